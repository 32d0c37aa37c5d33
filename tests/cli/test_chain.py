"""sonopack chain: against Bessel and Airy functions of scipy, the sum over modes, and packings of equal balls that go
through `pack', `signal' and `front'; lists of lengths; wrong use.

usage: test_chain.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.special import airy, jv

from common import names_all

COMMAND = sys.argv[1]
MARKS = ["t10", "t_peak", "t_zero", "amplitude", "width", "width_peak", "gamma", "alpha", "alpha_peak"]


def run(*arguments, status=0, reason=""):
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=1200)
    line = done.stderr.split("\n")[0]
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    assert not status or names_all(line, reason), (arguments, done.stderr)
    assert status == 0 or (line.startswith("sonopack") and not done.stdout), (arguments, line)
    return done.stdout


def table(text):
    """Columns by name, comments by key."""
    lines = text.splitlines()
    notes = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("#") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    values = np.array([[float(word) for word in row] for row in rows[1:]])
    return {name: values[:, k] for k, name in enumerate(rows[0])}, notes


def chain(*arguments):
    return table(run("chain", *arguments))


def bessel_sum(grains, initial, t):
    """With more echoes than any of the traces has."""
    terms = {"A": ((-3, 1), (-1, 1), (1, -1), (3, -1)), "B": ((-4, 1), (0, -2), (4, 1))}[initial]
    return sum(sign * jv(2 * m + order, 2 * t) for m in (grains + 1) * np.arange(1, 31, 2) for order, sign in terms)


def signals():
    for grains, tolerance in ((1, 2e-14), (20, 2e-14), (1000, 1e-13), (1000000, 1e-12)):  # scipy's own
        for initial in "AB":
            middle, unit = grains + 1, (grains + 1) ** (1 / 3)
            s, notes = chain("signal", "--grains", grains, "--initial", initial, "--start", max(0, middle - 6 * unit),
                             "--until", middle + 9 * unit, "--points", 61)
            assert list(s) == ["t", "F", "airy"] and notes["grains"] == str(grains)
            assert np.abs(s["F"] - bessel_sum(grains, initial, s["t"])).max() < tolerance, (grains, initial)
            t = s["t"][1:]
            w = 2 * (grains - t) / t ** (1 / 3)
            limit = -8 * t ** (-2 / 3) * airy(w)[1] if initial == "A" else 16 * w * airy(w)[0] / t
            assert np.abs(s["airy"][1:] - limit).max() < 1e-13 * (1 + np.abs(limit).max()), (grains, initial)
    default, _ = chain("signal", "--grains", 30)
    assert len(default["t"]) == 1001 and default["t"][0] == 0 and default["t"][-1] == 62


def modes():
    for initial, wave in (("A", np.sin), ("B", np.cos)):
        m, _ = chain("modes", "--grains", 40, "--initial", initial)
        n = np.arange(1, 41)
        assert list(m) == ["n", "omega", "a", "b"] and (m["n"] == n).all()
        assert np.allclose(m["omega"], 2 * np.sin(n * np.pi / 82), rtol=1e-15, atol=0)
        s, _ = chain("signal", "--grains", 40, "--initial", initial, "--until", 120, "--points", 200)
        total = (m["a"] * m["b"] * wave(m["omega"] * s["t"][:, None])).sum(axis=1)
        assert np.abs(total - s["F"]).max() < 1e-13  # omega t is rounded


def fronts():
    f, notes = chain("front", "--grains", "7,1000,2000")
    assert list(f) == ["grains", *MARKS] and f["grains"].tolist() == [7, 1000, 2000]
    assert np.allclose(f["width"], f["t_zero"] - f["t10"]) and np.allclose(f["width_peak"], f["t_zero"] - f["t_peak"])
    # of 1000 the next length is there too
    for name, column in (("gamma", -np.log2(f["amplitude"])), ("alpha", np.log2(f["width"])),
                         ("alpha_peak", np.log2(f["width_peak"]))):
        assert abs(f[name][1] - (column[2] - column[1])) < 1e-12, name
    assert float(notes["gamma_limit"]) == 2 / 3 and float(notes["alpha_limit"]) == 1 / 3
    # Table III of Somfai et al. 2005, from 10 to 10^6 balls
    for initial, gamma in (("A", 2 / 3), ("B", 1)):
        f, notes = chain("front", "--initial", initial, "--grains", "10:1000000:10")
        assert f["grains"].tolist() == [10, 100, 1000, 10000, 100000, 1000000]
        assert float(notes["gamma_limit"]) == gamma
        for name, limit in (("gamma", gamma), ("alpha", 1 / 3), ("alpha_peak", 1 / 3)):
            off = np.abs(f[name] - limit)
            assert (np.diff(off[1:]) < 0).all() and off[-1] < 1.2e-4, (initial, name, off)
        assert abs(f["amplitude"][-1] * 1e6 ** gamma / float(notes["height_limit"]) - 1) < 3e-4
        assert abs(f["width"][-1] / 100 / float(notes["width_limit"]) - 1) < 3e-4
    dense, _ = chain("front", "--grains", "2:9:1.2")
    assert dense["grains"].tolist() == [2, 3, 4, 5, 6, 7, 9]  # 2, 2.4, 2.88, ... rounded, none twice
    assert len(chain("front")[0]["grains"]) == 17


def general_engine(folder):
    """Packings of equal balls by way of contacts, network and expansion, in the units of packings."""
    for grains, pressure in ((50, 1e-4), (1000, 1e-6), (10000, 1e-4)):
        packing = folder / f"chain{grains}.h5"
        run("pack", "--set", "packing.kind=chain", "--set", f"packing.grains={grains}", "--set",
            f"packing.pressure={pressure}", "-o", packing)
        stiffness, mass = 0.5 * np.cbrt(3 * pressure), np.pi / 6  # Hertz: F = n^(3/2)/3
        period = np.sqrt(mass / stiffness)
        for initial, source in (("A", "impulse"), ("B", "displacement")):
            until = 1.05 * grains * period
            ours, notes = table(run("signal", packing, "--source", source, "--until", until, "--points", 400))
            for scaled in (True, False):
                given = ("--pressure", pressure, "--until", until) if scaled else ("--until", until / period)
                s, _ = chain("signal", "--grains", grains, "--initial", initial, "--points", 400, *given)
                force = 1 if scaled else stiffness * (1 / period if initial == "A" else stiffness)
                # beside the engine's own bound: times are rounded, F' is below its own height
                slack = float(notes["error"]) + 1e-15 * grains * np.abs(ours["F"]).max()
                assert np.abs(s["F"] * force - ours["F"]).max() < slack, (grains, initial, scaled)
        if grains <= 1000:  # a longer trace has crests five times as high as the first
            row = run("front", packing).splitlines()[-1].split("\t")
            f, _ = chain("front", "--grains", grains, "--pressure", pressure)
            # straight lines and a parabola, ten points a unit of time at 1e-4
            assert np.allclose([float(word) for word in row[2:6]], [f[name][0] for name in MARKS[:4]], rtol=2e-5), row


def triangular_lattice(folder):
    """Section V B: rows move like balls of a chain, whose ends differ: K_wall/K = 4/3^(5/6)/(1 + eta/3)."""
    rows, row, pressure = 60, 4, 1e-4
    for friction, eta in ((0, 0), (0.5, 1)):
        packing = folder / f"lattice{friction}.h5"
        run("pack", "--set", "packing.kind=triangular", "--set", f"packing.grains={rows * row}", "--set",
            f"packing.width={row}", "--set", f"packing.pressure={pressure}", "--set", f"packing.friction={friction}",
            "-o", packing)
        overlap = 0
        for _ in range(50):  # sqrt(3) F = p (1 - overlap), F = overlap^(3/2)/3
            overlap = (np.sqrt(3) * pressure * (1 - overlap)) ** (2 / 3)
        stiffness = 1.5 * (0.5 * np.sqrt(overlap)) * (1 + eta / 3)  # of a row, a grain
        wall = np.cbrt(3 * pressure * (1 - overlap))
        ratio, period = wall / stiffness, np.sqrt(np.pi / 6 / stiffness)
        assert abs(ratio * (1 + eta / 3) / (4 / 3 ** (5 / 6)) - 1) < 0.3 * overlap
        ours, notes = table(run("signal", packing, "--until", 2.9 * rows * period, "--points", 500))
        s, _ = chain("signal", "--grains", rows, "--wall", repr(ratio), "--until", 2.9 * rows, "--points", 500)
        force = row * wall / period  # first row of speed wall/m; K l (v/c) = sqrt(K m) v
        slack = float(notes["error"]) + 3e-12 * np.abs(ours["F"]).max()  # overlap by iteration, times rounded
        assert np.abs(s["F"] * force - ours["F"]).max() < slack, friction


def main():
    signals()
    modes()
    fronts()
    with tempfile.TemporaryDirectory() as folder:
        general_engine(pathlib.Path(folder))
        triangular_lattice(pathlib.Path(folder))


if __name__ == "__main__":
    main()
