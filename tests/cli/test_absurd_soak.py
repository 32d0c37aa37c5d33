"""Two rounds of tests/soak: commands on one store at once, killed, stopped and continued, and the store as if nothing had been.

usage: test_absurd_soak.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys

SOAK = pathlib.Path(sys.argv[2]) / "tests" / "soak"
sys.exit(subprocess.run([sys.executable, "-B", SOAK, sys.argv[1], "--rounds", "2", "--seed", "1"]).returncode)
