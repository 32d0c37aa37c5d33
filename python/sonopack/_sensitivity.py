"""Derivatives of fronts, signals, frequencies and moduli by what a packing is made of."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core, _place
from ._core import Floats, call
from ._native import ffi, lib

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

    kn: Floats | None
    kt: Floats | None
    mass: Floats | None
    radius: Floats | None
    position: Floats | None
    pressure: Floats | None

    def __init__(self, c: Any, of: str = "") -> None:
        self.of = of
        self.value, self.error = float(c.value), float(c.error)
        self.homogeneity, self.homogeneity_size = float(c.homogeneity), float(c.homogeneity_size)
        self.errors: dict[str, Floats] = {}
        for name in PARAMETERS:
            part = getattr(c, name)
            shape = (int(part.n) // 3, 3) if name == "position" else (int(part.n),)
            setattr(self, name, _core.view(c, part.d, shape) if part.n > 0 else None)
            if part.n > 0:
                self.errors[name] = _core.view(c, part.error, shape)

    def __repr__(self) -> str:
        parts = [f"{name} {list(part.shape)}" for name, part in self.errors.items()]
        return f"<Gradient: value = {self.value:.6g}, error = {self.error:.2g}, by {', '.join(parts)}>"


def _mask(by: str | Sequence[str]) -> int:
    names = by.split(",") if isinstance(by, str) else list(by)
    for name in names:
        if name not in PARAMETERS:
            raise _core.invalid("by", f"{name!r}: must be among {', '.join(PARAMETERS)}")
    return sum(1 << PARAMETERS.index(name) for name in set(names))


def _gradient() -> Any:
    return _core.new("sp_gradient", lib.sp_gradient_free, lib.sp_gradient_none)


def _options(network: Network, parameters: int, values: Mapping[str, Any]) -> tuple[Any, list[Any]]:
    """Options of a source and a detector, and what they point to."""
    own = {name: value for name, value in values.items() if name not in ("at", "detector", "pulse")}
    kept = {field: _place.one(values[name], name == "at") for name, field in (("at", "from"), ("detector", "to"))
            if values[name] is not None}
    if values.get("pulse") is not None:
        kept["pulse"] = values["pulse"]._c
    own |= {**kept, "parameters": parameters, "packing": network.packing._c}
    return _core.options_of("sp_sensitivity_options", own), list(kept.values())


def sensitivity(network: Network, of: str, by: str | Sequence[str], t: float | None, wave: Mapping[str, Any],
                margin: float) -> Gradient:
    """network.sensitivity()."""
    mask, out = _mask(by), _gradient()
    of = {"c_l": "cl", "c_t": "ct"}.get(of, of)  # as network.moduli() names them
    if (of == "F") != (t is not None):
        raise _core.invalid("t", "the time of F: needed for it, and only for it")
    options, kept = _options(network, mask, wave)
    if of in FRONTS:
        front = ffi.gc(ffi.new("sp_front_gradient *"), lib.sp_front_gradient_free)
        call(lib.sp_sensitivity_front, network._c, options, 1 << FRONTS.index(of), front)
        out[0] = getattr(front, of)
        setattr(front, of, lib.sp_gradient_none())
    elif of == "F":
        time, weight = ffi.new("double[]", [t]), ffi.new("double[]", [1.0])
        functional = ffi.new("sp_functional *", {"n": 1, "t": time, "weight": weight})
        call(lib.sp_sensitivity_signal, network._c, options, 1, functional, out)
    elif of in MODULI:
        which = ffi.new("sp_modulus[]", [MODULI.index(of)])
        call(lib.sp_sensitivity_moduli, network._c, network._density(margin), 1, which, mask, network.packing._c, out)
    else:
        raise _core.invalid("of", f"{of!r}: must be one of {', '.join((*FRONTS, 'F', *MODULI))}")
    del kept
    return Gradient(out, of)


def of_modes(network: Network, modes: Modes, first: int, count: int, by: str | Sequence[str]) -> Gradient:
    """network.mode_sensitivity()."""
    out = _gradient()
    call(lib.sp_sensitivity_modes, network._c, modes._c, int(first), int(count), _mask(by), network.packing._c, out)
    return Gradient(out, "omega")


def of_times(network: Network, t: npt.ArrayLike, springs: npt.ArrayLike | None,
             wave: Mapping[str, Any]) -> tuple[Floats, Floats, Floats]:
    """network.signal_sensitivity()."""
    times = _core.floats(t, "t").ravel()
    every = np.arange(len(network.springs))
    chosen = np.ascontiguousarray(every if springs is None else springs, dtype=np.int32).ravel()
    kn, kt, error = np.empty((len(chosen), len(times))), np.empty((len(chosen), len(times))), np.empty((len(chosen), 2))
    options, kept = _options(network, 1, wave)
    call(lib.sp_sensitivity_times, network._c, options, len(chosen), _core.pointer_to(chosen, "const int32_t *"),
         len(times), *map(_core.pointer_to, (times, kn, kt, error)))
    del kept
    return kn, kt, error
