"""Which quantities of a result are uncertain beside its strains, and by how much."""

from __future__ import annotations

from fenics_mech.accuracy.accepted_errors import ACCEPTED
from fenics_mech.accuracy.estimate import NUMERICAL
from fenics_mech.accuracy.missed_peaks import BETWEEN
from fenics_mech.accuracy.quantities import ERROR_VARIABLES
from fenics_mech.recovery import Result
from fenics_mech.scene.joints import effort_units
from fenics_mech.views.words import error_share


def beside_tolerance(result: Result) -> list[str]:
    """Say of the quantities that a tolerance does not name how large their errors are, where these are larger."""
    stated, data = result.scene.tolerances, result.data
    errors = {
        name: float(data.attrs[f"{ERROR_VARIABLES[what][1]}error_estimate"])
        for what, name in quantities(result).items()
        if what not in stated
    }
    most = max(stated.values(), default=1.0)
    beyond = [f"{name} {error_share(value)}" for name, value in errors.items() if value > most]
    return [f"The tolerance does not name what has larger errors: {', '.join(beyond)}."] if beyond else []


def quantities(result: Result) -> dict[str, str]:
    """Give the quantities of a result that have an error, and their names."""
    data = result.data
    names = {"strain": "strain", "deflection": "deflection"}
    if data.sizes["joint"]:
        names["joint_force"] = "joint force"
    if moved := result.scene.moved_joints:
        alone = effort_units(moved, result.scene.joints) == ["N m"]
        names["torque"] = "effort" if not result.scene.drives else "input torque" if alone else "drive effort"
    return {what: name for what, name in names.items() if f"{ERROR_VARIABLES[what][1]}error_estimate" in data.attrs}


def too_uncertain(result: Result) -> dict[str, float]:
    """Give the quantities beside the strain whose numerical error is too large, and that error."""
    data, found = result.data, {}
    numerical = [str(source) for source in data["source"].to_numpy() if source in (*NUMERICAL, BETWEEN)]
    for what, name in quantities(result).items():
        wrong = float(data[f"{ERROR_VARIABLES[what][1]}relative_error"].sel(source=numerical).sum())
        if what != "strain" and wrong > ACCEPTED.of_strain:
            found[name] = wrong
    return found
