"""What Python says of the library: every member has its own meaning, in the words of Python; every object shows what it
is; every result goes to SI units."""
import dataclasses
import inspect
import pickle
import re

import numpy as np
import pytest
from common import SOURCE, command, raised

import sonopack
from sonopack import _command, _core, _records, formats
from sonopack._reference import COMMENTS

DISKS = SOURCE / "packings/reference/packing_N200_p1e-4.txt"
GLASS = sonopack.Material(young=70e9, poisson=0.22, density=2500.0, diameter=1e-3)
MODULUS = GLASS.young / (1 - GLASS.poisson**2)
SPEED = np.sqrt(MODULUS / GLASS.density)
CLASSES = [getattr(sonopack, name) for name in sonopack.__all__ if inspect.isclass(getattr(sonopack, name))]


def documents():
    """(name, docstring) of everything public."""
    yield from ((name, getattr(sonopack, name).__doc__) for name in sonopack.__all__ if callable(getattr(sonopack, name)))
    yield from ((f"formats.{name}", member.__doc__) for name, member in vars(formats).items()
                if not name.startswith("_") and getattr(member, "__module__", "").startswith(formats.__name__))
    for kind in CLASSES:
        if issubclass(kind, sonopack.Status):
            continue
        for name, member in {name: member for base in kind.__mro__[::-1] if base.__module__.startswith("sonopack")
                             for name, member in vars(base).items()}.items():
            function = getattr(member, "__func__", member)
            if not name.startswith("_") and (callable(function) or isinstance(member, (property, _core._Field))):
                yield f"{kind.__name__}.{name}", function.__doc__
        for field in dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ():
            found = re.search(rf"^(\s*|.*, ){field.name.rstrip('_')}(, \w+)*: (.*)", kind.__doc__, re.M)
            yield f"{kind.__name__}.{field.name}", found and found[3]


def test_everything_has_its_meaning():
    found = dict(documents())
    assert len(found) > 500
    assert not [name for name, text in found.items() if not text or not re.search("[A-Za-z]{2}|C[1-6]{2}", text)]


def test_no_words_of_c():
    wrong = re.compile(r"\bNULL\b|\bNAN\b|\bSP_E|\bmay be None\b|INFINITY|\w\.\.\w{3}")
    assert not {name: text for name, text in documents() if wrong.search(text or "")}


@pytest.mark.parametrize("member, says, not_of", [
    ("Moduli.c11", "C11", "C33"), ("Moduli.c33", "longitudinal in 3D", "C11"),
    ("Moduli.c_t", "transverse", "longitudinal"), ("Moduli.c_l", "in 3D sqrt(C33/Phi_3*)", "transverse"),
    ("Statics.phi3", "volume fraction", "area"), ("Statics.f0", "rattlers", "contacts per"),
    ("AmplitudeFront.lost", "at the end", "slid"), ("Front.t10", "`rise` of the peak", "vertex"),
    ("ParticipationBin.sd", "standard deviation", "smallest"), ("Packing.seed", "random", "compression"),
    ("Signal.detectors", "detectors", "sources"), ("Front.width", "t_zero - t10 [d/sqrt(E* / rho)]", "arrival")])
def test_comments_belong_to_their_members(member, says, not_of):
    text = dict(documents())[member]
    assert says in text and not_of not in text


def test_sources_are_named():
    named = [name for path in (SOURCE / "python/sonopack").glob("*.py")
             for name in re.findall(r'@documented\("(\w+)"\)', path.read_text())]
    assert len(named) > 30 and all(COMMENTS.get(name, ("",))[0] for name in named)
    text = sonopack.Network.moduli.__doc__
    assert "Refused" in text and "(C: sp_moduli_make)" in text and "C11 .. C66" in text


@pytest.fixture(scope="module")
def network():
    return sonopack.Packing.read(DISKS).network()


RESULTS = {
    "dos": lambda n: n.dos(bins=5), "transmission": lambda n: n.transmission(points=7), "modes": lambda n: n.modes(lowest=3),
    "dispersion": lambda n: n.dispersion(profile=9), "harmonic": lambda n: n.harmonic([0.1], damping=0.1),
    "continuum": lambda n: n.continuum(lowest=4), "damped": lambda n: n.damped_modes(0.05),
    "local": lambda n: n.local_moduli(3), "complex": lambda n: n.complex_modes(), "clusters": lambda n: n.clusters(),
    "response": lambda n: n.respond("strain", axis=1), "signal": lambda n: n.signal(),
    "coda": lambda n: sonopack.Coda(n, [1.0, 2.0]), "elasticity": lambda n: n.elasticity(), "network": lambda n: n,
    "section": lambda n: n.section(low=2, spacing=0.2), "packing": lambda n: n.packing,
    "design": lambda n: sonopack.design(n.packing, "delay", iterations=1),
    "uncertainty": lambda n: sonopack.uncertainty(n.packing, force=0.1, samples=10)}


@pytest.mark.parametrize("name", RESULTS)
def test_results_show_themselves_and_go_to_si(network, name):
    result = RESULTS[name](network)
    assert " object at 0x" not in repr(result) and re.search(r"\d", repr(result)), repr(result)
    in_si = result.si(GLASS)
    scales = {"s": 1e-3 / SPEED, "Pa": MODULUS, "N": MODULUS * 1e-6, "rad/s": SPEED / 1e-3, "m": 1e-3, "m/s": SPEED,
              "1/m": 1e3}
    for member, unit in in_si.units.items():
        own, si = getattr(result, member), getattr(in_si, member)
        if unit in scales:
            assert np.allclose(si, np.multiply(own, scales[unit]), rtol=1e-12, atol=0, equal_nan=True), (member, unit)
    fault = raised(sonopack.InvalidInput, result.si) if in_si.units else None
    assert fault is None or fault.key == "material"


def test_other_objects_show_themselves(network):
    for thing in (sonopack.Pulse.sine(0.1, 3), sonopack.Pulse.table([0, 1], [0, 1]), network.sensitivity(),
                  sonopack.Column(), sonopack.Scene(), sonopack.Place.plane(3)):
        assert " object at 0x" not in repr(thing), repr(thing)


@pytest.mark.parametrize("words, result, columns", [
    (("moduli",), lambda n: n.moduli(), {"C11": "c11", "C33": "c33", "c_l": "c_l"}),
    (("front",), lambda n: n.packing.front(), {"t10": "t10", "width": "width"}),
    (("signal", "--set", "signal.points=50"), lambda n: n.signal(points=50), {"t": "t", "F": "F"}),
    (("statics",), lambda n: n.packing.statics(), {"Phi3": "phi3", "zs": "zs"})])
def test_si_is_that_of_the_command(network, words, result, columns):
    """--units si has prefixes, which the unit of a column names."""
    material = "E=70e9,nu=0.22,rho=2500,d=1e-3"
    command(words[0], DISKS, *words[1:], "--units", "si", "--material", material, "-o", "si.tsv", "--quiet")
    read, found = sonopack.Table.read("si.tsv"), result(network).si(GLASS)
    for column, member in columns.items():
        unit = read.units[column]
        base = re.sub(r"\b[numkMG]?(m|s|N|Pa)\b", r"\1", unit)
        scale = sonopack.quantity(f"1 {unit}", base) if unit else 1
        assert np.allclose(read[column] * scale, getattr(found, member), rtol=1e-14, atol=0), (column, unit)


def test_results_know_the_material_of_their_packing():
    scene = sonopack.Scene(packing={"grains": 60, "width": 8}, material=dict(E=70e9, nu=0.22, rho=2500.0, d=1e-3))
    packing = sonopack.Packing.make(scene)
    for one, other in ((packing.network().moduli(), packing.network().moduli().si()),
                       (packing.network().signal().front(), packing.front().si())):
        assert type(one) is type(other)
    moduli = packing.network().moduli()
    assert moduli.si().c11 == moduli.si(packing.material).c11 == pytest.approx(moduli.c11 * MODULUS, rel=1e-12)
    assert pickle.loads(pickle.dumps(moduli)).si().c11 == moduli.si().c11
    assert np.allclose(packing.si().contacts["fn"], packing.contacts["fn"] * MODULUS * 1e-6, rtol=1e-12)


def test_units_are_units():
    """Every unit in a header is one that the library can read; no record mixes two in one member."""
    for kind in _records.RECORDS.values():
        for unit in kind.units.values():
            assert sonopack.quantity(f"1 {unit}", unit, GLASS) == pytest.approx(1, rel=1e-12), (kind, unit)


@pytest.mark.parametrize("call, begins", [
    (lambda: sonopack.Scene(packing={"pressure": -1}), "packing.pressure = -1"),
    (lambda: sonopack.Scene(packing={"presure": 1}), "unknown key packing.presure"),
    (lambda: sonopack.Column(e=1.5), "column.e = 1.5"),
    (lambda: sonopack.Scene().replace({"packing.seed": -1}), "packing.seed = -1"),
    (lambda: sonopack.Scene.parse("signal = { points = 1; };"), "text:1: signal.points = 1"),
    (lambda: sonopack.Scene.parse("signal = { points = 1; };", name="keywords.cfg"), "keywords.cfg:1: signal.points")])
def test_errors_begin_with_what_is_wrong(call, begins):
    assert str(raised(sonopack.InvalidInput, call)).startswith(begins)


@pytest.mark.parametrize("setting, says", [
    ("friktion=0.2", "did you mean packing.friction?"), ("points=7", "unknown key"), ("signal.points=7", "packing or network"),
    ("friction", "KEY=VALUE"), ("packing.friktion=0.2", "did you mean packing.friction?")])
def test_set_knows_the_groups_of_its_command(setting, says):
    """A key without its group is looked for in the groups that the command has, and in no other."""
    parser = _command.Parser("view", groups="packing network")
    fault = raised(sonopack.InvalidInput, lambda: parser.scene(parser.parse_args(["--set", setting])))
    assert says in str(fault) and "signal." not in str(fault).removeprefix(f"--set {setting}")
    assert parser.scene(parser.parse_args(["--set", "friction=0.25"]))["packing.friction"] == 0.25
