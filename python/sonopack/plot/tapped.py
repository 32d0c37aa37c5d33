"""Figures of the tapped column of Blackmore et al. 2011."""
from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.ticker import MaxNLocator, NullLocator

from .._command import Failed, usage
from .._core import Floats, invalid
from ._frame import WIDTH, column_of_panels, dash, figure, ink, legend, mark, new_figure, panels, points
from ._inputs import Input
from ._units import label, number, plain, refuse, unit_text

#: outputs, the abscissa of each, and a column that no other output has
_SIGNS = (("lyapunov", "parameter", "lambda"), ("bifurcation", "parameter", "tap"), ("energy", "tap", "work"),
          ("strobe", "tap", "density"), ("compare", "t", "mean_longwave"), ("compare", "t", "mean_bsr"),
          ("density", "t", "rho1"), ("trajectory", "t", "y0"), ("trajectory", "t", "y1"))
KINDS = {"trajectory": "a trajectory", "strobe": "a strobe table", "lyapunov": "a Lyapunov table",
         "bifurcation": "a bifurcation", "compare": "a comparison", "density": "a density table",
         "energy": "an energy table"}
#: the tapped column has units of its own
_SI = {"cm": (0.01, "m"), "g/cm": (0.1, "kg/m"), "erg": (1e-7, "J")}
_PARAMETERS = {"amplitude": "$a$", "period": "$T$", "frequency": "$f$", "restitution": "$e$", "e": "$e$"}


class Tapped:
    """A table of the tapped column. output: a key of KINDS. particles: number of columns y1, y2, ..."""

    def __init__(self, one: Input) -> None:
        self.one, self.table, self.si = one, one.raw_table, one.material is not None
        text = next((name for name in self.table.names if self.table[name].dtype.kind not in "fiu"), None)
        if text is not None:
            raise refuse(one.name, f"column {text} holds text: must be numbers")
        names = set(self.table.names)
        found = next(((output, abscissa) for output, abscissa, sign in _SIGNS if {abscissa, sign} <= names), None)
        if found is None:
            raise refuse(one.name, "the table is not one of `sonopack column', with columns t y0 y1 ..., tap t y1 ... "
                                   "density, parameter lambda, parameter tap y1 ..., t mean_longwave ..., t y1 ... "
                                   "rho1 ..., or tap work dissipated ...")
        self.output, self.abscissa = found
        self.particles, densities = (next(k for k in range(len(names) + 1) if f"{letter}{k + 1}" not in names)
                                     for letter in ("y", "rho"))
        lacking = "y1" if self.particles == 0 and self.output in ("trajectory", "strobe", "bifurcation") else \
            "dissipated" if self.output == "energy" and "dissipated" not in names else None
        if lacking:
            raise refuse(one.name, f"the table has no column {lacking} of numbers; must be a table of `sonopack column'")
        if self.output == "density" and densities != self.particles:
            raise refuse(one.name, f"{self.particles} columns y1, y2, ... and {densities} columns rho1, rho2, ...: must "
                                   f"be equal numbers")
        if self.table.rows == 0:
            raise refuse(one.name, "nothing to draw: no row")

    def __contains__(self, name: str) -> bool:
        return name in self.table

    def __getitem__(self, name: str) -> Floats:
        """A column, in SI where that is asked for; nan in place of what is not finite."""
        values = self.table[name].astype(float)
        factor = _SI.get(self.table.units[name], (1.0, ""))[0] if self.si else 1.0
        return np.where(np.isfinite(values), factor * values, np.nan)

    def y(self, particle: int) -> Floats:
        return self[f"y{particle}"]

    def label(self, symbol: str, column: str) -> str:
        unit = self.table.units.get(column, "")
        return label(symbol, _SI.get(unit, (1.0, unit))[1] if self.si else unit)

    def time(self) -> Floats:
        """The abscissa, which must rise."""
        values = self.table[self.abscissa].astype(float)
        if len(values) < 2:
            raise refuse(self.one.name, "nothing to draw: one row, must be two or more")
        self.check_finite(self.abscissa)
        for k in 1 + np.flatnonzero(np.diff(values) <= 0)[:1]:
            raise refuse(self.one.name,
                         f"row {k + 1}, {self.abscissa} = {values[k]:g} after {values[k - 1]:g}: must rise")
        return values

    def check_finite(self, column: str) -> None:
        values = self.table[column].astype(float)
        self.one.check(column, values, ~np.isfinite(values), "finite")

    def check_any(self, what: str, *columns: Floats) -> None:
        """Whether there is something to draw."""
        if not any(np.any(np.isfinite(column)) for column in columns):
            raise refuse(self.one.name, f"nothing to draw: no {what} is finite")

    def setting(self, key: str) -> float:
        """A positive number of the comments, nan without it."""
        value = self.one.number(key)
        return value if 0 < value < float("inf") else float("nan")

    def text(self, key: str) -> str:
        return str(self.table.metadata.get(key, ""))

    def parameter(self) -> str:
        """The label of the parameter of a diagram."""
        name = self.text("parameter")
        return self.label(_PARAMETERS.get(name, plain(name or "parameter")), "parameter")

    def violated(self) -> str:
        """The warning of a table whose particles did not keep their order; "" if there is none."""
        words = re.compile(r"warning: ordering \(1\) violated at (\d+) of (\d+) points")
        found = [words.match(one) for one in self.table.comments]
        return next((f"order (1) violated at {one[1]} of {one[2]} points" for one in found if one), "")


# ---- the figure of each output --------------------------------------------------------------------------------------

LINES_MOST = 40  # particles drawn
NAMED_MOST = 6  # particles with colours of their own
MARKED_MOST = 60  # points of a curve with marks
TAPS_MOST = 40  # of a trajectory, marked by lines


@figure
def column(given: Sequence[Input], *, ax: Any = None, column: str | None = None, surface: bool = False) -> Any:
    """Tables of `sonopack column`: a trajectory, strobe, lyapunov, bifurcation, compare, density or energy. Several
    trajectories or densities, or surface=True, make surfaces over particle and time side by side; a bifurcation stands
    above a table of lyapunov. column: "y2", ... of a bifurcation. material: heights in m."""
    tables = [Tapped(one) for one in given]
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
        told = " and ".join(f"table {k + 1} is {KINDS[kind]}" for k, kind in enumerate(kinds))
        raise refuse(given[0].name, f"{told}: they make no figure together; must be trajectories, densities, or a "
                                    f"bifurcation and a Lyapunov table")
    draw = {"strobe": _strobe, "compare": _compare, "density": _density, "energy": _energy,
            "trajectory": _trajectory}[kinds[0]]
    return draw(tables[0], ax)


def _shown(particles: int) -> range:
    """Particles that are drawn, counted from the top."""
    stride = -(-particles // LINES_MOST)
    return range(particles - (particles - 1) // stride * stride, particles + 1, stride)


# ---- against time ---------------------------------------------------------------------------------------------------

def _trajectory(s: Tapped, ax: Any) -> Axes:
    """Positions of the particles against time, as Fig. 1 of Blackmore et al. 2011."""
    t, shown, few = s.time(), _shown(s.particles), s.particles <= NAMED_MOST
    curves = [s.y(k) for k in shown] + ([s["y0"]] if "y0" in s else [])
    s.check_any("position", *curves)
    low, high = min(float(np.nanmin(y)) for y in curves), max(float(np.nanmax(y)) for y in curves)
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
    curves = {name: s[name] for name in _DIFFERENCES if name in s and np.isfinite(s[name]).any()}
    s.check_any("difference", *curves.values())
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
    t, axes = s.time(), column_of_panels(2, ax, 0.72)
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

def _taps_axis(axes: Any, s: Tapped, taps: Floats) -> None:
    """The same limits for all panels; points at whole taps stay clear of the frame."""
    low, high = float(np.nanmin(taps)), float(np.nanmax(taps))
    margin = max(0.04 * (high - low), min(0.5, 0.08 * (high - low))) or 0.5
    for ax in axes:
        ax.set_xlim(low - margin, high + margin)
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        ax.tick_params(axis="x", which="minor", bottom=False, top=False)
        ax.set_xlabel(s.label("tap", "tap"))


def _strobe(s: Tapped, ax: Any) -> Any:
    """Density and positions after each tap, these minus the first ones."""
    taps, axes = s.time(), column_of_panels(2, ax, 0.62)
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
    return axes


_ENERGIES = {"work": "work \N{MINUS SIGN} dissipated", "rest": "at rest after", "separation": r"least $y_{i+1} - y_i$"}


def _energy(s: Tapped, ax: Any) -> Any:
    """Energies of the taps. The column keeps so little of the work that work and dissipation look equal on one scale,
    so their difference is drawn, too."""
    taps, work, lost = s["tap"], s["work"], s["dissipated"]
    s.check_any("energy", taps + np.fmax(work, lost))
    values = {column: work - lost if column == "work" else s[column] for column in _ENERGIES if column in s}
    values = {column: y for column, y in values.items() if np.isfinite(y).any()}
    axes = column_of_panels(1 + len(values), ax, 0.5)
    marked = len(taps) <= MARKED_MOST
    axes[0].plot(taps, lost, color=ink(2), lw=2.6, marker="s" if marked else "", ms=5, mfc="white", label="dissipated")
    axes[0].plot(taps, work, color=ink(1), lw=0.8, marker="o" if marked else "", label="work of the floor")
    axes[0].set_ylabel(s.label("energy", "work"))
    for one, (column, y) in zip(axes[1:], values.items()):
        one.plot(taps, y, color=ink(1), lw=0.8, marker="o" if marked else "")
        one.axhline(0, color="0.6", lw=0.5, zorder=0)
        one.set_ylabel(s.label(_ENERGIES[column], column))
    _taps_axis(axes, s, taps)
    legend(axes[0])
    return axes if len(axes) > 1 else axes[0]


# ---- against a parameter --------------------------------------------------------------------------------------------

def _diagram(bifurcation: Tapped | None, lyapunov: Tapped | None, column: str, ax: Any) -> Any:
    """Bifurcations above Lyapunov exponents, or one of them."""
    given = [one for one in (bifurcation, lyapunov) if one is not None]
    names = [one.text("parameter") for one in given]
    if len(set(filter(None, names))) > 1:
        raise refuse(given[0].one.name, f"a bifurcation over the {plain(names[0])}, but exponents over the "
                                        f"{plain(names[1])}: must be the same")
    for s in given:
        s.check_finite("parameter")
    parameters = [s["parameter"] for s in given]
    low, high = min(x.min() for x in parameters), max(x.max() for x in parameters)
    axes, margin = column_of_panels(len(given), ax, 0.66 if len(given) > 1 else 0.75), 0.015 * (high - low)
    for panel, one, x in zip(axes, given, parameters):
        (_bifurcation if one is bifurcation else _exponents)(panel, one, x, column)
        panel.set(xlim=(low - margin, high + margin), xlabel=given[0].parameter())
    if not low < high:
        raise refuse(given[0].one.name, f"nothing to draw: only one value of the parameter, {low:g}; must be two or more")
    notes = [one.violated() for one in given]
    if any(notes):
        each = [f"({letter}): {note}" for letter, note in zip("ab", notes) if note]
        told = notes[:1] if len(set(notes)) == 1 else each
        axes[0].figure.supxlabel("\n".join(told if len(given) > 1 else notes), fontsize=6.5, x=0.02, ha="left")
    return axes if len(axes) > 1 else axes[0]


def _bifurcation(ax: Axes, s: Tapped, x: Floats, column: str) -> None:
    if column[:1] != "y" or column == "y0" or column not in s:
        raise usage(f"--column {column:.40}: the table has no such positions, must be y1 to y{s.particles}")
    s.check_any("position", s[column])
    ax.plot(x, s[column], ls="none", marker=".", ms=1.6, mew=0, color=ink(1), rasterized=len(x) > 20000)
    ax.set_ylabel(s.label(f"$y_{{{column[1:]}}}$ after a tap", column))


def _exponents(ax: Axes, s: Tapped, x: Floats, _: str) -> None:
    """Marks without a line: the exponent jumps between windows of cycles, and a line would show values that it never
    takes."""
    values, few = s["lambda"], len(x) <= MARKED_MOST
    s.check_any("Lyapunov exponent", values)
    points(ax, x, values, np.abs(s["error"]) if few and "error" in s else None, color=ink(1),
           marker="o" if few else ".", ms=3 if few else 2.5)
    ax.axhline(0, color="0.6", lw=0.5, zorder=0)
    ax.set_ylabel(s.label(r"$\lambda$", "lambda"))


# ---- surfaces -------------------------------------------------------------------------------------------------------
# y(particle, t) side by side, as in Fig. 2 of Blackmore et al. 2011. The colour shows what the height alone does not: the
# displacement from the first row, or the density.

TIMES_MOST, LABELS_MOST = 400, 60  # rows and particles of a surface
MESH = 0.25  # width of the lines on it [pt]
#: lighter is less, as in cividis, but without dark ends that hide the mesh
DENSITY = LinearSegmentedColormap.from_list("density", ["#fffad7", "#bee2b6", "#50b8be", "#2870b2", "#122664"])
_MODELS = {"longwave": "long wave", "bsr": "BSR"}


def draw_surfaces(tables: Sequence[Tapped], given: Any) -> Any:
    """One panel a table, at one scale."""
    if len({one.output for one in tables}) > 1:
        raise refuse(tables[0].one.name, "trajectories and densities have no common scale: must be all of one kind")
    faces = [_face(one) for one in tables]
    shades = np.concatenate([shade.ravel() for _, _, _, shade in faces])
    tables[0].check_any("position", shades)
    scale = _scale(tables[0], shades)
    axes = _axes(len(tables), given)
    for k, (ax, one, face) in enumerate(zip(axes, tables, faces)):
        _draw(ax, one, face, scale)
        name = _name(tables, k)
        ax.set_title(f"({'abcdef'[k]})  {name}" if len(tables) > 1 else name, pad=0)
    _same_limits(axes, faces, tables)
    symbol = r"density $\rho$" if tables[0].output == "density" else "$y(t) - y(0)$"
    bar = axes[0].figure.colorbar(scale, ax=list(axes), location="bottom", aspect=30, shrink=0.6, pad=0.1)
    bar.set_label(tables[0].label(symbol, "rho1" if tables[0].output == "density" else "y1"))
    return np.array(axes, object) if len(axes) > 1 else axes[0]


def _face(s: Tapped) -> tuple[Floats, Floats, Floats, Floats]:
    """Times, particles, heights and shades [times][particles] that are drawn."""
    if s.particles < 2:
        raise refuse(s.one.name, f"{s.particles} particle: a surface needs two or more")
    t = s.time()
    rows = np.unique(np.linspace(0, len(t) - 1, min(len(t), TIMES_MOST)).astype(int))
    particles = np.unique(np.linspace(1, s.particles, min(s.particles, LABELS_MOST)).astype(int))
    y = np.stack([s.y(k)[rows] for k in particles], axis=1)
    shade = np.stack([s[f"rho{k}"][rows] for k in particles], axis=1) if s.output == "density" else y - y[0]
    return t[rows], particles, y, shade


def _scale(s: Tapped, shades: Floats) -> ScalarMappable:
    low, high = float(np.nanmin(shades)), float(np.nanmax(shades))
    if s.output == "density":
        return ScalarMappable(Normalize(low, high), DENSITY)
    most = max(-low, high) or 1.0
    colours = LinearSegmentedColormap.from_list("signed", ["#00224e", "#424e6c", "#8c8c8c", "#cbbb68", "#fee838"])
    part = colours(0.5 + 0.5 * np.linspace(low, high, 256) / most)
    return ScalarMappable(Normalize(low, high), LinearSegmentedColormap.from_list("displacement", part))


def _axes(count: int, given: Any) -> list[Axes]:
    if given is not None:
        found = list(np.ravel(np.asarray(given, object)))
        if len(found) != count or any(ax.name != "3d" for ax in found):
            raise invalid("ax", f"must be {count} Axes with projection='3d'")
        return found
    across = count if count < 3 else 2 if count == 4 else 3
    down = -(-count // across)
    width = 1.25 * WIDTH if count == 1 else 7.0
    fig = new_figure((width, down * 0.9 * width / across + 0.6))
    return [fig.add_subplot(down, across, k + 1, projection="3d", label="surface") for k in range(count)]


def _draw(ax: Any, s: Tapped, face: tuple[Floats, Floats, Floats, Floats], scale: ScalarMappable) -> None:
    """Strips between neighbouring particles from back to front, each with the line of the one behind: so a surface
    hides what lies behind it."""
    t, particles, y, shade = face
    colours = scale.to_rgba(shade)
    colours[1:, :, :3] *= _light(t, y)[:, :, None]
    ax.computed_zorder = False
    every = -(-len(particles) // 25)
    for k in reversed(range(len(particles))):
        order = 2 * (len(particles) - k)
        if k > 0:
            ax.plot_surface(t[:, None], particles[None, k - 1:k + 1], y[:, k - 1:k + 1],
                            facecolors=colours[:, k - 1:k + 1],
                            rstride=1, cstride=1, shade=False, linewidth=0, antialiased=False, rasterized=True,
                            zorder=order)
        if k % every == 0 or k + 1 == len(particles):
            ax.plot(t, np.full(len(t), particles[k]), y[:, k], color="black", lw=MESH, zorder=order + 1,
                    rasterized=True)
    if "y0" in s:
        ax.plot(t, np.zeros(len(t)), np.interp(t, s.time(), s["y0"]), color="black", lw=0.9, zorder=order + 2)


def _light(t: Floats, y: Floats) -> Floats:
    """The steeper a cell falls with time, the darker. Flat cells keep the colour of the scale."""
    rise = np.diff(y, axis=0) / ((np.nanmax(y) - np.nanmin(y)) or 1)
    run = np.diff(t)[:, None] / (t[-1] - t[0])
    shade: Floats = 1 - 0.17 * np.tanh(0.5 * np.maximum(0, -np.nan_to_num(rise / run)))
    return shade


def _same_limits(axes: Sequence[Any], faces: Sequence[Any], tables: Sequence[Tapped]) -> None:
    """The same axes for all panels. Those of particles and of heights begin below their first ticks, so that the labels
    of two axes do not meet in a corner."""
    times, heights = [face[0] for face in faces], np.concatenate([face[2].ravel() for face in faces])
    most, low, high = max(one.particles for one in tables), min(0.0, np.nanmin(heights)), np.nanmax(heights)
    for ax, s in zip(axes, tables):
        ax.set(xlim=(min(t[0] for t in times), max(t[-1] for t in times)), ylim=(0, most),
               zlim=(low - 0.06 * (high - low), high))
        ax.set_xlabel(s.label("$t$", "t"), labelpad=-6)
        ax.set_ylabel("particle", labelpad=-8)
        ax.set_zlabel(s.label("$y$", "y1"), labelpad=-8)
        for axis, count in ((ax.xaxis, 4), (ax.yaxis, 5), (ax.zaxis, 5)):
            axis.set_major_locator(MaxNLocator(count, steps=[1, 2, 5, 10]))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(NullLocator())
            axis.set_tick_params(labelsize=6.5, pad=-3)
            axis.pane.set_facecolor("white")
            axis._axinfo["grid"].update(linewidth=0.3, color="0.8")
        ax.set_yticks([tick for tick in ax.get_yticks() if 1 <= tick <= most and tick == round(tick)])
        ax.set_proj_type("ortho")
        ax.view_init(elev=24, azim=-60)
        ax.set_box_aspect((1.5, 1.0, 1.1), zoom=1.0 if len(axes) == 1 else 0.93)


def _name(tables: Sequence[Tapped], k: int) -> str:
    """The label, the model, or the name of the file where another table has the same model."""
    own, models = tables[k].one, [one.text("model") for one in tables]
    if own.own_label is not None:
        return plain(own.own_label)
    if models[k] and models.count(models[k]) == 1:
        return plain(_MODELS.get(models[k], models[k]))
    return plain(own.stem() if len(tables) > 1 else models[k])
