"""Counterweights that cancel the forces of a linkage on its frame, or make the best of force, moment and torque.

Closed forms by linearly independent vectors (Berkof and Lowen 1969, Journal of Engineering for Industry 91, 21-26): the
angle of the coupler is eliminated by the closed loop, and what remains must not depend on the angles of the others.
For any linkage the same counterweights follow from least squares over the cycle, as far as they exist.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.kinematics import Motion
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Revolute, Scene
from fenics_mech.scene.base import check_known
from fenics_mech.studies.synthesis.inertia_forces import LinkInertia, Shaking, bar_inertia, link_inertias, shaking

POSITIONS = 180  # of the cycle, at which forces are made small
SHARE = 0.4  # radius of a counterweight over the length of its link, where none is stated
EXACT = 1e-15  # convergence of the least squares


@dataclass(frozen=True)
class Counterweight:
    """A mass on the far side of a pin of a link.

    Parameters
    ----------
    link, pivot
        The link, and the point of it that the radius is measured from.
    radius
        Distance from the pivot (m).
    mass
        Mass (kg), beside that of the bar which holds it.
    angle
        Direction from the pivot in the link's frame (rad).
    """

    link: str
    pivot: str
    radius: float
    mass: float
    angle: float


@dataclass(frozen=True)
class Balanced:
    """A balanced linkage.

    Parameters
    ----------
    scene
        The scene with its counterweights.
    counterweights
        What was added.
    before, after
        What inertia does to the frame and the drive without and with them, with links that do not bend.
    """

    scene: Scene
    counterweights: tuple[Counterweight, ...]
    before: Shaking
    after: Shaking


def four_bar_counterweights(
    lengths: tuple[float, float, float], bodies: tuple[LinkInertia, ...]
) -> tuple[complex, complex]:
    """First moments that counterweights on crank and follower need to cancel the shaking force of a four-bar.

    The origins of crank and follower are at the ground, that of the coupler at the crank, and the x axes along the
    links. Berkof and Lowen (1969), with the masses of the links themselves.

    Parameters
    ----------
    lengths
        Of crank, coupler and follower (m).
    bodies
        Inertia of crank, coupler and follower.

    Returns
    -------
    tuple
        First moments for the crank and the follower (kg m): x + i y in the link's frame.

    Examples
    --------
    >>> from fenics_mech.studies.synthesis.balancing import four_bar_counterweights
    >>> from fenics_mech.studies.synthesis.inertia_forces import LinkInertia
    >>> nothing = LinkInertia(0.0, np.zeros(2), 0.0)
    >>> rod = LinkInertia.at(2.0, np.array([0.1, 0.0]))
    >>> moments = four_bar_counterweights((0.1, 0.2, 0.3), (nothing, rod, nothing))
    >>> [round(moment.real, 3) for moment in moments]
    [-0.1, -0.3]
    """
    crank, coupler, follower = lengths
    of_crank, of_coupler, of_follower = (complex(*body.moment) for body in bodies)
    first = -of_crank - crank * (bodies[1].mass - of_coupler / coupler)
    second = -of_follower - of_coupler * follower / coupler
    return first, second


def slider_crank_counterweights(
    lengths: tuple[float, float], bodies: tuple[LinkInertia, ...], radius: float
) -> tuple[complex, complex]:
    """First moments that counterweights on crank and rod need to cancel the shaking force of a slider-crank.

    The counterweight of the rod brings the centre of rod and slider to the crank pin, that of the crank brings the
    centre of all to the main bearing.

    Parameters
    ----------
    lengths
        Of crank and rod (m).
    bodies
        Inertia of crank, rod and slider.
    radius
        Distance of the rod's counterweight from the crank pin (m).

    Returns
    -------
    tuple
        First moments for the crank and the rod (kg m): x + i y in the link's frame.

    Examples
    --------
    >>> from fenics_mech.studies.synthesis.balancing import slider_crank_counterweights
    >>> from fenics_mech.studies.synthesis.inertia_forces import LinkInertia
    >>> nothing, piston = LinkInertia(0.0, np.zeros(2), 0.0), LinkInertia.at(1.0, np.zeros(2))
    >>> moments = slider_crank_counterweights((0.1, 0.3), (nothing, nothing, piston), radius=0.1)
    >>> [round(moment.real, 3) for moment in moments]
    [-0.4, -0.3]
    """
    crank, rod = lengths
    of_crank, of_rod = (complex(*body.moment) for body in bodies[:2])
    second = -of_rod - bodies[2].mass * rod
    first = -of_crank - crank * (bodies[1].mass + bodies[2].mass + abs(second) / radius)
    return first, second


@dataclass(frozen=True)
class _Holder:
    """Where a counterweight is held, and the bar that holds it."""

    link: str
    pivot: str
    radius: float
    bar: LinkInertia  # about the pivot, with the bar along the link's x axis
    place: Array = field(compare=False)

    def inertia(self, moment: Array) -> LinkInertia:
        """Give the inertia of counterweight and bar with a first moment about the pivot (kg m), ``(2,)``."""
        size = float(np.hypot(*moment))
        out = moment / size if size else np.array([1.0, 0.0])
        return LinkInertia.at(self.mass(moment), self.place + self.radius * out) + self._turned_bar(out)

    def mass(self, moment: Array) -> float:
        """Give the mass of the counterweight (kg), negative where the bar alone is too heavy."""
        return float(np.hypot(*moment) - self.bar.moment[0]) / self.radius

    def _turned_bar(self, out: Array) -> LinkInertia:
        """Give the inertia of the bar about the link's origin, with the bar along a direction, ``(2,)``."""
        (along, across), mass = self.bar.moment, self.bar.mass
        moment = along * out + across * np.array([-out[1], out[0]])
        inertia = self.bar.inertia + 2 * float(self.place @ moment) + mass * float(self.place @ self.place)
        return LinkInertia(mass, mass * self.place + moment, inertia)


def balance(
    scene: Scene,
    radii: Mapping[str, float] | None = None,
    *,
    moment: float = 0.0,
    torque: float = 0.0,
    section: str | None = None,
) -> Balanced:
    """Find counterweights that make the shaking force least, or a sum of squares of force, moment and torque.

    Each is divided by its root mean square without counterweights, so that weights of 1 count alike. On a link that
    bends, a bar holds the counterweight; its mass is taken into account. On a rigid link the counterweight is part of
    the link's mass and inertia.

    Parameters
    ----------
    scene
        A linkage with one drive.
    radii
        Distance of each counterweight from its pin (m), by link. By default one on each link that is pinned to the
        ground, at 0.4 of its length.
    moment, torque
        Weights of the shaking moment and of the torque of the drive, where that of the force is 1.
    section
        Name of the bars' section; by default that of the link's first member.

    Returns
    -------
    Balanced
        The scene with its counterweights, and forces before and after.

    Raises
    ------
    SceneError
        When a link is not there or cannot have a counterweight, or a weight or radius is not valid.

    Examples
    --------
    >>> found = fm.balance(fm.load("demos/four_bar.toml"), {"crank": 0.05, "follower": 0.05})
    >>> found.after.rms["force"] < 1e-10 * found.before.rms["force"]
    True
    """
    _check(scene, moment, torque, section)
    holders = _holders(scene, radii, section)
    motion = solve_motion(scene, scene.drive_angles(POSITIONS))
    own, rate = link_inertias(scene), scene.drives[0].cycle_rate
    before = shaking(motion, own, rate)
    weights = {"force": 1.0, "moment": moment, "torque": torque}
    found = _least(motion, own, rate, holders, weights, before)
    for holder, one in zip(holders, found):
        if holder.mass(one) < 0:
            raise SceneError(
                f"the bar of {holder.radius:g} m that holds the counterweight is heavier than what is needed",
                place=f"links.{holder.link}",
                hint="Take a smaller radius, or no counterweight on this link",
            )
    made = tuple(
        Counterweight(holder.link, holder.pivot, holder.radius, holder.mass(one), float(np.arctan2(one[1], one[0])))
        for holder, one in zip(holders, found)
    )
    new = _with(scene, made, section)
    return Balanced(new, made, before, shaking(motion, link_inertias(new), rate))


def _check(scene: Scene, moment: float, torque: float, section: str | None) -> None:
    if section is not None:
        check_known(section, scene.sections, "section", "section")
    if len(scene.drives) != 1 or scene.freedoms:
        raise SceneError("balancing takes a linkage that one drive moves", place="drive")
    for name, weight in (("moment", moment), ("torque", torque)):
        if not 0 <= weight < float("inf"):
            raise SceneError(f"a weight is 0 or more, found {weight:g}", place=name)


def _holders(scene: Scene, radii: Mapping[str, float] | None, section: str | None) -> list[_Holder]:
    """Give where the counterweights are held: at pins on the ground, else at the joint nearest to it."""
    pivots = _pivots(scene)
    if radii is None:
        grounded = {name: point for name, (point, steps) in pivots.items() if steps == 1}
        if not grounded:
            raise SceneError("no link is pinned to the ground: name the links of the counterweights", place="links")
        radii = {name: SHARE * _length(scene, name) for name in grounded}
    found = []
    for name, radius in radii.items():
        if name not in pivots:
            known = ", ".join(pivots)
            raise SceneError(f"no counterweight can be pinned to {name!r}", place="links", hint=f"There are {known}")
        if not 0 < radius < float("inf"):
            raise SceneError(f"the radius of a counterweight is positive, found {radius:g} m", place=f"links.{name}")
        pivot = pivots[name][0]
        place = np.array(scene.links[name].points[pivot])
        found.append(_Holder(name, pivot, radius, _bar(scene, name, section, radius), place))
    return found


def _bar(scene: Scene, name: str, section: str | None, radius: float) -> LinkInertia:
    """Give the inertia of a bar on a link about its pivot; a link without members needs none."""
    own = [(label, member) for label, (link, member) in scene.members().items() if link == name]
    if not own:
        return LinkInertia(0.0, np.zeros(2), 0.0)
    label, member = own[0]
    if section is not None:
        key = next(key for key, one in scene.links[name].members.items() if one == member)
        scene = scene.changed({f"links.{name}.members.{key}.section": section})
    return bar_inertia(lambda s: scene.rigidity(label, s), np.zeros(2), np.array([radius, 0.0]))


def _length(scene: Scene, name: str) -> float:
    """Give the largest distance between points of a link (m)."""
    points = np.array(list(scene.links[name].points.values()))
    return float(np.linalg.norm(points[:, None] - points[None], axis=-1).max())


def _pivots(scene: Scene) -> dict[str, tuple[str, int]]:
    """Give the point by which each link is pinned towards the ground, and the number of pins up to there."""
    found: dict[str, tuple[str, int]] = {}
    reached = {"ground": 0}
    while True:
        new: dict[str, tuple[str, int]] = {}
        for joint in scene.joints.values():
            ends = [point.split(".") for point in joint.connect]
            bodies = [body for body, _ in ends]
            known = [body for body in bodies if body in reached]
            if isinstance(joint, Revolute) and known:
                steps = 1 + min(reached[body] for body in known)
                new |= {body: (point, steps) for body, point in ends if body not in reached and body not in new}
        if not new:
            return found
        found |= new
        reached |= {body: steps for body, (_, steps) in new.items()}


def _least(
    motion: Motion,
    own: Mapping[str, LinkInertia],
    rate: float,
    holders: list[_Holder],
    weights: Mapping[str, float],
    before: Shaking,
) -> Array:
    """First moments of the counterweights (kg m), ``(counterweights, 2)``, by least squares."""
    from scipy.optimize import least_squares  # noqa: PLC0415  (slow to import)

    sizes = {name: before.rms[name] or 1.0 for name in weights}
    scale = max(float(np.hypot(*body.moment)) for body in own.values()) or 1.0

    def left(x: Array) -> Array:
        bodies = dict(own)
        for holder, one in zip(holders, scale * x.reshape(-1, 2)):
            bodies[holder.link] = bodies[holder.link] + holder.inertia(one)
        now = shaking(motion, bodies, rate)
        return np.concatenate([weight / sizes[name] * getattr(now, name).ravel() for name, weight in weights.items()])

    start = np.tile([-1.0, 0.1], len(holders))
    found = least_squares(left, start, method="lm", xtol=EXACT, ftol=EXACT, gtol=EXACT)
    return np.asarray(scale * found.x.reshape(-1, 2))


def _with(scene: Scene, counterweights: tuple[Counterweight, ...], section: str | None) -> Scene:
    """Give the scene with counterweights: a rigid link has them in its inertia, others at points of their own."""
    data = scene.model_dump()
    for one in counterweights:
        link = data["links"][one.link]
        x, y = link["points"][one.pivot]
        place = (x + one.radius * np.cos(one.angle), y + one.radius * np.sin(one.angle))
        if link["rigid"]:
            link["rigid"] = _heavier(link["rigid"], one.mass, np.array(place))
            continue
        point = _free("W", link["points"])
        link["points"][point] = place
        if link["members"]:
            bar = next(iter(link["members"].values())) | {"ends": (one.pivot, point)}
            bar |= {} if section is None else {"section": section}
            _call_by_key(data, one.link)
            link["members"][_free("counterweight", link["members"])] = bar
        name = _free(f"counterweight_{one.link}", data["masses"])
        data["masses"][name] = {"at": f"{one.link}.{point}", "mass": one.mass}
    return Scene.read(data)


def _heavier(body: dict[str, Any], mass: float, place: Array) -> dict[str, Any]:
    """Give the data of a rigid body with a mass (kg) at a place (m), ``(2,)``."""
    whole, centre = body["mass"] + mass, np.array(body["centre"])
    share = mass / whole if whole else 0.0
    apart = place - centre
    inertia = body["inertia"] + share * body["mass"] * float(apart @ apart)
    return {"mass": whole, "inertia": inertia, "centre": tuple((centre + share * apart).tolist())}


def _call_by_key(data: dict[str, Any], link: str) -> None:
    """Call the one member of a link by link and key where it is called by the link, as it gets a second one."""
    members = list(data["links"][link]["members"])
    if len(members) > 1:
        return
    for table in ("loads", "impulses", "points", "measurements"):
        for part in data[table].values() if isinstance(data[table], dict) else data[table]:
            for key in ("member", "at"):
                called, sign, rest = str(part.get(key)).partition("@")
                if called == link:
                    part[key] = f"{link}.{members[0]}{sign}{rest}"


def _free(name: str, taken: Mapping[str, object]) -> str:
    """Give a name that is not taken."""
    return next(new for new in (name, *(f"{name}{i}" for i in range(2, 1000))) if new not in taken)
