"""The arithmetic of benchmarks/leap_distance: influences and exponents, one curve through series with correlated errors,
the lengths that fit best, the fit of the attenuation, and fronts of a wave whose attenuation is known.

usage: test_leap_distance.py COMMAND SOURCE_DIR
"""
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(sys.argv[2]) / "benchmarks"))
import numpy as np

import coherent_front
import leap_collapse
import leap_wave

PLANES = np.array([8.0, 16.0, 32.0, 64.0, 128.0])


def errors_of_means():
    """For a mean the jackknife gives the standard error, and products of influences the covariance."""
    packings = [np.array(v) for v in np.random.default_rng(1).normal(size=(9, 2))]
    value, pull = leap_collapse.influences(lambda some: np.mean(some, 0), packings)
    assert np.allclose(value, np.mean(packings, 0))
    assert np.allclose(leap_collapse.errors(pull), np.std(packings, 0, ddof=1) / 3)
    assert np.allclose(pull.T @ pull, np.cov(np.array(packings).T) / 9)


def powers():
    assert np.allclose(leap_collapse.exponents(PLANES, 3 * PLANES**-1.7), -1.7)
    assert np.allclose(leap_collapse.middles(PLANES), PLANES[:-1] * 2**0.5)
    x = np.linspace(0, 2, 7)
    slope, error, left = leap_collapse.line(x, 1 + 0.4 * x, np.full(7, 0.1))
    assert np.isclose(slope, 0.4) and left < 1e-12 and np.isclose(error, 0.1 / np.sqrt(((x - 1)**2).sum()))


def curve(x):
    return 1 + 0.5 / (1 + np.exp(x - 1))


def some_series(random, lengths, noise, count=8, own=0.0):
    """Series on `curve', each a mean over packings whose values at neighbouring planes scatter together, and each point
    with a scatter of its own that all packings share."""
    out = []
    for length in lengths:
        at = leap_collapse.middles(PLANES)
        steps = random.normal(size=(count, len(at) + 1)) * noise
        packings = list(curve(np.log(at / length)) + np.diff(steps, axis=1) + own * random.normal(size=len(at)))
        value, pull = leap_collapse.influences(lambda some: np.mean(some, 0), packings)
        out.append(leap_collapse.Series(at, value, pull, length, np.zeros(count)))
    return out


def one_curve():
    """chi^2 is that of its degrees of freedom when the lengths are right, and far beyond when there are none; scatter
    that is put in comes out."""
    random, lengths = np.random.default_rng(2), np.geomspace(2, 20, 8)
    ratios, wrong, found = [], [], []
    for _ in range(30):
        fit = leap_collapse.collapse(some_series(random, lengths, 0.03), with_scatter=False)
        assert fit.freedom == 32 - 4
        ratios.append(fit.chi2 / fit.freedom)
        series = some_series(random, lengths, 0.03)
        for s in series:
            s.length = 1.0
        wrong.append(leap_collapse.collapse(series).chi2 / fit.freedom)
    assert 0.8 < np.mean(ratios) < 1.3, np.mean(ratios)
    assert min(wrong) > 4, min(wrong)
    for _ in range(10):
        found.append(leap_collapse.collapse(some_series(random, lengths, 0.01, own=0.05)).scatter)
    assert 0.04 < np.mean(found) < 0.06, found
    at = np.log(leap_collapse.middles(PLANES) / 5)
    assert np.abs(fit.at(at) - curve(at)).max() < 0.03
    step = 1e-4
    assert np.allclose(fit.slope(at), (fit.at(at + step) - fit.at(at - step)) / (2 * step), rtol=1e-5, atol=1e-8)


def errors_of_lengths_count():
    """A length with an error of 20% explains what it moves."""
    series = some_series(np.random.default_rng(3), np.geomspace(2, 20, 8), 0.004)
    sure = leap_collapse.collapse(series).chi2
    random = np.random.default_rng(4)
    for s in series:
        factor = np.exp(0.2 * random.normal())
        s.length *= factor
    off = leap_collapse.collapse(series).chi2
    for s in series:
        s.length_pull = 0.2 * s.length * random.normal(size=8) / 8**0.5
    known = leap_collapse.collapse(series).chi2
    assert off > 5 * sure and known < 0.5 * off, (sure, off, known)


def missing_planes():
    """A lower box has no last interval."""
    series = some_series(np.random.default_rng(5), np.geomspace(2, 20, 6), 0.02)
    low = series[2]
    series[2] = leap_collapse.Series(low.distance[:-1], low.value[:-1], low.pull[:, :-1], low.length, low.length_pull)
    fit = leap_collapse.collapse(series)
    assert fit.freedom == 23 - 4 and fit.chi2 < 2 * fit.freedom


def lengths_come_back():
    random, lengths = np.random.default_rng(6), np.geomspace(3, 12, 7)
    series = some_series(random, lengths, 0.005)
    for s in series:
        s.length *= np.exp(random.uniform(-0.3, 0.3))
    before = [np.log(s.length) for s in series]
    found, wrong, _ = leap_collapse.best_lengths([series])
    assert np.isclose(np.log(found).mean(), np.mean(before))
    left = np.log(found / lengths)
    left -= left.mean()
    assert np.abs(left).max() < 0.12 and np.abs(left).max() < 0.5 * np.ptp(before - np.log(lengths)), left
    assert (wrong < 0.2).all()


def attenuation():
    """The fit finds plateau, crossover and exponent, and from them the length of scattering."""
    k = np.geomspace(0.05, 1.5, 40)
    factors = np.array([np.log(0.2), np.log(0.4), 2.6])
    assert np.allclose(leap_wave.fit(k, leap_wave.law(k, factors)), factors, atol=1e-4)
    kind = (2, 24.0, 4000, 1e-4, 0.5, "affine")
    sample = {"kind": kind, "omega": 0.2 * k, "k": k, "alpha": k * leap_wave.law(k, factors), "c_l": 0.2}
    found = leap_wave.crossover([sample])
    assert np.isclose(found["k_s"], 0.4 * 3**(-1 / 2.6), rtol=1e-3), found
    assert np.isclose(leap_wave.law(found["k_s"], factors), leap_wave.PER_WAVE, rtol=1e-3)


def fronts_of_rayleigh():
    """Without dispersion and with alpha = a k^3 a front moves at c, and far off falls as y^(-2/3) and widens as
    y^(1/3)."""
    w = np.geomspace(0.005, 0.6, 48)
    k, y = w / 0.2, np.array([200.0, 400.0, 800.0])
    speed, factor, marks = coherent_front.fronts(w, k, 0.5 * k**3, y, 0.02, lambda y: (y / 0.2 - 200, y / 0.2 + 150),
                                                 points=2500)
    assert np.isclose(speed, 0.2) and np.isclose(factor, 0.5)
    assert np.allclose(leap_collapse.exponents(y, marks[:, 3]), -2 / 3, atol=0.01), marks
    assert np.allclose(leap_collapse.exponents(y, marks[:, 2] - marks[:, 0]), 1 / 3, atol=0.01)
    assert np.allclose(leap_collapse.exponents(y, y / 0.2 - marks[:, 0]), 1 / 3, atol=0.02)


for test in (errors_of_means, powers, one_curve, errors_of_lengths_count, missing_planes, lengths_come_back, attenuation,
             fronts_of_rayleigh):
    test()
    print(test.__name__, "ok")
