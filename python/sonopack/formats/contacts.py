"""Contacts of grains: those that a file lists, those with walls included, or all that overlap."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from .._core import Floats, Integers
from ._faults import bad_file
from .options import RINGS, SIDES, Column
from .sheet import Mask, Sheet
from .work import Links, Work, dot, length, links_of

_WALL = -100  # a wall of which it is not known which: far from the numbers of walls


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
    if w.form == "photoelastic":
        links = _leave_out_attractions(w, links)
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
    if w.form == "photoelastic":  # a wall that is not said which: its force follows from the balance
        skip[rows] |= unknown[rows] & (ids < 0)
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
    if w.form == "photoelastic" and len(rows) < len(first) and not w.report.left_out:
        w.note(f"{len(first) - len(rows)} contacts with walls of negative ids are left out: --walls balance finds them")
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
    axis = largest_axis(w, p)
    along = p[np.arange(len(p)), axis]
    links.j[here] = [w.wall_on(a, value) for a, value in zip(axis.tolist(), along.tolist())]
    beside[here] = np.abs(along) < 0.7 * length(p)
    return beside


def largest_axis(w: Work, vectors: Floats) -> Integers:
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


def _leave_out_attractions(w: Work, links: Links) -> Links:
    """Fits of fringes may end with a force below 0, which dry disks cannot have."""
    bad = links.fn < 0
    if bad.any():
        w.note(f"{int(bad.sum())} contacts with a normal force below 0 are left out, of up to "
               f"{-links.fn.min() / np.abs(links.fn).mean():.2g} of the mean force")
    return links[~bad]


def _average_twins(w: Work, links: Links, twin: Mask) -> None:
    """A force that was measured in both disks: the mean of the two."""
    second = np.flatnonzero(twin)
    first = second - 1
    apart = links.fn[second] - links.fn[first]
    w.note(f"{len(second)} contacts are measured in both disks: the mean is taken, from which they differ by "
           f"{0.5 * math.sqrt((apart**2).mean()) / (float(links.fn.mean()) or 1.0):.2g} of the mean force (rms)")
    for values in (links.fn, links.ft):
        values[first] = values[second] = 0.5 * (values[first] + values[second])


def _remove_twins(w: Work, listed: _List, links: Links) -> Links:
    """Removes contacts that are listed once for each grain. Others that come twice are errors."""
    links = links[np.lexsort((links.row, links.j, links.i))]
    twin = np.zeros(len(links), bool)
    twin[1:] = (links.i[1:] == links.i[:-1]) & (links.j[1:] == links.j[:-1])
    first = np.maximum.accumulate(np.where(twin, 0, np.arange(len(links))))
    measured = twin & (links.j >= 0) & (w.form == "photoelastic" and not (twin[1:] & twin[:-1]).any())
    if measured.any():
        _average_twins(w, links, measured)
    known = links.fn[first]
    bad = np.flatnonzero(twin & ~(np.abs(links.fn - known) <= 1e-5 * np.abs(known)) & ~np.isnan(links.fn))
    if len(bad):
        raise bad_file(f"{listed.where(links, bad[0])}: {_pair_text(w, links, bad[0])} touch already in line "
                       f"{listed.sheet.line(int(links.row[first[bad[0]]]))}, with another force")
    if (twin & ~measured).any():
        w.note(f"{int((twin & ~measured).sum())} contacts are listed twice, with the same force: taken once")
    return links[~twin]


# ---- what overlaps --------------------------------------------------------------------------------------------------

def touching(w: Work) -> Links:
    """All pairs of grains that overlap."""
    links = links_of(*_pairs(w))
    w.place_links(links)
    return links


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
