"""The pages as a site: `./run docs` builds it in build/docs. What the program can print is printed into pages of the
reference, and so are the comments of the C headers, by doxygen."""
import itertools
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ.get("SONOPACK_BUILD", HERE.parent / "build/release")).resolve()
PRINTED = HERE / "printed"  # pages that are made here; git does not know them
sys.path[:0] = [str(BUILD / "python"), str(HERE)]

import layouts

project = "sonopack"
author = copyright = "the sonopack authors"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "breathe"]
exclude_patterns = ["studies/results"]
root_doc = "index"
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
suppress_warnings = ["misc.highlighting_failure"]
html_theme = "furo"
html_title = "sonopack"
html_show_copyright = False
html_show_sphinx = False
# formulas are drawn by KaTeX from the site's own files; where it is not installed, by MathJax from elsewhere
KATEX = pathlib.Path("/usr/share/javascript/katex")
if KATEX.is_dir():
    mathjax_path = "site.js"
    html_static_path = [str(KATEX), "site.js"]
    html_css_files = ["katex.min.css"]
    html_js_files = ["katex.min.js", "contrib/auto-render.js"]
autodoc_member_order = "groupwise"
autodoc_typehints = "none"
breathe_projects = {"sonopack": str(PRINTED / "xml")}
breathe_default_project = "sonopack"
breathe_domain_by_extension = {"h": "c"}
breathe_show_enumvalue_initializer = True


def command(*words):
    return subprocess.run([BUILD / "sonopack", *words], check=True, capture_output=True, text=True,
                          env={**os.environ, "COLUMNS": "100"}).stdout


def print_pages(app):
    """The reference of commands, keys, datasets and columns, as the program tells them."""
    shutil.rmtree(PRINTED, ignore_errors=True)
    PRINTED.mkdir()
    names = re.findall(r"^  ([a-z]+) ", command("help"), re.M)
    pages = {"commands": "# Commands\n\n" + "\n".join(
        f"## {name}\n\n```text\n{command(name, '--help').rstrip()}\n```\n" for name in names if name != "help")}
    groups = {}
    for key in re.findall(r"^([\w.]+\.\w+) = ", command("help", "scene"), re.M):
        groups.setdefault(key.split(".")[0], []).append(f"```text\n{command('help', key).rstrip()}\n```\n")
    pages["keys"] = "# Keys of scenes\n\n" + "\n".join(f"## {group}\n\n" + "\n".join(all) for group, all in groups.items())
    pages["layouts"] = layouts.page(BUILD / "sonopack")
    for name, text in pages.items():
        (PRINTED / f"{name}.md").write_text(text)
    print_headers()


def print_headers():
    """A page of each public header."""
    subprocess.run(["doxygen", "docs/api/Doxyfile"], check=True, cwd=HERE.parent)
    numbers = itertools.count()  # for nameless enums: doxygen 1.9.4 makes them, 1.9.8 does not, Sphinx wants them
    for file in (PRINTED / "xml").glob("*_8h.xml"):
        file.write_text(re.sub("<name></name>", lambda _: f"<name>@{next(numbers)}</name>", file.read_text()))
    include = HERE.parent / "include/sonopack"
    for header in include.rglob("*.h"):
        name = str(header.relative_to(include))
        page = PRINTED / f"c-{name.replace('/', '-')}.md"
        if name != "visibility.h":
            page.write_text(f"# sonopack/{name}\n\n```{{doxygenfile}} {name}\n```\n")


def plain(app, what, name, obj, options, lines):
    """Docstrings are plain text: E* is no emphasis, and indented lines stay lines."""
    out = []
    for line in lines:
        text = re.sub(r"([*`|_\\])", r"\\\1", line.strip())
        out += ["", "| " + text, ""] if line.startswith(" ") and text else [text]
    lines[:] = out


def inside(app, name, source):
    """Of links to pages that the site does not have, the text."""
    def link(found):
        target = (HERE / name).parent / found[2].split("#")[0]
        outside = target.suffix == ".md" and not target.resolve().is_relative_to(HERE)
        return found[1] if outside else found[0]
    source[0] = re.sub(r"\[([^][]*)\]\(([^()\s]+)\)", link, source[0])


def setup(app):
    app.connect("source-read", inside)
    app.connect("builder-inited", print_pages)
    app.connect("autodoc-process-docstring", plain)
