"""Loud pulses and bursts, and the solitary waves of chains."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from . import _core
from ._core import call, documented
from ._native import ffi, lib
from ._records import AmplitudeFront, AmplitudeHarmonics, AmplitudePlane, AmplitudeSecond, Solitary

if TYPE_CHECKING:
    from ._packing import Packing


def _options(**values: Any) -> Any:
    options = ffi.new("sp_amplitude_options *", lib.sp_amplitude_options_default())
    _core.set_fields(options, values)
    return options


def fronts(packing: Packing, amplitudes: npt.ArrayLike, **values: Any) -> list[AmplitudeFront]:
    given = _core.floats(amplitudes, "amplitudes").ravel()
    out = ffi.new("sp_amplitude_front[]", len(given))
    call(lib.sp_amplitude_pulses, packing._c, _options(**values), len(given), _core.pointer_to(given), out, ffi.NULL)
    return [_core.record(AmplitudeFront, out[k], packing.material) for k in range(len(given))]


def planes(packing: Packing, amplitude: float, heights: npt.ArrayLike, **values: Any) -> list[AmplitudePlane]:
    given = _core.floats(heights, "heights").ravel()
    out = ffi.new("sp_amplitude_plane[]", len(given))
    call(lib.sp_amplitude_planes, packing._c, _options(**values), float(amplitude), len(given), _core.pointer_to(given),
         out, ffi.NULL)
    return [_core.record(AmplitudePlane, out[k], packing.material) for k in range(len(given))]


def burst(packing: Packing, amplitude: float, omega: float, cycles: int, count: int,
          heights: npt.ArrayLike | None, **values: Any) -> tuple[list[AmplitudeHarmonics], AmplitudeSecond]:
    given = None if heights is None else _core.floats(heights, "heights").ravel()
    n = count if given is None else len(given)
    made = ffi.new("sp_amplitude_burst *", {"amplitude": float(amplitude), "omega": float(omega), "cycles": int(cycles)})
    out, second = ffi.new("sp_amplitude_harmonics[]", max(n, 1)), ffi.new("sp_amplitude_second *")
    call(lib.sp_amplitude_bursts, packing._c, _options(**values), made, n,
         ffi.NULL if given is None else _core.pointer_to(given), out, second)
    return [_core.record(AmplitudeHarmonics, out[k], packing.material) for k in range(n)], _core.record(AmplitudeSecond, second, packing.material)


@documented("sp_solitary_make")
def solitary(peak: float) -> Solitary:
    """The solitary wave of a chain of Hertzian balls whose largest additional overlap is `peak` overlaps at rest;
    math.inf: a chain that bears no force at rest."""
    out = ffi.new("sp_solitary *")
    call(lib.sp_solitary_make, float(peak), out)
    return _core.record(Solitary, out)


__all__: Sequence[str] = ("burst", "fronts", "planes", "solitary")
