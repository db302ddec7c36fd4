"""Drives from rest to rest: their laws, the torque of a rigid arm, and the vibration that a move leaves."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.scene.rest_to_rest import POLYNOMIALS
from tests.common import response_of

WAY, PERIOD = 0.5, 2.0
PEAKS = {  # of the acceleration, of the way over the time of the move squared
    "polynomial-3-4-5": 10 / np.sqrt(3),
    "polynomial-4-5-6-7": 84 * np.sqrt(5) / 25,
    "cycloidal": 2 * np.pi,
}


def law(profile="cycloidal", **changes):
    return fm.RestToRest(**({"end": WAY, "out": (0.1, 0.3), "back": (0.6, 0.8), "profile": profile} | changes))


def rest_to_rest(profile, links, way=WAY, **others):
    """Give one arm that turns about the pin O by the law."""
    return fm.Scene(
        name="arm",
        ground=fm.Ground(points={"O": (0, 0)}),
        links=links,
        joints={"O": fm.Revolute(connect=("ground.O", "arm.O"))},
        drive=fm.Drive(joint="O", law=law(profile, end=way), period=PERIOD),
        **others,
    )


@pytest.mark.parametrize("profile", PEAKS)
def test_moves_begin_and_end_at_rest_and_have_the_peak_of_the_textbook(profile):
    shares = np.array([0.0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.7, 0.8, 0.9])
    jet = law(profile, start=0.2, end=0.2 + WAY).jet(2 * np.pi * shares)
    assert jet.value == pytest.approx(0.2 + WAY * np.array([0, 0, 0.5, 1, 1, 1, 0.5, 0, 0]), abs=1e-12)
    still = [0, 1, 3, 4, 5, 7, 8]
    assert np.abs([jet.first[still], jet.second[still]]).max() < 1e-11
    fine = law(profile).jet(2 * np.pi * np.linspace(0.1, 0.3, 20001)).second
    assert np.abs(fine).max() * (2 * np.pi * 0.2) ** 2 / WAY == pytest.approx(PEAKS[profile], rel=1e-6)


@pytest.mark.parametrize("profile", PEAKS)
def test_rates_are_the_derivatives_of_the_places(profile):
    theta, h = np.linspace(0.0, 6.0, 101), 1e-5
    one, jet = law(profile), law(profile).jet(theta)
    before, after = one.jet(theta - h), one.jet(theta + h)
    assert jet.first == pytest.approx((after.value - before.value) / (2 * h), abs=1e-7)  # h^2, and rounding over h
    assert jet.second == pytest.approx((after.first - before.first) / (2 * h), abs=2e-3)  # the rate jumps at corners


@pytest.mark.parametrize("profile", PEAKS)
def test_torque_of_a_rigid_arm_is_its_inertia_by_the_acceleration(profile):
    arm = fm.Link(points={"O": (0, 0), "A": (1, 0)}, rigid=fm.RigidBody(mass=2.0, inertia=0.3, centre=(0.5, 0)))
    analysis = fm.Analysis(method="quasi-static", sub_intervals=200)
    data = fm.analyse(rest_to_rest(profile, {"arm": arm}, analysis=analysis)).data
    acceleration = law(profile).jet(np.asarray(data.theta)).second * (2 * np.pi / PERIOD) ** 2
    expected = (0.3 + 2.0 * 0.5**2) * acceleration
    assert np.asarray(data.input_torque) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def residual_by_duhamel(profile, way, frequency):
    """Amplitude that the outward move leaves in ``w'' + frequency^2 w = -way s''``, by the integral of Duhamel."""
    time = PERIOD * np.linspace(0.1, 0.3, 200001)
    acceleration = way * law(profile, end=1.0).jet(2 * np.pi * time / PERIOD).second * (2 * np.pi / PERIOD) ** 2
    return abs(trapezoid(acceleration * np.exp(1j * frequency * time), time)) / frequency


@pytest.mark.slow
@pytest.mark.parametrize("profile", PEAKS)
def test_vibration_that_a_move_leaves_is_the_integral_of_duhamel(profile):
    """A spring of a beam without mass, and a mass at its tip: one mode, here of 3.6 Hz, at small moves.

    The tension of a move by 0.5 rad makes it 0.4 % less, in proportion to the square of the way.
    """
    way = 2e-3 * WAY
    mass, length, width, height, modulus = 1.0, 0.5, 0.02, 0.004, 200e9
    arm = fm.Link(
        points={"O": (0, 0), "A": (length, 0)},
        members={"OA": fm.Member(ends=("O", "A"), section="bar", material="light")},
    )
    scene = rest_to_rest(
        profile,
        {"arm": arm},
        way,
        materials={"light": fm.Material(modulus=modulus, density=1e-3)},
        sections={"bar": fm.RectangleSection(width=width, height=height)},
        masses={"tip": fm.PointMass(at="arm.A", mass=mass)},
        mesh=fm.Mesh(elements=2),
        analysis=fm.Analysis(method="transient", cycles=1, sub_intervals=400, time_tolerance=1e-7),
    )
    data = response_of(scene).data
    frequency = np.sqrt(3 * modulus * width * height**3 / 12 / length**3 / mass)
    tip = residual_by_duhamel(profile, way * length, frequency)
    dwell = (data.time.values > 0.62) & (data.time.values < 1.18)
    waves = np.exp(1j * frequency * data.time.values[dwell])
    strain = data.strain.values[dwell, 0, 0, 0]  # at the clamped end
    parts, left, *_ = np.linalg.lstsq(np.stack([waves.real, waves.imag], axis=1), strain, rcond=None)
    assert np.hypot(*parts) == pytest.approx(3 * tip * height / 2 / length**2, rel=1e-6)  # the beam weighs 4e-8 of it
    assert np.sqrt(left[0] / len(strain)) < 1e-6 * np.hypot(*parts)  # nothing else is left


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"out": (0.3, 0.1)}, "must be shares of the cycle that increase"),
        ({"back": (0.2, 0.8)}, "back begins when out has ended"),
        ({"back": (0.6, 1.2)}, "less than or equal to 1"),
        ({"end": 0.0}, "would not move"),
        ({"profile": "trapezoid"}, "polynomial-3-4-5"),
    ],
)
def test_moves_that_contradict_themselves_are_refused(changes, message):
    with pytest.raises(SceneError, match=message):
        law(**changes)


def test_every_profile_is_tested():
    assert set(PEAKS) == {*POLYNOMIALS, "cycloidal"}
