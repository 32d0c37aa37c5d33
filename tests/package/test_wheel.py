"""`pip install .`: the wheel of this build in an empty virtual environment, without network; and the source distribution.

usage: test_wheel.py BUILD_DIR SOURCE_DIR
"""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile

BUILD, SOURCE = sys.argv[1:3]
PROGRAM = ('import sonopack; p = sonopack.Packing.make(sonopack.Scene(packing={"grains": 60, "width": 8})); '
           'p.save("P.h5"); print(sonopack.__file__, sonopack.__version__, p.n)')


def run(*words):
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, env=clean)
    assert done.returncode == 0, (words, done.stdout, done.stderr)
    return done.stdout


if not importlib.util.find_spec("pip"):
    print("python3-pip is not there")
    sys.exit(77)
with tempfile.TemporaryDirectory(prefix="sonopack-wheel-") as folder:
    os.chdir(folder)
    place = pathlib.Path(folder)
    run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", "venv")
    python, command = place / "venv/bin/python", place / "venv/bin/sonopack"
    pip = sys.executable, "-m", "pip", "--python", python
    run(*pip, "wheel", "--no-deps", "--no-index", "--config-settings", f"build-dir={BUILD}", "-w", ".", SOURCE)
    wheel, = place.glob("*.whl")
    assert zipfile.ZipFile(wheel).testzip() is None
    run(*pip, "install", "--no-index", wheel)
    where, version, grains = run(python, "-c", PROGRAM).split()
    assert where.startswith(str(place / "venv")) and grains == "60", where
    assert run(command, "--version").split()[1] == version in wheel.name
    run(command, "check", "P.h5")
    run(command, "plot", "network", "P.h5", "-o", "P.svg")
    assert (place / "P.svg").stat().st_size > 1000
    assert (place / "venv/bin/sonopack-plot").read_text().startswith(f"#!{place}/venv/bin/python")
    run(*pip, "uninstall", "-y", "sonopack")
    assert not command.exists() and not pathlib.Path(where).exists()
    if (pathlib.Path(SOURCE) / ".git").exists() and shutil.which("git"):
        run(python, "-c", f"import sys; sys.path.insert(0, {SOURCE + '/python/packaging'!r}); import wheel; wheel.build_sdist('.')")
        names = tarfile.open(place / f"sonopack-{version}.tar.gz").getnames()
        assert {f"sonopack-{version}/{name}" for name in ("PKG-INFO", "pyproject.toml", "CMakeLists.txt", "src/cli/main.c")} <= set(names)
