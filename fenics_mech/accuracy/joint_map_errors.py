"""What rigid arms and guides of a motion are wrong by, as joints are linearised about the rigid motion.

The forces and the places that they leave out, see `forces.joint_maps`, act on the motion as a small load: its linear
answer is the error, to first order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array, each
from fenics_mech.accuracy.estimate import Errors
from fenics_mech.accuracy.mesh_residual import given_way
from fenics_mech.accuracy.periodic_errors import answer_of
from fenics_mech.accuracy.quantities import Quantities, measures
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.effects import Loads
from fenics_mech.eigenmodes import Modes
from fenics_mech.errors import SolverError, percent
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.joint_forces import Reactions, nodal_forces, reactions
from fenics_mech.forces.joint_maps import RIGID, JointMaps, attachments, joint_maps
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.solution import (
    CollocationSolution,
    HarmonicSolution,
    PeriodicSolution,
    Solution,
    StaticSolution,
)
from fenics_mech.response.static.quasi_static import held_still, solve_static, yielding_to
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class JointLimits:
    """How much of an answer joints may leave out."""

    little: float = 1e-2  # of what is left out, with both signs: exact strains of stiff members answer in proportion
    margin: float = 1.25  # on the first order, which is 0.8 to 1.1 of the truth: without it 1 % could pass untold
    counted: float = 1e-3  # share of a strain, deflection or joint force from which it counts as an error
    warned: float = 0.01  # the same, from which it is told
    refused: float = 0.05  # the same, from which the answer is refused: then its first order says no more
    of_stiffness: float = 0.25  # of the stiffness in statics, from which buckling loads are not those that are told


JOINTS = JointLimits()


@dataclass(frozen=True)
class LeftByJoints:
    """What rigid arms and guides of a motion are wrong by.

    Parameters
    ----------
    place
        The rigid link or the guide that leaves out most, in words.
    turn
        Its largest elastic rotation (rad).
    theta
        The drive angle of that (rad).
    errors
        Largest change of each quantity, as `Quantities.largest`.
    share
        The largest of these, over what errors are relative to.
    frequency
        By which share natural frequencies are wrong at most; 0 where there are none.
    buckling
        Share of the stiffness at rest that is left out and would be taken away; 1 or more where it buckles.
    """

    place: str
    turn: float
    theta: float
    errors: Mapping[str, Array]
    share: float
    frequency: float
    buckling: float

    def refuse(self, scene: Scene) -> None:
        """Raise `SolverError` where the answer is of no use, unless the scene lets it pass.

        Parameters
        ----------
        scene
            The scene.
        """
        if scene.analysis.allow_large or (self.share < JOINTS.refused and self.buckling < 1):
            return
        at = f"at drive angle {np.degrees(self.theta):.6g} deg"
        what = f"about {percent(self.share)} of the answer"
        if self.buckling >= 1:
            what, at = "so much of the stiffness that the mechanism buckles", "under this load"
        cycle = scene.analysis.method == "periodic" and bool(scene.drives)
        exact = "Take analysis.solver = 'poses', which leaves nothing out there. Else: " if cycle else ""
        raise SolverError(
            f"{self.place} turns elastically by {self.turn:.3g} rad {at}. The moment of the forces by this turn is "
            f"left out of rigid arms and guides, which is {what}. {exact}{remedy(self.place)}; "
            "analysis.allow_large lets it pass"
        )

    @property
    def attributes(self) -> dict[str, float | str]:
        """What a result says of it."""
        return {
            "joints_place": self.place,
            "joints_turn": self.turn,
            "joints_share": self.share,
            "joints_frequency": self.frequency,
            "joints_buckling": self.buckling,
        }

    def added_to(self, errors: Errors) -> Errors:
        """Give errors of the same motion with these, as the source "joints".

        Parameters
        ----------
        errors
            The errors.
        """
        if self.share < JOINTS.counted:
            return errors
        found = {name: {**parts, "joints": self.errors[name]} for name, parts in errors.errors.items()}
        return replace(errors, errors=found, order=errors.order | {"joints": 0.0})


def in_frequencies(place: str, share: float) -> str:
    """Say that natural frequencies lack the moment of forces by the turn of a rigid arm or a guide.

    Parameters
    ----------
    place
        The rigid link or the guide, in words.
    share
        By which share that changes one of them.
    """
    return (
        f"The moment of the forces on {place} by its turn is left out of the natural frequencies of the mechanism held "
        f"in a position, of which it changes one by about {percent(share)}; those about the motion have it on arms. "
        f"{remedy(place)}"
    )


def remedy(place: str) -> str:
    """Say what makes less of what a rigid arm or a guide leaves out.

    Parameters
    ----------
    place
        The rigid link or the guide, in words.
    """
    if place.startswith(RIGID):
        return "Take a stiff member that bends in place of `rigid`, with effects = 'auto', or lower loads or speed"
    return "Lower loads or speed, or take stiffer members"


def left_by_joints(solution: Solution, system: System, found: Reactions) -> LeftByJoints | None:
    """Estimate what rigid arms and guides of a motion are wrong by.

    Parameters
    ----------
    solution
        The motion.
    system
        Its mechanism, as forces act on it.
    found
        Forces of the joints.

    Returns
    -------
    LeftByJoints or None
        None where no link is rigid, and no guide is on a link that moves.
    """
    scene, response = solution.scene, solution.response.undamped
    maps = joint_maps(scene, system, response, found)
    if not maps.motions:
        return None
    sizes = maps.sizes(system.to_links(response.displacement))
    missing = np.einsum("tij,tj->ti", maps.stiffnesses, sizes)
    k, i = np.unravel_index(np.abs(missing * sizes).argmax(), sizes.shape)
    turn = next((n for n in (i, i - 1) if n in _turns(maps)), i)
    base = Quantities.of(scene, system, response)
    loads, moved = _left_out(scene, maps, sizes)
    both = [loads.of_columns(sign * JOINTS.little * loads.columns()) for sign in (1.0, -1.0)]
    more, less = (Quantities.of(scene, system, *pair) for pair in zip(_answers(solution, system, both), both))
    change = (more - less).with_nodes(system, 2 * JOINTS.little * moved)
    errors = {name: JOINTS.margin / (2 * JOINTS.little) * part for name, part in change.largest.items()}
    of = measures(scene, base.largest)
    shares = [float((errors[name] / of[name]).max(initial=0.0)) for name in ("strain", "deflection", "joint_force")]
    return LeftByJoints(
        place=maps.motions[i].place,
        turn=float(np.abs(sizes[:, turn]).max()),
        theta=float(system.motion.theta[k]),
        errors=errors,
        share=max(shares),
        frequency=_of_frequencies(solution.modes, maps) if isinstance(solution, PeriodicSolution) else 0.0,
        buckling=_of_stiffness(solution, maps) if isinstance(solution, StaticSolution) else 0.0,
    )


def _turns(maps: JointMaps) -> set[int]:
    return {*maps.turns.values(), *(guide.turn for guide in maps.guides.values())}


def _left_out(scene: Scene, maps: JointMaps, sizes: Array) -> tuple[Loads, Array]:
    """Give what the joints leave out: loads on the nodes and the ends of elements, and displacements of the nodes."""
    system, ends = maps.system, attachments(scene, maps.system)
    separated = system.transformation.displacement_off(
        system.motion, lambda equation: maps.off(equation, sizes, ends[equation.joint])
    )
    v, force = system.on_nodes(given_way(system, separated)), maps.forces(sizes)
    for entries in system.added_stiffness:
        force = force - entries.times(v)
    held = each(system.beams.element_stiffness, in_member_axes(system.beams.mesh, v))
    return Loads(force=force, ends=-held), v


def _answers(solution: Solution, system: System, loads: Sequence[Loads]) -> list[ElasticResponse]:
    """Give a motion under small loads more, for each of these."""
    match solution:
        case CollocationSolution() | HarmonicSolution():
            answer = answer_of(solution)
        case _:
            response = solution.response.undamped
            q = response.displacement
            changes = (_at_rest(system, q, system.on_coordinates_by(part)) for part in loads)
            return [replace(response, displacement=q + change) for change in changes]
    return [answer.changed(answer.to(part), part) for part in loads]


def _at_rest(system: System, q: Array, load: Array) -> Array:
    """Give the answer of a displacement q to a small load without inertia."""
    if system.terms.law is None:
        return yielding_to(system, load)
    return Equation(held_still(system)).about(q, np.zeros_like(q)).stiffness.solve(load)


def left_out_of_frequencies(scene: Scene, system: System, modes: Callable[[], Modes]) -> tuple[str, float] | None:
    """Tell by which share natural frequencies are wrong under the forces of the rigid motion, and where.

    Parameters
    ----------
    scene, system
        The scene and its mechanism.
    modes
        Gives its modes, where there are such joints.

    Returns
    -------
    tuple or None
        The rigid link or the guide in words, and the share; None where the mechanism has no static answer, or none
        of them.
    """
    linear = system.with_terms(replace(system.terms, law=None))
    try:
        response = solve_static(linear)
    except SolverError:
        return None
    maps = joint_maps(scene, linear, response, reactions(linear, nodal_forces(linear, response)))
    if not maps.motions:
        return None
    i = int(np.abs(maps.stiffnesses).max(axis=(0, 2)).argmax())
    return maps.motions[i].place, _of_frequencies(modes(), maps)


@contextmanager
def naming_joints(scene: Scene, system: System, modes: Callable[[], Modes]) -> Iterator[None]:
    """Add what joints leave out of frequencies to a `SolverError` of a motion that is not found or not stable.

    Parameters
    ----------
    scene, system
        The scene and its mechanism.
    modes
        Gives its modes, where a motion is not found.
    """
    try:
        yield
    except SolverError as error:
        left = left_out_of_frequencies(scene, system, modes)
        if left is None or left[1] < JOINTS.refused:
            raise
        named = type(error)(f"{error}. That may be wrong: {in_frequencies(*left)}")
        named.found_up_to = error.found_up_to
        raise named from error


def _of_frequencies(modes: Modes, maps: JointMaps) -> float:
    """Give the largest share by which a natural frequency is wrong, by Rayleigh's quotient: ``u C u/(2 omega^2)``."""
    system, largest = maps.system, 0.0
    for m in range(modes.omega.shape[1]):
        sizes = maps.sizes(system.to_links(modes.shapes[:, m]))
        change = np.einsum("ti,tij,tj->t", sizes, maps.stiffnesses, sizes)  # the shapes have the modal mass 1
        largest = max(largest, float(np.abs(change / (2 * modes.omega[:, m] ** 2)).mean()))
    return JOINTS.margin * largest


def _of_stiffness(solution: StaticSolution, maps: JointMaps) -> float:
    """Give the largest share of the stiffness that would be taken away: K + U C U' is singular where it is 1."""
    system, q = maps.system, solution.response.displacement
    units = [motion.forces(np.ones(len(q)), system.transformation.height) for motion in maps.motions]
    moved = [_at_rest(system, q, system.on_coordinates(unit)) for unit in units]
    flexible = np.stack([maps.sizes(system.to_links(one)) for one in moved], axis=2)
    share = -np.linalg.eigvals(flexible @ maps.stiffnesses).real.min(axis=1)
    return float(max(share.max(initial=0.0), 0.0))
