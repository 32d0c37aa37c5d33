"""Spectra of a network: density of states, transmission, dispersion, driving, the continuum, coherent waves."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _core, _fields
from ._core import Floats, call, documented
from ._native import ffi, lib
from ._records import CoherentWave

#: dtypes of Dispersion.wave, Harmonic.fit and Continuum.row
DISPERSION_POINT = _core.dtype_of("sp_dispersion_point")
WAVE_FIT = _core.dtype_of("sp_wave_fit")
CONTINUUM_ROW = _core.dtype_of("sp_continuum_row")


class DensityOfStates(_core.NetworkResult, _fields.Dos):
    """Density of states. Made by network.dos(). Errors have the names of the numbers: density_error, ..."""

    @property
    def omega(self) -> Floats:
        """Middles of the bins."""
        edge: Floats = self.edge
        return 0.5 * (edge[:-1] + edge[1:])


class Transmission(_core.NetworkResult, _fields.Transmission):
    """Spectrum of the signal. Made by network.transmission()."""

    @property
    def F(self) -> npt.NDArray[np.complex128]:
        """re + i im."""
        return self.re + 1j * self.im  # type: ignore[no-any-return]


class Dispersion(_core.NetworkResult, _fields.Dispersion):
    """Waves of a network. Made by network.dispersion(). wave: one row (DISPERSION_POINT) for each polarization and
    number; s [waves][profile]: S(k, omega)."""

    _missing = "ask for dispersion(profile=400)"

    def polarization(self, row: int) -> str:
        """longitudinal, transverse or rotational, for a row of `wave`."""
        return _core.words("sp_polarization")[int(self.wave["polarization"][row])]


class Harmonic(_core.NetworkResult, _fields.Harmonic):
    """Response to driving. Made by network.harmonic(). fit: one row (WAVE_FIT) for each frequency."""

    @property
    def F(self) -> npt.NDArray[np.complex128]:
        """The force at the detector [n], a view."""
        force: npt.NDArray[np.complex128] = self.f.view(np.complex128)[:, 0]
        return force


class Continuum(_core.NetworkResult, _fields.Continuum):
    """The lowest modes and those of an elastic strip. Made by network.continuum(). row: CONTINUUM_ROW."""


class WaveSection(_core.NetworkResult, _fields.CoherentSection):
    """Signals at planes one above the other. Made by network.section()."""

    @documented("sp_coherent_fit")
    def wave(self, omega: float) -> CoherentWave:
        """The coherent wave at one frequency."""
        out = ffi.new("sp_coherent_wave *")
        call(lib.sp_coherent_fit, self._c, omega, out)
        return _core.record(CoherentWave, out, self._known_material())
