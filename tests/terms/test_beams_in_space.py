"""The twist inside beam elements: stresses and stiffness against differences of the energy, and its sign."""

import numpy as np
import pytest

from fenics_mech.terms import Beams, Element


@pytest.mark.parametrize("bending", [(9.0, 2.0), (2.0, 9.0), (4.0, 4.0)])
def test_stresses_are_the_gradient_of_the_energy(bending):
    beams, t = Beams([], [Element.uniform(0.7, 5.0, bending, 1.5)]), np.zeros(1)
    x, step = np.random.default_rng(0).normal(size=(1, 1, 6)), 1e-6
    found = beams.respond(t, x, 0 * x)
    for i in range(6):
        ahead, behind = (x + sign * step * np.eye(6)[i] for sign in (1, -1))
        by_energy = (beams.energy(t, ahead) - beams.energy(t, behind)) / (2 * step)
        by_stress = (beams.respond(t, ahead, 0 * x).stress - beams.respond(t, behind, 0 * x).stress) / (2 * step)
        # central differences lose 1e-16/1e-6 to rounding; numbers are of the order 100
        np.testing.assert_allclose(found.stress[..., i], by_energy, atol=1e-7)
        np.testing.assert_allclose(found.by_measure[..., i], by_stress, atol=1e-7)


@pytest.mark.parametrize("flatness", [3, 10, 100])
def test_a_flat_strip_has_positive_energy_however_far_its_elements_bend(flatness):
    thin = 0.02 / flatness
    bending, torsion = [200e9 * thin * 0.02**3 / 12, 200e9 * 0.02 * thin**3 / 12], 77e9 * 0.02 * thin**3 / 3
    beams = Beams([], [Element.uniform(0.1, 1e6, bending, torsion)])
    p, r = np.meshgrid(np.linspace(0.1, 2, 20), np.linspace(0, 2, 21))  # curvature modes (rad), r = 0: without twist
    x = np.zeros((p.size, 1, 6))
    x[:, 0, 3], x[:, 0, 4] = p.ravel(), r.ravel()
    energy = beams.energy(np.zeros(p.size), x).reshape(p.shape)
    without = (bending[0] * p**2 + bending[1] * r**2) / 0.2
    assert (energy >= without / 6).all()  # up to 5/6 of the difference of both stiffnesses
    assert (energy[1:] < without[1:]).all()
