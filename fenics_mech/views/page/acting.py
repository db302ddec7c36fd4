"""Loads and weights as the page draws them: where they act at every position, and how large they are."""

from __future__ import annotations

from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.known import GRAVITY
from fenics_mech.recovery.peaks import smoothed
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.rigid_places import between_ends
from fenics_mech.scene import Scene
from fenics_mech.views.geometry import Moments, ends_of, motion_of
from fenics_mech.views.judgements import acting
from fenics_mech.views.moving_points import load_arrows, load_names, mass_places
from fenics_mech.views.reading import ForceReading, Reading
from fenics_mech.views.words import short

FINE = 201  # places along a member, at which its line density is added up


def acting_of(reading: ForceReading) -> tuple[dict[str, Any], dict[str, Array]]:
    """Give names and sizes of loads and weights, and the arrays of where they act; nothing where nothing acts."""
    # Loads are places (m) and forces over the largest of their kind. Weights are places (m) of centres of mass: of
    # members, of links that do not bend, and of point masses.
    scene, result = reading.scene, reading.result
    names, weighs = load_names(scene), "weight" in kinds_of(reading)
    if not kinds_of(reading):
        return {}, {}
    at = result.data["time" if reading.in_time else "theta"].to_numpy()
    shown = Moments(result, at)
    found: dict[str, Array] = {}
    ends, bent = _lines(reading, len(at))
    if names:
        straight, moved = (
            load_arrows(shown, shown.motion, (ends, line), times) for line, times in zip(bent, (0.0, 1.0))
        )
        found |= {"loads": straight, "loads_bent": moved[:, :, 0] - straight[:, :, 0]}
    said: dict[str, Any] = {"loads": list(names)}
    if weighs:
        masses, places, moved_places = _masses(reading, shown, bent)
        force = masses * float(np.linalg.norm(scene.gravity))
        said |= {
            "weights": [f"{short(one / reading.units.size('force'))} {reading.units.label('force')}" for one in force],
            "weight_sizes": (force / force.max(initial=1e-300)).round(4).tolist(),
            "down": (np.array(scene.gravity) / np.linalg.norm(scene.gravity)).round(6).tolist(),
        }
        found |= {"weights": places, "weights_bent": moved_places - places}
    return said, {name: smoothed(result, values)[1] for name, values in found.items()}


def kinds_of(reading: ForceReading) -> list[str]:
    """Name what acts on a machine and can be drawn: loads with a force, and weight."""
    weighs = any(reading.scene.gravity) and any(effect.name == GRAVITY for effect in acting(reading.result))
    return ["loads"] * bool(load_names(reading.scene)) + ["weight"] * weighs


def _lines(reading: ForceReading, count: int) -> tuple[Array, tuple[Array, Array]]:
    """Ends of the members, and their straight and their bent lines (m), ``(angles, members, stations, 2)``."""
    if not isinstance(reading, Reading):
        return np.zeros((count, 0, 2, 2)), (np.zeros((count, 0, 2, 2)), np.zeros((count, 0, 2, 2)))
    ends = ends_of(reading.result)
    straight = between_ends(ends, reading.s)
    deflection = reading.result.data["deflection"].transpose("theta", "member", "s", "component").to_numpy()
    return ends, (straight, straight + deflection)


def _masses(reading: ForceReading, shown: Moments, lines: tuple[Array, Array]) -> tuple[Array, Array, Array]:
    """Masses (kg), and their centres without and with deflection (m), ``(angles, masses, 2)``."""
    scene, motion = reading.scene, motion_of(reading.result)
    masses: list[float] = []
    places: list[tuple[Array, Array]] = []
    for i, label in enumerate(scene.members()):
        mass, s = member_mass(scene, label)
        stations = reading.result.data["s"].to_numpy()
        masses.append(mass)
        places.append(tuple(at_place(np.moveaxis(line[:, i], 1, -1), stations, s) for line in lines))  # type: ignore[arg-type]
    for link, body in scene.links.items():
        if body.rigid is not None and body.rigid.mass:
            place = motion.of_point(link, body.rigid.centre)[0]
            masses.append(body.rigid.mass)
            places.append((place, place))
    points = [mass_places(shown, times)[0] for times in (0.0, 1.0)]
    for i, point in enumerate(scene.masses.values()):
        if point.mass:
            masses.append(point.mass)
            places.append((points[0][:, i], points[1][:, i]))
    straight, bent = (np.stack([pair[n] for pair in places], axis=1) for n in (0, 1))
    return np.array(masses), straight, bent


def member_mass(scene: Scene, label: str) -> tuple[float, float]:
    """Give the mass of a member (kg), and the place of its centre of mass along it, 0..1."""
    s = np.linspace(0, 1, FINE)
    density = scene.rigidity(label, s).line_density
    weights = np.gradient(s)  # of the trapezoidal rule
    weights[[0, -1]] /= 2
    whole, first = float(weights @ density), float(weights @ (density * s))
    length = float(np.linalg.norm(np.subtract(*scene.member_ends(label))))
    return whole * length, first / whole
