"""A call that fails anywhere in a command (of memory, files, locks, threads, clocks) ends it with one clear line, or
changes nothing: no other output, no part of a file, no temporary left, and a store as whole as before.

usage: test_faulty_commands.py COMMAND SOURCE_DIR
"""
import collections
import errno

from common import expect
from faulty import COMMANDS, KINDS, try_all

# every call, or every few calls, of these fail, once or all from there on: (command, kind, how, error, step)
EVERY = [
    ("statics-tall", "read", "ONCE", errno.EIO, 3),  # of what is optional too
    ("statics-tall", "read", "ONCE", errno.EINTR, 9),
    ("statics-tall", "read", "ONCE", "SHORT", 9),
    ("study-again", "read", "ONCE", errno.EIO, 29),
    ("study-verify", "read", "ON", errno.ESTALE, 37),  # no good sample is put aside
    ("study-verify", "foreign", "ONCE", errno.ENOMEM, 503),  # HDF5 begins by half
    ("study-again", "open", "ONCE", errno.EMFILE, 3),
    ("study-again", "stat", "ONCE", errno.ESTALE, 9),
    ("table", "list", "ONCE", errno.EIO, 1),  # no sample is left out
    ("table", "stat", "ONCE", errno.ESTALE, 1),
    ("table", "read", "ONCE", errno.ESTALE, 1),
    ("pack-text", "stat", "ONCE", errno.ESTALE, 1),  # no temporary is left
    ("pack-text", "write", "ONCE", errno.ENOSPC, 1),
    ("statics", "own", "ONCE", errno.ENOMEM, 1),  # no row without its name
    ("column-bifurcation", "own", "ONCE", errno.ENOMEM, 4),  # no point becomes nan
    ("chain-modes", "foreign", "ONCE", errno.ENOMEM, 1),  # not done, and no word of it
    ("study", "foreign", "ONCE", errno.ENOMEM, 5000),  # the first: OpenBLAS on one thread
]


def every_call(tried, closer=1):
    """closer: how much shorter the steps are."""
    for name, kind, how, error, step in EVERY:
        step = max(step // closer, 1)
        calls = tried.count(name, kind)
        expect(calls > 0, f"{name} makes no call of {kind}")
        for at in range(1, calls + 1, step):
            fault = tried.judge(name, kind, how, error, at)[1]
            expect(not fault, f"{name}, call {at} of {kind}, {how} {error}: {fault}")
        print(f"{name}: of {calls} calls of {kind} every {step}. has failed, {how} {error}")


def some_calls(tried):
    """One call of each command, of one kind after another; kinds that a command does not use are passed over."""
    kinds, tally = [kind for kind in KINDS if kind != "foreign"], collections.Counter()
    for turn, name in enumerate(COMMANDS):
        used = [kind for kind in kinds if tried.count(name, kind) > 0]
        if not used:  # --version
            continue
        kind = min(used, key=lambda kind: (tally[kind], kinds.index(kind)))
        how, error = KINDS[kind][turn % len(KINDS[kind])]
        at = 1 + tried.count(name, kind) * (turn % 7) // 7
        fault = tried.judge(name, kind, how, error, at)[1]
        expect(not fault, f"{name}, call {at} of {kind}, {how} {error}: {fault}")
        tally[kind] += 1
    print(f"one call of each of {len(COMMANDS)} commands has failed: {dict(tally)}")


def main(tried):
    every_call(tried)
    some_calls(tried)


if __name__ == "__main__":
    try_all(main)
