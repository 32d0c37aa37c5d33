#!/usr/bin/env python3
"""Counts the house: lines of code by room, words of documents. usage: docs/house.py [--write]

Prints the table of docs/DESIGN.md, "The house in numbers"; with --write puts it there, between the two comments `house`.
Lines are all lines of the files that git knows, comments and blank ones included; results and data are not code.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
CODE = {".c", ".h", ".inc", ".py", ".js", ".html", ".css", ".sh", ".m", ".R", ".txt", ""}

#: what, folders, endings, most that it may have, what it buys
ROWS = [
    ("C: the core", ["src/core"], {".c", ".h", ".inc"}, None, "packings, networks, signals, modes, moduli, spectra, sensitivities"),
    ("C: the tapped column", ["src/tapped"], {".c", ".h", ".inc"}, None, "the second model"),
    ("C: studies", ["src/study"], {".c", ".h", ".inc"}, None, "scenes, ensembles, stores"),
    ("C: the command", ["src/cli"], {".c", ".h", ".inc"}, None, "the commands that compute"),
    ("C: public headers", ["include"], {".h", ".inc"}, None, "the interface, documented"),
    ("**C in src and include**", ["src", "include"], {".c", ".h", ".inc"}, 60000, ""),
    ("Python: the library", ["python/sonopack/*.py", "python/*.py"], {".py"}, None, "the library as objects with arrays"),
    ("Python: plot", ["python/sonopack/plot"], {".py"}, None, "figures"),
    ("Python: formats", ["python/sonopack/formats"], {".py"}, None, "other programs' files"),
    ("Python: papers", ["python/sonopack/papers"], {".py"}, None, "published values beside ours"),
    ("Python: view", ["python/sonopack/view"], {".py"}, None, "what fills the page"),
    ("**Python**", ["python"], {".py"}, 12000, ""),
    ("JavaScript, HTML and CSS of the page", ["python/sonopack/view/web"], {".js", ".html", ".css"}, None, "packings, modes, waves in a browser"),
    ("**tests**", ["tests"], {".c", ".h", ".inc", ".py", ".txt", ".sh", ".m", ".R", ""}, 47000, ""),
    ("**benchmarks**", ["benchmarks"], {".c", ".h", ".py", ".sh", ".md", ".txt", ".cfg", ".tsv", ".m", ""}, 6000, ""),
]


def tracked():
    names = subprocess.run(["git", "-C", ROOT, "ls-files"], text=True, capture_output=True, check=True).stdout.split("\n")
    return [name for name in names if name and (ROOT / name).is_file() and not (ROOT / name).is_symlink()]


def belongs(name, places):
    return any(name.startswith(place + "/") if "*" not in place else
               re.fullmatch(place.replace(".", r"\.").replace("*", "[^/]*"), name) for place in places)


def lines(names, places, endings):
    return sum((ROOT / name).read_bytes().count(b"\n") for name in names
               if belongs(name, places) and pathlib.PurePath(name).suffix in endings and "three.bundle" not in name)


def table():
    names = tracked()
    rows = ["| what | lines | at most | what it buys |", "|---|---:|---:|---|"]
    for what, places, endings, most, buys in ROWS:
        rows.append(f"| {what} | {lines(names, places, endings):,} | {f'{most:,}' if most else ''} | {buys} |")
    documents = [name for name in names if name.endswith(".md") and
                 (name.startswith("docs/") or name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))]
    words = sum(len((ROOT / name).read_text(encoding="utf-8").split()) for name in documents)
    rows.append(f"| **words in docs, README, CONTRIBUTING and CHANGELOG** | {words:,} | 70,000 | |")
    rows.append(f"| files | {len(names):,} | | |")
    return "\n".join(rows)


def main():
    found = table()
    print(found)
    if "--write" in sys.argv[1:]:
        page = ROOT / "docs/DESIGN.md"
        text = page.read_text(encoding="utf-8")
        new = re.sub(r"(<!-- house -->\n).*?(<!-- /house -->)", lambda m: f"{m[1]}{found}\n{m[2]}", text, flags=re.S)
        page.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
