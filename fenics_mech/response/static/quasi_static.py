"""Quasi-static response: the elastic mechanism under the inertia of its rigid motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech._sparse import SingularError, Stack
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import elastic_forces
from fenics_mech.mechanism import RigidModes, System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices, not_positive
from fenics_mech.mechanism.spin_tangents import turning_forces
from fenics_mech.response.periodic.newton import Orbit, solve_nonlinear
from fenics_mech.response.static.equilibrium import STATIC, losses, naming_buckled, refuse_buckled, refuse_lost


def solve_static(system: System, rigid: RigidModes | None = None) -> ElasticResponse:
    """Solve ``K q = f`` at every angle.

    A nonlinear law is solved for by Newton's method. Where rigid-body modes are left, the links accelerate by what of
    the load is not in equilibrium, and q is what their own inertia leaves (inertia relief).

    Parameters
    ----------
    system
        The mechanism.
    rigid
        Motions in which the links accelerate; by default those of `RigidModes.giving_way`.

    Raises
    ------
    SolverError
        When Newton's method does not converge at some angle, or the mechanism buckles or has no stiffness there.
    """
    if system.terms.law is not None:
        return _solve_nonlinear(system)
    if len(rigid := RigidModes.giving_way(system) if rigid is None else rigid):
        return _relieved(system, rigid)
    q = displacement_under(system, system.load, STATIC.largest_loss)
    return ElasticResponse(displacement=q, inertia=system.rigid_acceleration)


def yielding_to(system: System, load: Array) -> Array:
    """Give the q of ``K q = load`` at every angle, with inertia relief where rigid-body modes are left.

    Parameters
    ----------
    system
        The mechanism.
    load
        The load (N, N m), ``(angles, coordinates)``.

    Returns
    -------
    numpy.ndarray
        Of the shape of the load.

    Raises
    ------
    SolverError
        As of `displacement_under`.
    """
    if len(rigid := RigidModes.giving_way(system)):
        return np.array([rigid.relieved(part)[0] for part in load])
    return displacement_under(system, load)


def displacement_under(system: System, load: Array, lost: float = math.inf) -> Array:
    """Give the q of ``K q = load`` at every angle, of the shape of the load.

    Parameters
    ----------
    system
        The mechanism.
    load
        The load (N, N m), ``(angles, coordinates)``.
    lost
        Share of the answer that rounding may take.

    Raises
    ------
    SolverError
        When the mechanism has no stiffness at some angle or buckles there, or rounding takes more of an answer.
    """
    if not load.size:  # both ends of the only element are held
        return load.copy()
    stiffness = system.held_stiffness
    if system.terms.stiffening is not None:
        _refuse_buckled(system, stiffness)
    try:
        answer = stiffness.solve(load)
    except SingularError as error:
        angle = np.degrees(system.motion.theta[error.position])
        raise SolverError(
            f"no static answer at drive angle {angle:.6g} deg: nothing resists some motion of the links there"
        ) from error
    rounded = losses(stiffness, answer, load)
    if lost < math.inf:
        refuse_lost(system, answer, rounded, lost)
    linear = system.with_terms(replace(system.terms, law=None))  # as K is
    return _refined(Equation(linear), answer, load, rounded, lambda q: stiffness)


def _refined(equation: Equation, q: Array, load: Array, rounded: Array, tangent: Callable[[Array], Stack]) -> Array:
    """Refine answers by the part of the load that they leave over (Wilkinson, 1963), where rounding takes enough.

    Where it takes too much they would get worse. `rounded` is the share that it takes, ``(angles,)``, and `tangent`
    gives the stiffness about an answer.
    """
    if equation.system.beams.reduction is None and STATIC.refined < rounded.max(initial=0.0) <= STATIC.largest_loss:
        for _ in range(STATIC.refinements):
            q = q + tangent(q).solve(load - _resistance(equation, q))
    return q


def _resistance(equation: Equation, q: Array) -> Array:
    """Give the forces that hold q (N, N m), ``(angles, coordinates)``, with the strain of each element."""
    system, v, still = equation.system, equation.system.to_links(q), np.zeros_like(q)
    elastic = elastic_forces(system, v)
    for part in system.added_stiffness:
        elastic += part.times(v)
    found = system.on_coordinates(elastic)
    for forces in turning_forces(equation, (q, still, still)):
        found += forces
    return found


def _refuse_buckled(system: System, stiffness: Stack) -> None:
    """Raise where a tangent stiffness is not positive."""
    for k in not_positive(stiffness):
        refuse_buckled(system, int(k), stiffness.dense(k))


def _relieved(system: System, rigid: RigidModes) -> ElasticResponse:
    """Solve beside rigid-body modes, which are the same at all positions as nothing is driven."""
    if system.terms.stiffening is not None:
        refuse_buckled(system, 0, rigid.elastic())
    q, acceleration = (np.array(parts) for parts in zip(*map(rigid.relieved, system.load)))
    return ElasticResponse(displacement=q, inertia=system.rigid_acceleration + system.to_links(acceleration))


def _solve_nonlinear(system: System) -> ElasticResponse:
    """Solve ``K q + law = f`` at every angle."""
    law = system.terms.law
    assert law is not None
    linear = replace(system, terms=replace(system.terms, law=None))
    start = solve_static(linear).displacement
    equation = Equation(held_still(system))
    still = np.zeros_like(start)
    tension = law.axial(equation.in_links(start, still)[0])

    def solve(matrices: Matrices) -> Orbit:
        found = matrices.stiffness.solve(matrices.load)
        return Orbit(found, still, still, found, still)

    def accept(tangents: Matrices) -> None:
        _refuse_buckled(system, tangents.stiffness)

    with naming_buckled(equation, tension), _naming_share():
        found = solve_nonlinear(equation, solve, tension, accept, lambda tension: _lowered(equation, tension))
    rounded = losses(equation.linear.stiffness, start, system.load)
    return ElasticResponse(
        displacement=_refined(
            equation, found.displacement, system.load, rounded, lambda q: equation.about(q, still).stiffness
        ),
        inertia=system.rigid_acceleration,
        velocity=np.zeros_like(system.rigid_acceleration),
    )


def held_still(system: System) -> System:
    """Give the mechanism whose links do not vibrate: of the coupling, what dampers feel of displaced ends is left.

    Parameters
    ----------
    system
        The mechanism.
    """
    terms, matrices = system.terms, system.terms.matrices
    if terms.coupled:
        matrices = replace(matrices, follower=matrices.follower + matrices.convective, convective=())
    return system.with_terms(replace(terms, coupled=False, matrices=matrices))


@contextmanager
def _naming_share() -> Iterator[None]:
    """Add to a `SolverError` up to which share of the load there are equilibria."""
    try:
        yield
    except SolverError as error:
        if not (share := error.found_up_to):
            raise
        named = type(error)(f"{error}. There are equilibria up to {share:.3g} of the load")
        named.found_up_to = share
        raise named from error.__cause__


def _lowered(equation: Equation, tension: Array) -> Array:
    """Lower a tension to below its buckling load: close to it, the smallest load across bends the members far.

    The stiffness is linear in the tension, K without any and K_1 under the whole. With the least eigenvalue of
    ``K_1 x = lambda K x`` it is singular under the share ``1/(1 - lambda)``, and the next power of
    `STATIC.smaller` is below.

    Raises
    ------
    SolverError
        Where the stiffness is not positive without any tension of the members.
    """
    whole = equation.straight(tension).stiffness
    if not len(buckled := not_positive(whole)):
        return tension
    free, share = equation.straight(np.zeros_like(tension)).stiffness, np.ones((len(tension), 1))
    for k in buckled:
        refuse_buckled(equation.system, int(k), free.dense(k))
        (least,) = eigh(whole.dense(k), free.dense(k), eigvals_only=True, subset_by_index=(0, 0))
        share[k] = STATIC.smaller ** (math.floor(math.log1p(-min(least, 0.0)) / -math.log(STATIC.smaller)) + 1)
    return share * tension
