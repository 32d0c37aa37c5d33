"""VTK XML PolyData: grains as points, contacts and wall contacts as lines; and series of snapshots. Arrays are inline
and uncompressed, in base64 with a 64-bit size in front: of the forms that VTK reads, OVITO reads this one alone."""
from __future__ import annotations

import base64
import binascii
import os
import xml.etree.ElementTree
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
import numpy.typing as npt

from .._core import Floats
from ._faults import bad_file
from .export import Export, beside, number_text
from .options import CELLS, WALLS
from .sheet import load

_TYPES = {"f8": "Float64", "i8": "Int64", "i4": "Int32"}

#: name, values and type of an array; without values it is left out
_Array = tuple[str, Any, str]


# ---- writing --------------------------------------------------------------------------------------------------------

def _arrays(*arrays: _Array) -> str:
    text = ""
    for name, values, kind in arrays:
        if values is None:
            continue
        data = np.ascontiguousarray(values, dtype="<" + kind)
        count, wide = (data.shape + (1,))[:2] if data.ndim else (1, 1)
        coded = base64.b64encode(data.nbytes.to_bytes(8, "little") + data.tobytes()).decode()
        text += (f'<DataArray type="{_TYPES[kind]}" Name="{name}" NumberOfComponents="{wide}" NumberOfTuples="{count}" '
                 f'format="binary">{coded}</DataArray>\n')
    return text


def _file(note: str, data: str, arrays: list[_Array], points: Floats, each: int, field: str) -> bytes:
    """A file of one piece whose elements, vertices or lines, have so many points each."""
    count, element = len(points) // each, "Verts" if each == 1 else "Lines"
    verts, lines = (count, 0) if each == 1 else (0, count)
    connected = _arrays(("connectivity", np.arange(count * each), "i8"),
                        ("offsets", each * np.arange(1, count + 1), "i8"))
    return ('<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
            f'header_type="UInt64">\n<!-- {note} -->\n<PolyData>\n<Piece NumberOfPoints="{len(points)}" '
            f'NumberOfVerts="{verts}" NumberOfLines="{lines}" NumberOfStrips="0" NumberOfPolys="0">\n'
            f"<{data}>\n{_arrays(*arrays)}</{data.split()[0]}>\n"
            f"<Points>\n{_arrays(('Points', points, 'f8'))}</Points>\n<{element}>\n{connected}</{element}>\n</Piece>\n"
            f"<FieldData>\n{field}</FieldData>\n</PolyData>\n</VTKFile>\n").encode()


def _whole(e: Export) -> str:
    """The numbers of the whole packing, which ParaView shows as field data."""
    p = e.packing
    arrays: list[_Array] = [("dimension", p.dim, "i4"), ("box", [e.box], "f8"), ("pressure", e.pressure, "f8"),
                            ("friction", p.friction, "f8"), ("poisson", p.poisson, "f8")]
    if e.special:
        arrays += [("cell", CELLS.index(p.cell), "i4"), ("tilt", [e.tilt], "f8"), ("gravity", e.gravity, "f8")]
    if e.springs or (p.wall != WALLS[0] and not (e.j < 0).any()):  # else the stiffnesses of contacts with walls tell it
        arrays.append(("wall_kind", WALLS.index(p.wall), "i4"))
    return _arrays(*arrays)


def _note(e: Export) -> str:
    length, mass, force, stress, stiffness, _ = e.units.names
    return (f"sonopack: lengths in {length}, forces in {force}, stiffnesses in {stiffness}, stresses in {stress}, "
            f"masses in {mass}; the normal of a contact points from its grain id1, on which the force acts")


def _grains(e: Export) -> bytes:
    arrays: list[_Array] = [
        ("id", e.ids, "i8"), ("radius", e.r, "f8"), ("mass", e.mass, "f8"), ("inertia", e.inertia, "f8"), ("contacts", e.contacts, "i4"),
        ("rattler", e.rattler, "i4"), ("pressure", e.grain_pressure, "f8"), ("stress", e.stress, "f8"),
        ("net_force", e.net, "f8"), ("displacement", e.displacement, "f8"), ("rotation", e.rotation, "f8")]
    return _file(_note(e), 'PointData Scalars="radius"', arrays, e.x, 1, _whole(e))


def _lines(e: Export, walls: bool) -> bytes:
    """OVITO takes a file of lines with id1 and id2 for the bonds of its particles. Walls are no particles: theirs is
    another name."""
    part = e.j < 0 if walls else e.j >= 0
    ends, crosses = e.ends()
    arrays: list[_Array] = [
        ("id1", e.i, "i8"), ("wall" if walls else "id2", e.j, "i8"), ("normal_force", e.fn, "f8"),
        ("force", e.force, "f8"), ("tangential_force", e.ft, "f8"), ("normal", e.n, "f8"), ("overlap", e.overlap, "f8"),
        ("kn", e.kn, "f8"), ("kt", e.kt, "f8"), ("mu", e.mu, "f8"), ("carrying", e.carrying, "i8"),
        *(() if walls else (("periodic", crosses, "i8"),))]
    points = np.stack([e.x[e.i], ends], axis=1)[part].reshape(-1, 3)
    own = [(name, values[part], kind) for name, values, kind in arrays if values is not None]
    return _file(_note(e), 'CellData Scalars="normal_force"', own, points, 2, _whole(e))


def _index(kind: str, version: str, sets: list[tuple[str, str]], inner: str) -> bytes:
    """A file that names others."""
    text = "".join(f'<DataSet {words} file="{_named(path)}"/>\n' for words, path in sets)
    return os.fsencode(f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="{version}">\n'
                       f"<{inner}>\n{text}</{inner}>\n</VTKFile>\n")


def _named(path: str) -> str:
    return escape(os.path.basename(path), {'"': "&quot;"}).replace("&gt;", ">")


def files_of(path: str) -> list[str]:
    """NAME.vtp, NAME-contacts.vtp, NAME-walls.vtp, and NAME.vtm."""
    return [path, *(beside(path, suffix) for suffix in ("-contacts.vtp", "-walls.vtp", ".vtm"))]


def write(e: Export) -> dict[str, bytes]:
    """Grains, contacts, contacts with walls, and the file that OVITO opens to get the first two at once."""
    grains, contacts, walls, blocks = files_of(e.path)
    sets = [(f'index="{k}" name="{name}"', path) for k, (name, path) in enumerate((("grains", grains),
                                                                                     ("contacts", contacts)))]
    return {grains: _grains(e), contacts: _lines(e, False), walls: _lines(e, True),
            blocks: _index("vtkMultiBlockDataSet", "1.0", sets, "vtkMultiBlockDataSet")}


# ---- series ---------------------------------------------------------------------------------------------------------

def frame_name(path: str, k: int) -> str:
    """The file of a snapshot."""
    return beside(path, f"-{k:04d}.vtp")


def write_frame(e: Export, time: float, scale: float) -> bytes:
    """A snapshot whose points are the centres plus `scale` times the displacements."""
    moved = e.x if e.displacement is None else e.x + scale * e.displacement
    note = f"sonopack: lengths in {e.units.names[0]}; the points are displaced by scale times displacement"
    arrays: list[_Array] = [("id", e.ids, "i8"), ("radius", e.r, "f8"), ("displacement", e.displacement, "f8"),
                            ("rotation", e.rotation, "f8")]
    return _file(note, 'PointData Scalars="radius" Vectors="displacement"', arrays, moved, 1,
                 _arrays(("TimeValue", time, "f8"), ("scale", scale, "f8")))


def write_index(path: str, times: list[float]) -> bytes:
    """The .pvd file, which gives each snapshot its time."""
    sets = [(f'timestep="{number_text(time)}" group="" part="0"', frame_name(path, k)) for k, time in enumerate(times)]
    return _index("Collection", "0.1", sets, "Collection")


# ---- reading --------------------------------------------------------------------------------------------------------

def _read_array(path: str, element: Any) -> npt.NDArray[Any]:
    name = element.get("Name", "")
    kind = next((code for code, own in _TYPES.items() if own == element.get("type")), None)
    if element.get("format") != "binary" or kind is None:
        raise bad_file(f"{path}: array {name}: must be inline in base64, of Float64, Int64 or Int32")
    try:
        data = base64.b64decode((element.text or "").strip(), validate=True)
    except (binascii.Error, ValueError):
        raise bad_file(f"{path}: array {name} is no base64") from None
    if len(data) < 8 or int.from_bytes(data[:8], "little") != len(data) - 8 or (len(data) - 8) % int(kind[1]):
        raise bad_file(f"{path}: array {name} is cut, or compressed; must be of the size that it begins with")
    array = np.frombuffer(data[8:], "<" + kind)
    components = element.get("NumberOfComponents", "1")
    wide = int(components) if components in "123456789" else 1
    return array.reshape(-1, wide) if wide > 1 and len(array) % wide == 0 else array


def read_arrays(path: str) -> tuple[dict[str, Any], str]:
    """All arrays of a file of one piece by their names, and its note."""
    text = load(path)
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise bad_file(f"{path}: has a DOCTYPE, which VTK files have not")
    try:
        root = xml.etree.ElementTree.fromstring(text)
    except (xml.etree.ElementTree.ParseError, ValueError) as fault:
        raise bad_file(f"{path}: is no whole XML: {fault}") from None
    if root.get("type") != "PolyData" or root.get("header_type") != "UInt64" or root.get("compressor"):
        raise bad_file(f"{path}: {root.get('type')}, must be PolyData as sonopack writes it; a series or a block of "
                       "files names others, which can be read")
    note = text[text.find(b"<!--") + 4:text.find(b"-->")].decode(errors="replace") if b"<!--" in text else ""
    return {element.get("Name", ""): _read_array(path, element) for element in root.iter("DataArray")}, note
