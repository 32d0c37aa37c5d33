"""Every bit is the same without optimisation, with another compiler, and in a build for this machine alone:
benchmarks/same_numbers of the command and of builds that this test makes.

usage: test_same_numbers_long.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
BUILDS = {"-O0": ["-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_C_FLAGS_DEBUG=-O0"],
          "clang": ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_C_COMPILER=clang"],
          "-march=native": ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_C_FLAGS=-march=native"]}


def build(folder, options):
    given = ["-DSONOPACK_TESTS=OFF", "-DSONOPACK_PYTHON=ON", *options]
    subprocess.run(["cmake", "-S", SOURCE, "-B", folder, *given], check=True, capture_output=True)
    done = subprocess.run(["cmake", "--build", folder, "-j2"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:]
    return folder / "sonopack"


for name, options in BUILDS.items():
    if name == "clang" and not shutil.which("clang"):
        continue
    with tempfile.TemporaryDirectory() as folder:
        command = build(pathlib.Path(folder), options)
        done = subprocess.run([SOURCE / "benchmarks/same_numbers", COMMAND, command, "--bits"], capture_output=True,
                              text=True)
        assert done.returncode == 0, (name, [line for line in done.stdout.splitlines() if not line.startswith("same ")])
        print(name, done.stdout.splitlines()[-1])
