"""The work on a paper: the published values, the items, what they have to say, their files, and progress."""
from __future__ import annotations

import argparse
import csv
import dataclasses
import functools
import math
import os
import pathlib
import re
import signal
import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__, plot
from .._command import note
from .._table import Table

if TYPE_CHECKING:
    from .sheet import Sheet

Published = dict[str, str]
Tell = Callable[[float], None]  # tells which part of an item is done


# ---- published values -----------------------------------------------------------------------------------------------

@functools.cache
def published(paper: str, name: str) -> tuple[Published, ...]:
    """Rows of PAPER/NAME.tsv: a header, then cells between tabs. Lines that begin with '#' are comments."""
    with open(pathlib.Path(__file__).with_name(paper) / f"{name}.tsv", encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    return tuple(csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE))


@functools.cache
def by_key(paper: str, name: str, key: str = "key") -> dict[str, Published]:
    """The same rows by one of their cells."""
    return {row[key]: row for row in published(paper, name)}


def number(cell: str) -> float:
    """The number of a cell; NAN of an empty one."""
    return float(cell) if cell else math.nan


# ---- items ----------------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Section:
    """What the report says of an item: sentences about our result, and figures as (file, caption)."""

    sentences: list[str] = dataclasses.field(default_factory=list)
    figures: list[tuple[str, str]] = dataclasses.field(default_factory=list)


class Work:
    """The work on the items of one paper that are asked for. folder: of the report, its figures and tables; "" for
    none. figures: their format."""

    def __init__(self, paper: str, signature: str, wanted: set[str], arguments: argparse.Namespace) -> None:
        self.paper, self.items = paper, by_key(paper, "items", "name")
        self.texts = {row["key"]: row["text"] for row in published(paper, "texts")}
        self.signature, self.watch, self.threads = signature, Watch(arguments), arguments.threads
        self.folder, self.figures = arguments.output or "", arguments.figures
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

    def draw(self, item: str, name: str, kind: str, *data: Any, caption: str = "", **words: Any) -> None:
        """Draws a kind of figure of sonopack.plot as NAME.(svg, png or pdf), if there is a folder. caption: if it is not
        among the texts."""
        if self.folder:
            self._save(item, name, caption or self.texts[name], getattr(plot, kind)(*data, **words))

    def draw_sheet(self, item: str, name: str, sheet: Sheet, table: Table | None = None) -> None:
        """Draws curves, with their numbers in NAME.tsv, if there is a folder. table: these numbers."""
        if self.folder:
            self._save(item, name, self.texts[name], sheet.draw())
            self.save_table(name, sheet.table() if table is None else table)

    def _save(self, item: str, name: str, caption: str, axes: Any) -> None:
        from ..plot._frame import figure_of, forget

        plot.save(figure_of(axes), self.path(name, self.figures))
        forget(figure_of(axes))
        self.sections[item].figures.append((f"{name}.{self.figures}", caption))

    def table(self, rows: Sequence[Any], columns: dict[str, type], units: dict[str, str] | None = None) -> Table:
        """Rows of the paper, of which these columns are members, with the comments that explain them."""
        made = Table.from_columns({name: np.array([getattr(row, name) for row in rows], kind)
                                   for name, kind in columns.items()}, units)
        for text in published(self.paper, "texts"):
            if text["key"] == "comment":
                made.add_comment(text["text"])
        return made


# ---- progress and stopping ------------------------------------------------------------------------------------------

class Watch:
    """Progress on stderr: a line on a terminal, elsewhere a line for each step. Ctrl-C, SIGTERM and their like raise
    KeyboardInterrupt; a second one ends the process at once."""

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGXCPU)

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments, self.begun = arguments, time.monotonic()
        self._step, self._shown, self._at = "", False, 0.0
        for each in self.SIGNALS:
            if signal.getsignal(each) is not signal.SIG_IGN:
                signal.signal(each, self._stop)

    def _stop(self, number: int, _: Any) -> None:
        signal.signal(number, signal.SIG_DFL)
        self.clear()
        note(self.arguments, "stopping; a second signal ends the command at once")
        raise KeyboardInterrupt

    @property
    def seconds(self) -> float:
        return time.monotonic() - self.begun

    def tell(self, step: str, fraction: float, more: str = "") -> None:
        """Shows the step that is under way, and the share of all work that is done."""
        fraction = min(1.0, max(0.0, fraction))
        if self.arguments.quiet:
            return
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
