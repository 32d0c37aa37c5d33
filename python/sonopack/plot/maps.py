"""Heat maps: waves over wave number and frequency, signals over time and frequency; with the ridges of their
branches."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from .._core import Floats, Integers
from .._scene import Scene
from ._frame import WIDTH, figure, panels
from ._inputs import Input
from ._units import FREQUENCY, TIME, label, refuse, same_unit, unit_text
from .signals import Trace, traces_of

DECADES = 3.0  # of a map, below its largest value
STEEP = 8.0  # price of a ridge for climbing from the lowest row to the highest, in logarithms of what lies on it


def ridge(values: Floats, steep: float = STEEP) -> Integers:
    """Rows [columns] of the continuous line through a map [rows][columns] with the most on it: the sum of the
    logarithms minus `steep` for the part of all rows that it climbs and falls is the largest. The largest value of each
    column alone would jump between branches."""
    rows, columns = values.shape
    height = np.log(np.maximum(values, np.max(values) * 1e-12))
    price = steep / rows * np.abs(np.arange(rows)[:, None] - np.arange(rows)[None, :])
    best, came = height[:, 0], np.empty((columns, rows), int)
    for k in range(1, columns):
        reached = best[None, :] - price
        came[k] = np.argmax(reached, axis=1)
        best = height[:, k] + np.take_along_axis(reached, came[k][:, None], axis=1)[:, 0]
    path = np.empty(columns, int)
    path[-1] = np.argmax(best)
    for k in range(columns - 1, 0, -1):
        path[k - 1] = came[k, path[k]]
    return path


def _edges(middles: Floats) -> Floats:
    """Edges of cells around values."""
    if len(middles) == 1:
        return np.array([0.5, 1.5]) * float(middles[0])
    half = 0.5 * np.diff(middles)
    return np.concatenate([[middles[0] - half[0]], middles[:-1] + half, [middles[-1] + half[-1]]])


def _map(ax: Axes, x: Floats, y: Floats, values: Floats, most: float) -> Any:
    """Cells [y][x], lighter where there is more, and the line of their ridge, which its outline keeps visible."""
    norm = LogNorm(most * 10**-DECADES, most)
    cells = ax.pcolormesh(_edges(x), _edges(y), np.maximum(values, norm.vmin), norm=norm, rasterized=True)
    path = y[ridge(values)]
    few = {"marker": "o", "ms": 2.5} if len(x) <= 60 else {}
    ax.plot(x, path, color="white", lw=2.0, **few, mew=1.2, mec="white")
    ax.plot(x, path, color="black", lw=0.9, **few, mew=0, label="ridge")
    ax.set(xlim=_edges(x)[[0, -1]], ylim=(max(0.0, _edges(y)[0]), _edges(y)[-1]))
    return cells


def _bar(axes: npt.NDArray[Any], cells: Any, text: str) -> None:
    bar = axes.flat[0].figure.colorbar(cells, ax=list(axes.flat), extend="min", aspect=30, pad=0.02)
    bar.set_label(text, fontsize=7)


# ---- waves ----------------------------------------------------------------------------------------------------------

_BRANCHES = ("longitudinal", "transverse", "rotational")


def dispersion_map(one: Input, ax: Any = None) -> Any:
    """S(k, omega) of a table of `sonopack spectrum dispersion --profile', one panel for each polarization."""
    words = one.table["polarization"] if "polarization" in one.table else np.array([])
    k, omega, s = (one.column(name,
                              "a map needs k, omega and S, as `sonopack spectrum dispersion --profile' prints them")
                   for name in ("k", "omega", "S"))
    found = [word for word in _BRANCHES if word in words]
    if not found or not np.any(s > 0):
        raise refuse(one.name, "nothing to draw: no S above 0 of a longitudinal, transverse or rotational wave")
    grids = [_grid(one, k[words == word], omega[words == word], s[words == word]) for word in found]
    columns = len(found)
    axes = panels(1, columns, ax=ax, aspect=0.8 if columns == 1 else 1.3, width=WIDTH if columns == 1 else 7.0)
    most = max(float(grid.max()) for _, _, grid in grids)
    for panel, word, (x, y, grid) in zip(axes[0], found, grids):
        cells = _map(panel, x, y, grid, most)
        panel.set_title(word)
        panel.set_xlabel(label("$k$", one.table.units["k"]))
    axes[0, 0].set_ylabel(label(r"$\omega$", one.table.units["omega"]))
    for panel in axes[0, 1:]:
        panel.set_yticklabels([])
        panel.set_ylim(axes[0, 0].get_ylim())
    _bar(axes, cells, label(r"$S(k, \omega)$", one.table.units["S"]))
    return axes[0, 0] if columns == 1 else axes[0]


def _grid(one: Input, k: Floats, omega: Floats, s: Floats) -> tuple[Floats, Floats, Floats]:
    """Wave numbers, frequencies, and S [omega][k]."""
    x, at_x = np.unique(k, return_inverse=True)
    y, at_y = np.unique(omega, return_inverse=True)
    grid = np.full((len(y), len(x)), np.nan)
    grid[at_y, at_x] = s
    if len(y) < 2 or not np.all(np.isfinite(grid)):
        raise refuse(one.name, "S must be a finite number for each pair of k and omega")
    return x, y, grid


# ---- local moduli ---------------------------------------------------------------------------------------------------

@figure
def local(given: Sequence[Input], *, ax: Any = None) -> Any:
    """The shear moduli of the parts of a packing in two dimensions, from a table of `sonopack moduli --probe local:W'."""
    one = given[0]
    why = "a map needs x, y and G of a packing in two dimensions, as `sonopack moduli --probe local:W' prints them"
    x, y, shear = (one.column(name, why) for name in ("x", "y", "G"))
    if "z" in one.table:
        raise refuse(one.name, why)
    rows = len(np.unique(y))
    columns = len(x) // rows
    if rows * columns != len(x) or not np.all(np.isfinite(shear)):
        raise refuse(one.name, "G must be a finite number for each part")
    edges = np.array([one.table.number("edge_x"), one.table.number("edge_y")])
    lean = x[columns] - x[0] if rows > 1 else 0.0  # of the parts of a tilted cell
    i, j = np.arange(columns + 1), np.arange(rows + 1)[:, None]
    axes = panels(1, 1, ax=ax, aspect=0.85)
    cells = axes[0, 0].pcolormesh(x[0] + (i - 0.5) * edges[0] + (j - 0.5) * lean, y[0] + (j - 0.5) * edges[1] + 0 * i,
                                  shear.reshape(rows, columns), rasterized=True)
    axes[0, 0].set(aspect="equal", xlabel=label("$x$", one.table.units["x"]), ylabel=label("$y$", one.table.units["y"]))
    axes[0, 0].figure.colorbar(cells, ax=axes[0, 0], pad=0.02).set_label(label("$G$", one.table.units["G"]), fontsize=7)
    return axes[0, 0]


# ---- signals --------------------------------------------------------------------------------------------------------

PANELS_MOST = 6


@figure
def spectrogram(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Any:
    """The spectral density of a signal over time and frequency, with the ridge of the largest density. data: a signal,
    a table of signals, or a packing, whose signal is computed with the keys of `scene`. Windows of Hann, an eighth of
    the signal long; several detectors have a panel each."""
    one, traces = given[0], traces_of(given[0], scene)
    if len(traces) > PANELS_MOST:
        raise refuse(one.name, f"{len(traces)} signals: a figure shows 1 to {PANELS_MOST}")
    found = [_spectrum(one, trace) for trace in traces]
    axes = panels(len(traces), 1, ax=ax, aspect=0.85 if len(traces) == 1 else 0.55)[:, 0]
    most = max(float(power.max()) for _, _, power in found)
    top = max(int(1.1 * np.flatnonzero(power.max(axis=1) > most * 10**-DECADES)[-1]) + 3 for _, _, power in found)
    for panel, trace, (omega, t, power) in zip(axes, traces, found):
        cells = _map(panel, t, omega[:top], power[:top], most)
        panel.set_ylabel(label(r"$\omega$", _frequency_unit(trace)))
        if trace.place and len(traces) > 1:
            panel.set_title(trace.place, fontsize=7)
    axes[-1].set_xlabel(label("$t$", traces[0].t_unit))
    unit = _density_unit(traces[0])
    _bar(axes, cells, rf"spectral density of $F$  [{unit}]" if unit else "spectral density of $F$")
    return axes[0] if len(axes) == 1 else axes


def _spectrum(one: Input, trace: Trace) -> tuple[Floats, Floats, Floats]:
    """Circular frequencies, times, and spectral densities [omega][t] of F."""
    import scipy.signal
    t, f = trace.t, trace.f
    step = np.diff(t)
    if len(t) < 64:
        raise refuse(one.name, f"{len(t)} times: a spectrogram needs 64 or more")
    if not np.all(np.isfinite(f)) or not np.allclose(step, step.mean(), rtol=1e-3):
        raise refuse(one.name, "a spectrogram needs finite values at equally spaced times")
    if not np.ptp(f) > 0:
        raise refuse(one.name, "nothing to draw: the signal is constant")
    size = float(np.abs(f).max())
    if not 1e-150 < size < 1e150:
        raise refuse(one.name, f"the largest value of the signal is {size:g}: its square must be a number, within 1e-150 "
                               "to 1e150")
    length = max(16, len(t) // 8)
    frequency, times, power = scipy.signal.spectrogram(
        f, 1 / step.mean(), window="hann", nperseg=length, noverlap=length - max(1, length // 16), nfft=4 * length,
        detrend="constant")
    scale = _turns(trace)
    keep = frequency > 0
    return scale * frequency[keep], t[0] + times, power[keep] / scale


def _turns(trace: Trace) -> float:
    """From one over the unit of times to the unit of circular frequencies."""
    return 2 * np.pi * {"us": 1e6, "ms": 1e3}.get(trace.t_unit, 1.0)


def _frequency_unit(trace: Trace) -> str:
    if same_unit(trace.t_unit, TIME):
        return FREQUENCY
    return "rad/s" if trace.t_unit in ("us", "ms", "s") else ""


def _density_unit(trace: Trace) -> str:
    """Of a squared force over a circular frequency."""
    force = {"E* d^2": r"$E^{*2}d^4$"}.get(trace.f_unit, f"{unit_text(trace.f_unit)}$^2$" if trace.f_unit else "")
    over = unit_text(TIME) if same_unit(trace.t_unit, TIME) else "s" if _frequency_unit(trace) else ""
    return rf"{force}$\,${over}" if force and over else ""
