"""What the elements neglect: the inertia of the deflection between their nodes, as a line load.

Under a load that does not depend on the motion the nodes of an element move exactly. But the load adds a deflection b
between them, and b has no inertia and no axial force T acts on it. Of that force the equation has the mean over each
element, and a part linear along it by loads and rigid motion; what else it is, n, is left out. So the equation of the
nodes lacks ``-int (rho A b'' N + T b' N' + n w' N') dx``, b'' being an acceleration. The response to this load is the
error, to first order. In bending it falls with the fourth power of the element's length, along the axis with the
second. So does n by the elastic motion, with the inertia of the mass that bending moves along the axis: both are small.

Where a section varies, the nodes are not exact under loads at rest either; see `beams.variable_sections`. A pin that
travels along a member follows the nodes, without the deflection between them by its own force. That error falls with
the third power, and under a slider that turns with the member with the first; see also `slider_kinks`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index, each
from fenics_mech.accuracy.time_derivatives import first_derivative, second_derivative
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.shapes import ACROSS, ALONG, AXIAL, CUBIC, LINEAR, NORMAL, evaluate
from fenics_mech.beams.variable_sections import shape_corrections, stiffness_correction
from fenics_mech.effects import NOTHING, UNLOADED, Loads
from fenics_mech.effects.given_axial_forces import AxialForces
from fenics_mech.forces.bent_axes import beyond_mean
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import element_tension, left_to_statics, uneven_tension
from fenics_mech.forces.element_loads import PointLoad, pin_loads
from fenics_mech.forces.inertia import SHAPES, inertia_of
from fenics_mech.forces.joint_forces import without_elastic
from fenics_mech.forces.mass_shift import MassShift
from fenics_mech.forces.section_forces import bent_by_tension, between_nodes, straining_displacement
from fenics_mech.mechanism import System
from fenics_mech.response.static.quasi_static import yielding_to
from fenics_mech.scene import Prismatic

Complex = NDArray[np.complex128]
ROTATIONS = (CUBIC[1], CUBIC[3])  # the functions of the nodes' rotations
OF_WORK_ALONG, OF_WORK_ACROSS = np.linalg.inv(ALONG).T, np.linalg.inv(ACROSS[[1, 3]]).T  # linear loads of their work
GAUSS, GAUSS_WEIGHT = (np.polynomial.legendre.leggauss(4) + np.array([[1.0], [0.0]])) / 2  # in an element of length 1
ORDER, OF_PINS, OF_LUMPS, OF_SLIDERS = 4, 3, 2, 1  # in the length of the elements


def order_of(system: System) -> float:
    """Power of the elements' length with which the error falls.

    Parameters
    ----------
    system
        The mechanism over the cycle.
    """
    if system.beams.inertia.spread is not None:
        return OF_LUMPS
    contacts = system.transformation.constraints.contacts.values()
    if any(isinstance(contact.slot, Prismatic) for contact in contacts):
        return OF_SLIDERS
    return OF_PINS if contacts else ORDER


def neglected(system: System, response: ElasticResponse, step: float | None) -> Loads:
    """Give the loads that the elements neglect.

    Those of the inertia are linear along each element, with the same moments at clamped ends; those of the axial force
    and of a section that varies are on its ends. Derivatives in time are those of a Fourier series through a cycle.

    Parameters
    ----------
    system, response
        The mechanism and its motion at equal steps of time.
    step
        The step (s); None where the elastic motion has no inertia.
    """
    if system.beams.consistent is not None:
        along = replace(system, beams=system.beams.consistent)
        return _by_lumps(system, along, response) + neglected(along, response, step)
    count, tension, reduction = len(system.beams.mesh.cell), element_tension(system, response), system.beams.reduction
    varies, contacts = system.beams.rigidity.varies, system.transformation.constraints.contacts
    if step is None and tension is None and not varies and not contacts:
        return UNLOADED
    element, xi = _everywhere(system.beams)
    pins = pin_loads(system, response)
    u, w = between_nodes(system, response, element, xi, pins)
    forces = None
    if tension is not None:
        forces = AxialForces(tension, uneven_tension(system, response))
        w = w + bent_by_tension(system, response, forces, element, xi)
    z = (u + 1j * w).reshape(len(u), count, -1)
    line = None
    if step is not None:
        share = 1.0 if reduction is None else reduction.fineness ** float(-ORDER)
        line = _line(-share * _line_density(system.beams) * _acceleration(system, z, step))
        if not system.terms.coupled:
            line += _of_joints(system, response.displacement, step)
    force = None
    if reduction is not None and (step is not None or tension is not None):
        force = _by_statics(system, left_to_statics(system, response), tension, step)
    ends = _by_varying(system, response, element, xi) if varies else None
    if forces is not None:
        uneven = beyond_mean(system, response, element, xi, pins).reshape(z.shape)
        ends = _sum(ends, _by_tension_inside(system, response, uneven) + _by_tension(system, forces, z.imag))
        if system.terms.law is not None and step is not None:
            ends += _by_shift(system, response, step)
    if contacts:
        pulled = tension if system.terms.law is not None else None
        of_ends, of_nodes = _by_pins(system, pins, step, pulled)
        ends, force = _sum(ends, of_ends), _sum(force, of_nodes)
    return Loads(line=line, force=force, ends=ends)


def _sum(first: Array | None, second: Array) -> Array:
    return second if first is None else first + second


def _by_lumps(system: System, along: System, response: ElasticResponse) -> Loads:
    """Give the inertia of mass along the beams in place of that of lumps; `along` is the mechanism with such beams.

    It is linear along each element; what is then missing of the forces by the consistent mass is on the nodes.
    """
    element, xi = _everywhere(along.beams)
    along_axis, across = (np.sum(part * evaluate(SHAPES, xi), axis=-1) for part in inertia_of(along, response, element))
    force = -_line_density(along.beams) * (along_axis + 1j * across).reshape(len(across), -1, len(GAUSS))
    line = _line(np.asarray(force, dtype=np.complex128))
    lumps, beams = (without_elastic(replace(one, terms=NOTHING), response) for one in (system, along))
    return Loads(line=line, force=lumps - beams - along.applied_by(Loads(line=line)))


def _everywhere(beams: Beams) -> tuple[Index, Array]:
    """`GAUSS` in all elements: their elements, and places 0..1."""
    count = len(beams.mesh.cell)
    return np.repeat(np.arange(count), len(GAUSS)), np.tile(GAUSS, count)


def _by_varying(system: System, response: ElasticResponse, element: Index, xi: Array) -> Array:
    """Give the loads on the ends of elements whose sections vary, by the shapes missing in them: ``f S + dk v``.

    S are those shapes, f the loads and the inertia along the elements, dk what their stiffness is too large.
    """
    beams, terms = system.beams, system.terms
    count = len(beams.mesh.cell)
    found = -each(
        stiffness_correction(beams), straining_displacement(system, response, response.undamped.strained(system))
    )
    density, shapes = _line_density(beams).ravel(), evaluate(SHAPES, xi)
    corrections = shape_corrections(beams, element, xi)
    parts = zip(inertia_of(system, response, element), corrections, (slice(0, 2), slice(2, 4)))
    for acceleration, missing, of_line in parts:
        load = -density * np.sum(acceleration * shapes, axis=-1)
        if terms.loads.line is not None:
            load += np.sum(terms.loads.line[:, element, of_line] * evaluate(LINEAR, xi), axis=-1)
        per_place = load * np.tile(GAUSS_WEIGHT, count) * beams.mesh.cell_length[element]
        found += (per_place[..., None] * missing).reshape(len(load), count, -1, 6).sum(axis=2)
    return found


def _by_pins(
    system: System, pins: Sequence[PointLoad], step: float | None, tension: Array | None
) -> tuple[Array, Array]:
    """Give the loads by which travelling pins follow the deflection under their own forces, which the nodes leave out.

    The linkage gives way to the pins' gaps by statics. That bends elements, whose stress and inertia act on their ends,
    and moves springs and point masses, whose forces act on nodes. Axial forces are not in these statics, and act
    on what they give: a link that is beyond its Euler load for a moment only would buckle. `tension` is that of the
    elements where a nonlinear law holds it, and no stiffness does.
    """
    beams, v = system.beams, _by_gaps(system, pins)
    ends = -each(beams.element_stiffness, in_member_axes(beams.mesh, v))
    force = -sum((entries.times(v) for entries in system.added_stiffness), np.zeros_like(v))
    if tension is not None:
        force += system.assembled_from_members(_pulled(system, v, tension[..., None] * GAUSS_WEIGHT))
    if step is None:
        return ends, force
    inertia, turning = _of_nodes(system, v, step)
    of_elements = -each(beams.element_mass, in_member_axes(beams.mesh, inertia))
    if turning is not None:
        of_elements -= each(beams.element_gyroscopic, in_member_axes(beams.mesh, turning))
    force += _by_inertia(system, inertia, turning) - system.assembled_from_members(of_elements)
    return ends + of_elements, force


def moved_by_gaps(system: System, response: ElasticResponse) -> Array:
    """Displacement that the nodes leave out as pins travel over them, ``(angles, nodal dofs)``; see `_by_pins`.

    Parameters
    ----------
    system
        The mechanism at the angles of the response.
    response
        Its motion.
    """
    return _by_gaps(system, pin_loads(system, response))


def _by_gaps(system: System, pins: Sequence[PointLoad]) -> Array:
    contacts = system.transformation.constraints.contacts
    return system.on_nodes(yielded(system, dict(zip(contacts, (pin.gap(system) for pin in pins)))))


def yielded(system: System, gaps: Mapping[str, tuple[Array, Array]]) -> Array:
    """Give the links' coordinates, ``(angles, links' coordinates)``, when the linkage gives way to gaps at its pins.

    That is by statics without axial forces; see `Transformation.displacement_by_gaps`.

    Parameters
    ----------
    system
        The mechanism.
    gaps
        As of `Transformation.displacement_by_gaps`.
    """
    return given_way(system, system.transformation.displacement_by_gaps(system.motion, gaps))


def given_way(system: System, separated: Array) -> Array:
    """Give the links' coordinates when the linkage gives way to displacements that joints force on it.

    That is by statics without axial forces.

    Parameters
    ----------
    system
        The mechanism.
    separated
        Displacements of the links with q = 0, ``(angles, links' coordinates)``.
    """
    unstressed = system.without_axial_forces
    q = yielding_to(unstressed, -_held(unstressed, separated, system.on_nodes(separated)))
    return separated + system.transformation.forward(system.values, q)


def _held(system: System, coordinates: Array, v: Array) -> Array:
    """Forces on the mechanism's coordinates by displacements of the links, ``(angles, coordinates)``."""
    elastic = system.transformation.backward(system.values, (system.link_stiffness @ coordinates.T).T)
    for entries in system.added_stiffness:
        elastic += system.on_coordinates(entries.times(v))
    return elastic


def _by_statics(system: System, v: Array, tension: Array | None, step: float | None) -> Array:
    """Forces on nodal dofs by inertia and axial force of displacements v that have none in the reduction."""
    force = np.zeros_like(v)
    if step is not None:
        force += _by_inertia(system, *_of_nodes(system, v, step))
    if tension is not None:
        force += system.assembled_from_members(_pulled(system, v, tension[..., None] * GAUSS_WEIGHT))
    return force


def _by_inertia(system: System, inertia: Array, turning: Array | None) -> Array:
    force = -(system.nodal_mass @ inertia.T).T
    return force if turning is None else force - (system.nodal_gyroscopic @ turning.T).T


def _of_nodes(system: System, v: Array, step: float, links: Index | None = None) -> tuple[Array, Array | None]:
    """Inertia of displacements with drag, and what the gyroscopic matrix takes, ``(angles, dofs)`` each.

    `links` are those of the dofs; by default dofs are nodal ones.
    """
    first = first_derivative(v, step)
    inertia = second_derivative(v, step) + system.terms.damping.drag * first
    if not system.terms.coupled:
        return inertia, None
    links = system.link_of_dof if links is None else links
    omega, alpha = system.motion.omega[:, links], system.tangential[:, links]
    return inertia - omega**2 * v, 2 * omega * first + alpha * v


def _line(force: Complex) -> Array:
    """Give the loads linear along each element that are to it what forces at `GAUSS` are (N/m)."""
    along = (force.real * GAUSS_WEIGHT) @ evaluate(LINEAR, GAUSS) @ OF_WORK_ALONG
    across = (force.imag * GAUSS_WEIGHT) @ evaluate(ROTATIONS, GAUSS) @ OF_WORK_ACROSS
    return np.concatenate([along, across], axis=-1)


def _of_joints(system: System, q: Array, step: float) -> Array:
    """Give the load by which the inertia beside joints is that of the links' own axes, as it is everywhere else.

    Without coupling the acceleration is P q'', and not (P q)''. That differs where the coordinates are not those of
    nodes in link axes, in the elements beside joints, and so depends on the mesh.
    """
    nodal = second_derivative(system.to_links(q), step) - system.to_links(second_derivative(q, step))
    ends = in_member_axes(system.beams.mesh, nodal)
    return -system.beams.inertia.density.mean[:, None] * ends[..., [0, 3, 1, 4]]


def _by_tension(system: System, forces: AxialForces, w: Array) -> Array:
    """Give the loads on elements' ends by axial forces on deflections w at `GAUSS`, ``-int N w' z' dx``.

    As w is 0 at the ends, that is ``int w (N z')' dx``.
    """
    mesh, ends = system.beams.mesh, np.zeros((*forces.mean.shape, 6))
    for force, shape in ((forces.mean, Polynomial([1])), (forces.slope, Polynomial([-1, 2]))):
        bent = (w * GAUSS_WEIGHT) @ evaluate(tuple((shape * f.deriv()).deriv() for f in CUBIC), GAUSS)
        ends[..., NORMAL] += force[..., None] * bent
    ends[..., NORMAL] /= np.stack([mesh.cell_length, np.ones(len(mesh.cell))] * 2, axis=-1)
    return ends


def _by_tension_inside(system: System, response: ElasticResponse, uneven: Array) -> Array:
    """Give the loads on elements' ends by what axial forces differ from those in the equation, ``-int n w' N' dx``.

    `uneven` is what they differ from their means, at `GAUSS`. The moments inside elements have it already.
    """
    for given in system.terms.uneven:
        uneven = uneven - given.force[..., None] * (2 * GAUSS - 1)
    return _pulled(system, system.to_links(response.displacement), uneven * GAUSS_WEIGHT)


def _by_shift(system: System, response: ElasticResponse, step: float) -> Array:
    """Give the loads on elements' ends by the inertia of the shift of their mass, see `MassShift`."""
    mesh, v = system.beams.mesh, system.to_links(response.displacement)
    shift = MassShift(system, (v, v, v)).in_time[0]
    moved = np.zeros((*shift.shape, 6))
    moved[..., AXIAL] = shift[..., None]
    links = np.repeat(mesh.member_link[mesh.cell_member], 6)
    inertia, turning = _of_nodes(system, moved.reshape(len(v), -1), step, links)
    ends = -each(system.beams.element_mass, inertia.reshape(moved.shape))
    if turning is not None:
        ends -= each(system.beams.element_gyroscopic, turning.reshape(moved.shape))
    return ends


def _pulled(system: System, v: Array, axial: Array) -> Array:
    """Forces on the elements' ends by axial forces times `GAUSS_WEIGHT` on nodal displacements, ``-int N w' N' dx``."""
    mesh = system.beams.mesh
    h = mesh.cell_length[:, None]
    nodal = in_member_axes(mesh, v)[..., NORMAL]
    nodal[..., 1::2] *= h
    slopes = evaluate(tuple(f.deriv() for f in CUBIC), GAUSS)
    ends = np.zeros((*axial.shape[:2], 6))
    ends[..., NORMAL] = -((axial * (nodal @ slopes.T)) @ slopes) / h
    ends[..., [2, 5]] *= h
    return ends


def _acceleration(system: System, z: Complex, step: float) -> Complex:
    """Acceleration of displacements u + i w, ``(angles, elements, places)``, in the axes of the members, with drag."""
    first = first_derivative(z, step)
    second = second_derivative(z, step) + system.terms.damping.drag * first
    if not system.terms.coupled:
        return second
    mesh, motion = system.beams.mesh, system.motion
    omega, alpha = (rate[:, mesh.member_link[mesh.cell_member], None] for rate in (motion.omega, system.tangential))
    turning: Complex = (2j * omega) * first + (1j * alpha - omega**2) * z
    total: Complex = np.add(second, turning)
    return total


def _line_density(beams: Beams) -> Array:
    """Mass per length at `GAUSS` of every element (kg/m), ``(elements, places)``."""
    powers = beams.inertia.density.powers
    return powers @ GAUSS ** np.arange(powers.shape[-1])[:, None]
