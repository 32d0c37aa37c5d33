"""modes: parts of the spectrum against all of it, a chain longer than the dense solver takes, and files of vectors.

usage: test_modes.py COMMAND SOURCE_DIR
"""
import pathlib

import numpy as np

from command import N200, N600, main, pack, refused, run, table
from network_oracle import network


def same_rows(part, whole, rows):
    assert np.array_equal(part["n"], whole["n"][rows])
    assert np.all(np.abs(part["omega"] - whole["omega"][rows]) <= part["error"] + whole["error"][rows])
    assert np.all(part["error"] <= 1e-10 * part["omega"])
    if "ab" in part:
        assert np.abs(part["ab"] - whole["ab"][rows]).max() < 1e-6 * np.abs(whole["ab"]).max()


def parts():
    whole = table("modes", N600)
    assert whole.notes["method"] == "dense" and whole.notes["complete"] == "0:inf"
    rattlers, omega = int(whole.notes["rattler_modes"]), whole["omega"]
    for count in (1, 200):
        part = table("modes", N600, "--lowest", count)
        same_rows(part, whole, np.arange(rattlers, rattlers + count))
        low, high = map(float, part.notes["complete"].split(":"))
        assert part.notes["method"] == "sparse" and low == 0
        assert part["omega"][-1] <= high <= omega[rattlers + count] * (1 + 1e-12)
    seed = 4
    print("seed", seed)
    rng = np.random.default_rng(seed)
    for k in range(3):
        low, high = sorted(rng.uniform(0, omega[-1], 2))
        high = min(high, low + 0.1 * omega[-1])
        part = table("modes", N600, "--band", f"{low!r}:{high!r}", *["--frequencies-only"] * (k % 2))
        same_rows(part, whole, np.flatnonzero((omega >= low) & (omega <= high)))
        assert "on_edge" not in part.notes and int(part.notes["rattler_modes"]) == rattlers
    # limits that are frequencies: in the band, and told of
    part = table("modes", N600, "--band", f"{float(omega[500])!r}:{float(omega[520])!r}")
    same_rows(part, whole, np.arange(500, 521))
    assert part.notes["on_edge"] == "2"
    part = table("modes", N600, "--band", f"{1.5 * float(omega[-1])!r}:inf")
    assert len(part) == 0 and part.names == whole.names
    part = table("modes", N600, "--band", "0:0.02", "--frequencies-only")
    assert np.array_equal(part["n"], np.arange(rattlers + 2)) and int(part.notes["zero_modes"]) == rattlers


def chain():
    """More grains than the dense solver takes: omega_n = omega_max sin(n pi/(2(N+1)))."""
    number = 21000
    path = pack("chain.h5", kind="chain", grains=number)
    first, angle = table("modes", path, "--lowest", 30, "--frequencies-only"), np.pi / (2 * (number + 1))
    assert first.notes["zero_modes"] == "0" and first.note("zero_below") < 1e-3 * first["omega"][0]
    top = float(first["omega"][0] / np.sin(angle))
    # top from the first frequency is as good as that; a chain's lowest frequencies are 1e-5 of the highest
    assert np.abs(first["omega"] / (top * np.sin(np.arange(1, 31) * angle)) - 1).max() < 1e-10
    low, high, n = 0.5 * top, 0.502 * top, np.arange(1, number + 1)
    band, exact = table("modes", path, "--band", f"{low!r}:{high!r}"), top * np.sin(n * angle)
    inside = n[(exact >= low) & (exact <= high)]
    assert np.array_equal(band["n"], inside - 1) and np.abs(band["omega"] / exact[inside - 1] - 1).max() < 1e-10


def growing():
    """Prestress and friction: the sum of all motions is the signal of the expansion, also where some grow; without the
    forces that turn, the same modes as ever."""
    pairs = 0
    for dimension, pressure, width in ((2, 1e-2, 10), (3, 1e-2, 5), (2, 1e-4, 10)):
        path = pack(f"grow{dimension}{pressure}.h5", dimension=dimension, pressure=pressure, grains=150, width=width,
                    friction=0.8, protocol="quick")
        for source in ("impulse", "displacement"):
            modes = table("modes", path, "--prestress", "--source", source)
            signal = table("signal", path, "--prestress", "--until", 200, "--source", source)
            t = signal["t"][:, None]
            force = (np.exp(modes["growth"] * t) * (modes["cosine"] * np.cos(modes["omega"] * t) +
                                                    modes["sine"] * np.sin(modes["omega"] * t))).sum(axis=1)
            assert np.abs(force - signal["F"]).max() < 1e-10 * np.abs(signal["F"]).max(), (path, source)
        grow = np.flatnonzero(modes["growth"] > modes["error"])
        verdict = table("modes", path, "--prestress", "--stability")
        assert len(grow) == int(modes.notes["pairs"]) == int(verdict["flutter"][0]), path
        assert np.all(modes["growth"] <= verdict["growth_bound"][0] + modes["error"])
        pairs += len(grow)
        few = table("modes", path, "--prestress", "--frequencies-only")
        assert np.array_equal(few["growth"], modes["growth"]) and "sine" not in few.names
    assert pairs >= 2  # there are motions that grow
    exact, own = np.sort(np.sqrt(network(N200, True).turned_modes[0]).real), table("modes", N200, "--prestress")
    rattlers = int(own.notes["rattler_modes"])
    assert np.abs(own["omega"][rattlers:] - exact).max() < 1e-9 * exact[-1] and not own["omega"][:rattlers].any()
    for word, *words in (("zero", "--lowest=3", "--zero"), ("arpack", "--lowest=3", "--solver=arpack"), ("band", "--band=1:0.5")):
        refused(word, "modes", path, "--prestress", *words)


def lowest_of_growing():
    """The lowest motions of prestress and friction, from a sparse factor, are those of LAPACK within the errors of both,
    with their amplitudes; none is missing, zero motions are left out, and a pair that grows has both its rows."""
    disks = {"dimension": 2, "pressure": 1e-2, "width": 15, "grains": 400}
    walls = {"dimension": 3, "pressure": 1e-2, "width": 5, "grains": 230}
    cell = {"dimension": 3, "pressure": 1e-3, "cell": "periodic", "friction": 0.5, "grains": 200}
    pairs = diverging = 0
    for few, packing, words in ((25, disks, []), (16, disks, ["--threshold=0.18"]), (90, walls, []), (15, cell, [])):
        path = pack("lowest.h5", protocol="quick", **{"friction": 0.8} | packing)
        words = ["modes", path, "--prestress", *words]
        whole, part = table(*words), table(*words, "--lowest", few, "--solver=lanczos")
        assert part.notes["method"] == "sparse" and whole.notes["method"] == "dense", words
        assert part["n"][0] == int(part.notes["zero_motions"]) + int(whole.notes["rattler_modes"])
        # what is 0: at most the imbalance of the forces, far below the lowest omega
        kept = np.hypot(whole["omega"], whole["growth"]) > 1e-4 * whole["omega"][-1]
        of = {name: whole[name][kept][:len(part)] for name in whole.names}
        apart = np.hypot(part["omega"] - of["omega"], part["growth"] - of["growth"])
        assert few <= len(part) <= few + 1 and np.all(apart <= part["error"] + of["error"]), words
        assert np.all(part["error"] < 1e-8), words
        assert packing == cell or np.abs(part["sine"] - of["sine"]).max() < 1e-9 * np.abs(of["sine"]).max(), words
        # up to `complete` the whole table has no other rows
        until = float(part.notes["complete"].split(":")[1])
        assert np.sum(whole["omega"][kept] < until - 1e-9) == len(part), words
        grow = part["growth"] > part["error"]
        assert np.sum(grow) == np.sum(part["growth"] < -part["error"])
        assert np.sum(grow & (part["omega"] > 0)) == int(part.notes["pairs"])
        pairs, diverging = pairs + int(part.notes["pairs"]), diverging + np.sum(grow & (part["omega"] == 0))
    assert pairs > 0 and diverging > 0
    middle = float(part["omega"][9]), float(part["omega"][-3])  # ends in modes: these are inside, and on an edge
    band = table(*words, "--band", "{!r}:{!r}".format(*middle), "--solver=lanczos")
    assert band.notes["method"] == "sparse" and int(band.notes["on_edge"]) >= 2
    inside = (part["omega"] >= middle[0] - 1e-9) & (part["omega"] <= middle[1] + 1e-9)
    assert np.array_equal(band["n"], part["n"][inside]) and float(band.notes["complete"].split(":")[1]) > middle[1]
    dense = table(*words, "--lowest", few, "--solver=dense")
    assert dense.notes["method"] == "dense" and np.array_equal(dense["n"], part["n"])
    assert np.all(np.abs(dense["omega"] - part["omega"]) <= dense["error"] + part["error"])
    assert table(*words, "--lowest", few, "--solver=lanczos", "--threads=2").rows == part.rows
    refused("", "modes", path, "--prestress", "--lowest", 100000)


def overwriting():
    """A packing is never replaced by vectors, nor vectors by a packing, and two outputs never share a file."""
    packing, vectors = pathlib.Path("packing.h5"), pathlib.Path("vectors.h5")
    pack(packing, grains=60, width=8)
    before = packing.read_bytes()
    refused("packing.h5", "modes", packing, "--lowest", 2, "--vectors", packing, "--force")
    run("modes", packing, "--lowest", 2, "--vectors", vectors)
    kept = vectors.read_bytes()
    refused("vectors.h5", "pack", "-o", vectors, "--force")
    refused("", "modes", packing, "--vectors", "t.tsv", "--mode", 90, "-o", "t.tsv")
    assert packing.read_bytes() == before and vectors.read_bytes() == kept and not pathlib.Path("t.tsv").exists()


main(parts, chain, growing, lowest_of_growing, overwriting)
