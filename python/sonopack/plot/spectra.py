"""Figures of spectra: density of states, response, participation, modes, dispersion."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._command import usage
from .._core import Floats
from .._scene import Scene
from .._table import Table
from ._frame import GREY, column_of_panels, dash, figure, ink, inset, key, legend, mark, panels
from ._inputs import Input, common_unit, names, network_of
from ._units import FORCE, FREQUENCY, SPEED, TIME, WAVE, inverse, label, number, refuse, square, unit_text, worded

RESPONSE = "E* d^3/sqrt(E* / rho)"
POLARIZATIONS = ("longitudinal", "transverse", "rotational")


@dataclasses.dataclass(frozen=True)
class Style:
    """How a kind of table is drawn: the column and its error, label and unit of the y axis, with lines, points or bins."""

    y: str
    error: str
    symbol: str
    unit: str
    log: bool = False
    marks: bool = False
    line: bool = True


DENSITY = r"$g(\omega)$"
STYLES = {
    "dos": Style("smooth", "smooth_err", DENSITY, TIME),
    "ensemble": Style("density", "", DENSITY, TIME),
    "transmission": Style("magnitude", "", r"|$F(\omega)$|", RESPONSE, log=True),
    "harmonic": Style("magnitude", "", r"|$F(\omega)$|", RESPONSE, log=True, marks=True),
    "participation": Style("participation", "sd", "participation ratio", "", marks=True, line=False),
    "modes": Style("", "", DENSITY, TIME)}
RESPONSES = {"alpha": Style("alpha", "alpha_err", r"$\alpha$", WAVE, marks=True),
             "k": Style("k", "k_err", "$k$", WAVE, marks=True),
             "speed": Style("speed", "speed_err", "speed", SPEED, marks=True)}


# ---- spectra --------------------------------------------------------------------------------------------------------

@figure
def spectrum(given: Sequence[Input], *, ax: Axes | None = None, scene: Scene | None = None,
             column: str | None = None) -> Axes:
    """Tables of `sonopack spectrum` dos, transmission, harmonic or participation, of `sonopack modes` or `table spectrum`
    against frequency, all of one kind; of packings the density of states. column: alpha, k or speed of a response."""
    if column and column not in RESPONSES:
        raise usage(f"--column {column:.60}: must be alpha, k or speed")
    for one in given:
        if one.is_packing:
            one.raw_table = _dos_table(one, scene)
    kinds = [_kind_of(one) for one in given]
    if len(set(kinds)) > 1:
        other = next(kind for kind in kinds if kind != kinds[0])
        raise refuse(given[0].name, f"tables of {kinds[0]} and of {other} in one figure, must be of one kind")
    kind = kinds[0]
    if column and kind != "harmonic":
        raise refuse(given[0].name, f"column {column} of a table of {kind}: must be of `sonopack spectrum harmonic'")
    style = RESPONSES[column] if column else STYLES[kind]
    ax = panels(ax=ax, aspect=0.72)[0, 0]
    draw = _histogram if kind == "modes" else _bins if kind == "ensemble" else _curve
    grains = all(one.number("carrying") > 0 for one in given)
    for j, (one, name) in enumerate(zip(given, names(given))):
        draw(ax, one, j, name, style, grains=grains, alone=len(given) == 1)
    _finish(ax, given, style, kind, grains)
    return ax


def _kind_of(one: Input) -> str:
    kind = one.table.metadata.get("spectrum", "")
    if not kind and {"omega", "n"} <= set(one.table):
        kind = "modes"
    if not kind and "density_low" in one.table:  # CSV files have no comments
        kind = "ensemble"
    if kind not in STYLES:
        raise refuse(one.name, "no table to draw here: must be of `sonopack spectrum' dos, transmission, harmonic or "
                               "participation, of `sonopack modes', or of `sonopack table spectrum'")
    return kind


def _dos_table(one: Input, scene: Scene | None) -> Table:
    """What `sonopack spectrum dos` prints of a packing, as far as it is drawn."""
    dos = network_of(one.packing, scene).dos()
    edge = np.asarray(dos.edge)
    columns = {"omega": dos.omega, "low": edge[:-1], "high": edge[1:], "density": dos.density, "smooth": dos.smooth,
               "smooth_err": dos.smooth_error}
    units = {name: FREQUENCY if name in ("omega", "low", "high") else TIME for name in columns}
    return Table.from_columns(columns, units, {"spectrum": "dos", "norm": "grain"})


_HINT = "must be from `sonopack spectrum' without --lines and --profile"


def _curve(ax: Axes, one: Input, j: int, name: str, style: Style, *, grains: bool, alone: bool) -> None:
    omega, value = one.column("omega", _HINT), one.column(style.y, _HINT)
    if alone and style.y == "smooth" and {"low", "high", "density"} <= set(one.table):
        ax.stairs(one.column("density"), np.r_[one.column("low"), one.column("high")[-1]], color=GREY, lw=0.7,
                  label="modes in bins")
        name = name or "smoothed"
    if style.log:
        value = np.where(value > 0, value, np.nan)
    if not np.any(np.isfinite(omega) & np.isfinite(value)):
        raise refuse(one.name, "nothing to draw: no row has a frequency and a value")
    words = {"color": ink(j + 1), "label": name or None, "ls": dash(j) if style.line else "none",
             "lw": 0.6 if style.marks else 0.9}
    error = one.optional(style.error) if style.error else None
    if error is None or not np.nanmax(error, initial=0) > 1e-4 * np.nanmax(np.abs(value)):
        # smaller ones, as of rounding, would be caps without bars
        ax.plot(omega, value, marker=mark(j % 4) if style.marks else "", **words)
        return
    low, high = _ends(one, value, error)
    ax.errorbar(omega, value, yerr=[value - low, high - value], elinewidth=0.7, marker=mark(j % 4) if style.marks else "",
                **words)


def _ends(one: Input, value: Floats, error: Floats) -> tuple[Floats, Floats]:
    """One error from the value, but no farther than the least and the greatest value where the table has them."""
    error = np.where(error > 0, error, 0)
    least, most = one.optional("min"), one.optional("max")
    low = value - error if least is None else np.minimum(np.maximum(value - error, least), value)
    high = value + error if most is None else np.maximum(np.minimum(value + error, most), value)
    return low, high


def _bins(ax: Axes, one: Input, j: int, name: str, style: Style, *, grains: bool, alone: bool) -> None:
    """Means over samples as steps, and their intervals as a band; densities are not negative."""
    low, high, mean, least, most = (one.column(column, _HINT) for column in ("low", "high", "density", "density_low",
                                                                             "density_high"))
    x = np.column_stack([low, high]).ravel()
    ax.fill_between(x, np.repeat(np.maximum(least, 0), 2), np.repeat(most, 2), color=ink(j + 1), alpha=0.25, lw=0)
    level = one.number("interval_level")
    text = f"mean, {number(100 * level)}% interval" if 0 < level < 1 else "mean, interval"
    ax.plot(x, np.repeat(mean, 2), color=ink(j + 1), ls=dash(j), lw=0.9, label=name or text)
    ax._sonopack_band = text


def _histogram(ax: Axes, one: Input, j: int, name: str, style: Style, *, grains: bool, alone: bool) -> None:
    """Modes of each grain and unit of frequency; without the number of grains, modes of each unit of frequency."""
    omega = one.column("omega", _HINT)
    low, high = _complete_range(one, omega)
    inside = omega[(omega > max(one.number("zero_below"), 0) if one.number("zero_below") > 0 else omega > 0)
                   & (omega >= low) & (omega <= high)]
    if not len(inside):
        raise refuse(one.name, "nothing to draw: no frequency above 0")
    bins = int(min(60, max(5, math.sqrt(len(inside)))))
    counts, edges = np.histogram(inside, bins, (low, high))
    density = counts / ((high - low) / bins * (one.number("carrying") if grains else 1))
    ax.stairs(density, edges, color=ink(j + 1), ls=dash(j), lw=0.9, label=name or f"{len(inside)} modes in bins")


def _complete_range(one: Input, omega: Floats) -> tuple[float, float]:
    """Frequencies between which no mode is missing: the comment "complete = low:high"; without it, up to the highest."""
    low, colon, high = one.table.metadata.get("complete", "").partition(":")
    last = float(np.nanmax(omega, initial=0))
    try:
        ends = (max(float(low), 0.0), float(high.split()[0])) if colon else (0.0, last)
    except (ValueError, IndexError):
        return 0.0, last
    return ends[0], ends[1] if math.isfinite(ends[1]) else last


def _finish(ax: Axes, given: Sequence[Input], style: Style, kind: str, grains: bool) -> None:
    norms = {norm for one in given if (norm := one.table.metadata.get("norm"))}
    if len(norms) > 1:
        raise refuse(given[0].name, f"tables of the norms {' and '.join(sorted(norms))}: must be the same")
    if kind == "modes":
        text = inverse(common_unit(given, "omega", FREQUENCY))
        text = f"{text}/grain" if grains else f"modes {text}"
    else:
        text = unit_text(common_unit(given, style.y, style.unit)) + ("/grain" if norms == {"grain"} else "")
    ax.set_xlabel(label(r"$\omega$", common_unit(given, "omega", FREQUENCY)))
    ax.set_ylabel(worded(style.symbol, text))
    if style.log:
        ax.set_yscale("log")
    elif ax.dataLim.y0 >= 0:
        ax.set_ylim(bottom=0)
    if ax.dataLim.x0 >= 0:
        ax.set_xlim(left=0)
    band = getattr(ax, "_sonopack_band", "")
    entries = ax.get_legend_handles_labels()[0]
    legend(ax, entries + [key(color="black", lw=0.9, label=band)] if band and entries[0].get_label() != band else None)


# ---- dispersion -----------------------------------------------------------------------------------------------------

@figure
def dispersion(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Any:
    """Peak frequencies of the spectral functions against the wave number with their half widths as bars, from one or two
    tables of `sonopack spectrum dispersion`, or packings. A wave that is damped out within a period, whose half width
    exceeds its frequency, is drawn faint. A table of --profile is drawn as a map of S(k, omega)."""
    if len(given) > 2:
        raise refuse(given[0].name, f"{len(given)} tables of waves: a figure shows 1 or 2")
    for one in given:
        if one.is_packing:
            one.raw_table = _dispersion_table(one, scene)
        if "polarization" not in one.table or one.table["polarization"].dtype.kind != "U":
            raise refuse(one.name, "the table has no words in a column polarization; must be one of `sonopack spectrum "
                                   "dispersion'")
    if "S" in given[0].table:
        if len(given) > 1:
            raise usage("plot dispersion: two tables, must be one table of S(k, omega), or tables without --profile")
        from .maps import dispersion_map
        return dispersion_map(given[0], ax)
    ax = panels(ax=ax, aspect=0.78)[0, 0]
    entries = _waves(ax, given)
    ax.margins(x=0.04)
    two = [(name, j) for j, name in enumerate(names(given)) if name]
    entries += [key(marker="o", color="black", mfc="white" if j else "black", ls="none", label=name) for name, j in two]
    ax.set(xlim=(0, None), ylim=(0, None), xlabel=label("$k$", common_unit(given, "k", WAVE)),
           ylabel=label(r"$\omega$", common_unit(given, "peak", FREQUENCY)))
    legend(ax, entries)
    return ax


def _dispersion_table(one: Input, scene: Scene | None) -> Table:
    """What `sonopack spectrum dispersion` prints of a packing, as far as it is drawn."""
    found = network_of(one.packing, scene).dispersion()
    wave = found.wave
    columns: dict[str, Any] = {"polarization": np.array([found.polarization(row) for row in range(found.n)])}
    columns |= {name: wave[name] for name in ("k", "peak", "half_width")}
    units = {"k": WAVE, "peak": FREQUENCY, "half_width": FREQUENCY}
    return Table.from_columns(columns, units, {"spectrum": "dispersion"})


def _waves(ax: Axes, given: Sequence[Input]) -> list[Any]:
    """The legend names the polarizations; the marks of the second table are hollow."""
    entries = []
    for j, one in enumerate(given):
        k, peak, width = one.column("k", _HINT), one.column("peak", _HINT), one.not_negative("half_width")
        one.not_negative("peak")
        for q, word in enumerate(POLARIZATIONS):
            mine = (one.table["polarization"] == word) & np.isfinite(k) & np.isfinite(peak)
            if not mine.any():
                continue
            x, y = k[mine], peak[mine]
            half = np.zeros(len(x)) if width is None else np.nan_to_num(width[mine])
            for faint in (False, True):
                some = (half >= y) == faint
                ax.errorbar(x[some], y[some], yerr=[np.minimum(half[some], y[some]), half[some]], ls="none",
                            marker=mark(q), color=ink(q + 1), mfc="white" if j else None, elinewidth=0.7,
                            alpha=0.35 if faint else 1)
            entries += [key(marker=mark(q), color=ink(q + 1), ls="none", label=word)] if j == 0 else []
    if not entries:
        raise refuse(given[0].name, "nothing to draw: no row has a wave number and a peak")
    return entries


# ---- modes ----------------------------------------------------------------------------------------------------------

FEW = 60  # so many rows have marks instead of a line


@figure
def modes(given: Sequence[Input], *, ax: Any = None) -> Any:
    """Squared frequency and weight a b of each mode, from tables of `sonopack modes`. Returns two Axes, or one where no
    mode has a weight."""
    hint = "a table of modes has n, omega, a, b, ab"
    read = [(one.column("n", hint), one.column("omega", hint), one.optional("ab")) for one in given]
    empty = next((one for one in given if one.table.rows == 0), None)
    if empty:
        raise refuse(empty.name, "nothing to draw: the table of modes has no row")
    weighted = any(ab is not None and np.any(np.isfinite(ab)) for _, _, ab in read)
    axes = column_of_panels(2 if weighted else 1, ax, 0.66)
    for j, ((n, omega, ab), name) in enumerate(zip(read, names(given))):
        few = len(n) <= FEW
        style = {"color": ink(j + 1), "ls": "none" if few else dash(j), "marker": mark(j % 4) if few else ""}
        axes[0].plot(n, omega**2, lw=1.2, label=name or None, **style)
        if weighted and ab is not None:
            style["color"] = ink(0 if len(given) == 1 else j + 1)
            axes[1].plot(n, ab, lw=0.5, **style)
            if few:  # a line would hide what happens between the rows of a short table
                axes[1].vlines(n, 0, ab, color=style["color"], lw=0.5)
    axes[0].set_ylabel(worded(r"$\omega_n^2$", square(common_unit(given, "omega", FREQUENCY))))
    if weighted:
        axes[1].axhline(0, color="black", lw=0.4)
        axes[1].set_ylabel(label("$a_n b_n$", common_unit(given, "ab", FORCE)))
    for each in axes:
        each.set_xlabel("$n$")
    legend(axes[0])
    if len(given) == 1 and len(read[0][0]) > FEW:
        _first_modes(axes[0], *read[0][:2])
    return axes


def _first_modes(ax: Axes, n: Floats, omega: Floats) -> None:
    """An inset of the first modes that are not zero modes, and the last that are."""
    squares = omega**2
    first = int(np.argmax(squares > 1e-12 * np.nanmax(squares)))
    rows = slice(max(first - 3, 0), min(first + 25, len(n)))
    if rows.stop == len(n):
        return
    inner = inset(ax)
    inner.plot(n[rows], squares[rows], "o", color=ink(1), mfc="white", ms=2.2)
    inner.axhline(0, color="black", lw=0.4)
    inner.set(xlabel="$n$", ylabel=r"$\omega_n^2$")
