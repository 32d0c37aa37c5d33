"""Figures of the tapped column of Blackmore et al. 2011."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from .._command import Failed, usage
from .._core import Floats
from .._records import Material
from ._frame import dash, ink, legend, mark, panels, points
from ._frame import styled
from ._inputs import inputs
from ._surfaces import draw_surfaces
from ._tapped import KINDS, Tapped, any_finite
from ._units import number, plain, refuse, unit_text

LINES_MOST = 40  # particles drawn
NAMED_MOST = 6  # particles with colours of their own
MARKED_MOST = 60  # points of a curve with marks
TAPS_MOST = 40  # of a trajectory, marked by lines


@styled
def column(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None, ax: Any = None,
           column: str | None = None, surface: bool = False) -> Any:
    """Tables of `sonopack column`: a trajectory, strobe, lyapunov, bifurcation, compare, density or energy. Several
    trajectories or densities, or surface=True, make surfaces over particle and time side by side; a bifurcation stands
    above a table of lyapunov. column: "y2", ... of a bifurcation. material: heights in m."""
    tables = [Tapped(one) for one in inputs(data, labels, material)]
    kinds = [one.output for one in tables]
    flat = [kind in ("trajectory", "density") for kind in kinds]
    diagram = set(kinds) <= {"bifurcation", "lyapunov"} and len(set(kinds)) == len(kinds)
    if column and "bifurcation" not in (kinds if diagram else ()):
        raise Failed(f"column {column:.40}: only a bifurcation has a choice of column")
    if surface and not all(flat):
        raise refuse(tables[0].one.name, "a surface is drawn of trajectories (t y0 y1 ...) or densities only")
    if diagram:
        of = dict(zip(kinds, tables))
        return _diagram(of.get("bifurcation"), of.get("lyapunov"), column or "y1", ax)
    if surface or (len(tables) > 1 and all(flat)):
        return draw_surfaces(tables, ax)
    if len(tables) > 1:
        raise _apart(tables)
    draw = {"strobe": _strobe, "compare": _compare, "density": _density, "energy": _energy,
            "trajectory": _trajectory}[kinds[0]]
    return draw(tables[0], ax)


def _apart(tables: Sequence[Tapped]) -> Failed:
    """Names the first two tables that cannot share a figure."""
    suit = [{"trajectory": 0, "density": 0, "bifurcation": 1, "lyapunov": 1}.get(one.output, 2) for one in tables]
    one, two = next(((a, b) for a in range(len(suit)) for b in range(a + 1, len(suit))
                     if suit[a] != suit[b] or suit[a] == 2 or tables[a].output == tables[b].output), (0, 1))
    return refuse(tables[0].one.name, f"table {one + 1} is {KINDS[tables[one].output]} and table {two + 1} "
                                      f"{KINDS[tables[two].output]}: they make no figure together; must be "
                                      f"trajectories, densities, or a bifurcation and a Lyapunov table")


def _tagged(axes: Sequence[Axes]) -> None:
    """Letters of panels above their frames, where they hide no data."""
    for ax, letter in zip(axes, "abcd"):
        ax.set_title(f"({letter})", loc="left", fontsize=7, pad=3)


def _shown(particles: int) -> range:
    """Particles that are drawn, counted from the top."""
    stride = -(-particles // LINES_MOST)
    return range(particles - (particles - 1) // stride * stride, particles + 1, stride)


# ---- against time ---------------------------------------------------------------------------------------------------

def _trajectory(s: Tapped, ax: Any) -> Axes:
    """Positions of the particles against time, as Fig. 1 of Blackmore et al. 2011."""
    t, shown, few = s.time(), _shown(s.particles), s.particles <= NAMED_MOST
    curves = [s.y(k) for k in shown] + ([s["y0"]] if "y0" in s else [])
    if not any_finite(*curves):
        raise refuse(s.one.name, "nothing to draw: no position is finite")
    low, high = min(np.nanmin(y) for y in curves), max(np.nanmax(y) for y in curves)
    range_ = high - low if high > low else 1.0
    ax = panels(ax=ax, aspect=0.85)[0, 0]
    between = ", " if shown.step == 1 else f", $y_{{{shown[min(1, len(shown) - 1)]}}}$ "
    many = f"$y_{{{shown[0]}}}${between if shown.step > 1 else ' '}\N{HORIZONTAL ELLIPSIS} $y_{{{shown[-1]}}}$"
    for k, particle in enumerate(shown):
        text = f"$y_{{{particle}}}$" if few else many if k == 0 else None
        ax.plot(t, curves[k], color=ink(1 + k) if few else ink((1, 6)[k % 2]), lw=0.8 if few else 0.6, label=text)
    if "y0" in s:
        ax.fill_between(t, low - 0.04 * range_, s["y0"], color="0.8", lw=0)
        ax.plot(t, s["y0"], color="black", lw=1.2, label="floor $y_0$")
    _tap_lines(ax, s, t)
    ax.set(xlim=(t[0], t[-1]), ylim=(low - 0.04 * range_, high + 0.04 * range_), xlabel=s.label("$t$", "t"),
           ylabel=s.label("$y$", "y1"))
    legend(ax)
    return ax


def _tap_lines(ax: Axes, s: Tapped, t: Floats) -> None:
    period = s.setting("period")
    if (t[-1] - t[0]) / period <= TAPS_MOST - 1:
        starts = period * np.arange(np.ceil(t[0] / period + 1e-9), t[-1] / period - 1e-9)
        for start in starts:
            ax.axvline(start, color="0.4", ls="--", lw=0.4, zorder=0)


_DIFFERENCES = {"mean_longwave": "long wave, mean", "max_longwave": "long wave, largest", "mean_bsr": "BSR, mean",
                "max_bsr": "BSR, largest"}


def _compare(s: Tapped, ax: Any) -> Axes:
    """Differences of the continua from the lattice. Where their sizes differ much, on a logarithmic axis, which cannot
    show that both start from the lattice."""
    t = s.time()
    curves = {name: s[name] for name in _DIFFERENCES if name in s and any_finite(s[name])}
    if not curves:
        raise refuse(s.one.name, "nothing to draw: no difference is finite")
    tops = [top for top in (np.nanmax(y) for y in curves.values()) if top > 0]
    wide = bool(tops) and max(tops) > 30 * min(tops)
    ax = panels(ax=ax)[0, 0]
    for name, y in curves.items():
        largest = name.startswith("max")
        ax.plot(t, np.where(y > 0, y, np.nan) if wide else y, color=ink(1 + name.endswith("bsr")),
                ls=dash(int(largest)), lw=0.7 if largest else 1.0, label=_DIFFERENCES[name])
    ax.set(xlim=(t[0], t[-1]), yscale="log" if wide else "linear", xlabel=s.label("$t$", "t"),
           ylabel=s.label("difference from the lattice", next(iter(curves))))
    legend(ax)
    return ax


# ---- densities ------------------------------------------------------------------------------------------------------

PROFILES, PROFILE_MARKS = 6, 40


def _density(s: Tapped, ax: Any) -> Any:
    """Density along the column at rest and after taps, and of three particles against time."""
    t, axes = s.time(), panels(2, 1, ax=ax, aspect=0.72)[:, 0]
    y = np.stack([s.y(k + 1) for k in range(s.particles)], axis=1)
    rho = np.stack([s[f"rho{k + 1}"] for k in range(s.particles)], axis=1)
    unit = unit_text(s.table.units["t"])
    for k, (row, tap) in enumerate(_profile_rows(s, t)):
        text = (f"tap {tap}, " if tap else "") + f"$t$ = {number(t[row], 3)} {unit}".rstrip()
        axes[0].plot(y[row], rho[row], color=ink(k), ls=dash(k), marker=mark(k) if s.particles <= PROFILE_MARKS else "",
                     mfc="white" if k % 2 else None, lw=0.8, label=text)
    for k, particle in enumerate(sorted({1, (s.particles + 1) // 2, s.particles})):
        axes[1].plot(t, rho[:, particle - 1], color=ink(1 + k), ls=dash(int(k == 1)), lw=0.7,
                     label=f"particle {particle}")
    axes[0].set_xlabel(s.label("height $y$", "y1"))
    axes[1].set(xlabel=s.label("$t$", "t"), xlim=(t[0], t[-1]))
    for one in axes:
        one.set_ylabel(s.label(r"density $\rho$", "rho1"))
        legend(one)
    _tagged(axes)
    return axes


def _profile_rows(s: Tapped, t: Floats) -> list[tuple[int, int]]:
    """The first row and those at .99T, 1.99T, ...; of many taps the first, the last and some in between. Without a
    known period evenly spaced ones. Rows, and numbers of taps, 0 if unknown."""
    period = s.setting("period")
    known = np.isfinite(period)
    taps = int((t[-1] - t[0]) / period + 0.02) if known else PROFILES - 1
    numbers = np.unique(np.round(np.linspace(1, taps, min(taps, PROFILES - 1))).astype(int))
    if known:
        wanted = {int(np.argmin(np.abs(t - t[0] - (tap - 0.01) * period))): int(tap) for tap in numbers}
        whole = abs(t[0]) < 1e-9 * period
        return [(0, 0)] + [(row, tap if whole else 0) for row, tap in wanted.items() if row > 0]
    return [(int(row), 0) for row in np.unique(np.round(np.linspace(0, len(t) - 1, PROFILES)).astype(int))]


# ---- tap by tap -----------------------------------------------------------------------------------------------------

def _taps_axis(axes: Sequence[Axes], s: Tapped, taps: Floats) -> None:
    """The same limits for all panels; points at whole taps stay clear of the frame."""
    low, high = np.nanmin(taps), np.nanmax(taps)
    margin = max(0.04 * (high - low), min(0.5, 0.08 * (high - low))) or 0.5
    for ax in axes:
        ax.set_xlim(low - margin, high + margin)
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        ax.tick_params(axis="x", which="minor", bottom=False, top=False)
        ax.set_xlabel(s.label("tap", "tap"))


def _strobe(s: Tapped, ax: Any) -> Any:
    """Density and positions after each tap, these minus the first ones."""
    taps, axes = s.time(), panels(2, 1, ax=ax, aspect=0.62)[:, 0]
    few, shown, marked = s.particles <= NAMED_MOST, _shown(s.particles), len(taps) <= MARKED_MOST
    axes[0].plot(taps, s["density"], color=ink(1), marker="o" if marked else "")
    for k, particle in enumerate(shown):
        y = s.y(particle)
        first = y[np.isfinite(y)][:1]
        end = particle in (shown[0], shown[-1])
        words: dict[str, Any] = {"color": ink(1 + k), "lw": 0.8, "marker": mark(k) if marked else ""}
        if not few:
            words = {"color": ink(1 + (k > 0)) if end else "0.6", "lw": 1.0 if end else 0.5, "zorder": 3 if end else 2}
        axes[1].plot(taps, y - (first if len(first) else np.nan), **words,
                     label=f"$y_{{{particle}}}$" if few or end else "those between" if k == len(shown) // 2 else None)
    axes[1].axhline(0, color="0.6", lw=0.5, zorder=0)
    _taps_axis(axes, s, taps)
    axes[0].set_ylabel(s.label("density", "density"))
    axes[1].set_ylabel(s.label(f"$y - y$(tap {taps[0]:.0f})", "y1"))
    legend(axes[1])
    _tagged(axes)
    return axes


_ENERGIES = {"kept": ("work", "work \N{MINUS SIGN} dissipated"), "rest": ("rest", "at rest after"),
             "separation": ("separation", r"least $y_{i+1} - y_i$")}


def _energy(s: Tapped, ax: Any) -> Any:
    """Energies of the taps. The column keeps so little of the work that work and dissipation look equal on one scale,
    so their difference is drawn, too."""
    taps, work, lost = s["tap"], s["work"], s["dissipated"]
    if not any_finite(taps) or not any_finite(work, lost):
        raise refuse(s.one.name, "nothing to draw: no energy is finite")
    shown = {name: column for name, (column, _) in _ENERGIES.items() if column in s}
    values = {name: work - lost if name == "kept" else s[column] for name, column in shown.items()}
    values = {name: y for name, y in values.items() if any_finite(y)}
    axes = panels(1 + len(values), 1, ax=ax, aspect=0.5)[:, 0]
    marked = len(taps) <= MARKED_MOST
    axes[0].plot(taps, lost, color=ink(2), lw=2.6, marker="s" if marked else "", ms=5, mfc="white", label="dissipated")
    axes[0].plot(taps, work, color=ink(1), lw=0.8, marker="o" if marked else "", label="work of the floor")
    axes[0].set_ylabel(s.label("energy", "work"))
    for one, (name, y) in zip(axes[1:], values.items()):
        one.plot(taps, y, color=ink(1), lw=0.8, marker="o" if marked else "")
        one.axhline(0, color="0.6", lw=0.5, zorder=0)
        one.set_ylabel(s.label(_ENERGIES[name][1], _ENERGIES[name][0]))
    _taps_axis(axes, s, taps)
    legend(axes[0])
    if len(axes) > 1:
        _tagged(axes)
    return axes if len(axes) > 1 else axes[0]


# ---- against a parameter --------------------------------------------------------------------------------------------

def _diagram(bifurcation: Tapped | None, lyapunov: Tapped | None, column: str, ax: Any) -> Any:
    """Bifurcations above Lyapunov exponents, or one of them."""
    given = [one for one in (bifurcation, lyapunov) if one is not None]
    names = [one.text("parameter") for one in given]
    if len(set(filter(None, names))) > 1:
        raise refuse(given[0].one.name, f"a bifurcation over the {plain(names[0])}, but exponents over the "
                                        f"{plain(names[1])}: must be the same")
    parameters = [_parameter_values(one) for one in given]
    low, high = min(x.min() for x in parameters), max(x.max() for x in parameters)
    axes, margin = panels(len(given), 1, ax=ax, aspect=0.66 if len(given) > 1 else 0.75)[:, 0], 0.015 * (high - low)
    for one, s, x in zip(axes, given, parameters):
        (_bifurcation if s is bifurcation else _exponents)(one, s, x, column)
        one.set(xlim=(low - margin, high + margin), xlabel=given[0].parameter())
    if not low < high:
        raise refuse(given[0].one.name,
                     f"nothing to draw: only one value of the parameter, {low:g}; must be two or more")
    if len(given) > 1:
        _tagged(axes)
    notes = [one.violated() for one in given]
    if any(notes):
        each = [f"({letter}): {note}" for letter, note in zip("ab", notes) if note]
        told = notes[:1] if len(set(notes)) == 1 else each
        axes[0].figure.supxlabel("\n".join(told if len(given) > 1 else notes), fontsize=6.5, x=0.02, ha="left")
    return axes if len(axes) > 1 else axes[0]


def _parameter_values(s: Tapped) -> Floats:
    values = s.table["parameter"].astype(float)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise refuse(s.one.name, f"row {bad[0] + 1}, parameter = {values[bad[0]]:g}: must be finite")
    return values


def _bifurcation(ax: Axes, s: Tapped, x: Floats, column: str) -> None:
    if column[:1] != "y" or column == "y0" or column not in s:
        raise usage(f"--column {column:.40}: the table has no such positions, must be y1 to y{s.particles}")
    if not any_finite(s[column]):
        raise refuse(s.one.name, "nothing to draw: no position is finite")
    ax.plot(x, s[column], ls="none", marker=".", ms=1.6, mew=0, color=ink(1), rasterized=len(x) > 20000)
    ax.set_ylabel(s.label(f"$y_{{{column[1:]}}}$ after a tap", column))


def _exponents(ax: Axes, s: Tapped, x: Floats, _: str) -> None:
    """Marks without a line: the exponent jumps between windows of cycles, and a line would show values that it never
    takes."""
    values, few = s["lambda"], len(x) <= MARKED_MOST
    if not any_finite(values):
        raise refuse(s.one.name, "nothing to draw: no Lyapunov exponent is finite")
    points(ax, x, values, np.abs(s["error"]) if few and "error" in s else None, color=ink(1),
           marker="o" if few else ".", ms=3 if few else 2.5)
    ax.axhline(0, color="0.6", lw=0.5, zorder=0)
    ax.set_ylabel(s.label(r"$\lambda$", "lambda"))
