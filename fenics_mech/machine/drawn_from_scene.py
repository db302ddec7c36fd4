"""The links of a scene as rigid bodies at the start of its cycle: by rough angles, or by a search where they fail."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import AssemblyError
from fenics_mech.geometry import PLANE, End
from fenics_mech.joints import Row
from fenics_mech.machine.assembly import MET, Assemblies, assemblies, closed, led
from fenics_mech.machine.machine import Machine
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import Joint, Prismatic, Slot, Weld
from fenics_mech.terms import Look, Measure

FARTHEST = np.pi / 2  # of a link from its rough angle: beyond it another assembly was meant
FARTHEST_HELD = np.pi / 4  # of rough angles from the one at which a joint holds both links
TRIED = 8  # assemblies of which the first is taken that lets the drives run through their cycle
LISTED = 3  # assemblies in a message
POSITIONS = 72  # of a cycle: 5 degrees of a crank

Law = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Bodies:
    """The links of a scene as rigid bodies: pose k + 1 is that of link k, its place the link's origin."""

    scene: Scene
    joints: Mapping[str, Joint]  # that hold them
    laws: Mapping[str, Law]  # of drives and freedoms, by joint
    machine: Machine  # poses as they are roughly drawn, with rows of joints, then of these laws
    angles: Array  # rough angles (links,) (rad)
    stated: np.ndarray  # whether the scene states them, and no drive leads the link (links,)
    q: Array  # coordinates at the start (size,)
    searched: bool = False  # whether the rough angles led to no assembly

    @property
    def drawn(self) -> Array:
        """Places and angles as they are roughly drawn ``(3 links,)`` (m, rad)."""
        return np.column_stack([np.array(self.machine.r)[1:], self.angles]).ravel()

    @property
    def links(self) -> Array:
        """Places and angles at the start ``(3 links,)`` (m, rad)."""
        return np.asarray(self.drawn + self.q[: self.machine.n])

    @property
    def freedoms(self) -> list[str]:
        """Freedoms by which they are led."""
        return [name for name in self.laws if name in self.scene.freedoms]

    def at_links(self, links: Array) -> Bodies:
        """Give the bodies at other places and angles ``(3 links,)`` (m, rad)."""
        return replace(self, q=np.pad(links - self.drawn, (0, self.machine.size - self.machine.n)))

    def misled(self, q: Array) -> np.ndarray:
        """Say which links are far from rough angles that the scene states ``(links,)``."""
        return self.stated & (np.cos(q[2 : self.machine.n : 3]) < math.cos(FARTHEST))

    def search(self) -> Assemblies:
        """Search for all ways in which the links come together, the nearest to how they are drawn first."""
        weight = [[link.position is not None] * 2 + [True] for link in self.scene.links.values()]
        return assemblies(self.machine, 0.0, np.array(weight, dtype=float).ravel())

    def frames(self) -> dict[str, tuple[Array, Array]]:
        """Give place and axes of every link, and of the ground."""
        poses = self.links.reshape(-1, 3)
        return {"ground": (np.zeros(2), np.eye(2))} | dict(
            zip(self.scene.links, zip(poses[:, :2], PLANE.turn(poses[:, 2:])))
        )

    @property
    def at_start(self) -> dict[str, float]:
        """Angles of the ground, 0, and of all links at the start, by name (rad)."""
        return {"ground": 0.0} | dict(zip(self.scene.links, self.links[2::3]))

    @cached_property
    def turned(self) -> Array:
        """Angles of the ground, 0, and of all links, at even instants from the start to the end of the cycle (rad)."""
        # They are those of the start alone where nothing drives the links.
        (found, (runs,)) = led(self.machine, self.q[None], _cycle(self.scene))
        if not runs:
            raise AssemblyError("the drives cannot lead the links, which do not bend, through their cycle")
        turned = self.angles + np.unwrap(found[:, 0, 2 : self.machine.n : 3], axis=0)
        return np.pad(turned, ((0, 0), (1, 0)))


def bodies_of(scene: Scene) -> Bodies:
    """Put the links of a scene together at the start, with tight pins where they have clearance, if that can be."""
    try:
        return put_together(scene, scene.joints, scene.freedoms)
    except AssemblyError:
        if not scene.open_joints:
            raise
    stated = [name for name, freedom in scene.freedoms.items() if freedom.start is not None]
    return put_together(scene, scene.constraints, stated)


def law_of(scene: Scene, number: int, clock: Law | None = None) -> Law:
    """Give the angle (rad) or stroke (m) of a drive of a scene by time (s), or by the clock of a run-up."""
    drive, rate = scene.drives[number], scene.cycle_rate
    return lambda t: drive.jet(rate * (t if clock is None else clock(t)), rate).value


def clock_of(scene: Scene) -> Law:
    """Give by time the time in which drives at full speed come as far (s): both differ by the run-up of a transient."""
    if scene.analysis.method != "transient" or not scene.drives:
        return lambda t: t
    return lambda t: np.asarray(scene.coordinate(t).value / scene.cycle_rate)


def _cycle(scene: Scene) -> Array:
    """Give even instants from the start to the end of the cycle, which show what the laws of all drives do (s)."""
    if not scene.drives:
        return np.zeros(1)
    rate = scene.cycle_rate
    counts = (drive.enough_angles(POSITIONS * abs(drive.turns_in(rate)), rate) for drive in scene.drives)
    return np.linspace(0.0, scene.period, 1 + max(counts))


def _constant(value: float) -> Law:
    return lambda t: np.full(len(t), value)


def drawn_bodies(scene: Scene, joints: Mapping[str, Joint], freedoms: Collection[str]) -> Bodies:
    """Draw links by their rough angles, as drives and some freedoms lead them, whose joints need not meet."""
    laws: dict[str, Law] = {}
    for number, drive in enumerate(scene.drives):
        laws[drive.joint] = law_of(scene, number)
    for name in freedoms:
        laws[name] = _constant(scene.freedoms[name].start or 0.0)
    angles, stated = _rough_angles(scene, joints, laws)
    machine = _drawn(scene, joints, laws, angles)
    return Bodies(scene, joints, laws, machine, angles, stated, np.zeros(machine.size))


def put_together(scene: Scene, joints: Mapping[str, Joint], freedoms: Collection[str]) -> Bodies:
    """Put links together whose joints hold tight, with drives and some freedoms at their start."""
    # They follow from the rough angles of the links. Where these lead to no assembly, all are searched for. Taken is
    # the nearest to the rough angles that lets the drives run through their cycle.
    bodies = drawn_bodies(scene, joints, freedoms)
    machine = bodies.machine
    (q,), gap = closed(machine, 0.0, bodies.q[None])
    meant = gap[0] < MET
    if meant and not bodies.misled(q).any():
        return replace(bodies, q=q)
    search = bodies.search()
    if not len(search.q):
        raise AssemblyError(_impossible(bodies, search))
    found = [one for one in search.q if not (meant and bodies.misled(one).any())]
    if not found:
        raise AssemblyError(_misled(bodies, q, search.q[:LISTED]))
    runs = np.zeros(1, dtype=bool)
    if len(machine.rows) >= machine.n and len(found) > 1 and scene.drives and not scene.freedoms:
        runs = led(machine, np.array(found[:TRIED]), _cycle(scene))[1]
    return replace(bodies, q=found[int(np.argmax(runs))], searched=True)  # the first if none does


def _rough_angles(scene: Scene, joints: Mapping[str, Joint], laws: Mapping[str, Law]) -> tuple[Array, np.ndarray]:
    """Give the rough angles of links (rad), as drives lead them, and which of them a scene states."""
    names = ["ground", *scene.links]
    angle = np.array([0.0, *(link.angle for link in scene.links.values())])
    stated = angle != 0
    for name, law in laws.items():
        one, other = (names.index(point.split(".")[0]) for point in scene.joints[name].connect[:2])
        if not isinstance(scene.joints[name], Slot | Prismatic):
            stated[[one, other]] = False
            if other:
                angle[other] = angle[one] + law(np.zeros(1))[0]
            else:
                angle[one] = -law(np.zeros(1))[0]
    for name, joint in joints.items():
        if isinstance(joint, Weld | Prismatic):
            held = joint.angle if isinstance(joint, Weld) else joint.turn
            one, other = (names.index(point.split(".")[0]) for point in joint.connect)
            turned = math.remainder(angle[other] - angle[one], TURN)
            known = [k == 0 or stated[k] for k in (one, other)]
            if all(known) and abs(math.remainder(turned - held, TURN)) > FARTHEST_HELD:
                first, second = (f"link {names[k]}" if k else "the ground" for k in (one, other))
                raise AssemblyError(
                    f"joint {name} holds {second} at {_degrees(held)} to {first}, and their rough angles say "
                    f"{_degrees(turned)}. Give the angle that the joint demands, or none"
                )
    return angle[1:], stated[1:]


def _drawn(scene: Scene, joints: Mapping[str, Joint], laws: Mapping[str, Law], angles: Array) -> Machine:
    """Draw links at some angles as bodies, each where its first joint with a drawn one is, with all rows."""
    numbers = {"ground": 0} | {name: k for k, name in enumerate(scene.links, start=1)}
    machine, axes = Machine(PLANE), PLANE.turn(np.array([0.0, *angles])[:, None])
    places = {0: np.zeros(2)} | {
        numbers[name]: np.array(link.position) for name, link in scene.links.items() if link.position is not None
    }

    def ends(joint: Joint) -> list[End]:
        turn, found = (
            PLANE.turn(np.array([scene.guide_angle(joint) if isinstance(joint, Slot | Prismatic) else 0.0])),
            [],
        )
        for body, point in map(scene.point, joint.connect):
            found.append(End(numbers[body], np.array(point), turn))
        return found

    pairs: list[tuple[str, Joint, End, End]] = []
    for name, joint in sorted(joints.items(), key=lambda item: isinstance(item[1], Slot | Prismatic)):
        one, *others = ends(joint)
        pairs += [(name, joint, one, other) for other in others]
    while len(places) < len(numbers):
        for *_, one, other in pairs:
            if (one.pose in places) != (other.pose in places):
                known, new = (one, other) if one.pose in places else (other, one)
                places[new.pose] = places[known.pose] + axes[known.pose] @ known.offset - axes[new.pose] @ new.offset
                break
        else:
            places[min(set(numbers.values()) - set(places))] = np.zeros(2)  # nothing leads from the ground to it
    for k in range(1, len(numbers)):
        machine.add_pose(places[k], axes[k])
    for name, joint, one, other in pairs:
        pair = one, other
        machine.join("slot" if isinstance(joint, Slot | Prismatic) else "revolute", pair, name=name)
        if isinstance(joint, Weld | Prismatic):
            held = joint.angle if isinstance(joint, Weld) else joint.turn
            machine.rows.append(Row(pair, Measure(Look.ANGLE), held, name=name))
    for name, law in laws.items():
        freedom = "stroke" if isinstance(scene.joints[name], Slot | Prismatic) else "angle"
        one, other, *_ = ends(scene.joints[name])
        machine.drive(scene.joints[name].kind, freedom, (one, other), law, name)
    return machine


def _misled(bodies: Bodies, q: Array, ways: Array) -> str:
    """Say which link its rough angle misled, and how the linkage can be assembled."""
    k, turned, names = int(np.argmax(bodies.misled(q))), slice(2, bodies.machine.n, 3), list(bodies.scene.links)
    angles = bodies.angles
    listed = (", ".join(f"{name} at {_degrees(x)}" for name, x in zip(names, angles + way[turned])) for way in ways)
    return (
        f"at drive angle 0 link {names[k]} came to lie at {_degrees(angles[k] + q[turned][k])}, far from "
        f"its rough angle {_degrees(angles[k])}: give rough angles nearer to the intended position. The linkage can be "
        f"assembled with {'; or '.join(listed)}"
    )


def _impossible(bodies: Bodies, search: Assemblies) -> str:
    """Say which joint stays open, by how much, and where a single turning drive might start instead."""
    scene, joints, laws, angles = bodies.scene, bodies.joints, bodies.laws, bodies.angles
    # Links are drawn at the angles that leave the least open, so that one joint has all of the gap.
    machine = _drawn(scene, joints, laws, angles + search.rest[2::3][: len(angles)])
    zero = np.zeros((1, machine.size))
    missed = machine.residual(np.zeros(1), zero, zero, zero, tangents=False).force[0, machine.n :]
    squares: dict[tuple[str, int], float] = {}
    for row, gap in zip(machine.rows, missed):
        if not row.leads and row.measure.look is not Look.ANGLE:
            pin = row.name, row.pair[1].pose
            squares[pin] = squares.get(pin, 0.0) + gap**2
    among = [pin for pin in squares if pin[0] in search.names] or list(squares)
    worst = max(among, key=squares.__getitem__)
    turning = [name for name in laws if not isinstance(scene.joints[name], Slot | Prismatic)]
    starts = {name: law(np.zeros(1))[0] for name, law in laws.items()}
    held = [f"joint {name} at {_degrees(starts[name])} from the x axis of its first body" for name in turning]
    held += [f"joint {name} at {start:.6g} m" for name, start in starts.items() if name not in turning]
    closing = ""
    if len(laws) == 1 and turning:
        (name,) = turning
        for away in np.radians([sign * step for step in range(10, 190, 10) for sign in (1, -1)]):
            other = _drawn(scene, joints, {name: _constant(starts[name] + away)}, angles)
            if len(replace(bodies, machine=other).search().q):
                closing = f": with {name} at {_degrees(starts[name] + away)} the links close"
                break
    return (
        f"the links cannot be assembled at drive angle 0{', with ' if held else ''}{' and '.join(held)}: joint "
        f"{worst[0]} stays open by {math.sqrt(squares[worst]):.3g} m at least. Check lengths, places of joints, and "
        f"where the drive starts{closing}"
    )


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.6g} deg"
