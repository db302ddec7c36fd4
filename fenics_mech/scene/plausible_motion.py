"""Whether a machine can move as fast as its scene states."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech._constants import TURN
from fenics_mech.scene.drives import Drive
from fenics_mech.scene.joint_law_checks import with_units
from fenics_mech.scene.models import Scene
from fenics_mech.scene.plausible_limits import USUAL, Found, likely
from fenics_mech.scene.sections import Rigidity


def motion(scene: Scene) -> Found:
    """Estimate speeds, and strains by the inertia across members, whose links go as fast as those that are driven."""
    if scene.analysis.method == "static":  # held at one position
        return
    theta = TURN / 720 * np.arange(720, dtype=float)
    for place, drive in scene.drives_by_place.items():
        jet = drive.jet(theta, scene.cycle_rate)
        fastest = float(np.abs(jet.first).max()) * abs(scene.cycle_rate)
        sharpest = float(np.abs(jet.second).max()) * scene.cycle_rate**2
        key = "speed" if drive.speed is not None else "law"
        if not scene.joints[drive.joint].slides:
            yield from _of_swing(f"{place}.law", drive, jet.value)
            yield from _of_turning(scene, f"{place}.{key}", drive, fastest, sharpest)
        else:
            lengths = [math.dist(*scene.member_ends(label)) for label in scene.members()]
            yield from _of_stroke(f"{place}.law", jet.value, max(lengths))
            across = dict.fromkeys(scene.members(), sharpest)
            yield from _of_inertia(scene, f"{place}.law", "the stroke", across, "")


def _of_turning(scene: Scene, place: str, drive: Drive, fastest: float, sharpest: float) -> Found:
    """Look at a drive that turns, by its largest speed (rad/s) and angular acceleration (rad/s^2)."""
    what, arm = f"{fastest:.6g} rad/s", scene.size_at(drive.joint)
    rpm = f": {fastest:.6g} rpm = {fastest * TURN / 60:.4g} rad/s may be meant" * (drive.speed is not None)
    across = {label: _across(scene, label, drive, arm, fastest, sharpest) for label in scene.members()}
    yield from _of_inertia(scene, place, what, across, rpm)
    if arm * fastest > USUAL.fastest_tip:
        yield place, f"{what} moves the driven link's end at {arm * fastest:.4g} m/s{rpm}"
    elif drive.speed is not None and fastest >= USUAL.least_nominal and fastest % USUAL.step_of_nominal == 0:
        told = f"{fastest * 60 / TURN:.0f} rpm"
        yield place, f"{what} are {told}{rpm}. If not, write '{told}'"


def _across(scene: Scene, label: str, drive: Drive, arm: float, fastest: float, sharpest: float) -> float:
    """Acceleration across a member (m/s^2), at most."""
    # A link that turns about the drive's joint is drawn to it. Others turn against what carries them, so that all the
    # acceleration of its end is across them at some position.
    body = scene.members()[label][0]
    pivots = [point.split(".") for point in scene.joints[drive.joint].connect]
    here = [scene.links[body].points[name] for link, name in pivots if link == body]
    if not here:
        return arm * (sharpest + fastest**2)
    first, second = map(np.array, scene.member_ends(label))
    along = (second - first) / np.linalg.norm(second - first)
    from_pivot = np.array([first, second]) - here[0]
    beside = abs(float(along[0] * from_pivot[0, 1] - along[1] * from_pivot[0, 0]))
    return beside * fastest**2 + float(np.abs(from_pivot @ along).max()) * sharpest


def _of_inertia(scene: Scene, place: str, what: str, across: dict[str, float], meant: str) -> Found:
    """Estimate the strains by accelerations across members (m/s^2), by label."""
    strain, label = max((_bent_by(scene, name, acceleration), name) for name, acceleration in across.items())
    if strain > USUAL.largest_strain:
        yield (
            place,
            f"{what} accelerates links by about {across[label]:.3g} m/s^2, which strains member {label} by about "
            f"{strain:.2g} (metals yield at 0.001 to 0.01){meant}",
        )


def _bent_by(scene: Scene, label: str, acceleration: float) -> float:
    """Strain ``rho A a L^2 c/(8 EI)`` of a member on two pins that is accelerated across, at mid-span."""
    rigid, length = scene.rigidity(label, np.array([0.5])), math.dist(*scene.member_ends(label))
    return bending_strain(rigid, float(rigid.line_density[0]) * acceleration * length**2 / 8)


def bending_strain(rigid: Rigidity, moment: float) -> float:
    """Strain of the outer fibres by a bending moment (N m)."""
    return moment * float(np.abs(rigid.fibre).max()) / float(rigid.bending[0])


def _of_swing(place: str, drive: Drive, angle: np.ndarray) -> Found:
    mean, swing = float(angle.mean()), float(np.ptp(angle))
    if drive.law is not None and not any(with_units(drive.law)) and max(abs(mean), swing) > USUAL.largest_angle:
        yield (
            place,
            f"the law swings by {swing:.4g} rad about {mean:.4g} rad, or {swing / TURN:.3g} turns: degrees are likely "
            "meant, and a number without a unit is in rad",
        )


def _of_stroke(place: str, stroke: np.ndarray, longest: float) -> Found:
    if (size := float(np.ptp(stroke))) > USUAL.longest_stroke * longest:
        meant = likely(size, "m", (("mm", 1e-3),), 0, longest)
        yield place, f"the stroke is {size:.4g} m, and no member is longer than {longest:.4g} m{meant}"
