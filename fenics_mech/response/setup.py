"""From a scene to its mechanism at the drive angles, with the effects that act in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._guard import guarded
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.made_once import LastMade
from fenics_mech.beams.mesh import BeamMesh, mesh_depends_on, mesh_scene
from fenics_mech.effects import EFFECTS, NOTHING, AxialForces, Situation, build_terms
from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import axial_forces, uneven_tension
from fenics_mech.kinematics import Linkage, Motion, refuse_unresolved, solve_motion
from fenics_mech.kinematics.free_linkage import FreeLinkage
from fenics_mech.kinematics.freedom import describe, nothing_holds
from fenics_mech.kinematics.linkage import CACHE
from fenics_mech.kinematics.motion import coordinates
from fenics_mech.mechanism import RigidModes, System, build_system
from fenics_mech.mechanism.beam_links import links as build_links
from fenics_mech.mechanism.beam_links import links_depend_on
from fenics_mech.mechanism.rigid import RIGID
from fenics_mech.response.sampling_checks import require_positions
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.scene import Link, Scene
from fenics_mech.scene.joints import Joint
from fenics_mech.scene.springs_dampers import Hinge
from fenics_mech.solve.last_motions import LastMotions

if TYPE_CHECKING:
    from fenics_mech.effects.effect import Choice
    from fenics_mech.response.periodic.known_motion import KnownMotion
    from fenics_mech.response.solution import Solution


class CommonParts:
    """Meshes, links and linkages of the scenes of a study, each made once for all scenes that have it in common.

    Meshes are in common where points and members are, links where sections, materials and point masses are too, and
    linkages where the positions are. With them goes what is made of both without a rate of the drive: P and its
    derivatives, and modes that no axial force changes.

    Parameters
    ----------
    begin_from_last
        Let Newton's method begin each motion from the last ones on the same mesh: beyond them on a straight line.
        Motions under exact strains then agree with those of other beginnings to the tolerance of Newton's method; else
        they agree to the last bit.
    """

    def __init__(self, begin_from_last: bool = False) -> None:
        self.last: LastMotions[Any] | None = LastMotions() if begin_from_last else None
        self._meshes, self._links = LastMade(CACHE.most_shared), LastMade(CACHE.most_shared)
        self._linkages: list[Linkage] = []

    def links(self, scene: Scene) -> Beams:
        """Give the links of a scene.

        Parameters
        ----------
        scene
            The scene.
        """
        return self._links.once(links_depend_on(scene), build_links, scene, self._mesh)

    def _mesh(self, scene: Scene, loads_at_nodes: bool) -> BeamMesh:
        """Give the mesh of a scene's members."""
        return self._meshes.once(mesh_depends_on(scene, loads_at_nodes), mesh_scene, scene, loads_at_nodes)

    def linkage(self, scene: Scene) -> Linkage:
        """Give the linkage of a scene that has drives.

        Parameters
        ----------
        scene
            The scene.
        """
        found = next((linkage for linkage in self._linkages if linkage.moves_as(scene)), None)
        if found is None:
            found = Linkage(scene)
            self._linkages = [*self._linkages, found][-CACHE.most_shared :]
        return found

    def near(self, beams: Beams) -> KnownMotion | None:
        """Give a motion on the mesh of links from which the next is to begin, if it is to.

        Parameters
        ----------
        beams
            The links.
        """
        if self.last is None:
            return None
        return self.last.near(lambda motion: getattr(motion, "mesh", None) is beams.mesh)

    def keep(self, motion: KnownMotion) -> None:
        """Keep a motion for the next to begin from, if it does.

        Parameters
        ----------
        motion
            The motion.
        """
        if self.last is not None:
            self.last.keep(motion)

    def answered(self, solution: Solution, fields: Any, choices: Sequence[Choice]) -> None:
        """Take note of the answer of each analysis: studies that need it do, here nothing is done.

        Parameters
        ----------
        solution, fields
            The response, and what was recovered from it.
        choices
            What was decided about each effect.
        """

    def motion(self, scene: Scene, theta: Array) -> Motion:
        """Give the motion of a scene's links at drive angles; without a drive, the linkage at rest.

        Parameters
        ----------
        scene
            The scene.
        theta
            Drive angles (rad), ``(angles,)``.
        """
        return self.linkage(scene).motion(theta, scene.cycle_rate) if scene.drives else solve_motion(scene, theta)


@guarded()
def mechanism(
    scene: Scene, progress: Callable[[str], None] = lambda step: None, common: CommonParts | None = None
) -> System:
    """Build the mechanism at equal steps over a cycle, or at its one position when nothing drives it.

    Parameters
    ----------
    scene
        The scene.
    progress
        Called with the name of each step as it begins.
    common
        What it may have in common with other scenes of a study.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at some drive angle.
    SceneError
        When the cycle and its results need more memory than there is, or its positions miss a corner of the motion.
    """
    common = common or CommonParts()
    moves = scene.moved_joints and scene.analysis.method != "static"
    require_positions(scene, scene.analysis.sub_intervals if moves else 1)
    progress("kinematics")
    if scene.freedoms or (scene.joint_laws and scene.analysis.method == "transient"):
        motion = FreeLinkage(scene).at_start()
    elif scene.analysis.method == "static":
        motion = common.motion(scene, np.array([scene.analysis.position])).held()
    else:
        motion = common.motion(scene, scene.drive_angles(scene.analysis.sub_intervals) if scene.drives else np.zeros(1))
        if motion.path and scene.analysis.method != "transient" and not scene.analysis.allow_coarse:
            refuse_unresolved(motion.path, vibrates=scene.analysis.method == "periodic")
    progress("beams")
    return system_at(scene, common.links(scene), motion)


def system_at(scene: Scene, beams: Beams, motion: Motion) -> System:
    """Build the mechanism at the angles of a motion, with its effects.

    Parameters
    ----------
    scene
        The scene.
    beams
        The links' matrices.
    motion
        The rigid motion.
    """
    return _with_effects(scene, build_system(scene, beams, motion))


def moved(scene: Scene, system: System, motion: Motion) -> System:
    """Take a mechanism to another motion with the same coordinates, which `system_at` may choose anew.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.
    motion
        The other rigid motion.
    """
    return _with_effects(scene, replace(system, motion=motion, terms=NOTHING))


def _with_effects(scene: Scene, bare: System) -> System:
    situation = Situation(
        scene,
        bare.beams,
        bare.motion,
        tension=lambda: _rigid_axial_forces(scene, bare),
        uneven=lambda: _rigid_uneven_tension(scene, bare),
    )
    return replace(bare, terms=build_terms(situation))


def _rigid_uneven_tension(scene: Scene, bare: System) -> Array:
    """Half of what axial forces of loads and rigid motion change along each element (N), ``(angles, elements)``.

    Nothing has to be solved for it. Of a motion with freedoms it is that of the loads: inertia that counts in the
    mass of the freedoms and not in that of the links would leave a mass that is not positive.
    """
    system = without_stiffening(scene, replace(bare, motion=bare.motion.held()) if scene.freedoms else bare)
    still = np.zeros((len(system.motion.theta), system.size))
    return uneven_tension(system, ElasticResponse(still, system.rigid_acceleration))


def without_stiffening(scene: Scene, bare: System) -> System:
    """Give the mechanism whose axial forces do not act on its bending.

    Parameters
    ----------
    scene
        The scene.
    bare
        Its mechanism without effects.
    """
    linear = tuple(name for name in scene.named_effects if not EFFECTS[name].stress_stiffening)
    return _with_effects(scene.model_copy(update={"effects": linear}), bare)  # read anew it would take longer


def _rigid_axial_forces(scene: Scene, bare: System) -> AxialForces:
    """Give the axial forces of the elements from loads and rigid motion."""
    system = without_stiffening(scene, bare)
    return axial_forces(system, static_response(scene, system))


def rough_tension(scene: Scene, system: System) -> Array | None:
    """Axial force of each element from loads and rigid motion (N), where the links have a nonlinear law.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.

    Returns
    -------
    numpy.ndarray or None
        Shape ``(angles, elements)``; None in linear theory.
    """
    return None if system.terms.law is None else _rigid_axial_forces(scene, system).mean


def static_response(scene: Scene, system: System) -> ElasticResponse:
    """Solve for the static or quasi-static response, as far as something holds the mechanism.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.

    Raises
    ------
    SceneError
        When loads move a rigid-body mode of a mechanism that is to stay at rest. When large rotations are asked for
        where there is such a mode.
    SolverError
        When there is no answer, or springs let a whole link turn too far for small motions.
    """
    if not len(system.motion.free):
        return solve_static(system)
    at_rest, rigid = scene.analysis.method == "static", RigidModes.of(system)
    if unconstrained := rigid.moved_by(system.load[0]) if at_rest else []:
        raise nothing_holds(freedoms_in_words(scene.links, scene.joints, system, rigid, unconstrained))
    if len(rigid) and system.terms.law is not None:
        free = "; ".join(freedoms_in_words(scene.links, scene.joints, system, rigid))
        raise SceneError(
            f"the effect {LARGE_ROTATIONS.name!r} needs a mechanism that is held: {free}",
            place="effects",
            hint="Add a drive, a spring or a support, or leave the effect out",
        )
    response = solve_static(system, RigidModes.of(system, symmetric=False) if at_rest else None)
    _refuse_turned(scene, system, response)
    return response


def _refuse_turned(scene: Scene, system: System, response: ElasticResponse) -> None:
    """Raise `SolverError` where what holds the mechanism lets a whole link turn too far for small motions."""
    turned = np.abs(system.to_links(response.displacement)[:, 2::3])
    hinges = all(isinstance(spring, Hinge) for spring in scene.springs.values())
    exact = system.terms.law is not None and hinges  # then elastic links may turn
    looked_at = [i for i, link in enumerate(scene.links.values()) if link.rigid is not None or not exact]
    least = np.array([turned[:, system.beams.mesh.node_link == i].min() for i in looked_at])
    if least.max(initial=0.0) > RIGID.turn:
        farthest = list(scene.links)[looked_at[int(least.argmax())]]
        raise SolverError(
            f"what holds the mechanism lets link {farthest} turn by {least.max():.3g} rad from its rough angle, and "
            f"small motions end at {RIGID.turn} rad. "
            "Give angles near to the equilibrium, or stiffer springs"
        )


def freedoms_in_words(
    links: Mapping[str, Link],
    joints: Mapping[str, Joint],
    system: System,
    rigid: RigidModes,
    which: Sequence[int] | None = None,
) -> list[str]:
    """Say of freedoms that nothing holds what moves in them.

    Parameters
    ----------
    links, joints
        The linkage, by name.
    system
        Its mechanism.
    rigid
        Its rigid-body modes.
    which
        Numbers of the freedoms; by default all.
    """
    motion = system.motion
    motions = np.einsum("mf,fli->mli", rigid.freedoms, motion.free)
    q = coordinates(motion.position, motion.angle)[0]
    return describe(links, joints, q, motions if which is None else motions[list(which)])
