"""Gaps of sweeps: motions are followed into them through folds, and unstable ones are kept apart."""

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.analysis import analyse
from fenics_mech.recovery.peaks import peak_of
from fenics_mech.scene import Scene
from fenics_mech.studies.gauge import Gauge
from fenics_mech.studies.kept_points import TEXTS
from fenics_mech.studies.point_curves import ANGLES, angles, packed_curves, unpacked_curves
from fenics_mech.studies.sweep import sweep
from fenics_mech.studies.sweep_axes import parse_axes, placed, scene_data
from fenics_mech.studies.sweep_gaps import LOST, ahead, fill_gaps, gaps_of, in_words
from fenics_mech.studies.sweep_run import SweepRun
from fenics_mech.studies.worker_processes import Workers
from fenics_mech.views.sweep_data import unstable_points, without_unstable
from fenics_mech.views.sweep_summary import sweep_summary
from tests.common import DEMOS
from tests.response.forced import folds
from tests.studies.test_follow import CUBIC, FORCE, OMEGA, RATIO, beam

NOTHING = dict.fromkeys(TEXTS, "") | {"again": False, "seconds": 0.0}


def test_gaps_are_runs_of_points_without_a_stable_motion():
    good, lost = NOTHING, NOTHING | {"error": "SolverError"}
    loose, apart = NOTHING | {"unstable": "it grows"}, NOTHING | {"error": "AssemblyError"}
    assert gaps_of([good, lost, loose, good, apart, lost]) == [range(1, 3), range(5, 6)]
    assert gaps_of([good, good]) == []


@pytest.mark.slow
@pytest.mark.parametrize("solver", [pytest.param("poses", marks=pytest.mark.long)])
def test_a_motion_is_followed_to_where_it_turns_back(solver):
    """Against Duffing's oscillator: its upper motions end at the first fold, the lower ones at the second."""
    data = scene_data(beam().changed(analysis__error_estimates=False, analysis__solver=solver))

    def at(value):
        return Scene.read(placed(data, {"drive.speed": value}))

    first, second = np.sort(folds(2 * RATIO, CUBIC, FORCE)[:, 0])[::-1] * OMEGA
    inside = 1.05 * OMEGA
    up = ahead(at, "drive.speed", (0.95 * OMEGA, 1.35 * OMEGA), [inside])
    assert 0.9 * first < up.ended <= first * 1.0005
    assert "a fold" in up.how
    assert up.reached[inside][0]
    down = ahead(at, "drive.speed", (1.35 * OMEGA, 0.95 * OMEGA), [1.3 * OMEGA])
    assert second * 0.9995 <= down.ended < 1.1 * second
    said = in_words([up, down], lambda value: f"{value:.3g} rad/s")
    assert said.startswith("By continuation the motion of ")
    assert said.count(" is stable ") == 2  # "up to" a value, or "at" one, as three digits tell


@pytest.mark.slow
@pytest.mark.parametrize("solver", [pytest.param("poses", marks=pytest.mark.long)])
def test_points_that_a_stable_motion_passes_are_answered(tmp_path, solver):
    """A point that is taken to have failed gets the answer of an analysis by itself; no other does."""
    scene = beam(analysis__solver=solver)
    axes = parse_axes(scene, [f"drive.speed={0.9 * OMEGA}:{1.02 * OMEGA}:4"])
    values = axes[0].values
    with Workers(1) as workers:
        run = SweepRun(scene_data(scene), axes, tmp_path, Gauge(), _Alone(), lambda *_: None, workers, False)
        run.points.mkdir(parents=True)
        run.compute([(value,) for value in values])
        whole = run.records([(value,) for value in values])
        failed = NOTHING | {"error": "UnresolvedError", "message": "no motion found"}
        found = fill_gaps(run, values, [whole[0], failed, failed, whole[3]])
    for record, known in zip(found, whole):
        assert record["error"] == ""
        assert record["values"]["peak_strain"] == pytest.approx(known["values"]["peak_strain"], rel=1e-6)
    assert LOST == "NoStableMotion"


class _Alone:
    """A communicator of one process."""

    rank, size = 0, 1

    def bcast(self, found):
        return found

    def allgather(self, found):
        return [found]


@pytest.mark.slow
def test_unstable_points_keep_their_numbers_apart_from_the_largest(tmp_path):
    """Mathieu's column: what is kept is the answer that `allow_unstable` gives, and no largest value is of it."""
    scene = load(DEMOS / "pulsating_column.toml").changed({"analysis.allow_unstable": True})
    axes = parse_axes(scene, ["drive.speed=150:240:3"])
    allowed = sweep(scene, axes, tmp_path / "allowed").data
    judged = sweep(scene.changed({"analysis.allow_unstable": False}), axes, tmp_path / "judged")
    loose = unstable_points(allowed).to_numpy()
    assert loose.any()
    assert ((judged.data["unstable"] != "").to_numpy() == loose).all()
    assert (judged.data["error"] == "").all()
    assert judged.data["peak_strain"].to_numpy() == pytest.approx(allowed["peak_strain"].to_numpy(), rel=1e-9)
    assert np.isnan(without_unstable(judged.data)["peak_strain"].to_numpy()[loose]).all()
    assert any("UNSTABLE, and not among the largest" in str(part) for part in sweep_summary(judged).renderables)


def test_kept_curves_are_those_of_the_result():
    scene = load(DEMOS / "four_bar.toml").changed(
        {"analysis.method": "quasi-static", "analysis.sub_intervals": ANGLES, "effects": ()}
    )
    result = analyse(scene)
    found = unpacked_curves(packed_curves(result), scene)
    order = np.argsort(np.mod(np.round(result.data["theta"].to_numpy(), 9), 2 * np.pi))
    strain = result.data["strain"].transpose("theta", "member", "s", "fibre").to_numpy()[order]
    assert angles()[1] == pytest.approx(np.radians(3))
    assert found["curve_strain_highest"] == pytest.approx(strain.max(axis=(2, 3)), abs=3e-5 * np.abs(strain).max())
    assert found["curve_strain_lowest"] == pytest.approx(strain.min(axis=(2, 3)), abs=3e-5 * np.abs(strain).max())
    most = np.abs(peak_of(result, "joint_force")[2])
    assert found["curve_joint_force"].max(axis=0) == pytest.approx(most, rel=0.01)  # peaks lie between positions
    text = packed_curves(result)
    assert unpacked_curves(text[:-8], scene) is None
    assert unpacked_curves("no base64", scene) is None
