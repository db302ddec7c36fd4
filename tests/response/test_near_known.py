"""A mechanism beside a known one, against its own equation as it is assembled."""

import numpy as np
import pytest

from fenics_mech.eigenmodes import natural
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import elastic_response
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.near_known import BesideKnown, KnownModes, modes_beside, residual_of_links
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import mechanism
from fenics_mech.scene.factories import seed_four_bar
from tests.common import scene_modes
from tests.response.synthetic import PERIOD, Manufactured, places

EFFECTS = [
    {"effects": ()},
    {"effects": ("coupling", "geometric-stiffness")},
    {"effects": ("large-rotations", "coupling"), "damping": {"ratio": 0.0, "material": 1e-5}},
    {"effects": ("coupling",), "gravity": (0, -9.81), "analysis": {"sub_intervals": 12, "reduction": "craig-bampton"}},
    {"effects": ("coupling",), "dampers": {"d": {"between": ("ground.C", "coupler.B"), "damping": 3.0}}},
    {"effects": ("coupling",), "springs": {"s": {"between": ("ground.C", "coupler.B"), "stiffness": 900.0}}},
]


def four_bar(**changes):
    return seed_four_bar(**{"analysis": {"sub_intervals": 12}} | changes)


def state(system, seed=0):
    """Some displacement and two derivatives at all positions, small enough for exact strains."""
    sizes = np.array([1e-4, 1e-2, 1.0])[:, None, None]
    return sizes * np.random.default_rng(seed).standard_normal((3, len(system.motion.theta), system.size))


@pytest.mark.parametrize("changes", EFFECTS, ids=" ".join)
def test_the_residual_by_the_links_forces_is_that_of_the_matrices(changes):
    system = mechanism(four_bar(**changes))
    q, rate, second = state(system)
    expected = Equation(system).residual(q, rate, second)
    found = residual_of_links(Equation(system), q, rate, second)
    size = np.abs(Equation(system).linear.stiffness.times(q)).max()
    assert np.abs(found - expected).max() < 1e-12 * size  # rounding


def damped(scene):
    system = mechanism(scene)
    return Equation(system, modal_damping(scene.damping.ratio, system))


@pytest.mark.parametrize("effects", [(), ("coupling",), ("coupling", "large-rotations")])
def test_differences_beside_a_known_equation_are_those_of_whole_equations(effects):
    """Of the residual, of all parts of the response and of frequencies; the step leaves an error of 1e-8."""
    step, known = 1e-4, damped(four_bar(effects=effects))
    scenes = [
        four_bar(effects=effects).changed(
            {"materials.material.modulus": 71e9 * (1 + by), "masses.A.mass": 0.0452 * (1 - by), "damping.ratio": zeta}
        )
        for by, zeta in ((step, 0.02 * (1 + step)), (-step, 0.02 * (1 - step)))
    ]
    whole = [damped(scene) for scene in scenes]
    held = [natural(equation.system).held_matrices() for equation in whole]
    mass, stiffness = (more + -1.0 * less for more, less in zip(*held))
    factor = known.modal_damping.values
    change = 0.02 * KnownModes.of(known.system).change_of_damping(mass, stiffness) / 2
    change += step * factor.transpose(0, 2, 1) @ factor
    beside = [BesideKnown(known, one.system, sign * change) for sign, one in zip((1, -1), whole)]
    q, rate, _ = state(known.system)
    second = known.acceleration(q, rate)

    def slope(pair):
        return (pair[0] - pair[1]) / (2 * step)

    exact = slope([one.residual(q, rate, second) for one in whole])
    near = slope([one.residual(q, rate, second) for one in beside])
    np.testing.assert_allclose(near, exact, atol=1e-7 * np.abs(exact).max())
    found = [one.response(q, rate, one.acceleration(q, rate, second)) for one in beside]
    full = [elastic_response(one, q, rate) for one in whole]
    parts = {
        "inertia": lambda one: one.inertia,
        "strain of damping": lambda one: one.modal_damping.displacement,
        "inertia of damping": lambda one: one.modal_damping.acceleration,
    }
    if "large-rotations" in effects:
        parts["forces on the bent axis"] = lambda one: one.modal_damping.on_bent_axis
    for name, part in parts.items():
        exact = slope([part(one) for one in full])
        np.testing.assert_allclose(
            slope([part(one) for one in found]), exact, atol=1e-6 * np.abs(exact).max(), err_msg=name
        )
    modes = scene_modes(four_bar(effects=effects), known.system)
    quick = slope([modes_beside(modes, *one).frequency for one in held])
    exact = slope([scene_modes(scene, one.system).frequency for scene, one in zip(scenes, whole)])
    np.testing.assert_allclose(quick, exact, atol=1e-6 * np.abs(exact).max())


def test_several_loads_are_solved_for_as_each_alone():
    tableau, count = Tableau.of("radau", 3), 24
    matrices = Manufactured().matrices(places(tableau.points, count))
    loads = np.random.default_rng(3).standard_normal((len(matrices.load), matrices.mass.size, 7))
    alone = [Flow(Matrices(*vars_of(matrices), load), tableau, PERIOD / count) for load in np.moveaxis(loads, -1, 0)]
    expected = np.stack([flow.cycle.solve(flow.added) for flow in alone], axis=-1)
    flow = Flow(Matrices(*vars_of(matrices), loads), tableau, PERIOD / count)
    assert flow.cycle._by_monodromy(np.moveaxis(flow.added, -1, 0)) is not None
    np.testing.assert_allclose(flow.cycle.solve(flow.added), expected, atol=1e-10 * np.abs(expected).max())


def vars_of(matrices):
    return matrices.mass, matrices.damping, matrices.stiffness


def test_the_matrix_of_a_cycle_that_cannot_close_is_no_answer():
    flow = Flow(Manufactured().matrices(places(Tableau.of("radau", 3).points, 24)), Tableau.of("radau", 3), PERIOD / 24)
    wrong = np.full((2, *flow.added.shape), np.nan)
    assert flow.cycle._by_monodromy(wrong) is None
    with pytest.raises(SolverError):
        flow.cycle.solve(np.moveaxis(wrong, 0, -1))
