"""Histograms of contacts: directions, normal forces and stiffnesses, as Figs. 2 and 1(c) of Somfai et al. 2005."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._core import Floats, SonopackError, invalid
from .._scene import Scene
from .._table import Table
from ._frame import WIDTH, dash, ink, legend, panels, styled
from ._histograms import ContactCounts
from ._inputs import Input, inputs
from ._units import refuse
from ._view import key_below, picture
from .packing import packing_of, threshold_of

BULK = 3.0  # distance of the contacts from the walls [d]
ENOUGH = 60  # contacts of a bin; with fewer, three bins become one
CURVES = {"all": ("all contacts", 0, 1.6, 0), "strong": (r"strong: $F > \langle F\rangle$", 2, 1.0, 0),
          "weak": (r"weak: $F \leq \langle F\rangle$", 1, 1.0, 1)}  # label, ink, width, dash


def _table(given: Sequence[Input], scene: Scene | None, make: Callable[[ContactCounts], Table]) -> Input:
    """The table that is given, or the counts of all packings."""
    if len(given) == 1 and not given[0].is_packing and not hasattr(given[0].source, "packing"):
        return given[0]
    counts = ContactCounts()
    for one in given:
        try:
            counts.add(packing_of(one), threshold_of(scene), BULK)
        except SonopackError as fault:
            raise refuse(one.name, str(fault)) from None
    return Input(make(counts))


# ---- directions -----------------------------------------------------------------------------------------------------

@styled
def angles(*data: Any, ax: Any = None, scene: Scene | None = None) -> Axes:
    """Directions of the contacts of packings, at least 3 d from the walls: all, strong and weak contacts. A circle of
    radius 1 is isotropic. In three dimensions angles are those above the horizontal. data: packings, or a table with
    the columns angle, all, strong, weak. ax: polar Axes."""
    one = _table(inputs(data), scene, ContactCounts.angles)
    angle, densities = _densities(one)
    quarter, merged = one.number("dimension") == 3, _merged(one, len(angle))
    if ax is None:
        ax = picture(WIDTH).add_subplot(projection="polar", label="panel")
    elif ax.name != "polar":
        raise invalid("ax", "must have projection='polar'")
    largest = 0.0
    for name, density in densities.items():
        text, colour, width, dashes = CURVES[name]
        edges, values = _bins(angle, density, merged)
        largest = max(largest, values.max())
        around, radii = _outline(edges, values, quarter)
        ax.plot(around, radii, color=ink(colour), lw=width, ls=dash(dashes), label=text)
    _rings(ax, largest, quarter)
    return ax


def _densities(one: Input) -> tuple[Floats, dict[str, Floats]]:
    """Angles in degrees, and densities over that of isotropic directions."""
    hint = "a table of directions has angle, all, strong, weak"
    angle, found = one.column("angle", hint), {"all": one.column("all", hint)}
    found |= {name: one.column(name) for name in ("strong", "weak") if name in one.table}
    if not 2 <= len(angle) <= 100_000:
        raise refuse(one.name, f"{len(angle)} rows of angles, must be 2 or more")
    wrong = ~np.isfinite(angle) | (np.diff(angle, prepend=-np.inf) <= 0)
    if np.any(wrong):
        row = int(np.argmax(wrong))
        raise refuse(one.name, f"row {row + 1}, angle = {angle[row]:g}: must be finite and rise from row to row")
    for name, values in found.items():
        wrong = (values < 0) | np.isinf(values)
        if np.any(wrong):
            row = int(np.argmax(wrong))
            raise refuse(one.name, f"row {row + 1}, {name} = {values[row]:g}: a density is a finite number >= 0")
    if not any(np.any(values > 0) for values in found.values()):
        raise refuse(one.name, f"nothing to draw: no row of {len(angle)} has a density above 0")
    return angle, {name: np.nan_to_num(values) for name, values in found.items()}


def _merged(one: Input, rows: int) -> int:
    """Few contacts in narrow bins are noise: three rows become one bin, with the middle one in its middle."""
    few = one.number("contacts") / rows < ENOUGH and one.number("dimension") in (2, float("nan"))
    return 3 if few and rows % 3 == 0 and rows >= 12 else 1


def _bins(angle: Floats, density: Floats, merged: int) -> tuple[Floats, Floats]:
    """Edges [bins + 1] in radians, over half a turn, and densities."""
    values = np.roll(density, merged // 2).reshape(-1, merged).mean(axis=1)
    middles = angle[::merged]
    around = np.concatenate([[middles[-1] - 180], middles, [middles[0] + 180]])
    return np.deg2rad(0.5 * (around[1:] + around[:-1])), values


def _outline(edges: Floats, values: Floats, quarter: bool) -> tuple[Floats, Floats]:
    """Arcs of the bins of n and of -n, joined by radii; of a quarter the part above the horizontal."""
    pieces = [np.linspace(low, high, max(2, int((high - low) / 0.02))) for low, high in zip(edges, edges[1:])]
    half = np.concatenate(pieces)
    radii = np.repeat(values, [len(piece) for piece in pieces])
    if quarter:
        return half, np.where((half >= 0) & (half <= np.pi / 2), radii, np.nan)
    around, both = np.concatenate([half, half + np.pi]), np.tile(radii, 2)
    return np.append(around, around[0] + 2 * np.pi), np.append(both, both[0])


def _rings(ax: Any, largest: float, quarter: bool) -> None:
    """Rings at round values, that at 1 thicker, with their numbers outside the curves; every 30 degrees."""
    step = float(np.ceil(largest / 2.4)) if largest > 2.4 else 0.5
    rings = step * np.arange(1, np.ceil(largest / step) + 1)
    ax.set_rgrids(rings, [f"{ring:g}" for ring in rings], angle=0 if quarter else 22.5, fontsize=6.5)
    ax.set_thetagrids(np.arange(0, 91 if quarter else 360, 30), fontsize=6.5)
    ax.set_rlim(0, rings[-1])
    ax.set_thetamax(90 if quarter else 360)
    ax.tick_params(pad=1)
    ax.grid(color="0.7", lw=0.4)
    ax.minorticks_off()
    ax.plot(np.linspace(0, np.pi / 2 if quarter else 2 * np.pi, 200), np.ones(200), color="0.5", lw=1.0, zorder=1)
    ax.spines[:].set_visible(quarter)
    ax.set_axisbelow(False)  # the numbers of rings stand above the curves
    for text in ax.get_yticklabels():
        text.set_bbox({"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.8})
    title = "radius: density, isotropic 1" + ("; angle above the horizontal" if quarter else "")
    key_below(ax, [line for line in ax.lines if not line.get_label().startswith("_")], title)


# ---- values ---------------------------------------------------------------------------------------------------------

@styled
def forces(*data: Any, ax: Any = None, scene: Scene | None = None) -> Axes:
    """Histograms of normal forces and stiffnesses, divided by their means, with standard errors over several packings.
    data: packings, or a table with the columns x, forces, stiffnesses."""
    one = _table(inputs(data), scene, ContactCounts.values)
    hint = "a table of contact values has x, forces, stiffnesses"
    x, values = one.column("x", hint), [one.column(name, hint) for name in ("forces", "stiffnesses")]
    if len(x) < 2:
        raise refuse(one.name, f"{len(x)} rows of values, must be 2 or more")
    edges = np.concatenate([[1.5 * x[0] - 0.5 * x[1]], 0.5 * (x[1:] + x[:-1]), [1.5 * x[-1] - 0.5 * x[-2]]])
    ax = panels(ax=ax)[0, 0]
    for k, (name, density) in enumerate(zip(("forces", "stiffnesses"), values)):
        ax.stairs(density, edges, color=ink(1 + k), ls=dash(k), lw=1.0, label=f"normal {('force', 'stiffness')[k]}")
        error = one.errors(name)
        if error is not None and np.any(error > 0):
            ax.errorbar(x, density, yerr=np.nan_to_num(error), ls="none", color=ink(1 + k), elinewidth=0.5, capsize=0)
    ax.set(xlim=(edges[0], edges[-1]), xlabel=r"$F_\mathrm{n}/\langle F_\mathrm{n}\rangle$,  "
           r"$k_\mathrm{n}/\langle k_\mathrm{n}\rangle$", ylabel="probability density")
    ax.set_ylim(bottom=0)
    legend(ax)
    return ax
