"""The error that a result tells of each of its variables, relative to the largest value of that variable."""

from typing import Any

import numpy as np

from fenics_mech.estimate.quantities import ERROR_VARIABLES

EXACT = 2e-8  # of what follows from closed loops alone: they are closed to 1e-12, and numbers kept to 2^-27 = 7e-9
MEASURED_BY = {  # the quantity of whose error a variable has the same share
    "strain": (
        *("strain_axial", "strain_bending", "strain_quasi_static", "strain_cosine", "strain_sine", "largest_strain"),
        *("stress", "stress_quasi_static", "stress_range", "stress_mean", "stress_ratio", "utilisation", "moment"),
    ),
    "deflection": ("bow", "rotation", "residual_vibration"),
    "joint_force": (
        *("axial_force", "shear_force", "euler_ratio", "joint_moment", "joint_force_cosine", "joint_force_sine"),
        *("support_force", "support_moment", "shaking_force", "shaking_moment", "spring_force", "damper_force"),
    ),
    "torque": (
        *("input_torque", "input_torque_cosine", "input_torque_sine", "drive_effort_rms", "drive_impulse"),
        "attrs.energy_fluctuation",
    ),
}
QUANTITY_OF = {variable: quantity for quantity, variables in MEASURED_BY.items() for variable in variables}
OF_THE_RIGID_MOTION = (
    *("theta", "time", "s", "mode", "harmonic", "harmonic_frequency", "disturbance", "position", "link_position"),
    *("link_angle", "link_omega", "link_alpha", "instant_centre", "point_position", "point_velocity", "slide_place"),
    *("point_acceleration", "transmission_angle", "attrs.mobility", "attrs.elements", "attrs.too_coarse"),
)
Numbers = dict[str, np.ndarray]


def told(numbers: Numbers, texts: dict[str, Any], variable: str, largest: float) -> float:
    """Give the told error of a variable over its largest value, by all sources: numerical ones, and the theory.

    NaN where the result says that it does not estimate it.
    """
    shares = {what: by_sources(numbers, f"{prefix}relative_error") for what, (_, prefix, _) in ERROR_VARIABLES.items()}
    shares["freedom"] = by_sources(numbers, "freedom_place_relative_error")
    known = [share for share in shares.values() if share is not None]
    any_of_them = max(known, default=np.nan if "not_estimated" in texts else 0.0)
    if variable in OF_THE_RIGID_MOTION:
        if "freedom_place" not in numbers and "drive_twist" not in numbers:
            return EXACT
        return EXACT + (any_of_them if shares["freedom"] is None else shares["freedom"])
    if variable.endswith("_bent") and variable.removesuffix("_bent") in numbers:  # what bending adds has the error
        added = np.nan_to_num(np.abs(numbers[variable] - numbers[variable.removesuffix("_bent")])).max(initial=0.0)
        of_bending = any_of_them if shares["deflection"] is None else shares["deflection"]
        return EXACT + of_bending * float(added) / (largest or 1.0)
    if variable == "frequency" and "frequency_error" in numbers:
        held = 0.0 if "freedom_place" not in numbers else any_of_them  # at positions that are found
        return EXACT + float(numbers["frequency_error"].max(initial=0.0)) + held
    if variable in [name for name, *_ in ERROR_VARIABLES.values()] and f"{variable}_error" in numbers:
        error = float(np.nansum(numbers[f"{variable}_error"], axis=0).max(initial=0.0))
        return EXACT + error / (largest or 1.0)
    share = shares.get(QUANTITY_OF.get(variable, ""))
    return EXACT + (any_of_them if share is None else share)


def by_sources(numbers: Numbers, name: str) -> float | None:
    """Give the sum of a relative error's sources; None where it is not told."""
    return float(np.nansum(numbers[name])) if name in numbers else None
