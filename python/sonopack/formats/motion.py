"""Displacements that convert writes beside the grains: of a mode, or at times after a pulse; computed, or read from
files."""
from __future__ import annotations

import numpy as np

from .._command import Failed
from .._core import Floats, c_path
from .._native import lib
from .._packing import Packing
from ..plot._inputs import Input
from ..plot._motion import Motion, find_mode, find_snapshots


def find(packing: Packing, number: int | None, vectors: str | None) -> Motion:
    """A mode of a packing, by its number among all: computed, or of a file of modes; or a table of displacements."""
    if vectors is None:
        return find_mode([Input(packing)], number, None)
    given = [Input(packing), Input(vectors)]
    if not lib.sp_modes_file_looks(c_path(vectors)) and given[1].raw_table.metadata.get("motion") == "snapshot":
        return find_snapshots(given, None, None)[0]
    return find_mode(given, number, None)


def after_pulse(packing: Packing, times: list[float], threads: int) -> list[Motion]:
    """The motion at times after a pulse of unit strength at the bottom wall."""
    if packing.cell == "periodic":
        raise Failed("the cell is periodic and has no walls, between which the pulse of --times passes: `sonopack "
                     "signal' sends pulses from plane to plane (--from plane:Y --detector plane:Z)")
    network = packing.network()
    return [Motion(network, u, False) for u in network.field(np.array(times), threads=threads)]


def of_grains(motion: Motion, factor: float = 1.0) -> tuple[Floats, Floats | None]:
    """Displacements and rotations of all grains [n][3]; rattlers do not move."""
    net, n = motion.network, motion.network.packing.n
    u, turn = np.zeros((n, 3)), np.zeros((n, 3)) if net.dof > net.dim else None
    u[net.grain, :net.dim] = factor * motion.u[:, :net.dim]
    if turn is not None:
        turn[net.grain, 2 if net.dim == 2 else 0:] = factor * motion.u[:, net.dim:]
    return u, turn
