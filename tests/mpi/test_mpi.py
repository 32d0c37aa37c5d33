"""sonopack study by mpirun: ranks share the samples as they come free, and give the bytes of one process; a killed,
interrupted or failed job loses nothing that was finished; errors are told once; waiting ranks sleep.

usage: test_mpi.py COMMAND SOURCE_DIR MPI_COMMAND      MPI_COMMAND: a build with -DSONOPACK_MPI=ON, or none
"""
import contextlib
import fcntl
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import PATIENCE, made_now, names_all, wait_until  # noqa: E402

COMMAND, SOURCE, MPI_COMMAND = sys.argv[1:4]

ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI", "PMI", "SLURM", "MV2"))}
ENVIRONMENT.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", LC_ALL="C.UTF-8")

SCENE = """packing = { width = 8; grains = 120; tolerance = 1e-9; protocol = "quick"; };
study = { samples = 6; want = ["ctof", "moduli"]; sweep = (
  { key = "packing.pressure"; values = [1e-4, 1e-3]; },
  { key = "packing.grains"; values = [60, 120]; } ); };
"""
SAMPLES = 24
# samples that take so long that a rank is stopped with one in its hands
LONGER = """packing = { width = 8; grains = 120; pressure = 1e-5; };
study = { samples = 30; want = ["statics"]; };
"""
LONGER_SAMPLES = 30


def start(ranks, *arguments, command=MPI_COMMAND):
    return subprocess.Popen(["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), command,
                             *map(str, arguments)], env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True)


def mpirun(ranks, *arguments, command=MPI_COMMAND, status=0):
    job = start(ranks, *arguments, command=command)
    out, err = job.communicate(timeout=PATIENCE)
    assert job.returncode == status, (ranks, arguments, job.returncode, out, err)
    return out, err


def plain(*arguments, command=COMMAND, status=0):
    done = subprocess.run([command, *map(str, arguments)], env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout, done.stderr


def ours(err):
    """What the command says; MPI's libraries may say more, of a network that a container lacks, say."""
    return [line for line in err.splitlines() if line.startswith("sonopack")]


def samples(store):
    return {path.name: path.read_bytes() for path in store.glob("*.h5")}


@contextlib.contextmanager
def held(store):
    """Meanwhile a quarter of the samples is in the hands of this process, so that a study cannot end, however quick it
    is and however long mpirun takes to end its ranks."""
    store.mkdir()
    with open(store / ".sonopack-lock", "w") as file:
        fcntl.lockf(file, fcntl.LOCK_EX, 0, 3 << 60)  # a lock for each name, from its first 62 bits
        yield


def modified(store):
    return {path.name: path.stat().st_mtime_ns for path in store.glob("*.h5")}


def processes(store):
    """Ranks that work on a store: {process: ID of its parent}, found by their command lines."""
    found = {}
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            state = (folder / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if words[0] == os.fsencode(MPI_COMMAND) and os.fsencode(store) in words and state[0] != "Z":
            found[int(folder.name)] = int(state[1])
    return found


def same_bytes(folder, scene, text, expected, slow):
    for ranks, jobs in ((1, None), (2, None), (4, None), (2, 2), (4, 2)) if slow else ((1, None), (4, None), (2, 2)):
        store = folder / f"ranks-{ranks}-{jobs}"
        more = ["--jobs", jobs] if jobs else []
        out, err = mpirun(ranks, "study", scene, "--store", store, *more)
        assert out == text, (ranks, jobs)
        assert samples(store) == expected, (ranks, jobs)
        assert made_now(err) == SAMPLES and len(ours(err)) == 1, err  # each once, and told once
        assert ranks == 1 or names_all(ours(err)[0], ranks), err
    before = modified(store)
    out, err = mpirun(ranks, "study", scene, "--store", store, *more)
    assert out == text and made_now(err) == 0 and modified(store) == before
    # shards of several ranks, and tables in a file
    store, table = folder / "shards", folder / "table.tsv"
    for shard in (1, 2):
        _, err = mpirun(2, "study", scene, "--store", store, "--shard", f"{shard}/2", "-q")
        assert ours(err) == []
    mpirun(2, "study", scene, "--store", store, "-o", table)
    assert samples(store) == expected
    assert table.read_text() + "\n" + table.with_name("table-moduli.tsv").read_text() == text
    # the same command without a launcher
    out, err = plain("study", scene, "--store", store, command=MPI_COMMAND)
    assert out == text and made_now(err) == 0


def cpu_time(process):
    return int(pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[11])


def dynamic(folder):
    """One rank is slowed down (stopped for a while): the others make the samples meanwhile."""
    scene, store = folder / "longer.cfg", folder / "dynamic"
    scene.write_text(LONGER)
    job = start(3, "study", scene, "--store", store)
    wait_until(lambda: len(modified(store)) >= 6, "six samples")
    ranks = sorted(processes(store))
    assert len(ranks) == 3, ranks
    os.kill(ranks[-1], signal.SIGSTOP)  # the last one to be started: not rank 0
    busy = [cpu_time(rank) for rank in ranks]
    assert min(busy) > 0.25 * max(busy), busy  # all of them make samples
    wait_until(lambda: len(modified(store)) >= LONGER_SAMPLES - 1, "the samples of the other ranks")
    assert job.poll() is None
    os.kill(ranks[-1], signal.SIGCONT)
    out, err = job.communicate(timeout=PATIENCE)
    assert job.returncode == 0 and made_now(err) == LONGER_SAMPLES, err
    return scene, out, samples(store)


def stopped(folder, slow, scene, text, expected):
    """mpirun or a rank killed, Ctrl-C to mpirun, SIGTERM to one rank: what was finished stays, and the job goes on."""
    def ends(name, act, told):
        store = folder / name
        with held(store):
            job = start(4, "study", scene, "--store", store)
            wait_until(lambda: len(modified(store)) >= 5, "five samples")
            act(job, sorted(processes(store)))
            before = modified(store)
            out, err = job.communicate(timeout=PATIENCE)
            wait_until(lambda: not processes(store), f"the ranks to end ({name})")
        assert job.returncode != 0 and out == "", (name, job.returncode, out)
        if told:
            lines = [line for line in ours(err) if str(store) in line]  # beside the acknowledgement of the signal
            assert len(lines) == 1 and names_all(lines[0], f"{LONGER_SAMPLES} {store}"), (name, err)
        kept = modified(store)
        assert before.items() <= kept.items() and len(kept) < LONGER_SAMPLES, (name, len(before), len(kept))
        out, err = mpirun(2, "study", scene, "--store", store)
        assert out == text and made_now(err) == LONGER_SAMPLES - len(kept), (name, err)
        assert samples(store) == expected and kept.items() <= modified(store).items(), name

    if slow:
        ends("mpirun killed", lambda job, ranks: job.kill(), False)
    ends("rank 0 killed", lambda job, ranks: os.kill(ranks[0], signal.SIGKILL), False)
    if slow:
        ends("last rank killed", lambda job, ranks: os.kill(ranks[-1], signal.SIGKILL), False)
    ends("interrupted", lambda job, ranks: job.send_signal(signal.SIGINT), False)
    ends("one rank ended", lambda job, ranks: os.kill(ranks[-1], signal.SIGTERM), True)


def failed_samples(folder):
    """What cannot be made is counted once, and is the same as without MPI."""
    args = ["study", "--set", "packing.width=8", "--set", "packing.grains=60", "--set", "study.samples=4", "--set",
            "study.want=statics", "--set", 'study.sweep=({ key = "packing.max_steps"; values = [100, 1000000]; })']
    _, err = plain(*args, "--store", folder / "failing")
    assert names_all(ours(err)[-1], 4), err
    _, err = mpirun(3, *args, "--store", folder / "failing-3")
    assert len(ours(err)) == 2 and names_all(ours(err)[-1], 4), err
    assert len(list((folder / "failing-3").glob("*.failed"))) == len(list((folder / "failing").glob("*.failed")))


def refused(folder, scene):
    store = folder / "refused"
    for arguments, status, reason in (
            (["study", scene], 2, "--store"), (["study", scene, "--store", store, "--jobz"], 2, "--jobz"),
            (["study", "--store", store, "--verify"], 2, "--verify"),
            (["study", folder / "none.cfg", "--store", store], 2, "none.cfg"),
            (["study", scene, "--store", scene], 1, str(scene))):
        out, err = mpirun(3, *arguments, status=status)
        assert out == "" and len(ours(err)) == 1 and names_all(err, reason), err
    assert "Usage" in mpirun(3, "study", "--help")[0]
    # ranks that do not make the same
    out, err = mpirun(1, "study", scene, "--store", store, ":", "-n", "1", MPI_COMMAND, "study", scene, "--store", store,
                      "--set", "packing.seed=7", status=2)
    assert names_all(err, "rank 1") and out == ""
    out, err = mpirun(1, "study", scene, "--store", store, ":", "-n", "1", MPI_COMMAND, "study", folder / "none.cfg",
                      "--store", store, status=2)
    assert names_all(err, "rank 1 none.cfg") and out == ""


def unlike_folders(folder):
    """One name of a store, and a folder of its own for each rank: nothing is printed as if it were whole."""
    script = folder / "elsewhere.sh"
    script.write_text(f'#!/bin/sh\nmkdir -p "{folder}/r$OMPI_COMM_WORLD_RANK"\ncd "{folder}/r$OMPI_COMM_WORLD_RANK"\n'
                      f'exec "{MPI_COMMAND}" "$@"\n')
    script.chmod(0o755)
    out, err = mpirun(2, "study", "--store", "store", "--set", "study.samples=12", "--set", "packing.grains=60",
                      "--set", "packing.width=8", command=script, status=1)
    assert not out and any("ranks" in line for line in ours(err)), (out, err)


def without_mpi(folder, scene, text):
    """A build without MPI says so where several of its processes would each do everything."""
    store = folder / "single"
    _, err = mpirun(2, "study", scene, "--store", store, command=COMMAND, status=2)
    assert "-DSONOPACK_MPI=ON" in err and not store.exists()
    done = subprocess.run([COMMAND, "study", scene, "--store", store], env={**ENVIRONMENT, "PMI_SIZE": "2"},
                          capture_output=True, text=True)
    assert done.returncode == 2 and "-DSONOPACK_MPI=ON" in done.stderr
    shards = f'exec "{COMMAND}" study "{scene}" --store "{store}" -q --shard $((OMPI_COMM_WORLD_RANK + 1))/2'
    mpirun(2, "-c", shards, command="sh")
    assert plain("study", scene, "--store", store)[0] == text


def sleepers(folder):
    """Three ranks wait for the one that makes the only sample: they may not take its cores."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.monotonic()
    mpirun(4, "study", "--store", folder / "one", "--set", "packing.width=24", "--set", "packing.grains=1500", "--set",
           "packing.protocol=quick", "--set", "study.samples=1", "--set", "study.want=statics")
    wall = time.monotonic() - begun
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    # one core for the sample; the rest is the start of four processes and of mpirun, 0.5 s here, and looking for mail
    assert cpu < wall + 1, (cpu, wall)
    return wall, cpu


def main(slow=False):
    if MPI_COMMAND == "none" or not shutil.which("mpirun"):
        print("skipped: no MPI here (Debian: openmpi-bin, libopenmpi-dev)")
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="sonopack-mpi-") as name:
        folder = pathlib.Path(name)
        scene = folder / "scene.cfg"
        scene.write_text(SCENE)
        text, _ = plain("study", scene, "--store", folder / "plain")
        expected = samples(folder / "plain")
        assert len(expected) == SAMPLES
        same_bytes(folder, scene, text, expected, slow)
        stopped(folder, slow, *dynamic(folder))
        failed_samples(folder)
        refused(folder, scene)
        unlike_folders(folder)
        if COMMAND != MPI_COMMAND:
            without_mpi(folder, scene, text)
        print("four ranks and one sample: {:.1f} s, {:.1f} s of CPU time".format(*sleepers(folder)))


if __name__ == "__main__":
    main()
