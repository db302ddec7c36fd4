"""Section forces inside elements by statics, from the forces on their ends and what acts between these."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fenics_mech._arrays import Array, Index, at_places
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.shapes import evaluate, integral
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_loads import PointLoad, SpreadLoad, applied_inside
from fenics_mech.forces.inertia import SHAPES, by_mass_beside_axis, by_rotary_inertia, inertia_of, shear_number
from fenics_mech.forces.spinning_sections import spinning
from fenics_mech.mechanism import System


def statics(
    system: System, response: ElasticResponse, ends: Array, loads: Sequence[PointLoad], element: Index, xi: Array
) -> tuple[Array, Array, Array]:
    """N, V and M on the straight axes at places of elements, ``(angles, places)`` each.

    Parameters
    ----------
    system, response
        The mechanism, and a motion of it.
    ends
        Forces on the elements' ends in member axes, ``(angles, elements, 6)``.
    loads
        Loads at places inside elements.
    element, xi
        Places 0..1 in elements, ``(places,)`` each.
    """
    beams, h = system.beams, system.beams.mesh.cell_length[element]
    ends = ends.copy() if loads else ends
    for load in loads:
        ends[np.arange(len(ends)), load.element] -= load.at_ends(beams.mesh.cell_length[load.element])
    if beams.layout.offsets is not None:
        ends = beams.layout.offsets.on_neutral_line(ends)
    along, across = inertia_of(system, response, np.arange(len(beams.mesh.cell)))
    force_along, force_across, moment = (np.take(ends[..., part], element, axis=1) for part in range(3))  # first ends
    first, second = mass_up_to(beams, element, xi)
    axial = -force_along + h * at_places(along, element, first)
    shear = force_across - h * at_places(across, element, first)
    moment = -moment + force_across * xi * h - h**2 * at_places(across, element, second)
    for each_load in spread_and_point_loads(system, loads):
        axial, shear, moment = (a + b for a, b in zip((axial, shear, moment), each_load.beyond(element, xi, h)))
    if beams.inertia.rotary is not None:
        moment += by_rotary_inertia(system, response, beams.inertia.rotary, element, xi)[0]
    if (spun := spinning(system, response)) is not None:  # as if it were even along each element
        moment += spun[0].on_frames(*spun[1])[:, element] * xi
    if beams.mass_moment is not None:
        moment += by_mass_beside_axis(system, response, beams.mass_moment, element, xi)[0]
    return axial, shear, moment


def spread_and_point_loads(system: System, loads: Sequence[PointLoad]) -> tuple[PointLoad | SpreadLoad, ...]:
    """Give all loads inside elements: point loads, and those spread along them.

    Parameters
    ----------
    system
        The mechanism.
    loads
        Point loads beside its own.
    """
    line, points = system.terms.loads.line, (*loads, *applied_inside(system))
    if line is None:
        return points
    number, offsets = shear_number(system.beams), system.beams.layout.offsets
    return (*points, SpreadLoad(line, number, np.zeros_like(number) if offsets is None else offsets.neutral))


def mass_up_to(beams: Beams, element: Index, xi: Array) -> tuple[Array, Array]:
    """Integrals, and twice repeated integrals, of rho A times `SHAPES` from an element's start to places xi (kg/m).

    Each is ``(places, 6)``.

    Parameters
    ----------
    beams
        The links' matrices.
    element, xi
        Places 0..1 in elements, ``(places,)`` each.
    """
    if not beams.inertia.density.varies:
        rho_a = beams.inertia.density.mean[element, None]
        return rho_a * integral(SHAPES, xi), rho_a * integral(SHAPES, xi, 2)
    powers = beams.inertia.density.powers[element]
    points, weights = np.polynomial.legendre.leggauss(
        (powers.shape[-1] + 5) // 2
    )  # exact to twice the number, less one
    places = xi[:, None] * (1 + points) / 2
    share = weights / 2 * xi[:, None]
    share = share * np.einsum("sgp,sp->sg", places[..., None] ** np.arange(powers.shape[-1]), powers)
    shapes = evaluate(SHAPES, places)
    arm = xi[:, None] - places  # twice the integral of f up to xi is once that of (xi - t) f(t)
    return np.einsum("sg,sgj->sj", share, shapes), np.einsum("sg,sgj->sj", share * arm, shapes)
