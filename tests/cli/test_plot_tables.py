"""Figures of fronts, exponents, ensembles, modes, contacts and motion from the command line, and what they refuse.

usage: test_plot_tables.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import svg_ink
from common import expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
N200 = SOURCE / "packings" / "reference" / "packing_N200_p1e-4.txt"
N600 = SOURCE / "packings" / "reference" / "packing_N600_p1e-4.txt"
SCALING = """p\twidth\tdistance\tsamples\tt10\tt10_err\tt_peak\tt_zero\tamplitude\twidth10\tgamma\tgamma_err\talpha\talpha_err
1e-4\t24\t8\t10\t32\t1\t40\t46\t2\t14\t1.5\t0.1\t0.9\t0.1
1e-4\t24\t25\t10\t100\t1\t110\t130\t0.5\t30\tnan\tnan\tnan\tnan
1e-5\t24\t8\t10\t47\t1\t59\t67\t1\t20\t1.4\t0.1\t0.8\t0.1
1e-5\t24\t25\t10\t147\t2\t162\t191\t0.3\t44\tnan\tnan\tnan\tnan
"""


def run(*arguments):
    return subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, timeout=1200,
                          stdin=subprocess.DEVNULL)


def words(path, *arguments):
    """Texts of a figure that must succeed silently."""
    result = run("plot", *arguments, "-o", path)
    expect(result.returncode == 0 and not result.stdout and not result.stderr, f"{arguments}: {result}")
    if not path.exists():
        return []
    found = svg_ink.texts(path)
    path.unlink()
    return found


def refused(scratch, status, reason, *arguments):
    out = scratch / "no.svg"
    result = run("plot", *arguments, "-o", out)
    line = result.stderr.split("\n")[0]
    expect(result.returncode == status and names_all(line, reason) and line.startswith("sonopack"),
           f"{arguments}: {result.returncode} {line!r}, expected {status} and {reason!r}")
    expect(not out.exists(), f"{arguments}: a file is left")


def table(scratch, name, *arguments):
    result = run(*arguments)
    expect(result.returncode == 0, f"{arguments}: {result.stderr}")
    (scratch / name).write_text(result.stdout)
    return scratch / name


def check_fronts(scratch):
    out, scaling = scratch / "a.svg", scratch / "scaling.tsv"
    scaling.write_text(SCALING)
    text = words(out, "fronts", scaling, "--signal", N200)
    expect({"p = 10^\u22124 E*", "p = 10^\u22125 E*", "t_10", "t_zero"} <= set(text), f"fronts: {text}")
    expect(any(word.startswith("F_sig") for word in text), f"inset of fronts: {text}")
    text = words(out, "scaling", scaling)
    expect({"\u03b3_eff", "\u03b1_eff", "A", "W", "(a)", "(b)"} <= set(text), f"scaling: {text}")
    chain = table(scratch, "chain.tsv", "chain", "front", "--grains", "10,20,40")
    text = words(out, "scaling", scaling, chain)
    expect("chain" in text and "scaling, p = 10^\u22124 E*" in text, f"two tables: {text}")
    words(out, "fronts", chain)
    fronts = table(scratch, "fronts.tsv", "front", N200, N600)
    text = words(out, "fronts", fronts)
    expect(any(word.startswith("t_10,  c = 0.2") for word in text), f"two heights: {text}")
    # rows of any order are one line; signals of two files are two, with their names
    single = table(scratch, "single.tsv", "front", N600, N200)
    text = words(out, "fronts", single)
    expect(any(word.startswith("t_10,  c = 0.2") for word in text), f"two heights, the higher first: {text}")
    head, *rows = [line for line in single.read_text().split("\n") if line and line[0] != "#"]
    cells = [row.split("\t", 1)[1] for row in reversed(rows)]
    several = scratch / "several.tsv"
    several.write_text(head + "\n" + "".join(f"in/{name}.tsv:F{k + 1}\t{cells[k]}\n" for name in "ab" for k in (0, 1)))
    text = words(out, "fronts", several)
    expect(text.count("a") == text.count("b") == 1, f"two files of signals: {text}")
    bent = scratch / "bent.tsv"
    bent.write_text("distance\tt10\tt_peak\tt_zero\n1\t1\t1.2\t1.4\n2\t2\t2.2\t2.4\n10\t40\t41\t42\n")
    expect("t_10,  c = 0.2" in " ".join(words(out, "fronts", bent, "--log", "xy")), "a line that begins below zero")
    text = words(out, "fronts", single, fronts, "--label", "one", "--label", "two")
    expect(text.count("one") == text.count("two") == 1, f"a label for each table: {text}")
    signal = table(scratch, "signal.tsv", "signal", N200, "--detector", "plane:3", "--detector", "top", "--until", 60)
    for kind in ("fronts", "scaling"):
        refused(scratch, 1, "sonopack front", kind, signal)
    refused(scratch, 1, "gamma and alpha", "scaling", fronts)
    refused(scratch, 1, "scaling.tsv", "fronts", scaling, "--signal", scaling)
    refused(scratch, 1, "missing.txt", "fronts", scaling, "--signal", scratch / "missing.txt")
    refused(scratch, 1, "a packing, must be a table", "fronts", N200)
    refused(scratch, 2, "--signal: only plot fronts", "scaling", scaling, "--signal", N200)


def check_ensemble_and_modes(scratch):
    out, ensemble = scratch / "a.svg", scratch / "ensemble.tsv"
    ensemble.write_text("t\tmean\trms\n0\t0\t0\n1\t1e-3\t2e-3\n2\tnan\t1e-3\n")
    text = words(out, "ensemble", ensemble)
    expect({"mean", "rms deviation"} <= set(text), f"ensemble: {text}")
    text = words(out, "ensemble", ensemble, ensemble)
    expect({"ensemble", "mean", "rms deviation"} <= set(text), f"two ensembles: {text}")
    head = "# pressure = 0.0001, grains = 200, friction = {}\n# low, high: its interval at level 0.9, by bootstrap\n"
    rows = "t\tmean\trms\tlow\thigh\n0\t0\t0\t0\t0\n1\t2e-3\t2e-3\t1e-3\t3e-3\n"
    for friction in ("0", "0.5"):
        (scratch / f"of{friction}.tsv").write_text(head.format(friction) + rows)
    text = words(out, "ensemble", scratch / "of0.tsv", scratch / "of0.5.tsv")
    expect({"\u03bc = 0", "\u03bc = 0.5", "mean, 90% interval", "rms deviation"} <= set(text), f"frictions: {text}")
    text = words(out, "ensemble", scratch / "of0.tsv")
    expect("mean, 90% interval" in text and "\u03bc = 0" not in text, f"one friction: {text}")
    refused(scratch, 1, "a signal needs columns", "signal", ensemble)
    modes = table(scratch, "modes.tsv", "modes", N200)
    text = words(out, "modes", modes)
    expect({"(a)", "(b)", "n"} <= set(text), f"modes: {text}")
    text = words(out, "modes", table(scratch, "bare.tsv", "modes", N200, "--frequencies-only"))
    expect("(b)" not in text and "n" in text, f"frequencies alone: {text}")
    refused(scratch, 2, "7 files", "modes", *[modes] * 7)
    for name, content, reason in (("words.tsv", "t\tmean\trms\n0\tx\t1\n", ""), ("empty.tsv", "", "empty.tsv"),
                                  ("header.tsv", "t\tmean\trms\n", ""),
                                  ("nans.tsv", "t\tmean\trms\n0\tnan\tnan\n", ""),
                                  ("other.tsv", "a\tb\n1\t2\n", ""), ("binary.tsv", "\0\1\2", "binary.tsv")):
        (scratch / name).write_text(content)
        for kind in ("ensemble", "modes", "fronts", "scaling", "angles", "forces"):
            refused(scratch, 1, reason if kind == "ensemble" else "", kind, scratch / name)
    refused(scratch, 1, "missing.tsv", "ensemble", scratch / "missing.tsv")


def check_planes(scratch):
    """Planes are called by their heights; more than ten signals stand one above the other."""
    planes = table(scratch, "few.tsv", "signal", N600, "--planes", 4, "--until", 150, "--points", 200)
    text = words(scratch / "a.svg", "signal", planes)
    expect({"y = 4.933 d", "y = 9.866 d", "y = 14.8 d"} <= set(text) and "F1" not in text, f"few planes: {text}")
    places = table(scratch, "places.tsv", "signal", N200, "--detector", "top", "--detector", "part:0:6", "--until", 80)
    text = words(scratch / "a.svg", "signal", places)
    expect({"top", "part:0:6"} <= set(text), f"places: {text}")
    planes = table(scratch, "many.tsv", "signal", N600, "--planes", 14, "--until", 150, "--points", 200)
    text = words(scratch / "a.svg", "signal", planes)
    expect("distance  [d]" in text and "t_10" not in text, f"many planes: {text}")
    text = words(scratch / "a.svg", "signal", *[N200] * 11)
    expect("number" in text and "distance  [d]" not in text, f"eleven of one height: {text}")


def check_packings(scratch):
    out = scratch / "a.svg"
    text = words(out, "angles", N600, N200)
    expect({"all contacts", "90\u00b0", "1"} <= set(text), f"angles: {text}")
    text = words(out, "forces", N600)
    expect({"normal force", "normal stiffness"} <= set(text), f"forces: {text}")
    text = words(out, "snapshot", N600, "--time", 40)
    expect(any(word.startswith("t = 40 d") for word in text) and any(word.endswith("longer, cut") for word in text), f"snapshot: {text}")
    text = words(out, "snapshot", N200, "--set", "signal.source=displacement", "--time", 0)
    expect(any(word.startswith("t = 0 d") for word in text), f"snapshot: {text}")
    refused(scratch, 1, "missing.h5", "angles", N600, scratch / "missing.h5")
    refused(scratch, 2, "--time", "network", N600, "--time", 40)
    refused(scratch, 2, "--time -1", "snapshot", N600, "--time=-1")
    refused(scratch, 2, "2 files", "snapshot", N600, N200)  # the second may be a table of displacements
    refused(scratch, 2, "3 files", "snapshot", N600, N200, N200)
    low = scratch / "low.h5"
    made = run("pack", "--set", "packing.kind=triangular", "--set", "packing.grains=32", "--set", "packing.width=8",
               "--set", "packing.friction=0", "-o", low)
    if made.returncode == 0:
        refused(scratch, 1, "too small for a bulk", "angles", low)


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-plot-") as folder:
        scratch = pathlib.Path(folder)
        for check in (check_fronts, check_ensemble_and_modes, check_planes, check_packings):
            check(scratch)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


sys.exit(main())
