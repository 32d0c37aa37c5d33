#!/usr/bin/python3
"""Means of an ensemble beside the published ones: compare.py STATICS.tsv MODULI.tsv (tables of `sonopack table`).

The deviation is in standard deviations of the paper where it gives them, else in ours. A line a quantity and pressure."""
import os
import sys


def rows(path):
    lines = [line.rstrip("\n").split("\t") for line in open(path) if line.strip() and not line.startswith("#")]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


def main(tables):
    paper = rows(os.path.join(os.path.dirname(os.path.abspath(__file__)), "somfai2005.tsv"))
    ours = [row for path in tables for row in rows(path) if row["grains"] == "600"]
    print("p\tquantity\tpaper\tpaper_sd\tours\tours_sd\tdeviation")
    for line in paper:
        name = line["quantity"]
        for row in ours:
            if name in row and abs(float(row["p"]) / float(line["p"]) - 1) < 1e-6:
                mean, spread = float(row[name]), float(row[name + "_sd"])
                unit = float(line["sd"]) if line["sd"] else spread
                print(f"{line['p']}\t{name}\t{line['mean']}\t{line['sd']}\t{mean:.4g}\t{spread:.2g}\t"
                      f"{(mean - float(line['mean'])) / unit:+.1f}")


main(sys.argv[1:])
