"""sonopack convert and signal: every number in the files for other programs is that of the packing, and what is refused.
The readers are plain ones (foreign.py, and scipy for MAT-files); tests/foreign has the programs themselves.

usage: test_export.py COMMAND SOURCE_DIR
"""
import os
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import h5py
import numpy as np
import scipy.io

from common import names_all
from foreign import Vtp, extended_xyz, lammps_data, lammps_dump, sac

COMMAND = sys.argv[1]
FOLDER = tempfile.mkdtemp(prefix="sonopack-export-")
failures = []


def expect(condition, what):
    if not np.all(condition):
        failures.append(what)
        print("FAILED:", what)


def run(*words, status=0, says=""):
    result = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, timeout=1200, cwd=FOLDER)
    what = f"{' '.join(map(str, words))}: status {result.returncode}, {result.stderr}"
    expect(result.returncode == status, what)
    expect(not says or names_all(result.stderr, says), f"'{says}' in: {what}")
    return result


def path(name):
    return os.path.join(FOLDER, name)


def make(name, **keys):
    words = [word for key, value in keys.items() for word in ("--set", f"packing.{key}={value}")]
    run("pack", "--quiet", *words, "-o", name)


make("2.h5", grains=60, width=8)
make("3.h5", dimension=3, grains=120, width=5, depth=5)
make("1.h5", kind='"chain"', dimension=1, grains=8)
KEPT = ("1.h5", "2.h5", "3.h5")


class Packing:
    """A packing as its HDF5 file has it."""

    def __init__(self, name):
        with h5py.File(path(name)) as f:
            self.dim = int(f["sonopack/dimension"][()])
            self.x = np.zeros((len(f["particles/grains/radius"]), 3))
            self.x[:, :self.dim] = f["particles/grains/position/value"][0]
            self.r, self.mass = f["particles/grains/radius"][:], f["particles/grains/mass"][:]
            self.rattler, self.box = f["sonopack/rattler"][:], f["particles/grains/box/edges"][:]
            pairs = f["connectivity/contacts"][:]
            walls = f["sonopack/walls/contacts"][:] if "sonopack/walls" in f else np.zeros((0, 2), int)
            self.pairs, self.contacts = len(pairs), np.concatenate([pairs, walls])
            vector = lambda name: np.pad(f["sonopack/contacts/" + name][:], ((0, 0), (0, 3 - self.dim)))
            self.n, self.ft = vector("normal"), vector("tangential_force")
            self.overlap, self.fn = f["sonopack/contacts/overlap"][:], f["sonopack/contacts/normal_force"][:]
            self.pressure, self.friction = float(f["sonopack/pressure"][()]), float(f["sonopack/friction"][()])
            self.poisson, self.wall = float(f["sonopack/poisson"][()]), f["sonopack/wall"][()].decode()
        self.force = self.ft - self.fn[:, None] * self.n
        i, j = self.contacts.T
        self.carrying = (self.fn > 1e-4 * self.pressure) & (self.rattler[i] == 0) & ((j < 0) | (self.rattler[j] == 0))

    def stiffness(self):
        i, j = self.contacts.T
        r1, r2 = self.r[i], np.where(j < 0, self.r[i], self.r[j])
        e = 0.5 * np.sqrt(r1 * r2 / (r1 + r2))
        if self.wall == "rigid":
            e = np.where(j < 0, np.sqrt(r1), e)
        return 2 * e * np.sqrt(self.overlap)


def near(a, b, within=1e-13):
    return np.abs(np.asarray(a) - b) <= within * np.max(np.abs(b), initial=1e-300)


# ---- packings --------------------------------------------------------------------------------------------------------
def check_grains(p, vtp, what):
    expect((vtp.points == p.x) & True, what + "points")
    expect(vtp.cells[:, 0] == np.arange(len(p.r)), what + "a vertex for each")
    expect(vtp.point["id"] == np.arange(len(p.r)), what + "id")
    expect(vtp.point["radius"] == p.r, what + "radius")
    expect(vtp.point["mass"] == p.mass, what + "mass")
    expect(vtp.point["rattler"] == p.rattler, what + "rattler")
    count = np.zeros(len(p.r), int)
    net, stress = np.zeros((len(p.r), 3)), np.zeros((len(p.r), 3, 3))
    for (i, j), n, force, carrying in zip(p.contacts, p.n, p.force, p.carrying):
        for grain, sign in ((i, 1), (j, -1)):
            if grain >= 0:
                count[grain] += carrying
                net[grain] += sign * force
                stress[grain] -= p.r[grain] * np.outer(n, force) / (4 / 3 * np.pi * p.r[grain]**3)
    expect(vtp.point["contacts"] == count, what + "contacts")
    expect(np.abs(vtp.point["net_force"] - net) < 1e-14 * np.max(p.fn), what + "net force")
    expect(near(vtp.point["stress"].reshape(-1, 3, 3), stress), what + "stress")
    expect(near(vtp.point["pressure"], np.trace(stress, axis1=1, axis2=2) / p.dim), what + "pressure")
    expect(np.mean(vtp.point["pressure"]) > 0, what + "positive in compression")


def check_lines(p, vtp, first, last, what):
    i, j = p.contacts[first:last].T
    part = slice(first, last)
    expect(vtp.cell["id1"] == i, what + "id1")
    expect(vtp.cell["wall" if first else "id2"] == j, what + "partner")
    expect(vtp.cell["normal_force"] == p.fn[part], what + "normal force")
    expect(vtp.cell["overlap"] == p.overlap[part], what + "overlap")
    expect(vtp.cell["normal"] == p.n[part], what + "normal")
    expect(vtp.cell["tangential_force"] == p.ft[part], what + "tangential force")
    expect(vtp.cell["force"] == p.force[part], what + "force on id1")
    expect(vtp.cell["carrying"] == p.carrying[part], what + "carrying")
    expect(near(vtp.cell["kn"], p.stiffness()[part]), what + "kn")
    eta = (1 - p.poisson) / (1 - p.poisson / 2) if p.friction > 0 and p.dim > 1 else 0
    expect(near(vtp.cell["kt"], eta * p.stiffness()[part]), what + "kt")
    ends = vtp.points.reshape(-1, 2, 3)
    branch = ends[:, 1] - ends[:, 0]
    expect(ends[:, 0] == p.x[i], what + "begins at the centre of id1")
    expect((vtp.cells == np.arange(len(vtp.points)).reshape(-1, 2)), what + "two points a line")
    length = p.r[i] - p.overlap[part] + (0 if first else p.r[j])
    expect(near(np.linalg.norm(branch, axis=1), length), what + "length")
    expect(np.abs(branch - length[:, None] * p.n[part]) < 1e-11, what + "along the normal")
    if not first:
        images = (ends[:, 1] - p.x[j])[:, :p.dim - 1] / p.box[:p.dim - 1]
        expect(np.abs(images - np.rint(images)) < 1e-15, what + "ends at an image of id2")
        crosses = (np.rint(images) != 0).any(axis=1) if p.dim > 1 else np.zeros(len(i), bool)
        expect(vtp.cell["periodic"] == crosses, what + "crosses a periodic edge")
        expect(p.dim == 1 or crosses.any(), what + "some contacts cross an edge")


def test_vtp():
    for name in KEPT:
        p, what = Packing(name), name + " as VTK: "
        run("convert", name, "o.vtp")
        grains = Vtp(path("o.vtp"))
        check_grains(p, grains, what)
        expect(grains.field["box"][0, :p.dim] == p.box, what + "box")
        expect(grains.field["pressure"] == p.pressure, what + "pressure of the packing")
        check_lines(p, Vtp(path("o-contacts.vtp")), 0, p.pairs, what + "contacts: ")
        check_lines(p, Vtp(path("o-walls.vtp")), p.pairs, len(p.contacts), what + "walls: ")
        blocks = xml.etree.ElementTree.parse(path("o.vtm")).getroot().find("vtkMultiBlockDataSet").findall("DataSet")
        expect([b.get("file") for b in blocks] == ["o.vtp", "o-contacts.vtp"], what + "blocks")
        for file in ("o.vtp", "o-contacts.vtp", "o-walls.vtp", "o.vtm"):
            os.remove(path(file))


def test_lammps():
    for name in KEPT:
        p = Packing(name)
        run("convert", name, "o.data")
        run("convert", name, "o.dump")
        title, box, atoms = lammps_data(path("o.data"))
        expect(atoms[:, 0] == np.arange(len(p.r)) + 1, name + " data: ids from 1")
        expect((atoms[:, 2] / 2 == p.r) & (atoms[:, 3] == 1), name + " data: every bit of the radii; density 1")
        expect(atoms[:, 4:] == p.x, name + " data: every bit of the centres")
        expect((box[:p.dim, 0] == 0) & (box[:p.dim, 1] == p.box), name + " data: box")
        words = dict(word.split("=") for word in title.split() if "=" in word)
        expect(float(words["pressure"]) == p.pressure and words["wall"] == p.wall and len(title) < 250, title)
        again, boundaries, columns = lammps_dump(path("o.dump"))
        expect(again == box, name + " dump: box")
        up = p.dim - 1
        expect(boundaries == ["ff" if axis == up else "pp" for axis in range(3)], name + " dump: boundaries")
        expect(np.array([columns[axis] for axis in "xyz"]).T == p.x, name + " dump: centres")
        expect((columns["radius"] == p.r) & (columns["mass"] == p.mass), name + " dump: radii and masses")
        expect(columns["rattler"] == p.rattler, name + " dump: rattlers")
        for file in ("o.data", "o.dump"):
            os.remove(path(file))


def test_xyz():
    for name in KEPT:
        p = Packing(name)
        run("convert", name, "o.xyz")
        head, columns = extended_xyz(path("o.xyz"))
        lattice = np.array(head["Lattice"].split(), float).reshape(3, 3)
        expect(np.diag(lattice)[:p.dim] == p.box, name + " xyz: lattice")
        expect(np.count_nonzero(lattice) == 3, name + " xyz: a cuboid")
        expect(head["pbc"].split() == ["T" if axis < p.dim - 1 else "F" for axis in range(3)], name + " xyz: pbc")
        expect((columns["pos"] == p.x) & True, name + " xyz: centres")
        expect((columns["radius"][:, 0] == p.r) & (columns["mass"][:, 0] == p.mass), name + " xyz: radii, masses")
        expect(columns["species"] == "X", name + " xyz: species")
        expect(int(head["dimension"]) == p.dim and float(head["friction"]) == p.friction, name + " xyz: keys")
        os.remove(path("o.xyz"))


def test_csv_and_mat():
    for name in KEPT:
        p = Packing(name)
        run("convert", name, "o.csv")
        run("convert", name, "o.mat")
        grains = np.genfromtxt(path("o.csv"), delimiter=",", names=True)
        contacts = np.genfromtxt(path("o-contacts.csv"), delimiter=",", names=True)
        mat = scipy.io.loadmat(path("o.mat"), squeeze_me=True)
        for kind, g, c in (("csv", grains, contacts), ("mat", mat["grains"][()], mat["contacts"][()])):
            what = f"{name} {kind}: "
            expect(np.array([g[axis] for axis in "xyz"[:p.dim]]).T == p.x[:, :p.dim], what + "centres")
            expect((g["radius"] == p.r) & (g["mass"] == p.mass) & (g["rattler"] == p.rattler), what + "grains")
            expect(np.array([c["i"], c["j"]]).T == p.contacts, what + "contacts")
            expect((c["Fn"] == p.fn) & (c["overlap"] == p.overlap) & (c["carrying"] == p.carrying), what + "forces")
            expect(np.array([c["n" + axis] for axis in "xyz"[:p.dim]]).T == p.n[:, :p.dim], what + "normals")
            expect(np.array([c["Ft" + axis] for axis in "xyz"[:p.dim]]).T == p.ft[:, :p.dim], what + "tangential forces")
        expect(mat["pressure"] == p.pressure and mat["wall"] == p.wall and mat["dimension"] == p.dim, name + " mat")
        expect(np.atleast_1d(mat["box"]) == p.box, name + " mat: box")
        expect(mat["grains_units"]["mass"][()] == "rho d^3", name + " mat: units")
        for file in ("o.csv", "o-contacts.csv", "o-packing.csv", "o.mat"):
            os.remove(path(file))


def test_own_law():
    """Stiffnesses and masses of their own go along."""
    with open(path("g.tsv"), "w") as f:
        f.write("# width = 8\n# height = 2\n# pressure = 1e-4\n# friction = 0.5\nid x y radius mass inertia\n"
                "0 1 0.5 0.5 0.7 0.1\n1 1 1.49 0.5 0.9 0.2\n")
    with open(path("c.tsv"), "w") as f:
        f.write("i j nx ny overlap Fn Ft kn kt\n0 1 0 1 0.01 1e-4 0 0.25 0.125\n0 bottom 0 -1 0.001 1e-4 0 0.5 0\n")
    run("convert", "g.tsv", "own.h5", "--contact-table", "c.tsv")
    run("convert", "own.h5", "o.vtp")
    expect(Vtp(path("o.vtp")).point["mass"] == [0.7, 0.9], "masses")
    bulk, walls = Vtp(path("o-contacts.vtp")).cell, Vtp(path("o-walls.vtp")).cell
    expect([bulk["kn"][0], bulk["kt"][0], walls["kn"][0], walls["kt"][0]] == [0.25, 0.125, 0.5, 0], "stiffnesses")
    run("convert", "own.h5", "o.data")
    atoms = lammps_data(path("o.data"))[2]
    expect(near(atoms[:, 3] * np.pi / 6, [0.7, 0.9]), "density of the mass")


def test_no_contacts():
    """A packing without walls, and one without any contact, are written all the same."""
    with open(path("g.tsv"), "w") as f:
        f.write("# width = 8\n# height = 2\n# pressure = 1e-4\n# friction = 0.5\nid x y radius\n0 1 1 0.5\n1 3 1 0.5\n")
    with open(path("c.tsv"), "w") as f:
        f.write("i j nx ny overlap Ft\n")
    run("convert", "g.tsv", "none.h5", "--contact-table", "c.tsv")
    for ending in ("vtp", "data", "dump", "xyz", "csv", "mat"):
        run("convert", "none.h5", "none." + ending)
    expect(len(Vtp(path("none-contacts.vtp")).cells) == 0 == len(Vtp(path("none-walls.vtp")).cells), "no lines")
    expect(Vtp(path("none.vtp")).point["rattler"] == [1, 1], "rattlers alone")


# ---- displacements ---------------------------------------------------------------------------------------------------
def motion_table(file):
    names = next(line for line in open(file) if not line.startswith("#")).split()
    return dict(zip(names, np.atleast_2d(np.loadtxt(file, skiprows=sum(line.startswith("#") for line in open(file)) + 1)).T))


def moving_mode(name):
    """Number and frequency of a mode that is no zero mode."""
    rows = [line.split() for line in run("modes", name, "--frequencies-only").stdout.split("\n")]
    rows = [(int(row[0]), float(row[1])) for row in rows if row and row[0].isdigit()]
    return next((n, omega) for n, omega in rows[3:] if omega > 0)


def test_vectors():
    for name in KEPT:
        p = Packing(name)
        number, _ = moving_mode(name)
        run("modes", name, "--vectors", "V.h5", "-o", "modes.tsv")
        run("modes", name, "--vectors", "u.tsv", "--mode", number, "-o", "modes2.tsv")
        table = motion_table(path("u.tsv"))
        u = np.zeros((len(p.r), 3))
        for axis in range(p.dim):
            u[table["grain"].astype(int), axis] = table["u" + "xyz"[axis]]
        for k, words in enumerate((["--vectors", "u.tsv"], ["--vectors", "V.h5", "--mode", number])):
            run("convert", name, f"m{k}.vtp", *words)
            point = Vtp(path(f"m{k}.vtp")).point
            expect(near(point["displacement"], u, 1e-15), f"{name} {words}: displacements")
            expect(("rotation" in point) == (p.dim > 1), f"{name}: rotations")
            if p.dim == 2:
                expect(near(point["rotation"][table["grain"].astype(int), 2], table["rz"], 1e-15), f"{name}: angles")
            run("convert", name, f"m{k}.dump", *words)
            run("convert", name, f"m{k}.xyz", *words)
            columns = lammps_dump(path(f"m{k}.dump"))[2]
            expect(near(np.array([columns["u" + axis] for axis in "xyz"]).T, u, 1e-15), f"{name}: ux uy uz of the dump")
            expect(near(extended_xyz(path(f"m{k}.xyz"))[1]["displacement"], u, 1e-15), f"{name}: displacement of xyz")
        run("convert", name, "m.data", "--vectors", "u.tsv", status=2, says="m.data")
        run("convert", name, "snap.vtp", "--times", 12)
        run("plot", "snapshot", name, "--time", 12, "--table", "snap.tsv", "-o", "snap.svg") if p.dim == 2 else None
        if p.dim == 2:
            table = motion_table(path("snap.tsv"))
            at = Vtp(path("snap.vtp")).point["displacement"][table["grain"].astype(int)]
            expect(near(at[:, 0], table["ux"], 1e-12) & near(at[:, 1], table["uy"], 1e-12), "a snapshot as in plot")
        for file in os.listdir(FOLDER):
            if file not in KEPT:
                os.remove(path(file))


def series(name):
    sets = xml.etree.ElementTree.parse(path(name)).getroot().find("Collection").findall("DataSet")
    return [float(s.get("timestep")) for s in sets], [Vtp(path(s.get("file"))) for s in sets]


def test_series():
    for name in KEPT:
        p = Packing(name)
        number, omega = moving_mode(name)
        run("convert", name, "swing.pvd", "--mode", number, "--frames", 8)
        run("convert", name, "mode.vtp", "--mode", number)
        u = Vtp(path("mode.vtp")).point["displacement"]
        times, frames = series("swing.pvd")
        expect(near(times, 2 * np.pi / omega * np.arange(8) / 8), f"{name}: times of a period")
        scale = frames[0].field["scale"][0]
        expect(near(scale * np.linalg.norm(u, axis=1).max(), 0.25), f"{name}: the largest displacement is 0.25 d")
        for k, frame in enumerate(frames):
            phase = np.cos(2 * np.pi * k / 8)
            expect(np.abs(frame.point["displacement"] - phase * u) <= 1e-15 * np.abs(u).max(), f"{name}: frame {k}")
            expect(near(frame.points, p.x + scale * phase * u), f"{name}: points of frame {k}")
            expect(frame.field["TimeValue"] == times[k], f"{name}: time of frame {k}")
        run("convert", name, "wave.pvd", "--times", "0:20:5", "--amplitude", 1)
        times, frames = series("wave.pvd")
        expect(times == [0, 5, 10, 15, 20], f"{name}: times of the wave")
        run("convert", name, "snap.vtp", "--times", 15)
        at = Vtp(path("snap.vtp")).point["displacement"]
        expect(near(frames[3].point["displacement"], at, 1e-9), f"{name}: the wave at 15 is the snapshot")
        most = max(np.linalg.norm(f.point["displacement"], axis=1).max() for f in frames)
        expect(near(frames[0].field["scale"] * most, 1), f"{name}: --amplitude")
        for file in os.listdir(FOLDER):
            if file not in KEPT:
                os.remove(path(file))


# ---- signals ---------------------------------------------------------------------------------------------------------
def test_signals():
    run("signal", "2.h5", "--points", 201, "-o", "s.tsv")
    run("signal", "2.h5", "--points", 201, "-o", "s.sac")
    run("signal", "2.h5", "--points", 201, "-o", "s.mat")
    t, f = np.loadtxt(path("s.tsv"), skiprows=sum(line.startswith("#") for line in open(path("s.tsv"))) + 1).T
    head, values = sac(path("s.sac"))
    expect(values == f.astype("f4"), "SAC: every value, in single precision")
    expect(head["npts"] == 201 and head["iftype"] == 1 and head["leven"] == 1, "SAC: a time series at equal intervals")
    expect(head["delta"] == np.float32(t[1]) and head["b"] == 0 and head["e"] == np.float32(t[-1]), "SAC: times")
    expect(head["depmin"] == values.min() and head["depmax"] == values.max(), "SAC: limits")
    expect(abs(head["depmen"] - f.mean()) < 1e-6 * np.abs(f).max(), "SAC: mean")
    expect((head["kstnm"], head["kcmpnm"], head["kuser0"], head["kuser1"]) == ("top", "F", "E*d^2", "tau"), f"SAC: {head}")
    expect(head["kevnm"] == "impulse" and abs(head["user0"] - 1e-4) < 1e-10, "SAC: source and pressure")
    mat = scipy.io.loadmat(path("s.mat"), squeeze_me=True)
    expect((mat["t"] == t) & (mat["F"] == f), "MAT: every bit")
    expect(mat["units"]["F"][()] == "E* d^2" and any("height" in line for line in mat["comments"]), "MAT: units")
    run("signal", "2.h5", "--planes", 2, "--points", 31, "-o", "p.tsv")
    run("signal", "2.h5", "--planes", 2, "--points", 31, "-o", "p.sac")
    run("signal", "2.h5", "--planes", 2, "--points", 31, "-o", "p.slist")
    table = np.loadtxt(path("p.tsv"), skiprows=sum(line.startswith("#") for line in open(path("p.tsv"))) + 1).T
    stations = []
    for k in (1, 2):
        head, values = sac(path(f"p-F{k}.sac"))
        stations.append(head["kstnm"])
        expect(values == table[k].astype("f4"), f"SAC: signal {k}")
    expect(stations[0] != stations[1] and not os.path.exists(path("p.sac")), f"a file for each signal, {stations}")
    parts = open(path("p.slist")).read().split("TIMESERIES ")[1:]
    for k, part in enumerate(parts, 1):
        first, *rest = part.split("\n")
        words = first.replace(",", "").split()
        expect(words[1:3] == ["31", "samples"] and words[6:8] == ["SLIST", "FLOAT"] and len(words) == 9, first)
        expect(abs(float(words[3]) * table[0, 1] - 1) < 1e-15 and words[0].count("_") == 4, "SLIST: rate")
        expect(np.array(" ".join(rest).split(), float) == table[k], f"SLIST: every bit of signal {k}")
    run("modes", "2.h5", "-o", "m.sac", status=2, says="m.sac")
    run("check", "2.h5", "-o", "check.mat")
    expect(scipy.io.loadmat(path("check.mat"), squeeze_me=True)["file"] == "2.h5", "MAT: columns of text")
    run("signal", "2.h5", "--points", 31, "-o", "p.sac", "--planes", 2, status=2, says="--force")
    with open(path("notes.sac"), "w") as f:
        f.write("my notes")
    run("signal", "2.h5", "-o", "notes.sac", "--force", status=2, says="notes.sac")


# ---- SI ------------------------------------------------------------------------------------------------------------
def test_si():
    """Every number in m, kg, N, Pa and s, of glass beads of 1 mm."""
    e, nu, rho, d = 70e9, 0.22, 2500, 1e-3
    modulus = e / (1 - nu**2)
    si = ["--units", "si", "--material", f"E={e},nu={nu},rho={rho},d={d}"]
    run("convert", "2.h5", "o.vtp", "--units", "si", status=2, says="--material")
    run("convert", "2.h5", "o.h5", *si, status=2, says="--units")
    number, omega = moving_mode("2.h5")
    force, length = modulus * d**2, d
    factors = {"radius": length, "mass": rho * d**3, "pressure": modulus, "stress": modulus, "net_force": force,
               "normal_force": force, "force": force, "tangential_force": force, "overlap": length, "kn": modulus * d,
               "kt": modulus * d, "displacement": (rho * d**3)**-0.5, "rotation": (rho * d**5)**-0.5}
    run("convert", "2.h5", "a.vtp", "--mode", number)
    run("convert", "2.h5", "b.vtp", "--mode", number, *si)
    for part in ("", "-contacts", "-walls"):
        a, b = Vtp(path(f"a{part}.vtp")), Vtp(path(f"b{part}.vtp"))
        expect(near(b.points, d * a.points), "points in m")
        for own, other in ((a.point, b.point), (a.cell, b.cell)):
            for name in own:
                expect(near(other[name], factors.get(name, 1) * own[name], 1e-14), f"{name}{part} in SI")
        expect(near(b.field["box"], d * a.field["box"]) & near(b.field["pressure"], modulus * a.field["pressure"]), "field")
    for ending in ("data", "dump", "xyz", "csv", "mat"):
        run("convert", "2.h5", "b." + ending, *si)
    p = Packing("2.h5")
    title, box, atoms = lammps_data(path("b.data"))
    expect("SI" in title and near(atoms[:, 2] / 2, d * p.r) & (atoms[:, 3] == rho), "diameters and density")
    expect(near(atoms[:, 4:], d * p.x), "centres in m")
    expect(near(box[1, 1], d * p.box[1]) & near(box[2], np.array([-d / 2, d / 2])), "box in m")
    expect(near(lammps_dump(path("b.dump"))[2]["mass"], rho * d**3 * p.mass), "masses in kg")
    expect(extended_xyz(path("b.xyz"))[0]["units"] == "SI", "units of xyz")
    contacts = np.genfromtxt(path("b-contacts.csv"), delimiter=",", names=True)
    expect(near(contacts["Fn"], force * p.fn) & (contacts["carrying"] == p.carrying), "forces in N")
    mat = scipy.io.loadmat(path("b.mat"), squeeze_me=True)
    expect(mat["contacts_units"]["Fn"][()] == "N" and mat["grains_units"]["x"][()] == "m", "units of MAT")
    tau = d * (rho / modulus)**0.5
    run("convert", "2.h5", "s.pvd", "--mode", number, "--frames", 4, *si)
    times, frames = series("s.pvd")
    expect(near(times, tau * 2 * np.pi / omega * np.arange(4) / 4), "times in s")
    moved = frames[0].points - d * p.x
    expect(near(np.linalg.norm(moved, axis=1).max(), 0.25 * d, 1e-12), "the largest displacement shown is 0.25 d")
    run("convert", "2.h5", "a.pvd", "--times", "0:20:3")
    run("convert", "2.h5", "b.pvd", "--times", "0:20:3", *si)
    (t1, f1), (t2, f2) = series("a.pvd"), series("b.pvd")
    expect(near(t2, tau * np.array(t1)) & near(f2[2].points, d * f1[2].points, 1e-12), "the wave in SI")
    run("signal", "2.h5", "--points", 51, "-o", "a.sac")
    run("signal", "2.h5", "--points", 51, "-o", "b.sac", *si)
    (own, f), (head, g) = sac(path("a.sac")), sac(path("b.sac"))
    expect((head["kuser0"], head["kuser1"]) == ("N", "s"), f"SAC: {head}")
    expect(abs(head["delta"] / (own["delta"] * tau) - 1) < 1e-6 and np.abs(g - force * f).max() < 1e-6 * np.abs(g).max(), "SAC")


# ---- refusals --------------------------------------------------------------------------------------------------------
def test_refusals():
    before = set(os.listdir(FOLDER))
    run("convert", "2.h5", "o.xyzzy", status=2, says=".h5 .vtp --to")
    run("convert", "2.h5", "o.vtp", "--to", "paraview", status=2, says="--to paraview vtp")
    run("convert", "2.h5", "o.h5", "--mode", 50, status=2, says="o.h5")
    run("convert", "2.h5", "o.vtp", "--times", "0:10:5", status=2, says="--times .pvd")
    run("convert", "2.h5", "o.vtp", "--frames", 5, status=2, says="--frames .pvd")
    run("convert", "2.h5", "o.pvd", "--times", "0:10:5", "--mode", 50, status=2, says="--times --mode")
    for times in ("x", "0:10", "5:1:3", "-1", "0:10:0", "0:10:5:2", "0:10:20000", "nan"):
        run("convert", "2.h5", "o.pvd", f"--times={times}", status=2, says="--times")
    run("convert", "2.h5", "o.vtp", "--mode", 0, status=1, says="0")
    run("convert", "2.h5", "o.vtp", "--mode", 10**9, status=2, says="--mode")
    run("convert", "2.h5", "o.vtp", "--vectors", "nowhere.tsv", status=1, says="nowhere.tsv")
    expect(set(os.listdir(FOLDER)) == before, f"nothing is written: {set(os.listdir(FOLDER)) - before}")
    run("convert", "2.h5", "packing.final", "--to", "lammps-data")
    lammps_data(path("packing.final"))
    run("convert", "2.h5", "packing.final", "--to", "lammps-data", status=2, says="--force")
    run("convert", "2.h5", "packing.final", "--to", "vtp", "--force", status=2, says="packing.final")
    for file in ("o.vtp", "o-walls.vtp", "o.vtm"):
        run("convert", "2.h5", "o.vtp", "--force")
        for other in ("o.vtp", "o-contacts.vtp", "o-walls.vtp", "o.vtm"):
            os.remove(path(other)) if other != file else None
        run("convert", "2.h5", "o.vtp", status=2, says=file + " --force")
        os.remove(path(file))
    os.remove(path("packing.final"))


def test_bad_vectors():
    run("modes", "2.h5", "--vectors", "u.tsv", "--mode", 50, "-o", "m.tsv")
    run("modes", "3.h5", "--vectors", "V.h5", "--lowest", 3, "-o", "m3.tsv")
    run("convert", "2.h5", "o.vtp", "--vectors", "V.h5", status=1, says="V.h5")
    run("convert", "3.h5", "o.vtp", "--vectors", "u.tsv", status=1, says="u.tsv packing")
    text = open(path("u.tsv")).read()
    lines = text.split("\n")
    row = next(k for k, line in enumerate(lines) if line.startswith("grain")) + 3
    cells = lines[row].split("\t")
    for bad in ("nan", "inf"):
        cells[4] = bad
        with open(path("bad.tsv"), "w") as f:
            f.write("\n".join([*lines[:row], "\t".join(cells), *lines[row + 1:]]))
        run("convert", "2.h5", "o.vtp", "--vectors", "bad.tsv", status=1, says=f"bad.tsv ux {cells[0]}")
    with open(path("bad.tsv"), "w") as f:
        f.write("\n".join(lines[:row]))
    run("convert", "2.h5", "o.vtp", "--vectors", "bad.tsv", status=1, says="bad.tsv")
    run("convert", "2.h5", "--grain-table", "g.tsv", "--contact-table", "c.tsv")
    run("convert", "g.tsv", "o.vtp", "--contact-table", "c.tsv", "--mode", 50, status=2, says=".h5")
    expect(not [name for name in os.listdir(FOLDER) if name.startswith("o")], "nothing is written")


def test_full_device():
    """One of several files cannot be written: those that are new go too."""
    for full in ("o.vtp", "o-contacts.vtp", "o-walls.vtp", "o.vtm"):
        os.symlink("/dev/full", path(full))
        run("convert", "2.h5", "o.vtp", status=1, says="No space left")
        expect([name for name in os.listdir(FOLDER) if name.startswith("o")] == [full], f"{full}: the others go")
        os.remove(path(full))
    for ending in ("data", "dump", "xyz", "csv", "mat"):
        os.symlink("/dev/full", path("o." + ending))
        run("convert", "2.h5", "o." + ending, status=1, says="No space left")
        os.remove(path("o." + ending))
    os.symlink("/dev/full", path("o-0003.vtp"))
    run("convert", "2.h5", "o.pvd", "--times", "0:10:5", status=1, says="No space left")
    expect([name for name in os.listdir(FOLDER) if name.startswith("o")] == ["o-0003.vtp"], "frames go, and no .pvd")
    os.remove(path("o-0003.vtp"))
    for ending in ("sac", "slist", "mat"):
        os.symlink("/dev/full", path("o." + ending))
        run("signal", "2.h5", "--points", 11, "-o", "o." + ending, status=1, says="No space left")


for name, test in list(globals().items()):
    if name.startswith("test_"):
        before = len(failures)
        for file in os.listdir(FOLDER):
            if file not in KEPT:
                os.remove(path(file))
        test()
        print("ok" if len(failures) == before else "FAILED", name)
shutil.rmtree(FOLDER)
sys.exit(1 if failures else 0)
