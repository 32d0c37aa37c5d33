"""kill -9 at a hundred random moments and at every call that changes the store; and every such call that fails, for
each reason that it may have.

usage: test_store_kill_long.py COMMAND SOURCE_DIR
"""
import pathlib
import random
import signal
import sys
import tempfile

from store_faults import SMALL, Reference, calls_of, killed_at, refused_at, shim, stopped_at_random


def random_moments(folder):
    reference = Reference(folder / "reference")
    stopped_at_random(reference, folder, [signal.SIGKILL], 100, random.randrange(10**6))
    stopped_at_random(reference, folder, [signal.SIGINT, signal.SIGTERM], 40, random.randrange(10**6))
    return True


def every_call(folder):
    library = shim(folder)
    if not library:
        return False
    reference = Reference(folder / "small", SMALL)
    for stage in range(2):
        calls = calls_of(library, reference, folder, stage)
        for at in range(1, calls + 1):
            for do in ("KILL", "POWER"):
                killed_at(library, reference, folder, stage, do, at)
            for do in ("ENOSPC", "EDQUOT", "EIO", "EROFS"):
                refused_at(library, reference, folder, stage, do, at)
        print(f"stage {stage}: each of {calls} calls")
    return True


with tempfile.TemporaryDirectory() as name:
    skipped = False
    for test in (random_moments, every_call):
        done = test(pathlib.Path(name))
        print(test.__name__, "ok" if done else "skipped: no cc, or a build with sanitizers")
        skipped = skipped or not done
    sys.exit(77 if skipped else 0)
