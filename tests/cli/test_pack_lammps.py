"""pack --engine lammps with a stand-in for LAMMPS: what it is given, and every way in which it can fail. Each failure has
one line with the reason, status 1, no packing, and leaves the files in a folder that the line names.

usage: test_pack_lammps.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import signal
import stat
import subprocess
import sys
import tempfile

from common import names_all, wait_until

COMMAND = sys.argv[1]
SIZE = ["--set", "packing.grains=40", "--set", "packing.width=6"]
LOG = 'echo "LAMMPS (29 Sep 2021 - Update 2)" >log.lammps; echo "    1000 1e-3 12.5" >>log.lammps; '
GOOD = "steps 1000 acceleration 1e-9 top 7.0"
folder = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-engine-"))


def lmp(body, name="lmp"):
    """A program of this name, in a folder of its own."""
    home = pathlib.Path(tempfile.mkdtemp(dir=folder))
    path = home / name
    path.write_text("#!/bin/sh\n" + body + "\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def pack(*words, path=None):
    env = dict(os.environ, PATH=f"{path}:/usr/bin:/bin" if path else os.environ["PATH"])
    return subprocess.run([COMMAND, "pack", *words], capture_output=True, text=True, cwd=folder, env=env)


def fails(body, words, *more, output="F.h5"):
    """LAMMPS that does this: one line that names all of the words and the folder, whose files stay."""
    r = pack(*SIZE, "--engine", "lammps", "--lammps", str(lmp(body)), "--force", "-o", output, *more)
    assert r.returncode == 1, (body, r)
    lines = r.stderr.strip().split("\n")
    assert len(lines) == 1 and names_all(lines[0], words + f" {output}.lammps"), (words, r.stderr)
    assert not (folder / output).exists()
    assert (folder / f"{output}.lammps" / "in.pack").exists() and (folder / f"{output}.lammps" / "gas.data").exists()
    return r


# ---- the command line ----------------------------------------------------------------------------------------------

for words, key in [(["--ranks", "2", "-o", "a.h5"], "--ranks"), (["--prepare", "d"], "--prepare"),
                   (["--engine", "lammps", "--prepare", "d", "--collect", "d"], "--prepare"),
                   (["--engine", "lammps", "--prepare", "d", "--ranks", "2"], "--prepare"),
                   (["--engine", "lammps", "--prepare", "d", "-o", "a.h5"], "--prepare"),
                   (["--engine", "lammps", "--collect", "d", "--seed", "2", "-o", "a.h5"], "--collect"),
                   (["--engine", "lammps", "--dry-run", "-o", "a.h5"], "--dry-run"),
                   (["--engine", "lammps", "--ranks", "0", "-o", "a.h5"], "--ranks"),
                   (["--engine", "liggghts", "-o", "a.h5"], "--engine"),
                   (["--engine", "lammps", "--set", "packing.compression=isotropic", "-o", "a.h5"], "packing.compression"),
                   (["--engine", "lammps", "--set", "packing.viscous_limit=3", "-o", "a.h5"], "packing.viscous_limit"),
                   (["--engine", "lammps", "--set", "packing.kind=triangular", "-o", "a.h5"], "packing.kind"),
                   (["--engine", "lammps", "--set", "packing.history=(1e-5)", "-o", "a.h5"], "packing.history")]:
    sizes = SIZE if "--collect" not in words else []
    if "packing.kind=triangular" in words:
        sizes = ["--set", "packing.grains=42", "--set", "packing.width=6", "--set", "packing.diameter_min=1",
                 "--set", "packing.diameter_max=1"]
    r = pack(*sizes, *words, path=lmp("exit 0").parent)
    assert r.returncode == 2 and names_all(r.stderr, key), (words, r)
    assert not list(folder.glob("a.h5*")) and not (folder / "d").exists(), words

# ---- what LAMMPS is given ------------------------------------------------------------------------------------------

record = 'printf "%s\\n" "$0" "$@" >words; pwd >>words; ' + LOG + "exit 3"
fails(record, "status 3")
kept = folder / "F.h5.lammps"
words = (kept / "words").read_text().split("\n")
assert words[1:-2] == ["-nocite", "-in", "in.pack", "-log", "log.lammps"] and words[-2] == str(kept.resolve()), words

# ranks: mpirun gets absolute paths, and names are never read by a shell
launcher = lmp('printf "%s\\n" "$@" >words; exit 3', "mpirun")
odd = folder / "a $(touch harm); name"
odd.mkdir()
os.symlink(lmp("exit 3"), odd / "lmp")
r = pack(*SIZE, "--engine", "lammps", "--ranks", "3", "--lammps", str(odd / "lmp"), "--force", "-o", "x;touch harm.h5",
         path=launcher.parent)
assert r.returncode == 1, r
words = (folder / "x;touch harm.h5.lammps" / "words").read_text().split("\n")
assert words[:2] == ["-n", "3"] and os.path.isabs(words[2]) and words[3] == "-nocite", words
assert not list(folder.glob("**/harm")) and not (folder / "harm.h5").exists()

# ---- failures ------------------------------------------------------------------------------------------------------

r = pack(*SIZE, "--engine", "lammps", "--lammps", "no/such", "-o", "M.h5")
assert r.returncode == 1 and names_all(r.stderr, "no/such --lammps"), r
assert not (folder / "M.h5.lammps").exists()
empty = pathlib.Path(tempfile.mkdtemp(dir=folder))
r = subprocess.run([COMMAND, "pack", *SIZE, "--engine", "lammps", "-o", "M.h5"], capture_output=True, text=True,
                   cwd=folder, env=dict(os.environ, PATH=str(empty)))
assert r.returncode == 1 and names_all(r.stderr, "lmp"), r
r = pack(*SIZE, "--engine", "lammps", "--lammps", str(folder), "-o", "M.h5")
assert r.returncode == 1 and names_all(r.stderr, folder), r
broken = lmp("")
broken.write_bytes(b"\x7fELF nothing")
r = pack(*SIZE, "--engine", "lammps", "--lammps", str(broken), "--force", "-o", "F.h5")
assert r.returncode == 1 and names_all(r.stderr, f"{broken} F.h5.lammps"), r

fails(LOG + 'echo "ERROR: Lost atoms: original 41 current 40 (src/thermo.cpp:439)"; exit 1', "Lost atoms 1000")
fails('echo "LAMMPS (7 Aug 2019)" >log.lammps; echo "ERROR: Unknown pair style granular"; exit 1',
      "Unknown pair style granular 2019 2021 GRANULAR")
fails(LOG + "kill -9 $$", "9 1000")
fails("exit 0", "result.txt")  # not LAMMPS at all
fails(LOG + "exit 0", "result.txt")
fails(LOG + "printf 'steps 1000 accel' >result.txt", "result.txt")
fails(LOG + f"printf '{GOOD}' >result.txt", "result.txt")  # the end of the line is missing
fails(LOG + "echo steps 1000 acceleration nan top 7 >result.txt", "result.txt")
fails(LOG + "echo steps 1000 acceleration 1e-3 top 7 >result.txt", "1000 packing.max_steps")
fails(LOG + f"echo {GOOD} >result.txt", "grains.dump")
fails(LOG + ": >result.txt; : >grains.dump", "result.txt")  # as a full disk leaves them

# ---- the real output of a run, and what becomes of it when it is cut ------------------------------------------------

r = pack(*SIZE, "--seed", "3", "--engine", "lammps", "--prepare", "d")
assert r.returncode == 0, r
for name in ("in.pack", "gas.data", "scene.cfg"):
    assert (folder / "d" / name).stat().st_size > 0, name
r = pack(*SIZE, "--engine", "lammps", "--prepare", "d")
assert r.returncode == 1 and names_all(r.stderr, "d --force"), r
rows = (folder / "d" / "gas.data").read_text().split("Atoms # sphere\n\n")[1].split("\n")[:40]


def dumps(radius=lambda k, d: d / 2, number="%.17g", contacts="", count=40):
    """A dump of the gas as it was before anything touched, as if LAMMPS had made it."""
    head = "ITEM: TIMESTEP\n1000\nITEM: NUMBER OF %s\n%d\nITEM: BOX BOUNDS pp ff pp\n0 6\n-1 20\n-0.5 0.5\n"
    columns = "ITEM: ATOMS id type x y z radius mass " + " ".join(f"f_{w}[{k}]" for w in ("floor", "roof")
                                                                 for k in range(1, 8))
    lines = []
    for k, row in enumerate(rows):
        i, kind, d, _, x, y, z = row.split()
        r = radius(k, float(d))
        lines.append(" ".join([i, "1", number % float(x), number % float(y), "0", repr(r), repr(4.1887902 * r ** 3)] + ["0"] * 14))
    (folder / "d" / "grains.dump").write_text(head % ("ATOMS", 40) + columns + "\n" + "\n".join(lines[:count]) + "\n")
    (folder / "d" / "contacts.dump").write_text(
        head % ("ENTRIES", 1) + "ITEM: ENTRIES index " + " ".join(f"c_sp_id[{k}]" for k in (1, 2)) + " " +
        " ".join(f"c_sp_contact[{k}]" for k in range(1, 6)) + "\n" + (contacts or "1 1 2 1 1e-5 0 0 0\n"))
    (folder / "d" / "result.txt").write_text(GOOD.replace("7.0", "19.0") + "\n")
    (folder / "d" / "log.lammps").write_text("LAMMPS (29 Sep 2021)\n")


def collect_fails(words):
    r = pack("--engine", "lammps", "--collect", "d", "-o", "C.h5")
    lines = r.stderr.strip().split("\n")
    assert r.returncode == 1 and len(lines) == 1 and names_all(lines[0], words), (words, r)
    assert not (folder / "C.h5").exists() and (folder / "d" / "grains.dump").exists()


dumps(count=17)
collect_fails("grains.dump")
dumps(number="nan%.0s")
collect_fails("grains.dump")
dumps(contacts="1 1 2 1 nan 0 0 0\n")
collect_fails("d")
dumps(contacts="1 1 2 1 1e-5\n")
collect_fails("contacts.dump")
dumps(radius=lambda k, d: d / 2 * (1.001 if k == 5 else 1))
collect_fails("d")
# two grains that touch by Hertz's law, below a wall that would fall for minutes
one, two = (row.split() for row in rows[:2])
radii, near = [float(grain[2]) / 2 for grain in (one, two)], [(float(one[4]) + 0.9) % 6, 1.5 + max(float(row.split()[5]) for row in rows)]
overlap = sum(radii) - 0.9
force = 2 / 3 * (radii[0] * radii[1] / sum(radii)) ** 0.5 * overlap ** 1.5
rows[0] = " ".join([*one[:5], repr(near[1]), one[6]])
rows[1] = " ".join([*two[:4], repr(near[0]), repr(near[1]), two[6]])
dumps(contacts=f"1 {one[0]} {two[0]} 0.9 {force!r} 0 0 0\n")
(folder / "d" / "result.txt").write_text(GOOD.replace("7.0", "1e9") + "\n")
collect_fails("result.txt 1e+09")
(folder / "d" / "grains.dump").unlink()
os.mkfifo(folder / "d" / "grains.dump")  # which nobody ever opens to write
collect_fails("grains.dump")
r = pack("--engine", "lammps", "--collect", "nowhere", "-o", "C.h5")
assert r.returncode in (1, 2) and names_all(r.stderr, "nowhere/scene.cfg"), r

# ---- an interrupt, and the end of the command itself ---------------------------------------------------------------

sleeper = lmp("echo $$ >pid; " + LOG + "exec sleep 1000")


def child_of(name, number, status):
    process = subprocess.Popen([COMMAND, "pack", *SIZE, "--engine", "lammps", "--lammps", str(sleeper), "--force", "-o", name],
                               stderr=subprocess.PIPE, text=True, cwd=folder)
    pid = folder / f"{name}.lammps" / "pid"
    wait_until(lambda: pid.exists() and pid.read_text().strip() != "", "LAMMPS to start")
    child = int(pid.read_text())
    process.send_signal(number)
    said = process.communicate()[1]
    assert process.returncode == status, (number, process.returncode, said)
    wait_until(lambda: not running(child), "the child to end")
    assert (folder / f"{name}.lammps" / "in.pack").exists() and not (folder / name).exists()
    return said


def running(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


assert names_all(child_of("I.h5", signal.SIGINT, 1), "I.h5.lammps")
assert names_all(child_of("T.h5", signal.SIGTERM, 1), "T.h5.lammps")
child_of("K.h5", signal.SIGKILL, -9)

# a folder of an earlier run is not replaced
r = pack(*SIZE, "--engine", "lammps", "--lammps", str(sleeper), "-o", "I.h5")
assert r.returncode == 1 and names_all(r.stderr, "I.h5.lammps --force --collect"), r
(folder / "Q.h5.lammps").write_text("mine")
r = pack(*SIZE, "--engine", "lammps", "--lammps", str(sleeper), "--force", "-o", "Q.h5")
assert r.returncode == 1 and names_all(r.stderr, "Q.h5.lammps"), r
assert (folder / "Q.h5.lammps").read_text() == "mine"
print("ok")
