"""The linkage: what its joints hold, and the motion of its links as if they were rigid (chapter 6).

Poses are X, Y (m) and the angle (rad) of each link's frame, and last those of the ground. Every joint states rows G of
``G d = 0`` over small displacements d of what it joins. Rigid links, whose frames they move, and the nodes of bending
links have the same rows: the first give the motion, the second P(theta).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index, solved, times
from fenics_mech.errors import AssemblyError
from fenics_mech.scene import Prismatic, Revolute, Scene, Slot, Weld
from fenics_mech.scene.formulas.expression import Jet

End = Callable[[str], tuple[Index, Array]]
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # a quarter turn
IMAGINARY = 1e-30  # step of derivatives by complex numbers, which lose no digits
COARSE = 120  # parts of a cycle in which the branch is followed: links turn by few degrees in each
ITERATIONS = 20  # of Newton's method, of which a start from rough angles takes up to 7
CLOSED = 1e-8  # of the largest link: Newton's method squares what is left open, which then is rounding
LOCKED = 1e10  # condition of the rows: beyond it a dead centre leaves few digits of the motion
FARTHEST = math.pi / 2  # of an assembled link from its rough angle: beyond it another branch was meant


@dataclass(frozen=True)
class Motion:
    """The rigid motion.

    Parameters
    ----------
    pose, rate, second
        Poses of the links and the ground, with two time derivatives, ``(positions, links + 1, 3)`` each.
    """

    pose: Array
    rate: Array
    second: Array


def turns(angle: Array) -> Array:
    """Rotation matrices (7.3), ``(..., 2, 2)``."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)


def own_coordinates(scene: Scene) -> list[str]:
    """Name the joints' own coordinates: X and Y of pins that move, slides in guides, and last what drives lead."""
    driven, names = [drive.joint for drive in scene.drives], []
    for name, joint in scene.joints.items():
        if isinstance(joint, Slot | Prismatic):
            names += [f"{name}.slide"] if name not in driven else []
        elif not any(point.startswith("ground.") for point in joint.connect):
            names += [f"{name}.X", f"{name}.Y"]
    return names + [f"{name}.driven" for name in driven]


@dataclass
class JointRows:
    """Rows of the joints at some poses, gathered joint by joint.

    Parameters
    ----------
    scene
        The scene.
    pose
        Poses of the links and the ground, ``(positions, links + 1, 3)``.
    led
        What each drive leads (rad or m), ``(positions, drives)``.
    end
        Gives the columns of a point, "link.point" or "ground.point", and its displacement X, Y and rotation by them,
        ``(positions, 3, columns)``.
    width
        Number of columns; those of the joints' own coordinates follow.
    """

    scene: Scene
    pose: Array
    led: Array
    end: End
    width: int

    def __post_init__(self) -> None:
        self.own, self.links = own_coordinates(self.scene), [*self.scene.links, "ground"]
        self.driven = [drive.joint for drive in self.scene.drives]
        self.rows: list[Array] = []
        self.gaps: list[Array] = []

    @classmethod
    def of(cls, scene: Scene, pose: Array, led: Array, end: End, width: int) -> tuple[Array, Array]:
        """Give G, ``(positions, rows, columns)``, and by how much each row is open, ``(positions, rows)``."""
        here = cls(scene, pose, led, end, width)
        for name, joint in scene.joints.items():
            if isinstance(joint, Slot | Prismatic):
                here._guide(name, joint)
            else:
                here._pin(name, joint)
        return np.concatenate(here.rows, axis=1), np.concatenate(here.gaps, axis=1)

    def _pin(self, name: str, joint: Revolute | Weld) -> None:
        """All points of a pin move as it does (4.41), at a weld or a drive with one rotation."""
        grounded = [point for point in joint.connect if point.startswith("ground.")]
        at = self._place((*grounded, joint.connect[0])[0])[0]
        for point in joint.connect:
            if point not in grounded:
                columns, moved = self.end(point)
                pin = [] if grounded else [self._own(f"{name}.X", [[-1], [0]]), self._own(f"{name}.Y", [[0], [-1]])]
                self._hold(self._place(point)[0] - at, (columns, moved[:, :2]), *pin)
        if isinstance(joint, Weld):
            self._turn(joint.connect, joint.angle)
        elif (led := self._led(name)) is not None:
            self._turn(joint.connect, led, self._own(f"{name}.driven", [[-1]]))

    def _guide(self, name: str, joint: Slot | Prismatic) -> None:
        """The pin moves as the guide does where it is, and along it."""
        (first, angle), (second, _) = map(self._place, joint.connect)
        (one, guide), (two, pin) = map(self.end, joint.connect)
        along, way, led = turns(angle + joint.angle)[..., 0], second - first, self._led(name)
        reach = (along * way).sum(axis=-1) if led is None else led
        carried = guide[:, :2] + (way @ QUARTER.T)[..., None] * guide[:, 2:]  # the guide's rotation swings the pin
        slide = self._own(f"{name}.slide" if led is None else f"{name}.driven", -along[..., None])
        self._hold(way - reach[:, None] * along, (two, pin[:, :2]), (one, -carried), slide)
        if isinstance(joint, Prismatic):
            self._turn(joint.connect, joint.turn)

    def _turn(self, points: tuple[str, ...], by: Array | float, *own: tuple[Index, Array]) -> None:
        """Hold the angle between two bodies."""
        (one, first), (two, second) = map(self.end, points[:2])
        angles = [self._place(point)[1] for point in points[:2]]
        gap = (angles[1] - angles[0] - by)[:, None]
        self._hold(gap, (two, second[:, 2:]), (one, -first[:, 2:]), *own)

    def _hold(self, gap: Array, *parts: tuple[Index, Array]) -> None:
        row = np.zeros((*gap.shape, self.width + len(self.own)), self.pose.dtype)
        for columns, values in parts:
            row[:, :, columns] += values
        self.rows.append(row)
        self.gaps.append(gap)

    def _own(self, name: str, values: object) -> tuple[Index, Array]:
        return self.width + np.array([self.own.index(name)]), np.asarray(values)

    def _led(self, joint: str) -> Array | None:
        """What a drive leads at a joint, ``(positions,)``; None where no drive is."""
        return self.led[:, self.driven.index(joint)] if joint in self.driven else None

    def _place(self, point: str) -> tuple[Array, Array]:
        """Place of a point in the fixed frame, and the angle of its body."""
        body, at = self.scene.point(point)
        here = self.pose[:, self.links.index(body)]
        return here[:, :2] + turns(here[:, 2]) @ np.array(at), here[:, 2]


def rigid_rows(scene: Scene, pose: Array, led: Array) -> tuple[Array, Array]:
    """Give the joints' rows over displacements of rigid links' frames, and by how much they are open."""
    links = list(scene.links)

    def end(point: str) -> tuple[Index, Array]:
        body, at = scene.point(point)
        if body == "ground":
            return np.zeros(0, dtype=np.int64), np.zeros((len(pose), 3, 0))
        moved = np.tile(np.eye(3, dtype=pose.dtype), (len(pose), 1, 1))
        moved[:, :2, 2] = turns(pose[:, links.index(body), 2]) @ (QUARTER @ np.array(at))
        return 3 * links.index(body) + np.arange(3), moved

    return JointRows.of(scene, pose, led, end, 3 * len(links))


def drive_jets(scene: Scene, theta: Array) -> Jet:
    """What the drives lead (rad or m), with two derivatives by theta, ``(positions, drives)`` each."""
    jets = [drive.jet(theta, scene.cycle_rate) for drive in scene.drives]
    return Jet(*(np.stack([getattr(jet, part) for jet in jets], -1) for part in ("value", "first", "second")))


def rigid_motion(scene: Scene, branch: Array, coordinate: Jet) -> Motion:
    """Solve for the motion of the links as if they were rigid.

    Parameters
    ----------
    scene
        The scene.
    branch
        Its assembly over a cycle, as `assembly` gives it.
    coordinate
        Drive coordinate theta (rad) with two time derivatives, ``(positions,)`` each.

    Raises
    ------
    AssemblyError
        When the links cannot be put together at a position, or their motion is lost there.
    """
    turn = math.copysign(2 * math.pi, scene.cycle_rate)
    theta = np.mod(coordinate.value / turn, 1.0) * turn
    led = drive_jets(scene, theta)
    near = branch[np.floor(theta / turn * COARSE).astype(np.int64) % COARSE]
    theta_rate: Array = coordinate.first[:, None]
    theta_second: Array = coordinate.second[:, None]
    pose = _assembled(scene, theta, led.value, near)
    led_rate = led.first * theta_rate
    led_second = led.second * theta_rate**2 + led.first * theta_second
    rows, links, drives = rigid_rows(scene, pose, led.value)[0], 3 * len(scene.links), len(scene.drives)
    unknown, known = rows[..., :-drives], rows[..., -drives:]
    first = rigid_rows(scene, branch[:1], drive_jets(scene, np.zeros(1)).value)[0][..., :-drives]
    if (strays := np.linalg.slogdet(unknown)[0] != np.linalg.slogdet(first)[0]).any():  # it has one sign on a branch
        where = np.degrees(theta[int(strays.argmax())])
        raise AssemblyError(
            f"the linkage passes next to a change point before drive angle {where:.6g} deg: change a length"
        )
    rate, second = np.zeros_like(pose), np.zeros_like(pose)
    moved = np.concatenate([solved(unknown, -times(known, led_rate)), led_rate], axis=1)  # G d' = 0
    rate[:, :-1] = moved[:, :links].reshape(len(theta), -1, 3)
    turning = rigid_rows(scene, pose + 1j * IMAGINARY * rate, led.value)[0].imag / IMAGINARY
    right = -times(known, led_second) - times(turning, moved)  # G d'' + G' d' = 0
    second[:, :-1] = solved(unknown, right)[:, :links].reshape(len(theta), -1, 3)
    return Motion(pose, rate, second)


def assembly(scene: Scene) -> Array:
    """Put the links together from their rough angles, and follow their poses over a cycle.

    Parameters
    ----------
    scene
        The scene.

    Returns
    -------
    numpy.ndarray
        Poses of the links and the ground at equal parts of the cycle, ``(COARSE, links + 1, 3)``.

    Raises
    ------
    AssemblyError
        When the links cannot be put together.
    """
    theta = scene.drive_angles(COARSE)
    led = drive_jets(scene, theta).value
    pose, poses = _start(scene, theta[:1], led[:1]), []
    for k in range(COARSE):
        pose = _assembled(scene, theta[k : k + 1], led[k : k + 1], pose)
        poses.append(pose[0])
    return np.array(poses)


def _start(scene: Scene, theta: Array, led: Array) -> Array:
    """Put the links together at theta = 0 from their rough angles, ``(1, links + 1, 3)``."""
    pose, links, names = np.zeros((1, len(scene.links) + 1, 3)), list(scene.links.values()), [*scene.links, "ground"]
    rough = np.array([link.angle for link in links] + [0.0])
    for drive, value in zip(scene.drives, led[0]):
        if isinstance(scene.joints[drive.joint], Revolute):  # it gives the angle of a link, whatever its rough one is
            one, two = (names.index(point.split(".")[0]) for point in scene.joints[drive.joint].connect)
            turned, by = (two, rough[one] + value) if two < len(links) else (one, -value)
            rough[turned] = by
    pose[0, :, 2] = rough
    rows, gap = rigid_rows(scene, pose, led)
    places = np.delete(np.arange(rows.shape[2] - led.shape[1]), np.arange(2, 3 * len(links), 3))
    found = np.linalg.lstsq(rows[0][:, places], -gap[0], rcond=None)[0]  # with the rough angles held
    pose[0, :-1, :2] = found[: 2 * len(links)].reshape(-1, 2)
    pose = _assembled(scene, theta, led, pose)
    away = np.abs(np.mod(pose[0, :, 2] - rough + math.pi, 2 * math.pi) - math.pi)
    for name, link, by in zip(scene.links, links, away):
        if link.angle and by > FARTHEST:
            raise AssemblyError(
                f"at drive angle 0 link {name} came to lie {np.degrees(by):.4g} deg from its rough angle: "
                "give rough angles nearer to the intended position"
            )
    return pose


def _assembled(scene: Scene, theta: Array, led: Array, pose: Array) -> Array:
    """Close the joints by Newton's method from poses nearby."""
    size = max(float(np.abs(list(link.points.values())).max()) for link in scene.links.values()) or 1.0
    for _ in range(ITERATIONS):
        rows, gap = rigid_rows(scene, pose, led)
        rows = rows[..., : -len(scene.drives)]
        if rows.shape[1] != rows.shape[2]:
            raise AssemblyError(
                f"joints and drives hold the links {rows.shape[1]} times, and there are {rows.shape[2]} coordinates: "
                "state as many drives as there are freedoms, and no joint twice"
            )
        if (condition := np.linalg.cond(rows)).max() > LOCKED:
            where = np.degrees(theta[int(condition.argmax())])
            raise AssemblyError(
                f"the linkage locks or its motion is not unique at drive angle {where:.6g} deg: check lengths, "
                "places of joints and rough angles, or choose other positions"
            )
        step = solved(rows, -gap)[:, : 3 * len(scene.links)].reshape(len(pose), -1, 3)
        pose = pose + np.pad(step, ((0, 0), (0, 1), (0, 0)))
        if np.abs(gap).max() < CLOSED * size:
            return pose
    where = np.degrees(theta[int(np.abs(gap).max(axis=1).argmax())])
    raise AssemblyError(
        f"the links cannot be put together at drive angle {where:.6g} deg: check lengths, places of joints and the "
        "links' rough angles"
    )
