"""Fronts against distance, for boxes of several heights and for chains: Table III, Figs. 4 to 7."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._chain import chain_front
from ..._core import Floats, SonopackError
from ..._records import Front
from ..._signal import front
from ..sheet import Curve, Panel, Sheet
from .rows import Mean, exact, mean_of, ratio, speed
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


def line(x: Sequence[float], y: Sequence[Mean]) -> tuple[Mean, float]:
    """Slope and intercept of the line of least squares, all weights equal; the error follows from those of the points.
    NAN for fewer than two points."""
    if len(x) < 2:
        return exact(math.nan), math.nan
    values, errors = np.array([each.mean for each in y]), np.array([each.err for each in y])
    off = np.array(x) - np.mean(x)
    slope = float(off @ values / (off @ off))
    return (Mean(0, slope, math.nan, float(np.linalg.norm(off * errors) / (off @ off))),
            float(np.mean(values) - slope * np.mean(x)))


def power(x: Sequence[float], y: Sequence[Mean]) -> Mean:
    """The slope of ln y against ln x."""
    logarithms = [Mean(m.n, math.log(m.mean), math.nan, m.err / m.mean) for m in y]
    return line([math.log(each) for each in x], logarithms)[0]


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
    found = [network.signal(method="chebyshev", until=until, points=points)
             for _, _, network in work.walk(ensemble, 1e-4, grains)]
    f = np.array([signal.F for signal in found])
    rms = f.std(axis=0) if len(f) > 1 else np.full(points, math.nan)
    return Signals(len(f), np.array(found[0].t), f.mean(axis=0), rms, list(f[:4]))


def rms_after(t: Floats, f: Floats, time: float) -> float:
    """Root mean square of a signal after a time; NAN if it ends before."""
    later = f[t > time]
    return math.sqrt(np.mean(later**2)) if len(later) else math.nan


# ---- Fig. 6: arrival times against distance -------------------------------------------------------------------------

SHAPES = ("^", "o", "s")
LABELS = ("arrival (10% of the peak)", "peak", "zero crossing")
#: lines through boxes up to L = 60, and through all
FITS = (("50", 60.0), ("100", math.inf))


def make_arrivals(work: SomfaiWork, item: str) -> None:
    found = boxes(work)
    lines = [line([d.distance for d in some], [d.t10 for d in some])
             for some in (fitted(found, most) for _, most in FITS)]
    for (name, _), (slope, _) in zip(FITS, lines):
        work.state(f"slope-{name}", ratio(exact(1.0), slope))
    for low, high in zip(found, found[1:]):
        work.say(item, f"Between L = {low.distance:.3g} and {high.distance:.3g} the arrival moves with "
                       f"{speed(high.distance - low.distance, low.t10, high.t10):.3f}.")
    work.say(item, "The paper does not say how tall its tallest boxes were; the speed falls with the distance, so that "
                   "the slope depends on that.")
    if work.folder:
        _draw_arrivals(work, item, found, lines)


def _draw_arrivals(work: SomfaiWork, item: str, found: Sequence[Distance], lines: Sequence[tuple[Mean, float]]) -> None:
    curves = [curve_of(_of(found, name), label=LABELS[k], ink=k + 1, dash=None, mark=SHAPES[k], open=True)
              for k, name in enumerate(MARKS)]
    for (name, most), (slope, start), dash in zip(FITS, lines, (0, 1)):
        if math.isfinite(slope.mean):
            x = np.array([0, 1.05 * fitted(found, most)[-1].distance])
            label = f"slope 1/{1 / slope.mean:.3f}, |L| to {name}"
            curves.append(Curve(x, start + slope.mean * x, label, dash=dash, width=0.7))
    panel = Panel(curves, "distance |L| [|d|]", TIME_AXIS, x=(0, None), inset=_inset(work))
    work.draw_sheet(item, "fig6", Sheet([panel], aspect=0.9))


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
        work.state(f"gamma-{name}", exact(math.log2(half.amplitude / whole.amplitude)))
        work.state(f"alpha-{name}", exact(math.log2(whole.width / half.width)))
    for spread in SPREADS:
        _fits(work, f"chain-{spread}", chains(work, spread))
    _fits(work, "boxes-50", fitted(heights, 60))
    _fits(work, "boxes-100", fitted(heights, math.inf))
    work.say(item, "Equal chains: slopes between half a million and a million balls. Unequal chains and packings: "
                   "straight lines, log against log, through all lengths of chains and through the boxes of the range, "
                   "with the standard errors of the means.")
    for low, high in zip(heights, heights[1:]):
        gamma, alpha = _exponents([low, high])
        work.say(item, f"Between L = {low.distance:.3g} and {high.distance:.3g}: gamma = {gamma:.2f}, alpha = "
                       f"{alpha:.2f}.")


def _exponents(distances: Sequence[Distance]) -> tuple[Mean, Mean]:
    """gamma and alpha of a fit through the fronts at several distances."""
    x = [d.distance for d in distances]
    gamma, alpha = power(x, [d.amplitude for d in distances]), power(x, [d.width for d in distances])
    return gamma._replace(mean=-gamma.mean), alpha


def _fits(work: SomfaiWork, name: str, distances: Sequence[Distance]) -> None:
    for exponent, ours in zip(("gamma", "alpha"), _exponents(distances)):
        work.state(f"{exponent}-{name}", ours)


# ---- Fig. 7 ---------------------------------------------------------------------------------------------------------

#: distances, and a value at each
System = tuple[Sequence[float], Sequence[Mean]]


def _of(distances: Sequence[Distance], name: str) -> System:
    return [d.distance for d in distances], [getattr(d, name) for d in distances]


def _equal(name: str) -> System:
    """Chains of equal balls, exactly."""
    balls = np.floor(np.geomspace(4, 1000, EXACT) + 0.5).astype(int).tolist()
    return balls, [exact(getattr(chain_front(n), name)) for n in balls]


def _local(system: System, sign: int) -> System:
    """Exponents between neighbouring distances, at their geometric means. sign: of the one that is positive."""
    x, y = system
    found = [power(x[k:k + 2], y[k:k + 2]) for k in range(len(x) - 1)]
    return np.sqrt(np.array(x[:-1]) * x[1:]).tolist(), [m._replace(mean=sign * m.mean) for m in found]


def curve_of(system: System, **words: Any) -> Curve:
    """A curve with errors, unless its values are exact."""
    x, y = system
    err = np.array([m.err for m in y])
    return Curve(np.array(x), np.array([m.mean for m in y]), error=err if err.any() else None, **words)


_LOOKS: tuple[dict[str, Any], ...] = (
    {"label": "2D packings", "mark": "o"}, {"label": "chain, equal balls", "dash": 1},
    {"label": "chain, 1 ± 0.1", "mark": "s", "ink": 1, "open": True},
    {"label": "chain, 1 ± 0.2", "mark": "^", "ink": 2, "open": True},
    {"label": "chain, 1 ± 0.4", "mark": "D", "ink": 3, "open": True})
_AXES = (("|A|/|A|_{1}", "|γ|_{eff} = −d log |A| / d log |L|"), ("|W|/|W|_{1}", "|α|_{eff} = d log |W| / d log |L|"))


def _panel(k: int, systems: Sequence[System], exponents: Sequence[System]) -> Panel:
    """(a) the height A of the first peak, (b) its width W. The first panel has the legend."""
    main, small = [], []
    for (x, y), local, look in zip(systems, exponents, _LOOKS):
        first = y[0].mean if y else math.nan
        over = [m._replace(mean=m.mean / first, err=m.err / first) for m in y]
        main.append(curve_of(local, width=0.8, **{**look, "label": "" if k else look["label"]}))
        small.append(curve_of((x, over), width=0.8, **{**look, "label": ""}))
    inset = Panel(small, "|L| [|d|]", _AXES[k][0], log="xy")
    return Panel(main, "distance |L| [|d|]", _AXES[k][1], tag=("(a)", "(b)")[k], log="x", x=(3, 1000), y=(0, None),
                 inset=inset)


def make_scaling(work: SomfaiWork, item: str) -> None:
    heights, unequal = boxes(work), [chains(work, spread) for spread in SPREADS]
    panels, ends = [], []
    for k, (name, sign) in enumerate((("amplitude", -1), ("width", 1))):
        systems = [_of(heights, name), _equal(name), *(_of(each, name) for each in unequal)]
        exponents = [_local(system, sign) for system in systems]
        panels.append(_panel(k, systems, exponents))
        ends.append(exponents[:2])
    work.draw_sheet(item, "fig7", Sheet(panels, aspect=0.95))
    ((x, a), (far, equal_a)), ((_, w), (_, equal_w)) = ends
    if a:
        work.say(item, f"In boxes 24 wide gamma goes from {a[0]:.2f} at L = {x[0]:.3g} to {a[-1]:.2f} at L = {x[-1]:.3g}, "
                       f"alpha from {w[0]:.2f} to {w[-1]:.2f}.")
    work.say(item, f"The equal chain is exact ({equal_a[-1].mean:.3f} and {equal_w[-1].mean:.3f} at L = {far[-1]:.0f}; "
                   "2/3 and 1/3 far away). The paper does not say how wide its distributions of balls are; here "
                   "diameters are uniform in 1 +- 0.1, 0.2 and 0.4.")


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
    work.draw_sheet(item, "fig4", Sheet(panels, columns=2))


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
        work.draw_sheet(item, "fig5", Sheet([panel], aspect=0.9))
    if len(found) > 1:
        low, high = found[0], found[-1]
        work.say(item, f"From L = {low.distance:.3g} to {high.distance:.3g} the first peak falls by a factor "
                       f"{low.amplitude.mean / high.amplitude.mean:.3g} and its width (t_zero - t10) grows by "
                       f"{high.width.mean / low.width.mean:.3g}.")
