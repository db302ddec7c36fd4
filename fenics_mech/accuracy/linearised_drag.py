"""What the drag of the air that is linearised about the rigid motion leaves out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.errors import UnresolvedError
from fenics_mech.forces.air import displacement_and_velocity, flow_of
from fenics_mech.mechanism import System
from fenics_mech.response.solution import Solution
from fenics_mech.response.static.quasi_static import yielding_to


@dataclass(frozen=True)
class DragLimits:
    """How far the linearised drag of the air may be off."""

    mentioned: float = 0.01  # of the drag, from which a result says so
    largest: float = 1e-3  # of the elastic displacement in the energy norm, by statics: 1 % where vibration is tenfold


DRAG = DragLimits()


def left_out_of_drag(solution: Solution) -> list[str]:
    """Say what the linearised drag of the air leaves out, as a share of the largest drag of a member.

    Parameters
    ----------
    solution
        A solution of any method.

    Returns
    -------
    list of str
        A phrase; none where the share is below `DRAG.mentioned`, or the response has no velocity.

    Raises
    ------
    UnresolvedError
        When it matters to drag and strains, unless the scene lets it pass: see `DragLimits`.
    """
    scene, system, response = solution.scene, solution.system, solution.response
    if scene.damping.air is None or response.velocity is None:
        return []
    flow = flow_of(scene, system)
    ends, bound = flow.left_out(*displacement_and_velocity(system, response))
    by_member = flow.by_member(bound).max(axis=0)
    if not by_member.any():
        return []
    share = float(by_member.max()) / max(flow.largest(), TINY)
    if share <= DRAG.mentioned:
        return []
    remark = f"what the drag of the air does by the square of the links' vibration, up to {share:.2g} of the drag"
    if scene.analysis.allow_coarse:
        return [remark]
    unstressed = system.without_axial_forces
    q = yielding_to(unstressed, unstressed.on_coordinates(unstressed.assembled_from_members(ends)))
    change = np.sqrt(_energy(system, system.to_links(q)) / _energy(system, system.to_links(response.displacement)))
    if change > DRAG.largest:
        member = system.beams.mesh.members[int(by_member.argmax())]
        raise UnresolvedError(
            f"member {member} vibrates too fast for the drag of the air, linearised about the rigid motion: "
            f"this neglects up to {share:.2g} of the drag, and {change:.1e} of the displacement by statics. Take "
            "damping.external instead of damping.air; analysis.allow_coarse lets it pass"
        )
    return [remark]


def _energy(system: System, v: Array) -> float:
    """Largest strain energy of displacements in link axes, but for a factor (J)."""
    return float(np.sum(v * (system.nodal_stiffness @ v.T).T, axis=1).max())
