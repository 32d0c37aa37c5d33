"""What to read of other programs' files and how: options, keys, and which column means what."""
from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

from .._core import SonopackError
from .._records import Material
from .._table import quantity
from ._faults import bad_file, bad_option
from .sheet import Sheet, number

NAN = math.nan
SIDES = ("bottom", "top", "left", "right", "front", "back")
RINGS = ("inner", "outer")  # what bottom and top are of a ring
CELLS = ("piston", "periodic", "box", "ring")
WALLS = ("rigid", "grain", "elastic")

_ANY, _POSITIVE = (-math.inf, math.inf), (0.0, math.inf)
#: the keys: words that each may be, or the least and the largest number
_KEYS: dict[str, tuple[Any, ...]] = {
    "dimension": ("2", "3"), "up": ("x", "y", "z"), "cell": CELLS, "sides": ("open", "periodic"), "across": ("drop",),
    "width": _POSITIVE, "depth": _POSITIVE, "bottom": _ANY, "top": _ANY, "height": _POSITIVE,
    **{key: _POSITIVE for key in (*RINGS, "wall_kn", "wall_modulus")}, **{key: _ANY for key in ("x0", "y0", "z0")},
    **{key: _ANY for key in ("left", "right", "front", "back", "xy", "xz", "yz", "gravity")}, "pressure": _POSITIVE,
    "friction": (0.0, 1e6), "poisson": (0.0, 0.5), "wall": WALLS, "digits": ("exact",), "first_id": ()}
_DIMENSIONAL = ("width", "depth", "height", *SIDES, *RINGS, "x0", "y0", "z0", "xy", "xz", "yz", "pressure", "gravity")
#: those that the head of a file may say
SAID = ("dimension", "cell", "width", "depth", "height", *SIDES, *RINGS, "x0", "y0", "z0", "xy", "xz", "yz", "gravity", "friction", "poisson",
        "wall", "pressure")


@dataclasses.dataclass
class Options:
    """What is None or missing in `keys` follows from the files; docs/formats.md says how. Lengths and forces of the
    files are multiplied by the units, and are then in the units of the material; without a material they must be in d
    and E* d^2. Keys are in the units of the files; kn and thickness in those of the material."""

    form: str = "auto"
    contacts: str | None = None
    walls: str | None = None
    columns: str | None = None
    types: str | None = None
    frame: int | None = None
    material: Material | None = None
    length_unit: float = 1.0
    force_unit: float = 1.0
    mass_unit: float = 1.0
    kn: float = NAN
    kt_ratio: float = NAN
    thickness: float = NAN
    rest: bool = False
    threads: int = 1
    keys: dict[str, Any] = dataclasses.field(default_factory=dict)

    def number(self, key: str) -> float:
        """The number of a key; NaN if it is not given."""
        return float(self.keys.get(key, NAN))

    def given(self, *keys: str) -> bool:
        """Whether one of these keys is given."""
        return any(key in self.keys for key in keys)


def _in_file(name: str, value: str, o: Options) -> float:
    """A number with an SI unit, such as "100 kPa", in the units of the file; NaN if it is none."""
    unit, size = {"pressure": ("Pa", o.force_unit / o.length_unit**2), "gravity": ("m/s^2", o.force_unit / o.mass_unit)}.get(
        name, ("m", o.length_unit))
    try:
        return quantity(value, unit) / size
    except SonopackError:
        return NAN


def read_key(name: str, value: str, o: Options | None = None) -> Any:
    """The value of a key, checked. Where the options o have a material, lengths, pressure and gravity may have SI units."""
    if name not in _KEYS:
        raise bad_option(f"'{name:.60}={value:.60}': must be key=value with one of the keys {', '.join(_KEYS)}")
    allowed, found = _KEYS[name], number(value)
    si = name in _DIMENSIONAL and o is not None and o.material is not None
    if si and o is not None and math.isnan(found):
        found = _in_file(name, value, o)
    if name == "first_id":
        good, rule = bool(re.fullmatch(r"\+?\d{1,18}", value)), "a whole number >= 0"
    elif isinstance(allowed[0], str):
        good, rule = value in allowed, f"{', '.join(allowed[:-1])} or {allowed[-1]}".removeprefix(" or ")
    else:
        good, rule = allowed[0] <= found <= allowed[1], "a finite number" + " >= 0" * (allowed[0] == 0)
        rule += ", in the units of the file" * (name in _DIMENSIONAL) + " or with an SI unit" * si
    if not good:
        raise bad_option(f" = '{value:.60}': must be {rule}", name)
    return int(value) if name == "first_id" else value if isinstance(allowed[0], str) else found


def read_keys(texts: Iterable[str], o: Options | None = None) -> dict[str, Any]:
    """The keys of "key=value" or "packing.key=value"; o: their units."""
    keys = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip().removeprefix("packing.")
        if not equals:
            raise bad_option(f"'{text:.60}': must be key=value with one of the keys {', '.join(_KEYS)}")
        keys[name] = read_key(name, value.strip().strip('"'), o)
    return keys


def keys_of(values: Mapping[str, Any], o: Options | None = None) -> dict[str, Any]:
    """Keys from Python's values; o: their units."""
    return {name: read_key(name, str(value), o) for name, value in values.items()}


# ---- columns --------------------------------------------------------------------------------------------------------

OF_GRAINS = {
    "id": "id ID Id c_sp_wall[3]", "type": "type matId species info mol element", "x": "x xu xs xsu X",
    "y": "y yu ys ysu Y", "z": "z zu zs zsu Z", "radius": "radius r R rad Radius", "diameter": "diameter d D Diameter",
    "mass": "mass m masses", "inertia": "inertia", "density": "density", "boundary": "boundary",
    **{side: "" for side in (*SIDES, *RINGS)}}
OF_CONTACTS = {
    "id1": "id1 i patom1 c_sp_id[1] c_sp_gran[1]", "id2": "id2 j patom2 c_sp_id[2] c_sp_gran[2]",
    "overlap": "overlap penetrationDepth c_sp_gran[13]", "fn": "fn Fn force c_sp_contact[2]", "ft": "ft Ft",
    "ft_x": "ft_x Ftx p1 c_sp_contact[3] c_sp_gran[10]", "ft_y": "ft_y Fty p2 c_sp_contact[4] c_sp_gran[11]",
    "ft_z": "ft_z Ftz p3 c_sp_contact[5] c_sp_gran[12]", "t_x": "t_x", "t_y": "t_y", "t_z": "t_z",
    "fn_x": "fn_x c_sp_gran[7]", "fn_y": "fn_y c_sp_gran[8]", "fn_z": "fn_z c_sp_gran[9]", "f_x": "f_x c_sp_wall[4]",
    "f_y": "f_y c_sp_wall[5]", "f_z": "f_z c_sp_wall[6]", "p_x": "p_x", "p_y": "p_y", "p_z": "p_z", "kn": "kn",
    "kt": "kt ks"}
#: the names that programs give to their columns; sp_id, sp_contact and sp_gran are the computes of share/sonopack
_USUAL = OF_GRAINS | OF_CONTACTS

#: a column of a sheet and the sign that its numbers get
Column = tuple[int, float]


class Roles:
    """Which column of a sheet has which role: by the option --columns, or by its usual name."""

    def __init__(self, text: str | None) -> None:
        self.named: dict[str, tuple[str, float]] = {}
        self.used: set[str] = set()
        for word in filter(None, (text or "").split(",")):
            role, _, name = word.partition("=")
            if role not in _USUAL or not name:
                raise bad_option(f"--columns {role:.40}: must be ROLE=COLUMN, separated by commas, with a role of: "
                                 + " ".join(_USUAL))
            self.named[role] = (name.removeprefix("-"), -1.0 if name.startswith("-") else 1.0)

    def find(self, sheet: Sheet, role: str) -> Column | None:
        """The column of a role; None: there is none."""
        bare = [re.sub(r"\s*[(\[][^\d)\]]+[)\]]$", "", name) for name in sheet.names]  # "x (mm)"
        if role in self.named:
            name, sign = self.named[role]
            if name in sheet.names:
                self.used.add(role)
                return sheet.names.index(name), sign
        return next(((names.index(name), 1.0) for names in (sheet.names, bare) for name in _USUAL[role].split()
                     if name in names), None)

    def need(self, sheet: Sheet, role: str) -> Column:
        """The column of a role, which must be there."""
        found = self.find(sheet, role)
        if found is None:
            raise bad_file(f"{sheet.file}: no column for {role}; its columns are: {sheet.listed()}-- name it by "
                           f"--columns {role}=COLUMN")
        return found

    def axis_sign(self, axis: int) -> float:
        """-1 if the option turns this axis of the file, as y=-y does."""
        return self.named.get("xyz"[axis], ("", 1.0))[1]

    def vector(self, sheet: Sheet, role: str, axes: list[int]) -> list[Column] | None:
        """The columns role_x, ... along the axes of the packing. Components along an axis that is turned change their
        signs, unless the option names their own columns."""
        found = []
        every = [self.find(sheet, f"{role}_{axis}") for axis in "xyz"]  # also of axes that the packing does not have
        for axis in axes:
            column, name = every[axis], f"{role}_{'xyz'[axis]}"
            if column is not None:
                found.append((column[0], column[1] * (1.0 if name in self.named else self.axis_sign(axis))))
        if found and len(found) < len(axes):
            raise bad_file(f"{sheet.file}: {len(found)} of {len(axes)} columns of {role}_x, {role}_y"
                           f"{', ...' if len(axes) == 3 else ''}; must be all or none")
        return found or None

    def check(self, grains: Sheet, contacts: Sheet | None) -> None:
        """Refuses roles of the option that no sheet has."""
        for role, (name, _) in self.named.items():
            if role not in self.used and role not in (*SIDES, *RINGS):
                sheet = contacts if contacts is not None and role in OF_CONTACTS else grains
                raise bad_option(f"--columns {role}={name}: {sheet.file} has no such column; its columns are: "
                                 f"{sheet.listed()}")
