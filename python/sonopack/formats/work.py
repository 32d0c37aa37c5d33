"""The state of an import: grains, contacts and cell, in the packing's units from scale_grains on."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from .._core import Floats, Integers
from .._packing import CONTACT, Packing
from .._records import Material
from .options import NAN, SIDES, Column, Options, Roles
from .sheet import Sheet

PI = 3.14159265358979323846


def sphere_mass(r: Floats) -> Floats:
    """Of unit density."""
    mass: Floats = 4.0 / 3.0 * PI * r * r * r
    return mass


def running_sum(values: Floats) -> float:
    """The sum from the first to the last, in this order: the same bits everywhere."""
    return float(np.cumsum(values)[-1]) if len(values) else 0.0


def length(v: Floats) -> Floats:
    """Lengths of the rows."""
    out: Floats = np.sqrt(v[:, 0] * v[:, 0] + v[:, 1] * v[:, 1] + v[:, 2] * v[:, 2])
    return out


def dot(a: Floats, b: Floats) -> Floats:
    out: Floats = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]
    return out


def modulus(m: Material) -> float:
    """E* = E / (1 - nu^2)."""
    return m.young / (1 - m.poisson * m.poisson)


class Links:
    """Contacts as columns; numbers that are not known are NaN. j may be a wall; row -1: found by its overlap."""

    _FIELDS = {"i": "i8", "j": "i8", "row": "i8", "depth": "f8", "overlap": "f8", "fn": "f8", "kn": "f8", "kt": "f8"}

    def __init__(self, count: int = 0) -> None:
        self.i: Integers = np.zeros(count, np.int64)
        self.j: Integers = np.zeros(count, np.int64)
        self.row: Integers = np.full(count, -1, np.int64)
        self.depth, self.overlap, self.fn, self.kn, self.kt = (np.full(count, NAN) for _ in range(5))
        self.n: Floats = np.zeros((count, 3))
        self.ft: Floats = np.full((count, 3), NAN)

    def __len__(self) -> int:
        return len(self.i)

    def take(self, which: np.ndarray) -> Links:  # type: ignore[type-arg]
        """Those of a mask or of indices."""
        out = Links()
        for name in (*self._FIELDS, "n", "ft"):
            setattr(out, name, getattr(self, name)[which])
        return out

    def __add__(self, other: Links) -> Links:
        out = Links()
        for name in (*self._FIELDS, "n", "ft"):
            setattr(out, name, np.concatenate([getattr(self, name), getattr(other, name)]))
        return out

    def known_overlap(self) -> Floats:
        """The overlap that the file gives, or that the positions give."""
        return np.where(np.isnan(self.overlap), self.depth, self.overlap)

    def table(self) -> np.ndarray:  # type: ignore[type-arg]
        """As the packing has them."""
        out = np.zeros(len(self), CONTACT)
        for name in ("i", "j", "n", "overlap", "fn", "ft", "kn", "kt"):
            out[name] = getattr(self, name)
        return out


@dataclasses.dataclass
class Report:
    """What was read, for the user's eyes. NaN: not known."""

    form: str = ""
    grains: int = 0
    contacts: int = 0
    wall_contacts: int = 0
    left_out: int = 0  #: grains of other types
    across: int = 0  #: contacts left out, across a periodic edge on the axis up
    balance: float = NAN  #: largest net force on a force-carrying grain over the mean contact force
    hertz: float = NAN  #: median of Fn over Hertz's law at the overlap; NaN: one follows from the other
    hertz_spread: float = NAN  #: largest deviation of that ratio from its median
    overlap_error: float = NAN  #: error of overlaps from the digits in the file, over the mean overlap
    mean_diameter: float = NAN  #: in the units of the file
    notes: list[str] = dataclasses.field(default_factory=list)

    def lines(self, path: str) -> list[str]:
        """What the command prints."""
        within = abs(self.hertz - 1) + self.hertz * self.hertz_spread
        hertz = f"; normal forces follow Hertz's law within {within:.1e}" if math.isfinite(self.hertz) else ""
        first = (f"{path}: {self.form}, {self.grains} grains, {self.contacts} contacts, {self.wall_contacts} of them with "
                 f"walls; largest net force {self.balance:.2g} of the mean{hertz}")
        many = self.left_out > 1
        out = [f"{self.left_out} grain{'s' * many} of other types {'are' if many else 'is'} left out"] if self.left_out else []
        return [first, *out, *self.notes[:16]]


class Work:
    """What is known so far. axis[a] of the file is axis a of the packing, the last of which is up."""

    def __init__(self, path: str, options: Options, form: str, grains: Sheet, contacts: Sheet | None,
                 walls: Sheet | None) -> None:
        self.path, self.o, self.form = path, options, form
        self.grains, self.contacts, self.walls = grains, contacts, walls
        self.roles = Roles(options.columns)
        self.report = Report(form)
        self.material: Material | None = options.material
        self.dim, self.axis = 0, [0, 1, 2]
        self.row: Integers = np.zeros(0, np.int64)  # of the sheet
        self.id: Integers = np.zeros(0, np.int64)  # ascending
        self.x: Floats = np.zeros((0, 3))
        self.r: Floats = np.zeros(0)
        self.mass: Floats | None = None
        self.inertia: Floats | None = None
        self.boundary: np.ndarray = np.zeros(0, bool)  # type: ignore[type-arg]
        self.links = Links()
        self.cell = "piston"
        self.low, self.edge, self.tilt = [0.0] * 3, [0.0] * 3, [0.0] * 3
        self.periodic, self.open = [False] * 3, [False] * 3  # open: wider than all grains, for the file has no period
        self.cut = False
        self.has_wall = [False] * 6  # whether the positions of bottom, top, left, ... are known
        self.gravity, self.scale, self.force, self.stiffness = 0.0, 1.0, 1.0, 1.0
        self.place, self.force_place, self.mass_place = 0.0, NAN, 0.0
        self.has_forces = self.has_ft = self.springs = False
        self.wall, self.friction, self.poisson = "rigid", NAN, NAN

    @property
    def n(self) -> int:
        return len(self.r)

    @property
    def up(self) -> int:
        return self.dim - 1

    def note(self, text: str) -> None:
        self.report.notes.append(text)

    def pressure_text(self, pressure: float) -> str:
        if self.material is None:
            return f"{pressure:.6g}"
        return f"{pressure:.6g} E* ({1e-3 * pressure * modulus(self.material):.6g} kPa)"

    def length_text(self, value: float) -> str:
        return f"{value:.6g}" if self.material is None else f"{value:.6g} d ({1e3 * value * self.material.diameter:.6g} mm)"

    # ---- columns ----------------------------------------------------------------------------------------------------

    def column(self, sheet: Sheet, at: Column | None, rows: Integers | None = None) -> Floats | None:
        """The numbers of a column, which must be finite; None: there is no column."""
        return None if at is None else sheet.finite(at[0], rows) * at[1]

    def vectors(self, sheet: Sheet, at: list[Column], rows: Integers | None = None) -> Floats:
        """[rows][3]; 0 on axes that the packing does not have."""
        out = np.zeros((sheet.rows if rows is None else len(rows), 3))
        for axis, (column, sign) in enumerate(at):
            out[:, axis] = sheet.finite(column, rows) * sign
        return out

    def grain_of(self, ids: Integers) -> Integers:
        """Indices of the grains with these ids; -1: none."""
        at = np.searchsorted(self.id, ids)
        at[at == self.n] = 0
        return np.where(self.id[at] == ids, at, -1)

    # ---- geometry ---------------------------------------------------------------------------------------------------

    def wall_on(self, axis: int, sign: float) -> int:
        """The wall on this axis that lies in the direction of `sign`."""
        low = -1 if axis == self.up else -3 if axis == 0 else -5
        return low if sign < 0 else low - 1

    def axis_of(self, wall: int) -> int:
        """The axis across a wall."""
        return self.up if wall >= -2 else 0 if wall >= -4 else 1

    def has_side(self, wall: int) -> bool:
        """Whether the cell has this wall."""
        if not -6 <= wall < 0 or self.cell == "periodic":
            return False
        return wall >= -2 or (self.cell == "box" and self.axis_of(wall) < self.up)

    def wall_given(self, wall: int) -> float:
        """The place that an option gives to a wall, in units of the file; NaN: none."""
        return self.o.number(SIDES[-1 - wall])

    def size_key(self, axis: int) -> str:
        return "height" if axis == self.up else "width" if axis == 0 else "depth"

    def name_of(self, axis: int) -> str:
        """The name that an axis of the packing has in the file."""
        return "xyz"[self.axis[axis]]

    def separation(self, i: Integers, j: Integers) -> Floats:
        """Vectors from grains i to the nearest images of grains j."""
        d: Floats = self.x[j] - self.x[i]
        for a in reversed(range(self.dim)):
            if not self.periodic[a]:
                continue
            periods = np.rint(d[:, a] / self.edge[a])
            d[:, a] -= self.edge[a] * periods
            if a == 1:
                d[:, 0] -= self.tilt[0] * periods
            if a == 2:
                d[:, 0] -= self.tilt[1] * periods
                d[:, 1] -= self.tilt[2] * periods
        return d

    def place_links(self, links: Links) -> None:
        """Fills in n and depth of contacts of two grains, or of a grain and a flat wall."""
        pairs = links.j >= 0
        d = self.separation(links.i[pairs], links.j[pairs])
        apart = length(d)
        with np.errstate(invalid="ignore", divide="ignore"):
            links.n[pairs] = np.where(apart[:, None] > 0, d / apart[:, None], 0)
        links.depth[pairs] = self.r[links.i[pairs]] + self.r[links.j[pairs]] - apart
        for side in range(6):
            here = links.j == -1 - side
            if not here.any():
                continue
            axis, i, far = self.axis_of(-1 - side), links.i[here], side % 2
            links.n[here] = 0
            links.n[here, axis] = 1 if far else -1
            place = self.x[i, axis]
            links.depth[here] = self.r[i] - (self.edge[axis] - place if far else place) if self.has_wall[side] else NAN

    def goes_across(self, i: Integers, j: Integers) -> np.ndarray:  # type: ignore[type-arg]
        """Whether contacts lead through the face at which the box is cut."""
        far: np.ndarray = np.abs(self.x[j, self.up] - self.x[i, self.up]) > 0.5 * self.edge[self.up]  # type: ignore[type-arg]
        return far & (j >= 0) & self.cut


def fractions(w: Work, x: Floats) -> list[Floats]:
    """Coordinates of points in multiples of the lattice vectors: 0 .. 1 within the cell."""
    e, (xy, xz, yz) = w.edge, w.tilt
    s2 = x[:, 2] / e[2] if w.dim == 3 else np.zeros(len(x))
    s1 = (x[:, 1] - yz * s2) / e[1] if w.dim >= 2 else np.zeros(len(x))
    return [(x[:, 0] - xy * s1 - xz * s2) / e[0], s1, s2]


#: the packing that is made, and what there is to say about it
Made = tuple[Packing, Report]
