"""Shared by the measuring scripts of this folder: runs of commands with their CPU time, and tables."""
import concurrent.futures
import contextlib
import dataclasses
import math
import os
import platform
import resource
import subprocess
import sys
import tempfile
import threading
import time

# Quantities of Tables I and II (names of `sonopack statics` and `sonopack moduli`), and of the front.
STATICS = ("Phi2", "Phi3", "Phi3s", "zs", "f0", "N_over_p", "Z2", "Z3", "F2", "F2S", "s1_over_s2")
MODULI = ("C11", "C12", "C22", "C33", "c_l", "c_t")
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "LC_ALL": "C.UTF-8"}


@dataclasses.dataclass
class Run:
    """A finished command; status is negative for a signal."""
    status: int
    user: float
    wall: float
    out: str
    err: str

    def reason(self):
        lines = [line for line in self.err.splitlines() if line.strip()]
        last = lines[-1] if lines else "nothing on stderr"
        return last if self.status >= 0 else f"ended by signal {-self.status}: {last}"


class Runner:
    """Runs commands, several at a time if wanted, each with a bound on its CPU time."""

    def __init__(self, jobs=1, limit=600):
        self.pool = concurrent.futures.ThreadPoolExecutor(jobs)
        self.limit = limit
        self.running, self.lock, self.closed = set(), threading.Lock(), False

    def run(self, command, cwd=None):
        clock = time.monotonic()
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
            with self.lock:
                if self.closed:
                    raise RuntimeError("no more commands are started")
                process = subprocess.Popen(command, cwd=cwd, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                           env={**os.environ, **ONE_THREAD})
                self.running.add(process)
            with contextlib.suppress(OSError, ValueError):  # a stricter bound is in force
                resource.prlimit(process.pid, resource.RLIMIT_CPU, (self.limit, self.limit + 5))
            # wait4 and not wait: the CPU time of this child alone, whatever else runs
            _, status, usage = os.wait4(process.pid, 0)
            with self.lock:
                process.returncode = os.waitstatus_to_exitcode(status)
                self.running.discard(process)
            out.seek(0)
            err.seek(0)
            return Run(process.returncode, usage.ru_utime, time.monotonic() - clock, out.read(), err.read())

    def run_all(self, commands):
        return list(self.pool.map(self.run, commands))

    def close(self):
        with self.lock:
            self.closed = True
            for process in self.running:
                os.kill(process.pid, 15)
        self.pool.shutdown(cancel_futures=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def table_rows(text):
    """Rows of a TSV table as dictionaries, without the comments."""
    lines = [line.split("\t") for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [dict(zip(lines[0], line)) for line in lines[1:]] if lines else []


def pack_command(command, seed, settings, path, threads=1):
    """The command line of a packing; settings: a list of key=value, of which later ones override earlier ones."""
    options = [word for setting in settings for word in ("--set", setting)]
    return [command, "pack", "-q", "--force", f"--threads={threads}", f"--seed={seed}", *options, "-o", path]


def median(values):
    ordered, n = sorted(values), len(values)
    if n == 0:
        return math.nan
    return ordered[n // 2] if n % 2 else 0.5 * (ordered[n // 2 - 1] + ordered[n // 2])


def machine():
    """One line: processor, cores, system."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as info:
            model = next((line.split(":", 1)[1].strip() for line in info if line.startswith("model name")), model)
    except OSError:
        pass
    return f"{model}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"


def version(command):
    try:
        return subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"{command}: must be a sonopack that runs ({error})")


def write(lines, path):
    """Writes lines to a file, or to stdout without one; a file gets its name only when complete."""
    text = "".join(line + "\n" for line in lines)
    if not path:
        print(text, end="")
        return
    with open(path + ".tmp", "w", encoding="utf-8") as out:
        out.write(text)
    os.replace(path + ".tmp", path)
