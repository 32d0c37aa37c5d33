"""Tables in SI: every number is that of the table in our own units times the factor of its unit, and no number with a
dimension is left behind. The factors are computed here once more.

usage: test_units.py COMMAND SOURCE_DIR
"""
import math
import pathlib
import re

from command import SOURCE, Table, main, run, table, tables

E, NU, RHO, D = 70e9, 0.22, 2500.0, 1e-3
MATERIAL = "E=70e9,nu=0.22,rho=2500,d=1e-3"
GROUP = "material = { E = 70e9; nu = 0.22; rho = 2500; d = 1e-3; };\n"
MODULUS = E / (1 - NU * NU)
SPEED = math.sqrt(MODULUS / RHO)
TIME = D / SPEED
MASS = RHO * D**3
# our units: unit in SI, and its factor in m, kg and s over that of the SI unit
FACTORS = {"d": ("mm", D * 1e3), "1/d": ("1/mm", 1e-3 / D), "E*": ("kPa", MODULUS / 1e3),
           "E* d^2": ("N", MODULUS * D**2), "E* d": ("N/m", MODULUS * D), "rho d^3": ("mg", MASS * 1e6), "sqrt(E* / rho)": ("m/s", SPEED), "d/sqrt(E* / rho)": ("us", TIME * 1e6),
           "sqrt(E* / rho)/d": ("rad/s", 1 / TIME), "E* / (rho d)": ("m/s^2", MODULUS / RHO / D),
           "E* / (rho d^2)": ("rad^2/s^2", MODULUS / RHO / D**2), "modes d/sqrt(E* / rho)": ("modes us", TIME * 1e6),
           "E* d^3/sqrt(E* / rho)": ("N us", MODULUS * D**2 * TIME * 1e6), "E* d^2/sqrt(E* / rho)": ("N s/m", MODULUS * D**2 / SPEED),
           "1/sqrt(rho d^3)": ("1/sqrt(mg)", (MASS * 1e6) ** -0.5),
           "d sqrt(E* / rho)": ("m^2/s", D * SPEED), "E* d^3": ("N mm", MODULUS * D**3 * 1e3),
           "1/(E* d)": ("mm/N", 1e3 / (MODULUS * D)), "1/(E* d^2)": ("1/N", 1 / (MODULUS * D**2)),
           "1/sqrt(rho d^5)": ("1/(sqrt(mg) mm)", (MASS * 1e6) ** -0.5 / (D * 1e3)),
           "d sqrt(rho d^3)": ("mm sqrt(mg)", D * 1e3 * (MASS * 1e6) ** 0.5),
           "E* d/sqrt(rho d^3)": ("N/(m sqrt(mg))", MODULUS * D * (MASS * 1e6) ** -0.5)}
SI = {si: factor for si, factor in FACTORS.values()}
# columns and comments of numbers that have no dimension, and of texts
PLAIN = re.compile(r"""file|contacts?|opens|slides|i|j|r[xyz]|fn|ft|probe|reason|verdict|branch|polarization|ok|failed|name|seed|dimension|grains?|samples|left_out|modes|steps|
    n|n1|n2|made|lost|sliding|rattlers|negative|flutter|zero|z_star|friction|strain|part|participation|share|min|max|sd|misfit|
    overlap|ratio|alpha|alpha_err|alpha_peak|alpha_peak_err|gamma|gamma_err|speed_over_c_l|k_path(_err)?|plane|below(_err)?|(pulse_)?(along|across|rotation|normal|tangential)(_err)?|C\d\d_((sine|lines)\d_)?ratio(_\w+)?|
    (Phi2|Phi3s?|zs|f0|N_over_p|Z2|Z3|F2S?|s1_over_s2|s[13]2_over_s2|mobilised)(_(sd|err|low|high))?|
    force|torque|walls|law|geometry|coulomb|missing|residual|Q(_err)?|
    (speed|peak|width)_ratio(_err)?|amplitude|overpressure(_err)?|packings|carrying|slid|opened|closed|kinetic|normal|tangential|
    rubbed|released|balance|step|factor|at_limit|energy(_err)?|predicted|found|rank|probability|change(_err)?|
    F[0-3](_err)?|beta(_delta)?(_err)?|beta_field|ratio_err""".replace("\n    ", ""))
NUMBER = r"[-+]?(?:\d+(?:\.\d+)?(?:e[-+]?\d+)?|inf|nan)"
PLAIN_COMMENTS = [re.compile(pattern) for pattern in (
    r"(file|load|method|source|quantity|axis|detector|solver|spectrum|norm|direction|motion|packing|verdict|error_kind|material|prestress|sliding_free|"
    r"packing\.(sizes|kind|protocol|compression)|pulse|measured|goal|vary|total|fits) = .*",
    rf"(force|stiffness|calibration|false|missing|seed|candidates|contacts_ratio(_err)?|effective|factor_(low|high)|\w+_ratio|pairs|times|noise|change|grain|found(_err)?|stretch(_err)?) = {NUMBER}",
    r"(grains|carrying|n|zero_modes|rattler_modes|free_spins|rigid_motions|mechanisms|factors|solves|on_edge|degrees_of_freedom|products|"
    r"modes|moments|vectors|planes|dof|packings|dimension|samples|failed|mode|load_error|tolerance|residual|orthogonality|damping|"
    rf"amplitude|factor|threshold|homogeneity|half_share|vector_error|wall|Phi3s|mean_\w+|gamma_limit|alpha_limit|exponent(_err)?|packing\.friction|"
    rf"packing\.poisson|network\.threshold) = {NUMBER}",
    r"exponent = nan \(.*", r"(missing|loose|lacking) = \d+ samples .*", r"without_\w+ = \d+ \(.*", r"rattlers = \d+, which .*",
    r"sonopack [\d.]+", r"exponents? (are local|and its error).*", r"c_tof = \(<H2> .*", r"_(err|low|ratio|low, _high): .*",
    r"_low, _high: .*", r"(arithmetic )?means .*", r"fronts (from|of) .*", r"errors: 1e-11 of a time; .*", r"airy: .*",
    r"chain of equal balls.*", r"rms: .*", r"share: .*", r"nan: .*", r"u = M\^\(-1/2\) e .*", r"displacements after .*",
    r"mechanisms are not .*", r"zero modes of the network .*", r"\d+ of the motions .*", r"no row: .*",
    r"(left out|failed): .*")]
PACKING = "packing = { protocol = \"quick\"; grains = 90; width = \"8 mm\"; pressure = \"7356.906306306306 kPa\"; seed = 3; };\n"
STUDY = ("packing = { protocol = \"quick\"; width = \"8 mm\"; pressure = [\"7.5 MPa\", \"75 MPa\"]; };\n"
         "signal = { until = \"11 us\"; points = 61; planes = [\"3 mm\", \"5 mm\"]; };\n"
         "study = { samples = 3; want = [\"ctof\", \"statics\", \"moduli\", \"scaling\", \"planes\", \"probes\", \"signal\","
         " \"spectrum\"]; sweep = ( { key = \"packing.height\"; values = [\"8 mm\", \"14 mm\"]; } ); };\n")


def close(a, b, factor, relative):
    if a in ("nan", "inf", "-inf"):
        return a == b
    return abs(float(b) - float(a) * factor) <= relative * abs(float(a) * factor)


def significant(number):
    return len(re.sub(r"e.*|[-+.]", "", number).lstrip("0"))


def compare_comment(own, si):
    """Numbers with a unit behind them are those before times the factor; all else is the same."""
    unit = "|".join(sorted(map(re.escape, SI), key=len, reverse=True))
    found = list(re.finditer(rf"({NUMBER}) ?({unit})(?![\w/^*])", si))
    if own == si:
        assert any(p.fullmatch(own) for p in PLAIN_COMMENTS), f"nobody knows whether this has a dimension: {own}"
        return 0
    pattern, at = "", 0
    for match in found:
        pattern += re.escape(si[at:match.start()]) + f"({NUMBER}|\\[[^]]*\\])"
        at = match.end()
    before = re.fullmatch(pattern + re.escape(si[at:]), own)
    assert before, f"more than numbers differ: {own!r}, {si!r}"
    for number, match in zip(before.groups(), found):
        assert close(number, match[1], SI[match[2]], 1e-5 if significant(number) <= 6 else 4e-15), f"{own!r}, {si!r}"
    return len(found)


def compare(own, si):
    assert own.names == si.names and len(own.rows) == len(si.rows), "columns or rows differ"
    converted = 0
    for c, name in enumerate(own.names):
        unit = own.units.get(name)
        if unit not in FACTORS:
            assert unit or PLAIN.fullmatch(name), f"column {name} has no unit, and is not known to be without a dimension"
            assert unit in (None, "%", "s", "rad", "modes/grain", "1"), f"column {name}: unit {unit} is not converted"
            assert name == "seconds" or [row[c] for row in own.rows] == [row[c] for row in si.rows], name
            continue
        name_si, factor = FACTORS[unit]
        assert si.units[name] == name_si, f"{name}: {si.units[name]}, not {name_si}"
        for before, after in zip(own.rows, si.rows):
            assert close(before[c], after[c], factor, 1e-15), f"{name}: {before[c]} -> {after[c]}, factor {factor}"
        converted += 1
    assert converted == 0 or any(line.startswith("material = E=") for line in si.comments), si.comments
    comments = [[line for line in t.comments if not line.startswith(("material = ", "units: "))] for t in (own, si)]
    assert len(comments[0]) == len(comments[1]), comments
    for pair in zip(*comments):
        compare_comment(*pair)
    return converted


def check_command(*arguments, units=True):
    own, si = (tables(run(*arguments, *more).stdout) for more in ((), ("--units=si",)))
    assert len(own) == len(si), arguments
    converted = 0
    for pair in zip(own, si):
        try:
            converted += compare(*pair)
        except AssertionError as error:
            raise AssertionError(f"sonopack {' '.join(map(str, arguments))}: {error}") from error
    assert (converted > 0) == units, f"{arguments}: {converted} columns were converted"


def commands():
    """Every command that prints numbers of packings."""
    for name, scene in (("P", PACKING), ("W", PACKING.replace("grains = 90", "grains = 320")), ("K", "packing = { kind = \"chain\"; grains = 30; pressure = \"1 MPa\"; };\n"),
                        ("S", "packing = { dimension = 3; protocol = \"quick\"; grains = 150; width = \"5 mm\"; "
                              "pressure = \"10 MPa\"; friction = 0.3; };\n")):
        pathlib.Path(f"{name}.cfg").write_text(GROUP + scene)
        run("pack", f"{name}.cfg", "-o", f"{name}.h5", "-q")
    pathlib.Path("pulse.txt").write_text("0 0\n1 1\n4 0\n")
    for line in (
            "sensitivity P.h5", "sensitivity S.h5 --of peak --by mass,radius,position",
            "sensitivity P.h5 --of F --at 60 --by pressure", "sensitivity P.h5 --of C22", "sensitivity P.h5 --of omega:100",
            "statics P.h5 S.h5", "moduli P.h5", "moduli S.h5", "moduli P.h5 --probe sine:1 --probe lines:1", "moduli P.h5 --strain 1e-6",
            "moduli P.h5 --probe local:3", "respond P.h5 --push 30:x --contacts",
            "modes P.h5", "modes P.h5 --band 0.1:0.2", "modes S.h5 --lowest 3", "modes P.h5 --damping 0.1 ", "modes P.h5 --damping gamma:0.02:0.01", "signal P.h5 --damping mass:0.1 --until 60 --points 30",
            "modes P.h5 --prestress", "respond P.h5 --push 30:y", "respond P.h5 --strain yy", "respond P.h5 --swell 30 --contacts",
            "modes P.h5 --stability --prestress", "modes P.h5 --frequencies-only", "signal P.h5", "signal S.h5 --planes 2",
            "signal P.h5 --detector part:0:4 --detector grain:5:shear --from part:1:5 --until 60", "signal K.h5 --points 50",
            "signal P.h5 --pulse gauss:2 --until 60 --points 30", "signal P.h5 --pulse ricker:0.5 --until 60 --points 30",
            "signal P.h5 --pulse sine:0.2:3 --until 60 --points 30", "signal P.h5 --pulse file:pulse.txt --until 60 --points 30",
            "signal P.h5 --method verlet --step 0.05 --until 60 --points 30", "signal P.h5 --damping 0.1 --until 60 --points 30",
            "signal P.h5 --method dynamics --amplitude 0.01 --until 20 --points 9", "front P.h5 K.h5", "spectrum dos P.h5",
            "signal P.h5 --method sparse --modes 30 --until 60 --points 30",
            "spectrum transmission P.h5", "spectrum participation P.h5", "spectrum continuum P.h5 --lowest 3",
            "spectrum dispersion P.h5 --waves 2", "spectrum dispersion P.h5 --direction up --waves 2", "spectrum harmonic P.h5 --damping 0.1 --at 0.1:0.3:3",
            "spectrum dos P.h5 --method kpm", "wave W.h5", "amplitude P.h5 K.h5 --amplitudes 0.01,0.3",
            "amplitude P.h5 --amplitudes 0.1 --mean", "amplitude K.h5 --amplitudes 0.1 --planes 2",
            "amplitude K.h5 --amplitudes 0.01 --omega 0.15 --cycles 3",
            "amplitude K.h5 --amplitudes 0.01 --omega 0.15 --planes 2 --cycles 3",
            "transport P.h5 --at 0.5 --axis x --until 90",
            "transport P.h5 --quantity kubo --at 0.3:0.5:2", "transport W.h5 --quantity coherent --at 0.1:0.3:3",
            "design P.h5 --goal delay --iterations 2", "design P.h5 --goal band:0.1:0.2 --iterations 1 --rows grains",
            "coda P.h5 --trials 3 --noise 0.1", "coda P.h5 --detector part:0:4 --grain 40 --rows 4",
            "transport P.h5 --quantity split --at 0.3", "transport P.h5 --quantity energy --at 0.3"):
        check_command(*line.split())
    check_command("check", "P.h5", units=False)
    check_command("front", "K.h5", f"--material={MATERIAL}")
    for line in ("chain front --grains 10:40:2 --pressure 1e-4", "chain signal --grains 20 --pressure 1e-4 --points 20"):
        check_command(*line.split(), f"--material={MATERIAL}")


def tables_of_motions():
    for packing, mode in (("S", 200), ("P", 45)):
        for name, more in (("own", ()), ("si", ("--units=si",))):
            run("modes", f"{packing}.h5", f"--mode={mode}", f"--vectors={name}.tsv", "-q", "--force", *more)
        assert compare(*(Table(pathlib.Path(f"{name}.tsv").read_text()) for name in ("own", "si"))) > 4


def study():
    pathlib.Path("study.cfg").write_text(GROUP + STUDY)
    run("study", "study.cfg", "--store=store", "--jobs=2", "-q")
    check_command("study", "study.cfg", "--store=store")
    for name in "ctof scaling planes statics moduli probes spectrum ensemble signal".split():
        for scene in ([], ["study.cfg"]) if name in ("ctof", "signal") else ([],):
            one = ["--pressure=75 MPa", "--grains=66"] if name in ("signal", "spectrum") and not scene else []
            check_command("table", name, "--store=store", *scene, *one)
    # the material of the store is that of its samples, and --material replaces it
    one, two = (table("table", "ctof", "--store=store", "--units=si", *more) for more in (
        (), ("--material=E=70e9,nu=0.22,rho=2500,d=2mm",)))
    assert one.rows == two.rows and one.comments != two.comments, "speeds do not depend on d, times and lengths do"


def sources():
    """Every unit that the sources name is one of those above, or of stored files and scenes (tests/unit/test_units.c)."""
    elsewhere = {"rho", "E* d", "rho d", "rho d^3", "rho d^5", "d / sqrt(E* / rho)", "sqrt(E* / rho) / d"}
    found = set()
    for path in sorted((SOURCE / "src").rglob("*")):
        if path.suffix in (".c", ".h", ".inc") and "tapped" not in str(path.relative_to(SOURCE)):
            found |= set(re.findall(r'"((?:modes )?(?=[^"]*(?:E\*|rho|\bd\b))(?:E\*|rho|sqrt|d|[ ()/^0-9])+)"', path.read_text()))
    found = {text for text in found if re.search(r"E\*|rho|^d$|^1/d$", text)}
    assert len(found) > 12 and found <= FACTORS.keys() | elsewhere, found - FACTORS.keys() - elsewhere


main(sources, commands, tables_of_motions, study)
