"""Files that hold a whole packing, read back with every bit: VTK's of sonopack, MAT, and CSV with its table of the packing."""
from __future__ import annotations

import dataclasses
import os
from typing import Any

import numpy as np

from .._core import Floats, InvalidInput
from .._packing import Packing
from .._records import Material
from . import mat, table, vtk
from ._faults import bad_file, bad_option
from .export import Export, Units, beside, number_text
from .finish import not_usual, usual_stiffness
from .law import stiffness, wall_stiffness
from .options import CELLS, WALLS
from .work import Links

_HEAD = ("dimension", "box", "tilt", "cell", "pressure", "gravity", "friction", "poisson", "wall", "units")


@dataclasses.dataclass
class _Whole:
    """What a file says, in its own units."""

    path: str
    x: Floats
    r: Floats
    mass: Floats
    links: Links
    head: dict[str, Any]
    si: bool


def read(path: str, form: str, material: Material | None = None) -> Packing:
    """The packing of a file of form "vtp", "mat" or "csv". Files in SI units need the material of the grains."""
    try:
        whole = {"vtp": _read_vtp, "mat": _read_mat, "csv": _read_csv}[form](path)
        if whole.si and material is None:
            raise bad_option(f"{path}: is in SI units; give --material E=...,nu=...,rho=...,d=... of its grains")
        return _build(whole, Units.of(material if whole.si else None), material)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as fault:
        if isinstance(fault, InvalidInput):
            raise
        raise bad_file(f"{path}: is no packing of sonopack's: {fault} is missing, or of another size") from None


def _build(whole: _Whole, u: Units, material: Material | None) -> Packing:
    head, links, r = whole.head, whole.links, whole.r / u.length
    dim = int(head["dimension"])
    links.overlap, links.fn, links.ft = links.overlap / u.length, links.fn / u.force, links.ft / u.force
    links.kn, links.kt = links.kn / u.stiffness, links.kt / u.stiffness
    if ((links.i < 0) | (links.i >= len(r)) | (links.j >= len(r)) | (links.j < -6)).any():
        raise bad_file(f"{whole.path}: a contact of grains that are not there; must be 0 .. {len(r) - 1}")
    links.row = np.arange(len(links))
    wall = head.get("wall") or _wall_of(r, links)
    usual = usual_stiffness(r, links, wall, float(head["friction"]) if dim > 1 else 0.0, float(head["poisson"]))
    links.kn, links.kt = np.where(usual, 0, links.kn), np.where(usual, 0, links.kt)
    mass = whole.mass / u.mass
    inertia = 0.4 * mass * r * r
    try:
        return Packing.from_arrays(
            whole.x[:, :dim] / u.length, r, links.table(), box=[float(edge) / u.length for edge in head["box"][:dim]],
            pressure=float(head["pressure"]) / u.stress, friction=float(head["friction"]), poisson=float(head["poisson"]),
            wall=wall, cell=head["cell"], tilt=[float(t) / u.length for t in head["tilt"]], material=material,
            gravity=float(head["gravity"]) * u.density * u.length / u.stress,
            **dict(zip(("mass", "inertia"), not_usual(r, mass, inertia))))
    except InvalidInput as fault:
        raise bad_file(f"{whole.path}: {fault}") from None


def _wall_of(r: Floats, links: Links) -> str:
    """The kind of wall that the stiffnesses of the contacts with walls fit: VTK's files name it only where these
    do not tell."""
    walls = (links.j < 0) & (links.overlap > 0)
    for kind in WALLS if walls.any() else ():
        kn = 2.0 * wall_stiffness(r[links.i[walls]], kind) * np.sqrt(links.overlap[walls])
        if (np.abs(links.kn[walls] / kn - 1) < 1e-9).all():
            return kind
    return "rigid"


def _links(columns: dict[str, Any], dim: int, names: tuple[str, ...]) -> Links:
    """Contacts from columns i, j, overlap, fn, kn, kt of these names, and vectors n and ft."""
    links = Links(len(columns[names[0]]))
    links.i, links.j = (np.asarray(columns[name]).astype(np.int64) for name in names[:2])
    for field, name in zip(("overlap", "fn", "kn", "kt"), names[2:]):
        setattr(links, field, np.asarray(columns[name], dtype=float))
    for field, stem in (("n", "n"), ("ft", "Ft")):
        out = np.zeros((len(links), 3))
        for a in range(dim):
            out[:, a] = columns[stem + "xyz"[a]]
        setattr(links, field, out)
    return links


# ---- VTK ------------------------------------------------------------------------------------------------------------

def _read_vtp(path: str) -> _Whole:
    grains, note = vtk.read_arrays(path)
    if "scale" in grains or "mass" not in grains:
        raise bad_file(f"{path}: has no grains and contacts of a packing; give NAME.vtp, not a part or a frame of a series")
    parts = [vtk.read_arrays(beside(path, suffix))[0] for suffix in ("-contacts.vtp", "-walls.vtp")]
    links = sum((_vtk_links(part, partner) for part, partner in zip(parts, ("id2", "wall"))), Links())
    cell = CELLS[int(grains["cell"][0])] if "cell" in grains else "piston"
    head = {"dimension": grains["dimension"][0], "box": np.ravel(grains["box"]), "cell": cell,
            "tilt": np.ravel(grains.get("tilt", np.zeros(3))), **{key: grains[key][0] for key in ("pressure", "friction", "poisson")},
            "gravity": grains["gravity"][0] if "gravity" in grains else 0.0,
            "wall": WALLS[int(grains["wall_kind"][0])] if "wall_kind" in grains else None}
    return _Whole(path, grains["Points"].reshape(-1, 3), grains["radius"], grains["mass"], links, head, "lengths in m" in note)


def _vtk_links(part: dict[str, Any], partner: str) -> Links:
    links = Links(len(part["id1"]))
    links.i, links.j = part["id1"], part[partner]
    links.overlap, links.fn, links.kn, links.kt = (part[name] for name in ("overlap", "normal_force", "kn", "kt"))
    links.n, links.ft = part["normal"].reshape(-1, 3), part["tangential_force"].reshape(-1, 3)
    return links


# ---- MAT ------------------------------------------------------------------------------------------------------------

def _read_mat(path: str) -> _Whole:
    found = mat.read(path)
    dim, grains = int(found["dimension"][0]), found["grains"]
    x = np.zeros((len(grains["radius"]), 3))
    for a in range(dim):
        x[:, a] = grains["xyz"[a]]
    head = {"cell": "piston", "tilt": np.zeros(3), "gravity": 0.0,
            **{key: value if isinstance(value, str) or key in ("box", "tilt") else value[0] for key, value in found.items()
               if key in _HEAD}}
    links = _links(found["contacts"], dim, ("i", "j", "overlap", "Fn", "kn", "kt"))
    return _Whole(path, x, grains["radius"], grains["mass"], links, head, head["units"] == "SI")


# ---- CSV ------------------------------------------------------------------------------------------------------------

def csv_is_whole(path: str) -> bool:
    """Whether the table of a packing lies beside a table of grains."""
    return all(os.path.isfile(beside(path, suffix)) for suffix in ("-packing.csv", "-contacts.csv"))


def write_csv(e: Export) -> dict[str, bytes]:
    """NAME.csv, NAME-contacts.csv, and NAME-packing.csv: keys and values of what the two others cannot say."""
    p, n = e.packing, number_text
    values = {"dimension": str(p.dim), "box": " ".join(map(n, e.box[:p.dim])), "tilt": " ".join(map(n, e.tilt)), "cell": p.cell,
              "pressure": n(e.pressure), "gravity": n(e.gravity), "friction": n(p.friction), "poisson": n(p.poisson),
              "wall": p.wall, "units": "SI" if e.units.all == "SI" else "own"}
    text = "key,value\n" + "".join(f"{key},{value}\n" for key, value in values.items())
    return {**table.write(e), beside(e.path, "-packing.csv"): text.encode()}


def _read_csv(path: str) -> _Whole:
    from .sheet import text_of
    rows = [line.partition(",")[::2] for line in text_of(beside(path, "-packing.csv")).decode(errors="replace").splitlines()]
    said: dict[str, Any] = dict(rows[1:])
    head = {key: said[key] for key in _HEAD}
    head |= {key: np.array([float(word) for word in said[key].split()]) for key in ("box", "tilt")}
    grains, contacts = table.read(path), table.read(beside(path, "-contacts.csv"))
    columns = {sheet.file: {name: sheet.finite(k) for k, name in enumerate(sheet.names)} for sheet in (grains, contacts)}
    own = columns[grains.file]
    dim = int(head["dimension"])
    x = np.zeros((grains.rows, 3))
    for a in range(dim):
        x[:, a] = own["xyz"[a]]
    links = _links(columns[contacts.file], dim, ("i", "j", "overlap", "Fn", "kn", "kt"))
    return _Whole(path, x, own["radius"], own["mass"], links, head, said["units"] == "SI")
