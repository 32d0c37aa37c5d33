"""Traces from files of oscilloscopes and recorders: text with any delimiter and decimals, WAV, SAC, miniSEED, our tables."""
from __future__ import annotations

import dataclasses
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._command import Failed
from .._core import Floats
from .._table import Table

MICROSECONDS = {"s": 1e6, "ms": 1e3, "us": 1.0, "ns": 1e-3}
OWN_TIME = "d/sqrt(E* / rho)"
_VOLTS = {"mV": ("V", 1e-3), "uV": ("V", 1e-6)}
KINDS = ("text", "wav", "sac", "miniseed", "table")
LEAST = 32  # samples of a trace
_SAC_VERSIONS = (b"\6\0\0\0", b"\0\0\0\6")  # at byte 304, in either order
_SAC_TEXT = rb"([ 0-9.+Ee-]{60,80}\r?\n){14}([ 0-9-]{46,60}\r?\n){8}"
_HEAD = 400  # lines in which the form of a text shows
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|infinity|∞)", re.I)
_UNITS = {"second": "s", "seconds": "s", "sec": "s", "volt": "V", "volts": "V", "amp": "A", "µs": "us", "μs": "us",
          **{unit: unit for unit in ("s", "ms", "us", "ns", "V", "mV", "uV", "A", "N", "Pa", "g")}}

_INFINIIUM = {"xinc": "increment", "xorg": "start", "xunits": "horizontal units"}


@dataclasses.dataclass
class Trace:
    """A channel at equal intervals: times and values, their units ("us", or our own), the distance from the pulse (nan: not
    known), and what is doubtful about it."""

    file: str
    channel: str
    t: Floats
    f: Floats
    t_unit: str = "us"
    f_unit: str = ""
    distance: float = math.nan
    notes: list[str] = dataclasses.field(default_factory=list)

    @property
    def name(self) -> str:
        return f"{self.file}:{self.channel}"

    @property
    def step(self) -> float:
        return float(self.t[1] - self.t[0])


@dataclasses.dataclass
class Form:
    """What the user says of files: their kind ("": found out); of text files the unit of times, the interval of samples in it,
    columns by name or number (values: a minus turns the sign)."""

    time_unit: str = ""
    step: float = 0.0
    time: str = ""
    values: Sequence[str] = ()
    kind: str = ""


def read(path: str, form: Form = Form()) -> list[Trace]:
    """The traces of a file, one a channel. Times of instruments are in us."""
    data = pathlib.Path(path).read_bytes()
    kind = form.kind or _kind(path, data)
    if kind == "text":
        found = _text(path, _decoded(data), form)
    elif kind == "sac":
        found = [_sac(path, data) if data[304:308] in _SAC_VERSIONS else _sac_text(path, _decoded(data))]
    else:
        found = {"wav": _wav, "miniseed": _miniseed, "table": _own}[kind](path)
    return [_check(trace) for trace in found]


def _decoded(data: bytes) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # the micro sign of Windows


def _kind(path: str, data: bytes) -> str:
    """One of KINDS, by the content."""
    if data[:4] in (b"RIFF", b"RIFX"):
        return "wav"
    if data[304:308] in _SAC_VERSIONS or re.match(_SAC_TEXT, data):
        return "sac"
    if re.match(rb"\d{6}[DRQM][ \0]", data):
        return "miniseed"
    if b"\0" in data[:4096]:
        raise Failed(f"{path}: is a binary file, must be WAV, SAC, miniSEED, or text" + (
            ": `sonopack signal` computes the trace of a packing" if data.startswith(b"\x89HDF") else ""))
    return "table" if re.search(rb"^# units:", data, re.M) else "text"


def _check(trace: Trace) -> Trace:
    """Cuts missing values off the ends, tells clipped ones, and refuses what no trace can be."""
    size = np.abs(trace.f[np.isfinite(trace.f)]).max(initial=0)
    if not np.all(np.isfinite(trace.t)) or not trace.step > 0 or not 1e-100 < size < 1e100:
        raise Failed(f"{trace.name}: largest value {size:g}, interval {trace.step:g}: must be numbers, values within 1e-100 and 1e100")
    known = np.flatnonzero(~np.isnan(trace.f))
    if not len(known) or len(known) <= known[-1] - known[0]:
        missing = int(np.sum(np.isnan(trace.f)))
        raise Failed(f"{trace.name}: {missing} of {len(trace.f)} values are missing, must be only at the ends")
    if len(known) < len(trace.f):
        trace.notes.append(f"{len(trace.f) - len(known)} missing values at the ends are left out")
        trace.t, trace.f = trace.t[known], trace.f[known]
    beyond = np.isinf(trace.f)
    if len(known) < LEAST or np.all(beyond) or not np.ptp(trace.f[~beyond]) > 0:
        raise Failed(f"{trace.name}: {len(known)} values, must be {LEAST} or more that are not all equal")
    trace.f = np.clip(trace.f, trace.f[~beyond].min(), trace.f[~beyond].max())
    clipped = max(np.sum(beyond), _clipped(trace.f), _clipped(-trace.f))
    if clipped:
        trace.notes.append(f"clipped: {clipped} values stand at a limit of the range; peak and amplitude are not those of the "
                           "signal")
    return trace


def _clipped(f: Floats) -> int:
    """How many successive values equal the largest, if the trace comes there by a jump of more than the resolution. A
    recorder of few bits has flat tops too, but reaches them by single steps."""
    top = np.flatnonzero(f == f.max())
    run = max(np.split(top, np.flatnonzero(np.diff(top) > 1) + 1), key=len)
    steps = np.abs(np.diff(np.unique(f)))
    jump = min(f[run[0]] - f[run[0] - 1], f[run[0]] - f[run[-1] + 1]) if 0 < run[0] and run[-1] + 1 < len(f) else 0.0
    high = f.max() - np.median(f) > 0.5 * np.abs(f - np.median(f)).max()
    return len(run) if len(run) >= 4 and high and jump > 1.5 * steps.min() else 0


def even(t: Floats, name: str) -> tuple[Floats, str]:
    """Times at equal intervals in place of times that are rounded, and a note if these are far from them."""
    n = len(t)
    if n < LEAST or not np.all(np.abs(t) < 1e100):
        raise Failed(f"{name}: {n} times, must be {LEAST} numbers or more")
    fit = np.polyfit(np.arange(n), t, 1)[::-1]
    if not fit[1] > 0:
        raise Failed(f"{name}: times must rise")
    grid = fit[0] + fit[1] * np.arange(n)
    off = np.abs(t - grid) / fit[1]
    if off.max() > 0.6:
        row = int(np.argmax(off))
        raise Failed(f"{name}: sample {row + 1} is {off[row]:.2g} intervals away from equal intervals of {fit[1]:.6g}; must be "
                     "samples at equal intervals")
    return grid, f"times are rounded by up to {off.max():.2g} of an interval: equal intervals are used" if off.max() > 0.02 else ""


# ---- text -----------------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class _Layout:
    delimiter: str
    decimal: str
    start: int        # line of the first numbers
    columns: list[int]
    head: list[list[str]]


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip(' \t"\r') for cell in (line.split(delimiter) if delimiter else line.split())]


def _is_number(cell: str, decimal: str) -> bool:
    return _NUMBER.fullmatch(cell if decimal == "." else cell.replace(".", "x").replace(",", ".")) is not None


def _first(rows: Sequence[Sequence[str]], j: int, decimal: str) -> int:
    """The row from which column j has only numbers and some empty cells."""
    cells = [row[j] if j < len(row) else "" for row in rows]
    texts = (k for k in reversed(range(len(cells))) if cells[k] and not _is_number(cells[k], decimal))
    start = next((k for k in range(next(texts, -1) + 1, len(cells)) if cells[k]), len(cells))
    return start if sum(map(bool, cells[start:])) > 0.9 * (len(cells) - start) else len(cells)


def _layout(path: str, lines: Sequence[str]) -> _Layout:
    """The first delimiter and decimal sign by which the head ends in rows of numbers and of nothing else."""
    forms = [("\t", "."), ("\t", ","), (";", "."), (";", ","), (",", "."), ("", "."), ("", ",")]
    for (delimiter, decimal), least in [(form, 2) for form in forms] + [(form, 1) for form in forms]:
        rows = [_cells(line, delimiter) for line in lines[:_HEAD]]
        starts = {j: start for j in range(max(map(len, rows))) if (start := _first(rows, j, decimal)) <= len(rows) - 8}
        start = max(starts.values(), default=0)
        columns = list(starts)
        rest = [row[j] for row in rows[(start + len(rows)) // 2:] for j in range(len(row)) if j not in starts]
        if len(columns) < least or any(rest):
            continue
        if any(all(j < len(row) and _is_number(row[j], decimal) for j in columns) for row in rows[:start]):
            raise Failed(f'{path}:{start}: "{lines[start - 1]:.60}": must be numbers, as in the rows above')
        body = {cell for row in rows[start:] for j, cell in enumerate(row) if j in starts}
        if delimiter == "," and any(re.fullmatch(r"[+-]?0\d+", cell) for cell in body):
            raise Failed(f"{path}: commas stand between columns and, it seems, in numbers: must be one of them")
        if len(columns) == 1:  # below a header of words and values
            rows[:start] = [_cells(row[0], ";" if ";" in row[0] else ",") for row in rows[:start]]
        return _Layout(delimiter, decimal, start, columns, rows)
    raise Failed(f"{path}: no columns of numbers up to line {len(lines[:_HEAD])}: must be rows of numbers, behind any header")


def _numbers(path: str, lines: Sequence[str], form: _Layout) -> Floats:
    """The rows of numbers [column][row], nan in empty cells."""
    out = np.full((len(form.columns), len(lines) - form.start), math.nan)
    for row, line in enumerate(lines[form.start:]):
        cells = _cells(line, form.delimiter)
        for k, j in enumerate(form.columns):
            cell = cells[j] if j < len(cells) else ""
            if cell and not _is_number(cell, form.decimal):
                raise Failed(f'{path}:{form.start + row + 1}: "{cell:.40}": must be a number, as in the rows above')
            out[k, row] = float(cell.replace(",", ".").replace("∞", "inf")) if cell else math.nan
    return out


def _title(texts: Sequence[str]) -> tuple[str, str]:
    """Name and unit of a column, of the cells above it, from below: "Time(s)"; "second"; "(ms)" below "Time"."""
    unit = ""
    if list(texts) == ["A"]:
        return "A", ""  # a channel, as B beside it
    for text in texts:
        text = re.sub(r"^(t|time|zeit|temps|tiempo|tempo)\s*/\s*(\S+)$", r"\1 (\2)", text, flags=re.I)
        found = re.search(r"[(\[]\s*([^)\]]+?)\s*[)\]]", text)
        word = _UNITS.get(found[1] if found else text) or _UNITS.get((found[1] if found else text).lower(), "")
        if found and not word and unit:
            return found[1], unit  # "X(CH1)" above "Volt"
        unit = unit or word or (found[1] if found else "")
        name = re.sub(r"\s*[(\[].*", "", text)
        if name and not (word and not found):
            return name, unit
    return "", unit


def _header(head: Sequence[Sequence[str]], start: int) -> dict[str, str]:
    """What a header says beside or below a word, such as "sample interval"."""
    said: dict[str, str] = {}
    for k, row in enumerate(head):
        if len(row) > 1 and row[0] and not _is_number(row[0], "."):
            key = row[0].strip(":# ").lower()
            said.setdefault(key, row[1])
            if key in _INFINIIUM:
                said[_INFINIIUM[key]] = row[1]
        for j, cell in enumerate(row if k < start else ()):
            if cell.lower() in ("start", "increment") and k + 1 < len(head) and j < len(head[k + 1]):
                said[cell.lower()] = head[k + 1][j]
            for key, value in re.findall(r"\b(t0|tInc)\s*=\s*([0-9.eE+-]+)", cell):
                said[{"t0": "start", "tInc": "increment"}[key]] = value
    return said


def _vertical_units(head: Sequence[Sequence[str]]) -> list[str]:
    """Of each channel, where a header has them in a row."""
    cells = next((row[1:] for row in head if row[0].strip(":# ").lower() in ("vertical units", "yunits")), [])
    return [_UNITS.get(cell, "") or _UNITS.get(cell.split(":")[-1].lower(), "") for cell in cells]


def _text(path: str, text: str, form: Form) -> list[Trace]:
    lines = text.rstrip().splitlines()
    if len(lines) < LEAST:
        raise Failed(f"{path}: {len(lines)} lines, must be {LEAST} or more")
    layout = _layout(path, lines)
    above = [row for row in layout.head[:layout.start] if any(row) and not row[0].endswith(":")][-2:]
    titles = [_title([row[j].lstrip("# ") for row in reversed(above) if j < len(row)]) for j in layout.columns]
    said = _header(layout.head, layout.start)
    if lines[0].startswith("LECROY"):
        segments = next((row[1] for row in layout.head if row[0] == "Segments"), "1")
        if segments != "1":
            raise Failed(f"{path}: {segments} segments, must be 1: export them one by one")
        said["horizontal units"] = "s"
    values = _numbers(path, lines, layout)
    if not titles[-1][0]:
        titles[-1] = (said.get("source", ""), titles[-1][1])
    for unit, row in zip(_vertical_units(layout.head), range(min(len(titles) - 1, 1), len(titles))):
        titles[row] = (titles[row][0], titles[row][1] or unit)
    return _columns(path, titles, values, said, form)


def _columns(path: str, titles: list[tuple[str, str]], values: Floats, said: dict[str, str], form: Form) -> list[Trace]:
    names = [name or f"c{j + 1}" for j, (name, _) in enumerate(titles)]
    at = _time_column(path, names, values, said, form)
    units = ([titles[at][1]] if at is not None and "increment" not in said else []) + [said.get("horizontal units", "").lower()]
    unit = form.time_unit or next((_UNITS[unit] for unit in units if _UNITS.get(unit) in MICROSECONDS), "")
    if not unit and any(units):
        raise Failed(f"{path}: the unit of time is {next(filter(None, units)):.40}: choose by --time-unit {', '.join(MICROSECONDS)} or own")
    notes = [] if unit or form.step or "increment" in said else ["the file names no unit of time: seconds are assumed; "
                                                                  "--time-unit says another"]
    scale = MICROSECONDS.get(unit or "s", 1.0)  # the unit "own" is kept
    count = np.arange(values.shape[1])
    step = form.step or _float(said.get("increment", "")) or (0.0 if at is not None else _float(said.get("sample interval", "")))
    if step > 0:
        t = _float(said.get("start", "")) + step * count
    elif at is not None:
        t, note = even(values[at], path)
        notes += [note] if note else []
    else:
        raise Failed(f"{path}: has no column of times, and no interval: say --step, or --columns t=NAME")
    names = [name if names.count(name) == 1 else f"c{j + 1}" for j, name in enumerate(names)]
    with np.errstate(invalid="ignore"):  # of inf; without counters of rows, the times once more, and idle channels
        rest = [j for j in range(len(names)) if j != at and not np.all(np.diff(values[j]) == 1)
                and not (at is not None and np.array_equal(values[j], values[at]))]
        rest = [j for j in rest if not np.all(np.diff(values[j]) == 0)] or rest
    wanted = [(_find(path, names, name.lstrip("-")), name) for name in form.values] or [(j, names[j]) for j in rest]
    if not wanted:
        raise Failed(f"{path}: has a column of times and no other")
    found = []
    for j, name in wanted:
        unit_of, size = _VOLTS.get(titles[j][1], (titles[j][1], 1.0))
        found.append(Trace(path, name, t * scale, values[j] * (-size if name[0] == "-" else size),
                           OWN_TIME if unit == "own" else "us", unit_of, notes=list(notes)))
    return found


def _float(text: str) -> float:
    return float(text) if _NUMBER.fullmatch(text) and math.isfinite(float(text)) else 0.0


def _find(path: str, names: Sequence[str], name: str) -> int:
    if name in names:
        return names.index(name)
    if name.isdigit() and 1 <= int(name) <= len(names):
        return int(name) - 1
    raise Failed(f"{path}: has no column {name:.40}: must be one of {', '.join(names)}, or its number")


def _time_column(path: str, names: Sequence[str], values: Floats, said: dict[str, str], form: Form) -> int | None:
    """The column that the user or its header says, or else the only one that rises evenly."""
    if form.time:
        return _find(path, names, form.time)
    called = [j for j, name in enumerate(names) if re.match(r"(t|x|time|zeit|temps|tiempo|tempo|x-axis)\b", name.lower())]
    rising = [j for j, column in enumerate(values) if np.all(column[1:] >= column[:-1])
              and -math.inf < column[0] < column[-1] < math.inf and np.abs(column - np.linspace(column[0], column[-1], len(column))).max() * (len(column) - 1)
              < 0.6 * (column[-1] - column[0])]
    if called:
        return called[0]
    if len(rising) > 1:
        raise Failed(f"{path}: the columns {', '.join(names[j] for j in rising)} may be the times: choose by --columns t=NAME")
    return rising[0] if rising and len(values) > 1 else None


# ---- other forms ----------------------------------------------------------------------------------------------------

def _own(path: str) -> list[Trace]:
    """A table of signals of this program, or one that `trace --write` wrote."""
    table = Table.read(path)
    if "t" not in table or table["t"].dtype.kind not in "fi" or len(table.names) < 2:
        raise Failed(f"{path}: a table of signals has numbers t and F, or t, F1, F2, ...")
    unit = table.units["t"]
    t, note = even(table["t"].astype(float), path)
    found = []
    for name in (name for name in table.names if name != "t" and table[name].dtype.kind == "f"):
        said = table.metadata.get(name, "")
        to = re.match(r"from bottom\S* to plane:([0-9.eE+-]+)", said)
        top = table.metadata.get("height", "") if len(table.names) == 2 or re.match(r"from bottom\S* to top", said) else ""
        distance = float(to[1]) if to else _float(top.split(" ")[0]) or math.nan
        found.append(Trace(path, name, t * MICROSECONDS.get(unit, 1.0), table[name].astype(float),
                           "us" if unit in MICROSECONDS else unit, table.units[name], distance, [note] if note else []))
    return found


def _wav(path: str) -> list[Trace]:
    import scipy.io.wavfile
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Chunk")
            warnings.filterwarnings("error", "Reached EOF")
            rate, data = scipy.io.wavfile.read(path)
    except (ValueError, ZeroDivisionError, UnboundLocalError, struct.error, UserWarning) as fault:
        raise Failed(f"{path}: is no whole WAV: {fault}") from None
    if rate < 1 or not len(data):
        raise Failed(f"{path}: {len(data)} samples at {rate} a second")
    channels = data.reshape(len(data), -1).T
    if data.dtype.kind != "f":
        channels = (channels - (128.0 if data.dtype == np.uint8 else 0.0)) / (np.iinfo(data.dtype).max + 1.0)
    return [Trace(path, f"c{k + 1}", np.arange(len(data)) * 1e6 / rate, f.astype(float)) for k, f in enumerate(channels)]


def _sac(path: str, data: bytes) -> Trace:
    """70 numbers, 40 integers and 192 letters, then the values."""
    order = "<" if data[304] else ">"
    header = struct.unpack(order + "70f40i", data[:440].ljust(440, b"\0"))
    values = np.frombuffer(data, order + "f4", max(len(data) - 632, 0) // 4, min(632, len(data)))
    return _sac_series(path, header, data[440:632].decode("ascii", "replace"), values)


def _sac_text(path: str, text: str) -> Trace:
    """The same in lines: 14 of 5 numbers, 8 of 5 integers, 8 of 24 letters, then the values."""
    lines = text.splitlines()
    try:
        header = [read(word) for read, part in ((float, lines[:14]), (int, lines[14:22])) for line in part for word in line.split()]
        values = np.array([float(word) for line in lines[30:] for word in line.split()])
    except ValueError as fault:
        raise Failed(f"{path}: is neither SAC of version 6 or 7 nor its text: {str(fault).rpartition(': ')[2]:.30} is no number") from None
    if len(header) != 110:
        raise Failed(f"{path}: is no SAC: {len(header)} numbers in the header of 22 lines, must be 110")
    return _sac_series(path, header, "".join(f"{line:24.24}" for line in lines[22:30]), values)


def _sac_series(path: str, header: Sequence[float], letters: str, values: Floats) -> Trace:
    """A time series at equal intervals."""
    points, step, begin = int(header[79]), header[0], header[5]
    if len(values) < points or points < 1:
        raise Failed(f"{path}: {points} values, of which {len(values)} are there: the file is cut off")
    if header[85] != 1 or header[105] != 1 or not step > 0:
        raise Failed(f"{path}: must be a time series of SAC with equal intervals")
    unit, time_unit, writer, component = (letters[k:k + 8].strip("\0 ") for k in (136, 144, 152, 160))
    own = writer == "sonopack" and time_unit == "tau"
    t = (begin if begin != -12345 else 0.0) + step * np.arange(points)
    return Trace(path, component if component not in ("", "-12345") else "c1", t * (1.0 if own else 1e6),
                 values[:points].astype(float), OWN_TIME if own else "us", unit if writer == "sonopack" else "")


def _miniseed(path: str) -> list[Trace]:
    """By Debian's program mseed2sac, since no library of Debian for Python reads it."""
    program: Any = shutil.which("mseed2sac")
    if not program:
        raise Failed(f"{path}: is miniSEED, for which the program mseed2sac must be installed")
    with tempfile.TemporaryDirectory(prefix="sonopack-") as folder:
        done = subprocess.run([program, os.path.abspath(path)], cwd=folder, capture_output=True, text=True)
        made = sorted(os.listdir(folder))
        if done.returncode or not made:
            raise Failed(f"{path}: mseed2sac: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else 'no trace'}")
        return [_sac(path, pathlib.Path(folder, name).read_bytes()) for name in made]
