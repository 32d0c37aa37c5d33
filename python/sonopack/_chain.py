"""The chain of equal balls between two walls in closed form (units: length of a ball l, time l/c, force K l), and the
solitary waves of chains."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Floats, call, documented
from ._native import ffi, lib
from ._records import Front, Solitary


def _source(word: str) -> int:
    return _core.number_of("sp_chain_source", word, "source")


@documented("sp_chain_front")
def chain_front(balls: int, source: str = "velocity") -> Front:
    """The first front of the force on the far wall. source: velocity or displacement of the first ball."""
    return _core.made(Front, None, lib.sp_chain_front, balls, _source(source))


def _signal(times: npt.ArrayLike, function: object, *given: object) -> Floats:
    t = _core.row(times, "times")
    out = np.empty(len(t))
    call(function, *given, len(t), _core.pointer_to(t), _core.pointer_to(out))  # type: ignore[arg-type]
    return out


@documented("sp_chain_walls_signal")
def chain_signal(balls: int, times: npt.ArrayLike, source: str = "velocity", wall: float = 1.0) -> Floats:
    """The force of the last ball on its wall at ascending times. wall: stiffness of the walls' springs over the others'."""
    if wall == 1:
        return _signal(times, lib.sp_chain_signal, balls, _source(source))
    chain = ffi.new("sp_chain *", {"grains": balls, "source": _source(source), "wall": wall})
    return _signal(times, lib.sp_chain_walls_signal, chain)


@documented("sp_chain_airy")
def chain_airy(balls: int, times: npt.ArrayLike, source: str = "velocity") -> Floats:
    """The front of an infinitely long chain, Eq. (16) of Somfai et al. (2005)."""
    return _signal(times, lib.sp_chain_airy, balls, _source(source))


@documented("sp_solitary_make")
def solitary(peak: float) -> Solitary:
    """The solitary wave of a chain of Hertzian balls whose largest additional overlap is `peak` overlaps at rest;
    math.inf: a chain that bears no force at rest."""
    return _core.made(Solitary, None, lib.sp_solitary_make, float(peak))
