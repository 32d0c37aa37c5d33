"""Pictures of motions: modes of vibration, and the wave after a pulse; movies of both."""
from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from .._command import usage
from .._core import Floats
from .._network import Network
from .._records import Material
from .._scene import Scene
from ._frame import figure, figure_of, forget, styled
from ._inputs import Input
from ._motion import Motion, find_mode, find_snapshots, network_for, usual_time
from ._units import FREQUENCY, LENGTH, TIME, number, to_si, unit_text
from ._view import EARLIER, GRAIN, LATER, RATTLER, View, arrow_key, finish, views
from .packing import disc, rattler_entry

LONGEST_MODE = 1.5  # arrow of a mode [mean diameters]
FARTHEST = 0.5  # how far a grain moves in a movie, over the length of its arrow
TYPICAL, LENGTH_OF_TYPICAL = 0.70, 0.8  # this part of the moving grains has arrows shorter than this [mean diameters]
LONGEST = 1.7  # arrow of a snapshot [mean diameters]
MOVING = 0.01  # least displacement of a moving grain, relative to the largest
CUT = "#d55e00"


def _save_table(motion: Motion, table: str | None, material: Material | None) -> None:
    if table is not None:
        made = motion.table()
        (made.si(material) if material else made).save(table)


def _same_size(draw: Any, count: int) -> Iterator[Any]:
    """The frames of a movie, all as large as the first."""
    size = None
    for k in range(count):
        axes = draw(k)
        fig = figure_of(axes)
        size = fig.get_size_inches() if size is None else size
        fig.set_size_inches(size)
        forget(fig)
        yield axes


@figure
def mode(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None, mode: int | None = None,
         frames: int | None = None, table: str | None = None) -> Any:
    """The displacements of a mode as arrows on the grains, tinted where they rotate. data: a packing, network or Modes,
    or a packing and a file of `sonopack modes --vectors'. mode: the number, by default of the first that is no zero
    mode. frames: an iterator over the Axes of so many pictures of one period. table: writes the displacements there,
    too."""
    motion, material = find_mode(given, mode, scene), given[0].material
    if frames is None:
        _save_table(motion, table, material)
        return _draw_mode(motion, material, ax, None)
    draw = functools.partial(_draw_mode, motion, material, ax)
    return _same_size(lambda k: draw(k / frames), frames)


def _tints(view: View, motion: Motion, swing: float) -> Floats:
    """Colours of all grains: white, tinted by the rotation relative to the largest translation or rotation."""
    net, turns = motion.network, motion.turns
    most = max(np.linalg.norm(turns, axis=1).max(), motion.lengths.max())
    seen = view.towards(turns) if net.dim == 3 else turns[:, 2]
    part = swing * seen / most if most > 0 else seen
    fill = np.tile(to_rgb(RATTLER), (net.packing.n, 1))
    inks = np.where(part[:, None] > 0, to_rgb(LATER), to_rgb(EARLIER))
    fill[net.grain] = 1 + np.minimum(1, np.abs(part))[:, None] * (inks - 1)
    return fill


@styled
def _draw_mode(motion: Motion, material: Material | None, ax: Any, part: float | None) -> Any:
    """part: of the period that has passed; None: no movie."""
    net = motion.network
    swing, moves, largest = 1.0 if part is None else np.cos(2 * np.pi * part), motion.moves, motion.lengths.max()
    diameter = 2 * float(np.mean(net.packing.r))
    scale = swing * (0.9 if net.dim == 1 else LONGEST_MODE) * diameter / largest if largest > 0 else 0.0
    shift = None
    if part is not None:
        shift = np.zeros((net.packing.n, 3))
        shift[net.grain] = FARTHEST * scale * moves
    found = views(net.packing, ax, shift)
    for view in found:
        view.grains(_tints(view, motion, swing))
        view.arrows(net.grain, scale * _for_view(moves, net.dim), "black", centred=True,
                    width=max(0.4, min(0.9, 0.1 * diameter * view.points)))
    factor, unit = to_si(FREQUENCY, material)
    title = rf"$n$ = {motion.number},  $\omega$ = {number(factor * motion.omega)} {unit_text(unit)}"
    title = motion.load or title
    title += "" if part is None else f",  $t$ = {part:.2f} $T$"
    turning = [disc(LATER, "rotating counterclockwise"), disc(EARLIER, "clockwise")] if np.any(motion.turns) else []
    return finish(found, turning + _rattlers(net), title)


def _rattlers(net: Network) -> list[Any]:
    return [rattler_entry(int(net._c.rattlers))] if net._c.rattlers else []


def _for_view(vectors: Floats, dim: int) -> Floats:
    """Vectors of a chain stand on its own axis."""
    return vectors if dim > 1 else np.stack([vectors[:, 0]] * 3, axis=1)


# ---- snapshots ------------------------------------------------------------------------------------------------------

@figure
def snapshot(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None, time: float | None = None,
             frames: int | None = None, start: float = 0.0, end: float | None = None, table: str | None = None) -> Any:
    """The displacements of the grains as arrows at a time after the pulse, which starts at the bottom wall. data: a
    packing or network, or this and displacements [n][dof] or a table of them. frames: an iterator over the Axes of so
    many pictures from start to end. table: writes the displacements there, too."""
    times = None if time is None else [time]
    if frames is not None:
        end = usual_time(network_for(given[0], scene).packing) / 0.75 if end is None else end
        if not start < end:
            raise usage(f"--from {start:g}: must be before the last frame, at {end:g} (--to)")
        times = [start + (end - start) * k / (frames - 1) for k in range(frames)]
    motions = find_snapshots(given, times, scene)
    scale, material = _arrow_scale(motions), given[0].material
    if frames is None:
        _save_table(motions[0], table, material)
        return _draw_snapshot(motions[0], scale, material, ax, False)
    cut = any(_is_cut(one, scale).any() for one in motions)
    return _same_size(lambda k: _draw_snapshot(motions[k], scale, material, ax, cut), frames)


def _arrow_scale(motions: list[Motion]) -> float:
    """Length of an arrow over its displacement. Localized oscillations near the source are much larger than the wave,
    so the scale follows most of the grains, in all frames together; 0: nothing moves."""
    lengths = np.concatenate([one.lengths for one in motions])
    moving = np.sort(lengths[(lengths >= MOVING * lengths.max()) & (lengths > 0)])
    if len(moving) == 0:
        return 0.0
    diameter = 2 * float(np.mean(motions[0].network.packing.r))
    return LENGTH_OF_TYPICAL * diameter / float(moving[int(TYPICAL * (len(moving) - 1) + 0.5)])


def _is_cut(motion: Motion, scale: float) -> Any:
    diameter = 2 * float(np.mean(motion.network.packing.r))
    return scale * motion.lengths > LONGEST * diameter


@styled
def _draw_snapshot(motion: Motion, scale: float, material: Material | None, ax: Any, any_cut: bool) -> Any:
    net = motion.network
    packing, cut, moves = net.packing, _is_cut(motion, scale), scale * motion.moves
    diameter = 2 * float(np.mean(packing.r))
    moves[cut] *= (LONGEST * diameter / np.linalg.norm(moves[cut], axis=1))[:, None]
    moves = _for_view(moves, net.dim)
    fill = np.tile(to_rgb(RATTLER), (packing.n, 1))
    fill[net.grain] = to_rgb(GRAIN)
    found = views(packing, ax)
    width = max(0.4, min(0.8, 0.08 * diameter * found[0].points))
    for view in found:
        view.grains(fill)
        view.arrows(net.grain[~cut], moves[~cut], "black", width=width)
        view.arrows(net.grain[cut], moves[cut], CUT, width=width)
    factor, unit = to_si(TIME, material)
    entries = _arrow_entries(found[0], scale, material, width)
    if scale > 0 and (any_cut or cut.any()):
        entries.append(arrow_key(12, width, CUT, f"{cut.sum()} longer, cut"))
    return finish(found, entries + _rattlers(net), f"$t$ = {number(factor * motion.t)} {unit_text(unit)}")


def _arrow_entries(view: View, scale: float, material: Material | None, width: float) -> list[Any]:
    """An arrow of a diameter, or a few so that it shows, and its length."""
    if not scale > 0:
        return []
    one = view.diameter * view.points
    points = one * max(1, np.ceil(10 / one))
    factor, unit = to_si(LENGTH, material)
    return [arrow_key(points, width, "black",
                      f"= {number(factor * points / view.points / scale, 2)} {unit_text(unit)}")]
