"""Files that hold a whole packing, and give it back with every bit: CSV with a table of the packing, MAT, and VTK as
sonopack writes it."""
from __future__ import annotations

import dataclasses
import io
import os
from functools import partial
from typing import Any

import numpy as np

from .._core import Floats, InvalidInput, in_child
from .._packing import Packing
from .._records import Material
from .._table import Table
from . import table, vtk
from ._faults import bad_file, bad_option
from .export import Columns, Export, Units, beside, contact_columns, grain_columns, mat_file, number_text
from .finish import not_usual
from .law import usual_stiffness, wall_stiffness
from .options import CELLS, WALLS
from .sheet import load, text_of
from .work import Links, contact_table, links_of


@dataclasses.dataclass
class _Whole:
    """What a file says, in its own units: columns of grains and contacts, and the keys of the packing."""

    grains: dict[str, Any]
    contacts: dict[str, Any]
    head: dict[str, Any]


def _head(e: Export) -> dict[str, Any]:
    """What the columns of grains and contacts do not say."""
    p = e.packing
    return {"dimension": p.dim, "box": e.box[:p.dim], "tilt": e.tilt, "cell": p.cell, "pressure": e.pressure,
            "gravity": e.gravity, "friction": p.friction, "poisson": p.poisson, "wall": p.wall,
            "units": "SI" if e.units.all == "SI" else "own"}


def read(path: str, form: str, material: Material | None = None) -> Packing:
    """The packing of a file of form "vtp", "mat" or "csv". Files in SI units need the material of the grains."""
    try:
        whole = {"vtp": _read_vtp, "mat": _read_mat, "csv": _read_csv}[form](path)
        if whole.head["units"] == "SI" and material is None:
            raise bad_option(f"{path}: is in SI units; give --material E=...,nu=...,rho=...,d=... of its grains")
        return _build(path, whole, Units.of(material if whole.head["units"] == "SI" else None), material)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as fault:
        if isinstance(fault, InvalidInput):
            raise
        raise bad_file(f"{path}: is no packing of sonopack's: {fault} is missing, or of another size") from None


# ---- the packing ----------------------------------------------------------------------------------------------------

def _vector(columns: dict[str, Any], stem: str, dim: int) -> Floats:
    """[rows][3] of the columns of a vector."""
    found = np.stack([np.asarray(columns[stem + axis], float) for axis in "xyz"[:dim]], axis=1)
    return np.pad(found, ((0, 0), (0, 3 - dim)))


def _links(c: dict[str, Any], dim: int, u: Units) -> Links:
    links = links_of(c["i"], c["j"])
    for field, name, unit in (("overlap", "overlap", u.length), ("fn", "Fn", u.force), ("kn", "kn", u.stiffness),
                              ("kt", "kt", u.stiffness), ("mu", "mu", 1.0)):
        if name != "mu" or name in c:
            setattr(links, field, np.asarray(c[name], float) / unit)
    links.n, links.ft = _vector(c, "n", dim), _vector(c, "Ft", dim) / u.force
    return links


def _build(path: str, whole: _Whole, u: Units, material: Material | None) -> Packing:
    head, dim, r = whole.head, int(whole.head["dimension"]), np.asarray(whole.grains["radius"], float) / u.length
    links = _links(whole.contacts, dim, u)
    if ((links.i < 0) | (links.i >= len(r)) | (links.j >= len(r)) | (links.j < -6)).any():
        raise bad_file(f"{path}: a contact of grains that are not there; must be 0 .. {len(r) - 1}")
    wall = head["wall"] or _wall_of(r, links)
    usual = usual_stiffness(r, links, wall, float(head["friction"]) if dim > 1 else 0.0, float(head["poisson"]))
    links.kn, links.kt = np.where(usual, 0, links.kn), np.where(usual, 0, links.kt)
    own = np.asarray(whole.grains["mass"], float) / u.mass
    turned = whole.grains.get("inertia")  # only where grains are no spheres of one density
    mass, inertia = not_usual(r, own, 0.4 * own * r * r if turned is None
                              else np.asarray(turned, float) / (u.mass * u.length**2))
    try:
        return Packing.from_arrays(
            _vector(whole.grains, "", dim)[:, :dim] / u.length, r, contact_table(links),
            box=[float(edge) / u.length for edge in head["box"][:dim]], pressure=float(head["pressure"]) / u.stress,
            friction=float(head["friction"]), poisson=float(head["poisson"]), wall=wall, cell=head["cell"],
            tilt=[float(t) / u.length for t in head["tilt"]], material=material, mass=mass, inertia=inertia,
            gravity=float(head["gravity"]) * u.density * u.length / u.stress)
    except InvalidInput as fault:
        raise bad_file(f"{path}: {fault}") from None


def _wall_of(r: Floats, links: Links) -> str:
    """The kind of wall that the stiffnesses of the contacts with walls fit: VTK's files name it only where these do not
    tell."""
    walls = links[(links.j < 0) & (links.overlap > 0)]
    for kind in WALLS if len(walls) else ():
        kn = 2.0 * wall_stiffness(r[walls.i], kind) * np.sqrt(walls.overlap)
        if (np.abs(walls.kn / kn - 1) < 1e-9).all():
            return kind
    return "rigid"


# ---- VTK ------------------------------------------------------------------------------------------------------------

def _read_vtp(path: str) -> _Whole:
    grains, note = vtk.read_arrays(path)
    if "scale" in grains or "mass" not in grains:
        raise bad_file(f"{path}: has no grains and contacts of a packing; give NAME.vtp, not a part or a frame of a "
                       "series")
    grains |= dict(zip("xyz", grains["Points"].reshape(-1, 3).T))
    parts = [vtk.read_arrays(beside(path, suffix))[0] for suffix in ("-contacts.vtp", "-walls.vtp")]
    names: dict[str, tuple[str, str]] = {"i": ("id1",) * 2, "j": ("id2", "wall"), "Fn": ("normal_force",) * 2}
    names |= {name: (name,) * 2 for name in ("overlap", "kn", "kt", "mu") if name != "mu" or all(name in part for part in parts)}
    contacts = {name: np.concatenate([part[own] for part, own in zip(parts, both)]) for name, both in names.items()}
    for stem, name in (("n", "normal"), ("Ft", "tangential_force")):
        vector = np.concatenate([part[name].reshape(-1, 3) for part in parts])
        contacts |= {stem + axis: column for axis, column in zip("xyz", vector.T)}
    kinds = {"cell": CELLS, "wall": WALLS}
    codes = {"cell": grains.get("cell", [0]), "wall": grains.get("wall_kind", [])}
    head: dict[str, Any] = {"tilt": [0.0] * 3, "gravity": [0.0], **grains,
                            "units": "SI" if "lengths in m" in note else "own"}
    for key, code in codes.items():
        head[key] = kinds[key][int(code[0])] if len(code) else None
    return _Whole(grains, contacts, _plain_head(head))


def _plain_head(head: dict[str, Any]) -> dict[str, Any]:
    """Rows for box and tilt, and for the other keys words or numbers, of arrays of one element."""
    plain = {key: value[0] if isinstance(value, (np.ndarray, list)) else value
             for key, value in head.items() if np.size(value)}
    return plain | {key: np.ravel(head[key]) for key in ("box", "tilt") if key in head}


# ---- MAT ------------------------------------------------------------------------------------------------------------

def write_mat(e: Export) -> bytes:
    """A MATLAB 5 MAT-file: structs grains and contacts, their units, and the numbers of the packing."""
    head = _head(e) | {"dimension": float(e.packing.dim), "units": e.units.all}
    values = {key: head[key] for key in ("dimension", "box", "cell", "tilt", "gravity", "pressure", "friction",
                                         "poisson", "wall", "units")
              if e.special or key not in ("cell", "tilt", "gravity")}
    values |= {key: np.array([values[key]]) for key in ("box", "tilt") if key in values}
    if e.packing.scene:
        values["scene"] = e.packing.scene
    for name, columns in (("grains", grain_columns(e)), ("contacts", contact_columns(e))):
        values[name] = {column: np.asarray(rows, dtype=float).reshape(-1, 1) for column, (rows, _) in columns.items()}
        values[name + "_units"] = {column: unit for column, (_, unit) in columns.items()}
    return mat_file(values)


def _read_mat(path: str) -> _Whole:
    found = _load_mat(path)
    grains, contacts = ({name: found[part][0, 0][name].reshape(-1) for name in found[part].dtype.names}
                        for part in ("grains", "contacts"))
    return _Whole(grains, contacts, _plain_head({"cell": "piston", "tilt": [0.0] * 3, "gravity": 0.0} | {
        key: value.reshape(-1) for key, value in found.items() if isinstance(value, np.ndarray)}))


def _load_mat(path: str) -> dict[str, Any]:
    """The variables of a file. scipy's reader trusts the tags of a damaged one, of which it may die: a child reads."""
    import scipy.io  # here, so that the child has it
    data = load(path)
    try:
        return in_child(partial(scipy.io.loadmat, io.BytesIO(data), squeeze_me=False, chars_as_strings=True))
    except EOFError:
        why = "its tags do not fit its size"
    except Exception as fault:  # scipy raises whatever a damaged file leads to
        why = f"{type(fault).__name__}: {fault}"
    raise bad_file(f"{path}: is damaged or cut: {why}")


# ---- CSV ------------------------------------------------------------------------------------------------------------

def is_whole_csv(path: str) -> bool:
    """Whether the table of a packing lies beside a table of grains."""
    return all(os.path.isfile(beside(path, suffix)) for suffix in ("-packing.csv", "-contacts.csv"))


def write_csv(e: Export) -> dict[str, bytes]:
    """NAME.csv of grains, NAME-contacts.csv, and NAME-packing.csv: keys and values of what the two others cannot
    say."""
    text = {key: " ".join(number_text(float(x)) for x in np.atleast_1d(value))
            if key != "dimension" and not isinstance(value, str) else str(value) for key, value in _head(e).items()}
    own = "key,value\n" + "".join(f"{key},{value}\n" for key, value in text.items())
    return {e.path: _csv(grain_columns(e)), beside(e.path, "-contacts.csv"): _csv(contact_columns(e)),
            beside(e.path, "-packing.csv"): own.encode()}


def _csv(columns: Columns) -> bytes:
    return Table.from_columns({name: values for name, (values, _) in columns.items()},
                              {name: unit for name, (_, unit) in columns.items()}).text("csv").encode()


def _read_csv(path: str) -> _Whole:
    lines = text_of(beside(path, "-packing.csv")).decode(errors="replace").splitlines()
    head: dict[str, Any] = dict(line.split(",", 1) for line in lines[1:])
    head |= {key: [float(word) for word in head[key].split()] for key in ("box", "tilt")}
    sheets = [table.read(name) for name in (path, beside(path, "-contacts.csv"))]
    grains, contacts = ({name: sheet.finite(k) for k, name in enumerate(sheet.names)} for sheet in sheets)
    return _Whole(grains, contacts, head)
