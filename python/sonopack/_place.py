"""Where sources and detectors are."""
from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import _core
from ._native import ffi, lib


@dataclass(frozen=True)
class Place:
    """Place of a source or detector: Place.wall(), part(low, high), disc(x, y, diameter), grain(index) or
    plane(height).

    kind: wall, part, disc, grain or plane
    shear: along x in place of the normal
    low: of a part: its left end [d]
    high: of a part: its right end [d]
    height: of a plane [d]
    index: of a grain, in the packing
    x: of a disc: its centre [d]
    y: of a disc: its centre [d]
    diameter: of a disc [d]
    """

    kind: str = "wall"
    shear: bool = False
    low: float = 0.0
    high: float = 0.0
    height: float = 0.0
    index: int = 0
    x: float = 0.0
    y: float = 0.0
    diameter: float = 0.0

    @classmethod
    def wall(cls, shear: bool = False) -> Place:
        """A whole wall: the bottom for a source, the top for a detector."""
        return cls("wall", shear)

    @classmethod
    def part(cls, low: float, high: float, shear: bool = False) -> Place:
        """The part of that wall from low to high [d]."""
        return cls("part", shear, low=low, high=high)

    @classmethod
    def disc(cls, x: float, y: float, diameter: float, shear: bool = False) -> Place:
        """A circle of that wall, in three dimensions [d]."""
        return cls("disc", shear, x=x, y=y, diameter=diameter)

    @classmethod
    def grain(cls, index: int, shear: bool = False) -> Place:
        """One grain, by its index in the packing."""
        return cls("grain", shear, index=index)

    @classmethod
    def plane(cls, height: float, shear: bool = False) -> Place:
        """A plane at a height [d]: the flux of momentum through it; in periodic cells for sources too."""
        return cls("plane", shear, height=height)

    @classmethod
    def parse(cls, text: str, source: bool | None = None) -> Place:
        """A place as the command writes it: top, bottom, part:X0:X1, disc:X:Y:D, grain:I, plane:Y, with :shear or :normal.
        source: whether it is that of a source, to which the top is refused, or of a detector; None: either."""
        out = ffi.new("sp_place *")
        try:
            _core.call(lib.sp_place_read, text.encode(), text.startswith(("bottom", "inner")) if source is None else source, out, ffi.NULL)
        except _core.InvalidInput as error:
            raise _core.invalid("place", str(error)) from None
        kind = _core.words("sp_place_kind")[out.kind]
        return cls(kind, bool(out.shear), getattr(out, "from"), out.to, out.height, out.grain, out.x, out.y, out.diameter)

    def _write(self, to: Any) -> None:
        _core.set_fields(to, {"kind": self.kind, "shear": self.shear, "height": float(self.height)})
        setattr(to, "from", float(self.low))
        to.to = float(self.high)
        _core.set_fields(to, {"grain": int(self.index), "x": float(self.x), "y": float(self.y),
                              "diameter": float(self.diameter)})


#: A place, as a Place or as the command writes it
Where = Place | str


def place(where: Where, source: bool) -> Place:
    if not isinstance(where, (str, Place)):
        raise _core.invalid("place", f"{where!r}: must be a Place or a text such as plane:5")
    return Place.parse(where, source) if isinstance(where, str) else where


def one(where: Where, source: bool) -> Any:
    struct = ffi.new("sp_place *")
    place(where, source)._write(struct)
    return struct


def options_of(c_name: str, values: Mapping[str, Any]) -> Any:
    """Options of the library, with those values that are not its own; at and detector are places."""
    own = {name: value for name, value in values.items() if name not in ("at", "detector")}
    options = _core.options_of(c_name, own)
    for name, field in (("at", "from"), ("detector", "to")):
        if values.get(name) is not None:
            setattr(options, field, one(values[name], name == "at")[0])
    return options


def several(where: Where | Iterable[Where] | None, source: bool) -> tuple[int, Any]:
    """Number of places and their array; 0 and NULL for the whole wall."""
    if where is None:
        return 0, ffi.NULL
    places: Sequence[Place] = [place(each, source) for each in ([where] if isinstance(where, (str, Place)) else where)]
    array = ffi.new("sp_place[]", len(places))
    for k, each in enumerate(places):
        each._write(array[k])
    return len(places), array
