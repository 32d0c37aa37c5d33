"""Judges our values against those of the paper, counts verdicts, and finds systematic differences."""
from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Sequence

from ..work import hypot, ratio, root, total

SAMPLES = 30      # of each mean in the paper
DECIDED = 2       # standard errors from its limit, at which a claim is decided


@dataclasses.dataclass(frozen=True)
class Row:
    """A value of the paper and ours; NAN where there is none.

    scatter: the unit of sigma. "paper": its standard deviation; "ours": that of our samples; "stated": the precision of the
    words and our error together; "bound": the same of a lower bound, and 0 above it; "claim": a claim in words, which holds
    or does not. paper_sd: standard deviation, precision of the words, or tolerance of a claim. digit: unit of the last
    printed digit; 0: not rounded. samples: 0 if it is no average. sigma, combined, deviation_err and verdict are those of
    judged()."""

    item: str
    quantity: str
    p: float = math.nan
    paper: float = math.nan
    paper_sd: float = math.nan
    scatter: str = "paper"
    ours: float = math.nan
    ours_sd: float = math.nan
    err: float = math.nan
    samples: int = 0
    digit: float = 0.0
    relation: str = "="
    where: str = ""
    note: str = ""
    sigma: float = math.nan
    combined: float = math.nan
    deviation_err: float = math.nan
    verdict: str = ""

    @property
    def is_claim(self) -> bool:
        return self.scatter == "claim"

    @property
    def is_mean(self) -> bool:
        return self.scatter in ("paper", "ours")

    @property
    def rounding(self) -> float:
        """Standard deviation of what rounding took away: uniform within half of the last digit."""
        return self.digit / math.sqrt(12)


def judged(row: Row) -> Row:
    """The row with its differences and its verdict."""
    if row.is_claim:
        return dataclasses.replace(row, verdict=_of_claim(row))
    known = row.err if math.isfinite(row.err) else 0.0
    scatter = {"paper": row.paper_sd, "ours": row.ours_sd}.get(row.scatter, hypot(row.paper_sd, known))
    theirs = {"paper": row.paper_sd / math.sqrt(SAMPLES), "ours": row.ours_sd / math.sqrt(SAMPLES)}.get(row.scatter,
                                                                                                     row.paper_sd)
    difference = row.ours - row.paper
    if row.scatter == "bound" and difference > 0:
        difference = 0.0
    sigma, errors = ratio(difference, scatter), hypot(theirs, row.err)
    combined, with_print = math.nan, math.nan
    if math.isfinite(row.err):
        combined, with_print = ratio(difference, errors), ratio(difference, hypot(errors, row.rounding))
    verdict = "missing" if not math.isfinite(sigma) else "agrees" if abs(sigma) <= 1 else "deviates"
    return dataclasses.replace(row, sigma=sigma, combined=combined, deviation_err=with_print, verdict=verdict)


def _of_claim(row: Row) -> str:
    """By the distance of ours from the limit, which is positive if the claim holds."""
    off = row.ours - row.paper
    inside = {">": off, "<": -off, "=": row.paper_sd - abs(off)}[row.relation]
    if not math.isfinite(inside) or not math.isfinite(row.err):
        return "missing"
    if abs(inside) < DECIDED * row.err:
        return "undecided"
    return "holds" if inside >= 0 else "contradicted"


def mean_of(row: Row, values: Iterable[float]) -> Row:
    """The row with mean, standard deviation and standard error of values. Those that are not finite are left out."""
    known = [float(value) for value in values if math.isfinite(value)]
    n = len(known)
    mean = total(known) / n if n else math.nan
    sd = math.sqrt(total((x - mean) * (x - mean) for x in known) / (n - 1)) if n > 1 else math.nan
    return dataclasses.replace(row, samples=n, ours=mean, ours_sd=sd, err=sd / math.sqrt(n) if n > 1 else math.nan)


class Sum:
    """Running sums of finite values, for means and standard errors."""

    def __init__(self, values: Iterable[float] = ()) -> None:
        self.n, self.sum, self.squares = 0, 0.0, 0.0
        for value in values:
            self.add(value)

    def add(self, x: float) -> None:
        if math.isfinite(x):
            self.n, self.sum, self.squares = self.n + 1, self.sum + float(x), self.squares + float(x) * float(x)

    @property
    def mean(self) -> float:
        return self.sum / self.n if self.n else math.nan

    @property
    def err(self) -> float:
        n = self.n
        return root(max(0.0, self.squares / n - self.sum / n * (self.sum / n)) / (n - 1)) if n > 1 else math.nan


# ---- counts ---------------------------------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class Counts:
    """Verdicts on values. judged: those with a deviation_err; within1, beyond2, beyond3: in those errors. chi2, chi2_bare:
    sums of squares with and without the rounding of print; NAN for stated numbers, whose precision is no deviation."""

    values: int
    agree: int
    missing: int
    judged: int
    within1: int
    beyond2: int
    beyond3: int
    chi2: float
    chi2_bare: float


def counted(rows: Iterable[Row], item: str = "", means: bool = True) -> Counts:
    """Counts over the values of an item, or of all: means that the paper prints, or numbers that it states."""
    some = [row for row in rows if item in ("", row.item) and not row.is_claim and row.is_mean == means]
    sigmas = [abs(row.sigma) for row in some if math.isfinite(row.sigma)]
    pairs = [(abs(row.deviation_err), row.combined) for row in some if math.isfinite(row.deviation_err)]
    off = [pair[0] for pair in pairs]
    return Counts(len(sigmas), sum(x <= 1 for x in sigmas), len(some) - len(sigmas), len(off), sum(x <= 1 for x in off),
                  sum(x > 2 for x in off), sum(x > 3 for x in off), total(x * x for x in off) if means else math.nan,
                  total(bare * bare for _, bare in pairs) if means else math.nan)


@dataclasses.dataclass(frozen=True)
class Family:
    """One quantity at all its pressures. side: +1, ours are above; -1, below; 0, both. together: sum of deviation_err over
    the root of their number. least: the smallest deviation_err. low, high: range of ours/paper - 1."""

    item: str
    quantity: str
    values: int
    side: int
    together: float
    least: float
    low: float
    high: float

    @property
    def is_systematic(self) -> bool:
        """Chance hardly explains three or more values on one side, together beyond three errors, or all beyond two."""
        return self.values >= 3 and (abs(self.together) > 3 if self.side else self.least > 2)


def families(rows: Sequence[Row]) -> list[Family]:
    """The families of rows that follow each other."""
    out = []
    for (item, quantity), group in itertools.groupby(rows, lambda row: (row.item, row.quantity)):
        some = [row for row in group if not row.is_claim and math.isfinite(row.deviation_err)]
        off = [row.deviation_err for row in some]
        ratios = [row.ours / row.paper - 1 for row in some]
        side = 1 if all(x > 0 for x in off) else -1 if all(x < 0 for x in off) else 0
        out.append(Family(item, quantity, len(off), side, total(off) / math.sqrt(len(off)) if off else math.nan,
                          min(map(abs, off), default=math.inf), min(ratios, default=math.inf),
                          max(ratios, default=-math.inf)))
    return out
