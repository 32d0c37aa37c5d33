"""Links and paths in the documentation lead somewhere: relative links with their anchors, and paths in backticks.

usage: test_links.py COMMAND SOURCE_DIR
"""
import itertools
import pathlib
import re
import sys
import tempfile

PATH = re.compile(r"(?:src|include|tests|benchmarks|docs|packings)/[^\s`]*")


def without_fences(text):
    """Commands and their output name files that exist only where they are run."""
    return re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)


def anchors(page):
    """The names that GitHub gives to the headings of a page."""
    heads = re.findall(r"^#+ +(.+)", without_fences(page.read_text()), re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def exists(root, path):
    """Of a path with {a,b} every form must exist; <...> and NAME stand for anything, as * does."""
    path = re.sub(r"<[^>]*>|NAME", "*", re.sub(r":\d+$", "", path))
    parts = re.findall(r"\{[^}]*\}|[^{]+", path)
    groups = [part[1:-1].split(",") if part[0] == "{" else [part] for part in parts]
    return all(next(root.glob("".join(form).rstrip("/")), None) for form in itertools.product(*groups))


def faults(root, page, text):
    text = without_fences(text)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        file, _, anchor = target.partition("#")
        to = (page.parent / file) if file else page
        if re.match(r"\w+:", target):
            continue
        if not to.exists() or (anchor and anchor not in anchors(to)):
            yield f"{page.relative_to(root)}: a link to {target}, which is not there"
    for path in re.findall(r"`([^`\n]+)`", text):
        if PATH.fullmatch(path) and not exists(root, path):
            yield f"{page.relative_to(root)}: the path {path}, which is not there"


def check_the_reader():
    """The faults of a planted page are found, and nothing else."""
    with tempfile.TemporaryDirectory(prefix="sonopack-links-") as folder:
        root = pathlib.Path(folder)
        (root / "docs").mkdir()
        page = root / "docs/page.md"
        page.write_text("# Its head\n")
        text = ("[a](page.md) [b](#its-head) [c](https://x.y/z) `docs/*.md` `docs/{page}.md` `docs/p<x>.md` `docs/NAME.md`\n"
                "```\n`docs/not.md`\n```\n[d](no.md) [e](page.md#no-head) `docs/no.md` `docs/{page,no}.md` `src/no*.c`\n")
        found = [fault.split(", ")[0].split()[-1] for fault in faults(root, page, text)]
        assert found == ["no.md", "page.md#no-head", "docs/no.md", "docs/{page,no}.md", "src/no*.c"], found


def main():
    root = pathlib.Path(sys.argv[2]).resolve()
    check_the_reader()
    pages = [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md"))]
    texts = {page: page.read_text() for page in pages if page.exists()}
    history = root / "CHANGELOG.md"
    texts[history] = "\n## ".join(history.read_text().split("\n## ")[:2])  # older entries name files of their time
    found = [fault for page, text in texts.items() for fault in faults(root, page, text)]
    print(*found, sep="\n")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
