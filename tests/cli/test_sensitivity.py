#!/usr/bin/env python3
"""sensitivity: derivatives against differences of other commands, sums that Euler's theorem knows.
Usage: test_sensitivity.py COMMAND SOURCE_DIR"""
import math
import os
import sys
import tempfile

from test_signal import N200, columns, run, table

SOURCE = os.path.abspath(sys.argv[2])


def sensitivity(path, *words):
    comments, found = columns(run("sensitivity", path, *words))
    return comments, found


def cell(text, name):
    """A cell of a table of one row, which begins with a file name."""
    _, header, (row,) = table(text)
    return float(row[header.index(name)])


def number(comments, key):
    return float(comments[key].split()[0])


def total(found, *names):
    return math.fsum(x for name in names for x in found[name])


def check_shared_grains(folder):
    """Source and detector that share a grain. One ball between both walls swings with omega^2 = (k1 + k2)/m, and each
    of its two equal springs has half of the derivative by both."""
    ball = os.path.join(folder, "ball.h5")
    run("pack", os.path.join(SOURCE, "packings/chain.cfg"), "--set", "packing.grains=1", "-o", ball)
    comments, found = sensitivity(ball)
    stiffness, t10 = total(found, "kn"), number(comments, "value")
    assert abs(t10 / (math.asin(0.1) / math.sqrt(stiffness / (math.pi / 6))) - 1) < 1e-9
    assert all(abs(d / (-t10 / 4) - 1) < 1e-10 for d in found["by_kn"]), found
    for words in (("--detector", "grain:78"), ("--detector", "grain:78", "--source", "displacement"), ("--detector", "plane:4")):
        source = "plane:4" if words[1] == "plane:4" else "grain:78"
        comments, _ = sensitivity(N200, "--of", "F", "--at", "9", "--from", source, *words)
        assert abs(number(comments, "homogeneity")) < 1e-10, (words, comments)


def main():
    # springs that are stiffer by a factor s: times shorten by sqrt(s), forces grow by s^(3/2), omega^2 and moduli by s
    for of, power in (("t10", -0.5), ("t_peak", -0.5), ("peak", 1.5), ("t_zero", -0.5), ("width", -0.5), ("omega:100", 1),
                      ("omega:100-103", 1), ("cl", 0.5), ("ct", 0.5), ("C22", 1), ("C12", 1)):
        comments, found = sensitivity(N200, "--of", of)
        value = number(comments, "value")
        assert abs(total(found, "by_kn", "by_kt") - power * value) < 1e-9 * abs(value), of
        assert abs(number(comments, "homogeneity")) < 1e-10 and 0 < number(comments, "half_share") < 0.5, of
        assert comments["quantity"] == of and number(comments, "value_err") < 1e-9 * abs(value), of
        errors, sizes = found["by_kn_err"], found["by_kn"]
        assert all(e >= 0 for e in errors) and max(errors) < 1e-6 * max(map(abs, sizes)), of
    # the values are those of the other commands
    assert abs(number(sensitivity(N200, "--of", "t10")[0], "value") - cell(run("front", N200), "t10")) < 0.02
    assert number(sensitivity(N200, "--of", "c_l")[0], "value") == number(sensitivity(N200, "--of", "cl")[0], "value")
    assert abs(number(sensitivity(N200, "--of", "cl")[0], "value") / cell(run("moduli", N200), "c_l") - 1) < 1e-12
    omega = columns(run("modes", N200))[1]["omega"][100]
    assert abs(number(sensitivity(N200, "--of", "omega:100")[0], "value") / omega**2 - 1) < 1e-11
    # masses: all grains heavier by s make times longer by sqrt(s)
    comments, found = sensitivity(N200, "--by", "mass,radius,position")
    assert abs(total(found, "by_mass") - 0.5 * number(comments, "value")) < 1e-9 * number(comments, "value")
    # a packing that moves as a whole along the walls sounds the same
    assert abs(total(found, "by_x")) < 1e-7 * total({"x": map(abs, found["by_x"])}, "x")
    assert "by_radius" in found and "by_position_err" in found and "by_kn" not in found
    comments, found = sensitivity(N200, "--by", "pressure")
    # Hertz: about (p'/p)^(-1/6)
    assert -0.3 < found["by_p"][0] / number(comments, "value") < -0.08
    # F at a time
    assert number(sensitivity(N200, "--of", "F", "--at", "60")[0], "t") == 60
    narrow = number(sensitivity(N200, "--pulse", "gauss:0.05")[0], "value")
    assert abs(narrow - number(sensitivity(N200)[0], "value")) < 0.02
    with tempfile.TemporaryDirectory() as folder:
        check_shared_grains(folder)


if __name__ == "__main__":
    main()
