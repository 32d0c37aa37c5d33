"""Contacts with the walls: by overlaps, from the per-atom output of fix wall/gran, from a file, or by what is missing in
the balance of forces."""
from __future__ import annotations

import math

import numpy as np

from .._core import Floats, Integers
from . import touch
from ._faults import bad_file, bad_option
from .options import SIDES
from .sheet import Sheet
from .work import Links, Work, dot, length, running_sum

_USUAL = (("f_floor", "f_bottom"), ("f_roof", "f_top"), ("f_left",), ("f_right",), ("f_front",), ("f_back",))


def read(w: Work) -> None:
    """Adds the contacts with the walls, as the option says or the files have them."""
    walls = w.o.walls
    if walls == "none" or (walls is None and w.cell == "periodic"):
        return
    if w.cell == "periodic":
        raise bad_option(f"--walls {walls}: the cell of {w.path} is periodic along all axes and has no walls: --set cell=piston "
                         "or box, if it should have")
    fixes = {side: fix for side in range(2 * w.dim if w.cell == "box" else 2) if (fix := _find_side(w, side)) is not None}
    if walls == "balance":
        _balance(w)
    elif w.walls is not None:
        _read_file(w, w.walls)
    elif walls is None and fixes:
        _read_fixes(w, fixes)
    elif walls == "overlap" or (w.form != "photoelastic" and not (w.links.j < 0).any()):
        _overlap(w)


def _overlap(w: Work) -> None:
    if not w.has_wall[0] and not w.has_wall[1] and w.o.walls is not None:
        raise bad_option(f"--walls overlap: {w.path} has no box along {w.name_of(w.up)}; must be given: --set bottom=PLACE, "
                         "--set top=PLACE")
    w.links = w.links + touch.walls(w)


# ---- forces of walls ------------------------------------------------------------------------------------------------

def _pushing(w: Work, grain: Integers, force: Floats) -> Integers:
    """The walls that push grains. In a box it is the nearest of those that push in the direction of the force."""
    best = np.where(force[:, w.up] > 0, -1, -2)
    nearest = np.full(len(grain), math.inf)
    for a in range(w.dim if w.cell == "box" else 0):
        wall = np.where(force[:, a] > 0, w.wall_on(a, -1), w.wall_on(a, 1))
        distance = np.where(force[:, a] > 0, w.x[grain, a], w.edge[a] - w.x[grain, a])
        nearer = (force[:, a] != 0) & (distance < nearest)
        best, nearest = np.where(nearer, wall, best), np.where(nearer, distance, nearest)
    return best


def _add_forces(w: Work, grain: Integers, force: Floats, point: Floats | None, side: int = -1) -> tuple[Integers, Integers]:
    """Adds contacts with the walls that push grains with these forces, in the units of the file, at these points. Returns
    the indices of those that act from the side, which are left out, and of those that pull."""
    links = Links(len(grain))
    links.i, links.j = grain, _pushing(w, grain, force) if side < 0 else np.full(len(grain), -1 - side)
    w.place_links(links)
    beside = np.zeros(len(grain), bool)
    if point is not None:
        beside = _turn_normals(w, links, point)
    along = -dot(force, links.n)
    links.fn, links.ft = along * w.force, (force + along[:, None] * links.n) * w.force
    pulls = (links.fn < 0) & ~beside
    w.links = w.links + links.take(~beside & ~pulls)
    return np.flatnonzero(beside), np.flatnonzero(pulls)


def _turn_normals(w: Work, links: Links, point: Floats) -> np.ndarray:  # type: ignore[type-arg]
    """Normals point to the points of contact. Returns which lie at the side."""
    axis = np.array([w.axis_of(int(j)) for j in links.j], dtype=np.int64)
    d = point * w.scale - np.array(w.low) - w.x[links.i]
    d[:, w.dim:] = 0
    known = np.isfinite(d[:, 0]) & (length(d) > 0)
    for a in range(w.up):
        if not w.periodic[a]:
            break
        d[:, a] -= w.edge[a] * np.rint(d[:, a] / w.edge[a])
    far, along = length(d), np.abs(d[np.arange(len(d)), axis])
    with np.errstate(invalid="ignore"):
        beside: np.ndarray = known & (along < 0.7 * far)  # type: ignore[type-arg]
        turned = known & (along < (1 - 1e-12) * far)
    links.n[turned] = d[turned] / far[turned, None]
    new = known & np.isnan(links.depth)
    links.depth[new] = w.r[links.i[new]] - far[new]
    return beside


def _pull_text(w: Work, grain: int) -> str:
    return f"the force of a wall on grain {w.id[grain]} pulls; must push it away from the wall"


# ---- fix wall/gran contacts -----------------------------------------------------------------------------------------

Fix = tuple[int, list[int], list[int]]  # columns of the flag, the force and the point along the packing's axes


def _find_fix(w: Work, name: str) -> Fix | None:
    """The columns f_ID[1] ... f_ID[7]: touches, force, point."""
    columns = [w.grains.column(f"{name}[{k}]") for k in range(1, 8)]
    force = [columns[1 + f] for f in w.axis[:w.dim]]
    return (columns[0], force, [columns[4 + f] for f in w.axis[:w.dim]]) if columns[0] >= 0 and min(force) >= 0 else None


def _find_side(w: Work, side: int) -> Fix | None:
    if SIDES[side] in w.roles.named:
        return _find_fix(w, w.roles.named[SIDES[side]][0])
    return next((fix for name in _USUAL[side] if (fix := _find_fix(w, name)) is not None), None)


def _read_fix(w: Work, fix: Fix) -> tuple[Integers, Floats, Floats | None]:
    """The grains that a wall touches, its forces, and the points of contact."""
    flag, force, point = fix
    grain = np.flatnonzero(w.grains.finite(flag, w.row) != 0)
    signs = [w.roles.axis_sign(f) for f in w.axis[:w.dim]]
    rows = w.row[grain]
    forces = w.vectors(w.grains, list(zip(force, signs)), rows)
    return grain, forces, w.vectors(w.grains, list(zip(point, signs)), rows) if min(point) >= 0 else None


def _place_wall(w: Work, fix: Fix, side: int) -> None:
    """Takes the position of a wall from its points of contact, if these lie in a plane, and moves the box to it."""
    wall = -1 - side
    axis, far = w.axis_of(wall), side % 2
    _, _, point = _read_fix(w, fix)
    if point is None or len(point) == 0 or math.isfinite(w.wall_given(wall)) or w.o.given(w.size_key(axis)):
        return
    low, high = float((point[:, axis] * w.scale).min()), float((point[:, axis] * w.scale).max())
    if high - low > 1e-6:
        return
    other = w.low[axis] if far else w.low[axis] + w.edge[axis]
    move = 0.0 if far else low - w.low[axis]
    w.low[axis] = other if far else low
    w.edge[axis] = low - other if far else other - low
    w.has_wall[side] = True
    w.x[:, axis] -= move


def _read_fixes(w: Work, fixes: dict[int, Fix]) -> None:
    for side, fix in fixes.items():
        _place_wall(w, fix, side)
    for side, fix in fixes.items():
        grain, force, point = _read_fix(w, fix)
        _, pulls = _add_forces(w, grain, force, point, side)
        if len(pulls):
            raise bad_file(_pull_text(w, int(grain[pulls[0]])))


# ---- a file ---------------------------------------------------------------------------------------------------------

def _read_file(w: Work, sheet: Sheet) -> None:
    ids = w.roles.need(sheet, "id")[0]
    axes = w.axis[:w.dim]
    at, points = w.roles.vector(sheet, "f", axes), w.roles.vector(sheet, "p", axes)
    if at is None:
        w.roles.need(sheet, "f_x")
        raise bad_file(f"{sheet.file}: no columns for f_x, f_y")
    grain = w.grain_of(sheet.whole(ids))
    if (grain < 0).any() and w.report.left_out == 0:
        sheet.fail(int(np.flatnonzero(grain < 0)[0]), ids, "the id of a grain in the file of grains")
    rows = np.flatnonzero(grain >= 0)
    grain, force = grain[rows], w.vectors(sheet, at, rows)
    point = w.vectors(sheet, points, rows) if points else None
    size = length(force)
    from_side = np.abs(force[:, w.up]) < 0.5 * size if w.cell == "piston" and point is None else np.zeros(len(rows), bool)
    taken = np.flatnonzero((size > 0) & ~from_side)
    beside, pulls = _add_forces(w, grain[taken], force[taken], None if point is None else point[taken])
    if len(pulls):
        k = int(taken[pulls[0]])
        raise bad_file(f"{sheet.file}:{sheet.line(int(rows[k]))}: {_pull_text(w, int(grain[k]))}")
    left_out = len(beside) + int(from_side.sum())
    if left_out > 0:
        w.note(f"{left_out} contacts with side walls are left out")


# ---- balance --------------------------------------------------------------------------------------------------------

def sum_over(links: Links, n: int, values: Floats, sign: float = -1.0) -> Floats:
    """Sums of values [contacts][k] over the contacts of each of n grains, on j times `sign`. They are taken contact by
    contact: the same bits everywhere."""
    ends = np.stack([links.i, links.j], axis=1).ravel()
    grains = ends >= 0
    signs = np.tile([1.0, sign], len(links))[grains]
    columns = [np.bincount(ends[grains], signs * np.repeat(column, 2)[grains], n) for column in values.T]
    return np.stack(columns, axis=1)


def _balance(w: Work) -> None:
    """Grains at the boundary are pushed by walls that the file does not list: with the force that they lack."""
    if not w.has_forces:
        raise bad_option(f"--walls balance: {w.path} has no forces; must have them")
    mean = running_sum(w.links.fn / len(w.links))
    lack = sum_over(w.links, w.n, np.where(np.isfinite(w.links.ft), w.links.ft, 0) - w.links.fn[:, None] * w.links.n)
    size = length(lack)
    pushed = size > 0.05 * mean
    grain = np.flatnonzero(pushed & w.boundary)
    axis = np.full(len(grain), w.up)
    own = np.abs(lack[grain])
    for a in range(w.up if w.cell == "box" else 0):
        axis = np.where(own[:, a] > own[np.arange(len(grain)), axis], a, axis)
    along = lack[grain, axis]
    aside = np.abs(along) < 0.5 * size[grain]
    links = Links(int((~aside).sum()))
    links.i = grain[~aside]  # the others push it up: what holds it is above
    links.j = np.array([w.wall_on(int(a), float(value)) for a, value in zip(axis[~aside], along[~aside])], dtype=np.int64)
    links.fn, links.n = size[links.i], lack[links.i] / size[links.i, None]
    links.ft[:] = 0
    w.links = w.links + links
    if aside.any():
        w.note(f"{int(aside.sum())} boundary grains are pushed from the side: this force is left out")
    inner = int((pushed & ~w.boundary).sum())
    if inner > 0:
        w.note(f"{inner} grains that are not marked as boundary lack more than 5% of the mean force")

