"""sonopack reproduce: rows with verdicts, a report whose links hold, only what is asked for, nothing made twice, stopping
by Ctrl-C, what is refused.

usage: test_reproduce.py COMMAND SOURCE_DIR
"""
import csv
import html.parser
import io
import json
import math
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

from common import PATIENCE, names_all, wait_until

COMMAND = sys.argv[1]
COLUMNS = ("item p quantity paper paper_sd ours err sigma verdict ours_sd samples combined scatter deviation_err rounding "
           "relation where note").split()
ITEMS = [f"table{k}" for k in range(1, 6)] + [f"fig{k}" for k in range(1, 13)] + ["claims"]
VOID = {"meta", "img", "br", "hr", "link"}


def run(*args, status=0):
    """With packings that are made quickly: what they are like does not matter here."""
    quick = ["--protocol", "quick"] if status == 0 and args and args[0] == "somfai2005" else []
    done = subprocess.run([COMMAND, "reproduce", *map(str, args), *quick], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stdout, done.stderr)
    assert "Sanitizer" not in done.stderr, done.stderr
    return done


def rows_of(text):
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert lines[0] == COLUMNS, lines[0]
    return [dict(zip(COLUMNS, line)) for line in lines[1:]]


def check_claim(row):
    ours, limit, err = (float(row[name]) for name in ("ours", "paper", "err"))
    inside = {"<": limit - ours, ">": ours - limit, "=": float(row["paper_sd"]) - abs(ours - limit)}[row["relation"]]
    assert row["sigma"] == "nan" and row["where"] != "-" and len(row["note"]) > 20, row
    if math.isnan(inside) or math.isnan(err):
        verdict = "missing"
    elif abs(inside) < 2 * err:
        verdict = "undecided"
    else:
        verdict = "holds" if inside >= 0 else "contradicted"
    assert row["verdict"] == verdict, row


def check_deviation(row):
    """By both standard errors, with the rounding of print."""
    value = {name: float(row[name]) for name in ("paper", "paper_sd", "ours", "err", "ours_sd", "combined", "rounding",
                                                 "deviation_err")}
    theirs = {"paper": value["paper_sd"] / 30 ** 0.5, "ours": value["ours_sd"] / 30 ** 0.5}.get(row["scatter"],
                                                                                             value["paper_sd"])
    difference = value["ours"] - value["paper"]
    if row["scatter"] == "bound":
        difference = min(difference, 0)
    for name, more in (("combined", 0), ("deviation_err", value["rounding"])):
        expected = difference / math.hypot(theirs, value["err"], more)
        assert math.isnan(expected) and math.isnan(value[name]) or abs(expected - value[name]) < 1e-9 * (
            1 + abs(expected)), row
    assert (value["rounding"] > 0) == row["item"].startswith("table") * (row["item"] != "table3"), row


def check_counts(text):
    """The comments count what the rows say."""
    rows = rows_of(text)
    for line in text.splitlines():
        if not line.startswith("# count: table"):
            continue
        words = line.split()
        count = dict(zip(words[3::2], words[4::2]))
        own = [row for row in rows if row["item"] == words[2] or words[2] == "tables" and row["scatter"] in ("paper", "ours")]
        off = [abs(float(row["deviation_err"])) for row in own if row["deviation_err"] != "nan"]
        assert int(count["agree"]) == sum(row["verdict"] == "agrees" for row in own), line
        assert int(count["judged"]) == len(off) and int(count["beyond2"]) == sum(x > 2 for x in off), line
        assert abs(float(count["chi2"]) - sum(x * x for x in off)) < 0.06, line
    claims = [row["verdict"] for row in rows if row["scatter"] == "claim"]
    if claims:
        assert (f"# claims: {len(claims)} hold {claims.count('holds')} contradicted {claims.count('contradicted')} "
                f"undecided {claims.count('undecided')} ") in text


def check_rows(rows):
    """sigma, combined and verdict follow from the other columns."""
    for row in rows:
        if row["scatter"] == "claim":
            check_claim(row)
            continue
        check_deviation(row)
        value = {name: float(row[name]) for name in ("paper", "paper_sd", "ours", "err", "sigma", "ours_sd")}
        scatter = {"paper": value["paper_sd"], "ours": value["ours_sd"]}.get(
            row["scatter"], math.hypot(value["paper_sd"], 0 if math.isnan(value["err"]) else value["err"]))
        sigma = (value["ours"] - value["paper"]) / scatter
        if row["scatter"] == "bound":
            sigma = min(sigma, 0)
        if math.isnan(sigma):
            assert row["verdict"] == "missing" and math.isnan(value["sigma"]), row
        else:
            assert abs(sigma - value["sigma"]) <= 1e-9 * (1 + abs(sigma)), row
            assert row["verdict"] == ("agrees" if abs(sigma) <= 1 else "deviates"), row
        if row["samples"] == "1":
            assert math.isnan(value["err"]) and row["combined"] == "nan", row


class Page(html.parser.HTMLParser):
    """Tags that close, and the files that are linked."""

    def __init__(self):
        super().__init__()
        self.open, self.links, self.ids = [], [], []

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.links += [attrs[name] for name in ("src", "href") if name in attrs]
        self.ids += [attrs["id"]] if "id" in attrs else []
        if tag == "img":
            assert attrs["alt"], attrs
        assert tag != "script"
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, (tag, self.open)
        self.open.pop()


def check_report(folder, items, rows):
    page = Page()
    text = (folder / "report.html").read_text()
    page.feed(text)
    assert not page.open and page.ids == ["summary", *items, "files"], (page.open, page.ids)
    for link in page.links:
        assert (folder / link).stat().st_size > 200, link
    markdown = (folder / "report.md").read_text()
    links = re.findall(r"\]\(([^)\s]+)\)", markdown)
    assert sorted(links) == sorted(page.links), (links, page.links)
    assert "Here." in text and "not finished" not in markdown
    values = [row for row in rows if row["scatter"] != "claim"]
    agree = sum(row["verdict"] == "agrees" for row in values)
    assert f"Of {len(values)} values of the paper {agree} agree" in markdown or not values
    off = [abs(float(row["deviation_err"])) for row in values if row["scatter"] in ("paper", "ours")]
    off = [x for x in off if not math.isnan(x)]
    if off:
        assert (f"Of {len(off)} means that the paper prints {sum(x <= 1 for x in off)} lie within one combined standard "
                f"error, {sum(x > 2 for x in off)} beyond two and {sum(x > 3 for x in off)} beyond three") in markdown
    claims = [row for row in rows if row["scatter"] == "claim"]
    if claims:
        assert f"Of {len(claims)} claims {sum(row['verdict'] == 'holds' for row in claims)} hold" in markdown
    assert markdown.count("deviates |") == 2 * sum(row["verdict"] == "deviates" for row in rows)  # summary and item
    assert not re.search(r"\b(nan|inf)\b", text), re.search(r".*\b(nan|inf)\b.*", text)
    for item in items:
        own = [row for row in rows if row["item"] == item]
        name = folder / (f"{item}-values.tsv" if item.startswith("fig") else f"{item}.tsv")
        assert name.exists() == bool(own), name
        if own:
            assert rows_of(name.read_text()) == own
    return len(page.links)


def made(folder):
    return int(re.search(r"(\d+) samples made in this run", (folder / "report.md").read_text()).group(1))


def a_report(folder):
    items = ["table1", "table3", "fig1", "fig2", "fig3", "fig6", "fig11", "fig12"]
    store, out = folder / "store", folder / "report"
    done = run("somfai2005", "--only", ",".join(items), "--samples", 1, "--store", store, "-o", out, "--jobs", 2)
    rows = rows_of(done.stdout)
    check_rows(rows)
    assert {row["item"] for row in rows} == {"table1", "table3", "fig6", "fig12"}
    assert len([row for row in rows if row["item"] == "table1"]) == 40
    exact = {row["quantity"]: float(row["ours"]) for row in rows if row["item"] == "table3"}
    assert abs(exact["gamma, equal chain A"] - 2 / 3) < 1e-3 and abs(exact["alpha, equal chain B"] - 1 / 3) < 1e-3
    # 3 figures of Fig. 1, and one of each other; their numbers beside them
    assert check_report(out, items, rows) == 8
    for name in ("fig1ab", "fig1c", "fig2", "fig3", "fig6", "fig11", "fig12"):
        lines = (out / f"{name}.tsv").read_text().splitlines()
        assert len([line for line in lines if not line.startswith("#")]) > 10, name
    # values as the paper prints them
    report = (out / "report.md").read_text()
    for cell in ("| 0.818 ± 0.005 |", "| 7.4 ± 1.5 |", "| 0.50 ± 0.01 |", "| ≥ 0.667 |"):
        assert cell in report, cell
    assert "|" not in (out / "fig6.tsv").read_text()  # marks of italics
    # the lattice is a chain with other walls: a sentence that is computed
    apart = re.search(r"balls with such walls, to (\S+) of the largest", (out / "report.md").read_text()).group(1)
    assert float(apart) < 1e-11, apart
    assert made(out) == len(list(store.glob("*.h5")))
    return store, out, items, done.stdout


def nothing_twice(folder, store, out, items, text):
    before = {path.name: path.stat().st_mtime_ns for path in store.iterdir()}
    only = ("somfai2005", "--only", ",".join(items), "--store", store)
    assert names_all(run(*only, "--samples", 1, "-o", out, status=2).stderr, "--force")
    again = run(*only, "--samples", 1, "-o", out, "--force", "--figures", "png")
    assert again.stdout == text and made(out) == 0
    assert {path.name: path.stat().st_mtime_ns for path in store.iterdir()} == before
    assert (out / "fig6.png").read_bytes().startswith(b"\x89PNG")
    # without a folder: the same rows, and nothing is made for figures alone
    assert run(*only, "--samples", 1).stdout == text
    empty = folder / "figures"
    alone = run("somfai2005", "--only", "fig3", "--store", empty)
    assert rows_of(alone.stdout) == [] and names_all(alone.stderr, "-o") and not list(empty.iterdir())
    # a sample more: four more packings, and those of before
    more = run("somfai2005", "--only", "table1", "--samples", 2, "--store", store)
    assert len(list(store.glob("*.h5"))) == sum(name.endswith(".h5") for name in before) + 4
    check_rows(rows_of(more.stdout))
    check_counts(more.stdout)
    deviations = [row["deviation_err"] for row in rows_of(more.stdout)]
    assert len(deviations) == 40 and "nan" not in deviations  # two samples have errors
    # other forms
    table = run("somfai2005", "--only", "table1", "--samples", 1, "--store", store, "--format", "csv").stdout
    assert len(list(csv.reader(io.StringIO("".join(line + "\n" for line in table.splitlines() if line[0] != "#"))))) == 41
    assert json.loads(run("somfai2005", "--only", "fig12", "--store", store, "--format", "json").stdout)
    pdf = folder / "pdf"
    run("somfai2005", "--only", "fig12", "--store", store, "-o", pdf, "--figures", "pdf")
    assert check_report(pdf, ["fig12"], rows_of((pdf / "fig12-values.tsv").read_text())) == 1
    # a damaged sample is made again, foreign files are left alone
    victim = sorted(store.glob("*.h5"))[0]
    whole = victim.read_bytes()
    victim.write_bytes(whole[:2000])
    (store / "notes.txt").write_text("mine")
    assert run(*only, "--samples", 1).stdout == text
    assert victim.stat().st_size > 2000 and (store / "notes.txt").read_text() == "mine"


def stopped(folder):
    store, out = folder / "stopped", folder / "unfinished"
    command = [COMMAND, "reproduce", "somfai2005", "--only", "table2", "--samples", "20", "--store", str(store), "-o",
               str(out), "--jobs", "1", "--protocol", "quick"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_until(lambda: store.exists() and list(store.glob("*.h5")), "a sample")
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1 and not stdout and names_all(stderr, store), (stdout, stderr)
    assert "not finished" in (out / "report.md").read_text()
    kept = len(list(store.glob("*.h5")))
    # fewer samples, of which some are there; the unfinished report makes no fuss
    run("somfai2005", "--only", "table2", "--samples", 1, "--store", store, "-o", out)
    assert made(out) <= 4 and len(list(store.glob("*.h5"))) == made(out) + kept


def refused(folder, store):
    def wrong(*args, says, status=2):
        text = run(*args, status=status).stderr
        assert names_all(text.splitlines()[0], says), text

    there = ("--store", store)
    wrong(*there, says="somfai2005 blackmore2011")
    wrong("somfai2005", says="--store")
    wrong("somfai2004", *there, says="somfai2005")
    wrong("somfai2005", "somfai2005", *there, says="")
    wrong("somfai2005", *there, "--only", "tabel1", says="table1")
    wrong("somfai2005", *there, "--only", "fig13", says="fig1")
    wrong("somfai2005", *there, "--only", "moduli", says=", ".join(ITEMS))
    wrong("somfai2005", *there, "--only", "", says="table1")
    wrong("somfai2005", *there, "--only", "fig1,", says="table1")
    for number in ("0", "-1", "2.5", "nan", "100001", ""):
        wrong("somfai2005", *there, "--samples", number, says="--samples")
    wrong("somfai2005", *there, "--jobs", "0", says="--jobs")
    wrong("somfai2005", *there, "--figures", "gif", says="svg png pdf")
    wrong("somfai2005", *there, "--protocol", "slow", says="default somfai2005 quick")
    wrong("somfai2005", *there, "--set", "packing.grains=10", says="--set")
    only = ("somfai2005", "--only", "fig12")
    file = folder / "file"
    file.write_text("not a folder")
    wrong(*only, "--store", file, says=str(file), status=1)
    wrong(*only, *there, "-o", file, says=file)
    wrong(*only, *there, "-o", file / "below", says=file / "below", status=1)
    wrong(*only, *there, "-o", "", says="")
    wrong(*only, *there, "-o", folder, says=folder)
    wrong(*only, *there, "-o", folder, "--force", says=folder)
    assert file.read_text() == "not a folder"


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-reproduce-") as name:
        folder = pathlib.Path(name)
        store, out, items, text = a_report(folder)
        nothing_twice(folder, store, out, items, text)
        stopped(folder)
        refused(folder, store)


if __name__ == "__main__":
    main()
