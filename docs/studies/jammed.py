"""Packings of frictionless grains at rest in periodic cells, by minimising their enthalpy: made for the benchmark
`jamming' by a program of its own, so that what it measures does not rest on the program's protocol.

Half of the grains are 1.4 times as large as the others, and the mean diameter is 1. Lengths and pressures are in the
units of the program: d and E*. The energy of two grains is Hertz's, 8/15 E12 sqrt(R12) overlap^(5/2) with E12 = 1/2.
"""
import dataclasses

import numpy as np
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree


@dataclasses.dataclass
class Cell:
    """Grains in a square or cubic cell of the edge `edge`, at the positions x [n, dim]."""
    x: np.ndarray
    r: np.ndarray
    edge: float

    @property
    def dim(self):
        return self.x.shape[1]

    @property
    def volume(self):
        return self.edge**self.dim

    def fraction(self):
        """Area fraction of disks, volume fraction of balls."""
        return (np.pi * self.r**2 if self.dim == 2 else 4 / 3 * np.pi * self.r**3).sum() / self.volume

    def near(self, gap):
        """Pairs closer than the gap."""
        x = self.x % self.edge
        x[x >= self.edge] = 0  # rounding
        i, j = cKDTree(x, boxsize=self.edge).query_pairs(2 * self.r.max() + gap, output_type="ndarray").T
        d = self.x[j] - self.x[i]
        d -= self.edge * np.round(d / self.edge)
        close = (d**2).sum(1) < (self.r[i] + self.r[j] + gap)**2
        order = np.lexsort((j[close], i[close]))
        return i[close][order], j[close][order]


@dataclasses.dataclass
class Contacts:
    i: np.ndarray
    j: np.ndarray
    n: np.ndarray
    length: np.ndarray
    overlap: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray

    def energy(self):
        return 0.4 * (self.force * self.overlap).sum()

    def on_grains(self, vectors, count):
        """Sum over contacts of vectors that act on j and, reversed, on i."""
        return np.stack([np.bincount(self.j, v, count) - np.bincount(self.i, v, count) for v in vectors.T], 1)


def touch(cell, pairs=None):
    i, j = cell.near(0) if pairs is None else pairs
    d = cell.x[j] - cell.x[i]
    d -= cell.edge * np.round(d / cell.edge)
    length = np.sqrt((d**2).sum(1))
    overlap = cell.r[i] + cell.r[j] - length
    on = overlap > 0
    i, j, d, length, overlap = i[on], j[on], d[on], length[on], overlap[on]
    e = 0.5 * np.sqrt(cell.r[i] * cell.r[j] / (cell.r[i] + cell.r[j]))
    return Contacts(i, j, d / length[:, None], length, overlap, 4 / 3 * e * overlap**1.5, 2 * e * np.sqrt(overlap))


def slopes(cell, c, p):
    """Gradient of the enthalpy E + p V by the positions and by the logarithm of the edge."""
    return (c.on_grains(-c.force[:, None] * c.n, len(cell.r)),
            cell.dim * p * cell.volume - (c.force * c.length).sum())


def excess(cell, c, p):
    """How far from rest: the largest force over p, and the relative error of the pressure."""
    g, s = slopes(cell, c, p)
    return max(np.sqrt((g**2).sum(1)).max() / p, abs(s) / (cell.dim * p * cell.volume))


def fall(cell, p, goal, most=100000):
    """FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201, 2006) in positions and cell, down to the goal."""
    skin = 0.3
    pairs, held = cell.near(skin), (cell.x.copy(), cell.edge)
    v, w, h, mix, since = np.zeros_like(cell.x), 0.0, 0.1, 0.1, 0
    arm = cell.edge * np.sqrt(len(cell.r))  # a change of the logarithm of the edge as a length
    for step in range(most):
        if np.abs(cell.x - held[0]).max() > 0.3 * skin or abs(cell.edge / held[1] - 1) * cell.edge > 0.1 * skin:
            pairs, held = cell.near(skin), (cell.x.copy(), cell.edge)
        c = touch(cell, pairs)
        g, s = slopes(cell, c, p)
        s /= arm
        if step % 20 == 0 and excess(cell, c, p) < goal:
            return
        power, vv, gg = -(g * v).sum() - s * w, (v**2).sum() + w * w, (g**2).sum() + s * s
        if power > 0:
            v, w, since = (1 - mix) * v - mix * g * np.sqrt(vv / gg), (1 - mix) * w - mix * s * np.sqrt(vv / gg), since + 1
            if since > 5:
                longest = 0.6 / np.sqrt(c.stiffness.max()) if len(c.i) else 1
                h, mix = min(1.1 * h, longest), 0.99 * mix
        else:
            v, w, h, mix, since = 0 * v, 0.0, 0.5 * h, 0.1, 0
        v, w = v - h * g, w - h * s
        grow = np.exp(np.clip(h * w / arm, -1e-3, 1e-3))
        cell.x = grow * (cell.x + h * v)
        cell.edge *= grow


def stiffness(cell, c):
    """The second derivative of the energy by the positions."""
    n, dim = cell.x.shape
    nn = c.n[:, :, None] * c.n[:, None, :]
    block = c.stiffness[:, None, None] * nn - (c.force / c.length)[:, None, None] * (np.eye(dim) - nn)
    ends = [(c.i, c.i, 1), (c.j, c.j, 1), (c.i, c.j, -1), (c.j, c.i, -1)]
    row = np.concatenate([np.repeat(dim * a[:, None] + np.arange(dim), dim, 1).ravel() for a, _, _ in ends])
    column = np.concatenate([np.tile(dim * b[:, None] + np.arange(dim), (1, dim)).ravel() for _, b, _ in ends])
    value = np.concatenate([sign * block.ravel() for _, _, sign in ends])
    return coo_matrix((value, (row, column)), shape=(n * dim, n * dim)).tocsc()


def newton(cell, p, goal, most=30):
    """Newton's method in positions and cell. Returns whether the goal was reached."""
    n, dim = cell.x.shape
    last = np.inf
    for _ in range(most):
        c = touch(cell)
        now = excess(cell, c, p)
        if now < goal:
            return True
        if not now < 10 * last:
            return False
        last = now
        g, s = slopes(cell, c, p)
        solve = splu(stiffness(cell, c) + 1e-10 * c.stiffness.max() * identity(n * dim, format="csc")).solve
        across = c.on_grains((c.stiffness * c.length)[:, None] * c.n, n).ravel()
        own = (c.stiffness * c.length**2 - c.force * c.length).sum() + dim**2 * p * cell.volume
        a, b = solve(g.ravel()), solve(across)
        turn = -(s - across @ a) / (own - across @ b)
        u = (-a - turn * b).reshape(n, dim)
        size = max(np.abs(u).max(), abs(turn) * cell.edge)
        part = min(1, 0.3 * c.overlap.max() / size) if size > 0 else 1
        grow = np.exp(part * turn)
        cell.x = grow * (cell.x + part * u)
        cell.edge *= grow
    return False


def factor(k, shift):
    """Factors of k + shift without exchange of rows, and how many eigenvalues of that are negative (Sylvester)."""
    lu = splu((k + shift * identity(k.shape[0])).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0,
              options={"SymmetricMode": True})
    if not np.array_equal(lu.perm_r, lu.perm_c):
        raise RuntimeError("rows were exchanged")
    return lu, (lu.U.diagonal() < 0).sum()


def downhill(cell):
    """The motion [n, dim] of the lowest stiffness, where Newton's method ended at a saddle; None at a minimum."""
    n, dim = cell.x.shape
    c = touch(cell)
    held = np.flatnonzero(np.bincount(np.concatenate([c.i, c.j]), minlength=n))
    dofs = (dim * held[:, None] + np.arange(dim)).ravel()
    k = stiffness(cell, c)[dofs][:, dofs]
    low, high = 1e-8 * c.stiffness.max(), 10 * c.stiffness.max()
    if factor(k, low)[1] == 0:
        return None
    while high > 1.01 * low:  # the lowest eigenvalue lies between -high and -low
        middle = np.sqrt(low * high)
        if factor(k, middle)[1] > 0:
            low = middle
        else:
            high = middle
    lu, v = factor(k, high)[0], np.random.default_rng(1).standard_normal(len(dofs))
    for _ in range(20):
        v = lu.solve(v)
        v /= np.abs(v).max()
    out = np.zeros(n * dim)
    out[dofs] = v
    return out.reshape(n, dim)


def settle(cell, p, goal):
    for coarse in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
        fall(cell, p, coarse)
        kept = cell.x.copy(), cell.edge
        if newton(cell, p, goal):
            return
        cell.x, cell.edge = kept
    raise RuntimeError(f"no rest at p = {p:g}")


def rest(cell, p, goal=1e-9):
    """Brings the cell to stable rest at the pressure p."""
    for _ in range(20):
        settle(cell, p, goal)
        way = downhill(cell)
        if way is None:
            return
        cell.x = cell.x + 0.3 * touch(cell).overlap.mean() * way
        fall(cell, p, 1e-5)
    raise RuntimeError(f"no stable rest at p = {p:g}")


def random_cell(dim, n, seed):
    """Random positions at the fraction 0.7 (2D) or 0.5 (3D)."""
    random = np.random.default_rng([dim, n, seed])
    r = np.where(np.arange(n) % 2 == 0, 1, 1.4) / 2.4
    cell = Cell(random.random((n, dim)), r, 1.0)
    edge = (cell.fraction() / (0.7 if dim == 2 else 0.5))**(1 / dim)
    return Cell(cell.x * edge, r, edge)


def write(cell, p, grains, contacts):
    """The two tables that `sonopack convert --grains --contacts' reads."""
    c = touch(cell)
    axes = "xyz"[:cell.dim]
    names = ["width", "height"] if cell.dim == 2 else ["width", "depth", "height"]
    keys = {"dimension": cell.dim, "cell": "periodic", **{name: f"{cell.edge:.17g}" for name in names},
            "pressure": f"{p:.17g}", "friction": 0, "poisson": 0}
    x = cell.x - cell.edge * np.floor(cell.x / cell.edge)
    with open(grains, "w") as file:
        file.write("".join(f"# {key} = {value}\n" for key, value in keys.items()))
        file.write("\t".join(["id", *axes, "radius"]) + "\n")
        for k, at in enumerate(x):
            file.write("\t".join([str(k + 1), *(f"{v:.17g}" for v in at), f"{cell.r[k]:.17g}"]) + "\n")
    with open(contacts, "w") as file:
        file.write("\t".join(["i", "j", *("n" + a for a in axes), "overlap"]) + "\n")
        for k in range(len(c.i)):
            file.write("\t".join([str(c.i[k] + 1), str(c.j[k] + 1), *(f"{v:.17g}" for v in c.n[k]),
                                  f"{c.overlap[k]:.17g}"]) + "\n")
