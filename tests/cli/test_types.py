"""Grains of several materials, and disks: forces, stiffnesses and masses by the formulas of Hertz and Mindlin for E, nu and
rho of each grain, balance, frequencies against a dense matrix of numpy, and what is refused.

usage: test_types.py COMMAND SOURCE_DIR
"""
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's threads wait for each other where others are at work

import h5py  # noqa: E402
import numpy as np  # noqa: E402

from command import main, pack, refused, run, sets, table  # noqa: E402

THREE = {"types.fraction": [0.5, 0.3, 0.2], "types.modulus": [1, 0.2, 3], "types.poisson": [0.3, 0, 0.45],
         "types.density": [1, 0.4, 3], "types.friction": [0.5, 0.3, 0, 0.2, 0.4, 0.1]}
PAIRS = {frozenset(pair): mu for pair, mu in zip([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)], THREE["types.friction"])}


class File:
    def __init__(self, path):
        with h5py.File(path) as file:
            grains, contacts = file["/particles/grains"], file["/sonopack/contacts"]
            self.x, self.r, self.mass = grains["position/value"][0], grains["radius"][:], grains["mass"][:]
            self.species = grains["species"][:] if "species" in grains else np.zeros(len(self.r), int)
            self.inertia = grains["inertia"][:] if "inertia" in grains else 0.4 * self.mass * self.r**2
            self.ends = file["/connectivity/contacts"][:]
            if "/sonopack/walls" in file:
                self.ends = np.concatenate([self.ends, file["/sonopack/walls/contacts"][:]])
            self.n, self.overlap, self.fn, self.ft, self.kn, self.kt, self.mu = (
                contacts[name][:] if name in contacts else None for name in (
                    "normal", "overlap", "normal_force", "tangential_force", "normal_stiffness", "tangential_stiffness",
                    "friction"))
            self.pressure = float(file["/sonopack/pressure"][()])
        self.dim = self.n.shape[1]


def check_contacts(f, exponent=1.5):
    """By E and nu of each grain (E* = E/(1 - nu^2)), as in Johnson's book: k_n = 2 E12 a, k_t = 8 G12 a, a^2 = R12 n."""
    modulus, nu = np.array(THREE["types.modulus"]), np.array(THREE["types.poisson"])
    young = modulus * (1 - nu**2)
    shear = young / (2 * (1 + nu))
    s, walls = f.species[f.ends[:, 0]], f.ends[:, 1] < 0
    t = np.where(walls, s, f.species[f.ends[:, 1]])
    ri, rj = f.r[f.ends[:, 0]], np.where(walls, np.inf, f.r[f.ends[:, 1]])
    e12 = 1 / ((1 - nu[s]**2) / young[s] + np.where(walls, 0, (1 - nu[t]**2) / young[t]))
    g12 = 1 / ((2 - nu[s]) / shear[s] + np.where(walls, 0, (2 - nu[t]) / shear[t]))
    r12 = 1 / (1 / ri + 1 / rj)
    a = np.where(walls, 1.5, exponent)
    fn = 4 / 3 * e12 * r12**(2 - a) * f.overlap**a
    mu = np.array([PAIRS[frozenset((int(one), int(two)))] for one, two in zip(s, t)])
    np.testing.assert_allclose(f.fn, fn, rtol=1e-13)
    np.testing.assert_allclose(f.kn, a * fn / f.overlap, rtol=1e-13)
    np.testing.assert_allclose(f.kt, np.where(mu > 0, 4 * g12 / e12 * f.kn, 0), rtol=1e-12)
    np.testing.assert_array_equal(f.mu, mu)
    assert np.all(np.linalg.norm(f.ft, axis=1) <= mu * f.fn * (1 + 1e-12))
    assert np.any(np.linalg.norm(f.ft, axis=1) > 0.2 * mu.max() * f.fn)


def check_balance(f):
    force = np.zeros((len(f.r), f.dim))
    turn = np.zeros((len(f.r), 3))
    for (i, j), n, fn, ft in zip(f.ends, f.n, f.fn, f.ft):
        push = ft - fn * n
        moment = np.cross(np.pad(n, (0, 3 - f.dim)), np.pad(ft, (0, 3 - f.dim)))
        force[i] += push
        turn[i] += moment
        if j >= 0:
            force[j] -= push
            turn[j] += moment
    assert np.abs(force).max() < 1e-5 * f.pressure and np.abs(turn).max() < 1e-5 * f.pressure


def frequencies(f, threshold=1e-4):
    """All of the network without rattlers, from a dense matrix."""
    keep = f.fn > threshold * f.pressure
    while True:
        count = np.bincount(f.ends[keep][f.ends[keep] >= 0], minlength=len(f.r))
        worse = keep & ((count[f.ends[:, 0]] < 2) | ((f.ends[:, 1] >= 0) & (count[f.ends[:, 1]] < 2)))
        if not worse.any():
            break
        keep &= ~worse
    width = 3 if f.dim == 2 else 6
    k = np.zeros((width * len(f.r),) * 2)
    for c in np.flatnonzero(keep):
        i, j = f.ends[c]
        axes = np.linalg.svd(f.n[c][None])[2]
        for axis, stiffness in zip(axes, [f.kn[c]] + [f.kt[c]] * (f.dim - 1)):
            row = np.zeros(width * len(f.r))
            for end, sign, arm in ((i, -1, f.r[i]), (j, 1, -f.r[j] if j >= 0 else 0)):
                if end < 0:
                    continue
                row[width * end:width * end + f.dim] += sign * axis
                lever = np.cross(np.pad(arm * f.n[c], (0, 3 - f.dim)), np.pad(axis, (0, 3 - f.dim)))
                row[width * end + f.dim:width * end + width] += sign * (lever if f.dim == 3 else lever[2:])
            k += stiffness * np.outer(row, row)
    mass = np.repeat(np.column_stack([f.mass, f.inertia]), [f.dim, width - f.dim], axis=1).ravel()
    alive = np.repeat(count >= 2, width)
    root = 1 / np.sqrt(mass[alive])
    return np.sqrt(np.abs(np.linalg.eigvalsh(k[np.ix_(alive, alive)] * np.outer(root, root))))


def check_modes(path, f):
    found, true = table("modes", path)["omega"], frequencies(f)
    rattlers = len(found) - len(true)
    assert rattlers >= 0 and np.all(found[:rattlers] == 0)
    np.testing.assert_allclose(found[rattlers:], true, atol=1e-7 * true[-1])


def three_materials():
    cases = (("disks", dict(grains=150, width=12)), ("periodic", dict(grains=150, cell="periodic", pressure=1e-3)),
             ("spheres", dict(grains=90, width=5, dimension=3, pressure=1e-3, sizes="types", **{"types.diameter": [1, 0.9, 1.2]})),
             ("harmonic", dict(grains=120, cell="periodic", pressure=1e-3, **{"law.exponent": 1})))
    for name, keys in cases:
        f = File(pack(f"{name}.h5", friction=0.5, seed=4, **THREE, **keys))
        n = len(f.r)
        assert [int(np.sum(f.species == t)) for t in range(3)] == [n // 2, round(0.3 * n), n - n // 2 - round(0.3 * n)]
        np.testing.assert_allclose(f.mass, np.array(THREE["types.density"])[f.species] * 4 / 3 * np.pi * f.r**3, rtol=1e-14)
        if name == "spheres":
            np.testing.assert_array_equal(2 * f.r, np.array(keys["types.diameter"])[f.species])
        check_contacts(f, 1 if name == "harmonic" else 1.5)
        check_balance(f)
        check_modes(f"{name}.h5", f)
        assert table("check", f"{name}.h5").words("ok") == ["yes"]


def alike():
    """Materials that do not differ make the packing of one: other code, the same bits."""
    same = {"types.fraction": [0.3, 0.7], "types.modulus": [1, 1], "types.poisson": [0.2, 0.2], "types.density": [1, 1],
            "types.friction": [0.5, 0.5, 0.5]}
    for keys in (dict(grains=80, width=8), dict(grains=60, width=5, dimension=3, pressure=1e-3)):
        one, two = (File(pack("same.h5", friction=0.5, poisson=0.2, **more, **keys)) for more in ({}, same))
        assert one.kn is None and two.species.max() == 1
        for name in ("x", "r", "mass", "ends", "n", "fn", "ft"):
            np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def soft_as_hard():
    """At one p/E* soft grains are pressed as much as hard ones: the piston must not arrive faster than they bear."""
    hard, soft = (File(pack("soft.h5", grains=200, width=10, pressure=p, **{"types.fraction": [1], "types.modulus": [modulus]}))
                  for p, modulus in ((1e-2, 1), (2e-4, 0.02)))
    assert abs(soft.overlap.mean() / hard.overlap.mean() - 1) < 0.1


def disks():
    """The mass of a disk is rho pi R^2 d, and I = m R^2/2; the gas is the same, the motion another."""
    f = File(pack("disk.h5", grains=100, width=10, shape="disk", friction=0.3, **{"types.fraction": [0.5, 0.5],
                                                                                  "types.density": [1, 2],
                                                                                  "types.modulus": [1, 1]}))
    np.testing.assert_allclose(f.mass, np.pi * f.r**2 * (1 + f.species), rtol=1e-14)
    np.testing.assert_allclose(f.inertia, 0.5 * f.mass * f.r**2, rtol=1e-14)
    check_balance(f)
    check_modes("disk.h5", f)


def minima():
    keys = dict(kind="minimum", cell="periodic", friction=0, grains=100, pressure=1e-3, **{
        key: THREE[key] for key in ("types.fraction", "types.modulus", "types.density")})
    f = File(pack("minimum.h5", **keys))
    check_balance(f)
    modulus = np.array(THREE["types.modulus"])[f.species[f.ends]]
    e12 = 1 / (1 / modulus).sum(axis=1)
    r12 = 1 / (1 / f.r[f.ends]).sum(axis=1)
    np.testing.assert_allclose(f.fn, 4 / 3 * e12 * np.sqrt(r12) * f.overlap**1.5, rtol=1e-13)


def commands_take_them():
    pack("mixed.h5", grains=100, width=10, friction=0.5, seed=2, **THREE)
    for words in ("statics", "moduli", "signal", "front", "respond --strain xy --contacts", "clusters",
                  "modes --prestress --lowest 5", "sensitivity --by kn,kt", "uncertainty --force 0.1 --position 1e-4",
                  "design --goal delay", "coda --trials 1"):
        command, *rest = words.split()
        assert len(table(command, "mixed.h5", *rest, status=0)) > 0, words
    run("convert", "mixed.h5", "mixed.vtp")
    refused("law", "signal", "mixed.h5", "--method", "dynamics", status=1)


def wrong_ones_are_refused():
    two = {"types.fraction": [0.5, 0.5]}
    for names, keys in (
            ("types.fraction 0.9 1", {"types.fraction": [0.5, 0.4]}),
            ("types.modulus 3 2", {**two, "types.modulus": [1, 2, 3]}),
            ("types.modulus 0", {**two, "types.modulus": [1, 0]}),
            ("types.modulus nan", {**two, "types.modulus": "[1, nan]"}),
            ("types.density 2 0", {"types.density": [1, 2]}),
            ("types.friction 2 3", {**two, "types.friction": [0.5, 0.1]}),
            ("packing.friction 0.5 0.3", {**two, "types.friction": [0.3, 0.2, 0.1]}),
            ("types.diameter types", {**two, "sizes": "types"}),
            ("sizes types", {**two, "types.diameter": [1, 2]}),
            ("diameter_min 0.8", {**two, "types.diameter": [1, 2], "sizes": "types", "diameter_min": 0.8, "diameter_max": 1.2}),
            ("types.fraction 9 8", {"types.fraction": [0.12] * 8 + [0.04]}),
            ("types.fraction piston", {**two, "kind": "triangular", "grains": 80, "width": 8}),
            ("packing.shape sphere", {"shape": "disk", "dimension": 3, "width": 5}),
            ("tangential constant", {**two, "types.modulus": [1, 2], "tangential": "history"})):
        refused(names, "pack", *sets(**keys), "-o", "no.h5")
    refused("types.fraction lammps", "pack", *sets(**two), "--engine", "lammps", "--prepare", "in")
    pack("from.h5", grains=60, width=8)
    refused("types piston", "pack", *sets(**two, kind="file", file="from.h5"), "-o", "no.h5")
    smooth = dict(kind="minimum", cell="periodic", friction=0, pressure=1e-3)
    pack("from.h5", grains=60, **smooth, **two, **{"types.modulus": [1, 0.2]})
    refused("several one material", "pack", *sets(**smooth, file="from.h5"), "-o", "no.h5")


main(three_materials, alike, soft_as_hard, disks, minima, commands_take_them, wrong_ones_are_refused)
