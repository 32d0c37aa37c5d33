"""What figures are drawn from: files, tables, arrays, packings, signals."""
from __future__ import annotations

import csv
import dataclasses
import functools
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core import Floats, SonopackError, invalid
from .._network import Network
from .._packing import Packing
from .._records import Material
from .._scene import Scene
from .._signal import Signal
from .._table import Table, material_of
from ._units import PRESSURE, is_ours, number, plain, refuse, same_unit, unit_text

LARGEST = 1e300  # of values in a table: axes around larger ones overflow


class Input:
    """One thing to draw from, read when it is needed: a file, or a Packing, Signal, Table, DataFrame, structured array or
    mapping of columns. label: the reader's own name of it. material: tables are taken in SI, with this material."""

    def __init__(self, source: Any, label: str | None = None, material: Material | None = None) -> None:
        self.source, self.own_label, self.material = source, label, material
        self.path = os.fspath(source) if isinstance(source, (str, os.PathLike)) else ""
        self.name = self.path

    @functools.cached_property
    def is_packing(self) -> bool:
        """Whether it is a packing. A binary file is taken for one."""
        return _looks_like_packing(self.path) if self.path else isinstance(self.source, Packing)

    @functools.cached_property
    def packing(self) -> Packing:
        if self.path:
            return Packing.read(self.path)
        if not isinstance(self.source, Packing):
            raise invalid("", f"{type(self.source).__name__}: must be a Packing or the name of its file")
        return self.source

    @functools.cached_property
    def raw_table(self) -> Table:
        """The table in the units that it has."""
        if self.is_packing:
            raise refuse(self.name, "is a packing, must be a table")
        return _table_of(self.source)

    @functools.cached_property
    def table(self) -> Table:
        """The table, in SI where that is asked for."""
        table = self.raw_table
        for name in (name for name in table.names if table[name].dtype.kind == "f"):
            huge = np.isfinite(table[name]) & (np.abs(table[name]) > LARGEST)
            self.check(name, table[name], huge, f"within {LARGEST:g}")
        known = self.material is None or any(map(is_ours, table.units.values()))
        if not known and not any(table.units.values()) and not table.metadata:
            raise refuse(self.name, "names no units, so nothing can be converted to SI: must be a table with the line "
                                    "# units:")
        return table.si(self.material) if known and self.material is not None else table

    def own_material(self) -> Material | None:
        """The material that the packing or the table says, None without one."""
        if self.is_packing:
            material = self.packing.material
            return material if material.young > 0 else None
        text = self.raw_table.metadata.get("material")
        return material_of(text) if text else None

    def column(self, name: str, hint: str = "") -> Floats:
        """A column of numbers."""
        values = self.optional(name)
        if values is None:
            raise refuse(self.name, f"the table has no column {name}" + (f"; {hint}" if hint else ""))
        return values

    def optional(self, name: str) -> Floats | None:
        """A column of numbers, None without one."""
        if name not in self.table:
            return None
        values = self.table[name]
        if values.dtype.kind not in "fiu":
            raise refuse(self.name, f"column {name} holds text: must be numbers, nan where there is none")
        return values.astype(float)

    def errors(self, name: str) -> Floats | None:
        """The standard errors of a column, None without them."""
        return self.not_negative(f"{name}_err")

    def not_negative(self, name: str) -> Floats | None:
        """A column of numbers of 0 or more, None without one."""
        values = self.optional(name)
        if values is not None:
            self.check(name, values, values < 0, "a number >= 0, or nan")
        return values

    def check(self, name: str, values: Floats, wrong: npt.NDArray[np.bool_], must: str) -> None:
        """Refuses the first row of a column that is wrong."""
        for row in np.flatnonzero(wrong)[:1]:
            raise refuse(self.name, f"row {row + 1}, {name} = {values[row]:g}: must be {must}")

    def number(self, key: str) -> float:
        """A number of the comments, nan without it."""
        try:
            return self.table.number(key)
        except KeyError:
            return float("nan")

    def stem(self) -> str:
        """The name of the file without folder and ending."""
        return os.path.splitext(os.path.basename(self.path))[0]


def inputs(data: Iterable[Any], labels: Sequence[str] | None = None, material: Material | None = None) -> list[Input]:
    """The Inputs of a function's arguments. A list among them counts as its elements."""
    found: list[Input] = []
    for each in data:
        several = each if isinstance(each, (list, tuple)) else [each]
        found += [one if isinstance(one, Input) else Input(one, None, material) for one in several]
    if not found:
        raise invalid("", "nothing to draw: no data")
    if labels is not None and len(labels) != len(found):
        raise invalid("", f"labels: {len(labels)} for {len(found)} data, must be one for each")
    for one, text in zip(found, labels or ()):
        one.own_label = text
    return found


def common_unit(data: Sequence[Input], column: str, own: str = "") -> str:
    """The unit of a column in all tables that have it; `own` without any."""
    first, unit = 0, ""
    for j, one in enumerate(data):
        other = one.table.units.get(column, "")
        if unit and other and not same_unit(unit, other):
            raise refuse(one.name, f"table {first + 1} has {column} in {unit}, table {j + 1} in {other}: must be the same "
                                   f"unit")
        if other and not unit:
            first, unit = j, other
    return unit or own


def common_dimension(data: Sequence[Input]) -> int:
    """The dimension that all tables say, 0 without one."""
    found = {next((value for value in (one.number("dimension"), one.number("packing.dimension")) if value == value), 0)
             for one in data}
    return int(found.pop()) if len(found) == 1 and found <= {1, 2, 3} else 0


# ---- names in legends -----------------------------------------------------------------------------------------------

_SYMBOLS = {"pressure": ("$p$", r" $E^*$"), "friction": (r"$\mu$", ""), "grains": ("$N$", ""), "width": ("width", " $d$")}


def names(data: Sequence[Input]) -> list[str]:
    """What tells the data apart: the reader's labels, else the settings that differ, such as mu = 0.2, else the names of
    the files. "" for a single one without a label."""
    if len(data) == 1:
        return [plain(data[0].own_label or "")]
    settings = [{} if one.own_label is not None or one.is_packing else _settings(one.table) for one in data]
    keys = [key for key in settings[0] if all(key in other for other in settings)
            and len({other[key] for other in settings}) > 1]
    for told in ([", ".join(_setting_text(key, other[key]) for key in keys) for other in settings],
                 [plain(one.stem()) for one in data], [plain(one.path) for one in data]):
        if len(set(told)) == len(told):
            break
    return [plain(one.own_label) if one.own_label is not None else text for one, text in zip(data, told)]


def _settings(table: Table) -> dict[str, str]:
    """The keys of the scene in the comments, without their groups: of "packing.friction = 0.2", and of the lists
    "pressure = ..., friction = ..." and "dimension = ..., friction = ..."."""
    found: dict[str, str] = {}
    for comment in table.comments:
        pairs = re.findall(r"([a-z][a-z0-9_.]*) = ([^,]*)", comment)
        listed = pairs and (pairs[0][0] == "pressure" or (pairs[0][0] == "dimension" and len(pairs) > 1))
        for key, value in pairs:
            if listed or "." in key:
                found.setdefault(key.rpartition(".")[2], value.strip())
    return found


def _setting_text(key: str, value: str) -> str:
    symbol, unit = _SYMBOLS.get(key, (plain(key), ""))
    if re.fullmatch(r"[0-9+\-.eE]+", value):
        return f"{symbol} = {number(float(value), 9)}{unit}"
    return f"{symbol} = {plain(value)}"


# ---- groups of rows -------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Group:
    """Successive rows of a table that belong together. columns: the arrays of these rows; keys: the settings that all of
    them have; text: what tells the group apart."""

    source: Input
    columns: dict[str, Floats]
    keys: dict[str, float]
    file: str = ""
    text: str = ""


def groups_of(given: Sequence[Input], read: Callable[[Input], tuple[dict[str, Floats], list[str]]], x: str,
              forms: Mapping[str, str], by_file: bool = False) -> list[Group]:
    """The groups of all tables. read: gives the columns of a table, and the keys that it has; x: the column that rises in
    a group; forms: keys, and how a legend has them, with a number and a unit; by_file: as the column `file` says."""
    groups = [group for one in given for group in _split(one, *read(one), x, by_file)]
    if not groups:
        raise refuse(given[0].name, "nothing to draw: the table has no row")
    unit = " " + unit_text(common_unit(given, "p", PRESSURE))
    differing = [name for name in forms if len({group.keys.get(name) for group in groups}) > 1]
    for group in groups:
        told = [forms[name].format(number(group.keys[name], 9 if name == "grains" else 3), unit) for name in differing
                if name in group.keys]
        others = sum(other.source is group.source for other in groups) > 1
        group.text = ", ".join(filter(None, (plain(group.source.own_label or ""), group.file if others else "", *told)))
    texts = [group.text for group in groups]
    for group in groups:
        if len(given) > 1 and texts.count(group.text) > 1 and group.source.own_label is None:
            group.text = ", ".join(filter(None, (plain(group.source.stem()), group.text)))
    texts = [group.text for group in groups]
    for group in groups:
        if texts.count(group.text) > 1 and not by_file:
            group.text = ", ".join(filter(None, (group.file, group.text)))
    return groups


def _split(one: Input, columns: dict[str, Floats], names: Sequence[str], x: str, by_file: bool) -> list[Group]:
    """Rows of one group follow each other, with rising x and the same keys (higher packings have more grains); signals of
    one file belong together, and so do files with one signal each."""
    keys = {name: one.column(name) for name in names if name in one.table and one.table[name].dtype.kind in "fiu"}
    named = one.table["file"].astype(str) if "file" in one.table else None
    files = [re.fullmatch(r"(.*?)(:F\d+)?", name, re.S).groups()  # type: ignore[union-attr]
             for name in named] if by_file and named is not None else []

    def begins(row: int) -> bool:
        if files:
            (name, signal), (last, before) = files[row], files[row - 1]
            return not (name == last and before) if signal else before is not None
        same = all(column[row] == column[row - 1] or np.isnan(column[row]) and np.isnan(column[row - 1])
                   for name, column in keys.items() if name != "grains")
        return not same or bool(columns[x][row] <= columns[x][row - 1])

    starts = [row for row in range(one.table.rows) if row == 0 or begins(row)]
    found = []
    for rows in map(slice, starts, [*starts[1:], one.table.rows]):
        common = {name: column[rows][0] for name, column in keys.items() if len(set(column[rows].tolist())) == 1}
        group = Group(one, {name: each[rows] for name, each in columns.items()}, common)
        if files:
            alone = files[rows.start][1] or rows.stop - rows.start == 1
            group.file = plain(_stem(files[rows.start][0])) if alone else "single signals"
        elif named is not None and len(set(named[rows])) == 1:
            group.file = plain(_stem(named[rows][0]))
        found.append(group)
    return found


def _stem(path: str) -> str:
    return os.path.splitext(os.path.basename(path))[0]


# ---- reading --------------------------------------------------------------------------------------------------------

def _looks_like_packing(path: str) -> bool:
    if os.path.exists(path) and not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        head = file.read(8192)
    return b"\0" in head or re.match(rb"(\s*#[^\n]*\n)*\s*N\s+\d+\s", head) is not None


def _table_of(source: Any) -> Table:
    if isinstance(source, (str, os.PathLike)):
        path = os.fspath(source)
        return _read_csv(path) if path.lower().endswith(".csv") else Table.read(path)
    if isinstance(source, Table):
        return source
    if isinstance(source, Signal) or callable(getattr(source, "table", None)):
        made: Table = source.table()
        return made
    if isinstance(source, np.ndarray) and source.dtype.names:
        return Table.from_columns({name: source[name] for name in source.dtype.names})
    if isinstance(source, Mapping) or hasattr(source, "columns"):  # a DataFrame, whose attrs are its comments
        units = getattr(source, "attrs", {}).get("units", {})
        return Table.from_columns({str(name): _plain_array(source[name]) for name in source}, units,
                                  {key: value for key, value in getattr(source, "attrs", {}).items() if key != "units"})
    raise invalid("", f"{type(source).__name__}: must be a table, a packing, a signal, or the name of a file")


def _plain_array(values: Any) -> npt.NDArray[Any]:
    array = np.asarray(values)
    return array.astype(str) if array.dtype.kind == "O" else array


def _read_csv(path: str) -> Table:
    """Comments after '#', a header, and rows of numbers. An empty cell is nan."""
    with open(path, newline="", encoding="utf-8-sig", errors="surrogateescape") as file:
        lines = list(file)
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    kept = [(k + 1, line) for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    rows = list(csv.reader(line for _, line in kept))
    if not rows:
        raise refuse(path, "is no table: it has no header")
    header, columns = rows[0], [[] for _ in rows[0]]  # type: tuple[list[str], list[list[float]]]
    for (line, _), row in zip(kept[1:], rows[1:]):
        if len(row) != len(header):
            raise refuse(f"{path}:{line}", f"{len(row)} cells where there are {len(header)} columns")
        for name, cell, column in zip(header, row, columns):
            column.append(_number(cell, f"{path}:{line}: {name}"))
    pairs = (comment.partition(" = ") for comment in comments)
    return Table.from_columns({name: np.array(column) for name, column in zip(header, columns)}, None,
                              {key: value for key, equals, value in pairs if equals})


def _number(cell: str, place: str) -> float:
    try:
        return float(cell) if cell.strip() else float("nan")
    except ValueError:
        raise refuse("", f'{place} = "{cell:.40}": must be a number or empty') from None


def network_of(packing: Packing, scene: Scene | None = None) -> Network:
    """The network of a packing, with the keys of the group network of a scene."""
    return packing.network(**(scene.options("network") if scene else {}))
