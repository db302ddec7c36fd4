"""Which errors of a result are accepted, how far the theories hold, and what is said of larger errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from fenics_mech.errors import ANSWERED, UnresolvedError, percent
from fenics_mech.estimate.missed_peaks import BETWEEN
from fenics_mech.scene import Damping, Scene


@dataclass(frozen=True)
class AcceptedErrors:
    """Largest errors of a result that is not refused, relative to the largest value of a quantity."""

    by_steps: float = 0.02  # of a strain: steps are cheap
    by_positions: float = 0.05  # of a strain or joint force: so are positions
    of_strain: float = 0.05  # by all numerical sources
    of_rest: float = 0.5  # of deflections and joint forces: beyond it not one digit is known
    margin: float = 1.2  # factor on the numbers that a refusal asks for


ACCEPTED = AcceptedErrors()


@dataclass(frozen=True)
class ValidityLimits:
    """How far the theories hold."""

    euler_ratio: float = 0.05  # beyond it the axial force changes the bending by more than about as much
    bow: float = 0.02  # of the length; beyond it bending shortens a member noticeably
    rotation: float = 1.3  # rad; there 8 elements give a cantilever's tip to 1e-4, and at 90 degrees the strain ends
    farthest: float = 1.0  # rad, or of the length; a cantilever's end at 1 rad in linear theory turns by 0.78


VALIDITY = ValidityLimits()
ORIGINS = {"time": "time steps", "mesh": "mesh", "modes": "modes left out", "harmonics": "harmonics left out"}
ORIGINS |= {BETWEEN: "peaks between positions"}
FAULTS = {
    "time": "the sub-intervals are too long",
    "mesh": "the elements are too long",
    "modes": "the modes kept are too few",
    "harmonics": "the harmonics are too few",
}


def refusal_by(
    scene: Scene,
    what: str,
    measure: str,
    shares: Mapping[str, float],
    order: Mapping[str, float],
    limit: float,
    least: int,
) -> UnresolvedError:
    """Say which source has the largest part in the error of a strain or force, and what to do about it."""
    total, source = sum(shares.values()), max(shares, key=shares.__getitem__)
    room = max(limit - (total - shares[source]), limit / 2)
    in_time = source == "time" and scene.analysis.method == "transient"
    fault = "the time steps or sub-intervals are too long" if in_time else FAULTS[source]
    times = (shares[source] / room) ** (1 / order[source])
    cure, finer = advice(scene, source, times, least)
    if least:
        finer["sub_intervals"] = max(least, finer.get("sub_intervals", 0))
        cure += "" if "sub_intervals" in cure else f", and at least {least} sub_intervals"
    return UnresolvedError(
        f"{fault}: the {what} an estimated {percent(total)} of {measure}, "
        f"{percent(shares[source])} of it from the {ORIGINS[source]}. "
        f"{cure}; analysis.allow_coarse lets it pass"
    ).finer_by(ANSWERED, **finer)


def advice(scene: Scene, source: str, times: float, least: int) -> tuple[str, dict[str, float]]:
    """Say how many more it takes for an error to fall so many times, of sub-intervals as many as `least`, and which."""
    analysis, more = scene.analysis, ACCEPTED.margin * times
    if source == "time" and analysis.method == "transient":
        tolerance = analysis.time_tolerance / more
        said = f"Take analysis.time_tolerance = {tolerance:.1g}, and where the material damps more sub_intervals"
        return said, {"time_tolerance": tolerance}
    if source == "mesh":
        return f"Take {math.ceil(more * 100) / 100:.3g} times as many elements, rounded up", {"elements": more}
    name = "sub_intervals" if source == "time" else source
    enough = math.ceil(more * getattr(analysis, name))
    finer, first = {name: float(enough)}, "Take"
    if source == "harmonics":  # which need more than four times as many sub-intervals
        finer["sub_intervals"] = max(analysis.sub_intervals, 4 * enough + 2)
    if source == "time":
        enough = max(enough, least)
        if scene.damping == Damping() and not scene.dampers:
            first = "State the damping, as nothing damps the vibration, or take"
    return f"{first} at least {enough} {name}", finer
