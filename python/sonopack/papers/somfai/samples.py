"""Ensembles of packings: their samples are made in the store, and read from it."""
from __future__ import annotations

import argparse
import dataclasses
import functools
import math
import os
from collections.abc import Callable, Iterator

from ..._command import Failed
from ..._network import Network
from ..._packing import Packing
from ..._records import StudyProgress
from ..._scene import Scene
from ..._study import Sample, Store, study
from ..work import Work, by_key, number
from .rows import Mean, Row, judged

#: of the paper, ascending
PRESSURES = (1e-7, 1e-6, 1e-5, 1e-4)
SAMPLES = 30  # at each pressure in the paper


def needs(item: str, drawn: bool) -> dict[str, set[str]]:
    """The ensembles that an item needs, and results of their samples. drawn: with its figures."""
    out: dict[str, set[str]] = {}
    for need in by_key("somfai", "items", "name")[item]["needs"].split():
        if drawn or not need.startswith("("):
            ensemble, _, wants = need.strip("()").partition(":")
            out.setdefault(ensemble, set()).update(wants.split("+"))
    return out


def ensembles(items: list[str], drawn: bool) -> dict[str, set[str]]:
    """The ensembles that some items need, in their order, and the results of their samples."""
    out: dict[str, set[str]] = {}
    for item in items:
        for ensemble, want in needs(item, drawn).items():
            out.setdefault(ensemble, set()).update(want)
    return {ensemble: out[ensemble] for ensemble in by_key("somfai", "ensembles") if ensemble in out}


def count(ensemble: str, samples: int) -> int:
    """Samples of an ensemble if the paper's own ensembles have `samples`."""
    row = by_key("somfai", "ensembles")[ensemble]
    if not row["share"]:
        return 1
    most, least = math.ceil(float(row["share"]) * samples), int(row["least"])
    return most if most >= least else min(samples, least)


def scene(ensemble: str, samples: int, protocol: str, want: set[str]) -> Scene:
    """The scene of an ensemble. protocol: of packings under a piston. want: results, as in study.want."""
    row = by_key("somfai", "ensembles")[ensemble]
    keys = {"study.samples": count(ensemble, samples), "study.want": sorted(want)}
    if row["piston"]:
        keys["packing.protocol"] = protocol
    return Scene.parse(row["scene"], keys, row["name"])


class SomfaiWork(Work):
    """The work on the paper. sets: samples of each ensemble whose packing could be made."""

    rows: list[Row]

    def __init__(self, arguments: argparse.Namespace, wanted: set[str]) -> None:
        self.samples, self.protocol = arguments.samples or SAMPLES, arguments.protocol or "default"
        self.jobs, self.folder_of_store = arguments.jobs or arguments.threads, arguments.store
        super().__init__("somfai", f"reproduce somfai2005, samples = {self.samples}", wanted, arguments)
        self.sets: dict[str, list[Sample]] = {}
        self.computed = self.failed = 0
        self.done = 0.0  # share of the work: the samples

    # ---- samples ----------------------------------------------------------------------------------------------------

    def _cost(self, ensemble: str) -> float:
        row = by_key("somfai", "ensembles")[ensemble]
        slower = 5 if row["piston"] and self.protocol != "quick" else 1  # measured
        return slower * float(row["cost"]) * count(ensemble, self.samples)

    def collect(self) -> None:
        """Makes the samples that the store lacks, and reads them."""
        store = Store(self.folder_of_store, create=True)
        scenes = {ensemble: scene(ensemble, self.samples, self.protocol, want)
                  for ensemble, want in ensembles(self.wanted, bool(self.folder)).items()}
        everything, done = 1 + sum(map(self._cost, scenes)), 0.0  # 1: what is done with the samples
        for ensemble, own in scenes.items():
            self._make(store, own, by_key("somfai", "ensembles")[ensemble]["name"], done / everything,
                       self._cost(ensemble) / everything)
            done += self._cost(ensemble)
        self.done = done / everything
        for ensemble, own in scenes.items():
            self.sets[ensemble] = [sample for sample in store.samples(own)
                                   if os.path.exists(os.path.join(self.folder_of_store, f"{sample.name}.h5"))]

    def _make(self, store: Store, own: Scene, name: str, begin: float, share: float) -> None:
        computed, failed = self.computed, self.failed

        def watch(now: StudyProgress) -> None:
            self.computed, self.failed = computed + now.computed, failed + now.failed
            self.tell(name, begin + share * (now.done / now.total if now.total > 0 else 1.0))

        study(own, store, jobs=self.jobs, threads=self.threads, progress=watch)

    def tell(self, what: str, fraction: float) -> None:
        more = f", {self.computed} samples computed" + (f", {self.failed} failed" if self.failed else "")
        self.watch.tell(what, fraction, more)

    # ---- what they have ---------------------------------------------------------------------------------------------

    def some(self, ensemble: str, pressure: float, grains: int = 0, parts: str = "") -> list[Sample]:
        """Samples of one pressure and number of grains (0: any) that have these results, such as "statics moduli"."""
        return [sample for sample in self.sets[ensemble]
                if abs(sample.pressure - pressure) < 1e-9 * pressure and grains in (0, sample.grains)
                and all(getattr(sample, part) is not None for part in parts.split())]

    def walk(self, ensemble: str, pressure: float, grains: int = 0,
             most: int | None = None) -> Iterator[tuple[Sample, Packing, Network]]:
        """Samples with their packings and networks, at most `most`. Failed if there is none."""
        found = self.some(ensemble, pressure, grains)[:most]
        if not found:
            name = by_key("somfai", "ensembles")[ensemble]["name"]
            raise Failed(f"{name} at p = {pressure:g}: no packing could be made")
        for sample in found:
            packing = sample.packing()
            yield sample, packing, packing.network()

    # ---- rows -------------------------------------------------------------------------------------------------------

    def add(self, row: Row) -> Row:
        """Adds a row. Its place in the paper is, if it has none, "Table I" of the item's title "Table I. Statics"."""
        place = row.where or " ".join(self.items[row.item]["title"].split()[:2]).rstrip(".")
        self.rows.append(dataclasses.replace(judged(row), where=place))
        return self.rows[-1]

    def state(self, key: str, ours: Mean, theory: float = math.nan) -> Row:
        """Adds the row `key` of stated.tsv with our value and its standard error. theory: what an equation gives, which
        is taken to 0.2 %, where the row has no value."""
        row = by_key("somfai", "stated")[key]
        return self.add(Row(row["item"], row["quantity"], p=number(row["p"]), scatter=row["scatter"], ours=ours.mean,
                            err=ours.err, relation=">" if row["scatter"] == "bound" else "=",
                            paper=float(row["value"] or theory), paper_sd=float(row["precision"] or 0.002 * theory)))

    def claim(self, key: str, ours: Mean, p: float | None = None, **words: object) -> Row:
        """Adds the row `key` of claims.tsv. words: of its quantity; `within`, if it depends on the quantity."""
        row = by_key("somfai", "claims")[key]
        within = float(str(words["within"])) if "within" in words else number(row["within"])
        return self.add(Row("claims", row["quantity"].format(**words), p=number(row["p"]) if p is None else p,
                            paper=float(row["limit"]), paper_sd=within, scatter="claim", relation=row["relation"],
                            ours=ours.mean, err=ours.err, samples=ours.n, where=row["where"], note=row["note"]))


@functools.cache
def member(path: str) -> Callable[[Sample], float]:
    """A value of a sample by its place: "statics.zs", "probes.0.along / moduli.c22"."""
    above, _, below = path.partition(" / ")

    def of(sample: Sample) -> float:
        value: object = sample
        for name in above.split("."):
            value = value[int(name)] if isinstance(value, list) else getattr(value, name)
        return float(value) / member(below)(sample) if below else float(value)  # type: ignore[arg-type]
    return of
