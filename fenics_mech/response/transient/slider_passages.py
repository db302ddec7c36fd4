"""Velocities that jump in time as a slider passes a node of the member that it turns with; see `turning_sliders`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.turning_sliders import turning_sliders
from fenics_mech.response.setup import moved
from fenics_mech.response.transient.course import PlaceJumps, VelocityJumps
from fenics_mech.response.velocity_jumps import passages
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class PassageLimits:
    """How the drive angles are found at which sliders pass nodes."""

    iterations: int = 60  # halvings of an angle between two positions: to rounding
    beside: float = 1e-7  # rad, before and after a node: P' itself changes in proportion to it


PASSAGE = PassageLimits()


def slider_passages(scene: Scene, system: System, start: float, end: float) -> VelocityJumps | None:
    """Give the jumps of velocities in a stretch of time, through a run-up too, by the displacement at each time.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism over one cycle.
    start, end
        Ends of the time (s). The state at the start is one after a passage.

    Returns
    -------
    VelocityJumps or None
        None where no slider turns with a member that it travels along, past nodes.
    """
    names = turning_sliders(system) if system.terms.coupled else []
    theta = np.concatenate([np.zeros(0), *(_passed(scene, system, name) for name in names)])
    if not len(theta):
        return None
    met = [times[times > start] for times in (passages(scene, angle, start, end) for angle in theta)]
    time, which = np.concatenate(met), np.repeat(np.arange(len(theta)), [len(times) for times in met])
    order = np.argsort(time, kind="stable")
    by_place, faster = _jumps(scene, system, theta), scene.coordinate(time[order]).first / scene.cycle_rate
    return VelocityJumps(time[order], which[order], np.zeros(by_place.shape[:2]), PlaceJumps(by_place, faster))


def _passed(scene: Scene, system: System, name: str) -> Array:
    """Drive angles (rad) in a cycle at which a slider passes nodes, ``(passages,)``."""
    contact, mesh = system.transformation.constraints.contacts[name], system.beams.mesh
    cells = np.flatnonzero(mesh.cell_member == contact.member)
    nodes = mesh.cell_start[cells[1:]]

    def along(theta: Array) -> Array:
        element, place = contact.place(solve_motion(scene, theta, near=system.motion), 1)
        return np.asarray(mesh.cell_start[element] + place[0] * mesh.cell_length[element])

    theta = np.append(system.motion.theta, system.motion.theta[0] + np.copysign(2 * np.pi, scene.cycle_rate))
    beyond = np.append(along(theta[:-1]), along(theta[:1]))[:, None] >= nodes
    step, node = np.nonzero(beyond[1:] != beyond[:-1])
    if not len(step):
        return np.zeros(0)
    low, high, side = theta[step], theta[step + 1], beyond[step, node]
    for _ in range(PASSAGE.iterations):
        middle = (low + high) / 2
        same = (along(middle) >= nodes[node]) == side
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return (low + high) / 2


def _jumps(scene: Scene, system: System, theta: Array) -> Array:
    """Matrices of ``M jump(q') = -P^T m jump(P') q`` at drive angles (rad), ``(angles, coordinates, coordinates)``."""
    beside, layout = np.copysign(PASSAGE.beside, scene.cycle_rate), system.transformation
    before, after = (
        layout.derivatives(solve_motion(scene, theta + side, near=system.motion))[0] for side in (-beside, beside)
    )
    there = moved(scene, system, solve_motion(scene, theta, near=system.motion))
    carried = layout.forward((after - before)[:, None], np.eye(system.size))
    momenta = (system.link_mass @ carried.reshape(-1, carried.shape[-1]).T).T.reshape(carried.shape)
    lost = layout.backward(there.values[:, None], momenta)
    return -np.linalg.solve(Equation(there).linear.mass.full, lost.swapaxes(1, 2))
