"""Loads at points of the links and along their members, constant or changing with the drive angle."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.attachment import QUARTER, Attachment
from fenics_mech.beams.element_dofs import member_rotation
from fenics_mech.beams.shapes import point_equivalent
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.rotation_forces import RotationForces, of_sines
from fenics_mech.effects.terms import NOTHING, AddedMatrices, Entries, LoadInElement, Loads, Situation, Terms, in_links
from fenics_mech.kinematics.load_factors import factor_in
from fenics_mech.scene.applied_loads import LineLoad, Load
from fenics_mech.scene.bodies import MESH


def terms(situation: Situation) -> Terms:
    """Give the loads in link axes, {Qex} of (4.39)."""
    loads = situation.scene.loads.values()
    found = (_spread(situation, load) if isinstance(load, LineLoad) else _at_point(situation, load) for load in loads)
    return sum(found, NOTHING)


def turned_back(situation: Situation) -> Loads:
    """Give the loads turned by a quarter clockwise: the work that they do on v as a link turns by 1 rad.

    Parameters
    ----------
    situation
        The scene, its beams and its rigid motion.
    """
    found = Loads()
    for load in situation.scene.loads.values():
        if isinstance(load, LineLoad):
            found += _spread(situation, load).loads.turned()
        else:
            x, y = load.force
            found += _at_point(situation, load.model_copy(update={"force": (y, -x), "moment": 0.0})).loads
    return found


def _at_point(situation: Situation, load: Load) -> Terms:
    """Give a load at a point.

    One that follows stays as it is in axes that turn with the point: ``f = F + phi Q F`` with Q a quarter turn. On a
    rigid link its moment about the centre stays the same, as arm and force turn together.
    """
    scene, mesh, factor = (
        situation.scene,
        situation.beams.mesh,
        factor_in(situation.scene, load, situation.motion)[:, None],
    )
    label, _, at = load.at.partition("@")
    if at and not mesh.has_node(f"{label}@{float(at):.12g}"):
        return _inside(situation, load, factor)
    point = Attachment.of(scene.links, scene.joints, mesh, load.at)
    force = np.array(load.force)
    in_link = factor * (force if load.follows else in_links(situation.motion, force)[:, point.link])
    on_point, moment = in_link @ point.shift, factor * load.moment
    forces = np.zeros((len(factor), 3 * len(mesh.node_link)))
    forces[:, point.dofs] = on_point + moment * [0.0, 0.0, 1.0]
    loads, rotation, exact = Loads(force=forces), point.dofs[2:], of_sines(scene.named_effects)
    if not load.follows:
        couple = (RotationForces.of_couples(rotation, moment),) if load.moment and exact else ()
        return Terms(loads=loads, rotation_forces=couple)
    couple = (RotationForces.of_couples(rotation, moment + on_point[:, 2:]),) if exact else ()
    turning = (RotationForces.turning(point.dofs, in_link),) if exact else ()
    stiffness = Entries(point.dofs[:2], np.repeat(rotation, 2), -in_link @ QUARTER.T)
    return Terms(loads=loads, matrices=AddedMatrices(follower=(stiffness,)), rotation_forces=couple + turning)


def _inside(situation: Situation, load: Load, factor: Array) -> Terms:
    """Give a load at a place inside an element, at the element's ends, times a factor ``(angles, 1)``."""
    mesh = situation.beams.mesh
    label, _, at = load.at.partition("@")
    member = mesh.members.index(label)
    cells, along = np.flatnonzero(mesh.cell_member == member), float(at) * mesh.member_length[member]
    element = cells[np.searchsorted(mesh.cell_start[cells], along, side="right") - 1]
    length = mesh.cell_length[element]
    place = (along - mesh.cell_start[element]) / length * (1 - MESH.just_before)
    force, link = np.array(load.force), mesh.member_link[member]
    turn = member_rotation(mesh)[element]
    in_link = factor * in_links(situation.motion, force)[:, link]
    of_member = np.column_stack([in_link @ turn[:2, :2].T, factor[:, 0] * load.moment])
    ends = np.zeros((len(factor), len(mesh.cell), 6))
    ends[:, element] = point_equivalent(np.full(len(factor), place), of_member, length)
    return Terms(loads=Loads(ends=ends, inside=(LoadInElement(int(element), place, of_member),)))


def _spread(situation: Situation, load: LineLoad) -> Terms:
    """Give a load along a member, at the ends of its elements."""
    mesh = situation.beams.mesh
    member = mesh.members.index(load.member)
    here = mesh.cell_member == member
    ends = load.ends
    if load.axes == "fixed":
        ends = in_links(situation.motion, ends, mesh.member_angle[member])[:, mesh.member_link[member]]
    place = (mesh.cell_start[here, None] + mesh.cell_length[here, None] * [0, 1]) / mesh.member_length[member]
    along_and_across = np.stack([1 - place, place], axis=-1) @ ends[..., None, :, :]  # (angles, elements, nodes, 2)
    values = np.broadcast_to(along_and_across, (len(situation.motion.theta), *place.shape, 2))
    line = np.zeros((len(values), len(here), 4))
    by_component = values.swapaxes(-1, -2).reshape(*values.shape[:2], 4)
    line[:, here] = factor_in(situation.scene, load, situation.motion)[:, None, None] * by_component
    return Terms(loads=Loads(line=line))


EFFECT = Effect(
    name="loads",
    meaning="forces and moments at points of the links and along their members",
    source="(4.39); load stiffness: Bolotin, Nonconservative Problems of the Theory of Elastic Stability (1963)",
    work="own",
    terms=terms,
    stated=lambda scene: bool(scene.loads),
    stated_by="[loads]",
)
