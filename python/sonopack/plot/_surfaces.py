"""Surfaces y(particle, t) of the tapped column side by side, as in Fig. 2 of Blackmore et al. 2011. The colour shows
what the height alone does not: the displacement from the first row, or the density."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.ticker import MaxNLocator, NullLocator

from .._core import Floats, invalid
from ._frame import WIDTH, new_figure
from ._tapped import Tapped, any_finite
from ._units import plain, refuse

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
    if not any_finite(shades):
        raise refuse(tables[0].one.name, "nothing to draw: no position is finite")
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
    return 1 - 0.17 * np.tanh(0.5 * np.maximum(0, -np.nan_to_num(rise / run)))


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
