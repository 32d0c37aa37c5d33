"""The page of `sonopack view': its data are those of the other commands, it asks nothing of a network, and refusals leave
nothing behind. tests/foreign/test_view_browser.py opens it.

usage: test_view.py COMMAND SOURCE_DIR
"""
import base64
import hashlib
import html.parser
import json
import pathlib
import re

import h5py
import numpy as np

from cells import box_of_disks, lattice, matrix_of, write_packing
from command import MATERIAL, SOURCE, main, pack, run, table, tried
from common import LOOSE, expect, names_all

TYPES = {"uint8": "u1", "int8": "i1", "int16": "<i2", "uint16": "<u2", "int32": "<i4", "float32": "<f4"}
FLOAT = 6e-8  # relative rounding of a float of 32 bits
NOTHING = ("--no-wave", "--no-modes")


class Page(html.parser.HTMLParser):
    """What a browser would find in the page: its scripts, title, and every attribute."""

    def __init__(self, path):
        super().__init__()
        self.text = pathlib.Path(path).read_text(encoding="utf-8")
        self.open, self.scripts, self.title, self.attributes, self.tags = None, [], "", [], []
        self.feed(self.text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.open = (tag, dict(attrs))
        self.tags.append(tag)
        self.attributes += [(tag, *pair) for pair in attrs]
        if tag == "script":
            self.scripts.append([dict(attrs), ""])

    def handle_endtag(self, tag):
        self.open = None

    def handle_data(self, data):
        if self.open and self.open[0] == "script":
            self.scripts[-1][1] += data
        elif self.open and self.open[0] == "title":
            self.title += data


def refuse_constant(word):
    raise AssertionError(f"{word} in the data")


def unpack(value):
    """JSON with its packed arrays as arrays of np."""
    if isinstance(value, dict) and isinstance(value.get("data"), str) and value.get("type") in TYPES:
        array = np.frombuffer(base64.b64decode(value["data"], validate=True), TYPES[value["type"]])
        return array.reshape(value["shape"])
    if isinstance(value, dict):
        return {key: unpack(part) for key, part in value.items()}
    return [unpack(part) for part in value] if isinstance(value, list) else value


def data_of(page):
    found = [text for attributes, text in page.scripts if attributes.get("id") == "sonopack-data"]
    assert len(found) == 1, f"{len(found)} elements with data"
    return unpack(json.loads(found[0], parse_constant=refuse_constant))


def view(out, *words):
    run("view", *words, "--force", "-o", out)
    page = Page(out)
    data = data_of(page)
    assert data["format"] == "sonopack-view" and data["version"] == 1
    return page, data["packings"]


def near(a, b, relative=FLOAT, absolute=0.0):
    a, b = np.asarray(a, float), np.asarray(b, float)
    return a.shape == b.shape and bool(np.all(np.abs(a - b) <= relative * np.abs(b) + absolute))


# ---- what it shows --------------------------------------------------------------------------------------------------


def check_grains(name, path, shown):
    """Places, contacts and what follows from them, against the file."""
    with h5py.File(path) as f:
        x, r, walls = f["particles/grains/position/value"][0], f["particles/grains/radius"][()], []
        if "sonopack/walls" in f:
            walls = f["sonopack/walls/contacts"][()]
        i, j = np.concatenate([f["connectivity/contacts"][()], walls] if len(walls) else [f["connectivity/contacts"][()]]).T
        n, fn, overlap = (f["sonopack/contacts/" + key][()] for key in ("normal", "normal_force", "overlap"))
    dim = shown["dimension"]
    edges = matrix_of(shown["box"], shown.get("tilt", [0, 0, 0])) if dim > 1 else np.diag(shown["box"])
    expect(near(shown["x"], x, absolute=1e-12) and near(shown["r"], r), f"{name}: places and radii")
    expect(np.array_equal(shown["contact"], np.stack([i, j], 1)) and near(shown["fn"], fn), f"{name}: contacts, forces")
    pairs = j >= 0
    length = (r[i] + np.where(pairs, r[j], 0) - overlap)[:, None] * n
    reached = x[j[pairs]] + shown["image"][pairs] @ edges
    expect(near(x[i[pairs]] + length[pairs], reached, absolute=1e-9), f"{name}: copies of the box")
    points = x[i[~pairs]] + length[~pairs]
    expect(near(shown["wall_point"], points, absolute=1e-5) and len(points) == (~pairs).sum(), f"{name}: points at walls")
    # the pressures of the grains, weighted with their volumes, are the trace of the stress over the dimension
    volume = [None, 2 * r, np.pi * r**2, 4 / 3 * np.pi * r**3][dim]
    total = (fn * (r[i] + np.where(pairs, r[j], 0))).sum()
    expect(near((shown["grain_pressure"] * volume).sum() * dim, total, 1e-6), f"{name}: pressures on grains")
    mine = fn[i == i[0]].sum() + fn[j == i[0]].sum()
    expect(near(shown["grain_pressure"][i[0]], mine * r[i[0]] / (dim * volume[i[0]]), 1e-6), f"{name}: pressure on a grain")
    carried = shown["carrying"].astype(bool)
    counts = np.bincount(i[carried], minlength=len(r)) + np.bincount(j[carried & pairs], minlength=len(r))
    expect(np.array_equal(shown["coordination"], counts), f"{name}: coordination")
    expect(not counts[shown["rattler"].astype(bool)].any() and shown["rattlers"] == shown["rattler"].sum(), f"{name}: rattlers")


def motion(path):
    """Displacements in a table, a column a degree of freedom."""
    lines = [line.split("\t") for line in pathlib.Path(path).read_text().splitlines() if not line.startswith("#")]
    names = [name for name in lines[0] if re.fullmatch("[ur][xyz]", name)]
    rows = np.array([[float(row[lines[0].index(name)]) for name in ("grain", *names)] for row in lines[1:]])
    return rows[:, 0].astype(int), rows[:, 1:]


def check_modes(name, path, shown):
    rows, u = shown["modes"]["rows"], shown["modes"]["u"]
    listed = table("modes", path, "--lowest", len(rows))
    expect(near([row["number"] for row in rows], listed["n"], 0), f"{name}: numbers of modes")
    for key in ("omega", "participation"):
        expect(near([row[key] for row in rows], listed[key], 1e-9), f"{name}: {key}")
    run("modes", path, "--mode", rows[-1]["number"], "--vectors", "v.tsv", "--force", "-o", "m.tsv")
    grain, exact = motion("v.tsv")
    slack = 1e-6 * np.abs(exact).max()
    expect(np.array_equal(shown["grain"], grain) and exact.shape[1] == shown["dof"] == u.shape[2], f"{name}: network")
    expect(near(u[-1], exact, absolute=slack) or near(-u[-1], exact, absolute=slack), f"{name}: displacements of a mode")


def check_wave(name, path, shown):
    wave, dim = shown["wave"], shown["dimension"]
    frames, scale = len(wave["t"]), wave["levels"]
    expect(near(wave["t"], np.linspace(0, wave["until"], frames), 1e-12), f"{name}: times of the frames")
    at = frames // 2
    run("plot", "snapshot", path, "--time", repr(wave["t"][at]), "--table", "u.tsv", "--force", "-o", "u.svg")
    _, exact = motion("u.tsv")
    for k in range(exact.shape[1]):
        size = wave["length" if k < dim else "turn"][at]
        expect(near(wave["u"][at, :, k] * size / scale, exact[:, k], 0, 0.51 * size / scale), f"{name}: {k} of a frame")
    expect(np.abs(wave["u"][at, :, :dim]).max() == scale, f"{name}: the largest displacement has not all levels")
    run("signal", path, "--force", "-o", "signal.tsv")
    signal, shape, front = table("signal", path), wave["signal"], table("front", "signal.tsv")
    expect(near(shape["F"], signal["F"], FLOAT, 2 * shape["error"] + 1e-12 * np.abs(signal["F"]).max()), f"{name}: signal")
    expect(near(shape["until"], signal["t"][-1], 1e-12), f"{name}: end of the signal")
    marks = ("t10", "t_peak", "amplitude")
    expect(near([shape["front"][key] for key in marks], [front[key][0] for key in marks], 1e-6), f"{name}: front")


def scenes():
    """Every kind of packing that there is, and every cell."""
    for name, degrees, keys in (("plane", 3, {"grains": 80, "width": 8}), ("smooth", 2, {"grains": 60, "width": 8, "friction": 0}),
                                ("space", 6, {"dimension": 3, "grains": 90, "width": 5, "protocol": "quick"}),
                                ("chain", 1, {"kind": "chain", "grains": 12})):
        path = pack(f"{name}.h5", **keys)
        page, (shown,) = view(f"{name}.html", path, "--frames", 9, "--lowest", 4)
        expect(shown["name"] == path and path in page.title and shown["dof"] == degrees, f"{name}: {page.title}")
        expect(shown["wave"]["u"].shape[0] == 9 and len(shown["modes"]["rows"]) == 4, f"{name}: modes and frames")
        check_grains(name, path, shown)
        if name in ("plane", "space"):
            check_modes(name, path, shown)
            check_wave(name, path, shown)
    for name, packing in (("tilted", lattice(2, 0.3)), ("sheared", lattice(3, -0.2, cells=4)), ("box", box_of_disks())):
        _, (shown,) = view(f"{name}.html", write_packing(f"{name}.h5", packing), *NOTHING)
        expect(shown["cell"] == packing["cell"] and near(shown["tilt"], packing["tilt"], 1e-15), f"{name}: cell, tilt")
        check_grains(name, f"{name}.h5", shown)


# ---- the file -------------------------------------------------------------------------------------------------------


def alone():
    """The page holds all that it needs: no address of the network, no file beside it; the licence is in it."""
    page, _ = view("alone.html", "plane.h5", *NOTHING)
    addresses = set(re.findall(r"(?:https?|ftp|wss?):?//[\w./-]+", page.text))
    expect(addresses <= {"http://www.w3.org/1999/xhtml"}, f"addresses in the page: {addresses}")
    links = [it for it in page.attributes if it[1] in ("src", "href", "action", "srcset")]
    expect(not links, f"links in the page: {links}")
    own = "".join(text for attributes, text in page.scripts if attributes.get("type") == "module")
    calls = [word for word in ("@import", "url(", "importScripts", "XMLHttpRequest", "fetch(", "WebSocket") if word in own]
    expect(not calls, f"{calls} in the page's own code")
    three = SOURCE / "python/sonopack/view/three"
    for name in ("three.bundle.min.js", "LICENSE"):
        expect((three / name).read_text(encoding="utf-8").strip() in page.text, f"{name} of three.js is not whole")
    for line in (three / "SHA256SUMS").read_text().splitlines():
        digest, name = line.split()
        expect(hashlib.sha256((three / name).read_bytes()).hexdigest() == digest, f"checksum of {name}")
    expect(f"version {run('--version').stdout.split()[-1]}" in page.text, "the page does not name its version")
    expect(not re.search(r"@[A-Z_]+@", page.text), "a marker is left in the page")


def sizes():
    (few,), (many,) = (view(f"{count}.html", "plane.h5", "--frames", count, "--no-modes")[1] for count in (2, 300))
    grown = pathlib.Path("300.html").stat().st_size - pathlib.Path("2.html").stat().st_size
    frame = 2 * few["wave"]["u"][0].size * 4 / 3 + 3 * 25  # and its time and scales
    expect(0.8 < grown / (298 * frame) < 1.05 and many["modes"] is None, f"{grown} bytes for frames of {frame}")
    _, (shown,) = view("large.html", pack("large.h5", kind="triangular", grains=10000, width=100), "--lowest", 2)
    size = pathlib.Path("large.html").stat().st_size
    expect(size < 20e6 and shown["wave"]["u"].shape[0] >= 50, f"10^4 grains: {size} bytes")


def material():
    """A packing whose material is known carries it; the page opens in our own units."""
    glass = {"E": 70e9, "nu": 0.22, "rho": 2500, "d": 1e-3}
    page, (shown,) = view("none.html", "chain.h5", *NOTHING)
    expect(shown["material"] is None and data_of(page)["units"] == "own", "a material that nobody gave")
    page, (shown,) = view("glass.html", "chain.h5", MATERIAL, "--units", "si", "--until", "10 us", "--frames", 3, "--no-modes")
    expect(shown["material"] == glass and data_of(page)["units"] == "si", f"material {shown['material']}")
    expect(near(shown["wave"]["until"], 10e-6 / (1e-3 / (70e9 / (1 - 0.22**2) / 2500) ** 0.5), 1e-12), "10 us")


def several():
    words = ["plane.h5", "chain.h5", "--frames", 3, "--modes", "2:5"]
    page, shown = view("two.html", *words)
    expect([p["name"] for p in shown] == words[:2] and "1 more" in page.title, "two packings")
    expect(len(shown[0]["modes"]["rows"]) == 4 and shown[0]["modes"]["first"] == 2, "--modes 2:5")
    view("again.html", *words)
    expect(pathlib.Path("again.html").read_bytes() == pathlib.Path("two.html").read_bytes(), "the same command, other bytes")


def names():
    """They cannot end an element or a string, whatever letters they have."""
    for name in ("</script><script>alert(1)<!--.h5", "a<b>&\"'@VIEW_DATA@naïve — 粒.h5"):
        path = pathlib.Path(name.replace("/", "∕"))
        path.write_bytes(pathlib.Path("chain.h5").read_bytes())
        page, (shown,) = view("name.html", path, *NOTHING)
        expect(shown["name"] == path.name and path.name in page.title, f"{path.name}: {shown['name']}, {page.title}")
        expect(page.tags.count("script") == 3, f"{path.name}: {page.tags.count('script')} scripts")
    pathlib.Path(b"\xff\xfe.h5".decode("utf-8", "surrogateescape")).write_bytes(pathlib.Path("chain.h5").read_bytes())
    _, (shown,) = view("name.html", b"\xff\xfe.h5".decode("utf-8", "surrogateescape"), *NOTHING)
    expect(shown["name"] == "\ufffd\ufffd.h5", f"a name that is no UTF-8: {shown['name']}")


def loose():
    """Without walls there is no wave: the page says so."""
    pathlib.Path("loose.txt").write_text(LOOSE)
    result = run("view", "loose.txt", "-o", "loose.html")
    (shown,) = data_of(Page("loose.html"))["packings"]
    reason = (shown["wave"] or {}).get("reason", "")
    expect(names_all(reason, "wall pulse") and reason in result.stderr, f"no walls: {shown['wave']}, {result.stderr}")


REFUSED = [  # status, what is named, words; -o page.html behind them
    (1, "wall loose.txt", "loose.txt --frames 5"), (1, "text.h5", "text.h5"), (1, "cut.h5", "cut.h5"),
    (1, "missing.h5", "plane.h5 missing.h5 --no-wave --no-modes"), (2, "FILE", ""), (2, "--modes", "plane.h5 --modes 3:1"),
    (2, "--lowest", "plane.h5 --lowest 0"), (2, "--frames", "plane.h5 --frames 2001"), (2, "--until", "plane.h5 --until nan"),
    (2, "--source", "plane.h5 --source push"), (2, "--lowest --modes", "plane.h5 --lowest 3 --modes 1:2"),
    (2, "--no-wave --frames", "plane.h5 --frames 3 --no-wave"), (2, "packing.grains", "plane.h5 --set packing.grains=10"),
    (2, "modes", "plane.h5 --modes 100:100000"), (2, "--units plane.h5 --material", "plane.h5 --units si")]
OUTPUTS = [("kept.html", "--force", []), ("kept.svg.html", "kept.svg.html", ["--force"]), ("page.svg", "page.svg .html", []),
           ("no/folder.html", "no", []), (None, "-o .html", [])]


def refusals():
    for name, text in (("text.h5", "no packing\n"), ("kept.html", "<p>mine</p>\n"), ("kept.svg.html", "a\tb\n1\t2\n")):
        pathlib.Path(name).write_text(text)
    pathlib.Path("cut.h5").write_bytes(pathlib.Path("plane.h5").read_bytes()[:3000])
    before = {path: path.read_bytes() for path in pathlib.Path().iterdir()}
    cases = [(status, said, [*words.split(), "-o", "page.html"]) for status, said, words in REFUSED]
    cases += [(None, said, ["plane.h5", *more, *(["-o", out] if out else [])]) for out, said, more in OUTPUTS]
    for status, said, words in cases:
        done = tried("view", *words)
        expect(done.returncode == status if status else done.returncode > 0, f"{words}: exit status {done.returncode}")
        expect(names_all(done.stderr, said) and not done.stdout, f"{words}: {done.stderr!r} does not name {said}")
        expect({path: path.read_bytes() for path in pathlib.Path().iterdir()} == before, f"{words}: has written")


main(scenes, alone, sizes, material, several, names, loose, refusals, begun=True)
