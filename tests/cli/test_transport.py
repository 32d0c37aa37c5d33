#!/usr/bin/env python3
"""transport: means and errors over packings, what is refused, and the mean free path of made-up errors.
Usage: test_transport.py COMMAND SOURCE_DIR"""
import math
import os
import subprocess
import sys
import tempfile

from common import names_all
from test_signal import N200, N600, run, table

COMMAND = sys.argv[1]


def rows(*arguments):
    """Columns by name."""
    comments, header, cells = table(run("transport", *arguments))
    return comments, {name: [float(cell[c]) for cell in cells] for c, name in enumerate(header)}


def close(a, b, tolerance=1e-12):
    return abs(a - b) <= tolerance * abs(b)


def mean_of_files(options, values, files=(N200, N600)):
    """Means and standard errors of two files are those of their own rows."""
    one, two, both = (rows(*some, *options)[1] for some in (files[:1], files[1:], files))
    for name in values:
        for a, b, mean, error in zip(one[name], two[name], both[name], both[name + "_err"]):
            if not math.isnan(a + b + mean):
                assert close(mean, 0.5 * (a + b)) and close(error, 0.5 * abs(a - b), 1e-9), (options, name)
    for l, samples in enumerate(both["samples"]):
        assert samples == one["samples"][l] + two["samples"][l], (options, l)
    assert max(both["samples"]) == 2, options
    return one, two, both


def test_spread(other):
    at = ["--at", "0.25,0.35", "--axis", "x", "--sources", "4"]
    one, _, _ = mean_of_files(at, ["D"], (N600, other))
    for name in "D", "D_err", "from", "to":
        assert all(v > 0 or math.isnan(v) for v in one[name]), (name, one)
    again = rows(N600, *at, "--seed", 2)[1]
    assert again["D"] != one["D"]
    # the random motions of two seeds agree within their errors
    for a, b, e, f in zip(one["D"], again["D"], one["D_err"], again["D_err"]):
        assert math.isnan(a + b) or abs(a - b) < 5 * math.hypot(e, f), (one, again)
    # before the energy has spread there is no diffusivity, and no number
    early = rows(N600, *at, "--until", 1)[1]
    assert all(map(math.isnan, early["D"] + early["D_err"])) and early["samples"] == [0, 0]


def test_kubo():
    one, _, _ = mean_of_files(["--quantity", "kubo", "--at", "0.3:0.5:3"], ["D", "speed", "path"])
    assert close(one["path"][0], 2 * one["D"][0] / one["speed"][0])
    comments, given = rows(N200, "--quantity", "kubo", "--at", "0.3:0.5:3", "--axis", "x")
    assert given == one, "x is the only axis without walls"
    assert comments["axis"] == "x"
    # too few modes in the band
    few = rows(N200, "--quantity", "kubo", "--at", "0.02")[1]
    assert math.isnan(few["D"][0]) and math.isnan(few["speed"][0]) and few["samples"] == [0]
    assert run("transport", N200, "--quantity", "kubo", "--axis", "up", "--at", "0.3"), "up stands for the default"


def test_coherent(other):
    options = ["--quantity", "coherent", "--at", "0.05,0.1,0.15", "--part", "0.9", "--low", "2", "--spacing", "0.5"]
    one, two, both = mean_of_files(options, ["k", "alpha"], (N600, other))
    for t in one, two, both:
        for l, alpha in enumerate(t["alpha"]):
            if math.isnan(alpha):
                continue
            error, path = t["alpha_err"][l], t["path"][l]
            assert close(t["path_low"][l], 0.5 / (max(0, alpha) + 2 * error))
            assert math.isnan(path) == (alpha <= 2 * error)
            assert math.isnan(path) or close(path, 0.5 / alpha) and close(t["k_path"][l], t["k"][l] * path)
    # the transverse wave is slower
    shear = rows(N600, "--quantity", "coherent", "--at", "0.05", "--shear")[1]
    assert math.isnan(shear["k"][0]) or shear["k"][0] > one["k"][0]


def test_lattice(folder):
    """In a lattice nothing is scattered: a bound for the mean free path, no diffusivity."""
    scene = os.path.join(folder, "lattice.cfg")
    with open(scene, "w") as file:
        file.write('packing = { kind = "triangular"; grains = 480; width = 8; friction = 0; };\n')
    lattice = os.path.join(folder, "lattice.h5")
    run("pack", scene, "-o", lattice)
    wave = rows(lattice, "--quantity", "coherent", "--at", "0.2,0.3")[1]
    assert all(map(math.isnan, wave["path"])) and all(v > 30 for v in wave["path_low"]), wave
    spread = rows(lattice, "--at", "0.3,0.6")[1]
    assert all(map(math.isnan, spread["D"])), spread


def test_refused():
    for arguments, status, words in (
            (["none.h5"], 1, "none.h5"), ([], 2, ""), ([N200, "--at", "0"], 2, "--at"),
            ([N200, "--quantity", "x"], 2, "--quantity"), ([N200, "--axis", "y"], 2, "--axis"),
            ([N200, "--shear"], 2, "--shear"), ([N200, "--width", "0"], 2, "--width"),
            ([N200, "--quantity", "coherent", "--axis", "x"], 2, "--axis"),
            ([N200, "--sources", "1"], 2, "--sources"), ([N200, "--waves", "0"], 2, "--waves"),
            ([N200, "--at", "1e3"], 1, ""), ([N200, "--prestress", "--at", "0.2"], 1, "N200")):
        done = subprocess.run([COMMAND, "transport", *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == status and names_all(done.stderr, words if words != "N200" else ""), (arguments, done)


with tempfile.TemporaryDirectory() as folder:
    other = os.path.join(folder, "other.h5")
    with open(os.path.join(folder, "other.cfg"), "w") as file:
        file.write('packing = { protocol = "quick"; grains = 600; pressure = 1e-4; seed = 3; };\n')
    run("pack", os.path.join(folder, "other.cfg"), "-o", other)
    test_spread(other)
    test_kubo()
    test_coherent(other)
    test_lattice(folder)
    test_refused()
