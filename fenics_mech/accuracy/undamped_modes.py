"""What the damping of modes changes that a periodic motion leaves undamped, as they follow its loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.quantities import Quantities
from fenics_mech.effects import NOTHING
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.damped_modes import DAMPED, LeftOut
from fenics_mech.response.solution import CollocationSolution, HarmonicSolution, Solution
from fenics_mech.scene import Scene

TOO_MANY = f"what undamped modes would change if they were damped, as more than {DAMPED.most} modes are too many"


def left_undamped(solution: Solution) -> dict[str, Array] | None:
    """Estimate by how much the damping that a motion leaves out would change strains and deflections.

    Of a mode that follows its loads it changes the strain by ``2 zeta/omega`` times the strain's rate. Forces in joints
    and of drives balance the loads, whatever part of them is viscous.

    Parameters
    ----------
    solution
        The response.

    Returns
    -------
    dict or None
        "strain" and "deflection", as `Quantities.largest`. Empty where all modes are damped, and None where those that
        are not are too many to be found.
    """
    if not isinstance(solution, CollocationSolution | HarmonicSolution) or (modes := solution.cycle.damped) is None:
        return {}
    left = LeftOut.of(solution.scene, solution.system, modes)
    if left is None:
        return None
    modal, equation = left.equation.modal, left.equation
    assert modal is not None
    q, rate = (part[left.angles, : equation.system.size] for part in _at_positions(solution))
    forces = left.forces(modes, modal.rates(q, rate))
    if left.beyond and equation.system.terms.law is None:  # else bending moves the axis without stress
        forces = forces + left.forces_beyond(q, rate)
    return _changed_by(solution.scene, equation, forces)


def _changed_by(scene: Scene, equation: Equation, forces: Array) -> dict[str, Array]:
    """Give what forces of damping change of strains and deflections, where they are balanced by inertia."""
    bare = replace(equation.system, terms=NOTHING)
    inertia = -equation.system.to_links(equation.linear.mass.solve(forces))
    lost = ElasticResponse(equation.links_stiffness.solve(forces), inertia)
    sizes = Quantities.of(scene, bare, lost).largest
    return {name: sizes[name] for name in ("strain", "deflection")}


def _at_positions(solution: CollocationSolution | HarmonicSolution) -> tuple[Array, Array]:
    """Give q and q' of a motion at its positions, ``(positions, coordinates)`` each."""
    if isinstance(solution, CollocationSolution):
        motion = solution.orbit.start, solution.orbit.start_velocity
    else:
        motion = solution.cycle.series_motion(solution.series)(np.zeros(1))
    return motion[0][solution.cycle.steps.regular], motion[1][solution.cycle.steps.regular]
