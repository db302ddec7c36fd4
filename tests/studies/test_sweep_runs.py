"""Runs of a sweep: which points begin from others, and that their motions are the same."""

import logging

import numpy as np
import pytest

from fenics_mech.response.periodic.known_motion import KnownMotion
from fenics_mech.response.setup import CommonParts
from fenics_mech.solve import Path
from fenics_mech.solve.stages import radau
from fenics_mech.studies import kept_answers
from fenics_mech.studies.kept_motions import read_motion, read_steps, write_motion
from fenics_mech.studies.sweep import run_sweep
from fenics_mech.studies.sweep_axes import parse_axes
from fenics_mech.studies.sweep_runs import LONGEST, longest_run, runs_of, shrinking_runs, with_peaks

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
    ("run", "told"),
    [
        (range(7), [0, 1, "0", 2, "1", 3, "2", 4, "3", 5, "4", 6, "6"]),  # 2 and 4 of a curve that is flat there
        (range(1, 4), [1, 2, 3, "2"]),  # whether 1 and 3 are peaks the run does not know
        ([0, 1, 3, 4, 5], [0, 1, "0", 3, 4, 5, "4"]),
        ([6], [6]),
    ],
)
def test_a_run_tells_peaks_as_soon_as_they_are_known(run, told):
    curves, done = [[0, 0], [2, 1], [1, 1], [3, 0], [0, 0], None, [4, 4]], []

    def strains(index):
        assert done[-1] == index
        return curves[index]

    for task in with_peaks(list(run), 7, int, str, strains):
        done.append(task)
    assert done == told


@pytest.mark.slow
def test_estimates_of_a_kept_answer_are_those_of_a_second_analysis(seed, tmp_path, monkeypatch):
    scene = seed.changed({**EXACT, "effects": ["coupling"], "analysis.error_estimates": True})
    axes = parse_axes(scene, ["drive.speed=10:30:4"])
    kept = run_sweep(scene, axes, tmp_path / "kept", estimates="peaks")
    monkeypatch.setattr(kept_answers, "LARGEST", 0)
    again = run_sweep(scene, axes, tmp_path / "again", estimates="peaks")
    assert np.isfinite(kept.data["error_estimate"]).sum() >= 2
    assert kept.data.identical(again.data)


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
            found[longest] = run_sweep(scene, axes, tmp_path / str(longest)).data
        told = iterations(caplog)  # of each motion
        counts[longest] = sum(told)
        caplog.clear()
    for name in ("peak_strain", "peak_deflection", "peak_joint_force", "peak_input_torque"):
        alone, beside = found[1][name].to_numpy(), found[LONGEST][name].to_numpy()
        assert beside == pytest.approx(alone, rel=NEWTON)
        assert not np.array_equal(beside[1:], alone[1:])  # else they did not begin from others
        assert np.array_equal(beside[0], alone[0])
    assert counts[LONGEST] <= counts[1] - 2


@pytest.mark.long
@pytest.mark.slow
def test_peaks_have_estimates_of_their_answer_or_begin_from_their_own_motion(seed, tmp_path, caplog, monkeypatch):
    scene = seed.changed(EXACT | {"analysis.error_estimates": True, "mesh.elements": 6})  # which asks for no halves
    axes = parse_axes(scene, [SPEEDS])
    whole = run_sweep(scene, axes, tmp_path / "all", estimates="all").data
    for most, again in ((kept_answers.LARGEST, 0), (0, 1)):  # with answers kept, and without
        monkeypatch.setattr(kept_answers, "LARGEST", most)
        caplog.clear()
        with caplog.at_level(logging.DEBUG, "fenics_mech.response.periodic.newton"):
            found = run_sweep(scene, axes, tmp_path / f"peaks {most}", estimates="peaks").data
        estimated = np.isfinite(found["error_estimate"].to_numpy())
        assert 2 <= (peaks := int(estimated.sum())) < 4
        counts = iterations(caplog)
        assert counts.count(1) == 4 + again * peaks  # motions that were solved for
        assert counts[len(counts) - again * peaks - 1] > 1  # the last of those without estimates
        assert counts[len(counts) - again * peaks :] == [1] * (again * peaks)  # what is left of them is rounding
        # estimates are linear about a motion, and Newton's last tangents are those of one up to 1e-4 beside it
        for name, apart in (("peak_strain", 1e-6), ("error_estimate", 1e-4)):
            assert found[name].to_numpy()[estimated] == pytest.approx(whole[name].to_numpy()[estimated], rel=apart)
    assert not list(tmp_path.rglob("*.motion"))


def test_a_motion_that_does_not_fit_is_not_read(seed, tmp_path):
    mesh = CommonParts().links(seed).mesh
    dofs, elements = 3 * len(mesh.node_name), len(mesh.cell)
    parts = [np.arange(4.0), *(np.ones((4, count)) for count in (dofs, dofs, elements))]
    write_motion(tmp_path / "motion.motion", KnownMotion(mesh, *parts))
    assert (read_motion(tmp_path / "motion.motion", mesh).tension == 1).all()
    assert read_motion(tmp_path / "motion.motion", CommonParts().links(seed.changed(mesh__elements=2)).mesh) is None
    assert read_motion(tmp_path / "none.motion", mesh) is None
    (tmp_path / "motion.motion").write_bytes(b"PK of another kind")
    assert read_motion(tmp_path / "motion.motion", mesh) is None


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
    one, two = (run_sweep(scene, axes, tmp_path / str(jobs), jobs=jobs, estimates="peaks").data for jobs in (1, 2))
    assert one.identical(two)
