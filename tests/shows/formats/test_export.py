"""Files for other programs: every number is that of the packing. The readers are plain ones (tests/cli/foreign.py, and
scipy for MAT-files); tests/foreign has the programs themselves."""
import os
import pathlib
import sys
import xml.etree.ElementTree

import numpy as np
import pytest
import scipy.io

from sonopack import Material, Packing, Scene, SonopackError

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "cli"))
from cells import box_of_disks, lattice, matrix_of, write_packing  # noqa: E402
from common import names_all  # noqa: E402
from foreign import Vtp, extended_xyz, lammps_data, lammps_dump  # noqa: E402

GLASS = Material(70e9, 0.22, 2500.0, 1e-3)
MODULUS = 70e9 / (1 - 0.22**2)
SI = ("--units", "si", "--material", "E=70e9,nu=0.22,rho=2500,d=1e-3")
MADE = {"plane": {"grains": 60, "width": 8}, "space": {"dimension": 3, "grains": 120, "width": 5, "depth": 5},
        "chain": {"kind": "chain", "dimension": 1, "grains": 8}}
CELLS = {"tilted": lattice(2, 0.3), "sheared": lattice(3, 0.2, cells=4), "box": {**box_of_disks(), "gravity": 1e-7}}
NAMES = [*MADE, *CELLS]


@pytest.fixture(scope="module")
def packings(tmp_path_factory):
    folder, found = tmp_path_factory.mktemp("cells"), {}
    for name, keys in MADE.items():
        found[name] = Packing.make(Scene(packing=keys))
    for name, p in CELLS.items():
        found[name] = Packing.read(write_packing(folder / f"{name}.h5", p))
    return found


def near(a, b, within=1e-13):
    return np.all(np.abs(np.asarray(a) - b) <= within * np.max(np.abs(b), initial=1e-300))


class Numbers:
    """What a file must hold, from the arrays of the packing: i and j of grains and walls, force on i, what carries."""

    def __init__(self, p):
        self.p, c = p, p.contacts
        self.i, self.j, self.pairs = c["i"], c["j"], int((c["j"] >= 0).sum())
        self.mass = 4 / 3 * np.pi * p.r**3 if p.mass is None else p.mass
        self.force = c["ft"] - c["fn"][:, None] * c["n"]
        self.carrying, self.rattler = p.carrying(), p.rattlers()
        self.box = matrix_of(p.box, p.tilt) if p.dim > 1 else np.diag(p.box)

    def stiffness(self):
        r1, r2 = self.p.r[self.i], self.p.r[self.j]
        e = np.where(self.j < 0, np.sqrt(r1), 0.5 * np.sqrt(r1 * r2 / (r1 + r2)))
        if self.p.wall == "grain":
            e = np.where(self.j < 0, 0.5 * np.sqrt(r1 / 2), e)
        return 2 * e * np.sqrt(self.p.contacts["overlap"])

    def is_periodic(self, axis):
        return self.p.cell == "periodic" or self.p.cell == "piston" and axis < self.p.dim - 1


def check_grains(w, vtp):
    p = w.p
    assert np.array_equal(vtp.points, p.x) and np.array_equal(vtp.cells[:, 0], np.arange(p.n))
    for name, values in (("id", np.arange(p.n)), ("radius", p.r), ("rattler", w.rattler)):
        assert np.array_equal(vtp.point[name], values), name
    assert near(vtp.point["mass"], w.mass, 1e-15)
    count, net, stress = np.zeros(p.n, int), np.zeros((p.n, 3)), np.zeros((p.n, 3, 3))
    for i, j, n, force, carrying in zip(w.i, w.j, p.contacts["n"], w.force, w.carrying):
        for grain, sign in ((i, 1), (j, -1)):
            if grain >= 0:
                count[grain] += carrying
                net[grain] += sign * force
                stress[grain] -= p.r[grain] * np.outer(n, force) / (4 / 3 * np.pi * p.r[grain]**3)
    assert np.array_equal(vtp.point["contacts"], count)
    assert np.all(np.abs(vtp.point["net_force"] - net) < 1e-14 * p.contacts["fn"].max())
    assert near(vtp.point["stress"].reshape(-1, 3, 3), stress)
    assert near(vtp.point["pressure"], np.trace(stress, axis1=1, axis2=2) / p.dim) and vtp.point["pressure"].mean() > 0
    assert np.array_equal(vtp.field["box"][0, :p.dim], p.box) and vtp.field["pressure"] == p.pressure
    if p.cell != "piston":
        assert vtp.field["cell"] == {"periodic": 1, "box": 2}[p.cell] and vtp.field["gravity"] == p.gravity


def check_lines(w, vtp, part):
    p, c, inner = w.p, w.p.contacts[part], part.start == 0
    i, j = w.i[part], w.j[part]
    for name, values in (("id1", i), ("id2" if inner else "wall", j), ("normal_force", c["fn"]), ("overlap", c["overlap"]),
                         ("normal", c["n"]), ("tangential_force", c["ft"]), ("force", w.force[part]), ("carrying", w.carrying[part])):
        assert np.array_equal(vtp.cell[name], values), name
    eta = (1 - p.poisson) / (1 - p.poisson / 2) if p.friction > 0 and p.dim > 1 else 0
    assert near(vtp.cell["kn"], w.stiffness()[part]) and near(vtp.cell["kt"], eta * w.stiffness()[part])
    ends = vtp.points.reshape(-1, 2, 3)
    branch, length = ends[:, 1] - ends[:, 0], p.r[i] - c["overlap"] + (p.r[j] if inner else 0)
    assert np.array_equal(ends[:, 0], p.x[i]) and np.array_equal(vtp.cells, np.arange(2 * len(i)).reshape(-1, 2))
    assert np.all(np.abs(branch - length[:, None] * c["n"]) < 1e-9), "along the normal, as long as the distance"
    if inner:
        images = (ends[:, 1] - p.x[j])[:, :p.dim] @ np.linalg.inv(w.box)
        assert np.allclose(images, np.rint(images), atol=1e-9), "ends at an image of id2"
        crosses = (np.rint(images) != 0).any(axis=1)
        assert np.array_equal(vtp.cell["periodic"], crosses) and (crosses.any() or p.dim == 1 or p.cell == "box")


@pytest.mark.parametrize("name", NAMES)
def test_vtk(packings, tmp_path, name):
    w = Numbers(packings[name])
    w.p.save(tmp_path / "o.vtp")
    check_grains(w, Vtp(tmp_path / "o.vtp"))
    check_lines(w, Vtp(tmp_path / "o-contacts.vtp"), slice(0, w.pairs))
    check_lines(w, Vtp(tmp_path / "o-walls.vtp"), slice(w.pairs, len(w.i)))
    blocks = xml.etree.ElementTree.parse(tmp_path / "o.vtm").getroot().find("vtkMultiBlockDataSet").findall("DataSet")
    assert [b.get("file") for b in blocks] == ["o.vtp", "o-contacts.vtp"]


def tilted_box(path, at):
    """Of LAMMPS' files whose box leans: rows of their bounds, and the tilts."""
    lines = path.read_text().split("\n")
    rows = np.array([[float(word) for word in line.split()] for line in lines[5:8]]) if at else None
    line = next((line for line in lines if line.endswith("xy xz yz")), "0 0 0")
    return rows, [float(word) for word in line.split()[:3]]


@pytest.mark.parametrize("name", NAMES)
def test_lammps(packings, tmp_path, name):
    w = Numbers(packings[name])
    p, tilted = w.p, np.any(w.p.tilt)
    w.p.save(tmp_path / "o.data")
    w.p.save(tmp_path / "o.dump")
    if tilted:
        assert tilted_box(tmp_path / "o.data", False)[1] == list(p.tilt)
        rows, _ = tilted_box(tmp_path / "o.dump", True)
        edges, (xy, xz, yz) = p.box, p.tilt
        corners = np.array([a * np.array([edges[0], 0]) + b * np.array([xy, edges[1]]) + c * np.array([xz, yz])
                            for a in (0, 1) for b in (0, 1) for c in (0, 1)])
        assert np.array_equal(rows[:, 2], p.tilt), "bounds are around the corners"
        assert np.allclose(rows[:2, 0], corners.min(axis=0)) and np.allclose(rows[:2, 1], corners.max(axis=0))
        return
    title, box, atoms = lammps_data(tmp_path / "o.data")
    assert np.array_equal(atoms[:, 0], np.arange(p.n) + 1) and np.array_equal(atoms[:, 2] / 2, p.r) and np.all(atoms[:, 3] == 1)
    assert np.array_equal(atoms[:, 4:], p.x) and np.all(box[:p.dim, 0] == 0) and np.array_equal(box[:p.dim, 1], p.box)
    words = dict(word.split("=") for word in title.split() if "=" in word)
    assert float(words["pressure"]) == p.pressure and words["wall"] == p.wall and len(title) < 250, title
    again, boundaries, columns = lammps_dump(tmp_path / "o.dump")
    free = {"piston": [p.dim - 1], "box": [0, 1]}[p.cell]
    assert np.array_equal(again, box) and boundaries == ["ff" if axis in free else "pp" for axis in range(3)]
    assert np.array_equal(np.array([columns[axis] for axis in "xyz"]).T, p.x)
    assert np.array_equal(columns["radius"], p.r) and np.array_equal(columns["rattler"], w.rattler)
    assert near(columns["mass"], w.mass, 1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_xyz_csv_and_mat(packings, tmp_path, name):
    w = Numbers(packings[name])
    p, axes = w.p, "xyz"[:w.p.dim]
    for ending in ("xyz", "csv", "mat"):
        p.save(tmp_path / f"o.{ending}")
    head, columns = extended_xyz(tmp_path / "o.xyz")
    lattice_vectors = np.array(head["Lattice"].split(), float).reshape(3, 3)
    assert np.array_equal(lattice_vectors[:p.dim, :p.dim], w.box)
    assert head["pbc"].split() == ["T" if axis < p.dim and w.is_periodic(axis) else "F" for axis in range(3)]
    assert np.array_equal(columns["pos"], p.x) and np.array_equal(columns["radius"][:, 0], p.r)
    assert near(columns["mass"][:, 0], w.mass, 1e-15) and np.all(columns["species"] == "X")
    assert int(head["dimension"]) == p.dim and float(head["friction"]) == p.friction
    assert float(head.get("gravity", 0)) == p.gravity
    mat = scipy.io.loadmat(tmp_path / "o.mat", squeeze_me=True)
    sheets = [np.genfromtxt(tmp_path / file, delimiter=",", names=True) for file in ("o.csv", "o-contacts.csv")]
    for g, c in (sheets, (mat["grains"][()], mat["contacts"][()])):
        assert np.array_equal(np.array([g[axis] for axis in axes]).T, p.x[:, :p.dim])
        assert np.array_equal(g["radius"], p.r) and np.array_equal(g["rattler"], w.rattler) and near(g["mass"], w.mass, 1e-15)
        for key, values in (("i", w.i), ("j", w.j), ("Fn", p.contacts["fn"]), ("overlap", p.contacts["overlap"]), ("carrying", w.carrying)):
            assert np.array_equal(c[key], values), key
        for key, field in (("n", "n"), ("Ft", "ft")):
            assert np.array_equal(np.array([c[key + axis] for axis in axes]).T, p.contacts[field][:, :p.dim])
    assert (mat["pressure"], mat["wall"], mat["dimension"]) == (p.pressure, p.wall, p.dim)
    assert p.cell == "piston" or (mat["cell"], mat["gravity"]) == (p.cell, p.gravity)
    assert np.array_equal(np.atleast_1d(mat["box"]), p.box) and mat["grains_units"]["mass"][()] == "rho d^3"


def test_own_law_and_no_contacts(tmp_path, sonopack):
    """Stiffnesses and masses of their own go along; a packing without any contact is written all the same."""
    grains, contacts = tmp_path / "g.tsv", tmp_path / "c.tsv"
    grains.write_text("# width = 8\n# height = 2\n# pressure = 1e-4\n# friction = 0.5\nid x y radius mass inertia\n"
                      "0 1 0.5 0.5 0.7 0.1\n1 1 1.49 0.5 0.9 0.2\n")
    contacts.write_text("i j nx ny overlap Fn Ft kn kt\n0 1 0 1 0.01 1e-4 0 0.25 0.125\n0 bottom 0 -1 0.001 1e-4 0 0.5 0\n")
    p = Packing.read_tables(grains, contacts)
    p.save(tmp_path / "o.vtp")
    p.save(tmp_path / "o.data")
    bulk, walls = (Vtp(tmp_path / f"o-{part}.vtp").cell for part in ("contacts", "walls"))
    assert [bulk["kn"][0], bulk["kt"][0], walls["kn"][0], walls["kt"][0]] == [0.25, 0.125, 0.5, 0]
    assert near(lammps_data(tmp_path / "o.data")[2][:, 3] * np.pi / 6, [0.7, 0.9]), "density of the mass"
    p.save(tmp_path / "own.h5")
    assert "inertia" in sonopack("convert", tmp_path / "own.h5", "again.data").stderr
    contacts.write_text("i j nx ny overlap Fn Ft kn kt\n")
    none = Packing.read_tables(grains, contacts)
    for ending in ("vtp", "data", "dump", "xyz", "csv", "mat"):
        none.save(tmp_path / f"none.{ending}")
    assert len(Vtp(tmp_path / "none-contacts.vtp").cells) == 0 == len(Vtp(tmp_path / "none-walls.vtp").cells)
    assert list(Vtp(tmp_path / "none.vtp").point["rattler"]) == [1, 1]


def test_si(packings, tmp_path):
    """Every number in m, kg, N, Pa and s, of glass beads of 1 mm."""
    d, rho, p = 1e-3, 2500, packings["plane"]
    with pytest.raises(SonopackError, match="material"):
        p.save(tmp_path / "no.vtp", si=True)
    u = np.random.default_rng(1).normal(size=p.x.shape)
    p.save(tmp_path / "a.vtp", displacement=u)
    glass = p.of_material(GLASS)
    for ending in ("vtp", "data", "dump", "xyz", "csv", "mat"):
        glass.save(tmp_path / f"b.{ending}", si=True, **({"displacement": d * u} if ending == "vtp" else {}))
    force = MODULUS * d**2
    factors = {"radius": d, "mass": rho * d**3, "pressure": MODULUS, "stress": MODULUS, "overlap": d, "kn": MODULUS * d,
               "kt": MODULUS * d, "displacement": d, **dict.fromkeys(("net_force", "normal_force", "force", "tangential_force"), force)}
    for part in ("", "-contacts", "-walls"):
        a, b = (Vtp(tmp_path / f"{k}{part}.vtp") for k in "ab")
        assert near(b.points, d * a.points) and near(b.field["box"], d * a.field["box"]) and near(b.field["pressure"], MODULUS * a.field["pressure"])
        for own, other in ((a.point, b.point), (a.cell, b.cell)):
            for name in own:
                assert near(other[name], factors.get(name, 1) * own[name], 1e-14), name
    title, box, atoms = lammps_data(tmp_path / "b.data")
    assert "SI" in title and near(atoms[:, 2] / 2, d * p.r) and np.all(atoms[:, 3] == rho) and near(atoms[:, 4:], d * p.x)
    assert near(box[1, 1], d * p.box[1]) and near(box[2], np.array([-d / 2, d / 2]))
    assert near(lammps_dump(tmp_path / "b.dump")[2]["mass"], rho * d**3 * 4 / 3 * np.pi * p.r**3)
    assert extended_xyz(tmp_path / "b.xyz")[0]["units"] == "SI"
    contacts = np.genfromtxt(tmp_path / "b-contacts.csv", delimiter=",", names=True)
    assert near(contacts["Fn"], force * p.contacts["fn"])
    mat = scipy.io.loadmat(tmp_path / "b.mat", squeeze_me=True)
    assert mat["contacts_units"]["Fn"][()] == "N" and mat["grains_units"]["x"][()] == "m"


# ---- displacements, by the command ----------------------------------------------------------------------------------

def series(path):
    sets = xml.etree.ElementTree.parse(path).getroot().find("Collection").findall("DataSet")
    return np.array([float(s.get("timestep")) for s in sets]), [Vtp(path.parent / s.get("file")) for s in sets]


@pytest.fixture
def plane(packings, tmp_path):
    packings["plane"].save(tmp_path / "P.h5")
    return packings["plane"]


def moving_mode(p):
    """Number and frequency of a mode that is no zero mode, and its displacements."""
    modes = p.network().modes(vectors=True)
    number = next(k for k, omega in enumerate(modes.omega) if omega > 0)
    return number, modes.omega[number]


def test_vectors(sonopack, plane, tmp_path):
    """Of a mode, from each kind of file."""
    number, _ = moving_mode(plane)
    sonopack("modes", "P.h5", "--vectors", "V.h5", "-o", "modes.tsv")
    sonopack("modes", "P.h5", "--vectors", "u.tsv", "--mode", number, "-o", "modes2.tsv")
    names, *rows = (line.split() for line in (tmp_path / "u.tsv").read_text().splitlines() if line[0] != "#")
    table = dict(zip(names, np.array(rows, float).T))
    u, at = np.zeros((plane.n, 3)), table["grain"].astype(int)
    u[at, 0], u[at, 1] = table["ux"], table["uy"]
    for words in (["--vectors", "u.tsv"], ["--vectors", "V.h5", "--mode", number]):
        for ending in ("vtp", "dump", "xyz"):
            sonopack("convert", "P.h5", f"m.{ending}", *words, "--force")
        point, columns = Vtp(tmp_path / "m.vtp").point, lammps_dump(tmp_path / "m.dump")[2]
        assert near(point["displacement"], u, 1e-15) and near(point["rotation"][at, 2], table["rz"], 1e-15)
        assert near(np.array([columns["u" + axis] for axis in "xyz"]).T, u, 1e-15)
        assert near(extended_xyz(tmp_path / "m.xyz")[1]["displacement"], u, 1e-15)
    lines = (tmp_path / "u.tsv").read_text().split("\n")
    row = next(k for k, line in enumerate(lines) if line.startswith("grain")) + 3
    cells = lines[row].split("\t")
    for text, said in (("\t".join([*cells[:4], "nan", *cells[5:]]), f"bad.tsv ux {cells[0]}"), (None, "bad.tsv")):
        (tmp_path / "bad.tsv").write_text("\n".join(lines[:row] + ([text, *lines[row + 1:]] if text else [])))
        assert names_all(sonopack("convert", "P.h5", "o.vtp", "--vectors", "bad.tsv", status=1).stderr, said)
    assert not list(tmp_path.glob("o*"))


def test_series(sonopack, plane, tmp_path):
    number, omega = moving_mode(plane)
    sonopack("convert", "P.h5", "mode.vtp", "--mode", number)
    u = Vtp(tmp_path / "mode.vtp").point["displacement"]
    sonopack("convert", "P.h5", "swing.pvd", "--mode", number, "--frames", 8)
    times, frames = series(tmp_path / "swing.pvd")
    scale = frames[0].field["scale"][0]
    assert near(times, 2 * np.pi / omega * np.arange(8) / 8) and near(scale * np.linalg.norm(u, axis=1).max(), 0.25)
    for k, frame in enumerate(frames):
        phase = np.cos(2 * np.pi * k / 8)
        assert np.all(np.abs(frame.point["displacement"] - phase * u) <= 1e-15 * np.abs(u).max()), k
        assert near(frame.points, plane.x + scale * phase * u) and frame.field["TimeValue"] == times[k], k
    sonopack("convert", "P.h5", "wave.pvd", "--times", "0:20:5", "--amplitude", 1)
    times, frames = series(tmp_path / "wave.pvd")
    sonopack("convert", "P.h5", "snap.vtp", "--times", 15)
    assert list(times) == [0, 5, 10, 15, 20]
    assert near(frames[3].point["displacement"], Vtp(tmp_path / "snap.vtp").point["displacement"], 1e-9)
    most = max(np.linalg.norm(f.point["displacement"], axis=1).max() for f in frames)
    assert near(frames[0].field["scale"] * most, 1), "--amplitude"
    sonopack("convert", "P.h5", "si.pvd", "--times", "0:20:5", "--amplitude", 1, *SI)
    si, metres = series(tmp_path / "si.pvd")
    assert near(si, 1e-3 * (2500 / MODULUS)**0.5 * times) and near(metres[2].points, 1e-3 * frames[2].points, 1e-12)


REFUSED = [  # status, what is named, and the words after P.h5
    (2, ".h5 .vtp --to", "o.xyzzy"), (2, "--to paraview vtp", "o.vtp --to paraview"), (2, "o.h5", "o.h5 --mode 50"),
    (2, "--times .pvd", "o.vtp --times 0:10:5"), (2, "--frames .pvd", "o.vtp --frames 5"),
    (2, "--times --mode", "o.pvd --times 0:10:5 --mode 50"), (2, "--times", "o.pvd --times=5:1:3"),
    (2, "--times", "o.pvd --times=0:10:20000"), (1, "0", "o.vtp --mode 0"), (2, "--mode", "o.vtp --mode 1000000000"),
    (1, "nowhere.tsv", "o.vtp --vectors nowhere.tsv"), (2, "o.data", "o.data --mode 50"), (2, "--material", "o.vtp --units si"),
    (2, "--units", "o.h5 --units si --material E=7e10,nu=0.2,rho=2500,d=1e-3"), (2, "mine.vtp", "mine.vtp"),
    (2, "o.txt.gz no .gz", "o.txt.gz"), (2, "o.h5.gz no .gz", "o.h5.gz"), (2, "--grain-table", "--grain-table g.tsv --contacts c.tsv"),
    (2, "--force", "mine2.vtp"), (2, "mine.vtp", "mine.vtp --force"), (1, "nowhere", "nowhere/o.vtp")]


def test_refused(sonopack, plane, tmp_path):
    (tmp_path / "mine.vtp").write_text("my notes")
    plane.save(tmp_path / "mine2.vtp")
    (tmp_path / "mine2.vtp").unlink()  # one of its companions is in the way
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for status, names, words in REFUSED:
        assert names_all(sonopack("convert", "P.h5", *words.split(), status=status).stderr, names), words
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before, words


def test_full_device(plane, tmp_path):
    """One of several files cannot be written: those that are new go too."""
    for name, full in (("o.vtp", "o.vtp"), ("o.vtp", "o-contacts.vtp"), ("o.vtp", "o.vtm"), ("o.data", "o.data"),
                       ("o.csv", "o-packing.csv"), ("o.mat", "o.mat")):
        os.symlink("/dev/full", tmp_path / full)
        with pytest.raises(SonopackError, match="No space left"):
            plane.save(tmp_path / name)
        assert [path.name for path in tmp_path.glob("o*")] == [full], full
        (tmp_path / full).unlink()
