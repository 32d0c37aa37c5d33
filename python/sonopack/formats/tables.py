"""Tables as MAT-files, signals as SAC and SLIST: what `-o FILE.mat`, FILE.sac and FILE.slist of every command write."""
from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from .. import _command
from .._command import usage
from .._core import Floats, SonopackError
from .._table import Table
from .export import mat_file, number_text

ENDINGS = (".mat", ".sac", ".slist")
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_UNKNOWN = -12345  # in a header of SAC


# ---- MAT ------------------------------------------------------------------------------------------------------------

def mat(table: Table) -> bytes:
    """A variable for each column (text: a cell array), `units` (a struct with a text for each column) and `comments` (a cell
    array), as MATLAB 5."""
    values = {_name(name): _cells(table[name]) if table[name].dtype.kind in "US" else table[name].astype(float)
              for name in table.names}
    values["units"] = {_name(name): unit for name, unit in table.units.items()}
    values["comments"] = _cells(table.comments)
    return mat_file(values, long_field_names=True)


def _name(name: str) -> str:
    """A valid name: letters, digits and underscores, a letter first."""
    return re.sub(r"[^A-Za-z0-9]", "_", name if name[:1].isalpha() else "x" + name)[:63]


def _cells(texts: Any) -> Any:
    cells = np.empty((len(texts), 1 if len(texts) else 0), dtype=object)
    for k, text in enumerate(texts):
        cells[k, 0] = str(text)
    return cells


# ---- signals --------------------------------------------------------------------------------------------------------

class _Trace:
    """One column of a table of signals, with the texts that seismologists' files have."""

    def __init__(self, table: Table, name: str) -> None:
        unit = table.units["t"]
        scale, t = _SECONDS.get(unit, 1.0), table["t"]
        self.time_unit = "s" if unit in _SECONDS else "tau"
        self.step, self.begin = scale * (t[-1] - t[0]) / (len(t) - 1), scale * t[0]
        self.value: Floats = table[name].astype(float)
        self.component, self.unit = _word(name, 8), _word(table.units[name] or "1", 8)
        self.event = _word(table.metadata.get("source", "unknown").split(";")[0], 16)
        self.station = _word(_place(table.metadata.get(name, "")), 8)
        self.numbers = [_number(table, "pressure"), _number(table, "height")]

    def check(self, most: float) -> None:
        bad = np.flatnonzero(~(np.abs(self.value) <= most))
        if bad.size:
            raise usage(f"value {bad[0]} is {self.value[bad[0]]:g}; must be a finite number of up to {most:.3g}")

    def sac(self) -> bytes:
        """Version 6, little endian, in single precision."""
        self.check(3.4e38)
        numbers, integers = np.full(70, _UNKNOWN, "<f4"), np.full(40, _UNKNOWN, "<i4")
        names = ["-12345".ljust(8)] * 24
        low, high, mean = self.value.min(), self.value.max(), np.cumsum(self.value)[-1] / len(self.value)
        numbers[[0, 1, 2, 5, 6, 56]] = (self.step, low, high, self.begin,
                                        self.begin + self.step * (len(self.value) - 1), mean)
        numbers[40:42] = [_UNKNOWN if np.isnan(x) else x for x in self.numbers]
        integers[35:] = 0
        # version, points, a time series, of an unknown quantity (SAC knows no forces), even, writable
        integers[[6, 9, 15, 16, 35, 37]] = 6, len(self.value), 1, 5, 1, 1
        names[0], names[1:3] = self.station.ljust(8), [self.event.ljust(16)[:8], self.event.ljust(16)[8:]]
        names[17:21] = [self.unit.ljust(8), self.time_unit.ljust(8), "sonopack", self.component.ljust(8)]
        return numbers.tobytes() + integers.tobytes() + "".join(names).encode() + self.value.astype("<f4").tobytes()

    def slist(self) -> str:
        """Values in six columns; the time is counted from the pulse, which has the date 1970-01-01."""
        self.check(float(np.finfo(float).max))
        if not 0 <= self.begin < 60:
            raise usage(f"the first time is {self.begin:g}; must be 0 .. 60")
        head = (f"TIMESERIES SP_{self.station}__{self.component}_, {len(self.value)} samples, {number_text(1 / self.step)} sps, "
                f"1970-01-01T00:00:{self.begin:09.6f}, SLIST, FLOAT, {self.unit}\n")
        words = [number_text(x) for x in self.value.tolist()]
        return head + "".join("\t".join(words[k:k + 6]) + "\n" for k in range(0, len(words), 6))


def _word(text: str, most: int) -> str:
    return re.sub(r"[\s:_]", "", text)[:most]


def _number(table: Table, key: str) -> float:
    return table.number(key) if key in table.metadata else float("nan")


def _place(how: str) -> str:
    """"from bottom:normal to plane:25:normal, error ..." gives h25: a name has 8 letters."""
    match = re.search(r" to ([^,]*?)(:[^:,]*)?(,|$)", how)
    place = match[1] if match else "top"
    return f"h{float(place[6:]):.5g}" if place.startswith("plane:") else place


def _signals(table: Table) -> list[str]:
    """The columns after the time, which must be at equal intervals."""
    if len(table.names) < 2 or table.names[0] != "t" or table.rows < 2:
        raise usage("only tables of signals, whose first column is t, can be written in this form")
    t = table["t"]
    even = t[0] + (t[-1] - t[0]) * np.arange(len(t)) / (len(t) - 1)
    bad = np.flatnonzero(~(np.abs(t - even) <= 1e-9 * abs(t[-1])))
    if bad.size or not t[-1] > t[0]:
        row = bad[0] if bad.size else len(t) - 1
        raise usage(f"t = {t[row]:g} in row {row + 1}; must be at equal intervals")
    return table.names[1:]


# ---- files ----------------------------------------------------------------------------------------------------------

def files(table: Table, path: str) -> Iterator[tuple[str, bytes]]:
    """The names and contents of the files of a table: one, or for SAC one for each signal (FILE-F1.sac, ...)."""
    stem, dot, ending = path.rpartition(".")
    try:
        if ending.lower() == "mat":
            yield path, mat(table)
            return
        traces = [_Trace(table, name) for name in _signals(table)]
        if ending.lower() == "slist":
            yield path, "".join(trace.slist() for trace in traces).encode()
            return
        for name, trace in zip(table.names[1:], traces):
            yield path if len(traces) == 1 else f"{stem}-{name}{dot}{ending}", trace.sac()
    except SonopackError as fault:
        raise type(fault)(f"{path}: {fault}", fault.status) from None


def parser() -> _command.Parser:
    return _command.Parser("save-table", description="Writes the table on stdin to -o FILE.mat, FILE.sac or FILE.slist.")


def run(arguments: argparse.Namespace) -> None:
    """Writes the files of the table on stdin, if none of them is in the way."""
    found = list(files(Table.read("/dev/stdin"), arguments.output))
    for name, _ in found:
        _command.may_write(arguments, name, ENDINGS)
    for name, data in found:
        with _command.whole_file(name) as draft, open(draft, "wb") as file:
            file.write(data)
