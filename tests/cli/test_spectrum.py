"""spectrum against numpy on dense matrices, built here anew from the packing file, and against the closed forms of
lattices. The errors of the methods are in tests/unit/test_spectrum.c.

usage: test_spectrum.py COMMAND SOURCE_DIR
"""
import pathlib

import numpy as np
import scipy.linalg

from command import N200, N600, main, pack, refused, run, table
from network_oracle import network

NET = network(N200)


def jackson(n):
    k = np.arange(n)
    return ((n - k + 1) * np.cos(np.pi * k / (n + 1)) + np.sin(np.pi * k / (n + 1)) / np.tan(np.pi / (n + 1))) / (n + 1)


def smooth(frequencies, weights, top, moments, at):
    """Lines smoothed by Jackson's kernel in phi, as a density in omega."""
    phi, lines = 2 * np.arcsin(at / top), 2 * np.arcsin(frequencies / top)
    k = np.arange(moments)
    mu = np.cos(np.outer(k, lines)) @ weights * jackson(moments) * np.where(k > 0, 2, 1)
    return np.cos(np.outer(phi, k)) @ mu / np.pi * 2 / (top * np.cos(phi / 2))


def densities():
    t = table("spectrum", "dos", N200, "--bins", 37)
    assert t.names == ["omega", "low", "high", "density", "density_err", "cumulative", "cumulative_err", "smooth", "smooth_err"]
    top, moments, exact = t.note("omega_max"), int(t.note("moments")), NET.frequencies()
    g = smooth(exact, np.full(len(exact), 3 / len(exact)), top, moments, t["omega"])
    assert np.isclose(t.note("resolution"), np.pi * top / (2 * moments), rtol=1e-12)
    k = table("spectrum", "dos", N200, "--bins", 37, "--method", "kpm", "--vectors", 100)
    off = (k["smooth"] - g) / k["smooth_err"]
    assert np.sqrt(np.mean(off[t["omega"] < 0.8 * top] ** 2)) < 1.6 and np.max(np.abs(off)) < 5.5, off
    one, two, other = (run("spectrum", "dos", N200, "--method", "kpm", *words).stdout for words in
                       ([], ["--threads", 2], ["--seed", 2]))
    assert one == two != other


def amplitudes():
    """Of every mode in the signal."""
    root, omega = np.sqrt(NET.mass), np.sqrt(NET.squares)
    return omega, (NET.vectors.T @ (NET.source / root)) * (NET.vectors.T @ (NET.detector / root)) / omega


def transmission():
    t = table("spectrum", "transmission", N200, "--lines")
    omega, ab = amplitudes()
    gap = np.minimum(np.append(np.diff(omega), 1), np.append(1, np.diff(omega)))
    assert np.allclose(t["omega"], omega, rtol=1e-9)
    assert np.max(np.abs(t["ab"] - ab)[gap > 1e-5]) < 1e-10 * np.max(np.abs(ab))
    assert np.isclose(t["share"][-1], 1, rtol=1e-12) and np.all(np.diff(t["share"]) >= 0)


def dispersion():
    root = np.sqrt(NET.mass)
    a = NET.matrix / np.outer(root, root)
    for direction in ("x", "up"):
        t = table("spectrum", "dispersion", N200, "--direction", direction, "--waves", 2)
        assert t.names == ["polarization", "n", "k", "rms", "spread", "peak", "half_width", "resolution"] and len(t) == 6
        top, moments, up = t.note("omega_max"), int(t.note("moments")), direction == "up"
        for word, n, k, rms, spread, peak, resolution in zip(t.words("polarization"), t["n"], t["k"], t["rms"], t["spread"],
                                                             t["peak"], t["resolution"]):
            dof = {"longitudinal": int(up), "transverse": int(not up), "rotational": 2}[word]
            assert np.isclose(k, n * np.pi / NET.height if up else n * 2 * np.pi / NET.width, rtol=1e-13)
            wave = np.zeros(len(root), complex)
            wave[dof::3] = np.sin(k * NET.centre[:, 1]) if up else np.exp(1j * k * NET.centre[:, 0])
            wave *= root
            wave /= np.linalg.norm(wave)
            second, fourth = np.real(wave.conj() @ a @ wave), np.linalg.norm(a @ wave) ** 2
            assert np.isclose(rms, np.sqrt(second), rtol=1e-11)
            assert np.isclose(spread, np.sqrt(fourth - second**2) / (2 * rms), rtol=1e-8)
            phi = np.linspace(0, np.pi, 20 * moments)[1:-1]
            at = top * np.sin(phi / 2)
            s = smooth(np.sqrt(NET.squares), np.abs(NET.vectors.T @ wave) ** 2, top, moments, at) * np.cos(phi / 2)
            assert abs(peak - at[np.argmax(s)]) < 0.1 * resolution, (word, n, peak, at[np.argmax(s)])
    t = table("spectrum", "dispersion", N200, "--profile", "--bins", 200, "--waves", 2)
    assert t.names == ["polarization", "n", "k", "omega", "S"] and len(t) == 1200


def harmonic():
    words = ["spectrum", "harmonic", N200, "--damping=0.05", "--at=0.01,0.35", "--layers=8"]
    t, profile = table(*words), table(*words, "--profile")
    c = 0.05 * NET.c
    damping = NET.b.T @ (c[:, None] * NET.b)
    seen = NET.wall(-2, 1), NET.wall(-2, 1, stiffness=c)
    for l, omega in enumerate((0.01, 0.35)):
        u = scipy.linalg.solve(NET.matrix - omega**2 * np.diag(NET.mass) + 1j * omega * damping, NET.source)
        f = (seen[0] + 1j * omega * seen[1]) @ u
        off = abs(f - t["re"][l] - 1j * t["im"][l])
        assert off <= t["error"][l] + 1e-9 * abs(f), (omega, off / abs(f), t["error"][l] / abs(f))
        # planes: the momentum of what lies above changes by the force through the plane less that on the wall
        rows = profile["omega"] == omega
        through = profile["re"][rows] + 1j * profile["im"][rows]
        for y, shown in zip(profile["height"][rows], through):
            above = np.repeat(NET.centre[:, 1] > y, 3) & (np.arange(len(u)) % 3 == 1)
            assert abs(f - omega**2 * np.sum((NET.mass * u)[above]) - shown) < 1e-8 * np.abs(through).max()
    omega = np.sqrt(NET.squares)  # without damping, away from resonances
    middle = float(omega[40] + omega[41]) / 2
    t = table("spectrum", "harmonic", N200, "--at", repr(middle))
    f = NET.detector @ scipy.linalg.solve(NET.matrix - middle**2 * np.diag(NET.mass), NET.source)
    assert abs(t["re"][0] - f) <= t["error"][0] + 1e-8 * abs(f) and t["im"][0] == 0
    # at a resonance there is no number, and another frequency has its own all the same
    refused("", "spectrum", "harmonic", N200, "--at", repr(float(omega[40])), status=1)
    done = run("spectrum", "harmonic", N200, "--at", f"0.05,{float(omega[40])!r}", status=1)
    rows = [line.split("\t") for line in done.stdout.splitlines() if not line.startswith("#")]
    assert "nan" not in rows[1][1:5] and set(rows[2][1:]) == {"nan"} and "# refused = 1 " in done.stdout, rows


def participation():
    t = table("spectrum", "participation", N200, "--bins", 6, "--omega-max", 1.2)
    share = (NET.vectors**2).reshape(-1, 3, len(NET.squares)).sum(axis=1)
    ratio, omega = 1 / (len(share) * (share**2).sum(axis=0)), NET.frequencies()
    for b in range(6):
        mine = ratio[(omega > t["low"][b]) & (omega <= t["high"][b])]
        assert len(mine) == t["modes"][b]
        for name, value in (("participation", mine.mean()), ("sd", mine.std(ddof=1)), ("max", mine.max())):
            assert np.isclose(t[name][b], value, rtol=1e-6), (b, name)


def continuum():
    """The modes of the packing beside those of an elastic strip of its moduli."""
    t, net = table("spectrum", "continuum", N600, "--lowest", 5), network(N600)
    c, omega = net.moduli(), net.frequencies()[:5]
    assert t.names == "n omega n1 n2 branch omega_plane omega_continuum ratio overlap".split()
    for name, value in (("C11", c[0, 0]), ("C12", c[0, 1]), ("C22", c[1, 1]), ("C33", c[2, 2])):
        assert np.isclose(t.note(name), value, rtol=1e-9)
    assert np.allclose(t["omega"], omega, rtol=1e-8) and np.allclose(t["ratio"], omega / t["omega_continuum"], rtol=1e-7)
    for k, branch in enumerate(t.words("branch")):
        k1, k2 = 2 * np.pi * t["n1"][k] / net.width, np.pi * t["n2"][k] / net.height
        side = (c[0, 1] + c[2, 2]) * k1 * k2
        tensor = [[c[0, 0] * k1**2 + c[2, 2] * k2**2, side], [side, c[2, 2] * k1**2 + c[1, 1] * k2**2]]
        plane = np.sqrt(np.linalg.eigvalsh(tensor) / t.note("Phi3s"))[int(branch == "+")]
        assert np.isclose(t["omega_plane"][k], plane, rtol=1e-9) and 0 < t["overlap"][k] < 1


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


def lattices():
    """Plane waves along x in a lattice: the walls disturb only the outermost rows. Long waves of a chain travel at (C3)."""
    for friction in (0, 0.5):
        path = pack("lattice.h5", kind="triangular", grains=1600, width=16, friction=friction)
        t = table("spectrum", "dispersion", path, "--waves", 5)
        kinds = ("longitudinal", "transverse", "rotational")[:2 if friction == 0 else 3]
        assert set(t.words("polarization")) == set(kinds)
        arm = 2 * np.pi / t["k"][0] / 16  # spacing of the grains
        spring, mass = np.sqrt(0.25 * (1 - arm)), np.pi / 6
        for word, k, rms, peak, resolution in zip(t.words("polarization"), t["k"], t["rms"], t["peak"], t["resolution"]):
            d = kinds.index(word)
            matrix = lattice_frequencies(k, spring, 1 if friction else 0, mass, 0.5, arm)
            matrix = matrix[:2, :2] if friction == 0 else matrix
            # the walls' springs hold 2 rows of 100
            assert np.isclose(rms**2, matrix[d, d].real, rtol=0.02, atol=0.06 * spring / mass), (word, k)
            squares, vectors = np.linalg.eigh(matrix)
            strongest = np.sqrt(squares[np.argmax(np.abs(vectors[d]) ** 2)])
            assert abs(peak - strongest) < 0.5 * resolution + 0.01 * strongest, (word, k, peak, strongest)
    t = table("spectrum", "dispersion", pack("chain.h5", kind="chain", grains=300), "--waves", 300)
    assert t.notes["direction"] == "up" and t.notes["node"] == "0.5"
    overlap = 3e-4 ** (2 / 3)
    top = 2 * np.sqrt(np.sqrt(overlap / 4) / (np.pi / 6))
    assert np.allclose(t["rms"], top * np.sin(t["k"] * (1 - overlap) / 2), rtol=1e-12)


def pulses():
    """Against the sum over modes: a square in closed form, a triangle from a file by Simpson's rule."""
    times, (omega, ab), words = np.linspace(0, 150, 31), amplitudes(), ["signal", N200, "--until=150", "--points=31"]
    f, start = table(*words, "--pulse=square:7")["F"], np.maximum(times - 7, 0)
    exact = (np.cos(np.outer(start, omega)) - np.cos(np.outer(times, omega))) @ (ab / omega) / 7
    assert np.max(np.abs(f - exact)) < 1e-11 * np.max(np.abs(exact))
    pulse = pathlib.Path("pulse.tsv")
    pulse.write_text("# a triangle\nt\ts\n0\t0\n2\t1\n5\t0\n")
    t = table(*words, "--pulse=file:pulse.tsv")
    assert t.notes["pulse"] == "file:pulse.tsv"
    at = np.linspace(0, 5, 20001)
    s, weight = np.interp(at, [0, 2, 5], [0, 1, 0]), np.where(np.arange(len(at)) % 2, 4, 2).astype(float)
    weight[[0, -1]] = 1
    for l in (10, 30):
        answer = sum(a * np.sum(weight * s * np.sin(w * (times[l] - at))) for a, w in zip(ab, omega)) * 5 / 6e4
        assert abs(t["F"][l] - answer) < 1e-9 * np.max(np.abs(t["F"])), (l, t["F"][l], answer)
    pulse.write_text("t\ts\n1e6\t1\n1e7\t1\n")  # sent after the last time
    assert np.all(table(*words, "--pulse=file:pulse.tsv")["F"] == 0)
    pulse.write_text("t\ts\n0\t0\n2\tnan\n5\t0\n")
    refused("pulse.tsv", "signal", N200, "--pulse=file:pulse.tsv", status=1)
    assert table(*words, "--pulse=delta").body == table(*words).body


main(densities, transmission, dispersion, harmonic, participation, continuum, lattices, pulses)
