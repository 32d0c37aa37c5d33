"""./run with stand-ins for apt-get, sudo, cmake and the command: what it installs, builds, runs and prints.

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
    "dpkg-query": """for package; do :; done; if grep -qx "$package" "$HERE/installed"; then printf installed; else exit 1; fi""",
    "apt-get": """echo "apt-get $*" >>"$HERE/log"
if [ "$1" = "${APT_FAILS:-none}" ]; then exit 100; fi
if [ "$1" = install ]; then for package; do echo "$package" >>"$HERE/installed"; done; fi""",
    "sudo": 'echo sudo >>"$HERE/log"; exec "$@"',
    "ctest": 'echo "ctest $*" >>"$HERE/log"; echo "100% tests passed, 0 tests failed out of 7"',
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

    def __init__(self, folder, installed):
        self.here = pathlib.Path(folder)
        self.tree = self.here / "a checkout"
        self.bin = self.here / "bin"
        self.tree.mkdir()
        self.bin.mkdir()
        for name in ("run", "CMakePresets.json"):
            shutil.copy(SOURCE / name, self.tree)
        shutil.copytree(SOURCE / ".ci", self.tree / ".ci")
        for tool in TOOLS:
            if shutil.which(tool):
                (self.bin / tool).symlink_to(shutil.which(tool))
        for name, body in STUBS.items():
            (self.bin / name).write_text(f"#!/usr/bin/env bash\n{body}\n")
            (self.bin / name).chmod(0o755)
        (self.here / "installed").write_text("\n".join(installed) + "\n")
        (self.here / "command").write_text(COMMAND)

    def run(self, *arguments, script="run", **variables):
        (self.here / "log").write_text("")
        env = {"PATH": str(self.bin), "HERE": str(self.here), **variables}
        result = subprocess.run([self.bin / "bash", self.tree / script, *arguments], env=env, text=True,
                                capture_output=True, stdin=subprocess.DEVNULL, cwd=self.here)
        # sbin of this machine is on the PATH too, but the stand-ins come first
        return result, (self.here / "log").read_text().splitlines()


def packages(name):
    text = (SOURCE / "run").read_text()
    return text.split(f"{name}=(")[1].split(")")[0].split()


BUILD, TEST = packages("build_packages"), packages("test_packages")


def check(condition, *what):
    if not condition:
        print(*what, sep="\n")
        raise SystemExit("failed")


def try_usage(folder):
    box = Checkout(folder, BUILD + TEST)
    for arguments, status in ((("help",), 0), (("--help",), 0), (("nonsense",), 2), (("test", "more"), 2)):
        result, log = box.run(*arguments)
        check(result.returncode == status and not log, arguments, result, log)
        check("usage: ./run" in (result.stdout if status == 0 else result.stderr), arguments, result)


def try_bare_machine(folder):
    box = Checkout(folder, [p for p in BUILD if p not in ("cmake", "libhdf5-dev")])
    result, log = box.run("build")
    check(result.returncode == 0, result, log)
    check(log[0].startswith("apt-get update"), log)
    words = log[1].split()
    check(words[:2] == ["apt-get", "install"] and "-y" in words and "--no-install-recommends" in words, log)
    check([w for w in words[2:] if not w.startswith("-")] == ["cmake", "libhdf5-dev"], log)
    check("cmake libhdf5-dev" in result.stderr, result.stderr)
    check(any(line.startswith("cmake --preset release") for line in log), log)
    check(any(line.startswith("cmake --build build/release") and "3" in line for line in log), log)
    result, log = box.run("build")
    check(result.returncode == 0 and not any("apt-get" in line for line in log), "a second time", result, log)


def try_without_root(folder):
    box = Checkout(folder, [p for p in BUILD if p != "cmake"])
    result, log = box.run("build", FAKE_UID="1000")
    check(result.returncode == 0 and log[0] == "sudo" and log[1].startswith("apt-get update"), result, log)
    (box.here / "installed").write_text("gcc\n")
    (box.bin / "sudo").unlink()
    result, log = box.run("build", FAKE_UID="1000")
    check(result.returncode == 1 and not log and "apt-get" in result.stderr, result, log)


def try_failures(folder):
    box = Checkout(folder, ["gcc"])
    result, log = box.run("build", APT_FAILS="install")
    check(result.returncode == 1 and "apt-get" in result.stderr, result, log)
    check(not any("cmake" in line.split()[0] for line in log), "built all the same", log)
    result, log = box.run("build", APT_FAILS="update")
    check(result.returncode == 0, "stale package lists may do", result, log)
    result, log = box.run(STUDY_FAILS="study")
    check(result.returncode == 1 and "./run" in result.stderr, result, log)


def try_main_job(folder):
    box = Checkout(folder, BUILD)
    for _ in range(2):
        result, log = box.run()
        check(result.returncode == 0, result, log)
        study = [line for line in log if line.startswith("sonopack study")]
        check(len(study) == 1 and "packings/ctof-quick.cfg" in study[0], log)
        check("--store results/ctof-quick" in study[0] and "--jobs 3" in study[0], log)
        rows = [line.split() for line in result.stdout.splitlines() if line.strip().startswith("1.0e-")]
        check([row[-3] for row in rows] == ["0.0822", "0.2600"], "the paper's c_tof, 0.26 (p/1e-4)^(1/6)", result)
        check([row[2] for row in rows] == ["0.0825", "0.2613"], "our c_tof", result)
        for name in ("results/ctof-quick.tsv", "results/ctof.svg", "results/ctof.png"):
            check((box.tree / name).exists() and name in result.stdout, name, result)


def try_moved_checkout(folder):
    box = Checkout(folder, BUILD)
    box.run("build")
    (box.tree / "build/release/CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere\n")
    (box.tree / "build/release/stale").write_text("")
    result, log = box.run("build")
    check(result.returncode == 0 and not (box.tree / "build/release/stale").exists(), result, log)
    (box.tree / "results").mkdir()
    result, log = box.run("clean")
    check(not (box.tree / "build").exists() and (box.tree / "results").exists(), "clean keeps results", result)


def try_tests(folder):
    box = Checkout(folder, BUILD)
    result, log = box.run("test")
    check(set(TEST) <= set(log[1].split()), "test packages", log)
    check([line for line in log if line.startswith("ctest")][-1].split()[1:3] == ["--test-dir", "build/release"], log)
    check(sum(line.startswith("ctest") for line in log) == 1 and "-LE long|slow|foreign" in log[-1], log)
    check(result.stdout.splitlines()[-1].startswith("100% tests passed"), result)
    result, log = box.run("test-long")
    check(log[-1].endswith("-LE foreign"), log)
    result, log = box.run("test-foreign")
    check({"lammps", "yade", "octave", "chromium", "python3-vtk9"} <= set(" ".join(log).split()), log)
    check(log[-1].endswith("-L foreign"), log)
    result, log = box.run(script=".ci/run")
    check(result.returncode == 0, result, log)
    presets = [line.split()[2] for line in log if line.startswith("cmake --preset")]
    check(presets == ["clang", "sanitize", "release"] and "SONOPACK_WERROR=ON" in "".join(log), log)
    check(log[-1].startswith("ctest --test-dir build/release") and log[-1].split()[-1] == "long|foreign", log)
    check(result.stdout.splitlines()[-1] == "100% tests passed, 0 tests failed out of 7", result)


def main():
    for trial in (try_usage, try_bare_machine, try_without_root, try_failures, try_main_job, try_moved_checkout,
                  try_tests):
        with tempfile.TemporaryDirectory(prefix="sonopack-run-") as folder:
            trial(folder)
        print(trial.__name__, "ok")


if __name__ == "__main__":
    main()
