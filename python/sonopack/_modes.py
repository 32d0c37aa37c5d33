"""What follows from a network: modes, density of states, transmission, dispersion, driving, the continuum, coherent
waves."""
from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core, _fields
from ._core import Floats, Path, c_path, call, documented
from ._native import ffi, lib
from ._records import CoherentWave, FreePath, ParticipationBin

if TYPE_CHECKING:
    from ._network import Network

#: dtypes of Dispersion.wave, Harmonic.fit and Continuum.row
DISPERSION_POINT = _core.dtype_of("sp_dispersion_point")
WAVE_FIT = _core.dtype_of("sp_wave_fit")
CONTINUUM_ROW = _core.dtype_of("sp_continuum_row")


def _save(modes: Modes | ComplexModes, path: Path, save: Any) -> None:
    if os.path.splitext(os.fspath(path))[1] not in (".h5", ".hdf5"):
        raise _core.invalid("", f"{os.fspath(path)}: the ending of a file of modes must be .h5")
    network = modes.network
    made = ffi.new("sp_modes_made *", {"network": network._options[0], "source": modes._options.source})
    call(save, modes._c, network.packing._c, network._c, made, c_path(path))


class Modes(_fields.Modes):
    """Modes of a network, sorted by omega; rattlers' zero modes come first. Made by network.modes().

    `vectors` [modes that are no rattlers'][n][dof] are weighted with the masses: displacement times sqrt(mass).
    """

    _missing = "frequencies only: ask for modes(vectors=True)"

    def __init__(self, network: Network, span: Any, *, vectors: bool, source: str, solver: str, threads: int) -> None:
        options = _core.options_of(
            "sp_modes_options", {"vectors": vectors, "source": source, "solver": solver, "threads": threads})
        self.network = network
        self._options = options
        self._make(network._c, options, span)

    @property
    def ab(self) -> Floats:
        """a b, the weight of each mode in the signal."""
        return self.a * self.b  # type: ignore[no-any-return]

    @property
    def vectors(self) -> Floats:
        """Eigenvectors [n - n_rattler][grains of the network][dof], weighted with the masses; a view."""
        if self._c.vectors == ffi.NULL:
            raise AttributeError(f"vectors: {self._missing}")
        return _core.view(self._c, self._c.vectors, (self.n - self.n_rattler, self.network.n, self.network.dof))

    def displacement(self, row: int) -> Floats:
        """Displacements [n][dof] in the mode of a row of omega: its vector over the square roots of the masses."""
        if not self.n_rattler <= row < self.n:
            raise _core.invalid("row", f"{row}: must be {self.n_rattler} .. {self.n - 1}")
        return self.vectors[row - self.n_rattler] / self.network.mass**0.5  # type: ignore[no-any-return]

    @documented("sp_modes_vector_error")
    def vector_error(self, row: int) -> float:
        """Bound of the error of the vector of a row."""
        if not self.n_rattler <= row < self.n:
            raise _core.invalid("row", f"{row}: must be {self.n_rattler} .. {self.n - 1}")
        return float(lib.sp_modes_vector_error(self._c, self.network._c, row))

    @documented("sp_participation")
    def participation_bins(self, bins: int = 40, until: float = 0.0) -> list[ParticipationBin]:
        """Participation ratios in bins of frequency."""
        if not 1 <= bins <= 1_000_000:
            raise _core.invalid("bins", f"{bins}: must be 1 .. 1000000")
        out = ffi.new("sp_participation_bin[]", bins)
        call(lib.sp_participation, self._c, bins, until, out)
        return [_core.record(ParticipationBin, out[k], self._known_material()) for k in range(bins)]

    @documented("sp_modes_save")
    def save(self, path: Path) -> None:
        """Writes modes and vectors to HDF5, as `sonopack modes --vectors FILE.h5` does."""
        _save(self, path, lib.sp_modes_save)

    def __len__(self) -> int:
        return self.n

    def __repr__(self) -> str:
        if self.n == 0:
            return "<Modes: none>"
        return f"<Modes: {self.n}, {self.n_zero} of them zero modes, omega {self.omega[0]:.6g} .. {self.omega[-1]:.6g}>"


class DampedModes(_fields.DampedModes):
    """Modes with dashpots at all contacts. Made by network.damped_modes()."""

    def __init__(self, network: Network, damping: float | str, source: str) -> None:
        law = _core.damping_law(damping)
        self.network = network
        self._c = _core.new("sp_damped_modes", lib.sp_damped_modes_free, lib.sp_damped_modes_none)
        call(lib.sp_damped_modes_with, network._c, law, _core.number_of("sp_source", source, "source"), self._c)

    @documented("sp_damped_modes_quality")
    def quality(self) -> tuple[Floats, Floats]:
        """Quality factors [n] and bounds of their errors [n]."""
        q, error, pair = np.empty(self.n), np.empty(self.n), ffi.new("double[2]")
        for k in range(self.n):
            lib.sp_damped_modes_quality(self._c, k, pair, pair + 1)
            q[k], error[k] = pair[0], pair[1]
        return q, error


class ComplexModes(_fields.ComplexModes):
    """Motions of a network with prestress and friction, which may grow. Made by network.complex_modes().

    A row moves as the real part of displacement(row) exp((growth + i omega) t).
    """

    _missing = Modes._missing

    def __init__(self, network: Network, span: Any, **options: Any) -> None:
        self.network = network
        self._options = _core.options_of("sp_modes_options", options)
        self._make(network._c, self._options, span)

    def _complex(self, name: str, rows: Any = slice(None)) -> npt.NDArray[np.complex128]:
        parts = [getattr(self._c, name), getattr(self._c, f"{name}_im")]
        if parts[0] == ffi.NULL:
            raise AttributeError(f"{name}: {self._missing}")
        shape = self.n - self.rattlers, self.network.n, self.network.dof
        re, im = (_core.view(self._c, part, shape) for part in parts)
        return re[rows] + 1j * im[rows]  # type: ignore[no-any-return]

    @property
    def right(self) -> npt.NDArray[np.complex128]:
        """Right eigenvectors e [n - rattlers][grains of the network][dof], weighted with the masses; a copy."""
        return self._complex("right")

    @property
    def left(self) -> npt.NDArray[np.complex128]:
        """Left eigenvectors f, of the same shape, with the sum of f e = 1; a copy."""
        return self._complex("left")

    def displacement(self, row: int) -> npt.NDArray[np.complex128]:
        """Complex displacements [n][dof] in the mode of a row of omega, at t = 0."""
        if not self.rattlers <= row < self.n:
            raise _core.invalid("row", f"{row}: must be {self.rattlers} .. {self.n - 1}")
        return self._complex("right", row - self.rattlers) / self.network.mass**0.5

    @documented("sp_complex_modes_save")
    def save(self, path: Path) -> None:
        """Writes modes and vectors to HDF5, as `sonopack modes --vectors FILE.h5` does."""
        _save(self, path, lib.sp_complex_modes_save)


class Response(_fields.Response):
    """Displacements and forces of a static load. Made by network.respond()."""

    def __init__(self, network: Network, load: str, at: int, axis: int) -> None:
        self.network = network
        self._c = _core.new("sp_response", lib.sp_response_free, lib.sp_response_none)
        kind = _core.number_of("sp_load_kind", load, "load")
        call(lib.sp_response_make, network._c, ffi.new("sp_load *", {"kind": kind, "at": at, "axis": axis}), self._c)

    @documented("sp_response_limits")
    def limits(self) -> tuple[Floats, Floats]:
        """Amplitudes of the load at which each spring opens, and slides [springs]."""
        opens, slides, pair = np.empty(self.springs), np.empty(self.springs), ffi.new("double[2]")
        for k in range(self.springs):
            lib.sp_response_limits(self.network.packing._c, self.network._c, self._c, k, pair, pair + 1)
            opens[k], slides[k] = pair[0], pair[1]
        return opens, slides


class LocalModuli(_core.NetworkResult, _fields.LocalModuli):
    """Moduli of the parts of a packing. Made by network.local_moduli()."""


class Clusters(_fields.Clusters):
    """Rigid clusters of the contacts. Made by network.clusters()."""

    def __init__(self, network: Network, method: str, sliding_at: float | None, walls: bool) -> None:
        self.network = network
        self._c = _core.new("sp_clusters", lib.sp_clusters_free, lib.sp_clusters_none)
        options = _core.options_of("sp_clusters_options", {"method": method, "sliding_at": sliding_at, "walls": walls})
        call(lib.sp_clusters_make, network.packing._c, network._c, options, self._c)


# ---- spectra ----------------------------------------------------------------------------------------------------------

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
        return _core.made(CoherentWave, self._known_material(), lib.sp_coherent_fit, self._c, omega)

    @documented("sp_coherent_errors")
    def errors(self, wave: CoherentWave) -> tuple[float, float]:
        """Errors of k and alpha [1/d] of a wave of this section."""
        errors = ffi.new("double [2]")
        lib.sp_coherent_errors(self._c, ffi.new("sp_coherent_wave *", dataclasses.asdict(wave)), errors, errors + 1)
        return float(errors[0]), float(errors[1])


@documented("sp_free_path")
def free_path(k: float, k_err: float, alpha: float, alpha_err: float) -> FreePath:
    """The scattering mean free path of a wave, from wave number and attenuation [1/d] with their errors."""
    return _core.record(FreePath, lib.sp_free_path_of(k, k_err, alpha, alpha_err))


@documented("sp_ioffe_regel")
def ioffe_regel(omega: npt.ArrayLike, paths: Sequence[FreePath]) -> tuple[float, float] | None:
    """The frequency of Ioffe and Regel and its error, from the free paths at ascending frequencies [n]; None: there is
    none."""
    frequencies, out = _core.floats(omega, "omega", (len(paths),)), ffi.new("double [2]")
    known = ffi.new("sp_free_path []", [dataclasses.asdict(path) for path in paths])
    found = lib.sp_ioffe_regel(len(paths), _core.pointer_to(frequencies), known, out, out + 1)
    return (float(out[0]), float(out[1])) if found else None
