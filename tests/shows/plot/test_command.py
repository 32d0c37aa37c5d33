"""sonopack plot: options, files, statuses."""
import os
import re
import signal
import subprocess
import time

import numpy as np
import pytest

SIGNAL = "# units: t [d/sqrt(E* / rho)] F [E* d^2]\nt\tF\n" + "".join(
    f"{t}\t{np.exp(-0.5 * ((t - 40) / 5)**2) - 0.5 * np.exp(-0.5 * ((t - 55) / 5)**2)}\n" for t in np.linspace(0, 99, 300))
SPEEDS = "# dimension = 2\n# units: p [E*] c_tof [sqrt(E* / rho)]\np\tc_tof\tc_tof_err\n" + "".join(
    f"{10.0**-k}\t{0.26 * 10**((4 - k) / 6)}\t0.01\n" for k in (3, 4, 5))
GLASS = "E=70e9,nu=0.22,rho=2500,d=1e-3"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "s.tsv").write_text(SIGNAL)
    (tmp_path / "c.tsv").write_text(SPEEDS)
    (tmp_path / "bad.tsv").write_text("p\tc_tof\n1e-4\t-1\n")
    return tmp_path


def words_of(path):
    """The texts of an SVG, which stand in its comments."""
    return re.findall(r"<!-- (.*?) -->", path.read_text())


def test_statuses_of_the_process(sonopack, folder):
    done = sonopack("plot", "ctof", "bad.tsv", "-o", "x.svg", status=1)
    assert done.stderr.startswith("sonopack: bad.tsv: row 1, c_tof = -1") and not done.stdout
    assert sonopack("plot", "ctof", "c.tsv", status=2).stderr.startswith("sonopack: no -o FILE")


def test_looks_change_axes(sonopack, folder):
    sonopack("plot", "ctof", "c.tsv", "-o", "plain.svg")
    sonopack("plot", "ctof", "c.tsv", "--linear", "--y", ":0.4", "--title", "Sound & fury", "--label", "mine", "-o", "x.svg")
    words = words_of(folder / "x.svg")
    assert "Sound &amp; fury" in words or "Sound & fury" in words
    assert any(word.startswith("mine: ") for word in words) and {"0.4", "0.40"} & set(words)
    assert not any(word.startswith("mine") for word in words_of(folder / "plain.svg"))


def test_figures_in_si(sonopack, folder):
    sonopack("plot", "signal", "s.tsv", "--units", "si", "--material", GLASS, "-o", "x.svg")
    sonopack("pack", "--set", "packing.grains=60", "--set", "packing.width=8", "-q", "-o", "p.h5")
    for kind in ("forces", "angles"):  # of ratios, which have no unit
        sonopack("plot", kind, "p.h5", "--units", "si", "--material", GLASS, "-o", f"{kind}.svg")
    assert "$t$  [µs]" in words_of(folder / "x.svg")


@pytest.mark.parametrize("ending, head", [("svg", b"<?xml"), ("pdf", b"%PDF-"), ("png", b"\x89PNG")])
def test_endings_and_force(sonopack, folder, ending, head):
    path = folder / f"x.{ending}"
    sonopack("plot", "signal", "s.tsv", "-o", path)
    first = path.read_bytes()
    sonopack("plot", "signal", "s.tsv", "-o", path, status=2)
    assert sonopack("plot", "signal", "s.tsv", "--force", "-o", path).stderr == ""
    assert path.read_bytes() == first and first.startswith(head)


def test_a_front_that_is_not_there_is_noted(sonopack, folder):
    (folder / "flat.tsv").write_text("t\tF\n0\t0\n1\t0\n2\t0\n")
    assert "flat.tsv: the first front is not marked" in sonopack("plot", "signal", "flat.tsv", "-o", "x.svg").stderr


def test_a_store_is_drawn(sonopack, folder):
    (folder / "scene.cfg").write_text('packing = { width = 6; height = [5, 7]; pressure = [1e-4, 1e-3]; };\n'
                                      'study = { samples = 2; want = ["ctof"]; };\n')
    sonopack("study", "scene.cfg", "--store", "st", "-q")
    sonopack("plot", "ctof", "--store", "st", "-o", "x.svg")
    assert any("tof" in word for word in words_of(folder / "x.svg"))


@pytest.mark.parametrize("early", [True, False])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_command_without_traces(folder, number, early):
    """At the start, and once the draft of the figure is there."""
    work = subprocess.Popen([os.environ["SONOPACK"], "plot", "signal", "s.tsv", "-o", "x.pdf", "--force"], cwd=folder,
                            stderr=subprocess.PIPE, text=True)
    while not early and work.poll() is None and not list(folder.glob(".x.pdf*")):
        time.sleep(0.001)
    work.send_signal(number)
    assert work.communicate()[1] == "" and work.returncode in (-number, 0)
    assert not list(folder.glob(".x*"))
