"""Tables I, II, IV and V; and claims in words: on packings at rest, on fronts, on lattices, on soft modes, on damping, and on
the chain."""
from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._signal import front
from ..work import Published, number, published
from .fronts import MARKS, boxes, power, rms_after
from .packings import LEVELS, damped
from .rows import Mean, Row, counted, exact, mean_of, ratio, speed
from .samples import PRESSURES, SomfaiWork, member
from .speeds import NAMES, lattice_long, lattice_small, lattice_speed

FAR_OFF = 8  # standard deviations, from the median deviation: a probability of 1e-15 for a normal distribution


def make_table(work: SomfaiWork, item: str) -> None:
    for row in published("somfai", "tables"):
        if row["item"] == item:
            _add_mean(work, row)
    _say_agreement(work, item)
    if item == "table4":
        _say_box(work, item)


def _add_mean(work: SomfaiWork, row: Published) -> None:
    p, sd, of = float(row["p"]), number(row["sd"]), member(row["ours"])
    parts = " ".join(dict.fromkeys(word.split(".")[0] for word in row["ours"].split(" / ")))
    values = [of(sample) for sample in work.some("square", p, parts=f"statics {parts}")]
    mean = mean_of(values)
    work.add(Row(row["item"], row["quantity"], p=p, paper=float(row["paper"]), paper_sd=sd, digit=float(row["digit"]),
                 scatter="ours" if math.isnan(sd) else "paper", samples=mean.n, ours=mean.mean, ours_sd=mean.sd,
                 err=mean.err))
    _say_far_off(work, row["item"], f"{row['quantity']} at p = {p:g}", values)


def _say_agreement(work: SomfaiWork, item: str) -> None:
    rows = [row for row in work.rows if row.item == item]
    known = [row for row in rows if math.isfinite(row.sigma)]
    agree = sum(row.verdict == "agrees" for row in rows)
    gaps = ", and some have no value or no known scatter" if len(known) < len(rows) else ""
    work.say(item, f"{agree} of {len(rows)} means lie within one standard deviation of the paper{gaps}.")
    c = counted(work.rows, item)
    if c.judged:
        work.say(item, f"By the standard errors of both means {c.within1} of {c.judged} lie within one, {c.beyond2} "
                       f"beyond two and {c.beyond3} beyond three; chi^2 = {c.chi2:.0f}.")
    if known:
        worst = max(known, key=lambda row: abs(row.sigma))
        work.say(item, f"The largest deviation is that of {worst.quantity} at p = {worst.p:g}: {worst.ours:.4g} here, "
                       f"{worst.paper:.4g} in the paper, {abs(worst.sigma):.2f} standard deviations apart.")


def _say_far_off(work: SomfaiWork, item: str, what: str, values: Sequence[float]) -> None:
    """Names samples that dominate a mean. A soft spot in a single packing can do so for the body forces."""
    if len(values) < 5:
        return
    x = np.array(values)
    middle = float(np.median(x))
    off = np.abs(x - middle)
    far = off > FAR_OFF * 1.4826 * np.median(off)
    if far.any():
        work.say(item, f"{what}: {far.sum()} of {len(x)} samples lie more than 8 standard deviations of the others "
                       f"away, the farthest at {x[np.argmax(off)]:.3g}; the median is {middle:.4g}.")


def _say_box(work: SomfaiWork, item: str) -> None:
    """The body force on a grain is its volume divided by Phi3*. If Phi3* is that of the whole box, the forces add up to
    the force on the continuum. The ratios are proportional to its square."""
    rows = [row for row in work.rows if row.item == item]
    factors = {p: _box_ratio(work, p) for p in PRESSURES}
    before = sum(row.verdict == "agrees" for row in rows)
    agree = sum(abs(row.ours * factors[row.p] - row.paper) <= row.paper_sd for row in rows)
    work.say(item, "The body force on a grain goes as 1/Phi3*. Here that is the bulk's, as everywhere; with that of "
                   "the whole box, loose layers at the walls included, all ratios would be "
                   f"{min(factors.values()):.3f} to {max(factors.values()):.3f} times as large, and {agree} of "
                   f"{len(rows)} instead of {before} would agree.")


def _box_ratio(work: SomfaiWork, pressure: float) -> float:
    squares = []
    for sample, packing, network in work.walk("square", pressure):
        if sample.statics is not None:
            volume = float(np.sum(4 / 3 * np.pi * packing.r[network.grain] ** 3))
            squares.append((volume / (packing.box[0] * packing.box[1] * sample.statics.phi3s)) ** 2)
    return sum(squares) / len(squares) if squares else math.nan


# ---- claims ---------------------------------------------------------------------------------------------------------

PACKINGS = 10  # the first of an ensemble
SOFT = 0.1     # low modes have frequencies below this; the highest are near 2 at p = 1e-4


def make_claims(work: SomfaiWork, item: str) -> None:
    parts = (_margins, _forces, _large_scale, _marks, _lattices, _unequal, _four, _soft_modes, _damping, _energy)
    for part in parts:
        part(work)
        work.tell(item, (work.done + 1) / 2)


# ---- packings at rest -----------------------------------------------------------------------------------------------

#: quantities, and their last digits in Table I
_MARGINS = (("Phi2", 0.001, "phi2"), ("Phi3s", 0.01, "phi3s"), ("zs", 0.01, "zs"), ("N_over_p", 0.01, "n_over_p"),
            ("F2", 0.001, "f2"))


def _margins(work: SomfaiWork) -> None:
    """Layers left out at the walls: l = 1 and l = 5, minus l = 3."""
    found = [[packing.statics(1e-4, margin) for margin in (1.0, 3.0, 5.0)]
             for p in PRESSURES for _, packing, _ in work.walk("square", p)]
    for name, digit, member_ in _MARGINS:
        of = np.array([[getattr(statics, member_) for statics in three] for three in found])
        thin, thick = mean_of(of[:, 0] - of[:, 1]), mean_of(of[:, 2] - of[:, 1])
        work.claim("margin", thick, name=name, within=digit)
        work.say("claims", f"{name} with l = 1 is {thin:+.4f} off that with l = 3, with l = 5 {thick:+.4f}.")


def _participation(work: SomfaiWork, pressure: float) -> list[Mean]:
    """Makse et al. 1999: Pi = 1/(M sum q^2), q = f/sum f, where f is the magnitude of the total force of each of M
    contacts. Pi, and Pi Z(2) from total and from normal forces."""
    rows = []
    for _, packing, network in work.walk("square", pressure):
        c = packing.contacts[network.springs["contact"]]
        f, n = np.sqrt(c["fn"]**2 + (c["ft"]**2).sum(axis=1)), c["fn"]
        pi = 1 / (len(c) * ((f / f.sum())**2).sum())
        rows.append((pi, *(pi * len(c) * (force**2).sum() / force.sum()**2 for force in (f, n))))
    return [mean_of(column) for column in zip(*rows)]


def _forces(work: SomfaiWork) -> None:
    found = [_participation(work, p) for p in PRESSURES]
    for p, (number, _, normal) in zip(PRESSURES, found):
        work.say("claims", f"p = {p:g}: Pi = {number:.3f} over all contacts that carry, walls included; times Z(2) of "
                           f"the normal forces {normal:.4f}.")
    work.claim("identity", exact(mean_of(whole.mean for _, whole, _ in found).mean))
    work.claim("constant", power(PRESSURES, [number for number, _, _ in found]))


# ---- fronts ---------------------------------------------------------------------------------------------------------

def _large_scale(work: SomfaiWork) -> None:
    found = boxes(work)
    by_grains = {d.grains: d for d in found}
    ours = exact(math.nan)
    if {200, 600} <= set(by_grains) and found[-1].grains > 600:
        near, far = (speed(high.distance - low.distance, low.t10, high.t10)
                     for low, high in ((by_grains[200], by_grains[600]), found[-2:]))
        ours = ratio(near, far)._replace(n=0)
    work.claim("large-scale", ours)


def _marks(work: SomfaiWork) -> None:
    """The ratio of c from a later mark to c_tof is the ratio of the two delays. The marks of one packing vary together,
    so the error is that of t10 - ratio x mark."""
    low, high = (np.array([[member(f"front.{mark}")(s) for mark in MARKS] for s in work.some(e, 1e-4, parts="front")]).T
                 for e in ("low", "square"))
    delay = high.mean(axis=1) - low.mean(axis=1)
    for k, name in ((1, "c by the first peak over c_tof"), (2, "c by the zero crossing over c_tof")):
        of = delay[0] / delay[k]
        u, v = (mean_of(each[0] - of * each[k]) for each in (low, high))
        work.claim("mark", Mean(0, of, math.nan, math.hypot(u.err, v.err) / delay[k]), name=name)


# ---- lattices -------------------------------------------------------------------------------------------------------

def _lattices(work: SomfaiWork) -> None:
    """Equal balls, Fig. 8."""
    theory = [lattice_speed(5e-7, eta) for eta in (0, 1)]
    smooth, rough = (lattice_small(work, bool(k), 5e-7) / theory[k] for k in (0, 1))
    far = lattice_long(work, True)[1] / theory[1]
    work.claim("lattice-smooth", exact(smooth))
    work.claim("lattice-friction", exact(rough))
    work.claim("lattice-approach", exact(abs(far - 1) / abs(rough - 1)))
    work.claim("lattice-finite", exact(abs(rough - 1) / abs(smooth - 1)))


LOWER, HIGHER = 216, 672  # grains


def _over(work: SomfaiWork, ensemble: str, friction: bool, p: float, grains: int, path: str) -> Mean:
    """A quantity over the samples of a set."""
    part = path.split(".")[0]
    some = work.some(ensemble, p, grains, part if "." in path else "front")
    return mean_of(member(path)(sample) for sample in some if (sample.friction > 0) == friction)


def _unequal(work: SomfaiWork) -> None:
    """Unequal balls at P* = 3 p/alpha^(3/2): at P* >= 1, speed and contacts are those of the perfect lattice. Below
    that, disorder has an effect."""
    for p, reduced in ((1e-6, 0.1), (1e-5, 1.0), (1e-4, 10.0)):
        for friction, kind in enumerate(NAMES):
            where = ("uneven", bool(friction), p)
            (h1, t1), (h2, t2) = ([_over(work, *where, grains, path) for path in ("height", "front.t10")]
                                  for grains in (LOWER, HIGHER))
            words: dict[str, Any] = {"p": p, "reduced": reduced, "kind": kind}
            own, perfect = speed(h2.mean - h1.mean, t1, t2), lattice_small(work, bool(friction), p)
            work.claim("uneven-above" if reduced >= 1 else "uneven-below", ratio(own, exact(perfect, own.n)), **words)
            if reduced >= 1:
                z = _over(work, *where, HIGHER, "statics.zs")
                work.claim("uneven-contacts", z._replace(n=t2.n), **words)


def _four(work: SomfaiWork) -> None:
    """z* at the two lowest pressures, and its limit at p = 0 from z0 + a sqrt(p)."""
    lower, upper = 1e-7, 1e-6
    root = math.sqrt(upper / lower)
    for friction, kind in enumerate(NAMES):
        a, b = (_over(work, "uneven-low", bool(friction), p, HIGHER, "statics.zs") for p in (lower, upper))
        limit = a.mean - (b.mean - a.mean) / (root - 1)
        work.claim("four", Mean(a.n, limit, math.nan, math.hypot(a.err * root, b.err) / (root - 1)), kind=kind)
        work.say("claims", f"Lattice of balls 1 +- 0.005, {'with' if friction else 'without'} friction: z* = {a:.3f} "
                           f"at p = 1e-7, {b:.3f} at 1e-6.")


# ---- modes and damping ----------------------------------------------------------------------------------------------

def _count_soft(work: SomfaiWork, ensemble: str) -> Mean:
    found = []
    for _, _, network in work.walk(ensemble, 1e-4, most=PACKINGS):
        modes = network.modes(vectors=False, solver="dense")
        found.append(int(np.sum(modes.omega[modes.n_zero:] < SOFT)))
        work.tell("low modes", 0.9)
    return mean_of(found)


def _soft_modes(work: SomfaiWork) -> None:
    rough, smooth = _count_soft(work, "square"), _count_soft(work, "smooth")
    work.say("claims", f"Modes with 0 < omega < {SOFT:g}: {rough:.1f} a packing with friction, {smooth:.1f} without.")
    work.claim("soft", ratio(smooth, rough)._replace(n=smooth.n))


def _damping(work: SomfaiWork) -> None:
    """Ratios to the signal without damping, a value a packing."""
    levels, found, bare_times = LEVELS[1:], [], []
    for _, _, network in work.walk("square", 1e-4, most=PACKINGS):
        bare = damped(network, 0.0)
        first = front(bare.t, bare.F)
        rest0 = rms_after(bare.t, bare.F, first.t_zero)
        rows = []
        for zeta in levels:
            s = damped(network, zeta)
            own = front(s.t, s.F)
            peak, rest = own.amplitude / first.amplitude, rms_after(s.t, s.F, first.t_zero) / rest0
            rows.append((peak, rest, (1 - peak) / (1 - rest), own.t10 / first.t10, own.t10))
        found.append(rows)
        bare_times.append(first.t10)
        work.tell("damping", 0.95)
    bare_time = mean_of(bare_times).mean
    for zeta, columns in zip(levels, np.moveaxis(np.array(found), 0, 2)):
        peak_, rest_, loss, arrival, time = map(mean_of, columns)
        work.claim("damping", loss._replace(n=peak_.n), zeta=zeta)
        work.say("claims", f"zeta = {zeta:g}: the first peak keeps {peak_:.3f} of its height, what follows {rest_:.3f} "
                           f"of its root mean square; t10 goes from {bare_time:.1f} to {time.mean:.1f}.")
    work.claim("strong", peak_, zeta=zeta)
    work.claim("strong-arrival", arrival._replace(n=peak_.n), zeta=zeta)


# ---- Eq. (17) -------------------------------------------------------------------------------------------------------

def _first_pulse(t: float) -> tuple[float, float]:
    """The chain whose first ball, next to the wall, has velocity c at t = 0 (units of sp_chain). The method of images
    gives u'_n = J_(2n-2)(2t) - J_(2n+2)(2t). The kinetic energy from the front back to the first zero crossing, and the
    root mean square of u' behind it."""
    from scipy.special import jv

    balls = int(t + 15 + 8 * np.cbrt(2 * t))  # beyond these nothing moves
    j = jv(2 * np.arange(balls + 2), 2 * t)
    v = (j[:-2] - j[2:])[::-1]  # from the front
    end = int(np.flatnonzero((v < 0) & (np.arange(balls, 0, -1) < t))[0])
    return float(0.5 * np.sum(v[:end]**2)), math.sqrt(np.mean(v[end:]**2))


def _energy(work: SomfaiWork) -> None:
    early, late = 1e4, 1e5
    for key, before, after in zip(("energy", "oscillations"), _first_pulse(early), _first_pulse(late)):
        work.claim(key, exact(math.log(after / before) / math.log(late / early)))
