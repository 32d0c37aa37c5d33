"""Pictures of packings in periodic cells, tilted ones, and boxes: the outline of the cell, and every contact of every
grain within it, those through a face at both sides.

usage: test_plot_cells.py COMMAND SOURCE_DIR
"""
import itertools
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from cells import box_of_disks, lattice, matrix_of, write_packing

COMMAND = str(pathlib.Path(sys.argv[1]).resolve())
LINE = re.compile(r'stroke-linecap:round[^"]*" d="M ([\d.-]+) ([\d.-]+) L ([\d.-]+) ([\d.-]+) "')
OUTLINE = re.compile(r'stroke-dasharray[^"]*" d="([^"]*)"')
WALL = re.compile(r'fill:rgb\(25%,25%,25%\)[^"]*" d="([^"]*)"')
faults = []


def expect(good, what):
    if not good:
        faults.append(what)
        print("FAILED:", what)


def plot(kind, packing, out, *words):
    result = subprocess.run([COMMAND, "plot", kind, packing, "-o", out, "--force", *words], capture_output=True, text=True,
                            timeout=600)
    expect(result.returncode == 0, f"{kind} {packing}: {result.stderr}")
    return pathlib.Path(out).read_text() if str(out).endswith(".svg") and result.returncode == 0 else ""


def numbers(path):
    return np.array([float(word) for word in re.findall(r"-?[\d.]+", path)]).reshape(-1, 2)


def frame(svg, p):
    """From the canvas to lengths in d: the lower left corner of the cell, and points per d."""
    if p["cell"] == "box":
        corners = np.concatenate([numbers(path) for path in WALL.findall(svg)])
        wide, tall = np.ptp(corners, axis=0)
        thick = (wide - tall * p["box"][0] / p["box"][1]) / (2 - 2 * p["box"][0] / p["box"][1])
        return np.array([corners[:, 0].min() + thick, corners[:, 1].max() - thick]), (wide - 2 * thick) / p["box"][0]
    corners = np.concatenate([numbers(path) for path in OUTLINE.findall(svg)])
    low = corners[corners[:, 1] > corners[:, 1].max() - 0.01]
    return np.array([low[:, 0].min(), low[0, 1]]), np.ptp(low[:, 0]) / p["box"][0]


def check_network(folder, name, p):
    """Each centre within the cell has as many ends of lines as its grain has contacts."""
    path = write_packing(str(folder / f"{name}.h5"), p)
    svg = plot("network", path, folder / f"{name}.svg")
    corner, scale = frame(svg, p)
    ends = np.array([[float(x) for x in found] for found in LINE.findall(svg)]).reshape(-1, 2, 2)
    ends = (ends - corner) / scale * [1, -1]
    matrix = matrix_of(p["box"], p["tilt"])
    for i, x in enumerate(p["x"]):
        near = np.linalg.norm(ends - x, axis=2) < 0.02
        contacts = (p["pairs"][:, 0] == i).sum() + (p["pairs"][:, 1] == i).sum()
        expect(near.sum() == contacts, f"{name}: grain {i} has {near.sum()} lines, {contacts} contacts")
    if p["cell"] == "periodic":
        crossing = [k for k, (i, j) in enumerate(p["pairs"]) if np.linalg.norm(p["x"][j] - p["x"][i]) > 1.2]
        expect(len(crossing) > 0 and len(ends) >= len(p["pairs"]) + len(crossing), f"{name}: {len(ends)} lines")
        corners = np.concatenate([numbers(path) for path in OUTLINE.findall(svg)])
        for a, b in itertools.product((0, 1), repeat=2):
            at = corner + (a * matrix[0] + b * matrix[1]) * scale * [1, -1]
            expect(np.linalg.norm(corners - at, axis=1).min() < 0.01, f"{name}: corner {a} {b} of the outline")


def check_other_kinds(folder):
    """Kinds that need more than places are drawn too, in both dimensions."""
    for name, p in (("tilted", lattice(2, 0.3)), ("sheared", lattice(3, 0.2, cells=4)), ("box", box_of_disks())):
        path = write_packing(str(folder / f"{name}-kinds.h5"), p)
        plot("network", path, folder / f"{name}.png")
        svg = plot("mode", path, folder / f"{name}-mode.svg", "--mode", "3")
        expect("<svg" in svg, f"{name}: mode")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-plot-cells-") as scratch:
        folder = pathlib.Path(scratch)
        for name, p in (("square", lattice(2)), ("tilted", lattice(2, 0.3)), ("left", lattice(2, -0.4)),
                        ("box", box_of_disks())):
            check_network(folder, name, p)
        check_other_kinds(folder)
    print(f"{len(faults)} faults" if faults else "pictures of cells: all fine")
    sys.exit(1 if faults else 0)


main()
