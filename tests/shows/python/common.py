"""What the tests of the Python package share."""
import os
import pathlib
import subprocess

import numpy as np
import pytest

import sonopack

COMMAND, SOURCE = os.environ["SONOPACK"], pathlib.Path(__file__).parents[3]


def command(*arguments, **more):
    """Runs the built command; its stdout."""
    result = subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, **more)
    assert result.returncode == 0, (arguments, result.stdout, result.stderr)
    return result.stdout


def raised(kind, function, *arguments, **more):
    """The exception that a call must raise."""
    with pytest.raises(kind) as found:
        function(*arguments, **more)
    return found.value


def table(*words):
    """The table that a command writes."""
    command(*words, "-o", "table.tsv", "--force", "--quiet")
    return sonopack.Table.read("table.tsv")


def equal(read, name, values, what=""):
    """A column has these numbers: bits, signs of zeros and nan included."""
    column, values = np.asarray(read[name], float), np.atleast_1d(np.asarray(values, float))
    assert column.shape == values.shape, (what, name, column.shape, values.shape)
    same = (column.view(np.int64) == values.view(np.int64)) | (np.isnan(column) & np.isnan(values))
    assert same.all(), (what, name, column[~same], values[~same])
