"""Counterweights that cancel the forces of a linkage on its frame, or make the best of force, moment and torque.

They follow from least squares over the cycle, for any linkage, as far as they exist. Source: Berkof and Lowen, Journal
of Engineering for Industry 91 (1969) 21, whose closed forms are those of four-bars and slider-cranks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.scene.sections import Rigidity
from dataclasses import field
from typing import Any

from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Revolute
from fenics_mech.scene.base import check_known

PLACES = 12  # Gauss points of a member: exact for densities up to the 21st power of the place


@dataclass(frozen=True)
class LinkInertia:
    """Inertia of a link about the origin of its frame."""

    mass: float  # mass (kg)
    moment: Array  # first moment: mass times centre of mass in the link's frame (kg m), ``(2,)``
    inertia: float  # moment of inertia about the origin (kg m^2)

    def __add__(self, other: LinkInertia) -> LinkInertia:
        """Give the inertia of both together."""
        return LinkInertia(self.mass + other.mass, self.moment + other.moment, self.inertia + other.inertia)

    @classmethod
    def at(cls, mass: float, place: Array, inertia: float = 0.0) -> LinkInertia:
        """Give that of a mass at a place."""
        return cls(mass, mass * place, mass * float(place @ place) + inertia)


@dataclass(frozen=True)
class Shaking:
    """What inertia does, over the cycle."""

    force: Array  # on the frame (N), ``(angles, 2)``
    moment: Array  # on the frame, about the origin of the ground (N m), ``(angles,)``
    torque: Array  # of the first drive (N m; N where it slides), ``(angles,)``

    @property
    def rms(self) -> dict[str, float]:
        """Root mean square of each."""
        squares = {"force": (self.force**2).sum(axis=1), "moment": self.moment**2, "torque": self.torque**2}
        return {name: float(np.sqrt(values.mean())) for name, values in squares.items()}


def link_inertias(scene: Scene) -> dict[str, LinkInertia]:
    """Give the inertia of every link, with its point masses."""
    found = {}
    for name, link in scene.links.items():
        body = link.rigid
        found[name] = (
            LinkInertia(0.0, np.zeros(2), 0.0)
            if body is None
            else LinkInertia.at(body.mass, np.array(body.centre), body.inertia)
        )
    for label, (link_name, _) in scene.members().items():
        ends = (np.array(end) for end in scene.member_ends(label))
        found[link_name] += bar_inertia(partial(scene.rigidity, label), *ends)
    for mass in scene.masses.values():
        body_name, place = scene.point(mass.at)
        if body_name != "ground":
            found[body_name] += LinkInertia.at(mass.mass, np.array(place), mass.inertia)
    return found


def bar_inertia(rigidity: Callable[[Array], Rigidity], first: Array, second: Array) -> LinkInertia:
    """Give the inertia of a bar about the origin of its link."""
    nodes, weights = np.polynomial.legendre.leggauss(PLACES)
    s, length = (1 + nodes) / 2, float(np.linalg.norm(second - first))
    along = (second - first) / length
    here = rigidity(s)
    mass = here.line_density * weights * length / 2
    offset = np.broadcast_to(here.mass_centre, s.shape)
    places = first + s[:, None] * (second - first) + offset[:, None] * np.array([-along[1], along[0]])
    return LinkInertia(float(mass.sum()), mass @ places, float(mass @ (places**2).sum(axis=1)))


def shaking(motion: Motion, links: Mapping[str, LinkInertia], rate: float) -> Shaking:
    """Give what the inertia of links does to the frame and to the drive."""
    # Sum of minus mass times acceleration, its moment, and the rate of kinetic energy over the rate of the drive
    # (Berkof and Lowen 1969; Lowen, Tepper and Berkof 1983).
    count = len(motion.theta)
    force, moment, power = np.zeros((count, 2)), np.zeros(count), np.zeros(count)
    for name, body in links.items():
        i = motion.links.index(name)
        p, v, a = (array[:, i] for array in (motion.position, motion.velocity, motion.acceleration))
        omega, alpha = motion.omega[:, i], motion.alpha[:, i]
        c, s = np.cos(motion.angle[:, i]), np.sin(motion.angle[:, i])
        x, y = body.moment
        arm = np.stack([c * x - s * y, s * x + c * y], axis=1)
        normal = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        turning = alpha[:, None] * normal - omega[:, None] ** 2 * arm
        change = body.mass * a + turning  # rate of momentum
        force -= change
        moment -= _cross(p, change) + _cross(arm, a) + body.inertia * alpha
        dots = body.mass * a * v + omega[:, None] * a * normal + v * turning
        power += dots.sum(axis=1) + body.inertia * omega * alpha
    return Shaking(force, moment, power / rate)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


POSITIONS = 180  # of the cycle, at which forces are made small
SHARE = 0.4  # radius of a counterweight over the length of its link, where none is stated
EXACT = 1e-15  # convergence of the least squares


@dataclass(frozen=True)
class Counterweight:
    """A mass on the far side of a pin of a link."""

    # link, pivot: the link, and the point of it that the radius is measured from
    link: str
    pivot: str
    radius: float  # distance from the pivot (m)
    mass: float  # mass (kg), beside that of the bar which holds it
    angle: float  # direction from the pivot in the link's frame (rad)


@dataclass(frozen=True)
class Balanced:
    """A balanced linkage."""

    scene: Scene  # the scene with its counterweights
    counterweights: tuple[Counterweight, ...]  # what was added
    # before, after: what inertia does to the frame and the drive without and with them, with links that do not bend
    before: Shaking
    after: Shaking


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
        (along, across), mass = self.bar.moment, self.bar.mass
        turned = along * out + across * np.array([-out[1], out[0]])  # first moment of the bar along that direction
        inertia = self.bar.inertia + 2 * float(self.place @ turned) + mass * float(self.place @ self.place)
        bar = LinkInertia(mass, mass * self.place + turned, inertia)
        return LinkInertia.at(self.mass(moment), self.place + self.radius * out) + bar

    def mass(self, moment: Array) -> float:
        """Give the mass of the counterweight (kg), negative where the bar alone is too heavy."""
        return float(np.hypot(*moment) - self.bar.moment[0]) / self.radius


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
        grounded = [name for name, (_, steps) in pivots.items() if steps == 1]
        if not grounded:
            raise SceneError("no link is pinned to the ground: name the links of the counterweights", place="links")
        radii = {}
        for name in grounded:
            points = np.array(list(scene.links[name].points.values()))
            radii[name] = SHARE * float(np.linalg.norm(points[:, None] - points[None], axis=-1).max())
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
