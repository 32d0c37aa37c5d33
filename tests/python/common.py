"""What the tests of the Python package share."""
import pathlib
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()


def check(condition, *what):
    if not condition:
        print("failed:", *what, sep="\n  ")
        sys.exit(1)


def command(*arguments, **more):
    """Runs the built command; its stdout."""
    result = subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, **more)
    check(result.returncode == 0, arguments, result.stdout, result.stderr)
    return result.stdout


def raised(kind, function, *arguments, **more):
    """The exception that a call must raise."""
    try:
        result = function(*arguments, **more)
    except kind as fault:
        return fault
    check(False, f"{function} with {arguments} {more} raised no {kind.__name__}, but returned {result!r}")


def scratch():
    return tempfile.TemporaryDirectory(prefix="sonopack-python-")


def run(*trials):
    for trial in trials:
        trial()
        print(trial.__name__, "ok", flush=True)
