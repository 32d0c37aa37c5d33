"""One ball of a column by its energies, in 30 digits: the height to which it comes back when it is dropped, and the
ratio of velocities of one that comes down fast (test_column_lattice.c, test_column_smooth.c).

A contact pushes with K(1 + e) delta while it closes and with K(1 - e) delta while it opens; K = 2 m g/r of one ball of
mass m and radius r, e = 0.09. The ball touches the floor where its centre is r above it. `drop` is how far it falls.

usage: python3 tests/reference/one_ball.py
"""
import pathlib
import re
import sys

from mpmath import mp, mpf, nstr, sqrt

mp.dps = 30
UNIT = pathlib.Path(__file__).resolve().parents[1] / "unit"
e, r, drop = mpf("0.09"), mpf(1), mpf(1)


def rebound():
    """mg(drop + delta) = K(1 + e) delta^2/2 is what the contact takes up, (1 - e)/(1 + e) of it what it gives back."""
    k = 2 / r  # K/(mg)
    delta = (1 + sqrt(1 + 2 * k * (1 + e) * drop)) / (k * (1 + e))
    return r - delta + k * (1 - e) * delta ** 2 / 2


faults = 0
for name, digits, value in (("test_column_lattice.c", "1.583734480", rebound()),
                            ("test_column_smooth.c", "1.583734480", rebound()),
                            ("test_column_lattice.c", "0.913708041620", sqrt((1 - e) / (1 + e)))):
    printed = re.search(re.escape(digits), (UNIT / name).read_text())
    good = printed and abs(mpf(printed[0]) - value) < mpf(10) ** -(len(digits) - 2) / 2
    faults += not good
    print("ok " if good else "OFF", name, digits, nstr(value, 15))
sys.exit(1 if faults else 0)
