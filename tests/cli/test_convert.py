"""convert between HDF5, text and tables: every way there is, no bit lost, and nothing of others replaced. Files of other
programs are in tests/shows/formats.

usage: test_convert.py COMMAND SOURCE_DIR
"""
import os
import pathlib

from command import N200, main, pack, refused, run, tried, warmly
from common import names_all

GRAINS = """# width = 10
# height = 4
# pressure = 1e-4
# friction = 0.5
id x y radius
a 1 0.5 0.5
b 1.9 0.5 0.5
7 -5 2 0.5
"""
CONTACTS = """i j nx ny overlap Ft
a b 1 0 0.1 1e-3
7 b 0.6 0.8 0.05 -1e-4
a bottom 0 -1 0.001 0
"""


def read(name):
    return pathlib.Path(name).read_bytes()


def convert(*words, way=warmly):
    return run("convert", *words, "--force", way=way).stderr


def numbers(file):
    """Header, grains, and contacts (sorted) of a text packing, as exact doubles."""
    lines = [line.split() for line in open(file) if line.strip() and not line.startswith("#")]
    n = int(lines[0][1])
    contacts = sorted(tuple(map(float, line)) for line in lines[1 + n:])
    return dict(zip(lines[0][::2], map(float, lines[0][1::2]))), [tuple(map(float, line)) for line in lines[1:1 + n]], contacts


def round_trips():
    """Also without friction, where a force of zero has no sign."""
    for original in (N200, pack("smooth.txt", grains=40, width=8, friction=0)):
        for name in ("g.tsv", "c.tsv"):
            pathlib.Path(name).unlink(missing_ok=True)
        assert names_all(convert(original, "a.h5", way=tried), "a.h5")
        convert("a.h5", "b.txt")
        assert numbers(original) == numbers("b.txt"), "text -> HDF5 -> text, every number the same"
        convert("b.txt", "c.h5")
        convert("a.h5", "--grains", "g.tsv", "--contacts", "c.tsv")
        convert("-", "d.h5", "--grains", "g.tsv", "--contacts", "c.tsv")
        assert read("a.h5") == read("c.h5") == read("d.h5"), "by text and by tables, every byte the same"
        assert b"-0\n" not in read("c.tsv")


def ways():
    for path in pathlib.Path().iterdir():
        path.unlink()
    pathlib.Path("g.tsv").write_text(GRAINS)
    pathlib.Path("c.tsv").write_text(CONTACTS)
    tables = ["--grains", "g.tsv", "--contacts", "c.tsv"]
    convert("new.txt", *tables)  # one packing that is not there: made
    assert numbers("new.txt")[0]["p"] == 1e-4  # what the rows become: tests/shows/formats/test_pair.py
    for words in (["-o", "o.txt", *tables], ["g.tsv", "o.txt", "--contacts", "c.tsv"], ["-", "o.txt", *tables]):
        convert(*words)
        assert read("o.txt") == read("new.txt"), words
    convert("new.txt", "eg.tsv", "--contacts", "ec.tsv")
    convert("new.txt", "--grains", "fg.tsv", "--contacts", "fc.tsv")
    assert read("eg.tsv") == read("fg.tsv") and read("ec.tsv") == read("fc.tsv")
    convert("g.tsv", "set.txt", "--contacts", "c.tsv", "--set", "pressure=2e-5", "--set", "packing.friction=0.3")
    assert numbers("set.txt")[0]["p"] == 2e-5 and numbers("set.txt")[0]["mu"] == 0.3
    assert convert("new.txt", "P.h5", "--quiet") == ""


REFUSED = """2 | | 
2 | | P.h5
2 | | P.h5 Q.h5 R.h5
2 | .h5 .txt | P.h5 Q.xyzzy
2 | .h5 .txt | P.h5 Q
2 | -o | P.h5 Q.h5 -o R.h5
2 | --grains | P.h5 Q.h5 --grains g.tsv
2 | P.h5 | P.h5 --grains g.tsv --contacts c.tsv
2 | --set | P.h5 Q.h5 --set pressure=1
2 | colour=red | g.tsv Q.h5 --contacts c.tsv --set colour=red
2 | pressure x | g.tsv Q.h5 --contacts c.tsv --set pressure=x
2 | --bogus | P.h5 --bogus
2 | old.h5 | P.h5 old.h5 --force
2 | notes.txt | P.h5 notes.txt --force
2 | --force | P.h5 new.txt
2 | --force | new.txt P.h5
1 | absent | P.h5 absent/Q.h5
1 | nowhere.h5 | nowhere.h5 Q.h5
1 | nowhere.tsv | g.tsv Q.h5 --contacts nowhere.tsv
1 | bad.tsv:7 x nan | bad.tsv Q.h5 --contacts c.tsv
1 | bad.txt:1 | bad.txt Q.h5
1 | regular file | g.tsv full.h5 --contacts c.tsv
1 | No space left | g.tsv full.txt --contacts c.tsv
"""


def refusals():
    for name, text in (("old.h5", "my notes"), ("notes.txt", "my notes"), ("bad.tsv", GRAINS.replace("1.9", "nan")),
                       ("bad.txt", "N 3 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0 contacts 0 bottom 0 top 0\n1 1 0.5 0\n")):
        pathlib.Path(name).write_text(text)
    for name in ("full.h5", "full.txt"):
        os.symlink("/dev/full", name)
    before = {path.name: not path.is_symlink() and path.read_bytes() for path in pathlib.Path().iterdir()}
    for line in REFUSED.splitlines():
        status, names, words = (part.strip() for part in line.split("|"))
        refused(names, "convert", *words.split(), status=int(status), way=warmly if words else tried)
        assert {path.name: not path.is_symlink() and path.read_bytes() for path in pathlib.Path().iterdir()} == before, words
    convert("P.h5", "P.h5")
    assert read("P.h5") == before["P.h5"], "a file onto itself"


main(round_trips, ways, refusals)
