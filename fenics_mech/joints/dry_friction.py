"""Dry friction of pins and sliders: Coulomb's law with Stribeck's fall, regularised.

The friction is a share of the joint's force, which it changes in turn. It enters the balance as an unknown of its own.
Source: Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994); Threlfall, Mech. Mach. Theory 13 (1978).
"""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene import Friction, Scene

TOLD = 1e-4  # m: creep in a motion, above which it is told


def creeping(scene: Scene) -> tuple[str, ...]:
    """Tell of joints whose bodies may creep where they stick by more than a limit, or by what holds them."""
    if scene.analysis.method == "static":
        return _left_out_at_rest(scene)
    if scene.analysis.method != "transient":
        return ()
    lasts, found = scene.period * (scene.analysis.cycles if scene.drives else 1), []
    for name, law in scene.joint_laws.items():
        w = law.width if isinstance(law, Friction) and law.coefficient else 0.0
        if w * lasts > TOLD:
            found.append(
                f"joint_laws.{name}.width: where its bodies stick, they creep at up to about {w:.3g} m/s, which is "
                f"{1e3 * w * lasts:.3g} mm in {lasts:.4g} s. A smaller width lets them creep less, and takes more steps"
            )
    return tuple(found)


def _left_out_at_rest(scene: Scene) -> tuple[str, ...]:
    """Tell of friction at rest that an answer leaves out: beside drives that hold all links, and in contacts."""
    led = not scene.freedoms
    found = [
        f"joint_laws.{name}: the drives hold all links, and friction may take any part of the load up to its limit. "
        "The efforts and forces are those without it"
        for name, law in scene.joint_laws.items()
        if led and isinstance(law, Friction) and law.coefficient and not law.belt_speed
    ]
    return tuple(found) + tuple(
        f"joint_laws.{name}.friction: friction of a contact at rest is left out, and may hold the linkage elsewhere. "
        "method = 'transient' with a duration shows it"
        for name, law in scene.joint_laws.items()
        if getattr(law, "friction", 0.0)
    )


def line(held: Array, speed: Array) -> Array:
    """Tangent of tanh at `held`, ``(states,)``."""
    # held, speed (states,) each
    at = np.tanh(held)
    return np.asarray(at + (1 - at**2) * (speed - held))


def held_at(share: Array, speed: Array) -> Array:
    """Give where friction is held next, ``(states,)``, by the share of its limit that a step of Newton's predicts."""
    # share (states,); speed (states,)
    # It is held where its law gives that share. Beyond its limits it slides, and so it does where the speed is larger
    # than the tangents of the law let it be at that share. Where it would slide the other way, it is held at rest
    # first.
    inside = np.abs(share) < 1
    back = np.arctanh(np.where(inside, share, 0.0))
    slides = share * speed > 0
    stays = inside & ~(slides & (np.abs(speed) > np.abs(back) + 1))
    return np.where(stays, back, np.where(slides, speed, 0.0))


def coefficient(stated: Friction, speed: Array) -> Array:
    """Coefficient of friction with its sign, ``(states,)``."""
    # speed (states,) (m/s)
    return largest(stated, speed) * np.tanh(speed / stated.width)


def largest(stated: Friction, speed: Array) -> Array:
    """Coefficient of friction at its limit, ``(states,)``."""
    size = np.full_like(speed, stated.coefficient)
    if stated.static is not None and stated.stribeck is not None:
        size += (stated.static - stated.coefficient) * np.exp(-((speed / stated.stribeck) ** 2))
    return size
