"""Figures of first fronts against distance: arrival times, and local exponents of decay and broadening."""
from __future__ import annotations

import dataclasses
import math
import os
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from .._core import Floats
from .._records import Material
from .._scene import Scene
from ._frame import MARKS_OF_FRONT, dash, ink, inset, key, legend, mark, panels, points, styled, tag
from ._inputs import Input, common_unit, inputs
from ._units import LENGTH, PRESSURE, SPEED, TIME, label, number, plain, refuse, same_unit, unit_text
from .signals import FRONT_NAMES, traces_of

OCTAVE = math.sqrt(2)  # `chain front' computes exponents between N and 2 N
KEYS = {"p": "$p$ = {}{}", "width": "width {} $d$", "friction": r"$\mu$ = {}", "grains": "$N$ = {}"}
POSITIVE = ("distance", "amplitude", "width")
COLUMNS = ("distance", *MARKS_OF_FRONT, "amplitude", "width", "gamma", "alpha", "alpha_peak")


@dataclasses.dataclass
class Group:
    """Rows of one table that belong together: one pressure, width and friction, or one file. values, errors: [n] for each
    of COLUMNS, nan where the table has none; keys: the common values of KEYS."""

    source: Input
    values: dict[str, Floats]
    errors: dict[str, Floats]
    keys: dict[str, float]
    file: str = ""
    text: str = ""

    @property
    def between(self) -> Floats:
        """The distances of the exponents: the geometric means of the ends of their intervals."""
        distance = self.values["distance"]
        if is_chain(self.source):
            return OCTAVE * distance
        return np.append(np.sqrt(distance[:-1] * distance[1:]), math.nan)


def is_chain(one: Input) -> bool:
    """Whether distances are numbers of grains of a chain."""
    return "distance" not in one.table


# ---- reading --------------------------------------------------------------------------------------------------------

def groups_of(given: Sequence[Input]) -> list[Group]:
    """The groups of all tables, with what tells them apart."""
    groups = [group for one in given for group in _split(one)]
    if not groups:
        raise refuse(given[0].name, "nothing to draw: no row")
    _name(groups, given)
    return groups


def _find(one: Input) -> dict[str, str]:
    """The column of each of COLUMNS that the table has. `width` beside width10 is that of the box."""
    columns = {name: name for name in COLUMNS if name in one.table}
    if "width10" in one.table:
        columns["width"] = "width10"
    if "distance" not in one.table and "grains" in one.table:
        columns["distance"] = "grains"
    lacking = next((name for name in ("distance", "t10") if name not in columns), None)
    if lacking and "t" in one.table and ("F" in one.table or "F1" in one.table):
        raise refuse(one.name, "is a table of signals, without distances: run `sonopack front' on it first, and draw its "
                               "table")
    if lacking:
        raise refuse(one.name, f"the table has no column of numbers {lacking if lacking == 't10' else 'distance or grains'};"
                               f" must be of `sonopack table scaling' or `planes', `chain front' or `front'")
    return columns


def _split(one: Input) -> list[Group]:
    columns, nothing = _find(one), np.full(one.table.rows, math.nan)
    values, errors = {}, {}
    for name in COLUMNS:
        found = one.column(columns[name]) if name in columns else nothing
        bars = one.errors(columns[name]) if name in columns else None
        wrong = np.isinf(found) | ((found <= 0) if name in POSITIVE else np.zeros(len(found), bool))
        if wrong.any():
            row, must = int(np.argmax(wrong)), "above 0" if name in POSITIVE else "finite"
            raise refuse(one.name, f"row {row + 1}, {columns[name]} = {found[row]:g}: must be {must}, or nan")
        values[name], errors[name] = found, nothing if bars is None else bars
    keys = {name: one.column(name) for name in KEYS if name in one.table and name not in columns.values()
            and one.table[name].dtype.kind in "fiu"}
    files = one.table["file"].astype(str) if "file" in one.table else None
    starts = [0] + [row for row in range(1, one.table.rows) if not _joined(row, values["distance"], keys, files)]
    ends = [*starts[1:], one.table.rows]
    return [_group(one, slice(a, b), values, errors, keys, files) for a, b in zip(starts, ends) if b > a]


def _joined(row: int, distance: Floats, keys: dict[str, Floats], files: npt.NDArray[Any] | None) -> bool:
    """Rows of one group follow each other, with increasing distances; signals of one file belong together, and so do files
    with one signal each."""
    if files is not None:
        (name, several), (last, before) = _file_of(files[row]), _file_of(files[row - 1])
        return name == last if several and before else not several and not before
    same = all(column[row] == column[row - 1] or np.isnan(column[row]) and np.isnan(column[row - 1])
               for name, column in keys.items() if name != "grains")
    return same and not distance[row] <= distance[row - 1]


def _file_of(name: str) -> tuple[str, bool]:
    """The file of a row of `sonopack front', and whether it has several signals: "a.tsv:F2"."""
    found = re.fullmatch(r"(.*):F\d+", name)
    return (found.group(1), True) if found else (name, False)


def _group(one: Input, rows: slice, values: dict[str, Floats], errors: dict[str, Floats], keys: dict[str, Floats],
           files: npt.NDArray[Any] | None) -> Group:
    common = {name: column[rows][0] for name, column in keys.items() if len(set(column[rows].tolist())) == 1}
    group = Group(one, {name: each[rows] for name, each in values.items()},
                  {name: each[rows] for name, each in errors.items()}, common)
    if files is not None:
        name, several = _file_of(files[rows][0])
        alone = several or rows.stop - rows.start == 1
        group.file = plain(os.path.splitext(os.path.basename(name))[0]) if alone else "single signals"
    return group


def _name(groups: Sequence[Group], given: Sequence[Input]) -> None:
    """Names groups by what differs: settings, else the file."""
    unit = " " + unit_text(common_unit(given, "p", PRESSURE))
    differing = [name for name in KEYS if len({group.keys.get(name) for group in groups}) > 1]
    for group in groups:
        told = [KEYS[name].format(number(group.keys[name], 9 if name == "grains" else 3), unit) for name in differing
                if name in group.keys]
        others = sum(other.source is group.source for other in groups) > 1
        file = group.file if others else ""
        own = group.source.own_label
        group.text = ", ".join(filter(None, ([plain(own)] if own is not None else []) + ([file] if file else []) + told))
    texts = [group.text for group in groups]
    for group in groups:
        if len(groups) > 1 and texts.count(group.text) > 1 and group.source.own_label is None and len(given) > 1:
            group.text = ", ".join(filter(None, (plain(group.source.stem()), group.text)))


# ---- arrival times --------------------------------------------------------------------------------------------------

@styled
def fronts(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None, ax: Axes | None = None,
           signal: Any = None, scene: Scene | None = None) -> Axes:
    """Arrival, peak and zero crossing of fronts against distance with fitted lines, from tables of `sonopack table
    scaling`, `table planes`, `chain front` or `front`. signal: a signal or packing for an inset that explains the marks."""
    given = inputs(data, labels, material)
    groups = groups_of(given)
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
    low = min(np.nanmin(group.values[name], initial=0) for group in groups for name in MARKS_OF_FRONT)
    ax.set_xlim(left=0)
    if low >= 0:
        ax.set_ylim(bottom=0)
    ax.set_xlabel(distance_label(given))
    ax.set_ylabel(label("$t$", units[1]))
    legend(ax, entries)
    if signal is not None:
        _inset(ax, Input(signal, material=material), scene)
    return ax


def distance_label(given: Sequence[Input]) -> str:
    if is_chain(given[0]):
        return "length of the chain  [grains]"
    return label("distance", common_unit(given, "distance"))


def _add_arrivals(ax: Axes, group: Group, k: int, groups: Sequence[Group], units: tuple[str, str]) -> list[Any]:
    """A single group has a colour for each mark and the speeds of its lines; several groups have one colour each."""
    alone, entries, x = len(groups) == 1, [], group.values["distance"]
    for q, (name, shape) in enumerate(MARKS_OF_FRONT.items()):
        t, colour = group.values[name], ink(q + 1 if alone else k + 1)
        there = np.isfinite(x) & np.isfinite(t)
        if not there.any():
            continue
        points(ax, x[there], t[there], group.errors[name][there], hollow=name != "t_peak", marker=shape, color=colour)
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

@styled
def scaling(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None,
            ax: Any = None) -> npt.NDArray[Any]:
    """Local exponents gamma and alpha of amplitude and width against distance, with these in insets, from the tables of
    fronts. Returns two Axes."""
    given = inputs(data, labels, material)
    groups = groups_of(given)
    for name in ("gamma", "alpha"):
        if not any(np.any(np.isfinite(group.between * group.values[name])) for group in groups):
            raise refuse(given[0].name, "nothing to draw: no interval of distances has gamma and alpha; must be of "
                                        "`sonopack table scaling' or `planes', or `chain front'")
    axes = panels(2, 1, ax=ax, aspect=0.72)[:, 0]
    for k, group in enumerate(groups):
        _curve(axes[0], group, k, len(groups), group.between, "gamma", label=group.text)
        peaks = len(groups) <= 2 and np.any(np.isfinite(group.values["alpha_peak"]))
        names = (r"$t_\mathrm{zero} - t_{10}$", r"$t_\mathrm{zero} - t_\mathrm{peak}$") if peaks and len(groups) == 1 \
            else ("", "")
        _curve(axes[1], group, k, len(groups), group.between, "alpha", label=names[0])
        if peaks:
            _curve(axes[1], group, k, len(groups), group.between, "alpha_peak", label=names[1], mfc="white", ls=dash(2))
    for ax, letter, symbol in zip(axes, "ab", (r"$\gamma_\mathrm{eff}$", r"$\alpha_\mathrm{eff}$")):
        tag(ax, f"({letter})")
        ax.set(xscale="log", xlabel=distance_label(given), ylabel=symbol)
    limits = [(group.values["distance"], group.between[np.isfinite(group.values["gamma"])]) for group in groups]
    seen = np.concatenate([part for both in limits for part in both])
    for ax, name, symbol in zip(axes, ("amplitude", "width"), "AW"):
        ax.set_xlim(0.85 * np.nanmin(seen), np.nanmax(seen) / 0.85)
        legend(ax)
        if any(np.any(np.isfinite(group.values[name])) for group in groups):
            _sizes(ax, groups, name, symbol, given)
    return axes


def _curve(ax: Axes, group: Group, k: int, count: int, x: Floats, name: str, **words: Any) -> None:
    y, colour = group.values[name], ink(k + 1 if count > 1 else 0)
    there = np.isfinite(x) & np.isfinite(y)
    if there.any():
        points(ax, x[there], y[there], group.errors[name][there],
               **{"marker": mark(k % 4), "color": colour, "ls": dash(k), "lw": 0.7, **words})


def _sizes(ax: Axes, groups: Sequence[Group], name: str, symbol: str, given: Sequence[Input]) -> None:
    """An inset of amplitude or width against distance, where it hides least."""
    column = "width10" if name == "width" and "width10" in given[0].table else name
    inner = inset(ax)
    for k, group in enumerate(groups):
        _curve(inner, group, k, len(groups), group.values["distance"], name, ms=2)
    inner.set(xscale="log", yscale="log")
    inner.set_xlabel("grains" if is_chain(given[0]) else label("$L$", common_unit(given, "distance")))
    inner.set_ylabel(label(f"${symbol}$", common_unit(given, column)))
