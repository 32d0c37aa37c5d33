"""Fronts against distance, for boxes of several heights and for chains: Table III, Figs. 4 to 7."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..._chain import chain_front
from ..._core import Floats, SonopackError
from ..._records import Front
from ..._signal import front
from ..._study import Store
from ..._table import Table
from ..sheet import Curve, Panel, Sheet
from .rows import Mean, exact, ratio, speed
from .samples import SomfaiWork

#: ensembles of boxes, by their numbers of grains
_BOXES = {100: "short", 200: "low", 400: "short", 600: "square", 1200: "tall", 2400: "tallest"}
MARKS = ("t10", "t_peak", "t_zero")
TIME_AXIS = "time |t|  [|d| (|ρ|/|E|*)^{1/2}]"


class Distance(NamedTuple):
    """Averages over the fronts of boxes of one height, or chains of one length. width = t_zero - t10."""

    grains: int
    distance: float
    t10: Mean
    t_peak: Mean
    t_zero: Mean
    amplitude: Mean
    width: Mean


def scaling(work: SomfaiWork, *ensembles: str) -> Table | None:
    """The fronts at p = 1e-4, as `sonopack table scaling' prints them; None without samples."""
    some = [sample for ensemble in ensembles for sample in work.some(ensemble, 1e-4, parts="front")]
    return Store(work.folder_of_store).table("scaling", samples=some) if some else None


def _distances(table: Table | None) -> list[Distance]:
    if table is None:
        return []
    columns = [[Mean(0, *each) for each in zip(table[name], table[name] * math.nan, table[f"{name}_err"])]
               for name in (*MARKS, "amplitude", "width10")]
    return [Distance(*row) for row in zip(table["grains"].tolist(), table["distance"].tolist(), *columns)]


def boxes(work: SomfaiWork) -> list[Distance]:
    """Boxes of 100 to 2400 grains, the lowest first."""
    return _distances(scaling(work, *dict.fromkeys(_BOXES.values())))


def fitted(distances: Sequence[Distance], most: float) -> list[Distance]:
    """Boxes for line fits: from L = 8, the lower height in the paper. It does not state where its figures end."""
    return [d for d in distances if 6 <= d.distance <= most]


def line(x: Sequence[float], y: Sequence[Mean]) -> Mean:
    """Slope of the line of least squares, all weights equal; the error follows from those of the points. NAN for fewer than
    two points."""
    if len(x) < 2:
        return exact(math.nan)
    off = np.array(x) - np.mean(x)
    off /= off @ off
    return Mean(0, float(off @ [each.mean for each in y]), math.nan, float(np.linalg.norm(off * [each.err for each in y])))


def power(x: Sequence[float], y: Sequence[Mean]) -> Mean:
    """The slope of ln y against ln x."""
    logarithms = [Mean(m.n, math.log(m.mean), math.nan, m.err / m.mean) for m in y]
    return line([math.log(each) for each in x], logarithms)


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

def make_arrivals(work: SomfaiWork, item: str) -> None:
    table = scaling(work, *dict.fromkeys(_BOXES.values()))
    found = _distances(table)
    for name, most in (("50", 60.0), ("100", math.inf)):
        some = fitted(found, most)
        work.state(f"slope-{name}", ratio(exact(1.0), line([d.distance for d in some], [d.t10 for d in some])))
    for low, high in zip(found, found[1:]):
        work.say(item, f"Between L = {low.distance:.3g} and {high.distance:.3g} the arrival moves with "
                       f"{speed(high.distance - low.distance, low.t10, high.t10):.3f}.")
    work.say(item, "The paper does not say how tall its tallest boxes were; the speed falls with the distance, so that "
                   "the slope depends on that.")
    if work.folder and table is not None:
        work.draw(item, "fig6", "fronts", table, signal=next(work.walk("square", 1e-4, most=1))[1])
        work.save_table("fig6", table)


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
        _fits(work, f"chain-{spread}", _distances(scaling(work, f"chain-{spread}")))
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

def _equal() -> dict[str, Floats]:
    """Chains of equal balls, exactly, with the columns of scaling()."""
    balls = np.floor(np.geomspace(4, 1000, EXACT) + 0.5)
    found = [chain_front(int(n)) for n in balls]
    columns = {name: np.array([getattr(each, name) for each in found]) for name in ("t10", "amplitude", "width")}
    gamma, alpha = (np.append(np.diff(np.log(columns[name])) / np.diff(np.log(balls)), math.nan)
                    for name in ("amplitude", "width"))
    return {"distance": balls, "t10": columns["t10"], "amplitude": columns["amplitude"], "width10": columns["width"],
            "gamma": -gamma, "alpha": alpha}


def _over_first(system: Mapping[str, Floats]) -> Table:
    """Amplitudes and widths over those of the shortest distance, and their local exponents."""
    first = {"amplitude": system["amplitude"][0], "width10": system["width10"][0], "gamma": 1.0, "alpha": 1.0}
    columns = {name: system[name] for name in ("distance", "t10")}
    for name, by in first.items():
        columns |= {name: system[name] / by, f"{name}_err": system.get(f"{name}_err", 0 * system[name]) / by}
    return Table.from_columns(columns, {"distance": "d"})


def make_scaling(work: SomfaiWork, item: str) -> None:
    heights, equal = scaling(work, *dict.fromkeys(_BOXES.values())), _equal()
    systems = {"2D packings": heights, "chain, equal balls": equal,
               **{f"chain, ± {float(spread):.0%}": scaling(work, f"chain-{spread}") for spread in SPREADS}}
    tables = {name: _over_first(each) for name, each in systems.items() if each is not None}
    work.draw(item, "fig7", "scaling", *tables.values(), labels=list(tables))
    columns = {name: np.concatenate([each[name] for each in tables.values()]) for name in tables["chain, equal balls"]}
    work.save_table("fig7", Table.from_columns({
        "system": np.repeat(list(tables), [each.rows for each in tables.values()]), **columns}, {"distance": "d"}))
    if heights is not None and heights.rows > 1:
        first, last = ({name: Mean(0, heights[name][k], math.nan, heights[f"{name}_err"][k]) for name in ("gamma", "alpha")}
                       for k in (0, heights.rows - 2))
        work.say(item, f"In boxes 24 wide gamma goes from {first['gamma']:.2f} at L = {heights['between'][0]:.3g} to "
                       f"{last['gamma']:.2f} at L = {heights['between'][heights.rows - 2]:.3g}, alpha from "
                       f"{first['alpha']:.2f} to {last['alpha']:.2f}.")
    work.say(item, f"The equal chain is exact ({equal['gamma'][-2]:.3f} and {equal['alpha'][-2]:.3f} at L = "
                   f"{math.sqrt(equal['distance'][-2] * equal['distance'][-1]):.0f}; 2/3 and 1/3 far away). The paper does "
                   "not say how wide its distributions of balls are; here diameters are uniform in 1 +- 0.1, 0.2 and 0.4.")


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
    made = [signals(work, _BOXES[d.grains], 1.15 * d.t_zero.mean, 400, d.grains) for d in found]
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
