"""Figures of the tapped column, looked at as Axes."""
import matplotlib
import numpy as np
import pytest

import sonopack
from sonopack import plot
from sonopack.plot import tapped
from sonopack.plot._inputs import Input

matplotlib.use("agg")


@pytest.fixture(scope="module")
def made():
    """Tables of a column, computed once for each set of keys."""
    known = {}

    def table(**keys):
        words = tuple(sorted(keys.items()))
        if words not in known:
            known[words] = sonopack.Column(**{"particles": 3, "taps": 2, **keys}).table()
        return known[words]
    return table


def labelled(ax):
    return [line.get_label() for line in ax.lines if not line.get_label().startswith("_")]


def legend_hides(ax):
    """Texts of ticks that the legend lies on."""
    ax.figure.draw_without_rendering()
    box = ax.get_legend().get_window_extent()
    return [tick.get_text() for tick in (*ax.get_xticklabels(), *ax.get_yticklabels())
            if tick.get_text() and tick.get_window_extent().overlaps(box)]


def test_trajectories_of_few_particles_are_named(made):
    table = made()
    ax = plot.column(table)
    assert labelled(ax) == ["$y_{1}$", "$y_{2}$", "$y_{3}$", "floor $y_0$"]
    for k, line in enumerate(line for line in ax.lines if line.get_label().startswith("$y")):
        assert np.array_equal(line.get_ydata(), table[f"y{k + 1}"])
    assert ax.get_xlabel() == "$t$  [s]" and ax.get_ylabel() == "$y$  [cm]"
    assert [line.get_xdata()[0] for line in ax.lines if line.get_ls() == "--"] == [1.0]  # where the second tap begins


def test_of_many_particles_some_are_drawn(made):
    ax = plot.column(made(particles=50, taps=1, step=0.1))
    assert len(ax.lines) == 25 + 1 and labelled(ax)[0].startswith("$y_{2}$, $y_{4}$")


def test_si_of_heights(made):
    ax = plot.column(made(), material=sonopack.Material(70e9, 0.22, 2500.0, 1e-3))
    assert ax.get_ylabel() == "$y$  [m]" and np.array_equal(ax.lines[0].get_ydata(), 0.01 * made()["y1"])


def test_after_taps(made):
    table = made(output="strobe", taps=4)
    density, positions = plot.column(table)
    assert np.array_equal(density.lines[0].get_ydata(), table["density"])
    assert np.allclose(positions.lines[1].get_ydata(), table["y2"] - table["y2"][0])
    assert all(tick == round(tick) for tick in density.get_xticks())


def test_differences_of_models(made):
    table = made(output="compare", taps=1)
    ax = plot.column(table)
    assert labelled(ax) == ["long wave, mean", "long wave, largest", "BSR, mean", "BSR, largest"]
    if ax.get_yscale() == "linear":
        assert np.array_equal(ax.lines[0].get_ydata(), table["mean_longwave"])
    assert legend_hides(ax) == []


def test_sizes_that_differ_much_need_a_logarithmic_axis():
    t = np.linspace(0, 1, 20)
    ax = plot.column({"t": t, "mean_longwave": t, "max_longwave": 50 * t, "mean_bsr": t, "max_bsr": t})
    assert ax.get_yscale() == "log" and np.isnan(ax.lines[0].get_ydata()[0])


def test_densities(made):
    table = made(output="density")
    profiles, times = plot.column(table)
    assert labelled(profiles) == ["$t$ = 0 s", "tap 1, $t$ = 0.99 s", "tap 2, $t$ = 1.99 s"]
    assert np.allclose(profiles.lines[0].get_xdata(), [table[f"y{k}"][0] for k in (1, 2, 3)])
    assert labelled(times) == ["particle 1", "particle 2", "particle 3"]
    assert times.get_ylabel() == r"density $\rho$  [g/cm]"
    assert legend_hides(profiles) == [] == legend_hides(times)


@pytest.mark.parametrize("period, expected", [(1.0, [1, 2, 3]), (0.1, [1, 9, 16, 24, 32])])
def test_profiles_of_few_and_of_many_taps(period, expected):
    t = np.linspace(0, 3.2, 321)
    table = sonopack.Table.from_columns({"t": t, "y1": t, "rho1": t}, None, {"period": period})
    rows = tapped._profile_rows(tapped.Tapped(Input(table)), t)
    assert [tap for _, tap in rows] == [0, *expected]
    assert np.allclose(t[[row for row, _ in rows[1:]]], (np.array(expected) - 0.01) * period, atol=0.006)


def test_energies(made):
    table = made(output="energy")
    axes = plot.column(table)
    assert np.array_equal(axes[1].lines[0].get_ydata(), table["work"] - table["dissipated"])
    assert [ax.texts[0].get_text() for ax in axes] == ["(a)", "(b)", "(c)", "(d)"]
    assert axes[0].get_ylabel() == "energy  [erg]"


def test_a_bifurcation_stands_above_exponents(made):
    keys = {"particles": 1, "parameter": "period", "from_": 0.1, "to": 0.3, "points": 5, "taps": 10, "transient": 5,
            "e": 0.3, "stiffness": 1e5}
    dots, exponents = made(output="bifurcation", **keys), made(output="lyapunov", **keys)
    one, two = plot.column(exponents, dots)
    assert np.array_equal(one.lines[0].get_ydata(), dots["y1"]) and one.get_ylabel() == "$y_{1}$ after a tap  [cm]"
    assert np.array_equal(two.lines[0].get_ydata(), exponents["lambda"]) and two.get_ylabel() == r"$\lambda$  [1/tap]"
    assert one.get_xlim() == two.get_xlim() and one.get_xlabel() == "$T$  [s]"
    bars = two.containers[0].lines[2][0].get_segments()
    assert np.allclose([bar[1, 1] - bar[0, 1] for bar in bars], 2 * np.abs(exponents["error"]))


def test_violations_are_told():
    table = sonopack.Table.from_columns({"parameter": [1.0, 2.0], "lambda": [0.1, 0.2]})
    assert tapped.Tapped(Input(table)).violated() == ""
    path_text = "# warning: ordering (1) violated at 3 of 50 points\nparameter\tlambda\n1\t0.1\n2\t0.2\n"
    import pathlib
    import tempfile
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "l.tsv")
        path.write_text(path_text)
        ax = plot.column(path)
    assert ax.figure._supxlabel.get_text() == "order (1) violated at 3 of 50 points"


def test_surfaces_share_axes_and_have_a_colour_bar(made):
    lattice, wave = made(taps=1), made(taps=1, model="longwave")
    axes = plot.column(lattice, wave)
    assert [ax.get_title() for ax in axes] == ["(a)  lattice", "(b)  long wave"]
    assert axes[0].get_zlim() == axes[1].get_zlim() and axes[0].get_xlim() == axes[1].get_xlim()
    bar = next(ax for ax in axes[0].figure.axes if ax.name != "3d")
    assert bar.get_xlabel() == "$y(t) - y(0)$  [cm]"
    moves = np.array([lattice[f"y{k}"] - lattice[f"y{k}"][0] for k in (1, 2, 3)])
    assert bar.get_xlim()[1] >= moves.max() - 1e-9
    strips = [one for one in axes[0].collections]
    assert len(strips) == 2 and strips[0].get_zorder() < strips[1].get_zorder()  # the back first


def test_labels_of_axes_of_a_surface_do_not_meet(made):
    """The first labels of two axes stood on each other in the corner: 0 and 0.0."""
    ax = plot.column(made(taps=1), surface=True)
    ax.figure.draw_without_rendering()
    boxes = [tick.get_window_extent() for axis in (ax.xaxis, ax.yaxis, ax.zaxis) for tick in axis.get_ticklabels()
             if tick.get_text() and tick.get_visible()]
    assert len(boxes) > 6
    meet = [(a, b) for a in range(len(boxes)) for b in range(a) if boxes[a].overlaps(boxes[b])]
    assert meet == []
