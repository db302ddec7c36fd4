"""Equilibrium of a linkage with freedoms: of links that bend, and of rigid ones."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.joints.joint_state import Touching
from fenics_mech.kinematics.free_linkage import FreeLinkage
from fenics_mech.mechanism import System
from fenics_mech.mechanism.rigid_dynamics import RigidDynamics, RigidStates
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import RestSolution
from fenics_mech.response.static.small_motions import REST, RestSearch
from fenics_mech.response.transient.free_state import FreeState, States
from fenics_mech.response.transient.rigid_instants import instants_of, part_of
from fenics_mech.response.transient.rigid_motion import RigidMotion, stated_start
from fenics_mech.response.transient.rigid_state import RigidState
from fenics_mech.scene import Friction, Scene


@dataclass(frozen=True)
class BentEquation:
    """The equation of freedoms and of links that bend.

    Parameters
    ----------
    state
        The equation at many states.
    """

    state: FreeState

    def residuals(self, time: Array, place: Array, rate: Array, second: Array) -> Array:
        """What is left of it, ``(times, coordinates)``."""
        return self.state.residual(time, (place, rate, second))

    def tangents_at(self, time: Array, place: Array, rate: Array, second: Array) -> States:
        """Tangents by y'', y' and y, ``(times, coordinates, coordinates)`` each."""
        return self.state.tangents(time, (place, rate, second))


def without_friction(scene: Scene) -> Scene:
    """Give a scene whose joints do not rub: what is at rest without friction is so with it.

    Parameters
    ----------
    scene
        The scene.
    """
    laws = {name: law for name, law in scene.joint_laws.items() if not isinstance(law, Friction)}
    return scene.model_copy(update={"joint_laws": laws})


@contextmanager
def saying_what_is_left_out(scene: Scene) -> Iterator[None]:
    """Say in an error of the search that dry friction, which may hold the linkage, has no part in it.

    Parameters
    ----------
    scene
        The scene.
    """
    try:
        yield
    except SolverError as error:
        rubs = next((name for name, law in scene.joint_laws.items() if isinstance(law, Friction)), None)
        if rubs is None:
            raise
        raise SolverError(
            f"{error}. The search leaves dry friction out, such as joint_laws.{rubs}: method = 'transient' with a "
            "duration shows whether it holds the linkage"
        ) from error


def resting(scene: Scene, places: Array) -> Scene:
    """Give a scene whose freedoms start at other places.

    Parameters
    ----------
    scene, places
        The scene, and angles and strokes, ``(freedoms,)``.
    """
    found = {
        name: part.model_copy(update={"start": float(place)})
        for (name, part), place in zip(scene.freedoms.items(), places)
    }
    return scene.model_copy(update={"freedoms": found})


def rigid_rest(scene: Scene) -> RigidMotion:
    """Find where rigid links are at rest, and what acts there.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that can move.

    Raises
    ------
    SolverError
        When there is no equilibrium near to the rough angles, or it is unstable.
    """
    quiet = without_friction(scene)
    state, still = RigidState(quiet, FreeLinkage(quiet)), np.zeros((1, len(scene.freedoms)))
    state.contacts = state.dynamics.all_closed()

    def states(places: Array) -> RigidStates:
        return state.states(np.zeros(1), (places[None], still, still))

    search = RestSearch(
        state, tuple(scene.freedoms), lambda places: state.move_on(states(places)), scene.analysis.allow_unstable
    )
    with saying_what_is_left_out(scene):
        places, vibrations = search.found_from(stated_start(scene).displacement)
    dynamics = RigidDynamics(scene, state.linkage.loops, state.linkage.start)
    found = part_of(instants_of(dynamics, states(places), dynamics.all_closed()), slice(None))
    return RigidMotion(scene, [found], [places[None]], [still], vibrations=vibrations)


def by_rest(scene: Scene, system: System) -> RestSolution:
    """Find where a linkage with freedoms is at rest, bent by what acts on it.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that can move.
    system
        Its mechanism at the rough angles.

    Raises
    ------
    SolverError
        When there is no equilibrium near to the rough angles, or it is unstable.
    """
    state = FreeState(without_friction(scene), system)
    state.contacts = {name: Touching.shut(law.contacts) for name, law in state.laws.items()}
    n, time, analysis = state.size, np.zeros(1), scene.analysis
    modes = n if analysis.modes == "all" else analysis.modes

    def move_on(y: Array) -> None:
        state.move_on(0.0, y, np.zeros_like(y))

    names, allowed = tuple(scene.freedoms), analysis.allow_unstable
    search = RestSearch(BentEquation(state), names, move_on, allowed, min(n, REST.basis * modes))
    with saying_what_is_left_out(scene):
        y, motions = search.found_from(np.append(np.zeros(n), stated_start(scene).displacement))
    states = y[None], np.zeros((1, len(y))), np.zeros((1, len(y)))
    here = state.system_at(time, states)
    response = state.response(here, states)
    return RestSolution(
        scene=resting(scene, y[n:]),
        system=state.with_laws(moved(scene, system, here.motion), response),
        response=response,
        vibrations=motions.first(modes),
    )
