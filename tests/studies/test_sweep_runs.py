"""Runs of a sweep: which points begin from others, and that their motions are the same."""

import logging

import numpy as np
import pytest

from fenics_mech.solve import Path
from fenics_mech.solve.stages import radau
from fenics_mech.studies.sweep import sweep
from fenics_mech.studies.sweep_axes import parse_axes
from fenics_mech.studies.sweep_points import read_steps, write_motion
from fenics_mech.studies.sweep_run import LONGEST, longest_run, runs_of, shrinking_runs

EXACT = {
    "effects": ["coupling", "large-rotations"],
    "analysis.solver": "collocation",
    "analysis.sub_intervals": 40,
    "analysis.allow_coarse": True,
    "analysis.error_estimates": False,
    "analysis.stability": False,
}
LOGGER = "fenics_mech.solve.periodic"
SPEEDS = "drive.speed=34:36:4"  # where Newton's method takes 4 iterations from nothing
NEWTON = 1e-8  # of the peaks: Newton's method ends at 1e-9 of the displacement


def test_runs_are_of_neighbours():
    line = [(float(k),) for k in range(12)]
    assert runs_of(line, range(12), 5) == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9], [10, 11]]
    assert runs_of(line, range(12), 1) == [[k] for k in range(12)]
    assert runs_of([], [], 5) == []


def test_a_run_stays_in_its_row_of_a_grid():
    grid = [(float(row), float(column)) for row in range(2) for column in range(3)]
    assert runs_of(grid, range(6), 5) == [[0, 1, 2], [3, 4, 5]]


def test_what_is_missing_of_a_run_is_one_too():
    line = [(float(k),) for k in range(8)]
    assert runs_of(line, [3, 4, 7], 4) == [[3], [4, 7]]
    assert runs_of(line, [0, 2, 4], 4) == [[0, 2], [4]]


def test_points_that_do_not_depend_on_others_are_shared_in_runs_that_shrink():
    runs = shrinking_runs(range(20), 2)
    assert list(map(len, runs)) == [5, 3, 3, 2, 1, 1, 1, 1, 1, 1, 1]
    assert [point for run in runs for point in run] == list(range(20))
    assert shrinking_runs([3, 5, 8], 1) == [[3, 5, 8]]
    assert shrinking_runs([], 2) == []


@pytest.mark.parametrize(
    ("changes", "longest"),
    [
        ({"effects": "auto"}, LONGEST),
        ({"effects": ["coupling", "large-rotations"]}, LONGEST),
        ({"effects": ["coupling"]}, 1),
        ({"effects": "auto", "analysis.method": "quasi-static"}, 1),
    ],
)
def test_motions_that_need_newtons_method_begin_from_others(seed, changes, longest):
    assert longest_run(seed.changed(changes)) == longest


def iterations(caplog):
    return [record.args[0] for record in caplog.records if record.msg.startswith("Newton %d")]


@pytest.mark.slow
def test_motions_that_begin_from_others_are_the_same_in_fewer_iterations(seed, tmp_path, caplog, monkeypatch):
    scene = seed.changed(EXACT | {"analysis.solver": "poses"})
    axes = parse_axes(scene, [SPEEDS])
    found, counts = {}, {}
    for longest in (1, LONGEST):
        monkeypatch.setattr("fenics_mech.studies.sweep_run.longest_run", lambda scene, longest=longest: longest)
        with caplog.at_level(logging.DEBUG, LOGGER):
            found[longest] = sweep(scene, axes, tmp_path / str(longest)).data
        told = iterations(caplog)  # of each motion
        counts[longest] = sum(told)
        caplog.clear()
    for name in ("peak_strain", "peak_deflection", "peak_joint_force", "peak_input_torque"):
        alone, beside = found[1][name].to_numpy(), found[LONGEST][name].to_numpy()
        assert beside == pytest.approx(alone, rel=NEWTON)
        assert not np.array_equal(beside[1:], alone[1:])  # else they did not begin from others
        assert np.array_equal(beside[0], alone[0])
    assert counts[LONGEST] <= counts[1] - 2


def test_a_motion_of_poses_is_read_as_it_was_written(tmp_path):
    path, rest = tmp_path / "motion.motion", np.linspace(0.0, 0.18, 4)
    shape = len(rest), 3, 7
    made = Path(
        radau(3), rest, 0.2, 5, *(np.random.default_rng(0).normal(size=s) for s in (shape[::2], shape[::2], shape))
    )
    write_motion(path, made)
    found = read_steps(path).paced(0.2)
    assert found.alike(made)
    for name in ("q0", "v0", "a"):
        assert getattr(found, name) == pytest.approx(getattr(made, name), rel=1e-14)
    content = path.read_bytes()
    for wrong in (content[:-8], content[:16], b"PK of another kind", np.full(40, -1.0).tobytes()):
        path.write_bytes(wrong)
        assert read_steps(path) is None
    assert read_steps(tmp_path / "none.motion") is None


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["collocation", "poses"])
def test_the_result_does_not_depend_on_the_number_of_processes(seed, tmp_path, solver):
    scene = seed.changed(EXACT | {"analysis.error_estimates": True, "analysis.solver": solver})
    axes = parse_axes(scene, [SPEEDS])
    one, two = (sweep(scene, axes, tmp_path / str(jobs), jobs=jobs, estimates="peaks").data for jobs in (1, 2))
    assert one.identical(two)
