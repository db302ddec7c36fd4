"""Centrifugal forces of a machine whose ground turns about the origin: m speed^2 r on every mass at r."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.effects.effect import Effect
from fenics_mech.geometry import End
from fenics_mech.terms import AlongBeams, Look, Measure, Response, Spread, Term

if TYPE_CHECKING:
    from fenics_mech.machine.from_scene import SceneMachine


@dataclass(frozen=True)
class OnMembers:
    """Force per length on members, by the place of each section.

    Parameters
    ----------
    factor
        Mass per length times speed^2 at both ends of each element ``(elements, 2)`` (N/m^2).
    """

    factor: Array
    points: int = 4  # of Gauss's rule: a line mass, a place and a shape have degree 7 at most

    def at(self, t: Array, element: Index, x: Array, place: Array, tangent: Array, velocity: Array) -> Spread:
        """Give it (N/m), and its derivative by the place."""
        factor = (1 - x) * self.factor[element, 0] + x * self.factor[element, 1]
        by_place = np.broadcast_to(factor[:, None, None] * np.eye(2), (*place.shape, 2))
        return Spread(factor[:, None] * place, by_place=by_place)


class OnMasses(Term):
    """Forces on the centres of rigid links and on point masses.

    Parameters
    ----------
    ground
        An end that rests at the origin.
    ends
        The centres.
    factor
        Mass of each times speed^2 ``(masses,)`` (N/m).
    """

    measures = (Measure(Look.PLACE, 0), Measure(Look.PLACE, 1))

    def __init__(self, ground: End, ends: list[End], factor: Array) -> None:
        super().__init__([(ground, end) for end in ends])
        self.factor = factor[:, None]

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give minus the forces, and their derivatives by the places."""
        by = np.broadcast_to(-self.factor[:, :, None] * np.eye(2), (*x.shape, 2))
        return Response(-self.factor * x, np.ascontiguousarray(by))


def acting(made: SceneMachine) -> Mapping[str, Term]:
    """Give the forces on members, and on rigid links and point masses."""
    scene, machine = made.scene, made.machine
    square, found = scene.plugins["turntable"].speed ** 2, dict[str, Term]()
    if made.links is not None:
        mesh = made.links.mesh
        share = np.stack([mesh.cell_start, mesh.cell_start + mesh.cell_length], axis=1)
        share /= mesh.member_length[mesh.cell_member, None]
        mass = [scene.rigidity(mesh.members[m], s).line_density for m, s in zip(mesh.cell_member, share)]
        density = OnMembers(square * np.array(mass))
        found["members"] = AlongBeams(machine.at_ground(), machine.beams, np.arange(len(mass)), density)
    rigid = {f"{name}.{next(iter(link.points))}": link.rigid for name, link in scene.links.items() if link.rigid}
    centres = [(End(made.end(point).pose, np.zeros(2), np.eye(2)), body.mass) for point, body in rigid.items()]
    centres += [(made.end(mass.at), mass.mass) for mass in scene.masses.values()]
    if centres:
        ends, masses = zip(*centres)
        found["masses"] = OnMasses(machine.at_ground(), list(ends), square * np.array(masses))
    return found


EFFECT = Effect(
    name="turntable",
    meaning="centrifugal force of a ground that turns about the origin",
    source="Goldstein, Classical Mechanics, chapter 4",
    acting=acting,
    stated=lambda scene: "turntable" in scene.plugins,
    stated_by="[plugins.turntable]",
)
