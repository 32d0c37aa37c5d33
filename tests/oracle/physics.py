"""The physics of packings by plain formulas, for ./check: slow, dense, and written from docs/physics.md alone.

A packing is read as docs/file-format.md says. Everything is a dense matrix of numpy's long doubles, whose products
are made of exact products of slices, and eigenvectors of LAPACK are refined once. So the oracle's own rounding is
far below that of the program, whose stated errors can be checked as they are.
"""
import math
from functools import cached_property

import h5py
import numpy as np
from scipy.integrate import quad

LONG = np.longdouble
EPS = 2.0**-52


def slices(a, axis):
    """Three parts of 21 bits each, with one scale for each row or column: products of parts are exact."""
    size = np.max(np.abs(a), axis=axis, keepdims=True, initial=0)
    scale = np.exp2(np.ceil(np.log2(np.where(size > 0, size, 1)))).astype(LONG)
    parts = []
    for level in (1, 2, 3):
        step = scale * LONG(2) ** (-21 * level)
        head = np.rint(a / step) * step
        parts.append(head.astype(float))
        a = a - head
    return parts


def product(a, b):
    """The matrix product to about 62 bits, by products of double precision."""
    left, right = slices(a, 1), slices(b, 0)
    order = sorted(((i, j) for i in range(3) for j in range(3) if i + j < 4), reverse=True, key=sum)
    return sum((left[i] @ right[j]).astype(LONG) for i, j in order)


def eigen(a):
    """Eigenvalues and vectors of a symmetric matrix: LAPACK's, and one step of Ogita and Aishima."""
    n = len(a)
    values, x = np.linalg.eigh(a.astype(float))
    x = x.astype(LONG)
    r = np.eye(n, dtype=LONG) - product(x.T, x)
    s = product(x.T, product(a, x))
    values = np.diag(s) / (1 - np.diag(r))
    off, rest = (np.linalg.norm(m.astype(float)) for m in (s - np.diag(values), r))
    spread = off + np.abs(values).max() * rest
    gap = values[None, :] - values[:, None]
    near = np.abs(gap) <= 2 * spread
    step = np.where(near, r / 2, (s + values[None, :] * r) / np.where(near, 1, gap))
    x = x + product(x, step)
    # A cluster of values is resolved by a small problem of its own.
    values = np.sum(x * product(a, x), 0) / np.sum(x * x, 0)
    order = np.argsort(values)
    return values[order], x[:, order]


def cross(n):
    """The matrix of n x v."""
    x, y, z = n
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=LONG)


class Packing:
    """The numbers of a file, padded to three dimensions."""

    def __init__(self, path):
        with h5py.File(path) as f:
            def get(name, default=None):
                return f[name][()] if name in f else default
            grains = "particles/grains/"
            x = get(grains + "position/value")[0]
            self.dim, self.count = x.shape[1], len(x)
            self.x, self.r = self.pad(x), get(grains + "radius").astype(LONG)
            self.pi = LONG("3.14159265358979323846264338327950288")
            own = grains + "inertia" in f
            self.m = get(grains + "mass").astype(LONG) if own else 4 * self.pi / 3 * self.r**3
            self.inertia = get(grains + "inertia").astype(LONG) if own else LONG(2) / 5 * self.m * self.r**2
            self.own = own
            edges = get(grains + "box/edges")
            self.cell = np.diag(edges) if edges.ndim == 1 else edges
            pairs = get("connectivity/contacts", np.zeros((0, 2), int))
            walls = get("sonopack/walls/contacts", np.zeros((0, 2), int))
            self.i, self.j = np.concatenate([pairs, walls]).T.astype(int)
            self.n = self.pad(get("sonopack/contacts/normal"))
            self.overlap = get("sonopack/contacts/overlap").astype(LONG)
            given = [get(f"sonopack/contacts/{k}_stiffness", np.zeros(len(self.i))) for k in ("normal", "tangential")]
            self.given = np.array(given).astype(LONG)
            self.fn = get("sonopack/contacts/normal_force").astype(LONG)
            self.ft = self.pad(get("sonopack/contacts/tangential_force"))
            self.p, self.mu, self.nu = (float(get("sonopack/" + k)) for k in ("pressure", "friction", "poisson"))
            self.gravity = float(get("sonopack/gravity", 0.0))
            kind = get("sonopack/cell", b"piston")
            self.kind, self.wall = kind.decode().strip("\0"), get("sonopack/wall").decode().strip("\0")
        self.up = self.dim - 1
        self.height = self.cell[-1][-1]
        self.volume = abs(np.linalg.det(self.cell))
        self.is_wall = self.j < 0
        other = np.where(self.is_wall, 0, self.r[self.j])
        self.arm = np.stack([self.r[self.i], other], 1)
        self.branch = (self.arm.sum(1) - self.overlap)[:, None] * self.n
        self.stiffness()

    @staticmethod
    def pad(a):
        out = np.zeros((len(a), 3), dtype=LONG)
        out[:, :a.shape[1]] = a
        return out

    def stiffness(self):
        """Hertz's and Mindlin's stiffnesses."""
        r1, r2 = self.arm.T
        r12 = np.where(self.is_wall, r1 / 2 if self.wall == "grain" else r1, r1 * r2 / (r1 + r2))
        e12 = np.where(self.is_wall & (self.wall == "rigid"), LONG(1), LONG(1) / 2)
        self.kn = 2 * e12 * np.sqrt(r12 * self.overlap)
        eta = (1 - LONG(self.nu)) / (1 - LONG(self.nu) / 2)
        self.kt = eta * self.kn * (self.mu > 0) * (self.dim > 1)
        kn, kt = self.given
        self.kn, self.kt = np.where(kn > 0, kn, self.kn), np.where(kn > 0, kt * (self.kt > 0), self.kt)
        self.hertz = LONG(4) / 3 * e12 * np.sqrt(r12) * self.overlap ** LONG(1.5)

    def carrying(self, threshold=1e-4):
        """Force-carrying contacts and grains that are no rattlers."""
        least = 2 if self.mu > 0 or self.dim == 1 else self.dim + (0 if self.gravity else 1)
        active, alive = self.fn > threshold * self.p, np.ones(self.count, bool)
        while True:
            ends = np.bincount(self.i[active], minlength=self.count)
            ends += np.bincount(self.j[active & ~self.is_wall], minlength=self.count)
            loose = alive & (ends < least)
            if not loose.any():
                return active, alive
            alive[loose] = False
            active &= alive[self.i] & (self.is_wall | alive[self.j])


def quadrant(a, b, r):
    """Area of the part x < a, y < b of a disk."""
    def segment(u):
        u = max(-r, min(r, u))
        return 0.5 * (u * math.sqrt(max(0, r * r - u * u)) + r * r * math.asin(u / r))
    a, b = max(-r, min(r, a)), max(-r, min(r, b))
    half = math.sqrt(max(0, r * r - b * b))
    left, right = -half, min(a, half)
    cap = segment(right) - segment(left) - abs(b) * (right - left) if right > left else 0.0
    return cap if b < 0 else 2 * (segment(a) - segment(-r)) - cap


def disk_part(lo, hi, r):
    """Area of a disk within a rectangle around its centre."""
    if r <= 0:
        return 0.0
    return (quadrant(hi[0], hi[1], r) - quadrant(lo[0], hi[1], r)
            - quadrant(hi[0], lo[1], r) + quadrant(lo[0], lo[1], r))


def sphere_part(lo, hi, r):
    """Volume of a sphere within a box around its centre."""
    a, b = max(-r, lo[2]), min(r, hi[2])
    if a >= b:
        return 0.0
    if max(lo[0], lo[1]) <= -r and min(hi[0], hi[1]) >= r:
        return math.pi * (r * r * (b - a) - (b**3 - a**3) / 3)
    reach = [math.sqrt(r * r - s * s) for s in (*lo[:2], *hi[:2]) if abs(s) < r]
    corners = [math.sqrt(max(0, r * r - s * s - t * t)) for s in (lo[0], hi[0]) for t in (lo[1], hi[1])]
    points = sorted({a, b} | {s * z for z in reach + corners for s in (-1, 1) if a < s * z < b})
    def area(z):
        return disk_part(lo, hi, math.sqrt(max(0, r * r - z * z)))
    return sum(quad(area, u, v, epsabs=1e-14, epsrel=1e-13)[0] for u, v in zip(points, points[1:]))


class Bulk:
    """What is at least `margin` away from all walls."""

    def __init__(self, p, margin):
        self.p, big = p, 1e9
        self.lo, self.hi = [-big] * 3, [big] * 3
        walls = {"piston": [p.up], "periodic": [], "box": list(range(p.dim))}[p.kind]
        self.volume = p.volume
        for axis in walls:
            edge = p.cell[axis][axis]
            self.lo[axis], self.hi[axis] = margin, edge - margin
            self.volume *= max(0, 1 - 2 * margin / edge)

    def inside(self, x):
        x = x.astype(float)
        return np.all((x >= self.lo) & (x <= self.hi), 1)

    def fractions(self, keep, heavy=False):
        """Area and volume fractions of grains; heavy: the density, of masses that are given."""
        p, area, volume = self.p, 0.0, 0.0
        weights = p.m / (4 * p.pi / 3 * p.r**3) if heavy else np.ones(p.count)
        for x, r, weight in zip(p.x[keep].astype(float), p.r[keep].astype(float), weights[keep]):
            lo, hi = np.array(self.lo) - x, np.array(self.hi) - x
            area += disk_part(lo, hi, r)
            volume += sphere_part(lo, hi, r) * weight
        return (area / self.volume if p.dim == 2 else math.nan), volume / self.volume


def statics(p, margin=3.0, threshold=1e-4):
    """The columns of `sonopack statics`."""
    bulk, (active, alive) = Bulk(p, margin), p.carrying(threshold)
    grains = bulk.inside(p.x)
    out = {"p": p.p}
    n, c = p.n[active], active.nonzero()[0]
    point = p.x[p.i[c]] + (p.r[p.i[c]] - p.overlap[c] / 2)[:, None] * n
    here = bulk.inside(point)
    if bulk.volume > 0 and grains.any():
        out["Phi2"], out["Phi3"] = bulk.fractions(slice(None))
        out["Phi3s"] = bulk.fractions(alive)[1]
        out["density"] = bulk.fractions(alive, True)[1]
        out["f0"] = 100 * np.mean(~alive[grains])
    if bulk.volume > 0 and (grains & alive).any():
        ends = np.bincount(p.i[c], minlength=p.count)
        ends += np.bincount(p.j[c][p.j[c] >= 0], minlength=p.count)
        out["zs"] = ends[grains & alive].mean()
    if bulk.volume > 0 and here.any():
        force = p.fn[c][here]
        mean = force.mean()
        out["N_over_p"] = mean / p.p
        out["Z2"], out["Z3"] = ((force**k).mean() / mean**k for k in (2, 3))
        vertical = n[here][:, p.up] ** 2
        out["F2"] = vertical.mean()
        if np.ptp(force) > 1e-9 * mean:  # Of equal forces, which are above the mean is rounding.
            out["F2S"] = vertical[force > mean].mean()
    out.update(stress(p, c))
    if p.mu > 0:
        out["mobilised"] = np.mean(np.linalg.norm(p.ft[c].astype(float), axis=1) >= 0.99 * p.mu * p.fn[c])
    return out


def stress(p, c):
    """The stress of the contacts c, and its ratios."""
    force = p.fn[c, None] * p.n[c] - p.ft[c]
    s = (force.T @ p.branch[c]) / p.volume
    up, sides = p.up, list(range(p.up))
    out = {}
    if sides:
        out["s1_over_s2"] = sum(s[a, a] for a in sides) / len(sides) / s[up, up]
        out["s12_over_s2"] = s[0, up] / s[up, up]
    if p.dim == 3:
        out["s32_over_s2"] = s[1, up] / s[up, up]
    names = {"s_xx": (0, 0), "s_yy": (1, 1), "s_zz": (2, 2), "s_yz": (1, 2), "s_xz": (0, 2), "s_xy": (0, 1)}
    for name, (a, b) in names.items():
        if max(a, b) < p.dim and p.kind != "piston":
            out[name] = (s[a, b] + s[b, a]) / 2
    return out


class Network:
    """Springs of the carrying contacts: matrices over the freedoms of the carrying grains."""

    def __init__(self, p, threshold=1e-4, prestress=False, tangential="constant", sliding_free=False):
        self.p, self.prestress = p, prestress
        active, self.alive = p.carrying(threshold)
        self.c, self.grains = active.nonzero()[0], self.alive.nonzero()[0]
        rough = p.mu > 0 and p.dim > 1
        self.axes = {1: [0], 2: [0, 1, 5] if rough else [0, 1], 3: list(range(6 if rough else 3))}[p.dim]
        self.size = len(self.axes) * len(self.grains)
        self.number = np.full(p.count, -1)
        self.number[self.grains] = np.arange(len(self.grains))
        mass = np.stack([p.m[self.grains]] * 3 + [p.inertia[self.grains]] * 3, 1)
        self.mass = mass[:, self.axes].reshape(-1)
        self.kn, self.kt, self.normal = p.kn[self.c], p.kt[self.c], p.n[self.c]
        self.soften(tangential, sliding_free)
        self.wall = p.j[self.c]
        self.motions()
        self.forces()

    @cached_property
    def k(self):
        return self.assemble(self.law)

    def soften(self, tangential, sliding_free):
        """Tangential stiffness by loading history, or none where a contact slides."""
        p, c = self.p, self.c
        if p.mu == 0:
            return
        q = np.sqrt(np.sum(p.ft[c]**2, 1)) / (LONG(p.mu) * p.fn[c])
        left = np.maximum(1 - q, 0)
        if tangential != "constant":
            self.kt = self.kt * np.cbrt(left if tangential == "loading" else left / 2)
        if sliding_free:
            self.kt = np.where(q >= LONG(0.99), 0, self.kt)

    def motions(self):
        """For each contact u_j - u_i and the two angles, as maps from the freedoms."""
        p, f = self.p, len(self.axes)
        motion = np.zeros((len(self.c), 9, self.size), dtype=LONG)
        for row, c in enumerate(self.c):
            for side, grain in enumerate((p.i[c], p.j[c])):
                if grain < 0:
                    continue
                for local, axis in enumerate(self.axes):
                    column = f * self.number[grain] + local
                    if axis < 3:
                        motion[row, axis, column] += 1 if side else -1
                    else:
                        motion[row, 3 * side + axis, column] += 1
        self.motion = motion

    def forces(self):
        """Maps from a contact's motion to its slip, and to d(force on i) and d(n x Ft)."""
        p, eye = self.p, np.eye(3, dtype=LONG)
        self.slip = np.zeros((len(self.c), 3, 9), dtype=LONG)
        self.law = np.zeros((len(self.c), 6, 9), dtype=LONG)
        for row, c in enumerate(self.c):
            n, (r1, r2), nx = p.n[c], p.arm[c], cross(p.n[c])
            across = eye - np.outer(n, n)
            slip = np.concatenate([across, r1 * nx, r2 * nx], 1)
            push = np.concatenate([np.outer(n, n), np.zeros((3, 6))], 1)
            self.slip[row] = slip
            self.law[row, :3] = self.kn[row] * push + self.kt[row] * slip
            self.law[row, 3:] = self.kt[row] * (nx @ slip)
            if self.prestress:
                self.law[row] += self.static(c, across, nx)

    def static(self, c, across, nx):
        """What the forces at rest add; a wall's normal does not rotate."""
        p, n, ft, out = self.p, self.p.n[c], self.p.ft[c], np.zeros((6, 9), dtype=LONG)
        if not p.is_wall[c]:
            r = np.sqrt(p.branch[c] @ p.branch[c])
            out[:3, :3] = -p.fn[c] / r * across - np.outer(n, ft @ across) / r
            out[3:, :3] = -cross(ft) @ across / r
        if p.dim == 3:
            for turn in (slice(3, 6), slice(6, 9)):
                out[:3, turn] = np.outer(nx @ ft, n) / 2
                out[3:, turn] = -np.outer(ft, n) / 2
        return out

    def response(self, law, motion):
        """Changes of force and moment at the contacts for motions of the freedoms."""
        return np.stack([product(a, b) for a, b in zip(law, motion)])

    def assemble(self, law):
        """Stiffness for a law of the contacts: minus the derivative of the forces on the freedoms."""
        answer = self.response(law, self.motion)
        return self.gather(answer)

    def gather(self, answer):
        arm = self.p.arm[self.c]
        levers = np.concatenate([self.motion[:, :3], -arm[:, :1, None] * self.motion[:, 3:6]
                                 - arm[:, 1:, None] * self.motion[:, 6:]], 1)
        torque = levers[:, 3:].reshape(-1, self.size)
        force = levers[:, :3].reshape(-1, self.size)
        m = answer.shape[-1]
        return product(force.T, answer[:, :3].reshape(-1, m)) + product(torque.T, answer[:, 3:].reshape(-1, m))

    def stretch(self):
        """Stretches of normal springs, and slips, for each freedom."""
        normal = np.einsum("ca,can->cn", self.normal, self.motion[:, :3])
        return normal, self.response(self.slip, self.motion)

    def matrix(self):
        root = np.sqrt(self.mass)
        a = self.k / root[:, None] / root[None, :]
        return (a + a.T) / 2 if self.symmetric() else a

    def symmetric(self):
        return not self.prestress or self.p.mu == 0

    def modes(self):
        return eigen(self.matrix())

    def dashpots(self, kind, normal, tangential):
        """The matrix C of dashpots, and their coefficients: a fraction of critical (kind zeta), the same at every contact
        (gamma), or in proportion to the reduced mass (mass)."""
        p, c = self.p, self.c
        m2 = np.where(p.is_wall[c], 1, p.m[p.j[c]])
        meff = np.where(p.is_wall[c], p.m[p.i[c]], p.m[p.i[c]] * m2 / (p.m[p.i[c]] + m2))
        cn, ct = (value * {"zeta": 2 * np.sqrt(meff * k), "gamma": 1 + 0 * k, "mass": meff}[kind]
                  for value, k in ((LONG(normal), self.kn), (LONG(tangential), self.kt)))
        push = self.normal[:, :, None] * np.pad(self.normal, ((0, 0), (0, 6)))[:, None, :]
        law = np.zeros_like(self.law)
        law[:, :3] = cn[:, None, None] * push + ct[:, None, None] * self.slip
        law[:, 3:] = ct[:, None, None] * np.stack([cross(n) @ s for n, s in zip(self.normal, self.slip)])
        return self.assemble(law), cn, law

    def wall_vector(self, wall, weight):
        """Sum of weight n_c over the contacts with a wall, on the grains that touch it."""
        out = np.zeros((len(self.grains), len(self.axes)), dtype=LONG)
        for row in (self.wall == wall).nonzero()[0]:
            out[self.number[self.p.i[self.c[row]]], :self.p.dim] += weight[row] * self.normal[row, :self.p.dim]
        return out.reshape(-1)

    def source(self, kind="impulse", plane=None, axis=None):
        """Mass-weighted start of the motion; a plane pushes the grains of a layer."""
        if plane is None:
            start = -self.wall_vector(-1, self.kn)
        else:
            start = np.zeros((len(self.grains), len(self.axes)), dtype=LONG)
            y = self.p.x[self.grains, self.p.up]
            near = (y >= plane - 0.5) & (y < plane + 0.5)
            if self.p.kind == "periodic":
                gap = np.mod(y - plane + 0.5, self.height())
                near = gap < 1
            start[near, self.p.up if axis is None else axis] = 1
            start = start.reshape(-1)
        root = np.sqrt(self.mass)
        return start / root if kind == "impulse" else start * root

    def height(self):
        return self.p.height

    def crossings(self, plane):
        """How often each contact crosses a plane upwards from i to j (in a cell: the plane and its images)."""
        p, c = self.p, self.c
        start = p.x[p.i[c], p.up]
        if p.kind == "periodic":
            end = start + p.branch[c][:, p.up]
            return (np.floor((end - plane) / p.height) - np.floor((start - plane) / p.height)).astype(float)
        end = np.where(p.is_wall[c], np.where(p.j[c] == -1, -1e9, np.where(p.j[c] == -2, 1e9, start)),
                       p.x[p.j[c], p.up])
        return (end >= plane) * 1.0 - (start >= plane) * 1.0

    def detector(self, plane=None, axis=None, law=None):
        """Mass-weighted detector: the top wall, or the momentum flux through a plane."""
        if plane is None:
            out = self.wall_vector(-2, self.kn)
        else:
            times = self.crossings(plane)
            answer = self.response((self.law if law is None else law)[:, :3], self.motion)
            out = -np.einsum("c,cn->n", times, answer[:, self.p.up if axis is None else axis])
        return out / np.sqrt(self.mass)

    def strains(self):
        """Displacement gradients in Voigt's order."""
        pairs = {1: [(0, 0)], 2: [(0, 0), (1, 1), (0, 1)],
                 3: [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]}[self.p.dim]
        out = np.zeros((len(pairs), 3, 3), dtype=LONG)
        for e, (a, b) in zip(out, pairs):
            e[a, b] = 1
        return out

    def moduli(self):
        """The matrix of moduli, and each contact's motion in each strain."""
        p = self.p
        affine = np.zeros((len(self.c), 9, len(self.strains())), dtype=LONG)
        for s, e in enumerate(self.strains()):
            affine[:, :3, s] = p.branch[self.c] @ e.T
        load = -self.gather(self.response(self.law, affine))
        u = self.solve(load)
        total = affine + np.stack([product(b, u) for b in self.motion])
        force = self.response(self.law, total)[:, :3]
        return np.einsum("cas,cat->st", affine[:, :3], force) / p.volume, total

    def solve(self, load):
        """K u = load without the motions that stretch no spring, refined in long doubles."""
        if self.symmetric():
            values, x = np.linalg.eigh((self.k.astype(float) + self.k.astype(float).T) / 2)
            keep = np.abs(values) > 1e-12 * values.max()
            inverse = (x[:, keep] / values[keep]) @ x[:, keep].T
        else:
            # Spheres with two contacts have spins without stiffness; they are held.
            plain = self.law.copy()
            for row, c in enumerate(self.c):
                plain[row] -= self.static(c, np.eye(3, dtype=LONG) - np.outer(self.normal[row], self.normal[row]),
                                          cross(self.normal[row]))
            free = self.assemble(plain).astype(float)
            x, values, _ = np.linalg.svd(free)
            x = x[:, values > 1e-12 * values.max()]
            inverse = x @ np.linalg.inv(x.T @ self.k.astype(float) @ x) @ x.T
        inverse, u = inverse.astype(LONG), 0
        for _ in range(4):
            u = u + product(inverse, load - (product(self.k, u) if np.ndim(u) else 0))
        return u
