"""Theorem 1: cycles with known multipliers, and the parameters at which the Lyapunov exponent is positive."""
from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from ..._column import Column
from ..._table import Table
from ..work import Work
from .paper_column import column, separation, stiff
from .rows import add

SETTLED = 400  # taps; N = 1, T = 0.2 s: |multiplier| = 0.83, after these only the fixed point is left
EXPONENTS, POINTS, SHOWN, AVERAGED = 96, 240, 40, 300
_CONCLUSION = (
    "One particle can be chaotic, as Theorem 1 has it, for large amplitudes and for short periods. With K = 2 N m g/r as in "
    "Fig. 1 the floor then passes through the particle's centre, against (1), and from rest the shortest period of all, that "
    "of the tap itself, is not chaotic. With K = 100 m g/r the order holds at most points, not at short periods and the "
    "largest amplitudes, and there is chaos where it holds, as at the points of the largest lambda. Exponents of chaotic "
    f"orbits are averages over {AVERAGED} taps, their errors the change from the first half of these.")


@dataclasses.dataclass(frozen=True)
class Scan:
    """A scan of the period T or the amplitude a, with the paper's stiffness or with one for which (1) mostly holds.
    stiffness: in m g/r."""

    name: str
    over: str
    low: float
    high: float
    stiffness: float

    @property
    def parameter(self) -> str:
        return {"T": "period", "a": "amplitude"}[self.over]

    @property
    def unit(self) -> str:
        return {"T": "s", "a": "cm"}[self.over]

    def column(self, **keys: Any) -> Column:
        return column(1, stiffness=stiff(self.stiffness), **keys)

    def table(self, work: Work, output: str, **keys: Any) -> Table:
        c = self.column(output=output, parameter=self.parameter, from_=self.low, to=self.high, **keys)
        return c.table(threads=work.watch.arguments.threads, progress=lambda _: not work.watch.stop)


_SHORTEST = 0.5 / 7.5 * (1 + 1e-9)  # the period of a tap
SCANS = (Scan("chaos-period", "T", _SHORTEST, 1, 2), Scan("chaos-amplitude", "a", 0.05, 4, 2),
         Scan("chaos-period-stiff", "T", _SHORTEST, 1, 100), Scan("chaos-amplitude-stiff", "a", 0.05, 2, 100))


def make(work: Work, tell: Callable[[float], None]) -> None:
    _fixed_point(work)
    _cycles(work)
    for k, scan in enumerate(SCANS):
        tell(0.05 + 0.95 * k / len(SCANS))
        table = scan.table(work, "lyapunov", points=EXPONENTS, taps=AVERAGED)
        _exponents(work, scan, table)
        if work.folder:
            _show(work, scan, table)
    work.say("chaos", _CONCLUSION)


def _fixed_point(work: Work) -> None:
    c = column(1, period=0.2, taps=1000)
    state, d = c.map(c.map(c.start(), SETTLED)[0])
    y, v = c.positions(state)
    exponent = c.lyapunov()
    det = float(d[0, 0] * d[1, 1] - d[0, 1] * d[1, 0])
    add(work, "fixed-y", y[0])
    add(work, "fixed-v", v[0])
    add(work, "determinant", det)
    add(work, "trace", d[0, 0] + d[1, 1])
    add(work, "fixed-lambda", exponent.lambda_, abs(exponent.lambda_ - 0.5 * math.log(det)) + exponent.error)


def _cycles(work: Work) -> None:
    add(work, "cycle", column(1, period=0.7, taps=1000).lyapunov().cycle)
    for n in (5, 10):
        exponent = column(n, taps=1000).lyapunov()
        add(work, "settings", exponent.lambda_, exponent.error, n=n, cycle=exponent.cycle)
        work.say("chaos", f"At the settings of Fig. 1, N = {n}, the column is a cycle of {exponent.cycle} "
                          f"tap{'' if exponent.cycle == 1 else 's'} with lambda = {exponent.lambda_:.4f}: not chaotic.")


def _exponents(work: Work, scan: Scan, table: Table) -> None:
    at, lam, error, cycle = (table[name] for name in table.names[:4])
    chaotic = np.flatnonzero((cycle < 1) & (lam > error))  # no cycle, and an exponent larger than its error
    among = chaotic if len(chaotic) else np.arange(len(lam))
    best = int(among[np.argmax(lam[among])])
    words: dict[str, Any] = {"K": scan.stiffness, "over": scan.over}
    add(work, "largest", lam[best], error[best], at=at[best], points=len(chaotic), all=len(lam), low=scan.low,
        high=scan.high, **words)
    if not len(chaotic):
        return
    low, high = float(at[chaotic].min()), float(at[chaotic].max())
    work.say("chaos",
             f"N = 1, K = {scan.stiffness:g} m g/r, through {scan.over} from {scan.low:.3g} to {scan.high:g} {scan.unit}: "
             f"chaos at {len(chaotic)} of {len(lam)} values, between {low:.3f} and {high:.3f} {scan.unit}, with lambda up to "
             f"{lam[best]:.3f} a tap.")
    if scan.over == "a":
        add(work, "onset", low, (scan.high - scan.low) / (EXPONENTS - 1), all=len(lam), **words)
    else:
        add(work, "shortest", lam[0], error[0], **words)
    # over 400 taps at the point with the largest exponent
    run = scan.column(taps=400, **{scan.parameter: float(at[best])}).run([])
    add(work, "kept", separation(run), at=at[best], **words)


def _show(work: Work, scan: Scan, exponents: Table) -> None:
    from ..pictures import column as column_figure

    orbits = scan.table(work, "bifurcation", points=POINTS, transient=100, taps=SHOWN)
    violated = next((line for line in orbits.comments if line.startswith("warning: ordering (1) violated")), "")
    more = re.split("[,:]", violated.removeprefix("warning: "))[0]
    work.save_table(f"{scan.name}-lambda", exponents)
    work.save_table(f"{scan.name}-orbits", orbits)
    work.draw("chaos", scan.name,
              f"One particle, K = {scan.stiffness:g} m g/r: its position at .99T of {SHOWN} taps over the {scan.parameter}, "
              f"and the Lyapunov exponent{f'; {more}, the centre below the floor' if more else ''}.",
              column_figure([orbits, exponents]))
