"""The state of an import: grains, contacts and cell, in the packing's units once the grains are gathered."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core import Floats, Integers
from .._packing import CONTACT
from .._records import Material
from .options import NAN, RINGS, SIDES, Column, Options, Roles
from .sheet import Mask, Sheet


def sphere_mass(r: Floats) -> Floats:
    """Of unit density."""
    return np.multiply(4.0 / 3.0 * math.pi * r * r, r)


def running_sum(values: Floats) -> float:
    """The sum from the first to the last, in this order: the same bits everywhere."""
    return float(np.cumsum(values)[-1]) if len(values) else 0.0


def length(v: Floats) -> Floats:
    """Lengths of the rows."""
    return np.sqrt(dot(v, v))


def dot(a: Floats, b: Floats) -> Floats:
    """Products of the rows."""
    x, y, z = (a * b).T
    out: Floats = x + y + z
    return out


def modulus(m: Material) -> float:
    """E* = E / (1 - nu^2)."""
    return m.young / (1 - m.poisson * m.poisson)


# ---- the cell -------------------------------------------------------------------------------------------------------

def lattice(edge: Sequence[float], tilt: Sequence[float]) -> Floats:
    """The lattice vectors of a cell, as rows; of axes that it does not have they are of no use."""
    (xy, xz, yz), (a, b, c) = tilt, [*edge, 1.0, 1.0][:3]
    return np.array([[a, 0, 0], [xy, b, 0], [xz, yz, c]])


def fractions(x: Floats, edge: Sequence[float], tilt: Sequence[float]) -> Floats:
    """Coordinates of points in multiples of the lattice vectors: 0 .. 1 within the cell."""
    rows, s = lattice(edge, tilt), np.zeros_like(x)
    for a in (a for a in reversed(range(x.shape[1])) if rows[a, a] > 0):
        rest = x[:, a]
        for b in range(a + 1, x.shape[1]):
            rest = rest - rows[b, a] * s[:, b]
        s[:, a] = rest / rows[a, a]
    return s


def wrapped(x: Floats, cell: str, edge: Sequence[float], tilt: Sequence[float], periodic: Sequence[bool]) -> Floats:
    """Positions inside of the cell along its periodic axes; those inside remain the same, bit for bit."""
    out, rows = x + 0.0, lattice(edge, tilt)[:, :x.shape[1]]
    for a in (a for a in reversed(range(x.shape[1])) if periodic[a]):
        s = fractions(out, edge, tilt)[:, a]
        # what the packing's check allows
        inside = (s >= -1e-12) & (s <= 1 + 1e-12) if cell == "periodic" else (out[:, a] >= 0) & (out[:, a] < edge[a])
        away = np.flatnonzero(~inside)
        out[away] -= np.floor(s[away])[:, None] * rows[a]
        # a tiny negative coordinate rounds to the far end
        out[away] -= (fractions(out[away], edge, tilt)[:, a] >= 1)[:, None] * rows[a]
    return np.asarray(out + 0.0)


# ---- contacts -------------------------------------------------------------------------------------------------------

class Links:
    """Contacts as columns. j may be a wall, row is that of the sheet (-1: found by its overlap), depth is the overlap
    that the positions give; numbers that are not known are NaN."""

    i: Integers
    j: Integers
    row: Integers
    depth: Floats
    n: Floats
    overlap: Floats
    fn: Floats
    ft: Floats
    kn: Floats
    kt: Floats
    mu: Floats  #: 0 where it is the packing's friction

    def __init__(self, columns: dict[str, Any]) -> None:
        vars(self).update(columns)

    def __len__(self) -> int:
        return len(self.i)

    def __getitem__(self, which: Any) -> Links:
        """Those of a mask or of indices."""
        return Links({name: column[which] for name, column in vars(self).items()})


def links_of(i: npt.ArrayLike, j: npt.ArrayLike) -> Links:
    """Contacts of which only the partners are known."""
    count = len(np.asarray(i))
    columns: dict[str, Any] = {name: np.full(count, NAN) for name in ("depth", "overlap", "fn", "kn", "kt")}
    return Links({"i": np.array(i, np.int64), "j": np.array(j, np.int64), "row": np.full(count, -1), **columns, "mu": np.zeros(count),
                  "n": np.zeros((count, 3)), "ft": np.full((count, 3), NAN)})


def joined(a: Links, b: Links) -> Links:
    """Contacts one behind the other."""
    return Links({name: np.concatenate([column, getattr(b, name)]) for name, column in vars(a).items()})


def known_overlap(links: Links) -> Floats:
    """The overlap that the file gives, or that the positions give."""
    return np.where(np.isnan(links.overlap), links.depth, links.overlap)


def contact_table(links: Links) -> npt.NDArray[Any]:
    """Contacts as the packing has them."""
    out = np.zeros(len(links), CONTACT)
    for name in ("i", "j", "n", "overlap", "fn", "ft", "kn", "kt", "mu"):
        out[name] = getattr(links, name)
    return out


def sum_over(i: Integers, j: Integers, n: int, values: Floats, sign: float = -1.0) -> Floats:
    """Sums of values [contacts][k] over the contacts i, j of each of n grains, on j times `sign`. They are taken
    contact by contact: the same bits everywhere."""
    ends = np.stack([i, j], axis=1).ravel()
    grains = ends >= 0
    signs = np.tile([1.0, sign], len(i))[grains]
    return np.stack([np.bincount(ends[grains], signs * np.repeat(column, 2)[grains], n) for column in values.T], axis=1)


# ---- what is known --------------------------------------------------------------------------------------------------

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
    elsewhere: float = NAN  #: the same of grains that touch no wall
    hertz: float = NAN  #: median of Fn over Hertz's law at the overlap; NaN: one follows from the other
    hertz_spread: float = NAN  #: largest deviation of that ratio from its median
    overlap_error: float = NAN  #: error of overlaps from the digits in the file, over the mean overlap
    mean_diameter: float = NAN  #: in the units of the file
    scale: float = 1.0  #: of lengths: d in the units of the file, inverse
    notes: list[str] = dataclasses.field(default_factory=list)

    def lines(self, path: str) -> list[str]:
        """What the command prints."""
        within = abs(self.hertz - 1) + self.hertz * self.hertz_spread
        hertz = f"; normal forces follow Hertz's law within {within:.1e}" if math.isfinite(self.hertz) else ""
        first = (f"{path}: {self.form}, {self.grains} grains, {self.contacts} contacts, {self.wall_contacts} of them "
                 f"with walls; largest net force {self.balance:.2g} of the mean"
                 + (f" at walls, {self.elsewhere:.2g} elsewhere" if self.balance > 10 * self.elsewhere else "") + hertz)
        many = self.left_out > 1
        text = f"{self.left_out} grain{'s' * many} of other types {'are' if many else 'is'} left out"
        return [first, *([text] if self.left_out else []), *self.notes[:16]]


class Work:
    """What is known so far. axis[a] of the file is axis a of the packing, the last of which is up."""

    def __init__(self, path: str, options: Options, form: str,
                 sheets: tuple[Sheet, Sheet | None, Sheet | None]) -> None:
        self.path, self.o, self.form = path, options, form
        self.grains, self.contacts, self.walls = sheets
        self.roles, self.report = Roles(options.columns), Report(form)
        self.material: Material | None = options.material
        self.dim, self.axis = 0, [0, 1, 2]
        self.row: Integers = np.zeros(0, np.int64)  # of the sheet
        self.id: Integers = np.zeros(0, np.int64)  # ascending
        self.x: Floats = np.zeros((0, 3))
        self.r: Floats = np.zeros(0)
        self.mass: Floats | None = None
        self.inertia: Floats | None = None
        self.boundary: Mask = np.zeros(0, bool)
        self.links = links_of([], [])
        self.cell = "piston"
        self.low, self.edge, self.tilt = [0.0] * 3, [0.0] * 3, [0.0] * 3
        self.periodic, self.open = [False] * 3, [False] * 3  # open: wider than all grains, for the file has no period
        self.cut = False
        self.has_wall = [False] * 6  # whether the positions of bottom, top, left, ... are known
        self.gravity, self.scale, self.force, self.stiffness = 0.0, 1.0, 1.0, 1.0
        self.place, self.force_place, self.mass_place = 0.0, NAN, 0.0
        self.has_forces = self.has_ft = False
        self.pointed = False  # whether points of contact tell where walls are
        self.balanced = False  # whether forces of walls are from the balance of the grains
        self.wall, self.friction, self.poisson = "rigid", NAN, NAN

    @property
    def n(self) -> int:
        """Number of grains."""
        return len(self.r)

    @property
    def up(self) -> int:
        """The axis between the walls."""
        return self.dim - 1

    def note(self, text: str) -> None:
        """Something that the user should know."""
        self.report.notes.append(text)

    def pressure_text(self, pressure: float) -> str:
        """A pressure, in kPa too where the material is known."""
        si = "" if self.material is None else f" E* ({1e-3 * pressure * modulus(self.material):.6g} kPa)"
        return f"{pressure:.6g}{si}"

    def length_text(self, value: float) -> str:
        """A length, in mm too where the material is known."""
        return f"{value:.6g}" + ("" if self.material is None else f" d ({1e3 * value * self.material.diameter:.6g} mm)")

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

    @property
    def sides(self) -> list[int]:
        """Those walls of SIDES that the cell has."""
        return [side for side in range(2 * self.dim) if self.has_side(-1 - side)]

    def size_key(self, axis: int) -> str:
        """The key of the edge along an axis."""
        return "height" if axis == self.up else "width" if axis == 0 else "depth"

    def name_of(self, axis: int) -> str:
        """The name that an axis of the packing has in the file."""
        return "xyz"[self.axis[axis]]

    def separation(self, i: Integers, j: Integers) -> Floats:
        """Vectors from grains i to the nearest images of grains j."""
        d: Floats = self.x[j] - self.x[i]
        lattice = self.lattice()
        for a in reversed(range(self.dim)):
            if self.periodic[a]:
                d -= np.rint(d[:, a] / self.edge[a])[:, None] * lattice[a]
        return d

    def place_links(self, links: Links) -> None:
        """Fills in n and depth of contacts of two grains, or of a grain and a flat wall."""
        pairs = links.j >= 0
        d = self.separation(links.i[pairs], links.j[pairs])
        apart = length(d)
        links.n[pairs] = np.where(apart[:, None] > 0, d / apart[:, None], 0)
        links.depth[pairs] = self.r[links.i[pairs]] + self.r[links.j[pairs]] - apart
        for side in range(6 if self.cell != "ring" else 0):
            here = links.j == -1 - side
            if not here.any():
                continue
            axis, i, far = self.axis_of(-1 - side), links.i[here], side % 2
            links.n[here] = 0
            links.n[here, axis] = 1 if far else -1
            place = self.x[i, axis]
            links.depth[here] = self.r[i] - (self.edge[axis] - place if far else place) if self.has_wall[side] else NAN

        if self.cell == "ring":
            walls = ~pairs
            out, level = self.ring_of(self.x[links.i[walls]])
            far = links.j[walls] == -2
            links.n[walls] = np.where(far, 1, -1)[:, None] * out
            known = np.where(far, self.has_wall[1], self.has_wall[0])
            links.depth[walls] = np.where(known, self.r[links.i[walls]] - np.where(far, self.edge[1] - level, level), NAN)

    def ring_of(self, x: Floats) -> tuple[Floats, Floats]:
        """Outward unit vectors at points of a ring, and the distances of the points from its inner wall."""
        outer = 0.5 * self.edge[0]
        d = x - outer
        d[:, 2] = 0
        radius = length(d)
        return d / radius[:, None], radius - (outer - self.edge[1])

    def wall_gap(self, links: Links) -> Floats:
        """Distances of the centres of grains i from walls j."""
        if self.cell == "ring":
            level = self.ring_of(self.x[links.i])[1]
            return np.where(links.j == -2, self.edge[1] - level, level)
        axis = np.array([self.axis_of(j) for j in links.j.tolist()], dtype=np.int64)
        place: Floats = self.x[links.i, axis]
        return np.where(links.j % 2 == 0, np.array(self.edge)[axis] - place, place)

    def volume(self) -> float:
        """Of the cell."""
        if self.cell == "ring":
            return math.pi * self.edge[0] * self.edge[1] * (1 - self.edge[1] / self.edge[0])
        return math.prod(self.edge[:self.dim])

    def side_name(self, wall: int) -> str:
        """The name of a wall."""
        return (RINGS if self.cell == "ring" else SIDES)[-1 - wall]

    def goes_across(self, links: Links) -> Mask:
        """Whether contacts lead through the face at which the box is cut."""
        far: Mask = np.abs(self.x[links.j, self.up] - self.x[links.i, self.up]) > 0.5 * self.edge[self.up]
        return far & (links.j >= 0) & self.cut

    def fractions(self, x: Floats) -> Floats:
        return fractions(x, self.edge, self.tilt)

    def lattice(self) -> Floats:
        """The lattice vectors of the cell."""
        return lattice(self.edge, self.tilt)
