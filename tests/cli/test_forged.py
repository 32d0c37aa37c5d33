"""sonopack check trusts nothing: forged packings of every cell fail by the check that is named, and honest ones pass.

usage: test_forged.py COMMAND
"""
import pathlib
import tempfile

import h5py
import numpy as np

from cells import box_of_disks, hertz, lattice, wall_overlap, write_packing
from common import names_all
from streams import run, tables

SMALL = ("packing.grains=40", "packing.width=8")
LARGER = ("packing.grains=50", "packing.width=8")
HONEST = {
    "piston": SMALL,
    "smooth": (*SMALL, "packing.friction=0"),
    "faint": (*SMALL, "packing.pressure=1e-7"),
    "hard": (*SMALL, "packing.pressure=1e-2"),
    "heavy": (*SMALL, "packing.gravity=1e-5"),
    "cell": (*LARGER, "packing.cell=periodic", "packing.seed=2"),
    "sheared": (*LARGER, "packing.cell=periodic", "packing.stress=[1e-4,1.2e-4,2e-5]"),
    "box": (*LARGER, "packing.cell=box"),
    "spheres": ("packing.dimension=3", "packing.grains=90", "packing.width=4", "packing.diameter_min=0.95",
                "packing.diameter_max=1"),
    "history": (*SMALL, "packing.history=[1e-3]"),
    "rows": ('packing.kind="triangular"', "packing.grains=15", "packing.width=3"),
    "chain": ('packing.kind="chain"', "packing.grains=5", f"packing.seed={10**15}"),
    "lognormal": (*SMALL, "packing.sizes=lognormal", "packing.protocol=quick"),
    # accelerations 1.2 times as large as the residual says
    "sliding": ("packing.grains=40", "packing.width=6", "packing.protocol=quick", "packing.seed=3"),
}
PATHS = {"x": "/particles/grains/position/value", "r": "/particles/grains/radius", "m": "/particles/grains/mass",
         "pairs": "/connectivity/contacts", "walls": "/sonopack/walls/contacts", "n": "/sonopack/contacts/normal",
         "overlap": "/sonopack/contacts/overlap", "fn": "/sonopack/contacts/normal_force",
         "ft": "/sonopack/contacts/tangential_force", "rattler": "/sonopack/rattler",
         "edges": "/particles/grains/box/edges", "step": "/particles/grains/position/step",
         **{key: "/sonopack/" + key for key in ("pressure", "friction", "poisson", "seed", "steps", "residual", "wall",
                                                "gravity", "cell", "scene")}}


def make(folder):
    for name, sets in HONEST.items():
        run("pack", "-q", "-o", folder / f"{name}.h5", *(word for s in sets for word in ("--set", s)))
        run("convert", "-q", folder / f"{name}.h5", "-o", folder / f"{name}.txt")
    for name, p in (("square", lattice(2)), ("tilted", lattice(2, 0.3)), ("cubic", lattice(3, 0.3)),
                    ("disks", box_of_disks())):
        write_packing(folder / f"{name}.h5", p)
    put(folder / "disks.h5", folder / "own.h5", own_law)
    put(folder / "disks.h5", folder / "massive.h5", massive)
    return sorted(path for path in folder.iterdir() if path.suffix in (".h5", ".txt"))


def put(source, target, change):
    """A copy of the file, with what `change` does to its arrays: {short name: array}."""
    target.write_bytes(source.read_bytes())
    with h5py.File(target, "r+") as file:
        data = {key: file[path][()] for key, path in PATHS.items() if path in file}
        data["x"] = data["x"][0]
        data["file"] = file
        data["ij"] = np.vstack([data["pairs"], data["walls"]]) if "walls" in data else data["pairs"]
        before = {key: np.array(value) for key, value in data.items() if key != "file"}
        change(data)
        for key, path in PATHS.items():
            if key in data and not (np.shape(data[key]) == np.shape(before[key]) and np.all(data[key] == before[key])):
                value = np.asarray(data[key])
                del file[path]
                file[path] = value[np.newaxis] if key == "x" else value


def own_law(d):
    d["file"].attrs["made"] = "by hand"
    d["file"]["/sonopack"].attrs["format"] = np.int32(3)
    d["file"]["/sonopack/contacts/normal_stiffness"] = 1.5 * d["fn"] / d["overlap"]
    d["file"]["/sonopack/contacts/tangential_stiffness"] = d["fn"] / d["overlap"]


def massive(d):
    d["file"]["/particles/grains/mass"] = 2 * 4 / 3 * np.pi * d["r"]**3
    d["file"]["/particles/grains/inertia"] = 0.4 * 2 * 4 / 3 * np.pi * d["r"]**5


# ---- forgeries ----------------------------------------------------------------------------------------------------

def at(key, change, index=None):
    """Changes one array, or one entry: that of the middle contact or grain unless another is given."""
    def forge(d):
        value = np.array(d[key])
        where = () if value.shape == () else len(value) // 2 if index is None else index
        value[where] = change(value[where])
        d[key] = value
    return forge


def strongest(key, change):
    def forge(d):
        at(key, change, int(np.argmax(d["fn"])))(d)
    return forge


def without(d, c):
    """Leaves out contact c."""
    pairs = len(d["pairs"])
    for key in ("n", "overlap", "fn", "ft"):
        d[key] = np.delete(d[key], c, axis=0)
    if c < pairs:
        d["pairs"] = np.delete(d["pairs"], c, axis=0)
    else:
        d["walls"] = np.delete(d["walls"], c - pairs, axis=0)


def drop_strongest(d):
    without(d, int(np.argmax(d["fn"])))


def drop_wall(d):
    without(d, len(d["pairs"]))


def drop_grain_contacts(d):
    """A grain of the force network, left without any contact."""
    i = d["pairs"][int(np.argmax(d["fn"][:len(d["pairs"])]))][0]
    for c in reversed(np.flatnonzero((d["ij"] == i).any(axis=1))):
        without(d, int(c))


def insert(d, x, r, contacts):
    """A further grain, after the others: contacts are (partner, normal from the partner or of the wall, overlap, fn)."""
    n = len(d["r"])
    d["x"], d["r"] = np.vstack([d["x"], x]), np.append(d["r"], r)
    d["m"], d["rattler"] = np.append(d["m"], 4 / 3 * np.pi * r**3), np.append(d["rattler"], np.uint8(1))
    for partner, normal, overlap, fn in contacts:
        if partner >= 0:
            place = int(np.searchsorted(d["pairs"][:, 0], partner, side="right"))
            d["pairs"] = np.insert(d["pairs"], place, (partner, n), axis=0)
        else:
            place = len(d["pairs"]) + int(np.sum(d["walls"][:, 1] >= partner))
            d["walls"] = np.insert(d["walls"], place - len(d["pairs"]), (n, partner), axis=0)
        d["n"] = np.insert(d["n"], place, normal, axis=0)
        d["ft"] = np.insert(d["ft"], place, 0 * np.asarray(normal), axis=0)
        d["overlap"], d["fn"] = np.insert(d["overlap"], place, overlap), np.insert(d["fn"], place, fn)
    if "scene" in d:
        d["scene"] = np.bytes_(d["scene"].replace(b"grains = 40;", b"grains = %d;" % (n + 1)))


def pressing_rattlers(d):
    """Two small grains press on a grain from both sides, and nothing holds them. It stays in balance."""
    r, overlap, width = 0.02, 1e-4, d["edges"][0]
    for i in range(len(d["r"])):
        for angle in np.linspace(0, np.pi, 61):
            sides = np.array([[np.cos(angle), np.sin(angle)], [-np.cos(angle), -np.sin(angle)]])
            x = d["x"][i] + (d["r"][i] + r - overlap) * sides
            apart = np.delete(d["x"], i, axis=0)[:, np.newaxis] - x
            apart[..., 0] -= width * np.round(apart[..., 0] / width)
            free = np.linalg.norm(apart, axis=2) > np.delete(d["r"], i)[:, np.newaxis] + r
            if free.all() and (x > r).all() and (x < d["edges"] - r).all():
                e = 0.5 * np.sqrt(d["r"][i] * r / (d["r"][i] + r))
                for place, normal in zip(x, sides):
                    insert(d, place, r, [(i, normal, overlap, 4 / 3 * e * overlap**1.5)])
                return
    raise AssertionError("no room for small grains")


def through_the_floor(d):
    """A loose grain 0.25 d deep in the floor, which no contact lists."""
    gap = [np.min(np.hypot((d["x"][:, 0] - x + 4) % 8 - 4, d["x"][:, 1] - 0.05) - d["r"])
           for x in np.linspace(0, 8, 801)]
    x = float(np.linspace(0, 8, 801)[int(np.argmax(gap))])
    r = min(0.3, 0.9 * max(gap))
    assert r > 0.05
    insert(d, (x, 0.05), r, [])


def loose_in_another(d):
    """A grain without contacts in the middle of another."""
    insert(d, d["x"][3] + 1e-3, 0.2, [])


def scale(key, factor):
    def forge(d):
        d[key] = np.array(d[key]) * factor
    return forge


def state(key, value):
    def forge(d):
        d[key] = np.asarray(value, dtype=np.asarray(d[key]).dtype)
    return forge


def friction_everywhere(d):
    """Tangential forces at all contacts, just above Coulomb's limit."""
    turn = np.stack([-d["n"][:, 1], d["n"][:, 0]], axis=1)
    d["ft"] = turn * (1.01 * 0.5 * d["fn"])[:, np.newaxis]


def shift(key, by):
    def forge(d):
        d[key] = np.array(d[key]) + by
    return forge


def turned_normal(d):
    c = int(np.argmax(d["fn"]))
    s, co = np.sin(1e-3), np.cos(1e-3)
    d["n"] = np.array(d["n"])
    d["n"][c] = [co * d["n"][c][0] - s * d["n"][c][1], s * d["n"][c][0] + co * d["n"][c][1]]


def twice(d):
    d["pairs"] = np.insert(d["pairs"], 1, d["pairs"][0], axis=0)
    for key in ("n", "overlap", "fn", "ft"):
        d[key] = np.insert(d[key], 1, d[key][0], axis=0)


def text_of_scene(old, new):
    def forge(d):
        assert old.encode() in d["scene"], (old, d["scene"])
        d["scene"] = np.bytes_(d["scene"].replace(old.encode(), new.encode(), 1))
    return forge


def wheel(d):
    """Moments of inertia that no body within the grains has."""
    del d["file"]["/particles/grains/inertia"]
    d["file"]["/particles/grains/inertia"] = 3 * d["m"] * d["r"]**2


def weak_spring(d):
    """A contact of its own law whose normal force pushes no one."""
    at("fn", lambda f: 0 * f)(d)


def empty(d):
    """No contact at all: grains that hang in the air."""
    far = np.arange(len(d["r"]))[:, np.newaxis] * np.array([[0.6, 0.4]])
    d["x"], d["r"] = 0.05 + far % (d["edges"] - 0.1), 0 * d["r"] + 1e-3
    d["m"], d["rattler"] = 4 / 3 * np.pi * d["r"]**3, 0 * d["rattler"] + 1
    for key in ("pairs", "walls", "n", "overlap", "fn", "ft"):
        d[key] = d[key][:0]


FORGED = [
    # name, honest packing, what is done to it, what the check names
    ("rattlers press", "faint", pressing_rattlers, "force"),
    ("through the floor", "piston", through_the_floor, "missing"),
    ("a grain in a grain", "piston", loose_in_another, "missing"),
    ("nothing in contact", "piston", empty, "walls"),
    ("contact left out", "piston", drop_strongest, "missing"),
    ("wall contact left out", "piston", drop_wall, "missing"),
    ("grain without contacts", "piston", drop_grain_contacts, "missing"),
    ("contact of a cell left out", "cell", drop_strongest, "missing"),
    ("contact of spheres left out", "spheres", drop_strongest, "missing"),
    ("contact of a box left out", "box", drop_wall, "missing"),
    ("contact of a tilted lattice left out", "cubic", drop_strongest, "missing"),
    ("contact listed twice", "piston", twice, "twice"),
    ("one force", "piston", strongest("fn", lambda f: 1.01 * f), "law"),
    ("one overlap", "piston", strongest("overlap", lambda o: 1.01 * o), "geometry"),
    ("one normal", "smooth", turned_normal, "geometry"),
    ("one tangential force", "piston", strongest("ft", lambda f: 1.1 * f + 1e-6), "normal"),
    ("all forces", "piston", scale("fn", 1.001), "law"),
    ("all forces of a box", "box", scale("fn", 1.001), "law"),
    ("all forces of an own law", "own", scale("fn", 1.001), "walls"),
    ("a force of an own law", "own", weak_spring, "force"),
    ("all overlaps", "faint", scale("overlap", 1.001), "geometry"),
    ("tangential forces beyond friction", "piston", friction_everywhere, "coulomb"),
    ("tangential forces without friction", "smooth", friction_everywhere, "coulomb"),
    ("no tangential forces", "piston", scale("ft", 0), "force"),
    ("tangential forces turned over", "spheres", scale("ft", -1), "force"),
    ("a grain has moved", "piston", at("x", lambda x: x + 1e-4), "geometry"),
    ("a grain of spheres has moved", "spheres", at("x", lambda x: x + 1e-4), "geometry"),
    ("a grain has grown", "piston", at("r", lambda r: 1.0001 * r), "geometry"),
    ("a grain lies outside", "piston", at("x", lambda x: 0 * x - 1), "-1"),
    ("a radius is negative", "piston", at("r", lambda r: -r), "radius"),
    ("a radius is no number", "piston", at("r", lambda r: np.nan * r), "nan"),
    ("pressure", "piston", scale("pressure", 1.01), "walls"),
    ("pressure of a cell", "cell", scale("pressure", 1.001), "walls"),
    ("pressure of a box", "box", scale("pressure", 1.001), "walls"),
    ("height", "piston", lambda d: at("edges", lambda e: e + 1e-3, 1)(d), "geometry"),
    ("width", "piston", lambda d: at("edges", lambda e: e + 1e-3, 0)(d), "geometry"),
    ("edge of a cell", "square", lambda d: at("edges", lambda e: e * 1.001, 0)(d), "geometry"),
    ("gravity", "heavy", scale("gravity", 1.1), "force"),
    ("friction", "piston", state("friction", 5.0), "/sonopack/friction"),
    ("less friction", "piston", state("friction", 0.01), "coulomb"),
    ("Poisson's ratio", "piston", state("poisson", 0.3), "/sonopack/poisson"),
    ("seed", "piston", state("seed", 12), "/sonopack/seed"),
    ("large seed", "chain", state("seed", 10**15 + 1), "/sonopack/seed"),  # 1e-15 away
    ("wall", "piston", lambda d: d.update(wall=np.bytes_("grain")), "law"),
    ("residual", "faint", state("residual", 1e-20), "/sonopack/residual"),
    ("infinite residual", "piston", state("residual", np.inf), "/sonopack/residual"),
    ("negative residual", "piston", state("residual", -1.0), "/sonopack/residual"),
    ("steps", "piston", state("steps", 3), "/particles/grains/position/step"),
    ("rattlers", "piston", at("rattler", lambda x: 1 - x), "/sonopack/rattler"),
    ("masses", "piston", at("m", lambda m: 2 * m), "/particles/grains/mass"),
    ("inertia", "massive", wheel, "inertia"),
    ("scene's pressure", "piston", text_of_scene("pressure = 0.0001", "pressure = 0.001"), "/sonopack/pressure"),
    ("scene's friction", "piston", text_of_scene("friction = 0.5", "friction = 0.4"), "/sonopack/friction"),
    ("scene's width", "piston", text_of_scene("width = 8", "width = 9"), "width"),
    ("scene's grains", "cell", text_of_scene("grains = 50", "grains = 60"), "grains"),
]


def column_of(words):
    """Grains one above the other in a cell of any width: each touches those above and below."""
    width, r, count, p = words["width"], words["r"], words["count"], 1e-4
    force = p * width
    overlap = (force / (2 / 3 * np.sqrt(r / 2)))**(2 / 3)
    wall = wall_overlap(r, force)
    assert abs(hertz(r, overlap) - force) < 1e-12
    y = r - wall + (2 * r - overlap) * np.arange(count)
    height = y[-1] + r - wall
    lines = [f"N {count} Lx {width} Ly {height!r} p {p} mu 0.5 nu 0 contacts {count - 1} bottom 1 top 1"]
    lines += [f"{0.5 * width} {v!r} {r} 0" for v in map(float, y)]
    lines += [f"{i} {i + 1} 0 1 {overlap!r} {force!r} 0" for i in range(count - 1)]
    lines += [f"0 -1 0 -1 {wall!r} {force!r} 0", f"{count - 1} -2 0 1 {wall!r} {force!r} 0"]
    return "\n".join(lines) + "\n"


def two_at_the_walls(_):
    """One grain at each wall carries the whole load, and nothing is between them."""
    p, width, r, height = 1e-4, 4, 0.5, 6
    force = p * width
    wall = wall_overlap(r, force)
    return (f"N 2 Lx {width} Ly {height} p {p} mu 0.5 nu 0 contacts 0 bottom 1 top 1\n"
            f"2 {r - wall!r} {r} 0\n2 {height - r + wall!r} {r} 0\n"
            f"0 -1 0 -1 {wall!r} {force!r} 0\n1 -2 0 1 {wall!r} {force!r} 0\n")


def second_image(_):
    """Two grains side by side in a narrow cell overlap on both sides, and one contact is listed."""
    return ("N 2 Lx 1.5 Ly 5 p 1e-4 mu 0.5 nu 0 contacts 1 bottom 0 top 0\n"
            f"0.3 2 0.5 0\n1.05 2 0.5 0\n0 1 1 0 0.25 {hertz(0.5, 0.25)!r} 0\n")


BY_HAND = [
    # a column stands as it should where it is wide enough
    ("own image", column_of, {"width": 0.7, "r": 0.5, "count": 4}, "missing"),
    ("wide enough", column_of, {"width": 1.3, "r": 0.5, "count": 4}, None),
    ("second image", second_image, {}, "missing"),
    ("load at the walls alone", two_at_the_walls, {}, "force"),
]


def verdicts(paths, status):
    done = run("check", "-q", *paths, status=status)
    ((_, names, rows),) = tables(done.stdout)
    return [dict(zip(names, row)) for row in rows]


def names(row, what):
    """Whether the row fails by the column of that name, or names this word."""
    return row["ok"] == "no" and (float(row[what]) > 2e-5 if what in row else names_all(row["reason"], what))


def main():
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        honest = make(folder)
        bad = [row for row in verdicts(honest, 0) if row["ok"] != "yes"]
        assert len(honest) >= 30 and not bad, bad
        false = folder / "false"
        false.mkdir()
        said = {}
        for k, (name, source, forge, what) in enumerate(FORGED):
            put(folder / f"{source}.h5", false / f"{k:02}.h5", forge)
            said[str(false / f"{k:02}.h5")] = name, what
        for k, (name, write, words, what) in enumerate(BY_HAND):
            (false / f"hand{k}.txt").write_text(write(words))
            said[str(false / f"hand{k}.txt")] = name, what
        wrong = [(said[row["file"]], row) for row in verdicts(sorted(said), 1)
                 if not (names(row, said[row["file"]][1]) if said[row["file"]][1] else row["ok"] == "yes")]
        assert not wrong, "\n".join(map(str, wrong))


main()
