"""The network of a packing over the ranks of a job: each reads a slice of the contacts, all the grains."""
from __future__ import annotations

import argparse
import glob
import importlib
import re
import signal
import sys
import time
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np

from .. import __version__
from .._command import STOPS, Failed, Parser, may_write, usage, write_table
from .._core import Floats, Integers, SonopackError, text_of
from .._native import ffi, lib
from .._records import Material
from .._scene import Scene
from .._table import Table

EPSILON = float(np.finfo(float).eps)
BOTTOM, TOP, RIGHT = -1, -2, -4
SOURCES = ("impulse", "velocity", "displacement")
_FOLDERS = ("/usr/lib/slepcdir/slepc*/*-real/lib/python3/dist-packages",
            "/usr/lib/petscdir/petsc*/*-real/lib/python3/dist-packages")
_PARTS = ("normal", "overlap", "normal_force", "normal_stiffness", "tangential_stiffness")
_PATIENCE = 3.0  # seconds in which a launcher ends a job of which a rank has failed
_TURNS = 24  # power steps of the bound of all frequencies


# ---- commands -------------------------------------------------------------------------------------------------------

class EngineParser(Parser):
    """Options of a command with --engine, the common ones included."""

    def __init__(self, name: str, engine: str, groups: str) -> None:
        super().__init__(name, groups=groups, springs=True, usage=f"%(prog)s FILE.h5 --engine {engine} [OPTION...]")
        self.engine = engine
        self.add_argument("file", metavar="FILE.h5", nargs="+")
        self.add_argument("--engine", choices=(engine,))

    def error(self, message: str) -> NoReturn:
        _wait(library("PETSc"))
        raise usage(f"--engine {self.engine}: {message.removeprefix('argument ')}")


def library(name: str) -> Any:
    """The module PETSc of petsc4py, or SLEPc of slepc4py. MPI begins with the first."""
    for pattern in _FOLDERS:
        sys.path.extend(path for path in sorted(glob.glob(pattern)) if path not in sys.path)
    package = importlib.import_module(f"{name.lower()}4py")
    package.init(["-no_signal_handler"])
    return importlib.import_module(f"{name.lower()}4py.{name}")


def _wait(petsc: Any) -> None:
    """Before a fault is told: what all ranks have seen rank 0 says, and the job ends; else another says it later."""
    if petsc.COMM_WORLD.rank:
        time.sleep(_PATIENCE)


Compute = Callable[[argparse.Namespace, "Network"], Table]


def run(a: argparse.Namespace, compute: Compute) -> int:
    """Computes a table on all ranks, which rank 0 writes."""
    for number in STOPS:  # at once, in whatever library: the table appears whole
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)
    if a.engine == "slepc":
        library("SLEPc")
    petsc = library("PETSc")
    petsc.Sys.popErrorHandler()  # its errors are exceptions, of one line
    try:
        table, material = _table(a, petsc, compute)
        if petsc.COMM_WORLD.rank == 0:
            write_table(a, table, material)
            sys.stdout.flush()
    except SonopackError:
        _wait(petsc)
        raise
    except petsc.Error as fault:
        _wait(petsc)
        raise Failed(f"PETSc: {str(fault).strip().splitlines()[-1].strip()}") from None
    petsc._finalize()
    return 0


def _table(a: argparse.Namespace, petsc: Any, compute: Compute) -> tuple[Table, Material | None]:
    scene = Scene.read(None, a.words.keys(a))
    a.struct = scene.resolved()  # parts of a struct do not keep it
    options = a.struct.network
    if len(a.file) > 1:
        raise usage(f"--engine {a.engine}: takes one packing, there are {len(a.file)}")
    a.file = a.file[0]
    if options.prestress or options.sliding_free or options.tangential:
        raise usage(f"--engine {a.engine}: of the network only network.threshold may be given (no --prestress)")
    if a.threads > 1:
        raise usage(f"--engine {a.engine}: has ranks instead of --threads: mpirun -n {a.threads} sonopack ...")
    if a.output:
        may_write(a, a.output, (".tsv", ".csv", ".json"))
    petsc.COMM_WORLD.barrier()  # no rank looks for -o once rank 0 has written it
    net = Network(petsc, a.file, options.threshold)
    if a.units == "si" and not (a.material or net.material):
        raise usage("--units si: needs a material, and the packing has none: give it by --material")
    table = compute(a, net)
    if material := a.material or net.material:
        text = ffi.new("char[]", int(lib.SP_MATERIAL_TEXT))
        lib.sp_material_text(ffi.new("sp_material *", vars(material)), text)
        table.add_comment(f"material = {text_of(text)}")
    table.add_comment(f"sonopack {__version__}")
    return table, net.material


# ---- the network ----------------------------------------------------------------------------------------------------

class Network:
    """The scaled stretches S = k^1/2 B M^-1/2 of the springs: a matrix with a row for each direction of a contact, on
    the rank that has read the contact, and A = M^-1/2 K M^-1/2 = S^T S. A frequency squared is |S e|^2.

    x, radius, mass: of the grains that carry, on all ranks; ends: their numbers of contacts
    n, axis, length, i, j, root: of the rows of S on this rank: unit normal, direction of the stretch, distance of the
    centres, first grain, second one or a wall (< 0), k^1/2
    """

    def __init__(self, petsc: Any, path: str, threshold: float) -> None:
        h5py = importlib.import_module("h5py")
        self.petsc, self.comm, self.path = petsc, petsc.COMM_WORLD, path
        try:
            with h5py.File(path, "r") as file:
                self._read(file, threshold)
        except FileNotFoundError:
            raise Failed(f"cannot read {path}: No such file or directory") from None
        except (KeyError, IndexError, TypeError, OSError, ValueError) as fault:
            raise Failed(f"{path}: must be a packing as HDF5: {str(fault).splitlines()[0]}") from None
        self.A = self.S.transposeMatMult(self.S)
        self.A.setOption(petsc.Mat.Option.SYMMETRIC, True)
        self.omega = self._bound()

    def _read(self, file: Any, threshold: float) -> None:
        own, grains = file["sonopack"], file["particles/grains"]

        def number(name: str) -> float:
            return float(own[name][()]) if name in own else 0.0
        self.dim, self.pressure = int(own["dimension"][()]), float(own["pressure"][()])
        self.cell = own["cell"][()].decode() if "cell" in own else "piston"
        edges = np.array(grains["box/edges"], float)
        self.box: Floats = edges if edges.ndim == 1 else np.diag(edges)
        self.material = Material(*map(number, (f"material/{key}" for key in (
            "young", "poisson", "density", "diameter")))) if "material" in own else None
        if self.dim == 1:
            raise Failed(f"{self.path}: is a chain: an engine takes packings in two or three dimensions")
        self.turns = 0 if number("friction") == 0 else 1 if self.dim == 2 else 3
        self.dof = self.dim + self.turns
        radius = np.array(grains["radius"])
        i, j, parts = self._slice(file)
        keep = parts["normal_force"] > threshold * self.pressure
        there = self._carrying(i, j, keep, len(radius),
                               2 if self.turns else self.dim + (0 if number("gravity") > 0 else 1))
        self.rattlers, row = int((~there).sum()), np.cumsum(there) - 1
        if not there.any():
            raise Failed(f"{self.path}: no grain carries: all {len(radius)} are rattlers above {threshold:g} p")
        mass = np.array(grains["mass"]) if "inertia" in grains else np.pi * (4 / 3) * radius ** 3
        inertia = np.array(grains["inertia"]) if "inertia" in grains else 0.4 * mass * radius ** 2
        self.x: Floats = np.array(grains["position/value"][0])[there]
        self.radius: Floats = radius[there]
        self.mass: Floats = np.column_stack([mass] * self.dim + [inertia] * self.turns)[there]
        i, j, parts = i[keep], j[keep], {name: values[keep] for name, values in parts.items()}
        arms = radius[i], np.where(j < 0, 0.0, radius[j])
        kn, kt = stiffnesses(parts, *arms, j, own["wall"][()].decode(), number("poisson"))
        if self.total([np.sum(~(kn > 0))])[0]:
            raise Failed(f"{self.path}: a contact that carries a force has no overlap")
        self._springs(row[i], np.where(j < 0, j, row[j]), parts["normal"], arms, kn, kt)
        self.length: Floats = np.repeat(arms[0] + arms[1] - parts["overlap"], self.rows)

    def _slice(self, file: Any) -> tuple[Integers, Integers, dict[str, Any]]:
        """This rank's part of the contacts. Those between grains come first."""
        pairs, own = file["connectivity/contacts"], file["sonopack/contacts"]
        walls = file["sonopack/walls/contacts"] if "sonopack/walls/contacts" in file else np.empty((0, 2), int)
        between, count = len(pairs), len(pairs) + len(walls)
        first, end = (count * k // self.comm.size for k in (self.comm.rank, self.comm.rank + 1))
        both = np.concatenate([pairs[min(first, between):min(end, between)],
                               walls[max(first - between, 0):max(end - between, 0)]]).astype(np.int64)
        return both[:, 0], both[:, 1], {name: own[name][first:end] for name in _PARTS if name in own}

    def _carrying(self, i: Integers, j: Integers, keep: Any, count: int, needed: int) -> Any:
        """Which grains carry; contacts of others leave `keep`. Grains with too few are removed until none is left."""
        there, loose = np.ones(count, bool), np.ones(1, bool)
        while loose.any():
            ends = self.total(np.bincount(np.concatenate([i[keep], j[keep & (j >= 0)]]), minlength=count))
            loose = there & (ends < needed)
            there &= ~loose
            keep &= there[i] & ((j < 0) | there[j])
        self.ends: Floats = ends[there]
        return there

    def _springs(self, i: Integers, j: Integers, n: Floats, arms: tuple[Floats, Floats], kn: Floats, kt: Floats) \
            -> None:
        """The rows of S on this rank: of each contact one along the normal, and with friction those across it."""
        axes = [n, *(across(n) if self.turns else ())]
        self.rows, dof = len(axes), self.dof
        self.n, self.i, self.j = (np.repeat(of, self.rows, axis=0) for of in (n, i, j))
        self.axis: Floats = np.stack(axes, 1).reshape(-1, self.dim)
        self.root: Floats = np.sqrt(np.column_stack([kn] + [kt] * (self.rows - 1))).ravel()
        turn = turning(self.n, self.axis)[:, :self.turns]
        arm_i, arm_j = (np.repeat(arm, self.rows)[:, None] for arm in arms)
        values = np.hstack([-self.axis, -arm_i * turn, self.axis, -arm_j * turn]) * self.root[:, None]
        columns = np.hstack([dof * end[:, None] + np.arange(dof) for end in (self.i, self.j)])
        wide = np.hstack([np.ones((len(self.j), dof), bool), np.repeat(self.j[:, None] >= 0, dof, axis=1)])
        starts = np.concatenate([[0], np.cumsum(wide.sum(axis=1))]).astype(np.int32)
        grains, columns = len(self.mass), columns[wide].astype(np.int32)
        self.first, self.end = (dof * (grains * k // self.comm.size) for k in (self.comm.rank, self.comm.rank + 1))
        self.S = self.petsc.Mat().createAIJ(
            ((len(self.j), None), (self.end - self.first, dof * grains)),
            csr=(starts, columns, values[wide] / np.sqrt(self.mass.ravel()[columns])), comm=self.comm)

    def _bound(self) -> float:
        """A bound of all frequencies by the absolute values of A (Collatz, Wielandt), as `sonopack' has it."""
        sizes = self.sizes(self.A)
        v, w = sizes.createVecs()
        v.set(1)
        for _ in range(_TURNS):
            sizes.mult(v, w)
            w.shift(1e-3 * w.max()[1])  # no entry comes near 0
            w.scale(1 / w.norm())
            v, w = w, v
        sizes.mult(v, w)
        w.pointwiseDivide(w, v)
        sizes.destroy()
        return float(np.sqrt(w.max()[1]) * (1 + 1e-12))

    def sizes(self, matrix: Any) -> Any:
        """The absolute values of a matrix."""
        starts, columns, values = matrix.getValuesCSR()
        return self.petsc.Mat().createAIJ(matrix.getSizes(), csr=(starts, columns, np.abs(values)), comm=self.comm)

    # ---- vectors over the ranks -------------------------------------------------------------------------------------

    def total(self, values: Any) -> Floats:
        """The sum over the ranks of an array that each has."""
        vector = self.petsc.Vec().createMPI(len(values), comm=self.comm)
        vector.setValues(np.arange(len(values), dtype=np.int32), np.asarray(values, float), addv=True)
        vector.assemble()
        scatter, here = self.petsc.Scatter.toAll(vector)
        scatter.scatter(vector, here)
        out: Floats = here.getArray().copy()
        for thing in (vector, scatter, here):
            thing.destroy()
        return out

    def local(self, values: Floats) -> Floats:
        """This rank's part of an array over the degrees of freedom."""
        return values.ravel()[self.first:self.end]

    def rigid(self) -> list[Any]:
        """The motions of the packing as a whole that stretch nothing, of norm 1."""
        found = []
        for axis in range(self.dim):
            moved = np.zeros_like(self.mass)
            moved[:, axis] = np.sqrt(self.mass[:, axis])
            e, stretch = self.A.createVecRight(), self.S.createVecLeft()
            e.setArray(self.local(moved))
            e.normalize()
            self.S.mult(e, stretch)
            if stretch.norm() <= 1e-9 * self.omega:
                found.append(e)
        return found

    def loads(self, stretch: Floats) -> Any:
        """S^T g: forces on the grains, over the roots of their masses."""
        rows, out = self.S.createVecLeft(), self.S.createVecRight()
        rows.setArray(stretch)
        self.S.multTranspose(rows, out)
        return out

    def source(self, kind: str, plane: float | None = None) -> Any:
        """The mass-weighted momenta, or displacements, of a pulse of the bottom wall, or of a layer of grains; None
        without a bottom wall."""
        if plane is None:
            touched = (self.j == BOTTOM) & (np.arange(len(self.j)) % self.rows == 0)
            out = self.loads(np.where(touched, self.root, 0)) if self.total([touched.sum()])[0] else None
        else:
            out, moved, up = self.A.createVecRight(), np.zeros_like(self.mass), self.dim - 1
            above = self.x[:, up] - plane
            above -= self.box[up] * np.floor((above + 0.5) / self.box[up]) if self.cell == "periodic" else 0
            moved[(above >= -0.5) & (above < 0.5), up] = 1
            if not moved.any():
                raise Failed(f"no grain that carries is within 0.5 d of the plane at {plane:g}")
            out.setArray(self.local(moved / np.sqrt(self.mass)))
        if out is not None and kind != "impulse":
            out.setArray(out.getArray() * self.local(self.mass))
        return out

    def detector(self, plane: float | None = None) -> Any:
        """The force on the top wall, or through a plane, as a row over the mass-weighted displacements; None without a
        top wall."""
        if plane is None:
            touched = (self.j == TOP) & (np.arange(len(self.j)) % self.rows == 0)
            return self.loads(np.where(touched, -self.root, 0)) if self.total([touched.sum()])[0] else None
        up, height = self.dim - 1, self.box[-1]
        y, rise, other = self.x[self.i, up], self.n[:, up] * self.length, self.x[np.maximum(self.j, 0), up]

        if self.cell == "periodic":  # whole periods count the planes
            low, to = (np.ceil((of - plane) / height) for of in (y, other))
            to += np.rint((y + rise - other) / height)
        else:
            low, to = y > plane, np.where(self.j >= 0, other > plane, np.where(self.j < TOP, y > plane, self.j == TOP))
        way = np.sign(0.0 + to - low)
        if not self.total([np.abs(way).sum()])[0]:
            raise Failed(f"no carrying contact crosses the plane at {plane:g}")
        return self.loads(-way * self.root * self.axis[:, up])


def stiffnesses(parts: dict[str, Any], ri: Floats, rj: Floats, j: Integers, wall: str, nu: float) \
        -> tuple[Floats, Floats]:
    """Of Hertz and Mindlin (docs/physics.md, The contact), or those of the file."""
    curvature = 1 / ri + 1 / np.where(j >= 0, rj, ri if wall == "grain" else np.inf)
    kn = np.where((j < 0) & (wall == "rigid"), 2.0, 1.0) * np.sqrt(np.maximum(parts["overlap"], 0) / curvature)
    kt = kn * (1 - nu) / (1 - nu / 2)
    if "normal_stiffness" in parts:
        given = parts["normal_stiffness"] > 0
        kn, kt = np.where(given, parts["normal_stiffness"], kn), np.where(given, parts["tangential_stiffness"], kt)
    return kn, kt


def across(n: Floats) -> list[Floats]:
    """One or two unit vectors across each normal."""
    if n.shape[1] == 2:
        return [np.stack([-n[:, 1], n[:, 0]], 1)]
    one = np.cross(n, np.eye(3)[np.abs(n).argmin(axis=1)])
    one /= np.linalg.norm(one, axis=1)[:, None]
    return [one, np.cross(n, one)]


def turning(n: Floats, along: Floats) -> Floats:
    """n x along: how a turn about each axis moves the surface of a grain at a contact, over its radius."""
    turn: Floats = np.cross(n, along)
    return turn if n.shape[1] == 3 else turn[:, None]


def plane_of(places: list[str], wall: str, net: Network, name: str) -> float | None:
    """The height of plane:Y; None for the whole wall."""
    text = ", ".join(places) or wall
    match = re.fullmatch(rf"(?:{wall}|plane:([-+.\deE]+))(?::normal)?|normal", text)
    try:
        height = float(match[1]) if match and match[1] else None
    except ValueError:
        match = None
    if not match:
        raise usage(f"--{name} {text}: must be {wall} or plane:Y, along the normal, and one, with --engine petsc")
    if height is None and net.cell == "periodic":
        raise Failed(f"the cell is periodic and has no {wall} wall: --{name} must be plane:Y, a plane at the height Y")
    if height is not None and not 0 <= height < net.box[-1]:
        raise usage(f"--{name} plane:{height:g}: must be at or above 0 and below the height {net.box[-1]:.6g}")
    across = np.where(net.j >= TOP, net.dim - 1, np.where(net.j >= RIGHT, 0, 1))
    level = np.abs(np.take_along_axis(net.n, across[:, None], 1)[:, 0]) >= 1 - 1e-14
    if height is not None and net.total([np.sum((net.j < 0) & ~level)])[0]:
        raise Failed(f"{net.path}: a plane needs walls along the axes of the box, and one is inclined")
    return height
