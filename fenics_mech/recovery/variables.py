"""Names of a result's variables: what each means, and its unit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import xarray as xr

from fenics_mech.accuracy.frequencies import FREQUENCY
from fenics_mech.scene.springs_dampers import Damper, Hinge, Spring

ATTRIBUTES = {
    "strain": ("1", "strain of the outer fibre, as a gauge measures it"),
    "strain_error": ("1", "error of the member's strain by each source, estimated"),
    "deflection_error": ("m", "error of the member's deflection by each source, estimated"),
    "joint_force_error": ("N", "error of the joint's force by each source, estimated"),
    "drive_effort_error": ("N m", "error of each drive's effort by each source, estimated; N along a slide"),
    "point_acceleration_error": (
        "m/s^2",
        "error of the point's largest acceleration on links that do not bend, by positions; NaN of other sources",
    ),
    "point_acceleration_bent_error": (
        "m/s^2",
        "error of the point's largest acceleration on bent links, by positions; NaN of other sources",
    ),
    "point_acceleration_relative_error": (
        "1",
        "largest error of an acceleration on links that do not bend, by positions, over the largest of all",
    ),
    "point_acceleration_bent_relative_error": (
        "1",
        "largest error of an acceleration on bent links, by positions, over the largest of all",
    ),
    "relative_error": ("1", "largest error of a strain by each source, over the member's largest strain"),
    "deflection_relative_error": (
        "1",
        "largest error of a deflection by each source, over the member's largest deflection",
    ),
    "joint_force_relative_error": ("1", "largest error of a joint force by each source, over the largest of all"),
    "drive_effort_relative_error": ("1", "largest error of an effort by each source, over the largest effort"),
    "error_order": ("1", "expected convergence order of the error, in the number of steps, elements, modes and so on"),
    "strain_axial": ("1", "axial strain"),
    "strain_bending": ("1", "bending strain of the outer fibre"),
    "strain_quasi_static": ("1", "strain of the outer fibre without vibration, in linear theory"),
    "stress": (
        "Pa",
        "stress of the outer fibre; modulus times strain, and what damping by `ratio` or `material` adds by the rate",
    ),
    "stress_quasi_static": ("Pa", "stress of the outer fibre without vibration, in linear theory"),
    "case_stress": ("Pa", "largest stress of the member in each load case"),
    "case_strain": ("1", "largest strain of the member in each load case"),
    "case_deflection": ("m", "largest deflection of the member in each load case"),
    "case_safety": ("1", "least factor of safety of the member over the wanted one in each load case, of what decides"),
    "case_joint_force": ("N", "largest force of the joint in each load case"),
    "case_effort": ("N m", "largest effort of each drive in each load case; N along a slide"),
    "position": ("m", "place of the member's end in the rigid linkage, fixed frame"),
    "link_position": ("m", "place of the link's origin in the rigid linkage, fixed frame"),
    "link_angle": ("rad", "angle of the link's axes in the rigid linkage, not wrapped"),
    "stress_range": ("Pa", "stress range of the outer fibre over the cycle, from the least to the largest"),
    "stress_mean": ("Pa", "half of the sum of the least and the largest stress of the cycle"),
    "stress_ratio": ("1", "least over largest stress of the cycle; -1 where it alternates"),
    "utilisation": ("1", "largest stress over the strength, of all materials of the member"),
    "moment": ("N m", "bending moment"),
    "axial_force": ("N", "axial force, tension positive"),
    "shear_force": ("N", "shear force dM/ds"),
    "deflection": ("m", "elastic displacement, fixed frame"),
    "link_omega": ("rad/s", "angular velocity of the link"),
    "link_alpha": ("rad/s^2", "angular acceleration of the link"),
    "instant_centre": ("m", "point at which the link turns about the ground; none where it does not turn"),
    "point_position": ("m", "position of the point of a link that does not bend, fixed frame"),
    "point_velocity": ("m/s", "velocity of the point of a link that does not bend"),
    "point_acceleration": ("m/s^2", "acceleration of the point of a link that does not bend"),
    "point_position_bent": ("m", "position of the point of the bent link, fixed frame"),
    "point_velocity_bent": ("m/s", "velocity of the point of the bent link"),
    "point_acceleration_bent": ("m/s^2", "acceleration of the point of the bent link"),
    "slide_place": ("m", "distance of the pin along its guide from the guide's point"),
    "transmission_angle": (
        "rad",
        "transmission angle of the links at the joint; pi/2 less the pressure angle",
    ),
    "joint_force": ("N", "force of the joint's first body on its second, fixed frame"),
    "joint_moment": ("N m", "moment of the first body of a weld or slide on its second"),
    "support_force": ("N", "force of the mechanism on the frame at the support, fixed frame"),
    "support_moment": ("N m", "couple of the mechanism on the frame at the support"),
    "shaking_force": ("N", "force of the mechanism on the frame, fixed frame"),
    "shaking_moment": ("N m", "moment of the mechanism on the frame about the origin of the ground"),
    "input_torque": ("N m", "torque of the first drive on the second body of its joint; its force where it slides"),
    "drive_effort": ("N m", "torque of each drive on the second body of its joint; its force where it slides"),
    "drive_effort_rms": ("N m", "root mean square of the drive's effort over the cycle; N along a slide"),
    "freedom_place": ("rad", "angle of each freedom; m where it slides"),
    "freedom_rate": ("rad/s", "rate of each freedom; m/s where it slides"),
    "last_turn_rate": ("rad/s", "mean rate of each freedom that turns, over its last turn"),
    "last_turn_fluctuation": ("1", "range of that rate over its mean"),
    "electrical_power": ("W", "what each motor takes: its torque times the speed at which it has none"),
    "section_place": ("rad", "angle of each freedom in the Poincaré section; m where it slides"),
    "section_rate": ("rad/s", "rate of each freedom in the Poincaré section; m/s where it slides"),
    "section_time": ("s", "time of the point of the Poincaré section"),
    "lyapunov_exponent": ("1/s", "Lyapunov exponent over the second half of the motion, largest first"),
    "lyapunov_change": ("1/s", "by how much it differs between the third and the last quarter of the motion"),
    "disturbance_growth": ("1", "natural logarithm of what the disturbance has grown by since the start"),
    "rest_frequency": ("Hz", "frequency of each small motion about the equilibrium; 0 where it does not oscillate"),
    "rest_decay": ("1/s", "rate at which that motion decays; it grows where negative"),
    "rest_lowest": ("rad", "least place from which on friction holds the freedom; m where it slides"),
    "rest_highest": ("rad", "largest place up to which friction holds the freedom; m where it slides"),
    "friction_used": ("1", "what each friction at rest takes, over the most that it can"),
    "freedom_place_error": ("rad", "error of each freedom's angle or stroke by each source, estimated"),
    "freedom_place_relative_error": ("1", "largest error of a freedom by each source, over the largest of all"),
    "law_effort": (
        "N m",
        "what each joint law exerts: force (N) along the guide or moment (N m) on the second body; the size of its "
        "force where it takes the place of a pin",
    ),
    "largest_law_effort": ("N m", "largest size of that in the whole motion, between the positions too"),
    "indentation": ("m", "how far bodies are in each other at each contact, negative where they do not touch; or rad"),
    "mean_power": ("W", "mean power that the cause gives to the mechanism, negative where it takes"),
    "drive_impulse": ("N m s", "impulse of each drive's effort at each impulse; N s along a slide"),
    "drive_twist": ("rad", "angle of the crank ahead of its drive"),
    "drive_rate": ("rad/s", "rate of the crank"),
    "spring_force": ("N", "tension of each spring; of one at a joint the moment with which it turns its bodies back"),
    "damper_force": ("N", "tension of each damper; of one at a joint the moment with which it turns its bodies back"),
    "frequency": ("Hz", "natural frequency"),
    "frequency_across": ("Hz", "natural frequency across the plane, held at each position"),
    "multiplier_across": ("1", "Floquet multiplier of a motion across the plane, largest magnitude first"),
    "position_angle": ("rad", "drive angle at which frequencies across the plane are"),
    "frequency_error": (
        "1",
        "relative error of the frequency by the mesh, but for pins that travel; "
        f"{FREQUENCY.largest_known:g}: that or more",
    ),
    "mode_frequency": (
        "Hz",
        "natural frequency over the cycle, held at each position: lowest, mean and highest; running: its mean about "
        "the motion, with spin and axial forces",
    ),
    "mode_damping": ("1", "damping ratio of the mode, its mean over the cycle"),
    "mode_share": ("1", "share of each link in the mode, by mass"),
    "mode_group": ("1", "first of the modes that turn into this one over the cycle, as they veer; or itself"),
    "critical_speed": ("rad/s", "rate of the drive's cycle at which the harmonic meets the mode"),
    "critical_order": ("1", "multiple of the drive's rate that meets the mode there"),
    "critical_share": (
        "1",
        "amplitude of the strain that the harmonic makes on the mode at rest, over the peak strain without vibration",
    ),
    "euler_ratio": ("1", "largest axial force over the Euler load of the member on two pins"),
    "bow": ("1", "largest distance of the member's axis from its chord, over its length"),
    "rotation": ("rad", "largest rotation of the member's axis from its rigid position"),
    "multiplier": ("1", "Floquet multiplier: factor on a small disturbance in a cycle, largest magnitude first"),
    "growth_rate": ("1/s", "rate at which the disturbance grows; it decays where negative"),
    "multiplier_frequency": (
        "Hz",
        "frequency of the disturbance in the axes of its link; NaN where only rounding is left of it",
    ),
    "multiplier_link": ("1", "link that has the largest part of the disturbance, by mass"),
    "multiplier_mode": ("1", "mode that has the largest part of the disturbance"),
    "largest_strain": ("1", "largest strain of the member, at stations and where it may have a peak between them"),
    "state": ("1", "displacement (m, rad) and velocity of the coordinates at the end, from which to go on"),
    "assurance": ("1", "MAC of each mode with itself at the next position"),
    "harmonic_frequency": ("Hz", "frequency of the harmonic"),
    "gauge_s": ("1", "place of the gauge along the member"),
    "gauge_fibre": ("1", "fibre of the gauge"),
    "strain_amplitude": ("1", "amplitude of the strain's harmonic; order 0 is its mean"),
    "strain_phase": ("rad", "phase of the strain's harmonic, a cosine of the time since drive angle 0"),
    "joint_force_amplitude": ("N", "amplitude of the joint force's harmonic; order 0 is its mean"),
    "joint_force_phase": ("rad", "phase of the joint force's harmonic, a cosine of the time since drive angle 0"),
    "input_torque_amplitude": ("N m", "amplitude of the input torque's harmonic; order 0 is its mean"),
    "input_torque_phase": ("rad", "phase of the input torque's harmonic, a cosine of the time since drive angle 0"),
    "residual_vibration": ("m", "half of the range of the member's deflection in the dwell, where that is largest"),
    "vibration_amplitude": ("1", "half of the range of the strain at mid-span about its quasi-static curve"),
    "vibration_frequency": (
        "Hz",
        "ripples about the quasi-static curve in a second, where a natural frequency is near",
    ),
    "vibration_harmonic": ("1", "largest harmonic of the strain's distance from its quasi-static curve"),
    "vibration_mode": ("1", "mode whose natural frequency is nearest to the vibration's"),
}

STRAINS = (  # of the variables of unit 1 those that are told in units of strain
    "strain",
    "strain_axial",
    "strain_bending",
    "strain_quasi_static",
    "strain_error",
    "largest_strain",
    "strain_amplitude",
    "vibration_amplitude",
    "case_strain",
)


def with_units(
    data: xr.Dataset, efforts: Sequence[str], springs: Iterable[Spring], dampers: Iterable[Damper]
) -> xr.Dataset:
    """Say of every variable what it means, in ``attrs["long_name"]``, and its unit, in ``attrs["units"]``.

    Parameters
    ----------
    data
        A result; the attributes are added in place.
    efforts
        Unit of each drive's effort.
    springs, dampers
        Those that the result has forces of.
    """
    units = _units(efforts, springs, dampers)
    for name, (unit, meaning) in ATTRIBUTES.items():
        if name in data:
            data.variables[name].attrs.update(units=units.get(name, unit), long_name=meaning)
    data.variables["theta"].attrs.update(units="rad", long_name="drive angle")
    data.variables["time"].attrs.update(units="s", long_name="time")
    if "s" in data:
        data.variables["s"].attrs.update(
            units="1", long_name="place along the member, from its first to its second end"
        )
    return data


def _units(efforts: Sequence[str], springs: Iterable[Spring], dampers: Iterable[Damper]) -> dict[str, str]:
    """Give the units of variables that hold forces or moments by the scene; one for each where these are mixed."""
    found = {"input_torque": efforts[:1], "input_torque_amplitude": efforts[:1]}
    found |= dict.fromkeys(("drive_effort", "drive_effort_error", "drive_effort_rms"), efforts)
    found["drive_impulse"] = [f"{unit} s" for unit in efforts]
    for name, parts in (("spring_force", springs), ("damper_force", dampers)):
        found[name] = ["N m" if isinstance(part, Hinge) else "N" for part in parts]
    return {name: units[0] if len(set(units)) == 1 else ", ".join(units) for name, units in found.items() if units}
