"""Fronts against distance, for boxes of several heights and for chains: Table III, Figs. 4 to 7."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._chain import chain_front
from ..._core import Floats, SonopackError, call, new, pointer_to
from ..._native import lib
from ..._records import Front
from ..._signal import front
from ..sheet import Curve, Panel, Sheet
from ..work import hypot, total
from .rows import Mean, mean_of
from .samples import SomfaiWork, member

#: distances of boxes: ensembles with numbers of grains
_BOXES = (("short", 100), ("low", 200), ("short", 400), ("square", 600), ("tall", 1200), ("tallest", 2400))
MARKS = ("t10", "t_peak", "t_zero")
TIME_AXIS = "time |t|  [|d| (|ρ|/|E|*)^{1/2}]"


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
            means = [mean_of(map(member(f"front.{name}"), some)) for name in (*MARKS, "amplitude", "width")]
            out.append(Distance(ensemble, grains, mean_of(sample.height for sample in some).mean, *means))
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
    return line([math.log(d.distance) for d in distances], [math.log(m.mean) for m in means],
                [m.err / m.mean for m in means])


# ---- signals --------------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Signals:
    """Signals of the packings of an ensemble at the same times: mean and root mean square deviation, NAN for a single
    one, and those of the first packings. height: mean [d]."""

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


# ---- Fig. 6: arrival times against distance -------------------------------------------------------------------------

SHAPES = ("^", "o", "s")
LABELS = ("arrival (10% of the peak)", "peak", "zero crossing")
#: lines through boxes up to L = 60, and through all
FITS = (("50", 60.0), ("100", math.inf))


def make_arrivals(work: SomfaiWork, item: str) -> None:
    found = boxes(work)
    lines = [_line(fitted(found, most)) for _, most in FITS]
    for (name, _), own in zip(FITS, lines):
        work.state(f"slope-{name}", 1 / own.slope, own.err / (own.slope * own.slope))
    for low, high in zip(found, found[1:]):
        rise, time = high.distance - low.distance, high.t10.mean - low.t10.mean
        work.say(item, f"Between L = {low.distance:.3g} and {high.distance:.3g} the arrival moves with "
                       f"{rise / time:.3f} +- {rise / (time * time) * hypot(low.t10.err, high.t10.err):.3f}.")
    work.say(item, "The paper does not say how tall its tallest boxes were; the speed falls with the distance, so that "
                   "the slope depends on that.")
    if work.folder:
        _draw_arrivals(work, item, found, lines)


def _line(some: Sequence[Distance]) -> Line:
    return line([d.distance for d in some], [d.t10.mean for d in some], [d.t10.err for d in some])


def _draw_arrivals(work: SomfaiWork, item: str, found: Sequence[Distance], lines: Sequence[Line]) -> None:
    distance = np.array([d.distance for d in found])
    curves = []
    for k, name in enumerate(MARKS):
        means = [getattr(d, name) for d in found]
        curves.append(Curve(distance, np.array([m.mean for m in means]), LABELS[k],
                            error=np.array([m.err for m in means]), ink=k + 1, dash=None, mark=SHAPES[k], open=True))
    for (name, most), own, dash in zip(FITS, lines, (0, 1)):
        some = fitted(found, most)
        if math.isfinite(own.slope):
            x = np.array([0, 1.05 * some[-1].distance])
            label = f"slope 1/{1 / own.slope:.3f}, |L| to {name}"
            curves.append(Curve(x, own.intercept + own.slope * x, label, dash=dash, width=0.7))
    panel = Panel(curves, "distance |L| [|d|]", TIME_AXIS, x=(0, None), inset=_inset(work))
    work.draw_sheet(item, "fig6",
                    "Times of arrival, peak and zero crossing against the distance, means of boxes 24 wide at p = "
                    "1e-4; inset: the three marks on the signal of the packing of Fig. 1.", Sheet([panel], aspect=0.9))


def _inset(work: SomfaiWork) -> Panel | None:
    """The signal of the packing of Fig. 1 and its three marks."""
    s = signals(work, "square", 180.0, 721)
    own = front_of(s.t, s.single[0])
    if own is None:
        return None
    curves = [Curve(s.t, s.single[0] / own.amplitude, width=0.7)]
    curves += [Curve(np.array([getattr(own, name)]), np.array([height]), ink=k + 1, dash=None, mark=SHAPES[k],
                     open=True)
               for k, (name, height) in enumerate(zip(MARKS, (0.1, 1.0, 0.0)))]
    return Panel(curves, "|t|  [|d| (|ρ|/|E|*)^{1/2}]", "|F|_{sig} / peak", x=(0, 180), zero=True)


# ---- Table III and Fig. 7: exponents of amplitude and width ---------------------------------------------------------

SPREADS = ("0.1", "0.2", "0.4")
EXACT = 24  # number of lengths of chains of equal balls


def make_table3(work: SomfaiWork, item: str) -> None:
    heights = boxes(work)
    for source, name in (("velocity", "equal-A"), ("displacement", "equal-B")):
        half, whole = (chain_front(n, source) for n in (500000, 1000000))
        work.state(f"gamma-{name}", math.log(half.amplitude / whole.amplitude) / math.log(2.0), 0.0)
        work.state(f"alpha-{name}", math.log(whole.width / half.width) / math.log(2.0), 0.0)
    for spread in SPREADS:
        _fits(work, f"chain-{spread}", chains(work, spread))
    _fits(work, "boxes-50", fitted(heights, 60))
    _fits(work, "boxes-100", fitted(heights, math.inf))
    work.say(item, "Equal chains: slopes between half a million and a million balls. Unequal chains and packings: "
                   "straight lines, log against log, through all lengths of chains and through the boxes of the range, "
                   "with the standard errors of the means.")
    for low, high in zip(heights, heights[1:]):
        gamma, alpha = power([low, high], "amplitude"), power([low, high], "width")
        work.say(item, f"Between L = {low.distance:.3g} and {high.distance:.3g}: gamma = {-gamma.slope:.2f} +- "
                       f"{gamma.err:.2f}, alpha = {alpha.slope:.2f} +- {alpha.err:.2f}.")


def _fits(work: SomfaiWork, name: str, distances: Sequence[Distance]) -> None:
    """Exponents of fits through the fronts at several distances."""
    gamma, alpha = power(distances, "amplitude"), power(distances, "width")
    work.state(f"gamma-{name}", -gamma.slope, gamma.err)
    work.state(f"alpha-{name}", alpha.slope, alpha.err)


# ---- Fig. 7 ---------------------------------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class Scaling:
    """Values against distance, and local exponents between neighbouring distances."""

    distance: Floats
    value: Floats
    err: Floats
    middle: Floats
    local: Floats
    local_err: Floats


def _scaling(distance: Sequence[float], value: Sequence[float], err: Sequence[float], sign: int) -> Scaling:
    """sign: of the exponent that is positive."""
    pairs = range(len(distance) - 1)
    steps = [math.log(distance[k + 1] / distance[k]) for k in pairs]
    middle = [math.sqrt(distance[k] * distance[k + 1]) for k in pairs]
    local = [sign * math.log(value[k + 1] / value[k]) / steps[k] for k in pairs]
    local_err = [hypot(err[k] / value[k], err[k + 1] / value[k + 1]) / steps[k] for k in pairs]
    return Scaling(*map(np.array, (distance, value, err, middle, local, local_err)))


def _of(distances: Sequence[Distance], name: str, sign: int) -> Scaling:
    means = [getattr(d, name) for d in distances]
    return _scaling([d.distance for d in distances], [m.mean for m in means], [m.err for m in means], sign)


def _equal(name: str, sign: int) -> Scaling:
    """Chains of equal balls, exactly."""
    balls = [math.floor(4 * math.pow(1000 / 4, k / (EXACT - 1)) + 0.5) for k in range(EXACT)]
    return _scaling([float(n) for n in balls], [getattr(chain_front(n), name) for n in balls], [0.0] * EXACT, sign)


_LOOKS: tuple[dict[str, Any], ...] = (
    {"label": "2D packings", "mark": "o"}, {"label": "chain, equal balls", "dash": 1},
    {"label": "chain, 1 ± 0.1", "mark": "s", "ink": 1, "open": True},
    {"label": "chain, 1 ± 0.2", "mark": "^", "ink": 2, "open": True},
    {"label": "chain, 1 ± 0.4", "mark": "D", "ink": 3, "open": True})
_AXES = (("|A|/|A|_{1}", "|γ|_{eff} = −d log |A| / d log |L|"), ("|W|/|W|_{1}", "|α|_{eff} = d log |W| / d log |L|"))


def _panel(k: int, systems: Sequence[Scaling]) -> Panel:
    """(a) the height A of the first peak, (b) its width W."""
    main, small = [], []
    for s, look in zip(systems, _LOOKS):
        plain = look["label"] == "chain, equal balls"
        # the panel above has the legend
        words: dict[str, Any] = {**look, "width": 0.8, "label": "" if k else look["label"]}
        main.append(Curve(s.middle, s.local, **words, error=None if plain else s.local_err))
        words["label"] = ""
        small.append(Curve(s.distance, s.value / s.value[0], **words, error=None if plain else s.err / s.value[0]))
    inset = Panel(small, "|L| [|d|]", _AXES[k][0], log="xy")
    return Panel(main, "distance |L| [|d|]", _AXES[k][1], tag=("(a)", "(b)")[k], log="x", x=(3, 1000), y=(0, None),
                 inset=inset)


def make_scaling(work: SomfaiWork, item: str) -> None:
    heights, unequal = boxes(work), [chains(work, spread) for spread in SPREADS]
    parts = [[_of(heights, name, sign), _equal(name, sign), *(_of(each, name, sign) for each in unequal)]
             for name, sign in (("amplitude", -1), ("width", 1))]
    work.draw_sheet(item, "fig7", "Local exponents of (a) the height A of the first peak and (b) its width W = t_zero "
                                  "- t10; insets: A and W over those of the shortest distance.",
                    Sheet([_panel(k, part) for k, part in enumerate(parts)], aspect=0.95))
    (a, equal_a, *_), (w, equal_w, *_) = parts
    if len(a.local):
        work.say(item, f"In boxes 24 wide gamma goes from {a.local[0]:.2f} +- {a.local_err[0]:.2f} at L = "
                       f"{a.middle[0]:.3g} to {a.local[-1]:.2f} +- {a.local_err[-1]:.2f} at L = {a.middle[-1]:.3g}, "
                       f"alpha from {w.local[0]:.2f} +- {w.local_err[0]:.2f} to {w.local[-1]:.2f} +- "
                       f"{w.local_err[-1]:.2f}.")
    work.say(item, f"The equal chain is exact ({equal_a.local[-1]:.3f} and {equal_w.local[-1]:.3f} at L = "
                   f"{equal_a.middle[-1]:.0f}; 2/3 and 1/3 far away). The paper does not say how wide its "
                   "distributions of balls are; here diameters are uniform in 1 +- 0.1, 0.2 and 0.4.")


# ---- Fig. 4: signals ------------------------------------------------------------------------------------------------

_PANELS = (("square", "(a) 2D, |μ| = 0.5", ""), ("square", "(b) 2D, |μ| = 0.5", "2D with friction"),
           ("smooth", "(c) 2D, |μ| = 0", "2D without friction"), ("spheres", "(d) 3D, |μ| = 0", "3D without friction"))


def make_signals(work: SomfaiWork, item: str) -> None:
    made: dict[str, Signals] = {}
    panels = []
    for ensemble, tag, name in _PANELS:
        if ensemble not in made:
            s = signals(work, ensemble, 400.0, 1601)
            made[ensemble] = s.over(s.peak())
        panels.append(Panel(_curves(tag[1], made[ensemble]), TIME_AXIS, "|F|_{sig} / first peak of the mean", tag=tag,
                            x=(0, 400), zero=True))
        if name:
            _say_scatter(work, item, name, made[ensemble])
    work.draw_sheet(item, "fig4",
                    "Force on the top wall at p = 1e-4 over the first peak of the ensemble's mean: (a) single packings "
                    "with friction, (b) their ensemble, (c) 2D and (d) 3D without friction.", Sheet(panels, columns=2))


def _curves(letter: str, s: Signals) -> list[Curve]:
    """Single packings in (a), mean and scatter beside one of them otherwise."""
    if letter == "a":
        names = ("packing 1 (Fig. 1)", "packing 2", "packing 3", "packing 4")
        return [Curve(s.t, f, name, ink=ink, width=0.8) for f, name, ink in zip(s.single, names, (2, 1, 3, 0))]
    curves = [Curve(s.t, s.single[0], "one packing", ink=-1, width=0.8)] if letter != "b" else []
    curves.append(Curve(s.t, s.mean, "mean", width=0.8))
    return curves + ([Curve(s.t, s.rms, "rms deviation", ink=2, dash=1, width=0.8)] if s.n > 1 else [])


def _say_scatter(work: SomfaiWork, item: str, what: str, s: Signals) -> None:
    """The scatter relative to the peak of the mean: at the peak, and the largest after the first zero crossing."""
    found = front_of(s.t, s.mean)
    if s.n < 2 or found is None:
        return
    before = s.rms[s.t <= found.t_peak]
    at_peak, later = before[-1] if len(before) else math.nan, max(s.rms[s.t > found.t_zero], default=0.0)
    work.say(item, f"{what}, {s.n} packings: the rms deviation between packings is "
                   f"{100 * at_peak / found.amplitude:.0f}% of the mean's first peak at that peak, and reaches "
                   f"{100 * later / found.amplitude:.0f}% after the first zero crossing.")


# ---- Fig. 5 ---------------------------------------------------------------------------------------------------------

def make_coherent(work: SomfaiWork, item: str) -> None:
    found = boxes(work)
    if len(found) > 1 and found[0].grains == 100:
        found = found[1:]  # its amplitude would dwarf the others
    made = [signals(work, d.ensemble, 1.15 * d.t_zero.mean, 400, d.grains) for d in found]
    peak = made[0].peak() if made else 1.0
    curves = []
    for k, (d, s) in enumerate(zip(found, made)):
        later = np.flatnonzero(s.t >= 0.75 * d.t10.mean)[:1]  # nothing happens before the front arrives
        first = int(later[0]) if len(later) else len(s.t)
        curves.append(Curve(s.t[first:], s.mean[first:] / peak, f"|L| = {d.distance:.1f} |d|", ink=k % 4,
                            dash=(0, 1, 3)[k % 3]))
    if curves:
        panel = Panel(curves, TIME_AXIS, "mean |F|_{sig} / peak of the lowest box", x=(0, None), zero=True)
        work.draw_sheet(item, "fig5", "Mean signals of boxes 24 wide and L high at p = 1e-4, until shortly after their "
                                      "zero crossings, over the first peak of the lowest "
                                      "box.", Sheet([panel], aspect=0.9))
    if len(found) > 1:
        low, high = found[0], found[-1]
        work.say(item, f"From L = {low.distance:.3g} to {high.distance:.3g} the first peak falls by a factor "
                       f"{low.amplitude.mean / high.amplitude.mean:.3g} and its width (t_zero - t10) grows by "
                       f"{high.width.mean / low.width.mean:.3g}.")
