"""The elastic network of a packing: springs, stiffness matrix, and what follows from them."""
from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from . import _core, _fields, _place, _records, _sensitivity
from ._core import Floats, Integers, call, documented
from ._native import ffi, lib
from ._modes import (Clusters, ComplexModes, Continuum, DampedModes, DensityOfStates, Dispersion, Harmonic, LocalModuli,
                     Modes, Response, Transmission, WaveSection)
from ._place import Where
from ._sensitivity import Gradient
from ._si import InSI
from ._signal import Pulse, Signal

if TYPE_CHECKING:
    from ._packing import Packing

#: dtypes of Network.springs, Network.energy() and Network.flux()
SPRING = _core.dtype_of("sp_spring")
ENERGY = _core.dtype_of("sp_energy")
FLUX = _core.dtype_of("sp_flux")


_T = TypeVar("_T")


def _given(values: Mapping[str, Any]) -> dict[str, Any]:
    """The options among the arguments of a method, of its locals()."""
    return {name: value for name, value in values.items() if name != "self"}


def _scipy_sparse() -> Any:
    """scipy is needed for K and M as its matrices only."""
    return importlib.import_module("scipy.sparse")


@dataclasses.dataclass(frozen=True)
class Elasticity(InSI):
    """The stiffness tensor of a network. Made by network.elasticity().

    c, error: the tensor in Voigt's notation, and bounds of its errors [strains][strains] [E*]
    bulk, bulk_error: bulk modulus K, that of the tensor over all directions, and the bound of its error [E*]
    shear, shear_error: the same for the shear modulus G [E*]
    anisotropy, anisotropy_error: |c - isotropic part| over |c|, 0 if isotropic
    residual: largest |K u - f|/|f| of the solves
    """

    c: Floats
    error: Floats
    bulk: float
    bulk_error: float
    shear: float
    shear_error: float
    anisotropy: float
    anisotropy_error: float
    residual: float

    units = dict.fromkeys(("c", "error", "bulk", "bulk_error", "shear", "shear_error"), "E*")

    def __repr__(self) -> str:
        return (f"<Elasticity: K = {self.bulk:.6g}, G = {self.shear:.6g}, anisotropy {self.anisotropy:.3g}, "
                f"c {list(self.c.shape)}>")


def _span(lowest: int | None, band: tuple[float, float] | None, zero: bool = False) -> Any:
    """Which modes."""
    if lowest is not None and band is not None:
        raise _core.invalid("band", "cannot be combined with lowest")
    span = lib.sp_modes_range_all()
    if lowest is not None:
        span = lib.sp_modes_range_lowest(int(lowest))
    elif band is not None:
        span = lib.sp_modes_range_band(*_core.pair(band, "band"))
    span.zero = zero
    return ffi.new("sp_modes_range *", span)


class Network(_fields.Network):
    """The springs between the grains that carry force, with fixed walls or in a periodic cell: M u'' = -K u.

    Made by packing.network(). Vectors over the network are [n][dof]. The arrays are views, as those of a Packing.
    """

    def __init__(self, packing: Packing, *, threshold: float | None = None, prestress: bool = False,
                 sliding_free: bool = False, tangential: str | None = None) -> None:
        self._options = _core.options_of("sp_network_options", {
            "threshold": threshold, "prestress": prestress, "sliding_free": sliding_free, "tangential": tangential})
        self._make(packing._c, self._options)
        self.packing = packing

    def _record(self, cls: type[_T], function: Callable[..., int], *given: Any) -> _T:
        return _core.made(cls, self.packing.material, function, *given)

    # ---- the matrix -------------------------------------------------------------------------------------------------

    @property
    def dofs(self) -> int:
        """Degrees of freedom: n x dof."""
        return int(lib.sp_network_dofs(self._c))

    @documented("sp_network_assemble_whole")
    def csc(self) -> tuple[Floats, Integers, Integers]:
        """K in compressed sparse columns: values, row indices, start of each column. Works without scipy."""
        out = _core.new("sp_sparse", lib.sp_sparse_free)
        call(lib.sp_network_assemble_whole, self._c, out)
        entries = int(out.p[out.n])
        return (_core.view(out, out.x, (entries,)), _core.view(out, out.i, (entries,)),
                _core.view(out, out.p, (int(out.n) + 1,)))

    def K(self) -> Any:
        """The stiffness matrix, a scipy.sparse.csc_matrix [dofs][dofs]."""
        return _scipy_sparse().csc_matrix(self.csc(), shape=(self.dofs, self.dofs))

    def M(self) -> Any:
        """The diagonal matrix of masses and moments of inertia, a scipy.sparse.csc_matrix [dofs][dofs]."""
        return _scipy_sparse().diags(self.mass.ravel(), format="csc")

    def apply(self, u: npt.ArrayLike) -> Floats:
        """K u, for u [n][dof] or [dofs], without a matrix."""
        return self._product(lib.sp_network_apply, u)

    def apply_transposed(self, u: npt.ArrayLike) -> Floats:
        """K^T u; the same as apply() if K is symmetric."""
        return self._product(lib.sp_network_apply_transposed, u)

    def _product(self, function: Any, u: npt.ArrayLike) -> Floats:
        vector = self._vector(u)
        out = np.empty_like(vector)
        function(self._c, _core.pointer_to(vector), _core.pointer_to(out))
        return out

    def _vector(self, u: npt.ArrayLike) -> Floats:
        vector = _core.floats(u, "u")
        if vector.shape not in ((self.dofs,), (self.n, self.dof)):
            raise _core.invalid("u", f"has the shape {vector.shape}, must have {(self.n, self.dof)} or {(self.dofs,)}")
        return vector

    @documented("sp_network_touches")
    def touches(self, wall: int) -> bool:
        """Whether a spring leads to this wall: sonopack.BOTTOM, TOP, ..."""
        return bool(lib.sp_network_touches(self._c, wall))

    @documented("sp_network_energy2")
    def energy2(self, u: npt.ArrayLike) -> float:
        """u^T K u."""
        vector = self._vector(u)
        return float(lib.sp_network_energy2(self._c, _core.pointer_to(vector)))

    @property
    def omega_bound(self) -> float:
        """Upper bound of the largest frequency, a few percent above it."""
        return float(lib.sp_network_omega_bound(self._c))

    def spread(self, u: npt.ArrayLike, fill: float = np.nan) -> Floats:
        """A vector over the network for all grains of the packing [packing.n][dof]; rattlers get `fill`."""
        vector = self._vector(u).reshape(self.n, self.dof)
        out = np.full((self.packing.n, self.dof), fill)
        out[self.grain] = vector
        return out

    @documented("sp_network_source_at")
    def source(self, kind: str = "impulse", at: Where = _place.Place()) -> Floats:
        """The source vector [n][dof]."""
        out = np.empty((self.n, self.dof))
        number = _core.number_of("sp_source", kind, "source")
        call(lib.sp_network_source_at, self._c, number, _place.one(at, True), _core.pointer_to(out))
        return out

    @documented("sp_network_source_at")
    def detector(self, at: Where = _place.Place()) -> Floats:
        """The detector row [n][dof]: the force on it is (row * u).sum()."""
        out = np.empty((self.n, self.dof))
        call(lib.sp_network_detector_at, self._c, _place.one(at, False), _core.pointer_to(out))
        return out

    # ---- modes ------------------------------------------------------------------------------------------------------

    @documented("sp_modes_sparse")
    def modes(self, *, lowest: int | None = None, band: tuple[float, float] | None = None, zero: bool = False,
              vectors: bool = True, source: str = "impulse", solver: str = "auto", threads: int = 1) -> Modes:
        """Frequencies and eigenvectors: all of them, the `lowest` that are no zero modes, or those of a band.

        vectors=False: frequencies only, much faster. zero: with lowest, all zero modes too, in front of the others.
        """
        return Modes(self, _span(lowest, band, zero), vectors=vectors, source=source, solver=solver, threads=threads)

    @documented("sp_damped_modes_make")
    def damped_modes(self, damping: float | str, source: str = "impulse") -> DampedModes:
        """Modes with dashpots at all contacts: a fraction of critical damping, or words such as "gamma:0.01"."""
        return DampedModes(self, damping, source)

    @documented("sp_complex_modes_make")
    def complex_modes(self, source: str = "impulse", *, lowest: int | None = None, band: tuple[float, float] | None = None,
                      vectors: bool = True, solver: str = "auto", threads: int = 1) -> ComplexModes:
        """Modes with prestress and friction, of which some may grow: all of them, the lowest, or those of a band."""
        return ComplexModes(self, _span(lowest, band), vectors=vectors, source=source, solver=solver, threads=threads)

    @documented("sp_response_make")
    def respond(self, load: str, at: int = 0, axis: int = 0) -> Response:
        """The static response to a load: "force" or "swell" at a grain of the network, "dipole" at a spring, "strain"."""
        return Response(self, load, at, axis)

    @documented("sp_clusters_make")
    def clusters(self, method: str | None = None, *, sliding_at: float | None = None, walls: bool = True) -> Clusters:
        """Rigid clusters, by the pebble "game" (the default in two dimensions) or by "motions"."""
        return Clusters(self, method or ("motions" if self.dim == 3 else "game"), sliding_at, walls)

    @documented("sp_stability_make")
    def stability(self) -> _records.Stability:
        """Whether any motion grows."""
        return self._record(_records.Stability, lib.sp_stability_make, self.packing._c, self._c)

    # ---- waves ------------------------------------------------------------------------------------------------------

    @documented("sp_signal_make")
    def signal(self, *, until: float | None = None, points: int | None = None, method: str | None = None,
               tolerance: float | None = None, source: str | None = None, sources: Where | Iterable[Where] | None = None,
               detectors: Where | Iterable[Where] | None = None, damping: float | str | None = None,
               amplitude: float | None = None, step: float | None = None, modes: int | None = None,
               solver: str | None = None, stop_at_front: bool = False, pulse: Pulse | None = None,
               threads: int = 1) -> Signal:
        """The force on the top wall, minus its value at rest, after a pulse at the bottom wall.

        until: the last of `points` equally spaced times, by default after the first front. method: auto, chebyshev,
        dense, sparse, verlet, lax-wendroff, faber or dynamics (nonlinear). source: impulse, velocity or displacement.
        sources, detectors: places, such as Place.plane(5) or "plane:5". pulse: the source against time. damping: a
        fraction of critical damping, "gamma:C[:CT]" or "mass:RATE[:RATET]".
        """
        return Signal(self, _given(locals()))

    @documented("sp_network_front")
    def front(self, *, source: str = "impulse", window: float = 0.0) -> _records.Front:
        """The first wave front at the top wall."""
        number = _core.number_of("sp_source", source, "source")
        return self._record(_records.Front, lib.sp_network_front, self._c, number, window)

    @documented("sp_signal_field")
    def field(self, times: npt.ArrayLike, *, source: str = "impulse", at: Where | None = None, threads: int = 1,
              errors: bool = False) -> Any:
        """Displacements [times][n][dof] after the pulse; with errors=True a pair of them and of bounds of their errors
        [times]."""
        t = _core.row(times, "times")
        out = np.empty((len(t), self.n, self.dof))
        place = ffi.NULL if at is None else _place.one(at, True)
        spec = ffi.new("sp_field_options *", {"from": place, "times": len(t), "t": _core.pointer_to(t, "const double *"),
                                              "threads": threads})
        _core.set_fields(spec, {"source": source})
        bounds = np.empty(len(t))
        call(lib.sp_signal_field, self._c, spec, _core.pointer_to(out), _core.pointer_to(bounds))
        return (out, bounds) if errors else out

    # ---- elasticity -------------------------------------------------------------------------------------------------

    def _density(self, margin: float) -> float:
        out = ffi.new("double *")
        call(lib.sp_packing_density, self.packing._c, self._options.threshold, float(margin), out)
        return float(out[0])

    @documented("sp_moduli_make")
    def moduli(self, margin: float = 3.0) -> _records.Moduli:
        """Elastic moduli and speeds of long waves. margin: layers at the walls that do not count for the density."""
        return self._record(_records.Moduli, lib.sp_moduli_make, self._c, self._density(margin))

    @documented("sp_elasticity_make")
    def elasticity(self, margin: float = 3.0) -> Elasticity:
        """The whole stiffness tensor, with the bulk and shear modulus of its isotropic part."""
        out = ffi.new("sp_elasticity *")
        call(lib.sp_elasticity_make, self._c, self._density(margin), ffi.NULL, out)
        n = int(out.strains)
        c, error = (np.array([list(row) for row in rows])[:n, :n] for rows in (out.c, out.error))
        numbers = [getattr(out, field.name) for field in dataclasses.fields(Elasticity)[2:]]
        return _core.with_material(Elasticity(c, error, *numbers), self.packing.material)

    @documented("sp_ring_moduli_make")
    def ring_moduli(self) -> _records.RingModuli:
        """Moduli by what two rings feel when the inner one grows or turns."""
        return self._record(_records.RingModuli, lib.sp_ring_moduli_make, self._c)

    @documented("sp_local_moduli_make")
    def local_moduli(self, width: float) -> LocalModuli:
        """Moduli of parts that are about this wide, for a strain of the whole."""
        return LocalModuli(self, float(width))

    @documented("sp_moduli_probe")
    def probes(self, probes: Sequence[tuple[str, int]], margin: float = 3.0) -> list[_records.ProbeModuli]:
        """Apparent moduli of probes ("sine", n) or ("lines", n)."""
        array = ffi.new("sp_probe[]", len(probes))
        for k, (kind, n) in enumerate(probes):
            _core.set_fields(array[k], {"kind": kind, "n": int(n)})
        out = ffi.new("sp_probe_moduli[]", len(probes))
        phi3s = self.packing.statics(self._options.threshold, margin).phi3s
        call(lib.sp_moduli_probe, self._c, phi3s, len(probes), array, ffi.NULL, out)
        return [_core.record(_records.ProbeModuli, out[k], self.packing.material) for k in range(len(probes))]

    @documented("sp_moduli_finite_strain")
    def finite_strain(self, strain: float = 1e-6, *, turning: bool = True, margin: float = 3.0) -> _records.FiniteStrain:
        """Moduli at a finite strain, with the full contact law."""
        options = ffi.new("sp_finite_strain_options *", lib.sp_finite_strain_options_default())
        _core.set_fields(options, {"strain": float(strain), "turning": turning})
        return self._record(_records.FiniteStrain, lib.sp_moduli_finite_strain, self.packing._c, self._c,
                            self._density(margin), options)

    # ---- sensitivities ----------------------------------------------------------------------------------------------

    @documented("sp_sensitivity_front")
    def sensitivity(self, of: str = "t10", by: str | Sequence[str] = ("kn", "kt"), *, t: float | None = None,
                    source: str | None = None, at: Where | None = None, detector: Where | None = None,
                    pulse: Pulse | None = None, until: float | None = None, points: int | None = None,
                    margin: float = 3.0, threads: int = 1) -> Gradient:
        """Exact derivatives of a quantity: t10, t_peak, peak, t_zero or width of the first front, F (the signal at the
        time t), C11, C12, ..., c_l or c_t (at a fixed density). by: kn, kt, mass, radius, position, pressure."""
        wave = {"source": source, "at": at, "detector": detector, "pulse": pulse, "until": until, "points": points,
                "threads": threads}
        return _sensitivity.sensitivity(self, of, by, t, wave, margin)

    @documented("sp_sensitivity_modes")
    def mode_sensitivity(self, modes: Modes, first: int, count: int = 1,
                         by: str | Sequence[str] = ("kn", "kt")) -> Gradient:
        """Derivatives of the mean omega^2 of rows first .. first + count - 1 of modes with vectors."""
        return _sensitivity.of_modes(self, modes, first, count, by)

    @documented("sp_sensitivity_times")
    def signal_sensitivity(self, t: npt.ArrayLike, springs: npt.ArrayLike | None = None, *, source: str | None = None,
                           at: Where | None = None, detector: Where | None = None) -> tuple[Floats, Floats, Floats]:
        """dF/dk_n and dF/dk_t [springs][times] of chosen springs at all times t, and bounds of their errors [springs][2]."""
        return _sensitivity.of_times(self, t, springs, {"source": source, "at": at, "detector": detector})

    # ---- spectra ----------------------------------------------------------------------------------------------------

    @documented("sp_dos_make")
    def dos(self, *, method: str | None = None, norm: str | None = None, bins: int | None = None,
            until: float | None = None, resolution: float | None = None, vectors: int | None = None,
            seed: int | None = None, threads: int = 1) -> DensityOfStates:
        """The density of states: exact, by kernel polynomials (kpm), or counted in bins (count)."""
        return DensityOfStates(self, _core.options_of("sp_dos_options", _given(locals())))

    @documented("sp_transmission")
    def transmission(self, *, source: str | None = None, at: Where | None = None, detector: Where | None = None,
                     points: int | None = None, until: float | None = None,
                     resolution: float | None = None) -> Transmission:
        """Spectrum of the signal from wall to wall."""
        return Transmission(self, _place.options_of("sp_transmission_options", _given(locals())))

    @documented("sp_dispersion_make")
    def dispersion(self, *, up: bool | None = None, waves: int | None = None, node: float | None = None,
                   resolution: float | None = None, profile: int | None = None, along_y: bool = False) -> Dispersion:
        """Frequencies of longitudinal, transverse and rotational waves."""
        values = _given(locals())
        values["up"] = self.dim == 1 if up is None else up
        standing = self.cell == "box" or (values["up"] and self.cell == "piston")  # waves between walls
        behind = 0.5 if standing and self.packing.wall == "grain" else 0.0  # at the centre of the grain behind the wall
        values["node"] = behind if node is None else node
        return Dispersion(self, _core.options_of("sp_dispersion_options", values))

    @documented("sp_harmonic_make")
    def harmonic(self, omega: npt.ArrayLike, *, damping: float | str | None = None, source: str | None = None,
                 at: Where | None = None, detector: Where | None = None, planes: int | None = None,
                 range: tuple[float, float] | None = None, tolerance: float | None = None) -> Harmonic:
        """Steady response to driving with exp(i omega t)."""
        values, frequencies = _given(locals()), _core.row(omega, "omega")
        values |= {"omega": _core.pointer_to(frequencies, "const double *"), "n": len(frequencies),
                   "range": None if range is None else _core.pair(range, "range")}
        return Harmonic(self, _place.options_of("sp_harmonic_options", values))

    @documented("sp_continuum_make")
    def continuum(self, lowest: int = 12, *, solver: str = "auto", margin: float = 3.0) -> Continuum:
        """The lowest modes compared with those of a homogeneous elastic strip."""
        return Continuum(self, self._density(margin), lowest, _core.number_of("sp_modes_solver", solver, "solver"))

    @documented("sp_coherent_section_make")
    def section(self, *, source: str | None = None, spacing: float | None = None, low: float | None = None,
                 part: float | None = None, damping: float | str | None = None,
                 shear: bool | None = None) -> WaveSection:
        """Signals at planes one above the other, to which coherent waves are fitted."""
        return WaveSection(self, _core.options_of("sp_coherent_section_options", _given(locals())))

    # ---- transport of energy ----------------------------------------------------------------------------------------

    def _motion(self, values: npt.ArrayLike, name: str) -> Floats:
        out = np.array(values, dtype=float, order="C")
        if out.shape != (self.n, self.dof):
            raise ValueError(f"{name} has the shape {out.shape}, must be {(self.n, self.dof)}")
        return out

    @documented("sp_transport_energy")
    def energy(self, u: npt.ArrayLike, v: npt.ArrayLike) -> npt.NDArray[Any]:
        """Energies of the grains [n] of a motion, with the fields along, across, rotation, normal and tangential."""
        one, two, out = self._motion(u, "u"), self._motion(v, "v"), np.empty(self.n, ENERGY)
        call(lib.sp_transport_energy, self._c, _core.pointer_to(one), _core.pointer_to(two),
             _core.pointer_to(out, "sp_energy *"))
        return out

    @documented("sp_transport_flux")
    def flux(self, u: npt.ArrayLike, v: npt.ArrayLike, heights: npt.ArrayLike) -> npt.NDArray[Any]:
        """Fluxes of energy through planes, with the fields normal, sideways and rotation."""
        one, two, y = self._motion(u, "u"), self._motion(v, "v"), _core.row(heights, "heights")
        out = np.empty(len(y), FLUX)
        call(lib.sp_transport_flux, self._c, _core.pointer_to(one), _core.pointer_to(two), len(y),
             _core.pointer_to(y, "const double *"), _core.pointer_to(out, "sp_flux *"))
        return out

    @documented("sp_transport_advance")
    def advance(self, t: float, u: npt.ArrayLike, v: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Displacements and velocities after the time t, as new arrays."""
        one, two = self._motion(u, "u"), self._motion(v, "v")
        call(lib.sp_transport_advance, self._c, t, _core.pointer_to(one), _core.pointer_to(two), ffi.NULL)
        return one, two

    @documented("sp_spread_make")
    def diffusivity(self, omega: float, *, axis: int | None = None, width: float | None = None,
                    waves: int | None = None, sources: int | None = None, seed: int | None = None,
                    until: float | None = None) -> _records.Spread:
        """The diffusivity of energy from the spreading of random motions."""
        options = _core.options_of("sp_spread_options", {"axis": axis, "width": width, "waves": waves, "sources": sources,
                                                         "seed": seed, "until": until})
        return self._record(_records.Spread, lib.sp_spread_make, self._c, omega, options)

    @documented("sp_kubo_make")
    def kubo(self, modes: Modes, omega: float, *, axis: int | None = None, width: float | None = None,
             smear: float | None = None) -> _records.Kubo:
        """The diffusivity of energy from all modes of the network, with vectors."""
        options = _core.options_of("sp_kubo_options", {"axis": axis, "width": width, "smear": smear})
        return self._record(_records.Kubo, lib.sp_kubo_make, self._c, modes._c, 1, ffi.new("double *", omega), options)

    @documented("sp_split_make")
    def split(self, omega: float, *, width: float | None = None, sources: int | None = None, seed: int | None = None,
              start: float | None = None) -> _records.Split:
        """The split of the energy in equilibrium and after a pulse. start: the first time after the pulse."""
        options = _core.options_of("sp_split_options", {"width": width, "sources": sources, "seed": seed, "from": start})
        return self._record(_records.Split, lib.sp_split_make, self._c, omega, options)

    @documented("sp_network_dashpots")
    def damping(self, damping: float | str) -> Network:
        """The network of the dashpots: its K is the damping matrix C."""
        other = Network.__new__(Network)
        other._options, other.packing = self._options, self.packing
        other._c = _core.new("sp_network", lib.sp_network_free, lib.sp_network_none)
        call(lib.sp_network_dashpots, self._c, _core.damping_law(damping), other._c)
        return other

    def __repr__(self) -> str:
        return f"<Network: {self.n} grains, {len(self.springs)} springs, {self.dofs} degrees of freedom>"
