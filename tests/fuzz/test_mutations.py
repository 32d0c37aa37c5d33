"""Files with random damage never crash the command: it does its work or says in one line why not. Files of other programs
are damaged in tests/shows/formats/test_import.py.

usage: test_mutations.py COMMAND SOURCE_DIR [SEED [CASES]]
"""
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

from damage import mutate

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
SEED = int(sys.argv[3]) if len(sys.argv) > 3 else 20050201
CASES = int(sys.argv[4]) if len(sys.argv) > 4 else 14


def run(arguments, folder):
    # HDF5 1.10 itself loses memory when a checksum of a file's metadata is wrong
    (folder / "suppressions").write_text("leak:libhdf5\n")
    env = dict(os.environ, LSAN_OPTIONS=f"suppressions={folder / 'suppressions'}:print_suppressions=0")
    return subprocess.run([COMMAND, *arguments], cwd=folder, env=env, capture_output=True, timeout=1200,
                          stdin=subprocess.DEVNULL)


def fault_of(result):
    """What is wrong with the way in which the command ended, or None."""
    stderr = result.stderr.decode(errors="replace")
    if result.returncode not in (0, 1, 2):
        return f"ended with {result.returncode}: {stderr}"
    if "Sanitizer" in stderr or "runtime error" in stderr:
        return stderr
    if result.returncode and not re.match(r"sonopack[ \w]*: \S", stderr):
        return f"gave no reason: {stderr!r}"
    return None


def prepare(folder):
    """The sound files, and the commands that read them."""
    chain = ["--set", "packing.kind=chain", "--set", "packing.grains=12", "--set", "packing.friction=0"]
    cell = ["--set", "packing.cell=periodic", "--set", "packing.grains=30", "--set", "packing.pressure=1e-3"]
    for arguments in (["pack", *chain, "-o", "good.h5"], ["pack", *chain, "-o", "good.txt"],
                      ["pack", *cell, "-o", "cell.txt"], ["signal", "good.h5", "--points", "100", "-o", "trace.tsv"]):
        result = run(arguments, folder)
        assert result.returncode == 0, (arguments, result)
    scene = (SOURCE / "packings/chain.cfg").read_bytes() + (
        b'network = { prestress = [true, false]; threshold = { from = 1e-5; to = 1e-3; count = 3; spacing = "log"; }; };\n'
        b'study = { samples = 2; want = ["ctof"]; sweep = ( { key = "packing.pressure"; values = [1e-6, 1e-4]; },\n'
        b'  { key = "packing.sizes"; values = ["uniform", "lognormal"]; },\n'
        b'  { key = "packing.poisson"; from = 0; to = 0.4; step = 0.1; },\n'
        b'  { key = "packing.history"; values = ( [] ); } ); };\n')
    (folder / "scene.cfg").write_bytes(scene)
    # grains = 3 on the command line keeps damaged scenes from asking for much work
    small = ["--set", "packing.kind=chain", "--set", "packing.dimension=1", "--set", "packing.grains=3",
             "--set", "packing.friction=0"]
    return [("good.txt", ["signal", "damaged.txt", "--points", "20", "--until", "20"]), ("good.txt", ["check", "damaged.txt"]),
            ("cell.txt", ["moduli", "damaged.txt"]),
            ("good.h5", ["check", "damaged.h5"]), ("trace.tsv", ["front", "damaged.tsv"]),
            ("scene.cfg", ["pack", "damaged.cfg", *small, "--force", "-o", "out.h5"])]


def main():
    print(f"seed {SEED}, {CASES} cases each")
    faults, ended = [], {0: 0, 1: 0, 2: 0}
    with tempfile.TemporaryDirectory(prefix="sonopack-fuzz-") as scratch:
        folder = pathlib.Path(scratch)
        for number, (good, arguments) in enumerate(prepare(folder)):
            data = (folder / good).read_bytes()
            damaged = folder / next(word for word in arguments if word.startswith("damaged"))
            damaged.write_bytes(data)
            assert run(arguments, folder).returncode == 0, arguments
            for case in range(CASES):
                damaged.write_bytes(mutate(data, random.Random(f"{SEED} {number} {case}")))
                (folder / "out.h5").unlink(missing_ok=True)
                result = run(arguments, folder)
                ended[result.returncode] = ended.get(result.returncode, 0) + 1
                fault = fault_of(result)
                if "out.h5" in arguments and (folder / "out.h5").exists() != (result.returncode == 0):
                    fault = f"{fault or ''}, status {result.returncode}, and the file is not as it should be"
                if fault:
                    faults.append(f"seed {SEED}, {' '.join(arguments)}, case {case}: {fault}")
            damaged.unlink()
    print("exit statuses:", ended)
    # a check that never refuses, or always does, would test nothing
    assert ended[0] and ended[1], ended
    print(*faults[:20], sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
