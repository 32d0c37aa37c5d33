"""Blackmore et al. (2011) on the tapped column, called [B]: its errata, figures, theorems and claims. Equation numbers
are those of [B], units cm, g and s."""
from __future__ import annotations

from ..work import Work


def make(work: Work) -> None:
    """Computes the wanted items in their order."""
    from . import column, figures, theorems

    makers = {"errata": column.make_errata, "fig1": figures.make_fig1, "fig2": figures.make_fig2,
              "symbols": figures.make_symbols, "chaos": theorems.make_chaos, "claims": theorems.make_claims}
    shares = {item: float(work.items[item]["share"]) for item in work.wanted}
    done = 0.0
    for item, share in shares.items():
        begun, part = done, share / sum(shares.values())

        def tell(now: float, item: str = item, begun: float = begun, part: float = part) -> None:
            work.watch.tell(item, begun + part * now)

        tell(0.0)
        makers[item](work, tell)
        done += part
