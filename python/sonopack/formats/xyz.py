"""Extended XYZ: for each frame the number of atoms, a line of key="value", and the rows."""
from __future__ import annotations

import re
from collections.abc import Iterator

from .export import Export, number_text, rows_of
from .lammps import count_of, said_in
from .sheet import Cursor, Frame, Sheet, numbers, text_of


def _frames(at: Cursor) -> Iterator[Frame]:
    number = 0
    while (line := at.words()) is not None:
        rows = count_of(at, line, "the number of atoms of a frame")
        head = at.next()
        if head is None:
            at.fail("the file ends before the line of Lattice= and Properties=")
        yield Frame(number, rows, at.copy(), head)
        number += 1
        at.skip(rows)


def read(path: str, frame: int | None = None) -> Sheet:
    """The frame of a number from 0, or the last."""
    sheet = Sheet(path, [])
    chosen = sheet.pick(_frames(Cursor(path, text_of(path))), frame)
    sheet.said = said_in(chosen.head)
    _read_lattice(sheet, chosen.at)
    _read_properties(sheet, chosen.at)
    return sheet.read(chosen.at, chosen.rows)


def _read_lattice(sheet: Sheet, at: Cursor) -> None:
    text = sheet.said.get("Lattice")
    if text is None:
        return
    v, origin = numbers(text, 9), numbers(sheet.said.get("Origin", ""), 3)
    if len(v) != 9:
        at.fail(f'Lattice="{text}"; must be nine numbers')
    if v[1] or v[2] or v[5]:
        at.fail(f'Lattice="{text}": the first vector must lie along x, the second in the plane of x and y')
    sheet.tilt = [v[3], v[6], v[7]]
    for axis, low in enumerate(origin + [0.0] * (3 - len(origin))):
        sheet.box[axis] = v[4 * axis] > 0
        sheet.low[axis], sheet.high[axis] = low, low + v[4 * axis]
    for axis, flag in enumerate(re.findall("[TtFf01]", sheet.said.get("pbc", ""))[:3]):
        sheet.periodic[axis] = int(flag in "Tt1")


def _read_properties(sheet: Sheet, at: Cursor) -> None:
    """Names the columns by Properties=name:type:count:... Positions become x y z, other vectors name_x ..."""
    words = sheet.said.get("Properties", "species:S:1:pos:R:3").split(":")
    for name, count in zip(words[::3], [*words[2::3], *([""] * (len(words) % 3 > 0))]):
        if not re.fullmatch(r"\d{1,3}", count) or not 1 <= int(count) <= 100:
            at.fail(f"Properties: '{name[:60]}' must be followed by its type and count")
        many = int(count)
        if many == 3:
            sheet.names += [axis if name == "pos" else f"{name}_{axis}" for axis in "xyz"]
        else:
            sheet.names += [name] if many == 1 else [f"{name}_{k + 1}" for k in range(many)]


def write(e: Export) -> bytes:
    """One frame. The lattice has three vectors in any dimension; an axis that the packing has not is 1 long and not
    periodic."""
    p, n = e.packing, number_text
    (xy, xz, yz), edge = e.tilt, e.frame
    lattice = [n(edge[0]), "0", "0", n(xy), n(edge[1]), "0", n(xz), n(yz), n(edge[2])]
    pbc = " ".join("T" if a < p.dim and e.periodic(a) else "F" for a in range(3))
    more = ":inertia:R:1" * (e.inertia is not None)
    more += ":displacement:R:3" * (e.displacement is not None) + ":rotation:R:3" * (e.rotation is not None)
    head = (f'{p.n}\nLattice="{" ".join(lattice)}" pbc="{pbc}" Properties=species:S:1:pos:R:3:id:I:1:radius:R:1:'
            f"mass:R:1:forces:R:3:contacts:I:1:rattler:I:1{more} dimension={p.dim} pressure={n(e.pressure)} "
            f'friction={n(p.friction)} poisson={n(p.poisson)}{e.said} wall={p.wall} units="{e.units.all}"\n')
    columns = [*e.x.T, e.ids, e.r, e.mass, *e.net.T, e.contacts, e.rattler, *e.vectors("u", "r")[1]]
    return head.encode() + rows_of(columns, first="X ")  # ASE: no element
