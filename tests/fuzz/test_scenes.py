"""Small random scenes end in a packing that a second judge finds in equilibrium, or in a clear refusal.

usage: test_scenes.py COMMAND SOURCE_DIR [SEED [CASES [GRAINS]]]
"""
import sys

from scenes import campaign, known

SEED = int(sys.argv[3]) if len(sys.argv) > 3 else 20050202
CASES = int(sys.argv[4]) if len(sys.argv) > 4 else 24
GRAINS = int(sys.argv[5]) if len(sys.argv) > 5 else 30

counts, faults = campaign(sys.argv[1], SEED, CASES, GRAINS, 60)
faults += known(sys.argv[1])
# a campaign in which most are refused would test little
assert counts["packed"] >= 0.6 * CASES, counts
sys.exit(1 if faults else 0)
