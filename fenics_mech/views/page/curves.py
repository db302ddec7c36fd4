"""Arrays that the page draws, packed: 16-bit second differences along each curve, deflated, in letters."""

from __future__ import annotations

import base64
import zlib
from functools import partial
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech._constants import TINY, TURN
from fenics_mech.effects.known import GRAVITY
from fenics_mech.recovery.peaks import smoothed
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.rigid_places import between_ends
from fenics_mech.recovery.signal import PEAK as AT_PEAK
from fenics_mech.scene import Scene
from fenics_mech.scene.answer_units import KINDS
from fenics_mech.views.drawn_parts import (
    Moments,
    ends_of,
    ground_points,
    guides_of,
    load_arrows,
    load_names,
    mass_places,
    motion_of,
    moving_guides,
    pin_places,
    places_of,
    rigid_bars,
    slider_angles,
)
from fenics_mech.views.frames import default_magnification
from fenics_mech.views.judgements import acting
from fenics_mech.views.reading import SECTION_FORCES, ForceReading, Reading
from fenics_mech.views.words import DEGREE, short

FINE = 201  # places along a member, at which its line density is added up
STEPS = 32767  # of a 16-bit number
DRAWN = 2047  # of deflections, which are drawn and not told: a tenth of a pixel
MOST = 1200  # positions of a motion in time; more do not show on a screen
MOST_HARMONICS = 60
QUICK = 4  # level of zlib: 9 takes 50 times as long for 15 % less


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
    found: list[tuple[Any, ...]] = []
    for i, label in enumerate(scene.members()):
        mass, s = member_mass(scene, label)
        stations = reading.result.data["s"].to_numpy()
        straight, bent = (at_place(np.moveaxis(line[:, i], 1, -1), stations, s) for line in lines)
        found.append((mass, straight, bent))
    for link, body in scene.links.items():
        if body.rigid is not None and body.rigid.mass:
            place = motion.of_point(link, body.rigid.centre)[0]
            found.append((body.rigid.mass, place, place))
    points = [mass_places(shown, times)[0] for times in (0.0, 1.0)]
    for i, point in enumerate(scene.masses.values()):
        if point.mass:
            found.append((point.mass, points[0][:, i], points[1][:, i]))
    straight, bent = (np.stack([one[n] for one in found], axis=1) for n in (1, 2))
    return np.array([one[0] for one in found]), straight, bent


def member_mass(scene: Scene, label: str) -> tuple[float, float]:
    """Give the mass of a member (kg), and the place of its centre of mass along it, 0..1."""
    s = np.linspace(0, 1, FINE)
    density = scene.rigidity(label, s).line_density
    weights = np.gradient(s)  # of the trapezoidal rule
    weights[[0, -1]] /= 2
    whole, first = float(weights @ density), float(weights @ (density * s))
    length = float(np.linalg.norm(np.subtract(*scene.member_ends(label))))
    return whole * length, first / whole


def payload(reading: ForceReading) -> dict[str, Any]:
    """Give what the script of the page draws."""
    shown = _shown(reading)
    acts, moved = acting_of(reading)
    arrays = {**_curves(reading), **_places(reading), **moved}
    return {
        "title": reading.scene.name,
        "units": {kind: reading.units.label(kind) for kind in KINDS},
        **_axis(reading, shown),
        "joints": reading.joints,
        "names": list(reading.scene.joints),
        "pin_of": _pins(reading),
        **_members(reading, shown),
        "traced": _traced(reading),
        "effort": list(reading.effort_name) if reading.effort is not None else None,
        "freedoms": _freedoms(reading),
        **_fixed(reading),
        "acts": acts,
        "arrays": {name: packed(values[shown], DRAWN if name == "bent" else STEPS) for name, values in arrays.items()},
    }


def _members(reading: ForceReading, shown: Index) -> dict[str, Any]:
    """What there is of each member: none where no link bends."""
    if not isinstance(reading, Reading):
        none = dict.fromkeys(("members", "fibres", "ends", "s", "lengths", "peaks"), ())
        return {**none, "magnify": 1.0, "sections": {}}
    return {
        "members": reading.members,
        "fibres": reading.fibres,
        "ends": [list(ends) for ends in reading.ends],
        "s": reading.s.tolist(),
        "lengths": (reading.lengths / reading.units.size("length")).tolist(),
        "peaks": [[int(np.flatnonzero(shown == peak.k)[0]), peak.j, peak.f] for peak in reading.peaks],
        "magnify": default_magnification(reading.result),
        "sections": sections_of(reading),
    }


def sections_of(reading: Reading) -> dict[str, list[str]]:
    """Name of each section force that the result has, and its unit."""
    known = {name: [said, reading.units.label(kind)] for name, (said, kind) in SECTION_FORCES.items()}
    return {name: known[name] for name in known if name in reading.result.data}


def _pins(reading: ForceReading) -> list[int]:
    """Number of the pin at which each joint's force acts: one through three links has two, "A:rod" and so; -1: none."""
    pins = {name: n for n, name in enumerate(reading.scene.joints)}
    return [pins.get(label, pins.get(label.partition(":")[0], -1)) for label in reading.joints]


def _traced(reading: ForceReading) -> list[str]:
    """Names of the points that the scene traces, of which the result knows the paths."""
    known = [str(name) for name in reading.result.data["point"].to_numpy()] if "point" in reading.result.data else []
    return [name for name in reading.scene.points if name in known]


def _freedoms(reading: ForceReading) -> list[list[str]]:
    """Name of each freedom, and the unit of its curve."""
    if "freedom_place" not in reading.result.data:
        return []
    slides = [reading.scene.joints[name].kind in ("slot", "prismatic") for name in reading.scene.freedoms]
    return [[name, reading.units.label("length") if s else DEGREE] for name, s in zip(reading.scene.freedoms, slides)]


def packed(values: Array, steps: int = STEPS) -> dict[str, Any]:
    """Round to a share of the largest value, take second differences from position to position, and deflate."""
    # values: numbers, ``(positions, ...)``
    values = np.nan_to_num(np.asarray(values, dtype=float).reshape(len(values), -1))
    scale = max(float(np.abs(values).max(initial=0.0)), TINY * steps) / steps
    curves = np.rint(values / scale).astype("<i2").T
    differences = np.diff(np.diff(curves, prepend=curves[:, :1] * 0), prepend=curves[:, :1] * 0)  # modulo 2^16
    planes = differences.reshape(-1).view(np.uint8).reshape(-1, 2).T.tobytes()
    text = base64.b64encode(zlib.compress(planes, QUICK)).decode()
    return {"row": values.shape[1], "scale": scale, "data": text}


def _shown(reading: ForceReading) -> Index:
    """Numbers of the positions that are shown: of a turn all by their angle, of a long motion some and all peaks."""
    if not reading.in_time:
        angle = np.mod(np.round(reading.theta, 12), TURN)
        return np.argsort(angle, kind="stable")
    count = len(reading.theta)
    some = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(int))
    peaks = [peak.k for peak in reading.peaks] if isinstance(reading, Reading) else []
    peaks += [int(k) for k in reading.force.argmax(axis=0)]
    peaks += [int(np.abs(reading.effort).argmax())] if reading.effort is not None else []
    return np.union1d(some, peaks)


def _axis(reading: ForceReading, shown: Index) -> dict[str, Any]:
    """What the positions are along: the drive angle (degrees), or time (s)."""
    if reading.in_time:
        time = reading.data["time"].to_numpy()[shown]
        return {"kind": "time", "axis": time.round(9).tolist(), "seconds": float(np.ptp(time)), "direction": 1}
    angle = np.degrees(np.mod(np.round(reading.theta, 12), TURN))[shown]
    turns = len(angle) > 1
    back = turns and reading.theta[1] < reading.theta[0]
    kind = "turn" if turns else "still"
    seconds = float(reading.scene.period) if reading.scene.drives else None
    return {"kind": kind, "axis": angle.round(4).tolist(), "seconds": seconds, "direction": -1 if back else 1}


def _curves(reading: ForceReading) -> dict[str, Array]:
    """Stresses, strains, forces, and what else is drawn as curves, in the units of the answer."""
    data = reading.result.data
    found = {"force": reading.of("joint_force", "joint", "component") / reading.units.size("force")}
    if reading.shaking is not None:
        found["shaking"] = reading.shaking[0]
    if reading.effort is not None:
        found["effort"] = reading.effort
    if "frequency" in data:
        found["frequency"] = smoothed(reading.result, data["frequency"].transpose("theta", "mode").to_numpy())[1]
    if freedoms := _freedoms(reading):
        sizes = [np.radians(1.0) if unit == DEGREE else reading.units.size("length") for _, unit in freedoms]
        found["freedom"] = reading.of("freedom_place", "freedom") / np.array(sizes)
    if not isinstance(reading, Reading):
        return found
    found |= {"stress": reading.stress, "strain": reading.strain}
    found |= {name: reading.section_force(name) for name in sections_of(reading)}
    for name in ("strain", "stress"):
        if (still := f"{name}_quasi_static") in data:
            curves = data[still].transpose("theta", "member", "s", "fibre").to_numpy() / reading.units.size(name)
            at_peaks = np.stack([curves[:, peak.i, peak.j, peak.f] for peak in reading.peaks], axis=1)
            found[f"{name}_still"] = smoothed(reading.result, at_peaks, name)[1]
    return found


def _places(reading: ForceReading) -> dict[str, Array]:
    """Where members, pins, guides and traced points are in the rigid linkage, and how far deflection moves them (m)."""
    result, scene = reading.result, reading.scene
    motion = motion_of(result)
    ends, lines = _lines(reading, len(motion.theta))
    found = {}
    if isinstance(reading, Reading):
        bent = result.data["deflection"].transpose("theta", "member", "s", "component").to_numpy()
        found = {"ends": ends, "bent": bent}
    pins = [pin_places(scene, motion, line) for line in lines]
    both = {  # in the rigid linkage, and with deflection
        "pins": pins,
        "bars": [rigid_bars(scene, motion, at) for at in pins],
        "rails": [moving_guides(result, motion, partial(places_of, result, magnify=times)) for times in (0.0, 1.0)],
        "traced": [places_of(result, _traced(reading), times) for times in (0.0, 1.0)],
    }
    for name, (rigid, moved) in both.items():
        found |= {name: rigid, f"{name}_bent": moved - rigid}
    _, angles = slider_angles(scene, motion)
    found["guides"] = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return {name: smoothed(result, values)[1] for name, values in found.items()}


def _fixed(reading: ForceReading) -> dict[str, Any]:
    """What does not depend on the position: ground, guides, harmonics of the strain, multipliers."""
    result, scene = reading.result, reading.scene
    data, motion = result.data, motion_of(result)
    found: dict[str, Any] = {
        "ground": ground_points(scene).tolist(),
        "tracks": guides_of(scene, motion).tolist(),
        "sliders": slider_angles(scene, motion)[0],
    }
    if "strain_amplitude" in data:
        amplitude = data["strain_amplitude"].sel(gauge=AT_PEAK).transpose("member", "harmonic").to_numpy()
        found["harmonics"] = _rounded(amplitude[:, : MOST_HARMONICS + 1] / reading.units.size("strain"))
    if "multiplier" in data:
        found["multipliers"] = _rounded(data["multiplier"].transpose("disturbance", "part").to_numpy())
    return found


def _rounded(values: Array) -> list[list[float]]:
    return [[float(f"{value:.4g}") for value in line] for line in np.nan_to_num(values)]
