"""The same response on all nodes of members that are reduced: there exact strains have their coordinates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Congruence
from fenics_mech.accuracy.theory_ladder import released
from fenics_mech.errors import SceneError, UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.forces.element_ends import balanced
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism import System
from fenics_mech.response.motor_response import by_motor
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.setup import moved, system_at
from fenics_mech.response.solution import CollocationSolution, MotorSolution, Solution, TransientSolution
from fenics_mech.response.transient.in_time import concatenated, cycles_of, equation_along
from fenics_mech.scene import Scene

MOST_ELEMENTS = 200  # of reduced members, whose nodes are all taken: more take far longer than the response itself


def on_all_nodes(solution: Solution) -> Solution:
    """Give a response in the coordinates of exact strains; itself if it has them.

    Parameters
    ----------
    solution
        The response.

    Raises
    ------
    UnresolvedError
        When blows in time strike reduced members, or these have too many nodes.
    """
    own = solution.system
    if own.beams.reduction is not None and len(own.beams.mesh.cell_member) > MOST_ELEMENTS:
        raise UnresolvedError(f"the reduced members have more than {MOST_ELEMENTS} elements")
    try:
        scene = released(solution.scene)
    except SceneError as error:  # such as elements of which one is too short beside another
        raise UnresolvedError(f"the members can only be reduced: {error}") from error
    if scene is solution.scene:
        return solution
    if scene.impulses and isinstance(solution, TransientSolution):
        raise UnresolvedError("reduced members cannot follow the ringing after a blow")
    if isinstance(solution, MotorSolution):
        return _on_shaft(solution, scene)
    system = _on_nodes_of(scene, own, own.motion)
    (q,) = _carried(own, system, solution.response)
    found = replace(solution, scene=scene, system=system, response=replace(solution.response, displacement=q))
    match solution, found:
        case CollocationSolution(), CollocationSolution():
            return _at_points(solution, found)
        case TransientSolution(), TransientSolution():
            return _in_time(solution, found)
    return found


def _on_nodes_of(scene: Scene, system: System, motion: Motion) -> System:
    """Give the mechanism of a scene with all nodes that the links have in another."""
    return system_at(scene, replace(system.beams, reduction=None), motion)


def _at_points(own: CollocationSolution, found: CollocationSolution) -> CollocationSolution:
    """Give a response by collocation whose motion at the points and at the starts of steps is on all nodes too."""
    orbit, cycle = own.orbit, Cycle(found.scene, found.system, own.cycle.damped_up_to)
    here, there = (one.at_points(one.tableau) for one in (own.cycle, cycle))
    inside = orbit.displacement, orbit.velocity, orbit.acceleration
    q, rate, second = _carried(here.system, there.system, elastic_response(here, *inside[:2]), inside)
    regular = cycle.steps.regular
    start, start_rate = np.zeros((2, len(regular), cycle.system.size))
    states = orbit.start[regular], orbit.start_velocity[regular]
    response = elastic_response(own.cycle.start, *states)
    start[regular], start_rate[regular] = _carried(own.system, found.system, response, states)
    orbit = replace(
        orbit, displacement=q, velocity=rate, acceleration=second, start=start, start_velocity=start_rate, flow=None
    )
    return replace(found, cycle=cycle, orbit=orbit)


def _in_time(own: TransientSolution, found: TransientSolution) -> TransientSolution:
    """Give a response in time whose course is on all nodes too."""
    scene, course = found.scene, own.course
    states, responses = [], []
    over_cycle = moved(scene, found.system, own.over_cycle.motion)
    for part in cycles_of(course.time, scene.analysis.sub_intervals):
        here = equation_along(own.scene, own.over_cycle, own.system.motion.part(part))
        there = equation_along(scene, over_cycle, here.system.motion)
        state = course.displacement[part], course.velocity[part]
        states.append(np.stack(_carried(here.system, there.system, elastic_response(here, *state), state)))
        responses.append(elastic_response(there, *states[-1]))
    q, rate = np.concatenate(states, axis=1)
    return replace(
        found,
        over_cycle=over_cycle,
        response=concatenated(responses),
        course=replace(course, displacement=q, velocity=rate),
    )


def _on_shaft(own: MotorSolution, scene: Scene) -> MotorSolution:
    """Solve for a response on a motor's shaft anew: its twist goes with all nodes."""
    unjudged = scene.changed(analysis__stability=False)
    system = _on_nodes_of(unjudged, own.cycle.system, own.cycle.system.motion)
    return by_motor(unjudged, system, own.modes)


def _carried(own: System, there: System, response: ElasticResponse, state: Sequence[Array] = ()) -> list[Array]:
    """Give coordinates q, and as many rates as a state has, where all nodes move as in a response.

    Their displacement is in balance inside members that are reduced. It fulfils the joints' equations, so that the
    coordinates follow from it by least squares.
    """
    derivatives = [part.transformation.derivatives(part.motion) for part in (own, there)]
    p, wanted = ([part.values, *rates] for part, rates in zip((own, there), derivatives))
    nodes = [balanced(own, response)[1]]
    for n in range(1, len(state)):
        terms = (math.comb(n, i) * own.transformation.forward(p[i], state[n - i]) for i in range(n + 1))
        nodes.append(own.on_nodes(sum(terms, start=np.zeros((len(p[0]), own.transformation.shape[0])))))
    layout, found = there.transformation, list[Array]()
    every = np.arange(layout.shape[0])
    products = Congruence.of(*layout.shape, layout.rows, layout.columns, [(every, every)])
    square = products.products(wanted[0], (np.ones((1, len(every))), wanted[0]))
    for n, v in enumerate(nodes):
        left = v - sum(math.comb(n, i) * layout.forward(wanted[i], found[n - i]) for i in range(1, n + 1))
        found.append(square.solve(layout.backward(wanted[0], left)))
    return found
