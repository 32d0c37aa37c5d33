"""Derivatives of fronts, signals, frequencies and moduli by what a packing is made of."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core, _place
from ._core import Floats, Integers, call
from ._native import ffi, lib
from ._place import Where
from ._signal import Pulse

if TYPE_CHECKING:
    from ._modes import Modes
    from ._network import Network

PARAMETERS = ("kn", "kt", "mass", "radius", "position", "pressure")
FRONTS = ("t10", "t_peak", "peak", "t_zero", "width")
MODULI = ("C11", "C12", "C22", "C33", "C13", "C23", "C44", "C55", "C66", "cl", "ct")


class Gradient:
    """Derivatives of one quantity, by the parameters themselves: the command's by_kn is by a logarithm, kn times this.
    Those not asked for are None. Made by network.sensitivity().

    of: the word of the quantity
    value, error: the quantity, and the bound of its error
    kn, kt: by the stiffness of each spring [springs]
    mass, radius: by those of each grain of the network [n]
    position: by its centre [n][3]
    pressure: by the pressure [1]
    errors: bounds of the errors of these, {name: array of the same shape}
    homogeneity, homogeneity_size: what Euler's theorem leaves of its terms, 0 but for rounding; their size
    """

    def __repr__(self) -> str:
        parts = [f"{name} {list(part.shape)}" for name in self.errors if (part := getattr(self, name)) is not None]
        return f"<Gradient: value = {self.value:.6g}, error = {self.error:.2g}, by {', '.join(parts)}>"

    def __init__(self, c: Any, of: str = "") -> None:
        self.of = of
        self.value, self.error = float(c.value), float(c.error)
        self.homogeneity, self.homogeneity_size = float(c.homogeneity), float(c.homogeneity_size)
        self.errors: dict[str, Floats] = {}
        self.kn = self._take(c, "kn")
        self.kt = self._take(c, "kt")
        self.mass = self._take(c, "mass")
        self.radius = self._take(c, "radius")
        self.position = self._take(c, "position")
        self.pressure = self._take(c, "pressure")

    def _take(self, c: Any, name: str) -> Floats | None:
        part = getattr(c, name)
        if part.n == 0:
            return None
        shape = (int(part.n) // 3, 3) if name == "position" else (int(part.n),)
        self.errors[name] = _core.view(c, part.error, shape)
        return _core.view(c, part.d, shape)


def _mask(by: str | Sequence[str]) -> int:
    names = by.split(",") if isinstance(by, str) else list(by)
    for name in names:
        if name not in PARAMETERS:
            raise _core.invalid("by", f"{name!r}: must be among {', '.join(PARAMETERS)}")
    return sum(1 << PARAMETERS.index(name) for name in set(names))


def _gradient() -> Any:
    return _core.new("sp_gradient", lib.sp_gradient_free, lib.sp_gradient_none)


class _Wave:
    """Options of a source and a detector; keeps what they point to."""

    def __init__(self, network: Network, by: int, source: str | None, at: Where | None, detector: Where | None,
                 pulse: Pulse | None, until: float | None, points: int | None, threads: int) -> None:
        self.c = _core.options_of("sp_sensitivity_options", {"source": source, "until": until, "points": points,
                                                             "threads": threads})
        self.kept = [pulse, network, None if at is None else _place.one(at), None if detector is None else _place.one(detector)]
        self.c.parameters = by
        if self.kept[2] is not None:
            setattr(self.c, "from", self.kept[2])
        if self.kept[3] is not None:
            self.c.to = self.kept[3]
        if pulse is not None:
            self.c.pulse = pulse._c
        self.c.packing = network.packing._c


def _front(network: Network, of: str, wave: _Wave) -> Gradient:
    out = ffi.gc(ffi.new("sp_front_gradient *"), lib.sp_front_gradient_free)
    call(lib.sp_sensitivity_front, network._c, wave.c, 1 << FRONTS.index(of), out)
    moved = _gradient()
    moved[0] = getattr(out, of)
    setattr(out, of, lib.sp_gradient_none())
    return Gradient(moved, of)


def _signal(network: Network, t: float, wave: _Wave) -> Gradient:
    time, weight = ffi.new("double[]", [t]), ffi.new("double[]", [1.0])
    functional = ffi.new("sp_functional *", {"n": 1, "t": time, "weight": weight})
    out = _gradient()
    call(lib.sp_sensitivity_signal, network._c, wave.c, 1, functional, out)
    return Gradient(out, "F")


def _modulus(network: Network, of: str, by: int, margin: float) -> Gradient:
    which = ffi.new("sp_modulus[]", [MODULI.index(of)])
    out = _gradient()
    call(lib.sp_sensitivity_moduli, network._c, network._density(margin), 1, which, by, network.packing._c, out)
    return Gradient(out, of)


def sensitivity(network: Network, of: str, by: str | Sequence[str], t: float | None, wave: dict[str, Any],
                margin: float) -> Gradient:
    mask = _mask(by)
    of = {"c_l": "cl", "c_t": "ct"}.get(of, of)  # as network.moduli() names them
    if (of == "F") != (t is not None):
        raise _core.invalid("t", "the time of F: needed for it, and only for it")
    if of in FRONTS:
        return _front(network, of, _Wave(network, mask, **wave))
    if of == "F" and t is not None:
        return _signal(network, float(t), _Wave(network, mask, **wave))
    if of in MODULI:
        return _modulus(network, of, mask, margin)
    raise _core.invalid("of", f"{of!r}: must be one of {', '.join((*FRONTS, 'F', *MODULI))}")


def of_modes(network: Network, modes: Modes, first: int, count: int, by: str | Sequence[str]) -> Gradient:
    out = _gradient()
    call(lib.sp_sensitivity_modes, network._c, modes._c, int(first), int(count), _mask(by), network.packing._c, out)
    return Gradient(out, "omega")


def of_times(network: Network, t: npt.ArrayLike, springs: npt.ArrayLike | None, wave: dict[str, Any]) -> tuple[Floats, Floats, Floats]:
    times = _core.floats(t, "t").ravel()
    chosen: Integers | None = None if springs is None else np.ascontiguousarray(springs, dtype=np.int32).ravel()  # type: ignore[assignment]
    count = len(network.springs) if chosen is None else len(chosen)
    kn, kt, error = np.empty((count, len(times))), np.empty((count, len(times))), np.empty((count, 2))
    call(lib.sp_sensitivity_times, network._c, _Wave(network, 1, **wave).c, count,
         ffi.NULL if chosen is None else ffi.cast("const int32_t *", chosen.ctypes.data), len(times),
         _core.pointer_to(times), _core.pointer_to(kn), _core.pointer_to(kt), _core.pointer_to(error))
    return kn, kt, error
