"""How links and points move: angles and rates of links, paths of points, instant centres, transmission angles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.joints.link_states import quarter
from fenics_mech.kinematics import Motion
from fenics_mech.machine.transmission import transmission_angles
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.observations import TracedPoint

PARALLEL = 1e-9  # share of the fastest link's rate below which a link does not turn, and has no instant centre


def motion_of_links(scene: Scene, motion: Motion) -> xr.Dataset:
    """Give the motion of links that do not bend."""
    labels: dict[str, Any] = {"theta": motion.theta, "link": list(motion.links), "component": ["x", "y"]}
    found: dict[str, Any] = {}
    if motion.omega.any() or motion.velocity.any():
        found["link_omega"] = (("theta", "link"), motion.omega)
        found["link_alpha"] = (("theta", "link"), motion.alpha)
        turns = np.abs(motion.omega) > PARALLEL * np.abs(motion.omega).max(initial=0.0)
        rate = np.where(turns, motion.omega, np.nan)[..., None]
        found["instant_centre"] = (("theta", "link", "component"), motion.position + quarter(motion.velocity) / rate)
    slides = dict(_slide_places(scene, motion))
    if slides:
        found["slide_place"] = (("theta", "slide"), np.stack(list(slides.values()), axis=1))
        labels["slide"] = list(slides)
    angles = transmission_angles(scene, motion) if scene.drives else None
    if angles:
        found["transmission_angle"] = (("theta", "pair"), np.stack(list(angles.values()), axis=1))
        labels["pair"] = [f"{joint} ({', '.join(links)})" for joint, links in angles]
    return xr.Dataset(found, labels)


def followed(scene: Scene) -> dict[str, tuple[str, tuple[float, float]]]:
    """Give the link and the place in it (m) of all points of links, and of those that the scene adds, by name."""
    points = {f"{link}.{point}": (link, at) for link, body in scene.links.items() for point, at in body.points.items()}
    return points | {name: place_in_link(scene, point) for name, point in scene.points.items()}


def place_in_link(scene: Scene, point: TracedPoint) -> tuple[str, tuple[float, float]]:
    """Give the link of a point that is followed, and the point's place in the link's frame (m)."""
    link, (x, y) = scene.place(point.at)
    return link, (x + point.offset[0], y + point.offset[1])


def _slide_places(scene: Scene, motion: Motion) -> Iterator[tuple[str, Array]]:
    """Distance of the pin of each slot and slide from its guide's point (m), ``(angles,)``."""
    for name, joint in scene.joints.items():
        if isinstance(joint, Slot | Prismatic):
            start, end = (motion.of_point(*scene.point(point))[0] for point in joint.connect)
            guide = scene.point(joint.connect[0])[0]
            turned = 0.0 if guide == "ground" else motion.angle[:, motion.links.index(guide)]
            angle = np.broadcast_to(turned + scene.guide_angle(joint), (len(motion.theta),))
            yield name, np.cos(angle) * (end - start)[:, 0] + np.sin(angle) * (end - start)[:, 1]
