"""The elastic response of a mechanism: displacement, velocity, and the acceleration that its inertia feels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.modal_forces import NonlinearModalForces


@dataclass(frozen=True)
class RotationOfFrames:
    """What the rotation of the links' frames does to the elastic motion v in them.

    Parameters
    ----------
    turning
        What the gyroscopic matrix is multiplied by, ``2 omega v' + alpha v`` and the drag per mass on ``omega v``
        (m/s^2), ``(angles, nodal dofs)``.
    centripetal
        ``-omega^2 v`` (m/s^2), which the rotation of sections and point masses does not feel, ``(angles, nodal dofs)``.
    """

    turning: Array
    centripetal: Array


@dataclass(frozen=True)
class ModalDamping:
    """The forces ``D q'`` of modal damping, as a stress of the links and as their inertia.

    Springs carry no share of them. Axial forces act on the bent axis with a nonlinear strain only: in linear theory
    they would turn a link by forces from nowhere.

    Parameters
    ----------
    displacement
        Displacement in link axes (m, rad) whose elastic forces they are, ``P^T k v = D q'``, ``(angles, nodal dofs)``.
    acceleration
        Acceleration (m/s^2, rad/s^2) whose inertia would balance them, ``P^T m a = D q'``, ``(angles, nodal dofs)``.
    on_bent_axis
        Forces on the elements' ends by the axial forces on the bent axis, ``(angles, elements, 6)`` (N, N m).
    """

    displacement: Array
    acceleration: Array
    on_bent_axis: Array | None = None


@dataclass(frozen=True)
class ElasticResponse:
    """Elastic displacement of the mechanism over the drive angles, and the inertia that goes with it.

    Parameters
    ----------
    displacement
        Coordinates q (m, rad), ``(angles, coordinates)``.
    inertia
        Rigid and elastic acceleration of every nodal dof in link axes, less gravity's, and the drag per mass on its
        velocity (m/s^2, rad/s^2), ``(angles, nodal dofs)``.
    velocity
        Velocity v' of every nodal dof in link axes (m/s, rad/s), where a solver gives it, ``(angles, nodal dofs)``.
    rotation
        What the rotation of the links' frames adds; None where the coupling is off.
    modal_damping
        The forces of modal damping; None where there are none.
    """

    displacement: Array
    inertia: Array
    velocity: Array | None = None
    rotation: RotationOfFrames | None = None
    modal_damping: ModalDamping | None = None

    @property
    def undamped(self) -> ElasticResponse:
        """The response without the forces of modal damping, and with the inertia that balances what is left."""
        if self.modal_damping is None:
            return self
        return replace(self, inertia=self.inertia + self.modal_damping.acceleration, modal_damping=None)

    @property
    def by_modal_damping(self) -> ElasticResponse | None:
        """The forces of modal damping alone, and the inertia that balances them; None where there are none."""
        if (damping := self.modal_damping) is None:
            return None
        return ElasticResponse(np.zeros_like(self.displacement), -damping.acceleration, modal_damping=damping)

    def strained(self, system: System) -> Array:
        """Displacement in link axes whose elastic forces are all stress of the links, ``(angles, nodal dofs)``.

        Beside the displacement itself it holds what damping by the material and by modal ratios adds.

        Parameters
        ----------
        system
            The mechanism.
        """
        v = system.to_links(self.displacement)
        if self.modal_damping is not None:
            v = v + self.modal_damping.displacement
        if self.velocity is not None and system.terms.damping.material:
            v = v + system.terms.damping.material * self.velocity
        return v

    def changed(self, displacement: Array, inertia: Array) -> ElasticResponse:
        """Give the undamped response with a change of q and of the nodal inertia.

        Parameters
        ----------
        displacement
            Change of q, ``(angles, coordinates)``.
        inertia
            Change of the nodal acceleration in link axes, ``(angles, nodal dofs)``.
        """
        undamped = self.undamped
        return replace(undamped, displacement=undamped.displacement + displacement, inertia=undamped.inertia + inertia)


def elastic_response(equation: Equation, q: Array, rate: Array, load: Array | None = None) -> ElasticResponse:
    """Give the response from its coordinates and their rates: the equation of motion gives the acceleration.

    Parameters
    ----------
    equation
        The equation of motion at the drive angles.
    q, rate
        Coordinates (m, rad) and their rates (m/s, rad/s), ``(angles, coordinates)``.
    load
        A load beside that of the equation (N, N m), ``(angles, coordinates)``.
    """
    acceleration = equation.acceleration(q, rate)
    if load is not None:
        acceleration += equation.mass_at(q).solve(load)
    return response_at(equation, q, rate, acceleration)


def response_at(equation: Equation, q: Array, rate: Array, acceleration: Array) -> ElasticResponse:
    """Give the response from its coordinates and two time derivatives, whether they fulfil the equation or not.

    Parameters
    ----------
    equation
        The equation of motion at the positions.
    q, rate, acceleration
        Coordinates (m, rad) and derivatives (per s, per s^2), ``(positions, coordinates)`` each.
    """
    system, (p, first, second), forward = equation.system, equation.jets, equation.system.transformation.forward
    v, v_rate = map(system.on_nodes, equation.in_links(q, rate))
    of_links = forward(p, acceleration)
    if first is not None and second is not None:
        of_links += 2 * forward(first, rate) + forward(second, q)
    inertia = system.on_nodes(of_links) + system.rigid_acceleration + system.terms.damping.drag * v_rate
    rotation, damping = None, _modal_damping(equation, q, rate, v)
    if first is not None and second is not None:
        omega, alpha = (by_link[:, system.link_of_dof] for by_link in (system.motion.omega, system.tangential))
        rotation = RotationOfFrames(turning=2 * omega * v_rate + alpha * v, centripetal=-(omega**2) * v)
        inertia += rotation.centripetal
    return ElasticResponse(q, inertia, v_rate, rotation, damping)


def _modal_damping(equation: Equation, q: Array, rate: Array, v: Array) -> ModalDamping | None:
    """Give the forces of modal damping at a state with the nodal displacement v; None where there are none."""
    if (modal := equation.modal) is None:
        return None
    system, linear, rates, on_bent_axis = equation.system, equation.linear.modal, modal.rates(q, rate), None
    assert linear is not None
    forces = linear.forces(rates)
    strain = equation.links_stiffness.solve(forces)
    if isinstance(modal, NonlinearModalForces):
        on_bent_axis = modal.tension(rates)[..., None] * modal.law.on_elements.gradient(v)
        forces = forces + modal.on_bent_axis(rates, q)
    acceleration = equation.linear.mass.solve(forces)
    return ModalDamping(system.to_links(strain), system.to_links(acceleration), on_bent_axis)


def rate_of_cycle(values: Array, period: float) -> Array:
    """Give the time derivative of values at equal steps over a cycle, by their Fourier series.

    Parameters
    ----------
    values
        The values, ``(angles, ...)``.
    period
        Duration of the cycle (s).
    """
    count = len(values)
    order = np.fft.rfftfreq(count, 1 / count)
    order[2 * order == count] = 0.0
    spectrum = 2j * np.pi / period * order[:, None] * np.fft.rfft(values, axis=0)
    return np.asarray(np.fft.irfft(spectrum, count, axis=0))
