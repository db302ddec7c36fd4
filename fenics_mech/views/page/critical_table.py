"""The card of critical speeds: those to avoid, and a table by mode and harmonic."""

from __future__ import annotations

import numpy as np

from fenics_mech._constants import TURN
from fenics_mech.safety.critical_speeds import CriticalSpeed, critical_speeds, multiplier_distances, speeds_to_avoid
from fenics_mech.safety.critical_speeds import turns as speed_of
from fenics_mech.views.critical_words import band_of, cause_of, rise_of, speeds_in_words
from fenics_mech.views.page.html import EMPTY, Html, join, table, tag
from fenics_mech.views.reading import ForceReading
from fenics_mech.views.words import percent, short

MEANING = (
    "Critical speeds by harmonic of the drive, from the mean frequency about the motion; those in bold are strong. "
    "Spin and axial forces are taken to grow with the square of the speed, and deflections to stay small."
)


def critical(reading: ForceReading) -> Html:
    """List the nearest speeds to avoid, and tabulate the critical speeds of each mode.

    Parameters
    ----------
    reading
        The result.
    """
    result, head = reading.result, ["avoid", "critical", "from here", "which<", "its vibration, about"]
    near = [
        [band_of(result, one), speed_of(result, one.speed), f"{100 * one.distance:+.1f} %", cause_of(one), rise_of(one)]
        for one in speeds_to_avoid(result)
    ]
    nearest = table(head, near) if near else tag("p", f"Avoid: {speeds_in_words(result)}.", class_="hint")
    return join([nearest, tag("p", MEANING, class_="hint"), _by_mode(reading)])


def _by_mode(reading: ForceReading) -> Html:
    """Tabulate name, frequencies, damping, distance from resonance and critical speeds of each mode."""
    data = reading.result.data
    known = {(mode.modes, mode.order, mode.speed): mode for mode in critical_speeds(reading.result)}
    near, unit = multiplier_distances(reading.result), speed_of(reading.result, 1.0).split()[1]
    orders = np.unique(data["critical_order"].to_numpy()[np.isfinite(data["critical_order"].to_numpy())])
    rows = []
    for mode in data["mode"].to_numpy():
        one = data.sel(mode=mode)
        of_mode = [found for found in known.values() if found.speed in one["critical_speed"].to_numpy()]
        if not of_mode:
            continue
        mean, run = (float(one["mode_frequency"].sel(limit=limit)) for limit in ("mean", "running"))
        by_order = {found.order: found for found in of_mode}
        cells = [_cell(by_order.get(order)) for order in orders]
        name = join([str(mode), tag("small", of_mode[0].name)])
        rows.append(
            [name, short(mean), short(run), percent(of_mode[0].damping), short(near.get(int(mode), np.nan)), *cells]
        )
    head = ["mode", "held, Hz", "running, Hz", "damping", "|1 \N{MINUS SIGN} \N{GREEK SMALL LETTER MU}|"]
    return table([*head, *(f"{order:g}\N{MULTIPLICATION SIGN}, {unit}" for order in orders)], rows)


def _cell(one: CriticalSpeed | None) -> Html:
    if one is None:
        return EMPTY
    text = short(one.speed * 60 / TURN)
    return tag("b", text) if one.band else tag("span", text)
