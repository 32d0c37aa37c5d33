"""The lowest modes of many packings together: which are plane waves, and the power law of the density of the others."""
from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Floats, Path, Refused
from ._network import Network
from ._packing import Packing, _Cell
from ._study import Sample
from ._table import Table

DRAWS = 200  # of the test of Kolmogorov and Smirnov
FAR = 200.0  # of ln(high/low): e^-200 of the modes of a law with the exponent 0 are lower
WAVES_TO = 1.2  # plane waves count up to this times the highest frequency of a packing


# ---- power laws -----------------------------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class PowerLaw:
    """A density of modes ~ omega^exponent, by maximum likelihood.

    exponent, error: the exponent and its standard error, from the scatter of the packings
    low, high: the range of frequencies
    modes: the number of modes in it
    goodness: the share of samples drawn from the law that are farther from it (Kolmogorov and Smirnov); nan: not known
    """

    exponent: float
    error: float
    low: float
    high: float
    modes: int
    goodness: float = float("nan")


def power_law(omega: npt.ArrayLike, low: float = 0.0, high: float | None = None, packing: npt.ArrayLike | None = None,
              draws: int = DRAWS) -> PowerLaw:
    """The power law of frequencies between low and high (by default the highest). packing: to which packing each belongs;
    modes of one are not independent."""
    x = np.asarray(omega, float).ravel()
    if not (len(x) and np.isfinite(x).all()):
        raise _core.invalid("omega", f"{len(x)} frequencies: must be some, all finite")
    high = float(x.max()) if high is None else high
    inside = (x > low) & (x <= high)
    if inside.sum() < 3 or not high > low >= 0 or x[inside].min() == high:
        raise _core.invalid("high", f"{inside.sum()} modes between {low:g} and {high:g}: must be 3 or more, not all equal to it")
    y = np.log(high / x[inside])  # with the density s e^(-s y) in 0 .. span, s = exponent + 1
    span = min(np.log(high / low), FAR) if low > 0 else FAR
    s = float(_rate(np.atleast_1d(y.mean()), span)[0])
    groups = np.arange(len(y)) if packing is None else np.unique(np.asarray(packing)[inside], return_inverse=True)[1]
    scores = np.bincount(groups, y - y.mean())
    error = float(np.sqrt((scores**2).sum()) / (len(y) * _variance(s, span)))
    return PowerLaw(s - 1, error, low, high, len(y), _goodness(y, s, span, draws) if draws else float("nan"))


def _rate(mean: Floats, span: float) -> Floats:
    """s of the density s e^(-s y) in 0 .. span with these means, by bisection."""
    low, high = -1 / (span - mean), 1 / mean
    with np.errstate(over="ignore"):
        for _ in range(60):
            s = 0.5 * (low + high)
            above = 1 / s - span / np.expm1(s * span) > mean
            low, high = np.where(above, s, low), np.where(above, high, s)
    return 0.5 * (low + high)


def _variance(s: float, span: float) -> float:
    with np.errstate(over="ignore"):
        return float(1 / s**2 - (span / (2 * np.sinh(0.5 * s * span)))**2)


def _goodness(y: Floats, s: float, span: float, draws: int) -> float:
    """Samples of the law are fitted as the modes were, so that their distances have the same freedom."""
    random = np.random.default_rng(len(y)).random((draws, len(y)))
    drawn = -np.log1p(random * np.expm1(-s * span)) / s
    farthest = _distance(drawn, _rate(drawn.mean(1), span)[:, None], span)
    return float(np.mean(farthest >= _distance(y[None], np.array([[s]]), span)))


def _distance(y: Floats, s: Floats, span: float) -> Floats:
    """Of Kolmogorov and Smirnov, of each row."""
    below, n = np.expm1(-s * np.sort(y, axis=1)) / np.expm1(-s * span), y.shape[1]
    return np.maximum(np.arange(1, n + 1) / n - below, below - np.arange(n) / n).max(axis=1)  # type: ignore[no-any-return]


# ---- the modes of one packing ---------------------------------------------------------------------------------------

def _measured(one: Packing | Sample | Path, lowest: int, words: dict[str, Any]) -> dict[str, Any]:
    packing = one.packing() if isinstance(one, Sample) else one if isinstance(one, Packing) else Packing.read(one)
    if packing.cell != "periodic":
        raise _core.invalid("", f"packing.cell = {packing.cell}: must be periodic, for plane waves to be modes")
    network = packing.network(**words)
    modes = network.modes(lowest=lowest)
    c_t = _transverse_speed(network)
    waves = _wave_vectors(packing, WAVES_TO * float(modes.omega[-1]) / c_t if c_t > 0 else 0.0)
    first = c_t * float(np.linalg.norm(waves[0])) if c_t > 0 else float("nan")
    return {"omega": modes.omega.copy(), "participation": modes.participation.copy(), "first": first,
            "phonon": _share_of_waves(network, modes.vectors, waves), "dofs": network.dofs}


def _transverse_speed(network: Network) -> float:
    """0 for a network that gives way to a shear: a cell that is kept square or cubic may rest all the same."""
    try:
        shear = network.elasticity().shear
    except Refused:
        return 0.0
    return float(np.sqrt(max(shear, 0.0) * network.packing.volume / network.mass[:, 0].sum()))


def _wave_vectors(packing: Packing, until: float) -> Floats:
    """One of k and -k, shortest first: those of the first shell, and all with |k| <= until."""
    dim, lattice = packing.dim, _Cell(packing.cell, list(packing.box), list(packing.tilt)).lattice()
    reciprocal = 2 * np.pi * np.linalg.inv(lattice).T
    most = (np.maximum(until, 0) * np.linalg.norm(lattice, axis=1) / (2 * np.pi)).astype(int) + 1
    n = np.array([n for n in itertools.product(*(range(-m, m + 1) for m in most)) if n > (0,) * dim])
    k = n @ reciprocal
    length = np.linalg.norm(k, axis=1)
    order = np.argsort(length, kind="stable")
    return k[order][length[order] <= max(until, 1.001 * length.min())]  # type: ignore[no-any-return]


def _share_of_waves(network: Network, vectors: Floats, waves: Floats) -> Floats:
    """The share of the kinetic energy of each mode in plane waves of the displacements, less that of random vectors: 1 for
    a plane wave, 0 for no more than chance."""
    dim, mass = network.dim, np.sqrt(network.mass[:, 0])
    phase = network.packing.x[network.grain, :dim] @ waves.T
    wave = np.concatenate([np.cos(phase), np.sin(phase)], axis=1) * mass[:, None]
    basis, r = np.linalg.qr(wave)
    basis = basis[:, np.abs(np.diag(r)) > 1e-8 * np.abs(np.diag(r)).max()]
    share = (np.einsum("mia,iw->mwa", vectors[:, :, :dim], basis)**2).sum(axis=(1, 2))
    chance = basis.shape[1] * dim / network.dofs
    return (share - chance) / (1 - chance) if chance < 1 else share  # type: ignore[no-any-return]


# ---- ensembles ------------------------------------------------------------------------------------------------------

class SoftModes:
    """The lowest modes of the packings of an ensemble. Made by soft_modes().

    packing, omega, participation, phonon [modes]: its packing, its frequency, its participation ratio, and the share of
    plane waves in it, from which 0 is chance
    first, dofs [packings]: frequency of the longest transverse wave by the shear modulus (nan: below 0), and the number of
    degrees of freedom
    complete: the frequency below which the modes of all packings are here
    """

    def __init__(self, columns: dict[str, Any]) -> None:
        self._columns = {name: np.asarray(values, int if name in ("packing", "dofs") else float)
                         for name, values in columns.items()}
        self.packing, self.omega = self._columns["packing"], self._columns["omega"]
        self.participation, self.phonon = self._columns["participation"], self._columns["phonon"]
        rows = np.unique(self.packing, return_index=True)[1]
        self.first, self.dofs = self._columns["first"][rows], self._columns["dofs"][rows]
        highest = np.maximum.reduceat(self.omega, rows)
        self.complete = float(highest.min())

    @classmethod
    def of_table(cls, table: Table) -> SoftModes:
        """The modes of a table of .table()."""
        return cls({name: np.array(table[name]) for name in ("packing", "omega", "participation", "phonon", "first",
                                                             "dofs")})

    def table(self) -> Table:
        """All modes, with the columns packing omega participation phonon first dofs."""
        units = dict.fromkeys(("omega", "first"), "sqrt(E* / rho)/d")
        return Table.from_columns(self._columns, units, {"spectrum": "soft"})

    @property
    def is_phonon(self) -> npt.NDArray[np.bool_]:
        """Whether more than half of a mode is plane waves, and its frequency at least half of the first phonon's."""
        return (self.phonon > 0.5) & ~(self.omega < 0.5 * self._columns["first"])

    def density(self, edges: npt.ArrayLike, phonons: bool = True) -> tuple[Floats, Floats]:
        """Modes in bins over all modes and the width of the bin, with their standard errors from the scatter of the
        packings. phonons=False: of the others."""
        edge = np.asarray(edges, float)
        which, place = np.unique(self.packing, return_inverse=True)[1], np.searchsorted(edge, self.omega, "right") - 1
        use = (place >= 0) & (place < len(edge) - 1) & (phonons | ~self.is_phonon)
        count = np.zeros((len(self.dofs), len(edge) - 1))
        np.add.at(count, (which[use], place[use]), 1)
        factor = len(count) / (self.dofs.sum() * np.diff(edge))
        return count.mean(0) * factor, count.std(0, ddof=1) / np.sqrt(len(count)) * factor

    def law(self, high: float, low: float = 0.0, draws: int = DRAWS) -> PowerLaw:
        """The power law of the modes that are no phonons between low and high."""
        use = ~self.is_phonon
        return power_law(self.omega[use], low, min(high, self.complete), self.packing[use], draws)

    def scan(self, low: float = 0.0, fewest: int = 30, steps: int = 12) -> list[PowerLaw]:
        """Power laws with more and more modes, from `fewest` up to the first phonon (or `complete`)."""
        last = min(self.complete, float(np.nanmedian(self.first)))
        x = np.sort(self.omega[~self.is_phonon & (self.omega > low) & (self.omega <= last)])
        if len(x) < fewest:
            raise _core.invalid("", f"{len(x)} modes below the first phonon: must be {fewest} or more")
        counts = np.unique(np.geomspace(fewest, len(x), steps).round().astype(int))
        return [self.law(float(x[n - 1]), low) for n in counts]

    def best(self, low: float = 0.0) -> PowerLaw:
        """The one of scan() with the most modes that a test at 10% does not tell from a power law, or the first."""
        found = self.scan(low)
        return next((law for law in reversed(found) if law.goodness >= 0.1), found[0])

    def lowest_law(self, high: float) -> PowerLaw:
        """The exponent from the lowest mode of each packing alone: were modes independent, it had the distribution of
        Weibull with exponent + 1. Lowest modes above `high` count as such."""
        lowest = np.minimum.reduceat(self.omega, np.unique(self.packing, return_index=True)[1])
        y = np.log(np.minimum(lowest / high, 1.0))
        seen, s, low, top = y < 0, 1.0, 1e-3, 1e3
        for _ in range(60):
            s = np.sqrt(low * top)
            weight = np.exp(s * y)
            slope = 1 / s + y[seen].mean() - (weight * y).sum() / weight.sum()
            low, top = (s, top) if slope > 0 else (low, s)
        mean = (weight * y).sum() / weight.sum()
        information = seen.sum() * (1 / s**2 + (weight * (y - mean)**2).sum() / weight.sum())
        return PowerLaw(float(s - 1), float(1 / np.sqrt(information)), 0.0, high, int(seen.sum()))

    def __repr__(self) -> str:
        return f"<SoftModes: {len(self.omega)} of {len(self.dofs)} packings, all below {self.complete:.4g}>"


def soft_modes(packings: Iterable[Packing | Sample | Path], *, lowest: int = 30, threads: int = 1,
               **network: Any) -> SoftModes:
    """The `lowest` modes of each of these periodic packings (such as the samples of a Store). network: arguments of
    Packing.network(), such as prestress=True."""
    with ThreadPoolExecutor(threads) as pool:
        found = list(pool.map(lambda one: _measured(one, lowest, network), packings))
    if not found:
        raise _core.invalid("packings", "none: must be one or more")
    counts = [len(one["omega"]) for one in found]
    columns: dict[str, Any] = {"packing": np.repeat(np.arange(1, len(found) + 1), counts)}
    columns |= {name: np.concatenate([one[name] for one in found]) for name in ("omega", "participation", "phonon")}
    columns |= {name: np.repeat([one[name] for one in found], counts) for name in ("first", "dofs")}
    return SoftModes(columns)
