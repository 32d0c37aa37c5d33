"""--damping with the same coefficient at every contact, and in proportion to mass: signal, modes, spectrum harmonic and
wave against numpy and scipy (network_oracle.py), the units of the comment, and the command line.

usage: test_gamma.py COMMAND SOURCE_DIR
"""
import os
import re
import subprocess
import sys

import numpy as np
import scipy.integrate

from network_oracle import Network

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
N200 = os.path.join(SOURCE, "packings", "reference", "packing_N200_p1e-4.txt")
N600 = os.path.join(SOURCE, "packings", "reference", "packing_N600_p1e-4.txt")
NORMAL = 1


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, timeout=1200)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done.stderr if status else done.stdout


def table(*words):
    """Comments and columns."""
    comments, rows = {}, []
    for line in run(*words).splitlines():
        if line.startswith("#"):
            key, _, value = line[1:].partition("=")
            comments[key.strip()] = value.strip()
        else:
            rows.append(line.split("\t"))
    values = np.array(rows[1:], dtype=float)
    return comments, {name: values[:, k] for k, name in enumerate(rows[0])}


def with_dashpots(kind, value, tangential):
    """The network whose c are those of the kind."""
    network = Network(N200)
    normal = np.arange(len(network.c)) % 2 == 0  # rows of a contact: normal, tangential
    if kind == "mass":
        scale = (network.c / 2) ** 2 / network.k  # the reduced mass: c = 2 sqrt(m k) there
    else:
        scale = np.ones(len(network.c))
    network.c = np.where(normal, value, tangential) * scale
    return network


def test_signal():
    t = np.linspace(0, 60, 31)
    for kind, value, tangential in (("gamma", 0.01, 0.01), ("gamma", 0.05, 0), ("mass", 0.3, 0.1)):
        network = with_dashpots(kind, value, tangential)
        word = f"{kind}:{value}" if value == tangential else f"{kind}:{value}:{tangential}"
        comments, f = table("signal", N200, "--until", 60, "--points", 31, "--damping", word)
        assert comments["method"] == "faber" and comments["damping"] == f"{kind}:{value}:{tangential}", comments
        row = (network.wall(-2, NORMAL), network.wall(-2, NORMAL, stiffness=network.c))
        exact = network.damped(1, network.source, [row], t)[0]
        assert np.max(np.abs(f["F"] - exact)) < 1e-10 * np.max(np.abs(exact)), (word, np.max(np.abs(f["F"] - exact)))


def test_ode():
    """The same by time steps that know nothing of modes."""
    network = with_dashpots("gamma", 0.02, 0.02)
    motion, t = network.motion(1), np.linspace(0, 40, 9)
    start = np.concatenate([np.zeros(len(network.mass)), network.source / network.mass])
    steps = scipy.integrate.solve_ivp(lambda _, u: motion @ u, (0, 40), start, method="DOP853", t_eval=t, rtol=1e-12,
                                      atol=1e-14 * np.max(np.abs(start)))
    row = np.concatenate([network.wall(-2, NORMAL), network.wall(-2, NORMAL, stiffness=network.c)])
    _, f = table("signal", N200, "--until", 40, "--points", 9, "--damping", "gamma:0.02")
    off = np.max(np.abs(f["F"] - row @ steps.y)) / np.max(np.abs(f["F"]))
    print(f"against DOP853: {off:.2g} of the peak")
    assert off < 1e-9


def test_modes():
    network = with_dashpots("gamma", 0.02, 0.02)
    rates = np.linalg.eigvals(network.motion(1))
    rates = rates[rates.imag >= 0]
    _, ours = table("modes", N200, "--damping", "gamma:0.02")
    assert len(ours["omega"]) == len(rates)
    for rate in rates:
        k = np.argmin(np.hypot(ours["omega"] - rate.imag, ours["decay"] + rate.real))
        assert np.hypot(ours["omega"][k] - rate.imag, ours["decay"][k] + rate.real) < 1e-10
        if rate.imag > 1e-6:
            assert abs(ours["Q"][k] + abs(rate) / (2 * rate.real)) < 1e-8 * ours["Q"][k]
            assert 0 <= ours["Q_err"][k] < 1e-6 * ours["Q"][k]


def test_harmonic():
    network = with_dashpots("mass", 0.4, 0.2)
    _, ours = table("spectrum", "harmonic", N200, "--damping", "mass:0.4:0.2", "--at", "0.1,0.2")
    damping = network.b.T @ (network.c[:, None] * network.b)
    for l, omega in enumerate(ours["omega"]):
        u = np.linalg.solve(network.matrix - omega ** 2 * np.diag(network.mass) + 1j * omega * damping, network.source)
        seen = network.wall(-2, NORMAL) + 1j * omega * network.wall(-2, NORMAL, stiffness=network.c)
        assert abs(ours["re"][l] + 1j * ours["im"][l] - seen @ u) < 1e-8 * abs(seen @ u)
        q = abs(ours["k"][l]) / (2 * ours["alpha"][l])
        assert abs(ours["Q"][l] - q) < 1e-9 * q if ours["alpha"][l] > 3 * ours["alpha_err"][l] else np.isnan(ours["Q"][l])


def test_wave():
    """Dashpots add to the attenuation by scattering; a lower one of the same kind adds less."""
    at = ["--at", "0.14,0.18"]
    alpha = [table("wave", N600, *at, *words)[1]["alpha"] for words in
             ([], ["--damping", "gamma:0.005"], ["--damping", "gamma:0.02"])]
    assert np.all(alpha[0] < alpha[1]) and np.all(alpha[1] < alpha[2]), alpha


def test_units():
    """c in N s/m: E* d^2/sqrt(E*/rho) = sqrt(E* rho) d^2."""
    material = ["--material", "E=70e9,nu=0,rho=2500,d=1e-3", "--units", "si"]
    comments, _ = table("modes", N200, "--damping", "gamma:0.02:0.01", *material)
    normal, tangential = re.fullmatch(r"gamma:(.*)N s/m:(.*)N s/m", comments["damping"]).groups()
    scale = np.sqrt(70e9 * 2500) * 1e-6
    assert abs(float(normal) / (0.02 * scale) - 1) < 1e-12 and abs(float(tangential) / (0.01 * scale) - 1) < 1e-12
    comments, _ = table("signal", N200, "--points", 5, "--damping", "mass:0.02", *material)
    assert abs(float(comments["damping"].split(":")[1].removesuffix("rad/s")) / (0.02 * np.sqrt(70e9 / 2500) / 1e-3) - 1) < 1e-12


if __name__ == "__main__":
    test_signal()
    test_ode()
    test_modes()
    test_harmonic()
    test_wave()
    test_units()
    print("passed")
