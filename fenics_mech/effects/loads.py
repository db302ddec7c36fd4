"""Loads at points of the links and along their members, constant or changing with the drive angle."""

from __future__ import annotations

import numpy as np

from fenics_mech.beams.attachment import QUARTER, Attachment
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Array, Entries, Situation, Terms, in_links, total
from fenics_mech.scene.loads import LineLoad, Load


def terms(situation: Situation) -> Terms:
    """Give the loads in link axes, {Qex} of (4.39)."""
    loads = situation.scene.loads.values()
    return total(
        [_spread(situation, load) if isinstance(load, LineLoad) else _at_point(situation, load) for load in loads]
    )


def _at_point(situation: Situation, load: Load) -> Terms:
    """Give a load at a point.

    One that follows stays as it is in axes that turn with the point: ``f = F + phi Q F`` with Q a quarter turn. On a
    rigid link its moment about the centre stays the same, as arm and force turn together.
    """
    point = Attachment.of(situation.scene, situation.beams.mesh, load.at)
    factor = load.factor_at(situation.motion.theta)[:, None]
    force = np.array(load.force)
    in_link = factor * (force if load.follows else in_links(situation.motion, force)[:, point.link])
    forces = np.zeros((len(factor), 3 * len(situation.beams.mesh.node_link)))
    forces[:, point.dofs] = in_link @ point.shift + factor * [0.0, 0.0, load.moment]
    if not load.follows:
        return Terms(force=forces)
    stiffness = Entries(point.dofs[:2], np.repeat(point.dofs[2:], 2), -in_link @ QUARTER.T)
    return Terms(force=forces, follower=(stiffness,))


def _spread(situation: Situation, load: LineLoad) -> Terms:
    """Give a load along a member, at the ends of its elements."""
    mesh = situation.beams.mesh
    member = mesh.members.index(load.member)
    here = mesh.cell_member == member
    ends = np.array([load.line, load.line if load.line_end is None else load.line_end])
    if load.axes == "fixed":
        ends = in_links(situation.motion, ends, mesh.member_angle[member])[:, mesh.member_link[member]]
    place = (mesh.cell_start[here, None] + mesh.cell_length[here, None] * [0, 1]) / mesh.member_length[member]
    along_and_across = np.stack([1 - place, place], axis=-1) @ ends[..., None, :, :]  # (angles, elements, nodes, 2)
    values = np.broadcast_to(along_and_across, (len(situation.motion.theta), *place.shape, 2))
    line = np.zeros((len(values), len(here), 4))
    line[:, here] = load.factor_at(situation.motion.theta)[:, None, None] * _by_component(values)
    return Terms(line=line)


def _by_component(values: Array) -> Array:
    """Order ``(angles, elements, nodes, components)`` by component, ``(angles, elements, 4)``."""
    return values.swapaxes(-1, -2).reshape(*values.shape[:2], 4)


EFFECT = Effect(
    name="loads",
    meaning="forces and moments at points of the links and along their members",
    source="(4.39); load stiffness: Bolotin, Nonconservative Problems of the Theory of Elastic Stability (1963)",
    terms=terms,
    stated=lambda scene: bool(scene.loads),
    stated_by="[loads]",
)
