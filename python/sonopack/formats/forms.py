"""The forms of files: which one a file has by its content, and who reads it."""
from __future__ import annotations

import re
from collections.abc import Callable

from . import lammps, mercury, table, xyz
from .sheet import Sheet, load, number, numbers

#: forms of other programs that --from names; "auto": by the content
FORMS = ("auto", "lammps-data", "lammps-dump", "liggghts", "yade", "mercury", "xyz", "csv", "photoelastic")
#: files of packings whose contacts, box and pressure are in them
COMPLETE = ("ours", "vtp", "mat")

Reader = Callable[[str, "int | None"], Sheet]
_READERS: dict[str, Reader] = {
    "lammps-data": lammps.read_data, "lammps-dump": lammps.read_dump, "liggghts": lammps.read_dump,
    "yade": table.read_yade, "mercury": mercury.read_grains, "xyz": xyz.read, "csv": table.read, "photoelastic": table.read}


def form_of(path: str) -> str:
    """The form of a file: one of FORMS, or "ours" (HDF5 or text of this program), "vtp", "mat"; "auto" if none is
    recognised."""
    start = load(path, 8192)
    if start.startswith(b"\211HDF\r\n\032\n"):
        return "ours"
    if start.startswith(b"MATLAB 5"):
        return "mat"
    text = start.removeprefix(b"\xef\xbb\xbf").decode(errors="replace")
    if re.match(r"\s*(<\?xml[^>]*>\s*)?<VTKFile", text):
        return "vtp"
    return _form_of_lines([line.rstrip("\r") for line in text.split("\n")])


def _form_of_lines(all_lines: list[str]) -> str:
    """The form by the first lines."""
    lines = [line for line in all_lines if line.strip(" \t")]
    if lines and lines[0] == all_lines[0] and lines[0].startswith("#") and not lines[0].startswith(("#format", "# packing")):
        if len(lines) > 1 and " atoms" in lines[1]:  # the first line of LAMMPS data is a comment of any kind
            return "lammps-data"
    while lines and lines[0].startswith("#") and not lines[0].startswith("#format"):
        if lines[0].startswith("# packing"):
            return "ours"
        lines.pop(0)
    if not lines:
        return "auto"
    line = lines[0]
    if line.startswith("N ") and " Lx " in line and " mu " in line:  # our text form's header
        return "ours"
    if line.startswith("ITEM:"):
        return "lammps-dump"
    if line.startswith("#format"):
        return "yade"
    second = all_lines[all_lines.index(line) + 1] if line in all_lines[:-1] else ""
    counts = [len(found.split()) if numbers(found, 10**6) else 0 for found in (line, second)]
    if counts[0] == 1 and ("Lattice=" in second or "Properties=" in second):
        return "xyz"
    if counts[0] in (6, 8) and counts[1] in (8, 14):
        return "mercury"
    if any(" atoms" in found or " xlo xhi" in found for found in lines[1:40]):
        return "lammps-data"
    return _form_of_header(line)


def _form_of_header(line: str) -> str:
    cells = [cell.strip() for cell in line.split(",")]
    if len(cells) > 1:
        return "photoelastic" if {"frame", "radius", "boundary"} <= set(cells) else "csv"
    words = line.split()
    return "csv" if words and number(words[0]) != number(words[0]) and "x" in words else "auto"


def read(path: str, form: str, frame: int | None = None) -> Sheet:
    """The grains of a file."""
    return _READERS[form](path, frame)


def read_contacts(path: str, form: str, frame: int | None = None) -> Sheet:
    """Contacts are in a dump or a table, whatever the form of the grains; those of MercuryDPM in a form of their own."""
    if form == "mercury":
        return mercury.read_contacts(path, frame)
    return lammps.read_dump(path, frame) if form_of(path) == "lammps-dump" else table.read(path, frame)
