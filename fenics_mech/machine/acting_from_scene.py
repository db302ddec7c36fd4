"""Springs, dampers and loads of a scene as terms of its machine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import SceneError
from fenics_mech.geometry import End
from fenics_mech.machine.drawn_from_scene import Bodies, clock_of
from fenics_mech.machine.machine import Machine
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import LineLoad, Load
from fenics_mech.scene.springs_dampers import Hinge, HingeSpring, Line
from fenics_mech.scene.state_factors import StateFactor
from fenics_mech.terms import Damper, Look, PointLoad, Spring


class Ends(Protocol):
    """What gives the ends at points "link.point" of a scene."""

    def end(self, point: str) -> End:
        """Give the end at a point of a link or the ground, with the axes of the link."""


def add_acting(scene: Scene, machine: Machine, at: Ends, bodies: Bodies) -> None:
    """Add springs, dampers and loads.

    Parameters
    ----------
    scene
        The scene.
    machine
        Its machine, with all poses.
    at
        Ends at points of links.
    bodies
        The links as rigid bodies, by which whole turns of hinges count.

    Raises
    ------
    SceneError
        When the scene has what no term states yet.
    """
    _refuse(scene)
    for name, spring in scene.springs.items():
        pair, look, near = _between(scene, at, spring, bodies)
        if near and scene.drives and abs(np.subtract(*near(np.array([0.0, 0.999999 * scene.period])))) > TURN / 2:
            raise SceneError("the bodies turn against each other without end", place=f"springs.{name}")
        free = spring.angle if isinstance(spring, HingeSpring) else spring.length
        if free is None:
            free = float(near(np.zeros(1))[0]) if near else _distance(machine, pair)
        machine.terms.append(Spring([pair], spring.stiffness, free, look, near))
    for damper in scene.dampers.values():
        pair, look, _ = _between(scene, at, damper, bodies)
        machine.terms.append(Damper([pair], damper.damping, look))
    for name, load in scene.loads.items():
        assert isinstance(load, Load)
        factor, end = _factor(scene, name, load), at.end(_place(scene, load.at))
        machine.terms.append(PointLoad(machine.at_ground(), end, load.force, load.moment, factor, load.follows))


def _refuse(scene: Scene) -> None:
    """Raise `SceneError` for what acts on the links and has no term yet."""
    for name, load in scene.loads.items():
        if isinstance(load, LineLoad):
            raise SceneError("no term states a load along a member yet", place=f"loads.{name}")
    for name in scene.impulses:
        raise SceneError("no term states an impulse yet", place=f"impulses.{name}")
    for key in ("external", "relative", "air"):
        if getattr(scene.damping, key):
            raise SceneError("no term states the drag of the surroundings yet", place=f"damping.{key}")


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
    turned = bodies.turned[:, numbers[second]] - bodies.turned[:, numbers[first]]

    clock = clock_of(scene)

    def near(t: Array) -> Array:
        share = np.mod(clock(t) / scene.period, 1.0) if scene.drives else np.zeros(len(t))
        return turned[(share * (len(turned) - 1)).astype(int)]

    return (at.end(by_body[first]), at.end(by_body[second])), Look.ANGLE, near


def _distance(machine: Machine, pair: tuple[End, End]) -> float:
    """Give the distance of two ends as drawn (m)."""
    one, other = map(machine.drawn, pair)
    return float(np.linalg.norm(other - one))


def _place(scene: Scene, name: str) -> str:
    """Give the point "link.point" or the node "member@0.3" of a place: of a joint, its first one that moves."""
    if "@" in name:
        label, s = name.split("@")
        return f"{label}@{float(s):.12g}"
    if "." in name:
        return name
    return next(point for point in scene.joints[name].connect if not point.startswith("ground."))


def _factor(scene: Scene, name: str, load: Load) -> Callable[[Array], Array]:
    """Give the factor of a load by time."""
    factor = load.factor
    if not isinstance(factor, StateFactor):
        clock = clock_of(scene)
        return lambda t: load.factor_at(scene.cycle_rate * clock(t))
    if factor.joint is not None:
        raise SceneError("no term states a load over the place or rate of a joint yet", place=f"loads.{name}.factor")
    return lambda t: factor.of_state(t, np.zeros_like(t), np.zeros_like(t))
