"""The work on a paper: its items, what they have to say, their files, and how it is stopped."""
from __future__ import annotations

import argparse
import dataclasses
import math
import os
import re
import signal
import sys
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__
from .._command import Failed, note
from .._table import Table
from . import published

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .sheet import Sheet


@dataclasses.dataclass
class Section:
    """What the report says of an item: sentences about our result, and figures as (file, caption)."""

    sentences: list[str] = dataclasses.field(default_factory=list)
    figures: list[tuple[str, str]] = dataclasses.field(default_factory=list)


class Work:
    """The work on the items of one paper that are asked for. folder: of the report, its figures and tables; "" for none.
    figures: their format."""

    def __init__(self, paper: str, signature: str, wanted: set[str], watch: Watch, folder: str, figures: str) -> None:
        self.items = published.by_key(paper, "items", "name")
        self.signature, self.watch, self.folder, self.figures = signature, watch, folder, figures
        self.wanted = [name for name in self.items if not wanted or name in wanted]
        self.sections = {name: Section() for name in self.items}
        self.rows: list[Any] = []

    def say(self, item: str, text: str) -> None:
        """Adds a paragraph on our result. A single sample has no error."""
        self.sections[item].sentences.append(text.replace(" +- nan", ""))

    def path(self, name: str, ending: str) -> str:
        return os.path.join(self.folder, f"{name}.{ending}")

    def save_table(self, name: str, table: Table) -> None:
        """Writes NAME.tsv, if there is a folder."""
        if self.folder:
            table.add_comment(f"sonopack {__version__}, {self.signature}")
            table.save(self.path(name, "tsv"))

    def draw(self, item: str, name: str, caption: str, figure: Figure) -> None:
        """Writes a figure as NAME.(svg, png or pdf)."""
        from .sheet import save

        save(figure, self.path(name, self.figures))
        self.sections[item].figures.append((f"{name}.{self.figures}", caption))

    def draw_sheet(self, item: str, name: str, caption: str, sheet: Sheet) -> None:
        """Draws curves, with their numbers in NAME.tsv, if there is a folder."""
        if self.folder:
            self.draw(item, name, caption, sheet.draw())
            self.save_table(name, sheet.table())


# ---- numbers --------------------------------------------------------------------------------------------------------

def total(values: Iterable[float]) -> float:
    """The sum from the first to the last, on every version of Python."""
    out = 0.0
    for value in values:
        out += float(value)
    return out


def hypot(*values: float) -> float:
    """The length of a vector, by hypot of the C library from the left."""
    out = float(values[0])
    for value in values[1:]:
        out = float(np.hypot(out, value))
    return out


def largest(values: Iterable[float]) -> float:
    """The largest value, at least 0; those that are not numbers do not count."""
    return max((value for value in values if not math.isnan(value)), default=0.0) if values else 0.0


def ratio(a: float, b: float) -> float:
    """a/b as the C library has it: infinite or NAN for b = 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.float64(a) / np.float64(b))


def log(x: float) -> float:
    """The natural logarithm; NAN where there is none."""
    return math.log(x) if x > 0 else -math.inf if x == 0 else math.nan


def root(x: float) -> float:
    """The square root; NAN of a negative number."""
    return math.sqrt(x) if x >= 0 else math.nan


# ---- progress and stopping ------------------------------------------------------------------------------------------

class Stopped(Failed):
    """Stopped by a signal."""


class Watch:
    """Progress on stderr: a line on a terminal, elsewhere a line for each step. Makes Ctrl-C and its like wait for the
    next look at `stop`; a second signal ends the process at once."""

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGXCPU)

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments
        self.stop = False
        self.begun = time.monotonic()
        self._step, self._shown, self._at = "", False, 0.0
        for number in self.SIGNALS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._on_signal)

    def _on_signal(self, number: int, _: Any) -> None:
        self.stop = True
        signal.signal(number, signal.SIG_DFL)
        self.clear()
        note(self.arguments, "stopping; a second signal ends the command at once")

    @property
    def seconds(self) -> float:
        return time.monotonic() - self.begun

    def tell(self, step: str, fraction: float, more: str = "") -> None:
        """Shows the step that is under way, and the share of all work that is done. Raises Stopped after a signal."""
        if not self.arguments.quiet:
            self._show(step, min(1.0, max(0.0, fraction)), more)
        if self.stop:
            raise Stopped("stopped")

    def goes_on(self, step: str, fraction: float, more: str = "") -> bool:
        """The same for the library, which stops where it is told False."""
        try:
            self.tell(step, fraction, more)
        except Stopped:
            return False
        return True

    def _show(self, step: str, fraction: float, more: str) -> None:
        if not sys.stderr.isatty():
            if step != self._step:
                note(self.arguments, f"{step}, {100 * fraction:.0f}% done")
            self._step = step
        elif not self._shown or time.monotonic() - self._at > 0.1:
            self._shown, self._at = True, time.monotonic()
            left = f", {_span(self.seconds * (1 - fraction) / fraction)} left" if fraction > 0.02 else ""
            sys.stderr.write(f"\r\033[K{step}{more}: {100 * fraction:.0f} %{left}")
            sys.stderr.flush()

    def clear(self) -> None:
        if self._shown:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()
        self._shown = False


def _span(seconds: float) -> str:
    """"40 s", "5 min", "2.5 h"."""
    unit, name = (1, "s") if seconds < 100 else (60, "min") if seconds < 6000 else (3600, "h")
    return re.sub(r"\.0 ", " ", f"{seconds / unit:.{1 if unit == 3600 else 0}f} {name}")
