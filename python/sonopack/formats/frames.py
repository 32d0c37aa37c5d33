"""Packings of several frames: the place of each in the series, and how far its cell has been strained since the first."""
from __future__ import annotations

import numpy as np

from .._core import Floats
from .._packing import Packing


def _lattice(p: Packing) -> Floats:
    """Lattice vectors as columns, or edges of cells with walls, in the units of the file."""
    cell = np.diag([*p.box, 1.0, 1.0][:3])
    cell[0, 1], cell[0, 2], cell[1, 2] = p.tilt
    scale: float = p.report.scale if p.report else 1.0
    return np.asarray(cell / scale)


class Series:
    """Gives packings of one series, in their order, frames and strains."""

    def __init__(self) -> None:
        self._first: Floats | None = None
        self._last = np.zeros((3, 3))

    def add(self, p: Packing, frame: float | None) -> Packing:
        """The packing of a frame, unless it has one already. The tilt of a lattice is known but for whole vectors: the one
        nearest to that of the last frame is taken."""
        if frame is None or not np.isnan(p.frame):
            return p
        cell = _lattice(p)
        if self._first is None:
            self._first = self._last = cell
        for a, b in ((1, 2), (0, 2), (0, 1)):
            if p.cell == "periodic":
                cell[:, b] -= cell[:, a] * np.rint(cell[a, b] / cell[a, a] - self._last[a, b] / self._last[a, a])
        self._last = cell
        change = cell @ np.linalg.inv(self._first)
        strain = {f"e_{axis}{axis}": 0.0 - float(np.log(cell[a, a] / self._first[a, a])) for a, axis in enumerate("xyz"[:p.dim])}
        if p.cell == "periodic":
            strain |= {f"e_{'xyz'[a]}{'xyz'[b]}": 0.0 - float(change[a, b]) for a in range(p.dim) for b in range(a + 1, p.dim)}
        p.set_series(frame, strain)
        return p
