"""Figs. 9 and 10: the modes of the packing of Fig. 1."""
from __future__ import annotations

import numpy as np

from ..._core import Status
from ..._core import Refused
from ..._modes import Modes
from ..._network import Network
from ..._packing import Packing
from ..._study import Sample
from ..._table import Table
from ..sheet import Curve, Panel, Sheet
from .samples import SomfaiWork

LOWEST, BODY = 25, 10  # modes of the inset; modes compared with those of an elastic body
_WHY = ("the lowest above zero", "the second above zero", "strong in the signal", "strong in the signal",
        "strong in the signal", "localised, among the highest")
_SQUARE = "|ω|^{2}  [|E|*/(|ρ d|^{2})]"


def make(work: SomfaiWork, item: str) -> None:
    sample, packing, network = next(work.walk("square", 1e-4, most=1))
    modes = network.modes(vectors=True, solver="dense")
    if item == "fig9":
        _spectrum(work, item, sample, network, modes, _picked(modes))
    else:
        _six(work, item, packing, network, modes, _picked(modes))


def _picked(m: Modes) -> list[int]:
    """The modes of Fig. 10: the two lowest above zero, the strongest in the signal in each third of the lower 60% of the
    spectrum, and the most localised in the highest 10%."""
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

    def circles(y: np.ndarray, count: int = 6) -> Curve:
        return Curve(numbers[picked[:count]], y[picked[:count]], ink=2, dash=None, mark="o", open=True)

    inset = Panel([Curve(numbers[lowest], squares[lowest], dash=None, mark="s", open=True), circles(squares, 2),
                   Curve(*bodies, ink=1, dash=None, mark="D")], "|n|", _SQUARE, y=(0, None))
    panels = [Panel([Curve(numbers, squares), circles(squares)], "mode |n|", "|ω|_{|n|}^{2}  [|E|*/(|ρ d|^{2})]", tag="(a)",
                    x=(0, m.n), y=(0, None), inset=inset),
              Panel([Curve(numbers, weights, width=0.5), circles(weights)], "mode |n|", "|a|_{|n|} |b|_{|n|}  [|E|* |d|^{2}]",
                    tag="(b)", x=(0, m.n), zero=True)]
    work.draw_sheet(item, "fig9",
                    "(a) Squared eigenfrequencies of the packing of Fig. 1 and (b) weights of the modes in the signal; circles: "
                    "the modes of Fig. 10; inset: the lowest (squares) beside those of an elastic body with the packing's "
                    "moduli (diamonds).", Sheet(panels))
    rattlers = m.n_rattler // 3
    work.say(item, f"{m.n_zero} of {m.n} modes have frequency zero, three for each of {rattlers} rattlers; the paper's packing "
                   f"had 141. The lowest frequency above zero is {m.omega[m.n_zero]:.4f}, the highest {m.omega[-1]:.3f}.")


def _bodies(work: SomfaiWork, item: str, sample: Sample, network: Network) -> tuple[np.ndarray, np.ndarray]:
    """Modes of an elastic strip with the moduli and density of the packing, each beside the most similar mode of the packing.
    None if the packing has no bulk."""
    if sample.statics is None or not sample.statics.phi3s > 0:
        return np.empty(0), np.empty(0)
    rows = network.continuum(BODY).row[:BODY]
    for row in rows[:4]:
        work.say(item, f"Mode {row['n']}, omega = {row['omega']:.4f}: most like the {'fast' if row['fast'] else 'slow'} wave "
                       f"({row['n1']}, {row['n2']}) of an elastic body with the same moduli between the same walls, omega = "
                       f"{row['omega_continuum']:.4f}, squared overlap {row['overlap']:.2f}.")
    return rows["n"].astype(float), rows["omega_continuum"] ** 2


# ---- Fig. 10 --------------------------------------------------------------------------------------------------------

def _six(work: SomfaiWork, item: str, packing: Packing, network: Network, m: Modes, picked: list[int]) -> None:
    from .. import pictures

    for letter, why, n in zip("abcdef", _WHY, picked):
        work.draw(item, f"fig10{letter}",
                  f"({letter}) Mode n = {n}, omega = {m.omega[n]:.4f}, participation ratio {m.participation[n]:.3f}: {why}.",
                  pictures.mode(m, n))
    work.save_table("fig10", _displacements(packing, network, m, picked))
    weight = np.abs(m.ab[m.n_zero:])
    part = [float(m.participation[n]) for n in picked]
    work.say(item, f"The seven lowest modes above zero carry {100 * weight[:7].sum() / weight.sum():.1f}% of the sum of |a_n "
                   f"b_n|. Participation ratios: {part[0]:.2f} and {part[1]:.2f} for the two lowest, {part[2]:.2f}, "
                   f"{part[3]:.2f} and {part[4]:.2f} for those that carry the signal, {part[5]:.3f} for the localised one.")


def _displacements(packing: Packing, network: Network, m: Modes, picked: list[int]) -> Table:
    """Displacements of the modes for every grain that is not a rattler."""
    rows, places = [], packing.x[network.grain]
    for n in picked:
        u = np.zeros((network.n, 3))
        u[:, :min(network.dof, 3)] = m.displacement(n)[:, :3]
        head = np.tile([float(n), float(m.omega[n])], (network.n, 1))
        rows.append(np.column_stack([head, network.grain, places[:, :2], u]))
    names = ("mode", "omega", "grain", "x", "y", "u_x", "u_y", "angle")
    table = Table.from_columns(dict(zip(names, np.concatenate(rows).T)))
    table.add_comment("eigenmodes M^(-1/2) e, e of length 1")
    return table
