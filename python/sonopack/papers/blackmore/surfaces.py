"""Fig. 2: the continua in comparison with the lattice."""
from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..._core import Floats
from ..._table import Table
from ..work import Work, total
from .paper_column import column
from .rows import add

MODELS = {"lattice": "lattice", "longwave": "long wave", "bsr": "BSR"}
PAIRS = (("lattice", "longwave"), ("lattice", "bsr"), ("longwave", "bsr"))


def make(work: Work, tell: Callable[[float], None]) -> None:
    fine, coarse = {}, {}
    for k, model in enumerate(MODELS):
        fine[model] = column(10, model=model).table()
        # the lattice has no grid
        coarse[model] = fine[model] if model == "lattice" else column(10, model=model, cells=4).table()
        work.save_table(f"fig2-{model}", fine[model])
        tell(0.2 * (k + 1))
    for a, b in PAIRS:
        ours, rough = distance(fine[a], fine[b]), distance(coarse[a], coarse[b])
        for how, value, other in zip(("mean", "largest"), ours, rough):
            add(work, f"{b}-{a}", value, abs(value - other), how=how)
    _heights(work, fine, coarse)
    _collapse(work)
    if work.folder:
        _show(work, fine)


def _positions(table: Table) -> Floats:
    """Of the particles [times][N]: the columns behind t and the floor."""
    return np.array([table[name] for name in table.names[2:]]).T


def distance(a: Table, b: Table) -> tuple[float, float]:
    """Mean and largest difference of positions over particles and times."""
    off = np.abs(_positions(a) - _positions(b))
    return total(off.ravel()) / off.size, float(off.max())


def _heights(work: Work, fine: dict[str, Table], coarse: dict[str, Table]) -> None:
    high = {}
    for model, name in MODELS.items():
        high[model], other = (max(0.0, float(each[model]["y10"].max())) for each in (fine, coarse))
        error = 1e-8 if model == "lattice" else abs(high[model] - other)
        add(work, "highest", high[model], error, n=10, model=name)
    work.say("fig2",
             "The long wave is a well-posed limit of the lattice, BSR a conservative model with the same contact law (neither "
             "is the printed one, see below and the errata), for the ten particles of Fig. 1: the tap that the paper calls "
             f"much longer is not given. The top rises to {high['lattice']:.2f} cm in the lattice, {high['longwave']:.2f} in "
             f"the long wave and {high['bsr']:.2f} in BSR; the long wave is "
             f"{distance(fine['lattice'], fine['longwave'])[0]:.3f} cm off in the mean, of a column of {20:g} cm.")


def _collapse(work: Work) -> None:
    """(45) as printed and with corrected signs: the columns fall through the floor."""
    for form, name in (("literal", "(45) as printed"), ("signed", "(45) with sgn(y)")):
        c = column(10, model="bsr", bsr=form)
        run = c.run([])
        add(work, "collapse", run.taps[0].separation, form=name, t=run.violated_at,
            where="floor and particle 1" if run.violated == 0 else "two particles")
        down = ", downwards" if form == "literal" else ""
        work.say("fig2", f"{name}: its force is {c.bsr_force(form):.4f} m g at the most{down}; the column collapses, ordering "
                         f"(1) fails at t = {run.violated_at:.5f} s.")


def _show(work: Work, fine: dict[str, Table]) -> None:
    from ..pictures import column as column_figure

    work.draw("fig2", "fig2-surfaces",
              "y over particle and time: lattice, long wave and BSR, ten particles at 9.5 Hz, T = 1 s, in one scale.",
              column_figure(list(fine.values()), ["lattice", "long wave", "BSR, conservative"]))
    errors = column(10, output="compare").table()
    work.save_table("fig2-errors", errors)
    work.draw("fig2", "fig2-errors", "Mean and largest difference of long wave and BSR from the lattice over the particles.",
              column_figure([errors]))
