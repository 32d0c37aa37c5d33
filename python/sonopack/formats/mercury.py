"""MercuryDPM's .data (grains) and .fstat (contacts)."""
from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .sheet import Cursor, Frame, Sheet, numbers, shown, text_of

_FLAT = "x y vx vy radius angle omega info".split()
_SOLID = "x y z vx vy vz radius qx qy qz wx wy wz info".split()
_CONTACTS = "time id1 id2 p_x p_y p_z overlap stretch fn ft nx ny nz t_x t_y t_z".split()


def _frames(at: Cursor) -> Iterator[Frame]:
    number = 0
    while (line := at.words()) is not None:
        head = numbers(line, 9)
        if len(head) not in (6, 8) or not 1 <= head[0] < 1e9 or head[0] != int(head[0]):
            at.fail(f"{shown(line, 80)}; must be the head of a frame: N time xmin ymin zmin xmax ymax zmax")
        yield Frame(number, int(head[0]), at.copy(), head)
        number += 1
        at.skip(int(head[0]))


def read_grains(path: str, frame: int | None = None) -> Sheet:
    """.data: for each frame a line 'N time xmin ymin [zmin] xmax ymax [zmax]', then N rows."""
    sheet = Sheet(path, [])
    chosen = sheet.pick(_frames(Cursor(path, text_of(path))), frame)
    dim = 3 if len(chosen.head) == 8 else 2
    sheet.names = _SOLID if dim == 3 else _FLAT
    for axis in range(dim):
        sheet.low[axis], sheet.high[axis] = chosen.head[2 + axis], chosen.head[2 + dim + axis]
        sheet.box[axis] = sheet.high[axis] > sheet.low[axis]
    return sheet.read(chosen.at, chosen.rows)


def read_contacts(path: str, frame: int | None = None) -> Sheet:
    """.fstat: frames begin with comment lines; rows of 16 numbers."""
    text = text_of(path)
    sheet = Sheet(path, _CONTACTS).read(Cursor(path, text))
    lines = [line[:1] for line in text.split(b"\n") if line.strip()]
    comment = np.array([line == b"#" for line in lines], bool)
    begins = comment & ~np.concatenate([[False], comment[:-1]])
    of_row = np.maximum(np.cumsum(begins) - 1, 0)[~comment]
    last = int(begins.sum()) - 1
    sheet.frames = list(range(last + 1))
    sheet.frame = last if frame is None or last < 0 else min(frame, last)
    sheet.keep(np.flatnonzero(of_row == max(sheet.frame, 0)))
    return sheet
