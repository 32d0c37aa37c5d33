#!/usr/bin/env python3
"""sonopack spectrum continuum against numpy: frequencies of the strip by collocation, modes of the packing dense.
Usage: test_continuum.py COMMAND SOURCE_DIR"""
import os
import subprocess
import sys
import tempfile

import numpy as np
import scipy.interpolate
import scipy.linalg

from network_oracle import Network

COMMAND, SOURCE = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
N600 = os.path.join(SOURCE, "packings/reference/packing_N600_p1e-4.txt")
FOLDER = tempfile.TemporaryDirectory()


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, cwd=FOLDER.name, timeout=1200)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done.stdout, done.stderr


def collocation(n):
    """Chebyshev points on -1 .. 1 and the matrix of the derivative there."""
    x = np.cos(np.pi * np.arange(n + 1) / n)
    c = np.where((np.arange(n + 1) == 0) | (np.arange(n + 1) == n), 2.0, 1.0) * (-1.0) ** np.arange(n + 1)
    d = np.outer(c, 1 / c) / (x[:, None] - x[None, :] + np.eye(n + 1))
    return x, d - np.diag(d.sum(axis=1))


def strip(c, density, width, height, n1, n=60):
    """(v, w) of u = (v cos, -w sin)(k1 x) at the points, and omega, ascending."""
    x, d = collocation(n)
    d = d * 2 / height
    k1, inner = 2 * np.pi * n1 / width, slice(1, n)
    second, first, one = (d @ d)[inner, inner], d[inner, inner], np.eye(n - 1)
    matrix = np.block([[c["C11"] * k1**2 * one - c["C33"] * second, k1 * (c["C12"] + c["C33"]) * first],
                       [-k1 * (c["C12"] + c["C33"]) * first, c["C33"] * k1**2 * one - c["C22"] * second]]) / density
    squares, vectors = scipy.linalg.eig(matrix)
    order = np.argsort(squares.real)
    return (x[inner] + 1) * height / 2, np.sqrt(squares.real[order]), vectors.real[:, order]


def test_table():
    text, _ = run("spectrum", "continuum", N600, "--lowest", 5)
    comments = dict(line[2:].split(" = ") for line in text.splitlines() if line.startswith("# ") and " = " in line)
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert lines[0] == "n omega n1 n2 branch omega_plane omega_continuum ratio overlap".split()
    rows = [dict(zip(lines[0], line)) for line in lines[1:]]
    network = Network(N600)
    c, density = {name: float(comments[name]) for name in ("C11", "C12", "C22", "C33")}, float(comments["Phi3s"])
    exact = network.moduli()
    assert np.allclose([c["C11"], c["C12"], c["C22"], c["C33"]],
                       [exact[0, 0], exact[0, 1], exact[1, 1], exact[2, 2]], rtol=1e-9)
    frequencies = network.frequencies()
    mass = network.mass.reshape(-1, 3)[:, 0]
    assert len(rows) == 5
    for k, row in enumerate(rows):
        assert int(row["n"]) == 3 * network.rattlers + k
        assert np.isclose(float(row["omega"]), frequencies[k], rtol=1e-8)
        n1, n2 = int(row["n1"]), int(row["n2"])
        k1, k2 = 2 * np.pi * n1 / network.width, np.pi * n2 / network.height
        tensor = np.array([[c["C11"] * k1**2 + c["C33"] * k2**2, (c["C12"] + c["C33"]) * k1 * k2],
                           [(c["C12"] + c["C33"]) * k1 * k2, c["C33"] * k1**2 + c["C22"] * k2**2]])
        plane = np.sqrt(np.linalg.eigvalsh(tensor) / density)[int(row["branch"] == "+")]
        assert np.isclose(float(row["omega_plane"]), plane, rtol=1e-10)
        y, omega, vectors = strip(c, density, network.width, network.height, n1)
        at = np.argmin(np.abs(omega - float(row["omega_continuum"])))
        assert np.isclose(omega[at], float(row["omega_continuum"]), rtol=1e-8)
        assert np.isclose(float(row["ratio"]), frequencies[k] / omega[at], rtol=1e-7)
        # overlap: the mode on the span of the strip's two fields at the grains' centres
        half = len(y)
        field = scipy.interpolate.BarycentricInterpolator(
            np.concatenate([[0], y[::-1], [network.height]]),
            np.column_stack([np.concatenate([[0], part[::-1], [0]]) for part in (vectors[:half, at],
                                                                                 vectors[half:, at])]))
        v, w = field(network.centre[:, 1]).T
        phase = k1 * network.centre[:, 0]
        fields = [np.column_stack([v * np.cos(phase), -w * np.sin(phase) if n1 else w])]
        if n1:
            fields.append(np.column_stack([v * np.sin(phase), w * np.cos(phase)]))
        span = scipy.linalg.orth(np.array([(np.sqrt(mass)[:, None] * f).ravel() for f in fields]).T)
        mode = network.vectors[:, k].reshape(-1, 3)[:, :2].ravel()
        assert np.isclose(float(row["overlap"]), np.sum((span.T @ mode)**2), rtol=1e-5), row


if __name__ == "__main__":
    test_table()
    print("ok")
