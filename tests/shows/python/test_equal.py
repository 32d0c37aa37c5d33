"""The package gives the command's numbers bit for bit: packings, signals, modes, moduli, spectra, studies, columns."""
import dataclasses
import filecmp
import os
import pathlib

import numpy as np
from common import SOURCE, command, equal, table

import sonopack

KEYS = {"packing.grains": 100, "packing.width": 12, "packing.seed": 3}
SETS = [word for key, value in KEYS.items() for word in ("--set", f"{key}={value}")]
STUDY = """packing = { width = 12; };
study = { samples = 3; want = ["ctof", "moduli", "statics", "signal", "spectrum"]; sweep = (
  { key = "packing.grains"; values = [60, 100]; }, { key = "packing.pressure"; values = [1e-5, 1e-4]; } ); };
"""


def all_equal(read, result, names, what):
    for name in names:
        column, _, field = name.partition("=")
        equal(read, column, getattr(result, field or column), what)


def packing():
    if not os.path.exists("P.h5"):
        command("pack", *SETS, "-o", "P.h5", "--quiet")
    return sonopack.Packing.read("P.h5")


def test_packing():
    packing()
    sonopack.Packing.make(sonopack.Scene.read(None, KEYS)).save("Q.h5")
    assert filecmp.cmp("P.h5", "Q.h5", shallow=False), "the files differ"
    made = sonopack.Packing.make(sonopack.Scene(packing={"grains": 100, "width": 12}), seed=3)
    assert made.hash == packing().hash, "with a seed of its own"


def test_another_pressure():
    """packing.kind = file starts from a packing, in a file or in memory."""
    packing()
    command("pack", "--set", "packing.kind=file", "--set", "packing.file=P.h5", "--set", "packing.pressure=2e-4", "-o",
            "R.h5", "--quiet")
    scene = sonopack.Scene(packing={"kind": "file", "file": "P.h5", "pressure": 2e-4})
    expected = sonopack.Packing.read("R.h5").hash
    assert sonopack.Packing.make(scene).hash == expected, "from a file"
    assert sonopack.Packing.make(scene, start=packing()).hash == expected, "from memory"


def test_statics():
    statics, read = packing().statics(), table("statics", "P.h5")
    all_equal(read, statics, ["Phi2=phi2", "Phi3=phi3", "Phi3s=phi3s", "zs", "f0", "N_over_p=n_over_p", "Z2=z2", "F2=f2",
                              "F2S=f2s", "s1_over_s2", "s32_over_s2", "mobilised"], "statics")


def test_signal():
    network = packing().network()
    for words, options in (((), {}), (("--method", "dense", "--points", 101), {"method": "dense", "points": 101}),
                           (("--method", "dynamics", "--until", 30), {"method": "dynamics", "until": 30}),
                           (("--pulse", "gauss:2"), {"pulse": sonopack.Pulse.gauss(2)}),
                           (("--damping", 0.05, "--source", "displacement"), {"damping": 0.05, "source": "displacement"}),
                           (("--damping", "gamma:0.05:0.01"), {"damping": "gamma:0.05:0.01"})):
        read, signal = table("signal", "P.h5", *words), network.signal(**options)
        all_equal(read, signal, ["t", "F"], words)
        assert read.number("error") == signal.error, (words, "error")
    read = table("signal", "P.h5", "--detector", "plane:4", "--detector", "grain:40:shear")
    signal = network.signal(detectors=["plane:4", sonopack.Place.grain(40, shear=True)])
    for k in range(2):
        equal(read, f"F{k + 1}", signal.f[0, k], "several detectors")


def test_front():
    network = packing().network()
    names = ["t10", "t_peak", "t_zero", "amplitude", "width"]
    all_equal(table("front", "P.h5"), network.front(), names, "of a packing")
    assert packing().front() == network.front(), "of a packing without a network"
    network.signal().table().save("ours.tsv")
    all_equal(table("front", "ours.tsv"), network.signal().front(), names, "of a table made here")
    table("signal", "P.h5")
    os.replace("table.tsv", "signal.tsv")
    read = table("front", "signal.tsv")
    all_equal(read, network.signal().front(), names, "of a signal")
    trace = sonopack.Table.read("signal.tsv")
    window = sonopack.signal_window(trace.number("height"), trace.number("pressure"))
    all_equal(read, sonopack.front(trace["t"], trace["F"], window=window), names, "of a table")


def test_modes():
    network = packing().network()
    names = ["omega", "a", "b", "ab", "participation", "error"]
    for words, options in (((), {}), (("--lowest", 20), {"lowest": 20}), (("--band", "0.1:0.3"), {"band": (0.1, 0.3)})):
        all_equal(table("modes", "P.h5", *words), network.modes(**options), names, words)
    read, modes = table("modes", "P.h5", "--frequencies-only"), network.modes(vectors=False)
    all_equal(read, modes, ["omega", "error"], "frequencies only")
    assert read.number("zero_modes") == modes.zero.total, "zero modes"
    all_equal(table("modes", "P.h5", "--damping", 0.1), network.damped_modes(0.1),
              ["omega", "decay", "cosine", "sine", "error"], "damped")
    read, modes = table("modes", "P.h5", "--damping", "gamma:0.02"), network.damped_modes("gamma:0.02")
    all_equal(read, modes, ["omega", "decay"], "gamma")
    for name, ours in zip(("Q", "Q_err"), modes.quality()):
        assert np.array_equal(read[name], ours, equal_nan=True), (name, "gamma")
    all_equal(table("modes", "P.h5", "--prestress"), packing().network(prestress=True).complex_modes(),
              ["omega", "growth", "cosine", "sine", "error"], "complex")
    all_equal(table("modes", "P.h5", "--prestress", "--lowest", 4),
              packing().network(prestress=True).complex_modes(lowest=4), ["omega", "growth", "sine"], "lowest complex")
    read = table("modes", "P.h5", "--prestress", "--band", "0.1:0.3", "--vectors", "C.h5")
    growing = packing().network(prestress=True).complex_modes(band=(0.1, 0.3))
    all_equal(read, growing, ["omega", "growth", "error"], "band of complex")
    growing.save("D.h5")
    assert filecmp.cmp("C.h5", "D.h5", shallow=False), "the files of complex vectors differ"
    right, left = (v.reshape(growing.n, -1) for v in (growing.right, growing.left))
    assert np.abs(left @ right.T - np.eye(growing.n)).max() <= growing.orthogonality + 1e-13 < 1e-10
    assert np.array_equal(growing.displacement(2), growing.right[2] / growing.network.mass**0.5)
    assert not hasattr(packing().network(prestress=True).complex_modes(lowest=4, vectors=False), "right")
    command("modes", "P.h5", "--lowest", 5, "--vectors", "V.h5", "--quiet", "-o", "v.tsv")
    network.modes(lowest=5).save("W.h5")
    assert filecmp.cmp("V.h5", "W.h5", shallow=False), "the files of vectors differ"


def test_respond():
    network = packing().network()
    read, own = table("respond", "P.h5", "--strain", "yy"), network.respond("strain", axis=1)
    assert np.array_equal(np.column_stack([read["ux"], read["uy"], read["rz"]]).ravel(), own.u)
    read = table("respond", "P.h5", "--strain", "yy", "--contacts")
    all_equal(read, own, ["fn", "ft"], "forces")
    assert all(np.array_equal(read[name], limit) for name, limit in zip(("opens", "slides"), own.limits()))
    assert np.allclose(np.linalg.norm(own.force, axis=1)**2, own.fn**2 + own.ft**2)


def test_clusters():
    network = packing().network()
    for method in ("game", "motions"):
        all_equal(table("clusters", "P.h5", "--method", method, "--sliding-at", 0.5),
                  network.clusters(method, sliding_at=0.5), ["bars", "cluster", "redundant"], method)
    assert np.array_equal(table("clusters", "P.h5", "--grains")["cluster"], network.clusters().of_grain)


def test_moduli():
    network = packing().network()
    all_equal(table("moduli", "P.h5"), network.moduli(), ["C11=c11", "C12=c12", "C22=c22", "C33=c33", "c_l", "c_t"], "moduli")
    all_equal(table("moduli", "P.h5", "--set", "network.tangential=loading"),
              packing().network(tangential="loading").moduli(), ["C22=c22", "c_t"], "loading history")
    read, probe = table("moduli", "P.h5", "--probe", "sine:1"), network.probes([("sine", 1)])[0]
    all_equal(read, probe, ["C22=along", "C33=shear"], "probe")
    read, parts = table("moduli", "P.h5", "--probe", "local:3"), network.local_moduli(3)
    all_equal(read, parts, ["K=bulk", "G=shear", "error", "grains", "contacts"], "parts")
    assert np.array_equal(read["C21"], parts.c[:, 1, 0]) and read.number("C33") == parts.whole[2, 2]
    strained = network.finite_strain(1e-5).moduli
    all_equal(table("moduli", "P.h5", "--strain", "1e-5"), strained, ["C11=c11", "C22=c22", "C33=c33"], "strain")


def test_spectra():
    network = packing().network()
    names = ["omega", "density", "cumulative", "smooth", "density_err=density_error", "smooth_err=smooth_error"]
    for method in ("exact", "kpm", "count"):
        all_equal(table("spectrum", "dos", "P.h5", "--method", method), network.dos(method=method), names, method)
    all_equal(table("spectrum", "transmission", "P.h5"), network.transmission(), ["omega", "density", "re", "im", "error"],
              "transmission")
    read, waves = table("spectrum", "dispersion", "P.h5"), network.dispersion()
    for name in ("k", "rms", "spread", "peak", "half_width", "resolution"):
        equal(read, name, waves.wave[name], "dispersion")
    assert [waves.polarization(k) for k in range(waves.n)] == list(read["polarization"]), "polarizations"
    read = table("spectrum", "harmonic", "P.h5", "--damping", 0.01)
    driven = network.harmonic(read["omega"], damping=0.01)
    equal(read, "re", driven.F.real, "harmonic")
    equal(read, "im", driven.F.imag, "harmonic")
    for name in ("k", "k_err", "alpha", "misfit"):
        equal(read, name, driven.fit[name], "harmonic")
    read, continuum = table("spectrum", "continuum", "P.h5"), network.continuum()
    for name in ("omega", "omega_continuum", "overlap"):
        equal(read, name, continuum.row[name], "continuum")


def test_wave():
    packed = SOURCE / "packings/reference/packing_N600_p1e-4.txt"
    read = table("wave", packed, "--at", "0.1,0.2")
    section = sonopack.Packing.read(packed).network().section()
    for row, omega in enumerate((0.1, 0.2)):
        wave = section.wave(omega)
        for name in ("k", "alpha"):
            assert read[name][row] == getattr(wave, name), ("wave", name, read[name][row], wave)
        assert section.errors(wave)[0] >= abs(wave.k_shift) and section.errors(wave)[1] >= abs(wave.alpha_shift)


def test_free_paths():
    """k path falls through pi between the frequencies 1 and 2, half of the way or at a third of it."""
    long, short = (sonopack.free_path(k, 0.0, 0.25 / np.pi, 0.0) for k in (1.5, 0.5))
    assert np.isclose(long.path, 2 * np.pi) and np.isclose(long.k_path, 3 * np.pi) and np.isclose(short.k_path, np.pi)
    assert np.isnan(sonopack.free_path(1.0, 0.0, 0.1, 0.06).path)
    paths = [sonopack.free_path(k, 0.1, 0.25 / np.pi, 0.0) for k in (0.75, 0.25)]
    assert np.allclose(sonopack.ioffe_regel([1, 2], paths), (1.5, np.hypot(0.05, 0.05) * 2))
    assert sonopack.ioffe_regel([1, 2], paths[::-1]) is None


def test_study():
    pathlib.Path("study.cfg").write_text(STUDY)
    scene = sonopack.Scene.read("study.cfg")
    command("study", "study.cfg", "--store", "C", "-o", "study.tsv", "--force", "--quiet")
    store = sonopack.study(scene, "P", jobs=2)
    names = sorted(path.name for path in pathlib.Path("C").glob("*.h5"))
    assert len(names) == scene.samples == 12, names
    match, mismatch, errors = filecmp.cmpfiles("C", "P", names, shallow=False)
    assert len(match) == 12, ("files of samples differ", mismatch, errors)
    for name, file in (("ctof", "study.tsv"), ("moduli", "study-moduli.tsv"), ("statics", "study-statics.tsv")):
        read, made = sonopack.Table.read(file), store.table(name, scene)
        assert read.names == made.names and read.units == made.units, (name, read.names, made.names)
        for column in read:
            equal(read, column, made[column], name)
    command("table", "ensemble", "study.cfg", "--store", "C", "-o", "ensemble.tsv", "--quiet")
    read, made = sonopack.Table.read("ensemble.tsv"), store.table("ensemble", scene)
    for column in read:
        if made[column].dtype.kind == "U":
            assert list(read[column]) == list(made[column]), (column, read[column], made[column])
        else:
            equal(read, column, made[column], "ensemble")
    for sample in store:
        assert not sample.failed and sample.moduli and sample.statics, sample
        network = sample.packing().network()
        assert sample.front == dataclasses.replace(network.front(), crossings=0), (sample, "front")
        assert np.array_equal(sample.frequencies(), network.modes(vectors=False).omega[-len(sample.frequencies()):]), "spectrum"
        assert np.array_equal(sample.signal()[1], network.signal().F), "signal"


def test_units():
    """A scene in SI, and tables in SI: the command's numbers."""
    keys = {"E": 70e9, "nu": 0.22, "rho": 2500, "d": 1e-3}
    pathlib.Path("si.cfg").write_text("material = { E = 70e9; nu = 0.22; rho = 2500; d = 1e-3; };\n"
                                      'packing = { grains = 60; width = 8; pressure = "100 kPa"; };\n')
    command("pack", "si.cfg", "-o", "S.h5", "--quiet")
    scene = sonopack.Scene(material=keys, packing={"grains": 60, "width": 8, "pressure": "100 kPa"})
    made = sonopack.Packing.make(scene)
    made.save("T.h5")
    assert filecmp.cmp("S.h5", "T.h5", shallow=False), "the files differ"
    assert made.material == sonopack.Material(70e9, 0.22, 2500.0, 1e-3), made.material
    assert sonopack.quantity("100 kPa", "E*", made.material) == made.pressure, made.pressure
    si, own = table("signal", "S.h5", "--units", "si"), table("signal", "S.h5").si(made.material)
    assert si.units == own.units and si.units["F"] != "E* d^2", (si.units, own.units)
    for name in si:
        equal(si, name, own[name], "SI")
    started = sonopack.Packing.make(sonopack.Scene(packing={"kind": "file", "file": "S.h5", "pressure": 2e-6}))
    assert started.material == made.material, started.material


def test_sensitivity():
    made = packing()
    network = made.network()
    kn, kt = network.springs["kn"], network.springs["kt"]
    for of in ("t10", "peak", "width", "C22", "cl"):
        read, found = table("sensitivity", "P.h5", "--of", of), network.sensitivity(of)
        assert read.number("value") == found.value, of
        equal(read, "by_kn", kn * found.kn, of)
        equal(read, "by_kt", kt * found.kt, of)
        equal(read, "by_kn_err", kn * found.errors["kn"], of)
    read = table("sensitivity", "P.h5", "--by", "mass,radius,position", "--of", "F", "--at", 60)
    found = network.sensitivity("F", "mass,radius,position", t=60)
    equal(read, "by_radius", network.r * found.radius, "radius")
    equal(read, "by_y", found.position[:, 1], "position")
    modes = network.modes()
    first = modes.zero.total
    read = table("sensitivity", "P.h5", "--of", f"omega:{first}-{first + 3}")
    equal(read, "by_kn", kn * network.mode_sensitivity(modes, first, 4).kn, "modes")
    pressure = network.sensitivity("t10", "pressure").pressure
    equal(table("sensitivity", "P.h5", "--by", "pressure"), "by_p", made.pressure * pressure, "pressure")
    at_once, _, error = network.signal_sensitivity([60.0, 20.0], [5, 7])
    assert network.sensitivity("c_l").value == network.sensitivity("cl").value, "both names of a speed"
    one = network.sensitivity("F", "kn", t=60)
    assert np.all(np.abs(at_once[:, 0] - one.kn[[5, 7]]) <= error[:, 0] + one.errors["kn"][[5, 7]]), "all times"


def test_column():
    for output in ("trajectory", "strobe", "energy"):
        read = table("column", "--set", f"column.output={output}", "--set", "column.taps=3")
        made = sonopack.Column(output=output, taps=3).table()
        assert read.names == made.names, output
        for name in read:
            equal(read, name, made[name], output)
    read, column = table("column", "--set", "column.step=0.25"), sonopack.Column()
    motion = column.run(read["t"])
    for k in range(column.particles + 1):
        equal(read, f"y{k}", motion.y[:, k], "run")
    assert len(motion.taps) == column.taps, motion.taps
