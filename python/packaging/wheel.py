"""`pip install .`: a wheel of the command, its programs and the Python package, built by CMake (a build backend, PEP 517).

The libraries are those of the system, so that a wheel is of this machine's kind alone. --config-settings
build-dir=FOLDER takes what is built there."""
from __future__ import annotations

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = "lib/python3/dist-packages"


def _version():
    return re.search(r'SONOPACK_VERSION "([^"]+)"', (SOURCE / "include/sonopack/version.h").read_text())[1]


def _metadata():
    project = tomllib.loads((SOURCE / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    return "\n".join([
        "Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {_version()}", f"Summary: {project['description']}",
        f"License: {project['license']['text']}", f"Requires-Python: {project['requires-python']}",
        *(f"Requires-Dist: {need}" for need in project["dependencies"]),
        *(f"Provides-Extra: {extra}" for extra in extras),
        *(f"Requires-Dist: {need}; extra == '{extra}'" for extra, needs in extras.items() for need in needs),
        "Description-Content-Type: text/markdown", "", (SOURCE / project["readme"]).read_text()])


def _outside():
    """The environment without pip's, in which packages of the system are hidden; None if it lacks what the build needs."""
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    needs = subprocess.run([sys.executable, "-c", "import cffi, numpy"], env=clean, stderr=subprocess.DEVNULL)
    return clean if needs.returncode == 0 else None


def _run(*words):
    subprocess.run(["cmake", *map(str, words)], check=True, env=_outside())


def _installed(build, folder):
    """The tree of an installation."""
    if build is None:
        build = folder / "build"
        _run("-S", SOURCE, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DSONOPACK_TESTS=OFF", "-DSONOPACK_PYTHON=ON",
             f"-DSONOPACK_PYTHON_DIR={PACKAGE}", f"-DPython3_EXECUTABLE={sys.executable}")
        _run("--build", build, "--parallel")
    _run("--install", build, "--prefix", folder / "tree")
    return folder / "tree"


def _files(tree, data):
    """What belongs in the wheel, by its name there: the package, the commands, the manual page."""
    for path in sorted((tree / PACKAGE).rglob("*")):
        if path.is_file():
            yield path.relative_to(tree / PACKAGE).as_posix(), path.read_bytes()
    yield f"{data}/scripts/sonopack", (tree / "bin/sonopack").read_bytes()
    for path in sorted((tree / "libexec/sonopack").iterdir()):  # pip sets the interpreter
        yield f"{data}/scripts/{path.name}", b"#!python\n" + path.read_bytes().split(b"\n", 1)[1]
    yield f"{data}/data/share/man/man1/sonopack.1", (tree / "share/man/man1/sonopack.1").read_bytes()


def _tag():
    return f"cp3{sys.version_info.minor}-abi3-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def _info():
    """The files about the wheel, by their names."""
    about = f"Wheel-Version: 1.0\nGenerator: sonopack\nRoot-Is-Purelib: false\nTag: {_tag()}\n"
    return {f"sonopack-{_version()}.dist-info/{name}": content for name, content in (
        ("METADATA", _metadata().encode()), ("LICENSE", (SOURCE / "LICENSE").read_bytes()), ("WHEEL", about.encode()))}


def get_requires_for_build_wheel(config_settings=None):
    return [] if _outside() else ["cffi", "numpy"]


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    for name, content in _info().items():
        path = pathlib.Path(metadata_directory) / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
    return f"sonopack-{_version()}.dist-info"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    base = f"sonopack-{_version()}"
    name = f"{base}-{_tag()}.whl"
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w",
                                                                  zipfile.ZIP_DEFLATED) as wheel:
        tree = _installed((config_settings or {}).get("build-dir"), pathlib.Path(folder))
        record = ""
        for path, content in {**dict(_files(tree, f"{base}.data")), **_info()}.items():
            entry = zipfile.ZipInfo(path)
            entry.external_attr = (0o100755 if "/scripts/" in path else 0o100644) << 16  # a regular file
            wheel.writestr(entry, content, zipfile.ZIP_DEFLATED)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record += f"{path},sha256={digest},{len(content)}\n"
        wheel.writestr(f"{base}.dist-info/RECORD", f"{record}{base}.dist-info/RECORD,,\n")
    return name


def build_sdist(sdist_directory, config_settings=None):
    """Everything that git knows; PKG-INFO beside it."""
    base = f"sonopack-{_version()}"
    known = subprocess.run(["git", "-c", "safe.directory=*", "ls-files", "-z"], cwd=SOURCE, check=True, capture_output=True, text=True).stdout
    with tempfile.NamedTemporaryFile("w") as info, tarfile.open(pathlib.Path(sdist_directory) / f"{base}.tar.gz", "w:gz") as tar:
        info.write(_metadata())
        info.flush()
        tar.add(info.name, f"{base}/PKG-INFO")
        for name in filter(None, known.split("\0")):
            tar.add(SOURCE / name, f"{base}/{name}", recursive=False)
    return f"{base}.tar.gz"
