"""What is followed beside a motion with freedoms: its Poincaré section, and disturbances of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.transient.disturbances import EquationOfMotion, Growth, Transition, quarters_of
from fenics_mech.response.transient.section_points import PoincareRecord
from fenics_mech.response.transient.stepping import StepCurve
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class Beside:
    """What is followed.

    Parameters
    ----------
    weight
        Weights of the coordinates in those of the steps, ``(coordinates,)``.
    section
        The Poincaré section.
    growth
        Disturbances, and what they grow by.
    transition
        All disturbances of the state from the start on.
    """

    weight: Array
    section: PoincareRecord | None = None
    growth: Growth | None = None
    transition: Transition | None = None

    @classmethod
    def of(
        cls, scene: Scene, equation: EquationOfMotion, tableau: Tableau, weight: Array, times: Array, *, carries: bool
    ) -> Beside:
        """Begin to follow what a scene wants to know.

        Parameters
        ----------
        scene
            The scene, with its freedoms.
        equation, tableau
            The equation that steps solve, and their points.
        weight
            Weights of the coordinates in those of the steps, ``(coordinates,)``; the freedoms are the last.
        times
            Instants of the result, ascending ``(times,)`` (s).
        carries
            Whether all disturbances of the state are carried on instead.
        """
        freedoms = len(scene.freedoms)
        every = np.eye(2 * len(weight))
        if carries:
            return cls(weight, transition=Transition(equation, tableau, every))
        section = scene.analysis.poincare
        last = np.arange(len(weight) - freedoms, len(weight))  # of the freedoms' places, then of their rates
        chosen, wanted = np.append(last, last + len(weight)), np.union1d(times, quarters_of(times))
        return cls(
            weight,
            None if section is None else PoincareRecord(scene, section, weight[-freedoms:]),
            Growth(equation, tableau, every[:, chosen], wanted) if scene.analysis.lyapunov else None,
        )

    @property
    def takes(self) -> tuple[Callable[[StepCurve], None], ...]:
        """What is called with each step."""
        return tuple(part.take for part in (self.section, self.growth, self.transition) if part is not None)

    @property
    def monodromy(self) -> Array:
        """What became of disturbances of coordinates and rates, ``(2 coordinates, 2 coordinates)``."""
        assert self.transition is not None
        unit = np.tile(self.weight, 2)
        return self.transition.states * unit / unit[:, None]
