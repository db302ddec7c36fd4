"""Picture of the sound of vibrating links: the level of each harmonic, as it is and as the ear weights it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from fenics_mech.recovery.sound import REFERENCE, a_weighting
from fenics_mech.views.figures import COLOURS, empty_figure, finish

SHOWN = 60.0  # dB below the loudest harmonic, from which one is shown


def sound_figure(found: xr.Dataset) -> Figure:
    """Draw the sound pressure levels of the harmonics at the distance of a sound."""
    frequency, power = (found[name].to_numpy()[1:] for name in ("sound_frequency", "sound_power"))
    kept = power > power.max() * 10 ** (-SHOWN / 10)
    level = 10 * np.log10(power[kept] / REFERENCE) + found.attrs["pressure_level"] - found.attrs["power_level"]
    weighted = level + a_weighting(frequency[kept])
    floor = weighted.max() - SHOWN
    figure, (axes,) = empty_figure()
    for values, colour, label in ((level, COLOURS[5], "as it is"), (weighted, COLOURS[0], "A-weighted")):
        axes.vlines(frequency[kept], floor, np.maximum(values, floor), color=colour, lw=2)
        shown = values > floor
        axes.plot(frequency[kept][shown], values[shown], "o", color=colour, ms=4, label=label)
    axes.set_xlabel("frequency (Hz)")
    finish(axes, f"Sound of the links at {found.attrs['distance']:g} m", "level (dB re 20 \N{MICRO SIGN}Pa)")
    return figure
