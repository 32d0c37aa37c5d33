"""Verdicts on fabricated values: claims that must fail, deviations, systematic differences, and the tables of data."""
import math

import pytest

from sonopack.papers.blackmore.rows import Row as Claim
from sonopack.papers.report import Page
from sonopack.papers.somfai.claims import _first_pulse
from sonopack.papers.somfai.fronts import _equal, _over_first, line
from sonopack.papers.somfai.rows import (Mean, Row, _claim_cells, _value_cells, counted, exact, families, judged, mean_of,
                                         ratio, speed)
from sonopack.papers.somfai.samples import count, needs, scene
from sonopack.papers.work import by_key, published

NAN = math.nan


@pytest.mark.parametrize("relation, limit, within, ours, err, verdict", [
    ("<", 1.1, NAN, 1.0, 0.04, "holds"), ("<", 1.1, NAN, 1.0, 0.06, "undecided"), ("<", 1.1, NAN, 1.15, 0.03,
                                                                                   "undecided"),
    ("<", 1.1, NAN, 1.21, 0.03, "contradicted"), (">", 1, NAN, 1.4, 0.04, "holds"), (">", 1, NAN, 0.9, 0.04,
                                                                                     "contradicted"),
    ("=", -1, 0.01, -0.999, 0, "holds"), ("=", -1, 0.01, -1.02, 0, "contradicted"), ("=", 0, 0.01, 0.009, 0.002,
                                                                                     "undecided"),
    ("<", 1, NAN, 0.5, NAN, "missing"), ("<", 1, NAN, NAN, 0, "missing")])
def test_claims_of_packings(relation, limit, within, ours, err, verdict):
    row = judged(Row("claims", "x", paper=limit, paper_sd=within, scatter="claim", relation=relation, ours=ours,
                     err=err))
    assert row.verdict == verdict and math.isnan(row.sigma)


@pytest.mark.parametrize("scatter, ours, err, sigma, verdict", [
    ("paper", 3.1, 0.1, 0.5, "agrees"), ("paper", 3.3, 0.1, 1.5, "deviates"), ("ours", 2.4, 0.1, -1.2, "deviates"),
    ("stated", 3.125, 0.15, 0.5, "agrees"), ("stated", 3.25, 0.0, 1.25, "deviates"), ("bound", 9.0, 0.1, 0.0, "agrees"),
    ("bound", 2.7, 0.0, -1.5, "deviates"), ("paper", NAN, NAN, NAN, "missing")])
def test_deviations(scatter, ours, err, sigma, verdict):
    row = judged(Row("table1", "x", paper=3, paper_sd=0.2, scatter=scatter, ours=ours, ours_sd=0.5, err=err))
    assert row.sigma == pytest.approx(sigma, nan_ok=True) and row.verdict == verdict


def test_rounding_of_print():
    """Printed to 0.1: uniform within 0.05, a standard deviation of 0.1/sqrt(12)."""
    row = Row("table1", "x", paper=3, paper_sd=0.3 * 30**0.5, digit=0.1 * 12**0.5, ours=4, ours_sd=1, err=0.4)
    assert judged(row).combined == pytest.approx(2) and judged(row).deviation_err == pytest.approx(1 / 0.26**0.5)


def test_means():
    assert mean_of([1, 2, NAN, 3]) == pytest.approx((3, 2, 1, 3**-0.5))
    assert math.isnan(mean_of([1]).err) and math.isnan(mean_of([]).mean)
    a, b = Mean(4, 6.0, NAN, 0.3), Mean(3, 2.0, NAN, 0.2)
    assert ratio(a, b) == pytest.approx((3, 3, NAN, 3 * math.hypot(0.05, 0.1)), nan_ok=True)
    assert speed(8.0, b, a) == pytest.approx((4, 2, NAN, 2 * math.hypot(0.2, 0.3) / 4), nan_ok=True)
    assert f"{b:+.2f}" == "+2.00 +- 0.20" and ratio(b, exact(2.0)).err == pytest.approx(0.1)


@pytest.mark.parametrize("off, systematic, side", [
    ((2, 2, 2), True, 1), ((1, 1, 1), False, 1), ((-2, -2, -2.5), True, -1), ((3, -3, 3), True, 0), ((3, -1, 3), False,
                                                                                                     0),
    ((9, 9), False, 1)])
def test_systematic_differences(off, systematic, side):
    rows = [judged(Row("table1", "x", paper=1, paper_sd=0.3 * 30**0.5, ours=1 + 0.5 * each, err=0.4)) for each in off]
    family, = families(rows)
    assert (family.is_systematic, family.side, family.values) == (systematic, side, len(off))
    c = counted(rows)
    assert c.judged == len(off) and c.chi2 == pytest.approx(sum(each**2 for each in off))
    assert c.beyond2 == sum(abs(row.deviation_err) > 2 for row in rows)


@pytest.mark.parametrize("kind, relation, paper, precision, ours, err, verdict", [
    ("claim", "<", 0.99, 0, 0.7, 0, "holds"), ("claim", "<", 0.99, 0, 1.2, 0, "contradicted"),
    ("claim", ">", 4, 0, 4.1, 0.2, "undecided"), ("claim", ">", 4, 0, 5, NAN, "holds"),
    ("claim", "=", 0, 0.01, 0.013, 0.007, "holds"), ("claim", "=", 0, 0.01, 0.02, 0.015, "undecided"),
    ("claim", "=", 0, 0.01, 10.3, 0.8, "contradicted"), ("value", "=", 2.4, 0.02, 2.41, 0, "agrees"),
    ("value", "=", 2.4, 0.02, 2.5, 0, "deviates"), ("value", ">", 0, 0, -1, NAN, "deviates"),
    ("value", "=", NAN, 0, 1, 0, "not given"), ("erratum", "=", 50, 0, 1, 0, "erratum"),
    ("erratum", "=", 1, 0, 1, 0, "agrees"), ("erratum", "=", NAN, 0, 1, 0, "erratum"), ("value", "=", 1, 0, NAN, 0,
                                                                                        "missing")])
def test_claims_of_the_column(kind, relation, paper, precision, ours, err, verdict):
    assert Claim("claims", "(1)", "x", "", relation, paper, precision, ours, err, kind, "").verdict == verdict


def test_cells():
    """Ours to two digits of the error, the paper's as printed."""
    cells = _value_cells(judged(Row("table1", "f0", p=1e-4, paper=7.4, paper_sd=1.5, ours=7.6123, err=0.2345)))
    assert cells[2:] == ["1e-04", "7.4 ± 1.5", "7.61 ± 0.23", "+0.14", "+0.6", "agrees"]
    bound = _value_cells(Row("table3", "gamma", scatter="bound", paper=2 / 3, ours=0.76, err=0))
    assert bound[2:5] == ["–", "≥ 0.667", "0.76"]
    assert _claim_cells(Row("claims", "x", relation="<", scatter="claim", paper=1.1, where="Fig. 8"))[:4] == [
        "Fig. 8", "x", "< 1.1", "–"]


def test_no_text_is_markup():
    page = Page("t")
    page.table(["<b>"], [("deviates", ["a | b <script> +- 1"])], sentence=True)
    assert '<td class="sentence">a | b &lt;script&gt; ± 1</td>' in "".join(page.html)
    assert r"| a \| b \<script\> ± 1 |" in "".join(page.markdown)


def test_published_tables():
    """Every row has its cells, an item that exists, and numbers where numbers must be."""
    assert len(published("somfai", "tables")) == 92
    for paper, names in (("somfai", ("tables", "stated", "claims", "ensembles", "items")),
                         ("blackmore", ("rows", "items"))):
        for name in names:
            rows = published(paper, name)
            assert rows and all(None not in row and None not in row.values() for row in rows), (paper, name)
    for row in published("somfai", "claims"):
        assert row["relation"] in "<=>" and row["where"] and float(row["limit"]) < 1e3 and len(row["note"]) > 20
    for row in published("blackmore", "rows"):
        assert row["kind"] in ("value", "claim", "erratum") and row["relation"] in "<=>"
        assert row["item"] in by_key("blackmore", "items", "name") and float(row["precision"]) >= 0


def test_ensembles():
    assert [count(key, 30) for key in ("square", "tallest", "spheres", "lattice")] == [30, 15, 8, 1]
    assert [count("tallest", n) for n in (1, 2, 3)] == [1, 2, 2]
    for item in by_key("somfai", "items", "name"):
        for ensemble, want in needs(item, drawn=True).items():
            assert scene(ensemble, 2, "quick", want).samples >= 1
    assert needs("fig1", drawn=False) == {} and needs("table2", drawn=False) == {"square": {"statics", "moduli"}}


def test_numbers():
    slope = line([0, 1, 2], [Mean(1, y, NAN, 0.1) for y in (1, 3, 5)])
    assert slope.mean == pytest.approx(2) and slope.err == pytest.approx(0.1 / 2**0.5)
    assert math.isnan(line([1], [exact(1.0)]).mean)
    chain = _over_first(_equal())  # far away A ~ L^(-2/3), W ~ L^(1/3)
    assert chain["amplitude"][0] == chain["width10"][0] == 1 and chain["gamma"][-2] == pytest.approx(2 / 3, abs=0.02)
    assert chain["alpha"][-2] == pytest.approx(1 / 3, abs=0.01) and not chain["gamma_err"][:-1].any()
    for early, late, exponent in zip(_first_pulse(1e3), _first_pulse(1e4), (-1, -0.5)):  # 1/t, and t^(-1/2) behind it
        assert math.log10(late / early) == pytest.approx(exponent, abs=0.03)
