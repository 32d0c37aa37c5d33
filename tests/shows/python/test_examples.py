"""The examples, the notebook and the page docs/python.md do as they say, in a plain interpreter; types are right."""
import ast
import contextlib
import importlib.util
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import types

import numpy as np
import pytest
from common import COMMAND, SOURCE

EXAMPLES = SOURCE / "python/examples"


class Anything(types.ModuleType):
    """Stands in for a library that draws, where there is none: every call is accepted."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return Anything(name)

    def __call__(self, *_, **__):
        return self


def can_draw():
    if importlib.util.find_spec("matplotlib"):
        import matplotlib
        matplotlib.use("Agg")
        return True
    sys.modules.update({"matplotlib": Anything("matplotlib"), "matplotlib.pyplot": Anything("matplotlib.pyplot")})
    return False


def script(name, *arguments):
    result = subprocess.run([sys.executable, "-B", EXAMPLES / name, *arguments], text=True, capture_output=True)
    assert result.returncode == 0, (name, result.stdout, result.stderr)
    return result.stdout


def number(pattern, text):
    found = re.search(pattern.replace("#", r"([-+]?[0-9.]+(?:e[-+]?\d+)?)"), text)
    assert found, (pattern, text)
    return float(found.group(1))


def test_speed_of_sound():
    text = script("speed_of_sound.py", *(["figure.png"] if DRAWS else []))
    # Somfai et al. 2005: 0.26 for the front and 0.19 for long waves; one packing scatters by a tenth
    assert 0.2 < number("the front: #", text) < 0.32 and 0.15 < number("long waves: #", text) < 0.22, text
    if DRAWS:
        assert pathlib.Path("figure.png").read_bytes()[1:4] == b"PNG", "no figure"


def outputs_of(cell):
    """What a code cell printed when the notebook was saved, without its figures."""
    text = ""
    for output in cell["outputs"]:
        text += "".join(output.get("text", output.get("data", {}).get("text/plain", "")))
    return text


def run_cell(source, space):
    """Runs a cell. As in a notebook, the value of a last line that is an expression is shown."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "notebook", "exec"), space)
    if last is not None:
        value = eval(compile(ast.Expression(last.value), "notebook", "eval"), space)
        if value is not None:
            print(repr(value))


@pytest.mark.parametrize("name", sorted(path.name for path in EXAMPLES.glob("*.ipynb")))
def test_notebook(name):
    """The cells, run one after the other as a notebook runs them, print what is saved in the file."""
    space, seen = {"__name__": "__main__"}, 0
    for cell in json.loads((EXAMPLES / name).read_text())["cells"]:
        if cell["cell_type"] != "code":
            continue
        source, printed = "".join(cell["source"]), io.StringIO()
        with contextlib.redirect_stdout(printed):
            run_cell(source, space)
        expected = outputs_of(cell).strip()
        seen += expected != ""
        if "Figure" not in expected and "plt" not in source:
            assert printed.getvalue().strip() == expected, (source, printed.getvalue(), expected)
    assert seen >= 3, ("cells with output", seen)


def test_page():
    """Console and Python blocks of docs/python.md, in the order of the page."""
    text = (SOURCE / "docs/python.md").read_text()
    pathlib.Path("bin").mkdir()
    pathlib.Path("bin/sonopack").symlink_to(COMMAND)
    environment = dict(os.environ, PATH=f"{pathlib.Path('bin').resolve()}:{os.environ['PATH']}")
    space, blocks = {"__name__": "__main__"}, 0
    for kind, block in re.findall(r"^```(console|python)\n(.*?)^```", text, re.S | re.M):
        if "pandas" in block and not importlib.util.find_spec("pandas"):
            block = re.sub(r"^.*pandas.*\n", "", block, flags=re.M)
        for command in re.findall(r"^\$ (.*)", block, re.M) if kind == "console" else ():
            subprocess.run(["bash", "-c", command], check=True, env=environment, stdout=subprocess.DEVNULL)
        if kind == "python":
            blocks += 1
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(block, "docs/python.md", "exec"), space)
    assert blocks >= 12, blocks
    assert len(space["found"].contacts) == len(space["own"].contacts), ("overlapping pairs", space["found"])
    assert abs(space["own"].network().front().t10 / space["front"].t10 - 1) < 0.01, "own arrays"
    layer, beads = space["layer"], space["beads"]
    assert abs(layer.network().front().t10 / beads.network().front().t10 - 1) < 1e-9, ("arrays in SI", layer)
    assert abs(layer.pressure / beads.pressure - 1) < 1e-12 and layer.material == beads.material, "pressure in SI"
    if DRAWS:
        assert all(pathlib.Path(name).stat().st_size > 1000 for name in ("front.png", "mode.png")), "figures"
    check_recipes(recipe())


def recipe():
    """The function `read` of docs/recipes.md, and tables for it."""
    for words in ("signal P.h5 -o signal.tsv", "signal P.h5 -o signal.csv", "statics P.h5 -o statics.tsv",
                  "modes P.h5 -o modes.tsv", "front P.h5 -o front.tsv"):
        subprocess.run([COMMAND, *words.split(), "-q"], check=True)
    space = {}
    script = re.search(r"^```python read_numpy.py\n(.*?)^```", (SOURCE / "docs/recipes.md").read_text(), re.S | re.M)
    with contextlib.redirect_stdout(io.StringIO()):
        exec(script[1], space)
    return space["read"]


def check_recipes(read):
    """What recipes.md says of tables: bits of numpy and of pandas, and the form that alone does not work."""
    import sonopack
    for name in ("signal", "modes"):
        table, array = sonopack.Table.read(f"{name}.tsv"), read(f"{name}.tsv")
        assert list(array.dtype.names) == table.names, array.dtype
        assert all(np.array_equal(array[column], table[column], equal_nan=True) for column in table), name
    try:
        names = np.genfromtxt("signal.tsv", names=True).dtype.names
        assert names != ("t", "F"), "genfromtxt reads tables as they are: the page says it does not"
    except ValueError:
        pass
    plain = np.genfromtxt("signal.csv", names=True, delimiter=",")
    assert np.array_equal(plain["F"], sonopack.Table.read("signal.tsv")["F"]), "csv"
    assert "file_" in read("statics.tsv").dtype.names, "the column file"
    if importlib.util.find_spec("pandas"):
        import pandas
        frame = pandas.read_csv("signal.tsv", sep="\t", comment="#", float_precision="round_trip")
        assert np.array_equal(frame.F, plain["F"]) and list(frame.columns) == ["t", "F"], "pandas"


def test_types():
    mypy = shutil.which("mypy")
    if not mypy:
        return print("no mypy")
    folder = pathlib.Path(importlib.util.find_spec("sonopack").origin).parent
    # the hints say something: a wrong use is found, and nothing else
    pathlib.Path("wrong.py").write_text("import sonopack\nsonopack.Scene().samples.real.nothing\nx: str = sonopack.Packing.read('p').height\n")
    result = subprocess.run([mypy, "--strict", "--ignore-missing-imports", "--cache-dir", os.devnull, "wrong.py",
                             *sorted(map(str, EXAMPLES.glob("*.py"))), str(folder)], text=True, capture_output=True,
                            env=dict(os.environ, MYPYPATH=str(folder.parent)))
    faults = [line.split(" ")[0] for line in result.stdout.splitlines()[:-1]]
    assert result.returncode == 1 and faults == ["wrong.py:2:", "wrong.py:3:"], (result.stdout, result.stderr)


DRAWS = can_draw()
