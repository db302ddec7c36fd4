"""Laws of joints in the march of poses: rates after contacts against closed forms, by the tolerance of its steps."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.stated_freedoms import with_freedoms
from tests.joints.scenes import bar
from tests.joints.test_bending import slider_crank

RUBS = {"kind": "friction", "coefficient": 0.2}


@pytest.mark.parametrize("stribeck", [{}, {"static": 0.3, "stribeck": 0.05}])
def test_tangents_of_friction_are_those_of_differences(stribeck):
    """By rates, and by the multipliers of the pin's rows: forces of 1 N are linear to 1e-7 in 1e-4 of them."""
    scene = with_freedoms(bar(RUBS | stribeck | {"radius": 0.1, "width": 0.02}, freedoms={"O": {"speed": 0.3}}))
    machine = machine_of(scene).machine
    rng = np.random.default_rng(1)
    t, q, v, a = np.zeros(1), np.zeros((1, machine.size)), *rng.uniform(-0.3, 0.3, (2, 1, machine.size))
    a[:, machine.n :] *= 20
    found = machine.residual(t, q, v, a)
    for matrix, number in ((found.M, 2), (found.C, 1)):
        dense = found.pattern.dense(matrix[0])[: machine.n]
        for column in range(machine.size if number == 2 else machine.n):
            beside = []
            for step in (1e-6, -1e-6):
                moved = [q.copy(), v.copy(), a.copy()]
                moved[number][0, column] += step
                beside.append(machine.residual(t, *moved, tangents=False).force[0, : machine.n])
            np.testing.assert_allclose(dense[:, column], (beside[0] - beside[1]) / 2e-6, atol=1e-7)


def test_a_pin_that_rubs_has_rows_between_links_that_bend():
    """Its force is told as that of a pin without rows, which shares a place."""
    changes = {"analysis.duration": 0.01, "analysis.sub_intervals": 4, "analysis.start": "smooth"}
    small = {"rod": {"kind": "friction", "coefficient": 1e-9, "joint": "A", "radius": 0.01, "width": 1e-2}}
    with_rows, without = (fm.analyse(slider_crank(True, joint_laws=laws, **changes)).data for laws in (small, {}))
    force, shared = (data["joint_force"].to_numpy() for data in (with_rows, without))
    np.testing.assert_allclose(force, shared, atol=1e-3 * np.abs(shared).max())  # both by their steps
    found = np.abs(with_rows["law_effort"].to_numpy()[1:, 0])
    np.testing.assert_allclose(found, 1e-11 * np.linalg.norm(force[1:, 1], axis=-1), rtol=1e-3)
