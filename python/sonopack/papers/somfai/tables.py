"""Tables I, II, IV and V."""
from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .. import published
from .samples import PRESSURES, SomfaiWork, member
from .verdict import Row, counted, mean_of

FAR_OFF = 8  # standard deviations, from the median deviation: a probability of 1e-15 for a normal distribution


def make(work: SomfaiWork, item: str) -> None:
    for row in published.table("somfai", "tables"):
        if row["item"] == item:
            _add(work, row)
    _say_agreement(work, item)
    if item == "table4":
        _say_box(work, item)


def _add(work: SomfaiWork, row: published.Published) -> None:
    p, sd, of = float(row["p"]), published.number(row["sd"]), member(row["ours"])
    parts = " ".join(dict.fromkeys(word.split(".")[0] for word in row["ours"].split(" / ")))
    values = [of(sample) for sample in work.some("square", p, parts=f"statics {parts}")]
    work.add(mean_of(Row(row["item"], row["quantity"], p=p, paper=float(row["paper"]), paper_sd=sd,
                         digit=float(row["digit"]), scatter="ours" if math.isnan(sd) else "paper"), values))
    _say_far_off(work, row["item"], f"{row['quantity']} at p = {p:g}", values)


def _say_agreement(work: SomfaiWork, item: str) -> None:
    rows = [row for row in work.rows if row.item == item]
    known = [row for row in rows if math.isfinite(row.sigma)]
    agree = sum(row.verdict == "agrees" for row in rows)
    gaps = ", and some have no value or no known scatter" if len(known) < len(rows) else ""
    work.say(item, f"{agree} of {len(rows)} means lie within one standard deviation of the paper{gaps}.")
    c = counted(work.rows, item)
    if c.judged:
        work.say(item, f"By the standard errors of both means {c.within1} of {c.judged} lie within one, {c.beyond2} beyond two "
                       f"and {c.beyond3} beyond three; chi^2 = {c.chi2:.0f}.")
    if known:
        worst = max(known, key=lambda row: abs(row.sigma))
        work.say(item, f"The largest deviation is that of {worst.quantity} at p = {worst.p:g}: {worst.ours:.4g} here, "
                       f"{worst.paper:.4g} in the paper, {abs(worst.sigma):.2f} standard deviations apart.")


def _say_far_off(work: SomfaiWork, item: str, what: str, values: Sequence[float]) -> None:
    """Names samples that dominate a mean. A soft spot in a single packing can do so for the body forces."""
    if len(values) < 5:
        return
    x = np.array(values)
    middle = float(np.median(x))
    off = np.abs(x - middle)
    far = off > FAR_OFF * 1.4826 * np.median(off)
    if far.any():
        work.say(item, f"{what}: {far.sum()} of {len(x)} samples lie more than 8 standard deviations of the others away, the "
                       f"farthest at {x[np.argmax(off)]:.3g}; the median is {middle:.4g}.")


def _say_box(work: SomfaiWork, item: str) -> None:
    """The body force on a grain is its volume divided by Phi3*. If Phi3* is that of the whole box, the forces add up to the
    force on the continuum. The ratios are proportional to its square."""
    rows = [row for row in work.rows if row.item == item]
    factors = {p: _box_ratio(work, p) for p in PRESSURES}
    before = sum(row.verdict == "agrees" for row in rows)
    agree = sum(abs(row.ours * factors[row.p] - row.paper) <= row.paper_sd for row in rows)
    work.say(item, "The body force on a grain goes as 1/Phi3*. Here that is the bulk's, as everywhere; with that of the whole "
                   f"box, loose layers at the walls included, all ratios would be {min(factors.values()):.3f} to "
                   f"{max(factors.values()):.3f} times as large, and {agree} of {len(rows)} instead of {before} would agree.")


def _box_ratio(work: SomfaiWork, pressure: float) -> float:
    squares = []
    for sample, packing, network in work.walk("square", pressure):
        if sample.statics is not None:
            volume = float(np.sum(4 / 3 * np.pi * packing.r[network.grain] ** 3))
            squares.append((volume / (packing.box[0] * packing.box[1] * sample.statics.phi3s)) ** 2)
    return sum(squares) / len(squares) if squares else math.nan
