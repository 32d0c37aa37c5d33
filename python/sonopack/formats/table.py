"""Tables with a header row, also those of photoelastic experiments, and Yade's x_y_z_r; our own CSV."""
from __future__ import annotations

import re

import numpy as np

from ._faults import bad_file, bad_option
from .export import Export, beside, table_of_contacts, table_of_grains
from .sheet import Cursor, Sheet, number, shown, text_of


def read(path: str, frame: int | None = None) -> Sheet:
    """The rows of one frame, if there is a column of that name: the given one, or the last."""
    at = Cursor(path, text_of(path))
    said = {}
    line = at.words()
    while line is not None and line.startswith("#"):
        comment = re.match(r"#[ \t]*(\S+)[ \t]+=[ \t]+(\S+)", line)
        if comment:
            said.setdefault(*comment.groups())
        line = at.words()
    if line is None:
        raise bad_file(f"{path}: empty: must have a header row with the names of the columns")
    separator = next((mark for mark in ",;\t" if mark in line), " ")
    sheet = Sheet(path, [], separator)
    sheet.names = [cell.strip('"') if cell.startswith('"') else cell for cell in sheet._cells(line)]
    sheet.said = said
    if number(sheet.names[0]) == number(sheet.names[0]):
        at.fail(f"{shown(line)}: a row of numbers; must be a header row with the names of the columns")
    sheet.read(at)
    _choose_frame(sheet, frame)
    return sheet


def _choose_frame(sheet: Sheet, frame: int | None) -> None:
    column = sheet.column("frame")
    if column < 0 or sheet.rows == 0:
        return
    frames = sheet.whole(column)
    last = int(frames[-1])
    sheet.frame = last if frame is None else frame
    sheet.frames = 1 + int(np.count_nonzero(np.diff(frames)))
    kept = np.flatnonzero(frames == sheet.frame)
    if len(kept) == 0:
        raise bad_option(f"{sheet.file}: no row of frame {sheet.frame}; the last row is of frame {last}")
    sheet.keep(kept)


def frames_of(path: str) -> list[int]:
    """The numbers of the frames of a table."""
    at = Cursor(path, text_of(path))
    sheet = read(path)
    if sheet.column("frame") < 0:
        return []
    del at
    whole = Sheet(path, sheet.names, sheet.separator).read(sheet._begin)
    return [int(k) for k in dict.fromkeys(whole.whole(sheet.column("frame")).tolist())]


def read_yade(path: str, frame: int | None = None) -> Sheet:
    """'#format x_y_z_r', or id_x_y_z_r_matId and the like: the names of the columns between underscores."""
    del frame
    at = Cursor(path, text_of(path))
    line = at.words()
    if line is not None and not line.startswith("#format"):
        at.fail(f"{shown(line)}; must be '#format x_y_z_r'")
    names = "x y z r" if line is None else line.removeprefix("#format").replace("_", " ")
    return Sheet(path, names.split()).read(at)


def write(e: Export) -> dict[str, bytes]:
    """NAME.csv of grains and NAME-contacts.csv."""
    return {e.path: table_of_grains(e).text("csv").encode(),
            beside(e.path, "-contacts.csv"): table_of_contacts(e).text("csv").encode()}
