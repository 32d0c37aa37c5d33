"""VTK XML PolyData: grains as points, contacts and wall contacts as lines; and series of snapshots. Arrays are inline and
uncompressed, in base64 with a 64-bit size in front: of the forms that VTK reads, OVITO reads this one alone."""
from __future__ import annotations

import base64
import binascii
import os
import struct
import xml.etree.ElementTree
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from .._core import Floats
from ._faults import bad_file
from .export import Export, beside, number_text
from .options import CELLS, WALLS
from .sheet import load

_TYPES = {"f8": "Float64", "i8": "Int64", "i4": "Int32"}
_SIZES = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4"}


# ---- writing --------------------------------------------------------------------------------------------------------

def _array(name: str, values: Any, kind: str = "f8") -> str:
    data = np.ascontiguousarray(values, dtype="<" + kind)
    count, wide = (data.shape + (1,))[:2] if data.ndim else (1, 1)
    text = base64.b64encode(struct.pack("<Q", data.nbytes) + data.tobytes()).decode()
    return (f'<DataArray type="{_TYPES[kind]}" Name="{name}" NumberOfComponents="{wide}" '
            f'NumberOfTuples="{count}" format="binary">{text}</DataArray>\n')


def _field(arrays: str) -> str:
    return f"<FieldData>\n{arrays}</FieldData>\n</PolyData>\n</VTKFile>\n"


def _begin(note: str, points: int, verts: int, lines: int) -> str:
    return ('<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
            f"<!-- {note} -->\n<PolyData>\n"
            f'<Piece NumberOfPoints="{points}" NumberOfVerts="{verts}" NumberOfLines="{lines}" NumberOfStrips="0" '
            'NumberOfPolys="0">\n')


def _points(points: Floats, each: int, element: str) -> str:
    count = len(points) // each
    return (f"<Points>\n{_array('Points', points.reshape(-1, 3))}</Points>\n<{element}>\n"
            + _array("connectivity", np.arange(count * each), "i8") + _array("offsets", each * np.arange(1, count + 1), "i8")
            + f"</{element}>\n</Piece>\n")


def _whole(e: Export) -> str:
    """The numbers of the whole packing, which ParaView shows as field data."""
    p = e.packing
    text = _array("dimension", p.dim, "i4") + _array("box", [e.box]) + "".join(
        _array(name, value) for name, value in (("pressure", e.pressure), ("friction", p.friction), ("poisson", p.poisson)))
    if e.special:
        text += _array("cell", CELLS.index(p.cell), "i4") + _array("tilt", [e.tilt])
        text += _array("gravity", e.gravity)
    if e.springs or (p.wall != WALLS[0] and not (e.j < 0).any()):  # else the stiffnesses of contacts with walls tell it
        text += _array("wall_kind", WALLS.index(p.wall), "i4")
    return _field(text)


def _note(e: Export) -> str:
    length, mass, force, stress, stiffness = e.units.names
    return (f"sonopack: lengths in {length}, forces in {force}, stiffnesses in {stiffness}, stresses in {stress}, masses in "
            f"{mass}; the normal of a contact points from its grain id1, on which the force acts")


def _grains(e: Export) -> str:
    n = e.packing.n
    arrays = [("id", e.ids, "i8"), ("radius", e.r, "f8"), ("mass", e.mass, "f8"), ("contacts", e.contacts, "i4"),
              ("rattler", e.rattler, "i4"), ("pressure", e.grain_pressure, "f8"), ("stress", e.stress, "f8"),
              ("net_force", e.net, "f8"), ("displacement", e.displacement, "f8"), ("rotation", e.rotation, "f8")]
    return (_begin(_note(e), n, n, 0) + '<PointData Scalars="radius">\n'
            + "".join(_array(name, values, kind) for name, values, kind in arrays if values is not None)
            + "</PointData>\n" + _points(e.x, 1, "Verts") + _whole(e))


def _lines(e: Export, walls: bool) -> str:
    """OVITO takes a file of lines with id1 and id2 for the bonds of its particles. Walls are no particles: theirs is another
    name."""
    part = e.j < 0 if walls else e.j >= 0
    ends, crosses = e.ends()
    count = int(part.sum())
    arrays = [("id1", e.i, "i8"), ("wall" if walls else "id2", e.j, "i8"), ("normal_force", e.fn, "f8"), ("force", e.force, "f8"),
              ("tangential_force", e.ft, "f8"), ("normal", e.n, "f8"), ("overlap", e.overlap, "f8"), ("kn", e.kn, "f8"),
              ("kt", e.kt, "f8"), ("carrying", e.carrying, "i8"), *(() if walls else (("periodic", crosses, "i8"),))]
    points = np.stack([e.x[e.i], ends], axis=1)[part].reshape(-1, 3)
    return (_begin(_note(e), 2 * count, 0, count) + '<CellData Scalars="normal_force">\n'
            + "".join(_array(name, values[part], kind) for name, values, kind in arrays)
            + "</CellData>\n" + _points(points, 2, "Lines") + _whole(e))


def _named(path: str) -> str:
    return escape(os.path.basename(path), {'"': "&quot;"}).replace("&gt;", ">")


def files_of(path: str) -> list[str]:
    return [path, beside(path, "-contacts.vtp"), beside(path, "-walls.vtp"), beside(path, ".vtm")]


def write(e: Export) -> dict[str, bytes]:
    """NAME.vtp, NAME-contacts.vtp, NAME-walls.vtp, and NAME.vtm, which OVITO opens to get the first two at once."""
    grains, contacts, walls, blocks = files_of(e.path)
    both = "".join(f'<DataSet index="{k}" name="{name}" file="{_named(path)}"/>\n'
                   for k, (name, path) in enumerate((("grains", grains), ("contacts", contacts))))
    block = ('<?xml version="1.0"?>\n<VTKFile type="vtkMultiBlockDataSet" version="1.0">\n<vtkMultiBlockDataSet>\n'
             f"{both}</vtkMultiBlockDataSet>\n</VTKFile>\n")
    return {grains: _grains(e).encode(), contacts: _lines(e, False).encode(), walls: _lines(e, True).encode(),
            blocks: os.fsencode(block)}


# ---- series ---------------------------------------------------------------------------------------------------------

def frame_name(path: str, k: int) -> str:
    return beside(path, f"-{k:04d}.vtp")


def write_frame(e: Export, time: float, scale: float) -> bytes:
    """A snapshot whose points are the centres plus `scale` times the displacements."""
    n, unit = e.packing.n, e.units.names[0]
    text = _begin(f"sonopack: lengths in {unit}; the points are displaced by scale times displacement", n, n, 0)
    text += '<PointData Scalars="radius" Vectors="displacement">\n' + _array("id", e.ids, "i8") + _array("radius", e.r)
    text += _array("displacement", e.displacement) + (_array("rotation", e.rotation) if e.rotation is not None else "")
    text += "</PointData>\n" + _points(e.x + scale * e.displacement, 1, "Verts")
    return (text + _field(_array("TimeValue", time) + _array("scale", scale))).encode()


def write_index(path: str, times: list[float]) -> bytes:
    """The .pvd file, which gives each snapshot its time."""
    sets = "".join(f'<DataSet timestep="{number_text(time)}" group="" part="0" file="{_named(frame_name(path, k))}"/>\n'
                   for k, time in enumerate(times))
    return os.fsencode('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
                       f"{sets}</Collection>\n</VTKFile>\n")


# ---- reading --------------------------------------------------------------------------------------------------------

def _read_array(path: str, element: Any) -> np.ndarray:  # type: ignore[type-arg]
    name, kind = element.get("Name", ""), _SIZES.get(element.get("type", ""))
    if element.get("format") != "binary" or kind is None:
        raise bad_file(f"{path}: array {name}: must be inline in base64, of Float64, Int64 or Int32")
    try:
        data = base64.b64decode((element.text or "").strip(), validate=True)
    except (binascii.Error, ValueError):
        raise bad_file(f"{path}: array {name} is no base64") from None
    if len(data) < 8 or struct.unpack("<Q", data[:8])[0] != len(data) - 8 or (len(data) - 8) % np.dtype(kind).itemsize:
        raise bad_file(f"{path}: array {name} is cut, or compressed; must be of the size that it begins with")
    array = np.frombuffer(data[8:], kind)
    components = element.get("NumberOfComponents", "1")
    wide = int(components) if components.isdigit() and 1 <= int(components) <= 9 else 1
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
        raise bad_file(f"{path}: {root.get('type')}, must be PolyData as sonopack writes it; a series or a block of files names "
                       "others, which can be read")
    note = text[text.find(b"<!--") + 4:text.find(b"-->")].decode(errors="replace") if b"<!--" in text else ""
    return {element.get("Name"): _read_array(path, element) for element in root.iter("DataArray")}, note
