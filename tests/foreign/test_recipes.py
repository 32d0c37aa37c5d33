"""The recipes of docs/recipes.md that need other programs, as they stand there.

usage: test_recipes.py COMMAND SOURCE_DIR
"""
import importlib.util
import pathlib
import re
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
from test_readme import console_commands, run_page, SOURCE  # noqa: E402

PAGE = "docs/recipes.md"
HERE = {
    "octave": lambda: shutil.which("octave"),
    "Rscript": lambda: shutil.which("Rscript"),
    "gnuplot": lambda: shutil.which("gnuplot"),
    "pandas": lambda: importlib.util.find_spec("pandas") and importlib.util.find_spec("matplotlib"),
}
READERS = ("python3", "octave", "Rscript", "gnuplot")


def forces(scratch):
    rows = [line.split("\t") for line in (scratch / "signal.tsv").read_text().split("\n") if line and line[0] != "#"]
    return [float(row[1]) for row in rows[1:]]


def lacks(output, number):
    """Whether no word of an output is this number, with every bit."""
    words = re.findall(r"[-+\d.e]+", output)
    return not any(re.fullmatch(r"[-+]?\d*\.?\d+(e[-+]?\d+)?", word) and float(word) == number for word in words)


def look(scratch, outputs):
    """Each recipe prints the largest force."""
    largest = max(forces(scratch))
    assert lacks("1.2 a-b", largest) and not lacks(f"is {largest!r} at 3", largest)
    wrong = [command for command, output in outputs if command.split()[0] in READERS and lacks(output, largest)]
    return f"{PAGE}: not the largest force, {largest!r}: {wrong}" if wrong else None


def main():
    found = [name for name, here in HERE.items() if here()]
    print("found:", *found)
    if not found:
        sys.exit(77)
    text = (SOURCE / PAGE).read_text()
    faults = [f"{PAGE}: no recipe for {name}" for name in HERE if not console_commands(text, (f"```console {name}",))]
    fault = run_page(PAGE, look, ("```console", *(f"```console {name}" for name in found)))
    print(*faults, fault or "", sep="\n")
    sys.exit(1 if faults or fault else 0)


if __name__ == "__main__":
    main()
