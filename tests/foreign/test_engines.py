"""modes --engine slepc, moduli and signal --engine petsc on one rank, two and four: the table of the command alone, within both
bounds, in two and three dimensions, with and without friction, in every cell; and what is refused.
`python3 test_engines.py COMMAND SOURCE_DIR`; 77 without slepc4py, petsc4py, h5py or mpirun."""
import glob
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

COMMAND = sys.argv[1]
if not (glob.glob("/usr/lib/slepcdir/slepc*/*-real/lib/python3/dist-packages/slepc4py") and shutil.which("mpirun") and
        glob.glob("/usr/lib/petscdir/petsc*/*-real/lib/python3/dist-packages/petsc4py") and
        os.path.exists(os.path.join(os.path.dirname(COMMAND), "sonopack-modes-slepc"))):
    print("no slepc4py and petsc4py (Debian: python3-slepc4py-real), no mpirun, or no Python package: skipped")
    sys.exit(77)
folder = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-engines-"))
env = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
           OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none", OMP_NUM_THREADS="1",
           OPENBLAS_NUM_THREADS="1")


def run(*words, status=0, ranks=0):
    launcher = ["mpirun", "-n", str(ranks)] if ranks else []
    result = subprocess.run([*launcher, COMMAND, *words], capture_output=True, text=True, cwd=folder, env=env)
    assert result.returncode == status, f"{ranks} {words}: {result.returncode} {result.stdout[-500:]} {result.stderr}"
    return result


def table(text):
    """Comments `key = value`, and the columns."""
    lines = text.splitlines()
    told = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    return told, {name: [float(row[k]) for row in rows[1:]] for k, name in enumerate(rows[0]) if name != "file"}


def same(one, two, bound_one, bound_two):
    assert len(one) == len(two) > 0, (len(one), len(two))
    for a, b, s, t in zip(one, two, bound_one, bound_two):
        assert abs(a - b) <= s + t, (a, b, s, t)


def modes(packing, words, ranks):
    told, own = table(run("modes", packing, *words, "--threads", "1").stdout)
    found, theirs = table(run("modes", packing, *words, "--engine", "slepc", ranks=ranks).stdout)
    assert own["n"] == theirs["n"] and list(own) == list(theirs), (own["n"][:3], theirs["n"][:3])
    same(own["omega"], theirs["omega"], own["error"], theirs["error"])
    assert max(theirs["error"]) < 1e-12, max(theirs["error"])
    for key in ("dimension", "carrying", "zero_modes", "rattler_modes", "free_spins", "rigid_motions", "mechanisms"):
        assert told[key] == found[key], (key, told[key], found[key])
    for name in {"ab", "participation"} & set(own):  # of no degenerate modes, whose vectors have rounding over the gap
        size = max(map(abs, own[name])) or 1
        assert all(abs(a - b) < 1e-8 * size or a != a for a, b in zip(own[name], theirs[name])), (name, packing)


def signals(packing, words, ranks):
    told, own = table(run("signal", packing, *words).stdout)
    found, theirs = table(run("signal", packing, *words, "--engine", "petsc", ranks=ranks).stdout)
    same(own["t"], theirs["t"], *[[1e-13 * own["t"][-1]] * len(own["t"])] * 2)
    assert told["F"].split(", error")[0] == found["F"].split(", error")[0], (told, found)
    bounds = [[float(of["error"])] * len(own["t"]) for of in (told, found)]
    same(own["F"], theirs["F"], *bounds)
    assert float(found["error"]) <= 1e-10 * max(map(abs, own["F"])), found["error"]


def moduli(packing, words, ranks):
    _, own = table(run("moduli", packing, *words).stdout)
    _, theirs = table(run("moduli", packing, *words, "--engine", "petsc", ranks=ranks).stdout)
    assert list(own) == list(theirs), (list(own), list(theirs))
    for name in own:
        (a,), (b,) = own[name], theirs[name]
        if name.endswith("err"):  # of the same estimate, with other residuals
            assert 0 < b < 3 * a + 1e-13, (packing, name, a, b)
        else:
            assert abs(a - b) < 1e-12 * (1 + abs(a)) or a != a and b != b, (packing, name, a, b)


def pack(name, *settings):
    run("pack", *(word for setting in settings for word in ("--set", "packing." + setting)), "-o", name, "-q")
    return name


QUICK = ("protocol=quick", "pressure=1e-3")
CELLS = [(f"{cell}{dim}{friction}.h5", cell, dim, friction) for cell in ("piston", "periodic", "box") for dim in (2, 3)
         for friction in (0.5, 0)]
PLANES = ["--from", "plane:1", "--detector", "plane:3", "--until", "30"]
for number, (name, cell, dim, friction) in enumerate(CELLS):
    width = {"piston": 8 if dim == 2 else 5}.get(cell, 24)
    pack(name, *QUICK, f"grains={60 if dim == 2 else 150}", f"cell={cell}", f"dimension={dim}", f"friction={friction}",
         f"width={width}")
    ranks = 1 + number % 2
    modes(name, ["--lowest", "7"], ranks)
    signals(name, PLANES if cell == "periodic" else [], 3 - ranks)
    moduli(name, [], 3 - ranks)
modes("piston20.5.h5", ["--band", "0.2:0.5", "--source", "displacement"], 4)
modes("piston30.5.h5", ["--lowest", "250", "--frequencies-only"], 2)  # more than one slice has
signals("piston20.5.h5", ["--source", "displacement", "--points", "50"], 4)
signals("box30.5.h5", ["--source", "velocity", *PLANES], 2)
modes("piston20.5.h5", ["--lowest", "7", "--threshold", "0.2"], 2)  # more rattlers
signals("piston20.5.h5", ["--set", "network.threshold=0.2", "--points", "30"], 2)
moduli("piston20.5.h5", ["--threshold", "0.5", "--margin", "2"], 4)  # almost floppy
moduli("box30.5.h5", ["--margin", "0.5"], 2)
pack("smooth.h5", "grains=300", "width=10", "friction=0")
moduli("smooth.h5", [], 2)  # moves sideways as a whole
moduli("piston30.5.h5", ["--margin", "9"], 2)  # no bulk: no speeds


# rank 0 writes one file, in SI too; there are no leftovers
run("modes", "piston20.5.h5", "--engine", "slepc", "--lowest", "3", "--material", "E=70e9,nu=0.22,rho=2500,d=1e-3",
    "--units", "si", "-o", "m.tsv", ranks=2)
assert "omega [rad/s]" in (folder / "m.tsv").read_text()
run("modes", "piston20.5.h5", "--engine", "slepc", "--lowest", "3", "-o", "m.tsv", "--force", ranks=1)
text = (folder / "m.tsv").read_text()
run("modes", "piston20.5.h5", "--engine", "slepc", "--lowest", "3", "-o", "m.tsv", "--force", ranks=1)
assert (folder / "m.tsv").read_text() == text  # the same bytes
assert not [name for name in os.listdir(folder) if name.startswith(".")], os.listdir(folder)

# refused, once and with the reason: usage (2), and what the packing does not have (1)
for words, status, reason in (
        (["modes", "piston20.5.h5", "--engine", "slepc"], 2, "needs --lowest K or --band LO:HI"),
        (["modes", "piston20.5.h5", "--engine", "slepc", "--lowest", "3", "--prestress"], 2, "prestress"),
        (["modes", "piston20.5.h5", "--engine", "slepc", "--lowest", "3", "--zero"], 2, "--zero"),
        (["modes", "piston20.5.h5", "--engine", "slepc", "--lowest", "3", "-o", "m.tsv"], 2, "exists already"),
        (["modes", "m.tsv", "--engine", "slepc", "--lowest", "3"], 1, "m.tsv"),
        (["moduli", "piston20.5.h5", "--engine", "petsc", "--probe", "sine:1"], 2, "not --probe"),
        (["moduli", "piston20.5.h5", "piston30.5.h5", "--engine", "petsc"], 2, "there are 2"),
        (["moduli", "nowhere.h5", "--engine", "petsc"], 1, "cannot read nowhere.h5"),
        (["moduli", "piston20.5.h5", "--engine", "petsc", "--threshold", "1"], 1, "is floppy"),
        (["signal", "piston20.5.h5", "--engine", "petsc", "--damping", "0.1"], 2, "--damping"),
        (["signal", "piston20.5.h5", "--engine", "petsc", "--set", "signal.method=verlet"], 2, "chebyshev"),
        (["signal", "box20.5.h5", "--engine", "petsc", "--from", "plane:1", "--from", "plane:2"], 2, "and one"),
        (["signal", "box20.5.h5", "--engine", "petsc", "--detector", "grain:3"], 2, "top or plane:Y"),
        (["signal", "periodic20.5.h5", "--engine", "petsc"], 1, "has no bottom wall"),
        (["signal", "piston20.5.h5", "--engine", "petsc", "--tolerance", "1e-15"], 1, "above the tolerance")):
    said = [line for line in run(*words, status=status, ranks=2).stderr.splitlines() if line.startswith("sonopack: ")]
    assert len(said) == 1 and reason in said[0], (words, said)

# Ctrl-C ends all ranks
pack("more.h5", "grains=2000", "width=40", "protocol=quick", "pressure=1e-3")
job = subprocess.Popen(["mpirun", "-n", "2", COMMAND, "modes", "more.h5", "--engine", "slepc", "--lowest", "3000", "-o",
                        "never.tsv"], cwd=folder, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
time.sleep(3)
job.send_signal(signal.SIGINT)
job.communicate(timeout=30)
assert job.returncode != 0 and not (folder / "never.tsv").exists()
shutil.rmtree(folder)
print("ok")
