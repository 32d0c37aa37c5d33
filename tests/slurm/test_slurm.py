"""packings/slurm.sh on a Slurm of its own: munged, slurmctld and slurmd, started here in a private folder with their own
ports, key and configuration, and ended here. An array gives the tables of one process, byte for byte; also when it is
cancelled in the middle and submitted again, when its time is over (it is queued again by itself), and with holes.

usage: test_slurm.py COMMAND SOURCE_DIR MPI_COMMAND [show]      MPI_COMMAND: a build with -DSONOPACK_MPI=ON, or none;
                                                                show: print what docs/cluster.md shows
"""
import contextlib
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import made_now, names_all  # noqa: E402

COMMAND, SOURCE, MPI_COMMAND = sys.argv[1:4]
SHOW = sys.argv[4:] == ["show"]
DAEMONS = ("munged", "slurmctld", "slurmd")

SCENE = """packing = { width = 8; grains = 120; tolerance = 1e-9; };
study = { samples = 6; want = ["ctof", "moduli"]; sweep = (
  { key = "packing.pressure"; values = [1e-4, 1e-3]; },
  { key = "packing.grains"; values = [60, 120]; } ); };
"""

# long enough to be stopped in the middle
LONGER = """packing = { width = 16; grains = 400; };
study = { samples = 40; want = ["statics"]; };
"""

CONFIGURATION = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmctldPort={port[0]}
SlurmdPort={port[1]}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000,bf_interval=1
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ReturnToService=2
KillWait=10
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES State=UP
"""


def wait_until(condition, seconds, what):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"waited {seconds} s for {what}"
        time.sleep(0.1)


class Slurm:
    """The daemons, and the commands that speak to them."""

    def __init__(self, folder):
        self.folder, self.daemons = folder, []
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith(("SLURM", "SBATCH", "OMPI", "PMI"))}
        self.environment.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        self.environment.update(SLURM_CONF=str(folder / "slurm.conf"), SONOPACK=COMMAND, LC_ALL="C.UTF-8")

    def start(self):
        with contextlib.ExitStack() as stack:
            sockets = [stack.enter_context(socket.socket()) for _ in range(2)]
            for one in sockets:
                one.bind(("127.0.0.1", 0))
            ports = [one.getsockname()[1] for one in sockets]
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        (self.folder / "slurm.conf").write_text(
            CONFIGURATION.format(host=socket.gethostname().split(".")[0], port=ports, folder=self.folder))
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n")
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.folder.chmod(0o755)  # munged wants its socket within reach of all
        self.daemon("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.socket",
                    f"--pid-file={self.folder}/munged.pid", f"--log-file={self.folder}/munged.log",
                    f"--seed-file={self.folder}/munged.seed")
        wait_until((self.folder / "munge.socket").exists, 10, "munged")
        self.daemon("slurmctld", "-D", "-i")
        self.daemon("slurmd", "-D", "-N", socket.gethostname().split(".")[0])
        wait_until(lambda: "idle" in self.run("sinfo", "-h", "-o", "%T", check=False), 30, "an idle node")

    def daemon(self, *command):
        log = open(self.folder / f"{command[0]}.out", "w")
        self.daemons.append(subprocess.Popen(command, env=self.environment, stdout=log, stderr=log,
                                             stdin=subprocess.DEVNULL))
        log.close()

    def run(self, *command, check=True, cwd=None):
        done = subprocess.run([str(c) for c in command], env=self.environment, capture_output=True, text=True, cwd=cwd)
        assert not check or done.returncode == 0, (command, done.returncode, done.stdout, done.stderr)
        return done.stdout

    def submit(self, *arguments, cwd):
        return self.run("sbatch", "--parsable", *arguments, cwd=cwd).strip()

    def states(self, job):
        """States of a job's tasks: {ID in the array: state}."""
        text = self.run("scontrol", "show", "job", job, "-o", check=False)
        return {re.search(r"ArrayTaskId=(\S+)", line).group(1): re.search(r"JobState=(\S+)", line).group(1)
                for line in text.splitlines() if "ArrayTaskId=" in line}

    def ended(self, job, seconds=120):
        active = ("PENDING", "RUNNING", "COMPLETING", "CONFIGURING", "REQUEUED", "SUSPENDED")
        wait_until(lambda: not any(state in active for state in self.states(job).values()), seconds, f"job {job}")
        wait_until(lambda: not self.run("squeue", "-h", "-j", job, check=False).strip(), 30, f"the end of job {job}")
        return self.states(job)

    def end(self):
        self.run("scancel", "--user", "root", check=False)
        with contextlib.suppress(AssertionError):
            wait_until(lambda: not self.run("squeue", "-h", check=False).strip(), 20, "the queue to empty")
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()

    def logs(self):
        for path in sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out")):
            print(f"--- {path.name}\n{path.read_text(errors='replace')[-3000:]}", file=sys.stderr)


def study(*arguments):
    done = subprocess.run([COMMAND, "study", *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


def samples(store):
    return {path.name: path.read_bytes() for path in store.glob("*.h5")}


def modified(store):
    return {path.name: path.stat().st_mtime_ns for path in store.glob("*.h5")}


def arrays(slurm, folder, scene, expected, text):
    script = pathlib.Path(SOURCE, "packings", "slurm.sh")
    for array, tasks in (("1-4", 4), ("0-6:2", 4), ("2,3,7", 3)):
        work = folder / f"array-{tasks}-{array[0]}"
        work.mkdir()
        job = slurm.submit(f"--array={array}", script, scene, "store", cwd=work)
        assert set(slurm.ended(job).values()) == {"COMPLETED"}, slurm.states(job)
        logs = sorted(work.glob(f"sonopack-{job}_*.log"))
        assert len(logs) == tasks, logs
        made = [made_now(log.read_text()) for log in logs]
        assert sum(made) == 24, (array, made)
        if "," not in array:
            assert made == [6] * 4, (array, made)
        assert samples(work / "store") == expected, array
        again = study(scene, "--store", work / "store")
        assert again.stdout == text and made_now(again.stderr) == 0


def stopped(slurm, folder):
    """Cancelled in the middle, and submitted again; its time over, and queued again by itself."""
    scene = folder / "longer.cfg"
    scene.write_text(LONGER)
    text = study(scene, "--store", folder / "longer").stdout
    expected = samples(folder / "longer")
    script = pathlib.Path(SOURCE, "packings", "slurm.sh")
    work = folder / "stopped"
    work.mkdir()
    store = work / "store"
    job = slurm.submit("--array=1-4", script, scene, store, cwd=work)
    wait_until(lambda: len(samples(store)) >= 3, 60, "three samples")
    slurm.run("scancel", job)
    slurm.ended(job)
    kept = modified(store)
    assert 3 <= len(kept) < 40, len(kept)
    job = slurm.submit("--array=1-4", script, scene, store, cwd=work)
    wait_until(lambda: len(modified(store)) >= len(kept) + 3, 60, "three samples more")
    running = [task for task, state in slurm.states(job).items() if state == "RUNNING"]
    assert running
    # as Slurm does before the time is over; scancel tries again what it cannot do while the task is being queued
    slurm.run("scancel", "--signal=USR1", "--batch", f"{job}_{running[0]}", check=False)
    assert set(slurm.ended(job).values()) == {"COMPLETED"}, slurm.states(job)
    logs = [path.read_text() for path in work.glob(f"sonopack-{job}_*.log")]
    assert sum(names_all(log, store) for log in logs) == 1, logs
    now = modified(store)
    assert all(now[name] == stamp for name, stamp in kept.items())
    assert samples(store) == expected
    again = study(scene, "--store", store)
    assert again.stdout == text and made_now(again.stderr) == 0


def one_job(slurm, folder, scene, expected, text):
    """Several tasks of one job: ranks of mpirun, and processes that would not know of each other."""
    if MPI_COMMAND != "none" and shutil.which("mpirun"):
        store, table = folder / "job", folder / "job.tsv"
        job = f"exec mpirun '{MPI_COMMAND}' study '{scene}' --store '{store}' >'{table}' 2>'{folder}/job.err'"
        slurm.run("sbatch", "--wait", "--ntasks=2", "--output=/dev/null", "--wrap", job)
        assert table.read_text() == text and samples(store) == expected
        said = (folder / "job.err").read_text()
        assert made_now(said) == 24 and names_all(said, "2"), said
    store, log = folder / "no-mpi", folder / "no-mpi.err"
    job = f"exec srun --mpi=none '{COMMAND}' study '{scene}' --store '{store}' >/dev/null 2>'{log}'"
    slurm.run("sbatch", "--wait", "--ntasks=2", "--output=/dev/null", "--wrap", job, check=False)
    assert names_all(log.read_text(), "2 -DSONOPACK_MPI=ON") and not store.exists(), log.read_text()


def show(slurm, folder):
    """What docs/cluster.md shows."""
    (folder / "my.cfg").write_text(LONGER)
    shutil.copy(pathlib.Path(SOURCE, "packings", "slurm.sh"), folder)
    slurm.environment["PATH"] = f"{pathlib.Path(COMMAND).parent}:{slurm.environment['PATH']}"
    del slurm.environment["SONOPACK"]
    for line in ("cat my.cfg", "sbatch --array=1-4 slurm.sh my.cfg store",
                 "sbatch --dependency=afterok:1 --wrap 'sonopack study my.cfg --store store --jobs 1 -o tables.tsv "
                 "--force'",
                 "squeue", "cat sonopack-1_*.log", "cut -f 1-7 tables.tsv"):
        if line.startswith("squeue"):
            wait_until(lambda: " R " in slurm.run("squeue"), 60, "a task that runs")
        if line.startswith("cat sonopack"):
            wait_until((folder / "tables.tsv").exists, 60, "tables")
            wait_until(lambda: not slurm.run("squeue", "-h").strip(), 30, "the end")
        print("$", line)
        print(slurm.run("bash", "-c", line, check=False, cwd=folder), end="", flush=True)


def main():
    missing = [name for name in (*DAEMONS, "sbatch", "scontrol") if not shutil.which(name)]
    if missing or os.geteuid() != 0:
        print(f"skipped: not there: {', '.join(missing)}" if missing else "skipped: the daemons want root")
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="sonopack-slurm-") as name:
        folder = pathlib.Path(name)
        slurm = Slurm(folder)
        scene = folder / "scene.cfg"
        scene.write_text(SCENE)
        try:
            slurm.start()
            if SHOW:
                work = folder / "show"
                work.mkdir()
                show(slurm, work)
                return
            text = study(scene, "--store", folder / "plain").stdout
            expected = samples(folder / "plain")
            assert len(expected) == 24
            arrays(slurm, folder, scene, expected, text)
            one_job(slurm, folder, scene, expected, text)
            stopped(slurm, folder)
        except BaseException:
            slurm.logs()
            raise
        finally:
            slurm.end()


main()
