"""sonopack reproduce somfai2005: the claims in words with two samples each, and the other protocol.

usage: test_reproduce_claims_long.py COMMAND SOURCE_DIR
"""
import pathlib
import tempfile

from test_reproduce import check_counts, check_report, check_rows, rows_of, run


def claims(folder):
    """Every claim with two samples: an error where it can have one, and what is exact."""
    store, out = folder / "claims", folder / "claims-report"
    done = run("somfai2005", "--only", "claims", "--samples", 2, "--store", store, "-o", out, "--jobs", 2)
    rows = rows_of(done.stdout)
    check_rows(rows)
    check_counts(done.stdout)
    assert check_report(out, ["claims"], rows) == 0
    exact = {row["quantity"]: row for row in rows if float(row["err"]) == 0}
    assert abs(float(exact["exponent of the first pulse's energy"]["ours"]) + 1) < 0.002
    assert abs(float(exact["exponent of the oscillations behind it"]["ours"]) + 0.5) < 0.001
    assert abs(float(exact["Pi Z(2), whole forces"]["ours"]) - 1) < 1e-12
    value = {row["quantity"]: float(row["ours"]) for row in rows}
    assert value["low modes without friction over with"] > 1.2
    assert value["P* = 10, smooth: contacts z*"] == 6
    assert abs(value["P* = 10, smooth: c over the lattice's"] - 1) < 0.005
    assert value["P* = 0.1, friction: c over the lattice's"] < 0.95
    assert abs(value["smooth: z* of an uneven lattice at p = 0"] - 4) < 0.15
    assert {row["where"] for row in rows} >= {"Sec. IV A", "Sec. IV C", "Sec. IV D", "Sec. IV E", "Eq. (17)", "Fig. 8",
                                              "Fig. 11"}


def other_protocol(folder):
    """Packings of its own, the same rows and counts."""
    only = ("somfai2005", "--only", "table1", "--samples", 1, "--store", folder / "protocols")
    usual, slow = (rows_of(run(*only, "--protocol", name).stdout) for name in ("default", "somfai2005"))
    check_rows(slow)
    assert [row["quantity"] for row in slow] == [row["quantity"] for row in usual]
    assert [row["ours"] for row in slow] != [row["ours"] for row in usual]


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-claims-") as name:
        folder = pathlib.Path(name)
        claims(folder)
        other_protocol(folder)


if __name__ == "__main__":
    main()
