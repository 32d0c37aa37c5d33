"""Which cell a file means, piston, periodic or box, and where its edges are."""
from __future__ import annotations

import math

import numpy as np

from ._faults import bad_file, bad_option
from .options import SIDES
from .work import Work


def find(w: Work) -> None:
    """Decides which kind of cell the file and the options mean, finds it, and moves the grains to it."""
    w.cell = w.o.keys.get("cell") or _choose(w)
    if w.cell != "periodic" and _is_tilted(w):
        raise bad_file(f"{w.path}: a tilted box (xy xz yz); must have right angles in a cell with walls")
    {"periodic": _find_periods, "box": _find_box, "piston": _find_piston}[w.cell](w)
    _check_periods(w)


# ---- which kind -----------------------------------------------------------------------------------------------------

def _choose(w: Work) -> str:
    o, axes = w.o, w.axis[:w.dim]
    if o.given("left", "right", "front", "back"):
        return "box"
    if o.is_on("sides", "open") or o.given("across", "bottom", "top", "height"):
        return "piston"
    flags = [w.grains.periodic[f] for f in axes]
    if flags.count(1) == w.dim or (_is_tilted(w) and flags.count(0) == 0):
        return "periodic"
    return "box" if all(_has_walls(w, a) for a in range(w.dim)) else "piston"


def _is_tilted(w: Work) -> bool:
    return any(w.o.keys.get(key, own) != 0 for key, own in zip(("xy", "xz", "yz"), w.grains.tilt))


def _has_walls(w: Work, a: int) -> bool:
    sheet, f = w.grains, w.axis[a]
    if not sheet.box[f] or sheet.periodic[f] == 1:
        return False
    low, high = sheet.low[f] * w.scale, sheet.high[f] * w.scale
    if sheet.periodic[f] < 0 and a < w.up and not (_lists_wall(w, a, low) and _lists_wall(w, a, high)):
        return False
    return _leans_on(w, a, low, -1) and _leans_on(w, a, high, 1)


def _leans_on(w: Work, a: int, place: float, sign: int) -> bool:
    """Whether grains lean on a face of the box as on a wall: some touch it, and none lies deeper than half of its radius.
    Grains at a periodic face, or at that of a box which is as large as the centres need, do lie deeper."""
    depth = w.r - sign * (place - w.x[:, a])
    return bool((depth <= 0.5 * w.r).all() and (depth > 0).any())


def _lists_wall(w: Work, a: int, place: float) -> bool:
    """MercuryDPM lists contacts with walls as those with negative numbers, and where they are."""
    sheet = w.contacts
    if w.form != "mercury" or sheet is None or sheet.rows == 0:
        return False
    id1, id2, point = w.roles.find(sheet, "id1"), w.roles.find(sheet, "id2"), w.roles.vector(sheet, "p", w.axis[:w.dim])
    if id1 is None or id2 is None or point is None:
        return False
    at_wall = (sheet.values[:, id1[0]] < 0) | (sheet.values[:, id2[0]] < 0)
    column, sign = point[a]
    return bool((np.abs(sign * sheet.values[at_wall, column] * w.scale - place) < 0.1).any())


# ---- periodic cells -------------------------------------------------------------------------------------------------

def _find_periods(w: Work) -> None:
    """The box of a periodic cell."""
    for a in range(w.dim):
        _find_edge(w, a)
    for b in range(1, w.dim):
        for a in range(b):
            w.tilt[a + b - 1] = _find_tilt(w, a, b)
    _reduce_tilt(w)
    tilted = f", tilted by {w.tilt[0]:.6g}, {w.tilt[1]:.6g}, {w.tilt[2]:.6g} d" if any(w.tilt) else ""
    w.note(f"cell: periodic along all axes{tilted}")
    _move(w, range(w.dim))


def _move(w: Work, axes: range) -> None:
    for a in axes:
        w.x[:, a] -= w.low[a]


def _find_edge(w: Work, a: int) -> None:
    """The edge along an axis: from the options, or the box of the file."""
    sheet, f, key = w.grains, w.axis[a], w.size_key(a)
    given = w.o.number(key)
    if not math.isfinite(given) and not sheet.box[f]:
        raise bad_option(f": {w.path} has no box along {'xyz'[f]}; must be given, --set {key}=LENGTH for the period in the "
                         "file's units", key)
    w.low[a] = sheet.low[f] * w.scale if sheet.box[f] else 0.0
    w.edge[a] = given * w.scale if math.isfinite(given) else (sheet.high[f] - sheet.low[f]) * w.scale
    w.periodic[a] = True
    if not w.edge[a] > 0:
        raise bad_option(f" = {given:g}: must be positive", key)


def _find_tilt(w: Work, a: int, b: int) -> float:
    """The component along axis a of the lattice vector of axis b. Files have lattice vectors of which the first lies along
    x, the second in the plane of x and y: so must those of the packing."""
    fa, fb = w.axis[a], w.axis[b]
    pair = fa + fb - 1
    value = w.o.keys.get(("xy", "xz", "yz")[pair], w.grains.tilt[pair])
    if value != 0 and (fa > fb or w.roles.axis_sign(fa) < 0 or w.roles.axis_sign(fb) < 0):
        raise bad_option(f"{w.path}: a tilted box whose axes are turned (up, or a minus in --columns): must be x, y, z in this "
                         "order")
    return float(value * w.scale)


def _reduce_tilt(w: Work) -> None:
    """Other lattice vectors of the same lattice, whose tilt is at most half of the edge."""
    tilt, edge = w.tilt, w.edge
    tilt[0] -= edge[0] * float(np.rint(tilt[0] / edge[0]))
    if w.dim == 3:
        turns = float(np.rint(tilt[2] / edge[1]))
        tilt[2] -= edge[1] * turns
        tilt[1] -= tilt[0] * turns
        tilt[1] -= edge[0] * float(np.rint(tilt[1] / edge[0]))


def _check_periods(w: Work) -> None:
    """Refuses periods in which two grains could touch twice."""
    largest = float((2 * w.r).max())
    for a in range(w.dim):
        if w.periodic[a] and not w.open[a] and w.edge[a] <= 2 * largest:
            raise bad_option(f": the period along {w.name_of(a)} is {w.edge[a] / w.scale:.6g}; must be more than two of the "
                             f"largest grains, {2 * largest / w.scale:.6g}: in a smaller cell two grains could touch twice",
                             w.size_key(a))


# ---- walls on all sides ---------------------------------------------------------------------------------------------

def _find_box(w: Work) -> None:
    for a in range(w.dim):
        _find_two_walls(w, a)
    w.note("cell: a box with walls on all sides; --set sides=open leaves those beside out")
    _move(w, range(w.dim))


def _find_two_walls(w: Work, a: int) -> None:
    """The two walls of an axis: from the options, or the faces of the box. Photoelastic disks have neither: the walls are
    then where the outermost disks end, and their overlaps are not known."""
    sheet, f = w.grains, w.axis[a]
    size = w.o.number(w.size_key(a))
    place = [0.0, 0.0]
    for side in (0, 1):
        wall = w.wall_on(a, 2 * side - 1)
        given = w.wall_given(wall)
        w.has_wall[-1 - wall] = True
        if math.isfinite(given):
            place[side] = given * w.scale
        elif side == 1 and math.isfinite(size):
            place[side] = place[0] + size * w.scale
        elif sheet.box[f]:
            place[side] = (sheet.high[f] if side else sheet.low[f]) * w.scale
        elif side == 0 and math.isfinite(size):
            place[side] = 0.0
        elif w.form == "photoelastic":
            w.has_wall[-1 - wall] = False
            place[side] = _extent(w, a)[side]
        else:
            key = SIDES[-1 - wall]
            raise bad_option(f": {w.path} has no box along {'xyz'[f]}; must be given, --set {key}=PLACE in the file's units",
                             key)
    w.low[a], w.edge[a] = place[0], place[1] - place[0]
    if not w.edge[a] > 0:
        raise bad_option(f": this wall at {place[1] / w.scale:g} lies below the opposite one at {place[0] / w.scale:g}",
                         SIDES[-1 - w.wall_on(a, 1)])


def _extent(w: Work, a: int) -> tuple[float, float]:
    return float((w.x[:, a] - w.r).min()), float((w.x[:, a] + w.r).max())


# ---- under a piston -------------------------------------------------------------------------------------------------

def _find_piston(w: Work) -> None:
    """Periods beside the axis up, and walls on it."""
    sheet, up = w.grains, w.up
    f = w.axis[up]
    turned = sheet.periodic[f] == 1 and not w.o.given("bottom", "top")
    for a in range(up):
        _find_period(w, a)
    if turned and not w.o.given("across"):
        raise bad_option(f": {w.path} is periodic along {'xyz'[f]} too, where a piston has walls: --set across=drop cuts it at "
                         "the face of the box and leaves out the contacts across, --set up=AXIS takes another axis, --set "
                         "cell=periodic keeps it", "across")
    low, high = _piston_walls(w, turned)
    w.low[up], w.edge[up] = low, high - low
    w.periodic[up] = w.cut = turned
    if not w.edge[up] > 0:
        raise bad_option(f": the upper wall at {high / w.scale:g} lies below the lower at {low / w.scale:g}", "top")
    _move(w, range(up, w.dim))


def _piston_walls(w: Work, turned: bool) -> tuple[float, float]:
    """Places of the two walls: from the options, or faces of the box, else where the outermost grains end."""
    sheet, f = w.grains, w.axis[w.up]
    ends = (sheet.low[f] * w.scale, sheet.high[f] * w.scale)
    given = [w.o.number(key) for key in ("bottom", "top")]
    place = list(_extent(w, w.up))
    for side in (0, 1):
        w.has_wall[side] = math.isfinite(given[side]) or (sheet.box[f] and sheet.periodic[f] != 1)
        if w.has_wall[side]:
            place[side] = given[side] * w.scale if math.isfinite(given[side]) else ends[side]
    if turned:
        return ends
    if w.o.given("height"):
        place[1] = place[0] + w.o.number("height") * w.scale
        w.has_wall[1] = True
    return place[0], place[1]


def _find_period(w: Work, a: int) -> None:
    sheet, f, key = w.grains, w.axis[a], w.size_key(a)
    given, name = w.o.number(key), "xyz"[w.axis[a]]
    w.periodic[a] = True
    if math.isfinite(given):
        w.low[a] = sheet.low[f] * w.scale if sheet.box[f] else 0.0
        w.edge[a] = given * w.scale
    elif w.o.is_on("sides", "open") or w.form == "photoelastic":
        _open_side(w, a)
        w.note(f"{name}: no period; the box is {w.edge[a]:.6g} d wide, half a diameter more than the grains")
    elif sheet.box[f] and sheet.periodic[f] == 0:
        _open_side(w, a)
        w.note(f"{name} is not periodic in the file: contacts with side walls are not taken, the box is {w.edge[a]:.6g} d wide, "
               "half a diameter more than the grains")
    elif sheet.box[f]:
        w.low[a], w.edge[a] = sheet.low[f] * w.scale, (sheet.high[f] - sheet.low[f]) * w.scale
        if sheet.periodic[f] < 0:
            w.note(f"{name}: taken as periodic, {w.edge[a]:.6g} d; --set sides=open if it is not")
    else:
        raise bad_option(f": {w.path} has no box along {name}; must be given, --set {key}=LENGTH for the period in the file's "
                         "units, or --set sides=open if there is none", key)
    if not w.edge[a] > 0:
        raise bad_option(f" = {given:g}: must be positive", key)
    _move(w, range(a, a + 1))


def _open_side(w: Work, a: int) -> None:
    """Without a period the box is wider than the grains, so that none touches another across its sides."""
    low, high = _extent(w, a)
    w.low[a], w.edge[a] = low - 0.25, high - low + 0.5
    w.periodic[a] = w.open[a] = True
