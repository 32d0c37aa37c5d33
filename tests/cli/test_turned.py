"""Packings that are turned as a whole, and packings without walls: the same signal or a refusal, and modes.

usage: test_turned.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
REFERENCE = SOURCE / "packings" / "reference" / "packing_N200_p1e-4.txt"


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stderr)
    return done.stdout


def read(path):
    """Comments and rows of words of a table."""
    lines = pathlib.Path(path).read_text().splitlines() if isinstance(path, pathlib.Path) else path.splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    return comments, rows[0], rows[1:]


def columns(text):
    comments, header, rows = read(text)
    table = np.array(rows, float).reshape(-1, len(header))
    return comments, {name: table[:, c] for c, name in enumerate(header)}


class Tables:
    """A packing as two tables, with numbers in place of words."""

    def __init__(self, packing, folder):
        grains, contacts = folder / "grains.tsv", folder / "contacts.tsv"
        for file in (grains, contacts):
            file.unlink(missing_ok=True)
        run("convert", packing, "-q", "--grain-table", grains, "--contact-table", contacts)
        self.keys, self.grain_names, rows = read(grains)
        self.grains = np.array(rows, float)
        comments, self.contact_names, rows = read(contacts)
        self.pairs = [row[:2] for row in rows]
        self.contacts = np.array([row[2:] for row in rows], float)
        self.dim = int(self.keys["dimension"])

    def turned(self, matrix):
        """Positions stay within a box that is large enough; its height sets no number below."""
        from copy import deepcopy
        t, dim = deepcopy(self), self.dim
        x = self.grains[:, 1:1 + dim] @ matrix.T
        x -= x.min(0)
        t.grains[:, 1:1 + dim] = x + 1
        t.contacts[:, :dim] = self.contacts[:, :dim] @ matrix.T
        if dim == 3:
            t.contacts[:, dim + 2:] = self.contacts[:, dim + 2:] @ matrix.T
        return t

    def write(self, folder, name):
        (folder / name).unlink(missing_ok=True)
        grains, contacts, path = folder / "g.tsv", folder / "c.tsv", folder / name
        for file, names, rows in ((grains, self.grain_names, [[f"{v:.17g}" for v in r] for r in self.grains]),
                                  (contacts, self.contact_names,
                                   [p + [f"{v:.17g}" for v in r] for p, r in zip(self.pairs, self.contacts)])):
            head = [f"# {k} = {v}" for k, v in self.keys.items()] if file == grains else []
            file.write_text("\n".join([*head, "\t".join(names), *("\t".join(r) for r in rows)]) + "\n")
        size = max(60, 2 + self.grains[:, 1:1 + self.dim].max())
        depth = ["--set", f"depth={size}"] if self.dim == 3 else []
        run("convert", path, "-q", "--grain-table", grains, "--contact-table", contacts, "--set", f"width={size}", *depth,
            "--set", f"height={size}")
        return path


def turn_2d(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def turn_3d(rng):
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q if np.linalg.det(q) > 0 else -q


def signal(path, *args):
    comments, c = columns(run("signal", path, "--until", 100, *args))
    return comments, c["F"]


def same(path, turned, *args):
    comments, f = signal(path, *args)
    _, g = signal(turned, *args)
    worst = np.abs(f - g).max() / np.abs(f).max()
    assert worst < 1e-9, (turned, args, worst)
    return worst


def walls_turn_with_the_packing(folder, rng):
    flat = Tables(REFERENCE, folder)
    upright = flat.turned(np.eye(2)).write(folder, "upright.h5")
    worst = 0
    for angle in [*rng.uniform(-np.pi, np.pi, 4), np.pi / 2, np.pi, 1e-3, 0.3]:
        turned = flat.turned(turn_2d(angle)).write(folder, "turned.h5")
        for args in [[], ["--prestress"], ["--component", "shear"], ["--source", "displacement"], ["--damping", 0.1],
                     ["--method", "dense"], ["--method", "sparse"]][:7 if angle == 0.3 else 3]:
            worst = max(worst, same(upright, turned, *args))
        for args in (["--detector", "plane:20"], ["--detector", "part:0:20"], ["--method", "dynamics"]):
            run("signal", turned, "--until", 50, *args, status=1)
    # a grain that touches a wall acts along the wall's normal; another has no direction but that of the box
    touching = [int(i) for (i, j), row in zip(flat.pairs, flat.contacts) if j == "bottom" and row[3] > 1e-2 * 1e-4]
    inside = next(i for i in map(int, flat.grains[:, 0]) if 3 < flat.grains[i, 2] < 6 and sum(
        row[3] > 1e-2 * 1e-4 and str(i) in pair for pair, row in zip(flat.pairs, flat.contacts)) > 3)
    worst = max(worst, same(upright, turned, "--from", f"grain:{touching[0]}"))
    run("signal", upright, "--until", 50, "--from", f"grain:{inside}")
    run("signal", turned, "--until", 50, "--from", f"grain:{inside}", status=1)
    run("signal", turned, "--until", 50, "--detector", f"grain:{inside}", status=1)
    print(f"turned packings have the same signal within {worst:.1g} of its largest value")
    # so do their modes and weights
    _, modes = columns(run("modes", upright))
    _, other = columns(run("modes", turned))
    assert np.all(np.abs(modes["omega"] - other["omega"]) <= modes["error"] + other["error"])
    assert np.abs(modes["ab"] - other["ab"]).max() < 1e-6 * np.abs(modes["ab"]).max()


def spheres(folder, rng):
    path = folder / "spheres.h5"
    run("pack", SOURCE / "packings" / "spheres.cfg", "-q", "-o", path, "--set", "packing.grains=60", "--set",
        "packing.width=4", "--set", 'packing.protocol="quick"')
    flat = Tables(path, folder)
    upright = flat.turned(np.eye(3)).write(folder, "upright3.h5")
    for _ in range(2):
        turned = flat.turned(turn_3d(rng)).write(folder, "turned3.h5")
        same(upright, turned)
        same(upright, turned, "--prestress", "--threshold", 0)
        run("signal", turned, "--until", 50, "--component", "shear", status=1)  # no direction along the wall is x
    print("spheres turn too")


def clusters(folder, rng):
    """Without contacts at a wall: modes without amplitudes, the same at any angle, and no signals."""
    whole = Tables(REFERENCE, folder)
    for wall, lost in (("bottom", "a"), ("top", "b"), ("both", "ab")):
        t = whole.turned(np.eye(2))
        keep = [k for k, p in enumerate(t.pairs) if p[1] != wall and (wall != "both" or p[1] not in ("bottom", "top"))]
        t.pairs, t.contacts = [t.pairs[k] for k in keep], t.contacts[keep]
        path = t.write(folder, "cluster.h5")
        comments, m = columns(run("modes", path))
        assert (comments["source"] == "none") == ("a" in lost) and ("detector" in comments) == ("b" in lost)
        for name in "ab":
            assert np.all(np.isnan(m[name])) if name in lost else np.all(np.isfinite(m[name]))
        assert np.all(np.isnan(m["ab"])) and np.all((m["participation"] > 0) & (m["participation"] <= 1 + 1e-12))
        _, part = columns(run("modes", path, "--lowest", 20))
        at = int(part["n"][0])
        assert at == int(comments["zero_modes"])
        assert np.all(np.abs(part["omega"] - m["omega"][at:at + 20]) <= part["error"] + m["error"][at:at + 20])
        for kind in ("dos", "participation"):
            run("spectrum", kind, path)
        for command in (["signal", path, "--until", 10], ["signal", path, "--until", 10, "--method", "dense"],
                        ["spectrum", "transmission", path], ["spectrum", "transmission", path, "--lines"]):
            run(*command, status=1)
        if wall == "both":
            # free: two translations and a rotation cost no energy, if the periodic contacts are cut as well
            x, bonds = t.grains[:, 1:3], [tuple(map(int, p)) for p in t.pairs]
            keep = [k for k, (i, j) in enumerate(bonds) if abs(x[i, 0] - x[j, 0]) < 3]
            t.pairs, t.contacts = [t.pairs[k] for k in keep], t.contacts[keep]
            free, _ = columns(run("modes", t.write(folder, "free.h5")))
            assert int(free["zero_modes"]) - int(free["rattler_modes"]) >= 3
            turned, n = columns(run("modes", t.turned(turn_2d(1)).write(folder, "free1.h5")))
            assert turned["zero_modes"] == free["zero_modes"]
    print("networks without walls have modes, densities of states and participation ratios")


def main():
    seed = np.random.SeedSequence().entropy % 2**32
    print("seed", seed)
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        walls_turn_with_the_packing(folder, rng)
        clusters(folder, rng)
        spheres(folder, rng)


main()
