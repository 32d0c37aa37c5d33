"""Figure of the lowest modes of ensembles."""
from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._records import Material
from .._scene import Scene
from .._soft import PowerLaw, SoftModes, soft_modes
from .._study import Store
from ._frame import GREY, column_of_panels, ink, legend, points, styled
from ._inputs import Input, inputs
from ._units import FREQUENCY, TIME, label, number, refuse, to_si, unit_text, worded

BINS_PER_DECADE = 12


@styled
def softmodes(*data: Any, material: Material | None = None, ax: Any = None, scene: Scene | None = None,
              store: str | None = None, lowest: int = 30, table: str | None = None) -> Any:
    """Density of the lowest modes of many packings, or of a table of them, of all modes and of those that are no plane
    waves with the power law that they follow farthest, and participation ratios. store: the folder of a study. table:
    writes the modes there. Returns two Axes."""
    given = inputs(data, None, material) if store is None else []
    soft = _modes_of(given, store, scene, lowest)
    law = soft.best()
    if table is not None:
        made = soft.table()
        made.add_comment(f"power_law = {law.exponent:.6g}, error {law.error:.3g}, of {law.modes} modes below "
                         f"{law.high:.6g}, goodness {law.goodness:.3g}")
        made.save(table)
    return draw(soft, law, material, ax)


def _modes_of(given: Sequence[Input], store: str | None, scene: Scene | None, lowest: int) -> SoftModes:
    if len(given) == 1 and not given[0].is_packing:
        if "phonon" not in given[0].raw_table:
            raise refuse(given[0].name, "no column phonon: must be a table of `plot softmodes --table', or packings")
        return SoftModes.of_table(given[0].raw_table)
    packings: Any = [one.packing for one in given] if store is None else [one for one in Store(store) if not one.failed]
    words = {} if scene is None else {name: getattr(scene._c.network, name) for name in ("threshold", "prestress")}
    return soft_modes(packings, lowest=lowest, threads=os.cpu_count() or 1, **words)


def draw(soft: SoftModes, law: PowerLaw, material: Material | None, ax: Any) -> Any:
    """Densities and participation ratios, on two Axes."""
    axes = column_of_panels(2, ax, 0.66)
    (rate, unit), (time, unit_of_time) = to_si(FREQUENCY, material), to_si(TIME, material)
    edges = np.geomspace(soft.omega.min() * 0.99, soft.complete, 1 + max(4, int(
        BINS_PER_DECADE * np.log10(soft.complete / soft.omega.min()))))
    middle = rate * np.sqrt(edges[1:] * edges[:-1])
    for name, colour in (("all modes", GREY), ("no plane waves", ink(1))):
        value, error = soft.density(edges, phonons=colour == GREY)
        some = value > 0
        bars = np.minimum(error[some], 0.9 * value[some])  # a bin of one packing would reach to 0
        points(axes[0], middle[some], time * value[some], time * bars, hollow=colour != GREY, color=colour, label=name)
    x = np.geomspace(soft.omega.min(), law.high)
    share = law.modes / soft.dofs.sum() * (law.exponent + 1) / law.high**(law.exponent + 1)
    axes[0].plot(rate * x, time * share * x**law.exponent, color="black",
                 label=rf"$\omega^{{{law.exponent:.2f} \pm {law.error:.2f}}}$, $\omega < {number(rate * law.high, 2)}$, goodness "
                       f"{law.goodness:.2f}")
    for some, colour in ((~soft.is_phonon, ink(1)), (soft.is_phonon, GREY)):
        axes[1].plot(rate * soft.omega[some], soft.participation[some], ".", ms=1.5, color=colour, rasterized=True)
    first = float(np.nanmedian(soft.first))
    for one in axes:
        one.set(xscale="log", yscale="log", xlabel=label(r"$\omega$", unit),
                xlim=(0.9 * rate * soft.omega.min(), 1.1 * rate * soft.omega.max()))
        one.axvline(rate * first, color="black", lw=0.5, ls=":")
    axes[0].set_ylabel(worded(r"$D(\omega)$", unit_text(unit_of_time)))
    axes[1].set_ylabel("participation ratio")
    legend(axes[0])
    return axes
