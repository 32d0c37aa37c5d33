"""Command lines that make no sense, or only just: every option that a command's --help lists, with values drawn from lists
of extremes. What tests of them share."""
import math
import os
import re
import resource
import signal
import subprocess

MEMORY = 4 << 30  # bytes of address space
NUMBERS = ("0 -0 1 2 3 -1 0.5 1e-9 5e-324 1e-300 1e9 1e6 1e300 1e400 nan inf -inf 0x10 1e 1. .5 + - e 100000 65536 2147483647 "
           "2147483648 4294967297 9223372036854775807 9223372036854775808 -9223372036854775808 1e15").split()
MILD = "1 2 3 5 7 10 20 50 100 1000 1e3 10000 1e5 1e6 1e7 1e8 0.1 0.2 0.3 0.5 0.9 1e-2 1e-3 1e-6 1e-10 1e-12".split()
LISTS = ("1,2 2,1 1,1 0,0 1,2,3 1e300,1 , ,, 1, ,1 : :: 1: :1 1:2 2:1 1:1 0:0 inf:1 1:inf -1:1 1:2:3 1:2:1 2:1:3 0.1:0.5:1000 "
         "1e-300:1e300:10 0.1:0.3:1000000000 0.1:0.2:1e6 0.5:0.5001:2 1-3 3-1 0:1e9 1:1000000:1.0000001 1:2:0 1:2:-1 1:2:nan").split()
PLACES = ("top bottom plane:3 plane:0 plane:-1 plane:1e300 plane:nan part:0:3 part:3:0 part:0:1e300 grain:0 grain:199 grain:200 "
          "grain:-1 grain:1e9 grain: plane: part:: plane:3:shear grain:5:normal top:shear").split()
PULSES = ("delta gauss:0 gauss:1 gauss:1e300 gauss:1e-300 ricker:0 ricker:1e300 ricker:0.2 sine:0.2:1000000 sine:1e-9:1 sine:0:0 "
          "square:0 square:1e9 file:/dev/null file:/dev/zero file:. file:signal.tsv file:").split()
DASHPOTS = "0 1e-300 1 2 1e300 gamma:0 gamma:1e300 gamma:1:1e300 gamma: mass:1 mass:0:1 mass:-1 gamma:1e-300:0".split()
OTHERS = ["", " ", "x", "é", "\n", "a\nb", "\x1b[31m", "--", "%s%n%d", "$(id)", "`id`", "../..", "/", ".", "x" * 300, "x" * 5000,
          "=1+1", "'", '"', "\\", "\xff\xfe", "0" * 400, "1" * 400, "*", "#", "all", "none", "auto"]
QUANTITIES = ["1 us", "1e300 us", "100 kPa", "1 kPa", "1 km", "5 mm", "nan us", "us", "1 parsec", "1e-300 Hz", "1 kHz"]
FILES = ["P.h5", "Q.txt", "C.h5", "signal.tsv", "modes.tsv", "store", "store/none", "none.h5", "/dev/null", ".", "", "scene.cfg",
         "kubo.tsv", "loud.tsv", "statics.tsv", "x" * 255, "x" * 256, "y/" * 2040, "-", "a\nb.tsv", "page.html", "u.tsv"]
KEYS = {"E=..,nu=..,rho=..,d=..": ["E=70e9,nu=0.22,rho=2500,d=1e-3", "E=1e300,nu=0,rho=1,d=1", "E=1,nu=0.5,rho=1e-300,d=1e300",
                                    "E=,nu=", "E=1", "E=1,E=2,nu=0,rho=1,d=1", "nu=0.6,E=1,rho=1,d=1", ",", ""]}
# of these the values are files or programs, and no others are tried
FILE_OPTIONS = {"output", "packing", "vectors", "table", "signal", "store", "before", "after", "collect", "prepare", "contacts",
                "contact-table", "grains-table", "grain-table", "walls"}
NEVER = {"lammps", "engine", "ranks", "help", "usage", "version"}


def options_of(text):
    """[(name, argument or None)] of a help text."""
    found = re.findall(r"^ +(?:-\w, +)?((?:--[\w-]+(?:=\S+)?(?:, )?)+)", text, re.M)
    pairs = [word.lstrip("-").split("=", 1) for words in found for word in words.split(", ") if word]
    return [(p[0], p[1] if len(p) > 1 else None) for p in pairs if p[0] not in NEVER]


def kinds_of(text):
    """The words KIND of a help text."""
    if not re.search(r"^Usage: .* KIND\b", text, re.M):
        return []
    listed = re.findall(r"^  ([a-z]+)  +\S", text, re.M)
    return listed


def within(draw, low, high, whole):
    """A number that a range allows: an end of it, or anything between, most of all small and large ones."""
    pick = draw.choice((low, high, None, None, None))
    if pick is None:
        pick = draw.choice((1, -1)) * 10 ** draw.uniform(-13, math.log10(max(abs(low), abs(high), 1)))
        pick = min(max(abs(pick) if low >= 0 else pick, low), high)
    return str(int(pick)) if whole else repr(float(pick))


def set_value(draw, keys):
    """KEY=VALUE of a scene, within the key's range or out of it."""
    key, low, high, whole = draw.choice(keys)
    if low is None or draw.random() < 0.2:
        return f"{key}={draw.choice(NUMBERS + OTHERS + ['()', '[1e-3, 1e-5]', '[1, 1]', 'true', 'piston', 'periodic'])}"
    return f"{key}={within(draw, low, high, whole)}"


def value(draw, option, keys):
    """A legal but extreme value of an option, or one that is not legal."""
    name, argument, span = option
    if name == "set":
        return set_value(draw, keys)
    if name in FILE_OPTIONS:
        return draw.choice(FILES)
    if draw.random() < 0.08:
        return draw.choice(OTHERS + FILES + NUMBERS + QUANTITIES)
    if span and draw.random() < 0.9:
        return within(draw, *span)
    pools = [MILD] * 4 + [NUMBERS] + [LISTS]
    if argument in KEYS:
        pools = [KEYS[argument]]
    elif "|" in argument and not re.search(r"[A-Z]", argument):
        pools = [argument.split("|")] * 9 + [OTHERS]
    elif re.search(r",|:|LIST", argument):
        pools = [LISTS] * 3 + [MILD]
    if name in ("from", "detector", "source"):
        pools += [PLACES] * 3
    if name == "pulse":
        pools = [PULSES] * 6 + [OTHERS]
    if name == "damping":
        pools = [DASHPOTS] * 6 + [NUMBERS]
    return draw.choice(draw.choice(pools))


SPAN = r"(-?[0-9.]+(?:e[+-]?[0-9]+)?) \.\. (-?[0-9.]+(?:e[+-]?[0-9]+)?)"


def span_of(command, words, name):
    """The range of a number that an option takes, as the command tells who exceeds it."""
    done = subprocess.run([command, *words, f"--{name}=1e999"], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    found = re.search(r"must be an? (number|integer) " + SPAN, done.stderr)
    return (float(found[2]), float(found[3]), found[1] == "integer") if found else None


def keys_of(command):
    """[(key, low, high, whole)] of scenes."""
    text = subprocess.run([command, "help", "scene"], capture_output=True, text=True).stdout
    found = re.findall(r"^([a-z_]+\.[a-z_]+) = .*\n(?:    .*\n)*?    must be (.*)$", text, re.M)
    spans = [(key, re.search(SPAN, says), "integer" in says) for key, says in found if "file" not in key]
    return [(key, float(s[1]), float(s[2]), whole) if s else (key, None, None, whole) for key, s, whole in spans]


def limit(seconds):
    """For preexec_fn: this processor time, then SIGXCPU; little memory, and files that do not fill the disk."""
    def apply():
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 29, 1 << 29))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
    return apply


def run(command, words, folder, seconds):
    """(exit status, stderr, processor time [s], largest memory [MB])."""
    with open(os.path.join(folder, "..", "out"), "wb") as out, open(os.path.join(folder, "..", "err"), "w+b") as err:
        process = subprocess.Popen([command, *words], cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                   preexec_fn=limit(seconds))
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        err.seek(0)
        text = err.read(1 << 20).decode(errors="replace")
    return process.returncode, text, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def judge(status, text):
    """What is wrong with how a command ended, or nothing."""
    if status == -signal.SIGXCPU or status == -signal.SIGKILL:
        return None if re.search(r"\d%|left|so far", text) else "no progress"
    if status not in (0, 1, 2):
        return f"exit status {status}"
    first = text.split("\n")[0]
    if status and not first.startswith("sonopack"):
        return f"no reason: {first[:100]!r}"
    if status and re.search(r"[\x00-\x08\x0b-\x1f\x7f]", text):
        return "a control character reaches the terminal"
    return None


def seeds(command, folder, source):
    """Small files of every kind to be read; the words that each command works with."""
    def make(*words):
        done = subprocess.run([command, *words], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, (words, done.stderr)
    make("pack", "--set", "packing.grains=200", "--set", "packing.width=10", "-o", "P.h5")
    make("pack", "--set", "packing.kind=chain", "--set", "packing.grains=12", "-o", "Q.txt")
    make("pack", "--set", "packing.cell=periodic", "--set", "packing.dimension=3", "--set", "packing.grains=200", "--set",
         "packing.friction=0", "-o", "C.h5")
    make("signal", "P.h5", "-o", "signal.tsv")
    make("modes", "P.h5", "-o", "modes.tsv")
    make("statics", "P.h5", "-o", "statics.tsv")
    make("spectrum", "dos", "P.h5", "-o", "dos.tsv")
    make("front", "P.h5", "-o", "front.tsv")
    make("chain", "front", "--grains", "10,20,40", "-o", "fronts.tsv")
    make("modes", "P.h5", "--vectors", "u.tsv", "--mode", "100", "-o", "m.tsv")
    with open(os.path.join(folder, "scene.cfg"), "w") as file:
        file.write('packing = { grains = [20, 30]; width = 6; };\nstudy = { samples = 2; want = ["ctof", "statics"]; };\n')
    make("study", "scene.cfg", "--store", "store")


WORKS = {"pack": [["scene.cfg", "-o", "new.h5", "--set", "packing.grains=30", "--set", "packing.width=6"]],
         "chain": [["front", "--grains", "10,20"], ["signal", "--grains", "20"], ["modes", "--grains", "20"], ["soliton"],
                   ["localisation", "--grains", "1000"]],
         "spectrum": [[kind, "P.h5"] for kind in "dos transmission dispersion harmonic participation continuum".split()],
         "front": [["P.h5"], ["signal.tsv"]],
         "coda": [["P.h5", "--grain", "7"], ["P.h5", "--trials", "2"], ["P.h5", "--before", "signal.tsv", "--after", "signal.tsv"]],
         "study": [["scene.cfg", "--store", "store"], ["scene.cfg", "--store", "store2"], ["--store", "store", "--verify"]],
         "table": [["ctof", "--store", "store"], ["statics", "--store", "store"]],
         "column": [["--set", "column.taps=1"]],
         "plot": [["signal", "signal.tsv", "-o", "f.svg"], ["mode", "P.h5", "-o", "f.png"], ["spectrum", "dos.tsv", "-o", "f.pdf"],
                  ["network", "P.h5", "-o", "f.svg"], ["snapshot", "P.h5", "-o", "f.png"], ["modes", "modes.tsv", "-o", "f.svg"],
                  ["scaling", "fronts.tsv", "-o", "f.svg"], ["ctof", "--store", "store", "-o", "f.svg"]],
         "view": [["P.h5", "-o", "v.html"], ["C.h5", "-o", "v.html"]],
         "convert": [["P.h5", "o.txt"], ["P.h5", "o.vtp"], ["Q.txt", "o.h5"], ["C.h5", "o.data"]],
         "reproduce": [["blackmore2011", "--only", "errata", "-o", "paper"]],
         "bench": [["signal", "--packing", "Q.txt", "--seconds", "0.01"]],
         "completion": [["bash"], ["zsh"]],
         "design": [["P.h5", "--goal", "delay", "--iterations", "1"], ["Q.txt", "--goal", "advance"], ["Q.txt", "--goal", "band:0.1:0.2"]],
         "uncertainty": [["P.h5", "--radius", "1e-6", "--samples", "10"], ["Q.txt", "--stiffness", "0.1"]]}


def case(draw, helps, keys):
    """A random command line."""
    command = draw.choice(list(helps))
    words = [command, *draw.choice(works_of(command))]
    groups = "network" if command not in ("pack", "study", "column") else "column" if command == "column" else "packing study signal"
    own = [key for key in keys if key[0].split(".")[0] in groups]
    for _ in range(draw.choice((1, 1, 2, 2, 3))):
        option = draw.choice(helps[command])
        words.append(f"--{option[0]}" if option[1] is None else f"--{option[0]}={value(draw, option, own)}")
    if command in ("pack", "study", "column") and draw.random() < 0.6:
        words.append(f"--set={set_value(draw, own)}")
    if draw.random() < 0.03:
        words.append(draw.choice(FILES + OTHERS))
    return [word.replace("\0", "") for word in words + ["--verbose"]]


def works_of(command):
    return WORKS.get(command, [["P.h5"], ["P.h5"], ["Q.txt"], ["C.h5"]])


def helps_of(command):
    """{command: [(option, argument, range of its number)]} from the program's own help."""
    names = re.findall(r"^  ([a-z]+) ", subprocess.run([command, "help"], capture_output=True, text=True).stdout, re.M)
    texts = {name: subprocess.run([command, "help", name], capture_output=True, text=True).stdout
             for name in names if name != "help"}
    return {name: [(o, a, span_of(command, [name], o) if a else None) for o, a in options_of(text)]
            for name, text in texts.items()}
