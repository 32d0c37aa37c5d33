"""What the command refuses (refusals.txt): each ends with the status of its row, one reason on stderr that names the
option, key or file at fault, nothing on stdout, no file, and little memory.

usage: test_refusals.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile

from common import expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
CASES = pathlib.Path(__file__).with_name("refusals.txt")
MOST, SPACE = 1 << 30, 4 << 30  # bytes of memory, and of address space
SMALL = "--set packing.protocol=quick --set packing.grains=60 --set packing.width"
MADE = {"P.h5": f"{SMALL}=8", "thin.h5": f"{SMALL}=12", "smooth.h5": f"{SMALL}=8 --set packing.friction=0",
        "cell.h5": f"{SMALL}=8 --set packing.cell=periodic", "C.h5": "--set packing.kind=chain --set packing.grains=12",
        "spheres.h5": f"{SMALL}=5 --set packing.dimension=3"}


def make_inputs():
    for n in (200, 600):
        shutil.copy(SOURCE / f"packings/reference/packing_N{n}_p1e-4.txt", f"N{n}.txt")
    pathlib.Path("scene.cfg").write_text('packing = { grains = [20, 30]; width = 6; };\nstudy = { samples = 2; };\n')
    pathlib.Path("store").mkdir()
    for name, words in MADE.items():
        subprocess.run([COMMAND, "pack", *words.split(), "-q", "-o", name], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([COMMAND, "signal", "N200.txt", "-o", "signal.tsv"], check=True)


def refused(words):
    """Exit status, stdout, stderr, largest memory."""
    with open("../out", "w+") as out, open("../err", "w+") as err:
        process = subprocess.Popen([COMMAND, *words], stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (SPACE, SPACE)))
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, *(file.seek(0) or file.read() for file in (out, err)), 1024 * used.ru_maxrss


def check(line):
    status, names, command = (part.strip() for part in line.split("|", 2))
    before = sorted(os.listdir())
    code, out, err, memory = refused(shlex.split(command))
    reason = next((line for line in err.splitlines() if "warning" not in line), "")
    if reason.startswith("sonopack " + command.split()[0] + ": "):
        reason = reason.split(": ", 1)[1]
    expect(code == int(status), f"{command}: exit status {code}, must be {status}: {err[:300]}")
    expect(err.startswith("sonopack") and names_all(reason, names), f"{command}: {reason[:300]!r} names no {names}")
    expect(not out or command.startswith(("moduli no_such", "check")), f"{command}: prints {out[:100]!r}")
    expect(memory < MOST, f"{command}: {memory / 1e6:.0f} MB")
    expect(sorted(os.listdir()) == before, f"{command}: leaves {set(os.listdir()) - set(before)}")


def main():
    lines = [line for line in CASES.read_text().splitlines() if line and line[0] != "#"]
    with tempfile.TemporaryDirectory(prefix="sonopack-refusals-") as home:
        (pathlib.Path(home) / "work").mkdir()
        os.chdir(pathlib.Path(home) / "work")
        make_inputs()
        for line in lines:
            check(line)
        os.chdir("/")
    print(*faults, f"{len(lines)} refusals", sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
