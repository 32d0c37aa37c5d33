"""test_forged_samples.py with every number of every kind of sample made false in every way.

usage: test_forged_samples_long.py COMMAND SOURCE_DIR
"""
from command import main
from test_forged_samples import every_number, honest


def every_way():
    every_number(more=True)


main(honest, every_way)
