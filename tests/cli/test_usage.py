"""What scripts rely on: exit statuses, one-line reasons, streams, overwriting, interruption, the tables of pack, check
and statics.

usage: test_usage.py COMMAND SOURCE_DIR
"""
import json
import math
import os
import pathlib
import pty
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile

from common import PATIENCE, names_all, wait_for_work, worked

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
SMALL = ["--set", "packing.grains=60", "--set", "packing.width=8"]
LONG = ["--set", "packing.grains=3000", "--set", "packing.pressure=1e-8"]  # minutes, if nobody stopped it
LARGE = ["--set", "packing.grains=300000", "--set", "packing.width=500"]
faults = []


def run(*arguments, **options):
    return subprocess.run([COMMAND, *map(str, arguments)], text=True, stdin=subprocess.DEVNULL, timeout=PATIENCE,
                          **{"capture_output": True, **options})


def expect(good, what):
    if not good:
        faults.append(what)


def expect_status(status, *arguments, reason="", **options):
    """Runs, and wants this exit status and for a failure a first line on stderr that is the reason."""
    result = run(*arguments, **options)
    line = (result.stderr or "").split("\n")[0]
    expect(result.returncode == status, f"{arguments}: exit status {result.returncode}, expected {status}: {line}")
    if status:
        expect(line.startswith("sonopack") and names_all(line, reason), f"{arguments}: {line!r} does not say {reason!r}")
        expect(status == 1 or not result.stdout, f"{arguments}: data on stdout after wrong usage")
    return result


def rows(text):
    """Of a TSV table: a dictionary a row."""
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return [dict(zip(lines[0], line, strict=True)) for line in lines[1:]]


def check_help():
    for arguments in (["help"], ["--help"], ["help", "help"]):
        result = expect_status(0, *arguments)
        expect(result.stdout.startswith("Usage: sonopack") and not result.stderr, f"{arguments}: the overview")
    commands = re.findall(r"^  ([a-z]+) ", run("help").stdout, re.M)
    expect({"pack", "check", "statics", "signal", "study", "help"} <= set(commands), f"commands: {commands}")
    for command in commands:
        if command != "help":
            by_name, by_option = expect_status(0, "help", command), expect_status(0, command, "--help")
            expect(by_name.stdout == by_option.stdout and f"sonopack {command}" in by_name.stdout, f"help {command}")
    for arguments in (["--version"], ["pack", "--version"]):
        expect(re.fullmatch(r"sonopack \d+\.\d+\.\d+\n", run(*arguments).stdout), f"{arguments}")


def check_streams(folder):
    """A full disk, a closed stdout and a closed pipe are failures with a reason; a reader that has had enough is not."""
    for arguments in (["help"], ["help", "scene"], ["--version"]):
        with open("/dev/full", "w") as full:
            expect_status(1, *arguments, reason="No space left", capture_output=False, stdout=full,
                          stderr=subprocess.PIPE)
        closed = subprocess.run(["bash", "-c", '"$@" >&-', "bash", COMMAND, *arguments], text=True, capture_output=True)
        expect(closed.returncode == 1 and closed.stderr, f"{arguments} with stdout closed: {closed}")
    piped = subprocess.run(["bash", "-c", f"trap '' PIPE; '{COMMAND}' help scene; echo $? >&2"], text=True,
                           stdout=broken_pipe(), stderr=subprocess.PIPE)
    expect("Broken pipe\n1\n" in piped.stderr, f"a broken pipe with SIGPIPE ignored: {piped.stderr!r}")
    quiet = subprocess.run([COMMAND, "help", "scene"], stdout=broken_pipe(), stderr=subprocess.PIPE, restore_signals=True)
    expect(quiet.returncode == -signal.SIGPIPE and not quiet.stderr, f"a broken pipe ends quietly: {quiet}")
    # with stdout closed no result file may become file 1 and get the summary
    closed = subprocess.run(["bash", "-c", '"$@" >&-', "bash", COMMAND, "pack", *SMALL, "-o", folder / "closed.txt"],
                            text=True, capture_output=True)
    expect(closed.returncode == 1 and closed.stderr, f"pack with stdout closed: {closed}")
    expect("grains\theight" not in (folder / "closed.txt").read_text(), "the summary went into the packing")


def broken_pipe():
    reader, writer = os.pipe()
    os.close(reader)
    return os.fdopen(writer, "w")


def check_overwriting(folder):
    packing = folder / "p.txt"
    result = expect_status(0, "pack", *SMALL, "-o", packing)
    before = packing.read_bytes()
    expect(not result.stderr, f"progress without a terminal: {result.stderr!r}")
    expect_status(2, "pack", *SMALL, "-o", packing, reason=packing)
    expect(packing.read_bytes() == before, "an existing file was replaced silently")
    expect_status(0, "pack", *SMALL, "--seed", "2", "-o", packing, "--force")
    expect(packing.read_bytes() != before, "--force does not replace")
    for name, content in (("foreign.h5", b"a letter to my aunt\n"), ("image.txt", b"\x89PNG\r\n\x1a\n" + bytes(50)),
                          ("page.txt", b"<html></html>\n"), ("program.txt", b"int main(void) { return 0; }\n")):
        path = folder / name
        path.write_bytes(content)
        expect_status(2, "pack", *SMALL, "-o", path, "--force", reason=path)
        expect(path.read_bytes() == content, f"{name} was replaced")
    (folder / "folder.h5").mkdir()
    expect_status(2, "pack", *SMALL, "-o", folder / "folder.h5", "--force", reason="folder.h5")
    expect_status(1, "pack", *SMALL, "-o", folder / "nowhere/p.h5", reason="nowhere")
    expect_status(2, "pack", *SMALL, "-o", folder / "p.dat", reason="-o")
    expect_status(2, "pack", *SMALL, "-o", "", reason="-o")
    expect_status(2, "statics", packing, "-o", folder / "t.h5", reason="-o")
    expect_status(2, "statics", packing, "-o", folder / "t.tsv", "--format", "csv", reason="--format")
    shutil.copy(packing, folder / "packing.tsv")
    expect_status(2, "statics", packing, "-o", folder / "packing.tsv", "--force", reason="packing.tsv")
    for name in ("t.tsv", "t.csv", "t.json"):
        expect_status(0, "statics", packing, "-o", folder / name)
    expect(json.loads((folder / "t.json").read_text()), "JSON")
    expect_status(0, "statics", packing, "-o", folder / "t.dat", "--format", "tsv")
    expect((folder / "t.dat").read_text() == (folder / "t.tsv").read_text(), "--format names the format of t.dat")


def check_summary(folder):
    result = expect_status(0, "pack", *SMALL, "--seed", "5", "-o", folder / "s.txt")
    (row,) = rows(result.stdout)
    expect(list(row) == "grains height p z_star rattlers residual steps seconds".split(), f"columns {list(row)}")
    expect(row["grains"] == "60" and float(row["p"]) == 1e-4, f"summary {row}")
    # 60 grains in a box 8 wide at an area fraction of 0.7 .. 0.9, and rest by the rule min(1e-10, 1e-6 p)
    area = 60 * 3.14159 / 4 * (1 + 0.4**2 / 12)
    expect(0.65 < area / (8 * float(row["height"])) < 0.9, f"height {row['height']}")
    expect(0 <= float(row["residual"]) <= 1e-10 and int(row["steps"]) > 0, f"residual {row['residual']}")
    expect(0 <= int(row["rattlers"]) < 30, f"rattlers {row['rattlers']}")
    text = expect_status(0, "pack", *SMALL, "--seed", "5", "-o", folder / "s5.txt", "--format", "json").stdout
    expect("z_star" in json.dumps(json.loads(text)), "--format json")
    expect((folder / "s.txt").read_bytes() == (folder / "s5.txt").read_bytes(), "a seed is not a packing, bit for bit")
    for name in ("one.h5", "two.h5"):
        expect_status(0, "pack", *SMALL, "--seed", "5", "-o", folder / name)
    expect((folder / "one.h5").read_bytes() == (folder / "two.h5").read_bytes(), "equal packings, unequal HDF5 files")


def change_grain(lines, n):
    """The first grain that carries, moved by a hundredth of a diameter."""
    words = lines[2 + carrying_grain(lines, n)].split()
    words[0] = repr(float(words[0]) + 0.01)
    lines[2 + carrying_grain(lines, n)] = " ".join(words)


def carrying_grain(lines, n):
    return next(int(line.split()[0]) for line in lines[2 + n:] if float(line.split()[5]) > 1e-5)


def strongest_pair(lines, n):
    return max(range(2 + n, len(lines)), key=lambda k: (int(lines[k].split()[1]) >= 0, float(lines[k].split()[5])))


def change_force(lines, n):
    words = lines[strongest_pair(lines, n)].split()
    words[5] = repr(1.01 * float(words[5]))
    lines[strongest_pair(lines, n)] = " ".join(words)


def change_tangential_force(lines, n):
    words = lines[strongest_pair(lines, n)].split()
    words[6] = repr(float(words[6]) + 0.1 * float(words[5]))
    lines[strongest_pair(lines, n)] = " ".join(words)


def change_header(word, factor):
    def change(lines, n):
        words = lines[1].split()
        words[words.index(word) + 1] = repr(factor * float(words[words.index(word) + 1]))
        lines[1] = " ".join(words)
    return change


def check_audit(folder):
    good = folder / "good.txt"
    expect_status(0, "pack", *SMALL, "-o", good)
    result = expect_status(0, "check", good)
    (row,) = rows(result.stdout)
    measures = "force torque walls law geometry coulomb missing".split()
    expect(list(row) == "file ok residual reason".split() + measures, f"columns {list(row)}")
    expect(max(float(row[name]) for name in measures) == float(row["residual"]), f"measures {row}")
    expect(float(row["force"]) > 0 and float(row["coulomb"]) >= 0, f"measures {row}")
    expect(row["ok"] == "yes" and row["file"] == str(good), f"a packing that was just made: {row}")
    # at rest by the rule 1e-6 p: forces balance to 1e-6 of p d^2 (masses are below 1), the piston of 12.5 to 1.25e-5
    expect(0 <= float(row["residual"]) <= 1.25e-5, f"residual {row['residual']}")
    expect_status(1, "check", good, "--tolerance", "0", reason="0")
    references = sorted((SOURCE / "packings/reference").glob("packing_*.txt"))
    expect(references and {row["ok"] for row in rows(expect_status(0, "check", *references).stdout)} == {"yes"},
           f"reference packings: {references}")
    # what is wrong shows in the measure of it; a header without sense leaves none
    changes = {"grain": (change_grain, "geometry"), "force": (change_force, "law"),
               "tangential": (change_tangential_force, "torque"), "pressure": (change_header("p", 2), "walls"),
               "friction": (change_header("mu", 0.1), "coulomb"),
               "nan": (change_header("p", float("nan")), None), "negative": (change_header("p", -1), None)}
    for name, (change, measure) in changes.items():
        lines = good.read_text().splitlines()
        change(lines, 60)
        path = folder / f"{name}.txt"
        path.write_text("\n".join(lines) + "\n")
        bad = run("check", good, path)
        table = rows(bad.stdout)
        expect(bad.returncode == 1 and [row["ok"] for row in table] == ["yes", "no"], f"check {name}: {bad}")
        expect(float(table[-1][measure]) > 1e-3 if measure else math.isnan(float(table[-1]["residual"])),
               f"check {name}: {table[-1]}")
        expect(table[-1]["reason"] != "-", f"check {name}: {table[-1]}")
        expect(str(path) in bad.stderr.split("\n")[0], f"check {name}: stderr {bad.stderr!r}")
    (folder / "empty.h5").write_bytes(b"")
    (folder / "noise.h5").write_bytes(bytes(range(256)) * 40)
    for name in ("empty.h5", "noise.h5", "absent.h5", "folder.h5"):
        result = expect_status(1, "check", folder / name, reason=name)
        expect([row["ok"] for row in rows(result.stdout)] == ["no"], f"check {name}: {result.stdout}")
        expect({row[name] for row in rows(result.stdout) for name in measures} == {"nan"}, f"measures of {name}")


def check_statics(folder):
    good = folder / "good.txt"
    result = run("statics", folder / "noise.h5", good, "--margin", "0.5")
    expect(result.returncode == 1 and "noise.h5" in result.stderr.split("\n")[0], f"statics of a bad file: {result}")
    (row,) = rows(result.stdout)
    expect(list(row) == "file p Phi2 Phi3 Phi3s zs f0 N_over_p Z2 Z3 F2 F2S s1_over_s2 s12_over_s2 s32_over_s2 "
           "mobilised".split(), f"columns {list(row)}")
    value = {name: float(text) for name, text in row.items() if name != "file"}
    # a disk of diameter 1 is pi/4 of its square, a sphere pi/6 of its cube: Phi3/Phi2 = 2/3 <d^3>/<d^2> for the
    # uniform diameters 0.8 .. 1.2, in a layer one mean diameter thick
    expect(abs(value["Phi3"] / value["Phi2"] - 2 / 3 * 1.04 / (1 + 0.16 / 12)) < 0.02, f"Phi3/Phi2 in {row}")
    expect(2 < value["zs"] < 4 and 0 < value["Phi3s"] <= value["Phi3"] and value["Z2"] >= 1, f"statics {row}")
    for grains in (200, 600):
        check_stress(SOURCE / f"packings/reference/packing_N{grains}_p1e-4.txt")
    none = run("statics", folder / "noise.h5")
    expect(none.returncode == 1 and not none.stdout, f"statics without any good file: {none}")


def check_stress(path):
    """Stress and mobilised friction by their sums, from the text of a packing whose contacts all carry."""
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    head = dict(zip(lines[0][::2], lines[0][1::2]))
    n = int(head["N"])
    radius = [float(line[2]) for line in lines[1:n + 1]]
    loose = [line[3] == "1" for line in lines[1:n + 1]]
    stress, full, contacts = {"11": 0, "12": 0, "22": 0}, 0, 0
    for line in lines[n + 1:]:
        i, j, (nx, ny, overlap, fn, ft) = int(line[0]), int(line[1]), map(float, line[2:7])
        if loose[i] or j >= 0 and loose[j]:
            continue
        branch = radius[i] - overlap + (radius[j] if j >= 0 else 0)
        fx, fy = fn * nx + ft * ny, fn * ny - ft * nx  # of i on j; ft is the force on i along (-ny, nx)
        stress["11"] += fx * branch * nx
        stress["12"] += fx * branch * ny
        stress["22"] += fy * branch * ny
        full += abs(ft) >= 0.99 * float(head["mu"]) * fn
        contacts += 1
    (row,) = rows(expect_status(0, "statics", path).stdout)
    for name, value in (("s1_over_s2", stress["11"] / stress["22"]), ("s12_over_s2", stress["12"] / stress["22"]),
                        ("mobilised", full / contacts)):
        expect(abs(float(row[name]) - value) < 1e-9, f"{path}: {name} = {row[name]}, {value} by its sum")
    expect((full, contacts) in ((4, 295), (5, 975)), f"{path}: {full} of {contacts} contacts are at the limit")
    expect(row["s32_over_s2"] == "nan", f"{path}: a second shear stress in the plane")


def check_interruption(folder):
    for kind in (signal.SIGINT, signal.SIGTERM):
        place = folder / f"stop{kind}"
        place.mkdir()
        process = subprocess.Popen([COMMAND, "pack", *LONG, "-o", place / "p.h5"], text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        wait_for_work(process, 0.3)
        process.send_signal(kind)
        output, error = process.communicate(timeout=PATIENCE)
        expect(process.returncode == 1 and not output, f"{kind!r}: exit status {process.returncode}, {output!r}")
        expect(error.count("\n") == 2 and names_all(error, place / "p.h5.state"), f"{kind!r}: {error!r}")
        left = {path.name for path in place.iterdir()}
        expect(left == {"p.h5.state"}, f"{kind!r} leaves {left}")
    # a step of many grains takes long, which stopping must not
    process = subprocess.Popen([COMMAND, "pack", *LARGE, "-o", folder / "large.h5"], stderr=subprocess.DEVNULL)
    wait_for_work(process, 1)
    before = worked(process)
    process.send_signal(signal.SIGINT)
    _, status, usage = os.wait4(process.pid, 0)
    used = usage.ru_utime + usage.ru_stime - before
    expect(os.waitstatus_to_exitcode(status) == 1, "a large packing is stopped")
    expect(used < 20, f"{used:.1f} s of work to stop a large packing")


def work_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def check_memory(folder):
    """More grains than fit are refused at once, before the machine is brought to its knees."""
    if os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGESIZE") < 100e9:
        before = work_of_children()
        expect_status(1, "pack", "--set", "packing.grains=100000000", "-o", folder / "huge.h5",
                      reason="packing.grains 100000000")
        expect(work_of_children() - before < 10, "it takes long to see that memory does not suffice")
    # OpenBLAS cannot start its threads in so little space; a process ends all the same (127: the loader's word)
    for kilobytes in (100000, 200000):
        try:
            done = subprocess.run(f"ulimit -v {kilobytes}; exec {COMMAND} --version", shell=True, text=True,
                                  capture_output=True, timeout=PATIENCE)
            expect(done.returncode in (0, 127), f"--version in {kilobytes} kB: {done.returncode} {done.stderr}")
        except subprocess.TimeoutExpired:
            expect(False, f"--version in {kilobytes} kB never ends")


def check_progress(folder):
    """On a terminal a line that rewrites itself, none with --quiet. The reason why not, where there is no terminal."""
    for option, shown in (([], True), (["--quiet"], False)):
        try:
            master, slave = pty.openpty()
        except OSError as error:
            return f"no pseudo-terminal: {error}"
        process = subprocess.Popen([COMMAND, "pack", *LONG, *option, "-o", folder / "never.h5"], stderr=slave,
                                   stdout=subprocess.DEVNULL)
        os.close(slave)
        first = os.read(master, 65536).decode() if shown else ""  # waits for it
        wait_for_work(process, 0.3)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=PATIENCE)
        seen = first + os.read(master, 65536).decode()
        os.close(master)
        expect(("strain" in seen and "\r" in seen) == shown, f"progress with {option}: {seen!r}")
        last = re.split(r"[\r\n]+", seen.strip())[-1]
        expect(names_all(last, "never.h5.state"), f"the last line: {seen[-200:]!r}")
        (folder / "never.h5.state").unlink(missing_ok=True)
    return None


def main():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-usage-"))
    os.chdir(folder)
    try:
        check_help()
        check_streams(folder)
        check_overwriting(folder)
        check_summary(folder)
        check_audit(folder)
        check_statics(folder)
        check_interruption(folder)
        check_memory(folder)
        skipped = check_progress(folder)
    finally:
        shutil.rmtree(folder)
    print(*faults, *([f"skipped: {skipped}"] if skipped else []), sep="\n")
    sys.exit(1 if faults else 77 if skipped else 0)


if __name__ == "__main__":
    main()
