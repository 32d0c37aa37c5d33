"""What is wrong raises the exception of its kind, with status and key; nothing half made stays behind."""
import dataclasses
import os
import pathlib
import pickle
from functools import partial

import numpy as np
from common import SOURCE, raised

import sonopack
from sonopack import InvalidInput, Refused, Scene, SonopackError, Status

TEXT = SOURCE / "packings/reference/packing_N600_p1e-4.txt"


def fails(status, key, function, *arguments, **more):
    fault = raised(SonopackError, function, *arguments, **more)
    assert fault.status == status and fault.key == key, (f"{status!r} {key}", repr(fault), fault.status, fault.key)
    return fault


def test_scenes():
    fault = fails(Status.EINVAL, "packing.pressure", Scene, packing={"pressure": -1})
    assert isinstance(fault, InvalidInput) and isinstance(fault, ValueError), type(fault).__mro__
    fails(Status.EINVAL, "packing.presure", Scene, packing={"presure": 1e-4})
    fails(Status.EINVAL, "packing.grains", Scene, packing={"grains": "many"})
    fails(Status.EINVAL, "packing.kind", Scene.read, None, {"packing.kind": "heap"})
    fails(Status.EINVAL, "signal.points", Scene.parse, "signal = { points = 1; };")
    fails(Status.EINVAL, "", Scene.read, "no-such.cfg")
    fails(Status.EINVAL, "column.e", sonopack.Column, e=1.5)
    fails(Status.EINVAL, "", Scene, packing={"grains": None})
    raised(KeyError, Scene().__getitem__, "packing.presure")


def test_scene_values():
    scene = Scene(packing={"grains": np.int64(77), "pressure": np.float32(2**-11), "friction": 0, "seed": 2**40},
                  study={"samples": 2, "sweep": [{"key": "packing.poisson", "values": [0.1, 0.2, 0.3]}]})
    assert scene["packing.grains"] == 77 and scene["packing.pressure"] == 2**-11 and scene["packing.friction"] == 0, scene
    assert scene.samples == 6 and Scene(packing={"pressure": [1e-5, 1e-4]}).samples == 2, scene.samples
    assert f"{2**40}" in scene.text and Scene.parse(scene.text).text == scene.text, scene.text
    assert scene.replace({"packing.grains": 78})["packing.grains"] == 78 and scene["packing.grains"] == 77, "replace"
    assert pickle.loads(pickle.dumps(scene)).text == scene.text, "pickle"
    name = 'with "quotes" and \\'
    fails(Status.EIO, "", sonopack.Packing.make, Scene(packing={"kind": "file", "file": name}))


def test_shapes():
    """Arrays of another shape are refused: they were cut, or read beyond their end."""
    packing = sonopack.Packing.make(Scene(packing={"grains": 60, "width": 6, "seed": 2, "tolerance": 1e-8}))
    net, contacts = packing.network(), np.array(packing.contacts)
    size = len(contacts) // 2
    rest = {"box": packing.box, "pressure": 1e-4, "friction": 0.5}
    make = sonopack.Packing.from_arrays
    fails(Status.EINVAL, "contacts", make, packing.x[:, :2], packing.r, contacts[:2 * size].reshape(-1, 2), **rest)
    fails(Status.EINVAL, "inertia", make, packing.x[:, :2], packing.r, contacts, mass=packing.r, **rest)
    fails(Status.EINVAL, "mass", make, packing.x[:, :2], packing.r, contacts, inertia=packing.r, **rest)
    fails(Status.EINVAL, "times", net.field, [[0, 1], [2, 3]])
    fails(Status.EINVAL, "omega", net.harmonic, [[0.1, 0.2], [0.3, 0.4]], damping=0.01)
    fails(Status.EINVAL, "times", sonopack.Column(particles=3, taps=2).run, [[0, 0.1], [0.2, 0.3]])
    # a packing to start from is the start, whatever the scene says of gases
    packing.save("start.h5")
    again = {"pressure": 2e-4, "tolerance": 1e-8}
    one = sonopack.Packing.make(Scene(packing=dict(again, kind="file", file="start.h5")))
    two = sonopack.Packing.make(Scene(packing=dict(again, grains=60, width=6)), start=packing)
    assert one.height == two.height and np.array_equal(one.r, packing.r) and np.array_equal(two.r, packing.r), (one, two)


def test_files():
    fault = fails(Status.EIO, "", sonopack.Packing.read, "no-such.h5")
    assert isinstance(fault, OSError) and "no-such.h5" in str(fault), fault
    pathlib.Path("cut.txt").write_text(TEXT.read_text()[:5000])
    assert "cut.txt" in str(fails(Status.EFORMAT, "", sonopack.Packing.read, "cut.txt")), "the file is named"
    packing = sonopack.Packing.read(TEXT)
    fails(Status.EINVAL, "", packing.save, "packing.png")
    fails(Status.EIO, "", packing.save, "no/such/folder.h5")
    fails(Status.EIO, "", sonopack.Store, "no-store")
    fails(Status.EINVAL, "", sonopack.Packing.read, "a\0b")
    fails(Status.EFORMAT, "", sonopack.Table.read, sonopack.Packing.__module__ and _binary())
    assert sorted(os.listdir(".")) == ["binary.tsv", "cut.txt"], os.listdir(".")


def _binary():
    pathlib.Path("binary.tsv").write_bytes(bytes(range(256)) * 4)
    return "binary.tsv"


def test_options():
    network = sonopack.Packing.read(TEXT).network()
    fails(Status.EINVAL, "method", network.signal, method="magic")
    fails(Status.EINVAL, "place", network.signal, detectors="plane")
    for call in network.source, network.transmission, partial(network.field, [1.0]), partial(network.harmonic, [0.1]):
        fails(Status.EINVAL, "place", call, at="top")
    fails(Status.EINVAL, "place", network.signal, sources="top")
    assert "must be -2147483648 .. 2147483647" in str(fails(Status.EINVAL, "points", network.signal, points=2**40))
    assert "must be -1.79" in str(fails(Status.EINVAL, "until", network.signal, until=10**400))
    for drawn in (network.packing, sonopack.Table.from_columns({"t": [0.0, 1.0]})):
        assert ": must be one of ctof, signal," in str(fails(Status.EINVAL, "kind", drawn.plot, "nokind"))
    fails(Status.EINVAL, "band", network.modes, lowest=3, band=(0, 1))
    fails(Status.EINVAL, "u", network.apply, np.zeros(7))
    fails(Status.EINVAL, "f", sonopack.front, [0, 1, 2], [0, 1])
    fails(Status.EINVAL, "t", sonopack.front, ["a", "b"], [0, 1])
    assert raised(SonopackError, network.signal, points=1).status == Status.EINVAL, "one point"
    assert isinstance(fails(Status.EREFUSED, "", sonopack.front, [0, 1, 2], [0, -1, 0]), Refused), "no front"
    raised(AttributeError, lambda: network.modes(vectors=False, lowest=2).vectors)
    assert hasattr(network.modes(lowest=2), "a") and not hasattr(network.modes(lowest=2, vectors=False), "a"), "amplitudes"
    fault = raised(AttributeError, setattr, network, "n", 3)
    assert "n" in str(fault), fault


def test_arrays():
    packing = sonopack.Packing.read(TEXT)
    given = dict(box=packing.box, pressure=packing.pressure, friction=packing.friction)
    contacts = {name: packing.contacts[name] for name in ("i", "j", "n", "fn", "ft")}
    make = sonopack.Packing.from_arrays

    def wrong(key, x=packing.x, r=packing.r, contacts=contacts, status=Status.EINVAL, **more):
        return fails(status, key, make, x, r, contacts, **{**given, **more})

    assert make(packing.x, packing.r, packing.contacts, **given).hash == packing.hash, "the same packing"
    wrong("x", x=packing.x[:-1])
    wrong("contacts", contacts={"i": [0], "k": [1]})
    wrong("contacts", contacts={"i": [0]})
    wrong("contacts", contacts={"i": [0.5], "j": [1.5]})
    wrong("contacts", contacts={**contacts, "j": contacts["j"] + 600})
    wrong("fn", contacts={**contacts, "fn": contacts["fn"][1:]})
    wrong("n", contacts={**contacts, "n": contacts["n"][:, :1]})
    wrong("box", box=[1, 2, 3, 4])
    wrong("box", box=packing.box[1:])  # the second column would be lost
    filled = np.column_stack([packing.x[:, :2], np.linspace(0, 1, 600)])
    for z in (filled, np.where(filled == filled[:, 2:], np.nan, filled)):  # and so would the third
        wrong("box", x=z)
    wrong("wall", wall="soft")
    wrong("", contacts={**contacts, "fn": -contacts["fn"]})
    wrong("", r=np.where(np.arange(600) == 5, np.nan, packing.r), status=Status.EFORMAT)
    wrong("", x=np.where(np.arange(600)[:, None] == 5, np.nan, packing.x[:, :2]), status=Status.EFORMAT)
    wrong("", pressure=-1, status=Status.EFORMAT)


def test_completed():
    """Contacts need not be complete: what is left out follows from what is there."""
    packing = sonopack.Packing.make(Scene(packing={"grains": 60, "width": 8}))
    given = dict(box=packing.box, pressure=packing.pressure, friction=packing.friction)
    c = packing.contacts
    turned = {name: c[name].copy() for name in ("i", "j", "fn", "n", "ft")}
    swap = (c["j"] >= 0) & (np.arange(len(c)) % 2 == 0)  # the order of i and j is free, and that of the rows
    turned["i"][swap], turned["j"][swap] = c["j"][swap], c["i"][swap]
    turned["n"][swap] *= -1
    turned["ft"][swap] *= -1
    turned = {name: values[::-1] for name, values in turned.items()}
    made = sonopack.Packing.from_arrays(packing.x, packing.r, turned, **given)
    assert np.array_equal(made.contacts["i"], c["i"]) and np.array_equal(made.contacts["j"], c["j"]), "order"
    assert np.array_equal(made.contacts["n"], c["n"]) and np.array_equal(made.contacts["ft"], c["ft"]), "signs"
    assert np.allclose(made.contacts["overlap"], c["overlap"], 1e-13, 0), "Hertz's law"
    bare = sonopack.Packing.from_arrays(packing.x, packing.r, {"i": c["i"], "j": c["j"]}, **given)
    assert np.allclose(bare.contacts["overlap"], c["overlap"], 1e-11, 0), "overlaps of positions"
    assert np.allclose(bare.contacts["fn"], c["fn"], 1e-10, 0) and np.allclose(bare.contacts["n"], c["n"], 0, 1e-14), "forces"


def test_other_laws():
    """Contacts with stiffnesses of their own, grains with masses, a material: as from tables of text."""
    packing = sonopack.Packing.make(Scene(packing={"grains": 60, "width": 8}))
    c, glass = packing.contacts, sonopack.Material(young=70e9, poisson=0.22, density=2500.0, diameter=1e-3)
    contacts = {"i": c["i"], "j": c["j"], "n": c["n"], "fn": c["fn"], "ft": c["ft"], "kn": np.full(len(c), 0.1)}
    mass, inertia = 2 * packing.network().mass[0, 0] * np.ones(60), 0.1 * np.ones(60)
    given = dict(box=packing.box, pressure=packing.pressure, friction=packing.friction, wall="elastic", material=glass)
    made = sonopack.Packing.from_arrays(packing.x, packing.r, contacts, mass=mass, inertia=inertia, **given)
    assert np.allclose(made.contacts["overlap"], c["fn"] / 0.1, 1e-14) and np.all(made.contacts["kt"] == 0.1), "springs"
    assert made.wall == "elastic" and made.material == glass, made.material
    made.save_tables("g.tsv", "c.tsv")
    again = sonopack.Packing.read_tables("g.tsv", "c.tsv")
    assert np.array_equal(again.contacts, made.contacts) and np.array_equal(again.mass, mass), "through tables"
    network = again.network()
    assert np.all(network.mass[:, 0] == mass[0]) and np.all(network.springs["kn"] == 0.1), "in the network"
    copied = pickle.loads(pickle.dumps(made))
    assert np.array_equal(copied.inertia, inertia) and copied.material == glass and copied.hash == made.hash, "pickle"
    assert packing.mass is None and packing.inertia is None and packing.material.young == 0, "spheres"
    fails(Status.EINVAL, "mass", sonopack.Packing.from_arrays, packing.x, packing.r, contacts, mass=mass[1:],
          inertia=inertia, **given)
    wrong = dataclasses.replace(glass, density=-1.0)
    raised(InvalidInput, sonopack.Packing.from_arrays, packing.x, packing.r, c, **{**given, "material": wrong})
    raised(Refused, network.signal, method="dynamics")
    os.remove("g.tsv")
    os.remove("c.tsv")


def test_pickles():
    for fault in (raised(InvalidInput, Scene, packing={"pressure": -1}), raised(SonopackError, sonopack.Packing.read, "no.h5")):
        again = pickle.loads(pickle.dumps(fault))
        assert (type(again), str(again), again.status, again.key) == (type(fault), str(fault), fault.status, fault.key), again
    packing = sonopack.Packing.make(Scene(packing={"grains": 60, "width": 8}))
    again = pickle.loads(pickle.dumps(packing))
    assert again.hash == packing.hash and again.scene == packing.scene and again.steps == packing.steps, again


def test_tables():
    table = sonopack.Table.from_columns({"t": [0.1, 2.0], "n": [1, -2**40], "word": ["a", "b c"]}, {"t": "s"},
                                        {"height": 0.1, "note": "plain"})
    table.save("t.tsv")
    again = sonopack.Table.read("t.tsv")
    assert again.names == ["t", "n", "word"] and again.units["t"] == "s" and again.number("height") == 0.1, again.text()
    assert list(again["t"]) == [0.1, 2.0] and list(again["n"]) == [1, -2**40] and list(again["word"]) == ["a", "b c"], again
    assert again.array()["t"][1] == 2.0 and dict(table)["n"][0] == 1, again.array()
    raised(KeyError, again.__getitem__, "u")
    fails(Status.EINVAL, "columns", sonopack.Table.from_columns, {"a": [1], "b": [1, 2]})
    fails(Status.EINVAL, "format", table.text, "xml")
    os.remove("t.tsv")


def test_refused_table():
    scene = Scene(packing={"grains": 40, "width": 8, "friction": [0.0, 0.5]}, study={"want": ["moduli"]})
    store = sonopack.study(scene, "store")
    assert raised(SonopackError, store.table, "moduli").status == Status.EREFUSED, "two frictions in one mean"
    chosen = [sample for sample in store if sample.friction == 0.5]
    assert store.table("moduli", samples=chosen).rows == 1 and store.table("ensemble").rows == 2, "chosen"
