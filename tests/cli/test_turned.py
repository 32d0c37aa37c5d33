"""Packings that are turned as a whole, and packings without walls: the same signal or a refusal, and modes.

usage: test_turned.py COMMAND SOURCE_DIR
"""
import shutil

import h5py
import numpy as np

from command import SOURCE, main, pack, refused, run, table

X, NORMAL, FT = "particles/grains/position/value", "sonopack/contacts/normal", "sonopack/contacts/tangential_force"
EDGES, PAIRS, WALLS = "particles/grains/box/edges", "connectivity/contacts", "sonopack/walls/contacts"
UPRIGHT, TURNED = "upright.h5", "turned.h5"
SEED = int(np.random.SeedSequence().entropy % 2**32)
RNG = np.random.default_rng(SEED)


def change(source, target, matrix, dropped=lambda pairs, x: np.zeros(len(pairs), bool)):
    """A copy that is turned, in a box that is large enough (its height sets no number below), without some contacts."""
    shutil.copy(source, target)
    with h5py.File(target, "r+") as f:
        x, edges = f[X][0], f[EDGES][()]
        pairs, walls = f[PAIRS][()], f[WALLS][()]
        kept = ~dropped(np.concatenate([pairs, walls]), x)
        # contacts across the sides join images: the grains stay where they are, the new box is none of their business
        turned = x @ matrix.T
        replace(f, X, (turned - turned.min(0) + 1)[np.newaxis])
        replace(f, EDGES, np.full(len(edges), 60.0))
        for name in ("normal", "overlap", "normal_force", "tangential_force"):
            data = f["sonopack/contacts/" + name][()]
            replace(f, "sonopack/contacts/" + name, (data @ matrix.T if data.ndim == 2 else data)[kept])
        replace(f, PAIRS, pairs[kept[:len(pairs)]])
        if kept[len(pairs):].any():
            replace(f, WALLS, walls[kept[len(pairs):]])
        else:
            del f["sonopack/walls"]
        if "sonopack/scene" in f:
            del f["sonopack/scene"]
    return target


def replace(f, name, data):
    attributes = dict(f[name].attrs)
    del f[name]
    f[name] = data
    for key, value in attributes.items():
        f[name].attrs[key] = value


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def same(path, *words):
    f, g = (table("signal", p, "--until=100", *words)["F"] for p in (path, TURNED))
    assert np.abs(f - g).max() < 1e-9 * np.abs(f).max(), (words, np.abs(f - g).max() / np.abs(f).max())


def walls_turn_with_the_packing():
    print("seed", SEED)
    pack("flat.h5", grains=200, width=12, seed=2)
    change("flat.h5", UPRIGHT, np.eye(2))
    for angle in [*RNG.uniform(-np.pi, np.pi, 2), np.pi / 2, np.pi, 0.3]:
        change("flat.h5", TURNED, turn(angle))
        for words in [[], ["--prestress"], ["--component=shear"], ["--source=displacement"], ["--damping=0.1"],
                      ["--method=dense"], ["--method=sparse"]][:7 if angle == 0.3 else 3]:
            same(UPRIGHT, *words)
        for words in (["--detector=plane:20"], ["--detector=part:0:20"], ["--method=dynamics"]):
            refused("", "signal", TURNED, "--until=50", *words, status=1)
    # a grain that touches a wall acts along the wall's normal; another has no direction but that of the box
    with h5py.File("flat.h5") as f:
        pairs, walls, held = f[PAIRS][()], f[WALLS][()], f["sonopack/rattler"][()] == 0
    counts = np.bincount(pairs.ravel(), minlength=200)
    inside = next(i for i in np.argsort(-counts) if i not in walls[:, 0] and held[i])
    same(UPRIGHT, "--from", f"grain:{next(i for i, j in walls if j == -1 and held[i])}")
    run("signal", UPRIGHT, "--until=50", "--from", f"grain:{inside}")
    for word in ("--from", "--detector"):
        refused("", "signal", TURNED, "--until=50", word, f"grain:{inside}", status=1)
    modes, other = table("modes", UPRIGHT), table("modes", TURNED)  # so do their modes and weights
    assert np.all(np.abs(modes["omega"] - other["omega"]) <= modes["error"] + other["error"])
    assert np.abs(modes["ab"] - other["ab"]).max() < 1e-6 * np.abs(modes["ab"]).max()


def spheres():
    pack("spheres.h5", SOURCE / "packings/spheres.cfg", grains=60, width=4, protocol="quick")
    change("spheres.h5", UPRIGHT, np.eye(3))
    q, _ = np.linalg.qr(RNG.normal(size=(3, 3)))
    change("spheres.h5", TURNED, q if np.linalg.det(q) > 0 else -q)
    same(UPRIGHT)
    same(UPRIGHT, "--prestress", "--threshold=0")
    refused("", "signal", TURNED, "--until=50", "--component=shear", status=1)  # no direction along the wall is x


def clusters():
    """Without contacts at a wall: modes without amplitudes, the same at any angle, and no signals."""
    for lost, walls in (("a", [-1]), ("b", [-2]), ("ab", [-1, -2])):
        change("flat.h5", "cluster.h5", np.eye(2), lambda pairs, x: np.isin(pairs[:, 1], walls))
        m = table("modes", "cluster.h5")
        assert (m.notes["source"] == "none") == ("a" in lost) and ("detector" in m.notes) == ("b" in lost)
        assert all(np.isnan(m[name]).all() == (name in lost) for name in "ab") and np.isnan(m["ab"]).all()
        assert np.all((m["participation"] > 0) & (m["participation"] <= 1 + 1e-12))
        part, at = table("modes", "cluster.h5", "--lowest=20"), int(m.notes["zero_modes"])
        assert np.array_equal(part["n"], np.arange(at, at + 20))
        assert np.all(np.abs(part["omega"] - m["omega"][at:at + 20]) <= part["error"] + m["error"][at:at + 20])
        for kind in ("dos", "participation"):
            run("spectrum", kind, "cluster.h5")
        for words in ("signal {} --until=10", "signal {} --until=10 --method=dense", "spectrum transmission {}",
                      "spectrum transmission {} --lines"):
            refused("", *words.format("cluster.h5").split(), status=1)


def free():
    """Two translations and a rotation cost no energy, if the periodic contacts are cut as well, at any angle."""
    def cut(pairs, x):
        return (pairs[:, 1] < 0) | (np.abs(x[pairs[:, 0], 0] - x[pairs[:, 1], 0]) > 3)

    zeros = []
    for angle in (0, 1):
        m = table("modes", change("flat.h5", "free.h5", turn(angle), cut))
        zeros.append((int(m.notes["zero_modes"]), int(m.notes["rattler_modes"])))
    assert zeros[0] == zeros[1] and zeros[0][0] - zeros[0][1] >= 3, zeros


main(walls_turn_with_the_packing, spheres, clusters, free)
