"""Where links and the ends of members are over the motion, so that a result can be drawn by itself."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene

ENDS = ("first", "second")


def rigid_places(scene: Scene, motion: Motion) -> xr.Dataset:
    """Label the rigid positions of links and of the members' ends."""
    # Gives `position` (m) of the members' ends over theta, member, end and component; `link_position` (m) and
    # `link_angle` (rad) of the links' frames over theta and link.
    return xr.Dataset(
        {
            "position": (("theta", "member", "end", "component"), ends_in(scene, motion)),
            "link_position": (("theta", "link", "component"), motion.position),
            "link_angle": (("theta", "link"), motion.angle),
        },
        {"end": list(ENDS), "link": list(motion.links)},
    )


def between_ends(ends: Array, s: Array) -> Array:
    """Give places along straight members (m), ``(angles, members, places, 2)``."""
    # ends: the members' ends (m), ``(angles, members, 2, 2)``; s: places 0 to 1 along every member, ``(places,)``
    s = s[:, None]
    return np.asarray((1 - s) * ends[:, :, None, 0] + s * ends[:, :, None, 1])


def bent_axes(data: xr.Dataset) -> Array:
    """Give the places of the members' bent axes in a result (m), ``(angles, members, stations, 2)``."""
    ends = data["position"].transpose("theta", "member", "end", "component").to_numpy()
    bent = data["deflection"].transpose("theta", "member", "s", "component").to_numpy()
    return between_ends(ends, data["s"].to_numpy()) + bent


def ends_in(scene: Scene, motion: Motion) -> Array:
    """Give the members' two ends in a motion of the links (m), ``(angles, members, 2, 2)``."""
    members = [
        [motion.of_point(link, scene.links[link].points[end])[0] for end in member.ends]
        for link, member in scene.members().values()
    ]
    return np.moveaxis(np.array(members).reshape(-1, 2, len(motion.theta), 2), 2, 0)
