"""sonopack reproduce blackmore2011: rows and verdicts, errata that are computed, reference values of the column, a report
whose links and figures hold, only what is asked for, no store, what is refused.

usage: test_blackmore.py COMMAND SOURCE_DIR
"""
import csv
import io
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

from common import names_all

COMMAND = sys.argv[1]
COLUMNS = "item equation quantity unit relation paper precision ours err verdict note".split()
ITEMS = "errata fig1 fig2 symbols chaos claims".split()
FIGURES = {"errata": 0, "fig1": 4, "fig2": 2, "symbols": 1, "chaos": 4, "claims": 0}


def run(*args, status=0):
    done = subprocess.run([COMMAND, "reproduce", *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stdout, done.stderr)
    assert "Sanitizer" not in done.stderr, done.stderr
    return done


def rows_of(text):
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert lines[0] == COLUMNS, lines[0]
    rows = [dict(zip(COLUMNS, line)) for line in lines[1:]]
    for row in rows:
        for name in ("paper", "precision", "ours", "err"):
            row[name] = float(row[name])
    return rows


def ours(rows, quantity):
    found = [row["ours"] for row in rows if row["quantity"] == quantity]
    assert len(found) == 1, (quantity, found)
    return found[0]


def close(value, expected, tolerance):
    assert abs(value - expected) <= tolerance, (value, expected)


def check_verdicts(rows):
    """The verdict follows from the other columns."""
    for row in rows:
        err = 0 if math.isnan(row["err"]) else row["err"]
        holds = {"=": abs(row["ours"] - row["paper"]) <= row["precision"] + err,
                 ">": row["ours"] - err > row["paper"], "<": row["ours"] + err < row["paper"]}[row["relation"]]
        assert math.isfinite(row["ours"]) and not row["err"] < 0, row
        if row["item"] == "errata":
            # an erratum with a number must not hold as printed
            assert row["verdict"] == "erratum" and not holds and row["note"] != "-", row
        elif math.isnan(row["paper"]):
            assert row["verdict"] == "not given", row
        elif row["item"] == "claims":
            off = abs(row["ours"] - row["paper"])
            near = err > row["precision"] and row["precision"] < off <= row["precision"] + err
            near = near if row["relation"] == "=" else off <= err
            assert row["verdict"] == ("undecided" if near else "holds" if holds else "contradicted"), row
            assert len(row["note"]) > 20, row
        else:
            assert row["verdict"] == ("agrees" if holds else "deviates"), row
        if math.isnan(row["err"]):
            assert "err:" in row["note"], row


def check_errata(rows):
    errata = [row for row in rows if row["item"] == "errata"]
    assert {row["equation"] for row in errata} == {
        "(1)", "(3)", "(6)", "(24)", "(26)", "(27)", "Sect. 3", "(30)", "(31)", "(35)", "(37)", "(38)", "(39)", "(41)",
        "(43)", "(44)", "(45)", "(48)", "Sect. 7"}
    close(ours(errata, "A(-) at chi(0) = 1/2, alpha = 1/h"), 6.5, 1e-12)  # 3/2 + 3 + 2
    close(ours(errata, "frequency of the taps, N = 5"), 7.5025, 5e-5)
    close(ours(errata, "frequency of the taps, N = 10"), 9.4956, 5e-5)
    close(ours(errata, "smallest separation in tap 4, N = 5, T = 0.5 s"), -0.25, 2e-3)
    close(ours(errata, "largest force, upwards positive"), 0.3545, 5e-5)
    force = [row for row in errata if row["equation"] == "(45)"][0]
    close(force["paper"], -2.2588, 5e-5)
    # the resting column: overlaps n m g/K = n/10, K/m = 9806.7 /s^2
    middle = [row for row in errata if row["equation"] == "(24)"][0]
    close(middle["paper"], -980.67 - 9806.7 * 0.3 * 0.2, 1e-9)
    close(middle["ours"], 0, 1e-9)
    top = [row for row in errata if row["equation"] == "(27)"][0]
    close(top["paper"], -0.3, 1e-12)
    close(top["ours"], 0.1, 1e-12)
    close([row for row in errata if row["equation"] == "(44)"][0]["paper"], 3 / 7, 1e-12)  # c/b
    signs = {row["equation"]: row for row in errata if row["equation"] in ("(35)", "(37)")}
    close(signs["(37)"]["paper"], -signs["(37)"]["ours"], 1e-9)
    close(signs["(35)"]["paper"], 31 / 6, 1e-6)  # A+/3 - B h/3 + 2 r alpha h^2 with alpha = 1/h, r = 1


def check_values(rows):
    for k, y in enumerate((0.499205348314, 2.093203277325, 3.784435777282, 5.576736210942, 7.474198032402)):
        close(ours(rows, f"y{k + 1}(0.99T), N = 5"), y, 1e-8)
    assert sum("T), N = 10" in row["quantity"] for row in rows) == 40
    close(ours(rows, "work of the floor in tap 1, N = 5"), 6994.497407, 1e-6)
    close(ours(rows, "dissipated in tap 1, N = 5"), 6993.618476, 1e-6)
    # (27): y_5 = 9 - 15/10, and a radius more
    close(ours(rows, "density before, N = 5"), 5 / 8.5, 1e-12)
    for quantity in ("long wave and lattice", "BSR and lattice"):
        assert 0.01 < ours(rows, f"mean |y - y|, {quantity}") < 0.1, quantity
    assert ours(rows, "mean |y - y|, long wave and BSR") < ours(rows, "mean |y - y|, long wave and lattice")
    growth = 3 * 31 / 6 * math.sqrt(19613.4 / 6.5)  # 3 C sqrt(K/(m A-))
    close(ours(rows, "largest growth rate of all waves"), growth, 1e-6 * growth)
    close(ours(rows, "CFL number of the paper's steps, N = 10"), 2 * math.sqrt(19613.4), 1e-9)
    close(ours(rows, "c^2 of the expansion with its coefficients put right"), -1 / 6, 1e-12)
    close(ours(rows, "fixed point y, N = 1, T = 0.2 s"), 1.147749316, 1e-8)
    close(ours(rows, "fixed point v, N = 1, T = 0.2 s"), 17.526667496, 1e-7)
    close(ours(rows, "determinant of the map there"), 0.688060, 1e-6)
    close(ours(rows, "trace of the map there"), 0.385857, 1e-6)
    close(ours(rows, "lambda, N = 1, T = 0.2 s"), -0.18694, 1e-5)
    assert ours(rows, "cycle, N = 1, T = 0.7 s") == 2
    for n in (5, 10):
        assert ours(rows, f"lambda, settings of Fig. 1, N = {n}") < -0.1
    # chaos: against (1) with the paper's K, and in order with a stiffer one
    for over in "Ta":
        assert ours(rows, f"largest lambda, N = 1, K = 100 m g/r, over {over}") > 0.5
        assert ours(rows, f"smallest separation there, K = 100 m g/r, over {over}") > 0
        assert ours(rows, f"smallest separation there, K = 2 m g/r, over {over}") < 0


def check_claims(rows):
    claims = [row for row in rows if row["item"] == "claims"]
    verdict = {row["quantity"]: row["verdict"] for row in claims}
    assert verdict["Lyapunov exponent without taps and loss, N = 1"] == "holds"
    for n in (2, 3, 5):
        name = f"Lyapunov exponent without taps and loss, N = {n}"
        assert verdict[name] == "contradicted" and ours(claims, name) > 5
    close(ours(claims, "decay exponent gamma of a pulse, closed contacts, e = 0"), 2 / 3, 0.004)
    assert 800 < ours(claims, "growth rate of (37), e = 0") < 900
    assert ours(claims, "equal resonances of (35) and (37), e = 0") == 1
    assert ours(claims, "growth rate of (35), e = 0") > 1e7
    close(ours(claims, "(45) as printed, e = 0: order of the particles lost at"), 8.54e-3, 2e-5)
    close(ours(claims, "(45), e = 0: smooth solution ends at"), 0.1106, 1e-3)
    assert ours(claims, "longest cycle found, N = 1") > 8
    # as the table energy of the command has it: the smallest separation of ten taps
    close(ours(claims, "good choice a = 2 cm, f = 5.5 Hz: separation"), 0.113533193, 1e-8)
    close(ours(claims, "good choice a = 2 cm, f = 10 Hz: separation"), -0.137480828, 1e-8)
    close(ours(claims, "change of density over 200 taps, N = 5"), 0.59096 - 5 / 8.5, 5e-5)
    close(ours(claims, "change of density over 200 taps, N = 10"), 0.57561 - 10 / 17.25, 5e-5)
    close(ours(claims, "hybrid scheme, stable steps, e = 0: breaks down at"), 6.10e-3, 5e-5)
    assert ours(claims, "hybrid scheme, the paper's steps: breaks down at") < 0.1


def check_report(folder, items, rows, ending):
    text, markdown = (folder / "report.html").read_text(), (folder / "report.md").read_text()
    assert re.findall(r'<h2 id="(\w+)"', text) == ["summary", *items, "files"]
    links = re.findall(r'(?:src|href)="([^"]+)"', text)
    assert sorted(links) == sorted(re.findall(r"\]\(([^)\s]+)\)", markdown))
    assert len(links) == sum(FIGURES[item] for item in items)
    head = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending]
    for link in links:
        data = (folder / link).read_bytes()
        assert link.endswith(ending) and data.startswith(head) and len(data) > 3000, link
    assert not re.search(r"\b(nan|inf)\b", text), re.search(r".*\b(nan|inf)\b.*", text)
    assert "not finished" not in markdown and "Here." in text
    counts = {verdict: sum(row["verdict"] == verdict for row in rows)
              for verdict in ("agrees", "deviates", "erratum", "not given", "holds", "contradicted", "undecided")}
    claims = counts["holds"] + counts["contradicted"] + counts["undecided"]
    assert (f"of {claims} claims {counts['holds']} hold, {counts['contradicted']} are contradicted") in markdown
    assert (f"Of {len(rows) - claims} values {counts['agrees']} agree with the paper, {counts['deviates']} deviate, "
            f"{counts['erratum']} are errata, and {counts['not given']} are not given") in markdown
    for item in items:
        assert rows_of((folder / f"{item}.tsv").read_text()) == [row for row in rows if row["item"] == item] or any(
            math.isnan(row["paper"]) for row in rows if row["item"] == item)  # nan is not itself
        own = [row["quantity"] for row in rows if row["item"] == item]
        assert [row["quantity"] for row in rows_of((folder / f"{item}.tsv").read_text())] == own
    for name in folder.glob("*.tsv"):
        lines = [line for line in name.read_text().splitlines() if not line.startswith("#")]
        assert len(lines) > 1 and len({line.count("\t") for line in lines}) == 1, name


def whole(folder):
    out, store = folder / "report", folder / "store"
    done = run("blackmore2011", "--store", store, "-o", out, "--figures", "png", "--threads", 2)
    rows = rows_of(done.stdout)
    assert list(dict.fromkeys(row["item"] for row in rows)) == ITEMS and not store.exists()
    check_verdicts(rows)
    check_errata(rows)
    check_values(rows)
    check_claims(rows)
    check_report(out, ITEMS, rows, "png")
    trajectory = [line.split("\t") for line in (out / "fig1-n10-trajectories.tsv").read_text().splitlines()
                  if not line.startswith("#")]
    assert trajectory[0] == ["t"] + [f"y{k}" for k in range(11)] and len(trajectory) == 1602
    assert len({tuple(line[2:]) for line in trajectory[1:]}) > 500  # it moves
    return out, done.stdout


def parts(folder, out, text):
    """Items alone are the rows of the whole; a report is not overwritten; forms of table and figures."""
    wanted = ["errata", "symbols"]
    some = folder / "some"
    done = run("--only", "symbols,errata", "blackmore2011", "-o", some, "--samples", 3)
    assert names_all(done.stderr, "--samples")
    body = [line for line in text.splitlines() if line.split("\t")[0] in wanted]
    assert [line for line in done.stdout.splitlines() if line[0] != "#"][1:] == body
    check_report(some, wanted, rows_of(done.stdout), "svg")
    assert names_all(run("blackmore2011", "--only", "errata", "-o", some, status=2).stderr, "--force")
    run("blackmore2011", "--only", "symbols", "-o", some, "--force", "--figures", "pdf")
    assert (some / "symbols-waves.pdf").read_bytes().startswith(b"%PDF")
    table = run("blackmore2011", "--only", "errata", "--format", "csv").stdout
    lines = list(csv.reader(line for line in io.StringIO(table) if line[0] != "#"))
    assert lines[0] == COLUMNS and all(len(line) == len(COLUMNS) for line in lines)
    assert json.loads(run("blackmore2011", "--only", "symbols", "--format", "json").stdout)
    one, two = (run("blackmore2011", "--only", "fig1", "--threads", n).stdout for n in (1, 2))
    assert one == two


def refused(folder, out):
    def wrong(*args, says, status=2):
        text = run(*args, status=status).stderr
        assert names_all(text.splitlines()[0], says), text

    wrong(says="somfai2005 blackmore2011")
    wrong("blackmore2012", says="blackmore2012 somfai2005 blackmore2011")
    wrong("blackmore2011", "somfai2005", says="")
    wrong("blackmore2011", "--only", "fig3", says="errata fig1 fig2 symbols chaos claims")
    wrong("blackmore2011", "--only", "chaso", says="chaos")
    wrong("blackmore2011", "--only", "table1", says="errata")
    wrong("blackmore2011", "--only", "", says="errata")
    wrong("somfai2005", "--store", folder / "none", "--only", "errata", says="table1")
    wrong("blackmore2011", "--figures", "gif", says="svg png pdf")
    wrong("blackmore2011", "--set", "column.particles=3", says="--set")
    wrong("blackmore2011", "-o", folder, says="")
    wrong("blackmore2011", "-o", out, says="--force")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-blackmore-") as name:
        folder = pathlib.Path(name)
        out, text = whole(folder)
        parts(folder, out, text)
        refused(folder, out)


if __name__ == "__main__":
    main()
