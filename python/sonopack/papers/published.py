"""Tables of published values and claims, which are files of this package."""
from __future__ import annotations

import csv
import functools
import math
import pathlib

Published = dict[str, str]


@functools.cache
def table(paper: str, name: str) -> tuple[Published, ...]:
    """Rows of PAPER/NAME.tsv: a header, then cells between tabs. Lines that begin with '#' are comments."""
    with open(pathlib.Path(__file__).with_name(paper) / f"{name}.tsv", encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    return tuple(csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE))


@functools.cache
def by_key(paper: str, name: str, key: str = "key") -> dict[str, Published]:
    """The same rows by one of their cells."""
    return {row[key]: row for row in table(paper, name)}


def number(cell: str) -> float:
    """The number of a cell; NAN of an empty one."""
    return float(cell) if cell else math.nan
