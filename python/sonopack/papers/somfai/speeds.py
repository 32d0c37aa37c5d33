"""Fig. 8: speeds against pressure, of packings and of triangular lattices; Fig. 12: fronts of chains and of the triangular
lattice, with the Airy front."""
from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from ..._chain import chain_airy, chain_front, chain_signal
from ..._core import Floats, call
from ..._native import ffi, lib
from ..._packing import TOP
from ..._study import Sample, Store
from ..sheet import Curve, Panel, Sheet
from .rows import Mean, exact, ratio
from .samples import SomfaiWork

NAMES = ("smooth", "friction")


# ---- lattices -------------------------------------------------------------------------------------------------------

def lattice_speed(p: float, eta: float) -> float:
    """Eq. (18) for eta = 0, Eq. (19) otherwise."""
    return math.pow(3, 19.0 / 12) / (math.pow(2, 1.5) * math.sqrt(math.pi)) * math.sqrt(1 + eta / 3) * math.pow(p,
                                                                                                                1.0 / 6)


def _arrivals(work: SomfaiWork, ensemble: str, friction: bool, p: float) -> list[tuple[float, float]]:
    """Heights and arrival times in lattices of one kind, without that of Fig. 12."""
    made = work.sets[ensemble]
    lowest = made[-1].height / 5 if made else 0.0
    return [(sample.height, sample.front.t10) for sample in made
            if (sample.friction > 0) == friction and abs(sample.pressure - p) <= 1e-9 * p and sample.front is not None
            and sample.height >= lowest]


def lattice_small(work: SomfaiWork, friction: bool, p: float) -> float:
    """Speed from heights of about 8 and 24, as for packings; NAN without these samples."""
    found = _arrivals(work, "lattice", friction, p)
    if len(found) < 2:
        return math.nan
    (h0, t0), (h1, t1) = found[:2]
    return (h1 - h0) / (t1 - t0)


def lattice_long(work: SomfaiWork, friction: bool) -> tuple[float, float]:
    """Speed at p = 5e-7 from three heights, with the arrival time H/c + a + b H^(1/3) (Eq. (16)), and that between the
    two highest, about 80 and 160."""
    found = _arrivals(work, "lattice-long", friction, 5e-7)[:3]
    if len(found) < 3:
        return math.nan, math.nan
    (h0, t0), (h1, t1), (h2, t2) = found
    h10, h21, t10, t21 = h1 - h0, h2 - h1, t1 - t0, t2 - t1
    r10, r21 = float(np.cbrt(h1) - np.cbrt(h0)), float(np.cbrt(h2) - np.cbrt(h1))
    return (h10 * r21 - h21 * r10) / (t10 * r21 - t21 * r10), h21 / t21


# ---- packings -------------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Speeds:
    """Speeds against pressure, without those that are not known."""

    p: Floats
    c: Floats
    err: Floats

    @classmethod
    def of(cls, rows: list[tuple[float, float, float]]) -> Speeds:
        known = np.array([row for row in rows if math.isfinite(row[1])], float).reshape(-1, 3)
        return cls(*known.T)

    def last(self) -> Mean:
        """The speed at the largest pressure."""
        return Mean(0, float(self.c[-1]), math.nan, float(self.err[-1])) if len(self.c) else exact(math.nan)

    def exponent(self) -> Mean:
        """The exponent of p."""
        if len(self.p) < 3:
            return exact(math.nan)
        out, arrays = ffi.new("double[3]"), [np.ascontiguousarray(each) for each in (self.p, self.c, self.err)]
        p, c, err = (ffi.cast("double *", each.ctypes.data) for each in arrays)
        call(lib.sp_fit_power, len(self.p), p, c, err if np.all(self.err > 0) else ffi.NULL, out, out + 1, out + 2)
        return Mean(0, float(out[0]), math.nan, float(out[1]))


def _speeds(work: SomfaiWork, table: str, name: str, samples: list[Sample]) -> Speeds:
    """A column of a table of `sonopack table'."""
    if not samples:
        return Speeds.of([])
    made = Store(work.folder_of_store).table(table, samples=samples)
    return Speeds.of(list(zip(*(made[column].tolist() for column in ("p", name, f"{name}_err")))))


# ---- rows -----------------------------------------------------------------------------------------------------------

def make_speeds(work: SomfaiWork, item: str) -> None:
    tof = _speeds(work, "ctof", "c_tof", work.sets["low"] + work.sets["square"])
    fast, slow = (_speeds(work, "moduli", name, work.sets["square"]) for name in ("c_l", "c_t"))
    work.state("c_tof", tof.last())
    for name, speeds in (("c_tof", tof), ("c_l", fast), ("c_t", slow)):
        work.state(f"exponent-{name}", speeds.exponent())
    work.state("c_tof-over-c_l", ratio(tof.last(), fast.last()))
    for friction, name in enumerate(NAMES):
        work.state(f"lattice-{name}", exact(lattice_long(work, bool(friction))[0]), lattice_speed(5e-7, friction))
    if work.folder:
        _draw_speeds(work, item, tof, fast, slow)
    for k in range(len(tof.p)):
        work.say(item, f"p = {tof.p[k]:g}: c_tof = {tof.c[k]:.4f} +- {tof.err[k]:.4f}.")
    for friction, words, source in ((False, "without", "Eq. (18)"), (True, "with", "Eq. (19)")):
        limit, between = lattice_long(work, friction)
        work.say(item, f"Lattice {words} friction at 5e-7: {between:.4f} between heights of 80 and 160, {limit:.4f} "
                       f"once the front's spreading is allowed for; {source} gives "
                       f"{lattice_speed(5e-7, friction):.4f}.")
    work.say(item, "The points of the three experiments in the paper's figure are not available.")


# ---- figure ---------------------------------------------------------------------------------------------------------

def _eta(poisson: float) -> float:
    """Eq. (A4)."""
    return 1 - poisson / (2 - poisson)


def _guide(slope: float, y: float, label: str, **look: Any) -> Curve:
    """A short line of given slope, as a guide to the eye."""
    low, high = 2e-7, 6e-6
    return Curve(np.array([low, high]), np.array([y, y * math.pow(high / low, slope)]), label, **look)


def _marks(label: str, s: Speeds, ink: int, mark: str, open: bool = False) -> Curve:
    return Curve(s.p, s.c, label, error=None if open else s.err, ink=ink, dash=None, mark=mark, open=open)


def _draw_speeds(work: SomfaiWork, item: str, tof: Speeds, fast: Speeds, slow: Speeds) -> None:
    span = np.array([4e-8, 2.5e-4])
    plain, low, high = (np.array([lattice_speed(p, eta) for p in span]) for eta in (0, _eta(0.5), _eta(0)))
    small = [Speeds.of([(p, lattice_small(work, friction, p), math.nan) for p in (1e-7, 5e-7, 1e-6, 1e-5, 1e-4)])
             for friction in (False, True)]
    wide = [Speeds.of([(5e-7, lattice_long(work, friction)[1], math.nan)]) for friction in (False, True)]
    curves = [
        Curve(span, high, "lattice, friction, (19)", lower=low, upper=high, ink=-1, width=0.6),
        Curve(span, plain, "lattice, (18)", dash=1, width=0.8),
        _marks("lattice, |L| = 24", small[0], 3, "D", True),
        _marks("lattice, friction, |L| = 24", small[1], 4, "s", True),
        _marks("lattice, |L| = 160", wide[0], 3, "^", True),
        _marks("lattice, friction, |L| = 160", wide[1], 4, "o", True),
        _marks("2 |c|_{|t|}", Speeds(slow.p, 2 * slow.c, 2 * slow.err), 2, "^"),
        _marks("|c|_{|ℓ|}", fast, 1, "s"),
        _marks("|c|_{tof}", tof, 0, "o"),  # the main data, drawn on top
        _guide(1 / 6, 0.036, "slope 1/6", width=0.6), _guide(0.25, 0.026, "slope 1/4", dash=2, width=0.8)]
    panel = Panel(curves, "pressure |p| / |E|*", "speed / (|E|*/|ρ|)^{1/2}", log="xy", x=(span[0], span[1]),
                  y=(0.025, 0.4))
    work.draw_sheet(item, "fig8", Sheet([panel], aspect=0.85, width=300 / 72))


# ---- Fig. 12: chains and lattice ------------------------------------------------------------------------------------

BALLS = (20, 200, 2000)
ROWS = 20
LOW, HIGH = -2.5, 5.0  # range of (t - N)/N^(1/3)


def _cube(n: float) -> float:
    return float(np.cbrt(float(n)))


def _lattice(work: SomfaiWork) -> tuple[float, Floats, Floats]:
    """The lattice without friction as a chain: a row of grains is a ball, the two contacts of each grain with the next row
    its spring; the first row starts with k_wall/m, the first ball of the chain with velocity 1. The walls' springs over
    those between rows; x = (t - N)/N^(1/3), y = F N^(2/3): its front in the units of the chain."""
    network = next(each for sample, _, each in work.walk("lattice-long", 5e-7, 24 * ROWS) if not sample.friction > 0)
    s, third, mass = network.springs, _cube(ROWS), float(network.mass.ravel()[0])
    tops, up = s["j"] == TOP, np.flatnonzero((s["j"] >= 0) & (np.abs(s["n"][:, 1]) > 0.5))
    spring = float(np.mean(2 * s["kn"][up] * s["n"][up, 1]**2))
    wall, unit = float(s["kn"][tops][-1]), math.sqrt(mass / spring)
    signal = network.signal(method="chebyshev", until=(ROWS + HIGH * third) * unit, points=81)
    x = (signal.t / unit - ROWS) / third
    y = signal.F / int(tops.sum()) * mass / (wall * spring * unit) * third * third
    return wall / spring, x[x >= LOW], y[x >= LOW]


def _chain(n: int, x: Floats, wall: float = 1.0) -> Floats:
    """The front of a chain, scaled."""
    return chain_signal(n, n + x * _cube(n), wall=wall) * (_cube(n) * _cube(n))


def make_chains(work: SomfaiWork, item: str) -> None:
    wall, x, y = _lattice(work)
    row = work.state("wall", exact(wall))
    if abs(1 / wall - row.paper) < row.paper_sd:
        work.say(item, f"The walls' springs are {wall:.3f} times as stiff as those between rows, which is "
                       f"Hertz's law for rigid walls; the number in the paper is the inverse, {1 / wall:.3f}.")
    limit = float(lib.sp_chain_limit_of(lib.SP_CHAIN_VELOCITY).height)
    for n in BALLS:
        below = 100 * (1 - chain_front(n).amplitude * math.pow(n, 2.0 / 3) / limit)
        work.say(item, f"Chain of {n} balls: the first peak's height times N^(2/3) is {below:.2f}% below its limit.")
    mapped = _chain(ROWS, x, wall)
    apart = float(np.max(np.abs(mapped - y)) / np.max(np.abs(mapped)))
    work.say(item, f"The lattice of {ROWS} rows, its first row as fast as the chain's first ball, has the signal of a "
                   f"chain of {ROWS} balls with such walls, to {apart:.1g} of the largest value shown: its front is "
                   "lower and earlier than that of a chain whose springs are all equal.")
    if work.folder:
        _draw_chains(work, item, wall, x, y)


def _draw_chains(work: SomfaiWork, item: str, wall: float, at: Floats, lattice: Floats) -> None:
    x = np.array([LOW + (HIGH - LOW) * k / 400 for k in range(401)])
    far = 1000000000
    curves = [Curve(x, chain_airy(far, far + x * _cube(far)) * (_cube(far) * _cube(far)), "Airy, Eq. (16)", width=1.8)]
    curves += [Curve(x, _chain(n, x), f"chain, |N| = {n}", ink=k + 1, dash=(2, 3, 1)[k]) for k, n in enumerate(BALLS)]
    curves.append(Curve(x, _chain(ROWS, x, wall), ink=1, width=0.7))
    curves.append(Curve(at, lattice, "lattice, 20 rows", ink=1, dash=None, mark="o", open=True))
    panel = Panel(curves, "(|ct|/|ℓ| − |N|) / |N|^{1/3}", "|F| |N|^{2/3} / |Kℓ|", x=(LOW, HIGH), zero=True)
    work.draw_sheet(item, "fig12", Sheet([panel]))
