"""Errors of strains and joint forces by the steps in time, from a better motion that the solver gives too."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.recovery.contacts import point_loads
from fenics_mech.recovery.joints import joint_forces, nodal_forces, reactions
from fenics_mech.recovery.members import recover_members, stiffnesses
from fenics_mech.response import History
from fenics_mech.scene import Scene

STATIONS = 5  # of each member at which strains are compared
SAFETY = 2  # by which differences are raised: they are 0.3 to 1 of the true error in what was tried
LARGEST_ERROR = 0.02  # of the largest strain
LEAST = 0.1  # of the mechanism's largest strain that a member's own must have to be the measure of its error


def time_errors(scene: Scene, system: System, history: History) -> tuple[np.ndarray, np.ndarray]:
    """Compare the outer fibres' strains, and the joint forces, with those of the better motion.

    Returns
    -------
    tuple
        Twice the largest difference of the strain in each member, ``(members,)``, and of the force in each joint (N),
        ``(joints,)``.
    """
    assert history.better is not None
    (axial, bending, forces), better = (_recovered(scene, system, h.elastic) for h in (history, history.better))
    error = SAFETY * (np.abs(better[0] - axial) + np.abs(better[1] - bending)).max(axis=(0, 2))
    return error, SAFETY * np.linalg.norm(better[2] - forces, axis=-1).max(axis=1, initial=0.0)


def judged(scene: Scene, error: np.ndarray, largest: np.ndarray) -> float:
    """Give the largest error of a strain relative to the member's largest strain; both are ``(members,)``.

    Raises
    ------
    SolverError
        When that is more than `LARGEST_ERROR`, unless the scene lets it pass.
    """
    measure = np.maximum(np.maximum(largest, LEAST * largest.max()), np.finfo(float).tiny)
    relative = error / measure
    worst = int(relative.argmax())
    analysis = scene.analysis
    if not relative[worst] <= LARGEST_ERROR and not analysis.allow_coarse:
        order = 2 * analysis.stages - (analysis.scheme == "radau")
        finer = math.ceil(1.2 * analysis.sub_intervals * (relative[worst] / LARGEST_ERROR) ** (1 / order))
        raise SolverError(
            f"the sub-intervals are too long: the strain of {list(scene.members())[worst]!r} is uncertain by "
            f"{relative[worst]:.2g} of its largest value, by estimate. Take at least {finer} sub_intervals; "
            "analysis.allow_coarse lets it pass"
        )
    return float(relative[worst])


def _recovered(scene: Scene, system: System, history: History) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Axial and bending strain at few stations, ``(angles, members, stations)``, forces ``(joints, angles, 2)``."""
    found = reactions(system, nodal_forces(system, history))
    s = np.linspace(0, 1, STATIONS)
    members = recover_members(system, history, s, point_loads(system, found))
    ea, ei, _, fibre = stiffnesses(scene, s)
    axial = members.axial_force / ea
    forces = np.array(list(joint_forces(scene, found).values())).reshape(-1, len(axial), 2)
    return axial, members.moment * np.abs(fibre).max(axis=-1) / ei, forces
