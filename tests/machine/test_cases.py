"""Scenes whose arms and guides move far: linearised joints refuse or warn of them, poses have the right values."""

import numpy as np
import pytest

from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import equilibrium
from tests.cases.test_moving_guides import GUIDE, exactly
from tests.cases.test_rigid_arms import EA, EI, LENGTH, cantilever, cantilever_with_arm, column, critical


def held(scene):
    """Give the machine of a scene at rest, its coordinates and its multipliers."""
    made = machine_of(scene)
    q, a = equilibrium(made.machine)
    return made, q, a


def moved(made, q, point):
    """Give how far a point moves (m)."""
    machine, end = made.machine, made.end(point)
    Q = np.append(q, 0.0)[machine.places[end.pose]]
    before = machine.R[end.pose] @ end.offset
    return Q[:2] + machine.geometry.turn(Q[None, 2:])[0] @ before - before


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_a_column_with_a_rigid_arm_deflects_as_the_elastica(share):
    force = share * critical(LENGTH, 0.2)
    _, (_, y, _) = cantilever_with_arm((-force, 1e-3 * force), (0.2, 0.0), LENGTH, EI, EA)
    made, q, _ = held(column(share))
    assert moved(made, q, "beam.A")[1] == pytest.approx(y, rel=1e-3)  # 10 elements


@pytest.mark.parametrize("arm", [0.1, -0.1])
def test_a_cantilever_with_an_arm_up_or_down_is_held_as_the_elastica(arm):
    right = abs(cantilever_with_arm((0.0, -20.0), (0.0, arm), LENGTH, EI, EA)[0])
    made, _, a = held(cantilever((0, arm)))
    moment = abs(a[made.machine.n + made.driven[0]]) if made.driven else abs(a[made.machine.n])
    assert moment == pytest.approx(right, rel=1e-3)  # they differ by 4.4 %


def test_a_guide_on_a_bending_link_is_held_as_the_elastica():
    force, right = exactly(GUIDE)
    made, q, a = held(GUIDE)
    assert abs(a[made.machine.n]) == pytest.approx(force, rel=1e-3)  # 10 elements
    assert np.linalg.norm(right) == pytest.approx(5.0922e-3, rel=1e-4)
    np.testing.assert_allclose(moved(made, q, "crank.A"), right, atol=1e-5 * np.linalg.norm(right))
