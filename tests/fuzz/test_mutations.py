"""Files with random damage never crash the command: it does its work or says in one line why not.

usage: test_mutations.py COMMAND SOURCE_DIR [SEED [CASES]]
"""
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
SEED = int(sys.argv[3]) if len(sys.argv) > 3 else 20050201
CASES = int(sys.argv[4]) if len(sys.argv) > 4 else 40
HOSTILE = [b"nan", b"inf", b"-inf", b"-1", b"0", b"1e308", b"-1e-320", b"99999999999999999999", b"2147483648", b"0x1p3",
           b"", b"1,5", b"top", b"\x00", b"\xff\xfe", b"%s%n", b"(" * 2000, b"9" * 5000, b"bottom", b'"', b"}", b"/*",
           b"=", b"#", b"ITEM: ATOMS id", b"3 0 0 0 0 1 1 1\n"]
# a build with sanitizers is without Python, and so without `convert'
PYTHON = pathlib.Path(COMMAND).with_name("sonopack-convert").exists()
SAMPLES = SOURCE.resolve() / "tests/foreign/samples"
# files of other programs, and what is said beside them; where that names `damaged', contacts of sound grains
IMPORTS = [
    ("lammps/layer_grains.dump", "--contacts lammps/layer_contacts.dump --types 1"),
    ("lammps/layer_contacts.dump", "lammps/layer_grains.dump --contacts damaged --types 1"),
    ("lammps/layer.data", "--contacts overlap --types 1"),
    ("lammps/sheared_grains.dump", "--contacts lammps/sheared_contacts.dump"),
    ("lammps/sheared.data", "--contacts overlap"),
    ("lammps/box_grains.dump", "--contacts lammps/box_contacts.dump"),
    ("yade/packing_id.txt", "--set width=4 --set depth=4 --set bottom=5 --set top=8.92966"),
    ("mercury/layer.data", "--contacts mercury/layer.fstat"),
    ("xyz/layer.xyz", "--contacts csv/contacts.csv --walls csv/walls.csv"),
    ("photoelastic/particles.csv", "--contacts photoelastic/contacts.csv --material E=4e6,nu=0.5,rho=1060 "
                                   "--length-unit 5e-5 --kn 5e4 --walls balance"),
]


def mutate(data, rng):
    """One to four faults: in a number, a line, a range of bytes, a bit, or at the end."""
    for _ in range(rng.randint(1, 4)):
        kind = rng.randrange(6)
        if kind == 0 and (numbers := list(re.finditer(rb"[-+.\w]+", data))):
            spot = rng.choice(numbers)
            data = data[:spot.start()] + rng.choice(HOSTILE) + data[spot.end():]
        elif kind == 1:
            lines = data.split(b"\n")
            i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
            if rng.random() < 0.5:
                lines[i], lines[j] = lines[j], lines[i]
            else:
                lines[i:i] = [lines[j]] * rng.choice((0, 1, 100))
                del lines[i]
            data = b"\n".join(lines)
        elif kind == 2 and data:
            start = rng.randrange(len(data))
            data = data[:start] + data[start + rng.randrange(1, 200):]
        elif kind == 3 and data:
            spot = rng.randrange(len(data))
            data = data[:spot] + bytes([data[spot] ^ 1 << rng.randrange(8)]) + data[spot + 1:]
        elif kind == 4:
            data = data[:rng.randrange(len(data) + 1)]
        else:
            spot = rng.randrange(len(data) + 1)
            data = data[:spot] + rng.choice(HOSTILE) + data[spot:]
    return data


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


def imports():
    convert = ["convert", "--force", "out.h5"]
    yield "grains.tsv", [*convert, "--grain-table", "damaged.tsv", "--contact-table", "contacts.tsv"]
    yield "contacts.tsv", [*convert, "--grain-table", "grains.tsv", "--contact-table", "damaged.tsv"]
    for name, words in IMPORTS:
        words = [str(SAMPLES / word) if "/" in word else word for word in words.split()]
        first = [] if "damaged" in words else ["damaged"]
        yield SAMPLES / name, ["convert", *first, *words, "--set", "friction=0.5", "--force", "-o", "out.h5"]


def prepare(folder):
    """The sound files, and the commands that read them."""
    chain = ["--set", "packing.kind=chain", "--set", "packing.grains=12", "--set", "packing.friction=0"]
    cell = ["--set", "packing.cell=periodic", "--set", "packing.grains=30", "--set", "packing.pressure=1e-3"]
    tables = [["convert", "good.h5", "--grain-table", "grains.tsv", "--contact-table", "contacts.tsv"]]
    for arguments in (["pack", *chain, "-o", "good.h5"], ["pack", *chain, "-o", "good.txt"],
                      ["pack", *cell, "-o", "cell.txt"], ["signal", "good.h5", "--points", "100", "-o", "trace.tsv"],
                      *(tables if PYTHON else [])):
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
            ("scene.cfg", ["pack", "damaged.cfg", *small, "--force", "-o", "out.h5"]), *(imports() if PYTHON else [])]


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
            # a start of Python takes as long as ten of the command
            for case in range(CASES // 10 if "convert" in arguments else CASES):
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
