"""Inertia of sections whose axes turn far, and forces on their rotations: over the coordinates q, with tangents."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.mechanism.matrices import Matrices

if TYPE_CHECKING:
    from fenics_mech._sparse import Stack
    from fenics_mech.mechanism.equation import Equation


def turning_forces(equation: Equation, state: tuple[Array, Array, Array], share: float = 1.0) -> Iterator[Array]:
    """Give what linear parts lack of forces on rotations and of the sections' inertia where axes turn far.

    Parameters
    ----------
    equation
        The equation of motion.
    state
        q, q' and q'', ``(angles, coordinates)`` each.
    share
        Of the forces on rotations.

    Yields
    ------
    numpy.ndarray
        Forces on the coordinates (N, N m), ``(angles, coordinates)``; none where slopes are small.
    """
    system = equation.system
    if (forces := system.rotation_forces) is not None:
        yield equation.to_coordinates(forces.scaled(share).force(*equation.in_links(*state[:2])), forces.dofs)
    if (spin := system.spin) is not None:
        yield equation.to_coordinates(spin.force(*equation.state_in_links(*state), system.motion.alpha), spin.dofs)


def with_spin(equation: Equation, matrices: Matrices, state: tuple[Array, Array, Array]) -> Matrices:
    """Add the inertia of sections whose axes turn far, linearised about a state; nothing where there is none.

    With ``v = P q`` the derivatives of q count in those of v as in the equation of motion.

    Parameters
    ----------
    equation
        The equation of motion.
    matrices
        M, C, K and the load without this inertia.
    state
        q, q' and q'', ``(angles, coordinates)`` each.
    """
    spin, (p, first, second) = equation.system.spin, equation.jets
    if spin is None:
        return matrices
    products, places = equation.of_law, places_of(spin.dofs)
    constant, *tangents = spin.linearised(*equation.state_in_links(*state), equation.system.motion.alpha)
    k, d, m = (products.values_of(*places, part.reshape(len(p), -1)) for part in tangents)
    moved = () if first is None or second is None else ((d, first), (m, second))
    found = (
        products.products(p, (m, p)),
        products.products(p, (d, p), *(() if first is None else ((2 * m, first),))),
        products.products(p, (k, p), *moved),
    )
    parts = matrices.mass, matrices.damping, matrices.stiffness
    mass, damping, stiffness = (old + new.on(old.pattern) for old, new in zip(parts, found))
    load = matrices.load - equation.to_coordinates(constant, spin.dofs)
    return replace(matrices, mass=mass, damping=damping, stiffness=stiffness, load=load)


def mass_with_spin(equation: Equation, q: Array) -> Stack:
    """Give M with this inertia at a displacement.

    Parameters
    ----------
    equation
        The equation of motion.
    q
        Coordinates, ``(angles, coordinates)``.
    """
    spin, p, mass = equation.system.spin, equation.jets[0], equation.linear.mass
    if spin is None:
        return mass
    of_sections = spin.mass(equation.system.transformation.forward(p, q)).reshape(len(p), -1)
    products = equation.of_law
    return mass + products.products(p, (products.values_of(*places_of(spin.dofs), of_sections), p)).on(mass.pattern)


def places_of(dofs: Index) -> tuple[Index, Index]:
    """Rows and columns of blocks over the links' coordinates `dofs`, ``(blocks, n)``."""
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    return rows.ravel(), columns.ravel()
