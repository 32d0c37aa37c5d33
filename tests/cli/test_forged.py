"""check trusts nothing: packings in which any one number is false are refused, so are those that are false as a whole,
and honest ones of every cell pass.

usage: test_forged.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil

import h5py
import numpy as np

from cells import box_of_disks, hertz, lattice, wall_overlap, write_packing
from command import Table, main, pack, run, tried
from common import expect
from forging import WAYS, forge, numbers_of

SMALL, LARGER = {"grains": 40, "width": 8}, {"grains": 50, "width": 8}
HONEST = {
    "piston": SMALL,
    "smooth": {**SMALL, "friction": 0},
    "faint": {**SMALL, "pressure": 1e-7},
    "hard": {**SMALL, "pressure": 1e-2},
    "heavy": {**SMALL, "gravity": 1e-5},
    "cell": {**LARGER, "cell": "periodic", "seed": 2},
    "sheared": {**LARGER, "cell": "periodic", "stress": "[1e-4,1.2e-4,2e-5]"},
    "box": {**LARGER, "cell": "box"},
    "spheres": {"dimension": 3, "grains": 90, "width": 4, "diameter_min": 0.95, "diameter_max": 1},
    "history": {**SMALL, "history": "[1e-3]"},
    "rows": {"kind": "triangular", "grains": 15, "width": 3},
    "chain": {"kind": "chain", "grains": 5, "seed": 10**15},
    "lognormal": {**SMALL, "sizes": "lognormal", "protocol": "quick"},
    # accelerations 1.2 times as large as the residual says
    "sliding": {"grains": 40, "width": 6, "protocol": "quick", "seed": 3},
}
LATTICES = {"square": lattice(2), "tilted": lattice(2, 0.3), "cubic": lattice(3, 0.3), "disks": box_of_disks()}
# one of every cell; of what is made by hand no scene says what its friction, say, must be
FORGED = "piston", "smooth", "heavy", "sheared", "box", "spheres", "chain"
# the time says nothing; how far from rest a packing was made is a bound, which may be larger or not known
UNSAID = {("particles/grains/position/time", way) for way in WAYS} | {("sonopack/residual", way) for way in ("more", "nan")}
PATHS = {"x": "/particles/grains/position/value", "r": "/particles/grains/radius", "m": "/particles/grains/mass",
         "pairs": "/connectivity/contacts", "walls": "/sonopack/walls/contacts", "n": "/sonopack/contacts/normal",
         "overlap": "/sonopack/contacts/overlap", "fn": "/sonopack/contacts/normal_force",
         "ft": "/sonopack/contacts/tangential_force", "rattler": "/sonopack/rattler",
         "edges": "/particles/grains/box/edges", "step": "/particles/grains/position/step",
         **{key: "/sonopack/" + key for key in ("pressure", "friction", "poisson", "seed", "steps", "residual", "wall",
                                                "gravity", "cell", "scene")}}



def verdicts(paths, status):
    done = run("check", "-q", *paths, status=status)
    found = Table(done.stdout)
    return [dict(zip(found.names, row)) for row in found.rows]


def honest():
    for name, keys in HONEST.items():
        pack(f"{name}.h5", **keys)
        pack(f"{name}.txt", **keys)
    for name, p in LATTICES.items():
        write_packing(f"{name}.h5", p)
    put("disks.h5", "own.h5", own_law)
    put("disks.h5", "massive.h5", massive)
    paths = sorted(path for path in pathlib.Path().iterdir() if path.suffix in (".h5", ".txt"))
    bad = [row for row in verdicts(paths, 0) if row["ok"] != "yes"]
    assert len(paths) >= 30 and not bad, bad


def every_number():
    """Of the strongest contact, of a grain in the middle, of the packing: larger, negative, zero, and none."""
    cases = {}
    pathlib.Path("false").mkdir()
    for name in FORGED:
        with h5py.File(f"{name}.h5") as file:
            contacts = {path for path in (PATHS["n"], PATHS["overlap"], PATHS["fn"], PATHS["ft"]) if path in file}
            strongest = int(np.argmax(file[PATHS["fn"]][()]))
        for dataset in numbers_of(f"{name}.h5", "particles", "connectivity", "sonopack"):
            for way in WAYS:
                path = shutil.copy(f"{name}.h5", f"false/{len(cases):04}.h5")
                if (dataset, way) not in UNSAID and forge(path, dataset, way, strongest if "/" + dataset in contacts else None):
                    cases[path] = name, dataset, way
                else:
                    pathlib.Path(path).unlink()
    assert len(cases) > 400, len(cases)
    for row in verdicts(sorted(cases), 1):
        expect(row["ok"] == "no" and row["reason"] != "-", f"{cases[row['file']]}: {row}")
    print(f"{len(cases)} false numbers")


def put(source, target, change):
    """A copy of the file, with what `change` does to its arrays: {short name: array}."""
    shutil.copy(source, target)
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


# ---- false as a whole ------------------------------------------------------------------------------------------------

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


def friction_everywhere(d):
    """Tangential forces at all contacts, just above Coulomb's limit."""
    turn = np.stack([-d["n"][:, 1], d["n"][:, 0]], axis=1)
    d["ft"] = turn * (1.01 * 0.5 * d["fn"])[:, np.newaxis]


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


def empty(d):
    """No contact at all: grains that hang in the air."""
    far = np.arange(len(d["r"]))[:, np.newaxis] * np.array([[0.6, 0.4]])
    d["x"], d["r"] = 0.05 + far % (d["edges"] - 0.1), 0 * d["r"] + 1e-3
    d["m"], d["rattler"] = 4 / 3 * np.pi * d["r"]**3, 0 * d["rattler"] + 1
    for key in ("pairs", "walls", "n", "overlap", "fn", "ft"):
        d[key] = d[key][:0]


WHOLE = [
    # honest packing, what is done to it, what the check names: a measure, or a word of the reason
    ("faint", pressing_rattlers, "force"), ("piston", through_the_floor, "missing"), ("piston", loose_in_another, "missing"),
    ("piston", empty, "walls"), ("piston", drop_strongest, "missing"), ("piston", drop_wall, "missing"),
    ("piston", drop_grain_contacts, "missing"), ("cell", drop_strongest, "missing"), ("spheres", drop_strongest, "missing"),
    ("box", drop_wall, "missing"), ("cubic", drop_strongest, "missing"), ("piston", twice, "twice"),
    ("piston", scale("fn", 1.001), "law"), ("box", scale("fn", 1.001), "law"), ("own", scale("fn", 1.001), "walls"),
    ("own", lambda d: d.update(fn=np.where(np.arange(len(d["fn"])) == 9, 0, d["fn"])), "force"),
    ("faint", scale("overlap", 1.001), "geometry"), ("cell", scale("pressure", 1.001), "walls"),
    ("piston", friction_everywhere, "coulomb"), ("smooth", friction_everywhere, "coulomb"),
    ("piston", scale("ft", 0), "force"), ("spheres", scale("ft", -1), "force"),
    ("piston", lambda d: d.update(wall=np.bytes_("grain")), "law"), ("massive", wheel, "inertia"),
    ("piston", text_of_scene("pressure = 0.0001", "pressure = 0.001"), "/sonopack/pressure"),
    ("piston", text_of_scene("friction = 0.5", "friction = 0.4"), "/sonopack/friction"),
    ("piston", text_of_scene("width = 8", "width = 9"), "width"), ("cell", text_of_scene("grains = 50", "grains = 60"), "grains"),
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
    (column_of, {"width": 0.7, "r": 0.5, "count": 4}, "missing"), (column_of, {"width": 1.3, "r": 0.5, "count": 4}, None),
    (second_image, {}, "missing"), (two_at_the_walls, {}, "force"),
]


def false_as_a_whole():
    cases = {}
    for k, (source, change, what) in enumerate(WHOLE):
        put(f"{source}.h5", f"w{k:02}.h5", change)
        cases[f"w{k:02}.h5"] = k, what
    for k, (write, words, what) in enumerate(BY_HAND):
        pathlib.Path(f"w{k}.txt").write_text(write(words))
        cases[f"w{k}.txt"] = k, what
    for row in verdicts(sorted(cases), 1):
        k, what = cases[row["file"]]
        named = what is None or (float(row[what]) > 2e-5 if what in row else what in row["reason"])
        expect((row["ok"] == "no") == (what is not None) and named, f"{row}, must name {what}")


def headers():
    """Of a text, whose numbers are read otherwise."""
    lines = pathlib.Path("piston.txt").read_text().split("\n")
    words = lines[1].split()
    for key in ("N", "Lx", "Ly", "p", "mu", "contacts", "bottom", "top"):
        for value in ("nan", "-1", "0", "1e9"):
            head = list(words)
            head[head.index(key) + 1] = value
            pathlib.Path("h.txt").write_text("\n".join([lines[0], " ".join(head), *lines[2:]]))
            if key != "mu" or value != "1e9":
                expect(tried("check", "h.txt").returncode == 1, f"{key} {value}")


main(honest, every_number, false_as_a_whole, headers)
