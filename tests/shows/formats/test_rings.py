"""Packings between two rings, and walls that files do not list: packings from a minimiser of this file, in the tables
of experiments and dumps of DEM programs; signals from dense matrices of this file, speeds from its moduli."""
import gzip
import math
import os
import subprocess

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial import cKDTree
from scipy.special import j1, y1

from sonopack import Material, Packing, Scene, SonopackError
from sonopack.formats import command
from sonopack.formats.options import RINGS
from sonopack.traces import arrivals, line, read

INNER, OUTER = 3.0, 10.0
PIXEL, NEWTON = 100.0, 5e4  # of a diameter d; of E* d^2
MATERIAL = Material(0.75e9, 0.5, 1000.0, 1e-2)  # E* = 1e9 Pa
KN = 5e-3  # [E* d]
DISKS = {"material": MATERIAL, "length_unit": 1e-2 / PIXEL, "force_unit": 1e5 / NEWTON, "kn": KN * 1e7, "kt_ratio": 0.4,
         "thickness": 3e-3, "wall_kn": 2 * KN * 1e7, "friction": 0.5}
KNOWN = {"inner": PIXEL * INNER, "outer": PIXEL * OUTER, "x0": 1500.0, "y0": 1600.0}


def sonopack(*arguments):
    """What a command that computes prints."""
    return subprocess.run([os.environ["SONOPACK"], *map(str, arguments)], text=True, capture_output=True, check=True).stdout


class Annulus:
    """Smooth harmonic disks between rigid rings, at a minimum of their energy (FIRE)."""

    def __init__(self, seed=5, fraction=0.9):
        rng = np.random.default_rng(seed)
        n = int(4 * fraction * (OUTER**2 - INNER**2) / 1.013)
        self.r = r = 0.5 * rng.uniform(0.8, 1.2, n)
        rho, angle = np.sqrt(rng.uniform((INNER + 0.6)**2, (OUTER - 0.6)**2, n)), rng.uniform(0, 2 * math.pi, n)
        x, v = np.stack([rho * np.cos(angle), rho * np.sin(angle)], axis=1), np.zeros((n, 2))
        dt, mix, good = 0.1, 0.1, 0
        for step in range(20000):
            if step % 20 == 0:
                i, j = cKDTree(x).query_pairs(1.5, output_type="ndarray").T
            d = x[j] - x[i]
            apart, away = np.hypot(*d.T), np.hypot(*x.T)
            depth, deep = r[i] + r[j] - apart, np.stack([INNER - away + r, away + r - OUTER])
            push = (np.maximum(depth, 0) / apart)[:, None] * d
            f = (2 * (np.maximum(deep[0], 0) - np.maximum(deep[1], 0)) / away)[:, None] * x
            for a in range(2):
                f[:, a] += np.bincount(j, push[:, a], n) - np.bincount(i, push[:, a], n)
            if step % 20 == 10 and np.abs(f).max() < 1e-13:
                break
            if (f * v).sum() > 0:
                v, good = (1 - mix) * v + mix * f * np.sqrt((v**2).sum() / (f**2).sum()), good + 1
                dt, mix = (min(1.1 * dt, 0.5), 0.99 * mix) if good > 5 else (dt, mix)
            else:
                v, dt, mix, good = 0 * v, 0.5 * dt, 0.1, 0
            v = v + dt * f
            x = x + dt * v
        assert step < 19999, f"seed {seed}"
        touch, (wall, grain) = depth > 0, np.nonzero(deep > 0)
        self.x, self.n = x, n
        self.i, self.j = np.r_[i[touch], grain], np.r_[j[touch], -1 - wall]
        self.overlap = np.r_[depth[touch], deep[wall, grain]]
        self.kn = np.where(self.j < 0, 2 * KN, KN)

    def write(self, folder, listed, noise=0.0, names=("inner", "outer")):
        """The tables of an experiment, gzipped; listed: with the contacts of the rings."""
        centre = np.array([KNOWN["x0"], KNOWN["y0"]]) + PIXEL * (self.x + noise * np.random.default_rng(1).normal(size=(self.n, 2)))
        edge = set(self.i[self.j < 0])
        grains = "frame,id,x,y,radius,boundary\n" + "".join(
            f"{frame},{k + 1},{x!r},{y!r},{PIXEL * r!r},{int(k in edge)}\n" for frame in (3, 12)
            for k, ((x, y), r) in enumerate(zip(centre.tolist(), self.r.tolist())))
        rows = [(i + 1, j + 1 if j >= 0 else names[-1 - j], f) for i, j, f in
                zip(self.i.tolist(), self.j.tolist(), (self.kn * self.overlap).tolist()) if j >= 0 or listed]
        contacts = "frame,id1,id2,Ft,Fn\n" + "".join(f"{frame},{i},{j},0,{3 / frame * NEWTON * f!r}\n"
                                                     for frame in (3, 12) for i, j, f in rows)
        for name, text in (("grains.csv.gz", grains), ("contacts.csv.gz", contacts)):
            (folder / name).write_bytes(gzip.compress(text.encode()))
        return folder / "grains.csv.gz", {"contacts": folder / "contacts.csv.gz", "form": "photoelastic", "frame": 3}


class Dense:
    """Springs of contacts as rows of matrices: along n, then along t = (-ny, nx), of which the kn and kt are `k`."""

    def __init__(self, p):
        c = p.contacts[p.carrying()]
        self.i, self.j, n = c["i"], c["j"], c["n"][:, :2]
        self.way = np.concatenate([n, np.stack([-n[:, 1], n[:, 0]], axis=1)])
        self.k, m = np.r_[c["kn"], c["kt"]], len(c)
        self.b = np.zeros((2 * m, 3 * p.n))
        row = np.arange(m)
        for grain, sign, taken in ((self.i, -1, row), (self.j, 1, row[self.j >= 0])):
            for part in (0, m):
                for a in range(2):
                    self.b[taken + part, 3 * grain[taken] + a] = sign * self.way[taken + part, a]
            self.b[taken + m, 3 * grain[taken] + 2] = -p.r[grain[taken]]
        self.at = p.x[self.i, :2] + p.r[self.i, None] * n - p.box[0] / 2
        self.branch = (p.r[self.i] - c["overlap"] + np.where(self.j >= 0, p.r[np.maximum(self.j, 0)], 0))[:, None] * n
        self.level = np.hypot(*(p.x[:, :2] - p.box[0] / 2).T) - INNER
        self.mass = np.stack([p.mass, p.mass, p.inertia], axis=1).ravel()
        self.stiffness = self.b.T @ (self.k[:, None] * self.b)
        self.volume = math.pi * (OUTER**2 - INNER**2)
        root = 1 / np.sqrt(self.mass)
        square, modes = np.linalg.eigh(self.stiffness * root[:, None] * root)
        self.omega, self.modes = np.sqrt(np.maximum(square, 0)), root[:, None] * modes

    def force(self, springs, direction):
        """Row of the sum of the forces of i on j along a direction at each of some contacts, by their signs."""
        along = np.tile(springs, 2) * (self.way * np.tile(direction, (2, 1))).sum(axis=1)
        return -(along * self.k) @ self.b

    def signal(self, source, detector, t):
        parts, real = (self.modes.T @ source) * (self.modes.T @ detector), self.omega > 1e-8
        return np.sin(np.outer(t, self.omega[real])) @ (parts[real] / self.omega[real])

    def modulus(self, strain):
        """The stress of a strain of the rings and all contact points, in its own direction."""
        imposed = (np.tile(self.branch @ strain, (2, 1)) * self.way).sum(axis=1)
        load = self.b.T @ (self.k * imposed)
        return (self.k @ imposed**2 - load @ self.response(load)) / self.volume

    def response(self, load):
        """Displacements by a static load; rattlers are at rest."""
        real = self.omega > 1e-8
        return self.modes[:, real] @ ((self.modes[:, real].T @ load) / self.omega[real]**2)


@pytest.fixture(scope="module")
def annulus():
    return Annulus()


@pytest.fixture(scope="module")
def ring(annulus, tmp_path_factory):
    path, words = annulus.write(tmp_path_factory.mktemp("ring"), True)
    return Packing.read(path, **words, **DISKS, **KNOWN)


@pytest.fixture(scope="module")
def dense(ring):
    return Dense(ring)


# ---- geometry and sound ---------------------------------------------------------------------------------------------

def test_import(annulus, ring):
    assert ring.cell == "ring" and np.allclose(ring.box, (2 * OUTER, OUTER - INNER), rtol=1e-12)
    assert np.allclose(ring.x[:, :2] - OUTER, annulus.x, atol=1e-12) and ring.height == pytest.approx(OUTER - INNER)
    walls = {-1: 0.0, -2: 0.0}
    for i, j, force in zip(annulus.i, annulus.j, annulus.kn * annulus.overlap):
        walls[int(j)] = walls.get(int(j), 0.0) + force
    assert ring.pressure == pytest.approx((walls[-2] * OUTER - walls[-1] * INNER) / 2 / ring.volume, rel=1e-9)  # Gauss
    audit = ring.audit()
    assert max(audit.force_residual, audit.wall_residual, audit.geometry_residual, audit.missing) < 1e-9


def test_signals_are_those_of_dense_matrices(ring, dense):
    out = dense.at / np.hypot(*dense.at.T)[:, None]
    turned = np.stack([out[:, 1], -out[:, 0]], axis=1)
    network, t = ring.network(), np.linspace(0, 200, 101)
    above = dense.level > 3.5
    passes = np.where(dense.j >= 0, above[dense.j], dense.j == -2).astype(int) - above[dense.i]
    rows = {"outer": (dense.j == -2, out), "outer:shear": (dense.j == -2, turned), "plane:3.5": (passes, out),
            "plane:3.5:shear": (passes, turned)}
    momentum = np.zeros(3 * ring.n)
    for k in np.flatnonzero(dense.j == -1):
        momentum[3 * dense.i[k]:3 * dense.i[k] + 2] -= dense.k[k] * dense.way[k]
    for place, (springs, direction) in rows.items():
        exact = dense.signal(momentum, dense.force(springs, direction), t)
        found = network.signal(until=200, points=101, method="chebyshev", detectors=[place])
        assert np.abs(found.F - exact).max() < 1e-9 * np.abs(exact).max(), place


def test_speeds_are_those_of_the_continuum(ring, dense):
    """The lowest radial mode of a continuum of the same moduli, u = J1 Y1 - Y1 J1 between fixed rings, is within 3% of
    that of the grains, and peaks pass the circles at c_l within 10%. Fronts are up to 1.5 times as fast as long waves
    (Somfai et al. 2005)."""
    along = [dense.modulus(np.diag(axis)) for axis in ((1.0, 0.0), (0.0, 1.0))]
    speed = math.sqrt(0.5 * sum(along) / (ring.mass.sum() / dense.volume))
    k = brentq(lambda k: j1(k * INNER) * y1(k * OUTER) - j1(k * OUTER) * y1(k * INNER), 0.3, 0.6)
    at, away = ring.x[:, :2] - OUTER, dense.level + INNER
    field = np.zeros((ring.n, 3))
    field[:, :2] = at * ((j1(k * away) * y1(k * INNER) - y1(k * away) * j1(k * INNER)) / away)[:, None]
    load = field.ravel() * dense.mass
    u = dense.response(load)  # nearer to the mode than the field itself
    assert math.sqrt((load @ u) / ((u * dense.mass) @ u)) == pytest.approx(speed * k, rel=0.03)
    places = np.arange(2.0, 6.1, 0.5)
    signal = ring.network().signal(until=100, points=1001, detectors=[f"plane:{y}" for y in places])
    fronts = [signal.front(0, k) for k in range(len(places))]
    peak, first = (1 / np.polyfit(places, [getattr(front, name) for front in fronts], 1)[0] for name in ("t_peak", "t10"))
    assert peak == pytest.approx(speed, rel=0.1) and 1 < first / speed < 1.5


def test_speed_with_its_error(ring, tmp_path):
    """As the guide does it, `sonopack trace` on circles and the outer ring: the error covers the line of `sonopack front`."""
    ring.save(tmp_path / "ring.h5")
    places = [word for place in ("plane:2", "plane:3.5", "plane:5", "outer") for word in ("--detector", place)]
    sonopack("signal", tmp_path / "ring.h5", *places, "--until", 80, "--points", 401, "-o", tmp_path / "circles.tsv")
    rows = np.loadtxt(sonopack("front", tmp_path / "circles.tsv").splitlines(), skiprows=4, usecols=(1, 2))
    assert rows[:, 0].tolist() == [2, 3.5, 5, pytest.approx(OUTER - INNER)]
    traces = read(str(tmp_path / "circles.tsv"))
    found = line(np.array([trace.distance for trace in traces]), arrivals(traces), 0)
    assert 0 < found.error < 0.1 * found.speed and abs(found.speed - 1 / np.polyfit(*rows.T, 1)[0]) < 2 * found.error


def test_speed_and_errors_of_the_measurement(ring, tmp_path):
    """One factor of all stiffnesses, with a standard deviation of 4%, gives 2% of the speed."""
    ring.save(tmp_path / "ring.h5")
    rows = sonopack("uncertainty", tmp_path / "ring.h5", "--calibration", 0.04, "--samples", 40, "--front-only").splitlines()
    head, last = (row.split("\t") for row in (next(row for row in rows if row.startswith("quantity")), rows[-1]))
    c = dict(zip(head, last))
    assert c["quantity"] == "c" and float(c["value"]) == pytest.approx(ring.height / ring.front().t10, rel=1e-6)
    assert abs(float(c["sd"]) - 0.02 * float(c["value"])) < 4 * float(c["sd_err"]) < 0.02 * float(c["value"])


# ---- what files do not say ------------------------------------------------------------------------------------------

@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_rings_are_found(annulus, ring, tmp_path, noise):
    """From the balance of the grains alone. Places with an error move the circles by it over the root of the contacts."""
    path, words = annulus.write(tmp_path, False, noise)
    found = Packing.read(path, **words, **DISKS, walls="balance", cell="ring")
    sigma = noise * math.sqrt(1 / (annulus.j == -1).sum() + 1 / (annulus.j == -2).sum())
    assert abs(found.height - ring.height) < 1e-6 + 4 * sigma
    assert found.front().t10 == pytest.approx(ring.front().t10, rel=1e-5 if noise == 0 else 0.02)
    assert noise > 0 or found.pressure == pytest.approx(ring.pressure, rel=1e-6)
    assert "contacts: x0=1" in "\n".join(found.report.lines("it")).replace("rings through their 75 ", "")


def test_given_values_stay(annulus, tmp_path):
    path, words = annulus.write(tmp_path, False, 0.01)
    p = Packing.read(path, **words, **DISKS, walls="balance", cell="ring", outer=KNOWN["outer"])
    assert p.box[0] == pytest.approx(2 * OUTER, rel=1e-12) and p.box[1] != OUTER - INNER
    p = Packing.read(path, **words, **DISKS, walls="balance", x0=KNOWN["x0"], y0=KNOWN["y0"], inner=KNOWN["inner"])
    assert 0.5 * p.box[0] - p.box[1] == pytest.approx(INNER, rel=1e-12)


def test_walls_of_a_dump(annulus, ring, tmp_path):
    """Forces and points of contact with cylinders, as `fix wall/gran/region ... contacts` of LAMMPS has them."""
    rows = [[0.0] * 14 for _ in range(annulus.n)]
    for k in range(annulus.n):
        for wall in (-1, -2):
            for i in np.flatnonzero((annulus.i == k) & (annulus.j == wall)):
                out = annulus.x[k] / np.hypot(*annulus.x[k]) * (-1 if wall == -2 else 1)
                point = annulus.x[k] * (INNER if wall == -1 else OUTER) / np.hypot(*annulus.x[k])
                force = annulus.kn[i] * annulus.overlap[i] * out
                rows[k][7 * (-1 - wall):7 * (-wall)] = [1.0, *force, 0.0, *point, 0.0]
    box = "ITEM: BOX BOUNDS ff ff pp\n-10 10\n-10 10\n-0.5 0.5\n"
    names = " ".join(f"f_{wall}[{k}]" for wall in RINGS for k in range(1, 8))
    (tmp_path / "g").write_text(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{annulus.n}\n{box}ITEM: ATOMS id x y z radius {names}\n" + "".join(
        f"{k + 1} {x!r} {y!r} 0 {r!r} {' '.join(repr(float(v)) for v in row)}\n"
        for k, ((x, y), r, row) in enumerate(zip(annulus.x.tolist(), annulus.r.tolist(), rows))))
    pairs = annulus.j >= 0
    (tmp_path / "c").write_text(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n{pairs.sum()}\n{box}ITEM: ENTRIES id1 id2 fn kn kt\n" + "".join(
        f"{i + 1} {j + 1} {KN * o!r} {KN} {0.4 * KN}\n"
        for i, j, o in zip(annulus.i[pairs].tolist(), annulus.j[pairs].tolist(), annulus.overlap[pairs].tolist())))
    p = Packing.read(tmp_path / "g", contacts=tmp_path / "c", friction=0.5, cell="ring", wall_kn=2 * KN, kt_ratio=0.4)
    assert np.allclose(p.box, ring.box, rtol=1e-9) and p.pressure == pytest.approx(ring.pressure, rel=1e-9)
    assert np.allclose(p.contacts["kn"], ring.contacts["kn"], rtol=1e-9)


def dump(p, folder, digits):
    """Grains and the contacts between them as LAMMPS writes them."""
    bounds = f"ITEM: BOX BOUNDS pp ff pp\n0 {p.box[0]!r}\n0 {p.box[1]!r}\n-0.5 0.5\n"
    rows = p.contacts[p.contacts["j"] >= 0]
    grains = "".join(f"{k + 1} {x:.{digits}g} {y:.{digits}g} 0 {r!r}\n" for k, ((x, y, _), r) in enumerate(zip(p.x, p.r.tolist())))
    contacts = "".join(f"{c['i'] + 1} {c['j'] + 1} {float(c['fn'])!r} {float(c['ft'][0])!r} {float(c['ft'][1])!r}\n" for c in rows)
    for name, of, count, columns, text in (("g", "ATOMS", p.n, "id x y z radius", grains),
                                           ("c", "ENTRIES", len(rows), "id1 id2 fn ft_x ft_y", contacts)):
        (folder / name).write_text(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF {of}\n{count}\n{bounds}ITEM: {of} {columns}\n{text}")
    return folder / "g", {"contacts": folder / "c", "friction": p.friction}


@pytest.fixture(scope="module")
def piston():
    return Packing.make(Scene(packing={"grains": 80, "width": 8, "seed": 3, "pressure": 1e-4}))


@pytest.mark.parametrize("digits, close", [(17, 1e-5), (6, 1e-3)])
def test_unlisted_walls(piston, tmp_path, digits, close):
    """Rigid walls, where dumps of LAMMPS usually have elastic ones of half the force at an overlap."""
    path, words = dump(piston, tmp_path, digits)
    p = Packing.read(path, **words)
    assert p.wall == "rigid" and p.pressure == pytest.approx(1e-4, rel=close)
    assert p.front().t10 == pytest.approx(piston.front().t10, rel=close)
    assert "from the balance of the grains at them" in "\n".join(p.report.lines("it"))


def test_frames_with_known_walls(tmp_path):
    """Experiments mark grains at the boundary and list no wall; forces come back with friction, but in corners."""
    p = Packing.make(Scene(packing={"cell": "box", "grains": 60, "seed": 2}))
    c = p.contacts[p.contacts["j"] >= 0]
    edge = set(p.contacts["i"][p.contacts["j"] < 0].tolist())
    (tmp_path / "g.csv").write_text("id,x,y,radius,boundary\n" + "".join(
        f"{k},{x!r},{y!r},{r!r},{int(k in edge)}\n" for k, ((x, y, _), r) in enumerate(zip(p.x.tolist(), p.r.tolist()))))
    (tmp_path / "c.csv").write_text("id1,id2,fn,ft_x,ft_y\n" + "".join(
        f"{k['i']},{k['j']},{float(k['fn'])!r},{float(k['ft'][0])!r},{float(k['ft'][1])!r}\n" for k in c))
    q = Packing.read(tmp_path / "g.csv", contacts=tmp_path / "c.csv", walls="balance", friction=p.friction, cell="box",
                     left=0, right=p.box[0], bottom=0, top=p.box[1])
    assert q.wall == "rigid" and q.pressure == pytest.approx(p.pressure, rel=0.01)  # friction in corners is not known
    own, found = ({(int(k["i"]), int(k["j"])): k for k in one.contacts if k["j"] < 0} for one in (p, q))
    corner = [i for i in edge if sum(key[0] == i for key in own) > 1]
    alone = [key for key in found if key[0] not in corner]
    assert set(found) <= set(own) and len(alone) > 0.8 * len(own)
    assert all(np.allclose(found[key][name], own[key][name], atol=1e-5 * p.pressure) for key in alone for name in ("n", "fn", "ft"))


@pytest.mark.parametrize("modulus", [0.25, 1.0, 1e9])
def test_walls_of_a_modulus(piston, tmp_path, modulus):
    """1/E12 = 1/E1 + 1/E2: as rigid at infinity, elastic at 1."""
    path, words = dump(piston, tmp_path, 17)
    p = Packing.read(path, **words, wall_modulus=modulus)
    c = p.contacts[p.contacts["j"] < 0]
    e = np.sqrt(p.r[c["i"]]) / (1 + 1 / modulus)
    assert np.allclose(c["fn"], 4 / 3 * e * c["overlap"]**1.5, rtol=1e-12) and p.pressure == pytest.approx(1e-4, rel=1e-5)
    assert np.allclose(c["kn"], 2 * e * np.sqrt(c["overlap"]), rtol=1e-12)


def test_frames(annulus, tmp_path):
    """A movie of two frames, of which the second has a fourth of the forces; overlaps of a few percent follow from them."""
    annulus.write(tmp_path, True)
    words = (f"--from photoelastic --frame all --material E=0.75e9,nu=0.5,rho=1000,d=1e-2 --length-unit 1e-4 --quiet "
             f"--force-unit {1e5 / NEWTON} --kn {KN * 1e7} --thickness 3e-3 --set friction=0 --set cell=ring --contacts")
    command.run(command.parser().parse_intermixed_args(
        [f"{tmp_path}/grains.csv.gz", f"{tmp_path}/P.h5", *words.split(), f"{tmp_path}/contacts.csv.gz"]))
    first, last = (Packing.read(tmp_path / f"P-{k}.h5") for k in ("03", "12"))
    assert last.pressure == pytest.approx(first.pressure / 4, rel=0.1) and first.cell == "ring"
    assert len(sonopack("front", tmp_path / "P-03.h5", tmp_path / "P-12.h5").splitlines()) == 6


# ---- files and refusals ---------------------------------------------------------------------------------------------

@pytest.mark.parametrize("ending", [".h5", ".vtp", ".mat", ".csv"])
def test_files(ring, tmp_path, ending):
    ring.save(tmp_path / f"p{ending}")
    p = Packing.read(tmp_path / f"p{ending}")
    assert p.cell == "ring" and p.box == ring.box and np.array_equal(p.x, ring.x)
    assert np.allclose(p.contacts["n"], ring.contacts["n"], rtol=1e-15)


def test_own_tables(ring, tmp_path):
    ring.save_tables(tmp_path / "g.tsv", tmp_path / "c.tsv")
    assert Packing.read_tables(tmp_path / "g.tsv", tmp_path / "c.tsv").hash == ring.hash


def test_grains_alone(ring, tmp_path):
    """Forms that know no rings say them in their heads, and have a box around them."""
    for name in ("p.data", "p.xyz"):
        ring.save(tmp_path / name)
        p = Packing.read(tmp_path / name, contacts="overlap", digits="exact")
        assert p.cell == "ring" and np.allclose(p.box, ring.box, rtol=1e-12)
        assert (p.contacts["j"] < 0).sum() == (ring.contacts["j"] < 0).sum()


REFUSED = [  # what, and words of the reason
    (lambda p: p.network(prestress=True).moduli(), "walls are rings: a strain under prestress"),
    (lambda p: p.network().finite_strain(), "walls are rings"),
    (lambda p: p.network().local_moduli(4), "walls are rings: a grid"),
    (lambda p: p.network().probes([("sine", 1)]), "between two walls"),
    (lambda p: p.network().dispersion(), "walls are rings"),
    (lambda p: p.network().signal(until=1, points=2, method="dynamics"), ""),
    (lambda p: p.network().signal(until=1, points=2, detectors=["part:1:2"]), "walls are rings: a part of a wall"),
    (lambda p: p.network().signal(until=1, points=2, detectors=["plane:7.5"]), "below the height 7"),
    (lambda p: p.network().harmonic([0.1]), "walls are rings"),
    (lambda p: p.network().section(), "walls are rings"),
    (lambda p: p.network().sensitivity(by="radius"), "walls are rings: a derivative by radii"),
    (lambda p: p.network().flux(np.zeros((p.n, 3)), np.zeros((p.n, 3)), [1.0]), "walls are rings: a flux"),
    (lambda p: Packing.make(Scene(packing={"kind": "file"}), start=p), ""),
]


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_refused_by_the_engine(ring, case):
    act, words = REFUSED[case]
    with pytest.raises(SonopackError, match=words):
        act(ring)


@pytest.mark.parametrize("more, words", [
    ({"walls": "balance"}, r"\d+ of \d+ contacts with the \w+ wall are of grains farther than a radius"),
    ({"walls": "balance", "cell": "box"}, "farther than a radius"),
    ({"walls": "balance", "cell": "ring", **KNOWN, "outer": 800.0}, "is not between the rings"),
    ({"walls": "balance", "cell": "ring", **KNOWN, "inner": 1200.0}, "inner = 1200: must be above 0 and below"),
    ({"walls": "overlap", "cell": "ring"}, "of a ring inner, outer, x0, y0"),
    ({"cell": "ring", "wall_modulus": 1.0}, "wall_kn where --kn is given"),
    ({"walls": "balance", "x0": 1500.0}, "must be given by --set x0= and --set y0=, or by neither"),
    ({"cell": "ring", "gravity": 9.81}, "ring: dimension 2, 7.* gravity"),
    ({"cell": "ring", "rest": True}, "--rest: grains come to rest under a piston"),
    ({"walls": "balance", "cell": "ring", "inner": -1.0}, "inner = '-1.0': must be a finite number >= 0"),
])
def test_refused_imports(annulus, tmp_path, more, words):
    path, own = annulus.write(tmp_path, False)
    with pytest.raises(SonopackError, match=words):
        Packing.read(path, **own, **{**DISKS, **more})


def test_listed_walls_must_be_near(annulus, tmp_path):
    path, own = annulus.write(tmp_path, True, names=("bottom", "top"))
    with pytest.raises(SonopackError, match=r"\d+ of \d+ contacts with the top wall .* up to 1\d.\d d"):
        Packing.read(path, **own, **DISKS)


def test_own_tables_must_be_near(piston, tmp_path):
    piston.save_tables(tmp_path / "g.tsv", tmp_path / "c.tsv")
    with pytest.raises(SonopackError, match=r"c.tsv:\d+: grain \d+ is 5.* d from the top wall that it touches"):
        Packing.read_tables(tmp_path / "g.tsv", tmp_path / "c.tsv", {"height": piston.height + 5})
