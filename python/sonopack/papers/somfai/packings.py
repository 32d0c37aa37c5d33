"""The packing of Fig. 1: Figs. 1 to 3, forces, stiffnesses and directions of contacts, and displacements of the grains at one
time; Figs. 9 and 10, its modes; Fig. 11, damped signals."""
from __future__ import annotations

import math

import numpy as np

from ..._core import Floats, Refused, Status
from ..._modes import Modes
from ..._network import Network
from ..._packing import Packing
from ..._signal import Signal, front
from ..._study import Sample
from ..._table import Table
from ...plot._histograms import ContactCounts, contact_counts
from ...plot._inputs import Input
from ...plot._motion import Motion, find_mode
from ..sheet import Curve, Panel, Sheet
from .fronts import TIME_AXIS, front_of, rms_after
from .samples import SomfaiWork

THRESHOLD = 1e-4  # least force of a contact that carries load [p d^2]
TIME = 80.0       # of the snapshot in the paper


def _counted(work: SomfaiWork, margin: float) -> tuple[ContactCounts, str]:
    """The contacts of all packings at p = 1e-4, and how many there are."""
    counts = contact_counts(((sample.name, packing) for sample, packing, _ in work.walk("square", 1e-4)), THRESHOLD, margin)
    return counts, f"{counts.contacts:.0f} contacts of {counts.packings} packings"


# ---- Fig. 1 ---------------------------------------------------------------------------------------------------------

def make_networks(work: SomfaiWork, item: str) -> None:
    _, packing, network = next(work.walk("square", 1e-4, most=1))
    work.draw(item, "fig1a", "network", packing)
    work.draw(item, "fig1b", "stiffness", packing)
    work.save_table("fig1ab", _links(packing, network))
    counts, many = _counted(work, 0.0)
    table = counts.values()
    work.draw(item, "fig1c", "forces", table)
    work.save_table("fig1c", table)
    work.say(item, f"Over {many} the forces scatter by "
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

def make_directions(work: SomfaiWork, item: str) -> None:
    counts, many = _counted(work, 3.0)
    table = counts.angles()
    work.draw(item, "fig2", "angles", table)
    work.say(item, f"{many}. The mean of 2 n_y^2 - 1, 0 without "
                   f"anisotropy, is {_upright(table, 'all'):+.3f} for all, {_upright(table, 'strong'):+.3f} for strong "
                   f"and {_upright(table, 'weak'):+.3f} for weak contacts.")
    work.save_table("fig2", table)


def _upright(table: Table, name: str) -> float:
    """Mean of cos 2(angle - 90 degrees): 0 if isotropic, positive if contacts are mostly vertical."""
    density = table[name]
    return float(-np.sum(density * np.cos(2 * np.radians(table["angle"]))) / np.sum(density))


# ---- Fig. 3 ---------------------------------------------------------------------------------------------------------

def make_snapshot(work: SomfaiWork, item: str) -> None:
    _, packing, network = next(work.walk("square", 1e-4, most=1))
    u = network.field([TIME])[0]
    work.draw(item, "fig3", "snapshot", network, u, time=TIME)
    work.save_table("fig3", Motion(network, u, False, t=TIME).table())
    y = packing.x[network.grain, 1]
    quarter = np.clip(np.floor(4 * y / packing.height), 0, 3)
    rms = [math.sqrt(float(np.sum(u[quarter == k, 1] ** 2)) / max(1, int(np.sum(quarter == k)))) for k in range(4)]
    work.say(item, "Root mean square displacements up and down in the four quarters of the height, from the bottom, "
                   f"over that of the lowest: 1, {rms[1] / rms[0]:.2f}, {rms[2] / rms[0]:.2f}, {rms[3] / rms[0]:.2f}.")


# ---- Figs. 9 and 10: modes ------------------------------------------------------------------------------------------

LOWEST, BODY = 25, 10  # modes of the inset; modes compared with those of an elastic body
_WHY = ("the lowest above zero", "the second above zero", "strong in the signal", "strong in the signal",
        "strong in the signal", "localised, among the highest")
_SQUARE = "|ω|^{2}  [|E|*/(|ρ d|^{2})]"


def make_modes(work: SomfaiWork, item: str) -> None:
    sample, _, network = next(work.walk("square", 1e-4, most=1))
    modes = network.modes(vectors=True, solver="dense")
    if item == "fig9":
        _spectrum(work, item, sample, network, modes, _picked(modes))
    else:
        _six(work, item, modes, _picked(modes))


def _picked(m: Modes) -> list[int]:
    """The modes of Fig. 10: the two lowest above zero, the strongest in the signal in each third of the lower 60% of
    the spectrum, and the most localised in the highest 10%."""
    first, n = m.n_zero, m.n - m.n_zero
    if n < 40:
        raise Refused("modes: fewer than 40 above zero", Status.EREFUSED)
    weight = np.abs(m.ab)
    out = [first, first + 1]
    for third in range(3):
        begin, end = first + 2 + third * n // 5, first + (third + 1) * n // 5
        out.append(begin + int(np.argmax(weight[begin:end])))
    top = m.n - n // 10
    return [*out, top + int(np.argmin(m.participation[top:]))]


# ---- Fig. 9 ---------------------------------------------------------------------------------------------------------

def _spectrum(work: SomfaiWork, item: str, sample: Sample, network: Network, m: Modes, picked: list[int]) -> None:
    numbers, squares, weights = np.arange(m.n, dtype=float), m.omega * m.omega, m.ab
    bodies = _bodies(work, item, sample, network)
    begin = max(m.n_zero - 2, 0)
    lowest = slice(begin, begin + LOWEST)

    def circles(y: Floats, count: int = 6) -> Curve:
        return Curve(numbers[picked[:count]], y[picked[:count]], ink=2, dash=None, mark="o", open=True)

    inset = Panel([Curve(numbers[lowest], squares[lowest], dash=None, mark="s", open=True), circles(squares, 2),
                   Curve(*bodies, ink=1, dash=None, mark="D")], "|n|", _SQUARE, y=(0, None))
    panels = [Panel([Curve(numbers, squares), circles(squares)], "mode |n|", "|ω|_{|n|}^{2}  [|E|*/(|ρ d|^{2})]",
                    tag="(a)", x=(0, m.n), y=(0, None), inset=inset),
              Panel([Curve(numbers, weights, width=0.5), circles(weights)], "mode |n|",
                    "|a|_{|n|} |b|_{|n|}  [|E|* |d|^{2}]", tag="(b)", x=(0, m.n), zero=True)]
    work.draw_sheet(item, "fig9", Sheet(panels))
    rattlers = m.n_rattler // 3
    work.say(item, f"{m.n_zero} of {m.n} modes have frequency zero, three for each of {rattlers} rattlers; the paper's "
                   f"packing had 141. The lowest frequency above zero is {m.omega[m.n_zero]:.4f}, the highest "
                   f"{m.omega[-1]:.3f}.")


def _bodies(work: SomfaiWork, item: str, sample: Sample, network: Network) -> tuple[Floats, Floats]:
    """Modes of an elastic strip with the moduli and density of the packing, each beside the most similar mode of the
    packing. None if the packing has no bulk."""
    if sample.statics is None or not sample.statics.phi3s > 0:
        return np.empty(0), np.empty(0)
    rows = network.continuum(BODY).row[:BODY]
    for row in rows[:4]:
        work.say(item, f"Mode {row['n']}, omega = {row['omega']:.4f}: most like the "
                       f"{'fast' if row['fast'] else 'slow'} wave ({row['n1']}, {row['n2']}) of an elastic body with "
                       f"the same moduli between the same walls, omega = {row['omega_continuum']:.4f}, squared overlap "
                       f"{row['overlap']:.2f}.")
    return rows["n"].astype(float), (rows["omega_continuum"] ** 2).astype(float)


# ---- Fig. 10 --------------------------------------------------------------------------------------------------------

def _six(work: SomfaiWork, item: str, m: Modes, picked: list[int]) -> None:
    for letter, why, n in zip("abcdef", _WHY, picked):
        work.draw(item, f"fig10{letter}", "mode", m, mode=n,
                  caption=f"({letter}) Mode n = {n}, omega = {m.omega[n]:.4f}, participation ratio "
                          f"{m.participation[n]:.3f}: {why}.")
        work.save_table(f"fig10{letter}", find_mode([Input(m)], n, None).table())
    weight = np.abs(m.ab[m.n_zero:])
    part = [float(m.participation[n]) for n in picked]
    work.say(item, f"The seven lowest modes above zero carry {100 * weight[:7].sum() / weight.sum():.1f}% of the sum "
                   f"of |a_n b_n|. Participation ratios: {part[0]:.2f} and {part[1]:.2f} for the two lowest, "
                   f"{part[2]:.2f}, {part[3]:.2f} and {part[4]:.2f} for those that carry the signal, {part[5]:.3f} for "
                   "the localised one.")


# ---- Fig. 11: damping -----------------------------------------------------------------------------------------------

LEVELS = (0.0, 0.02, 0.1, 0.5)
UNTIL, POINTS = 300.0, 601


def damped(network: Network, zeta: float) -> Signal:
    """The signal with contacts damped by a fraction of critical."""
    return network.signal(until=UNTIL, points=POINTS, damping=zeta, tolerance=1e-6)


def make_damping(work: SomfaiWork, item: str) -> None:
    _, _, network = next(work.walk("square", 1e-4, most=1))
    linear, full = [], []
    for zeta in LEVELS:
        linear.append(damped(network, zeta))
        full.append(network.signal(until=UNTIL, points=POINTS, damping=zeta, method="dynamics", tolerance=1e-2,
                                   amplitude=1e-4))
        work.tell("fig11", 0.95)
    first = front(linear[0].t, linear[0].F)
    scaled = [(own.F / first.amplitude, other.F / first.amplitude) for own, other in zip(linear, full)]
    t = linear[0].t
    panels = [Panel([Curve(t, own, f"linear, |ζ| = {zeta:g}", width=0.9),
                     Curve(full[k].t, other, "nonlinear", ink=1, dash=1, width=0.9)],
                    TIME_AXIS, "|F|_{sig} / first peak", tag=f"({'abcd'[k]})", x=(0, UNTIL), zero=True)
              for k, (zeta, (own, other)) in enumerate(zip(LEVELS, scaled))]
    work.draw_sheet(item, "fig11", Sheet(panels, aspect=0.42))
    peaks = [found.amplitude if (found := front_of(t, own)) else math.nan for own, _ in scaled]
    rests = [rms_after(t, own, first.t_zero) for own, _ in scaled]
    for k in range(1, len(LEVELS)):
        apart = float(np.max(np.abs(scaled[k][0] - scaled[k][1])))
        work.say(item, f"zeta = {LEVELS[k]:g}: the first peak keeps {100 * peaks[k] / peaks[0]:.0f}% of its height, "
                       f"what follows {100 * rests[k] / rests[0]:.0f}% of its root mean square; linear and nonlinear "
                       f"motion differ by {100 * apart:.1f}% of the first peak without damping at the most.")
