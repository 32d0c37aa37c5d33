"""modes --stability: the verdict, its numbers against numpy's eigenvalues of a matrix built from the file, and what it
refuses.

usage: test_stability.py COMMAND SOURCE_DIR
"""
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from network_oracle import Network

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), str(pathlib.Path(sys.argv[2]).resolve())
N200 = os.path.join(SOURCE, "packings", "reference", "packing_N200_p1e-4.txt")


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done.stdout if status == 0 else done.stderr


def verdict(*words):
    """Its comments, and its row by the names of the columns."""
    lines = run("modes", *words, "--stability").splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    header, row = [line.split("\t") for line in lines if not line.startswith("#")]
    assert header == ["verdict", "negative", "flutter", "zero", "softest", "growth", "growth_bound", "error"]
    assert any(line.startswith(f"# {row[0]}: no motion grows faster") for line in lines)
    return comments, {name: word if name == "verdict" else float(word) for name, word in zip(header, row)}


def test_reference():
    for prestress in (False, True):
        network = Network(N200, prestress)
        comments, row = verdict(N200, *["--prestress"][:prestress])
        assert comments["method"] == ("dense" if prestress else "counts") and int(comments["degrees_of_freedom"]) == 525
        squares = np.linalg.eigvals(network.turned / network.mass[:, None])
        assert row["verdict"] == "stable" and row["negative"] == row["flutter"] == row["growth"] == 0
        assert row["zero"] == np.count_nonzero(np.abs(squares) < 1e-9) and np.all(np.abs(squares.imag) < 1e-9)
        assert math.isclose(row["softest"], np.min(squares.real), rel_tol=1e-6 if prestress else 0.02), row
        assert row["error"] < 1e-8 and row["growth_bound"] < 1e-4
        assert (float(comments["skew"]) > 0) == prestress


def test_space():
    """Spheres with two contacts spin freely: as many zero modes, with prestress and without, and nothing below 0."""
    for seed in (1, 2):
        run("pack", os.path.join(SOURCE, "packings", "spheres.cfg"), "--set", "packing.grains=150", "--set",
            "packing.width=5", "--set", f"packing.poisson={0.3 * (seed - 1)}", "--seed", seed, "-q", "-o", f"{seed}.h5")
        _, plain = verdict(f"{seed}.h5")
        comments, loaded = verdict(f"{seed}.h5", "--prestress")
        assert plain["verdict"] == loaded["verdict"] == "stable" and plain["zero"] == loaded["zero"], (plain, loaded)
        assert loaded["growth_bound"] < 1e-4 and float(comments["skew"]) > 1e-5 and loaded["softest"] < plain["softest"]


def test_unbalanced():
    """Without the contacts that carry little the others are no rest: what grows is counted, the verdict says why not."""
    run("pack", "--seed", 3, "-q", "-o", "loose.h5", *(f"--set=packing.{key}" for key in (
        "protocol=quick", "grains=80", "width=7", "friction=0")))
    words = "loose.h5", "--prestress", "--threshold", 0.3
    comments, row = verdict(*words)
    assert row["verdict"] == "undecided" and row["negative"] == 2 and row["zero"] == 1 and row["growth"] > 0.01, row
    assert row["growth"] ** 2 < float(comments["balance"])
    assert "# 2 of the motions that grow are within balance" in run("modes", *words, "--stability")
    assert verdict(*words[:2])[1]["verdict"] == "stable"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        test_reference()
        test_space()
        test_unbalanced()
    print("passed")
