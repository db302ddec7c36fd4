"""Equilibrium of rigid links with freedoms, by the equation of poses, and small motions about it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine.rigid_from_scene import motion_of_bodies
from fenics_mech.recovery.at_rest import of_small_motions
from fenics_mech.recovery.dataset import joined
from fenics_mech.recovery.law_efforts import with_law_units
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.variables import with_units
from fenics_mech.response.static.small_motions import RestSearch
from fenics_mech.rigid_by_poses import acting, carried, motion_of, read_off
from fenics_mech.rigid_in_time import FreeMachine
from fenics_mech.scene import Scene
from fenics_mech.solve.held import led_by

LED = 0.2  # rad, by which drives lead links to where they are held


def rigid_at_rest(scene: Scene) -> Result:
    """Find where rigid links are at rest, and what acts there.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that its drives leave free.

    Raises
    ------
    SolverError
        When there is no equilibrium near to the rough angles, or it is unstable.
    """
    machine = FreeMachine.of(scene)
    start = np.array([part.start or 0.0 for part in scene.freedoms.values()])
    equation = _AtRest(machine, machine.made.bodies.q[None])
    equation.lead(start)
    search = RestSearch(equation, tuple(scene.freedoms), equation.move_on, scene.analysis.allow_unstable)
    place, motions = search.found_from(start)
    along, labels = ("theta", "freedom"), {"freedom": list(scene.freedoms)}
    states = xr.Dataset({"freedom_place": (along, place[None]), "freedom_rate": (along, 0 * place[None])}, labels)
    data = read_off(scene, acting(machine.holding, equation.links(place)))
    data = joined(data, states, of_small_motions(motions))
    units = effort_units(scene.moved_joints, scene.joints)
    return Result.with_scene(
        scene, with_law_units(scene, with_units(data, units, scene.springs.values(), scene.dampers.values()))
    )


@dataclass
class _AtRest:
    """What is left of the equation of the freedoms at rest, with its tangents.

    Parameters
    ----------
    machine
        The machine.
    near
        Coordinates of the links as bodies near to those that are sought ``(1, size)``.
    """

    machine: FreeMachine
    near: Array
    t: Array = field(default_factory=lambda: np.zeros(1))

    def lead(self, place: Array) -> None:
        """Lead the drives from the start to their position, with the freedoms held at places ``(freedoms,)``."""
        scene = self.machine.made.scene
        if not scene.drives:
            return
        count = 1 + math.ceil(abs(scene.analysis.position) / LED)
        for share in np.arange(1, count + 1) / count:
            self.t = np.array([share * scene.analysis.position / scene.cycle_rate])
            self.move_on(place)

    def links(self, place: Array) -> LinkMotion:
        """Give the links where the freedoms are at places ``(freedoms,)``."""
        scene = self.machine.made.scene
        theta = scene.cycle_rate * self.t if scene.drives else self.machine.theta(self.t, place[None])
        return motion_of(self.machine.made, theta, self.t, self._bodies(place)).held()

    def _bodies(self, place: Array) -> tuple[Array, Array, Array]:
        made, none = self.machine.made, np.zeros((1, len(place)))
        rate, still = made.scene.cycle_rate, np.zeros((1, len(made.scene.drives)))
        led = [drive.jet(rate * self.t, rate).value for drive in made.scene.drives]
        drives = np.array(led).T if led else still, still, still
        return motion_of_bodies(made, self.t, self.near, (place[None], none, none), drives)

    def move_on(self, place: Array) -> None:
        """Take places of the freedoms as those that others are near to."""
        self.near = self._bodies(place)[0]

    def residuals(self, time: Array, place: Array, rate: Array, second: Array) -> Array:
        """Give what the freedoms would have to be held by, with the other sign ``(1, freedoms)``."""
        return self._found(place)[0]

    def tangents_at(self, time: Array, place: Array, rate: Array, second: Array) -> tuple[Array, Array, Array]:
        """Give tangents by accelerations, rates and places of the freedoms ``(1, freedoms, freedoms)`` each."""
        mass, damping, stiffness = self._found(place)[1]
        return mass, damping, stiffness

    def _found(self, place: Array) -> tuple[Array, tuple[Array, ...]]:
        machine, angles = carried(self.machine.holding, links := self.links(place[0]))
        rows = range(len(machine.rows) - place.shape[1], len(machine.rows))
        return led_by(machine, links.time, rows, angles=angles, moving=False)
