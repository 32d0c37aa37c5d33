"""Pictures of packings and columns, by the functions of sonopack.plot, and histograms of contacts."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .. import plot
from .._core import Floats
from .._modes import Modes
from .._network import Network
from .._packing import Packing
from .._table import Table
from ..plot._frame import GREY, dash, ink, legend, panels, styled


def _figure(axes: Any) -> Figure:
    figure: Figure = np.ravel(np.asarray(axes, object))[0].figure
    return figure


def network(packing: Packing, links: str) -> Figure:
    """Forces or stiffnesses of the contacts as widths of lines."""
    return _figure((plot.network if links == "forces" else plot.stiffness)(packing))


def snapshot(network: Network, u: Floats, time: float) -> Figure:
    """Displacements [n][dof] of the grains as arrows."""
    return _figure(plot.snapshot(network, u, time=time))


def mode(modes: Modes, number: int) -> Figure:
    """Displacements in a mode as arrows."""
    return _figure(plot.mode(modes, mode=number))


def column(tables: Sequence[Table], labels: Sequence[str] | None = None) -> Figure:
    """Tables of a column, as `sonopack plot column` draws them."""
    return _figure(plot.column(*tables, labels=labels))


def values(table: Table) -> Figure:
    """Histograms of forces and stiffnesses over their means."""
    return _figure(_values(table))


def angles(table: Table) -> Figure:
    """Densities of directions of contacts, in polar form: n and -n are the same contact. The circle is isotropic."""
    return _figure(_angles(table))


@styled
def _values(table: Table) -> Any:
    ax = panels()[0, 0]
    edges = np.append(table["x"] - 0.05, table["x"][-1] + 0.05)
    for k, (name, word) in enumerate((("forces", "normal force"), ("stiffnesses", "normal stiffness"))):
        ax.stairs(table[name], edges, color=ink(k + 1), ls=dash(k), lw=1, label=word)
    ax.set_xlim(0, edges[-1])
    ax.set_ylim(0, None)
    mean = r"{0}_\mathrm{{n}}/\langle {0}_\mathrm{{n}}\rangle"
    ax.set_xlabel(f"${mean.format('F')}$,  ${mean.format('k')}$")
    ax.set_ylabel("probability density")
    legend(ax)
    return ax


@styled
def _angles(table: Table) -> Any:
    ax = panels(subplot_kw={"projection": "polar"}, aspect=1.0)[0, 0]
    step = table["angle"][1] - table["angle"][0]
    starts = np.concatenate([table["angle"], table["angle"] + 180]) - step / 2
    turned = np.radians(np.append((starts[:, None] + np.linspace(0, step, 4)).ravel(), starts[0]))
    around = np.linspace(0, 2 * np.pi, 181)
    ax.plot(around, np.ones(181), color=GREY, lw=1, zorder=1)
    strong = r"strong: $F > \langle F\rangle$", r"weak: $F \leq \langle F\rangle$"
    looks = {"all": (0, 0, 1.4, "all contacts"), "strong": (2, 0, 1, strong[0]), "weak": (1, 1, 1, strong[1])}
    for name, (colour, dashes, width, word) in looks.items():
        density = np.repeat(np.tile(table[name], 2), 4)
        ax.plot(turned, np.append(density, density[0]), color=ink(colour), ls=dash(dashes), lw=width, label=word)
    ax.set_ylim(0, None)
    ax.set_rlabel_position(75)
    ax.set_thetagrids(range(0, 360, 30))
    ax.set_title("density (isotropic: 1)", fontsize=7)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.06), ncol=3, columnspacing=1)
    return ax
