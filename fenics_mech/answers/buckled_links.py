"""Which links buckle where there is no motion or equilibrium near the rigid one, or an unstable one."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.machine import Evaluation
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.solve import StaticIteration, axial_forces, quasi_static


def weakest_link(made: SceneMachine, steps: StaticIteration, k: int) -> str:
    """Name the link that bends most in the motion that the last stiffness at an instant resists least."""
    machine, n = made.machine, made.machine.n
    matrix = machine.pattern.matrix(steps.values[k]).toarray()
    stiff = matrix[:n, :n] + matrix[:n, :n].T
    units = 1 / np.sqrt(np.maximum(np.abs(stiff).max(axis=1), np.finfo(float).tiny))
    free = scipy.linalg.null_space(matrix[n:, :n] * units) if len(matrix) > n else np.eye(n)
    way = np.linalg.eigh(free.T @ (stiff * units * units[:, None]) @ free)[1][:, 0]
    moved = np.pad(units * (free @ way), (0, machine.size - n))[None]
    strains = np.einsum("emj,ej->em", steps.found.terms[0].gradient[k], machine.groups[0].variables(moved)[0])
    assert made.links is not None
    mesh = made.links.mesh
    energy = np.einsum("em,emn,en->e", strains, machine.beams.stiffness, strains)
    of_links = np.bincount(np.asarray(mesh.member_link)[np.asarray(mesh.cell_member)], energy)
    return list(made.scene.links)[int(of_links.argmax())]


def with_buckled(made: SceneMachine, t: Array, moving: bool, error: SolverError) -> SolverError:
    """Add to an error of Newton's method which straight link buckles under its static axial forces, if any."""
    # t: instants at which its links are looked at ``(instants,)`` (s)
    machine = made.machine
    straight = StaticIteration(machine, t, moving, axial_forces(machine, quasi_static(machine, t, moving)))
    straight.step()
    if not (yielding := straight.yielding).any():
        return error
    worst = int(np.argmax(yielding))
    angle = np.degrees(made.scene.cycle_rate * t[worst])
    return SolverError(
        f"{error}. The straight link {weakest_link(made, straight, worst)} buckles: under its axial forces the "
        f"stiffness is not positive at drive angle {angle:.6g} deg"
    )


FOLDED = 1.0  # rad, between the chord of an element and its ends' sections


def refuse_folded(made: SceneMachine, found: Evaluation, t: Array) -> None:
    """Raise `SolverError` where an element is bent so far that its strains are not those of its member."""
    # found: its residual ``(instants, ...)``; t: the instants (s)
    assert made.links is not None
    strains, mesh = found.terms[made.machine.terms.index(made.machine.beams)].x, made.links.mesh
    turned = np.abs(strains[..., 1]) + np.abs(strains[..., 2]) / 2
    k, e = np.unravel_index(int(turned.argmax()), turned.shape)
    if turned[k, e] > FOLDED:
        raise SolverError(
            f"member {mesh.members[mesh.cell_member[e]]!r} bends within one element by {turned[k, e]:.3g} rad from its "
            f"chord at drive angle {np.degrees(made.scene.cycle_rate * t[k]):.6g} deg, and strains are good up to "
            f"{FOLDED:g} rad. Take more elements, lower loads or speed, or stiffer members"
        )
