"""Files of other programs as packings: what the samples of tests/foreign/samples hold in every form, cells of every kind
that are made here, and what cannot be read. Files that are damaged are in test_formats.py."""
import csv
import math
import pathlib
import random
import sys

import numpy as np
import pytest

from sonopack import Material, Packing, SonopackError

ROOT = pathlib.Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "tests/cli"))
from cells import box_of_disks, hertz, lattice, links, matrix_of, wall_overlap  # noqa: E402
sys.path.insert(0, str(ROOT / "tests/fuzz"))
from common import names_all  # noqa: E402
from damage import mutate  # noqa: E402

SAMPLES = ROOT / "tests/foreign/samples"
LAMMPS = SAMPLES / "lammps"
TOP = 8.8661880014055292  # the upper wall that the deck in.layer printed
CSV = {"contacts": SAMPLES / "csv/contacts.csv", "walls": SAMPLES / "csv/walls.csv"}
CSV_BOX = {"width": 8, "bottom": 0, "top": TOP}
DISKS = {"contacts": SAMPLES / "photoelastic/contacts.csv", "frame": 1, "material": Material(4e6, 0.5, 1060.0, 0.0),
         "length_unit": 0.05e-3, "kn": 5e4, "kt_ratio": 0.5, "thickness": 6e-3}
LAYERS = {  # one packing in every form
    "dump": ("lammps/layer_grains.dump", {"contacts": LAMMPS / "layer_contacts.dump", "types": 1}),
    "data": ("lammps/layer.data", {"contacts": LAMMPS / "layer_contacts.dump", "types": 1, "walls": CSV["walls"], "top": TOP}),
    "liggghts": ("liggghts/grains.dump", {"form": "liggghts", "contacts": SAMPLES / "liggghts/contacts.dump",
                                          "walls": SAMPLES / "liggghts/walls.dump"}),
    "mercury": ("mercury/layer.data", {"contacts": SAMPLES / "mercury/layer.fstat"}),
    "xyz": ("xyz/layer.xyz", CSV),
    "csv": ("csv/grains.csv", {**CSV, **CSV_BOX}),
}


def read(path, friction=0.5, **words):
    return Packing.read(SAMPLES / path if isinstance(path, str) else path, friction=friction, **words)


def refused(names, path, friction=0.5, **words):
    with pytest.raises(SonopackError) as fault:
        read(path, friction, **words)
    assert names_all(str(fault.value), names), fault.value


def said(packing):
    return "\n".join(packing.report.lines("it"))


@pytest.fixture
def write(tmp_path):
    def write(name, text):
        (tmp_path / name).write_text(text)
        return tmp_path / name
    return write


# ---- samples of every program ---------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def layer():
    path, words = LAYERS["dump"]
    return read(path, **words)


def rows_of(path):
    lines = path.read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")))
    return [dict(zip(lines[at].split()[2:], line.split())) for line in lines[at + 1:]]


def test_numbers_of_lammps(layer):
    grains = {int(g["id"]): g for g in rows_of(LAMMPS / "layer_grains.dump") if g["type"] == "1"}
    order = sorted(grains)
    own = np.array([[float(grains[k][name]) for name in ("x", "y", "radius")] for k in order])
    assert np.array_equal(layer.x[:, :2], own[:, :2]) and np.array_equal(layer.r, own[:, 2]) and layer.wall == "elastic"
    found, listed = {(int(c["i"]), int(c["j"])): c for c in layer.contacts}, 0
    for row in rows_of(LAMMPS / "layer_contacts.dump"):
        i, j = (int(row[f"c_sp_id[{k}]"]) for k in (1, 2))
        distance, fn, *ft = (float(row[f"c_sp_contact[{k}]"]) for k in (1, 2, 3, 4))
        if fn > 0 and i in grains and j in grains:
            listed += 1
            ours = found[order.index(min(i, j)), order.index(max(i, j))]
            assert ours["fn"] == pytest.approx(fn, rel=1e-15) and ours["overlap"] == pytest.approx(
                sum(float(grains[k]["radius"]) for k in (i, j)) - distance, rel=1e-10)
            assert np.allclose(ours["ft"][:2], ft if i < j else np.negative(ft), atol=1e-15)
    walls = layer.contacts[layer.contacts["j"] < 0]
    assert listed == len(found) - len(walls) and len(walls) == 11
    for side, fix in ((-1, "f_floor"), (-2, "f_roof")):
        force = sum(abs(float(grains[k][fix + "[3]"])) for k in order)
        assert walls["fn"][walls["j"] == side].sum() == pytest.approx(force, rel=1e-12)
        assert force / 8 == pytest.approx(layer.pressure, rel=1e-8)


@pytest.mark.parametrize("form", LAYERS)
def test_same_in_every_form(layer, form):
    path, words = LAYERS[form]
    p = read(path, **words)
    assert p.pressure == pytest.approx(layer.pressure, rel=1e-14) and p.wall == "elastic"
    assert np.allclose(p.x, layer.x, rtol=1e-15) and np.array_equal(p.r, layer.r)
    assert np.array_equal(p.contacts["j"], layer.contacts["j"])
    for field in ("n", "overlap", "fn", "ft"):
        assert np.allclose(p.contacts[field], layer.contacts[field], rtol=0, atol=1e-13), field


def test_columns_by_name(layer):
    ids = {"id1": "c_sp_id[1]", "id2": "c_sp_id[2]", "fn": "c_sp_contact[2]"}
    named = read(LAYERS["dump"][0], **LAYERS["dump"][1], columns={
        **ids, **{f"ft_{axis}": f"c_sp_contact[{k}]" for axis, k in zip("xyz", (3, 4, 5))}})
    assert named.hash == layer.hash


def test_spreadsheets(layer, write):
    """Semicolons and decimal commas; names with their units; diameters."""
    for end, mark in ((".csv", ";"), (".txt", "\t")):
        rows = [row.split(",") for row in (SAMPLES / "csv/grains.csv").read_text().splitlines()]
        names = ["id", "x (mm)", "y [mm]", "Diameter (mm)"]
        columns = [rows[0].index(name) for name in ("id", "x", "y", "radius")]
        body = [[row[k] if k < columns[3] else repr(2 * float(row[k])) for k in columns] for row in rows[1:]]
        path = write(f"sheet{end}", "\ufeff" + "\r\n".join(mark.join(row).replace(".", ",") for row in [names, *body]) + "\r\n")
        contacts = write(f"list{end}", CSV["contacts"].read_text().replace(",", mark).replace(".", ","))
        p = read(path, contacts=contacts, walls=CSV["walls"], **CSV_BOX)
        q = read("csv/grains.csv", **CSV, **CSV_BOX)
        assert np.array_equal(p.x, q.x) and np.array_equal(p.r, q.r) and np.array_equal(p.contacts["fn"], q.contacts["fn"])
    refused("radius Durchmesser", write("sheet.csv", "Nr;x;y;Durchmesser\n1;0,5;0,5;1,0\n"))
    assert read(write("sheet.csv", "Nr;x;y;Durchmesser (mm)\n1;0,5;0,5;1,0\n2;1,499;0,5;1,0\n"), columns="diameter=Durchmesser (mm)",
                contacts="overlap", digits="exact", width=5, pressure=1e-4).n == 2


def test_beads_in_si():
    """Walls of this LAMMPS are 1 + nu times as stiff as elastic ones, and keep their own stiffness."""
    words = {"contacts": LAMMPS / "beads_contacts.dump", "types": 1}
    p = read("lammps/beads_grains.dump", **words, material=Material(1e9, 0.22, 2500.0, 0.0))
    mean = np.mean([2 * float(g["radius"]) for g in rows_of(LAMMPS / "beads_grains.dump") if g["type"] == "1"])
    assert p.material.diameter == pytest.approx(mean, rel=1e-14) and "1.22 times" in said(p)
    own = p.contacts["kn"] > 0
    assert own.sum() == 17 and np.allclose(p.contacts["kn"][own], 1.5 * (p.contacts["fn"] / p.contacts["overlap"])[own], rtol=1e-14)
    assert p.pressure * 1e9 / (1 - 0.22**2) == pytest.approx(1e5, rel=1e-5)
    refused("2 times Hertz", "lammps/beads_grains.dump", **words, material=Material(0.5e9, 0.22, 2500.0, 0.0))
    refused("0.2 .. 5 material", "lammps/beads_grains.dump", **words)
    refused("length-unit", "lammps/beads_grains.dump", **words, material=Material(1e9, 0.22, 2500.0, 1.0))


def test_si_in_keys(write):
    """Keys with SI units are those in the units of the file: here mm, N and kg."""
    path = write("mm.csv", "x,y,diameter\n0.5,0.5,1\n1.499,0.5,1\n")
    words = {"length_unit": 1e-3, "contacts": "overlap", "digits": "exact", "width": 5}
    glass = {"material": Material(70e9, 0.22, 2500.0, 0.0)}
    p = read(path, **words, **glass, pressure="100 kPa", bottom="-1 mm", top="0.2 cm", gravity="9.81 m/s^2")
    q = read(path, **words, **glass, pressure=0.1, bottom=-1, top=2, gravity=9.81)
    assert p.height == q.height == pytest.approx(3, rel=1e-14) and p.gravity == pytest.approx(9.81 * 2500e-3 / (70e9 / (1 - 0.22**2)), rel=1e-12)
    assert p.pressure == pytest.approx(1e5 / (70e9 / (1 - 0.22**2)), rel=1e-14) and (q.pressure, q.gravity) == pytest.approx((p.pressure, p.gravity))
    refused("pressure '100 kPA' units file SI", path, **words, **glass, pressure="100 kPA")
    refused("pressure '100 kPa' units file", path, **words, pressure="100 kPa")  # without a material


def test_digits(layer, write):
    """Overlaps of six digits come from the forces; where there are none, they are worth nothing in a wide box."""
    six = read("lammps/layer_grains6.dump", contacts=LAMMPS / "layer_contacts6.dump", types=1)
    assert np.allclose(six.contacts["overlap"], layer.contacts["overlap"], rtol=1e-5) and "%.17g" in said(six)
    for digits in (6, 12):
        rows = [(500 + 2 / 3 + 0.9999 * k + 1e-6 * math.sin(k), 0.49995, 0.5) for k in range(8)]
        path = write("row.csv", "id,x,y,radius\n" + "".join(
            f"{k + 1}," + ",".join(f"{v:.{digits}g}" for v in row) + "\n" for k, row in enumerate(rows)))
        words = {"contacts": "overlap", "sides": "open", "bottom": 0, "top": 5}
        if digits == 6:
            refused("digits %.17g", path, **words)
            refused("coming to rest", path, **words, rest=True, pressure=1e-20)  # digits do not matter then
        else:
            assert len(read(path, **words).contacts) == 7 + 8


def test_yade():
    p = Packing.read_tables(SAMPLES / "yade/grains.tsv", SAMPLES / "yade/contacts.tsv")
    c, radii = p.contacts, np.append(p.r, np.inf)
    r = np.where(c["j"] < 0, radii[c["i"]] / 2, 1 / (1 / radii[c["i"]] + 1 / radii[np.maximum(c["j"], 0)]))
    assert p.n == 63 and p.wall == "grain" and np.allclose(c["fn"], 2 / 3 * np.sqrt(r) * c["overlap"]**1.5, rtol=1e-4)
    box = {"width": 4, "depth": 4, "bottom": 5, "top": 8.92966}
    ids, plain = read("yade/packing_id.txt", **box), read("yade/packing.xyzr", **box)
    assert ids.hash == plain.hash and np.array_equal(ids.contacts["j"], c["j"]), "the same contacts, by overlap"
    refused("width sides=open", "yade/packing.xyzr")


def test_photoelastic():
    p = read("photoelastic/particles.csv", **DISKS)
    grains, listed = ([row for row in csv.DictReader(open(SAMPLES / "photoelastic" / name)) if row["frame"] == "1"]
                      for name in ("particles.csv", "contacts.csv"))
    d, modulus = 2 * np.mean([float(g["radius"]) for g in grains]) * 0.05e-3, 4e6 / (1 - 0.25)
    c, radius = p.contacts, float(grains[0]["radius"]) * 0.05e-3
    assert len(c) == len(listed), "no contact with a wall is listed"
    assert c["fn"].sum() * modulus * d * d == pytest.approx(sum(float(row["Fn"]) for row in listed), rel=1e-12)
    assert np.allclose(c["kn"] * modulus * d, 5e4, rtol=1e-12) and np.allclose(c["kt"] / c["kn"], 0.5, rtol=1e-12)
    assert p.mass[0] * 1060 * d**3 == pytest.approx(math.pi * radius**2 * 6e-3 * 1060, rel=1e-12)
    assert p.inertia[0] / p.mass[0] * d * d == pytest.approx(radius**2 / 2, rel=1e-12)
    assert np.isfinite(read("photoelastic/particles.csv", **DISKS, walls="balance").network().front().t10)
    for left_out, names in (("material", "material"), ("kn", "kn"), ("contacts", "contacts")):
        refused(names, "photoelastic/particles.csv", **{key: value for key, value in DISKS.items() if key != left_out})
    refused("frame 3 2", "photoelastic/particles.csv", **{**DISKS, "frame": 3})


def test_forces_of_both_disks(write):
    """As a solver of fringes lists them: from each disk, with errors, one of them below 0, and walls by a negative id."""
    rows = [row.split(",") for row in (SAMPLES / "photoelastic/contacts.csv").read_text().split() if row[:2] == "1,"]
    both = ["frame,id1,id2,Ft,Fn"] + [f"1,{a},{b},{float(ft) * k!r},{float(fn) * k!r}" for _, i, j, ft, fn in rows[1:]
                                      for a, b, k in ((i, j, 1.1), (j, i, 0.9))]
    words = {**DISKS, "contacts": write("both.csv", "\n".join([*both, f"1,{rows[0][1]},{rows[0][2]},0,-0.01", "1,3,-1,0,2.0"]) + "\n")}
    p, one = (read("photoelastic/particles.csv", **more) for more in (words, DISKS))
    assert (int(rows[0][1]), int(rows[0][2])) == (1, 2) and len(p.contacts) == len(one.contacts) - 1
    for name in ("fn", "ft"):
        assert np.allclose(p.contacts[name], one.contacts[name][1:], rtol=1e-12, atol=1e-20)
    assert "of up to 0.0" in said(p) and "differ by 0.1" in said(p)


@pytest.mark.filterwarnings("error")
def test_forces_that_are_none(write):
    """A wall is no disk that measures again; of forces that are all 0, or all below it, no packing is made."""
    rows = [f"1,{i},{j}" for i, j in ((1, 2), (2, 1), (3, 4), (4, 3))]
    for forces, words in (([0] * 4, "no force"), ([-1] * 4, "no force"), ([1, 1, 1, 1], "touch already in line")):
        walls = ["1,3,bottom,0,1", "1,3,bottom,0,1.5"] if forces[0] > 0 else []
        table = "\n".join(["frame,id1,id2,Ft,Fn", *(f"{row},0,{f}" for row, f in zip(rows, forces)), *walls]) + "\n"
        refused(words, "photoelastic/particles.csv", **{**DISKS, "contacts": write("none.csv", table)})


def test_lammps_cells():
    """The pressure that LAMMPS printed is the mean of the normal stresses."""
    for name in ("sheared_grains.dump", "sheared.data"):
        p = read(LAMMPS / name, contacts=LAMMPS / "sheared_contacts.dump")
        assert p.cell == "periodic" and len(p.contacts) == 238 and p.pressure == pytest.approx(0.0038357194, rel=1e-7)
    p = read(LAMMPS / "box_grains.dump", contacts=LAMMPS / "box_contacts.dump")
    assert p.cell == "box" and len(p.contacts) == 86 and p.audit().force_residual < 0.03  # friction at walls balances


# ---- signs, axes and laws -------------------------------------------------------------------------------------------

def test_mirror(layer):
    """An image with y downwards is mirrored: vectors, and Ft, which is a number along t, change their signs with the axis."""
    words = {"columns": {"y": "-y"}, **CSV, "width": 8, "bottom": -TOP, "top": 0}
    c = read("csv/grains.csv", **words).contacts
    mirrored = {(i, j if j >= 0 else -3 - j): (n, fn, ft) for i, j, n, fn, ft in zip(*(c[k].tolist() for k in ("i", "j", "n", "fn", "ft")))}
    for row in layer.contacts:
        n, fn, ft = mirrored[int(row["i"]), int(row["j"])]
        assert np.allclose(row["n"] * [1, -1, 1], n, atol=1e-9) and fn == pytest.approx(row["fn"], rel=1e-9)
        assert np.allclose(row["ft"] * [1, -1, 1], ft, atol=1e-13)
    balance = [read("photoelastic/particles.csv", **DISKS, **more).audit().force_residual for more in (
        {}, {"columns": "y=-y"}, {"columns": "y=-y,ft=-Ft"}, {"columns": "y=-y,ft=Ft"})]
    assert balance[0] == pytest.approx(balance[1]) and balance[1] == balance[2] < balance[3], balance


def test_axes(write):
    """A layer that stands in another plane is the same packing; a table of ours has its keys in its head."""
    words, box = {"walls": "none", "pressure": 1e-4}, {"width": 8, "bottom": 0, "height": 8.9}
    plain, text = read("csv/grains.csv", **words, **box), (SAMPLES / "csv/grains.csv").read_text()
    rows = [line.split(",") for line in text.split("\n")[1:] if line]
    turned = write("t.csv", "id,z,x,y,radius\n" + "\n".join(f"{g[0]},{g[1]},{g[2]},7.5,{g[3]}" for g in rows))
    assert read(turned, up="x", **words, **box).hash == plain.hash
    own = write("own.tsv", "# friction = 0.5\n# pressure = 1e-4\n" + "".join(f"# {k} = {v}\n" for k, v in box.items())
                + text.replace(",", "\t"))
    p = Packing.read(own, contacts="overlap", walls="none")
    assert p.hash == plain.hash and "friction=0.5" in said(p)
    refused("up", turned, up="y", width=8, **words)


def test_sense(layer, write):
    """Force vectors on the second grain are turned by the positions; turned tangential forces are pointed out."""
    head, *rows = (line.split(",") for line in CSV["contacts"].read_text().split())
    x = {row[0]: np.array([float(row[1]), float(row[2])]) for row in (
        line.split(",") for line in (SAMPLES / "csv/grains.csv").read_text().split()[1:])}
    second, turned = ["id1,id2,f_x,f_y"], [",".join(head)]
    for i, j, fn, fx, fy in rows:
        d = x[j] - x[i]
        d[0] -= 8 * round(d[0] / 8)
        f = float(fn) * d / np.hypot(*d) - [float(fx), float(fy)]
        second.append(f"{i},{j},{float(f[0])!r},{float(f[1])!r}")
        turned.append(f"{i},{j},{fn},{-float(fx)!r},{-float(fy)!r}")
    words = {"walls": CSV["walls"], **CSV_BOX}
    p = read("csv/grains.csv", contacts=write("second.csv", "\n".join(second) + "\n"), **words)
    assert "turned" in said(p) and np.allclose(p.contacts["ft"], layer.contacts["ft"], atol=1e-13)
    path = write("turned.csv", "\n".join(turned) + "\n")
    assert "other sign" in said(read("csv/grains.csv", contacts=path, **words))
    p = read("csv/grains.csv", contacts=path, columns={"ft_x": "-ft_x", "ft_y": "-ft_y"}, **words)
    assert np.allclose(p.contacts["ft"], layer.contacts["ft"], atol=1e-13)


def test_own_stiffnesses_and_masses(write):
    grains = write("g.csv", "id,x,y,radius,mass,inertia\n1,1,0.499,0.5,0.5,0.05\n2,1.99,0.5,0.5,0.6,0.04\n# a comment\n\n")
    words = {"digits": "exact", "sides": "open", "bottom": 0, "top": 1}

    def listed(text, **more):
        return {"contacts": write("c.csv", text), **words, **more}

    p = read(grains, **listed("id1,id2,fn,kn,kt,ft\n2,1,0.003,0.3,0.1,-0.0005\n", walls="none", pressure=1e-3))
    c = p.contacts[0]
    assert (c["kn"], c["kt"], c["fn"]) == (0.3, 0.1, 0.003) and c["overlap"] == pytest.approx(0.01, rel=1e-14)
    assert p.mass.tolist() == [0.5, 0.6] and p.inertia.tolist() == [0.05, 0.04]
    # the force on grain 2 along t of n from 2 to 1 is that on grain 1 along t of n from 1 to 2
    assert c["ft"][:2] == pytest.approx([0.0005 * c["n"][1], -0.0005 * c["n"][0]], abs=1e-15)
    c = read(grains, contacts="overlap", kn=0.2, kt_ratio=0, **words).contacts  # springs by overlap, at the wall too
    assert sorted(c["overlap"]) == pytest.approx([0.001, 1 - math.hypot(0.99, 0.001)], rel=1e-12)
    assert np.allclose(c["fn"] / c["overlap"], 0.2, rtol=1e-14)
    c = read(grains, kn=0.2, **listed("id1,id2,fn,ft_x,ft_y\n1,2,0.003,0,0\ntop,1,0.002,0.0001,0\n2,bottom,0.001,0,0\n")).contacts
    assert [(int(a["i"]), int(a["j"]), a["n"][1]) for a in c if a["j"] < 0] == [(1, -1, -1), (0, -2, 1)]
    refused("c.csv:2 top", grains, kn=1, **listed("id1,id2,fn\nbottom,top,0.003\n"))
    refused("stiffness -1", grains, **listed("id1,id2,fn,kn\n1,2,0.003,-1\n"))


def test_rest(layer):
    p = read("lammps/layer.data", contacts="overlap", types=1, top=TOP, rest=True, wall="rigid")
    assert names_all(said(p), "rigid height") and p.audit().force_residual < 1e-5 and p.n == layer.n


def test_gravity(write):
    """A column of grains under its own weight, held by a floor and a light lid: each contact carries what lies above."""
    g, n, p = 1e-4, 5, 1e-4
    force = [p * 6 + np.pi / 6 * g * (n - k) for k in range(n)]  # from the floor upwards; the last: the lid + 1 grain
    y = [0.5 - wall_overlap(0.5, force[0])]
    for k in range(1, n):
        overlap = (force[k] / (2 / 3 * np.sqrt(0.25))) ** (2 / 3)
        assert hertz(0.5, overlap) == pytest.approx(force[k], rel=1e-12)
        y.append(y[-1] + 1 - overlap)
    path = write("a.csv", "# cell = piston\nid,x,y,radius\n" + "".join(f"{k},3,{float(v)!r},0.5\n" for k, v in enumerate(y)))
    words = {"width": 6, "bottom": 0, "top": y[-1] + 0.5 - wall_overlap(0.5, p * 6), "wall": "rigid", "friction": 0}
    assert read(path, **words, gravity=g).pressure == pytest.approx(p, rel=1e-6)
    assert "differ" in said(read(path, **words))


# ---- cells of every kind, in every form -----------------------------------------------------------------------------

CELLS = {"square": lattice(2), "tilted": lattice(2, 0.3), "cubic": lattice(3, cells=4), "sheared": lattice(3, 0.2, cells=4)}
BOX = box_of_disks()


def is_like(packing, p, tolerance=1e-9):
    """The same contacts; lattice vectors and positions may be others of the same lattice."""
    c, dim = packing.contacts, p["dim"]
    assert packing.cell == p["cell"] and np.array_equal(np.stack([c["i"], c["j"]], 1), p["pairs"])
    assert np.allclose(c["n"][:, :dim], p["normal"], atol=tolerance) and np.allclose(c["overlap"], p["overlap"], atol=tolerance)
    assert np.allclose(c["fn"], p["fn"], rtol=1e-6) and packing.pressure == pytest.approx(p["pressure"], rel=1e-6)
    audit = packing.audit()
    assert max(audit.force_residual, audit.wall_residual, audit.geometry_residual) < 1e-5


def solid(p):
    """Three coordinates, tilts and edges, as programs of three dimensions write a layer too."""
    x, box = np.zeros((len(p["x"]), 3)), np.ones(3)
    x[:, :p["dim"]], box[:p["dim"]] = p["x"], p["box"]
    if p["dim"] == 2:
        box[2], x[:, 2] = 2, 0.5
    return x, box, np.array(p["tilt"], dtype=float)


def table_of(rows):
    return "".join(" ".join(repr(v) for v in row) + "\n" for row in rows)


def dump(p, tilt=None, scaled=False, low=(0.0, 0.0, 0.0), boundary="pp"):
    x, box, own = solid(p)
    xy, xz, yz = tilt = own if tilt is None else np.asarray(tilt)
    bounds = [[low[0] + min(0, xy, xz, xy + xz), low[0] + box[0] + max(0, xy, xz, xy + xz), xy],
              [low[1] + min(0, yz), low[1] + box[1] + max(0, yz), xz], [low[2], low[2] + box[2], yz]]
    tilted = bool(np.any(tilt))
    names, rows = ("xs ys zs", x @ np.linalg.inv(matrix_of(box, tilt))) if scaled else ("x y z", x + low)
    return (f"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n{len(x)}\nITEM: BOX BOUNDS{' xy xz yz' * tilted} {' '.join([boundary] * 3)}\n"
            + table_of([list(map(float, b[:2 + tilted])) for b in bounds]) + f"ITEM: ATOMS id type {names} radius\n"
            + table_of([k + 1, 1, *row, float(r)] for k, (row, r) in enumerate(zip(rows.tolist(), p["r"]))))


def data(p):
    x, box, tilt = solid(p)
    return (f"a comment\n\n{len(x)} atoms\n1 atom types\n\n" + "".join(f"0 {float(b)!r} {a}lo {a}hi\n" for a, b in zip("xyz", box))
            + " ".join(repr(float(t)) for t in tilt) + " xy xz yz\n\nAtoms # sphere\n\n"
            + table_of([k + 1, 1, 2 * float(r), 1, *row] for k, (row, r) in enumerate(zip(x.tolist(), p["r"]))))


def xyz(p, pbc="T T T"):
    x, box, tilt = solid(p)
    cell = " ".join(repr(float(v)) for v in matrix_of(box, tilt).ravel())
    return (f"{len(x)}\nLattice=\"{cell}\" pbc=\"{pbc}\" Properties=pos:R:3:radius:R:1\n"
            + table_of([*row, float(r)] for row, r in zip(x.tolist(), p["r"])))


def grains_csv(p, **keys):
    return ("".join(f"# {key} = {value}\n" for key, value in keys.items()) + "id," + ",".join("xyz"[:p["dim"]]) + ",radius\n"
            + "".join(f"{k}," + ",".join(repr(v) for v in [*row, float(r)]) + "\n" for k, (row, r) in enumerate(zip(p["x"].tolist(), p["r"]))))


def edges(p):
    names = ("width", "height") if p["dim"] == 2 else ("width", "depth", "height")
    return {**dict(zip(names, map(float, p["box"]))), **dict(zip(("xy", "xz", "yz"), map(float, p["tilt"])))}


@pytest.mark.parametrize("name", CELLS)
def test_periodic_cells(write, name):
    p = CELLS[name]
    head = {key: repr(value) for key, value in edges(p).items()}
    for file, text, words in (("a.dump", dump(p, low=(-3, 7.5, 0.25)), {"digits": "exact"}),
                              ("b.dump", dump(p, scaled=True), {"digits": "exact"}), ("a.data", data(p), {}),
                              ("a.xyz", xyz(p), {}), ("a.csv", grains_csv(p, cell="periodic", **head), {}),
                              ("b.csv", grains_csv(p), {"cell": "periodic", **edges(p)})):
        if file != "a.data" or np.any(p["tilt"]):  # boundaries are not in data files, tilts are
            is_like(read(write(file, text), 0, **words), p)


@pytest.mark.parametrize("name, turns", [("tilted", (1, 0, 0)), ("tilted", (-2, 0, 0)), ("sheared", (1, -1, 1)), ("sheared", (0, 2, -1))])
def test_other_vectors_of_the_lattice(write, name, turns):
    """Tilts beyond half of the edge are other vectors of the same lattice."""
    p = CELLS[name]
    tilt = np.array(p["tilt"], dtype=float)
    if p["dim"] == 3:
        tilt += [turns[0] * p["box"][0], turns[1] * p["box"][0] + turns[2] * tilt[0], turns[2] * p["box"][1]]
    else:
        tilt[0] += turns[0] * p["box"][0]
    is_like(read(write("a.dump", dump(p, tilt=tilt)), 0), p)


def test_contacts_by_brute_force(write):
    """Grains anywhere in a tilted cell: the contacts are those of all pairs and images."""
    draw = np.random.default_rng(7)
    for dim, n in ((2, 60), (3, 120)):
        box, tilt = draw.uniform(5.2, 6, 3)[:dim], draw.uniform(-0.45, 0.45, 3) * 5 * [1, dim == 3, dim == 3]
        m = matrix_of(box, tilt)
        p = {"dim": dim, "x": draw.uniform(0, 1, (n, dim)) @ m, "r": draw.uniform(0.4, 0.6, n), "box": box, "tilt": tilt}
        pairs = [(i, j) for i, j, d in links(p["x"], m, 1.2) if np.hypot.reduce(d) < p["r"][i] + p["r"][j]]
        found = read(write("a.dump", dump(p)), 0).contacts
        assert list(zip(found["i"].tolist(), found["j"].tolist())) == pairs, (dim, len(found), len(pairs))


def test_periodic_cells_as_layers(write):
    """A cell is cut at its face where asked, and the cut contacts are counted; contacts may be listed."""
    p, tilted = CELLS["square"], CELLS["tilted"]
    path = write("a.dump", dump(p))
    cut = read(path, 0, across="drop")
    assert cut.cell == "piston" and len(cut.contacts) == len(p["pairs"]) - 6 and "6 contacts across" in said(cut)
    assert read(path, 0, bottom=-1, top=7).cell == "piston"
    refused("across=drop cell=periodic", path, 0, cell="piston")
    rows = table_of([i + 1, j + 1, f, 0, 0, 0] for i, j, f in zip(*tilted["pairs"].T.tolist(), tilted["fn"].tolist()))
    listed = write("c.dump", f"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n{len(tilted['fn'])}\nITEM: BOX BOUNDS pp pp pp\n"
                   f"0 1\n0 1\n0 1\nITEM: ENTRIES id1 id2 fn ft_x ft_y ft_z\n{rows}")
    is_like(read(write("t.dump", dump(tilted)), 0, contacts=listed), tilted)


def test_boxes(write):
    (width, height), rigid = BOX["box"].tolist(), {"friction": 0, "wall": "rigid"}
    path = write("a.dump", dump(BOX, boundary="ff"))
    is_like(read(path, **rigid), BOX)
    is_like(read(write("a.xyz", xyz(BOX, pbc="F F F")), **rigid), BOX)
    # the box of the program is larger than that of the walls, whose places are given
    larger = write("b.dump", dump({**BOX, "box": BOX["box"] + 2}, low=(-1, -1, 0), boundary="ff"))
    is_like(read(larger, **rigid, left=-1, right=width - 1, bottom=-1, top=height - 1), BOX)
    side = read(path, **rigid, sides="open")
    assert side.cell == "piston" and side.contacts["j"].min() == -2
    # faces deep inside of grains, as those of a box around the centres, are no walls
    inner = {**BOX, "x": BOX["x"] - BOX["x"].min(axis=0) + 0.2, "box": np.ptp(BOX["x"], axis=0) + 0.4}
    assert read(write("c.dump", dump(inner, boundary="ss")), **rigid, digits="exact").cell == "piston"


def test_listed_walls(write):
    rigid, names = {"friction": 0, "wall": "rigid"}, {-1: "bottom", -2: "top", -3: "left", -4: "right"}
    pairs, overlap, fn = (BOX[key].tolist() for key in ("pairs", "overlap", "fn"))
    listed = write("c.csv", "id1,id2,overlap,Fn\n" + "".join(
        f"{i},{names.get(j, j)},{o!r},{f!r}\n" for (i, j), o, f in zip(pairs, overlap, fn)))
    path = write("a.csv", grains_csv(BOX, cell="box", width=float(BOX["box"][0]), height=float(BOX["box"][1])))
    is_like(read(path, **rigid, contacts=listed), BOX)
    at = [(i, n, BOX["x"][i] + (0.5 - o) * n, f) for (i, j), n, o, f in zip(pairs, BOX["normal"], overlap, fn) if j < 0]
    forces = "".join(f"{i},{float(-f * n[0])!r},{float(-f * n[1])!r},0{{{k}}}\n" for k, (i, n, _, f) in enumerate(at))
    points = [f",{float(x[0])!r},{float(x[1])!r},0" for _, _, x, _ in at]
    for head, cells in (("id,f_x,f_y,f_z,p_x,p_y,p_z", points), ("id,f_x,f_y,f_z", [""] * len(at))):
        is_like(read(path, **rigid, walls=write("w.csv", f"{head}\n" + forces.format(*cells))), BOX)
    refused("c.csv left", write("b.csv", grains_csv(BOX, width=float(BOX["box"][0]), height=float(BOX["box"][1]))), 0, contacts=listed)
    # MercuryDPM has them among its contacts
    path = write("m.data", f"{len(BOX['x'])} 0 0 0 {float(BOX['box'][0])!r} {float(BOX['box'][1])!r}\n" + table_of(
        [a, b, 0, 0, 0.5, 0, 0, 0] for a, b in BOX["x"].tolist()))
    rows = table_of([0, i, j, *(BOX["x"][i] + (0.5 - o) * np.array(n)).tolist(), 0, o, 0, f, 0, *n, 0, 0, 0, 0] for (i, j), n, o, f in zip(
        pairs, BOX["normal"].tolist(), overlap, fn))
    is_like(read(path, **rigid, contacts=write("m.fstat", "# 0 1\n# 0 0\n# \n" + rows)), BOX)


# ---- what cannot be read --------------------------------------------------------------------------------------------

ATOMS = ("ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp ff pp\n0 4\n0 1\n-0.5 0.5\n"
         "ITEM: ATOMS id type x y z radius\n1 1 0.5 0.4999 0 0.5\n2 1 1.4999 0.5001 0 0.5\n3 1 2.4998 0.5 0 0.5\n")
TILTED, CUBIC = dump(CELLS["tilted"]), dump(CELLS["sheared"])
SMALL = dump({**lattice(2, cells=3), "r": np.full(9, 0.75)})  # the period is 2.97
DATA = (LAMMPS / "layer.data").read_text()
REFUSED = [  # what is named, the file, its text, and what is said beside it
    ("a.dump:11 x 1.49.99", "a.dump", ATOMS.replace("1.4999 ", "1.49.99 "), {}),
    ("a.dump:11 id 2.5", "a.dump", ATOMS.replace("2 1 1.4999", "2.5 1 1.4999"), {}),
    ("a.dump:10 commas", "a.dump", ATOMS.replace(" 1 0.5 0.4999", ",1,0.5,0.4999"), {}),
    ("a.dump:7 tilt", "a.dump", ATOMS.replace("pp ff pp", "xy xz yz pp ff pp").replace("0 4\n", "0 4 0\n"), {}),
    ("a.dump:10 1.7 between the walls", "a.dump", ATOMS.replace("0.4999 0 0.5", "1.7 0 0.5"), {}),
    ("height two", "a.dump", ATOMS.replace("pp ff pp", "pp pp pp"), {}),
    ("periodic across=drop", "a.dump", ATOMS.replace("pp ff pp", "pp pp pp"), {"cell": "piston"}),
    ("type 2", "a.dump", ATOMS, {"types": 2}), ("8 7", "a.dump", ATOMS, {"frame": 8}),
    ("colour", "a.dump", ATOMS, {"colour": "red"}), ("poisson 0.7", "a.dump", ATOMS, {"poisson": 0.7}),
    ("idd role", "a.dump", ATOMS, {"columns": "idd=id"}), ("weight columns", "a.dump", ATOMS, {"columns": "mass=weight"}),
    ("friction", "a.dump", ATOMS, {"friction": None}), ("none.dump", "a.dump", ATOMS, {"contacts": "none.dump"}),
    ("tilted", "a.dump", TILTED, {"across": "drop"}), ("tilted", "a.dump", TILTED, {"cell": "box"}),
    ("cell round", "a.dump", TILTED, {"cell": "round"}), ("walls overlap", "a.dump", TILTED, {"walls": "overlap"}),
    ("rest", "a.dump", TILTED, {"rest": True}), ("turned", "a.dump", TILTED, {"columns": "x=-x"}),
    ("turned", "a.dump", CUBIC, {"up": "x"}), ("width 2.97 two", "a.dump", SMALL, {}),
    ("width", "a.csv", grains_csv(CELLS["tilted"], cell="periodic"), {}),
    ("a.csv xy nan", "a.csv", grains_csv(CELLS["tilted"], cell="periodic", width=5, height=5, xy="nan"), {}),
    ("left", "a.csv", grains_csv(BOX, cell="box"), {}), ("a.csv x between 3", "a.csv", grains_csv(BOX, cell="box", width=3, height=9), {}),
    ("right", "a.csv", grains_csv(BOX), {"left": 1, "right": 0, "bottom": 0, "top": 5}),
    ("a.data:10 ellipsoid sphere", "a.data", DATA.replace("# sphere", "# ellipsoid"), {"contacts": "overlap"}),
    ("Atoms", "a.data", DATA[:DATA.index("Atoms")], {"contacts": "overlap"}),
    ("width", "a.data", DATA.replace("0 8 xlo xhi\n", ""), {"contacts": "overlap", "types": 1, "top": TOP}),
    ("a.csv:4 x 1e307 within", "a.csv", "id,x,y,radius\n1,0.5,0.5,0.5\n2,1.49,0.5,0.5\n3,1e307,0.5,0.5\n", {"contacts": "overlap", "sides": "open"}),
    ("a.csv:3 5 4", "a.csv", "id,x,y,radius\n1,0.5,0.5,0.5\n2,1.49,0.5,0.5,7\n", {"sides": "open"}),
    ("a.csv:1 header", "a.csv", "1,0.5,0.5,0.5\n", {"form": "csv"}),
    ("a.xyz:3 1 of 3", "a.xyz", "3\nLattice=\"4 0 0 0 1 0 0 0 1\" Properties=pos:R:3:radius:R:1\n0.5 0.5 0 0.5\n", {}),
    ("a.xyz:2 Lattice x", "a.xyz", "1\nLattice=\"4 1 0 0 1 0 0 0 1\" Properties=pos:R:3:radius:R:1\n0.5 0.5 0 0.5\n", {}),
    ("m.data:2 1 of 2", "m.data", "2 0 0 0 0 4 1 1\n0.5 0.5 0 0 0 0 0.5 0 0 0 0 0 0 0\n", {}),
]


@pytest.mark.parametrize("names, file, text, words", REFUSED)
def test_refused(write, names, file, text, words):
    words = {"friction": 0.5, "digits": "exact", **words}
    if words["friction"] is None:
        del words["friction"]
    with pytest.raises(SonopackError) as fault:
        Packing.read(write(file, text), **words)
    assert names_all(str(fault.value), names), fault.value


def test_contacts_that_cannot_be(write):
    path, force = write("a.dump", ATOMS), [hertz(0.5, 1 - math.hypot(0.9999, dy)) for dy in (0.0002, 0.0001)]
    good = ("ITEM: TIMESTEP\n7\nITEM: NUMBER OF ENTRIES\n2\nITEM: ENTRIES c_1[1] c_1[2] c_2[1]\n"
            f"1 2 {force[0]}\n2 3 {force[1]}\n")
    words = {"digits": "exact", "wall": "rigid", "columns": {"id1": "c_1[1]", "id2": "c_1[2]", "fn": "c_2[1]"}}
    one, two = (read(path, **words, contacts=write("c.dump", text)) for text in (good, good.replace("1 2 ", "2 1 ")))
    assert one.hash == two.hash, "the order of a pair does not matter"
    refused("id1 c_1[1] columns", path, contacts=write("c.dump", good), digits="exact", wall="rigid")
    last = str(force[1])
    for text, names in ((good.replace("2 3 ", "2 9 "), "c.dump:7 9 id"), (good.replace("2 3 ", "2 2 "), "c.dump:7 2"),
                        (good.replace("2 3 ", "2 1 "), "c.dump:7 line 6"), (good.replace(last, "-1e-7"), "c.dump:7 attraction"),
                        (good.replace(last, "inf"), "c.dump:7 c_2[1] inf"), (good.replace("TIMESTEP\n7", "TIMESTEP\n8"), "c.dump 7"),
                        (good.replace(last, "1e-7"), "times Hertz")):  # the overlaps ask for other forces
        refused(names, path, **words, contacts=write("c.dump", text))


def test_lists_that_cannot_be(write):
    """Lists without pairs, or with far too few, are refused."""
    text = (LAMMPS / "layer_contacts.dump").read_text()
    head = text[:text.index("\n", text.index("ITEM: ENTRIES")) + 1]
    rows = text[len(head):].splitlines(keepends=True)
    for count, names in ((40, "c.dump pairs"), (0, "c.dump overlap")):
        listed = write("c.dump", head.replace(f"\n{len(rows)}\n", f"\n{count}\n") + "".join(rows[:count]))
        refused(names, "lammps/layer_grains.dump", types=1, contacts=listed)


def test_loose_grains(write):
    """Nothing touches the walls of fix wall/gran: their points of contact, zeros, are no places of walls."""
    names = " ".join(f"f_{fix}[{k}]" for fix in ("floor", "roof") for k in range(1, 8))
    none, floor = " 0" * 7, " 1 0 1e-5 0 0.5 0 0"
    head, rows = ATOMS.replace("radius\n", f"radius {names}\n").split("ITEM: ATOMS")[0], ATOMS.split("radius\n")[1].splitlines()
    for flags in ((none, none, none), (floor, none, none)):
        path = write("l.dump", head + f"ITEM: ATOMS id type x y z radius {names}\n" + "".join(
            row + flag + none + "\n" for row, flag in zip(rows, flags)))
        p = read(path, digits="exact", wall="rigid")
        assert "upper" in said(p) and "inf" not in said(p) and "outside" not in said(p) and p.box[1] == 1


@pytest.mark.parametrize("name", LAYERS)
def test_damaged(tmp_path, name):
    """Whatever is changed, in the grains or the contacts: a packing, or an error of ours."""
    seed, ended = 20050201, {True: 0, False: 0}
    path, words = LAYERS[name]
    for damaged in (SAMPLES / path, words["contacts"]):
        good = damaged.read_bytes()
        for case in range(30):
            other = tmp_path / damaged.name
            other.write_bytes(mutate(good, random.Random(f"{seed} {name} {case}")))
            try:
                if damaged == words["contacts"]:
                    read(path, **{**words, "contacts": other})
                else:
                    read(other, **words)
                ended[True] += 1
            except SonopackError:
                ended[False] += 1
    assert ended[False] > 10, ended
