"""What the tests of the Python package share."""
import os
import pathlib
import subprocess

import pytest

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
