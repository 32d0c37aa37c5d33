"""What the tests of faulty calls share: short runs of every command, and what may come of one in which a call fails
(faults.c): a failure that is said, or what an undisturbed run gives."""
import collections
import errno
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile

from command import COMMAND
from common import faults
from store_faults import shim

HERE = pathlib.Path(__file__).parent
# kind of calls: (how it fails, errors)
KINDS = {
    "own": [("ONCE", errno.ENOMEM), ("ON", errno.ENOMEM)],
    "foreign": [("ONCE", errno.ENOMEM)],
    "read": [("ONCE", errno.EIO), ("ONCE", errno.EINTR), ("ON", "SHORT"), ("ON", errno.ESTALE)],
    "write": [("ONCE", errno.ENOSPC), ("ONCE", errno.EINTR), ("ON", "SHORT"), ("ON", errno.EDQUOT)],
    "open": [("ONCE", errno.EMFILE), ("ON", errno.ENFILE), ("ONCE", errno.ESTALE)],
    "close": [("ONCE", errno.EIO), ("ON", errno.EDQUOT)],
    "stat": [("ONCE", errno.ESTALE), ("ON", errno.EIO)],
    "sync": [("ONCE", errno.EIO), ("ON", errno.EDQUOT)],
    "rename": [("ONCE", errno.EIO), ("ON", errno.EROFS), ("ONCE", "DONE")],
    "lock": [("ONCE", errno.ENOLCK), ("ON", errno.EIO)],
    "truncate": [("ONCE", errno.EIO), ("ON", errno.ENOSPC)],
    "unlink": [("ONCE", errno.EIO), ("ON", errno.EROFS)],
    "mkdir": [("ONCE", errno.EDQUOT)],
    "list": [("ONCE", errno.EMFILE), ("ON", errno.EIO)],
    "thread": [("ONCE", errno.EAGAIN), ("ON", errno.EAGAIN)],
    "clock": [("ONCE", "BACK"), ("ON", "BACK"), ("ONCE", "AHEAD"), ("ON", "AHEAD")],
    "locale": [("ONCE", errno.ENOMEM), ("ON", errno.ENOMEM)],
    "load": [("ONCE", errno.ENOENT)],
    "stdio": [("ONCE", errno.EIO), ("ON", errno.ENOSPC)],
}
SCENE = """packing = { protocol = "quick"; grains = 30; width = 6; pressure = 1e-3; seed = 3; };
study = { samples = 2; want = ["ctof", "statics", "moduli", "signal", "spectrum"]; };
signal = { until = 40.0; points = 41; };
"""
COLUMN = """column = { particles = 2; stiffness = 1e5; e = 0.3; taps = 1; step = 0.05; };
"""
# name: arguments, with {in} for the folder of inputs; what begins with @ is copied to the working folder first
PLAIN = {
    "pack": "pack {in}/scene.cfg -o out.h5",
    "pack-text": "pack {in}/scene.cfg -o out.txt",
    "pack-chain": "pack {in}/chain.cfg -o out.h5",
    "pack-spheres": "pack {in}/scene.cfg --set packing.dimension=3 --set packing.width=5 -o out.h5",
    "pack-file": "pack --set packing.kind=file --set packing.file={in}/P.h5 --set packing.protocol=quick "
                 "--set packing.pressure=2e-3 -o out.h5",
    "pack-state": "pack {in}/scene.cfg -o out.h5 --state-every=0.0001",
    "pack-threads": "pack {in}/scene.cfg -o out.h5 --threads=3",
    "check": "check {in}/P.h5 {in}/P.txt",
    "statics": "statics {in}/P.h5 --margin 1 -o out.json",
    "statics-tall": "statics {in}/tall.h5 --margin 1",
    "moduli": "moduli {in}/P.h5 --margin 1 -o out.tsv",
    "moduli-probe": "moduli {in}/P.h5 --probe sine:1 --probe lines:1 --margin 1",
    "moduli-local": "moduli {in}/P.h5 --probe local:2 --margin 1",
    "moduli-strain": "moduli {in}/P.h5 --strain 1e-6 --margin 1",
    "modes": "modes {in}/P.h5",
    "modes-lowest": "modes {in}/P.h5 --lowest 3 -o out.csv",
    "modes-vectors": "modes {in}/P.h5 --lowest 3 --vectors out.h5 -o out.tsv",
    "modes-damped": "modes {in}/C.h5 --damping 0.1",
    "spectrum-dos": "spectrum dos {in}/P.h5 -o out.tsv",
    "spectrum-transmission": "spectrum transmission {in}/P.h5",
    "spectrum-dispersion": "spectrum dispersion {in}/P.h5 --waves 2",
    "spectrum-harmonic": "spectrum harmonic {in}/P.h5 --at 0.1:0.3:2",
    "spectrum-participation": "spectrum participation {in}/P.h5",
    "spectrum-continuum": "spectrum continuum {in}/big.txt",
    **{f"signal-{method}": f"signal {{in}}/P.h5 --until 10 --points 11 --method {method} --tolerance {tolerance}"
       for method, tolerance in (("auto", 1e-8), ("chebyshev", 1e-8), ("dense", 1e-8), ("sparse", 1e-8),
                                 ("verlet", 1e-3), ("lax-wendroff", 1e-3), ("faber", 1e-6))},
    "signal-dynamics": "signal {in}/P.h5 --until 10 --points 11 --method dynamics -o out.tsv",
    "signal-damped": "signal {in}/P.h5 --until 10 --points 11 --damping 0.1",
    "signal-threads": "signal {in}/big.txt --until 10 --points 11 --detector plane:5 --detector plane:8 --threads 3",
    "front": "front {in}/P.h5 --window 30",
    "front-trace": "front {in}/F.tsv -o out.tsv",
    "wave": "wave {in}/tall.h5 --low 1 --spacing 0.5 --at 0.2:0.4:2",
    "transport": "transport {in}/P.h5 --at 0.2:0.4:2 --sources 2 --until 20",
    "transport-kubo": "transport {in}/P.h5 --quantity kubo --at 0.2:0.4:2 -o out.tsv",
    "transport-split": "transport {in}/P.h5 --quantity split --at 0.2:0.4:2 --sources 2",
    "transport-energy": "transport {in}/P.h5 --quantity energy --at 0.2:0.4:2",
    "transport-coherent": "transport {in}/tall.h5 --quantity coherent --low 1 --spacing 0.5 --at 0.2:0.4:2",
    "amplitude": "amplitude {in}/P.h5 --amplitudes 0.01,0.1 -o out.tsv",
    "amplitude-burst": "amplitude {in}/tall.h5 --amplitudes 0.01 --omega 0.7 --cycles 3",
    "chain-front": "chain front --grains 8:32:2 -o out.tsv",
    "chain-signal": "chain signal --grains 20 --start 10 --until 30 --points 11",
    "chain-modes": "chain modes --grains 8",
    "chain-soliton": "chain soliton",
    "chain-localisation": "chain localisation --at 1 --grains 1000",
    "respond": "respond {in}/P.h5 --strain yy -o out.tsv",
    "clusters": "clusters {in}/P.h5 -o out.tsv",
    "clusters-motions": "clusters {in}/P.h5 --method motions --grains",
    "sensitivity": "sensitivity {in}/P.h5 -o out.tsv",
    "sensitivity-by": "sensitivity {in}/P.h5 --by mass,radius,position --of omega:20",
    "sensitivity-moduli": "sensitivity {in}/P.h5 --of C22 --margin 1",
    "uncertainty": "uncertainty {in}/P.h5 --radius 1e-4 --missing 0.01 --margin 1 --samples 10 -o out.tsv",
    "coda": "coda {in}/C.h5 --grain 3 --window 20:60 --points 40 -o out.tsv",
    "coda-trials": "coda {in}/C.h5 --trials 2 --window 20:60 --points 40",
    "design": "design {in}/C.h5 --iterations 2 --goal delay -o out.tsv --packing out.h5",
    "design-band": "design {in}/C.h5 --iterations 1 --goal band:0.3:0.4",
    "column": "column {in}/column.cfg -o out.tsv",
    "column-bsr": "column --set column.model=bsr --set column.taps=1 --set column.particles=2",
    "column-bifurcation": "column {in}/column.cfg --set column.particles=1 --set column.output=bifurcation "
                          "--set column.parameter=period --set column.from=0.1 --set column.to=0.3 "
                          "--set column.points=2 --set column.taps=2 --set column.transient=2",
    "completion": "completion bash -o out.bash",
    "help": "help scene",
    "help-key": "help friction",
    "version": "--version",
    "table": "table ensemble --store {in}/store",
    "table-ctof": "table ctof --store {in}/store -o out.json",
    "table-signal": "table signal --store {in}/store",
    "table-spectrum": "table spectrum --store {in}/store --bins 4",
    "study": "study {in}/study.cfg --store store --jobs 1",
    "study-jobs": "study {in}/study.cfg --store store --jobs 2",
    "study-again": "study {in}/study.cfg --store @store --jobs 1 -o out.tsv",
    "study-more": "study {in}/study.cfg --store @store --jobs 1 --set study.samples=3",
    "study-verify": "study --verify --store @store",
}
# Their numbers are times: what they print is compared without digits.
TIMED = {"pack-dry-run": "pack {in}/scene.cfg -o out.h5 --dry-run",
         "study-dry-run": "study {in}/study.cfg --store store --dry-run"}
COMMANDS = {**PLAIN, **TIMED}
INPUTS = [
    "pack {in}/scene.cfg -o {in}/P.h5", "pack {in}/chain.cfg -o {in}/C.h5", "pack {in}/scene.cfg -o {in}/P.txt",
    "pack {in}/scene.cfg --set packing.grains=90 -o {in}/tall.h5",
    "signal {in}/P.h5 --until 60 --points 121 -o {in}/F.tsv", "study {in}/study.cfg --store {in}/store --jobs 1",
]
CPU = 20  # seconds until a run counts as one that hangs


def made_inputs(folder, source):
    folder.mkdir()
    (folder / "scene.cfg").write_text(SCENE[:SCENE.index("\n")])
    (folder / "study.cfg").write_text(SCENE)
    (folder / "column.cfg").write_text(COLUMN)
    (folder / "chain.cfg").write_text('packing = { kind = "chain"; friction = 0; grains = 8; };\n')
    shutil.copy(source / "packings/reference/packing_N200_p1e-4.txt", folder / "big.txt")
    for line in INPUTS:
        subprocess.run([COMMAND, *line.replace("{in}", str(folder)).split()], check=True, capture_output=True)


def hdf5_within(command):
    """From where to where the command's code is HDF5's, which calls the C library on its own account."""
    lines = [line.split() for line in subprocess.run(["nm", command], text=True, capture_output=True).stdout.splitlines()]
    code = sorted((int(words[0], 16), words[2]) for words in lines if len(words) == 3 and words[1] in "tT")
    theirs = [k for k, (_, name) in enumerate(code) if name.startswith("H5") and "." not in name]
    return f"{code[theirs[0]][0]} {code[theirs[-1] + 1][0]}" if theirs else "0 0"


def content(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def identities(folder):
    return {path: (path.stat().st_ino, path.stat().st_size, path.stat().st_mtime_ns) for path in folder.rglob("*")}


Outcome = collections.namedtuple("Outcome", "status out err files calls")
# of no sample: the index of a store and its locks
BESIDE = re.compile(r"(.*/)?(manifest\.tsv|\.sonopack-lock)$")


class Faulty:
    """Runs commands in which calls fail, and judges what came of it."""

    def __init__(self, preload, inputs, work):
        self.preload, self.inputs, self.work = preload, inputs, work
        self.within = hdf5_within(COMMAND)
        self.reference = {}
        self.before = identities(inputs)

    def run(self, name, kind="", how="ONCE", error=0, at=0):
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir()
        line = COMMANDS[name].replace("{in}", str(self.inputs))
        if "@store" in line:
            shutil.copytree(self.inputs / "store", self.work / "store")
        count = self.work.parent / "count"
        environment = {**os.environ, "LC_ALL": "C", "LD_PRELOAD": str(self.preload), "FAULTS_CALL": kind,
                       "FAULTS_DO": how, "FAULTS_ERROR": str(error), "FAULTS_AT": str(at), "FAULTS_COUNT": str(count),
                       "FAULTS_WITHIN": self.within}
        count.unlink(missing_ok=True)
        words = line.replace("@store", "store").split()
        if "--threads" not in line and words[0] not in ("help", "--version"):
            words.append("--threads=1")
        process = subprocess.Popen([COMMAND, *words], cwd=self.work, env=environment, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        resource.prlimit(process.pid, resource.RLIMIT_CPU, (CPU, CPU))
        out, err = process.communicate(timeout=1200)
        calls = dict(line.split() for line in count.read_text().splitlines()) if count.exists() else {}
        return Outcome(process.returncode, self.plain(name, out), err.decode(errors="replace"),
                       {path: self.plain(name, data) for path, data in content(self.work).items()
                        if not BESIDE.match(path)}, calls)

    def plain(self, name, data):
        """What is printed and written, without the times."""
        if name in TIMED:
            return re.sub(rb"[-+.\d]+(e[-+]?\d+)?|nan|yes|no", b"", data)
        if name.startswith("pack"):  # the last column: seconds
            data = re.sub(rb"[^\t\n]+(?=\n)", b"", data) if b"seconds" in data else data
        return data

    def count(self, name, kind):
        """The calls of an undisturbed run, whose results are kept."""
        if name not in self.reference:
            self.reference[name] = self.run(name)
        done = self.reference[name]
        assert done.status == 0 and done.calls, (name, done.status, done.err)
        return int(done.calls[kind])

    def judge(self, name, kind, how, error, at):
        """(outcome, fault): what a run ended with, and what is wrong with that, or None."""
        done, good = self.run(name, kind, how, error, at), self.reference[name]
        left = [path for path in done.files if ".tmp" in path and path not in good.files]
        changed = identities(self.inputs) != self.before
        wrong = [path for path in done.files if path not in left and done.files[path] != good.files.get(path)
                 and not path.endswith(".state.h5")]
        if changed:
            return "inputs", "inputs have changed"
        if kind == "foreign" and (done.status < 0 or done.status == 255) and not wrong:
            return "ended by a library", None  # HDF5 and libconfig do not stand every lack of memory
        if done.status < 0:
            return signal.Signals(-done.status).name, f"ended by signal {-done.status}: {done.err[-200:]}"
        if left and kind not in ("unlink",):
            return "left", f"left {left}: {done.err[-200:]}"
        if wrong:
            return "wrong", f"status {done.status}, wrong files {wrong}: {done.err[-200:]}"
        if done.status == 0:
            missing = [path for path in good.files if path not in done.files]
            if done.out != good.out or missing:
                return "lost", f"status 0 with other output, or without {missing}: {done.err[-200:]}"
            return "as before", None
        said = [line for line in done.err.splitlines() if "warning" not in line]
        if done.status not in (1, 2) or not said:
            return f"status {done.status}", f"status {done.status}, said: {done.err[-200:]!r}"
        if kind != "foreign" and not (said[-1].startswith("sonopack: ")):
            return "unclear", f"said: {done.err[-300:]!r}"
        if name not in ("check", "study-verify") and not good.out.startswith(done.out):  # they go on with the next
            return "printed", f"status {done.status} after it printed something else"
        return "refused", None


def try_all(test):
    """Runs test(Faulty) in a new folder, and ends with what it found: exit status 0, 1, or 77 where it cannot run."""
    with tempfile.TemporaryDirectory(prefix="sonopack-faulty-") as folder:
        root = pathlib.Path(folder)
        preload = shim(root)
        if not preload:
            print("no cc, or a build with sanitizers")
            sys.exit(77)
        made_inputs(root / "in", pathlib.Path(sys.argv[2]))
        test(Faulty(preload, root / "in", root / "work"))
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)
