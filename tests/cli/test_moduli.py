"""moduli against numpy: global strain in the plane and in space, probes, mechanisms, finite strain, and what has no value.

usage: test_moduli.py COMMAND SOURCE_DIR
"""
import os
import re

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's threads wait for each other where others are at work

import h5py  # noqa: E402
import numpy as np  # noqa: E402

from cells import lattice, write_packing  # noqa: E402
from command import MATERIAL, N200, N600, Table, main, pack, refused, run, table, tried  # noqa: E402
from common import names_all  # noqa: E402
from network_oracle import network  # noqa: E402

PROBES = ["sine:1", "sine:5", "lines:1", "lines:3"]


class Space:
    """The springs of a packing in an HDF5 file in the plainest way, in two and three dimensions."""

    def __init__(self, path, threshold=1e-4):
        with h5py.File(path) as file:
            x = file["/particles/grains/position/value"][0]
            radius = file["/particles/grains/radius"][:]
            edges = file["/particles/grains/box/edges"][:]
            ends = file["/connectivity/contacts"][:]
            if "/sonopack/walls" in file:
                ends = np.concatenate([ends, file["/sonopack/walls/contacts"][:]])
            normal, overlap = file["/sonopack/contacts/normal"][:], file["/sonopack/contacts/overlap"][:]
            force = file["/sonopack/contacts/normal_force"][:]
            friction = float(np.asarray(file["/sonopack/friction"][()]))
            pressure = float(np.asarray(file["/sonopack/pressure"][()]))
        dim = x.shape[1]
        self.lattice = edges if edges.ndim == 2 else np.diag(edges)
        self.box = np.diag(self.lattice)
        self.dim, rotations = dim, {2: 1, 3: 3}[dim] if friction > 0 else 0
        self.dof = dim + rotations
        need = 2 if friction > 0 else dim + 1
        carrying = [c for c in range(len(ends)) if force[c] > threshold * pressure]
        while True:
            count = np.zeros(len(radius), int)
            for c in carrying:
                for end in ends[c]:
                    if end >= 0:
                        count[end] += 1
            kept = [c for c in carrying if all(end < 0 or count[end] >= need for end in ends[c])]
            if len(kept) == len(carrying):
                break
            carrying = kept
        alive = np.flatnonzero(count >= need)
        row = {g: k for k, g in enumerate(alive)}
        self.x, self.r = x[alive], radius[alive]
        mass = 4 / 3 * np.pi * self.r**3
        self.mass = np.hstack([np.repeat(mass[:, None], dim, 1),
                               np.repeat(0.4 * (mass * self.r**2)[:, None], rotations, 1)]).ravel()
        size = self.dof * len(alive)
        self.b, self.k, self.gap, self.of, self.start, self.branch = [], [], [], [], [], []
        for c in carrying:
            i, j = ends[c]
            n = normal[c]
            arm = radius[j] if j >= 0 else 0.0
            length = radius[i] + arm - overlap[c]
            kn = (np.sqrt(radius[i] * arm / (radius[i] + arm) * overlap[c]) if j >= 0
                  else 2 * np.sqrt(radius[i] * overlap[c]))
            self.start.append(x[i])
            self.branch.append(length * n)
            # relative displacement at the contact as a matrix over all degrees of freedom
            d = np.zeros((dim, size))
            d[:, self.dof * row[i]:self.dof * row[i] + dim] -= np.eye(dim)
            if j >= 0:
                d[:, self.dof * row[j]:self.dof * row[j] + dim] += np.eye(dim)
            if rotations:
                axes = np.eye(3) if dim == 3 else np.array([[0.0, 0.0, 1.0]])
                full = np.zeros(3)
                full[:dim] = n
                turn = np.array([np.cross(axis, full)[:dim] for axis in axes]).T  # surface velocity per spin and arm
                for grain, lever in ((i, radius[i]), (j, arm)):
                    if grain >= 0:
                        at = self.dof * row[grain] + dim
                        d[:, at:at + rotations] -= lever * turn
            strains = [(0, 0), (1, 1), (0, 1)] if dim == 2 else [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
            affine = np.array([[length * n[of] if a == along else 0 for along, of in strains] for a in range(dim)])
            for projector, k in ((np.outer(n, n), kn), (np.eye(dim) - np.outer(n, n), kn if rotations else 0)):
                if k:  # nu = 0: k_t = k_n
                    self.b.append(projector @ d)
                    self.gap.append(projector @ affine)
                    self.k += [k] * dim
                    self.of += [len(self.branch) - 1] * dim
        self.b, self.gap, self.k = np.vstack(self.b), np.vstack(self.gap), np.array(self.k)
        self.matrix = self.b.T @ (self.k[:, None] * self.b)
        self.area = np.prod(self.box[:-1])
        root = np.sqrt(self.mass)
        squares, vectors = np.linalg.eigh(self.matrix / np.outer(root, root))
        kept = squares > 1e-11 * squares[-1]  # what no spring resists is left out, in the metric of the masses
        self.floppy = int(np.sum(~kept))
        self.squares, self.vectors = squares[kept], vectors[:, kept] / root[:, None]

    def respond(self, force):
        return self.vectors @ ((self.vectors.T @ force).T / self.squares).T

    def stretch(self):
        return self.b @ self.respond(-self.b.T @ (self.k[:, None] * self.gap)) + self.gap

    def moduli(self):
        stretch = self.stretch()
        return self.gap.T @ (self.k[:, None] * stretch) / (self.area * self.box[-1])


def apparent(matrix, respond, dof, centres, radii, box, density, probe, axis):
    """(B2) and (B3)."""
    kind, n = probe.split(":")
    n, height, area = int(n), box[-1], np.prod(box[:-1])
    y = centres[:, -1]
    if kind == "sine":
        force = np.zeros(len(matrix))
        force[axis::dof] = 4 / 3 * np.pi * radii**3 / density * np.sin(n * np.pi * y / height)
        return area * height**3 / (4 * n**2 * np.pi**2 * (0.5 * force @ respond(force)))
    lines = height * np.arange(n + 2) / (n + 1)
    on = np.any(np.abs(y[:, None] - lines[None, 1:-1]) <= radii[:, None], axis=1)
    held = np.zeros((len(radii), dof), bool)
    held[on, :len(box)] = True
    held = held.ravel()
    u = np.zeros(len(matrix))
    u[axis::dof] = np.where(on, np.interp(y, lines, np.resize([0.0, 1, 0, -1], n + 2)), 0)
    free = ~held
    u[free] = np.linalg.lstsq(matrix[np.ix_(free, free)], -matrix[np.ix_(free, held)] @ u[held], rcond=1e-12)[0]
    return 2 * height * (0.5 * u @ matrix @ u) / ((n + 1)**2 * area)


def places(dim):
    """{column: its entry of the matrix}"""
    if dim == 2:
        return {"C11": (0, 0), "C12": (0, 1), "C22": (1, 1), "C33": (2, 2)}
    return {f"C{a + 1}{b + 1}": (a, b) for a in range(6) for b in range(a, 6) if a == b or b < 3}


def parts(oracle, cells, periodic):
    """Tensors of the parts [...][a][b], from forces and branch lines of the contacts; a line is cut by each part and its
    images (Liang and Barsky), as the command, which walks along it, does not."""
    dim, branch = oracle.dim, np.array(oracle.branch)
    start, line = (np.array(vectors) @ np.linalg.inv(oracle.lattice) * cells for vectors in (oracle.start, branch))
    force = np.zeros((len(branch), dim, oracle.gap.shape[1]))
    for row, (stretch, k) in enumerate(zip(oracle.stretch(), oracle.k)):
        force[oracle.of[row], row % dim] += k * stretch
    strains = [(0, 0), (1, 1), (0, 1)] if dim == 2 else [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    stress = np.stack([force[:, along] * branch[:, [of]] for along, of in strains], axis=1)
    out = np.zeros((*cells, *stress.shape[1:]))
    for at in np.ndindex(*cells):
        for image in np.ndindex(*np.where(periodic, 3, 1)):
            low = np.array(at) + np.where(periodic, np.array(image) - 1, 0) * cells - start
            with np.errstate(divide="ignore"):  # along an edge: infinities of the signs that the place has
                one, other = low / line, (low + 1) / line
            inside = np.minimum(one, other).max(axis=1).clip(0), np.maximum(one, other).min(axis=1).clip(None, 1)
            out[at] += np.tensordot((inside[1] - inside[0]).clip(0), stress, 1)
    return out / np.prod(oracle.box / cells)


def local():
    """moduli --probe local:W against numpy, within 1e-9 of the largest; its comments, and what is refused."""
    for width, keys, periodic in ((3, dict(grains=150, width=9, seed=7), (1, 0)),
                                  (1.5, dict(grains=90, cell="periodic", friction=0, seed=3, protocol="quick"), (1, 1)),
                                  (2.2, dict(grains=120, cell="box", seed=2, protocol="quick"), (0, 0)),
                                  (1.9, dict(dim=2, tilt=0.3, cells=7), (1, 1)), (1.7, dict(dim=3, tilt=-0.2, cells=4), (1, 1, 1)),
                                  (1.9, dict(dimension=3, grains=150, width=5, seed=7, protocol="quick"), (1, 1, 0))):
        if "tilt" in keys:
            write_packing(path := "tilted.h5", lattice(**keys))
        else:
            path = pack("local.h5", tolerance=1e-9, pressure=1e-3, **keys)
        oracle, own = Space(path), table("moduli", path, f"--probe=local:{width}")
        dim = oracle.dim
        cells = np.maximum(1, np.round(oracle.box / width)).astype(int)
        c = np.moveaxis(parts(oracle, cells, np.array(periodic, bool)), range(dim), range(dim - 1, -1, -1))
        c = c.reshape(-1, *c.shape[-2:])  # x first
        middle = (np.arange(cells[0])[:, None] + 0.5) / cells[0] * oracle.lattice[0] + 0.5 * (oracle.lattice[1:] / cells[1:, None]).sum(0)
        assert len(own) == np.prod(cells) and np.allclose(own["x"][:cells[0]], middle[:, 0])
        names = [name for name in own.names if re.fullmatch(r"C\d\d", name)]
        assert len(names) == (5 if dim == 2 else 12)
        for name in names:
            exact = c[:, int(name[1]) - 1, int(name[2]) - 1]
            assert np.abs(own[name] - exact).max() < 1e-9 * c.max() + own["error"].max(), (keys, name)
        axial = c[:, :dim, :dim]
        assert np.allclose(own["K"], axial.sum((1, 2)) / dim**2, atol=1e-9 * c.max())
        assert own["grains"].sum() == len(oracle.r) and np.isclose(own["contacts"].sum(), len(oracle.branch))
        for name in ("K", "G"):
            assert np.isclose(own.note(name), own[name].mean()) and np.isclose(own.note(name + "_sd"), own[name].std())
        if dim == 2:
            assert np.allclose(own["G"], 0.5 * (own["G_pure"] + own["C33"]), rtol=1e-9, atol=1e-9 * c.max())
    for words in (["--probe=local:x"], ["--probe=local:0"], ["--probe=local:3", "--probe=global"], ["--probe=local:3", N600]):
        refused("local", "moduli", N200, *words)
    refused("mean diameter", "moduli", N200, "--probe=local:0.9", status=1)
    assert "no contact" in run("moduli", N200, "--probe=local:1.01").stderr


def strain_and_probes():
    """Packings in space and in the plane, with and without friction, within 1e-6 of the largest (where a modulus is small
    the oracle's own rounding shows)."""
    words = [f"--probe={probe}" for probe in PROBES]
    for name, keys in (("space", dict(dimension=3, grains=220, width=5)), ("plane", dict(grains=150, width=9, pressure=1e-6)),
                       ("smooth", dict(dimension=3, grains=220, width=5, friction=0))):
        path = pack(f"{name}.h5", tolerance=1e-9, seed=7, **keys)
        oracle, density, row = Space(path), table("statics", path)["Phi3s"][0], table("moduli", path)
        dim, c = oracle.dim, oracle.moduli()
        assert row.names == ["file", "p", *places(dim), "c_l", "c_t", "C_err", "c_l_err", "c_t_err"]
        for column, place in places(dim).items():
            if name == "smooth" and column in ("C44", "C55"):  # smooth walls cannot shear
                assert np.isnan(row[column][0])
            else:
                assert np.isclose(row[column][0], c[place], rtol=1e-6, atol=1e-12 * c[1, 1]), (name, column, c)
        along, shear = ("C33", "C55") if dim == 3 else ("C22", "C33")
        assert np.isclose(row["c_l"][0]**2 * density, row[along][0], rtol=1e-12)
        assert 0 < row["C_err"][0] < 1e-9 * row[along][0] and np.isnan(row["c_t_err"][0]) == np.isnan(row["c_t"][0])
        if name == "smooth":
            continue
        found = table("moduli", path, *words, "--probe=global")
        assert found.names == ["file", "p", "probe", along, shear, along + "_ratio", shear + "_ratio", along + "_err", shear + "_err"]
        assert (0 < found[along + "_err"]).all() and (found[along + "_err"] < 1e-9 * found[along]).all()
        bound = found[along + "_err"][-1]  # of the imposed strain
        assert bound <= row["C_err"][0] and 0.5 * row["c_l"][0] * bound / row[along][0] < row["c_l_err"][0] < 1e-9 * row["c_l"][0]
        assert found.words("probe") == [*PROBES, "global"] and found[along][-1] == row[along][0]
        for axis, column in ((dim - 1, along), (0, shear)):
            exact = [apparent(oracle.matrix, oracle.respond, oracle.dof, oracle.x, oracle.r, oracle.box, density, probe, axis)
                     for probe in PROBES]
            assert np.allclose(found[column][:-1], exact, rtol=1e-6, atol=0), (name, column, found[column], exact)
            assert np.allclose(found[column + "_ratio"], found[column] / row[column][0], rtol=1e-9)
    assert table("moduli", N200, "--probe=lines:1").names == ["file", "p", "C22", "C33", "C22_ratio", "C33_ratio", "C22_err", "C33_err"]


def projected(oracle):
    """The moduli from the projection of the affine stretches onto those that no displacement makes: no inverse, and so
    no rounding that grows with the softness of a motion. Also the number of mechanisms."""
    root = np.sqrt(oracle.k)[:, None]
    left, values, _ = np.linalg.svd(root * oracle.b, full_matrices=False)
    kept = values > 1e-7 * values[0]
    stretch = root * oracle.gap
    made = left[:, kept].T @ stretch
    return (stretch.T @ stretch - made.T @ made) / (oracle.area * oracle.box[-1]), int(np.sum(~kept))


def floppy():
    """Packings at low pressure, with mechanisms: within 1e-9 of the largest modulus."""
    found = 0
    for dim, grains, width, friction, pressure in ((3, 60, 4.9, 0.3, 1e-5), (3, 60, 4.9, 1, 1e-7), (3, 70, 4.9, 0, 1e-6),
                                                   (2, 80, 8, 0.5, 1e-7), (2, 80, 8, 0, 1e-6)):
        path = pack("floppy.h5", dimension=dim, grains=grains, width=width, friction=friction, pressure=pressure, seed=1,
                    protocol="quick")
        c, mechanisms = projected(Space(path))
        found, row = found + mechanisms, table("moduli", path)
        for name, place in places(dim).items():
            assert np.isnan(row[name][0]) or abs(row[name][0] - c[place]) < 1e-9 * c[1, 1], (dim, friction, name, row.row(), c)
    assert found > 5, found
    # 700 spheres with 21 mechanisms: one pivot is 1e-13 of another, and yet no modulus is in doubt
    path = pack("spheres.h5", dimension=3, width=6, friction=0.3, pressure=1e-5, grains=700, seed=1, protocol="quick")
    row = table("moduli", path)
    assert all(row[name][0] > 0 for name in row.names[2:]), row.row()


def strained():
    """A strain of next to nothing gives the moduli with prestress."""
    found, springs = table("moduli", N600, "--strain=1e-9", "--strain=5e-5"), table("moduli", N600, "--prestress")
    assert found.names == "file p strain C11 C12 C22 C33 sliding lost made residual".split()
    for name in ("C11", "C22", "C33"):
        assert abs(found[name][0] / springs[name][0] - 1) < 1e-5, (name, found.rows, springs.rows)
    assert found["residual"][0] < 1e-6 and 0 < found["sliding"][1] >= found["sliding"][0]
    assert found["C33"][1] < found["C33"][0]


def without_a_value():
    """What has none is nan, and told; no rounding is shown as a modulus."""
    def told(names, *words):
        done = run("moduli", *words)
        assert names_all(done.stderr, names), done.stderr
        return Table(done.stdout)

    # thin: no bulk away from both walls, so no density; lines need none
    thin = pack("thin.h5", grains=60, width=12, tolerance=1e-8)
    assert np.isnan(told("--margin", thin)["c_l"][0])
    assert table("moduli", thin, "--probe=lines:1")["C22"][0] > 0
    assert table("moduli", thin, "--probe=sine:1", "--margin=1")["C22"][0] > 0
    smooth = pack("smooth2.h5", grains=150, width=9, friction=0, tolerance=1e-9)
    assert np.isnan(told("--probe sine:1", smooth)["C33"][0])
    row = told("nan", smooth, "--probe=sine:1")
    assert row["C33"][0] > 0 and np.isnan(row["C33_ratio"][0])
    # two dimensions and three name their moduli otherwise: the first file decides, the other is told
    done = tried("moduli", thin, pack("solid.h5", grains=60, width=5, dimension=3, tolerance=1e-8))
    assert done.returncode == 1 and len(Table(done.stdout)) == 1
    # a ball that rolls between the walls
    ball = pack("ball.h5", grains=2, width=4.8)
    row = told("C33 0 C11", ball)
    assert row["C11"][0] == row["C33"][0] == 0 < row["C22"][0], row.row()
    row = table("moduli", ball, "--strain=1e-6")  # its uniaxial strain along the walls is free
    assert abs(row["C11"][0]) < 1e-15 < row["C22"][0], row.row()
    # strong contacts alone, which touch both walls and hold nothing; a network that its prestress makes unstable
    for words in ([ball, "--probe=lines:1"], [N600, "--threshold=0.9"], [N600, "--threshold=0.9", "--probe=lines:1"],
                  [N200, "--threshold=0.3", "--prestress"]):
        refused("", "moduli", *words, status=1)
    chain = pack("chain.h5", kind="chain", grains=9)
    row, linear = told("C22", chain, "--strain=1e-9"), table("moduli", chain)
    assert all(np.isnan(t[name][0]) for t in (row, linear) for name in ("C11", "C12", "C33"))
    assert np.isclose(row["C22"][0], linear["C22"][0], rtol=1e-6)  # strain over overlap: 1e-7


def responses():
    """respond against a dense solution of the plain network: displacements, forces, work; and what is refused."""
    plain = network(N200)
    rows, normals = {grain: k for k, grain in enumerate(plain.alive)}, np.arange(0, len(plain.k), 2)
    grain, other = int(plain.alive[17]), int(plain.alive[60])
    force, swell, dipole = (np.zeros(len(plain.mass)) for _ in range(3))
    force[3 * rows[grain] + 1] = 1
    radius = dict(zip(*(table("respond", N200, "--strain", "xx")[name] for name in ("grain", "radius"))))
    of = normals[(plain.ends[normals] == rows[other]).any(axis=1)]
    swell += plain.b[of].T @ plain.k[of] * radius[other]
    contact = table("respond", N200, "--strain", "xx", "--contacts")
    at = int(contact["contact"][5])
    i, j = (int(contact[name][5]) for name in "ij")
    between = next(q for q in normals if list(plain.ends[q]) == [rows[i], rows[j] if j >= 0 else j])
    dipole += plain.b[between]
    for words, load in ((("--push", f"{grain}:y"), force), (("--swell", other), swell), (("--dipole", at), dipole),
                        (("--strain", "yy"), -plain.b.T @ (plain.k * plain.affine[:, 1])),
                        (("--strain", "xy"), -plain.b.T @ (plain.k * plain.affine[:, 2]))):
        own, exact = table("respond", N200, *words), np.linalg.solve(plain.matrix, load)
        u = np.column_stack([own["ux"], own["uy"], own["rz"]]).ravel()
        assert list(own["grain"]) == list(plain.alive), words
        assert np.abs(u - exact).max() < 1e-9 * np.abs(exact).max() and own.note("load_error") < 1e-10, words
        told = own.note("work") if "work" in own.notes else 0.5 * own.note("compliance")
        assert np.isclose(told, 0.5 * load @ exact, rtol=1e-9), words
    own, si = (table("respond", N200, "--push", f"{grain}:y", *words) for words in ((), ("--units=si", MATERIAL)))
    factor = 1 / (70e9 / (1 - 0.22**2) * 1e-3) * 1e3  # mm/N
    assert np.allclose(si["uy"], own["uy"] * factor, rtol=1e-9) and np.isclose(si.note("compliance"), own.note("compliance") * factor)
    for word in (["--push", "3"], ["--push", "3:q"], ["--push", "3:z"], ["--swell", "x"], ["--strain", "yx"], ["--strain", "x"],
                 ["--strain", "zz"], [], ["--swell", 1, "--dipole", 2], ["--dipole", -1]):
        refused(word[0] if len(word) == 2 else "--push --strain", "respond", N200, *word,
                status=2 if word not in (["--push", "3:z"], ["--strain", "zz"]) else 1)
    told = table("moduli", N200, "--prestress", "--threshold", "1e-3").notes
    assert told["prestress"] == "1" and told["threshold"] == "0.001" and not {"prestress", "threshold"} & table("moduli", N200).notes.keys()
    rattler = next(k for k in range(200) if k not in rows)
    for word in (["--push", f"{rattler}:x"], ["--swell", 200], ["--dipole", 100000], ["--swell", 3, "--prestress"]):
        refused("", "respond", N200, *word, status=1)


main(strain_and_probes, local, floppy, strained, without_a_value, responses)
