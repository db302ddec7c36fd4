"""Springs, dampers and loads of a scene as terms of its machine."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.beams.element_matrices import Beams as LinkMatrices
from fenics_mech.errors import SceneError
from fenics_mech.geometry import End
from fenics_mech.machine.drawn_from_scene import Bodies, clock_of
from fenics_mech.machine.groups import Drag
from fenics_mech.machine.laws_from_scene import add_laws
from fenics_mech.machine.machine import Machine
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import AnyLoad, LineLoad, Load, Varying
from fenics_mech.scene.joints import Prismatic, Slot
from fenics_mech.scene.springs_dampers import Hinge, HingeSpring, Line
from fenics_mech.scene.state_factors import FactorFormula, StateFactor
from fenics_mech.terms import AirForce, AlongBeams, Damper, LineForce, Look, Measure, OverState, PointLoad, Spring, Term


class Ends(Protocol):
    """What gives the ends at points "link.point" of a scene."""

    def end(self, point: str, turn: float = 0.0) -> End:
        """Give the end at a point of a link or the ground, its axes turned from those of the link (rad)."""


def add_acting(scene: Scene, machine: Machine, at: Ends, bodies: Bodies, links: LinkMatrices | None) -> dict[str, Term]:
    """Add springs, dampers, loads and drag, and give their terms by place in the scene, such as "loads.gas"."""
    acting: dict[str, Term] = {}
    for name, spring in scene.springs.items():
        pair, look, near = _between(scene, at, spring, bodies)
        cyclic = scene.drives and scene.analysis.method == "periodic"
        if near and cyclic and abs(np.subtract(*near(np.array([0.0, 0.999999 * scene.period])))) > TURN / 2:
            raise SceneError(
                "the bodies turn against each other without end, which winds the spring up in every cycle",
                place=f"springs.{name}",
                hint="Put it at a joint that swings",
            )
        free = spring.angle if isinstance(spring, HingeSpring) else spring.length
        if free is None:
            free = _angle_at_start(scene, spring, bodies) if isinstance(spring, Hinge) else _distance(machine, pair)
        acting[f"springs.{name}"] = Spring([pair], spring.stiffness, free, look, near)
    for name, load in scene.loads.items():
        acting[f"loads.{name}"] = _load(scene, machine, name, load, at, bodies, links)
    for name, damper in scene.dampers.items():
        pair, look, _ = _between(scene, at, damper, bodies)
        acting[f"dampers.{name}"] = Damper([pair], damper.damping, look)
    for impulse in scene.impulses.values():
        t = impulse.time if impulse.angle is None else np.mod(impulse.angle / scene.cycle_rate, scene.period)
        assert t is not None
        end = at.end(point_of(scene, impulse.at))
        size = impulse.impulse, impulse.angular_impulse
        machine.blows.append((float(t), PointLoad(machine.at_ground(), end, *size, np.ones_like)))
    acting |= add_laws(scene, machine, at.end, bodies, links)
    damping = scene.damping
    machine.drag = Drag(damping.external, damping.relative)
    if damping.air is not None and links is not None:
        mesh = links.mesh
        width = np.array([scene.drag_width(label) for label in mesh.members])
        factor = damping.air.density * damping.air.coefficient * width[mesh.cell_member] / 2
        _refuse_offsets(links, range(len(factor)), "damping.air")
        acting["damping.air"] = AlongBeams(machine.at_ground(), machine.beams, range(len(factor)), AirForce(factor))
    machine.terms += acting.values()
    machine.forget_plan()
    return acting


def _load(
    scene: Scene, machine: Machine, name: str, load: AnyLoad, at: Ends, bodies: Bodies, links: LinkMatrices | None
) -> Term:
    """Give the term of a load."""
    by_state = isinstance(load.factor, StateFactor) and load.factor.joint is not None
    factor = (lambda t: np.ones(len(t))) if by_state else _factor(scene, load)
    if isinstance(load, LineLoad):
        if by_state:
            raise SceneError(
                "no term states a load along a member over the place or rate of a joint yet",
                place=f"loads.{name}.factor",
            )
        assert links is not None
        mesh = links.mesh
        cells = np.flatnonzero(mesh.cell_member == mesh.members.index(load.member))
        _refuse_offsets(links, cells, f"loads.{name}")
        whole = mesh.member_length[mesh.cell_member[cells[0]]]
        shares = (mesh.cell_start[cells, None] + mesh.cell_length[cells, None] * [0, 1]) / whole
        ends = (1 - shares)[..., None] * load.ends[0] + shares[..., None] * load.ends[1]
        density = LineForce(ends, factor, load.axes == "member")
        return AlongBeams(machine.at_ground(), machine.beams, cells, density)
    assert isinstance(load, Load)
    end = at.end(point_of(scene, load.at))
    term = PointLoad(machine.at_ground(), end, load.force, load.moment, factor, load.follows)
    if not by_state:
        return term
    assert isinstance(load.factor, FactorFormula)
    pair, measure, near = _of_joint(scene, machine, at, load.factor.joint or "", bodies)
    return OverState(term, pair, measure, load.factor.with_derivatives, near)


def _of_joint(
    scene: Scene, machine: Machine, at: Ends, name: str, bodies: Bodies
) -> tuple[tuple[End, End], Measure, Callable[[Array], Array] | None]:
    """Give the ends of a joint, the measure that is its angle or stroke, and its angle in the rigid motion by time."""
    joint = scene.joints[name]
    if isinstance(joint, Slot | Prismatic):
        if joint.member is not None:
            return machine.along(name), Measure(Look.ALONG, 0), None
        guide, slide = (at.end(point, joint.angle) for point in joint.connect)
        return (guide, slide), Measure(Look.ALONG, 0), None
    pair, look, near = _between(scene, at, HingeSpring(joint=name, stiffness=1.0), bodies)
    return pair, Measure(look), near


def _refuse_offsets(links: LinkMatrices, cells: Iterable[int], place: str) -> None:
    """Raise where the axis of a member, on which a load acts, is not the neutral line of its elements."""
    offsets = links.layout.offsets
    if offsets is not None and np.abs(offsets.neutral[list(cells)]).max() > 0:
        raise SceneError("no term states a load along a member whose section has an offset yet", place=place)


def _between(
    scene: Scene, at: Ends, part: Line | Hinge, bodies: Bodies
) -> tuple[tuple[End, End], Look, Callable[[Array], Array] | None]:
    """Give the ends of a spring or damper, what it looks at, and for hinges the angle in the rigid motion by time."""
    if isinstance(part, Line):
        one, other = part.between
        return (at.end(one), at.end(other)), Look.DISTANCE, None
    by_body = {point.split(".")[0]: point for point in scene.joints[part.joint].connect}
    first, second = part.bodies or tuple(by_body)
    numbers = {"ground": 0} | {name: k for k, name in enumerate(scene.links, start=1)}
    clock = clock_of(scene)

    def near(t: Array) -> Array:
        turned = bodies.turned[:, numbers[second]] - bodies.turned[:, numbers[first]]
        share = np.mod(clock(t) / scene.period, 1.0) if scene.drives else np.zeros(len(t))
        return turned[(share * (len(turned) - 1)).astype(int)]

    return (at.end(by_body[first]), at.end(by_body[second])), Look.ANGLE, near


def _angle_at_start(scene: Scene, part: Hinge, bodies: Bodies) -> float:
    """Give the angle at the start between the bodies of a spring (rad)."""
    first, second = part.bodies or (point.split(".")[0] for point in scene.joints[part.joint].connect)
    return float(bodies.at_start[second] - bodies.at_start[first])


def _distance(machine: Machine, pair: tuple[End, End]) -> float:
    """Give the distance of two ends as drawn (m)."""
    one, other = map(machine.drawn, pair)
    return float(np.linalg.norm(other - one))


def point_of(scene: Scene, name: str) -> str:
    """Give the point "link.point" or the node "member@0.3" of a place: of a joint, its first one that moves."""
    if "@" in name:
        label, s = name.split("@")
        return f"{label}@{float(s):.12g}"
    if "." in name:
        return name
    return next(point for point in scene.joints[name].connect if not point.startswith("ground."))


def _factor(scene: Scene, load: Varying) -> Callable[[Array], Array]:
    """Give the factor of a load by time."""
    factor = load.factor
    if not isinstance(factor, StateFactor):
        clock = clock_of(scene)
        return lambda t: load.factor_at(scene.cycle_rate * clock(t))
    return lambda t: factor.of_state(t, np.zeros_like(t), np.zeros_like(t))
