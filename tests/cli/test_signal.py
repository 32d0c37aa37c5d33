#!/usr/bin/env python3
"""signal, modes and moduli against numpy (network_oracle.py). Usage: test_signal.py COMMAND SOURCE_DIR"""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

from network_oracle import network
from common import names_all

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
REFERENCE = os.path.join(SOURCE, "packings", "reference")
N200 = os.path.join(REFERENCE, "packing_N200_p1e-4.txt")
N600 = os.path.join(REFERENCE, "packing_N600_p1e-4.txt")


def run(*words, status=0, cwd=None):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, cwd=cwd, timeout=1200)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    if status:
        assert done.stdout == "" and done.stderr.startswith("sonopack"), (words, done.stdout[:200], done.stderr)
    return done.stderr if status else done.stdout


def table(text):
    """Comments as a dict, the header row, and the rows as floats (text where they are none)."""
    comments, rows, header = {}, [], None
    for line in text.splitlines():
        if line.startswith("#"):
            key, _, value = line[1:].partition("=")
            comments[key.strip()] = value.strip()
        elif header is None:
            header = line.split("\t")
        else:
            rows.append(line.split("\t"))
    return comments, header, rows


def columns(text):
    comments, header, rows = table(text)
    return comments, {name: np.array([float(row[k]) for row in rows]) for k, name in enumerate(header)}


def test_modes(oracle, path, *options):
    comments, t = columns(run("modes", path, *options))
    exact = oracle.frequencies()
    zero = 3 * oracle.rattlers
    assert list(t) == ["n", "omega", "a", "b", "ab", "participation", "error"], list(t)
    assert np.array_equal(t["n"], np.arange(len(t["n"]))) and len(t["n"]) == zero + len(exact)
    assert np.all(t["omega"][:zero] == 0) and np.all(t["omega"][zero:] > 0)
    assert int(comments["zero_modes"]) == zero == int(comments["rattler_modes"])
    worst = np.max(np.abs(t["omega"][zero:] / exact - 1))
    print(f"{os.path.basename(path)} {' '.join(options)}: frequencies differ by {worst:.2g} at the most")
    assert worst < 1e-11, worst
    assert np.all(t["error"] < 1e-12) and np.allclose(t["ab"], t["a"] * t["b"], rtol=1e-14, atol=0)
    # amplitudes: the modal sum of the table is the signal
    times = np.linspace(0, 150, 40)
    f = np.sin(np.outer(times, t["omega"])) @ t["ab"]
    g = oracle.signal("impulse", times)
    assert np.max(np.abs(f - g)) < 1e-11 * np.max(np.abs(g))
    share = (oracle.vectors ** 2).reshape(-1, 3, len(exact)).sum(axis=1)  # of each grain that is no rattler
    gap = np.diff(oracle.squares) / oracle.squares[-1]
    lone = np.minimum(np.append(gap, 1), np.append(1, gap)) > 1e-6  # close modes may mix
    ratio = 1 / (len(share) * (share ** 2).sum(axis=0))
    assert np.max(np.abs(t["participation"][zero:] - ratio)[lone]) < 1e-8
    _, bare = columns(run("modes", path, "--frequencies-only", *options))
    assert list(bare) == ["n", "omega", "error"]
    assert np.all(np.abs(bare["omega"] - t["omega"]) <= bare["error"] + t["error"])
    _, few = columns(run("modes", path, "--lowest", 5, *options))  # beyond the rattlers', by their numbers
    assert np.array_equal(few["n"], np.arange(zero, zero + 5))
    assert np.all(np.abs(few["omega"] - t["omega"][zero:zero + 5]) <= few["error"] + t["error"][zero:zero + 5])


def test_signals(oracle, path, *options):
    for source in ("impulse", "velocity", "displacement"):
        for method in ("auto", "chebyshev") + (() if options else ("dense",)):
            words = ["signal", path, "--source", source, "--method", method, "--until", 300, "--points", 301, *options]
            comments, t = columns(run(*words))
            exact = oracle.signal(source, np.linspace(0, 300, 301))
            peak = np.max(np.abs(exact))
            assert list(t) == ["t", "F"] and np.array_equal(t["t"], np.linspace(0, 300, 301))
            assert np.max(np.abs(t["F"] - exact)) < 2e-12 * peak, (source, method, options)
            assert float(comments["error"]) < 1e-10 * peak
            assert comments["method"] == ("dense" if method == "dense" else "chebyshev")
            assert float(comments["height"]) == oracle.height and float(comments["pressure"]) == 1e-4


def test_symmetry():
    """What needs a symmetric stiffness refuses with prestress and friction, in the same words."""
    for words in (["modes", N200], ["modes", N200, "--lowest", 3], ["modes", N200, "--frequencies-only"],
                  ["modes", N200, "--damping", 0.1], ["signal", N200, "--method", "dense"],
                  ["signal", N200, "--method", "sparse"], ["signal", N200, "--method", "verlet"],
                  ["signal", N200, "--method", "lax-wendroff"], ["signal", N200, "--damping", 0.1],
                  ["spectrum", "dos", N200], ["spectrum", "transmission", N200], ["spectrum", "dispersion", N200],
                  ["spectrum", "harmonic", N200], ["spectrum", "participation", N200],
                  ["spectrum", "continuum", N200]):
        assert "needs a symmetric stiffness" in run(*words, "--prestress", status=1), words


def test_oracle(path):
    """The signals that came with the packings."""
    oracle = np.loadtxt(path.replace("packing_", "signal_"))
    for source, exact in (("velocity", oracle[:, 1]), ("impulse", oracle[:, 2])):
        _, t = columns(run("signal", path, "--until", 400, "--points", 801, "--source", source, "--threshold", 1e-4))
        assert np.allclose(t["t"], oracle[:, 0], rtol=1e-14)
        assert np.max(np.abs(t["F"] - exact)) < 1e-9 * np.max(np.abs(exact))


def test_moduli():
    _, header, rows = table(run("moduli", N200, N600))
    assert header == ["file", "p", "C11", "C12", "C22", "C33", "c_l", "c_t"]
    assert [row[0] for row in rows] == [N200, N600]
    for row, oracle in zip(rows, (network(N200), network(N600))):
        p, c11, c12, c22, c33, c_l, c_t = map(float, row[1:])
        c = oracle.moduli()
        assert p == 1e-4
        assert np.allclose([c11, c12, c22, c33], [c[0, 0], c[0, 1], c[1, 1], c[2, 2]], rtol=1e-9, atol=0)
        assert np.isclose(c_l / c_t, np.sqrt(c22 / c33), rtol=1e-12)
        assert 0.45 < c22 / c_l**2 < 0.6  # Phi3*
    ours = [float(x) for x in table(run("moduli", N200, "--prestress"))[2][0][2:6]]
    c = network(N200, True).turned_moduli()
    assert np.allclose(ours, [c[0, 0], c[0, 1], c[1, 1], c[2, 2]], rtol=1e-9, atol=0), (ours, c)
    # a chain has C22 and c_l only; c_l is l sqrt(K/m) (C3) but for its ends
    grains, pressure = 1000, 1e-4
    with tempfile.TemporaryDirectory() as folder:
        chain = os.path.join(folder, "chain.h5")
        run("pack", "--set", "packing.kind=chain", "--set", f"packing.grains={grains}", "-o", chain)
        c22, c_l = (float(table(run("moduli", chain))[2][0][k]) for k in (4, 6))
    overlap = (3 * pressure) ** (2 / 3)  # (A1) with E12 = 1/2, R12 = 1/4
    k = np.sqrt(overlap / 4)
    assert np.isclose(c_l, (1 - overlap) * np.sqrt(k / (np.pi / 6)), rtol=1 / grains)
    assert np.isclose(c22, (1 - overlap) * k, rtol=2 / grains)
    # a file that is no good does not take the others along, but the exit status tells
    done = subprocess.run([COMMAND, "moduli", "no_such_file", N200], capture_output=True, text=True)
    assert done.returncode == 1 and names_all(done.stderr, "no_such_file") and len(table(done.stdout)[2]) == 1


def test_defaults():
    comments, t = columns(run("signal", N200))
    height = float(comments["height"])
    assert len(t["t"]) == 801 and np.isclose(t["t"][-1], 8 * height + 40, rtol=1e-14)
    assert comments["source"] == "impulse"
    a = run("signal", N200, "--set", "signal.points=11", "--set", "signal.source=\"velocity\"", "--until", 20)
    b = run("signal", N200, "--points", 11, "--source", "velocity", "--until", 20)
    assert a == b
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "s.json")
        run("signal", N200, "--points", 5, "-o", out)
        assert "F" in json.dumps(json.load(open(out)))
        run("signal", N200, "--points", 5, "-o", out, status=2)  # not silently again
        run("signal", N200, "--points", 5, "-o", out, "--force")


if __name__ == "__main__":
    for prestress in (False, True):
        options = ["--prestress"] if prestress else []
        if not prestress:
            test_modes(network(N200), N200)
        test_signals(network(N200, prestress), N200, *options)
    test_modes(network(N600), N600)
    test_symmetry()
    for path in (N200, N600):
        test_oracle(path)
    test_moduli()
    test_defaults()
    print("passed")
