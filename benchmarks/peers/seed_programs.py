"""Programs that know the seed four-bar alone: chapter 5, Gauss-Legendre collocation and exponentials by hand, SciPy.

They give the strain of the + fibre at mid-span of coupler and follower.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from benchmarks.converged import Converged, difference, extrapolated
from benchmarks.cost_grid import TRUNCATED
from benchmarks.peers.by_hand import by_exponentials, by_solve_ivp
from benchmarks.peers.peer_runs import COUPLED, Entry
from fenics_mech._arrays import Array
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.validation.reference import NineElementModel, gauss_legendre_periodic, link_strain, periodic_response

CHAPTER_5 = ((60, 3, 3), (120, 5, 3), (240, 5, 3), (480, 8, 6))  # sub-intervals, modes, elements a link
GAUSS_LEGENDRE = ((80, 2), (80, 3), (120, 3), (120, 4), (180, 4), (240, 6), (240, 8))  # steps a cycle, elements a link
EXPONENTIALS = ((360, 3), (1440, 3), (2880, 3), (5760, 4))  # the same
SOLVE_IVP = ((1e-2, 2), (1e-2, 3), (1e-3, 3))  # relative tolerance, elements a link


def is_seed(scene: Scene) -> bool:
    """Tell whether a scene is the seed four-bar, whatever its mesh, effects and analysis.

    Parameters
    ----------
    scene
        The scene.
    """
    return bool(_machine(scene) == _machine(seed_four_bar()))


def _machine(scene: Scene) -> Any:
    """Numbers that a machine is the same by, whatever its sections and materials are called."""
    half = np.array([0.5])
    members = {}
    for label in scene.members():
        section = scene.rigidity(label, half)
        numbers = [section.axial, section.bending, section.line_density, section.fibre, scene.member_ends(label)]
        members[label] = [np.round(np.ravel(part) / np.abs(part).max(), 9).tolist() for part in map(np.array, numbers)]
        members[label] += [f"{np.abs(np.array(part)).max():.9g}" for part in numbers]
    others = ("ground", "joints", "masses", "gravity", "loads", "impulses", "springs", "dampers", "drive", "damping")
    branch = np.round(solve_motion(scene, np.zeros(1)).angle[0], 6).tolist() if len(members) == 3 else None
    return members, branch, {name: scene.model_dump(mode="json")[name] for name in others}


def by_hand(quick: bool) -> Iterator[Entry]:
    """Chapter 5, Gauss-Legendre collocation and matrix exponentials on hand-coded matrices; then SciPy.

    Parameters
    ----------
    quick
        With one run of each method, without SciPy.
    """
    for count, modes, elements in CHAPTER_5[:1] if quick else CHAPTER_5:
        settings = {"elements": elements, "sub_intervals": count, "modes": modes}
        work = partial(_chapter_5, elements, count, modes)
        yield Entry("chapter 5 by hand", TRUNCATED, _without_note(work), settings)
    for count, elements in GAUSS_LEGENDRE[:1] if quick else GAUSS_LEGENDRE:
        settings = {"elements": elements, "sub_intervals": count}
        work = partial(_gauss_legendre, elements, count, COUPLED)
        yield Entry("Gauss-Legendre by hand", COUPLED, _without_note(work), settings)
    for count, elements in ((60, 1),) if quick else EXPONENTIALS:
        settings = {"elements": elements, "sub_intervals": count}
        work = partial(_exponentials, elements, count)
        yield Entry("exponentials by hand", COUPLED, _without_note(work), settings)
    for tolerance, elements in () if quick else SOLVE_IVP:
        work = partial(_solve_ivp, elements, tolerance)
        yield Entry("solve_ivp by hand", COUPLED, _without_note(work), {"elements": elements, "tolerance": tolerance})


def converged_by_hand(equation: str, quick: bool) -> Converged:
    """Find the converged answer of Gauss-Legendre collocation by hand.

    Parameters
    ----------
    equation
        `TRUNCATED` or `COUPLED`.
    quick
        With coarser meshes and longer steps.
    """
    meshes, steps = ((3, 2, 1), 120) if quick else ((8, 6, 4), 480)
    runs = [_gauss_legendre(n, count, equation) for n, count in zip(meshes, (steps, steps, steps // 2))]
    strain, other = (extrapolated(runs[i], runs[i + 1], meshes[i] / meshes[i + 1]) for i in (0, 1))
    how = (
        f"Gauss-Legendre collocation by hand, {steps} steps, extrapolated from {meshes[0]} and {meshes[1]} elements; "
        f"checked by {meshes[1]} and {meshes[2]}, the last with half the steps"
    )
    return Converged(strain, difference(other, strain), how)


def _without_note(work: Callable[[], Array]) -> Callable[[Any], Array]:
    """Take the function for the time of the solver, and leave it alone."""
    return lambda note: work()


def _chapter_5(elements: int, count: int, modes: int) -> Array:
    model = NineElementModel(elements=elements)
    found = periodic_response(model, count, modes=modes)
    return _middles(link_strain(model, found.theta, found.displacement, found.acceleration).total)


def _exponentials(elements: int, count: int) -> Array:
    return _middles(by_exponentials(count, elements))


def _solve_ivp(elements: int, tolerance: float) -> Array:
    return _middles(by_solve_ivp(tolerance, elements))


def _gauss_legendre(elements: int, count: int, equation: str) -> Array:
    model = NineElementModel(elements=elements)
    found = gauss_legendre_periodic(model, count, coupling=equation == COUPLED)
    return _middles(link_strain(model, found.theta, found.displacement, found.acceleration).total)


def _middles(strain: Array) -> Array:
    """Strains of crank, coupler and follower, ``(angles, 3)``, as those of coupler and follower."""
    return strain[:, 1:, None, None]
