"""`pip install .`: a wheel of the command, its programs and the Python package, built by CMake (a build backend, PEP 517).

The libraries are those of the system, so that a wheel is of this machine's kind alone. --config-settings
build-dir=FOLDER takes what is built there."""
from __future__ import annotations

import base64
import hashlib
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


def _run(*words):
    subprocess.run(["cmake", *map(str, words)], check=True)


def _installed(build, folder):
    """The tree of an installation."""
    if build is None:
        build = folder / "build"
        _run("-S", SOURCE, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DSONOPACK_TESTS=OFF", f"-DSONOPACK_PYTHON_DIR={PACKAGE}",
             f"-DPython3_EXECUTABLE={sys.executable}")
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


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    base = f"sonopack-{_version()}"
    tag = f"cp3{sys.version_info.minor}-abi3-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    name = f"{base}-{tag}.whl"
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w",
                                                                  zipfile.ZIP_DEFLATED) as wheel:
        tree = _installed((config_settings or {}).get("build-dir"), pathlib.Path(folder))
        info = f"{base}.dist-info"
        files = {**dict(_files(tree, f"{base}.data")), f"{info}/METADATA": _metadata().encode(),
                 f"{info}/LICENSE": (SOURCE / "LICENSE").read_bytes(),
                 f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: sonopack\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()}
        record = ""
        for path, content in files.items():
            entry = zipfile.ZipInfo(path)
            entry.external_attr = (0o100755 if "/scripts/" in path else 0o100644) << 16  # a regular file
            wheel.writestr(entry, content, zipfile.ZIP_DEFLATED)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record += f"{path},sha256={digest},{len(content)}\n"
        wheel.writestr(f"{info}/RECORD", record + f"{info}/RECORD,,\n")
    return name


def build_sdist(sdist_directory, config_settings=None):
    """Everything that git knows; PKG-INFO beside it."""
    base = f"sonopack-{_version()}"
    known = subprocess.run(["git", "ls-files", "-z"], cwd=SOURCE, check=True, capture_output=True, text=True).stdout
    with tempfile.NamedTemporaryFile("w") as info, tarfile.open(pathlib.Path(sdist_directory) / f"{base}.tar.gz", "w:gz") as tar:
        info.write(_metadata())
        info.flush()
        tar.add(info.name, f"{base}/PKG-INFO")
        for name in filter(None, known.split("\0")):
            tar.add(SOURCE / name, f"{base}/{name}", recursive=False)
    return f"{base}.tar.gz"
