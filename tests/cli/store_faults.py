"""What tests of stores share that are killed, filled, damaged and used by many: the uninterrupted store to compare
with, what may lie in a folder, and calls that fail (faults.c)."""
import contextlib
import errno
import os
import pathlib
import random
import shutil
import signal
import subprocess

from command import COMMAND, run, sanitized
from common import PATIENCE, made_now, wait_until

# quick packings; of the second stage all results, so that every file is written a second time
SCENE = """
packing = { width = 8; grains = 40; tolerance = 1e-7; seed = 3; protocol = "quick"; };
study = { samples = 15; want = ["statics"]; sweep = ( { key = "packing.pressure"; values = [1e-4, 1e-3]; } ); };
signal = { until = 40.0; points = 41; };
"""
# two good samples and two that fail: the soft ones need more steps
SMALL = """
packing = { width = 8; grains = 40; tolerance = 1e-7; seed = 3; protocol = "quick"; max_steps = 3500; };
study = { samples = 2; want = ["statics"]; sweep = ( { key = "packing.pressure"; values = [1e-6, 1e-3]; } ); };
signal = { until = 40.0; points = 41; };
"""
STAGES = (), ("--set", 'study.want=["statics","moduli","signal"]')
OF_THE_STORE = {"manifest.tsv", ".sonopack-lock"}  # beside the samples
ENVIRONMENT = {**os.environ, "LC_ALL": "C"}


def samples(store):
    """The files of samples, and of their failures."""
    return sorted([*store.glob("*.h5"), *store.glob("*.failed")]) if store.exists() else []


def content(store):
    return {path.name: path.read_bytes() for path in samples(store)}


def identities(store):
    found = {}
    for path in samples(store):
        with contextlib.suppress(FileNotFoundError):  # renamed at this very moment
            found[path.name] = path.stat().st_ino, path.stat().st_mtime_ns
    return found


def ensemble(store):
    return run("table", "ensemble", "--store", store).stdout


class Reference:
    """A store that nobody disturbed: after each stage a copy, and what was printed."""

    def __init__(self, folder, scene=SCENE, stages=STAGES):
        folder.mkdir()
        self.program = COMMAND
        self.scene, self.stages = folder / "scene.cfg", stages
        self.scene.write_text(scene)
        self.stdout, self.table, self.content, self.store = [], [], [], []
        working = folder / "store"
        for number, stage in enumerate(stages):
            self.stdout.append(run("study", self.scene, "--store", working, *stage, "--jobs", 2).stdout)
            self.table.append(ensemble(working))
            self.content.append(content(working))
            self.store.append(folder / f"stage{number}")
            shutil.copytree(working, self.store[-1])
        self.count = len(self.content[-1])

    def command(self, store, stage, *args):
        words = [self.program, "study", self.scene, "--store", store, *self.stages[stage], *args]
        return [str(word) for word in words]

    def look(self, store, stage, finished):
        """At any moment: every file is whole, and of this stage or the one before; none that was finished is gone, or
        was made again. The number of those."""
        for name, data in content(store).items():
            done = data == self.content[stage][name]
            assert done or (stage > 0 and data == self.content[stage - 1][name]), (name, "is not whole")
            assert done or name not in finished, (name, "was finished and is not any more")
        for name, identity in identities(store).items():
            if (store / name).read_bytes() == self.content[stage][name]:
                assert finished.setdefault(name, identity) == identity, (name, "was finished and was made again")
        assert finished.keys() <= identities(store).keys(), "a finished sample is gone"
        return len(finished)

    def finish(self, store, stage, finished, *args):
        """Goes on to the end of the stage: to the same bytes and tables, and nothing else in the folder."""
        done = subprocess.run(self.command(store, stage, *args), capture_output=True, text=True, env=ENVIRONMENT)
        assert done.returncode == 0, done
        assert done.stdout == self.stdout[stage], (done.stdout, self.stdout[stage])
        made = made_now(done.stderr)
        assert made == self.count - len(finished), (made, self.count, len(finished))
        self.check_end(store, stage, finished)

    def check_end(self, store, stage, finished=None):
        assert content(store) == self.content[stage]
        if finished is not None:
            self.look(store, stage, finished)
        others = {path.name for path in store.iterdir()} - self.content[stage].keys()
        assert others <= OF_THE_STORE, others
        assert ensemble(store) == self.table[stage]


# ---- processes that are stopped at random moments ----------------------------------------------------------------


def one_line(err, *words):
    lines = err.splitlines()
    assert len(lines) == 1 and all(word in lines[0] for word in words), (err, words)


def check_stopped(process, number, out, err, whole):
    """What a process says that got a signal: nothing after kill -9, or what it had begun to print at the end; else the
    way on, unless it came before anybody listened, or after the last sample."""
    told = err.splitlines()
    if number == signal.SIGKILL or process.returncode == -number:
        assert process.returncode == -number and whole.startswith(out), (process.returncode, out, err)
        return
    assert process.returncode == 1 and whole.startswith(out), (process.returncode, out, err)
    if len(told) > 1:  # after the acknowledgement the way on, if it was not ended in the midst of work
        assert len(told) == 2 and not out, (out, err)


def wait_for_changes(process, store, count):
    """Until a process has written so many samples, or has ended."""
    before = identities(store)
    wait_until(lambda: process.poll() is not None or len(identities(store).items() - before.items()) >= count,
               f"{count} samples", every=0.001)


def stopped_at_random(reference, folder, signals, moments, seed):
    """Studies that get a signal after some sample, and go on, until `moments' of them were hit. How many hits fall between
    the first and the last sample depends on the machine, and is told."""
    dice = random.Random(seed)
    hits = inside = rounds = 0
    while hits < moments:
        rounds += 1
        store = folder / f"round{rounds}"
        for stage in range(len(reference.stages)):
            finished = {}
            while hits < moments:
                process = subprocess.Popen(reference.command(store, stage, "--jobs", 2), stdout=subprocess.PIPE,
                                           stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)
                wait_for_changes(process, store, dice.randrange(reference.count))
                number = dice.choice(signals)
                process.send_signal(number)
                out, err = process.communicate(timeout=PATIENCE)
                if process.returncode == 0:
                    assert out == reference.stdout[stage]
                    break
                check_stopped(process, number, out, err, reference.stdout[stage])
                had, hits = len(finished), hits + 1
                now = reference.look(store, stage, finished)
                inside += 0 < now < reference.count and now > had
                if number != signal.SIGKILL:
                    assert not list(store.glob("*.tmp"))
            reference.look(store, stage, finished)
            reference.finish(store, stage, finished, "--jobs", 2)
        shutil.rmtree(store)
    print(f"seed {seed}: {hits} stopped in {rounds} stores, {inside} of them between samples")


# ---- calls that fail ----------------------------------------------------------------------------------------------


def shim(folder):
    """The compiled faults.c; None: there is no compiler, or the command has the sanitizers, which are to be first."""
    compiler = shutil.which("cc")
    if not compiler or sanitized():
        return None
    source, library = pathlib.Path(__file__).with_name("faults.c"), folder / "faults.so"
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
    return library


def with_faults(library, command, store, do, at, count=None):
    environment = {**ENVIRONMENT, "LD_PRELOAD": str(library), "FAULTS_DIR": str(store.resolve()), "FAULTS_AT": str(at),
                   "FAULTS_CALL": "lock" if do == "ENOLCK" else "change",
                   "FAULTS_ERROR": str(getattr(errno, do, do))}
    if count:
        environment["FAULTS_COUNT"] = str(count)
    return subprocess.run(command, capture_output=True, text=True, env=environment)


def start_of(reference, folder, stage):
    """A store as it is before the stage."""
    store = folder / "faulted"
    shutil.rmtree(store, ignore_errors=True)
    if stage > 0:
        shutil.copytree(reference.store[stage - 1], store)
    return store


def calls_of(library, reference, folder, stage, do="KILL"):
    """How many calls of one stage can fail; one thread makes them in the same order every time."""
    count, store = folder / "count", start_of(reference, folder, stage)
    done = with_faults(library, reference.command(store, stage, "--jobs", 1), store, do, 0, count)
    assert done.returncode == 0 and done.stdout == reference.stdout[stage], done
    words = dict(line.split() for line in count.read_text().splitlines())
    return int(words["lock" if do == "ENOLCK" else "change"])


def killed_at(library, reference, folder, stage, do, at):
    store, finished = start_of(reference, folder, stage), {}
    done = with_faults(library, reference.command(store, stage, "--jobs", 1), store, do, at)
    assert done.returncode == -signal.SIGKILL, (do, at, done)
    reference.look(store, stage, finished)
    reference.finish(store, stage, finished, "--jobs", 1)


def refused_at(library, reference, folder, stage, do, at):
    """Calls that return an error, from one on. The study fails and says why, or did not need what failed."""
    store, finished = start_of(reference, folder, stage), {}
    done = with_faults(library, reference.command(store, stage, "--jobs", 1), store, do, at)
    count = reference.look(store, stage, finished)
    if done.returncode == 0:  # something of the store's own, not a sample
        assert count == reference.count and done.stdout == reference.stdout[stage], (do, at, done)
    else:
        assert done.returncode == 1 and not done.stdout, (do, at, done)
        one_line(done.stderr, str(store), os.strerror(getattr(errno, do)))
    reference.finish(store, stage, finished, "--jobs", 1)
    return done.returncode
