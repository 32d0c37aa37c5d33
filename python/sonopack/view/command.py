"""sonopack view: writes one HTML file that shows packings, their modes and the wave in a browser."""
from __future__ import annotations

import argparse
import re

from .. import _command
from .._command import Parser, usage
from .._packing import Packing
from .._scene import Scene
from . import Choice, page
from ._data import FRAMES_MAX, MODES

_FILES_MAX = 8
_HIGHEST = 1000000

_HELP = """\
Writes one page that any browser with WebGL 2 opens, without a network: packings in two or three dimensions to turn and to
zoom, with force chains, modes that swing, and the wave after a pulse at the bottom wall with the force on the top wall
beside it."""

_MORE = """\
In the page the grains are coloured by pressure, contacts, radius, displacement or rotation, and contacts by force. Keys are
listed under "Keys" in it; its address leads to what is shown, such as PAGE.html#mode=3&t=0.5 or PAGE.html#wave&t=80.
Several packings are chosen from a list.

The wave has N frames, equally spaced, between which the page interpolates. Positions, forces and modes are rounded to 24
bits and frames to 16 bits of the largest displacement in each, which is enough to look at: for numbers use `sonopack modes'
and `sonopack signal'. If there are no modes or is no wave, the page says why; it is an error where an option asks for them.
With a material the page has a switch for SI units, and opens in them with --units si. --set takes keys of the groups
network and signal."""


def parser() -> Parser:
    """The options of the command."""
    words = Parser("view", groups="network signal", springs=True, description=_HELP, epilog=_MORE)
    words.add_argument("files", metavar="FILE", nargs="+", help=f"packings, at most {_FILES_MAX}")
    words.add_argument("--lowest", metavar="K", type=_command.whole(1, _HIGHEST),
                       help=f"show the K softest modes that are no zero modes ({MODES})")
    words.add_argument("--modes", metavar="A:B", type=_span,
                       help="show modes A to B, both included; 0 is the softest that is no zero mode")
    words.add_argument("--no-modes", action="store_true", help="leave the modes out")
    words.add_argument("--frames", metavar="N", type=_command.whole(2, FRAMES_MAX),
                       help="number of frames of the wave (200, or fewer so that they take less than 12 MB of the page)")
    words.add_argument("--until", metavar="T",
                       help="last time of the wave [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6), after the first front)")
    words.add_argument("--source", choices=("impulse", "velocity", "displacement"),
                       help="what the pulse imposes at the bottom wall (impulse)")
    words.add_argument("--no-wave", action="store_true", help="leave the wave out")
    return words


def _span(text: str) -> tuple[int, int]:
    """A:B, or a single number."""
    match = re.fullmatch(r"(\d{1,7})(?::(\d{1,7}))?", text)
    if not match:
        raise argparse.ArgumentTypeError(f"{text:.60}: must be A:B or a number")
    first, last = int(match[1]), int(match[2] or match[1])
    if not first <= last <= _HIGHEST:
        raise argparse.ArgumentTypeError(f"{text:.60}: must be A:B with A <= B <= {_HIGHEST}")
    return first, last


def run(arguments: argparse.Namespace) -> None:
    """Writes the page."""
    _check(arguments)
    _command.may_write(arguments, arguments.output, (".html", ".htm"))
    scene = arguments.words.scene(arguments)
    damping = scene.options("signal")["damping"]
    if damping != 0:
        raise usage(f"signal.damping = {damping:g}: must be 0, the frames are without damping")
    packings = {path: _packing(arguments, path) for path in arguments.files}
    choices = {path: _choice(arguments, scene, packing) for path, packing in packings.items()}
    text = page(packings, choices, si=arguments.units == "si",
                missing=lambda name, reason: _command.note(arguments, f"{name}: left out of the page: {reason}"))
    with _command.whole_file(arguments.output) as draft, open(draft, "w", encoding="utf-8") as file:
        file.write(text)


def _check(arguments: argparse.Namespace) -> None:
    wave = {"frames": arguments.frames, "until": arguments.until, "source": arguments.source}
    modes = {"lowest": arguments.lowest, "modes": arguments.modes}
    for flag, without, others in ((arguments.no_modes, "--no-modes", modes), (arguments.no_wave, "--no-wave", wave)):
        given = [name for name, value in others.items() if value is not None]
        if flag and given:
            raise usage(f"{without}: must not be given with --{given[0]}")
    if None not in modes.values():
        raise usage("--lowest and --modes: must not both be given")
    if arguments.format:
        raise usage("--format: applies only to tables")
    if arguments.output is None:
        raise usage("no -o FILE: must end in .html")
    if len(arguments.files) > _FILES_MAX:
        raise usage(f"{len(arguments.files)} files: must be at most {_FILES_MAX}")


def _packing(arguments: argparse.Namespace, path: str) -> Packing:
    packing = Packing.read(path)
    if arguments.material:
        packing = packing.of_material(arguments.material)
    if arguments.units == "si" and not packing.material.young > 0:
        raise usage(f"--units si: {path} has no material: give one by --material")
    return packing


def _choice(arguments: argparse.Namespace, scene: Scene, packing: Packing) -> Choice:
    until = None
    if arguments.until is not None:
        until = _command.amount("--until", arguments.until, "d/sqrt(E* / rho)", (1e-9, 1e9), packing.material)
    modes = arguments.modes or ((0, arguments.lowest - 1) if arguments.lowest else None)
    signal = {**scene.options("signal"), "threads": arguments.threads or _command.cores()}
    return Choice(modes=False if arguments.no_modes else modes, frames=False if arguments.no_wave else arguments.frames,
                  until=until, source=arguments.source, network=scene.options("network"), signal=signal)
