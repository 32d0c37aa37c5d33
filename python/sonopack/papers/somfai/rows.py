"""Our values beside those of the paper: verdicts, counts, systematic differences; their table, and what the report says."""
from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..._table import Table
from ..report import Page

if TYPE_CHECKING:
    from .samples import SomfaiWork

SAMPLES = 30  # of each mean in the paper
DECIDED = 2  # standard errors from its limit, at which a claim is decided


@dataclasses.dataclass(frozen=True)
class Row:
    """A value of the paper and ours; NAN where there is none.

    scatter: the unit of sigma. "paper": its standard deviation; "ours": that of our samples; "stated": the precision of
    the words and our error together; "bound": the same of a lower bound, and 0 above it; "claim": a claim in words,
    which holds or does not. paper_sd: standard deviation, precision of the words, or tolerance of a claim. digit: unit
    of the last printed digit; 0: not rounded. samples: 0 if it is no average. sigma, combined, deviation_err and
    verdict are those of judged()."""

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
    note: str = "-"
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
    scatter = {"paper": row.paper_sd, "ours": row.ours_sd}.get(row.scatter, math.hypot(row.paper_sd, known))
    theirs = {"paper": row.paper_sd / math.sqrt(SAMPLES), "ours": row.ours_sd / math.sqrt(SAMPLES)}.get(row.scatter,
                                                                                                     row.paper_sd)
    difference = row.ours - row.paper
    if row.scatter == "bound" and difference > 0:
        difference = 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        errors = math.hypot(theirs, row.err)
        sigma, combined, with_print = map(float, np.divide(difference, (scatter, errors, math.hypot(errors, row.rounding))))
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


class Mean(NamedTuple):
    """Mean, standard deviation and standard error of values; or what follows from such means, without a deviation."""

    n: int
    mean: float
    sd: float
    err: float

    def __format__(self, spec: str) -> str:
        return f"{self.mean:{spec}} +- {self.err:{spec.lstrip('+')}}"


def mean_of(values: Iterable[float]) -> Mean:
    """Of values, without those that are not finite."""
    known = [value for value in values if math.isfinite(value)]
    n = len(known)
    sd = float(np.std(known, ddof=1)) if n > 1 else math.nan
    return Mean(n, float(np.mean(known)) if n else math.nan, sd, sd / math.sqrt(max(n, 1)))


def exact(value: float, n: int = 0) -> Mean:
    return Mean(n, value, math.nan, 0.0)


def ratio(a: Mean, b: Mean) -> Mean:
    """a/b of means that are independent."""
    value = a.mean / b.mean
    return Mean(b.n, value, math.nan, abs(value) * math.hypot(a.err / a.mean, b.err / b.mean))


def speed(rise: float, early: Mean, late: Mean) -> Mean:
    """The speed between two heights from arrival times."""
    time = late.mean - early.mean
    return Mean(late.n, rise / time, math.nan, rise / time * math.hypot(early.err, late.err) / time)


# ---- counts ---------------------------------------------------------------------------------------------------------

class Counts(NamedTuple):
    """Verdicts on values. judged: those with a deviation_err; within1, beyond2, beyond3: in those errors. chi2,
    chi2_without_rounding: sums of squares, with and without the rounding of print; NAN for stated numbers, whose
    precision is no deviation."""

    values: int
    agree: int
    missing: int
    judged: int
    within1: int
    beyond2: int
    beyond3: int
    chi2: float
    chi2_without_rounding: float


def counted(rows: Iterable[Row], item: str = "", means: bool = True) -> Counts:
    """Counts over the values of an item, or of all: means that the paper prints, or numbers that it states."""
    some = [row for row in rows if item in ("", row.item) and not row.is_claim and row.is_mean == means]
    sigma, off, bare = (np.abs([getattr(row, name) for row in some]) for name in ("sigma", "deviation_err", "combined"))
    counts = [np.isfinite(sigma), sigma <= 1, ~np.isfinite(sigma), np.isfinite(off), off <= 1, off > 2, off > 3]
    judged = np.isfinite(off)
    return Counts(*(int(np.sum(which)) for which in counts), *(float(np.sum(x[judged]**2)) if means else math.nan
                                                               for x in (off, bare)))


@dataclasses.dataclass(frozen=True)
class Family:
    """One quantity at all its pressures. side: +1, ours are above; -1, below; 0, both. together: sum of deviation_err
    over the root of their number. least: the smallest deviation_err. low, high: range of ours/paper - 1."""

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
        out.append(Family(item, quantity, len(off), side, sum(off) / math.sqrt(len(off)) if off else math.nan,
                          min((abs(x) for x in off), default=math.inf), min(ratios, default=math.inf),
                          max(ratios, default=-math.inf)))
    return out


# ---- the table ------------------------------------------------------------------------------------------------------

OF_FIGURES = "-values"
_COLUMNS = {"item": str, "p": float, "quantity": str, "paper": float, "paper_sd": float, "ours": float, "err": float,
            "sigma": float, "verdict": str, "ours_sd": float, "samples": int, "combined": float, "scatter": str,
            "deviation_err": float, "rounding": float, "relation": str, "where": str, "note": str}


def table(work: SomfaiWork, rows: Sequence[Row]) -> Table:
    """Rows as a table; all of them with their counts, claims and families as comments, one a line."""
    made = work.table(rows, _COLUMNS, {"p": "E*"})
    if rows is work.rows:
        _add_counts(made, work)
    return made


def _side(family: Family, both: str) -> str:
    return "high" if family.side > 0 else "low" if family.side < 0 else both


def _claims(rows: Sequence[Row]) -> list[str]:
    return [row.verdict for row in rows if row.is_claim]


def _counts(work: SomfaiWork, means: str, stated: str) -> list[tuple[str, Counts]]:
    """Counts of the items, of all means, and of what is stated in words, as far as there are values."""
    found = [(item, counted(work.rows, item)) for item in work.items]
    found += [(means, counted(work.rows)), (stated, counted(work.rows, means=False))]
    return [(name, c) for name, c in found if c.values + c.missing]


def _add_counts(made: Table, work: SomfaiWork) -> None:
    for name, c in _counts(work, "tables", "stated"):
        made.add_comment(f"count: {name} " + " ".join(f"{key} {value:.1f}" if key.startswith("chi2") else f"{key} {value}"
                                                      for key, value in c._asdict().items()))
    found = _claims(work.rows)
    if found:
        made.add_comment(f"claims: {len(found)} hold {found.count('holds')} contradicted {found.count('contradicted')} "
                         f"undecided {found.count('undecided')} missing {found.count('missing')}")
    for f in families(work.rows):
        if f.is_systematic:
            made.add_comment(f"systematic: {f.item} {f.quantity}, {_side(f, 'off on both sides')} at all {f.values} "
                             f"pressures, {100 * f.low:+.1f}% to {100 * f.high:+.1f}%, together {f.together:+.1f} errors")


# ---- cells of the report --------------------------------------------------------------------------------------------

def _number(format: str, x: float) -> str:
    return format % x if math.isfinite(x) else "–"


def _decimals(x: float, digits: int, zeros: bool) -> int:
    """Decimal places of `digits` significant digits of x. zeros: keep trailing zeros."""
    mantissa, _, exponent = f"{x:.{digits - 1}e}".partition("e")
    if not zeros:
        digits = max(1, len(mantissa.lstrip("-").replace(".", "").rstrip("0")))
    return min(9, max(0, digits - 1 - int(exponent)))


def _value(x: float, error: float, printed: bool) -> str:
    """A value and its error to the same decimal place: ours to two digits of the error, the paper's as printed."""
    if not math.isfinite(x):
        return "–"
    if not math.isfinite(error) or error <= 0:
        return f"{x:.4g}"
    places = _decimals(error, 2, not printed)
    if printed:
        places = max(places, _decimals(x, 4, False))
    return f"{x:.{places}f} ± {error:.{places}f}"


def _value_cells(row: Row) -> list[str]:
    theirs = f"≥ {row.paper:.3g}" if row.scatter == "bound" else _value(row.paper, row.paper_sd, True)
    return [row.item, row.quantity, _number("%.0e", row.p), theirs, _value(row.ours, row.err, False),
            _number("%+.2f", row.sigma), _number("%+.1f", row.deviation_err), row.verdict]


def _claim_cells(row: Row) -> list[str]:
    limit = f"{row.paper:.4g} ± {row.paper_sd:.2g}" if row.relation == "=" and row.paper_sd > 0 else \
        f"{'' if row.relation == '=' else row.relation + ' '}{row.paper:.4g}"
    return [row.where or "–", row.quantity, limit, _value(row.ours, row.err, False), row.verdict, row.note]


def _count_cells(name: str, c: Counts) -> list[str]:
    squares = [_number("%.1f", x) if c.judged else "–" for x in (c.chi2, c.chi2_without_rounding)]
    return [name, *map(str, (c.values, c.agree, c.judged, c.within1, c.beyond2, c.beyond3)), *squares]


_VALUES = ("item", "quantity", "p", "paper", "ours", "σ", "s.e.", "verdict")
_CLAIMS = ("in the paper", "claim", "paper", "ours", "verdict", "what was done")
_COUNTS = ("", "values", "within 1 σ", "with errors", "within 1 s.e.", "beyond 2", "beyond 3", "chi^2", "without "
                                                                                                        "rounding")


def write_summary(work: SomfaiWork, page: Page) -> None:
    _lead(work.rows, page)
    if work.rows:
        page.table(_COUNTS, [("", _count_cells(*each)) for each in _counts(work, "all means", "stated in words")])
    _systematic(work.rows, page)
    page.table(_VALUES, [(row.verdict, _value_cells(row)) for row in work.rows
                         if not row.is_claim and row.verdict != "agrees"])
    page.table(_CLAIMS, [(row.verdict, _claim_cells(row)) for row in work.rows
                         if row.is_claim and row.verdict != "holds"], True)


def _lead(rows: Sequence[Row], page: Page) -> None:
    means, stated, found = counted(rows), counted(rows, means=False), _claims(rows)
    values = len(rows) - len(found)
    if not rows:
        page.paragraph("Only figures were asked for, which have no values to compare.")
    if values:
        page.paragraph(
            f"Of {values} values of the paper {means.agree + stated.agree} agree within one standard deviation, "
            f"{means.values - means.agree + stated.values - stated.agree} deviate, and "
            f"{means.missing + stated.missing} could not be compared.", "By the scatter of one sample.")
    if means.judged:
        page.paragraph(
            f"Of {means.judged} means that the paper prints {means.within1} lie within one combined standard "
            f"error, {means.beyond2} beyond two and {means.beyond3} beyond three; chi^2 = {means.chi2:.0f} "
            f"({means.chi2_without_rounding:.0f} without the rounding of print). This is the sharper measure, and shows "
            "differences that the scatter of one sample hides.", "By the standard errors of both means.")
    if found:
        page.paragraph(
            f"Of {len(found)} claims {found.count('holds')} hold, {found.count('contradicted')} are contradicted, "
            f"{found.count('undecided')} are undecided, and {found.count('missing')} could not be examined.",
            "Claims in words.")


def _systematic(rows: Sequence[Row], page: Page) -> None:
    """Caveats: the error of the paper's mean is unknown if few packings dominate it, and the values of one table
    come from the same packings."""
    known = [family for family in families(rows) if family.values >= 3]
    found = [family for family in known if family.is_systematic]
    if found:
        page.paragraph("Quantities that lie on one side of the paper at all pressures, and together beyond three "
                       "errors; or off at all pressures, none within two errors:", "Systematic deviations.")
    elif known:
        page.paragraph("None.", "Systematic deviations.")
    for f in found:
        page.paragraph(f"{f.item}, {f.quantity}: {_side(f, 'off, on both sides,')} at all {f.values} pressures, by "
                       f"{100 * f.low:+.1f}% to {100 * f.high:+.1f}%; {f.together:+.1f} errors together.")


def write_tables(page: Page, rows: Sequence[Row]) -> None:
    page.table(_VALUES[1:], [(row.verdict, _value_cells(row)[1:]) for row in rows if not row.is_claim])
    page.table(_CLAIMS, [(row.verdict, _claim_cells(row)) for row in rows if row.is_claim], True)


def what_was_run(work: SomfaiWork) -> str:
    return (f"somfai2005 with {work.samples} samples a pressure (2400 grains: half as many; spheres: a quarter), "
            f"protocol {work.protocol}; {work.computed} samples made in this run, {work.failed} that failed or "
            f"lack a part; {work.watch.seconds:.0f} seconds.")
