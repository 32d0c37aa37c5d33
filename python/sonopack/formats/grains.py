"""Takes the grains out of the rows of their file, turns the units, and finds the cell that the file means: piston,
periodic or box, and where its edges are."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from .._core import Floats, Integers
from ._faults import bad_file, bad_option
from .options import RINGS, SIDES
from .work import Work, modulus, running_sum, sphere_mass

_MOST = (2**31 - 1) // 4
_TILTS = ("xy", "xz", "yz")


def gather(w: Work) -> None:
    """The grains, in the units of the packing."""
    _read_ids(w, _choose_rows(w))
    _read_positions(w)
    _choose_axes(w)
    _read_sizes(w)
    _read_masses(w)
    _scale(w)


def _choose_rows(w: Work) -> Integers:
    """The rows of the types wanted."""
    sheet, types = w.grains, w.o.types
    rows = np.arange(sheet.rows)
    if types is not None:
        rows = rows[np.isin(sheet.words(w.roles.need(sheet, "type")[0]), types.split(","))]
    w.report.left_out = sheet.rows - len(rows)
    if len(rows) == 0:
        raise bad_file(f"{sheet.file}: no grain{' of type ' + types if types is not None else '; must be 1 or more'}")
    if len(rows) > _MOST:
        raise bad_file(f"{sheet.file}: {len(rows)} grains; at most {_MOST}")
    return rows


def _read_ids(w: Work, rows: Integers) -> None:
    """Ids number the grains; without them the rows do."""
    sheet, column = w.grains, w.roles.find(w.grains, "id")
    first = w.o.keys.get("first_id", 0 if w.form in ("mercury", "yade") else 1)
    ids = first + rows if column is None else sheet.whole(column[0], rows)
    order = np.argsort(ids, kind="stable")
    w.id, w.row = ids[order], rows[order]
    twice = np.flatnonzero(w.id[1:] == w.id[:-1])
    if len(twice):
        k = int(twice[0])
        raise bad_file(f"{sheet.file}:{sheet.line(int(w.row[k + 1]))}: id {w.id[k]} stands already in line "
                       f"{sheet.line(int(w.row[k]))}; must be there once")


def _read_positions(w: Work) -> None:
    sheet = w.grains
    w.x, scaled = np.zeros((len(w.id), 3)), np.zeros((len(w.id), 3))
    for a, name in enumerate("xyz"):
        at = w.roles.need(sheet, name) if a < 2 else w.roles.find(sheet, name)
        values = w.column(sheet, at, w.row)
        if at is None or values is None:
            continue
        column = sheet.names[at[0]]
        if column[1:2] != "s":
            w.x[:, a] = values
            continue
        if not sheet.box[a]:  # positions xs are fractions of the box
            raise bad_file(f"{sheet.file}: scaled coordinates {column} without a box; must be x y z")
        w.x[:, a] = sheet.low[a] + values * (sheet.high[a] - sheet.low[a])
        scaled[:, a] = (w.x[:, a] - sheet.low[a]) / (sheet.high[a] - sheet.low[a])
    xy, xz, yz = sheet.tilt  # the fractions along y and z move a grain along x too, those along z also along y
    if any(sheet.tilt):
        w.x[:, 0] += xy * scaled[:, 1] + xz * scaled[:, 2]
        w.x[:, 1] += yz * scaled[:, 2]


def _choose_axes(w: Work) -> None:
    """Chooses the dimension and turns the axes, so that the last is the one between the walls."""
    flat = [a for a in range(3) if np.all(w.x[:, a] == w.x[0, a])]  # along which all grains lie in one place
    w.dim = int(w.o.keys.get("dimension", 2 if flat else 3))
    out = -1 if w.dim == 3 else flat[0] if len(flat) == 1 else 2  # the axis that a layer does not have
    up = "xyz".index(w.o.keys.get("up", "z" if w.dim == 3 or out != 2 else "y"))
    if w.dim == 2 and not flat:
        raise bad_option(f"{w.path}: dimension = 2, but the grains do not lie in one plane; must be 3, or a file of "
                         f"one layer")
    if up == out:
        raise bad_option(f"up = {'xyz'[up]}: the grains lie in a plane normal to it; must be one of the others")
    w.axis = [a for a in range(3) if a not in (up, out)] + [up]
    x = np.zeros_like(w.x)
    x[:, :w.dim] = w.x[:, w.axis]
    w.x = x


def _read_sizes(w: Work) -> None:
    radius, diameter = w.roles.find(w.grains, "radius"), w.roles.find(w.grains, "diameter")
    at = radius or diameter or w.roles.need(w.grains, "radius")
    values = w.grains.finite(at[0], w.row) * at[1]
    w.grains.refuse(~(values > 0), at[0], "positive", w.row)
    w.r = values * (1 if radius else 0.5)


def _read_masses(w: Work) -> None:
    sheet = w.grains
    mass, inertia, density, flags = (w.roles.find(sheet, role) for role in ("mass", "inertia", "density", "boundary"))
    of_mass = mass or density
    if of_mass and w.o.keys.get("digits") != "exact":
        w.mass_place = math.pow(10, 1 - min(sheet.digits([of_mass[0]]), 17))
    w.mass, w.inertia = w.column(sheet, mass, w.row), w.column(sheet, inertia, w.row)
    if density and not mass:
        w.mass = sheet.finite(density[0], w.row) * density[1] * sphere_mass(w.r)
    for at, values in ((mass, w.mass), (inertia, w.inertia)):
        if at is not None and values is not None:
            sheet.refuse(~(values > 0), at[0], "positive", w.row)
    w.boundary = np.zeros(w.n, bool) if flags is None else sheet.finite(flags[0], w.row) != 0


# ---- units ----------------------------------------------------------------------------------------------------------

def _scale(w: Work) -> None:
    """Turns the units of the file into d, E* and rho; and estimates what the digits of the positions are worth."""
    o, m = w.o, w.o.material
    mean = running_sum(2 * w.r) / w.n
    w.report.mean_diameter = mean
    d, stress, rho = 1.0, 1.0, 1.0
    if m is not None:
        d = m.diameter if m.diameter > 0 else mean * o.length_unit
        w.material = dataclasses.replace(m, diameter=d)
        stress, rho = modulus(m), m.density
    w.scale = w.report.scale = o.length_unit / d
    w.force = o.force_unit / (stress * d * d)
    w.stiffness = 1 / (stress * d)
    w.place = 0 if o.keys.get("digits") == "exact" else _digits_error(w) * w.scale
    mass = o.mass_unit / (rho * d * d * d)
    w.gravity = o.number("gravity") * w.force / mass if o.given("gravity") else 0.0
    w.x *= w.scale
    w.r = w.r * w.scale
    w.mass = None if w.mass is None else w.mass * mass
    w.inertia = None if w.inertia is None else w.inertia * (mass * w.scale * w.scale)
    if math.isfinite(o.thickness):
        w.mass = math.pi * w.r * w.r * (o.thickness / d)
        w.inertia = 0.5 * w.mass * w.r * w.r
    _check_diameter(w, mean * w.scale, d)


def _digits_error(w: Work) -> float:
    """The error of an overlap from the rounding of two positions and two radii, evenly distributed. All coordinates are
    written with as many digits as the longest of them."""
    sheet, place = w.grains, 0.0
    columns = [w.roles.need(sheet, w.name_of(a))[0] for a in range(w.dim)]
    digits = min(sheet.digits(columns), 17)
    for f, column in zip(w.axis, columns):
        largest = float(np.abs(sheet.values[w.row, column]).max())
        unit = sheet.high[f] - sheet.low[f] if sheet.names[column][1:2] == "s" else 1
        if largest > 0:  # the spacing of numbers of so many digits and of this size
            place = max(place, unit * math.pow(10, math.floor(math.log10(largest)) + 1 - digits))
    return 0.6 * place


def _check_diameter(w: Work, mean: float, d: float) -> None:
    if 0.2 <= mean <= 5:
        return
    if w.o.material is None:
        raise bad_option(f"{w.path}: the mean diameter is {mean:.4g}; must be 0.2 .. 5, since lengths are in mean "
                         "diameters, or the file's units must be given: --material E=...,nu=...,rho=... for metres, "
                         "pascals and kg/m^3, with --length-unit 1e-3 for millimetres")
    raise bad_option(f"{w.path}: the mean diameter is {mean:.4g} times the material's d = {d:g}; must be 0.2 .. 5: "
                     "give no d for the file's mean, or correct --length-unit")


# ---- the cell -------------------------------------------------------------------------------------------------------

def find_cell(w: Work) -> None:
    """Decides which kind of cell the file and the options mean, finds it, and moves the grains to it."""
    w.cell = w.o.keys.get("cell") or _choose(w)
    if w.cell != "periodic" and _is_tilted(w):
        raise bad_file(f"{w.path}: a tilted box (xy xz yz); must have right angles in a cell with walls")
    {"periodic": _find_periods, "box": _find_box, "piston": _find_piston, "ring": _find_ring}[w.cell](w)
    for a in range(w.dim):
        w.x[:, a] -= w.low[a]
    _check_periods(w)


# ---- which kind -----------------------------------------------------------------------------------------------------

def _choose(w: Work) -> str:
    if w.o.given(*RINGS, "x0", "y0", "z0"):
        return "ring"
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
        raise bad_option(f"{w.path}: a tilted box whose axes are turned (up, or a minus in --columns): must be x, y, z "
                         "in this order")
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
            raise bad_option(f": the period along {w.name_of(a)} is {w.edge[a] / w.scale:.6g}; must be more than two "
                             f"of the largest grains, {2 * largest / w.scale:.6g}: in a smaller cell two grains could "
                             "touch twice", w.size_key(a))


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
    """The place of a wall: from the options, or a face of the box. Under a piston, and of photoelastic disks, where
    there may be neither, it is where the outermost grains end, and their overlaps are not known."""
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


# ---- rings ----------------------------------------------------------------------------------------------------------

def _find_ring(w: Work) -> None:
    """Two circles. What is not given is found: the outer circle is the smallest that holds all grains."""
    if w.dim != 2:
        raise bad_option(" = ring: the grains do not lie in one plane; must be a layer", "cell")
    keys = [f"{w.name_of(a)}0" for a in range(2)]
    given = [w.o.number(key) * w.scale for key in keys]
    if w.o.given("x0", "y0", "z0") and not np.isfinite(given).all():
        raise bad_option(f"the centre of a ring: must be given by --set {keys[0]}= and --set {keys[1]}=, or by neither")
    centre = np.array(given) if np.isfinite(given).all() else _middle(w)
    away = np.hypot(*(w.x[:, :2] - centre).T)
    inner, outer = (w.o.number(key) * w.scale for key in RINGS)
    w.has_wall[0], w.has_wall[1] = (bool(np.isfinite(given).all() and math.isfinite(wall)) for wall in (inner, outer))
    inner = inner if math.isfinite(inner) else float((away - w.r).min())
    outer = outer if math.isfinite(outer) else float((away + w.r).max())
    if not 0 < inner < outer:
        raise bad_option(f" = {inner / w.scale:.6g}: must be above 0 and below the outer radius, {outer / w.scale:.6g}",
                         "inner")
    w.low[:2], w.edge[:2] = (centre - outer).tolist(), [2 * outer, outer - inner]
    text = ", ".join(f"{key}={float(value) / w.scale:.8g}" for key, value in zip((*keys, *RINGS), (*centre, inner, outer)))
    w.note(f"cell: a ring, {text}" + ("" if all(w.has_wall[:2]) else "; what is not given is found from the grains"))


def _middle(w: Work) -> Floats:
    """The centre of the smallest circle around all grains, of which a few of the outermost decide."""
    from scipy.optimize import minimize
    x, r = w.x[:, :2], w.r
    start = 0.5 * ((x - r[:, None]).min(axis=0) + (x + r[:, None]).max(axis=0))
    reach = np.hypot(*(x - start).T) + r
    near = reach > reach.max() - 4 * r.max()
    inside = {"type": "ineq", "fun": lambda c: c[2] - np.hypot(*(x[near] - c[:2]).T) - r[near]}
    return np.asarray(minimize(lambda c: c[2], [*start, reach.max()], jac=lambda c: np.array([0.0, 0.0, 1.0]),
                               constraints=inside, method="SLSQP", options={"ftol": 1e-15, "maxiter": 200}).x[:2])


# ---- under a piston -------------------------------------------------------------------------------------------------

def _find_piston(w: Work) -> None:
    """Periods beside the axis up, and walls on it."""
    up, name = w.up, w.name_of(w.up)
    turned = w.grains.periodic[w.axis[up]] == 1 and not w.o.given("bottom", "top")
    for a in range(up):
        _find_period(w, a)
        _check_edge(w, a)
    if turned and not w.o.given("across"):
        raise bad_option(f": {w.path} is periodic along {name} too, where a piston has walls: --set across=drop cuts "
                         "it at the face of the box and leaves out the contacts across, --set up=AXIS takes another "
                         "axis, --set cell=periodic keeps it", "across")
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
