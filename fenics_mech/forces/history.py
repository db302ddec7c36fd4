"""What every solver of the response gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import times
from fenics_mech.effects import NOTHING, Terms
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.response.transient.integration import Course

Array = NDArray[np.float64]


@dataclass(frozen=True)
class History:
    """Elastic displacement of the mechanism over the drive angles, and the inertia that goes with it.

    Parameters
    ----------
    displacement
        Coordinates q (m, rad), ``(angles, coordinates)``.
    inertia
        Rigid and elastic acceleration of every nodal dof in link axes, less gravity's, and the drag per mass on its
        velocity (m/s^2, rad/s^2), ``(angles, nodal dofs)``.
    turning
        What the gyroscopic matrix s is multiplied by, ``2 omega v' + alpha v`` and the drag per mass on ``omega v``;
        None where the coupling is off.
    centripetal
        The share -omega^2 v of `inertia`, which the rotation of sections and point masses does not feel; None where
        the coupling is off.
    velocity
        Velocity v' of every nodal dof in link axes (m/s, rad/s), where a solver gives it.
    viscous
        Displacement of every nodal dof in link axes (m, rad) whose elastic forces are those of modal damping,
        ``P^T k viscous = D q'``: a viscous stress in the links. Springs carry no share, nor do axial forces: those act
        on the axis as it is bent, and would turn a link by forces from nowhere. None where there is no such damping.
    drag
        Acceleration whose inertia would balance these forces, ``P^T m drag = D q'`` (m/s^2, rad/s^2).
    stability
        Whether small disturbances of the motion die out, where a solver tells.
    twist
        Angle of the crank ahead of its drive and two time derivatives, ``(3, angles)``, where the drive has a motor:
        all the rest then belongs to the crank's own motion.
    better
        By source of error ("time", "mesh", "modes"), the same motion without it, to first order.
    course
        How a motion in time came about.
    closed
        How a periodic motion came about.
    """

    displacement: Array
    inertia: Array
    turning: Array | None = None
    velocity: Array | None = None
    centripetal: Array | None = None
    viscous: Array | None = None
    drag: Array | None = None
    stability: Stability | None = None
    twist: Array | None = None
    better: Mapping[str, Better] = field(default_factory=dict)
    course: Course | None = None
    closed: Closed | None = None

    @property
    def elastic(self) -> History:
        """The motion without the forces of modal damping, and with the inertia that balances what is left."""
        if self.drag is None:
            return self
        return replace(self, inertia=self.inertia + self.drag, viscous=None, drag=None)

    def strained(self, system: System) -> Array:
        """Displacement in link axes whose elastic forces are all stress of the links, ``(angles, nodal dofs)``.

        Beside the displacement itself it holds what damping by the material and by modal ratios adds.
        """
        v = system.to_links(self.displacement)
        if self.viscous is not None:
            v = v + self.viscous
        if self.velocity is not None and system.terms.material:
            v = v + system.terms.material * self.velocity
        return v

    @property
    def damping(self) -> History | None:
        """The forces of modal damping alone, and the inertia that balances them; None where there are none."""
        if self.drag is None:
            return None
        return History(displacement=np.zeros_like(self.displacement), inertia=-self.drag, viscous=self.viscous)


@dataclass(frozen=True)
class Better:
    """A motion without one source of error.

    Parameters
    ----------
    history
        The motion; the difference is the error.
    order
        With which power the error falls: of the number of steps, or of elements.
    safety
        By which differences are raised, as they are less than the true error.
    loads
        Loads that act beside.
    unheld
        Whether next to a resonance that hardly anything damps the error may be more.
    hidden
        A motion with some of the vibration that the source may hide, and how much of it; see `dispersion`.
    """

    history: History
    order: float
    safety: float = 1.0
    loads: Terms = NOTHING
    unheld: bool = False
    hidden: tuple[History, float] | None = None


@dataclass(frozen=True)
class Struck:
    """State of a mechanism at the impulses of its cycle.

    Parameters
    ----------
    system
        The mechanism at the angle of each impulse.
    history
        Its motion there, with the mean of the velocities before and after.
    jump
        Change of q' by each impulse, ``(impulses, coordinates)``.
    """

    system: System
    history: History
    jump: Array


@dataclass(frozen=True)
class Inside:
    """A periodic motion at the collocation points of all its steps.

    Parameters
    ----------
    system, history
        The mechanism and its motion there.
    shares
        Weights of the points in a mean over the cycle, ``(points,)``.
    struck
        What impulses find, where there are some.
    """

    system: System
    history: History
    shares: Array
    struck: Struck | None = None


@dataclass(frozen=True)
class Closed:
    """How a periodic motion came about.

    Parameters
    ----------
    condition
        How many times a relative error of the cycle's equations comes out in the motion.
    inside
        The motion inside the steps, where these are by collocation.
    """

    condition: float
    inside: Inside | None = None


def history_of(equation: Equation, q: Array, rate: Array, load: Array | None = None) -> History:
    """Give the history of a motion from its coordinates and their velocities, ``(angles, coordinates)`` each.

    A load beside that of the equation is ``(angles, coordinates)``.
    """
    system, (p, first, second) = equation.system, equation.shape
    v, v_rate = map(system.on_nodes, equation.in_links(q, rate))
    acceleration = equation.acceleration(q, rate)
    if load is not None:
        acceleration += np.linalg.solve(equation.linear.mass, load[..., None])[..., 0]
    of_links = times(p, acceleration)
    if first is not None and second is not None:
        of_links += 2 * times(first, rate) + times(second, q)
    drag_rate = system.terms.drag
    inertia = system.on_nodes(of_links) + system.rigid_acceleration + drag_rate * v_rate
    turning = centripetal = viscous = drag = None
    if equation.extra_damping is not None:
        forces = equation.extra_damping @ equation.straining(q, rate)[..., None]
        matrices = equation.links_stiffness, equation.linear.mass
        viscous, drag = (system.on_nodes(times(p, np.linalg.solve(matrix, forces)[..., 0])) for matrix in matrices)
    if first is not None and second is not None:
        omega, alpha = (by_link[:, system.link_of_dof] for by_link in (system.motion.omega, system.tangential))
        centripetal = -(omega**2) * v
        inertia += centripetal
        turning = 2 * omega * v_rate + alpha * v
    return History(
        displacement=q,
        inertia=inertia,
        turning=turning,
        velocity=v_rate,
        viscous=viscous,
        drag=drag,
        centripetal=centripetal,
    )
