"""Slider-crank and manipulator of the demos against hand-coded models with a sixth-order periodic integrator."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene import load
from tests.common import DEMOS
from tests.validation.manipulator_arm import ManipulatorModel, ManipulatorParameters
from tests.validation.reference.gauss_legendre import gauss_legendre_periodic
from tests.validation.reference.nine_element import element_gyroscopic, element_mass, element_stiffness, modes_of
from tests.validation.reference.strain import link_strain
from tests.validation.slider_crank_linkage import SliderCrankModel, SliderCrankParameters
from tests.validation.two_links import element_matrices

ELEMENTS = 3


def slider_crank():
    bar, strip = 25e-3 * 10e-3, 25e-3 * 3e-3
    return SliderCrankModel(
        SliderCrankParameters(
            lengths=(0.06, 0.3),
            area=(bar, strip),
            inertia=(bar * 10e-3**2 / 12, strip * 3e-3**2 / 12),
            fibre=(5e-3, 1.5e-3),
            E=71e9,
            rho=2714.0,
            omega1=60.0,
            mass=(0.03, 0.12),
            offset=0.01,
        ),
        ELEMENTS,
    )


def manipulator():
    # cos^3 = (3 cos + cos 3)/4 in the elbow's law
    upper, fore, degree = 40e-3 * 6e-3, 30e-3 * 4e-3, np.pi / 180
    return ManipulatorModel(
        ManipulatorParameters(
            lengths=(0.5, 0.4),
            area=(upper, fore),
            inertia=(upper * 6e-3**2 / 12, fore * 4e-3**2 / 12),
            fibre=(3e-3, 2e-3),
            E=71e9,
            rho=2714.0,
            omega1=np.pi,
            mass=(0.25, 0.1),
            turning=(1e-4, 0.5e-4),
            shoulder=(40 * degree, (-30 * degree,), (0.0, 5 * degree)),
            elbow=(0.9, (-0.375, 0.0, -0.125), (0.2,)),
        ),
        ELEMENTS,
    )


CASES = {"slider_crank": slider_crank, "manipulator": manipulator}


def scene_of(name, **rest):
    scene = load(DEMOS / f"{name}.toml")
    for link in scene.links:
        member = next(iter(scene.links[link].members))
        scene = scene.changed(**{f"links__{link}__members__{member}__mesh": {"elements": ELEMENTS}})
    return scene.changed(**rest)


@pytest.mark.parametrize("name", CASES)
def test_frequencies_agree(name):
    scene, model = (
        scene_of(name, analysis__sub_intervals=24, analysis__modes=6, analysis__allow_ringing=True),
        CASES[name](),
    )
    found = analyse(scene.changed(analysis__allow_coarse=True)).data  # frequencies need few positions
    by_hand = modes_of(*model.mass_stiffness(found["theta"].to_numpy()), 6)[0] / (2 * np.pi)
    assert np.allclose(np.sort(found["frequency"].to_numpy(), axis=1), by_hand, rtol=1e-9)


def test_element_matrices_are_the_typed_ones():
    m, k, s = element_matrices(0.3, 0.11, 5e3, 7.0)
    assert np.allclose(m, element_mass(0.3, 0.11), rtol=1e-12)
    assert np.allclose(k, element_stiffness(1.0, 5e3, 7.0, 0.11), rtol=1e-12)
    assert np.allclose(s, element_gyroscopic(0.3, 0.11), rtol=1e-12, atol=1e-18)


@pytest.fixture(scope="module")
def by_hand():
    """Strain at mid-span of both links by the hand-coded models, ``(960, 2)``."""
    found = {}
    for name, model in CASES.items():
        answer = gauss_legendre_periodic(model(), 960)
        found[name] = link_strain(model(), answer.theta, answer.displacement, answer.acceleration).total
    return found


def apart(scene, strain):
    """Largest difference of the mid-span strains over the largest strain, per link."""
    found = analyse(scene).data["strain"].sel(fibre="+", s=0.5).to_numpy()
    return np.abs(found - strain[:: len(strain) // len(found)]).max(axis=0) / np.abs(strain).max(axis=0)


@pytest.mark.parametrize("name", CASES)
def test_periodic_strain_agrees_within_the_error_of_the_scheme(name, by_hand):
    assert apart(scene_of(name, analysis__sub_intervals=480), by_hand[name]).max() < 1e-3
    static = scene_of(name, analysis__sub_intervals=480, analysis__method="quasi-static")
    assert apart(static, by_hand[name])[1] > 0.02  # what the agreement is worth: the vibration that is agreed on


def test_what_is_left_of_the_difference_is_of_the_modes_left_out(by_hand):
    few, more = (
        apart(scene_of("slider_crank", analysis__sub_intervals=960, analysis__modes=n), by_hand["slider_crank"])
        for n in (4, 8)
    )
    assert (more < 0.4 * few).all()
