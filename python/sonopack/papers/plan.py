"""--dry-run: what the command would make, and what that would take: as `sonopack study' says of each ensemble, and the items."""
from __future__ import annotations

import argparse
import subprocess
import tempfile
from typing import Any

import numpy as np

from .._command import Failed, program
from .._core import call
from .._native import ffi, lib
from .._table import Table
from .somfai.samples import SAMPLES, ensembles, scene
from .work import by_key

Row = tuple[Any, ...]
COSTS = ("cpu_s", "wall_s", "memory_MB", "disk_MB")


def table(arguments: argparse.Namespace, wanted: set[str]) -> Table:
    """What `sonopack reproduce` would make."""
    packings, drawn = arguments.paper == "somfai2005", arguments.output is not None
    items = by_key("somfai" if packings else "blackmore", "items", "name")
    chosen = [name for name in items if not wanted or name in wanted]
    machine = ffi.new("sp_machine *")
    call(lib.sp_machine_measure, 1, machine)
    made = _ensembles(arguments, chosen, drawn) if packings else []
    rows = [row for _, some in made for row in some]
    seconds = machine.slower[0] * sum(float(items[name]["seconds_drawn" if drawn else "seconds"]) for name in chosen)
    rows.append(("items and figures" if drawn else "items", len(chosen), seconds, seconds, 25.0,
                 0.4 * len(chosen) if drawn else 0.0))
    cpu, wall, memory, disk = np.array([row[2:] for row in rows]).T
    longest = max((total[1] for total, _ in made), default=0.0)
    rows.append(("total", 1, cpu.sum(), max(wall.sum(), longest), memory.max(), disk.sum()))
    # three digits: more would claim what is not known
    columns = {name: [row[k] if k < 2 else float(f"{row[k]:.3g}") for row in rows]
               for k, name in enumerate(("what", "count", *COSTS))}
    plan = Table.from_columns(columns, {name: name.split("_")[1] for name in COSTS})
    for line in ("dry run: nothing was made", f"threads = {arguments.threads}",
                 f"machine_step = {machine.slower[0]:.2f}",
                 "machine: time of a kernel on this machine, now, over that on the machine of the laws",
                 "accuracy = 2 (factor of cpu_s and wall_s in nine cases of ten; wall_s on free cores)"):
        plan.add_comment(line)
    return plan


def _ensembles(arguments: argparse.Namespace, items: list[str], drawn: bool) -> list[tuple[Row, list[Row]]]:
    """The costs of each ensemble and its rows. An ensemble that has the name of one before gets a number."""
    found, names = [], list[str]()
    for key, want in ensembles(items, drawn).items():
        names.append(by_key("somfai", "ensembles")[key]["name"])
        name = names[-1] + f" {names.count(names[-1])}" * (names.count(names[-1]) > 1)
        table = _study(arguments, key, want)
        cells: list[Row] = list(zip(*(table[column].tolist() for column in table.names)))
        found.append((cells[-1][2:], [(f"{name}: {row[0]}", *row[1:]) for row in cells[:-1]]))
    return found


def _study(arguments: argparse.Namespace, ensemble: str, want: set[str]) -> Table:
    """What `sonopack study --dry-run' prints of an ensemble."""
    own = scene(ensemble, arguments.samples or SAMPLES, arguments.protocol or "default", want)
    words = ["--store", arguments.store, "--jobs", arguments.jobs or arguments.threads, "--threads", arguments.threads]
    with tempfile.NamedTemporaryFile(prefix="sonopack-", suffix=".tsv") as made:
        done = subprocess.run([program(), "study", "/dev/stdin", "--dry-run", *map(str, words)],
                              input=own.text, stdout=made, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise Failed(done.stderr.removeprefix("sonopack: ").strip())
        return Table.read(made.name)
