#!/usr/bin/env python3
"""Second harmonics of bursts in packings: numbers of docs/amplitude.md.

usage: harmonics.py COMMAND FOLDER

Packings of 600 disks in boxes 12 wide, at frequencies that go as p^(1/6) as those of the contacts do. For each plane the
mean of F2/F1^2 over the packings and its standard error; then what a wave of beta = M/(3 p) would have.
"""
import pathlib
import subprocess
import sys

import numpy as np

COMMAND, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
SAMPLES, PLANES = range(1, 9), 6


def packing(seed, pressure, friction):
    path = FOLDER / f"tall_{pressure:g}_{friction:g}_{seed}.h5"
    if not path.exists():
        values = {"grains": 600, "width": 12, "protocol": "quick", "seed": seed, "pressure": pressure, "friction": friction}
        sets = [word for key, value in values.items() for word in ("--set", f"packing.{key}={value}")]
        subprocess.run([COMMAND, "pack", "-q", *sets, "-o", path], check=True, stdout=subprocess.DEVNULL)
    return path


def table(*words):
    text = subprocess.run([COMMAND, *map(str, words)], check=True, capture_output=True, text=True).stdout
    rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}


def mean(values):
    values = np.asarray(values, float)
    return values.mean(0), values.std(0, ddof=1) / np.sqrt(len(values))


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    for pressure, friction, amplitude in ((1e-4, 0, 0.02), (1e-4, 0, 0.1), (1e-6, 0, 0.02), (1e-4, 0.5, 0.02), (1e-4, 0.5, 0.1)):
        omega = 0.1 * (pressure / 1e-4) ** (1 / 6)
        heights, ratios, firsts, moved = [], [], [], []
        for seed in SAMPLES:
            found = table("amplitude", packing(seed, pressure, friction), "--amplitudes", amplitude, "--omega", omega,
                          "--cycles", 3, "--planes", PLANES)
            heights.append(np.array(found["y"], float))
            ratios.append(np.array(found["ratio"], float))
            firsts.append(np.array(found["F1"], float))
            moved.append(np.array(found["F0"], float) / firsts[-1] ** 2)
        y, (ratio, error), (first, spread), (zero, zero_error) = np.mean(heights, 0), mean(ratios), mean(firsts), mean(moved)
        print(f"p = {pressure:g}, mu = {friction:g}, A = {amplitude:g}, omega = {omega:.4g}")
        for k in range(PLANES):
            print(f"   {y[k]:5.1f}  F1 {first[k]:.4g} +- {spread[k]:.1g}  F2/F1^2 {ratio[k]:.3g} +- {error[k]:.2g}  "
                  f"F0/F1^2 {zero[k]:.3g} +- {zero_error[k]:.2g}", flush=True)


if __name__ == "__main__":
    main()
