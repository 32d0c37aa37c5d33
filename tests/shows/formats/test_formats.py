"""Files of other programs in Python: round trips of every form, frames, gzip, refusals, and the predecessor's numbers."""
import gzip
import math
import os
import pathlib
import signal

import numpy as np
import pytest

import sonopack
from sonopack import Material, Packing, SonopackError, formats

GLASS = Material(70e9, 0.22, 2500.0, 1e-3)
FIELDS = ("i", "j", "n", "overlap", "fn", "ft", "kn", "kt", "mu")


@pytest.fixture(scope="module")
def samples(source):
    return source / "tests" / "foreign" / "samples"


@pytest.fixture(scope="module")
def layer(samples):
    """LAMMPS' layer of 72 disks, with friction."""
    return Packing.read(samples / "lammps" / "layer_grains.dump", contacts=samples / "lammps" / "layer_contacts.dump",
                        types=1, friction=0.5)


@pytest.fixture(scope="module")
def packings(layer, samples):
    """One of each cell, law and dimension."""
    beads = Packing.read(samples / "lammps" / "beads_grains.dump", contacts=samples / "lammps" / "beads_contacts.dump",
                         types=1, friction=0.5, material=Material(1e9, 0.22, 2500.0, 0.0))
    sheared = Packing.read(samples / "lammps" / "sheared_grains.dump", contacts=samples / "lammps" / "sheared_contacts.dump",
                           friction=0.5)
    box = Packing.read(samples / "lammps" / "box_grains.dump", contacts=samples / "lammps" / "box_contacts.dump", friction=0.5)
    chain = Packing.make(sonopack.Scene(packing={"kind": "chain", "dimension": 1, "grains": 8}))
    types = {"fraction": [0.5, 0.5], "density": [1, 3], "modulus": [2, 3], "friction": [0.2, 0.4, 0.5]}
    disks = Packing.make(sonopack.Scene(packing={"grains": 60, "width": 8, "shape": "disk", "types": types}))
    return {"layer": layer, "beads": beads, "sheared": sheared, "box": box, "chain": chain, "disks": disks}


def same(a, b):
    """Every bit of two packings, but for what no file says."""
    assert (a.dim, a.n, a.cell, a.wall, a.box, a.tilt) == (b.dim, b.n, b.cell, b.wall, b.box, b.tilt)
    assert (a.pressure, a.friction, a.poisson, a.gravity) == (b.pressure, b.friction, b.poisson, b.gravity)
    assert np.array_equal(a.x, b.x) and np.array_equal(a.r, b.r)
    assert np.array_equal(a.mass, b.mass) and np.array_equal(a.inertia, b.inertia)
    for field in FIELDS:
        assert np.array_equal(a.contacts[field], b.contacts[field]), field


# ---- the predecessor's numbers --------------------------------------------------------------------------------------

#: written by the program in C: grains, contacts, pressure, sum of the normal forces, hash of all bits
PREDECESSOR = {
    "layer": (72, 106, 9.999999996008811e-05, 0.012661456803959754, 4248726168344433532),
    "beads": (81, 177, 9.515999984982282e-05, 0.018969063445723786, 2592863925113482140),
    "sheared": (73, 238, 0.003835719428760033, 0.7248493167351263, 2040450062533629687),
    "box": (42, 86, 0.0034984764925938, 0.3409195589592115, 6739085306088366877),
}


@pytest.mark.parametrize("name", PREDECESSOR)
def test_numbers_of_the_predecessor(packings, name):
    p = packings[name]
    assert (p.n, len(p.contacts), p.pressure, math.fsum(p.contacts["fn"]), p.hash) == PREDECESSOR[name]


def test_report(layer):
    lines = layer.report.lines("layer.dump")
    assert lines[0] == ("layer.dump: lammps-dump, 72 grains, 106 contacts, 11 of them with walls; largest net force 3.2e-09 of "
                        "the mean; normal forces follow Hertz's law within 7.3e-13")
    assert lines[1] == "1 grain of other types is left out" and "elastic" in lines[2] and "torques" in lines[3]


# ---- round trips ----------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("ending", [".vtp", ".mat", ".csv"])
@pytest.mark.parametrize("name", ["layer", "beads", "sheared", "box", "chain", "disks"])
def test_whole_packings_come_back(packings, tmp_path, ending, name):
    packings[name].save(tmp_path / f"p{ending}")
    same(Packing.read(tmp_path / f"p{ending}"), packings[name])


@pytest.mark.parametrize("ending", [".vtp", ".mat", ".csv"])
def test_si_comes_back(layer, tmp_path, ending):
    p = layer.of_material(GLASS)
    p.save(tmp_path / f"p{ending}", si=True)
    with pytest.raises(SonopackError, match="material"):
        Packing.read(tmp_path / f"p{ending}")
    back = Packing.read(tmp_path / f"p{ending}", material=GLASS)
    assert np.allclose(back.x, p.x, rtol=1e-15) and np.allclose(back.contacts["fn"], p.contacts["fn"], rtol=1e-14)
    assert back.pressure == pytest.approx(p.pressure, rel=1e-15) and (back.contacts["kn"] == 0).all()


@pytest.mark.parametrize("ending", [".data", ".dump", ".xyz"])
def test_grains_come_back(packings, tmp_path, ending):
    """These forms have grains alone: contacts are those that overlap, forces Hertz's."""
    for name in ("layer", "sheared", "box"):
        p = packings[name]
        p.save(tmp_path / f"p{ending}")
        keys = {"friction": p.friction, "wall": p.wall, "cell": p.cell, "dimension": p.dim}
        back = Packing.read(tmp_path / f"p{ending}", **keys, **({"top": p.height} if name == "layer" else {}))
        assert np.allclose(back.x, p.x, atol=1e-14) and np.array_equal(back.r, p.r)
        assert np.array_equal(back.contacts["j"], p.contacts["j"])
        assert np.allclose(back.contacts["fn"], p.contacts["fn"], rtol=1e-7)


@pytest.mark.parametrize("name", ["p.vtp", "p.xyz", "p.dump", "p.data", "p.mat", "p.csv"])
def test_gzip(layer, tmp_path, name):
    layer.save(tmp_path / name)
    layer.save(tmp_path / f"{name}.gz")
    assert gzip.open(tmp_path / f"{name}.gz").read() == (tmp_path / name).read_bytes()
    packed = formats.files_for(formats.form_for(name), str(tmp_path / f"{name}.gz"))
    assert all(pathlib.Path(file).is_file() for file in packed)
    if name not in ("p.dump", "p.data"):
        plain = Packing.read(tmp_path / name)
        for file in formats.files_for(formats.form_for(name), str(tmp_path / name)):
            pathlib.Path(file).unlink()  # what lies beside a packed file is packed too
        same(Packing.read(tmp_path / f"{name}.gz"), plain)


@pytest.mark.parametrize("name", ["p.h5", "p.txt"])
def test_own_files_are_not_packed(layer, tmp_path, name):
    layer.save(tmp_path / name)
    (tmp_path / f"{name}.gz").write_bytes(gzip.compress((tmp_path / name).read_bytes()))
    with pytest.raises(SonopackError, match=f"{name}.gz: is packed by gzip; must be unpacked"):
        Packing.read(tmp_path / f"{name}.gz")
    with pytest.raises(SonopackError, match=f"other-{name}.gz: .* takes no .gz"):
        layer.save(tmp_path / f"other-{name}.gz")


def test_death_of_a_reader(layer, tmp_path, monkeypatch):
    """scipy's reader of MAT-files may die of a damaged one."""
    import scipy.io
    layer.save(tmp_path / "p.mat")
    for die in (lambda *_, **__: os.kill(os.getpid(), signal.SIGKILL), lambda *_, **__: os._exit(0)):
        monkeypatch.setattr(scipy.io, "loadmat", die)
        with pytest.raises(SonopackError, match="p.mat: is damaged or cut: its tags do not fit its size"):
            Packing.read(tmp_path / "p.mat")


def test_same_bytes_on_every_run(layer, tmp_path):
    for ending in formats.ENDINGS:
        layer.save(tmp_path / f"a{ending}")
        layer.save(tmp_path / f"b{ending}")
        if ending != ".vtp":
            assert (tmp_path / f"a{ending}").read_bytes() == (tmp_path / f"b{ending}").read_bytes()


# ---- frames ---------------------------------------------------------------------------------------------------------

def frame(step, shift=0.0):
    return (f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp ff pp\n0 4\n0 1\n-0.5 0.5\n"
            "ITEM: ATOMS id type x y z radius\n" +
            "".join(f"{k + 1} 1 {0.5 + 0.9999 * k} {0.4999 + shift} 0 0.5\n" for k in range(3)))


def test_frames(tmp_path):
    (tmp_path / "a.dump").write_text(frame(10) + frame(20, 1e-5) + frame(30, 2e-5))
    words = {"friction": 0, "digits": "exact"}
    found = list(formats.series(tmp_path / "a.dump", **words))
    assert formats.frames_of(tmp_path / "a.dump") == [10, 20, 30]
    assert [p.x[0, 1] for p in found] == [0.4999, 0.4999 + 1e-5, 0.4999 + 2e-5]
    assert Packing.read(tmp_path / "a.dump", frame=20, **words).x[0, 1] == 0.4999 + 1e-5
    last = Packing.read(tmp_path / "a.dump", **words)
    assert any("3 frames: the last, 30" in line for line in last.report.notes)
    for k in range(3):
        (tmp_path / f"b{k}.dump").write_text(frame(k, k * 1e-5))
    assert len(list(formats.series(tmp_path / "b*.dump", **words))) == 3
    with pytest.raises(SonopackError, match="no frame 15; it has 3, 10 .. 30"):
        Packing.read(tmp_path / "a.dump", frame=15, **words)


# ---- refusals -------------------------------------------------------------------------------------------------------

GOOD = frame(1)
REFUSED = {  # content of a.dump: what the message says
    "cut between rows": (GOOD[:GOOD.index("3 1 2.49")], r"a\.dump:11: the file ends after 2 of 3 rows"),
    "cut in the last number": (GOOD[:-2], r"a\.dump:12: .*ends inside"),
    "a cell less": (GOOD.replace("1 1 0.5 ", "1 1 "), r"a\.dump:10: 5 cells; must be 6"),
    "NaN": (GOOD.replace("1.4999 ", "nan "), r"a\.dump:11: column x is 'nan'"),
    "infinite": (GOOD.replace("1.4999 ", "1e999 "), r"a\.dump:11: column x is '1e999'"),
    "huge count": (GOOD.replace("ATOMS\n3", "ATOMS\n999999999"), r"a\.dump:12: .*3 of 999999999"),
    "no radius": (GOOD.replace("radius", "q"), "no column for radius; its columns are: id type x y z q"),
    "id twice": (GOOD.replace("2 1 1.4", "1 1 1.4"), r"a\.dump:11: id 1 stands already in line 10"),
    "negative radius": (GOOD.replace("0 0.5\n2", "0 -0.5\n2"), r"a\.dump:10: column radius is '-0.5'; must be positive"),
    "box upside down": (GOOD.replace("0 4\n", "4 0\n"), r"a\.dump:6: '4 0'; must be two growing numbers"),
    "other box": (GOOD.replace("pp ff pp", "abc origin pp ff pp"), r"a\.dump:5: a box of any direction"),
    "too small a period": (GOOD.replace("0 4\n", "0 1.5\n"), "width: the period along x is 1.5"),
    "metres": (GOOD.replace(" 0.5\n", " 0.0005\n"), "the mean diameter is 0.001; must be 0.2 .. 5"),
    "binary": ("ITEM: TIMESTEP\n\0\1", "a binary file"),
    "unknown": ("hello\n", "its form is not recognised"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_refused_dumps(tmp_path, what):
    text, says = REFUSED[what]
    (tmp_path / "a.dump").write_text(text)
    with pytest.raises(SonopackError, match=says):
        Packing.read(tmp_path / "a.dump", friction=0, digits="exact")


@pytest.mark.parametrize("name, spoil, says", [
    ("p.vtp", lambda d: d[:len(d) // 2], "no whole XML"),
    ("p.vtp", lambda d: d.replace(b'Name="radius"', b'Name="size"'), "radius"),
    ("p.vtp", lambda d: b'<!DOCTYPE x [<!ENTITY a "b">]>' + d[d.index(b"<VTKFile"):], "recognised|DOCTYPE"),
    ("p-contacts.vtp", lambda d: d.replace(b'format="binary">', b'format="binary">AAAA', 1), "id1 is cut|base64"),
    ("p.mat", lambda d: d[:len(d) // 2], "damaged or cut"),
    ("p.mat", lambda d: d.replace(b"pressure", b"qressure"), "pressure"),
    ("p-packing.csv", lambda d: d.replace(b"friction", b"friktion"), "friction"),
    ("p-contacts.csv", lambda d: d.replace(b"\n0,", b"\n7777,", 1), "0 .. 71"),
    ("p.xyz.gz", lambda d: d[:200], "damaged or cut"),
])
def test_spoiled_files(layer, tmp_path, name, spoil, says):
    first = "p" + name[name.index("."):]
    layer.save(tmp_path / first)
    path = tmp_path / name
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(SonopackError, match=says):
        Packing.read(tmp_path / first)


def test_random_damage(layer, tmp_path):
    """Whatever byte is changed: a packing, or an error of ours."""
    rng = np.random.default_rng(7)
    for name in ("p.vtp", "p.mat", "p.dump", "p.xyz", "p.data", "p.csv"):
        layer.save(tmp_path / name)
        whole = (tmp_path / name).read_bytes()
        for _ in range(12):
            data = bytearray(whole)
            for at in rng.integers(0, len(data), 3):
                data[at] = rng.integers(0, 256)
            (tmp_path / name).write_bytes(bytes(data))
            try:
                Packing.read(tmp_path / name, **({} if name in ("p.vtp", "p.mat", "p.csv") else {"friction": 0.5}))
            except SonopackError:
                pass


# ---- the command ----------------------------------------------------------------------------------------------------

def test_command(sonopack, samples, layer, tmp_path):
    grains, contacts = samples / "lammps" / "layer_grains.dump", samples / "lammps" / "layer_contacts.dump"
    done = sonopack("convert", grains, "P.h5", "--contacts", contacts, "--types", 1, "--set", "friction=0.5")
    assert "sonopack: walls: elastic, by their forces and overlaps\n" in done.stderr and done.stdout == ""
    same(Packing.read(tmp_path / "P.h5"), layer)
    sonopack("convert", "P.h5", "Q.vtp")
    sonopack("convert", "Q.vtp", "R.h5")
    assert (tmp_path / "P.h5").read_bytes() == (tmp_path / "R.h5").read_bytes()
    assert "--force" in sonopack("convert", "P.h5", "Q.vtp", status=2).stderr
    assert "friction" in sonopack("convert", grains, "S.h5", "--types", 1, status=2).stderr
    assert "no.h5" in sonopack("convert", "no.h5", "S.h5", status=1).stderr
