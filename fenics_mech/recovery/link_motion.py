"""How links and points move: angles and rates of links, paths of points, instant centres, transmission angles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.beams.attachment import Attachment
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.forces.places_on_axes import AtNode, BentLinks, InElement
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.joints.link_states import quarter
from fenics_mech.kinematics import Motion
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.motion import coordinates
from fenics_mech.kinematics.transmission import transmission_angles
from fenics_mech.mechanism.contact import travelled
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.observations import TracedPoint

PARALLEL = 1e-9  # share of the fastest link's rate below which a link does not turn, and has no instant centre


@dataclass(frozen=True)
class TracedPlace:
    """A point that is followed.

    Parameters
    ----------
    link
        Name of its link.
    place
        Where it is on the link that does not bend, in the link's frame (m).
    fixed_to
        The node or the section that it is fixed to.
    """

    link: str
    place: tuple[float, float]
    fixed_to: AtNode | InElement


def link_motion(forces: Forces) -> xr.Dataset:
    """Give the motion of the links and of points of them.

    Parameters
    ----------
    forces
        The forces of the motion, with its scene and its mechanism.

    Returns
    -------
    xarray.Dataset
        What `motion_of_links` gives. `point_position`, `point_velocity`, `point_acceleration` by `point` with links
        that do not bend, and with `_bent` behind them on bent links: rates only where the coupling acts, without which
        the equation does not know them. A mechanism at rest has no rates.
    """
    found, names = _of_points(forces)
    points = xr.Dataset(found, {"theta": forces.system.motion.theta, "point": names, "component": ["x", "y"]})
    return points.merge(motion_of_links(forces.scene, forces.system.motion))


def motion_of_links(scene: Scene, motion: Motion) -> xr.Dataset:
    """Give the motion of links that do not bend.

    Parameters
    ----------
    scene
        The linkage.
    motion
        Its motion.

    Returns
    -------
    xarray.Dataset
        `link_omega`, `link_alpha` by `link`, and its `instant_centre`.
        `transmission_angle` by `pair`, `slide_place` by `slide`. A mechanism at rest has no rates.
    """
    labels: dict[str, Any] = {"theta": motion.theta, "link": list(motion.links), "component": ["x", "y"]}
    found: dict[str, Any] = {}
    if motion.omega.any() or motion.velocity.any():
        found["link_omega"] = (("theta", "link"), motion.omega)
        found["link_alpha"] = (("theta", "link"), motion.alpha)
        found["instant_centre"] = (("theta", "link", "component"), instant_centres(motion))
    slides = dict(_slide_places(scene, motion))
    if slides:
        found["slide_place"] = (("theta", "slide"), np.stack(list(slides.values()), axis=1))
        labels["slide"] = list(slides)
    loops = Loops.of(scene)
    angles = transmission_angles(loops, coordinates(motion.position, motion.angle)) if scene.drives else None
    if angles:
        found["transmission_angle"] = (("theta", "pair"), np.stack(list(angles.values()), axis=1))
        labels["pair"] = [f"{joint} ({', '.join(links)})" for joint, links in angles]
    return xr.Dataset(found, labels)


def instant_centres(motion: Motion) -> Array:
    """Points of the links that are at rest (m), ``(angles, links, 2)``; NaN where a link does not turn.

    Parameters
    ----------
    motion
        The rigid motion.
    """
    turns = np.abs(motion.omega) > PARALLEL * np.abs(motion.omega).max(initial=0.0)
    rate = np.where(turns, motion.omega, np.nan)[..., None]
    return motion.position + quarter(motion.velocity) / rate


def _of_points(forces: Forces) -> tuple[dict[str, Any], list[str]]:
    """Position, velocity and acceleration of all points, on links that do not bend and on bent ones; their names."""
    system, along = forces.system, ("theta", "point", "component")
    motion, places = system.motion, dict(_traced(forces.scene, system.beams))
    bent_links = BentLinks(system, [forces.displacement] if forces.response.rotation is None else list(forces.jets))
    rigid, bent = [], []
    for place in places.values():
        still = motion.of_point(place.link, place.place)
        rigid.append(still)
        carried = _carried(motion, place.link, place.fixed_to.displacement(bent_links))
        bent.append([a + b for a, b in zip(still, carried)])
    found: dict[str, Any] = {}
    names = ("position", "velocity", "acceleration")[: 3 if motion.omega.any() or motion.velocity.any() else 1]
    for name, of_all in zip(names, zip(*rigid)):
        found[f"point_{name}"] = (along, np.stack(of_all, axis=1))
    for name, of_all in zip(names, zip(*bent)):
        found[f"point_{name}_bent"] = (along, np.stack(of_all, axis=1))
    return found, list(places)


def _carried(motion: Motion, link: str, own: list[Array]) -> list[Array]:
    """Displacement in the fixed frame, its velocity and its acceleration, from those in the axes of a turning link."""
    i = motion.links.index(link)
    angle, omega, alpha = (array[:, i, None] for array in (motion.angle, motion.omega, motion.alpha))
    c, s = np.cos(angle), np.sin(angle)
    d, *rates = (c * vector + s * quarter(vector) for vector in own)
    if not rates:
        return [d]
    first, second = rates
    across = quarter(d)
    return [
        d,
        first + omega * across,
        second + 2 * omega * quarter(first) + alpha * across - omega**2 * d,  # (4.17), with the elastic motion
    ]


def _traced(scene: Scene, beams: Beams) -> Iterator[tuple[str, TracedPlace]]:
    """Give all points of the links, and those that the scene adds, by name."""
    for link, body in scene.links.items():
        for point in body.points:
            yield f"{link}.{point}", _traced_place(scene, beams, TracedPoint(at=f"{link}.{point}"))
    for name, traced in scene.points.items():
        yield name, _traced_place(scene, beams, traced)


def followed(scene: Scene) -> dict[str, tuple[str, tuple[float, float]]]:
    """Give all points of the links, and those that the scene adds: the link of each, and its place there (m), by name.

    Parameters
    ----------
    scene
        The scene.
    """
    points = {f"{link}.{point}": (link, at) for link, body in scene.links.items() for point, at in body.points.items()}
    return points | {name: place_in_link(scene, point) for name, point in scene.points.items()}


def place_in_link(scene: Scene, point: TracedPoint) -> tuple[str, tuple[float, float]]:
    """Give the link of a point that is followed, and the point's place in the link's frame (m).

    Parameters
    ----------
    scene
        The scene.
    point
        The point.
    """
    link, (x, y) = scene.place(point.at)
    return link, (x + point.offset[0], y + point.offset[1])


def _traced_place(scene: Scene, beams: Beams, point: TracedPoint) -> TracedPlace:
    """Find where a point is, and what it is fixed to."""
    link, place = place_in_link(scene, point)
    if "@" in point.at:
        return TracedPlace(link, place, _in_element(beams, point))
    at = Attachment.of(scene.links, scene.joints, beams.mesh, point.at)
    return TracedPlace(link, place, AtNode(at.dofs, at.shift, point.offset, scene.links[link].rigid is None))


def _in_element(beams: Beams, point: TracedPoint) -> InElement:
    """Find the section of a point that is fixed at "member@0.3"."""
    mesh, (label, s) = beams.mesh, point.at.split("@")
    member = mesh.members.index(label)
    cells, arc = np.flatnonzero(mesh.cell_member == member), float(s) * mesh.member_length[member]
    cell = int(cells[max(0, int(np.searchsorted(mesh.cell_start[cells], arc, side="right")) - 1)])
    return InElement(cell, float((arc - mesh.cell_start[cell]) / mesh.cell_length[cell]), point.offset)


def _slide_places(scene: Scene, motion: Motion) -> Iterator[tuple[str, Array]]:
    """Distance of the pin of each slot and slide from its guide's point (m), ``(angles,)``."""
    for name, joint in scene.joints.items():
        if isinstance(joint, Slot | Prismatic):
            (guide, _), (pin, _) = ends = [scene.point(point) for point in joint.connect]
            yield name, travelled(motion, guide, pin, [at for _, at in ends], scene.guide_angle(joint), 1)[0]
