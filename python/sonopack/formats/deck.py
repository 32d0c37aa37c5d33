"""The files that LAMMPS is given for a packing: the gas of grains, and the input script with our contact law, our
piston, and our protocol. Lengths in mean diameters, density and E* of the grains 1."""
from __future__ import annotations

import math
import pathlib
from typing import Any

import numpy as np

from .. import __version__, _core
from .._core import Floats, call
from .._native import ffi, lib
from ._faults import bad_option
from .export import number_text as n
from .export import rows_of
from .law import eta
from .work import sphere_mass

#: files of a run in its folder; WORDS is what LAMMPS and its launcher print, RESULT one line, written last
GAS, INPUT, SCENE, WORDS, LOG, GRAINS, CONTACTS, RESULT = FILES = (
    "gas.data", "in.pack", "scene.cfg", "printed.txt", "log.lammps", "grains.dump", "contacts.dump", "result.txt")

# The fraction of the stable step of packing.time_step, 0.7, corresponds to 0.1 sqrt(m/k) of the lightest grain and the
# stiffest contact. LAMMPS has one step for a whole run, so that it must be stable at the hardest impact.
_STEP_AT_DEFAULT, _DEFAULT_STEP = 0.1, 0.7
_REST = 1e-5  # once LAMMPS has come to this many pressures our own compression takes over
_WEAK = 1e-8  # how much weaker the springs of the viscous contacts are


def check(given: Any) -> None:
    """Refuses a spec that LAMMPS cannot make."""
    call(lib.sp_pack_spec_check, given)
    s = lib.sp_pack_spec_resolve(given)
    for wrong, key, rule in (
            (s.kind != lib.SP_PACK_PISTON, "kind", ': must be "piston"'),
            (s.cell != lib.SP_CELL_PISTON, "cell", ': must be "piston"'),
            (s.tangential != lib.SP_TANGENTIAL_CONSTANT, "tangential", ': must be "constant"'),
            (s.types.fractions > 0, "types.fraction", ": must be empty"),
            (s.shape != lib.SP_SHAPE_SPHERE, "shape", ' = "disk": must be "sphere"'),
            (s.gravity != 0, "gravity", f" = {s.gravity:g}: must be 0"),
            (s.protocol == lib.SP_PROTOCOL_AFFINE, "protocol", ' = "affine": must be another'),
            (s.compression != lib.SP_COMPRESSION_PISTON, "compression", ': must be "piston"'),
            (s.history_count > 0, "history", f" = ({s.history_count} pressures): must be empty, and the packing that "
                                             'is made given to packing.kind = "file",'),
            (getattr(s, "reference", False), "reference", " = true: must be false"),
            (s.viscous_limit != 1 and s.viscous_limit < 1000, "viscous_limit",
             f" = {s.viscous_limit:g}: must be 1, or at least 1000 (no limit),")):
        if wrong:
            raise bad_option(f"{rule} for --engine lammps", f"packing.{key}")


# ---- numbers --------------------------------------------------------------------------------------------------------

def restitution(alpha: float) -> float:
    """The number for which the polynomial of `damping tsuji' is alpha. Between 0 and 1 it falls from 1.2728 to 0, and
    it grows without bounds above 1.3. LAMMPS takes any number there."""
    low, high = (10.0, 1.3) if alpha > _tsuji(0) else (0.0, 1.0)
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _tsuji(middle) > alpha else (low, middle)
    return 0.5 * (low + high)


def _tsuji(e: float) -> float:
    return 1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))))


def pressure_of(s: Any) -> float:
    """Pressure under which LAMMPS packs: that of the spec unless it would push grains through each other."""
    small = s.diameter_min / lib.sp_sizes_moment(ffi.addressof(s), 1)
    return float(min(s.pressure, 1e-3 * min(1, 4 * small * small)))


def _mass(r: float) -> float:
    return float(sphere_mass(r))  # type: ignore[arg-type]


def _step(s: Any, pressure: float, height: float) -> float:
    """The time step for the stiffest contact: with a wall, of the largest grain, under ten times the load of one grain,
    or at the impact of the piston, which pressure has accelerated over the whole height of the gas."""
    r = 0.5 * s.diameter_max
    e = math.sqrt(r)
    loaded = 2 * e * math.sqrt(math.pow(0.75 * (10 * pressure * (s.diameter_max * s.diameter_max)) / e, 2 / 3))
    struck = 2 * e * math.sqrt(math.pow(0.9375 * _mass(r) * (2 * pressure * height / s.piston_mass) / e, 0.4))
    viscous = 6.25 * s.damping  # a lighter damping allows longer steps
    stable, usual = (math.sqrt(v * v + 4) - v for v in (viscous, 6.25 * 0.8))
    step = min(s.time_step, _DEFAULT_STEP)
    factor = _STEP_AT_DEFAULT * step / _DEFAULT_STEP * min(2, stable / usual)
    return float(factor * math.sqrt(_mass(0.5 * s.diameter_min) / max(loaded, struck)))


# ---- gas ------------------------------------------------------------------------------------------------------------

def radii(s: Any) -> Floats:
    """Of all grains of a resolved spec."""
    r = np.empty(s.grains)
    lib.sp_radii_draw(ffi.addressof(s), _core.pointer_to(r))
    return r


def files(given: Any) -> dict[str, bytes]:
    """Gas and input script of a spec."""
    check(given)
    s = lib.sp_pack_spec_resolve(given)
    r, x, height = radii(s), np.zeros((s.grains, 3)), ffi.new("double *")
    call(lib.sp_gas_make, ffi.addressof(s), _core.pointer_to(r), _core.pointer_to(x), height)
    return {GAS: _gas(s, r, x, height[0]), INPUT: _script(s, height[0]).encode()}


def _piston_mass(s: Any) -> float:
    return float(s.piston_mass * (s.width * (s.depth if s.dim == 3 else 1)))


def _gas(s: Any, r: Floats, x: Floats, height: float) -> bytes:
    """The grains, and the atom that is the piston, of the smallest diameter so that it widens no list."""
    small, up, period = s.diameter_min, s.dim - 1, (s.width, s.depth)
    at = [0.5 * period[0], 0.5 * period[1] if s.dim == 3 else 0.0, 0.0]
    at[up] = height
    edges = [(axis, 0.0, period[a]) for a, axis in enumerate("xyz"[:up])] + [("xyz"[up], -1.0, height + 1)]
    edges += [("z", -0.5, 0.5)] if s.dim == 2 else []
    head = f"gas of grains, and the piston: written by sonopack {__version__}\n\n{s.grains + 1} atoms\n2 atom types\n\n"
    head += "".join(f"{n(low)} {n(high)} {axis}lo {axis}hi\n" for axis, low, high in edges) + "\nAtoms # sphere\n\n"
    ids = np.arange(1, s.grains + 1)
    piston = [s.grains + 1, 2, *map(n, (small, _piston_mass(s) / (math.pi / 6 * small * small * small), *at))]
    return (head.encode() + rows_of([ids, ids * 0 + 1, 2 * r, np.ones(s.grains), *x.T])
            + (" ".join(map(str, piston)) + "\n").encode())


# ---- input script ---------------------------------------------------------------------------------------------------

def _springs(s: Any, factor: float, alpha: float) -> str:
    """Springs with Coulomb's law, and normal viscosity. F_n = kn sqrt(R12) n^(3/2) and k_t = kt sqrt(R12 n) of two
    grains; walls: twice. damping: viscous tangential over viscous normal coefficient."""
    text = f"hertz {n(factor * (2.0 / 3.0))} {n(restitution(alpha))}"
    if not s.friction > 0:
        return text + " tangential linear_nohistory 0 0 damping tsuji limit_damping"
    damping = 0.0 if s.viscous_limit > 1 else math.sqrt(eta(s.poisson))
    law = f"tangential mindlin/force {n(factor * eta(s.poisson))} {n(damping)} {n(s.friction)}"
    return f"{text} {law} damping tsuji limit_damping"


def _viscosity(s: Any, factor: float, alpha: float) -> str:
    """Tangential viscosity alone, of springs without weight."""
    normal = f"hertz {n(factor * (_WEAK * 2.0 / 3.0))} {n(0.1)}"
    damping = math.sqrt(eta(s.poisson) / _WEAK) * alpha / _tsuji(0.1)
    return f"{normal} tangential linear_nohistory {n(damping)} 1e15 damping tsuji"


def _script(s: Any, height: float) -> str:
    """The input script. Largest accelerations over the pressure: calm, at which a global damping of the rate drag
    begins, and rest, at which the run ends. Coulomb's law may leave the viscous tangential forces alone (twice), which
    then have contacts of their own."""
    flat, turns, twice, p = s.dim == 2, s.friction > 0, s.friction > 0 and s.viscous_limit > 1, pressure_of(s)
    along = "0 {} 0" if flat else "0 0 {}"
    # c = 2 zeta sqrt(m k_n) with k_n = 1.5 F_n/n; tsuji: c = alpha sqrt(m F_n/n)
    alpha, longest = 2 * s.damping * math.sqrt(1.5), max(s.width, s.depth, 0.5 * height)
    most = s.max_steps or int(4e6 * max(1, height / 75) * max(1, math.pow(s.pressure / 1e-4, -0.3)))
    numbers = {"p": p, "step": _step(s, p, height), "calm": s.calm * p, "rest": _REST * p,
               "drag": s.drag * math.pow(p / 1e-4, 1 / 3) * min(1, 30 / longest), "piston": _piston_mass(s)}
    words = {
        "grains": s.grains, "dim": s.dim, "version": __version__, "input": INPUT, "gas": GAS, "most": most,
        "skin": n(0.15 * s.diameter_max), "up": "y" if flat else "z", "column": 3 if flat else 4,
        "numbers": "".join(f"variable    {name:<10} equal {n(value)}\n" for name, value in numbers.items()),
        "boundary": "p f p" if flat else "p p f", "processors": "* 1 1" if flat else "* * 1",
        "law": _springs(s, 1, alpha), "wall": _springs(s, 2, alpha), "law_v": _viscosity(s, 1, alpha),
        "wall_v": _viscosity(s, 2, alpha),
        "move": "NULL v_top NULL" if flat else "NULL NULL v_top", "plane": "0 0 0 0 -1 0" if flat else "0 0 0 0 0 -1",
        "area": "" if flat else "*ly", "twice": "-c_roof_v" if twice else "", "push": along.format("v_push"),
        "turns": "+c_turn" if turns else "", "drag": along.format("v_drag_p"),
        "tangent": "p13 p14 p15" if twice else "p1 p2 p3", "file_grains": GRAINS, "file_contacts": CONTACTS,
        "result": RESULT}
    marks = {"%": False, "?flat": flat, "?turns": turns, "?twice": twice, "?once": not twice}
    text = ""
    for line in pathlib.Path(__file__).with_name("pack.in").read_text().splitlines(keepends=True):
        mark, _, rest = line.partition(" ")
        text += line if mark not in marks else rest if marks[mark] else ""
    for name, value in words.items():
        text = text.replace(f"<{name}>", str(value))
    return text
