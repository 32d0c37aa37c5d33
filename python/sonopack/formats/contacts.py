"""Contacts of grains: those that a file lists, or all that overlap; and with the walls: by overlaps, from the per-atom
output of fix wall/gran, from a file, or by what is missing in the balance of forces."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from .._core import Floats, Integers
from ._faults import bad_file, bad_option
from .options import NAN, RINGS, SIDES, Column
from .sheet import Mask, Sheet
from .work import Links, Work, dot, joined, length, links_of, running_sum, sphere_mass, sum_over

_WALL = -100  # a wall of which it is not known which: far from the numbers of walls
_USUAL = (("f_floor", "f_bottom", "f_inner"), ("f_roof", "f_top", "f_outer"), ("f_left",), ("f_right",), ("f_front",),
          ("f_back",))


def read(w: Work) -> None:
    """The contacts of the list, or all pairs that overlap."""
    if w.contacts is not None:
        _read_list(w, w.contacts)
    else:
        w.links = _within(w, touching(w))
    if w.report.across > 0:
        w.note(f"{w.report.across} contacts across the face of the box along {w.name_of(w.up)} are left out")
    if w.contacts is None:
        w.note("contacts: all pairs that overlap")


def _within(w: Work, links: Links) -> Links:
    """All but the contacts across the face at which the box is cut."""
    across = w.goes_across(links)
    w.report.across = int(across.sum())
    return links[~across]


@dataclasses.dataclass
class _List:
    """A list of contacts and its columns."""

    sheet: Sheet
    ids: list[Column]
    numbers: dict[str, Column | None]  # overlap, fn, ft, kn, kt
    vectors: dict[str, list[Column] | None]  # fn, f, ft, t, p

    def where(self, links: Links, k: int) -> str:
        """The file and the line of a contact."""
        return f"{self.sheet.file}:{self.sheet.line(int(links.row[k]))}"


def _find_columns(w: Work, sheet: Sheet) -> _List:
    axes = w.axis[:w.dim]
    found = _List(sheet, [w.roles.need(sheet, role) for role in ("id1", "id2")],
                  {role: w.roles.find(sheet, role) for role in ("overlap", "fn", "ft", "kn", "kt")},
                  {role: w.roles.vector(sheet, role, axes) for role in ("fn", "f", "ft", "t", "p")})
    ft = found.numbers["ft"]
    if ft is not None and found.vectors["t"] is None and w.dim == 2 and "ft" not in w.roles.named:
        found.numbers["ft"] = ft[0], ft[1] * w.roles.axis_sign(axes[0]) * w.roles.axis_sign(axes[1])  # t turns with one
    return found


def _read_list(w: Work, sheet: Sheet) -> None:
    listed = _find_columns(w, sheet)
    links, turn, beside = _read_pairs(w, listed)
    w.place_links(links)
    _read_numbers(w, listed, links)
    sense = _read_vectors(w, listed, links, turn)
    apart = ~(links.depth > 0)  # pairs of neighbours that do not touch are left out
    links = links[~((links.fn == 0) & apart | np.isnan(links.fn) & apart & ~(links.overlap > 0))]
    links = _within(w, links)
    if not (links.j >= 0).any():
        raise bad_file(f"{sheet.file}: lists no contact between two grains of {w.path}; --contacts overlap finds them")
    _turn_sense(w, listed, links, sense)
    w.links = _remove_twins(w, listed, links)
    vector = listed.vectors["f"] or listed.vectors["fn"]
    force = vector[0] if vector else listed.numbers["fn"]
    w.has_forces = force is not None
    w.has_ft = bool(listed.vectors["ft"] or listed.vectors["f"] or listed.numbers["ft"])
    w.force_place = math.nan if force is None else math.pow(10, 1 - min(sheet.digits([force[0]]), 17))
    if beside > 0:
        w.note(f"{beside} contacts with side walls are left out")


# ---- grains and walls -----------------------------------------------------------------------------------------------

def _find_grains(w: Work, sheet: Sheet, column: int) -> tuple[Integers, Mask]:
    """Grains or walls of a column of ids; and which belong to a type that was left out. Walls have negative ids in
    MercuryDPM, and may be named: bottom, top, left, ..."""
    values = sheet.values[:, column]
    grain, unknown = np.full(sheet.rows, _WALL, np.int64), np.zeros(sheet.rows, bool)
    named = np.flatnonzero(np.isnan(values))
    if len(named):
        words = np.array(sheet.words(column))[named]
        sides = {side: -1 - k for k, side in enumerate(SIDES) if w.has_side(-1 - k)}
        sides |= {name: -1 - k for k, name in enumerate(RINGS) if w.cell == "ring"}
        sheet.refuse(~np.isin(words, list(sides)), column, "a whole number", named)
        grain[named] = [sides[word] for word in words]
    rows = np.flatnonzero(~np.isnan(values))
    ids = sheet.whole(column, rows)
    found = w.grain_of(ids)
    own = w.form == "csv" and np.isin(ids, [wall for wall in range(-6, 0) if w.has_side(wall)])  # written by us
    grain[rows] = np.where(found >= 0, found, np.where(own, ids, _WALL))
    unknown[rows] = grain[rows] == _WALL
    skip = unknown & (w.report.left_out > 0)
    bad = unknown & ~skip
    if w.form == "mercury":
        bad[rows] &= ids >= 0
    sheet.refuse(bad, column, "the id of a grain in the file of grains")
    return grain, skip


def _read_pairs(w: Work, listed: _List) -> tuple[Links, Floats, int]:
    """The grains of each row, i < j or j a wall; the sign of what acts on the first of the row; and how many contacts
    with side walls are left out."""
    (first, skip1), (second, skip2) = (_find_grains(w, listed.sheet, column) for column, _ in listed.ids)
    rows = np.flatnonzero(~(skip1 | skip2))
    first, second = first[rows], second[rows]
    for bad, rule in ((first == second, "another grain than the first"),
                      ((first < 0) & (second < 0), "a grain, if the first is a wall")):
        listed.sheet.refuse(bad, listed.ids[1][0], rule, rows)
    swap = (first < 0) | ((second >= 0) & (first > second))
    links = links_of(np.where(swap, second, first), np.where(swap, first, second))
    links.row = rows
    beside = _place_at_walls(w, listed, links)
    return links[~beside], np.where(swap, -1.0, 1.0)[~beside], int(beside.sum())


def _place_at_walls(w: Work, listed: _List, links: Links) -> Mask:
    """Contacts with a wall that the list has: which one, by where the contact lies. Returns which are at side walls, or
    at edges, and are left out."""
    beside = np.zeros(len(links), bool)
    here, point = np.flatnonzero(links.j == _WALL), listed.vectors["p"]
    if len(here) == 0:
        return beside
    w.pointed = True
    if point is None:
        raise bad_file(f"{listed.where(links, here[0])}: a contact with a wall without the point of contact, p_x p_y")
    p = w.vectors(listed.sheet, point, links.row[here])
    p = p * w.scale - np.array(w.low) - w.x[links.i[here]]
    p[:, w.dim:] = 0
    if w.cell == "ring":
        links.j[here] = np.where(dot(p, w.ring_of(w.x[links.i[here]])[0]) > 0, -2, -1)
        return beside
    axis = _largest_axis(w, p)
    along = p[np.arange(len(p)), axis]
    links.j[here] = [w.wall_on(a, value) for a, value in zip(axis.tolist(), along.tolist())]
    beside[here] = np.abs(along) < 0.7 * length(p)
    return beside


def _largest_axis(w: Work, vectors: Floats) -> Integers:
    """The axis across the wall to which a vector points: up, and in a box that of its largest component."""
    axis = np.full(len(vectors), w.up)
    size = np.abs(vectors)
    for a in range(w.up if w.cell == "box" else 0):
        axis = np.where(size[:, a] > size[np.arange(len(size)), axis], a, axis)
    return axis


# ---- numbers and vectors --------------------------------------------------------------------------------------------

def _read_numbers(w: Work, listed: _List, links: Links) -> None:
    spring = w.force / w.scale
    for name, unit in (("overlap", w.scale), ("kn", spring), ("kt", spring), ("fn", w.force)):
        values = w.column(listed.sheet, listed.numbers[name], links.row)
        if values is not None:
            setattr(links, name, values * unit)


def _read_vectors(w: Work, listed: _List, links: Links, turn: Floats) -> float:
    """The vectors of the rows, turned to act on grain i. Normal forces are taken along n, whatever their sense, which
    is returned."""
    sense, sheet, vectors = 0.0, listed.sheet, listed.vectors
    given = vectors["f"] or vectors["fn"]
    if given:
        f = w.vectors(sheet, given, links.row)
        links.fn = -turn * dot(f, links.n) * w.force
        sense = float(links.fn.sum())
        if vectors["f"]:
            links.ft = turn[:, None] * f * w.force + links.fn[:, None] * links.n
    if vectors["ft"]:
        links.ft = turn[:, None] * w.vectors(sheet, vectors["ft"], links.row) * w.force
    ft = listed.numbers["ft"]
    if ft is None or vectors["ft"] or vectors["f"]:
        return sense
    if vectors["t"]:
        t = w.vectors(sheet, vectors["t"], links.row)
    elif w.dim == 2:  # along t, which turns with n
        t = np.stack([-turn * links.n[:, 1], turn * links.n[:, 0], 0 * turn], axis=1)
    else:
        raise bad_file(f"{sheet.file}: column {sheet.names[ft[0]]} alone; in three dimensions tangential forces must "
                       "be vectors, ft_x ft_y ft_z")
    links.ft = (turn * (sheet.finite(ft[0], links.row) * ft[1]))[:, None] * t * w.force
    return sense


# ---- the whole list -------------------------------------------------------------------------------------------------

def _pair_text(w: Work, links: Links, k: int) -> str:
    return f"grains {w.id[links.i[k]]} and {w.id[links.j[k]] if links.j[k] >= 0 else -1}"


def _turn_sense(w: Work, listed: _List, links: Links, sense: float) -> None:
    """Forces on the second grain instead of the first are turned. Negative ones that remain are attractions."""
    if sense < 0:
        links.fn, links.ft = -links.fn, -links.ft
    bad = np.flatnonzero(links.fn < 0)
    if len(bad):
        raise bad_file(f"{listed.where(links, bad[0])}: the normal force of {_pair_text(w, links, bad[0])} is "
                       f"{links.fn[bad[0]] / w.force:.6g}: an attraction; must be >= 0")
    if sense < 0:
        w.note(f"the forces of {listed.sheet.file} act on the second grain of each row: turned")


def _remove_twins(w: Work, listed: _List, links: Links) -> Links:
    """Removes contacts that are listed once for each grain. Others that come twice are errors."""
    links = links[np.lexsort((links.row, links.j, links.i))]
    twin = np.zeros(len(links), bool)
    twin[1:] = (links.i[1:] == links.i[:-1]) & (links.j[1:] == links.j[:-1])
    first = np.maximum.accumulate(np.where(twin, 0, np.arange(len(links))))
    known = links.fn[first]
    bad = np.flatnonzero(twin & ~(np.abs(links.fn - known) <= 1e-5 * np.abs(known)) & ~np.isnan(links.fn))
    if len(bad):
        raise bad_file(f"{listed.where(links, bad[0])}: {_pair_text(w, links, bad[0])} touch already in line "
                       f"{listed.sheet.line(int(links.row[first[bad[0]]]))}, with another force")
    if twin.any():
        w.note(f"{int(twin.sum())} contacts are listed twice, with the same force: taken once")
    return links[~twin]


# ---- what overlaps --------------------------------------------------------------------------------------------------

def touching(w: Work) -> Links:
    """All pairs of grains that overlap."""
    links = links_of(*_pairs(w))
    w.place_links(links)
    return links


def _touching_walls(w: Work) -> Links:
    """All grains that overlap the walls whose positions are known."""
    out = links_of([], [])
    for side in np.flatnonzero(w.has_wall):
        links = links_of(np.arange(w.n), np.full(w.n, -1 - side))
        w.place_links(links)
        out = joined(out, links[links.depth > (-3 * w.place if w.has_forces else 0)])
    return out


def _pairs(w: Work) -> tuple[Integers, Integers]:
    """Pairs i < j that overlap, ascending. Near periodic faces the grains have images on the other side."""
    from scipy.spatial import cKDTree
    reach, lattice = 2.0001 * float(w.r.max()), w.lattice()
    x, s, of = w.x, w.fractions(w.x), np.arange(w.n)
    for a in np.flatnonzero(w.periodic[:w.dim]):
        turns = np.floor(s[:, a])
        x, near = x - turns[:, None] * lattice[a], reach / _thickness(w, a)
        s[:, a] -= turns
        first, last = np.flatnonzero(s[:, a] < near), np.flatnonzero(s[:, a] > 1 - near)
        images = np.concatenate([first, last])
        step = np.repeat([1.0, -1.0], [len(first), len(last)])
        x = np.concatenate([x, x[images] + step[:, None] * lattice[a]])
        s, of = np.concatenate([s, s[images]]), np.concatenate([of, of[images]])
    found = cKDTree(x[:, :w.dim], balanced_tree=False, compact_nodes=False).query_pairs(reach, output_type="ndarray")
    found = found[(found < w.n).any(axis=1)]
    i, j = of[found[:, 0]], of[found[:, 1]]
    overlap = (i != j) & (w.r[i] + w.r[j] > length(w.separation(i, j)))
    pair = np.unique(np.minimum(i, j)[overlap] * np.int64(w.n) + np.maximum(i, j)[overlap])
    return pair // w.n, pair % w.n


def _thickness(w: Work, a: int) -> float:
    """Distance between the faces of the box on an axis."""
    return 1 / float(np.linalg.norm(np.linalg.inv(w.lattice()[:w.dim, :w.dim])[:, a]))


# ---- walls ----------------------------------------------------------------------------------------------------------

def read_walls(w: Work) -> None:
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
    axis, size = _largest_axis(w, lack), length(lack)
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
