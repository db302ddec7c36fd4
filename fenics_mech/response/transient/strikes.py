"""Impulses on linkages with freedoms: what they change the rates of the coordinates by.

In an instant ``M (y'_after - y'_before)`` is the momentum that the impulses give to the coordinates y. It is what
forces of their size would leave over in the equation. Drives keep to their laws, and contacts that are closed give no
impulse.
Source: Goldsmith, Impact (1960), chapter 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.impulses import EFFECT as IMPULSES
from fenics_mech.effects.loads import EFFECT as LOADS
from fenics_mech.response.transient.stepping import EquationInTime
from fenics_mech.scene import Load, Scene
from fenics_mech.scene.start_state import StartState
from fenics_mech.scene.strikes import Strike

Momentum = Callable[[tuple[str, ...], float, Array, Array], Array]  # of impulses, at a time, for coordinates and rates


@dataclass(frozen=True)
class Strikes:
    """All impulses of a motion.

    Parameters
    ----------
    equation
        The equation of the motion.
    momentum
        Gives what impulses give to the scaled coordinates, ``(coordinates,)``.
    due
        The impulses, in the order of time.
    work
        Work of those that have struck (J), where no drive moves.
    """

    equation: EquationInTime
    momentum: Momentum
    due: tuple[Strike, ...]
    work: list[float] = field(default_factory=list)

    def struck(self, strike: Strike, place: Array, rate: Array) -> Array:
        """Give the rates after impulses, ``(coordinates,)``.

        Parameters
        ----------
        strike
            The impulses.
        place, rate
            Scaled coordinates and rates before, ``(coordinates,)`` each.
        """
        at, still = np.array([strike.time]), np.zeros_like(place)
        mass = self.equation.tangents_at(at, place[None], rate[None], still[None])[0][0]
        momentum = self.momentum(strike.names, strike.time, place, rate)
        after = rate + np.linalg.solve(mass, momentum)
        self.work.append(float(momentum @ (rate + after)) / 2)
        return after


def loaded(scene: Scene, names: tuple[str, ...]) -> Scene:
    """Give a scene on which some impulses act as constant loads of a second.

    Parameters
    ----------
    scene
        The scene.
    names
        Names of the impulses.
    """
    loads = {}
    for name, impulse in scene.impulses.items():  # all of them, as their places are nodes of the mesh
        acts = {"force": impulse.impulse, "moment": impulse.angular_impulse} if name in names else {}
        loads[f"impulse_{name}"] = Load(at=impulse.at, **acts)
    effects = scene.effects if scene.effects == "auto" else tuple(set(scene.effects) - {IMPULSES.name, LOADS.name})
    return scene.changed(loads=scene.loads | loads, impulses={}, effects=effects)


def started(strikes: Strikes | None, start: StartState, weight: Array) -> StartState:
    """Give a start after the impulses that strike there.

    Parameters
    ----------
    strikes
        The impulses.
    start
        The start.
    weight
        Weights of the coordinates in the scaled ones, ``(coordinates,)``.
    """
    if strikes is None or not strikes.due or strikes.due[0].time > start.time:
        return start
    rate = strikes.struck(strikes.due[0], weight * start.displacement, weight * start.velocity) / weight
    strikes.work.clear()  # what is stored at the start has it
    return StartState(start.time, start.displacement, rate, start.links)
