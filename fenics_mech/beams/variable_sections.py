"""Elements whose section varies: the shapes that statics gives them between their nodes are not the cubic ones.

Under forces on its ends an element has a moment that is linear along it, over a stiffness that is not constant. Its
cubic shape is stiffer than that; the flexibility of the element is known, as are the shapes of its axis.

Source: Spacone, Filippou and Taucer, Earthq. Eng. Struct. Dyn. 25 (1996) 711, elements by forces.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, evaluate
from fenics_mech.scene.sections.rigidity import SECTION

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams
    from fenics_mech.scene.sections import Rigidity as SectionRigidity

RULE_POINTS, RULE_WEIGHTS = (np.polynomial.legendre.leggauss(12) + np.array([[1.0], [0.0]])) / 2  # integrals over 0..1


def stiffness_correction(beams: Beams) -> Array:
    """Stiffness of the elements by statics less that by the shape functions, in member axes, ``(elements, 6, 6)``.

    Parameters
    ----------
    beams
        The links' matrices.
    """
    axial, bending = _flexibility(beams, *_ends(beams))
    relative, found = _relative(beams.mesh.cell_length), np.zeros_like(beams.element_stiffness)
    found[:, [[1], [2], [4], [5]], NORMAL] = relative.transpose(0, 2, 1) @ np.linalg.inv(bending) @ relative
    found[:, [[0], [3]], AXIAL] = np.array([[1.0, -1.0], [-1.0, 1.0]]) / axial[:, None, None]
    if beams.layout.offsets is not None:
        arms = beams.layout.offsets.arms
        found = arms.transpose(0, 2, 1) @ found @ arms
    found -= beams.element_stiffness
    return found


def shape_corrections(beams: Beams, element: Index, xi: Array) -> tuple[Array, Array]:
    """Displacements by statics less those of the shape functions, along and across, by the nodes' in member axes.

    Both are ``(places, 6)``, at places `xi` 0..1 of elements.

    Parameters
    ----------
    beams
        The links' matrices.
    element
        Element of each place, ``(places,)``.
    xi
        The places, ``(places,)``.
    """
    h = beams.mesh.cell_length[element]
    along, across = shapes(beams, element, xi)
    linear, cubic = np.zeros_like(along), np.zeros_like(across)
    linear[:, AXIAL] = evaluate(LINEAR, xi)
    cubic[:, NORMAL] = evaluate(CUBIC, xi) * np.stack([np.ones_like(h), h] * 2, axis=-1)
    return along - linear, across - np.einsum("pi,pij->pj", cubic, beams.layout.tie[element])


def shapes(beams: Beams, element: Index, xi: Array) -> tuple[Array, Array]:
    """Displacements along and across the member that statics gives elements by their nodes', in member axes.

    Both are ``(places, 6)``, at places `xi` 0..1 of elements.

    Parameters are those of `shape_corrections`.
    """
    h = beams.mesh.cell_length[element]
    axial, bending = _flexibility(beams, element, xi)
    whole_axial, whole = (part[element] for part in _flexibility(beams, *_ends(beams)))
    along, across = np.zeros((2, len(element), 6))
    stretched = axial / whole_axial
    along[:, AXIAL] = np.stack([1 - stretched, stretched], axis=-1)
    across[:, NORMAL] = (bending[:, :1] @ np.linalg.inv(whole) @ _relative(h))[:, 0]
    across[:, [1, 2]] += np.stack([np.ones_like(xi), xi * h], axis=-1)
    return along, across


def between_ends(
    beams: Beams, element: Index, xi: Array, loads: Callable[[Index, Array], tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Displacements of elements with fixed, clamped ends under loads spread along them.

    The element is first free at its first end, where statics gives its forces. What its second end then has of
    displacement and rotation is taken away by the shapes of `shapes`.

    Parameters
    ----------
    beams, element, xi
        Places 0..1 in elements whose section varies.
    loads
        Gives the integrals, and the twice repeated integrals, of load functions (N/m) from the starts of elements to
        places in them of length 1, ``(places, functions)`` each.

    Returns
    -------
    tuple
        u and w of each load function (m), ``(places, functions)``.
    """
    u, w, _ = _from_first_end(beams, element, xi, loads)
    end_u, end_w, end_turn = (part[element] for part in _from_first_end(beams, *_ends(beams), loads))
    along, across = shapes(beams, element, xi)
    return u - along[:, 3:4] * end_u, w - across[:, 4:5] * end_w - across[:, 5:] * end_turn


def _from_first_end(
    beams: Beams, element: Index, xi: Array, loads: Callable[[Index, Array], tuple[Array, Array]]
) -> tuple[Array, Array, Array]:
    """Displacements u, w and rotation beside those of the first node, which has no forces, ``(places, functions)``."""
    h, x = beams.mesh.cell_length[element, None], xi[:, None] * RULE_POINTS
    once, twice = (part.reshape(*x.shape, -1) for part in loads(np.repeat(element, len(RULE_POINTS)), x.ravel()))
    ea, ei = _rigidities(beams, element, x)
    weight = xi[:, None] * RULE_WEIGHTS
    u = -(h**2) * np.sum((weight / ea)[..., None] * once, axis=1)
    turned = h**3 * np.sum((weight / ei)[..., None] * twice, axis=1)
    w = h**4 * np.sum((weight * (xi[:, None] - x) / ei)[..., None] * twice, axis=1)
    if beams.rigidity.shear is not None:
        w -= h**2 * loads(element, xi)[1] / beams.rigidity.shear.mean[element, None]
    return u, w, turned


def misfit(rigidities: Callable[[str, Array], SectionRigidity], beams: Beams) -> Array:
    """Share of each member's flexibility and mass by which its elements' polynomials miss its section, ``(members,)``.

    What notches and steps have between the points of a polynomial no element knows.

    Parameters
    ----------
    rigidities
        Gives the rigidity of a member at places along it, as `Scene.rigidity`.
    beams
        The links' matrices.
    """
    mesh = beams.mesh
    rigidity, density = beams.rigidity, beams.inertia.density
    if not (rigidity.varies and density.varies):
        return np.zeros(len(mesh.members))
    places = (np.arange(SECTION.places) + 0.5) / SECTION.places
    powers = np.stack([rigidity.bending.powers, density.powers])
    fitted = powers @ np.vander(places, powers.shape[-1], increasing=True).T  # EI, rho A: (2, elements, places)
    fitted[0] = 1 / fitted[0]
    found = np.empty(len(mesh.members))
    for i, label in enumerate(mesh.members):
        of_member = mesh.cell_member == i
        h = mesh.cell_length[of_member, None]
        s = (mesh.cell_start[of_member, None] + h * places) / mesh.member_length[i]
        section = rigidities(label, np.clip(s.ravel(), 0, 1))
        true = np.stack([1 / section.bending, section.line_density]).reshape(2, *s.shape)
        shares = np.sum(h * np.abs(fitted[:, of_member] - true), axis=(1, 2)) / np.sum(h * true, axis=(1, 2))
        found[i] = shares.sum()
    return found


def _ends(beams: Beams) -> tuple[Index, Array]:
    """All elements, and the places of their second nodes."""
    return np.arange(len(beams.mesh.cell)), np.ones(len(beams.mesh.cell))


def _relative(h: Array) -> Array:
    """Displacement w, phi of the second node beside that of the rigid element that the first one turns."""
    relative = np.tile([[-1.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 1.0]], (len(h), 1, 1))
    relative[:, 0, 1] = -h
    return relative


def _flexibility(beams: Beams, element: Index, xi: Array) -> tuple[Array, Array]:
    """Displacements at places of elements by the forces on their second nodes, when the first ones are held.

    Returns
    -------
    tuple
        u by the axial force, ``(places,)``, and w, phi by the transverse force and the moment, ``(places, 2, 2)``.
    """
    h = beams.mesh.cell_length[element]
    x, weight = xi[:, None] * RULE_POINTS, xi[:, None] * RULE_WEIGHTS
    ea, ei = _rigidities(beams, element, x)
    curvature = np.stack([h[:, None] * (1 - x), np.ones_like(x)], axis=-1) / ei[..., None]
    turned = np.sum(weight[..., None] * curvature, axis=1) * h[:, None]
    moved = np.sum((weight * (xi[:, None] - x))[..., None] * curvature, axis=1) * h[:, None] ** 2
    if beams.rigidity.shear is not None:
        moved[:, 0] += xi * h / beams.rigidity.shear.mean[element]
    return h * np.sum(weight / ea, axis=1), np.stack([moved, turned], axis=1)


def _rigidities(beams: Beams, element: Index, x: Array) -> Array:
    """EA (N) and EI (N m^2) at places of elements, ``(places, points)``, stacked."""
    powers = beams.rigidity.powers[element]
    found = np.einsum("pgk,pak->pga", x[..., None] ** np.arange(powers.shape[-1]), powers)
    return np.moveaxis(found, -1, 0)
