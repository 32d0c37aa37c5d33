"""Tables with a header row, also those of photoelastic experiments, and Yade's x_y_z_r."""
from __future__ import annotations

import re

import numpy as np

from ._faults import bad_file
from .sheet import Cursor, Frame, Sheet, number, shown, text_of


def read(path: str, frame: int | None = None) -> Sheet:
    """The rows of one frame, if there is a column of that name: the given one, or the last."""
    at = Cursor(path, text_of(path))
    line = at.words()
    while line is not None and line.lstrip().startswith("#"):
        line = at.words()
    if line is None:
        raise bad_file(f"{path}: empty: must have a header row with the names of the columns")
    sheet = Sheet(path, [], next((mark for mark in ";,\t" if mark in line), " "))
    sheet.names = [cell.strip('"') if cell.startswith('"') else cell for cell in sheet.cells(line)]
    for key, value in re.findall(rb"^[ \t]*#[ \t]*(\w+)[ \t]*=[ \t]*(\S+)", at.text, re.M):
        sheet.said.setdefault(key.decode(), value.decode(errors="replace"))
    if sheet.separator in ";\t" and not re.search(rb"\d\.\d", at.text):  # spreadsheets of many countries write decimal commas
        at.text = re.sub(rb"(?<=\d),(?=\d)", b".", at.text)
    if number(sheet.names[0]) == number(sheet.names[0]):
        at.fail(f"{shown(line)}: a row of numbers; must be a header row with the names of the columns")
    sheet.read(at)
    column = sheet.column("frame")
    if column >= 0 and sheet.rows > 0:
        frames = sheet.whole(column)
        sheet.pick((Frame(k, 0, at, None) for k in dict.fromkeys(frames.tolist())), frame)
        sheet.keep(np.flatnonzero(frames == sheet.frame))
    return sheet


def read_yade(path: str, frame: int | None = None) -> Sheet:
    """'#format x_y_z_r', or id_x_y_z_r_matId and the like: the names of the columns between underscores."""
    del frame
    at = Cursor(path, text_of(path))
    line = at.words()
    if line is not None and not line.startswith("#format"):
        at.fail(f"{shown(line)}; must be '#format x_y_z_r'")
    names = "x y z r" if line is None else line.removeprefix("#format").replace("_", " ")
    return Sheet(path, names.split()).read(at)
