"""`sonopack reproduce`: computes the tables and figures of a paper and compares them with the printed values."""
from __future__ import annotations

import argparse
import difflib
import importlib

from .. import __version__
from .._command import Failed, Parser, cores, note, usage, whole, write_table
from .._core import Interrupted
from .._table import Table
from . import report
from .work import Work, by_key

#: papers, and the packages of their work
PAPERS = {"somfai2005": "somfai", "blackmore2011": "blackmore"}
PROTOCOLS = ("default", "somfai2005", "quick", "affine")

_ABOUT = (
    "Computes the results of a paper and compares them with the printed values. somfai2005: E. Somfai, J.-N. Roux, J. "
    "H. Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E 72, 021301 (2005), with newly compressed packings. "
    "blackmore2011: D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. Mater. Struct. 6 (2011), "
    "on the tapped column.")
_MORE = """\
With -o FOLDER a report is written, report.html and report.md, with all figures and their numbers.

somfai2005 prints one row per value: mean and standard deviation in the paper, our mean and its standard error, the
difference in standard deviations (sigma), and the verdict: agrees (within one standard deviation), deviates, or
missing (no value or no scatter). deviation_err is the difference divided by the standard errors of both means and the
rounding in print. Comments count both, with chi^2 and with systematic differences. Statements in words hold, are
contradicted or undecided. Items: table1 to table5, fig1 to fig12, claims; only the samples that they need are
computed. The samples stay in the store: an interrupted run continues where it stopped, and further samples or items
reuse what is there.

blackmore2011 prints one row per value: what is printed or follows from it, our value with its error, the verdict
(agrees, deviates, erratum, not given; for statements holds, contradicted, undecided), and the reason. Items: errata,
fig1, fig2, symbols, chaos, claims. This takes seconds and needs no store.

  sonopack reproduce somfai2005 --store results/somfai2005 -o results/report
  sonopack reproduce somfai2005 --only table2,fig8 --samples 4 --store results/somfai2005
  sonopack reproduce blackmore2011 --only errata"""


def parser() -> Parser:
    """The options of the command."""
    own = Parser("reproduce", description=_ABOUT, epilog=_MORE,
                 usage="sonopack reproduce somfai2005 --store DIR [-o FOLDER]\n       sonopack reproduce blackmore2011 "
                       "[-o FOLDER]")
    own.add_argument("paper", nargs="?", choices=PAPERS, help="the paper")
    own.add_argument("--store", metavar="DIR", help="somfai2005: folder of the samples; it is created if necessary")
    own.add_argument("--only", metavar="ITEMS", help="compute only these items, as in fig6,table2 or fig1,chaos (all)")
    own.add_argument("--samples", metavar="N", type=whole(1, 100000),
                     help="somfai2005: number of packings at each pressure (30, as in the paper)")
    own.add_argument("--jobs", metavar="N", type=whole(1, 4096),
                     help="somfai2005: number of samples computed at the same time (one per core)")
    own.add_argument("--figures", choices=("svg", "png", "pdf"), default="svg", help="format of the figures (svg)")
    own.add_argument("--protocol", choices=PROTOCOLS,
                     help="somfai2005: how packings are compressed, as packing.protocol: default; somfai2005, the same "
                          "motion in shorter steps; or quick and affine, with other materials, in less time. "
                          "Lattices of unequal balls always use the default")
    own.add_argument("--dry-run", action="store_true",
                     help="make and write nothing: print what would be made, and what CPU time, memory and disk it "
                          "would take")
    return own


def chosen(paper: str, only: str | None) -> set[str]:
    """The items of --only; none for all."""
    items = by_key(PAPERS[paper], "items", "name")
    names = only.split(",") if only is not None else []
    for name in names:
        if name not in items:
            near = difflib.get_close_matches(name, items, 1)
            raise usage(f"--only {name:.60}: {f'did you mean {near[0]}? ' if near else ''}must be one of "
                        f"{', '.join(items)}")
    return set(names)


def run(arguments: argparse.Namespace) -> int:
    """Does the work of the command."""
    if arguments.paper is None:
        raise usage(f"no paper: must be {' or '.join(PAPERS)}")
    if arguments.paper == "somfai2005" and not arguments.store:
        raise usage("no store: must be --store DIR")
    if arguments.set:
        raise usage("--set: not used here, because the paper determines the scenes")
    if arguments.units == "si":
        raise usage("--units si: the report is in the units of the paper")
    wanted = chosen(arguments.paper, arguments.only)
    arguments.threads = arguments.threads or cores()
    if arguments.dry_run:
        from . import plan

        table = plan.table(arguments, wanted)
    else:
        table = _reproduce(arguments, wanted)
    table.add_comment(f"sonopack {__version__}")
    arguments.output = None  # the folder of the report; the table goes to stdout
    write_table(arguments, table)
    return 0


def _reproduce(arguments: argparse.Namespace, wanted: set[str]) -> Table:
    """The table of the rows, and the report if there is a folder for it."""
    column = arguments.paper == "blackmore2011"
    if arguments.output is not None:
        report.take_folder(arguments.output, arguments.force)
    for name in ("jobs", "samples", "protocol") if column else ():
        if getattr(arguments, name) is not None:
            note(arguments, f"--{name} has no effect: blackmore2011 needs no packings")
    work, room = _work(arguments, wanted), f"sonopack.papers.{PAPERS[arguments.paper]}"
    if work.folder:
        report.begin(work.folder)
    try:
        importlib.import_module(room).make(work)
    except (KeyboardInterrupt, Interrupted):
        raise Failed("stopped, and nothing was saved" if column else f"stopped: all finished samples are in "
                     f"{arguments.store}, and the same command continues") from None
    finally:
        work.watch.clear()
    paper = importlib.import_module(f"{room}.rows")
    table: Table = paper.table(work, work.rows)
    if work.folder:
        report.write(paper, work)
    _notes(arguments, work)
    return table


def _work(arguments: argparse.Namespace, wanted: set[str]) -> Work:
    if arguments.paper == "blackmore2011":
        return Work("blackmore", "reproduce blackmore2011", wanted, arguments)
    from .somfai.samples import SomfaiWork

    return SomfaiWork(arguments, wanted)


def _notes(arguments: argparse.Namespace, work: Work) -> None:
    failed = getattr(work, "failed", 0)
    if failed:
        note(arguments, f"{failed} samples failed or lack a result: the column `samples' counts those that were used")
    if work.folder:
        note(arguments, f"report: {work.folder}/report.html")
    elif not work.rows:
        note(arguments, "there are no values to compare, and figures need -o FOLDER")
