"""Figures of first fronts against distance: arrival times, and local exponents of decay and broadening."""
from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._core import Floats
from .._scene import Scene
from ._frame import MARKS_OF_FRONT, column_of_panels, dash, figure, ink, inset, key, legend, mark, panels, points
from ._inputs import Group, Input, common_unit, groups_of
from ._units import LENGTH, SPEED, TIME, label, number, refuse, same_unit, unit_text
from .signals import FRONT_NAMES, traces_of

OCTAVE = math.sqrt(2)  # `chain front' computes exponents between N and 2 N
KEYS = {"p": "$p$ = {}{}", "width": "width {} $d$", "friction": r"$\mu$ = {}", "grains": "$N$ = {}"}
POSITIVE = ("distance", "amplitude", "width")
COLUMNS = ("distance", *MARKS_OF_FRONT, "amplitude", "width", "gamma", "alpha", "alpha_peak")


def is_chain(one: Input) -> bool:
    """Whether distances are numbers of grains of a chain."""
    return "distance" not in one.table


def between(group: Group) -> Floats:
    """The distances of the exponents: the geometric means of the ends of their intervals."""
    distance = group.columns["distance"]
    if is_chain(group.source):
        return OCTAVE * distance
    return np.append(np.sqrt(distance[:-1] * distance[1:]), math.nan)


def _find(one: Input) -> dict[str, str]:
    """The column of each of COLUMNS that the table has. `width` beside width10 is that of the box."""
    columns = {name: name for name in COLUMNS if name in one.table}
    if "width10" in one.table:
        columns["width"] = "width10"
    if is_chain(one) and "grains" in one.table:
        columns["distance"] = "grains"
    lacking = next((name for name in ("distance", "t10") if name not in columns), None)
    if lacking and "t" in one.table and ("F" in one.table or "F1" in one.table):
        raise refuse(one.name, "is a table of signals, without distances: run `sonopack front' on it first, and draw its "
                               "table")
    if lacking:
        raise refuse(one.name, f"the table has no column of numbers {lacking if lacking == 't10' else 'distance or grains'};"
                               f" must be of `sonopack table scaling' or `planes', `chain front' or `front'")
    return columns


def _read(one: Input) -> tuple[dict[str, Floats], list[str]]:
    """COLUMNS and their errors, nan where the table has none, and the keys."""
    columns, nothing = _find(one), np.full(one.table.rows, math.nan)
    values = {}
    for name in COLUMNS:
        found = one.column(columns[name]) if name in columns else nothing
        bars = one.errors(columns[name]) if name in columns else None
        wrong = np.isinf(found) | ((found <= 0) if name in POSITIVE else np.zeros(len(found), bool))
        one.check(columns.get(name, name), found, wrong, "above 0, or nan" if name in POSITIVE else "finite, or nan")
        values[name], values[f"{name}_err"] = found, nothing if bars is None else bars
    return values, [name for name in KEYS if name not in columns.values()]


# ---- arrival times --------------------------------------------------------------------------------------------------

@figure
def fronts(given: Sequence[Input], *, ax: Axes | None = None, signal: Any = None, scene: Scene | None = None) -> Axes:
    """Arrival, peak and zero crossing of fronts against distance with fitted lines, from tables of `sonopack table
    scaling`, `table planes`, `chain front` or `front`. signal: a signal or packing for an inset that explains the marks."""
    groups = groups_of(given, _read, "distance", KEYS, by_file=True)
    chains = {is_chain(one) for one in given}
    if len(chains) > 1:
        raise refuse(given[0].name, "chains beside packings: their distances and times have other units, must be of one "
                                    "kind")
    ax = panels(ax=ax, aspect=0.85)[0, 0]
    units = common_unit(given, "distance"), common_unit(given, "t10")
    entries = [handle for k, group in enumerate(groups) for handle in _add_arrivals(ax, group, k, groups, units)]
    if len(groups) > 1:
        entries += [key(marker=shape, mfc="black" if name == "t_peak" else "white", mec="black", ls="none",
                        label=FRONT_NAMES[name]) for name, shape in MARKS_OF_FRONT.items()]
    low = min(np.nanmin(group.columns[name], initial=0) for group in groups for name in MARKS_OF_FRONT)
    ax.set_xlim(left=0)
    if low >= 0:
        ax.set_ylim(bottom=0)
    ax.set(xlabel=distance_label(given), ylabel=label("$t$", units[1]))
    if signal is not None:
        _inset(ax, Input(signal, material=given[0].material), scene)
    legend(ax, entries)
    return ax


def distance_label(given: Sequence[Input]) -> str:
    if is_chain(given[0]):
        return "length of the chain  [grains]"
    return label("distance", common_unit(given, "distance"))


def _add_arrivals(ax: Axes, group: Group, k: int, groups: Sequence[Group], units: tuple[str, str]) -> list[Any]:
    """A single group has a colour for each mark and the speeds of its lines; several groups have one colour each."""
    alone, entries, x = len(groups) == 1, [], group.columns["distance"]
    for q, (name, shape) in enumerate(MARKS_OF_FRONT.items()):
        t, colour = group.columns[name], ink(q + 1 if alone else k + 1)
        there = np.isfinite(x) & np.isfinite(t)
        if not there.any():
            continue
        points(ax, x[there], t[there], group.columns[f"{name}_err"][there], hollow=name != "t_peak", marker=shape, color=colour)
        text = FRONT_NAMES[name] if alone else group.text if q == 0 else ""
        if there.sum() > 1 and np.ptp(x[there]) > 1e-6 * abs(x[there].mean()):
            slope, start = np.polyfit(x[there], t[there], 1)
            ends = np.array([x[there].min(), x[there].max()])
            ax.plot(ends, start + slope * ends, color=colour, ls=dash(q), lw=0.7)
            text += f",  {_speed(1 / slope, units)}" if alone and slope > 0 else ""
        if text:
            entries.append(key(marker=shape, color=colour, mfc=colour if name == "t_peak" else "white", ls=dash(q), lw=0.7,
                               label=text))
    return entries


def _speed(value: float, units: tuple[str, str]) -> str:
    distance, time = units
    if same_unit(time, "l/c"):
        return f"$v$ = {number(value, 3)} $c$"
    if same_unit(distance, LENGTH) and same_unit(time, TIME):
        unit = unit_text(SPEED)
    else:
        unit = f"{unit_text(distance)}/{unit_text(time)}" if distance and time else ""
    return f"$c$ = {number(value, 3)} {unit}".strip()


def _inset(ax: Axes, source: Input, scene: Scene | None) -> None:
    """A signal with its three marks, up to twice its zero crossing."""
    trace = traces_of(source, scene)[0]
    found = trace.front()
    if found is None or not np.isfinite(found.t_zero):
        raise refuse(source.name, "the signal ends before its first front does")
    inner = inset(ax)
    there = trace.t <= 2 * found.t_zero
    inner.plot(trace.t[there], trace.f[there], color="black", lw=0.8)
    for q, (name, shape) in enumerate(MARKS_OF_FRONT.items()):
        time = getattr(found, name)
        inner.plot(time, np.interp(time, trace.t, trace.f), marker=shape, color=ink(q + 1),
                   mfc=ink(q + 1) if name == "t_peak" else "white", ls="none")
    inner.axhline(0, color="black", lw=0.4)
    inner.set_xlabel(label("$t$", trace.t_unit))
    inner.set_ylabel(label(r"$F_\mathrm{sig}$", trace.f_unit))


# ---- exponents ------------------------------------------------------------------------------------------------------

@figure
def scaling(given: Sequence[Input], *, ax: Any = None) -> Any:
    """Local exponents gamma and alpha of amplitude and width against distance, with these in insets, from the tables of
    fronts. Returns two Axes."""
    groups = groups_of(given, _read, "distance", KEYS, by_file=True)
    for name in ("gamma", "alpha"):
        if not any(np.any(np.isfinite(between(group) * group.columns[name])) for group in groups):
            raise refuse(given[0].name, "nothing to draw: no interval of distances has gamma and alpha; must be of "
                                        "`sonopack table scaling' or `planes', or `chain front'")
    axes = column_of_panels(2, ax, 0.72)
    for k, group in enumerate(groups):
        _curve(axes[0], group, k, len(groups), between(group), "gamma", label=group.text)
        peaks = len(groups) <= 2 and np.any(np.isfinite(group.columns["alpha_peak"]))
        names = (r"$t_\mathrm{zero} - t_{10}$", r"$t_\mathrm{zero} - t_\mathrm{peak}$") if peaks and len(groups) == 1 \
            else ("", "")
        _curve(axes[1], group, k, len(groups), between(group), "alpha", label=names[0])
        if peaks:
            _curve(axes[1], group, k, len(groups), between(group), "alpha_peak", label=names[1], mfc="white", ls=dash(2))
    limits = [(group.columns["distance"], between(group)[np.isfinite(group.columns["gamma"])]) for group in groups]
    seen = np.concatenate([part for both in limits for part in both])
    for ax, name, exponent, symbol in zip(axes, ("amplitude", "width"), (r"\gamma", r"\alpha"), "AW"):
        ax.set(xscale="log", xlabel=distance_label(given), ylabel=rf"${exponent}_\mathrm{{eff}}$",
               xlim=(0.85 * np.nanmin(seen), np.nanmax(seen) / 0.85))
        if any(np.any(np.isfinite(group.columns[name])) for group in groups):
            _sizes(ax, groups, name, symbol, given)
        legend(ax)
    return axes


def _curve(ax: Axes, group: Group, k: int, count: int, x: Floats, name: str, **words: Any) -> None:
    y, colour = group.columns[name], ink(k + 1 if count > 1 else 0)
    there = np.isfinite(x) & np.isfinite(y)
    if there.any():
        points(ax, x[there], y[there], group.columns[f"{name}_err"][there],
               **{"marker": mark(k % 4), "color": colour, "ls": dash(k), "lw": 0.7, **words})


def _sizes(ax: Axes, groups: Sequence[Group], name: str, symbol: str, given: Sequence[Input]) -> None:
    """An inset of amplitude or width against distance, where it hides least."""
    column = "width10" if name == "width" and "width10" in given[0].table else name
    inner = inset(ax)
    for k, group in enumerate(groups):
        _curve(inner, group, k, len(groups), group.columns["distance"], name, ms=2)
    inner.set(xscale="log", yscale="log", ylabel=label(f"${symbol}$", common_unit(given, column)),
              xlabel="grains" if is_chain(given[0]) else label("$L$", common_unit(given, "distance")))
