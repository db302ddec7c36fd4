"""System matrices: symmetry, energy, and derivatives of P."""

from dataclasses import replace

import numpy as np
import pytest

from fenics_mech.kinematics import solve_motion
from fenics_mech.response.setup import mechanism
from fenics_mech.scene.factories import seed_four_bar
from tests.validation.check import coupling


def test_27_coordinates_with_names(seed_system):
    names = seed_system.transformation.names
    assert seed_system.size == len(set(names)) == 27
    assert {"A.X", "A.Y", "B.X", "B.Y", "crank.A.rotation", "coupler.A.rotation", "follower.C.rotation"} <= set(names)
    assert not any(name.startswith(("O.", "C.", "crank.O", "follower.C.x")) for name in names)


def test_matrices_are_symmetric_and_positive(seed_system):
    for _, mass, stiffness in seed_system.positions():
        for matrix in (mass[:, :], stiffness[:, :]):
            assert np.abs(matrix - matrix.T).max() < 1e-12 * np.abs(matrix).max()
            assert np.linalg.eigvalsh(matrix / np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))).min() > 0


def test_derivatives_of_p_against_central_differences(seed):
    theta, h = np.linspace(0, 6, 7), 1e-5
    system = mechanism(seed)
    here, ahead, behind = (solve_motion(seed, theta + d) for d in (0, h, -h))
    values = system.transformation.values
    first, second = system.transformation.derivatives(here)
    speed = seed.drive.speed
    assert np.allclose(first, (values(ahead) - values(behind)) / (2 * h) * speed, atol=1e-7 * np.abs(first).max())
    rate = (
        (system.transformation.derivatives(ahead)[0] - system.transformation.derivatives(behind)[0]) / (2 * h) * speed
    )
    assert np.allclose(second, rate, atol=1e-7 * np.abs(second).max())


def test_full_equation_has_the_damping_of_a_hamiltonian_system(seed_system):
    # C = 2 P^T m P' + 2 P^T m_v P is M' plus a skew matrix, so that no energy is made
    k, h = 5, 1e-6
    scene = seed_four_bar(analysis={"sub_intervals": 24})
    theta = seed_system.motion.theta[k]
    damping = coupling(seed_system)[0][k]
    system = mechanism(scene)
    near = [replace(system, motion=solve_motion(scene, np.array([theta + d]))) for d in (h, -h)]
    ahead, behind = (next(iter(s.positions()))[1][:, :] for s in near)
    rate = (ahead - behind) / (2 * h) * scene.drive.speed
    symmetric = damping + damping.T
    assert np.abs(symmetric - 2 * rate).max() < 1e-6 * np.abs(damping).max()


def test_load_does_the_virtual_work_of_the_rigid_inertia(seed_system):
    # load = -dT-like virtual work: a rigid acceleration field weighed by m through P
    p_values = seed_system.values
    expected = seed_system.transformation.backward(
        p_values, -(seed_system.link_mass @ seed_system.rigid_acceleration.T).T
    )
    dense = np.zeros(seed_system.transformation.shape)
    k = 3
    dense[seed_system.transformation.rows, seed_system.transformation.columns] = p_values[k]
    by_hand = -dense.T @ seed_system.link_mass.toarray() @ seed_system.rigid_acceleration[k]
    assert np.allclose(expected[k], by_hand, rtol=1e-12, atol=1e-12 * np.abs(by_hand).max())


@pytest.mark.parametrize("turn", [0.7, 2.5])
def test_turning_the_whole_scene_changes_no_frequency_and_no_strain(turn):
    from fenics_mech import analyse

    plain = seed_four_bar(analysis={"sub_intervals": 24})
    c, s = np.cos(turn), np.sin(turn)
    data = plain.model_dump()
    # the ground turns; the drive angle is measured from the fixed x axis, so the start of the cycle moves with it
    x, y = data["ground"]["points"]["C"]
    data["ground"]["points"]["C"] = (c * x - s * y, s * x + c * y)
    for link in ("coupler", "follower"):
        data["links"][link]["angle"] += turn
    count = 24 * 5
    shift = turn / (2 * np.pi) * count
    reference = analyse(plain.changed(analysis={"sub_intervals": count, "method": "quasi-static"}))
    data["links"]["crank"]["points"] = {"O": (0, 0), "A": (0.10795 * np.cos(turn), 0.10795 * np.sin(turn))}
    turned = analyse(
        type(plain).model_validate(data).changed(analysis={"sub_intervals": count, "method": "quasi-static"})
    )
    assert shift  # the crank's own frame is turned back, so that drive angle 0 is the same position
    assert np.allclose(turned.strain_at("coupler"), reference.strain_at("coupler"), rtol=0, atol=1e-12)
