"""Data files and dumps of LAMMPS, and dumps of LIGGGHTS."""
from __future__ import annotations

import dataclasses
import re

from ._faults import bad_file, bad_option
from .export import Export, number_text, rows_of
from .sheet import Cursor, Sheet, numbers, shown, text_of

_EDGES = ("xlo xhi", "ylo yhi", "zlo zhi")


# ---- data files -----------------------------------------------------------------------------------------------------

def read_data(path: str, frame: int | None = None) -> Sheet:
    """A data file of atom style sphere."""
    del frame
    at = Cursor(path, text_of(path))
    sheet = Sheet(path, [])
    sheet.said = said_in(at.next() or "")  # a comment
    atoms = 0
    while (line := at.words()) is not None:
        if line.startswith("Atoms"):
            if atoms == 0:
                at.fail("Atoms before a line '... atoms'")
            style = line.partition("#")[2].split()
            if style and style[0] != "sphere":
                at.fail(f"atom style {style[0]}; must be sphere, whose rows have a diameter and a density")
            cells = (at.copy().words() or "").partition("#")[0].split()
            sheet.names = ["id", "type", "diameter", "density", "x", "y", "z", *(("ix", "iy", "iz") if len(cells) == 10 else ())]
            return sheet.read(at, atoms, "atoms")
        atoms = _header_line(sheet, at, line) or atoms
    at.fail("the file ends without a section 'Atoms # sphere'")


def _header_line(sheet: Sheet, at: Cursor, line: str) -> int:
    """Takes what a line of the header says. Returns the number of atoms, if it is that."""
    content = line.partition("#")[0].rstrip(" \t")
    for axis, edge in enumerate(_EDGES):
        if content.endswith(edge):
            ends = numbers(line, 2)
            if len(ends) != 2 or not ends[1] > ends[0]:
                at.fail(f"'{line}'; must be two growing numbers before {edge}")
            sheet.box[axis], sheet.low[axis], sheet.high[axis] = True, ends[0], ends[1]
    if content.endswith("xy xz yz"):
        sheet.tilt = numbers(line, 3)
        if len(sheet.tilt) != 3:
            at.fail(f"'{line}'; must be three numbers before xy xz yz")
    if content.endswith((" avec", " bvec", " cvec")):
        at.fail(f"'{line}': a box of any direction; must be given by xlo xhi ... xy xz yz")
    if not content.endswith(" atoms"):
        return 0
    count = numbers(line, 1)
    if not count or not 1 <= count[0] < 1e9:
        at.fail(f"'{line}'; must be the number of atoms, 1 or more")
    return int(count[0])


def said_in(line: str) -> dict[str, str]:
    """What key=value and key="value" say in a line; the first counts."""
    found: dict[str, str] = {}
    for key, quoted, plain in re.findall(r"(?:^|(?<=[ \t]))(\w+)=(?:\"([^\"]*)\"?|([^ \t]*))", line):
        found.setdefault(key, quoted or plain)
    return found


# ---- dumps ----------------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class _Frame:
    """One frame of a dump: what its header says, and where its rows are."""

    sheet: Sheet
    step: float = -1
    count: float = -1
    rows: Cursor | None = None


def read_dump(path: str, frame: int | None = None) -> Sheet:
    """The frame of a time step, or the last."""
    at = Cursor(path, text_of(path))
    frames, last, chosen = 0, -1, None
    while (found := _read_frame(at)) is not None:
        frames, last = frames + 1, int(found.step)
        if frame is None or frame == last:
            chosen = found
        at.skip(int(min(found.count, len(at.text))))
    if frames == 0:
        raise bad_file(f"{path}: no frame: no line 'ITEM: TIMESTEP'")
    if chosen is None or chosen.rows is None:
        raise bad_option(f"{path}: no frame of step {frame}; it has {frames}, the last of step {last}")
    sheet = chosen.sheet
    sheet.frames, sheet.frame = frames, int(chosen.step)
    if not sheet.names:
        chosen.rows.fail("no names of columns")
    return sheet.read(chosen.rows, int(chosen.count))


def steps(path: str) -> list[int]:
    """The time steps of all frames."""
    at, found = Cursor(path, text_of(path)), []
    while (frame := _read_frame(at)) is not None:
        found.append(int(frame.step))
        at.skip(int(min(frame.count, len(at.text))))
    return found


def _read_frame(at: Cursor) -> _Frame | None:
    """The header of the next frame; None at the end of the file."""
    frame, any_line = _Frame(Sheet(at.file, [])), False
    while (line := at.words()) is not None:
        any_line = True
        if line.startswith("ITEM: TIMESTEP"):
            frame.step = _single(at, "time step")
        elif line.startswith("ITEM: NUMBER OF"):
            frame.count = _single(at, "number of rows")
        elif line.startswith("ITEM: BOX BOUNDS"):
            _read_bounds(frame.sheet, at, line.split()[3:])
        elif line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
            frame.sheet.names, frame.rows = line.split()[2:], at.copy()
            break
        elif not line.startswith("ITEM:"):
            at.fail(f"{shown(line)} where a line 'ITEM: ...' must be")
        else:  # such as ITEM: UNITS, ITEM: TIME, which have one line
            at.next()
    if any_line and (frame.rows is None or frame.count < 0):
        at.fail("the file ends inside of a frame, before its rows")
    return frame if any_line else None


def _single(at: Cursor, what: str) -> float:
    line = at.next() or ""
    found = numbers(line, 1)
    if not found or found[0] < 0:
        at.fail(f"'{line}'; must be the {what}")
    return found[0]


def _read_bounds(sheet: Sheet, at: Cursor, words: list[str]) -> None:
    if "abc" in words:
        at.fail("a box of any direction (abc origin); must be given by xy xz yz")
    tilted = "xy" in words
    for axis, word in enumerate([word for word in words if len(word) == 2 and word[0] not in "xyz"][:3]):
        sheet.periodic[axis] = int(word == "pp")
    for axis in range(3):
        line = at.next() or ""
        found = numbers(line, 2 + tilted)
        if len(found) != 2 + tilted or not found[1] > found[0]:
            at.fail(f"'{line}'; must be two growing numbers{' and the tilt' if tilted else ''}, the box along {'xyz'[axis]}")
        sheet.box[axis], sheet.low[axis], sheet.high[axis] = True, found[0], found[1]
        sheet.tilt[axis] = found[2] if tilted else 0.0
    if tilted:
        _straighten(sheet, at)


def _around(tilt: list[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """How far the smallest box with right angles around a tilted one lies outside of it, along x and y."""
    xy, xz, yz = tilt
    return (min(0.0, xy, xz, xy + xz), max(0.0, xy, xz, xy + xz)), (min(0.0, yz), max(0.0, yz))


def _straighten(sheet: Sheet, at: Cursor) -> None:
    """Bounds of a tilted box are those of the smallest box with right angles around it."""
    for axis, (below, above) in enumerate(_around(sheet.tilt)):
        sheet.low[axis] -= below
        sheet.high[axis] -= above
        if not sheet.high[axis] > sheet.low[axis]:
            at.fail(f"the bounds along {'xyz'[axis]} leave nothing of the box at these tilts")


# ---- writing --------------------------------------------------------------------------------------------------------

def _bounds(e: Export) -> list[tuple[float, float, bool]]:
    """LAMMPS knows two or three dimensions. Axes that the packing has not are periodic, and wide enough that no grain
    touches its own image; in 2D the layer is one diameter thick, as always."""
    p = e.packing
    wide = 0.25 * e.units.length if p.dim > 1 else max(0.25 * e.units.length, float(e.r.max()))
    return [(0.0, e.box[a], e.periodic(a)) if a < p.dim else (-2 * wide, 2 * wide, True) for a in range(3)]


def write_data(e: Export) -> bytes:
    """A data file of atom style sphere. What it cannot say otherwise is in its first line, which LAMMPS skips."""
    p, n = e.packing, number_text
    title = (f"sonopack packing in {e.units.all}: dimension={p.dim} pressure={n(e.pressure)} friction={n(p.friction)} "
             f"poisson={n(p.poisson)} wall={p.wall}")
    if e.special:
        title += f" cell={p.cell} gravity={n(e.gravity)}"
    head = f"{title}\n\n{p.n} atoms\n1 atom types\n\n"
    head += "".join(f"{n(low)} {n(high)} {axis}lo {axis}hi\n" for axis, (low, high, _) in zip("xyz", _bounds(e)))
    if any(p.tilt):
        head += " ".join(map(n, e.tilt)) + " xy xz yz\n"
    columns = [e.ids + 1, e.ids * 0 + 1, 2 * e.r, e.density, *e.x.T]
    return (head + "\nAtoms # sphere\n\n").encode() + rows_of(columns)


def write_dump(e: Export) -> bytes:
    """One snapshot of `dump custom`."""
    tilted, bounds = any(e.packing.tilt), _bounds(e)
    if tilted:
        out = _around(list(e.tilt))
        bounds = [(bounds[a][0] + out[a][0], bounds[a][1] + out[a][1], bounds[a][2]) if a < 2 else bounds[a] for a in range(3)]
    head = (f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{e.packing.n}\nITEM: BOX BOUNDS{' xy xz yz' if tilted else ''} "
            + " ".join("pp" if periodic else "ff" for _, _, periodic in bounds) + "\n")
    for axis, (low, high, _) in enumerate(bounds):
        head += " ".join(map(number_text, (low, high, *((e.tilt[axis],) if tilted else ())))) + "\n"
    names, vectors = e.vectors("u", "r")
    head += f"ITEM: ATOMS id type x y z radius mass fx fy fz contacts rattler{names}\n"
    columns = [e.ids + 1, e.ids * 0 + 1, *e.x.T, e.r, e.mass, *e.net.T, e.contacts, e.rattler, *vectors]
    return head.encode() + rows_of(columns)
