"""Equilibrium of rigid links with freedoms, by the equation of poses, and the friction that may hold it."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.answers.by_poses import read_off
from fenics_mech.answers.held_by_friction import FrictionAtRest, Held, holds
from fenics_mech.answers.rest_by_poses import LED, Resting, of_small_motions, refuse_friction, without_friction
from fenics_mech.answers.rigid_in_time import freed_of
from fenics_mech.errors import SolverError
from fenics_mech.recovery.dataset import joined
from fenics_mech.recovery.freedoms_and_laws import law_efforts, of_freedoms
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.variables import with_units
from fenics_mech.scene import Scene
from fenics_mech.scene.start_state import StartState
from fenics_mech.solve.rest import SmallMotions


def rigid_at_rest(scene: Scene, placed: bool = True) -> Result:
    """Find where rigid links are at rest, and what acts there."""
    motions: SmallMotions | None = None
    if any(map(holds, scene.joint_laws.values())):
        if len(scene.freedoms) > 1:
            refuse_friction(scene, f"freedoms at joint {', '.join(scene.freedoms)}")
        if not placed:
            try:
                place, motions = _found(Resting.of(without_friction(scene)))
            except SolverError:
                pass
            else:
                scene = scene.changed({f"freedoms.{name}.start": float(x) for name, x in zip(scene.freedoms, place)})
        rubbing = Resting.of(scene)
        friction = _friction(rubbing)
        start = float(rubbing.start[0])
        if friction.acts(start):
            held = friction.held_near(start)
            friction.hold(held)
            return _labelled(rubbing, np.array([held.place]), motions, held)
        scene = without_friction(scene)
    resting = Resting.of(scene)
    return _labelled(resting, *_found(resting))


def _found(resting: Resting) -> tuple[Array, SmallMotions]:
    """Give the places of the freedoms at rest ``(freedoms,)``, and small motions about them."""
    place, here = resting.search.found_from(resting.start)
    return place, resting.small_motions(place, here, 2 * len(place))


def _friction(resting: Resting) -> FrictionAtRest:
    """Give the friction of a machine whose drives are led from the start to their position."""
    scene = resting.made.scene
    freed, still = freed_of(resting.made, StartState.stated(scene)), np.zeros((1, 1))
    if scene.drives:
        count = 1 + math.ceil(abs(scene.analysis.position) / LED)
        for share in np.arange(1, count + 1) / count:
            freed.go_back(freed.carried(share * resting.t, freed.place[None], still, still))
    return FrictionAtRest(resting.made, freed, resting.t)


def _labelled(resting: Resting, place: Array, motions: SmallMotions | None, held: Held | None = None) -> Result:
    """Label what acts at places of the freedoms ``(freedoms,)``."""
    scene, found = resting.made.scene, resting.read(place, resting.search.at(place))
    laws = law_efforts(found)
    parts = [read_off(found), laws, of_freedoms(scene, place[None], 0 * place[None])]
    if motions is not None:
        parts.append(of_small_motions(motions))
    if held is not None:
        used = [held.used.get(str(name), np.nan) for name in laws["law"].to_numpy()]
        limits = {f"rest_{name}": (("freedom",), [end]) for name, end in zip(("lowest", "highest"), held.range)}
        parts.append(xr.Dataset(limits | {"friction_used": (("law",), used)}))
    return Result.with_scene(scene, with_units(scene, joined(*parts)))
