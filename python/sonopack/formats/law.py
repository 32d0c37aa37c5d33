"""Completes contacts: overlaps from forces or forces from overlaps, whichever the file gives more exactly, and checks
one against the other where both are given."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from .._core import Floats, Integers
from ._faults import bad_file, bad_option, refused
from .options import NAN, WALLS
from .sheet import Mask
from .work import Links, Work, dot, known_overlap, modulus, running_sum


def wall_stiffness(r: Floats, wall: str) -> Floats:
    """E12 sqrt(R12) of a grain at a wall of this kind (Somfai et al. 2005, Appendix A)."""
    r12 = r * r / (r + r) if wall == "grain" else r
    e: Floats = (1.0 if wall == "rigid" else 0.5) * np.sqrt(r12)
    return e


def stiffness_of(r: Floats, i: Integers, j: Integers, wall: str) -> Floats:
    """The same of contacts of two grains, or with walls."""
    one, other = r[i], r[np.maximum(j, 0)]
    return np.where(j < 0, wall_stiffness(one, wall), 0.5 * np.sqrt(one * other / (one + other)))


def hertz_force(e: Floats, overlap: Floats) -> Floats:
    """The normal force at an overlap."""
    force: Floats = 4.0 / 3.0 * e * overlap * np.sqrt(overlap)
    return force


def hertz_overlap(e: Floats, force: Floats) -> Floats:
    """The overlap at a force. With the C library's power: numpy's own may differ in the last bit."""
    return np.array([math.pow(value, 2.0 / 3.0) for value in (0.75 * force / e).tolist()], dtype=float)


def eta(poisson: float) -> float:
    """k_t / k_n of Mindlin."""
    return (1.0 - poisson) / (1.0 - 0.5 * poisson)


def near(a: Floats, b: Floats) -> Mask:
    """Whether numbers are the same but for rounding."""
    out: Mask = np.abs(a - b) <= 1e-12 * np.abs(b)
    return out


def usual_stiffness(r: Floats, links: Links, wall: str, friction: float, poisson: float) -> Mask:
    """Which stiffnesses are those of Hertzian spheres anyway, as in our own files, and say nothing new."""
    with np.errstate(invalid="ignore"):
        kn = 2.0 * stiffness_of(r, links.i, links.j, wall) * np.sqrt(links.overlap)
        usual: Mask = (links.kn > 0) & near(links.kn, kn) & (near(links.kt, eta(poisson) * kn) | (not friction > 0))
    return usual


# ---- what the file does not say -------------------------------------------------------------------------------------

def complete(w: Work) -> None:
    """Overlaps, forces and stiffnesses of all contacts, and the kind of walls."""
    o = w.o
    w.poisson = o.keys.get("poisson", o.material.poisson if o.material is not None else 0.0)
    if not o.given("friction"):
        raise bad_option(": no file gives it; must be given by --set friction=MU (0: no tangential forces, no rotations)",
                         "friction")
    w.friction = o.number("friction")
    usual = {"lammps-data": "elastic", "lammps-dump": "elastic", "liggghts": "elastic", "yade": "grain"}
    w.wall = str(o.keys.get("wall", usual.get(w.form, "rigid")))
    springs = bool(np.isfinite(w.links.kn).any() or math.isfinite(o.kn))
    for key, right in (("wall_kn", springs), ("wall_modulus", not springs)):
        if o.given(key) and not right:
            raise bad_option(": is for contacts of given stiffness (--kn); must be wall_modulus for Hertz's law"
                             if key == "wall_kn" else ": is for Hertz's law; must be wall_kn where --kn is given", key)
    if springs:
        _complete_springs(w)
    else:
        _complete_hertz(w, _compare_all(w))
    links = w.links
    links.ft = np.where(np.isnan(links.ft), 0, links.ft + 0.0)
    links.ft = links.ft - dot(links.ft, links.n)[:, None] * links.n  # no part along n, but for rounding
    if w.has_ft and not w.friction > 0:
        w.note("tangential forces are left out, for friction = 0")
    if not w.has_ft and w.friction > 0:
        w.note("tangential forces are not known: 0")


def _compare_all(w: Work) -> bool:
    """Checks forces against overlaps, chooses the kind of walls. Returns whether overlaps follow from the forces."""
    known = known_overlap(w.links)
    some = known[known > 0]
    mean = running_sum(some) / len(some) if len(some) else NAN
    noise = w.place / mean if np.isnan(w.links.overlap).all() else 0.0
    w.report.overlap_error = noise
    from_forces = w.has_forces and not (noise <= 1e-6 or noise <= w.force_place)
    if not w.has_forces and noise > 0.01 and not w.o.rest:
        _fail_digits(w, mean)
    if from_forces:
        w.note("overlaps: from the normal forces by Hertz's law; the digits of the positions give them within "
               f"{noise:.2g} only (LAMMPS: dump_modify ID format float %.17g)")
    if w.has_forces:
        _check_grains(w)
        unknown = int(((w.links.j < 0) & np.isnan(w.links.fn)).sum())
        if unknown > 0:
            w.note(f"{unknown} forces of walls are not in the file: from the overlaps, without tangential forces")
    _choose_wall(w)
    return from_forces


def _complete_hertz(w: Work, from_forces: bool) -> None:
    """Overlaps of contacts with forces follow from these, or from the positions."""
    links = w.links
    own = links.kn > 0  # as contacts with walls of another stiffness have
    e, given = stiffness_of(w.r, links.i, links.j, w.wall), known_overlap(links)
    links.kn, links.kt = np.where(own, links.kn, 0), np.where(own, links.kt, 0)
    forced = ~own & ~np.isnan(links.fn) & (from_forces | ~(given > 0))
    overlap = np.where(own, links.overlap, np.fmax(given, 0))
    overlap[forced] = hertz_overlap(e[forced], links.fn[forced])
    links.overlap = overlap
    links.fn = np.where(np.isnan(links.fn) & ~own, hertz_force(e, overlap), links.fn)


def _complete_springs(w: Work) -> None:
    links, o = w.links, w.o
    own = np.where(links.j < 0, o.number("wall_kn") if o.given("wall_kn") else o.kn, o.kn)
    links.kn = np.where(np.isnan(links.kn), own * w.stiffness, links.kn)
    bad = np.flatnonzero(~(links.kn > 0))
    if len(bad):
        raise bad_file(f"{w.path}: a contact of grain {w.id[links.i[bad[0]]]} has the stiffness {links.kn[bad[0]]:g}; "
                       "must be positive: --kn, or a column kn")
    ratio = eta(w.poisson) if math.isnan(o.kt_ratio) else o.kt_ratio
    links.kt = np.where(np.isnan(links.kt), links.kn * ratio, links.kt)
    forceless, known = np.isnan(links.fn), np.fmax(known_overlap(links), 0)
    links.overlap = np.where(forceless, known, np.where(np.isnan(links.overlap), links.fn / links.kn, links.overlap))
    links.fn = np.where(forceless, links.kn * links.overlap, links.fn)


# ---- forces against overlaps ----------------------------------------------------------------------------------------

@dataclasses.dataclass
class _Comparison:
    """Fn over Hertz's law, of contacts whose overlap is known; spread: largest deviation from the median, over it."""

    count: int = 0
    median: float = NAN
    low: float = 0.0
    high: float = 0.0
    spread: float = NAN

    def fits(self) -> bool:
        """Whether the forces are Hertz's."""
        return abs(self.median - 1) <= 1e-3 and self.spread <= 0.02


def _compare(w: Work, at_walls: bool, wall: str) -> _Comparison:
    links = w.links
    mean = running_sum(np.where(np.isnan(links.fn), 0, links.fn / max(1, len(links))))
    overlap = known_overlap(links)
    known = ~np.isnan(overlap) & (np.abs(overlap) > (10 if at_walls and w.balanced else 1000) * w.place)
    taken = ((links.j < 0) == at_walls) & (links.fn > 0.01 * mean) & known
    if not taken.any():
        return _Comparison()
    e, overlap = stiffness_of(w.r, links.i, links.j, wall)[taken], overlap[taken]
    ratio = np.sort(np.where(overlap > 0, links.fn[taken] / hertz_force(e, overlap), math.inf))
    median, low, high = ratio[len(ratio) // 2], ratio[0], ratio[-1]
    return _Comparison(len(ratio), float(median), float(low), float(high), max(high / median - 1, 1 - low / median))


def _check_grains(w: Work) -> None:
    """Forces and overlaps of grains must follow Hertz's law."""
    c = _compare(w, False, w.wall)
    w.report.hertz, w.report.hertz_spread = c.median, c.spread
    if c.count == 0 or c.fits():
        return
    if c.spread <= 1e-3:
        raise refused(f"{w.path}: all normal forces are {c.median:.6g} times Hertz's at the overlaps; must be 1: E or "
                      "the unit of forces is wrong by this factor (--material E=..., --force-unit)")
    raise refused(f"{w.path}: normal forces are {c.low:.4g} .. {c.high:.4g} times Hertz's at the overlaps; must be 1: "
                  "are E, radii and units right? For another contact law give stiffnesses, --kn or columns kn kt")


def _fail_digits(w: Work, mean: float) -> None:
    """How many digits coordinates need for overlaps within a thousandth."""
    largest = float(np.abs(w.x[:, :w.dim]).max())
    ratio = largest / mean if mean > 0 else math.inf
    digits = min(17, math.ceil(math.log10(1e3 * ratio)) + 1) if ratio < 1e15 else 17
    own = w.grains.digits([w.roles.need(w.grains, "x")[0]])
    raise refused(f"{w.path}: positions have {own} digits, which makes overlaps of {mean:.3g} d wrong by {w.place:.3g} "
                  f"d; {digits} digits are needed (LAMMPS: dump_modify ID format float %.17g), or contacts with their "
                  "forces; --set digits=exact if the numbers are exact")


# ---- walls ----------------------------------------------------------------------------------------------------------

def _choose_wall(w: Work) -> None:
    """The kind of wall that forces and overlaps fit, if both are known and none is given."""
    c, links = _compare(w, True, w.wall), w.links
    if w.o.given("wall_modulus"):
        _soften(w)
        return
    if w.o.given("wall"):
        if c.count > 0 and not c.fits():
            forced = (links.j < 0) & (links.fn > 0)
            links.overlap[forced] = hertz_overlap(stiffness_of(w.r, links.i, links.j, w.wall)[forced], links.fn[forced])
        return
    for kind in WALLS if c.count > 0 else ():
        if _compare(w, True, kind).fits():
            w.wall = kind
            w.note(f"walls: {kind}, by their forces and overlaps")
            return
    if c.count > 0 and w.balanced:  # not as exact as forces of a file
        c, kind = min(((_compare(w, True, kind), kind) for kind in WALLS), key=lambda found: abs(found[0].median - 1))
        if abs(c.median - 1) < 0.1:
            w.wall = kind
            w.note(f"walls: {kind}; their forces are {c.low:.4g} .. {c.high:.4g} times Hertz's at the overlaps")
            return
    c = _compare(w, True, "elastic")
    if c.count > 0 and c.spread > 0.02 and not w.balanced:
        raise refused(f"{w.path}: normal forces of walls are {c.low:.4g} .. {c.high:.4g} times Hertz's at the "
                      "overlaps; must be one number: --set bottom=PLACE and top=PLACE correct the overlaps, --set "
                      "wall=KIND takes them from the forces")
    if c.count > 0:
        _keep_stiffness(w, c.median)
    elif w.cell != "periodic":
        w.note(f"walls: {w.wall} (--set wall=rigid|grain|elastic chooses)")


def _soften(w: Work) -> None:
    """Walls of a modulus of their own: 1/E12 = 1/E* of the grains + 1/E* of the walls."""
    links, times = w.links, w.o.number("wall_modulus") * (1.0 if w.material is None else 1 / modulus(w.material))
    here = links.j < 0
    e = times / (1 + times) * wall_stiffness(w.r[links.i[here]], "rigid")
    force, overlap = links.fn[here], np.fmax(known_overlap(links)[here], 0)
    overlap = np.where(force > 0, hertz_overlap(e, np.where(force > 0, force, 0)), overlap)
    links.overlap[here], links.fn[here] = overlap, np.where(force > 0, force, hertz_force(e, overlap))
    links.kn[here] = 2 * e * np.sqrt(overlap)
    links.kt[here] = links.kn[here] * eta(w.poisson)
    w.note(f"walls: a modulus E* of {times:.6g} times that of the grains")


def _keep_stiffness(w: Work, factor: float) -> None:
    """Walls of none of our kinds whose forces follow Hertz's law with another modulus: each contact keeps its
    stiffness, dF/d(overlap) = 3/2 F/overlap."""
    links, overlap = w.links, known_overlap(w.links)
    own = (links.j < 0) & (overlap > 0) & (links.fn > 0)
    links.overlap = np.where(own, overlap, links.overlap)
    links.kn = np.where(own, 1.5 * links.fn / overlap, links.kn)
    links.kt = np.where(own, links.kn * eta(w.poisson), links.kt)
    w.note(f"walls: {factor:.6g} times as stiff as elastic ones; contacts with them keep this stiffness, so that the "
           "packing is no longer Hertz's (--set wall=elastic makes it so)")
