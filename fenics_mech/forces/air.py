"""Drag of the air in a motion that is found: as a load, and what its linearised law leaves out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.effects import Situation
from fenics_mech.effects.air_drag import Flow, SpreadDamping
from fenics_mech.effects.terms import Terms
from fenics_mech.errors import UnresolvedError
from fenics_mech.mechanism import System
from fenics_mech.response import History
from fenics_mech.response.static.quasi_static import yielding_to
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
TINY = float(np.finfo(float).tiny)
LEAST_TOLD = 0.01  # of the drag, by which its linearised law may be off without a word
MOST_LEFT_OUT = 1e-3  # of the elastic displacement in the energy norm, by statics: 1 % where vibration makes it tenfold


def drag_known(scene: Scene, system: System, history: History) -> System:
    """Give a mechanism on which the drag of the air in a motion acts as a load along members, and damps nothing."""
    if scene.damping.air is None:
        return system
    flow, terms = _flow(scene, system), system.terms
    (known, _), (rigid, _) = flow.loads(*_motion(system, history)), flow.loads(*_still(system))
    change = rigid.of_columns(known.columns() - rigid.columns())
    damping, convective = (
        tuple(part for part in parts if not isinstance(part, SpreadDamping))
        for parts in (terms.damping, terms.convective)
    )
    return system.with_terms(replace(terms, damping=damping, convective=convective) + change)


def air_loads(scene: Scene, system: System, history: History, rigid: bool = False) -> tuple[Terms, Terms]:
    """Drag of the air in a motion, or in its rigid part alone, and the same turned by a quarter clockwise."""
    return _flow(scene, system).loads(*(_still(system) if rigid else _motion(system, history)))


def left_out(scene: Scene, system: System, history: History) -> float:
    """Tell what the linearised drag of the air leaves out, as a share of the largest drag of a member.

    Raises
    ------
    UnresolvedError
        When it matters to drag and strains, unless the scene lets it pass: see `LEAST_TOLD` and `MOST_LEFT_OUT`.
    """
    if scene.damping.air is None or history.velocity is None:
        return 0.0
    flow = _flow(scene, system)
    ends, bound = flow.left_out(*_motion(system, history))
    by_member = flow.by_member(bound).max(axis=0)
    if not by_member.any():
        return 0.0
    share = float(by_member.max()) / max(flow.largest(), TINY)
    if share <= LEAST_TOLD or scene.analysis.allow_coarse:
        return share
    slack = system.slack
    q = yielding_to(slack, slack.on_coordinates(slack.assembled_from_members(ends)), scene.petsc)
    change = np.sqrt(_energy(system, system.to_links(q)) / _energy(system, system.to_links(history.displacement)))
    if change > MOST_LEFT_OUT:
        member = system.beams.mesh.members[int(by_member.argmax())]
        raise UnresolvedError(
            f"member {member} vibrates too fast for the drag of the air, which is linearised about the rigid motion: "
            f"that leaves out up to {share:.2g} of the drag, and {change:.1e} of the displacement by statics. Take "
            "damping.external instead of damping.air; analysis.allow_coarse lets it pass"
        )
    return share


def unlinear(share: float) -> list[str]:
    """Say that the linearised drag leaves out a share of the drag that is worth a word."""
    if share <= LEAST_TOLD:
        return []
    return [f"what the drag of the air does by the square of the links' vibration, up to {share:.2g} of the drag"]


def _energy(system: System, v: Array) -> float:
    """Largest strain energy of displacements in link axes, but for a factor (J)."""
    return float(np.sum(v * (system.nodal_stiffness @ v.T).T, axis=1).max())


def _flow(scene: Scene, system: System) -> Flow:
    return Flow.of(Situation(scene, system.beams, system.motion))


def _still(system: System) -> tuple[Array, Array]:
    none = np.zeros((len(system.motion.theta), system.transformation.height))
    return none, none


def _motion(system: System, history: History) -> tuple[Array, Array]:
    """Displacement and velocity that the drag knows, ``(angles, nodal dofs)`` each."""
    none, _ = _still(system)
    v = system.to_links(history.displacement) if system.terms.coupled else none
    return v, none if history.velocity is None else history.velocity
