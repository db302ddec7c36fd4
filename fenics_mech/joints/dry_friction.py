"""Dry friction of pins and sliders: Coulomb's law with Stribeck's fall, regularised.

The friction is a share of the joint's force, which it changes in turn. It enters the balance as an unknown of its own.
Source: Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994); Threlfall, Mech. Mach. Theory 13 (1978).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.causes import Cause
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, WithoutContact, Wrench
from fenics_mech.scene import Friction, Scene


@dataclass(frozen=True)
class FrictionLimits:
    """How sharply friction changes its sense, and what creep of bodies that stick is told."""

    width: float = 1e-8  # m/s: what sticks creeps by less than 1e-3 mm in 20 s; a pin of 10 mm turns by 1e-6 rad/s
    width_of_bent: float = 1e-4  # m/s: vibration of links that bend crosses it, and steps become as short as it asks
    told: float = 1e-4  # m, of creep in a motion


FRICTION = FrictionLimits()


def with_width(stated: Friction, scene: Scene) -> Friction:
    """Give a law of friction with the speed over which it changes its sense.

    Parameters
    ----------
    stated
        What the scene states.
    scene
        The scene.
    """
    if stated.width is not None:
        return stated
    return stated.model_copy(update={"width": FRICTION.width_of_bent if scene.members() else FRICTION.width})


def creeping(scene: Scene) -> tuple[str, ...]:
    """Tell of joints whose bodies may creep where they stick, by more than a limit in a motion, or by what holds them.

    Parameters
    ----------
    scene
        The scene.
    """
    if scene.analysis.method == "static":
        return _left_out_at_rest(scene)
    if scene.analysis.method != "transient":
        return ()
    lasts, found = scene.period * (scene.analysis.cycles if scene.drives else 1), []
    for name, law in scene.joint_laws.items():
        w = (with_width(law, scene).width or 0.0) if isinstance(law, Friction) and law.coefficient else 0.0
        if w * lasts > FRICTION.told:
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


@dataclass(frozen=True)
class DryFriction(WithoutContact):
    """Dry friction at a joint, with its viscous share.

    Parameters
    ----------
    joint
        Where it acts.
    stated
        What the scene states.
    """

    joint: JointPlace
    stated: Friction
    cause = Cause.FRICTION

    @property
    def arm(self) -> float:
        """Radius at which a pin rubs (m); 1 of a slider."""
        return 1.0 if self.stated.radius is None else self.stated.radius

    def share(self, state: JointState) -> Array:
        """Friction on the second body over the joint's force (m of a pin, 1 of a slider), ``(states,)``.

        Parameters
        ----------
        state
            How the bodies move.
        """
        return -self.arm * coefficient(self.stated, self.arm * state.rate - self.stated.belt_speed)

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give the viscous share, which needs no force of the joint.

        Parameters
        ----------
        time, state, touching
            As of `JointLaw`.
        """
        return self.joint.effort(state, -self.stated.viscous * state.rate)


def coefficient(stated: Friction, speed: Array) -> Array:
    """Coefficient of friction with its sign, ``(states,)``.

    Parameters
    ----------
    stated
        The law.
    speed
        Sliding speed (m/s), ``(states,)``.
    """
    size = np.full_like(speed, stated.coefficient)
    if stated.static is not None and stated.stribeck is not None:
        size += (stated.static - stated.coefficient) * np.exp(-((speed / stated.stribeck) ** 2))
    assert stated.width is not None  # see `with_width`
    return size * np.tanh(speed / stated.width)
