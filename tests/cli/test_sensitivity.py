"""sensitivity: sums that Euler's theorem knows, and values of other commands. Each derivative by itself is tried against
differences in tests/unit/test_sensitivity*.c.

usage: test_sensitivity.py COMMAND SOURCE_DIR
"""
import math

import numpy as np

from command import N200, main, pack, table


def sensitivity(path, *words):
    """The table, and the value of the quantity."""
    found = table("sensitivity", path, *words)
    return found, found.note("value")


def powers():
    """Springs that are stiffer by a factor s: times shorten by sqrt(s), forces grow by s^(3/2), omega^2 and moduli by s."""
    for of, power in (("t10", -0.5), ("peak", 1.5), ("width", -0.5), ("omega:100", 1), ("omega:100-103", 1), ("cl", 0.5),
                      ("C12", 1)):
        found, value = sensitivity(N200, "--of", of)
        total = math.fsum([*found["by_kn"], *found["by_kt"]])
        assert abs(total - power * value) < 1e-9 * abs(value), of
        assert abs(found.note("homogeneity")) < 1e-10 and 0 < found.note("half_share") < 0.5, of
        assert found.notes["quantity"] == of and found.note("value_err") < 1e-9 * abs(value), of
        assert np.all(found["by_kn_err"] >= 0) and found["by_kn_err"].max() < 1e-6 * np.abs(found["by_kn"]).max(), of
    # masses: all grains heavier by s make times longer by sqrt(s); what moves as a whole along the walls sounds the same
    found, value = sensitivity(N200, "--by", "mass,radius,position")
    assert abs(math.fsum(found["by_mass"]) - 0.5 * value) < 1e-9 * value and "by_kn" not in found
    assert abs(math.fsum(found["by_x"])) < 1e-7 * np.abs(found["by_x"]).sum() and "by_position_err" in found
    found, value = sensitivity(N200, "--by", "pressure")
    assert -0.3 < found["by_p"][0] / value < -0.08  # Hertz: about (p'/p)^(-1/6)


def values():
    """Those of the other commands."""
    t10 = sensitivity(N200)[1]
    assert abs(t10 - table("front", N200)["t10"][0]) < 0.02 and abs(sensitivity(N200, "--pulse=gauss:0.05")[1] - t10) < 0.02
    c_l = sensitivity(N200, "--of=c_l")[1]
    assert c_l == sensitivity(N200, "--of=cl")[1] and abs(c_l / table("moduli", N200)["c_l"][0] - 1) < 1e-12
    omega = table("modes", N200)["omega"][100]
    assert abs(sensitivity(N200, "--of=omega:100")[1] / omega**2 - 1) < 1e-11
    assert sensitivity(N200, "--of=F", "--at=60")[0].note("t") == 60


def shared_grains():
    """Source and detector that share a grain. One ball between both walls swings with omega^2 = (k1 + k2)/m, and each
    of its two equal springs has half of the derivative by both."""
    found, t10 = sensitivity(pack("ball.h5", kind="chain", grains=1))
    stiffness = math.fsum(found["kn"])
    assert abs(t10 / (math.asin(0.1) / math.sqrt(stiffness / (math.pi / 6))) - 1) < 1e-9
    assert np.allclose(found["by_kn"], -t10 / 4, rtol=1e-10)
    for place, words in (("grain:78", ()), ("grain:78", ("--source=displacement",)), ("plane:4", ())):
        found, _ = sensitivity(N200, "--of=F", "--at=9", "--from", place, "--detector", place, *words)
        assert abs(found.note("homogeneity")) < 1e-10, (place, words)


main(powers, values, shared_grains)
