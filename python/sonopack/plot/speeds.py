"""Figures of the speed of sound against pressure, and of run time against error."""
from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._command import usage
from .._core import Floats
from .._records import Material
from .._study import Store
from ._frame import GREY, INKS, dash, figure, ink, key, legend, mark, panels, points, styled
from ._inputs import Input, common_dimension, common_unit, inputs, names
from ._units import PRESSURE, SPEED, label, measured, plain, refuse, same_unit

SPEEDS = {"c_tof": r"$c_\mathrm{tof}$", "c_l": "$c_l$", "c_t": "$c_t$"}


@styled
def ctof(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None, ax: Axes | None = None,
         published: bool | None = None, store: str | None = None) -> Axes:
    """Speeds c_tof, c_l and c_t with their errors against pressure. The power law of c_tof has the exponent in the comments
    of the table, otherwise that of a fit through three or more points. published: whether to draw c_tof = 0.26
    (p/1e-4)^(1/6) (Somfai et al. 2005, Secs. IV C and D); by default where all tables say dimension = 2 and have our units.
    store: the folder of a study, in place of tables."""
    given = inputs([*data, *_of_store(store, material)], labels, material)
    ax = panels(ax=ax, aspect=0.78 + 0.03 * (len(given) - 1))[0, 0]
    ax.set(xscale="log", yscale="log")
    units = common_unit(given, "p", PRESSURE), common_unit(given, "c_tof", SPEED)
    made = [_add_speeds(ax, one, name, k, len(given)) for k, (one, name) in enumerate(zip(given, names(given)))]
    entries, used = [entry for entry, _ in made], [speed for _, speeds in made for speed in speeds]
    pressures = np.concatenate([line.get_xdata() for line in ax.lines if line.get_gid() == "points"] or [np.array([])])
    if not len(pressures):
        raise refuse(given[0].name, "nothing to draw: no row has a pressure and a speed")
    low, high = pressures.min(), pressures.max()
    entries += [key(marker=mark(q), mfc="white", ls="none", color=ink(q + 1 if len(given) == 1 else 0), label=SPEEDS[name])
                for q, name in enumerate(SPEEDS) if q and name in used]
    if _shows_published(published, given, units):
        entries.append(_published(ax, low, high))
    beyond = 10 ** max(0.25, 1 - 0.5 * np.log10(high / low))
    ax.set(xlim=(low / beyond, high * beyond), xlabel=label("$p$", units[0]), ylabel=label("$c$", units[1]))
    legend(ax, entries)
    return ax


def _of_store(store: str | None, material: Material | None) -> list[Input]:
    if store is None:
        return []
    opened = Store(store)
    made = Input(opened.table("ctof"), material=material)
    made.name = store
    bad = [sample for sample in opened.samples() if getattr(sample, "failed", False)]
    if bad:
        warnings.warn(f"{store}: {len(bad)} samples failed and are not used", stacklevel=3)
    return [made]


def _positive(one: Input, name: str, values: Floats | None) -> Floats:
    """Values that a logarithmic axis can show, or nan; nan where there is no column."""
    if values is None:
        return np.full(one.table.rows, np.nan)
    one.check(name, values, (values <= 0) | np.isinf(values), "above 0, or nan")
    return values


def _add_speeds(ax: Axes, one: Input, name: str, k: int, count: int) -> tuple[Any, list[str]]:
    """The points of one table. One table has a colour for each speed, several have one each."""
    hint, used = "a ctof table has p, c_tof, c_tof_err, c_l, c_t", []
    p = _positive(one, "p", one.column("p", hint))
    one.column("c_tof", hint)
    for q, speed in enumerate(SPEEDS):
        c, error = _positive(one, speed, one.optional(speed)), one.errors(speed)
        there = np.isfinite(p) & np.isfinite(c)
        if not there.any():
            continue
        used.append(speed)
        points(ax, p[there], c[there], error[there] if error is not None else None, hollow=q > 0, marker=mark(q),
               color=ink(q + 1 if count == 1 else k + 1), gid="points")
    law = _power_law(one, p)
    colour, text = ink(1 if count == 1 else k + 1), SPEEDS["c_tof"]
    if law:
        ax.plot(law[2], law[3], color=colour, ls=dash(k), lw=0.7)
        text += rf" $\sim\, p^{{{measured(*law[:2])}}}$"
    handle = key(color=colour, marker=mark(0), ls=dash(k) if law else "none", lw=0.7,
                 label=f"{name}: {text}" if name else text)
    return handle, used


def _power_law(one: Input, p: Floats) -> tuple[float, float, Floats, Floats] | None:
    """Exponent, its error, and the line: through the mean of the points, weighted by their errors."""
    c, error = one.column("c_tof"), one.errors("c_tof")
    there = np.isfinite(p) & np.isfinite(c)
    x, y = np.log(p[there]), np.log(c[there])
    slope, spread = one.number("exponent"), one.number("exponent_err")
    if len(x) == 0 or not np.ptp(x) > 0 or (np.isnan(slope) and len(x) < 3):
        return None
    if np.isnan(slope):
        (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
        spread = float(np.sqrt(covariance[0, 0]))
    bars = error[there] / c[there] if error is not None else np.zeros(len(x))
    weights = 1 / bars**2 if np.all(bars > 0) else np.ones(len(x))
    line = np.geomspace(p[there].min(), p[there].max(), 64)
    return slope, spread, line, np.exp(np.average(y - slope * x, weights=weights) + slope * np.log(line))


def _shows_published(wish: bool | None, given: Sequence[Input], units: tuple[str, str]) -> bool:
    ours = same_unit(units[0], PRESSURE) and same_unit(units[1], SPEED)
    if wish and not ours:
        raise usage(f"--published: the line has p in {PRESSURE} and c in {SPEED}, the table in {units[0]} and {units[1]}")
    return ours and common_dimension(given) == 2 if wish is None else wish


def _published(ax: Axes, low: float, high: float) -> Any:
    beyond = 10 ** max(0.15, 0.5 - 0.5 * np.log10(high / low))
    p = np.geomspace(low / beyond, high * beyond, 64)
    return ax.plot(p, 0.26 * (p / 1e-4)**(1 / 6), color="black", ls=dash(1), lw=0.8,
                   label=r"$p^{1/6}$, Somfai $et\ al.$")[0]


# ---- run time against error -----------------------------------------------------------------------------------------

@figure
def pareto(given: Sequence[Input], *, ax: Axes | None = None, case: str | None = None) -> Axes:
    """Run time against error from a table of `sonopack bench`, one symbol for each method, hollow for those of other
    programs, which have a blank in their names. A grey line joins the methods that are fastest at their error. case: of the
    table; by default that of its first row."""
    one = given[0]
    if not {"case", "method", "seconds", "error"} <= set(one.table):
        raise refuse(one.name, "the table lacks one of the columns case, method, seconds, error of a bench")
    cases, methods = (one.table[name].astype(str) for name in ("case", "method"))
    chosen = case or str(next(iter(cases), ""))
    seconds, error = one.column("seconds"), np.maximum(one.column("error"), 1e-17)
    there = (cases == chosen) & (methods != "auto") & (seconds > 0) & np.isfinite(seconds + error)
    if not there.any():
        raise refuse(one.name, f"nothing to draw: no row of case {chosen:.80} has a time and an error, must be as in the "
                               f"column case")
    ax = panels(ax=ax, aspect=0.9)[0, 0]
    low, high = error[there].min(), error[there].max()
    beyond = 10 ** max(0.6, 1 - 0.5 * np.log10(high / low))
    _frontier(ax, error[there], seconds[there], high * beyond)
    counts = {False: 0, True: 0}
    for method in dict.fromkeys(methods[there]):
        rival, mine = " " in method, there & (methods == method)
        k, order = counts[rival], np.argsort(error[mine])
        counts[rival] += 1
        points(ax, error[mine][order], seconds[mine][order], hollow=rival, color=INKS[1 + k % 6], marker=mark(k + k // 4),
               ls=dash(2), lw=0.6, label=plain(method))
    ax.set(xscale="log", yscale="log", xlim=(low / beyond, high * beyond), ylabel="CPU time  [s]")
    ax.set_xlabel(f"relative error  ({plain(chosen.rpartition('.')[0] if ':' in chosen and '.' in chosen else chosen)})")
    legend(ax)
    return ax


def _frontier(ax: Axes, error: Floats, seconds: Floats, end: float) -> None:
    """A staircase from the most accurate run to the fastest one, and on to `end`, the edge of the figure."""
    order = np.lexsort((seconds, error))
    least = np.minimum.accumulate(seconds[order])
    best = np.r_[True, least[1:] < least[:-1]]
    x, y = error[order][best], least[best]
    ax.step(np.r_[x, end], np.r_[y, y[-1]], where="post", color=GREY, lw=0.8)
