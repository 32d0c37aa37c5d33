"""Equations (35) and (37) as printed: growth rates and speeds of their linear waves, and the refusal to run them."""
from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..._column import Column
from ..._core import Floats, Refused
from ..._table import Table
from ..sheet import Curve, Panel, Sheet
from ..work import Work
from .paper_column import coefficients, column, speed2
from .rows import add

STEP = 0.01  # the paper's steps [s, cm]
WAVES = 241
NAMES = ("eq35", "eq37", "longwave", "lattice")


def make(work: Work, tell: Callable[[float], None]) -> None:
    c = column(10)
    k, growth, squares = _evaluate(c)
    plus, _, b = coefficients(c.radius(), 1 / (2 * c.radius()))
    add(work, "plus", plus)
    add(work, "b", b * 2 * c.radius())
    _growth(work, c, k, growth[1])
    _speeds(work, c)
    _refusals(work)
    columns = {f"{kind}_{name}": values[j] for j, name in enumerate(NAMES)
               for kind, values in (("growth", growth), ("speed2", squares))}
    table = Table.from_columns({"k": k, **columns}, {"k": "1/cm", **{f"growth_{name}": "1/s" for name in NAMES}})
    table.add_comment("linearised about y = z, alpha = 1/h; ten particles of Fig. 1; speed2 in K h^2/m; the lattice's waves "
                      "end at k = pi/h")
    work.save_table("symbols-waves", table)
    if work.folder:
        work.draw("symbols", "symbols-waves",
                  "(a) Growth rates of waves exp(i k z) by (35) and (37) as printed, about y = z; the lattice and the long "
                  "wave here have none. (b) Squares of their speeds; below 0 there is no wave; (35) and (37) as in (a).",
                  _sheet(k, growth, squares).draw())


def _evaluate(c: Column) -> tuple[Floats, Floats, Floats]:
    """Wave numbers, and growth rates and squared speeds of the four models, linearised about y_z = 1."""
    h, unit = 2 * c.radius(), speed2(c)
    k = np.array([0.01 * math.pow(10, 4.5 * i / (WAVES - 1)) for i in range(WAVES)])
    growth, squares = np.zeros((4, WAVES)), np.empty((4, WAVES))
    for i, wave in enumerate(map(float, k)):
        for j, model in enumerate(NAMES[:3]):
            at = c.symbol(model, wave, alpha=1 / h)
            growth[j, i], squares[j, i] = at.growth, at.speed2 / unit
        x = math.sin(0.5 * wave * h) / (0.5 * wave * h)
        squares[3, i] = x * x if wave * h <= math.pi else math.nan
    return k, growth, squares


def _growth(work: Work, c: Column, k: Floats, growth: Floats) -> None:
    """The largest growth rate of (37), and that of (35) on the paper's grid."""
    h = 2 * c.radius()
    best = int(np.argmax(growth))
    most, at = float(growth[best]), float(k[best])
    wave = at / 1.05
    while wave < at * 1.05:
        here = c.symbol("eq37", wave, alpha=1 / h).growth
        if here > most:
            most, at = here, wave
        wave *= 1.0001
    # the error of the maximum is quadratic in the step of k
    add(work, "growth", most, 1e-6 * most, k=at, factor=math.exp(STEP * most))
    add(work, "grid", c.symbol("eq35", math.pi / STEP, alpha=1 / h).growth)
    work.say("symbols",
             f"(37) has no waves below k = {at * math.sqrt(2):.3g} /cm: they grow, by up to {most:.4g} /s. (35), of the other "
             "sign, has waves there and growth above, without bound in k. No scheme helps: a finer one follows the growth "
             "better.")


def _speeds(work: Work, c: Column) -> None:
    h, unit = 2 * c.radius(), speed2(c)
    add(work, "expansion", c.expansion_speed2(1 / h) / unit)
    add(work, "cfl", math.sqrt(unit))
    add(work, "longwave", c.symbol("longwave", math.pi / h, alpha=1 / h, slope=0.95).growth)


def _refusals(work: Work) -> None:
    """The library refuses both, and says why."""
    for model, name in (("eq35", "(35)"), ("eq37", "(37)")):
        why = ""
        try:
            column(10, model=model).run([])
        except Refused as fault:
            why = str(fault)
        add(work, f"run-{model}", 0 if why else 1, paper=None if model == "eq37" else math.nan)
        work.say("symbols", f"The command refuses {name}: {why}.")


def _sheet(k: Floats, growth: Floats, squares: Floats) -> Sheet:
    labels = ("(35) as printed", "(37) as printed", "long wave here", "lattice")
    looks = [{"ink": 1}, {"ink": 2, "dash": 1}, {"ink": 3}, {"ink": 0, "dash": 2}]
    shown = np.where(growth > 0, growth, np.nan)  # a logarithmic axis cannot show others
    rates = [Curve(k, shown[j], labels[j], **looks[j]) for j in range(2)]
    speeds = [Curve(k, squares[j], labels[j] if j > 1 else "", **looks[j]) for j in range(4)]
    return Sheet([Panel(rates, "|k| [1/cm]", "growth rate [1/s]", tag="(a)", log="xy", x=(0.01, 316), y=(1, 5e7)),
                  Panel(speeds, "|k| [1/cm]", "|c|^{2}/(|K| |h|^{2}/|m|)", tag="(b)", log="x", x=(0.01, 316), y=(-8, 8),
                        zero=True)], columns=2)
