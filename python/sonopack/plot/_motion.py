"""Displacements that figures show, and convert writes: of a mode, or at a time after a pulse; computed, or read from files."""
from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence

import numpy as np

from .. import _core
from .._command import Failed, usage
from .._core import Floats, InvalidInput, c_path, call
from .._modes import ComplexModes, Modes
from .._native import ffi, lib
from .._network import Network
from .._packing import Packing
from .._scene import Scene
from .._table import Table
from ._inputs import Input, network_of
from ._units import refuse


@dataclasses.dataclass(frozen=True)
class Motion:
    """Displacements u [n][dof] of a network. Of a mode: its number and omega; else at the time t after a pulse of
    `source`. error, omega_error: bounds."""

    network: Network
    u: Floats
    is_mode: bool
    number: int = 0
    omega: float = 0.0
    omega_error: float = 0.0
    t: float = 0.0
    source: str = "impulse"
    load: str = ""  # of a static response
    error: float = float("nan")

    def __post_init__(self) -> None:
        if not np.all(np.isfinite(self.u)):
            where = int(np.argmin(np.isfinite(self.u.ravel())))
            raise Failed(f"displacement {where}{' of the mode' if self.is_mode else ''} is not finite")

    @functools.cached_property
    def moves(self) -> Floats:
        """Translations [n][3] along the axes of the packing."""
        found = np.zeros((self.network.n, 3))
        found[:, :self.network.dim] = self.u[:, :self.network.dim]
        return found

    @functools.cached_property
    def lengths(self) -> Floats:
        """Of the translations [n]."""
        lengths: Floats = np.linalg.norm(self.moves, axis=1)
        return lengths

    @functools.cached_property
    def turns(self) -> Floats:
        """Rotations times radius [n][3]."""
        net, found = self.network, np.zeros((self.network.n, 3))
        if net.dim > 1 and net.dof > net.dim:
            found[:, 3 - (net.dof - net.dim):] = self.u[:, net.dim:] * net.r[:, None]
        return found

    def table(self) -> Table:
        """One row for each grain that is no rattler; `sonopack plot` draws it in place of computing the motion."""
        net, options = self.network, self.network._options
        if _core.words("sp_springs")[options.tangential] != "constant":
            raise Failed("network.tangential: must be \"constant\" for a table of displacements, which cannot say "
                         "otherwise")
        length, turn = ("1/sqrt(rho d^3)", "1/sqrt(rho d^5)") if self.is_mode else ("d", "rad")
        columns = {"grain": net.grain, **dict(zip("xyz", net.x.T[:net.dim])), "radius": net.r,
                   **dict(zip(components(net), self.u.T))}
        units = {name: "d" for name in ("x", "y", "z", "radius")}
        units |= {name: turn if name[0] == "r" else length for name in components(net)}
        head = {"motion": "mode" if self.is_mode else "snapshot", "packing": f"{net.packing.hash:016x}",
                "threshold": float(options.threshold), "prestress": int(options.prestress),
                "sliding_free": int(options.sliding_free)}
        if self.is_mode:
            head |= {"mode": self.number, "omega": self.omega, "omega_error": self.omega_error,
                     "vector_error": self.error}
        else:
            head |= {"t": self.t, "source": self.source, "error": self.error}
        return Table.from_columns(columns, units, head)


def components(net: Network) -> list[str]:
    """Names of the degrees of freedom of a grain. In two dimensions the only rotation is about z."""
    turns = ["rz"] if net.dim == 2 else ["rx", "ry", "rz"]
    return (["ux", "uy", "uz"][:net.dim] + turns)[:net.dof]


def network_for(one: Input, scene: Scene | None) -> Network:
    """The network of a packing, or the one that is given."""
    source = getattr(one.source, "network", one.source)
    return source if isinstance(source, Network) else network_of(one.packing, scene)


# ---- modes ----------------------------------------------------------------------------------------------------------

def find_mode(given: Sequence[Input], number: int | None, scene: Scene | None) -> Motion:
    """The wanted mode of a packing, of Modes, or of a packing and a file; by default the first that is no zero mode."""
    if isinstance(given[0].source, (Modes, ComplexModes)):
        return _of_modes(given[0].source, number)
    if len(given) == 1:
        return _of_modes(_compute(network_for(given[0], scene), number), number)
    one = given[1]
    if isinstance(one.source, (Modes, ComplexModes)):
        return _of_modes(one.source, number)
    if one.path and lib.sp_modes_file_looks(c_path(one.path)):
        return _of_file(one, given[0].packing, number)
    found = _of_table(one, given[0].packing, True)
    if number not in (None, found.number):
        raise usage(f"--mode {number}: {one.name} has mode {found.number}")
    return found


def _row(first: int, n: int, n_zero: int, n_rattler: int, number: int | None) -> int:
    """The row of a mode in a part of the spectrum."""
    row = n_zero if number is None else number - first
    if n == 0:
        raise Failed("there are no modes in it")
    if number is None and n == n_zero:
        raise Failed("there are only zero modes")
    if not 0 <= row < n:
        raise usage(f"--mode {number}: must be in {first + n_rattler} .. {first + n - 1}")
    if row < n_rattler:
        raise Failed(f"mode {number} belongs to a rattler: must be {first + n_rattler} or more")
    return row


def _compute(network: Network, number: int | None) -> Modes | ComplexModes:
    """The modes up to the wanted one."""
    rattlers = int(network._c.rattlers) * network.dof
    lowest = 1 if number is None else max(1, number - rattlers + 1)
    if network._c.carried:
        return network.complex_modes(lowest=lowest)
    try:
        if lowest <= network.dofs:
            return network.modes(lowest=lowest, zero=number is not None)
    except InvalidInput as fault:
        if number is None:
            raise Failed("there are only zero modes") from fault
    return network.modes()  # there are not so many besides zero modes


def _of_modes(modes: Modes | ComplexModes, number: int | None) -> Motion:
    if isinstance(modes, ComplexModes):  # at the time 0
        row = _row(modes.first, modes.n, modes.rattlers, modes.rattlers, number)
        return Motion(modes.network, modes.displacement(row).real, True, modes.first + row, float(modes.omega[row]),
                      float(modes.error[row]))
    row = _row(modes.first, modes.n, modes.n_zero, modes.n_rattler, number)
    return Motion(modes.network, modes.displacement(row), True, modes.first + row, float(modes.omega[row]),
                  float(modes.error[row]), error=modes.vector_error(row))


def _of_file(one: Input, packing: Packing, number: int | None) -> Motion:
    """Of a file of `sonopack modes --vectors FILE.h5', of which one vector is read."""
    f = _core.new("sp_modes_file", lib.sp_modes_file_free, lib.sp_modes_file_none)
    call(lib.sp_modes_file_read, c_path(one.path), packing._c, f)
    made = f.made.network
    network = packing.network(threshold=made.threshold, prestress=made.prestress, sliding_free=made.sliding_free,
                              tangential=_core.words("sp_springs")[made.tangential])
    if (f.n, f.dof) != (network.n, network.dof) or not np.array_equal(_core.view(f, f.grain, (f.n,)), network.grain):
        raise refuse(one.name, "the modes have other grains or degrees of freedom than the network")
    m = f.modes
    try:
        row = _row(m.first, m.n, m.n_zero, m.n_rattler, number)
    except Failed as fault:
        raise refuse(one.name, str(fault)) from None
    e = np.empty((network.n, network.dof))
    call(lib.sp_modes_file_vectors, c_path(one.path), f, row, 1, _core.pointer_to(e))
    error = float(lib.sp_modes_vector_error(ffi.addressof(f, "modes"), network._c, row))
    return Motion(network, e / np.sqrt(network.mass), True, int(m.first + row), float(m.omega[row]),
                  float(m.error[row]), error=error)


# ---- snapshots ------------------------------------------------------------------------------------------------------

def usual_time(packing: Packing) -> float:
    """When the wave is about three quarters of the way: 80 at a height of 25 and p = 1e-4, as in Fig. 3 of Somfai et
    al. 2005."""
    return float(3.2 * packing.height * (packing.pressure / 1e-4) ** (-1 / 6))


def find_snapshots(given: Sequence[Input], times: Sequence[float] | None, scene: Scene | None) -> list[Motion]:
    """Displacements at times after the pulse, by default one at the usual time."""
    if len(given) > 1 and isinstance(given[1].source, np.ndarray) and not given[1].source.dtype.names:
        network = network_for(given[0], scene)
        u = network._vector(given[1].source).reshape(network.n, network.dof)
        return [Motion(network, u, False, t=times[0] if times else float("nan"))]
    if len(given) > 1:
        if given[1].is_packing:
            raise refuse(given[1].name, "must be a table of displacements")
        return [_of_table(given[1], given[0].packing, False)]
    network = network_for(given[0], scene)
    if network.cell == "periodic":
        raise Failed("the cell is periodic and has no walls, between which the pulse of a snapshot passes: `sonopack "
                     "signal' sends pulses from plane to plane (--from plane:Y --detector plane:Z)")
    times = times or [usual_time(network.packing)]
    source = scene.options("signal")["source"] if scene else "impulse"
    u, errors = network.field(times, source=source, errors=True)
    return [Motion(network, u[k], False, t=t, source=source, error=float(errors[k])) for k, t in enumerate(times)]


# ---- tables ---------------------------------------------------------------------------------------------------------

def _of_table(one: Input, packing: Packing, is_mode: bool) -> Motion:
    table, head = one.raw_table, one.raw_table.metadata
    if table.units.get("radius", "d") not in ("d", ""):
        raise refuse(one.name, f"its lengths are in {table.units['radius']}, must be in d: a table without --units si")
    if "motion" not in head or "packing" not in head:
        raise refuse(one.name, "no comments `motion' and `packing', must be a table of displacements")
    kind, own = "mode" if is_mode else "snapshot", f"{packing.hash:016x}"
    response = is_mode and head["motion"] == "response"
    if head["motion"] != kind and not response:
        raise refuse(one.name, f"motion = {head['motion']:.60}, must be {kind}")
    if head["packing"] != own:
        raise refuse(one.name, f"displacements of another packing, {head['packing']:.60}; must be {own}")
    keys = ["threshold", "prestress", "sliding_free", *(() if response else ("mode", "omega") if is_mode else ("t",))]
    values = {key: _head_number(one, key) for key in keys}
    if is_mode and not response and not (0 <= values["mode"] < 1e15 and values["omega"] >= 0):
        raise refuse(one.name, f"mode = {values['mode']:g}, omega = {values['omega']:g}; must be 0 or more")
    network = packing.network(threshold=values["threshold"], prestress=values["prestress"] != 0,
                              sliding_free=values["sliding_free"] != 0)
    return Motion(network, _field(one, network), is_mode, int(values.get("mode", 0)), values.get("omega", 0.0),
                  t=values.get("t", 0.0), source=head.get("source", ""), load=head.get("load", "") if response else "")


def _head_number(one: Input, key: str) -> float:
    try:
        return one.raw_table.number(key)
    except KeyError:
        raise refuse(one.name, f"no comment `{key} = NUMBER', must be a table of displacements") from None


def _field(one: Input, network: Network) -> Floats:
    table = one.raw_table
    missing = [name for name in ("grain", *components(network)) if name not in table]
    if missing:
        raise refuse(one.name, f"no column {missing[0]}")
    if table.rows != network.n:
        raise refuse(one.name, f"{table.rows} rows, must be one for each of the {network.n} grains of the network")
    wrong = np.flatnonzero(table["grain"] != network.grain)
    if len(wrong):
        raise refuse(one.name, f"row {wrong[0] + 1} is of grain {table['grain'][wrong[0]]}, must be "
                               f"{network.grain[wrong[0]]}")
    for name in components(network):
        if table[name].dtype.kind not in "fiu":
            raise refuse(one.name, f"column {name} holds text: must be numbers")
    u: Floats = np.stack([table[name].astype(float) for name in components(network)], axis=1)
    for row, a in np.argwhere(~np.isfinite(u))[:1]:
        raise refuse(one.name, f"{components(network)[a]} of grain {network.grain[row]} is not a finite number")
    return u
