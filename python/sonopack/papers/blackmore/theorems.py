"""Claims in words and theorems, tested by computation: chaos (Theorem 1), integrability, long cycles, parameters, long-term
trends, and the hybrid scheme."""
from __future__ import annotations

import dataclasses
import itertools
import math
import re
from typing import Any

import numpy as np

from ..._chain import chain_front
from ..._column import Column
from ..._core import Floats, SonopackError
from ..._table import Table
from ..work import Tell, Work
from .column import GRAVITY, RESTITUTION, coefficients, column, separation, speed2, stiff
from .rows import add

# ---- chaos ----------------------------------------------------------------------------------------------------------

SETTLED = 400  # taps; N = 1, T = 0.2 s: |multiplier| = 0.83, after these only the fixed point is left
EXPONENTS, POINTS, SHOWN, AVERAGED = 96, 240, 40, 300


@dataclasses.dataclass(frozen=True)
class Scan:
    """A scan of the period T or the amplitude a, with the paper's stiffness or with one for which (1) mostly holds.
    stiffness: in m g/r."""

    name: str
    over: str
    low: float
    high: float
    stiffness: float

    @property
    def parameter(self) -> str:
        return {"T": "period", "a": "amplitude"}[self.over]

    @property
    def unit(self) -> str:
        return {"T": "s", "a": "cm"}[self.over]

    def column(self, **keys: Any) -> Column:
        return column(1, stiffness=stiff(self.stiffness), **keys)

    def table(self, work: Work, output: str, **keys: Any) -> Table:
        c = self.column(output=output, parameter=self.parameter, from_=self.low, to=self.high, **keys)
        return c.table(threads=work.threads)


_SHORTEST = 0.5 / 7.5 * (1 + 1e-9)  # the period of a tap
SCANS = (Scan("chaos-period", "T", _SHORTEST, 1, 2), Scan("chaos-amplitude", "a", 0.05, 4, 2),
         Scan("chaos-period-stiff", "T", _SHORTEST, 1, 100), Scan("chaos-amplitude-stiff", "a", 0.05, 2, 100))


def make_chaos(work: Work, tell: Tell) -> None:
    _fixed_point(work)
    _cycles(work)
    for k, scan in enumerate(SCANS):
        tell(0.05 + 0.95 * k / len(SCANS))
        table = scan.table(work, "lyapunov", points=EXPONENTS, taps=AVERAGED)
        _exponents(work, scan, table)
        if work.folder:
            _show(work, scan, table)
    work.say("chaos", work.texts["chaos"])


def _fixed_point(work: Work) -> None:
    c = column(1, period=0.2, taps=1000)
    state, d = c.map(c.map(c.start(), SETTLED)[0])
    y, v = c.positions(state)
    exponent = c.lyapunov()
    det = float(np.linalg.det(d))
    add(work, "fixed-y", y[0])
    add(work, "fixed-v", v[0])
    add(work, "determinant", det)
    add(work, "trace", np.trace(d))
    add(work, "fixed-lambda", exponent.lambda_, abs(exponent.lambda_ - 0.5 * math.log(det)) + exponent.error)


def _cycles(work: Work) -> None:
    add(work, "cycle", column(1, period=0.7, taps=1000).lyapunov().cycle)
    for n in (5, 10):
        exponent = column(n, taps=1000).lyapunov()
        add(work, "settings", exponent.lambda_, exponent.error, n=n, cycle=exponent.cycle)
        work.say("chaos", f"At the settings of Fig. 1, N = {n}, the column is a cycle of {exponent.cycle} "
                          f"tap{'' if exponent.cycle == 1 else 's'} with lambda = {exponent.lambda_:.4f}: not chaotic.")


def _exponents(work: Work, scan: Scan, table: Table) -> None:
    at, lam, error, cycle = (table[name] for name in table.names[:4])
    chaotic = np.flatnonzero((cycle < 1) & (lam > error))  # no cycle, and an exponent larger than its error
    among = chaotic if len(chaotic) else np.arange(len(lam))
    best = int(among[np.argmax(lam[among])])
    words: dict[str, Any] = {"K": scan.stiffness, "over": scan.over}
    add(work, "largest", lam[best], error[best], at=at[best], points=len(chaotic), all=len(lam), low=scan.low,
        high=scan.high, **words)
    if not len(chaotic):
        return
    low, high = float(at[chaotic].min()), float(at[chaotic].max())
    work.say("chaos",
             f"N = 1, K = {scan.stiffness:g} m g/r, through {scan.over} from {scan.low:.3g} to {scan.high:g} "
             f"{scan.unit}: chaos at {len(chaotic)} of {len(lam)} values, between {low:.3f} and {high:.3f} "
             f"{scan.unit}, with lambda up to {lam[best]:.3f} a tap.")
    if scan.over == "a":
        add(work, "onset", low, (scan.high - scan.low) / (EXPONENTS - 1), all=len(lam), **words)
    else:
        add(work, "shortest", lam[0], error[0], **words)
    # over 400 taps at the point with the largest exponent
    run = scan.column(taps=400, **{scan.parameter: float(at[best])}).run([])
    add(work, "kept", separation(run), at=at[best], **words)


def _show(work: Work, scan: Scan, exponents: Table) -> None:
    orbits = scan.table(work, "bifurcation", points=POINTS, transient=100, taps=SHOWN)
    violated = next((line for line in orbits.comments if line.startswith("warning: ordering (1) violated")), "")
    more = re.split("[,:]", violated.removeprefix("warning: "))[0]
    work.save_table(f"{scan.name}-lambda", exponents)
    work.save_table(f"{scan.name}-orbits", orbits)
    told = f"; {more}, the centre below the floor" if more else ""
    work.draw("chaos", scan.name, "column", orbits, exponents,
              caption=f"One particle, K = {scan.stiffness:g} m g/r: its position at .99T of {SHOWN} taps over the "
                      f"{scan.parameter}, and the Lyapunov exponent{told}.")


# ---- claims ---------------------------------------------------------------------------------------------------------

def make_claims(work: Work, tell: Tell) -> None:
    _integrability(work)
    _painleve(work)
    _solitons(work)
    _burgers(work)
    tell(0.5)
    _periods(work)
    for a, f in ((2, 5.5), (2, 7.5), (2, 10), (1, 7.5)):
        _choice(work, a, f)
    for n in (5, 10):
        _trend(work, n)
    _hybrids(work)


# ---- (22) -----------------------------------------------------------------------------------------------------------

def _integrability(work: Work) -> None:
    """Without taps and dissipation (22) is a Hamiltonian system. If it were integrable, no exponent would be
    positive."""
    period = 0.2
    for n in (1, 2, 3, 5):
        c = column(n, e=0.0, amplitude=0.0, drop=0.1, period=period, stiffness=100 * n * 1.0 * GRAVITY, taps=1000)
        found = c.lyapunov()
        add(work, "integrable", found.lambda_ / period, found.error / period, n=n,
            order="violated" if found.violated else "holds")
    work.say("claims",
             "A single elastic particle is integrable, as every system of one degree of freedom. Two and more are "
             "chaotic: their contacts open and close, and (22) is not integrable.")


# ---- (35), (37), (45) -----------------------------------------------------------------------------------------------

def _painleve(work: Work) -> None:
    """With e = 0, w = y_z obeys w_tt = (a w + b w^2 + d w^3/3)_zz + f w_zzzz. About a singularity w = alpha/phi with
    alpha^2 = -6 f/d, an arbitrary function enters with phi^(r - 1) at each resonance r; here (r - 3)(r - 4)(f (r - 1)(r
    - 2) + d alpha^2) = 0. Two equal resonances bring in a logarithm, so that the equation fails Painleve's test, which
    integrable equations pass. (37) has the same d and f with the other sign."""
    c = column(10)
    r = c.radius()
    h = 2 * r
    minus, unit = coefficients(r, 1 / h)[1], c.stiffness * math.pow(h, 4) / c.mass()
    f, d = unit * minus / 36, unit * 2 * r * (1 / h)
    root = math.sqrt(9 - 4 * (2 + d * (-6 * f / d) / f))
    resonances = [0.5 * (3 - root), 3.0, 4.0, 0.5 * (3 + root)]
    equal = sum(abs(a - b) < 1e-12 for a, b in itertools.combinations(resonances, 2))
    add(work, "painleve", equal, r=resonances)


def _largest_growth(c: Column, model: str) -> float:
    """Of waves longer than two of the paper's cells."""
    waves = 0.01 * 1.01**np.arange(int(math.log(math.pi / 0.01 / 0.01, 1.01)) + 1)
    return max(c.symbol(model, float(k), alpha=0.5 / c.radius()).growth for k in waves)


def _solitons(work: Work) -> None:
    c = column(10, e=0.0)
    for model in ("eq35", "eq37"):
        add(work, f"solitons-{model}", _largest_growth(c, model))
    half, whole = (chain_front(n) for n in (5000, 10000))
    add(work, "pulse", math.log(half.amplitude / whole.amplitude) / math.log(2.0))


def _force(c: Column, z: Floats) -> Floats:
    """With e = 0 the force of (45) depends on z alone, and (45) is u_t + u u_z = f(z): each point moves in the field f
    like a particle. f at z."""
    from scipy.integrate import simpson

    h = 2 * c.radius()
    y = np.linspace(-h, h, 65)
    off = (z[..., None] + y - 7 * h) / (3 * h)
    integral = simpson(np.exp(-0.5 * off**2) * (h - np.abs(y)), dx=h / 32) / (7 * h * math.sqrt(2 * math.pi))
    return np.asarray(-GRAVITY - c.stiffness / c.mass() * integral)


def _meeting(c: Column, until: float) -> float:
    """When the first two points meet, of pairs 1e-4 cm apart, at rest every 0.25 cm; at most `until`. Where f falls
    with height, neighbours meet and the smooth solution ends."""
    z, step, t = np.arange(0, 2 * c.particles * c.radius(), 0.25), 1e-4, 0.0
    x = np.stack([z, z + 1e-4])
    v = np.zeros_like(x)
    while t < until:  # leapfrog
        half = v + 0.5 * step * _force(c, x)
        x = x + step * half
        v = half + 0.5 * step * _force(c, x)
        if np.any(x[1] <= x[0]):
            return t + step
        t += step
    return until


def _burgers(work: Work) -> None:
    c = column(10, e=0.0, model="bsr", bsr="literal")
    run = c.run([])
    add(work, "lost", run.violated_at, run.time_step)
    add(work, "burgers", _meeting(c, 4.0))


# ---- Theorem 1 ------------------------------------------------------------------------------------------------------

LONGEST, STARTS, ROUNDS = 12, 60, 40


def _newton(c: Column, period: int, state: Floats) -> tuple[float, Floats]:
    """A fixed point of `period` taps, N = 1, by Newton's method: the final residual, infinite after a failure."""
    x = state
    for _ in range(ROUNDS):
        try:
            after, d = c.map(x, period)
            residual = float(np.abs(after - x).sum())
            if residual < 1e-9:
                return residual, x
            x = x - np.linalg.solve(d - np.eye(2), after - x)
        except (SonopackError, np.linalg.LinAlgError):
            break
        if not (np.abs(x) < [[1e3], [1e4]]).all():
            break
    return math.inf, x


def _is_shorter(c: Column, period: int, x: Floats) -> bool:
    """Whether the orbit returns to x after fewer than `period` taps."""
    state = x
    for k in range(1, period):
        try:
            state, _ = c.map(state)
        except SonopackError:
            return True
        if period % k == 0 and float(np.abs(state - x).sum()) < 1e-6:
            return True
    return False


def _periods(work: Work) -> None:
    c = column(1, stiffness=stiff(100), amplitude=0.584)  # chaotic, see the item chaos
    state = c.map(c.start(), 200)[0]
    found: set[int] = set()
    for _ in range(STARTS):
        state, _ = c.map(state)
        for period in set(range(1, LONGEST + 1)) - found:
            residual, x = _newton(c, period, state)
            if residual < 1e-9 and not _is_shorter(c, period, x):
                found.add(period)
    add(work, "cycles", max(found, default=0), found=", ".join(map(str, sorted(found))), tried=LONGEST)


# ---- Section 2 ------------------------------------------------------------------------------------------------------

def _choice(work: Work, amplitude: float, frequency: float) -> None:
    """The paper's choice N >= 20, T = 1, pi/omega < 1/10, a <= 1/50, r < 1/100, m < 1/20, read in m, kg and s; these
    are values at its edge."""
    run = column(20, mass=40.0, radius=0.9, amplitude=float(amplitude), frequency=float(frequency), taps=10).run([])
    rest = [tap.rest for tap in run.taps]
    add(work, "choice-order", separation(run), a=amplitude, f=frequency)
    add(work, "choice-rest", max(rest) if np.isfinite(rest).all() else math.inf, a=amplitude, f=frequency)


def _trend(work: Work, n: int) -> None:
    """Densities at .99T of many taps."""
    taps = 200
    c = column(n, taps=taps)
    run = c.run([(k + 0.99) * c.period for k in range(taps)])
    before, quarter, late = (c.density(y) for y in (np.append(0.0, c.rest()), run.y[taps // 4 - 1], run.y[-1]))
    add(work, "denser", late - before, taps=taps, n=n)
    add(work, "trend", late - quarter, quarter=taps // 4, taps=taps, n=n)


# ---- Section 4 ------------------------------------------------------------------------------------------------------

def _rate(c: Column, e: float, dz: float, y: Floats, v: Floats) -> Floats:
    """Right-hand side of (37) with (38), by central differences at the nodes 2 .. cells - 2; v: velocities."""
    r = c.radius()
    h = 2 * r
    alpha = 1 / h
    plus, minus, b = coefficients(r, alpha)
    here, up, down = y[2:-2], y[3:-1], y[1:-3]
    z, zz = (up - down) / (2 * dz), (up - 2 * here + down) / (dz * dz)
    zzzz = (y[4:] - 4 * up + 6 * here - 4 * down + y[:-4]) / math.pow(dz, 4)
    tz, tzz = (v[3:-1] - v[1:-3]) / (2 * dz), (v[3:-1] - 2 * v[2:-2] + v[1:-3]) / (dz * dz)
    bracket = plus * zz / 3 - h / 3 * (b * z + e * alpha * plus * tz) * zz + h * h * (
        minus * zzzz / 36 + alpha * (2 * r * z * z * zz + e * b * z * zz * tz + e * plus * zz * tzz / 6))
    found: Floats = -GRAVITY - speed2(c) * bracket
    return found


def _breakdown(cells: int, dz: float, dt: float, steps: int, e: float) -> float:
    """The time at which the scheme with dissipation e in (37) breaks down on a grid for the ten particles of Fig. 1, 20 cm
    high: a point is farther away than 10 m, or the end. It begins from (39); above the top of the lattice the force is
    zero."""
    c = column(10)
    tops = c.run(np.arange(steps) * dt).y[:, 10] + 1
    places = dz * np.arange(cells + 1)
    y, old, v = places.copy(), places.copy(), np.zeros(cells + 1)
    for k in range(steps):
        t = (k + 1) * dt
        force = np.full(cells + 1, -GRAVITY)
        inside = places[2:-2] < tops[k]
        with np.errstate(over="ignore", invalid="ignore"):
            force[2:-2] = np.where(inside, _rate(c, e, dz, y, v), -GRAVITY)
            after = 2 * y - old + dt * dt * force
        after[0] = c.floor(t)[0]
        after[1] = after[0] + dz  # no gravity at the floor, which moves this node
        if not np.all(np.abs(after) < 1e3):
            return t
        v, old, y = (after - y) / dt, y, after
    return steps * dt


def _hybrids(work: Work) -> None:
    """With the paper's steps, and with stable steps. In the latter case the time does not depend on the grid, so it is
    the equation that breaks down. (With dissipation it does so earlier on finer grids.)"""
    add(work, "hybrid-printed", _breakdown(2000, 0.01, 0.01, 400, RESTITUTION))
    coarse, fine = _breakdown(100, 0.2, 1e-5, 2000, 0.0), _breakdown(200, 0.1, 1e-5, 2000, 0.0)
    add(work, "hybrid-stable", fine, abs(fine - coarse) + 1e-5)
