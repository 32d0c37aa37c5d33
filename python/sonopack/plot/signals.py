"""Figures of signals, their first fronts, and ensembles of signals."""
from __future__ import annotations

import dataclasses
import math
import re
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._core import Floats, SonopackError
from .._records import Front, Material
from .._scene import Scene
from .._signal import front, signal_window
from .._table import Table, material_of, quantity
from ._frame import MARKS_OF_FRONT, dash, figure, ink, key, legend, panels
from ._inputs import Input, common_unit, names, network_of
from ._units import FORCE, LENGTH, PRESSURE, TIME, label, plain, refuse, same_unit, to_si, unit_text, number

LEGEND_MOST = 10   # more signals are drawn one above the other
SECTION_MOST = 60  # as many are legible one above the other
FRONT_NAMES = {"t10": "$t_{10}$", "t_peak": r"$t_\mathrm{peak}$", "t_zero": r"$t_\mathrm{zero}$"}


@dataclasses.dataclass
class Trace:
    """One signal: times and forces, their units, and what is known of its place."""

    t: Floats
    f: Floats
    t_unit: str
    f_unit: str
    window: float              # the last time that the search of the first front uses; 0: unknown
    source: Input
    place: str = ""            # of the detector, as text of a legend
    distance: float = math.nan
    length_unit: str = LENGTH
    ours: bool = True          # in the units, or of the making, of this program

    def front(self) -> Front | None:
        """The first front, None where `sonopack front` finds none; the reason is a warning."""
        try:
            return front(self.t, self.f, window=self.window)
        except SonopackError as fault:
            name = ", ".join(filter(None, (self.source.name, self.place.replace("$", ""))))
            warnings.warn(f"{name + ': ' if name else ''}the first front is not marked: {fault}", stacklevel=2)
            return None


# ---- reading --------------------------------------------------------------------------------------------------------

def traces_of(source: Input, scene: Scene | None = None) -> list[Trace]:
    """The signals of a table with the columns t and F, or t, F1, F2, ..., or the signal of a packing, which is computed."""
    return [_computed(source, scene)] if source.is_packing else _columns(source)


def _computed(source: Input, scene: Scene | None) -> Trace:
    packing, height = source.packing, source.packing.height
    window = signal_window(height, packing.pressure)
    words: dict[str, Any] = {"until": window, **(scene.options("signal") if scene else {})}
    made = network_of(packing, scene).signal(**words)
    (time, t_unit), (force, f_unit), (length, length_unit) = (to_si(unit, source.material)
                                                              for unit in (TIME, FORCE, LENGTH))
    return Trace(made.t * time, made.F * force, t_unit, f_unit, window * time, source, distance=height * length,
                 length_unit=length_unit)


def _columns(source: Input) -> list[Trace]:
    table = source.table
    time, forces = _find_columns(source, table)
    window, material = _window(table, table.units[time])
    ours = same_unit(table.units[time], TIME)
    length_unit = LENGTH if ours else "mm" if material else ""
    found = []
    for name in forces:
        trace = Trace(table[time].astype(float), table[name].astype(float), table.units[time], table.units[name], window,
                      source, length_unit=length_unit, ours=ours)
        _place(trace, table, name, len(forces) > 1)
        found.append(trace)
    return found


def _find_columns(source: Input, table: Table) -> tuple[str, list[str]]:
    numbers = [name for name in table.names if table[name].dtype.kind in "fiu"]
    first = next((name for name in ("F", "F1") if name in table), "")
    time = "t" if "t" in table else ""
    if not time and not first and "omega" not in table and len(numbers) > 1:
        time, first = numbers[:2]
    if not time or not first or not {time, first} <= set(numbers):
        raise refuse(source.name, "a signal needs columns of numbers t and F, or t, F1, F2, ...: times and forces")
    several = [name for name in numbers if re.fullmatch(r"F[1-9]\d*", name)] if first == "F1" else [first]
    return time, several


def _window(table: Table, t_unit: str) -> tuple[float, Material | None]:
    """The window of the first front in the unit of the times, and the material of a table of ours in SI."""
    text = table.metadata.get("material")
    material = material_of(text) if text else None
    factor, si = to_si(TIME, material)
    if material is None or not same_unit(si, t_unit):
        material, factor = None, 1.0
    height, pressure = (_own_number(table, key, unit, material) for key, unit in (("height", LENGTH),
                                                                                  ("pressure", PRESSURE)))
    known = height > 0 and pressure > 0
    return (signal_window(height, pressure) * factor if known else 0.0), material


def _own_number(table: Table, name: str, unit: str, material: Material | None) -> float:
    """A number of the comments in our unit: in a table in SI its unit stands behind it."""
    text = table.metadata.get(name, "")
    try:
        return quantity(text, unit, material) if material else _positive(table, name)
    except SonopackError:
        return 0.0


def plane_of(place: str) -> float:
    """The height in "plane:25:normal", nan if the place is not a plane."""
    found = re.match(r"plane:([0-9.eE+-]+)", place)
    return float(found.group(1)) if found else math.nan


def detector_of(table: Table, column: str) -> tuple[str, float] | None:
    """The word of the detector of a column, and the height of the source: of a comment such as "F2 = from bottom to
    plane:25". None without it."""
    start, to, end = table.metadata.get(column, "").partition(" to ")
    if not to:
        return None
    source = plane_of(start.removeprefix("from "))
    return end.split(",")[0], 0.0 if math.isnan(source) else source


def way(table: Table, source: float, at: float) -> float:
    """The distance from the source to a height, the shorter way around in a periodic cell."""
    height, length = _positive(table, "height"), abs(at - source)
    return min(length, height - length) if table.metadata.get("cell") == "periodic" and height > length else length


def _positive(table: Table, name: str) -> float:
    try:
        return max(table.number(name), 0.0)
    except KeyError:
        return 0.0


def _place(trace: Trace, table: Table, column: str, several: bool) -> None:
    """Names a signal by its detector and finds its distance."""
    height, found = _positive(table, "height"), detector_of(table, column if several else "F1")
    trace.place = column if several else ""
    if found is None:
        trace.distance = height if height > 0 and not several else math.nan
        return
    word, source = found
    plane = plane_of(word)
    if math.isfinite(plane):
        trace.distance = way(table, source, plane)
    elif word.startswith("top") and height > 0:
        trace.distance = way(table, source, height)
    if several:
        axis = "z" if table.metadata.get("dimension") == "3" else "y"
        shear = ", shear" if word.endswith(":shear") else ""
        where = f"${axis}$ = {number(plane)} {unit_text(trace.length_unit)}".strip() + shear
        trace.place = where if math.isfinite(plane) else plain(word.removesuffix(":normal"))


# ---- signals --------------------------------------------------------------------------------------------------------

@figure
def signal(given: Sequence[Input], *, ax: Axes | None = None, scene: Scene | None = None) -> Axes:
    """F(t) of Signals, of tables with the columns t and F (or F1, F2, ...), or of packings, whose signal is computed with
    the keys of `scene`. A triangle marks 10 % of the first front's peak, a circle the peak, a square the zero crossing,
    where `sonopack front` finds it. More than ten signals are drawn one above the other, at their distances."""
    read = [traces_of(one, scene) for one in given]
    traces = [trace for each in read for trace in each]
    for attribute, symbol in (("t_unit", "t"), ("f_unit", "F")):
        _check_units(traces, attribute, symbol)
    if not any(np.any(np.isfinite(trace.t) & np.isfinite(trace.f)) for trace in traces):
        raise refuse(given[0].name, "nothing to draw: no finite point")
    if LEGEND_MOST < len(traces) <= SECTION_MOST:
        return _section(traces, ax)
    count = len(traces)
    ax = panels(ax=ax, aspect=0.66)[0, 0]
    for k, (trace, text) in enumerate(zip(traces, _texts(given, read))):
        ax.plot(trace.t, trace.f, color=ink(k if count == 1 else k + 1), ls=dash(k + k // 6), lw=0.9,
                label=text or None)
    _mark_fronts(ax, traces)
    ax.axhline(0, color="black", lw=0.4, zorder=0)
    ax.set(xlabel=label("$t$", _shared(traces, "t_unit")),
           ylabel=label(r"$F_\mathrm{sig}$" if all(t.ours for t in traces) else "$F$", _shared(traces, "f_unit")))
    _finish(ax, traces)
    return ax


def _finish(ax: Axes, traces: Sequence[Trace]) -> None:
    low, high = min(np.nanmin(t.t) for t in traces), max(np.nanmax(t.t) for t in traces)
    if low < high:
        ax.set_xlim(low, high)
    marks = [key(marker=mark, mfc="white", mec="black", ls="none", label=FRONT_NAMES[name])
             for name, mark in MARKS_OF_FRONT.items() if any(line.get_gid() == name for line in ax.lines)]
    entries = [line for line in ax.lines if not line.get_label().startswith("_")]
    if len(traces) > LEGEND_MOST:
        entries = [key(ls="none", label=f"{len(traces)} signals")]
    legend(ax, entries + marks)


def _texts(given: Sequence[Input], read: Sequence[Sequence[Trace]]) -> list[str]:
    """What tells signals apart: the data's names, and the detectors where a table has several."""
    own = names(given) if len(given) > 1 or given[0].own_label else [plain(given[0].stem()) if len(read[0]) == 1 else ""]
    return [", ".join(filter(None, (name, trace.place))) for name, each in zip(own, read) for trace in each]


def _mark_fronts(ax: Axes, traces: Sequence[Trace]) -> None:
    """The marks of the first fronts, where there is one; of many signals they would hide each other."""
    for k, trace in enumerate(traces):
        found = trace.front()
        for name, mark in MARKS_OF_FRONT.items() if found else ():
            time = getattr(found, name)
            if np.isfinite(time) and trace.t[0] <= time <= trace.t[-1]:
                size = 3.6 if len(traces) < 4 else 2.6
                ax.plot(time, np.interp(time, trace.t, trace.f), marker=mark, ms=size, mew=0.6, mfc="white", ls="none",
                        color=ink(k if len(traces) == 1 else k + 1), gid=name, zorder=3)


def _check_units(traces: Sequence[Trace], attribute: str, symbol: str) -> None:
    """Curves in two units on one axis would look comparable."""
    known = [(k + 1, getattr(trace, attribute)) for k, trace in enumerate(traces) if getattr(trace, attribute)]
    for k, unit in known:
        if not same_unit(unit, known[0][1]):
            raise refuse(traces[0].source.name, f"signal {known[0][0]} has {symbol} in {known[0][1]}, signal {k} in {unit}:"
                                                f" must be the same unit")


def _shared(traces: Sequence[Trace], attribute: str) -> str:
    """The unit that all signals have; "" if that of one is unknown."""
    units: list[str] = [getattr(trace, attribute) for trace in traces]
    return units[0] if all(units) else ""


def _section(traces: Sequence[Trace], ax: Axes | None) -> Axes:
    """Each signal at its distance, or at 1, 2, ..., scaled to its largest value."""
    ax = panels(ax=ax, aspect=min(1.5, 0.75 + 0.02 * len(traces)))[0, 0]
    distances = np.array([trace.distance for trace in traces])
    spread = np.ptp(distances)
    known = bool(np.isfinite(spread)) and np.min(np.diff(np.sort(distances))) > 0.1 * spread / (len(traces) - 1)
    places = distances if known else np.arange(1.0, len(traces) + 1)
    scale = np.ptp(places) / (len(traces) - 1)
    largest = [np.nanmax(np.abs(trace.f)) for trace in traces]
    for trace, place, most in zip(traces, places, largest):
        ax.plot(trace.t, place + (scale * trace.f / most if most > 0 else 0 * trace.f), color="black", lw=0.6)
    ax.set(xlabel=label("$t$", traces[0].t_unit), ylabel=label("distance", traces[0].length_unit) if known else "number",
           xlim=(min(np.nanmin(t.t) for t in traces), max(np.nanmax(t.t) for t in traces)))
    some = [most for most in largest if most > 0]
    if some:
        ax.set_title(f"each signal scaled to its largest |$F$|:\n{number(min(some), 3)} to {number(max(some), 3)} "
                     f"{unit_text(traces[0].f_unit)}", fontsize=6.5, loc="left")
    return ax


# ---- ensembles ------------------------------------------------------------------------------------------------------

@figure
def ensemble(given: Sequence[Input], *, ax: Axes | None = None) -> Axes:
    """Mean and rms deviation of the signals of an ensemble, from tables with the columns t, mean and rms; low and high
    give a band around the mean."""
    alone = len(given) == 1 and given[0].own_label is None
    ax = panels(ax=ax, aspect=0.66)[0, 0]
    hint, bands = "a table of an ensemble has t, mean and rms", []
    for k, (one, text) in enumerate(zip(given, names(given))):
        t, mean, rms = (one.column(name, hint) for name in ("t", "mean", "rms"))
        low, high = one.optional("low"), one.optional("high")
        if low is not None and high is not None:
            ax.fill_between(t, low, high, color=ink(k + 1), alpha=0.25, lw=0)
            bands.append(_interval(one))
        ax.plot(t, mean, color=ink(k + 1), label=text)
        ax.plot(t, rms, color=ink(2 if alone else k + 1), ls=dash(1))
    meaning = "mean" + (f", {bands[0] if len(set(bands)) == 1 else 'interval'}" if bands else "")
    ax.axhline(0, color="black", lw=0.4, zorder=0)
    ax.set(xlabel=label("$t$", common_unit(given, "t", TIME)),
           ylabel=label(r"$F_\mathrm{sig}$", common_unit(given, "mean", FORCE)))
    shades = [] if alone else [line for line in ax.lines if not line.get_label().startswith("_")]
    legend(ax, shades + [key(color=ink(1) if alone else "black", label=meaning),
                         key(color=ink(2) if alone else "black", ls=dash(1), label="rms deviation")])
    return ax


def _interval(one: Input) -> str:
    level = one.number("interval_level")
    return f"{number(100 * level)}% interval" if 0 < level < 1 else "interval"
