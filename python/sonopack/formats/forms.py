"""The forms of files: which one a file has by its content, and who reads it."""
from __future__ import annotations

import re
from collections.abc import Callable

from . import lammps, mercury, table, xyz
from .sheet import Sheet, load, number, numbers

_READERS: dict[str, Callable[[str, "int | None"], Sheet]] = {
    "lammps-data": lammps.read_data, "lammps-dump": lammps.read_dump, "liggghts": lammps.read_dump,
    "yade": table.read_yade, "mercury": mercury.read_grains, "xyz": xyz.read, "csv": table.read,
    "photoelastic": table.read}
#: forms of other programs that --from names; "auto": by the content
FORMS = ("auto", *_READERS)


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
    if re.match(r"#(?!format|# packing| packing)[^\n]*\n\s*[^\n#]* atoms", text):  # a comment of any kind, LAMMPS data
        return "lammps-data"
    if re.match(r"(\s*#(?!format)[^\n]*\n)*\s*# packing", text):
        return "ours"
    lines = [line.rstrip("\r") for line in re.sub(r"\A(\s*#(?!format)[^\n]*(\n|\Z))*\s*", "", text).split("\n")]
    return _form_of_lines(lines)


def _form_of_lines(lines: list[str]) -> str:
    """The form by the first lines behind comments."""
    line, second = (lines + [""])[:2]
    if line.startswith("N ") and " Lx " in line and " mu " in line:  # our text form's header
        return "ours"
    if line.startswith("ITEM:"):
        return "lammps-dump"
    if line.startswith("#format"):
        return "yade"
    counts = [len(found.split()) if numbers(found, 10**6) else 0 for found in (line, second)]
    if counts[0] == 1 and ("Lattice=" in second or "Properties=" in second):
        return "xyz"
    if counts[0] in (6, 8) and counts[1] in (8, 14):
        return "mercury"
    if any(" atoms" in found or " xlo xhi" in found for found in [found for found in lines if found.strip()][1:40]):
        return "lammps-data"
    cells = [cell.strip() for cell in line.split(";" if ";" in line else ",")]
    if len(cells) > 1:
        return "photoelastic" if {"frame", "radius", "boundary"} <= set(cells) else "csv"
    words = line.split()
    return "csv" if words and number(words[0]) != number(words[0]) and "x" in words else "auto"


def read(path: str, form: str, frame: int | None = None) -> Sheet:
    """The grains of a file."""
    return _READERS[form](path, frame)


def read_contacts(path: str, form: str, frame: int | None = None) -> Sheet:
    """Contacts are in a dump or a table, whatever the form of the grains; those of MercuryDPM in a form of their
    own."""
    if form == "mercury":
        return mercury.read_contacts(path, frame)
    return lammps.read_dump(path, frame) if form_of(path) == "lammps-dump" else table.read(path, frame)
