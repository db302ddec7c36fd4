"""The order in which the parts of a scene are stated, which numbers them."""

from __future__ import annotations

from fenics_mech.scene.models import Scene

GROUND = -1  # among the numbers of links


def order_of(scene: Scene) -> tuple[object, ...]:
    """Give the order of links, points, members, joints and masses, in which mappings that are equal may differ."""
    links = [(name, list(link.points), list(link.members)) for name, link in scene.links.items()]
    return links, list(scene.joints), list(scene.masses)
