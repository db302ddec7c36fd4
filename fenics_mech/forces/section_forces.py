"""Section forces and deflection along the members, from equilibrium.

The curvature of a Hermite element is a poor one (4 % off at mid-span with 3 elements). The forces at an element's ends
are as good as the displacements, so the section forces follow from them and from the distributed inertia by statics.
This is the same as adding the clamped-clamped particular solution to the Hermite displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.polynomial import Polynomial

from fenics_mech._arrays import Array, Index, at_places
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.shapes import (
    CUBIC,
    LINEAR,
    NORMAL,
    between_clamped_ends,
    between_fixed_ends,
    integral,
)
from fenics_mech.beams.variable_sections import between_ends, shape_corrections
from fenics_mech.effects.given_axial_forces import AxialForces
from fenics_mech.forces.bent_axes import by_shape_functions, of_bent_axis, refuse_turned, stretch_of
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import balanced, element_tension, uneven_tension
from fenics_mech.forces.element_loads import PointLoad, SpreadLoad
from fenics_mech.forces.inertia import (
    SHAPES,
    by_mass_beside_axis,
    by_rotary_inertia,
    inertia_of,
    scaled,
    shear_number,
)
from fenics_mech.forces.statics import mass_up_to, spread_and_point_loads, statics
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class MemberState:
    """State of all members at the stations `s` (0..1), arrays of shape ``(angles, members, stations)``.

    Parameters
    ----------
    s
        Stations along every member, 0..1.
    axial_force, shear_force, moment
        N (N, tension positive), V = dM/ds (N) less the inertia of the sections' rotation, and M = EI phi' (N m). phi is
        the rotation of the sections, w' where they stay normal to the axis.
    deflection
        Elastic displacement of the members' axes in the fixed frame (m), ``(angles, members, stations, 2)``.
    rotation
        Rotation of the axis, its slope w' (rad).
    """

    s: Array
    axial_force: Array
    shear_force: Array
    moment: Array
    deflection: Array
    rotation: Array

    def with_forces(self, axial: Array, shear: Array, moment: Array) -> MemberState:
        """Give this state with N, V and M of `section_forces` added, ``(angles, members x stations)`` each."""
        axial, shear, moment = (force.reshape(self.moment.shape) for force in (axial, shear, moment))
        return replace(
            self,
            axial_force=self.axial_force + axial,
            shear_force=self.shear_force + shear,
            moment=self.moment + moment,
        )


def recover_members(
    system: System, response: ElasticResponse, s: Array, loads: Sequence[PointLoad] = ()
) -> MemberState:
    """Recover the members' state at stations `s`, the same on all members.

    Parameters
    ----------
    system
        The mechanism at the angles of the response.
    response
        Displacement and the inertia that balances it.
    s
        Places along the members, 0..1, shape ``(stations,)``.
    loads
        Point loads on the members, beside those at their ends.
    """
    beams = system.beams
    element, xi = _locate(beams, s)
    ends, v = balanced(system, response)
    axial, shear, moment = statics(system, response, ends, loads, element, xi)
    stretch = stretch_of(system, response)
    nodal = beams.layout.hermite_dofs(v, stretch)
    u, w, slope = by_shape_functions(nodal, beams.mesh.cell_length * stretch, element, xi)
    extra_u, extra_w = between_nodes(system, response, element, xi, loads, v)
    u, w, tension = u + extra_u, w + extra_w, element_tension(system, response)
    if tension is not None:
        w += bent_by_tension(system, response, AxialForces(tension, uneven_tension(system, response)), element, xi)
    u, rotation = u + _from_neutral_line(beams, v, nodal, slope, element), slope
    if tension is not None:  # the axial force acts on the bent axis
        arms, shorter = of_bent_axis(system, response, ends, loads, element, xi)
        moment = moment + (stretch[:, element] - 1) * (moment + ends[:, element, 2])  # forces across have longer arms
        moment, u = moment + tension[:, element] * (w - nodal[:, element, 1]) + arms, u + shorter
    if tension is not None and system.terms.law is not None:
        refuse_turned(system, element, slope)
        along = np.sqrt(1 - slope**2)
        axial, shear, rotation = axial * along - shear * slope, shear * along + axial * slope, np.arcsin(slope)
    elif tension is not None:
        shear += tension[:, element] * slope
    shape = (len(moment), len(beams.mesh.members), len(s))
    return MemberState(
        s=s,
        axial_force=axial.reshape(shape),
        shear_force=shear.reshape(shape),
        moment=moment.reshape(shape),
        deflection=_in_fixed_frame(system, u, w, element).reshape(*shape, 2),
        rotation=rotation.reshape(shape),
    )


def deflection_of_nodes(system: System, v: Array, s: Array) -> Array:
    """Displacement of the members in the fixed frame by that of the nodes alone (m).

    Parameters
    ----------
    system
        The mechanism.
    v
        Displacement of every nodal dof in link axes (m, rad), ``(angles, nodal dofs)``.
    s
        Places along the members, 0..1, ``(stations,)``.

    Returns
    -------
    numpy.ndarray
        Of shape ``(angles, members, stations, 2)``.
    """
    beams, (element, xi) = system.beams, _locate(system.beams, s)
    nodal = beams.layout.hermite_dofs(v)
    u, w, slope = by_shape_functions(nodal, beams.mesh.cell_length, element, xi)
    u = u + _from_neutral_line(beams, v, nodal, slope, element)
    return _in_fixed_frame(system, u, w, element).reshape(len(v), -1, len(s), 2)


def _from_neutral_line(beams: Beams, v: Array, nodal: Array, slope: Array, element: Index) -> Array | float:
    """By how much the axis moves farther along the member than the neutral line (m), ``(angles, places)``."""
    if beams.layout.offsets is None:
        return 0.0
    sections = in_member_axes(beams.mesh, v)[:, element, 2] - nodal[:, element, 2]  # turn by less than the slope
    return np.asarray(beams.layout.offsets.neutral[element] * (slope + sections))


def section_forces(
    system: System, response: ElasticResponse, s: Array, loads: Sequence[PointLoad] = ()
) -> tuple[Array, Array, Array]:
    """Give N, V and M on the straight axes at stations `s` of all members, ``(angles, members x stations)`` each.

    Parameters are those of `recover_members`.
    """
    return statics(system, response, balanced(system, response)[0], loads, *_locate(system.beams, s))


def _locate(beams: Beams, s: Array) -> tuple[Index, Array]:
    """Element and place 0..1 in it of each station `s` of each member, both ``(members x stations,)``."""
    mesh = beams.mesh
    elements, places = [], []
    for i, length in enumerate(mesh.member_length):
        cells = np.flatnonzero(mesh.cell_member == i)
        inside = np.clip(np.searchsorted(mesh.cell_start[cells], s * length, side="right") - 1, 0, None)
        elements.append(cells[inside])
        places.append(np.clip((s * length - mesh.cell_start[cells[inside]]) / mesh.cell_length[cells[inside]], 0, 1))
    return np.concatenate(elements), np.concatenate(places)


def between_nodes(
    system: System,
    response: ElasticResponse,
    element: Index,
    xi: Array,
    loads: Sequence[PointLoad] = (),
    v: Array | None = None,
) -> tuple[Array, Array]:
    """Displacements along and across the member that the shape functions leave out, ``(angles, places)`` each (m).

    They are those of an element with fixed, clamped ends under its own inertia and the loads on it. Where its section
    varies, its shape under forces on its ends also differs from the cubic one. Point loads and the inertia of the
    sections' rotation bend it there with its mean stiffness.

    Parameters
    ----------
    system, response, loads
        As of `recover_members`.
    element, xi
        Places 0..1 in elements.
    v
        Displacement from `balanced`, where it is known.
    """
    beams = system.beams
    h, rho_a = beams.mesh.cell_length[element], beams.inertia.density.mean[element]
    along, across = inertia_of(system, response, np.arange(len(beams.mesh.cell)))
    varies = beams.rigidity.varies
    u, w = np.zeros((2, len(along), len(element)))
    if not varies:
        u += rho_a * h**2 * at_places(along, element, between_fixed_ends(SHAPES, xi))
        shapes = between_clamped_ends(SHAPES, xi, shear_number(beams)[element])
        w -= rho_a * h**4 * at_places(across, element, shapes)
    if beams.inertia.rotary is not None:
        w += by_rotary_inertia(system, response, beams.inertia.rotary, element, xi)[1]
    if beams.mass_moment is not None:
        w += by_mass_beside_axis(system, response, beams.mass_moment, element, xi)[1]
    for load in spread_and_point_loads(system, loads):
        if varies and isinstance(load, SpreadLoad):  # by the section's own stiffness below
            w += load.by_arm(element, xi, h)
            continue
        extra_u, extra_w = load.displacement(element, xi, h)
        u, w = u + extra_u, w + extra_w
    u, w = u / beams.rigidity.axial.mean[element], w / beams.rigidity.bending.mean[element]
    if not varies:
        return u, w
    for (of_u, of_w), loaded in _spread_where_varying(system, (along[:, element], across[:, element]), element, xi):
        u, w = u + np.sum(of_u * loaded[0], -1), w + np.sum(of_w * loaded[1], -1)
    nodal = straining_displacement(system, response, balanced(system, response)[1] if v is None else v)[:, element]
    more = [np.einsum("tpi,pi->tp", nodal, shapes) for shapes in shape_corrections(beams, element, xi)]
    return u + more[0], w + more[1]


def _spread_where_varying(
    system: System, inertia: tuple[Array, Array], element: Index, xi: Array
) -> Iterator[tuple[tuple[Array, Array], tuple[Array, Array]]]:
    """Give inertia and spread loads along and across elements whose section varies, with what each function adds.

    The latter are displacements between clamped ends, see `between_ends`.
    """
    beams = system.beams
    yield between_ends(beams, element, xi, partial(mass_up_to, beams)), (-inertia[0], -inertia[1])
    if (line := system.terms.loads.line) is not None:
        found = between_ends(beams, element, xi, lambda _, x: (integral(LINEAR, x), integral(LINEAR, x, 2)))
        yield found, (line[:, element, :2], line[:, element, 2:])


def straining_displacement(system: System, response: ElasticResponse, v: Array) -> Array:
    """Nodal values v of the elements in member axes, less what strains nothing along them, ``(angles, elements, 6)``.

    With large rotations bending shortens the axis: elements are as much longer as their axial force stretches them, and
    bend as one does that is not stretched, see `BentAxis`.
    """
    nodal, tension = in_member_axes(system.beams.mesh, v), element_tension(system, response)
    if system.terms.law is not None and tension is not None:
        nodal[..., 0] = 0.0
        nodal[..., 3] = tension * system.beams.mesh.cell_length / system.beams.rigidity.axial.mean
        nodal[..., NORMAL[::2]] /= stretch_of(system, response)[..., None]
    return nodal


def bent_by_tension(system: System, response: ElasticResponse, forces: AxialForces, element: Index, xi: Array) -> Array:
    """Deflection that axial forces on their cubic shape add between the nodes of elements, ``(angles, places)`` (m).

    A force N acts as the spread load ``(N w')'``; that is linear along each element here.

    Parameters
    ----------
    system, response
        The mechanism, and a motion of it.
    forces
        Axial forces of the elements.
    element, xi
        Places 0..1 in elements, ``(places,)`` each.
    """
    beams = system.beams
    h, number = beams.mesh.cell_length[element], shear_number(beams)[element]
    stretch = stretch_of(system, response)
    nodal = beams.layout.hermite_dofs(system.to_links(response.displacement), stretch)[..., NORMAL]
    nodal = scaled(nodal, beams.mesh.cell_length * stretch)[:, element]
    of_mean, of_slope = (
        np.sum(nodal * between_clamped_ends(tuple((force * f.deriv()).deriv() for f in CUBIC), xi, number), -1)
        for force in (Polynomial([1]), Polynomial([-1, 2]))
    )
    bent = forces.mean[:, element] * of_mean + forces.slope[:, element] * of_slope
    return np.asarray(h**2 / beams.rigidity.bending.mean[element] * bent)


def _in_fixed_frame(system: System, u: Array, w: Array, element: Index) -> Array:
    mesh = system.beams.mesh
    angle = system.motion.angle[:, mesh.member_link] + mesh.member_angle
    c, s = (np.take(of_members, mesh.cell_member[element], axis=1) for of_members in (np.cos(angle), np.sin(angle)))
    return np.stack([c * u - s * w, s * u + c * w], axis=-1)
