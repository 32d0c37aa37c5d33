"""signal with places, time steps and nonlinear dynamics against numpy (network_oracle.py); units of dashpots. Damped motion
is compared in tests/oracle.

usage: test_places.py COMMAND SOURCE_DIR
"""
import re

import numpy as np

from command import MATERIAL, N200, N600, main, run, table
from network_oracle import network

NORMAL, SHEAR = 1, 0


def signal(*words):
    return table("signal", N200, *words)


def responses(oracle, sources, detectors, t):
    """After momenta, by the modes."""
    root, omega = np.sqrt(oracle.mass), np.sqrt(oracle.squares)
    sent = oracle.vectors.T @ (np.array(sources) / root).T
    seen = oracle.vectors.T @ (np.array(detectors) / root).T
    waves = np.sin(np.outer(t, omega)) / omega
    return [[(waves * sent[:, a] * seen[:, b]).sum(axis=1) for b in range(seen.shape[1])] for a in range(sent.shape[1])]


def places():
    net, t = network(N200), np.linspace(0, 60, 31)
    sources = [net.wall(-1, NORMAL), net.wall(-1, SHEAR), net.wall(-1, NORMAL, net.part(3, 9))]
    detectors = [net.wall(-2, NORMAL), net.wall(-2, SHEAR), net.wall(-2, SHEAR, net.part(0, 12)),
                 net.plane(4, NORMAL), net.plane(4, SHEAR)]
    words = ["--until=60", "--points=31", "--source=impulse:normal", "--from=bottom:shear", "--from=part:3:9", *(
        f"--detector={place}" for place in ("top", "shear", "part:0:12:shear", "plane:4:normal", "plane:4:shear"))]
    exact = responses(net, sources, detectors, t)
    for method, tolerance in (("auto", 1e-10), ("chebyshev", 1e-10), ("dense", 1e-10), ("lax-wendroff", 1e-7),
                              ("verlet", 1e-4), ("faber", 1e-10)):
        found = signal("--method", method, "--tolerance", tolerance, *words)
        assert found.names == ["t"] + [f"F{k}" for k in range(1, 16)] and method in ("auto", found.notes["method"])
        for k, name in enumerate(found.names[1:]):
            a, b = divmod(k, 5)
            assert found.notes[name].startswith("from " + ["bottom:normal", "bottom:shear", "part:3:9:normal"][a])
            bound = float(found.notes[name].rpartition("error ")[2])
            off = np.max(np.abs(found[name] - exact[a][b]))
            assert off <= bound + 2e-12 * np.max(np.abs(exact[a][b])), (method, name, off, bound)
            assert bound <= tolerance * np.max(np.abs(found[name]))
    # a component for all, and planes in equal layers
    found = signal("--until=60", "--points=31", "--component=shear", "--planes=2", "--detector=normal")
    rows = [net.wall(-2, NORMAL), net.plane(net.height / 3, SHEAR), net.plane(2 * net.height / 3, SHEAR)]
    for b, one in enumerate(responses(net, sources[1:2], rows, t)[0]):
        assert np.max(np.abs(found[f"F{b + 1}"] - one)) < 1e-11 * np.max(np.abs(one))


def tables_of_planes():
    """A front for each plane, with its height."""
    run("signal", N200, "--planes", 4, "--detector", "top", "--detector", "grain:3", "-o", "s.tsv")
    found, height = table("front", "s.tsv"), network(N200).height
    assert found.words("file") == [f"s.tsv:F{k}" for k in range(1, 7)]
    assert np.isnan(found["distance"][1]) and found["distance"][0] == height
    assert np.allclose(found["distance"][2:], height / 5 * np.arange(1, 5), rtol=1e-14)
    assert found.rows[3][2:] == table("front", "s.tsv", "--column", "F4").rows[0][2:]


def damped_waves():
    """More dashpots, more attenuation of a wave."""
    alpha = [table("wave", N600, "--at=0.14,0.18", *words)["alpha"] for words in
             ([], ["--damping=gamma:0.005"], ["--damping=gamma:0.02"])]
    assert np.all(alpha[0] < alpha[1]) and np.all(alpha[1] < alpha[2]), alpha


def units_of_dashpots():
    """c in N s/m: E* d^2/sqrt(E*/rho) = sqrt(E* rho) d^2; of mass in rad/s."""
    modulus = 70e9 / (1 - 0.22**2)
    found = table("modes", N200, "--damping", "gamma:0.02:0.01", MATERIAL, "--units=si").notes["damping"]
    normal, tangential = map(float, re.fullmatch(r"gamma:(.*)N s/m:(.*)N s/m", found).groups())
    assert np.allclose([normal, tangential], np.array([0.02, 0.01]) * np.sqrt(modulus * 2500) * 1e-6, rtol=1e-12)
    found = signal("--points=5", "--damping=mass:0.02", MATERIAL, "--units=si").notes["damping"]
    assert np.isclose(float(found.split(":")[1].removesuffix("rad/s")), 0.02 * np.sqrt(modulus / 2500) / 1e-3, rtol=1e-12)


def dynamics():
    """At small amplitudes the packing's own motion is the linear one, in proportion to the amplitude; contacts at Coulomb's
    limit slide before that, however gently one knocks."""
    words = ["--until=60", "--points=61", "--prestress", "--threshold=0"]
    linear, off = signal(*words)["F"], []
    for amplitude in (1e-2, 1e-3, 1e-6):
        found = signal(*words, "--method=dynamics", "--amplitude", amplitude)
        off.append(np.max(np.abs(found["F"] - linear)) / np.max(np.abs(linear)))
        assert found.notes["method"] == "dynamics" and 0 < found.note("error") <= 1e-3 * np.max(np.abs(found["F"]))
        assert found.note("amplitude") > 0 and found.note("step") > 0
    assert off[0] > off[1] > off[2] and off[2] < 1e-5, off


main(places, tables_of_planes, damped_waves, units_of_dashpots, dynamics)
