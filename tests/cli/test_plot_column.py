"""Figures of the tapped column from the command line, and what they refuse.

usage: test_plot_column.py COMMAND SOURCE_DIR
"""
import math
import pathlib
import subprocess
import sys
import tempfile

import svg_ink
from common import expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()


def run(*arguments):
    return subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, timeout=1200,
                          stdin=subprocess.DEVNULL)


def words(scratch, *arguments):
    """Texts of a figure that must succeed silently."""
    path = scratch / "a.svg"
    result = run("plot", "column", *arguments, "-o", path)
    expect(result.returncode == 0 and not result.stdout and not result.stderr, f"{arguments}: {result}")
    if not path.exists():
        return []
    found = svg_ink.texts(path)
    path.unlink()
    return found


def refused(scratch, status, reason, *arguments):
    out = scratch / "no.svg"
    result = run("plot", "column", *arguments, "-o", out)
    line = result.stderr.split("\n")[0]
    expect(result.returncode == status and names_all(line, reason) and line.startswith("sonopack"),
           f"{arguments}: {result.returncode} {line!r}, expected {status} and {reason!r}")
    expect(not out.exists(), f"{arguments}: a file is left")


def table(path, header, rows, **comments):
    """A table as `sonopack column' writes it: units behind the names in brackets."""
    names = [name.split("[")[0] for name in header.split()]
    units = " ".join(name.replace("[", " [") for name in header.split() if "[" in name)
    lines = [f"# {key} = {value}" for key, value in comments.items()] + [f"# units: {units}"]
    lines += ["\t".join(names)] + ["\t".join(repr(float(cell)) for cell in row) for row in rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def column(particles, rows=120):
    return [[0.02 * k, max(0.0, math.sin(3 * k)) if k % 50 < 5 else 0.0] +
            [2 * i + 1 + math.exp(-0.05 * (k % 50)) * math.sin(0.3 * k - i) for i in range(particles)]
            for k in range(rows)]


def trajectory(path, particles, **comments):
    header = "t[s] " + " ".join(f"y{k}[cm]" for k in range(particles + 1))
    return table(path, header, column(particles), period=1, **comments)


def check_trajectories(scratch):
    one = trajectory(scratch / "one.tsv", 5, model="lattice")
    two = trajectory(scratch / "two.tsv", 5, model="longwave")
    many = trajectory(scratch / "many.tsv", 90)
    text = words(scratch, one)
    expect({"y_1", "y_5", "floor y_0", "t  [s]", "y  [cm]"} <= set(text), f"trajectory: {text}")
    text = words(scratch, many)
    expect("y_3, y_6 \u2026 y_90" in text, f"many particles: {text}")
    text = words(scratch, one, two)
    expect({"(a)  lattice", "(b)  long wave", "particle"} <= set(text), f"surfaces: {text}")
    text = words(scratch, one, "--surface")
    expect({"lattice", "y(t) \u2212 y(0)  [cm]"} <= set(text), f"one surface: {text}")
    for ending in (".png", ".pdf"):
        result = run("plot", "column", one, two, "-o", scratch / f"a{ending}")
        expect(result.returncode == 0 and (scratch / f"a{ending}").stat().st_size > 5000, f"{ending}: {result}")
    refused(scratch, 1, "only a bifurcation", one, "--column", "y2")
    refused(scratch, 2, "must be y1, y2, ...", one, "--column", "alpha")
    refused(scratch, 2, "7 files", *[one] * 7)


def check_diagrams(scratch):
    branches = table(scratch / "bif.tsv", "parameter[cm] tap y1[cm] y2[cm]",
                     [[1 + 0.01 * p, tap, math.sin(p * tap), math.cos(p * tap)] for p in range(50) for tap in range(20)],
                     parameter="amplitude")
    exponents = table(scratch / "lyap.tsv", "parameter[cm] lambda",
                      [[1 + 0.01 * p, -math.inf if p % 9 == 0 else math.sin(p)] for p in range(50)],
                      parameter="amplitude")
    text = words(scratch, branches)
    expect({"a  [cm]", "y_1 after a tap  [cm]"} <= set(text), f"bifurcation: {text}")
    for files in ([branches, exponents], [exponents, branches]):
        text = words(scratch, *files, "--column", "y2")
        expect({"y_2 after a tap  [cm]", "\u03bb", "(b)"} <= set(text), f"both: {text}")
    text = words(scratch, exponents)
    expect({"a  [cm]", "\u03bb"} <= set(text), f"exponents: {text}")
    refused(scratch, 1, "must be y1 to y2", branches, "--column", "y3")
    refused(scratch, 1, "a surface is drawn of trajectories", branches, "--surface")
    one = trajectory(scratch / "one.tsv", 3)
    refused(scratch, 1, "table 1 is a trajectory and table 2 a bifurcation: they make no figure together", one, branches)


def check_others(scratch):
    taps = table(scratch / "strobe.tsv", "tap t[s] y1[cm] y2[cm] density[g/cm]",
                 [[k, k - 0.01, 0.5 + 0.1 / k, 2.1 + 0.2 / k, 0.6 - 0.1 / k] for k in range(1, 9)])
    text = words(scratch, taps)
    expect({"tap", "density  [g/cm]", "y_2"} <= set(text), f"strobe: {text}")
    compared = table(scratch / "compare.tsv", "t[s] mean_longwave[cm] max_longwave[cm] mean_bsr[cm] max_bsr[cm]",
                     [[0.1 * k, 0.1 * k, 0.2 * k, 0.3 * k, 0.5 * k] for k in range(20)])
    expect("BSR, mean" in words(scratch, compared), "compare")
    energies = table(scratch / "energy.tsv", "tap work[erg] dissipated[erg] rest[s]",
                     [[k, 7000 + k, 6990 + k, math.nan] for k in range(1, 5)])
    expect({"work of the floor", "work \u2212 dissipated  [erg]"} <= set(words(scratch, energies)), "energy")
    dense = table(scratch / "density.tsv", "t[s] y1[cm] y2[cm] rho1[g/cm] rho2[g/cm]",
                  [[0.01 * k, 0.5, 2.1, 0.6, 0.5 + 0.001 * k] for k in range(200)], period=1)
    expect("tap 1, t = 0.99 s" in words(scratch, dense), "density")
    for name, content, reason in (("words.tsv", "t\ty0\ty1\n0\tx\t1\n", ""),
                                  ("empty.tsv", "", "empty.tsv"), ("header.tsv", "t\ty0\ty1\n", ""),
                                  ("row.tsv", "t\ty0\ty1\n0\t0\t1\n", ""),
                                  ("nans.tsv", "t\ty0\ty1\n0\tnan\tnan\n1\tnan\tnan\n", ""),
                                  ("times.tsv", "t\ty0\ty1\nnan\t0\t1\n1\t0\t1\n", ""),
                                  ("back.tsv", "t\ty0\ty1\n1\t0\t1\n0\t0\t1\n", ""),
                                  ("gap.tsv", "t\ty0\ty2\n0\t0\t1\n1\t0\t1\n", "y1"),
                                  ("other.tsv", "a\tb\n1\t2\n", ""),
                                  ("binary.tsv", "\0\1\2", "binary.tsv")):
        (scratch / name).write_text(content)
        refused(scratch, 1, reason, scratch / name)
    refused(scratch, 1, "missing.tsv", scratch / "missing.tsv")
    refused(scratch, 1, "a packing, must be a table", SOURCE / "packings" / "reference" / "packing_N200_p1e-4.txt")
    result = run("plot", "modes", taps, "--surface", "-o", scratch / "no.svg")
    expect(result.returncode == 2 and names_all(result.stderr, "--surface"), f"--surface of modes: {result}")


with tempfile.TemporaryDirectory() as name:
    for check in (check_trajectories, check_diagrams, check_others):
        check(pathlib.Path(name))
for fault in faults:
    print(fault)
print("plot column:", len(faults), "faults")
sys.exit(1 if faults else 0)
