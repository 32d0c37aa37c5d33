"""What all figures have: inputs, legends that hide nothing, units, looks, files that are the same on every run."""
import subprocess
import sys

import matplotlib
import numpy as np
import pytest

import sonopack
from sonopack import plot
from sonopack.plot import _frame, _inputs, _units
from sonopack.plot.kinds import KINDS

matplotlib.use("agg")
T = np.linspace(0, 9, 50)


def wave(**more):
    return sonopack.Table.from_columns({"t": T, "F": np.sin(T)}, more.pop("units", None), more)


def drawn_legend(ax):
    ax.figure.draw_without_rendering()
    return ax.get_legend().get_window_extent()


@pytest.mark.filterwarnings("ignore:.*first front")
@pytest.mark.parametrize("label", ["short", "a label that is much longer than the figure is wide, and then some more " * 2])
def test_legends_hide_no_data_and_are_not_cut(label):
    ax = plot.signal(wave(), wave(), labels=[label, "other"])
    box, page = drawn_legend(ax), ax.figure.bbox
    assert page.x0 <= box.x0 and box.x1 <= page.x1 + 1 and box.y1 <= page.y1 + 1
    inside = ax.get_window_extent().overlaps(box.padded(-2))
    assert not inside or _frame.Obstacles(ax).leave(box)
    shown = "".join(ax.get_legend().get_texts()[0].get_text().split())
    assert shown == "".join(label.split())


@pytest.mark.filterwarnings("ignore:.*first front")
def test_objects_that_make_a_figure(tmp_path):
    import pandas
    path = tmp_path / "wave.csv"
    path.write_text("t,F\n" + "".join(f"{t},{np.sin(t)}\n" for t in T))
    structured = np.zeros(50, [("t", float), ("F", float)])
    structured["t"], structured["F"] = T, np.sin(T)
    for data in (wave(), pandas.DataFrame({"t": T, "F": np.sin(T)}), structured, {"t": T, "F": np.sin(T)}, path, str(path)):
        assert np.allclose(plot.signal(data).lines[0].get_ydata(), np.sin(T))


@pytest.mark.filterwarnings("ignore:.*first front")
def test_given_axes_are_drawn_on():
    import matplotlib.pyplot
    fig, axes = matplotlib.pyplot.subplots(1, 2)
    assert plot.signal(wave(), ax=axes[1]) is axes[1] and not axes[0].lines
    with pytest.raises(sonopack.InvalidInput, match="2 panels"):
        plot.wave(wave(), ax=axes[0]) if "k" in wave() else _frame.panels(2, 1, ax=axes[0])
    matplotlib.pyplot.close(fig)


@pytest.mark.filterwarnings("ignore:.*first front")
@pytest.mark.parametrize("ending", [".svg", ".pdf", ".png"])
def test_files_are_the_same_on_every_run(tmp_path, ending):
    for name in ("a", "b"):
        _frame.save(plot.signal(wave()).figure, tmp_path / f"{name}{ending}")
    assert (tmp_path / f"a{ending}").read_bytes() == (tmp_path / f"b{ending}").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"a{ending}", f"b{ending}"]


def test_a_notebook_shows_signals_and_packings(source):
    packing = sonopack.Packing.make(sonopack.Scene(packing={"grains": 30, "width": 5}))
    for thing in (packing, packing.network().signal()):
        assert thing._repr_png_().startswith(b"\x89PNG")
    assert packing.plot("signal").get_xlabel().startswith("$t$")


@pytest.mark.parametrize("unit, text", [
    ("us", "µs"), ("m/s", "m/s"), ("m^2", "m$^{2}$"), ("E*", "$E^*$"), ("1/d", "$1/d$"), ("V $x", r"V \$x"),
    ("d/sqrt(E*/rho)", r"$d\,(\rho/E^*)^{1/2}$")])
def test_units_as_text(unit, text):
    assert _units.unit_text(unit) == text


@pytest.mark.parametrize("value, error, text", [(0.1663, 0.0041, "0.166(4)"), (0.152, 0.017, "0.152(17)"),
                                                (0.5, float("nan"), "0.5"), (12.3, 4.0, "12(4)")])
def test_values_with_errors(value, error, text):
    assert _units.measured(value, error) == text


def test_settings_that_differ_name_tables():
    made = [wave(**{"packing.friction": mu, "packing.pressure": 1e-4}) for mu in (0.2, 0.5)]
    assert _inputs.names(_inputs.inputs(made)) == [r"$\mu$ = 0.2", r"$\mu$ = 0.5"]


def test_a_start_loads_no_matplotlib():
    code = "import sys, sonopack.plot.command as c; c.parser(); sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_kind_has_its_function():
    for name, kind in KINDS.items():
        assert callable(kind.function(name)) and getattr(plot, name) is kind.function(name)
        assert kind.function(name).__doc__
