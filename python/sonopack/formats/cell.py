"""Which cell a file means, piston, periodic or box, and where its edges are."""
from __future__ import annotations

import math

import numpy as np

from ._faults import bad_file, bad_option
from .options import SIDES
from .work import Work

_TILTS = ("xy", "xz", "yz")


def find(w: Work) -> None:
    """Decides which kind of cell the file and the options mean, finds it, and moves the grains to it."""
    w.cell = w.o.keys.get("cell") or _choose(w)
    if w.cell != "periodic" and _is_tilted(w):
        raise bad_file(f"{w.path}: a tilted box (xy xz yz); must have right angles in a cell with walls")
    {"periodic": _find_periods, "box": _find_box, "piston": _find_piston}[w.cell](w)
    for a in range(w.dim):
        w.x[:, a] -= w.low[a]
    _check_periods(w)


# ---- which kind -----------------------------------------------------------------------------------------------------

def _choose(w: Work) -> str:
    if w.o.given("left", "right", "front", "back"):
        return "box"
    if w.o.keys.get("sides") == "open" or w.o.given("across", "bottom", "top", "height"):
        return "piston"
    flags = [w.grains.periodic[f] for f in w.axis[:w.dim]]
    if flags.count(1) == w.dim or (_is_tilted(w) and flags.count(0) == 0):
        return "periodic"
    return "box" if all(_has_walls(w, a) for a in range(w.dim)) else "piston"


def _is_tilted(w: Work) -> bool:
    return any(w.o.keys.get(key, own) != 0 for key, own in zip(_TILTS, w.grains.tilt))


def _ends(w: Work, a: int) -> tuple[float, float]:
    """The faces of the file's box on an axis."""
    f = w.axis[a]
    return w.grains.low[f] * w.scale, w.grains.high[f] * w.scale


def _extent(w: Work, a: int) -> tuple[float, float]:
    """Where the outermost grains end."""
    return float((w.x[:, a] - w.r).min()), float((w.x[:, a] + w.r).max())


def _has_walls(w: Work, a: int) -> bool:
    sheet, f = w.grains, w.axis[a]
    if not sheet.box[f] or sheet.periodic[f] == 1:
        return False
    ends = _ends(w, a)
    if sheet.periodic[f] < 0 and a < w.up and not all(_lists_wall(w, a, place) for place in ends):
        return False
    return all(_leans_on(w, a, place, sign) for place, sign in zip(ends, (-1, 1)))


def _leans_on(w: Work, a: int, place: float, sign: int) -> bool:
    """Whether grains lean on a face of the box as on a wall: some touch it, and none lies deeper than half of its
    radius. Grains at a periodic face, or at that of a box which is as large as the centres need, do lie deeper."""
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
    at_wall = (sheet.values[:, [id1[0], id2[0]]] < 0).any(axis=1)
    column, sign = point[a]
    return bool((np.abs(sign * sheet.values[at_wall, column] * w.scale - place) < 0.1).any())


# ---- periods --------------------------------------------------------------------------------------------------------

def _find_periods(w: Work) -> None:
    """The box of a periodic cell."""
    for a in range(w.dim):
        if not _given_period(w, a) and not _period_of_file(w, a):
            raise _no_box(w, a, w.size_key(a), "LENGTH for the period in the file's units")
        _check_edge(w, a)
    for b in range(1, w.dim):
        for a in range(b):
            w.tilt[a + b - 1] = _find_tilt(w, a, b)
    _reduce_tilt(w)
    tilted = f", tilted by {w.tilt[0]:.6g}, {w.tilt[1]:.6g}, {w.tilt[2]:.6g} d" if any(w.tilt) else ""
    w.note(f"cell: periodic along all axes{tilted}")


def _no_box(w: Work, a: int, key: str, what: str) -> Exception:
    return bad_option(f": {w.path} has no box along {w.name_of(a)}; must be given, --set {key}={what}", key)


def _given_period(w: Work, a: int) -> bool:
    """Takes the period of an option."""
    given = w.o.number(w.size_key(a))
    w.periodic[a] = True
    w.low[a] = _ends(w, a)[0] if w.grains.box[w.axis[a]] else 0.0
    w.edge[a] = given * w.scale
    return math.isfinite(given)


def _period_of_file(w: Work, a: int) -> bool:
    """Takes the box of the file."""
    f = w.axis[a]
    w.low[a], w.edge[a] = w.grains.low[f] * w.scale, (w.grains.high[f] - w.grains.low[f]) * w.scale
    return w.grains.box[f]


def _check_edge(w: Work, a: int) -> None:
    key = w.size_key(a)
    if not w.edge[a] > 0:
        raise bad_option(f" = {w.o.number(key):g}: must be positive", key)


def _find_tilt(w: Work, a: int, b: int) -> float:
    """The component along axis a of the lattice vector of axis b. Files have lattice vectors of which the first lies
    along x, the second in the plane of x and y: so must those of the packing."""
    fa, fb = w.axis[a], w.axis[b]
    value = w.o.keys.get(_TILTS[fa + fb - 1], w.grains.tilt[fa + fb - 1])
    if value != 0 and (fa > fb or w.roles.axis_sign(fa) < 0 or w.roles.axis_sign(fb) < 0):
        raise bad_option(f"{w.path}: a tilted box whose axes are turned (up, or a minus in --columns): must be x, y, z in "
                         "this order")
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
            raise bad_option(f": the period along {w.name_of(a)} is {w.edge[a] / w.scale:.6g}; must be more than two of "
                             f"the largest grains, {2 * largest / w.scale:.6g}: in a smaller cell two grains could touch "
                             "twice", w.size_key(a))


# ---- walls on all sides ---------------------------------------------------------------------------------------------

def _find_box(w: Work) -> None:
    for a in range(w.dim):
        _set_walls(w, a, _find_wall(w, a, 0), _find_wall(w, a, 1))
    w.note("cell: a box with walls on all sides; --set sides=open leaves those beside out")


def _set_walls(w: Work, a: int, low: float, high: float) -> None:
    w.low[a], w.edge[a] = low, high - low
    if not w.edge[a] > 0:
        raise bad_option(f": this wall at {high / w.scale:g} lies below the opposite one at {low / w.scale:g}",
                         SIDES[-1 - w.wall_on(a, 1)])


def _find_wall(w: Work, a: int, side: int) -> float:
    """The place of a wall: from the options, or a face of the box. Under a piston, and of photoelastic disks, where there
    may be neither, it is where the outermost grains end, and their overlaps are not known."""
    wall, f, box = w.wall_on(a, 2 * side - 1), w.axis[a], w.cell == "box"
    given, size = w.o.number(SIDES[-1 - wall]), w.o.number(w.size_key(a))
    w.has_wall[-1 - wall] = True
    if math.isfinite(given):
        return given * w.scale
    if side == 1 and math.isfinite(size):
        return _find_wall(w, a, 0) + size * w.scale
    if w.grains.box[f] and (box or w.grains.periodic[f] != 1):
        return _ends(w, a)[side]
    if box and math.isfinite(size):
        return 0.0
    if box and w.form != "photoelastic":
        raise _no_box(w, a, SIDES[-1 - wall], "PLACE in the file's units")
    w.has_wall[-1 - wall] = False
    return _extent(w, a)[side]


# ---- under a piston -------------------------------------------------------------------------------------------------

def _find_piston(w: Work) -> None:
    """Periods beside the axis up, and walls on it."""
    up, name = w.up, w.name_of(w.up)
    turned = w.grains.periodic[w.axis[up]] == 1 and not w.o.given("bottom", "top")
    for a in range(up):
        _find_period(w, a)
        _check_edge(w, a)
    if turned and not w.o.given("across"):
        raise bad_option(f": {w.path} is periodic along {name} too, where a piston has walls: --set across=drop cuts it at "
                         "the face of the box and leaves out the contacts across, --set up=AXIS takes another axis, "
                         "--set cell=periodic keeps it", "across")
    if turned:
        _set_walls(w, up, *_ends(w, up))
    else:
        _set_walls(w, up, _find_wall(w, up, 0), _find_wall(w, up, 1))
    w.periodic[up] = w.cut = turned


def _find_period(w: Work, a: int) -> None:
    sheet, f, key, name = w.grains, w.axis[a], w.size_key(a), w.name_of(a)
    if _given_period(w, a):
        return
    if w.o.keys.get("sides") == "open" or w.form == "photoelastic":
        w.note(f"{name}: no period; the box is {_open_side(w, a):.6g} d wide, half a diameter more than the grains")
    elif sheet.box[f] and sheet.periodic[f] == 0:
        w.note(f"{name} is not periodic in the file: contacts with side walls are not taken, the box is "
               f"{_open_side(w, a):.6g} d wide, half a diameter more than the grains")
    elif not _period_of_file(w, a):
        raise _no_box(w, a, key, "LENGTH for the period in the file's units, or --set sides=open if there is none")
    elif sheet.periodic[f] < 0:
        w.note(f"{name}: taken as periodic, {w.edge[a]:.6g} d; --set sides=open if it is not")


def _open_side(w: Work, a: int) -> float:
    """Without a period the box is wider than the grains, so that none touches another across its sides."""
    low, high = _extent(w, a)
    w.low[a], w.edge[a], w.open[a] = low - 0.25, high - low + 0.5, True
    return w.edge[a]
