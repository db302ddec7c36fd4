"""Whether an equilibrium is one: stable, and not lost to rounding."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.effects import AddedMatrices
from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import looked_at, not_positive


@dataclass(frozen=True)
class StaticLimits:
    """Limits of positions in equilibrium."""

    largest_loss: float = 1e-3  # of an answer by rounding; measured, the estimate is up to 20 times the true loss
    refined: float = 1e-9  # estimated loss from which answers are refined, as the true one may be 16 times as large
    refinements: int = 3  # measured, each leaves a fiftieth of the loss, or less
    smaller: float = 0.95  # of a tension that buckles, until it does not


STATIC = StaticLimits()


def refuse_buckled(system: System, k: int, stiffness: Array) -> None:
    """Raise where a stiffness is not positive: the equilibrium is not stable.

    Parameters
    ----------
    system, k
        The mechanism, and the number of the angle.
    stiffness
        Its tangent stiffness there, ``(coordinates, coordinates)``.

    Raises
    ------
    SolverError
        With the drive angle, and the link that bends most as the mechanism gives way.
    """
    try:
        np.linalg.cholesky(stiffness + stiffness.T)
    except np.linalg.LinAlgError:
        raise SolverError(
            f"the mechanism buckles at drive angle {np.degrees(system.motion.theta[k]):.6g} deg: under its axial "
            f"forces its stiffness is not positive, and link {_weakest_link(system, k, stiffness)} gives way. Lower "
            f"the load or the speed, or take stiffer members. The effect {LARGE_ROTATIONS.name!r} finds a buckled "
            "shape, if a small load across the members determines to which side they buckle"
        ) from None


@contextmanager
def naming_buckled(equation: Equation, tension: Array | None) -> Iterator[None]:
    """Add to a `SolverError` which straight link buckles, where one does.

    Parameters
    ----------
    equation
        The equation that is solved.
    tension
        Axial forces (N), ``(angles, elements)``; None where the equation is linear and has them in its stiffness.

    Raises
    ------
    SolverError
        Of the class of the first one, with link and drive angle.
    """
    try:
        yield
    except SolverError as error:
        is_named = isinstance(error.__cause__, SolverError)  # by the steps of a motion to begin from
        if is_named or (found := _buckled(equation.system, tension)) is None:
            raise
        k, link = found
        named = type(error)(
            f"{error}. The straight link {link} buckles: under its axial forces the stiffness is not positive at drive "
            f"angle {np.degrees(equation.system.motion.theta[k]):.6g} deg"
        )
        named.found_up_to = error.found_up_to
        raise named from error


def _buckled(system: System, tension: Array | None) -> tuple[int, str] | None:
    """Angle and link at which axial forces alone make the stiffness of the links and springs not positive.

    The whole stiffness also holds inertia and the damping's force by the turning of the links, which bend no link.
    """
    terms = replace(system.terms, coupled=False, matrices=AddedMatrices(stiffness=system.terms.matrices.stiffness))
    equation = Equation(replace(system, terms=terms))
    if tension is None:
        loaded, free = equation.linear, Equation(replace(system, terms=replace(terms, stiffening=None))).linear
    else:
        loaded, free = equation.straight(tension), equation.straight(np.zeros_like(tension))
    by_axial_forces = np.setdiff1d(not_positive(loaded.stiffness), not_positive(free.stiffness))
    if not len(among := looked_at(by_axial_forces, system.size)):
        return None
    k = int(min(among, key=lambda k: np.linalg.eigvalsh(loaded.stiffness.dense(k))[0]))
    return k, _weakest_link(system, k, loaded.stiffness.dense(k))


def _weakest_link(system: System, k: int, stiffness: Array) -> str:
    """Link that bends most in the shape that a stiffness ``(coordinates, coordinates)`` at angle k resists least."""
    return system.bent_most(k, np.linalg.eigh(stiffness + stiffness.T)[1][:, 0])


def losses(stiffness: Stack, q: Array, force: Array) -> Array:
    """Give the share of each answer of ``K q = f`` that rounding of K may change, ``eps |q| |K| |q| / (q f)``.

    It is large where q strains the links far less than its parts alone would. Examples are positions next to a dead
    centre, members that are far stiffer along than across, and fine meshes. Source: Skeel, J. ACM 26 (1979) 494.

    Parameters
    ----------
    stiffness
        K at all angles.
    q
        The answers (m, rad), ``(angles, coordinates)``.
    force
        The load f (N, N m), of the same shape.

    Returns
    -------
    numpy.ndarray
        ``(angles,)``; 0 where nothing is done on the links.
    """
    energy, size = np.abs(np.sum(q * force, axis=1)), np.abs(q)
    rounded = np.finfo(float).eps * np.sum(size * stiffness.magnitude.times(size), axis=1)
    return np.divide(rounded, energy, out=np.zeros_like(energy), where=energy > 0)


def refuse_lost(system: System, q: Array, losses: Array, largest: float) -> None:
    """Raise where rounding has taken more than the largest share of an answer.

    Parameters
    ----------
    system
        The mechanism.
    q, losses
        The answer at all angles, ``(angles, coordinates)``, and its loss, ``(angles,)``.

    Raises
    ------
    SolverError
        With the drive angle, and the point that moves most.
    """
    k = int(losses.argmax())
    if losses[k] <= largest:
        return
    point = system.beams.mesh.node_name[int(np.hypot(*system.nodes_at(k, q[k])[:, :2].T).argmax())]
    raise SolverError(
        f"the static answer is lost to rounding at drive angle {np.degrees(system.motion.theta[k]):.10g} deg: "
        f"{losses[k]:.1e} of it, by estimate, largest at {point}. Keep away from dead centres, where the links do not "
        "hold that point. Or take members less stiff along than across, fewer elements, or reduction = 'craig-bampton'"
    )
