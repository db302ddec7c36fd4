"""Causes of work: the names by which the balance of energy lists them."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fenics_mech.scene import Scene


class Cause(StrEnum):
    """What does work on a mechanism, beside its drives."""

    INERTIA = "inertia"
    WEIGHT = "weight"
    LOADS = "loads"
    IMPULSES = "impulses"
    SPRINGS = "springs"
    DAMPERS = "dampers"
    MATERIAL = "material"
    MODAL_DAMPING = "modal damping"
    EXTERNAL_DRAG = "external drag"
    RELATIVE_DRAG = "relative drag"
    AIR_DRAG = "air drag"
    FRICTION = "friction"
    CONTACTS = "contacts"
    BUSHINGS = "bushings"
    EFFORTS = "efforts"
    GEARS = "gears"
    STORED = "stored"


def cause_of_efforts(scene: Scene) -> str:
    """Give the name under which the power of all drives and freedoms together is listed."""
    kinds = ("drive", len(scene.drives)), ("freedom", len(scene.freedoms))
    return " and ".join(name if count == 1 else f"{name}s" for name, count in kinds if count) or "drive"
