"""sonopack demo: a packing of glass beads, its moduli, a knock and a page to look at, by the commands that it shows."""
from __future__ import annotations

import argparse
import pathlib
import shlex
import subprocess
import sys

from ._command import Failed, Parser, program

_BEADS = ["material.E=70e9", "material.nu=0.22", "material.rho=2500", "material.d=1e-3", "packing.grains=400",
          "packing.width=20", "packing.pressure=100 kPa"]
#: what is said, and the command
_STEPS = [
    ("400 glass beads of 1 mm, compressed to 100 kPa", ["pack", *(word for key in _BEADS for word in ("--set", key)),
                                                        "--units", "si", "-o", "beads.h5"]),
    ("Moduli in kPa, and the speeds of long waves in m/s", ["moduli", "beads.h5", "--units", "si"]),
    ("A knock at the bottom: the force at the top against time", ["signal", "beads.h5", "--units", "si", "-o", "signal.tsv"]),
    ("When the first front arrives, and how strong it is", ["front", "signal.tsv"]),
    ("The signal as a figure", ["plot", "signal", "signal.tsv", "-o", "signal.svg"]),
    ("The packing, its force chains and the wave, for a browser", ["view", "beads.h5", "-o", "beads.html"])]


def parser() -> Parser:
    return Parser("demo", usage="%(prog)s [--force] [-o FOLDER]",
                  description="Makes a packing of glass beads, its moduli, a signal, a figure and a page in some seconds, and "
                              "shows the commands.\nThey work by themselves in the folder, sonopack-demo unless -o names "
                              "another.")


def run(arguments: argparse.Namespace) -> None:
    command, folder = program(), pathlib.Path(arguments.output or "sonopack-demo")
    folder.mkdir(parents=True, exist_ok=True)
    for text, words in _STEPS:
        print(f"\n{text}:\n$ sonopack {shlex.join(words)}", flush=True)
        done = subprocess.run([command, *words, "--quiet", *["--force"] * arguments.force], cwd=folder, text=True,
                              stdout=None if sys.stdout.isatty() else subprocess.PIPE)  # a terminal gets aligned tables
        if done.returncode != 0:
            raise Failed(f"sonopack {words[0]} failed with status {done.returncode}")
        for line in (done.stdout or "").splitlines():
            if not line.startswith("# ") or line.startswith("# units"):
                print(f"    {line}")
    print(f"\nOpen {folder / 'beads.html'} in a browser. `sonopack help' lists what else there is.")
