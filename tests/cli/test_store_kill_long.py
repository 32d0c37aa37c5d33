"""kill -9 at a hundred random moments and at every call that changes the store; and every such call that fails, for
each reason that it may have.

usage: test_store_kill_long.py COMMAND SOURCE_DIR
"""
from command import main
from test_store_kill import every_call, random_moments


def moments():
    random_moments(100, 40)


def calls():
    return every_call(long=True)


main(moments, calls)
