"""Drag of the air in a motion that is found, as a load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects import Situation
from fenics_mech.effects.air_drag import AirFlow, SpreadDamping
from fenics_mech.effects.terms import Loads
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System
from fenics_mech.scene import Scene


def drag_known(scene: Scene, system: System, response: ElasticResponse) -> System:
    """Give a mechanism on which the drag of the air in a motion acts as a load along members, and damps nothing.

    Parameters
    ----------
    scene
        A scene that states air.
    system
        Its mechanism.
    response
        A motion of it.
    """
    if scene.damping.air is None:
        return system
    flow, terms = flow_of(scene, system), system.terms
    (known, _), (rigid, _) = flow.loads(*displacement_and_velocity(system, response)), flow.loads(*_still(system))
    change = rigid.of_columns(known.columns() - rigid.columns())
    damping, convective = (
        tuple(part for part in parts if not isinstance(part, SpreadDamping))
        for parts in (terms.matrices.damping, terms.matrices.convective)
    )
    matrices = replace(terms.matrices, damping=damping, convective=convective)
    return system.with_terms(replace(terms, loads=terms.loads + change, matrices=matrices))


def air_loads(scene: Scene, system: System, response: ElasticResponse, rigid: bool = False) -> tuple[Loads, Loads]:
    """Drag of the air in a motion, or in its rigid part alone, and the same turned by a quarter clockwise.

    Parameters
    ----------
    scene
        A scene that states air.
    system
        Its mechanism.
    response
        A motion of it.
    rigid
        Whether only the rigid part of the motion counts.

    Returns
    -------
    tuple
        The drag, and the same loads turned, both spread along the elements.
    """
    return flow_of(scene, system).loads(*(_still(system) if rigid else displacement_and_velocity(system, response)))


def flow_of(scene: Scene, system: System) -> AirFlow:
    """Give the flow of the air about the members.

    Parameters
    ----------
    scene
        A scene that states air.
    system
        Its mechanism.
    """
    return AirFlow.of(Situation(scene, system.beams, system.motion))


def _still(system: System) -> tuple[Array, Array]:
    none = np.zeros((len(system.motion.theta), system.transformation.height))
    return none, none


def displacement_and_velocity(system: System, response: ElasticResponse) -> tuple[Array, Array]:
    """Displacement and velocity that the drag knows, ``(angles, nodal dofs)`` each.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    """
    none, _ = _still(system)
    v = system.to_links(response.displacement) if system.terms.coupled else none
    return v, none if response.velocity is None else response.velocity
