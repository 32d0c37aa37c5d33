"""Numbers of special functions that unit tests compare with, by mpmath with 50 digits. Reads the tests, prints every
number beside its own, and ends with 1 if one is farther off than its printed digits allow.

usage: python3 tests/reference/special.py
"""
import pathlib
import re
import sys

from mpmath import airyai, besselj, betainc, findroot, mp, mpf

mp.dps = 50
UNIT = pathlib.Path(__file__).resolve().parents[1] / "unit"
faults = 0


def compare(what, printed, value):
    """A number as it is printed in a test: right to half a unit of its last digit, or to that of a double."""
    global faults
    digits = re.sub(r"e.*", "", printed).replace("-", "").replace(".", "").lstrip("0")
    allowed = max(mpf(10) ** -len(digits), mpf(2) ** -53) * max(abs(value), mpf(10) ** -300) * mpf("10")
    good = abs(mpf(printed) - value) <= allowed
    faults += not good
    print(f"{'ok ' if good else 'OFF'} {what:42} {printed:28} {mp.nstr(value, 20)}")


def bessel():
    """test_bessel.c: j[m] after sp_bessel_j(x, ...)."""
    x = None
    for line in (UNIT / "test_bessel.c").read_text().split("test_zero")[0].splitlines():
        if call := re.search(r"sp_bessel_j\((\d+), 101", line):
            x = int(call[1])
        if row := re.search(r"assert_close\(j\[(\d+)\], (\S+),", line):
            compare(f"J_{row[1]}({x})", row[2], besselj(int(row[1]), x))


def airy():
    """test_chain_closed.c: zeros and extrema of Ai, its values and slopes there, and where heads have a tenth of their
    peak."""
    text = (UNIT / "test_chain_closed.c").read_text()
    rows = re.search(r"at\[\]\[3\] = \{(.*?)\};", text, re.S)[1]
    for x, value, slope in re.findall(r"\{(\S+), (\S+), ([^}\s]+)\}", rows):
        at = mpf(x)
        if value == "0":
            at = findroot(airyai, at)
            compare("a zero of Ai", x, at)
        elif slope == "0":
            at = findroot(lambda y: airyai(y, derivative=1), at)
            compare("a zero of Ai'", x, at)
        if value != "0":
            compare(f"Ai({x})", value, airyai(at))
        if slope != "0":
            compare(f"Ai'({x})", slope, airyai(at, derivative=1))
    for name, derivative in (("c1", 0), ("c2", 1)):
        printed = re.search(name + r" = ([\d.]+)L", text)[1]
        compare(f"|Ai{chr(39) * derivative}(0)|", printed, abs(airyai(0, derivative=derivative)))
    heads = (lambda y: -airyai(y, derivative=1), lambda y: y * airyai(y))
    tenth = re.search(r"tenth\[\] = \{(\S+), (\S+)\}", text).groups()
    peak = re.search(r"peak\[\] = \{(\S+), (\S+)\}", text).groups()
    for head, slope, place, top in zip(heads, (lambda y: -y * airyai(y),
                                               lambda y: airyai(y) + y * airyai(y, derivative=1)), tenth, peak):
        best = findroot(slope, mpf(top)) if top != "0" else mpf(0)
        if top != "0":
            compare("where y Ai(y) is largest", top, best)
        compare("where a tenth of the peak is passed", place, findroot(lambda y: head(y) - head(best) / 10, mpf(place)))


def student():
    """test_interval.c: quantiles of Student's t."""
    text = (UNIT / "test_interval.c").read_text()
    rows = re.search(r"\} table\[\] = \{(.*?)\};", text, re.S)[1]
    for level, degrees, printed in re.findall(r"\{([\d.]+), (\d+), ([\d.]+)\}", rows):
        n, p = mpf(degrees), mpf(level)

        def off(t):
            return 1 - betainc(n / 2, mpf("0.5"), 0, n / (n + t * t), regularized=True) / 2 - p

        compare(f"t of {degrees} degrees at {level}", printed, findroot(off, mpf(printed)))


bessel()
airy()
student()
sys.exit(1 if faults else 0)
