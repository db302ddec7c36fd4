"""What is said of motions with freedoms that repeat, and of those that do not."""

from __future__ import annotations

import numpy as np

from fenics_mech.errors import percent
from fenics_mech.recovery import Result
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.views.force_summary import shown
from fenics_mech.views.tables import number

CLEAR = 5.0  # natural logarithm of a growth in half of a motion, from which on neighbours part exponentially
STEADY = 0.5  # of an exponent, by which it may change between the last two quarters


def motion_rows(result: Result, units: AnswerUnits) -> dict[str, str]:
    """Give rows for the table of decisions: whether the motion repeats, how motions beside it part, what rings on."""
    rows, data = {}, result.data
    if "repeats_after" in data.attrs:
        kind = "a period of its own" if data.attrs["own_period"] else "the period of what acts"
        rows["repeats"] = (
            f"after {number(data.attrs['repeats_after'])} s, {kind}; it misses its start by "
            f"{percent(data.attrs['closing_error'])}"
        )
        rows["stability"] = _stability(result)
    if "lyapunov_exponent" in data:
        rows["disturbances"] = _exponents(result)
    if "residual_vibration" in data:
        sizes = data["residual_vibration"].transpose("dwell", "member").to_numpy()
        worst = [(str(data["member"][row.argmax()].item()), float(row.max())) for row in sizes]
        said = [
            f"{member} {shown(size, 'length', units)} {dwell}"
            for dwell, (member, size) in zip(data["dwell"].to_numpy(), worst)
        ]
        rows["swings on"] = ", ".join(said)
    if "section_time" in data:
        rows["section"] = f"{data.sizes['section_point']} points"
    return rows


def _stability(result: Result) -> str:
    """Tell what is left of a small disturbance after a cycle."""
    if "multiplier" not in result.data:
        return "not known, as bodies touch or rub"
    sizes = np.hypot(*result.data["multiplier"].transpose("part", "disturbance").to_numpy())
    values = result.data["multiplier"].transpose("disturbance", "part").to_numpy() @ [1.0, 1.0j]
    if result.data.attrs["own_period"]:  # one along the motion itself neither grows nor decays
        sizes = np.delete(sizes, int(np.abs(values - 1).argmin()))
    return f"{percent(float(sizes.max(initial=0.0)))} of a small disturbance is left after each cycle"


def _exponents(result: Result) -> str:
    """Tell the largest Lyapunov exponent, and whether the motion is chaotic."""
    largest, change = (float(result.data[name][0]) for name in ("lyapunov_exponent", "lyapunov_change"))
    half = float(np.ptp(result.data["time"].to_numpy())) / 2
    text = f"largest Lyapunov exponent {number(largest)} 1/s, which changes by {number(change)} 1/s between quarters"
    if largest * half > CLEAR and change < STEADY * largest:
        return f"{text}: the motion is CHAOTIC. After some {3 / largest:.2g} s only its statistics can be compared"
    if largest * half > CLEAR:
        return f"{text}: neighbours part, and a longer motion tells whether for ever"
    return f"{text}: no sign of chaos"
