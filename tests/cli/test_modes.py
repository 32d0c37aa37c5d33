"""sonopack modes: parts of the spectrum against all of it, against closed forms, and what is refused.

usage: test_modes.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
PACKING = SOURCE / "packings" / "reference" / "packing_N600_p1e-4.txt"


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stderr)
    return done


def modes(*args):
    """Comments, and columns as arrays."""
    lines = run("modes", *args).stdout.splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    table = np.array(rows[1:], float).reshape(-1, len(rows[0]))
    return comments, {name: table[:, c] for c, name in enumerate(rows[0])}


def pack(folder, name, *settings):
    path = folder / name
    run("pack", SOURCE / "packings" / "single.cfg", "-q", "-o", path, *(w for s in settings for w in ("--set", s)))
    return path


def same_rows(part, whole, rows):
    assert np.array_equal(part["n"], whole["n"][rows])
    assert np.all(np.abs(part["omega"] - whole["omega"][rows]) <= part["error"] + whole["error"][rows])
    assert np.all(part["error"] <= 1e-10 * part["omega"])
    if "ab" in part:
        scale = np.abs(whole["ab"]).max()
        assert np.abs(part["ab"] - whole["ab"][rows]).max() < 1e-6 * scale


def parts(rng):
    comments, whole = modes(PACKING)
    assert comments["method"] == "dense" and comments["complete"] == "0:inf"
    rattlers = int(comments["rattler_modes"])
    top = whole["omega"][-1]
    for count in (1, 40, 200):
        comments, part = modes(PACKING, "--lowest", count)
        assert comments["method"] == "sparse" and int(comments["zero_modes"]) == rattlers
        same_rows(part, whole, np.arange(rattlers, rattlers + count))
        low, high = map(float, comments["complete"].split(":"))
        assert low == 0 and part["omega"][-1] <= high <= whole["omega"][rattlers + count] * (1 + 1e-12)
    for k in range(6):
        low, high = sorted(rng.uniform(0, top, 2))
        high = min(high, low + 0.1 * top)
        comments, part = modes(PACKING, "--band", f"{low!r}:{high!r}", *["--frequencies-only"][:k % 2])
        same_rows(part, whole, np.flatnonzero((whole["omega"] >= low) & (whole["omega"] <= high)))
        assert "on_edge" not in comments and int(comments["rattler_modes"]) == rattlers
    # limits that are frequencies: in the band, and told of
    low, high = whole["omega"][500], whole["omega"][520]
    comments, part = modes(PACKING, "--band", f"{low!r}:{high!r}")
    same_rows(part, whole, np.arange(500, 521))
    assert comments["on_edge"] == "2"
    comments, part = modes(PACKING, "--band", f"{1.5 * top}:inf")
    assert len(part["n"]) == 0 and list(part) == list(whole)
    comments, part = modes(PACKING, "--band", "0:0.02", "--frequencies-only")
    assert np.array_equal(part["n"], np.arange(rattlers + 2)) and int(comments["zero_modes"]) == rattlers
    print("parts of a spectrum agree with the whole")


def chain(folder):
    """More grains than the dense solver takes: omega_n = omega_max sin(n pi/(2(N+1)))."""
    number = 21000
    path = pack(folder, "chain.h5", 'packing.kind="chain"', "packing.dimension=1", f"packing.grains={number}")
    comments, first = modes(path, "--lowest", 30, "--frequencies-only")
    assert comments["zero_modes"] == "0" and float(comments["zero_below"]) < 1e-3 * first["omega"][0]
    angle = np.pi / (2 * (number + 1))
    top = first["omega"][0] / np.sin(angle)
    exact = top * np.sin(np.arange(1, 31) * angle)
    # top from the first frequency is as good as that; a chain's lowest frequencies are 1e-5 of the highest
    assert np.abs(first["omega"] / exact - 1).max() < 1e-10
    low, high = 0.5 * top, 0.502 * top
    comments, band = modes(path, "--band", f"{low!r}:{high!r}")
    n = np.arange(1, number + 1)
    inside = n[(top * np.sin(n * angle) >= low) & (top * np.sin(n * angle) <= high)]
    assert np.array_equal(band["n"], inside - 1) and comments["method"] == "sparse"
    assert np.abs(band["omega"] / (top * np.sin(inside * angle)) - 1).max() < 1e-10
    print(f"chain of {number}: {len(inside)} modes of a band, all there")


def lattice(folder):
    """Waves to the left and to the right have one frequency."""
    path = pack(folder, "lattice.h5", 'packing.kind="triangular"', "packing.grains=400", "packing.width=20")
    _, whole = modes(path)
    for count in (2, 7, 50):
        _, part = modes(path, "--lowest", count)
        rattlers = len(whole["n"]) - 400 * 3 if len(whole["n"]) > 1200 else 0
        assert np.array_equal(part["n"], whole["n"][rattlers:rattlers + count])
        assert np.all(np.abs(part["omega"] - whole["omega"][rattlers:rattlers + count]) <= 1e-10 * part["omega"])
    pairs = np.sum(np.diff(whole["omega"]) < 1e-10)
    assert pairs > 100, pairs
    print(f"lattice: {pairs} pairs of modes alike")


def overwriting(folder):
    """A packing is never replaced by vectors, nor vectors by a packing, and two outputs never share a file."""
    packing, vectors, table = folder / "packing.h5", folder / "vectors.h5", folder / "one.tsv"
    run("convert", PACKING, packing)
    before = packing.read_bytes()
    run("modes", packing, "--lowest", 2, "--vectors", packing, "--force", status=2)
    assert packing.read_bytes() == before
    run("modes", packing, "--lowest", 2, "--vectors", vectors)
    before = vectors.read_bytes()
    run("convert", PACKING, vectors, "--force", status=2)
    assert vectors.read_bytes() == before
    run("modes", packing, "--vectors", table, "--mode", 200, "-o", table, status=2)
    assert not table.exists()


with tempfile.TemporaryDirectory(prefix="sonopack-modes-") as name:
    SEED = 4
    print("seed", SEED)
    parts(np.random.default_rng(SEED))
    chain(pathlib.Path(name))
    lattice(pathlib.Path(name))
    overwriting(pathlib.Path(name))
