"""Statics, prestress and moduli of packings between two rings, against dense matrices and quadratures of this file, and
against Lame's solution of the elastic annulus."""
import math
import os
import subprocess

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sonopack import Packing, Scene, SonopackError
from test_rings import INNER, KN, MATERIAL, OUTER, Annulus, Dense, sonopack

MARGIN = 1.5


@pytest.fixture(scope="module")
def annulus():
    return Annulus()


def packing(annulus, **more):
    c = {"i": annulus.i, "j": annulus.j, "overlap": annulus.overlap, "fn": annulus.kn * annulus.overlap,
         "kn": annulus.kn, "kt": 0.4 * annulus.kn, **more.pop("contacts", {})}
    words = {"box": (2 * OUTER, OUTER - INNER), "pressure": 1e-4, "friction": 0.5, "cell": "ring", **more}
    return Packing.from_arrays(annulus.x + OUTER, annulus.r, c, mass=math.pi * annulus.r**2,
                               inertia=0.5 * math.pi * annulus.r**4, **words)


@pytest.fixture(scope="module")
def plain(annulus):
    return packing(annulus)


@pytest.fixture(scope="module")
def dense(plain):
    return Dense(plain)


def rings_of(dense, motion):
    """Stretches of all springs when a ring's radius grows by 1 (0: inner, 1: outer), or the inner one turns by 1 (2)."""
    wall, m = (dense.j == -1 - (motion == 1)), len(dense.j)
    out = dense.at / np.hypot(*dense.at.T)[:, None]
    moved = INNER * np.stack([-out[:, 1], out[:, 0]], axis=1) if motion == 2 else out
    return np.tile(wall, 2) * (np.tile(moved, (2, 1)) * dense.way).sum(axis=1)


def forces_of(dense, a, b):
    """What ring a feels of motion b."""
    own = rings_of(dense, b)
    u = dense.response(-dense.b.T @ (dense.k * own))
    return rings_of(dense, a) @ (dense.k * (own + dense.b @ u))


@pytest.fixture(scope="module")
def twisted(annulus, plain, dense):
    """With the forces of a small turn of the inner ring in addition: tangential forces, still at rest."""
    own = rings_of(dense, 2)
    force = -2e-3 * dense.k * (own + dense.b @ dense.response(-dense.b.T @ (dense.k * own)))
    m, c = len(dense.j), plain.contacts.copy()
    at = np.flatnonzero(plain.carrying())
    c["fn"][at] += force[:m]
    c["ft"][at, :2] -= force[m:, None] * dense.way[m:]
    assert c["fn"].min() > 0
    return Packing.from_arrays(plain.x, plain.r, c, box=plain.box, pressure=1e-4, friction=0.5, cell="ring",
                               mass=plain.mass, inertia=plain.inertia)


# ---- statics --------------------------------------------------------------------------------------------------------

def test_stresses(twisted, dense):
    """The rings by the forces on them, the mean stress by its definition, both by their balances."""
    s, c = twisted.ring_statics(0), twisted.contacts
    at = twisted.x[c["i"], :2] + (twisted.r[c["i"]] - 0.5 * c["overlap"])[:, None] * c["n"][:, :2] - OUTER
    axes = np.stack([at, np.stack([-at[:, 1], at[:, 0]], axis=1)], axis=1) / np.hypot(*at.T)[:, None, None]
    force = c["fn"][:, None] * c["n"][:, :2] - c["ft"][:, :2]
    branch = (twisted.r[c["i"]] - c["overlap"] + np.where(c["j"] < 0, 0, twisted.r[c["j"]]))[:, None] * c["n"][:, :2]
    tensor = np.einsum("kab,kb,kcd,kd->ac", axes, force, axes, branch) / twisted.volume
    assert (s.s_rr, s.s_tt, s.s_rt) == pytest.approx((tensor[0, 0], tensor[1, 1], 0.5 * (tensor[0, 1] + tensor[1, 0])), rel=1e-9)
    for wall, radius, p, t in ((-1, INNER, s.p_inner, s.t_inner), (-2, OUTER, s.p_outer, s.t_outer)):
        touch = c["j"] == wall
        assert p == pytest.approx(c["fn"][touch].sum() / (2 * math.pi * radius), rel=1e-12)
        around = (force[touch] * axes[touch, 1]).sum() * (-1 if wall == -1 else 1)
        assert t == pytest.approx(around / (2 * math.pi * radius), rel=1e-9)
    assert s.p_outer * OUTER**2 - s.p_inner * INNER**2 == pytest.approx((s.s_rr + s.s_tt) * (OUTER**2 - INNER**2) / 2, rel=1e-3)
    assert s.t_outer * OUTER**2 == pytest.approx(s.t_inner * INNER**2, rel=2e-3) and s.t_inner > 0  # overlaps have no lever
    assert s.t_inner * 2 * math.pi * INNER**2 == pytest.approx(2e-3 * forces_of(dense, 2, 2), rel=1e-9)
    all_of = twisted.statics(0)
    assert all_of.s1_over_s2 == pytest.approx(s.s_tt / s.s_rr) and all_of.s12_over_s2 == pytest.approx(
        -tensor[1, 0] / s.s_rr)
    assert all_of.s_xx + all_of.s_yy == pytest.approx(s.s_rr + s.s_tt, rel=1e-12)


def test_no_contacts(plain):
    s = Packing.from_arrays(plain.x, plain.r, plain.contacts[:0], box=plain.box, pressure=1e-4, friction=0.5, cell="ring").ring_statics()
    assert all(math.copysign(1, value) == 1 and value == 0 for value in (s.p_inner, s.t_outer, s.s_rr, s.s_rt))


def between(r, away, low, high, ball):
    """Area of a disc, or volume of a ball, between two circles: arcs of circles about the centre of the rings."""
    node, weight = np.polynomial.legendre.leggauss(24)
    turn, total = 0.25 * math.pi * (1 + node), 0.0
    low, high = max(low, away - r), min(high, away + r)
    angle = 0.5 * math.pi * (1 + node)
    s, ds = low + (high - low) * np.sin(0.5 * angle)**2, 0.25 * (high - low) * np.sin(angle) * math.pi * weight
    half = np.arccos(np.clip((s**2 + away**2 - r**2) / (2 * s * away), -1, 1))
    if not ball:
        return float((2 * s * half * ds).sum()) if high > low else 0.0
    around = half[:, None] * np.sin(turn)
    deep = r**2 - (s**2 + away**2)[:, None] + 2 * (s * away)[:, None] * np.cos(around)
    total = (2 * np.sqrt(np.maximum(deep, 0)) * np.cos(turn) * 0.25 * math.pi * weight).sum(axis=1)
    return float((2 * s * half * total * ds).sum()) if high > low else 0.0


def test_bulk(plain):
    s, level = plain.statics(margin=MARGIN), np.hypot(*(plain.x[:, :2] - OUTER).T)
    low, high = INNER + MARGIN, OUTER - MARGIN
    area = math.pi * (high**2 - low**2)
    rows = list(zip(plain.r.tolist(), level.tolist(), plain.rattlers().tolist()))
    assert s.phi2 == pytest.approx(sum(between(r, a, low, high, False) for r, a, _ in rows) / area, rel=1e-5)
    assert s.phi3 == pytest.approx(sum(between(r, a, low, high, True) for r, a, _ in rows) / area, rel=1e-5)
    assert s.phi3s == pytest.approx(sum(between(r, a, low, high, True) for r, a, loose in rows if not loose) / area, rel=1e-5)
    c, inside = plain.contacts[plain.carrying()], (level >= low) & (level <= high)
    z = np.bincount(c["i"], minlength=plain.n) + np.bincount(c["j"][c["j"] >= 0], minlength=plain.n)
    held = inside & ~plain.rattlers()
    assert s.zs == pytest.approx(z[held].mean()) and s.f0 == pytest.approx(100 * (1 - held.sum() / inside.sum()))
    at = plain.x[c["i"], :2] + (plain.r[c["i"]] - 0.5 * c["overlap"])[:, None] * c["n"][:, :2] - OUTER
    here = (np.hypot(*at.T) >= low) & (np.hypot(*at.T) <= high)
    up = ((at * c["n"][:, :2]).sum(axis=1) / np.hypot(*at.T))[here]
    assert s.f2 == pytest.approx((up**2).mean()) and s.n_over_p == pytest.approx(c["fn"][here].mean() / plain.pressure)


def test_bulk_of_wide_rings():
    """A disc on a circle of 8000 diameters: half of it is inside, but for the curve."""
    r, inner, gap = 0.5, 7990.0, 20.0
    p = Packing.from_arrays([[2 * inner + gap + 5, inner + gap]], [r], {"i": [0], "j": [-1], "overlap": [1e-9]}, box=(2 * (inner + gap), gap),
                            pressure=1e-6, friction=0, cell="ring")
    low, high = inner + 5, inner + gap - 5
    inside = p.statics(margin=5, threshold=0).phi2 * (high**2 - low**2) / r**2
    assert inside == pytest.approx(0.5 + r / (3 * math.pi * low), abs=1e-9)


# ---- prestress ------------------------------------------------------------------------------------------------------

def forces(p, u):
    """Forces and torques on the grains that move by u [n][3] from rest: normal ones follow the distance, tangential ones
    turn with the normal and add kt times the motion at the contact; a ring acts along its radius."""
    c, x, r = p.contacts, p.x[:, :2] - OUTER, p.r
    i, j, wall = c["i"], c["j"], c["j"] < 0
    other, r_other = np.where(wall, 0, j), np.where(wall, 0, p.r[j])
    side = np.where(j == -2, 1.0, -1.0)[:, None]

    def normal(at):
        away = np.where(wall[:, None], side * at[i], at[other] - at[i])
        return away / np.hypot(*away.T)[:, None]

    def gap(at):
        away = np.hypot(*at[i].T)
        return np.where(wall, np.where(j == -2, OUTER - away, away - INNER), np.hypot(*(at[other] - at[i]).T))

    n0, n1 = normal(x), normal(x + u[:, :2])
    t0, t1 = (np.stack([-n[:, 1], n[:, 0]], axis=1) for n in (n0, n1))
    slip = ((np.where(wall[:, None], 0, u[other, :2]) - u[i, :2]) * t0).sum(axis=1) - r[i] * u[i, 2] - r_other * np.where(wall, 0, u[other, 2])
    normal_force = c["fn"] - c["kn"] * (gap(x + u[:, :2]) - gap(x))
    side_force = (c["ft"][:, :2] * t0).sum(axis=1) + c["kt"] * slip
    f = -normal_force[:, None] * n1 + side_force[:, None] * t1
    total = np.zeros((p.n, 3))
    np.add.at(total[:, :2], i, f)
    np.add.at(total[:, :2], other[~wall], -f[~wall])
    np.add.at(total[:, 2], i, r[i] * side_force)
    np.add.at(total[:, 2], other[~wall], (r_other * side_force)[~wall])
    return total


def test_prestress_is_the_derivative_of_the_forces(twisted):
    network, step = twisted.network(prestress=True, threshold=0), 1e-6
    rng, moved = np.random.default_rng(1), np.zeros((twisted.n, 3))
    moved[network.grain] = rng.normal(size=(len(network.grain), 3))
    change = (forces(twisted, -step * moved) - forces(twisted, step * moved)) / (2 * step)
    found, without = (net.apply(moved[network.grain]) for net in (network, twisted.network(threshold=0)))
    assert np.abs(found - change[network.grain]).max() < 1e-6 * np.abs(found).max()
    assert np.abs(without - change[network.grain]).max() > 1e-3 * np.abs(found).max()
    assert np.allclose(network.K() @ moved[network.grain].ravel(), found.ravel(), rtol=0, atol=1e-12)
    assert np.allclose(network.K().T @ moved[network.grain].ravel(), network.apply_transposed(moved[network.grain]).ravel(), atol=1e-12)


def test_smooth_grains_turn_as_a_whole(annulus):
    """Which no force at rest resists, if and only if the terms of the rings are right."""
    p = packing(annulus, friction=0, contacts={"kt": 0 * annulus.kn})
    network = p.network(prestress=True, threshold=0)
    x = network.x[:, :2] - OUTER
    turned = network.apply(np.stack([-x[:, 1], x[:, 0]], axis=1))
    assert np.abs(turned).max() < 1e-10 < 1e-6 < np.abs(p.contacts["fn"]).max()
    assert network.modes(lowest=1).zero.total == 1


@pytest.mark.parametrize("load, axis", [("strain", 0), ("strain", 2), ("dipole", 0)])
def test_responses_of_smooth_grains_do_not_turn(annulus, load, axis):
    """The turn of the whole is free; the one is given whose mean angle stays."""
    p = packing(annulus, friction=0, contacts={"kt": 0 * annulus.kn})
    network = p.network()
    u, x = network.respond(load, 20 * (load == "dipole"), axis).u.reshape(-1, 2), network.x[:, :2] - OUTER
    around = (x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0]) * network.mass[:, 0]
    assert abs(around.sum()) < 1e-12 * np.abs(around).sum() != 0


@pytest.mark.parametrize("which", ["plain", "twisted"])
def test_signals_under_prestress(which, request):
    """By the eigenvectors of the dense matrix, which is not symmetric where tangential forces are carried."""
    network, t = request.getfixturevalue(which).network(prestress=True), np.linspace(0, 150, 61)
    root = np.sqrt(network.mass.ravel())
    square, right = np.linalg.eig(network.K().toarray() / root[:, None] / root)
    source, detector = network.source() / root.reshape(network.mass.shape), network.detector() / root.reshape(network.mass.shape)
    parts = (detector.ravel() @ right) * np.linalg.solve(right, source.ravel())
    omega = np.sqrt(square.astype(complex))
    exact = (np.sin(np.outer(t, omega)) @ (parts / omega)).real
    found = network.signal(until=150, points=61, method="chebyshev").F
    assert np.abs(found - exact).max() < 1e-7 * np.abs(exact).max()


# ---- moduli ---------------------------------------------------------------------------------------------------------

def test_imposed_strain(plain, dense):
    e = plain.network().elasticity()
    for row, strain in enumerate((np.diag((1.0, 0.0)), np.diag((0.0, 1.0)), np.array(((0.0, 1.0), (0.0, 0.0))))):
        assert abs(e.c[row, row] - dense.modulus(strain.T)) < e.error[row, row] + 1e-10 * e.c[0, 0]
    both = dense.modulus(np.eye(2))
    assert e.bulk == pytest.approx(both / 4, rel=1e-8) and e.bulk_error < 1e-6 * e.bulk


@pytest.mark.parametrize("prestress", [False, True])
def test_rings_that_grow_and_turn(twisted, prestress):
    network, exact = twisted.network(prestress=prestress), Dense(twisted)
    m, at = network.ring_moduli(), (3 * network.grain[:, None] + np.arange(3)).ravel()
    inverse = np.linalg.inv(network.K().toarray())
    exact.response = lambda load: np.bincount(at, inverse @ load[at], 3 * twisted.n)  # under prestress, too
    p_inner, p_outer = forces_of(exact, 0, 0) / (2 * math.pi), -forces_of(exact, 1, 0) * INNER / (2 * math.pi * OUTER)
    assert (m.p_inner, m.p_outer) == pytest.approx((p_inner, p_outer), rel=1e-8)
    assert m.torque == pytest.approx(forces_of(exact, 2, 2), rel=1e-8)
    ratio = (OUTER / INNER)**2
    assert p_inner == pytest.approx(2 * (m.bulk + m.shear * ratio) / (ratio - 1), rel=1e-8)
    assert p_outer == pytest.approx(2 * (m.bulk + m.shear) / (ratio - 1), rel=1e-8)
    assert m.shear_turn == pytest.approx(m.torque * (1 / INNER**2 - 1 / OUTER**2) / (4 * math.pi), rel=1e-12)
    assert 0 < m.error_bulk < 1e-6 * m.bulk and 0 < m.error_shear < 1e-6 * m.shear and 0 < m.error_shear_turn < 1e-6 * m.shear_turn


def test_torque_is_a_force_times_a_length(plain):
    """A layer of larger grains under the same stress, as seen in the same units."""
    size, c = 3.0, plain.contacts.copy()
    for name, power in (("overlap", 1), ("fn", 2), ("ft", 2), ("kn", 1), ("kt", 1)):
        c[name] *= size**power
    large = Packing.from_arrays(size * plain.x, size * plain.r, c, box=[size * edge for edge in plain.box], pressure=1e-4, friction=0.5,
                                cell="ring", material=MATERIAL)
    m = large.network().ring_moduli()
    assert m.torque == pytest.approx(size**3 * plain.network().ring_moduli().torque, rel=1e-9)
    assert m.si().torque == pytest.approx(m.torque * 1e9 * MATERIAL.diameter**3, rel=1e-12)  # N m


def lattice(inner, outer, kt):
    """Rolling grains of a triangular lattice, of K = sqrt(3)/2 kn and G = sqrt(3)/4 (kn + kt), and the rings near them."""
    rows = int(outer / math.sqrt(0.75)) + 1
    x = np.array([(a + 0.5 * (b % 2), math.sqrt(0.75) * b) for b in range(-rows, rows + 1) for a in range(-int(outer) - 1, int(outer) + 2)])
    away = np.hypot(*x.T)
    inside = (away > inner + 0.3) & (away < outer - 0.3)
    x, away = x[inside], away[inside]
    i, j = cKDTree(x).query_pairs(1.001, output_type="ndarray").T
    low, high = np.flatnonzero(away < inner + 1.2), np.flatnonzero(away > outer - 1.2)
    j = np.r_[j, np.full(len(low), -1), np.full(len(high), -2)]
    kn = np.where(j < 0, 2.0, 1.0)
    contacts = {"i": np.r_[i, low, high], "j": j, "overlap": 1e-9 * kn, "fn": 1e-6 * kn, "kn": kn, "kt": kt * kn}
    return Packing.from_arrays(x + outer, np.full(len(x), 0.5), contacts, box=(2 * outer, outer - inner), pressure=1e-6,
                               friction=0.5, cell="ring")


def test_continuum():
    """Of larger and larger rings of a lattice: K and G by growth, G by the torque, and K and G of an imposed strain tend to
    those of the continuum as 1/size, since layers at the rings differ."""
    exact = np.array([2.0, 1.3, 1.3, 2.0, 1.3]) * math.sqrt(3) / 4
    for size in (1, 2, 4):
        network = lattice(6.0 * size, 15.0 * size, 0.3).network(threshold=0)
        m, e = network.ring_moduli(), network.elasticity()
        off = np.array([m.bulk, m.shear, m.shear_turn, e.bulk, e.shear]) / exact - 1
        assert (np.abs(off) < np.array([0.1, 0.1, 0.45, 0.2, 0.25]) / size).all(), off
        assert e.anisotropy < 0.1 / size


def test_commands(plain, tmp_path):
    plain.save(tmp_path / "p.h5")
    tables = [sonopack(*words, tmp_path / "p.h5") for words in (("statics", ), ("moduli", ), ("moduli", "--probe", "rings", "--prestress"))]
    for table, found in zip(tables, (plain.ring_statics(), plain.network().moduli(), plain.network(prestress=True).ring_moduli())):
        rows = [line.split("\t") for line in table.splitlines() if not line.startswith("#")]
        row = dict(zip(rows[0], rows[-1]))
        for name in ("p_inner", "s_rt", "c22", "bulk", "torque"):
            if hasattr(found, name):
                assert float(row[{"bulk": "K"}.get(name, name.replace("c22", "C22"))]) == pytest.approx(getattr(found, name), rel=1e-5)


def test_after_another_cell(plain, tmp_path):
    """A packing without rings is refused, and those after it are not."""
    Packing.make(Scene(packing={"grains": 80, "width": 8, "seed": 3})).save(tmp_path / "piston.h5")
    plain.save(tmp_path / "p.h5")
    ran = subprocess.run([os.environ["SONOPACK"], "moduli", "--probe", "rings", "--units", "si", "--material", "E=0.75e9,nu=0.5,rho=1000,d=1e-2",
                          tmp_path / "piston.h5", tmp_path / "p.h5"], text=True, capture_output=True)
    rows = [line.split("\t") for line in ran.stdout.splitlines() if not line.startswith("#")]
    assert ran.returncode == 1 and "must be a ring" in ran.stderr and len(rows) == 2
    assert "torque [N mm]" in ran.stdout
    assert float(rows[1][rows[0].index("torque")]) == pytest.approx(1e6 * plain.network().ring_moduli().torque, rel=1e-5)


def test_other_cells():
    p = Packing.from_arrays([[0.5, 0.5], [0.5, 1.4]], [0.5, 0.5], {"i": [0, 0, 1], "j": [1, -1, -2], "overlap": [0.1, 0.1, 0.1]},
                            box=(4.0, 1.8), pressure=1e-2, friction=0.5)
    with pytest.raises(SonopackError, match="must be a ring"):
        p.ring_statics()
    with pytest.raises(SonopackError, match="must be a ring"):
        p.network(threshold=0).ring_moduli()
