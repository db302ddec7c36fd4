"""Frequencies of beams about a bent state, against an independent program: rigid rods joined by torsional springs."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh

from fenics_mech.analysis import analyse
from tests.effects import strips

EI = strips.E * strips.INERTIA
UNIT = np.sqrt(EI / (strips.RHO * strips.A * strips.L**4))  # rad/s


def of_rods(force, count):
    """Three frequencies (UNIT) of a cantilever of rods under a dead force at its tip (EI/L^2), and the tip's turn.

    Their springs have EI over the rods' length, the first one twice that. The angles of the rods are the coordinates.
    """
    h, (along, across) = 1 / count, force
    springs = np.full(count, 1 / h)
    springs[0] *= 2
    turns = np.eye(count) - np.eye(count, k=-1)
    bending = turns.T @ (springs[:, None] * turns)
    angle = np.sin(np.pi / 2 * (np.arange(count) + 0.5) * h)
    for _ in range(40):
        stiffness = bending + np.diag(h * (along * np.cos(angle) + across * np.sin(angle)))
        left = bending @ angle + h * (along * np.sin(angle) - across * np.cos(angle))
        angle = angle - np.linalg.solve(stiffness, left)
    i = np.arange(count)
    beyond = count - 1 - np.maximum.outer(i, i)  # rods that both of a pair carry
    carried = h**3 * (0.5 + beyond)
    carried[i, i] = h**3 * (1 / 3 + np.diag(beyond))
    mass = carried * np.cos(angle[:, None] - angle)
    squares = eigh(stiffness, mass, eigvals_only=True, subset_by_index=(0, 2))
    return np.append(np.sqrt(squares), angle[-1])


def known(force):
    """The same of a beam: the error falls with the square of the rods' length."""
    found = [of_rods(force, count) for count in (40, 80, 160)]
    once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(found)]
    return (16 * once[1] - once[0]) / 15


def clamped(force, elements, sub_intervals):
    """The cantilever, beside a crank that turns by itself: its multipliers are those of the cantilever at rest."""
    crank = {"points": {"P": (0, 0), "Q": (0.1, 0)}, "rigid": {"mass": 1.0, "inertia": 1.0}}
    return strips.beam({"O": {"kind": "weld"}}).changed(
        ground__points={"O": (0, 0), "C": (0, -1)},
        links__crank=crank,
        joints__crank={"connect": ("ground.C", "crank.P")},
        drive={"joint": "crank", "speed": UNIT},
        loads={"tip": {"at": "beam.B", "force": tuple(np.array(force) * EI / strips.L**2)}},
        damping={"material": 1e-7},
        effects=("coupling", "large-rotations"),
        mesh={"elements": elements},
        analysis={"sub_intervals": sub_intervals, "modes": 3, "allow_coarse": True},
    )


def test_rods_have_the_frequencies_of_a_straight_cantilever():
    # roots of cos(b) cosh(b) = -1
    assert known((0.0, 0.0))[:3] == pytest.approx(np.square([1.8751041, 4.6940911, 7.8547574]), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "turn", "elements", "sub_intervals"),
    [((0.0, 2.0), 0.78, 12, 96), ((0.0, 4.0), 1.12, 12, 96), ((-2.7141, 0.3), 1.16, 12, 96)],
    ids=["bent", "far", "buckled"],  # the last one is under 1.1 times the load at which it buckles
)
def test_frequencies_of_a_bent_cantilever(force, turn, elements, sub_intervals):
    expected = known(force)
    data = analyse(clamped(force, elements, sub_intervals)).data
    assert data["rotation"].item() == pytest.approx(expected[3], rel=1e-4)
    assert expected[3] == pytest.approx(turn, abs=0.01)
    found, which = (data[name].to_numpy() for name in ("multiplier_frequency", "multiplier_mode"))
    for mode in np.unique(which):
        # the mean stretch of an element, h^2: 2e-4, where it buckles 5e-4, of the second mode 1e-3; a straight
        # cantilever is 18 to 36 % off
        assert 2 * np.pi * found[which == mode] / UNIT == pytest.approx(expected[mode - 1], rel=6e-4 * mode)
