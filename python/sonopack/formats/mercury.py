"""MercuryDPM's .data (grains) and .fstat (contacts)."""
from __future__ import annotations

import numpy as np

from ._faults import bad_file, bad_option
from .sheet import Cursor, Sheet, numbers, shown, text_of

_FLAT = "x y vx vy radius angle omega info".split()
_SOLID = "x y z vx vy vz radius qx qy qz wx wy wz info".split()
_CONTACTS = "time id1 id2 p_x p_y p_z overlap stretch fn ft nx ny nz t_x t_y t_z".split()


def read_grains(path: str, frame: int | None = None) -> Sheet:
    """.data: for each frame a line 'N time xmin ymin [zmin] xmax ymax [zmax]', then N rows."""
    at = Cursor(path, text_of(path))
    frames, chosen = 0, None
    while (line := at.words()) is not None:
        head = numbers(line, 9)
        if len(head) not in (6, 8) or not 1 <= head[0] < 1e9 or head[0] != int(head[0]):
            at.fail(f"{shown(line, 80)}; must be the head of a frame: N time xmin ymin zmin xmax ymax zmax")
        if frame is None or frame == frames:
            chosen = frames, head, at.copy()
        frames += 1
        at.skip(int(head[0]))
    if frames == 0:
        raise bad_file(f"{path}: no frame")
    if chosen is None:
        raise bad_option(f"{path}: no frame {frame}; must be 0 .. {frames - 1}")
    number, head, start = chosen
    dim = 3 if len(head) == 8 else 2
    sheet = Sheet(path, _SOLID if dim == 3 else _FLAT)
    for axis in range(dim):
        sheet.low[axis], sheet.high[axis] = head[2 + axis], head[2 + dim + axis]
        sheet.box[axis] = sheet.high[axis] > sheet.low[axis]
    sheet.frames, sheet.frame = frames, number
    return sheet.read(start, int(head[0]), "grains")


def read_contacts(path: str, frame: int | None = None) -> Sheet:
    """.fstat: frames begin with comment lines; rows of 16 numbers."""
    text = text_of(path)
    sheet = Sheet(path, _CONTACTS).read(Cursor(path, text))
    of_row, number, comment = [], -1, False
    for line in text.split(b"\n"):
        if line[:1] == b"#":
            number += not comment
            comment = True
        elif line.strip():
            of_row.append(max(number, 0))
            comment = False
    sheet.frames, sheet.frame = number + 1, number
    rows = np.array(of_row, dtype=np.int64)
    if frame is not None and number >= 0:
        sheet.frame = min(frame, number)
    sheet.keep(np.flatnonzero(rows == max(sheet.frame, 0)))
    return sheet
