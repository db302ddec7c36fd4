"""A guide that bends: the axis of a member, as the cubic curve through frames at its nodes.

The pin is seen from the point of the curve next to it. What acts there is put on the two frames beside that point so
that it does the same work.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.joints.joint_state import JointPlace, JointState, Wrench
from fenics_mech.joints.link_states import BodyForces, LinkStates, cross, quarter
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh

ITERATIONS = 12  # of Newton's method for the point of the axis next to the pin
LEAST_SLOPE = 0.1  # in it: a pin farther from the axis than its radius of curvature has no one such point

Shapes = tuple[Array, Array, Array]  # of the four vectors of an element and two derivatives, ``(states, 4)`` each


@dataclass(frozen=True)
class BentGuide(JointPlace):
    """Place of a joint whose guide is the axis of a member; its stroke is the distance along it from the first node."""

    nodes: tuple[int, ...] = ()  # the frames at the member's nodes, from end to end of the guide
    distances: tuple[float, ...] = ()  # their distances from the first along the straight member (m), (nodes,)

    @property
    def ends(self) -> tuple[float, float]:
        """Strokes at both ends of the guide (m)."""
        return self.distances[0], self.distances[-1]

    def state(self, links: LinkStates) -> JointState:
        """Give how the pin moves against the axis."""
        second = self.bodies[1]
        arm = links.turned(second, self.points[1])
        pin, pin_rate = links.point(second, arm)
        place = self._nearest(links, pin)
        shapes = self._shapes(place)
        vectors, rates = self._vectors(links, place), self._vector_rates(links, place)
        (at, slope), (moved, turned) = (
            tuple(np.einsum("si,sij->sj", shape, part) for shape in shapes[:2]) for part in (vectors, rates)
        )
        size = np.linalg.norm(slope, axis=-1, keepdims=True)
        along = slope / size
        spin = np.sum(quarter(along) * turned, axis=-1) / size[:, 0]
        gap, gap_rate = pin - at, pin_rate - moved
        rate = np.sum(along * (gap_rate - spin[:, None] * quarter(gap)), axis=-1)
        turning = spin, links.rate[:, second, 2]
        angle = links.pose[:, second, 2] - np.arctan2(along[:, 1], along[:, 0])
        return JointState(place, rate, gap, gap_rate, (np.zeros_like(arm), arm), turning, along, angle, links)

    def exert(self, on: BodyForces, state: JointState, wrench: Wrench) -> None:
        """Add a wrench on the pin's body, and the opposite one on the frames beside the point of the axis."""
        second = self.bodies[1]
        on.add(second, state.arms[1] + wrench.offset, wrench.force)
        on.turn(second, wrench.moment)
        value, slope, _ = self._shapes(state.place)
        vectors = self._vectors(state.links, state.place)
        size = np.linalg.norm(np.einsum("si,sij->sj", slope, vectors), axis=-1)
        moment = (wrench.moment + cross(state.gap + wrench.offset, wrench.force)) / size
        on_vectors = -value[..., None] * wrench.force[:, None]
        on_vectors -= slope[..., None] * (moment[:, None] * quarter(state.along))[:, None]
        states, first = np.arange(len(moment)), self._element(state.place)
        for k in (0, 1):
            frame = np.array(self.nodes)[first + k]
            on.values[states, frame, :2] += on_vectors[:, 2 * k]
            on.values[states, frame, 2] += cross(vectors[:, 2 * k + 1], on_vectors[:, 2 * k + 1])

    def _nearest(self, links: LinkStates, pin: Array) -> Array:
        """Stroke at which the axis is nearest to the pin (m), ``(states,)``; beyond its ends the axis is straight."""
        ends = links.pose[:, self.nodes[0], :2], links.pose[:, self.nodes[-1], :2]
        chord = ends[1] - ends[0]
        place = self.ends[1] * np.sum((pin - ends[0]) * chord, axis=-1) / np.sum(chord * chord, axis=-1)
        for _ in range(ITERATIONS):
            vectors = self._vectors(links, place)
            at, slope, bend = (np.einsum("si,sij->sj", shape, vectors) for shape in self._shapes(place))
            square = np.sum(slope * slope, axis=-1)
            steep = np.maximum(square - np.sum((pin - at) * bend, axis=-1), LEAST_SLOPE * square)
            place = place + np.sum((pin - at) * slope, axis=-1) / steep
        return np.asarray(place)

    def _element(self, place: Array) -> Index:
        """Number of the element of the guide at distances, ``(states,)``."""
        found = np.searchsorted(self.distances, place, side="right") - 1
        return np.clip(found, 0, len(self.distances) - 2)

    def _vectors(self, links: LinkStates, place: Array) -> Array:
        """First end of the element there and its tangent, as long as it; then the second end, ``(states, 4, 2)``."""
        pose, length = self._beside(links.pose, place)
        tangents = np.stack([np.cos(pose[..., 2] + self.guide), np.sin(pose[..., 2] + self.guide)], axis=-1)
        found = np.stack([pose[..., :2], length * tangents], axis=2)
        return found.reshape(len(place), 4, 2)

    def _vector_rates(self, links: LinkStates, place: Array) -> Array:
        """Rates of `_vectors`."""
        (rate, _), vectors = self._beside(links.rate, place), self._vectors(links, place)
        turned = rate[..., 2:] * quarter(vectors[:, 1::2])
        return np.stack([rate[..., :2], turned], axis=2).reshape(len(place), 4, 2)

    def _beside(self, values: Array, place: Array) -> tuple[Array, Array]:
        """Values of the frames beside places, ``(states, 2, 3)``, and lengths of the elements, ``(states, 1, 1)``."""
        first = self._element(place)
        frames = np.array(self.nodes)[np.stack([first, first + 1], axis=1)]
        lengths = np.diff(self.distances)[first]
        return values[np.arange(len(place))[:, None], frames], lengths[:, None, None]

    def _shapes(self, place: Array) -> Shapes:
        """Hermite's polynomials of `_vectors`, and two derivatives by the distance along the axis."""
        first = self._element(place)
        length = np.diff(self.distances)[first]
        share = (place - np.array(self.distances)[first]) / length
        x = np.clip(share, 0.0, 1.0)
        beyond = (share - x)[:, None]
        value = np.stack([1 - 3 * x**2 + 2 * x**3, x - 2 * x**2 + x**3, 3 * x**2 - 2 * x**3, x**3 - x**2], axis=1)
        slope = np.stack([6 * (x**2 - x), 1 - 4 * x + 3 * x**2, 6 * (x - x**2), 3 * x**2 - 2 * x], axis=1)
        bend = np.stack([12 * x - 6, 6 * x - 4, 6 - 12 * x, 6 * x - 2], axis=1) * (beyond == 0)
        return value + beyond * slope, slope / length[:, None], bend / length[:, None] ** 2


def nodes_along(scene: Scene, mesh: BeamMesh, joint: str) -> list[str]:
    """Names of the nodes of the member that a joint's pin travels along, from end to end; none where it has no such."""
    member = scene.joints[joint].member
    if member is None:
        return []
    link = scene.joints[joint].connect[0].split(".")[0]
    label = link if link in mesh.members else f"{link}.{member}"
    cells = mesh.cell_nodes[mesh.cell_member == mesh.members.index(label)]
    return [mesh.node_name[node] for node in [*cells[:, 0], cells[-1, 1]]]
