"""uncertainty: its table against the command's own values, units, and measured packings. The statistics are in
tests/unit/test_inference_uncertain.c.

usage: test_uncertainty.py COMMAND SOURCE_DIR
"""
import math
import pathlib

from command import N200, SOURCE, main, refused, run, table, Table
from common import names_all

SAMPLES = SOURCE / "tests/foreign/samples/photoelastic"


def uncertainty(*words):
    """{quantity: {column: number or word}}, and the table."""
    found = table("uncertainty", *words)
    return rows_of(found), found


def rows_of(found):
    return {row[0]: dict(zip(found.names, row)) for row in found.rows}


def same_values(path, rows):
    """The values without errors are those of front and moduli."""
    for command, names in (("front", {"t10": "t10", "t_peak": "t_peak", "peak": "amplitude", "width": "width"}),
                           ("moduli", {"C22": "C22", "c_l": "c_l", "c_t": "c_t"})):
        found = table(command, path)
        for name, column in names.items():
            assert abs(float(rows[name]["value"]) / found[column][0] - 1) < 1e-9, (path, name)


def values():
    same_values(N200, uncertainty(N200, "--force=0.01", "--samples=10")[0])


def measured():
    """Contacts that are not where the positions say: pixels, and oblique forces on walls."""
    run("convert", SAMPLES / "particles.csv", "disks.h5", "--frame=1", f"--contacts={SAMPLES}/contacts.csv",
        "--material=E=4e6,nu=0.5,rho=1060", "--length-unit=0.05e-3", "--kn=5e4", "--kt-ratio=0.5", "--thickness=6e-3",
        "--walls=balance", "--set=friction=0.5")
    said = run("uncertainty", "disks.h5", "--position=0.003", "--force=0.1", "--samples=40", "-o", "errors.tsv").stderr
    assert names_all(said, "disks.h5 --force --stiffness"), said
    rows = rows_of(Table(pathlib.Path("errors.tsv").read_text()))
    same_values("disks.h5", rows)
    assert all(rows[name]["linear"] == "yes" for name in ("t10", "peak", "C22", "c_l")), rows


def first_order():
    """All stiffnesses together by 1%: t10 by 0.5%, moduli by 1%, and shares that add up."""
    rows, _ = uncertainty(N200, "--calibration=0.01", "--samples=0", "--modes=2")
    for name, power in (("t10", 0.5), ("C11", 1), ("c_l", 0.5), ("omega_2", 0.5)):
        assert abs(float(rows[name]["sd_first"]) / float(rows[name]["value"]) / (0.01 * power) - 1) < 5e-3, name
        assert rows[name]["sd"] == "nan" and rows[name]["linear"] == "unknown"
    rows, _ = uncertainty(N200, "--force=0.1", "--radius=0.01", "--position=0.01", "--false=0.01", "--samples=0")
    for name, row in rows.items():
        assert abs(sum(float(row[key]) for key in row if key.startswith("share_")) - 1) < 1e-9, name


def parts():
    """Rows for grains and contacts: what is left of 1 is the calibration, and the worst contact is told."""
    given = ("--force=0.1", "--radius=0.01", "--calibration=0.01", "--modes=1")
    shares = {name: float(row["share_calibration"]) for name, row in uncertainty(N200, *given, "--samples=0")[0].items()}
    grains, contacts = (table("uncertainty", N200, *given, f"--by={by}") for by in ("grain", "contact"))
    assert grains.names[:3] == ["grain", "x", "y"] and contacts.names[:2] == ["i", "j"] and contacts["j"].min() == -2
    for name, share in shares.items():
        assert abs(grains[name].sum() + contacts[name].sum() + share - 1) < 1e-9, name
    for words in (("--missing=0.1",), ("--force=0.1", "--samples=10"), ("--force=0.1", "--sampled-only")):
        refused("--by", "uncertainty", N200, "--by=grain", *words)
    refused("--by --prestress", "uncertainty", N200, "--force=0.1", "--by=grain", "--prestress")


def samples():
    words = [N200, "--from=overlaps", "--position=0.003", "--samples=30", "--seed=4"]
    rows, found = uncertainty(*words)
    assert rows == uncertainty(*words, "--threads=1")[0]
    assert rows["t10"]["linear"] == "no" and int(rows["t10"]["samples"]) <= 30
    assert found.notes["measured"] == "overlaps" and found.note("overlap") > 1e-3 and found.note("contacts_ratio") < 1
    few = uncertainty(N200, "--from=overlaps", "--position=0.05", "--samples=10", "--front-only")[0]["t10"]
    # most draws have no sound: of few samples the standard deviation has a large error, and not none
    assert 2 <= int(few["samples"]) <= 5 and few["linear"] == "no" and float(few["sd_err"]) > 0.2 * float(few["sd"]), few
    rows, found = uncertainty(N200, "--missing=0.2", "--samples=20", "--front-only")
    assert rows["t10"]["sd_first"] == "nan" and float(rows["t10"]["sd"]) > 0 and "C11" not in rows
    assert found.note("candidates") > 10 and found.note("contacts_ratio") > 1


def units():
    material = "--material=E=70e9,nu=0.2,rho=2500,d=2e-3"
    own, one = uncertainty(N200, material, "--position=0.02 mm", "--samples=10")
    si, two = uncertainty(N200, material, "--position=0.01", "--samples=10", "--units=si")
    modulus = 70e9 / (1 - 0.2**2)
    speed = math.sqrt(modulus / 2500)
    for name, unit, factor in (("t10", "us", 2e-3 / speed * 1e6), ("C22", "kPa", modulus * 1e-3), ("c_l", "m/s", speed),
                               ("peak", "N", modulus * 4e-6)):
        assert si[name]["unit"] == unit and si[name]["share_position"] == own[name]["share_position"], si[name]
        for key in ("value", "sd", "bias_err", "sd_first"):
            assert abs(float(si[name][key]) / float(own[name][key]) / factor - 1) < 1e-9, (name, key)
    assert two.notes["position"] == "0.02 mm" and one.note("position") == 0.01


main(values, measured, first_order, parts, samples, units)
