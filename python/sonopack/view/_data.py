"""What the page shows of a packing: grains and contacts, modes, and the wave after a pulse at the bottom wall."""
from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .. import _core
from .._core import Floats, SonopackError, Status
from .._modes import Modes
from .._network import Network
from .._packing import BOTTOM, TOP, Packing
from .._signal import signal_window

LEVELS = 32767  # of a frame's numbers, of 16 bits
MODES = 10  # shown where none are asked for
ALL_MAX = 6000  # degrees of freedom of a network whose modes are all computed if it has too few to choose from
FRAMES_MAX = 2000

Tell = Callable[[str], object]


@dataclasses.dataclass(frozen=True)
class Choice:
    """What is shown besides grains and contacts. modes: first and last, both included, 0 the softest that is no zero mode;
    None: the ten softest; False: none. frames: how many of the wave, None: 200, or fewer so that they take less than
    12 MB; False: no wave. until: the last time [d/sqrt(E* / rho)]. What is asked for and cannot be had is an error."""

    modes: tuple[int, int] | bool | None = None
    frames: int | bool | None = None
    until: float | None = None
    source: str | None = None
    network: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    signal: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    @property
    def needs_wave(self) -> bool:
        """Whether something was asked of the wave."""
        return self.frames not in (None, False) or self.until is not None or self.source is not None


def describe(name: str, packing: Packing, choice: Choice, missing: Tell) -> dict[str, Any]:
    """The part of a packing in the page's data; arrays are numpy's."""
    threshold = choice.network.get("threshold") or 1e-4
    found = {"name": name, "hash": f"{packing.hash:016x}", "seed": str(packing.seed), "dimension": packing.dim,
             "grains": packing.n, "contacts": len(packing.contacts), "box": list(packing.box), "cell": packing.cell,
             "tilt": list(packing.tilt), "gravity": packing.gravity, "pressure": packing.pressure,
             "friction": packing.friction, "poisson": packing.poisson, "wall": packing.wall, "threshold": threshold,
             "prestress": bool(choice.network.get("prestress")), "material": _material(packing),
             "scene": packing.scene or None}
    return {**found, **_grains(packing, threshold), **_motion(packing, choice, missing)}


def _material(packing: Packing) -> dict[str, float] | None:
    m = packing.material
    return {"E": m.young, "nu": m.poisson, "rho": m.density, "d": m.diameter} if m.young > 0 else None


# ---- grains and contacts --------------------------------------------------------------------------------------------

def _grains(packing: Packing, threshold: float) -> dict[str, Any]:
    c, r, dim = packing.contacts, packing.r, packing.dim
    x, i, j = packing.x[:, :dim], packing.contacts["i"], packing.contacts["j"]
    pair, carrying = j >= 0, packing.carrying(threshold)
    rattler = packing.rattlers(threshold)
    reach = (r[i] + np.where(pair, r[np.maximum(j, 0)], 0) - c["overlap"])[:, None] * c["n"][:, :dim]
    count = np.bincount(i[carrying], minlength=packing.n) + np.bincount(j[carrying & pair], minlength=packing.n)
    return {"rattlers": int(rattler.sum()), "x": x.astype(np.float32), "r": r.astype(np.float32),
            "rattler": rattler.astype(np.uint8), "coordination": np.minimum(count, 65535).astype(np.uint16),
            "grain_pressure": _pressures(packing).astype(np.float32), "contact": np.stack([i, j], axis=1).astype(np.int32),
            "image": _images(packing, reach), "wall_point": (x[i] + reach)[~pair].astype(np.float32),
            "fn": c["fn"].astype(np.float32), "ft": np.linalg.norm(c["ft"], axis=1).astype(np.float32),
            "carrying": carrying.astype(np.uint8)}


def _pressures(packing: Packing) -> Floats:
    """The trace of the stress of each grain over the dimension [n][E*]: sum of F_n R over its contacts, over dim V. V is in
    2D that of a layer one d thick, in 1D of a bar of section d^2."""
    c, r, dim = packing.contacts, packing.r, packing.dim
    volume = {1: 2 * r, 2: np.pi * r**2, 3: 4 / 3 * np.pi * r**3}[dim]
    total: Any = np.bincount(c["i"], c["fn"] * r[c["i"]], packing.n)
    pair = c["j"] >= 0
    total += np.bincount(c["j"][pair], (c["fn"] * r[c["j"]])[pair], packing.n)
    pressures: Floats = total / (dim * volume)
    return pressures


def _images(packing: Packing, reach: Floats) -> Any:
    """In which copy of the box the grain j lies that i touches [contacts][dim]; 0 of walls. In a tilted box a step along an
    axis leads along the axes before it too."""
    c, dim = packing.contacts, packing.dim
    shift = packing.x[c["i"], :dim] + reach - packing.x[np.maximum(c["j"], 0), :dim]
    xy, xz, yz = packing.tilt
    image = np.zeros(shift.shape, np.int8)
    for axis in reversed(range(dim)):
        image[:, axis] = np.where(c["j"] < 0, 0, np.clip(np.rint(shift[:, axis] / packing.box[axis]), -100, 100))
        for before, tilt in enumerate(([], [xy], [xz, yz])[axis]):
            shift[:, before] -= image[:, axis] * tilt
    return image


# ---- what moves -----------------------------------------------------------------------------------------------------

def _motion(packing: Packing, choice: Choice, missing: Tell) -> dict[str, Any]:
    parts: dict[str, Any] = {"modes": None, "wave": None}
    network, reason = None, None
    if choice.modes is not False or choice.frames is not False:
        try:
            network = packing.network(**choice.network)
            parts = {"dof": network.dof, "grain": np.array(network.grain, np.int32), **parts}
        except SonopackError as fault:
            reason = fault

    def make_there(make: Callable[..., dict[str, Any]]) -> dict[str, Any]:
        return make(_there(network, reason), choice, missing)

    for key, wanted, needed, make in (("modes", choice.modes is not False, choice.modes is not None, _modes),
                                      ("wave", choice.frames is not False, choice.needs_wave, _wave)):
        if wanted:
            parts[key] = _part(functools.partial(make_there, make), needed, missing)
    return parts


def _there(network: Network | None, reason: SonopackError | None) -> Network:
    if network is None:
        assert reason is not None
        raise reason
    return network


def _part(make: Callable[[], dict[str, Any]], needed: bool, missing: Tell) -> dict[str, Any]:
    """What `make` returns, or the reason for which there is none."""
    try:
        return make()
    except SonopackError as fault:
        if needed or fault.status == Status.ENOMEM:
            raise
        missing(str(fault))
        return {"reason": str(fault)}


def _modes(network: Network, choice: Choice, _: Tell) -> dict[str, Any]:
    first, last = choice.modes if isinstance(choice.modes, tuple) else (0, MODES - 1)
    modes, row = _chosen(network, choice, first, last)
    rows = range(row, min(row + last - first + 1, modes.n))
    return {"first": first, "zero_modes": modes.zero.total,
            "rows": [{"number": modes.first + k, "omega": float(modes.omega[k]), "omega_error": float(modes.error[k]),
                      "participation": float(modes.participation[k]), "vector_error": modes.vector_error(k)} for k in rows],
            "u": np.array([modes.displacement(k) for k in rows], np.float32)}


def _chosen(network: Network, choice: Choice, first: int, last: int) -> tuple[Modes, int]:
    """Modes among which `first` is the row, and that row. A small network that has fewer than the iteration can find, or
    than are asked for, has all its modes computed."""
    source = choice.source or choice.signal.get("source") or "impulse"
    threads = choice.signal.get("threads", 1)
    if last < network.dofs:
        try:
            return network.modes(lowest=last + 1, source=source, threads=threads), first
        except _core.InvalidInput:
            pass
    if network.dofs > ALL_MAX:
        raise _core.invalid("", f"modes {first} to {last}: {network.dofs} degrees of freedom have fewer modes")
    modes = network.modes(source=source, threads=threads)
    count = modes.n - modes.n_zero
    if count == 0 or first >= count or (choice.modes is not None and last >= count):
        text = f"modes {first} to {last}: there are only {count} modes that are no zero modes"
        raise _core.invalid("", text) if count else _core.Refused(text, Status.EREFUSED)
    return modes, modes.n_zero + first


def _wave(network: Network, choice: Choice, missing: Tell) -> dict[str, Any]:
    if not network.touches(BOTTOM):
        raise _core.Refused("the packing touches no bottom wall, so that no pulse can enter it there", Status.EREFUSED)
    packing, signal = network.packing, dict(choice.signal)
    frames = choice.frames or usual_frames(network.dofs)
    until = choice.until or signal.pop("until", None) or signal_window(packing.height, packing.pressure)
    source = choice.source or signal.pop("source", None) or "impulse"
    t = until * np.arange(frames) / (frames - 1)
    u, errors = network.field(t, source=source, threads=signal.get("threads", 1), errors=True)
    length, turn = (np.abs(part).max(axis=(1, 2), initial=0) for part in (u[..., :network.dim], u[..., network.dim:]))
    scale = np.concatenate([np.repeat(length[:, None], network.dim, 1), np.repeat(turn[:, None], network.dof - network.dim, 1)], 1)
    levels = np.divide(u, scale[:, None, :], out=np.zeros_like(u), where=scale[:, None, :] > 0) * LEVELS
    return {"source": source, "until": until, "error": float(errors.max()), "t": t.tolist(), "length": length.tolist(),
            "turn": turn.tolist(), "levels": LEVELS, "u": np.rint(levels).astype(np.int16),
            "signal": _part(lambda: _signal(network, {**signal, "until": until, "source": source}), False, missing)}


def usual_frames(dofs: int) -> int:
    """So many frames that they take less than 12 MB of the page, at most 200 and at least 12."""
    return int(min(200, max(12, 9e6 // (2 * dofs))))  # a third more as base64


def _signal(network: Network, options: Mapping[str, Any]) -> dict[str, Any]:
    """The curve beside the frames. A packing that does not touch the top wall has a wave, but no signal."""
    if not network.touches(TOP):
        raise _core.Refused("the packing touches no top wall, where the signal would be measured", Status.EREFUSED)
    signal = network.signal(**options)
    try:
        front = signal.front(window=0.0)
        marks = {key: getattr(front, key) for key in ("t10", "t_peak", "t_zero", "amplitude")}
    except SonopackError:
        marks = None
    return {"until": options["until"], "method": signal.method, "error": signal.error, "front": marks,
            "F": signal.F.astype(np.float32)}
