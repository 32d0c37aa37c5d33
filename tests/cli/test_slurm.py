"""packings/slurm.sh with stand-ins for the command and for Slurm's scontrol: the share of each task of an array, what a
signal does, and which tasks are queued again. Shares, kills and stops of the command itself are in test_store_share.py.

usage: test_slurm.py COMMAND SOURCE_DIR
"""
import contextlib
import os
import pathlib
import signal
import subprocess

from command import SOURCE, main
from common import PATIENCE, wait_until

SCRIPT = SOURCE / "packings/slurm.sh"
# writes its words; told to, it waits until a signal comes, and ends with its status
SONOPACK = """#!/bin/bash
printf '%s ' "$@" >words.new && mv words.new words
[ "$WAITS" ] || exit "$STATUS"
trap 'kill $!; exit 143' TERM
sleep infinity &
touch begun
wait
"""


def task(waits="", status=0, **slurm):
    for name in ("words", "begun", "requeued"):
        pathlib.Path(name).unlink(missing_ok=True)
    for name, text in (("sonopack", SONOPACK), ("scontrol", '#!/bin/bash\necho "$*" >requeued\n')):
        pathlib.Path(name).write_text(text)
        pathlib.Path(name).chmod(0o755)
    names = {f"SLURM_{name.upper()}": str(value) for name, value in slurm.items()}
    return subprocess.Popen(["bash", SCRIPT, "my.cfg", "store"], stdout=subprocess.DEVNULL, start_new_session=True, env={
        **os.environ, **names, "SONOPACK": "./sonopack", "PATH": f".:{os.environ['PATH']}", "WAITS": waits,
        "STATUS": str(status)})


def in_array(first, last, count, step, tasks):
    """The shares of the tasks of an array."""
    for id in tasks:
        process = task(array_task_id=id, array_task_min=first, array_task_max=last, array_task_count=count,
                       array_task_step=step, cpus_per_task=3)
        assert process.wait(PATIENCE) == 0
        words = pathlib.Path("words").read_text().split()
        assert words[:4] == ["study", "my.cfg", "--store", "store"] and words[-3:] == ["--jobs", "3", "-v"], words
        yield " ".join(words[4:-3])


def shares():
    quarters = [f"--shard {k}/4" for k in (1, 2, 3, 4)]
    assert [*in_array(1, 4, 4, 1, (1, 2, 3, 4))] == [*in_array(0, 6, 4, 2, (0, 2, 4, 6))] == quarters
    assert {*in_array(2, 7, 3, 1, (2, 3, 7)), *in_array(5, 5, 1, 1, (5,))} == {""}  # with holes, and a task alone
    assert task(status=3).wait(PATIENCE) == 3
    assert subprocess.run(["bash", SCRIPT, "my.cfg"], capture_output=True).returncode == 2


def signals():
    """Near its end a task is queued again, at most 50 times; one that is cancelled is not."""
    job = {"array_job_id": 12, "array_task_id": 3}
    for number, slurm, requeued in ((signal.SIGUSR1, job, "requeue 12_3"), (signal.SIGUSR1, {"job_id": 7}, "requeue 7"),
                                    (signal.SIGUSR1, {**job, "restart_count": 50}, None), (signal.SIGTERM, job, None)):
        process = task(waits="yes", **slurm)
        wait_until(pathlib.Path("begun").exists, "the study")
        process.send_signal(number)
        process.wait(PATIENCE)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # what is left, if the script did not end it
        found = pathlib.Path("requeued").read_text().strip() if pathlib.Path("requeued").exists() else None
        assert process.returncode == 143 and found == requeued, (number, slurm, process.returncode, found)


main(shares, signals)
