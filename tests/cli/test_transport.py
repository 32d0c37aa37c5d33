#!/usr/bin/env python3
"""transport: means and errors over packings, what is refused, and the mean free path of made-up errors.
Usage: test_transport.py COMMAND SOURCE_DIR"""
import math
import os
import re
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


def test_rows():
    """A frequency without modes leaves the others their values, and is named."""
    t = rows(N200, "--quantity", "split", "--at", "0.001,0.4")[1]
    assert t["samples"] == [0, 1] and not any(math.isnan(t[name][1]) for name in t), t


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
    # in one packing, what the wave does not explain leaves its k and alpha uncertain, even if they do not change with time
    height = float(re.search(r"^# height = (\S+)", run("signal", N600, "--points", "2"), re.M).group(1))
    span = 0.6 * height - 4
    alone = rows(N600, "--quantity", "coherent", "--at", "0.1:0.9:17")[1]
    fits = [l for l in range(17) if alone["samples"][l] == 1]
    assert len(fits) > 4 and all(alone["part"][l] >= 0.5 for l in fits), alone
    for l in fits:  # at least as much as if the planes spread the weight as far apart as they can
        least = math.sqrt((1 - alone["part"][l]) / (2 * alone["part"][l] * (1 + span))) / (span / 2)
        assert alone["k_err"][l] > 0.99 * least and alone["alpha_err"][l] > 0.99 * least, (l, least, alone)
    # the frequency of Ioffe and Regel lies between the rows about it
    comments, t = rows(N600, other, "--quantity", "coherent", "--at", "0.06:0.3:9")
    if "ioffe_regel" in comments:
        w, error = float(comments["ioffe_regel"]), float(comments["ioffe_regel_err"])
        l = next(l for l in range(1, 9) if t["k_path"][l] <= math.pi < t["k_path"][l - 1])
        assert t["omega"][l - 1] <= w <= t["omega"][l] and error > 0, (w, t)
    else:
        assert not any(a > math.pi >= b for a, b in zip(t["k_path"], t["k_path"][1:])), t
    # the transverse wave is slower
    shear = rows(N600, "--quantity", "coherent", "--at", "0.05", "--shear")[1]
    assert math.isnan(shear["k"][0]) or shear["k"][0] > one["k"][0]


def test_split(other):
    names = ("along", "across", "rotation", "normal", "tangential")
    options = ["--quantity", "split", "--at", "0.2,0.5"]
    one, _, _ = mean_of_files(options, [*names, *("pulse_" + name for name in names)], (N600, other))
    for prefix in "", "pulse_":
        for l in range(2):
            assert close(sum(one[prefix + name][l] for name in names), 1, 1e-9), (prefix, one)
            kinetic = sum(one[prefix + name][l] for name in names[:3])
            assert abs(kinetic - 0.5) < 0.06, (prefix, kinetic)


def test_energy(other):
    options = ["--quantity", "energy", "--at", "0.1", "--until", "200"]
    one, two, both = mean_of_files(options, ["below", "flux", "flux_normal", "flux_rotation"], (N600, other))
    assert len(one["t"]) == 72 and one["t"][-1] == 200 and set(one["plane"]) == {0.25, 0.5, 0.75}
    for t in one, two:
        assert all(abs(a) < 1e-9 for a in t["below_err"]), "errors of rounding"
        for k in range(0, 72, 3): # the order of the planes, and what the flux consists of
            assert 0 <= t["below"][k] <= t["below"][k + 1] <= t["below"][k + 2] <= 1 + 1e-9
            assert abs(t["flux"][k] - t["flux_normal"][k] - t["flux_sideways"][k] - t["flux_rotation"][k]) < 1e-12
        assert t["below"][0] > t["below"][-3] + 0.1, "it has gone up"
    assert names_all(run("transport", N600, "--quantity", "energy", "--at", "0.1:0.5:40", status=2), "--at 40")


def test_chain():
    """Random masses: the closed form where the frequency is low, a bound where nothing decays."""
    comments, t = chain("--at", "0.1,0.2,1.5", "--disorder", "0.4", "--grains", "2000000")
    for l in range(2):
        assert abs(t["gamma"][l] - t["law"][l]) < 4 * t["gamma_err"][l] + 0.05 * t["law"][l], t
        assert close(t["length"][l], 1 / t["gamma"][l]) and close(t["law"][l], t["omega"][l] ** 2 * 0.4 ** 2 / 8)
    assert t["gamma"][2] > 1.3 * t["law"][2]
    _, equal = chain("--at", "0.5", "--disorder", "0", "--grains", "10000")
    assert math.isnan(equal["length"][0]) and equal["length_low"][0] > 1000 and equal["law"][0] == 0, equal
    _, other = chain("--at", "1", "--grains", "10000", "--seed", "2")
    _, first = chain("--at", "1", "--grains", "10000")
    assert other["gamma"] != first["gamma"]
    for arguments in (["--disorder", "0.6"], ["--grains", "100"], ["--at", "0"], ["--seed", "x"], ["--units", "si"]):
        reason = run("chain", "localisation", *arguments, status=2)
        assert names_all(reason, arguments[0]), (arguments, reason)


def chain(*arguments):
    comments, header, cells = table(run("chain", "localisation", *arguments))
    return comments, {name: [float(cell[c]) for cell in cells] for c, name in enumerate(header)}


def test_lattice(folder):
    """In a lattice nothing is scattered: a bound for the mean free path, no diffusivity."""
    scene = os.path.join(folder, "lattice.cfg")
    with open(scene, "w") as file:
        file.write('packing = { kind = "triangular"; grains = 480; width = 8; friction = 0; };\n')
    lattice = os.path.join(folder, "lattice.h5")
    run("pack", scene, "-o", lattice)
    wave = rows(lattice, "--quantity", "coherent", "--at", "0.2,0.3")[1]
    assert all(map(math.isnan, wave["path"])) and all(v > 30 for v in wave["path_low"]), wave
    # long waves of both kinds have the speeds of the moduli, if there is friction to hold the rows together
    with open(scene, "w") as file:
        file.write('packing = { kind = "triangular"; grains = 480; width = 8; friction = 0.5; };\n')
    rough = os.path.join(folder, "rough.h5")
    run("pack", scene, "-o", rough)
    _, header, cells = table(run("moduli", rough))
    for speed, more in (("c_l", ()), ("c_t", ("--shear",))):
        c = float(cells[0][header.index(speed)])
        t = rows(rough, "--quantity", "coherent", "--at", "0.05,0.1", *more)[1]
        assert all(close(w / k, c, 0.02) for w, k in zip(t["omega"], t["k"])), (speed, c, t)
        assert all(map(math.isnan, t["path"])) and all(v > 300 for v in t["path_low"]), t
    spread = rows(lattice, "--at", "0.3,0.6")[1]
    assert all(map(math.isnan, spread["D"])), spread


with tempfile.TemporaryDirectory() as folder:
    other = os.path.join(folder, "other.h5")
    with open(os.path.join(folder, "other.cfg"), "w") as file:
        file.write('packing = { protocol = "quick"; grains = 600; pressure = 1e-4; seed = 3; };\n')
    run("pack", os.path.join(folder, "other.cfg"), "-o", other)
    test_rows()
    test_spread(other)
    test_kubo()
    test_coherent(other)
    test_split(other)
    test_energy(other)
    test_chain()
    test_lattice(folder)
