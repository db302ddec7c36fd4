"""Error of the strains by the steps in time, from a better motion that the solver gives along with its own."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.recovery.contacts import point_loads
from fenics_mech.recovery.joints import nodal_forces, reactions
from fenics_mech.recovery.members import MemberState, recover_members
from fenics_mech.response import History
from fenics_mech.scene import Scene

STATIONS = 5  # of each member at which strains are compared
SAFETY = 2  # by which differences are raised: they are 0.3 to 1 of the true error in what was tried
LARGEST_ERROR = 0.02  # of the largest strain
LEAST = 0.1  # of the mechanism's largest strain that a member's own must have to be the measure of its error


def strain_error(scene: Scene, system: System, history: History) -> tuple[np.ndarray, float]:
    """Compare the outer fibres' strains with those of the better motion.

    Returns
    -------
    tuple
        Twice the largest difference in each member, ``(members,)``, and the largest of them relative to the member's
        largest strain.

    Raises
    ------
    SolverError
        When that is more than `LARGEST_ERROR`, unless the scene lets it pass.
    """
    assert history.better is not None
    (axial, bending), (better_axial, better_bending) = (
        _strains(scene, system, h.elastic) for h in (history, history.better)
    )
    error = SAFETY * (np.abs(better_axial - axial) + np.abs(better_bending - bending)).max(axis=(0, 2))
    largest = (np.abs(axial) + np.abs(bending)).max(axis=(0, 2))
    measure = np.maximum(np.maximum(largest, LEAST * largest.max()), np.finfo(float).tiny)
    relative = error / measure
    worst = int(relative.argmax())
    analysis = scene.analysis
    if not relative[worst] <= LARGEST_ERROR and not analysis.allow_coarse:
        order = 2 * analysis.stages - (analysis.scheme == "radau")
        finer = math.ceil(1.2 * analysis.sub_intervals * (relative[worst] / LARGEST_ERROR) ** (1 / order))
        raise SolverError(
            f"the sub-intervals are too long: the strain of {system.beams.mesh.members[worst]!r} is uncertain by "
            f"{relative[worst]:.2g} of its largest value, by estimate. Take at least {finer} sub_intervals; "
            "analysis.allow_coarse lets it pass"
        )
    return error, float(relative[worst])


def _strains(scene: Scene, system: System, history: History) -> tuple[np.ndarray, np.ndarray]:
    """Axial and bending strain at few stations, ``(angles, members, stations)`` each."""
    found = reactions(system, nodal_forces(system, history))
    s = np.linspace(0, 1, STATIONS)
    members: MemberState = recover_members(system, history, s, point_loads(system, found))
    rigidity = [scene.rigidity(label, s) for label in scene.members()]
    fibre = np.stack([np.abs(r.fibre).max(axis=-1) for r in rigidity])
    axial = members.axial_force / np.stack([r.axial for r in rigidity])
    return axial, members.moment * fibre / np.stack([r.bending for r in rigidity])
