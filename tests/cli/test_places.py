"""signal with places, damping, time steps and nonlinear dynamics against numpy (network_oracle.py), and its command line.

usage: test_places.py COMMAND SOURCE_DIR
"""
import os
import subprocess
import sys
import tempfile

import numpy as np

from network_oracle import Network

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
N200 = os.path.join(SOURCE, "packings", "reference", "packing_N200_p1e-4.txt")
NORMAL, SHEAR = 1, 0


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, timeout=1200)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    if status:
        assert done.stdout == "" and done.stderr.startswith("sonopack"), (words, done.stdout[:200], done.stderr)
    return done.stderr if status else done.stdout


def signal(*words):
    """Comments and columns."""
    comments, rows = {}, []
    for line in run("signal", *words).splitlines():
        if line.startswith("#"):
            key, _, value = line[1:].partition("=")
            comments[key.strip()] = value.strip()
        else:
            rows.append(line.split("\t"))
    values = np.array(rows[1:], dtype=float)
    return comments, {name: values[:, k] for k, name in enumerate(rows[0])}


def responses(network, sources, detectors, t):
    """After momenta, by the modes."""
    root, omega = np.sqrt(network.mass), np.sqrt(network.squares)
    sent = network.vectors.T @ (np.array(sources) / root).T
    seen = network.vectors.T @ (np.array(detectors) / root).T
    waves = np.sin(np.outer(t, omega)) / omega
    return [[(waves * sent[:, a] * seen[:, b]).sum(axis=1) for b in range(seen.shape[1])] for a in range(sent.shape[1])]


def test_places(network):
    t = np.linspace(0, 60, 31)
    sources = [network.wall(-1, NORMAL), network.wall(-1, SHEAR), network.wall(-1, NORMAL, network.part(3, 9))]
    detectors = [network.wall(-2, NORMAL), network.wall(-2, SHEAR), network.wall(-2, SHEAR, network.part(0, 12)),
                 network.plane(4, NORMAL), network.plane(4, SHEAR)]
    words = ["--source", "impulse:normal", "--from", "bottom:shear", "--from", "part:3:9",
             "--detector", "top", "--detector", "shear", "--detector", "part:0:12:shear", "--detector", "plane:4:normal",
             "--detector", "plane:4:shear"]
    exact = responses(network, sources, detectors, t)
    for method, tolerance in (("auto", 1e-10), ("chebyshev", 1e-10), ("dense", 1e-10), ("lax-wendroff", 1e-7),
                              ("verlet", 1e-4), ("faber", 1e-10)):
        comments, f = signal(N200, "--until", 60, "--points", 31, "--method", method, "--tolerance", tolerance, *words)
        assert list(f) == ["t"] + [f"F{k}" for k in range(1, 16)]
        assert method in ("auto", comments["method"])
        for a in range(3):
            for b in range(5):
                name = f"F{5 * a + b + 1}"
                assert comments[name].startswith("from " + ["bottom:normal", "bottom:shear", "part:3:9:normal"][a])
                bound = float(comments[name].rpartition("error ")[2])
                difference = np.max(np.abs(f[name] - exact[a][b]))
                assert difference <= bound + 2e-12 * np.max(np.abs(exact[a][b])), (method, name, difference, bound)
                assert bound <= tolerance * np.max(np.abs(f[name]))
    # a component for all, and planes in equal layers
    comments, f = signal(N200, "--until", 60, "--points", 31, "--component", "shear", "--planes", 2, "--detector", "normal")
    height = network.height
    rows = [network.wall(-2, NORMAL), network.plane(height / 3, SHEAR), network.plane(2 * height / 3, SHEAR)]
    for b, exact in enumerate(responses(network, sources[1:2], rows, t)[0]):
        assert np.max(np.abs(f[f"F{b + 1}"] - exact)) < 1e-11 * np.max(np.abs(exact))
    # columns serve where tables go
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "s.tsv")
        run("signal", N200, "--planes", 40, "-o", table)
        assert "F30" not in run("front", table, "--column", "F30", "--distance", 5).splitlines()[0]
        # a row a plane, with its height
        run("signal", N200, "--planes", 4, "--detector", "top", "--detector", "grain:3", "-o", table, "--force")
        rows = [line.split("\t") for line in run("front", table).splitlines() if line.startswith(table)]
        assert [row[0] for row in rows] == [f"{table}:F{k}" for k in range(1, 7)], rows
        far = {row[0][len(table) + 1:]: float(row[1]) for row in rows}
        assert np.isnan(far["F2"]) and far["F1"] == height
        assert np.allclose([far[f"F{k}"] for k in range(3, 7)], height / 5 * np.arange(1, 5), rtol=1e-14)
        assert rows[3][2:] == run("front", table, "--column", "F4").splitlines()[-1].split("\t")[2:]


def test_damping(network):
    t = np.linspace(0, 80, 41)
    for zeta in (1e-4, 0.05, 1):
        rows = [(network.wall(-2, NORMAL), network.wall(-2, NORMAL, stiffness=zeta * network.c)),
                (network.plane(3, SHEAR), network.plane(3, SHEAR, stiffness=zeta * network.c))]
        comments, f = signal(N200, "--until", 80, "--points", 41, "--damping", zeta, "--detector", "top", "--detector",
                             "plane:3:shear")
        exact = network.damped(zeta, network.source, rows, t)
        assert comments["method"] == "faber" and float(comments["damping"]) == zeta
        for b in range(2):
            assert np.max(np.abs(f[f"F{b + 1}"] - exact[b])) < 1e-10 * np.max(np.abs(exact[b]))
    # modes of the damped motion
    rates = np.linalg.eigvals(network.motion(0.1))
    rates = rates[rates.imag >= 0]
    lines = [line for line in run("modes", N200, "--damping", 0.1).splitlines() if not line.startswith("#")]
    assert lines[0].split("\t") == ["n", "omega", "decay", "cosine", "sine", "error", "Q", "Q_err"]
    ours = np.array([line.split("\t") for line in lines[1:]], dtype=float)
    assert len(ours) == len(rates)
    for rate in rates:
        assert np.min(np.hypot(ours[:, 1] - rate.imag, ours[:, 2] + rate.real)) < 1e-10


def test_dynamics():
    """At small amplitudes the packing's own motion is the linear one, in proportion to the amplitude; contacts at Coulomb's
    limit slide before that, however gently one knocks."""
    words = [N200, "--until", 60, "--points", 61]
    _, linear = signal(*words, "--prestress", "--threshold", 0)
    peak = np.max(np.abs(linear["F"]))
    difference = []
    for amplitude in (1e-2, 1e-3, 1e-6):
        comments, f = signal(*words, "--prestress", "--threshold", 0, "--method", "dynamics", "--amplitude", amplitude)
        difference.append(np.max(np.abs(f["F"] - linear["F"])) / peak)
        assert comments["method"] == "dynamics" and 0 < float(comments["error"]) <= 1e-3 * np.max(np.abs(f["F"]))
        assert float(comments["amplitude"]) > 0 and float(comments["step"]) > 0
    print("dynamics against the linear signal:", *(f"{d:.2g}" for d in difference))
    assert difference[0] > difference[1] > difference[2] and difference[2] < 1e-5


if __name__ == "__main__":
    reference = Network(N200)
    test_places(reference)
    test_damping(reference)
    test_dynamics()
    print("passed")
