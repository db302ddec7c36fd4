"""What planar machines do across their plane: frequencies, multipliers, and lateral buckling."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.answers.in_space import UNSTABLE, InSpace, answer_in_space
from fenics_mech.errors import SceneError, UnstableError
from fenics_mech.machine.lifted import lifted
from fenics_mech.recovery.variables import ATTRIBUTES
from fenics_mech.scene import Scene
from fenics_mech.solve import frequencies, held_modes, tangents_at

POSITIONS = 60  # of a cycle, at most: frequencies across the plane vary as slowly as those in it
COUNT = 6  # frequencies and multipliers of both kinds, of which those across are kept


def across_the_plane(scene: Scene) -> xr.Dataset:
    """Give the frequencies and multipliers of a planar machine whose links also bend across its plane, and twist.

    Small motions across the plane do not change those in it, so that each mode is of one kind.

    Parameters
    ----------
    scene
        The scene.

    Raises
    ------
    SceneError
        When it cannot be stated in space; see `lifted`.
    UnstableError
        When the machine buckles across its plane.
    """
    if scene.analysis.method == "transient":
        raise SceneError(
            "a motion in time has no frequencies and multipliers across the plane",
            place="analysis.out_of_plane",
            hint="Leave it out, or take another method",
        )
    count = min(scene.analysis.sub_intervals, POSITIONS)
    answer = answer_in_space(lifted(scene).changed({"analysis.positions": max(count, 8)}))
    across = _across(answer)
    rates = np.array([_rates_across(answer, k, across) for k in range(len(answer.motion.t))])
    if (rates.real > 1e-6 * np.abs(rates).max()).any():
        k = int(np.argmax(rates.real.max(axis=1)))
        angle = np.degrees(scene.cycle_rate * answer.motion.t[k])
        raise UnstableError(
            f"the machine buckles across its plane at drive angle {angle:.6g} deg. Lower loads or speed, or take "
            "members that are wider across the plane"
        )
    found: dict[str, Any] = {"frequency_across": (("position_angle", "mode_across"), np.abs(rates.imag) / TURN)}
    if answer.cycle is not None:
        values, states = answer.cycle.steps.multipliers(4 * COUNT)
        n = answer.made.machine.n
        share = _share(states[:n], across)
        own = np.abs(values[share > 0.5])[:COUNT]
        found["multiplier_across"] = (("disturbance_across",), own)
        if len(own) and own.max() > UNSTABLE and not scene.analysis.allow_unstable:
            raise UnstableError(
                f"the periodic motion is unstable across the plane: a small disturbance grows by a factor of "
                f"{own.max():.5g} in every cycle. Take members that are wider across it, or another speed"
            )
    labels = {"position_angle": answer.motion.t * answer.made.scene.cycle_rate}
    data = xr.Dataset(found, labels)
    for name in data.variables:
        unit, meaning = ATTRIBUTES[str(name)]
        data.variables[name].attrs.update(units=unit, long_name=meaning)
    return data


def _across(answer: InSpace) -> Array:
    """Say which coordinates are across the plane: places along Z, and turns about X and Y."""
    machine = answer.made.machine
    mask = np.zeros(machine.size + 1, dtype=bool)
    mask[machine.places[:, 2:5]] = True
    return mask[:-1]


def _share(shapes: Array, across: Array) -> Array:
    """Give the share of shapes ``(coordinates, shapes)`` that is across the plane."""
    squares = np.abs(shapes) ** 2
    return np.asarray(squares[across[: len(shapes)]].sum(axis=0) / squares.sum(axis=0))


def _rates_across(answer: InSpace, k: int, across: Array) -> NDArray[np.complex128]:
    """Give the slowest rates of modes across the plane at a position (1/s), `COUNT` of them.

    At rest and in a quasi-static answer they are those about the loaded equilibrium, else of the unloaded machine.
    """
    machine, motion = answer.made.machine, answer.motion
    if answer.cycle is None:
        M, _, K = tangents_at(machine, motion.q[k], motion.a[k], float(motion.t[k]), moving=False)
        rates, shapes = frequencies(M, None, K, 3 * COUNT)
    else:
        omega, shapes = held_modes(machine, float(motion.t[k]))
        rates = 1j * omega  # type: ignore[assignment]
    own = np.asarray(rates, dtype=complex)[_share(shapes[: machine.n], across) > 0.5][:COUNT]
    return np.pad(own, (0, COUNT - len(own)), constant_values=np.nan)
