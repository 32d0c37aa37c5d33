"""sonopack reproduce: rows with verdicts, a report whose links hold, only what is asked for, nothing made twice,
stopping, what is refused."""
import csv
import html.parser
import io
import json
import math
import os
import pathlib
import re
import signal
import subprocess
import time

import pytest
from warm import warm

ITEMS = [f"table{k}" for k in range(1, 6)] + [f"fig{k}" for k in range(1, 13)] + ["claims"]
SOME = ["table1", "fig1", "fig3", "fig8", "fig12"]
VOID = {"meta", "img", "br", "hr", "link"}


def run(*arguments, status=0):
    command = warm(os.environ["SONOPACK"]) / "sonopack"
    done = subprocess.run([command, "reproduce", *map(str, arguments)], text=True, capture_output=True)
    assert done.returncode == status, f"{arguments}: status {done.returncode}\n{done.stderr}"
    return done


def rows_of(text):
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A store with one sample of each combination, quickly compressed, and the report on some items: folder and
    table."""
    folder = tmp_path_factory.mktemp("somfai")
    done = run("somfai2005", "--only", ",".join(SOME), "--samples", 1, "--store", folder / "store", "-o",
               folder / "report",
               "--jobs", 2, "--protocol", "quick")
    return folder, done.stdout


@pytest.fixture
def quick(made):
    """Runs with the store of `made`."""
    def again(*arguments, status=0):
        return run("somfai2005", *arguments, "--store", made[0] / "store", "--protocol", "quick", status=status)
    return again


class Parsed(html.parser.HTMLParser):
    """Tags that close, and the files that are linked."""

    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.ids = [], [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.links += [attrs[name] for name in ("src", "href") if name in attrs]
        self.ids += [attrs["id"]] if "id" in attrs else []
        assert tag != "script" and (tag != "img" or attrs["alt"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag


def test_rows(made):
    rows = rows_of(made[1])
    assert {row["item"] for row in rows} == {"table1", "fig8", "fig12"} and len(rows) == 40 + 7 + 1
    for row in rows:
        ours, paper, sigma = (float(row[name]) for name in ("ours", "paper", "sigma"))
        known = math.isfinite(sigma)
        assert row["verdict"] == ("missing" if not known else "agrees" if abs(sigma) <= 1 else "deviates"), row
        if row["scatter"] == "paper":
            assert sigma == pytest.approx((ours - paper) / float(row["paper_sd"])) and row["samples"] == "1"
    lattice = {row["quantity"]: row for row in rows}["c of lattice, Eq. (18)"]
    assert lattice["verdict"] == "agrees" and float(lattice["ours"]) == pytest.approx(0.1012, abs=2e-4)
    assert rows[-1]["verdict"] == "deviates"  # the paper prints the inverse of K_wall/K_bulk


def test_report(made):
    folder, text = made[0] / "report", made[1]
    page, markdown = Parsed((folder / "report.html").read_text()), (folder / "report.md").read_text()
    assert page.ids == ["summary", *SOME, "files"]
    assert sorted(re.findall(r"\]\(([^)\s]+)\)", markdown)) == sorted(page.links) and len(page.links) == 6
    assert all((folder / link).stat().st_size > 200 for link in page.links)
    values = rows_of(text)
    agree = sum(row["verdict"] == "agrees" for row in values)
    assert f"Of {len(values)} values of the paper {agree} agree" in markdown and "not finished" not in markdown
    assert markdown.count("deviates |") == 2 * sum(row["verdict"] == "deviates" for row in values)
    assert not re.search(r"\b(nan|inf)\b", markdown)
    for cell in ("| 0.818 ± 0.005 |", "| 7.4 ± 1.5 |", "| 0.50 ± 0.01 |"):
        assert cell in markdown
    for item in ("table1", "fig8-values", "fig12-values"):
        assert rows_of((folder / f"{item}.tsv").read_text()) == [row for row in values if row["item"] in item]
    # the lattice is a chain with other walls
    assert float(re.search(r"balls with such walls, to (\S+) of the largest", markdown).group(1)) < 1e-11


@pytest.mark.parametrize("name, columns, least", [
    ("fig1ab", "i j x_i y_i x_contact y_contact Fn kn", 500), ("fig1c", "x forces forces_err stiffnesses "
                                                                        "stiffnesses_err", 10),
    ("fig3", "grain x y radius ux uy rz", 500),
    ("fig8", "panel curve label x y error lower upper", 30), ("fig12", "panel curve label x y error lower "
                                                                       "upper", 2000)])
def test_numbers_of_figures(made, name, columns, least):
    text = (made[0] / "report" / f"{name}.tsv").read_text()
    rows = rows_of(text)
    assert list(rows[0]) == columns.split() and len(rows) >= least and "|" not in text
    assert "reproduce somfai2005, samples = 1" in text


def test_nothing_twice(made, quick, tmp_path):
    store, text = made[0] / "store", made[1]
    before = {path.name: path.stat().st_mtime_ns for path in store.iterdir()}
    assert quick("--only", ",".join(SOME), "--samples", 1).stdout == text
    assert {path.name: path.stat().st_mtime_ns for path in store.iterdir()} == before
    # two more packings of 200 grains and so on are not needed for Table I: four of 600 grains are
    assert len(rows_of(quick("--only", "table1", "--samples", 2).stdout)) == 40
    assert len(list(store.glob("*.h5"))) == sum(name.endswith(".h5") for name in before) + 4
    assert "-o FOLDER" in quick("--only", "fig3", "--samples", 1).stderr


def test_other_forms(quick, tmp_path):
    table = quick("--only", "table1", "--samples", 1, "--format", "csv").stdout
    assert len(list(csv.reader(io.StringIO("".join(line + "\n"
                                                   for line in table.splitlines() if line[0] != "#"))))) == 41
    assert json.loads(quick("--only", "fig12", "--format", "json").stdout)
    for format, head in (("pdf", b"%PDF"), ("png", b"\x89PNG")):
        quick("--only", "fig12", "-o", tmp_path / format, "--figures", format)
        assert (tmp_path / format / f"fig12.{format}").read_bytes().startswith(head)
        assert f"fig12.{format}" in Parsed((tmp_path / format / "report.html").read_text()).links


def test_stopped(tmp_path):
    """Ctrl-C ends with what is done; the same command continues, and the unfinished report makes no fuss."""
    store, out = tmp_path / "store", tmp_path / "report"
    command = [os.environ["SONOPACK"], "reproduce", "somfai2005", "--only", "table2", "--samples", "20", "--store",
               str(store),
               "-o", str(out), "--jobs", "1", "--protocol", "quick"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 60
    while not list(store.glob("*.h5")) and time.monotonic() < until:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 1 and not stdout and str(store) in stderr and "continues" in stderr
    assert "not finished" in (out / "report.md").read_text()
    kept = len(list(store.glob("*.h5")))
    run("somfai2005", "--only", "table2", "--samples", 1, "--store", store, "-o", out, "--protocol", "quick")
    assert len(list(store.glob("*.h5"))) <= kept + 4


# ---- the column -----------------------------------------------------------------------------------------------------

def test_column():
    done = run("blackmore2011", "--only", "errata,fig1,symbols")
    rows = {(row["equation"], row["quantity"]): row for row in rows_of(done.stdout)}
    for place, ours in ((("(26)", "equations for the 5 unknowns"), 5), (("(27)", "overlap of particles 4 and 5 at "
                                                                                 "rest"), 0.1),
                        (("(38)", "A(-) at chi(0) = 1/2, alpha = 1/h"), 6.5), (("(44)", "integral of Theta"), 1),
                        (("(31)", "acceleration when the upper contact is open"), 1961.34)):
        assert float(rows[place]["ours"]) == pytest.approx(ours) and rows[place]["verdict"] == "erratum"
    assert rows["(37)", "can be run as printed (1: yes)"]["verdict"] == "deviates"
    assert rows["Fig. 1", "y5(0.99T), N = 5"]["verdict"] == "not given"
    assert rows["Sect. 3", "Gamma at f = 7.5 Hz, N = 5"]["verdict"] == "agrees"
    for step in ("errata", "fig1", "symbols"):
        assert f"sonopack: {step}, " in done.stderr
    assert not run("blackmore2011", "--only", "errata", "--quiet").stderr


def test_report_of_the_column(tmp_path):
    folder = tmp_path / "report"
    rows = rows_of(run("blackmore2011", "--only", "errata,symbols", "-o", folder).stdout)
    page, markdown = Parsed((folder / "report.html").read_text()), (folder / "report.md").read_text()
    assert page.ids == ["summary", "errata", "symbols", "files"] and page.links == ["symbols-waves.svg"]
    assert f"{sum(row['verdict'] == 'erratum' for row in rows)} are errata" in markdown and "5 ± 0.05" in markdown
    assert rows_of((folder / "errata.tsv").read_text()) == [row for row in rows if row["item"] == "errata"]
    assert len(rows_of((folder / "symbols-waves.tsv").read_text())) == 241


def test_plan(tmp_path):
    def plan(*arguments):
        return {row["what"]: row for row in rows_of(run(*arguments, "--dry-run").stdout)}

    def seconds(samples):
        """Of the packings of 600 grains, at the pace that the machine has now."""
        row = plan("somfai2005", "--only", "table1", "--samples", samples, "--store", store)["600 grains: packings"]
        assert int(row["count"]) == 4 * samples
        return float(row["cpu_s"])

    store = tmp_path / "none"
    assert 8 < seconds(30) / seconds(2) < 30 and not store.exists()
    only = plan("somfai2005", "--only", "table1", "--store", store)
    assert {name.split(":")[0] for name in only} == {"600 grains", "items", "total"}
    assert plan("blackmore2011")["items"]["count"] == "6"


def test_plan_of_a_store(made):
    done = run("somfai2005", "--only", "table1", "--samples", 1, "--store", made[0] / "store", "--protocol", "quick",
               "--dry-run")
    assert "600 grains: samples in the store\t4\t" in done.stdout and "packings" not in done.stdout


# ---- what is refused ------------------------------------------------------------------------------------------------

REFUSED = [
    (["--store", "S"], "somfai2005 blackmore2011"), (["somfai2005"], "--store"), (["somfai2004", "--store", "S"],
                                                                                  "somfai2005"),
    (["somfai2005", "somfai2005", "--store", "S"], ""), (["somfai2005", "--store", "S", "--only", "tabel1"], "table1"),
    (["somfai2005", "--store", "S", "--only", "fig13"], "fig1"), (["somfai2005", "--store", "S", "--only", ""],
                                                                  "table1"),
    (["somfai2005", "--store", "S", "--only", "moduli"],
     ", ".join(ITEMS)), (["somfai2005", "--store", "S", "--only", "fig1,"], "fig1"),
    (["blackmore2011", "--only", "fig9"], "errata fig1"), (["somfai2005", "--store", "S", "--jobs", "0"], "--jobs"),
    (["somfai2005", "--store", "S", "--figures", "gif"], "svg png pdf"),
    (["somfai2005", "--store", "S", "--protocol", "slow"], "default somfai2005 quick"),
    (["somfai2005", "--store", "S", "--set", "packing.grains=10"], "--set"), (["blackmore2011", "--units", "si"],
                                                                              "--units"),
    *((["somfai2005", "--store", "S", "--samples", n], "--samples") for n in ("0", "-1", "2.5", "nan", "100001", "")),
    (["blackmore2011", "-o", "file"], "file"), (["blackmore2011", "-o", ""],
                                                "folder"), (["blackmore2011", "-o", "full"], "full"),
    (["blackmore2011", "-o", "full", "--force"], "full"), (["blackmore2011", "-o", "report"], "--force")]


@pytest.mark.parametrize("words, says", REFUSED, ids=[" ".join(words) for words, _ in REFUSED])
def test_refused(sonopack, tmp_path, words, says):
    (tmp_path / "file").write_text("not a folder")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes.txt").write_text("mine")
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "report.md").write_text("<!-- sonopack reproduce -->\n\n# done\n")
    done = sonopack("reproduce", *words, status=2)
    assert not done.stdout and all(word in done.stderr for word in says.split()), done.stderr
    assert not (tmp_path / "S").exists() and (tmp_path / "file").read_text() == "not a folder"


@pytest.mark.parametrize("words, says", [
    (["somfai2005", "--only", "fig12", "--store", "file"], "file"), (["blackmore2011", "-o", "file/below"],
                                                                     "file/below")])
def test_failed(sonopack, tmp_path, words, says):
    (tmp_path / "file").write_text("not a folder")
    assert says in sonopack("reproduce", *words, status=1).stderr


def test_report_is_replaced_with_force(tmp_path):
    folder = pathlib.Path(tmp_path / "report")
    run("blackmore2011", "--only", "errata", "-o", folder)
    first = (folder / "errata.tsv").read_text()
    run("blackmore2011", "--only", "errata", "-o", folder, "--force")
    assert (folder / "errata.tsv").read_text() == first
