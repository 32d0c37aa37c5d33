"""Displacements that convert writes beside the grains: of a mode, or at times after a pulse; computed, or read from files."""
from __future__ import annotations

import dataclasses

import numpy as np

from .. import _core
from .._command import Failed, usage
from .._core import Floats, InvalidInput, c_path, call
from .._native import ffi, lib
from .._network import Network
from .._packing import Packing
from .._table import Table
from ._faults import bad_file


@dataclasses.dataclass
class Motion:
    """Displacements u [n][dof] of a network, in a mode or after a pulse."""

    network: Network
    u: Floats
    is_mode: bool
    omega: float = 0.0

    def of_grains(self, factor: float = 1.0) -> tuple[Floats, Floats | None]:
        """Displacements and rotations of all grains [n][3]; rattlers do not move."""
        net, n = self.network, self.network.packing.n
        u, turn = np.zeros((n, 3)), np.zeros((n, 3)) if net.dof > net.dim else None
        u[net.grain, :net.dim] = factor * self.u[:, :net.dim]
        if turn is not None:
            turn[net.grain, 2 if net.dim == 2 else slice(0, 3)] = factor * (self.u[:, 2] if net.dim == 2 else self.u[:, 3:])
        return u, turn


def components(net: Network) -> list[str]:
    """Names of the degrees of freedom of a grain. In two dimensions the only rotation is about z."""
    return (["ux", "uy", "uz"][:net.dim] + (["rz"] if net.dim == 2 else ["rx", "ry", "rz"]))[:net.dof]


def find(packing: Packing, number: int | None, vectors: str | None) -> Motion:
    """A mode of a packing, by its number among all: computed, or of a file of modes; or a table of displacements."""
    if vectors is None:
        modes = _modes(packing.network(), number)
        row = _row(modes, number)
        return Motion(modes.network, modes.displacement(row), True, float(modes.omega[row]))
    if lib.sp_modes_file_looks(c_path(vectors)):
        return _of_file(packing, number, vectors)
    return _of_table(packing, number, vectors)


def after_pulse(packing: Packing, times: list[float], threads: int) -> list[Motion]:
    """The motion at times after a pulse of unit strength at the bottom wall."""
    if packing.cell == "periodic":
        raise Failed("the cell is periodic and has no walls, between which the pulse of --times passes: `sonopack signal' sends "
                     "pulses from plane to plane (--from plane:Y --detector plane:Z)")
    network = packing.network()
    return [Motion(network, u, False) for u in network.field(np.array(times), threads=threads)]


# ---- modes ----------------------------------------------------------------------------------------------------------

def _row(m: object, number: int | None) -> int:
    """The row of a mode in a part of the spectrum."""
    first, n, zero, rattler = (int(getattr(m, name)) for name in ("first", "n", "n_zero", "n_rattler"))
    row = zero if number is None else number - first
    if n == 0:
        raise Failed("there are no modes in it")
    if number is None and n == zero:
        raise Failed("there are only zero modes")
    if not 0 <= row < n:
        raise usage(f"--mode {number}: must be in {first + rattler} .. {first + n - 1}")
    if row < rattler:
        raise Failed(f"mode {number} belongs to a rattler: must be {first + rattler} or more")
    return row


def _modes(network: Network, number: int | None) -> object:
    """The modes up to the wanted one."""
    rattlers = int(network._c.rattlers) * network.dof
    lowest = 1 if number is None or number < rattlers else number - rattlers + 1
    if lowest <= network.dofs:
        try:
            return network.modes(lowest=lowest, zero=number is not None)
        except InvalidInput:
            if number is None:
                raise Failed("there are only zero modes") from None
    return network.modes()  # there are not so many besides zero modes


def _of_file(packing: Packing, number: int | None, path: str) -> Motion:
    """Of a file of `sonopack modes --vectors FILE.h5', of which one vector is read."""
    f = _core.new("sp_modes_file", lib.sp_modes_file_free, lib.sp_modes_file_none)
    call(lib.sp_modes_file_read, c_path(path), packing._c, f)
    made = f.made.network
    network = packing.network(threshold=made.threshold, prestress=made.prestress, sliding_free=made.sliding_free,
                              tangential=_core.words("sp_springs")[made.tangential])
    if (f.n, f.dof) != (network.n, network.dof) or not np.array_equal(_core.view(f, f.grain, (f.n,)), network.grain):
        raise bad_file(f"{path}: the modes have other grains or degrees of freedom than the network")
    try:
        row = _row(f.modes, number)
    except (Failed, InvalidInput) as fault:
        raise type(fault)(f"{path}: {fault}", *(() if isinstance(fault, Failed) else (fault.status,))) from None
    e = np.empty((network.n, network.dof))
    call(lib.sp_modes_file_vectors, c_path(path), f, row, 1, _core.pointer_to(e))
    return Motion(network, e / np.sqrt(network.mass), True, float(f.modes.omega[row]))


# ---- tables ---------------------------------------------------------------------------------------------------------

def _of_table(packing: Packing, number: int | None, path: str) -> Motion:
    """A table of displacements, as `modes --vectors FILE.tsv' and `plot --table' write them, which must be of this packing."""
    table = Table.read(path)
    head, own = table.metadata, f"{packing.hash:016x}"
    if table.units.get("radius", "d") not in ("d", ""):
        raise bad_file(f"{path}: its lengths are in {table.units['radius']}, must be in d: a table without --units si")
    if "motion" not in head or "packing" not in head:
        raise bad_file(f"{path}: no comments `motion' and `packing', must be a table of displacements")
    if head["packing"] != own:
        raise bad_file(f"{path}: displacements of another packing, {head['packing']:.60}; must be {own}")
    is_mode = head["motion"] == "mode"
    values = {key: _number(table, path, key) for key in (
        "threshold", "prestress", "sliding_free", *(("mode", "omega") if is_mode else ("t",)))}
    if is_mode and not (0 <= values["mode"] < 1e15 and values["omega"] >= 0):
        raise bad_file(f"{path}: mode = {values['mode']:g}, omega = {values['omega']:g}; must be 0 or more")
    if is_mode and number not in (None, int(values["mode"])):
        raise usage(f"--mode {number}: {path} has mode {int(values['mode'])}")
    network = packing.network(threshold=values["threshold"], prestress=values["prestress"] != 0,
                              sliding_free=values["sliding_free"] != 0)
    return Motion(network, _field(table, path, network), is_mode, values.get("omega", 0.0))


def _number(table: Table, path: str, key: str) -> float:
    try:
        return table.number(key)
    except KeyError:
        raise bad_file(f"{path}: no comment `{key} = NUMBER', must be a table of displacements") from None


def _field(table: Table, path: str, network: Network) -> Floats:
    names = components(network)
    for name in ("grain", *names):
        if name not in table:
            raise bad_file(f"{path}: no column {name}")
    if table.rows != network.n:
        raise bad_file(f"{path}: {table.rows} rows, must be one for each of the {network.n} grains of the network")
    wrong = np.flatnonzero(table["grain"] != network.grain)
    if len(wrong):
        k = int(wrong[0])
        raise bad_file(f"{path}: row {k + 1} is of grain {table['grain'][k]}, must be {network.grain[k]}")
    u = np.stack([table[name].astype(float) for name in names], axis=1)
    bad = np.argwhere(~np.isfinite(u))
    if len(bad):
        raise bad_file(f"{path}: {names[bad[0][1]]} of grain {network.grain[bad[0][0]]} is not a finite number")
    return u
