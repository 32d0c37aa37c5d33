"""sonopack convert on files of other programs in periodic cells, tilted ones, and boxes with walls on all sides."""
import itertools
import os
import re
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from cells import box_of_disks, lattice, matrix_of
from common import expect, faults, names_all

COMMAND = sys.argv[1]
FOLDER = tempfile.mkdtemp(prefix="sonopack-import-cells-")
FRICTION, RIGID, EXACT = ("--set", "friction=0"), ("--set", "wall=rigid"), ("--set", "digits=exact")


def path(name):
    return os.path.join(FOLDER, name)


def write(name, text):
    with open(path(name), "w") as f:
        f.write(text)
    return name


def run(*words):
    return subprocess.run([COMMAND, *words], capture_output=True, text=True, timeout=600, cwd=FOLDER)


class Imported:
    """What convert makes of a file."""

    def __init__(self, *words, says="", check=True):
        result = run("convert", *words, "--force", "-o", "out.h5", *FRICTION)
        expect(result.returncode == 0 and names_all(result.stderr, says), f"{words}: {result.stderr}")
        with h5py.File(path("out.h5")) as f:
            self.cell = f["sonopack/cell"][()].decode() if "sonopack/cell" in f else "piston"
            self.edges = f["particles/grains/box/edges"][()]
            self.x = f["particles/grains/position/value"][0]
            walls = f["sonopack/walls/contacts"][()] if "sonopack/walls" in f else np.zeros((0, 2), "i4")
            self.pairs = np.concatenate([f["connectivity/contacts"][()], walls])
            self.normal = f["sonopack/contacts/normal"][()]
            self.overlap, self.fn = f["sonopack/contacts/overlap"][()], f["sonopack/contacts/normal_force"][()]
            self.pressure = f["sonopack/pressure"][()]
        if check:
            said = run("check", "out.h5")
            expect(said.returncode == 0, f"{words}: {said.stdout} {said.stderr}")

    def is_like(self, p, what, tolerance=1e-9):
        """The same contacts; lattice vectors and positions may be others of the same lattice."""
        expect(self.cell == p["cell"], f"{what}: cell {self.cell}")
        expect(np.array_equal(self.pairs, p["pairs"]), f"{what}: {len(self.pairs)} contacts, {len(p['pairs'])}")
        if len(self.pairs) == len(p["pairs"]):
            expect(np.allclose(self.normal, p["normal"], atol=tolerance), f"{what}: normals")
            expect(np.allclose(self.overlap, p["overlap"], atol=tolerance), f"{what}: overlaps")
            expect(np.allclose(self.fn, p["fn"], rtol=1e-6), f"{what}: forces")
        expect(abs(self.pressure / p["pressure"] - 1) < 1e-6, f"{what}: pressure {self.pressure} {p['pressure']}")


def refuse(*words, status=1, says=""):
    result = run("convert", *words, "--force", "-o", "no.h5", *FRICTION)
    expect(result.returncode == status and names_all(result.stderr, says), f"{words}: {result.returncode} {result.stderr}")
    expect(not os.path.exists(path("no.h5")), f"nothing written: {words}")


# ---- the forms -------------------------------------------------------------------------------------------------------
def solid(p):
    """Three coordinates, tilts and edges, as programs of three dimensions write a layer too."""
    x = np.zeros((len(p["x"]), 3))
    x[:, :p["dim"]] = p["x"]
    box = np.ones(3)
    box[:p["dim"]] = p["box"]
    if p["dim"] == 2:
        box[2], x[:, 2] = 2, 0.5
    return x, box, np.array(p["tilt"], dtype=float)


def dump(p, tilt=None, scaled=False, low=(0.0, 0.0, 0.0), boundary="pp"):
    x, box, own = solid(p)
    tilt = own if tilt is None else np.asarray(tilt)
    low = np.asarray(low)
    xy, xz, yz = tilt
    bounds = [(low[0] + min(0, xy, xz, xy + xz), low[0] + box[0] + max(0, xy, xz, xy + xz), xy),
              (low[1] + min(0, yz), low[1] + box[1] + max(0, yz), xz), (low[2], low[2] + box[2], yz)]
    tilted = bool(np.any(tilt))
    text = f"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n{len(x)}\nITEM: BOX BOUNDS{' xy xz yz' * tilted} {' '.join([boundary] * 3)}\n"
    text += "".join(" ".join(repr(float(v)) for v in b[:2 + tilted]) + "\n" for b in bounds)
    names, rows = "x y z", x + low
    if scaled:
        names, rows = "xs ys zs", x @ np.linalg.inv(matrix_of(box, tilt))
    text += f"ITEM: ATOMS id type {names} radius\n"
    return text + "".join(f"{k + 1} 1 {a!r} {b!r} {c!r} {float(r)!r}\n"
                          for k, ((a, b, c), r) in enumerate(zip(rows.tolist(), p["r"])))


def data(p):
    x, box, tilt = solid(p)
    head = "a comment\n\n%d atoms\n1 atom types\n\n" % len(x)
    head += "".join(f"0 {float(b)!r} {a}lo {a}hi\n" for a, b in zip("xyz", box))
    head += " ".join(repr(float(t)) for t in tilt) + " xy xz yz\n\nAtoms # sphere\n\n"
    return head + "".join(f"{k + 1} 1 {2 * float(r)!r} 1 {a!r} {b!r} {c!r}\n"
                          for k, ((a, b, c), r) in enumerate(zip(x.tolist(), p["r"])))


def xyz(p, pbc="T T T"):
    x, box, tilt = solid(p)
    cell = " ".join(repr(float(v)) for v in matrix_of(box, tilt).ravel())
    return (f"{len(x)}\nLattice=\"{cell}\" pbc=\"{pbc}\" Properties=pos:R:3:radius:R:1\n"
            + "".join(f"{a!r} {b!r} {c!r} {float(r)!r}\n" for (a, b, c), r in zip(x.tolist(), p["r"])))


def table(p, **keys):
    head = "".join(f"# {key} = {value}\n" for key, value in keys.items()) + "id," + ",".join("xyz"[:p["dim"]]) + ",radius\n"
    return head + "".join(f"{k}," + ",".join(repr(v) for v in row) + f",{float(r)!r}\n"
                          for k, (row, r) in enumerate(zip(p["x"].tolist(), p["r"])))


def edges(p):
    names = ("width", "height") if p["dim"] == 2 else ("width", "depth", "height")
    return {name: repr(float(b)) for name, b in zip(names, p["box"])}


# ---- periodic cells --------------------------------------------------------------------------------------------------
CELLS = {"square": lattice(2), "tilted": lattice(2, 0.3), "cubic": lattice(3, cells=4), "sheared": lattice(3, 0.2, cells=4)}


def test_dumps():
    for name, p in CELLS.items():
        write("a.dump", dump(p, low=(-3, 7.5, 0.25)))
        Imported("a.dump", *EXACT, says="periodic").is_like(p, f"dump of {name}")
        write("a.dump", dump(p, scaled=True))
        Imported("a.dump", *EXACT).is_like(p, f"scaled dump of {name}")


def test_other_vectors_of_the_lattice():
    """Tilts beyond half of the edge are other vectors of the same lattice."""
    for name, turns in (("tilted", (1, 0, 0)), ("tilted", (-2, 0, 0)), ("sheared", (1, -1, 1)), ("sheared", (0, 2, -1))):
        p = CELLS[name]
        tilt = np.array(p["tilt"], dtype=float)
        if p["dim"] == 3:
            tilt += [turns[0] * p["box"][0], turns[1] * p["box"][0] + turns[2] * tilt[0], turns[2] * p["box"][1]]
        else:
            tilt[0] += turns[0] * p["box"][0]
        write("a.dump", dump(p, tilt=tilt))
        Imported("a.dump").is_like(p, f"{name} with {turns}")


def test_data_xyz_tables():
    for name in ("tilted", "sheared"):
        p = CELLS[name]
        write("a.data", data(p))
        Imported("a.data", says="periodic").is_like(p, f"data of {name}")
    for name, p in CELLS.items():
        write("a.xyz", xyz(p))
        Imported("a.xyz").is_like(p, f"xyz of {name}")
        tilts = dict(zip(("xy", "xz", "yz"), (repr(float(t)) for t in p["tilt"])))
        write("a.csv", table(p, cell="periodic", **edges(p), **tilts))
        Imported("a.csv", says="cell=periodic").is_like(p, f"csv of {name}")
        write("a.csv", table(p))
        given = itertools.chain.from_iterable(("--set", f"{k}={v}") for k, v in {**edges(p), **tilts}.items())
        Imported("a.csv", "--set", "cell=periodic", *given).is_like(p, f"csv of {name} with options")


def test_contacts_by_brute_force():
    """Grains anywhere in a tilted cell: the contacts are those of all pairs and images."""
    draw = np.random.default_rng(7)
    for dim, n in ((2, 60), (3, 120)):
        box, tilt = draw.uniform(5.2, 6, 3), draw.uniform(-0.45, 0.45, 3) * 5
        if dim == 2:
            tilt[1:] = 0
        m = matrix_of(box[:dim], tilt)
        p = {"dim": dim, "x": draw.uniform(0, 1, (n, dim)) @ m, "r": draw.uniform(0.4, 0.6, n), "box": box[:dim], "tilt": tilt}
        images = np.array(list(itertools.product((-2, -1, 0, 1, 2), repeat=dim))) @ m
        pairs = [(i, j) for i in range(n) for j in range(i + 1, n)
                 if np.linalg.norm(p["x"][j] - p["x"][i] + images, axis=1).min() < p["r"][i] + p["r"][j]]
        write("a.dump", dump(p))
        found = Imported("a.dump", check=False)
        expect([tuple(k) for k in found.pairs] == pairs, f"{len(found.pairs)} contacts, by brute force {len(pairs)}")


def test_listed_contacts():
    p = CELLS["tilted"]
    write("a.dump", dump(p))
    rows = "".join(f"{i + 1} {j + 1} {f!r} 0 0 0\n" for (i, j), f in zip(p["pairs"], p["fn"].tolist()))
    write("c.dump", f"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n{len(p['fn'])}\nITEM: BOX BOUNDS pp pp pp\n"
          f"0 1\n0 1\n0 1\nITEM: ENTRIES id1 id2 fn ft_x ft_y ft_z\n{rows}")
    Imported("a.dump", "--contacts", "c.dump", says="Hertz").is_like(p, "listed contacts")


def test_old_ways_remain():
    p = CELLS["square"]
    write("a.dump", dump(p))
    cut = Imported("a.dump", "--set", "across=drop", check=False)
    expect(cut.cell == "piston" and len(cut.pairs) == len(p["pairs"]) - 6, "cut at the face")
    refuse("a.dump", "--set", "cell=piston", status=2, says="across=drop cell=periodic")
    between = Imported("a.dump", "--set", "bottom=-1", "--set", "top=7", check=False)
    expect(between.cell == "piston", "walls by the options")


def test_refusals():
    p = CELLS["tilted"]
    write("a.dump", dump(p))
    refuse("a.dump", "--set", "across=drop", says="tilted")
    refuse("a.dump", "--set", "cell=box", says="tilted")
    refuse("a.dump", "--set", "cell=round", status=2, says="cell round")
    refuse("a.dump", "--walls", "overlap", status=2, says="walls overlap")
    refuse("a.dump", "--rest", says="rest")
    refuse("a.dump", "--columns", "x=-x", status=2, says="turned")
    write("s.dump", dump(CELLS["sheared"]))
    refuse("s.dump", "--set", "up=x", status=2, says="turned")
    write("a.dump", dump(p, tilt=(50, 0, 0)).replace("50.0", "5000"))
    refuse("a.dump", says="a.dump")
    small = {**lattice(2, cells=3)}
    small["r"] = np.full(9, 0.75)  # the period is 2.97
    write("a.dump", dump(small))
    refuse("a.dump", status=2, says="width 2.97 two")
    write("a.csv", table(p, cell="periodic"))
    refuse("a.csv", status=2, says="width")
    write("a.csv", table(p, cell="periodic", **edges(p), xy="nan"))
    refuse("a.csv", status=2, says="a.csv xy nan")


# ---- boxes -----------------------------------------------------------------------------------------------------------
BOX = box_of_disks()


def test_boxes_by_their_faces():
    write("a.dump", dump(BOX, boundary="ff"))
    Imported("a.dump", *RIGID, says="box").is_like(BOX, "dump of a box")
    write("a.xyz", xyz(BOX, pbc="F F F"))
    Imported("a.xyz", *RIGID).is_like(BOX, "xyz of a box")
    # the box of the program is larger than that of the walls, whose places are given
    width, height = BOX["box"]
    write("a.dump", dump({**BOX, "box": BOX["box"] + 2}, low=(-1, -1, 0), boundary="ff"))
    moved = {"left": -1, "right": width - 1, "bottom": -1, "top": height - 1}
    given = itertools.chain.from_iterable(("--set", f"{k}={float(v)!r}") for k, v in moved.items())
    Imported("a.dump", *given, *RIGID).is_like(BOX, "walls by the options")


def test_open_sides_remain():
    write("a.dump", dump(BOX, boundary="ff"))
    found = Imported("a.dump", "--set", "sides=open", *RIGID, check=False)
    expect(found.cell == "piston" and found.pairs.min() == -2, "side walls left out")
    # faces deep inside of grains, as those of a box around the centres, are no walls
    inner = {**BOX, "x": BOX["x"] - BOX["x"].min(axis=0) + 0.2, "box": np.ptp(BOX["x"], axis=0) + 0.4}
    write("a.dump", dump(inner, boundary="ss"))
    found = Imported("a.dump", *RIGID, *EXACT, check=False)
    expect(found.cell == "piston", "no box by faces that cut grains")


def walls_of(p):
    return [(k, tuple(pair), n, o, f) for k, (pair, n, o, f) in enumerate(zip(p["pairs"], p["normal"], p["overlap"], p["fn"]))
            if pair[1] < 0]


def test_listed_walls():
    names = {-1: "bottom", -2: "top", -3: "left", -4: "right"}
    rows = "".join(f"{i},{names.get(j, j)},{o!r},{f!r}\n"
                   for (i, j), o, f in zip(BOX["pairs"].tolist(), BOX["overlap"].tolist(), BOX["fn"].tolist()))
    write("c.csv", "id1,id2,overlap,Fn\n" + rows)
    write("a.csv", table(BOX, cell="box", **edges(BOX)))
    Imported("a.csv", "--contacts", "c.csv", *RIGID).is_like(BOX, "walls by name")
    # forces of walls and where they act
    write("w.csv", "id,f_x,f_y,f_z,p_x,p_y,p_z\n" + "".join(
        f"{i},{-f * n[0]!r},{-f * n[1]!r},0,{x[0]!r},{x[1]!r},0\n"
        for _, (i, _), n, o, f in walls_of(BOX) for x in [BOX["x"][i] + (0.5 - o) * n]))
    Imported("a.csv", "--walls", "w.csv", *RIGID).is_like(BOX, "walls by force and point")
    write("w.csv", "id,f_x,f_y,f_z\n" + "".join(f"{i},{-f * n[0]!r},{-f * n[1]!r},0\n"
                                                for _, (i, _), n, o, f in walls_of(BOX)))
    Imported("a.csv", "--walls", "w.csv", *RIGID).is_like(BOX, "walls by force alone")
    write("a.csv", table(BOX, **edges(BOX)))  # under a piston there is no wall of this name
    refuse("a.csv", "--contacts", "c.csv", says="c.csv left")


def test_mercury_walls():
    width, height = BOX["box"].tolist()
    write("m.data", f"{len(BOX['x'])} 0 0 0 {width!r} {height!r}\n"
          + "".join(f"{a!r} {b!r} 0 0 0.5 0 0 0\n" for a, b in BOX["x"].tolist()))
    rows = ""
    for (i, j), n, o, f in zip(BOX["pairs"].tolist(), BOX["normal"].tolist(), BOX["overlap"].tolist(), BOX["fn"].tolist()):
        point = BOX["x"][i] + (0.5 - o) * np.array(n)
        rows += f"0 {i} {j} {point[0]!r} {point[1]!r} 0 {o!r} 0 {f!r} 0 {n[0]!r} {n[1]!r} 0 0 0 0\n"
    write("m.fstat", "# 0 1\n# 0 0\n# \n" + rows)
    Imported("m.data", "--contacts", "m.fstat", *RIGID, says="box").is_like(BOX, "MercuryDPM")


def test_box_refusals():
    write("a.csv", table(BOX, cell="box"))
    refuse("a.csv", status=2, says="left")
    write("a.csv", table(BOX))
    refuse("a.csv", "--set", "left=1", "--set", "right=0", "--set", "bottom=0", "--set", "top=5", status=2, says="right")
    write("a.csv", table(BOX, cell="box", width=3, height=9))
    refuse("a.csv", says="a.csv x between 3")


# ---- files of LAMMPS -------------------------------------------------------------------------------------------------
SAMPLES = os.path.join(sys.argv[2], "tests", "foreign", "samples", "lammps")
BALANCE = re.compile(r"largest net force (\S+) of the mean; normal forces follow Hertz's law within (\S+)")


def lammps(grains, contacts, *words):
    result = run("convert", os.path.join(SAMPLES, grains), "--contacts", os.path.join(SAMPLES, contacts), "--force", "-o",
                 "l.h5", "--set", "friction=0.5", *words)
    found = BALANCE.search(result.stderr)
    expect(found and float(found[1]) < 1e-6 and float(found[2]) < 1e-10, f"{grains}: {result.stderr}")
    with h5py.File(path("l.h5")) as f:
        return f["sonopack/cell"][()].decode(), f["sonopack/pressure"][()], len(f["sonopack/contacts/overlap"])


def test_lammps_samples():
    """The pressure that LAMMPS printed is the mean of the normal stresses."""
    for name in ("sheared_grains.dump", "sheared.data"):
        cell, pressure, contacts = lammps(name, "sheared_contacts.dump")
        expect(cell == "periodic" and contacts == 238 and abs(pressure / 0.0038357194 - 1) < 1e-7, f"{name}: {pressure}")
    cell, pressure, contacts = lammps("box_grains.dump", "box_contacts.dump")
    expect(cell == "box" and contacts == 86, f"box: {cell} {contacts}")
    said = run("check", "l.h5", "--tolerance", "0.03")
    expect(said.returncode == 0, f"box: friction at walls balances: {said.stdout} {said.stderr}")


# ---- gravity ---------------------------------------------------------------------------------------------------------
def test_gravity():
    """A column of grains under its own weight, held by a floor and a light lid: each contact carries what lies above."""
    from cells import hertz, wall_overlap
    g, n, p = 1e-4, 5, 1e-4
    mass, lid = np.pi / 6, p * 6.0
    force = [lid + mass * g * (n - k) for k in range(n)]  # from the floor upwards; the last is that of the lid + 1 grain
    y, x = [0.5 - wall_overlap(0.5, force[0])], 3.0
    for k in range(1, n):
        overlap = (force[k] / (2 / 3 * np.sqrt(0.25))) ** (2 / 3)
        expect(abs(hertz(0.5, overlap) / force[k] - 1) < 1e-12, "Hertz")
        y.append(y[-1] + 1 - overlap)
    top = y[-1] + 0.5 - wall_overlap(0.5, lid)
    write("a.csv", "# cell = piston\nid,x,y,radius\n" + "".join(f"{k},{x},{float(v)!r},0.5\n" for k, v in enumerate(y)))
    words = ["a.csv", "--set", "width=6", "--set", "bottom=0", "--set", f"top={float(top)!r}", *RIGID]
    found = Imported(*words, "--set", f"gravity={g}")
    expect(abs(found.pressure / p - 1) < 1e-6, f"the pressure is that of the lid: {found.pressure}")
    result = run("convert", *words, "--force", "-o", "b.h5", *FRICTION)
    expect(result.returncode == 0 and "differ" in result.stderr, "without gravity the walls differ")


for test in [value for name, value in list(globals().items()) if name.startswith("test_")]:
    before = len(faults)
    test()
    print("ok" if len(faults) == before else "FAILED", test.__name__)
print(f"{len(faults)} faults" if faults else "import of cells: all fine")
print(*faults, sep="\n")
sys.exit(1 if faults else 0)
