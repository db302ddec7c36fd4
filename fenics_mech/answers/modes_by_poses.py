"""A scene's machine at rest in positions of its cycle, and its natural modes there, by the equation of poses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.answers.solved_by_poses import built, instants_of, moves_of, with_effects
from fenics_mech.effects.known import STIFFENING, VIBRATION
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.kinematics import coordinates
from fenics_mech.machine.along_members import cubic_places, elements_at
from fenics_mech.machine.free_motions import describe, row_reduced
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.stated_freedoms import with_freedoms
from fenics_mech.scene import Friction, Scene
from fenics_mech.scene.damping_options import Damping
from fenics_mech.scene.drives import Drive, Harmonics
from fenics_mech.solve import BESIDE, FollowedModes, about_motion, followed_modes, forces_about

LARGEST_KNOWN = 0.2  # error of a frequency by the mesh, which means that or more
LITTLE = 1e-6  # of the machine's extent, by which shapes move it: squares of it are rounding
IDLE = 1e-12  # of what the stiffness resists: a load below it is rounding of drawn places


def at_rest(scene: Scene) -> Scene:
    """Give a scene whose machine is held at positions: freedoms at their start, members in all of their nodes."""
    analysis = scene.analysis
    if scene.freedoms:
        scene = with_freedoms(scene)
        held = tuple(
            Drive(joint=name, law=Harmonics(mean=freedom.start or 0.0), period=scene.period)
            for name, freedom in scene.freedoms.items()
        )
        scene = scene.model_copy(update={"drive": (*scene.drives, *held), "freedoms": {}})
    rests = analysis.method == "static" or all(drive.speed is None and drive.law is None for drive in scene.drives)
    options = {"method": "static" if rests else "quasi-static", "allow_coarse": True}
    return scene.model_copy(update={"analysis": analysis.model_copy(update=options)})


def over_cycle(scene: Scene, positions: int) -> Scene:
    """Give a scene whose machine is held at so many positions of its cycle, without axial forces."""
    analysis = scene.analysis.model_copy(update={"sub_intervals": positions, "method": "quasi-static"})
    scene = with_effects(scene)
    listed = tuple(name for name in scene.named_effects if name not in (VIBRATION, STIFFENING))
    return at_rest(scene.model_copy(update={"effects": listed, "analysis": analysis}))


def undamped(scene: Scene) -> Scene:
    """Give a scene without damping, dampers and friction."""
    laws = {name: law for name, law in scene.joint_laws.items() if not isinstance(law, Friction)}
    return scene.model_copy(update={"damping": Damping(), "dampers": {}, "joint_laws": laws})


def modes_kept(modes: int | Literal["all"], size: int) -> int:
    """Give the number of modes that are kept of a machine with so many."""
    return size if modes == "all" else min(modes, size)


@dataclass(frozen=True)
class HeldMachine:
    """A scene's machine at rest in positions."""

    made: SceneMachine  # it, without damping
    t: Array  # instants at which its chart is in the positions (s)

    @classmethod
    def of(cls, scene: Scene, coarse: HeldMachine | None = None) -> HeldMachine:
        """Build it, with all contacts closed."""
        made = built(undamped(scene), None if coarse is None else coarse.made.machine)
        for term in made.machine.terms:
            if isinstance(term, LawTerm) and term.contacts:
                term.shut()
        return cls(made, instants_of(scene))

    @property
    def moving(self) -> bool:
        """Whether the drives go on from the positions."""
        return self.made.scene.analysis.method != "static"

    @cached_property
    def every(self) -> FollowedModes:
        """The modes that the scene asks for, followed over the positions, and some more, as far as there are."""
        scene, machine = self.made.scene, self.made.machine
        asked, about = scene.analysis.modes, None
        moves = moves_of(self.made)
        loose = None if moves is None else moves[1]
        if STIFFENING in scene.named_effects:
            about = forces_about(machine, self.t, self.moving)
        count = None if asked == "all" else asked + BESIDE + (0 if loose is None else loose.shape[1])
        return followed_modes(machine, self.t, count, about=about, loose=loose, options=scene.petsc)

    @cached_property
    def count(self) -> int:
        """How many of them are asked for: rigid motions come before those."""
        found = self.every.omega
        rigid = int((found[0] == 0).sum())
        return rigid + modes_kept(self.made.scene.analysis.modes, found.shape[1] - rigid)

    @cached_property
    def modes(self) -> FollowedModes:
        """The modes that the scene asks for."""
        return self.every.only(np.arange(self.count))

    @property
    def frequency(self) -> Array:
        """Natural frequencies ``(positions, modes)`` (Hz)."""
        return self.modes.omega / (2 * np.pi)

    def running(self, moving: bool | None = None) -> Array | None:
        """Give frequencies about the motion and the loads ``(positions, modes)`` (Hz); None where neither is there."""
        moving = self.moving if moving is None else moving
        if (self.every.omega[0] == 0).any() or not (moving or self._loaded):
            return None
        found = about_motion(self.made.machine, self.t, self.every, moving, self.count)
        return found[:, : self.count] / (2 * np.pi)

    @property
    def _loaded(self) -> bool:
        machine = self.made.machine
        zero = np.zeros((len(self.t), machine.size))
        found = machine.residual(self.t, zero, zero, zero, moving=False)
        resisted = machine.pattern.times(np.abs(found.K), np.broadcast_to(machine.units, zero.shape))
        return bool((np.abs(found.force) > IDLE * resisted)[:, : machine.n].any())

    @cached_property
    def free(self) -> list[str]:
        """Say which rigid motions nothing holds."""
        scene, rigid = self.made.scene, self.modes.shapes[0][:, self.modes.omega[0] == 0]
        if not rigid.shape[1] or (moves := moves_of(self.made)) is None:
            return []
        motion, ways = moves
        parts = np.linalg.lstsq(ways[: len(rigid)], rigid, rcond=None)[0].T
        parts = row_reduced(parts, np.zeros(ways.shape[1], dtype=bool))
        q = coordinates(motion.position, motion.angle)[0]
        return describe(scene, q, np.einsum("mf,fli->mli", parts, motion.free))

    # ---- shapes ----
    def _little(self, shape: Array) -> tuple[float, Array]:
        """Give a share of a shape ``(positions, n)`` that moves the machine little, and its coordinates."""
        size = self.made.machine.size
        whole = np.pad(shape, ((0, 0), (0, size - shape.shape[1])))
        share = LITTLE / max(float(np.abs(whole / self.made.machine.units).max()), 1e-300)
        return share, share * whole

    def along(self, shapes: Array, places: Array) -> Array:
        """Give displacements of the members' axes by shapes ``(positions, shapes, members, places, 2)``."""
        # shapes: coordinates ``(positions, n, shapes)``
        made, found, zero = self.made, [], np.zeros((len(self.t), self.made.machine.size))
        for shape in np.moveaxis(shapes, 2, 0):
            share, q = self._little(shape)
            ahead, behind = (Motion(made.machine, self.t, x, zero, zero, False).found for x in (q, -q))
            moved = cubic_places(made, ahead, places) - cubic_places(made, behind, places)
            found.append(moved / (2 * share))
        return np.stack(found, axis=1) + self._beside_neutral(shapes, places)

    def _beside_neutral(self, shapes: Array, places: Array) -> Array | float:
        """Give how far axes move beyond neutral lines that are beside them, as sections turn; as of `along`."""
        made, machine = self.made, self.made.machine
        assert made.links is not None
        if (offsets := made.links.layout.offsets) is None:
            return 0.0
        elements, share, _ = elements_at(made.links.mesh, places)
        first, second = (np.array([ends[side].pose for ends in made.element_ends])[elements] for side in (0, 1))
        turns = np.pad(shapes, ((0, 0), (0, 1), (0, 0)))[:, machine.places[:, 2]]
        turn = (1 - share)[:, None] * turns[:, first] + share[:, None] * turns[
            :, second
        ]  # (positions, stations, shapes)
        own = np.array([ends[0].turn[:, 0] for ends in made.element_ends])[elements]
        along = (machine.known.at(self.t).R[:, first] @ own[..., None])[..., 0]
        moved = np.einsum("n,pnm,pnc->pmnc", offsets.neutral[elements], turn, along)
        return moved.reshape(*moved.shape[:2], -1, len(places), 2)

    def of_nodes(self, shapes: Array) -> Array:
        """Give displacements of the nodes in the axes of their links ``(positions, modes, nodes, 3)`` (m, rad)."""
        # shapes: coordinates ``(positions, n, modes)``
        made, machine = self.made, self.made.machine
        assert made.links is not None
        mesh, poses, frames = made.links.mesh, np.array(made.node_pose), made.bodies.frames()
        names = list(made.scene.links)
        drawn = [(frames[names[link]], xy) for link, xy in zip(mesh.node_link, mesh.node_xy)]
        ends = [machine.end(pose, place + axes @ xy, axes) for pose, ((place, axes), xy) in zip(poses, drawn)]
        turn, offset = np.array([end.turn for end in ends]), np.array([end.offset for end in ends])
        axes = machine.known.at(self.t).R[:, poses] @ turn  # of the links
        whole = np.pad(shapes, ((0, 0), (0, 1), (0, 0)))[:, machine.places[poses]]  # (positions, nodes, 3, modes)
        found = np.moveaxis(whole, -1, 1)
        x, y = np.einsum("nji,nj->in", turn, offset)  # in the link's axes
        place = np.einsum("pnji,pmnj->pmni", axes, found[..., :2])
        angle = found[..., 2]
        return np.stack([place[..., 0] - angle * y, place[..., 1] + angle * x, angle], axis=-1)
