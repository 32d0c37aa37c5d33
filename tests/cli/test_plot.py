"""Figures of the command: every kind in every format, what they show, and refusals that leave nothing behind.

usage: test_plot.py COMMAND SOURCE_DIR
"""
import pathlib
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zlib

import numpy

from common import expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
CTOF = """# exponent = nan (it needs 3 pressures with c_tof)
# units: p [E*] c_tof [sqrt(E*/rho)]
p\tsamples\tc_tof\tc_tof_err\tc_peak\tc_zero\tc_l\tc_t
1e-4\t8\t0.266\t0.004\t0.2\t0.2\t0.189\t0.0905
1e-5\t8\t0.175\t0.003\t0.1\t0.1\t0.121\t0.0487
1e-6\t8\tnan\tnan\tnan\tnan\t0.0811\t0.0308
"""
# two grains side by side across the periodic edge, between both walls
PACKING = """# packing: two grains
N 2 Lx 4 Ly 0.998 p 1e-4 mu 0.5 nu 0 contacts 1 bottom 2 top 2 seed 1
0.4 0.499 0.5 0
3.401 0.499 0.5 0
0 1 -1 0 0.001 1.0540925533894598e-05 0
0 -1 0 -1 0.001 2.981423969999720e-05 0
1 -1 0 -1 0.001 2.981423969999720e-05 0
0 -2 0 1 0.001 2.981423969999720e-05 0
1 -2 0 1 0.001 2.981423969999720e-05 0
"""


def plot(*arguments):
    return subprocess.run([COMMAND, "plot", *map(str, arguments)], text=True, capture_output=True, timeout=1200,
                          stdin=subprocess.DEVNULL)


def drawn(scratch, name, *arguments, note=""):
    """Draws a figure that must succeed silently (but for a note), and gives its path."""
    path = scratch / name
    result = plot(*arguments, "-o", path)
    expect(result.returncode == 0, f"{arguments}: exit status {result.returncode}: {result.stderr}")
    expect(not result.stdout, f"{arguments}: something on stdout")
    expect(names_all(result.stderr, note) if note else not result.stderr, f"{arguments}: stderr {result.stderr!r}")
    return path


def refused(scratch, status, reason, *arguments):
    """A call that fails with one reason first, and changes nothing in the folder."""
    before = {path: path.stat().st_mtime_ns for path in scratch.iterdir()}
    result = plot(*arguments)
    line = result.stderr.split("\n")[0]
    expect(result.returncode == status, f"{arguments}: exit status {result.returncode}, expected {status}: {line}")
    expect(line.startswith("sonopack") and names_all(line, reason), f"{arguments}: {line!r} does not say {reason!r}")
    expect(not result.stdout, f"{arguments}: something on stdout")
    after = {path: path.stat().st_mtime_ns for path in scratch.iterdir()}
    expect(after == before, f"{arguments}: files changed: {set(after) ^ set(before)}")


def png(path):
    """Width, height and the rows' bytes of a PNG; every chunk's checksum is tried."""
    if not path.exists():
        return 0, 0, b""
    data = path.read_bytes()
    expect(data[:8] == b"\x89PNG\r\n\x1a\n", f"{path.name}: no PNG")
    position, chunks = 8, {}
    while position < len(data):
        length, = struct.unpack(">I", data[position:position + 4])
        kind, body = data[position + 4:position + 8], data[position + 8:position + 8 + length]
        check, = struct.unpack(">I", data[position + 8 + length:position + 12 + length])
        expect(check == zlib.crc32(kind + body), f"{path.name}: checksum of {kind}")
        chunks[kind] = chunks.get(kind, b"") + body
        position += 12 + length
    expect(b"IEND" in chunks, f"{path.name}: no end")
    width, height = struct.unpack(">II", chunks[b"IHDR"][:8])
    expect(chunks.get(b"pHYs") == struct.pack(">IIB", 11811, 11811, 1), f"{path.name}: resolution")
    return width, height, zlib.decompress(chunks[b"IDAT"])


def words(path):
    """The texts of an SVG figure, whose letters are outlines; none if it was not drawn."""
    if not path.exists():
        return []
    root = ElementTree.parse(path).getroot()
    expect(root.get("width", "").startswith("243.7"), f"{path.name}: width {root.get('width')}")
    return root.find("{http://www.w3.org/2000/svg}desc").text.split("\n")


def check_ctof(scratch):
    table = scratch / "table.tsv"
    table.write_text(CTOF)
    comma = scratch / "table.csv"
    comma.write_text("\r\n".join(CTOF.split("\n")[2:]).replace("\t", ",").replace("nan", ""))
    text = words(drawn(scratch, "ctof.svg", "ctof", table))
    for label in ("c_tof", "c_l", "c_t", "10^\u22124", "10^\u22126", "p  [E*]"):
        expect(label in text, f"ctof: no label {label!r} in {text}")
    expect(not any("~" in line for line in text), "ctof: an exponent from two points")
    same = drawn(scratch, "comma.svg", "ctof", comma)
    expect(same.read_bytes() == (scratch / "ctof.svg").read_bytes(), "ctof: CSV and TSV differ")
    width, height, _ = png(drawn(scratch, "ctof.png", "ctof", table))
    expect(width == 1016 and 600 < height < 1100, f"ctof: {width} x {height} pixels")
    pdf = drawn(scratch, "ctof.pdf", "ctof", table).read_bytes()
    expect(pdf.startswith(b"%PDF-") and pdf.rstrip().endswith(b"%%EOF"), "ctof: no PDF")
    # an existing figure is replaced only if that is said, and then by the same bytes
    old = (scratch / "ctof.svg").read_bytes()
    refused(scratch, 2, "exists already", "ctof", table, "-o", scratch / "ctof.svg")
    drawn(scratch, "ctof.svg", "ctof", table, "--force")
    expect((scratch / "ctof.svg").read_bytes() == old, "ctof: drawn again, other bytes")


def check_signals(scratch):
    t = numpy.linspace(0, 100, 501)
    pulse = numpy.exp(-0.5 * ((t - 40) / 5) ** 2) - 0.5 * numpy.exp(-0.5 * ((t - 55) / 5) ** 2)
    trace = scratch / "pulse_a.tsv"
    rows = "".join(f"{a:.17g}\t{3e-3 * b:.17g}\n" for a, b in zip(t, pulse))
    trace.write_text("t\tF\n" + rows)
    plain = scratch / "b<&>.txt"
    plain.write_text("".join(f"{a:.17g} {2e-3 * b:.17g} 7\n" for a, b in zip(t, pulse)))
    text = words(drawn(scratch, "signal.svg", "signal", trace, plain))
    for label in ("pulse_a", "b<&>", "t_10", "t_peak", "t_zero", "t", "F  [10^\u22123]"):
        expect(label in text, f"signal: no label {label!r} in {text}")
    # the units are the trace's own; a packing's are d/sqrt(E*/rho) and E* d^2
    volts, ours = scratch / "volts.tsv", scratch / "ours.tsv"
    volts.write_text("# units: t [ms] F [V]\nt\tF\n" + rows)
    ours.write_text("# units: t [d/sqrt(E* / rho)] F [E* d^2]\nt\tF\n" + rows)
    for name, label in (("volts", ["t  [ms]", "F  [10^\u22123 V]"]),
                        ("ours", ["t  [d (\u03c1/E*)^1/2]", "F_sig  [10^\u22123 E* d^2]"])):
        text = words(drawn(scratch, f"{name}.svg", "signal", scratch / f"{name}.tsv"))
        expect(set(label) <= set(text), f"signal: {label} not in {text}")
    for pair in ((volts, ours), (ours, volts), (trace, ours, volts)):  # a trace without units fits beside any
        refused(scratch, 1, "t in", "signal", *pair, "-o", scratch / "no.svg")
    png(drawn(scratch, "signal.png", "signal", trace))
    flat = scratch / "flat.tsv"
    flat.write_text("t\tF\n0\t0\n1\t0\n2\t0\n")
    text = words(drawn(scratch, "flat.svg", "signal", flat, note="flat.tsv"))
    expect("t_10" not in text, "signal: a mark without a front")
    packing = SOURCE / "packings" / "reference" / "packing_N200_p1e-4.txt"
    text = words(drawn(scratch, "made.svg", "signal", packing))
    expect("packing_N200_p1e-4" in text and "t_10" in text, f"signal of a packing: {text}")
    text = words(drawn(scratch, "short.svg", "signal", packing, "--set", "signal.until=40"))
    expect("100" not in text, f"signal.until: {text}")


def check_several(scratch):
    """Tables with F1, F2, ... are that many signals; other tables are none. Soft modes name their power of ten."""
    several, soft, harmonic = (scratch / f"{name}.tsv" for name in ("several", "soft", "harmonic"))
    t = numpy.linspace(0, 100, 201)
    pulse = numpy.exp(-0.5 * ((t - 40) / 5) ** 2) - 0.5 * numpy.exp(-0.5 * ((t - 55) / 5) ** 2)
    several.write_text("t\tF1\tF2\tF3\n" + "".join(f"{a}\t{b}\t{2 * b}\t{3 * b}\n" for a, b in zip(t, pulse)))
    text = words(drawn(scratch, "several.svg", "signal", several))
    expect({"F1", "F2", "F3", "t_10"} <= set(text), f"several signals: {text}")
    text = words(drawn(scratch, "files.svg", "signal", several, scratch / "pulse_a.tsv"))
    expect({"several F1", "several F3", "pulse_a"} <= set(text), f"several files: {text}")
    soft.write_text("n\tomega\n" + "".join(f"{k}\t{0.001 * k}\n" for k in range(30)))
    text = words(drawn(scratch, "soft.svg", "spectrum", soft))
    expect("\u03c9  [10^\u22122 (E*/\u03c1)^1/2/d]" in text, f"soft modes: {text}")
    si = scratch / "soft-si.tsv"
    si.write_text("# units: omega [rad/s]\n" + soft.read_text())
    text = words(drawn(scratch, "soft-si.svg", "spectrum", si))
    expect(any(word.startswith("g(") and word.endswith("s]") and "rad" not in word for word in text), f"density of modes in SI: {text}")
    refused(scratch, 1, "needs columns", "signal", soft, "-o", scratch / "no.svg")
    harmonic.write_text("# spectrum = harmonic\nomega\tmagnitude\talpha\talpha_err\n"
                        + "".join(f"{k / 10}\t{2.0 ** -k}\t{k * k / 50}\t0.01\n" for k in range(1, 8)))
    text = words(drawn(scratch, "alpha.svg", "spectrum", harmonic, "--column", "alpha"))
    expect("\u03b1  [1/d]" in text, f"attenuation: {text}")
    refused(scratch, 1, "no column speed", "spectrum", harmonic, "--column", "speed", "-o", scratch / "no.svg")
    refused(scratch, 1, "must be of `sonopack spectrum harmonic'", "spectrum", soft, "--column", "k", "-o",
            scratch / "no.svg")
    refused(scratch, 2, "alpha, k or speed", "spectrum", harmonic, "--column", "beta", "-o", scratch / "no.svg")
    refused(scratch, 2, "only plot spectrum", "signal", several, "--column", "k", "-o", scratch / "no.svg")


def check_packings(scratch):
    packing = scratch / "pair.txt"
    packing.write_text(PACKING)
    text = words(drawn(scratch, "network.svg", "network", packing))
    mean = (1.05409255e-5 + 4 * 2.98142397e-5) / 5
    expect(f"mean F_n = {mean * 1e5:.3g}\u00d710^\u22125 E*d^2" in text and "0 rattlers" in text, f"network: {text}")
    text = words(drawn(scratch, "stiffness.svg", "stiffness", packing))
    mean = (1e-3 ** 0.5 / 2 + 8 * (1e-3 / 2) ** 0.5) / 5
    expect(f"mean k_n = {mean:.3g} E*d" in text, f"stiffness: {text}, not {mean:.3g}")
    text = words(drawn(scratch, "threshold.svg", "network", packing, "--set", "network.threshold=0.25"))
    expect("0 rattlers" in text and "mean F_n = 2.98\u00d710^\u22125 E*d^2" in text, f"threshold: {text}")
    width, height, _ = png(drawn(scratch, "network.png", "network", packing))
    expect(width == 1016 and 250 < height < 450, f"network: {width} x {height} pixels")
    text = words(drawn(scratch, "large.svg", "network", SOURCE / "packings" / "reference" / "packing_N600_p1e-4.txt"))
    expect("39 rattlers" in text, f"network: {text}")


def check_store(scratch):
    scene = scratch / "study.cfg"
    scene.write_text("""packing = { kind = "chain"; dimension = 1; friction = 0.0; };
study = { samples = 1; want = ["ctof"]; sweep = ( { key = "packing.pressure"; values = [1e-5, 1e-4]; },
{ key = "packing.grains"; values = [8, 24]; } ); };
""")
    made = subprocess.run([COMMAND, "study", scene, "--store", scratch / "store", "-o", scratch / "study.tsv"],
                          text=True, capture_output=True, timeout=1200, stdin=subprocess.DEVNULL)
    expect(made.returncode == 0, f"study: {made.stderr}")
    text = words(drawn(scratch, "store.svg", "ctof", "--store", scratch / "store"))
    expect("c_tof" in text, f"store: {text}")
    refused(scratch, 2, "not both", "ctof", scratch / "study.tsv", "--store", scratch / "store", "-o",
            scratch / "x.svg")
    refused(scratch, 2, "--store", "signal", "--store", scratch / "store", "-o", scratch / "x.svg")


def check_refusals(scratch):
    table, packing = scratch / "table.tsv", scratch / "pair.txt"
    figure = scratch / "never.svg"
    refused(scratch, 2, "ctof, signal, network", "chart", table, "-o", figure)
    refused(scratch, 2, "no kind", "-o", figure)
    refused(scratch, 2, "no file", "ctof", "-o", figure)
    refused(scratch, 2, "no -o", "ctof", table)
    refused(scratch, 2, "13 files", "ctof", *[table] * 13, "-o", figure)
    refused(scratch, 2, ".svg, .png or .pdf", "ctof", table, "-o", scratch / "never.tsv")
    refused(scratch, 2, ".svg, .png or .pdf", "ctof", table, "-o", scratch / "never")
    refused(scratch, 2, "--format", "ctof", table, "--format", "csv", "-o", figure)
    refused(scratch, 2, "--set", "ctof", table, "--set", "packing.grains=3", "-o", figure)
    refused(scratch, 2, "packing.grains", "network", packing, "--set", "packing.grains=3", "-o", figure)
    refused(scratch, 1, "no/such", "ctof", table, "-o", scratch / "no" / "such" / "a.svg")
    refused(scratch, 1, "missing.tsv", "ctof", scratch / "missing.tsv", "-o", figure)
    refused(scratch, 1, "missing", "ctof", "--store", scratch / "missing", "-o", figure)
    refused(scratch, 1, "missing.tsv", "signal", scratch / "missing.tsv", "-o", figure)
    refused(scratch, 1, "pair.txt", "ctof", packing, "-o", figure)
    refused(scratch, 1, "table.tsv", "network", table, "-o", figure)
    for name, content, reason in (("negative.tsv", "p\tc_tof\n1e-4\t-1\n", "1 c_tof -1"),
                                  ("nans.tsv", "p\tc_tof\n1e-4\tnan\n", ""),
                                  ("header.tsv", "p\tc_tof\n", ""),
                                  ("words.tsv", "p\tc_tof\n1e-4\tfast\n", ""),
                                  ("other.tsv", "a\tb\n1\t2\n", "p"),
                                  ("empty.tsv", "", "empty.tsv"),
                                  ("empty.csv", "", "empty.csv"),
                                  ("words.csv", "p,c_tof\n1e-4,fast\n", "words.csv:2 c_tof"),
                                  ("ragged.csv", "p,c_tof\n1e-4\n", "ragged.csv:2"),
                                  ("long.csv", "p,c_tof\n1,2,3\n", "long.csv:2"),
                                  ("wide.csv", ",".join("abcdefgh" * 5), "p"),
                                  ("binary.csv", "\0\1\2", "binary.csv"),
                                  ("binary.tsv", "\0\1\2", "binary.tsv")):
        (scratch / name).write_text(content)
        refused(scratch, 1, reason, "ctof", scratch / name, "-o", figure)
    (scratch / "one.tsv").write_text("t\n1\n2\n")
    refused(scratch, 1, "t and F", "signal", scratch / "one.tsv", "-o", figure)
    (scratch / "cut.txt").write_text(PACKING[:200])
    refused(scratch, 1, "cut.txt", "network", scratch / "cut.txt", "-o", figure)
    refused(scratch, 1, "cut.txt", "signal", scratch / "cut.txt", "-o", figure)
    (scratch / "notes.svg").write_text("shopping list\n")
    refused(scratch, 2, "another kind", "ctof", table, "--force", "-o", scratch / "notes.svg")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-plot-") as folder:
        scratch = pathlib.Path(folder)
        for check in (check_ctof, check_signals, check_several, check_packings, check_store, check_refusals):
            check(scratch)
        left = [path.name for path in scratch.iterdir() if path.name.startswith(".") or path.name.endswith(".tmp")]
        expect(not left, f"temporary files are left: {left}")
    for fault in faults:
        print(fault)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
