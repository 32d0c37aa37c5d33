"""Histograms of contacts over packings: directions (Fig. 2 of Somfai et al. 2005), forces and stiffnesses (Fig. 1(c))."""
from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from .._core import Floats, Refused, SonopackError, Status, invalid
from .._packing import Packing
from .._table import Table
from ._units import refuse

ANGLES = {2: 36, 3: 12}  # bins around 0, 5, ... (3D: 15, ...) degrees; n and -n are equivalent
VALUES, WIDTH = 100, 0.1  # bins of a value over its mean in the same packing
EQUAL = 1 + 1e-9          # a force equal to the mean up to rounding is not above it


class ContactCounts:
    """Densities of the contacts of packings, which are added one at a time: each packing has integral 1."""

    def __init__(self) -> None:
        self.dim = self.packings = 0
        self.contacts = self.strong = self.beyond = 0.0
        self._angles: dict[str, list[Floats]] = {"all": [], "strong": [], "weak": []}
        self._values: dict[str, list[Floats]] = {"forces": [], "stiffnesses": []}

    def add(self, packing: Packing, threshold: float = 1e-4, margin: float = 3.0) -> None:
        """Adds the contacts between grains that carry, at least `margin` [d] from all walls. Strong ones have a normal
        force above the mean of these contacts, the others are weak."""
        if not (margin >= 0 and np.isfinite(margin)):
            raise invalid("margin", f"{margin:g}, must be a distance from the walls, 0 or above")
        if self.dim not in (0, packing.dim):
            raise invalid("", f"a packing in {packing.dim} dimensions after one in {self.dim}, must be of one kind")
        c = packing.contacts[packing.carrying(threshold) & _inside(packing, margin)]
        if len(c) == 0:
            raise _nothing(packing, margin)
        r = packing.r[c["i"]], packing.r[c["j"]]
        stiffness = np.where(c["kn"] > 0, c["kn"],
                             2 * (0.5 * np.sqrt(r[0] * r[1] / (r[0] + r[1]))) * np.sqrt(np.maximum(c["overlap"], 0)))
        strong = c["fn"] > EQUAL * c["fn"].mean()
        for name, of in (("all", np.full(len(c), True)), ("strong", strong), ("weak", ~strong)):
            if np.any(of) and packing.dim > 1:
                self._angles[name].append(_directions(packing.dim, c["n"][of]))
        for name, value in (("forces", c["fn"]), ("stiffnesses", stiffness)):
            numbers = np.bincount(np.minimum(value / value.mean() / WIDTH, VALUES).astype(int), minlength=VALUES + 1)
            self._values[name].append(numbers[:VALUES] / (len(c) * WIDTH))
            self.beyond += numbers[VALUES] / len(c) if name == "forces" else 0
        self.dim, self.packings = packing.dim, self.packings + 1
        self.contacts, self.strong = self.contacts + len(c), self.strong + np.count_nonzero(strong)

    def angles(self) -> Table:
        """Densities over that of isotropic directions: angle [degrees], all, strong, weak, with standard errors over
        packings. In three dimensions angles are those of elevation; a and 180 - a have the same contacts."""
        if self.dim == 1:
            raise Refused("directions of contacts are counted in 2 or 3 dimensions, the packings have 1",
                          Status.EREFUSED)
        of = ("of elevation, whatever the direction along the walls, " if self.dim == 3 else "")
        angle = 180 * np.arange(ANGLES.get(self.dim, 0)) / ANGLES.get(self.dim, 1)
        return self._table("angle", angle, self._angles, f"dimension = {self.dim}",
                           f"density of contact directions over that of isotropic ones; angle {of}in degrees from the "
                           "walls, n and -n are the same", f"strong_part = {self.strong / max(self.contacts, 1):.6g}")

    def values(self) -> Table:
        """Densities of normal forces and stiffnesses over their means, with standard errors over packings."""
        filled = [int(np.flatnonzero(density)[-1]) for of in self._values.values() for density in of if np.any(density)]
        rows = max([1, *filled]) + 1
        kept = {name: [density[:rows] for density in densities] for name, densities in self._values.items()}
        return self._table("x", WIDTH * (np.arange(rows) + 0.5), kept,
                           "densities of normal forces and stiffnesses over their means; areas 1, x is the middle of a "
                           "bin", f"beyond = {self.beyond / max(self.packings, 1):.6g}")

    def _table(self, first: str, x: Floats, of: dict[str, list[Floats]], *comments: str) -> Table:
        if self.packings == 0:
            raise Refused("no packing was counted", Status.EREFUSED)
        columns = {first: x}
        for name, densities in of.items():
            n, nothing = len(densities), np.full(len(x), np.nan)
            columns[name] = np.mean(densities, axis=0) if n > 0 else nothing
            columns[f"{name}_err"] = np.std(densities, axis=0, ddof=1) / np.sqrt(n) if n > 1 else nothing
        table = Table.from_columns(columns)
        for comment in (f"packings = {self.packings}", f"contacts = {self.contacts:.0f}", *comments):
            table.add_comment(comment)
        return table


def _inside(packing: Packing, margin: float) -> npt.NDArray[np.bool_]:
    """Contacts between grains whose point is at least `margin` from all walls."""
    c = packing.contacts
    point = packing.x[c["i"]] + c["n"] * (packing.r[c["i"]] - 0.5 * c["overlap"])[:, None]
    inside: npt.NDArray[np.bool_] = c["j"] >= 0
    if packing.cell == "ring":  # the distance from the inner wall in place of y
        outer = 0.5 * packing.box[0]
        point[:, 1] = np.hypot(*(point[:, :2] - outer).T) - (outer - packing.box[1])
    for axis in _bounded(packing):
        inside = inside & (point[:, axis] >= margin) & (point[:, axis] <= packing.box[axis] - margin)
    return inside


def _bounded(packing: Packing) -> list[int]:
    """Axes with walls, the last first."""
    walls: dict[str, list[int]] = {"piston": [packing.dim - 1], "periodic": [], "ring": [1],
                                   "box": list(range(packing.dim - 1, -1, -1))}
    return walls[packing.cell]


def _nothing(packing: Packing, margin: float) -> Refused:
    for axis in _bounded(packing):
        edge = packing.box[axis]
        if edge <= 2 * margin:
            name = "height" if axis == packing.dim - 1 else "width"
            return Refused(f"{name} {edge:g} is too small for a bulk {margin:g} from both walls, must be above "
                           f"{2 * margin:g}", Status.EREFUSED)
    return Refused(f"no contact between grains carries a force at least {margin:g} from both walls", Status.EREFUSED)


def _directions(dim: int, n: Floats) -> Floats:
    """Density over that of isotropic directions. In three dimensions the angle is that of elevation above the
    horizontal, and the bins are wider: few directions are nearly upright. Bin b and bins - b are on both sides of the
    vertical and hold the same contacts."""
    bins = ANGLES[dim]
    angle = np.arcsin(np.minimum(1, np.abs(n[:, 2]))) if dim == 3 else np.arctan2(n[:, 1], n[:, 0])
    counted = np.bincount(((np.floor(angle / np.pi * bins + 0.5) + bins) % bins).astype(int), minlength=bins)
    if dim == 2:
        return counted / (len(n) * (1 / bins))
    level = np.minimum(np.arange(bins), bins - np.arange(bins))
    low, high = np.maximum(level - 0.5, 0) * np.pi / bins, np.minimum((level + 0.5) * np.pi / bins, 0.5 * np.pi)
    density: Floats = counted[level] / (len(n) * (np.sin(high) - np.sin(low)))
    return density


def contact_counts(packings: Iterable[tuple[str, Packing]], threshold: float, margin: float) -> ContactCounts:
    """The counts of packings, which have names for messages."""
    counts = ContactCounts()
    for name, packing in packings:
        try:
            counts.add(packing, threshold, margin)
        except SonopackError as fault:
            raise refuse(name, str(fault)) from None
    return counts
