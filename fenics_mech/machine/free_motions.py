"""Motions that joints and drives leave to links that do not bend: null vectors of the rows, and words for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.machine.assembly import left_open, units_of
from fenics_mech.machine.drawn_from_scene import Bodies
from fenics_mech.scene import Scene

FREE = 1e-9  # singular value of the rows without units, up to which a motion is free
SEEN = 1e-6  # of the largest motion, above which a link moves
NAMED = 4  # links that a message about one freedom names


def free_motions(bodies: Bodies) -> Array:
    """Give the small motions of links (m, m, rad) that no joint and no drive prevents ``(motions, links, 3)``."""
    machine = bodies.machine
    _, values, right = np.linalg.svd(left_open(machine, 0.0, bodies.q[None])[1][0])
    null = right[int((values > FREE).sum()) :]
    return (row_reduced(null, np.arange(machine.n) % 3 == 2) * units_of(machine)).reshape(len(null), machine.n // 3, 3)


def row_reduced(vectors: Array, preferred: NDArray[np.bool_]) -> Array:
    """Combine vectors, one a row, until each alone has one coordinate, by Gauss and Jordan; preferred ones go first."""
    left = vectors.copy()
    for k in range(len(left)):
        size = np.abs(left[k:])
        first = np.where(preferred, size, 0.0)
        row, column = np.unravel_index(int((first if first.max() > SEEN else size).argmax()), size.shape)
        left[np.array([k, k + row])] = left[np.array([k + row, k])]
        left[k] /= left[k, column]
        others = np.arange(len(left)) != k
        left[others] -= np.outer(left[others, column], left[k])
    return left


def nothing_holds(moves: Sequence[str]) -> SceneError:
    """Give the error of a mechanism at rest that loads move."""
    return SceneError(
        f"nothing holds the mechanism against its loads: {'; '.join(moves)}",
        place="analysis.method",
        hint="State its [freedoms] for an equilibrium that is searched, add a drive, a spring or a support, or "
        "write method = 'quasi-static' for links that give way to the loads and carry their own inertia",
    )


def describe(scene: Scene, q: Array, motions: Array) -> list[str]:
    """Say of each motion which link it moves most, about or along which joint, and which links go with it.

    Links are at ``q`` ``(3 links,)``, and motions are ``(motions, links, 3)``.
    """
    return [_described(scene, q.reshape(-1, 3), motion) for motion in motions]


def _described(scene: Scene, poses: Array, motion: Array) -> str:
    links = list(scene.links)
    coordinates = [abs(value) for link in scene.links.values() for point in link.points.values() for value in point]
    size = max([*coordinates, float(np.finfo(float).tiny)])
    turns = np.abs(motion[:, 2])
    moves = np.maximum(np.linalg.norm(motion[:, :2], axis=1) / size, turns)
    leads = turns if turns.max() > SEEN * moves.max() else moves
    first = int(leads.argmax())
    held = {name: dict(point.split(".") for point in joint.connect) for name, joint in scene.joints.items()}
    held = {name: points for name, points in held.items() if links[first] in points}
    if leads is turns:
        text, still = f"link {links[first]} can turn freely", []
        c, s = np.cos(poses[first, 2]), np.sin(poses[first, 2])
        for name, points in held.items():
            x, y = scene.links[links[first]].points[points[links[first]]]
            shift = motion[first, :2] + motion[first, 2] * np.array([-(s * x + c * y), c * x - s * y])
            still += [name] if np.linalg.norm(shift) < SEEN * size * turns[first] else []
        text += f" about joint {still[0]}" if still else ""
    else:
        sliding = [name for name in held if scene.joints[name].kind in ("slot", "prismatic")]
        angle = np.degrees(np.arctan2(motion[first, 1], motion[first, 0])) % 180
        text = f"link {links[first]} can move freely along {angle:.4g} deg"
        text += f", in joint {sliding[0]}" if sliding else ""
    least = SEEN * moves.max()
    others = [links[i] for i in np.argsort(-moves, kind="stable") if i != first and moves[i] > least]
    more = f" and {len(others) - NAMED} more" if len(others) > NAMED else ""
    return text + (f" and moves {', '.join(others[:NAMED])}{more} with it" if others else "")
