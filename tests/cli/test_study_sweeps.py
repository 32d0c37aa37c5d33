"""Studies that sweep words, booleans, lists, ranges and seeds: the samples and tables of separate studies.

usage: test_study_sweeps.py COMMAND SOURCE_DIR
"""
import itertools
import pathlib
import tempfile

from common import names_all
from streams import column, comment, run, tables

# made in no time
CHAIN = """
packing = { kind = "chain"; grains = 20; friction = 0; diameter_min = 0.9; diameter_max = 1.1; };
study = { samples = 2; want = ["ctof", "signal"]; };
"""
PILE = "packing = { width = 6; grains = 30; tolerance = 1e-8; }; study = { samples = 2; want = [\"statics\"]; };\n"


def samples(store):
    return {path.name: path.read_bytes() for path in pathlib.Path(store).glob("*.h5")}


def settings(values):
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def study(folder, base, *sets, status=0):
    """The tables and samples of a scene with overrides, in a store of its own."""
    scene = folder / "base.cfg"
    scene.write_text(base)
    store = tempfile.mkdtemp(dir=folder)
    done = run("study", scene, "--store", store, *[word for one in sets for word in ("--set", one)], status=status)
    return (done.stdout, samples(store)) if status == 0 else done.stderr


def same_as_separate(folder, base, swept, *sets):
    """Sweeps of `swept` (key: list of values for --set) have the samples that studies of single values make, byte for
    byte; the tables that the sweep prints."""
    text, together = study(folder, base, *sets)
    apart = {}
    for values in itertools.product(*swept.values()):
        _, some = study(folder, base, *[f"{key}={value}" for key, value in zip(swept, values)])
        assert some and not set(some) & set(apart), (values, "the same samples for other values")
        apart.update(some)
    assert set(together) == set(apart), (sets, len(together), len(apart))
    different = [name for name in apart if together[name] != apart[name]]
    assert not different, (sets, different)
    return text


def words_and_booleans(folder):
    swept = {"packing.sizes": ["uniform", "bidisperse"], "network.prestress": ["true", "false"],
             "signal.source": ["impulse", "velocity"]}
    text = same_as_separate(
        folder, CHAIN, swept,
        'study.sweep=( { key = "packing.sizes"; values = ["uniform", "bidisperse"]; },'
        '{ key = "network.prestress"; values = [true, false]; },'
        '{ key = "signal.source"; values = ["impulse", "velocity"]; } )')
    found = tables(text)
    assert len(found) == 8
    cases = [tuple(comment(table, key) for key in swept) for table in found]
    assert sorted(cases) == sorted(itertools.product(*swept.values())), cases
    # the table of each value is the table of its own study
    for case, table in zip(cases, found):
        alone, _ = study(folder, CHAIN, *[f"{key}={value}" for key, value in zip(swept, case)])
        (only,) = tables(alone)
        assert table[1:] == only[1:], case


def kinds(folder):
    """Each kind has its own dimension."""
    base = "packing = { grains = 30; width = 6; friction = 0; tolerance = 1e-8; }; study = { samples = 1; };"
    swept = {"packing.kind": ["piston", "chain", "triangular"]}
    for order in ("piston,chain,triangular", "chain,triangular,piston"):
        same_as_separate(folder, base, swept, f"packing.kind=[{order}]")


def histories(folder):
    swept = {"packing.history": ["[]", "[1e-3]", "[1e-3, 1e-5]"]}
    text = same_as_separate(folder, PILE, swept,
                            'study.sweep=({ key = "packing.history"; values = ( [], [1e-3], [1e-3, 1e-5] ); })')
    found = tables(text)
    assert [comment(table, "packing.history") for table in found] == ["[]", "[0.001]", "[0.001, 1e-05]"]
    assert len({str(table[2]) for table in found}) == 3


def diameters(folder):
    base = "packing = { kind = \"chain\"; friction = 0; grains = 3; sizes = \"list\"; }; study = { samples = 1; };"
    same_as_separate(folder, base, {"packing.diameters": ["[1, 1, 1]", "[1, 1.1, 0.9]"]},
                     'study.sweep=({ key = "packing.diameters"; values = ([1, 1, 1], [1, 1.1, 0.9]); })')


def ranges(folder):
    swept = {"packing.pressure": ["1e-7", "1e-6", "1e-5", "1e-4"], "packing.grains": ["10", "20", "30"]}
    text = same_as_separate(folder, CHAIN, swept,
                            'study.sweep=({ key = "packing.pressure"; from = 1e-7; to = 1e-4; count = 4; '
                            'spacing = "log"; }, { key = "packing.grains"; from = 10; to = 30; step = 10; })')
    (ctof,) = tables(text)  # both have rows
    assert list(column(ctof, "p")) == [1e-7, 1e-6, 1e-5, 1e-4]
    by_override, _ = study(folder, CHAIN, 'packing.pressure={from=1e-7; to=1e-4; count=4; spacing="log";}',
                           "packing.grains={ from = 10; to = 30; count = 3; }")
    assert by_override == text


def in_the_place_of_values(folder):
    base = CHAIN.replace("grains = 20;", "grains = [10, 20]; poisson = { from = 0; to = 0.4; step = 0.2; };")
    text, there = study(folder, base)
    same, listed = study(folder, CHAIN, 'study.sweep=({ key = "packing.grains"; values = [10, 20]; },'
                         '{ key = "packing.poisson"; values = [0, 0.2, 0.4]; })')
    assert text == same and there == listed and len(there) == 12
    assert [comment(table, "packing.poisson") for table in tables(text)] == ["0", "0.2", "0.4"]
    # an override takes the place of such a sweep
    one, fewer = study(folder, base, "packing.poisson=0.2")
    assert fewer.items() < there.items() and len(fewer) == 4
    assert not [line for line in tables(one)[0][0] if "poisson" in line]
    _, other = study(folder, base, "packing.poisson=[0.2]", "packing.grains=20")
    assert other.items() < fewer.items() and len(other) == 2
    # the packing that is made alone has the first values
    scene = folder / "base.cfg"
    scene.write_text(base)
    run("pack", scene, "-o", folder / "first.txt")
    run("pack", scene, "--set", "packing.grains=10", "--set", "packing.poisson=0", "-o", folder / "plain.txt")
    assert (folder / "first.txt").read_bytes() == (folder / "plain.txt").read_bytes()


def seeds(folder):
    """Every table averages over them."""
    text, there = study(folder, CHAIN, "packing.seed=[1, 11, 21]")
    (ctof,) = tables(text)
    assert len(there) == 6 and list(column(ctof, "samples")) == [6]
    _, first = study(folder, CHAIN, "packing.seed=11")
    assert first.items() < there.items()
    assert "must differ by at least study.samples = 2" in study(folder, CHAIN, "packing.seed=[1, 2]", status=2)


def tables_of_a_scene(folder):
    """table, given the scene, chooses like study."""
    scene, store = folder / "scene.cfg", folder / "store"
    scene.write_text(CHAIN.replace("friction = 0;", 'friction = 0; protocol = ["default", "somfai2005"];'))
    text = run("study", scene, "--store", store).stdout
    assert [comment(table, "packing.protocol") for table in tables(text)] == ["default", "somfai2005"]
    assert run("table", "ctof", scene, "--store", store).stdout == text
    out = folder / "ctof.tsv"
    run("table", "ctof", scene, "--store", store, "-o", out)
    assert out.read_text() + "\n" + (folder / "ctof-ctof-2.tsv").read_text() == text
    assert names_all(run("study", scene, "--store", store, "--verify").stderr, "0")


def refusals(folder):
    for override, reason in (
            ("packing.pressure=[1e-7, 1]", "packing.pressure 1 1e-10 0.01 E*"),
            ("packing.pressure=[1e-7, 1e-7]", "1e-07"),
            ("packing.pressure=[]", "packing.pressure"),
            ("packing.pressure=[nan]", "packing.pressure"),
            ("packing.pressure=[[1e-7]]", "packing.pressure"),
            ("packing.pressure={from=1e-7;to=1e-4;count=1000000000;}", "2 10000"),
            ("packing.pressure={from=1e-7;to=1e-4;}", "packing.pressure count step"),
            ("packing.sizes=[uniform, bidispers]", "uniform bidisperse lognormal list"),
            ("packing.kind=[chain, file]", "packing.kind file"),
            ("packing.content=[1, 2]", "packing.content"),
            ("signal.method=[dense, chebyshev]", "signal.method"),
            ("study.samples=[1, 2]", "study.samples"),
            ('study.sweep=({ key = "study.want"; values = ["ctof"]; })', ""),
            ("packing.grains={from=1;to=10;count=30;spacing=\"log\";}", "1"),
            ("packing.seed={from=1;to=10000;count=10000;}", "study.samples")):
        error = study(folder, CHAIN, override, status=2)
        assert names_all(error, f"--set {reason}") and error.count("\n") == 1, (override, error)
    hidden = CHAIN.replace('"signal"];', '"signal"]; sweep = ({ key = "packing.poisson"; values = [0, 0.1]; });')
    assert "the key is swept by study.sweep" in study(folder, hidden, "packing.poisson=0.2", status=2)
    assert "swept here and by study.sweep" in study(folder, hidden, "packing.poisson=[0.2, 0.3]", status=2)


def main():
    for test in (words_and_booleans, kinds, histories, diameters, ranges, in_the_place_of_values, seeds,
                 tables_of_a_scene, refusals):
        with tempfile.TemporaryDirectory(prefix="sonopack-sweeps-") as folder:
            test(pathlib.Path(folder))


if __name__ == "__main__":
    main()
