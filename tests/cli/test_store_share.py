"""Several processes on one store: every sample is made once, whoever dies or stops, and the bytes and tables are those
of one process alone.

usage: test_store_share.py COMMAND SOURCE_DIR
"""
import pathlib
import random
import shutil
import signal
import subprocess

from command import COMMAND, main, run
from common import PATIENCE, made_now, names_all, sleeps, wait_until, worked
from store_faults import ENVIRONMENT, STAGES, Reference, content, samples

# fourteen samples of some tenths of a second, so that processes are at work at the same time
SLOW = """
packing = { width = 12; grains = 150; tolerance = 1e-7; seed = 3; protocol = "quick"; };
study = { samples = 7; want = ["statics"]; sweep = ( { key = "packing.pressure"; values = [1e-5, 1e-3]; } ); };
signal = { until = 40.0; points = 41; };
"""


def start(reference, store, stage, *args):
    return subprocess.Popen(reference.command(store, stage, *args), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True, env=ENVIRONMENT)


def end(process):
    """(what it printed, how many samples it made)"""
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, (process.returncode, out, err)
    return out, made_now(err)


def made_by(found):
    return [made for _, made in found]


def four_at_once(folder, reference):
    """The same command four times, through both stages."""
    store = folder / "four"
    for stage in range(2):
        found = [end(process) for process in [start(reference, store, stage, "--jobs", 1) for _ in range(4)]]
        assert all(out == reference.stdout[stage] for out, _ in found)
        assert sum(made_by(found)) == reference.count, made_by(found)
        reference.check_end(store, stage)
        print(f"stage {stage}: {made_by(found)} of {reference.count} samples")


def one_of_them_killed(folder, reference):
    """What a dead process had begun is made by the others."""
    dice = random.Random(seed := random.randrange(10**6))
    print(f"seed {seed}")
    for number in range(3):
        store, finished = folder / f"killed{number}", {}
        processes = [start(reference, store, 1, "--jobs", 1 + number % 2) for _ in range(4)]
        victim = processes.pop(dice.randrange(4))
        there = dice.randrange(reference.count - 4)
        wait_until(lambda: len(samples(store)) >= there, there)
        victim.kill()
        victim.communicate()
        reference.look(store, 1, finished)
        found = [end(process) for process in processes]
        assert all(out == reference.stdout[1] for out, _ in found)
        assert sum(made_by(found)) <= reference.count, made_by(found)
        reference.look(store, 1, finished)
        reference.finish(store, 1, finished)


def shards(folder, reference):
    """At once, one after the other, and over a store that is there in part."""
    for name, at_once in (("at-once", True), ("in-turn", False)):
        store, made = folder / name, 0
        order = (3, 1, 4, 2)
        processes = []
        for k in order:
            processes.append(start(reference, store, 1, "--jobs", 1, "--shard", f"{k}/4"))
            if not at_once:
                made += end(processes.pop())[1]
        made += sum(end(process)[1] for process in processes)
        assert made == reference.count, (name, made)
        assert content(store) == reference.content[1]
        out, more = end(start(reference, store, 1, "--shard", "1/1"))
        assert out == reference.stdout[1] and more == 0
        reference.check_end(store, 1)
    # a shard and all of it at the same time
    store = folder / "part-and-whole"
    processes = [start(reference, store, 1, "--jobs", 1, "--shard", shard) for shard in ("1/1", "2/2", "1/1")]
    found = [end(process) for process in processes]
    assert sum(made_by(found)) == reference.count, made_by(found)
    assert found[0][0] == found[2][0] == reference.stdout[1]
    reference.check_end(store, 1)


def threads(folder, reference):
    for jobs in (1, 2, 4):
        store = folder / f"jobs{jobs}"
        for stage in range(2):
            assert end(start(reference, store, stage, "--jobs", jobs)) == (reference.stdout[stage], reference.count)
            reference.check_end(store, stage)


def standing_still(folder, reference, name, *args):
    """(store, a process that stands still with a sample in its hands, others that wait for it, samples that were there
    when it stopped). It is tried again where the process had nothing in its hands just then."""
    for attempt in range(20):
        store = folder / f"{name}{attempt}"
        still = start(reference, store, 1, "--jobs", 1)
        wait_until(lambda: len(samples(store)) >= 2, "two samples")
        before = worked(still)
        wait_until(lambda: worked(still) > before + 0.02, "the third sample to be begun")
        still.send_signal(signal.SIGSTOP)
        others = [start(reference, store, 1, *args) for _ in range(2)]
        had = len(samples(store))
        wait_until(lambda: len(samples(store)) >= reference.count - 1, "all but one")
        wait_until(lambda: len(samples(store)) == reference.count or all(map(sleeps, others)), "the others to sleep")
        if len(samples(store)) < reference.count:
            assert all(process.poll() is None for process in others), "who waits for another stays"
            return store, still, others, had
        still.send_signal(signal.SIGCONT)
        for process in [still, *others]:
            end(process)
    raise AssertionError("a sample in one process's hands is made by another")


def stopped(folder, reference, resume):
    """The others make all the rest and wait for that one. When the process goes on it makes it; when it is killed they
    do, and the next study removes the file that it was writing."""
    store, still, others, had = standing_still(folder, reference, f"stopped-{resume}-", "--jobs", 1)
    still.send_signal(signal.SIGCONT if resume else signal.SIGKILL)
    found = [end(process) for process in others]
    if resume:
        found.append(end(still))
        assert sum(made_by(found)) == reference.count, made_by(found)
    else:
        still.communicate()
        assert sum(made_by(found)) == reference.count - had, (made_by(found), had)
        assert end(start(reference, store, 1)) == (reference.stdout[1], 0)
    assert all(out == reference.stdout[1] for out, _ in found)
    reference.check_end(store, 1)


def waiting_is_stopped(folder, reference):
    """Ctrl-C ends a process that waits for another."""
    store, still, others, _ = standing_still(folder, reference, "waiting", "--jobs", 2)
    for process, number in zip(others, (signal.SIGINT, signal.SIGTERM)):
        process.send_signal(number)
        out, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 1 and not out and names_all(err, store), (process.returncode, err)
    still.send_signal(signal.SIGCONT)
    assert end(still)[0] == reference.stdout[1]
    reference.check_end(store, 1)


def growing_wants(folder, reference):
    """Studies with unlike wants fill the same files at the same time: no part is lost, whoever writes last."""
    store = folder / "parts"
    wants = "statics", "moduli", "signal"
    processes = [subprocess.Popen([COMMAND, "study", reference.scene, "--store", store, "--jobs", "1", "--set",
                                   f'study.want=["{want}"]'], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                 for want in wants]
    for process in processes:
        end(process)
    out, made = end(start(reference, store, 1))
    assert out == reference.stdout[1] and made == 0, made
    assert run("table", "ensemble", "--store", store).stdout == reference.table[1]


def readers(folder, reference):
    """Tables while a study runs: always of whole samples, never fewer than before."""
    store, before, looks = folder / "read", 0, 0
    writer = start(reference, store, 1, "--jobs", 1)
    wait_until(lambda: len(samples(store)) > 0, "a sample")
    rows = set(reference.table[1].splitlines())
    while writer.poll() is None:
        lines = [line for line in run("table", "ensemble", "--store", store).stdout.splitlines() if line[0] != "#"]
        assert set(lines) <= rows and len(lines) >= before, (before, lines)
        before, looks = len(lines), looks + 1
    assert end(writer)[0] == reference.stdout[1] and looks > 1
    reference.check_end(store, 1)


def all_of_them():
    folder = pathlib.Path()
    reference = Reference(folder / "reference", SLOW, STAGES)
    # of a store that begins with all wants: the packings are made for them
    whole = Reference(folder / "whole", SLOW.replace('["statics"]', '["statics","moduli","signal"]'), (STAGES[1],) * 2)
    for test, arguments in ((four_at_once, (reference,)), (threads, (reference,)), (one_of_them_killed, (whole,)),
                            (shards, (whole,)), (stopped, (whole, True)), (stopped, (whole, False)),
                            (waiting_is_stopped, (whole,)), (growing_wants, (whole,)), (readers, (whole,))):
        test(folder, *arguments)
        print(test.__name__, "ok", flush=True)
        for store in folder.iterdir():
            if store.name not in ("reference", "whole"):
                shutil.rmtree(store)


main(all_of_them)
