"""Spectra of a network: density of states, transmission, dispersion, driving, the continuum, coherent waves."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core, _place
from ._core import Array, Floats, Value, call, documented
from ._native import ffi, lib
from ._place import Where
from ._records import CoherentWave, Moduli, ZeroModes

if TYPE_CHECKING:
    from ._network import Network

#: dtypes of Dispersion.wave, Harmonic.fit and Continuum.row
DISPERSION_POINT = _core.dtype_of("sp_dispersion_point")
WAVE_FIT = _core.dtype_of("sp_wave_fit")
CONTINUUM_ROW = _core.dtype_of("sp_continuum_row")


class DensityOfStates(_core.Result):
    """Density of states. Made by network.dos(). Errors have the names of the numbers: density_error, ..."""

    _type = "sp_dos"
    bins = Value[int]()
    method = Value[str]()
    edge = Array(lambda d: int(d.bins) + 1)
    density = Array("bins")
    cumulative = Array("bins")
    smooth = Array("bins")
    density_error = Array("bins")
    cumulative_error = Array("bins")
    smooth_error = Array("bins")
    resolution = Value[float]()
    omega_max = Value[float]()
    zero = Value[ZeroModes]()
    modes = Value[int]()
    moments = Value[int]()
    vectors = Value[int]()

    def __init__(self, network: Network, values: dict[str, Any]) -> None:
        options = _core.options_of("sp_dos_options", values)
        self.network = network
        self._make(network._c, options)

    @property
    def omega(self) -> Floats:
        """Middles of the bins."""
        edge: Floats = self.edge
        return 0.5 * (edge[:-1] + edge[1:])


class Transmission(_core.Result):
    """Spectrum of the signal. Made by network.transmission()."""

    _type = "sp_transmission"
    n = Value[int]()
    omega = Array("n")
    density = Array("n")
    re = Array("n")
    im = Array("n")
    error = Array("n")
    resolution = Value[float]()
    omega_max = Value[float]()
    moments = Value[int]()

    def __init__(self, network: Network, at: Where | None, detector: Where | None, values: dict[str, Any]) -> None:
        options = _core.options_of("sp_transmission_options", values)
        _set_places(options, at, detector)
        self.network = network
        self._make(network._c, options)

    @property
    def F(self) -> npt.NDArray[np.complex128]:
        """re + i im."""
        return self.re + 1j * self.im  # type: ignore[no-any-return]


def _set_places(options: Any, at: Where | None, detector: Where | None) -> None:
    if at is not None:
        _place.place(at)._write(getattr(options, "from"))
    if detector is not None:
        _place.place(detector)._write(options.to)


class Dispersion(_core.Result):
    """Waves of a network. Made by network.dispersion(). wave: one row (DISPERSION_POINT) for each polarization and
    number; s [waves][profile]: S(k, omega)."""

    _type = "sp_dispersion"
    n = Value[int]()
    wave = Array("n")
    profile = Value[int]()
    omega = Array("profile", missing="ask for dispersion(profile=400)")
    s = Array("n", "profile", missing="ask for dispersion(profile=400)")
    omega_max = Value[float]()
    moments = Value[int]()

    def __init__(self, network: Network, values: dict[str, Any]) -> None:
        up = network.dim == 1 if values["up"] is None else values["up"]
        # the centre of the grain behind the wall, if the waves stand between walls
        standing = network.cell == "box" or (bool(up) and network.cell == "piston")
        behind = 0.5 if standing and network.packing.wall == "grain" else 0.0
        node = behind if values["node"] is None else values["node"]
        options = _core.options_of("sp_dispersion_options", {**values, "up": up, "node": node})
        self.network = network
        self._make(network._c, options)

    def polarization(self, row: int) -> str:
        """longitudinal, transverse or rotational, for a row of `wave`."""
        return _core.words("sp_polarization")[int(self.wave["polarization"][row])]


class Harmonic(_core.Result):
    """Response to driving. Made by network.harmonic(). fit: one row (WAVE_FIT) for each frequency."""

    _type = "sp_harmonic"
    n = Value[int]()
    planes = Value[int]()
    omega = Array("n")
    f = Array("n", 2)
    error = Array("n")
    height = Array("planes")
    flux = Array("n", "planes", 2)
    flux_error = Array("n", "planes")
    fit = Array("n")

    def __init__(self, network: Network, omega: npt.ArrayLike, at: Where | None, detector: Where | None,
                 heights: tuple[float, float] | None, values: dict[str, Any]) -> None:
        frequencies = _core.row(omega, "omega")
        options = _core.options_of("sp_harmonic_options", {**values, "n": len(frequencies)})
        options.omega = _core.pointer_to(frequencies, "const double *")
        if heights is not None:
            options.range = list(_core.pair(heights, "range"))
        _set_places(options, at, detector)
        self.network = network
        self._make(network._c, options)

    @property
    def F(self) -> npt.NDArray[np.complex128]:
        """The force at the detector [n], a view."""
        force: npt.NDArray[np.complex128] = self.f.view(np.complex128)[:, 0]
        return force


class Continuum(_core.Result):
    """The lowest modes and those of an elastic strip. Made by network.continuum(). row: CONTINUUM_ROW."""

    _type = "sp_continuum"
    n = Value[int]()
    row = Array("n")
    moduli = Value[Moduli]()

    def __init__(self, network: Network, density: float, lowest: int, solver: str) -> None:
        self.network = network
        self._c = _core.new("sp_continuum", lib.sp_continuum_free, lib.sp_continuum_none)
        call(lib.sp_continuum_make, network._c, density, lowest, _core.number_of("sp_modes_solver", solver, "solver"),
             self._c)


class WaveSection(_core.Result):
    """Signals at planes one above the other. Made by network.section()."""

    _type = "sp_coherent_section"
    planes = Value[int]()
    n = Value[int]()
    spacing = Value[float]()
    y = Array("planes")
    arrival = Array("planes")
    until = Array("planes")
    f = Array("planes", "n")
    highest = Value[float]()

    def __init__(self, network: Network, values: dict[str, Any]) -> None:
        options = _core.options_of("sp_coherent_section_options", values)
        self.network = network
        self._make(network._c, options)

    @documented("sp_coherent_fit")
    def wave(self, omega: float) -> CoherentWave:
        """The coherent wave at one frequency."""
        out = ffi.new("sp_coherent_wave *")
        call(lib.sp_coherent_fit, self._c, omega, out)
        return _core.record(CoherentWave, out, self._known_material())
