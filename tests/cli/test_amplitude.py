#!/usr/bin/env python3
"""amplitude: the front as the pulse grows loud: the linear limit of `signal', means, units, and what it refuses.
Usage: test_amplitude.py COMMAND SOURCE_DIR"""
import math
import os
import tempfile

from test_signal import N200, run, table

from common import names_all


def numbers(text):
    """{column: its numbers} without the column of files."""
    _, header, rows = table(text)
    return {name: [float(row[k]) for row in rows] for k, name in enumerate(header) if name != "file"}


def rows(*arguments):
    return numbers(run("amplitude", *arguments))


def front_of(folder, *arguments):
    signal = os.path.join(folder, "signal.tsv")
    run("signal", *arguments, "-o", signal, "--force")
    return numbers(run("front", signal))


def test_limit(folder):
    """The quietest pulse has the front of the linear signal; all have the energy that they were given."""
    quiet = rows(N200, "--amplitudes", "1e-7,0.1,1", "--tolerance", "1e-4")
    linear = front_of(folder, N200, "--prestress", "--threshold", "0", "--points", "20001")
    assert abs(quiet["t10"][0] - linear["t10"][0]) < quiet["t10_err"][0] + 1e-3, (quiet["t10"], linear["t10"])
    for name in ("speed", "peak", "width"):
        assert abs(quiet[name + "_ratio"][0] - 1) < quiet[name + "_ratio_err"][0], name
    assert quiet["slid"][0] == quiet["opened"][0] == 0 and 0 < quiet["opened"][1] < quiet["opened"][2]
    for k in range(3):
        total = sum(quiet[name][k] for name in ("kinetic", "normal", "tangential", "rubbed")) - quiet["released"][k]
        assert abs(total - 1) <= quiet["balance"][k] * 1.000001 <= 1e-4, (k, total, quiet["balance"])
    assert quiet["speed_ratio"][2] < 0.97, quiet["speed_ratio"]


def test_means(folder):
    """Means are those of the rows, their errors the scatter of packings besides those of the rows."""
    files = []
    for seed in (1, 2, 3):
        files.append(os.path.join(folder, f"{seed}.h5"))
        run("pack", "-q", "--set", "packing.protocol=quick", "--set", "packing.grains=60", "--set", "packing.width=6",
            "--set", f"packing.seed={seed}", "-o", files[-1])
    each = rows(*files, "--amplitudes", "0.01,0.5")
    mean = rows(*files, "--amplitudes", "0.01,0.5", "--mean")
    for k in range(2):
        assert mean["packings"][k] == 3 and mean["dimension"][k] == 2
        for name in ("t10", "speed_ratio", "width_ratio"):
            values, errors = each[name][k::2], each[name + "_err"][k::2]
            middle = sum(values) / 3
            spread = math.sqrt(sum((v - middle) ** 2 for v in values) / 6)
            assert abs(mean[name][k] / middle - 1) < 1e-12, name
            assert abs(mean[name + "_err"][k] / (spread + sum(errors) / 3) - 1) < 1e-6, name
    one = rows(files[0], "--amplitudes", "0.01", "--mean")
    assert one["packings"][0] == 1 and math.isnan(one["speed_ratio_err"][0])


def test_chains(folder):
    """A hard knock makes a solitary wave, whose speed `chain soliton' gives; long-wave theory is 1% off."""
    chain = os.path.join(folder, "chain.h5")
    run("pack", "-q", "--set", "packing.kind=chain", "--set", "packing.grains=80", "--set", "packing.pressure=1e-8",
        "-o", chain)
    found = rows(chain, "--amplitudes", "300", "--planes", "3", "--tolerance", "1e-4")
    for k in (1, 2):
        assert abs(found["speed_peak"][k] / found["solitary"][k] - 1) < 1e-3, found
        assert 5e-3 < abs(found["nesterenko"][k] / found["solitary"][k] - 1) < 2e-2, found
    assert math.isnan(found["speed"][0]) and math.isnan(rows(N200, "--planes", "2", "--amplitudes", "0.1")["kdv"][0])
    solitons = numbers(run("chain", "soliton", "--peaks", "0.01,1,inf"))
    assert abs(solitons["speed"][0] - 1 - 0.01 / 12) < 2e-6 and math.isinf(solitons["speed"][2])
    assert abs(solitons["force"][1] - 2 ** 1.5) < 1e-12 and max(solitons["relative_error"]) < 1e-7
    for word in ("0", "x", "1,,2", "1e10"):
        assert names_all(run("chain", "soliton", "--peaks", word, status=2), "--peaks")


def test_bursts(folder):
    """Long waves in a chain: beta delta0/d = 1/2; the second harmonic goes as the square of the first."""
    chain = os.path.join(folder, "long.h5")
    run("pack", "-q", "--set", "packing.kind=chain", "--set", "packing.grains=200", "--set", "packing.pressure=1e-6",
        "-o", chain)
    found = rows(chain, "--omega", "0.02", "--cycles", "4", "--amplitudes", "0.005")
    assert abs(found["beta_delta"][0] - 0.5) < 0.03 and abs(found["beta"][0] / found["beta_field"][0] - 1) < 0.06, found
    planes = rows(chain, "--omega", "0.02", "--cycles", "4", "--amplitudes", "0.001,0.005", "--planes", "3")
    for k in range(3):
        assert abs(planes["F1"][k + 3] / planes["F1"][k] - 5) < 1e-2 and abs(planes["F2"][k + 3] / planes["F2"][k] - 25) < 0.3
        assert planes["F0"][k] > 0, "Hertz's law pushes apart on average"


def test_low_packing(folder):
    """In a low packing the quiet front falls back to 0 later than 1.5 times its peak: its width is found all the same."""
    low = os.path.join(folder, "low.h5")
    run("pack", "-q", "--set", "packing.dimension=3", "--set", "packing.grains=150", "--set", "packing.width=5",
        "--seed", 43, "-o", low)
    quiet = rows(low, "-q", "--amplitudes", "1e-6", "--tolerance", "1e-4")
    linear = front_of(folder, low, "-q", "--prestress", "--threshold", "0", "--points", "20001")
    assert linear["t_zero"][0] > 1.5 * linear["t_peak"][0], linear
    # the passage of 10% lies between two times, where every second time tells less of the error than elsewhere
    assert abs(quiet["t10"][0] - linear["t10"][0]) < 1.2 * quiet["t10_err"][0], (quiet, linear["t10"])
    assert abs(quiet["width_ratio"][0] - 1) < quiet["width_ratio_err"][0], quiet


def main():
    with tempfile.TemporaryDirectory() as folder:
        test_limit(folder)
        test_means(folder)
        test_chains(folder)
        test_bursts(folder)
        test_low_packing(folder)


if __name__ == "__main__":
    main()
