"""What scripts rely on: streams, overwriting, the tables of pack, check and statics, lines of progress, warnings of low
boxes, memory.

usage: test_usage.py COMMAND SOURCE_DIR
"""
import json
import os
import pathlib
import pty
import re
import resource
import shutil
import signal
import subprocess
import sys

import numpy as np

from command import COMMAND, N200, N600, REFERENCE, main, pack, refused, run, sets, table, tried
from common import PATIENCE, names_all, wait_for_work

SMALL = sets(grains=60, width=8)
LONG = sets(grains=3000, pressure=1e-8)  # minutes, if nobody stopped it


def broken_pipe():
    reader, writer = os.pipe()
    os.close(reader)
    return os.fdopen(writer, "w")


def closed_stdout(*words):
    return subprocess.run(["bash", "-c", '"$@" >&-', "bash", COMMAND, *map(str, words)], text=True, capture_output=True)


def streams():
    """A full disk, a closed stdout and a closed pipe are failures with a reason; a reader that has had enough is not."""
    for words in (["help"], ["help", "scene"], ["--version"]):
        with open("/dev/full", "w") as full:
            done = run(*words, status=1, capture_output=False, stdout=full, stderr=subprocess.PIPE)
        assert names_all(done.stderr, "No space left"), done
        done = closed_stdout(*words)
        assert done.returncode == 1 and done.stderr, done
    piped = subprocess.run(["bash", "-c", f"trap '' PIPE; '{COMMAND}' help scene; echo $? >&2"], text=True,
                           stdout=broken_pipe(), stderr=subprocess.PIPE)
    assert "Broken pipe\n1\n" in piped.stderr, piped
    quiet = tried("help", "scene", capture_output=False, stdout=broken_pipe(), stderr=subprocess.PIPE)
    assert quiet.returncode == -signal.SIGPIPE and not quiet.stderr, quiet
    # with stdout closed no result file may become file 1 and get the summary
    done = closed_stdout("pack", *SMALL, "-o", "closed.txt")
    assert done.returncode == 1 and done.stderr and "height" not in pathlib.Path("closed.txt").read_text(), done


def overwriting():
    packing = pathlib.Path("p.txt")
    assert not run("pack", *SMALL, "-o", packing).stderr, "progress without a terminal"
    before = packing.read_bytes()
    refused("p.txt", "pack", *SMALL, "-o", packing)
    assert packing.read_bytes() == before
    pack(packing, "--seed=2", grains=60, width=8)
    assert packing.read_bytes() != before
    for name, content in (("foreign.h5", b"a letter to my aunt\n"), ("image.txt", b"\x89PNG\r\n\x1a\n" + bytes(50)),
                          ("page.txt", b"<html></html>\n"), ("program.txt", b"int main(void) { return 0; }\n")):
        path = pathlib.Path(name)
        path.write_bytes(content)
        refused(name, "pack", *SMALL, "-o", path, "--force")
        assert path.read_bytes() == content, name
    pathlib.Path("folder.h5").mkdir()
    refused("folder.h5", "pack", *SMALL, "-o", "folder.h5", "--force")
    pathlib.Path("packing.tsv").write_bytes(packing.read_bytes())
    refused("packing.tsv", "statics", packing, "-o", "packing.tsv", "--force")
    for name in ("t.tsv", "t.csv", "t.json"):
        run("statics", packing, "-o", name)
    assert json.loads(pathlib.Path("t.json").read_text())
    run("statics", packing, "-o", "t.dat", "--format", "tsv")
    assert pathlib.Path("t.dat").read_text() == pathlib.Path("t.tsv").read_text()


def summary():
    words = ["pack", *SMALL, "--seed=5", "-o"]
    found = table(*words, "s.txt")
    row = {name: float(word) for name, word in found.row().items()}
    assert found.names == "grains height p z_star rattlers residual steps seconds".split()
    # 60 grains in a box 8 wide at an area fraction of 0.7 .. 0.9, and rest by the rule min(1e-10, 1e-6 p)
    area = 60 * np.pi / 4 * (1 + 0.4**2 / 12)
    assert row["grains"] == 60 and row["p"] == 1e-4 and 0.65 < area / (8 * row["height"]) < 0.9, row
    assert 0 <= row["residual"] <= 1e-10 and row["steps"] > 0 and 0 <= row["rattlers"] < 30, row
    assert "z_star" in json.dumps(json.loads(run(*words, "s5.txt", "--format=json").stdout))
    for name in ("one.h5", "two.h5"):
        run(*words, name)
    for a, b in (("s.txt", "s5.txt"), ("one.h5", "two.h5")):
        assert pathlib.Path(a).read_bytes() == pathlib.Path(b).read_bytes(), "a seed is a packing, bit for bit"


def check():
    measures = "force torque walls law geometry coulomb missing".split()
    paths = ["s.txt", *sorted(REFERENCE.glob("packing_*.txt"))]
    found = table("check", *paths)
    assert found.names == "file ok residual reason".split() + measures and set(found.words("ok")) == {"yes"}
    assert np.array_equal(found["residual"], np.max([found[name] for name in measures], axis=0))
    # at rest by the rule 1e-6 p: forces balance to 1e-6 of p d^2 (masses are below 1), the piston of 12.5 to 1.25e-5
    assert 0 <= found["residual"][0] <= 1.25e-5
    assert names_all(run("check", "s.txt", "--tolerance=0", status=1).stderr, "s.txt")
    pathlib.Path("empty.h5").write_bytes(b"")
    pathlib.Path("noise.h5").write_bytes(bytes(range(256)) * 40)
    for name in ("empty.h5", "noise.h5", "absent.h5", "folder.h5"):
        done = run("check", name, "s.txt", status=1)
        rows = [line.split("\t") for line in done.stdout.splitlines() if not line.startswith("#")]
        assert [row[1] for row in rows[1:]] == ["no", "yes"] and set(rows[1][4:]) == {"nan"} and names_all(done.stderr, name)


def statics():
    done = run("statics", "noise.h5", "s.txt", "--margin=0.5", status=1)
    assert names_all(done.stderr, "noise.h5") and "s.txt" in done.stdout
    refused("noise.h5", "statics", "noise.h5", status=1)
    row = {name: value[0] for name, value in ((n, table("statics", "s.txt", "--margin=0.5")[n]) for n in
                                              ("Phi2", "Phi3", "Phi3s", "zs", "Z2"))}
    # a disk of diameter 1 is pi/4 of its square, a sphere pi/6 of its cube: Phi3/Phi2 = 2/3 <d^3>/<d^2> for the
    # uniform diameters 0.8 .. 1.2, in a layer one mean diameter thick
    assert abs(row["Phi3"] / row["Phi2"] - 2 / 3 * 1.04 / (1 + 0.16 / 12)) < 0.02, row
    assert 2 < row["zs"] < 4 and 0 < row["Phi3s"] <= row["Phi3"] and row["Z2"] >= 1, row
    for path, counts in ((N200, (4, 295)), (N600, (5, 975))):
        stress(path, counts)


def stress(path, counts):
    """Stress and mobilised friction by their sums, from the text of a packing whose contacts all carry."""
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    head, n = dict(zip(lines[0][::2], lines[0][1::2])), int(lines[0][1])
    radius, loose = zip(*((float(line[2]), line[3] == "1") for line in lines[1:n + 1]))
    rows = np.array([line[:7] for line in lines[n + 1:]], float)
    i, j = rows[:, :2].astype(int).T
    kept = ~(np.array(loose)[i] | ((j >= 0) & np.array(loose)[j]))
    nx, ny, overlap, fn, ft = rows[kept, 2:].T
    r = np.array([*radius, 0])  # of a wall: none
    branch = r[i[kept]] + np.where(j[kept] >= 0, r[j[kept]], 0) - overlap
    fx, fy = fn * nx + ft * ny, fn * ny - ft * nx  # of i on j; ft is the force on i along (-ny, nx)
    full, found = int((np.abs(ft) >= 0.99 * float(head["mu"]) * fn).sum()), table("statics", path)
    total = (fy * branch * ny).sum()
    for name, value in (("s1_over_s2", (fx * branch * nx).sum() / total), ("s12_over_s2", (fx * branch * ny).sum() / total),
                        ("mobilised", full / len(fn))):
        assert abs(found[name][0] - value) < 1e-9, (path, name)
    assert (full, len(fn)) == counts and np.isnan(found["s32_over_s2"][0]), (full, len(fn))


def rest_of(terminal):
    """All that an ended process wrote to it: one read gives what one or some writes left, and the end is an error."""
    seen = b""
    try:
        while part := os.read(terminal, 65536):
            seen += part
    except OSError:
        pass
    return seen.decode()


def progress():
    """On a terminal a line that rewrites itself, none with --quiet; the way on is told in any case."""
    for option, shown in (([], True), (["--quiet"], False)):
        try:
            master, slave = pty.openpty()
        except OSError as error:
            return f"no pseudo-terminal: {error}"
        process = subprocess.Popen([COMMAND, "pack", *LONG, *option, "-o", "never.h5"], stderr=slave,
                                   stdout=subprocess.DEVNULL)
        os.close(slave)
        first = os.read(master, 65536).decode() if shown else ""  # waits for it
        wait_for_work(process, 0.3)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=PATIENCE)
        seen = first + rest_of(master)
        os.close(master)
        assert ("strain" in seen and "\r" in seen) == shown, (option, seen)
        assert names_all(re.split(r"[\r\n]+", seen.strip())[-1], "never.h5.state"), seen[-200:]
        pathlib.Path("never.h5.state").unlink()
    return None


def shown(*words):
    """What a command writes on a terminal."""
    master, slave = pty.openpty()
    process = subprocess.Popen([COMMAND, *map(str, words)], stdin=subprocess.DEVNULL, stdout=slave, stderr=subprocess.PIPE)
    os.close(slave)
    text = rest_of(master).replace("\r\n", "\n")
    assert process.wait(timeout=PATIENCE) == 0, process.stderr.read()
    process.stderr.close()
    os.close(master)
    return text


def on_a_terminal():
    """Tables are aligned, and rounded to what their errors carry; pipes, files and --format have the bytes that they had."""
    words = ["uncertainty", N200, "--force=0.1", "--samples=10", "--front-only", "-q"]
    try:
        text = shown(*words)
    except OSError as error:
        return f"no pseudo-terminal: {error}"
    pipe = run(*words).stdout
    run(*words, "-o", "piped.tsv")
    assert pathlib.Path("piped.tsv").read_text() == pipe == shown(*words, "--format=tsv") == run(*words, "--digits=3").stdout
    cells = [[line.split("\t") for line in pipe.splitlines() if line[0] != "#"],
             *([re.split("  +", line.strip()) for line in shown(*words, *more).splitlines() if line[0] != "#"]
               for more in (["--digits=all"], []))]
    assert cells[0] == cells[1] and cells[0][0] == cells[2][0]
    assert [line for line in text.splitlines() if line[0] == "#"] == [line for line in pipe.splitlines() if line[0] == "#"]
    names, rows = cells[0][0], zip(cells[0][1:], cells[2][1:], strict=True)
    for exact, rounded in rows:
        bias, error = (float(exact[names.index(name)]) for name in ("bias", "bias_err"))
        assert abs(float(rounded[names.index("bias")]) - bias) <= 0.0501 * error and rounded[names.index("bias_err")] == f"{error:.2g}"
        assert rounded[names.index("value")] == f"{float(exact[names.index('value')]):.6g}"
    table_lines = [line for line in text.splitlines() if line[0] != "#"]
    end = table_lines[0].index("value") + len("value")
    assert all(line[end - 1] != " " and line[end] == " " for line in table_lines), "numbers end below the end of their name"
    run("signal", N200, "--points=400", "-o", "one.tsv")
    assert "\t" not in shown("trace", "one.tsv") and "\t" in shown("trace", "one.tsv", "--format=tsv")
    for word in ("0", "18", "many", ""):
        refused("--digits", "statics", N200, f"--digits={word}")
        refused("--digits", "trace", "one.tsv", f"--digits={word}")
    return None


def low_boxes():
    """They are told, in one warning; what it says would be right is right."""
    words = ["pack", "--set=packing.dimension=3", "--dry-run", "-o", "q.h5"]
    said = run(*words).stderr
    assert len(said.splitlines()) == 1 and not run(*words, "--quiet").stderr
    grains, width = re.search(r"packing.grains = (\d+), or packing.width = ([\d.]+)", said).groups()
    for key in (f"packing.grains={grains}", f"packing.width={width}"):
        assert not run(*words, "--set", key).stderr
    pack("low.txt", grains=60, width=16, protocol="quick")
    for command in (["signal"], ["front"], ["moduli"], ["modes", "--lowest", 3]):
        lines = [line for line in run(*command, "low.txt").stderr.splitlines() if "warning" in line]
        assert len(lines) == 1 and names_all(lines[0], "low.txt 6"), (command, lines)
        assert not run(*command, N200).stderr and not run(*command, "low.txt", "--quiet").stderr


def programs_beside():
    """A program of the package begins with Ctrl-C held back. One whose interpreter is missing is said so."""
    folder = pathlib.Path("beside").resolve()
    folder.mkdir()
    shutil.copy(COMMAND, folder / "sonopack")
    mask = f"#!{sys.executable}\nimport signal\nprint(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))\n"
    for name, text in (("plot", mask), ("view", "#!/no/such/python3\n"),
                       ("save-table", "#!/no/such/python3\n")):
        (folder / f"sonopack-{name}").write_text(text)
        (folder / f"sonopack-{name}").chmod(0o755)
    command = str(folder / "sonopack")
    done = subprocess.run([command, "plot"], text=True, capture_output=True, timeout=PATIENCE)
    assert done.stdout == "True\n", done
    for words in (["view", N200], ["statics", N200, "-o", "table.mat"]):
        done = subprocess.run([command, *map(str, words)], text=True, capture_output=True, timeout=PATIENCE)
        assert done.returncode == 1 and names_all(done.stderr, "sonopack- interpreter python3") and \
            len(done.stderr.splitlines()) == 1, done


def work_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def memory():
    """More grains than fit are refused at once, before the machine is brought to its knees."""
    if os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGESIZE") < 100e9:
        before = work_of_children()
        refused("packing.grains 100000000", "pack", "--set=packing.grains=100000000", "-o", "huge.h5", status=1)
        assert work_of_children() - before < 10, "it takes long to see that memory does not suffice"
    # OpenBLAS cannot start its threads in so little space; a process ends all the same (127: the loader's word)
    for kilobytes in (100000, 200000):
        done = subprocess.run(f"ulimit -v {kilobytes}; exec {COMMAND} --version", shell=True, text=True,
                              capture_output=True, timeout=PATIENCE)
        assert done.returncode in (0, 127), (kilobytes, done)


main(streams, overwriting, summary, check, statics, progress, on_a_terminal, low_boxes, programs_beside, memory)
