"""Our own form in two tables: grains 'id x y [z] radius [mass inertia]', contacts 'i j nx ny [nz] overlap Fn Ft [kn kt mu]';
box and material in comment lines '# key = value'."""
from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np

from .._core import Floats, Integers, SonopackError
from .._packing import CONTACT, STRAINS, Packing
from .._table import material_of
from . import table
from ._faults import bad_file, bad_option
from .export import number_text, rows_of
from .finish import tangent_numbers, tangent_vectors
from .options import CELLS, SIDES, WALLS
from .sheet import Sheet, number
from .work import wrapped

_KEYS = ("dimension", "width", "depth", "height", "cell", "xy", "xz", "yz", "gravity", "pressure", "friction", "poisson",
         "wall", "material", "seed", "frame", *STRAINS)
_TILT = ("xy", "xz", "yz")
_EDGES = {1: ("height",), 2: ("width", "height"), 3: ("width", "depth", "height")}


def _column(s: Sheet, name: str) -> int:
    """The index of a column, which must be there."""
    if name not in s.names:
        raise bad_file(f"{s.file}: no column '{name}' in the header row")
    return s.column(name)


def _numbers(s: Sheet, name: str, optional: bool = False) -> Floats:
    """The finite numbers of a column. optional: NaN where the column or the number is missing."""
    if optional and name not in s.names:
        return np.full(s.rows, math.nan)
    at = _column(s, name)
    values: Floats = s.values[:, at]
    wrong = np.isnan(values)
    if optional and wrong.any():
        wrong &= np.array(s.words(at)) != ""
    s.refuse(wrong, at, "a finite number")
    return values


class _Keys:
    """What options and comment lines say: options first, then the comments of the grains, then those of the contacts."""

    def __init__(self, grains: Sheet, contacts: Sheet, given: Mapping[str, Any]) -> None:
        self._grains = grains
        self._said = {key: (value, sheet.file) for sheet in (contacts, grains) for key, value in sheet.said.items()}
        for key, value in ((str(key).removeprefix("packing."), str(value)) for key, value in given.items()):
            if key not in _KEYS:
                raise bad_option(f"'{key}={value}': must be key=value with one of the keys {', '.join(_KEYS)}")
            self._said[key] = value, "option"

    def word(self, key: str) -> tuple[str | None, str]:
        """The value of a key, or None, and where it stands."""
        return self._said.get(key, (None, self._grains.file))

    def _fail(self, key: str, rule: str) -> NoReturn:
        value, where = self.word(key)
        text = f"{where}: {key} is '{value!s:.60}'; must be {rule}"
        raise bad_option(text) if where == "option" else bad_file(text)

    def number(self, key: str, other: float | None = None) -> float:
        value, _ = self.word(key)
        if value is None and other is None:
            raise bad_file(f"{self._grains.file}: no {key}; must be in a comment line '# {key} = ...' or `--set {key}=...'")
        found = number(value) if value is not None else float(other or 0)
        if not math.isfinite(found):
            self._fail(key, "a finite number")
        return found

    def one_of(self, key: str, words: tuple[str, ...]) -> str:
        value = self.word(key)[0] or words[0]
        if value not in words:
            self._fail(key, f"{', '.join(words[:-1])} or {words[-1]}")
        return value

    def seed(self) -> int:
        value = self.word("seed")[0] or "0"
        if not re.fullmatch(r"\d{1,20}", value) or int(value) >= 1 << 64:
            self._fail("seed", "a whole number of 64 bits")
        return int(value)

    def dimension(self) -> int:
        columns = 3 if "z" in self._grains.names else 2 if "y" in self._grains.names else 1
        value = self.number("dimension", columns)
        if value not in (1, 2, 3):
            self._fail("dimension", "1, 2 or 3")
        if value > columns:
            raise bad_file(f"{self._grains.file}: dimension is {value:g}, but there is no column '{'xyz'[columns]}'")
        return int(value)

    def box(self, dim: int) -> list[float]:
        for key in _EDGES[dim]:
            if not self.number(key) > 0:
                self._fail(key, "positive")
        return [self.number(key) for key in _EDGES[dim]]


# ---- reading --------------------------------------------------------------------------------------------------------

def _grains(g: Sheet, dim: int, sides: dict[str, int]) -> tuple[dict[str, int], Floats, Floats, list[Floats | None]]:
    """The places of the ids, centres, radii, and masses with moments of inertia."""
    place: dict[str, int] = {}
    for k, word in enumerate(g.words(_column(g, "id"))):
        if word == "" or word in sides:
            g.fail(k, f"id is '{word:.60}'; must be a number or word, not the name of a wall")
        if place.setdefault(word, k) != k:
            g.fail(k, f"id {word:.60} stands already in line {g.line(place[word])}")
    if not place:
        raise bad_file(f"{g.file}: 0 grains; must be 1 or more")
    masses: list[Floats | None] = [None, None]
    if ("mass" in g.names) != ("inertia" in g.names):
        raise bad_file(f"{g.file}: a column '{'mass' if 'mass' in g.names else 'inertia'}' alone; must be both mass and inertia, "
                       "or neither")
    positive = {"radius": _numbers(g, "radius")}
    if "mass" in g.names:
        positive |= {"mass": _numbers(g, "mass"), "inertia": _numbers(g, "inertia")}
        masses = [positive["mass"], positive["inertia"]]
    for name, values in positive.items():
        for k in np.flatnonzero(~(values > 0))[:1]:
            g.fail(int(k), f"{name} is {values[k]:g}; must be positive")
    return place, np.stack([_numbers(g, "xyz"[a]) for a in range(dim)], axis=1), positive["radius"], masses


def _ends(c: Sheet, name: str, place: dict[str, int], sides: dict[str, int]) -> Integers:
    known = {**place, **sides}
    words = c.words(_column(c, name))
    found = [known.get(word) for word in words]
    if None in found:
        k = found.index(None)
        c.fail(k, f"{name} is '{words[k]:.60}'; must be the id of a grain, or a wall: {', '.join(sides)}")
    return np.array(found, dtype=np.int64)


def _forces(c: Sheet, dim: int, n: Floats) -> Floats:
    """The tangential forces on i as vectors."""
    axes = [name for name in ("Ftx", "Fty", "Ftz")[:dim] if name in c.names]
    if axes and len(axes) != dim:
        raise bad_file(f"{c.file}: {len(axes)} of the {dim} columns Ftx, Fty{', Ftz' if dim == 3 else ''}")
    if "Ft" in c.names and (axes or dim == 3):
        raise bad_file(f"{c.file}: a column 'Ft', where the force must be in Ftx, Fty{', Ftz' if dim == 3 else ' alone'}")
    out = np.zeros((c.rows, 3))
    for a, name in enumerate(axes):
        out[:, a] = _numbers(c, name) + 0.0
    return tangent_vectors(n, _numbers(c, "Ft")) if "Ft" in c.names and dim == 2 else out


def _contacts(c: Sheet, dim: int, cell: str, ends: tuple[Integers, Integers]) -> np.ndarray:  # type: ignore[type-arg]
    """The contacts with i < j; what overlap, Fn and kt lack is NaN."""
    out = np.zeros(c.rows, CONTACT)
    i, j = ends
    n = np.zeros((c.rows, 3))
    for a in range(dim):
        n[:, a] = _numbers(c, "n" + "xyz"[a]) + 0.0
    squared = (n[:, 0] * n[:, 0] + n[:, 1] * n[:, 1]) + n[:, 2] * n[:, 2]
    if "kt" in c.names and "kn" not in c.names:
        raise bad_file(f"{c.file}: a column 'kt' without 'kn'; must be both, or kn alone")
    if "overlap" not in c.names and "Fn" not in c.names:
        raise bad_file(f"{c.file}: neither a column 'overlap' nor 'Fn' in the header row")
    overlap, fn, kn, kt, mu = (_numbers(c, name, True) for name in ("overlap", "Fn", "kn", "kt", "mu"))
    kn, mu = (np.where(np.isnan(of), 0.0, of) for of in (kn, mu))
    walls = (i < 0).astype(int) + (j < 0)
    for bad, text in ((((i == j) | (walls > 1) | ((walls > 0) & (cell == "periodic"))),
                       "a contact of {} and {}; must be two grains, or a grain and a wall of the cell"),
                      (~(np.abs(np.sqrt(squared) - 1) <= 1e-3), "the normal is not of length 1"),
                      (np.isnan(overlap) & np.isnan(fn), "neither overlap nor Fn"),
                      ((overlap < 0) | (fn < 0), "overlap or Fn is below 0; must be >= 0"),
                      ((kn < 0) | (kt < 0) | ((kt > 0) & ~(kn > 0)), "kn and kt must be >= 0, and kn above 0 where kt is")):
        for k in np.flatnonzero(bad)[:1]:
            c.fail(int(k), text.format(i[k], j[k]))
    rough = np.abs(squared - 1) > 1e-9  # measured normals have few digits
    n[rough] /= np.sqrt(squared[rough])[:, None]
    ft = _forces(c, dim, n)
    turned = (i < 0) | ((j >= 0) & (i > j))
    out["i"], out["j"] = np.where(turned, j, i), np.where(turned, i, j)
    out["n"], out["ft"] = np.where(turned[:, None], 0.0 - n, n), np.where(turned[:, None], 0.0 - ft, ft)
    out["overlap"], out["fn"], out["kn"], out["kt"], out["mu"] = overlap, fn, kn, kt, mu
    return out


def _check_near(c: Sheet, links: np.ndarray, x: Floats, r: Floats, box: list[float]) -> None:  # type: ignore[type-arg]
    """Refuses grains that touch a wall whose normal is along an axis, from farther away than a radius."""
    for k in np.flatnonzero(links["j"] < 0):
        i, j, axis = links["i"][k], links["j"][k], int(np.abs(links["n"][k]).argmax())
        gap = (box[axis] - x[i, axis] if j % 2 == 0 else x[i, axis]) - r[i]
        if abs(links["n"][k, axis]) > 1 - 1e-7 and gap > r[i]:
            c.fail(int(k), f"grain {i} is {gap:.3g} d from the {SIDES[-1 - j]} wall that it touches: must be less than a radius; "
                           "are width and height right, or is this wall elsewhere?")


def read(grains: str, contacts: str, given: Mapping[str, Any]) -> Packing:
    """given: keys in place of those in the comment lines."""
    g, c = table.read(grains), table.read(contacts)
    keys = _Keys(g, c, given)
    dim, cell = keys.dimension(), keys.one_of("cell", CELLS)
    # under a piston, left, right, front and back are free for grains
    count = 2 if cell != "box" else 4 if dim == 2 else 2 if dim == 1 else 6
    sides = {name: -1 - k for k, name in enumerate(SIDES[:count])}
    box, tilt = keys.box(dim), [keys.number(key, 0.0) for key in _TILT]
    place, x, r, masses = _grains(g, dim, sides)
    links = _contacts(c, dim, cell, (_ends(c, "i", place, sides), _ends(c, "j", place, sides)))
    if cell != "ring":
        _check_near(c, links, x, r, box)
    material = keys.word("material")[0]
    try:
        x = wrapped(x, cell, box, tilt, [cell == "periodic" or (cell == "piston" and a < dim - 1) for a in range(dim)])
        p = Packing.from_arrays(x, r, links, box=box, pressure=keys.number("pressure"),
                                friction=keys.number("friction"), poisson=keys.number("poisson", 0.0),
                                wall=keys.one_of("wall", WALLS), mass=masses[0], inertia=masses[1],
                                material=material_of(material) if material else None, cell=cell,
                                tilt=(tilt[0], tilt[1], tilt[2]), gravity=keys.number("gravity", 0.0))
    except SonopackError as fault:
        if str(fault).startswith((grains, contacts, "option")):
            raise
        raise bad_file(f"{grains}, {contacts}: {fault}") from None
    p._c.seed = keys.seed()
    if keys.word("frame")[0] is not None:
        p.set_series(keys.number("frame"), {name: keys.number(name) for name in STRAINS if keys.word(name)[0] is not None})
    return p


# ---- writing --------------------------------------------------------------------------------------------------------

def _rows(columns: dict[str, Any]) -> bytes:
    return ("\t".join(columns) + "\n").encode() + rows_of(list(columns.values()), between="\t")


def _said(p: Packing) -> str:
    """The comment lines of the grains."""
    said: dict[str, Any] = {"dimension": p.dim, **dict(zip(_EDGES[p.dim], p.box))}
    if p.cell != "piston" or p.gravity != 0:
        said["cell"] = p.cell
    said |= {key: step for key, step in zip(_TILT, p.tilt) if step != 0}
    if p.gravity != 0:
        said["gravity"] = p.gravity
    said |= {"pressure": p.pressure, "friction": p.friction, "poisson": p.poisson, "wall": p.wall}
    m = p.material
    if m.young > 0:
        said["material"] = ",".join(f"{key}={number_text(value)}" for key, value in
                                    (("E", m.young), ("nu", m.poisson), ("rho", m.density), ("d", m.diameter)))
    if p._c.seed:
        said["seed"] = p._c.seed
    if not math.isnan(p.frame):
        said |= {"frame": p.frame, **p.strain}
    return "# lengths in mean grain diameters d, pressure in E*\n" + "".join(
        f"# {key} = {f'{value:.17g}' if isinstance(value, float) else value}\n" for key, value in said.items())


def content(p: Packing, grains: str, contacts: str) -> dict[str, bytes]:
    """The text of both tables, by their names."""
    if grains == contacts:
        raise bad_option(f"{grains}: grains and contacts need a file each")
    dim, k = p.dim, p.contacts
    columns: dict[str, Any] = {"id": range(p.n), **{"xyz"[a]: p.x[:, a] for a in range(dim)}, "radius": p.r}
    if p.mass is not None:
        columns |= {"mass": np.array(p.mass), "inertia": np.array(p.inertia)}
    links: dict[str, Any] = {"i": k["i"], "j": [SIDES[-1 - j] if j < 0 else j for j in k["j"].tolist()],
                             **{"n" + "xyz"[a]: k["n"][:, a] for a in range(dim)}, "overlap": k["overlap"], "Fn": k["fn"]}
    if dim == 2:
        links["Ft"] = tangent_numbers(k["n"], k["ft"])
    if dim == 3:
        links |= {"Ft" + "xyz"[a]: k["ft"][:, a] for a in range(dim)}
    springs = bool((k["kn"] > 0).any())
    if springs:
        links |= {"kn": k["kn"], "kt": k["kt"]}
    if bool((k["mu"] > 0).any()):
        links["mu"] = k["mu"]
    head = "# n from i to j; overlap in d, forces in E* d^2"
    head += ", stiffnesses in E* d (0: Hertz and Mindlin)" if springs else ""
    head += ("", "; Ft: force on i along t = (-ny, nx)", "; Ft: force on i")[dim - 1]
    return {grains: _said(p).encode() + _rows(columns), contacts: f"{head}\n".encode() + _rows(links)}
