"""Plots show the numbers of the result, and their files are whole pictures or not there."""

import numpy as np
import pytest
from matplotlib.image import imread

from fenics_mech.eigenmodes import simply_supported_frequencies
from fenics_mech.errors import SceneError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.views.measured import read_measurement
from fenics_mech.views.plots import (
    deflection_figure,
    frequency_figure,
    joint_force_figure,
    plot_all,
    plot_strain,
    spectrum_figure,
    strain_figure,
)

MICRO = 1e6


def curves(axes):
    """Points of the labelled curves of some axes between 0 and 360 degrees, by label."""
    found = {}
    for line in axes.get_lines():
        x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
        inside = (x > -1e-9) & (x < 360 - 1e-9)
        found[line.get_label()] = (x[inside], y[inside])
    return found


def measured(result, file, **place):
    """Give the result with a file of measurements in its scene."""
    scene = result.scene.changed(measurements=[{"file": str(file), "member": "coupler"} | place])
    return Result(result.data.assign_attrs(scene=scene.model_dump_json()))


def test_strain_curve_is_the_result_in_microstrain_over_degrees(result):
    theta = np.linspace(0, 2 * np.pi, 50)
    figure = strain_figure(result, "coupler", s=0.25, fibre="-", rigid=(theta, np.sin(theta), "by hand"))
    found = curves(figure.axes[0])
    angle, strain = found["with vibration"]
    assert angle[::30] == pytest.approx(np.arange(24) * 15.0)  # smooth between 24 positions
    assert strain[::30] == pytest.approx(MICRO * result.strain_at("coupler", 0.25, "-"), rel=1e-12)
    assert found["by hand"][1].max() == pytest.approx(MICRO, rel=1e-2)
    assert "coupler" in figure.axes[0].get_title("left")


def test_spectrum_has_a_bar_for_every_harmonic_and_a_band_for_every_mode(result):
    figure = spectrum_figure(result)
    amplitude = result.data["strain_amplitude"].sel(gauge="mid-span")
    assert [axes.get_title("left").split()[-1] for axes in figure.axes] == ["crank", "coupler", "follower"]
    heights = [bar.get_height() for bar in figure.axes[1].containers[0]]
    assert heights == pytest.approx(MICRO * amplitude.sel(member="coupler").to_numpy()[1:])
    marked = [text.get_text() for text in figure.axes[0].texts]
    assert marked == ["1", "2"]
    first = float(result.data["frequency"].sel(mode=1).mean()) * result.scene.period
    assert figure.axes[0].texts[0].get_position()[0] == pytest.approx(first, abs=0.5)


def test_curves_close_at_a_full_turn(result):
    line = strain_figure(result, "crank").axes[0].get_lines()[0]
    x, y = line.get_xdata(), line.get_ydata()
    assert x.max() == pytest.approx(360)
    assert y[x.argmax()] == y[np.abs(x).argmin()]


def test_a_drive_that_turns_back_is_drawn_from_0_to_360_degrees(result):
    backward = Result(result.data.assign_coords(theta=-result.data["theta"]))
    angle, strain = curves(strain_figure(backward, "coupler").axes[0])["with vibration"]
    assert (np.diff(angle) > 0).all()
    assert strain[30::30] == pytest.approx(MICRO * result.strain_at("coupler")[:0:-1])  # smooth between 24 positions


def test_measured_points_are_drawn_where_they_were_measured_and_only_there(result, tmp_path):
    file = tmp_path / "gauge.csv"
    file.write_text("angle,strain\n10,1e-4\n-90, -2e-4\n\n")
    with_points = measured(result, file, s=0.25, fibre="-")
    angle, strain = curves(strain_figure(with_points, "coupler", s=0.25, fibre="-").axes[0])["measured"]
    assert angle == pytest.approx([10, 270])
    assert strain == pytest.approx([100, -200])
    for member, s, fibre in (("coupler", 0.5, "-"), ("coupler", 0.25, "+"), ("crank", 0.25, "-")):
        assert "measured" not in curves(strain_figure(with_points, member, s=s, fibre=fibre).axes[0])
    names = {path.name for path in plot_all(with_points, tmp_path / "plots")}
    assert "strain_coupler_s0.25_minus.png" in names


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("angle,strain\n1,2\n3,oops\n", 3, "not two finite numbers"),
        ("angle,strain\n1,2,3\n", 2, "not two finite numbers"),
        ("angle,strain\n\n1\n", 3, "not two finite numbers"),
        ("angle,strain\n1,nan\n", 2, "not two finite numbers"),
        ("angle,strain\n", None, "no measured points"),
    ],
)
def test_bad_measurements_are_refused_with_file_and_line(tmp_path, text, line, said):
    file = tmp_path / "gauge.csv"
    file.write_text(text)
    with pytest.raises(SceneError, match=r"gauge\.csv") as caught:
        read_measurement(file)
    assert caught.value.line == line
    assert said in str(caught.value)
    assert "oops" not in str(caught.value)  # what a file holds is not told: the scene may name any file


def test_measurements_that_cannot_be_read_leave_no_plot(result, tmp_path):
    lost = measured(result, tmp_path / "lost.csv")
    with pytest.raises(SceneError, match=r"lost\.csv.*No such file"):
        plot_strain(lost, "coupler", tmp_path / "strain.png")
    (tmp_path / "binary.csv").write_bytes(b"a,b\n\xff\xfe,1\n")
    with pytest.raises(SceneError, match=r"binary\.csv"):
        read_measurement(tmp_path / "binary.csv")
    assert not (tmp_path / "strain.png").exists()


def test_frequencies_and_the_members_supported_ones(result):
    supported = {member: float(found[0]) for member, found in simply_supported_frequencies(result.scene).items()}
    frequency = result.data["frequency"].to_numpy()
    axes = frequency_figure(frequency, result.data["theta"].to_numpy(), supported).axes[0]
    found = curves(axes)
    for mode in (1, 2):
        assert found[f"mode {mode}"][1] == pytest.approx(frequency[:, mode - 1])
    dashed = [line.get_ydata()[0] for line in axes.get_lines() if line.get_linestyle() == "--"]
    assert sorted(dashed) == pytest.approx([supported["coupler"], supported["follower"]])
    labels = {text.get_text().split()[0]: text for text in axes.texts}
    assert labels.keys() == supported.keys()
    assert "848.3 Hz \N{UPWARDS ARROW}" in labels["crank"].get_text()  # out of the modes' range


def test_labels_of_close_frequencies_do_not_lie_upon_another(result):
    supported = {"c": 47.7, "a": 47.5, "b": 47.6, "far": 50.0}
    axes = frequency_figure(result.data["frequency"].to_numpy(), result.data["theta"].to_numpy(), supported).axes[0]
    height = {text.get_text().split()[0]: text.get_position()[1] for text in axes.texts}
    assert list(height) == ["a", "b", "c", "far"]
    assert np.diff(list(height.values())).min() > 0.049  # of the axes
    assert height["far"] == pytest.approx(axes.transAxes.inverted().transform(axes.transData.transform((0, 50.0)))[1])


def test_joint_forces_and_torque(result):
    upper, lower = joint_force_figure(result).axes
    found = curves(upper)
    force = result.data["joint_force"].sel(joint="B")
    assert found["joint B"][1][::30] == pytest.approx(np.hypot(force.sel(component="x"), force.sel(component="y")))
    assert set(found) == {"joint O", "joint A", "joint B", "joint C"}
    assert lower.get_lines()[0].get_ydata()[1:-1][::30] == pytest.approx(result.data["input_torque"].to_numpy())


def test_deflection_of_the_crank_is_along_its_normal(result):
    found = curves(deflection_figure(result).axes[0])
    theta = result.data["theta"].to_numpy()  # the crank's own angle
    x, y = result.data["deflection"].sel(member="crank", s=0.5).to_numpy().T
    assert found["crank"][1][::30] == pytest.approx(1e3 * (-np.sin(theta) * x + np.cos(theta) * y))
    assert np.abs(found["crank"][1]).max() > 0.05


def test_all_plots_are_written_and_none_is_blank(result, tmp_path):
    paths = plot_all(result, tmp_path / "new" / "folder")
    assert [path.stem for path in paths] == [
        "strain_crank", "strain_coupler", "strain_follower", "deflection", "joint_forces", "spectrum", "frequencies",
    ]  # fmt: skip
    for path in paths:
        picture = imread(path)
        assert picture.shape[1] == 1152
        assert (picture[..., :3] < 0.9).any(axis=-1).mean() > 0.005  # ink
    assert {path.name for path in (tmp_path / "new" / "folder").iterdir()} == {path.name for path in paths}


@pytest.mark.parametrize("ending", [".pdf", ".svg"])
def test_vector_formats(result, tmp_path, ending):
    path = plot_strain(result, "crank", tmp_path / f"strain{ending}")
    assert path.stat().st_size > 5000


def test_bad_requests_are_refused(result, tmp_path):
    with pytest.raises(ViewError, match=r"\.png, \.pdf, \.svg"):
        plot_strain(result, "crank", tmp_path / "strain.bmp")
    with pytest.raises(ViewError, match="no member 'rocker'; it has crank, coupler, follower"):
        plot_strain(result, "rocker", tmp_path / "strain.png")
    with pytest.raises(ViewError, match="no fibre 'top'"):
        plot_strain(result, "crank", tmp_path / "strain.png", fibre="top")
    (tmp_path / "file").touch()
    with pytest.raises(ViewError, match="cannot make the folder"):
        plot_all(result, tmp_path / "file" / "folder")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
