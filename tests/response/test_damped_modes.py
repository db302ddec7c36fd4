"""Damping of slow modes only, against that of all modes, in models of many coordinates."""

import numpy as np
import pytest

from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of
from tests.demos.test_invariance import turned

BLOW = {"impulses": {"blow": {"at": "coupler.B", "angle": 1.0, "impulse": (0.0, 0.002)}}}
PULSE = {"kind": "pulse", "start": 1.0, "end": 2.0}
JUMP = {"loads": {"jump": {"at": "coupler.B", "force": (5.0, -3.0), "factor": PULSE}}}
SPRING = {"springs": {"line": {"between": ("coupler.B", "ground.O"), "stiffness": 1000.0}}}
HINGE = {"springs": {"hinge": {"joint": "C", "stiffness": 50.0, "angle": 1.7}}}


def many(**more):
    return seed_four_bar(
        mesh={"elements": 6},
        damping={"ratio": 0.02},
        effects=("coupling",),
        analysis={"sub_intervals": 60, "stations": 5, "allow_coarse": True, "stability": False},
        **more,
    )


# The second is nearer to a resonance.


def test_damped_modes_are_those_of_a_similar_machine():
    """Turned, or with all rates three times as high, it has the same strains."""
    scene = many()
    data = scene.model_dump()
    for material in data["materials"].values():
        material["modulus"] *= 9
    data["drive"]["speed"] *= 3
    plain = response_of(scene).data["strain"].to_numpy()
    for other in (Scene.read(data), Scene.read(turned(scene, 0.7))):
        found = response_of(other).data["strain"].to_numpy()
        assert found == pytest.approx(plain, abs=1e-8 * np.abs(plain).max())
