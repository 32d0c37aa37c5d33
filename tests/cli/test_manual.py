"""Help, the manual page and the completions know every command, option and key, and what they show is accepted.

usage: test_manual.py COMMAND SOURCE_DIR
"""
import functools
import pathlib
import re
import shutil
import subprocess

from command import COMMAND, SOURCE, main, run, sets
from common import PATIENCE, expect

# of the Python package: they have completions of their own
PYTHON = set("plot view convert reproduce trace demo".split())
# keys whose examples contradict those of others
ALONE = tuple(f"packing.{key}=" for key in ("kind", "compression", "height", "tangential", "shape"))


@functools.cache
def output(*words):
    return run(*words).stdout


def commands():
    return re.findall(r"^  ([a-z]+) ", output("help"), re.M)


def options(command):
    """A line shows an option, and perhaps another name of it before or behind."""
    found = re.findall(r"^ +(?:-\w, )?(--[a-z][a-z0-9-]*)(?:[^,\n]*, (--[a-z][a-z0-9-]*))?", output(command, "--help"), re.M)
    return {name for names in found for name in names if name}


def keys():
    return re.findall(r"^(\w+\.\w+) = ", output("help", "scene"), re.M)


def offered(*words):
    """What `completion --words' offers, without the explanations."""
    return {line.split("\t")[0] for line in output("completion", "--words", *words).splitlines()}


def help_of_commands():
    assert {"pack", "check", "statics", "signal", "study", "help"} <= set(commands())
    assert output("help") == output("--help") == output("-h") and output("help").startswith("Usage: sonopack")
    for command in commands():
        if command not in {"help"} | PYTHON | {"bench"} - {"plot"}:  # those of Python are handed over in one way
            assert output("help", command) == output(command, "--help") == output(command, "-h"), command
        if command != "help":
            assert f"sonopack {command}" in output(command, "--help")
    assert re.fullmatch(r"sonopack \d+\.\d+\.\d+\n", output("--version")) and output("pack", "--version") == output("--version")


def manual():
    """The page, which the build makes of the commands' help, has every command and option; files name one version."""
    page = (pathlib.Path(COMMAND).parent / "sonopack.1").read_text().replace("\\-", "-")
    for command in set(commands()) - {"help"}:
        expect(f"\n.SS {command}\n" in page, f"the manual page does not explain {command}")
    lacking = set().union(*map(options, commands())) - {"--usage"} - set(re.findall(r"--[a-z][a-z0-9-]*", page))
    expect(not lacking, f"the manual page does not know {lacking}")
    versions = {re.search(pattern, (SOURCE / name).read_text(), re.M).group(1) for name, pattern in (
        ("include/sonopack/version.h", r'SONOPACK_VERSION "([^"]+)"'), ("CHANGELOG.md", r"^## (\d\S+)"),
        ("CITATION.cff", r"^version: \"?([^\"\s]+)"), ("packaging/conda/meta.yaml", r'set version = "([^"]+)"'))}
    versions.add(re.search(r'"sonopack ([^"]+)"', page)[1])
    assert versions == {output("--version").split()[-1]}, versions


def help_of_keys():
    """Every key is explained, and its example is one that scenes take (files, which are not there, and lists aside)."""
    apart = {"packing.file", "packing.content", "packing.diameter_file", "packing.diameters", "study.sweep"}
    minimum = ['study.want=["moduli"]', 'packing.cell="periodic"', 'packing.kind="minimum"', "packing.friction=0"]
    needs = {"packing.sizes": ["packing.diameter_min=0.8", "packing.diameter_max=1.2"],
             "packing.diameter_min": ["packing.diameter_max=1.2"], "packing.diameter_max": ["packing.diameter_min=0.8"],
             "packing.depth": ["packing.dimension=3"], "packing.cell": ['study.want=["moduli"]'],  # fronts need walls
             "packing.fraction": minimum, "packing.law.exponent": minimum,
             "packing.strain_rate": ['study.want=["moduli"]', 'packing.cell="periodic"'],
             "packing.stress": ['study.want=["moduli"]', 'packing.cell="periodic"']}
    glass = ["material.E=7e10", "material.nu=0.2", "material.rho=2500", "material.d=1e-3"]
    tried = []
    for key in keys():
        text = output("help", key)
        for word in ("meaning", "unit", "range", "default", "source", "example"):
            assert re.search(rf"^  {word} +\S", text, re.M), (key, word)
        example = re.search(r"^  example +--set '(.*)'$", text, re.M).group(1)
        more = [other for other in glass if not other.startswith(key + "=")] if key.startswith("material.") else []
        assert example.startswith(key + "="), example
        if key not in apart and not key.startswith("column."):
            tried.append((needs.get(key, more), example))
    # at once, but for those that contradict others
    lone = [case for case in tried if case[0] or case[1].startswith(ALONE)]
    for examples in ([*needed, example] for needed, example in lone):
        run("study", *sets(*examples), "--store", "nowhere", "--dry-run")
    run("study", *sets(*(case[1] for case in tried if case not in lone)), "--store", "nowhere", "--dry-run")
    assert len(keys()) > 60 and "packing.tolerance" in output("help", "tolerance")
    # the range that help says is the range that is accepted
    low, high = (word for word in output("help", "packing.seed").split("an integer", 1)[1].split()[:3] if word != "..")
    for seed, status in ((low, 0), (high, 0), (int(high) + 1, 2)):
        run("pack", f"--set=packing.seed={seed}", "--dry-run", "-o", "seed.h5", status=status)


def completions():
    assert set(commands()) <= offered("") and set(keys()) <= offered("help", "")
    assert {f"{key}=" for key in keys()} <= offered("pack", "--set", "")
    for command in set(commands()) - PYTHON - {"help"}:
        assert options(command) <= offered(command, "--") | {"--help", "--usage", "--version"}, command
    for words, some in ((("signal", "--method", ""), {"chebyshev", "lax-wendroff"}), (("spectrum", ""), {"participation"}),
                        (("table", ""), {"ctof"}), (("pack", "--set", "packing.kind="), {"packing.kind=triangular"}),
                        (("pack", "--set=packing.kind=tri"), {"--set=packing.kind=triangular"}),
                        (("signal", ""), {":files h5 hdf5 txt"}), (("study", "--store", ""), {":folders"})):
        assert some <= offered(*words), words


def shell_says(shell, *words):
    done = subprocess.run([shell, *words], text=True, capture_output=True, stdin=subprocess.DEVNULL, timeout=PATIENCE)
    assert done.returncode == 0 and not done.stderr, (shell, done.returncode, done.stderr)
    return done.stdout


def shells():
    """bash offers words and files; zsh and fish too, where they are installed."""
    def offers(*words):
        line = " ".join(f"'{word}'" for word in (COMMAND, *words))
        script = (f"source <('{COMMAND}' completion bash); COMP_WORDS=({line}); COMP_CWORD={len(words)}; "
                  "_sonopack 2>/dev/null; printf '%s\\n' \"${COMPREPLY[@]}\"")
        return set(shell_says("bash", "-c", script).split())

    for name in ("zz.cfg", "zz.png"):
        pathlib.Path(name).touch()
    for words, exactly in ((("pa",), {"pack"}), (("signal", "--method", "che"), {"chebyshev"}),
                           (("spectrum", "d"), {"dos", "dispersion"}), (("pack", "z"), {"zz.cfg"}),
                           (("pack", "--set", "packing.kind=tri"), {"packing.kind=triangular"}),
                           (("pack", "--set", "packing.kind", "=", "tri"), {"triangular"}),
                           (("pack", "-o", "z"), {"zz.cfg", "zz.png"})):
        assert offers(*words) == exactly, (words, offers(*words))
    for command in ["view"]:
        assert options(command) <= offers(command, "--") | {"--help", "--usage", "--version"}, command
    for shell in filter(shutil.which, ("zsh", "fish")):
        pathlib.Path(shell).write_text(output("completion", shell))
        shell_says(shell, "-n", shell)
    run("completion", "bash", "-o", "sonopack.bash")
    assert pathlib.Path("sonopack.bash").read_text() == output("completion", "bash")
    assert run("completion", "bash", "-o", "/dev/full", status=1).stderr


main(help_of_commands, manual, help_of_keys, completions, shells)
