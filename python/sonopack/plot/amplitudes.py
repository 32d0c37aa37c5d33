"""Figures of fronts and bursts as they grow loud."""
from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._core import Floats
from .._records import Material
from ._frame import dash, ink, key, legend, mark, panels, points, styled, tag
from ._inputs import Input, common_unit, inputs
from ._units import LENGTH, PRESSURE, label, number, plain, refuse, unit_text

KEYS = {"dimension": "dimensions = {}", "friction": r"$\mu$ = {}", "p": "$p$ = {}", "amplitude": "$A$ = {}"}
FRONTS = ("amplitude", "speed_ratio", "speed_ratio_err", "slid", "opened", "carrying")
BURSTS = ("y", "ratio", "ratio_err")
GROUPS_MOST = 18


@dataclasses.dataclass
class Group:
    """Successive rows of one table with the same keys. columns: the arrays of FRONTS or BURSTS."""

    keys: dict[str, float]
    columns: dict[str, Floats]
    text: str = ""


@styled
def amplitude(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None, ax: Any = None) -> Any:
    """Speed over its linear limit, and the shares of contacts that opened and slid, against amplitude, from tables of
    `sonopack amplitude`: two Axes. Of bursts at planes F2/F1^2 against the height: one."""
    given = inputs(data, labels, material)
    names = FRONTS if _has(given[0], FRONTS) else BURSTS
    wrong = next((j for j, one in enumerate(given) if not _has(one, names)), None)
    if wrong is not None:
        raise refuse(given[wrong].name, f"table {wrong + 1}: must be of `sonopack amplitude', with fronts (amplitude, "
                                        f"speed_ratio) or with bursts at planes (y, ratio), all of one kind")
    groups = _groups(given, names)
    return _fronts(groups, ax) if names is FRONTS else _bursts(given, groups, ax)


def _has(one: Input, names: Sequence[str]) -> bool:
    return all(name in one.table and one.table[name].dtype.kind in "fiu" for name in names)


def _groups(given: Sequence[Input], names: Sequence[str]) -> list[Group]:
    keys = [name for name in KEYS if name not in names]
    groups = [group for one in given for group in _split(one, names, keys)]
    if not groups:
        raise refuse(given[0].name, "nothing to draw: the table has no row")
    if len(groups) > GROUPS_MOST:
        raise refuse(given[0].name, f"more than {GROUPS_MOST} curves: draw fewer rows, or means (--mean)")
    unit = unit_text(common_unit(given, "p", PRESSURE))
    differing = [name for name in keys if len({group.keys.get(name) for group in groups}) > 1]
    for group in groups:
        group.text = ", ".join(KEYS[name].format(number(group.keys[name], 3)) + (f" {unit}" if name == "p" else "")
                               for name in differing if name in group.keys)
    if len(groups) == 1 and given[0].own_label is not None:
        groups[0].text = plain(given[0].own_label)
    return groups


def _split(one: Input, names: Sequence[str], keys: Sequence[str]) -> list[Group]:
    """The x of a group ascend, so that files with the same keys make several."""
    columns = {name: one.column(name) for name in names}
    own = {name: one.column(name) for name in keys if name in one.table}
    x, rows = columns[names[0]], one.table.rows
    starts = [row for row in range(rows) if row == 0 or not x[row] > x[row - 1]
              or any(column[row] != column[row - 1] for column in own.values())]
    return [Group({name: column[a] for name, column in own.items()}, {name: each[a:b] for name, each in columns.items()})
            for a, b in zip(starts, [*starts[1:], rows])]


def _style(groups: Sequence[Group], group: Group, colour_key: str) -> dict[str, Any]:
    """Pressures (of bursts amplitudes) have colours, frictions marks, so that curves of both can be told apart."""
    def rank(name: str) -> int:
        return list(dict.fromkeys(each.keys.get(name) for each in groups)).index(group.keys.get(name))
    which = rank("friction")
    return {"color": ink(rank(colour_key) + 1), "marker": mark(which % 4), "hollow": which % 2 == 1}


def _fronts(groups: Sequence[Group], ax: Any) -> Any:
    axes = panels(2, 1, ax=ax, aspect=0.68)[:, 0]
    slid = False
    for group in groups:
        c, style = group.columns, _style(groups, group, "p")
        points(axes[0], c["amplitude"], c["speed_ratio"], c["speed_ratio_err"], ls="-", label=group.text or None, **style)
        points(axes[1], c["amplitude"], c["opened"] / c["carrying"], ls="-", **style)
        if np.any(c["slid"] > 0):
            slid = True
            axes[1].plot(c["amplitude"], c["slid"] / c["carrying"], color=style["color"], ls=dash(1))
    for one, letter, text in zip(axes, "ab", ("speed over its linear limit", "share of the contacts")):
        tag(one, f"({letter})")
        one.set(xscale="log", xlabel="amplitude $A$", ylabel=text)
    legend(axes[0])
    legend(axes[1], [key(color="black", marker="o", label="opened")]
           + ([key(color="black", ls=dash(1), label="slid")] if slid else []))
    return axes


def _bursts(given: Sequence[Input], groups: Sequence[Group], ax: Axes | None) -> Axes:
    ax = panels(ax=ax)[0, 0]
    for group in groups:
        points(ax, *(group.columns[name] for name in BURSTS), ls="-", label=group.text or None,
               **_style(groups, group, "amplitude"))
    ax.set_xlabel(label("height $y$", common_unit(given, "y", LENGTH)))
    ax.set_ylabel("$F_2/F_1^2$")
    legend(ax)
    return ax
