"""Takes the grains out of the rows of their file: types, ids, positions, radii, masses; finds the axes; turns the
units."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from .._core import Integers
from ._faults import bad_file, bad_option
from .work import Work, modulus, running_sum, sphere_mass

_MOST = (2**31 - 1) // 4


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
        raise bad_option(f"{w.path}: dimension = 2, but the grains do not lie in one plane; must be 3, or a file of one "
                         f"layer")
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
    w.scale = o.length_unit / d
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
                         "pascals and kg/m^3")
    raise bad_option(f"{w.path}: the mean diameter is {mean:.4g} times the material's d = {d:g}; must be 0.2 .. 5: give "
                     "no d for the file's mean, or correct --length-unit")
