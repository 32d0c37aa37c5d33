"""The Debian package: what it needs, what it holds, and that its command works out of the unpacked tree.

usage: test_deb.py BUILD_DIR SOURCE_DIR CMAKE C_COMPILER
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BUILD, SOURCE, CMAKE = sys.argv[1:4]
# cpack asks `cmake -E env file` what each of the four hundred files is: here only of those that may be binaries
CMAKE_THAT_LOOKS = f"""#!/bin/sh
case $* in
"-E env LC_ALL=C "*file\\ *)
    shift 3
    case $(head -c 4 "$2") in
    *ELF) exec env LC_ALL=C "$@" ;;
    *) echo "$2: data" ;;
    esac ;;
*) exec '{CMAKE}' "$@" ;;
esac
"""


def run(*command, **more):
    result = subprocess.run([str(c) for c in command], text=True, capture_output=True, timeout=250, **more)
    if result.returncode != 0:
        sys.exit(f"{command[0]} ended with {result.returncode}:\n{result.stdout}{result.stderr}")
    return result.stdout


def expect(condition, message):
    if not condition:
        sys.exit(f"failed: {message}")


def check_control(deb):
    fields = dict(line.split(": ", 1) for line in run("dpkg-deb", "-f", deb).splitlines() if ": " in line[:40])
    lines = run("dpkg-deb", "-f", deb, "Description").splitlines()
    expect(len(lines) > 1 and lines[0].strip() not in map(str.strip, lines[1:]), f"the description repeats itself: {lines}")
    header = pathlib.Path(SOURCE, "include/sonopack/version.h").read_text()
    expect(f'"{fields["Version"]}"' in header, f"version {fields['Version']} is not that of version.h")
    needs = {name.split()[0] for name in fields["Depends"].split(", ")}
    # what the command is linked with, and what it loads at the first call
    for part in ("libc6", "libconfig", "libcholmod", "liblapacke", "libarpack2", "hdf5", "openblas"):
        expect(any(part in name for name in needs), f"no {part} among {needs}")


def check_content(tree, scratch):
    command = tree / "usr/bin/sonopack"
    version = run(command, "--version")
    expect("sonopack" in version, version)
    run(command, "pack", tree / "usr/share/doc/sonopack/packings/single.cfg", "--set", "packing.grains=60", "--set",
        "packing.width=8", "--set", "packing.tolerance=1e-8", "-q", "-o", scratch / "p.h5")
    signal = run(command, "signal", scratch / "p.h5", "-q")
    expect("\nt\tF\n" in signal, signal[:300])
    run(command, "plot", "network", scratch / "p.h5", "-o", scratch / "n.png")
    for file in ("share/man/man1/sonopack.1", "include/sonopack/packing.h", "share/doc/sonopack/LICENSE",
                 "share/bash-completion/completions/sonopack"):
        found = list((tree / "usr").glob(file + "*"))
        expect(found, f"no {file}")


def check_pages(doc):
    """The links of the installed pages lead to installed files, and the samples that they use are there."""
    dead = [f"{page.relative_to(doc)}: {target}" for page in doc.rglob("*.md")
            for target in re.findall(r"\]\(([^)#\s]+)", page.read_text())
            if not re.match(r"\w+:", target) and not (page.parent / target).exists()]
    expect(not dead, f"dead links: {dead}")
    for sample in pathlib.Path(SOURCE, "tests/foreign/samples").rglob("*"):
        expect((doc / sample.relative_to(SOURCE)).exists() or "__pycache__" in sample.parts, f"{sample.name} is not there")


def check_python(tree):
    """Where it is built, the Python module is in the package."""
    cache = pathlib.Path(BUILD, "CMakeCache.txt").read_text()
    if not re.search(r"^SONOPACK_PYTHON:BOOL=(ON|1|TRUE)$", cache, re.M):
        print("no Python module is built")
        return
    folder = tree / "usr" / re.search(r"^SONOPACK_PYTHON_DIR:\w+=(.*)$", cache, re.M).group(1)
    where = run(sys.executable, "-B", "-c", "import sonopack; print(sonopack.__file__)",
                env=dict(os.environ, PYTHONPATH=str(folder)))
    expect(where.startswith(str(folder)), f"imported from {where}")


def main():
    if not (shutil.which("dpkg-deb") and shutil.which("dpkg-shlibdeps") and shutil.which("cpack")):
        print("dpkg-dev or cpack is not installed")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        (scratch / "cmake").write_text(CMAKE_THAT_LOOKS)
        (scratch / "cmake").chmod(0o755)
        run("cpack", "--config", pathlib.Path(BUILD, "CPackConfig.cmake"), "-G", "DEB", "-D",
            f"CMAKE_COMMAND={scratch / 'cmake'}", "-B", scratch / "deb")
        deb, = (scratch / "deb").glob("*.deb")
        check_control(deb)
        run("dpkg-deb", "-x", deb, scratch / "tree")
        check_content(scratch / "tree", scratch)
        check_pages(scratch / "tree/usr/share/doc/sonopack")
        check_python(scratch / "tree")


main()
