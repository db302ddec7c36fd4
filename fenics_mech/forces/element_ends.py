"""Forces on the ends of the elements, which are as good as the displacements, and the axial forces that they hold."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array, each, times
from fenics_mech.beams.element_dofs import element_dofs, in_member_axes, member_rotation
from fenics_mech.beams.shapes import AXIAL
from fenics_mech.effects import AxialForces
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.joint_forces import without_elastic
from fenics_mech.forces.reduced_members import response_of_reduced_members
from fenics_mech.forces.spinning_sections import spinning
from fenics_mech.mechanism import System


def balanced(system: System, response: ElasticResponse) -> tuple[Array, Array]:
    """Forces on the elements' ends, ``(angles, elements, 6)``, and the displacement v that goes with them.

    Inside members that are reduced both follow from equilibrium, so that the modes left out answer statically.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    """
    stress, v = _by_stress(system, response)
    return _on_elements(system, response) + stress, v


def _by_stress(system: System, response: ElasticResponse) -> tuple[Array, Array]:
    """Forces on the elements' ends by the links' stress, ``(angles, elements, 6)``, and v as of `balanced`."""
    beams, strained, v = system.beams, response.strained(system), system.to_links(response.displacement)
    if beams.reduction is None:
        ends = beams.elastic_ends(strained)
    else:
        ends, settled = response_of_reduced_members(beams, strained, without_elastic(system, response))
        v = v + settled - strained
    return ends, v


def elastic_forces(system: System, v: Array) -> Array:
    """Forces of stretch and bending on the nodes (N, N m), ``(angles, nodal dofs)``, by the strain of each element.

    The stiffness matrix times the displacements is the same but for rounding, which is more where stiff elements move
    far as a whole.

    Parameters
    ----------
    system
        A mechanism whose members are not reduced.
    v
        Displacements of the nodes in link axes (m, rad), ``(angles, nodal dofs)``.
    """
    if (law := system.terms.law) is None:
        return system.assembled_from_members(system.beams.elastic_ends(v))
    return system.assembled(law.whole_force(v, np.zeros_like(v)))


def left_to_statics(system: System, response: ElasticResponse) -> Array:
    """Displacement that modes left out of reduced members add, ``(angles, nodal dofs)``: it has no inertia.

    Parameters are those of `balanced`.
    """
    return balanced(system, response)[1] - system.to_links(response.displacement)


def _on_elements(system: System, response: ElasticResponse) -> Array:
    """Forces on the elements' ends by everything but the links' stress, ``(angles, elements, 6)``."""
    beams, terms = system.beams, system.terms
    ends = each(beams.element_mass, in_member_axes(beams.mesh, response.inertia))
    if response.rotation is not None:
        ends += each(beams.element_gyroscopic, in_member_axes(beams.mesh, response.rotation.turning))
        if beams.inertia.rotary is not None:
            ends -= each(beams.element_rotary_mass, in_member_axes(beams.mesh, response.rotation.centripetal))
    if terms.loads.line is not None:
        ends -= beams.layout.work_equivalent(terms.loads.line)
    if terms.loads.ends is not None:
        ends -= terms.loads.ends
    v, rotation = system.to_links(response.displacement), member_rotation(beams.mesh)
    if response.modal_damping is not None and response.modal_damping.on_bent_axis is not None:
        ends += each(rotation, response.modal_damping.on_bent_axis)
    for blocks in terms.axial_stiffness:
        ends += each(rotation, times(blocks, v[:, element_dofs(beams.mesh)]))
    if terms.law is not None and response.velocity is not None:
        ends += each(rotation, terms.law.on_elements.force(v, response.velocity))
    if (spun := spinning(system, response)) is not None:
        ends += each(rotation, spun[0].force(*spun[1], system.motion.alpha))
    return ends


def element_tension(system: System, response: ElasticResponse) -> Array | None:
    """Axial force with which the elements' axes resist bending (N), ``(angles, elements)``; None in linear theory.

    Parameters are those of `balanced`.
    """
    law = system.terms.law
    if law is not None and response.velocity is not None:
        return law.on_elements.tension(system.to_links(response.displacement), response.velocity)
    return None if system.terms.stiffening is None else system.terms.stiffening.force


def uneven_tension(system: System, response: ElasticResponse) -> Array:
    """Half of what axial forces change along every element (N), ``(angles, elements)``: half of all loads along it.

    Parameters are those of `balanced`.
    """
    return np.asarray(_on_elements(system, response)[..., AXIAL].mean(axis=-1))


def axial_forces(system: System, response: ElasticResponse) -> AxialForces:
    """Axial forces of the elements that act on their bent axes.

    Parameters are those of `balanced`.
    """
    return AxialForces(mean_tension(system, response), uneven_tension(system, response.undamped))


def mean_tension(system: System, response: ElasticResponse) -> Array:
    """Mean axial force of every element that acts on its bent axis (N), ``(angles, elements)``; for linear laws.

    The share of modal damping does not, as it is linear in the coordinates. By virtual work ``int N dx`` is that of the
    forces on the ends, less that of loads and inertia, as the element is stretched evenly: that of the stress is left.

    Parameters are those of `balanced`.
    """
    ends = _by_stress(system, response.undamped)[0]
    return np.asarray(ends[..., 3] - ends[..., 0]) / 2
