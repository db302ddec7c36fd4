"""Inertia along elements, and what it adds between their ends: by the axis, by rotation, by mass beside the axis."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.distributions import Distribution
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, between_clamped_ends, integral
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System

SHAPES = (*CUBIC, *LINEAR)  # functions that the inertia of an element is made of
SLOPES = (*(f.deriv() for f in CUBIC), Polynomial([1.0]))  # and the rotation of its sections
AS_CUBICS = np.array([[f(0.0), f.deriv()(0.0), f(1.0), f.deriv()(1.0)] for f in SLOPES])  # that rotation by `CUBIC`


def by_rotary_inertia(
    system: System, response: ElasticResponse, rotary: Distribution, element: Index, xi: Array
) -> tuple[Array, Array]:
    """Moment, and EI times the deflection between clamped ends, by the inertia of the sections' rotation.

    Both are ``(angles, places)``; `rotary` is rho I.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    rotary
        rho I of the sections (kg m).
    element
        Element of each place, ``(places,)``.
    xi
        The places, 0..1 in their elements, ``(places,)``.
    """
    beams, powers = system.beams, rotary.powers
    h = beams.mesh.cell_length[element]
    rotation = response.rotation
    turning = response.inertia if rotation is None else response.inertia - rotation.centripetal
    rate = _rotation(system, turning, element)
    terms = [tuple(f * Polynomial.basis(p) for f in SLOPES) for p in range(powers.shape[-1])]
    up_to = sum(powers[element, p, None] * integral(f, xi) for p, f in enumerate(terms))
    particular = between_clamped_ends(SLOPES, xi, shear_number(beams)[element], order=3)
    bent = rotary.mean[element] * h**3 * np.sum(rate * particular, -1)
    return h * np.sum(rate * up_to, -1), bent


def _rotation(system: System, nodal: Array, element: Index) -> Array:
    """Rotation of the sections of elements by nodal values in link axes, by `SLOPES`, ``(angles, places, 5)``."""
    mesh, layout = system.beams.mesh, system.beams.layout
    h, slopes, plain = mesh.cell_length[element], layout.hermite_dofs(nodal), in_member_axes(mesh, nodal)
    slopes, plain = slopes[:, element], plain[:, element]
    rate = np.empty((*slopes.shape[:2], len(SLOPES)))  # slope of w less angle of shear
    rate[..., :4], rate[..., 4] = scaled(slopes[..., NORMAL], h) / h[:, None], plain[..., 2] - slopes[..., 2]
    return rate


def by_mass_beside_axis(
    system: System, response: ElasticResponse, mass_moment: Array, element: Index, xi: Array
) -> tuple[Array, Array]:
    """Moment, and EI times the deflection between clamped ends, by inertia along the member on the arm of its mass.

    Both are ``(angles, places)``. Of that inertia the acceleration of the neutral line counts here; `by_rotary_inertia`
    has the rest.

    Parameters
    ----------
    system, response
        The mechanism, and a motion of it.
    mass_moment
        rho A e of the elements (kg), ``(elements,)``.
    element, xi
        Places 0..1 in elements, ``(places,)`` each.
    """
    h = system.beams.mesh.cell_length[element]
    along = _of_neutral_line(system, response, element)[0]
    particular = between_clamped_ends(SHAPES, xi, shear_number(system.beams)[element], order=3)
    on_arm = -mass_moment[element]
    return on_arm * h * np.sum(along * integral(SHAPES, xi), -1), on_arm * h**3 * np.sum(along * particular, -1)


def shear_number(beams: Beams) -> Array:
    """EI/(G A_s) over the length squared of the elements, ``(elements,)``; 0 where they are rigid in shear.

    Parameters
    ----------
    beams
        The links' matrices.
    """
    if beams.rigidity.shear is None:
        return np.zeros(len(beams.mesh.cell))
    return beams.rigidity.bending.mean / beams.rigidity.shear.mean / beams.mesh.cell_length**2


def inertia_of(system: System, response: ElasticResponse, element: Index) -> tuple[Array, Array]:
    """Acceleration of the mass along and across the member in each element, as coefficients of `SHAPES`.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    element
        Element of each place, ``(places,)``.

    Returns
    -------
    tuple
        Along and across, ``(angles, places, 6)`` each.
    """
    along, across = _of_neutral_line(system, response, element)
    if system.beams.mass_moment is not None and system.beams.layout.offsets is not None:
        arm = system.beams.layout.offsets.mass[element, None]  # the centre of mass moves by u - e phi, w
        along[..., :4] -= arm * (_rotation(system, response.inertia, element) @ AS_CUBICS)
        if response.rotation is not None:
            across[..., :4] -= arm * (_rotation(system, response.rotation.turning, element) @ AS_CUBICS)
    return along, across


def _of_neutral_line(system: System, response: ElasticResponse, element: Index) -> tuple[Array, Array]:
    """Acceleration of the neutral line, as `inertia_of` gives that of the mass."""
    h = system.beams.mesh.cell_length[element]
    inertia = system.beams.layout.hermite_dofs(response.inertia)[:, element]
    along = np.zeros((*inertia.shape[:2], 6))
    across = np.zeros_like(along)
    along[..., 4:], across[..., :4] = inertia[..., AXIAL], scaled(inertia[..., NORMAL], h)
    if response.rotation is not None:
        turning = system.beams.layout.hermite_dofs(response.rotation.turning)[:, element]
        along[..., :4], across[..., 4:] = -scaled(turning[..., NORMAL], h), turning[..., AXIAL]  # the form s
    return along, across


def scaled(dofs: Array, h: Array) -> Array:
    """Displacements and rotations of elements as those of unit elements: rotations times h.

    Parameters
    ----------
    dofs
        Displacement across the member and rotation of both nodes, ``(..., 4)``.
    h
        Length of each element (m).
    """
    return dofs * np.stack([np.ones_like(h), h, np.ones_like(h), h], axis=-1)
