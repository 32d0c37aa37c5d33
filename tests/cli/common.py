"""What tests of the command share: faults that are counted, what a message names, and waiting for what happens, not for
a time."""
import pathlib
import re
import signal
import time
import zlib

# three equal grains in a ring that touches no wall
LOOSE = """# packing: three grains
N 3 Lx 4 Ly 5 p 1e-4 mu 0.5 nu 0 contacts 3 bottom 0 top 0 seed 1
1 1 0.5 0
1.998 1 0.5 0
1.499 1.8643 0.5 0
0 1 1 0 0.002 2.98e-05 0
0 2 0.5 0.8660254037844386 0.002 2.98e-05 0
1 2 -0.5 0.8660254037844386 0.002 2.98e-05 0
"""
PATIENCE = 600  # seconds until what never happens is a failure; nothing is measured by it


faults = []  # of tests that go on after the first


def expect(good, what):
    if not good:
        faults.append(what)


def names_all(text, words):
    """Whether a message names all of the words, which blanks separate: keys, options, values, FILE:LINE. Each must stand
    by itself: not "grain" of "grains", nor 5 of 0.5. How a message is put is not asked; of no words, that there is one."""
    text = str(text)
    return text.strip() != "" and all(_named(text, word) for word in str(words).split())


def _named(text, word):
    before = r"(?<!\w)" if re.match(r"\w", word) else ""
    if re.match(r"\d", word):
        before += r"(?<!-)(?<!\d\.)"
    after = r"(?!\w)(?!\.\d)" if re.search(r"\w$", word) else ""
    return re.search(before + re.escape(word) + after, text) is not None


def made_now(text):
    """How many samples a study says that it made: the number after that of all."""
    return int(re.search(r"(\d+) samples\D+(\d+)", text).group(2))


def wait_until(condition, what, every=0.01):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, f"waited {PATIENCE} s for {what}"
        time.sleep(every)


def catches(process):
    """Whether a process stops in its own time when a signal asks for it (before, the signal simply ends it): only then
    does it catch the alarm that ends it if it does not."""
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"SigCgt:\s*(\w+)", status).group(1), 16) >> (signal.SIGALRM - 1) & 1


def worked(process):
    """The seconds of processor time that a process has used: unlike a clock they pass only when it gets on."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100


def wait_for_work(process, seconds):
    """Until a process stops in its own time and has worked for so long since it began."""
    wait_until(lambda: process.poll() is not None or (catches(process) and worked(process) >= seconds),
               f"{seconds} s of work")
    assert process.poll() is None, "it ended before it could be stopped"


def sleeps(process, looks=30):
    """Whether all threads of a process are found asleep every time. One that makes a sample is not: where other
    processes take its core it waits for it, which is told from sleep."""
    for _ in range(looks):
        for path in pathlib.Path(f"/proc/{process.pid}/task").glob("*/stat"):
            if path.read_text().rsplit(")", 1)[1].split()[0] != "S":
                return False
        time.sleep(0.01)
    return True


def packed_zeros(size):
    """The zlib stream of so many zeros (a multiple of a megabyte), without going through them."""
    piece = bytes(2 ** 20)
    pack = zlib.compressobj()
    first = pack.compress(piece) + pack.flush(zlib.Z_FULL_FLUSH)
    again = pack.compress(piece) + pack.flush(zlib.Z_FULL_FLUSH)  # the same each time: a full flush forgets
    end = pack.flush()[:-4] + (size % 65521 << 16 | 1).to_bytes(4, "big")  # Adler's sum of zeros
    return first + again * (size // len(piece) - 1) + end
