"""What files of other programs list of a packing: its numbers in their units, sums over the contacts of each grain, and
displacements."""
from __future__ import annotations

import dataclasses
import os
from typing import Any

import numpy as np

from .._core import Floats, Integers, text_of
from .._native import ffi
from .._packing import Packing
from .._records import Material
from .._table import Table
from .law import eta, stiffness_of
from .walls import sum_over
from .work import Links, modulus, sphere_mass


@dataclasses.dataclass(frozen=True)
class Units:
    """What a number of a packing is multiplied by, and the names of the units."""

    length: float = 1.0
    mass: float = 1.0
    density: float = 1.0
    force: float = 1.0
    stress: float = 1.0
    stiffness: float = 1.0
    names: tuple[str, ...] = ("d", "rho d^3", "E* d^2", "E*", "E* d")  #: of length, mass, force, stress, stiffness
    all: str = "d, E*, rho"

    @classmethod
    def of(cls, m: Material | None) -> Units:
        """SI units of grains of a material; None: the packing's own."""
        if m is None:
            return cls()
        d, stress = m.diameter, modulus(m)
        return cls(d, m.density * d * d * d, m.density, stress * d * d, stress, stress * d, ("m", "kg", "N", "Pa", "N/m"), "SI")


def number_text(value: float) -> str:
    """A number with the fewest digits, 15 to 17, that read back exactly."""
    for digits in (15, 16):
        text = f"{value:.{digits}g}"
        if float(text) == value:
            return text
    return f"{value:.17g}"


def rows_of(columns: list[Any], first: str = "") -> bytes:
    """Rows of numbers between blanks; first: a word before each."""
    texts = [map(str, column.tolist()) if column.dtype.kind in "iub" else map(number_text, column.tolist())
             for column in map(np.asarray, columns)]
    start = f"{first} " if first else ""
    return "".join(f"{start}{' '.join(row)}\n" for row in zip(*texts)).encode()


def beside(path: str, suffix: str) -> str:
    """NAME + suffix for NAME.ending."""
    return os.path.splitext(path)[0] + suffix


class Export:
    """A packing in the units of a file. displacement, rotation [n][3] are written as they are."""

    def __init__(self, packing: Packing, path: str, si: Material | None = None, displacement: Floats | None = None,
                 rotation: Floats | None = None) -> None:
        p, u = packing, Units.of(si)
        self.packing, self.units, self.path = packing, u, path
        self.displacement, self.rotation = displacement, rotation
        self.ids: Integers = np.arange(p.n)
        self.box = [p._c.box[a] * u.length for a in range(3)]
        self.tilt = [t * u.length for t in p.tilt]
        self.pressure = p.pressure * u.stress
        self.gravity = p.gravity * u.stress / (u.density * u.length)
        self.special = p.cell != "piston" or p.gravity != 0
        self.x, self.r = np.array(p.x) * u.length, np.array(p.r) * u.length
        own = sphere_mass(np.array(p.r)) if p.mass is None else np.array(p.mass)
        self.mass = own * u.mass
        self.density = np.full(p.n, u.density) if p.mass is None else self.mass / sphere_mass(self.r)
        self._derive()

    def _derive(self) -> None:
        """Sums over contacts, in the packing's own units: its threshold of forces needs them."""
        p, u, c = self.packing, self.units, self.packing.contacts
        links = Links(len(c))
        links.i, links.j = c["i"].astype(np.int64), c["j"].astype(np.int64)
        self.i, self.j, self.n = links.i, links.j, np.array(c["n"])
        force = c["ft"] - c["fn"][:, None] * c["n"] + 0.0
        self.rattler, self.carrying = p.rattlers().astype(int), p.carrying().astype(int)
        self.contacts = np.bincount(np.concatenate([links.i, links.j[links.j >= 0]]), np.concatenate(
            [self.carrying, self.carrying[links.j >= 0]]), p.n).astype(int)
        self.net = sum_over(links, p.n, force) * u.force
        stress = self._stress(links, force)
        self.grain_pressure = (stress[:, 0] + stress[:, 4] + stress[:, 8]) / p.dim * u.stress
        self.stress = stress * u.stress
        self.overlap, self.fn, self.ft = c["overlap"] * u.length, c["fn"] * u.force, c["ft"] * u.force
        self.force = self.ft - self.fn[:, None] * self.n + 0.0
        own = c["kn"] > 0
        kn = np.where(own, c["kn"], 2.0 * stiffness_of(p.r, links, p.wall) * np.sqrt(np.fmax(c["overlap"], 0.0)))
        usual = eta(p.poisson) * kn if p.friction > 0 and p.dim > 1 else 0 * kn
        self.kn, self.kt = kn * u.stiffness, np.where(own, c["kt"], usual) * u.stiffness
        self.springs = bool(own.any())

    def _stress(self, links: Links, force: Floats) -> Floats:
        """[n][9] sum of (branch) x (force) over the grain's volume; positive in compression."""
        p, n = self.packing, self.packing.contacts["n"]
        out = np.zeros((p.n, 9))
        ends = np.stack([links.i, links.j], axis=1).ravel()
        grains = ends >= 0
        ends, signs = ends[grains], np.tile([1.0, -1.0], len(links))[grains]
        volume = sphere_mass(np.array(p.r))[ends]
        for a in range(3):
            branch = signs * p.r[ends] * np.repeat(n[:, a], 2)[grains]
            for b in range(3):
                out[:, 3 * a + b] = np.bincount(ends, -(branch * (signs * np.repeat(force[:, b], 2)[grains]) / volume), p.n)
        return out + 0.0

    def periodic(self, axis: int) -> bool:
        return self.packing.cell == "periodic" or (self.packing.cell == "piston" and axis < self.packing.dim - 1)

    def vectors(self, displacement: str, rotation: str) -> tuple[str, list[Floats]]:
        """Names and columns of displacements and rotations, as a row lists them."""
        names, columns = "", []
        for stem, values in ((displacement, self.displacement), (rotation, self.rotation)):
            if values is not None:
                names += "".join(f" {stem}{axis}" for axis in "xyz")
                columns += list(values.T)
        return names, columns

    def ends(self) -> tuple[Floats, np.ndarray]:  # type: ignore[type-arg]
        """Where the lines of contacts end: at the centre of the image of j that touches i, or at the point on the wall. And
        whether they cross a periodic edge."""
        p, pairs = self.packing, self.j >= 0
        j = np.maximum(self.j, 0)
        reach = self.r[self.i] - self.overlap
        there = self.x[self.i] + (reach + np.where(pairs, self.r[j], 0))[:, None] * self.n
        shift = np.zeros_like(there)
        if p.cell == "periodic":
            apart = there - self.x[j]
            rest = apart.copy()
            rows = [[self.box[0], 0, 0], [self.tilt[0], self.box[1], 0], [self.tilt[1], self.tilt[2], self.box[2]]]
            for a in reversed(range(p.dim)):
                rest = rest - np.rint(rest[:, a] / self.box[a])[:, None] * np.array(rows[a])
            shift = apart - rest
        else:
            for a in range(p.dim - 1 if p.cell == "piston" else 0):
                shift[:, a] = np.rint((there[:, a] - self.x[j, a]) / self.box[a]) * self.box[a]
        out = np.where(pairs[:, None], self.x[j] + shift, there)
        return out, pairs & (shift != 0).any(axis=1)


# ---- tables ---------------------------------------------------------------------------------------------------------

def _axes(stem: str, values: Floats, dim: int, unit: str) -> dict[str, tuple[Any, str]]:
    return {f"{stem}{'xyz'[a]}": (values[:, a], unit) for a in range(dim)}


def _table(columns: dict[str, tuple[Any, str]]) -> Table:
    return Table.from_columns({name: values for name, (values, _) in columns.items()},
                              {name: unit for name, (_, unit) in columns.items()})


def grain_columns(e: Export) -> dict[str, tuple[Any, str]]:
    """The columns of grains with their units, for CSV and MAT."""
    length, mass, _, stress, _ = e.units.names
    dim = e.packing.dim
    columns = {"id": (e.ids, ""), **_axes("", e.x, dim, length), "radius": (e.r, length), "mass": (e.mass, mass),
               "contacts": (e.contacts, ""), "rattler": (e.rattler, ""), "pressure": (e.grain_pressure, stress)}
    if e.displacement is not None:
        columns |= _axes("u", e.displacement, dim, "")
    if e.rotation is not None:
        columns |= _axes("r", e.rotation, 3, "")
    return columns


def contact_columns(e: Export) -> dict[str, tuple[Any, str]]:
    """The same of contacts."""
    length, _, force, _, stiffness = e.units.names
    dim = e.packing.dim
    return {"i": (e.i, ""), "j": (e.j, ""), **_axes("n", e.n, dim, ""), "overlap": (e.overlap, length), "Fn": (e.fn, force),
            **_axes("Ft", e.ft, dim, force), "kn": (e.kn, stiffness), "kt": (e.kt, stiffness), "carrying": (e.carrying, "")}


def table_of_grains(e: Export) -> Table:
    return _table(grain_columns(e))


def table_of_contacts(e: Export) -> Table:
    return _table(contact_columns(e))


def scene_of(packing: Packing) -> str:
    return text_of(packing._c.scene) if packing._c.scene != ffi.NULL else ""
