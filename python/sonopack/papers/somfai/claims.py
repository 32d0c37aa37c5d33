"""Tables I, II, IV and V; and claims in words: on packings at rest, on fronts, on lattices, on soft modes, on damping, and on
the chain."""
from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._signal import front
from ..work import Published, hypot, number, published, total
from .fronts import MARKS, Distance, boxes, line, rms_after
from .packings import LEVELS, damped
from .rows import Row, Sum, counted, mean_of
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
    thin, thick = ([Sum() for _ in _MARGINS] for _ in range(2))
    for p in PRESSURES:
        for _, packing, _ in work.walk("square", p):
            one, three, five = (packing.statics(1e-4, margin) for margin in (1.0, 3.0, 5.0))
            for k, (_, _, name) in enumerate(_MARGINS):
                thin[k].add(getattr(one, name) - getattr(three, name))
                thick[k].add(getattr(five, name) - getattr(three, name))
    for (name, digit, _), a, b in zip(_MARGINS, thin, thick):
        work.claim("margin", b.mean, b.err, b.n, name=name, within=digit)
        work.say("claims", f"{name} with l = 1 is {a.mean:+.4f} +- {a.err:.4f} off that with l = 3, with l = 5 "
                           f"{b.mean:+.4f} +- {b.err:.4f}.")


def _participation(work: SomfaiWork, pressure: float) -> tuple[Sum, Sum, Sum]:
    """Makse et al. 1999: Pi = 1/(M sum q^2), q = f/sum f, where f is the magnitude of the total force of each of M
    contacts. Pi, and Pi Z(2) from total and from normal forces: a value a packing."""
    number, whole, normal = Sum(), Sum(), Sum()
    for _, packing, network in work.walk("square", pressure):
        c = packing.contacts[network.springs["contact"]]
        squares = c["fn"] * c["fn"] + c["ft"][:, 0] ** 2 + c["ft"][:, 1] ** 2 + c["ft"][:, 2] ** 2
        f, m = np.sqrt(squares), len(c)
        f1, n1 = total(f), total(c["fn"])
        pi = 1 / (m * total(f / f1 * (f / f1)))
        number.add(pi)
        whole.add(pi * m * total(f * f) / (f1 * f1))
        normal.add(pi * m * total(c["fn"] * c["fn"]) / (n1 * n1))
    return number, whole, normal


def _forces(work: SomfaiWork) -> None:
    numbers, wholes = [], Sum()
    for p in PRESSURES:
        number, whole, normal = _participation(work, p)
        numbers.append(number)
        wholes.add(whole.mean)
        work.say("claims", f"p = {p:g}: Pi = {number.mean:.3f} +- {number.err:.3f} over all contacts that carry, walls "
                           f"included; times Z(2) of the normal forces {normal.mean:.4f} +- {normal.err:.4f}.")
    work.claim("identity", wholes.mean, 0.0)
    own = line([math.log(p) for p in PRESSURES], [math.log(n.mean) for n in numbers], [n.err / n.mean for n in numbers])
    work.claim("constant", own.slope, own.err)


# ---- fronts ---------------------------------------------------------------------------------------------------------

def _speed_between(low: Distance, high: Distance) -> tuple[float, float]:
    """Speed between two heights from t10, and its error."""
    time = high.t10.mean - low.t10.mean
    speed = (high.distance - low.distance) / time
    return speed, speed * hypot(low.t10.err, high.t10.err) / time


def _large_scale(work: SomfaiWork) -> None:
    found = boxes(work)
    by_grains = {d.grains: k for k, d in enumerate(found)}
    ours = error = math.nan
    if {200, 600} <= set(by_grains) and len(found) - 1 > by_grains[600]:
        near, near_err = _speed_between(found[by_grains[200]], found[by_grains[600]])
        far, far_err = _speed_between(*found[-2:])
        ours = near / far
        error = abs(ours) * hypot(near_err / near, far_err / far)
    work.claim("large-scale", ours, error)


def _marks(work: SomfaiWork) -> None:
    """The ratio of c from a later mark to c_tof is the ratio of the two delays. The marks of one packing vary together,
    so the error is that of t10 - ratio x mark."""
    low, high = ([[member(f"front.{mark}")(s) for s in work.some(e, 1e-4, parts="front")] for mark in MARKS]
                 for e in ("low", "square"))
    for k, name in ((1, "c by the first peak over c_tof"), (2, "c by the zero crossing over c_tof")):
        delay = Sum(high[k]).mean - Sum(low[k]).mean
        ratio = (Sum(high[0]).mean - Sum(low[0]).mean) / delay
        u, v = (Sum(1 * t10 + -ratio * mark for t10, mark in zip(each[0], each[k])) for each in (low, high))
        work.claim("mark", ratio, hypot(u.err, v.err) / delay, name=name)


# ---- lattices -------------------------------------------------------------------------------------------------------

def _lattices(work: SomfaiWork) -> None:
    """Equal balls, Fig. 8."""
    theory = [lattice_speed(5e-7, eta) for eta in (0, 1)]
    off = [lattice_small(work, bool(k), 5e-7) / theory[k] for k in (0, 1)]
    far = [lattice_long(work, bool(k))[1] / theory[k] for k in (0, 1)]
    work.claim("lattice-smooth", off[0], 0.0)
    work.claim("lattice-friction", off[1], 0.0)
    work.claim("lattice-approach", abs(far[1] - 1) / abs(off[1] - 1), 0.0)
    work.claim("lattice-finite", abs(off[1] - 1) / abs(off[0] - 1), 0.0)


LOWER, HIGHER = 216, 672  # grains


def _over(work: SomfaiWork, ensemble: str, friction: bool, p: float, grains: int, path: str) -> Sum:
    """A quantity over the samples of a set."""
    part = path.split(".")[0]
    some = work.some(ensemble, p, grains, part if "." in path else "front")
    return Sum(member(path)(sample) for sample in some if (sample.friction > 0) == friction)


def _unequal(work: SomfaiWork) -> None:
    """Unequal balls at P* = 3 p/alpha^(3/2): at P* >= 1, speed and contacts are those of the perfect lattice. Below
    that, disorder has an effect."""
    for p, reduced in ((1e-6, 0.1), (1e-5, 1.0), (1e-4, 10.0)):
        for friction, kind in enumerate(NAMES):
            where = ("uneven", bool(friction), p)
            h1, h2 = (_over(work, *where, grains, "height") for grains in (LOWER, HIGHER))
            t1, t2 = (_over(work, *where, grains, "front.t10") for grains in (LOWER, HIGHER))
            time, perfect = t2.mean - t1.mean, lattice_small(work, bool(friction), p)
            speed = (h2.mean - h1.mean) / time
            error = speed * hypot(t1.err, t2.err) / time
            words: dict[str, Any] = {"samples": t2.n, "p": p, "reduced": reduced, "kind": kind}
            work.claim("uneven-above" if reduced >= 1 else "uneven-below", speed / perfect, error / perfect, **words)
            if reduced >= 1:
                z = _over(work, *where, HIGHER, "statics.zs")
                work.claim("uneven-contacts", z.mean, z.err, **words)


def _four(work: SomfaiWork) -> None:
    """z* at the two lowest pressures, and its limit at p = 0 from z0 + a sqrt(p)."""
    lower, upper = 1e-7, 1e-6
    root = math.sqrt(upper / lower)
    for friction, kind in enumerate(NAMES):
        a, b = (_over(work, "uneven-low", bool(friction), p, HIGHER, "statics.zs") for p in (lower, upper))
        limit = a.mean - (b.mean - a.mean) / (root - 1)
        work.claim("four", limit, hypot(a.err * root, b.err) / (root - 1), a.n, kind=kind)
        work.say("claims", f"Lattice of balls 1 +- 0.005, {'with' if friction else 'without'} friction: z* = "
                           f"{a.mean:.3f} +- {a.err:.3f} at p = 1e-7, {b.mean:.3f} +- {b.err:.3f} at 1e-6.")


# ---- modes and damping ----------------------------------------------------------------------------------------------

def _count_soft(work: SomfaiWork, ensemble: str) -> Sum:
    found = Sum()
    for _, _, network in work.walk(ensemble, 1e-4, most=PACKINGS):
        modes = network.modes(vectors=False, solver="dense")
        found.add(int(np.sum(modes.omega[modes.n_zero:] < SOFT)))
        work.tell("low modes", 0.9)
    return found


def _soft_modes(work: SomfaiWork) -> None:
    rough, smooth = _count_soft(work, "square"), _count_soft(work, "smooth")
    a, b = rough.mean, smooth.mean
    work.say("claims", f"Modes with 0 < omega < {SOFT:g}: {a:.1f} +- {rough.err:.1f} a packing with friction, {b:.1f} "
                       f"+- {smooth.err:.1f} without.")
    work.claim("soft", b / a, b / a * hypot(rough.err / a, smooth.err / b), smooth.n)


def _damping(work: SomfaiWork) -> None:
    """Ratios to the signal without damping, a value a packing."""
    levels = LEVELS[1:]
    peaks, rests, losses, arrivals, times = ([Sum() for _ in levels] for _ in range(5))
    bare_times = Sum()
    for _, _, network in work.walk("square", 1e-4, most=PACKINGS):
        bare = damped(network, 0.0)
        first = front(bare.t, bare.F)
        rest0 = rms_after(bare.t, bare.F, first.t_zero)
        for k, zeta in enumerate(levels):
            s = damped(network, zeta)
            own = front(s.t, s.F)
            peak, rest = own.amplitude / first.amplitude, rms_after(s.t, s.F, first.t_zero) / rest0
            for sums, value in ((peaks, peak), (rests, rest), (losses, (1 - peak) / (1 - rest)),
                                (arrivals, own.t10 / first.t10), (times, own.t10)):
                sums[k].add(value)
        bare_times.add(first.t10)
        work.tell("damping", 0.95)
    for k, zeta in enumerate(levels):
        work.claim("damping", losses[k].mean, losses[k].err, peaks[k].n, zeta=zeta)
        work.say("claims", f"zeta = {zeta:g}: the first peak keeps {peaks[k].mean:.3f} +- {peaks[k].err:.3f} of its "
                           f"height, what follows {rests[k].mean:.3f} +- {rests[k].err:.3f} of its root mean square; "
                           f"t10 goes from {bare_times.mean:.1f} to {times[k].mean:.1f}.")
    work.claim("strong", peaks[-1].mean, peaks[-1].err, peaks[-1].n, zeta=levels[-1])
    work.claim("strong-arrival", arrivals[-1].mean, arrivals[-1].err, peaks[-1].n, zeta=levels[-1])


# ---- Eq. (17) -------------------------------------------------------------------------------------------------------

def bessel(x: float, n: int) -> list[float]:
    """J_0 .. J_(n - 1) at x > 0 by the downward recurrence J_(m-1) = (2m/x) J_m - J_(m+1), normalised by J_0^2 + 2 sum
    J_m^2 = 1, with the sign of J_0 + 2 sum J_2k = 1 (Abramowitz and Stegun, 9.1.76 and 9.1.46)."""
    order = int(x + 30 + 15 * float(np.cbrt(x)))
    order += order % 2
    j = [0.0] * max(n, order + 1)
    above, here, even, squares = 0.0, 1e-140, 0.0, 0.0
    for m in range(order, 0, -1):
        j[m] = here
        if m % 2 == 0:
            even += here
        squares += here * here
        above, here = here, 2 * m / x * here - above
    j[0] = here
    scale = math.copysign(1 / math.sqrt(here * here + 2 * squares), here + 2 * even)
    return [value * scale for value in j[:n]]


def _first_pulse(t: float) -> tuple[float, float]:
    """The chain whose first ball, next to the wall, has velocity c at t = 0 (units of sp_chain). The method of images
    gives u'_n = J_(2n-2)(2t) - J_(2n+2)(2t). The kinetic energy from the front back to the first zero crossing, and the
    root mean square of u' behind it."""
    orders = int(2 * t + 30 + 15 * float(np.cbrt(2 * t)))
    orders += orders % 2 + 4
    j = bessel(2 * t, orders)
    v = [j[2 * n - 2] - j[2 * n + 2] for n in range(orders // 2 - 2, 0, -1)]  # from the front
    end = next(k for k, one in enumerate(v) if one < 0 and orders // 2 - 2 - k < t)
    return total(0.5 * one * one for one in v[:end]), math.sqrt(total(one * one for one in v[end:]) / (len(v) - end))


def _energy(work: SomfaiWork) -> None:
    early, late = 1e4, 1e5
    (energy, behind), (later, later_behind) = _first_pulse(early), _first_pulse(late)
    work.claim("energy", math.log(later / energy) / math.log(late / early), 0.0)
    work.claim("oscillations", math.log(later_behind / behind) / math.log(late / early), 0.0)
