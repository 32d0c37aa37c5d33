"""Contacts with walls: by overlaps, from the per-atom output of fix wall/gran, from a file, or by what is missing in the
balance of forces."""
from __future__ import annotations

import math

import numpy as np

from .._core import Floats, Integers
from ._faults import bad_file, bad_option
from .contacts import largest_axis
from .options import NAN, SIDES
from .sheet import Mask, Sheet
from .work import Links, Work, dot, joined, length, links_of, running_sum, sphere_mass, sum_over

_USUAL = (("f_floor", "f_bottom", "f_inner"), ("f_roof", "f_top", "f_outer"), ("f_left",), ("f_right",), ("f_front",),
          ("f_back",))


def read(w: Work) -> None:
    """Adds the contacts with the walls, as the option says or the files have them."""
    walls = w.o.walls
    if walls == "none" or (walls is None and w.cell == "periodic"):
        return
    if w.cell == "periodic":
        raise bad_option(f"--walls {walls}: the cell of {w.path} is periodic along all axes and has no walls: --set "
                         "cell=piston or box, if it should have")
    fixes = {}
    if walls is None and w.walls is None:
        found = {side: _find_fix(w, side) for side in range(2 * w.dim if w.cell == "box" else 2)}
        fixes = {side: fix for side, fix in found.items() if fix is not None}
    if walls == "balance":
        _balance(w)
    elif w.walls is not None:
        _read_file(w, w.walls)
    elif fixes:
        _read_fixes(w, fixes)
    elif walls == "overlap" or (w.form != "photoelastic" and not (w.links.j < 0).any()):
        if walls is not None and not w.has_wall[0] and not w.has_wall[1]:
            raise bad_option(f"--walls overlap: {w.path} has no box along {w.name_of(w.up)}; must be given: --set "
                             "bottom=PLACE, --set top=PLACE (of a ring inner, outer, x0, y0)")
        near = _touching_walls(w)
        w.links = joined(w.links, _balanced(w, near) if w.has_forces else near)
    _check_near(w)


def _touching_walls(w: Work) -> Links:
    """All grains that overlap the walls whose positions are known."""
    out = links_of([], [])
    for side in np.flatnonzero(w.has_wall):
        links = links_of(np.arange(w.n), np.full(w.n, -1 - side))
        w.place_links(links)
        out = joined(out, links[links.depth > (-3 * w.place if w.has_forces else 0)])
    return out


def _check_near(w: Work) -> None:
    """Grains that a wall pushes must be beside it. Where we guessed the wall, and most are, the others are left out."""
    walls = np.flatnonzero(w.links.j < 0)
    gap, r = w.wall_gap(w.links[walls]), w.r[w.links.i[walls]]
    far = gap > 2 * r
    if w.pointed or not far.any():
        return
    side = int(np.bincount(-1 - w.links.j[walls[far]]).argmax())
    there = w.links.j[walls] == -1 - side
    if w.o.walls == "balance" and 2 * (far & there).sum() <= there.sum():
        w.links = w.links[np.setdiff1d(np.arange(len(w.links)), walls[far])]
        w.note(f"{int(far.sum())} boundary grains are farther than a radius from the wall that would push them: this "
               "force is left out")
        return
    worst = float((gap - r)[far & there].max())
    raise bad_file(f"{w.path}: {int((far & there).sum())} of {int(there.sum())} contacts with the "
                   f"{w.side_name(-1 - side)} wall are of grains farther than a radius from it, up to {worst:.3g} d: must "
                   "touch it. Where are the walls: two rings (--set cell=ring), on four sides (--set cell=box, with left, "
                   "right, bottom and top), elsewhere (bottom, top)? --walls none leaves them out")


# ---- forces of walls ------------------------------------------------------------------------------------------------

def _pushing(w: Work, grain: Integers, force: Floats) -> Integers:
    """The walls that push grains. In a box it is the nearest of those that push in the direction of the force."""
    if w.cell == "ring":
        return np.where(dot(force, w.ring_of(w.x[grain])[0]) > 0, -1, -2)
    best = np.where(force[:, w.up] > 0, -1, -2)
    nearest = np.full(len(grain), math.inf)
    for a in range(w.dim if w.cell == "box" else 0):
        wall = np.where(force[:, a] > 0, w.wall_on(a, -1), w.wall_on(a, 1))
        distance = np.where(force[:, a] > 0, w.x[grain, a], w.edge[a] - w.x[grain, a])
        nearer = (force[:, a] != 0) & (distance < nearest)
        best, nearest = np.where(nearer, wall, best), np.where(nearer, distance, nearest)
    return best


def _add_forces(w: Work, grain: Integers, wall: Integers, force: Floats, point: Floats | None) -> tuple[Mask, Mask]:
    """Adds contacts with walls that push grains with these forces, in the units of the file, at these points. Returns
    which of them act from the side, and are left out, and which pull."""
    links = links_of(grain, wall)
    w.place_links(links)
    beside = np.zeros(len(grain), bool) if point is None else _turn_normals(w, links, point)
    w.pointed = w.pointed or point is not None
    along = -dot(force, links.n)
    links.fn, links.ft = along * w.force, (force + along[:, None] * links.n) * w.force
    pulls = (links.fn < 0) & ~beside
    w.links = joined(w.links, links[~beside & ~pulls])
    return beside, pulls


def _turn_normals(w: Work, links: Links, point: Floats) -> Mask:
    """Normals point to the points of contact. Returns which lie at the side."""
    d = point * w.scale - np.array(w.low) - w.x[links.i]
    d[:, w.dim:] = 0
    known = np.isfinite(d[:, 0]) & (length(d) > 0)
    for a in np.flatnonzero(w.periodic[:w.up]):
        d[:, a] -= w.edge[a] * np.rint(d[:, a] / w.edge[a])
    far, along = length(d), np.abs(dot(d, links.n))
    turned = known & (along < (1 - 1e-12) * far)
    links.n[turned] = d[turned] / far[turned, None]
    new = known & np.isnan(links.depth)
    links.depth[new] = w.r[links.i[new]] - far[new]
    beside: Mask = known & (along < 0.7 * far)
    return beside


def _pull_text(w: Work, grain: int) -> str:
    return f"the force of a wall on grain {w.id[grain]} pulls; must push it away from the wall"


# ---- fix wall/gran contacts -----------------------------------------------------------------------------------------

#: grains that a wall touches, its forces, and the points of contact
_Fix = tuple[Integers, Floats, "Floats | None"]


def _find_fix(w: Work, side: int) -> _Fix | None:
    """What the columns f_ID[1] ... f_ID[7] say of a wall: touches, force, point."""
    role = SIDES[side]
    role = w.side_name(-1 - side) if w.side_name(-1 - side) in w.roles.named else role
    names = (w.roles.named[role][0],) if role in w.roles.named else _USUAL[side]
    for name in names:
        columns = [w.grains.column(f"{name}[{k}]") for k in range(1, 8)]
        force, point = ([(columns[first + f], w.roles.axis_sign(f)) for f in w.axis[:w.dim]] for first in (1, 4))
        if columns[0] >= 0 and min(force)[0] >= 0:
            grain = np.flatnonzero(w.grains.finite(columns[0], w.row) != 0)
            rows = w.row[grain]
            return (grain, w.vectors(w.grains, force, rows),
                    w.vectors(w.grains, point, rows) if min(point)[0] >= 0 else None)
    return None


def _place_wall(w: Work, point: Floats | None, side: int) -> None:
    """Takes the position of a wall from its points of contact, if these lie in a plane, and moves the box to it."""
    axis, far = w.axis_of(-1 - side), side % 2
    if point is None or len(point) == 0 or w.cell == "ring" or w.o.given(SIDES[side], w.size_key(axis)):
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


def _read_fixes(w: Work, fixes: dict[int, _Fix]) -> None:
    for side, (_, _, point) in fixes.items():
        _place_wall(w, point, side)
    for side, (grain, force, point) in fixes.items():
        _, pulls = _add_forces(w, grain, np.full(len(grain), -1 - side), force, point)
        if pulls.any():
            raise bad_file(_pull_text(w, grain[pulls][0]))


# ---- a file ---------------------------------------------------------------------------------------------------------

def _read_file(w: Work, sheet: Sheet) -> None:
    ids, axes = w.roles.need(sheet, "id")[0], w.axis[:w.dim]
    at, points = w.roles.vector(sheet, "f", axes), w.roles.vector(sheet, "p", axes)
    if at is None:
        w.roles.need(sheet, "f_x")
        raise bad_file(f"{sheet.file}: no columns for f_x, f_y")
    grain = w.grain_of(sheet.whole(ids))
    if w.report.left_out == 0:
        sheet.refuse(grain < 0, ids, "the id of a grain in the file of grains")
    rows = np.flatnonzero(grain >= 0)
    force = w.vectors(sheet, at, rows)
    point = w.vectors(sheet, points, rows) if points else None
    size = length(force)
    from_side = (np.abs(force[:, w.up]) < 0.5 * size) & (w.cell == "piston" and point is None)
    taken = (size > 0) & ~from_side
    rows, force, point = rows[taken], force[taken], None if point is None else point[taken]
    beside, pulls = _add_forces(w, grain[rows], _pushing(w, grain[rows], force), force, point)
    if pulls.any():
        row = int(rows[pulls][0])
        raise bad_file(f"{sheet.file}:{sheet.line(row)}: {_pull_text(w, grain[row])}")
    left_out = int(beside.sum()) + int(from_side.sum())
    if left_out > 0:
        w.note(f"{left_out} contacts with side walls are left out")


# ---- balance --------------------------------------------------------------------------------------------------------

def _balance(w: Work) -> None:
    """Grains at the boundary are pushed by walls that the file does not list: with the force that they lack."""
    if not w.has_forces:
        raise bad_option(f"--walls balance: {w.path} has no forces; must have them")
    mean = running_sum(w.links.fn / len(w.links))
    old, lack = w.links, _lack(w)
    size = length(lack)
    pushed = size > 0.05 * mean
    known = w.balanced = w.cell == "ring" or all(w.has_wall[side] for side in w.sides)
    if known:
        if not w.boundary.any():  # the file does not mark them
            gaps = [w.wall_gap(links_of(np.arange(w.n), np.full(w.n, -1 - side))) for side in w.sides]
            w.boundary = np.min(gaps, axis=0) < 1.5 * w.r
        others = size[~w.boundary]
        pushed = size > min(0.05 * mean, 5 * float(np.median(others)) if len(others) else math.inf)  # beyond their noise
    grain = np.flatnonzero(pushed & w.boundary)
    links, aside = (_of_known if known else _of_flat)(w, grain, lack[grain])
    w.links = joined(old, links)
    if aside > 0:
        why = "not pushed by a wall beside them" if known else "pushed from the side"
        w.note(f"{aside} boundary grains are {why}: this force is left out")
    inner = int(((size > 0.05 * mean) & ~w.boundary).sum())
    if inner > 0:
        w.note(f"{inner} grains that are not marked as boundary lack more than 5% of the mean force")


def _lack(w: Work) -> Floats:
    """The net force of the contacts on each grain [n][3], which something else must balance."""
    c = w.links
    return sum_over(c.i, c.j, w.n, np.where(np.isfinite(c.ft), c.ft, 0) - c.fn[:, None] * c.n)


def _balanced(w: Work, walls: Links) -> Links:
    """Contacts with walls of which the file has no forces: with those that balance the grains at them, if all others
    are in balance."""
    lack, mean = _lack(w), running_sum(w.links.fn / max(1, len(w.links)))
    if w.gravity != 0:
        lack[:, w.up] -= w.gravity * (sphere_mass(w.r) if w.mass is None else w.mass)
    here = np.bincount(walls.i, minlength=w.n)
    held = (here == 0) & (np.bincount(w.links.i, minlength=w.n) + np.bincount(w.links.j[w.links.j >= 0], minlength=w.n) > 1)
    moved = float(np.median(length(lack[held]))) / mean if held.any() else math.inf
    if not moved < 0.05:
        w.note(f"grains away from walls lack {moved:.2g} of the mean force: no balance tells the forces of walls")
        return walls[walls.depth > 0]
    push = dot(lack[walls.i], walls.n)
    told = push > 1e-4 * mean
    walls.fn = np.where(told, push, NAN)
    alone = told & (here[walls.i] == 1)
    walls.ft[alone] = push[alone, None] * walls.n[alone] - lack[walls.i[alone]]
    w.balanced = bool(told.any())
    if w.balanced:
        w.note(f"{int(told.sum())} forces of walls are not in the file: from the balance of the grains at them")
    return walls[told | (walls.depth > 0)]


def _of_flat(w: Work, grain: Integers, lack: Floats) -> tuple[Links, int]:
    """Contacts of grains with the walls to which their contacts push them, and how many are pushed to the side."""
    axis, size = largest_axis(w, lack), length(lack)
    along = lack[np.arange(len(lack)), axis]
    to = np.abs(along) >= 0.5 * size
    links = links_of(grain[to], [w.wall_on(a, value) for a, value in zip(axis[to].tolist(), along[to].tolist())])
    links.fn, links.n, links.ft = size[to], lack[to] / size[to, None], np.zeros((len(links), 3))
    return links, int((~to).sum())


def _of_known(w: Work, grain: Integers, lack: Floats) -> tuple[Links, int]:
    """The same with walls that are known, along their normals: the nearest, and a second one in a corner where the places
    say so or friction at the first is too weak. The rest is tangential, but with two."""
    out, r, slips = links_of([], []), w.r[grain], np.zeros(len(grain), bool)
    every = [links_of(grain, np.full(len(grain), -1 - side)) for side in w.sides]
    gaps = np.array([w.wall_gap(links) for links in every])
    for second in (False, True):
        for links, gap in zip(every, gaps):
            w.place_links(links)
            links.fn = dot(lack, links.n)
            links.ft = links.fn[:, None] * links.n - lack
            nearest = gap == gaps.min(axis=0)
            beside = ~nearest & ((gap < r) | (gap < 1.1 * r) & slips) if second else nearest & (gap < 2 * r)
            slips |= nearest & (length(links.ft) > w.o.number("friction") * links.fn)
            out = joined(out, links[beside & (links.fn > 0)])
    to = np.bincount(out.i, out.fn**2, w.n)[grain] >= 0.25 * dot(lack, lack)
    out.ft[np.bincount(out.i, minlength=w.n)[out.i] > 1] = 0
    return out[np.isin(out.i, grain[to])], int((~to).sum())
