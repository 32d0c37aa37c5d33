"""Whether curves of several series fall on one when their distances are measured in a length of each series: the
arithmetic of the benchmark `leap_distance', tested by tests/cli/test_leap_distance.py.

A series is a kind of packing. Its numbers (speeds and exponents between planes, and its length) come from the same
packings, so they are correlated. Everything is therefore computed from influences: what leaving out one packing at a
time does to each number.
"""
import dataclasses

import numpy as np


@dataclasses.dataclass
class Series:
    """One quantity at several distances, and a length. `pull` [packing][distance] and `length_pull` [packing] are the
    influences of the packings: the covariance of the numbers is the sum over packings of their products."""
    distance: np.ndarray
    value: np.ndarray
    pull: np.ndarray
    length: float
    length_pull: np.ndarray


def influences(number, packings):
    """The numbers of all packings, and the influence of each packing by the jackknife, [packing][number].
    `number' makes the numbers from a list of packings."""
    whole = np.asarray(number(packings), float)
    left = np.array([number(packings[:k] + packings[k + 1:]) for k in range(len(packings))], float)
    n = len(packings)
    return whole, np.sqrt((n - 1) / n) * (left - left.mean(0))


def errors(pull):
    return np.sqrt((pull**2).sum(0))


def exponents(distance, value):
    """Of each interval: s of value ~ distance^s."""
    return np.diff(np.log(value)) / np.diff(np.log(distance))


def middles(distance):
    return np.sqrt(distance[1:] * distance[:-1])


# ---- one curve -------------------------------------------------------------------------------------------------------

def basis(x, ends, degree):
    """Legendre's polynomials of x, whose ends are mapped to -1 and 1, and their derivatives by x."""
    scale = 2 / (ends[1] - ends[0])
    u = (x - ends[0]) * scale - 1
    p = np.polynomial.legendre
    unit = np.eye(degree + 1)
    return p.legval(u, unit).T, np.array([p.legval(u, p.legder(row)) * scale for row in unit]).T


def pooled(covariances):
    """Covariances of few packings each are too noisy to be inverted. Series differ mostly by a factor, and distances by
    another: variances become products of both, and one matrix of correlations is that of all series. Entries of
    distances that a series lacks are nan."""
    c = np.array(covariances)
    variance = np.array([np.diag(m) for m in c])
    of_series, of_distance = np.ones(len(c)), np.nanmean(variance, 0)
    for _ in range(20):
        of_series = np.nanmean(variance / of_distance, 1)
        of_distance = np.nanmean(variance / of_series[:, None], 0)
    smooth = np.sqrt(of_series[:, None] * of_distance)
    together = np.nanmean(c / (smooth[:, :, None] * smooth[:, None, :]), 0)
    size = np.sqrt(np.diag(together))
    together /= size[:, None] * size[None, :]
    return [s[:, None] * together * s[None, :] for s in smooth]


def covariances(series, slopes, count):
    """Pooled covariances of what is left of each series when the curve of these slopes is subtracted: an error of the
    length moves the curve."""
    out = []
    for s, slope in zip(series, slopes):
        left = s.pull + s.length_pull[:, None] / s.length * slope
        c = np.full((count, count), np.nan)
        c[:left.shape[1], :left.shape[1]] = left.T @ left
        out.append(c)
    return [c[:len(s.value), :len(s.value)] for s, c in zip(series, pooled(out))]


@dataclasses.dataclass
class Curve:
    """The curve that fits all series best. `scatter' is the departure of the points, beyond their errors, that would
    make chi^2 equal to its degrees of freedom."""
    chi2: float
    freedom: int
    scatter: float
    ends: tuple
    factors: np.ndarray
    covariance: list

    def at(self, x):
        return basis(np.asarray(x), self.ends, len(self.factors) - 1)[0] @ self.factors

    def slope(self, x):
        return basis(np.asarray(x), self.ends, len(self.factors) - 1)[1] @ self.factors


def scaled(s):
    return np.log(s.distance / s.length)


def least_squares(designs, values, covariance, extra=0.0):
    """Factors and chi^2 with the covariances, whose diagonals get extra^2."""
    normal, right = 0, 0
    weights = [np.linalg.inv(c + extra**2 * np.eye(len(c))) for c in covariance]
    for p, y, w in zip(designs, values, weights):
        normal, right = normal + p.T @ w @ p, right + p.T @ w @ y
    factors = np.linalg.pinv(normal, rcond=1e-10, hermitian=True) @ right  # without lengths, planes are few points
    left = [y - p @ factors for p, y in zip(designs, values)]
    return factors, sum(r @ w @ r for r, w in zip(left, weights))


def scatter_of(designs, values, covariance, freedom):
    """The extra scatter with which chi^2 is as large as its degrees of freedom; 0 where it is smaller anyway."""
    if least_squares(designs, values, covariance)[1] <= freedom:
        return 0.0
    low, high = 0.0, 10 * max(np.ptp(y) for y in values) + 10 * np.std([y.mean() for y in values])
    for _ in range(50):
        middle = 0.5 * (low + high)
        if least_squares(designs, values, covariance, middle)[1] > freedom:
            low = middle
        else:
            high = middle
    return high


def collapse(series, degree=3, with_scatter=True):
    """One polynomial in ln(distance/length) through all series, by least squares with all correlations."""
    x = [scaled(s) for s in series]
    ends = min(a.min() for a in x), max(a.max() for a in x)
    both = [basis(a, ends, degree) for a in x]
    designs, values = [b[0] for b in both], [s.value for s in series]
    factors, count = np.zeros(degree + 1), max(len(s.value) for s in series)
    for _ in range(4):  # the effect of errors of the lengths depends on the slope of the curve
        covariance = covariances(series, [b[1] @ factors for b in both], count)
        factors, chi2 = least_squares(designs, values, covariance)
    freedom = sum(len(v) for v in values) - np.linalg.matrix_rank(np.concatenate(designs))
    scatter = scatter_of(designs, values, covariance, freedom) if with_scatter else np.nan
    return Curve(chi2, freedom, scatter, ends, factors, covariance)


# ---- the best length -------------------------------------------------------------------------------------------------

STEPS = np.linspace(-0.5, 0.5, 101)


def own_chi2(curves, group):
    """chi^2 of one series, of which `group' has several quantities, if its length were larger by e^STEPS."""
    total = 0
    for (curve, k), s in zip(curves, group):
        x = np.clip(scaled(s)[:, None] - STEPS, *curve.ends)  # polynomials are wild beyond the points
        left = s.value[:, None] - curve.at(x.ravel()).reshape(x.shape)
        total = total + (left * np.linalg.solve(curve.covariance[k], left)).sum(0)
    return total


def best_step(curves, group):
    """The step in ln length with the least chi^2, and its error: from where chi^2 is larger by 1."""
    values = own_chi2(curves, group)
    low = values.argmin()
    inside = STEPS[values <= values[low] + 1]
    return STEPS[low], max(0.5 * (inside[-1] - inside[0]), STEPS[1] - STEPS[0])


def best_lengths(quantities, degree=3, rounds=30):
    """`quantities': lists of series, of the same packings in the same order. Lengths, one for each series and common to
    the quantities, that bring them nearest to one curve of each quantity; their geometric mean stays what it was.
    Returns lengths, errors of their logarithms, and the curves."""
    quantities = [[dataclasses.replace(s, length_pull=0 * s.length_pull) for s in series] for series in quantities]
    lengths = np.log([s.length for s in quantities[0]])
    held = lengths.mean()
    for turn in range(rounds + 1):
        curves = [collapse(series, degree, with_scatter=turn == rounds) for series in quantities]
        steps = np.array([best_step([(c, k) for c in curves], [series[k] for series in quantities])
                          for k in range(len(lengths))])
        if turn < rounds:
            lengths = lengths + 0.5 * steps[:, 0]
            lengths += held - lengths.mean()
            quantities = [[dataclasses.replace(s, length=np.exp(v)) for s, v in zip(series, lengths)]
                          for series in quantities]
    return np.exp(lengths), steps[:, 1], curves


def line(x, y, error):
    """y = c + s x by least squares: s, its error widened by the misfit, and the root mean square misfit."""
    w = error**-2.0
    middle = np.sum(w * x) / np.sum(w)
    s = np.sum(w * (x - middle) * y) / np.sum(w * (x - middle)**2)
    left = y - np.sum(w * y) / np.sum(w) - s * (x - middle)
    worse = max(1.0, np.sum(w * left**2) / (len(x) - 2))
    return s, np.sqrt(worse / np.sum(w * (x - middle)**2)), np.sqrt(np.mean(left**2))
