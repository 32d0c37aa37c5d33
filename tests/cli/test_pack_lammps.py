"""pack --engine lammps with a stand-in for LAMMPS: what it is given, and every way in which it can fail. Each failure has
one line with the reason, status 1, no packing, and leaves the files in a folder that the line names.

usage: test_pack_lammps.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import signal
import stat
import tempfile

from command import main, refused, run, sets, start, tried, warmly
from common import names_all, wait_until

SIZE = ["pack", *sets(grains=40, width=6)]
ENGINE = [*SIZE, "--engine", "lammps"]
LOG = 'echo "LAMMPS (29 Sep 2021 - Update 2)" >log.lammps; echo "    1000 1e-3 12.5" >>log.lammps; '
GOOD = "steps 1000 acceleration 1e-9 top 7.0"
D = pathlib.Path("d")


def lmp(body, name="lmp"):
    """A program of this name, in a folder of its own."""
    path = pathlib.Path(tempfile.mkdtemp(dir=".")).resolve() / name
    path.write_text("#!/bin/sh\n" + body + "\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def on_path(program):
    return {"env": dict(os.environ, PATH=f"{program.parent}:/usr/bin:/bin")}


def wrong_words():
    engine = on_path(lmp("exit 0"))
    for words, key in (("--ranks 2 -o a.h5", "--ranks"), ("--prepare d", "--prepare"),
                       ("--engine lammps --prepare d --collect d", "--prepare"),
                       ("--engine lammps --prepare d --ranks 2", "--prepare"), ("--engine lammps --prepare d -o a.h5", "--prepare"),
                       ("--engine lammps --collect d --seed 2 -o a.h5", "--collect"), ("--engine lammps --dry-run -o a.h5", "--dry-run"),
                       ("--engine lammps --ranks 0 -o a.h5", "--ranks"), ("--engine liggghts -o a.h5", "--engine")):
        refused(key, *(["pack"] if "--collect" in words else SIZE), *words.split(), **engine,
                way=warmly if "--engine lammps" in words else tried)
    for key, value in (("compression", "isotropic"), ("viscous_limit", 3), ("history", "(1e-5)")):
        refused(f"packing.{key}", *ENGINE, *sets(**{key: value}), "-o", "a.h5", way=warmly, **engine)
    assert not list(pathlib.Path().glob("a.h5*")) and not D.exists()
    for words, names in ((["--lammps", "no/such"], "no/such --lammps"), (["--lammps", "."], ".")):
        refused(names, *ENGINE, *words, "-o", "M.h5", status=1, way=warmly)
    refused("lmp", *ENGINE, "-o", "M.h5", status=1, env=dict(os.environ, PATH=str(lmp("", "other").parent)))
    assert not pathlib.Path("M.h5.lammps").exists()


def fails(program, names, output="F.h5", way=warmly):
    """One line that names all of the words and the folder, whose files stay."""
    done = run(*ENGINE, "--lammps", program, "--force", "-o", output, status=1, way=way)
    assert len(done.stderr.splitlines()) == 1 and names_all(done.stderr, f"{names} {output}.lammps"), (names, done.stderr)
    assert not pathlib.Path(output).exists()
    assert all(pathlib.Path(f"{output}.lammps", name).exists() for name in ("in.pack", "gas.data"))


def what_it_is_given():
    fails(lmp('printf "%s\\n" "$0" "$@" >words; pwd >>words; ' + LOG + "exit 3"), "status 3", way=tried)
    kept = pathlib.Path("F.h5.lammps").resolve()
    words = (kept / "words").read_text().split("\n")
    assert words[1:-1] == ["-nocite", "-in", "in.pack", "-log", "log.lammps", str(kept)], words
    # ranks: mpirun gets absolute paths, and names are never read by a shell
    launcher, odd = lmp('printf "%s\\n" "$@" >words; exit 3', "mpirun"), pathlib.Path("a $(touch harm); name")
    odd.mkdir()
    os.symlink(lmp("exit 3"), odd / "lmp")
    run(*ENGINE, "--ranks", 3, "--lammps", odd / "lmp", "--force", "-o", "x;touch harm.h5", status=1, **on_path(launcher))
    words = pathlib.Path("x;touch harm.h5.lammps/words").read_text().split("\n")
    assert words[:2] == ["-n", "3"] and os.path.isabs(words[2]) and words[3] == "-nocite", words
    assert not list(pathlib.Path().glob("**/harm*"))


def failures():
    broken = lmp("")
    broken.write_bytes(b"\x7fELF nothing")
    fails(broken, broken)
    for body, names in (
            (LOG + 'echo "ERROR: Lost atoms: original 41 current 40 (src/thermo.cpp:439)"; exit 1', "Lost atoms 1000"),
            ('echo "LAMMPS (7 Aug 2019)" >log.lammps; echo "ERROR: Unknown pair style granular"; exit 1',
             "Unknown pair style granular 2019 2021 GRANULAR"),
            (LOG + "kill -9 $$", "9 1000"), ("exit 0", "result.txt"), (LOG + "printf 'steps 1000 accel' >result.txt", "result.txt"),
            (LOG + f"printf '{GOOD}' >result.txt", "result.txt"),  # the end of the line is missing
            (LOG + "echo steps 1000 acceleration nan top 7 >result.txt", "result.txt"),
            (LOG + "echo steps 1000 acceleration 1e-3 top 7 >result.txt", "1000 packing.max_steps"),
            (LOG + f"echo {GOOD} >result.txt", "grains.dump"),
            (LOG + ": >result.txt; : >grains.dump", "result.txt")):  # as a full disk leaves them
        fails(lmp(body), names)


# ---- the real output of a run, and what becomes of it when it is cut -------------------------------------------------


def dumps(rows, radius=lambda k, d: d / 2, number="%.17g", contacts="1 1 2 1 1e-5 0 0 0\n", count=40, top="19.0"):
    """A dump of the gas as it was before anything touched, as if LAMMPS had made it."""
    head = "ITEM: TIMESTEP\n1000\nITEM: NUMBER OF %s\n%d\nITEM: BOX BOUNDS pp ff pp\n0 6\n-1 20\n-0.5 0.5\n"
    columns = "ITEM: ATOMS id type x y z radius mass " + " ".join(f"f_{w}[{k}]" for w in ("floor", "roof") for k in range(1, 8))
    lines = []
    for k, (i, _, d, _, x, y, _) in enumerate(row.split() for row in rows):
        r = radius(k, float(d))
        lines.append(" ".join([i, "1", number % float(x), number % float(y), "0", repr(r), repr(4.1887902 * r**3)] + ["0"] * 14))
    (D / "grains.dump").write_text(head % ("ATOMS", 40) + columns + "\n" + "\n".join(lines[:count]) + "\n")
    (D / "contacts.dump").write_text(head % ("ENTRIES", 1) + "ITEM: ENTRIES index c_sp_id[1] c_sp_id[2] " +
                                     " ".join(f"c_sp_contact[{k}]" for k in range(1, 6)) + "\n" + contacts)
    (D / "result.txt").write_text(GOOD.replace("7.0", top) + "\n")
    (D / "log.lammps").write_text("LAMMPS (29 Sep 2021)\n")


def collect_fails(names):
    done = run("pack", "--engine", "lammps", "--collect", "d", "-o", "C.h5", status=1, way=warmly)
    assert len(done.stderr.splitlines()) == 1 and names_all(done.stderr, names), (names, done)
    assert not pathlib.Path("C.h5").exists() and (D / "grains.dump").exists()


def collected():
    run(*ENGINE, "--seed", 3, "--prepare", "d")
    assert all((D / name).stat().st_size > 0 for name in ("in.pack", "gas.data", "scene.cfg"))
    refused("d --force", *ENGINE, "--prepare", "d", status=1, way=warmly)
    rows = (D / "gas.data").read_text().split("Atoms # sphere\n\n")[1].split("\n")[:40]
    for names, words in (("grains.dump", {"count": 17}), ("grains.dump", {"number": "nan%.0s"}),
                         ("d", {"contacts": "1 1 2 1 nan 0 0 0\n"}), ("contacts.dump", {"contacts": "1 1 2 1 1e-5\n"}),
                         ("d", {"radius": lambda k, d: d / 2 * (1.001 if k == 5 else 1)})):
        dumps(rows, **words)
        collect_fails(names)
    # two grains that touch by Hertz's law, below a wall that would fall for minutes
    one, two = (row.split() for row in rows[:2])
    radii = [float(grain[2]) / 2 for grain in (one, two)]
    x, y = (float(one[4]) + 0.9) % 6, 1.5 + max(float(row.split()[5]) for row in rows)
    force = 2 / 3 * (radii[0] * radii[1] / sum(radii)) ** 0.5 * (sum(radii) - 0.9) ** 1.5
    rows[:2] = [" ".join([*one[:5], repr(y), one[6]]), " ".join([*two[:4], repr(x), repr(y), two[6]])]
    dumps(rows, contacts=f"1 {one[0]} {two[0]} 0.9 {force!r} 0 0 0\n", top="1e9")
    collect_fails("result.txt 1e+09")
    (D / "grains.dump").unlink()
    os.mkfifo(D / "grains.dump")  # which nobody ever opens to write
    collect_fails("grains.dump")
    done = warmly("pack", "--engine", "lammps", "--collect", "nowhere", "-o", "C.h5")
    assert done.returncode in (1, 2) and names_all(done.stderr, "nowhere/scene.cfg"), done


# ---- an interrupt, and the end of the command itself -----------------------------------------------------------------


def running(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def stopped():
    sleeper = lmp("echo $$ >pid; " + LOG + "exec sleep 1000")
    for name, number, status in (("I.h5", signal.SIGINT, 1), ("T.h5", signal.SIGTERM, 1), ("K.h5", signal.SIGKILL, -9)):
        process, pid = start(*ENGINE, "--lammps", sleeper, "--force", "-o", name), pathlib.Path(f"{name}.lammps/pid")
        wait_until(lambda: pid.exists() and pid.read_text().strip() != "", "LAMMPS to start")
        child = int(pid.read_text())
        process.send_signal(number)
        said = process.communicate()[1]
        assert process.returncode == status and (status < 0 or names_all(said, f"{name}.lammps")), (number, process.returncode, said)
        wait_until(lambda: not running(child), "the child to end")
        assert pathlib.Path(f"{name}.lammps/in.pack").exists() and not pathlib.Path(name).exists()
    # a folder of an earlier run is not replaced
    refused("I.h5.lammps --force --collect", *ENGINE, "--lammps", sleeper, "-o", "I.h5", status=1, way=warmly)
    pathlib.Path("Q.h5.lammps").write_text("mine")
    refused("Q.h5.lammps", *ENGINE, "--lammps", sleeper, "--force", "-o", "Q.h5", status=1, way=warmly)
    assert pathlib.Path("Q.h5.lammps").read_text() == "mine"


main(wrong_words, what_it_is_given, failures, collected, stopped)
