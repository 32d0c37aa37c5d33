"""The Python package of an installation works by itself, wherever the tree is moved.

usage: test_python.py BUILD_DIR PYTHON_DIR CMAKE
"""
import os
import pathlib
import subprocess
import sys
import tempfile

BUILD, PYTHON_DIR, CMAKE = sys.argv[1:4]
PROGRAM = """
import sonopack
packing = sonopack.Packing.make(sonopack.Scene(packing={"grains": 60, "width": 8}))
packing.save("P.h5")
again = sonopack.Packing.read("P.h5")
assert again.hash == packing.hash and again.network().front().t10 > 0
print(sonopack.__file__, sonopack.__version__)
"""


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-python-") as folder:
        scratch = pathlib.Path(folder)
        subprocess.run([CMAKE, "--install", BUILD, "--prefix", scratch / "first"], check=True, stdout=subprocess.DEVNULL)
        (scratch / "first").rename(scratch / "moved")
        package = scratch / "moved" / PYTHON_DIR / "sonopack"
        files = sorted(path.name for path in package.iterdir())
        assert {"__init__.py", "py.typed", "_native.abi3.so", "_native.pyi", "_records.py"} <= set(files), files
        assert not any(path.is_symlink() for path in package.iterdir()), "links into the build folder"
        result = subprocess.run([sys.executable, "-B", "-c", PROGRAM], cwd=scratch, text=True, capture_output=True,
                                env=dict(os.environ, PYTHONPATH=str(package.parent)))
        assert result.returncode == 0, result.stderr
        where, version = result.stdout.split()
        assert where == str(package / "__init__.py"), where
        command = subprocess.run([scratch / "moved/bin/sonopack", "--version"], text=True, capture_output=True, check=True)
        assert command.stdout.split()[1] == version, (command.stdout, version)
        print("imported from an installation")


if __name__ == "__main__":
    main()
