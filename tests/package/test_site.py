"""The pages as a site: built without a warning, complete, of files of its own; and no misspelt words in what we wrote.

usage: test_site.py BUILD_DIR SOURCE_DIR
"""
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BUILD, SOURCE = map(pathlib.Path, sys.argv[1:3])
#: names, and words of tests that are misspelt on purpose
KNOWN = "statics,mater,workd,lates,widht,upto,exponant,makse,fro,commun,bu,partcles,presure,packin"
WRITTEN = (".md", ".c", ".h", ".py", ".inc", ".1", ".js", ".html")
OTHERS = ("/three/", "/results/", "/samples/", "/build/")


def built(folder):
    source, site = folder / "tree/docs", folder / "site"
    shutil.copytree(SOURCE / "docs", source)
    for other in SOURCE.iterdir():  # what pages link to
        if other.name not in ("docs", "build", ".git"):
            (folder / "tree" / other.name).symlink_to(other)
    done = subprocess.run(["sphinx-build", "-q", "-W", "--keep-going", "-b", "html", source, site], capture_output=True,
                          text=True, env={**os.environ, "SONOPACK_BUILD": str(BUILD)})
    assert done.returncode == 0, done.stderr
    return site


def check_pages(site):
    pages = {page: page.read_text() for page in site.rglob("*.html")}
    for page in SOURCE.glob("docs/**/*.md"):
        html = site / page.relative_to(SOURCE / "docs").with_suffix(".html")
        assert html in pages or "results" in str(page) or "printed" in str(page), page
    for page, text in pages.items():
        away = re.findall(r"<(?:script|link|img)[^>]*(?:src|href)=\"(https?:[^\"]+)", text)
        assert not away, (page, away)
    commands = pages[site / "printed/commands.html"]
    assert all(f'id="{name}"' in commands for name in ("pack", "signal", "modes", "moduli", "trace"))
    assert "packing.types.friction" in pages[site / "printed/keys.html"]
    check_layouts(" ".join(re.sub("<[^>]*>", " ", pages[site / "printed/layouts.html"]).split()))
    assert "sonopack.Packing.from_arrays" in pages[site / "api/python.html"]
    packing = pages[site / "printed/c-packing.h.html"]
    assert all(f'id="c.{name}"' in packing for name in ("sp_packing_free", "sp_contact.overlap", "sp_cell.SP_CELL_RING"))
    assert (site / "searchindex.js").stat().st_size > 10000 and list(site.glob("_static/fonts/*.woff2"))


def check_layouts(text):
    """Every dataset that a source names is on the page, and the shapes and units are those of the files."""
    for name in ("packing", "modes", "sample"):
        source = (SOURCE / f"src/study/store/{name}_h5.c").read_text()
        named = set(re.findall(r'"(/(?:particles|connectivity|sonopack|modes|results|signal)/[/\w]*\w)"', source))
        lacking = [path for path in named if path not in text]
        assert len(named) > 3 and not lacking, lacking
    for row in ("/modes/vector float64 [n - R][G f] 1", "/sonopack/contacts/friction float64 [C] 1",
                "/particles/grains/box/edges float64 [D] or float64 [D][D] d", "/results/moduli/c66 float64 E*", "radius radius, r, R, rad, Radius"):
        assert row in text, row


def check_spelling():
    files = [path for path in SOURCE.rglob("*") if path.suffix in WRITTEN and path.is_file()
             and not any(part in str(path) for part in OTHERS)]
    done = subprocess.run(["codespell", "-L", KNOWN, *files], capture_output=True, text=True)
    assert done.returncode == 0 and len(files) > 500, done.stdout


if not (all(map(shutil.which, ("sphinx-build", "codespell", "doxygen"))) and importlib.util.find_spec("breathe")
        and pathlib.Path("/usr/share/javascript/katex").is_dir()):
    print("sphinx-build, codespell, doxygen, breathe or KaTeX is not there")
    sys.exit(77)
with tempfile.TemporaryDirectory(prefix="sonopack-site-") as place:
    check_pages(built(pathlib.Path(place)))
check_spelling()
