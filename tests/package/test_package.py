"""An installation serves users' projects: find_package, pkg-config, a moved tree, the command, the manual.

usage: test_package.py BUILD_DIR SOURCE_DIR CMAKE C_COMPILER
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BUILD, SOURCE, CMAKE, CC = sys.argv[1:5]
HERE = pathlib.Path(SOURCE, "tests", "package")


def run(*command, env=None, **more):
    print("+", *command, flush=True)
    result = subprocess.run([str(c) for c in command], env=env, text=True, capture_output=True, **more)
    if result.returncode:
        sys.exit(f"{command[0]} failed with {result.returncode}:\n{result.stdout}{result.stderr}")
    return result.stdout.strip()


def expect(condition, message):
    if not condition:
        sys.exit(f"failed: {message}")


def public_version():
    text = pathlib.Path(SOURCE, "include/sonopack/version.h").read_text()
    return re.search(r'SONOPACK_VERSION "([^"]+)"', text).group(1)


def check_files(prefix):
    installed = sorted(str(p.relative_to(prefix)) for p in prefix.rglob("*") if not p.is_dir())
    for header in pathlib.Path(SOURCE, "include/sonopack").glob("*.h"):
        expect(f"include/sonopack/{header.name}" in installed, f"{header.name} is not installed")
    for ending in ("bin/sonopack", "share/man/man1/sonopack.1", "share/bash-completion/completions/sonopack",
                   "cmake/sonopack/sonopackConfig.cmake", "cmake/sonopack/sonopackConfigVersion.cmake",
                   "pkgconfig/sonopack.pc"):
        expect(any(name.endswith(ending) for name in installed), f"{ending} is not installed: {installed}")
    libraries = [name for name in installed if re.search(r"/libsonopack\.(a|so)$", name)]
    expect(len(libraries) == 1, f"one library, not {libraries}")
    # nothing installed may lead back to the folders it was built in
    for name in installed:
        if name.endswith((".cmake", ".pc")):
            text = (prefix / name).read_text()
            expect(SOURCE not in text and BUILD not in text, f"{name} names the build tree")


def check_cmake_consumer(prefix, scratch):
    build = scratch / "cmake-consumer"
    run(CMAKE, "-S", HERE, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_C_COMPILER={CC}")
    run(CMAKE, "--build", build)
    return run(build / "consumer")


def check_pkgconfig_consumer(prefix, scratch):
    folder = next(prefix.rglob("sonopack.pc")).parent
    env = dict(os.environ, PKG_CONFIG_PATH=str(folder))
    flags = run("pkg-config", "--cflags", "--libs", "sonopack", env=env).split()
    expect(run("pkg-config", "--modversion", "sonopack", env=env) == public_version(), "version of sonopack.pc")
    program = scratch / "pkg-config-consumer"
    run(CC, "-std=c17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", HERE / "consumer.c", "-o", program, *flags, "-lm")
    return run(program, env=dict(os.environ, LD_LIBRARY_PATH=str(folder.parent)))


def check_headers_in_cplusplus(prefix):
    compiler = shutil.which("clang")
    if not compiler:
        print("no clang: headers not tried as C++")
        return
    for header in sorted((prefix / "include/sonopack").glob("*.h")):
        run(compiler, "-x", "c++", "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
            f"-I{prefix / 'include'}", header)


def check_header_alone(prefix):
    """Each public header compiles as the first and only include."""
    for header in sorted((prefix / "include/sonopack").glob("*.h")):
        run(CC, "-x", "c", "-std=c17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
            f"-I{prefix / 'include'}", "-include", header, "/dev/null")


def check_manual(prefix):
    page = prefix / "share/man/man1/sonopack.1"
    if shutil.which("man") and shutil.which("groff"):
        env = dict(os.environ, MANWIDTH="100", LC_ALL="C.UTF-8")
        complaints = subprocess.run(["man", "--warnings", "-l", str(page)], env=env, text=True, capture_output=True)
        expect(complaints.returncode == 0 and not complaints.stderr, f"sonopack.1: {complaints.stderr}")
        expect("sonopack" in complaints.stdout, "an empty manual page")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-package-") as folder:
        scratch = pathlib.Path(folder)
        first, prefix = scratch / "first", scratch / "moved"
        run(CMAKE, "--install", BUILD, "--prefix", first)
        first.rename(prefix)  # nothing may depend on where it was installed first
        check_files(prefix)
        version = run(prefix / "bin/sonopack", "--version")
        expect(public_version() in version, f"--version says {version}")
        one = check_cmake_consumer(prefix, scratch)
        two = check_pkgconfig_consumer(prefix, scratch)
        print(one)
        expect(one == two and public_version() in one, f"the consumers differ: {one} / {two}")
        check_header_alone(prefix)
        check_headers_in_cplusplus(prefix)
        check_manual(prefix)


if __name__ == "__main__":
    main()
