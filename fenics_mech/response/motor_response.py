"""Periodic response of a mechanism whose drive has a motor: the crank's own motion and the links' vibration together.

Newton's method: the equation is linearised about a motion of the crank, and solved for its twist; then about that.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.eigenmodes import Modes
from fenics_mech.errors import AssemblyError, UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.mechanism.motor_equation import MotorEquation, at_rate, load_with_torque
from fenics_mech.response.periodic.collocation import solve_collocation
from fenics_mech.response.periodic.cycle import Cycle, States
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.periodic.steady_state import condition_of
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import moved, rough_tension
from fenics_mech.response.solution import AtPoints, MotorSolution
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.scene import Drive, Scene


@dataclass(frozen=True)
class MotorLimits:
    """How the crank's own motion is found."""

    most_iterations: int = 20  # of Newton's method, each about the twist found before
    settled: float = 1e-9  # change of the twist, relative
    step: float = 1e-4  # crank's angle (rad), and relative its rate, in differences of loads: errors of about 1e-8


MOTOR = MotorLimits()


def by_motor(scene: Scene, system: System, modes: Modes) -> MotorSolution:
    """Solve at collocation points; the mechanism has its crank's own motion, at the starts of the sub-intervals.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the starts of the sub-intervals, as the drive would turn it.
    modes
        Its modes, by which an instability is named.

    Raises
    ------
    SolverError
        When Newton's method does not converge (`UnresolvedError`), or the motion is unstable.
    """
    cycle = MotorCycle(scene, system)
    steps = cycle.steps
    theta = steps.angles(cycle.tableau.points)
    twist, change = np.zeros((3, len(theta))), np.inf
    for _ in range(MOTOR.most_iterations):
        try:
            equation = cycle.about_twist(theta, twist)
        except AssemblyError as error:  # so far ahead of the drive that the links' positions are not found
            raise _not_found(scene.drives[0], theta, twist[0], "no position of the linkage is found there") from error
        tension = rough_tension(scene, equation.system)
        orbit = solve_collocation(equation, cycle.tableau, steps.duration, scene.petsc, tension)
        found = np.stack([orbit.displacement[:, -1], orbit.velocity[:, -1], orbit.acceleration[:, -1]])
        change = np.abs(found[0] - twist[0]).max() / max(np.abs(found[0]).max(), TINY)
        twist = found
        if change < MOTOR.settled:
            break
    else:
        raise _not_found(
            scene.drives[0], theta, twist[0], f"{MOTOR.most_iterations} iterations still change it by {change:.1e}"
        )
    return _at_starts(cycle, modes, orbit, theta)


@dataclass(frozen=True, eq=False)
class MotorCycle(Cycle):
    """The equation of motion of a mechanism on a motor's shaft: it is linearised about the crank's own motion."""

    _starts: list[tuple[MotorEquation, Array]] = field(default_factory=list)

    @property
    def linear(self) -> bool:
        """The twist of the shaft changes the equation."""
        return False

    @cached_property
    def massless(self) -> str | None:
        """The multipliers are those of the linearised equation, whatever a coordinate's mass."""
        return None

    def multipliers(self, modes: Modes, motion: States | None) -> Stability:
        """Find the Floquet multipliers of a motion; the twist of the shaft has no part in the modes.

        Parameters
        ----------
        modes, motion
            As of `Cycle.multipliers`.
        """
        shapes = np.pad(modes.shapes, ((0, 0), (0, 0), (0, 1)))
        return super().multipliers(replace(modes, shapes=shapes), motion)

    def about_twist(self, theta: Array, twist: Array) -> MotorEquation:
        """Linearise about a twist of the shaft; tangents of the load are central differences.

        Parameters
        ----------
        theta
            Drive angles (rad).
        twist
            Angle of the crank ahead of them (rad) and two time derivatives, ``(3, angles)``.
        """
        scene, system, motor = self.scene, self.system, self.scene.drives[0].motor
        assert motor is not None
        plain = scene.changed(effects=())  # effects that a scene names change no load
        at = {
            ahead: solve_motion(scene, theta + (twist[0] + ahead), near=system.motion)
            for ahead in (-MOTOR.step, 0.0, MOTOR.step)
        }
        one, none = np.ones_like(theta), np.zeros_like(theta)
        units = {ahead: at_rate(motion, scene.cycle_rate, one, none) for ahead, motion in at.items()}  # 1 rad/s

        def load(by: Array) -> Array:
            return load_with_torque(_turned(plain, system, at[by[0]], theta, twist + by[:, None]), units[by[0]])

        rate = abs(scene.cycle_rate)
        steps = np.diag([MOTOR.step, MOTOR.step * rate, MOTOR.step * rate**2])
        tangents = [(load(step) - load(-step)) / (2 * step.sum()) for step in steps]
        here = self.damped_equation(_turned(scene, system, at[0.0], theta, twist))
        return MotorEquation(
            system=here.system,
            modal_damping=here.modal_damping,
            motor=motor,
            unit=units[0.0],
            twist=twist,
            load=load(np.zeros(3)),
            tangents=np.stack(tangents),
        )

    def links_at(self, theta: Array, q: Array, rate: Array, twist: Array) -> tuple[Equation, ElasticResponse]:
        """Give the equation of the links at the crank's own angle, and their response.

        Parameters
        ----------
        theta
            Drive angles (rad).
        q, rate
            Coordinates with the twist as their last, and their rates, ``(angles, coordinates + 1)``.
        twist
            The twist (rad) and two time derivatives, ``(3, angles)``.
        """
        motion = solve_motion(self.scene, theta + twist[0], near=self.system.motion)
        links = self.damped_equation(_turned(self.scene, self.system, motion, theta, twist))
        return links, elastic_response(links, q[:, :-1], rate[:, :-1])

    def accelerated(self, theta: Array, q: Array, rate: Array) -> Array:
        """Give the twist of a state with the acceleration that the equation demands, ``(3, angles)``.

        The acceleration stands in the coefficients too, which are linear in it but for what axial forces do to bending.
        So the one that demands itself follows from two that are demanded (a secant step). Plain iteration would not
        converge where little inertia turns with the shaft itself, as with a fine mesh of the crank and a light rotor.

        Parameters
        ----------
        theta, q, rate
            As of `links_at`.
        """

        def demanded(acceleration: Array) -> Array:
            equation = self.about_twist(theta, np.stack([q[:, -1], rate[:, -1], acceleration]))
            return equation.acceleration(q, rate)[:, -1]

        first = demanded(np.zeros(len(q)))
        slope = np.divide(demanded(first) - first, first, out=np.zeros_like(first), where=first != 0)
        return np.stack([q[:, -1], rate[:, -1], first / (1 - slope)])

    def start_about(self, motion: States) -> tuple[MotorEquation, Array]:
        """Give the equation about a motion at the starts of the sub-intervals, and the twist of that motion.

        Its acceleration is that at the end of the step before, which is a collocation point of Radau.
        """
        if not self._starts:
            whole = self._twist(motion, np.array([0.0, 1.0]))
            twist, at_ends = whole[:, ::2], whole[2, 1::2]
            if not self.steps.disturbed:
                twist[2] = np.roll(at_ends, 1)
            twist = twist[:, self.steps.regular]
            self._starts.append((self.about_twist(self.system.motion.theta, twist), twist))
        return self._starts[0]

    def _twist(self, motion: States, places: Array) -> Array:
        """Give the twist of a motion and two time derivatives at places 0..1 of all steps, ``(3, steps x places)``.

        The acceleration is the derivative of the rate's collocation polynomial. To solve the equation for it would
        divide by the inertia of the shaft alone, which may be next to nothing.
        """
        powers = np.arange(len(self.tableau.points) + 1)
        nodes = np.linspace(0, 1, len(powers))
        derivative = powers * places[:, None] ** np.maximum(powers - 1, 0) @ np.linalg.inv(nodes[:, None] ** powers)
        rates = motion(nodes)[1][:, -1].reshape(-1, len(nodes))
        acceleration = rates @ derivative.T / self.steps.duration[:, None]
        q, rate = motion(places)
        return np.stack([q[:, -1], rate[:, -1], acceleration.ravel()])

    def _at_start(self, motion: States | None) -> Matrices:
        assert motion is not None
        return self.start_about(motion)[0].linear

    def _about(self, motion: States | None, tableau: Tableau) -> Matrices:
        assert motion is not None
        theta = self.steps.angles(tableau.points)
        equation = self.about_twist(theta, self._twist(motion, tableau.points))
        return equation.about(*motion(tableau.points))


def _not_found(drive: Drive, theta: Array, twist: Array, why: str) -> UnresolvedError:
    """Say that the crank's own motion is not found, and where its shaft (twist in rad, ``(angles,)``) turns most."""
    worst = int(np.abs(twist).argmax())
    assert drive.motor is not None
    angle = np.degrees(theta[worst]) % 360
    return UnresolvedError(
        f"the own motion of the crank on the motor's shaft (drive.motor, joint {drive.joint}) is not found: "
        f"Newton's method twists the shaft by {twist[worst]:.3g} rad at drive angle {angle:.6g} deg, and {why}. "
        f"Take a stiffer shaft than {drive.motor.stiffness:.3g} N m/rad, more damping or inertia of the "
        "motor, or smaller loads"
    )


def _at_starts(cycle: MotorCycle, modes: Modes, orbit: Orbit, theta: Array) -> MotorSolution:
    """Give the solution at the starts of the sub-intervals, and judge its stability.

    `theta` are the drive angles of the collocation points.
    """
    scene, system, motion = cycle.scene, cycle.system, cycle.motion(orbit)
    q, rate = orbit.start[cycle.steps.regular], orbit.start_velocity[cycle.steps.regular]
    _, twist = cycle.start_about(motion)
    crank, response = cycle.links_at(system.motion.theta, q, rate, twist)
    stability = cycle.stability(modes, motion)
    return MotorSolution(
        scene=scene,
        system=crank.system,
        response=response,
        modes=modes,
        condition=condition_of(orbit),
        stability=stability,
        cycle=cycle,
        equation=crank,
        orbit=orbit,
        inside=lambda: _at_points(cycle, orbit, theta),
        twist=twist,
    )


def _at_points(cycle: MotorCycle, orbit: Orbit, theta: Array) -> AtPoints:
    """Give the motion at the collocation points, with the crank's own motion there."""
    q, rate = orbit.displacement, orbit.velocity
    twist = np.stack([q[:, -1], rate[:, -1], orbit.acceleration[:, -1]])
    equation, response = cycle.links_at(theta, q, rate, twist)
    return AtPoints(equation.system, response, cycle.weights)


def _turned(scene: Scene, system: System, motion: Motion, theta: Array, twist: Array) -> System:
    """Give the mechanism with its crank ahead of drive angles by a twist, ``(3, angles)`` with time derivatives.

    `motion` is that of a crank at these angles at the drive's rate. Drive angles and their times stay.
    """
    motion = at_rate(motion, scene.cycle_rate, scene.cycle_rate + twist[1], twist[2])
    motion = replace(motion, theta=theta, time=theta / scene.cycle_rate)
    return moved(scene, system, motion)
