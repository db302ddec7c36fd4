"""Branches of a scene: a beam between fixed pins against Duffing's oscillator, and single points against analyses."""

import io

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from fenics_mech.analysis import analyse
from fenics_mech.answers.by_poses import result_of
from fenics_mech.cli import app
from fenics_mech.errors import MechanismError, ResultError, SceneError
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.scene import Scene, load
from fenics_mech.studies.follow import END, Branch, follow
from fenics_mech.studies.sweep_axes import parse_range
from fenics_mech.views.branch_plots import branch_figure, branch_summary, plot_branch
from tests.common import DEMOS
from tests.response.forced import folds

FROZEN = DEMOS.parent / "tests" / "frozen" / "scenes"

LENGTH, WIDTH, HEIGHT, MODULUS, DENSITY = 1.0, 0.02, 0.002, 70e9, 2700.0
EI, LINE = MODULUS * WIDTH * HEIGHT**3 / 12, DENSITY * WIDTH * HEIGHT
OMEGA, RADIUS = np.pi**2 / LENGTH**2 * np.sqrt(EI / LINE), HEIGHT / np.sqrt(12)
RATIO, FORCE = (
    0.02,
    0.1,
)  # of the half-wave: damping over critical, and force over stiffness times the radius of gyration
CUBIC = (
    0.25  # EA (pi a)^2/(4 L^2) of tension, over stiffness: Nayfeh and Mook, Nonlinear Oscillations (1979), section 7.5
)


def beam(**changes):
    """A beam between two fixed pins; a line load on it goes with the angle of a flywheel."""
    line = FORCE * OMEGA**2 * RADIUS * LINE * np.pi / 4  # its part in the half-wave is 4/pi of it
    data = {
        "name": "beam between pins",
        "materials": {"metal": {"modulus": MODULUS, "density": DENSITY}},
        "sections": {"strip": {"shape": "rectangle", "width": WIDTH, "height": HEIGHT}},
        "ground": {"points": {"A": [0, 0], "B": [LENGTH, 0], "C": [LENGTH + 1, 0], "O": [0, 1]}},
        "links": {
            "beam": {
                "points": {"A": [0, 0], "B": [LENGTH, 0]},
                "members": {"strip": {"ends": ["A", "B"], "section": "strip", "material": "metal"}},
            },
            "flywheel": {"points": {"O": [0, 0]}, "rigid": {"mass": 1.0, "inertia": 1.0}},
        },
        "joints": {
            "A": {"connect": ["ground.A", "beam.A"]},
            "B": {"kind": "slot", "connect": ["ground.B", "beam.B"], "angle": 0.0},
            "O": {"connect": ["ground.O", "flywheel.O"]},
        },
        "springs": {"wall": {"between": ["beam.B", "ground.C"], "stiffness": 1e4 * MODULUS * WIDTH * HEIGHT}},
        "loads": {"line": {"member": "beam", "line": [0, line], "factor": {"kind": "harmonics", "cosine": [1.0]}}},
        "drive": {"joint": "O", "speed": OMEGA},
        "damping": {"external": 2 * RATIO * OMEGA},
        "mesh": {"elements": 4},
        "effects": ["coupling", "large-rotations"],
        "analysis": {"sub_intervals": 24, "stations": 11, "allow_coarse": True},
    }
    return Scene.read(data).changed(**changes)


@pytest.fixture(scope="module", params=["collocation", "poses"])
def branch(request):
    """From below the resonance to above it."""
    scene = beam(analysis__solver=request.param)
    return follow(scene, "drive.speed", (0.9 * OMEGA, 1.35 * OMEGA), points=12)


def at_folds(branch):
    return branch.data.isel(point=np.flatnonzero(branch.data["fold"] == 1))


@pytest.mark.slow
def test_folds_of_a_beam_between_pins_are_duffings(branch):
    found, expected = at_folds(branch), folds(2 * RATIO, CUBIC, FORCE)
    # the uniform load moves the third half-wave by 1/81 of its 1/3, and its shortening the tension: 2e-4 measured
    assert found["drive.speed"].to_numpy() / OMEGA == pytest.approx(expected[:, 0], rel=5e-4)
    # 24 positions miss the top by up to (pi/24)^2/2 = 0.9 %; the third harmonic adds b A^2/(32 w^2) = 1.7 %
    peaks = found["peak_deflection"].sel(member="beam").to_numpy() / RADIUS
    assert peaks == pytest.approx(expected[:, 1], rel=0.025)


@pytest.mark.slow
def test_motions_between_the_folds_are_unstable_in_the_middle_only(branch):
    first, second = np.flatnonzero(branch.data["fold"] == 1)
    leading = branch.data["multiplier"].transpose("point", "disturbance", "part").to_numpy()[:, 0]
    middle = leading[first + 1 : second]
    assert (middle[:, 0] > 1.0).all()
    assert (middle[:, 1] == 0).all()  # at a fold a real one passes 1: Nayfeh and Balachandran, section 3.2
    assert leading[[first, second], 0] == pytest.approx([1.0, 1.0], abs=1e-3)
    stable = branch.data["stable"].to_numpy() == 1
    assert stable[:first].all()
    assert not stable[first + 1 : second].any()
    assert stable[second + 1 :].all()
    assert {kind for *_, kind in branch.changes()} == {"fold"}
    between = np.mean(branch.values[[first, second]])
    assert [stable for _, stable in branch.motions(between)] == [True, False, True]
    assert [stable for _, stable in branch.motions(1.34 * OMEGA)] == [True]


@pytest.mark.slow
def test_both_ends_are_what_an_analysis_gives(branch):
    assert branch.whole
    for index, share in ((0, 0.9), (-1, 1.35)):
        assert branch.values[index] == share * OMEGA
        result = analyse(beam(drive__speed=share * OMEGA, analysis__solver=branch.scene.analysis.solver))
        alone, close = result.data, between_positions(result).data
        point = branch.data.isel(point=index)
        strain = np.abs(close["strain"]).max(("theta", "s", "fibre")).to_numpy()
        assert point["peak_strain"].to_numpy() == pytest.approx(strain, rel=1e-7)
        assert point["strain_highest"].item() == pytest.approx(close["strain"].max().item(), rel=1e-7)
        assert point["strain_lowest"].item() == pytest.approx(close["strain"].min().item(), rel=1e-7)
        multiplier = alone["multiplier"].transpose("disturbance", "part").to_numpy()
        found = point["multiplier"].transpose("disturbance", "part").to_numpy()
        assert found[: len(multiplier)] == pytest.approx(multiplier, abs=1e-6)
        assert np.isnan(found[len(multiplier) :]).all()


def test_a_branch_over_the_load_ends_at_what_an_analysis_gives():
    scene = beam(drive__speed=1.15 * OMEGA, mesh__elements=2)
    path = "loads.line.factor.cosine.0"
    found = follow(scene, path, (0.1, 0.2), points=2)
    assert found.data[path].attrs["units"] == "1"
    alone = between_positions(analyse(scene.changed(loads__line__factor__cosine=(0.2,)))).data
    assert found.data["peak_strain"].to_numpy()[-1, 0] == pytest.approx(np.abs(alone["strain"]).max().item(), rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("what", [pytest.param("motor", marks=pytest.mark.long), "impulse"])
def test_motors_and_impulses_are_followed_to_what_an_analysis_gives(what):
    if what == "motor":
        scene = load(FROZEN / "motors_04_large_rotations.toml").changed({"analysis.allow_coarse": True})
    else:
        scene = beam(
            impulses={"hit": {"at": "beam@0.5", "angle": 1.0, "impulse": [0, 1e-3]}},
            mesh__elements=2,
            drive__speed=0.7 * OMEGA,
        )
    scene = scene.changed({"analysis.solver": "poses", "analysis.error_estimates": False})
    speed = scene.drives[0].speed
    found = follow(scene, "drive.speed", (speed, 1.1 * speed), points=2)
    alone = between_positions(analyse(scene.changed(drive__speed=1.1 * speed))).data
    strain = np.abs(alone["strain"]).max(("theta", "s", "fibre")).to_numpy()
    assert found.data["peak_strain"].to_numpy()[-1] == pytest.approx(strain, rel=1e-7)


def test_linear_strains_are_not_followed_by_poses():
    scene = beam(effects=("coupling", "geometric-stiffness"), analysis__solver="poses")
    with pytest.raises(SceneError, match="effects: under linear strains there is one motion"):
        follow(scene, "drive.speed", (20.0, 30.0))
    with pytest.raises(SceneError, match="only periodic motions are followed"):
        follow(scene.changed(analysis__method="quasi-static"), "drive.speed", (20.0, 30.0))


@pytest.mark.slow
def test_files_and_pictures(branch, tmp_path):
    branch.save(tmp_path / "branch.nc")
    loaded = Branch.load(tmp_path / "branch.nc")
    assert loaded.data.identical(branch.data)
    assert loaded.path == "drive.speed"
    assert loaded.scene.drives[0].speed == 0.9 * OMEGA
    assert {path.name for path in plot_branch(loaded, tmp_path)} == {"branch_response.png", "branch_stability.png"}
    lines = branch_figure(loaded).axes[0].get_lines()
    dashed = np.concatenate([line.get_xdata() for line in lines if line.get_linestyle() == "--"])
    edges = at_folds(branch)["drive.speed"].to_numpy()
    assert [dashed.max(), dashed.min()] == pytest.approx(edges)
    circles = [line.get_xdata() for line in lines if line.get_marker() == "o"]
    assert circles[0] == pytest.approx(edges)
    console = Console(width=200, record=True, file=io.StringIO())
    console.print(branch_summary(loaded))
    text = console.export_text()
    assert f"{edges[0]:.6g}" in text
    assert "Folds" in text
    (tmp_path / "text.nc").write_text("no")
    with pytest.raises(ResultError, match=r"text\.nc"):
        Branch.load(tmp_path / "text.nc")


def bending_column(folder):
    """Write the demo of a column that is pressed in time, with exact strains."""
    path, text = folder / "column.toml", (DEMOS / "pulsating_column.toml").read_text()
    path.write_text(text.replace('["coupling", "geometric-stiffness"]', '["large-rotations"]'))
    return path


@pytest.mark.slow
def test_command_follows(tmp_path):
    path = bending_column(tmp_path)
    found = CliRunner().invoke(
        app, ["follow", str(path), "--over", "drive.speed=150:160", "--points", "2", "-o", str(tmp_path)]
    )
    assert found.exit_code == 0, found.output
    assert "stable" in found.stdout
    branch = Branch.load(tmp_path / "branch.nc")
    assert branch.data.attrs["ended"] == END
    assert branch.values[[0, -1]] == pytest.approx([150, 160])
    assert (tmp_path / "branch_response.png").exists()


def test_a_branch_broken_off_is_kept_as_far_as_it_is(tmp_path, monkeypatch):
    path, calls = bending_column(tmp_path), []

    def broken(*arguments):
        calls.append(arguments)
        if len(calls) == 3:
            raise MechanismError("the disk is gone")
        return result_of(*arguments)

    monkeypatch.setattr("fenics_mech.studies.follow.result_of", broken)
    monkeypatch.setattr("fenics_mech._console.PAUSE", 0)
    over = ["--over", "drive.speed=150:160", "--points", "4"]
    found = CliRunner().invoke(app, ["follow", str(path), *over, "-o", str(tmp_path)])
    assert str(found.exception) == "the disk is gone"
    assert found.stderr.splitlines()[0] == "drive.speed = 150"
    branch = Branch.load(tmp_path / "branch.nc")
    assert branch.data.sizes["point"] == 2
    assert branch.data.attrs["ended"] == "broken off: the disk is gone"


@pytest.mark.parametrize("count", [{"points": 0}, {"points": np.nan}, {"points": np.inf}, {"most_points": 1}])
def test_numbers_of_points_that_never_end_are_refused(count):
    with pytest.raises(SceneError, match="a branch has a point or more"):
        follow(beam(mesh__elements=2), "drive.speed", (0.9 * OMEGA, 1.3 * OMEGA), **count)


def test_a_branch_that_does_not_end_says_so():
    found = follow(beam(mesh__elements=2), "drive.speed", (0.9 * OMEGA, 1.3 * OMEGA), points=4, most_points=3)
    assert not found.whole
    assert found.data.sizes["point"] == 3
    assert "3 points" in found.data.attrs["ended"]


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"analysis__method": "quasi-static"}, "analysis.method"),
        ({"analysis__solver": "harmonic-balance"}, "analysis.solver"),
    ],
)
def test_scenes_that_cannot_be_followed_are_refused(changes, place):
    with pytest.raises(SceneError, match=place):
        follow(beam(**changes), "drive.speed", (20.0, 30.0))


def test_ranges_are_read():
    scene = beam()
    assert parse_range(scene, "drive.speed=60 rpm:30 rpm") == ("drive.speed", pytest.approx((2 * np.pi, np.pi)))
    for text, message in (
        ("drive.speed=1:2:3", "Write PATH=START:STOP,"),
        ("drive.speed=1", "cannot read"),
        ("drive.speed=2:2", "begins where it ends"),
        ("drive.speed=1:60 rpm", "one end"),
        ("mesh.elements=1:3", "whole number"),
        ("drive.sped=1:3", "no 'sped'"),
    ):
        with pytest.raises(SceneError, match=message):
            parse_range(scene, text)
    with pytest.raises(MechanismError, match="sense of turning"):
        follow(scene, "drive.speed", (-20.0, 20.0))
