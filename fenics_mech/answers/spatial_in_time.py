"""Motions of scenes in space in time, from the drawn position."""

from __future__ import annotations

from copy import copy

import numpy as np
import scipy.linalg

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.geometry import Given, PoseMotion
from fenics_mech.machine.mobility import conditions
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.spatial import SpatialMachine
from fenics_mech.solve import Step, accelerated, steps_in_time
from fenics_mech.solve.step import now

BEYOND = 1e-3  # of the way between two instants, by which the motion goes on for the forces at the last one
UNLED = 1e-9  # of the largest rate that is asked for: what no rate of links gives is a contradiction


def in_time(made: SpatialMachine, stricter: float = 1.0) -> Motion:
    """Follow the motion of a machine, and give it at even instants.

    Parameters
    ----------
    made
        The machine.
    stricter
        What its tolerance is multiplied by.

    Raises
    ------
    SceneError
        When drives and start speeds contradict each other.
    SolverError
        When a step has no solution.
    """
    machine, analysis = made.machine, made.scene.analysis
    assert analysis.duration is not None
    machine.chart = None
    tolerance = stricter * analysis.time_tolerance * machine.units[: machine.n]
    even = analysis.duration * np.arange(analysis.positions + 1) / analysis.positions
    times = np.append(even, even[-1] + BEYOND * even[1])
    states: list[tuple[PoseMotion, Array, list[Array]]] = []
    for step in steps_in_time(
        machine,
        _start(made),
        times,
        tolerance=tolerance,
        longest=analysis.duration / analysis.positions,
        angles=machine.angles_as_drawn(),
    ):
        if np.abs(even - step.t).min() < BEYOND / 10 * even[1]:
            states.append(_state(made, step))
    motions, others, measures = zip(*states)
    still = copy(machine)
    still.forget_plan()
    still.chart = Given(even, PoseMotion.joined(motions))
    zero = np.zeros((len(even), machine.size))
    a = zero.copy()
    a[:, machine.n :] = others
    return Motion(still, even, zero, zero, a, angles=[np.concatenate(of_term) for of_term in zip(*measures)])


def _state(made: SpatialMachine, step: Step) -> tuple[PoseMotion, Array, list[Array]]:
    """Give poses, multipliers and measures where a step begins.

    Rates are brought onto the rows. Accelerations and multipliers come from M a + G^T L = F and the second derivatives
    of the rows: those at the end of a step have the order of its stages alone.
    """
    machine, t, zero = made.machine, np.array([step.t]), np.zeros((1, made.machine.size))
    n, rows = machine.n, len(machine.rows)
    held = machine.residual(t, zero, zero, zero, loads=0.0, moving=False, angles=step.angles)
    first, second = np.zeros((2, rows))
    for row, drive in zip(made.driven, made.scene.drives):
        rate = made.scene.cycle_rate
        jet = drive.jet(rate * t, rate)
        first[row], second[row] = rate * jet.first[0], rate**2 * jet.second[0]
    off = np.zeros_like(zero)
    off[0, n : n + rows] = machine.pattern.times(held.K, step.v[None])[0, n : n + rows] - first
    v = step.v + np.where(np.arange(machine.size) < n, accelerated(machine, held, -off)[0], 0.0)

    found = machine.residual(t, zero, v[None], zero, angles=step.angles, known=True)
    force = -found.force
    force[0, n:] = 0.0
    if rows:
        measured = machine.row_group.measure(found.at, None)
        bent = np.einsum("tn,tn->t", measured.rate_by_variables[0, :, 0], measured.ways[0])
        force[0, n : n + rows] = second - bent
    a = accelerated(machine, found, force)[0]
    return now(machine, step.t, v, a), a[n:], [term.x for term in found.terms]


def _start(made: SpatialMachine) -> Array:
    """Give rates at the start: links do not bend, drives and stated joints have their speeds, and energy is least."""
    machine, scene = made.machine, made.scene
    led, rates = copy(machine), []
    led.rows = list(machine.rows)
    led.forget_plan()
    for drive in scene.drives:
        rates.append(float(drive.jet(np.zeros(1), scene.cycle_rate).first[0]) * scene.cycle_rate)
    for joint, speed in scene.analysis.start_speeds.items():
        led.drive(scene.joints[joint].kind, "angle", made.joints[joint], np.zeros_like, joint)
        rates.append(speed)
    n, own = led.n, [row for row in range(len(machine.rows), len(led.rows))]
    J, _ = conditions(led, 0.0, np.zeros(led.size), np.ones(led.size - n, dtype=bool))
    asked = np.zeros(len(J))
    asked[[*made.driven, *own]] = rates
    units = led.units[:n]
    v = units * np.linalg.lstsq(J * units, asked, rcond=1e-8)[0]
    off = np.abs(J @ v - asked)
    if off.max(initial=0.0) > UNLED * max(np.abs(asked).max(), 1e-300) and np.abs(asked).max() > 0:
        raise SceneError(
            "no motion of rigid links has the speeds that drives and start speeds ask for",
            place="analysis.start_speeds",
        )
    zero = np.zeros((1, led.size))
    M = led.pattern.dense(led.residual(np.zeros(1), zero, zero, zero, loads=0.0, moving=False).M[0])[:n, :n]
    free = units[:, None] * scipy.linalg.null_space(J * units, rcond=1e-8)
    if free.shape[1]:
        v = v - free @ np.linalg.lstsq(free.T @ M @ free, free.T @ M @ v, rcond=1e-12)[0]
    return np.pad(v, (0, machine.size - n))
