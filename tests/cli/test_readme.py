"""The commands of the README and of the guide work as written: every line that begins with `$ ` in a
```console block, in the order of the page, in one scratch folder with the example scenes. Blocks marked ```console long
are left out. A block such as ```python draw.py is a file of that name.

usage: test_readme.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from warm import warm

COMMAND, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
PAGES = ("README.md", "docs/guide.md", "docs/units.md")
# less work for the same commands, where no number that they print is looked at: in the scenes, and in the commands
SMALLER = [("packings/single.cfg", "grains = 600;", "grains = 120;"),
           ("packings/ctof-quick.cfg", r"values = \[200, 600\];", "values = [60, 120];"),
           ("packings/ctof-quick.cfg", "width = 24;", "width = 8;"),
           ("packings/glass.cfg", "grains = 400;", "grains = 150;"), ("packings/glass.cfg", '"6 mm"', '"4.5 mm"')]
SHORTER = {"packing.grains=200": "packing.grains=160", "packing.grains=300": "packing.grains=150",
           "packing.grains=400": "packing.grains=150", "--seconds 0.1": "--seconds 0.01"}


def console_commands(text, fences=("```console",)):
    """(line number, command) of the blocks that begin so; a trailing backslash continues a command."""
    commands, inside, pending = [], False, None
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith("```"):
            inside = line.strip() in fences
            pending = None
        elif inside and pending:
            pending = (pending[0], pending[1][:-1] + line)
        elif inside and line.startswith("$ "):
            pending = (number, line[2:])
        if pending and not pending[1].endswith("\\"):
            commands.append(pending)
            pending = None
    return commands


def files_of(text):
    """(name, content) of the blocks that begin with a language and the name of a file: ```python draw.py"""
    return re.findall(r"^```\w+ ([\w-]+\.\w+)\n(.*?)^```$", text, re.M | re.S)


def check_the_reader():
    text = "```console\n$ one\noutput $ no\n$ two \\\n  more\n```\n```console long\n$ never\n```\n$ never\n```sh\n$ never\n```\n"
    found = console_commands(text)
    assert found == [(2, "one"), (4, "two   more")], found
    assert files_of("```python a.py\nx = 1\n```\n```python\ny\n```\n") == [("a.py", "x = 1\n")]


def make_small(scratch):
    """The scenes and packings that the commands of a page begin with."""
    for name, pattern, smaller in SMALLER:
        text, count = re.subn(pattern, smaller, (scratch / name).read_text())
        assert count == 1, f"{name} has not one {pattern}"
        (scratch / name).write_text(text)
    for name, grains, width in ((200, 60, 8), (600, 300, 12)):
        small = warm(COMMAND) / f"{grains}.txt"
        if not small.exists():
            subprocess.run([COMMAND, "pack", "-q", "--set", f"packing.grains={grains}", "--set",
                            f"packing.width={width}", "-o", small], check=True, stdout=subprocess.DEVNULL)
        shutil.copy(small, scratch / f"packings/reference/packing_N{name}_p1e-4.txt")


def shorter(command):
    for words, fewer in SHORTER.items():
        command = command.replace(words, fewer)
    return command


def run_page(page, then=lambda scratch, outputs: None, fences=("```console",), small=False):
    """All commands of a page in a fresh folder; the fault, or what `then` finds there and in [(command, its output)]."""
    text = (SOURCE / page).read_text()
    commands = console_commands(text, fences)
    with tempfile.TemporaryDirectory(prefix="sonopack-readme-") as folder:
        scratch = pathlib.Path(folder)
        shutil.copytree(SOURCE / "packings", scratch / "packings")
        shutil.copytree(SOURCE / "tests/foreign/samples", scratch / "samples")
        (scratch / "bin").mkdir()
        (scratch / "bin/sonopack").symlink_to(warm(COMMAND) / "sonopack")
        (scratch / "bin/python3").symlink_to(sys.executable)  # which has what the tests need
        for name, content in files_of(text):
            (scratch / name).write_text(content)
        if small:
            make_small(scratch)
        env = dict(os.environ, PATH=f"{scratch / 'bin'}:{os.environ['PATH']}", LC_ALL="C.UTF-8", HOME=folder,
                   PYTHONPATH=str(COMMAND.parent / "python"))
        outputs = []
        for number, command in commands:
            print(f"{page}:{number}: $ {command}", flush=True)
            words = ["bash", "-o", "pipefail", "-c", shorter(command) if small else command]
            result = subprocess.run(words, cwd=scratch, env=env, text=True, capture_output=True,
                                    stdin=subprocess.DEVNULL, timeout=1200)
            if result.returncode:
                return f"{page}:{number}: {command}: exit status {result.returncode}\n{result.stdout}{result.stderr}"
            outputs.append((command, result.stdout))
        return then(scratch, outputs) if commands else f"{page}: no commands found"


def run_pages(pages):
    faults = [fault for page in pages for fault in [run_page(page, small=True)] if fault]
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    check_the_reader()
    run_pages(PAGES)
