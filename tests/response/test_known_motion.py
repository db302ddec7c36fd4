"""A motion as the beginning of another: on its own mesh it is itself, on others Newton's method has little to do."""

from dataclasses import replace

import numpy as np
import pytest

from fenics_mech.accuracy.periodic_errors import collocation_errors
from fenics_mech.beams.other_mesh import elemental_on, nodal_on
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic import collocation, newton, steady_state
from fenics_mech.response.periodic.known_motion import KnownMotion, interpolation
from fenics_mech.response.periodic.newton import NEWTON
from fenics_mech.response.periodic.steady_state import by_collocation
from fenics_mech.response.setup import mechanism
from fenics_mech.scene import Mesh
from fenics_mech.scene.factories import seed_four_bar


def scene_with(elements, steps):
    return seed_four_bar(
        effects=("coupling", "large-rotations"),
        mesh=Mesh(elements=elements),
        analysis={
            "sub_intervals": steps,
            "stages": 3,
            "scheme": "radau",
            "allow_coarse": True,
            "stability": False,
            "reduction": "none",
        },
    )


def solved(scene, near=None):
    system = mechanism(scene)
    return by_collocation(scene, system, solve_modes(system, 3), near)


@pytest.fixture(scope="module")
def coarse():
    """The seed by few elements and steps: its equation, its orbit, and its motion."""
    solution = solved(scene_with(2, 40))
    equation = solution.cycle.at_points(solution.cycle.tableau)
    return equation, solution.orbit, KnownMotion.of(equation, solution.orbit)


@pytest.fixture
def iterations(monkeypatch):
    """Positions of the equations that were linearised, one an iteration."""
    found, linearised = [], Equation.linearised

    def counted(self, *state):
        found.append(len(state[0]))
        return linearised(self, *state)

    monkeypatch.setattr(Equation, "linearised", counted)
    return found


def test_on_its_own_mesh_a_motion_is_itself(coarse):
    equation, orbit, motion = coarse
    same = motion.at(equation)
    for found, known in ((same.displacement, orbit.displacement), (same.velocity, orbit.velocity)):
        assert np.abs(found - known).max() < 1e-9 * np.abs(known).max()  # rounding; P^T P is well conditioned
    assert np.abs(same.tension - motion.tension).max() < 1e-9 * np.abs(motion.tension).max()


def test_a_motion_is_interpolated_between_its_positions_also_across_the_ends_of_a_turn():
    h = 2 * np.pi / 60
    known = h * np.add.outer(np.arange(60), [0.155, 0.645, 1.0]).ravel()
    places = np.linspace(-1.0, 9.0, 500)
    missed = np.abs(interpolation(known, places) @ np.cos(5 * known) - np.cos(5 * places)).max()
    assert missed < 5**6 / 720 * (1.875 * (0.51 * h) ** 3) ** 2  # remainder of six points that are 0.51 h apart


@pytest.mark.parametrize("elements", [1, 2, 3, 7])
def test_a_cubic_is_the_same_on_every_mesh(elements):
    """A member that is stretched evenly and bent by a cubic, turned in its link's axes as the coupler may be."""
    scenes = [scene_with(count, 40).changed(mesh__grading=1.3) for count in (2, elements)]
    old, new = (mechanism(scene).beams.mesh for scene in scenes)

    def nodal(mesh):
        values = np.zeros((len(mesh.node_name), 3))
        for member, nodes, start, length in zip(mesh.cell_member, mesh.cell_nodes, mesh.cell_start, mesh.cell_length):
            x = (start + np.array([0.0, length])) / mesh.member_length[member]
            along, across, turned = 0.2 * x, x**3 - 0.4 * x**2, (3 * x**2 - 0.8 * x) / mesh.member_length[member]
            c, s = np.cos(mesh.member_angle[member]), np.sin(mesh.member_angle[member])
            values[nodes] = np.stack([c * along - s * across, s * along + c * across, turned], axis=1)
        return values.ravel()

    assert nodal_on(new, old) @ nodal(old) == pytest.approx(nodal(new), abs=1e-12)
    middles = [mesh.cell_start + mesh.cell_length / 2 for mesh in (old, new)]
    assert elemental_on(new, old) @ middles[0] == pytest.approx(middles[1], abs=1e-12)  # of elements linear in place


def test_newton_begins_beside_the_motion(coarse, iterations):
    """From a motion with 7 % of error the change is squared twice; from nothing it takes two iterations more."""
    scene = scene_with(5, 60)
    cold = solved(scene)
    from_nothing = len(iterations)
    warm = solved(scene, coarse[2])
    assert len(iterations) - from_nothing < from_nothing
    difference = np.abs(warm.orbit.displacement - cold.orbit.displacement).max()
    assert difference < 1e-8 * np.abs(cold.orbit.displacement).max()  # Newton's tolerance is 1e-9 of the whole


@pytest.mark.parametrize("damping", [{"ratio": 0.02}, {"material": 3e-4}])
def test_tangents_that_are_used_again_lead_to_the_same_motion_and_errors(damping, iterations, monkeypatch):
    """From a motion with 2 % of error; errors are by the equation linearised about the answer."""
    scene = scene_with(2, 60).changed(damping=damping)
    near = KnownMotion.of((begun := solved(scene)).cycle.at_points(begun.cycle.tableau), begun.orbit)
    near, made, found = replace(near, displacement=1.02 * near.displacement), [], []
    for limits in (NEWTON, replace(NEWTON, reuse_below=0.0)):
        monkeypatch.setattr(newton, "NEWTON", limits)
        iterations.clear()
        found.append(solved(scene, near))
        made.append(len(iterations))
    assert made[0] < made[1]
    (orbit, alone), size = (each.orbit for each in found), np.abs(found[1].orbit.displacement).max()
    assert not orbit.linearised_here  # the tangents are 2 % away from the answer
    assert alone.linearised_here
    assert np.abs(orbit.displacement - alone.displacement).max() < 1e-8 * size  # Newton's tolerance is 1e-9 of it
    again, once = (collocation_errors(solution) for solution in found)
    for source, part in once.items():
        own, other = (errors.response.displacement - alone.start for errors in (part, again[source]))
        assert np.abs(own - other).max() < 1e-4 * np.abs(own).max()  # the orbits differ by less than 1e-8


def test_where_nothing_is_found_beside_it_newton_begins_from_nothing(coarse, monkeypatch):
    def fails(*_):
        raise SolverError("no motion found")

    monkeypatch.setattr(collocation, "improved", fails)
    scene = scene_with(3, 48)
    assert (solved(scene, coarse[2]).orbit.displacement == solved(scene).orbit.displacement).all()


def test_newton_begins_from_the_motion_by_longer_steps(iterations, monkeypatch):
    scene = scene_with(2, 360)
    found = solved(scene).orbit.displacement
    assert iterations.count(3 * 360) <= 3  # of 3 points in each of 360 steps; 6 from nothing
    monkeypatch.setattr(steady_state, "_by_longer_steps", lambda cycle: None)
    assert np.abs(found - solved(scene).orbit.displacement).max() < 1e-8 * np.abs(found).max()


def test_where_longer_steps_find_nothing_newton_begins_from_nothing(monkeypatch):
    monkeypatch.setattr(steady_state.KnownMotion, "of", lambda equation, orbit: None)
    assert np.isfinite(solved(scene_with(2, 360)).orbit.displacement).all()


def test_a_motion_that_ends_at_a_share_of_the_load_is_not_sought_by_all_steps(iterations, coarse):
    scene = scene_with(2, 360).changed(drive__speed=48.0)
    with pytest.raises(UnresolvedError, match=r"at 0\.\d+ of the load") as failed:
        solved(scene, coarse[2])
    assert 0 < failed.value.found_up_to < 1
    assert 0 < iterations.count(3 * 360) <= NEWTON.most_iterations  # beside the known motion alone
    assert iterations.count(3 * 90) > 30


def test_a_motion_goes_on_along_a_straight_line_unless_the_other_is_far(coarse):
    motion = coarse[2]
    near, far = (
        replace(motion, displacement=share * motion.displacement, tension=share * motion.tension)
        for share in (0.9, 0.5)
    )
    ahead = motion.beyond(near, 2.0)
    assert ahead.displacement == pytest.approx(1.2 * motion.displacement, rel=1e-12, abs=1e-18)
    assert ahead.tension == pytest.approx(1.2 * motion.tension, rel=1e-12, abs=1e-18)
    assert (ahead.velocity == motion.velocity).all()
    assert motion.beyond(far, 2.0) is motion
    assert motion.beyond(replace(near, turned=motion.turned + 0.1), 2.0) is motion


def test_linear_strains_have_nothing_to_begin_from():
    scene = scene_with(2, 40).changed(effects=("coupling",))
    solution = solved(scene)
    assert KnownMotion.of(solution.cycle.at_points(solution.cycle.tableau), solution.orbit) is None


def test_positions_in_a_short_pulse_are_not_magnified_beside_it():
    """A motion turns a corner in a step of 1e-4 rad: beside it the polynomial was off by twice the largest value."""
    angles = 2 * np.pi * (np.arange(48) + 0.5) / 48
    turned = np.sort(np.concatenate([angles, np.pi + 1e-4 * np.array([0.16, 0.64, 1.0])]))
    places = np.linspace(0, 2 * np.pi, 1001)
    found = interpolation(turned, places) @ np.abs(turned - np.pi - 5e-5)
    assert found == pytest.approx(np.abs(places - np.pi), abs=0.05)  # where the cycle ends and the curve turns as well
