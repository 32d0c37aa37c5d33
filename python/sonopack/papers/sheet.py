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

    def column(self, name: str) -> Floats:
        """A number of each point: x, y, error, lower or upper."""
        values = getattr(self, name)
        return np.full(len(self.x), np.nan) if values is None else np.asarray(values, float)


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

    def named(self, name: str) -> list[tuple[str, int, Curve]]:
        """The curves with the name of their panel and their number; those of the inset follow."""
        found = [(name, k + 1, curve) for k, curve in enumerate(self.curves)]
        return found + (self.inset.named(f"{name} inset") if self.inset is not None else [])


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
        from ..plot._frame import legend, letter, panels

        axes = panels(len(self.panels) // self.columns, self.columns, aspect=self.aspect, width=self.width).ravel()
        for ax, panel in zip(axes, self.panels):
            entries = panel.draw(ax)
            if panel.tag:
                letter(ax, formula(panel.tag))
            legend(ax, entries, fixed=panel.y[1] is not None)
        return axes

    def table(self) -> Table:
        """The points of all curves."""
        names, numbers, curves = zip(*(row for panel in self.panels for row in panel.named(plain(panel.tag))))
        points = [len(curve.x) for curve in curves]
        table = Table.from_columns({
            "panel": np.repeat(names, points), "curve": np.repeat(numbers, points),
            "label": np.repeat([plain(curve.label) for curve in curves], points),
            **{name: np.concatenate([curve.column(name) for curve in curves])
               for name in ("x", "y", "error", "lower", "upper")}})
        for panel in self.panels:
            name = plain(panel.tag)
            table.add_comment(f"{name}{': ' if name else ''}x: {plain(panel.xlabel)}; y: {plain(panel.ylabel)}")
        return table
