"""What the joints hold: rows of small displacements of nodes and of the joints' own coordinates (4.41).

Every joint states rows G of ``G d = 0``. They are solved for as many unknowns; the others are the coordinates q.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.scene import Prismatic, Revolute, Scene, Slot, Weld

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # a quarter turn


def turns(angle: Array) -> Array:
    """Rotation matrices (7.3), ``(..., 2, 2)``."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)


def own_coordinates(scene: Scene) -> list[str]:
    """Name the joints' own coordinates: X and Y of pins that move, and slides in guides that no drive leads."""
    driven, names = {drive.joint for drive in scene.drives}, []
    for name, joint in scene.joints.items():
        if isinstance(joint, Slot | Prismatic):
            names += [f"{name}.slide"] if name not in driven else []
        elif not any(point.startswith("ground.") for point in joint.connect):
            names += [f"{name}.X", f"{name}.Y"]
    return names


@dataclass
class JointRows:
    """Rows of all joints at some poses, gathered joint by joint."""

    # The scene and its mesh. Unknowns are three of every node, in link axes, and the joints' own coordinates.
    scene: Scene
    mesh: BeamMesh
    # Place X, Y (m) and angle (rad) of every link's frame, (positions, links, 3). Complex ones give derivatives.
    pose: Array
    parts: list[list[tuple[Index, Array]]] = field(default_factory=list)

    def whole(self) -> tuple[Index, Array]:
        """Give the unknowns that joints look at, and G over them, ``(positions, rows, these unknowns)``."""
        driven = {drive.joint for drive in self.scene.drives}
        for name, joint in self.scene.joints.items():
            if isinstance(joint, Slot | Prismatic):
                self._guide(name, joint, name in driven)
            else:
                self._pin(name, joint, name in driven)
        columns = np.unique(np.concatenate([at for parts in self.parts for at, _ in parts]))
        rows = []
        for parts in self.parts:
            row = np.zeros((len(self.pose), parts[0][1].shape[-2], len(columns)), self.pose.dtype)
            for at, values in parts:
                row[:, :, np.searchsorted(columns, at)] += values
            rows.append(row)
        return columns, np.concatenate(rows, axis=1)

    def _pin(self, name: str, joint: Revolute | Weld, driven: bool) -> None:
        """All points of a pin move as it does, at a weld or a drive with one rotation."""
        grounded = [point for point in joint.connect if point.startswith("ground.")]
        pin = [] if grounded else [self._own(f"{name}.X", [[-1], [0]]), self._own(f"{name}.Y", [[0], [-1]])]
        for point in joint.connect:
            if point not in grounded:
                columns, moved = self._end(point)
                self._hold((columns, moved[:, :2]), *pin)
        if isinstance(joint, Weld) or driven:
            self._turn(joint.connect)

    def _guide(self, name: str, joint: Slot | Prismatic, driven: bool) -> None:
        """The pin moves as the guide does where it is, and along it unless a drive leads it."""
        (first, angle), (second, _) = map(self._place, joint.connect)
        (one, guide), (two, pin) = map(self._end, joint.connect)
        along = turns(angle + joint.angle)[..., 0]
        lever = ((second - first) @ QUARTER.T)[..., None]  # the guide's rotation swings the pin
        slide = [] if driven else [self._own(f"{name}.slide", -along[..., None])]
        self._hold((two, pin[:, :2]), (one, -guide[:, :2] - lever * guide[:, 2:]), *slide)
        if isinstance(joint, Prismatic):
            self._turn(joint.connect)

    def _turn(self, points: tuple[str, ...]) -> None:
        """Hold the angle between two bodies."""
        (one, first), (two, second) = map(self._end, points[:2])
        self._hold((two, second[:, 2:]), (one, -first[:, 2:]))

    def _hold(self, *parts: tuple[Index, Array]) -> None:
        self.parts.append(list(parts))

    def _own(self, name: str, values: object) -> tuple[Index, Array]:
        return np.array([3 * len(self.mesh.node_name) + own_coordinates(self.scene).index(name)]), np.asarray(values)

    def _place(self, point: str) -> tuple[Array, Array]:
        """Place of a point in the fixed frame, and the angle of its body."""
        body, at = self.scene.point(point)
        if body == "ground":
            return np.broadcast_to(np.array(at), (len(self.pose), 2)), np.zeros(len(self.pose))
        here = self.pose[:, list(self.scene.links).index(body)]
        return here[:, :2] + turns(here[:, 2]) @ np.array(at), here[:, 2]

    def _end(self, point: str) -> tuple[Index, Array]:
        """Columns of a point, and its displacement X, Y and rotation by them ``(positions, 3, columns)``."""
        body, at = self.scene.point(point)
        if body == "ground":
            return np.zeros(0, dtype=np.int64), np.zeros((len(self.pose), 3, 0))
        rigid = self.scene.links[body].rigid
        moved = np.tile(np.eye(3, dtype=self.pose.dtype), (len(self.pose), 1, 1))
        if rigid is not None:
            moved[:, :2, 2] = QUARTER @ np.subtract(at, rigid.centre)
        moved[:, :2] = turns(self.pose[:, list(self.scene.links).index(body), 2]) @ moved[:, :2]
        node = self.mesh.node(point if rigid is None else f"{body}.centre")
        return 3 * node + np.arange(3), moved
