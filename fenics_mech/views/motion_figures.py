"""Figures of motions: what joint laws exert, orbits of loose pins, freedoms, Poincaré sections, spectrum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech._constants import MILLI
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.joint_laws import Bushing, Clearance
from fenics_mech.scene.joints import Revolute, effort_units
from fenics_mech.views.figures import COLOURS, SIZE, empty_figure, figure_of, finish, new_axes
from fenics_mech.views.plots import abscissa, mark_peak, over
from fenics_mech.views.reading import ForceReading, reading_of
from fenics_mech.views.words import short

MOST_LAWS = 6  # panels of a figure
COLUMNS = 3
BETWEEN = 0.01  # share by which the largest effort exceeds those at the positions, from which it is drawn
SHOWN = {"N m": ("deg", float(np.degrees(1.0))), "N": ("mm", MILLI)}  # unit of a freedom by that of its effort
ROW = 3.2  # inches
LEAST_SHOWN = 1e-5  # of the largest amplitude


@dataclass(frozen=True)
class LawEffort:
    """What a joint law exerts."""

    law: str  # its name; "cam:G" is the push of a cam on what it drives
    # joint, kind: its joint and its kind
    joint: str
    kind: str
    values: Array  # at the positions, in the unit of the answer, ``(positions,)``
    largest: float  # its largest size in the whole motion, between the positions too
    unit: str  # unit of these

    @property
    def between(self) -> bool:
        """Whether it is larger between the positions than at them."""
        return self.largest > (1 + BETWEEN) * float(np.abs(self.values).max())


def law_efforts(result: Result, units: AnswerUnits) -> list[LawEffort]:
    """Give what each joint law of a motion exerts; none where it has no joint laws."""
    if "law_effort" not in result.data:
        return []
    data, found = result.data, []
    in_si = str(data["largest_law_effort"].attrs["units"]).split(", ")
    values = data["law_effort"].transpose("law", "theta").to_numpy()
    names = [str(name) for name in data["law"].to_numpy()]
    for name, effort, largest, unit in zip(names, values, data["largest_law_effort"].to_numpy(), in_si * len(names)):
        stated, _, driven = name.partition(":")
        law, kind = result.scene.joint_laws[stated], "force" if unit == "N" else "moment"
        size = units.size(kind)
        found.append(
            LawEffort(name, driven or law.joint, law.kind, effort / size, float(largest) / size, units.label(kind))
        )
    return found


def law_figure(result: Result) -> Figure:
    """Draw what each joint law exerts over the motion, and dashed its largest size between the positions."""
    reading = reading_of(result)
    efforts = sorted(law_efforts(result, reading.units), key=lambda one: -one.largest)[:MOST_LAWS]
    figure, panels = empty_figure(len(efforts), 0.8 + 2.3 * len(efforts))
    for axes, one in zip(panels, efforts):
        k = int(np.abs(one.values).argmax())
        axes.plot(*over(reading, one.values), color=COLOURS[0], label="at the positions")
        mark_peak(axes, reading, k, float(one.values[k]))
        if one.between:
            sign = -1.0 if one.values[k] < 0 else 1.0
            text = f"largest between them: {short(one.largest)} {one.unit}"
            axes.axhline(sign * one.largest, color=COLOURS[1], linestyle="--", linewidth=1.1, label=text)
        what = "force" if one.unit == reading.units.label("force") else "moment"
        finish(axes, f"{one.law}: {one.kind} at joint {one.joint}", f"{what} ({one.unit})")
    abscissa(panels[-1], reading)
    return figure


def open_pins(result: Result) -> list[str]:
    """Names of the joint laws that leave a pin loose, in a motion that has the places of its points."""
    scene = result.scene
    known = "point_position" in result.data and result.data.sizes.get("theta", 1) > 1
    return [
        name
        for name, law in scene.joint_laws.items()
        if known and isinstance(law, Clearance | Bushing) and isinstance(scene.joints[law.joint], Revolute)
    ]


def plot_pin_orbit(result: Result, law: str, axes: Axes | None = None) -> Axes:
    """Plot the orbit of a loose pin: its second body's point about that of the first, in the fixed frame."""
    if law not in (known := open_pins(result)):
        raise ViewError(f"the result has no loose pin {law!r}; it has {', '.join(known) or 'none'}")
    axes, reading, scene = axes or new_axes(SIZE[0] * 0.75), reading_of(result), result.scene
    size, unit = reading.units.size("length"), reading.units.label("length")
    stated = scene.joint_laws[law]
    first, second = (_place_of(result, point) for point in scene.joints[stated.joint].connect[:2])
    apart = (second - first) / size
    axes.plot(*apart.T, color=COLOURS[0], linewidth=0.9)
    axes.plot(*apart[0], "o", color=COLOURS[0], markersize=5)
    title = f"Orbit of the pin of joint {stated.joint}"
    if isinstance(stated, Clearance):
        turn, radius = np.linspace(0, 2 * np.pi, 181), stated.radial / size
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color="#777777", linestyle="--", linewidth=1.0)
        title += f". Dashed: its clearance of {short(radius)} {unit}"
    axes.set_aspect("equal", adjustable="datalim")
    finish(axes, title, f"y ({unit})")
    axes.set_xlabel(f"x ({unit}), from the middle of the bearing")
    return axes


def orbit_figure(result: Result) -> Figure:
    """Draw the orbits of the loose pins."""
    pins = open_pins(result)[: 2 * COLUMNS]
    figure, panels = figure_of(len(pins), COLUMNS, 0.6, 0.9, 3.0)
    for axes, law in zip(panels, pins):
        plot_pin_orbit(result, law, axes)
        axes.set_title(axes.get_title("left").replace(". ", "\n"), fontsize=10, loc="left")
    return figure


def _place_of(result: Result, point: str) -> Array:
    """Places of a point over the motion (m), ``(positions, 2)``, of links that bend where they do."""
    body, here = result.scene.point(point)
    if body == "ground":
        return np.tile(here, (result.data.sizes["theta"], 1))
    name = "point_position_bent" if "point_position_bent" in result.data else "point_position"
    return np.asarray(result.data[name].sel(point=point).transpose("theta", "component").to_numpy())


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
