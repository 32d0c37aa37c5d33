"""Minutes of libFuzzer on every reader: builds the targets of tests/guided with clang and runs their campaign.

usage: test_guided_long.py COMMAND SOURCE_DIR

SONOPACK_GUIDED_RUNS: executions of each target, 20000 if it is not set.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(sys.argv[2])
RUNS = int(os.environ.get("SONOPACK_GUIDED_RUNS", "20000"))


def run(*words):
    done = subprocess.run(words, cwd=SOURCE, capture_output=True, text=True)
    assert done.returncode == 0, (words, done.stdout[-3000:], done.stderr[-3000:])
    return done.stdout


def main():
    if shutil.which("clang") is None:
        print("skipped: clang is not installed")
        sys.exit(77)
    targets = re.search(r"set\(guided_targets ([\w ]+)\)", (SOURCE / "tests/guided/CMakeLists.txt").read_text())[1].split()
    with tempfile.TemporaryDirectory(prefix="sonopack-guided-") as build:
        run("cmake", "--preset", "guided", "-B", build)
        run("cmake", "--build", build, "--parallel", "2", "--target", "guided_programs")
        table = subprocess.run([SOURCE / "tests/guided/campaign", build, str(RUNS)], capture_output=True, text=True)
        print(table.stdout, table.stderr)
        faults = [path for path in pathlib.Path(build).glob("campaign/*.findings/*")]
        for path in faults:
            print(path.name, path.read_bytes().hex(), (path.parent.with_suffix(".log")).read_text()[-3000:])
        rows = [line.split("\t") for line in table.stdout.splitlines()[1:]]
        assert table.returncode == 0 and not faults, table.stderr
        assert [row[0] for row in rows] == targets and all(int(row[1]) >= RUNS for row in rows), rows


main()
