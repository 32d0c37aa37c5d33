"""What docs/security.md promises about files that nobody trusts: their texts reach no terminal as commands;
nothing in them is executed or loaded; no name in them leads out of a store; temporaries follow no link.

usage: test_security.py COMMAND SOURCE_DIR
"""
import json
import os
import pathlib
import pty
import re
import resource
import shutil
import stat
import subprocess

import h5py
import numpy as np

from command import COMMAND, main, pack, run, sanitized, sets, tried
from common import expect

CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\x80-\x9f]")
EVIL = "\x1b]0;owned\x07\x1b[2J\u009b31m\r"  # sets the title of a terminal, clears it, colours it
SCRIPT = "<script>alert(1)<\\script>&\"'"


def on_terminal(*words):
    """What a command prints on a terminal."""
    master, slave = pty.openpty()
    done = subprocess.Popen([COMMAND, *map(str, words)], stdout=slave, stderr=slave, stdin=subprocess.DEVNULL)
    os.close(slave)
    parts = []
    while True:
        try:
            parts.append(os.read(master, 65536))
        except OSError:  # the last end of it is closed
            break
        if not parts[-1]:
            break
    done.wait()
    os.close(master)
    return b"".join(parts).decode(errors="replace").replace("\r\n", "\n")


def check_messages():
    """Names and contents of hostile files in messages, and in tables on a terminal."""
    bad = pathlib.Path(EVIL + ".h5")
    shutil.copy("P.h5", bad)
    for name, text in (("a.txt", f"# packing\nN {EVIL} 3\n"), ("b.tsv", f"t\tF{EVIL}\n0\t{EVIL}\n"), ("c.cfg", f"packing = {EVIL}\n"),
                       ("d.txt", "\u009b31m\n"), ("e.h5", EVIL)):
        pathlib.Path(name).write_text(text)
    with h5py.File("P.h5") as good, h5py.File("f.h5", "w") as forged:
        good.copy("/", forged, name="x")
        forged.create_dataset(EVIL, data=EVIL)
    for words in (["signal", "none" + str(bad)], ["check", "a.txt"], ["front", "b.tsv"], ["pack", "c.cfg", "-o", "o.h5"],
                  ["check", "d.txt"], ["check", "e.h5"], ["check", "f.h5"], [EVIL], ["pack", EVIL], ["help", EVIL],
                  ["signal", "P.h5", "--" + EVIL], ["signal", "P.h5", "--until", EVIL], ["table", EVIL, "--store", "."],
                  ["study", "--store", EVIL, "--set", EVIL]):
        done = tried(*words)
        expect(done.returncode != 0 and not CONTROL.search(done.stderr), f"{words}: {done.returncode}, {done.stderr!r}")
    shown = on_terminal("sensitivity", bad)
    expect("owned" in shown and not CONTROL.search(shown), f"a table on a terminal: {CONTROL.findall(shown)[:5]}")
    expect(EVIL.replace("\r", "") in run("sensitivity", bad).stdout.replace("\r", ""), "a table in a file has other names")


def check_json():
    """A name stays a text."""
    shutil.copy("P.h5", SCRIPT + ".h5")
    said = json.loads(run("sensitivity", SCRIPT + ".h5", "--format", "json").stdout)
    expect(any(SCRIPT in comment for comment in said["comments"]), "JSON: the name is another")


def plugin():
    """A filter of HDF5 that tells that it was loaded; None without a compiler."""
    source = """#include <stdio.h>
static const struct { int version, id; unsigned e, d; const char *n; void *c, *s, *f; } z = {1, 32015, 1, 1, "evil", 0, 0, 0};
__attribute__((constructor)) static void loaded(void) { FILE *f = fopen("loaded", "w"); if (f) fclose(f); }
int H5PLget_plugin_type(void) { return 0; }
const void *H5PLget_plugin_info(void) { return &z; }
"""
    pathlib.Path("plugins").mkdir()
    pathlib.Path("evil.c").write_text(source)
    compiler = shutil.which("cc") or shutil.which("gcc")
    if not compiler:
        return None
    subprocess.run([compiler, "-shared", "-fPIC", "-o", "plugins/libevil.so", "evil.c"], check=True)
    return {**os.environ, "HDF5_PLUGIN_PATH": str(pathlib.Path("plugins").resolve())}


def check_hdf5():
    """Data outside the file, and filters that are libraries."""
    pathlib.Path("raw").write_bytes(bytes(100000))
    with h5py.File("P.h5") as good:
        paths = []
        good.visititems(lambda name, thing: paths.append(name) if isinstance(thing, h5py.Dataset) and thing.ndim else None)
    name = next(path for path in paths if path.endswith(("x", "position", "radius", "r"))) if paths else None
    expect(name, "no dataset to be forged")
    for kind in ("external", "soft", "storage", "virtual", "filter"):
        shutil.copy("P.h5", "forged.h5")
        with h5py.File("forged.h5", "r+") as file:
            shape, dtype = file[name].shape, file[name].dtype
            del file[name]
            if kind == "external":
                file[name] = h5py.ExternalLink("P.h5", "/" + name)
            elif kind == "soft":
                file["elsewhere"] = h5py.ExternalLink("P.h5", "/")
                file[name] = h5py.SoftLink("/elsewhere/" + name)
            elif kind == "storage":
                file.create_dataset(name, shape, dtype, external=[("raw", 0, 100000)])
            elif kind == "virtual":
                layout = h5py.VirtualLayout(shape, dtype)
                layout[...] = h5py.VirtualSource("P.h5", name, shape)
                file.create_virtual_dataset(name, layout)
            else:
                plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
                plist.set_chunk(shape)
                plist.set_filter(32015, h5py.h5z.FLAG_OPTIONAL)
                made = h5py.h5d.create(file.id, name.encode(), h5py.h5t.py_create(dtype), h5py.h5s.create_simple(shape), plist)
                made.write_direct_chunk((0,) * len(shape), np.zeros(shape, dtype).tobytes(), 0)
        done = tried("check", "forged.h5", env=plugin() if kind == "filter" else None)
        expect(done.returncode == 1 and " forged.h5: " in done.stderr, f"{kind}: {done.returncode}, {done.stderr}")
    expect(not pathlib.Path("loaded").exists(), "a file had a library loaded")


def check_store():
    """Links and names in a store of someone else's: nothing outside is read as a sample, written or removed."""
    scene = sets("study.samples=2", kind="chain", grains=12)
    run("study", *scene, "--store", "good")
    names = sorted(path.name for path in pathlib.Path("good").glob("*.h5"))
    outside = pathlib.Path("outside")
    outside.mkdir()
    for name in ("letter", "lock", "manifest", "temporary"):
        (outside / name).write_text("a letter\n")
    store = pathlib.Path("store")
    shutil.copytree("good", store)
    (store / names[0]).unlink()
    (store / names[0]).symlink_to("../outside/letter")
    lines = (store / "manifest.tsv").read_text()
    (store / "manifest.tsv").write_text(lines + lines.splitlines()[-1].replace(names[1][:32], "../outside/letter") + "\n")
    (store / ".sonopack-lock").unlink(missing_ok=True)
    (store / ".sonopack-lock").symlink_to("../outside/lock")
    (store / ".sonopack-00000000-1-1.tmp").symlink_to("../outside/temporary")
    for words in (["study", *scene], ["study", *scene, "--verify"], ["table", "statics"]):
        tried(*words, "--store", "store")
    left = {path.name: path.read_text() for path in outside.iterdir()}
    expect(left == dict.fromkeys(("letter", "lock", "manifest", "temporary"), "a letter\n"),
           f"a store wrote outside: {left}")
    shutil.rmtree("store")
    shutil.copytree("good", store)
    (store / "manifest.tsv").unlink()
    (store / "manifest.tsv").symlink_to("../outside/manifest")
    run("study", *scene, "--store", "store")
    expect((outside / "manifest").read_text() == "a letter\n", "a store wrote through a link of its index")


def check_temporaries():
    """Made anew, beside the result, with the rights that the umask leaves; a link to a file keeps its target's rights."""
    folder = pathlib.Path("private")
    folder.mkdir()
    script = 'umask 077; exec "$@"'
    subprocess.run(["sh", "-c", script, "sh", COMMAND, "signal", "P.h5", "-o", folder / "s.tsv"], check=True,
                   env={**os.environ, "TMPDIR": "/nowhere"})
    expect(stat.S_IMODE((folder / "s.tsv").stat().st_mode) == 0o600, "the umask does not hold")
    expect([path.name for path in folder.iterdir()] == ["s.tsv"], "something is left")
    (folder / "dangling.tsv").symlink_to("made-by-a-link.tsv")
    done = tried("signal", "P.h5", "-o", folder / "dangling.tsv", "--force")
    expect(done.returncode != 0 and not (folder / "made-by-a-link.tsv").exists(), "a dangling link was followed")


def largest_memory(*words):
    """Bytes that a command took at the most, or those of this process when it started it, if they were more."""
    done = subprocess.Popen([COMMAND, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, use = os.wait4(done.pid, 0)
    done.returncode = os.waitstatus_to_exitcode(status)
    expect(done.returncode in (1, 2), f"{words}: status {done.returncode}")
    return 1024 * use.ru_maxrss


def check_memory():
    """Memory over the size of the file, for files that take the most."""
    usual = 13 << 20  # of a command without work
    pathlib.Path("list.cfg").write_text(f"packing = {{ history = [{','.join(['1'] * 1500000)}]; }};")
    pathlib.Path("rows.tsv").write_text("t\tF\n" + "1\t1\n" * 1500000)
    with h5py.File("zeros.h5", "w") as file:
        with h5py.File("P.h5") as honest:
            for part in honest:
                honest.copy(part, file)
        grains = {"radius": (2000000,), "mass": (2000000,), "position/value": (1, 2000000, 2)}
        for name, shape in grains.items():
            del file["particles/grains/" + name]
            file.create_dataset("particles/grains/" + name, shape, "f8", np.zeros(shape), chunks=True, compression=9)
    for times, name, words in ((60, "list.cfg", ("pack", "list.cfg", "-o", "Q.h5")),
                               (25, "rows.tsv", ("front", "rows.tsv")),
                               (2600, "zeros.h5", ("check", "zeros.h5"))):
        took = (largest_memory(*words) - usual) / os.path.getsize(name)
        expect(times / 5 < took < times, f"{name}: {took:.1f} times its size, promised {times}")


def check_wide_table():
    """30,000 columns and 30,000 blank lines: a table of one row, for which 7 GB were taken."""
    columns, limit = 30000, 3 << 30
    pathlib.Path("wide.csv").write_text(",".join(f"c{k}" for k in range(columns)) + "\n" * 30000 + ",".join(["1"] * columns) + "\n")
    done = tried("coda", "P.h5", "--before", "wide.csv", "--after", "wide.csv",
                 preexec_fn=None if sanitized() else lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
    expect(done.returncode == 1 and "memory" not in done.stderr and "wide.csv" in done.stderr, f"a wide table: {done}")


def check_symbols():
    """No shell is ever asked: the one call that starts a program is execv, for commands of the Python package."""
    tool = shutil.which("nm")
    if tool:
        names = set(re.findall(r" U (\w+)", subprocess.run([tool, "-D", COMMAND], capture_output=True, text=True).stdout))
        expect(not names & {"system", "popen", "execvp", "execlp", "execl", "wordexp", "posix_spawn", "tmpnam", "mktemp"},
               f"the command calls {names & {'system', 'popen', 'execvp', 'wordexp'}}")


def all_of_it():
    pack("P.h5", grains=60, width=8)
    for check in (check_messages, check_json, check_hdf5, check_store, check_temporaries, check_memory, check_wide_table,
                  check_symbols):
        check()


main(all_of_it)
