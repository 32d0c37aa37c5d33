"""Blackmore et al. (2011) on the tapped column, called [B]: its errata, figures, theorems and claims. Equation numbers are
those of [B], units cm, g and s."""
from __future__ import annotations

import importlib

from ..work import Work

#: the module and function of each item
_MAKERS = {"errata": "errata", "fig1": "trajectories", "fig2": "surfaces", "symbols": "symbols", "chaos": "chaos",
           "claims": "theorems"}


def make(work: Work) -> None:
    """Computes the wanted items in their order."""
    everything = sum(float(work.items[item]["share"]) for item in work.wanted)
    done = 0.0
    for item in work.wanted:
        share = float(work.items[item]["share"]) / everything

        def tell(part: float, item: str = item, done: float = done, share: float = share) -> None:
            work.watch.tell(item, done + share * part)

        tell(0.0)
        importlib.import_module(f"{__name__}.{_MAKERS[item]}").make(work, tell)
        done += share
