"""Zero modes, lowest and highest frequency of the reference packings, which test_modes.c states, by numpy's dense solver
on the plain network of tests/cli/network_oracle.py.

usage: OPENBLAS_NUM_THREADS=1 python3 tests/reference/modes.py
"""
import pathlib
import re
import sys

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS / "cli"))
from network_oracle import Network  # noqa: E402

faults = 0
rows = re.findall(r'REFERENCE\("(packing_\w+-4\.txt)"\), (\d+), ([\d.]+), ([\d.]+)\}',
                  (TESTS / "unit" / "test_modes.c").read_text())
assert len(rows) == 2, rows
for name, zero, lowest, highest in rows:
    network = Network(TESTS.parent / "packings" / "reference" / name)
    omega = network.frequencies()
    off_low, off_high = abs(omega[0] - float(lowest)), abs(omega[-1] - float(highest))
    good = 3 * network.rattlers == int(zero) and off_low < 1e-11 and off_high < 1e-13
    faults += not good
    print("ok " if good else "OFF", name, 3 * network.rattlers, repr(omega[0]), repr(omega[-1]))
sys.exit(1 if faults else 0)
