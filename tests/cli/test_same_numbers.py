"""The same numbers whatever runs the command: benchmarks/same_numbers on a few commands with other kernels of OpenBLAS,
without the processor's fused operations in the C library, with more threads, with memory that is never clean, and with
other settings of the user. Bits are the same where no other library's kernel is changed.

usage: test_same_numbers.py COMMAND SOURCE_DIR
"""
import pathlib
import platform
import re
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
FEW = "^(pack-quick|pack-text|signal-(dense|planes|json)|modes|modes-spheres|moduli-strain|spectrum-(harmonic|dos-one)|wave-options|" \
      "convert-tables-out|study-kept|column-fine|transport-kubo|sensitivity-c_l)$"


def compare(*options, only=FEW):
    """The numbers of the last line: commands, values, and values with other bits."""
    done = subprocess.run([SOURCE / "benchmarks/same_numbers", COMMAND, COMMAND, "--only", only, *options],
                          capture_output=True, text=True)
    assert done.returncode == 0, (options, done.stdout, done.stderr)
    last = done.stdout.splitlines()[-1]
    commands, values, other = (int(re.search(rf"(\d+) {what}", last)[1]) for what in ("commands", "values", "with other"))
    assert commands >= only.count("|") and values > 1000, last
    return other


def test_bits():
    """One run with all that must not matter: freshly allocated and freed memory is filled, more threads, a user with
    another language and zone, and without a home."""
    settings = ("MALLOC_PERTURB_=165", "GLIBC_TUNABLES=glibc.malloc.tcache_count=0:glibc.malloc.mxfast=0",
                "LC_ALL=tr_TR.UTF-8", "LANG=de_DE.UTF-8", "TZ=Pacific/Chatham", "HOME=", "OPENBLAS_NUM_THREADS=3",
                "OMP_NUM_THREADS=3")
    assert compare("--bits", "--threads", "3", *(word for pair in settings for word in ("--set", pair))) == 0


def test_kernels():
    """OpenBLAS's kernels for the oldest processor, and the C library's functions without fused operations."""
    if platform.machine() != "x86_64":
        return
    other = compare("--set", "OPENBLAS_CORETYPE=Nehalem", "--set",
                    "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL")
    # so that something was compared; where the processor has no such units nothing is changed
    assert other > 0 or "fma" not in pathlib.Path("/proc/cpuinfo").read_text()


def test_sees_differences():
    """The comparison finds what it should: a command that leaves out a few contacts has other frequencies."""
    with tempfile.TemporaryDirectory() as folder:
        other = pathlib.Path(folder, "other")
        other.write_text(f'#!/bin/sh\nexec {COMMAND} "$@" --threshold 0.3\n')
        other.chmod(0o700)
        done = subprocess.run([SOURCE / "benchmarks/same_numbers", COMMAND, other, "--only", "^modes-lowest$"],
                              capture_output=True, text=True)
    assert done.returncode == 1 and "1 DIFFERENT" in done.stdout, done.stdout


test_bits()
test_kernels()
test_sees_differences()
print("same numbers")
