"""Somfai et al. (2005): their tables, figures and claims with newly compressed packings. Lengths are in mean grain diameters
d, pressures in E*, times in d/sqrt(E*/rho)."""
from __future__ import annotations

import importlib

from .samples import SomfaiWork, needs

#: the module that makes each item, with make(work, item)
_MAKERS = {**{f"table{k}": "tables" for k in (1, 2, 4, 5)}, "table3": "exponents", "fig7": "exponents", "fig1": "networks",
           "fig2": "networks", "fig3": "networks", "fig4": "pulses", "fig5": "pulses", "fig6": "arrivals", "fig8": "speeds",
           "fig9": "eigenmodes", "fig10": "eigenmodes", "fig11": "damping", "fig12": "chains", "claims": "claims"}


def make(work: SomfaiWork) -> None:
    """Makes the samples that the wanted items need, then the items."""
    work.collect()
    for made, item in enumerate(work.wanted):
        work.tell(item, work.done + (1 - work.done) * made / len(work.wanted))
        if work.folder or needs(item, drawn=False):
            importlib.import_module(f"{__name__}.{_MAKERS[item]}").make(work, item)
