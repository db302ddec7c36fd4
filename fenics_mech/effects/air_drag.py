"""Drag of the air on members, by the square of their absolute velocity across their axis.

Per length of a member acts ``F = -k |V| V`` along the normal of its bent axis, with ``k = rho C_D b/2`` and the
velocity V of the axis along that normal. About the rigid motion V_0, in link axes that turn at omega,

    V = V_0 + w' + omega u - V_t w_x,    F = -k |V_0| V_0 - 2 k |V_0| (V - V_0),

with the rigid velocity V_t along the axis. What is left out is of the size ``k (V - V_0)^2``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, times
from fenics_mech.beams.element_dofs import element_dofs, in_member_axes, member_rotation
from fenics_mech.beams.offset_pins import refuse_offsets
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import AddedMatrices, Entries, Loads, Situation, Terms
from fenics_mech.errors import SceneError
from fenics_mech.kinematics import Motion

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams

OF_WORK = np.array([[4.0, -2.0], [-2.0, 4.0]])  # a linear load on a unit length, from its work on `LINEAR`
POWERS = 7  # powers of xi in the product of two cubics
DRAG_POINTS, DRAG_WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact for |V| times it: |V| is linear in parts


def _coefficients(functions: tuple[np.polynomial.Polynomial, ...], dofs: list[int]) -> Array:
    """Coefficients of functions of xi that go with an element's dofs, ``(6, 4)``; those of the other dofs are 0."""
    found = np.zeros((6, 4))
    for dof, function in zip(dofs, functions):
        found[dof, : len(function.coef)] = function.coef
    return found


ALONG, ACROSS = _coefficients(LINEAR, AXIAL), _coefficients(CUBIC, NORMAL)
SLOPE = _coefficients(tuple(f.deriv() for f in CUBIC), NORMAL)


def _products(first: Array, second: Array) -> Array:
    """Coefficients of the products of functions, ``(6, 6, powers)``."""
    found = np.zeros((6, 6, POWERS))
    for power in range(4):
        found[..., power : power + 4] += first[:, None, power, None] * second[None]
    return found


class SpreadDamping(Entries):
    """A matrix of forces that are spread along elements."""


@dataclass(frozen=True)
class AirFlow:
    """Air along the elements of a mechanism in its rigid motion.

    Parameters
    ----------
    beams
        The links.
    drag
        ``rho C_D b/2`` of each element (kg/m^2), ``(elements,)``.
    speed
        Rigid velocity across the axis at both nodes of each element (m/s), ``(angles, elements, 2)``.
    along, omega
        Rigid velocity along the axis (m/s), and rate of the link (rad/s), ``(angles, elements)``.
    """

    beams: Beams
    drag: Array
    speed: Array
    along: Array
    omega: Array

    @classmethod
    def of(cls, situation: Situation) -> AirFlow:
        """Give the flow of a scene that states air.

        Parameters
        ----------
        situation
            The scene, its beams and its rigid motion.
        """
        scene, mesh = situation.scene, situation.beams.mesh
        air = scene.damping.air
        assert air is not None
        width = np.array([air.width_of(scene, label) for label in mesh.members])
        drag = air.density * air.coefficient * width[mesh.cell_member] / 2
        across, along, omega = _rigid(situation.beams, situation.motion)
        return cls(situation.beams, drag, across, along, omega)

    @cached_property
    def points(self) -> tuple[Array, Array]:
        """Places xi and weights (m) of an integral along each element, cut where the air changes its side.

        Both are ``(angles, elements, places)``.
        """
        first, second = self.speed[..., 0], self.speed[..., 1]
        turns = first * second < 0
        cut = np.where(turns, first / np.where(turns, first - second, 1.0), 1.0)[..., None]
        xi = np.concatenate([cut * (1 + DRAG_POINTS) / 2, cut + (1 - cut) * (1 + DRAG_POINTS) / 2], axis=-1)
        weights = np.concatenate([cut * DRAG_WEIGHTS / 2, (1 - cut) * DRAG_WEIGHTS / 2], axis=-1)
        return xi, weights * self.beams.mesh.cell_length[:, None]

    @cached_property
    def across(self) -> Array:
        """Rigid velocity across the axis at the places, ``(angles, elements, places)``."""
        xi, first, second = self.points[0], self.speed[..., :1], self.speed[..., 1:]
        return np.asarray(first + (second - first) * xi)

    @cached_property
    def _moments(self) -> tuple[Array, Array]:
        """Integrals of ``2 k |V|`` and of ``k |V| V`` times powers of xi, ``(angles, elements, powers)``."""
        xi, weights = self.points
        powers = xi[..., None] ** np.arange(POWERS)
        by_place = 2 * self.drag[:, None] * np.abs(self.across) * weights
        linear = np.einsum("tep,tepj->tej", by_place, powers)
        return linear, np.einsum("tep,tepj->tej", by_place * self.across / 2, powers)

    @property
    def _units(self) -> Array:
        """Elements' dofs by those of unit elements, ``(elements, 6)``: rotations times the length."""
        one, h = np.ones_like(self.beams.mesh.cell_length), self.beams.mesh.cell_length
        return np.stack([one, one, h] * 2, axis=-1)

    def linearised(self, turned: bool = False) -> tuple[Array, Array, Array]:
        """Linearise the drag about the rigid motion; or the same forces turned by a quarter clockwise.

        Parameters
        ----------
        turned
            Whether the forces are turned, which gives their work as a link turns by 1 rad.

        Returns
        -------
        tuple
            Forces on the elements' ends in member axes: that of the rigid motion ``(angles, elements, 6)``, and how it
            changes with v' and, where the elastic motion is coupled, with v, ``(angles, elements, 6, 6)`` each.
        """
        normal, tangent = (ALONG, -ACROSS) if turned else (ACROSS, ALONG)
        linear, whole = self._moments
        h = self.beams.mesh.cell_length[:, None, None]
        by_rate = -np.einsum("ijp,tep->teij", _products(normal, ACROSS), linear)
        by_u = -np.einsum("ijp,tep->teij", _products(normal, ALONG), linear)
        by_slope = np.einsum("ijp,tep->teij", _products(normal, SLOPE), linear) * self.along[..., None, None]
        by_slope += np.einsum("ijp,tep->teij", _products(tangent, SLOPE), whole)  # the force turns with the axis
        constant = -np.einsum("ip,tep->tei", normal, whole[..., :4])
        by_v = self.omega[..., None, None] * by_u + by_slope / h
        return self._tied(constant), self._tied(by_rate), self._tied(by_v)

    def _tied(self, forces: Array) -> Array:
        """Carry forces or matrices over Hermite's functions of the unit element to the elements' nodal dofs."""
        tie = self._units[..., None] * self.beams.layout.tie
        if forces.ndim == 3:
            return np.einsum("eji,tej->tei", tie, forces)
        return np.asarray(tie.transpose(0, 2, 1) @ forces @ tie)

    def loads(self, v: Array, rate: Array) -> tuple[Loads, Loads]:
        """Give the drag in a motion as a load along the elements, and the same turned by a quarter clockwise.

        Parameters
        ----------
        v, rate
            Elastic displacement in link axes, 0 where it is not coupled, and its velocity, ``(angles, nodal dofs)``.
        """
        nodal, rates = (in_member_axes(self.beams.mesh, vectors) for vectors in (v, rate))
        ends, turned = (
            constant + times(by_rate, rates) + times(by_v, nodal)
            for constant, by_rate, by_v in (self.linearised(), self.linearised(turned=True))
        )
        h = self.beams.mesh.cell_length[:, None]
        along, across = (forces[..., AXIAL] @ OF_WORK / h for forces in (ends, turned))
        return self._linear(ends, along, across), self._linear(turned, across, -along)

    def _linear(self, ends: Array, along: Array, across: Array) -> Loads:
        """Give a load by its forces on the elements' ends, and by the linear one of the same work along them."""
        line = np.concatenate([along, across], axis=-1)
        return Loads(line=line, ends=ends - self.beams.layout.work_equivalent(line))

    def left_out(self, v: Array, rate: Array) -> tuple[Array, Array]:
        """Give the part of the drag in a motion that the linearised drag leaves out.

        Parameters
        ----------
        v, rate
            Elastic displacement in link axes, and its velocity, ``(angles, nodal dofs)``.

        Returns
        -------
        tuple
            Forces on the elements' ends in member axes, ``(angles, elements, 6)``, and the bound
            ``int k (V - V_0)^2 dx`` of their sum (N), ``(angles, elements)``.
        """
        h, (xi, weights) = self.beams.mesh.cell_length[:, None], self.points
        nodal, rates = (self.beams.layout.hermite_dofs(vectors) * self._units for vectors in (v, rate))
        slope = nodal @ SLOPE / h
        shape = rates @ ACROSS + self.omega[..., None] * (nodal @ ALONG) - self.along[..., None] * slope
        powers = xi[..., None] ** np.arange(4)
        more = np.sum(shape[..., None, :] * powers, axis=-1)
        whole, k = self.across + more, self.drag[:, None]
        missing = -k * (np.abs(whole) * whole - np.abs(self.across) * (self.across + 2 * more))
        moments = np.einsum("tep,tepj->tej", missing * weights, powers)
        return self._tied(moments @ ACROSS.T), np.sum(k * more**2 * weights, axis=-1)

    def largest(self) -> float:
        """Largest drag of a member in the rigid motion, ``int k V^2 dx`` (N)."""
        by_element = np.sum(self.drag[:, None] * self.across**2 * self.points[1], axis=-1)
        return float(self.by_member(by_element).max())

    def by_member(self, by_element: Array) -> Array:
        """Sum ``(angles, elements)`` over the elements of each member, ``(angles, members)``.

        Parameters
        ----------
        by_element
            Values of the elements.
        """
        mesh = self.beams.mesh
        return by_element @ (mesh.cell_member[:, None] == np.arange(len(mesh.members)))


def _rigid(beams: Beams, motion: Motion) -> tuple[Array, Array, Array]:
    """Rigid velocity across the elements at both nodes, along them, and their rate; see `AirFlow`."""
    mesh = beams.mesh
    link = mesh.member_link[mesh.cell_member]
    angle = motion.angle[:, link] + mesh.member_angle[mesh.cell_member]
    c, s, omega = np.cos(angle), np.sin(angle), motion.omega[:, link]
    origin = motion.velocity[:, link]
    turn, (x, y) = mesh.member_angle[mesh.cell_member, None], mesh.node_xy[mesh.cell_nodes].transpose(2, 0, 1)
    abscissa, ordinate = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
    across = (c * origin[..., 1] - s * origin[..., 0])[..., None] + omega[..., None] * abscissa
    along = c * origin[..., 0] + s * origin[..., 1] - omega * ordinate[:, 0]
    return across, along, omega


def terms(situation: Situation) -> Terms:
    """Give the drag of the rigid motion as a load, and the damping by how it changes with the elastic motion.

    Raises
    ------
    SceneError
        When a section has offsets, or a drive has a motor.
    """
    scene, mesh = situation.scene, situation.beams.mesh
    refuse_offsets(scene.rigidity, scene.members(), EFFECT.name)
    if any(drive.motor is not None for drive in scene.drives):
        raise SceneError(
            "air drag is not available with a motor, whose rate it would change",
            place="damping.air",
            hint="Leave it out, or the drive's motor; damping.external acts with both",
        )
    flow = AirFlow.of(situation)
    _, *tangents = flow.linearised()
    still = np.zeros((len(flow.speed), 3 * len(mesh.node_link)))
    rotation, dofs = member_rotation(mesh), element_dofs(mesh)
    by_rate, by_v = (
        SpreadDamping.of_blocks(dofs, -(rotation.transpose(0, 2, 1) @ blocks @ rotation)) for blocks in tangents
    )
    return Terms(loads=flow.loads(still, still)[0], matrices=AddedMatrices(damping=(by_rate,), convective=(by_v,)))


EFFECT = Effect(
    name="air-drag",
    meaning="drag of the air by the square of the members' velocity, linearised about the rigid motion",
    source="Morison, O'Brien, Johnson and Schaaf, Petroleum Transactions AIME 189 (1950) 149, without the inertia",
    work="own",
    terms=terms,
    stated=lambda scene: scene.damping.air is not None,
    stated_by="[damping.air]",
)
