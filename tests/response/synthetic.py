"""Equations of motion with known answers, for the solvers of the periodic response."""

import numpy as np

from fenics_mech.scene import Scene

PERIOD = 2 * np.pi / 3


def places(points, count, period=PERIOD):
    """Times at places in every one of `count` steps."""
    return (period / count * (np.arange(count)[:, None] + points)).ravel()


def arm(speed, **rest):
    """A steel arm on a turning shaft, bent by its weight, which turns against it."""
    strip = {"shape": "rectangle", "width": "20 mm", "height": "2 mm"}
    member = {"ends": ["O", "A"], "section": "strip", "material": "steel"}
    return Scene.read(
        {
            "materials": {"steel": {"modulus": "206 GPa", "density": "7850 kg/m^3"}},
            "sections": {"strip": strip},
            "ground": {"points": {"O": (0, 0)}},
            "links": {"arm": {"points": {"O": (0, 0), "A": (0.5, 0)}, "members": {"beam": member}}},
            "joints": {"O": {"connect": ["ground.O", "arm.O"]}},
            "drive": {"joint": "O", "speed": speed},
            "loads": {"tip": {"at": "arm.A", "force": (0.0, -1.0)}},
        }
        | rest
    )
