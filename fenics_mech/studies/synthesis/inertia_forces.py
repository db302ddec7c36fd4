"""What the inertia of links that do not bend does to the frame and to the drive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.scene.sections import Rigidity

PLACES = 12  # Gauss points of a member: exact for densities up to the 21st power of the place


@dataclass(frozen=True)
class LinkInertia:
    """Inertia of a link about the origin of its frame."""

    mass: float  # mass (kg)
    moment: Array  # first moment: mass times centre of mass in the link's frame (kg m), ``(2,)``
    inertia: float  # moment of inertia about the origin (kg m^2)

    def __add__(self, other: LinkInertia) -> LinkInertia:
        """Give the inertia of both together."""
        return LinkInertia(self.mass + other.mass, self.moment + other.moment, self.inertia + other.inertia)

    @classmethod
    def at(cls, mass: float, place: Array, inertia: float = 0.0) -> LinkInertia:
        """Give that of a mass at a place."""
        return cls(mass, mass * place, mass * float(place @ place) + inertia)


@dataclass(frozen=True)
class Shaking:
    """What inertia does, over the cycle."""

    force: Array  # on the frame (N), ``(angles, 2)``
    moment: Array  # on the frame, about the origin of the ground (N m), ``(angles,)``
    torque: Array  # of the first drive (N m; N where it slides), ``(angles,)``

    @property
    def rms(self) -> dict[str, float]:
        """Root mean square of each."""
        squares = {"force": (self.force**2).sum(axis=1), "moment": self.moment**2, "torque": self.torque**2}
        return {name: float(np.sqrt(values.mean())) for name, values in squares.items()}


def link_inertias(scene: Scene) -> dict[str, LinkInertia]:
    """Give the inertia of every link, with its point masses."""
    found = {}
    for name, link in scene.links.items():
        body = link.rigid
        found[name] = (
            LinkInertia(0.0, np.zeros(2), 0.0)
            if body is None
            else LinkInertia.at(body.mass, np.array(body.centre), body.inertia)
        )
    for label, (link_name, _) in scene.members().items():
        found[link_name] += _of_member(scene, label)
    for mass in scene.masses.values():
        body_name, place = scene.point(mass.at)
        if body_name != "ground":
            found[body_name] += LinkInertia.at(mass.mass, np.array(place), mass.inertia)
    return found


def _of_member(scene: Scene, label: str) -> LinkInertia:
    """Give the inertia of a member about the origin of its link."""
    return bar_inertia(lambda s: scene.rigidity(label, s), *(np.array(end) for end in scene.member_ends(label)))


def bar_inertia(rigidity: Callable[[Array], Rigidity], first: Array, second: Array) -> LinkInertia:
    """Give the inertia of a bar about the origin of its link."""
    nodes, weights = np.polynomial.legendre.leggauss(PLACES)
    s, length = (1 + nodes) / 2, float(np.linalg.norm(second - first))
    along = (second - first) / length
    here = rigidity(s)
    mass = here.line_density * weights * length / 2
    offset = np.broadcast_to(here.mass_centre, s.shape)
    places = first + s[:, None] * (second - first) + offset[:, None] * np.array([-along[1], along[0]])
    return LinkInertia(float(mass.sum()), mass @ places, float(mass @ (places**2).sum(axis=1)))


def shaking(motion: Motion, links: Mapping[str, LinkInertia], rate: float) -> Shaking:
    """Give what the inertia of links does to the frame and to the drive."""
    # Sum of minus mass times acceleration, its moment, and the rate of kinetic energy over the rate of the drive
    # (Berkof and Lowen 1969; Lowen, Tepper and Berkof 1983).
    count = len(motion.theta)
    force, moment, power = np.zeros((count, 2)), np.zeros(count), np.zeros(count)
    for name, body in links.items():
        i = motion.links.index(name)
        p, v, a = (array[:, i] for array in (motion.position, motion.velocity, motion.acceleration))
        omega, alpha = motion.omega[:, i], motion.alpha[:, i]
        c, s = np.cos(motion.angle[:, i]), np.sin(motion.angle[:, i])
        x, y = body.moment
        arm = np.stack([c * x - s * y, s * x + c * y], axis=1)
        normal = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        turning = alpha[:, None] * normal - omega[:, None] ** 2 * arm
        change = body.mass * a + turning  # rate of momentum
        force -= change
        moment -= _cross(p, change) + _cross(arm, a) + body.inertia * alpha
        power += body.mass * _dot(a, v) + omega * _dot(a, normal) + _dot(v, turning) + body.inertia * omega * alpha
    return Shaking(force, moment, power / rate)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray((a * b).sum(axis=1))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
