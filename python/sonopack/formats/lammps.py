"""Data files and dumps of LAMMPS, and dumps of LIGGGHTS."""
from __future__ import annotations

import re
from collections.abc import Iterator

from .export import Export, number_text, rows_of
from .sheet import Cursor, Frame, Sheet, numbers, shown, text_of

_EDGES = ("xlo xhi", "ylo yhi", "zlo zhi")


# ---- data files -----------------------------------------------------------------------------------------------------

def read_data(path: str, frame: int | None = None) -> Sheet:
    """A data file of atom style sphere."""
    del frame
    at, atoms = Cursor(path, text_of(path)), 0
    sheet = Sheet(path, [])
    sheet.said = said_in(at.next() or "")  # a comment
    while (line := at.words()) is not None:
        if not line.startswith("Atoms"):
            atoms = _header_line(sheet, at, line) or atoms
            continue
        if atoms == 0:
            at.fail("Atoms before a line '... atoms'")
        style = line.partition("#")[2].split()
        if style and style[0] != "sphere":
            at.fail(f"atom style {style[0]}; must be sphere, whose rows have a diameter and a density")
        cells = (at.copy().words() or "").partition("#")[0].split()
        sheet.names = "id type diameter density x y z".split() + (["ix", "iy", "iz"] if len(cells) == 10 else [])
        return sheet.read(at, atoms)
    at.fail("the file ends without a section 'Atoms # sphere'")


def _header_line(sheet: Sheet, at: Cursor, line: str) -> int:
    """Takes what a line of the header says. Returns the number of atoms, if it is that."""
    content = line.partition("#")[0].rstrip(" \t")
    for axis, edge in enumerate(_EDGES):
        if content.endswith(edge):
            _read_edge(sheet, at, line, axis, 2, f"two growing numbers before {edge}")
    if content.endswith("xy xz yz"):
        sheet.tilt = numbers(line, 3)
        if len(sheet.tilt) != 3:
            at.fail(f"'{line}'; must be three numbers before xy xz yz")
    if content.endswith((" avec", " bvec", " cvec")):
        at.fail(f"'{line}': a box of any direction; must be given by xlo xhi ... xy xz yz")
    return count_of(at, line, "the number of atoms, 1 or more") if content.endswith(" atoms") else 0


def count_of(at: Cursor, line: str, what: str) -> int:
    """The number of rows that a line begins with."""
    count = numbers(line, 1)
    if not count or not 1 <= count[0] < 1e9:
        at.fail(f"{shown(line)}; must be {what}")
    return int(count[0])


def _read_edge(sheet: Sheet, at: Cursor, line: str, axis: int, count: int, what: str) -> list[float]:
    """The numbers of a line, the first two of which are the box along an axis."""
    found = numbers(line, count)
    if len(found) != count or not found[1] > found[0]:
        at.fail(f"'{line}'; must be {what}")
    sheet.box[axis], sheet.low[axis], sheet.high[axis] = True, found[0], found[1]
    return found


def said_in(line: str) -> dict[str, str]:
    """What key=value and key="value" say in a line; the first counts."""
    found: dict[str, str] = {}
    for key, quoted, plain in re.findall(r"(?:^|(?<=[ \t]))(\w+)=(?:\"([^\"]*)\"?|([^ \t]*))", line):
        found.setdefault(key, quoted or plain)
    return found


# ---- dumps ----------------------------------------------------------------------------------------------------------

def read_dump(path: str, frame: int | None = None) -> Sheet:
    """The frame of a time step, or the last."""
    sheet = Sheet(path, [])
    chosen = sheet.pick(_frames(Cursor(path, text_of(path))), frame)
    own: Sheet = chosen.head
    if not own.names:
        chosen.at.fail("no names of columns")
    own.frames, own.frame = sheet.frames, sheet.frame
    return own.read(chosen.at, chosen.rows)


def _frames(at: Cursor) -> Iterator[Frame]:
    """Each frame with a sheet of its columns and its box."""
    while (line := at.words()) is not None:
        step, count, sheet = -1.0, -1.0, Sheet(at.file, [])
        while line is not None and not line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
            if line.startswith("ITEM: TIMESTEP"):
                step = _single(at, "time step")
            elif line.startswith("ITEM: NUMBER OF"):
                count = _single(at, "number of rows")
            elif line.startswith("ITEM: BOX BOUNDS"):
                _read_bounds(sheet, at, line.split()[3:])
            elif line.startswith("ITEM:"):  # such as ITEM: UNITS, ITEM: TIME, which have one line
                at.next()
            else:
                at.fail(f"{shown(line)} where a line 'ITEM: ...' must be")
            line = at.words()
        if line is None or count < 0:
            at.fail("the file ends inside of a frame, before its rows")
        sheet.names = line.split()[2:]
        yield Frame(int(step), int(min(count, 2**62)), at.copy(), sheet)
        at.skip(int(min(count, len(at.text))))


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
        found = _read_edge(sheet, at, at.next() or "", axis, 2 + tilted, f"two growing numbers"
                           f"{' and the tilt' if tilted else ''}, the box along {'xyz'[axis]}")
        sheet.tilt[axis] = found[2] if tilted else 0.0
    for axis, (below, above) in enumerate(_around(sheet.tilt) if tilted else ()):
        sheet.low[axis] -= below
        sheet.high[axis] -= above
        if not sheet.high[axis] > sheet.low[axis]:
            at.fail(f"the bounds along {'xyz'[axis]} leave nothing of the box at these tilts")


def _around(tilt: list[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """How far the smallest box with right angles around a tilted one, which bounds are of, lies outside of it, along x
    and y."""
    xy, xz, yz = tilt
    return (min(0.0, xy, xz, xy + xz), max(0.0, xy, xz, xy + xz)), (min(0.0, yz), max(0.0, yz))


# ---- writing --------------------------------------------------------------------------------------------------------

def _bounds(e: Export) -> list[tuple[float, float, bool]]:
    """LAMMPS knows two or three dimensions. Axes that the packing has not are periodic, and wide enough that no grain
    touches its own image; in 2D the layer is one diameter thick, as always."""
    p = e.packing
    wide = 0.25 * e.units.length if p.dim > 1 else max(0.25 * e.units.length, float(e.r.max()))
    return [(0.0, e.frame[a], e.periodic(a)) if a < p.dim else (-2 * wide, 2 * wide, True) for a in range(3)]


def write_data(e: Export) -> bytes:
    """A data file of atom style sphere. What it cannot say otherwise is in its first line, which LAMMPS skips."""
    p, n = e.packing, number_text
    head = (f"sonopack packing in {e.units.all}: dimension={p.dim} pressure={n(e.pressure)} friction={n(p.friction)} "
            f"poisson={n(p.poisson)} wall={p.wall}{e.said}\n\n{p.n} atoms\n1 atom types\n\n")
    head += "".join(f"{n(low)} {n(high)} {edge}\n" for edge, (low, high, _) in zip(_EDGES, _bounds(e)))
    if any(p.tilt):
        head += " ".join(map(n, e.tilt)) + " xy xz yz\n"
    columns = [e.ids + 1, e.ids * 0 + 1, 2 * e.r, e.density, *e.x.T]
    return (head + "\nAtoms # sphere\n\n").encode() + rows_of(columns)


def write_dump(e: Export) -> bytes:
    """One snapshot of `dump custom`."""
    tilted = any(e.packing.tilt)
    out = (*_around(e.tilt), (0.0, 0.0))
    flags = " ".join("pp" if periodic else "ff" for _, _, periodic in _bounds(e))
    head = (f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{e.packing.n}\n"
            f"ITEM: BOX BOUNDS{' xy xz yz' * tilted} {flags}\n")
    for (low, high, _), (below, above), tilt in zip(_bounds(e), out, e.tilt):
        head += " ".join(map(number_text, (low + below, high + above, tilt)[:2 + tilted])) + "\n"
    names, vectors = e.vectors("u", "r")
    head += f"ITEM: ATOMS id type x y z radius mass fx fy fz contacts rattler{names}\n"
    columns = [e.ids + 1, e.ids * 0 + 1, *e.x.T, e.r, e.mass, *e.net.T, e.contacts, e.rattler, *vectors]
    return head.encode() + rows_of(columns)
