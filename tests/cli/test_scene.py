"""Scene files as users and outside checks write them, right and wrong, through the command.

usage: test_scene.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from common import expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
SMALL = ["--set", "packing.grains=20", "--set", "packing.width=6"]
KEYS = """packing.kind packing.cell packing.file packing.content packing.dimension packing.grains packing.width packing.depth
    packing.height packing.pressure packing.stress packing.gravity packing.history packing.friction packing.tangential packing.poisson packing.sizes packing.diameter_min
    packing.diameter_max packing.large_fraction packing.size_spread packing.diameters packing.diameter_file
    packing.compression packing.protocol packing.reference packing.seed packing.tolerance packing.damping
    packing.piston_mass packing.gas_fraction packing.time_step packing.calm packing.drag packing.calm_damping
    packing.viscous_limit packing.max_steps material.E material.nu material.rho material.d network.threshold network.prestress network.sliding_free network.tangential
    signal.method signal.source signal.until signal.points signal.tolerance signal.planes study.samples
    study.want study.sweep column.particles column.frequency column.period column.taps column.amplitude column.e
    column.stiffness column.gravity column.drop column.mass column.radius column.model column.method column.bsr
    column.output column.step column.alpha_v column.alpha_x column.time_step column.tolerance column.cells
    column.parameter column.from column.to column.points column.transient""".split()
WRONG = [  # a scene, and what its reason must say
    ("packing = {\n  pressure = 10;\n};", "SCENE:2 packing.pressure 10 1e-10 0.01"),
    ("packing = { pressure = 1e-12; };", "packing.pressure 1e-12"),
    ("packing = { pressure = -1e-4; };", "packing.pressure"),
    ("packing = { pressure = 0; };", "packing.pressure"),
    ("packing = { pressure = 1e999; };", "packing.pressure inf"),
    ("packing = { pressure = nan; };", "SCENE:1"),
    ("packing = { grains = 0; };", "packing.grains 0"),
    ("packing = { grains = -5; };", "packing.grains -5"),
    ("packing = { grains = 1.5; };", "packing.grains 1.5"),
    ("packing = { grains = \"many\"; };", "packing.grains many"),
    ("packing = { width = 2; };", "SCENE:1 packing.width 2"),
    ("packing = { cell = \"torus\"; };", "packing.cell piston periodic box"),
    ("packing = { cell = \"periodic\"; stress = [1e-4, 1e-4, 2e-4]; };", "packing.stress"),
    ("packing = { cell = \"periodic\"; grains = 20; };", "packing.grains 20"),
    ("packing = { stress = [1e-4, 1e-4, 0.0]; };", "packing.stress piston"),
    ("packing = { cell = \"box\"; gravity = 1e-5; };", "packing.gravity box"),
    ("packing = { kind = \"box\"; };", "piston triangular chain"),
    ("packing = { kind = \"chain\"; dimension = 2; };", "packing.dimension 2"),
    ("packing = { poisson = 0.6; };", "packing.poisson 0.6"),
    ("packing = { friction = -0.1; };", "packing.friction -0.1"),
    ("packing = { time_step = 4.01; };", "packing.time_step 4.01"),
    ("packing = { seed = 3; seed = 4; };", "SCENE:1"),
    ("packing = {\n\n presure = 1e-4; };", "SCENE:3 packing.presure packing.pressure"),
    ("paking = { pressure = 1e-4; };", "packing"),
    ("network = { threshold = 2; };", "network.threshold 2"),
    ("signal = { source = \"shout\"; };", "impulse velocity displacement"),
    ("study = { want = [\"everything\"]; };", "everything"),
    ("study = { sweep = ( { key = \"packing.pressure\"; values = [1e-4, 1]; } ); };", "packing.pressure 1"),
    ("study = { samples = 10000000; sweep = ( { key = \"packing.grains\"; values = [200, 600]; } ); };", "study.samples"),
    ("@include \"/etc/hostname\"", "SCENE:1 @include"),
    ("packing = { /* no end", "SCENE:1"),
    ("packing = { kind = \"piston", "SCENE:1"),
    ("packing = { grains = 200;", "SCENE"),
    ("", "SCENE"),
    ("a" * 100000, "SCENE:1"),
    ("a = " + "(" * 100000, "SCENE"),
    ("packing\0", "SCENE"),
]


def pack(*arguments):
    return subprocess.run([COMMAND, "pack", *map(str, arguments)], text=True, capture_output=True,
                          stdin=subprocess.DEVNULL, timeout=1200)


def expect_refused(reason, *arguments):
    output = pathlib.Path("never.txt")
    result = pack(*arguments, "-o", output)
    expect(result.returncode == 2, f"{arguments}: exit status {result.returncode}, expected 2: {result.stderr}")
    line = result.stderr.rstrip("\n")
    expect(line.startswith("sonopack: ") and names_all(line, reason), f"{arguments}: {line[:300]!r} does not say {reason!r}")
    expect("\n" not in line and len(line) < 1100, f"{arguments}: more than one line: {line[:300]!r}")
    expect(not output.exists() and not result.stdout, f"{arguments}: something was made of a wrong scene")


def summary(*arguments):
    result = pack(*arguments)
    if result.returncode:
        faults.append(f"{arguments}: {result.stderr}")
        return {}
    head, row = [line.split("\t") for line in result.stdout.splitlines() if not line.startswith("#")]
    return dict(zip(head, row, strict=True))


def check_help():
    text = subprocess.run([COMMAND, "help", "scene"], text=True, capture_output=True, check=True).stdout
    described = re.findall(r"^(\w+\.\w+) = (.+)\n    .+", text, re.M)
    expect([key for key, _ in described] == KEYS, f"keys: {[key for key, _ in described]}")
    # what help shows as defaults is a scene file, up to the group brackets, and gives the default packing
    groups = {}
    for key, value in described:
        groups.setdefault(key.split(".")[0], []).append(f"{key.split('.')[1]} = {value};")
    scene = "\n".join(f"{group} = {{ {' '.join(lines)} }};" for group, lines in groups.items())
    pathlib.Path("defaults.cfg").write_text(scene)
    first = summary("defaults.cfg", *SMALL, "-o", "first.txt")
    second = summary(*SMALL, "-o", "second.txt")
    expect(first.get("height") == second.get("height") and first, "the defaults of help scene are not the defaults")


def check_examples():
    scenes = sorted((SOURCE / "packings").glob("*.cfg"))
    expect(len(scenes) >= 3, f"scenes: {scenes}")
    for scene in scenes:
        row = summary(scene, *SMALL, "-o", f"{scene.stem}.txt")
        expect(row.get("grains") == "20", f"{scene.name}: {row}")


def check_wrong(scratch):
    for text, reason in WRONG:
        scene = scratch / "scene.cfg"
        scene.write_text(text)
        expect_refused(reason.replace("SCENE", str(scene)), scene)
    expect_refused("absent.cfg No such file", scratch / "absent.cfg")
    expect_refused("directory", scratch)
    expect_refused(COMMAND, COMMAND)
    expect_refused("/dev/zero", "/dev/zero")
    expect_refused("/dev/null", "/dev/null")
    for override, reason in (("packing.pressure=10", "packing.pressure 10"), ("packing.pressure", "packing.pressure"),
                             ("packing.pressure=abc", "packing.pressure abc"), ("packing.pressure=", "packing.pressure"),
                             ("packing.presure=1e-4", "packing.pressure"), ("=", ""),
                             ("packing.width=3.9", "packing.width 3.9"), ("packing.seed=18446744073709551616", "9223372036854775807"),
                             ("packing.dimension=1", "packing.dimension 1"), ("packing.depth=6", "packing.depth 6"),
                             ("packing.diameter_file=absent.txt", "absent.txt No such file")):
        expect_refused(reason, "--set", override)
        expect_refused("--set", "--set", override)


def check_values(scratch):
    """What is written is what is used; --set wins; whole reals and integers stand for each other."""
    scene = scratch / "scene.cfg"
    scene.write_text("packing : {\n  grains = 2e1, width = 6\n  pressure = 1e-3;\n  seed = 4294967297 };")
    row = summary(scene, "-o", "a.txt")
    expect(row.get("grains") == "20" and float(row.get("p", 0)) == 1e-3, f"values: {row}")
    row = summary(scene, "--set", "packing.grains=25", "--set", "packing.pressure=1e-5", "-o", "b.txt")
    expect(row.get("grains") == "25" and float(row.get("p", 0)) == 1e-5, f"overrides: {row}")
    same = summary(scene, "--set", "packing.seed=4294967297", "-o", "c.txt")
    by_option = summary(scene, "--seed", "4294967297", "-o", "d.txt")
    other = summary(scene, "--seed", "1", "-o", "e.txt")  # the same in 32 bits
    height = summary(scene, "-o", "f.txt").get("height")
    expect(same.get("height") == by_option.get("height") == height != other.get("height"), "seeds of 64 bits")
    for grains in (1, 3):
        row = summary("--set", "packing.kind=chain", "--set", f"packing.grains={grains}", "-o", f"chain{grains}.txt")
        expect(row.get("grains") == str(grains), f"a chain of {grains}: {row}")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-scene-") as folder:
        scratch = pathlib.Path(folder)
        os.chdir(scratch)
        check_help()
        check_examples()
        check_wrong(scratch)
        check_values(scratch)
        os.chdir("/")
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
