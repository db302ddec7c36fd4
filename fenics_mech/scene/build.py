"""From plain data to a `Scene`."""

from __future__ import annotations

from typing import Any

from fenics_mech.scene.models import Scene


def build(data: dict[str, Any]) -> Scene:
    """Make a scene from nested dictionaries as a scene file holds them; raises `SceneError` as `Scene` does.

    Parameters
    ----------
    data
        Tables and keys of a scene file, with quantities as numbers in SI or texts with a unit.

    Returns
    -------
    Scene
        The scene, checked.
    """
    return Scene.read(data)
