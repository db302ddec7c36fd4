"""Beams that turn about their clamped end, and their frequencies by Ritz' method."""

import numpy as np
from numpy.polynomial import Polynomial
from scipy.linalg import eigh

from fenics_mech.scene import Scene

MODULUS, DENSITY = 207e9, 7850.0


def ritz(speed, length, width, height, mass=0.0, arm=0.0, hub=0.0, terms=9, spin=1.0, modulus=MODULUS, density=DENSITY):
    """In-plane frequencies (rad/s) of a turning beam with a point mass on a rigid arm at its tip, inextensible.

    About the straight state, with the pull ``N = speed^2 [rho A ((h + L)^2 - (h + x)^2)/2 + m (h + L + arm)]``:
    ``K = int EI w''^2 + int N w'^2 + m speed^2 (h + L + arm) arm w'(L)^2 - speed^2 M``, h being the hub's radius.
    Functions are ``(x/L)^2, (x/L)^3, ...``. `spin` = 0 leaves out the last term: K and M alone.
    """
    line, bending = density * width * height, modulus * width * height**3 / 12
    shapes = [Polynomial([0] * (i + 2) + [1.0]) for i in range(terms)]  # of xi = x/L
    xi, weight = np.polynomial.legendre.leggauss(2 * terms + 2)
    xi, weight = (xi + 1) / 2, weight / 2 * length
    w, slope, curve = (np.array([s.deriv(n)(xi) / length**n if n else s(xi) for s in shapes]) for n in range(3))
    end_slope = np.array([s.deriv()(1.0) / length for s in shapes])
    tip = np.array([s(1.0) for s in shapes]) + arm * end_slope
    reach = hub + length + arm
    pull = speed**2 * (line * ((hub + length) ** 2 - (hub + length * xi) ** 2) / 2 + mass * reach)
    inertia = line * (w * weight) @ w.T + mass * np.outer(tip, tip)
    stiffness = bending * (curve * weight) @ curve.T + (slope * weight * pull) @ slope.T
    stiffness += mass * speed**2 * reach * arm * np.outer(end_slope, end_slope)
    squares = eigh(stiffness - spin * speed**2 * inertia, inertia, eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0))  # 0 where it diverges


def turning_beam(speed, length=0.3, width=0.02, height=0.003, mass=0.0, arm=0.0, hub=0.0, rigid=False, light=1e-3):
    """A beam whose end turns, with a mass on an arm at its tip: a rigid body, or a stiff member of the same link."""
    member = {"ends": ["O", "A"], "section": "strip", "material": "steel"}
    points, members = {"O": [0, 0], "A": [length, 0]}, {"OA": member | {"mesh": {"elements": 12}}}
    links, joints = {"beam": {"points": points, "members": members}}, {"O": {"connect": ["ground.O", "beam.O"]}}
    if hub:
        links["hub"] = {"points": {"O": [0, 0], "H": [hub, 0]}, "rigid": {"mass": 1.0, "inertia": 1e-2}}
        joints = {
            "O": {"connect": ["ground.O", "hub.O"]},
            "H": {"kind": "weld", "connect": ["hub.H", "beam.O"]},
        }
    masses = {"tip": {"at": "beam.A", "mass": mass}} if mass else {}
    if rigid:
        body = {"mass": mass, "inertia": 1e-8, "centre": [arm, 0]}
        links["body"] = {"points": {"A": [0, 0]}, "rigid": body}
        joints["A"] = {"kind": "weld", "connect": ["beam.A", "body.A"]}
        masses = {}
    elif arm:
        points["B"] = [length + arm, 0]
        members["AB"] = {"ends": ["A", "B"], "section": "bar", "material": "stiff", "mesh": {"elements": 2}}
        masses["tip"]["at"] = "beam.B"
    steel, stiff = {"modulus": MODULUS, "density": DENSITY}, {"modulus": 1e3 * MODULUS, "density": light}
    strip = {"shape": "rectangle", "width": width, "height": height}
    return Scene.read(
        {
            "materials": {"steel": steel} | ({"stiff": stiff} if arm and not rigid else {}),
            "sections": {"strip": strip} | ({"bar": strip | {"height": 0.03}} if arm and not rigid else {}),
            "ground": {"points": {"O": [0, 0]}},
            "links": links,
            "masses": masses,
            "joints": joints,
            "drive": {"joint": "O", "speed": speed},
            "analysis": {"sub_intervals": 12, "modes": 3},
        }
    )
