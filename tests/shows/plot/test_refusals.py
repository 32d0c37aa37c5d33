"""What sonopack plot refuses: rows of command line, status, and a part of the reason."""
import numpy as np
import pytest

import sonopack
from sonopack import SonopackError, Status
from sonopack.plot import command
from sonopack.plot._inputs import Input
from sonopack.plot._motion import find_mode, find_snapshots

from test_command import GLASS, SIGNAL, SPEEDS

TEXTS = {
    "s.tsv": SIGNAL, "bare.tsv": "t\tF\n0\t0\n1\t1\n2\t0\n",
    "c.tsv": SPEEDS, "v.tsv": SIGNAL.replace("t [d/sqrt(E* / rho)] F [E* d^2]", "t [ms] F [V]"),
    "bad.tsv": "p\tc_tof\n1e-4\t-1\n", "old.svg": "<svg/>", "mine.svg": "mine",
    "text.tsv": "t\ty0\ty1\n0\ta\t1\n", "none.tsv": "p\tc\n1\t2\n", "y0.tsv": "t\ty0\n0\t0\n1\t0\n",
    "rho.tsv": "t\ty1\trho1\trho2\n0\t1\t1\t1\n1\t1\t1\t1\n", "work.tsv": "tap\twork\n1\t1\n",
    "row.tsv": "t\ty1\n0\t1\n",
    "falls.tsv": "t\ty1\n1\t1\n0\t1\n", "inf.tsv": "t\ty1\nnan\t1\n0\t1\n", "nans.tsv": "t\ty1\n0\tnan\n1\tnan\n",
    "y.tsv": "t\ty1\n0\t1\n1\t2\n", "rho1.tsv": "t\ty1\ty2\trho1\trho2\n0\t1\t2\t1\t1\n1\t1\t2\t1\t1\n",
    "two.tsv": "t\ty1\ty2\n0\t1\t2\n1\t1\t2\n", "strobe.tsv": "tap\ty1\tdensity\n1\t1\t1\n2\t1\t1\n",
    "bif.tsv": "# parameter = period\nparameter\ttap\ty1\n1\t1\t1\n2\t1\t1\n",
    "same.tsv": "parameter\tlambda\n1\t1\n1\t1\n",
    "lyap.tsv": "# parameter = e\nparameter\tlambda\n1\t1\n2\t1\n",
    "nolyap.tsv": "parameter\tlambda\n1\tnan\n2\tnan\n"}
COLUMNS = {
    "far.tsv": {"grain": [60], "factor": [2.0]}, "one.tsv": {"grain": [0], "factor": [1.0]},
    "low.tsv": {"grain": [0], "factor": [-1.0]}, "x.tsv": {"grain": [0], "size": [1.0]},
    "nan.tsv": {"contact": [0], "by_kn": [np.nan]}, "zero.tsv": {"contact": [0], "by_kn": [0.0]},
    "k.tsv": {"contact": [10**6], "by_kn": [1.0]},
    "short.tsv": {"t": [0.0, 1.0], "F": [0.0, 1.0]},
    "huge.tsv": {"t": [0.0, 1.0, 2.0], "F": [0.0, 1e308, -1e308]},
    "loud.tsv": {"t": np.arange(100.0), "F": 1e200 * np.sin(np.arange(100.0))},
    "soft.tsv": {"t": np.arange(100.0), "F": 1e-200 * np.sin(np.arange(100.0))},
    "below.tsv": {"polarization": ["longitudinal"] * 2, "k": [1.0, 2.0], "peak": [1.0, -1.0]},
    "width.tsv": {"polarization": ["longitudinal"], "k": [1.0], "peak": [1.0], "half_width": [-1.0]},
    "far_modes.tsv": {"n": [1e308] * 80, "omega": np.arange(80.0)},
    "gap.tsv": {"t": [*range(99), 200.0], "F": np.arange(100.0)},
    "still.tsv": {"t": np.arange(100.0), "F": np.ones(100)},
    "dull.tsv": {"angle": [0.0, 0.0], "all": [1.0, 1.0]},
    "skw.tsv": {"polarization": ["longitudinal"], "k": [1.0], "omega": [1.0],
                "S": [1.0]}}


def made(**keys):
    return sonopack.Packing.make(sonopack.Scene(packing={"grains": 60, "width": 6, "seed": 3, "friction": 0.5, **keys}))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    tmp_path = tmp_path_factory.mktemp("refusals")
    for name, text in TEXTS.items():
        (tmp_path / name).write_text(text)
    for name, columns in COLUMNS.items():
        sonopack.Table.from_columns(columns).save(tmp_path / name)
    flat = made()
    flat.save(tmp_path / "p.h5")
    made(cell="periodic").save(tmp_path / "q.h5")
    flat.network().modes().save(tmp_path / "m.h5")
    for name, packing in (("mode.tsv", flat), ("other.tsv", made(seed=9))):
        find_mode([Input(packing)], None, None).table().save(tmp_path / name)
    moved = find_snapshots([Input(flat)], None, None)[0].table().text("tsv").splitlines()
    moved[-1] = "\t".join([*moved[-1].split("\t")[:4], "true", *moved[-1].split("\t")[5:]])
    (tmp_path / "words.tsv").write_text("\n".join([*moved, ""]))
    return tmp_path


@pytest.mark.parametrize("arguments, status, reason", [
    # options and tables
    ("ctof s.tsv -o x.svg", 1, "no column p"), ("ctof bad.tsv -o x.svg", 1, "c_tof = -1: must be above 0"),
    ("ctof gone.tsv -o x.svg", 1, "gone.tsv"), ("signal s.tsv v.tsv -o x.svg", 1, "must be the same unit"),
    ("ctof c.tsv", 2, "no -o FILE"), ("ctof -o x.svg", 2, "no file to draw"), ("nothing c.tsv -o x.svg", 2, "nothing"),
    ("ctof c.tsv -o x.gif", 2, ".svg, .png or .pdf"), ("ctof c.tsv -o old.svg", 2, "exists already"),
    ("ctof c.tsv --force -o mine.svg", 2, "another kind"), ("ctof c.tsv --format csv -o x.svg", 2, "--format"),
    ("ctof c.tsv --store st -o x.svg", 2, "not both"), ("ctof --store none -o x.svg", 1, "none"),
    ("ctof c.tsv --label a --label b -o x.svg", 2, "2 label(s) for 1 file"),
    ("ctof c.tsv --published --no-published -o x.svg", 2, "one of them"),
    ("ctof c.tsv --published --units si --material " + GLASS + " -o x.svg", 2, "--published"),
    ("signal bare.tsv --units si --material " + GLASS + " -o x.svg", 1, "names no units"),
    ("ctof c.tsv --mode 3 -o x.svg", 2, "--mode: not for plot ctof"), ("network c.tsv --x 1:2 -o x.svg", 2, "--x"),
    ("ctof c.tsv --set friction=1 -o x.svg", 2, "--set"), ("signal s.tsv --set packing.friction=1 -o x.svg", 2, "--set"),
    ("ctof c.tsv --units si -o x.svg", 2, "needs a material"), ("signal s.tsv --log y -o x.svg", 2, "below 0"),
    ("ctof c.tsv --x 3:1 -o x.svg", 2, "empty range"), ("ctof c.tsv --y : -o x.svg", 2, "LO:HI"),
    ("ctof c.tsv --y nan:1 -o x.svg", 2, "--y"), ("ctof c.tsv --x -1:2 -o x.svg", 2, "above 0"),
    ("ctof c.tsv --log z -o x.svg", 2, "--log"), ("spectrum c.tsv --column F -o x.svg", 2, "alpha, k or speed"),
    ("mode p.h5 --frames 1 -o x.svg", 2, "2 .. 100000"), ("snapshot p.h5 --from 3 -o x.svg", 2, "needs --frames"),
    ("mode p.h5 --frames 3 -o x%q.svg", 2, "%d or %04d"), ("mode p.h5 --table x.svg -o x.svg", 2, "another file"),
    ("pareto c.tsv -o x.svg", 1, "case, method, seconds, error"), ("fronts s.tsv -o x.svg", 1, "sonopack front"),
    ("spectrum c.tsv -o x.svg", 1, "sonopack spectrum"), ("dispersion c.tsv -o x.svg", 1, "polarization"),
    ("wave c.tsv -o x.svg", 1, "sonopack wave"), ("transport c.tsv -o x.svg", 1, "omega"),
    ("amplitude c.tsv -o x.svg", 1, "sonopack amplitude"), ("path c.tsv -o x.svg", 1, "packing.path.strain"), ("modes c.tsv -o x.svg", 1, "no column n"),
    ("ensemble c.tsv -o x.svg", 1, "no column t"), ("scaling c.tsv -o x.svg", 1, "distance or grains"),
    # packings, motions, maps
    ("grains p.h5 -o x.svg", 2, "needs a packing and a table"),
    ("grains p.h5 far.tsv -o x.svg", 1, "of another packing"),
    ("grains p.h5 one.tsv -o x.svg", 1, "all grains are alike"), ("grains p.h5 low.tsv -o x.svg", 1, "must be above 0"),
    ("grains p.h5 x.tsv -o x.svg", 1, "no column factor"), ("sensitivity p.h5 x.tsv -o x.svg", 1, "by_kn"),
    ("sensitivity p.h5 nan.tsv -o x.svg", 1, "row 1: must have finite numbers"),
    ("sensitivity p.h5 zero.tsv -o x.svg", 1, "nothing to draw"),
    ("sensitivity p.h5 k.tsv -o x.svg", 1, "contact 1e+06"),
    ("mode p.h5 --mode 99999 -o x.svg", 2, "--mode 99999: must be in"),
    ("mode p.h5 other.tsv -o x.svg", 1, "another packing"),
    ("mode p.h5 mode.tsv --mode 99 -o x.svg", 2, "--mode 99"),
    ("mode p.h5 short.tsv -o x.svg", 1, "table of displacements"),
    ("snapshot p.h5 mode.tsv -o x.svg", 1, "must be snapshot"), ("snapshot q.h5 -o x.svg", 1, "no walls"),
    ("snapshot p.h5 m.h5 -o x.svg", 1, "must be a table"), ("mode q.h5 m.h5 -o x.svg", 1, "m.h5"),
    ("angles dull.tsv -o x.svg", 1, "rise from row to row"),
    ("angles x.tsv -o x.svg", 1, "a table of directions has"),
    ("forces x.tsv -o x.svg", 1, "a table of contact values has"),
    ("forces p.h5 far.tsv -o x.svg", 1, "far.tsv"),
    ("snapshot p.h5 --frames 3 --from 9 --to 2 -o x.svg", 2, "--from 9"), ("network none.h5 -o x.svg", 1, "none.h5"),
    ("spectrogram short.tsv -o x.svg", 1, "64 or more"), ("spectrogram gap.tsv -o x.svg", 1, "equally spaced"),
    ("spectrogram still.tsv -o x.svg", 1, "constant"), ("dispersion skw.tsv -o x.svg", 1, "each pair of k and omega"),
    ("signal huge.tsv -o x.svg", 1, "huge.tsv: row 2, F = 1e+308: must be within 1e+300"),
    ("modes far_modes.tsv -o x.svg", 1, "row 1, n = 1e+308"),
    ("spectrogram loud.tsv -o x.svg", 1, "must be a number, within"), ("spectrogram soft.tsv -o x.svg", 1, "must be a number, within"),
    ("dispersion below.tsv -o x.svg", 1, "row 2, peak = -1: must be a number >= 0"),
    ("dispersion width.tsv -o x.svg", 1, "row 1, half_width = -1"),
    ("snapshot p.h5 words.tsv -o x.svg", 1, "column ux holds text"),
    # the tapped column
    ("column text.tsv -o x.svg", 1, "column y0 holds text"), ("column none.tsv -o x.svg", 1, "sonopack column"), ("column y0.tsv -o x.svg", 1, "no column y1"),
    ("column rho.tsv -o x.svg", 1, "must be equal numbers"), ("column work.tsv -o x.svg", 1, "no column dissipated"),
    ("column row.tsv -o x.svg", 1, "must be two or more"),
    ("column falls.tsv -o x.svg", 1, "row 2, t = 0 after 1: must rise"), ("column inf.tsv -o x.svg", 1, "must be finite"),
    ("column nans.tsv -o x.svg", 1, "no position is finite"),
    ("column two.tsv rho1.tsv -o x.svg", 1, "no common scale"),
    ("column strobe.tsv two.tsv -o x.svg", 1, "table 1 is a strobe table and table 2 is a trajectory"),
    ("column strobe.tsv --surface -o x.svg", 1, "a surface is drawn of"), ("column y.tsv --surface -o x.svg", 1, "a surface needs two or more"),
    ("column y.tsv --column y1 -o x.svg", 1, "only a bifurcation"), ("column bif.tsv --column y2 -o x.svg", 2, "must be y1 to y1"),
    ("column bif.tsv --column z -o x.svg", 2, "must be y1 to y1"), ("column bif.tsv lyap.tsv -o x.svg", 1, "must be the same"),
    ("column same.tsv -o x.svg", 1, "only one value of the parameter"), ("column nolyap.tsv -o x.svg", 1, "no Lyapunov exponent is finite")])
def test_refusals(folder, monkeypatch, arguments, status, reason):
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    with pytest.raises((SonopackError, OSError)) as caught:
        command.run(command.parser().parse_intermixed_args(arguments.split()))
    fault = caught.value
    assert reason in str(fault) and sorted(folder.iterdir()) == before
    assert (2 if isinstance(fault, SonopackError) and fault.status == Status.EINVAL else 1) == status, str(fault)
