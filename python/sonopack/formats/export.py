"""What files of other programs list of a packing: its numbers in their units, sums over the contacts of each grain, and
displacements."""
from __future__ import annotations

import dataclasses
import io
import os
from typing import Any

import numpy as np

from .. import __version__
from .._core import Floats
from .._packing import Packing
from .._records import Material
from ._faults import refused
from .law import eta, stiffness_of
from .sheet import Mask
from .work import modulus, sphere_mass, sum_over


@dataclasses.dataclass(frozen=True)
class Units:
    """What a number of a packing is multiplied by, and the names of the units."""

    length: float = 1.0
    mass: float = 1.0
    density: float = 1.0
    force: float = 1.0
    stress: float = 1.0
    stiffness: float = 1.0
    #: of length, mass, force, stress, stiffness, moment of inertia
    names: tuple[str, ...] = ("d", "rho d^3", "E* d^2", "E*", "E* d", "rho d^5")
    all: str = "d, E*, rho"

    @classmethod
    def of(cls, m: Material | None) -> Units:
        """SI units of grains of a material; None: the packing's own."""
        if m is None:
            return cls()
        d, stress = m.diameter, modulus(m)
        return cls(d, m.density * d * d * d, m.density, stress * d * d, stress, stress * d,
                   ("m", "kg", "N", "Pa", "N/m", "kg m^2"), "SI")


def number_text(value: float) -> str:
    """A number with the fewest digits, 15 to 17, that read back exactly."""
    for digits in (15, 16):
        text = f"{value:.{digits}g}"
        if float(text) == value:
            return text
    return f"{value:.17g}"


def rows_of(columns: list[Any], first: str = "", between: str = " ") -> bytes:
    """Rows of numbers and words; first: begins each."""
    texts = [[number_text(value) if isinstance(value, float) else str(value) for value in np.asarray(column).tolist()]
             for column in columns]
    return "".join(f"{first}{between.join(row)}\n" for row in zip(*texts)).encode()


def mat_file(values: dict[str, Any], **words: Any) -> bytes:
    """The bytes of a MATLAB 5 MAT-file with these variables. words: of scipy's savemat."""
    import scipy.io

    sizes = [sum(map(np.size, value.values())) if isinstance(value, dict) else np.size(value) for value in values.values()]
    if 8 * max(sizes) > 0x7fffffff:
        raise refused("a variable has more than 2 GB, the limit of a MAT-file")
    out = io.BytesIO()
    scipy.io.savemat(out, values, oned_as="column", **words)
    head = f"MATLAB 5.0 MAT-file, written by sonopack {__version__}".encode()
    return head.ljust(116) + out.getvalue()[116:]  # without the date: the same bytes on every run


def beside(path: str, suffix: str) -> str:
    """NAME + suffix for NAME.ending, NAME + suffix + .gz for NAME.ending.gz."""
    plain = path.removesuffix(".gz")
    return os.path.splitext(plain)[0] + suffix + path[len(plain):]


class Export:
    """A packing in the units of a file. displacement, rotation [n][3] are written as they are."""

    def __init__(self, packing: Packing, path: str, si: Material | None = None, displacement: Floats | None = None,
                 rotation: Floats | None = None) -> None:
        p, u = packing, Units.of(si)
        self.packing, self.units, self.path = packing, u, path
        self.displacement, self.rotation = displacement, rotation
        self.ids = np.arange(p.n)
        self.box = [p._c.box[a] * u.length for a in range(3)]
        self.tilt = [t * u.length for t in p.tilt]
        self.pressure, self.gravity = p.pressure * u.stress, p.gravity * u.stress / (u.density * u.length)
        self.special = p.cell != "piston" or p.gravity != 0
        #: the edges of the smallest box around the cell, and what the heads of other programs' files say of the cell
        self.frame, n = list(self.box), number_text
        self.said = f" cell={p.cell} gravity={n(self.gravity)}" if self.special else ""
        if p.cell == "ring":
            outer = 0.5 * self.box[0]
            self.frame[1] = self.box[0]
            self.said += f" inner={n(outer - self.box[1])} outer={n(outer)} x0={n(outer)} y0={n(outer)}"
        self.x, self.r = np.array(p.x) * u.length, np.array(p.r) * u.length
        self.mass = (sphere_mass(np.array(p.r)) if p.mass is None else np.array(p.mass)) * u.mass
        self.inertia = None if p.inertia is None else p.inertia * (u.mass * u.length**2)
        self.density = np.full(p.n, u.density) if p.mass is None else self.mass / sphere_mass(self.r)
        self._derive()

    def _derive(self) -> None:
        """Sums over contacts, in the packing's own units: its threshold of forces needs them."""
        p, u, c = self.packing, self.units, self.packing.contacts
        self.i, self.j, self.n = c["i"].astype(np.int64), c["j"].astype(np.int64), np.array(c["n"])
        force = c["ft"] - c["fn"][:, None] * c["n"] + 0.0
        self.rattler, self.carrying = p.rattlers().astype(int), p.carrying().astype(int)
        self.contacts = sum_over(self.i, self.j, p.n, self.carrying[:, None], 1.0)[:, 0].astype(int)
        self.net = sum_over(self.i, self.j, p.n, force) * u.force
        ends = np.stack([self.i, self.j], axis=1).ravel()
        at, of = np.repeat(np.arange(len(c)), 2)[ends >= 0], ends[ends >= 0]
        branch, volume = p.r[of, None] * self.n[at], sphere_mass(np.array(p.r))[of]
        stress = np.stack([np.bincount(of, -(branch[:, k // 3] * force[at, k % 3] / volume), p.n) for k in range(9)],
                          axis=1) + 0.0  # sum of (branch) x (force) over the grain's volume; positive in compression
        self.grain_pressure = (stress[:, 0] + stress[:, 4] + stress[:, 8]) / p.dim * u.stress
        self.stress = stress * u.stress
        self.overlap, self.fn, self.ft = c["overlap"] * u.length, c["fn"] * u.force, c["ft"] * u.force
        self.force = self.ft - self.fn[:, None] * self.n + 0.0
        own = c["kn"] > 0
        hertz = 2.0 * stiffness_of(p.r, self.i, self.j, p.wall) * np.sqrt(np.fmax(c["overlap"], 0.0))
        kn = np.where(own, c["kn"], hertz)
        usual = eta(p.poisson) * kn if p.friction > 0 and p.dim > 1 else 0 * kn
        self.kn, self.kt = kn * u.stiffness, np.where(own, c["kt"], usual) * u.stiffness
        self.springs, self.mu = bool(own.any()), c["mu"] if (c["mu"] > 0).any() else None

    def periodic(self, axis: int) -> bool:
        """Whether the cell is periodic along an axis."""
        return self.packing.cell == "periodic" or (self.packing.cell == "piston" and axis < self.packing.dim - 1)

    def vectors(self, displacement: str, rotation: str) -> tuple[str, list[Floats]]:
        """Names and columns of moments of inertia, displacements and rotations, if there are any, as a row lists them."""
        names, columns = ("", []) if self.inertia is None else (" inertia", [self.inertia])
        for stem, values in ((displacement, self.displacement), (rotation, self.rotation)):
            if values is not None:
                names += "".join(f" {stem}{axis}" for axis in "xyz")
                columns += list(values.T)
        return names, columns

    def ends(self) -> tuple[Floats, Mask]:
        """Where the lines of contacts end: at the centre of the image of j that touches i, or at the point on the wall.
        And whether they cross a periodic edge."""
        pairs, j = self.j >= 0, np.maximum(self.j, 0)
        there = self.x[self.i] + (self.r[self.i] - self.overlap + np.where(pairs, self.r[j], 0))[:, None] * self.n
        (a, b, c), (xy, xz, yz) = self.box, self.tilt
        lattice, rest = np.array([[a, 0, 0], [xy, b, 0], [xz, yz, c]]), there - self.x[j]
        shift = np.zeros_like(there)
        for axis in reversed(range(self.packing.dim)):
            if self.periodic(axis):
                step = np.rint(rest[:, axis] / self.box[axis])[:, None] * lattice[axis]
                rest, shift = rest - step, shift + step
        return np.where(pairs[:, None], self.x[j] + shift, there), pairs & (shift != 0).any(axis=1)


# ---- tables ---------------------------------------------------------------------------------------------------------

#: the columns of a table with their units
Columns = dict[str, tuple[Any, str]]


def _axes(stem: str, values: Floats, dim: int, unit: str = "") -> Columns:
    return {f"{stem}{'xyz'[a]}": (values[:, a], unit) for a in range(dim)}


def grain_columns(e: Export) -> Columns:
    """The columns of grains with their units, for CSV and MAT."""
    length, mass, _, stress, _, inertia = e.units.names
    dim = e.packing.dim
    columns = {"id": (e.ids, ""), **_axes("", e.x, dim, length), "radius": (e.r, length), "mass": (e.mass, mass),
               "contacts": (e.contacts, ""), "rattler": (e.rattler, ""), "pressure": (e.grain_pressure, stress)}
    columns |= {} if e.inertia is None else {"inertia": (e.inertia, inertia)}
    columns |= {} if e.displacement is None else _axes("u", e.displacement, dim)
    return columns | ({} if e.rotation is None else _axes("r", e.rotation, 3))


def contact_columns(e: Export) -> Columns:
    """The same of contacts."""
    length, _, force, _, stiffness, _ = e.units.names
    dim = e.packing.dim
    own = {} if e.mu is None else {"mu": (e.mu, "")}
    return {"i": (e.i, ""), "j": (e.j, ""), **_axes("n", e.n, dim), "overlap": (e.overlap, length), "Fn": (e.fn, force),
            **_axes("Ft", e.ft, dim, force), "kn": (e.kn, stiffness), "kt": (e.kt, stiffness),
            **own, "carrying": (e.carrying, "")}
