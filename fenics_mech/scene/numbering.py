"""The order in which the parts of a scene are stated, which numbers them."""

from __future__ import annotations

from fenics_mech.scene.models import Scene

GROUND = -1  # among the numbers of links


def order_of(scene: Scene) -> tuple[object, ...]:
    """Give the order of the links, their points and members, and the joints and masses.

    Mappings are equal in any order. What is numbered by the order is in common only where this is equal too.

    Parameters
    ----------
    scene
        The scene.

    Examples
    --------
    >>> from fenics_mech.scene.numbering import order_of
    >>> order_of(scene)[1:]
    (['O', 'A', 'B', 'C'], [])
    """
    links = [(name, list(link.points), list(link.members)) for name, link in scene.links.items()]
    return links, list(scene.joints), list(scene.masses)
