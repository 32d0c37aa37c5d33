"""Studies that sweep words, booleans, lists, ranges and seeds: the samples and tables of separate studies. What is refused is
in tests/unit/test_scene_refusals.c.

usage: test_study_sweeps.py COMMAND SOURCE_DIR
"""
import itertools
import pathlib
import tempfile

import h5py
import numpy as np

from command import main, refused, run, sets, table, tables
from common import made_now

# made in no time
CHAIN = """
packing = { kind = "chain"; grains = 20; friction = 0; diameter_min = 0.9; diameter_max = 1.1; };
study = { samples = 2; want = ["ctof", "signal"]; };
"""
MINIMUM = """
packing = { kind = "minimum"; cell = "periodic"; friction = 0.0; grains = 60; sizes = "bidisperse"; diameter_min = 0.8333;
  diameter_max = 1.1667; @ };
study = { samples = 3; want = ["statics", "moduli"]; };
"""
PERIODIC = MINIMUM.replace("minimum", "piston").replace("friction = 0.0", "friction = 0.3")
PILE = "packing = { width = 6; grains = 30; tolerance = 1e-8; }; study = { samples = 2; want = [\"statics\"]; };\n"


def study(base, *keys):
    """What a scene with overrides prints, and its samples, in a store of its own."""
    pathlib.Path("base.cfg").write_text(base)
    store = tempfile.mkdtemp(dir=".")
    text = run("study", "base.cfg", "--store", store, *sets(*keys)).stdout
    return text, {path.name: path.read_bytes() for path in pathlib.Path(store).glob("*.h5")}


def same_as_separate(base, swept, *keys):
    """Sweeps of `swept` (key: list of values for --set) have the samples that studies of single values make, byte for
    byte; the tables that the sweep prints."""
    text, together = study(base, *keys)
    apart = {}
    for values in itertools.product(*swept.values()):
        _, some = study(base, *[f"{key}={value}" for key, value in zip(swept, values)])
        assert some and not set(some) & set(apart), (values, "the same samples for other values")
        apart.update(some)
    assert together == apart, (keys, set(together) ^ set(apart))
    return tables(text)


def words_and_booleans():
    swept = {"packing.sizes": ["uniform", "bidisperse"], "network.prestress": ["true", "false"],
             "signal.source": ["impulse", "velocity"]}
    found = same_as_separate(
        CHAIN, swept, 'study.sweep=( { key = "packing.sizes"; values = ["uniform", "bidisperse"]; },'
        '{ key = "network.prestress"; values = [true, false]; },'
        '{ key = "signal.source"; values = ["impulse", "velocity"]; } )')
    cases = [tuple(t.notes[key] for key in swept) for t in found]
    assert sorted(cases) == sorted(itertools.product(*swept.values())), cases
    alone, _ = study(CHAIN, *[f"{key}={value}" for key, value in zip(swept, cases[5])])
    assert found[5].body == tables(alone)[0].body, "the table of each value is the table of its own study"


def kinds():
    """Each kind has its own dimension."""
    base = "packing = { grains = 30; width = 6; friction = 0; tolerance = 1e-8; }; study = { samples = 1; };"
    for order in ("piston,chain,triangular", "chain,triangular,piston"):
        same_as_separate(base, {"packing.kind": order.split(",")}, f"packing.kind=[{order}]")


def lists():
    found = same_as_separate(PILE, {"packing.history": ["[]", "[1e-3]", "[1e-3, 1e-5]"]},
                             'study.sweep=({ key = "packing.history"; values = ( [], [1e-3], [1e-3, 1e-5] ); })')
    assert [t.notes["packing.history"] for t in found] == ["[]", "[0.001]", "[0.001, 1e-05]"]
    assert len({str(t.body) for t in found}) == 3
    base = "packing = { kind = \"chain\"; friction = 0; grains = 3; sizes = \"list\"; }; study = { samples = 1; };"
    same_as_separate(base, {"packing.diameters": ["[1, 1, 1]", "[1, 1.1, 0.9]"]},
                     'study.sweep=({ key = "packing.diameters"; values = ([1, 1, 1], [1, 1.1, 0.9]); })')


def ranges():
    (ctof,) = same_as_separate(  # both have rows
        CHAIN, {"packing.pressure": ["1e-7", "1e-6", "1e-5", "1e-4"], "packing.grains": ["10", "20", "30"]},
        'study.sweep=({ key = "packing.pressure"; from = 1e-7; to = 1e-4; count = 4; spacing = "log"; },'
        '{ key = "packing.grains"; from = 10; to = 30; step = 10; })')
    assert list(ctof["p"]) == [1e-7, 1e-6, 1e-5, 1e-4]
    by_override, _ = study(CHAIN, 'packing.pressure={from=1e-7; to=1e-4; count=4; spacing="log";}',
                           "packing.grains={ from = 10; to = 30; count = 3; }")
    assert tables(by_override)[0].body == ctof.body


def in_the_place_of_values():
    base = CHAIN.replace("grains = 20;", "grains = [10, 20]; poisson = { from = 0; to = 0.4; step = 0.2; };")
    text, there = study(base)
    same, listed = study(CHAIN, 'study.sweep=({ key = "packing.grains"; values = [10, 20]; },'
                         '{ key = "packing.poisson"; values = [0, 0.2, 0.4]; })')
    assert text == same and there == listed and len(there) == 12
    assert [t.notes["packing.poisson"] for t in tables(text)] == ["0", "0.2", "0.4"]
    # an override takes the place of such a sweep
    one, fewer = study(base, "packing.poisson=0.2")
    assert fewer.items() < there.items() and len(fewer) == 4 and "packing.poisson" not in tables(one)[0].notes
    # the packing that is made alone has the first values
    run("pack", "base.cfg", "-o", "first.txt")
    run("pack", "base.cfg", *sets(grains=10, poisson=0), "-o", "plain.txt")
    assert pathlib.Path("first.txt").read_bytes() == pathlib.Path("plain.txt").read_bytes()


def seeds():
    """Every table averages over them."""
    text, there = study(CHAIN, "packing.seed=[1, 11, 21]")
    assert len(there) == 6 and list(tables(text)[0]["samples"]) == [6]
    assert study(CHAIN, "packing.seed=11")[1].items() < there.items()
    refused("study.samples 2", "study", "base.cfg", "--store", "no", "--set", "packing.seed=[1, 2]")


def tables_of_a_scene():
    """table, given the scene, chooses like study."""
    pathlib.Path("scene.cfg").write_text(CHAIN.replace("friction = 0;", 'friction = 0; protocol = ["default", "somfai2005"];'))
    text = run("study", "scene.cfg", "--store", "store").stdout
    assert [t.notes["packing.protocol"] for t in tables(text)] == ["default", "somfai2005"]
    assert run("table", "ctof", "scene.cfg", "--store", "store").stdout == text
    run("table", "ctof", "scene.cfg", "--store", "store", "-o", "ctof.tsv")
    assert pathlib.Path("ctof.tsv").read_text() + "\n" + pathlib.Path("ctof-ctof-2.tsv").read_text() == text


def fractions():
    """Rows by fraction: their means are those of the packings that `pack` makes of the same seeds; p is a mean, too. Samples
    below jamming are left out of their row."""
    statics, moduli = same_as_separate(MINIMUM.replace("@", ""), {"packing.fraction": ["0.9", "1.0"]}, "packing.fraction=[0.9, 1.0]")
    assert list(moduli["fraction"]) == [0.9, 1] and list(moduli["samples"]) == [3, 3] and moduli.names[-10:-9] == ["K"]
    files = [f"{phi}-{seed}.h5" for phi in (0.9, 1.0) for seed in (1, 2, 3)]
    for file in files:
        run("pack", "base.cfg", "-q", "-o", file, *sets(f"packing.fraction={file[:3]}", f"packing.seed={file[4]}"))
    alone = table("moduli", "-q", *files)
    for name in ("p", "K", "G", "C11"):
        values = alone[name].reshape(2, 3)
        assert np.allclose(moduli[name], values.mean(1), rtol=1e-14, atol=0), name
        assert np.allclose(moduli[f"{name}_err"], values.std(1, ddof=1) / 3**0.5, rtol=1e-9, atol=0), name
    assert np.allclose(statics["Phi2"], [0.9, 1], rtol=1e-14)
    loose = table("study", "base.cfg", "--store", "loose", *sets('study.want=["moduli"]', "packing.fraction=[0.6, 0.9]"))
    assert list(loose["left_out"]) == [3, 0] and np.isnan(loose["p"][0]) and loose["K"][1] == moduli["K"][0]
    run("study", "base.cfg", "--store", "loose", "--verify", *sets("packing.fraction=0.9"))


def stages():
    """One run serves all stages of its path, with and without friction: the samples of a run for each. What lies behind the
    end of a path fails as it does alone. Rows by stage, with the strain; the state of rest at a stress has that pressure."""
    for base in (MINIMUM, PERIODIC):
        keys = "pressure = 1e-3; history = [2e-3]; path = { strain = [0.0, 0.0, 0.01]; steps = 4; turns = [1.0, 0.0]; };"
        _, moduli = same_as_separate(base.replace("@", keys), {"packing.stages": ["1", "2", "4", "6", "0"]},
                                     "packing.stages=[1, 2, 4, 6, 0]")
        assert list(moduli["stage"]) == [2, 4, 6, 10, 1] and list(moduli["strain"]) == [0, 0.005, 0.01, 0, 0]
        assert np.allclose(moduli["p"][[0, 4]], [1e-3, 2e-3], rtol=1e-3) and (moduli["p_err"][1:3] > 1e-6).all()
    apart = MINIMUM.replace("@", "pressure = 1e-3; path = { strain = [-0.04, -0.04, 0.0]; steps = 10; };")
    store = tempfile.mkdtemp(dir=".")
    pathlib.Path("base.cfg").write_text(apart)
    run("study", "base.cfg", "--store", store, "-q", *sets("packing.stages=[2, 9, 0]"))
    run("study", "base.cfg", "--store", "alone", "-q", *sets("packing.stages=9"))
    records = sorted(pathlib.Path("alone").glob("*.failed"))
    assert len(records) == 3 and len(list(pathlib.Path(store).glob("*.failed"))) == 6
    assert all((pathlib.Path(store) / r.name).read_text() == r.read_text() for r in records)
    rows = table("table", "ensemble", "base.cfg", "--store", store, *sets("packing.stages=[2, 9, 0]"))
    assert list(rows["stage"]) == [2] * 3 + [9] * 3 + [11] * 3 and list(rows["failed"]) == [0] * 3 + [1] * 6


def older_stores():
    """Samples without K and G, as older versions left them: nan in tables, sound, and made again by the study."""
    text, _ = study(MINIMUM.replace("@", ""))
    store = max(pathlib.Path(".").glob("tmp*"), key=lambda folder: folder.stat().st_mtime_ns)
    for path in store.glob("*.h5"):
        with h5py.File(path, "r+") as file:
            del file["results/moduli/bulk"], file["results/moduli/shear"]
    older = table("table", "moduli", "--store", store)
    whole = tables(text)[1]
    assert np.isnan(older["K"]).all() and older["C11"] == whole["C11"] and older["samples"] == [3]
    run("study", "--store", store, "--verify")
    assert run("study", "base.cfg", "--store", store).stdout == text
    assert made_now(run("study", "base.cfg", "--store", store).stderr) == 0


main(words_and_booleans, kinds, lists, ranges, in_the_place_of_values, seeds, tables_of_a_scene, fractions, stages,
     older_stores)
