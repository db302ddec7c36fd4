"""Motions without the error of the steps, and of the mesh: what the loads do that elements neglect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.accuracy.feedback import under_neglected
from fenics_mech.accuracy.hidden_resonances import Mask, Resonances, enough_modes, hidden_motion
from fenics_mech.accuracy.linear_response import periodic_change
from fenics_mech.accuracy.mesh_residual import neglected, order_of
from fenics_mech.effects import NOTHING, Terms
from fenics_mech.errors import UnresolvedError
from fenics_mech.forces.history import Better, history_of
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.modes import Modes
from fenics_mech.response import History
from fenics_mech.response.periodic.collocation import corrected
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.static.quasi_static import yielding_to
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
OF_STEPS = 2  # differences of steps are 0.3 to 1 of the true error in what was tried
SAFETY = 2  # where the elastic motion has no inertia: the axial force of an element is a mean, which is left out
TAPERED = 1.25  # where sections vary, or mass is lumped: the estimate is 0.57 of the error or more
TRAVELLING = 2.0  # where a pin travels along a member: the estimate is 0.4 to 0.9 of the error
ONE_ELEMENT = 2.5  # where it varies along a member's only element: the error is 0.8 to 5 times its first order
LITTLE = 1e-4  # of a motion, that a vibration which is taken as linear is
FARTHEST, LEAST = 0.3, 1e-3  # share of an answer, and of the largest answer over the cycle that it counts for
CONSTANT = 1e-9  # change of a section along an element, of its mean, that is rounding


def collocation_better(
    scene: Scene, equation: Equation, orbit: Orbit, finer: Flow, at: tuple[Modes, Steps]
) -> dict[str, Better]:
    """Give a motion by collocation without the errors of its steps and of the mesh.

    Parameters
    ----------
    scene
        The scene.
    equation
        Its equation at the starts of the sub-intervals.
    orbit
        The motion. Its steps may have more coordinates.
    finer
        The same steps by a better method, linearised about the motion.
    at
        Modes at the starts of the sub-intervals, and the steps.

    Raises
    ------
    SolverError
        When the cycle cannot be closed.
    """
    (modes, steps), size, flow = at, equation.system.size, orbit.flow
    assert flow is not None
    motion, right = (
        (q[steps.regular, :size], rate[steps.regular, :size])
        for q, rate in ((orbit.start, orbit.start_velocity), corrected(orbit, finer))
    )
    order = 2 * scene.analysis.stages - (scene.analysis.scheme == "radau")
    found = {
        "time": Better(history_of(equation, *right), order, OF_STEPS),
        "mesh": mesh_better(scene, equation, motion, (orbit.start, orbit.start_velocity), flow, steps.regular),
    }
    resonances = resonances_of(scene, equation, modes)
    by_steps = resonances.by_steps(flow.tableau, finer.tableau, float(steps.duration.max()))
    hidden = {"time": by_steps, "mesh": resonances.by_mesh}
    return {name: with_hidden(better, equation, motion, resonances, hidden[name]) for name, better in found.items()}


def mesh_better(
    scene: Scene,
    equation: Equation,
    motion: tuple[Array, Array],
    starts: tuple[Array, Array],
    flow: Flow,
    regular: NDArray[np.bool_],
) -> Better:
    """Give a periodic motion without the error of the mesh.

    Parameters
    ----------
    scene
        The scene.
    equation
        Its equation at the starts of the sub-intervals.
    motion
        q and q' there.
    starts
        The same at the starts of all steps, with all coordinates.
    flow, regular
        The steps of the cycle, linearised about the motion, and which of them are sub-intervals' starts. They may have
        more coordinates, on which the load does not act.
    """
    system, step = equation.system, scene.period / len(motion[0])
    around, size = flow.states(*starts), motion[0].shape[1]

    def load_of(lack: Terms) -> Array:
        return system.on_coordinates(system.applied_by(lack))

    def moved(change: Array, lack: Terms) -> History:
        q, rate = change[:, :size], change[:, size:]
        return history_of(equation, motion[0] + q, motion[1] + rate, load_of(lack))

    def change_by(lack: Terms) -> Array:
        whole = np.pad(load_of(lack), ((0, 0), (0, flow.size - size)))
        return np.concatenate([part[:, :size] for part in periodic_change(whole, around, flow, regular)], axis=1)

    def lack_of(there: System, history: History) -> Terms:
        return neglected(there, history, step)

    lack, unit = lack_of(system, history_of(equation, *motion)), np.pad(flow.unit[:size], (0, size))
    within = LITTLE * float(np.linalg.norm(motion[0] * unit[:size]))
    found = under_neglected(system, lack, lack_of, change_by, moved, unit, equation.linear.loss, within)
    return of_mesh(system, *found)


def resonances_of(scene: Scene, equation: Equation, modes: Modes) -> Resonances:
    """Give the resonances that the loads of a scene's equation may have, with the modes given or more."""
    rate, linear = abs(scene.cycle_rate), equation.linear
    modes = enough_modes(equation.system, modes, linear.load, rate, linear.loss, scene.petsc)
    return Resonances.of(equation, modes, rate)


def with_hidden(
    better: Better, equation: Equation, motion: tuple[Array, Array], resonances: Resonances, hidden: Mask
) -> Better:
    """Add to an error the vibration of modes that its source hides; see `dispersion`.

    Only a little of it stands beside the motion, as an equation may be linear for small motions only.

    Parameters
    ----------
    better
        The motion without the error.
    equation, motion
        The equation at the starts of the sub-intervals, and q and q' there.
    resonances, hidden
        Modes and harmonics there, and which of them are hidden.
    """
    if not hidden.any():
        return better
    more = hidden_motion(equation, resonances, hidden)
    moves, vibrates = (float(np.abs(q).max(initial=0.0)) for q, _ in (motion, more))
    share = LITTLE * moves / vibrates if vibrates > LITTLE * moves > 0 else 1.0
    beside = history_of(equation, *(part + share * change for part, change in zip(motion, more)))
    return replace(better, hidden=(beside, share))


def of_mesh(system: System, history: History, lack: Terms, unheld: bool = False, least: float = 1.0) -> Better:
    """Judge a motion without the error of the mesh: how that falls, and by how much, `least` or more, it is raised.

    The loads `lack` are what the elements neglect, `unheld` is as of `Better`.
    """
    return Better(history, order_of(system), max(least, _safety_of(system)), lack, unheld)


def _safety_of(system: System) -> float:
    """By which the error of a mesh is raised."""
    beams = system.beams
    least = TRAVELLING if system.transformation.constraints.contacts else 1.0
    if beams.stiffness_powers is None:
        return least if beams.spread is None else max(least, TAPERED)
    powers = np.abs(beams.stiffness_powers).reshape(len(beams.mesh.cell), -1, beams.stiffness_powers.shape[-1])
    varies = (powers[..., 1:].max(axis=-1, initial=0.0) > CONSTANT * powers[..., 0]).any(axis=1)
    members = beams.mesh.cell_member
    return ONE_ELEMENT if (np.bincount(members)[members] == 1)[varies].any() else max(least, TAPERED)


def still_better(scene: Scene, system: System, history: History) -> Better:
    """Give a static or quasi-static answer without the error of the mesh.

    There is none without axial forces, if no section varies and no pin travels along a member.
    """
    lack = neglected(system, history, None)
    if lack is NOTHING:
        return Better(history, order_of(system))
    law, load = system.terms.law, system.on_coordinates(system.applied_by(lack))
    if law is None:
        q = yielding_to(system, load, scene.petsc)
    else:
        equation, still = Equation(system), np.zeros_like(history.displacement)
        tension = law.tension(*equation.in_links(history.displacement, still))
        tangents = equation.linearised(history.displacement, still, tension)
        q = np.linalg.solve(tangents.stiffness, load[..., None])[..., 0]
    if (law is not None or system.terms.tension is not None) and not scene.analysis.allow_coarse:
        _refuse_far(system, history.displacement, q)
    return of_mesh(system, replace(history, displacement=history.displacement + q), lack, least=SAFETY)


def _refuse_far(system: System, q: Array, change: Array) -> None:
    """Raise where the error of the mesh is so large a share of an answer that its first order does not tell it.

    So it is next to a buckling load, which elements that are too long put too high.
    """
    share = np.abs(change).max(axis=1) / np.maximum(np.abs(q).max(axis=1), np.finfo(float).tiny)
    k = int(share.argmax())
    if share[k] > FARTHEST and np.abs(q[k]).max() > LEAST * np.abs(q).max():
        theta = np.degrees(system.motion.theta[k])
        raise UnresolvedError(
            f"the elements are too long under axial forces at drive angle {theta:.6g} deg: they may change the "
            f"deflection by {share[k]:.2g} of it or more, as next to a buckling load. Take more elements; "
            "analysis.allow_coarse lets it pass"
        )
