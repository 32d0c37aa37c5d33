"""Files of modes seen from outside: K u = omega^2 M u with K built by numpy, the units and meanings of all datasets, and
forged, damaged and foreign files, each of which must give its reason (exit status 1) and never a crash or a figure."""
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import zlib

import h5py
import numpy as np

TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / "cli"), str(TESTS / "oracle"), str(pathlib.Path(sys.argv[1]).parent / "python")]
import physics  # noqa: E402
from command import sanitized  # noqa: E402
from common import names_all, packed_zeros  # noqa: E402
from network_oracle import Network  # noqa: E402

os.environ["MPLBACKEND"] = "Agg"
from sonopack.plot import command as plotting  # noqa: E402
from sonopack._command import start  # noqa: E402

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
PACKING = SOURCE / "packings" / "reference" / "packing_N200_p1e-4.txt"
FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-modes-"))
SEED = 20261122


if not sanitized():  # such a build maps terabytes
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))  # a file must not make the reader ask for the moon


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stderr)
    return done


def plot(*args):
    """`sonopack plot` in a fork of this process, which has drawn before: the same code without a second of imports for
    each forgery. Exit status (negative: a signal) and what went to stderr."""
    errors = FOLDER / "stderr"
    child = os.fork()
    if child == 0:
        os.dup2(os.open(errors, os.O_CREAT | os.O_WRONLY | os.O_TRUNC), 2)
        sys.argv = ["sonopack", *map(str, args)]
        start("plot")
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return status, errors.read_text()


def table(text):
    lines = text.splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    data = np.array(rows[1:], float)
    return comments, {name: data[:, c] for c, name in enumerate(rows[0])}


GOOD, PRINTED = FOLDER / "good.h5", FOLDER / "good.tsv"
run("modes", PACKING, "--vectors", GOOD, "-o", PRINTED)
DRAWN = ["mode", str(PACKING), str(GOOD), "--mode", "80", "-o", str(FOLDER / "first.png")]
plotting.run(plotting.parser().parse_intermixed_args(DRAWN))  # what a drawing imports, once for all forks


def equation_of_motion():
    comments, printed = table(PRINTED.read_text())
    net = Network(PACKING)
    k = (net.b.T * net.k) @ net.b
    with h5py.File(GOOD) as f:
        g = f["modes"]
        assert g.attrs["format"] == 1
        for name, d in g.items():
            assert d.attrs["unit"] and len(d.attrs["description"]) > 10, name
        assert g["vector"].chunks == (1, g["vector"].shape[1]) and g["vector"].fletcher32
        mass, rattlers = g["mass"][:], g["n_rattler"][()]
        assert np.allclose(mass, net.mass, rtol=1e-14)
        assert np.array_equal(g["grain"][:], net.alive)
        assert np.array_equal(np.sort(np.concatenate([g["grain"][:], g["rattler"][:]])), np.arange(200))
        assert np.array_equal(g["column"][:, 0], np.repeat(net.alive, 3))
        assert np.array_equal(g["column"][:, 1], np.tile([0, 1, 5], len(net.alive)))
        omega, e = g["omega"][:], g["vector"][:]
        u = e / np.sqrt(mass)
        top = omega[-1] ** 2
        worst = np.abs(u @ k - omega[rattlers:, None] ** 2 * (u * mass)).max() / top
        assert worst < 1e-13, worst
        assert np.abs(e @ e.T - np.eye(len(e))).max() < 1e-12 and g["orthogonality"][()] < 1e-12
        assert np.all(e[np.arange(len(e)), np.abs(e).argmax(1)] > 0)  # the sign
        # a and b from the vectors, and what is printed
        with np.errstate(divide="ignore", invalid="ignore"):
            a = np.where(omega[rattlers:] > 0, u @ net.source / omega[rattlers:], 0)
        assert np.allclose(g["a"][rattlers:], a, rtol=1e-8, atol=1e-10)
        assert np.allclose(g["b"][rattlers:], u @ net.detector, rtol=1e-8, atol=1e-10)
        for name in ("omega", "error", "a", "b", "participation"):
            assert np.array_equal(g[name][:], printed[name]), name
        w = (e ** 2).reshape(len(e), -1, 3).sum(2)
        assert np.allclose(g["participation"][rattlers:], 1 / (w.shape[1] * (w ** 2).sum(1)), rtol=1e-10)
        assert g["n_zero"][()] == int(comments["zero_modes"]) and g["first"][()] == 0
        print(f"K u = omega^2 M u within {worst:.1g}")


def part_of_a_spectrum():
    path = FOLDER / "band.h5"
    run("modes", PACKING, "--band", "0.3:0.5", "--vectors", path, "-o", FOLDER / "band.tsv")
    with h5py.File(path) as f, h5py.File(GOOD) as whole:
        g, first = f["modes"], f["modes/first"][()]
        n = len(g["omega"])
        assert first > 0 and g["n_rattler"][()] == 0 and g["solver"][()] == b"lanczos"
        assert g["certified_from"][()] <= 0.3 and g["certified_to"][()] >= 0.5
        rows = slice(first - whole["modes/n_rattler"][()], first - whole["modes/n_rattler"][()] + n)
        e, v = g["vector"][:], whole["modes/vector"][rows]
        far = np.minimum(np.linalg.norm(e - v, axis=1), np.linalg.norm(e + v, axis=1))
        assert np.all(far <= g["vector_error"][:] + whole["modes/vector_error"][rows])
    u = FOLDER / "u.tsv"
    run("modes", PACKING, "--band", "0.3:0.5", "--vectors", u, "--mode", first + 2, "-o", FOLDER / "band2.tsv")
    comments, t = table(u.read_text())
    with h5py.File(path) as f:
        shown = f["modes/vector"][2] / np.sqrt(f["modes/mass"][:])
        assert np.array_equal(np.column_stack([t["ux"], t["uy"], t["rz"]]).ravel(), shown)
        assert float(comments["omega"]) == f["modes/omega"][2] and int(comments["mode"]) == first + 2
        assert float(comments["vector_error"]) == f["modes/vector_error"][2]
    run("modes", PACKING, "--band", "0.3:0.5", "--vectors", u, "--mode", 0, "--force", status=2)


def spheres():
    packing, path, figure = FOLDER / "spheres.h5", FOLDER / "sv.h5", FOLDER / "s.svg"
    run("pack", SOURCE / "packings" / "spheres.cfg", "-q", "-o", packing, "--set", "packing.grains=50", "--set",
        "packing.width=4", "--set", 'packing.protocol="quick"')
    run("modes", packing, "--vectors", path, "-o", FOLDER / "sm.tsv")
    with h5py.File(path) as f:
        g = f["modes"]
        net = physics.Network(physics.Packing(packing))
        assert np.array_equal(net.grains, g["grain"][:])
        k = net.k.astype(float)
        mass, omega = g["mass"][:], g["omega"][g["n_rattler"][()]:]
        assert g["freedoms"][()] == 6 and np.array_equal(g["column"][:6, 1], np.arange(6))
        u = g["vector"][:] / np.sqrt(mass)
        worst = np.abs(u @ k - omega[:, None] ** 2 * (u * mass)).max() / omega[-1] ** 2
    assert worst < 1e-12, worst
    run("plot", "mode", packing, path, "-o", figure)
    assert "clockwise" in figure.read_text() and "rattler" in figure.read_text()
    print(f"spheres: K u = omega^2 M u within {worst:.1g}")


def growing():
    """Prestress and friction: J e = z M e and the same from the left with J of numpy, biorthogonal vectors, and the same
    rows in all, the lowest and a band of motions; one as a table is drawn, a file of them is refused with the way out."""
    packing, text, path, shown = (FOLDER / name for name in ("g.h5", "g.txt", "gv.h5", "g.tsv"))
    run("pack", "-q", "-o", packing, *(word for key in (
        "grains=150", "width=10", "pressure=1e-2", "friction=0.8", "poisson=0", 'protocol="quick"') for word in ("--set", f"packing.{key}")))
    run("convert", packing, text)
    net, pairs = Network(text, prestress=True), []
    root = np.sqrt(net.mass)
    a = net.turned / np.outer(root, root)
    top = np.linalg.norm(a, 2)
    for words in ([], ["--lowest", 20, "--solver=lanczos"], ["--band=1.2:1.6"], ["--band=0.1:0.3", "--solver=lanczos"]):
        run("modes", packing, "--prestress", *words, "--vectors", path, "-o", shown, "--force")
        comments, printed = table(shown.read_text())
        with h5py.File(path) as f:
            g = {name: d[()] for name, d in f["modes"].items()}
            assert f["modes"].attrs["format"] == 2 and all(d.attrs["unit"] and d.attrs["description"] for d in f["modes"].values())
        e, left = g["vector"] + 1j * g["vector_imaginary"], g["left"] + 1j * g["left_imaginary"]
        z, rows = -(g["growth"] + 1j * g["omega"]) ** 2, len(g["omega"])
        far = [np.linalg.norm(off, axis=1).max() for off in (
            e @ a.T - z[:, None] * e, (left @ a - z[:, None] * left) / np.linalg.norm(left, axis=1)[:, None])]
        assert max(far) <= g["residual"] * net_top(net) + 1e-13 * top and g["residual"] < 1e-10, (words, far)
        once = np.unique(z, return_index=True)[1]
        apart = np.abs(left[once] @ e[once].T - np.eye(len(once))).max()
        assert abs(apart - g["orthogonality"]) < 1e-13 and apart < 1e-10 and np.abs(np.linalg.norm(e, axis=1) - 1).max() < 1e-13
        most = e[np.arange(rows), np.abs(e).argmax(1)]
        assert np.all(most.real > 0) and np.abs(most.imag).max() < 1e-15
        for name in ("omega", "growth", "error", "cosine", "sine"):
            assert np.array_equal(g[name], printed[name]), name
        assert printed["n"][0] == g["first"] and np.allclose(g["mass"], net.mass, rtol=1e-14) and rows > 10
        whole = whole if words else printed
        apart = np.abs(whole["omega"][int(g["first"]):][:rows] - g["omega"])
        assert np.all(apart <= g["error"] + whole["error"][int(g["first"]):][:rows]), words
        if words[:1] == ["--band=0.1:0.3"]:
            assert np.array_equal(printed["n"], np.flatnonzero((whole["omega"] >= 0.1) & (whole["omega"] <= 0.3)))
            assert comments["method"] == "sparse" and float(comments["complete"].split(":")[1]) > 0.3
        pairs.append(int(comments["pairs"]))
    assert pairs[0] > 0 and pairs[2] > 0, pairs
    number = int(printed["n"][3])
    run("modes", packing, "--prestress", "--band=0.1:0.3", "--vectors", FOLDER / "gu.tsv", "--mode", number, "-o", shown, "--force")
    u = table((FOLDER / "gu.tsv").read_text())[1]
    same = np.column_stack([u["ux"], u["uy"], u["rz"]]).ravel() * root
    assert min(np.abs(same - s * e[3].real).max() for s in (1, -1)) < 1e-7
    assert plot("mode", packing, FOLDER / "gu.tsv", "-o", FOLDER / "g.svg")[0] == 0
    status, said = plot("mode", packing, path, "-o", FOLDER / "no.svg")
    assert status == 1 and "--vectors FILE.tsv --mode N" in said, said
    run("modes", packing, "--prestress", "--vectors", FOLDER / "gu.tsv", "--mode", 450, "-o", shown, "--force", status=2)


def growing_spheres():
    """Of the sparse solver a pair, whose vectors come with any phase."""
    packing, path = FOLDER / "gs.h5", FOLDER / "gsv.h5"
    run("pack", "-q", "-o", packing, *(word for key in (
        "dimension=3", "grains=230", "width=5", "pressure=1e-2", "friction=0.8", 'protocol="quick"') for word in ("--set", f"packing.{key}")))
    run("modes", packing, "--prestress", "--lowest", 25, "--solver=lanczos", "--vectors", path, "-o", FOLDER / "gs.tsv")
    with h5py.File(path) as f:
        g = {name: d[()] for name, d in f["modes"].items()}
    e, left = g["vector"] + 1j * g["vector_imaginary"], g["left"] + 1j * g["left_imaginary"]
    pair = g["growth"] > g["error"]
    assert g["pairs"] == np.sum(pair) > 0 and np.abs(e[pair].imag).max() > 1e-3
    most = e[np.arange(len(e)), np.abs(e).argmax(1)]
    assert np.all(most.real > 0) and np.abs(most.imag).max() < 1e-15
    assert np.abs(left @ e.T - np.eye(len(e))).max() < 1e-12


def net_top(net):
    """The square of the command's bound of all frequencies is at most this: Gershgorin's."""
    return 1.3 * np.abs(net.turned / np.sqrt(np.outer(net.mass, net.mass))).sum(1).max()


def command_lines():
    v = FOLDER / "v.h5"
    for words in (["--frequencies-only"], ["--stability"], ["--damping", 0.1], ["--mode", 80]):
        run("modes", PACKING, "--vectors", v, *words, status=2)
    run("modes", PACKING, "--vectors", FOLDER / "v.tsv", status=2)
    run("modes", PACKING, "--vectors", FOLDER / "v.txt", status=2)
    run("modes", PACKING, "--mode", 80, status=2)
    run("modes", PACKING, "--vectors", GOOD, status=2)  # exists
    run("modes", PACKING, "--vectors", FOLDER / "none" / "v.h5", status=1)
    assert not v.exists()


# ---- forgeries -------------------------------------------------------------------------------------------------------
def refuse(path, *parts):
    status, said = plot("mode", PACKING, path, "--mode", 80, "-o", FOLDER / "no.png", "--force")
    assert status == 1 and names_all(said, " ".join([path.name, *parts])) and said.count("\n") == 1, (status, parts, said)


def forge(change, *parts):
    copy = FOLDER / "forged.h5"
    shutil.copy(GOOD, copy)
    with h5py.File(copy, "r+") as f:
        change(f["modes"])
    refuse(copy, *parts)


def put(name, data, **options):
    def change(g):
        del g[name]
        g.create_dataset(name, data=data, **options)
    return change


def set_one(name, at, value):
    def change(g):
        g[name][at] = value
    return change


def forgeries():
    assert zlib.decompress(packed_zeros(3 << 20)) == bytes(3 << 20)
    with h5py.File(GOOD) as f:
        g = {name: d[()] for name, d in f["modes"].items()}
    n, dofs, rows = len(g["omega"]), len(g["mass"]), len(g["vector"])
    for name in ("omega", "error", "a", "b", "participation", "mass"):
        forge(set_one(name, 90, np.nan))
        forge(put(name, g[name][:-1]), *[f"/modes/{name}"][name == "omega":])
    for name in ("omega", "error", "participation", "mass"):
        forge(set_one(name, 90, -1.0))
    forge(set_one("omega", 90, 1e-3))
    forge(set_one("vector", (80 - g["n_rattler"], 7), np.nan), "80")
    forge(set_one("vector", (80 - g["n_rattler"], 7), 2.0), "80")
    forge(put("vector", g["vector"][:-1]))
    forge(put("vector", g["vector"][:, :-1]))
    forge(put("vector", g["vector"].ravel()), "/modes/vector")
    forge(put("vector", g["vector"].astype("f4").astype("i4")), "/modes/vector")
    forge(set_one("grain", 3, 1))
    forge(set_one("grain", -1, 200))
    forge(put("grain", g["grain"][:-1]))
    for name, value in (("n_rattler", -1), ("n_rattler", n + 1), ("n_zero", n + 1), ("first", -1), ("dimension", 3),
                        ("freedoms", 2), ("packing", 1), ("certified_from", np.nan), ("residual", np.nan)):
        forge(put(name, np.array(value, g[name].dtype)))
    forge(put("source", "loud"), "/modes/source", "loud")
    forge(lambda g: g.attrs.modify("format", 3), "3")
    for name in g:
        if name not in ("column", "rattler", "vector_error"):  # these are for readers; ours derives them
            forge(lambda f, name=name: f.__delitem__(name), f"/modes/{name}")
    # claims: data that are not there, and chunks that memory cannot hold
    def claim(g, chunks, shape, fill):
        del g["vector"]
        fill(g.create_dataset("vector", shape=shape, chunks=chunks, maxshape=(None, None), dtype="f8", compression="gzip"))

    def one_chunk(vector):
        vector.id.write_direct_chunk((0, 0), packed_zeros(3 << 30))

    def one_row(vector):
        vector[80 - 75, :5] = 1.0
    forge(lambda g: claim(g, (3 << 13, 1 << 14), (rows, dofs), one_chunk), "/modes/vector")
    forge(lambda g: claim(g, (1, dofs), (2 ** 31 - 1, dofs), one_row), "/modes/vector")
    # other layouts are read
    copy = FOLDER / "changed.h5"
    for options in ({"chunks": (rows, dofs), "compression": "gzip"}, {}, {"dtype": ">f8"}):
        shutil.copy(GOOD, copy)
        with h5py.File(copy, "r+") as f:
            put("vector", g["vector"].astype(options.pop("dtype", "<f8")), **options)(f["modes"])
        status, said = plot("mode", PACKING, copy, "--mode", 80, "-o", FOLDER / "yes.png", "--force")
        assert status == 0, (options, said)


def damage():
    whole, copy, rng = GOOD.read_bytes(), FOLDER / "damaged.h5", random.Random(SEED)
    for size in [0, 7, 47, 100, *(rng.randrange(len(whole)) for _ in range(6)), len(whole) - 1]:
        copy.write_bytes(whole[:size])
        refuse(copy)
    refused, at = 0, 0
    with h5py.File(GOOD) as f:  # the row that is drawn
        at = f["modes/vector"].id.get_chunk_info_by_coord((80 - int(f["modes/n_rattler"][()]), 0)).byte_offset
    for byte in [at + 5, at + 77] + [rng.randrange(len(whole)) for _ in range(10)]:
        damaged = bytearray(whole)
        damaged[byte] ^= 1 << rng.randrange(8)
        copy.write_bytes(damaged)
        status, said = plot("mode", PACKING, copy, "--mode", 80, "-o", FOLDER / "d.png", "--force")
        assert status in (0, 1), (byte, status, said)  # a byte of another row is not read
        refused += status
    assert refused >= 2
    shutil.copy(PACKING, copy)
    refuse(copy)
    packing = FOLDER / "packing.h5"
    run("convert", PACKING, packing)
    refuse(packing, "packing")


try:
    equation_of_motion()
    part_of_a_spectrum()
    spheres()
    growing()
    growing_spheres()
    command_lines()
    forgeries()
    damage()
finally:
    shutil.rmtree(FOLDER)
print("files of modes are right, or refused with a reason")
