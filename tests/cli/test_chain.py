"""chain: tables against Bessel and Airy functions of scipy and the sum over modes, and packings of equal balls that go
through `pack', `signal' and `front'. The numerics of the closed form are in tests/unit/test_chain_closed.c.

usage: test_chain.py COMMAND SOURCE_DIR
"""
import numpy as np
from scipy.special import airy, jv

from command import main, pack, sets, table

MARKS = ["t10", "t_peak", "t_zero", "amplitude", "width", "width_peak", "gamma", "alpha", "alpha_peak"]


def bessel_sum(grains, initial, t):
    """With more echoes than any of the traces has."""
    terms = {"A": ((-3, 1), (-1, 1), (1, -1), (3, -1)), "B": ((-4, 1), (0, -2), (4, 1))}[initial]
    return sum(sign * jv(2 * m + order, 2 * t) for m in (grains + 1) * np.arange(1, 31, 2) for order, sign in terms)


def signals():
    for grains, tolerance in ((1, 2e-14), (20, 2e-14), (1000000, 1e-12)):  # scipy's own
        for initial in "AB":
            middle, unit = grains + 1, (grains + 1) ** (1 / 3)
            s = table("chain", "signal", "--grains", grains, "--initial", initial, "--start", max(0, middle - 6 * unit),
                      "--until", middle + 9 * unit, "--points", 61)
            assert s.names == ["t", "F", "airy"] and s.notes["grains"] == str(grains)
            assert np.abs(s["F"] - bessel_sum(grains, initial, s["t"])).max() < tolerance, (grains, initial)
            t = s["t"][1:]
            w = 2 * (grains - t) / t ** (1 / 3)
            limit = -8 * t ** (-2 / 3) * airy(w)[1] if initial == "A" else 16 * w * airy(w)[0] / t
            assert np.abs(s["airy"][1:] - limit).max() < 1e-13 * (1 + np.abs(limit).max()), (grains, initial)
    t = table("chain", "signal", "--grains", 30)["t"]
    assert len(t) == 1001 and t[0] == 0 and t[-1] == 62


def modes():
    for initial, wave in (("A", np.sin), ("B", np.cos)):
        m = table("chain", "modes", "--grains", 40, "--initial", initial)
        n = np.arange(1, 41)
        assert m.names == ["n", "omega", "a", "b"] and (m["n"] == n).all()
        assert np.allclose(m["omega"], 2 * np.sin(n * np.pi / 82), rtol=1e-15, atol=0)
        s = table("chain", "signal", "--grains", 40, "--initial", initial, "--until", 120, "--points", 200)
        total = (m["a"] * m["b"] * wave(m["omega"] * s["t"][:, None])).sum(axis=1)
        assert np.abs(total - s["F"]).max() < 1e-13  # omega t is rounded


def fronts():
    f = table("chain", "front", "--grains", "7,1000,2000")
    assert f.names == ["grains", *MARKS] and f["grains"].tolist() == [7, 1000, 2000]
    assert np.allclose(f["width"], f["t_zero"] - f["t10"]) and np.allclose(f["width_peak"], f["t_zero"] - f["t_peak"])
    for name, column in (("gamma", -np.log2(f["amplitude"])), ("alpha", np.log2(f["width"]))):
        assert abs(f[name][1] - (column[2] - column[1])) < 1e-12, name  # of 1000 the next length is there too
    for initial, gamma in (("A", 2 / 3), ("B", 1)):  # Table III of Somfai et al. 2005, to 10^6 balls
        f = table("chain", "front", "--initial", initial, "--grains", "10:1000000:10")
        assert f["grains"].tolist() == [10**k for k in range(1, 7)] and f.note("gamma_limit") == gamma
        assert abs(f["gamma"][-1] - gamma) < 1.2e-4 and abs(f["alpha"][-1] - 1 / 3) < 1.2e-4
        assert abs(f["amplitude"][-1] * 1e6**gamma / f.note("height_limit") - 1) < 3e-4
    assert table("chain", "front", "--grains", "2:9:1.2")["grains"].tolist() == [2, 3, 4, 5, 6, 7, 9]  # none twice
    assert len(table("chain", "front")) == 17


def packings():
    """By way of contacts, network and expansion, in the units of packings and in those of the chain."""
    for grains, pressure in ((50, 1e-4), (1000, 1e-6)):
        packing = pack("chain.h5", kind="chain", grains=grains, pressure=pressure)
        stiffness = 0.5 * np.cbrt(3 * pressure)  # Hertz: F = n^(3/2)/3
        period = np.sqrt(np.pi / 6 / stiffness)
        for initial, source in (("A", "impulse"), ("B", "displacement")):
            until = 1.05 * grains * period
            ours = table("signal", packing, "--source", source, "--until", until, "--points", 400)
            for scaled in (True, False):
                given = ("--pressure", pressure, "--until", until) if scaled else ("--until", until / period)
                s = table("chain", "signal", "--grains", grains, "--initial", initial, "--points", 400, *given)
                force = 1 if scaled else stiffness * (1 / period if initial == "A" else stiffness)
                # beside the engine's own bound: times are rounded, F' is below its own height
                slack = ours.note("error") + 1e-15 * grains * np.abs(ours["F"]).max()
                assert np.abs(s["F"] * force - ours["F"]).max() < slack, (grains, initial, scaled)
        row, f = table("front", packing), table("chain", "front", "--grains", grains, "--pressure", pressure)
        # straight lines and a parabola, ten points a unit of time at 1e-4
        assert all(np.isclose(row[name][0], f[name][0], rtol=2e-5) for name in MARKS[:4]), row.row()


def triangular_lattice():
    """Section V B: rows move like balls of a chain, whose ends differ: K_wall/K = 4/3^(5/6)/(1 + eta/3)."""
    rows, row, pressure = 60, 4, 1e-4
    for friction, eta in ((0, 0), (0.5, 1)):
        packing = "lattice.h5"
        made = table("pack", "--force", "-o", packing, *sets(kind="triangular", grains=rows * row, width=row,
                                                             pressure=pressure, friction=friction))
        overlap = 0
        for _ in range(50):  # sqrt(3) F = p (1 - overlap), F = overlap^(3/2)/3
            overlap = (np.sqrt(3) * pressure * (1 - overlap)) ** (2 / 3)
        stiffness = 1.5 * (0.5 * np.sqrt(overlap)) * (1 + eta / 3)  # of a row, a grain
        wall = np.cbrt(3 * pressure * (1 - overlap))
        ratio, period = wall / stiffness, np.sqrt(np.pi / 6 / stiffness)
        assert abs(ratio * (1 + eta / 3) / (4 / 3 ** (5 / 6)) - 1) < 0.3 * overlap
        ours = table("signal", packing, "--until", 2.9 * rows * period, "--points", 500)
        s = table("chain", "signal", "--grains", rows, "--wall", repr(ratio), "--until", 2.9 * rows, "--points", 500)
        force = row * wall / period  # first row of speed wall/m; K l (v/c) = sqrt(K m) v
        slack = ours.note("error") + 3e-12 * np.abs(ours["F"]).max()  # overlap by iteration, times rounded
        assert np.abs(s["F"] * force - ours["F"]).max() < slack, friction
        # Eqs. (18) and (19) of Somfai et al. 2005: under a strain all rows and walls carry the same stress
        compliance = made["height"][0] / table("moduli", packing)["C22"][0]
        assert np.isclose(compliance, (rows - 1) / stiffness + 2 / wall, rtol=10 * overlap), friction


main(signals, modes, fronts, packings, triangular_lattice)
