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
from fenics_mech.solve import States, steps_in_time

BEGUN = 1e-4  # of the way to the first instant, where forces at the start are told
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
    times = np.insert(even, 1, BEGUN * even[1])
    states: list[States] = []
    for step in steps_in_time(
        machine,
        _start(made),
        times,
        tolerance=tolerance,
        longest=analysis.duration / analysis.positions,
        angles=machine.angles_as_drawn(),
    ):
        if np.abs(times - step.t - step.h).min() < 1e-3 * times[1]:
            states.append(step.at_end())
    whole = States.joined(states)
    still = copy(machine)
    still.forget_plan()
    motion = PoseMotion(*(x.copy() for x in whole.motion.arrays))
    still.chart = Given(whole.t, motion)
    zero = np.zeros((len(whole.t), machine.size))
    a = zero.copy()
    a[:, machine.n :] = whole.others
    return Motion(still, whole.t, zero, zero, a, angles=whole.measures)


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
