"""What helps at the terminal: help of keys, suggestions, completions of three shells, warnings, lines of progress.

usage: test_terminal.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from common import PATIENCE, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
N200 = SOURCE / "packings/reference/packing_N200_p1e-4.txt"


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], text=True, capture_output=True, stdin=subprocess.DEVNULL,
                          timeout=PATIENCE)
    assert done.returncode == status, (words, done.returncode, done.stdout[-300:], done.stderr)
    return done


def commands():
    return re.findall(r"^  ([a-z]+) ", run("help").stdout, re.M)


def options(command):
    text = run(command, "--help").stdout
    return set(re.findall(r"^ +(?:-\w, )?(--[a-z][a-z0-9-]*)", text, re.M))


def keys():
    return re.findall(r"^(\w+\.\w+) = ", run("help", "scene").stdout, re.M)


def test_help_of_keys():
    assert len(keys()) > 60
    for key in keys():
        text = run("help", key).stdout
        assert text.startswith(key + "\n"), text
        for word in ("meaning", "unit", "range", "default", "source", "example"):
            assert re.search(rf"^  {word} +\S", text, re.M), (key, word)
        example = re.search(r"^  example +--set '(.*)'$", text, re.M).group(1)
        assert example.startswith(key + "="), example
    for key in run("help", "tolerance").stdout.split("\n\n"):
        assert key.split("\n")[0] in ("packing.tolerance", "signal.tolerance", "column.tolerance")
    scene = run("help", "scene").stdout
    assert not re.search(r"\b\d+L\b|e[-+]0", scene), re.findall(r".*(?:\b\d+L\b|e[-+]0).*", scene)[:3]


def test_examples_of_keys():
    """The example of a key is one that scenes take (files, which are not there, and lists for other keys aside)."""
    apart = {"packing.file", "packing.content", "packing.diameter_file", "packing.diameters", "study.sweep"}
    needs = {"packing.sizes": ["packing.diameter_min=0.8", "packing.diameter_max=1.2"],
             "packing.diameter_min": ["packing.diameter_max=1.2"], "packing.diameter_max": ["packing.diameter_min=0.8"], "packing.depth": ["packing.dimension=3"],
             "packing.cell": ["study.want=[\"moduli\"]"],  # fronts need walls
             "packing.stress": ["study.want=[\"moduli\"]", "packing.cell=\"periodic\""]}
    glass = ["material.E=7e10", "material.nu=0.2", "material.rho=2500", "material.d=1e-3"]
    needs.update({key: [other for other in glass if not other.startswith(key + "=")] for key in keys()
                  if key.startswith("material.")})
    for key in keys():
        if key in apart or key.startswith("column."):
            continue
        example = re.search(r"--set '(.*)'$", run("help", key).stdout, re.M).group(1)
        words = [word for setting in [*needs.get(key, []), example] for word in ("--set", setting)]
        run("study", *words, "--store", "nowhere", "--dry-run")


def test_h_is_help():
    for command in commands():
        if command != "help":
            assert run(command, "-h").stdout == run(command, "--help").stdout == run(command, "-?").stdout
    assert run("-h").stdout == run("help").stdout


def offered(*words):
    """What `completion --words' offers, without the explanations."""
    return {line.split("\t")[0] for line in run("completion", "--words", *words).stdout.splitlines()}


def test_completions_know_everything():
    """Structure: commands, options, kinds and keys are offered, and every script is one that asks for them."""
    for shell in ("bash", "zsh", "fish"):
        assert "completion --words" in run("completion", shell).stdout, shell
    assert set(commands()) <= offered("")
    assert set(keys()) <= offered("help", "") and {f"{key}=" for key in keys()} <= offered("pack", "--set", "")
    for command in set(commands()) - set("help plot view convert reproduce".split()):
        assert options(command) <= offered(command, "--"), command
    assert {"chebyshev", "lax-wendroff"} <= offered("signal", "--method", "")
    assert "participation" in offered("spectrum", "") and "ctof" in offered("table", "")
    assert "packing.kind=triangular" in offered("pack", "--set", "packing.kind=")
    assert "--set=packing.kind=triangular" in offered("pack", "--set=packing.kind=tri")
    assert ":files h5 hdf5 txt" in offered("signal", "") and ":files" in offered("signal", "-o", "")
    assert ":folders" in offered("study", "--store", "")


def shell_says(shell, *words):
    done = subprocess.run([shell, *words], text=True, capture_output=True, stdin=subprocess.DEVNULL, timeout=PATIENCE)
    assert done.returncode == 0 and not done.stderr, (shell, done.returncode, done.stderr)
    return done.stdout


def test_bash(folder):
    def offers(*words):
        line = " ".join(f"'{word}'" for word in (COMMAND, *words))
        script = (f"source <('{COMMAND}' completion bash); COMP_WORDS=({line}); COMP_CWORD={len(words)}; "
                  "_sonopack 2>/dev/null; printf '%s\\n' \"${COMPREPLY[@]}\"")
        return set(shell_says("bash", "-c", script).split())
    (folder / "zz.cfg").touch()
    (folder / "zz.png").touch()
    assert offers("pa") == {"pack"}
    assert "--dry-run" in offers("pack", "--d")
    assert offers("signal", "--method", "che") == {"chebyshev"}
    assert offers("spectrum", "d") == {"dos", "dispersion"}
    assert "packing.friction=" in offers("pack", "--set", "packing.fr")
    assert offers("pack", "--set", "packing.kind=tri") == {"packing.kind=triangular"}
    assert offers("pack", "--set", "packing.kind", "=", "tri") == {"triangular"}
    assert offers("pack", "z") == {"zz.cfg"} and offers("pack", "-o", "z") == {"zz.cfg", "zz.png"}
    assert "packing.friction" in offers("help", "packing.f")


def test_other_shells(folder):
    """Where these shells are installed: the scripts parse, and fish offers words and files."""
    for shell in ("zsh", "fish"):
        if shutil.which(shell):
            (folder / shell).write_text(run("completion", shell).stdout)
            shell_says(shell, "-n", folder / shell)
    if shutil.which("fish"):
        for line, word in (("pa", "pack"), ("signal --method che", "chebyshev"), ("pack z", "zz.cfg")):
            text = shell_says("fish", "-c", f"source fish; complete -C '{COMMAND} {line}'")
            assert word in {row.split("\t")[0] for row in text.splitlines()}, (line, text)


def test_defaults(folder):
    """Without a scene and without --set all keys have their defaults."""
    text = run("pack", "-o", "q.txt", "--dry-run").stdout
    assert re.search(r"^packing\t1\t", text, re.M)
    # the real thing, stopped by a limit that names the key: the work had begun with the defaults
    assert names_all(run("pack", "-o", "q.txt", "--set", "packing.max_steps=10", status=1).stderr, "packing.max_steps")


def test_low_boxes():
    flat = ["--set", "packing.dimension=3"]
    done = run("pack", *flat, "--dry-run", "-o", "q.h5")
    assert len(done.stderr.splitlines()) == 1 and names_all(done.stderr, "packing.grains packing.width"), done.stderr
    assert not run("pack", *flat, "--dry-run", "--quiet", "-o", "q.h5").stderr
    # what it says would be right is right
    grains, width = re.search(r"packing.grains = (\d+), or packing.width = ([\d.]+)", done.stderr).groups()
    for key in (f"packing.grains={grains}", f"packing.width={width}"):
        assert not run("pack", *flat, "--set", key, "--dry-run", "-o", "q.h5").stderr
    low = ["--set", "packing.grains=60", "--set", "packing.width=16", "--set", 'packing.protocol="quick"']
    run("pack", *low, "-o", "low.txt")
    for command in (["signal"], ["front"], ["moduli"], ["modes", "--lowest", 3]):
        done = run(*command, "low.txt")
        assert names_all(done.stderr.splitlines()[0], "low.txt 6"), (command, done.stderr)
        assert sum("warning" in line for line in done.stderr.splitlines()) == 1, (command, done.stderr)
        assert not run(*command, N200).stderr and not run(*command, "low.txt", "--quiet").stderr


def test_refused_frequencies():
    modes = [line.split("\t") for line in run("modes", N200).stdout.splitlines() if not line.startswith("#")]
    omega = next(row[1] for row in modes[100:])
    done = run("spectrum", "harmonic", N200, "--at", f"0.05,{omega}", status=1)
    rows = [line.split("\t") for line in done.stdout.splitlines() if not line.startswith("#")]
    assert len(rows) == 3 and "nan" not in rows[1][1:5] and set(rows[2][1:]) == {"nan"}, rows
    assert re.search("^# refused = 1 ", done.stdout, re.M) and len(done.stderr.splitlines()) == 1
    assert not run("spectrum", "harmonic", N200, "--at", omega, status=1).stdout


def test_errors_of_signals():
    run("signal", N200, "--method", "sparse", "--modes", 20, "-o", "few.tsv")
    assert names_all(run("front", "few.tsv", status=1).stderr, "few.tsv error")
    run("signal", N200, "-o", "all.tsv")
    text = pathlib.Path("all.tsv").read_text()
    assert not run("front", "all.tsv").stderr
    peak = float(run("front", "all.tsv").stdout.splitlines()[-1].split("\t")[5])
    for part, status, lines in ((0.03, 0, 1), (0.3, 1, 1)):
        pathlib.Path("error.tsv").write_text(re.sub(r"error .*|error = .*", lambda m: re.sub(
            r"[\d.e+-]+$", repr(part * peak), m.group()), text))
        assert len(run("front", "error.tsv", status=status).stderr.splitlines()) == lines, part


def test_progress_in_a_file():
    done = run("reproduce", "blackmore2011", "--only", "errata,fig1,symbols")
    assert all(names_all(done.stderr, item) for item in ("errata", "fig1", "symbols")), done.stderr
    assert not run("reproduce", "blackmore2011", "--only", "errata", "--quiet").stderr


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-terminal-") as name:
        folder = pathlib.Path(name)
        os.chdir(folder)
        for test in (test_help_of_keys, test_examples_of_keys, test_h_is_help,
                     test_completions_know_everything, test_low_boxes, test_refused_frequencies, test_errors_of_signals,
                     test_progress_in_a_file):
            test()
            print(test.__name__, "ok")
        for test in (test_bash, test_other_shells, test_defaults):
            reason = test(folder)
            print(test.__name__, reason or "ok")
        os.chdir(SOURCE)


if __name__ == "__main__":
    main()
