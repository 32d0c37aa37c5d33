"""Rows of numbers from a text file of another program, quickly: files have up to millions of them."""
from __future__ import annotations

import dataclasses
import gzip
import io
import math
import os
import re
import stat
import warnings
import zlib
from collections.abc import Iterable, Iterator
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from .._core import Floats, Integers
from ._faults import bad_file, bad_option, unreadable

Mask = npt.NDArray[np.bool_]

_MOST_COLUMNS = 128
_LARGEST = 1e100  # of positions and forces in any unit: powers of larger ones overflow
_GZIP = b"\x1f\x8b"
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
            return gzip.open(file).read(limit) if file.peek(2)[:2] == _GZIP else file.read(limit)
    except (EOFError, zlib.error, gzip.BadGzipFile) as fault:
        raise bad_file(f"{path}: is damaged or cut, as gzip finds: {fault}") from None
    except OSError as fault:
        raise unreadable(path, fault) from None


def is_packed(path: str) -> bool:
    """Whether a file is in gzip's form."""
    with open(path, "rb") as file:
        return file.read(2) == _GZIP


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
    """The beginning of a line in quotes."""
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
        if lines > 10000:
            ends = np.flatnonzero(np.frombuffer(self.text, np.uint8, offset=min(self.at, len(self.text))) == 10)
            passed = min(lines, len(ends))
            self.at = self.at + int(ends[passed - 1]) + 1 if passed else len(self.text)
            self.line += passed
        else:
            while lines > 0 and self.next() is not None:
                lines -= 1

    def copy(self) -> Cursor:
        """A second cursor at this place."""
        return Cursor(self.file, self.text, self.at, self.line)

    def fail(self, text: str) -> NoReturn:
        """Refuses the last line."""
        raise bad_file(f"{self.file}:{self.line}: {text}")


@dataclasses.dataclass
class Frame:
    """One of the frames of a file: its number, how many rows it has, where they begin, and what its header says."""

    number: int
    rows: int
    at: Cursor
    head: Any


class Sheet:
    """Rows of numbers with named columns, and what the headers say: the box, periods and tilts, keys, the frames.

    values [rows][columns]: NaN for cells that are no finite numbers; words() are the texts of a column.
    """

    def __init__(self, file: str, names: list[str], separator: str = " ") -> None:
        self.file, self.names, self.separator = file, names, separator
        self.values: Floats = np.empty((0, len(names)))
        self.box, self.low, self.high, self.tilt = [False] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3
        self.periodic = [-1] * 3  # 1: yes, 0: no, -1: the file does not say
        self.said: dict[str, str] = {}
        self.frames: list[int] = []
        self.frame = -1
        self._kept: Integers | None = None
        self._texts: dict[int, list[str]] = {}
        self._begin = Cursor(file, b"")

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(self.values)

    # ---- reading ----------------------------------------------------------------------------------------------------

    def pick(self, found: Iterable[Frame], wanted: int | None) -> Frame:
        """The frame of this number, or the last."""
        chosen = None
        for one in found:
            self.frames.append(one.number)
            if wanted is None or wanted == one.number:
                chosen = one
        if not self.frames:
            raise bad_file(f"{self.file}: no frame")
        if chosen is None:
            raise bad_option(f"{self.file}: no frame {wanted}; it has {len(self.frames)}, {self.frames[0]} .. "
                             f"{self.frames[-1]}")
        self.frame = chosen.number
        return chosen

    def read(self, at: Cursor, count: int | None = None) -> Sheet:
        """Reads `count` rows, or all that there are but for comments, from where the cursor is."""
        if len(self.names) > _MOST_COLUMNS:
            at.fail(f"more than {_MOST_COLUMNS} columns")
        self._begin = at.copy()
        values = self._parse(count)
        self.values = self._parse_rows(count) if values is None else values
        if count is None:
            return self
        if self.rows < count:
            lines = at.text.count(b"\n") + (not at.text.endswith(b"\n"))
            raise bad_file(f"{self.file}:{lines}: the file ends after {self.rows} of {count} rows; must have all of "
                           "them")
        if not at.text.endswith(b"\n") and at.text.count(b"\n", at.at) == count - 1:
            raise bad_file(f"{self.file}:{self.line(count - 1)}: the file ends inside of this line; must end with a "
                           "line end")
        return self

    def _parse(self, count: int | None) -> Floats | None:
        """The rows by pandas, if all of their cells are numbers or words in columns of words."""
        import pandas
        region: bytes | memoryview = memoryview(self._begin.text)[self._begin.at:]
        if count is None and b"#" in self._begin.text:
            region = _COMMENT.sub(b"", region)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # cells that are too many are found in "more"
                frame = pandas.read_csv(
                    io.BytesIO(region), header=None, names=[*range(len(self.names)), "more"], index_col=False,
                    nrows=count, engine="c", float_precision="round_trip", encoding_errors="replace", low_memory=False,
                    quoting=3, sep=r"\s+" if self.separator == " " else self.separator)
        except (pandas.errors.ParserError, pandas.errors.EmptyDataError, OverflowError, ValueError):
            return None
        whole = bool(frame.pop("more").isna().all()) and (count is None or len(frame) == count)
        words = [k for k in frame if frame[k].dtype == object]  # such as the species of XYZ, or walls among ids
        if not whole or len(self.names) - 1 in words or frame[words].isna().to_numpy().any():
            return None
        self._texts = {k: frame[k].tolist() for k in words}
        for k in words:
            frame[k] = [number(cell.strip()) for cell in self._texts[k]]
        values = frame.to_numpy(dtype=float)
        return values if np.isfinite(np.delete(values, words, axis=1) if words else values).all() else None

    def _parse_rows(self, count: int | None) -> Floats:
        """The rows one by one: finds the first that is wrong."""
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
                yield at.line, self.cells(line)

    def cells(self, line: str) -> list[str]:
        """The cells of a line."""
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
        return next(found for k, found in enumerate(self._lines()) if k == wanted)

    def line(self, row: int) -> int:
        """The number of the line of a row."""
        return self._row(row)[0]

    def words(self, column: int) -> list[str]:
        """The texts of a column."""
        values = self.values[:, column]
        if np.all(values == np.trunc(values)):
            return [f"{value:.0f}" for value in values]
        found = self._texts.get(column) or [cells[column] for _, cells in self._lines()]
        texts = [text.strip(' \t"') for text in found]
        return texts[:self.rows] if self._kept is None else [texts[k] for k in self._kept]

    def refuse(self, bad: Mask, column: int, rule: str, rows: Integers | None = None) -> None:
        """Refuses the first cell that is bad, if any; rows: those that `bad` is about."""
        at = np.flatnonzero(bad)
        if len(at):
            line, cells = self._row(int(at[0] if rows is None else rows[at[0]]))
            word = re.sub('^"(.*)"$', r"\1", cells[column])
            raise bad_file(f"{self.file}:{line}: column {self.names[column]} is '{word}'; must be {rule}")

    def finite(self, column: int, rows: Integers | None = None) -> Floats:
        """The numbers of a column, in these rows; the first that is not finite is refused."""
        values: Floats = self.values[:, column] if rows is None else self.values[rows, column]
        self.refuse(np.isnan(values), column, "a finite number", rows)
        self.refuse(np.abs(values) > _LARGEST, column, f"within {_LARGEST:g}", rows)
        return values

    def whole(self, column: int, rows: Integers | None = None) -> Integers:
        """The same of whole numbers."""
        values: Floats = self.values[:, column] if rows is None else self.values[rows, column]
        self.refuse(~((np.abs(values) < 9e15) & (values == np.trunc(values))), column, "a whole number", rows)
        return values.astype(np.int64)

    def fail(self, row: int, text: str) -> NoReturn:
        """Refuses a row."""
        raise bad_file(f"{self.file}:{self.line(row)}: {text}")

    def listed(self) -> str:
        """The names of all columns, for messages."""
        text = "".join(f"{name} " for name in self.names)
        return text if len(text) < 495 else text[:490] + "..."

    def digits(self, columns: list[int]) -> int:
        """The most significant digits that a cell of these columns has, of 20000 rows where there are more."""
        most = 0
        for cells in self._sample():
            for cell in (cells[column] for column in columns if column < len(cells)):
                most = max(most, len(re.split("[eE]", cell.lstrip("+-"), maxsplit=1)[0].replace(".", "").lstrip("0")))
        return most

    def _sample(self) -> Iterator[list[str]]:
        if self.rows <= _SAMPLED:
            last = self.rows if self._kept is None else int(self._kept[-1]) + 1
            yield from (cells for _, (_, cells) in zip(range(last), self._lines()))
            return
        text, begin = self._begin.text, self._begin.at
        for k in range(_SAMPLED):
            start = text.find(b"\n", begin + (len(text) - begin) * k // _SAMPLED) + 1
            cells = self.cells(text[start:text.find(b"\n", start)].decode(errors="replace"))
            if len(cells) == len(self.names):
                yield cells
