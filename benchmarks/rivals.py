#!/usr/bin/python3
"""The cost of the same work by other programs: SciPy, and SLEPc if installed (python3-slepc4py), on one thread.

    rivals.py [build/release/sonopack] [PACKING.txt ...] -o TABLE.tsv [--join bench.tsv]

The rows are like those of `sonopack bench`, for the cases signal (T = 400, 801 times), modes, lowest10, lowest100
(frequencies and vectors), frequencies and moduli. A method is named by its program, a blank and its own name. The
networks are assembled here from the files of the packings. Errors: of signals the largest difference from `sonopack
signal` at 1e-12 over the peak; of frequencies the largest relative one from Rayleigh quotients of all modes as sums of
squares over the springs; of moduli that of C22. --join puts the rows of another table in front.
"""
import argparse
import glob
import os
import resource
import subprocess
import sys
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"
sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, "..", "tests", "cli"), *glob.glob("/usr/lib/*dir/*/*-real/lib/python3/dist-packages")]

import numpy as np
import scipy.integrate
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from network_oracle import Network

try:
    import slepc4py
    slepc4py.init([])
    from petsc4py import PETSc
    from slepc4py import SLEPc
except ImportError:
    SLEPc = None

HEADER = ("case", "method", "parameter", "seconds", "error", "memory_MB")
UNTIL, POINTS = 400.0, 801


class Subject:
    """One packing: its matrices, and the reference results."""

    def __init__(self, command, path):
        self.name = os.path.basename(path)
        net = self.net = Network(path)
        self.t = np.linspace(0, UNTIL, POINTS)
        self.mass = net.mass
        root = np.sqrt(net.mass)
        self.k = scipy.sparse.csc_matrix(net.matrix)
        self.a = scipy.sparse.csc_matrix(net.matrix / np.outer(root, root))
        self.sent, self.seen = net.source / root, net.detector / root
        self.omega = np.sort(net.frequencies())
        words = [command, "signal", path, "--until", f"{UNTIL:g}", "--points", str(POINTS), "--method", "chebyshev",
                 "--tolerance", "1e-12", "--quiet"]
        lines = subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()
        rows = [line.split("\t") for line in lines if not line.startswith("#")][1:]
        self.f = np.array([float(row[1]) for row in rows])

    def signal_error(self, f):
        return np.abs(f - self.f).max() / np.abs(self.f).max()

    def frequency_error(self, squares):
        omega = np.sqrt(np.maximum(np.sort(squares), 0))
        return np.abs(omega / self.omega[:len(omega)] - 1).max()


# ---- signals ----------------------------------------------------------------------------------------------------------


def first_order(s):
    n = len(s.mass)
    return scipy.sparse.bmat([[None, scipy.sparse.identity(n)], [-s.a, None]], format="csr")


def start(s):
    return np.concatenate([np.zeros(len(s.mass)), s.sent])


def dop853(s, tolerance):
    a, n = s.a, len(s.mass)
    done = scipy.integrate.solve_ivp(lambda t, y: np.concatenate([y[n:], -(a @ y[:n])]), (0, UNTIL), start(s), "DOP853",
                                     s.t, rtol=tolerance, atol=tolerance * np.abs(s.sent).max())
    return s.signal_error(s.seen @ done.y[:n])


def expm_multiply(s, _):
    states = scipy.sparse.linalg.expm_multiply(first_order(s), start(s), 0, UNTIL, POINTS)
    return s.signal_error(states[:, :len(s.mass)] @ s.seen)


def modal_sum(s, squares, vectors):
    omega = np.sqrt(squares)
    return np.sin(np.outer(s.t, omega)) @ ((vectors.T @ s.sent) * (vectors.T @ s.seen) / omega)


def eigh_signal(s, _):
    return s.signal_error(modal_sum(s, *scipy.linalg.eigh(s.a.toarray(), driver="evd")))


def eigsh_signal(s, count):
    return s.signal_error(modal_sum(s, *scipy.sparse.linalg.eigsh(s.a, int(count), sigma=0)))


# ---- modes ------------------------------------------------------------------------------------------------------------


def eigh_modes(s, _):
    return s.frequency_error(scipy.linalg.eigh(s.a.toarray(), driver="evd")[0])


def eigh_frequencies(s, _):
    return s.frequency_error(scipy.linalg.eigh(s.a.toarray(), eigvals_only=True))


def eigsh_modes(s, count):
    return s.frequency_error(scipy.sparse.linalg.eigsh(s.a, int(count), sigma=0)[0])


def slepc_modes(s, count):
    a = s.a.tocsr()
    matrix = PETSc.Mat().createAIJ(size=a.shape, csr=(a.indptr, a.indices, a.data))
    matrix.setOption(PETSc.Mat.Option.SPD, True)
    solver = SLEPc.EPS().create()
    solver.setOperators(matrix)
    solver.setProblemType(SLEPc.EPS.ProblemType.HEP)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setTarget(0)
    solver.setDimensions(int(count))
    solver.setTolerances(1e-10)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    ksp = transform.getKSP()
    ksp.setType("preonly")
    ksp.getPC().setType("cholesky")
    solver.solve()
    squares = [solver.getEigenvalue(k).real for k in range(int(count))]
    return s.frequency_error(squares)


# ---- moduli -----------------------------------------------------------------------------------------------------------


def superlu_moduli(s, _):
    net = s.net
    factor = scipy.sparse.linalg.splu(s.k)
    relaxed = factor.solve(-net.b.T @ (net.k[:, None] * net.affine))
    stretch = net.b @ relaxed + net.affine
    c = net.affine.T @ (net.k[:, None] * stretch) / (net.width * net.height)
    return abs(c[1, 1] / net.moduli()[1, 1] - 1)


NAN = float("nan")
WORK = [("signal", "scipy DOP853", dop853, (1e-3, 1e-6, 1e-9, 1e-12)),
        ("signal", "scipy expm_multiply", expm_multiply, (NAN,)), ("signal", "scipy eigh", eigh_signal, (NAN,)),
        ("signal", "scipy eigsh", eigsh_signal, (50, 200)),
        ("modes", "scipy eigh", eigh_modes, (NAN,)), ("frequencies", "scipy eigh", eigh_frequencies, (NAN,)),
        ("lowest10", "scipy eigsh", eigsh_modes, (10,)), ("lowest100", "scipy eigsh", eigsh_modes, (100,)),
        ("moduli", "scipy superlu", superlu_moduli, (NAN,))]
if SLEPc:
    WORK += [("lowest10", "slepc krylovschur", slepc_modes, (10,)),
             ("lowest100", "slepc krylovschur", slepc_modes, (100,))]


def measure(run, s, parameter):
    """Median of up to 5 runs (one if it takes a second), and growth of the resident set in the first. They run in a
    child process, because memory that a process has freed to its own heap would not count as growth again."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        seconds = []
        while not seconds or (len(seconds) < 5 and sum(seconds) < 1):
            clock = time.process_time()
            error = run(s, parameter)
            seconds.append(time.process_time() - clock)
            if len(seconds) == 1:
                grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        os.write(writer, f"{np.median(seconds)!r} {float(error)!r} {grown!r}".encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as told:
        text = told.read()
    os.waitpid(child, 0)
    return [float(word) for word in text.split()] or [NAN, NAN, NAN]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", nargs="?", default=os.path.join(HERE, "..", "build", "release", "sonopack"))
    parser.add_argument("packing", nargs="*")
    parser.add_argument("--cases", nargs="+", help="only these")
    parser.add_argument("--join", metavar="TSV", help="rows that go in front, those of `sonopack bench'")
    parser.add_argument("--output", "-o", metavar="TSV", help="instead of stdout")
    given = parser.parse_args()
    reference = os.path.join(HERE, "..", "packings", "reference")
    paths = given.packing or [os.path.join(reference, f"packing_N{n}_p1e-4.txt") for n in (200, 600)]
    lines = open(given.join).read().splitlines() if given.join else ["\t".join(HEADER)]
    for path in paths:
        s = Subject(given.command, path)
        for case, method, run, parameters in WORK:
            if given.cases and case not in given.cases:
                continue
            for parameter in parameters:
                seconds, error, megabytes = measure(run, s, parameter)
                lines.append("\t".join([f"{case}:{s.name}", method, *(f"{x:.6g}" for x in (parameter, seconds, error,
                                                                                         megabytes))]))
                print(lines[-1], file=sys.stderr)
    text = "\n".join(lines) + "\n"
    if given.output:
        with open(given.output, "w") as out:
            out.write(text)
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
