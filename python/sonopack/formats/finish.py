"""Makes the packing, checks its balance, and says what came out."""
from __future__ import annotations

import math

import numpy as np

from .. import _core
from .._core import Floats, Integers, InvalidInput, call
from .._native import ffi, lib
from .._packing import Packing
from .contacts import touching
from ._faults import bad_file, bad_option, refused
from .law import hertz_overlap, near, usual_stiffness, wall_stiffness
from .options import NAN, RINGS, SIDES
from .work import Links, Work, contact_table, dot, length, running_sum, sphere_mass, sum_over, wrapped


def make(w: Work) -> Packing:
    """The packing of what has been gathered."""
    if w.cell == "ring" and not all(w.has_wall[:2]):
        _fit_ring(w)
    x, outside = wrapped(w.x, w.cell, w.edge, w.tilt, w.periodic), _axes_outside(w)
    if (outside >= 0).any():
        _fail_outside(w, outside)
    listed, report = w.links, w.report
    w.links = listed[np.lexsort((np.maximum(listed.j, 0), listed.i, np.maximum(-listed.j, 0)))]
    mass, inertia = _masses(w)
    if usual_stiffness(w.r, w.links, w.wall, w.friction, w.poisson).all():
        w.links.kn, w.links.kt = 0 * w.links.kn, 0 * w.links.kt
    report.grains, report.contacts, report.wall_contacts = w.n, len(listed), int((listed.j < 0).sum())
    pressure = _piston_pressure(w, listed, mass) if w.cell == "piston" else _mean_pressure(w)
    packing = _build(w, x, mass, inertia, pressure)
    _check_balance(w, packing)
    _remark_missing(w)
    _remark_friction(w, pressure)
    _remark_walls(w)
    return packing


def _build(w: Work, x: Floats, mass: Floats | None, inertia: Floats | None, pressure: float) -> Packing:
    links = w.links
    links.n, links.ft = links.n + 0.0, (links.ft if w.friction > 0 else 0 * links.ft) + 0.0
    if w.dim == 2:
        # a number Ft that our tables give back with all bits
        links.ft = tangent_vectors(links.n, tangent_numbers(links.n, links.ft))
    try:
        return Packing.from_arrays(
            x[:, :w.dim], w.r, contact_table(links), box=w.edge[:w.dim], pressure=pressure, friction=w.friction,
            poisson=w.poisson, wall=w.wall, mass=mass, inertia=inertia, material=w.material, cell=w.cell, tilt=w.tilt,
            gravity=w.gravity)
    except InvalidInput as fault:
        raise InvalidInput(f"{w.path}: {fault}", fault.status, fault.key) from None


def tangent_vectors(n: Floats, scalar: Floats) -> Floats:
    """Ft (-ny, nx), from which tangent_numbers gives the same Ft."""
    out = _product(n, scalar)
    for k in np.flatnonzero(tangent_numbers(n, out) != scalar):
        # two neighbouring numbers have the same product: the vector moves by an ulp, to one that is no product
        x, y = (np.nextafter(v, [-np.inf, v, np.inf]) for v in out[k, :2])
        moved = np.stack([np.repeat(x, 3), np.tile(y, 3), np.zeros(9)], axis=1)
        out[k] = next(iter(moved[tangent_numbers(np.tile(n[k], (9, 1)), moved) == scalar[k]]), out[k])
    return out


def _product(n: Floats, scalar: Floats) -> Floats:
    return np.stack([scalar * -n[:, 1] + 0.0, scalar * n[:, 0] + 0.0, np.zeros(len(n))], axis=1)


def tangent_numbers(n: Floats, ft: Floats) -> Floats:
    """The number whose product is ft, within two ulps of the rounded quotient; else that."""
    wide_n, wide = n.astype(np.longdouble), ft.astype(np.longdouble)
    along = wide[:, 0] * -wide_n[:, 1] + wide[:, 1] * wide_n[:, 0]
    middle = (along / (wide_n[:, 0] * wide_n[:, 0] + wide_n[:, 1] * wide_n[:, 1])).astype(float) + 0.0
    up, down = np.nextafter(middle, np.inf), np.nextafter(middle, -np.inf)
    tried = np.stack([middle, up, down, np.nextafter(up, np.inf), np.nextafter(down, -np.inf)])
    fits = np.stack([(_product(n, one) == ft)[:, :2].all(axis=1) for one in tried])
    found: Floats = tried[fits.argmax(axis=0), np.arange(len(n))]  # the first that fits, else the middle
    return found


# ---- grains ---------------------------------------------------------------------------------------------------------

def _axes_outside(w: Work) -> Integers:
    """The axis on which each grain lies outside of the walls; -1: none."""
    out = np.full(w.n, -1)
    if w.cell == "ring":
        level = w.ring_of(w.x)[1]
        return np.where((level >= 0) & (level <= w.edge[1]), -1, 0)
    for a in range(w.dim):
        if not w.periodic[a]:
            out[~((w.x[:, a] >= 0) & (w.x[:, a] <= w.edge[a]))] = a
    return out


def _fail_outside(w: Work, outside: Integers) -> None:
    """Says where the walls are taken to be, and whether anything touches them: loose grains have no walls to find."""
    k = int(np.flatnonzero(outside >= 0)[0])
    axis = int(outside[k])
    if w.cell == "ring":
        raise bad_file(f"{w.path}: the centre of grain {w.id[k]} is not between the rings, nor are those of "
                       f"{int((outside >= 0).sum()) - 1} others: correct --set x0=, y0=, inner= and outer=, or leave "
                       "them out")
    low, high = w.low[axis] / w.scale, (w.low[axis] + w.edge[axis]) / w.scale
    first = w.wall_on(axis, -1)
    names = SIDES[-1 - first], SIDES[-first]
    touching = [int((w.links.j == first - side).sum()) for side in (0, 1)]
    pressed = "is this packing under pressure? If so, " if sum(touching) <= 2 else ""
    w.grains.refuse(
        outside >= 0, w.roles.need(w.grains, w.name_of(axis))[0],
        f"between the walls, which are taken to be at {low:.8g} and {high:.8g}. Outside of them are "
        f"{int((outside == axis).sum())} of {w.n} grains, and {touching[0]} touch the {names[0]} wall, {touching[1]} "
        f"the {names[1]}: {pressed}give --set {names[0]}= and {names[1]}=, or --types", w.row)


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


def not_usual(r: Floats, mass: Floats, inertia: Floats) -> tuple[Floats | None, Floats | None]:
    """Masses and moments of inertia, unless they are those of spheres of unit density, which say nothing new."""
    usual = sphere_mass(r)
    spheres = near(mass, usual).all() and near(inertia, usual * (0.4 * r * r)).all()
    return (None, None) if spheres else (mass, inertia)


def _fit_ring(w: Work) -> None:
    """The circles that pass nearest to the points of contact with the rings, but for what is given. Forces stay what
    they are."""
    links, names = w.links, (f"{w.name_of(0)}0", f"{w.name_of(1)}0", *RINGS)
    free = np.array([not w.o.given(name) for name in names])
    c = np.flatnonzero((links.j < 0) & (links.fn > 0))
    i, far = links.i[c], (links.j[c] == -2)
    if min(far.sum(), (~far).sum()) < 3:
        return
    force = links.ft[c] - links.fn[c, None] * links.n[c]
    low, inner, outer = np.array(w.low[:2]), 0.5 * w.edge[0] - w.edge[1], 0.5 * w.edge[0]
    for _ in range(20):
        out, level = w.ring_of(w.x[i])
        miss = np.where(far, level - w.edge[1] + w.r[i] - links.overlap[c], level - w.r[i] + links.overlap[c])
        step = np.zeros(4)
        step[free] = np.linalg.lstsq(np.stack([*out[:, :2].T, ~far, far], axis=1).astype(float)[:, free], miss, rcond=None)[0]
        inner, outer = inner + step[2], outer + step[3]
        low = low + step[:2] - (outer - 0.5 * w.edge[0])
        w.x[:, :2] += 0.5 * (2 * outer - w.edge[0]) - step[:2]
        w.edge[:2] = [2 * float(outer), float(outer - inner)]
    w.low[:2] = low.tolist()
    walls = links[c]
    w.place_links(walls)
    links.n[c], links.fn[c] = walls.n, -dot(force, walls.n)
    links.ft[c] = force + links.fn[c, None] * walls.n
    rms = float(np.sqrt(np.mean(miss**2)))
    text = ", ".join(f"{key}={float(v) / w.scale:.8g}" for key, v in zip(names, (*(low + outer), inner, outer)))
    w.note(f"rings through their {len(c)} contacts: {text}; these lie within {w.length_text(rms)} of them (rms)")


# ---- pressure -------------------------------------------------------------------------------------------------------

def _area(w: Work) -> float:
    return math.prod(w.edge[:w.up]) if w.dim > 1 else 1.0


def _given_pressure(w: Work) -> float:
    return w.o.number("pressure") * w.force / (w.scale * w.scale)


def _checked(w: Work, pressure: float) -> float:
    if not pressure > 0:
        raise bad_option(f": there is no force on the walls and none between grains ({len(w.links)} contacts); must be "
                         "given: --set pressure=P", "pressure")
    return pressure


def _mean_pressure(w: Work) -> float:
    """In a periodic cell or a box: mean of the normal stresses, sum of F.r over the volume and the dimension."""
    links, given = w.links, _given_pressure(w)
    branch = w.r[links.i] - links.overlap + np.where(links.j >= 0, w.r[np.maximum(links.j, 0)], 0)
    mean = running_sum(links.fn * branch) / (w.dim * w.volume())
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
    pressure = _checked(w, given if math.isfinite(given) else walls if known else _stress(w, links))
    if not math.isfinite(given) and not known:
        w.note(f"no contact with a wall: the pressure {w.pressure_text(pressure)} is the stress along {w.name_of(up)} "
               "from the contacts")
    if abs(low / high - 1) > 1e-3:
        w.note(f"the pressures on the walls differ: {w.pressure_text(low)} below, {w.pressure_text(high)} above "
               "(weight, motion, or contacts missing)")
    if math.isfinite(given) and abs(walls / given - 1) > 1e-2:
        w.note(f"the pressure on the walls is {w.pressure_text(walls)}, not the given {w.pressure_text(given)}")
    return pressure


def _stress(w: Work, links: Links) -> float:
    """Mean normal stress along the axis up: sum of forces times branches over the volume."""
    up = w.up
    branch = np.where(links.j >= 0, w.separation(links.i, np.maximum(links.j, 0))[:, up], links.n[:, up] * w.r[links.i])
    return running_sum((links.fn * links.n[:, up] - links.ft[:, up]) * branch) / (_area(w) * w.edge[up])


# ---- balance --------------------------------------------------------------------------------------------------------

def _check_balance(w: Work, p: Packing) -> None:
    """Largest net forces and torques over R of the grains that carry force, also with the other sign of the tangential
    forces, and what they tell."""
    links = w.links
    mean = running_sum(links.fn / max(1, len(links)))
    normal, tangential, torque = (sum_over(links.i, links.j, w.n, values, sign) for values, sign in (
        (-links.fn[:, None] * links.n, -1.0), (links.ft, -1.0), (np.cross(links.n, links.ft), 1.0)))
    if w.gravity != 0:
        normal[:, w.up] -= w.gravity * (sphere_mass(w.r) if p.mass is None else p.mass)
    counted = ~p.rattlers() & ~(w.boundary & (w.o.walls is None))
    now, turned = length(normal + tangential)[counted], length(normal - tangential)[counted]
    most, other, turning = (float(sizes.max(initial=0)) for sizes in (now, turned, length(torque)[counted]))
    if p.rattlers().all():
        why = "" if w.friction > 0 else " (friction = 0)"
        w.note(f"all grains are rattlers: no balance of forces can be told{why}")
    else:
        w.report.balance = most / mean if mean > 0 else NAN
        inner = ~np.isin(np.flatnonzero(counted), links.i[links.j < 0])
        w.report.elsewhere = float(now[inner].max(initial=0)) / mean if mean > 0 and inner.any() else NAN
        if most > mean and not w.has_ft and w.friction > 0:
            w.note("forces do not balance, perhaps because the tangential forces are missing")
        elif most > mean:
            w.note("forces do not balance: is the file cut short, or are periods, units or signs wrong?")
    if (turned * turned).sum() < 0.25 * (now * now).sum():
        w.note(f"with the other sign of the tangential forces the grains balance better ({other / mean:.2g} of the "
               "mean force): --columns ft_x=-COLUMN,... (or ft=-COLUMN) turns them")
    elif most < 1e-3 * turning:
        w.note(f"torques over R balance within {turning / mean:.2g} of the mean force only: tangential forces act at "
               "the distance R here, at R - overlap/2 in LAMMPS and LIGGGHTS")


# ---- remarks --------------------------------------------------------------------------------------------------------

def _remark_missing(w: Work) -> None:
    """Pairs that overlap by the positions and are not in the list of contacts."""
    if w.contacts is None or not w.report.overlap_error < 0.01:
        return
    pairs, listed = int((~w.goes_across(touching(w))).sum()), int(((w.links.j >= 0) & (w.links.depth > 0)).sum())
    if pairs - listed > pairs // 10:
        raise bad_file(f"{w.contacts.file}: lists {listed} of the {pairs} pairs that overlap; must list all: is it cut "
                       "short, or are the periods wrong?")
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
    for side in w.sides:
        if not (w.links.j == -1 - side).any():
            key = w.side_name(-1 - side)
            name = ("lower", "upper")[side] if side < 2 and w.cell != "ring" else key
            w.note(f"no grain touches the {name} wall" + ("" if w.cut else f"; --set {key}=PLACE moves it"))


# ---- rest -----------------------------------------------------------------------------------------------------------

def rest(w: Work, p: Packing) -> Packing:
    """Brings the packing to rest under its pressure, between rigid walls."""
    if p.cell != "piston" or p.gravity != 0:
        raise refused(f"{w.path}, --rest: grains come to rest under a piston without gravity only; read this cell "
                      "without --rest, and pack it with packing.kind = \"file\"")
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
           f"contacts per carrying grain {loads[0]:.3g} -> {loads[1]:.3g}")
    w.report.contacts, w.report.wall_contacts = len(rested.contacts), int((rested.contacts["j"] < 0).sum())
    return rested


def _at_rest(w: Work, start: Packing) -> Packing:
    spec = ffi.new("sp_pack_spec *", lib.sp_pack_spec_default())
    spec.kind, spec.pressure = lib.SP_PACK_FILE, start.pressure
    spec.friction, spec.poisson = start.friction, start.poisson
    try:
        call(lib.sp_packing_need_law, start._c, b"coming to rest")
        call(lib.sp_pack_spec_from, spec, start._c)
        packing = Packing.of_spec(spec, start, threads=w.o.threads)
    except _core.SonopackError as fault:
        raise type(fault)(f"{w.path}, coming to rest: {fault}", fault.status, fault.key) from None
    return packing if w.material is None else packing.of_material(w.material)
