"""Packings in the files of other programs: what Packing.read and Packing.save use beyond HDF5 and text.

    packing = Packing.read("atoms.dump", contacts="contacts.dump", friction=0.5)
    packing.save("packing.vtp")
    for packing in sonopack.formats.series("atoms.dump", friction=0.5): ...

Each form has a module that reads rows of numbers into a Sheet, or writes an Export; what the rows mean is found out in
the order of load(): grains, cell, contacts, walls, Hertz's law, and the packing with its balance.
"""
from __future__ import annotations

import dataclasses
import glob
import os
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from .._core import Floats, InvalidInput, Path, c_path, call
from .._packing import Packing
from .._native import lib
from .._records import Material
from . import contacts, finish, forms, grains, lammps, law, vtk, walls, whole, xyz
from ._faults import bad_file, bad_option
from .export import Export, beside
from .frames import Series
from .options import SAID, Options, keys_of, read_key
from .sheet import is_packed
from .work import Report, Work

#: endings of files that save() writes, and the names of their forms
ENDINGS = {".vtp": "vtp", ".data": "lammps-data", ".lammps": "lammps-data", ".dump": "lammps-dump", ".xyz": "xyz",
           ".extxyz": "xyz", ".csv": "csv", ".mat": "mat"}
_SINGLE: dict[str, Callable[[Export], bytes]] = {"lammps-data": lammps.write_data, "lammps-dump": lammps.write_dump,
                                                 "xyz": xyz.write, "mat": whole.write_mat}


# ---- reading --------------------------------------------------------------------------------------------------------

def read(path: Path, *, form: str = "auto", material: Material | None = None, **words: Any) -> Packing:
    """The packing of a file of another program (docs/formats.md).

    words: contacts, walls (files, or words as of --contacts and --walls), columns={role: name}, types, frame,
    length_unit, force_unit, mass_unit, kn, kt_ratio, thickness, rest; and the keys of --set: friction=0.5, top=8.9,
    wall="elastic". packing.report says what was read: its lines() are what the command prints.
    """
    names = {field.name for field in dataclasses.fields(Options)} - {"keys"}
    options = Options(form, material=material, **{name: words.pop(name) for name in names & set(words)})
    if isinstance(options.columns, dict):
        options.columns = ",".join(f"{role}={name}" for role, name in options.columns.items())
    if options.types is not None and not isinstance(options.types, str):
        options.types = ",".join(map(str, np.atleast_1d(options.types)))
    options.contacts, options.walls = (None if word is None else os.fspath(word)
                                       for word in (options.contacts, options.walls))
    options.keys = keys_of(words, options)
    packing, report = load(os.fspath(path), options)
    packing.report = report
    return packing


def load(path: str, options: Options) -> tuple[Packing, Report]:
    """Reads a packing stage by stage. Returns it and what there is to say about it."""
    form = options.form if options.form != "auto" else forms.form_of(path)
    alone = form == "csv" and options.form == "auto" and options.contacts is None and not options.keys
    if form in ("vtp", "mat") or (alone and whole.is_whole_csv(path)):
        packing = whole.read(path, form, options.material)
        walled = int((packing.contacts["j"] < 0).sum())
        return packing, Report(form, packing.n, len(packing.contacts), walled, balance=_balance(packing))
    if form in ("auto", "ours"):
        raise bad_file(f"{path}: {'a packing of this program' if form == 'ours' else 'its form is not recognised'}; "
                       "--from must be lammps-data, lammps-dump, liggghts, yade, mercury, xyz, csv or photoelastic")
    _check_options(options, form)
    with np.errstate(invalid="ignore", divide="ignore"):
        w = _read_files(path, options, form)
        for stage in (grains.gather, grains.find_cell, contacts.read, walls.read):
            stage(w)
        w.roles.check(w.grains, w.contacts)
        law.complete(w)
        packing = finish.make(w)
        return (finish.rest(w, packing) if options.rest else packing), w.report


def _balance(p: Packing) -> float:
    """The largest net force on a grain that is no rattler, over the mean contact force."""
    mean = float(p.contacts["fn"].mean()) if len(p.contacts) else 0.0
    net = np.linalg.norm(Export(p, "").net, axis=1)[~p.rattlers()]
    return float(net.max()) / mean if mean > 0 and len(net) and p.gravity == 0 else float("nan")


def _check_options(o: Options, form: str) -> None:
    """Options that need each other."""
    for unit in (o.length_unit, o.force_unit, o.mass_unit):
        if not 0 < unit < float("inf"):
            raise bad_option(f"the unit {unit:g}: must be positive")
    if o.material is None and o.thickness == o.thickness:
        raise bad_option("--thickness: needs the density of the disks, --material E=...,nu=...,rho=...")
    if form == "photoelastic" and o.material is None:
        raise bad_option("photoelastic disks are no Hertzian spheres: give --material E=...,nu=...,rho=... (their "
                         "modulus and density)")
    if form == "photoelastic" and o.kn != o.kn:
        raise bad_option("photoelastic disks are no Hertzian spheres: give --kn, the stiffness of a contact")
    if form == "photoelastic" and o.contacts is None:
        raise bad_option("photoelastic: give --contacts, the file of frame,id1,id2,Ft,Fn")


def _read_files(path: str, o: Options, form: str) -> Work:
    """The sheets, and the keys that the head of the file says where no option does."""
    sheet = forms.read(path, form, o.frame)
    if o.frame is not None and sheet.frame < 0:
        raise bad_option(f"--frame {o.frame}: {path} has no frames")
    frame = sheet.frame if sheet.frame >= 0 else None  # of several, the contacts of the same one
    listed = None if o.contacts in (None, "overlap") else forms.read_contacts(str(o.contacts), form, frame)
    of_walls = (None if o.walls in (None, "overlap", "none", "balance")
                else forms.read_contacts(str(o.walls), form, frame))
    if listed is not None and listed.frame >= 0 and sheet.frame >= 0 and listed.frame != sheet.frame:
        raise bad_option(f"{path} is of frame {sheet.frame}, {o.contacts} of {listed.frame}; must be the same")
    w = Work(path, o, form, (sheet, listed, of_walls))
    if len(sheet.frames) > 1 and o.frame is None:
        w.note(f"{path} has {len(sheet.frames)} frames: the last, {sheet.frame}, is taken (--frame takes another)")
    said = [key for key in SAID if key in sheet.said and key not in o.keys]
    for key in said:
        try:
            o.keys[key] = read_key(key, sheet.said[key])
        except InvalidInput as fault:
            raise bad_option(f"{path}: {fault}") from None
    if said:
        w.note("from the head of the file:" + "".join(f" {key}={sheet.said[key]}" for key in said))
    return w


def is_foreign(path: str) -> bool:
    """Whether a file that exists is one of another program, by its content."""
    form = forms.form_of(path) if os.path.isfile(path) else "auto"
    if form == "ours" and is_packed(path):
        raise bad_file(f"{path}: is packed by gzip; must be unpacked (gunzip), as .txt and .h5 are not read otherwise")
    return form not in ("auto", "ours")


def series(path: Path, **words: Any) -> Iterator[Packing]:
    """The packings of all frames of a file, or of the files of a folder or a pattern in the order of their names.
    words: as of read(); contacts may be a file with the same frames, or a pattern with as many files. Each packing has its
    frame, and the strain of its cell since the first; those of ours that have them keep them."""
    name, together = os.fspath(path), Series()
    files = sorted(glob.glob(os.path.join(name, "*") if os.path.isdir(name) else name)) or [name]
    if len(files) == 1 and not os.path.isdir(name):
        frames: list[int | None] = [*frames_of(files[0], words.get("form", "auto"))]
        for frame in frames or [None]:
            yield together.add(Packing.read(files[0], **{**words, **({} if frame is None else {"frame": frame})}), frame)
        return
    lists = sorted(glob.glob(os.fspath(words.get("contacts") or "")))
    if len(lists) > 1 and len(lists) != len(files):
        raise bad_option(f"contacts: {len(lists)} files, must be one for each of the {len(files)}")
    for k, file in enumerate(files):
        yield together.add(Packing.read(file, **{**words, **({"contacts": lists[k]} if len(lists) > 1 else {})}), k)


def frames_of(path: Path, form: str = "auto") -> list[int]:
    """The frames of a file as it names them: time steps, or numbers; an empty list if it has none."""
    name = os.fspath(path)
    form = forms.form_of(name) if form == "auto" else form
    return forms.read(name, form).frames if form in forms.FORMS[1:] else []


# ---- writing --------------------------------------------------------------------------------------------------------

def form_for(path: str) -> str | None:
    """The form that the ending of a name stands for, .gz left aside; None: none of another program."""
    return ENDINGS.get(os.path.splitext(path.removesuffix(".gz"))[1].lower())


def files_for(form: str, path: str) -> list[str]:
    """The files that save() writes, the first of which is `path`."""
    csv = [path, beside(path, "-contacts.csv"), beside(path, "-packing.csv")]
    return vtk.files_of(path) if form == "vtp" else csv if form == "csv" else [path]


def save(packing: Packing, path: Path, *, form: str | None = None, si: bool = False, displacement: Floats | None = None,
         rotation: Floats | None = None) -> None:
    """Writes a packing for another program (docs/formats.md): all files, or none. form: one of ENDINGS' values, by
    default that of the ending, which .gz may follow. si: in SI units, of the packing's material. displacement, rotation
    [n][3] are listed as they are."""
    name = os.fspath(path)
    form, plain = form or form_for(name), name.removesuffix(".gz")
    if form is None and plain != name and os.path.splitext(plain)[1] in (".txt", ".h5", ".hdf5"):
        raise bad_option(f"{name}: {os.path.splitext(plain)[1]} takes no .gz, as packings in it are not read packed")
    if form is None or form not in ENDINGS.values():
        raise bad_option(f"{name}: the ending of a packing must be .h5, .txt or {', '.join(ENDINGS)}")
    if si and not packing.material.young > 0:
        raise bad_option("si: the packing has no material")
    call(lib.sp_packing_check, packing._c)
    if displacement is not None and form == "lammps-data":
        raise bad_option(f"{name}: this form has no place for displacements")
    for values in (displacement, rotation):
        if values is not None and not np.isfinite(values).all():
            bad = np.flatnonzero(~np.isfinite(values).all(axis=1))[0]
            raise bad_option(f"the displacement of grain {bad} is not a finite number")
    e = Export(packing, plain, packing.material if si else None, displacement, rotation)
    files = (vtk.write(e) if form == "vtp" else whole.write_csv(e) if form == "csv" else {plain: _SINGLE[form](e)})
    write_files({file + name[len(plain):]: data for file, data in files.items()})


def write_files(files: dict[str, bytes]) -> None:
    """Writes all files, those that end in .gz packed. If one fails, those that were not there before are removed."""
    import gzip
    new = [name for name in files if not os.path.lexists(name)]
    try:
        for name, data in files.items():
            packed = gzip.compress(data, 6, mtime=0) if name.endswith(".gz") else data
            call(lib.sp_text_save, c_path(name), packed, len(packed))
    except BaseException:
        for name in new:
            if os.path.exists(name):
                os.unlink(name)
        raise
