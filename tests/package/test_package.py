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
MODULES = ("sonopack", "sonopack-tapped", "sonopack-study")
# make takes twice as long
BUILDER = {**os.environ, **({"CMAKE_GENERATOR": "Ninja"} if shutil.which("ninja") else {})}
# what someone who wants signals alone must not be handed
NOT_IN_THE_CORE = re.compile(r"lib(hdf5\w*|config)\.so")


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
    for header in pathlib.Path(SOURCE, "include").rglob("*.h"):
        name = header.relative_to(SOURCE)
        expect(str(name) in installed, f"{name} is not installed")
    for ending in ("bin/sonopack", "share/man/man1/sonopack.1", "share/bash-completion/completions/sonopack",
                   "cmake/sonopack/sonopackConfig.cmake", "cmake/sonopack/sonopackConfigVersion.cmake",
                   *(f"pkgconfig/{module}.pc" for module in MODULES)):
        expect(any(name.endswith(ending) for name in installed), f"{ending} is not installed: {installed}")
    libraries = [name for name in installed if re.search(r"/libsonopack\w*\.(a|so)$", name)]
    expect(len(libraries) == len(MODULES), f"{len(MODULES)} libraries, not {libraries}")
    check_symbols([prefix / name for name in libraries])
    # nothing installed may lead back to the folders it was built in
    for name in installed:
        if name.endswith((".cmake", ".pc")):
            text = (prefix / name).read_text()
            expect(SOURCE not in text and BUILD not in text, f"{name} names the build tree")


def check_symbols(libraries):
    """Every global symbol begins with sp_; a shared library shows no others, and hides what is not shared."""
    for library in libraries:
        shared = library.suffix == ".so"
        listing = run("nm", *(["-D"] if shared else ["-g"]), "--defined-only", library)
        names = {line.split()[-1] for line in listing.splitlines() if len(line.split()) == 3}
        names = {re.sub(r"\.(resolver|default|avx\w*|arch_\w+)(\.\d+)?$", "", name) for name in names}
        strangers = sorted(name for name in names - {"__bss_start", "_edata", "_end"} if not name.startswith("sp_"))
        expect(names and not strangers, f"{library.name}: global symbols without sp_: {strangers}")
        if shared and library.name == "libsonopack.so":
            expect("sp_signal_make" in names and "sp_pairs_rebuild" not in names, f"{library.name}: visibility")


def check_linked(program, light, env=None):
    """What a consumer was linked to: signals alone without the libraries of studies."""
    needed = run("ldd", program, env=env)
    if light:
        expect(not NOT_IN_THE_CORE.search(needed), f"{program.name} is linked to more than it needs:\n{needed}")
    else:
        expect(len(set(NOT_IN_THE_CORE.findall(needed))) == 2, f"{program.name}:\n{needed}")


def check_cmake_consumer(prefix, scratch, everything=False):
    """One folder for all: what CMake finds out of the compiler takes most of the time."""
    build = scratch / "cmake-consumer"
    run(CMAKE, "-S", HERE, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_C_COMPILER={CC}",
        f"-DCOMPONENTS={'study;tapped' if everything else ''}", env=BUILDER)
    run(CMAKE, "--build", build)
    check_linked(build / "consumer", light=not everything)
    return run(build / "consumer", *([scratch] if everything else []))


def check_unknown_component(scratch):
    result = subprocess.run([CMAKE, "-DCOMPONENTS=nonsense", scratch / "cmake-consumer"], text=True,
                            capture_output=True)
    expect(result.returncode != 0 and "nonsense" in result.stderr, f"an unknown component: {result.stderr}")


def check_pkgconfig_consumer(prefix, scratch, everything=False):
    folder = next(prefix.rglob("sonopack.pc")).parent
    env = dict(os.environ, PKG_CONFIG_PATH=str(folder))
    modules = MODULES[1:] if everything else MODULES[:1]
    flags = run("pkg-config", "--cflags", "--libs", *modules, env=env).split()
    for module in modules:
        expect(run("pkg-config", "--modversion", module, env=env) == public_version(), f"version of {module}.pc")
    program = scratch / f"pkg-config-consumer-{everything}"
    source = HERE / ("consumer_all.c" if everything else "consumer.c")
    run(CC, "-std=c17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", source, "-o", program, *flags, "-lm")
    env = dict(os.environ, LD_LIBRARY_PATH=str(folder.parent))
    check_linked(program, not everything, env)
    return run(program, *([scratch] if everything else []), env=env)


def check_headers_in_cplusplus(prefix):
    compiler = shutil.which("clang")
    if not compiler:
        print("no clang: headers not tried as C++")
        return
    # that each includes what it needs is seen in C
    words = [word for header in sorted((prefix / "include/sonopack").rglob("*.h")) for word in ("-include", header)]
    run(compiler, "-x", "c++", "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", f"-I{prefix / 'include'}",
        *words, "/dev/null")


def check_header_alone(prefix):
    """Each public header compiles as the first and only include."""
    for header in sorted((prefix / "include/sonopack").rglob("*.h")):
        run(CC, "-x", "c", "-std=c17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
            f"-I{prefix / 'include'}", "-include", header, "/dev/null")


def check_manual(prefix):
    page = prefix / "share/man/man1/sonopack.1"
    if shutil.which("man") and shutil.which("groff"):
        env = dict(os.environ, MANWIDTH="100", LC_ALL="C.UTF-8")
        complaints = subprocess.run(["man", "--warnings", "-l", str(page)], env=env, text=True, capture_output=True)
        expect(complaints.returncode == 0 and not complaints.stderr, f"sonopack.1: {complaints.stderr}")
        expect("sonopack" in complaints.stdout, "an empty manual page")


def check_page(prefix, scratch):
    """The moved command writes a page: no file beside it is needed."""
    run(prefix / "bin/sonopack", "pack", "-q", "--set", 'packing.kind="chain"', "--set", "packing.grains=8", "-o",
        scratch / "chain.h5")
    run(prefix / "bin/sonopack", "view", scratch / "chain.h5", "-o", scratch / "chain.html")
    expect("sonopack-data" in (scratch / "chain.html").read_text(), "the installed command writes an empty page")


def check_without_pkg_config_of_hdf5(scratch):
    """Fedora's HDF5 has no pkg-config file: its consumers are told its plain name."""
    program = scratch / "pkg-config"
    program.write_text("#!/bin/sh\ncase $* in *hdf5*) exit 1 ;; esac\nexec pkg-config \"$@\"\n")
    program.chmod(0o755)
    run(CMAKE, "-S", SOURCE, "-B", scratch / "plain", f"-DPKG_CONFIG_EXECUTABLE={program}", f"-DCMAKE_C_COMPILER={CC}",
        "-DHDF5_INCLUDE_DIR=/", "-DHDF5_LIBRARY=/", "-DSONOPACK_PYTHON=OFF", "-DSONOPACK_TESTS=OFF", env=BUILDER)
    module = (scratch / "plain/sonopack-study.pc").read_text()
    expect(re.search("^Libs:.* -lhdf5", module, re.M) and not re.search("^Requires:.*hdf5", module, re.M), module)


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-package-") as folder:
        scratch = pathlib.Path(folder)
        first, prefix = scratch / "first", scratch / "moved"
        run(CMAKE, "--install", BUILD, "--prefix", first)
        first.rename(prefix)  # nothing may depend on where it was installed first
        check_files(prefix)
        version = run(prefix / "bin/sonopack", "--version")
        expect(public_version() in version, f"--version says {version}")
        check_page(prefix, scratch)
        one = check_cmake_consumer(prefix, scratch)
        two = check_pkgconfig_consumer(prefix, scratch)
        print(one)
        expect(one == two and public_version() in one, f"the consumers differ: {one} / {two}")
        one = check_cmake_consumer(prefix, scratch, everything=True)
        two = check_pkgconfig_consumer(prefix, scratch, everything=True)
        expect(one == two and "grains" in one, f"the consumers of all components differ: {one} / {two}")
        check_unknown_component(scratch)
        check_header_alone(prefix)
        check_headers_in_cplusplus(prefix)
        check_manual(prefix)
        check_without_pkg_config_of_hdf5(scratch)


if __name__ == "__main__":
    main()
