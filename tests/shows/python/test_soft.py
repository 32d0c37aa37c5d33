"""Soft modes: the estimators on drawn modes, plane waves of a crystal and a heavy grain in it, pooled counts, the figure."""
import matplotlib
import numpy as np
import pytest
from common import command, raised

import sonopack
from sonopack import plot

matplotlib.use("agg")
SEED, TRIALS = 20261129, 200


def drawn(random, exponent, low, n):
    """n frequencies below 1 with a density ~ omega^exponent above low, from the inverse of its integral."""
    s = exponent + 1
    return (low**s + random.random(n) * (1 - low**s)) ** (1 / s)


def within_two(found, exponent):
    """Of 200 trials with normal errors 191 +- 3 are within two errors; the means have no bias beyond 3 of their errors."""
    off = np.array([(law.exponent - exponent) / law.error for law in found])
    print("seed", SEED, "inside", np.sum(np.abs(off) < 2), "bias", off.mean())
    return 0.905 < np.mean(np.abs(off) < 2) < 0.995 and abs(off.mean()) < 3 / np.sqrt(TRIALS) + 0.07


def test_exponents_and_their_errors():
    """Also between two limits, of a falling density, and where each mode of a packing comes twice: half as much is known.
    The estimate of s = exponent + 1 is 1/n too large: 0.07 errors for 200 modes."""
    random = np.random.default_rng(SEED)
    for exponent, low, twice in ((4, 0, 1), (2.5, 0.6, 1), (-2, 0.1, 1), (4, 0, 2)):
        found = []
        for _ in range(TRIALS):
            x, packing = drawn(random, exponent, low, 200), np.arange(200) // 2
            found.append(sonopack.power_law(np.repeat(x, twice), low, 1.0, np.repeat(packing, twice), draws=0))
        assert within_two(found, exponent), (exponent, low, twice)


def test_goodness():
    """It is as often below any share as that share says if the law is true, and small if it is not."""
    random = np.random.default_rng(SEED)
    true = [sonopack.power_law(drawn(random, 4, 0, 100), 0, 1).goodness for _ in range(TRIALS)]
    assert abs(np.mean(true) - 0.5) < 3 * 12**-0.5 / TRIALS**0.5 and 0.02 < np.mean(np.array(true) < 0.1) < 0.2
    mixed = np.concatenate([drawn(random, 1, 0, 200), drawn(random, 9, 0, 200)])
    assert sonopack.power_law(mixed, 0, 1).goodness < 0.02


def pooled(packing, omega, phonon=0.0, first=3.0):
    n = np.full(len(omega), 1)
    return sonopack.SoftModes({"packing": packing, "omega": omega, "participation": 0.1 * n, "phonon": phonon * n,
                               "first": first * n, "dofs": 300 * n})


def test_the_lowest_mode_alone():
    """Of independent modes with a density ~ omega^4 up to 2; in a third of the packings none is below 1, the limit."""
    random = np.random.default_rng(SEED)
    def one():
        modes = random.poisson(32, 200) + 1  # the first is that at 2, so that no packing is empty
        omega = np.concatenate([np.r_[2, np.sort(2 * drawn(random, 4, 0, k - 1))[::-1]][::-1] for k in modes])
        return pooled(np.repeat(np.arange(200), modes), omega).lowest_law(1.0)
    assert within_two([one() for _ in range(TRIALS)], 4)


def crystal(held=1.0, n=12):
    """Equal disks on a triangular lattice in a cell of its own shape; springs of one may be softer than the others."""
    a, k = 0.999, np.arange(n * n)
    column, row = k % n, k // n
    x = np.stack([a * (column + 0.5 * row), a * np.sqrt(0.75) * row, 0 * k], 1)
    pairs = [(i, (c + dc) % n + n * ((r + dr) % n)) for i, c, r in zip(k, column, row) for dc, dr in ((1, 0), (0, 1), (-1, 1))]
    i, j = np.array([sorted(pair) for pair in pairs]).T
    springs = {"i": i, "j": j, "kn": np.where((i == 50) | (j == 50), held, 1.0), "kt": np.zeros(len(i))}
    return sonopack.Packing.from_arrays(x, np.full(n * n, 0.5), springs, box=(n * a, n * a * np.sqrt(0.75)), cell="periodic",
                                        tilt=(n * a / 2, 0, 0), pressure=1e-4, friction=0.0)


def test_phonons_of_a_crystal():
    """All its modes are plane waves. The nominal frequency is that of long waves: omega is lower by less than (k a)^2/12.
    A grain on springs of 1% moves alone, at omega^2 = 3 k/m, and is no phonon."""
    soft = sonopack.soft_modes([crystal()], lowest=24)
    step = 4 * np.pi / np.sqrt(3) / 12
    assert soft.is_phonon.all() and soft.phonon.min() > 1 - 1e-8
    assert 1 - step**2 / 12 < soft.omega[0] / soft.first[0] < 1 and np.ptp(soft.omega[:6]) < 1e-8 * soft.omega[0]
    loose = sonopack.soft_modes([crystal(0.01)], lowest=24)
    alone = loose.participation < 0.05
    assert alone[:2].all() and np.array_equal(alone, ~loose.is_phonon)
    assert np.allclose(loose.omega[:2]**2, 0.03 / (np.pi / 6), rtol=0.03)  # the others give way by some k'/k


def test_pooled_counts(tmp_path, monkeypatch):
    """Counts in bins, by any number of threads, from a store, its table and the figure."""
    monkeypatch.chdir(tmp_path)
    scene = sonopack.Scene(packing={"kind": "minimum", "cell": "periodic", "friction": 0, "dimension": 3, "grains": 150,
                                    "pressure": 1e-2}, study={"samples": 6, "want": ["packings"]})
    samples = sonopack.study(scene, sonopack.Store("store", create=True)).samples()
    soft = sonopack.soft_modes(samples, lowest=20, prestress=True)
    again = sonopack.soft_modes(samples, lowest=20, prestress=True, threads=3).table()
    assert again.text() == soft.table().text()
    edges = np.linspace(0, 0.999 * soft.complete, 8)
    for phonons, use in ((True, soft.omega > 0), (False, ~soft.is_phonon)):
        counts = np.histogram(soft.omega[use], edges)[0]
        assert np.allclose(soft.density(edges, phonons)[0] * np.diff(edges) * soft.dofs.sum(), counts)
    command("plot", "softmodes", "--store", "store", "--lowest", 20, "--set", "network.prestress=true", "--table", "s.tsv", "-o", "s.svg")
    read = sonopack.SoftModes.of_table(sonopack.Table.read("s.tsv"))
    assert read.table().text() == soft.table().text()
    axes, law = plot.softmodes("s.tsv"), soft.best()
    line = next(line for line in axes[0].lines if "omega^" in str(line.get_label())).get_xydata()
    slope, _ = np.polyfit(*np.log(line.T), 1)
    assert slope == pytest.approx(law.exponent) and line[-1, 0] == pytest.approx(law.high)
    between = np.trapezoid if hasattr(np, "trapezoid") else np.trapz
    below = line[0, 0] ** (law.exponent + 1) / law.high ** (law.exponent + 1)
    assert between(line[:, 1], line[:, 0]) * soft.dofs.sum() == pytest.approx(law.modes * (1 - below), rel=0.01)


def test_refusals():
    piston = sonopack.Packing.make(sonopack.Scene(packing={"grains": 40, "width": 6}))
    assert "must be periodic" in str(raised(sonopack.InvalidInput, sonopack.soft_modes, [piston]))
    assert "3 or more" in str(raised(sonopack.InvalidInput, sonopack.power_law, [1.0, 2.0]))
    assert "none" in str(raised(sonopack.InvalidInput, sonopack.soft_modes, []))
    assert "30 or more" in str(raised(sonopack.InvalidInput, pooled([1, 1], np.array([1.0, 2.0])).scan))
