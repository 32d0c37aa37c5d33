"""What signals do: every command ends soon and leaves no temporary file; those that have something to keep acknowledge
the signal; what cannot be written is an error.

usage: test_signals_caught.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import resource
import signal
import subprocess

import command
from command import main, sets
from common import PATIENCE, catches, expect, names_all, sleeps, wait_for_work, wait_until, worked
from store_faults import shim

SMALL = sets(grains=60, width=8)
LONG = sets(grains=3000, pressure=1e-8)  # minutes, if nobody stopped it
PLACING = sets(grains=2000000, width=1000)  # half a minute until the first step
# one sample that is packed at once, and whose signal takes ten seconds
SIGNAL = sets('study.want=["signal"]', "signal.until=1.5e6", "signal.method=verlet", grains=300)
SOON = 3  # seconds of CPU time: one, and what a busy machine may add


def defaults():
    """As of a shell: the runner of the tests may ignore what a user does not."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGXFSZ, signal.SIGPIPE):
        signal.signal(number, signal.SIG_DFL)


def start(*words, before=None, **options):
    def prepare():
        defaults()
        if before:
            before()
    return command.start(*words, preexec_fn=prepare, **options)


def run(*words, **options):
    process = start(*words, **options)
    out, err = process.communicate(timeout=PATIENCE)
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def temporaries():
    return [str(path) for path in pathlib.Path().rglob(".sonopack*.tmp")]


def phases_that_do_not_look():
    """A second of work after the signal a process is ended, wherever it is, and has acknowledged the signal before."""
    for name, words, work in (("placing", ["pack", *PLACING, "-o", "placing.h5"], 0.1),
                              ("signal", ["study", *SIGNAL, "--store", "long", "--jobs", 1], 0.5)):
        process = start(*words)
        wait_for_work(process, work)
        before = worked(process)
        process.send_signal(signal.SIGTERM)
        told = process.stderr.readline()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        used = usage.ru_utime + usage.ru_stime - before
        process.stdout.close()
        process.stderr.close()
        expect(process.returncode == 1 and used < SOON, f"{name}: {process.returncode}, {used:.1f} s")
        expect(told.startswith("sonopack: "), f"{name}: no acknowledgement, but {told!r}")
        expect(not temporaries(), f"{name} leaves {temporaries()}")


def waiting_for_a_pipe():
    """The open of a pipe that nobody reads never returns: the signal ends it."""
    pipe = pathlib.Path("pipe.txt")
    os.mkfifo(pipe)
    process = start("pack", *SMALL, "-o", pipe)
    wait_until(lambda: process.poll() is not None or (catches(process) and sleeps(process)),
               "the open of the pipe")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    expect(process.returncode == 1, f"a pipe: {process.returncode}, {out!r}, {err!r}")
    pipe.unlink()


def twice():
    """The second signal ends the process where it is."""
    process = start("pack", *LONG, "--quiet", "-o", "twice.h5")
    wait_for_work(process, 0)
    process.send_signal(signal.SIGSTOP)  # both arrive before it has said anything of the first
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGTERM)
    process.send_signal(signal.SIGCONT)
    _, err = process.communicate(timeout=PATIENCE)
    expect(process.returncode in (-signal.SIGINT, -signal.SIGTERM) and not err, f"twice: {process.returncode} {err!r}")
    expect(not temporaries(), f"twice leaves {temporaries()}")


def in_the_middle_of_a_write():
    """A signal during the write of a result: the old file stays, and no temporary one."""
    library, packing = shim(pathlib.Path().resolve()), "P.h5"
    if not library:
        return "no cc, or a build with sanitizers"
    command.pack(packing, grains=60, width=8)
    for name, words in (("w.h5", ["pack", *SMALL]), ("w.txt", ["pack", *SMALL]), ("w.tsv", ["statics", packing])):
        path = pathlib.Path("writes").resolve() / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("")
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
            # pack, which may have a state to save, goes on after the first signal
            done = run(*words, "--force", "-o", path, env={**os.environ, "LD_PRELOAD": str(library), "FAULTS_CALL": "write",
                                                          "FAULTS_DIR": str(path.parent.resolve()), "FAULTS_AT": "1",
                                                          "FAULTS_DO": "ONCE",
                                                          "FAULTS_ERROR": f"SIGNAL{number.value}"})
            if words[0] != "pack":
                expect(done.returncode == -number and path.read_text() == "", f"{name}, {number!r}: {done}")
            expect(not temporaries(), f"{name}, {number!r} leaves {temporaries()}")
    return None


def storm():
    """A study that is stopped and continued again and again prints the same table; no read or write is cut short."""
    words = ["study", *SMALL, "--set", "study.samples=6", "--quiet", "--jobs", 2, "--store"]
    want, process = run(*words, "calm"), start(*words, "storm")
    while process.poll() is None:
        for number in (signal.SIGWINCH, signal.SIGSTOP, signal.SIGCONT, signal.SIGURG):
            process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    expect(process.returncode == 0 and out == want.stdout and not err, f"a storm of signals: {process.returncode} {err}")


def hang_up():
    """A terminal that goes away stops a compression, unless it was started by nohup."""
    for ignored in (False, True):
        path = f"hangup{ignored}.h5"
        process = start("pack", *LONG, "-o", path,
                        before=(lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)) if ignored else None)
        wait_for_work(process, 0.2)
        process.send_signal(signal.SIGHUP)
        if ignored:
            process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=PATIENCE)
        expect(process.returncode == 1, f"{ignored}: {process.returncode}")
        expect(names_all(err, f"{path}.state") and pathlib.Path(f"{path}.state").exists(), f"hang-up: {err}")


def processor_time():
    """ulimit -t: the state is kept."""
    path = "time.h5"
    done = run("pack", *LONG, "-o", path, before=lambda: resource.setrlimit(resource.RLIMIT_CPU, (1, 20)))
    expect(done.returncode == 1 and names_all(done.stderr, f"{path}.state"), f"SIGXCPU: {done}")


def large_files():
    """ulimit -f: an error like others, nothing is left."""
    packing, place = "P.h5", pathlib.Path("limited")
    place.mkdir()
    for name, words in (("f.h5", ["pack", *SMALL]), ("f.tsv", ["signal", packing]), ("m.h5", ["modes", packing, "--vectors"])):
        path = place / name
        out = [path] if words[-1] == "--vectors" else ["-o", path]
        done = run(*words, *out, before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000)))
        expect(done.returncode == 1 and names_all(done.stderr.splitlines()[-1], name), f"{name}: {done}")
        left = {path.name for path in place.iterdir()}
        expect(left <= {"f.h5.state"}, f"{name} leaves {left}")


def links_to_nothing():
    """Refused before the work: minutes would be lost."""
    path = pathlib.Path("link.h5")
    path.symlink_to(pathlib.Path("nowhere/there.h5"))
    process = start("pack", *LONG, "-o", path)
    _, err = process.communicate(timeout=PATIENCE)
    expect(process.returncode == 1 and names_all(err, path), f"a link to nothing: {err}")


main(phases_that_do_not_look, waiting_for_a_pipe, twice, in_the_middle_of_a_write, storm, hang_up, processor_time, large_files,
     links_to_nothing)
