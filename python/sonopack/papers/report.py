"""The report on a paper: a summary, then each item with its sentences, tables and figures; in two forms with the same content,
report.html and report.md, in a folder of its own."""
from __future__ import annotations

import html
import os
import pathlib
import re
from collections.abc import Sequence
from typing import Any

from .. import __version__
from .._command import Failed, usage, whole_file
from .work import Work

#: first lines of a report, and of an unfinished one
MARK = "<!-- sonopack reproduce -->"
UNFINISHED = "This report is not finished."


def take_folder(folder: str, replace: bool) -> None:
    """Makes the folder of a report. It must be new, empty, or have an unfinished report; with `replace`, any report."""
    if not 0 < len(folder) <= 3800:
        raise usage(f"folder '{folder:.100}': a path of 1 to 3800 characters")
    if not os.path.lexists(folder):
        try:
            os.mkdir(folder)
        except OSError as fault:
            raise Failed(f"cannot make the folder {folder}: {fault.strerror}") from None
    if not os.path.isdir(folder):
        raise usage(f"{folder}: is no folder: must be one for the report and its figures")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise Failed(f"cannot write in {folder}: no permission")
    head = _head(folder)
    if os.listdir(folder) and not head.startswith(MARK):
        raise usage(f"{folder}: has other files in it and no report: must be a new or an empty folder")
    if head and UNFINISHED not in head and not replace:
        raise usage(f"{folder}: has a report already: must be another folder, or give --force")


def _head(folder: str) -> str:
    try:
        with open(os.path.join(folder, "report.md"), encoding="utf-8", errors="replace") as file:
            return file.read(255)
    except FileNotFoundError:
        return ""


def begin(folder: str) -> None:
    """Writes the report.md of an unfinished report."""
    _save(folder, "md", f"{MARK}\n\n{UNFINISHED} The same command goes on with it.\n")


def _save(folder: str, ending: str, text: str) -> None:
    with whole_file(os.path.join(folder, f"report.{ending}")) as draft, open(draft, "w", encoding="utf-8") as file:
        file.write(text)


def _html(text: str) -> str:
    return html.escape(text.replace("+-", "±"), quote=True).replace("&#x27;", "'")


def _markdown(text: str) -> str:
    return re.sub(r"([*_|<>\\])", r"\\\1", text.replace("+-", "±"))


class Page:
    """The two forms as they grow. Texts are plain: what is special is escaped, and +- becomes ±."""

    def __init__(self, title: str) -> None:
        style = pathlib.Path(__file__).with_name("report.css").read_text(encoding="utf-8")
        self.html = [f'<!DOCTYPE html>\n{MARK}\n<html lang="en"><head><meta charset="utf-8">\n'
                     '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
                     f"<title>{title}</title>\n<style>\n{style}</style></head>\n<body>\n<h1>{title}</h1>\n"]
        self.markdown = [f"{MARK}\n\n# {title}\n\n"]

    def heading(self, name: str, text: str) -> None:
        self.html.append(f'<h2 id="{name}">{_html(text)}</h2>\n')
        self.markdown.append(f"## {_markdown(text)}\n\n")

    def paragraph(self, text: str, lead: str = "") -> None:
        """lead: words in bold before the text."""
        self.html.append(f"<p>{f'<b>{lead}</b> ' if lead else ''}{_html(text)}</p>\n")
        self.markdown.append(f"{f'**{lead}** ' if lead else ''}{_markdown(text)}\n\n")

    def table(self, head: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]], sentence: bool = False) -> None:
        """rows: style and cells of each. sentence: the last cell holds a sentence and may be broken into lines."""
        if not rows:
            return
        self.html.append('<div class="wide"><table>\n<tr>' + self._cells("th", head))
        self.markdown.append(self._row(head) + "|" + "---|" * len(head) + "\n")
        for style, cells in rows:
            self.html.append(f'<tr class="{style}">' + self._cells("td", cells, len(cells) - 1 if sentence else -1))
            self.markdown.append(self._row(cells))
        self.html.append("</table></div>\n")
        self.markdown.append("\n")

    @staticmethod
    def _cells(tag: str, cells: Sequence[str], sentence: int = -1) -> str:
        style = [' class="sentence"' if k == sentence else "" for k in range(len(cells))]
        return "".join(f"<{tag}{words}>{_html(cell)}</{tag}>" for words, cell in zip(style, cells)) + "</tr>\n"

    @staticmethod
    def _row(cells: Sequence[str]) -> str:
        return "|" + "".join(f" {_markdown(cell)} |" for cell in cells) + "\n"

    def figure(self, file: str, caption: str) -> None:
        """A file of the folder: an image, or for PDF a link."""
        shown = not file.endswith(".pdf")
        inside = f'<img src="{file}" alt="{_html(caption)}">' if shown else f'<a href="{file}">{file}</a>'
        self.html.append(f"<figure>{inside}<figcaption>{_html(caption)}</figcaption></figure>\n")
        self.markdown.append(f"{'!' if shown else ''}[{_markdown(caption)}]({file})\n\n")
        if shown:
            self.markdown.append(f"*{_markdown(caption)}*\n\n")

    def save(self, folder: str) -> None:
        self.html.append("</body></html>\n")
        _save(folder, "html", "".join(self.html))
        _save(folder, "md", "".join(self.markdown))


# ---- the whole ------------------------------------------------------------------------------------------------------

def write(paper: Any, work: Work) -> None:
    """Writes report.html and report.md, and a table of the rows of each item. paper: the module with the summary of the
    report, the tables of an item, and what was run; OF_FIGURES: how names of tables of figures end."""
    page = Page(work.texts["title"])
    page.paragraph(work.texts["opening"])
    page.heading("summary", "Summary")
    paper.write_summary(work, page)
    page.paragraph(work.texts["reading"], "How to read the tables.")
    page.paragraph(f"sonopack {__version__}, reproduce {paper.what_was_run(work)}", "Run.")
    for item in work.wanted:
        page.heading(item, work.items[item]["title"])
        page.paragraph(work.items[item]["shows"], "In the paper.")
        for k, text in enumerate(work.sections[item].sentences):
            page.paragraph(text, "" if k else "Here.")
        rows = [row for row in work.rows if row.item == item]
        paper.write_tables(page, rows)
        for file, caption in work.sections[item].figures:
            page.figure(file, caption)
        if rows:
            work.save_table(item + (paper.OF_FIGURES if item.startswith("fig") else ""), paper.table(work, rows))
    page.heading("files", "Files")
    page.paragraph(work.texts["files"])
    page.save(work.folder)
