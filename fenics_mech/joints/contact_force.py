"""Normal force of a contact with restitution: Hunt and Crossley's form, ``F = K d^n (1 + c d'/v)``.

Source: Hunt and Crossley, J. Applied Mechanics 42 (1975); Lankarani and Nikravesh, J. Mechanical Design 112 (1990);
Flores, Machado, Silva and Martins, Multibody System Dynamics 25 (2011).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene import Contact
from fenics_mech.scene.joint_laws import LooseJoint


@dataclass(frozen=True)
class ContactLimits:
    """Limits of contacts."""

    least_speed: float = 1e-6  # m/s or rad/s, at which a contact counts as begun: its damping is over that speed
    nearly_elastic: float = 1e-6  # 1 - e, below which c is 3/2 of it to 6 digits


CONTACT = ContactLimits()


def damping_of(contact: Contact) -> float:
    """Give c of a contact by its restitution."""
    # In one dimension the energy of m x'' = -K d^n (1 + c d'/v) is known in closed form. The speed after the contact
    # over that before it is e where c (1 + e) = ln[(1 + c)/(1 - c e)], whatever n is.
    e = contact.restitution
    if contact.law == "lankarani-nikravesh":
        return 3 * (1 - e**2) / 4
    if contact.law == "flores":
        return 8 * (1 - e) / (5 * e)

    if 1 - e < CONTACT.nearly_elastic:
        return 1.5 * (1 - e)

    def left(share: float) -> float:
        c = share / e  # up to 1/e, beyond which the bodies would stick
        return math.log1p(c) - math.log1p(-share) - c * (1 + e)

    from scipy.optimize import brentq  # noqa: PLC0415  (slow to import, and few scenes have contacts)

    return float(brentq(left, e * (1 - e) / 2, 1 - 1e-15, xtol=1e-15, rtol=1e-14)) / e


def rubbing(stated: LooseJoint, push: Array, sliding: Array) -> Array:
    """Friction of a contact (N), ``(states,)``: Coulomb's, regularised at low speeds."""
    # push (states,) (N); sliding (states,) (m/s)
    return stated.friction * push * np.tanh(sliding / stated.width)


def contact_force(contact: Contact, depth: Array, rate: Array, speed: float) -> Array:
    """Force with which two bodies push each other apart, ``(states,)``; nothing where they do not touch."""
    # depth, rate (states,)
    elastic = contact.stiffness * np.maximum(depth, 0.0) ** contact.exponent
    return elastic * np.maximum(1 + damping_of(contact) * rate / max(speed, CONTACT.least_speed), 0.0)
