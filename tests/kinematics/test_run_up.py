"""Motion in time: run-ups against closed forms, high-order differences and the steady motion."""

import numpy as np
import pytest

from fenics_mech.errors import SceneError
from fenics_mech.scene.factories import manipulator, seed_four_bar

SPEED, RUN_UP = 32.3, 0.4
NAMES = ("position", "velocity", "acceleration", "angle", "omega", "alpha")
STRIP = {"area": 1e-4, "inertia": 1e-10, "fibre": 1e-3}
METAL = {"modulus": 7e10, "density": 2700}
# eighth-order central differences
WEIGHTS = {-4: 1 / 280, -3: -4 / 105, -2: 1 / 5, -1: -4 / 5, 1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
RAMP = {"kind": "expression", "formula": "0.5 * 32.3 / 0.4 * t**2"}
WAVERING = {
    "kind": "table",
    "times": [0.0, 0.1, 0.2, 0.3, 0.4],
    "angles": ["0 deg", "20 deg", "70 deg", "160 deg", "330 deg"],
}


def running(**rest):
    return seed_four_bar(drive__run_up=RUN_UP, **rest)


def two_arms():
    law = {"kind": "harmonics", "mean": 0.3, "sine": [0.4, 0.1]}
    other = {"kind": "expression", "formula": "1.2 + 0.5*cos(theta)**2"}
    sections, masses = [STRIP] * 2, [{"mass": 0.1}] * 2
    return manipulator(arms=(0.3, 0.2), sections=sections, material=METAL, laws=(law, other), period=0.7, masses=masses)


def largest_difference(one, other):
    """Largest difference of two motions, each quantity over its own largest value."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in NAMES]
    return max(np.abs(a - b).max() / max(np.abs(b).max(), 1e-300) for a, b in pairs)


def test_angle_speed_and_acceleration_of_the_smooth_start():
    # speed = SPEED (10 x^3 - 15 x^4 + 6 x^5): at the middle half of it, with 30/16 of the mean acceleration
    drive = running().drive
    jet = drive.coordinate(np.array([0.0, RUN_UP / 2, RUN_UP, 3 * RUN_UP]))
    assert jet.value == pytest.approx(
        [0, SPEED * RUN_UP * (2.5 - 1.5 + 0.25) / 16, SPEED * RUN_UP / 2, 2.5 * SPEED * RUN_UP]
    )
    assert jet.first == pytest.approx([0, SPEED / 2, SPEED, SPEED])
    assert jet.second == pytest.approx([0, 30 / 16 * SPEED / RUN_UP, 0, 0])


def test_table_goes_through_its_points():
    jet = running(drive__run_up_law=WAVERING).drive.coordinate(np.array(WAVERING["times"]))
    assert np.degrees(jet.value) == pytest.approx([0, 20, 70, 160, 330])
    assert (jet.first[0], jet.second[0]) == pytest.approx((0, 0), abs=1e-9)
    assert (jet.first[-1], jet.second[-1]) == pytest.approx((SPEED, 0), abs=1e-9)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"run_up": -1.0}, "greater than 0"),
        ({"run_up": "3 m"}, "wrong unit"),
        ({"run_up_law": RAMP}, "needs its duration"),
        ({"run_up": 0.5, "run_up_law": RAMP}, "ends with 40.375 rad/s, and the drive goes on with 32.3"),
        ({"run_up": 0.5, "run_up_law": WAVERING}, "table ends at 0.4 s, and the run-up at 0.5 s"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "1 + 0.5 * 32.3 / 0.4 * t**2"}}, "start with an angle of 0"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "log(t)"}}, "not finite"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "1/0"}}, "not finite"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "theta"}}, "may not stand in a formula"),
        ({"run_up": 0.4, "run_up_law": {**WAVERING, "times": [0, 0.2, 0.1, 0.3, 0.4]}}, "times must increase"),
        ({"run_up": 0.4, "run_up_law": {**WAVERING, "times": [0, 0.4]}}, "the same number of both"),
        ({"speed": None, "law": {"kind": "harmonics", "sine": [0.3]}, "period": 1.0, "run_up": 0.4}, "has none"),
    ],
)
def test_bad_run_ups_are_refused(values, words):
    with pytest.raises(SceneError, match=words):
        seed_four_bar(**{f"drive__{key}": value for key, value in values.items()})
