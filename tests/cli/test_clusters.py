"""clusters against motions that numpy finds from all singular values: with and without friction, walls and periods, in the
plane and in space; what the table says; what is refused.

usage: test_clusters.py COMMAND SOURCE_DIR
"""
import itertools
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's threads wait for each other where others are at work

import h5py  # noqa: E402
import numpy as np  # noqa: E402

from command import N200, main, pack, refused, table  # noqa: E402

SMALL = 1e-7  # of singular values and motions; those of packings that can be judged keep away from it


class Dense:
    """Bodies (grains with a contact that sticks, walls) and points, with all motions that keep the bars."""

    def __init__(self, path, contacts, limit):
        with h5py.File(path) as file:
            radius, ends = file["/particles/grains/radius"][:], file["/connectivity/contacts"][:]
            if "/sonopack/walls" in file:
                ends = np.concatenate([ends, file["/sonopack/walls/contacts"][:]])
            get = lambda name: file["/sonopack/contacts/" + name][:][contacts]
            self.ends, normal, overlap, fn, ft = ends[contacts], get("normal"), get("overlap"), get("normal_force"), get("tangential_force")
            friction = float(np.asarray(file["/sonopack/friction"][()]))
        self.dim, self.turns = normal.shape[1], {2: 1, 3: 3}[normal.shape[1]] if friction > 0 else 0
        names = sorted({int(end) for pair in self.ends for end in pair})
        self.sticks = np.array([friction > 0 and np.linalg.norm(t) < limit * friction * f for t, f in zip(ft, fn)])
        self.body = {name: name < 0 for name in names}
        for i, j in self.ends[self.sticks]:
            self.body[i] = self.body[j] = True
        self.place, size = {}, 0
        for name in names:
            self.place[name], size = size, size + self.dim + (self.turns if name >= 0 else 0)
        self.arm, rows, self.owner = [], [], []
        for k, (i, j) in enumerate(self.ends):
            radii = np.array([radius[i], radius[j] if j >= 0 else 0])
            length = radii.sum() - overlap[k]
            shorter = length / radii.sum() if j >= 0 else 1
            self.arm.append(length * normal[k])
            d = np.zeros((self.dim, size))
            for end, sign, arm in ((i, -1, radii[0]), (j, 1, -radii[1])):
                at = self.place[end]
                d[:, at:at + self.dim] += sign * np.eye(self.dim)
                if end >= 0 and self.turns:
                    d[:, at + self.dim:at + self.dim + self.turns] += sign * self.lever(arm * shorter * normal[k])
            axes = np.linalg.svd(normal[k][None])[2][:self.dim if self.sticks[k] else 1]
            rows.append(axes @ d)
            self.owner += [k] * len(axes)
        u, s, v = np.linalg.svd(np.vstack(rows))
        self.rank, self.bars = int((s > SMALL * s[0]).sum()), len(self.owner)
        self.motions, self.floppy = v[self.rank:].T, size - self.rank
        stress = np.abs(u[:, self.rank:]).max(axis=1, initial=0)
        self.redundant = np.array([max(stress[np.equal(self.owner, k)]) > SMALL for k in range(len(self.ends))])

    def lever(self, arm):
        """omega x arm as a matrix."""
        if self.dim == 2:
            return np.array([[-arm[1]], [arm[0]]])
        return np.array([[0, arm[2], -arm[1]], [-arm[2], 0, arm[0]], [arm[1], -arm[0], 0]])

    def speed(self, name):
        return self.motions[self.place[name]:][:self.dim]

    def spin(self, name):
        if name < 0 or not self.turns:
            return np.zeros((1 if self.dim == 2 else 3, self.motions.shape[1]))
        return self.motions[self.place[name] + self.dim:][:self.turns]

    def carrier(self, k):
        """The body that the contact moves with, its own name for two points in the plane, or None."""
        (i, j), arm = map(int, self.ends[k]), self.arm[k]
        if not self.body[i] and not self.body[j]:
            return ("line", k) if self.dim == 2 else None
        if not self.body[i]:
            i, j, arm = j, i, -arm
        off = [self.speed(j) - self.speed(i) - self.lever(arm) @ self.spin(i)]
        off += [self.spin(j) - self.spin(i)] if self.body[j] else []
        return ("body", i) if all(np.abs(o).max(initial=0) < SMALL for o in off) else None

    def turning(self, by):
        if by[0] == "body":
            return self.spin(by[1])
        i, j = self.ends[by[1]]
        arm, along = self.arm[by[1]], self.speed(j) - self.speed(i)
        return ((arm[0] * along[1] - arm[1] * along[0]) / (arm @ arm))[None]

    def clusters(self):
        """A set of contacts for each cluster."""
        by = [self.carrier(k) for k in range(len(self.ends))]
        group = {name: {name} for name in {*by, *(("body", name) for name in self.body)} if name}

        def join(a, b):
            if group[a] is not group[b]:
                group[a] |= group[b]
                for name in group[b]:
                    group[name] = group[a]

        for k, (i, j) in enumerate(self.ends):
            if by[k] and self.body[i] and self.body[j]:
                join(("body", i), ("body", j))
        for point in (name for name in self.body if not self.body[name]):
            at = [k for k in range(len(by)) if by[k] and point in self.ends[k]]
            for a, b in itertools.combinations(at, 2):
                if np.abs(self.turning(by[a]) - self.turning(by[b])).max(initial=0) < SMALL:
                    join(by[a], by[b])
        held = [not self.turns or all(self.body[end] for end in ends) for ends in self.ends]  # what spins moves with none
        return parts({k: id(group[by[k]]) for k in range(len(by)) if by[k] and held[k]})


    def bodies(self):
        """Of smooth spheres in space: from each two contacts of a grain that are not in one line, with the rigid motion that
        is the best for their three grains, all contacts whose ends follow it. {contacts: grains}"""
        at, found = {}, {}
        for k, (i, j) in enumerate(self.ends):
            if j >= 0:
                at.setdefault(int(i), []).append((k, int(j), self.arm[k]))
                at.setdefault(int(j), []).append((k, int(i), -self.arm[k]))
        for i, contacts in at.items():
            for (one, p, a), (two, q, b) in itertools.combinations(contacts, 2):
                rows = np.vstack([np.hstack([np.eye(3), self.lever(x)]) for x in (np.zeros(3), a, b)])  # v + omega x arm
                seen = np.vstack([self.speed(grain) for grain in (i, p, q)])
                if any(one in body and two in body for body in found) or np.linalg.norm(np.cross(a, b)) < 0.01 * np.linalg.norm(a) * np.linalg.norm(b):
                    continue
                best = np.linalg.lstsq(rows, seen, rcond=None)[0]
                if np.abs(rows @ best - seen).max(initial=0) > SMALL:
                    continue
                place, queue, body = {i: np.zeros(3)}, [i], set()
                for grain in queue:
                    for k, other, arm in at[grain]:
                        follows = best[:3] + self.lever(place[grain] + arm) @ best[3:] - self.speed(other)
                        if np.abs(follows).max(initial=0) < SMALL:
                            body.add(k)
                            if other not in place:
                                place[other] = place[grain] + arm
                                queue.append(other)
                found[frozenset(body)] = len(place)
        alone = {k for ends in at.values() for k, _, _ in ends} - {k for body in found for k in body}
        return found | {frozenset([k]): 2 for k in alone}


def parts(number):
    found = {}
    for k, name in number.items():
        found.setdefault(name, set()).add(k)
    return {frozenset(one) for one in found.values()}


def motions():
    several = spun = 0
    for name, limit, least, keys in (("plane", 0.55, 0.3, dict(grains=90, width=8, pressure=1e-4)),
                                     ("low", 0.5, 1e-4, dict(grains=80, cell="periodic", pressure=1e-6, friction=0.1)),
                                     ("box", 0.55, 0.1, dict(grains=80, cell="box", width=8, friction=0.2)),
                                     ("smooth", 0.99, 0.2, dict(grains=80, width=8, pressure=1e-6, friction=0)),
                                     ("space", 0.9, 1e-4, dict(dimension=3, grains=90, width=4.8, pressure=1e-5))):
        path = pack(f"{name}.h5", seed=3, **keys)
        own = table("clusters", path, "--method=motions", f"--sliding-at={limit}", f"--threshold={least}")
        dense = Dense(path, own["contact"].astype(int), limit)
        assert np.array_equal(own["bars"], np.where(dense.sticks, dense.dim, 1)), name
        assert parts({k: c for k, c in enumerate(own["cluster"]) if c >= 0}) == dense.clusters(), name
        assert np.array_equal(own["redundant"], dense.redundant), name
        assert own.note("floppy_motions") == dense.floppy - dense.dim, name
        assert own.note("redundant_bars") == dense.bars - dense.rank, name
        several += own.note("clusters") > 1
        spun += own.note("free_spins") > 0
    assert several > 1 and spun > 2  # the packings are not all one cluster


def smooth_spheres():
    """Bodies, hinges, redundant contacts and Maxwell's count of smooth spheres against all singular values; the triangle
    and the tetrahedra of a chain of tetrahedra that share edges turn about these."""
    hinges = several = 0
    for name, least, words, keys in (("ss", 1e-4, [], dict(pressure=1e-2)), ("sn", 0.2, ["--no-walls"], dict(pressure=1e-2)),
                                     ("sp", 1e-4, ["--no-walls"], dict(pressure=1e-4)), ("sw", 0.15, [], dict(pressure=1e-4)),
                                     ("sc", 0.1, [], dict(pressure=1e-4, cell="periodic", grains=130))):
        shape = {} if "cell" in keys else dict(width=4.8, grains=80)
        path = pack(f"{name}.h5", seed=2, dimension=3, friction=0, protocol="quick", **shape, **keys)
        own = table("clusters", path, f"--threshold={least}", *words)
        kept = own["bars"] > 0
        dense = Dense(path, own["contact"][kept].astype(int), 1)
        walls = len({int(j) for j in own["j"][kept] if j < 0})
        size = 3 * (len(table("clusters", path, f"--threshold={least}", "--grains", *words)) + walls)
        assert np.array_equal(own["redundant"][kept], dense.redundant), name
        assert own.note("redundant_bars") == dense.bars - dense.rank and own.note("bars") == dense.bars, name
        assert own.note("floppy_motions") == dense.floppy + (size - len(dense.motions)) - 3, name  # and grains without bars
        assert own.note("floppy_motions") - own.note("redundant_bars") == size - dense.bars - 3, name  # Maxwell, Calladine
        assert own.note("free_spins") == 0 and np.all(own["cluster"][own["j"] < 0] == -1), name
        bodies = dense.bodies()
        assert own.note("clusters") == len(bodies) and own.note("largest") == max(bodies.values(), default=0), name
        number = own["cluster"][kept]
        for k in np.flatnonzero(own["j"][kept] >= 0):  # the largest body of a contact, of those that hold all that has its number
            with_it = [(grains, len(body), body) for body, grains in bodies.items() if k in body]
            hinges += len(with_it) > 1
            best = max(with_it)[:2]
            assert any(one[:2] == best and set(np.flatnonzero(number == number[k])) <= one[2] for one in with_it), (name, k)
        several += len(bodies) > 20
    assert hinges > 20 and several > 2, (hinges, several)


def tables():
    """Both methods agree on a packing without special places but for the turn that the period forbids; rows of grains."""
    game, real = table("clusters", N200), table("clusters", N200, "--method=motions")
    assert game.names == ["contact", "i", "j", "bars", "cluster", "redundant"] and game.notes["method"] == "game"
    assert np.array_equal(game["cluster"], real["cluster"]) and game.note("redundant_bars") == real.note("redundant_bars") - 1
    assert game.note("largest_fraction") == 1 and game.notes["spans"] == "y (cluster 0)" and game.notes["wraps"] == "x (cluster 0)"
    loose = table("clusters", N200, "--sliding-at=0.3", "--no-walls")
    assert set(loose["bars"][loose["j"] < 0]) == {0} and loose.note("floppy_motions") > 0 and loose.notes["spans"] == "none"
    grains = table("clusters", N200, "--grains", "--sliding-at=0.3", "--no-walls")
    assert grains.names == ["grain", "x", "y", "radius", "cluster"]
    own = {g: max(c, -1) for g, c in zip(grains["grain"], grains["cluster"])}
    for i, j, cluster in zip(loose["i"], loose["j"], loose["cluster"]):
        assert cluster < 0 or own[i] == own[j] == cluster
    assert np.sum(grains["cluster"] == 0) == loose.note("largest")
    pack("chain.h5", kind="chain", grains=10)
    refused("chain", "clusters", "chain.h5", status=1)
    refused("motions", "clusters", "space.h5", "--method=game", status=1)
    refused("--method", "clusters", N200, "--method=guess")
    refused("--sliding-at", "clusters", N200, "--sliding-at=-1")


main(motions, smooth_spheres, tables)
