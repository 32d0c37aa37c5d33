"""sonopack convert: imports and exports packings."""
from __future__ import annotations

import argparse
import dataclasses
import math
import os
import re
from typing import Any

import numpy as np

from .. import formats
from .._command import Failed, Parser, cores, may_write, note, number, option, usage, whole
from .._core import Floats, SonopackError, c_path
from .._native import lib
from .._packing import Packing
from .._records import Material
from .._table import material_of
from ..plot._inputs import Input
from ..plot._motion import Motion, find_mode, find_snapshots
from . import forms, vtk
from .export import Export, beside
from .frames import Series
from .options import Options, read_keys
from .work import modulus

_FRAMES, _MOST_FRAMES, _AMPLITUDE = 24, 10000, 0.25
_KINDS = {"h5": ".h5", "txt": ".txt", "pvd": ".pvd", "vtp": ".vtp", "lammps-data": ".data", "lammps-dump": ".dump",
          "xyz": ".xyz", "csv": ".csv", "mat": ".mat"}
_ENDINGS = ".h5, .txt, .vtp, .pvd, .data, .dump, .xyz, .csv or .mat"
#: options of other programs' files
_IMPORT = ("walls", "columns", "types", "frame", "length_unit", "force_unit", "mass_unit", "kn", "kt_ratio",
           "thickness", "rest")

_USAGE = """%(prog)s [OPTION...] IN OUT [--contacts FILE|overlap]
  or:  %(prog)s [OPTION...] IN|OUT --grains G.tsv --contacts C.tsv"""
_HELP = """\
The format of IN is recognised by its content, that of OUT by its ending or --to. With two tables and one
packing file, the existing one of the two is read and the other is written. A table of grains may also take
the place of IN or OUT; then only the table of contacts needs an option:
  sonopack convert grains.tsv P.h5 --contacts contacts.tsv
With IN, OUT and both tables the packing is written in both forms. IN may also be a file of LAMMPS, LIGGGHTS,
Yade or MercuryDPM, extended XYZ, or a table; its contacts are then in --contacts FILE or, with --contacts
overlap, found by overlap:
  sonopack convert grains.dump P.h5 --contacts contacts.dump --set friction=0.5
--set then takes dimension, up, cell (piston, periodic, box or ring: that of the file), sides, across, width,
depth, bottom, top, height, left, right, front, back, inner, outer, x0, y0, xy, xz, yz, gravity, pressure,
friction, poisson, wall, wall_modulus, wall_kn, digits, first_id (docs/formats.md). For our own tables: box and
material are in comment lines `# key = value' or in --set key=value: width, depth (3D), height, cell, xy, xz,
yz, gravity, pressure, friction, poisson, wall, material, seed. Lengths are in mean grain diameters, pressures in E*.

Endings of OUT for other programs: .vtp (ParaView, OVITO: also NAME-contacts.vtp, NAME-walls.vtp and
NAME.vtm), .pvd (ParaView: a series of snapshots, NAME-0000.vtp and so on), .data and .dump (LAMMPS), .xyz
(extended XYZ), .csv (spreadsheets: also NAME-contacts.csv and NAME-packing.csv), .mat (MATLAB, Octave); and
these with .gz behind them. All but .pvd can be read again."""


def parser() -> Parser:
    """The options of the command."""
    p = Parser("convert", usage=_USAGE, epilog=_HELP,
               description="Converts packings between HDF5 (.h5), a text file (.txt), two tables, and the files of "
                           "other programs.")
    p.add_argument("files", nargs="*", metavar="IN OUT", help=argparse.SUPPRESS)
    add = p.add_argument
    add("--grains", metavar="FILE.tsv", help="table of grains: id x y [z] radius")
    add("--contacts", metavar="FILE.tsv",
        help="table of contacts: i j nx ny [nz] overlap Fn Ft. With files of other programs: their list of contacts, or "
             "overlap: all pairs that overlap")
    add = p.add_argument_group("Packings of other programs").add_argument
    unit, stiff = number(1e-30, 1e30), number(1e-300, 1e300)
    add("--from", dest="form", choices=forms.FORMS, default="auto", help="form of IN (by its content)")
    add("--walls", metavar="FILE|overlap|balance|none",
        help="contacts with the walls (those that IN has, else overlap)")
    add("--columns", metavar="ROLE=NAME,...", help="columns of IN and its contacts, as in id1=c_1[1],ft_x=c_2[5]")
    add("--types", metavar="T,...", help="only grains of these types")
    add("--frame", metavar="N|LOW:HIGH|all", type=_frames,
        help="frame or time step N (the last); several: OUT-N for each")
    add("--length-unit", metavar="L", type=unit, help="length unit of IN over that of the material, 1e-3 for mm (1)")
    add("--force-unit", metavar="F", type=unit, help="the same for forces")
    add("--mass-unit", metavar="M", type=unit, help="the same for masses")
    add("--kn", metavar="K", type=stiff,
        help="normal stiffness of all contacts, in units of the material (Hertz's law)")
    add("--kt-ratio", metavar="X", type=number(0, 100), help="tangential over normal stiffness (Mindlin's)")
    add("--thickness", metavar="H", type=stiff, help="grains are disks of this thickness, in units of the material")
    add("--rest", action="store_true", default=None, help="bring the grains to rest under their pressure")
    add = p.add_argument_group("Files for other programs").add_argument
    add("--to", metavar="KIND", choices=tuple(_KINDS), help=f"form of OUT, in place of its ending: {', '.join(_KINDS)}")
    add("--vectors", metavar="FILE",
        help="displacements to write: a file of modes, or a table of displacements of this packing")
    add("--mode", metavar="N", type=whole(0, 10**15), help="displacements in mode N, of --vectors or computed")
    add("--times", metavar="T|LOW:HIGH:N", type=_times,
        help="displacements at these times after a pulse at the bottom wall; several need .pvd")
    add("--frames", metavar="N", type=whole(1, _MOST_FRAMES), help=".pvd of a mode: snapshots of one period (24)")
    add("--amplitude", metavar="D", type=number(0, 1e6), help=".pvd: largest displacement shown [d] (0.25)")
    p.set_type("--material", option(_material_option))
    return p


def _frames(text: str) -> int | tuple[int, int]:
    """The type of --frame: N, LOW:HIGH or all."""
    most = 9 * 10**15
    if text == "all":
        return 0, most
    low, colon, high = text.partition(":")
    first = whole(0, most)(low)
    return (first, whole(first, most)(high)) if colon else first


def _times(text: str) -> list[float]:
    """The type of --times: T, or LOW:HIGH:N."""
    words = text.split(":")
    if len(words) not in (1, 3):
        raise argparse.ArgumentTypeError(f"{text:.60}: must be T or LOW:HIGH:N")
    low = number(0, 1e9)(words[0])
    if len(words) == 1:
        return [low]
    high, count = number(low, 1e9)(words[1]), whole(1, _MOST_FRAMES)(words[2])
    return [low + (high - low) * k / max(count - 1, 1) for k in range(count)]


def _material_option(text: str) -> Material:
    """--material without d: the diameter is 0, that of the file."""
    has_d = re.search(r"(^|[, ])d=", text)
    material = material_of(text if has_d else text + ",d=1")
    return material if has_d else dataclasses.replace(material, diameter=0.0)


# ---- what is read and written ---------------------------------------------------------------------------------------

@dataclasses.dataclass
class _Job:
    """Files of a conversion: source None: the two tables are read; target None: they are written alone."""

    a: argparse.Namespace
    source: str | None
    target: str | None
    grains: str | None
    contacts: str | None
    foreign: bool = False
    ending: str = ""  # the form of the target
    series: Series | None = None  # of which this is a frame

    @property
    def writes_tables(self) -> bool:
        return self.source is not None and self.grains is not None

    @property
    def moves(self) -> bool:
        """Whether displacements are asked for."""
        return bool(self.a.vectors) or self.a.mode is not None or self.a.times is not None


def _job(a: argparse.Namespace) -> _Job:
    if len(a.files) > 2:
        raise usage(f"{len(a.files)} files; must be IN and OUT")
    source, target = (a.files + [None, None])[:2]
    job = _Job(a, source, target, a.grains, a.contacts)
    if a.output and job.target:
        raise usage(f"OUT is given twice, as {job.target} and -o {a.output}")
    own_table = job.grains or (job.source or "").endswith(".tsv") and a.contacts != "overlap"
    job.foreign = a.form != "auto" or bool(job.source and not own_table and formats.is_foreign(job.source))
    if not job.foreign:
        for name in _IMPORT:
            if getattr(a, name) is not None:
                raise usage(f"--{name.replace('_', '-')}: applies to files of other programs; {job.source or 'IN'} is "
                            "not recognised as one (--from FORM says its form)")
        return _own_files(job)
    job.target = a.output or job.target
    if not job.source or not job.target:
        raise usage(f"no OUT: must be a file name that ends in {_ENDINGS}")
    if job.grains:
        raise usage(f"--grains: IN is {job.source}, the grains of another program; must not be given")
    return job


def _own_files(job: _Job) -> _Job:
    """Which of a packing file and two tables is read, and which is written."""
    two = bool(job.source and (job.target or job.a.output))
    job.target = job.a.output or job.target
    if not job.source and not job.target:
        raise usage("no file: must be IN and OUT; see `sonopack help convert'")
    if two and job.grains in (None, job.source) and str(job.source).endswith(".tsv"):
        job.grains, job.source = job.source, None
    elif two and job.grains in (None, job.target) and str(job.target).endswith(".tsv"):
        job.grains, job.target = job.target, None
    if (job.grains is None) != (job.contacts is None):
        raise usage(f"a table of {'grains' if job.grains else 'contacts'} alone: give both --grains and "
                    "--contacts")
    if job.source == "-" and job.grains:
        job.source = None
    if job.source and not job.target:
        if not job.grains:
            raise usage(f"no OUT: must be a file name that ends in {_ENDINGS}")
        return job if two else _choose_direction(job)
    return job


def _choose_direction(job: _Job) -> _Job:
    """With one packing file and both tables, what exists is read."""
    found = [os.path.exists(path) for path in (str(job.grains), str(job.contacts))]
    packing = os.path.exists(str(job.source))
    if all(found) and packing:
        words = f"{job.source} {job.grains}", f"{job.grains} {job.source}"
        raise usage(f"{job.source} and both tables exist: use `convert {words[0]} --contacts ...' to write the "
                    f"tables, or `convert {words[1]} --contacts ...' to read them")
    if all(found) or (not packing and any(found)):
        job.target, job.source = job.source, None
    return job


# ---- checks before the work -----------------------------------------------------------------------------------------

def _ending_of(a: argparse.Namespace, path: str) -> str:
    """The ending whose form OUT has: that of --to, or its own."""
    own = os.path.splitext(path)[1].replace(".hdf5", ".h5")
    if a.to is not None or own in (".h5", ".txt", ".pvd"):
        return own if a.to is None else _KINDS[a.to]
    form = formats.form_for(path)
    if form is None and re.search(r"\.(h5|hdf5|txt)\.gz$", path):
        raise usage(f"{path}: takes no .gz, as packings in .h5 and .txt are not read packed; must end in .h5 or .txt")
    if form is None:
        raise usage(f"{path}: its ending must be {_ENDINGS}; or use --to")
    return _KINDS[form]


def _check_motion(job: _Job) -> None:
    a, ending = job.a, job.ending
    given = "frames" if a.frames is not None else "amplitude" if a.amplitude is not None else ""
    if ending in (".h5", ".txt") and (job.moves or given):
        raise usage(f"{job.target}: takes no displacements; the forms .vtp, .pvd, .dump, .xyz, .csv and .mat do")
    if a.times and (a.vectors or a.mode is not None):
        raise usage("--times: gives the motion after a pulse; not together with --vectors or --mode")
    if ending != ".pvd" and len(a.times or ()) > 1:
        raise usage("--times LOW:HIGH:N: several times need an OUT that ends in .pvd")
    if ending != ".pvd" and given:
        raise usage(f"--{given}: applies only to an OUT that ends in .pvd")
    if a.times and a.frames is not None:
        raise usage("--frames: applies only to a mode; --times has its own number")


def _outputs(job: _Job) -> list[str]:
    """The files of OUT, the first of which is OUT itself."""
    a, path = job.a, str(job.target)
    if job.ending == ".pvd":
        return [path, *(vtk.frame_name(path, k) for k in range(len(a.times or ()) or a.frames or _FRAMES))]
    return formats.files_for(formats.ENDINGS.get(job.ending, ""), path)


def _check_output(job: _Job) -> None:
    a = job.a
    if job.target is not None:
        job.ending = _ending_of(a, job.target)
        _check_motion(job)
        for k, name in enumerate(_outputs(job)):
            may_write(a, name, None, job.ending if k == 0 and a.to else None)
    if a.units == "si" and (job.ending in ("", ".h5", ".txt") or job.writes_tables):
        raise usage("--units si: packings are stored in d, E* and rho, in .h5, .txt and tables; files for other "
                    "programs may be in SI")
    for table in (job.grains, job.contacts) if job.writes_tables else ():
        may_write(a, str(table), None)


# ---- reading --------------------------------------------------------------------------------------------------------

def _read(job: _Job) -> Packing:
    a = job.a
    if job.foreign:
        given = {name: getattr(a, name) for name in (*_IMPORT, "contacts") if getattr(a, name) is not None}
        options = Options(a.form, material=a.material, threads=a.threads or cores(), **given)
        options.keys = read_keys(a.set, options)
        packing, report = formats.load(str(job.source), options)
        for line in report.lines(str(job.source)):
            note(a, line)
        return packing
    if job.source is None:
        keys = dict(text.partition("=")[::2] for text in a.set)
        return Packing.read_tables(str(job.grains), str(job.contacts), keys)
    if a.set:
        raise usage(f"--set {a.set[0]:.60}: applies only to tables and files of other programs; {job.source} is a packing of "
                    "sonopack's, or its form is not recognised: see --from")
    return Packing.read(job.source)


def _take_material(job: _Job, packing: Packing) -> Packing:
    """Gives a packing of ours the material of --material; of another program's it has it, with the diameter of the
    file."""
    a, own, path = job.a, packing.material, job.source or job.grains
    if a.material is None:
        if a.units == "si" and not own.young > 0:
            raise usage(f"--units si: needs a material, and {path} has none: give it, as in --material "
                        "E=70e9,nu=0.22,rho=2500,d=1e-3 (Pa, kg/m^3, m)")
    elif not job.foreign:
        if not a.material.diameter > 0:
            raise usage("material.d: is missing in --material; only files of other programs give it by their mean "
                        "diameter")
        if own.young > 0 and own != a.material:
            note(a, f"{path}: --material replaces its material E={own.young!r},nu={own.poisson!r},rho={own.density!r},"
                    f"d={own.diameter!r}")
        packing = packing.of_material(a.material)
    d = packing.material.diameter
    if packing.material.young > 0 and not 1e-7 <= d <= 0.1:
        note(a, f"warning: material.d = {d:g} m: the diameter of the grains is in metres (--length-unit 1e-3 if those of the "
                "file are millimetres)")
    return packing


# ---- displacements --------------------------------------------------------------------------------------------------

def _find(packing: Packing, number: int | None, vectors: str | None) -> Motion:
    """A mode of a packing, by its number among all: computed, or of a file of modes; or a table of displacements."""
    if vectors is None:
        return find_mode([Input(packing)], number, None)
    given = [Input(packing), Input(vectors)]
    if not lib.sp_modes_file_looks(c_path(vectors)) and given[1].raw_table.metadata.get("motion") == "snapshot":
        return find_snapshots(given, None, None)[0]
    return find_mode(given, number, None)


def _after_pulse(packing: Packing, times: list[float], threads: int) -> list[Motion]:
    """The motion at times after a pulse of unit strength at the bottom wall."""
    if packing.cell == "periodic":
        raise Failed("the cell is periodic and has no walls, between which the pulse of --times passes: `sonopack "
                     "signal' sends pulses from plane to plane (--from plane:Y --detector plane:Z)")
    network = packing.network()
    return [Motion(network, u, False) for u in network.field(np.array(times), threads=threads)]


def _of_grains(motion: Motion, factor: float = 1.0) -> tuple[Floats, Floats | None]:
    """Displacements and rotations of all grains [n][3]; rattlers do not move."""
    net = motion.network
    u, turns = np.split(factor * net.spread(motion.u, 0.0), [net.dim], axis=1)
    u = np.pad(u, ((0, 0), (0, 3 - net.dim)))
    return u, np.pad(turns, ((0, 0), (3 - turns.shape[1], 0))) if net.dof > net.dim else None


# ---- writing --------------------------------------------------------------------------------------------------------

def _find_motion(job: _Job, packing: Packing) -> list[Motion]:
    """The mode, or the motion at each time."""
    a = job.a
    if job.source is None or job.foreign:
        raise usage("displacements need a packing file as IN: convert to .h5 first")
    if a.times is not None:
        return _after_pulse(packing, a.times, a.threads or cores())
    return [_find(packing, a.mode, a.vectors)]


def _moved(a: argparse.Namespace, one: Motion, amount: float = 1.0) -> dict[str, Any]:
    """Displacements and rotations in the units of the file. A mode has |M^(1/2) u| = 1, so that its u is in 1/sqrt(rho
    d^3) and its rotations in 1/sqrt(rho d^5)."""
    m, (u, turn) = one.network.packing.material, _of_grains(one, amount)
    scale = by_angle = 1.0
    if a.units == "si":
        scale = 1 / math.sqrt(m.density * math.pow(m.diameter, 3)) if one.is_mode else m.diameter
        by_angle = scale / m.diameter
    return {"displacement": scale * u, "rotation": None if turn is None else by_angle * turn}


def _write_movie(job: _Job, packing: Packing) -> None:
    """A moving picture for ParaView: of a mode that swings, or of a wave that passes."""
    a, path, m = job.a, str(job.target), packing.material
    si = a.units == "si"
    moves = _find_motion(job, packing)
    if a.times is None and not moves[0].is_mode:
        raise usage(f"{a.vectors}: is a snapshot; a movie needs a mode, or --times LOW:HIGH:N")
    times, frames = a.times, [_moved(a, one) for one in moves]
    most = max(float(np.linalg.norm(one["displacement"], axis=1).max()) for one in frames)
    if a.times is None:
        count, omega = a.frames or _FRAMES, moves[0].omega
        times = [(2 * math.pi / omega if omega > 0 else 1.0) * k / count for k in range(count)]
        frames = [_moved(a, moves[0], math.cos(2 * math.pi * k / count)) for k in range(count)]
    shown = (m.diameter if si else 1.0) * (_AMPLITUDE if a.amplitude is None else a.amplitude)
    scale = shown / most if most > 0 else 0.0
    times = [time * (m.diameter * math.sqrt(m.density / modulus(m)) if si else 1.0) for time in times]
    e, files = Export(packing, path, m if si else None), {}
    for k, (time, one) in enumerate(zip(times, frames)):
        e.displacement, e.rotation = one["displacement"], one["rotation"]
        files[vtk.frame_name(path, k)] = vtk.write_frame(e, time, scale)
    formats.write_files({**files, path: vtk.write_index(path, times)})
    note(a, f"{path}: {len(times)} frames, displacements times {scale:.6g}")


def _note_losses(job: _Job, p: Packing) -> None:
    """Says what a form that only knows grains leaves out."""
    if job.ending in (".dump", ".data", ".xyz") and (p.contacts["kn"] > 0).any():
        note(job.a, f"{job.target}: has no place for the stiffnesses of contacts, which are left out")
    if job.ending == ".data" and p.mass is not None and p.inertia is not None and not np.allclose(p.inertia, 0.4 * p.mass * p.r**2):
        note(job.a, f"{job.target}: has no place for moments of inertia: its grains are spheres")
    if job.ending == ".dump":
        walls, wall = ("", "") if p.cell == "periodic" else ("walls and ", f"--set wall={p.wall} ")
        note(job.a, f"{job.target}: has no place for {walls}friction: to read it again, {wall}--set friction="
                    f"{p.friction:g}")


def _write(job: _Job, packing: Packing) -> None:
    a = job.a
    if job.ending == ".pvd":
        _write_movie(job, packing)
    elif job.ending in (".h5", ".txt"):
        packing.save_as(str(job.target), job.ending)
    elif job.target is not None:
        vectors = _moved(a, _find_motion(job, packing)[0]) if job.moves else {}
        formats.save(packing, job.target, form=formats.ENDINGS[job.ending], si=a.units == "si", **vectors)
        _note_losses(job, packing)
    if job.writes_tables:
        packing.save_tables(str(job.grains), str(job.contacts))


def run(a: argparse.Namespace) -> int:
    """Reads one packing and writes it, or those of several frames."""
    if not isinstance(a.frame, tuple):
        return _convert(a, _job(a))
    job, failed, (low, high), series = _job(a), list[str](), a.frame, Series()
    ending = os.path.splitext(str(job.target).removesuffix(".gz"))[1]
    numbers = [k for k in formats.frames_of(str(job.source), a.form) if low <= k <= high]
    if not numbers:
        raise usage(f"--frame {low}:{high}: {job.source} has no such frame")
    for k in numbers:
        target = beside(str(job.target), f"-{k:0{len(str(max(numbers)))}d}{ending}")
        one = argparse.Namespace(**{**vars(a), "frame": k, "files": [job.source, target], "output": None})
        try:
            _convert(one, dataclasses.replace(_job(one), series=series))
        except SonopackError as fault:
            failed.append(f"frame {k}: {fault}")
    if failed:
        raise Failed(f"{len(failed)} of {len(numbers)} frames are not converted; {failed[0]}")
    return 0


def _convert(a: argparse.Namespace, job: _Job) -> int:
    _check_output(job)
    packing = _take_material(job, _read(job))
    if job.series:
        job.series.add(packing, a.frame)
    _write(job, packing)
    m = packing.material
    si = f" E* ({1e-3 * packing.pressure * modulus(m):.6g} kPa)" if m.young > 0 else ""
    note(a, f"{job.source or job.grains} -> {job.target or job.grains}: {packing.n} grains, {len(packing.contacts)} "
            f"contacts in {packing.dim}D at p = {packing.pressure:g}{si}")
    return 0
