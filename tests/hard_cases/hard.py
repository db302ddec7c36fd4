"""Machines that several hard cases share, and their answers by modes."""

import numpy as np
from scipy.linalg import eigh

from fenics_mech.response.setup import mechanism
from fenics_mech.scene import Scene


def arm(speed, **rest):
    """A steel arm of 0.5 m on a turning shaft; a force at its tip turns against it, so that harmonic 1 bends it."""
    member = {"ends": ["O", "A"], "section": "strip", "material": "steel"}
    return Scene.read(
        {
            "materials": {"steel": {"modulus": "206 GPa", "density": "7850 kg/m^3"}},
            "sections": {"strip": {"shape": "rectangle", "width": "20 mm", "height": "2 mm"}},
            "ground": {"points": {"O": (0, 0)}},
            "links": {"arm": {"points": {"O": (0, 0), "A": (0.5, 0)}, "members": {"beam": member}}},
            "joints": {"O": {"connect": ["ground.O", "arm.O"]}},
            "drive": {"joint": "O", "speed": speed},
            "loads": {"tip": {"at": "arm.A", "force": (0.0, -1.0)}},
        }
        | rest
    )


def natural(scene):
    """The mechanism of a scene, its natural frequencies at drive angle 0 (rad/s) and its modes."""
    system = mechanism(scene)
    mass, stiffness = system.held_matrices()
    squares, shapes = eigh(stiffness.dense(0), mass.dense(0))
    return system, np.sqrt(squares), shapes


def by_modes(scene, decay):
    """Coordinates of a mechanism with constant coefficients, by its modes and the Fourier series of its load.

    Parameters
    ----------
    scene
        Its force has no harmonic above 1.
    decay
        Damping of each mode over its mass (1/s), as a function of its frequency.
    """
    system, omega, shapes = natural(scene)
    load = np.fft.rfft(system.load, axis=0) / len(system.load)
    speed, theta = scene.cycle_rate, system.motion.theta
    q = np.zeros_like(system.load)
    for harmonic in (0, 1):
        force = (1 + harmonic) * shapes.T @ load[harmonic]
        dynamic = omega**2 - (harmonic * speed) ** 2 + 1j * decay(omega) * harmonic * speed
        q += np.real((shapes @ (force / dynamic)) * np.exp(1j * harmonic * theta)[:, None])
    return system.to_links(q)
