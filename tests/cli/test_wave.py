#!/usr/bin/env python3
"""wave: the coherent wave of packings and lattices, its means over packings, and what it refuses.
Usage: test_wave.py COMMAND SOURCE_DIR"""
import math
import os
import subprocess
import tempfile

from test_signal import COMMAND, N200, N600, columns, run, table

from common import names_all


def pack(path, **keys):
    sets = [f"--set=packing.{key}={value}" for key, value in keys.items()]
    run("pack", "-q", *sets, "-o", path)
    return path


def rows(*arguments):
    return columns(run("wave", *arguments))[1]


def perfect(kind, pressure, friction):
    """Distance of the rows, and the frequency of the shortest wave of them; E* = rho = d = 1, nu = 0."""
    spacing = 1
    for _ in range(50):  # F = 4/3 E12 sqrt(R12) n^(3/2), E12 = 1/2, R12 = 1/4; F = p d a/sqrt(3) in the lattice
        overlap = (3 * pressure * (1 if kind == "chain" else spacing / math.sqrt(3))) ** (2 / 3)
        spacing = 1 - overlap
    stiffness = 0.5 * math.sqrt(overlap)
    if kind == "chain":
        return spacing, 2 * math.sqrt(stiffness / (math.pi / 6))
    eta = 1 if friction > 0 else 0  # k_t = eta k_n, (A4)
    return spacing * math.sqrt(3) / 2, 2 * math.sqrt(1.5 * stiffness * (1 + eta / 3) / (math.pi / 6))


def main():
    with tempfile.TemporaryDirectory() as folder:
        # lattices and chains carry the wave of their rows, omega = 2 sqrt(K/m) sin(k l/2), without attenuation. K/m of
        # a row in the lattice is 1.5 (1 + eta/3) k_n/m, as in Eqs. (18) and (19) of Somfai et al. 2005
        for kind, count, pressure, friction, highest, k_error, alpha_error in (
                ("triangular", 26, 1e-4, 0, 0.5, 8e-3, 4e-3), ("triangular", 43, 1e-6, 0.5, 0.5, 8e-4, 6e-4),
                ("triangular", 86, 1e-4, 0.5, 0.5, 2e-4, 3e-5), ("triangular", 173, 1e-6, 0, 0.7, 1e-5, 1e-5),
                ("chain", 50, 1e-6, 0, 0.5, 2e-4, 1e-4), ("chain", 200, 1e-4, 0, 0.7, 5e-6, 5e-6)):
            spacing, top = perfect(kind, pressure, friction)
            made = pack(os.path.join(folder, "rows.h5"), kind=kind, grains=count * (8 if kind == "triangular" else 1),
                        width=8, friction=friction, poisson=0, pressure=pressure)
            parts = [part for part in (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9) if part * count > 3]
            found = rows(made, "--at", ",".join(repr(part * top) for part in parts))
            for l, part in enumerate(parts):
                k, alpha, right = found["k"][l], found["alpha"][l], 2 * math.asin(part) / spacing
                case = kind, count, part, k, alpha, found["k_shift"][l], found["alpha_shift"][l]
                assert found["samples"][l] == 1, case
                assert part > highest or (abs(k / right - 1) < k_error and abs(alpha) < alpha_error), case
                shift = math.hypot(found["k_shift"][l], found["alpha_shift"][l])
                assert math.hypot(k - right, alpha) < (1 if part < 0.85 else 3) * shift + 1e-6, case
            # above the largest frequency there is no wave: sideways ones of the lattice with friction go higher
            above = (1.003, 1.05, 1.2) if kind == "chain" else (1.05, 1.2) if friction == 0 else (2.5,)
            none = rows(made, "--at", ",".join(repr(part * top) for part in above))
            assert all(map(math.isnan, none["k"])) and all(map(math.isnan, none["alpha"])), (kind, none)
            assert list(none["samples"]) == [0] * len(above), (kind, none)
            os.remove(made)
        # means and standard errors over packings are those of their own rows
        options = "--at", "0.05,0.1,0.15", "--part", "0.9", "--low", "2", "--spacing", "0.5"
        one, two, both = (rows(*files, *options) for files in ([N200], [N600], [N200, N600]))
        for name in "k", "speed", "alpha":
            for l in range(3):
                a, b = one[name][l], two[name][l]
                assert math.isnan(one[name + "_err"][l])
                if math.isnan(a) or math.isnan(b):
                    assert both["samples"][l] < 2
                    continue
                assert abs(both[name][l] - 0.5 * (a + b)) < 1e-12 * abs(a), (name, l)
                assert abs(both[name + "_err"][l] - 0.5 * abs(a - b)) < 1e-9 * abs(a), (name, l)
        # a packing's wave is about as fast as the long waves of `moduli'
        _, header, cells = table(run("moduli", N600))
        c_l = float(cells[0][header.index("c_l")])
        assert 0.8 < two["speed"][0] / c_l < 1.2, two["speed"]
        assert len(rows(N600)["omega"]) == 24
        # a record shorter than a period tells no wave number (the integrals are those of its tail: 0.02 for 0.2)
        done = subprocess.run([COMMAND, "wave", N600, "--at", "1e-9,1e-3,0.1"], capture_output=True, text=True)
        short = rows(N600, "--at", "1e-9,1e-3,0.1")
        assert [math.isnan(k) for k in short["k"]] == [True, True, False] and list(short["samples"]) == [0, 0, 1], short
        assert names_all(done.stderr, "nan 2 3"), done.stderr


main()
