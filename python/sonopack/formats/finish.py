"""Makes the packing, checks its balance, and says what came out."""
from __future__ import annotations

import math

import numpy as np

from .. import _core
from .._core import Floats, InvalidInput, call
from .._native import ffi, lib
from .._packing import Packing
from . import touch
from ._faults import bad_file, bad_option, refused
from .law import eta, hertz_overlap, stiffness_of, wall_stiffness
from .options import NAN, SIDES
from .work import Links, Work, fractions, length, running_sum, sphere_mass


def make(w: Work) -> Packing:
    """The packing of what has been gathered."""
    x = _wrap(w)
    outside = _axes_outside(w)
    if (outside >= 0).any():
        _fail_outside(w, outside)
    links = w.links
    order = np.lexsort((np.maximum(links.j, 0), links.i, np.maximum(-links.j, 0)))
    wild, w.links = links, links.take(order)
    mass, inertia = _masses(w)
    if usual_stiffness(w.r, w.links, w.wall, w.friction, w.poisson).all():
        w.links.kn, w.links.kt = w.links.kn * 0, w.links.kt * 0
    report = w.report
    report.grains, report.contacts, report.wall_contacts = w.n, len(links), int((links.j < 0).sum())
    pressure = _piston_pressure(w, wild, mass) if w.cell == "piston" else _mean_pressure(w)
    packing = _build(w, x, mass, inertia, pressure)
    _check_balance(w, packing)
    _remark_missing(w)
    _remark_friction(w, pressure)
    _remark_walls(w)
    return packing


def _build(w: Work, x: Floats, mass: Floats | None, inertia: Floats | None, pressure: float) -> Packing:
    links = w.links
    links.n, links.ft = links.n + 0.0, links.ft + 0.0 if w.friction > 0 else links.ft * 0 + 0.0
    try:
        return Packing.from_arrays(
            x[:, :w.dim], w.r, tangents(links, w.dim).table(), box=w.edge[:w.dim], pressure=pressure,
            friction=w.friction,
            poisson=w.poisson, wall=w.wall, mass=mass, inertia=inertia, material=w.material, cell=w.cell, tilt=w.tilt,
            gravity=w.gravity)
    except InvalidInput as fault:
        raise InvalidInput(f"{w.path}: {fault}", fault.status, fault.key) from None


# ---- grains ---------------------------------------------------------------------------------------------------------

def _wrap(w: Work) -> Floats:
    """Positions inside of the cell along its periodic axes; those inside remain the same, bit for bit."""
    x = w.x + 0.0
    if w.cell == "piston":
        for a in range(w.dim):
            if w.periodic[a]:
                inside = np.fmod(x[:, a], w.edge[a])
                inside = np.where(inside < 0, inside + w.edge[a], inside)
                away = ~((x[:, a] >= 0) & (x[:, a] < w.edge[a]))
                x[away, a] = np.where(inside < w.edge[a], inside + 0.0, 0.0)[away]
    if w.cell == "periodic":
        outside = np.zeros(w.n, bool)
        for a in range(w.dim):
            s = fractions(w, x)[a]
            outside |= ~((s >= -1e-12) & (s <= 1 + 1e-12))  # what the packing's check allows
        x[outside] = _wrap_periods(w, x[outside])
    return x


def _wrap_periods(w: Work, x: Floats) -> Floats:
    """Moves points into the cell."""
    vectors = [np.array([w.edge[0], 0, 0]), np.array([w.tilt[0], w.edge[1], 0]),
               np.array([w.tilt[1], w.tilt[2], w.edge[2]])]
    for a in reversed(range(w.dim)):
        x = x - np.floor(fractions(w, x)[a])[:, None] * vectors[a]
        x = x - (fractions(w, x)[a] >= 1)[:, None] * vectors[a]  # a tiny negative coordinate rounds to the far end
    return x


def _axes_outside(w: Work) -> np.ndarray:  # type: ignore[type-arg]
    """The axis on which each grain lies outside of the walls; -1: none."""
    out = np.full(w.n, -1)
    for a in range(w.dim):
        if not w.periodic[a]:
            out[~((w.x[:, a] >= 0) & (w.x[:, a] <= w.edge[a]))] = a
    return out


def _fail_outside(w: Work, outside: np.ndarray) -> None:  # type: ignore[type-arg]
    """Says where the walls are taken to be, and whether anything touches them: loose grains have no walls to find."""
    k = int(np.flatnonzero(outside >= 0)[0])
    axis = int(outside[k])
    low, high = w.low[axis] / w.scale, (w.low[axis] + w.edge[axis]) / w.scale
    first = w.wall_on(axis, -1)
    names = SIDES[-1 - first], SIDES[-first]
    touching = [int((w.links.j == first - side).sum()) for side in (0, 1)]
    pressed = "is this packing under pressure? If so, " if sum(touching) <= 2 else ""
    w.grains.fail(int(w.row[k]), w.roles.need(w.grains, w.name_of(axis))[0],
                  f"between the walls, which are taken to be at {low:.8g} and {high:.8g}. Outside of them are "
                  f"{int((outside == axis).sum())} of {w.n} grains, and {touching[0]} touch the {names[0]} wall, "
                  f"{touching[1]} "
                  f"the {names[1]}: {pressed}give --set {names[0]}= and {names[1]}=, or --types")


def _masses(w: Work) -> tuple[Floats | None, Floats | None]:
    """Masses of spheres of one density are left out: that density is the unit."""
    if w.mass is None or not np.isfinite(w.mass).all():
        return None, None
    usual = 0.4 * w.mass * w.r * w.r
    density = w.mass / sphere_mass(w.r)
    spheres = w.inertia is None or bool((np.abs(w.inertia / usual - 1) < 1e-6).all())
    low, high = (float(density.min()) if spheres else -math.inf), float(density.max())
    place = 1e-6 + min(10 * w.mass_place, 1e-3)
    if high - low <= place * high and (w.material is None or abs(high - 1) < place):
        return None, None
    return not_usual(w.r, w.mass, usual if w.inertia is None else w.inertia)


def near(a: Floats, b: Floats) -> np.ndarray:  # type: ignore[type-arg]
    out: np.ndarray = np.abs(a - b) <= 1e-12 * np.abs(b)  # type: ignore[type-arg]
    return out


def not_usual(r: Floats, mass: Floats, inertia: Floats) -> tuple[Floats | None, Floats | None]:
    """Masses and moments of inertia, unless they are those of spheres of unit density, which say nothing new."""
    usual = sphere_mass(r)
    spheres = near(mass, usual).all() and near(inertia, usual * (0.4 * r * r)).all()
    return (None, None) if spheres else (mass, inertia)


# type: ignore[type-arg]
def usual_stiffness(r: Floats, links: Links, wall: str, friction: float, poisson: float) -> np.ndarray:
    """Which stiffnesses are those of Hertzian spheres anyway, as in our own files, and say nothing new."""
    with np.errstate(invalid="ignore"):
        kn = 2.0 * stiffness_of(r, links, wall) * np.sqrt(links.overlap)
        usual: np.ndarray = (links.kn > 0) & near(links.kn, kn) & (  # type: ignore[type-arg]
            near(links.kt, eta(poisson) * kn) | (not friction > 0))
    return usual


def tangents(links: Links, dim: int) -> Links:
    """In two dimensions tangential forces are Ft (-ny, nx), with a number Ft that our tables give back with all
    bits."""
    if dim == 2:
        links.ft = tangent_vectors(links.n, tangent_numbers(links.n, links.ft))
    return links


def tangent_vectors(n: Floats, scalar: Floats) -> Floats:
    """Ft (-ny, nx), from which tangent_numbers gives the same Ft."""
    ft = _product(n, scalar)
    for k in np.flatnonzero(tangent_numbers(n, ft) != scalar):
        # two neighbouring numbers have the same product: the vector moves by an ulp, to one that is no product
        x, y = (np.array([np.nextafter(v, -np.inf), v, np.nextafter(v, np.inf)]) for v in ft[k, :2])
        moved = np.stack([np.repeat(x, 3), np.tile(y, 3), np.zeros(9)], axis=1)
        good = np.flatnonzero(tangent_numbers(np.tile(n[k], (9, 1)), moved) == scalar[k])
        ft[k] = moved[good[0]] if len(good) else ft[k]
    return ft


def _product(n: Floats, scalar: Floats) -> Floats:
    return np.stack([scalar * -n[:, 1] + 0.0, scalar * n[:, 0] + 0.0, np.zeros(len(n))], axis=1)


def tangent_numbers(n: Floats, ft: Floats) -> Floats:
    """The number whose product is ft, within two ulps of the rounded quotient; else that."""
    wide_n, wide = n.astype(np.longdouble), ft.astype(np.longdouble)
    along = wide[:, 0] * -wide_n[:, 1] + wide[:, 1] * wide_n[:, 0]
    middle = (along / (wide_n[:, 0] * wide_n[:, 0] + wide_n[:, 1] * wide_n[:, 1])).astype(float) + 0.0
    out, open_ = middle.copy(), np.ones(len(n), bool)
    up, down = np.nextafter(middle, np.inf), np.nextafter(middle, -np.inf)
    for near_by in (middle, up, down, np.nextafter(up, np.inf), np.nextafter(down, -np.inf)):
        product = _product(n, near_by)
        fits = open_ & (product[:, 0] == ft[:, 0]) & (product[:, 1] == ft[:, 1])
        out[fits], open_ = near_by[fits], open_ & ~fits
    return out


# ---- pressure -------------------------------------------------------------------------------------------------------

def _area(w: Work) -> float:
    return math.prod(w.edge[:w.up]) if w.dim > 1 else 1.0


def _given_pressure(w: Work) -> float:
    return w.o.number("pressure") * w.force / (w.scale * w.scale)


def _checked(w: Work, pressure: float) -> float:
    if not pressure > 0:
        raise bad_option(f": there is no force on the walls and none between grains ({len(w.links)} contacts); must be "
                         f"given: "
                         "--set pressure=P", "pressure")
    return pressure


def _mean_pressure(w: Work) -> float:
    """In a periodic cell or a box: mean of the normal stresses, sum of F.r over the volume and the dimension."""
    links, given = w.links, _given_pressure(w)
    branch = w.r[links.i] - links.overlap + np.where(links.j >= 0, w.r[np.maximum(links.j, 0)], 0)
    mean = running_sum(links.fn * branch) / (w.dim * (_area(w) * w.edge[w.up]))
    if math.isfinite(given) and abs(mean / given - 1) > 1e-2:
        w.note(f"the mean of the normal stresses is {w.pressure_text(mean)}, not the given {w.pressure_text(given)}")
    return _checked(w, given if math.isfinite(given) else mean)


def _piston_pressure(w: Work, links: Links, mass: Floats | None) -> float:
    """The force on the walls over their area."""
    up, area, given = w.up, _area(w), _given_pressure(w)
    force = links.ft[:, up] - links.fn * links.n[:, up]  # upward force on the grain
    below, above = running_sum(force[(links.j < 0) & (links.j != -2)]), running_sum(-force[links.j == -2])
    weight = running_sum(w.gravity * (sphere_mass(w.r) if mass is None else mass)) if w.gravity != 0 else 0.0
    low = below / area - weight / area if below > 0 else NAN
    high = above / area if above > 0 else NAN
    known = [p for p in (low, high) if math.isfinite(p)]
    walls = 0.5 * (low + high) if len(known) == 2 else known[0] if known else NAN
    pressure = given if math.isfinite(given) else walls if known else _stress(w, links)
    _checked(w, pressure)
    if not math.isfinite(given) and not known:
        w.note(f"no contact with a wall: the pressure {w.pressure_text(pressure)} is the stress along {w.name_of(up)} "
               f"from the "
               "contacts")
    if abs(low / high - 1) > 1e-3:
        w.note(f"the pressures on the walls differ: {w.pressure_text(low)} below, {w.pressure_text(high)} above "
               f"(weight, motion, "
               "or contacts missing)")
    if math.isfinite(given) and abs(walls / given - 1) > 1e-2:
        w.note(f"the pressure on the walls is {w.pressure_text(walls)}, not the given {w.pressure_text(given)}")
    return pressure


def _stress(w: Work, links: Links) -> float:
    """Mean normal stress along the axis up: sum of forces times branches over the volume."""
    up = w.up
    branch = np.where(links.j >= 0, w.separation(links.i, np.maximum(links.j, 0))[:, up], links.n[:, up] * w.r[links.i])
    return running_sum((links.fn * links.n[:, up] - links.ft[:, up]) * branch) / (_area(w) * w.edge[up])


# ---- balance --------------------------------------------------------------------------------------------------------

def _imbalance(w: Work, p: Packing) -> tuple[float, float, float, float, float]:
    """Of the grains that carry force: the largest net force, torque over R, and net force with the other sign of the
    tangential forces; and the sums of squares of both forces."""
    links = w.links
    net, tangential = _sums(links, w.n, -links.fn[:, None] * links.n), np.zeros((w.n, 3))
    torque = tangential
    if links.ft.any():
        tangential, torque = _sums(links, w.n, links.ft), _sums(links, w.n, np.cross(links.n, links.ft), 1.0)
    if w.gravity != 0:
        net[:, w.up] -= w.gravity * (sphere_mass(w.r) if p.mass is None else p.mass)
    counted = ~p.rattlers() & ~(w.boundary & (w.o.walls is None))
    now, other = (length(net + sign * tangential)[counted] for sign in (1, -1))
    return (float(now.max(initial=0)), float(length(torque)[counted].max(initial=0)), float(other.max(initial=0)),
            float((now * now).sum()), float((other * other).sum()))


def _sums(links: Links, n: int, values: Floats, sign: float = -1.0) -> Floats:
    """Sums over the contacts of each grain, in an order of their own: for what is told in two digits."""
    pairs = links.j >= 0
    return np.stack([np.bincount(links.i, column, n) + sign * np.bincount(links.j[pairs], column[pairs], n)
                     for column in values.T], axis=1)


def _check_balance(w: Work, p: Packing) -> None:
    mean = running_sum(w.links.fn / max(1, len(w.links)))
    now, torque, turned, squares, turned_squares = _imbalance(w, p)
    none = bool((p.rattlers() != 0).all())
    w.report.balance = now / mean if mean > 0 and not none else NAN
    if none:
        why = "" if w.friction > 0 else " (friction = 0)"
        w.note(f"all grains are rattlers: no balance of forces can be told{why}")
    elif now > mean and not w.has_ft and w.friction > 0:
        w.note("forces do not balance, perhaps because the tangential forces are missing")
    elif now > mean:
        w.note("forces do not balance: is the file cut short, or are periods, units or signs wrong?")
    if turned_squares < 0.25 * squares:
        w.note(f"with the other sign of the tangential forces the grains balance better ({turned / mean:.2g} of the "
               f"mean "
               "force): --columns ft_x=-COLUMN,... (or ft=-COLUMN) turns them")
    elif now < 1e-3 * torque:
        w.note(f"torques over R balance within {torque / mean:.2g} of the mean force only: tangential forces act at "
               f"the distance "
               "R here, at R - overlap/2 in LAMMPS and LIGGGHTS")


# ---- remarks --------------------------------------------------------------------------------------------------------

def _remark_missing(w: Work) -> None:
    """Pairs that overlap by the positions and are not in the list of contacts."""
    if w.contacts is None or not w.report.overlap_error < 0.01:
        return
    pairs, listed = touch.count(w), int(((w.links.j >= 0) & (w.links.depth > 0)).sum())
    if pairs - listed > pairs // 10:
        raise bad_file(f"{w.contacts.file}: lists {listed} of the {pairs} pairs that overlap; must list all: is it cut "
                       f"short, or "
                       "are the periods wrong?")
    if pairs > listed:
        w.note(f"{pairs - listed} pairs overlap and are not listed as contacts")


def _remark_friction(w: Work, pressure: float) -> None:
    links = w.links
    pressed = links.fn > 1e-4 * pressure
    if not w.friction > 0 or not pressed.any():
        return
    excess = float((length(links.ft[pressed]) / (w.friction * links.fn[pressed])).max())
    if excess > 1 + 1e-6:
        w.note(f"a tangential force is {excess:.4g} times friction times the normal force: is friction = "
               f"{w.friction:g} right?")


def _remark_walls(w: Work) -> None:
    for side, key in enumerate(SIDES):
        if not w.has_side(-1 - side) or (w.links.j == -1 - side).any():
            continue
        name = ("lower", "upper")[side] if side < 2 else key
        w.note(f"no grain touches the {name} wall" + ("" if w.cut else f"; --set {key}=PLACE moves it"))


# ---- rest -----------------------------------------------------------------------------------------------------------

def rest(w: Work, p: Packing) -> Packing:
    """Brings the packing to rest under its pressure, between rigid walls."""
    if p.cell != "piston" or p.gravity != 0:
        raise refused(f"{w.path}, --rest: grains come to rest under a piston without gravity only; read this cell "
                      f"without "
                      "--rest, and pack it with packing.kind = \"file\"")
    if p.wall != "rigid":
        w.note("the walls become rigid, since grains come to rest between such walls only")
    table = np.array(p.contacts)
    own = (table["j"] < 0) & ((p.wall != "rigid") | (table["kn"] != 0))
    table["overlap"][own] = hertz_overlap(wall_stiffness(p.r[table["i"][own]], "rigid"), table["fn"][own])
    table["kn"][own] = table["kt"][own] = 0
    start = Packing.from_arrays(p.x[:, :p.dim], p.r, table, box=p.box, pressure=p.pressure, friction=p.friction,
                                poisson=p.poisson, mass=p.mass, inertia=p.inertia)
    rested = _at_rest(w, start)
    heights = [w.length_text(packing.height) for packing in (p, rested)]
    loads = [2.0 * audit.carrying / max(1, packing.n - audit.rattlers) for packing in (start, rested)
             for audit in (packing.audit(),)]
    w.note(f"at rest under p = {w.pressure_text(p.pressure)} between rigid walls: height {heights[0]} -> {heights[1]}, "
           f"contacts "
           f"per carrying grain {loads[0]:.3g} -> {loads[1]:.3g}")
    w.report.contacts, w.report.wall_contacts = len(rested.contacts), int((rested.contacts["j"] < 0).sum())
    return rested


def _at_rest(w: Work, start: Packing) -> Packing:
    spec = ffi.new("sp_pack_spec *", lib.sp_pack_spec_default())
    spec.kind, spec.pressure = lib.SP_PACK_FILE, start.pressure
    spec.friction, spec.poisson = start.friction, start.poisson
    hooks = ffi.new("sp_pack_hooks *", {"threads": w.o.threads})
    setattr(hooks, "from", start._c)
    out = _core.new("sp_packing", lib.sp_packing_free, lib.sp_packing_none)
    try:
        call(lib.sp_packing_need_law, start._c, b"coming to rest")
        call(lib.sp_pack_spec_from, spec, start._c)
        call(lib.sp_packing_make_with, spec, hooks, out)
    except _core.SonopackError as fault:
        raise type(fault)(f"{w.path}, coming to rest: {fault}", fault.status, fault.key) from None
    if w.material is not None:
        _core.set_fields(out.material, vars(w.material))
    return Packing(out)
