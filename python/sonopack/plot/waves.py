"""Figures of tables against frequency, wave number and amplitude: coherent waves, transport of energy, loud fronts;
and of paths of strain."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._core import Floats
from ._frame import column_of_panels, dash, figure, ink, key, legend, mark, points, sets
from ._inputs import Group, Input, common_dimension, common_unit, groups_of, names
from ._units import FREQUENCY, LENGTH, SPEED, WAVE, label, number, refuse, same_unit


def _positive(values: Floats) -> Floats:
    """nan where a logarithmic axis can show nothing."""
    return np.where(np.isfinite(values) & (values > 0), values, np.nan)


def _finish(axes: Any, x: Floats, x_label: str, y_labels: Sequence[str]) -> Any:
    """Labels, and one logarithmic range for all panels."""
    for ax, text in zip(axes, y_labels):
        ax.set(xscale="log", xlim=(0.8 * np.nanmin(x), 1.25 * np.nanmax(x)), xlabel=x_label, ylabel=text)
        legend(ax)
    return axes


@figure
def wave(given: Sequence[Input], *, ax: Any = None) -> Any:
    """Phase speed and attenuation of coherent waves against the wave number, from tables of `sonopack wave`, with
    Rayleigh's alpha = a k^(dimension + 1) through the points with alpha below k/10. Returns two Axes."""
    hint = "one of `sonopack wave' has omega, k, speed and alpha"
    read = [tuple(one.column(name, hint) for name in ("k", "speed", "alpha")) for one in given]
    if not any(np.any(_positive(k) > 0) for k, _, _ in read):
        raise refuse(given[0].name, "nothing to draw: no row has a wave number")
    axes = column_of_panels(2, ax, 0.62)
    lines = []
    for j, (one, name, (k, speed, alpha)) in enumerate(zip(given, names(given), read)):
        known = one.errors("alpha")
        error = np.zeros(len(k)) if known is None else known
        k, alpha = _positive(k), np.where(alpha < error, np.nan, _positive(alpha))
        points(axes[0], k, speed, one.errors("speed"), label=name or None, **sets(j))
        points(axes[1], k, alpha, error, **sets(j))
        lines.append((k, alpha, error))
    axes[1].set_yscale("log")
    unit, (k, alpha, error) = common_unit(given, "k", WAVE), (np.concatenate(parts) for parts in zip(*lines))
    _rayleigh(axes[1], k, alpha, error, common_dimension(given) + 1, same_unit(unit, WAVE))
    return _finish(axes, k, label("$k$", unit), [label(r"$\omega/k$", common_unit(given, "speed", SPEED)),
                                                 label(r"$\alpha$", common_unit(given, "alpha", WAVE))])


def _rayleigh(ax: Axes, k: Floats, alpha: Floats, error: Floats, power: int, ours: bool) -> None:
    """The law through the long waves, whose mean free path exceeds 10/k; each point weighs by its error."""
    with np.errstate(invalid="ignore", divide="ignore"):
        there = (alpha > 0) & (alpha <= 0.1 * k) & ~(alpha < 3 * error)
    if power < 2 or there.sum() < 3 or not np.ptp(k[there]) > 0:
        return
    weights = np.where(error[there] > 0, (alpha[there] / np.maximum(error[there], 1e-300))**2, 1)
    factor = np.exp(np.average(np.log(alpha[there] / k[there]**power), weights=weights))
    ends = np.array([0.8 * k[there].min(), 2 * k[there].max()])
    text = f"{number(factor, 2)} $d^{{{power - 1}}}\\,k^{{{power}}}$" if ours else rf"$\sim\,k^{{{power}}}$"
    ax.plot(ends, factor * ends**power, color="black", ls=dash(1), lw=0.8, label=text)


@figure
def transport(given: Sequence[Input], *, ax: Any = None) -> Any:
    """Diffusivity and mean free path against frequency with their errors, from tables of `sonopack transport`. Returns an
    Axes for each of the columns D and path that any table has."""
    shown = [row for row in (("D", "$D$", "d sqrt(E* / rho)"), ("path", "mean free path", LENGTH))
             if any(_has_errors(one, row[0]) for one in given)]
    frequencies = [_positive(one.column("omega", "one of `sonopack transport' has omega and D or path")) for one in given]
    if not shown:
        raise refuse(given[0].name, "nothing to draw: no table has a D or a path with its error")
    axes = column_of_panels(len(shown), ax, 0.62)
    for ax, (column, _, _) in zip(axes, shown):
        ax.set_yscale("log")
        for j, (one, name, omega) in enumerate(zip(given, names(given), frequencies)):
            if _has_errors(one, column):
                points(ax, omega, _positive(one.column(column)), one.errors(column), label=name or None, **sets(j))
    return _finish(axes, np.concatenate(frequencies), label(r"$\omega$", common_unit(given, "omega", FREQUENCY)),
                   [label(symbol, common_unit(given, column, own)) for column, symbol, own in shown])


def _has_errors(one: Input, column: str) -> bool:
    values = one.optional(column)
    return values is not None and one.errors(column) is not None and bool(np.any(_positive(values) > 0))


# ---- amplitudes -----------------------------------------------------------------------------------------------------

KEYS = {"dimension": "dimensions = {}", "friction": r"$\mu$ = {}", "p": "$p$ = {}{}", "amplitude": "$A$ = {}"}
FRONTS = ("amplitude", "speed_ratio", "speed_ratio_err", "slid", "opened", "carrying")
BURSTS = ("y", "ratio", "ratio_err")
STRESSES = ("s_xx", "s_yy", "s_zz", "s_yz", "s_xz", "s_xy")
GROUPS_MOST = 18


@figure
def amplitude(given: Sequence[Input], *, ax: Any = None) -> Any:
    """Speed over its linear limit, and the shares of contacts that opened and slid, against amplitude, from tables of
    `sonopack amplitude`: two Axes. Of bursts at planes F2/F1^2 against the height: one."""
    shown = FRONTS if _has_all(given[0], FRONTS) else BURSTS
    wrong = next((j for j, one in enumerate(given) if not _has_all(one, shown)), None)
    if wrong is not None:
        raise refuse(given[wrong].name, f"table {wrong + 1}: must be of `sonopack amplitude', with fronts (amplitude, "
                                        f"speed_ratio) or with bursts at planes (y, ratio), all of one kind")
    groups = groups_of(given, lambda one: ({name: one.column(name) for name in shown},
                                           [name for name in KEYS if name not in shown]), shown[0], KEYS)
    if len(groups) > GROUPS_MOST:
        raise refuse(given[0].name, f"more than {GROUPS_MOST} curves: draw fewer rows, or means (--mean)")
    return _fronts(groups, ax) if shown is FRONTS else _bursts(given, groups, ax)


@figure
def path(given: Sequence[Input], *, ax: Any = None) -> Any:
    """Stresses, and the change of the volume, along paths of strain, from tables of `sonopack pack`: two Axes. The strain is
    the largest component of the path's, compression positive."""
    axes = column_of_panels(2, ax, 0.62)
    unit, shown = common_unit(given, "s_xx"), ["s_xx"]
    for j, (one, name) in enumerate(zip(given, names(given))):
        if "path_strain" not in one.table.metadata:
            raise refuse(one.name, "not of a path of strain: `sonopack pack' with packing.path.strain prints one")
        strain = one.column("strain")
        stress = {c: one.column(c) for c in STRESSES if c in one.table}
        largest = max(np.abs(values).max() for values in stress.values())
        shown = [c for c in STRESSES if c in shown or np.abs(stress.get(c, np.zeros(1))).max() > 1e-4 * largest]
        for c in shown:
            axes[0].plot(strain, stress[c], color=ink(STRESSES.index(c)), ls=dash(j))
        volume = one.column("volume")
        axes[1].plot(strain, volume / volume[0] - 1, color="black", ls=dash(j), label=name or None)
    axes[0].set(xlabel="strain", ylabel=label("stress", unit))
    axes[1].set(xlabel="strain", ylabel="change of the volume")
    legend(axes[0], [key(color=ink(STRESSES.index(c)), label=rf"$\sigma_{{{c[2:]}}}$") for c in shown])
    if len(given) > 1:
        legend(axes[1])
    return axes


def _has_all(one: Input, columns: Sequence[str]) -> bool:
    return all(name in one.table and one.table[name].dtype.kind in "fiu" for name in columns)


def _style(groups: Sequence[Group], group: Group, colour_key: str) -> dict[str, Any]:
    """Pressures (of bursts amplitudes) have colours, frictions marks, so that curves of both can be told apart. Packings of one
    pressure and friction have colours."""
    if len({(each.keys.get(colour_key), each.keys.get("friction")) for each in groups}) < len(groups):
        j = next(j for j, each in enumerate(groups) if each is group)
        return {"color": ink(j + 1), "marker": mark(j % 4), "ls": "-"}

    def rank(name: str) -> int:
        return list(dict.fromkeys(each.keys.get(name) for each in groups)).index(group.keys.get(name))
    which = rank("friction")
    return {"color": ink(rank(colour_key) + 1), "marker": mark(which % 4), "hollow": which % 2 == 1, "ls": "-"}


def _fronts(groups: Sequence[Group], ax: Any) -> Any:
    axes = column_of_panels(2, ax, 0.68)
    slid = False
    for group in groups:
        c, style = group.columns, _style(groups, group, "p")
        points(axes[0], c["amplitude"], c["speed_ratio"], c["speed_ratio_err"], label=group.text or None, **style)
        points(axes[1], c["amplitude"], c["opened"] / c["carrying"], **style)
        if np.any(c["slid"] > 0):
            slid = True
            axes[1].plot(c["amplitude"], c["slid"] / c["carrying"], color=style["color"], ls=dash(1))
    for one, text in zip(axes, ("speed over its linear limit", "share of the contacts")):
        one.set(xscale="log", xlabel="amplitude $A$", ylabel=text)
    legend(axes[0])
    legend(axes[1], [key(color="black", marker="o", label="opened")]
           + ([key(color="black", ls=dash(1), label="slid")] if slid else []))
    return axes


def _bursts(given: Sequence[Input], groups: Sequence[Group], ax: Any) -> Axes:
    one: Axes = column_of_panels(1, ax, 0.75)[0]
    for group in groups:
        points(one, *(group.columns[name] for name in BURSTS), label=group.text or None,
               **_style(groups, group, "amplitude"))
    one.set(xlabel=label("height $y$", common_unit(given, "y", LENGTH)), ylabel="$F_2/F_1^2$")
    legend(one)
    return one
