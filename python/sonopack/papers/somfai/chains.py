"""Fig. 12: fronts of chains and of the triangular lattice, with the Airy front."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from ..._chain import chain_airy, chain_front, chain_signal
from ..._core import Floats
from ..._native import lib
from ..._network import Network
from ..._packing import TOP
from ..sheet import Curve, Panel, Sheet
from .samples import SomfaiWork

BALLS = (20, 200, 2000)
ROWS = 20
LOW, HIGH = -2.5, 5.0  # range of (t - N)/N^(1/3)


@dataclasses.dataclass(frozen=True)
class Lattice:
    """The lattice as a chain: a row of M grains is a ball, the two contacts of each grain with the next row its spring. mass,
    spring and wall: of a grain. x = (t - N)/N^(1/3), y = F N^(2/3): its front in the units of the chain."""

    mass: float
    spring: float
    wall: float
    row: int
    x: Floats
    y: Floats


def _cube(n: float) -> float:
    return float(np.cbrt(float(n)))


def _measure(network: Network) -> tuple[float, float, float, int]:
    s = network.springs
    tops = s["j"] == TOP
    up = (s["j"] >= 0) & (np.abs(s["n"][:, 1]) > 0.5)
    spring = 0.0
    for k in np.flatnonzero(up):
        spring += 2 * float(s["kn"][k]) * float(s["n"][k, 1]) * float(s["n"][k, 1])
    return float(network.mass.ravel()[0]), spring / int(up.sum()), float(s["kn"][tops][-1]), int(tops.sum())


def _lattice(work: SomfaiWork) -> Lattice:
    """That without friction; the first row starts with k_wall/m, the first ball of the chain with velocity 1."""
    network = next(each for sample, _, each in work.walk("lattice-long", 5e-7, 24 * ROWS) if not sample.friction > 0)
    mass, spring, wall, row = _measure(network)
    unit, third = math.sqrt(mass / spring), _cube(ROWS)
    signal = network.signal(method="chebyshev", until=(ROWS + HIGH * third) * unit, points=81)
    x = (signal.t / unit - ROWS) / third
    y = signal.F / row * mass / (wall * spring * unit) * third * third
    return Lattice(mass, spring, wall, row, x[x >= LOW], y[x >= LOW])


def _chain(n: int, x: Floats, wall: float = 1.0) -> Floats:
    """The front of a chain, scaled."""
    return chain_signal(n, n + x * _cube(n), wall=wall) * (_cube(n) * _cube(n))


def make(work: SomfaiWork, item: str) -> None:
    l = _lattice(work)
    row = work.state("wall", l.wall / l.spring, 0.0)
    if abs(l.spring / l.wall - row.paper) < row.paper_sd:
        work.say(item, f"The walls' springs are {l.wall / l.spring:.3f} times as stiff as those between rows, which is Hertz's "
                       f"law for rigid walls; the number in the paper is the inverse, {l.spring / l.wall:.3f}.")
    limit = float(lib.sp_chain_limit_of(lib.SP_CHAIN_VELOCITY).height)
    for n in BALLS:
        below = 100 * (1 - chain_front(n).amplitude * math.pow(n, 2.0 / 3) / limit)
        work.say(item, f"Chain of {n} balls: the first peak's height times N^(2/3) is {below:.2f}% below its limit.")
    mapped = _chain(ROWS, l.x, l.wall / l.spring)
    apart = float(np.max(np.abs(mapped - l.y)) / np.max(np.abs(mapped)))
    work.say(item, f"The lattice of {ROWS} rows, its first row as fast as the chain's first ball, has the signal of a chain of "
                   f"{ROWS} balls with such walls, to {apart:.1g} of the largest value shown: its front is lower and earlier "
                   "than that of a chain whose springs are all equal.")
    if work.folder:
        _draw(work, item, l)


def _draw(work: SomfaiWork, item: str, l: Lattice) -> None:
    x = np.array([LOW + (HIGH - LOW) * k / 400 for k in range(401)])
    far = 1000000000
    curves = [Curve(x, chain_airy(far, far + x * _cube(far)) * (_cube(far) * _cube(far)), "Airy, Eq. (16)", width=1.8)]
    curves += [Curve(x, _chain(n, x), f"chain, |N| = {n}", ink=k + 1, dash=(2, 3, 1)[k]) for k, n in enumerate(BALLS)]
    curves.append(Curve(x, _chain(ROWS, x, l.wall / l.spring), ink=1, width=0.7))
    curves.append(Curve(l.x, l.y, "lattice, 20 rows", ink=1, dash=None, mark="o", open=True))
    panel = Panel(curves, "(|ct|/|ℓ| − |N|) / |N|^{1/3}", "|F| |N|^{2/3} / |Kℓ|", x=(LOW, HIGH), zero=True)
    work.draw_sheet(item, "fig12",
                    "Force of the last ball on its wall after a velocity of the first (A), against the time after N l/c: "
                    "chains of N balls, their limit, a triangular lattice of 20 rows (circles), and a chain with walls as "
                    "stiff as the lattice's (thin line).", Sheet([panel]))
