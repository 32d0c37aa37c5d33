"""sonopack bench: run time against error of every method."""
from __future__ import annotations

import argparse
import math
import os
import resource
import statistics
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from . import __version__, _command, _core
from ._command import Failed, usage
from ._core import Refused, SonopackError
from ._network import Network
from ._packing import Packing
from ._place import Place
from ._scene import Scene
from ._signal import Signal
from ._table import Table

#: the default networks: two files, and two packings that are made
_FILES = ("packings/reference/packing_N200_p1e-4.txt", "packings/reference/packing_N600_p1e-4.txt")
_MADE: dict[str, dict[str, Any]] = {"piston30": {"kind": "piston", "grains": 30, "width": 6},
                                    "lattice3600": {"kind": "triangular", "grains": 3600, "width": 60}}
_SAMPLES, _PRESSURES = 5, (1e-4, 1e-5, 1e-6, 1e-7)
_PACKINGS_MAX, _REPEATS_MAX = 16, 401
_MODES_DOFS, _SIGNAL_DOFS, _LONG_DOFS = 3000, 6000, 700  # above these, methods that compute all modes are left out
_STEPS = ("verlet", "lax-wendroff")
_COLUMNS = {"case": "", "method": "", "parameter": "", "seconds": "s", "error": "", "memory_MB": "MB"}

#: computes, and returns the relative error
_Work = Callable[[], float]


class _Run(NamedTuple):
    """One row: work of a method, which is timed."""

    case: str
    method: str
    parameter: float
    work: _Work


# ---- measuring ------------------------------------------------------------------------------------------------------

def _measured(work: _Work, seconds: float) -> tuple[float, float, float]:
    """Median CPU time, error, and the memory that the first run needs [MB]. There are 15 runs, fewer if they take longer than
    is given, and more if they are short, so that other work of the machine averages out."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    each: list[float] = []
    error, grown = 0.0, 0.0
    while not each or (len(each) < _REPEATS_MAX and sum(each) < seconds and
                       (len(each) < 15 or sum(each) < 0.4 * seconds)):
        begun = time.process_time()
        error = work()
        each.append(time.process_time() - begun)
        if len(each) == 1:
            grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    return statistics.median(each), error, grown


def _apart(work: _Work, seconds: float) -> tuple[float, float, float]:
    """The same in a child process: memory that an earlier run has freed would hide the growth."""
    try:
        return _core.in_child(lambda: _measured(work, seconds))
    except EOFError:
        raise Failed("the process that measured has died") from None


# ---- signals --------------------------------------------------------------------------------------------------------

def _deviation(signal: Signal, exact: Signal | None) -> float:
    """The largest difference from the exact signal, or the error bound, over the peak."""
    worst = np.abs(signal.f - exact.f).max(axis=2) if exact else signal.errors
    return float((worst / np.abs((exact or signal).f).max(axis=2)).max())


def _bound(net: Network, words: dict[str, Any]) -> float:
    return _deviation(net.signal(**words), None)


def _is_tried(method: str, net: Network) -> bool:
    return method != "dynamics" and (method not in ("dense", "sparse") or net.dofs <= _SIGNAL_DOFS)


def _best(net: Network, method: str, words: dict[str, Any]) -> Signal | None:
    """The signal with the smallest tolerance that the method can guarantee."""
    for tolerance in (1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2):
        try:
            return net.signal(method=method, tolerance=tolerance, **words)
        except Refused:
            pass
    return None


def _signals(net: Network, case: str, words: dict[str, Any], whole: bool) -> Iterator[_Run]:
    """Every method; whole: with time stepping, and with several tolerances. The error is the difference from that other method
    which has the smallest error bound."""
    methods = [method for method in _core.words("sp_signal_method").values() if _is_tried(method, net)]
    known = {method: _best(net, method, words) for method in methods[1:]
             if method not in _STEPS and (whole or method in ("chebyshev", "dense"))}

    def run(method: str, parameter: float, **more: Any) -> _Run:
        used = net.signal(method=method, **more, **words).method if method == "auto" else method
        others = [signal for name, signal in known.items() if signal and name != used]
        exact = min(others, key=lambda signal: signal.error, default=None)
        return _Run(case, method, parameter, lambda: _deviation(net.signal(method=method, **more, **words), exact))

    for method in methods:
        if method in _STEPS:
            for k in range(5 if whole else 0):
                step = 4.0**-k / net.omega_bound
                yield run(method, step, step=step, tolerance=1e-3)
        elif method == "dense":
            yield run(method, math.nan, tolerance=1e-3)
        else:
            several = (1e-3, 1e-9) if method == "auto" else (1e-3, 1e-6, 1e-9, 1e-12)
            for tolerance in several if whole else (1e-6,):
                yield run(method, tolerance, tolerance=tolerance)


def _signal(net: Network, until: float) -> Iterator[_Run]:
    yield from _signals(net, "signal", {"until": until}, True)


def _long(net: Network, until: float) -> Iterator[_Run]:
    if net.dofs <= _LONG_DOFS:
        yield from _signals(net, "long", {"until": 1e6 / net.omega_bound}, False)


def _many(net: Network, until: float) -> Iterator[_Run]:
    """Sources and detectors are 12 grains each, throughout the packing."""
    places = [Place.grain(int(net.grain[net.n * k // 24])) for k in range(24)]
    yield from _signals(net, "many", {"until": until, "sources": places[::2], "detectors": places[1::2]}, False)


def _damped(net: Network, until: float) -> Iterator[_Run]:
    """Dashpots with a tenth of critical damping. The error is the bound of the method."""
    for tolerance in (1e-3, 1e-9):
        words: dict[str, Any] = {"until": until, "damping": 0.1, "method": "faber", "tolerance": tolerance}
        yield _Run("damped", "faber", tolerance, partial(_bound, net, words))


# ---- modes, moduli, packings ----------------------------------------------------------------------------------------

def _modes(net: Network, until: float) -> Iterator[_Run]:
    """The dense solver computes all modes, however many are asked for."""
    def error(words: dict[str, Any]) -> float:
        modes = net.modes(**words)
        there = modes.omega > 0
        return float((modes.error[there] / modes.omega[there]).max(initial=0))

    for case, lowest, vectors in (("lowest10", 10, True), ("lowest100", 100, True), ("modes", None, True),
                                  ("frequencies", None, False)):
        for solver in ("auto", "lanczos", "arpack", "dense"):
            dense = solver == "dense" or lowest is None
            if not (net.dofs > _MODES_DOFS or (lowest or 0) > net.dofs if dense else net.dofs < 4 * (lowest or 0)):
                words = {"lowest": lowest, "vectors": vectors, "solver": solver}
                yield _Run(case, solver, math.nan, partial(error, words))


def _moduli(net: Network, until: float) -> Iterator[_Run]:
    def error() -> float:
        moduli = net.moduli()
        return float(moduli.error22 / moduli.c22)

    if net.dim < 3:
        yield _Run("moduli", "cholesky", math.nan, error)


_CASES = {"signal": _signal, "long": _long, "many": _many, "damped": _damped, "modes": _modes, "moduli": _moduli}


def _packings(arguments: argparse.Namespace, scene: Scene) -> Iterator[tuple[Any, ...]]:
    """Rows of packings: median CPU time, and the largest elastic acceleration at the end, over p."""
    for pressure in _PRESSURES:
        one = scene.replace({"packing.pressure": pressure})
        grains, seed = int(one["packing.grains"]), int(one["packing.seed"])
        _command.note(arguments, f"{_SAMPLES} packings of {grains} grains at {pressure:g}")
        made = [Packing.make(one, seed=seed + k) for k in range(_SAMPLES)]
        yield (f"pack:{grains} grains", "piston", pressure, statistics.median(p.seconds for p in made),
               max(p.residual / pressure for p in made), math.nan)


# ---- the command ----------------------------------------------------------------------------------------------------

def parser() -> _command.Parser:
    words = _command.Parser(
        "bench", "packing", usage="sonopack bench [OPTION...] [CASE...]",
        description="Measures run time against error, on two packings of packings/reference, one of 30 grains and a\n"
                    "lattice of 3600. Cases: signal (all methods and parameters), long (up to 10^6 over the largest\n"
                    "frequency, small networks only), many (from 12 grains to 12 others), damped, modes (the 10 and the\n"
                    "100 lowest, all, and all frequencies without vectors), moduli (all of these are the default), and\n"
                    "pack: the compression of packings at 1e-4 .. 1e-7, of 600 grains or as --set says (one minute).",
        epilog="seconds: median CPU time. error: for a signal, the largest difference, over the peak, from the signal of\n"
               "another method, the one with the smallest error bound (damped: its own bound); for modes, the largest\n"
               "bound for the relative error of a frequency; for moduli, the bound for C22; for packings, the largest\n"
               "acceleration over p (five seeds). parameter: the tolerance, the time step of verlet and lax-wendroff, or\n"
               "p. memory_MB: growth of the resident memory. `sonopack plot pareto' draws the table.")
    words.add_argument("cases", nargs="*", metavar="CASE", default=[])
    words.add_argument("--packing", metavar="FILE", action="append", default=[],
                       help="packing to measure, instead of the four (repeatable)")
    words.add_argument("--until", metavar="T", type=_command.number(1e-9, 1e9), default=400.0,
                       help="last time of the signals (400)")
    words.add_argument("--seconds", metavar="S", type=_command.number(0.01, 1e4), default=1.0,
                       help="CPU time that is spent on a row; less is less exact (1)")
    return words


def _check(arguments: argparse.Namespace) -> None:
    for word in arguments.cases:
        if word not in (*_CASES, "pack"):
            raise usage(f"no case {word:.60}: must be {', '.join(_CASES)} or pack")
    if arguments.units == "si":
        raise usage("--units si: it measures run times and errors, which have no units of a packing")
    if len(arguments.packing) > _PACKINGS_MAX:
        raise usage(f"--packing: may be given at most {_PACKINGS_MAX} times")
    if arguments.set and "pack" not in arguments.cases:
        raise usage(f"--set {arguments.set[0]:.60}: only the case pack takes keys")
    if arguments.output:
        _command.may_write(arguments, arguments.output, (".tsv", ".csv", ".json"))


def _networks(arguments: argparse.Namespace) -> Iterator[tuple[str, Network]]:
    for path in arguments.packing or _FILES:
        yield os.path.basename(path), Packing.read(path).network()
    for name, keys in {} if arguments.packing else _MADE.items():
        yield name, Packing.make(Scene(packing=keys)).network()


def _rows(arguments: argparse.Namespace, cases: list[str]) -> Iterator[tuple[Any, ...]]:
    for name, net in _networks(arguments) if cases else ():
        for case in cases:
            _command.note(arguments, f"{case} of {name}")
            for run in _CASES[case](net, arguments.until):
                try:
                    measured = _apart(run.work, arguments.seconds)
                except Refused as reason:
                    _command.note(arguments, f"{run.case}:{name}, {run.method} {run.parameter:g}: {reason}")
                    continue
                yield (f"{run.case}:{name}", run.method, run.parameter, *measured)


def _auto(rows: list[tuple[Any, ...]]) -> str | None:
    """How much slower `auto` was than the fastest row of its case that is exact enough; for modes, than all of them."""
    worst = (0.0, "", math.nan)
    for case, _, parameter, seconds, *_ in (row for row in rows if row[1] == "auto"):
        fastest = min((row[3] for row in rows if row[0] == case and row[1] != "auto" and not row[4] > parameter),
                      default=math.inf)
        ratio = seconds / max(fastest, 1e-9)  # a coarse clock gives 0
        if ratio > worst[0]:
            worst = (ratio, case, parameter)
    return f"auto = {worst[0]:.2f} times the fastest at the most ({worst[1]}, {worst[2]:g})" if worst[1] else None


def run(arguments: argparse.Namespace) -> None:
    """Measures, and writes the table."""
    _check(arguments)
    scene = arguments.words.scene(arguments) if arguments.set else Scene()
    rows = list(_rows(arguments, [case for case in _CASES if case in arguments.cases or not arguments.cases]))
    if "pack" in arguments.cases:
        rows += _packings(arguments, scene)
    columns: dict[str, Any] = {name: [row[k] for row in rows] for k, name in enumerate(_COLUMNS)}
    numbers = {name: np.array(column, dtype=str if k < 2 else float) for k, (name, column) in enumerate(columns.items())}
    table = Table.from_columns(numbers, _COLUMNS)
    comment = _auto(rows)
    if comment:
        table.add_comment(comment)
    table.add_comment(f"sonopack {__version__}")
    _command.write_table(arguments, table)
