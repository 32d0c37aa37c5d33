"""signal, modes and moduli against numpy (network_oracle.py), and signals as the packings brought them.

usage: test_signal.py COMMAND SOURCE_DIR
"""
import json
import pathlib

import numpy as np

from command import N200, N600, REFERENCE, main, pack, refused, run, sets, table, tried
from common import names_all
from network_oracle import network


def modes_of(path):
    oracle, found = network(path), table("modes", path)
    exact, zero = oracle.frequencies(), 3 * oracle.rattlers
    assert found.names == ["n", "omega", "a", "b", "ab", "participation", "error"]
    assert np.array_equal(found["n"], np.arange(zero + len(exact))) and np.all(found["omega"][:zero] == 0)
    assert found.note("zero_modes") == zero == found.note("rattler_modes")
    assert np.abs(found["omega"][zero:] / exact - 1).max() < 1e-11 and np.all(found["error"] < 1e-12)
    # amplitudes: the modal sum of the table is the signal
    times = np.linspace(0, 150, 40)
    f, g = np.sin(np.outer(times, found["omega"])) @ found["ab"], oracle.signal("impulse", times)
    assert np.max(np.abs(f - g)) < 1e-11 * np.max(np.abs(g))
    share = (oracle.vectors**2).reshape(-1, 3, len(exact)).sum(axis=1)  # of each grain that is no rattler
    gap = np.diff(oracle.squares) / oracle.squares[-1]
    lone = np.minimum(np.append(gap, 1), np.append(1, gap)) > 1e-6  # close modes may mix
    ratio = 1 / (len(share) * (share**2).sum(axis=0))
    assert np.max(np.abs(found["participation"][zero:] - ratio)[lone]) < 1e-8
    bare = table("modes", path, "--frequencies-only")
    assert bare.names == ["n", "omega", "error"]
    assert np.all(np.abs(bare["omega"] - found["omega"]) <= bare["error"] + found["error"])


def modes():
    for path in (N200, N600):
        modes_of(path)


def signals():
    t = np.linspace(0, 300, 301)
    for prestress in (False, True):
        oracle = network(N200, prestress)
        for source in ("impulse", "velocity", "displacement"):
            for method in ("auto", "chebyshev") + (() if prestress else ("dense",)):
                found = table("signal", N200, "--source", source, "--method", method, "--until", 300, "--points", 301,
                              *["--prestress"] * prestress)
                exact = oracle.signal(source, t)
                assert np.array_equal(found["t"], t) and found.names == ["t", "F"]
                assert np.max(np.abs(found["F"] - exact)) < 2e-12 * np.max(np.abs(exact)), (source, method, prestress)
                assert found.notes["method"] == ("dense" if method == "dense" else "chebyshev")
                assert found.note("height") == oracle.height and found.note("pressure") == 1e-4


def published():
    """The signals that came with the packings."""
    for path in (N200, N600):
        reference = np.loadtxt(REFERENCE / path.name.replace("packing_", "signal_"))
        for column, source in ((1, "velocity"), (2, "impulse")):
            found = table("signal", path, "--until", 400, "--points", 801, "--source", source)
            assert np.allclose(found["t"], reference[:, 0], rtol=1e-14)
            assert np.abs(found["F"] - reference[:, column]).max() < 1e-9 * np.abs(reference[:, column]).max()


def symmetry():
    """What needs a symmetric stiffness refuses with prestress and friction, in the same words."""
    for line in ("modes {} --damping 0.1", "respond {} --swell 7", "signal {} --method dense", "signal {} --method sparse", "signal {} --method verlet",
                 "signal {} --method lax-wendroff", "signal {} --damping 0.1", "spectrum dos {}", "spectrum transmission {}",
                 "spectrum dispersion {}", "spectrum harmonic {}", "spectrum participation {}", "spectrum continuum {}"):
        assert "symmetric stiffness" in refused("", *line.format(N200).split(), "--prestress", status=1), line


def moduli():
    found = table("moduli", N200, N600)
    assert found.names == ["file", "p", "C11", "C12", "C22", "C33", "c_l", "c_t", "C_err", "c_l_err", "c_t_err"]
    assert found.words("file") == [str(N200), str(N600)] and list(found["p"]) == [1e-4, 1e-4]
    pairs = [(found, k, network(path).moduli()) for k, path in enumerate((N200, N600))]
    for t, k, c in [*pairs, (table("moduli", N200, "--prestress"), 0, network(N200, True).turned_moduli())]:
        assert np.allclose([t[name][k] for name in ("C11", "C12", "C22", "C33")], [c[0, 0], c[0, 1], c[1, 1], c[2, 2]],
                           rtol=1e-9, atol=0), (t.rows, c)
    assert np.allclose(found["c_l"] / found["c_t"], np.sqrt(found["C22"] / found["C33"]), rtol=1e-12)
    # a chain has C22 and c_l only; c_l is l sqrt(K/m) (C3) but for its ends
    row = table("moduli", pack("chain.h5", kind="chain", grains=1000))
    overlap = 3e-4 ** (2 / 3)  # (A1) with E12 = 1/2, R12 = 1/4
    k = np.sqrt(overlap / 4)
    assert np.isclose(row["c_l"][0], (1 - overlap) * np.sqrt(k / (np.pi / 6)), rtol=1e-3)
    assert np.isclose(row["C22"][0], (1 - overlap) * k, rtol=2e-3) and np.isnan(row["C11"][0])
    # a file that is no good does not take the others along, but the exit status tells
    done = tried("moduli", "no_such_file", N200)
    assert done.returncode == 1 and names_all(done.stderr, "no_such_file") and str(N200) in done.stdout


def defaults():
    found = table("signal", N200)
    assert len(found) == 801 and np.isclose(found["t"][-1], 8 * found.note("height") + 40, rtol=1e-14)
    assert found.notes["source"] == "impulse"
    by_key = run("signal", N200, *sets("signal.points=11", 'signal.source="velocity"'), "--until", 20).stdout
    assert by_key == run("signal", N200, "--points", 11, "--source", "velocity", "--until", 20).stdout
    run("signal", N200, "--points", 5, "-o", "s.json")
    assert "F" in json.loads(pathlib.Path("s.json").read_text())["columns"]
    refused("s.json", "signal", N200, "--points", 5, "-o", "s.json")
    run("signal", N200, "--points", 5, "-o", "s.json", "--force")


main(modes, signals, published, symmetry, moduli, defaults)
