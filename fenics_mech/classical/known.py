"""What the dissertation's method knows of a scene."""

from __future__ import annotations

import numpy as np

from fenics_mech.effects import active
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import Load

KNOWN = {"damping", "gravity", "loads", "vibration"}  # effects that the method has


def unknown_part(scene: Scene) -> str | None:
    """Name what a scene states that (5.1) with modal damping does not know; None where it knows all."""
    damping, analysis = scene.damping, scene.analysis
    there = {
        "effects": {effect.name for effect in active(scene)} - KNOWN - {"springs", "dampers", "impulses", "motor"},
        "loads": [name for name, load in scene.loads.items() if not isinstance(load, Load) or load.follows],
        "springs": scene.springs,
        "dampers": scene.dampers,
        "joint_laws": scene.joint_laws,
        "impulses": scene.impulses,
        "freedoms": scene.freedoms,
        "plugins": scene.plugins,
        "drive": not scene.drives or [drive.motor for drive in scene.drives if drive.motor],
        "damping": damping.material or damping.external or damping.relative or damping.air,
        "analysis.start": analysis.method == "transient" and analysis.start != "rigid",
        "joints": [name for name, joint in scene.joints.items() if getattr(joint, "member", None) is not None],
        "sections": [member for _, member in scene.members().values() if not scene.sections[member.section].constant],
        "links": not scene.members()
        or [r for r in scene.rigidities(np.zeros(1)) if r.neutral.any() or r.mass_centre.any()],
    }
    return next((name for name, value in there.items() if value), None)


def has_modes(scene: Scene) -> bool:
    """Say whether a scene goes by sub-intervals: where it asks for them, or the program chooses."""
    # The program chooses them for the periodic motion of (5.1), where the method knows all that the scene states.
    asked, method = scene.analysis.solver, scene.analysis.method
    if asked == "sub-intervals":
        return method in ("periodic", "transient")
    return asked == "auto" and method == "periodic" and scene.effects != "auto" and unknown_part(scene) is None
