"""The equation of motion of a scene over the steps of its cycle, and whether a motion of it is stable."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.eigenmodes import Modes, natural
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.forces.element_ends import axial_forces
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.damping_factors import DampingFactor
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.axial_forces import settles, with_axial_forces
from fenics_mech.response.damped_modes import damped_modes
from fenics_mech.response.modal_damping import FACTOR, DampedModes, KnownDamping, modal_damping
from fenics_mech.response.periodic.collocation import between
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.harmonic_balance import Series
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import system_at
from fenics_mech.response.stability.floquet import Stability, floquet
from fenics_mech.response.stability.resonance import blaming, refuse_magnified
from fenics_mech.response.stability.turning import LinkAxes
from fenics_mech.scene import Scene

States = Callable[[Array], tuple[Array, Array]]  # q and q' at places 0..1 in every step of the cycle


@dataclass(frozen=True, eq=False)
class Cycle:
    """The equation of motion of a scene at the collocation points of the steps of its cycle.

    Parameters
    ----------
    scene, system
        The scene, and its mechanism at the starts of the sub-intervals.
    damped_up_to
        As `enough` of `damped_modes`.
    shorter
        The same cycle by steps of which several make one of these, and whose damping of modes is taken.
    """

    scene: Scene
    system: System
    damped_up_to: float | None = None
    shorter: Cycle | None = None
    _equations: dict[Tableau, Equation] = field(default_factory=dict)
    _flows: dict[Tableau, Flow] = field(default_factory=dict)

    @cached_property
    def steps(self) -> Steps:
        """The sub-intervals, cut where something jumps."""
        return Steps.of(self.scene)

    @cached_property
    def tableau(self) -> Tableau:
        """The collocation points that the scene asks for."""
        return Tableau.of_analysis(self.scene.analysis)

    @property
    def weights(self) -> Array:
        """Weights of the points of `tableau` in a mean over the cycle, ``(steps x points,)``."""
        duration = self.steps.duration
        return np.outer(duration / duration.sum(), self.tableau.weights).ravel()

    @cached_property
    def start(self) -> Equation:
        """The equation at the starts of the sub-intervals."""
        return self.damped_equation(self.system)

    def damped_equation(self, system: System) -> Equation:
        """Give the equation of the mechanism at any angles, with the damping of its modes there.

        Parameters
        ----------
        system
            The mechanism at these angles.
        """
        return Equation(system, modal_damping(self.scene.damping.ratio, system, self.damped))

    @cached_property
    def damped(self) -> DampedModes | None:
        """Modes that are damped, where they are not all."""
        return damped_modes(self.scene, self.system, self.damped_up_to)

    @property
    def settling(self) -> bool:
        """Whether axial forces of the response act on it."""
        return settles(self.scene.analysis.tension, self.system.terms)

    @property
    def linear(self) -> bool:
        """Whether the equation does not depend on the motion."""
        return self.system.terms.law is None and not self.settling

    def at_points(self, tableau: Tableau) -> Equation:
        """Give the equation at collocation points of all steps.

        Parameters
        ----------
        tableau
            The points in each step.
        """
        if tableau not in self._equations:
            there = system_at_places(self.scene, self.system, self.steps, tableau.points)
            known = self._between_starts(there, tableau)
            self._equations[tableau] = self.damped_equation(there) if known is None else Equation(there, known)
        return self._equations[tableau]

    def _between_starts(self, there: System, tableau: Tableau) -> DampingFactor | None:
        """Give the damping of modes at points by that at equal positions; None where it is not smooth."""
        finer = self.shorter or self
        if finer.start.modal_damping is None or not (self.steps.regular.all() and finer.steps.regular.all()):
            return None
        if (known := finer._known_damping) is None:
            return None
        together = len(finer.steps.start) // len(self.steps.start)
        key = str(self.scene.damping.ratio), finer.damped, together * known.parts
        return natural(there).once("damping between", lambda: known.at(tableau.points, together), key)

    @cached_property
    def _known_damping(self) -> KnownDamping | None:
        """The damping of modes at the starts of equal steps, or of parts of them; None where these are too many."""
        factor = self.start.modal_damping
        assert factor is not None
        known = KnownDamping(factor, factor.unit(self.start))
        while known.enough_parts > 1 and (parts := known.parts * known.enough_parts) <= FACTOR.most_parts:
            there = system_at_places(self.scene, self.system, self.steps, np.arange(parts) / parts)
            closer = self.damped_equation(there).modal_damping
            assert closer is not None
            known = KnownDamping(closer, known.unit, parts)
        return known if known.enough_parts == 1 else None

    def flow(self, tableau: Tableau, motion: States | None = None) -> Flow:
        """Give the steps of the equation linearised about the motion (a linear one needs none).

        Parameters
        ----------
        tableau
            The points in each step.
        motion
            Gives q and q' at places 0..1 in every step; only the first motion of a kind of points counts.
        """
        if tableau not in self._flows:
            matrices = self._about(motion, tableau)
            self._flows[tableau] = Flow(matrices, tableau, self.steps.duration, self.scene.petsc)
        return self._flows[tableau]

    def forget(self, tableau: Tableau) -> None:
        """Free the memory of points that the motion was not solved at.

        Parameters
        ----------
        tableau
            The points in each step.
        """
        if tableau != self.tableau:
            self._flows.pop(tableau, None)
            self._equations.pop(tableau, None)

    def keep(self, flow: Flow) -> None:
        """Keep the steps that a motion was solved for with, as those linearised about it.

        Parameters
        ----------
        flow
            The steps.
        """
        self._flows.setdefault(flow.tableau, flow)

    def _about(self, motion: States | None, tableau: Tableau) -> Matrices:
        """Linearise about a motion at the collocation points of all steps."""
        equation = self.at_points(tableau)
        if self.linear or motion is None:
            return equation.linear
        q, rate = motion(tableau.points)
        return (self.stiffened(equation, q, rate) if self.settling else equation).about(q, rate)

    def _at_start(self, motion: States | None) -> Matrices:
        """Linear part of the equation at the starts of the sub-intervals."""
        return self.start.linear

    @staticmethod
    def stiffened(equation: Equation, q: Array, rate: Array) -> Equation:
        """Give the equation with the axial forces of a motion.

        Parameters
        ----------
        equation
            The equation of motion.
        q, rate
            q (m, rad) and q' (m/s, rad/s) at its angles, ``(angles, coordinates)`` each.
        """
        forces = axial_forces(equation.system, elastic_response(equation, q, rate))
        return Equation(with_axial_forces(equation.system, forces), equation.modal_damping)

    def at_starts(self, orbit: Orbit) -> tuple[Equation, ElasticResponse]:
        """Give the equation and the response at the starts of the sub-intervals.

        The equation has the axial forces of the motion where they act on it.

        Parameters
        ----------
        orbit
            The motion by collocation.
        """
        q, rate = orbit.start[self.steps.regular], orbit.start_velocity[self.steps.regular]
        equation = self.stiffened(self.start, q, rate) if self.settling else self.start
        return equation, elastic_response(equation, q, rate)

    def stability(self, modes: Modes, motion: States | None = None) -> Stability | None:
        """Judge a motion, if the scene wants it.

        Parameters
        ----------
        modes
            Modes at the starts of the sub-intervals.
        motion
            Gives q and q' at places 0..1 in every step; a linear equation needs none.

        Raises
        ------
        SolverError
            When it is unstable, or an equation that is the same for all motions has a resonance.
        """
        analysis = self.scene.analysis
        return self.judged(modes, motion, analysis.allow_unstable) if analysis.stability else None

    def judged(self, modes: Modes, motion: States | None, allow_unstable: bool) -> Stability:
        """Judge a motion.

        Parameters
        ----------
        modes, motion
            As of `stability`.
        allow_unstable
            Whether an unstable one passes.

        Raises
        ------
        SolverError
            As of `multipliers` and `stability`.
        """
        found = self.multipliers(modes, motion)
        if not allow_unstable:
            found.refuse_unstable()
        if self.linear:
            found.refuse_resonance()
        return found

    def multipliers(self, modes: Modes, motion: States | None) -> Stability:
        """Find the Floquet multipliers of a motion, stable or not.

        Parameters
        ----------
        modes, motion
            As of `stability`.

        Raises
        ------
        SolverError
            When a coordinate has almost no mass.
        """
        if self.massless is not None:
            raise SolverError(
                f"{self.massless} has almost no mass: rounding spoils the Floquet multipliers of its vibration. Give "
                "its link a density or a mass, or write analysis.stability = false"
            )
        gauss, radau = (Tableau.of(scheme, self.scene.analysis.stages) for scheme in ("gauss", "radau"))
        damped = partial(self.flow, radau, motion)
        flow = self.flow(gauss, motion)
        found = floquet(flow, self._at_start(motion), self.axes, modes, self.scene.petsc, damped)
        self.forget(gauss)
        return found

    @cached_property
    def axes(self) -> LinkAxes:
        """The links' axes at the starts of the steps."""
        if self.steps.regular.all():
            return LinkAxes.of(self.system, self.system.motion)
        return LinkAxes.of(self.system, solve_motion(self.scene, self.steps.start, near=self.system.motion))

    @cached_property
    def massless(self) -> str | None:
        """Coordinate whose own vibration turns so far in a step that its multipliers are lost to rounding."""
        mass, stiffness = (part.diagonal[0] for part in (self.start.linear.mass, self.start.linear.stiffness))
        heavy = np.flatnonzero(mass > 0)  # with lumped masses rotations have none
        frequency = np.sqrt(np.abs(stiffness[heavy] / mass[heavy]))
        too_fast = CYCLIC.fastest / float(np.max(self.steps.duration))
        lost = frequency.max() > max(too_fast, CYCLIC.largest_spread * frequency.min())
        return self.system.transformation.names[heavy[int(frequency.argmax())]] if lost else None

    @contextmanager
    def determined(self, modes: Modes) -> Iterator[None]:
        """Add the mode at resonance to an error about a linear equation; see `blaming`.

        Parameters
        ----------
        modes
            Modes at the starts of the sub-intervals.
        """
        if not self.linear or self.massless is not None:
            yield
            return
        with blaming(lambda: self.multipliers(modes, None).nearest()):
            yield

    def refuse_magnified(self, modes: Modes, condition: float, motion: States) -> None:
        """Raise `SolverError` where rounding would show in a motion.

        Parameters
        ----------
        modes
            As of `stability`.
        condition
            From `magnification`.
        motion
            As of `stability`.
        """
        refuse_magnified(condition, lambda: self.multipliers(modes, motion).nearest())

    def motion(self, orbit: Orbit) -> States:
        """Give a motion by collocation between the starts of the steps.

        Parameters
        ----------
        orbit
            The motion at the points of `tableau`.
        """
        return lambda places: between(orbit, self.tableau, self.steps.duration, places)

    def series_motion(self, series: Series) -> States:
        """Give a Fourier series between the starts of the steps.

        Parameters
        ----------
        series
            The series over the cycle.
        """
        return lambda places: series.at(np.abs(self.steps.angles(places)))


def system_at_places(scene: Scene, system: System, steps: Steps, places: Array) -> System:
    """Give a mechanism at the same places of all steps.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the starts of the sub-intervals.
    steps
        The steps.
    places
        Where in each step, 0..1.

    Raises
    ------
    UnresolvedError
        When the points call for other independent coordinates than the starts.
    """
    theta = steps.angles(places)
    there = system_at(scene, system.beams, solve_motion(scene, theta, near=system.motion))
    if there.transformation.names != system.transformation.names:  # both choose their coordinates by their angles
        raise UnresolvedError(
            "no independent coordinates are well conditioned over the whole cycle. Take other sub_intervals"
        )
    return there
