"""Packings in two tables: what is read, what follows from Hertz's law, and the reasons of what is refused."""
import math
import pickle

import numpy as np
import pytest

import sonopack
from sonopack import InvalidInput, Packing
from sonopack.formats.finish import tangent_numbers, tangent_vectors

BOX = "# width = 10\n# height = 4\n# pressure = 1e-4\n# friction = 0.5\n# poisson = 0.1\n"
G = BOX + "id\tx\ty\tradius\na\t1\t0.5\t0.5\nb\t1.9\t0.5\t0.5\n17\t5\t2\t0.5\n"
C = ("i\tj\tnx\tny\toverlap\tFn\tFt\na\tb\t1\t0\t0.1\t0.01\t0.002\n17\tb\t0.6\t0.8\t0.05\t0.001\t-1e-4\n"
     "a\tbottom\t0\t-1\t1e-3\t0.002\t0\n")
TWO = "id x y radius\n1 1 0.5 0.5\n2 1.9 0.5 0.5\n"


def read(folder, grains, contacts, **keys):
    (folder / "g.tsv").write_text(grains)
    (folder / "c.tsv").write_text(contacts)
    return Packing.read_tables(folder / "g.tsv", folder / "c.tsv", keys)


def test_read_and_written(tmp_path):
    p = read(tmp_path, G, C)
    assert (p.n, p.friction, p.poisson) == (3, 0.5, 0.1) and p.contacts["j"].tolist() == [1, 2, sonopack.BOTTOM]
    turned = p.contacts[1]  # of 17 and b: the force on 17 along (-0.8, 0.6) is -1e-4
    assert np.allclose(turned["n"][:2], (-0.6, -0.8)) and np.allclose(turned["ft"][:2], (-0.8e-4, 0.6e-4), rtol=1e-14)
    p.save_tables(tmp_path / "g2.tsv", tmp_path / "c2.tsv")
    again = Packing.read_tables(tmp_path / "g2.tsv", tmp_path / "c2.tsv")
    assert again.contacts.tobytes() == p.contacts.tobytes() and again.x.tobytes() == p.x.tobytes()
    other = read(tmp_path, G, C, **{"packing.friction": 0, "pressure": 2e-5, "wall": "grain"})
    assert (other.pressure, other.friction, other.wall) == (2e-5, 0, "grain")
    with pytest.raises(InvalidInput, match="a file each"):
        p.save_tables(tmp_path / "g2.tsv", tmp_path / "g2.tsv")


def test_materials(tmp_path):
    """Tables keep masses, stiffnesses and frictions of contacts; copies keep the species of the grains too."""
    scene = sonopack.Scene(packing={"grains": 40, "width": 8}).replace({
        "packing.types.fraction": [0.5, 0.5], "packing.types.modulus": [1, 0.5], "packing.types.density": [1, 2],
        "packing.types.friction": [0.5, 0.2, 0.1]})
    p = Packing.make(scene)
    p.save_tables(tmp_path / "g.tsv", tmp_path / "c.tsv")
    again, copy = Packing.read_tables(tmp_path / "g.tsv", tmp_path / "c.tsv"), pickle.loads(pickle.dumps(p))
    assert set(p.contacts["mu"]) == {0.5, 0.2, 0.1} and sorted(p.species) == [0] * 20 + [1] * 20
    for other in (again, copy):
        assert other.contacts.tobytes() == p.contacts.tobytes() and other.mass.tobytes() == p.mass.tobytes()
    assert again.species is None and copy.species.tobytes() == p.species.tobytes()
    assert p.repeated(2, 1).species.tolist() == 2 * p.species.tolist()
    for bad in ([0, 1], p.species + 0.5, p.species.astype(np.int64) + 2**40, p.species - 1):
        with pytest.raises(InvalidInput, match="species"):
            Packing.from_arrays(p.x[:, :2], p.r, p.contacts, box=p.box, pressure=p.pressure, friction=p.friction, species=bad)


def test_hertz_fills_in(tmp_path):
    p = read(tmp_path, G, "i j nx ny overlap\na b 1 0 0.1\n17 b 0.6 0.8 0.01\n")
    assert math.isclose(p.contacts["fn"][0], 4 / 3 * 0.5 * 0.25**0.5 * 0.1**1.5, rel_tol=1e-14)
    back = read(tmp_path, G, f"i j nx ny Fn\na b 1 0 {float(p.contacts['fn'][0])!r}\n")
    assert math.isclose(back.contacts["overlap"][0], 0.1, rel_tol=1e-14)


def test_grains_outside_are_moved(tmp_path):
    pairs = "i j nx ny overlap\n1 2 1 0 0.1\n"
    tilted = BOX + "# cell = periodic\n# xy = 1\nid x y radius\n1 1 0.5 0.5\n2 2.9 4.5 0.5\n"
    assert np.allclose(read(tmp_path, tilted, pairs).x[1, :2], (1.9, 0.5), atol=1e-15)
    below = BOX + "id x y radius\n1 -9 0.5 0.5\n2 1.9 0.5 0.5\n"
    assert read(tmp_path, below, pairs).x[0, 0] == 1


def test_forces_along_tangents_keep_all_bits():
    draw = np.random.default_rng(11)
    angle = draw.uniform(0, 2 * np.pi, 20000)
    n = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    scalar = (draw.random(20000) - 0.5) * 10.0 ** (-10 * draw.random(20000))
    assert (tangent_numbers(n, tangent_vectors(n, scalar)) == scalar).all()


@pytest.mark.parametrize("grains, contacts, words", [
    (BOX + "id x y\n1 1 1\n", C, "g.tsv radius"),
    (BOX + "id x y radius\n1 1 1 0.5\n2 2 1\n", C, "g.tsv:8 3 4"),
    (BOX + "id x y radius\n1 1 1 0.5 7\n", C, "g.tsv:7 5 4"),
    (BOX + "id x y radius\n1 1 1 nan\n", C, "g.tsv:7 radius nan"),
    (BOX + "id x y radius\n1 1 1 0.5\n2 1 2 0.5\n1 2 2 0.5\n", C, "g.tsv:9 id 1 7"),
    (BOX + "id x y radius\n1 1 1 0.5\nbottom 1 2 0.5\n", C, "g.tsv:8 id bottom"),
    (BOX + "id x y radius\n", C, "g.tsv 0"),
    ("", C, "g.tsv"),
    ("# width = 10\n# height = 0\n# pressure = 1\n# friction = 0\nid x y radius\n1 1 1 0.5\n", C, "height 0"),
    ("# dimension = 3\nid x y radius\n1 1 1 0.5\n", C, "z"),
    (G, "i j nx ny overlap\na c 1 0 0.1\n", "c.tsv:2 j c"),
    (G, "i j nx ny overlap\na b 1 0.1 0.1\n", "c.tsv:2"),
    (G, "i j nx ny overlap\ntop bottom 1 0 0.1\n", "c.tsv:2 -2 -1"),
    (G, "i j nx ny overlap\na b 1 0 0.1\nb a -1 0 0.1\n", "c.tsv 0 1"),
    (G, "i j nx ny\na b 1 0\n", "overlap Fn"),
    (G, "i\tj\tnx\tny\toverlap\tFn\na\tb\t1\t0\t\t\n", "c.tsv:2 overlap Fn"),
    (G, "i j nx ny overlap\na b 1 0 -0.1\n", "c.tsv:2 overlap"),
    (G, "i j nx ny overlap Ftx\na b 1 0 0.1 0\n", "1 2"),
    (BOX + "# cell = round\n" + TWO, "i j nx ny overlap\n1 2 1 0 0.01\n", "cell round"),
    (BOX + "# cell = periodic\n# xy = 6\n" + TWO, "i j nx ny overlap\n1 2 1 0 0.01\n", "tilt 6"),
    (BOX + "# cell = periodic\n" + TWO, "i j nx ny overlap\n1 bottom 0 -1 0.01\n", "c.tsv:2 -1"),
    (BOX + "# cell = box\n" + TWO, "i j nx ny overlap\n1 front -1 0 0.01\n", "c.tsv:2 front"),
    (BOX + "# cell = box\nid x y radius\nleft 1 0.5 0.5\n", "i j nx ny overlap\n", "g.tsv:8 left"),
    (BOX + TWO, "i j nx ny overlap\n1 left -1 0 0.01\n", "c.tsv:2 left"),
])
def test_refused(tmp_path, grains, contacts, words):
    with pytest.raises(InvalidInput) as refusal:
        read(tmp_path, grains, contacts)
    assert all(word in str(refusal.value) for word in words.split()), refusal.value


@pytest.mark.parametrize("key, value", [("colour", "red"), ("pressure", "high"), ("seed", "-1"), ("wall", "soft")])
def test_refused_keys(tmp_path, key, value):
    with pytest.raises(InvalidInput) as refusal:
        read(tmp_path, G, C, **{key: value})
    assert key in str(refusal.value) and value in str(refusal.value)
