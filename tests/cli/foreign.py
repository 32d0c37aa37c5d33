"""Plain readers of the forms that sonopack writes for other programs, for its tests: made from the formats' descriptions,
and strict."""
import base64
import struct
import xml.etree.ElementTree

import numpy as np

TYPES = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4"}


def vtk_array(element):
    """One DataArray: a size of 8 bytes and the data, together in base64."""
    assert element.get("format") == "binary" and element.get("type") in TYPES, element.attrib
    data = base64.b64decode(element.text, validate=True)
    size = struct.unpack("<Q", data[:8])[0]
    assert size == len(data) - 8, (element.get("Name"), size, len(data))
    array = np.frombuffer(data[8:], TYPES[element.get("type")])
    components = int(element.get("NumberOfComponents"))
    assert len(array) == components * int(element.get("NumberOfTuples")), element.attrib  # VTK needs it in FieldData
    return array.reshape(-1, components) if components > 1 else array


class Vtp:
    """points, cells [n][1 or 2], point, cell and field: dicts of arrays."""

    def __init__(self, path):
        root = xml.etree.ElementTree.parse(path).getroot()
        assert root.tag == "VTKFile" and root.get("type") == "PolyData" and root.get("header_type") == "UInt64"
        assert root.get("byte_order") == "LittleEndian" and root.get("compressor") is None
        data = root.find("PolyData")
        self.field = self.arrays(data.find("FieldData"))
        piece, = data.findall("Piece")
        # OVITO tells grains, contacts and meshes apart by the first element alone, and contacts by the first of that
        assert data[0] is piece and (piece[0].tag == "CellData" or piece.find("CellData") is None)
        count = {key: int(piece.get("NumberOf" + key)) for key in ("Points", "Verts", "Lines", "Strips", "Polys")}
        assert count["Strips"] == count["Polys"] == 0 and not (count["Verts"] and count["Lines"])
        self.points = self.arrays(piece.find("Points"))["Points"].reshape(-1, 3)
        self.point, self.cell = self.arrays(piece.find("PointData")), self.arrays(piece.find("CellData"))
        cells = self.arrays(piece.find("Lines" if piece.find("Lines") is not None else "Verts"))
        each = 2 if piece.find("Lines") is not None else 1
        self.cells = cells["connectivity"].reshape(-1, each)
        assert (cells["offsets"] == each * np.arange(1, len(self.cells) + 1)).all()
        assert len(self.points) == count["Points"] and len(self.cells) == count["Lines"] + count["Verts"]
        assert all(len(a) == len(self.points) for a in self.point.values())
        assert all(len(a) == len(self.cells) for a in self.cell.values())

    @staticmethod
    def arrays(element):
        return {} if element is None else {a.get("Name"): vtk_array(a) for a in element.findall("DataArray")}


def lammps_data(path):
    """Title, box [3][2], and rows of atoms: id type diameter density x y z."""
    lines = open(path).read().split("\n")
    assert int(lines[2].removesuffix(" atoms")) > 0 and lines[3] == "1 atom types"
    box = []
    for line, axis in zip(lines[5:8], "xyz"):
        low, high, *names = line.split()
        assert names == [axis + "lo", axis + "hi"], line
        box.append((float(low), float(high)))
    assert lines[9] == "Atoms # sphere" and not lines[8] and not lines[10] and not lines[-1]
    atoms = np.array([[float(word) for word in line.split()] for line in lines[11:-1]])
    assert len(atoms) == int(lines[2].split()[0])
    return lines[0], np.array(box), atoms


def lammps_dump(path):
    """Box [3][2], boundaries, and {column: numbers}."""
    lines = open(path).read().split("\n")
    assert lines[0] == "ITEM: TIMESTEP" and lines[2] == "ITEM: NUMBER OF ATOMS" and lines[-1] == ""
    assert lines[4].startswith("ITEM: BOX BOUNDS ") and lines[8].startswith("ITEM: ATOMS ")
    box = np.array([[float(word) for word in line.split()] for line in lines[5:8]])
    rows = np.array([[float(word) for word in line.split()] for line in lines[9:-1]])
    assert len(rows) == int(lines[3])
    return box, lines[4].split()[3:], dict(zip(lines[8].split()[2:], rows.T))


def extended_xyz(path):
    """{key: text} of the second line, and {property: array}."""
    import shlex
    lines = open(path).read().split("\n")
    head = dict(word.split("=", 1) for word in shlex.split(lines[1]))
    rows = [line.split() for line in lines[2:-1]]
    assert len(rows) == int(lines[0]) and lines[-1] == ""
    properties, at = head["Properties"].split(":"), 0
    columns = {}
    for name, kind, width in zip(properties[::3], properties[1::3], properties[2::3]):
        part = [row[at:at + int(width)] for row in rows]
        columns[name] = np.array(part, {"S": str, "R": float, "I": int}[kind])
        at += int(width)
    assert all(len(row) == at for row in rows)
    return head, columns
