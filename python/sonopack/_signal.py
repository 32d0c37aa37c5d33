"""Signals after a pulse, and their first fronts."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from . import _core, _fields, _place
from ._core import Floats, call, documented
from ._native import ffi, lib
from ._records import Front
from ._si import Members
from ._table import Table

if TYPE_CHECKING:
    from ._network import Network

DYNAMICS_TOLERANCE = 1e-3  # of the command, too: the error falls only with the square of the time step


@documented("sp_front_find")
def front(t: npt.ArrayLike, f: npt.ArrayLike, *, window: float | None = None, rise: float | None = None,
          prominence: float | None = None) -> Front:
    """The first front of any trace: a signal, a simulation, a measurement. window: the last time that is used."""
    times, values = _core.floats(t, "t"), _core.floats(f, "f")
    if times.ndim != 1 or times.shape != values.shape:
        raise _core.invalid("f", f"has the shape {values.shape}, and t {times.shape}: must have one number for each time")
    options = ffi.new("sp_front_options *", lib.sp_front_options_default())
    _core.set_fields(options, {"window": window, "rise": rise, "prominence": prominence})
    return _core.made(Front, None, lib.sp_front_find, len(times), _core.pointer_to(times), _core.pointer_to(values), options)


class Pulse:
    """Strength of a source against time, in place of the short pulse: Pulse.gauss(width), ricker(omega), sine(omega,
    cycles), square(width), or table(t, s). Times are in d / sqrt(E* / rho), frequencies in sqrt(E* / rho) / d."""

    def __init__(self, kind: str, **values: float) -> None:
        self._c = ffi.new("sp_pulse *")
        self._kept: list[Floats] = []
        _core.set_fields(self._c, {"kind": kind, **{name: float(value) for name, value in values.items()}})

    @classmethod
    def gauss(cls, width: float) -> Pulse:
        """A Gaussian of this standard deviation."""
        return cls("gauss", width=width)

    @classmethod
    def ricker(cls, omega: float) -> Pulse:
        """Ricker's wavelet, whose spectrum is largest at omega."""
        return cls("ricker", omega=omega)

    @classmethod
    def sine(cls, omega: float, cycles: float) -> Pulse:
        """So many cycles of a sine."""
        return cls("sine", omega=omega, cycles=cycles)

    @classmethod
    def square(cls, width: float) -> Pulse:
        """A constant strength for this time."""
        return cls("square", width=width)

    @classmethod
    def table(cls, t: npt.ArrayLike, s: npt.ArrayLike) -> Pulse:
        """Strengths s at the times t, with straight lines between them."""
        pulse = cls("table")
        pulse._kept = [_core.floats(t, "t"), _core.floats(s, "s")]
        if pulse._kept[0].ndim != 1 or pulse._kept[0].shape != pulse._kept[1].shape:
            raise _core.invalid("s", "must have one number for each time of t")
        pulse._c.n = len(pulse._kept[0])
        pulse._c.t, pulse._c.s = (_core.pointer_to(each, "const double *") for each in pulse._kept)
        return pulse

    def __repr__(self) -> str:
        kind = _core.words("sp_pulse_kind")[int(self._c.kind)]
        given = {"gauss": ("width",), "ricker": ("omega",), "sine": ("omega", "cycles"), "square": ("width",)}.get(kind, ())
        values = ", ".join(f"{getattr(self._c, name):g}" for name in given)
        return f"Pulse.{kind}({values or f'{self._c.n} times'})"

    @documented("sp_pulse_strength")
    def __call__(self, t: float) -> float:
        """s(t)."""
        return float(lib.sp_pulse_strength(self._c, t))


class Signal(_core.Drawn, _fields.Signal):
    """The force on a detector after a pulse, at equally spaced times. Made by network.signal()."""

    _figure = "signal"

    def __init__(self, network: Network, values: dict[str, Any]) -> None:
        self.network = network
        self._height, self._pressure = network.packing.height, network.packing.pressure
        self._c = _core.new("sp_signal", lib.sp_signal_free, lib.sp_signal_none)
        pulse, values["front"] = values.pop("pulse"), values.pop("stop_at_front")
        count, start = _place.several(values.pop("sources"), True)
        count_to, end = _place.several(values.pop("detectors"), False)
        usual = lib.sp_signal_options_default().tolerance
        if values["method"] == "dynamics" and values["tolerance"] is None:
            values["tolerance"] = max(usual, DYNAMICS_TOLERANCE)
        if values["until"] is None:
            values["until"] = signal_window(self._height, self._pressure)
        options = _core.options_of("sp_signal_options", {
            **values, "sources": count, "from": start, "detectors": count_to, "to": end})
        if pulse is not None:
            call(lib.sp_signal_pulse, network._c, options, pulse._c, self._c)
        else:
            call(lib.sp_signal_compute, network.packing._c, network._c, options, self._c)

    @property
    def F(self) -> Floats:
        """The force of a single signal [n], or f [sources][detectors][n] of several; a view."""
        f: Floats = self.f
        return f.reshape(-1) if f.shape[:2] == (1, 1) else f

    def front(self, source: int = 0, detector: int = 0, *, window: float | None = None) -> Front:
        """The first front of one of the signals, as `sonopack front` finds it in a table of `sonopack signal`."""
        usual = signal_window(self._height, self._pressure)
        found = front(self.t, self.f[source, detector], window=usual if window is None else window)
        return _core.with_material(found, self._known_material())

    def si(self, material: Any = None) -> Members:
        """The members and F in SI units (s, N, ...), as copies. material: of the grains, by default that of the packing."""
        members = super().si(material)
        members.__dict__["F"] = members.f.reshape(self.F.shape)
        return members

    def table(self) -> Table:
        """Columns t and F (F1, F2, ... of several), with what `sonopack front` and `sonopack plot` need to know."""
        forces = self.f.reshape(-1, self.n)
        names = ["F"] if len(forces) == 1 else [f"F{k + 1}" for k in range(len(forces))]
        units = {"t": "d/sqrt(E* / rho)", **{name: "E* d^2" for name in names}}
        return Table.from_columns({"t": self.t, **dict(zip(names, forces))}, units,
                                  {"method": self.method, "height": self._height, "pressure": self._pressure,
                                   "error": self.error})

    def __len__(self) -> int:
        return self.n

    def __repr__(self) -> str:
        return (f"<Signal: {self.n} times up to {self.t[-1]:.6g}, {self.sources} x {self.detectors}, {self.method}, "
                f"error {self.error:.2g}>")


def signal_window(height: float, pressure: float) -> float:
    """A time after the passage of the first front: 8 H + 40 at p = 1e-4, scaled with p^(-1/6)."""
    return float(lib.sp_signal_window(height, pressure))
