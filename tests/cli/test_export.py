"""Signals and tables as SAC, SLIST and MAT-files: every number is that of the table. Packings for other programs are in
tests/shows/formats/test_export.py.

usage: test_export.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import struct

import numpy as np
import scipy.io

from command import MATERIAL, main, pack, refused, run, table

# The words of a SAC header in their order, "-" for those that no program may use.
SAC_NUMBERS = ("delta depmin depmax scale odelta b e o a - t0 t1 t2 t3 t4 t5 t6 t7 t8 t9 f resp0 resp1 resp2 resp3 resp4 "
               "resp5 resp6 resp7 resp8 resp9 stla stlo stel stdp evla evlo evel evdp mag user0 user1 user2 user3 user4 "
               "user5 user6 user7 user8 user9 dist az baz gcarc - - depmen cmpaz cmpinc xminimum xmaximum yminimum "
               "ymaximum - - - - - - -").split()
SAC_INTEGERS = ("nzyear nzjday nzhour nzmin nzsec nzmsec nvhdr norid nevid npts - nwfid nxsize nysize - iftype idep iztype - "
                "iinst istreg ievreg ievtyp iqual isynth imagtyp imagsrc - - - - - - - - leven lpspol lovrok lcalda -").split()
SAC_NAMES = ("kstnm kevnm - khole ko ka kt0 kt1 kt2 kt3 kt4 kt5 kt6 kt7 kt8 kt9 kf kuser0 kuser1 kuser2 kcmpnm knetwk kdatrd "
             "kinst").split()


def sac(path):
    """{name: value} of what the header knows, and the values."""
    data = pathlib.Path(path).read_bytes()
    assert len(SAC_NUMBERS) == 70 and len(SAC_INTEGERS) == 40 and len(SAC_NAMES) == 24
    numbers, integers = struct.unpack("<70f", data[:280]), struct.unpack("<40i", data[280:440])
    head = {name: x for name, x in zip(SAC_NUMBERS, numbers) if x != -12345}
    head.update({name: x for name, x in zip(SAC_INTEGERS[:35], integers) if x != -12345})
    head.update(zip(SAC_INTEGERS[35:], integers[35:]))
    names = {name: data[440 + 8 * k:448 + 8 * k].decode("ascii") for k, name in enumerate(SAC_NAMES)}
    names["kevnm"] += names.pop("-")
    head.update({name: text.strip() for name, text in names.items() if not text.startswith("-12345")})
    assert head["nvhdr"] == 6 and len(data) == 632 + 4 * head["npts"], (head, len(data))
    return head, np.frombuffer(data[632:], "<f4")


def one_signal():
    pack("P.h5", grains=60, width=8)
    for ending in ("sac", "mat"):
        run("signal", "P.h5", "--points", 201, "-o", f"s.{ending}")
    own = table("signal", "P.h5", "--points", 201)
    t, f = own["t"], own["F"]
    head, values = sac("s.sac")
    assert np.array_equal(values, f.astype("f4")), "every value, in single precision"
    assert (head["npts"], head["iftype"], head["leven"], head["b"]) == (201, 1, 1, 0)
    assert (head["delta"], head["e"]) == (np.float32(t[1]), np.float32(t[-1]))
    assert (head["depmin"], head["depmax"]) == (values.min(), values.max())
    assert abs(head["depmen"] - f.mean()) < 1e-6 * np.abs(f).max()
    assert (head["kstnm"], head["kcmpnm"], head["kuser0"], head["kuser1"]) == ("top", "F", "E*d^2", "tau"), head
    assert head["kevnm"] == "impulse" and abs(head["user0"] - 1e-4) < 1e-10, head
    mat = scipy.io.loadmat("s.mat", squeeze_me=True)
    assert np.array_equal(mat["t"], t) and np.array_equal(mat["F"], f), "every bit"
    assert mat["units"]["F"][()] == "E* d^2" and any("height" in line for line in mat["comments"])
    run("signal", "P.h5", "--points", 201, "-o", "si.sac", "--units=si", MATERIAL)
    modulus = 70e9 / (1 - 0.22**2)
    si, newton = sac("si.sac")
    assert (si["kuser0"], si["kuser1"]) == ("N", "s")
    assert abs(si["delta"] / (head["delta"] * 1e-3 * (2500 / modulus)**0.5) - 1) < 1e-6
    assert np.abs(newton - modulus * 1e-6 * values).max() < 1e-6 * np.abs(newton).max()


def several_signals():
    words = ["signal", "P.h5", "--planes", 2, "--points", 31]
    for ending in ("sac", "slist"):
        run(*words, "-o", f"p.{ending}")
    own = table(*words)
    heads = []
    for k in (1, 2):
        head, values = sac(f"p-F{k}.sac")
        heads.append(head["kstnm"])
        assert np.array_equal(values, own[f"F{k}"].astype("f4")), k
    assert heads[0] != heads[1] and not os.path.exists("p.sac"), "a file for each signal"
    for k, part in enumerate(pathlib.Path("p.slist").read_text().split("TIMESERIES ")[1:], 1):
        first, *rest = part.split("\n")
        cells = first.replace(",", "").split()
        assert cells[1:3] == ["31", "samples"] and cells[6:8] == ["SLIST", "FLOAT"] and len(cells) == 9, first
        assert abs(float(cells[3]) * own["t"][1] - 1) < 1e-15 and cells[0].count("_") == 4, first
        assert np.array_equal(np.array(" ".join(rest).split(), float), own[f"F{k}"]), "every bit"
    run("check", "P.h5", "-o", "check.mat")
    assert scipy.io.loadmat("check.mat", squeeze_me=True)["file"] == "P.h5", "columns of text"


def refusals():
    refused("m.sac", "modes", "P.h5", "-o", "m.sac")
    refused("--force", "signal", "P.h5", "--points", 31, "--planes", 2, "-o", "p.sac")
    pathlib.Path("notes.sac").write_text("my notes")
    refused("notes.sac", "signal", "P.h5", "-o", "notes.sac", "--force")
    for ending in ("sac", "slist", "mat"):
        os.symlink("/dev/full", f"o.{ending}")
        refused("No space left", "signal", "P.h5", "--points", 11, "-o", f"o.{ending}", status=1)


main(one_signal, several_signals, refusals, begun=True)
