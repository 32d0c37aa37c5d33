"""Our own form in two tables: grains 'id x y [z] radius [mass inertia]', contacts 'i j nx ny [nz] overlap Fn Ft [kn kt mu]';
box and material in comment lines '# key = value'."""
from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np

from .._core import Floats, Integers, SonopackError
from .._packing import CONTACT, STRAINS, Packing
from .._table import material_of
from ._faults import bad_file, bad_option
from .export import number_text
from .finish import tangent_numbers, tangent_vectors
from .options import CELLS, SIDES, WALLS
from .sheet import number, text_of

_KEYS = ("dimension", "width", "depth", "height", "cell", "xy", "xz", "yz", "gravity", "pressure", "friction", "poisson",
         "wall", "material", "seed", "frame", *STRAINS)
_TILT = ("xy", "xz", "yz")
_EDGES = {1: ("height",), 2: ("width", "height"), 3: ("width", "depth", "height")}


class _Rows:
    """Rows of words below a header, between tabs or blanks; said: the keys of the comment lines."""

    def __init__(self, file: str) -> None:
        self.file = file
        text = text_of(file).decode(errors="replace")
        self.said: dict[str, str] = {}
        for key, value in re.findall(r"^[ \t]*#[ \t]*(\w+)[ \t]*=[ \t]*(\S+)", text, re.M):
            self.said.setdefault(key, value)
        lines = [(k, line) for k, line in enumerate(text.split("\n"), 1) if line.strip() and line.lstrip(" \t")[0] != "#"]
        if not lines:
            raise bad_file(f"{file}: empty: must have a header row with the names of the columns")
        self._tabs = "\t" in lines[0][1]
        self.names = self._cells(lines[0][1])
        self.line = [k for k, _ in lines[1:]]  #: the number of each row's line
        self._rows = [line for _, line in lines[1:]]
        words = {k: str for k, name in enumerate(self.names) if name in ("id", "i", "j")}
        try:
            self._columns = self._parse({k: words.get(k, float) for k in range(len(self.names))})
        except (ValueError, OverflowError):  # other words: each is looked at
            self._columns = self._parse(str)

    def _cells(self, line: str) -> list[str]:
        return [cell.strip(" ") for cell in line.split("\t")] if self._tabs else line.split()

    def _parse(self, kind: Any) -> Any:
        import pandas
        columns = range(len(self.names))
        full = ("\t" if self._tabs else " ").join("0" * (len(columns) + 1))  # pandas wants one row with all columns
        try:
            frame = pandas.read_csv(io.StringIO("\n".join([full, *self._rows, ""])), header=None,
                                    names=[*columns, "more"], dtype=kind, sep="\t" if self._tabs else r"\s+",
                                    keep_default_na=False, na_values=[""], quoting=3, index_col=False,
                                    skipinitialspace=True, engine="c", float_precision="round_trip").iloc[1:]
            wrong = frame.pop("more").notna().any() or frame.isna().to_numpy().any()  # or empty cells
        except pandas.errors.ParserError:
            wrong = True
        for k, row in enumerate(self._rows if wrong else []):
            found = len(self._cells(row))
            if found != len(self.names):
                self.fail(k, f"{found} cells where the first row has {len(self.names)}")
        return frame

    def __len__(self) -> int:
        return len(self._rows)

    def fail(self, row: int, text: str) -> NoReturn:
        raise bad_file(f"{self.file}:{self.line[row]}: {text}")

    def column(self, name: str) -> list[str]:
        """The words of a column, which must be there."""
        if name not in self.names:
            raise bad_file(f"{self.file}: no column '{name}' in the header row")
        return [str(word) for word in self._column(name).fillna("")]

    def _column(self, name: str) -> Any:
        return self._columns[self.names.index(name)]

    def numbers(self, name: str, optional: bool = False) -> Floats:
        """The finite numbers of a column. optional: NaN where the column or the number is missing."""
        if optional and name not in self.names:
            return np.full(len(self), math.nan)
        if name in self.names and self._column(name).dtype != object:
            found: Floats = self._column(name).to_numpy(dtype=float)
            if np.isfinite(found).all():
                return found
            self._columns = self._parse(str)
        words = self.column(name)
        values = np.array([number(word) for word in words])
        for k in np.flatnonzero(~np.isfinite(values)):
            if not (optional and words[k] == ""):
                self.fail(int(k), f"{name} is '{words[k]:.60}'; must be a finite number")
        return values


class _Keys:
    """What options and comment lines say: options first, then the comments of the grains, then those of the contacts."""

    def __init__(self, grains: _Rows, contacts: _Rows, given: Mapping[str, Any]) -> None:
        self._grains, self._contacts = grains, contacts
        self._given = {str(key).removeprefix("packing."): str(value) for key, value in given.items()}
        for key, value in self._given.items():
            if key not in _KEYS:
                raise bad_option(f"'{key}={value}': must be key=value with one of the keys {', '.join(_KEYS)}")

    def word(self, key: str) -> tuple[str | None, str]:
        """The value of a key, or None, and where it stands."""
        for said, where in ((self._given, "option"), (self._grains.said, self._grains.file),
                            (self._contacts.said, self._contacts.file)):
            if key in said:
                return said[key], where
        return None, self._grains.file

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

def _wrapped(x: Floats, box: list[float], tilt: list[float], cell: str) -> Floats:
    """Grains outside of the cell move into it along the periodic axes; those inside remain the same, bit for bit."""
    dim = len(box)
    out = x + 0.0  # no negative zero
    if cell == "piston":
        for a in range(dim - 1):
            outside = (x[:, a] < 0) | (x[:, a] >= box[a])
            moved = np.mod(x[outside, a], box[a])
            out[outside, a] = np.where(moved < box[a], moved, 0.0)
    if cell == "periodic":
        rows = np.array([[box[0], 0, 0], [tilt[0], box[1] if dim > 1 else 1, 0], [tilt[1], tilt[2], box[2] if dim > 2 else 1]])
        for a in reversed(range(dim)):
            rest = out.copy()
            for b in reversed(range(a + 1, dim)):
                rest -= (rest[:, b] / rows[b, b])[:, None] * rows[b, :dim]
            s = rest[:, a] / rows[a, a]
            outside = ~((s >= -1e-12) & (s <= 1 + 1e-12))  # what the check of packings allows
            out[outside] -= np.floor(s[outside])[:, None] * rows[a, :dim]
    return out


def _grains(g: _Rows, dim: int, sides: dict[str, int]) -> tuple[dict[str, int], Floats, Floats, list[Floats | None]]:
    """The places of the ids, centres, radii, and masses with moments of inertia."""
    place: dict[str, int] = {}
    for k, word in enumerate(g.column("id")):
        if word == "" or word in sides:
            g.fail(k, f"id is '{word:.60}'; must be a number or word, not the name of a wall")
        if place.setdefault(word, k) != k:
            g.fail(k, f"id {word:.60} stands already in line {g.line[place[word]]}")
    if not place:
        raise bad_file(f"{g.file}: 0 grains; must be 1 or more")
    masses: list[Floats | None] = [None, None]
    if ("mass" in g.names) != ("inertia" in g.names):
        raise bad_file(f"{g.file}: a column '{'mass' if 'mass' in g.names else 'inertia'}' alone; must be both mass and inertia, "
                       "or neither")
    positive = {"radius": g.numbers("radius")}
    if "mass" in g.names:
        positive |= {"mass": g.numbers("mass"), "inertia": g.numbers("inertia")}
        masses = [positive["mass"], positive["inertia"]]
    for name, values in positive.items():
        for k in np.flatnonzero(~(values > 0))[:1]:
            g.fail(int(k), f"{name} is {values[k]:g}; must be positive")
    return place, np.stack([g.numbers("xyz"[a]) for a in range(dim)], axis=1), positive["radius"], masses


def _ends(c: _Rows, name: str, place: dict[str, int], sides: dict[str, int]) -> Integers:
    known = {**place, **sides}
    words = c.column(name)
    found = [known.get(word) for word in words]
    if None in found:
        k = found.index(None)
        c.fail(k, f"{name} is '{words[k]:.60}'; must be the id of a grain, or a wall: {', '.join(sides)}")
    return np.array(found, dtype=np.int64)


def _forces(c: _Rows, dim: int, n: Floats) -> Floats:
    """The tangential forces on i as vectors."""
    axes = [name for name in ("Ftx", "Fty", "Ftz")[:dim] if name in c.names]
    if axes and len(axes) != dim:
        raise bad_file(f"{c.file}: {len(axes)} of the {dim} columns Ftx, Fty{', Ftz' if dim == 3 else ''}")
    if "Ft" in c.names and (axes or dim == 3):
        raise bad_file(f"{c.file}: a column 'Ft', where the force must be in Ftx, Fty{', Ftz' if dim == 3 else ' alone'}")
    out = np.zeros((len(c), 3))
    for a, name in enumerate(axes):
        out[:, a] = c.numbers(name) + 0.0
    return tangent_vectors(n, c.numbers("Ft")) if "Ft" in c.names and dim == 2 else out


def _contacts(c: _Rows, dim: int, cell: str, ends: tuple[Integers, Integers]) -> np.ndarray:  # type: ignore[type-arg]
    """The contacts with i < j; what overlap, Fn and kt lack is NaN."""
    out = np.zeros(len(c), CONTACT)
    i, j = ends
    n = np.zeros((len(c), 3))
    for a in range(dim):
        n[:, a] = c.numbers("n" + "xyz"[a]) + 0.0
    squared = (n[:, 0] * n[:, 0] + n[:, 1] * n[:, 1]) + n[:, 2] * n[:, 2]
    if "kt" in c.names and "kn" not in c.names:
        raise bad_file(f"{c.file}: a column 'kt' without 'kn'; must be both, or kn alone")
    if "overlap" not in c.names and "Fn" not in c.names:
        raise bad_file(f"{c.file}: neither a column 'overlap' nor 'Fn' in the header row")
    overlap, fn, kn, kt, mu = (c.numbers(name, True) for name in ("overlap", "Fn", "kn", "kt", "mu"))
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


def _check_near(c: _Rows, links: np.ndarray, x: Floats, r: Floats, box: list[float]) -> None:  # type: ignore[type-arg]
    """Refuses grains that touch a wall whose normal is along an axis, from farther away than a radius."""
    for k in np.flatnonzero(links["j"] < 0):
        i, j, axis = links["i"][k], links["j"][k], int(np.abs(links["n"][k]).argmax())
        gap = (box[axis] - x[i, axis] if j % 2 == 0 else x[i, axis]) - r[i]
        if abs(links["n"][k, axis]) > 1 - 1e-7 and gap > r[i]:
            c.fail(int(k), f"grain {i} is {gap:.3g} d from the {SIDES[-1 - j]} wall that it touches: must be less than a radius; "
                           "are width and height right, or is this wall elsewhere?")


def read(grains: str, contacts: str, given: Mapping[str, Any]) -> Packing:
    """given: keys in place of those in the comment lines."""
    g, c = _Rows(grains), _Rows(contacts)
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
        p = Packing.from_arrays(_wrapped(x, box, tilt, cell), r, links, box=box, pressure=keys.number("pressure"),
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

def _rows(columns: dict[str, Any]) -> str:
    texts = [map(number_text, column.tolist()) if getattr(column, "dtype", None) == float else map(str, column)
             for column in columns.values()]
    return "\t".join(columns) + "\n" + "".join("\t".join(row) + "\n" for row in zip(*texts))


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
    return {grains: (_said(p) + _rows(columns)).encode(), contacts: (f"{head}\n" + _rows(links)).encode()}
