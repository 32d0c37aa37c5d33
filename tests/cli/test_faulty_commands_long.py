"""The whole sweep of faulty calls: in every command calls of every kind fail, spread over all that it makes; and more of
those of test_faulty_commands.py. A table of what came of them goes to stdout.

usage: test_faulty_commands_long.py COMMAND SOURCE_DIR [MOST [COMMANDS [KINDS]]]
    MOST: how many calls of a kind fail, one run each (6); COMMANDS, KINDS: regular expressions
"""
import collections
import re
import sys

from common import expect
from faulty import COMMANDS, KINDS, try_all
from test_faulty_commands import every_call


def sweep(tried, name, kind, most):
    """What came of faults of one kind: {outcome: runs}."""
    calls, tally = tried.count(name, kind), collections.Counter()
    places = sorted({1 + calls * k // min(most, calls) for k in range(min(most, calls))})
    for how, error in KINDS[kind]:
        for at in places:
            outcome, fault = tried.judge(name, kind, how, error, at)
            tally[outcome] += 1
            expect(not fault, f"{name}, call {at} of {kind}, {how} {error}: {fault}")
    return tally


def main(tried):
    words = dict(enumerate(sys.argv[3:]))
    most, commands, kinds = int(words.get(0, 6)), words.get(1, ".*"), words.get(2, ".*")
    total = collections.Counter()
    for name in (name for name in COMMANDS if re.fullmatch(commands, name)):
        for kind in (kind for kind in KINDS if re.fullmatch(kinds, kind)):
            tally = sweep(tried, name, kind, most)
            total += tally
            if tally:
                print(name, kind, tried.count(name, kind), dict(tally), sep="\t", flush=True)
    if len(words) < 2:
        every_call(tried, closer=5)
    print(f"{sum(total.values())} runs: {dict(total)}")


if __name__ == "__main__":
    try_all(main)
