"""Stores on full and read-only disks, with damaged files and a damaged index: nothing finished is lost, no number is
wrong, what failed is said in one line, and the next study completes the store.

usage: test_store_faults.py COMMAND SOURCE_DIR
"""
import functools
import os
import pathlib
import random
import re
import shutil
import socket
import subprocess
import sys
import time

import h5py

from command import COMMAND, main, run, table, tried
from common import PATIENCE, made_now, names_all
from store_faults import (ENVIRONMENT, SMALL, STAGES, Reference, calls_of, content, ensemble, identities, one_line,
                          refused_at, samples, shim, with_faults)

# six good samples, with all wants at once: a packing names those that it was made for
SIX = (SMALL.replace("1e-6, 1e-3", "1e-4, 1e-3").replace("samples = 2", "samples = 3")
       .replace("max_steps = 3500;", "").replace('["statics"]', '["statics", "moduli", "signal"]'))
HERE = pathlib.Path(sys.argv[3] if len(sys.argv) == 4 else "")  # in the private namespace: where to work


@functools.cache
def six():
    return Reference(HERE.resolve() / "six", SIX)


def study(reference, store, status=0, **options):
    done = subprocess.run(reference.command(store, 1), capture_output=True, text=True, env=ENVIRONMENT, timeout=PATIENCE,
                          **options)
    assert done.returncode == status, (status, done)
    return done


def fresh(reference=None, made=False):
    """A copy of a whole store, where perhaps a study has looked at it."""
    store = HERE.resolve() / "store"
    shutil.rmtree(store, ignore_errors=True)
    shutil.copytree((reference or six()).store[1], store)
    if made:
        study(reference or six(), store)
    return store


def completes(store, made, what, reference=None, **options):
    """A study makes so many samples, and all is as it was."""
    reference = reference or six()
    done = study(reference, store, **options)
    assert done.stdout == reference.stdout[1] and made_now(done.stderr) == made, (what, done)
    assert content(store) == reference.content[1], what


# ---- calls that fail ----------------------------------------------------------------------------------------------


def refused_calls():
    """Every third call that changes the store fails, and all after it; test_store_kill_long.py has them all."""
    folder = pathlib.Path().resolve()
    library = shim(folder)
    if not library:
        return "no cc, or a build with sanitizers"
    reference = Reference(folder / "small", SMALL)
    for stage in range(2):
        calls, failed = calls_of(library, reference, folder, stage), 0
        for at in range(1 + stage, calls + 1, 3):
            failed += refused_at(library, reference, folder, stage, ("ENOSPC", "EDQUOT", "EIO", "EROFS")[at % 4], at)
        print(f"stage {stage}: every third of {calls} calls, {failed} end the study")
        assert failed >= len(reference.content[0]) / 2
    store = folder / "no-locks"
    assert calls_of(library, reference, folder, 0, "ENOLCK") > 0
    done = with_faults(library, reference.command(store, 0), store, "ENOLCK", 1)  # as on some network file systems
    assert done.returncode == 0 and done.stdout == reference.stdout[0], done
    reference.check_end(store, 0)
    return None


# ---- small disks --------------------------------------------------------------------------------------------------


def namespace():
    """A way to mount something that only the process itself sees."""
    pathlib.Path("empty").mkdir()
    for command in (["unshare", "-m"], ["unshare", "-rm"]):
        if shutil.which("unshare") and subprocess.run([*command, "sh", "-c", "mount -t tmpfs -o size=64k none empty && "
                                                       "mount -o remount,ro empty"], capture_output=True).returncode == 0:
            return command
    return None


def mount(name, options):
    where = HERE / name
    where.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", where], check=True)
    return where


def remount(where, options):
    subprocess.run(["mount", "-o", f"remount,{options}", where], check=True)


def small_disks():
    """The rest in a namespace of its own, as another process."""
    command = namespace()
    if not command:
        return "no private mounts here"
    place = pathlib.Path("disks").resolve()
    place.mkdir()
    done = subprocess.run([*command, sys.executable, "-B", __file__, COMMAND, sys.argv[2], str(place)],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    print(done.stdout, end="")
    return None


def full_disk():
    """A disk that is enlarged bit by bit: at every size the study makes what fits, and loses none of it."""
    disk, reference = mount("disk", "size=20k"), six()
    store, finished, full = disk / "store", [{}, {}], 0
    sizes = iter(range(20, 10000, random.Random(5).randrange(12, 24)))
    for stage in range(2):
        for size in sizes:
            remount(disk, f"size={size}k")
            done = subprocess.run(reference.command(store, stage), capture_output=True, text=True, env=ENVIRONMENT)
            reference.look(store, stage, finished[stage])
            assert not list(store.glob("*.tmp"))
            if done.returncode == 0:
                break
            assert done.returncode == 1 and not done.stdout, done
            one_line(done.stderr, str(disk), "No space left on device")
            if finished[stage] or stage == 1:
                ensemble(store)
            full += 1
        assert done.stdout == reference.stdout[stage]
        reference.check_end(store, stage, finished[stage])
    assert full >= 5, full


def no_room_for_the_index():
    """The samples are all that counts: where nothing else fits, tables are right all the same."""
    disk = mount("filled", "size=4m")
    store = disk / "store"
    shutil.copytree(six().store[1], store)
    (store / "manifest.tsv").unlink(missing_ok=True)
    with open(disk / "filler", "wb", buffering=0) as filler:
        try:
            while filler.write(bytes(4096)):
                pass
        except OSError:
            pass
    before = identities(store)
    for _ in range(2):
        assert ensemble(store) == six().table[1]
        completes(store, 0, "full")
        (disk / "filler").unlink(missing_ok=True)
    assert identities(store) == before


def no_more_files():
    disk, finished = mount("inodes", "size=4m,nr_inodes=7"), {}  # room for three or four files
    one_line(study(six(), disk / "store", status=1).stderr, str(disk), "No space left on device")
    six().look(disk / "store", 1, finished)
    remount(disk, "nr_inodes=100")
    assert study(six(), disk / "store").stdout == six().stdout[1]
    six().check_end(disk / "store", 1, finished)


def read_only_disk():
    disk = mount("read-only", "size=4m")
    store = disk / "store"
    shutil.copytree(six().store[1], store)
    study(six(), store)
    check_read_only(store, lambda: remount(disk, "ro"), lambda: remount(disk, "rw"), "Read-only file system")


def check_read_only(store, close, reopen, reason, **options):
    """Tables of what is there, with the index and without; what is missing is not computed in vain."""
    reference, index = six(), store / "manifest.tsv"
    for state in ("as it is", "old", "none"):
        if state == "none":
            index.unlink(missing_ok=True)
        elif state == "old" and index.exists():
            index.write_bytes(index.read_bytes()[:index.stat().st_size // 2])
        close()
        before = {path.name: path.stat().st_mtime_ns for path in store.iterdir()}
        found = tried("table", "ensemble", "--store", store, env=ENVIRONMENT, **options)
        assert found.returncode == 0 and found.stdout == reference.table[1], (state, found)
        assert study(reference, store, **options).stdout == reference.stdout[1], state
        done = subprocess.run([*reference.command(store, 1), "--set", "packing.grains=30000", "--set", "packing.width=100"],
                              capture_output=True, text=True, env=ENVIRONMENT, timeout=PATIENCE, **options)
        assert done.returncode == 1 and not done.stdout, (state, done)
        one_line(done.stderr, str(store), reason)
        assert {path.name: path.stat().st_mtime_ns for path in store.iterdir()} == before
        reopen()
    assert study(reference, store, **options).stdout == reference.stdout[1]


def not_ours():
    """A store of somebody else, that may be read and not written. Root may write everywhere: the command runs as
    nobody then."""
    folder, reference = pathlib.Path().resolve(), six()
    for path in (folder, reference.scene.parent):
        path.chmod(0o755)
    user = {"user": 65534, "group": 65534, "cwd": folder} if os.geteuid() == 0 else {}
    reference.program = shutil.copy(COMMAND, folder / "sonopack")
    store = fresh(made=True)
    if user:
        for path in [store, *store.iterdir()]:
            os.chown(path, 65534, 65534)
    check_read_only(store, lambda: store.chmod(0o555), lambda: store.chmod(0o755), "Permission denied",
                    executable=reference.program, **user)
    # the folder may be written, some of its files may not
    for mode in (0o444, 0):
        (store / "manifest.tsv").chmod(mode)
        assert study(reference, store, **user).stdout == reference.stdout[1]
    (store / "manifest.tsv").unlink()
    victim = samples(store)[0]
    victim.chmod(0)
    if user:  # what may not be read is not damaged: nothing is done to it
        refused = study(reference, store, status=1, **user)
        assert victim.name in refused.stderr and names_all(refused.stderr, "Permission denied"), refused.stderr
        victim.chmod(0o600)
    completes(store, 0, "not ours", **user)
    reference.program = COMMAND


# ---- damaged files ------------------------------------------------------------------------------------------------


def flip(path, at):
    data = bytearray(path.read_bytes())
    data[at] ^= 0x10
    path.write_bytes(bytes(data))


def place_of(path, dataset):
    """Where in the file the data of a dataset begin."""
    with h5py.File(path) as file:
        data = file[dataset]
        if data.chunks:
            return data.id.get_chunk_info(0).byte_offset
        if data.id.get_offset():
            return data.id.get_offset()
        value = data[()]
    return path.read_bytes().index(value if isinstance(value, bytes) else value.tobytes())  # within its header


def replaced(make):
    def damage(path):
        path.unlink()
        make(path)
    return damage


def half(path):
    path.write_bytes(path.read_bytes()[:path.stat().st_size // 2])


OBJECTS = {  # that may lie in the place of any file
    "a folder": lambda path: path.mkdir(),
    "a folder with files": lambda path: (path.mkdir(), (path / "file").write_text("x")),
    "a FIFO": os.mkfifo,
    "a link to nothing": lambda path: path.symlink_to("nothing"),
    "a link to itself": lambda path: path.symlink_to(path.name),
    "an endless device": lambda path: path.symlink_to("/dev/zero"),
}
DAMAGES = {
    "a flipped byte of the results": lambda path: flip(path, place_of(path, "results/statics/s1_over_s2") + 3),
    "half": half,
    "one byte less": lambda path: path.write_bytes(path.read_bytes()[:-1]),
    "empty": lambda path: path.write_bytes(b""),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "text": lambda path: path.write_text("sample = 1\n"),
    "another sample": lambda path: shutil.copy(sorted(path.parent.glob("*.h5"))[-1], path),
    **{what: replaced(make) for what, make in OBJECTS.items()},
}


def damaged_files():
    """No table has the numbers of a damaged file; it is put aside as NAME.bad, and the sample is made anew, the same to
    the byte. Each kind of damage; then some one after the other to the same file, when there is a NAME.bad of another
    kind."""
    seed = random.randrange(10**6)
    print(f"seed {seed}")
    some = random.Random(seed).sample([*DAMAGES], 5)
    for again, what in [(False, what) for what in DAMAGES] + [(True, what) for what in some]:
        store = store if again else fresh(made=True)
        victim, before = store / sorted(six().content[1])[0], identities(store)
        DAMAGES[what](victim)
        assert len(table("table", "ensemble", "--store", store)) == six().count - 1, what
        completes(store, 1, what)
        assert {name: it for name, it in identities(store).items() if name != victim.name} == \
            {name: it for name, it in before.items() if name != victim.name}, what
        assert os.path.lexists(victim.with_suffix(".bad")) and ensemble(store) == six().table[1], what


RECORD_DAMAGES = {
    **{what: DAMAGES[what] for what in ("empty", "zeros", "half", "a folder", "a FIFO", "an endless device")},
    "without its last line": lambda path: path.write_bytes(path.read_bytes()[:path.read_bytes().rindex(b"seed")]),
    "no number": lambda path: path.write_bytes(re.sub(rb"seed = \d+", b"seed = x", path.read_bytes())),
}


def damaged_records():
    """Records of failed samples are files like others: a damaged one is put aside, and the sample is tried again."""
    reference = Reference(pathlib.Path("records").resolve(), SMALL, (STAGES[0],) * 2)
    for what, damage in RECORD_DAMAGES.items():
        store = fresh(reference, made=True)
        victim = sorted(store.glob("*.failed"))[0]
        damage(victim)
        lines = run("table", "ensemble", "--store", store).stdout.splitlines()
        assert set(lines[-3:]) < set(reference.table[1].splitlines()), what
        completes(store, 1, what, reference)
        assert os.path.lexists(victim.with_suffix(".bad")), what


def flipped_packings():
    """A flipped byte of the packing, which no table shows: --verify puts the file aside if the study did not."""
    store = fresh(made=True)
    for number, dataset in enumerate(("particles/grains/position/value", "sonopack/contacts/normal_force", "signal/F")):
        victim = samples(store)[number]
        flip(victim, place_of(victim, dataset) + 11)
        assert study(six(), store).stdout == six().stdout[1]
        if not victim.with_suffix(".bad").exists():
            run("study", "--store", store, "--verify", status=1)
        assert victim.with_suffix(".bad").exists(), dataset
        study(six(), store)
        assert content(store) == six().content[1], dataset


# ---- the index, locks and temporaries -----------------------------------------------------------------------------


def index_damages(dice):
    """Ways to spoil a cache, text to text."""
    def digit(text):
        """One digit of one number changed: what only a checksum can see."""
        k = dice.choice([k for k, byte in enumerate(text) if chr(byte).isdigit()])
        return text[:k] + (b"%d" % ((text[k] - ord("0") + dice.randrange(1, 10)) % 10)) + text[k + 1:]

    def flipped(text):
        k = dice.randrange(len(text))
        return text[:k] + bytes([text[k] ^ 1 << dice.randrange(8)]) + text[k + 1:]

    return [("empty", lambda text: b""), ("garbage", lambda text: dice.randbytes(5000)),
            ("lines of others", lambda text: text + text.replace(b"\t1\t", b"\t2\t")), ("a huge line", lambda text: text + b"x" * 10**7),
            ("the end of a line is missing", lambda text: text[:-7]), ("truncated", lambda text: text[:dice.randrange(len(text))]),
            *((make.__name__, make) for make in (flipped, digit) for _ in range(2))]


def indices():
    """The index is only a cache: whatever is in its place, no number changes and none is made again."""
    seed = random.randrange(10**6)
    print(f"seed {seed}")
    store = fresh(made=True)
    path, before = store / "manifest.tsv", identities(store)
    good = set(path.read_bytes().split(b"\n")) - {b""}
    assert all(any(sample.stem.encode() in line for line in good) for sample in samples(store)), good

    def check(what):
        assert ensemble(store) == six().table[1], what
        completes(store, 0, what)
        assert identities(store) == before, what

    for what, damage in index_damages(random.Random(seed)):
        path.write_bytes(damage(path.read_bytes()))
        check(what)
        assert good <= set(path.read_bytes().split(b"\n")), what  # and the study leaves a good one
    precious = path.parent.parent / "precious"
    for what, make in {**OBJECTS, "deleted": lambda path: None, "a link elsewhere": lambda path: path.symlink_to(precious)}.items():
        precious.write_text("precious")
        path.unlink()
        make(path)
        check(what)
        assert precious.read_text() == "precious", what
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif os.path.lexists(path):
            path.unlink()
        study(six(), store)


def odd_locks():
    """Whatever lies where the locks should be, samples are made."""
    precious = pathlib.Path("precious").resolve()
    for what, make in {**OBJECTS, "a link elsewhere": lambda path: path.symlink_to(precious)}.items():
        store = fresh()
        precious.write_text("precious")
        samples(store)[0].unlink()
        (store / ".sonopack-lock").unlink(missing_ok=True)
        make(store / ".sonopack-lock")
        completes(store, 1, what)
        assert precious.read_text() == "precious", what


def stale_index():
    """A file that says something else than when it was listed: tables show what it says now."""
    store = fresh(made=True)
    for victim in samples(store)[:2]:
        size = victim.stat().st_size
        with h5py.File(victim, "r+") as file:
            file["results/statics/s1_over_s2"][...] = 0.125
        assert victim.stat().st_size == size
        for _ in range(2):
            rows = table("table", "ensemble", "--store", store)
            assert dict(zip(rows.words("name"), rows["s1_over_s2"]))[victim.stem] == 0.125, victim
            assert made_now(study(six(), store).stderr) == 0
    # gone from the folder, gone from the tables; what was brought here is in the tables without a study
    for change, count in ((victim.unlink, 5), (lambda: shutil.copy(six().store[1] / victim.name, victim), 6)):
        change()
        assert len(table("table", "ensemble", "--store", store)) == count
    # files with other times and the same bytes are as good: nothing is made, and the index has the new times
    store = fresh()
    index = store / "manifest.tsv"
    for path in samples(store):
        os.utime(path)
    completes(store, 0, "copied")
    stamps = {line.split("\t")[3] for line in index.read_text().splitlines() if line[0] != "#" and "\t" in line}
    assert {str(path.stat().st_mtime_ns) for path in samples(store)} <= stamps


def old_temporaries():
    """What dead processes leave is removed; what may be another machine's is when it is a day old; files of others stay."""
    store, dead = fresh(), subprocess.Popen(["true"])
    dead.wait()
    host = 0xcbf29ce484222325  # FNV-1a of 64 bits, of which the name has the lower 32
    for byte in socket.gethostname().encode():
        host = (host ^ byte) * 0x100000001b3 & 0xffffffffffffffff
    ours, old, new = (f".sonopack-{host & 0xffffffff ^ other:08x}-{dead.pid}-{k}.tmp" for other, k in ((0, 3), (1, 5), (1, 6)))
    for name in (ours, old, new, "notes.txt", ".sonopack-notes"):
        (store / name).write_text("half")
    os.utime(store / old, (time.time() - 90000, time.time() - 90000))
    study(six(), store)
    left = {path.name for path in store.iterdir()}
    assert not left & {ours, old} and {"notes.txt", ".sonopack-notes", new} <= left, left


if len(sys.argv) == 4:
    for disk_test in (full_disk, no_room_for_the_index, no_more_files, read_only_disk):
        disk_test()
        print(disk_test.__name__, "ok")
else:
    main(refused_calls, small_disks, not_ours, damaged_files, damaged_records, flipped_packings, indices, odd_locks,
         stale_index, old_temporaries)
