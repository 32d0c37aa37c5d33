"""Zero modes of packings: the numbers in the tables against ranks that numpy finds from the contacts alone, and the same
numbers whatever is asked for.

usage: test_zero_modes.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from common import names_all

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
KEYS = ("rattler_modes", "free_spins", "rigid_motions", "mechanisms")


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stderr)
    return done


def table(*args):
    """Comments, and columns as arrays."""
    lines = run(*args).stdout.splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    body = np.array(rows[1:], float).reshape(-1, len(rows[0]))
    return comments, {name: body[:, c] for c, name in enumerate(rows[0])}


class Contacts:
    """Grains and contacts that carry force, without the program's network."""

    def __init__(self, path):
        with h5py.File(path) as f:
            self.dim = int(f["sonopack/dimension"][()])
            friction = float(f["sonopack/friction"][()]) > 0 and self.dim > 1
            pressure = float(f["sonopack/pressure"][()])
            pairs = f["connectivity/contacts"][()]
            if "sonopack/walls" in f:
                pairs = np.concatenate([pairs, f["sonopack/walls/contacts"][()]])
            normal = f["sonopack/contacts/normal"][()][:, :self.dim]
            carrying = f["sonopack/contacts/normal_force"][()] > 1e-4 * pressure
            self.radius, self.x = f["particles/grains/radius"][()], f["particles/grains/position/value"][0][:, :self.dim]
            self.box = f["particles/grains/box/edges"][()][:self.dim - 1]
        n, needed = len(self.radius), 2 if friction or self.dim == 1 else self.dim + 1
        while True:  # grains with too few contacts do not hold others
            count = np.bincount(pairs[carrying].ravel()[pairs[carrying].ravel() >= 0], minlength=n)
            held = count >= needed
            kept = carrying & held[pairs[:, 0]] & ((pairs[:, 1] < 0) | held[pairs[:, 1]])
            if np.array_equal(kept, carrying):
                break
            carrying = kept
        self.alive = np.flatnonzero(held)
        self.rattlers = n - len(self.alive)
        self.turns = (0, 0, 1, 3)[self.dim] if friction else 0
        self.dof = self.dim + self.turns
        self.row = {g: k for k, g in enumerate(self.alive)}
        self.pairs, self.normal = pairs[carrying], normal[carrying]
        self.b = np.zeros((0, 0)) if len(self.alive) == 0 else np.array([r for k in range(len(self.pairs)) for r in self.stretches(k, friction)])

    def stretches(self, k, friction):
        """Rows of relative displacement at the contact; rotations as displacements of the surface."""
        (i, j), n = self.pairs[k], self.normal[k]
        tangents = np.linalg.svd(n[None])[2][1:] if friction else []
        for axis in [n, *tangents]:
            b = np.zeros(self.dof * len(self.alive))
            for end, sign in ((i, -1), (j, 1)):
                if end < 0:
                    continue
                at = self.dof * self.row[end]
                b[at:at + self.dim] = sign * axis
                if self.turns == 1:
                    b[at + 2] = -(n[0] * axis[1] - n[1] * axis[0])
                elif self.turns == 3:
                    b[at + 3:at + 6] = -np.cross(n, axis)
            yield b

    def rigid_motions(self):
        """Motions of parts that hang together: translations, and rotations of those that do not wrap around."""
        place, part, wraps, next_part = {}, {}, {}, 0
        near = {g: [] for g in self.alive}
        for (i, j), n in zip(self.pairs, self.normal):
            if j >= 0:
                near[i].append((j, n))
                near[j].append((i, -n))
        for start in self.alive:
            if start in part:
                continue
            place[start], part[start], wraps[next_part], queue = np.zeros(self.dim), next_part, False, [start]
            for g in queue:
                for other, n in near[g]:
                    step = self.x[other] - self.x[g]
                    step[:-1] -= self.box * np.round((step[:-1] - (self.radius[g] + self.radius[other]) * n[:-1])
                                                     / self.box)
                    there = place[g] + step
                    if other not in part:
                        place[other], part[other] = there, next_part
                        queue.append(other)
                    elif np.abs(place[other] - there).max() > 1e-6:
                        wraps[next_part] = True
            next_part += 1
        for p in range(next_part):
            grains = [g for g in self.alive if part[g] == p]
            if len(grains) < 2:
                continue
            for axis in range(self.dim):
                u = np.zeros((len(self.alive), self.dof))
                u[[self.row[g] for g in grains], axis] = 1
                yield u.ravel()
            for axis in np.eye(3)[2:] if self.dim == 2 else np.eye(3) if self.dim == 3 else []:
                if wraps[p]:
                    break
                u = np.zeros((len(self.alive), self.dof))
                for g in grains:
                    u[self.row[g], :self.dim] = np.cross(axis, [*place[g], 0, 0][:3])[:self.dim]
                    if self.turns:
                        u[self.row[g], self.dim:] = self.radius[g] * (axis[2:] if self.turns == 1 else axis)
                yield u.ravel()

    def numbers(self):
        dofs = self.dof * len(self.alive)
        values = np.zeros(dofs)
        _, some, turned = np.linalg.svd(self.b)
        values[:len(some)] = some
        null = turned[values < 1e-10]  # rows span the null space
        assert not np.any((values >= 1e-10) & (values < 1e-5)), "no clear rank"
        spins = []
        for k in range(len(self.alive)):
            own = self.b[:, self.dof * k:self.dof * (k + 1)]
            _, s, v = np.linalg.svd(own[np.any(own != 0, axis=1)])
            for alone in v[np.concatenate([s, np.zeros(self.dof - len(s))]) < 1e-10]:
                spins.append(np.zeros(dofs))
                spins[-1][self.dof * k:self.dof * (k + 1)] = alone
        motions = np.array([*self.rigid_motions()]).reshape(-1, dofs)
        free = np.zeros((0, dofs))
        if len(motions):  # combinations that stretch nothing
            motions = np.linalg.svd(motions, full_matrices=False)[2]
            _, s, v = np.linalg.svd(self.b @ motions.T)
            free = v[np.concatenate([s, np.zeros(len(v) - len(s))]) < 1e-10] @ motions
        both = np.array([*spins, *free]).reshape(-1, dofs)
        together = np.linalg.matrix_rank(both, tol=1e-7) if len(both) else 0
        return {"rattler_modes": self.rattlers * self.dof, "free_spins": len(spins),
                "rigid_motions": together - len(spins), "mechanisms": len(null) - together}


def check(path, label):
    expected = Contacts(path).numbers()
    total = sum(expected.values())
    comments, everything = table("modes", path)
    omega = everything["omega"]
    found = {key: int(comments[key]) for key in KEYS}
    assert found == expected, (label, found, expected)
    assert np.count_nonzero(omega == 0) == total and np.all(omega[total:] > float(comments["zero_below"]))
    left = len(omega) - total
    few = min(left, 7)
    low, high = 0.4 * omega[-1], 0.45 * omega[-1]
    kinds = [("modes", path, "--frequencies-only"), ("modes", path, "--lowest", few),
             ("modes", path, "--lowest", few, "--frequencies-only"), ("modes", path, "--lowest", few, "--zero"),
             ("modes", path, "--band", f"{low}:{high}", "--frequencies-only"), ("modes", path, "--band", f"0:{low}"),
             ("spectrum", "dos", path, "--method", "exact"), ("spectrum", "dos", path, "--method", "count", "--bins", 3),
             ("spectrum", "participation", path)]
    for words in kinds:
        comments, part = table(*words)
        assert {key: int(comments[key]) for key in KEYS} == expected, (label, words)
        assert int(comments["zero_modes"]) == total
        if "--lowest" in words:
            first = 0 if "--zero" in words else total
            assert np.array_equal(part["n"], np.arange(first, total + few)), (label, words)
            assert np.all(np.abs(part["omega"] - omega[first:total + few]) <= 1e-9 * omega[-1])
            assert np.count_nonzero(part["omega"] == 0) == total - first
        elif words[0] == "modes" and "--band" in words:
            inside = np.flatnonzero((omega >= (0 if f"0:{low}" in words else low))
                                    & (omega <= (low if f"0:{low}" in words else high)))
            assert np.array_equal(part["n"], inside), (label, words)
    comments, _ = table("spectrum", "dos", path, "--method", "kpm", "--bins", 3, "--vectors", 2)
    assert all(int(comments[key]) == expected[key] for key in KEYS[:3]) and "zero_modes" not in comments
    # the sum over all that vibrate is the whole signal, and a partial sum has an error that holds
    window = ("--until", 20, "--points", 40)
    _, whole = table("signal", path, *window)
    for modes in (left, max(1, left // 10)):
        comments, some = table("signal", path, "--method", "sparse", "--modes", modes, *window)
        off, size = np.abs(some["F"] - whole["F"]).max(), np.abs(whole["F"]).max()
        assert int(comments["modes"]) == modes and off <= float(comments["error"]) + 1e-9 * size + 1e-12, (label, modes, off)
        assert modes < left or float(comments["error"]) < 1e-9, (label, comments["error"])
    # as many as there are, and one more
    run("modes", path, "--lowest", left, "--frequencies-only")
    assert names_all(run("modes", path, "--lowest", left + 1, status=2).stderr, f"{left + 1} {left}"), label
    print(label, expected, f"and {left} others")
    return expected


def lame(path, share, rng):
    """Takes the force from a share of the contacts: they carry no more."""
    with h5py.File(path, "r+") as f:
        force = f["sonopack/contacts/normal_force"]
        force[:] = np.where(rng.uniform(size=force.shape) < share, 0, force[:])


def packings(folder, rng):
    seen = dict.fromkeys(KEYS, 0)
    scenes = [("2D", 2, 0.5, 90, 12), ("2D without friction", 2, 0, 110, 10), ("2D, large", 2, 0.5, 170, 13),
              ("3D", 3, 0.5, 70, 4), ("3D, large", 3, 0.5, 100, 4.5), ("3D without friction", 3, 0, 120, 4.5)]
    for label, dim, friction, grains, width in scenes:
        for share in (0, 0.1, 0.5):
            path = folder / f"{label}-{share}.h5"
            run("pack", SOURCE / "packings" / ("spheres.cfg" if dim == 3 else "single.cfg"), "-q", "-o", path, "--set",
                f"packing.friction={friction}", "--set", f"packing.grains={grains}", "--set", f"packing.width={width}")
            lame(path, share, rng)
            if not {-1, -2} <= set(Contacts(path).pairs[:, 1]):
                print(label, share, "does not carry from wall to wall")
                continue
            for key, number in check(path, f"{label}, {share} of the contacts gone:").items():
                seen[key] += number
    assert all(seen.values()), seen


def lattices(folder):
    for name, settings in (("chain", ("packing.kind=\"chain\"", "packing.dimension=1", "packing.grains=30")),
                           ("triangular", ("packing.kind=\"triangular\"", "packing.grains=100", "packing.width=10")),
                           ("smooth triangular", ("packing.kind=\"triangular\"", "packing.grains=240",
                                                  "packing.width=12", "packing.friction=0"))):
        path = folder / f"{name}.h5"
        run("pack", SOURCE / "packings" / "single.cfg", "-q", "-o", path, *(w for s in settings for w in ("--set", s)))
        check(path, f"{name}:")


with tempfile.TemporaryDirectory(prefix="sonopack-zero-") as name:
    SEED = 7
    print("seed", SEED)
    packings(pathlib.Path(name), np.random.default_rng(SEED))
    lattices(pathlib.Path(name))
