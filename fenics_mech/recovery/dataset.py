"""Putting everything that was computed into one labelled dataset."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech.accuracy.estimate import Errors, estimated, not_estimated
from fenics_mech.accuracy.hidden_resonances import MOST_OFF, frequency_error
from fenics_mech.accuracy.quantities import ERROR_VARIABLES
from fenics_mech.accuracy.validity import bow, euler_ratio, refuse_far, rotation
from fenics_mech.effects import NOTHING
from fenics_mech.effects.dampers import damper_forces
from fenics_mech.effects.effect import Choice
from fenics_mech.effects.springs import spring_forces
from fenics_mech.forces.air import drag_known, left_out, unlinear
from fenics_mech.forces.element_loads import point_loads
from fenics_mech.forces.joint_forces import effort_units, joint_forces, nodal_forces, reactions
from fenics_mech.forces.section_forces import MemberState, recover_members, section_forces, stiffnesses
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.forces.viscous import elastic_strain, sampling_error
from fenics_mech.mechanism import System
from fenics_mech.modes import Modes
from fenics_mech.recovery.balance import energy_balance
from fenics_mech.recovery.peak_places import unseen
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.signal import of_cycle
from fenics_mech.response import History, solve_static
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.response.transient.integration import Course
from fenics_mech.scene import Scene
from fenics_mech.scene.springs_dampers import Hinge

ATTRIBUTES = {
    "strain": ("1", "strain of the outer fibre"),
    "strain_error": ("1", "error of the member's strain by each source, estimated"),
    "deflection_error": ("m", "error of the member's deflection by each source, estimated"),
    "joint_force_error": ("N", "error of the joint's force by each source, estimated"),
    "drive_effort_error": ("N m", "error of each drive's effort by each source, estimated; N along a slide"),
    "relative_error": ("1", "largest error of a strain by each source, over the member's largest strain"),
    "deflection_relative_error": (
        "1",
        "largest error of a deflection by each source, over the member's largest deflection",
    ),
    "joint_force_relative_error": ("1", "largest error of a joint force by each source, over the largest of all"),
    "drive_effort_relative_error": ("1", "largest error of an effort by each source, over the largest effort"),
    "error_order": ("1", "power of the number of steps, elements, modes and so on with which the error falls"),
    "strain_axial": ("1", "axial strain"),
    "strain_bending": ("1", "bending strain of the outer fibre"),
    "stress": ("Pa", "stress of the outer fibre"),
    "moment": ("N m", "bending moment"),
    "axial_force": ("N", "axial force, tension positive"),
    "shear_force": ("N", "shear force dM/ds"),
    "deflection": ("m", "elastic displacement, fixed frame"),
    "joint_force": ("N", "force of the joint's first body on its second, fixed frame"),
    "input_torque": ("N m", "torque of the first drive on the second body of its joint; its force where it slides"),
    "drive_effort": ("N m", "torque of each drive on the second body of its joint; its force where it slides"),
    "mean_power": ("W", "mean power that the cause gives to the mechanism, negative where it takes"),
    "drive_impulse": ("N m s", "impulse of each drive's effort at each impulse; N s along a slide"),
    "drive_twist": ("rad", "angle of the crank ahead of its drive"),
    "drive_rate": ("rad/s", "rate of the crank"),
    "spring_force": ("N", "tension of each spring; of one at a joint the moment with which it turns its bodies back"),
    "damper_force": ("N", "tension of each damper; of one at a joint the moment with which it turns its bodies back"),
    "frequency": ("Hz", "natural frequency"),
    "frequency_error": (
        "1",
        f"share by which the mesh has the frequency wrong, but for pins that travel; {MOST_OFF:g}: that or more",
    ),
    "euler_ratio": ("1", "largest axial force over the Euler load of the member on two pins"),
    "bow": ("1", "largest distance of the member's axis from its chord, over its length"),
    "rotation": ("rad", "largest rotation of the member's axis from its rigid position"),
    "multiplier": ("1", "Floquet multiplier: what a cycle makes of a small disturbance, largest magnitude first"),
    "growth_rate": ("1/s", "rate at which the disturbance grows; it decays where negative"),
    "multiplier_frequency": ("Hz", "frequency of the disturbance in the axes of its link, multiplier_link"),
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
    "vibration_amplitude": ("1", "half of the range of the strain at mid-span about its quasi-static curve"),
    "vibration_frequency": ("Hz", "ripples about the quasi-static curve in a cycle, over its duration"),
    "vibration_harmonic": ("1", "largest harmonic of the strain's distance from its quasi-static curve"),
    "vibration_mode": ("1", "mode whose natural frequency is nearest to the vibration's"),
}


def collect(
    scene: Scene, moving: System, history: History, modes: Modes | None, choices: Sequence[Choice] = ()
) -> Result:
    """Recover strains, forces and deflections of a history of a moving mechanism and label them."""
    neglected, system = left_out(scene, moving, history), drag_known(scene, moving, history)
    s = np.linspace(0, 1, scene.analysis.stations)
    members, elastic, found = _with_viscous_forces(system, history, s)
    by_joint = joint_forces(scene, found)
    variables: dict[str, Any] = _of_members(scene, members, elastic) | _of_springs(scene, system, history)
    forces = np.array(list(by_joint.values())).reshape(len(by_joint), len(system.motion.theta), 2)
    variables["joint_force"] = (("theta", "joint", "component"), np.moveaxis(forces, 0, 1))
    _, sampling = variables.pop("sampling_error", (None, None))
    strain, bent = variables["strain"][1], np.linalg.norm(variables["deflection"][1], axis=-1, keepdims=True)
    variables["largest_strain"] = (("member",), _largest(scene, system, history, strain))
    errors = estimated(scene, system, history, {"strain": strain, "deflection": bent}, sampling, choices)
    errors.judge(scene)
    refuse_far(scene, system, members)
    coordinates: dict[str, object] = {
        "theta": system.motion.theta,
        "time": ("theta", system.motion.time),
        "member": list(system.beams.mesh.members),
        "s": s,
        "fibre": ["+", "-"],
        "joint": list(by_joint),
        "component": ["x", "y"],
    }
    balance = xr.Dataset()
    if scene.drives:
        acting = Forces(scene, system, history)
        efforts = acting.efforts()
        balance = energy_balance(acting, efforts, np.sum(list(errors.errors["torque"].values()), axis=0))
        variables["input_torque"] = (("theta",), efforts[scene.drives[0].joint])
        variables["drive_effort"] = (("theta", "drive"), np.stack(list(efforts.values()), axis=1))
        coordinates["drive"] = list(efforts)
    if history.twist is not None:
        variables |= {
            "drive_twist": (("theta",), history.twist[0]),
            "drive_rate": (("theta",), scene.cycle_rate + history.twist[1]),
        }
    data = xr.Dataset(variables, coordinates, stamp(scene) | _decisions(system, choices))
    parts = (
        _of_modes(system, modes),
        _of_stability(history.stability),
        _of_course(history.course),
        _of_errors(errors),
        balance,
    )
    data = xr.merge([data, *parts], combine_attrs="no_conflicts")
    still = _quasi_static(scene, moving) if modes is not None else None
    data = xr.merge([data, of_cycle(scene, data, still)], combine_attrs="no_conflicts")
    if unknown := [*not_estimated(scene, history), *unlinear(neglected)]:
        data.attrs["not_estimated"] = "; ".join(unknown)
    if history.closed is not None and np.isfinite(history.closed.condition):
        data.attrs["condition"] = history.closed.condition
    units = _units(scene)
    for name, (unit, meaning) in ATTRIBUTES.items():
        if name in data:
            data[name].attrs.update(units=units.get(name, unit), long_name=meaning)
    data["theta"].attrs.update(units="rad", long_name="drive angle")
    data["time"].attrs.update(units="s", long_name="time")
    data["s"].attrs.update(units="1", long_name="place along the member, from its first to its second end")
    return Result(data)


def _units(scene: Scene) -> dict[str, str]:
    """Give the units of variables that hold forces or moments by the scene; one for each where these are mixed."""
    efforts = effort_units(scene)
    found = {"input_torque": efforts[:1], "input_torque_amplitude": efforts[:1]}
    found |= dict.fromkeys(("drive_effort", "drive_effort_error"), efforts)
    found["drive_impulse"] = [f"{unit} s" for unit in efforts]
    for name, parts in (("spring_force", scene.springs), ("damper_force", scene.dampers)):
        found[name] = ["N m" if isinstance(part, Hinge) else "N" for part in parts.values()]
    return {name: units[0] if len(set(units)) == 1 else ", ".join(units) for name, units in found.items() if units}


def _with_viscous_forces(
    system: System, history: History, s: np.ndarray
) -> tuple[MemberState, MemberState, dict[tuple[str, str, int], np.ndarray]]:
    """Members with the forces of modal damping and without them, and the joints' reactions with them."""
    found = reactions(system, nodal_forces(system, history.elastic))
    elastic = recover_members(system, history.elastic, s, point_loads(system, found))
    if history.damping is None:
        return elastic, elastic, found
    bare = replace(system, terms=NOTHING)
    viscous = reactions(bare, nodal_forces(bare, history.damping))
    members = elastic.with_forces(*section_forces(bare, history.damping, s, point_loads(bare, viscous)))
    return members, elastic, {key: force + viscous[key] for key, force in found.items()}


def _largest(scene: Scene, system: System, history: History, strain: np.ndarray) -> np.ndarray:
    """Largest strain of each member, at its stations and where it may have a peak between them, ``(members,)``."""
    found, places = np.abs(strain).max(axis=(0, 2, 3)), unseen(scene, system, history)
    if not len(places):
        return found
    members, elastic, _ = _with_viscous_forces(system, history, places)
    _, there = _of_members(scene, members, elastic)["strain"]
    return np.maximum(found, np.abs(there).max(axis=(0, 2, 3)))


def _of_errors(errors: Errors) -> xr.Dataset:
    """Errors by source of every quantity that the scene has, and the largest relative ones by all of them."""
    variables: dict[str, Any] = {}
    attributes: dict[str, float] = {}
    for what, (name, prefix, places) in ERROR_VARIABLES.items():
        if what == "torque" and not errors.measure[what].size:  # nothing is driven
            continue
        variables[f"{name}_error"] = (("source", places), np.stack(list(errors.errors[what].values())))
        variables[f"{prefix}relative_error"] = (("source",), list(errors.relative(what).values()))
        attributes[f"{prefix}error_estimate"] = errors.total(what)
    sources = list(errors.order)
    variables["error_order"] = (("source",), [float(errors.order[source]) for source in sources])
    return xr.Dataset(variables, {"source": sources}, attributes | {"too_coarse": int(errors.too_large)})


def _of_modes(system: System, modes: Modes | None) -> xr.Dataset:
    """Natural frequencies, their error, and how well each mode was followed."""
    if modes is None:
        return xr.Dataset()
    along = ("theta", "mode")
    return xr.Dataset(
        {
            "frequency": (along, modes.frequency),
            "frequency_error": (("mode",), frequency_error(system, modes)),
            "assurance": (along, modes.assurance),
        },
        {"mode": np.arange(1, modes.frequency.shape[1] + 1)},
    )


def _of_stability(stability: Stability | None) -> xr.Dataset:
    """Floquet multipliers, if there are some, and the frequency up to which they are resolved."""
    if stability is None:
        return xr.Dataset()
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


def _of_course(course: Course | None) -> xr.Dataset:
    """The state at the end of a motion in time, and how that motion came about."""
    if course is None:
        return xr.Dataset()
    state = np.stack([course.displacement[-1], course.velocity[-1]], axis=1)
    return xr.Dataset(
        {"state": (("dof", "derivative"), state)},
        attrs={
            "cycle_change": course.change,
            "time_steps": course.steps,
            "interpolation_error": course.interpolation,
        },
    )


def _quasi_static(scene: Scene, system: System) -> np.ndarray:
    """Quasi-static strain of the + fibre at mid-span in linear theory, ``(angles, members)``."""
    terms = replace(system.slack.terms, law=None, coupled=False)
    linear = replace(system, terms=terms)
    history = solve_static(linear, scene.petsc)
    found = reactions(linear, nodal_forces(linear, history))
    middle = np.array([0.5])
    axial, _, moment = section_forces(linear, history, middle, point_loads(linear, found))
    ea, ei, _, fibre = stiffnesses(scene, middle)
    return axial / ea[:, 0] - moment * fibre[:, 0, 0] / ei[:, 0]


def _decisions(system: System, choices: Sequence[Choice]) -> dict[str, object]:
    """Attributes that say what was decided; the effects as JSON: name, size if it was estimated, whether it acts."""
    effects = [{"name": c.effect.name, "size": c.size, "acts": c.acts, "lacking": c.lacking} for c in choices]
    return {"dofs": system.size, "elements": len(system.beams.mesh.cell), "effects": json.dumps(effects)}


def _of_springs(scene: Scene, system: System, history: History) -> dict[str, xr.DataArray]:
    """Forces of springs and dampers, where there are some."""
    mesh, motion, v = system.beams.mesh, system.motion, system.to_links(history.displacement)
    forces = {
        "spring": spring_forces(scene, mesh, motion, v),
        "damper": damper_forces(scene, mesh, motion, v, history.velocity),
    }
    return {
        f"{kind}_force": xr.DataArray(np.stack(list(found.values()), axis=1), {kind: list(found)}, ("theta", kind))
        for kind, found in forces.items()
        if found
    }


def _of_members(
    scene: Scene, members: MemberState, elastic: MemberState
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Strains, stresses, section forces and deflections of the members, with their dimensions.

    Parameters
    ----------
    scene
        The linkage.
    members, elastic
        The members' state, and that without the forces of modal damping, from which the strains are.
    """
    ea, ei, modulus, fibre = stiffnesses(scene, members.s)

    def over_modulus(state: MemberState) -> tuple[np.ndarray, np.ndarray]:
        return state.axial_force / ea, -state.moment[..., None] * fibre / ei[..., None]  # + fibre on the normal's side

    axial, bending = over_modulus(members)
    stress = modulus * (axial[..., None] + bending)
    whole = over_modulus(elastic)
    axial, bending = (elastic_strain(scene, part) for part in whole)
    strain = axial[..., None] + bending  # (6.38)
    along = ("theta", "member", "s")
    found: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
        "strain": ((*along, "fibre"), strain),
        "strain_axial": (along, axial),
        "strain_bending": ((*along, "fibre"), bending),
        "stress": ((*along, "fibre"), stress),
        "moment": (along, members.moment),
        "axial_force": (along, members.axial_force),
        "shear_force": (along, members.shear_force),
        "deflection": ((*along, "component"), members.deflection),
        "euler_ratio": (("member",), euler_ratio(scene, members)),
        "bow": (("member",), bow(scene, members)),
        "rotation": (("member",), rotation(members)),
    }
    if scene.damping.material and scene.analysis.method in ("periodic", "transient"):
        found["sampling_error"] = (("member",), sampling_error(scene, whole[0][..., None] + whole[1]))
    return found
