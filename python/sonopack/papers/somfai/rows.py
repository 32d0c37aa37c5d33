"""The table of the rows, and what the report says beside the items."""
from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._table import Table
from ..page import Page
from .samples import SomfaiWork
from .verdict import Counts, Family, Row, counted, families

_COMMENTS = (
    "values of Somfai et al., Phys. Rev. E 72, 021301 (2005), beside ours; units: d, E*, sqrt(E* / rho)",
    "err: standard error of our mean; ours_sd: one standard deviation of our samples",
    "sigma = (ours - paper)/scatter, agrees within one; scatter paper: paper_sd, its standard deviation",
    "scatter ours: the paper gives none, ours_sd; stated: paper_sd, the precision of the words, and err in square",
    "scatter bound: the paper gives a lower bound, paper_sd is our precision; above it sigma is 0",
    "combined = (ours - paper) over both standard errors, that of the paper with 30 samples; nan for one sample",
    "deviation_err = the same with the rounding of print in square, uniform within half of the last digit",
    "scatter claim: a claim in words, relation: what it says of ours (= within paper_sd); it holds or is",
    "contradicted, or is undecided: ours lies within two standard errors of the limit",
    "verdict missing: there is no value of ours, or no scatter, as that of one sample")
_COLUMNS = {"item": str, "p": float, "quantity": str, "paper": float, "paper_sd": float, "ours": float, "err": float,
            "sigma": float, "verdict": str, "ours_sd": float, "samples": int, "combined": float, "scatter": str,
            "deviation_err": float, "rounding": float, "relation": str, "where": str, "note": str}


def rows_table(work: SomfaiWork, rows: Sequence[Row]) -> Table:
    """Rows as a table."""
    cells: dict[str, list[Any]] = {name: [getattr(row, name) for row in rows] for name in _COLUMNS}
    cells["relation"] = [">" if row.scatter == "bound" else row.relation for row in rows]
    # the place is that of the title of the item: "Table I" of "Table I. Statics", "Fig. 6" of "Fig. 6. Arrival times"
    places = {item: " ".join(row["title"].split()[:2]).rstrip(".") for item, row in work.items.items()}
    cells["where"] = [row.where or places[row.item] for row in rows]
    cells["note"] = [row.note or "-" for row in rows]
    table = Table.from_columns({name: np.array(cells[name], kind) for name, kind in _COLUMNS.items()}, {"p": "E*"})
    for line in _COMMENTS:
        table.add_comment(line)
    return table


def _side(family: Family, both: str) -> str:
    return "high" if family.side > 0 else "low" if family.side < 0 else both


def _claims(rows: Sequence[Row]) -> list[str]:
    return [row.verdict for row in rows if row.is_claim]


def add_counts(table: Table, items: Sequence[str], rows: Sequence[Row]) -> None:
    """Adds counts, claims and families as comments, one a line."""
    counts = [(item, counted(rows, item)) for item in items]
    for name, c in [*counts, ("tables", counted(rows)), ("stated", counted(rows, means=False))]:
        if c.values + c.missing:
            table.add_comment(
                f"count: {name} values {c.values} agree {c.agree} missing {c.missing} judged {c.judged} within1 {c.within1} "
                f"beyond2 {c.beyond2} beyond3 {c.beyond3} chi2 {c.chi2:.1f} chi2_without_rounding {c.chi2_bare:.1f}")
    found = _claims(rows)
    if found:
        table.add_comment(f"claims: {len(found)} hold {found.count('holds')} contradicted {found.count('contradicted')} "
                          f"undecided {found.count('undecided')} missing {found.count('missing')}")
    for f in families(rows):
        if f.is_systematic:
            table.add_comment(f"systematic: {f.item} {f.quantity}, {_side(f, 'off on both sides')} at all {f.values} "
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
    squares = [_number("%.1f", x) if c.judged else "–" for x in (c.chi2, c.chi2_bare)]
    return [name, *map(str, (c.values, c.agree, c.judged, c.within1, c.beyond2, c.beyond3)), *squares]


_VALUES = ("item", "quantity", "p", "paper", "ours", "σ", "s.e.", "verdict")
_CLAIMS = ("in the paper", "claim", "paper", "ours", "verdict", "what was done")
_COUNTS = ("", "values", "within 1 σ", "with errors", "within 1 s.e.", "beyond 2", "beyond 3", "chi^2", "without rounding")
_HOW = (
    "Paper: mean and one standard deviation of its samples. Ours: mean and its standard error. σ: the difference over one "
    "standard deviation of the paper; where it gives none (normal forces, their moments, fabric) over that of our samples; "
    "for values that the paper states in words over the precision of the words and our standard error together, and 0 above "
    "a lower bound (≥). A value agrees when σ is within one; with few samples more of them deviate by chance. Missing: ours "
    "has no value, or a single sample no scatter. s.e.: the difference over the standard errors of both means together, 30 "
    "samples taken for the paper, and the rounding of print (uniform within half of the last digit). Values of one table "
    "come from the same packings, so that chi^2 is no sum of independent parts. Claims hold or are contradicted where ours "
    "is two standard errors away from the limit, else they are undecided.")


class Report:
    """What the report says beside the items."""

    TITLE = "Elastic wave propagation in confined granular systems, computed again"
    OPENING = (
        "Tables and figures of E. Somfai, J.-N. Roux, J. H. Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E 72, 021301 "
        "(2005), beside values and figures of new packings. Units: lengths in mean grain diameters d, pressures in E*, speeds "
        "in sqrt(E*/rho), times in d/sqrt(E*/rho).")
    FILES = ("The numbers behind each figure and table are beside it in a file of the same name: fig6.tsv, table1.tsv; values "
             "of figures that the paper states in fig6-values.tsv and so on.")

    def table(self, work: SomfaiWork) -> Table:
        table = rows_table(work, work.rows)
        add_counts(table, list(work.items), work.rows)
        return table

    def summary(self, work: SomfaiWork, page: Page) -> None:
        self._lead(work.rows, page)
        if work.rows:
            counts = [(item, counted(work.rows, item)) for item in work.items]
            counts += [("all means", counted(work.rows)), ("stated in words", counted(work.rows, means=False))]
            page.table(_COUNTS, [("", _count_cells(*each)) for each in counts if each[1].values + each[1].missing])
        self._systematic(work.rows, page)
        page.table(_VALUES, [(row.verdict, _value_cells(row)) for row in work.rows
                             if not row.is_claim and row.verdict != "agrees"])
        page.table(_CLAIMS, [(row.verdict, _claim_cells(row)) for row in work.rows
                             if row.is_claim and row.verdict != "holds"], True)
        page.paragraph(_HOW, "How to read the tables.")

    @staticmethod
    def _lead(rows: Sequence[Row], page: Page) -> None:
        means, stated, found = counted(rows), counted(rows, means=False), _claims(rows)
        values = len(rows) - len(found)
        if not rows:
            page.paragraph("Only figures were asked for, which have no values to compare.")
        if values:
            page.paragraph(
                f"Of {values} values of the paper {means.agree + stated.agree} agree within one standard deviation, "
                f"{means.values - means.agree + stated.values - stated.agree} deviate, and {means.missing + stated.missing} "
                "could not be compared.", "By the scatter of one sample.")
        if means.judged:
            page.paragraph(
                f"Of {means.judged} means that the paper prints {means.within1} lie within one combined standard error, "
                f"{means.beyond2} beyond two and {means.beyond3} beyond three; chi^2 = {means.chi2:.0f} "
                f"({means.chi2_bare:.0f} without the rounding of print). This is the sharper measure, and shows differences "
                "that the scatter of one sample hides.", "By the standard errors of both means.")
        if found:
            page.paragraph(
                f"Of {len(found)} claims {found.count('holds')} hold, {found.count('contradicted')} are contradicted, "
                f"{found.count('undecided')} are undecided, and {found.count('missing')} could not be examined.",
                "Claims in words.")

    @staticmethod
    def _systematic(rows: Sequence[Row], page: Page) -> None:
        """Caveats: the error of the paper's mean is unknown if few packings dominate it, and the values of one table come
        from the same packings."""
        known = [family for family in families(rows) if family.values >= 3]
        found = [family for family in known if family.is_systematic]
        if found:
            page.paragraph("Quantities that lie on one side of the paper at all pressures, and together beyond three errors; "
                           "or off at all pressures, none within two errors:", "Systematic deviations.")
        elif known:
            page.paragraph("None.", "Systematic deviations.")
        for f in found:
            page.paragraph(f"{f.item}, {f.quantity}: {_side(f, 'off, on both sides,')} at all {f.values} pressures, by "
                           f"{100 * f.low:+.1f}% to {100 * f.high:+.1f}%; {f.together:+.1f} errors together.")

    def tables(self, work: SomfaiWork, page: Page, item: str) -> None:
        own = [row for row in work.rows if row.item == item]
        page.table(_VALUES[1:], [(row.verdict, _value_cells(row)[1:]) for row in own if not row.is_claim])
        page.table(_CLAIMS, [(row.verdict, _claim_cells(row)) for row in own if row.is_claim], True)

    def save_rows(self, work: SomfaiWork, item: str) -> None:
        own = [row for row in work.rows if row.item == item]
        if own:
            work.save_table(item + ("-values" if item.startswith("fig") else ""), rows_table(work, own))

    def run(self, work: SomfaiWork) -> str:
        return (f"somfai2005 with {work.samples} samples a pressure (2400 grains: half as many; spheres: a quarter), protocol "
                f"{work.protocol}; {work.computed} samples made in this run, {work.failed} that failed or lack a part; "
                f"{work.watch.seconds:.0f} seconds.")
