"""Quasi-static response: the elastic mechanism under the inertia of its rigid motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech._petsc import DIRECT, PETSc, configured, name_of, to_scipy
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import RigidModes, System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices, not_positive
from fenics_mech.response.periodic.newton import Orbit, solve_nonlinear
from fenics_mech.response.static.equilibrium import STATIC, loss, naming_buckled, refuse_buckled, refuse_lost


def solve_static(
    system: System, options: Mapping[str, Any] | None = None, rigid: RigidModes | None = None
) -> ElasticResponse:
    """Solve ``K q = f`` at every angle.

    A nonlinear law is solved for by Newton's method. Where rigid-body modes are left, the links accelerate by what of
    the load is not in equilibrium, and q is what their own inertia leaves (inertia relief).

    Parameters
    ----------
    system
        The mechanism.
    options
        PETSc options with the prefix "static_".
    rigid
        Motions in which the links accelerate; by default those of `RigidModes.giving_way`.

    Raises
    ------
    SolverError
        When the KSP or Newton's method does not converge at some angle, or the mechanism buckles there.
    """
    if system.terms.law is not None:
        return _solve_nonlinear(system, options)
    if len(rigid := RigidModes.giving_way(system) if rigid is None else rigid):
        return _relieved(system, rigid)
    q = displacement_under(system, system.load, options, STATIC.largest_loss)
    return ElasticResponse(displacement=q, inertia=system.rigid_acceleration)


def yielding_to(system: System, load: Array, options: Mapping[str, Any] | None = None) -> Array:
    """Give the q of ``K q = load`` at every angle, with inertia relief where rigid-body modes are left.

    Parameters
    ----------
    system
        The mechanism.
    load
        The load (N, N m), ``(angles, coordinates)``.
    options
        PETSc options with the prefix "static_".

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
    return displacement_under(system, load, options)


def displacement_under(
    system: System, load: Array, options: Mapping[str, Any] | None = None, lost: float = math.inf
) -> Array:
    """Give the q of ``K q = load`` at every angle, of the shape of the load.

    Parameters
    ----------
    system
        The mechanism.
    load
        The load (N, N m), ``(angles, coordinates)``, or of several ``(angles, coordinates, loads)``.
    options
        PETSc options with the prefix "static_".
    lost
        Share of the answer that rounding may take; for several loads it may take any.

    Raises
    ------
    SolverError
        When the KSP does not converge at some angle, the mechanism buckles there, or rounding takes more of an answer.
    """
    answer, losses = np.empty_like(load), np.zeros(len(load))
    if not answer.size:  # both ends of the only element are held
        return answer
    ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
    force = PETSc.Vec().createSeq(system.size)
    displacement = force.duplicate()
    with configured(ksp, "static_", DIRECT, options or {}):
        for k, _, stiffness in system.positions():
            if system.terms.stiffening is not None:
                refuse_buckled(system, k, to_scipy(stiffness).toarray())
            ksp.setOperators(stiffness)
            for part, found in zip(load[k].reshape(system.size, -1).T, answer[k].reshape(system.size, -1).T):
                force.array[:] = part
                ksp.solve(force, displacement)
                if ksp.getConvergedReason() <= 0:
                    reason = name_of(PETSc.KSP.ConvergedReason, ksp.getConvergedReason())
                    angle = np.degrees(system.motion.theta[k])
                    raise SolverError(f"no static answer at drive angle {angle:.6g} deg (PETSc says {reason})")
                found[:] = displacement.array_r
            if lost < math.inf:
                losses[k] = loss(stiffness, answer[k], load[k])
    refuse_lost(system, answer, losses, lost)
    return answer


def _relieved(system: System, rigid: RigidModes) -> ElasticResponse:
    """Solve beside rigid-body modes, which are the same at all positions as nothing is driven."""
    if system.terms.stiffening is not None:
        refuse_buckled(system, 0, rigid.elastic())
    q, acceleration = (np.array(parts) for parts in zip(*map(rigid.relieved, system.load)))
    return ElasticResponse(displacement=q, inertia=system.rigid_acceleration + system.to_links(acceleration))


def _solve_nonlinear(system: System, options: Mapping[str, Any] | None) -> ElasticResponse:
    """Solve ``K q + law = f`` at every angle."""
    linear = replace(system, terms=replace(system.terms, law=None))
    start = solve_static(linear, options).displacement
    equation = Equation(replace(system, terms=replace(system.terms, coupled=False)))
    still = np.zeros_like(start)
    tension = equation.predicted_tension(still, still, start, still)

    def solve(matrices: Matrices) -> Orbit:
        found = matrices.stiffness.solve(matrices.load)
        return Orbit(found, still, still, found, still)

    def accept(tangents: Matrices) -> None:
        for k in not_positive(tangents.stiffness):
            refuse_buckled(system, int(k), tangents.stiffness.dense(k))

    with naming_buckled(equation, tension):
        found = solve_nonlinear(equation, solve, tension, accept, lambda tension: _lowered(equation, tension))
    return ElasticResponse(
        displacement=found.displacement,
        inertia=system.rigid_acceleration,
        velocity=np.zeros_like(system.rigid_acceleration),
    )


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
