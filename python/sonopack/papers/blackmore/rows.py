"""Rows: a published value or claim beside ours, the verdict, their table and their report."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from ..._table import Table
from ..report import Page
from ..work import Work, by_key

OF_FIGURES = ""
_COLUMNS: dict[str, type] = {
    **dict.fromkeys(("item", "equation", "quantity", "unit", "relation"), str),
    **dict.fromkeys(("paper", "precision", "ours", "err"), float), "verdict": str, "note": str}


@dataclasses.dataclass(frozen=True)
class Row:
    """A value of the paper, which may be NAN, and ours. err: bound of our error, 0 for rounding alone, NAN if none is
    known. detail: left out of the report."""

    item: str
    equation: str
    quantity: str
    unit: str
    relation: str
    paper: float
    precision: float
    ours: float
    err: float
    kind: str
    note: str
    detail: bool = False

    @property
    def _error(self) -> float:
        return self.err if math.isfinite(self.err) else 0.0

    def holds(self) -> bool:
        """Whether the relation is true of our value, within precision and error."""
        return {">": self.ours - self._error > self.paper, "<": self.ours + self._error < self.paper,
                "=": abs(self.ours - self.paper) <= self.precision + self._error}[self.relation]

    def is_near(self) -> bool:
        """Whether our value lies within its error of the limit."""
        off = abs(self.ours - self.paper)
        if self.relation == "=":
            return self.precision < off <= self.precision + self._error and self._error > self.precision
        return off <= self._error

    @property
    def verdict(self) -> str:
        """By kind, whether the relation holds: what the table says."""
        if math.isnan(self.ours):
            return "missing"
        if math.isnan(self.paper):
            return "erratum" if self.kind == "erratum" else "not given"
        if self.kind == "claim" and self.is_near():
            return "undecided"
        return _VERDICTS[self.kind][self.holds()]


_VERDICTS = {"claim": ("contradicted", "holds"), "erratum": ("erratum", "agrees"), "value": ("deviates", "agrees")}


def add(work: Work, key: str, ours: float, err: float | None = None, *, paper: float | None = None,
        detail: bool = False, **words: object) -> None:
    """Adds the row `key` of rows.tsv with our value. err, paper: where they are computed. words: of quantity and
    note."""
    row = by_key("blackmore", "rows")[key]
    work.rows.append(Row(
        row["item"], row["equation"], row["quantity"].format(**words), row["unit"] or "-", row["relation"],
        float(row["paper"]) if paper is None else float(paper), float(row["precision"]), float(ours),
        float(row["err"]) if err is None else float(err), row["kind"], row["note"].format(**words) or "-", detail))


def table(work: Work, rows: Sequence[Row]) -> Table:
    """The rows as a table."""
    return work.table(rows, _COLUMNS)


# ---- the report -----------------------------------------------------------------------------------------------------

_HEAD = ("item", "in [B]", "quantity", "paper", "ours", "verdict", "note")


def _number(x: float, error: float, before: str = "") -> str:
    if math.isnan(x):
        return "–"
    if math.isinf(x):
        return f"{before}{'-' if x < 0 else ''}∞"
    return f"{before}{x:.7g}" + (f" +- {error:.2g}" if error > 1e-6 * abs(x) else "")


def _cells(row: Row) -> list[str]:
    before = "" if row.relation == "=" else f"{row.relation} "
    return [row.item, row.equation, row.quantity + (f" [{row.unit}]" if row.unit != "-" else ""),
            _number(row.paper, row.precision, before), _number(row.ours, row.err), row.verdict,
            row.note if row.note != "-" else ""]


def write_summary(work: Work, page: Page) -> None:
    found = [row.verdict for row in work.rows]
    claims = sum(found.count(verdict) for verdict in ("holds", "contradicted", "undecided"))
    faults = [row for row in work.rows if row.verdict in ("deviates", "contradicted", "undecided")]
    page.paragraph(
        f"Of {len(found) - claims} values {found.count('agrees')} agree with the paper, {found.count('deviates')} "
        f"deviate, {found.count('erratum')} are errata, and {found.count('not given')} are not given there; of "
        f"{claims} claims {found.count('holds')} hold, {found.count('contradicted')} are contradicted and "
        f"{found.count('undecided')} are undecided.{' What deviates or does not hold:' if faults else ''}")
    page.table(_HEAD, [(row.verdict, _cells(row)) for row in faults], True)


def write_tables(page: Page, rows: Sequence[Row]) -> None:
    page.table(_HEAD[1:], [(row.verdict, _cells(row)[1:]) for row in rows if not row.detail], True)


def what_was_run(work: Work) -> str:
    return f"blackmore2011; {work.watch.seconds:.1f} seconds."
