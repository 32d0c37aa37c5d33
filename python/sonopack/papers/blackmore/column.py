"""The columns of the paper, and its errors: for each the value that follows from the print, and the correct one, both
computed."""
from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._column import Column, ColumnRun
from ..._core import Floats
from ..work import Tell, Work
from .rows import add

#: of the paper: gravity [cm/s^2], amplitude [cm], restitution
GRAVITY, AMPLITUDE, RESTITUTION = 980.67, 1.06, 0.09


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


# ---- errata ---------------------------------------------------------------------------------------------------------

def make_errata(work: Work, tell: Tell) -> None:
    five, ten = column(5), column(10)
    work.say("errata", work.texts["errata"])
    _taps(work, five)
    _rest(work, five)
    _long_wave(work, ten)
    _bsr(work, ten)


def _overlap(c: Column, y: Floats, contact: int) -> float:
    h = 2 * c.radius()
    if contact >= c.particles:
        return 0.0
    return max(0.0, 0.5 * h - float(y[0]) if contact == 0 else h - float(y[contact] - y[contact - 1]))


def _acceleration(c: Column, y: Floats, particle: int) -> float:
    """By (19), of a particle (from 1) at rest at y [N] on a resting floor, where sigma(0) = 0."""
    return -GRAVITY + c.stiffness / c.mass() * (_overlap(c, y, particle - 1) - _overlap(c, y, particle))


def _taps(work: Work, five: Column) -> None:
    run = column(5, period=0.5).run([])
    add(work, "order", run.taps[3].separation, contact=run.violated, t=run.violated_at)
    end, jump = 0.5 / 7.5 * (1 + 1e-12), AMPLITUDE * 2 * math.pi * 7.5
    add(work, "floor-begin", five.floor(0)[1])
    add(work, "floor-end", five.floor(end)[1], paper=-jump)
    add(work, "elastic", column(5, e=0.0, taps=1).run([]).taps[0].dissipated)


def _rest(work: Work, c: Column) -> None:
    """(24) to (31): the column at rest, and its taps."""
    n, r, m, y = c.particles, c.radius(), overlap(c), c.rest()
    # the middle line of (24) as printed, where its two brackets are multiplied
    printed = -GRAVITY - c.stiffness / c.mass() * _overlap(c, y, 3) * _overlap(c, y, 2)
    add(work, "middle", _acceleration(c, y, 3), 1e-9 * GRAVITY, paper=printed)
    add(work, "unknowns", n, paper=n - 1)
    add(work, "top", _overlap(c, y, 4), paper=2 * r - ((2 * n - 1) * r - 0.5 * ((n - 1) * n + 2) * m - float(y[3])))
    add(work, "source", 28)
    # omega = 2 pi Gamma mistakes the acceleration Gamma = a omega^2/g for a frequency
    for key, gamma in (("hertz-5", 2.4019), ("hertz-10", 3.8476)):
        ours = math.sqrt(gamma * GRAVITY / AMPLITUDE) / (2 * math.pi)
        add(work, key, ours, 0.5e-4 / gamma * ours / 2)  # half of the last digit of Gamma
    add(work, "period", c.period)
    add(work, "alphas", 2)
    # the upper contact is just open; the lower one carries three particles, as at rest
    add(work, "open", -GRAVITY + c.stiffness / c.mass() * 3 * overlap(c), paper=-GRAVITY)


def _long_wave(work: Work, c: Column) -> None:
    r, unit = c.radius(), speed2(c)
    h = 2 * r
    add(work, "minus", coefficients(r, 1 / h)[1])
    of35, of37 = (c.symbol(model, 1e-6, alpha=1 / h).speed2 / unit for model in ("eq35", "eq37"))
    add(work, "sign", of35, paper=of37)
    add(work, "closed", 0.5, paper=of35)
    add(work, "start", 0, paper=_acceleration(c, c.rest() * 0 + [(2 * i + 1) * r for i in range(c.particles)], 1))
    # y = (1 + s t) z with mass m/h per label: the density at a label is m/(h (1 + s t)). (41) mixes rho_z at fixed
    # places with y of labels, and gives exp(-s t)
    add(work, "stretched", 0.5, paper=math.exp(-1))
    add(work, "data", 42)
    add(work, "integrand", 0)


def _normalisation(prefactor: float, c: float) -> float:
    """Integral of Theta, (44), over all y, with a prefactor; b only shifts the maximum."""
    x = np.linspace(-12 * c, 12 * c, 4001)  # over 12 widths on either side the trapezoidal rule is exact
    return float(np.trapz(prefactor / math.sqrt(2 * math.pi) * np.exp(-x**2 / (2 * c * c)), x))


def _bsr(work: Work, c: Column) -> None:
    h = 2 * c.radius()
    wide = 3 * h
    add(work, "theta", _normalisation(1 / wide, wide), paper=_normalisation(1 / (7 * h), wide))
    add(work, "force", c.bsr_force("signed"), paper=-c.bsr_force("literal"))
    add(work, "step", 0.01 / (h * math.sqrt(c.stiffness / c.mass())))
