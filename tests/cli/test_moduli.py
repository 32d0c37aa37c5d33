#!/usr/bin/env python3
"""sonopack moduli against numpy: global strain in space, mechanisms, probes, and what it refuses.
Usage: test_moduli.py COMMAND SOURCE_DIR"""
import os
import subprocess
import sys
import tempfile

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's threads wait for each other where others are at work

import h5py
import numpy as np

from network_oracle import Network
from common import names_all

COMMAND, SOURCE = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
N200 = os.path.join(SOURCE, "packings/reference/packing_N200_p1e-4.txt")
N600 = os.path.join(SOURCE, "packings/reference/packing_N600_p1e-4.txt")
FOLDER = tempfile.TemporaryDirectory()
PROBES = ["sine:1", "sine:2", "sine:5", "lines:1", "lines:3"]


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, cwd=FOLDER.name, timeout=1200)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done.stdout, done.stderr


def rows(text):
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return lines[0], [dict(zip(lines[0], line)) for line in lines[1:]]


class Space:
    """The springs of a packing in an HDF5 file in the plainest way, in two and three dimensions."""

    def __init__(self, path, threshold=1e-4):
        with h5py.File(path) as file:
            x = file["/particles/grains/position/value"][0]
            radius = file["/particles/grains/radius"][:]
            self.box = file["/particles/grains/box/edges"][:]
            ends = file["/connectivity/contacts"][:]
            if "/sonopack/walls" in file:
                ends = np.concatenate([ends, file["/sonopack/walls/contacts"][:]])
            normal, overlap = file["/sonopack/contacts/normal"][:], file["/sonopack/contacts/overlap"][:]
            force = file["/sonopack/contacts/normal_force"][:]
            friction = float(np.asarray(file["/sonopack/friction"][()]))
            pressure = float(np.asarray(file["/sonopack/pressure"][()]))
        dim = x.shape[1]
        self.dim, rotations = dim, {2: 1, 3: 3}[dim] if friction > 0 else 0
        self.dof = dim + rotations
        need = 2 if friction > 0 else dim + 1
        carrying = [c for c in range(len(ends)) if force[c] > threshold * pressure]
        while True:
            count = np.zeros(len(radius), int)
            for c in carrying:
                for end in ends[c]:
                    if end >= 0:
                        count[end] += 1
            kept = [c for c in carrying if all(end < 0 or count[end] >= need for end in ends[c])]
            if len(kept) == len(carrying):
                break
            carrying = kept
        alive = np.flatnonzero(count >= need)
        row = {g: k for k, g in enumerate(alive)}
        self.x, self.r = x[alive], radius[alive]
        mass = 4 / 3 * np.pi * self.r**3
        self.mass = np.hstack([np.repeat(mass[:, None], dim, 1),
                               np.repeat(0.4 * (mass * self.r**2)[:, None], rotations, 1)]).ravel()
        size = self.dof * len(alive)
        self.b, self.k, self.gap = [], [], []
        for c in carrying:
            i, j = ends[c]
            n = normal[c]
            arm = radius[j] if j >= 0 else 0.0
            length = radius[i] + arm - overlap[c]
            kn = (np.sqrt(radius[i] * arm / (radius[i] + arm) * overlap[c]) if j >= 0
                  else 2 * np.sqrt(radius[i] * overlap[c]))
            # relative displacement at the contact as a matrix over all degrees of freedom
            d = np.zeros((dim, size))
            d[:, self.dof * row[i]:self.dof * row[i] + dim] -= np.eye(dim)
            if j >= 0:
                d[:, self.dof * row[j]:self.dof * row[j] + dim] += np.eye(dim)
            if rotations:
                axes = np.eye(3) if dim == 3 else np.array([[0.0, 0.0, 1.0]])
                full = np.zeros(3)
                full[:dim] = n
                turn = np.array([np.cross(axis, full)[:dim] for axis in axes]).T  # surface velocity per spin and arm
                for grain, lever in ((i, radius[i]), (j, arm)):
                    if grain >= 0:
                        at = self.dof * row[grain] + dim
                        d[:, at:at + rotations] -= lever * turn
            strains = [(0, 0), (1, 1), (0, 1)] if dim == 2 else [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
            affine = np.array([[length * n[of] if a == along else 0 for along, of in strains] for a in range(dim)])
            for projector, k in ((np.outer(n, n), kn), (np.eye(dim) - np.outer(n, n), kn if rotations else 0)):
                if k:  # nu = 0: k_t = k_n
                    self.b.append(projector @ d)
                    self.gap.append(projector @ affine)
                    self.k += [k] * dim
        self.b, self.gap, self.k = np.vstack(self.b), np.vstack(self.gap), np.array(self.k)
        self.matrix = self.b.T @ (self.k[:, None] * self.b)
        self.area = np.prod(self.box[:-1])
        root = np.sqrt(self.mass)
        squares, vectors = np.linalg.eigh(self.matrix / np.outer(root, root))
        kept = squares > 1e-11 * squares[-1]  # what no spring resists is left out, in the metric of the masses
        self.floppy = int(np.sum(~kept))
        self.squares, self.vectors = squares[kept], vectors[:, kept] / root[:, None]

    def respond(self, force):
        return self.vectors @ ((self.vectors.T @ force).T / self.squares).T

    def moduli(self):
        stretch = self.b @ self.respond(-self.b.T @ (self.k[:, None] * self.gap)) + self.gap
        return self.gap.T @ (self.k[:, None] * stretch) / (self.area * self.box[-1])


def apparent(matrix, respond, dof, centres, radii, box, density, probe, axis):
    """(B2) and (B3)."""
    kind, n = probe.split(":")
    n, height, area = int(n), box[-1], np.prod(box[:-1])
    y = centres[:, -1]
    if kind == "sine":
        force = np.zeros(len(matrix))
        force[axis::dof] = 4 / 3 * np.pi * radii**3 / density * np.sin(n * np.pi * y / height)
        return area * height**3 / (4 * n**2 * np.pi**2 * (0.5 * force @ respond(force)))
    lines = height * np.arange(n + 2) / (n + 1)
    on = np.any(np.abs(y[:, None] - lines[None, 1:-1]) <= radii[:, None], axis=1)
    held = np.zeros((len(radii), dof), bool)
    held[on, :len(box)] = True
    held = held.ravel()
    u = np.zeros(len(matrix))
    u[axis::dof] = np.where(on, np.interp(y, lines, np.resize([0.0, 1, 0, -1], n + 2)), 0)
    free = ~held
    u[free] = np.linalg.lstsq(matrix[np.ix_(free, free)], -matrix[np.ix_(free, held)] @ u[held], rcond=1e-12)[0]
    return 2 * height * (0.5 * u @ matrix @ u) / ((n + 1)**2 * area)


def test_plane():
    """Every probe on packings that came as text, within 1e-9; ratios are those to the global moduli."""
    words = [word for probe in PROBES for word in ("--probe", probe)]
    for path in (N200, N600):
        height = float(rows(run("statics", path)[0])[1][0]["Phi3s"])
        network = Network(path)
        _, (whole,) = rows(run("moduli", path)[0])
        header, found = rows(run("moduli", path, *words, "--probe", "global")[0])
        assert header == ["file", "p", "probe", "C22", "C33", "C22_ratio", "C33_ratio"]
        assert [row["probe"] for row in found] == PROBES + ["global"]
        assert found[-1]["C22"] == whole["C22"] and float(found[-1]["C33_ratio"]) == 1
        box, radii = np.array([network.width, network.height]), np.cbrt(network.mass[::3] * 3 / (4 * np.pi))
        for row in found[:-1]:
            for axis, name in ((1, "C22"), (0, "C33")):
                exact = apparent(network.matrix, lambda f: np.linalg.solve(network.matrix, f), 3, network.centre, radii,
                                 box, height, row["probe"], axis)
                assert np.isclose(float(row[name]), exact, rtol=1e-9, atol=0), (path, row, exact)
                assert np.isclose(float(row[name + "_ratio"]), exact / float(whole[name]), rtol=1e-9, atol=0)
    header, (one,) = rows(run("moduli", N200, "--probe", "lines:1")[0])
    assert header == ["file", "p", "C22", "C33", "C22_ratio", "C33_ratio"] and one["file"] == N200
    assert rows(run("moduli", N200, "--probe", "global")[0]) == rows(run("moduli", N200)[0])


def test_space():
    """Unseen packings in space and in the plane, with and without friction: global strain and probes within 1e-6 (of
    the largest: where a modulus is small the oracle's own rounding shows)."""
    for name, words in (("S", ["dimension=3", "grains=220", "width=5"]),
                        ("F", ["dimension=3", "grains=220", "width=5", "friction=0"]),
                        ("P", ["grains=150", "width=9", "pressure=1e-6"])):
        sets = [word for key in [*words, "tolerance=1e-9", "seed=7"] for word in ("--set", "packing." + key)]
        path = os.path.join(FOLDER.name, name + ".h5")
        run("pack", *sets, "-q", "-o", path)
        oracle = Space(path)
        density = float(rows(run("statics", path)[0])[1][0]["Phi3s"])
        c = oracle.moduli()
        text, notes = run("moduli", path)
        header, (row,) = rows(text)
        dim = oracle.dim
        if dim == 3:
            assert header == "file p C11 C12 C13 C22 C23 C33 C44 C55 C66 c_l c_t".split()
            places = {"C11": (0, 0), "C12": (0, 1), "C13": (0, 2), "C22": (1, 1), "C23": (1, 2), "C33": (2, 2),
                      "C44": (3, 3), "C55": (4, 4), "C66": (5, 5)}
        else:
            places = {"C11": (0, 0), "C12": (0, 1), "C22": (1, 1), "C33": (2, 2)}
        for column, place in places.items():
            if name == "F" and column in ("C44", "C55"):
                assert row[column] == "nan" and "sine:1" in notes
            else:
                assert np.isclose(float(row[column]), c[place], rtol=1e-6, atol=1e-12 * c[1, 1]), (name, column, c)
        along, shear = ("C33", "C55") if dim == 3 else ("C22", "C33")
        assert np.isclose(float(row["c_l"])**2 * density, float(row[along]), rtol=1e-12)
        text, notes = run("moduli", path, "--probe", "sine:1", "--probe", "lines:1")
        header, found = rows(text)
        assert header[3:] == [along, shear, along + "_ratio", shear + "_ratio"]
        assert (oracle.floppy > 0 and name != "F") == ("floppy" in notes), (oracle.floppy, notes)
        for probe in found:
            for axis, column in ((dim - 1, along), (0, shear)):
                if name == "F" and axis == 0 and probe["probe"] == "lines:1":
                    assert probe[column] == "nan"
                    continue
                if name == "F" and axis == 0:  # the cosine, less what accelerates the whole
                    force = np.zeros(len(oracle.matrix))
                    weight = oracle.mass[::oracle.dof]
                    push = weight / density * np.cos(np.pi * oracle.x[:, -1] / oracle.box[-1])
                    force[::oracle.dof] = push - weight * (push.sum() / weight.sum())
                    work = 0.5 * force @ oracle.respond(force)
                    exact = oracle.area * oracle.box[-1]**3 / (4 * np.pi**2 * work)
                    assert np.isclose(float(probe[column]), exact, rtol=1e-6), (probe, exact)
                    continue
                exact = apparent(oracle.matrix, oracle.respond, oracle.dof, oracle.x, oracle.r, oracle.box, density,
                                 probe["probe"], axis)
                assert np.isclose(float(probe[column]), exact, rtol=1e-6), (name, probe, column, exact)


def projected(oracle):
    """The moduli from the projection of the affine stretches onto those that no displacement makes: no inverse, and so
    no rounding that grows with the softness of a motion. Also the number of mechanisms."""
    root = np.sqrt(oracle.k)[:, None]
    left, values, _ = np.linalg.svd(root * oracle.b, full_matrices=False)
    kept = values > 1e-7 * values[0]
    stretch = root * oracle.gap
    made = left[:, kept].T @ stretch
    return (stretch.T @ stretch - made.T @ made) / (oracle.area * oracle.box[-1]), int(np.sum(~kept))


def test_floppy():
    """Packings at low pressure, with mechanisms: within 1e-9 of the largest modulus."""
    found = 0
    for dimension, grains, width, friction, pressure, seeds in ((3, 60, 4.9, 0.3, 1e-5, 2), (3, 60, 4.9, 1, 1e-7, 1),
                                                                (3, 70, 4.9, 0, 1e-6, 1), (2, 80, 8, 0.5, 1e-7, 1),
                                                                (2, 80, 8, 0, 1e-6, 1)):
        for seed in range(1, seeds + 1):
            keys = [f"dimension={dimension}", f"grains={grains}", f"width={width}", f"friction={friction}",
                    f"pressure={pressure}", f"seed={seed}", 'protocol="quick"']
            sets = [word for key in keys for word in ("--set", "packing." + key)]
            path = os.path.join(FOLDER.name, "floppy.h5")
            run("pack", *sets, "-q", "--force", "-o", path)
            c, mechanisms = projected(Space(path))
            _, (row,) = rows(run("moduli", path)[0])
            found += mechanisms
            names = (("C11", "C12", "C13"), ("C22", "C23"), ("C33",), ("C44",), ("C55",), ("C66",))
            for a in range(6 if dimension == 3 else 2):
                for name in names[a] if dimension == 3 else (("C11", "C12"), ("C22",))[a]:
                    b = a + int(name[2]) - int(name[1])
                    if row[name] != "nan":
                        assert abs(float(row[name]) - c[a, b]) < 1e-9 * c[1, 1], (keys, name, row[name], c)
    assert found > 10, found


def test_quick_spheres():
    """700 spheres with 21 mechanisms: one pivot is 1e-13 of another, and yet no modulus is in doubt."""
    path = os.path.join(FOLDER.name, "spheres.h5")
    keys = ("dimension=3", "width=6", "friction=0.3", "pressure=1e-5", "grains=700", "seed=1", 'protocol="quick"')
    run("pack", *[word for key in keys for word in ("--set", "packing." + key)], "-q", "-o", path)
    header, (row,) = rows(run("moduli", path)[0])
    assert all(float(row[name]) > 0 for name in header[2:]), row
    _, (probe,) = rows(run("moduli", path, "--probe", "lines:1")[0])
    assert 0.9 < float(probe["C33_ratio"]) < 1.3 and 0.9 < float(probe["C55_ratio"]) < 1.3, probe


def test_strained():
    """A strain of next to nothing gives the moduli with prestress."""
    header, (small, large) = rows(run("moduli", N600, "--strain", "1e-9", "--strain", "5e-5")[0])
    assert header == "file p strain C11 C12 C22 C33 sliding lost made residual".split()
    _, (springs,) = rows(run("moduli", N600, "--prestress")[0])
    for name in ("C11", "C22", "C33"):
        assert abs(float(small[name]) / float(springs[name]) - 1) < 1e-5, (name, small, springs)
    assert float(small["residual"]) < 1e-6 and int(small["sliding"]) <= int(large["sliding"])
    assert int(large["sliding"]) > 0 and float(large["C33"]) < float(small["C33"])


def test_nan():
    # thin: no bulk away from both walls, so no density; lines need none
    run("pack", "--set", "packing.grains=60", "--set", "packing.width=12", "--set", "packing.tolerance=1e-8", "-q",
        "-o", "thin.h5")
    out, said = run("moduli", "thin.h5")
    assert rows(out)[1][0]["c_l"] == "nan" and names_all(said, "--margin")
    assert rows(run("moduli", "thin.h5", "--probe", "lines:1")[0])[1]
    assert rows(run("moduli", "thin.h5", "--probe", "sine:1", "--margin", "1")[0])[1]
    # smooth walls: said, and the sine has a value
    run("pack", "--set", "packing.grains=150", "--set", "packing.width=9", "--set", "packing.friction=0", "--set",
        "packing.tolerance=1e-9", "-q", "-o", "smooth.h5")
    out, said = run("moduli", "smooth.h5")
    assert rows(out)[1][0]["C33"] == "nan" and names_all(said, "--probe sine:1")
    out, said = run("moduli", "smooth.h5", "--probe", "sine:1")
    assert float(rows(out)[1][0]["C33"]) > 0 and rows(out)[1][0]["C33_ratio"] == "nan" and names_all(said, "nan")
    # two dimensions and three name their moduli otherwise: the first file decides, the other is told
    run("pack", "--set", "packing.grains=60", "--set", "packing.width=5", "--set", "packing.dimension=3", "--set",
        "packing.tolerance=1e-8", "-q", "-o", "space.h5")
    out, said = run("moduli", "thin.h5", "space.h5", status=1)
    assert len(rows(out)[1]) == 1 and names_all(said, "")


def test_mechanisms():
    """What yields without a force is told, and no rounding is shown as a modulus: a ball that rolls between the walls,
    strong contacts alone (which touch both walls and hold nothing), a network that its prestress makes unstable."""
    run("pack", "--set", "packing.grains=2", "--set", "packing.width=4.8", "-q", "-o", "ball.h5")
    out, said = run("moduli", "ball.h5")
    row = rows(out)[1][0]
    assert float(row["C11"]) == float(row["C33"]) == 0 < float(row["C22"]), row
    assert names_all(said, "C33 0") and names_all(said, "C11 0") and "C22 is 0" not in said, said
    row = rows(run("moduli", "ball.h5", "--strain", "1e-6")[0])[1][0]  # its uniaxial strain along the walls is free
    assert abs(float(row["C11"])) < 1e-15 < float(row["C22"]), row
    assert "none is coarse enough" in run("moduli", "ball.h5", "--probe", "lines:1", status=1)[1]
    for words in ([], ["--probe", "lines:1"]):
        out, said = run("moduli", N600, "--threshold", "0.9", *words, status=1)
        assert out == "" and names_all(said, ""), (out, said)
    out, said = run("moduli", N200, "--threshold", "0.3", "--prestress", status=1)
    assert out == "" and names_all(said, ""), said
    run("pack", "--set", "packing.kind=chain", "--set", "packing.dimension=1", "--set", "packing.grains=9", "-q", "-o",
        "chain.h5")
    (linear,) = rows(run("moduli", "chain.h5")[0])[1]
    out, said = run("moduli", "chain.h5", "--strain", "1e-9")
    (row,) = rows(out)[1]
    assert row["C12"] == row["C11"] == row["C33"] == linear["C12"] == "nan" and names_all(said, "C22"), (row, said)
    assert np.isclose(float(row["C22"]), float(linear["C22"]), rtol=1e-6), (row, linear)  # strain over overlap: 1e-7


if __name__ == "__main__":
    test_plane()
    test_space()
    test_floppy()
    test_quick_spheres()
    test_strained()
    test_nan()
    test_mechanisms()
    print("ok")
