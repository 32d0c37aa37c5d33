"""wave and transport: lattices and chains of known waves, means and errors over packings, and where there is no number. The
physics is in tests/unit/test_coherent.c and test_transport_*.c.

usage: test_wave.py COMMAND SOURCE_DIR
"""
import math

import numpy as np

from command import N200, N600, main, pack, run, table
from common import names_all

OTHER = "other.h5"


def perfect(kind, pressure, friction):
    """Distance of the rows, and the frequency of the shortest wave of them; E* = rho = d = 1, nu = 0."""
    spacing = 1
    for _ in range(50):  # F = 4/3 E12 sqrt(R12) n^(3/2), E12 = 1/2, R12 = 1/4; F = p d a/sqrt(3) in the lattice
        overlap = (3 * pressure * (1 if kind == "chain" else spacing / math.sqrt(3))) ** (2 / 3)
        spacing = 1 - overlap
    stiffness = 0.5 * math.sqrt(overlap)
    if kind == "chain":
        return spacing, 2 * math.sqrt(stiffness / (math.pi / 6))
    eta = 1 if friction > 0 else 0  # k_t = eta k_n, (A4)
    return spacing * math.sqrt(3) / 2, 2 * math.sqrt(1.5 * stiffness * (1 + eta / 3) / (math.pi / 6))


def lattices():
    """They carry the wave of their rows, omega = 2 sqrt(K/m) sin(k l/2), without attenuation. K/m of a row in the lattice is
    1.5 (1 + eta/3) k_n/m, as in Eqs. (18) and (19) of Somfai et al. 2005."""
    for kind, count, pressure, friction, highest, k_error, alpha_error in (
            ("triangular", 43, 1e-6, 0.5, 0.5, 8e-4, 6e-4), ("triangular", 86, 1e-4, 0, 0.5, 2e-4, 1e-4),
            ("chain", 200, 1e-4, 0, 0.7, 5e-6, 5e-6)):
        spacing, top = perfect(kind, pressure, friction)
        path = pack("rows.h5", kind=kind, grains=count * (8 if kind == "triangular" else 1), width=8, friction=friction,
                    poisson=0, pressure=pressure)
        parts = np.array([0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9])
        t = table("wave", path, "--at", ",".join(map(repr, (parts * top).tolist())))
        right, low = 2 * np.arcsin(parts) / spacing, parts <= highest
        assert np.all(t["samples"] == 1)
        assert np.all(np.abs(t["k"] / right - 1)[low] < k_error) and np.all(np.abs(t["alpha"])[low] < alpha_error), t.rows
        shift = np.hypot(t["k_shift"], t["alpha_shift"])
        assert np.all(np.hypot(t["k"] - right, t["alpha"]) < np.where(parts < 0.85, 1, 3) * shift + 1e-6), t.rows
        # above the largest frequency there is no wave: sideways ones of the lattice with friction go higher
        t = table("wave", path, "--at", repr((2.5 if friction else 1.05) * top))
        assert np.isnan(t["k"][0]) and np.isnan(t["alpha"][0]) and t["samples"][0] == 0, (kind, t.rows)


def mean_of_files(command, options, values, *files):
    """Means and standard errors of two files are those of their own rows."""
    one, two, both = (table(command, *some, *options) for some in (files[:1], files[1:], files))
    for name in values:
        a, b, there = one[name], two[name], ~np.isnan(one[name] + two[name])
        assert there.any() and np.allclose(both[name][there], 0.5 * (a + b)[there], rtol=1e-12), (options, name)
        err = 0.5 * np.abs(a - b)
        if "--quantity=kubo" in options and name != "speed":  # all share what a wide delta leaves out: twice the shift
            err = np.hypot(err, sum(t["shift"] * t[name] / t["D"] for t in (one, two)))
        elif command == "transport" and name == "D":  # what longer times and waves may change
            err = np.hypot(err, np.hypot(0.5 * (one["shift"] + two["shift"]), one["half"] + two["half"]))
        assert np.allclose(both[name + "_err"][there], err[there], rtol=1e-9), (options, name)
    assert np.array_equal(both["samples"], one["samples"] + two["samples"]), options
    return one


def waves():
    options = "--at=0.05,0.1,0.15", "--part=0.9", "--low=2", "--spacing=0.5"
    pack(OTHER, protocol="quick", grains=600, seed=3)
    mean_of_files("wave", options, ["k", "alpha"], N600, OTHER)
    t = table("wave", N600, OTHER, *options)
    assert np.allclose(t["speed"], t["omega"] / t["k"]) and np.allclose(t["speed_err"], t["speed"] * t["k_err"] / t["k"])
    # a packing's wave is about as fast as the long waves of `moduli'
    assert 0.8 < table("wave", N600, *options)["speed"][0] / table("moduli", N600)["c_l"][0] < 1.2
    assert len(table("wave", N600)) == 24
    # a record shorter than a period tells no wave number
    done = run("wave", N600, "--at=1e-9,1e-3,0.1")
    t = table("wave", N600, "--at=1e-9,1e-3,0.1")
    assert list(np.isnan(t["k"])) == [True, True, False] and list(t["samples"]) == [0, 0, 1] and names_all(done.stderr, "2 3")


def spread():
    at = ["--at=0.25,0.35", "--axis=x", "--sources=4"]
    one = mean_of_files("transport", at, ["D"], N600, OTHER)
    again = table("transport", N600, *at, "--seed=2")
    # the random motions of two seeds agree within their errors
    off = np.abs(one["D"] - again["D"]) / np.hypot(one["D_err"], again["D_err"])
    assert np.all(np.isnan(off) | ((off < 5) & (off > 0))), (one.rows, again.rows)
    # before the energy has spread there is no diffusivity, and no number
    early = table("transport", N600, *at, "--until=1")
    assert np.all(np.isnan(early["D"])) and list(early["samples"]) == [0, 0]


def kubo_split_and_energy():
    words = ["--quantity=kubo", "--at=0.3:0.5:3"]
    one = mean_of_files("transport", words, ["D", "speed", "path"], N200, N600)
    assert np.allclose(one["path"], 2 * one["D"] / one["speed"], rtol=1e-12)
    given = table("transport", N200, *words, "--axis=x")
    assert given.body == one.body and given.notes["axis"] == "x", "x is the only axis without walls"
    few = table("transport", N200, "--quantity=kubo", "--at=0.02")  # too few modes in the band
    assert np.isnan(few["D"][0]) and few["samples"][0] == 0
    parts = ("along", "across", "rotation", "normal", "tangential")
    one = mean_of_files("transport", ["--quantity=split", "--at=0.2,0.5"], [*parts, *(f"pulse_{p}" for p in parts)], N600, OTHER)
    for prefix in "", "pulse_":
        assert np.allclose(sum(one[prefix + name] for name in parts), 1, atol=1e-9)
        assert np.all(np.abs(sum(one[prefix + name] for name in parts[:3]) - 0.5) < 0.06)  # kinetic
    t = table("transport", N200, "--quantity=split", "--at=0.001,0.4")  # a frequency without modes is named
    assert list(t["samples"]) == [0, 1] and not any(np.isnan(t[name][1]) for name in t.names)
    one = mean_of_files("transport", ["--quantity=energy", "--at=0.1", "--until=200"], ["below", "flux"], N600, OTHER)
    assert len(one) == 72 and one["t"][-1] == 200 and set(one["plane"]) == {0.25, 0.5, 0.75}
    below = one["below"].reshape(-1, 3)  # a row a time, a column a plane
    assert np.all(np.diff(below, axis=1) >= 0) and below[0, 0] > below[-1, 0] + 0.1, "it has gone up"
    assert np.allclose(one["flux"], one["flux_normal"] + one["flux_sideways"] + one["flux_rotation"], atol=1e-12)


def coherent():
    options = ["--quantity=coherent", "--at=0.05,0.1,0.15", "--part=0.9", "--low=2", "--spacing=0.5"]
    mean_of_files("transport", options, ["k", "alpha"], N600, OTHER)
    t = table("transport", N600, OTHER, "--quantity=coherent", "--at=0.06:0.3:9")
    alpha, error, path = t["alpha"], t["alpha_err"], t["path"]
    there = ~np.isnan(alpha)
    assert np.allclose(t["path_low"][there], 0.5 / (np.maximum(0, alpha) + 2 * error)[there], rtol=1e-12)
    assert np.array_equal(np.isnan(path)[there], (alpha <= 2 * error)[there])
    there = ~np.isnan(path)
    assert np.allclose(path[there], 0.5 / alpha[there]) and np.allclose(t["k_path"][there], (t["k"] * path)[there])
    # the frequency of Ioffe and Regel lies between the rows about it
    crossed = [l for l in range(1, 9) if t["k_path"][l] <= math.pi < t["k_path"][l - 1]]
    if "ioffe_regel" in t.notes:
        assert t["omega"][crossed[0] - 1] <= t.note("ioffe_regel") <= t["omega"][crossed[0]] and t.note("ioffe_regel_err") > 0
    else:
        assert not crossed, t.rows
    # in a lattice nothing is scattered: long waves have the speeds of the moduli, a bound for the path, no diffusivity
    path = pack("rough.h5", kind="triangular", grains=480, width=8, friction=0.5)
    speeds = table("moduli", path)
    for name, more in (("c_l", ()), ("c_t", ("--shear",))):
        t = table("transport", path, "--quantity=coherent", "--at=0.05,0.1", *more)
        assert np.allclose(t["omega"] / t["k"], speeds[name][0], rtol=0.02), (name, t.rows)
        assert np.all(np.isnan(t["path"])) and np.all(t["path_low"] > 300), t.rows
    smooth = pack("smooth.h5", kind="triangular", grains=480, width=8, friction=0)
    assert np.all(np.isnan(table("transport", smooth, "--at=0.3,0.6")["D"]))


def random_chains():
    """The closed form where the frequency is low, a bound where nothing decays."""
    words = ["chain", "localisation"]
    t = table(*words, "--at=0.1,0.2,1.5", "--disorder=0.4", "--grains=2000000")
    assert np.all(np.abs(t["gamma"] - t["law"])[:2] < (4 * t["gamma_err"] + 0.05 * t["law"])[:2]), t.rows
    assert np.allclose(t["length"], 1 / t["gamma"]) and np.allclose(t["law"], t["omega"]**2 * 0.4**2 / 8)
    equal = table(*words, "--at=0.5", "--disorder=0", "--grains=10000")
    assert np.isnan(equal["length"][0]) and equal["length_low"][0] > 1000 and equal["law"][0] == 0
    one, two = (table(*words, "--at=1", "--grains=10000", "--seed", seed)["gamma"] for seed in (1, 2))
    assert one != two


main(lattices, waves, spread, kubo_split_and_energy, coherent, random_chains)
