"""pack --engine lammps: writes the files of a run, runs LAMMPS, reads what it has made, and brings it to our rest."""
from __future__ import annotations

import argparse
import copy
import ctypes
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np

from .. import __version__, _core, formats
from .._command import Failed, Parser, cores, may_write, note, usage, whole, write_table
from .._core import SonopackError, Status, call, text_of
from .._native import ffi, lib
from .._packing import Packing
from .._records import Material
from .._scene import Scene, SceneText
from .._table import Table
from . import deck
from ._faults import bad_file
from .options import Options

_GRACE = 20.0  # seconds: mpirun needs some to end its ranks
_MOVING = 0.05  # above this acceleration over the pressure grains still move: LAMMPS has taken all its steps
_TOLERANCE, _THRESHOLD = 2e-5, 1e-4  # of `sonopack check'
_PART = 65536


def parser() -> Parser:
    """The options of `sonopack pack', which has checked them."""
    p = Parser("pack", groups="packing network signal study material", usage="%(prog)s [SCENE] --engine lammps -o FILE")
    add = p.add_argument
    add("scene", nargs="*", metavar="SCENE")
    add("--seed", metavar="S", type=whole(0, 9_300_000_000_000_000_000))
    add("--state-every", metavar="SECONDS")
    add("--dry-run", action="store_true")
    add("--engine", choices=("lammps",))
    add("--ranks", metavar="N", type=whole(1, 1_000_000), default=0)
    for name, value in (("--lammps", "PATH"), ("--prepare", "DIR"), ("--collect", "DIR")):
        add(name, metavar=value)
    return p


def _check(a: argparse.Namespace) -> None:
    """Options that contradict each other."""
    apart = "--prepare" if a.prepare else "--collect"
    for wrong, text in (
            (a.prepare and a.collect, "--prepare and --collect: must be two commands, with LAMMPS between them"),
            ((a.prepare or a.collect) and (a.lammps or a.ranks),
             f"{apart}: does not run LAMMPS, so that --lammps and --ranks are not for it"),
            (a.prepare and a.output, "--prepare: makes no packing, -o is not for it but for --collect"),
            (a.collect and (a.scene or a.set or a.seed is not None),
             f"--collect: takes the scene and the seed of --prepare from {a.collect}/{deck.SCENE}: no others may be "
             "given"),
            (a.dry_run, "--dry-run: what LAMMPS will take is not known, --engine must be sonopack"),
            (not a.output and not a.prepare, "no output: must be -o FILE.h5 or -o FILE.txt"),
            (len(a.scene) > 1, f"{len(a.scene)} files; must be one scene")):
        if wrong:
            raise usage(text)
    if a.output:
        may_write(a, a.output, (".h5", ".hdf5", ".txt"))


def _scene(a: argparse.Namespace) -> tuple[Scene, Any]:
    """The scene, whose lists must stay alive, and its struct, resolved."""
    path = os.path.join(a.collect, deck.SCENE) if a.collect else a.scene[0] if a.scene else None
    keys = a.words.keys(a)
    if a.material is not None:
        keys["material"] = SceneText(_material_text(a.material))
    scene = Scene.read(path, keys)
    struct = scene.resolved()
    if a.seed is not None:
        _core.set_fields(struct.pack, {"seed": a.seed})
    if a.units == "si" and not struct.material.young > 0:
        raise usage("--units si: needs a material, and the scene has none: give it, as in --material "
                    "E=70e9,nu=0.22,rho=2500,d=1e-3 (Pa, kg/m^3, m)")
    return scene, struct


def _material_text(material: Material) -> str:
    text = ffi.new("char[]", int(lib.SP_MATERIAL_TEXT))
    lib.sp_material_text(ffi.new("sp_material *", vars(material)), text)
    return text_of(text)


def run(a: argparse.Namespace) -> int:
    """Prepares a run, collects what it has left, or does both and runs LAMMPS in between."""
    _check(a)
    scene, struct = _scene(a)
    spec = ffi.addressof(struct, "pack")
    height = lib.sp_packing_expect(spec, 1, ffi.new("sp_machine *", lib.sp_machine_reference())).height
    if not a.collect and spec.kind == lib.SP_PACK_PISTON and spec.dim > 1 and height < 6:
        note(a, f"warning: the box will be about {height:.1f} d high, less than 6: sound has no room between the walls")
    if a.prepare:
        _prepare(a, struct, pathlib.Path(a.prepare))
        note(a, f"{a.prepare}: run `lmp -nocite -in {deck.INPUT}' there (mpirun -n N before it), then `sonopack pack "
                f"--engine lammps --collect {a.prepare}'")
        return 0
    folder = pathlib.Path(a.collect or f"{a.output}.lammps")
    words = None if a.collect else _find(a)
    if words:
        _prepare(a, struct, folder)
    packing = _make(a, struct, folder, words)
    packing.save_as(a.output, os.path.splitext(a.output)[1])
    if words:
        _remove(folder)
        folder.rmdir()
    _summarise(a, packing, struct.network.threshold)
    del scene
    return 0


# ---- the folder -----------------------------------------------------------------------------------------------------

def _remove(folder: pathlib.Path) -> None:
    for name in deck.FILES:
        (folder / name).unlink(missing_ok=True)


def _scene_text(struct: Any, group: Any = ffi.NULL) -> bytes:
    """The scene of a struct as a text."""
    chars = ffi.gc(lib.sp_scene_text(struct, group), lib.sp_free)
    text: bytes = ffi.string(chars)
    return text


def _prepare(a: argparse.Namespace, struct: Any, folder: pathlib.Path) -> None:
    """Writes the files of a run. A folder that has some is only used again with --force."""
    files = {**deck.files(ffi.addressof(struct, "pack")), deck.SCENE: _scene_text(struct)}
    if folder.exists() and not folder.is_dir():
        raise Failed(f"{folder}: must be a folder, for the files of LAMMPS")
    if any(os.path.lexists(folder / name) for name in deck.FILES):
        if not a.force:
            raise Failed(f"{folder}: has the files of a run of LAMMPS: --collect {folder} reads them, --force replaces "
                         f"them")
        _remove(folder)
    folder.mkdir(exist_ok=True)
    for name, data in files.items():
        (folder / name).write_bytes(data)


def _look(folder: pathlib.Path, name: str) -> pathlib.Path:
    """The path of a file; a pipe in a folder of someone else's would keep us waiting."""
    path = folder / name
    if path.exists() and not path.is_file():
        raise bad_file(f"{path}: must be a regular file")
    return path


# ---- LAMMPS ---------------------------------------------------------------------------------------------------------

def _program(name: str, why: str) -> str:
    """The absolute path, for the program starts in another folder."""
    found = shutil.which(name)
    if found is None:
        raise Failed(f"{why}: {name}: {'no program that can be run' if '/' in name else 'no such program in PATH'}")
    return os.path.realpath(found)


def _find(a: argparse.Namespace) -> list[str]:
    """The words that start LAMMPS, by mpirun on several ranks."""
    lammps = _program(a.lammps or "lmp", "LAMMPS (Debian: apt install lammps; another program: --lammps PATH)")
    launcher = [_program("mpirun", f"--ranks {a.ranks}"), "-n", str(a.ranks)] if a.ranks > 1 else []
    return [*launcher, lammps, "-nocite", "-in", deck.INPUT, "-log", deck.LOG]


class _Show:
    """Progress on a terminal, and what Ctrl-C and SIGTERM ask for: LAMMPS is ended before the command."""

    def __init__(self, quiet: bool) -> None:
        self.asked, self.shows = False, sys.stderr.isatty() and not quiet
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._ask)

    def _ask(self, *_: Any) -> None:
        self.asked = True

    def __call__(self, text: str = "") -> None:
        if self.shows:
            print(f"\r{text}\033[K", end="", file=sys.stderr, flush=True)

    def of_packing(self, now: Any) -> bool:
        """Progress of our own compression; False stops it."""
        self(f"{now.phase}: {now.steps:.0f} steps, residual {now.residual:.2g}")
        return not self.asked


def _begin() -> None:
    """In the child: it ends with its parent, however that ends."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)  # what is ignored would stay so


def _execute(words: list[str], folder: pathlib.Path, show: _Show) -> float:
    """Runs LAMMPS on the files of the folder; returns its CPU time. However this ends, no process is left, and the
    files are."""
    with open(folder / deck.WORDS, "wb") as printed:
        try:
            child = subprocess.Popen(words, cwd=folder, stdin=subprocess.DEVNULL, stdout=printed, stderr=printed,
                                     start_new_session=True, preexec_fn=_begin)
        except OSError as fault:
            raise Failed(f"{words[0]}: cannot be started: {fault.strerror}") from None
    asked, pause = 0.0, 0.002
    while not (ended := os.wait4(child.pid, os.WNOHANG))[0]:
        if show.asked and not asked:
            asked = time.monotonic()
            _kill(child.pid, signal.SIGTERM)
        if asked and time.monotonic() - asked > _GRACE:
            _kill(child.pid, signal.SIGKILL)
        log = _Log(folder)
        show(f"LAMMPS: {max(log.steps, 0)} steps, residual {log.acceleration:.2g}")
        time.sleep(pause)
        pause = min(0.2, 1.5 * pause)
    _, status, spent = ended
    child.returncode = os.waitstatus_to_exitcode(status)
    _kill(child.pid, signal.SIGKILL)  # what it may have left
    if asked:
        raise SonopackError("stopped while LAMMPS was running", Status.EINTERRUPTED)
    if child.returncode != 0:
        _fail(words[-6], folder, child.returncode)
    return float(spent.ru_utime + spent.ru_stime)


def _kill(group: int, number: signal.Signals) -> None:
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        pass


class _Log:
    """What the log tells so far: version, fault, and the last row of thermodynamic output."""

    def __init__(self, folder: pathlib.Path) -> None:
        texts = [_part(folder, name, end) for end in (False, True) for name in (deck.LOG, deck.WORDS)]
        version = next(filter(None, (re.search(r"LAMMPS \(([^)\n]*)", text) for text in texts[:2])), None)
        fault = next(filter(None, (re.search(r"^ERROR.*", text, re.M) for text in texts[:1:-1])), None)
        rows = re.findall(r"^ *(\d{1,18}) +([-+.\deE]+) +[-+.\deE]+ *\n", texts[2], re.M)
        self.version, self.fault = version.group(1)[:199] if version else "", fault.group(0)[:199] if fault else ""
        self.steps, self.acceleration = (int(rows[-1][0]), float(rows[-1][1])) if rows else (-1, math.nan)


def _part(folder: pathlib.Path, name: str, end: bool) -> str:
    """The beginning of a file, or its end. Empty if it cannot be read."""
    try:
        with open(_look(folder, name), "rb") as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - _PART) if end else 0)
            return re.sub(r"[\0-\x08\x0b-\x1f]", " ", file.read(_PART).decode(errors="replace"))
    except (OSError, ValueError):
        return ""


def _fail(program: str, folder: pathlib.Path, status: int) -> None:
    """Says why LAMMPS failed."""
    log = _Log(folder)
    killed = f"was killed by signal {-status} ({signal.strsignal(-status)})" if status < 0 else ""
    how = killed or f"ended with status {status}"
    text = f"{program} {how} after {max(log.steps, 0)} steps: {log.fault or f'it gives no reason, see {deck.WORDS}'}"
    if any(sign in log.fault for sign in ("granular", "Unknown", "Unrecognized", "Illegal", "Invalid")):
        text += (f"; this is LAMMPS {log.version or 'of an unknown version'}, and what is needed is pair_style "
                 "granular of LAMMPS of 29 Sep 2021 or later, with its package GRANULAR")
    raise Failed(text)


# ---- what it has made -----------------------------------------------------------------------------------------------

def _make(a: argparse.Namespace, struct: Any, folder: pathlib.Path, words: list[str] | None) -> Packing:
    show = _Show(a.quiet)
    try:
        seconds = _execute(words, folder, show) if words else 0.0
        steps, version, packing = _collect(a, struct.pack, folder, show)
    except (SonopackError, OSError) as fault:
        raise Failed(f"the files are in {folder}: {fault}") from None  # the command line was right
    finally:
        show()
    p = packing._c
    p.seed, p.seconds, p.material = struct.pack.seed, p.seconds + seconds, struct.material
    p.steps += steps
    ranks = f", {a.ranks} ranks" if a.ranks else ""
    text = f"# engine: LAMMPS ({version}){ranks}, {steps} steps; brought to rest by sonopack {__version__}\n"
    lib.sp_free(p.scene)
    p.scene = lib.strdup(text.encode() + _scene_text(struct, b"packing"))
    return packing


def _read_result(folder: pathlib.Path, pressure: float) -> tuple[int, float]:
    """Steps and height at the end."""
    path = _look(folder, deck.RESULT)
    if not path.exists():
        raise bad_file(f"{path}: is missing or cannot be read: LAMMPS did not come to its end")
    number = r"([-+]?\d[\d.]*(?:[eE][-+]?\d+)?)"
    found = re.match(rf"steps (\d{{1,18}}) acceleration {number} top {number}\n",
                     path.read_bytes().decode(errors="replace"))
    if not found or not all(math.isfinite(float(word)) for word in found.groups()) or int(found.group(1)) == 0:
        raise bad_file(f"{path}: must be a line of steps, acceleration and top, all finite: is it cut, is the disk "
                       "full?")
    steps, acceleration, top = int(found.group(1)), float(found.group(2)), float(found.group(3))
    if acceleration > _MOVING * pressure:
        raise Failed(f"LAMMPS: not at rest after {steps} steps: the largest acceleration is {acceleration:.3g}, must "
                     f"be below {_MOVING * pressure:.3g} (packing.max_steps allows more steps)")
    return steps, top


def _collect(a: argparse.Namespace, given: Any, folder: pathlib.Path, show: _Show) -> tuple[int, str, Packing]:
    """Reads what LAMMPS has left in the folder, with the tangential forces, and brings it to rest under the pressure of
    the spec."""
    deck.check(ffi.addressof(given))
    s = lib.sp_pack_spec_resolve(ffi.addressof(given))
    steps, top = _read_result(folder, deck.pressure_of(s))
    keys: dict[str, Any] = {"dimension": str(s.dim), "wall": "rigid", "width": s.width, "bottom": 0.0, "top": top,
                            "pressure": deck.pressure_of(s), "friction": s.friction, "poisson": s.poisson}
    keys |= {"depth": s.depth} if s.dim == 3 else {}
    raw, _ = formats.load(str(_look(folder, deck.GRAINS)), Options(
        "lammps-dump", contacts=str(_look(folder, deck.CONTACTS)), types="1", keys=keys))
    _check_grains(raw, s, top)
    packing = _come_to_rest(raw, given, a.threads or cores(), show)
    audit, reason = ffi.new("sp_audit *"), ffi.new("char[]", 200)
    call(lib.sp_packing_audit, packing._c, _THRESHOLD, audit)
    worst = lib.sp_audit_worst(audit, _TOLERANCE, reason, 200)
    if text_of(reason):
        raise Failed(f"the packing at rest fails its audit by {worst:.3g}: {text_of(reason)}")
    return steps, _Log(folder).version or "of an unknown version", packing


def _check_grains(raw: Packing, s: Any, top: float) -> None:
    """The grains must be those of the spec; LAMMPS leaves out grains that leave the box. And the upper wall must rest
    on them: from a height that a file has made up it would fall for ever."""
    if raw.n != s.grains:
        raise bad_file(f"{deck.GRAINS}: {raw.n} grains, must be {s.grains} of the scene")
    r = deck.radii(s)
    other = np.flatnonzero(~(np.abs(r - raw.r) <= 1e-14 * r))
    if len(other):
        k = int(other[0])
        raise bad_file(f"{deck.GRAINS}: grain {k} has the diameter {2 * raw.r[k]:.17g}, must have {2 * r[k]:.17g}: is "
                       "this of another scene or seed?")
    highest = float((raw.x[:, s.dim - 1] + raw.r).max())
    if not abs(highest - top) <= 0.1:
        raise bad_file(f"{deck.RESULT}: top {top:g}, but the grains reach up to {highest:g}")


def _come_to_rest(raw: Packing, given: Any, threads: int, show: _Show) -> Packing:
    s = ffi.new("sp_pack_spec *", given)
    usual = lib.sp_pack_spec_default()
    s.kind = lib.SP_PACK_FILE
    for name in ("dim", "grains", "width", "depth", "sizes", "diameter_min", "diameter_max", "large_fraction",
                 "size_spread"):
        setattr(s, name, getattr(usual, name))  # what the grains are follows from the packing
    s.diameters, s.diameter_count, s.content, s.max_steps = ffi.NULL, 0, 0, 0
    call(lib.sp_pack_spec_from, s, raw._c)
    return Packing.of_spec(s, raw, progress=show.of_packing, threads=threads)


def _summarise(a: argparse.Namespace, p: Packing, threshold: float) -> None:
    """Prints the summary on stdout: -o is the file of the packing."""
    statics = p.statics(threshold)
    columns = {"grains": [p.n], "height": [p.height], "p": [p.pressure], "z_star": [statics.zs],
               "rattlers": [int(p.rattlers(threshold).sum())], "residual": [p.residual], "steps": [p.steps],
               "seconds": [p.seconds]}
    units = {"height": "d", "p": "E*", "residual": "E* / (rho d)", "seconds": "s"}
    printed = copy.copy(a)
    printed.output = None
    write_table(printed, Table.from_columns({name: np.array(value) for name, value in columns.items()}, units),
                p.material)
