"""Figures of coherent waves and of the transport of energy, against wave number and frequency."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from .._core import Floats
from .._records import Material
from ._frame import dash, ink, legend, mark, panels, points, styled, tag
from ._inputs import Input, common_dimension, common_unit, inputs, names
from ._units import FREQUENCY, LENGTH, SPEED, WAVE, label, number, refuse, same_unit


def _positive(values: Floats) -> Floats:
    """nan where a logarithmic axis can show nothing."""
    return np.where(np.isfinite(values) & (values > 0), values, np.nan)


def _shared_range(axes: Sequence[Axes], values: Floats) -> None:
    for ax in axes:
        ax.set_xscale("log")
        ax.set_xlim(0.8 * np.nanmin(values), 1.25 * np.nanmax(values))


@styled
def wave(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None,
         ax: Any = None) -> npt.NDArray[Any]:
    """Phase speed and attenuation of coherent waves against the wave number, from tables of `sonopack wave`, with
    Rayleigh's alpha = a k^(dimension + 1) through the points with alpha below k/10. Returns two Axes."""
    given = inputs(data, labels, material)
    hint = "one of `sonopack wave' has omega, k, speed and alpha"
    read = [tuple(one.column(name, hint) for name in ("k", "speed", "alpha")) for one in given]
    if not any(np.any(_positive(k) > 0) for k, _, _ in read):
        raise refuse(given[0].name, "nothing to draw: no row has a wave number")
    axes = panels(2, 1, ax=ax, aspect=0.62)[:, 0]
    lines = []
    for j, (one, name, (k, speed, alpha)) in enumerate(zip(given, names(given), read)):
        error = one.errors("alpha")
        error = np.zeros(len(k)) if error is None else error
        k, alpha = _positive(k), np.where(alpha < error, np.nan, _positive(alpha))
        style = {"marker": mark(j % 4), "color": ink(j + 1), "hollow": j >= 4}
        points(axes[0], k, speed, one.errors("speed"), label=name or None, **style)
        points(axes[1], k, alpha, error, **style)
        lines.append((k, alpha, error))
    axes[1].set_yscale("log")
    _shared_range(axes, np.concatenate([k for k, _, _ in lines]))
    _rayleigh(axes[1], lines, common_dimension(given) + 1, same_unit(common_unit(given, "k", WAVE), WAVE))
    for ax, letter, (column, symbol, own) in zip(axes, "ab", (("speed", r"$\omega/k$", SPEED),
                                                              ("alpha", r"$\alpha$", WAVE))):
        tag(ax, f"({letter})")
        ax.set_xlabel(label("$k$", common_unit(given, "k", WAVE)))
        ax.set_ylabel(label(symbol, common_unit(given, column, own)))
        legend(ax)
    return axes


def _rayleigh(ax: Axes, lines: Sequence[tuple[Floats, Floats, Floats]], power: int, ours: bool) -> None:
    """The law through the long waves, whose mean free path exceeds 10/k; each point weighs by its error."""
    k, alpha, error = (np.concatenate(parts) for parts in zip(*lines))
    with np.errstate(invalid="ignore", divide="ignore"):
        there = (alpha > 0) & (alpha <= 0.1 * k) & ~(alpha < 3 * error)
    if power < 2 or there.sum() < 3 or not np.ptp(k[there]) > 0:
        return
    weights = np.where(error[there] > 0, (alpha[there] / np.maximum(error[there], 1e-300))**2, 1)
    factor = np.exp(np.average(np.log(alpha[there] / k[there]**power), weights=weights))
    ends = np.array([0.8 * k[there].min(), 2 * k[there].max()])
    text = f"{number(factor, 2)} $d^{{{power - 1}}}\\,k^{{{power}}}$" if ours else rf"$\sim\,k^{{{power}}}$"
    ax.plot(ends, factor * ends**power, color="black", ls=dash(1), lw=0.8, label=text)


@styled
def transport(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None,
              ax: Any = None) -> npt.NDArray[Any]:
    """Diffusivity and mean free path against frequency with their errors, from tables of `sonopack transport`. Returns an
    Axes for each of the columns D and path that any table has."""
    given = inputs(data, labels, material)
    shown = [(column, symbol, own) for column, symbol, own in (("D", "$D$", "d sqrt(E* / rho)"),
                                                               ("path", "mean free path", LENGTH))
             if any(_has(one, column) for one in given)]
    frequencies = [_positive(one.column("omega", "one of `sonopack transport' has omega and D or path")) for one in given]
    if not shown:
        raise refuse(given[0].name, "nothing to draw: no table has a D or a path with its error")
    axes = panels(len(shown), 1, ax=ax, aspect=0.62)[:, 0]
    for ax, (column, symbol, own), letter in zip(axes, shown, "ab"):
        for j, (one, name, omega) in enumerate(zip(given, names(given), frequencies)):
            if _has(one, column):
                points(ax, omega, _positive(one.column(column)), one.errors(column), label=name or None,
                       marker=mark(j % 4), color=ink(j + 1), hollow=j >= 4)
        ax.set_yscale("log")
        ax.set_xlabel(label(r"$\omega$", common_unit(given, "omega", FREQUENCY)))
        ax.set_ylabel(label(symbol, common_unit(given, column, own)))
        if len(shown) > 1:
            tag(ax, f"({letter})")
    _shared_range(axes, np.concatenate(frequencies))
    for ax in axes:
        legend(ax)
    return axes


def _has(one: Input, column: str) -> bool:
    values = one.optional(column)
    return values is not None and one.errors(column) is not None and bool(np.any(_positive(values) > 0))
