"""Fronts against distance, for boxes of several heights and for chains; lines through them; signals of an ensemble."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from ..._core import Floats, SonopackError, new, pointer_to, call
from ..._native import lib
from ..._records import Front
from ..._signal import front
from ..work import log, total
from .samples import SomfaiWork, member
from .verdict import Row, mean_of

#: distances of boxes: ensembles with numbers of grains
_BOXES = (("short", 100), ("low", 200), ("short", 400), ("square", 600), ("tall", 1200), ("tallest", 2400))
MARKS = ("t10", "t_peak", "t_zero")
TIME_AXIS = "time |t|  [|d| (|ρ|/|E|*)^{1/2}]"


@dataclasses.dataclass(frozen=True)
class Mean:
    """A mean with its standard error."""

    mean: float
    err: float


@dataclasses.dataclass(frozen=True)
class Distance:
    """Averages over the fronts of boxes of one height, or chains of one length. width = t_zero - t10."""

    ensemble: str
    grains: int
    distance: float
    t10: Mean
    t_peak: Mean
    t_zero: Mean
    amplitude: Mean
    width: Mean


def _distances(work: SomfaiWork, all_: Sequence[tuple[str, int]]) -> list[Distance]:
    """Averages at p = 1e-4. Distances without fronts are left out."""
    out = []
    for ensemble, grains in all_:
        some = work.some(ensemble, 1e-4, grains, "front")
        if some:
            means = [mean_of(Row("", ""), map(member(f"front.{name}"), some)) for name in (*MARKS, "amplitude", "width")]
            height = mean_of(Row("", ""), [sample.height for sample in some]).ours
            out.append(Distance(ensemble, grains, height, *(Mean(row.ours, row.err) for row in means)))
    return out


def boxes(work: SomfaiWork) -> list[Distance]:
    """Boxes of 100 to 2400 grains, the lowest first."""
    return _distances(work, _BOXES)


def chains(work: SomfaiWork, spread: str) -> list[Distance]:
    """Chains of balls of unequal diameters 1 +- spread, the shortest first."""
    return _distances(work, [(f"chain-{spread}", 25 << k) for k in range(6)])


def fitted(distances: Sequence[Distance], most: float) -> list[Distance]:
    """Boxes for line fits: from L = 8, the lower height in the paper. It does not state where its figures end."""
    return [d for d in distances if 6 <= d.distance <= most]


@dataclasses.dataclass(frozen=True)
class Line:
    """A straight line, and the error of its slope; NAN for fewer than two points."""

    slope: float
    intercept: float
    err: float


def line(x: Sequence[float], y: Sequence[float], y_err: Sequence[float]) -> Line:
    """Least squares with equal weights; the error follows from those of the points, 0 for points without."""
    n = len(x)
    if n < 2:
        return Line(math.nan, math.nan, math.nan)
    x_mean, y_mean = total(each / n for each in x), total(each / n for each in y)
    xx = total((a - x_mean) * (a - x_mean) for a in x)
    xy = total((a - x_mean) * (b - y_mean) for a, b in zip(x, y))
    variance = total(math.pow((a - x_mean) * (e if math.isfinite(e) else math.nan), 2) for a, e in zip(x, y_err))
    return Line(xy / xx, y_mean - xy / xx * x_mean, math.sqrt(variance) / xx)


def power(distances: Sequence[Distance], of: str) -> Line:
    """A line through ln mean against ln distance."""
    means = [getattr(d, of) for d in distances]
    return line([log(d.distance) for d in distances], [log(m.mean) for m in means], [m.err / m.mean for m in means])


# ---- signals --------------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Signals:
    """Signals of the packings of an ensemble at the same times: mean and root mean square deviation, NAN for a single one,
    and those of the first packings. height: mean [d]."""

    n: int
    t: Floats
    mean: Floats
    rms: Floats
    single: list[Floats]

    def over(self, by: float) -> Signals:
        """All of them divided by a number."""
        return dataclasses.replace(self, mean=self.mean / by, rms=self.rms / by, single=[f / by for f in self.single])

    def peak(self) -> float:
        """Height of the first peak of the mean; its largest value if there is no front."""
        found = front_of(self.t, self.mean)
        if found is not None:
            return found.amplitude
        most = max(0.0, float(np.nanmax(self.mean)))
        return most if most > 0 else 1.0


def front_of(t: Floats, f: Floats) -> Front | None:
    """The first front of a signal, if there is one."""
    try:
        return front(t, f)
    except SonopackError:
        return None


def signals(work: SomfaiWork, ensemble: str, until: float, points: int, grains: int = 0) -> Signals:
    """Averages over all packings at p = 1e-4."""
    average = new("sp_signal_average", lib.sp_signal_average_free, lib.sp_signal_average_none)
    single: list[Floats] = []
    for _, _, network in work.walk(ensemble, 1e-4, grains):
        signal = network.signal(method="chebyshev", until=until, points=points)
        call(lib.sp_signal_average_add, average, points, pointer_to(signal.t), pointer_to(signal.F))
        if len(single) < 4:
            single.append(signal.F.copy())
    t, mean = (np.array([row[k] for k in range(points)]) for row in (average.t, average.mean))
    rms = np.array([lib.sp_signal_average_rms(average, k) for k in range(points)])
    return Signals(int(average.count), t, mean, rms, single)


def rms_after(t: Floats, f: Floats, time: float) -> float:
    """Root mean square of a signal after a time; NAN if it ends before."""
    later = f[t > time]
    return math.sqrt(total(later * later) / len(later)) if len(later) else math.nan
