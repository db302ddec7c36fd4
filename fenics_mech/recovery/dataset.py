"""Putting everything that was computed into one labelled dataset."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.accuracy.estimate import Errors
from fenics_mech.accuracy.frequency_errors import frequency_error
from fenics_mech.accuracy.quantities import ERROR_VARIABLES
from fenics_mech.effects.effect import Choice
from fenics_mech.eigenmodes import Modes
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.mechanism import System
from fenics_mech.recovery.balance import drive_figures, energy_balance
from fenics_mech.recovery.fields import Fields
from fenics_mech.recovery.frame_forces import frame_forces
from fenics_mech.recovery.law_efforts import law_efforts, with_law_units
from fenics_mech.recovery.link_motion import link_motion
from fenics_mech.recovery.mode_speeds import mode_speeds
from fenics_mech.recovery.residual_vibration import residual_vibration
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.rigid_places import rigid_places
from fenics_mech.recovery.running import running
from fenics_mech.recovery.signal import last_cycle, of_cycle
from fenics_mech.recovery.stress_figures import stress_figures
from fenics_mech.recovery.variables import with_units
from fenics_mech.recovery.without_vibration import without_vibration
from fenics_mech.response.setup import CommonParts
from fenics_mech.response.solution import FreeSolution, InTime, MotorSolution, PeriodicSolution, Solution
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.response.transient.course import Course
from fenics_mech.scene.consistency import mobility

FRAME_FORCES = ("support_force", "support_moment", "shaking_force", "shaking_moment")


class DatasetParts(NamedTuple):
    """What a dataset is made of. To make one of several such parts takes less than to join datasets of them.

    Parameters
    ----------
    variables, coordinates, attributes
        As `xarray.Dataset` takes them.
    """

    variables: Mapping[str, Any]
    coordinates: Mapping[str, Any] = {}
    attributes: Mapping[str, Any] = {}

    @classmethod
    def of(cls, data: xr.Dataset) -> DatasetParts:
        """Give the parts of a dataset.

        Parameters
        ----------
        data
            The dataset.
        """
        variables, coordinates = (
            {str(name): data.variables[name] for name in names} for names in (data.data_vars, data.coords)
        )
        return cls(variables, coordinates, data.attrs)

    def dataset(self, *others: DatasetParts) -> xr.Dataset:
        """Make a dataset of this and other parts.

        Parameters
        ----------
        others
            The other parts. No two have a variable in common.
        """
        variables, coordinates, attributes = (dict[str, Any](part) for part in self)
        for part in others:
            variables.update(part.variables)
            coordinates.update(part.coordinates)
            attributes.update(part.attributes)
        return xr.Dataset(variables, coordinates, attributes)


def collect(
    solution: Solution,
    fields: Fields,
    errors: Errors | None,
    choices: Sequence[Choice] = (),
    names: Collection[str] | None = None,
    common: CommonParts | None = None,
) -> Result:
    """Label what was computed.

    Parameters
    ----------
    solution
        The response.
    fields
        Strains, stresses, forces and deflections that were recovered from it.
    errors
        Their estimated errors; None where they are not estimated.
    choices
        What was decided about effects.
    names
        Variables that are wanted, with those that come with them; None for all.
    common
        What it may have in common with other analyses of a study.
    """
    scene = solution.scene
    attributes = (
        stamp(scene)
        | {"mobility": mobility(scene)}
        | decisions(fields.system.size, len(fields.system.beams.mesh.cell), choices)
    )
    attributes |= {} if fields.joints is None else fields.joints.attributes
    parts = DatasetParts(fields.variables, fields.coordinates, attributes)
    forces = Forces(scene, fields.system, solution.response)
    if names is None or (few := _named(solution, fields, forces, names)) is None:
        data = _whole(parts.dataset(), solution, fields, forces, errors, common)
    else:
        data = parts.dataset(*few, *([] if errors is None else [of_errors(errors)]))
    units = effort_units(scene.moved_joints, scene.joints)
    data = with_law_units(scene, with_units(data, units, scene.springs.values(), scene.dampers.values()))
    return Result.with_scene(scene, data)


def _whole(
    data: xr.Dataset,
    solution: Solution,
    fields: Fields,
    forces: Forces,
    errors: Errors | None,
    common: CommonParts | None,
) -> xr.Dataset:
    """Add to the fields all else that is computed."""
    scene = solution.scene
    efforts = forces.efforts() if scene.moved_joints else {}
    of_kind, of_modes = _of_kind(solution, fields.system), mode_speeds(scene)
    if of_modes.sizes and (numbers := [part["mode"] for part in of_kind if "mode" in part]):
        of_modes = of_modes.reindex(mode=numbers[0])  # axial forces may hold what is a rigid body without them
    parts = (
        rigid_places(scene, fields.system.motion),
        _of_drives(solution, forces, efforts, errors),
        frame_forces(forces, fields, efforts),
        link_motion(forces),
        *of_kind,
        *([] if errors is None else [of_errors(errors).dataset()]),
        of_modes,
    )
    data = joined(data, *parts)
    data = joined(data, residual_vibration(scene, data))
    still = data.get("strain_quasi_static")
    cycle = last_cycle(scene.analysis, scene.drives, data)
    of_stress = stress_figures(scene, data, cycle)
    return joined(data, of_stress, *([] if cycle is None else [of_cycle(data, cycle, scene.period, still)]))


def _named(solution: Solution, fields: Fields, forces: Forces, names: Collection[str]) -> list[DatasetParts] | None:
    """Give variables that the fields do not hold; None where all are needed for them."""
    if solution.scene.analysis.method == "transient" or not solution.scene.moved_joints:
        return None
    efforts = cache(forces.efforts)
    makers: dict[tuple[str, ...], Callable[[], DatasetParts]] = {
        ("input_torque",): lambda: DatasetParts({"input_torque": (("theta",), next(iter(efforts().values())))}),
        FRAME_FORCES: lambda: DatasetParts.of(frame_forces(forces, fields, efforts())),
        ("frequency", "assurance"): lambda: DatasetParts({}),
        ("multiplier", "growth_rate"): lambda: DatasetParts({}),
    }
    if isinstance(solution, PeriodicSolution):
        modes, stability = solution.modes, solution.stability
        makers["frequency", "assurance"] = lambda: _of_modes(fields.system, modes)
        if stability is not None:
            makers["multiplier", "growth_rate"] = lambda: DatasetParts.of(of_stability(stability))
    missing = set(names) - set(fields.variables)
    if not missing <= {name for known in makers for name in known}:
        return None
    return [make() for known, make in makers.items() if not missing.isdisjoint(known)]


def joined(*parts: xr.Dataset) -> xr.Dataset:
    """Put datasets with the same labels together, without a look at whether these are the same."""
    return xr.merge(parts, combine_attrs="no_conflicts", compat="override", join="override")


def _of_drives(solution: Solution, forces: Forces, efforts: dict[str, Array], errors: Errors | None) -> xr.Dataset:
    """Efforts of the drives, the balance of energy, and the crank's own motion on a motor's shaft."""
    scene = solution.scene
    if not scene.moved_joints:
        return xr.Dataset()
    variables: dict[str, Any] = {
        "input_torque": (("theta",), efforts[scene.moved_joints[0]]),
        "drive_effort": (("theta", "drive"), np.stack(list(efforts.values()), axis=1)),
    }
    if isinstance(solution, MotorSolution):
        variables["drive_twist"] = (("theta",), solution.twist[0])
        variables["drive_rate"] = (("theta",), scene.cycle_rate + solution.twist[1])
    uncertain = (
        np.full(len(efforts), np.nan) if errors is None else np.sum(list(errors.errors["torque"].values()), axis=0)
    )
    found = xr.Dataset(variables, {"drive": list(efforts)})
    figures = drive_figures(solution, forces, efforts)
    balance = energy_balance(solution, forces, efforts, uncertain)
    return xr.merge([found, figures, balance], combine_attrs="no_conflicts")


def _of_kind(solution: Solution, system: System) -> list[xr.Dataset]:
    """What a response has by its kind: modes, stability and condition, or the end of a motion in time."""
    if isinstance(solution, InTime):
        return [_of_course(solution.course), *_of_freedoms(solution), _of_laws(solution)]
    if not isinstance(solution, PeriodicSolution):
        return []
    parts = [_of_modes(system, solution.modes).dataset(), without_vibration(solution)]
    if solution.stability is not None:
        parts.append(of_stability(solution.stability))
    if solution.condition is not None and np.isfinite(solution.condition):
        parts.append(xr.Dataset(attrs={"condition": solution.condition}))
    return parts


def of_errors(errors: Errors) -> DatasetParts:
    """Give errors by source of every quantity that the scene has, and the largest relative ones by all of them.

    Parameters
    ----------
    errors
        The errors.
    """
    variables: dict[str, Any] = {}
    attributes: dict[str, float | str] = {}
    for what, (name, prefix, places) in ERROR_VARIABLES.items():
        if what not in errors.errors or (what == "torque" and not errors.measure[what].size):  # nothing is driven
            continue
        variables[f"{name}_error"] = (("source", places), np.stack(list(errors.errors[what].values())))
        variables[f"{prefix}relative_error"] = (("source",), list(errors.relative(what).values()))
        attributes[f"{prefix}error_estimate"] = errors.total(what)
    sources = list(errors.order)
    variables["error_order"] = (("source",), [float(errors.order[source]) for source in sources])
    labels: dict[str, Any] = {"source": sources}
    if errors.missed is not None:
        variables |= errors.missed.of_points(sources)
        labels["point"] = list(errors.missed.points)
    attributes["too_coarse"] = int(errors.too_large)
    if errors.remarks:
        attributes["not_estimated"] = "; ".join(errors.remarks)
    return DatasetParts(variables, labels, attributes)


def _of_modes(system: System, modes: Modes) -> DatasetParts:
    """Natural frequencies, their error, and how well each mode was followed."""
    along = ("theta", "mode")
    return DatasetParts(
        {
            "frequency": (along, modes.frequency),
            "frequency_error": (("mode",), frequency_error(system, modes)),
            "assurance": (along, modes.assurance),
        },
        {"mode": np.arange(1, modes.frequency.shape[1] + 1)},
    )


def of_stability(stability: Stability) -> xr.Dataset:
    """Give Floquet multipliers and the frequency up to which they are resolved.

    Parameters
    ----------
    stability
        The multipliers.
    """
    limit, multipliers = {"stability_limit": stability.limit}, stability.multipliers
    if not len(multipliers):
        return xr.Dataset(attrs=limit)
    of_each = ("disturbance",)
    return xr.Dataset(
        {
            "multiplier": ((*of_each, "part"), np.stack([multipliers.real, multipliers.imag], axis=1)),
            "growth_rate": (of_each, stability.growth_rate),
            "multiplier_frequency": (of_each, stability.frequency),
            "multiplier_link": (of_each, list(stability.link)),
            "multiplier_mode": (of_each, stability.mode + 1),
        },
        {"disturbance": np.arange(1, len(multipliers) + 1), "part": ["real", "imaginary"]},
        limit,
    )


def _of_course(course: Course) -> xr.Dataset:
    """The state at the end of a motion in time, and how that motion came about."""
    state = np.stack([course.displacement[-1], course.velocity[-1]], axis=1)
    return xr.Dataset(
        {"state": (("dof", "derivative"), state)},
        attrs={
            "cycle_change": course.change,
            "time_steps": course.steps,
            "interpolation_error": course.interpolation,
        },
    )


def _of_freedoms(solution: InTime) -> list[xr.Dataset]:
    """Angles and strokes of the freedoms, and their rates."""
    if not isinstance(solution, FreeSolution) or not solution.scene.freedoms:
        return []
    course, freedoms = solution.course, list(solution.scene.freedoms)
    last, along = slice(-len(freedoms), None), ("theta", "freedom")
    states = {"freedom_place": course.displacement, "freedom_rate": course.velocity}
    variables = {name: (along, values[:, last]) for name, values in states.items()}
    of_turn = running(solution.scene, course.time, *(values[:, last] for values in states.values()))
    return [xr.Dataset(variables, {"freedom": freedoms}), of_turn]


def _of_laws(solution: InTime) -> xr.Dataset:
    """What joint laws exert."""
    if not isinstance(solution, FreeSolution) or solution.course.laws is None:
        return xr.Dataset()
    laws = solution.course.laws
    return law_efforts(laws.efforts, laws.depths, laws.largest, laws.contacts.closed)


def decisions(dofs: int, elements: int, choices: Sequence[Choice]) -> dict[str, object]:
    """Attributes that say what was decided; the effects as JSON: name, size if it was estimated, whether it acts."""
    effects = [{"name": c.effect.name, "size": c.size, "acts": c.acts, "lacking": c.missing} for c in choices]
    return {"dofs": dofs, "elements": elements, "effects": json.dumps(effects)}
