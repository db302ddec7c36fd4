"""Geometric stiffness whose axial forces are updated with the response."""

import numpy as np
import pytest

from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.forces.joint_forces import nodal_forces
from fenics_mech.response.axial_forces import settle
from fenics_mech.response.periodic.steady_state import by_collocation
from fenics_mech.response.setup import mechanism
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.studies.effect_costs import largest_difference
from tests.common import response_of, scene_modes


@pytest.mark.slow
def test_settled_axial_forces_bring_the_strains_nearer_to_large_rotations(seed):
    scene = seed.changed(drive__speed=15.0, analysis__sub_intervals=120, analysis__stability=False)
    whole = response_of(scene.changed(effects=("coupling", "large-rotations")))
    rigid, settled = (
        response_of(scene.changed(effects=("coupling", "geometric-stiffness"), analysis__tension=tension))
        for tension in ("rigid", "settled")
    )
    assert largest_difference(settled, whole) < largest_difference(rigid, whole) / 5
    # bending at 15 rad/s shortens the members by about a thousandth of the deflection
    assert largest_difference(settled, whole) < 2e-3


def test_settled_axial_forces_are_those_of_the_response(seed):
    scene = seed.changed(effects=("geometric-stiffness",), analysis__method="quasi-static", analysis__sub_intervals=24)
    system = mechanism(scene)
    settled = settle(system, solve_static)
    tension = mean_tension(settled, solve_static(settled))
    assert tension == pytest.approx(settled.terms.stiffening.force, abs=1e-7 * np.abs(tension).max())
    # the bent members hang on their pins at another angle than the straight ones: that is felt, if hardly here
    assert np.abs(tension - system.terms.stiffening.force).max() > 1e-6 * np.abs(tension).max()


def test_recovered_forces_with_settled_axial_forces_are_in_equilibrium(seed):
    scene = seed.changed(
        effects=("coupling", "geometric-stiffness"),
        drive__speed=15.0,
        analysis__sub_intervals=60,
        analysis__tension="settled",
        analysis__stability=False,
    )
    system = mechanism(scene)
    solution = by_collocation(scene, system, scene_modes(scene, system))
    system, forces = solution.system, nodal_forces(solution.system, solution.response)
    lack = system.transformation.backward(system.values, forces)  # P^T of all forces on the nodes
    assert np.abs(lack).max() < 1e-9 * np.abs(forces).max()
