"""Studies that are killed, and go on: no finished sample is lost or made again, no file is half, and files and tables
are those of a study that nobody disturbed.

usage: test_store_kill.py COMMAND SOURCE_DIR
"""
import pathlib
import random
import signal
import sys
import tempfile

from store_faults import SMALL, Reference, calls_of, killed_at, shim, stopped_at_random


def random_moments(folder):
    reference = Reference(folder / "reference")
    stopped_at_random(reference, folder, [signal.SIGKILL], 12, random.randrange(10**6))
    stopped_at_random(reference, folder, [signal.SIGINT, signal.SIGTERM], 6, random.randrange(10**6))
    return True


def every_call(folder):
    """Dead before each of the calls that change the store, and after half of the bytes of each write; then the power
    fails as well."""
    library = shim(folder)
    if not library:
        return False
    reference = Reference(folder / "small", SMALL)
    assert sum(name.endswith(".failed") for name in reference.content[0]) == 2
    for stage in range(2):
        calls = calls_of(library, reference, folder, stage)
        assert calls >= 8, calls
        for at in range(1, calls + 1):
            killed_at(library, reference, folder, stage, ("KILL", "POWER")[at % 2], at)
        print(f"stage {stage}: dead at each of {calls} calls")
    return True


with tempfile.TemporaryDirectory() as name:
    skipped = False
    for test in (random_moments, every_call):
        done = test(pathlib.Path(name))
        print(test.__name__, "ok" if done else "skipped: no cc, or a build with sanitizers")
        skipped = skipped or not done
    sys.exit(77 if skipped else 0)
