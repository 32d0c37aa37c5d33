"""sonopack plot: draws figures of tables, signals and packings."""
from __future__ import annotations

import argparse
import os
import re
import textwrap
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .._command import DONE, Failed, Parser, may_write, note, number, usage
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
    _check_frames(arguments, given)
    paths = _paths(arguments, given)
    words: dict[str, Any] = {"scene": Parser("plot", kind.sets).scene(arguments)} if kind.sets or arguments.set else {}
    look = {"title": arguments.title, "x": _limits("--x", arguments.x), "y": _limits("--y", arguments.y),
            "log": arguments.log, "linear": arguments.linear}
    from ._inputs import Input
    files = [Input(path) for path in arguments.files]
    si = arguments.units == "si"
    material = _material(arguments, files) if si or _has_quantity(given) else None
    words |= _numbers(given, material, arguments)
    if si:
        words["material"] = material
        for one in files:
            one.material = material
    if arguments.label:
        words["labels"] = arguments.label
    _draw(arguments, kind, files, words, look, paths)
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
    """Raises the first of what is wrong."""
    files, store, name = arguments.files, given.get("store"), f"plot {arguments.kind}"
    count, labels = 1 if store else len(files), arguments.label
    wrong = {
        "%s: must be a file or --store, not both" % (*files, "")[0]: store and files,
        f"{name}: no file to draw": not store and not files,
        f"{name}: {len(files)} files, must be at most {kind.most}": len(files) > kind.most,
        f"{name}: needs a packing and a table of its grains": len(files) < kind.needs,
        f"--set: no key of a scene changes a figure of {arguments.kind}": arguments.set and not kind.sets,
        "no -o FILE: must end in .svg, .png or .pdf": not arguments.output,
        "--format: applies only to tables; a figure has the format of its ending": arguments.format,
        f"--table {arguments.output}: must be another file than the figure": given.get("table") == arguments.output,
        "--published and --no-published: must be one of them": {"published", "no-published"} <= set(given),
        f"--label {(*labels, '')[-1]:.60}: {len(labels)} label(s) for {count} file(s), must be one for each":
            labels and len(labels) != count}
    for text, is_wrong in wrong.items():
        if is_wrong:
            raise usage(text)


def _check_frames(arguments: argparse.Namespace, given: dict[str, Any]) -> None:
    late, stray = ([name for name in names if name in given] for names in (("from", "to"), ("table", "time")))
    if "frames" not in given and late:
        raise usage(f"--{late[0]}: needs --frames")
    if "frames" in given and stray:
        raise usage(f"--frames {given['frames']}: a movie takes no --{stray[0]}")
    if "frames" in given and arguments.kind == "snapshot" and len(arguments.files) > 1:
        raise usage(f"--frames {given['frames']}: the table {arguments.files[1]} has one time only")


def _limits(option: str, text: str | None) -> tuple[float | None, float | None] | None:
    if text is None:
        return None
    low, colon, high = text.partition(":")
    if not colon or len(text) < 2:
        raise usage(f"{option} {text:.60}: must be LO:HI, LO: or :HI")
    try:
        first, last = (number(-1.8e308, 1.8e308)(part) if part else None for part in (low, high))
    except argparse.ArgumentTypeError as fault:
        raise usage(f"{option} {fault}") from None
    if first is not None and last is not None and first >= last:
        raise usage(f"{option} {text:.60}: is an empty range, the first limit must be below the second")
    return first, last


# ---- numbers and materials ------------------------------------------------------------------------------------------

def _has_quantity(given: dict[str, Any]) -> bool:
    """Whether a number has a unit, for which a material is needed."""
    return any(OPTIONS[name].unit and re.search(r"[A-Za-z]$", str(value).strip()) for name, value in given.items())


def _numbers(given: dict[str, Any], material: Material | None, arguments: argparse.Namespace) -> dict[str, Any]:
    """The values of options, by the names that functions have for them."""
    words = {}
    for name, value in given.items():
        unit, read = OPTIONS[name].unit, OPTIONS[name].read
        try:
            if _has_quantity({name: value}):
                value = repr(quantity(value, unit, material or arguments.material))
            words[_WORDS.get(name, name)] = read(value) if isinstance(value, str) else value
        except (InvalidInput, argparse.ArgumentTypeError) as fault:
            raise usage(f"--{name} {fault}") from None
    if words.pop("no-published", False):
        words["published"] = False
    if "start" in words and "end" in words and words["start"] >= words["end"]:
        raise usage(f"--from {words['start']:g}: must be below --to {words['end']:g}")
    return words


_WORDS = {"from": "start", "to": "end"}


def _material(arguments: argparse.Namespace, files: Sequence[Input]) -> Material:
    """The material of --material, or the one that all files have."""
    own = [(arguments.material or one.own_material(), one.name) for one in files] or [(arguments.material, "the store")]
    for material, name in own:
        if material is None:
            raise usage(f"--units si: needs a material, and {name} has none: give it, as in --material "
                        f"E=70e9,nu=0.22,rho=2500,d=1e-3 (Pa, kg/m^3, m)")
        if material != own[0][0]:
            raise usage(f"{own[0][1]} and {name} are of different materials: choose one by --material")
    assert own[0][0] is not None
    return own[0][0]


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


def _paths(arguments: argparse.Namespace, given: dict[str, Any]) -> list[str]:
    """The files of the figure, which may be written, as may that of --table."""
    frames = int(_numbers({"frames": given["frames"]}, None, arguments)["frames"]) if "frames" in given else 0
    paths = frame_paths(arguments.output, frames) if frames else [arguments.output]
    for path in paths:
        may_write(arguments, path, ENDINGS)
    if "table" in given:
        may_write(arguments, given["table"], (".tsv", ".csv", ".json"))
    return paths


def _draw(arguments: argparse.Namespace, kind: Kind, files: Sequence[Input], words: dict[str, Any],
          look: dict[str, Any], paths: Sequence[str]) -> None:
    function = kind.function(arguments.kind)
    from ._frame import apply_look, figure_of, save
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", UserWarning)
        try:
            drawn = function(*files, **words)
            for path, axes in zip(paths, drawn if "frames" in words else (drawn,)):
                apply_look(figure_of(axes), **look)
                save(figure_of(axes), path)
        except InvalidInput as fault:
            raise _blame(fault, arguments) from None
    for text in dict.fromkeys(str(one.message) for one in told if issubclass(one.category, UserWarning)):
        if not text.startswith("Glyph"):
            note(arguments, text)


def _blame(fault: InvalidInput, arguments: argparse.Namespace) -> Exception:
    """What the library finds wrong in a file is the file's fault, not one of usage, unless it names an option."""
    text = str(fault)
    if text.startswith("--") or fault.status != Status.EINVAL:
        return fault
    first = arguments.files[0] if arguments.files else arguments.own_store
    return Failed(text if first in text else f"{first}: {text}")
