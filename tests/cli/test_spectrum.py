#!/usr/bin/env python3
"""spectrum against numpy on dense matrices, built here anew from the packing file, and against the closed forms of
lattices. Usage: test_spectrum.py COMMAND SOURCE_DIR"""
import os
import tempfile

import numpy as np
import scipy.linalg

from network_oracle import Network
from test_signal import N200, columns, run, table


class Waves(Network):
    """The network with positions and dashpots."""

    def __init__(self, path):
        super().__init__(path)
        lines = open(path).read().splitlines()
        n = int(dict(zip(*[iter(lines[1].split())] * 2))["N"])
        grains = np.array([line.split() for line in lines[2:2 + n]], dtype=float)
        # grains that carry are those whose mass is in the list, in order
        mass = 4 / 3 * np.pi * grains[:, 2] ** 3
        kept, k = [], 0
        for i in range(n):
            if k < len(self.mass) and np.isclose(mass[i], self.mass[k], rtol=1e-14):
                kept.append(i)
                k += 3
        assert 3 * len(kept) == len(self.mass)
        self.x = grains[kept, :2]

    def damping(self, zeta):
        """C: every row of B has a dashpot 2 zeta sqrt(m_eff k)."""
        m = []
        for b in self.b:
            grains = sorted({c // 3 for c in np.flatnonzero(b)})
            masses = self.mass[[3 * g for g in grains]]
            m.append(masses[0] if len(grains) == 1 else masses.prod() / masses.sum())
        c = 2 * zeta * np.sqrt(np.array(m) * self.k)
        return self.b.T @ (c[:, None] * self.b), c


def jackson(n):
    k = np.arange(n)
    return ((n - k + 1) * np.cos(np.pi * k / (n + 1)) + np.sin(np.pi * k / (n + 1)) / np.tan(np.pi / (n + 1))) / (n + 1)


def smooth(frequencies, weights, top, moments, at):
    """Lines smoothed by Jackson's kernel in phi, as a density in omega."""
    phi, lines = 2 * np.arcsin(at / top), 2 * np.arcsin(frequencies / top)
    k = np.arange(moments)
    mu = np.cos(np.outer(k, lines)) @ weights * jackson(moments) * np.where(k > 0, 2, 1)
    return np.cos(np.outer(phi, k)) @ mu / np.pi * 2 / (top * np.cos(phi / 2))


def test_dos(network, path):
    exact = network.frequencies()
    for method in ("exact", "count"):
        comments, t = columns(run("spectrum", "dos", path, "--method", method, "--norm", "modes", "--bins", 37))
        assert list(t) == ["omega", "low", "high", "density", "density_err", "cumulative", "cumulative_err", "smooth",
                           "smooth_err"]
        edges = np.append(t["low"], t["high"][-1])
        assert np.array_equal(t["high"][:-1], t["low"][1:]) and np.allclose(t["omega"], (t["low"] + t["high"]) / 2)
        assert np.array_equal(t["cumulative"], [np.sum(exact <= x) for x in t["high"]]), method
        assert np.allclose(t["density"] * np.diff(edges), np.histogram(exact, edges)[0], atol=1e-9)
        assert np.all(t["cumulative_err"] == 0) and comments["zero_modes"] == comments["rattler_modes"]
        assert int(comments["rattler_modes"]) == 3 * network.rattlers
    comments, t = columns(run("spectrum", "dos", path, "--bins", 37))
    top, moments = float(comments["omega_max"]), int(comments["moments"])
    g = smooth(exact, np.full(len(exact), 3 / len(exact)), top, moments, t["omega"])
    assert np.allclose(t["smooth"], g, rtol=1e-9, atol=1e-12)
    assert np.isclose(float(comments["resolution"]), np.pi * top / (2 * moments), rtol=1e-12)
    _, k = columns(run("spectrum", "dos", path, "--bins", 37, "--method", "kpm", "--vectors", 100))
    off = (k["smooth"] - g) / k["smooth_err"]
    assert np.sqrt(np.mean(off[t["omega"] < 0.8 * top] ** 2)) < 1.6 and np.max(np.abs(off)) < 5.5, off
    one, two, other = (run("spectrum", "dos", path, "--method", "kpm", *words) for words in
                       ([], ["--threads", 2], ["--seed", 2]))
    assert one == two != other


def test_transmission(network, path):
    _, t = columns(run("spectrum", "transmission", path, "--lines"))
    root = np.sqrt(network.mass)
    omega = np.sqrt(network.squares)
    ab = (network.vectors.T @ (network.source / root)) * (network.vectors.T @ (network.detector / root)) / omega
    gap = np.minimum(np.append(np.diff(omega), 1), np.append(1, np.diff(omega)))
    assert np.allclose(t["omega"], omega, rtol=1e-9)
    assert np.max(np.abs(t["ab"] - ab)[gap > 1e-5]) < 1e-10 * np.max(np.abs(ab))
    assert np.isclose(t["share"][-1], 1, rtol=1e-12) and np.all(np.diff(t["share"]) >= 0)
    comments, s = columns(run("spectrum", "transmission", path, "--bins", 90))
    top, moments = float(comments["omega_max"]), int(comments["moments"])
    assert np.allclose(s["magnitude"], np.hypot(s["re"], s["im"]), rtol=1e-13)
    g = jackson(2 * moments)[1::2]
    odd = 2 * np.arange(moments) + 1
    w = 2 * g * (np.sin(np.outer(odd, np.arcsin(omega / top))) @ ab)
    psi = np.arcsin(s["omega"] / top)
    f = np.exp(1j * np.outer(psi, odd)) @ w / (top * np.cos(psi))
    assert np.max(np.abs(f - s["re"] - 1j * s["im"])) < 1e-10 * np.max(np.abs(f))


def test_dispersion(network, path):
    for direction in ("x", "up"):
        comments, header, rows = table(run("spectrum", "dispersion", path, "--direction", direction, "--waves", 3))
        assert header == ["polarization", "n", "k", "rms", "spread", "peak", "half_width", "resolution"]
        assert len(rows) == 9
        root = np.sqrt(network.mass)
        a = network.matrix / np.outer(root, root)
        for word, n, *numbers in rows:
            k, rms, spread, peak, half_width, resolution = map(float, numbers)
            up = direction == "up"
            dof = {"longitudinal": int(up), "transverse": int(not up), "rotational": 2}[word]
            wave = np.zeros(len(root), complex)
            if up:
                assert np.isclose(k, int(n) * np.pi / network.height, rtol=1e-13)
                wave[dof::3] = np.sin(k * network.x[:, 1])
            else:
                assert np.isclose(k, int(n) * 2 * np.pi / network.width, rtol=1e-13)
                wave[dof::3] = np.exp(1j * k * network.x[:, 0])
            wave = wave * root
            wave /= np.linalg.norm(wave)
            second = np.real(wave.conj() @ a @ wave)
            fourth = np.linalg.norm(a @ wave) ** 2
            assert np.isclose(rms, np.sqrt(second), rtol=1e-11)
            assert np.isclose(spread, np.sqrt(fourth - second**2) / (2 * rms), rtol=1e-8)
            top, moments = float(comments["omega_max"]), int(comments["moments"])
            weights = np.abs(network.vectors.T @ wave) ** 2
            phi = np.linspace(0, np.pi, 20 * moments)[1:-1]
            at = top * np.sin(phi / 2)
            s = smooth(np.sqrt(network.squares), weights, top, moments, at) * np.cos(phi / 2)
            assert abs(peak - at[np.argmax(s)]) < 0.1 * resolution, (word, n, peak, at[np.argmax(s)])
    _, header, rows = table(run("spectrum", "dispersion", path, "--profile", "--bins", 200, "--waves", 2))
    assert header == ["polarization", "n", "k", "omega", "S"] and len(rows) == 1200


def test_harmonic(network, path):
    frequencies = [0.01, 0.1, 0.35, 0.9]
    for zeta in (0.05, 1):
        comments, t = columns(run("spectrum", "harmonic", path, "--damping", zeta, "--at",
                                  ",".join(map(str, frequencies)), "--layers", 8))
        _, profile = columns(run("spectrum", "harmonic", path, "--damping", zeta, "--at",
                                 ",".join(map(str, frequencies)), "--layers", 8, "--profile"))
        c, each = network.damping(zeta)
        # the force on the top wall by springs and dashpots: rows of B at that wall, times what n_y and t_y are
        top = np.zeros((2, len(network.mass)))
        for b, k, q in zip(network.b, network.k, each):
            grains = {g // 3 for g in np.flatnonzero(b)}
            if len(grains) == 1 and network.x[next(iter(grains)), 1] > network.height / 2:
                gap = -b[3 * next(iter(grains)) + 1]  # the wall's own motion along y in this row
                top += -np.outer([k, q], b) * gap
        assert np.allclose(top[0], network.detector, atol=1e-14)
        for l, omega in enumerate(frequencies):
            h = network.matrix - omega**2 * np.diag(network.mass) + 1j * omega * c
            u = scipy.linalg.solve(h, network.source)
            f = (top[0] + 1j * omega * top[1]) @ u
            off = abs(f - t["re"][l] - 1j * t["im"][l])
            assert off <= t["error"][l] + 1e-9 * abs(f), (zeta, omega, off / abs(f), t["error"][l] / abs(f))
            # planes: the momentum of what lies above changes by the force through the plane less that on the wall
            rows = profile["omega"] == omega
            for y, re, im in zip(profile["height"][rows], profile["re"][rows], profile["im"][rows]):
                above = np.repeat(network.x[:, 1] > y, 3) & (np.arange(len(u)) % 3 == 1)
                through = f - omega**2 * np.sum((network.mass * u)[above])
                assert abs(through - re - 1j * im) < 1e-8 * max(np.hypot(profile["re"][rows], profile["im"][rows]))
    # without damping, away from resonances
    omega = np.sqrt(network.squares)
    middle = (omega[40] + omega[41]) / 2
    _, t = columns(run("spectrum", "harmonic", path, "--at", repr(float(middle))))
    f = network.detector @ scipy.linalg.solve(network.matrix - middle**2 * np.diag(network.mass), network.source)
    assert abs(t["re"][0] - f) <= t["error"][0] + 1e-8 * abs(f) and t["im"][0] == 0
    assert "an error of up to" in run("spectrum", "harmonic", path, "--at", repr(float(omega[40])), status=1)


def test_participation(network, path):
    _, t = columns(run("spectrum", "participation", path, "--bins", 6, "--omega-max", 1.2))
    share = (network.vectors**2).reshape(-1, 3, len(network.squares)).sum(axis=1)
    ratio = 1 / (len(share) * (share**2).sum(axis=0))
    omega = network.frequencies()
    for b in range(6):
        mine = ratio[(omega > t["low"][b]) & (omega <= t["high"][b])]
        assert len(mine) == t["modes"][b]
        assert np.isclose(t["participation"][b], mine.mean(), rtol=1e-6)
        assert np.isclose(t["sd"][b], mine.std(ddof=1), rtol=1e-6)
        assert np.isclose(t["max"][b], mine.max(), rtol=1e-6)


def lattice_frequencies(k, spring, eta, mass, radius, arm):
    """Triangular lattice with rows along x, wave along x: longitudinal, and transverse coupled to rotations."""
    directions = [np.array([np.cos(a), np.sin(a)]) for a in (0, np.pi / 3, 2 * np.pi / 3)]
    m = np.zeros((3, 3), complex)
    for n in directions:
        tangent = np.array([-n[1], n[0]])
        phase = np.exp(1j * k * arm * n[0])
        for row, stiffness in ((np.append(n * (phase - 1), 0), spring),
                               (np.append(tangent * (phase - 1), -radius * (1 + phase)), eta * spring)):
            m += stiffness * np.outer(row.conj(), row)
    scale = np.sqrt(np.array([mass, mass, 0.4 * mass * radius**2]))
    return m / np.outer(scale, scale)


def test_lattice():
    """Plane waves along x in a lattice: the walls disturb only the outermost rows."""
    with tempfile.TemporaryDirectory() as folder:
        for friction in (0, 0.5):
            path = os.path.join(folder, f"lattice{friction}.txt")
            run("pack", "--set", "packing.kind=triangular", "--set", "packing.grains=1600", "--set", "packing.width=16",
                "--set", f"packing.friction={friction}", "-o", path)
            comments, header, rows = table(run("spectrum", "dispersion", path, "--waves", 5))
            lines = open(path).read().splitlines()
            width = float(dict(zip(*[iter(lines[1].split())] * 2))["Lx"]) if "Lx" in lines[1] else None
            values = [dict(zip(header, row)) for row in rows]
            k1 = float(values[0]["k"])
            arm = 2 * np.pi / k1 / 16  # spacing of the grains
            overlap = 1 - arm
            spring, mass = np.sqrt(0.25 * overlap), np.pi / 6
            assert width is None or np.isclose(width, 16 * arm)
            kinds = ("longitudinal", "transverse", "rotational")[:2 if friction == 0 else 3]
            assert {v["polarization"] for v in values} == set(kinds)
            for v in values:
                matrix = lattice_frequencies(float(v["k"]), spring, 1 if friction else 0, mass, 0.5, arm)
                d = kinds.index(v["polarization"])
                if friction == 0:
                    matrix = matrix[:2, :2]
                    k = float(v["k"]) * arm
                    closed = (2 * (1 - np.cos(k)) + (1 - np.cos(k / 2)), 3 * (1 - np.cos(k / 2)))[d] * spring / mass
                    assert np.isclose(matrix[d, d].real, closed, rtol=1e-12)
                # the walls' springs hold 2 rows of 100
                assert np.isclose(float(v["rms"]) ** 2, matrix[d, d].real, rtol=0.02, atol=0.06 * spring / mass), v
                squares, vectors = np.linalg.eigh(matrix)
                weight = np.abs(vectors[d]) ** 2
                strongest = np.sqrt(squares[np.argmax(weight)])
                assert abs(float(v["peak"]) - strongest) < 0.5 * float(v["resolution"]) + 0.01 * strongest, (v, strongest)


def test_chain_speed():
    """Long waves of a chain travel at (C3)."""
    with tempfile.TemporaryDirectory() as folder:
        chain = os.path.join(folder, "chain.h5")
        run("pack", "--set", "packing.kind=chain", "--set", "packing.grains=300", "-o", chain)
        comments, header, rows = table(run("spectrum", "dispersion", chain, "--waves", 300))
        assert comments["direction"] == "up" and comments["node"] == "0.5"
        k, rms = (np.array([float(row[header.index(name)]) for row in rows]) for name in ("k", "rms"))
        overlap = (3e-4) ** (2 / 3)
        spring, mass = np.sqrt(overlap / 4), np.pi / 6
        assert np.allclose(rms, 2 * np.sqrt(spring / mass) * np.sin(k * (1 - overlap) / 2), rtol=1e-12)


def test_pulses(network, path):
    """Against the sum over modes, the convolution by scipy-free closed forms of a square and by brute force."""
    times = np.linspace(0, 150, 31)
    root, omega = np.sqrt(network.mass), np.sqrt(network.squares)
    ab = (network.vectors.T @ (network.source / root)) * (network.vectors.T @ (network.detector / root)) / omega
    _, t = columns(run("signal", path, "--pulse", "square:7", "--until", 150, "--points", 31))
    start = np.maximum(times - 7, 0)
    exact = (np.cos(np.outer(start, omega)) - np.cos(np.outer(times, omega))) @ (ab / omega) / 7
    assert np.max(np.abs(t["F"] - exact)) < 1e-11 * np.max(np.abs(exact))
    with tempfile.TemporaryDirectory() as folder:
        pulse = os.path.join(folder, "pulse.tsv")
        open(pulse, "w").write("# a triangle\nt\ts\n0\t0\n2\t1\n5\t0\n")
        comments, t = columns(run("signal", path, "--pulse", "file:" + pulse, "--until", 150, "--points", 31))
        assert comments["pulse"] == "file:" + pulse
        at, s = np.linspace(0, 5, 200001), np.interp(np.linspace(0, 5, 200001), [0, 2, 5], [0, 1, 0])
        for l in (10, 20, 30):  # Simpson's rule
            weight = np.where(np.arange(len(at)) % 2, 4, 2).astype(float)
            weight[[0, -1]] = 1
            answer = sum(a * np.sum(weight * s * np.sin(w * (times[l] - at))) for a, w in zip(ab, omega)) * 5 / 6e5
            assert abs(t["F"][l] - answer) < 1e-9 * np.max(np.abs(t["F"])), (l, t["F"][l], answer)
        open(pulse, "w").write("t\ts\n1e6\t1\n1e7\t1\n")  # sent after the last time
        _, t = columns(run("signal", path, "--pulse", "file:" + pulse, "--until", 150, "--points", 31))
        assert np.all(t["F"] == 0)
        open(pulse, "w").write("t\ts\n0\t0\n2\tnan\n5\t0\n")
        assert "not finite" in run("signal", path, "--pulse", "file:" + pulse, status=1)
        run("signal", path, "--pulse", "file:" + os.path.join(folder, "none"), status=1)
    for word in ("boom", "gauss", "gauss:", "gauss:1:2", "gauss:-1", "sine:1", "file:", "square:0", "delta:1"):
        assert "--pulse" in run("signal", path, "--pulse", word, status=2), word
    assert columns(run("signal", path, "--points", 5, "--pulse", "delta"))[1]["F"].tolist() == columns(
        run("signal", path, "--points", 5))[1]["F"].tolist()


if __name__ == "__main__":
    small = Waves(N200)
    test_dos(small, N200)
    test_transmission(small, N200)
    test_dispersion(small, N200)
    test_harmonic(small, N200)
    test_participation(small, N200)
    test_pulses(small, N200)
    test_lattice()
    test_chain_speed()
    print("passed")
