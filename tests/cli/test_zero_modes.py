"""Zero modes of packings: the numbers in the tables against ranks that numpy finds from the contacts alone, and the same
numbers whatever is asked for.

usage: test_zero_modes.py COMMAND SOURCE_DIR
"""
import sys

import h5py
import numpy as np

from command import SOURCE, main, pack, refused, table

sys.path.append(str(SOURCE / "tests/oracle"))
import physics  # noqa: E402

KEYS = ("rattler_modes", "free_spins", "rigid_motions", "mechanisms")


class Contacts:
    """What tells which motions are free: relative displacements at the carrying contacts, rotations as displacements of
    the surface."""

    def __init__(self, path):
        net = physics.Network(physics.Packing(path))
        p, self.dim, self.dof, self.alive = net.p, net.p.dim, len(net.axes), net.grains
        self.turns, self.rattlers = self.dof - self.dim, p.count - len(net.grains)
        self.row = {g: k for k, g in enumerate(self.alive)}
        self.pairs, self.normal = np.stack([p.i, p.j], 1)[net.c], p.n[net.c, :self.dim].astype(float)
        self.x, self.radius = p.x[:, :self.dim].astype(float), p.r.astype(float)
        self.box = np.diag(p.cell)[:self.dim - 1]
        motion = net.motion.astype(float)
        rows = [np.einsum("ca,can->cn", self.normal, motion[:, :self.dim])]
        if self.turns:
            rows += [*np.einsum("cxb,cbn->xcn", net.slip.astype(float), motion)]
        self.b = np.concatenate(rows) / np.where(np.array(net.axes) < 3, 1, self.radius[self.alive, None]).ravel()

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
    whole = table("modes", path)
    omega = whole["omega"]
    assert {key: int(whole.notes[key]) for key in KEYS} == expected, (label, whole.notes, expected)
    assert np.count_nonzero(omega == 0) == total and np.all(omega[total:] > whole.note("zero_below"))
    left = len(omega) - total
    few, low = min(left, 7), 0.4 * float(omega[-1])
    for words, rows in (("modes {} --frequencies-only", range(len(omega))),
                        (f"modes {{}} --lowest {few}", range(total, total + few)),
                        (f"modes {{}} --lowest {few} --zero", range(total + few)),
                        (f"modes {{}} --band 0:{low!r}", np.flatnonzero(omega <= low)),
                        ("spectrum dos {} --method exact", None), ("spectrum dos {} --method count --bins 3", None),
                        ("spectrum participation {}", None)):
        part = table(*words.format(path).split())
        assert {key: int(part.notes[key]) for key in KEYS} == expected, (label, words)
        assert int(part.notes["zero_modes"]) == total
        if rows is not None:
            assert np.array_equal(part["n"], rows), (label, words)
            assert np.all(np.abs(part["omega"] - omega[rows]) <= 1e-9 * omega[-1]), (label, words)
    # the sum over all that vibrate is the whole signal, and a partial sum has an error that holds
    window = ("--until", 20, "--points", 40)
    exact = table("signal", path, *window)["F"]
    for modes in (left, max(1, left // 10)):
        some = table("signal", path, "--method", "sparse", "--modes", modes, *window)
        off, size = np.abs(some["F"] - exact).max(), np.abs(exact).max()
        assert int(some.notes["modes"]) == modes and off <= some.note("error") + 1e-9 * size + 1e-12, (label, modes, off)
        assert modes < left or some.note("error") < 1e-9, label
    refused(f"{left + 1} {left}", "modes", path, "--lowest", left + 1)
    print(label, expected, f"and {left} others")
    return expected


def lame(path, share, rng):
    """Takes the force from a share of the contacts: they carry no more."""
    with h5py.File(path, "r+") as f:
        force = f["sonopack/contacts/normal_force"]
        force[:] = np.where(rng.uniform(size=force.shape) < share, 0, force[:])


def packings():
    seed, seen = 7, dict.fromkeys(KEYS, 0)
    print("seed", seed)
    rng = np.random.default_rng(seed)
    for dim, friction, grains, width in ((2, 0.5, 170, 13), (2, 0, 110, 10), (3, 0.5, 70, 4), (3, 0, 120, 4.5)):
        for share in (0, 0.3 if friction else 0.1):
            label = f"{dim}D, friction {friction}, {share} of the contacts gone:"
            path = pack("packing.h5", SOURCE / "packings" / ("spheres.cfg" if dim == 3 else "single.cfg"), friction=friction,
                        grains=grains, width=width)
            lame(path, share, rng)
            if not {-1, -2} <= set(Contacts(path).pairs[:, 1]):
                print(label, "does not carry from wall to wall")
                continue
            for key, number in check(path, label).items():
                seen[key] += number
    assert all(seen.values()), seen


def lattices():
    for keys in ({"kind": "chain", "grains": 30}, {"kind": "triangular", "grains": 240, "width": 12, "friction": 0}):
        check(pack("lattice.h5", **keys), f"{keys}:")


main(packings, lattices)
