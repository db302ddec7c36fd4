"""From plain data to a `Scene`."""

from __future__ import annotations

from typing import Any

from fenics_mech.scene.models import Scene


def build(data: dict[str, Any]) -> Scene:
    """Make a scene from nested dictionaries as a scene file holds them; raises `SceneError` as `Scene` does."""
    return Scene.read(data)
