"""Errors that act back on themselves, against operators whose answer is known."""

import numpy as np
import pytest

from fenics_mech.accuracy.feedback import FEEDBACK, fed_back

ANGLE = np.linspace(0, 2 * np.pi, 24, endpoint=False)
FORMS = np.array([np.ones_like(ANGLE), np.cos(2 * ANGLE), np.sin(2 * ANGLE), np.cos(7 * ANGLE), np.sin(7 * ANGLE)])
FIRST = np.array([0.3, 0.2, 0.1, 0.2, 0.1])


def operator(real, imaginary):
    """Harmonic 2 times 0.01, harmonic 7 times ``real + i imaginary``."""
    matrix = np.diag([0.001, 0.01, 0.01, real, real])
    matrix[3, 4], matrix[4, 3] = imaginary, -imaginary
    return matrix


def along(values):
    return (np.asarray(values) @ FORMS)[:, None] * [1.0, 2.0]


def applied(matrix, motion):
    return along(matrix @ np.linalg.lstsq(FORMS.T, motion[:, 0], rcond=None)[0])


@pytest.mark.parametrize(("real", "imaginary"), [(0.05, 0.02), (0.4, 0.05), (-0.9, 0.3), (0.3, 0.35)])
def test_all_that_an_error_does_to_itself(real, imaginary):
    matrix = operator(real, imaginary)
    exact = np.linalg.solve(np.eye(5) - matrix, FIRST)
    found, near = fed_back(along(FIRST), lambda motion: applied(matrix, motion), np.array([1.0, 0.0]))
    assert not near
    assert np.linalg.lstsq(FORMS.T, found[:, 0], rcond=None)[0] == pytest.approx(exact, rel=0.02, abs=0.005)


def test_nothing_is_amplified_without_resonance():
    calls = []

    def again(motion):
        calls.append(1)
        return applied(operator(0.02, 0.0), motion)

    found, _ = fed_back(along(FIRST), again, np.ones(2))
    assert len(calls) == 1
    assert found == pytest.approx(along(FIRST), rel=0.03, abs=0.03)


def test_what_no_resonance_makes_felt_is_not_followed():
    """What is left by rounding of a fine mesh has no harmonics: it would be followed to the end, and amplified."""
    size = float(np.linalg.norm(along(FIRST)))
    found, near = fed_back(along(FIRST), pytest.fail, np.ones(2), within=1.01 * size / FEEDBACK.unfelt)
    assert np.array_equal(found, along(FIRST))
    assert not near


def test_what_300_times_would_not_make_felt_costs_nothing():
    calls = []

    def again(motion):
        calls.append(1)
        return applied(operator(1.0, 0.1), motion)

    fed_back(along([1.0, 0.0, 0.0, 1.5e-4, 0.0]), again, np.ones(2))
    assert len(calls) == 1


def test_no_error():
    nothing = np.zeros((24, 2))
    assert fed_back(nothing, lambda motion: motion, np.ones(2))[0] is nothing


@pytest.mark.parametrize(("real", "imaginary", "near"), [(0.95, 1e-3, True), (3.0, 0.2, True), (0.3, 0.1, False)])
def test_a_resonance_is_near(real, imaginary, near):
    matrix = operator(real, imaginary)
    assert fed_back(along(FIRST), lambda motion: applied(matrix, motion), np.ones(2))[1] is near


def test_an_operator_that_is_linear_for_little_only():
    matrix = operator(0.4, 0.1)

    def again(motion):
        return applied(matrix, motion) + 100 * motion**2

    exact, _ = fed_back(along(FIRST), lambda motion: applied(matrix, motion), np.ones(2))
    found, _ = fed_back(along(FIRST), again, np.ones(2), within=1e-4)
    assert found == pytest.approx(exact, rel=0.02, abs=0.02)
