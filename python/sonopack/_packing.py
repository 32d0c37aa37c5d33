"""Packings: grains at rest under pressure, and their contacts."""
from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core, _fields, _scene
from ._core import Floats, Path, c_path, call, documented
from ._native import ffi, lib
from ._network import Network
from ._records import (AmplitudeFront, AmplitudeHarmonics, AmplitudePlane, AmplitudeSecond, Audit, Front, Material,
                       PackProgress, RingStatics, Statics)
from ._watch import Watch

BOTTOM = int(lib.SP_BOTTOM)
TOP = int(lib.SP_TOP)
LEFT = int(lib.SP_LEFT)
RIGHT = int(lib.SP_RIGHT)
FRONT = int(lib.SP_FRONT)
BACK = int(lib.SP_BACK)
#: dtype of Packing.contacts: i, j, n, overlap, fn, ft, kn, kt
CONTACT = _core.dtype_of("sp_contact")


class Packing(_core.Drawn, _fields.Packing):
    """Grains at rest under pressure, and their contacts.

    Lengths are in mean grain diameters d, pressures in E*, forces in E* d^2, times in d / sqrt(E* / rho). The arrays are
    views of the library's memory: they are not copied, cannot be written to, and keep it alive.
    """

    _figure = "network"

    #: of a packing that another program wrote: what was read (sonopack.formats.Report)
    report: Any = None

    def __init__(self, struct: Any) -> None:
        self._c = struct

    # ---- where packings come from -----------------------------------------------------------------------------------

    @classmethod
    @documented("sp_packing_make")
    def make(cls, scene: _scene.Scene, *, seed: int | None = None,
             progress: Callable[[PackProgress], object] | None = None, threads: int = 1,
             start: Packing | None = None) -> Packing:
        """Compresses a packing: the first one of the scene, bit for bit that of `sonopack pack`.

        progress is called with a PackProgress several times a second; it may return False to stop, which raises
        Interrupted. Ctrl-C raises KeyboardInterrupt. start: the packing to begin with, in place of packing.file;
        packing.kind is "file" then, unless it is "minimum".
        """
        struct = scene.resolved()
        if seed is not None:
            _core.set_fields(struct.pack, {"seed": seed})
        if start is None and (name := os.fsdecode(ffi.string(getattr(struct, "from")))):
            start = cls.read(name)
        if start is not None:
            if struct.pack.kind != lib.SP_PACK_MINIMUM:
                struct.pack.kind = lib.SP_PACK_FILE
            call(lib.sp_pack_spec_from, ffi.addressof(struct, "pack"), start._c)
            if not struct.material.young > 0:
                struct.material = start._c.material
        made = cls.of_spec(ffi.addressof(struct, "pack"), start, progress=progress, threads=threads)
        if made._c.scene == ffi.NULL:
            made._c.scene = lib.sp_scene_text(struct, b"packing")
        made._c.material = struct.material
        return made

    @classmethod
    def of_spec(cls, spec: Any, start: Packing | None = None, *,
                progress: Callable[[PackProgress], object] | None = None, threads: int = 1) -> Packing:
        """Compresses the packing of an sp_pack_spec, from a gas or from a start."""
        watch = Watch(progress)
        hooks = ffi.new("sp_pack_hooks *", {"watch": lib.sonopack_pack_watch, "user": watch.handle, "threads": threads})
        if start is not None:
            setattr(hooks, "from", start._c)
        out = _none()
        watch.run(lib.sp_packing_make_with, spec, hooks, out)
        return cls(out)

    @classmethod
    @documented("sp_packing_read")
    def read(cls, path: Path, **words: Any) -> Packing:
        """Reads a packing from HDF5, text, or a file of another program, by its content, and checks it.

        words are for files of other programs: Packing.read("atoms.dump", contacts="contacts.dump", friction=0.5), see
        sonopack.formats.read.
        """
        from . import formats
        if words or formats.is_foreign(os.fsdecode(path)):
            return formats.read(path, **words)
        out = _none()
        call(lib.sp_packing_read, c_path(path), out)
        return cls(out)

    @classmethod
    def read_tables(cls, grains: Path, contacts: Path, keys: Mapping[str, Any] | None = None) -> Packing:
        """Reads a table of grains and one of contacts, and checks the packing. keys: {"pressure": 1e-4, ...}, in place of
        their comments: dimension, width, depth, height, cell, xy, xz, yz, gravity, pressure, friction, poisson, wall,
        material, seed."""
        from .formats import pair
        return pair.read(os.fsdecode(grains), os.fsdecode(contacts), keys or {})

    @classmethod
    def from_arrays(cls, x: npt.ArrayLike, r: npt.ArrayLike, contacts: Mapping[str, npt.ArrayLike] | npt.NDArray[Any],
                    *, box: Sequence[float], pressure: float, friction: float, poisson: float = 0.0, wall: str = "rigid",
                    mass: npt.ArrayLike | None = None, inertia: npt.ArrayLike | None = None,
                    material: Material | None = None, cell: str = "piston", tilt: Sequence[float] = (0.0, 0.0, 0.0),
                    gravity: float = 0.0, species: npt.ArrayLike | None = None) -> Packing:
        """A packing from arrays, which are copied and checked (InvalidInput names the first fault).

        x [n][dim] centres and r [n] radii [d]; columns of x beyond the lengths of box must be 0. box: the edges, the
        height last [d]. cell: "piston" (walls at the bottom and the top, periodic sideways), "periodic" along all axes,
        with the lattice vectors (box[0], 0, 0), (xy, box[1], 0), (xz, yz, box[2]) of tilt = (xy, xz, yz), "box" (walls
        on all sides), or "ring" (two circles about (box[0]/2, box[0]/2): box has the diameter of the outer one and
        their distance; BOTTOM is the inner one). contacts: an array of dtype CONTACT
        (such as that of another packing), or a dictionary of arrays: i, j (BOTTOM, TOP, ... for walls); if known n
        [contacts][dim], overlap, fn, and ft on i [contacts][dim] (or scalars in 2D: ft (-ny, nx)). What is left out
        follows: n from the positions, overlap and fn from each other by Hertz's law or from the positions; ft is 0.
        Stiffnesses kn, kt of contacts of another law, and mass and inertia [n] of grains that are no spheres of unit
        density, make a linear network; mu is Coulomb's coefficient of a contact where it is not friction. species [n]:
        materials of the grains.
        """
        radii = _core.floats(r, "r")
        places = _core.floats(x, "x")
        if radii.ndim != 1 or places.ndim != 2 or len(places) != len(radii) or places.shape[1] not in (1, 2, 3):
            raise _core.invalid("x", f"has the shape {places.shape}, and r {radii.shape}: must be [n][dim] and [n]")
        dim = len(box)
        if not 1 <= dim <= places.shape[1]:
            raise _core.invalid("box", f"has {dim} lengths: must have one for each of the dimensions")
        if np.any(places[:, dim:]):  # the rows of a packing have three columns in any dimension, the last ones 0
            raise _core.invalid("box", f"has {dim} lengths, but x has numbers in column {dim + 1}: it must have one for each "
                                       "dimension")
        if cell not in ("piston", "periodic", "box", "ring"):
            raise _core.invalid("cell", f"is {cell!r}: must be 'piston', 'periodic', 'box' or 'ring'")
        if cell == "ring" and dim != 2:
            raise _core.invalid("cell", f"is 'ring' in {dim} dimensions: must have 2")
        if len(tilt) != 3:
            raise _core.invalid("tilt", f"has {len(tilt)} numbers: must be xy, xz and yz")
        shape = _Cell(cell, [float(edge) for edge in box], [float(step) for step in tilt])
        table = contacts if isinstance(contacts, np.ndarray) else _contacts(places[:, :dim], radii, contacts, shape)
        if table.dtype != CONTACT:
            raise _core.invalid("contacts", f"has the dtype {table.dtype}: must be sonopack.CONTACT")
        if table.ndim != 1:
            raise _core.invalid("contacts", f"has the shape {table.shape}: must be one row of contacts")
        if (mass is None) != (inertia is None):
            raise _core.invalid("mass" if mass is None else "inertia", "is missing: must be both mass and inertia, or neither")
        out = _none()
        call(lib.sp_packing_alloc, out, dim, len(radii), len(table))
        _fill(out, places[:, :dim], radii, table)
        for axis in range(3):
            out.box[axis] = box[axis] if axis < dim else 1
            out.tilt[axis] = tilt[axis]
        _set_masses(out, mass, inertia, species)
        if material is not None:
            _set_material(out, material)
            call(lib.sp_material_check, ffi.addressof(out, "material"))
        _core.set_fields(out, {"pressure": float(pressure), "friction": float(friction), "poisson": float(poisson),
                               "wall": wall, "cell": cell, "gravity": float(gravity), "residual": float("nan")})
        lib.sp_packing_sort(out)
        call(lib.sp_packing_complete, out)
        call(lib.sp_packing_check, out)
        return cls(out)

    # ---- files ------------------------------------------------------------------------------------------------------

    @documented("sp_packing_save")
    def save(self, path: Path, **words: Any) -> None:
        """Writes HDF5 (.h5, .hdf5), text (.txt), or a file for another program (.vtp, .data, .dump, .xyz, .csv, .mat, with the
        words of sonopack.formats.save), as the ending says. A file of this name is replaced."""
        ending = os.path.splitext(os.fsdecode(path))[1]
        if ending not in (".h5", ".hdf5", ".txt"):
            from . import formats
            formats.save(self, path, **words)
        else:
            self.save_as(path, ending)

    def save_as(self, path: Path, ending: str) -> None:
        """Writes a file of any name as text, or as HDF5."""
        call(lib.sp_packing_save_text if ending == ".txt" else lib.sp_packing_save, self._c, c_path(path))

    def save_tables(self, grains: Path, contacts: Path) -> None:
        """Writes a table of grains and one of contacts."""
        from . import formats
        from .formats import pair
        call(lib.sp_packing_check, self._c)
        formats.write_files(pair.content(self, os.fsdecode(grains), os.fsdecode(contacts)))

    def repeated(self, *times: int) -> Packing:
        """Copies side by side, times[a] along axis a: a supercell, at rest as the packing is. Axes with walls take 1."""
        shape = _Cell(self.cell, list(self.box), list(self.tilt))
        for axis, count in enumerate(times):
            if count < 1 or (count > 1 and not shape.periodic(axis)):
                raise _core.invalid("times", f"{count} along axis {axis}: must be 1 or more, and 1 between walls")
        if len(times) != self.dim:
            raise _core.invalid("times", f"has {len(times)} numbers: must be one for each of the {self.dim} dimensions")
        base, n, copies = self.contacts, self.n, math.prod(times)
        lattice = shape.lattice()
        cell = np.array(list(np.ndindex(*times)))
        x = (self.x[None, :, : self.dim] + (cell @ lattice)[:, None, :]).reshape(-1, self.dim)
        i, j, bulk = base["i"], base["j"], base["j"] >= 0
        apart = base["n"][:, : self.dim] * (self.r[i] + self.r[j] - base["overlap"])[:, None]
        over = self.x[i, : self.dim] + apart - self.x[j, : self.dim]  # by how many lattice vectors i and j are apart
        step = np.where(bulk[:, None], np.rint(over @ np.linalg.inv(lattice)), 0).astype(int)
        table = np.tile(base, copies)
        for k, here in enumerate(cell):
            rows = slice(k * len(base), (k + 1) * len(base))
            there = np.ravel_multi_index(tuple((np.mod(here + step, times)).T), times)
            table["i"][rows] = k * n + i
            table["j"][rows] = np.where(bulk, there * n + j, j)
        _order(table)
        mass, inertia, species = (None if of is None else np.tile(of, copies) for of in self._masses())
        along = (*times, 1, 1)
        xy, xz, yz = self.tilt
        return Packing.from_arrays(
            x, np.tile(self.r, copies), table, box=[edge * count for edge, count in zip(self.box, times)],
            pressure=self.pressure, friction=self.friction, poisson=self.poisson, wall=self.wall, cell=self.cell,
            tilt=(xy * along[1], xz * along[2], yz * along[2]),
            mass=mass, inertia=inertia, species=species, gravity=self.gravity,
            material=self._known_material() if self._c.material.young > 0 else None)

    def of_material(self, material: Material) -> Packing:
        """The same packing of grains of another material, which tells what its numbers are in SI units."""
        other = _restored(*self.__reduce__()[1])
        _set_material(other._c, material)
        call(lib.sp_material_check, ffi.addressof(other._c, "material"))
        return other

    # ---- what it is like --------------------------------------------------------------------------------------------

    @property
    def box(self) -> tuple[float, ...]:
        """The edges, the height last [d]: periods, or distances of walls."""
        return tuple(self._c.box[axis] for axis in range(self.dim))

    @property
    def tilt(self) -> tuple[float, float, float]:
        """xy, xz and yz of the lattice vectors (box[0], 0, 0), (xy, box[1], 0), (xz, yz, box[2]) of a periodic cell [d]."""
        return self._c.tilt[0], self._c.tilt[1], self._c.tilt[2]

    @property
    def strain(self) -> dict[str, float]:
        """Strain of the cell since the first packing of the series (see frame), compression positive: e_xx, e_yy, ..."""
        return {name: value for name, value in zip(STRAINS, self._c.strain) if not math.isnan(value)}

    def set_series(self, frame: float, strain: Mapping[str, float]) -> None:
        """Gives the packing a place in a series: the number of its frame, or its time, and the strain of its cell, such as
        {"e_yy": 0.01}. Files keep them, and tables of commands have them as columns."""
        for name, value in {"frame": frame, **strain}.items():
            if name not in ("frame", *STRAINS) or math.isinf(value):
                raise _core.invalid(name, f"{value}: must be finite, and a strain one of {' '.join(STRAINS)}")
        _core.set_fields(self._c, {"frame": float(frame)})
        for axis, name in enumerate(STRAINS):
            self._c.strain[axis] = strain.get(name, math.nan)

    @property
    def species(self) -> npt.NDArray[np.int32] | None:
        """Material of each grain [n], from 0; None for one material."""
        return None if self._c.species == ffi.NULL else _core.view(self._c, self._c.species, (self.n,))

    def _masses(self) -> tuple[Any, Any, Any]:
        return self.mass, self.inertia, self.species

    @property
    def mass(self) -> Floats | None:
        """Masses [n]; None for spheres of unit density."""
        return None if self._c.mass == ffi.NULL else _core.view(self._c, self._c.mass, (self.n,))

    @property
    def inertia(self) -> Floats | None:
        """Moments of inertia [n]; None for spheres of unit density."""
        return None if self._c.inertia == ffi.NULL else _core.view(self._c, self._c.inertia, (self.n,))

    @property
    def height(self) -> float:
        """Edge along the last axis, under a piston the distance between the walls [d]."""
        return float(lib.sp_packing_height(self._c))

    @property
    def wall_area(self) -> float:
        """Area of the cell across the last axis [d^2]."""
        return float(lib.sp_packing_wall_area(self._c))

    @property
    def volume(self) -> float:
        """Volume of the cell [d^3]; in two dimensions its area times d."""
        return float(lib.sp_packing_volume(self._c))

    @property
    def hash(self) -> int:
        """A number of 63 bits that depends on grains, contacts and box."""
        return int(lib.sp_packing_hash(self._c))

    @documented("sp_packing_audit")
    def audit(self, threshold: float = 1e-4) -> Audit:
        """Checks the physics: balance of forces and torques, Coulomb's law, walls, contacts against positions."""
        return _core.made(Audit, self.material, lib.sp_packing_audit, self._c, threshold)

    @documented("sp_statics")
    def statics(self, threshold: float = 1e-4, margin: float = 3.0) -> Statics:
        """Densities, contacts, forces and stress, averaged over the bulk."""
        return _core.made(Statics, self.material, lib.sp_statics_make, self._c, threshold, margin)

    @documented("sp_ring_statics_make")
    def ring_statics(self, threshold: float = 1e-4) -> RingStatics:
        """Stresses of a packing between two rings, on polar axes, and at the rings."""
        return _core.made(RingStatics, self.material, lib.sp_ring_statics_make, self._c, threshold)

    @documented("sp_packing_rattlers")
    def rattlers(self, threshold: float = 1e-4) -> npt.NDArray[np.bool_]:
        """Which grains are rattlers [n]."""
        out = np.zeros(self.n, np.uint8)
        self._rattlers(threshold, _core.pointer_to(out, "uint8_t *"), ffi.NULL)
        return out.astype(np.bool_)

    @documented("sp_packing_rattlers")
    def carrying(self, threshold: float = 1e-4) -> npt.NDArray[np.bool_]:
        """Which contacts carry force [contacts]."""
        out = np.zeros(len(self.contacts), np.uint8)
        self._rattlers(threshold, ffi.NULL, _core.pointer_to(out, "uint8_t *"))
        return out.astype(np.bool_)

    def _rattlers(self, threshold: float, rattler: Any, carrying: Any) -> None:
        call(lib.sp_packing_rattlers, self._c, threshold, rattler, carrying, ffi.new("int32_t *"))

    # ---- sound ------------------------------------------------------------------------------------------------------

    def network(self, *, threshold: float | None = None, prestress: bool = False, sliding_free: bool = False,
                tangential: str | None = None) -> Network:
        """The springs between the grains that carry force: from there to modes, signals, moduli and spectra.

        tangential: "constant", "loading" or "lowest", the stiffness that Mindlin's loading history leaves.
        """
        return Network(self, threshold=threshold, prestress=prestress, sliding_free=sliding_free, tangential=tangential)

    @documented("sp_network_front")
    def front(self, *, source: str = "impulse", window: float = 0.0) -> Front:
        """The first wave front at the top wall, as `sonopack front` finds it."""
        return self.network().front(source=source, window=window)

    @documented("sp_amplitude_pulses")
    def loud_fronts(self, amplitudes: npt.ArrayLike, *, source: str | None = None, until: float | None = None,
                    tolerance: float | None = None) -> list[AmplitudeFront]:
        """The front at the top wall after pulses of these amplitudes, as `sonopack amplitude` finds it."""
        given = _core.floats(amplitudes, "amplitudes").ravel()
        out = ffi.new("sp_amplitude_front[]", len(given))
        options = _core.options_of("sp_amplitude_options", {"source": source, "until": until, "tolerance": tolerance})
        call(lib.sp_amplitude_pulses, self._c, options, len(given), _core.pointer_to(given), out, ffi.NULL)
        return [_core.record(AmplitudeFront, one, self.material) for one in out]

    @documented("sp_amplitude_planes")
    def loud_planes(self, amplitude: float, heights: npt.ArrayLike, *, source: str | None = None,
                    until: float | None = None, tolerance: float | None = None) -> list[AmplitudePlane]:
        """The fronts of one pulse at planes of these heights, ascending."""
        given = _core.floats(heights, "heights").ravel()
        out = ffi.new("sp_amplitude_plane[]", len(given))
        options = _core.options_of("sp_amplitude_options", {"source": source, "until": until, "tolerance": tolerance})
        call(lib.sp_amplitude_planes, self._c, options, float(amplitude), len(given), _core.pointer_to(given), out, ffi.NULL)
        return [_core.record(AmplitudePlane, one, self.material) for one in out]

    @documented("sp_amplitude_bursts")
    def loud_burst(self, amplitude: float, omega: float, cycles: int = 6, *, planes: int = 10,
                   heights: npt.ArrayLike | None = None,
                   tolerance: float | None = None) -> tuple[list[AmplitudeHarmonics], AmplitudeSecond]:
        """The harmonics of a burst at planes, `planes` equal distances or these heights, and what they tell together."""
        given = None if heights is None else _core.floats(heights, "heights").ravel()
        made = ffi.new("sp_amplitude_burst *", {"amplitude": float(amplitude), "omega": float(omega), "cycles": int(cycles)})
        out = ffi.new("sp_amplitude_harmonics[]", planes if given is None else len(given))
        second = ffi.new("sp_amplitude_second *")
        call(lib.sp_amplitude_bursts, self._c, _core.options_of("sp_amplitude_options", {"tolerance": tolerance}), made,
             len(out), ffi.NULL if given is None else _core.pointer_to(given), out, second)
        return ([_core.record(AmplitudeHarmonics, one, self.material) for one in out],
                _core.record(AmplitudeSecond, second, self.material))

    def _known_material(self) -> Material:
        return self.material

    def __len__(self) -> int:
        return self.n

    def __repr__(self) -> str:
        return f"<Packing: {self.n} grains, {self.dim}D, height {self.height:.6g} d, pressure {self.pressure:g} E*>"

    def __reduce__(self) -> tuple[Any, ...]:
        values = {name: getattr(self, name)
                  for name in ("cell", "gravity", "pressure", "friction", "poisson", "wall", "seed", "steps", "residual", "seconds")}
        masses = tuple(None if of is None else np.array(of) for of in self._masses())
        return _restored, (self.dim, np.array(self.x), np.array(self.r), np.array(self.contacts), masses,
                           list(self._c.box) + list(self._c.tilt), self.material, values, self.scene, (self.frame, self.strain))


#: names of the strains of a series
STRAINS = ("e_xx", "e_yy", "e_zz", "e_yz", "e_xz", "e_xy")


def _none() -> Any:
    return _core.new("sp_packing", lib.sp_packing_free, lib.sp_packing_none)


def _fill(out: Any, x: npt.NDArray[Any], r: npt.NDArray[Any], contacts: npt.NDArray[Any]) -> None:
    ffi.memmove(out.r, np.ascontiguousarray(r), 8 * len(r))
    centres = np.zeros((len(r), 3))
    centres[:, :x.shape[1]] = x
    ffi.memmove(out.x, centres, centres.nbytes)
    ffi.memmove(out.contacts, np.ascontiguousarray(contacts), contacts.nbytes)


def _set_masses(out: Any, mass: npt.ArrayLike | None, inertia: npt.ArrayLike | None,
                species: npt.ArrayLike | None = None) -> None:
    if species is not None:
        given = np.asarray(species)
        if given.shape != (out.n,) or given.dtype.kind not in "iu" or np.any(given > np.iinfo(np.int32).max):
            raise _core.invalid("species", f"{given.dtype} of the shape {given.shape}: must be one whole number for each grain")
        whole = np.ascontiguousarray(given, np.int32)
        call(lib.sp_packing_alloc_species, out)
        ffi.memmove(out.species, whole, whole.nbytes)
    if mass is None and inertia is None:
        return
    call(lib.sp_packing_alloc_masses, out)
    for pointer, values, key in ((out.mass, mass, "mass"), (out.inertia, inertia, "inertia")):
        if values is not None:
            ffi.memmove(pointer, _core.floats(values, key, (out.n,)), 8 * out.n)


def _set_material(out: Any, material: Material) -> None:
    _core.set_fields(out.material, dataclasses.asdict(material))


def _restored(dim: int, x: Any, r: Any, contacts: Any, masses: tuple[Any, ...], box: list[float], material: Material,
              values: dict[str, Any], scene: str,
              series: tuple[float, dict[str, float]] = (math.nan, {})) -> Packing:
    out = _none()
    call(lib.sp_packing_alloc, out, dim, len(r), len(contacts))
    _fill(out, x, r, contacts)
    _set_masses(out, *masses)
    out.box[0], out.box[1], out.box[2] = box[:3]
    out.tilt[0], out.tilt[1], out.tilt[2] = box[3:] or (0, 0, 0)
    _set_material(out, material)
    _core.set_fields(out, values)
    if scene:
        parsed = _scene.Scene.parse(scene)
        out.scene = lib.sp_scene_text(parsed._c, b"packing")
    made = Packing(out)
    made.set_series(*series)
    return made


def _axes(values: npt.ArrayLike, count: int, dim: int, key: str) -> npt.NDArray[np.float64]:
    array = _core.floats(values, key)
    if array.shape not in ((count, dim), (count, 3)):
        raise _core.invalid(key, f"has the shape {array.shape}, must have {(count, dim)}")
    return array[:, :dim]


@dataclasses.dataclass
class _Cell:
    """What bounds the grains: the kind, the edges and the tilt."""

    kind: str
    box: list[float]
    tilt: list[float]

    def periodic(self, axis: int) -> bool:
        return self.kind == "periodic" or (self.kind == "piston" and axis < len(self.box) - 1)

    def lattice(self) -> Floats:
        """The lattice vectors [dim][dim]."""
        (xy, xz, yz), (a, b, c), dim = self.tilt, [*self.box, 0.0, 0.0][:3], len(self.box)
        return np.array([[a, 0, 0], [xy, b, 0], [xz, yz, c]])[:dim, :dim]

    def walls(self) -> dict[int, tuple[int, float]]:
        """The axis across each wall, and where on it the wall is."""
        up = len(self.box) - 1
        found = {} if self.kind == "periodic" else {BOTTOM: (up, 0.0), TOP: (up, self.box[up])}
        if self.kind == "box":
            for axis, (low, high) in enumerate(((LEFT, RIGHT), (FRONT, BACK))[:up]):
                found |= {low: (axis, 0.0), high: (axis, self.box[axis])}
        return found

    def to_ring(self, x: Floats, wall: int) -> Floats:
        """Vectors from points to the nearest ones of a wall of a ring."""
        outer = 0.5 * self.box[0]
        d: Floats = x - outer
        r = np.hypot(*d.T)[:, None]
        away: Floats = d / r * ((outer if wall == TOP else outer - self.box[1]) - r)
        return away


def _geometry(x: Floats, r: Floats, i: npt.NDArray[Any], j: npt.NDArray[Any], cell: _Cell) -> tuple[Floats, Floats]:
    """Unit vectors from i to j, across the periodic sides where that is shorter (to walls straight), and overlaps."""
    away: Floats = x[np.maximum(j, 0)] - x[i]
    for axis, vector in reversed(list(enumerate(cell.lattice()))):
        if cell.periodic(axis):
            away -= np.round(away[:, axis] / cell.box[axis])[:, None] * vector
    away[j < 0] = 0
    for wall, (axis, place) in cell.walls().items():
        if cell.kind == "ring":
            away[j == wall] = cell.to_ring(x[i[j == wall]], wall)
        else:
            away[j == wall, axis] = place - x[i[j == wall], axis]
    distance: Floats = np.linalg.norm(away, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):  # coinciding centres are found by the check
        return away / distance[:, None], r[i] + np.where(j < 0, 0, r[np.maximum(j, 0)]) - distance


def _contacts(x: npt.NDArray[Any], r: Floats, given: Mapping[str, npt.ArrayLike],
              cell: _Cell) -> npt.NDArray[Any]:
    unknown = sorted(set(given) - {"i", "j", "n", "overlap", "fn", "ft", "kn", "kt"})
    missing = [name for name in ("i", "j") if name not in given]
    if unknown or missing:
        raise _core.invalid("contacts", f"unknown {', '.join(unknown)}" if unknown else f"no {', '.join(missing)}")
    i, j = (np.asarray(given[name]) for name in ("i", "j"))
    if i.ndim != 1 or i.shape != j.shape or i.dtype.kind not in "iu" or j.dtype.kind not in "iu":
        raise _core.invalid("contacts", "i and j must be arrays of integers of one length")
    walls = cell.walls()
    if len(i) and (i.min() < 0 or max(i.max(), j.max()) >= len(x) or not set(j[j < 0].tolist()) <= set(walls)):
        names = {BOTTOM: "BOTTOM", TOP: "TOP", LEFT: "LEFT", RIGHT: "RIGHT", FRONT: "FRONT", BACK: "BACK"}
        raise _core.invalid("contacts", f"i must be 0 .. {len(x) - 1}, j too"
                                        + (f", or {', '.join(names[wall] for wall in walls)}" if walls else ""))
    count, dim = len(i), x.shape[1]
    table = np.zeros(count, CONTACT)
    table["i"], table["j"] = i, j
    normals, overlaps = _geometry(x, r, i, j, cell)
    if "n" in given:
        normals = _axes(given["n"], count, dim, "n")
    table["n"][:, :dim] = normals
    for name in ("overlap", "fn"):
        table[name] = _core.floats(given[name], name, (count,)) if name in given else np.nan
    for name in ("kn", "kt"):
        table[name] = _core.floats(given[name], name, (count,)) if name in given else np.nan if name == "kt" else 0
    if "overlap" not in given and "fn" not in given:
        table["overlap"] = overlaps
    if "ft" in given:
        ft = _core.floats(given["ft"], "ft")
        if ft.ndim == 1 and dim == 2 and ft.shape == (count,):
            ft = ft[:, None] * np.stack([-normals[:, 1], normals[:, 0]], axis=1)
        table["ft"][:, :dim] = _axes(ft, count, dim, "ft")
    _order(table)
    return table


def _order(table: npt.NDArray[Any]) -> None:
    """The library has i < j: n and the force on i change their signs."""
    swap = (table["j"] >= 0) & (table["j"] < table["i"])
    table["i"][swap], table["j"][swap] = table["j"][swap], table["i"][swap]
    table["n"][swap] *= -1
    table["ft"][swap] *= -1
