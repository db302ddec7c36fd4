"""Periodic response of a mechanism whose drive has a motor: the crank's own motion and the links' vibration together.

Newton's method: the equation is linearised about a motion of the crank, and solved for its twist; then about that.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.accuracy.motion_errors import collocation_better
from fenics_mech.errors import AssemblyError, UnresolvedError
from fenics_mech.forces.history import Closed, Inside, history_of
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.motor_equation import MotorEquation, at_rate, load_with_torque
from fenics_mech.modes import Modes
from fenics_mech.response import History
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.periodic.collocation import between, solve_collocation
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.periodic.steady_state import axes_at, condition_of, shares_of
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.periodic.tableau import Tableau, better_than
from fenics_mech.response.setup import moved, rough_tension
from fenics_mech.response.stability.floquet import floquet
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
MOST_ITERATIONS = 20
TOLERANCE = 1e-9  # of the change of the twist, relative
STEP = 1e-4  # of the crank's angle (rad) and relative of its rate, in differences of loads: errors of about 1e-8


def by_motor(scene: Scene, system: System, modes: Modes) -> tuple[System, History]:
    """Solve at collocation points; give the mechanism with its crank's own motion, and the history.

    Both are at the starts of the sub-intervals.

    Raises
    ------
    SolverError
        When Newton's method does not converge (`UnresolvedError`), or the motion is unstable.
    """
    tableau, steps = Tableau.of(scene.analysis.scheme, scene.analysis.stages), Steps.of(scene)
    theta = steps.angles(tableau.points, scene.cycle_rate)
    damping = modal_damping(scene, _turned(scene, system, theta, np.zeros((3, len(theta)))))
    twist, change = np.zeros((3, len(theta))), np.inf
    for _ in range(MOST_ITERATIONS):
        try:
            equation = _equation(scene, system, theta, twist, damping)
        except AssemblyError as error:  # so far ahead of the drive that the links' positions are not found
            raise _not_found(scene, theta, twist[0], "no position of the linkage is found there") from error
        tension = rough_tension(scene, equation.system)
        orbit = solve_collocation(equation, tableau, steps.duration, scene.petsc, tension)
        found = np.stack([orbit.displacement[:, -1], orbit.velocity[:, -1], orbit.acceleration[:, -1]])
        change = np.abs(found[0] - twist[0]).max() / max(np.abs(found[0]).max(), np.finfo(float).tiny)
        twist = found
        if change < TOLERANCE:
            break
    else:
        raise _not_found(scene, theta, twist[0], f"{MOST_ITERATIONS} iterations still change it by {change:.1e}")
    return _at_starts(scene, system, modes, orbit, (tableau, steps))


def _not_found(scene: Scene, theta: Array, twist: Array, why: str) -> UnresolvedError:
    """Say that the crank's own motion is not found, and where its shaft (twist in rad, ``(angles,)``) turns most."""
    (drive,), worst = scene.drives, int(np.abs(twist).argmax())
    assert drive.motor is not None
    angle = np.degrees(theta[worst]) % 360
    return UnresolvedError(
        f"the own motion of the crank on the motor's shaft (drive.motor, joint {drive.joint}) is not found: "
        f"Newton's method twists the shaft by {twist[worst]:.3g} rad at drive angle {angle:.6g} deg, and {why}. "
        f"Take a stiffer shaft than {drive.motor.stiffness:.3g} N m/rad, more damping or inertia of the "
        "motor, or smaller loads"
    )


def _at_starts(
    scene: Scene, system: System, modes: Modes, orbit: Orbit, cut: tuple[Tableau, Steps]
) -> tuple[System, History]:
    """Give mechanism and history at the starts of the sub-intervals, and judge the motion's accuracy and stability."""
    tableau, steps = cut
    analysis, damping = scene.analysis, modal_damping(scene, system)
    q, rate = orbit.start[steps.regular], orbit.start_velocity[steps.regular]
    start, twist = _accelerated(scene, system, system.motion.theta, q, rate, damping)
    crank = Equation(_turned(scene, system, system.motion.theta, twist), damping)
    flows: dict[tuple[str, int], Flow] = {}
    better = better_than(analysis.scheme, analysis.stages, steps.disturbed)
    for points in (better, ("gauss", analysis.stages)):
        other = Tableau.of(*points)
        if points not in flows:
            flows[points] = _flow(scene, system, other, steps, between(orbit, tableau, steps.duration, other.points))
    stability = None
    if analysis.stability:
        shapes = np.pad(modes.shapes, ((0, 0), (0, 0), (0, 1)))  # without twist
        of_all = replace(modes, shapes=shapes)
        axes = axes_at(scene, system, steps)
        stability = floquet(flows["gauss", analysis.stages], start.linear, axes, of_all, scene.petsc)
        if not analysis.allow_unstable:
            stability.refuse_unstable()
    history = replace(
        history_of(crank, q[:, :-1], rate[:, :-1]),
        better=collocation_better(scene, crank, orbit, flows[better], (modes, steps)),
        twist=twist,
        stability=stability,
        closed=Closed(condition_of(orbit), _inside(scene, system, orbit, cut)),
    )
    return crank.system, history


def _inside(scene: Scene, system: System, orbit: Orbit, cut: tuple[Tableau, Steps]) -> Inside:
    """Give the motion at the collocation points, with the crank's own motion there."""
    tableau, steps = cut
    theta = steps.angles(tableau.points, scene.cycle_rate)
    q, rate, acceleration = orbit.displacement, orbit.velocity, orbit.acceleration
    there = _turned(scene, system, theta, np.stack([q[:, -1], rate[:, -1], acceleration[:, -1]]))
    damping = modal_damping(scene, _turned(scene, system, theta, np.zeros((3, len(theta)))))
    equation = Equation(there, damping)
    return Inside(there, history_of(equation, q[:, :-1], rate[:, :-1]), shares_of(tableau, steps))


def _flow(scene: Scene, system: System, tableau: Tableau, steps: Steps, motion: tuple[Array, Array]) -> Flow:
    """Give the steps of the equation linearised about a motion at the tableau's points."""
    theta = steps.angles(tableau.points, scene.cycle_rate)
    damping = modal_damping(scene, _turned(scene, system, theta, np.zeros((3, len(theta)))))
    equation, _ = _accelerated(scene, system, theta, *motion, damping)
    law, matrices = equation.system.terms.law, equation.linear
    if law is not None:
        matrices = equation.linearised(*motion, law.tension(*equation.in_links(*motion)))
    return Flow(matrices, tableau, steps.duration, scene.petsc)


def _accelerated(
    scene: Scene, system: System, theta: Array, q: Array, rate: Array, damping: Array | None
) -> tuple[MotorEquation, Array]:
    """Give the equation about a motion, and the twist of it with the acceleration that the equation demands."""
    twist = np.stack([q[:, -1], rate[:, -1], np.zeros(len(q))])
    for _ in range(2):  # the acceleration stands in the coefficients too
        equation = _equation(scene, system, theta, twist, damping)
        twist = np.stack([*twist[:2], equation.acceleration(q, rate)[:, -1]])
    return equation, twist


def _equation(scene: Scene, system: System, theta: Array, twist: Array, damping: Array | None) -> MotorEquation:
    """Linearise about a twist, ``(3, angles)``; tangents of the load are central differences."""
    motor = scene.drives[0].motor
    assert motor is not None
    plain = scene.changed(effects=())  # effects that a scene names change no load
    at = {ahead: _nominal(scene, system, theta + (twist[0] + ahead)) for ahead in (-STEP, 0.0, STEP)}
    one, none = np.ones_like(theta), np.zeros_like(theta)
    units = {ahead: at_rate(motion, scene.cycle_rate, one, none) for ahead, motion in at.items()}  # 1 rad/s

    def load(by: Array) -> Array:
        return load_with_torque(_moved(plain, system, at[by[0]], theta, twist + by[:, None]), units[by[0]])

    rate = abs(scene.cycle_rate)
    steps = np.diag([STEP, STEP * rate, STEP * rate**2])
    tangents = [(load(step) - load(-step)) / (2 * step.sum()) for step in steps]
    return MotorEquation(
        system=_moved(scene, system, at[0.0], theta, twist),
        extra_damping=damping,
        motor=motor,
        unit=units[0.0],
        twist=twist,
        load=load(np.zeros(3)),
        tangents=np.stack(tangents),
    )


def _turned(scene: Scene, system: System, theta: Array, twist: Array) -> System:
    """Give the mechanism with its crank ahead of drive angles by a twist, ``(3, angles)`` with time derivatives."""
    return _moved(scene, system, _nominal(scene, system, theta + twist[0]), theta, twist)


def _nominal(scene: Scene, system: System, psi: Array) -> Motion:
    """Give the motion at given angles of the crank, when it turns at the drive's rate."""
    return solve_motion(scene, psi, near=system.motion)


def _moved(scene: Scene, system: System, nominal: Motion, theta: Array, twist: Array) -> System:
    """Give the mechanism with the motion `nominal` at the crank's own rate; it keeps drive angles and their times."""
    motion = at_rate(nominal, scene.cycle_rate, scene.cycle_rate + twist[1], twist[2])
    motion = replace(motion, theta=theta, time=theta / scene.cycle_rate)
    return moved(scene, system, motion)
