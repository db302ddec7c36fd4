"""What axial forces do on bent axes: moments along them, by forces that change inside elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array, Index, at_places
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, evaluate
from fenics_mech.errors import UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_loads import PointLoad
from fenics_mech.forces.inertia import inertia_of, scaled
from fenics_mech.forces.statics import mass_up_to, spread_and_point_loads, statics
from fenics_mech.mechanism import System

PLACES, WEIGHTS = np.polynomial.legendre.leggauss(5)  # -1..1, at which forces are summed up along an element


def by_shape_functions(nodal: Array, h: Array, element: Index, xi: Array) -> tuple[Array, Array, Array]:
    """Displacements u and w by the shape functions, and the slope of w, ``(angles, places)`` each.

    Parameters
    ----------
    nodal
        Dofs of Hermite's functions in member axes, ``(angles, elements, 6)``.
    h
        Lengths of the elements' axes as they are stretched (m), ``(elements,)`` or ``(angles, elements)``.
    element, xi
        Places 0..1 in elements, ``(places,)`` each.
    """
    bent, slopes = scaled(nodal[..., NORMAL], h), np.stack([f.deriv()(xi) for f in CUBIC], axis=-1, dtype=np.float64)
    u = at_places(nodal[..., AXIAL], element, evaluate(LINEAR, xi))
    return u, at_places(bent, element, evaluate(CUBIC, xi)), at_places(bent / h[..., None], element, slopes)


def stretch_of(system: System, response: ElasticResponse) -> Array:
    """Length of each element's axis over that before, ``(angles or 1, elements)``: 1 where strains are not exact.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    """
    if system.terms.law is None:
        return np.ones((1, len(system.beams.mesh.cell)))
    return system.terms.law.on_elements.stretch(system.to_links(response.displacement))


def of_bent_axis(
    system: System, response: ElasticResponse, ends: Array, loads: Sequence[PointLoad], element: Index, xi: Array
) -> tuple[Array, Array]:
    """Give what moments and displacements along members differ as axes are bent, ``(angles, places)`` each.

    Along the arc the moment changes by ``V c + N b``, with the force N along the member's straight line, V across it,
    and the sine b and cosine c of the rotation. Here that is ``V (c - 1) + n b``, with what N differs from its mean
    over the element, n. A moment at a node is that on b, and so c times the one on the rotation. The displacement
    along the member has the shortening up to a place, where the element's function has its mean. Where rotations are
    small, c is 1.

    Parameters are those of `statics`.
    """
    h, law, v = system.beams.mesh.cell_length, system.terms.law, system.to_links(response.displacement)
    inner = np.asarray(np.outer(xi, (PLACES + 1) / 2).ravel(), dtype=np.float64)
    of = np.repeat(element, len(PLACES))
    stretch = stretch_of(system, response)
    nodal = system.beams.layout.hermite_dofs(v, stretch)
    slope = by_shape_functions(nodal, h * stretch, of, inner)[2]
    along = (h * stretch)[:, element] * xi
    change = _up_to(beyond_mean(system, response, of, inner, loads) * slope, along)
    if law is None:
        return change, np.zeros_like(change)
    refuse_turned(system, of, slope)
    shear, arm = statics(system, response, ends, loads, of, inner)[1], _arm(slope)
    longer = law.on_elements.shortening(v, stretch)[:, element]  # of whole elements
    change += _up_to(shear * arm, along) - ends[:, element, 2] * _arm(nodal[:, element, 2])
    return change, _up_to(arm, along) + longer * xi


def refuse_turned(system: System, element: Index, sine: Array) -> None:
    """Refuse axes that turn by 90 degrees or more inside elements: mesh, steps or theory do not suffice.

    Parameters
    ----------
    system
        The mechanism.
    element
        Element of each place, ``(places,)``.
    sine
        Sines of the rotations, ``(angles, places)``.

    Raises
    ------
    UnresolvedError
        It names the first angle, and the member.
    """
    if (beyond := np.argwhere(~(np.abs(sine) < 1))).size:  # there the stretch has no number
        k, place = beyond[0]
        mesh = system.beams.mesh
        name = mesh.members[mesh.cell_member[element[place]]]
        raise UnresolvedError(system.turned_too_far(k, f"axis of member {name}"))


def _up_to(values: Array, length: Array) -> Array:
    """Integrals over lengths, ``(angles, places)``, of values at `PLACES` of each, ``(angles, places x PLACES)``."""
    return np.asarray((values.reshape(len(values), -1, len(PLACES)) @ WEIGHTS) / 2 * length)


def _arm(slope: Array) -> Array:
    """Cosine of a rotation less 1, from its sine."""
    return np.asarray(np.sqrt(1 - slope**2) - 1)


def beyond_mean(
    system: System, response: ElasticResponse, element: Index, xi: Array, loads: Sequence[PointLoad] = ()
) -> Array:
    """What the axial forces that act on bent axes differ from their means over elements (N), ``(angles, places)``.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    element, xi
        Places 0..1 in elements, ``(places,)`` each.
    loads
        Loads at places inside elements.
    """
    given, count = system.terms.stiffening is not None, len(system.beams.mesh.cell)
    if given:  # they are those of loads and rigid motion, with the slope that they are given with
        response, loads = replace(response, inertia=system.rigid_acceleration, rotation=None), ()
    all_elements, all_places = np.repeat(np.arange(count), len(PLACES)), np.tile((PLACES + 1) / 2, count)
    everywhere = _carried(system, response, all_elements, all_places, loads)
    everywhere = everywhere.reshape(-1, count, len(PLACES))
    found = _carried(system, response, element, xi, loads) - (everywhere @ WEIGHTS / 2)[:, element]
    if given:
        own = 3 / 2 * everywhere @ (WEIGHTS * PLACES)
        found += (sum(part.force for part in system.terms.uneven) - own)[:, element] * (2 * xi - 1)
    return np.asarray(found)


def _carried(system: System, response: ElasticResponse, element: Index, xi: Array, loads: Sequence[PointLoad]) -> Array:
    """Axial force at places of elements less that at their starts (N), ``(angles, places)``."""
    h = system.beams.mesh.cell_length[element]
    along = inertia_of(system, response, np.arange(len(system.beams.mesh.cell)))[0]
    own = h * at_places(along, element, mass_up_to(system.beams, element, xi)[0])
    return own + sum(load.beyond(element, xi, h)[0] for load in spread_and_point_loads(system, loads))
