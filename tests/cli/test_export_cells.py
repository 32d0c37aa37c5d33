"""sonopack convert to the forms of other programs, for periodic cells, tilted ones, and boxes with walls on all sides:
what the files say, and that they read back as the same packing."""
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np
import scipy.io

from cells import box_of_disks, lattice, matrix_of, write_packing
from foreign import Vtp, extended_xyz

COMMAND = sys.argv[1]
FOLDER = tempfile.mkdtemp(prefix="sonopack-export-cells-")
CELLS = {"square": lattice(2), "tilted": lattice(2, 0.3), "sheared": lattice(3, 0.2, cells=4), "box": box_of_disks()}
failures = []


def expect(condition, what):
    if not np.all(condition):
        failures.append(what)
        print("FAILED:", what)


def path(name):
    return os.path.join(FOLDER, name)


def convert(*words):
    result = subprocess.run([COMMAND, "convert", *words, "--force"], capture_output=True, text=True, timeout=600, cwd=FOLDER)
    expect(result.returncode == 0, f"{words}: {result.stderr}")
    return result.stderr


def same(name, p, what, tolerance=1e-12):
    with h5py.File(path(name)) as f:
        walls = f["sonopack/walls/contacts"][()] if "sonopack/walls" in f else np.zeros((0, 2), "i4")
        pairs = np.concatenate([f["connectivity/contacts"][()], walls])
        expect(f["sonopack/cell"][()].decode() == p["cell"], f"{what}: cell")
        edges = f["particles/grains/box/edges"][()]
        expect(np.allclose(edges if edges.ndim == 2 else np.diag(edges), matrix_of(p["box"], p["tilt"]), rtol=1e-15), what)
        expect(np.array_equal(pairs, p["pairs"]), f"{what}: contacts")
        expect(np.allclose(f["particles/grains/position/value"][0], p["x"], atol=tolerance), f"{what}: positions")
        if np.array_equal(pairs, p["pairs"]):
            expect(np.allclose(f["sonopack/contacts/overlap"][()], p["overlap"], atol=tolerance), f"{what}: overlaps")


def test_lammps():
    for name, p in CELLS.items():
        convert(name + ".h5", "o.data")
        text = open(path("o.data")).read()
        tilted = np.any(p["tilt"])
        expect(("xy xz yz" in text) == tilted and f"cell={p['cell']}" in text.split("\n")[0], f"{name} data: head")
        if tilted:
            line = next(line for line in text.split("\n") if line.endswith("xy xz yz"))
            expect([float(v) for v in line.split()[:3]] == list(p["tilt"]), f"{name} data: tilt")
        convert("o.data", "b.h5", "--set", "digits=exact")
        same("b.h5", p, f"{name} data again")
        said = convert(name + ".h5", "o.dump")
        expect("--set friction=" in said and ("--set wall=" in said) == (p["cell"] != "periodic"), f"{name} dump: {said}")
        lines = open(path("o.dump")).read().split("\n")
        words = lines[4].split()[3:]
        periodic = "ff" if name == "box" else "pp"
        expect(words[-3:-1] == [periodic] * 2 and (len(words) == 6) == tilted, f"{name} dump: {lines[4]}")
        if tilted:
            xy, xz, yz = p["tilt"]
            bounds = np.array([[float(v) for v in line.split()] for line in lines[5:8]])
            expect(bounds[:, 2] == p["tilt"], f"{name} dump: tilts")
            corners = np.array([a * np.array([p["box"][0], 0]) + b * np.array([xy, p["box"][1]]) + c * np.array([xz, yz])
                                for a in (0, 1) for b in (0, 1) for c in (0, 1)])
            expect(np.allclose(bounds[:2, 0], corners.min(axis=0)) & np.allclose(bounds[:2, 1], corners.max(axis=0)),
                   f"{name} dump: bounds are around the corners")
        convert("o.dump", "b.h5", "--set", "digits=exact", "--set", "friction=0", "--set", "wall=rigid")
        same("b.h5", p, f"{name} dump again")


def test_xyz():
    for name, p in CELLS.items():
        convert(name + ".h5", "o.xyz")
        head, columns = extended_xyz(path("o.xyz"))
        lattice_vectors = np.array([float(v) for v in head["Lattice"].split()]).reshape(3, 3)
        dim = p["dim"]
        expect(lattice_vectors[:dim, :dim] == matrix_of(p["box"], p["tilt"]), f"{name} xyz: lattice")
        flag = "F" if name == "box" else "T"
        expect(head["pbc"].split() == [flag] * dim + ["F"] * (3 - dim) and head["cell"] == p["cell"], f"{name} xyz: pbc")
        convert("o.xyz", "b.h5", "--set", "digits=exact")
        same("b.h5", p, f"{name} xyz again")


def test_vtp():
    """Every contact is a line as long as the distance of its grains, across the faces of the cell too."""
    for name, p in CELLS.items():
        convert(name + ".h5", "o.vtp")
        grains, lines, walls = Vtp(path("o.vtp")), Vtp(path("o-contacts.vtp")), Vtp(path("o-walls.vtp"))
        expect(grains.field["cell"] == {"periodic": 1, "box": 2}[p["cell"]], f"{name} vtp: cell")
        expect(grains.field["tilt"] == p["tilt"], f"{name} vtp: tilt")
        ends = lines.points.reshape(-1, 2, 3)
        inner = p["pairs"][:, 1] >= 0
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        expect(np.allclose(length, 1 - p["overlap"][inner]), f"{name} vtp: lengths")
        x = np.zeros((len(p["x"]), 3))
        x[:, :p["dim"]] = p["x"]
        step = (ends[:, 1] - x[p["pairs"][inner, 1]])[:, :p["dim"]] @ np.linalg.inv(matrix_of(p["box"], p["tilt"]))
        expect(np.allclose(step, np.round(step), atol=1e-9), f"{name} vtp: ends are images of the grains")
        expect(np.any(np.round(step) != 0, axis=1) == (lines.cell["periodic"] != 0), f"{name} vtp: which cross a face")
        expect(np.array_equal(walls.cell["wall"], p["pairs"][~inner, 1]), f"{name} vtp: walls")


def test_mat_and_gravity():
    p = {**CELLS["box"], "gravity": 1e-7}
    write_packing(path("g.h5"), p)
    convert("g.h5", "o.mat")
    mat = scipy.io.loadmat(path("o.mat"), squeeze_me=True)
    expect(mat["cell"] == "box" and mat["gravity"] == 1e-7, "mat: cell, gravity")
    expect(np.array_equal(mat["contacts"]["j"][()], p["pairs"][:, 1]), "mat: walls")
    convert("g.h5", "o.xyz")
    expect(float(extended_xyz(path("o.xyz"))[0]["gravity"]) == 1e-7, "xyz: gravity")
    convert("g.h5", "o.vtp")
    expect(Vtp(path("o.vtp")).field["gravity"] == 1e-7, "vtp: gravity")
    material = ("--units", "si", "--material", "E=1e9,nu=0,rho=2000,d=2e-3")
    convert("g.h5", "s.vtp", *material)
    expect(np.allclose(Vtp(path("s.vtp")).field["gravity"], 1e-7 * 1e9 / (2000 * 2e-3)), "gravity in m/s^2")
    convert("tilted.h5", "s.data", *material)
    line = next(line for line in open(path("s.data")) if "xy xz yz" in line)
    expect(np.isclose(float(line.split()[0]), 2e-3 * CELLS["tilted"]["tilt"][0]), "tilt in m")


for case, packing in CELLS.items():
    write_packing(path(case + ".h5"), packing)
for test in [value for name, value in list(globals().items()) if name.startswith("test_")]:
    before = len(failures)
    test()
    print("ok" if len(failures) == before else "FAILED", test.__name__)
print(f"{len(failures)} failures" if failures else "export of cells: all fine")
sys.exit(1 if failures else 0)
