"""The matrices of the equation of motion over the positions, and the share of each mode in a motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from scipy.integrate import simpson

from fenics_mech._arrays import Array, Index
from fenics_mech._guard import guarded, require_memory
from fenics_mech.answers.by_poses import planned, solution
from fenics_mech.answers.by_sub_intervals import ByModes
from fenics_mech.answers.modes_by_poses import HeldMachine, at_rest
from fenics_mech.answers.solved_by_poses import built, instants_of, with_effects
from fenics_mech.effects.known import COUPLING, STIFFENING
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.machine import Machine
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.recovery.result import stamp
from fenics_mech.scene import Scene
from fenics_mech.solve import forces_about

PLACES = np.array([0.0, 0.5, 1.0])  # along every member, at which coordinates move it
SPACING = 1e-4  # rad of the drive, by which coordinates are differentiated twice: its square, and rounding over it
HELD = 1e-6  # of a row: smaller ones say what others do
Progress = Callable[[str], None]


@dataclass(frozen=True)
class SystemMatrices(OfScene):
    """What `matrices` found.

    Parameters
    ----------
    data
        Coordinates theta (rad), row and column (the coordinates q, from 1), member, s (0, 0.5, 1), component. Variables
        are

        - coordinate: what each q is, by row, such as "coupler.B.x" (m) or "coupler.B.rotation" (rad): how far that
          point is from its place in the rigid motion, in axes that turn with its link there,
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


@guarded()
def matrices(scene: Scene, progress: Progress = lambda step: None) -> SystemMatrices:
    """Give M, C and K of the equation of motion at the positions of a scene.

    Coordinates are deviations of the nodes' poses from the rigid motion, in axes that turn with it. What joints and
    drives hold by rows is eliminated. With coupling C and K have the Coriolis and centrifugal terms. K has the axial
    forces of the static answer where `geometric-stiffness` acts; under large rotations it is that of straight links.
    Modal damping is in C and K.

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
    _refuse(scene)
    progress("kinematics")
    chosen = with_effects(scene)
    made, t = built(at_rest(chosen)), instants_of(at_rest(chosen))
    machine, moving = made.machine, chosen.analysis.method != "static"
    progress("beams")
    assert made.links is not None
    size = machine.n - len(machine.rows)
    what = f"full matrices of {size} coordinates at {len(t)} positions"
    require_memory(8 * len(t) * machine.size**2, what, "Take fewer sub_intervals or elements")
    coupled = moving and COUPLING in chosen.named_effects
    given, names = _coordinates(made, t, coupled)
    M, C, K, load = _tangents(machine, t, coupled, moving, STIFFENING in chosen.named_effects)
    Z, Z1, Z2 = given
    back = Z.transpose(0, 2, 1)
    found = {
        "mass": back @ M @ Z,
        "damping": back @ (2 * M @ Z1 + C @ Z),
        "stiffness": back @ (K @ Z + C @ Z1 + M @ Z2),
    }
    moved = HeldMachine(made, t).along(Z, PLACES)
    data = xr.Dataset(
        {name: (("theta", "row", "column"), matrix) for name, matrix in found.items()}
        | {
            "load": (("theta", "row"), np.einsum("kni,kn->ki", Z, load)),
            "displacement": (("theta", "column", "member", "s", "component"), moved),
            "coordinate": (("row",), names),
        },
        {
            "theta": ("theta", chosen.cycle_rate * t if chosen.drives else 0 * t, {"units": "rad"}),
            "row": range(1, len(names) + 1),
            "column": range(1, len(names) + 1),
            "member": list(made.links.mesh.members),
            "s": PLACES,
            "component": ["x", "y"],
        },
        stamp(scene),
    )
    return SystemMatrices(data)


def _refuse(scene: Scene) -> None:
    """Raise `SceneError` where a scene has no such matrices."""
    if scene.analysis.method == "transient":
        hint = 'Write method = "periodic" for those over a cycle'
        raise SceneError("the matrices of a motion in time change with it", place="analysis.method", hint=hint)
    if not scene.members():
        raise SceneError("no link has a member, and matrices are those of links that bend", place="links")


def _tangents(
    machine: Machine, t: Array, coupled: bool, moving: bool, stiffened: bool
) -> tuple[Array, Array, Array, Array]:
    """Give M, C and K of the linear theory ``(positions, n, n)``, and the load ``(positions, n)``."""
    n, kept, zero = machine.n, machine.n + machine.held, np.zeros((len(t), machine.size))
    stiff = forces_about(machine, t, moving).stresses if stiffened else None
    found = machine.residual(t, zero, zero, zero, predicted=stiff, moving=coupled, turning=stiffened)
    M, C, K = (machine.pattern.dense(x) for x in (found.M, found.C, found.K))
    by_modes = M[:, :n, kept:]  # forces of the modes of stress, whose sizes are what their rows of C and K give
    C, K = (X[:, :n, :n] + by_modes @ X[:, kept:, :n] for X in (C, K))
    load = -machine.residual(t, zero, zero, zero, moving=moving, tangents=False).force[:, :n]
    return M[:, :n, :n], C, K, load


def _coordinates(made: SceneMachine, t: Array, coupled: bool) -> tuple[list[Array], list[str]]:
    """Give the machine's coordinates by independent ones, two derivatives by time, and names of those."""
    # The first three are ``(positions, n, independent)`` each; derivatives are 0 where nothing is coupled.
    machine = made.machine
    turned, rows = _turned(machine, t), _rows(machine, t)
    dependent = _dependent(rows @ turned)
    left = np.setdiff1d(np.arange(machine.n), dependent)

    def given(at: Array) -> Array:
        axes = _turned(machine, at)
        held = _rows(machine, at) @ axes
        by = np.zeros((len(at), machine.n, len(left)))
        by[:, left, np.arange(len(left))] = 1.0
        by[:, dependent] = -np.linalg.pinv(held[..., dependent]) @ held[..., left]
        return np.asarray(axes @ by)

    Z = given(t)
    found = [Z, np.zeros_like(Z), np.zeros_like(Z)]
    if coupled:
        step = SPACING / abs(made.scene.cycle_rate)
        ahead, behind = given(t + step), given(t - step)
        found = [Z, (ahead - behind) / (2 * step), (ahead - 2 * Z + behind) / step**2]
    names = _names(made)
    return found, [names[i] for i in left]


def _turned(machine: Machine, t: Array) -> Array:
    """Give coordinates by those in the axes of their poses in the rigid motion ``(positions, n, n)``."""
    found, R = np.tile(np.eye(machine.n), (len(t), 1, 1)), machine.known.at(t).R
    for pose in range(len(machine.places) - 1, -1, -1):  # of poses that share a place the axes of the first
        place = machine.places[pose, :2]
        if (place >= 0).all():
            found[np.ix_(np.arange(len(t)), place, place)] = R[:, pose]
    return found


def _rows(machine: Machine, t: Array) -> Array:
    """Give the gradients of all rows ``(positions, rows, n)``."""
    zero = np.zeros((len(t), machine.size))
    found = machine.residual(t, zero, zero, zero, moving=False)
    return machine.pattern.dense(found.K)[:, machine.n : machine.n + machine.held, : machine.n]


def _dependent(rows: Array) -> Index:
    """Choose coordinates that rows give at all positions ``(positions, rows, n)``, by the others."""
    left = rows / np.maximum(np.abs(rows).max(axis=2, initial=0.0, keepdims=True), 1e-300)
    dependent: list[int] = []
    for _ in range(rows.shape[1]):
        size = np.linalg.norm(left, axis=1)
        column = int(size.min(axis=0).argmax())
        if size.max() < HELD:
            break
        if size[:, column].min() < HELD:
            raise SolverError(
                "no choice of coordinates serves at all positions: take fewer of them, or one by 'static'"
            )
        unit = left[..., column] / size[:, column, None]
        left = left - unit[..., None] * (unit[:, None] @ left)
        dependent.append(column)
    return np.array(sorted(dependent), dtype=np.int64)


def _names(made: SceneMachine) -> list[str]:
    """Name the coordinates of the machine: "link.point.x", "link.point.rotation", in the axes of the link."""
    assert made.links is not None
    found = [""] * made.machine.n
    for label, pose in zip(made.links.mesh.node_name, made.node_pose):
        for place, part in zip(made.machine.places[pose], ("x", "y", "rotation")):
            if place >= 0 and not found[place]:
                found[place] = f"{label}.{part}"
    return [name or f"pose.{i}" for i, name in enumerate(found)]


@guarded()
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
    _refuse(scene)
    if scene.analysis.method != "periodic":
        raise SceneError("modes take part in a periodic motion", place="analysis.method", hint='Write "periodic"')
    progress("response")
    chosen = with_effects(scene)
    positions: OfPoses
    if COUPLING in chosen.named_effects:
        positions = solution(planned(chosen)).positions
        q = positions.motion.q
    else:
        positions = (by_modes := ByModes.of(chosen)).positions
        q = by_modes.positions.displaced
    progress("modes")
    held = HeldMachine(HeldMachine.of(at_rest(chosen)).made, instants_of(chosen))
    y = np.einsum("tnm,tn->tm", held.modes.momenta, q[:, : held.made.machine.n])
    shares = np.mean((held.modes.omega * y) ** 2 / 2, axis=0) / (_strain_energy(positions) or 1.0)
    meaning = {"units": "m kg^0.5", "long_name": "modal coordinate, of modes that are orthonormal in M"}
    found: dict[str, Any] = {
        "modal_coordinate": (("theta", "mode"), y, meaning),
        "energy_share": ("mode", shares, {"units": "1", "long_name": "share of the strain energy over the cycle"}),
    }
    labels = {"theta": ("theta", chosen.cycle_rate * held.t, {"units": "rad"}), "mode": range(1, y.shape[1] + 1)}
    return xr.Dataset(found, labels, stamp(scene))


def _strain_energy(positions: OfPoses) -> float:
    """Mean of the strain energy of all members over the positions (J)."""
    s, forces = positions.stations, positions.sections
    lengths, total = positions.mesh.member_length, 0.0
    for i, here in enumerate(positions.made.scene.rigidities(s)):
        line = forces.axial[:, i] ** 2 / here.axial + forces.moment[:, i] ** 2 / here.bending  # J/m, twice
        total += float(lengths[i] * np.mean(simpson(line, x=s, axis=1)) / 2)
    return total
