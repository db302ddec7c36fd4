"""The matrices of the equation of motion over the positions, and the share of each mode in a motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from scipy.integrate import simpson

from fenics_mech._arrays import Array
from fenics_mech._guard import guarded, require_memory
from fenics_mech.analysis import solve
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import SceneError
from fenics_mech.forces.section_forces import deflection_of_nodes
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.planning.effect_choice import choose
from fenics_mech.recovery.fields import recover
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.recovery.result import stamp
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.setup import CommonParts, mechanism
from fenics_mech.response.solution import PeriodicSolution, Solution
from fenics_mech.scene import Scene

PLACES = np.array([0.0, 0.5, 1.0])  # along every member, at which coordinates move it
Progress = Callable[[str], None]


@dataclass(frozen=True)
class SystemMatrices(OfScene):
    """What `matrices` found.

    Parameters
    ----------
    data
        Coordinates theta (rad), row and column (the coordinates q, from 1), member, s (0, 0.5, 1), component. Variables
        are

        - mass, damping, stiffness: M, C and K of ``M q'' + C q' + K q = f``, by theta, row and column, in SI,
        - load: f by theta and row,
        - displacement: of the members' axes in the fixed frame by a unit of each coordinate, by theta, column, member,
          s and component.

    Examples
    --------
    >>> few = {"analysis.method": "quasi-static", "analysis.sub_intervals": 12}
    >>> scene = fm.load("demos/four_bar.toml").changed(few)
    >>> found = fm.matrices(scene).data
    >>> dict(found["mass"].sizes)
    {'theta': 12, 'row': 27, 'column': 27}
    """

    KIND: ClassVar[str] = "set of matrices"
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech", "scene")


def matrices(scene: Scene, progress: Progress = lambda step: None) -> SystemMatrices:
    """Give M, C and K of the equation of motion at the positions of a scene.

    They are those of the linear part of the equation that the scene's effects make: with coupling C and K hold the
    Coriolis and centrifugal terms, and K the axial forces of the response where they stiffen. Under large rotations
    they are those of straight links. Modal damping is in C and K.

    Parameters
    ----------
    scene
        The scene; that of a result is ``result.scene``.
    progress
        Called with the name of each step as it begins.

    Returns
    -------
    SystemMatrices
        The matrices, in SI.

    Raises
    ------
    SceneError
        When the motion is one in time, whose matrices change with it.
    SolverError
        When the response that stiffens the links is not found.
    TooLargeError
        When the matrices do not fit into memory.

    Examples
    --------
    >>> few = {"analysis.method": "quasi-static", "analysis.sub_intervals": 12}
    >>> scene = fm.load("demos/four_bar.toml").changed(few)
    >>> stiffness = fm.matrices(scene).data["stiffness"].to_numpy()
    >>> stiffness.shape
    (12, 27, 27)
    """
    solution = _solution(scene, progress)
    scene, system = solution.scene, solution.system
    count, n = len(system.motion.theta), system.size
    require_memory(5 * count * n * n, f"full matrices of {n} coordinates at {count} positions", "Take a reduction")
    linear = Equation(system, modal_damping(scene.damping.ratio, system)).linear
    square = ("theta", "row", "column")
    found = {name: (square, matrix) for name, matrix in zip(("mass", "damping", "stiffness"), linear.full)}
    along = ("theta", "column", "member", "s", "component")
    data = xr.Dataset(
        found | {"load": (("theta", "row"), linear.load), "displacement": (along, _moved(system))},
        {
            "theta": ("theta", system.motion.theta, {"units": "rad"}),
            "row": range(1, n + 1),
            "column": range(1, n + 1),
            "member": list(system.beams.mesh.members),
            "s": PLACES,
            "component": ["x", "y"],
        },
        stamp(scene),
    )
    return SystemMatrices(data)


def participation(scene: Scene, progress: Progress = lambda step: None) -> xr.Dataset:
    """Give the part that each mode has in the motion of a scene.

    Parameters
    ----------
    scene
        The scene, of a periodic motion; that of a result is ``result.scene``. ``analysis.modes`` states how many modes.
    progress
        Called with the name of each step as it begins.

    Returns
    -------
    xarray.Dataset
        `modal_coordinate` ``y = Phi^T M q`` (m kg^0.5) over theta and mode. `energy_share` over mode: the mean over the
        cycle of ``omega^2 y^2/2``, of the mean strain energy of the members, that of moments and axial forces. The
        shares of all modes make 1, but for the loads inside elements. What few modes lack is the static part of the
        higher ones.

    Raises
    ------
    SceneError
        When the motion is not periodic.
    SolverError
        When a solver does not converge.

    Examples
    --------
    >>> scene = fm.load("demos/four_bar.toml").changed({"effects": ["coupling"], "analysis.sub_intervals": 120})
    >>> 0.5 < float(fm.participation(scene)["energy_share"].sum()) < 1
    True
    """
    solution = _solution(scene, progress)
    if not isinstance(solution, PeriodicSolution):
        raise SceneError("modes take part in a periodic motion", place="analysis.method", hint='Write "periodic"')
    progress("modes")
    system, q = solution.system, solution.response.displacement
    modes = solve_modes(system, solution.scene.analysis.modes, solution.scene.petsc)
    mass, _ = system.held_matrices()
    y = np.einsum("tmn,tn->tm", modes.shapes, mass.times(q))
    shares = np.mean((modes.omega * y) ** 2 / 2, axis=0) / (_strain_energy(solution) or 1.0)
    meaning = {"units": "m kg^0.5", "long_name": "modal coordinate, of modes that are orthonormal in M"}
    found: dict[str, Any] = {
        "modal_coordinate": (("theta", "mode"), y, meaning),
        "energy_share": ("mode", shares, {"units": "1", "long_name": "share of the strain energy over the cycle"}),
    }
    labels = {"theta": ("theta", modes.theta, {"units": "rad"}), "mode": range(1, y.shape[1] + 1)}
    return xr.Dataset(found, labels, stamp(solution.scene))


def _strain_energy(solution: Solution) -> float:
    """Mean of the strain energy of all members over the positions (J)."""
    members = recover(solution).members
    lengths, total = solution.system.beams.mesh.member_length, 0.0
    for i, here in enumerate(solution.scene.rigidities(members.s)):
        line = members.axial_force[:, i] ** 2 / here.axial + members.moment[:, i] ** 2 / here.bending  # J/m, twice
        total += float(lengths[i] * np.mean(simpson(line, x=members.s, axis=1)) / 2)
    return total


@guarded()
def _solution(scene: Scene, progress: Progress) -> Solution:
    """Solve a scene, with the effects that it calls for."""
    if scene.analysis.method == "transient":
        hint = 'Write method = "periodic" for those over a cycle'
        raise SceneError("the matrices of a motion in time change with it", place="analysis.method", hint=hint)
    if not scene.members():
        raise SceneError("no link has a member, and matrices are those of links that bend", place="links")
    common = CommonParts()
    chosen, _ = choose(scene, common)
    return solve(chosen, mechanism(chosen, progress, common), progress)[0]


def _moved(system: System) -> Array:
    """Displacement of the members by a unit of each coordinate, ``(angles, coordinates, members, places, 2)``."""
    count, units = len(system.motion.theta), np.eye(system.size)
    moved = [
        deflection_of_nodes(system, system.to_links(np.broadcast_to(unit, (count, system.size))), PLACES)
        for unit in units
    ]
    return np.stack(moved, axis=1)
