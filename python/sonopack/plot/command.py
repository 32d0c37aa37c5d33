"""sonopack plot: draws figures of tables, signals and packings."""
from __future__ import annotations

import argparse
import os
import re
import textwrap
import warnings
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from .._command import DONE, Failed, Parser, may_write, note, number, usage, whole_file
from .._core import InvalidInput, Status
from .._records import Material
from .._table import quantity
from .kinds import KINDS, OPTIONS, Kind

if TYPE_CHECKING:
    from ._inputs import Input

ENDINGS = (".svg", ".png", ".pdf")


def parser() -> Parser:
    """The options of all kinds; run() refuses those that the kind does not have."""
    p = Parser("plot", usage="sonopack plot [OPTION...] KIND FILE... -o FIGURE\n"
                             "  or:  sonopack plot [OPTION...] ctof --store DIR -o FIGURE",
               description="Draws figures one print column (86 mm) wide, as PNG (300 dpi), SVG or PDF by the ending of "
                           "FIGURE.",
               epilog=_epilog())
    p._negative_number_matcher = re.compile(r"-[0-9.]")  # --x -1:5 has a value, not one more option
    p.add_argument("kind", metavar="KIND", choices=tuple(KINDS), help="kind of figure")
    p.add_argument("files", metavar="FILE", nargs="*", help="table or packing")
    own = p.add_argument_group("Options of kinds")
    for name, option in OPTIONS.items():
        kinds = ", ".join(kind for kind in KINDS if name in KINDS[kind].options)
        words: dict[str, Any] = {"metavar": option.value} if option.value else {"action": "store_true"}
        own.add_argument(f"--{name}", dest=f"own_{name}", help=f"{kinds}: {option.help}".replace("%", "%%"), **words)
    look = p.add_argument_group("Look")
    look.add_argument("--title", metavar="TEXT", default="", help="title above the figure")
    look.add_argument("--label", metavar="TEXT", action="append", default=[],
                      help="name of a file in the legend (repeatable: one for each file, in their order)")
    look.add_argument("--x", metavar="LO:HI", help="limits of the x axis, or LO: or :HI")
    look.add_argument("--y", metavar="LO:HI", help="limits of the y axis, of several panels that of the first")
    look.add_argument("--log", choices=("x", "y", "xy"), default="", help="make these axes logarithmic")
    look.add_argument("--linear", action="store_true", help="make the axes linear that --log does not name")
    return p


def _epilog() -> str:
    parts = [f"{name}: {kind.help}." for name, kind in KINDS.items()]
    parts += ["In three dimensions network, stiffness, sensitivity, mode and snapshot show three views: along y, along x "
              "and from above.",
              "--frames makes a movie of a mode (one period) or of a wave, one numbered file a frame, all at one scale.",
              "Axes have the units of the tables, or SI (--units si); tables of one figure must have the same."]
    return "\n".join(textwrap.fill(part, 79) for part in parts)


def run(arguments: argparse.Namespace) -> int:
    kind = KINDS[arguments.kind]
    given = _own_options(arguments, kind)
    _check(arguments, kind, given)
    _may_write(arguments, given)
    words = dict(given)
    scene = Parser("plot", kind.sets).scene(arguments) if kind.sets or arguments.set else None
    if scene is not None:
        words["scene"] = scene
    look = _look(arguments)
    from ._inputs import Input
    files = [Input(path) for path in arguments.files]
    material = _material(arguments, files) if arguments.units == "si" or _has_quantity(given) else None
    _numbers(words, material, arguments)
    if arguments.units == "si":
        words["material"] = material
        for one in files:
            one.material = material
    if arguments.label:
        words["labels"] = arguments.label
    _draw(arguments, kind, files, words, look)
    return DONE


# ---- the command line -----------------------------------------------------------------------------------------------

def _own_options(arguments: argparse.Namespace, kind: Kind) -> dict[str, Any]:
    """The options of kinds that are given, by name."""
    given = {name: getattr(arguments, f"own_{name}") for name in OPTIONS if getattr(arguments, f"own_{name}")}
    look = {name for name in ("x", "y", "log", "linear") if getattr(arguments, name)}
    stray = [name for name in given if name not in kind.options]
    stray += [] if kind.axes else sorted(look)
    stray += ["label"] if arguments.label and not kind.labels else []
    if stray:
        fitting = [name for name, other in KINDS.items() if stray[0] in other.options
                   or (stray[0] == "label" and other.labels) or (stray[0] in look and other.axes)]
        raise usage(f"--{stray[0]}: not for plot {arguments.kind}, only for plot {', '.join(fitting)}")
    return given


def _check(arguments: argparse.Namespace, kind: Kind, given: dict[str, Any]) -> None:
    files, store = arguments.files, given.get("store")
    if store and files:
        raise usage(f"{files[0]}: must be a file or --store, not both")
    if not store and not files:
        raise usage(f"plot {arguments.kind}: no file to draw")
    if len(files) > kind.most:
        raise usage(f"plot {arguments.kind}: {len(files)} files, must be at most {kind.most}")
    if len(files) < kind.needs:
        raise usage(f"plot {arguments.kind}: needs a packing and a table of its grains")
    if arguments.set and not kind.sets:
        raise usage(f"--set: no key of a scene changes a figure of {arguments.kind}")
    if not arguments.output:
        raise usage("no -o FILE: must end in .svg, .png or .pdf")
    if given.get("table") == arguments.output:
        raise usage(f"--table {given['table']}: must be another file than the figure")
    if given.get("published") and given.get("no-published"):
        raise usage("--published and --no-published: must be one of them")
    count = 1 if store else len(files)
    if arguments.label and len(arguments.label) != count:
        raise usage(f"--label {arguments.label[-1]:.60}: {len(arguments.label)} label(s) for {count} file(s), must be one "
                    f"for each")
    _check_column(arguments, given)
    _check_frames(arguments, given)


def _check_column(arguments: argparse.Namespace, given: dict[str, Any]) -> None:
    column = given.get("column", "")
    if arguments.kind == "column" and column and not re.fullmatch(r"y[1-9]\d*", column):
        raise usage(f"--column {column:.60}: must be y1, y2, ...")
    if arguments.kind == "spectrum" and column and column not in ("alpha", "k", "speed"):
        raise usage(f"--column {column:.60}: must be alpha, k or speed")


def _check_frames(arguments: argparse.Namespace, given: dict[str, Any]) -> None:
    late = next((name for name in ("from", "to") if name in given), None)
    if "frames" not in given:
        if late:
            raise usage(f"--{late}: needs --frames")
        return
    stray = next((name for name in ("table", "time") if name in given), None)
    if stray:
        raise usage(f"--frames {given['frames']}: a movie takes no --{stray}")
    if arguments.kind == "snapshot" and len(arguments.files) > 1:
        raise usage(f"--frames {given['frames']}: the table {arguments.files[1]} has one time only")


def _look(arguments: argparse.Namespace) -> dict[str, Any]:
    return {"title": arguments.title, "x": _limits("--x", arguments.x), "y": _limits("--y", arguments.y),
            "log": arguments.log, "linear": arguments.linear}


def _limits(option: str, text: str | None) -> tuple[float | None, float | None] | None:
    if text is None:
        return None
    low, colon, high = text.partition(":")
    if not colon or len(text) < 2:
        raise usage(f"{option} {text:.60}: must be LO:HI, LO: or :HI")
    try:
        limits = tuple(number(-1.8e308, 1.8e308)(part) if part else None for part in (low, high))
    except argparse.ArgumentTypeError as fault:
        raise usage(f"{option} {fault}") from None
    if None not in limits and limits[0] >= limits[1]:
        raise usage(f"{option} {text:.60}: is an empty range, the first limit must be below the second")
    return limits


# ---- numbers and materials ------------------------------------------------------------------------------------------

def _has_quantity(given: dict[str, Any]) -> bool:
    """Whether a number has a unit, for which a material is needed."""
    return any(OPTIONS[name].unit and re.search(r"[A-Za-z]$", value.strip()) for name, value in given.items()
               if isinstance(value, str))


def _numbers(words: dict[str, Any], material: Material | None, arguments: argparse.Namespace) -> None:
    """Reads the values of options, and gives them the names that functions have."""
    for name in [name for name in words if name in OPTIONS]:
        value, option = words.pop(name), OPTIONS[name]
        if option.unit and _has_quantity({name: value}):
            try:
                value = repr(quantity(value, option.unit, material or arguments.material))
            except InvalidInput as fault:
                raise usage(f"--{name} {fault}") from None
        try:
            words[_WORDS.get(name, name)] = option.read(value) if isinstance(value, str) else value
        except argparse.ArgumentTypeError as fault:
            raise usage(f"--{name} {fault}") from None
    if words.pop("no-published", False):
        words["published"] = False
    if "start" in words and "end" in words and words["start"] >= words["end"]:
        raise usage(f"--from {words['start']:g}: must be below --to {words['end']:g}")


_WORDS = {"from": "start", "to": "end"}


def _material(arguments: argparse.Namespace, files: Sequence[Input]) -> Material:
    """The material of --material, or the one that all files have."""
    found = arguments.material
    if found is None:
        own = [(one.own_material(), one.name) for one in files]
        lacking = next((name for material, name in own if material is None), None if own else "the store")
        if lacking is not None:
            raise usage(f"--units si: needs a material, and {lacking} has none: give it, as in --material "
                        f"E=70e9,nu=0.22,rho=2500,d=1e-3 (Pa, kg/m^3, m)")
        other = next((name for material, name in own if material != own[0][0]), None)
        if other is not None:
            raise usage(f"{own[0][1]} and {other} are of different materials: choose one by --material")
        found = own[0][0]
    return found


# ---- drawing --------------------------------------------------------------------------------------------------------

def frame_paths(output: str, frames: int) -> list[str]:
    """The files of a movie: "wave-%03d.png" becomes wave-001.png, "wave.png" wave-0001.png."""
    if "%" not in output:
        stem, ending = os.path.splitext(output)
        return [f"{stem}-{k + 1:04d}{ending}" for k in range(frames)]
    found = re.fullmatch(r"([^%]*)%(?:0([0-9]))?d([^%]*)", output)
    if not found:
        raise usage(f"-o {output}: frames are numbered at one %d or %04d in the name, or without one before the ending")
    head, digits, rest = found.groups()
    return [f"{head}{k + 1:0{int(digits or 1)}d}{rest}" for k in range(frames)]


def _may_write(arguments: argparse.Namespace, given: dict[str, Any]) -> None:
    output = arguments.output
    if arguments.format:
        raise usage("--format: applies only to tables; a figure has the format of its ending")
    paths = frame_paths(output, _frames(given)) if "frames" in given else [output]
    for path in paths:
        may_write(arguments, path, ENDINGS)
    if "table" in given:
        may_write(arguments, given["table"], (".tsv", ".csv", ".json"))


def _frames(given: dict[str, Any]) -> int:
    try:
        return int(OPTIONS["frames"].read(given["frames"]))
    except argparse.ArgumentTypeError as fault:
        raise usage(f"--frames {fault}") from None


def _draw(arguments: argparse.Namespace, kind: Kind, files: Sequence[Input], words: dict[str, Any],
          look: dict[str, Any]) -> None:
    function = kind.function(arguments.kind)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", UserWarning)
        try:
            drawn = function(*files, **words)
            _save_all(arguments, drawn, words, look)
        except InvalidInput as fault:
            raise _blame(fault, arguments) from None
    for text in dict.fromkeys(str(one.message) for one in told if issubclass(one.category, UserWarning)):
        if not text.startswith("Glyph"):
            note(arguments, text)


def _save_all(arguments: argparse.Namespace, drawn: Any, words: dict[str, Any], look: dict[str, Any]) -> None:
    from ._frame import Look, save
    paths = frame_paths(arguments.output, words["frames"]) if "frames" in words else [arguments.output]
    for path, fig in zip(paths, _figures(drawn, "frames" in words)):
        Look(**look).apply(fig)
        save(fig, path)


def _figures(drawn: Any, movie: bool) -> Iterator[Any]:
    """The figure of Axes, of an array of them, or of each that a movie makes."""
    import numpy as np
    for each in drawn if movie else (drawn,):
        yield np.ravel(np.asarray(each, object))[0].figure


def _blame(fault: InvalidInput, arguments: argparse.Namespace) -> Exception:
    """What the library finds wrong in a file is the file's fault, not one of usage, unless it names an option."""
    text = str(fault)
    if text.startswith("--") or fault.status != Status.EINVAL:
        return fault
    first = arguments.files[0] if arguments.files else arguments.own_store
    return Failed(text if first in text else f"{first}: {text}")
