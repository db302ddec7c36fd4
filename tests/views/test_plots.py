"""Plots show the numbers of the result, and their files are whole pictures or not there."""

import re
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.image import imread

from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.errors import SceneError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.measured import read_measurement
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.views.figures import figure_in, new_axes, save
from fenics_mech.views.frequency_views import draw_frequencies, plot_frequencies
from fenics_mech.views.page.page_tables import members
from fenics_mech.views.plots import (
    plot_deflection,
    plot_drive,
    plot_joint_forces,
    plot_spectrum,
    plot_strain,
    plot_strain_map,
)
from fenics_mech.views.reading import Reading
from fenics_mech.views.result_figures import force_figure, map_figure, plot_all, spectrum_figure, strain_figure
from fenics_mech.views.summary import summary
from fenics_mech.views.words import short

MICRO = 1e6


def curves(axes):
    """Points of the labelled curves of some axes between 0 and 360 degrees, by label."""
    found = {}
    for line in axes.get_lines():
        x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
        inside = (x > -1e-9) & (x < 360 - 1e-9)
        found[line.get_label()] = (x[inside], y[inside])
    return found


def at_positions(angle):
    """Find the 24 positions of a result among the angles (degrees) of its smooth curves, which are more."""
    away = np.abs(np.subtract.outer(15.0 * np.arange(24), angle))
    assert away.min(axis=1).max() < 1e-9
    return away.argmin(axis=1)


def measured(result, file, **place):
    """Give the result with a file of measurements in its scene."""
    scene = result.scene.changed(measurements=[{"file": str(file), "member": "coupler"} | place])
    return Result(result.data.assign_attrs(scene=scene.model_dump_json()))


def test_strain_curve_is_the_result_in_microstrain_over_degrees(result):
    axes = plot_strain(result, "coupler", s=0.25, fibre="-")
    found = curves(axes)
    angle, strain = found["with vibration"]
    at = at_positions(angle)
    assert strain[at] == pytest.approx(MICRO * result.strain_at("coupler", 0.25, "-"), rel=1e-12)
    still = result.data["strain_quasi_static"].sel(member="coupler", fibre="-").interp(s=0.25)
    assert found["without vibration"][1][at] == pytest.approx(MICRO * still.to_numpy(), rel=1e-12)
    assert axes.get_title("left") == "Strain of coupler, s = 0.25, \N{MINUS SIGN} side"


def test_strain_is_drawn_where_the_stress_is_largest_with_a_ring(result):
    """Of the crank that is at the drive: at mid-span there is half of it."""
    axes = plot_strain(result, "crank")
    closer = between_positions(result).data.sel(member="crank")
    place = np.unravel_index(np.abs(closer["stress"].to_numpy()).argmax(), closer["stress"].shape)
    at = closer["strain"].to_numpy()[place]
    ring = next(line for line in axes.get_lines() if line.get_marker() == "o")
    assert ring.get_ydata() == pytest.approx([MICRO * at])
    assert float(axes.texts[0].get_text().split()[0]) == pytest.approx(MICRO * at, rel=5e-3)
    assert axes.get_title("left").startswith("Strain of crank, at O, ")
    assert MICRO * abs(at) > 1.8 * np.abs(curves(plot_strain(result, "crank", s=0.5))["with vibration"][1]).max()


def test_plot_summary_details_and_report_name_the_same_strain_angle_and_place(result):
    """Damping lets stress and strain peak at different angles: all name those of the stress, as in the demo."""
    reading = Reading(result)
    assert any(reading.peak(reading.strain, i) != peak for i, peak in enumerate(reading.peaks))
    rows = re.findall(r'<tr data-member="(\d+)">(.*?)</tr>', str(members(reading)))
    cells = {reading.members[int(i)]: re.sub("<[^>]*>", "|", cells) for i, cells in rows}
    for member in reading.members:
        value, angle = plot_strain(result, member).texts[0].get_text().split(" at ")
        rows = [line for line in str(summary(result)).splitlines() if line.startswith(member)]
        told = next(line for line in str(summary(result, details=True)).splitlines() if line.startswith(f" {member} "))
        assert any(f" {value} " in row and f" {angle} " in row for row in rows)
        assert f"|{value}|" in cells[member]
        assert f"|{angle}|" in cells[member]
        peak = reading.peaks[reading.members.index(member)]
        strain = reading.strain[peak.k, peak.i, peak.j, peak.f]
        assert short(strain) == value
        assert told.split()[1].replace(",", "") == f"{strain:.4g}"
        assert f" {angle}, " in told


def test_members_stand_below_one_another_the_most_strained_on_top(result):
    figure = strain_figure(result)
    titles = [axes.get_title("left").split(",")[0] for axes in figure.axes if axes.get_title("left")]
    size = np.abs(result.data["strain"]).max(("theta", "s", "fibre"))
    expected = sorted(("crank", "coupler", "follower"), key=lambda member: -float(size.sel(member=member)))
    assert titles == [f"Strain of {member}" for member in expected]
    shares = [axes.texts[-1].get_text() for axes in figure.axes]
    assert shares[0] == "100% of the largest"


def test_map_has_the_strain_of_every_place_and_one_scale_up_to_the_peak(result):
    figure = map_figure(result)
    closer = between_positions(result).data["strain"]
    largest = MICRO * float(np.abs(closer).max())
    images = [axes.images[0] for axes in figure.axes[:3]]
    assert np.array([image.get_clim() for image in images]) == pytest.approx(np.array([[-largest, largest]] * 3))
    crank = images[0].get_array()
    assert crank.shape == (21, between_positions(result).data.sizes["theta"] + 2)  # and one before and after the turn
    assert np.abs(crank).max() == pytest.approx(largest, rel=2e-3)  # its columns are even, and beside the peak
    lengths = [axes.get_ylim()[1] for axes in figure.axes[:3]]
    assert lengths == pytest.approx([107.95, 279.4, 270.51])
    with pytest.raises(ViewError, match="no member 'rocker'"):
        plot_strain_map(result, "rocker")


def test_axes_that_are_given_are_drawn_into(result):
    for plot in (plot_deflection, plot_joint_forces, plot_drive, plot_frequencies):
        axes = new_axes()
        assert plot(result, axes) is axes
        assert axes.get_lines()
    axes = new_axes()
    assert plot_strain(result, "crank", axes) is plot_strain_map(result, "crank", axes) is axes


def test_spectrum_has_a_bar_for_every_harmonic_and_a_band_for_every_mode(result):
    figure = spectrum_figure(result)
    amplitude = result.data["strain_amplitude"].sel(gauge="peak")
    titles = [axes.get_title("left") for axes in figure.axes]
    assert [title.split(",")[0].split()[-1] for title in titles] == ["crank", "coupler", "follower"]
    heights = [bar.get_height() for bar in figure.axes[1].containers[0]]
    assert heights == pytest.approx(MICRO * amplitude.sel(member="coupler").to_numpy()[1:])
    marked = [text.get_text() for text in figure.axes[0].texts]
    assert marked == ["1", "2"]
    first = float(result.data["frequency"].sel(mode=1).mean()) * result.scene.period
    assert figure.axes[0].texts[0].get_position()[0] == pytest.approx(first, abs=0.5)
    assert figure.axes[-1].get_xlabel().endswith("; bands: natural frequencies over the cycle, by mode")
    slow = Result(result.data.assign(frequency=10 * result.data["frequency"]))
    lowest = 10 * float(result.data["frequency"].min()) * result.scene.period
    said = spectrum_figure(slow).axes[-1].get_xlabel()
    assert said.endswith(f"natural frequencies lie beyond, from {short(lowest)} times the drive on")
    with pytest.raises(ViewError, match="no harmonics"):
        plot_spectrum(Result(result.data.drop_vars("strain_amplitude")), "crank")


def test_bars_of_a_spectrum_do_not_overlap_beside_one_with_many(result):
    """The axis is that of the member with the most harmonics, whatever others have."""
    data = result.data.copy(deep=True)
    few = (data["harmonic"] > 2) & (data["member"] != "follower")
    data["strain_amplitude"] = data["strain_amplitude"].where(~few, 0.0)
    for axes in spectrum_figure(Result(data)).axes:
        bars = [bar.get_window_extent() for bar in axes.containers[0] if bar.get_height()]
        assert all(before.x1 < after.x0 for before, after in pairwise(bars))


def test_curves_close_at_a_full_turn(result):
    line = plot_strain(result, "crank", s=0.5).get_lines()[-1]
    x, y = line.get_xdata(), line.get_ydata()
    assert x.max() == pytest.approx(360)
    assert y[x.argmax()] == y[np.abs(x).argmin()]


def test_a_drive_that_turns_back_is_drawn_from_0_to_360_degrees(result):
    backward = Result(result.data.assign_coords(theta=-result.data["theta"]))
    angle, strain = curves(plot_strain(backward, "coupler", s=0.5))["with vibration"]
    assert (np.diff(angle) > 0).all()
    assert strain[at_positions(angle)][1:] == pytest.approx(MICRO * result.strain_at("coupler")[:0:-1])


def test_measured_points_are_drawn_where_they_were_measured_and_only_there(result, tmp_path):
    file = tmp_path / "gauge.csv"
    file.write_text("angle,strain\n10,1e-4\n-90, -2e-4\n\n")
    with_points = measured(result, file, s=0.25, fibre="-")
    angle, strain = curves(plot_strain(with_points, "coupler", s=0.25, fibre="-"))["measured"]
    assert angle == pytest.approx([10, 270])
    assert strain == pytest.approx([100, -200])
    for member, s, fibre in (("coupler", 0.5, "-"), ("coupler", 0.25, "+"), ("crank", 0.25, "-")):
        assert "measured" not in curves(plot_strain(with_points, member, s=s, fibre=fibre))
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
        plot_all(lost, tmp_path / "lost")
    (tmp_path / "binary.csv").write_bytes(b"a,b\n\xff\xfe,1\n")
    with pytest.raises(SceneError, match=r"binary\.csv"):
        read_measurement(tmp_path / "binary.csv")
    assert not list((tmp_path / "lost").glob("strain_coupler*"))


def test_frequencies_and_the_members_supported_ones(result):
    supported = {member: float(found[0]) for member, found in simply_supported_frequencies(result.scene).items()}
    frequency = result.data["frequency"].to_numpy()
    axes = plot_frequencies(result)
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
    theta = result.data["theta"].to_numpy()
    axes = draw_frequencies(result.data["frequency"].to_numpy(), theta, supported, new_axes())
    height = {text.get_text().split()[0]: text.get_position()[1] for text in axes.texts}
    assert list(height) == ["a", "b", "c", "far"]
    assert np.diff(list(height.values())).min() > 0.049  # of the axes
    assert height["far"] == pytest.approx(axes.transAxes.inverted().transform(axes.transData.transform((0, 50.0)))[1])


def test_labels_of_many_members_are_few_and_inside_the_axes(result):
    supported = {f"twin {n}": 47.5 for n in range(3)} | {f"thick {n}": 800.0 + n for n in range(9)} | {"soft": 1.0}
    axes = draw_frequencies(result.data["frequency"].to_numpy(), result.data["theta"].to_numpy(), supported, new_axes())
    texts = [text.get_text() for text in axes.texts]
    assert texts == [
        "soft 1 Hz \N{DOWNWARDS ARROW}",
        "twin 0 and 2 more 47.5 Hz",
        "thick 0 800 Hz \N{UPWARDS ARROW}",
        "thick 1 801 Hz \N{UPWARDS ARROW}",
        "7 more \N{UPWARDS ARROW}",
    ]
    heights = [text.get_position()[1] for text in axes.texts]
    assert max(heights) <= 1.001
    assert np.diff(heights).min() > 0.049


def test_joint_forces_and_torque(result):
    upper, lower = force_figure(result).axes
    found = curves(upper)
    force = result.data["joint_force"].sel(joint="B")
    at = at_positions(found["joint B"][0])
    assert found["joint B"][1][at] == pytest.approx(np.hypot(force.sel(component="x"), force.sel(component="y")))
    assert {"joint O", "joint A", "joint B", "joint C"} <= set(found)
    assert lower.get_lines()[0].get_ydata()[1:-1][at] == pytest.approx(result.data["input_torque"].to_numpy())


def test_deflections_have_the_places_and_values_of_the_summary(result):
    axes = plot_deflection(result)
    found, reading = curves(axes), Reading(result)
    told = [text.get_text().split(" at ") for text in axes.texts]
    for i, member in enumerate(reading.members):
        peak = reading.peak(reading.bent, i)
        rows = [line for line in str(summary(result)).splitlines() if line.startswith(member)]
        assert any(f" {told[i][0]}  {reading.place(peak).removeprefix('at ')}" in row for row in rows)
        values = np.linalg.norm(result.data["deflection"].sel(member=member).isel(s=peak.j), axis=-1)
        angle, bent = found[f"{member}, {reading.place(peak)}"]
        assert bent[at_positions(angle)] == pytest.approx(1e3 * values, rel=5e-3, abs=1e-2)
    rings = [line for line in axes.get_lines() if line.get_marker() == "o"]
    assert [float(ring.get_ydata()[0]) for ring in rings] == pytest.approx(reading.bent.max(axis=(0, 2, 3)))


def test_all_plots_are_written_and_none_is_blank(result, tmp_path):
    paths = plot_all(result, tmp_path / "new" / "folder")
    assert [path.stem for path in paths] == [
        "strain",
        "strain_map",
        "deflection",
        "section_forces",
        "joint_forces",
        "force_paths",
        "point_paths",
        "spectrum",
        "frequencies",
    ]
    for path in paths:
        picture = imread(path)
        assert picture.shape[1] == 1152
        assert (picture[..., :3] < 0.9).any(axis=-1).mean() > 0.005  # ink
    assert {path.name for path in (tmp_path / "new" / "folder").iterdir()} == {path.name for path in paths}


@pytest.mark.parametrize("ending", [".pdf", ".svg"])
def test_vector_formats(result, tmp_path, ending):
    (path,) = plot_all(result, tmp_path, ["strain"], ending)
    assert path.name == f"strain{ending}"
    assert path.stat().st_size > 5000


def test_bad_requests_are_refused(result, tmp_path):
    with pytest.raises(ViewError, match=r"\.png, \.pdf, \.svg"):
        save(figure_in(new_axes()), tmp_path / "strain.bmp")
    with pytest.raises(ViewError, match=r"\.png, \.pdf, \.svg, not in '\.bmp'"):
        plot_all(result, tmp_path, ending=".bmp")
    with pytest.raises(ViewError, match="no plot 'strains'; there are strain, strain_map, "):
        plot_all(result, tmp_path, ["strains"])
    with pytest.raises(ViewError, match="no member 'rocker'; it has crank, coupler, follower"):
        plot_strain(result, "rocker")
    with pytest.raises(ViewError, match="no fibre 'top'"):
        plot_strain(result, "crank", s=0.5, fibre="top")
    (tmp_path / "file").touch()
    with pytest.raises(ViewError, match="cannot make the folder"):
        plot_all(result, tmp_path / "file" / "folder")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
