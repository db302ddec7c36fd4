"""Pictures and words of sweeps, made up: units as written, points outside the theory, points that failed."""

import io
import json
import re

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import PathCollection
from rich.console import Console

from fenics_mech import load
from fenics_mech.cli import app
from fenics_mech.studies.kept_points import TEXTS
from fenics_mech.studies.sweep import Sweep
from fenics_mech.studies.sweep import sweep as run_sweep
from fenics_mech.studies.sweep_axes import parse_axes
from fenics_mech.views.judgements import theory
from fenics_mech.views.sweep_data import distances, gains, raised, resonances, theory_levels
from fenics_mech.views.sweep_plots import (
    NAME,
    _apart,
    campbell_figure,
    force_figure,
    response_figure,
    strain_map,
    waterfall_figure,
)
from fenics_mech.views.sweep_summary import sweep_summary
from tests.common import DEMOS, ROOT, analysed

SPEEDS = "drive.speed=100 rpm:600 rpm:11"
RATIOS = "damping.ratio=0.01:0.05:5"


@pytest.fixture
def made(seed):
    """Make a sweep of plausible numbers over fields of the seed four-bar."""

    def make(*over):
        axes = parse_axes(seed, over)
        paths, shape = [axis.path for axis in axes], [len(axis.values) for axis in axes]
        data = xr.Dataset(attrs={"title": "made up", "paths": json.dumps(paths), "gauge": json.dumps(GAUGE)})
        for axis in axes:
            units = dict(zip(("written_units", "written_factor"), axis.written))
            data = data.assign_coords({axis.path: (axis.path, list(axis.values), {"units": axis.unit} | units)})
        for name in TEXTS:
            data[name] = (paths, np.full(shape, "", dtype=object))
        growing = np.arange(1.0, 1 + np.prod(shape)).reshape(*shape, 1)
        for name in (
            "peak_stress",
            "peak_strain",
            "peak_deflection",
            "peak_strain_s",
            "euler_ratio",
            "bow",
            "rotation",
        ):
            data[name] = ((*paths, "member"), 1e-6 * growing)
        waves = np.abs(np.sin(growing * [1, 2, 3, 4]))[..., None, :]
        data["strain_harmonic"] = ((*paths, "member", "harmonic"), waves)
        data["frequency_lowest"] = data["frequency_highest"] = ((*paths, "mode"), 0 * growing + 205.0)
        data["drive_rate"] = data[paths[0]] + 0 * data["bow"].isel(member=0)
        data.attrs["scene"] = seed.model_dump_json()
        return Sweep(data.assign_coords(member=["coupler"], harmonic=range(4), mode=[1]))

    return make


GAUGE = {"s": 0.5, "fibre": "+", "harmonics": 3}


def said(sweep):
    console = Console(width=400, record=True, file=io.StringIO())
    console.print(sweep_summary(sweep))
    return console.export_text()


def test_effects_that_come_and_go_are_told(made):
    sweep = made(SPEEDS)
    sweep.data.attrs["scene"] = sweep.scene.changed(effects="auto").model_dump_json()
    sweep.data["effects"][:] = "coupling, vibration"
    sweep.data["effects"][10], sweep.data["error"][10] = "", "SolverError"
    assert "at some points only" not in said(sweep)
    sweep.data["effects"][3:5] = "coupling, shear, vibration"
    assert "at some points only: shear at drive.speed = 250 to 300 rpm. List" in said(sweep)
    sweep.data["effects"][0] = ""  # quasi-static
    assert "vibration at drive.speed = 150 to 550 rpm" in said(sweep)
    sweep.data.attrs["scene"] = json.dumps({"effects": ["coupling"]})  # damping, say, comes with its number
    assert "at some points only" not in said(sweep)


def test_points_that_failed_are_told_by_ranges_in_the_unit_written(made):
    sweep = made(SPEEDS)
    assert "failed" not in said(sweep)
    for place in (0, 1, 2, 5):
        sweep.data["error"][place], sweep.data["message"][place] = "UnresolvedError", f"too coarse at {place}"
    sweep.data["error"][7] = "ZeroDivisionError"
    text = said(sweep)
    assert "5 of 11 points failed" in text
    assert "4 at drive.speed = 100 to 200 rpm, 350 rpm: steps, modes or elements are too coarse." in text
    assert "The first message is: too coarse at 0" in text
    assert "UnresolvedError" not in text
    assert "1 at drive.speed = 450 rpm: unexpected error ZeroDivisionError" in text


def test_points_of_a_grid_that_failed_are_told_by_what_holds_them(made):
    sweep = made(SPEEDS, RATIOS)
    sweep.data["error"][3:5, 1:] = "AssemblyError"
    assert "8 at drive.speed = 250 to 300 rpm and damping.ratio = 0.02 to 0.05: the links cannot be" in said(sweep)


def test_points_outside_the_theory_are_told(made):
    sweep = made(SPEEDS)
    assert "OUTSIDE" not in said(sweep)
    sweep.data["bow"][3:5] = 0.03
    assert "2 of 11 points are OUTSIDE THE THEORY" in said(sweep)
    assert "drive.speed = 250 to 300 rpm" in said(sweep)
    sweep.data["effects"][:] = "coupling, large-rotations"
    assert "OUTSIDE" not in said(sweep)


def test_sweeps_are_told_in_the_units_of_their_scene(made):
    sweep = made(SPEEDS)
    sweep.data["peak_joint_force"] = (("drive.speed", "joint"), np.full((11, 1), 4.4482216152605))
    sweep.data["peak_strain_s"][:] = 0.25
    sweep = Sweep(sweep.data.assign_coords(joint=["A"])).told_in(["%", "in", "lbf", "psi"])
    top, upper, lower = response_figure(sweep).axes
    labels = [axes.get_ylabel() for axes in (top, upper, lower)]
    assert labels == ["stress (psi)", "strain (%)", "deflection (in)"]
    assert top.get_lines()[0].get_ydata()[-1] == pytest.approx(11e-6 / 6894.757)
    assert upper.get_lines()[0].get_ydata()[-1] == pytest.approx(1e-4 * 11)
    assert lower.get_lines()[0].get_ydata()[-1] == pytest.approx(11e-6 / 0.0254)
    (forces,) = force_figure(sweep).axes
    assert forces.get_lines()[0].get_ydata()[-1] == pytest.approx(1)
    row = next(line for line in said(sweep).splitlines() if line.startswith(" coupler"))
    assert [float(cell) for cell in row.split()[1:4]] == pytest.approx([11e-6 / 6894.757, 11e-4, 600], rel=1e-3)
    assert row.rstrip().endswith("25 % of A to B")
    assert "stress (psi)" in said(sweep)
    without = Sweep(sweep.data.drop_vars("peak_stress"))  # as of an older version
    assert len(response_figure(without).axes) == 2
    assert " - " in next(line for line in said(without).splitlines() if line.startswith(" coupler"))


def test_large_forces_and_stresses_of_a_sweep_have_a_prefix_as_those_of_a_run_do(made):
    sweep = made(SPEEDS)
    along = np.linspace(0.1, 1.0, 11)
    sweep.data["peak_stress"] = 2.5e10 * along[:, None] + 0 * sweep.data["peak_stress"]
    sweep.data["peak_joint_force"] = (("drive.speed", "joint"), 38200 * along[:, None])
    sweep.data["peak_input_torque"] = ("drive.speed", 5e4 * along, {"units": "N m"})
    sweep.data["peak_joint_force"][3] = np.nan  # of a point that failed
    sweep = Sweep(sweep.data.assign_coords(joint=["A"]))

    def shown(sweep):
        axes = [*force_figure(sweep).axes, response_figure(sweep).axes[0]]
        return {one.get_ylabel(): one.get_lines()[0].get_ydata()[-1] for one in axes}

    wanted = {"force (kN)": 38.2, "torque (kN m)": 50.0, "stress (GPa)": 25.0}
    assert shown(sweep) == pytest.approx(wanted)
    assert re.search(r"stress.\(GPa\)", said(sweep))
    assert next(line for line in said(sweep).splitlines() if line.startswith(" coupler")).split()[1] == "25"
    stated = {"force (N)": 38200.0, "torque (kN m)": 50.0, "stress (MPa)": 25000.0}
    assert shown(sweep.told_in(["N", "MPa"])) == pytest.approx(stated)
    slides = sweep.data.assign(peak_input_torque=sweep.data["peak_input_torque"].assign_attrs(units="N") * 1e-3)
    slides["peak_input_torque"].attrs["units"] = "N"
    both = [axes.get_ylabel() for axes in force_figure(Sweep(slides)).axes]
    assert both == ["force (kN)", "force (kN)"]
    balanced = sweep.data.assign(peak_input_torque=sweep.data["peak_input_torque"] * 1e-18)  # nothing but rounding
    balanced["peak_input_torque"].attrs["units"] = "N m"
    assert force_figure(Sweep(balanced)).axes[1].get_ylabel() == "torque (N m)"


def test_points_are_judged_by_what_linear_theory_leaves_out_as_a_run_is(made):
    """The fixed limits are for points of which that is not known: a bow beyond them may be within the theory."""
    sweep = made(SPEEDS)
    sweep.data["bow"][:] = 0.03
    for name, least in (("theory_share", 0.001), ("deflection_theory_share", 0.002)):
        sweep.data[name] = ("drive.speed", np.linspace(least, 0.3, 11))
    sweep.data["theory_share"][0] = np.nan
    levels = theory_levels(sweep.data).to_numpy()
    assert list(levels[:2]) == ["bad", "warn"]
    assert set(levels[1:9]) == {"warn"}
    assert set(levels[9:]) == {"bad"}
    words = " ".join(said(sweep).split())
    assert "3 of 11 points are OUTSIDE THE THEORY" in words
    assert "leaves out up to 24 % of the strain or deflection at drive.speed = 150 to 500 rpm" in words
    for name in ("theory_share", "deflection_theory_share"):
        sweep.data[name][:] = np.nan
    sweep.data["bow"][:], sweep.data["euler_ratio"][:] = 0.0, 0.12
    assert "Linear theory may leave too much out at drive.speed = 100 to 600 rpm" in " ".join(said(sweep).split())


@pytest.mark.slow
def test_a_point_and_a_run_have_the_same_judgement(tmp_path):
    scene = load(DEMOS / "slider_crank.toml")
    sweep = run_sweep(scene, parse_axes(scene, ["drive.speed=40:60:2"]), tmp_path)
    judged = [theory(analysed(scene.changed(drive__speed=speed))).level for speed in (40.0, 60.0)]
    assert list(theory_levels(sweep.data).to_numpy()) == judged
    assert judged[1] == "warn"


def test_points_outside_the_theory_are_dotted_in_curves(made):
    sweep = made(SPEEDS)
    assert not response_figure(sweep).axes[0].patches
    sweep.data["bow"][3:5] = 0.03
    axes, _, last = response_figure(sweep).axes
    assert [(span.get_x(), span.get_x() + span.get_width()) for span in axes.patches] == [pytest.approx((225, 325))]
    assert last.get_xlabel() == "drive.speed (rpm)"
    assert "outside the theory" in [text.get_text() for text in axes.get_legend().get_texts()]


def test_peaks_between_points_that_are_not_resolved_are_marked(made):
    """Curves that are straight are resolved; a spike is not, in the steps at its point and beside them."""
    sweep = made(SPEEDS)
    assert "lines may miss" not in said(sweep)
    sweep.data["peak_strain"][5] *= 3  # at 350 rpm
    steps = [275, 325, 375, 425]
    text = " ".join(said(sweep).split())
    assert "near 275, 325, 375, 425 rpm lines may miss more than 1 % of a peak strain: --refine-peaks" in text
    for axes in response_figure(sweep).axes:
        marks = next(line for line in axes.get_lines() if line.get_marker() == "v")
        assert list(marks.get_xdata()) == pytest.approx(steps)
    two = made(SPEEDS, RATIOS)
    assert "lines may miss" not in said(two)


def test_maps_end_with_the_range_and_hatch_cells_outside_the_theory(made):
    sweep = made(SPEEDS, RATIOS)
    axes = strain_map(sweep, "coupler").axes[0]
    assert axes.get_xlim() == pytest.approx((100, 600))
    assert axes.get_ylim() == pytest.approx((0.01, 0.05))
    assert axes.get_legend() is None
    sweep.data["bow"][3:5, 2] = 0.03
    sweep.data["error"][10] = "SolverError"
    axes = strain_map(sweep, "coupler").axes[0]
    cells = np.array([path.vertices for path in axes.collections[-1].get_paths()])
    assert len(cells) == 2
    assert np.ptp(cells[..., 0]) == pytest.approx(100)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["outside the theory", "failed"]


def test_waves_of_a_waterfall_stay_below_the_next(made):
    sweep = made(SPEEDS)
    waves = [line.get_ydata() for line in waterfall_figure(sweep, "coupler").axes[0].get_lines()[:3]]
    assert all(order <= wave.min() and wave.max() < order + 1 for order, wave in enumerate(waves, 1))


def test_a_waterfall_leaves_out_the_higher_harmonics_that_no_one_sees(made):
    sweep = made(SPEEDS)
    sweep.data["strain_harmonic"].loc[{"harmonic": slice(8, None)}] *= 1e-6
    assert waterfall_figure(sweep, "coupler").axes[0].get_ylim()[1] < 9


def test_names_of_resonances_stay_apart_and_inside():
    found = _apart([0.0, 0.5, 0.52, 0.98, 1.0])
    assert (np.diff(found) >= 2 * NAME - 1e-12).all()
    assert min(found) >= NAME - 1e-12
    assert max(found) <= 1 - NAME + 1e-12
    assert _apart([0.3, 0.7]) == [0.3, 0.7]


def test_orders_of_a_campbell_diagram_go_on_where_points_failed(made):
    sweep = made(SPEEDS)
    sweep.data["drive_rate"][[0, 9, 10]] = np.nan
    lines = [line for line in campbell_figure(sweep).axes[0].get_lines() if line.get_linestyle() == "--"]
    assert lines[2].get_ydata() == pytest.approx(3 * np.linspace(100, 600, 11) / 60)
    assert {f"{order}\N{MULTIPLICATION SIGN}" for order in range(1, len(lines) + 1)} == {
        text.get_text() for text in campbell_figure(sweep).axes[0].texts
    }


def test_a_campbell_diagram_of_one_point_that_did_not_fail_has_its_rate_there(made):
    sweep = made(SPEEDS)
    sweep.data["drive_rate"][np.arange(11) != 4] = np.nan
    lines = [line for line in campbell_figure(sweep).axes[0].get_lines() if line.get_linestyle() == "--"]
    assert lines[2].get_ydata()[4] == pytest.approx(3 * 300 / 60)


def test_a_resonance_is_found_where_a_multiple_of_the_drive_meets_a_mode():
    """A strain that grows with the square of the speed, and is raised as an oscillator of 2 % damping at 50 Hz."""
    rate = np.linspace(4, 9, 101)  # Hz
    low, high = np.full((101, 2), [49.0, 120.0]), np.full((101, 2), [51.0, 130.0])
    orders = np.arange(12)
    share = orders * rate[:, None] / 50
    amplitude = 1e-6 * (rate[:, None] ** 2 / np.hypot(1 - share**2, 0.04 * share))[:, None]
    peak = amplitude.max(axis=2)
    found = {one.order: one for one in resonances(rate, (low, high), amplitude, peak)}
    assert sorted(found) == [6, 7, 8, 9, 10, 11]  # 5 times the drive does not come to 50 Hz
    for order, one in found.items():
        assert one.mode == 0
        assert rate[one.point] == pytest.approx(50 / order, rel=0.01)
    distance = distances(rate, low, high, 12)
    shown = raised(gains(rate, amplitude), amplitude, distance)
    assert shown[found[8].point, 8] == pytest.approx(found[8].strain)
    assert not shown[:, :5].any()  # nothing near a mode
    smooth = 1e-6 * np.ones((101, 1, 12)) * rate[:, None, None] ** 2
    assert resonances(rate, (low, high), smooth, smooth.max(axis=2)) == []
    assert gains(rate, smooth) == pytest.approx(
        np.ones_like(smooth)
    )  # which is what grows with the square of the speed
    assert distance[0, 10] == pytest.approx([49 / 40 - 1, 120 / 40 - 1])  # 10 times 4 Hz is below both modes
    assert distance[-1, 7] == pytest.approx([63 / 51 - 1, 120 / 63 - 1])  # 7 times 9 Hz is between them


def test_the_diagram_names_resonances_and_the_scenes_own_speed(made):
    sweep = made("drive.speed=240 rpm:540 rpm:61")
    rate = sweep.data["drive.speed"].to_numpy() / (2 * np.pi)
    share = np.arange(9) * rate[:, None] / 50
    sweep.data["frequency_lowest"][:] = sweep.data["frequency_highest"][:] = 50.0
    amplitude = 1e-6 * rate[:, None] ** 2 / np.hypot(1 - share**2, 0.04 * share)
    data = sweep.data.drop_vars("strain_harmonic").drop_dims("harmonic")
    data["strain_harmonic"] = (("drive.speed", "member", "harmonic"), amplitude[:, None])
    data["peak_strain"] = (("drive.speed", "member"), amplitude.max(axis=1, keepdims=True))
    data.attrs["stated_rate"] = 2 * np.pi * 5
    smooth = np.broadcast_to(1e-6 * rate[:, None, None] ** 2, (61, 1, 9)).copy()
    smooth[-1, 0, 8] *= 2  # at the end of the range, where nothing is known to be a peak
    without = data.assign(strain_harmonic=(("drive.speed", "member", "harmonic"), smooth))
    before = [type(one) for one in campbell_figure(Sweep(without)).axes[0].collections]
    assert PathCollection not in before  # no dots
    upper, lower = campbell_figure(Sweep(data)).axes
    named = [text.get_text() for text in upper.texts if "meets" in text.get_text()]
    assert [text.split()[0] for text in named] == [
        "8\N{MULTIPLICATION SIGN}",
        "7\N{MULTIPLICATION SIGN}",
        "6\N{MULTIPLICATION SIGN}",
    ]
    assert [float(text.split()[-2]) for text in named] == pytest.approx([375, 429, 500], abs=3)
    assert "scene: 300 rpm" in [text.get_text() for text in lower.texts]
    assert "still rise" not in said(Sweep(data))
    cut = Sweep(data.isel({"drive.speed": slice(0, 52)}))  # before the resonance of 6 times the drive
    assert "Strains still rise at 495 rpm, where 6 times the drive nears mode 1" in said(cut)
    assert len(upper.collections[-1].get_offsets()) > 10
    words = re.search(r"Resonances, the largest first: (.*)\.", said(Sweep(data)))[1]
    assert [float(speed) for speed in re.findall(r"([\d.]+) rpm \(", words)] == pytest.approx([500, 429, 375], abs=3)
    assert "rpm (6 times the drive meets mode 1)" in words
    data["strain_harmonic"] = (
        ("drive.speed", "member", "harmonic"),
        1e-6 * rate[:, None, None] ** 2 * np.ones((1, 1, 9)),
    )
    assert re.search(
        r"The strain peaks at 500 rpm, where it is [\d.]+ times that beside it", said(Sweep(data))
    )  # whatever raises it
    assert "No resonance stands out" not in said(Sweep(data))
    data["peak_strain"][:] = 1e-6 * rate[:, None] ** 2
    assert "No resonance stands out" in said(Sweep(data))


def test_a_link_without_joints_has_no_plot_of_joint_forces(tmp_path):
    scene = ROOT / "tests" / "cases" / "scenes" / "short_tube.toml"
    words = ["sweep", str(scene), "-o", str(tmp_path), "--over", "analysis.stations=5:7:2"]
    app(words, standalone_mode=False)
    assert (tmp_path / "sweep_response.png").exists()
    assert not (tmp_path / "sweep_forces.png").exists()
