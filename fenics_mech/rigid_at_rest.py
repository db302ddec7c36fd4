"""Equilibrium of rigid links with freedoms, by the equation of poses, and small motions about it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.by_poses import read_off
from fenics_mech.errors import SolverError
from fenics_mech.held_by_friction import FrictionAtRest, Held, holds
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.machine.freed import Freed
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.recovery.at_rest import of_friction, of_small_motions
from fenics_mech.recovery.dataset import joined
from fenics_mech.recovery.result import Result
from fenics_mech.response.static.rest import refuse_friction, resting, without_friction
from fenics_mech.response.static.small_motions import RestSearch, SmallMotions
from fenics_mech.rigid_by_poses import of_laws, with_all_units
from fenics_mech.rigid_in_time import freed_of, rigid_at
from fenics_mech.scene import Scene
from fenics_mech.scene.start_state import StartState

LED = 0.2  # rad, by which drives lead links to where they are held


def rigid_at_rest(scene: Scene, placed: bool = True) -> Result:
    """Find where rigid links are at rest, and what acts there.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that its drives leave free.
    placed
        Whether it states where the freedoms are, so that friction may hold them there.

    Raises
    ------
    SceneError
        When joints rub and there are several freedoms.
    SolverError
        When there is no equilibrium near to the rough angles, or it is unstable.
    """
    motions: SmallMotions | None = None
    if any(map(holds, scene.joint_laws.values())):
        if len(scene.freedoms) > 1:
            refuse_friction(scene, f"freedoms at joint {', '.join(scene.freedoms)}")
        if not placed:
            try:
                place, motions = _AtRest.of(without_friction(scene)).found()
            except SolverError:
                pass
            else:
                scene = resting(scene, place)
        rubbing = _AtRest.of(scene)
        friction = FrictionAtRest(rubbing.made, rubbing.freed, rubbing.t)
        start = float(rubbing.freed.place[0])
        if friction.acts(start):
            held = friction.held_near(start)
            friction.hold(held)
            return _labelled(rubbing, np.array([held.place]), motions, held)
        scene = without_friction(scene)
    at_rest = _AtRest.of(scene)
    return _labelled(at_rest, *at_rest.found())


def _labelled(at_rest: _AtRest, place: Array, motions: SmallMotions | None, held: Held | None = None) -> Result:
    """Label what acts at places of the freedoms ``(freedoms,)``."""
    scene, freed, still = at_rest.made.scene, at_rest.freed, np.zeros((1, len(place)))
    known = freed.carried(at_rest.t, place[None], still, still).resting()
    found = rigid_at(at_rest.made, freed, known, scene.cycle_rate * at_rest.t, None)
    along, labels = ("theta", "freedom"), {"freedom": list(scene.freedoms)}
    states = xr.Dataset({"freedom_place": (along, place[None]), "freedom_rate": (along, still)}, labels)
    parts = [states] if motions is None else [states, of_small_motions(motions)]
    data = joined(read_off(found), of_laws(found), *parts)
    if held is not None:
        data = joined(data, of_friction(held, next(iter(scene.freedoms)), [str(x) for x in data["law"].to_numpy()]))
    return with_all_units(scene, data)


@dataclass(frozen=True)
class _AtRest:
    """The equation of the freedoms where the drives are at their position.

    Parameters
    ----------
    made, freed
        The machine.
    t
        When the drives are there ``(1,)`` (s).
    """

    made: SceneMachine
    freed: Freed
    t: Array

    @classmethod
    def of(cls, scene: Scene) -> _AtRest:
        """Build it, with all contacts closed, and lead the drives from the start to their position.

        The freedoms are held meanwhile.
        """
        made, start = machine_of(scene), StartState.stated(scene)
        freed, t = freed_of(made, start), np.zeros(1)
        for term in freed.terms:
            if isinstance(term, LawTerm) and term.contacts:
                term.shut()
        still = np.zeros((1, freed.n))
        if scene.drives:
            count = 1 + math.ceil(abs(scene.analysis.position) / LED)
            for share in np.arange(1, count + 1) / count:
                t = np.array([share * scene.analysis.position / scene.cycle_rate])
                freed.go_back(freed.carried(t, freed.place[None], still, still))
        return cls(made, freed, t)

    def found(self) -> tuple[Array, SmallMotions]:
        """Give the places of the freedoms at rest ``(freedoms,)``, and small motions about them."""
        scene = self.made.scene
        search = RestSearch(self, tuple(scene.freedoms), lambda place: None, scene.analysis.allow_unstable)
        return search.found_from(self.freed.place)

    def residuals(self, time: Array, place: Array, rate: Array, second: Array) -> Array:
        """Give what the freedoms would have to be held by, with the other sign ``(1, freedoms)``."""
        return self.freed.residual(self.t, place - self.freed.place, rate, second, moving=False).force

    def tangents_at(self, time: Array, place: Array, rate: Array, second: Array) -> tuple[Array, Array, Array]:
        """Give tangents by accelerations, rates and places of the freedoms ``(1, freedoms, freedoms)`` each."""
        return self.freed.tangents_at(self.t, place, rate, second, moving=False)
