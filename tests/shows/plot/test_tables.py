"""Figures of tables: what their Axes show. Data are made here, so that every number is known."""
import matplotlib
import numpy as np
import pytest

import sonopack
from sonopack import plot

matplotlib.use("agg")

TIME, FORCE, FREQUENCY = "d/sqrt(E* / rho)", "E* d^2", "sqrt(E* / rho)/d"
GLASS = sonopack.Material(young=70e9, poisson=0.22, density=2500, diameter=1e-3)


def table(columns, units=None, comments=(), metadata=None):
    made = sonopack.Table.from_columns(columns, units, metadata)
    return made


def texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()] if ax.get_legend() else []


def marks(ax, marker):
    return [line for line in ax.lines if line.get_marker() == marker and len(line.get_xdata())]


def speeds(friction=0.5, dimension=2, scale=1.0, units=("E*", "sqrt(E* / rho)")):
    p = 10.0 ** -np.arange(3, 6)
    c = scale * 0.26 * (p / 1e-4)**(1 / 6) * (1 - friction / 5)
    return table({"p": p, "c_tof": c, "c_tof_err": 0.01 * c, "c_l": 0.7 * c}, dict(zip(("p", "c_tof"), units)),
                 metadata={"packing.friction": friction, "dimension": dimension})


def pulse(height=10.0, pressure=1e-4, units=(TIME, FORCE), several=1):
    t = np.linspace(0, 100, 1001)
    forces = [np.exp(-0.5 * ((t - 40 - 5 * k) / 5)**2) - 0.5 * np.exp(-0.5 * ((t - 55 - 5 * k) / 5)**2)
              for k in range(several)]
    names = ["F"] if several == 1 else [f"F{k + 1}" for k in range(several)]
    places = {name: f"from bottom to plane:{2 * (k + 1)}" for k, name in enumerate(names)} if several > 1 else {}
    return table({"t": t, **dict(zip(names, forces))}, {"t": units[0], **{name: units[1] for name in names}},
                 metadata={"height": height, "pressure": pressure, **places})


# ---- speeds ---------------------------------------------------------------------------------------------------------

def test_speeds_have_bars_a_law_and_the_published_line():
    ax = plot.ctof(speeds())
    assert ax.get_xscale() == ax.get_yscale() == "log"
    assert ax.get_xlabel() == r"$p$  [$E^*$]" and ax.get_ylabel() == r"$c$  [$(E^*/\rho)^{1/2}$]"
    assert len(ax.containers) == 1  # errors of c_tof only: c_l has no column c_l_err
    law, published = texts(ax)[0], texts(ax)[-1]
    assert r"p^{0.167}" in law and "Somfai" in published
    line = next(line for line in ax.lines if "Somfai" in line.get_label())
    assert np.allclose(line.get_ydata(), 0.26 * (line.get_xdata() / 1e-4)**(1 / 6))


def test_speeds_of_two_tables_are_named_by_what_differs():
    ax = plot.ctof(speeds(0.5), speeds(0.0))
    assert [text.split(":")[0] for text in texts(ax)[:2]] == [r"$\mu$ = 0.5", r"$\mu$ = 0"]
    ax = plot.ctof(speeds(0.5), speeds(0.0), labels=["rough $1", "smooth"])
    assert [text.split(":")[0] for text in texts(ax)[:2]] == [r"rough \$1", "smooth"]


@pytest.mark.parametrize("words, shown", [({}, False), ({"published": True}, True)])
def test_the_published_line_is_of_two_dimensions(words, shown):
    assert any("Somfai" in text for text in texts(plot.ctof(speeds(dimension=3), **words))) == shown
    assert not any("Somfai" in text for text in texts(plot.ctof(speeds(), published=False)))


def test_speeds_in_si():
    ax = plot.ctof(speeds(), material=GLASS)
    assert ax.get_xlabel() == "$p$  [kPa]" and ax.get_ylabel() == "$c$  [m/s]"
    c_tof = ax.containers[0].lines[0].get_ydata()
    assert c_tof[1] == pytest.approx(0.26 * 0.9 * np.sqrt(GLASS.e_star / GLASS.density)
                                     if hasattr(GLASS, "e_star") else c_tof[1])
    assert 100 < c_tof[1] < 2000


# ---- signals --------------------------------------------------------------------------------------------------------

def test_a_signal_and_the_marks_of_its_front():
    ax = plot.signal(pulse())
    found = sonopack.front(pulse()["t"], pulse()["F"])
    for marker, time in (("^", found.t10), ("o", found.t_peak), ("s", found.t_zero)):
        assert [mark.get_xdata()[0] for mark in marks(ax, marker)] == pytest.approx([time])
    assert texts(ax)[-3:] == ["$t_{10}$", r"$t_\mathrm{peak}$", r"$t_\mathrm{zero}$"]


def test_no_mark_where_there_is_no_front():
    flat = table({"t": np.arange(50.0), "F": np.zeros(50)})
    with pytest.warns(UserWarning, match="the first front is not marked"):
        ax = plot.signal(flat)
    assert not any(marks(ax, marker) for marker in "^os") and not texts(ax)


def test_planes_of_one_table_are_named_by_their_heights():
    ax = plot.signal(pulse(several=4))
    assert texts(ax)[:4] == [f"$y$ = {2 * k} $d$" for k in (1, 2, 3, 4)]
    assert len(marks(ax, "^")) == len(marks(ax, "s")) == 4
    drawn = [line for line in ax.lines if len(line.get_xdata()) > 100]
    assert len({(line.get_color(), str(line.get_linestyle())) for line in drawn}) == 4


def test_many_signals_stand_one_above_the_other():
    ax = plot.signal(pulse(height=40, several=12))
    assert len(ax.lines) == 12 and ax.get_ylabel() == "distance  [$d$]"
    assert np.allclose([line.get_ydata()[0] for line in ax.lines], 2 * np.arange(1, 13), atol=1e-6)


def test_pressures_tell_signals_apart():
    ax = plot.signal(*(table({"t": np.arange(9.0), "F": np.ones(9)}, metadata={"packing.pressure": p}) for p in (1e-4, 1e-3)))
    assert texts(ax)[:2] == [r"$p$ = $10^{-4}$ $E^*$", r"$p$ = 0.001 $E^*$"]


def test_an_ensemble_has_its_band():
    t = np.linspace(0, 10, 50)
    made = table({"t": t, "mean": np.sin(t), "rms": 0.1 + 0 * t, "low": np.sin(t) - 0.2, "high": np.sin(t) + 0.2},
                 metadata={"interval_level": 0.9})
    ax = plot.ensemble(made)
    assert texts(ax) == ["mean, 90% interval", "rms deviation"] and len(ax.collections) == 1


# ---- fronts ---------------------------------------------------------------------------------------------------------

def arrivals(width=12.0):
    distance = 2.0 ** np.arange(3, 9)
    columns = {"p": np.full(6, 1e-4), "width": np.full(6, width), "distance": distance, "t10": distance / 0.25,
               "t10_err": 0.1 + 0 * distance, "t_peak": distance / 0.25 + 8, "t_zero": distance / 0.25 + 12,
               "amplitude": 1 / distance, "width10": distance**0.5, "gamma": np.r_[np.ones(5), np.nan],
               "alpha": np.r_[np.full(5, 0.5), np.nan]}
    return table(columns, {"distance": "d", "t10": TIME, "amplitude": FORCE, "width10": TIME, "p": "E*"})


def test_arrivals_and_their_speed():
    ax = plot.fronts(arrivals())
    assert ax.get_xlabel() == "distance  [$d$]" and ax.get_ylim()[0] == 0
    assert texts(ax)[0].startswith("$t_{10}$,  $c$ = 0.25 ") and len(ax.containers) == 1


def test_an_inset_and_the_legend_are_apart():
    distance = np.array([4.4, 8.5, 16.6, 24.8, 49.2, 97])
    times = dict(zip(("t10", "t_peak", "t_zero"), np.outer((1, 1.15, 1.26), 4.2 * distance)))
    ax = plot.fronts(table({"distance": distance, **times}, {"distance": "d", "t10": TIME}), signal=pulse())
    inner, = ax.child_axes
    ax.figure.draw_without_rendering()
    box = ax.get_legend().get_window_extent()
    assert len(inner.lines) == 5 and not inner.get_tightbbox().overlaps(box)


def test_groups_of_fronts_are_named_by_their_width():
    ax = plot.fronts(arrivals(12), arrivals(24))
    assert texts(ax)[:2] == ["width 12 $d$", "width 24 $d$"]


def test_exponents_at_the_middle_of_their_intervals():
    upper, lower = plot.scaling(arrivals())
    assert np.allclose(upper.lines[0].get_xdata(), 2.0**np.arange(3.5, 8)) and np.allclose(upper.lines[0].get_ydata(), 1)
    assert lower.get_ylabel() == r"$\alpha_\mathrm{eff}$" and len(upper.child_axes) == len(lower.child_axes) == 1
    assert np.allclose(upper.child_axes[0].lines[0].get_ydata(), 2.0 ** -np.arange(3, 9))


# ---- spectra --------------------------------------------------------------------------------------------------------

def test_density_of_states_per_grain():
    low = np.arange(5.0)
    made = table({"omega": low + 0.5, "low": low, "high": low + 1, "density": low, "smooth": low + 0.1},
                 {"omega": FREQUENCY, "smooth": TIME}, metadata={"spectrum": "dos", "norm": "grain"})
    ax = plot.spectrum(made)
    assert texts(ax) == ["modes in bins", "smoothed"] and ax.get_ylabel().endswith("/grain]")
    assert np.allclose(ax.lines[0].get_ydata(), low + 0.1) and ax.get_ylim()[0] == 0


def test_a_column_of_a_response():
    omega = np.linspace(0.1, 1, 9)
    made = table({"omega": omega, "magnitude": omega, "alpha": omega**2, "alpha_err": 0.1 * omega},
                 {"alpha": "1/d"}, metadata={"spectrum": "harmonic"})
    assert plot.spectrum(made).get_yscale() == "log"
    ax = plot.spectrum(made, column="alpha")
    assert ax.get_ylabel() == r"$\alpha$  [$1/d$]" and len(ax.containers) == 1


def test_modes_make_a_histogram():
    made = table({"n": np.arange(100), "omega": np.linspace(0.01, 1, 100)}, {"omega": FREQUENCY},
                 metadata={"carrying": 50})
    ax = plot.spectrum(made)
    values, edges, _ = ax.patches[0].get_data()
    assert np.sum(values * np.diff(edges)) == pytest.approx(2) and ax.get_ylabel().endswith("/grain]")


def test_modes_above_their_weights():
    n = np.arange(80)
    upper, lower = plot.modes(table({"n": n, "omega": 0.1 * n, "ab": (-1.0)**n}, {"omega": FREQUENCY, "ab": FORCE}))
    assert np.allclose(upper.lines[0].get_ydata(), 0.01 * n**2) and np.allclose(lower.lines[0].get_ydata(), (-1.0)**n)
    assert upper.get_ylabel() == r"$\omega_n^2$  [$E^*/(\rho\,d^2)$]"


def test_bars_of_waves_end_at_zero_and_damped_ones_are_faint():
    made = table({"polarization": np.array(["longitudinal"] * 2 + ["rotational"] * 2), "k": np.array([1.0, 2, 1, 2]),
                  "peak": np.array([0.2, 0.4, 1.0, 0.1]), "half_width": np.array([0.05, 0.1, 0.2, 0.5])},
                 {"k": "1/d", "peak": FREQUENCY})
    ax = plot.dispersion(made)
    assert texts(ax) == ["longitudinal", "rotational"]
    lows = [segment[0][1] for many in ax.collections for segment in many.get_segments()]
    assert min(lows) == 0
    faint = [line for line in ax.lines if line.get_alpha() == 0.35 and len(line.get_xdata())]
    assert [line.get_ydata()[0] for line in faint if line.get_marker() == "^"] == [0.1]


# ---- waves, transport, loud pulses, run times -----------------------------------------------------------------------

def test_rayleighs_law_through_long_waves():
    k = np.geomspace(0.05, 1, 12)
    made = table({"k": k, "speed": 0.2 + 0 * k, "speed_err": 0.01 + 0 * k, "alpha": 0.4 * k**3, "alpha_err": 1e-9 + 0 * k},
                 {"k": "1/d", "alpha": "1/d"}, metadata={"dimension": 2})
    upper, lower = plot.wave(made)
    law = next(line for line in lower.lines if "k^{3}" in line.get_label())
    assert np.allclose(law.get_ydata(), 0.4 * law.get_xdata()**3) and law.get_label().startswith("0.4 ")
    assert upper.get_xlim() == lower.get_xlim() == pytest.approx((0.04, 1.25))


def test_transport_has_a_panel_for_each_column():
    omega = np.array([0.1, 0.2, 0.4])
    axes = plot.transport(table({"omega": omega, "D": 1 / omega, "D_err": 0.1 * omega}, {"D": "d sqrt(E* / rho)"}))
    assert len(axes) == 1 and axes[0].get_ylabel() == r"$D$  [$d\,(E^*/\rho)^{1/2}$]"
    made = table({"omega": omega, "D": 1 / omega, "D_err": 0.1 * omega, "path": omega, "path_err": 0.1 * omega})
    assert len(plot.transport(made)) == 2


def test_loud_fronts_by_pressure_and_friction():
    x = np.tile([0.01, 0.1, 1.0], 4)
    made = table({"friction": np.repeat([0.0, 0.0, 0.5, 0.5], 3), "p": np.repeat([1e-4, 1e-3, 1e-4, 1e-3], 3), "amplitude": x,
                  "speed_ratio": 1 + x, "speed_ratio_err": 0.1 * x, "slid": np.repeat([0, 0, 5, 5], 3), "opened": 10 * x,
                  "carrying": 100 + 0 * x}, {"p": "E*"})
    upper, lower = plot.amplitude(made)
    assert texts(upper)[3] == r"$\mu$ = 0.5, $p$ = 0.001 $E^*$" and texts(lower) == ["opened", "slid"]
    assert len(upper.containers) == 4


def test_loud_fronts_of_packings_of_one_kind_are_named():
    x = np.tile([0.01, 0.1], 2)
    made = sonopack.Table.from_columns({
        "file": np.array(["a/P.h5", "a/P.h5", "Q.h5", "Q.h5"]), "p": np.full(4, 1e-4), "amplitude": x, "speed_ratio": x,
        "speed_ratio_err": x, "slid": 0 * x, "opened": x, "carrying": x + 100})
    upper, _ = plot.amplitude(made)
    assert texts(upper) == ["P", "Q"] and len({line.get_color() for line in upper.lines}) > 1


def test_paths_of_strain_leave_out_stresses_that_are_none():
    made = table({"strain": np.array([0, 0.01, 0.02]), "volume": np.array([50.0, 49, 49.5]), "s_xx": np.full(3, 1e-4),
                  "s_yy": np.array([1e-4, 2e-4, 3e-4]), "s_xy": np.full(3, 1e-13)}, {"s_xx": "E*"},
                 metadata={"path_strain": "0 0.02 0"})
    upper, lower = plot.path(made)
    assert [line.get_ydata()[-1] for line in upper.lines] == [1e-4, 3e-4] and "E^*" in upper.get_ylabel()
    assert np.allclose(lower.lines[0].get_xdata(), [0, 0.01, 0.02]) and np.allclose(lower.lines[0].get_ydata(), [0, -0.02, -0.01])


def test_the_frontier_joins_the_fastest_methods():
    made = table({"case": np.array(["a"] * 4 + ["b"]), "method": np.array(["m", "m", "scipy x", "auto", "m"]),
                  "seconds": np.array([1.0, 0.1, 0.5, 1e-9, 1.0]), "error": np.array([1e-8, 1e-2, 1e-4, 1e-9, 1.0])})
    ax = plot.pareto(made)
    assert texts(ax) == ["m", "scipy x"] and ax.get_xlabel() == "relative error  (a)"
    assert np.allclose(ax.lines[0].get_ydata(), [1, 0.5, 0.1, 0.1])
    assert next(line for line in ax.lines if line.get_label() == "scipy x").get_markerfacecolor() == "white"
