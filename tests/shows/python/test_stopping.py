"""Progress functions see the work and may stop it; Ctrl-C raises KeyboardInterrupt; afterwards all is as before. Threads
work side by side, and numpy keeps its own.
"""
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
from common import raised

import sonopack
from sonopack import Column, Interrupted, Packing, Scene

SCENE = Scene(packing={"grains": 200, "width": 12})
SMALL = Scene(packing={"grains": 60, "width": 8})
DIAGRAM = dict(output="bifurcation", from_=0.5, to=1.2, points=40, taps=40, transient=100)


def time_used(process):
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def wait_for_work(process, seconds):
    """Until a process has used so much more processor time: unlike a clock it passes only when the process gets on."""
    before = time_used(process)
    while process.poll() is None:
        if time_used(process) >= before + seconds:
            return
        time.sleep(0.01)
    assert False, "it ended before it could be stopped"


class Stop(Exception):
    pass


def interrupt(*_):
    signal.raise_signal(signal.SIGINT)


def fail(*_):
    raise Stop


def sound():
    """What was interrupted has left nothing behind: the same work gives the same packing."""
    packing = Packing.make(SMALL)
    assert packing.hash == EXPECTED.hash and packing.audit().missing == 0, packing


def test_progress():
    seen = []
    packing = Packing.make(SCENE, progress=seen.append)
    assert {p.phase for p in seen} <= {"flight", "compaction", "equilibration"} and len(seen) > 3, seen
    assert all(a.steps < b.steps and a.fraction <= b.fraction + 0.2 for a, b in zip(seen, seen[1:])), seen
    assert Packing.make(SCENE).hash == packing.hash, "progress changes nothing"
    shares = []
    Column(**DIAGRAM).table(progress=shares.append)
    assert shares == sorted(shares) and all(0 <= share <= 1 for share in shares), shares
    samples = []
    sonopack.study(Scene(packing={"grains": 40, "width": 8}, study={"samples": 3}), "seen", progress=samples.append)
    assert samples[-1].done == samples[-1].total == 3 and samples[-1].failed == 0, samples


def test_stopped():
    calls = []
    fault = raised(Interrupted, Packing.make, SCENE, progress=lambda p: calls.append(p) or len(calls) < 3)
    assert len(calls) == 3 and fault.status == sonopack.Status.EINTERRUPTED, (calls, fault)
    sound()
    raised(Interrupted, Column(**DIAGRAM).table, progress=lambda share: False)
    sound()


def test_exceptions():
    raised(Stop, Packing.make, SCENE, progress=fail)
    raised(Stop, Column(**DIAGRAM).table, progress=fail, threads=2)
    raised(Stop, sonopack.study, SCENE, "stopped", progress=fail)
    sound()


def test_ctrl_c():
    raised(KeyboardInterrupt, Packing.make, SCENE, progress=interrupt)
    raised(KeyboardInterrupt, Column(**DIAGRAM).table, progress=interrupt, threads=2)
    raised(KeyboardInterrupt, sonopack.study, SCENE, "stopped", progress=interrupt)
    sound()


def test_study_goes_on():
    """What was finished when a study was stopped is kept, and not made again."""
    scene = Scene(packing={"grains": 40, "width": 8}, study={"samples": 40})
    seen = []
    raised(Interrupted, sonopack.study, scene, "study", progress=lambda p: seen.append(p) or p.done < 2)
    kept = len(list(pathlib.Path("study").glob("*.h5")))
    assert 2 <= kept == len(sonopack.Store("study").samples(scene)), kept
    last = []
    store = sonopack.study(scene, "study", progress=last.append)
    assert len(store) == 40 and last[-1].computed == 40 - kept, (kept, last[-1])


CHILD = """
import sonopack, sys
print("begun", flush=True)
try:
    {work}
except KeyboardInterrupt:
    packing = sonopack.Packing.make(sonopack.Scene(packing={{"grains": 60, "width": 8}}))
    print("interrupted", packing.hash, flush=True)
    sys.exit(3)
"""


def test_ctrl_c_without_progress():
    """The signal comes from outside, while no Python code runs."""
    for work in ('sonopack.Packing.make(sonopack.Scene(packing={"grains": 20000, "width": 60}))',
                 'sonopack.Column(taps=10_000_000, output="energy").table()',
                 'sonopack.Column(output="bifurcation", from_=0.5, to=1.2, points=10000, taps=1000).table(threads=2)',
                 'sonopack.study(sonopack.Scene(packing={"grains": 20000, "width": 60}), "big")'):
        child = subprocess.Popen([sys.executable, "-B", "-c", CHILD.format(work=work)], stdout=subprocess.PIPE, text=True)
        assert child.stdout.readline() == "begun\n", work
        wait_for_work(child, 0.2)
        child.send_signal(signal.SIGINT)
        words = child.stdout.read().split()
        assert child.wait() == 3 and words == ["interrupted", str(EXPECTED.hash)], (work, child.returncode, words)


def test_other_threads_run():
    """A long call does not hold the interpreter's lock. With the lock held the counter would stand still."""
    network = Packing.make(SCENE).network()
    counts, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counts[0] += 1

    counter = threading.Thread(target=count)
    counter.start()
    before = counts[0]
    network.modes()  # no callback
    during = counts[0] - before
    stop.set()
    counter.join()
    assert during > 1000, during


def test_threads():
    """The same packing is used by several threads, and each makes some of its own."""
    packing, results = Packing.make(SCENE), []

    def work(seed):
        network = packing.network()
        results.append((seed, network.signal(points=200).F.copy(), network.modes(lowest=10, solver="arpack").omega.copy(),
                        Packing.make(SMALL, seed=seed).hash))

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(1, 7)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 6, results
    for seed, force, omega, name in results:
        assert np.array_equal(force, results[0][1]) and np.array_equal(omega, results[0][2]), ("results differ", seed)
        assert name == Packing.make(SMALL, seed=seed).hash, ("packings differ", seed)


def test_studies_side_by_side():
    """Two threads fill one store, and read it meanwhile, as processes do; no sample is made twice."""
    scene = Scene(packing={"grains": 40, "width": 8}, study={"samples": 16, "want": ["moduli"]})
    store, computed, read = sonopack.Store("shared", create=True), [], []

    def work():
        last = []
        sonopack.study(scene, store, progress=lambda p: (last.append(p), read.append(len(store.samples(scene))))[0])
        computed.append(last[-1].computed)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(computed) == 2 and sum(computed) == 16, computed
    assert len(store) == 16 and read and max(read) <= 16, read
    assert store.table("moduli", scene).rows == 1 and not store.bad, store.bad


def test_interrupt_in_a_thread():
    """An exception in a thread's progress function is that thread's."""
    found = []

    def work():
        try:
            Packing.make(SCENE, progress=fail)
        except Stop as fault:
            found.append(fault)

    thread = threading.Thread(target=work)
    thread.start()
    packing = Packing.make(SCENE)
    thread.join()
    assert len(found) == 1 and packing.hash == Packing.make(SCENE).hash, found


def test_blas_threads():
    """The library computes on one BLAS thread, as the command does; numpy has its own number again afterwards."""
    import ctypes
    try:
        blas = ctypes.CDLL("libopenblas.so.0")
    except OSError:
        return print("no OpenBLAS")
    packing = Packing.make(SCENE)
    expected = packing.network().modes().omega.copy()
    for threads in (1, 2, 3):
        blas.openblas_set_num_threads(threads)
        set_now = blas.openblas_get_num_threads()
        assert np.array_equal(packing.network().modes().omega, expected), threads
        raised(Interrupted, Packing.make, SCENE, progress=lambda p: False)
        assert blas.openblas_get_num_threads() == set_now, (threads, blas.openblas_get_num_threads())


EXPECTED = Packing.make(SMALL)
