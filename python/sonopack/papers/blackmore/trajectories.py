"""Fig. 1: trajectories of five and of ten particles, their positions and densities after each tap, and what the taps cost."""
from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..._column import Column
from ..._table import Table
from ..work import Work, largest
from .paper_column import AMPLITUDE, GRAVITY, column
from .rows import add


def make(work: Work, tell: Callable[[float], None]) -> None:
    for k, n in enumerate((5, 10)):
        tables = {output: column(n, step=0.0025, output=output).table() for output in ("trajectory", "strobe", "energy")}
        f = 9.5 if n == 10 else 7.5
        omega = 2 * math.pi * f
        add(work, f"gamma-{n}", AMPLITUDE * omega * omega / GRAVITY, n=n, f=f)
        _densities(work, column(n), tables["strobe"])
        _taps(work, column(n), tables["energy"])
        for tap in range(tables["strobe"].rows):
            for i in range(1, n + 1):
                add(work, "position", tables["strobe"][f"y{i}"][tap], detail=True, i=i, tap=tap, n=n)
        _show(work, n, f, tables)
        tell(0.5 * (k + 1))
    work.say("fig1",
             "That a column grows denser is no law: contacts come to rest anywhere within the band of forces that friction "
             "allows, K (1 -+ e) times the overlap. All positions are in the table of rows (fig1.tsv), with an error of 1e-8 "
             "cm at the most.")


def _densities(work: Work, c: Column, strobe: Table) -> None:
    """Before the first tap and at .99T, 1.99T, ..."""
    before, after = c.density(np.append(0.0, c.rest())), strobe["density"]
    add(work, "before", before, n=c.particles)
    for tap, density in enumerate(after):
        add(work, "after", density, tap=tap + 1, n=c.particles)
    work.say("fig1",
             f"N = {c.particles}: m N over the length of the column is {before:.6f} g/cm before the first tap; that tap "
             f"changes it by {100 * (after[0] / before - 1):+.2f}%, all four by {100 * (after[-1] / before - 1):+.2f}%.")


def _taps(work: Work, c: Column, energy: Table) -> None:
    for tap in range(energy.rows):
        done, words = energy["work"][tap], {"tap": tap + 1, "n": c.particles, "detail": tap > 0}
        error = abs(energy["residual"][tap]) * done
        add(work, "rest", energy["rest"][tap], **words)
        add(work, "work", done, error, **words)
        add(work, "dissipated", energy["dissipated"][tap], error, **words)
    rest = energy["rest"]
    latest = math.inf if np.isnan(rest).any() else largest(map(float, rest))  # NAN: never at rest
    add(work, "settled", latest, paper=0.99 * c.period, n=c.particles)
    add(work, "separation", energy["separation"].min(), n=c.particles)


def _show(work: Work, n: int, f: float, tables: dict[str, Table]) -> None:
    for name, output in (("trajectories", "trajectory"), ("strobe", "strobe"), ("energy", "energy")):
        work.save_table(f"fig1-n{n}-{name}", tables[output])
    if work.folder:
        from ..pictures import column as column_figure

        work.draw("fig1", f"fig1-n{n}-trajectories",
                  f"Trajectories of {n} particles, f = {f:g} Hz, T = 1 s, four taps; the floor below, ticks where taps begin.",
                  column_figure([tables["trajectory"]]))
        work.draw("fig1", f"fig1-n{n}-strobe",
                  f"Density and positions of {n} particles at .99T, 1.99T, 2.99T, 3.99T.", column_figure([tables["strobe"]]))
