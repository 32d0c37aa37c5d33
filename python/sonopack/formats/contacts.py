"""Reads the contacts that a file lists."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from .._core import Floats, Integers
from . import touch
from ._faults import bad_file
from .options import SIDES, Column
from .sheet import Sheet
from .work import Links, Work, dot, length

_WALL = -100  # a wall of which it is not known which: far from the numbers of walls


def read(w: Work) -> None:
    """The contacts of the list, or all pairs that overlap."""
    if w.contacts is not None:
        _read_list(w, w.contacts)
    else:
        w.links = touch.grains(w)
    if w.report.across > 0:
        w.note(f"{w.report.across} contacts across the face of the box along {w.name_of(w.up)} are left out")
    if w.contacts is None:
        w.note("contacts: all pairs that overlap")


@dataclasses.dataclass
class _Columns:
    """The columns of a list of contacts."""

    id1: Column
    id2: Column
    numbers: dict[str, Column | None]  # overlap, fn, ft, kn, kt
    vectors: dict[str, list[Column] | None]  # fn, f, ft, t, p


def _find_columns(w: Work, sheet: Sheet) -> _Columns:
    axes = w.axis[:w.dim]
    found = _Columns(w.roles.need(sheet, "id1"), w.roles.need(sheet, "id2"),
                     {role: w.roles.find(sheet, role) for role in ("overlap", "fn", "ft", "kn", "kt")},
                     {role: w.roles.vector(sheet, role, axes) for role in ("fn", "f", "ft", "t", "p")})
    ft = found.numbers["ft"]
    if ft is not None and found.vectors["t"] is None and w.dim == 2 and "ft" not in w.roles.named:  # t turns when one axis does
        found.numbers["ft"] = ft[0], ft[1] * w.roles.axis_sign(axes[0]) * w.roles.axis_sign(axes[1])
    return found


def _read_list(w: Work, sheet: Sheet) -> None:
    columns = _find_columns(w, sheet)
    links, turn, beside = _read_pairs(w, sheet, columns)
    w.place_links(links)
    _read_numbers(w, sheet, columns, links)
    sense = _read_vectors(w, sheet, columns, links, turn)
    with np.errstate(invalid="ignore"):  # pairs of neighbours that do not touch are left out
        apart = ~(links.depth > 0)
        links = links.take(~((links.fn == 0) & apart | np.isnan(links.fn) & apart & ~(links.overlap > 0)))
    across = w.goes_across(links.i, links.j)
    w.report.across += int(across.sum())
    links = links.take(~across)
    if not (links.j >= 0).any():
        raise bad_file(f"{sheet.file}: lists no contact between two grains of {w.path}; --contacts overlap finds them")
    _turn_sense(w, sheet, links, sense)
    w.links = _remove_twins(w, sheet, links)
    vector = columns.vectors["f"] or columns.vectors["fn"]
    force = vector[0] if vector else columns.numbers["fn"]
    w.has_forces = force is not None
    w.has_ft = bool(columns.vectors["ft"] or columns.vectors["f"] or columns.numbers["ft"])
    w.force_place = math.nan if force is None else math.pow(10, 1 - min(sheet.digits([force[0]])[0], 17))
    if beside > 0:
        w.note(f"{beside} contacts with side walls are left out")


# ---- grains and walls -----------------------------------------------------------------------------------------------

def _find_grains(w: Work, sheet: Sheet, column: int) -> tuple[Integers, np.ndarray]:  # type: ignore[type-arg]
    """Grains or walls of a column of ids; and which belong to a type that was left out. Walls have negative ids in
    MercuryDPM, and may be named: bottom, top, left, ..."""
    values = sheet.values[:, column]
    grain = np.full(sheet.rows, _WALL, np.int64)
    named = np.flatnonzero(np.isnan(values))
    words = sheet.words(column) if len(named) else []
    for row in named:
        side = SIDES.index(words[row]) if words[row] in SIDES else -1
        if side < 0 or not w.has_side(-1 - side):
            sheet.fail(int(row), column, "a whole number")
        grain[row] = -1 - side
    rows = np.flatnonzero(~np.isnan(values))
    ids = sheet.whole(column, rows)
    found = w.grain_of(ids)
    own = w.form == "csv" and np.isin(ids, [wall for wall in range(-6, 0) if w.has_side(wall)])  # written by us
    found = np.where(found >= 0, found, np.where(own, ids, _WALL))
    grain[rows] = found
    unknown = np.zeros(sheet.rows, bool)
    unknown[rows] = found == _WALL
    skip = unknown & (w.report.left_out > 0)
    bad = unknown & ~skip
    if w.form == "mercury":
        bad[rows] &= ids >= 0
    if bad.any():
        sheet.fail(int(np.flatnonzero(bad)[0]), column, "the id of a grain in the file of grains")
    return grain, skip


def _read_pairs(w: Work, sheet: Sheet, columns: _Columns) -> tuple[Links, Floats, int]:
    """The grains of each row, i < j or j a wall; the sign of what acts on the first of the row; and how many contacts with
    side walls are left out."""
    first, skip1 = _find_grains(w, sheet, columns.id1[0])
    second, skip2 = _find_grains(w, sheet, columns.id2[0])
    rows = np.flatnonzero(~(skip1 | skip2))
    first, second = first[rows], second[rows]
    for bad, rule in ((first == second, "another grain than the first"),
                      ((first < 0) & (second < 0), "a grain, if the first is a wall")):
        if bad.any():
            sheet.fail(int(rows[np.flatnonzero(bad)[0]]), columns.id2[0], rule)
    swap = (first < 0) | ((second >= 0) & (first > second))
    links = Links(len(rows))
    links.i, links.j, links.row = np.where(swap, second, first), np.where(swap, first, second), rows
    turn = np.where(swap, -1.0, 1.0)
    beside = _place_at_walls(w, sheet, columns, links)
    return links.take(~beside), turn[~beside], int(beside.sum())


def _place_at_walls(w: Work, sheet: Sheet, columns: _Columns, links: Links) -> np.ndarray:  # type: ignore[type-arg]
    """Contacts with a wall that the list has: which one, by where the contact lies. Returns which are at side walls, or at
    edges, and are left out."""
    beside = np.zeros(len(links), bool)
    here = np.flatnonzero(links.j == _WALL)
    if len(here) == 0:
        return beside
    if columns.vectors["p"] is None:
        raise bad_file(f"{sheet.file}:{sheet.line(int(links.row[here[0]]))}: a contact with a wall without the point of "
                       "contact, p_x p_y")
    p = w.vectors(sheet, columns.vectors["p"], links.row[here])
    p = p * w.scale - np.array(w.low) - w.x[links.i[here]]
    p[:, w.dim:] = 0
    axis = np.full(len(here), w.up)
    for a in range(w.up if w.cell == "box" else 0):
        axis = np.where(np.abs(p[:, a]) > np.abs(p[np.arange(len(p)), axis]), a, axis)
    along = p[np.arange(len(p)), axis]
    links.j[here] = [w.wall_on(int(a), float(value)) for a, value in zip(axis, along)]
    beside[here] = np.abs(along) < 0.7 * length(p)
    return beside


# ---- numbers and vectors --------------------------------------------------------------------------------------------

def _read_numbers(w: Work, sheet: Sheet, columns: _Columns, links: Links) -> None:
    spring = w.force / w.scale
    for name, unit in (("overlap", w.scale), ("kn", spring), ("kt", spring), ("fn", w.force)):
        values = w.column(sheet, columns.numbers[name], links.row)
        if values is not None:
            setattr(links, name, values * unit)


def _read_vectors(w: Work, sheet: Sheet, columns: _Columns, links: Links, turn: Floats) -> float:
    """The vectors of the rows, turned to act on grain i. Normal forces are taken along n, whatever their sense, which is
    returned."""
    sense, vectors = 0.0, columns.vectors
    given = vectors["f"] or vectors["fn"]
    if given:
        f = w.vectors(sheet, given, links.row)
        along = -turn * dot(f, links.n) * w.force
        sense = float(along.sum())
        links.fn = along
        if vectors["f"]:
            links.ft = turn[:, None] * f * w.force + along[:, None] * links.n
    if vectors["ft"]:
        links.ft = turn[:, None] * w.vectors(sheet, vectors["ft"], links.row) * w.force
    size = None if vectors["ft"] or vectors["f"] else w.column(sheet, columns.numbers["ft"], links.row)
    if size is None:
        return sense
    if vectors["t"]:
        t = w.vectors(sheet, vectors["t"], links.row)
    elif w.dim == 2:  # along t, which turns with n
        t = np.stack([-turn * links.n[:, 1], turn * links.n[:, 0], 0 * turn], axis=1)
    else:
        raise bad_file(f"{sheet.file}: column {sheet.names[columns.numbers['ft'][0]]} alone; in three dimensions tangential "  # type: ignore[index]
                       "forces must be vectors, ft_x ft_y ft_z")
    links.ft = (turn * size)[:, None] * t * w.force
    return sense


# ---- the whole list -------------------------------------------------------------------------------------------------

def _pair_text(w: Work, links: Links, k: int) -> str:
    return f"grains {w.id[links.i[k]]} and {w.id[links.j[k]] if links.j[k] >= 0 else -1}"


def _turn_sense(w: Work, sheet: Sheet, links: Links, sense: float) -> None:
    """Forces on the second grain instead of the first are turned. Negative ones that remain are attractions."""
    if sense < 0:
        links.fn, links.ft = -links.fn, -links.ft
    bad = np.flatnonzero(links.fn < 0)
    if len(bad):
        k = int(bad[0])
        raise bad_file(f"{sheet.file}:{sheet.line(int(links.row[k]))}: the normal force of {_pair_text(w, links, k)} is "
                       f"{links.fn[k] / w.force:.6g}: an attraction; must be >= 0")
    if sense < 0:
        w.note(f"the forces of {sheet.file} act on the second grain of each row: turned")


def _remove_twins(w: Work, sheet: Sheet, links: Links) -> Links:
    """Removes contacts that are listed once for each grain. Others that come twice are errors."""
    links = links.take(np.lexsort((links.row, links.j, links.i)))
    twin = np.zeros(len(links), bool)
    twin[1:] = (links.i[1:] == links.i[:-1]) & (links.j[1:] == links.j[:-1])
    first = np.maximum.accumulate(np.where(twin, 0, np.arange(len(links))))
    fn, known = links.fn, links.fn[first]
    bad = np.flatnonzero(twin & ~(np.abs(fn - known) <= 1e-5 * np.abs(known)) & ~np.isnan(fn))
    if len(bad):
        k = int(bad[0])
        raise bad_file(f"{sheet.file}:{sheet.line(int(links.row[k]))}: {_pair_text(w, links, k)} touch already in line "
                       f"{sheet.line(int(links.row[first[k]]))}, with another force")
    if twin.any():
        w.note(f"{int(twin.sum())} contacts are listed twice, with the same force: taken once")
    return links.take(~twin)
