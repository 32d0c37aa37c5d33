"""LAMMPS reads the data files of `sonopack convert`, and finds our normal forces to 1e-10 by the deck lammps_forces.in.

usage: test_export_lammps.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
LAMMPS = shutil.which("lmp")
if not LAMMPS:
    print("no lmp")
    sys.exit(77)

import h5py
import numpy as np

sys.path.insert(0, str(SOURCE / "tests" / "cli"))
from cells import box_of_disks, lattice, write_packing  # noqa: E402

DECK = SOURCE / "share/sonopack/lammps_forces.in"
CASES = [("2D, rigid walls", "y", "2", {"grains": 200, "width": 12}, "piston"),
         ("3D, box", "z", "2", {"dimension": 3, "grains": 300, "cell": "box", "protocol": "quick"}, "box"),
         ("3D, rigid walls", "z", "2", {"dimension": 3, "grains": 200, "width": 6, "depth": 5}, "piston"),
         ("3D, nu = 0.3", "z", "2", {"dimension": 3, "grains": 150, "width": 5, "depth": 5, "poisson": 0.3}, "piston"),
         ("chain, walls like grains", "x", "0.70710678118654757", {"kind": '"chain"', "dimension": 1, "grains": 10}, "piston")]


def run(folder, *words):
    result = subprocess.run([str(word) for word in words], cwd=folder, text=True, capture_output=True, timeout=1200)
    assert result.returncode == 0, f"{words}: {result.stdout[-2000:]} {result.stderr}"


def rows(path):
    return np.array([line.split() for line in path.read_text().split("\n")[9:-1]], float)


def compare_cell(name, packing, folder):
    write_packing(folder / "P.h5", packing)
    compare(name, "y" if packing["dim"] == 2 else "z", "2", None, packing["cell"], folder)


def compare(name, up, modulus, keys, cell, folder):
    words = [word for key, value in (keys or {}).items() for word in ("--set", f"packing.{key}={value}")]
    if keys is not None:
        run(folder, COMMAND, "pack", "--quiet", *words, "-o", "P.h5")
    run(folder, COMMAND, "convert", "P.h5", "P.data")
    run(folder, LAMMPS, "-nocite", "-log", "none", "-in", DECK, "-var", "file", "P.data", "-var", "up", up, "-var",
        "modulus", modulus, "-var", "cell", cell)
    with h5py.File(folder / "P.h5") as f:
        pairs = f["connectivity/contacts"][:]
        walls = f["sonopack/walls/contacts"][:] if "sonopack/walls" in f else np.zeros((0, 2), int)
        fn, n = f["sonopack/contacts/normal_force"][:], f["sonopack/contacts/normal"][:]
        x, dim = f["particles/grains/position/value"][0], int(f["sonopack/dimension"][()])
        tilted = f["particles/grains/box/edges"].ndim == 2
    theirs = {(int(min(a, b)) - 1, int(max(a, b)) - 1): force for _, a, b, force in rows(folder / "pairs.dump")}
    assert set(theirs) == set(map(tuple, pairs)), f"{name}: other contacts"
    error = max(abs(theirs[tuple(pair)] - force) for pair, force in zip(pairs, fn)) / fn.mean()
    net = np.zeros((len(x), dim))
    for (i, j), force, normal in zip(np.concatenate([pairs, walls]), fn, n):
        net[i] -= force * normal
        if j >= 0:
            net[j] += force * normal
    grains = rows(folder / "grains.dump")
    sums = np.abs(grains[:, 5:5 + dim] - net).max() / fn.mean()
    print(f"{name}: {len(pairs)} pairs, {len(walls)} at walls; forces differ by {error:.1e}, sums by {sums:.1e} of the mean")
    turned = np.abs(grains[:, 1:1 + dim] - x).max()  # LAMMPS takes fractions of tilted cells and back
    assert turned <= (1e-14 if tilted else 0), f"{name}: positions differ by {turned} from those of the packing"
    assert error < 1e-10 and sums < 1e-10, name


def main():
    for case in CASES:
        with tempfile.TemporaryDirectory(prefix="sonopack-lammps-") as name:
            compare(*case, pathlib.Path(name))
    for name, packing in (("2D, tilted", lattice(2, 0.3)), ("3D, sheared", lattice(3, 0.2, cells=4)),
                          ("2D, box", box_of_disks())):
        with tempfile.TemporaryDirectory(prefix="sonopack-lammps-") as scratch:
            compare_cell(name, packing, pathlib.Path(scratch))


main()
