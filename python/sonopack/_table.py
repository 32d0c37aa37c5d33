"""Tables: what every command prints, as numpy arrays."""
from __future__ import annotations

import dataclasses
import os
import tempfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Path, c_path, call, figure_of_kind, taken_text, text_of
from ._native import ffi, lib
from ._records import Material

_FORMATS = {".tsv": lib.SP_TSV, ".csv": lib.SP_CSV, ".json": lib.SP_JSON}


class Table(Mapping[str, npt.NDArray[Any]]):
    """A table with named columns: table["t10"] is an array of numbers (a view), of integers, or of texts.

    units: {column: unit}. comments: the lines behind '#'. metadata: {key: text} of the comments "key = value".
    """

    def __init__(self, struct: Any) -> None:
        self._c = struct

    @classmethod
    def read(cls, path: Path) -> Table:
        """Reads a TSV file of the command, or columns of numbers without a header (named c1, c2, ...)."""
        table = _empty()
        call(lib.sp_table_read, c_path(path), table)
        return cls(table)

    @classmethod
    def from_columns(cls, columns: Mapping[str, npt.ArrayLike], units: Mapping[str, str] | None = None,
                     metadata: Mapping[str, Any] | None = None) -> Table:
        """A table of arrays of one length, which are copied. Texts make a column of texts, integers one of integers."""
        table = _empty()
        arrays = {name: np.asarray(values) for name, values in columns.items()}
        lengths = {array.shape for array in arrays.values()}
        if len(lengths) != 1 or len(next(iter(lengths))) != 1:
            raise _core.invalid("columns", f"have the shapes {sorted(lengths)}: must be arrays of one length")
        kinds = [_kind(array) for array in arrays.values()]
        for name, kind in zip(arrays, kinds):
            call(lib.sp_table_add_column, table, name.encode(), (units or {}).get(name, "").encode(), kind)
        for key, value in (metadata or {}).items():
            text = repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)
            call(lib.sp_table_set_text, table, key.encode(), text.encode())
        for row in zip(*(array.tolist() for array in arrays.values())):
            _add_row(table, kinds, row)
        return cls(table)

    # ---- columns ----------------------------------------------------------------------------------------------------

    @property
    def names(self) -> list[str]:
        """Names of the columns, in their order."""
        return [text_of(self._c.column[k].name) for k in range(self._c.columns)]

    @property
    def units(self) -> dict[str, str]:
        """{column: unit}, "" for pure numbers and texts."""
        return {text_of(self._c.column[k].name): text_of(self._c.column[k].unit) for k in range(self._c.columns)}

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self._c.rows)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        column = int(lib.sp_table_find_column(self._c, name.encode()))
        if column < 0:
            raise KeyError(name)
        kind = self._c.column[column].kind
        if kind == lib.SP_COLUMN_TEXT:
            texts = (self._c.cells[row * self._c.columns + column].text for row in range(self.rows))
            return np.array([text_of(text) for text in texts], dtype=str)
        cells = _core.view(self._c, ffi.cast("double *", self._c.cells), (self.rows, int(self._c.columns)))
        if kind == lib.SP_COLUMN_INTEGER:
            cells = cells.view(np.int64)
        array: npt.NDArray[Any] = cells[:, column]
        return array

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return int(self._c.columns)

    def array(self) -> npt.NDArray[Any]:
        """All columns as one structured array, a copy."""
        columns = [self[name] for name in self.names]
        out = np.empty(self.rows, [(name, column.dtype) for name, column in zip(self.names, columns)])
        for name, column in zip(self.names, columns):
            out[name] = column
        return out

    # ---- comments ---------------------------------------------------------------------------------------------------

    @property
    def comments(self) -> list[str]:
        """The lines behind '#', without it."""
        return [text_of(self._c.comment[k]) for k in range(self._c.comments)]

    @property
    def metadata(self) -> dict[str, str]:
        """{key: text} of the comments "key = value"."""
        return {text_of(self._c.value[k].key): text_of(self._c.value[k].text) for k in range(self._c.values)}

    def number(self, key: str) -> float:
        """The number that a value of the metadata begins with: 0.25 of "0.25, error 0.01"."""
        out = ffi.new("double *")
        if not lib.sp_table_get_number(self._c, key.encode(), out):
            raise KeyError(key)
        return float(out[0])

    def si(self, material: Material | None = None) -> Table:
        """This table in SI units, as the command prints it with --units si. material: that of the grains; by default
        that of the table's comments."""
        if not any(self.units.values()) and not self.metadata:
            raise _core.invalid("", "a table without units, as in CSV, cannot be converted to SI")
        struct = ffi.new("sp_material *")
        if material is not None:
            _core.set_fields(struct, dataclasses.asdict(material))
        elif "material" in self.metadata:
            call(lib.sp_material_read, self.metadata["material"].encode(), struct)
        with tempfile.TemporaryDirectory(prefix="sonopack-") as folder:
            path = os.path.join(folder, "table.tsv")
            self.save(path)
            copy = Table.read(path)
        call(lib.sp_table_to_si, copy._c, struct)
        return copy

    def add_comment(self, text: str) -> None:
        """Adds a line behind '#'."""
        err = ffi.new("sp_error *")
        _core.check(lib.sp_table_add_comment(self._c, err, b"%s", ffi.new("char[]", os.fsencode(text))), err)

    # ---- text -------------------------------------------------------------------------------------------------------

    def text(self, format: str = "tsv") -> str:
        """The table as tsv, csv or json. Numbers have the digits that read back exactly."""
        if "." + format not in _FORMATS:
            raise _core.invalid("format", f"{format!r}: must be tsv, csv or json")
        return taken_text(lib.sp_table_text(self._c, _FORMATS["." + format]))

    def aligned(self, digits: int = lib.SP_DIGITS_OF_ERRORS) -> str:
        """The table for readers: columns aligned; numbers to two digits of their errors X_err, at most six, or to so many
        digits; -1: all."""
        return taken_text(lib.sp_table_aligned(self._c, digits))

    def save(self, path: Path) -> None:
        """Writes .tsv, .csv or .json, as the ending says. A reader sees the old file or the new one, never a part."""
        ending = os.path.splitext(os.fspath(path))[1]
        if ending not in _FORMATS:
            raise _core.invalid("", f"{os.fspath(path)}: the ending of a table must be .tsv, .csv or .json")
        text = os.fsencode(self.text(ending[1:]))
        call(lib.sp_text_save, c_path(path), text, len(text))

    def plot(self, kind: str, **words: Any) -> Any:
        """Draws a figure of a kind of sonopack.plot, such as "ctof", and returns its Axes."""
        return figure_of_kind(kind)(self, **words)

    def __repr__(self) -> str:
        return f"<Table: {self.rows} rows of {' '.join(self.names)}>"


def quantity(text: str, unit: str, material: Material | None = None) -> float:
    """A number with a unit in another unit: quantity("100 kPa", "E*", packing.material)."""
    out, struct = ffi.new("double *"), ffi.NULL
    if material is not None:
        struct = ffi.new("sp_material *")
        _core.set_fields(struct, dataclasses.asdict(material))
    call(lib.sp_quantity_read, text.encode(), unit.encode(), struct, out)
    return float(out[0])


def material_of(text: str) -> Material:
    """The material of "E=70e9,nu=0.22,rho=2500,d=1e-3", in SI units; values may name others: "E=70 GPa,d=1 mm"."""
    units = {"E": "Pa", "rho": "kg/m^3", "d": "m"}
    plain = []
    for pair in text.split(","):
        key, _, value = pair.partition("=")
        if key.strip() in units and not value.strip(" 0123456789+-.eE") == "":
            value = repr(quantity(value.strip(), units[key.strip()]))
        plain.append(f"{key}={value}")
    struct = ffi.new("sp_material *")
    call(lib.sp_material_read, ",".join(plain).encode(), struct)
    material: Material = _core.record(Material, struct)
    return material


def _empty() -> Any:
    return _core.new("sp_table", lib.sp_table_free, lib.sp_table_none)


def _kind(array: npt.NDArray[Any]) -> int:
    if array.dtype.kind in "US":
        return int(lib.SP_COLUMN_TEXT)
    if array.dtype.kind in "iub":
        return int(lib.SP_COLUMN_INTEGER)
    if array.dtype.kind == "f":
        return int(lib.SP_COLUMN_NUMBER)
    raise _core.invalid("columns", f"of dtype {array.dtype}: must be numbers, integers or texts")


def _add_row(table: Any, kinds: list[int], row: tuple[Any, ...]) -> None:
    err = ffi.new("sp_error *")
    cells = []
    for kind, value in zip(kinds, row):
        if kind == lib.SP_COLUMN_TEXT:
            cells.append(ffi.new("char[]", os.fsencode(value)))
        else:
            cells.append(ffi.cast("double", value) if kind == lib.SP_COLUMN_NUMBER else ffi.cast("int64_t", value))
    _core.check(lib.sp_table_add_row(table, err, *cells), err)
