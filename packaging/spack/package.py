from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Sonopack(CMakePackage):
    """Sound in compressed granular packings: signals, modes, moduli and speeds of frictional spheres in contact."""

    license("BSD-3-Clause AND GPL-2.0-or-later")
    version("main", branch="main")

    variant("mpi", default=False, description="Studies by mpirun")

    depends_on("c", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("suite-sparse")
    depends_on("arpack-ng")
    depends_on("openblas")
    depends_on("netlib-lapack+lapacke")
    depends_on("hdf5")
    depends_on("libconfig")
    depends_on("random123")
    depends_on("mpi", when="+mpi")
    extends("python@3.10:")
    for module in ("cffi", "numpy", "scipy", "pandas", "matplotlib", "h5py"):
        depends_on(f"py-{module}", type=("build", "run"))

    def cmake_args(self):
        python = self.spec["python"]
        return [self.define("SONOPACK_TESTS", False), self.define("SONOPACK_OWN_HDF5", False),
                self.define("SONOPACK_PYTHON", True), self.define("SONOPACK_PYTHON_COMMAND", python.command.path),
                self.define("SONOPACK_PYTHON_DIR", f"lib/python{python.version.up_to(2)}/site-packages"),
                self.define_from_variant("SONOPACK_MPI", "mpi")]
