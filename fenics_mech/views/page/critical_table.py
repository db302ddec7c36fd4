"""The card of critical speeds: those to avoid, and a table by mode and harmonic."""

from __future__ import annotations

import numpy as np

from fenics_mech.safety.critical_speeds import (
    CriticalSpeed,
    cause_of,
    critical_speeds,
    multiplier_distances,
    speeds_to_avoid,
)
from fenics_mech.safety.critical_speeds import turns as speed_of
from fenics_mech.views.critical_words import band_of, rise_of, runs_in, speeds_in_words
from fenics_mech.views.page.html import EMPTY, Html, join, table, tag
from fenics_mech.views.reading import ForceReading
from fenics_mech.views.words import MINUS, percent, short

MEANING = (
    "Speeds ({}) at which 1, 2, 3 and more times the drive's rate meets a mode; in bold where vibration then adds much "
    "strain. Running: the mean frequency about the motion. Spin and axial forces are taken to grow with the square of "
    "the speed, and deflections to stay small."
)


def critical(reading: ForceReading) -> Html:
    """List the nearest speeds to avoid, and tabulate the critical speeds of each mode."""
    result = reading.result
    near = []
    for one in speeds_to_avoid(result):
        level = "warn" if runs_in(result, one) else "note"
        near.append(tag("li", tag("b", band_of(result, one)), _about(reading, one), class_=level))
    nearest = tag("ul", *near, class_="reasons") if near else tag("p", f"To be avoided: {speeds_in_words(result)}.")
    unit = speed_of(result, 1.0).split()[1]
    return join([nearest, tag("p", MEANING.format(unit), class_="hint"), _by_mode(reading)])


def _about(reading: ForceReading, one: CriticalSpeed) -> Html:
    """Say of a critical speed where it is, which mode it is of, and how strong it is."""
    side = "above" if one.distance >= 0 else "below"
    where = f"{speed_of(reading.result, one.speed)}, {percent(abs(one.distance))} {side} the present speed"
    return tag("span", f"Critical at {where}: {cause_of(reading.result, one)}; {rise_of(one)}.")


def _by_mode(reading: ForceReading) -> Html:
    """Tabulate link, frequencies, damping, distance from resonance and critical speeds of each mode."""
    data = reading.result.data
    by_mode: dict[int, dict[float, CriticalSpeed]] = {}
    for one in critical_speeds(reading.result):
        by_mode.setdefault(one.mode, {})[one.order] = one
    modes = sorted(by_mode)
    of_modes = [next(iter(by_mode[mode].values())) for mode in modes]
    near, frequency = multiplier_distances(reading.result), data["mode_frequency"].sel(mode=modes)
    rows = [
        ["link", *(one.link for one in of_modes)],
        ["veers with", *(" ".join(str(other) for other in one.modes if other != one.mode) for one in of_modes)],
        ["held, Hz", *(short(float(value)) for value in frequency.sel(limit="mean"))],
        ["running, Hz", *(short(float(value)) for value in frequency.sel(limit="running"))],
        ["damping ratio", *(percent(one.damping) for one in of_modes)],
        [f"|1 {MINUS} \N{GREEK SMALL LETTER MU}|", *(short(near.get(mode, np.nan)) for mode in modes)],
    ]
    rows = [row for row in rows if any(text.strip("\N{EN DASH}") for text in row[1:])]
    for order in sorted({order for found in by_mode.values() for order in found}):
        cells = [_cell(by_mode[mode].get(order)) for mode in modes]
        rows.append([f"{order:g}\N{MULTIPLICATION SIGN}", *cells])
    return table(["", *(f"mode {mode}" for mode in modes)], rows)


def _cell(one: CriticalSpeed | None) -> Html:
    """Write a critical speed; in bold where it is to be avoided."""
    if one is None:
        return EMPTY
    text = short(one.speed * 30 / np.pi)
    return tag("b", text) if one.band else tag("span", text)
