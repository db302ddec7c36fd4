"""Quantities that follow from a result and are computed when they are asked for: they cost an analysis nothing."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, turned
from fenics_mech.errors import ResultError
from fenics_mech.joints.link_states import quarter
from fenics_mech.recovery.rigid_places import bent_axes
from fenics_mech.scene import Scene
from fenics_mech.scene.sections.plain import ISection, PlainSection

LEAST_SAMPLES = 16  # positions, for a spectrum
LINES = 41  # in a section, at which stresses are compared
INSIDE = 1 - 1e-9  # of the distance of an I's flange, which is in its web
Combine = Callable[[Array, Array], Array]  # of normal and shear stress
PARALLEL = 1e-9  # share of the fastest link's rate below which two links turn at the same rate


def derived(name: str, data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Give a quantity that follows from those of a result."""
    if name not in DERIVED:
        raise ResultError(f"no quantity {name!r} can be derived; there are {', '.join(DERIVED)}")
    needed, meaning, unit, make = DERIVED[name]
    if lacking := [variable for variable in needed if variable not in data]:
        raise ResultError(f"{name} needs {' and '.join(lacking)}, which the result does not have")
    found = make(data, scene)
    return found.assign_attrs(units=unit, long_name=meaning).rename(name)


def _in_link(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Turn deflections into the axes of the members' links."""
    bent = data["deflection"].transpose("theta", "member", "s", "component")
    of_member = [scene.members()[str(member)][0] for member in data["member"].to_numpy()]
    angle = data["link_angle"].sel(link=of_member).transpose("theta", "link").to_numpy()[..., None]
    labels = {name: bent[name] for name in ("theta", "member", "s")}
    return xr.DataArray(
        turned(bent.to_numpy(), -angle), labels | {"axis": ["x", "y"]}, ("theta", "member", "s", "axis")
    )


def _from_chord(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Distance of bent axes from the line between their ends."""
    path = bent_axes(data)
    chord = path[:, :, -1] - path[:, :, 0]
    normal = quarter(chord / np.linalg.norm(chord, axis=-1, keepdims=True))
    apart = np.einsum("tmsc,tmc->tms", path - path[:, :, :1], normal)
    along = ("theta", "member", "s")
    return xr.DataArray(apart, {name: data[name] for name in along}, along)


def _relative_centres(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Points at which two links have the same velocity; NaN where they turn at the same rate."""
    # With u = v - w k x r of any point r of a link, both have the velocity u + w k x c at c. So ``c = k x (u_2 -
    # u_1)/(w_2 - w_1)``. The three centres of three links lie on a line (Aronhold and Kennedy).
    links = [str(link) for link in data["link"].to_numpy()]
    points = [f"{link}.{next(iter(scene.links[link].points))}" for link in links]
    place, velocity = (
        data[name].sel(point=points).transpose("theta", "point", "component").to_numpy()
        for name in ("point_position", "point_velocity")
    )
    omega = data["link_omega"].sel(link=links).transpose("theta", "link").to_numpy()
    at_origin = velocity - omega[..., None] * quarter(place)
    first, second = np.array([*combinations(range(len(links)), 2)], dtype=int).reshape(-1, 2).T
    turn = omega[:, second] - omega[:, first]
    turns = np.abs(turn) > PARALLEL * np.abs(omega).max(initial=0.0)
    centres = quarter(at_origin[:, second] - at_origin[:, first]) / np.where(turns, turn, np.nan)[..., None]
    names = [f"{links[i]}, {links[j]}" for i, j in zip(first, second)]
    labels = {"theta": data["theta"], "linked": names, "component": ["x", "y"]}
    return xr.DataArray(centres, labels, ("theta", "linked", "component"))


def _spectrum(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Amplitudes of the freedoms' rates by frequency; the mean has frequency 0."""
    # A vibration between two frequencies has up to 15 % less. Source: Harris, Proc. IEEE 66 (1978), p. 51.
    rates = data["freedom_rate"].transpose("theta", "freedom").to_numpy()[:-1]
    if len(rates) < LEAST_SAMPLES:
        raise ResultError(f"a spectrum needs {LEAST_SAMPLES} positions, and the result has {len(rates) + 1}")
    mean, window = rates.mean(axis=0), np.hanning(len(rates) + 1)[:-1, None]
    size = np.abs(np.fft.rfft((rates - mean) * window, axis=0)) * 2 / window.sum()
    size[0] = np.abs(mean)
    step = float(np.ptp(data["time"].to_numpy())) / len(rates)
    labels = {"spectrum_frequency": np.fft.rfftfreq(len(rates), step), "freedom": data["freedom"]}
    return xr.DataArray(size, labels, ("spectrum_frequency", "freedom"))


def _off_the_place(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Distance of points of the bent linkage from those of the rigid one."""
    rigid, bent = (data[f"point_position{end}"].transpose("theta", "point", "component") for end in ("", "_bent"))
    away = np.linalg.norm(bent.to_numpy() - rigid.to_numpy(), axis=-1)
    return xr.DataArray(away, {name: rigid[name] for name in ("theta", "point")}, ("theta", "point"))


def shear_stress(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Give the largest shear stress in each section (Pa), with the shear force's sign, over theta, member and s."""
    # It is ``Q S/(I b)`` of Zhuravskii. Sections whose shape is not known, of several materials or with tapers have
    # none.
    return _by_member(data, scene, lambda normal, shear: shear.max(axis=-1) + shear.min(axis=-1))  # one of them is 0


def von_mises(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Give the largest von Mises stress of any line in each section (Pa), over theta, member and s."""
    # It is ``sqrt(sigma^2 + 3 tau^2)``, sigma linear between the outer fibres. It is known where `shear_stress` is.
    return _by_member(data, scene, lambda normal, shear: np.sqrt(normal**2 + 3 * shear**2).max(axis=-1))


def _by_member(data: xr.Dataset, scene: Scene, combined: Combine) -> xr.DataArray:
    """Combine normal and shear stress at lines of each member's section, ``(angles, stations, lines)``."""
    force = data["shear_force"].transpose("theta", "member", "s")
    stress = data["stress"].sel(fibre=["+", "-"]).transpose("theta", "member", "s", "fibre").to_numpy()
    found = np.full(force.shape, np.nan)
    for i, label in enumerate(force["member"].to_numpy()):
        section = scene.sections[scene.members()[str(label)][1].section]
        if not isinstance(section, PlainSection):
            continue
        y = _lines(section)
        if (over := section.moment_over_breadth(y)) is None:
            continue
        share = y / section.fibre
        normal = ((1 + share) * stress[:, i, :, :1] + (1 - share) * stress[:, i, :, 1:]) / 2
        shear = force.to_numpy()[:, i, :, None] * over / section.inertia
        found[:, i] = combined(normal, shear)
    return force.copy(data=found).drop_attrs()


def _lines(section: PlainSection) -> Array:
    """Distances from the neutral line (m) at which a section's stresses are compared: ends, middle, and joints."""
    y = np.linspace(-section.fibre, section.fibre, LINES)
    if isinstance(section, ISection):
        joint = INSIDE * (section.height / 2 - section.flange)
        y = np.concatenate([y, [-joint, joint]])
    return y


Make = Callable[[xr.Dataset, Scene], xr.DataArray]
DERIVED: dict[str, tuple[tuple[str, ...], str, str, Make]] = {  # by name: what it needs, meaning, unit, what makes it
    "deflection_in_link": (
        ("deflection", "link_angle"),
        "elastic displacement, axes of the member's link",
        "m",
        _in_link,
    ),
    "deflection_from_chord": (
        ("deflection", "position"),
        "distance of the bent axis from the line between its ends, on the side of the normal",
        "m",
        _from_chord,
    ),
    "relative_centre": (
        ("point_position", "point_velocity", "link_omega"),
        "point at which both links have the same velocity; none where they turn at the same rate",
        "m",
        _relative_centres,
    ),
    "freedom_spectrum": (
        ("freedom_rate", "time"),
        "amplitude of the freedom's rate by frequency; m/s where it slides",
        "rad/s",
        _spectrum,
    ),
    "shear_stress": (
        ("stress", "shear_force"),
        "largest shear stress in the section; none where its shape is not known",
        "Pa",
        shear_stress,
    ),
    "von_mises": (
        ("stress", "shear_force"),
        "largest von Mises stress in the section; none where its shape is not known",
        "Pa",
        von_mises,
    ),
    "positioning_error": (
        ("point_position", "point_position_bent"),
        "distance of the point from its place in the rigid linkage",
        "m",
        _off_the_place,
    ),
}
