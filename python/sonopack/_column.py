"""The tapped column of particles (Blackmore et al. 2011)."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core, _scene
from ._core import Floats, Path, c_path, call, documented
from ._native import ffi, lib
from ._records import TappedExponent, TappedSymbol, TappedTap
from ._table import Table
from ._watch import Watch


@dataclass(frozen=True)
class ColumnRun:
    """Motion of a column (Blackmore et al. 2011). Made by column.run().

    t: times [s]
    y: heights of the floor and of the particles [times][particles + 1] [cm]
    v: their velocities [times][particles + 1] [cm/s]
    taps: the results of each tap
    initial_energy: energy at the start [erg]
    violated_at: first time at which particles have passed each other [s]; nan: never
    violated: number of taps in which they have
    events: contacts that closed or opened
    steps: time steps
    error: largest relative error of a step
    time_step: length of the steps [s]
    """

    t: Floats
    y: Floats
    v: Floats
    taps: list[TappedTap]
    initial_energy: float
    violated_at: float
    violated: int
    events: int
    steps: int
    error: float
    time_step: float


class Column(_core.Owner):
    """A column of particles on a tapped floor, in cm, g and s.

    Keys are those of the group column of `sonopack help scene`: Column(taps=8, output="strobe"); from_ stands for from,
    which Python keeps for itself. Column.read("file.cfg", taps=8) reads them from a scene file first.
    """

    _type = "sp_scene"

    def __init__(self, **keys: Any) -> None:
        self._load(None, keys)

    def _load(self, path: Path | None, keys: dict[str, Any]) -> None:
        self._c = _core.new("sp_scene", lib.sp_scene_free, lib.sp_scene_default)
        count, array, kept = _scene.overrides({f"column.{name.rstrip('_')}": value for name, value in keys.items()})
        with _core.without_place():
            call(lib.sp_scene_read_tapped, c_path(path) if path is not None else ffi.NULL, count, array, self._c)
        del kept

    @classmethod
    def read(cls, path: Path, **keys: Any) -> Column:
        """The column of a scene file; keys override its keys."""
        column = cls.__new__(cls)
        column._load(path, keys)
        return column

    @property
    def particles(self) -> int:
        """Number of particles above the floor."""
        return int(self._c.tapped.particles)

    @property
    def taps(self) -> int:
        """Number of periods of a run."""
        return int(lib.sp_tapped_taps(self._spec()))

    @property
    def period(self) -> float:
        """Time between taps [s]."""
        return float(self._c.tapped.period)

    @property
    def stiffness(self) -> float:
        """Stiffness K of a contact [g/s^2]."""
        return float(lib.sp_tapped_stiffness(self._spec()))

    def _spec(self) -> Any:
        """A struct that shares the lists of this column."""
        return ffi.new("sp_tapped_spec *", self._c.tapped)

    def mass(self, particle: int = 1) -> float:
        """Mass of a particle, 1 the lowest [g]."""
        return float(lib.sp_tapped_mass(self._spec(), particle))

    def radius(self, particle: int = 1) -> float:
        """Radius of a particle, 1 the lowest [cm]."""
        return float(lib.sp_tapped_radius(self._spec(), particle))

    @documented("sp_tapped_floor")
    def floor(self, t: float) -> tuple[float, float]:
        """Position [cm] and velocity [cm/s] of the floor at t >= 0."""
        return float(lib.sp_tapped_floor(self._spec(), t)), float(lib.sp_tapped_floor_velocity(self._spec(), t))

    @documented("sp_tapped_density")
    def density(self, y: npt.ArrayLike) -> float:
        """Mass over length of a column whose floor and particles are at y [particles + 1] [g/cm]."""
        heights = _core.floats(y, "y", (self.particles + 1,))
        return float(lib.sp_tapped_density(self._spec(), _core.pointer_to(heights)))

    def rest(self) -> Floats:
        """Heights of the particles at rest [particles]."""
        out = np.empty(self.particles)
        lib.sp_tapped_rest(self._spec(), _core.pointer_to(out))
        return out

    @documented("sp_tapped_table_watched")
    def table(self, *, threads: int = 1, progress: Callable[[float], object] | None = None) -> Table:
        """The table of the key `output`, as `sonopack column` prints it.

        progress is called with the share of the work that is done; it may return False to stop (Interrupted).
        """
        watch = Watch(progress)
        spec = self._spec()
        spec.stopped, spec.user = lib.sonopack_tapped_stopped, watch.handle
        watcher = ffi.new("sp_tapped_watcher *", {"watch": lib.sonopack_tapped_watch, "user": watch.handle})
        table = _core.new("sp_table", lib.sp_table_free, lib.sp_table_none)
        watch.run(lib.sp_tapped_table_watched, spec, threads, watcher[0], table)
        return Table(table)

    @documented("sp_tapped_run")
    def run(self, times: npt.ArrayLike) -> ColumnRun:
        """The motion at ascending times [s], over all taps."""
        t = _core.row(times, "times")
        width = self.particles + 1
        y, v = np.empty((len(t), width)), np.empty((len(t), width))
        row = 0

        def keep(_: float, positions: Any, velocities: Any) -> None:
            nonlocal row
            ffi.memmove(y[row], positions, 8 * width)
            ffi.memmove(v[row], velocities, 8 * width)
            row += 1

        watch = Watch(None, row=keep)
        spec = self._spec()
        spec.stopped, spec.user = lib.sonopack_tapped_stopped, watch.handle
        report = _core.new("sp_tapped_report", lib.sp_tapped_report_free)
        watch.run(lib.sp_tapped_run, spec, len(t), _core.pointer_to(t), lib.sonopack_tapped_row, watch.handle, report)
        taps = [_core.record(TappedTap, report.tap[k]) for k in range(report.taps)]
        return ColumnRun(t, y, v, taps, float(report.initial_energy), float(report.violated_at), int(report.violated),
                         int(report.events), int(report.steps), float(report.error), float(report.time_step))

    # ---- linear waves -----------------------------------------------------------------------------------------------

    @documented("sp_tapped_symbol_at")
    def symbol(self, model: str, k: float, *, alpha: float, slope: float = 1.0) -> TappedSymbol:
        """Growth and squared speed of linear waves of the model eq35, eq37 or longwave, at the wave number k [1/cm]."""
        number = _core.number_of("sp_tapped_model", model, "model")
        return _core.made(TappedSymbol, None, lib.sp_tapped_symbol_at, self._spec(), number, alpha, slope, k)

    @documented("sp_tapped_expansion_speed2")
    def expansion_speed2(self, alpha: float, slope: float = 1.0) -> float:
        """Squared speed of long waves of the corrected expansion [cm^2/s^2]."""
        return float(lib.sp_tapped_expansion_speed2(self._spec(), alpha, slope))

    @documented("sp_tapped_bsr_force")
    def bsr_force(self, form: str) -> float:
        """The largest force of (45), "literal" or "signed" [m g]."""
        return float(lib.sp_tapped_bsr_force(self._spec(), _core.number_of("sp_tapped_bsr", form, "form")))

    # ---- dynamics ---------------------------------------------------------------------------------------------------

    @documented("sp_tapped_lyapunov")
    def lyapunov(self) -> TappedExponent:
        """The largest Lyapunov exponent per tap."""
        return _core.made(TappedExponent, None, lib.sp_tapped_lyapunov, self._spec())

    @documented("sp_tapped_state_make")
    def start(self) -> Floats:
        """The state at the start of the first tap [2][particles]: overlaps [cm] and opening velocities [cm/s]."""
        state = _core.new("sp_tapped_state", lib.sp_tapped_state_free)
        call(lib.sp_tapped_state_make, self._spec(), state)
        rows = [_core.view(state, row, (self.particles,)) for row in (state.overlap, state.opening)]
        return np.array(rows)

    @documented("sp_tapped_map")
    def map(self, state: npt.ArrayLike, taps: int = 1) -> tuple[Floats, Floats]:
        """The state [2][particles] after some taps, and its derivative [2 particles][2 particles]."""
        after = _core.floats(state, "state", (2, self.particles)).copy()
        derivative = np.empty((2 * self.particles, 2 * self.particles))
        call(lib.sp_tapped_map, self._spec(), self._state(after), taps, _core.pointer_to(derivative))
        return after, derivative

    @documented("sp_tapped_positions")
    def positions(self, state: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Positions [cm] and velocities [cm/s] of a state [2][particles] at the start of a tap."""
        rows = _core.floats(state, "state", (2, self.particles))
        y, v = np.empty(self.particles), np.empty(self.particles)
        lib.sp_tapped_positions(self._spec(), self._state(rows), _core.pointer_to(y), _core.pointer_to(v))
        return y, v

    @staticmethod
    def _state(rows: Floats) -> Any:
        return ffi.new("sp_tapped_state *", {"overlap": _core.pointer_to(rows[0]), "opening": _core.pointer_to(rows[1])})

    def __repr__(self) -> str:
        return f"<Column: {self.particles} particles, {self.taps} taps of {self.period:g} s>"
