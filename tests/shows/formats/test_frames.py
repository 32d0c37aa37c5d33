"""Packings of several frames: their numbers and strains go with them, through files, into the tables of commands."""
import math
import os
import pickle
import subprocess

import numpy as np
import pytest

from sonopack import Packing, Scene, SonopackError
from sonopack import formats
from sonopack.formats import command, frames
from test_rings import sonopack

FRAMES = {100: (0.0, 0.0), 250: (0.01, 0.02), 400: (0.03, 0.45)}  # compression along y, shear


@pytest.fixture(scope="module")
def first():
    return Packing.make(Scene(packing={"cell": "periodic", "grains": 60, "seed": 4, "pressure": 1e-3}))


@pytest.fixture(scope="module")
def movie(first, tmp_path_factory):
    """Three frames of a dump, and of its contacts, of which the cell is strained; the last is tilted by most of a period,
    and LAMMPS writes the lattice vector that is shorter by one."""
    folder, texts = tmp_path_factory.mktemp("movie"), {"g": "", "c": ""}
    width, height = first.box
    for step, (down, sheared) in FRAMES.items():
        tall = height * math.exp(-down)
        tilt = first.tilt[0] - sheared * height
        x = np.stack([first.x[:, 0] - sheared * first.x[:, 1], first.x[:, 1] * tall / height], axis=1)
        tilt -= width * round(tilt / width)
        low, high = min(0, tilt), width + max(0, tilt)
        box = f"ITEM: BOX BOUNDS xy xz yz pp pp pp\n{low!r} {high!r} {tilt!r}\n0 {tall!r} 0\n-0.5 0.5 0\n"
        texts["g"] += f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{first.n}\n{box}ITEM: ATOMS id x y z radius\n" + "".join(
            f"{k + 1} {a!r} {b!r} 0 {r!r}\n" for k, ((a, b), r) in enumerate(zip(x.tolist(), first.r.tolist())))
        c = first.contacts
        texts["c"] += f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ENTRIES\n{len(c)}\n{box}ITEM: ENTRIES id1 id2 fn kn kt\n" + "".join(
            f"{k['i'] + 1} {k['j'] + 1} {float(k['fn'])!r} 0.1 0.08\n" for k in c)
    for name, text in texts.items():
        (folder / name).write_text(text)
    return folder


def convert(*words):
    assert command.run(command.parser().parse_intermixed_args([*map(str, words), "--quiet"])) == 0


def table(*words):
    rows = [line.split("\t") for line in sonopack(*words).splitlines() if not line.startswith("#")]
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}


@pytest.fixture(scope="module")
def files(movie, tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    convert(movie / "g", folder / "P.h5", "--contacts", movie / "c", "--frame", "all", "--set", "friction=0.5")
    return [folder / f"P-{step}.h5" for step in FRAMES]


def expected(step):
    down, sheared = FRAMES[step]
    return {"e_xx": 0.0, "e_yy": down, "e_xy": sheared}


def test_python(files, movie):
    for path, step in zip(files, FRAMES):
        p = Packing.read(path)
        assert p.frame == step and p.strain == pytest.approx(expected(step), abs=1e-12)
    for p, step in zip(formats.series(movie / "g", contacts=movie / "c", friction=0.5), FRAMES):
        assert p.frame == step and p.strain == pytest.approx(expected(step), abs=1e-12)
    assert math.isnan(Packing.read(movie / "g", contacts=movie / "c", friction=0.5).frame)


@pytest.mark.parametrize("words", [["statics"], ["moduli"], ["moduli", "--probe", "global"]])
def test_tables(files, words):
    found = table(*words, *files)
    assert list(map(float, found["frame"])) == list(FRAMES) and list(found)[-4:] == ["frame", "e_xx", "e_yy", "e_xy"]
    for name in ("e_xx", "e_yy", "e_xy"):
        assert list(map(float, found[name])) == pytest.approx([expected(step)[name] for step in FRAMES], abs=1e-9)


@pytest.mark.parametrize("ending", [".h5", ".txt", ".tsv"])
def test_files_keep_them(first, tmp_path, ending):
    """Ours do; a packing of no series has the bytes of one that never was of any."""
    def save(p, name):
        path = tmp_path / f"{name}{ending}"
        (p.save_tables(path, tmp_path / f"{name}-contacts.tsv") if ending == ".tsv" else p.save(path))
        return path
    p = Packing.read(save(first, "plain")) if ending != ".tsv" else pickle.loads(pickle.dumps(first))
    p.set_series(1e9 + 1, {"e_xx": 0.1, "e_xy": -1e-3})
    path = save(p, "series")
    q = Packing.read_tables(path, tmp_path / "series-contacts.tsv") if ending == ".tsv" else Packing.read(path)
    assert q.frame == 1e9 + 1 and q.strain == {"e_xx": 0.1, "e_xy": -1e-3} and q.hash == first.hash
    assert pickle.loads(pickle.dumps(q)).strain == q.strain
    q.set_series(math.nan, {})
    assert save(q, "again").read_bytes() == save(first, "plain").read_bytes()


def test_a_series_of_ours(files, first, tmp_path):
    """Packings that have frames and strains keep them; of a single one without it has none."""
    for path in files:
        (tmp_path / path.name).write_bytes(path.read_bytes())
    for p, step in zip(formats.series(tmp_path), FRAMES):
        assert p.frame == step and p.strain == pytest.approx(expected(step), abs=1e-12) and p.strain["e_xx"] == 0
    first.save(tmp_path / "one.h5")
    assert [math.isnan(p.frame) for p in formats.series(tmp_path / "one.h5")] == [True]


@pytest.mark.parametrize("frame, strain, words", [(math.inf, {}, "frame: inf"), (1, {"e_yy": -math.inf}, "e_yy: -inf"),
                                                  (1, {"exx": 0.1}, "exx: 0.1: .* one of e_xx e_yy")])
def test_refused_places(first, frame, strain, words):
    with pytest.raises(SonopackError, match=words):
        pickle.loads(pickle.dumps(first)).set_series(frame, strain)


def test_files_of_infinite_frames(first, tmp_path):
    first.save(tmp_path / "p.h5")
    p = Packing.read(tmp_path / "p.h5")
    p._c.strain[1] = math.inf
    with pytest.raises(SonopackError, match="a strain since the first: must be finite"):
        p.save(tmp_path / "q.h5")


def test_the_first_packing_decides(files, first, tmp_path):
    first.save(tmp_path / "p.h5")
    found = table("statics", files[1], tmp_path / "p.h5")
    assert found["frame"] == ["250", "nan"] and found["e_yy"][1] == "nan"
    assert "frame" not in table("statics", tmp_path / "p.h5", files[1])
    p = Packing.read(tmp_path / "p.h5")
    p.set_series(5, {"e_yy": 0.1})
    p.save(tmp_path / "walls.h5")
    said = [subprocess.run([os.environ["SONOPACK"], "statics", *order], text=True, capture_output=True).stderr
            for order in ((tmp_path / "walls.h5", files[1]), (files[1], tmp_path / "walls.h5"))]
    assert f"{files[1]}: its frame or strain is left out" in said[0] and said[1] == ""


def test_fronts_and_other_tables(tmp_path):
    """`front` and `check` read packings themselves; a trace has no frame, and a spectrum of one packing no column of it."""
    p = Packing.make(Scene(packing={"grains": 80, "width": 8, "seed": 3}))
    p.set_series(7, {"e_yy": 0.5})
    p.save(tmp_path / "p.h5")
    sonopack("signal", tmp_path / "p.h5", "--points", 200, "-o", tmp_path / "trace.tsv")
    found = table("front", tmp_path / "p.h5", tmp_path / "trace.tsv")
    assert found["frame"] == ["7", "nan"] and found["e_yy"] == ["0.5", "nan"] and "width" in found
    assert table("check", tmp_path / "p.h5")["frame"] == ["7"]
    assert "frame" not in table("modes", tmp_path / "p.h5", "--lowest", 2)


def test_walls(tmp_path):
    """Edges of a box, in the units of the file: grains that grow are no strain."""
    together = frames.Series()
    for frame, (height, size) in enumerate(((8.0, 1.0), (7.2, 1.0), (7.2, 2.0))):
        p = Packing.from_arrays([[1, 1], [2, 1]], [0.5, 0.5], {"i": [0], "j": [1], "overlap": [1e-3]}, box=(6 / size, height / size),
                                pressure=1e-3, friction=0, cell="box")
        p.report = formats.Report(scale=1 / size)
        together.add(p, frame)
        assert p.frame == frame and p.strain == pytest.approx({"e_xx": 0, "e_yy": math.log(8.0 / height)})
