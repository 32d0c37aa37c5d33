"""The commands of the README and of the guide work as written: every line that begins with `$ ` in a ```console block,
in the order of the page, in one scratch folder with the example scenes. Blocks marked ```console long are left out.

usage: test_readme.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

COMMAND, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
PAGES = ("README.md", "docs/guide.md", "docs/units.md")


def console_commands(text):
    """(line number, command) of the console blocks; a trailing backslash continues a command."""
    commands, inside, pending = [], False, None
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith("```"):
            inside = line.strip() == "```console"
            pending = None
        elif inside and pending:
            pending = (pending[0], pending[1][:-1] + line)
        elif inside and line.startswith("$ "):
            pending = (number, line[2:])
        if pending and not pending[1].endswith("\\"):
            commands.append(pending)
            pending = None
    return commands


def check_the_reader():
    text = "```console\n$ one\noutput $ no\n$ two \\\n  more\n```\n```console long\n$ never\n```\n$ never\n```sh\n$ never\n```\n"
    found = console_commands(text)
    assert found == [(2, "one"), (4, "two   more")], found


def run_page(page):
    """All commands of a page in a fresh folder; the fault, or None."""
    commands = console_commands((SOURCE / page).read_text())
    with tempfile.TemporaryDirectory(prefix="sonopack-readme-") as folder:
        scratch = pathlib.Path(folder)
        shutil.copytree(SOURCE / "packings", scratch / "packings")
        (scratch / "bin").mkdir()
        (scratch / "bin/sonopack").symlink_to(COMMAND)
        env = dict(os.environ, PATH=f"{scratch / 'bin'}:{os.environ['PATH']}", LC_ALL="C.UTF-8", HOME=folder)
        for number, command in commands:
            print(f"{page}:{number}: $ {command}", flush=True)
            result = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=scratch, env=env, text=True,
                                    capture_output=True, stdin=subprocess.DEVNULL, timeout=1200)
            if result.returncode:
                return f"{page}:{number}: {command}: exit status {result.returncode}\n{result.stdout}{result.stderr}"
    return None if commands else f"{page}: no commands found"


def check_links(page):
    """Links of a page to files of the checkout lead somewhere."""
    faults = []
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", (SOURCE / page).read_text()):
        if not re.match(r"\w+:", target) and not ((SOURCE / page).parent / target).exists():
            faults.append(f"{page}: a link to {target}, which is not there")
    return faults


def main():
    check_the_reader()
    faults = [fault for page in PAGES for fault in [run_page(page)] if fault]
    for page in [*PAGES, "docs/physics.md", "docs/reproduction.md", "docs/DESIGN.md", "CHANGELOG.md"]:
        faults += check_links(page)
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
