"""Causes of work: the names by which the balance of energy lists them."""

from enum import StrEnum


class Cause(StrEnum):
    """What does work on a mechanism, beside its drives."""

    INERTIA = "inertia"
    WEIGHT = "weight"
    ELASTIC = "elastic"
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


LOSSES = (
    Cause.MATERIAL,
    Cause.MODAL_DAMPING,
    Cause.EXTERNAL_DRAG,
    Cause.RELATIVE_DRAG,
    Cause.DAMPERS,
    Cause.AIR_DRAG,
)  # causes that take energy for good
OF_JOINT_LAWS = (Cause.FRICTION, Cause.CONTACTS, Cause.BUSHINGS, Cause.EFFORTS, Cause.GEARS)
