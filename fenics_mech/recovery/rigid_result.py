"""The result of a motion of rigid links: forces of joints and laws, efforts, powers, and the freedoms' motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.accuracy.quantities import measures_of_efforts
from fenics_mech.accuracy.remarks import after_contacts
from fenics_mech.accuracy.transient_errors import trial_of_steps
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.kinematics import Motion
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.motion import as_motion
from fenics_mech.recovery.at_rest import of_friction, of_small_motions
from fenics_mech.recovery.balance import balance_of, mean_in_time, stored
from fenics_mech.recovery.beside_motion import beside_motion
from fenics_mech.recovery.law_efforts import law_efforts, with_law_units
from fenics_mech.recovery.link_motion import followed, motion_of_links
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.rigid_between import missed_by_positions
from fenics_mech.recovery.rigid_places import rigid_places
from fenics_mech.recovery.running import running
from fenics_mech.recovery.variables import with_units
from fenics_mech.response.static.rest import rigid_rest
from fenics_mech.response.transient.course import StartState
from fenics_mech.response.transient.cycles import RigidRunner
from fenics_mech.response.transient.rigid_motion import RigidMotion, by_rigid_motion, free_course
from fenics_mech.response.transient.shooting import repeated_motion
from fenics_mech.scene import Scene


def rigid_result(scene: Scene, start: StartState | None = None, stated: Scene | None = None) -> Result:
    """Find the motion of a scene of which no link bends, and label everything that was computed.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that can move and no drive leads.
    start
        The state to go on from; None for that at time 0.
    stated
        The scene as it is stated, which may leave open where the freedoms are.

    Raises
    ------
    SceneError
        When contacts begin overlapped.
    SolverError
        When the time steps fail, or there is no stable equilibrium.
    AssemblyError
        When the linkage cannot be assembled, or comes to a dead centre of its freedoms.
    """
    repeated = repeated_motion(scene, RigidRunner(scene)) if scene.analysis.start == "periodic" else None
    if repeated is not None:
        scene, start = repeated.scene, repeated.start
    rests = bool(scene.freedoms) and scene.analysis.method == "static"
    motion = rigid_rest(scene, _places(stated or scene)) if rests else by_rigid_motion(scene, start)
    data = _of_motion(scene, motion)
    if motion.vibrations is not None:
        data = data.merge(of_small_motions(motion.vibrations), combine_attrs="no_conflicts")
    if motion.held is not None:
        labels = of_friction(motion.held, next(iter(scene.freedoms)), [str(name) for name in data["law"].to_numpy()])
        data = data.merge(labels, combine_attrs="no_conflicts")
    states = [part.states for part in motion.instants]
    names = "theta", "time", "q", "velocity", "acceleration"
    whole = as_motion(Loops.of(scene), *(np.concatenate([getattr(one, name) for one in states]) for name in names))
    places = rigid_places(scene, whole)[["link_position", "link_angle"]]
    parts = [
        data,
        places,
        motion_of_links(scene, whole),
        _of_points(scene, whole),
        _of_powers(scene, motion),
        _running(scene, motion, data),
        beside_motion(scene, motion.beside, whole.time, repeated),
        _errors(scene, motion, data, start),
        missed_by_positions(scene, whole),
    ]
    data = xr.merge(parts, combine_attrs="no_conflicts")
    efforts = effort_units(scene.moved_joints, scene.joints)
    return Result(with_law_units(scene, with_units(data, efforts, (), ())))


def _places(scene: Scene) -> bool:
    """Whether a scene states where some freedom is."""
    return any(part.start is not None for part in scene.freedoms.values())


def _of_motion(scene: Scene, motion: RigidMotion) -> xr.Dataset:
    """Motion, forces and efforts, over the positions."""
    states = [part.states for part in motion.instants]
    attributes = stamp(scene) | {"solver": str(scene.analysis.method), "effects": "[]", "dofs": len(scene.freedoms)}
    attributes |= {"elements": 0, "time_steps": motion.steps}
    forces = _joined(motion, "joint_forces")
    coordinates: dict[str, Any] = {
        "theta": np.concatenate([part.theta for part in states]),
        "time": ("theta", np.concatenate([part.time for part in states])),
        "joint": list(forces),
        "component": ["x", "y"],
    }
    shape = len(coordinates["theta"]), len(forces), 2
    by_joint = np.stack(list(forces.values()), axis=1) if forces else np.zeros(shape)
    variables: dict[str, Any] = {"joint_force": (("theta", "joint", "component"), by_joint)}
    if scene.moved_joints:
        efforts = np.concatenate([part.efforts for part in motion.instants])
        variables |= {"drive_effort": (("theta", "drive"), efforts), "input_torque": ("theta", efforts[:, 0])}
        coordinates["drive"] = list(scene.moved_joints)
    if scene.freedoms:
        along = "theta", "freedom"
        variables["freedom_place"] = (along, np.concatenate(motion.places))
        variables["freedom_rate"] = (along, np.concatenate(motion.rates))
        coordinates["freedom"] = list(scene.freedoms)
    exerted, depths = _joined(motion, "law_efforts"), _joined(motion, "depths")
    laws = law_efforts(exerted, depths, motion.largest, motion.contacts.closed)
    if any(point.startswith("ground.") for joint in scene.joints.values() for point in joint.connect):
        on_frame = np.concatenate([part.on_frame for part in motion.instants])
        variables["shaking_force"] = ("theta", "component"), on_frame[:, :2]
        variables["shaking_moment"] = "theta", on_frame[:, 2]
    return xr.Dataset(variables, coordinates, attributes).merge(laws, combine_attrs="no_conflicts")


def _of_points(scene: Scene, whole: Motion) -> xr.Dataset:
    """Position, velocity and acceleration of all points of the links, and of those that the scene adds."""
    places = followed(scene)
    moving = zip(*(whole.of_point(*place) for place in places.values()))
    kinds = ("point_position", "point_velocity", "point_acceleration")
    along = ("theta", "point", "component")
    found = {kind: (along, np.stack(values, axis=1)) for kind, values in zip(kinds, moving)}
    return xr.Dataset(found, {"point": list(places)})


def _joined(motion: RigidMotion, what: str) -> dict[str, Array]:
    """Parts of a motion put one after the other, by name."""
    names = getattr(motion.instants[0], what)
    return {name: np.concatenate([getattr(part, what)[name] for part in motion.instants]) for name in names}


def _of_powers(scene: Scene, motion: RigidMotion) -> xr.Dataset:
    """Mean power of every cause, and how far they are from a balance; see `energy_balance`.

    What drives give at impulses is not known.
    """
    powers = _joined(motion, "powers")
    silent = not any(power.any() for power in powers.values()) and not any(motion.work.values())
    if silent or (scene.impulses and scene.drives):
        return xr.Dataset()
    time = np.concatenate([part.states.time for part in motion.instants])
    in_time = scene.analysis.method == "transient"
    if motion.work:
        mean = {name: work / float(np.ptp(time)) for name, work in motion.work.items()}
    elif in_time:
        mean = mean_in_time(time, powers)
    else:
        mean = {name: float(power.mean()) for name, power in powers.items()}
    if in_time:
        mean |= stored(time, np.concatenate([part.energy for part in motion.instants]))
    return balance_of(mean, max(float(np.abs(power).mean()) for power in powers.values()), 0.0)


def _running(scene: Scene, motion: RigidMotion, data: xr.Dataset) -> xr.Dataset:
    """How the freedoms of a motion in time run."""
    if not motion.steps:
        return xr.Dataset()
    return running(scene, data["time"].to_numpy(), np.concatenate(motion.places), np.concatenate(motion.rates))


def _errors(scene: Scene, motion: RigidMotion, data: xr.Dataset, start: StartState | None) -> xr.Dataset:
    """Errors by the time steps, from a motion with another tolerance; after contacts opened where that is asked for."""
    if not motion.steps or not scene.analysis.error_estimates:
        return xr.Dataset()
    parted = motion.contacts.opened > 0
    remark = after_contacts(scene.analysis) if parted else ""
    attributes: dict[str, Any] = {"not_estimated": remark} if remark else {}
    if (trial := trial_of_steps(scene.analysis, parted)) is None:
        return xr.Dataset(attrs=attributes)
    factor, share = trial
    rough = _of_motion(scene, free_course(scene, start, factor))
    found: dict[str, Any] = {}
    for name, axis in {"joint_force": "joint", "drive_effort": "drive", "freedom_place": "freedom"}.items():
        if name not in data:
            continue
        change = share * np.abs(rough[name].to_numpy() - data[name].to_numpy())
        by_part, largest = (_by_part(values) for values in (change, np.abs(data[name].to_numpy())))
        found[f"{name}_error"] = (("source", axis), by_part[None])
        measure = np.full_like(largest, max(float(largest.max(initial=0.0)), TINY))
        if name == "drive_effort":
            measure = measures_of_efforts(scene, largest, float(abs(data["joint_force"]).max()))
        relative = float((by_part / measure).max(initial=0.0))
        found[f"{name}_relative_error"] = (("source",), [relative])
        attributes[f"{name}_error_estimate"] = relative
    return xr.Dataset(found, {"source": ["time"]}, attributes)


def _by_part(values: Array) -> Array:
    """Give the largest over time of each joint, drive or freedom: of ``(times, parts, ...)``."""
    return np.asarray(np.moveaxis(values, 1, 0).reshape(values.shape[1], -1).max(axis=1))
