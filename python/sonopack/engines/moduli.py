"""moduli --engine petsc: the moduli of a packing from imposed strains (docs/physics.md, Elastic moduli) on many
ranks."""
from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from .._command import Failed, number, usage
from .._core import Floats
from .._native import ffi, lib
from .._table import Table
from . import network
from .network import BOTTOM, EPSILON, TOP, EngineParser, Network

_SHIFT = 1e-9  # of omega_max^2: makes the factor regular where grains spin freely or all move as a whole
_STEPS = 60  # of conjugate gradients with that factor, which take two or three as a rule
_RESIDUAL, _MOST = 1e-13, 1e-8  # of the load: where the solver stops, and above which there are no moduli
_STRAINS = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))}  # u_a = x_b
_NAMED = {2: "C11 C12 C22 C33", 3: "C11 C12 C13 C22 C23 C33 C44 C55 C66"}
_WHOLE = {2: "C13 C23", 3: "C14 C15 C16 C24 C25 C26 C34 C35 C36 C45 C46 C56"}


def parser() -> EngineParser:
    p = EngineParser("moduli", "petsc", "network")
    p.add_argument("--margin", metavar="D", type=number(0, 1e6), default=3)
    for name in ("--probe", "--strain"):
        p.add_argument(name)
    return p


def run(a: argparse.Namespace) -> int:
    """Computes on all ranks."""
    return network.run(a, _compute)


def _compute(a: argparse.Namespace, net: Network) -> Table:
    if a.probe or a.strain:
        raise usage(f"--engine petsc: has the moduli of small homogeneous strains alone, not --{'probe' if a.probe else 'strain'}")
    if net.cell == "ring":
        raise Failed(f"{net.path}: the walls are rings: an imposed strain needs flat walls or a periodic cell")
    c, error = _stiffness(net)
    up = net.dim - 1
    if not c[up, up] > error[up, up]:
        raise Failed(f"{net.path}: the network is floppy: its modulus along the up axis, {c[up, up]:.2g}, is 0 within an "
                     f"error of {error[up, up]:.2g}")
    np.fill_diagonal(c, np.where(np.diag(c) <= np.diag(error), 0, np.diag(c)))
    density = _density(net, a.margin)
    shear = c[2, 2] if net.dim == 2 else 0.5 * (c[3, 3] + c[4, 4])
    values: dict[str, Any] = {"file": [net.path], "p": net.pressure}
    values |= {name: c[int(name[1]) - 1, int(name[2]) - 1] for name in _NAMED[net.dim].split()}
    units = dict.fromkeys(["p", *list(values)[2:]], "E*") | dict.fromkeys(["c_l", "c_t"], "sqrt(E* / rho)")
    values |= {"c_l": np.sqrt(c[up, up] / density), "c_t": np.sqrt(shear / density)}
    if net.cell != "piston":
        whole = {name: c[int(name[1]) - 1, int(name[2]) - 1] for name in _WHOLE[net.dim].split()}
        whole |= _isotropic(net.dim, c, error)
        units |= {name: "E*" for name in whole if not name.startswith("anisotropy")}
        values |= whole
    slip = error[2, 2] if net.dim == 2 else 0.5 * (error[3, 3] + error[4, 4])
    errors = {"C_err": np.nanmax(error), "c_l_err": _speed_error(values["c_l"], error[up, up], density, len(net.x)),
              "c_t_err": _speed_error(values["c_t"], slip, density, len(net.x))}
    units |= {name: units[name.removesuffix("_err")] if name != "C_err" else "E*" for name in errors}
    values |= errors
    told = {"solver": f"petsc, {net.comm.size} ranks"}
    return Table.from_columns({name: np.atleast_1d(value) for name, value in values.items()}, units, told)


def _speed_error(speed: float, error: float, density: float, grains: int) -> float:
    """As speed_error of src/cli/cmd_moduli.c."""
    steep = error / density / speed if speed else np.inf
    return float(np.fmin(steep, np.sqrt(error / density)) + 4 * grains * EPSILON * speed)


def _density(net: Network, margin: float) -> float:
    """Of the grains that carry, in the bulk, as sp_packing_density."""
    p = ffi.new("sp_packing *", {"dim": net.dim, "n": len(net.x), "box": [*net.box, 1.0][:3]})
    p.cell = ("piston", "periodic", "box").index(net.cell)
    x = np.zeros((len(net.x), 3))
    x[:, :net.dim] = net.x
    arrays = [np.ascontiguousarray(values, float) for values in (x, net.radius, net.mass[:, 0])]
    p.x, p.r, p.mass = (ffi.from_buffer("double[]", array) for array in arrays)
    return float(lib.sp_packing_density_of(p, ffi.NULL, margin))


def _stiffness(net: Network) -> tuple[Floats, Floats]:
    """C_ab = g_a . (g_b + S e_b)/V with the affine stretches g and A e_b = -S^T g_b, and bounds of its errors; nan where
    walls without friction do not take a strain. The error is e_a . (S^T g_b + A e_b), with a factor of 2 for that of
    e_a, and rounding."""
    ksp, count = _solver(net), len(_STRAINS[net.dim])
    sizes, (e, rest) = net.sizes(net.S), net.A.createVecs()
    affine, stretch, reach = (net.S.createVecLeft() for _ in range(3))
    noise = EPSILON * (16 + np.sqrt(net.S.getSize()[0] / net.rows))
    g, h, moved, left, most, far = ([] for _ in range(6))
    for along, of in _STRAINS[net.dim]:
        affine.setArray(net.root * net.axis[:, along] * net.n[:, of] * net.length)
        load = net.omega * affine.norm()  # in a lattice the rest below is rounding
        net.S.multTranspose(affine, rest)
        rest.scale(-1)
        ksp.setTolerances(rtol=_RESIDUAL, atol=2 * EPSILON * load, max_it=_STEPS)
        ksp.solve(rest, e)
        if not ksp.getResidualNorm() <= _MOST * max(rest.norm(), 1e-6 * load):
            raise Failed(f"{net.path}: the forces of an imposed strain are not balanced after {_STEPS} steps: "
                         "`sonopack moduli' alone may tell why")
        net.S.mult(e, stretch)
        moved.append(np.abs(e.getArray()))
        e.abs()
        sizes.mult(e, reach)
        stretch.axpy(1, affine)
        net.S.multTranspose(stretch, rest)
        g.append(affine.getArray().copy())
        h.append(stretch.getArray().copy())
        left.append(np.abs(rest.getArray()))
        far.append(2 * reach.getArray() + np.abs(g[-1]))
        most.append(reach.getArray() + np.abs(g[-1]))
    parts = [np.array(one) @ np.array(two).T for one, two in ((g, h), (moved, left), (far, most))]
    c, off, rounding = net.total(np.concatenate(parts).ravel()).reshape(3, count, count) / np.prod(net.box)
    error = 2 * off + noise * rounding
    taken = np.array([along == of or of != net.dim - 1 or _grips(net) for along, of in _STRAINS[net.dim]])
    undefined = ~(taken[:, None] & taken)
    c[undefined] = error[undefined] = np.nan
    return c, error


def _solver(net: Network) -> Any:
    """Conjugate gradients with the Cholesky factor of A, slightly shifted, by MUMPS."""
    shifted = net.A.copy()
    shifted.shift(_SHIFT * net.omega ** 2)
    for option in (net.petsc.Mat.Option.SYMMETRIC, net.petsc.Mat.Option.SPD):
        shifted.setOption(option, True)
    ksp = net.petsc.KSP().create(net.comm)
    ksp.setType("cg")
    if still := net.rigid():  # A does not see them, and rounding would
        net.A.setNullSpace(net.petsc.NullSpace().create(vectors=still, comm=net.comm))
    ksp.setOperators(net.A, shifted)
    ksp.setNormType(net.petsc.KSP.NormType.UNPRECONDITIONED)
    ksp.getPC().setType("cholesky")
    ksp.getPC().setFactorSolverType("mumps")
    return ksp


def _grips(net: Network) -> bool:
    """Whether walls can shear the packing: with friction, and without walls the cell does."""
    if net.cell != "piston":
        return True
    across = np.arange(len(net.j)) % net.rows != 0
    return bool(net.total([np.sum(net.root[across & (net.j == wall)]) for wall in (BOTTOM, TOP)]).all())


def _isotropic(dim: int, c: Floats, error: Floats) -> dict[str, float]:
    """Voigt's averages of the tensor, and what is left of it."""
    def averages(t: Floats, sign: float) -> tuple[float, float]:
        own, shears = np.trace(t[:dim, :dim]), np.trace(t[dim:, dim:])
        cross = np.sum(t[:dim, :dim]) - own
        shear = (own + sign * cross + 4 * shears) / 8 if dim == 2 else (own + sign * cross / 2 + 3 * shears) / 15
        return float((own + cross) / dim ** 2), float(shear)
    (bulk, shear), (bulk_error, shear_error) = averages(c, -1), averages(error, 1)
    times = np.where(np.arange(len(c)) < dim, 1.0, 2.0)  # each shear stands for two components
    weight, plain = np.outer(times, times), np.diag(2 * shear / times)
    plain[:dim, :dim] += bulk - 2 * shear / dim
    whole = np.sum(weight * c ** 2)
    return {"K": bulk, "K_err": bulk_error, "G": shear, "G_err": shear_error,
            "anisotropy": float(np.sqrt(np.sum(weight * (c - plain) ** 2) / whole)),
            "anisotropy_err": float(2 * np.sqrt(np.sum(weight * error ** 2) / whole))}
