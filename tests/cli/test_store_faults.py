"""Stores on full and read-only disks, with damaged files and damaged manifests: nothing finished is lost, no number is
wrong, what failed is said in one line, and the next study completes the store.

usage: test_store_faults.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

import h5py

from common import PATIENCE, made_now, names_all
from store_faults import (ENVIRONMENT, SMALL, STAGES, Reference, calls_of, content, ensemble, identities, one_line,
                          refused_at, samples, shim, with_faults)
from streams import COMMAND, column, run, tables

# six good samples, with all wants at once: a packing names those that it was made for
SIX = (SMALL.replace("1e-6, 1e-3", "1e-4, 1e-3").replace("samples = 2", "samples = 3")
       .replace("max_steps = 3500;", "").replace('["statics"]', '["statics", "moduli", "signal"]'))


def study(reference, store, status=0, **keywords):
    command = reference.command(store, 1)
    done = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=PATIENCE, **keywords)
    assert done.returncode == status, (status, done)
    return done


def fresh(reference, folder, stage=1):
    store = folder / "store"
    if store.exists():
        shutil.rmtree(store)
    shutil.copytree(reference.store[stage], store)
    return store


# ---- calls that fail ----------------------------------------------------------------------------------------------


def refused_calls(folder):
    """Each call that changes the store fails, and all after it."""
    library = shim(folder)
    if not library:
        return "no cc, or a build with sanitizers"
    reference = Reference(folder / "small", SMALL)
    for stage in range(2):
        calls, failed = calls_of(library, reference, folder, stage), 0
        for at in range(1, calls + 1):
            do = ("ENOSPC", "EDQUOT", "EIO", "EROFS")[at % 4]
            failed += refused_at(library, reference, folder, stage, do, at)
        print(f"stage {stage}: {failed} of {calls} calls end the study")
        assert failed >= 3 * len(reference.content[0]) / 2
    store = folder / "no-locks"
    assert calls_of(library, reference, folder, 0, "ENOLCK") > 0
    done = with_faults(library, reference.command(store, 0), store, "ENOLCK", 1)  # as on some network file systems
    assert done.returncode == 0 and done.stdout == reference.stdout[0], done
    reference.check_end(store, 0)


# ---- small disks --------------------------------------------------------------------------------------------------


def namespace():
    """A way to mount something that only the process itself sees."""
    for command in (["unshare", "-m"], ["unshare", "-rm"]):
        test = [*command, "sh", "-c", 'mount -t tmpfs -o size=64k none "$0" && mount -o remount,ro "$0"', "."]
        with tempfile.TemporaryDirectory() as empty:
            try:
                if subprocess.run([*test[:-1], empty], capture_output=True).returncode == 0:
                    return command
            except FileNotFoundError:
                pass
    return None


def mount(where, options):
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", where], check=True)


def remount(where, options):
    subprocess.run(["mount", "-o", f"remount,{options}", where], check=True)


def small_disks(folder):
    """The rest in a namespace of its own, as another process."""
    command = namespace()
    if not command:
        return "no private mounts here"
    done = subprocess.run([*command, sys.executable, "-B", __file__, *sys.argv[1:3], str(folder)],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    print(done.stdout, end="")


def full_disk(folder, reference):
    """A disk that is enlarged bit by bit: at every size the study makes what fits, and loses none of it."""
    disk = folder / "disk"
    disk.mkdir()
    mount(disk, "size=20k")
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
    print(f"full_disk ok: {full} times full")


def no_room_for_the_manifest(folder, reference):
    """The samples are all that counts: where nothing else fits, tables are right all the same."""
    disk = folder / "filled"
    disk.mkdir()
    mount(disk, "size=4m")
    store = disk / "store"
    shutil.copytree(reference.store[1], store)
    (store / "manifest.tsv").unlink(missing_ok=True)
    with open(disk / "filler", "wb", buffering=0) as filler:
        try:
            while filler.write(bytes(4096)):
                pass
        except OSError:
            pass
    before = identities(store)
    assert ensemble(store) == reference.table[1]
    assert study(reference, store).stdout == reference.stdout[1]
    assert identities(store) == before and content(store) == reference.content[1]
    (disk / "filler").unlink()
    assert study(reference, store).stdout == reference.stdout[1] and identities(store) == before
    reference.check_end(store, 1)
    print("no_room_for_the_manifest ok")


def no_more_files(folder, reference):
    disk = folder / "inodes"
    disk.mkdir()
    mount(disk, "size=4m,nr_inodes=7")  # room for three or four files
    store, finished = disk / "store", {}
    one_line(study(reference, store, status=1).stderr, str(disk), "No space left on device")
    reference.look(store, 1, finished)
    remount(disk, "nr_inodes=100")
    assert study(reference, store).stdout == reference.stdout[1]
    reference.check_end(store, 1, finished)
    print("no_more_files ok")


def read_only_disk(folder, reference):
    disk = folder / "read-only"
    disk.mkdir()
    mount(disk, "size=4m")
    store = disk / "store"
    shutil.copytree(reference.store[1], store)
    run("study", reference.scene, "--store", store, *reference.stages[1])
    check_read_only(reference, store, lambda: remount(disk, "ro"), lambda: remount(disk, "rw"), "Read-only file system")
    print("read_only_disk ok")


def check_read_only(reference, store, close, reopen, reason, **keywords):
    """Tables of what is there, with the manifest and without; what is missing is not computed in vain."""
    for manifest in ("as it is", "old", "none"):
        if manifest == "none":
            (store / "manifest.tsv").unlink(missing_ok=True)
        elif manifest == "old" and (store / "manifest.tsv").exists():
            text = (store / "manifest.tsv").read_bytes()
            (store / "manifest.tsv").write_bytes(text[:len(text) // 2])
        close()
        before = {path.name: path.stat().st_mtime_ns for path in store.iterdir()}
        table = subprocess.run([reference.program, "table", "ensemble", "--store", store], capture_output=True,
                               text=True, env=ENVIRONMENT, **keywords)
        assert table.returncode == 0 and table.stdout == reference.table[1], (manifest, table)
        assert study(reference, store, **keywords).stdout == reference.stdout[1], manifest
        command = [*reference.command(store, 1), "--set", "packing.grains=30000", "--set", "packing.width=100"]
        done = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=PATIENCE, **keywords)
        assert done.returncode == 1 and not done.stdout, (manifest, done)
        one_line(done.stderr, str(store), reason)
        assert {path.name: path.stat().st_mtime_ns for path in store.iterdir()} == before
        reopen()
    assert study(reference, store, **keywords).stdout == reference.stdout[1]


def not_ours(folder):
    """A store of somebody else, that may be read and not written. Root may write everywhere: the command runs as
    nobody then."""
    reference = Reference(folder / "ours", SIX)
    for path in (folder, reference.scene.parent):
        path.chmod(0o755)
    user = {"user": 65534, "group": 65534, "cwd": folder} if os.geteuid() == 0 else {}
    reference.program = shutil.copy(COMMAND, folder / "sonopack")
    store = fresh(reference, folder)
    run("study", reference.scene, "--store", store, *reference.stages[1])
    if user:
        for path in [store, *store.iterdir()]:
            os.chown(path, 65534, 65534)
    check_read_only(reference, store, lambda: store.chmod(0o555), lambda: store.chmod(0o755), "Permission denied",
                    **user)
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
    assert study(reference, store, **user).stdout == reference.stdout[1] and content(store) == reference.content[1]


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


DAMAGES = {
    "a flipped byte of the results": lambda path: flip(path, place_of(path, "results/statics/s1_over_s2") + 3),
    "a flipped byte of the moduli": lambda path: flip(path, place_of(path, "results/moduli/c12") + 3),
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:-1000]),
    "one byte less": lambda path: path.write_bytes(path.read_bytes()[:-1]),
    "empty": lambda path: path.write_bytes(b""),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "text": lambda path: path.write_text("sample = 1\n"),
    "another sample": lambda path: shutil.copy(sorted(path.parent.glob("*.h5"))[-1], path),
    "a folder": replaced(lambda path: path.mkdir()),
    "a folder with files": replaced(lambda path: (path.mkdir(), (path / "file").write_text("x"))),
    "a FIFO": replaced(os.mkfifo),
    "a link to nothing": replaced(lambda path: path.symlink_to("nothing")),
    "an endless device": replaced(lambda path: path.symlink_to("/dev/zero")),
}


def damage_one(reference, store, what):
    """No table has the numbers of a damaged file; it is put aside as NAME.bad, and the sample is made anew, the same to
    the byte."""
    victim, before = store / sorted(reference.content[1])[0], identities(store)
    DAMAGES[what](victim)
    assert len(tables(ensemble(store))[0][2]) == reference.count - 1, what
    done = study(reference, store)
    assert done.stdout == reference.stdout[1] and made_now(done.stderr) == 1, (what, done)
    assert content(store) == reference.content[1], what
    assert {name: identity for name, identity in identities(store).items() if name != victim.name} == \
        {name: identity for name, identity in before.items() if name != victim.name}, what
    assert os.path.lexists(victim.with_suffix(".bad")), what
    assert ensemble(store) == reference.table[1], what


def damaged_files(folder):
    """Each kind of damage; then one after the other to the same file, when there is a NAME.bad of another kind."""
    reference = Reference(folder / "damage", SIX)
    for what in DAMAGES:
        store = fresh(reference, folder)
        study(reference, store)
        damage_one(reference, store, what)
    seed = random.randrange(10**6)
    print(f"seed {seed}")
    for what in random.Random(seed).sample([*DAMAGES, *DAMAGES], 2 * len(DAMAGES)):
        damage_one(reference, store, what)


RECORD_DAMAGES = {
    "empty": lambda path: path.write_bytes(b""),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "without its last line": lambda path: path.write_bytes(path.read_bytes()[:path.read_bytes().rindex(b"seed")]),
    "without its end": lambda path: path.write_bytes(path.read_bytes()[:-2]),
    "the half": lambda path: path.write_bytes(path.read_bytes()[:path.stat().st_size // 2]),
    "no number": lambda path: path.write_bytes(re.sub(rb"seed = \d+", b"seed = x", path.read_bytes())),
    "a folder": replaced(lambda path: path.mkdir()),
    "a FIFO": replaced(os.mkfifo),
    "an endless device": replaced(lambda path: path.symlink_to("/dev/zero")),
}


def damaged_records(folder):
    """Records of failed samples are files like others: a damaged one is put aside, and the sample is tried again."""
    reference = Reference(folder / "records", SMALL, (STAGES[0],) * 2)
    for what, damage in RECORD_DAMAGES.items():
        store = fresh(reference, folder)
        study(reference, store)
        victim = sorted(store.glob("*.failed"))[0]
        damage(victim)
        done = subprocess.run([COMMAND, "table", "ensemble", "--store", store], capture_output=True, text=True,
                              timeout=PATIENCE)
        assert done.returncode == 0 and set(done.stdout.splitlines()[-3:]) < set(reference.table[1].splitlines()), what
        done = study(reference, store)
        assert done.stdout == reference.stdout[1] and made_now(done.stderr) == 1, (what, done)
        assert content(store) == reference.content[1], what
        assert os.path.lexists(victim.with_suffix(".bad")), what


def flipped_packings(folder):
    """A flipped byte of the packing, which no table shows: --verify puts the file aside if the study did not."""
    reference = Reference(folder / "flips", SIX)
    store = fresh(reference, folder)
    study(reference, store)
    for number, dataset in enumerate(("particles/grains/position/value", "sonopack/contacts/normal_force", "signal/F")):
        victim = samples(store)[number]
        flip(victim, place_of(victim, dataset) + 11)
        assert study(reference, store).stdout == reference.stdout[1]
        bad = victim.with_suffix(".bad")
        if not bad.exists():
            run("study", "--store", store, "--verify", status=1)
        assert bad.exists(), dataset
        assert study(reference, store).stdout == reference.stdout[1]
        assert content(store) == reference.content[1], dataset


def copied_stores(folder):
    """Files with other times and the same bytes are as good: nothing is made, and the manifest has the new times."""
    reference = Reference(folder / "copied", SIX)
    store, other = fresh(reference, folder), folder / "other"
    study(reference, store)
    shutil.copytree(store, other, copy_function=shutil.copyfile)
    before = (other / "manifest.tsv").read_text()
    done = study(reference, other)
    assert made_now(done.stderr) == 0 and done.stdout == reference.stdout[1]
    lines = (other / "manifest.tsv").read_text().removeprefix(before).splitlines()
    assert len(lines) == reference.count, lines
    assert {line.split("\t")[3] for line in lines} == {str(path.stat().st_mtime_ns) for path in samples(other)}
    again = study(reference, other)
    assert again.stdout == reference.stdout[1] and len((other / "manifest.tsv").read_text().removeprefix(
        before).splitlines()) == reference.count


# ---- damaged manifests --------------------------------------------------------------------------------------------


def manifest_damages(dice, other):
    """Ways to spoil a cache, text to text."""
    def digit(text):
        """One digit of one number changed: what only a checksum can see."""
        k = dice.choice([k for k, byte in enumerate(text) if chr(byte).isdigit()])
        return text[:k] + (b"%d" % ((text[k] - ord("0") + dice.randrange(1, 10)) % 10)) + text[k + 1:]

    def flipped(text):
        k = dice.randrange(len(text))
        return text[:k] + bytes([text[k] ^ 1 << dice.randrange(8)]) + text[k + 1:]

    texts = [("empty", lambda text: b""), ("garbage", lambda text: dice.randbytes(5000)),
             ("lines of both", lambda text: text + other), ("a huge line", lambda text: text + b"x" * 10**7),
             ("the end of a line is missing", lambda text: text[:-7])]
    texts += [(f"truncated {k}", lambda text: text[:dice.randrange(len(text))]) for k in range(3)]
    return texts + [(f"{make.__name__} {k}", make) for k in range(4) for make in (flipped, digit)]


PLACES = {
    "a folder": lambda path: path.mkdir(),
    "a folder with files": lambda path: (path.mkdir(), (path / "file").write_text("x")),
    "a FIFO": os.mkfifo,
    "a link to nothing": lambda path: path.symlink_to("nowhere/manifest"),
    "a link to itself": lambda path: path.symlink_to(path.name),
    "a link elsewhere": lambda path: path.symlink_to(path.parent.parent / "precious"),
    "an endless device": lambda path: path.symlink_to("/dev/zero"),
}


def manifests(folder):
    """The manifest is only a cache: whatever is in its place, no number changes and none is made again,
    and the next study leaves a good one."""
    reference = Reference(folder / "index", SIX)
    seed = random.randrange(10**6)
    dice = random.Random(seed)
    print(f"seed {seed}")
    store = fresh(reference, folder)
    study(reference, store)
    path = store / "manifest.tsv"
    assert path.is_file(), "no manifest"
    good = lines_of(path)
    assert all(any(sample.stem.encode() in line for line in good) for sample in samples(store)), good
    other = Reference(folder / "other", SIX.replace("seed = 3", "seed = 77"))
    for what, damage in manifest_damages(dice, (other.store[1] / "manifest.tsv").read_bytes()):
        before, text = identities(store), path.read_bytes()
        path.write_bytes(damage(text))
        check_manifest(reference, store, before, good, what)
    path.unlink()
    check_manifest(reference, store, identities(store), good, "deleted")
    path.chmod(0o444)
    check_manifest(reference, store, identities(store), good, "read-only")
    for what, make in PLACES.items():
        (folder / "precious").write_text("precious")
        path.unlink()
        make(path)
        check_manifest(reference, store, identities(store), good, what, own=False)
        assert (folder / "precious").read_text() == "precious", what
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
            study(reference, store)
        elif not path.is_file():
            path.unlink()
            study(reference, store)


def lines_of(path):
    return {line for line in path.read_bytes().split(b"\n") if line}


def check_manifest(reference, store, before, good, what, own=True):
    """Tables before and after a study; own: a text of the manifest's own name, which a study puts right."""
    for _ in range(2):
        assert ensemble(store) == reference.table[1], what
        done = study(reference, store)
        assert done.stdout == reference.stdout[1] and made_now(done.stderr) == 0, (what, done)
    assert identities(store) == before and content(store) == reference.content[1], what
    if own:
        assert good <= lines_of(store / "manifest.tsv"), what


def odd_locks(folder):
    """Whatever lies where the locks should be, samples are made."""
    reference = Reference(folder / "locks", SIX)
    for what, make in PLACES.items():
        store = fresh(reference, folder)
        (folder / "precious").write_text("precious")
        samples(store)[0].unlink()
        (store / ".sonopack-lock").unlink(missing_ok=True)
        make(store / ".sonopack-lock")
        assert study(reference, store).stdout == reference.stdout[1], what
        assert content(store) == reference.content[1], what
        assert (folder / "precious").read_text() == "precious", what


def stale_manifest(folder):
    """A file that says something else than when it was listed: tables show what it says now."""
    reference = Reference(folder / "stale", SIX)
    store = fresh(reference, folder)
    study(reference, store)
    for victim in samples(store)[:3]:
        size = victim.stat().st_size
        with h5py.File(victim, "r+") as file:
            old = file["results/statics/s1_over_s2"][()]
            file["results/statics/s1_over_s2"][...] = 0.125
        assert victim.stat().st_size == size and old != 0.125
        for _ in range(2):
            (rows,) = tables(ensemble(store))
            values = dict(zip((row[rows[1].index("name")] for row in rows[2]), column(rows, "s1_over_s2")))
            assert values[victim.stem] == 0.125, (values, victim)
            assert made_now(study(reference, store).stderr) == 0
    # gone from the folder, gone from the tables
    victim.unlink()
    assert len(tables(ensemble(store))[0][2]) == reference.count - 1
    # a file that was brought here is in the tables without a study
    shutil.copy(reference.store[1] / victim.name, victim)
    assert len(tables(ensemble(store))[0][2]) == reference.count


def old_temporaries(folder):
    """What dead processes leave is removed; what a living one is writing, and files of others, are not."""
    reference = Reference(folder / "left", SIX)
    store = fresh(reference, folder)
    dead = subprocess.Popen(["true"])
    dead.wait()
    living = subprocess.Popen(["cat"], stdin=subprocess.PIPE)  # ends when it is told to
    try:
        host = 0xcbf29ce484222325  # FNV-1a of 64 bits, of which the name has the lower 32
        for byte in socket.gethostname().encode():
            host = (host ^ byte) * 0x100000001b3 & 0xffffffffffffffff
        host &= 0xffffffff
        names = {f".sonopack-{host:08x}-{dead.pid}-{k}.tmp" for k in (3, 4)}
        # of another machine, whose locks may not be seen here: removed when it is a day old
        away = {f".sonopack-{host ^ 1:08x}-{dead.pid}-{k}.tmp" for k in (5, 6)}
        for name in names | away:
            (store / name).write_text("half")
        old = min(away)
        os.utime(store / old, (time.time() - 90000, time.time() - 90000))
        (store / "notes.txt").write_text("left alone")
        (store / ".sonopack-notes").write_text("left alone")
        study(reference, store)
        left = {path.name for path in store.iterdir()}
        assert not left & (names | {old}), left
        assert {"notes.txt", ".sonopack-notes", max(away)} <= left, left
    finally:
        living.send_signal(signal.SIGKILL)
        living.wait()


def inside_the_namespace(folder):
    reference = Reference(folder / "reference", SIX)
    for test in (full_disk, no_room_for_the_manifest, no_more_files, read_only_disk):
        test(folder, reference)


def main():
    skipped = False
    for test in (refused_calls, small_disks, not_ours, damaged_files, damaged_records, flipped_packings, copied_stores,
                 manifests, odd_locks, stale_manifest, old_temporaries):
        with tempfile.TemporaryDirectory() as name:
            reason = test(pathlib.Path(name))
        print(test.__name__, f"skipped: {reason}" if reason else "ok")
        skipped = skipped or bool(reason)
    sys.exit(77 if skipped else 0)


if len(sys.argv) == 4:
    inside_the_namespace(pathlib.Path(sys.argv[3]))
else:
    main()
