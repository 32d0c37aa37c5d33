"""Somfai et al. (2005): their tables, figures and claims with newly compressed packings. Lengths are in mean grain
diameters d, pressures in E*, times in d/sqrt(E*/rho)."""
from __future__ import annotations

from .samples import SomfaiWork, needs


def make(work: SomfaiWork) -> None:
    """Makes the samples that the wanted items need, then the items."""
    from . import claims, fronts, packings, speeds

    makers = {
        **dict.fromkeys(("table1", "table2", "table4", "table5"), claims.make_table), "table3": fronts.make_table3,
        "fig1": packings.make_networks, "fig2": packings.make_directions, "fig3": packings.make_snapshot,
        "fig4": fronts.make_signals, "fig5": fronts.make_coherent, "fig6": fronts.make_arrivals,
        "fig7": fronts.make_scaling, "fig8": speeds.make_speeds, **dict.fromkeys(("fig9", "fig10"), packings.make_modes),
        "fig11": packings.make_damping, "fig12": speeds.make_chains, "claims": claims.make_claims}
    work.collect()
    for made, item in enumerate(work.wanted):
        work.tell(item, work.done + (1 - work.done) * made / len(work.wanted))
        if work.folder or needs(item, drawn=False):
            makers[item](work, item)
