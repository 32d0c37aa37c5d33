"""MATLAB 5 MAT-files of packings, as MATLAB, Octave and scipy read them."""
from __future__ import annotations

import io
from typing import Any

import numpy as np

from .. import _core
from ._faults import bad_file, refused
from .export import Export, contact_columns, grain_columns, scene_of
from .sheet import load

_MOST = 0x7fffffff  # bytes of a variable


def _struct(columns: dict[str, tuple[Any, str]]) -> dict[str, Any]:
    return {name: np.asarray(values, dtype=float).reshape(-1, 1) for name, (values, _) in columns.items()}


def write(e: Export) -> bytes:
    """Structs grains and contacts, their units, and the numbers of the packing."""
    import scipy.io
    p, grains, contacts = e.packing, grain_columns(e), contact_columns(e)
    values: dict[str, Any] = {"dimension": float(p.dim), "box": np.array([e.box[:p.dim]])}
    if e.special:
        values |= {"cell": p.cell, "tilt": np.array([e.tilt]), "gravity": e.gravity}
    values |= {"pressure": e.pressure, "friction": p.friction, "poisson": p.poisson, "wall": p.wall, "units": e.units.all}
    if scene_of(p):
        values["scene"] = scene_of(p)
    for name, columns in (("grains", grains), ("contacts", contacts)):
        values[name] = _struct(columns)
        values[name + "_units"] = {column: unit for column, (_, unit) in columns.items()}
        if 8 * len(columns) * len(next(iter(columns.values()))[0]) > _MOST:
            raise refused("a variable has more than 2 GB, the limit of a MAT-file")
    out = io.BytesIO()
    scipy.io.savemat(out, values, oned_as="column")
    head = f"MATLAB 5.0 MAT-file, written by sonopack {_core.text_of(_core.lib.sp_version())}".encode()
    return head.ljust(116) + out.getvalue()[116:]  # without the date: the same bytes on every run


def read(path: str) -> dict[str, Any]:
    """The variables of a file: numbers, arrays, texts, and dictionaries for structs."""
    import scipy.io
    data = load(path)
    try:
        found = scipy.io.loadmat(io.BytesIO(data), squeeze_me=False, chars_as_strings=True)
    except Exception as fault:  # scipy raises whatever a damaged file leads to
        raise bad_file(f"{path}: is damaged or cut: {type(fault).__name__}: {fault}") from None
    return {name: _plain(value) for name, value in found.items() if not name.startswith("__")}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray) and value.dtype.names:
        row = value.reshape(-1)[0] if value.size else None
        return {} if row is None else {name: _plain(row[name]) for name in value.dtype.names}
    if isinstance(value, np.ndarray) and value.dtype.kind in "US":
        return str(value.reshape(-1)[0]) if value.size else ""
    return np.asarray(value).reshape(-1) if np.asarray(value).dtype.kind in "iufb" else value
