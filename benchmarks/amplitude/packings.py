#!/usr/bin/env python3
"""How the front changes with amplitude, pressure, friction, dimension and protocol: the numbers of docs/amplitude.md.

usage: packings.py COMMAND FOLDER [CASE...]

Makes packings in FOLDER (those that are there are kept), runs `sonopack amplitude --mean' on each set of them, and writes
FOLDER/CASE.tsv. All cases take some six minutes of processor time.
"""
import pathlib
import subprocess
import sys

COMMAND, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
QUICK = {"protocol": "quick"}
DISKS = {"grains": 600, "width": 24, **QUICK}
SPHERES = {"dimension": 3, "grains": 500, "width": 6, **QUICK}
QUIET = [1e-3, 1e-2, 0.1, 0.3, 1]
# up to amplitudes that carry grains by a fraction of their size
LOUD = {1e-2: QUIET, 1e-3: QUIET + [3], 1e-4: QUIET + [3, 10], 1e-6: QUIET + [3, 10, 30, 100]}
PRESSURES = sorted(LOUD, reverse=True)

SOME = [1e-3, 0.1, 1, 10]

# name: keys of the packings, seeds, pressures, frictions, amplitudes or None for LOUD
CASES = {
    "disks": (DISKS, range(1, 11), PRESSURES, (0, 0.5), None),
    "spheres": (SPHERES, range(1, 9), [1e-3, 1e-4, 1e-6], (0, 0.5), None),
    # is it the protocol, the box, the number of grains, or chance?
    "default": ({**DISKS, "protocol": "default"}, range(1, 11), [1e-4], (0.5,), SOME),
    "narrow": ({**DISKS, "grains": 300, "width": 12}, range(1, 11), [1e-4], (0.5,), SOME),
    "high": ({**DISKS, "grains": 600, "width": 12}, range(1, 11), [1e-4], (0.5,), SOME),
    "others": (DISKS, range(101, 111), [1e-4], (0.5,), SOME),
}


def packing(case, keys, seed, pressure, friction):
    path = FOLDER / f"{case}_{pressure:g}_{friction:g}_{seed}.h5"
    if not path.exists():
        values = {**keys, "seed": seed, "pressure": pressure, "friction": friction}
        sets = [word for key, value in values.items() for word in ("--set", f"packing.{key}={value}")]
        subprocess.run([COMMAND, "pack", "-q", *sets, "-o", path], check=True, stdout=subprocess.DEVNULL)
    return path


def table(paths, amplitudes):
    done = subprocess.run([COMMAND, "amplitude", *paths, "--mean", "--amplitudes", ",".join(map(str, amplitudes))],
                          capture_output=True, text=True)
    sys.stderr.write(done.stderr)  # packings that fail, because grains fly out of reach, do not count
    text = done.stdout.splitlines()
    comments = [line for line in text if line.startswith("#")]
    rows = [line for line in text if not line.startswith("#")]
    return comments, rows[0], rows[1:]


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    for case in sys.argv[3:] or CASES:
        keys, seeds, pressures, frictions, amplitudes = CASES[case]
        rows = []
        for friction in frictions:
            for pressure in pressures:
                paths = [packing(case, keys, seed, pressure, friction) for seed in seeds]
                comments, header, new = table(paths, amplitudes or LOUD[pressure])
                rows += new
                (FOLDER / f"{case}.tsv").write_text("\n".join(comments + [header] + rows) + "\n")
                print(case, friction, pressure, flush=True)


if __name__ == "__main__":
    main()
