"""The columns of the paper, and quantities that several items derive from them."""
from __future__ import annotations

import math
from typing import Any

from ..._column import Column, ColumnRun


def column(particles: int, **keys: Any) -> Column:
    """The column of Fig. 1: 5 particles at 7.5 Hz or 10 at 9.5 Hz, T = 1 s, four taps, with other keys."""
    return Column(**{"particles": particles, "frequency": 9.5 if particles == 10 else 7.5, "taps": 4, **keys})


def overlap(c: Column) -> float:
    """m g/K, the overlap that supports one particle [cm]."""
    return c.mass() * GRAVITY / c.stiffness


def speed2(c: Column) -> float:
    """K h^2/m, the unit of squared speeds [cm^2/s^2]."""
    h = 2 * c.radius()
    return c.stiffness * h * h / c.mass()


def separation(run: ColumnRun) -> float:
    """The smallest separation in any tap [cm]."""
    return min(tap.separation for tap in run.taps)


def stiff(times: float) -> float:
    """K = times m g/r, of particles of unit mass and radius [g/s^2]."""
    return times * 1.0 * GRAVITY / 1.0


def coefficients(r: float, alpha: float) -> tuple[float, float, float]:
    """The coefficients (36) and (38) for sigma = tanh(alpha s): A(+), A(-), B."""
    cubed = 16 * math.pow(r * alpha, 3)
    return 1.5 + 6 * r * alpha - cubed, 1.5 + 6 * r * alpha + cubed, alpha * (1 - 8 * r * r * alpha * alpha)


#: of the paper: gravity [cm/s^2], amplitude [cm], restitution
GRAVITY, AMPLITUDE, RESTITUTION = 980.67, 1.06, 0.09
