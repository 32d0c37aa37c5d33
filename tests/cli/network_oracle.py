"""The network of a reference packing, built from its file in the plainest way, contact by contact, and solved dense by
numpy and scipy: what the command's answers are held against."""
import functools

import numpy as np
import scipy.linalg


@functools.lru_cache
def network(path, prestress=False):
    """One for all tests of a program that ask for it."""
    return Network(path, prestress)


class Network:
    """Springs of a reference packing in the plainest way."""

    def __init__(self, path, prestress=False, threshold=1e-4):
        lines = open(path).read().splitlines()
        head = lines[1].split()
        head = dict(zip(head[::2], head[1::2]))
        n, p = int(head["N"]), float(head["p"])
        self.width, self.height = float(head["Lx"]), float(head["Ly"])
        grains = np.array([line.split() for line in lines[2:2 + n]], dtype=float)
        contacts = [line.split() for line in lines[2 + n:] if line.strip()]
        contacts = [(int(w[0]), int(w[1]), *map(float, w[2:])) for w in contacts]
        radius = grains[:, 2]
        carrying = [c for c in contacts if c[5] > threshold * p]
        while True:
            count = np.zeros(n, int)
            for c in carrying:
                count[c[0]] += 1
                if c[1] >= 0:
                    count[c[1]] += 1
            kept = [c for c in carrying if count[c[0]] >= 2 and (c[1] < 0 or count[c[1]] >= 2)]
            if len(kept) == len(carrying):
                break
            carrying = kept
        alive = np.flatnonzero(count >= 2)
        self.rattlers = n - len(alive)
        row = {g: k for k, g in enumerate(alive)}
        size = 3 * len(alive)
        mass = 4 / 3 * np.pi * radius[alive] ** 3
        self.mass = np.column_stack([mass, mass, 0.4 * mass * radius[alive] ** 2]).ravel()
        self.b, self.k, self.affine = [], [], []
        self.alive, self.centre = alive, grains[alive, :2]
        self.c, self.walls, self.ends = [], [], []  # dashpots at critical damping; bumps of the walls; grains of a row
        self.source, self.detector = np.zeros(size), np.zeros(size)
        self.tilts = []  # tangential forces at rest, as the normal turns towards t: -ft/r n (t . (u_j - u_i))
        for i, j, nx, ny, overlap, fn, ft in carrying:
            arm = radius[j] if j >= 0 else 0.0
            length = radius[i] + arm - overlap
            if j >= 0:  # E12 = 1/2
                kn = np.sqrt(radius[i] * radius[j] / (radius[i] + radius[j]) * overlap)
            else:
                kn = 2 * np.sqrt(radius[i] * overlap)
            rows = [(np.array([nx, ny]), kn, False), (np.array([-ny, nx]), kn, True)]  # nu = 0: k_t = k_n
            if prestress and j >= 0:
                rows.append((np.array([-ny, nx]), -fn / length, False))
                normal, across = np.zeros(size), np.zeros(size)
                for end, sign in ((i, -1), (j, 1)):
                    normal[3 * row[end]:3 * row[end] + 2] += sign * np.array([nx, ny])
                    across[3 * row[end]:3 * row[end] + 2] += sign * np.array([-ny, nx])
                self.tilts.append((-ft / length, normal, across))
            for axis, k, turns in rows:
                b = np.zeros(size)
                b[3 * row[i]:3 * row[i] + 2] = -axis
                if turns:
                    b[3 * row[i] + 2] = -radius[i]
                if j >= 0:
                    b[3 * row[j]:3 * row[j] + 2] = axis
                    if turns:
                        b[3 * row[j] + 2] = -arm
                self.b.append(b)
                self.k.append(k)
                reduced = mass[row[i]] if j < 0 else mass[row[i]] * mass[row[j]] / (mass[row[i]] + mass[row[j]])
                self.c.append(2 * np.sqrt(reduced * k) if k > 0 else 0)
                self.walls.append(axis if j < 0 else np.zeros(2))
                self.ends.append((row[i], row[j] if j >= 0 else j))
                # relative displacement of the ends under strain xx, yy and shear u_x = y
                self.affine.append([length * nx * axis[0], length * ny * axis[1], length * ny * axis[0]])
            if j == -1:
                self.source[3 * row[i] + 1] += kn
            elif j == -2:
                self.detector[3 * row[i] + 1] += kn
        self.b, self.k, self.affine = np.array(self.b), np.array(self.k), np.array(self.affine)
        self.c, self.walls, self.ends = np.array(self.c), np.array(self.walls), np.array(self.ends)
        self.matrix = self.b.T @ (self.k[:, None] * self.b)
        self.turned = self.matrix.copy()  # what is not symmetric
        for tilt, normal, across in self.tilts:
            self.turned += tilt * np.outer(normal, across)

    @functools.cached_property
    def modes(self):
        root = np.sqrt(self.mass)
        return scipy.linalg.eigh(self.matrix / np.outer(root, root))

    @property
    def squares(self):
        return self.modes[0]

    @property
    def vectors(self):
        return self.modes[1]

    def frequencies(self):
        """Rayleigh quotients as sums of squares: soft modes keep their digits."""
        u = self.vectors / np.sqrt(self.mass)[:, None]
        return np.sqrt(self.k @ (self.b @ u) ** 2)

    @functools.cached_property
    def turned_modes(self):
        return scipy.linalg.eig(self.turned / self.mass[:, None])

    def moduli(self):
        relaxed = np.linalg.solve(self.matrix, -self.b.T @ (self.k[:, None] * self.affine))
        stretch = self.b @ relaxed + self.affine
        return self.affine.T @ (self.k[:, None] * stretch) / (self.width * self.height)

    def wall(self, j, axis, chosen=lambda grain: True, stiffness=None):
        """Force on a wall (-1 bottom, -2 top) along axis (0 shear, 1 normal) as a row over the displacements."""
        k = self.k if stiffness is None else stiffness
        out = np.zeros(len(self.mass))
        for q in np.flatnonzero(self.ends[:, 1] == j):
            if chosen(self.ends[q, 0]):
                out -= k[q] * self.walls[q, axis] * self.b[q]
        return out

    def part(self, low, high):
        x = self.centre[:, 0] % self.width
        return lambda grain: low <= x[grain] < high

    def plane(self, height, axis, stiffness=None):
        """Force of what lies below a plane on what lies above, by the momentum balance of all grains above it."""
        k = self.k if stiffness is None else stiffness
        above = np.zeros(len(self.mass))
        for grain in np.flatnonzero(self.centre[:, 1] > height):
            above[3 * grain + axis] = 1
        return -(above @ self.b.T * k) @ self.b + self.wall(-2, axis, stiffness=stiffness)
