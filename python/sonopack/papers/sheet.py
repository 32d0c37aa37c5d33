"""Figures of curves in panels, and the numbers behind them."""
from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._core import Floats
from .._table import Table

Limits = tuple[float | None, float | None]


def formula(markup: str) -> str:
    """The text of a figure: |x| is italic, _{x} and ^{x} are lowered and raised."""
    def piece(match: re.Match[str]) -> str:
        italic, sign, inside = match.groups()
        if italic is not None:
            return f"${italic}$".replace(" ", r"\,")
        words = re.sub(r"\|([^|]*)\|", r"}\1\\mathrm{", inside)
        return f"${sign}{{\\mathrm{{{words}}}}}$".replace(r"\mathrm{}", "")
    return re.sub(r"\|([^|]*)\||([_^])\{([^}]*)\}", piece, markup)


def plain(markup: str) -> str:
    """The same for a table: "c_tof"."""
    return re.sub(r"[|{}]", "", markup)


@dataclasses.dataclass
class Curve:
    """A curve, whose points that are not finite make gaps. ink: -1 is grey. dash: None for marks without a line. error:
    standard errors; lower, upper: edges of a light band. open: marks are filled with white."""

    x: Floats
    y: Floats
    label: str = ""
    error: Floats | None = None
    lower: Floats | None = None
    upper: Floats | None = None
    ink: int = 0
    dash: int | None = 0
    mark: str = ""
    open: bool = False
    width: float = 1.0

    def draw(self, ax: Any) -> Any:
        """Draws it, and returns what the legend shows."""
        from ..plot._frame import GREY, dash, ink, points

        colour = GREY if self.ink < 0 else ink(self.ink)
        look: dict[str, Any] = {"color": colour, "lw": self.width,
                                "ls": "none" if self.dash is None else dash(self.dash),
                                "marker": self.mark or None, "label": formula(self.label) or None}
        if self.lower is not None and self.upper is not None:
            ax.fill_between(self.x, self.lower, self.upper, color=colour, alpha=0.25, lw=0)
        return points(ax, self.x, self.y, self.error, hollow=self.open, **look)

    def points(self) -> list[Floats]:
        """x, y, error, lower and upper of each point."""
        none = np.full(len(self.x), np.nan)
        given = (self.x, self.y, self.error, self.lower, self.upper)
        return [none if each is None else np.asarray(each, float) for each in given]


@dataclasses.dataclass
class Panel:
    """Axes with curves. log: "x", "y" or "xy". zero: a thin line at y = 0."""

    curves: list[Curve]
    xlabel: str
    ylabel: str
    tag: str = ""
    log: str = ""
    x: Limits = (None, None)
    y: Limits = (None, None)
    zero: bool = False
    inset: Panel | None = None

    def draw(self, ax: Any) -> list[Any]:
        """Draws it, and returns the entries of its legend in the order of the curves."""
        from ..plot._frame import inset

        if "x" in self.log:
            ax.set_xscale("log")
        if "y" in self.log:
            ax.set_yscale("log", nonpositive="clip")
        drawn = [curve.draw(ax) for curve in self.curves]
        if self.zero:
            ax.axhline(0, color="black", lw=0.4, zorder=0)
        ax.set(xlabel=formula(self.xlabel), ylabel=formula(self.ylabel), xlim=self.x, ylim=self.y)
        if self.inset is not None:
            self.inset.draw(inset(ax))
        return [each for each, curve in zip(drawn, self.curves) if curve.label]

    def rows(self, name: str) -> tuple[list[tuple[str, int, str]], list[list[Floats]]]:
        """Panel, number and label of each point, and its numbers; those of the inset follow."""
        words, numbers = [], []
        for k, curve in enumerate(self.curves):
            words += [(name, k + 1, plain(curve.label))] * len(curve.x)
            numbers.append(curve.points())
        if self.inset is not None:
            more = self.inset.rows(f"{name} inset".strip() if name else " inset")
            words, numbers = words + more[0], numbers + more[1]
        return words, numbers


def _tag(ax: Any, text: str) -> None:
    """The tag of a panel in a corner where it hides nothing, else in the upper left one."""
    from ..plot._frame import Obstacles

    corners = ((0.02, 0.97, "left"), (0.98, 0.97, "right"), (0.02, 0.03, "left"), (0.98, 0.03, "right"),
               (0.02, 0.97, "left"))
    ax.figure.draw_without_rendering()
    there = Obstacles(ax)
    for x, y, side in corners:
        shown = ax.text(x, y, text, transform=ax.transAxes, va="top" if y > 0.5 else "bottom", ha=side, fontsize=8)
        extent = shown.get_window_extent()
        shown.remove()
        if there.leave(extent):
            break
    ax.add_artist(shown)


@dataclasses.dataclass
class Sheet:
    """Panels in rows of `columns`. aspect: height of a panel over its width."""

    panels: Sequence[Panel]
    columns: int = 1
    aspect: float = 0.75
    width: float | None = None

    def draw(self) -> Any:
        """The Axes of all panels."""
        from ..plot._frame import styled

        return styled(self._axes)()

    def _axes(self) -> Any:
        from ..plot._frame import legend, panels

        axes = panels(len(self.panels) // self.columns, self.columns, aspect=self.aspect, width=self.width).ravel()
        for ax, panel in zip(axes, self.panels):
            entries = panel.draw(ax)
            if panel.tag:
                _tag(ax, formula(panel.tag))
            legend(ax, entries, fixed=panel.y[1] is not None)
        return axes

    def table(self) -> Table:
        """The points of all curves."""
        words: list[tuple[str, int, str]] = []
        numbers: list[list[Floats]] = []
        for panel in self.panels:
            more = panel.rows(plain(panel.tag))
            words, numbers = words + more[0], numbers + more[1]
        names, counts, labels = ([each[k] for each in words] for k in range(3))
        columns = [np.concatenate([each[k] for each in numbers]) for k in range(5)]
        table = Table.from_columns({"panel": np.array(names, str), "curve": counts, "label": np.array(labels, str),
                                    **dict(zip(("x", "y", "error", "lower", "upper"), columns))})
        for panel in self.panels:
            name = plain(panel.tag)
            table.add_comment(f"{name}{': ' if name else ''}x: {plain(panel.xlabel)}; y: {plain(panel.ylabel)}")
        return table
