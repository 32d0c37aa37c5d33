"""Random options with extreme values, of every command: none crashes, none works long without progress, none takes memory that
4 GB do not hold without saying so, and what fails says why.

usage: test_absurd_long.py COMMAND SOURCE_DIR [COUNT [SEED [SECONDS]]]
SECONDS of CPU time are more than 30: by then work has told of itself.
"""
import collections
import os
import pathlib
import random
import shutil
import sys
import tempfile

import absurd

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
COUNT, SEED, SECONDS = (int(word) for word in (sys.argv[3:] + ["1000", "1", "60"][len(sys.argv) - 3:]))


def fill(folder, spare):
    """What an earlier command line has written or replaced is gone."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(spare, folder, symlinks=True)


def main():
    home = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-absurd-"))
    spare, folder = home / "spare", home / "a" / "b"
    spare.mkdir(), folder.parent.mkdir()
    faults, ends, most = [], collections.Counter(), 0
    try:
        absurd.seeds(COMMAND, spare, SOURCE)
        helps, keys = absurd.helps_of(COMMAND), absurd.keys_of(COMMAND)
        for k in range(COUNT):
            if k % 20 == 0:
                fill(folder, spare)
            words = absurd.case(random.Random(f"{SEED} {k}"), helps, keys)
            status, text, spent, memory = absurd.run(COMMAND, words, folder, SECONDS)
            fault = absurd.judge(status, text)
            ends[status] += 1
            most = max(most, memory)
            if fault or os.environ.get("ABSURD_TELL") and (spent > 10 or memory > 1000):
                print(f"{SEED} {k}: {fault}: {' '.join(map(repr, words))[:400]}: {status}, {spent:.1f} s, {memory:.0f} MB, "
                      f"{text[:200]!r}", flush=True)
            faults += [fault] if fault else []
    finally:
        shutil.rmtree(home, ignore_errors=True)
    print(f"{COUNT} command lines, seed {SEED}: ended with {dict(ends)}; at most {most:.0f} MB; {len(faults)} faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
