"""Studies that are killed, and go on: no finished sample is lost or made again, no file is half, and files and tables
are those of a study that nobody disturbed.

usage: test_store_kill.py COMMAND SOURCE_DIR
"""
import pathlib
import random
import signal

from command import main
from store_faults import SMALL, Reference, calls_of, killed_at, refused_at, shim, stopped_at_random


def random_moments(kills=6, stops=4):
    reference, folder = Reference(pathlib.Path("reference")), pathlib.Path()
    stopped_at_random(reference, folder, [signal.SIGKILL], kills, random.randrange(10**6))
    stopped_at_random(reference, folder, [signal.SIGINT, signal.SIGTERM], stops, random.randrange(10**6))


def every_call(long=False):
    """Dead before every third of the calls that change the store, or after half of the bytes of a write; then the power
    fails as well. In the long test each call, each way, and each call that fails for each reason that it may have."""
    folder = pathlib.Path().resolve()
    library = shim(folder)
    if not library:
        return "no cc, or a build with sanitizers"
    reference = Reference(folder / "small", SMALL)
    assert sum(name.endswith(".failed") for name in reference.content[0]) == 2
    for stage in range(2):
        calls = calls_of(library, reference, folder, stage)
        assert calls >= 8, calls
        for at in range(1, calls + 1, 1 if long else 3):
            for do in ("KILL", "POWER") if long else (("KILL", "POWER")[at % 2],):
                killed_at(library, reference, folder, stage, do, at)
            for do in ("ENOSPC", "EDQUOT", "EIO", "EROFS") if long else ():
                refused_at(library, reference, folder, stage, do, at)
        print(f"stage {stage}: {calls} calls")
    return None


if __name__ == "__main__":
    main(random_moments, every_call)
