"""The plan of the house holds: no include climbs the ranks, foreign headers stay in their rooms, functions and files
are short, sources are formatted, nothing unfinished or local is left in the text. The checker itself is tried on a
planted tree first.

usage: test_structure.py COMMAND SOURCE_DIR
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# The rooms of src/ in the order in which they stand on each other: a room may use rooms of lower rank.
RANKS = {"core/base": 0, "core/table": 1, "core/numeric": 1, "core/linalg": 1, "core/front": 2, "core/chain": 3,
         "core/packing": 3, "core/network": 4, "core/units": 4, "core/modes": 5, "core/elastic": 5, "core/spectrum": 6,
         "core/signal": 6, "core/cost": 7, "core/amplitude": 7, "core/transport": 7, "core/sensitivity": 7,
         "core/inference": 8, "tapped": 7, "study/scene": 8, "study/ensemble": 9, "study/store": 10,
         "cli": 12}
# what stands beside a room, not below it
BESIDE = {"tapped": {"core/base", "core/table", "core/numeric", "core/linalg"}}
# headers of other libraries, and the rooms that may see them
FOREIGN = [(r"hdf5(_hl)?\.h|H5\w*\.h|zlib\.h", {"study/store"}),
           (r"(suitesparse/)?(cholmod|SuiteSparse\w*|amd|umfpack)\.h", {"core/linalg"}),
           (r"(lapacke|lapack|cblas|openblas\w*|f77blas|arpack)\.h", {"core/linalg"}),
           (r"libconfig\.h", {"study/scene"}), (r"argp\.h|getopt\.h|mpi\.h", {"cli"}),
           (r"gsl/.*|Random123/.*", {"core/numeric"})]
LIBC = set("""assert complex ctype errno fcntl fenv float inttypes limits locale math pthread setjmp signal stdalign stdarg
    stdatomic stdbool stddef stdint stdio stdlib string strings tgmath threads time unistd dirent dlfcn ftw libgen sched search
    """.split())
# what only the command may do: speak, and end the process
SPEECH = re.compile(r"(?<![\w.>])(printf|vprintf|puts|putchar|perror|exit|_exit|_Exit|quick_exit|abort|err|errx|warn|"
                    r"warnx)\s*\(|(?<!\w)(stdout|stderr)(?!\w)")
LONGEST_FUNCTION, USUAL_FUNCTION, LONGEST_FILE = 120, 60, 800
UNFINISHED = re.compile(r"\b(" + "|".join(("TO" "DO", "FIX" "ME", "X" "XX", "HA" "CK")) + r")\b")
LOCAL_PATH = re.compile(r"(?<![\w.}~$-])/(home|root|Users|work|scratch|mnt)/")


def without_comments(text):
    """The code with comments and the insides of literals blanked, line by line as before."""
    pattern = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)

    def blank(match):
        kept = re.sub(r"[^\n]", " ", match.group())
        return match.group()[0] + kept[1:-1] + match.group()[-1] if match.group()[0] in "\"'" else kept

    return pattern.sub(blank, text)


def functions(text):
    """(name, first line, lines) of every function definition."""
    code = without_comments(text)
    code = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda m: "\n" * m.group().count("\n"), code, flags=re.M)
    found, depth, opened, line, start = [], 0, None, 1, 0
    for position, letter in enumerate(code):
        if letter == "\n":
            line += 1
        elif letter == "{":
            head = code[start:position].strip()
            if depth == 0 and head.startswith("extern"):
                start = position + 1
                continue
            if depth == 0 and head.endswith(")"):
                opened = (re.search(r"(\w+)\s*\(", head).group(1), line - head.count("\n"))
            depth += 1
        elif letter == "}":
            depth = max(0, depth - 1)
            if depth == 0:
                start = position + 1
                if opened:
                    found.append((*opened, line - opened[1] + 1))
                    opened = None
        elif letter == ";" and depth == 0:
            start = position + 1
    return found


def room_of(path):
    """The room of a path below src/: "core/network" of core/network/apply.c."""
    return "/".join(path.parts[:-1])


def may_use(room, other):
    return other == room or RANKS[other] < RANKS[room] and other in BESIDE.get(room, RANKS)


def check_includes(root):
    """Includes of every file of src/ against the ranks of the rooms."""
    faults = []
    for path in sorted((root / "src").rglob("*.[ch]")):
        room = room_of(path.relative_to(root / "src"))
        name = path.relative_to(root)
        if room not in RANKS:
            faults.append(f"{name}: no room of the plan is called {room}")
            continue
        for number, line in enumerate(path.read_text().split("\n"), 1):
            match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
            if not match:
                continue
            form, header = match.groups()
            where = f"{name}:{number}: {header}"
            if header.startswith("sonopack/"):
                if not (root / "include" / header).exists():
                    faults.append(f"{where}: no such public header")
            elif form == '"':
                other = next((r for r in RANKS if r.split("/")[-1] == header.split("/")[0]), None)
                if other is None or not (root / "src" / other / header.split("/")[-1]).exists():
                    faults.append(f'{where}: private headers are named "room/file.h"')
                elif not may_use(room, other):
                    faults.append(f"{where}: {room} (rank {RANKS[room]}) may not include {other} (rank {RANKS[other]})")
            else:
                rooms = next((rooms for pattern, rooms in FOREIGN if re.fullmatch(pattern, header)), None)
                if rooms is not None and room not in rooms:
                    faults.append(f"{where}: only for {', '.join(sorted(rooms))}")
                elif rooms is None and header.removesuffix(".h") not in LIBC and not header.startswith("sys/"):
                    faults.append(f"{where}: a library that the plan does not know")
    for path in sorted((root / "include").rglob("*.h")):
        for number, line in enumerate(path.read_text().split("\n"), 1):
            match = re.match(r'\s*#\s*include\s*[<"]([^>"]+)', line)
            if match and not match.group(1).startswith("sonopack/") and match.group(1).removesuffix(".h") not in LIBC:
                faults.append(f"{path.relative_to(root)}:{number}: a public header shows {match.group(1)}")
    return faults


def objects_of(build):
    """{source below src/: its object file} of a build."""
    found = {}
    for path in pathlib.Path(build, "CMakeFiles").glob("*.dir/src/**/*.o"):
        source = path.relative_to(build).as_posix().split("/src/", 1)[1].removesuffix(".o")
        found[source] = path
    return found


def calls_of(objects):
    """{source: {sources whose global symbols it uses: one of these symbols}}"""
    defined, wanted = {}, {}
    source_of = {str(path): source for source, path in objects.items()}
    listing = subprocess.run(["nm", "-A", "-g", *source_of], text=True, capture_output=True, check=True).stdout
    for path, words in (line.split(":", 1) for line in listing.splitlines()):
        source, words = source_of[path], words.split()
        if words[0] == "U":
            wanted.setdefault(source, set()).add(words[1])
        elif len(words) == 3:
            defined[words[2]] = source
    return {source: {defined[name]: name for name in sorted(names) if defined.get(name, source) != source}
            for source, names in wanted.items()}


def circle_in(calls):
    """Files that call each other in a circle, or None."""
    state = {}

    def walk(source, way):
        state[source] = "open"
        for other in sorted(calls.get(source, ())):
            if state.get(other) == "open":
                return [*way[way.index(other):], other]
            found = None if other in state else walk(other, [*way, other])
            if found:
                return found
        state[source] = "done"
        return None

    for source in sorted(calls):
        found = None if source in state else walk(source, [source])
        if found:
            return found
    return None


def check_calls(root, build):
    """Symbols of every object file of a build against the ranks of the rooms, and for circles."""
    calls = calls_of({s: o for s, o in objects_of(build).items() if (root / "src" / s).exists()})
    faults = []
    for source, others in sorted(calls.items()):
        for other, name in others.items():
            if not may_use(*(room_of(pathlib.PurePath(s)) for s in (source, other))):
                faults.append(f"src/{source}: {name} of src/{other} is above or beside it")
    circle = circle_in(calls)
    if circle:
        faults.append(f"files call each other in a circle: {' -> '.join(circle)}")
    return faults


def check_speech(root):
    faults = []
    for path in sorted((root / "src").rglob("*.[ch]")):
        if room_of(path.relative_to(root / "src")) == "cli":
            continue
        for number, line in enumerate(without_comments(path.read_text()).split("\n"), 1):
            match = SPEECH.search(line)
            if match:
                faults.append(f"{path.relative_to(root)}:{number}: {match.group().strip('( ')}: "
                              "the library never prints, exits or aborts")
    return faults


def sources(root):
    for folder in ("include", "src", "tests", "benchmarks"):
        yield from sorted((root / folder).rglob("*.[ch]"))


def check_lengths(root):
    faults, lengths = [], []
    for path in sources(root):
        name = path.relative_to(root)
        text = path.read_text()
        if text.count("\n") > LONGEST_FILE:
            faults.append(f"{name}: {text.count(chr(10))} lines, at most {LONGEST_FILE}")
        for function, line, length in functions(text):
            lengths.append(length)
            if length > LONGEST_FUNCTION:
                faults.append(f"{name}:{line}: {function} has {length} lines, at most {LONGEST_FUNCTION}")
    usual = sum(length <= USUAL_FUNCTION for length in lengths)
    if lengths and usual < 0.9 * len(lengths):
        faults.append(f"only {usual} of {len(lengths)} functions have up to {USUAL_FUNCTION} lines, not nine in ten")
    return faults


def check_openings(root):
    """Every source of src/ begins with a sentence that says what it does."""
    return [f"{path.relative_to(root)}:1: no comment that says what the file does"
            for path in sorted((root / "src").rglob("*.c"))
            if not re.match(r"/\*\s*([A-Z\"]|sonopack \w+:).{10,}", path.read_text())]


def check_guards(root):
    """No two headers share an include guard: whichever came second would be empty."""
    faults, first = [], {}
    for path in sources(root):
        guard = re.search(r"^#ifndef (\w+)\n#define \1$", path.read_text(), re.M)
        other = first.setdefault(guard[1], path) if guard else path
        if other != path:
            faults.append(f"{path.relative_to(root)}:1: {guard[1]} is the guard of {other.relative_to(root)} too")
    return faults


def check_words(root):
    faults = []
    endings = {".c", ".h", ".py", ".md", ".txt", ".cmake", ".cfg", ".json", ".in", ".1", ".bash", ".sh", ""}
    for path in sorted(root.rglob("*")):
        parts = path.relative_to(root).parts
        if parts[0] in (".git", "build", "results") or path.suffix not in endings or not path.is_file():
            continue
        for number, line in enumerate(path.read_text(errors="replace").split("\n"), 1):
            for pattern, complaint in ((UNFINISHED, "unfinished"), (LOCAL_PATH, "a path of one machine")):
                match = pattern.search(line)
                if match:
                    faults.append(f"{path.relative_to(root)}:{number}: {match.group()}: {complaint}")
    return faults


def check_format(root):
    files = [str(path) for path in sources(root)]
    result = subprocess.run(["clang-format", "--dry-run", "-Werror", *files], text=True, capture_output=True, cwd=root)
    if result.returncode == 0:
        return []
    return sorted(set(re.findall(r"^(\S+?:\d+):\d+: error: code should be", result.stderr, re.M))) or [result.stderr]


RULES = [check_includes, check_speech, check_lengths, check_openings, check_guards, check_words]


def write(root, name, text):
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def check_the_checker(with_format):
    """Each rule finds its planted fault and passes the same tree without it."""
    assert circle_in({"a": {"b": "f", "c": "g"}, "b": {"d": "h"}, "c": {"d": "h"}}) is None
    assert circle_in({"a": {"b": "f"}, "b": {"c": "g"}, "c": {"b": "h"}}) == ["b", "c", "b"]
    assert may_use("cli", "tapped") and not may_use("tapped", "study/store") and not may_use("tapped", "core/packing")
    with tempfile.TemporaryDirectory(prefix="sonopack-structure-") as folder:
        root = pathlib.Path(folder)
        shutil.copy(pathlib.Path(sys.argv[2], ".clang-format"), root)
        good = '/* Makes an f of an x. */\n#include <sonopack/a.h>\n\n#include "base/base.h"\n\nint f(int x) { return x; }\n'
        write(root, "include/sonopack/a.h", "int f(int x);\n")
        write(root, "src/core/base/base.h", "#ifndef SP_BASE_H\n#define SP_BASE_H\n#endif\n")
        write(root, "src/study/ensemble/study.h", "")
        write(root, "src/core/network/network.c", good)
        write(root, "tests/test.h", "")
        rules = RULES + ([check_format] if with_format else [])
        for rule in rules:
            assert rule(root) == [], f"{rule.__name__} finds a fault in a good tree: {rule(root)}"
        body = "    x++;\n"
        planted = [(check_includes, '#include "ensemble/study.h"\n'), (check_includes, "#include <hdf5.h>\n"),
                   (check_includes, '#include "network.h"\n'),
                   (check_includes, "#include <sonopack/nothing.h>\n"), (check_includes, "#include <curl/curl.h>\n"),
                   (check_speech, 'void g(void) { printf("x"); }\n'), (check_speech, "void g(void) { exit(1); }\n"),
                   (check_lengths, "int g(int x) {\n" + body * LONGEST_FUNCTION + "    return x;\n}\n"),
                   (check_lengths, "int x;\n" * LONGEST_FILE), (check_words, "/* FIX" "ME */\n"),
                   (check_words, "/* see /ho" "me/someone/x */\n"), (check_format, "int  x;\n")]
        for rule, fault in planted:
            write(root, "src/core/network/network.c", good + fault)
            if rule in rules:
                assert rule(root), f"{rule.__name__} does not find {fault[:60]!r}"
        write(root, "src/core/network/other.h", "#ifndef SP_BASE_H\n#define SP_BASE_H\n#endif\n")
        assert check_guards(root), "check_guards does not find two equal guards"
        # neither comments nor snprintf nor a name that ends in exit are speech
        write(root, "src/core/network/network.c", good + 'void g(char *x) { snprintf(x, 2, "exit(1) %s", ""); on_exit(); }\n'
              "/* printf(x) */\n")
        assert check_speech(root) == [], check_speech(root)


def main():
    root = pathlib.Path(sys.argv[2])
    with_format = shutil.which("clang-format") is not None
    check_the_checker(with_format)
    rules = RULES + ([check_format] if with_format else [])
    faults = [fault for rule in rules for fault in rule(root)]
    build = pathlib.Path(sys.argv[1]).resolve().parent
    if not objects_of(build):
        faults.append(f"{build}: no object files, so that nothing is known of who calls whom")
    faults += check_calls(root, build)
    for fault in faults:
        print(fault)
    if faults:
        sys.exit(f"{len(faults)} faults")
    if not with_format:
        print("clang-format is not installed: formatting not checked")
        sys.exit(77)
    print("the plan holds")


if __name__ == "__main__":
    main()
