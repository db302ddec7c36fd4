"""Motions that joints and drives leave to a linkage: null vectors of the loop Jacobian, and words for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.kinematics.conditioning import CONDITION
from fenics_mech.kinematics.loops import Loops
from fenics_mech.scene import Link
from fenics_mech.scene.joints import Joint


def free_motions(loops: Loops, q: Array) -> Array:
    """Small motions of the links at one position that no joint and no drive prevents."""
    # q (3 links,)
    _, values, right = np.linalg.svd(loops.without_units(q[None])[0])
    null = right[int((values > CONDITION.free).sum()) :]
    return (row_reduced(null, np.arange(len(q)) % 3 == 2) * loops.unit).reshape(len(null), len(loops.links), 3)


def row_reduced(vectors: Array, preferred: NDArray[np.bool_]) -> Array:
    """Combine vectors, one a row, until each alone has one coordinate, by Gauss and Jordan; preferred ones go first."""
    # vectors (vectors, coordinates); preferred (coordinates,)
    left = vectors.copy()
    for k in range(len(left)):
        size = np.abs(left[k:])
        first = np.where(preferred, size, 0.0)
        row, column = np.unravel_index(int((first if first.max() > CONDITION.seen else size).argmax()), size.shape)
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


def describe(links: Mapping[str, Link], joints: Mapping[str, Joint], q: Array, motions: Array) -> list[str]:
    """Say of each motion which link it moves most, about or along which joint, and which links go with it."""
    # q (3 links,); motions (motions, links, 3)
    return [_described(links, joints, q.reshape(-1, 3), motion) for motion in motions]


def _described(bodies: Mapping[str, Link], joints: Mapping[str, Joint], poses: Array, motion: Array) -> str:
    links, size = list(bodies), _size(bodies)
    moves = np.maximum(np.linalg.norm(motion[:, :2], axis=1) / size, np.abs(motion[:, 2]))
    turns = np.abs(motion[:, 2])
    leads = turns if turns.max() > CONDITION.seen * moves.max() else moves
    first = int(leads.argmax())
    held = {name: dict(map(_body_and_point, joint.connect)) for name, joint in joints.items()}
    held = {name: points for name, points in held.items() if links[first] in points}
    if leads is turns:
        places = {name: bodies[links[first]].points[points[links[first]]] for name, points in held.items()}
        speeds = {name: _speed(poses[first, 2], motion[first], place) for name, place in places.items()}
        still = [name for name, speed in speeds.items() if speed < CONDITION.seen * size * turns[first]]
        text = f"link {links[first]} can turn freely" + (f" about joint {still[0]}" if still else "")
    else:
        sliding = [name for name in held if joints[name].kind in ("slot", "prismatic")]
        angle = np.degrees(np.arctan2(motion[first, 1], motion[first, 0])) % 180
        text = f"link {links[first]} can move freely along {angle:.4g} deg"
        text += f", in joint {sliding[0]}" if sliding else ""
    least, most = CONDITION.seen * moves.max(), CONDITION.most_named
    others = [links[i] for i in np.argsort(-moves, kind="stable") if i != first and moves[i] > least]
    more = f" and {len(others) - most} more" if len(others) > most else ""
    return text + (f" and moves {', '.join(others[:most])}{more} with it" if others else "")


def _body_and_point(name: str) -> tuple[str, str]:
    body, point = name.split(".")
    return body, point


def _speed(angle: float, motion: Array, place: tuple[float, float]) -> float:
    """How far a small motion ``(3,)`` shifts a place of a link (m), given in the frame of the link."""
    (x, y), c, s = place, np.cos(angle), np.sin(angle)
    arm = np.array([-(s * x + c * y), c * x - s * y])
    return float(np.linalg.norm(motion[:2] + motion[2] * arm))


def _size(links: Mapping[str, Link]) -> float:
    """Largest coordinate of a link's point in its frame (m)."""
    points = [abs(value) for link in links.values() for point in link.points.values() for value in point]
    return max([*points, float(np.finfo(float).tiny)])
