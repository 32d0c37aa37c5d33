"""sonopack demo: what it makes, what it shows, and that it replaces nothing unasked.

usage: test_demo.py COMMAND SOURCE_DIR
"""
import pathlib
import re
import shlex
import subprocess
import sys

from command import COMMAND, main, run, table


def demo():
    shown = run("demo").stdout
    made = pathlib.Path("sonopack-demo")
    assert {path.name for path in made.iterdir()} == {"beads.h5", "signal.tsv", "signal.svg", "beads.html"}
    commands = [shlex.split(line) for line in re.findall(r"^\$ sonopack (.*)$", shown, re.M)]
    assert [words[0] for words in commands] == ["pack", "moduli", "signal", "front", "plot", "view"]
    own = table(*commands[1], cwd=made)  # a command by itself says what the demo said
    assert own.rows[0] == re.search(r"^    (beads.h5\t.*)$", shown, re.M)[1].split("\t")
    code = "import pty, sys; sys.exit(pty.spawn(sys.argv[1:]))"
    on_terminal = subprocess.run([sys.executable, "-c", code, COMMAND, "demo", "-o", "other"], capture_output=True, text=True,
                                 stdin=subprocess.DEVNULL).stdout
    assert re.search(r"^beads.h5 +100 ", on_terminal, re.M), on_terminal  # rounded, aligned
    assert "--force" in run("demo", status=1).stderr
    run("demo", "--force", "-o", made)
    (made / "file").touch()
    assert "file" in run("demo", "-o", made / "file", status=1).stderr


main(demo)
