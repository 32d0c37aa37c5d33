"""pack --engine lammps with LAMMPS itself: packings in two and three dimensions, with and without friction, of several
sizes, on one rank and on two, at once and by hand. Each passes the audit. `python3 test_pack_lammps.py COMMAND
SOURCE_DIR`; 77 without lmp."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

COMMAND = sys.argv[1]
if not shutil.which("lmp"):
    print("no lmp: skipped")
    sys.exit(77)
folder = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-engine-"))
env = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
           OMPI_MCA_rmaps_base_oversubscribe="1", OMP_NUM_THREADS="1")


def run(*words, cwd=folder):
    result = subprocess.run(words, capture_output=True, text=True, cwd=cwd, env=env)
    assert result.returncode == 0, f"{words}: {result.stdout[-1000:]} {result.stderr}"
    return result.stdout


def values(text):
    rows = [line.split("\t") for line in text.split("\n") if line and not line.startswith("#")]
    return dict(zip(rows[0], rows[1]))


def check(name, **wanted):
    audit = values(run(COMMAND, "check", name))
    assert audit["ok"] == "yes", audit
    text = run(COMMAND, "convert", name, name.replace(".h5", ".txt"), "--force") + (folder / name.replace(".h5", ".txt")).read_text()
    head = text.split("\n")[1].split()
    for key, value in wanted.items():
        assert float(head[head.index(key) + 1]) == value, (key, head)


SMALL = ["--set", "packing.grains=40", "--set", "packing.width=6", "--engine", "lammps"]
run(COMMAND, "pack", *SMALL, "--seed", "3", "-o", "a.h5")
check("a.h5", N=40, Lx=6, p=1e-4, mu=0.5, seed=3)
assert not (folder / "a.h5.lammps").exists()
assert b"engine: LAMMPS (" in (folder / "a.h5").read_bytes()

# by hand it is the same run
run(COMMAND, "pack", *SMALL, "--seed", "3", "--prepare", "d")
run("lmp", "-nocite", "-in", "in.pack", cwd=folder / "d")
run(COMMAND, "pack", "--engine", "lammps", "--collect", "d", "-o", "b.h5")
one, two = (values(run(COMMAND, "statics", name)) for name in ("a.h5", "b.h5"))
assert {k: v for k, v in one.items() if k != "file"} == {k: v for k, v in two.items() if k != "file"}, (one, two)
assert (folder / "d" / "grains.dump").exists()
# forces between grains are kept: the packing of positions alone has none
assert float(values(run(COMMAND, "statics", "a.h5"))["zs"]) < 3.9

run(COMMAND, "pack", *SMALL, "--set", "packing.friction=0", "-o", "smooth.h5")
check("smooth.h5", mu=0)
run(COMMAND, "pack", *SMALL, "--set", "packing.sizes=bidisperse", "--set", "packing.diameter_min=0.8", "--set",
    "packing.diameter_max=1.2", "--set", "packing.poisson=0.3", "--set", "packing.protocol=quick", "-o", "two.h5")
check("two.h5", nu=0.3)
run(COMMAND, "pack", "--set", "packing.dimension=3", "--set", "packing.grains=60", "--set", "packing.width=5",
    "--engine", "lammps", "-o", "spheres.h5")
assert values(run(COMMAND, "check", "spheres.h5"))["ok"] == "yes"
if shutil.which("mpirun"):
    run(COMMAND, "pack", *SMALL, "--ranks", "2", "-o", "ranks.h5")
    check("ranks.h5", N=40)
    assert b", 2 ranks" in (folder / "ranks.h5").read_bytes()
shutil.rmtree(folder)
print("ok")
