"""How figures look: titles, labels, limits, scales, published lines, units of SI tables, packings in three dimensions,
movies; no ink leaves the page; and what is refused, with nothing written.

usage: test_plot_look.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import svg_ink
from common import expect, faults, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
N200 = SOURCE / "packings" / "reference" / "packing_N200_p1e-4.txt"
MINUS = "\u2212"


def run(*arguments):
    return subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, timeout=1200,
                          stdin=subprocess.DEVNULL)


def drawn(scratch, *arguments):
    """The texts of a figure that must succeed silently and keep its ink on the page."""
    path = scratch / "figure.svg"
    result = run("plot", *arguments, "-o", path)
    expect(result.returncode == 0 and not result.stdout and not result.stderr, f"{arguments}: {result}")
    if not path.exists():
        return []
    beyond = svg_ink.outside(path)
    expect(not beyond, f"{arguments}: ink outside the page: {beyond[:3]}")
    expect(svg_ink.ink(path), f"{arguments}: nothing drawn")
    words = svg_ink.texts(path)
    path.unlink()
    return words


def has(words, *wanted):
    expect(set(wanted) <= set(words), f"no {set(wanted) - set(words)} in {words}")


def refused(scratch, status, reason, *arguments):
    before = set(scratch.iterdir())
    result = run("plot", *arguments, "-o", scratch / "no.svg")
    line = result.stderr.split("\n")[0]
    expect(result.returncode == status and names_all(line, reason) and line.startswith("sonopack"),
           f"{arguments}: {result.returncode} {line!r}, expected {status} and {reason!r}")
    expect(set(scratch.iterdir()) == before, f"{arguments}: files are left")


def speeds(path, friction=0.5, dimension=2, units="p [E*] c_tof [sqrt(E* / rho)]", scale=1):
    head = f"# dimension = {dimension}, friction = {friction}, width = 24\n" if dimension else ""
    rows = "".join(f"{10.0 ** -k}\t{scale * 0.26 * 10 ** ((4 - k) / 6) * (1 - friction / 5)}\t{0.01 * scale}\n"
                   for k in (3, 4, 5))
    path.write_text(f"{head}# units: {units}\np\tc_tof\tc_tof_err\n{rows}")
    return path


def check_the_checker(scratch):
    """Ink beyond the page is found: of a line, of a moved glyph, not of what a clip hides."""
    head = ('<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 100 50">'
            '<defs><symbol id="glyph0-1"><path d="M 0 0 L 5 -5"/></symbol>'
            '<clipPath id="clip1"><path d="M 10 10 L 90 10 L 90 40 L 10 40 Z"/></clipPath></defs>')
    for body, count in (('<path d="M 1 1 L 99 49"/>', 0), ('<path d="M 1 1 L 120 49"/>', 1),
                        ('<path d="M 1 1 L 9 9" transform="matrix(1,0,0,1,95,0)"/>', 1),
                        ('<use xlink:href="#glyph0-1" x="97" y="20"/>', 1), ('<use xlink:href="#glyph0-1" x="50" y="20"/>', 0),
                        ('<g clip-path="url(#clip1)"><path d="M 20 20 L 120 20"/></g>', 0)):
        path = scratch / "checked.svg"
        path.write_text(head + body + "</svg>")
        expect(len(svg_ink.outside(path)) == count, f"{body}: {svg_ink.outside(path)}, expected {count}")


def check_speeds(scratch):
    rough, smooth = speeds(scratch / "rough.tsv", 0.5), speeds(scratch / "smooth.tsv", 0)
    published = "p^1/6, Somfai et al."
    has(drawn(scratch, "ctof", rough), published, "p  [E*]", "c  [(E*/\u03c1)^1/2]")
    words = drawn(scratch, "ctof", rough, smooth)
    for name in ("\u03bc = 0.5", "\u03bc = 0"):
        expect(any(word.startswith(name + ": c_tof ~ p^") for word in words), f"two frictions: {words}")
    words = drawn(scratch, "ctof", rough, smooth, "--label", "rough <1>", "--label", "smooth_2", "--title", "Sound & fury")
    has(words, "Sound & fury")
    for name in ("rough <1>", "smooth_2"):
        expect(any(word.startswith(name + ": ") for word in words), f"labels: {words}")
    long = drawn(scratch, "ctof", rough, "--title", "a title that is wider than the figure " * 5)
    expect(long[0].startswith("a title that") and "\u2026" in long[0], f"a long title: {long[:1]}")
    # what the paper measured in two dimensions is not drawn over anything else, unless it is asked for
    solid, old = speeds(scratch / "solid.tsv", 0.5, 3), speeds(scratch / "old.tsv", 0.5, 0)
    for path in (solid, old):
        expect(published not in drawn(scratch, "ctof", path), f"{path.name}: the published line")
        has(drawn(scratch, "ctof", path, "--published"), published)
    expect(published not in drawn(scratch, "ctof", rough, solid), "a figure of two and three dimensions")
    expect(published not in drawn(scratch, "ctof", rough, "--no-published"), "--no-published")
    refused(scratch, 2, "--published --no-published", "ctof", rough, "--published", "--no-published")
    # units are those of the table, and published lines are in ours
    si = speeds(scratch / "si.tsv", 0.5, 2, "p [kPa] c_tof [m/s] c_tof_err [m/s]", 1000)
    words = drawn(scratch, "ctof", si)
    has(words, "p  [kPa]", "c  [m/s]")
    expect(published not in words, "the published line in other units")
    refused(scratch, 2, "--published kPa", "ctof", si, "--published")
    refused(scratch, 1, "p kPa E*", "ctof", rough, si)


def check_axes(scratch):
    rough = speeds(scratch / "rough.tsv")
    words = drawn(scratch, "ctof", rough, "--x", "1e-6:1e-2")
    has(words, f"10^{MINUS}6", f"10^{MINUS}2")
    words = drawn(scratch, "ctof", rough, "--linear", "--y", ":0.5")
    expect("0.50" in words and f"10^{MINUS}4" not in words, f"linear: {words}")
    words = drawn(scratch, "ctof", rough, "--linear", "--log", "x")
    expect(f"10^{MINUS}4" in words and "0.30" in words, f"one axis linear: {words}")
    pulse = scratch / "pulse.tsv"
    pulse.write_text("t\tF\n" + "".join(f"{t}\t{t * t * (30 - t) + 1}\n" for t in range(40)))
    plain = drawn(scratch, "signal", pulse)
    zoomed = drawn(scratch, "signal", pulse, "--x", "0:20")
    expect("30" in plain and "30" not in zoomed and "20" in zoomed, f"limits: {zoomed}")
    has(drawn(scratch, "signal", pulse, "--x", ":25", "--log", "y"), "10^3")
    # a negative number has no logarithm; zeros lie below the frame
    refused(scratch, 2, "--log y", "signal", pulse, "--log", "y")
    for option, value in (("--x", "3:1"), ("--x", "2:2"), ("--y", ":"), ("--y", "5"), ("--x", "a:b"), ("--y", "nan:1"),                          ("--log", "z")):
        refused(scratch, 2, f"{option} {value.split(':')[0] if option != '--log' else value}" if value[0] != ":" else option,
                "ctof", rough, option, value)
    refused(scratch, 2, "--x -1", "ctof", rough, "--x=-1:1")
    refused(scratch, 2, "--y 0", "ctof", rough, "--y", "0:1")
    for kind in ("network", "mode", "angles"):
        refused(scratch, 2, f"--x {kind}", kind, N200, "--x", "0:1")
    refused(scratch, 2, "--published signal", "signal", pulse, "--published")
    refused(scratch, 2, "--label network", "network", N200, "--label", "x")
    refused(scratch, 2, "--label b 2 1", "ctof", rough, "--label", "a", "--label", "b")
    refused(scratch, 2, "--label a 1 2", "ctof", rough, rough, "--label", "a")


def check_mismatches(scratch):
    modes, dos = scratch / "modes.tsv", scratch / "dos.tsv"
    modes.write_text("n\tomega\tab\n" + "".join(f"{k}\t{0.1 * k}\t{0.01 * k}\n" for k in range(12)))
    dos.write_text("# spectrum = dos\n# norm = grain\nomega\tsmooth\n0\t1\n1\t2\n")
    one = scratch / "one.tsv"
    one.write_text(dos.read_text().replace("grain", "one"))
    refused(scratch, 1, "dos modes", "spectrum", dos, modes)
    refused(scratch, 1, "norm one grain", "spectrum", dos, one)
    refused(scratch, 1, "p", "ctof", speeds(scratch / "rough.tsv"), dos)
    refused(scratch, 1, "table 2 omega", "modes", modes, speeds(scratch / "rough.tsv"))


def check_spectra(scratch):
    modes = scratch / "modes.tsv"
    rows = "".join(f"{k}\t{0.1 * k}\t{(-1) ** k * 0.01 * k}\n" for k in range(12))
    modes.write_text("# zero_below = 1e-9\n# complete = 0:1.2\n# carrying = 11\n"
                     "# units: omega [rad/us] ab [N]\nn\tomega\tab\n" + rows)
    has(drawn(scratch, "spectrum", modes), "11 modes in bins", "\u03c9  [rad/\u00b5s]", "g(\u03c9)  [1/(rad/\u00b5s)/grain]")
    has(drawn(scratch, "modes", modes), "n", "\u03c9_n^2  [(rad/\u00b5s)^2]", "a_n b_n  [N]")
    has(drawn(scratch, "modes", modes, modes, "--label", "this", "--label", "that"), "this", "that")
    part = scratch / "part.tsv"
    part.write_text("# spectrum = participation\nomega\tparticipation\tsd\tmin\tmax\n0.5\t0.1\t0.2\t0.02\t0.6\n"
                    "1\t0.3\t0.1\t0.1\t0.5\n")
    words = drawn(scratch, "spectrum", part)
    expect(not any(word.startswith(MINUS) for word in words), f"a participation below 0: {words}")
    harmonic = scratch / "harmonic.tsv"
    harmonic.write_text("# spectrum = harmonic\nomega\tmagnitude\n" +
                        "".join(f"{k}\t{10.0 ** (-2 * k)}\n" for k in range(1, 16)))
    has(drawn(scratch, "spectrum", harmonic), f"10^{MINUS}30")  # thirty decades
    dos = scratch / "dos.tsv"
    dos.write_text("# spectrum = dos\n# norm = grain\nomega\tlow\thigh\tdensity\tsmooth\n.5\t0\t1\t3\t2\n1.5\t1\t2\t1\t2\n")
    has(drawn(scratch, "spectrum", dos), "modes in bins", "smoothed", "g(\u03c9)  [d (\u03c1/E*)^1/2/grain]")


def check_distances(scratch):
    chain = scratch / "chain.tsv"
    result = run("chain", "front", "--grains", "10,20,40", "-o", chain)
    expect(result.returncode == 0, result.stderr)
    words = drawn(scratch, "fronts", chain)
    has(words, "length of the chain  [grains]", "t  [\u2113/c]")
    expect(any(word.startswith("t_10,  v = 1") and word.endswith(" c") for word in words), f"speeds: {words}")
    fronts = scratch / "fronts.tsv"
    fronts.write_text("# units: distance [mm] t10 [us]\ndistance\tt10\n5\t20\n10\t40\n")
    has(drawn(scratch, "fronts", fronts), "distance  [mm]", "t  [\u00b5s]", "t_10,  c = 0.25", "c  [mm/\u00b5s]")
    refused(scratch, 1, "chains packings", "fronts", fronts, chain)
    planes = scratch / "planes.tsv"
    result = run("signal", N200, "--planes", 12, "--until", 60, "--points", 100, "-o", planes)
    expect(result.returncode == 0, result.stderr)
    words = drawn(scratch, "signal", planes)
    expect(any(word.endswith(" E* d^2") for word in words) and "distance  [d]" in words, f"scale of a section: {words}")


def check_packings(scratch):
    solid = scratch / "solid.h5"
    made = run("pack", "--set", "packing.dimension=3", "--set", "packing.grains=200", "--set", "packing.width=5",
               "--set", "packing.pressure=1e-3", "-o", solid)
    expect(made.returncode == 0, made.stderr)
    for kind in ("network", "stiffness", "snapshot", "mode"):
        words = drawn(scratch, kind, solid)
        has(words, "x", "y", "z", "grains at half their size, far ones pale")
        expect(any("rattler" in word for word in words), f"{kind}: no rattlers in {words}")
        expect(words.count("x") == 2 and words.count("z") == 2, f"{kind}: not three views: {words}")
        drawn(scratch, kind, N200)
    has(drawn(scratch, "forces", solid), "normal force")
    words = drawn(scratch, "angles", solid)
    has(words, "angle above the horizontal", "0\u00b0", "90\u00b0", "density (isotropic: 1)")
    expect("120\u00b0" not in words, f"angles above a wall beyond 90 degrees: {words}")
    has(drawn(scratch, "angles", N200), "120\u00b0", "330\u00b0")
    drawn(scratch, "signal", solid, "--title", "three dimensions")
    planes = scratch / "solid-planes.tsv"
    made = run("signal", solid, "--detector", "plane:1", "--detector", "plane:2", "--until", 20, "-o", planes)
    expect(made.returncode == 0, made.stderr)
    has(drawn(scratch, "signal", planes), "z = 1 d", "z = 2 d")


def png_size(path):
    data = path.read_bytes()
    expect(data[:8] == b"\x89PNG\r\n\x1a\n", f"{path.name}: no PNG")
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


def check_movies(scratch):
    folder = scratch / "movie"
    folder.mkdir()
    result = run("plot", "snapshot", N200, "--frames", 3, "--from", 4, "--to", 20, "-o", folder / "wave.png")
    expect(result.returncode == 0 and not result.stderr, f"frames: {result}")
    names = sorted(path.name for path in folder.iterdir())
    expect(names == ["wave-0001.png", "wave-0002.png", "wave-0003.png"], f"frames: {names}")
    expect(len({png_size(folder / name) for name in names}) == 1, "frames of different size")
    result = run("plot", "mode", N200, "--frames", 4, "-o", folder / "m%02d.svg")
    expect(result.returncode == 0, f"frames: {result}")
    for k in range(4):
        has(svg_ink.texts(folder / f"m{k + 1:02d}.svg")[:1][0].split(",  "), f"t = {k / 4:.2f} T")
        expect(not svg_ink.outside(folder / f"m{k + 1:02d}.svg"), f"frame {k}: ink outside")
    # one scale: the key of all frames of a wave is the same
    run("plot", "snapshot", N200, "--frames", 3, "--from", 4, "--to", 20, "-o", folder / "w%d.svg")
    scales = {tuple(word for word in svg_ink.texts(folder / f"w{k}.svg") if word.startswith("= ")) for k in (1, 2, 3)}
    expect(len(scales) == 1 and scales.pop(), f"scales of frames: {scales}")
    for path in list(folder.iterdir()):
        path.unlink()
    # what exists is not replaced, and then no frame is written
    (folder / "a-0002.png").write_bytes(b"x")
    result = run("plot", "mode", N200, "--frames", 3, "-o", folder / "a.png")
    expect(result.returncode == 2 and [path.name for path in folder.iterdir()] == ["a-0002.png"], f"{result}")
    for status, reason, arguments in ((2, "--frames 1", ["--frames", 1]), (2, "--from --frames", ["--from", 3]),
                                      (2, "--from 5 --to 3", ["--frames", 3, "--from", 5, "--to", 3]),
                                      (2, "--frames --time", ["--frames", 3, "--time", 3])):
        refused(scratch, status, reason, "snapshot", N200, *arguments)
    result = run("plot", "mode", N200, "--frames", 3, "-o", folder / "a%s.png")
    expect(result.returncode == 2 and names_all(result.stderr.split("\n")[0], "-o"), f"{result}")


def check_notes(scratch):
    """Long notes below a diagram stand on the page, a line for each panel."""
    bifurcation, lyapunov = scratch / "b.tsv", scratch / "l.tsv"
    warning = "# warning: ordering (1) violated at {} of 123456 points\n"
    head = "# parameter = period\n"
    bifurcation.write_text(head + warning.format(123455) + "# units: parameter [s] y1 [cm]\nparameter\ttap\ty1\n1\t1\t1\n2\t1\t2\n")
    lyapunov.write_text(head + warning.format(7) + "# units: parameter [s]\nparameter\tlambda\terror\n1\t1\t.1\n2\t2\t.1\n")
    has(drawn(scratch, "column", bifurcation, lyapunov), "(a): order (1) violated at 123455 of 123456 points",
        "(b): order (1) violated at 7 of 123456 points")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-look-") as folder:
        scratch = pathlib.Path(folder)
        for check in (check_the_checker, check_speeds, check_axes, check_mismatches, check_spectra, check_distances, check_packings,
                      check_movies, check_notes):
            check(scratch)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


sys.exit(main())
