"""amplitude: the front as the pulse grows loud: the linear limit of `signal', and means over packings. What chains and
bursts do is in tests/unit/test_amplitude*.c.

usage: test_amplitude.py COMMAND SOURCE_DIR
"""
import math

import numpy as np

from command import N200, main, pack, run, table


def limit():
    """The quietest pulse has the front of the linear signal; all have the energy that they were given."""
    quiet = table("amplitude", N200, "--amplitudes", "1e-7,0.1,1", "--tolerance", "1e-4")
    run("signal", N200, "--prestress", "--threshold", "0", "--points", "20001", "-o", "signal.tsv")
    linear = table("front", "signal.tsv")
    assert abs(quiet["t10"][0] - linear["t10"][0]) < quiet["t10_err"][0] + 1e-3, (quiet["t10"], linear["t10"])
    for name in ("speed", "peak", "width"):
        assert abs(quiet[name + "_ratio"][0] - 1) < quiet[name + "_ratio_err"][0], name
    assert quiet["slid"][0] == quiet["opened"][0] == 0 and 0 < quiet["opened"][1] < quiet["opened"][2]
    total = sum(quiet[name] for name in ("kinetic", "normal", "tangential", "rubbed")) - quiet["released"]
    assert np.all(np.abs(total - 1) <= 1.000001 * quiet["balance"]) and np.all(quiet["balance"] < 1e-4), quiet["balance"]
    assert quiet["speed_ratio"][2] < 0.97, quiet["speed_ratio"]


def low_packing():
    """In a low packing the quiet front falls back to 0 late: its width is found all the same."""
    low = pack("low.h5", "--seed", 45, dimension=3, grains=150, width=5)
    quiet = table("amplitude", low, "-q", "--amplitudes", "1e-6", "--tolerance", "1e-4")
    assert abs(quiet["width_ratio"][0] - 1) < quiet["width_ratio_err"][0], quiet.row()


def means():
    """Means are those of the rows, their errors the scatter of packings besides those of the rows."""
    files = [pack(f"{seed}.h5", protocol="quick", grains=60, width=6, seed=seed) for seed in (1, 2, 3)]
    each = table("amplitude", *files, "--amplitudes", "0.01,0.5")
    mean = table("amplitude", *files, "--amplitudes", "0.01,0.5", "--mean")
    assert list(mean["packings"]) == [3, 3]
    for name in ("t10", "speed_ratio", "width_ratio"):
        for k in range(2):
            values, errors = each[name][k::2], each[name + "_err"][k::2]
            assert np.isclose(mean[name][k], values.mean(), rtol=1e-12), name
            assert np.isclose(mean[name + "_err"][k], values.std(ddof=1) / 3**0.5 + errors.mean(), rtol=1e-6), name
    one = table("amplitude", files[0], "--amplitudes", "0.01", "--mean")
    assert one["packings"][0] == 1 and math.isnan(one["speed_ratio_err"][0])


main(limit, low_packing, means)
