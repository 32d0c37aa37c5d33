"""Damaged files of other programs: whatever the damage, convert ends with a reason, or reads numbers that are there.

usage: test_import_files.py COMMAND SOURCE_DIR
"""
import os
import random
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
SAMPLES = os.path.join(SOURCE, "tests", "foreign", "samples")
SEED = int(os.environ.get("SONOPACK_FUZZ_SEED", "20260718"))
ROUNDS = int(os.environ.get("SONOPACK_FUZZ_ROUNDS", "40"))
SOME = [b"nan", b"-1", b"1e300", b"", b",", b"\n", b"\r\n", b"\0", b"99999999999999999999", b"#", b"ITEM: ATOMS id", b"x",
        b"0x1p3", b"\xff\xfe", b"\t", b"1e-320", b"=", b"\"", b"3 0 0 0 0 1 1 1\n"]
CASES = [
    ("lammps/layer_grains.dump", ["--contacts", "lammps/layer_contacts.dump", "--types", "1"]),
    ("lammps/layer_contacts.dump", None),
    ("lammps/layer.data", ["--contacts", "overlap", "--types", "1"]),
    ("lammps/sheared_grains.dump", ["--contacts", "lammps/sheared_contacts.dump"]),
    ("lammps/sheared.data", ["--contacts", "overlap"]),
    ("lammps/box_grains.dump", ["--contacts", "lammps/box_contacts.dump"]),
    ("yade/packing_id.txt", ["--set", "width=4", "--set", "depth=4", "--set", "bottom=5", "--set", "top=8.92966"]),
    ("mercury/layer.data", ["--contacts", "mercury/layer.fstat"]),
    ("xyz/layer.xyz", ["--contacts", "csv/contacts.csv", "--walls", "csv/walls.csv"]),
    ("photoelastic/particles.csv", ["--contacts", "photoelastic/contacts.csv", "--material", "E=4e6,nu=0.5,rho=1060",
                                    "--length-unit", "5e-5", "--kn", "5e4", "--walls", "balance"]),
]


def damage(data, rng):
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = rng.randrange(len(data) + 1)
        kind = rng.randrange(4)
        if kind == 0:
            del data[at:]
        elif kind == 1:
            del data[at:at + rng.choice((1, 3, 40, 400))]
        elif kind == 2:
            data[at:at + rng.choice((0, 1, 5))] = rng.choice(SOME)
        else:
            data[at:at] = data[max(0, at - rng.choice((10, 200))):at]
        if not data:
            break
    return bytes(data)


def main():
    print("seed", SEED)
    rng = random.Random(SEED)
    faults = 0
    with tempfile.TemporaryDirectory(prefix="sonopack-fuzz-") as folder:
        for name, words in CASES:
            original = open(os.path.join(SAMPLES, name), "rb").read()
            for k in range(ROUNDS):
                broken = os.path.join(folder, "broken")
                out = os.path.join(folder, "out.h5")
                with open(broken, "wb") as f:
                    f.write(damage(original, rng))
                if words is None:  # broken contacts of sound grains
                    line = [os.path.join(SAMPLES, "lammps/layer_grains.dump"), out, "--contacts", broken, "--types", "1"]
                else:
                    line = [broken, out] + [os.path.join(SAMPLES, w) if "/" in w else w for w in words]
                result = subprocess.run([COMMAND, "convert", *line, "--set", "friction=0.5"], capture_output=True,
                                        timeout=600)
                good = result.returncode in (0, 1, 2) and os.path.exists(out) == (result.returncode == 0)
                if not good or (result.returncode and not result.stderr.startswith(b"sonopack: ")):
                    faults += 1
                    print(f"FAILED: {name}, round {k}: status {result.returncode}, {result.stderr[-500:]}")
                    os.rename(broken, os.path.join(tempfile.gettempdir(), f"sonopack-fuzz-import-{faults}"))
                if os.path.exists(out):
                    os.remove(out)
    print(f"{faults} faults")
    sys.exit(1 if faults else 0)


main()
