"""Figs. 1 to 3: forces, stiffnesses and directions of contacts, and displacements of the grains at one time."""
from __future__ import annotations

import math
import numpy as np

from ..._core import Floats
from ..._network import Network
from ..._packing import Packing
from ..._table import Table
from ...plot._histograms import ContactCounts
from .samples import SomfaiWork

THRESHOLD = 1e-4  # least force of a contact that carries load [p d^2]
TIME = 80.0       # of the snapshot in the paper


def make(work: SomfaiWork, item: str) -> None:
    {"fig1": _one, "fig2": _two, "fig3": _three}[item](work, item)


def _counts(work: SomfaiWork, margin: float) -> ContactCounts:
    """Histograms of the contacts of all packings at p = 1e-4."""
    counts = ContactCounts()
    for _, packing, _ in work.walk("square", 1e-4):
        counts.add(packing, THRESHOLD, margin)
    return counts


# ---- Fig. 1 ---------------------------------------------------------------------------------------------------------

def _one(work: SomfaiWork, item: str) -> None:
    from .. import pictures

    _, packing, network = next(work.walk("square", 1e-4, most=1))
    work.draw(item, "fig1a", "(a) Normal forces in one packing of 600 grains at p = 1e-4, as widths of lines.",
              pictures.network(packing, "forces"))
    work.draw(item, "fig1b", "(b) Normal stiffnesses of the same contacts.", pictures.network(packing, "stiffness"))
    work.save_table("fig1ab", _links(packing, network))
    counts = _counts(work, 0.0)
    table = counts.values()
    work.draw(item, "fig1c", "(c) Histograms of the normal forces and stiffnesses of all contacts that carry, over "
                             "their means; equal areas.", pictures.values(table))
    work.save_table("fig1c", table)
    work.say(item, f"Over {counts.contacts:.0f} contacts of {counts.packings} packings the forces scatter by "
                   f"{100 * _spread(table, 'forces'):.0f}% of their mean and the stiffnesses by "
                   f"{100 * _spread(table, 'stiffnesses'):.0f}%: k_n goes as F_n^(1/3).")


def _links(packing: Packing, network: Network) -> Table:
    """The contacts of Figs. 1(a) and (b)."""
    c = packing.contacts[network.springs["contact"]]
    x, r = packing.x[c["i"]], packing.r[c["i"]]
    table = Table.from_columns({
        "i": c["i"].astype(float), "j": c["j"].astype(float), "x_i": x[:, 0], "y_i": x[:, 1],
        "x_contact": x[:, 0] + r * c["n"][:, 0], "y_contact": x[:, 1] + r * c["n"][:, 1], "Fn": c["fn"],
        "kn": network.springs["kn"]})
    table.add_comment("contacts that carry: grains from 0, -1 and -2 the bottom and the top wall; normal force and "
                      "stiffness")
    return table


def _spread(table: Table, name: str) -> float:
    """Standard deviation relative to the mean, from a histogram of values relative to their mean."""
    off, density = table["x"] - 1, table[name]
    return math.sqrt(float(np.sum(density * off * off) / np.sum(density)))


# ---- Fig. 2 ---------------------------------------------------------------------------------------------------------

def _two(work: SomfaiWork, item: str) -> None:
    from .. import pictures

    counts = _counts(work, 3.0)
    table = counts.angles()
    work.draw(item, "fig2", "Directions of contacts that carry, at least three diameters from both walls: all, those "
                            "with forces above the mean (strong), and the others (weak).", pictures.angles(table))
    work.say(item, f"{counts.contacts:.0f} contacts of {counts.packings} packings. The mean of 2 n_y^2 - 1, 0 without "
                   f"anisotropy, is {_upright(table, 'all'):+.3f} for all, {_upright(table, 'strong'):+.3f} for strong "
                   f"and {_upright(table, 'weak'):+.3f} for weak contacts.")
    work.save_table("fig2", table)


def _upright(table: Table, name: str) -> float:
    """Mean of cos 2(angle - 90 degrees): 0 if isotropic, positive if contacts are mostly vertical."""
    density = table[name]
    return float(-np.sum(density * np.cos(2 * np.radians(table["angle"]))) / np.sum(density))


# ---- Fig. 3 ---------------------------------------------------------------------------------------------------------

def _three(work: SomfaiWork, item: str) -> None:
    from .. import pictures

    _, packing, network = next(work.walk("square", 1e-4, most=1))
    u = network.field([TIME])[0]
    work.draw(item, "fig3", "Displacements of the grains of the packing of Fig. 1 at t = 80 after the pulse at the "
                            "bottom wall, magnified; rattlers grey.", pictures.snapshot(network, u, TIME))
    work.save_table("fig3", _field_table(packing, network, u))
    y = packing.x[network.grain, 1]
    quarter = np.clip(np.floor(4 * y / packing.height), 0, 3)
    rms = [math.sqrt(float(np.sum(u[quarter == k, 1] ** 2)) / max(1, int(np.sum(quarter == k)))) for k in range(4)]
    work.say(item, "Root mean square displacements up and down in the four quarters of the height, from the bottom, "
                   f"over that of the lowest: 1, {rms[1] / rms[0]:.2f}, {rms[2] / rms[0]:.2f}, {rms[3] / rms[0]:.2f}.")


def _field_table(packing: Packing, network: Network, u: Floats) -> Table:
    grain = network.grain
    return Table.from_columns({
        "grain": grain.astype(float), "x": packing.x[grain, 0], "y": packing.x[grain, 1], "radius": packing.r[grain],
        "u_x": u[:, 0], "u_y": u[:, 1], "angle": u[:, 2] if network.dof > 2 else np.zeros(len(grain))},
        metadata={"t": f"{TIME:g}"})
