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
import subprocess
import sys
import tempfile

import h5py
import numpy

from cells import box_of_disks, lattice, matrix_of, write_packing
from common import LOOSE, expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
TYPES = {"uint8": "u1", "int8": "i1", "int16": "<i2", "uint16": "<u2", "int32": "<i4", "float32": "<f4"}
FLOAT = 6e-8  # relative rounding of a float of 32 bits


def run(*arguments):
    return subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, timeout=1200,
                          stdin=subprocess.DEVNULL)


def must(*arguments):
    result = run(*arguments)
    assert result.returncode == 0, f"{' '.join(map(str, arguments))}: {result.returncode}: {result.stderr}"
    return result


def pack(path, **keys):
    sets = [word for key, value in keys.items() for word in ("--set", f"packing.{key}={value}")]
    must("pack", "-q", *sets, "-o", path)
    return path


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
    """JSON with its packed arrays as arrays of numpy."""
    if isinstance(value, dict) and isinstance(value.get("data"), str) and value.get("type") in TYPES:
        array = numpy.frombuffer(base64.b64decode(value["data"], validate=True), TYPES[value["type"]])
        return array.reshape(value["shape"])
    if isinstance(value, dict):
        return {key: unpack(part) for key, part in value.items()}
    return [unpack(part) for part in value] if isinstance(value, list) else value


def data_of(page):
    found = [text for attributes, text in page.scripts if attributes.get("id") == "sonopack-data"]
    assert len(found) == 1, f"{len(found)} elements with data"
    return unpack(json.loads(found[0], parse_constant=refuse_constant))


def view(out, *arguments):
    must("view", *arguments, "-o", out)
    page = Page(out)
    data = data_of(page)
    expect(data["format"] == "sonopack-view" and data["version"] == 1, "format of the data")
    return page, data["packings"]


def number(word):
    try:
        return float(word)
    except ValueError:
        return numpy.nan # a name


def table(path):
    rows = [line for line in pathlib.Path(path).read_text().splitlines() if not line.startswith("#")]
    values = numpy.array([[number(x) for x in row.split("\t")] for row in rows[1:]])
    return dict(zip(rows[0].split("\t"), values.T))


def printed(scratch, *arguments):
    path = scratch / "printed.tsv"
    must(*arguments, "--force", "-o", path)
    return table(path)


def near(a, b, relative=FLOAT, absolute=0.0):
    a, b = numpy.asarray(a, float), numpy.asarray(b, float)
    return a.shape == b.shape and bool(numpy.all(numpy.abs(a - b) <= relative * numpy.abs(b) + absolute))


# ---- what it shows --------------------------------------------------------------------------------------------------


def check_grains(scratch, name, path, shown):
    """Places, contacts and what follows from them, against the exported tables."""
    tables = [scratch / f"{name}-grains.tsv", scratch / f"{name}-contacts.tsv"]
    must("convert", path, "--grain-table", tables[0], "--contact-table", tables[1])
    grains, dim = table(tables[0]), shown["dimension"]
    rows = [line.split("\t") for line in tables[1].read_text().splitlines() if not line.startswith("#")]
    head, rows = rows[0], rows[1:]
    column = {key: [row[k] for row in rows] for k, key in enumerate(head)}
    walls = {"bottom": -1, "top": -2, "left": -3, "right": -4, "front": -5, "back": -6}
    edges = matrix_of(shown["box"], shown.get("tilt", [0, 0, 0])) if dim > 1 else numpy.diag(shown["box"])
    i = numpy.array([int(x) for x in column["i"]])
    j = numpy.array([walls[x] if x in walls else int(x) for x in column["j"]])
    n = numpy.array([[float(x) for x in column[f"n{axis}"]] for axis in "xyz"[:dim]]).T
    fn, overlap = (numpy.array([float(x) for x in column[key]]) for key in ("Fn", "overlap"))
    x = numpy.array([grains[axis] for axis in "xyz"[:dim]]).T
    r = grains["radius"]
    expect(near(shown["x"], x, absolute=1e-12) and near(shown["r"], r), f"{name}: places and radii")
    expect(numpy.array_equal(shown["contact"], numpy.stack([i, j], 1)), f"{name}: contacts")
    expect(near(shown["fn"], fn), f"{name}: forces")
    pairs = j >= 0
    length = (r[i] + numpy.where(pairs, r[j], 0) - overlap)[:, None] * n
    reached = x[j[pairs]] + shown["image"][pairs] @ edges
    expect(near(x[i[pairs]] + length[pairs], reached, absolute=1e-9), f"{name}: copies of the box")
    points = x[i[~pairs]] + length[~pairs]
    expect(near(shown["wall_point"], points, absolute=1e-5) and len(points) == (~pairs).sum(), f"{name}: points at walls")
    wall = {-1: (dim - 1, 0), -2: (dim - 1, 1), -3: (0, 0), -4: (0, 1), -5: (1, 0), -6: (1, 1)}
    expect(all(abs(p[wall[k][0]] - wall[k][1] * shown["box"][wall[k][0]]) < 1e-6 for p, k in zip(points, j[~pairs])),
           f"{name}: walls")
    # the pressures of the grains, weighted with their volumes, are the trace of the stress over the dimension
    volume = [None, 2 * r, numpy.pi * r**2, 4 / 3 * numpy.pi * r**3][dim]
    total = (fn * (r[i] + numpy.where(pairs, r[j], 0))).sum()
    expect(near((shown["grain_pressure"] * volume).sum() * dim, total, 1e-6), f"{name}: pressures on grains")
    one = i[0]
    mine = fn[i == one].sum() + fn[j == one].sum()
    expect(near(shown["grain_pressure"][one], mine * r[one] / (dim * volume[one]), 1e-6), f"{name}: pressure on a grain")
    carried = shown["carrying"].astype(bool)
    counts = numpy.bincount(i[carried], minlength=len(r)) + numpy.bincount(j[carried & pairs], minlength=len(r))
    expect(numpy.array_equal(shown["coordination"], counts), f"{name}: coordination")
    expect(not counts[shown["rattler"].astype(bool)].any() and shown["rattlers"] == shown["rattler"].sum(),
           f"{name}: rattlers")


def check_modes(scratch, name, path, shown):
    rows, u, dof = shown["modes"]["rows"], shown["modes"]["u"], shown["dof"]
    listed = printed(scratch, "modes", path, "--lowest", len(rows))
    expect(near([row["number"] for row in rows], listed["n"], 0), f"{name}: numbers of modes")
    for key in ("omega", "participation"):
        expect(near([row[key] for row in rows], listed[key], 1e-9), f"{name}: {key}")
    must("modes", path, "--mode", rows[-1]["number"], "--vectors", scratch / "v.tsv", "--force", "-o", scratch / "m.tsv")
    vector = table(scratch / "v.tsv")
    expect(numpy.array_equal(shown["grain"], vector["grain"]), f"{name}: grains of the network")
    keys = [key for key in ("ux", "uy", "uz", "rx", "ry", "rz") if key in vector]
    expect(len(keys) == dof == u.shape[2], f"{name}: degrees of freedom")
    exact = numpy.array([vector[key] for key in keys]).T
    slack = 1e-6 * numpy.abs(exact).max()
    expect(near(u[-1], exact, absolute=slack) or near(-u[-1], exact, absolute=slack), f"{name}: displacements of a mode")


def check_wave(scratch, name, path, shown):
    wave, dim = shown["wave"], shown["dimension"]
    frames, scale = len(wave["t"]), wave["levels"]
    expect(near(wave["t"], numpy.linspace(0, wave["until"], frames), 1e-12), f"{name}: times of the frames")
    frame = frames // 2
    must("plot", "snapshot", path, "--time", repr(wave["t"][frame]), "--table", scratch / "u.tsv", "--force", "-o",
         scratch / "u.svg")
    exact = table(scratch / "u.tsv")
    keys = [key for key in ("ux", "uy", "uz", "rx", "ry", "rz") if key in exact]
    for k, key in enumerate(keys):
        size = wave["length" if k < dim else "turn"][frame]
        expect(near(wave["u"][frame, :, k] * size / scale, exact[key], 0, 0.51 * size / scale), f"{name}: {key} of a frame")
    largest = numpy.abs(wave["u"][frame, :, :dim]).max()
    expect(largest == scale, f"{name}: the largest displacement has {largest} of {scale} levels")
    must("signal", path, "--force", "-o", scratch / "signal.tsv")
    signal = table(scratch / "signal.tsv")
    shape = wave["signal"]
    expect(near(shape["F"], signal["F"], FLOAT, 2 * shape["error"] + 1e-12 * numpy.abs(signal["F"]).max()),
           f"{name}: signal")
    expect(near(shape["until"], signal["t"][-1], 1e-12), f"{name}: end of the signal")
    front = printed(scratch, "front", scratch / "signal.tsv")
    expect(near([shape["front"][key] for key in ("t10", "t_peak", "amplitude")],
                [front[key][0] for key in ("t10", "t_peak", "amplitude")], 1e-6), f"{name}: front")


def check_scenes(scratch):
    """Every kind of packing that there is."""
    made = {"plane": pack(scratch / "plane.h5", grains=80, width=8),
            "smooth": pack(scratch / "smooth.h5", grains=60, width=8, friction=0),
            "space": pack(scratch / "space.h5", dimension=3, grains=90, width=5, protocol='"quick"'),
            "chain": pack(scratch / "chain.h5", kind='"chain"', grains=12),
            "wide": pack(scratch / "wide.h5", grains=150, width=40, protocol='"quick"')}
    degrees = {"plane": 3, "smooth": 2, "space": 6, "chain": 1, "wide": 3}
    for name, path in made.items():
        page, (shown,) = view(scratch / f"{name}.html", path, "--frames", 9, "--lowest", 4)
        expect(shown["name"] == path.name and path.name in page.title, f"{name}: title {page.title}")
        expect(shown["dof"] == degrees[name], f"{name}: {shown['dof']} degrees of freedom")
        if name != "chain": # tables of grains are of two or three dimensions
            check_grains(scratch, name, path, shown)
        if name in ("plane", "space"):
            check_modes(scratch, name, path, shown)
            check_wave(scratch, name, path, shown)
        expect(shown["wave"]["u"].shape[0] == 9 and len(shown["modes"]["rows"]) == 4, f"{name}: modes and frames")
    return made


def check_cells(scratch):
    """Periodic cells, tilted ones, and boxes: places, contacts and copies of the cell."""
    for name, packing in (("tilted", lattice(2, 0.3)), ("sheared", lattice(3, -0.2, cells=4)), ("box", box_of_disks())):
        path = pathlib.Path(write_packing(str(scratch / f"{name}.h5"), packing))
        _, (shown,) = view(scratch / f"{name}.html", path, "--no-modes", "--no-wave")
        expect(shown["cell"] == packing["cell"] and near(shown["tilt"], packing["tilt"], 1e-15), f"{name}: cell, tilt")
        check_grains(scratch, name, path, shown)


# ---- the file -------------------------------------------------------------------------------------------------------


def check_alone(scratch):
    """The page holds all that it needs: no address of the network, no file beside it; the licence is in it."""
    page, _ = view(scratch / "alone.html", scratch / "plane.h5", "--no-wave", "--no-modes")
    addresses = set(re.findall(r"(?:https?|ftp|wss?):?//[\w./-]+", page.text))
    expect(addresses <= {"http://www.w3.org/1999/xhtml"}, f"addresses in the page: {addresses}")
    for tag, key, value in page.attributes:
        expect(key not in ("src", "href", "action", "srcset"), f"<{tag} {key}={value}>")
    for word in ("@import", "url(", "importScripts", "XMLHttpRequest", "fetch(", "WebSocket"):
        own = "".join(text for attributes, text in page.scripts if attributes.get("type") == "module")
        expect(word not in own, f"{word} in the page's own code")
    three = SOURCE / "python" / "sonopack" / "view" / "three"
    expect((three / "three.bundle.min.js").read_text(encoding="utf-8").strip() in page.text, "three.js is not whole")
    expect((three / "LICENSE").read_text(encoding="utf-8").strip() in page.text, "the licence of three.js is missing")
    for line in (three / "SHA256SUMS").read_text().splitlines():
        digest, name = line.split()
        expect(hashlib.sha256((three / name).read_bytes()).hexdigest() == digest, f"checksum of {name}")
    version = must("--version").stdout.split()[-1]
    expect(f"version {version}" in page.text, "the page does not name its version")
    expect(not re.search(r"@[A-Z_]+@", page.text), "a marker is left in the page")


def check_sizes(scratch):
    _, (few,) = view(scratch / "few.html", scratch / "plane.h5", "--frames", 2, "--no-modes")
    _, (many,) = view(scratch / "many.html", scratch / "plane.h5", "--frames", 300, "--no-modes")
    sizes = [(scratch / name).stat().st_size for name in ("few.html", "many.html")]
    frame = 2 * few["wave"]["u"][0].size * 4 / 3 + 3 * 25 # and its time and scales
    expect(0.8 < (sizes[1] - sizes[0]) / (298 * frame) < 1.05, f"sizes {sizes}, a frame of {frame}")
    expect(many["wave"]["u"].shape[0] == 300 and many["modes"] is None, "parts that were not asked for")
    large = pack(scratch / "large.h5", kind='"triangular"', grains=10000, width=100)
    _, (shown,) = view(scratch / "large.html", large, "--lowest", 2)
    size = (scratch / "large.html").stat().st_size
    expect(size < 20e6 and shown["wave"]["u"].shape[0] >= 50, f"10^4 grains: {size} bytes")


def check_material(scratch):
    """A packing whose material is known carries it; the page opens in our own units."""
    path = pack(scratch / "glass.h5", kind='"chain"', grains=8)
    page, (shown,) = view(scratch / "none.html", path, "--no-wave", "--no-modes")
    expect(shown["material"] is None and data_of(page)["units"] == "own", "a material that nobody gave")
    with h5py.File(path, "r+") as file:
        for name, value in (("young", 70e9), ("poisson", 0.22), ("density", 2500.0), ("diameter", 1e-3)):
            file[f"/sonopack/material/{name}"] = value
    glass = {"E": 70e9, "nu": 0.22, "rho": 2500, "d": 1e-3}
    page, (shown,) = view(scratch / "glass.html", path, "--units", "si", "--until", "10 us", "--frames", 3, "--no-modes")
    expect(shown["material"] == glass and data_of(page)["units"] == "si", f"material {shown['material']}")
    time = 1e-3 / (70e9 / (1 - 0.22**2) / 2500) ** 0.5
    expect(near(shown["wave"]["until"], 10e-6 / time, 1e-12), f"10 us are {shown['wave']['until']}")
    _, (shown,) = view(scratch / "given.html", scratch / "plane.h5", "--material", "E=70e9,nu=0.22,rho=2500,d=1e-3",
                       "--no-wave", "--no-modes")
    expect(shown["material"] == glass, f"--material: {shown['material']}")
    refused(scratch, 2, "--units plane.h5 --material", scratch / "plane.h5", "--units", "si")


def check_several(scratch):
    first, second = scratch / "plane.h5", scratch / "chain.h5"
    page, shown = view(scratch / "two.html", first, second, "--frames", 3, "--modes", "2:5")
    expect([p["name"] for p in shown] == [first.name, second.name] and "1 more" in page.title, "two packings")
    _, (all_of,) = view(scratch / "all.html", first, "--lowest", 6, "--no-wave")
    for k, row in enumerate(shown[0]["modes"]["rows"]):
        expect(near(row["omega"], all_of["modes"]["rows"][2 + k]["omega"], 1e-9), f"mode {2 + k} of --modes 2:5")
    expect(len(shown[0]["modes"]["rows"]) == 4 and shown[0]["modes"]["first"] == 2, "--modes 2:5")
    must("view", first, second, "--frames", 3, "--modes", "2:5", "-o", scratch / "again.html")
    expect((scratch / "again.html").read_bytes() == (scratch / "two.html").read_bytes(), "the same command, other bytes")


def check_names(scratch):
    """Names cannot end an element or a string, whatever letters they have."""
    for name in ("a<b>&\"'c.h5", "</script><script>alert(1)<!--.h5", "naïve — 粒.h5", "@VIEW_DATA@.h5"):
        path = scratch / name.replace("/", "∕")
        path.write_bytes((scratch / "chain.h5").read_bytes())
        page, (shown,) = view(scratch / "name.html", path, "--no-modes", "--no-wave", "--force")
        expect(shown["name"] == path.name and path.name in page.title, f"{path.name}: {shown['name']}, {page.title}")
        expect(page.tags.count("script") == 3, f"{path.name}: {page.tags.count('script')} scripts")
    wrong = bytes(scratch) + b"/\xff\xfe.h5"
    pathlib.Path(wrong.decode("utf-8", "surrogateescape")).write_bytes((scratch / "chain.h5").read_bytes())
    result = subprocess.run([COMMAND, "view", wrong, "--no-wave", "--no-modes", "--force", "-o", scratch / "name.html"],
                            capture_output=True)
    expect(result.returncode == 0 and data_of(Page(scratch / "name.html"))["packings"][0]["name"] == "\ufffd\ufffd.h5",
           f"a name that is no UTF-8: {result}")


# ---- what is missing, and refusals ----------------------------------------------------------------------------------


def check_loose(scratch):
    """Without walls there is no wave: the page says so."""
    path = scratch / "loose.txt"
    path.write_text(LOOSE)
    result = must("view", path, "-o", scratch / "loose.html")
    (shown,) = data_of(Page(scratch / "loose.html"))["packings"]
    reason = (shown["wave"] or {}).get("reason", "")
    expect(names_all(reason, "wall pulse") and reason in result.stderr, f"no walls: {shown['wave']}, {result.stderr}")
    refused(scratch, 1, "wall loose.txt", path, "--frames", 5)


def refused(scratch, status, reason, *arguments, out="refused.html"):
    path = scratch / out
    before = path.read_bytes() if path.is_file() else None
    result = run("view", *arguments, "-o", path)
    words = " ".join(map(str, arguments))
    expect(result.returncode == status, f"view {words}: exit status {result.returncode}, not {status}: {result.stderr}")
    expect(names_all(result.stderr, reason), f"view {words}: {result.stderr!r} does not name {reason}")
    expect(not result.stdout and (path.read_bytes() if path.is_file() else None) == before, f"view {words}: has written")


def check_refusals(scratch):
    good = scratch / "plane.h5"
    (scratch / "text.h5").write_text("no packing\n")
    (scratch / "cut.h5").write_bytes(good.read_bytes()[:3000])
    (scratch / "kept.html").write_text("<p>mine</p>\n")
    (scratch / "kept.svg.html").write_text("a\tb\n1\t2\n")
    refused(scratch, 1, "missing.h5", scratch / "missing.h5")
    refused(scratch, 1, "text.h5", scratch / "text.h5")
    refused(scratch, 1, "cut.h5", scratch / "cut.h5")
    refused(scratch, 1, "missing.h5", good, scratch / "missing.h5", "--no-wave", "--no-modes")
    refused(scratch, 2, "FILE")
    refused(scratch, 2, "kept.html --force", good, out="kept.html")
    refused(scratch, 2, "kept.svg.html", good, "--force", out="kept.svg.html")
    for out in ("page.svg", "page.h5", "page", "page.html.txt"):
        refused(scratch, 2, f"{out} .html", good, out=out)
    for words in (("--modes", "3:1"), ("--modes", "-1:2"), ("--modes", "1:x"), ("--modes", ""), ("--modes", "1:"),
                  ("--lowest", "0"), ("--lowest", "2.5"), ("--frames", "1"), ("--frames", "2001"), ("--until", "0"),
                  ("--until", "nan"), ("--source", "push"), ("--threshold", "-1")):
        refused(scratch, 2, words[0].lstrip("-"), good, *words)
    refused(scratch, 2, "--lowest --modes", good, "--lowest", 3, "--modes", "1:2")
    refused(scratch, 2, "--no-modes --lowest", good, "--lowest", 3, "--no-modes")
    refused(scratch, 2, "--no-wave --frames", good, "--frames", 3, "--no-wave")
    refused(scratch, 2, "signal.damping", good, "--set", "signal.damping=0.1")
    refused(scratch, 2, "packing.grains", good, "--set", "packing.grains=10")
    for words in (("--modes", "100:100000"), ("--modes", "900000:900001"), ("--lowest", "239")):
        refused(scratch, 2, "modes", good, *words)
    result = run("view", good)
    expect(result.returncode == 2 and names_all(result.stderr, "-o .html"), f"no -o: {result}")
    result = run("view", good, "-o", scratch / "no" / "folder.html")
    expect(result.returncode != 0 and names_all(result.stderr, "no"), f"no such folder: {result}")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-view-") as folder:
        scratch = pathlib.Path(folder)
        check_scenes(scratch)
        check_cells(scratch)
        check_alone(scratch)
        check_sizes(scratch)
        check_material(scratch)
        check_several(scratch)
        check_names(scratch)
        check_loose(scratch)
        check_refusals(scratch)
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
