"""signal --engine petsc: the Chebyshev expansion of a signal (docs/physics.md, The signal) on many ranks."""
from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from .._command import Failed, amount, number, usage, whole
from .._core import Floats
from .._native import ffi, lib
from .._table import Table
from . import network
from .network import EPSILON, SOURCES, EngineParser, Network, plane_of

_UNITS = {"t": "d/sqrt(E* / rho)", "F": "E* d^2"}
_ROUNDING = 5.0  # of a moment and of a phase, in multiples of EPSILON, as `sonopack signal' has it
_MOST = 20_000_000  # products
_LARGE = 1e100


def parser() -> EngineParser:
    p = EngineParser("signal", "petsc", "network signal")
    p.add_argument("--until", metavar="T")
    for name in ("--from", "--detector"):
        p.add_argument(name, metavar="PLACE", action="append", default=[])
    p.add_argument("--source", choices=SOURCES)
    p.add_argument("--points", metavar="N", type=whole(2, 10_000_000))
    p.add_argument("--tolerance", metavar="EPS", type=number(1e-15, 1))
    p.add_argument("--method", choices=("auto", "chebyshev"))
    p.add_argument("--component", choices=("normal",))
    return p


def run(a: argparse.Namespace) -> int:
    """Computes on all ranks."""
    return network.run(a, _compute)


def _options(a: argparse.Namespace, net: Network) -> Any:
    """The options of the scene, those of the command line over them; what belongs to other methods is refused."""
    given, plain = a.struct.signal, lib.sp_signal_options_default()
    if given.method not in (lib.SP_SIGNAL_AUTO, lib.SP_SIGNAL_CHEBYSHEV):
        raise usage("--engine petsc: signal.method must be auto or chebyshev")
    for name in ("modes", "solver", "front", "damping", "amplitude", "step"):
        if getattr(given, name) != getattr(plain, name):
            raise usage(f"--engine petsc: signal.{name} is not for it")
    given.tolerance = a.tolerance or given.tolerance
    given.points = a.points or given.points
    if a.until is not None:
        given.until = amount("--until", a.until, _UNITS["t"], (1e-9, 1e9), a.material or net.material)
    if given.until == 0:
        given.until = lib.sp_signal_window(net.box[-1], net.pressure)
    a.source = a.source or SOURCES[given.source]
    return ffi.new("sp_signal_options *", given)


def _compute(a: argparse.Namespace, net: Network) -> Table:
    o = _options(a, net)
    planes = plane_of(getattr(a, "from"), "bottom", net, "from"), plane_of(a.detector, "top", net, "detector")
    source, detector = net.source(a.source, planes[0]), net.detector(planes[1])
    for vector, wall in ((source, "bottom"), (detector, "top")):
        if vector is None:
            raise Failed(f"{net.path}: no carrying contact at the {wall} wall")
    momenta = a.source != "displacement"
    scale, norms = 2 / net.omega if momenta else 2.0, source.norm() * detector.norm()
    t = o.until / (o.points - 1) * np.arange(o.points)
    x = net.omega * t
    if x[-1] > 2 * _MOST:
        raise Failed(f"--until: needs {x[-1] / 2:.3g} matrix products, must be at most {_MOST}")
    terms, tail = _terms(x[-1], momenta, 1e-8 * o.tolerance)
    moments, sizes = _moments(net, source, detector, terms, momenta)
    force = scale * _series(moments, x, momenta)
    last = np.abs([_series(row, x[-1:], momenta, squares=True)[0] for row in (
        sizes * np.sqrt(1 + np.arange(terms)), moments)])
    rounding = EPSILON * _ROUNDING * (last[0] + (1 + x[-1]) * last[1])
    error = scale * (norms * tail + rounding)
    if error > o.tolerance * max(np.abs(force).max(), 1e-6 * norms * scale / 2):
        raise Failed(f"{net.path}: error = {error:.3g}, above the tolerance {o.tolerance:g} of the largest |F|")
    ends = [f"{wall if plane is None else f'plane:{plane:g}'}:normal" for wall, plane in zip(("bottom", "top"), planes)]
    told = {"file": net.path, "method": "chebyshev", "source": a.source}
    told |= ({"dimension": 3} if net.dim == 3 else {}) | ({"cell": net.cell} if net.cell != "piston" else {})
    told |= {"height": net.box[-1], "pressure": net.pressure, "error": error, "tolerance": o.tolerance,
             "until": o.until, "omega_max": net.omega, "products": terms - 1,
             "engine": f"petsc, {net.comm.size} ranks", "F": f"from {ends[0]} to {ends[1]}, error {error}"}
    return Table.from_columns({"t": t, "F": force}, _UNITS, told)


def _moments(net: Network, source: Any, detector: Any, terms: int, momenta: bool) -> tuple[Floats, Floats]:
    """detector W_k(X) source for momenta, T_k for displacements (half of the first), X = 1 - 2A/Omega^2, and the sums
    of their sizes. The detector is propagated: it is a force, and never sets anything drifting."""
    before, now, a = detector.copy(), detector, source.getArray()
    next_, sizes, moments = detector.duplicate(), np.empty(terms), np.empty(terms)
    for k in range(terms):
        products = now.getArray() * a
        moments[k], sizes[k] = products.sum(), np.abs(products).sum()
        if k + 1 == terms:
            break
        net.A.mult(now, next_)
        if k == 0:  # W_-1 = -1, and T_1 = X
            before.scale(-1 if momenta else 0)
        twice = 2 if momenta or k else 1
        next_.axpby(twice, -2 * twice / net.omega ** 2, now)
        next_.axpy(-1, before)
        before, now, next_ = now, next_, before
    both = net.total(np.concatenate([moments, sizes]))
    moments, sizes = both[:terms], both[terms:]
    moments[0] *= 1 if momenta else 0.5
    return moments, sizes


def _series(moments: Floats, x: Floats, momenta: bool, squares: bool = False) -> Floats:
    """The sum of moments times J_2k+1(x) for momenta, J_2k(x) for displacements; squares: the root of the sum of the
    squares of its terms. Downward recurrence [AS, 9.1.27], scaled by J_0^2 + 2 sum J_m^2 = 1."""
    z, top = np.maximum(x, 1e-30), max(2 * len(moments), int(x[-1])) + 40 + int(12 * x[-1] ** (1 / 3))
    above, here, total, size = np.zeros_like(z), np.full_like(z, 1e-200), np.zeros_like(z), np.zeros_like(z)
    for m in range(top, -1, -1):
        k, odd = divmod(m, 2)
        if odd == momenta and k < len(moments):
            total += (moments[k] * here) ** (2 if squares else 1)
        size += (2 if m else 1) * here * here
        if m:
            above, here = here, 2 * m / z * here - above
        large = np.abs(here) > _LARGE
        if large.any():
            shrink = np.where(large, 1 / np.abs(here), 1.0)
            above, here = above * shrink, here * shrink
            total, size = total * (shrink ** 2 if squares else shrink), size * shrink ** 2
    sums: Floats = np.sqrt(total / size) if squares else total / np.sqrt(size)
    return sums


def _terms(x: float, momenta: bool, most: float) -> tuple[int, float]:
    """The fewest terms beyond which all others add at most `most` of the norms, by Kapteyn's bound of J_m [DLMF
    10.14.8], and what they add at most."""
    k = np.arange(64 + int(0.5 * x + 20 * x ** (1 / 3)))
    m = np.maximum(2.0 * k + momenta, 1e-300)
    z = np.clip(x / m, 1e-300, 1)
    root = np.sqrt(1 - z * z)
    parts = (2 * k + 1 if momenta else np.ones_like(m)) * np.exp(m * (np.log(z) + root - np.log1p(root)))
    tails = np.cumsum(parts[::-1])[::-1] + parts[-1]
    terms = int(np.argmax(tails <= most))
    return terms, float(tails[terms])
