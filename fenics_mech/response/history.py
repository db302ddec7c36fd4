"""What every solver of the response gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import times
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.floquet import Stability
from fenics_mech.response.transient import Course

Array = NDArray[np.float64]


@dataclass(frozen=True)
class History:
    """Elastic displacement of the mechanism over the drive angles, and the inertia that goes with it.

    Parameters
    ----------
    displacement
        Coordinates q (m, rad), ``(angles, coordinates)``.
    inertia
        Acceleration of every nodal dof in link axes (m/s^2, rad/s^2), ``(angles, nodal dofs)``, such that
        ``K q + P^T m inertia = 0``: rigid and elastic acceleration, and the modal damping force over the mass.
    turning
        What the gyroscopic matrix s is multiplied by, ``2 omega v' + alpha v``; None where the coupling is off.
    centripetal
        The share -omega^2 v of `inertia`, which the rotation of sections and point masses does not feel; None where
        the coupling is off.
    velocity
        Velocity v' of every nodal dof in link axes (m/s, rad/s), where a solver gives it.
    stability
        Whether small disturbances of the motion die out, where a solver tells.
    twist
        Angle of the crank ahead of its drive and two time derivatives, ``(3, angles)``, where the drive has a motor:
        all the rest then belongs to the crank's own motion.
    error_estimate
        Error of the displacement, relative to its largest value, where a solver estimates it.
    better
        The same motion more accurately, where a solver gives it: the difference is the error of the steps in time.
    course
        How a motion in time came about.
    """

    displacement: Array
    inertia: Array
    turning: Array | None = None
    velocity: Array | None = None
    centripetal: Array | None = None
    stability: Stability | None = None
    twist: Array | None = None
    error_estimate: float | None = None
    better: History | None = None
    course: Course | None = None


def history_of(equation: Equation, q: Array, rate: Array) -> History:
    """Give the history of a motion from its coordinates and their velocities, ``(angles, coordinates)`` each."""
    system, (p, first, second) = equation.system, equation.shape
    v, v_rate = equation.in_links(q, rate)
    seconds = equation.acceleration(q, rate)
    damped = seconds
    if equation.extra_damping is not None:
        damping = times(equation.extra_damping, rate)
        damped = seconds + np.linalg.solve(equation.linear.mass, damping[..., None])[..., 0]
    inertia = times(p, damped) + system.rigid_acceleration + system.terms.external * v_rate
    turning = centripetal = None
    if first is not None and second is not None:
        omega, alpha = (by_link[:, system.link_of_dof] for by_link in (system.motion.omega, system.motion.alpha))
        centripetal = -(omega**2) * v
        inertia += 2 * times(first, rate) + times(second, q) + centripetal
        turning = 2 * omega * v_rate + alpha * v
    return History(displacement=q, inertia=inertia, turning=turning, velocity=v_rate, centripetal=centripetal)
