"""The pages of docs/gallery: their commands run and make their picture, and print the numbers that the pages tell; the
pages are short and linked in a chain that the index follows. The pages of docs/literature, tutorial.md, recipes.md and faq.md run
too.

The commands of every sixth page run here, those of all in test_gallery_long.py.

usage: test_gallery.py COMMAND SOURCE_DIR [--pictures]

A page tells what is to come out in comments: `<!-- check: VALUE = EXPRESSION; ... -->`, also with < or >. In the expression
FILE.tsv:COLUMN:ROW is a number of a table (row 1 may be left out), FILE.tsv:#NAME that of a comment `# NAME = number`.
FILE.tsv may be one of docs/studies/results. FILE is also what `sonopack FILE` printed (front.out), the second time
front2.out. The functions are those of Python's math. VALUE is as the page writes it, which the test looks for; of 0.119(2)
the second number is that of the column with _err at its end. A number with a point or an exponent may differ by one in its
last digit, any other by nothing.

Blocks of ```console python run where the Python package is built, those of ```console chromium only with --pictures. This
makes the pictures in docs/gallery anew, from what the commands drew, reduced to be small (Pillow; build with
SONOPACK_PYTHON=ON, and install matplotlib and chromium).
"""
import itertools
import math
import pathlib
import re
import shutil
import sys
import tempfile

from test_readme import COMMAND, SOURCE, console_commands, run_page

FOLDER = SOURCE / "docs/gallery"
PAGES = sorted(FOLDER.glob("[0-9][0-9]-*.md"))
WORDS = ["docs/tutorial.md", "docs/recipes.md", "docs/faq.md"] + [
    f"docs/literature/{page.name}" for page in sorted(SOURCE.glob("docs/literature/[a-z]*.md"))]
LARGEST = 60000  # bytes of a picture
COMMENT = re.compile(r"<!-- check: (.+?)\s-->", re.S)
CHECK = re.compile(r"\s*(\S+)\s([=<>])\s(.+)", re.S)
TERM = re.compile(r"([\w.-]+\.(?:tsv|out)):(#?\w+)(?::(\d+))?")


def table_number(path, name, row):
    text = path.read_text()
    if name.startswith("#"):
        return float(re.findall(rf"^# {name[1:]} = ([^\s,]+)", text, re.M)[0])
    rows = [line.split("\t") for line in text.split("\n") if line and not line.startswith("#")]
    return float(rows[row][rows[0].index(name)])


def value_of(expression, folder):
    def number(found):
        return f"({table_number(folder / found[1], found[2], int(found[3] or 1))!r})"
    names = {name: getattr(math, name) for name in ("sqrt", "log", "exp", "pi", "inf", "nan")}
    return eval(f"({TERM.sub(number, expression)})", {"__builtins__": {"abs": abs, "min": min, "max": max, "round": round}}, names)


def last_digit(text):
    """One in the last digit of a number as it is written."""
    digits, _, exponent = text.lower().partition("e")
    places = len(digits.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - places)


def with_error(told, expression):
    """The checks of a number: 0.119(2) of NAME is 0.119 of NAME and 0.002 of NAME_err."""
    found = re.fullmatch(r"([^(]*)\((\d+)\)", told)
    if not found:
        return [(told, expression)]
    places = len(found[1].partition(".")[2])
    error = f"{int(found[2]) * 10.0**-places:.{places}f}"
    return [(found[1], expression), (error, TERM.sub(lambda term: f"{term[1]}:{term[2]}_err:{term[3] or 1}", expression))]


def holds(told, relation, value):
    if relation != "=":
        return value < float(told) if relation == ">" else value > float(told)
    exact = re.fullmatch(r"-?\d+", told)
    return abs(value - float(told)) <= (1e-9 if exact else 1.001 * last_digit(told))


def keep_outputs(outputs, folder):
    """What the commands printed, as files."""
    count = {}
    for command, output in outputs:
        if command.startswith("sonopack ") and output:
            name = command.split()[1]
            count[name] = count.get(name, 0) + 1
            (folder / f"{name}{count[name] if count[name] > 1 else ''}.out").write_text(output)


def check_numbers(text, folder):
    """What a page tells, against what its commands have written into a folder."""
    faults = []
    seen = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    checks = [check for comment in COMMENT.findall(text) for check in comment.split(";")]
    for told, relation, expression in (found.groups() for check in checks if (found := CHECK.fullmatch(check))):
        if not re.search(rf"(?<![\w.]){re.escape(told)}(?![\w]|\.\d)", seen):
            faults.append(f"checks {told}, which the page does not tell")
        for number, of in with_error(told, expression):
            try:
                value = value_of(of, folder)
            except (OSError, LookupError, ValueError, ArithmeticError) as fault:  # no such file, row or column
                faults.append(f"checks {number} {relation} {of}: {fault}")
                continue
            if not holds(number, relation, value):
                faults.append(f"tells {number} {relation} {of}, which is {value!r}")
    if len(re.findall(r"<!-- *check", text)) != len(COMMENT.findall(text)) or not all(map(CHECK.fullmatch, checks)):
        faults.append("has a check that cannot be read")
    return faults


def check_the_checker(folder):
    (folder / "a.tsv").write_text("# error = 1e-16, bound\nx\ty\ty_err\n1\t2\t0\n3\t4.56789\t0.0312\n")
    page = "It is 4.57 and 2, below 1e-15, twice 9.1e0, 4.57(3), 4.57(1), 4.51(3). <!-- check: {} -->"
    for good in ("4.57 = a.tsv:y:2", "2 = a.tsv:y", "1e-15 > a.tsv:#error", "9.1e0 = 2*a.tsv:y:2", "2 < a.tsv:x:2",
                 "4.57(3) = a.tsv:y:2"):
        assert check_numbers(page.format(good), folder) == [], good
    for bad in ("4.57 = a.tsv:y:1", "2 = a.tsv:y + 0.1", "1e-15 < a.tsv:#error", "5.0 = 5", "4.5 = 4.5", "2 is 2",
                "4.57(1) = a.tsv:y:2", "4.51(3) = a.tsv:y:2",
                "2 = b.tsv:y", "2 = a.tsv:z", "2 = a.tsv:y:9", "2 = a.tsv:#b"):
        assert len(check_numbers(page.format(bad), folder)) == 1, bad


def picture_of(text):
    return re.search(r"!\[[^\]]+\]\(([\w.-]+\.png)\)", text).group(1)


def check_form(page, before, after):
    """A page is short, has a picture, and leads to its neighbours and to the index."""
    text, faults = page.read_text(), []
    if len(text.split("\n")) > 60:
        faults.append("is longer than 60 lines")
    if not (FOLDER / picture_of(text)).stat().st_size < LARGEST:
        faults.append(f"has a picture {picture_of(text)} of 60 kB or more")
    if not COMMENT.search(text):
        faults.append("checks no number")
    for neighbour in (before, after, FOLDER / "README.md"):
        if neighbour and f"]({neighbour.name})" not in text:
            faults.append(f"does not lead to {neighbour.name}")
    return [f"{page.name}: {fault}" for fault in faults]


def reduce_picture(drawn, target):
    from PIL import Image  # only to make pictures anew
    whole = Image.open(drawn).convert("RGB")
    for width, colours in itertools.product((720, 600, 500, 420, 360), (64, 32, 24)):
        picture = whole.resize((width, round(whole.height * width / whole.width)), Image.LANCZOS)
        few = picture.quantize(colours, method=Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
        few.save(target, optimize=True)
        if target.stat().st_size < LARGEST:
            break


def fences_of(pictures):
    """Which blocks of commands run: those that need the Python package where it is built."""
    fences = ["```console"]
    if (COMMAND.parent / "python/sonopack").exists():
        fences.append("```console python")
    return fences + ["```console chromium"] * pictures


def check_page(page, pictures):
    text, fences = page.read_text(), fences_of(pictures)
    others = set(re.findall(r"^```console (?!long)\w+$", text, re.M))

    def look(scratch, outputs):
        keep_outputs(outputs, scratch)
        drawn = scratch / picture_of(text)
        faults = check_numbers(text, scratch)
        if drawn.exists() and pictures:
            reduce_picture(drawn, FOLDER / drawn.name)
        elif not others and not drawn.read_bytes().startswith(b"\x89PNG\r\n\x1a\n"):
            faults.append(f"draws no {drawn.name}")
        return faults

    faults = run_page(page.relative_to(SOURCE), look, fences) if console_commands(text, fences) or not others else []
    faults = [faults] if isinstance(faults, str) else faults
    return [f"{page.name}: {fault}" for fault in faults]


def words_of(page, scratch, outputs):
    shutil.copytree(SOURCE / "docs/studies/results", scratch, dirs_exist_ok=True)
    keep_outputs(outputs, scratch)
    return check_numbers((SOURCE / page).read_text(), scratch)


def check_index():
    text = (FOLDER / "README.md").read_text()
    found = re.findall(r"\]\((\d\d-[\w-]+\.md)\)", text)
    faults = [] if list(dict.fromkeys(found)) == [page.name for page in PAGES] else ["README.md: not the pages in their order"]
    return faults + [f"README.md: no picture of {page.name}" for page in PAGES if picture_of(page.read_text()) not in text]


def main(every=6):
    with tempfile.TemporaryDirectory(prefix="sonopack-gallery-") as folder:
        check_the_checker(pathlib.Path(folder))
    faults = [] if len(PAGES) >= 18 else ["pages are missing"]
    for k, (page, before, after) in enumerate(zip(PAGES, [None, *PAGES], [*PAGES[1:], None])):
        faults += check_form(page, before, after)
        faults += [] if k % every else check_page(page, "--pictures" in sys.argv)
    fences = fences_of(False)
    for page in WORDS[::every]:
        if "```console python" in (SOURCE / page).read_text() and len(fences) < 2:
            continue
        fault = run_page(page, lambda scratch, outputs, page=page: words_of(page, scratch, outputs), fences)
        faults += [f"{page}: {one}" for one in ([fault] if isinstance(fault, str) else fault)]
    faults += check_index()
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main(1 if "--pictures" in sys.argv else 6)
