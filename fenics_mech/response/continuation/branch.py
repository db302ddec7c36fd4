"""Periodic motions of a scene along a branch, over one number of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects import active
from fenics_mech.effects.impulses import EFFECT as IMPULSES
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.mechanism.damping_factors import FullFactor
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.mechanism.modal_forces import ModalForces
from fenics_mech.response.continuation.arc_length import BRANCH, Family, Point, paced
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.periodic.collocation import solve_collocation
from fenics_mech.response.periodic.cycle import Cycle, system_at_places
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import CommonParts, mechanism, rough_tension
from fenics_mech.response.solution import CollocationSolution
from fenics_mech.scene import Analysis, Drive, Impulse, Scene

AtValue = Callable[[float], Scene]


def refuse_unfollowable(analysis: Analysis, drives: Sequence[Drive], impulses: Mapping[str, Impulse]) -> None:
    """Raise a `SceneError` unless collocation finds the steady state of a scene by its own equation alone.

    Parameters
    ----------
    analysis
        Method, solver and tension of the scene.
    drives
        Its drives.
    impulses
        Its impulses by name.
    """
    settling, motor = analysis.tension == "settled", any(drive.motor for drive in drives)
    by_others = analysis.solver not in ("auto", "collocation")
    refused = (
        (analysis.method != "periodic" or not drives, "analysis.method", "only periodic motions are followed"),
        (by_others, "analysis.solver", f"a branch is followed by collocation, not by {analysis.solver}"),
        (motor, "drive.motor", "a branch is followed without a motor's shaft"),
        (bool(impulses), IMPULSES.name, "a branch is followed without impulses"),
        (settling, "analysis.tension", "a branch has large rotations in place of settled tension"),
    )
    for found, place, message in refused:
        if found:
            raise SceneError(message, place=place)


def family_of(at: AtValue, path: str, ends: tuple[float, float], common: CommonParts | None = None) -> Family:
    """Give the equation of a scene over a number of it.

    Parameters
    ----------
    at
        Gives the scene with a value of the number.
    path
        The number's dotted path in the scene.
    ends
        Its range.
    common
        What the scenes have in common.

    Raises
    ------
    SceneError
        When the drive does not keep its sense over the range, or loads jump or have corners elsewhere.
    """
    at = lru_cache(maxsize=8)(at)
    scene = at(ends[0])
    if scene.cycle_rate * at(ends[1]).cycle_rate < 0:
        raise SceneError("the drive must keep its sense of turning over the range", place=path)
    tableau, steps = Tableau.of_analysis(scene.analysis), Steps.of(scene)
    common = common or CommonParts()
    if not np.array_equal(steps.start, Steps.of(at(ends[1])).start):
        raise SceneError("the angles at which a load jumps or has corners must stay over the range", place=path)

    def equation_at(value: float) -> Equation:
        changed = at(value)
        there = system_at_places(changed, mechanism(changed, common=common), Steps.of(changed), tableau.points)
        return Equation(there, modal_damping(changed.damping.ratio, there))

    stiffened = any(effect.stress_stiffening and not effect.nonlinear for effect in active(scene))
    polynomial = not (stiffened and np.any(scene.damping.ratio))  # modal damping goes with the root of the stiffness
    if polynomial and len(scene.drives) == 1 and path.rpartition(".")[2] in ("speed", "period"):
        turning = Turning.between(equation_at, at, ends)
        at_value: Callable[[float], Equation] = lambda value: turning.at_rate(at(value).cycle_rate)  # noqa: E731
    else:
        names = equation_at(ends[0]).system.transformation.names

        def at_value(value: float) -> Equation:
            equation = equation_at(value)
            if equation.system.transformation.names != names:
                raise SolverError(
                    "no independent coordinates are well conditioned over the whole range: follow it in parts"
                )
            return equation

    return Family(
        at=lru_cache(maxsize=3)(at_value),
        rate=lambda value: abs(at(value).cycle_rate),
        ends=ends,
        tableau=tableau,
        step=steps.duration * abs(scene.cycle_rate),
        options=scene.petsc,
    )


@dataclass(frozen=True)
class _Known(Equation):
    """An equation of motion whose linear part and whose nonzeros of P, P', P'' are known already."""

    matrices: Matrices = field(kw_only=True)
    nonzeros: tuple[Array, Array, Array] = field(kw_only=True)

    @cached_property
    def linear(self) -> Matrices:
        """The linear part."""
        return self.matrices

    @cached_property
    def jets(self) -> tuple[Array, Array | None, Array | None]:
        """Nonzeros of P, P' and P'' at all angles."""
        p, first, second = self.nonzeros
        return (p, first, second) if self.coupled else (p, None, None)

    @cached_property
    def turned(self) -> Array:
        """Nonzeros of P' at all angles."""
        return self.nonzeros[1]


@dataclass(frozen=True)
class Turning:
    """The equation of motion at any rate of the drive, from that at three of them.

    The rigid motion has velocities that grow with the rate and accelerations that grow with its square. All matrices
    and loads are polynomials of second degree in it, but the modal damping of modes that axial forces stiffen.

    Parameters
    ----------
    equation
        The equation at one rate.
    unit
        The rate (rad/s) by which rates are divided in the polynomials.
    powers
        Coefficients of the arrays of `_arrays_of`, with the power that each belongs to.
    """

    equation: Equation
    unit: float
    powers: tuple[tuple[tuple[int, Array], ...], ...]

    @classmethod
    def between(cls, equation_at: Callable[[float], Equation], at: AtValue, ends: tuple[float, float]) -> Turning:
        """Build it from the equation at the ends and in the middle of a range.

        Parameters
        ----------
        equation_at
            Gives the equation with a value of the number.
        at
            Gives the scene with a value of the number.
        ends
            Range of the number.
        """
        values = (ends[0], (ends[0] + ends[1]) / 2, ends[1])
        equations, rates = [equation_at(value) for value in values], [at(value).cycle_rate for value in values]
        samples = [_arrays_of(each) for each in equations]
        weights: Array = np.linalg.inv(np.vander(np.array(rates) / rates[0], increasing=True)).astype(np.float64)
        return cls(equations[0], rates[0], tuple(_powers(weights, arrays) for arrays in zip(*samples)))

    def at_rate(self, rate: float) -> Equation:
        """Give the equation at a rate of the drive coordinate.

        Parameters
        ----------
        rate
            The rate (rad/s), with its sign.
        """
        arrays = [_polynomial(powers, rate / self.unit) for powers in self.powers]
        linear = self.equation.linear
        parts = zip((linear.mass, linear.damping, linear.stiffness), arrays)
        mass, damping, stiffness = (replace(stack, values=values) for stack, values in parts)
        load, p, first, second, *of_modes = arrays[3:]
        factor = of_modes[0] if of_modes else None
        modal = None if factor is None else ModalForces(factor, factor, of_modes[1])
        return _Known(
            self.equation.system,
            None if factor is None else FullFactor(factor),
            matrices=Matrices(mass, damping, stiffness, load, modal),
            nonzeros=(p, first, second),
        )


def _arrays_of(equation: Equation) -> list[Array]:
    """Nonzeros of M, C and K, the load, nonzeros of P, P' and P'', and where modes are damped F and H."""
    linear, (p, _, second) = equation.linear, equation.jets
    found = [linear.mass.values, linear.damping.values, linear.stiffness.values, linear.load]
    found += [p, equation.turned, np.zeros(0) if second is None else second]
    return found if linear.modal is None else [*found, linear.modal.outward, linear.modal.by_place]


def _polynomial(powers: Sequence[tuple[int, Array]], x: float) -> Array:
    """Give a polynomial's value from its coefficients."""
    value = np.zeros_like(powers[0][1])
    for power, array in powers:
        value += x**power * array
    return value


def _powers(weights: Array, arrays: Sequence[Array]) -> tuple[tuple[int, Array], ...]:
    """Give the coefficients of a polynomial from its values, those that are not mere rounding."""
    found = [sum(factor * array for factor, array in zip(row, arrays)) for row in weights]
    sizes = [float(np.abs(array).max(initial=0.0)) for array in found]
    kept = [power for power, size in enumerate(sizes) if size > BRANCH.negligible * max(sizes)] or [0]
    return tuple((power, found[power]) for power in kept)


def first_motion(scene: Scene, family: Family) -> Point:
    """Find the motion at the start of the range, as an analysis of the scene there does.

    Parameters
    ----------
    scene
        The scene with the value at the start of the range.
    family
        Its equation over the number.

    Raises
    ------
    SolverError
        When Newton's method does not converge.
    """
    value = family.ends[0]
    equation, steps = family.at(value), Steps.of(scene)
    law = equation.system.terms.law
    tension = rough_tension(scene, equation.system)
    orbit = solve_collocation(equation, family.tableau, steps.duration, scene.petsc, tension)
    if law is None or tension is None:
        tension = np.zeros(0)
    else:
        tension = law.tension(*equation.in_links(orbit.displacement, orbit.velocity))
    return Point(value, paced(orbit, 1 / family.rate(value)), tension)


def solution_at(scene: Scene, point: Point, common: CommonParts | None = None) -> CollocationSolution:
    """Give the response of a point with its Floquet multipliers, stable or not.

    Parameters
    ----------
    scene
        The scene with the point's value of the number.
    point
        The point.
    common
        What it may have in common with other points.
    """
    system = mechanism(scene, common=common)
    modes = solve_modes(system, scene.analysis.modes, scene.petsc)
    cycle, orbit = Cycle(scene, system), paced(point.orbit, abs(scene.cycle_rate))
    motion = cycle.motion(orbit)
    orbit = replace(orbit, flow=cycle.flow(cycle.tableau, motion))
    equation, response = cycle.at_starts(orbit)
    return CollocationSolution(
        scene=scene,
        system=system,
        response=response,
        modes=modes,
        stability=cycle.multipliers(modes, motion),
        cycle=cycle,
        equation=equation,
        orbit=orbit,
    )
