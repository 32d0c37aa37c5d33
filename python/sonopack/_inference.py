"""What follows from sensitivities: errors of measured packings, designs, and the places of changes."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core, _fields, _place
from ._core import Floats, call, documented
from ._native import ffi, lib
from ._packing import Packing
from ._place import Where

if TYPE_CHECKING:
    from ._network import Network

#: dtypes of Design.step and of the candidates of Coda.locate
DESIGN_STEP = _core.dtype_of("sp_design_step")
CODA_CANDIDATE = _core.dtype_of("sp_coda_candidate")


def _network_options(options: Any, threshold: float | None, prestress: bool) -> None:
    _core.set_fields(options.network, {"threshold": threshold, "prestress": prestress})


class Uncertain:
    """One quantity of Uncertainty, with its errors."""

    def __init__(self, c: Any) -> None:
        self.name: str = _core.text_of(c.name)
        self.unit: str = _core.text_of(c.unit)
        self.value: float = c.value
        self.first_order: float = c.first_order
        self.shift: float = c.shift
        self.sd: float = c.sd
        self.sd_error: float = c.sd_error
        self.bias: float = c.bias
        self.bias_error: float = c.bias_error
        self.samples: int = c.samples
        self.linear: str = _core.words("sp_linear")[int(c.linear)]
        kinds = _core.words("sp_error_kind")
        #: parts of the kinds of errors in the square of first_order
        self.share: dict[str, float] = {kinds[k].removesuffix("-part"): c.share[k] for k in range(lib.SP_ERROR_KINDS)}

    def __repr__(self) -> str:
        return f"<{self.name} = {self.value:.6g}: sd {self.sd:.2g}, bias {self.bias:.2g}, linear: {self.linear}>"


class Uncertainty(_fields.Uncertainty, Mapping[str, Uncertain]):
    """Errors of the sound of a measured packing, by the names of the quantities. Made by uncertainty()."""

    def __init__(self, packing: Packing, options: Any) -> None:
        self._make(packing._c, options)
        self.packing = packing
        self._names = {_core.text_of(self._c.quantity[k].name): k for k in range(self._c.n)}

    def __getitem__(self, name: str) -> Uncertain:
        return Uncertain(self._c.quantity[self._names[name]])

    def __iter__(self) -> Any:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


@documented("sp_uncertainty_make")
def uncertainty(packing: Packing, *, measured: str = "forces", position: float = 0.0, radius: float = 0.0,
                force: float = 0.0, stiffness: float = 0.0, calibration: float = 0.0, mean_one: bool = False,
                false: float = 0.0, missing: float = 0.0, gap: float | None = None, missing_force: float | None = None,
                samples: int | None = None, seed: int | None = None, modes: int | None = None, moduli: bool = True,
                first_order: bool = True, source: str = "impulse", margin: float | None = None, parts: bool = False,
                threshold: float | None = None, prestress: bool = False, threads: int = 1) -> Uncertainty:
    """How standard errors of a measured packing carry into its sound: result["t10"].sd, result["c_l"].share, ...

    parts: also result.by_grain and result.by_contact, a row for each quantity."""
    options = ffi.new("sp_uncertainty_options *", lib.sp_uncertainty_options_default())
    _core.set_fields(options.errors, {"measured": measured, "position": position, "radius": radius, "force": force,
                                      "stiffness": stiffness, "calibration": calibration, "mean_one": mean_one,
                                      "false_part": false, "missing": missing, "gap": gap,
                                      "missing_force": missing_force})
    _core.set_fields(options, {"samples": samples, "seed": seed, "modes": modes, "moduli": moduli,
                               "first_order": first_order, "source": source, "margin": margin, "parts": parts,
                               "threads": threads})
    _network_options(options, threshold, prestress)
    return Uncertainty(packing, options)


class Design(_fields.Design):
    """Which grains to change, and the packing made of them. Made by design()."""

    #: the packing made of these grains
    packing: Packing

    def __init__(self, packing: Packing, options: Any) -> None:
        self._make(packing._c, options)
        struct = _core.new("sp_packing", lib.sp_packing_free, lib.sp_packing_none)
        struct[0] = self._c.packing
        self._c.packing = lib.sp_packing_none()
        self.packing = Packing(struct)


@documented("sp_design_make")
def design(packing: Packing, goal: str, *, vary: str = "mass", limits: tuple[float, float] | None = None,
           free: bool = False, band: tuple[float, float] | None = None, until: float | None = None,
           iterations: int | None = None, tolerance: float | None = None, source: str = "impulse",
           threshold: float | None = None, prestress: bool = False, threads: int = 1) -> Design:
    """Grains that make the front late (goal="delay") or early ("advance"), or leave out a band ("band").

    vary: mass, modulus or radius. limits: of the factor of each grain. free: the total need not be kept.
    """
    options = ffi.new("sp_design_options *", lib.sp_design_options_default())
    _core.set_fields(options, {"goal": goal, "vary": vary, "free": free, "until": until, "iterations": iterations,
                               "tolerance": tolerance, "source": source, "threads": threads})
    if limits is not None:
        options.low, options.high = _core.pair(limits, "limits")
    elif vary == "radius":
        options.low, options.high = 0.98, 1.02
    if band is not None:
        options.band_low, options.band_high = _core.pair(band, "band")
    _network_options(options, threshold, prestress)
    return Design(packing, options)


class Coda(_fields.Coda):
    """Kernels of all grains: the derivatives of signals by the logarithm of the stiffness of a grain's contacts.

    t: times of the window. sources, detectors: places, as in network.signal(). grain: indices in the packing.
    """

    def __init__(self, network: Network, t: npt.ArrayLike, *, sources: Where | Iterable[Where] | None = None,
                 detectors: Where | Iterable[Where] | None = None, source: str = "impulse", threads: int = 1) -> None:
        self.t: Floats = _core.row(t, "t")
        self.network = network
        count, self._from = _place.several(sources, True)
        count_to, self._to = _place.several(detectors, False)
        self._options = ffi.new("sp_coda_options *", {"sources": count, "detectors": count_to, "from": self._from,
                                                      "to": self._to, "times": len(self.t), "threads": threads,
                                                      "t": _core.pointer_to(self.t, "const double *")})
        _core.set_fields(self._options, {"source": source})
        self._make(network._c, self._options)

    @documented("sp_coda_signal")
    def signal(self, grain: int = -1, change: float = 0.0) -> Floats:
        """Signals [pairs][times] with the stiffness of a grain's contacts multiplied by 1 + change."""
        out = np.empty((self.pairs, self.times))
        call(lib.sp_coda_signal, self.network._c, self._options, int(grain), float(change), _core.pointer_to(out))
        return out

    @documented("sp_coda_locate")
    def locate(self, change: npt.ArrayLike, noise: float = 0.0) -> npt.NDArray[Any]:
        """The grains as places of a change [pairs][times] of the signals, the most probable first.

        error knows of noise alone. signal(grain, change) tells how far the kernel, which is of first order, holds.
        """
        values = _core.floats(np.atleast_2d(np.asarray(change)), "change", (self.pairs, self.times))
        out = ffi.new("sp_coda_candidate[]", self.n)
        call(lib.sp_coda_locate, self._c, _core.pointer_to(values, "const double *"), float(noise), out)
        return _core.view(out, ffi.cast("sp_coda_candidate *", out), (self.n,), "sp_coda_candidate")

    @documented("sp_coda_first_order")
    def first_order(self, found: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Candidates of locate() whose error also has what the kernel, which is of first order, leaves out."""
        out, signal = np.array(found, ndmin=1), self.signal()
        before = _core.pointer_to(signal, "const double *")
        for k in range(len(out)):
            call(lib.sp_coda_first_order, self.network._c, self._options, self._c, before,
                 ffi.cast("sp_coda_candidate *", out[k:].ctypes.data))
        return out
