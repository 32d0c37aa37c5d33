"""Writes the report on a paper: a summary, then each item with its sentences, tables and figures."""
from __future__ import annotations

from typing import Protocol

from .. import __version__
from .._table import Table
from .page import Page
from .work import Work


class Paper(Protocol):
    """What is different from paper to paper."""

    TITLE: str
    OPENING: str
    FILES: str  #: what the files of the folder are

    def table(self, work: Work) -> Table:
        """All rows as a table."""

    def summary(self, work: Work, page: Page) -> None:
        """Counts of the verdicts, the rows that need attention, and how to read them."""

    def tables(self, work: Work, page: Page, item: str) -> None:
        """The tables of the rows of an item."""

    def save_rows(self, work: Work, item: str) -> None:
        """Writes the rows of an item as a file."""

    def run(self, work: Work) -> str:
        """What was run, for the end of the summary."""


def write(paper: Paper, work: Work) -> None:
    """Writes report.html and report.md, and a table of the rows of each item."""
    page = Page(paper.TITLE)
    page.paragraph(paper.OPENING)
    page.heading("summary", "Summary")
    paper.summary(work, page)
    page.paragraph(f"sonopack {__version__}, reproduce {paper.run(work)}", "Run.")
    for item in work.wanted:
        page.heading(item, work.items[item]["title"])
        page.paragraph(work.items[item]["shows"], "In the paper.")
        page.paragraphs(work.sections[item].sentences, "Here.")
        paper.tables(work, page, item)
        for file, caption in work.sections[item].figures:
            page.figure(file, caption)
        paper.save_rows(work, item)
    page.heading("files", "Files")
    page.paragraph(paper.FILES)
    page.save(work.folder)
