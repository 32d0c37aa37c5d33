"""What the tests of the Python package's commands share."""
import os
import pathlib
import subprocess
import sys

import pytest

sys.path.append(str(pathlib.Path(__file__).parents[1] / "cli"))
from warm import warm  # noqa: E402

SOURCE = pathlib.Path(__file__).parents[2]


@pytest.fixture(scope="session")
def source():
    """The folder of the sources."""
    return SOURCE


@pytest.fixture
def sonopack(tmp_path):
    """Runs `sonopack ARGUMENTS` in a folder of its own; the exit status must be `status`. Returns the process with its
    stdout and stderr."""
    def run(*arguments, status=0, **more):
        command = warm(os.environ["SONOPACK"]) / "sonopack"
        done = subprocess.run([command, *map(str, arguments)], text=True, capture_output=True,
                              cwd=more.pop("cwd", tmp_path), **more)
        assert done.returncode == status, f"{arguments}: status {done.returncode}\n{done.stderr}"
        return done
    return run
