"""Scene files through the command: the examples, the defaults that help shows, overrides. What is refused is in
refusals.txt and, sentence by sentence, in tests/unit/test_scene_refusals.c.

usage: test_scene.py COMMAND SOURCE_DIR
"""
import pathlib
import re

from command import SOURCE, main, run, sets, table

SMALL = sets(grains=20, width=6)


def summary(*words):
    return table("pack", *words, "--force", "-o", "made.txt").row()


def defaults():
    """What help shows as defaults is a scene file, up to the group brackets, and gives the default packing."""
    groups = {}
    for group, key, value in re.findall(r"^(\w+)\.(\w+) = (.+)\n    .+", run("help", "scene").stdout, re.M):
        groups.setdefault(group, []).append(f"{key} = {value};")
    pathlib.Path("defaults.cfg").write_text("\n".join(f"{group} = {{ {' '.join(lines)} }};" for group, lines in groups.items()))
    assert summary("defaults.cfg", *SMALL)["height"] == summary(*SMALL)["height"]
    assert re.findall(r"^packing\.path\.\w+", run("help", "packing.path").stdout, re.M) == [
        f"packing.path.{key}" for key in ("strain", "turns", "steps", "lateral")]
    assert table("pack", "-o", "q.txt", "--dry-run").words("what")[0] == "packing"  # without any key


def examples():
    scenes = sorted((SOURCE / "packings").glob("*.cfg"))
    assert len(scenes) >= 3
    for scene in scenes:
        assert summary(scene, *SMALL)["grains"] == "20", scene.name


def values():
    """What is written is what is used; --set wins; whole reals and integers stand for each other."""
    scene = pathlib.Path("scene.cfg")
    scene.write_text("packing : {\n  grains = 2e1, width = 6\n  pressure = 1e-3;\n  seed = 4294967297 };")
    row = summary(scene)
    assert row["grains"] == "20" and float(row["p"]) == 1e-3, row
    other = summary(scene, *sets(grains=25, pressure=1e-5))
    assert other["grains"] == "25" and float(other["p"]) == 1e-5, other
    by_key, by_option, low = (summary(scene, *words)["height"] for words in (
        ["--set=packing.seed=4294967297"], ["--seed=4294967297"], ["--seed=1"]))  # 1: the same in 32 bits
    assert by_key == by_option == row["height"] != low
    for grains in (1, 3):
        assert summary(*sets(kind="chain", grains=grains))["grains"] == str(grains)


main(defaults, examples, values)
