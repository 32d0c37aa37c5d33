"""Spectra of a network: density of states, transmission, dispersion, driving, the continuum, coherent waves."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Array, Floats, Value, call, documented
from ._native import ffi, lib
from ._records import CoherentWave, Moduli, ZeroModes

#: dtypes of Dispersion.wave, Harmonic.fit and Continuum.row
DISPERSION_POINT = _core.dtype_of("sp_dispersion_point")
WAVE_FIT = _core.dtype_of("sp_wave_fit")
CONTINUUM_ROW = _core.dtype_of("sp_continuum_row")


class DensityOfStates(_core.NetworkResult):
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

    @property
    def omega(self) -> Floats:
        """Middles of the bins."""
        edge: Floats = self.edge
        return 0.5 * (edge[:-1] + edge[1:])


class Transmission(_core.NetworkResult):
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

    @property
    def F(self) -> npt.NDArray[np.complex128]:
        """re + i im."""
        return self.re + 1j * self.im  # type: ignore[no-any-return]


class Dispersion(_core.NetworkResult):
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

    def polarization(self, row: int) -> str:
        """longitudinal, transverse or rotational, for a row of `wave`."""
        return _core.words("sp_polarization")[int(self.wave["polarization"][row])]


class Harmonic(_core.NetworkResult):
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

    @property
    def F(self) -> npt.NDArray[np.complex128]:
        """The force at the detector [n], a view."""
        force: npt.NDArray[np.complex128] = self.f.view(np.complex128)[:, 0]
        return force


class Continuum(_core.NetworkResult):
    """The lowest modes and those of an elastic strip. Made by network.continuum(). row: CONTINUUM_ROW."""

    _type = "sp_continuum"
    n = Value[int]()
    row = Array("n")
    moduli = Value[Moduli]()


class WaveSection(_core.NetworkResult):
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

    @documented("sp_coherent_fit")
    def wave(self, omega: float) -> CoherentWave:
        """The coherent wave at one frequency."""
        out = ffi.new("sp_coherent_wave *")
        call(lib.sp_coherent_fit, self._c, omega, out)
        return _core.record(CoherentWave, out, self._known_material())
