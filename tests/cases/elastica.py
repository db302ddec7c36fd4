"""Exact statics of beams that bend far, by shooting: references that use nothing of the program."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve


def beam(moment, force, length, ei, ea, start=(0.0, 0.0, 0.0)):
    """Give x, y, angle and moment at the end of a beam, from the moment at its start and the force beyond it.

    ``theta' = M/EI``, ``M' = -(F across)(1 + e)`` and ``e = (F along)/EA``, e being the stretch of the axis.
    """

    def slope(_, state):
        c, s = np.cos(state[2]), np.sin(state[2])
        stretch = 1 + (force[0] * c + force[1] * s) / ea
        return [stretch * c, stretch * s, state[3] / ei, -(force[1] * c - force[0] * s) * stretch]

    return solve_ivp(slope, (0, length), [*start, float(moment)], rtol=1e-11, atol=1e-14).y[:, -1]


def cantilever_with_arm(force, arm, length, ei, ea):
    """Give the root moment and x, y, angle of the tip of a cantilever along x under a force at a rigid arm."""

    def moment_at(angle):
        c, s = np.cos(angle), np.sin(angle)
        return (c * arm[0] - s * arm[1]) * force[1] - (s * arm[0] + c * arm[1]) * force[0]

    def left(root):
        _, _, angle, moment = beam(root[0], force, length, ei, ea)
        return [moment - moment_at(angle)]

    (root,) = fsolve(left, [length * force[1] + moment_at(0.0)], xtol=1e-13)
    return root, beam(root, force, length, ei, ea)[:3]


def crank_in_guide(crank, start, pivot, load, reach):
    """Give the force of a pin in a rigid guide that turns about a pivot, and the pin's displacement.

    `crank` is length, EI and EA of a cantilever from the origin at the angle `start`, whose tip carries the pin. A
    vertical `load` acts on the guide at `reach` beyond the pivot, on the side that the pin is not on.
    """
    length, ei, ea = crank
    tip = length * np.array([np.cos(start), np.sin(start)])
    apart = tip - pivot

    def left(unknown):
        moment, normal, angle, distance = unknown
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        x, y, _, end = beam(moment, normal * across, length, ei, ea, (0.0, 0.0, start))
        gap = np.array([x, y]) - pivot
        return [end, 1e3 * gap @ across, 1e3 * (gap @ along - distance), -reach * along[0] * load - distance * normal]

    distance, angle = np.hypot(*apart), np.arctan2(apart[1], apart[0])
    normal = -reach * np.cos(angle) * load / distance
    moment = normal * (tip @ apart) / distance  # of the force at the tip, across the guide, about the origin
    moment, normal, angle, _ = fsolve(left, [moment, normal, angle, distance], xtol=1e-13)
    across = np.array([-np.sin(angle), np.cos(angle)])
    return abs(normal), beam(moment, normal * across, length, ei, ea, (0.0, 0.0, start))[:2] - tip
