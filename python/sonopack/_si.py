"""Results in SI units: each number by the unit that it has in the headers."""
from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ._native import ffi, lib

if TYPE_CHECKING:
    from ._records import Material


def factor(unit: str, material: Material | None) -> float:
    """What a number in a unit of E*, rho and d is multiplied by to be in m, s, kg, N and Pa; 1 for a number without."""
    return in_si(unit, material)[0] if unit else 1.0


def in_si(unit: str, material: Material | None) -> tuple[float, str]:
    """That factor, and the unit in SI."""
    from . import _core, _table  # they stand on this module
    if material is None or not material.young > 0:
        raise _core.invalid("material", "of the grains is not known: give si(material)")
    struct, text, scale = ffi.new("sp_material *"), ffi.new("char[]", lib.SP_UNIT_TEXT), ffi.new("double *")
    _core.set_fields(struct, dataclasses.asdict(material))
    _core.call(lib.sp_unit_to_si, unit.encode(), struct, scale, text)
    name = base(_core.text_of(text))
    return _table.quantity(f"1 {unit}", name, material), name


def base(unit: str) -> str:
    """A unit of the tables in SI without its prefix: m of mm, kg of mg."""
    return re.sub(r"\b[numkMG]?(m|g|s|N|Pa)\b", lambda match: match[1].replace("g", "kg"), unit)


def converted(value: Any, unit: str, units: dict[str, str], material: Material | None) -> Any:
    """A number, an array, a record or a list of them in SI. units: of the fields of an array of structs."""
    if isinstance(value, (list, tuple)):
        return type(value)(converted(one, unit, units, material) for one in value)
    if isinstance(value, InSI) and unit:  # of the record as a whole, such as a number with its error
        scale = factor(unit, material)
        return dataclasses.replace(value, **{name: scale * number for name, number in vars(value).items()
                                             if isinstance(number, float)})
    if isinstance(value, InSI):
        return value.si(material)
    if isinstance(value, np.ndarray) and value.dtype.names:
        copy = value.copy()
        for name in set(value.dtype.names) & set(units):
            copy[name] *= factor(units[name], material)
        return copy
    return value * factor(unit, material) if isinstance(value, (float, np.ndarray)) else value


class InSI:
    """A record of numbers with units; those that `units` does not name are pure numbers."""

    units: ClassVar[dict[str, str]] = {}

    def si(self, material: Material | None = None) -> Any:
        """The same record with all numbers in SI units: m, s, kg, N, Pa. material: of the grains, by default that of the
        packing of which this is a result. InvalidInput (key "material") if it is not known."""
        material = material or getattr(self, "_material", None)
        return dataclasses.replace(self, **{
            field.name: converted(getattr(self, field.name), self.units.get(field.name.rstrip("_"), ""), {}, material)
            for field in dataclasses.fields(self)})


class Members:
    """The members of a result in SI units, as copies. units: {member: unit in SI} of those that have one."""

    def __init__(self, of: str, members: dict[str, Any], units: dict[str, str]) -> None:
        self.__dict__.update(members)
        self.units = units
        self._of = of

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{self._of} in SI units has no {name}")

    def __repr__(self) -> str:
        return f"<{self._of} in SI units: {', '.join(name for name in vars(self) if name not in ('units', '_of'))}>"
