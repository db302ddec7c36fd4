"""Singular positions of a linkage: where the drive locks, and where the assembly branch is not unique.

The smallest singular value of the loop Jacobian, made free of units, is 0 there. At a dead centre the drive cannot go
on; at a change point the linkage can go on in two ways. Between them its minima tell where force is transmitted worst.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._guard import guarded
from fenics_mech.kinematics.assembly import AssemblyBranch, coordinates_at, follow_branch
from fenics_mech.kinematics.conditioning import CONDITION, links_moved, locks, singular_values
from fenics_mech.kinematics.freedom import describe, free_motions
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.minimum import minimum
from fenics_mech.kinematics.start import assemble
from fenics_mech.kinematics.transmission import Transmission, worst_transmission
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class Critical:
    """A position where the smallest singular value of the loop Jacobian is 0 or has a minimum.

    Parameters
    ----------
    theta
        Drive coordinate (rad).
    kind
        "dead centre", "change point" or "worst transmission".
    value
        The smallest singular value, 0 to about 1.
    links
        The links that move there while the drive stands still, those that move most first.
    """

    theta: float
    kind: str
    value: float
    links: tuple[str, ...]


@dataclass(frozen=True)
class Range:
    """What the drive can reach from theta = 0.

    Parameters
    ----------
    low, high
        Limits of the drive coordinate (rad), at most a whole cycle to either side.
    turns
        Whether the drive can run through a whole cycle.
    critical
        Singular positions, and the minima of the smallest singular value, by theta.
    free
        What can move where nothing is driven, in words.
    transmission
        The worst transmission angles, where the drive can run through a whole cycle and all of them are known.
    """

    low: float
    high: float
    turns: bool
    critical: tuple[Critical, ...]
    free: tuple[str, ...] = ()
    transmission: tuple[Transmission, ...] = ()


@guarded()
def reachable_range(scene: Scene) -> Range:
    """Find how far the drive can go from theta = 0 in both directions, and the critical positions on the way.

    Dead centres are located to 1e-9 rad, minima to 1e-6 rad, change points that end the range to about 1e-5 rad.

    Parameters
    ----------
    scene
        The linkage and its drives.

    Returns
    -------
    Range
        Limits of the drive (rad), singular positions and worst transmission angles.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at theta = 0.
    SceneError
        When there are fewer drives than freedoms, but at least one.
    """
    loops = Loops.of(scene)
    if not scene.drives:
        q = assemble(loops)
        return Range(0.0, 0.0, False, (), tuple(describe(scene.links, scene.joints, q, free_motions(loops, q))))
    if scene.open_joints:  # how far a drive goes is that of tight pins
        loops = Loops.of(scene.model_copy(update={"joint_laws": {}}))
    whole = np.array([-2 * np.pi, 2 * np.pi])
    branch = follow_branch(loops, assemble(loops), whole, to_the_end=True)
    limits = [
        _limit(loops, branch, end) if abs(end) < 2 * np.pi else None
        for end in (float(branch.theta[0]), float(branch.theta[-1]))
    ]
    low, high = (limit.theta if limit else target for limit, target in zip(limits, whole))
    turns = high - low >= 2 * np.pi * (1 - 1e-12)
    minima = _minima(loops, branch, 0.0 if turns else low, 2 * np.pi if turns else high, turns)
    found = [limit for limit in limits if limit] + minima
    pairs = worst_transmission(loops, branch) if turns else ()
    return Range(low, high, turns, tuple(sorted(found, key=lambda critical: critical.theta)), transmission=pairs)


def _limit(loops: Loops, branch: AssemblyBranch, end: float) -> Critical:
    """Where the branch ends: at a dead centre the loops close, and the Jacobian has a null vector of length 1."""
    last = int(np.argmin(np.abs(branch.theta - end)))
    q = branch.q[last]
    null = singular_values(loops, q[None])[1][0, -1] / loops.unit
    if not locks(loops, q, branch.rate[last]):
        return Critical(end, "change point", 0.0, links_moved(loops, null))
    from scipy.optimize import root  # noqa: PLC0415  (slow to import, and few drives lock)

    n = len(q)

    def equations(x: Array) -> Array:
        place, vector, theta = x[:n] * loops.unit, x[n : 2 * n], x[-1:]
        closed = loops.residual(place[None], loops.drive(theta).value)[0] / loops.scale
        moved = loops.without_units(place[None])[0] @ vector
        return np.concatenate([closed, moved, [vector @ vector - 1]])

    answer = root(equations, np.concatenate([q / loops.unit, null, [end]]), tol=1e-14)
    theta = float(answer.x[-1]) if abs(answer.x[-1] - end) < 1e-3 else float(end)
    vector = answer.x[n : 2 * n] if theta != end else null
    return Critical(theta, "dead centre", 0.0, links_moved(loops, vector))


def _minima(loops: Loops, branch: AssemblyBranch, low: float, high: float, closed: bool) -> list[Critical]:
    """Minima of the smallest singular value inside the range, which is a closed cycle or ends at dead centres."""
    inside = 0.0 if closed else 1e-9 * (high - low)

    def smallest(theta: Array) -> Array:
        return singular_values(loops, coordinates_at(loops, theta, branch))[0][:, -1]

    thetas = np.linspace(low + inside, high - inside, CONDITION.samples)
    values = smallest(thetas)
    if closed:  # the first sample again is the last
        values = values[:-1]
    if np.ptp(values) < CONDITION.flat * values.max():  # drives that move every link of a chain: minima are rounding
        return []
    lowest = (values < np.roll(values, 1)) & (values <= np.roll(values, -1))
    step, found = thetas[1] - thetas[0], []
    for i in np.flatnonzero(lowest) if closed else np.flatnonzero(lowest[1:-1]) + 1:
        theta, value = minimum(smallest, thetas[i] - step, thetas[i] + step, 1e-9)
        theta = theta % (2 * np.pi) if closed else theta
        _, right = singular_values(loops, coordinates_at(loops, np.array([theta]), branch))
        kind = "change point" if value < CONDITION.singular else "worst transmission"
        found.append(Critical(theta, kind, value, links_moved(loops, right[0, -1])))
    return found
