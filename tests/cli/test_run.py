"""./run with stand-ins for apt-get, dnf, sudo, cmake and the command: what it installs, builds, runs and prints.

usage: test_run.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(sys.argv[2])
TOOLS = "bash cat env grep awk mkdir rm dirname chmod sort mapfile".split()
STUBS = {
    "nproc": "echo 3",
    "id": 'echo "${FAKE_UID:-0}"',
    "ninja": ":",
    "dpkg-query": """for package; do :; done
while read -r name; do if [ "$name" = "$package" ]; then printf installed; exit; fi; done <"$HERE/installed"
exit 1""",
    "apt-get": """echo "apt-get $*" >>"$HERE/log"
if [ "$1" = "${APT_FAILS:-none}" ]; then exit 100; fi
if [ "$1" = install ]; then for package; do echo "$package" >>"$HERE/installed"; done; fi""",
    "rpm": 'for package; do :; done; exec dpkg-query "$package" >/dev/null',
    "dnf": 'echo "dnf $*" >>"$HERE/log"; for package; do echo "$package" >>"$HERE/installed"; done',
    "cpack": ":",
    "sudo": 'echo sudo >>"$HERE/log"; exec "$@"',
    "ctest": 'echo "ctest $*" >>"$HERE/log"; echo "100% tests passed, 0 tests failed out of 7"',
    # as the real one, it reads conf.py in the folder of the pages
    "sphinx-build": 'cd docs && "$SONOPACK_BUILD/sonopack" help',
    "cmake": """echo "cmake $*" >>"$HERE/log"
case "$1" in
--preset)
    mkdir -p "build/$2"
    echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" >"build/$2/CMakeCache.txt" ;;
--build)
    cat "$HERE/command" >"$2/sonopack"
    chmod +x "$2/sonopack" ;;
esac""",
}
COMMAND = r"""#!/usr/bin/env bash
echo "sonopack $*" >>"$HERE/log"
[ "$1" = "${STUDY_FAILS:-none}" ] && exit 1
arguments=("$@")
for i in "${!arguments[@]}"; do
    [ "${arguments[i]}" = -o ] && output=${arguments[i + 1]}
done
if [ "${output-}" ]; then
    printf '# x\np\tsamples\tc_tof\tc_tof_err\tc_peak\tc_zero\tc_l\tc_t\n' >"$output"
    printf '1e-07\t10\t0.0825\t0.0009\t0.07\t0.05\t0.053\t0.018\n1e-04\t10\t0.2613\t0.004\t0.2\t0.19\t0.19\t0.09\n' >>"$output"
fi
exit 0
"""


class Checkout:
    """A folder with ./run and nothing else real in it, and a PATH of stand-ins."""

    def __init__(self, folder, installed, system="ID=debian"):
        self.here = pathlib.Path(folder)
        self.tree, self.bin = self.here / "a checkout", self.here / "bin"
        (self.tree / "docs").mkdir(parents=True)
        self.bin.mkdir()
        for name in ("run", "CMakePresets.json"):
            shutil.copy(SOURCE / name, self.tree)
        shutil.copytree(SOURCE / ".ci", self.tree / ".ci")
        for tool in filter(shutil.which, TOOLS):
            (self.bin / tool).symlink_to(shutil.which(tool))
        for name, body in STUBS.items():
            (self.bin / name).write_text(f"#!/bin/sh\n{body}\n")  # many of them: no bash for each
            (self.bin / name).chmod(0o755)
        (self.here / "installed").write_text("\n".join(installed) + "\n")
        (self.here / "command").write_text(COMMAND)
        (self.here / "os-release").write_text(system + "\n")

    def run(self, *words, status=0, script="run", **variables):
        """(the process, what it called)"""
        (self.here / "log").write_text("")
        here = {"PATH": str(self.bin), "HERE": str(self.here), "OS_RELEASE": str(self.here / "os-release")}
        done = subprocess.run([self.bin / "bash", self.tree / script, *words], text=True, capture_output=True, cwd=self.here,
                              stdin=subprocess.DEVNULL, env={**here, **variables})
        log = (self.here / "log").read_text().splitlines()
        assert done.returncode == status, (words, done, log)
        return done, log


def packages(name):
    return (SOURCE / "run").read_text().split(f"{name}=(")[1].split(")")[0].split()


BUILD, TEST = packages("build_packages"), packages("test_packages")


def usage(folder):
    box = Checkout(folder, BUILD + TEST)
    for words, status in ((("help",), 0), (("--help",), 0), (("nonsense",), 2), (("test", "more"), 2)):
        done, log = box.run(*words, status=status)
        assert not log and "usage: ./run" in (done.stderr if status else done.stdout), (words, log)


def bare_machine(folder):
    box = Checkout(folder, [p for p in BUILD if p not in ("cmake", "libhdf5-dev")])
    done, log = box.run("build")
    words = log[1].split()
    assert log[0].startswith("apt-get update") and words[:2] == ["apt-get", "install"], log
    assert {"-y", "--no-install-recommends"} <= set(words) and "cmake libhdf5-dev" in done.stderr, log
    assert [word for word in words[2:] if not word.startswith("-")] == ["cmake", "libhdf5-dev"], log
    assert any(line.startswith("cmake --preset release") for line in log), log
    assert any(line.startswith("cmake --build build/release") and "3" in line for line in log), log
    assert not any("apt-get" in line for line in box.run("build")[1]), "a second time"
    for word in ("docs", "deb"):
        assert any("-DSONOPACK_TESTS=OFF" in line for line in box.run(word)[1]), "what tests need is not installed"


def failures(folder):
    box = Checkout(folder, ["gcc"])
    done, log = box.run("build", status=1, APT_FAILS="install")
    assert "apt-get" in done.stderr and not any("cmake" in line.split()[0] for line in log), log
    box.run("build", APT_FAILS="update")  # stale package lists may do
    assert "./run" in box.run(status=1, STUDY_FAILS="study")[0].stderr
    (box.here / "installed").write_text("gcc\n")
    log = box.run("build", FAKE_UID="1000")[1]
    assert log[0] == "sudo" and log[1].startswith("apt-get update"), log
    (box.here / "installed").write_text("gcc\n")
    (box.bin / "sudo").unlink()
    done, log = box.run("build", status=1, FAKE_UID="1000")
    assert not log and "apt-get" in done.stderr, log


def other_systems(folder):
    for system, hdf5, apt in (("ID=ubuntu\nID_LIKE=debian", "libhdf5-dev", True),
                              ("ID=mint\nID_LIKE='ubuntu debian'", "libhdf5-dev", True), ("ID=fedora", "hdf5-devel", False)):
        place = pathlib.Path(folder, system.split()[0])
        place.mkdir()
        box = Checkout(place, ["gcc"], system)
        log = box.run("test")[1]
        install = next(line for line in log if " install " in line)
        assert hdf5 in install.split() and "gcc" not in install.split() and "  " not in install, log
        assert log[0].startswith("apt-get update") == apt != install.startswith("dnf"), log
        assert not any("install" in line for line in box.run("test")[1]), "a second time"
        assert apt or not any(word.endswith("-dev") for word in install.split()), "Debian's names"
        assert ("chromium" in " ".join(box.run("test-foreign")[1]).split()) != apt, system


def unknown_system(folder):
    assert not any("install" in line for line in Checkout(folder, [], "ID=plan9").run("build")[1])


def main_job(folder):
    box = Checkout(folder, BUILD)
    for _ in range(2):
        done, log = box.run()
        study, = (line for line in log if line.startswith("sonopack study"))
        assert all(word in study for word in ("packings/ctof-quick.cfg", "--store results/ctof-quick", "--jobs 3")), log
        rows = [line.split() for line in done.stdout.splitlines() if line.strip().startswith("1.0e-")]
        assert [row[-3] for row in rows] == ["0.0822", "0.2600"], "the paper's c_tof, 0.26 (p/1e-4)^(1/6)"
        assert [row[2] for row in rows] == ["0.0825", "0.2613"], rows
        for name in ("results/ctof-quick.tsv", "results/ctof.svg", "results/ctof.png"):
            assert (box.tree / name).exists() and name in done.stdout, name


def moved_checkout(folder):
    box = Checkout(folder, BUILD)
    box.run("build")
    (box.tree / "build/release/CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere\n")
    (box.tree / "build/release/stale").write_text("")
    box.run("build")
    assert not (box.tree / "build/release/stale").exists()
    (box.tree / "results").mkdir()
    box.run("clean")
    assert not (box.tree / "build").exists() and (box.tree / "results").exists(), "clean keeps results"


def tests(folder):
    box = Checkout(folder, BUILD)
    done, log = box.run("test")
    assert set(TEST) <= set(log[1].split()) and sum(line.startswith("ctest") for line in log) == 1, log
    assert log[-1].startswith("ctest --test-dir build/release") and "-LE long|slow|foreign" in log[-1], log
    assert done.stdout.splitlines()[-1].startswith("100% tests passed")
    log = box.run("test-long")[1]
    assert log[-1].endswith("-LE foreign") and {"clang-tidy", "cppcheck"} <= set(" ".join(log).split()), log
    log = box.run("test-foreign")[1]
    assert {"lammps", "yade", "octave", "chromium", "python3-vtk9"} <= set(" ".join(log).split())
    assert log[-1].endswith("-L foreign"), log
    done, log = box.run(script=".ci/run")
    presets = [line.split()[2] for line in log if line.startswith("cmake --preset")]
    assert presets == ["clang", "sanitize", "release"] and "SONOPACK_WERROR=ON" in "".join(log), log
    assert log[-1].startswith("ctest --test-dir build/release") and log[-1].split()[-1] == "long|foreign|fuzz", log


def site(folder):
    box = Checkout(folder, BUILD + TEST)
    done, log = box.run("docs")
    assert log[-1] == "sonopack help" and "build/docs/index.html" in done.stderr, (done, log)


for test in (usage, bare_machine, failures, other_systems, unknown_system, main_job, moved_checkout, tests, site):
    with tempfile.TemporaryDirectory(prefix="sonopack-run-") as scratch:
        test(scratch)
    print(test.__name__, "ok")
