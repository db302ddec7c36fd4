"""Equilibrium of a linkage with freedoms, of links that bend."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.held_by_friction import holds
from fenics_mech.joints.joint_state import Touching
from fenics_mech.mechanism import System
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import RestSolution
from fenics_mech.response.static.small_motions import REST, RestSearch
from fenics_mech.response.transient.free_state import FreeState, States
from fenics_mech.scene import Friction, Scene
from fenics_mech.scene.start_state import StartState


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
    """Give a scene in which no dry friction holds a joint at rest.

    Parameters
    ----------
    scene
        The scene.
    """
    none = {"coefficient": 0.0, "static": None, "stribeck": None}
    laws = {name: law.model_copy(update=none) if holds(law) else law for name, law in scene.joint_laws.items()}
    return scene.model_copy(update={"joint_laws": laws})


def refuse_friction(scene: Scene, why: str) -> None:
    """Raise `SceneError` where a joint has dry friction.

    Parameters
    ----------
    scene
        The scene.
    why
        What it has, of which a range of equilibria is not found.
    """
    for name, law in scene.joint_laws.items():
        if isinstance(law, Friction) and (law.belt_speed or holds(law)):
            raise SceneError(
                f"dry friction holds a linkage in a range of equilibria, which is found of one freedom of links that "
                f"are rigid. This scene has {why}",
                place=f"joint_laws.{name}",
                hint="Write method = 'transient' with a duration, which shows where it comes to rest",
            )


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
    SceneError
        When joints rub.
    SolverError
        When there is no equilibrium near to the rough angles, or it is unstable.
    """
    refuse_friction(scene, "links that bend")
    state = FreeState(scene, system)
    state.contacts = {name: Touching.shut(law.contacts) for name, law in state.laws.items()}
    n, time, analysis = state.size, np.zeros(1), scene.analysis
    modes = n if analysis.modes == "all" else analysis.modes

    def move_on(y: Array) -> None:
        state.move_on(0.0, y, np.zeros_like(y))

    names, allowed = tuple(scene.freedoms), analysis.allow_unstable
    search = RestSearch(BentEquation(state), names, move_on, allowed, min(n, REST.basis * modes))
    y, motions = search.found_from(np.append(np.zeros(n), StartState.stated(scene).displacement))
    states = y[None], np.zeros((1, len(y))), np.zeros((1, len(y)))
    here = state.system_at(time, states)
    response = state.response(here, states)
    return RestSolution(
        scene=resting(scene, y[n:]),
        system=state.with_laws(moved(scene, system, here.motion), response),
        response=response,
        vibrations=motions.first(modes),
    )
