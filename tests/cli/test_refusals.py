"""What the command refuses (refusals.txt): each ends with the status of its row, one reason on stderr that names the
option, key or file at fault, nothing on stdout, no file, and little memory.

usage: test_refusals.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import resource
import shlex
import shutil

from command import N200, N600, main, pack, run, start
from common import expect, names_all

CASES = pathlib.Path(__file__).with_name("refusals.txt")
MOST, SPACE = 1 << 30, 4 << 30  # bytes of memory, and of address space
SMALL = {"protocol": "quick", "grains": 60, "width": 8}
MADE = {"P.h5": SMALL, "thin.h5": {**SMALL, "width": 12}, "smooth.h5": {**SMALL, "friction": 0},
        "cell.h5": {**SMALL, "cell": "periodic"}, "C.h5": {"kind": "chain", "grains": 12},
        "spheres.h5": {**SMALL, "dimension": 3, "width": 5}}
SCENES = {"scene.cfg": "packing = { grains = [20, 30]; width = 6; };\nstudy = { samples = 2; };\n",
          "sweep.cfg": 'study = { samples = 2; sweep = ( { key = "packing.pressure"; values = [1e-5, 1e-4]; } ); };\n',
          "wrong.cfg": "packing = {\n\n presure = 1e-4; };", "open.cfg": "packing = { /* no end", "empty.cfg": "",
          "include.cfg": '@include "/etc/hostname"', "deep.cfg": "a = " + "(" * 100000, "long.cfg": "a" * 100000,
          "zero.cfg": "packing\0", "pressed.cfg": "# a note\n// and another\n/* one */ packing :\n{ pressure = 1e-4; };\n"}


def make_inputs():
    for path, name in ((N200, "N200.txt"), (N600, "N600.txt")):
        shutil.copy(path, name)
    for name, text in SCENES.items():
        pathlib.Path(name).write_text(text)
    for name, keys in MADE.items():
        pack(name, **keys)
    pathlib.Path("empty").mkdir()
    run("study", "--store", "store", "--set=packing.kind=chain", "--set=packing.grains=12", "--set=study.samples=1")
    for form in ("tsv", "csv"):
        run("signal", "N200.txt", "-o", f"signal.{form}")
    for form in ("dump", "xyz"):
        run("convert", "P.h5", f"grains.{form}", "-q")
    run("modes", "C.h5", "--vectors", "modes.h5", "-o", "modes.tsv")


def refused(words):
    """Exit status, stdout, stderr, largest memory."""
    with open("../out", "w+") as out, open("../err", "w+") as err:
        process = start(*words, stdout=out, stderr=err)
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


def refusals():
    os.mkdir("work")
    os.chdir("work")
    make_inputs()
    resource.setrlimit(resource.RLIMIT_AS, (SPACE, SPACE))  # for all that are started
    for line in CASES.read_text().splitlines():
        if line and line[0] != "#":
            check(line)


main(refusals)
