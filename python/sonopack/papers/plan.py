"""--dry-run: a table of what the command would make, and what that would take."""
from __future__ import annotations

import argparse
import os
from typing import Any

import numpy as np

from .._core import call, text_of
from .._native import ffi, lib
from .._study import Store
from .._table import Table
from .somfai.samples import SAMPLES, needs, scene
from .work import by_key

PROGRAM = 15e6  # bytes of a command that does next to nothing
KERNELS = ("step", "product", "dense", "sparse")


@ffi.def_extern(error=False)  # type: ignore[misc]
def sonopack_forecast_packed(user: Any, name: Any) -> bool:
    """Whether the store, whose folder is `user`, has the file of a sample."""
    return os.access(os.path.join(ffi.from_handle(user), f"{text_of(name)}.h5"), os.R_OK)


class Plan:
    """Rows of the table, and their sum. machine: how slow this one is."""

    def __init__(self, arguments: argparse.Namespace, kernels: tuple[str, ...]) -> None:
        self.machine = ffi.new("sp_machine *")
        call(lib.sp_machine_measure, sum(1 << KERNELS.index(name) for name in kernels), self.machine)
        slower = [f"machine_{name} = {self.machine.slower[KERNELS.index(name)]:.2f}" for name in kernels]
        self.comments = [
            "dry run: nothing was made", f"threads = {arguments.threads}", *slower,
            "machine: time of a kernel on this machine, now, over that on the machine of the laws",
            "accuracy = 2 (factor of cpu_s and wall_s in nine cases of ten; wall_s on free cores)"]
        self.rows: list[tuple[Any, ...]] = []
        self.cpu = self.wall = self.memory = self.bytes = self.longest = 0.0

    def add(self, what: str, number: int, cpu: float, wall: float, memory: float, on_disk: float) -> None:
        """A row of work; memory and disk in bytes."""
        self.cpu, self.wall, self.bytes = self.cpu + cpu, self.wall + wall, self.bytes + on_disk
        self.memory = max(self.memory, memory)
        self.note(what, number, cpu, wall, 1e-6 * (PROGRAM + memory), 1e-6 * on_disk)

    def note(self, what: str, number: int, *costs: float) -> None:
        """A row as it stands; without costs one that costs nothing. Three digits: more would claim what is not
        known."""
        self.rows.append((what, number, *(float(f"{cost:.3g}") for cost in costs or (0.0,) * 4)))

    def table(self) -> Table:
        """The rows and their total."""
        self.note("total", 1, self.cpu, max(self.wall, self.longest), 1e-6 * (PROGRAM + self.memory), 1e-6 * self.bytes)
        names = ("what", "count", "cpu_s", "wall_s", "memory_MB", "disk_MB")
        columns = dict(zip(names, map(np.array, zip(*self.rows))))
        made = Table.from_columns(columns, {name: name.split("_")[1] for name in names[2:]})
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        if PROGRAM + self.memory > 0.5 * memory:  # what is expected is within a factor of 2
            self.comments.append(f"warning: there are {1e-6 * memory:.3g} MB of memory, which may be too little")
        for line in self.comments:
            made.add_comment(line)
        return made


def table(arguments: argparse.Namespace, wanted: set[str]) -> Table:
    """What `sonopack reproduce` would make."""
    packings = arguments.paper == "somfai2005"
    plan = Plan(arguments, ("step", "product", "sparse") if packings else ("step",))
    items = by_key("somfai" if packings else "blackmore", "items", "name")
    chosen, drawn = [name for name in items if not wanted or name in wanted], arguments.output is not None
    if packings:
        _ensembles(plan, arguments, chosen, drawn)
    seconds = sum(float(items[name]["seconds_drawn" if drawn else "seconds"])
                  for name in chosen) * plan.machine.slower[0]
    plan.add("items and figures" if drawn else "items", len(chosen), seconds, seconds, 1e7,
             4e5 * len(chosen) if drawn else 0)
    return plan.table()


def _ensembles(plan: Plan, arguments: argparse.Namespace, items: list[str], drawn: bool) -> None:
    want: dict[str, set[str]] = {}
    for item in items:
        for ensemble, parts in needs(item, drawn).items():
            want.setdefault(ensemble, set()).update(parts)
    names: list[str] = []
    for key, row in by_key("somfai", "ensembles").items():
        if key in want:
            names.append(row["name"])
            same = names.count(row["name"])
            _samples(plan, arguments, key, want[key], f"{row['name']}{f' {same}' if same > 1 else ''}: ")


def _samples(plan: Plan, arguments: argparse.Namespace, ensemble: str, want: set[str], prefix: str) -> None:
    """Samples are made side by side, each by one thread."""
    jobs = arguments.jobs or arguments.threads
    own = scene(ensemble, arguments.samples or SAMPLES, arguments.protocol or "default", want)
    store = Store(arguments.store) if os.path.isdir(arguments.store) else None
    sink = ffi.new("sp_study_sink *", lib.sp_store_sink(store._c)) if store else ffi.NULL
    options = ffi.new("sp_study_options *", {"jobs": jobs, "threads": arguments.threads, "shard": 1, "shards": 1})
    user, f = ffi.new_handle(arguments.store), ffi.new("sp_forecast *")
    call(lib.sp_study_expect, own._c, options, sink, lib.sonopack_forecast_packed, user, plan.machine, f)
    missing = f.samples - f.stored - f.failed
    side_by_side = max(1, min(jobs, missing))
    plan.note(f"{prefix}samples", f.samples)
    plan.note(f"{prefix}samples in the store", f.stored)
    if f.failed:
        plan.note(f"{prefix}samples recorded as failed", f.failed)
    for part in f.part:
        if part.what != ffi.NULL and part.count:
            plan.add(prefix + text_of(part.what), part.count, part.cost.cpu, part.cost.wall / side_by_side,
                     part.cost.memory * side_by_side, part.bytes)
    if missing:
        plan.longest = max(plan.longest, f.longest)
    if 0 < f.looked < f.samples:
        plan.comments.append(f"{prefix}samples looked for = {f.looked}; the others are taken to be like them")
