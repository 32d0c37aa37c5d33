"""What tests of studies share: the command, and the tables that it prints."""
import subprocess
import sys

import numpy as np

COMMAND = sys.argv[1]


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stdout, done.stderr)
    return done


def tables(text):
    """Every table of a stream: [(comments, names, rows of words)]."""
    found = []
    for block in text.split("\n\n"):
        lines = block.strip("\n").splitlines()
        comments = [line[1:].strip() for line in lines if line.startswith("#")]
        rows = [line.split("\t") for line in lines if not line.startswith("#")]
        found.append((comments, rows[0], rows[1:]))
    return found


def column(table, name):
    return np.array([float(row[table[1].index(name)]) for row in table[2]])


def comment(table, key):
    return next(line.split(" = ", 1)[1].strip() for line in table[0] if line.startswith(key + " ="))
