"""Mesh and steps that a scene does not state are as fine as its answer needs; stated ones are kept."""

import json

import numpy as np
import pytest

from fenics_mech import analyse, load
from fenics_mech.errors import SolverError, TooLargeError, UnresolvedError
from fenics_mech.planning.fine_enough import FINE, fine_enough, finer_numbers, free_numbers, with_numbers
from fenics_mech.scene.factories import seed_four_bar
from tests.cases.test_between_positions import four_bar
from tests.common import DEMOS, response_of, too_coarse

PLAIN = {"method": "quasi-static", "sub_intervals": 36, "stability": False}


class Analyser:
    """Refuses scenes until they have so many elements."""

    def __init__(self, enough, answered=True):
        self.enough, self.answered, self.asked = enough, answered, []

    def __call__(self, scene):
        self.asked.append(scene.mesh.elements)
        if scene.mesh.elements >= self.enough or scene.analysis.allow_coarse:
            return Found()
        times = 1.1 * self.enough / scene.mesh.elements
        raise UnresolvedError("the elements are too long. Take more").finer_by(self.answered, elements=times)


class Found:
    """A result with attributes alone."""

    def __init__(self):
        self.data = type("Data", (), {"attrs": {}})()


def test_what_is_stated_stays_known_in_changed_scenes():
    """A key that a file or a call states is stated, also where it is the default; others are the program's."""
    scene = load(DEMOS / "slider_crank.toml")  # which states sub_intervals and modes, and no mesh
    assert free_numbers(scene).keys() == {"elements", "harmonics", "time_tolerance"}
    assert free_numbers(scene.changed({"drive.speed": 10.0})).keys() == free_numbers(scene).keys()
    assert "elements" not in free_numbers(scene.changed(mesh__elements=3))
    assert scene.changed(mesh__elements=3) == scene
    assert "solver" not in free_numbers(scene.changed(analysis__solver="collocation"))


def test_a_free_mesh_is_refined_and_a_stated_one_is_kept():
    free, stated = seed_four_bar(), seed_four_bar(mesh={"elements": 3})
    wanting = Analyser(5)
    result = fine_enough(free, wanting)
    assert wanting.asked[0] == 3
    assert wanting.asked[-1] >= 5
    assert json.loads(result.data.attrs["refined"]) == {"elements": wanting.asked[-1]}
    kept = Analyser(5)
    result = fine_enough(stated, kept)
    assert kept.asked == [3, 3]  # the second time with its error
    assert result.data.attrs["coarse_because"] == "the elements are too long. Take more"


def test_the_search_is_bounded():
    """Beyond its limit an answer comes with its error, and where there is none the refusal does."""
    wanting = Analyser(10**6)
    fine_enough(seed_four_bar(), wanting)
    assert max(wanting.asked) <= FINE.most_times * 3
    assert len(wanting.asked) <= FINE.most_rounds + 1
    with pytest.raises(UnresolvedError, match="too long"):
        fine_enough(seed_four_bar(), Analyser(10**6, answered=False))

    def out_of_memory(scene):
        if scene.mesh.elements > 3 and not scene.analysis.allow_coarse:
            raise TooLargeError("too large")
        return Analyser(4)(scene)

    assert fine_enough(seed_four_bar(), out_of_memory).data.attrs["coarse_because"]


def test_errors_that_nothing_finer_cures_pass_through():
    def unstable(scene):
        raise SolverError("unstable")

    with pytest.raises(SolverError, match="unstable"):
        fine_enough(seed_four_bar(), unstable)


def test_numbers_go_to_members_without_a_mesh_of_their_own():
    scene = seed_four_bar(links__coupler__members__AB__mesh={"elements": 2})
    fine = with_numbers(scene, {"elements": 7.0, "sub_intervals": 400.0})
    meshes = {label: (member.mesh or fine.mesh).elements for label, (_, member) in fine.members().items()}
    assert meshes == {"crank": 7, "coupler": 2, "follower": 7}
    assert fine.analysis.sub_intervals == 400
    error = UnresolvedError("").finer_by(sub_intervals=500)
    assert finer_numbers({"elements": 3}, {"elements": 3}, error) == {"elements": 3}  # steps are stated


@pytest.mark.slow
def test_steps_that_are_the_programs_to_choose_meet_what_is_allowed():
    """Against 2880 sub-intervals: 360 are refused, and those chosen are within the 2 % that steps may take."""
    steps = {"modes": 4, "critical_speeds": False, "solver": "sub-intervals"}
    scene = seed_four_bar(effects=(), analysis=steps, drive={"joint": "O", "speed": 40.0}, damping={"ratio": 0.01})
    assert "sub-intervals are too long" in too_coarse(scene.changed(analysis__sub_intervals=360))
    result = analyse(scene)
    count = json.loads(result.data.attrs["refined"])["sub_intervals"]
    fine = response_of(scene.changed(analysis__sub_intervals=2 * count)).data["strain"]
    error = np.abs(result.data["strain"].to_numpy() - fine.interp(theta=result.data["theta"]).to_numpy())
    assert "coarse_because" not in result.data.attrs
    assert float(np.nanmax(error) / np.abs(fine).max()) < 0.02


def test_too_few_positions_for_a_corner_are_the_programs_to_choose():
    """A crank-rocker 1e-5 beside its change point turns within 0.01 rad: 360 positions miss it."""
    scene = four_bar(24, 1e-5)
    free = scene.model_copy(
        update={"analysis": type(scene.analysis)(**{k: v for k, v in scene.analysis if k in ("method", "solver")})}
    )
    result = analyse(free)
    assert json.loads(result.data.attrs["refined"])["sub_intervals"] > 360
    assert float(result.data["joint_force_relative_error"].sel(source="positions")) < 0.05
