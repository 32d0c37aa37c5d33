"""What the commands in Python share: options, scenes, units, messages, files that appear whole, exit statuses.

`sonopack plot`, `view`, `convert`, `reproduce`, `trace` and `bench` execute `sonopack-NAME`, which calls start(NAME). Each has a module
with parser(), which returns a Parser, and run(arguments), which does the work.
"""
from __future__ import annotations

import argparse
import contextlib
import difflib
import importlib
import os
import pathlib
import re
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NoReturn

from . import __version__
from ._core import SonopackError, Status, c_path, invalid
from ._native import lib
from ._records import Material
from ._scene import Scene, SceneText, scene_help
from ._table import Table, material_of, quantity

DONE, FAILED, USAGE = 0, 1, 2
STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # signals that end a command, after which no draft is left

#: the module of each command
MODULES = {"plot": "plot.command", "view": "view.command", "convert": "formats.command", "reproduce": "papers.command", "trace": "traces.command",
           "pack-lammps": "formats.engine", "modes-slepc": "engines.modes", "moduli-petsc": "engines.moduli",
           "signal-petsc": "engines.signals", "bench": "bench", "demo": "demo", "save-table": "formats.tables"}

#: which Debian package brings a module
DEBIAN = {"matplotlib": "python3-matplotlib", "pandas": "python3-pandas", "scipy": "python3-scipy", "h5py": "python3-h5py",
          "petsc4py": "python3-petsc4py-real", "slepc4py": "python3-slepc4py-real"}



class Failed(SonopackError):
    """The work failed (exit status 1): a file or a value at fault, and what would be right."""

    def __init__(self, text: str) -> None:
        super().__init__(text, Status.EFAILED)


def usage(text: str) -> SonopackError:
    """The command line is wrong (exit status 2)."""
    return invalid("", text)


def program() -> pathlib.Path:
    """The command sonopack: beside this program in the folder of a build, else in bin of the installation."""
    here = pathlib.Path(os.path.realpath(sys.argv[0])).parent
    for place in (here, here.parents[1] / "bin"):
        if os.access(place / "sonopack", os.X_OK):
            return place / "sonopack"
    raise Failed(f"{here}: no command sonopack beside it or in {here.parents[1] / 'bin'}")


# ---- options --------------------------------------------------------------------------------------------------------

class Parser(argparse.ArgumentParser):
    """Options of one command, the common ones included. groups: those of a scene's keys that --set may change. springs: takes
    --threshold and --prestress, which are keys of the scene. Parsed arguments have it as `words`."""

    def __init__(self, name: str, groups: str = "", *, springs: bool = False, **words: Any) -> None:
        super().__init__(prog=f"sonopack {name}", formatter_class=argparse.RawDescriptionHelpFormatter, add_help=False,
                         **words)
        self.command = name
        self.set_defaults(words=self)
        if springs:
            group = self.add_argument_group("Springs")
            group.add_argument("--threshold", metavar="F",
                               help="use only contacts with a normal force above F p d^2 (1e-4)")
            group.add_argument("--prestress", action="store_true",
                               help="include the effect of the forces at rest when contacts rotate")
        common = self.add_argument_group("Common options")
        common.add_argument("-o", "--output", metavar="FILE", help="write to FILE; its ending sets the format")
        common.add_argument("--force", action="store_true", help="replace an existing file of the same kind")
        common.add_argument("--format", choices=("tsv", "csv", "json"), help="format of the table (tsv)")
        common.add_argument("--digits", metavar="all|N", type=_digits, default=lib.SP_DIGITS_OF_ERRORS,
                            help="digits of a table on a terminal (two of the errors, at most six); files and pipes "
                                 "have all")
        common.add_argument("--set", metavar="KEY=VALUE", action="append", default=[],
                            help="override a key of the scene (repeatable; see `sonopack help scene')")
        common.add_argument("--threads", metavar="N", type=whole(0, 1024), default=0,
                            help="number of threads (one per core)")
        common.add_argument("--units", choices=("own", "si"), default="own",
                            help="own, in d, E* and rho, or SI, for which a material is needed (own)")
        common.add_argument("--material", metavar="E=..,nu=..,rho=..,d=..", type=option(material_of),
                            help="material of the grains, in Pa, kg/m^3 and m, instead of that of scene or file")
        common.add_argument("-q", "--quiet", action="store_true", help="print no messages and no progress")
        common.add_argument("-v", "--verbose", action="store_true", help="print more messages")
        common.add_argument("-h", "-?", "--help", action="help", help="print this help")
        common.add_argument("--usage", action=_Usage, nargs=0, help="print the options in short")
        common.add_argument("-V", "--version", action="version", version=f"sonopack {__version__}",
                            help="print the version")
        common.add_argument("--words", action=_Words, nargs=0, help=argparse.SUPPRESS)
        self.groups = groups.split()

    def error(self, message: str) -> NoReturn:
        raise usage(message.removeprefix("argument "))

    def set_type(self, name: str, read: Callable[[str], Any]) -> None:
        """Gives a common option another type."""
        self._option_string_actions[name].type = read

    def scene(self, arguments: argparse.Namespace) -> Scene:
        """The scene of --set, in which keys may stand without the name of their group."""
        return Scene.read(None, self.keys(arguments))

    def keys(self, arguments: argparse.Namespace) -> dict[str, Any]:
        """Keys of the scene that the command line gives, with their values."""
        if arguments.set and not self.groups:
            raise usage("--set: no key of a scene changes anything here")
        found = dict(_setting(text, self.groups) for text in arguments.set)
        if getattr(arguments, "threshold", None) is not None:
            found["network.threshold"] = SceneText(arguments.threshold)
        if getattr(arguments, "prestress", False):
            found["network.prestress"] = True
        return found


class _Usage(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        parser.print_usage()
        parser.exit()


class _Words(argparse.Action):
    """The words that completion offers, one a line: options, then what the first argument may be."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        for action in parser._actions:
            if action.help is argparse.SUPPRESS:
                continue
            words = [word for word in action.option_strings if word.startswith("--")] or action.choices or ()
            print(*words, sep="\n", end="\n" if words else "")
        parser.exit()


def option(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """The type of an option whose text a function of the library reads, so that its reason is told."""

    def convert(text: str) -> Any:
        try:
            return read(text)
        except SonopackError as fault:
            raise argparse.ArgumentTypeError(str(fault)) from None
    return convert


def whole(low: int, high: int) -> Callable[[str], int]:
    """The type of an option that takes an integer between two."""

    def read(text: str) -> int:
        if not re.fullmatch(r"[+-]?\d+", text) or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"{text:.60}: must be an integer {low} .. {high}")
        return int(text)
    return read


def _digits(text: str) -> int:
    """The type of --digits."""
    return int(lib.SP_DIGITS_ALL) if text == "all" else whole(1, 17)(text)


def number(low: float, high: float) -> Callable[[str], float]:
    """The type of an option that takes a finite number between two."""

    def read(text: str) -> float:
        if not re.fullmatch(r"[0-9+\-.eE]+", text):
            raise argparse.ArgumentTypeError(f"{text:.60}: must be a number {low:g} .. {high:g}")
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text:.60}: must be a number {low:g} .. {high:g}")
        return value
    return read


def cores() -> int:
    """How many cores this process may use: what --threads 0 means."""
    return len(os.sched_getaffinity(0))


def amount(name: str, text: str, unit: str, span: tuple[float, float], material: Material | None) -> float:
    """The number of an option that is in our own unit, or has a unit of its own, as in "50 us", for which a material is needed."""
    try:
        value = float(text) if re.fullmatch(r"[0-9+\-.eE]+|nan|inf", text) else quantity(text, unit, material)
    except (ValueError, SonopackError) as fault:
        raise usage(f"{name} {text:.60}: {fault}") from None
    if not span[0] <= value <= span[1]:
        raise usage(f"{name} {text:.60}: must be {span[0]:g} .. {span[1]:g} {unit}")
    return value


def _setting(text: str, groups: Sequence[str]) -> tuple[str, Any]:
    key, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not key:
        raise usage(f"--set {text:.60}: must be KEY=VALUE")
    if "." in key and key.split(".")[0] not in groups:
        raise usage(f"--set {text:.60}: must be a key of {' or '.join(groups)}")
    return key if "." in key else _whole_key(key, groups), SceneText(value)


def _whole_key(key: str, groups: Sequence[str]) -> str:
    """The key of these groups that is given without its group."""
    keys = {name: f"{group}.{name}" for group, name in re.findall(r"^(\w+)\.(\w+) =", scene_help(), re.M) if group in groups}
    if key not in keys:
        near = difflib.get_close_matches(key, keys, 1)
        hint = f": did you mean {keys[near[0]]}?" if near else f" of {' or '.join(groups)}"
        raise usage(f"--set {key:.60}: unknown key{hint}")
    return keys[key]


# ---- messages -------------------------------------------------------------------------------------------------------

def note(arguments: argparse.Namespace, text: str) -> None:
    """A message on stderr, unless --quiet is given."""
    if not arguments.quiet:
        print(f"sonopack: {text}", file=sys.stderr)


_drafts: set[str] = set()


def _stop(number: int, _: object) -> None:
    """A signal ends the command, which first takes its drafts away. No exception: libraries would catch it."""
    for draft in _drafts:
        with contextlib.suppress(OSError):
            os.unlink(draft)
    _end_by(number)


def start(name: str) -> NoReturn:
    """Runs the command NAME with the arguments of the process, and ends the process with its status."""
    status = FAILED
    try:
        module = importlib.import_module(f"sonopack.{MODULES[name]}")
        parser = module.parser()
        for number in STOPS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, _stop)
        status = module.run(parser.parse_intermixed_args(sys.argv[1:])) or DONE
        sys.stdout.flush()
    except SonopackError as fault:
        print(f"sonopack: {_tame(str(fault))}", file=sys.stderr)
        status = USAGE if fault.status == Status.EINVAL else FAILED
    except ModuleNotFoundError as fault:
        package = DEBIAN.get(str(fault.name).split(".")[0], f"the Python module {fault.name}")
        print(f"sonopack: {name} needs {package}, which is not installed", file=sys.stderr)
    except BrokenPipeError:
        _end_by(signal.SIGPIPE)
    except KeyboardInterrupt:
        _end_by(signal.SIGINT)
    except MemoryError:
        print("sonopack: out of memory", file=sys.stderr)
    except OSError as fault:
        place = f"{fault.filename}: " if fault.filename else ""
        print(f"sonopack: {_tame(place + (fault.strerror or str(fault)))}", file=sys.stderr)
    sys.stderr.flush()
    os._exit(status) # the library's threads and the drafts of stdout have nothing left to say


def _end_by(number: int) -> None:
    """Ends the process as the signal does by default, so that a shell sees it."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


def _tame(text: str) -> str:
    """A terminal obeys control characters, which names of files may have."""
    return "".join(c if c.isprintable() else "?" for c in text.encode(errors="replace").decode())


# ---- files ----------------------------------------------------------------------------------------------------------

_MAGIC = {b"\211HDF\r\n\032\n": "hdf5", b"\211PNG\r\n\032\n": "png", b"%PDF-": "pdf", b"MATLAB 5": "mat", b"\x1f\x8b": "gz"}
_KINDS = {".h5": "hdf5", ".hdf5": "hdf5", ".png": "png", ".pdf": "pdf", ".mat": "mat", ".sac": "sac", ".gz": "gz",
          ".json": "json",
          ".txt": "packing", **dict.fromkeys((".svg", ".html", ".htm", ".vtp", ".pvd", ".vtm"), "markup")}


def _kind_of(head: bytes) -> str:
    """The kind of a file that begins like this."""
    for magic, kind in _MAGIC.items():
        if head.startswith(magic):
            return kind
    if b"\0" in head:
        return "sac" if head[304:308] in (b"\6\0\0\0", b"\0\0\0\6") else "unknown"
    if re.match(rb"(\s*#[^\n]*\n)*\s*(# packing(?! =)|N +\d+ +Lx )", head):
        return "packing"
    first = head.lstrip()[:1]
    return "markup" if first == b"<" else "json" if first in (b"{", b"[") else "text"


def may_write(arguments: argparse.Namespace, path: str, kinds: Sequence[str] | None, ending: str | None = None) -> None:
    """Refuses a file whose ending is none of `kinds` (None: of any), which exists without --force, or is of another kind than
    its ending says. ending: what counts as the ending instead. Call before the work."""
    ending = ending or os.path.splitext(path)[1].lower()
    if not path:
        raise usage("-o: the file name is empty")
    if kinds is not None and ending not in kinds:
        raise usage(f"-o {path}: the ending must be {' or '.join(filter(None, (', '.join(kinds[:-1]), kinds[-1])))}")
    place = pathlib.Path(path)
    if place.is_dir():
        raise usage(f"{path}: is a folder, must be a file")
    if place.is_file():
        with open(place, "rb") as file:
            head = file.read(4096)
        if head and _kind_of(head) != _KINDS.get(ending, "text"):
            raise usage(f"{path}: is a file of another kind than its ending says, and is not replaced: choose another name")
        if head and ending in (".h5", ".hdf5") and lib.sp_modes_file_looks(c_path(path)):
            raise usage(f"{path}: is a file of modes, and is not replaced: choose another name")
        if not arguments.force:
            raise usage(f"{path}: exists already: choose another name, or use --force")
    if not os.access(place.parent, os.W_OK | os.X_OK):
        raise Failed(f"cannot write in {place.parent}: no such folder, or no permission")


@contextlib.contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[str]:
    """A name to write to, in the folder of `path`. At the end the file gets its own name; after a failure it is gone."""
    place = pathlib.Path(path)
    if place.exists() and not place.is_file():  # a device or a pipe
        yield str(place)
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)  # until the draft is noted
    try:
        handle, draft = tempfile.mkstemp(prefix=f".{place.name[:100]}.", suffix=place.suffix, dir=place.parent)
        _drafts.add(draft)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    try:
        os.close(handle)
        yield draft
        with open(draft, "rb+") as file:
            os.fsync(file.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(draft, 0o666 & ~mask)
        os.replace(draft, place)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(draft)
        raise
    finally:
        _drafts.discard(draft)


def write_table(arguments: argparse.Namespace, table: Table, material: Material | None = None) -> None:
    """Prints a table, or writes it to -o in the format of its ending; in SI units where asked for."""
    if arguments.units == "si":
        table = table.si(arguments.material or material)
    if arguments.output:
        table.save(arguments.output)
    else:
        aligned = arguments.format is None and sys.stdout.isatty() and "OMPI_COMM_WORLD_SIZE" not in os.environ
        sys.stdout.write(table.aligned(arguments.digits) if aligned else table.text(arguments.format or "tsv"))

