"""Rows of numbers from a text file of another program, quickly: files have up to millions of them."""
from __future__ import annotations

import gzip
import io
import math
import os
import re
import stat
import zlib
from collections.abc import Iterator
from typing import NoReturn

import numpy as np

from .._core import Floats, Integers
from ._faults import bad_file, unreadable

MOST_COLUMNS = 128
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.A)
_COMMENT = re.compile(rb"^[ \t]*#[^\n]*", re.M)
_SAMPLED = 20000  # rows of which digits are counted, where a file has more


def load(path: str, limit: int = -1) -> bytes:
    """The content of a file, unpacked if it is in gzip's form; at most `limit` bytes of it."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe that nobody writes to would keep us waiting
        with os.fdopen(handle, "rb") as file:
            if stat.S_ISDIR(os.fstat(handle).st_mode):
                raise IsADirectoryError(21, "Is a directory")
            os.set_blocking(handle, True)
            head = file.peek(2)[:2]
            data = gzip.open(file).read(limit) if head == b"\x1f\x8b" else file.read(limit)
    except (EOFError, zlib.error, gzip.BadGzipFile) as fault:
        raise bad_file(f"{path}: is damaged or cut, as gzip finds: {fault}") from None
    except OSError as fault:
        raise unreadable(path, fault) from None
    return data


def text_of(path: str) -> bytes:
    """The content of a text file, with LF at its lines' ends and without a byte order mark."""
    data = load(path)
    if b"\0" in data:
        raise bad_file(f"{path}:{data.count(10, 0, data.index(0)) + 1}: a binary file; must be text")
    return data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n")


def number(word: str) -> float:
    """A finite decimal number; NaN for anything else."""
    value = float(word) if _NUMBER.fullmatch(word) else math.nan
    return value if math.isfinite(value) else math.nan


def numbers(line: str, count: int) -> list[float]:
    """Up to `count` numbers that a line begins with; an empty list if one of them is none."""
    found = [number(word) for word in line.split()[:count]]
    return [] if any(map(math.isnan, found)) else found


def shown(line: str, length: int = 60) -> str:
    return f"'{line[:length]}'"


class Cursor:
    """Where a reader is in a text; `at` is the offset of the next line, `line` the number of the last one, from 1."""

    def __init__(self, file: str, text: bytes, at: int = 0, line: int = 0) -> None:
        self.file, self.text, self.at, self.line = file, text, at, line

    def next(self) -> str | None:
        """The next line, or None at the end."""
        if self.at >= len(self.text):
            return None
        stop = self.text.find(b"\n", self.at)
        stop = len(self.text) if stop < 0 else stop
        line = self.text[self.at:stop].decode(errors="replace")
        self.at, self.line = stop + 1, self.line + 1
        return line

    def words(self) -> str | None:
        """The next line that is not blank."""
        line = self.next()
        while line is not None and not line.strip(" \t"):
            line = self.next()
        return line

    def skip(self, lines: int) -> None:
        """Passes over so many lines, or those that there are."""
        if lines > 10000:  # guess by the next one's length, which rows of one program share
            ends = np.flatnonzero(np.frombuffer(self.text, np.uint8, offset=min(self.at, len(self.text))) == 10)
            passed = min(lines, len(ends))
            self.at = self.at + int(ends[passed - 1]) + 1 if passed else len(self.text)
            self.line += passed
            return
        for _ in range(lines):
            if self.next() is None:
                return

    def copy(self) -> Cursor:
        return Cursor(self.file, self.text, self.at, self.line)

    def fail(self, text: str) -> NoReturn:
        raise bad_file(f"{self.file}:{self.line}: {text}")


class Sheet:
    """Rows of numbers with named columns, and what the headers say: the box, periods and tilts, keys, the frame.

    values [rows][columns]: NaN for cells that are no finite numbers; word() is the text of a cell.
    """

    def __init__(self, file: str, names: list[str], separator: str = " ") -> None:
        self.file, self.names, self.separator = file, names, separator
        self.values: Floats = np.empty((0, len(names)))
        self.box = [False] * 3
        self.low, self.high, self.tilt = [0.0] * 3, [0.0] * 3, [0.0] * 3
        self.periodic = [-1] * 3
        self.said: dict[str, str] = {}
        self.frames, self.frame = 1, -1
        self._kept: Integers | None = None
        self._begin = Cursor(file, b"")
        self._end = 0

    @property
    def rows(self) -> int:
        return len(self.values)

    # ---- reading ----------------------------------------------------------------------------------------------------

    def read(self, at: Cursor, count: int | None = None, what: str = "rows") -> Sheet:
        """Reads `count` rows, or all that there are but for comments, from where the cursor is. Moves the cursor on."""
        if len(self.names) > MOST_COLUMNS:
            at.fail(f"more than {MOST_COLUMNS} columns")
        self._begin, self._end = at.copy(), len(at.text)
        region = memoryview(at.text)[at.at:]
        if count is None:
            self.values = self._parse(_COMMENT.sub(b"", bytes(region)) if b"#" in at.text else region, None)
            return self
        self.values = self._parse(region, count)
        if self.rows < count:
            lines = at.text.count(b"\n") + (not at.text.endswith(b"\n"))
            raise bad_file(f"{self.file}:{lines}: the file ends after {self.rows} of {count} {what}; must have all of them")
        if count and not at.text.endswith(b"\n") and self._offset_of_last() == len(at.text):
            raise bad_file(f"{self.file}:{self.line(self.rows - 1)}: the file ends inside of this line; must end with a line "
                           "end")
        return self

    def _offset_of_last(self) -> int:
        """Where the last row ends: the end of the file, unless words follow."""
        tail = self._begin.text[self._begin.text.rfind(b"\n") + 1:].decode(errors="replace")
        last = [number(word) for word in self._cells(tail)]
        same = len(last) == len(self.names) and np.array_equal(np.array(last), self.values[-1], equal_nan=True)
        return len(self._begin.text) if same else 0

    def _parse(self, region: memoryview | bytes, count: int | None) -> Floats:
        """The rows by pandas, if all of their cells are numbers, else one by one."""
        import pandas
        try:
            frame = pandas.read_csv(
                io.BytesIO(region), header=None, names=[*range(len(self.names)), "more"], index_col=False, nrows=count,
                engine="c", float_precision="round_trip", encoding_errors="replace", low_memory=False, quoting=3,
                **{"delim_whitespace": True} if self.separator == " " else {"sep": self.separator})
        except (pandas.errors.ParserError, pandas.errors.EmptyDataError, OverflowError, ValueError):
            return self._parse_rows(count)
        more = frame.pop("more")
        words = [k for k in frame if frame[k].dtype == object]
        for k in words:  # a column of names, such as the species of XYZ
            if frame[k].map(lambda cell: isinstance(cell, str) and math.isnan(number(cell.strip()))).all():
                frame[k] = np.nan
        values = frame.to_numpy(dtype=float) if not any(frame[k].dtype == object for k in frame) else None
        whole = values is not None and bool(more.isna().all()) and np.isfinite(
            values[:, [k for k in range(len(self.names)) if k not in words]]).all()
        if not whole or (words and len(self.names) - 1 in words) or (count is not None and len(frame) < count):
            return self._parse_rows(count)
        return values  # type: ignore[return-value]

    def _parse_rows(self, count: int | None) -> Floats:
        rows: list[list[float]] = []
        for line, cells in self._lines():
            if len(rows) == count:
                break
            if len(cells) != len(self.names):
                commas = self.separator == " " and any("," in cell for cell in cells)
                raise bad_file(f"{self.file}:{line}: {len(cells)} cells; must be {len(self.names)}"
                               f"{', separated by blanks, not commas' if commas else ''}: {self.listed()}")
            rows.append([number(cell) for cell in cells])
        return np.array(rows, dtype=float).reshape(len(rows), len(self.names))

    def _lines(self) -> Iterator[tuple[int, list[str]]]:
        """Number and cells of each row, from the first."""
        at = self._begin.copy()
        while (line := at.words()) is not None:
            if not line.lstrip().startswith("#"):
                yield at.line, self._cells(line)

    def _cells(self, line: str) -> list[str]:
        if self.separator == " ":
            return line.split()
        cells = line.split(self.separator)
        return [cell.strip(" \t") for cell in (cells[:-1] if cells[-1] == "" else cells)]

    # ---- access -----------------------------------------------------------------------------------------------------

    def keep(self, rows: Integers) -> None:
        """Leaves all rows but these out."""
        self._kept = rows
        self.values = self.values[rows]

    def column(self, name: str) -> int:
        """The index of a column; -1: there is none."""
        return self.names.index(name) if name in self.names else -1

    def _row(self, row: int) -> tuple[int, list[str]]:
        wanted = row if self._kept is None else int(self._kept[row])
        for k, found in enumerate(self._lines()):
            if k == wanted:
                return found
        raise IndexError(row)

    def line(self, row: int) -> int:
        """The number of the line of a row."""
        return self._row(row)[0]

    def word(self, row: int, column: int) -> str:
        """The text of a cell, without quotes."""
        word = self._row(row)[1][column]
        return word[1:-1] if len(word) > 1 and word[0] == word[-1] == '"' else word

    def words(self, column: int) -> list[str]:
        """The texts of a column."""
        values = self.values[:, column]
        if np.all(values == np.trunc(values)):
            return [f"{value:.0f}" for value in values]
        texts = [cells[column].strip('"') for _, cells in self._lines()]
        return texts[:self.rows] if self._kept is None else [texts[k] for k in self._kept]

    def fail(self, row: int, column: int, rule: str) -> NoReturn:
        """Refuses a cell."""
        raise bad_file(f"{self.file}:{self.line(row)}: column {self.names[column]} is '{self.word(row, column)}'; must be "
                       f"{rule}")

    def finite(self, column: int, rows: Integers | None = None) -> Floats:
        """The numbers of a column, in these rows; the first that is not finite is refused."""
        values: Floats = self.values[:, column] if rows is None else self.values[rows, column]
        bad = np.flatnonzero(np.isnan(values))
        if len(bad):
            self.fail(int(bad[0]) if rows is None else int(rows[bad[0]]), column, "a finite number")
        return values

    def whole(self, column: int, rows: Integers | None = None) -> Integers:
        """The same of whole numbers."""
        values = self.values[:, column] if rows is None else self.values[rows, column]
        bad = np.flatnonzero(~((np.abs(values) < 9e15) & (values == np.trunc(values))))
        if len(bad):
            self.fail(int(bad[0]) if rows is None else int(rows[bad[0]]), column, "a whole number")
        return values.astype(np.int64)

    def listed(self) -> str:
        """The names of all columns, for messages."""
        text = "".join(f"{name} " for name in self.names)
        return text if len(text) < 495 else text[:490] + "..."

    def digits(self, columns: list[int]) -> list[int]:
        """The most significant digits that a cell of each column has, of 20000 rows where there are more."""
        most = [0] * len(columns)
        for cells in self._sample():
            for at, column in enumerate(columns):
                if column < len(cells):
                    mantissa = re.split("[eE]", cells[column].lstrip("+-"), 1)[0]
                    most[at] = max(most[at], len(mantissa.replace(".", "").lstrip("0")))
        return most

    def _sample(self) -> Iterator[list[str]]:
        if self.rows <= _SAMPLED:
            for k, (_, cells) in enumerate(self._lines()):
                if k >= (self.rows if self._kept is None else int(self._kept[-1]) + 1):
                    return
                yield cells
            return
        text, begin = self._begin.text, self._begin.at
        for k in range(_SAMPLED):
            start = text.find(b"\n", begin + (len(text) - begin) * k // _SAMPLED) + 1
            cells = self._cells(text[start:text.find(b"\n", start)].decode(errors="replace"))
            if len(cells) == len(self.names):
                yield cells


def place_of(digits: int, largest: float) -> float:
    """The spacing of numbers of so many digits and absolute values up to `largest`."""
    return math.pow(10, math.floor(math.log10(largest)) + 1 - min(digits, 17)) if largest > 0 else 0.0
