"""Sweeps: a resonance curve in closed form, sweeps that are ended and go on, several processes, points that fail."""

import math
import signal
import subprocess
import time
from functools import partial

import numpy as np
import pytest
from rich.table import Table

from fenics_mech import load
from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, ResultError, SceneError, ViewError
from fenics_mech.estimate.remarks import NO_ESTIMATE
from fenics_mech.recovery.peaks import between_positions, doubts, peak_of
from fenics_mech.studies import sweep_peaks, sweep_points
from fenics_mech.studies.gauge import Gauge
from fenics_mech.studies.saved_sweep import first_difference
from fenics_mech.studies.sweep import Sweep, sweep
from fenics_mech.studies.sweep_axes import axes_of, parse_axes, range_in_si, unit_of
from fenics_mech.studies.sweep_peaks import peaks_of, unresolved
from fenics_mech.studies.sweep_points import stacked
from fenics_mech.views.sweep_plots import campbell_figure, plot_sweep, stability_figure, waterfall_figure
from fenics_mech.views.sweep_summary import sweep_summary
from tests.studies.processes import ENVIRONMENT, MPIRUN, command, finished

LENGTH, RIGIDITY, MASS, RATIO, FIBRE, SWING = 0.3, 1.4, 0.2, 0.03, 1e-3, 1e-3
OMEGA = math.sqrt(3 * RIGIDITY / (MASS * LENGTH**3))  # rad/s, of a mass on a light cantilever
ARM = f"""
name = "arm"
materials.light = {{ modulus = 70e9, density = 1e-3 }}
sections.bar = {{ area = 4e-5, inertia = {RIGIDITY / 70e9!r}, fibre = {FIBRE} }}
ground.points.O = [0, 0]
links.arm.points = {{ O = [0, 0], P = [{LENGTH}, 0] }}
links.arm.members.OP = {{ ends = ["O", "P"], section = "bar", material = "light" }}
joints.O.connect = ["ground.O", "arm.O"]
masses.P = {{ at = "arm.P", mass = {MASS} }}
drive = {{ joint = "O", law = {{ kind = "harmonics", sine = [{SWING}] }}, period = 1 }}
damping.ratio = {RATIO}
mesh.elements = 1
analysis = {{ sub_intervals = 72, modes = 1 }}
"""  # an arm whose hub swings by SWING sin(2 pi t/period)
RANGE = f"drive.period={0.9 * math.pi / OMEGA}:{4 * math.pi / OMEGA}:16"  # 0.45 to 2 natural periods, not itself
SHORT = RANGE.replace(":16", ":8")


@pytest.fixture
def arm(tmp_path):
    """The scene of the arm, from a file."""
    path = tmp_path / "arm.toml"
    path.write_text(ARM)
    return load(path)


def swept(scene, folder, *over, **options):
    return sweep(scene, parse_axes(scene, over), folder, **options)


def resonance(period):
    """Amplitude of the tip (m): the hub's motion is an inertia load ``M L SWING (2 pi/T)^2`` on an oscillator."""
    ratio = 2 * np.pi / period / OMEGA
    return LENGTH * SWING * ratio**2 / np.hypot(1 - ratio**2, 2 * RATIO * ratio)


def test_resonance_curve_is_that_of_one_oscillator(arm, tmp_path):
    data = swept(arm, tmp_path, RANGE, gauge=Gauge(s=0.0, fibre="+", harmonics=3)).data
    assert data["drive.period"].attrs["units"] == "s"
    tip = resonance(data["drive.period"].to_numpy())
    root = 3 * FIBRE / LENGTH**2 * tip  # strain at the root of a cantilever with a force at its tip
    # 72 positions miss the top by up to (pi/72)^2/2 = 1.0e-3; the load is linear between them: (2 pi/72)^2/12 = 0.6e-3
    close = {"rel": 1.6e-3}
    assert data["peak_deflection"].sel(member="arm").to_numpy() == pytest.approx(tip, **close)
    assert data["peak_strain"].sel(member="arm").to_numpy() == pytest.approx(root, **close)
    assert data["strain_harmonic"].sel(member="arm", harmonic=1).to_numpy() == pytest.approx(root, **close)
    assert float(data["strain_harmonic"].sel(harmonic=[0, 2, 3]).max()) < 1e-2 * root.min()
    assert (data["peak_strain_s"] == 0).all()
    for name in ("frequency_lowest", "frequency_highest", "frequency_start"):
        assert data[name].sel(mode=1).to_numpy() == pytest.approx(OMEGA / (2 * np.pi), rel=1e-6)  # light, not massless
    assert data["drive_rate"].to_numpy() == pytest.approx(2 * np.pi / data["drive.period"].to_numpy(), rel=1e-12)
    assert (data["error"] == "").all()


def test_multiplier_is_the_decay_of_the_free_vibration_in_a_period(arm, tmp_path):
    folder, collocation = tmp_path / "out", arm.changed(analysis__solver="collocation")
    sweep = swept(collocation, folder, "drive.period=0.1:0.2:2", "damping.ratio=0.01:0.05:3")
    data = sweep.data
    decay = np.exp(-data["damping.ratio"] * OMEGA * data["drive.period"])
    largest = data["multiplier"].max("disturbance").transpose(*decay.dims)
    assert largest.to_numpy() == pytest.approx(decay.to_numpy(), rel=1e-4)  # steps of order 6, and a light arm
    assert {path.name for path in plot_sweep(sweep, folder)} == {"sweep_map.png", "sweep_stability.png"}
    line = stability_figure(Sweep(data.isel({"damping.ratio": 0}).assign_attrs(paths='["drive.period"]'))).axes[0]
    assert line.get_lines()[0].get_ydata() == pytest.approx(largest.to_numpy()[0])


@pytest.mark.slow
def test_points_are_added_where_the_peak_is_not_resolved(arm, tmp_path):
    top = resonance(2 * math.pi / OMEGA * np.linspace(0.45, 2, 20_001)).max() * 3 * FIBRE / LENGTH**2
    coarse = swept(arm, tmp_path, RANGE)
    fine = swept(arm, tmp_path, RANGE, refine_peaks=25)
    assert float(coarse.data["peak_strain"].max()) < 0.95 * top
    assert float(fine.data["peak_strain"].max()) == pytest.approx(top, rel=0.01)
    added = sorted(set(fine.data["drive.period"].to_numpy()) - set(coarse.data["drive.period"].to_numpy()))
    assert 0 < len(added) <= 25
    assert np.median(np.abs(np.array(added) * OMEGA / (2 * math.pi) - 1)) < 0.2  # about the natural period
    limited = swept(arm, tmp_path, RANGE, refine_peaks=3)
    assert limited.data.sizes["drive.period"] == 19


def test_refinement_estimates_the_error_of_linear_interpolation():
    x = np.array([0.0, 1, 2, 3, 5])
    square = (x**2)[:, None]  # the error in a step h is h^2/4, of the largest 25
    assert unresolved(x, square) == [4.0]  # 4 % in the last step; 1 % in the others is enough
    assert unresolved(x, 0 * square) == []
    failed = square.copy()
    failed[4] = np.nan
    assert 4.0 not in unresolved(x, failed)
    assert unresolved(x, np.full((5, 1), np.nan)) == []


@pytest.mark.slow
def test_an_interrupted_sweep_goes_on_to_the_same_file(arm, tmp_path, monkeypatch):
    whole = swept(arm, tmp_path / "whole", SHORT, refine_peaks=4)
    calls = []

    def limited(scene, run, names, most):
        calls.append(scene)
        if len(calls) > most:
            raise KeyboardInterrupt
        return analyse(scene, run=run)

    for most in (3, 6):  # the second time while points are added
        calls.clear()
        monkeypatch.setattr(
            sweep_points, "analyse", lambda scene, run, names, most=most: limited(scene, run, names, most)
        )
        with pytest.raises(KeyboardInterrupt):
            swept(arm, tmp_path / "parts", SHORT, refine_peaks=4)
        assert not (tmp_path / "parts" / "sweep.nc").exists()
    calls.clear()
    monkeypatch.setattr(sweep_points, "analyse", partial(limited, most=99))
    swept(arm, tmp_path / "parts", SHORT, refine_peaks=4)
    assert len(calls) == 12 - 3 - 6
    assert (tmp_path / "parts" / "sweep.nc").read_bytes() == (tmp_path / "whole" / "sweep.nc").read_bytes()
    calls.clear()
    again = swept(arm, tmp_path / "parts", SHORT, refine_peaks=4)
    assert not calls
    assert again.data.identical(whole.data)


@pytest.mark.slow
def test_a_killed_process_leaves_whole_points_behind(tmp_path, arm):
    folder = tmp_path / "killed"
    arguments = (
        "-m",
        "fenics_mech",
        "sweep",
        tmp_path / "arm.toml",
        "--over",
        RANGE.replace(":16", ":15"),
        "-o",
        folder,
    )
    swept(arm, tmp_path / "whole", RANGE.replace(":16", ":15"))
    with subprocess.Popen(command(*arguments), env=ENVIRONMENT, stderr=subprocess.DEVNULL) as process:
        limit = time.monotonic() + 60
        while len(list(folder.glob("points/[!.]*.json"))) < 3 and time.monotonic() < limit:
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
    done = len(list(folder.glob("points/[!.]*.json")))
    assert 3 <= done < 15
    assert not (folder / "sweep.nc").exists()
    swept(arm, folder, RANGE.replace(":16", ":15"))
    assert (folder / "sweep.nc").read_bytes() == (tmp_path / "whole" / "sweep.nc").read_bytes()
    rows = (folder / "timings.csv").read_text().splitlines()
    assert rows[0] == "drive.period (s),seconds,error"
    assert len(rows) == 16


def test_a_torn_point_is_computed_again(arm, tmp_path):
    swept(arm, tmp_path / "out", SHORT)
    before = (tmp_path / "out" / "sweep.nc").read_bytes()
    for path, text in zip(
        sorted((tmp_path / "out" / "points").iterdir()), ("", '{"error": ""', "[]", '{"again": false}')
    ):
        path.write_text(text)
    swept(arm, tmp_path / "out", SHORT)
    assert (tmp_path / "out" / "sweep.nc").read_bytes() == before


@pytest.mark.slow
@pytest.mark.skipif(MPIRUN is None, reason="no mpirun")
def test_two_processes_come_to_the_same_file(arm, tmp_path):
    arguments = ("-m", "fenics_mech", "sweep", tmp_path / "arm.toml", "--over", SHORT, "--refine-peaks", 3, "-o")
    swept(arm, tmp_path / "one", SHORT, refine_peaks=3)
    shared = finished(*arguments, tmp_path / "two", ranks=2)
    assert shared.returncode == 0, shared.stderr
    assert shared.stdout.count("Largest stress") == 1
    assert (tmp_path / "two" / "sweep.nc").read_bytes() == (tmp_path / "one" / "sweep.nc").read_bytes()


@pytest.mark.slow
@pytest.mark.skipif(MPIRUN is None, reason="no mpirun")
def test_an_error_of_one_process_ends_all_with_one_message(arm, tmp_path):
    arguments = ["sweep", str(tmp_path / "arm.toml"), "--over", SHORT, "-o", str(tmp_path / "out")]
    script = f"""
import sys
from mpi4py import MPI
from fenics_mech import cli
from fenics_mech.errors import ResultError
from fenics_mech.studies import sweep_run
if MPI.COMM_WORLD.rank == 1:
    def broken(*_):
        raise ResultError("the disk is full")
    sweep_run.compute_point = broken
sys.argv = ["fenics-mech", *{arguments!r}]
cli.main()
"""
    (tmp_path / "broken.py").write_text(script)
    ended = finished(tmp_path / "broken.py", ranks=2)
    assert ended.returncode == 1
    assert ended.stderr.count("error: process 1 ended with ResultError: the disk is full") == 1
    assert "Traceback" not in ended.stderr


def test_points_that_fail_are_recorded_and_do_not_end_the_sweep(tmp_path, seed):
    scene = seed.changed(analysis__method="quasi-static")
    sweep = swept(scene, tmp_path, "links.coupler.points.B.0=0.1:0.28:4")
    failed = sweep.data["error"].to_numpy() != ""
    assert failed.tolist() == [True, False, False, False]  # |0.1 - 0.2705| m is more than the 0.254 - 0.108 from A to C
    assert sweep.data["error"].to_numpy()[0] == "AssemblyError"
    assert sweep.data["message"].to_numpy()[0]
    peaks = sweep.data["peak_strain"].sel(member="coupler").to_numpy()
    assert np.isnan(peaks).tolist() == failed.tolist()
    alone = analyse(scene.changed(links__coupler__points__B__0=0.28))
    assert peaks[-1] == np.abs(peak_of(alone, "strain")[2][list(alone.data["member"]).index("coupler")])
    assert len(plot_sweep(sweep, tmp_path)) == 4
    assert any("1 of 4 points failed" in str(part) for part in sweep_summary(sweep).renderables)


def test_what_error_estimates_lack_is_told(arm, tmp_path):
    wave = {"kind": "expression", "formula": "sin(theta) + 5*exp(-((theta - 2.0001)/0.001)**2)"}
    loads = {"tap": {"at": "arm.P", "force": (0.0, 1e-3), "factor": wave}}
    struck = arm.changed(loads=loads, analysis__solver="collocation", analysis__allow_coarse=True)
    sweep = swept(struck, tmp_path, "loads.tap.force.1=1e-3:2e-3:2")
    alone = [analyse(struck.changed({"loads.tap.force.1": size})).data.attrs["not_estimated"] for size in (1e-3, 2e-3)]
    assert "the factor of the load 'tap' does between positions" in alone[0]
    assert sweep.data["not_estimated"].to_numpy().tolist() == alone
    assert any(
        str(part).endswith(f"force.1 = 0.001 to 0.002 N: {alone[0]}") for part in sweep_summary(sweep).renderables
    )


def test_points_without_estimates_are_told(arm, tmp_path):
    whole = swept(arm, tmp_path / "whole", SHORT).data
    sweep = swept(arm, tmp_path / "peaks", SHORT, estimates="peaks")
    data, peak = sweep.data, int(whole["peak_strain"].argmax("drive.period").item())
    assert data["peak_strain"].identical(whole["peak_strain"])
    estimated = [0, peak, 7]  # of a curve with one peak
    assert data["error_estimate"][estimated].identical(whole["error_estimate"][estimated])
    assert np.flatnonzero(np.isfinite(data["error_estimate"])).tolist() == estimated
    assert np.flatnonzero(data["not_estimated"] == NO_ESTIMATE).tolist() == [i for i in range(8) if i not in estimated]
    summary = sweep_summary(sweep).renderables
    assert any(str(part).startswith("NO errors are estimated at drive.period = ") for part in summary)
    assert [part.caption for part in summary if isinstance(part, Table)] == ["5 of 8 points have no error estimate"]
    off = swept(arm.changed(analysis__error_estimates=False), tmp_path / "off", SHORT).data
    assert (off["not_estimated"] == NO_ESTIMATE).all()


def test_points_with_stated_steps_that_are_too_long_are_kept_and_told(arm, tmp_path):
    rough = arm.changed(analysis__sub_intervals=12)  # twice the error that is let pass, of all points
    whole = swept(rough, tmp_path / "all", SHORT, estimates="all").data
    told = np.flatnonzero(whole["too_coarse"] != "")
    sweep = swept(rough, tmp_path / "peaks", SHORT, estimates="peaks")
    coarse = np.flatnonzero(sweep.data["too_coarse"] != "")
    assert len(coarse)
    assert set(coarse) < set(told)
    assert (sweep.data["error"] == "").all()
    assert (whole["error"] == "").all()
    assert np.isfinite(sweep.data["peak_strain"]).all()
    assert (sweep.data["too_coarse"][coarse] == whole["too_coarse"][coarse]).all()
    said = [str(part) for part in sweep_summary(sweep).renderables]
    assert any(f"{len(coarse)} of 8 points are TOO COARSE: drive.period = " in part for part in said)


def test_many_points_are_estimated_at_peaks_unless_it_is_asked_for_otherwise(arm, tmp_path, monkeypatch):
    def unknown(name, **asked):
        return int((swept(arm, tmp_path / name, SHORT, **asked).data["not_estimated"] == NO_ESTIMATE).sum())

    assert unknown("few") == 0
    monkeypatch.setattr(sweep_peaks, "MANY_POINTS", 7)  # the range has 8
    assert unknown("many") == 5
    assert unknown("asked", estimates="all") == 0


def test_many_points_that_choose_by_estimates_have_them_all(arm, tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_peaks, "MANY_POINTS", 1)
    chosen = arm.changed(effects="auto")
    data = swept(chosen, tmp_path, "drive.period=1:1.1:2").data
    assert (data["not_estimated"] != NO_ESTIMATE).all()


def test_estimates_at_peaks_choose_nothing(seed, tmp_path):
    for stated, place in (({"effects": "auto"}, "effects"), ({"tolerance": 0.01}, "tolerance")):
        with pytest.raises(SceneError, match="error estimates choose this for each point") as refused:
            swept(seed.changed(**stated), tmp_path, "drive.speed=10:20:3", estimates="peaks")
        assert refused.value.place == place


def test_peaks_of_a_grid_are_not_lower_than_their_neighbours():
    curves = np.array([[1.0, 0, 1, 0, 3, 3, 2], [1.0, 2, np.nan, 2, 1, 0, 5]]).T
    assert np.flatnonzero(peaks_of(curves, 1)).tolist() == [0, 1, 2, 3, 4, 5, 6]
    assert np.flatnonzero(peaks_of(curves[:, :1], 1)).tolist() == [0, 2, 4, 5, 6]
    hill = -np.add.outer((np.arange(5) - 2) ** 2, (np.arange(4) - 1) ** 2)[..., None].astype(float)
    assert np.argwhere(peaks_of(hill, 2)).tolist() == [[0, 0], [0, 3], [2, 1], [4, 0], [4, 3]]


def test_a_sweep_in_which_all_points_fail_is_a_sweep(tmp_path, seed):
    sweep = swept(seed, tmp_path, "links.coupler.points.B.0=0.01:0.02:2")
    assert (Sweep.load(tmp_path / "sweep.nc").data["error"] == "AssemblyError").all()
    assert plot_sweep(sweep, tmp_path) == []


@pytest.mark.parametrize("damaged", ["{}", "[1]", '{"scene": {}, "gauge": {}, "values": 1}'])
def test_a_damaged_plan_is_one_message(arm, tmp_path, damaged):
    (tmp_path / "sweep.json").write_text(damaged)
    with pytest.raises(ResultError, match=r"for a sweep: its sweep\.json is none that the program has written"):
        swept(arm, tmp_path, RANGE)


def test_an_error_that_is_not_known_is_recorded_and_tried_again(arm, tmp_path, monkeypatch):
    def broken(scene, run, names):
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(sweep_points, "analyse", broken)
    first = swept(arm, tmp_path, SHORT)
    assert (first.data["error"] == "ZeroDivisionError").all()
    monkeypatch.setattr(sweep_points, "analyse", analyse)
    assert (swept(arm, tmp_path, SHORT).data["error"] == "").all()


def test_lack_of_memory_is_not_an_answer(arm, tmp_path, monkeypatch):
    def broken(scene, run, names):
        raise MemoryError

    monkeypatch.setattr(sweep_points, "analyse", broken)
    with pytest.raises(MechanismError, match="MemoryError"):
        swept(arm, tmp_path, SHORT)
    assert not list(tmp_path.glob("points/*.json"))


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ("drive.speed", "cannot read"),
        ("drive.speed=1:2", "cannot read"),
        ("drive.speed=1:2:1", "whole number from 2"),
        ("drive.speed=1:2:3.5", "whole number from 2"),
        ("drive.speed=3:3:4", "begins where it ends"),
        ("drive.speed=1:nan:4", "finite"),
        ("drive.speed=1 kg:2 kg:4", "wrong unit"),
        ("drive.speed=1:2 rad/s:4", "has a unit and the other has none"),
        ("drive.speed=1,5:2:4", "has a comma"),
        ("drive.sped=1:2:3", "There are joint, speed"),
        ("links.rod.angle=1:2:3", "There are crank, coupler, follower"),
        ("name.x=1:2:3", "nothing below"),
        ("joints.O.connect.0=1:2:3", "must be"),
        ("analysis.static_correction=0:1:2", "only a number"),
        ("mesh.elements=1:4:3", "whole number"),
        ("damping.ratio=0.5:1.5:3", "less than 1"),
        ("drive=1:2:3", "must be"),
    ],
)
def test_bad_ranges_are_refused_with_their_place(seed, over, said):
    with pytest.raises(SceneError, match=said) as caught:
        parse_axes(seed, [over])
    assert caught.value.place.startswith(over.split("=")[0].split(".")[0])


def test_a_field_is_swept_once_and_grids_have_an_end(seed):
    for over in ([], ["drive.speed=1:2:3"] * 2, ["drive.speed=1:2:2000", "damping.ratio=0:0.1:2000"]):
        with pytest.raises(SceneError, match=r"each of them once|at most"):
            parse_axes(seed, over)


def test_values_are_read_in_units_and_units_are_known(seed):
    axes = parse_axes(
        seed, ["drive.speed=60 rpm:-120 rpm:4", "links.crank.points.A.0=1 in:2 in:2", "mesh.elements=1:5:3"]
    )
    assert axes[0].values == pytest.approx(np.array([-4, -2, 0, 2]) * np.pi)
    assert axes[1].values == pytest.approx([0.0254, 0.0508])
    assert axes[2].values == (1, 3, 5)
    assert [axis.unit for axis in axes] == ["rad/s", "m", "1"]
    assert [axis.written for axis in axes] == [("rpm", pytest.approx(np.pi / 30)), ("in", 0.0254), ("1", 1.0)]
    assert parse_axes(seed, ["drive.speed=1e1:6e1:3"])[0].written == ("rad/s", 1.0)
    assert parse_axes(seed, ["damping.ratio=1e-1 %:2 %:3"])[0].written == ("%", pytest.approx(0.01))
    assert axes[2].whole
    assert unit_of(seed, "gravity.1") == "m/s^2"
    assert unit_of(seed, "damping.ratio") == "1"


def test_peaks_of_a_load_that_jumps_are_doubted_as_well(arm):
    """Curves are not drawn through its jumps; a pulse between two of 72 positions may be seen by one or none."""
    pulse = {"kind": "pulse", "start": 1.0, "end": 1.05}
    loads = {"tap": {"at": "arm.P", "force": (0.0, 1.0), "factor": pulse}}
    result = analyse(arm.changed(loads=loads, analysis__solver="collocation", analysis__allow_coarse=True))
    assert between_positions(result) is result
    assert doubts(result)["strain"] > 0.01


def test_a_grid_holds_the_results_of_its_points(seed, tmp_path):
    seed = seed.changed(analysis__modes=2, analysis__allow_coarse=True)
    sweep = swept(seed, tmp_path / "out", "drive.speed=40:50:2", "damping.ratio=0.01:0.03:3", gauge=Gauge(harmonics=40))
    at = {"drive.speed": 50.0, "damping.ratio": 0.03}
    point = sweep.data.sel(at)
    result = analyse(seed.changed(drive__speed=50.0, damping__ratio=0.03))
    alone, close = result.data, between_positions(result).data
    for name in ("strain", "stress"):
        largest = np.abs(close[name]).max(("theta", "s", "fibre")).to_numpy()
        assert point[f"peak_{name}"].to_numpy() == pytest.approx(largest, rel=1e-9)
    there = {"member": "coupler"}
    there |= {"s": float(point["peak_strain_s"].sel(member="coupler"))}
    there |= {"fibre": "+" if point["peak_strain_side"].sel(member="coupler") == 1 else "-"}
    angle = float(point["peak_strain_theta"].sel(member="coupler"))
    at_peak = close["strain"].sel(there).sel(theta=angle, method="nearest")
    assert abs(float(at_peak)) == pytest.approx(float(point["peak_strain"].sel(member="coupler")), rel=1e-9)
    force = np.hypot(*close["joint_force"].transpose("component", "theta", "joint").to_numpy()).max(axis=0)
    assert point["peak_joint_force"].to_numpy() == pytest.approx(force, rel=1e-5)  # of a place beside the peak
    assert float(point["peak_input_torque"]) == pytest.approx(np.abs(close["input_torque"]).max().item(), rel=1e-9)
    assert point["frequency_highest"].to_numpy() == pytest.approx(alone["frequency"].max("theta").to_numpy(), rel=1e-15)
    wave = alone["strain"].sel(member="follower", s=0.5, fibre="+").to_numpy()
    angle = alone["theta"].to_numpy()
    second = 2 * abs(np.mean(wave * np.exp(-2j * angle)))
    assert float(point["strain_harmonic"].sel(member="follower", harmonic=2)) == pytest.approx(second, rel=1e-12)
    assert sweep.data.sizes["harmonic"] == 12  # 24 positions tell 11 harmonics
    loaded = Sweep.load(tmp_path / "out" / "sweep.nc")
    assert loaded.data.identical(sweep.data)
    assert loaded.paths == list(at)
    assert loaded.scene.drives[0].speed == 40.0


def test_a_folder_keeps_to_one_sweep(arm, tmp_path, monkeypatch):
    folder = tmp_path / "out"
    swept(arm, folder, "drive.period=0.1:0.3:3")
    before = (folder / "sweep.nc").read_bytes()
    for scene, over, gauge in (
        (arm.changed(masses__P__mass=0.3), "drive.period=0.1:0.3:3", Gauge()),
        (arm, "drive.period=0.1:0.4:3", Gauge()),
        (arm, "damping.ratio=0.1:0.3:3", Gauge()),
        (arm, "drive.period=0.1:0.3:3", Gauge(s=0.0)),
    ):
        with pytest.raises(SceneError, match=r"holds a sweep.*Give another folder"):
            swept(scene, folder, over, gauge=gauge)
    assert (folder / "sweep.nc").read_bytes() == before
    calls = []
    monkeypatch.setattr(sweep_points, "analyse", lambda scene, run, names: calls.append(scene) or analyse(scene))
    finer = swept(arm.changed(drive__period=5.0), folder, "drive.period=0.1:0.3:5")  # the period itself is swept
    assert finer.data.sizes["drive.period"] == 5
    own = set(finer.data["drive.period"].to_numpy())  # others are analysed for the largest strain between them
    assert sum(call.drive.period in own for call in calls) == 2


def test_refinement_is_for_one_field_that_is_no_whole_number(arm, tmp_path):
    for over in (["mesh.elements=1:3:3"], ["drive.period=0.1:0.3:3", "damping.ratio=0:0.1:2"]):
        with pytest.raises(SceneError, match="points can be added"):
            swept(arm, tmp_path / "out", *over, refine_peaks=2)


@pytest.mark.slow
def test_plots_show_the_numbers(arm, tmp_path):
    sweep = swept(arm, tmp_path / "out", RANGE)
    names = {path.name for path in plot_sweep(sweep, tmp_path)}
    assert names == {f"sweep_{name}.png" for name in ("response", "forces", "campbell", "waterfall")}
    axes = campbell_figure(sweep).axes[0]
    period = sweep.data["drive.period"].to_numpy()
    orders = [line.get_ydata() for line in axes.get_lines() if line.get_linestyle() == "--"]
    assert np.array(orders[1]) == pytest.approx(2 / period)
    top = waterfall_figure(sweep, "arm").axes[0].get_lines()[0].get_ydata()
    assert np.argmax(top) == np.abs(period * OMEGA / (2 * math.pi) - 1).argmin()
    with pytest.raises(ViewError, match="the scene has arm"):
        plot_sweep(sweep, tmp_path, member="rod")


def test_other_files_are_not_sweeps(arm, tmp_path):
    analyse(arm).save(tmp_path / "result.nc")
    (tmp_path / "text.nc").write_text("no")
    for name in ("result.nc", "text.nc", "missing.nc"):
        with pytest.raises(ResultError, match=name):
            Sweep.load(tmp_path / name)


def test_arrays_of_several_sizes_are_stacked_with_gaps():
    found = stacked([[1.0, 2.0], None, [3.0]])
    assert np.array_equal(found, [[1, 2], [np.nan, np.nan], [3, np.nan]], equal_nan=True)
    assert np.array_equal(stacked([2.0, None]), [2, np.nan], equal_nan=True)


def test_the_first_difference_of_two_scenes_is_named():
    assert first_difference({"a": [1, {"b": 2}]}, {"a": [1, {"b": 3}]}) == "a.1.b"
    assert first_difference({"a": 1}, {"a": 1}) == ""
    assert first_difference({"a": 1}, {}) == "a"


def test_a_text_is_not_taken_for_several_values(seed):
    with pytest.raises(SceneError, match="found the text '100 rpm'"):
        axes_of(seed, {"drive.speed": "100 rpm"})
    with pytest.raises(SceneError, match="a range has two ends"):
        range_in_si(seed, "drive.speed", "3:4")


@pytest.mark.parametrize("ending", ["json", "motion"])
def test_a_folder_in_place_of_a_kept_point_is_one_message(arm, tmp_path, ending):
    (tmp_path / "points" / f"0123.{ending}").mkdir(parents=True)
    with pytest.raises(ResultError, match=rf"0123\.{ending} in .*points is a folder, and points are files. Remove it"):
        swept(arm, tmp_path, SHORT)


def test_a_sweep_whose_points_all_fail_has_no_peaks(arm, tmp_path, monkeypatch):
    def fails(*arguments, **options):
        raise MechanismError("not this time")

    monkeypatch.setattr(sweep_points, "analyse", fails)
    found = swept(arm, tmp_path, SHORT, estimates="peaks")
    assert (found.data["message"] == "not this time").to_numpy().all()
