"""modes --engine slepc: the lowest modes of a packing, or those of a band, by shift and invert on many ranks."""
from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from .._command import Failed, usage, whole
from .._core import Floats
from .._table import Table
from . import network
from .network import EPSILON, SOURCES, EngineParser, Network

_FREQUENCY = "sqrt(E* / rho)/d"
_UNITS = {"omega": _FREQUENCY, "a": "d sqrt(rho d^3)", "b": "E* d/sqrt(rho d^3)", "ab": "E* d^2", "error": _FREQUENCY}
_MOST = 64  # modes of one slice
_NEAR = 1e-12  # of omega_max^2: counts are trusted where no eigenvalue is nearer; MUMPS exchanges rows, so E is small
_ZERO = 1e-10  # of omega_max^2: zero modes are below, all others must be above
_TRIES = 12


def parser() -> EngineParser:
    p = EngineParser("modes", "slepc", "network")
    p.add_argument("--lowest", metavar="K", type=whole(1, 1_000_000_000))
    p.add_argument("--band", metavar="LO:HI")
    p.add_argument("--frequencies-only", action="store_true")
    p.add_argument("--source", choices=SOURCES, default="impulse")
    return p


def _band(a: argparse.Namespace) -> tuple[float, float] | None:
    if (a.lowest is None) == (a.band is None):
        raise usage("--engine slepc: needs --lowest K or --band LO:HI")
    if a.band is None:
        return None
    try:
        low, high = map(float, a.band.split(":"))
    except ValueError:
        low = high = 0.0
    if not 0 < low < high:
        raise usage(f"--band {a.band}: must be LO:HI with 0 < LO < HI, with --engine slepc")
    return low, high


def run(a: argparse.Namespace) -> int:
    """Computes on all ranks."""
    return network.run(a, _compute)


class _Slices:
    """Counts and modes between shifts. `counts` has the number of eigenvalues below each shift (Sylvester: the negative
    pivots of A - shift)."""

    def __init__(self, net: Network) -> None:
        self.net, self.SLEPc = net, network.library("SLEPc")
        self.counts: dict[float, int] = {}
        self.factors = 0
        self.top: float = net.omega ** 2

    def _solver(self, shift: float) -> tuple[Any, int]:
        """A solver with the factor of A - shift, and the number of its negative pivots."""
        eps = self.SLEPc.EPS().create(self.net.comm)
        eps.setOperators(self.net.A)
        eps.setProblemType(self.SLEPc.EPS.ProblemType.HEP)
        eps.setTarget(shift)
        eps.setWhichEigenpairs(self.SLEPc.EPS.Which.TARGET_MAGNITUDE)
        st = eps.getST()
        st.setType("sinvert")
        st.setShift(shift)
        ksp = st.getKSP()
        ksp.setType("preonly")
        pc = ksp.getPC()
        pc.setType("cholesky")
        pc.setFactorSolverType("mumps")
        st.getOperator()
        pc.setFactorSetUpSolverType()
        factor = pc.getFactorMatrix()
        factor.setMumpsIcntl(13, 1)  # the last block is factored where it is counted
        factor.setMumpsIcntl(24, 1)  # pivots that are zero are found
        factor.setMumpsIcntl(14, 60)  # room for exchanged rows
        st.setUp()
        self.factors += 1
        negative, zero, _ = pc.getFactorMatrix().getInertia()
        if zero:
            raise Failed(f"{self.net.path}: {zero} pivots vanish at omega = {shift ** 0.5:.6g}, where no modes can be "
                         "counted")
        return eps, int(negative)

    def below(self, shift: float) -> int:
        """How many eigenvalues are below."""
        if shift not in self.counts:
            eps, self.counts[shift] = self._solver(shift)
            eps.destroy()
        return self.counts[shift]

    def between(self, low: float, high: float) -> list[tuple[float, Any]]:
        """Eigenvalues and vectors between two shifts; as many as their counts say, or none at all."""
        count = self.below(high) - self.below(low)
        if count > _MOST:
            middle = 0.5 * (low + high)
            return self.between(low, middle) + self.between(middle, high)
        if count == 0:
            return []
        eps, _ = self._solver(0.5 * (low + high))
        eps.setTolerances(1e-9, 1000)
        eps.setDimensions(count, 2 * count + 24)
        eps.solve()
        found = []
        for k in range(eps.getConverged()):
            vector = self.net.A.createVecRight()
            value = eps.getEigenpair(k, vector).real
            if low < value < high:
                found.append((value, vector))
        eps.destroy()
        if len(found) != count:
            raise Failed(f"{self.net.path}: {len(found)} modes were found with {low ** 0.5:.6g} < omega < "
                         f"{high ** 0.5:.6g}, where {count} are: try --band with other ends, or `sonopack modes' alone")
        return sorted(found, key=lambda mode: mode[0])


def _known_zeros(net: Network) -> tuple[int, int]:
    """Motions without a force that the contacts tell: spheres that spin about the line through two contacts, and the
    packing that moves as a whole."""
    return int((net.ends == 2).sum()) if net.turns == 3 else 0, len(net.rigid())


def _end_of_lowest(s: _Slices, count: int, zeros: int) -> float:
    """A shift with at least that many modes below that are no zero modes, and few more."""
    net = s.net
    dofs, low, high = int(net.mass.size), _ZERO * s.top, s.top
    if count > dofs - zeros:
        raise usage(f"--lowest {count}: the packing has {dofs - zeros} modes that are no zero modes")
    shift: float = s.top * min(1.0, 0.1 * ((1.2 * count + 4) / dofs) ** (2 / net.dim))
    for _ in range(_TRIES):
        found = s.below(shift) - zeros
        if count <= found <= 1.3 * count + 20:
            return shift
        low, high = (shift, high) if found < count else (low, shift)
        shift *= ((1.15 * count + 6) / max(found, 1)) ** (2 / net.dim)
        if not low < shift < high:
            shift = (low * high) ** 0.5
    return high


def _compute(a: argparse.Namespace, net: Network) -> Table:
    band, s = _band(a), _Slices(net)
    spins, rigid = _known_zeros(net)
    zeros = s.below(_ZERO * s.top)
    if zeros != spins + rigid:
        raise Failed(f"{net.path}: {zeros} modes have omega < {_ZERO ** 0.5 * net.omega:.3g}, and {spins + rigid} are "
                     "known to have none: `sonopack modes' alone tells mechanisms from soft modes")
    low, high = (band[0] ** 2, min(band[1] ** 2, 1.01 * s.top)) if band else (
        _ZERO * s.top, _end_of_lowest(s, a.lowest, zeros))
    modes = s.between(low, high)
    first = s.below(low) + net.rattlers * net.dof
    found = _Modes(net, modes)
    near = [shift for shift in s.counts if found.near(shift, _NEAR * s.top)]
    if near:
        raise Failed(f"{net.path}: a mode is at omega = {near[0] ** 0.5:.12g}, where the modes were to be counted: "
                     "take another number, or other ends of the band")
    error = found.errors(low, high)
    omega, shown = found.omega, len(modes) if band else a.lowest
    last = omega[shown - 1] if shown else 0.0
    to = high ** 0.5 if shown == len(modes) else 0.5 * (last + omega[shown])
    columns = {"n": first + np.arange(shown), "omega": omega[:shown]}
    if not a.frequencies_only:
        columns |= {name: values[:shown] for name, values in found.amplitudes(a.source).items()}
    columns["error"] = error[:shown]
    told = {"file": net.path, "pressure": net.pressure, "dimension": net.dim, "carrying": len(net.mass),
            "zero_modes": net.rattlers * net.dof + zeros, "rattler_modes": net.rattlers * net.dof, "free_spins": spins,
            "rigid_motions": rigid, "mechanisms": 0, "zero_below": 1e-8 * net.omega}
    if not a.frequencies_only:
        told |= {"source": a.source if found.source else "none"} | ({} if found.detector else {"detector": "none"})
        told |= {"residual": f"{found.residual.max(initial=0) / s.top:.3g}", "orthogonality": f"{found.loss:.3g}"}
    told |= {"method": "sparse", "complete": f"{band[0] if band else 0}:{to}",
             "solver": f"slepc, {net.comm.size} ranks", "factors": s.factors}
    return Table.from_columns(columns, _UNITS, told)


class _Modes:
    """Modes between two shifts with what belongs to them; vectors of this rank as rows of `e`."""

    def __init__(self, net: Network, modes: list[tuple[float, Any]]) -> None:
        self.net = net
        count, stretch, back = len(modes), net.S.createVecLeft(), net.A.createVecRight()
        self.e: Floats = np.empty((count, net.end - net.first))
        value, self.residual = np.empty(count), np.empty(count)
        for k, (_, vector) in enumerate(modes):
            vector.normalize()
            net.S.mult(vector, stretch)
            value[k] = stretch.norm() ** 2
            net.S.multTranspose(stretch, back)
            back.axpy(-value[k], vector)
            self.residual[k] = back.norm()
            self.e[k] = vector.getArray() * (-1 if -vector.min()[1] > vector.max()[1] else 1)
        order = np.argsort(value)
        self.value: Floats = value[order]
        self.residual, self.e, self.omega = self.residual[order], self.e[order], np.sqrt(self.value)
        gram = net.total((self.e @ self.e.T).ravel()).reshape(count, count) if count else np.empty((0, 0))
        self.loss = float(np.abs(gram - np.eye(count)).max(initial=0))
        self.source = self.detector = True

    def near(self, shift: float, distance: float) -> bool:
        """Whether an eigenvalue may be as near to a shift as the rounding of a count."""
        return bool(np.any(np.abs(self.value - shift) <= distance + 2 * self.residual))

    def errors(self, low: float, high: float) -> Floats:
        """Bounds of the errors of the frequencies: Kato's and Temple's for a mode apart, the norm of all residuals for
        one that is not (Kahan), and the rounding of the stretches, which moves omega by its norm (Weyl)."""
        bound = np.sqrt(2) * np.linalg.norm(self.residual) * (1 + len(self.value) * self.loss)
        ends = np.concatenate([[low], self.value, [high]])
        gap = np.minimum(np.diff(ends)[:-1], np.diff(ends)[1:]) - bound
        apart = np.where(gap > bound, self.residual ** 2 / np.where(gap > bound, gap, 1), bound)
        square = np.minimum(apart, bound)
        rounding = EPSILON * (16 * self.net.omega + np.sqrt(self.net.S.getSize()[0]) * self.omega)
        error: Floats = square / (self.omega + np.sqrt(np.maximum(self.value - square, 0))) + rounding
        return error

    def amplitudes(self, kind: str) -> dict[str, Floats]:
        """The columns of the table that are of the vectors."""
        net, source, detector = self.net, self.net.source(kind), self.net.detector()
        self.source, self.detector = source is not None, detector is not None
        share = (self.e ** 2).reshape(len(self.e), -1, net.dof).sum(axis=2)
        parts = [self.e @ vector.getArray() if vector is not None else np.full(len(self.e), np.nan)
                 for vector in (source, detector)] + [(share ** 2).sum(axis=1)]
        a, b, squares = net.total(np.concatenate(parts)).reshape(3, -1)
        a = a if kind == "displacement" else a / self.omega
        return {"a": a, "b": b, "ab": a * b, "participation": 1 / (len(net.mass) * squares)}
