"""modes --stability: the verdict and its numbers against numpy's eigenvalues of a matrix built from the file.

usage: test_stability.py COMMAND SOURCE_DIR
"""
import math

import numpy as np

from command import N200, SOURCE, main, pack, table
from network_oracle import Network


def verdict(*words):
    found = table("modes", *words, "--stability")
    assert found.names == ["verdict", "negative", "flutter", "zero", "softest", "growth", "growth_bound", "error"]
    return found, {name: word if name == "verdict" else float(word) for name, word in found.row().items()}


def reference():
    for prestress in (False, True):
        network = Network(N200, prestress)
        found, row = verdict(N200, *["--prestress"] * prestress)
        assert found.notes["method"] == ("dense" if prestress else "counts") and found.notes["degrees_of_freedom"] == "525"
        squares = np.linalg.eigvals(network.turned / network.mass[:, None])
        assert row["verdict"] == "stable" and row["negative"] == row["flutter"] == row["growth"] == 0
        assert row["zero"] == np.count_nonzero(np.abs(squares) < 1e-9) and np.all(np.abs(squares.imag) < 1e-9)
        assert math.isclose(row["softest"], np.min(squares.real), rel_tol=1e-6 if prestress else 0.02), row
        assert row["error"] < 1e-8 and row["growth_bound"] < 1e-4 and (found.note("skew") > 0) == prestress


def spheres():
    """Spheres with two contacts spin freely: as many zero modes, with prestress and without, and nothing below 0."""
    path = pack("spheres.h5", SOURCE / "packings/spheres.cfg", grains=150, width=5, poisson=0.3)
    plain, (found, loaded) = verdict(path)[1], verdict(path, "--prestress")
    assert plain["verdict"] == loaded["verdict"] == "stable" and plain["zero"] == loaded["zero"], (plain, loaded)
    assert loaded["growth_bound"] < 1e-4 and found.note("skew") > 1e-5 and loaded["softest"] < plain["softest"]


def unbalanced():
    """Without the contacts that carry little the others are no rest: what grows is counted, the verdict says why not."""
    path = pack("loose.h5", "--seed", 3, protocol="quick", grains=80, width=7, friction=0)
    found, row = verdict(path, "--prestress", "--threshold", 0.3)
    assert row["verdict"] == "undecided" and row["negative"] == 2 and row["zero"] == 1 and row["growth"] > 0.01, row
    assert row["growth"] ** 2 < found.note("balance")
    assert verdict(path, "--prestress")[1]["verdict"] == "stable"


main(reference, spheres, unbalanced)
