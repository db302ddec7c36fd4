"""Figures of motions with freedoms: their places and rates, Poincaré section, growth of disturbances, spectrum."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from fenics_mech._constants import MILLI
from fenics_mech.recovery import Result
from fenics_mech.scene.joints import effort_units
from fenics_mech.views.figures import empty_figure, finish
from fenics_mech.views.plots import abscissa, over
from fenics_mech.views.reading import ForceReading

SHOWN = {"N m": ("deg", float(np.degrees(1.0))), "N": ("mm", MILLI)}  # unit of a freedom by that of its effort
ROW = 3.2  # inches
LEAST_SHOWN = 1e-5  # of the largest amplitude


def freedom_figure(result: Result) -> Figure:
    """Draw the angle or stroke of each freedom, and below it their rates."""
    reading, (figure, panels) = ForceReading(result), empty_figure(rows=2, height=5.8)
    efforts = effort_units(tuple(result.scene.freedoms), result.scene.joints)
    kinds = ("freedom_place", "Freedoms", ""), ("freedom_rate", "Their rates", "/s")
    for axes, (name, title, per) in zip(panels, kinds):
        for freedom, effort, values in zip(result.scene.freedoms, efforts, reading.of(name, "freedom").T):
            unit, factor = SHOWN[effort]
            axes.plot(*over(reading, factor * values), label=f"{freedom} ({unit}{per})")
        finish(axes, title, " or ".join(f"{unit}{per}" for unit in sorted({SHOWN[effort][0] for effort in efforts})))
    abscissa(panels[-1], reading)
    return figure


def poincare_figure(result: Result) -> Figure:
    """Draw the rate of each freedom over its angle or stroke, in the Poincaré section."""
    # Angles are drawn within a turn.
    rows = result.data.sizes["freedom"]
    figure, panels = empty_figure(rows=rows, height=max(4.2, ROW * rows), shared=False)
    for axes, freedom, (unit, factor, turns) in zip(panels, result.data["freedom"].to_numpy(), _units(result)):
        place, rate = (result.data[name].sel(freedom=freedom).to_numpy() for name in ("section_place", "section_rate"))
        if turns:
            place = np.angle(np.exp(1j * place))
        size = 6 if len(place) < 200 else 1.5
        axes.plot(factor * place, factor * rate, "o", markersize=size, markeredgewidth=0)
        finish(axes, f"Poincaré section of {freedom}: {len(place)} points", f"rate ({unit}/s)")
        axes.set_xlabel(f"{'angle' if turns else 'stroke'} ({unit})")
    return figure


def growth_figure(result: Result) -> Figure:
    """Draw the logarithms of what disturbances of a motion have grown by; their slopes are the Lyapunov exponents."""
    figure, (axes,) = empty_figure(height=4.2)
    time, data = result.data["time"].to_numpy(), result.data
    curves = data["disturbance_growth"].transpose("exponent", "theta").to_numpy()
    for exponent, size, curve in zip(data["exponent"].to_numpy(), data["lyapunov_exponent"].to_numpy(), curves):
        axes.plot(time, curve, label=f"exponent {exponent}: {size:.4g} 1/s")
    finish(axes, "Growth of disturbances; exponents over the second half", "natural logarithm")
    axes.set_xlabel("time (s)")
    return figure


def freedom_spectrum_figure(result: Result) -> Figure:
    """Draw the spectrum of the freedoms' rates."""
    spectrum = result.derived("freedom_spectrum")
    figure, (axes,) = empty_figure(height=4.2)
    frequency = spectrum["spectrum_frequency"].to_numpy()
    least = LEAST_SHOWN * float(np.maximum(spectrum.to_numpy().max(), np.finfo(float).tiny))
    for freedom, (unit, factor, _) in zip(spectrum["freedom"].to_numpy(), _units(result)):
        sizes = np.maximum(spectrum.sel(freedom=freedom).to_numpy(), least)
        axes.semilogy(frequency[1:], factor * sizes[1:], label=f"{freedom} ({unit}/s)")
    units = " or ".join(sorted({f"{unit}/s" for unit, _, _ in _units(result)}))
    finish(axes, "Spectrum of the freedoms' rates", f"amplitude ({units})")
    axes.set_xlabel("frequency (Hz)")
    sizes = spectrum.max("freedom").to_numpy()[1:]  # nothing larger than a thousandth of the largest follows
    heard = np.flatnonzero(sizes > 1e-3 * sizes.max())
    axes.set_xlim(0, float(frequency[min(len(frequency) - 1, 2 + int(heard[-1]))] if len(heard) else frequency[-1]))
    return figure


def _units(result: Result) -> list[tuple[str, float, bool]]:
    """Unit and factor that each freedom is drawn in, and whether it is an angle."""
    efforts = effort_units(tuple(result.scene.freedoms), result.scene.joints)
    return [(*SHOWN[effort], effort == "N m") for effort in efforts]
