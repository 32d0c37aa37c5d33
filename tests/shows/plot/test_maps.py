"""Pictures of packings, motions and heat maps, looked at as Axes."""
import matplotlib
import numpy as np
import pytest
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.quiver import Quiver

import sonopack
from sonopack import plot
from sonopack.plot import _view, command, maps
from sonopack.plot._inputs import Input
from sonopack.plot._motion import find_mode

matplotlib.use("agg")
GLASS = sonopack.Material(70e9, 0.22, 2500.0, 1e-3)


def made(**keys):
    return sonopack.Packing.make(sonopack.Scene(packing={"grains": 60, "width": 6, "seed": 3, "friction": 0.5, **keys}))


@pytest.fixture(scope="module")
def flat():
    return made()


@pytest.fixture(scope="module")
def solid():
    return made(dimension=3, width=5, grains=120)


def only(ax, kind):
    found = [one for one in ax.collections if type(one) is kind]
    assert len(found) == 1
    return found[0]


def key_texts(ax):
    legend = ax.figure.legends[0] if ax.figure.legends else ax.get_legend()
    return [text.get_text() for text in legend.get_texts()] + [legend.get_title().get_text()]


# ---- networks -------------------------------------------------------------------------------------------------------

def test_widths_of_lines_are_forces_and_the_key_has_them(flat):
    ax = plot.network(flat)
    lines, forces = only(ax, LineCollection), flat.contacts["fn"][flat.carrying()]
    widths = np.unique(np.round(lines.get_linewidths(), 9))
    assert np.allclose(widths, np.unique(np.round(forces / forces.max() * widths[-1], 9)))
    entries = dict(zip(key_texts(ax), ax.figure.legends[0].get_lines()))
    mean = next(line for text, line in entries.items() if text.startswith("mean"))
    assert mean.get_linewidth() == pytest.approx(widths[-1] * forces.mean() / forces.max(), rel=1e-6)
    assert any(text.endswith(r"$E^*\,d^2$") for text in entries)


def test_grains_are_as_large_as_they_are_and_rattlers_grey(flat):
    discs, rattlers = only(plot.network(flat), EllipseCollection), flat.rattlers()
    assert set(np.round(discs._widths * 2, 12)) == set(np.round(2 * flat.r, 12))  # EllipseCollection keeps halves
    grey = np.all(np.isclose(discs.get_facecolors()[:, :3], matplotlib.colors.to_rgb(_view.RATTLER)), axis=1)
    assert set(np.round(2 * discs._widths[grey], 12)) == set(np.round(2 * flat.r[rattlers], 12))


def test_images_at_periodic_edges(flat):
    """A disc that reaches over an edge is seen at both."""
    discs, width = only(plot.network(flat), EllipseCollection), flat.box[0]
    x, r = discs.get_offsets()[:, 0], 2 * discs._widths / 2
    over = np.sum((flat.x[:, 0] % width < flat.r) | (flat.x[:, 0] % width > width - flat.r))
    assert len(x) == flat.n + over and over > 0
    assert np.all((x + r > 0) & (x - r < width))


def test_forces_in_si(flat):
    texts = key_texts(plot.network(flat, material=GLASS))
    forces = flat.contacts["fn"][flat.carrying()] * 73560.3194619588  # E* d^2 of GLASS [N]
    assert f"largest $F_\\mathrm{{n}}$ = {forces.max():.3g} N" in texts


def test_stiffnesses_are_those_of_the_network(flat):
    springs = flat.network().springs
    text = next(text for text in key_texts(plot.stiffness(flat)) if text.startswith("largest"))
    assert f"{springs['kn'].max():.3g}" in text and text.endswith(r"$E^*\,d$")


def test_three_views_of_spheres(solid):
    axes = plot.network(solid)
    assert [(ax.get_xlabel()[1], ax.get_ylabel()[1]) for ax in axes] == [("x", "z"), ("y", "z"), ("x", "y")]
    for ax, (width, height) in zip(axes, ((0, 2), (1, 2), (0, 1))):
        assert ax.get_xlim()[1] == pytest.approx(solid.box[width], rel=1e-9)
        assert ax.get_ylim()[1] >= solid.box[height]
    fills = only(axes[0], EllipseCollection).get_facecolors()[:, :3].mean(axis=1)
    assert fills[-1] < fills[0]  # the nearest is drawn last, the farthest is palest


@pytest.mark.parametrize("cell", ["periodic", "box"])
def test_other_cells(cell):
    packing = made(cell=cell)
    ax = plot.network(packing)
    walls = [patch for patch in ax.patches if patch.get_facecolor()[:3] == matplotlib.colors.to_rgb(_view.WALL)]
    assert len(walls) == (4 if cell == "box" else 0)
    assert only(ax, EllipseCollection).get_offsets().shape[0] >= packing.n


def test_given_axes_and_rows_of_lines(flat):
    from matplotlib.figure import Figure
    ax = Figure().subplots()
    assert plot.network(flat, ax=ax) is ax and ax.get_legend() is not None and ax.get_aspect() == 1
    assert flat.plot().figure is not ax.figure


def test_many_disks_become_an_image_in_vector_figures(tmp_path, flat, monkeypatch):
    monkeypatch.setattr(_view, "MANY", 10)
    ax = plot.network(flat)
    assert only(ax, EllipseCollection).get_rasterized() and only(ax, LineCollection).get_rasterized()
    plot.save(ax.figure, tmp_path / "x.svg")
    assert b"<image" in (tmp_path / "x.svg").read_bytes()


# ---- histograms of contacts -----------------------------------------------------------------------------------------

def direction_table(**more):
    angle = np.arange(0, 180, 5.0)
    return sonopack.Table.from_columns({"angle": angle, "all": 1 + 0.5 * np.cos(2 * np.deg2rad(angle))}, None, more)


def test_directions_are_arcs_of_the_bins_of_both_sides():
    ax = plot.angles(direction_table(contacts=1e6, dimension=2))
    around, radii = ax.lines[0].get_data()
    for degrees, density in ((0, 1.5), (90, 0.5), (180, 1.5), (270, 0.5), (45, 1.0)):
        assert np.interp(np.deg2rad(degrees), around, radii) == pytest.approx(density, abs=1e-12)
    assert "radius: density, isotropic 1" in key_texts(ax)


def test_bins_of_few_contacts_are_merged(flat):
    few, many = (plot.angles(direction_table(contacts=n, dimension=2)).lines[0].get_ydata() for n in (50, 1e6))
    assert len(np.unique(few)) < len(np.unique(many)) and few.max() < many.max()
    assert plot.angles(made(grains=120)).name == "polar"


def test_directions_in_space_are_a_quarter(solid):
    table = direction_table(contacts=1e6, dimension=3)
    ax = plot.angles(table)
    assert (ax.get_thetamin(), ax.get_thetamax()) == (0, 90)


def test_histograms_have_area_one_and_errors():
    one, two = made(grains=120), made(grains=120, seed=4)
    from matplotlib.patches import StepPatch
    alone, both = plot.forces(one), plot.forces(one, two)
    for ax in (alone, both):
        for steps in (patch for patch in ax.patches if isinstance(patch, StepPatch)):
            values, edges, _ = steps.get_data()
            assert np.sum(values * np.diff(edges)) == pytest.approx(1, abs=0.02)
    assert not alone.containers and len(both.containers) == 2


# ---- sensitivities and grains ---------------------------------------------------------------------------------------

def test_sensitivity_has_symbol_and_unit(flat):
    gradient = flat.network().sensitivity("t10")
    values = gradient.kn * flat.network().springs["kn"] + gradient.kt * flat.network().springs["kt"]
    for ax in (plot.sensitivity(flat), plot.sensitivity(flat, gradient)):
        lines, texts = only(ax, LineCollection), key_texts(ax)
        colours = lines.get_colors()[:, :3]
        later = np.all(np.isclose(colours, matplotlib.colors.to_rgb(_view.LATER)), axis=1)
        assert 0 < later.sum() < len(later)
        assert "stiffer: $t_{10}$ larger" in texts
        widest = next(text for text in texts if text.startswith("widest"))
        assert f"{np.abs(values).max():.3g}" in widest and widest.endswith(r"$d\,(\rho/E^*)^{1/2}$")
        assert np.all(np.diff(lines.get_linewidths()) >= -1e-12)  # large ones lie on top


def test_clusters_have_colours(flat):
    found = flat.network().clusters(sliding_at=0.3)
    for ax in (plot.clusters(flat, found), plot.clusters(flat)):
        lines, texts = only(ax, LineCollection), key_texts(ax)
        assert "cluster 0" in texts
    assert np.ptp(lines.get_linewidths()) == 0 and "redundant" in texts  # all is one cluster


@pytest.mark.parametrize("quantity, symbol", [("t10", "t_{10}"), ("omega:9", r"\omega_{9}^2"), ("C22", "C_{22}"),
                                              ("omega:3-5", r"\langle\omega^2\rangle"), ("c_l", "c_l")])
def test_symbols_of_quantities(quantity, symbol):
    from sonopack.plot.packing import symbol_of
    assert symbol_of(quantity) == symbol


def test_grains_have_a_colour_bar_with_a_unit(flat):
    n = flat.n
    values = np.linspace(-1, 2, n)
    table = sonopack.Table.from_columns({"grain": np.arange(n), "by_mass": values}, {"by_mass": "d/sqrt(E* / rho)"},
                                        {"quantity": "t10"})
    ax = plot.grains(flat, table)
    bar = next(one for one in ax.figure.axes if one is not ax)
    assert bar.get_xlabel() == r"$\partial t_{10}/\partial\ln m$  [$d\,(\rho/E^*)^{1/2}$]"
    assert bar.get_xlim() == pytest.approx((-2, 2))
    assert len(np.unique(only(ax, EllipseCollection).get_facecolors(), axis=0)) > n / 2


def test_factors_are_on_a_scale_of_logarithms(flat):
    factors = np.where(np.arange(flat.n) % 2, 2.0, 0.5)
    ax = plot.grains(flat, {"grain": np.arange(flat.n), "factor": factors})
    bar = next(one for one in ax.figure.axes if one is not ax)
    assert bar.get_xscale() == "log" and bar.get_xlim() == pytest.approx((0.5, 2))


def test_signed_colours_differ_in_grey_print():
    rgb = _view.SIGNED([0.0, 1.0])[:, :3]
    low, high = rgb @ (0.2126, 0.7152, 0.0722)
    assert high - low > 0.1


# ---- motions --------------------------------------------------------------------------------------------------------

def test_arrows_of_a_mode_are_its_displacements(flat):
    modes = flat.network().modes(lowest=1)
    arrows = only(plot.mode(modes), Quiver)
    moves = modes.displacement(modes.n_zero)[:, :2]
    expected = 1.5 * 2 * flat.r.mean() * np.linalg.norm(moves, axis=1).max() / np.linalg.norm(moves, axis=1).max()
    assert np.hypot(arrows.U, arrows.V).max() == pytest.approx(expected)
    drawn = set(np.round(np.arctan2(arrows.V, arrows.U), 6))
    assert set(np.round(np.arctan2(moves[:, 1], moves[:, 0]), 6)) == drawn


def test_a_mode_by_its_number_and_in_si(flat):
    modes = flat.network().modes()
    number = modes.n_zero + 2
    title = key_texts(plot.mode(flat, mode=number, material=GLASS))[-1]
    omega = modes.omega[number] * 5424401.145267883  # of GLASS [rad/s]
    mantissa, exponent = f"{omega:.3e}".split("e")
    assert f"$n$ = {number}," in title and title.endswith("rad/s")
    assert mantissa.rstrip("0") in title and (f"10^{{{int(exponent)}}}" in title or f"{omega:.4g}" in title)


def test_movies_are_of_one_size_and_a_period(flat):
    found = [np.ravel(ax)[0] for ax in plot.mode(flat, frames=4)]
    assert len({tuple(ax.figure.get_size_inches()) for ax in found}) == 1
    parts = [key_texts(ax)[-1].rsplit("=", 1)[1].strip() for ax in found]
    assert parts == ["0.00 $T$", "0.25 $T$", "0.50 $T$", "0.75 $T$"]
    lengths = [np.hypot(*(getattr(only(ax, Quiver), name) for name in "UV")).max() for ax in found]
    assert lengths[1] < 1e-9 < lengths[0] == pytest.approx(lengths[2])


def test_snapshots_of_a_network_and_of_displacements(flat):
    network = flat.network()
    u = network.field([30.0])[0]
    computed, given = plot.snapshot(flat, time=30.0), plot.snapshot(network, u, time=30.0)
    for one, two in zip((c for c in computed.collections if isinstance(c, Quiver)),
                        (c for c in given.collections if isinstance(c, Quiver))):
        assert np.allclose(one.U, two.U) and np.allclose(one.V, two.V)
    assert key_texts(computed)[-1].startswith("$t$ = 30 ")
    assert any("longer, cut" in text for text in key_texts(computed))


def test_arrows_stay_between_the_walls(flat):
    ax = plot.snapshot(flat)
    for arrows in (one for one in ax.collections if isinstance(one, Quiver)):
        if len(arrows.U):
            y = arrows.XY[:, 1]
            ends = np.concatenate([y, y + arrows.V])
            assert ends.min() > -1e-9 and ends.max() < flat.height + 1e-9


# ---- heat maps ------------------------------------------------------------------------------------------------------

def branch_table(**units):
    k, omega = np.meshgrid(np.arange(1, 9) * 0.25, np.linspace(0.005, 1.0, 200), indexing="ij")
    s = 1 / ((omega - 0.4 * np.sin(0.5 * k))**2 + 0.02**2) + 30 * (np.abs(omega - 0.95) < 0.01)
    return {"polarization": np.full(k.size, "longitudinal"), "k": k.ravel(), "omega": omega.ravel(), "S": s.ravel()}


def test_ridges_follow_a_branch_and_do_not_jump():
    data = branch_table()
    grid = data["S"].reshape(8, 200).T.copy()
    grid[190, 3] = 2 * grid.max()  # one cell of another branch
    path = np.linspace(0.005, 1.0, 200)[maps.ridge(grid)]
    assert np.allclose(path, 0.4 * np.sin(0.125 * np.arange(1, 9)), atol=0.006)


def test_a_map_of_waves_has_a_ridge_and_a_colour_bar_with_a_unit():
    table = sonopack.Table.from_columns(branch_table(), {"k": "1/d", "omega": "sqrt(E* / rho)/d",
                                                         "S": "d/sqrt(E* / rho)"})
    ax = plot.dispersion(table)
    line = next(one for one in ax.lines if one.get_label() == "ridge")
    assert np.allclose(line.get_ydata(), 0.4 * np.sin(0.5 * line.get_xdata()), atol=0.006)
    bar = next(one for one in ax.figure.axes if one is not ax)
    assert bar.get_ylabel() == r"$S(k, \omega)$  [$d\,(\rho/E^*)^{1/2}$]" and bar.get_yscale() == "log"
    lightness = ax.collections[0].get_cmap()(np.linspace(0, 1, 9))[:, :3] @ (0.2126, 0.7152, 0.0722)
    assert np.all(np.diff(lightness) > 0)


def test_a_spectrogram_finds_the_frequency_of_a_chirp():
    t = np.linspace(0, 400, 4000)
    table = sonopack.Table.from_columns({"t": t, "F": np.sin(0.5 * t + 0.001 * t**2)},
                                        {"t": "d/sqrt(E* / rho)", "F": "E* d^2"})
    ax = plot.spectrogram(table)
    line = next(one for one in ax.lines if one.get_label() == "ridge")
    x, y = line.get_xdata(), line.get_ydata()
    assert np.allclose(y, 0.5 + 0.002 * x, atol=0.05)
    bar = next(one for one in ax.figure.axes if one is not ax)
    assert "[" in bar.get_ylabel() and ax.get_ylabel() == r"$\omega$  [$(E^*/\rho)^{1/2}/d$]"
    energy = np.mean(np.sin(0.5 * t + 0.001 * t**2)**2)  # Parseval: the density over omega adds up to the mean square
    omega, times, power = maps._spectrum(Input(table), maps.traces_of(Input(table))[0])
    assert np.mean(power.sum(axis=0) * (omega[1] - omega[0])) == pytest.approx(energy, rel=0.02)


def test_a_map_of_local_moduli_has_them_at_their_places():
    i, j = np.tile([0, 1, 2], 2), np.repeat([0, 1], 3)  # x first, in a tilted cell
    columns = {"x": 1.0 + 2 * i + 0.5 * j, "y": 1.5 + 3 * j, "G": 10.0 * i + j}
    table = sonopack.Table.from_columns(columns, {"x": "d", "y": "d", "G": "E*"}, {"edge_x": 2, "edge_y": 3})
    cells = plot.local(table).collections[0]
    middle = 0.25 * sum(cells.get_coordinates()[a:2 + a, b:3 + b] for a in (0, 1) for b in (0, 1))
    assert np.allclose(middle.reshape(-1, 2), np.column_stack([columns["x"], columns["y"]]))
    assert np.array_equal(np.ravel(cells.get_array()), columns["G"])
    assert np.ptp(cells.get_coordinates()[0, :, 0]) == 6
    with pytest.raises(sonopack.SonopackError, match="two dimensions"):
        plot.local(sonopack.Table.from_columns({**columns, "z": i}))


# ---- files of the command -------------------------------------------------------------------------------------------

@pytest.fixture
def folder(tmp_path, flat):
    flat.save(tmp_path / "p.h5")
    flat.network().modes().save(tmp_path / "m.h5")
    find_mode([Input(flat)], None, None).table().save(tmp_path / "mode.tsv")
    return tmp_path


@pytest.fixture
def draw(folder, monkeypatch):
    """Runs `sonopack plot`, in this process."""
    monkeypatch.chdir(folder)
    return lambda *words: command.run(command.parser().parse_intermixed_args(words))


def test_tables_of_displacements_are_read_back(draw, folder):
    for kind, given in (("mode", "m.h5"), ("mode", "mode.tsv")):
        draw(kind, "p.h5", given, "-o", f"{given}.svg")
    draw("mode", "p.h5", "-o", "own.svg", "--table", "u.tsv")
    assert len({(folder / name).read_bytes() for name in ("m.h5.svg", "mode.tsv.svg", "own.svg")}) == 1
    assert (folder / "u.tsv").read_text() == (folder / "mode.tsv").read_text()
    draw("snapshot", "p.h5", "-o", "s.png", "--table", "s.tsv", "--time", "20")
    draw("snapshot", "p.h5", "s.tsv", "-o", "t.png")
    assert (folder / "s.png").read_bytes() == (folder / "t.png").read_bytes()


def test_movies_are_numbered(draw, folder):
    draw("snapshot", "p.h5", "--frames", "2", "-o", "w-%03d.png")
    draw("mode", "p.h5", "--frames", "2", "-o", "m.png")
    assert {"w-001.png", "w-002.png", "m-0001.png", "m-0002.png"} <= {path.name for path in folder.iterdir()}
