"""Parameters that are absurd yet legal, or not even that: each ends as this table says, with the key or option at fault in
its reason; long work tells its time; what would do nothing is refused.

usage: test_absurd.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import pty
import re
import shutil
import subprocess
import sys
import tempfile

import absurd
from common import expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
MATERIAL = "--material=E=70e9,nu=0.22,rho=2500,d=1e-3"

# command line, exit status, what the reason names
CASES = [
    # options that would do nothing
    ("coda P.h5 --trials 3 --rows 5", 2, "--rows"),
    ("coda P.h5 --before signal.tsv --after signal.tsv --points 5", 2, "--points"),
    ("coda P.h5 --before signal.tsv --after signal.tsv --change 0.1", 2, "--change"),
    ("uncertainty P.h5 --radius 1e-6 --gap 0.1", 2, "--gap"),
    ("uncertainty P.h5 --radius 1e-6 --missing-force 0.1", 2, "--missing-force"),
    ("uncertainty P.h5 --radius 1e-6 --front-only --margin 1", 2, "--margin"),
    ("sensitivity P.h5 --of cl --until 5", 2, "--until"),
    ("sensitivity P.h5 --of cl --source velocity", 2, "--source"),
    ("sensitivity P.h5 --of t10 --margin 5", 2, "--margin"),
    # a window of 10^9 takes gigabytes and minutes before it is refused, if nobody looks
    ("sensitivity Q.txt --until 1e9", 1, "Q.txt"),
    ("sensitivity Q.txt --of F --at 1e9", 1, "Q.txt"),
    ("signal Q.txt --method chebyshev --until 1e9", 1, "until"),
    ("signal P.h5 --points 1e7", 2, "--points"),
    ("signal P.h5 --until inf", 2, "--until"),
    ("signal P.h5 --until 5e-324", 2, "--until"),
    ("signal P.h5 --until 1e-9", 0, ""),
    ("signal P.h5 --points 2", 0, ""),
    ("signal P.h5 --planes 1000 --points 100000", 1, "100000 1000"),  # 5 GB
    ("signal P.h5 --planes 1000 --points 100000 --dry-run", 1, "100000 1000"),
    ("signal P.h5 --threads 10000", 2, "--threads"),
    ("signal P.h5 --threads 4096", 0, ""),
    ("signal P.h5 --from part:5:1", 2, "--from"),
    ("signal P.h5 --from part:3:3", 2, "--from"),
    ("signal P.h5 --pulse gauss:1e300", 2, "1e300"),
    ("signal P.h5 --pulse file:/dev/null", 1, "/dev/null"),
    ("signal P.h5 --detector grain:200", 2, "200 199"),
    ("modes P.h5 --lowest 2147483647", 2, "--lowest"),
    ("modes P.h5 --band 2:1", 2, "--band"),
    ("modes P.h5 --band 1e300:inf", 0, ""),
    ("spectrum dos P.h5 --bins 1000000000", 2, "--bins"),
    ("spectrum dispersion P.h5 --waves 2147483647", 2, "--waves"),
    ("spectrum harmonic P.h5 --at 1e-300:1e300:3", 2, "--at"),
    ("chain front --grains 10,20 --pressure", 2, "--pressure"),
    ("chain modes --grains 1", 0, ""),
    ("chain modes --grains 0", 2, "--grains"),
    ("chain localisation --grains 1", 2, "--grains"),
    ("design P.h5 --goal band:2:1", 2, "band"),
    ("statics P.h5 P.h5 P.h5 P.h5", 0, ""),
    ("front P.h5 --source velocity P.h5", 0, ""),
    ("pack --set packing.grains=1 -o single.h5", 0, ""),
    ("pack --set packing.kind=chain --set packing.grains=1 -o one.h5", 0, ""),
    ("pack --set packing.grains=100000000 -o x.h5", 1, ""),
    ("pack --set packing.grains=100000001 -o x.h5", 2, "packing.grains"),
    ("pack --set packing.grains=10000000 --dry-run -o x.h5", 0, ""),
    ("pack --set packing.cell=1 -o x.h5", 2, "packing.cell piston periodic box"),
    ("study scene.cfg --set study.samples=1000000000 --dry-run --store new", 2, "study.samples"),
    ("study scene.cfg --set study.samples=1000000 --dry-run --store new", 0, ""),
    ("study scene.cfg --jobs 10000 --store store", 2, "--jobs"),
    ("study scene.cfg --shard 3/2 --store store", 2, "--shard"),
    ("table spectrum --bins 2147483648 --store store", 2, "--bins"),
    ("plot transport modes.tsv -o x.svg", 1, "modes.tsv"),
    ("plot amplitude signal.tsv -o x.svg", 1, "signal.tsv"),
    ("plot transport P.h5 -o x.svg", 1, "P.h5"),
    ("convert P.h5 P.h5", 2, "P.h5"),
    ("signal signal.tsv -o signal.tsv --force", 1, "signal.tsv"),
    ("modes P.h5 -o P.h5 --force", 2, "P.h5"),
    ("signal P.h5 -o store --force", 2, "store"),
]
LITERAL = [  # words that a shell would split
    (["chain", "front", "--grains", "10,20", "--pressure", "100 kPa", MATERIAL], 0, ""),
    (["chain", "front", "--grains", "10,20", "--pressure", "100 kPa"], 2, "--pressure"),
    (["signal", "P.h5", "--until", "50 us"], 2, "--until"),
    (["signal", "P.h5", "--until", "50 us", MATERIAL], 0, ""),
    (["signal", "x" * 5000], 1, ""),
    (["signal", "P.h5", "-o", "y/" * 2040 + "t.tsv"], 1, ""),
    (["signal", "P.h5", "-o", "a\nb 'c' \"d\" é.tsv"], 0, ""),
    (["front", "a\nb 'c' \"d\" é.tsv"], 0, ""),
    (["signal", "P.h5", "-o", "./-o.tsv"], 0, ""),
    (["front", "--", "-o.tsv"], 0, ""),
    (["signal", ""], 1, ""),
    (["statics", *["P.h5"] * 300], 0, ""),
]


def check_table(folder):
    for words, wanted, reason in [(case[0].split(), *case[1:]) for case in CASES] + LITERAL:
        status, text, _, memory = absurd.run(COMMAND, words, folder, 60)
        if text.startswith("sonopack " + words[0] + ": "):
            text = text.split(": ", 1)[1]
        name = " ".join(words)[:120]
        expect(status == wanted, f"{name}: exit status {status}, must be {wanted}: {text[:300]}")
        expect(not wanted or not reason or names_all(text.split("\n")[0], reason), f"{name}: {text[:200]!r} names no {reason}")
        expect(memory < 1000, f"{name}: {memory:.0f} MB, without a word")


def check_rows(folder):
    """A frequency without modes leaves the others their values."""
    status, text, _, _ = absurd.run(COMMAND, ["transport", "P.h5", "--quantity", "split", "--at", "0.001,0.4", "-o", "r.tsv"],
                                    folder, 60)
    rows = [line.split("\t") for line in pathlib.Path(folder, "r.tsv").read_text().splitlines() if line[0] != "#"][1:]
    expect(status == 0 and [row[-1] for row in rows] == ["0", "1"] and "nan" not in rows[1], f"transport: {rows}, {text}")
    expect(names_all(text, "0.001"), f"transport does not say which frequency has no value: {text!r}")


def check_time(folder):
    """Long work that knows no fraction of it tells the time and the memory so far, on a terminal."""
    for words in ("spectrum dos P.h5 --bins 1000000", "signal P.h5 --points 10000000"):
        master, slave = pty.openpty()
        process = subprocess.Popen([COMMAND, *words.split(), "-o", "never.tsv"], cwd=folder, stderr=slave,
                                   stdin=subprocess.DEVNULL)
        os.close(slave)
        said = os.read(master, 4096).decode()
        expect(re.search(words.split()[0] + r".*\d+ s\b.*GB", said), f"{words}: no progress: {said!r}")
        process.terminate()
        process.wait()
        os.close(master)


def main():
    home = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-absurd-"))
    folder = home / "b"
    folder.mkdir()
    try:
        absurd.seeds(COMMAND, folder, SOURCE)
        check_table(folder)
        check_rows(folder)
        check_time(folder)
    finally:
        shutil.rmtree(home)
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
