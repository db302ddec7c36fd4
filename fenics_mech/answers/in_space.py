"""Answers to scenes in space: periodic, quasi-static and static, with stability, frequencies and their errors."""

from __future__ import annotations

import json
import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech._version import __version__
from fenics_mech.answers.spatial_in_time import in_time
from fenics_mech.errors import SceneError, SolverError, UnstableError
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.spatial import MemberInSpace, SpatialMachine, held_as_drawn, spatial_machine
from fenics_mech.machine.spatial_forces import SpatialSections, of_joints, of_members
from fenics_mech.recovery.spatial_result import SpatialResult, described
from fenics_mech.recovery.strains import elastic_strain
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.sections.shapes import open_and_thin
from fenics_mech.solve import (
    Cycle,
    damp_modes,
    equilibria,
    frequencies,
    held_modes,
    periodic,
    rigid_cycle,
    running_modes,
    tangents_at,
)
from fenics_mech.terms import Look, Spring

logger = logging.getLogger(__name__)
STAGES = 3  # of Radau IIA in a step
TOLERANCE = 1e-7  # of Newton's last change, relative to the largest coordinate
SAME = 1e-9  # rad, between an instant of the positions and a jump of a load
UNSTABLE = 1.0 + 1e-6  # a multiplier above it: rounding of steps is 1e-8
COARSE = 0.1  # estimated error from which an answer is called too coarse
COMPONENTS = ("x", "y", "z")


@dataclass(frozen=True)
class InSpace:
    """An answer at the positions of a scene.

    Parameters
    ----------
    made
        The machine.
    motion
        Its motion at the positions.
    cycle
        The periodic motion; None of the others.
    rigid
        Places of the stations of every member where no member bends ``(positions, stations, 3)`` (m).
    """

    made: SpatialMachine
    motion: Motion
    cycle: Cycle | None
    sections: dict[str, SpatialSections]
    rigid: dict[str, Array]
    joints: dict[str, tuple[Array, Array]]


def in_space(scene: SpatialScene) -> SpatialResult:
    """Analyse a scene in space as its `analysis` states.

    Parameters
    ----------
    scene
        The scene.

    Returns
    -------
    SpatialResult
        Stresses, forces, deflections and torques at its positions, with estimates of their errors.

    Raises
    ------
    SceneError
        When something can move that nothing leads.
    SolverError
        When there is no motion or equilibrium, or it is unstable.

    Examples
    --------
    >>> result = fm.analyse(fm.load("demos/space/rssr.toml").changed({"analysis.positions": 30}))
    >>> result.data["stress"].dims
    ('theta', 'member', 's', 'corner')
    """
    answer = answer_in_space(scene)
    data = _dataset(answer)
    better = _better(answer) if scene.analysis.error_estimates else {}
    data = data.merge(_errors(better, data))
    notices, doubts = _stability(better.get("time", answer), data)
    data.attrs |= _attributes(answer, data, notices, doubts)
    return SpatialResult.with_scene(scene, described(data))


def answer_in_space(scene: SpatialScene, finer: int = 1, stages: int = STAGES) -> InSpace:
    """Solve for the answer to a scene.

    Parameters
    ----------
    scene
        The scene.
    finer
        Elements for each one that it states.
    stages
        Of a step.
    """
    made = spatial_machine(scene, finer)
    machine, method = made.machine, scene.analysis.method
    if machine.size == 0:
        raise SceneError("nothing in the scene moves or bends", place="links")
    cycle = None
    if method == "transient":
        motion = in_time(made, stricter=10.0 ** (STAGES - stages))
        return _read_off(made, motion, None)
    if method == "static":
        t = np.zeros(1)
    else:
        with held_as_drawn(made):
            chart = rigid_cycle(machine, scene.period)
        machine.chart = chart
        t = scene.period * np.arange(scene.analysis.positions) / scene.analysis.positions
        _count_turns_of_springs(made)
    if method == "periodic" and machine.n > machine.held:
        if scene.damping.ratio and made.members:
            damp_modes(machine, scene.period, scene.damping.ratio)
        cycle = periodic(machine, scene.period, _steps_of(scene), stages=stages, tolerance=TOLERANCE)
        motion = Motion(machine, t, *cycle.path.when(t))
    else:  # at rest, or a machine without degrees of freedom beside the drives
        q, a = _balanced(made, t, method)
        motion = Motion(machine, t, q, 0 * q, a, moving=method != "static")
    return _read_off(made, motion, cycle)


def _read_off(made: SpatialMachine, motion: Motion, cycle: Cycle | None) -> InSpace:
    """Give the forces of a motion, and where its members are without bending."""
    shares = np.linspace(0, 1, made.scene.analysis.stations)
    sections = of_members(made, motion, shares)
    rigid = {own.label: _drawn_stations(made, motion, own, shares) for own in made.members}
    return InSpace(made, motion, cycle, sections, rigid, of_joints(made, motion))


def _balanced(made: SpatialMachine, t: Array, method: str) -> tuple[Array, Array]:
    """Find the equilibrium at every instant: all loads at once, or in growing shares where that finds none."""
    machine = made.machine
    zero = np.zeros((len(t), machine.size))
    moving, what = method != "static", "the static answer" if method == "static" else "the quasi-static answer"
    try:
        return equilibria(machine, t, zero, moving=moving, what=what)
    except SolverError as error:
        if moving:
            raise
        logger.info("the loads are put on in steps: %s", error)
    q, share = zero, 0.0
    step = 0.25
    while share < 1.0:
        step = min(step, 1.0 - share)
        try:
            q, a = equilibria(machine, t, q, loads=share + step, moving=False, what=what)
        except SolverError:
            step /= 2
            if step < 1 / 256:
                raise SolverError(
                    f"{what}: with {100 * share:.4g} % of the loads there is an equilibrium, and none is found a "
                    "little beyond. The machine buckles or gives way there: lower the loads, or take stiffer members"
                ) from None
            continue
        share, step = share + step, 2 * step
    return q, a


def _steps_of(scene: SpatialScene) -> Array | int:
    """Give the instants at which steps begin (s): evenly, and where loads jump."""
    count, rate = scene.analysis.positions, scene.cycle_rate
    jumps = [angle for load in scene.loads.values() if load.factor is not None for angle in load.factor.jumps]
    if not jumps:
        return count
    even, turned = TURN * np.arange(count) / count, np.mod(np.sign(rate) * np.array(jumps), TURN)
    apart = np.abs(np.mod(even[:, None] - turned + np.pi, TURN) - np.pi).min(axis=1)
    return np.unique(np.concatenate([even[apart > SAME], np.mod(turned - 2 * SAME, TURN)])) / abs(rate)


def _count_turns_of_springs(made: SpatialMachine) -> None:
    """Let springs at joints count whole turns by the rigid motion.

    Raises
    ------
    SceneError
        When a joint with a spring does not come back after a cycle: nothing would repeat.
    """
    machine, period = made.machine, made.scene.period
    t = period * np.arange(361) / 360
    for term in machine.terms:
        if isinstance(term, Spring) and term.measures[0].look is Look.ANGLE:
            one, other = term.pairs[0]
            poses = machine.known.at(t)
            first, second = (poses.R[:, end.pose] @ end.turn for end in (one, other))
            relative = np.swapaxes(first, -1, -2) @ second
            angle = np.unwrap(np.arctan2(relative[:, 1, 0], relative[:, 0, 0]))
            if abs(angle[-1] - angle[0]) > np.pi:
                name = next(name for name, pair in made.joints.items() if pair == (one, other))
                raise SceneError(
                    f"the spring at joint {name!r} is wound by {np.degrees(angle[-1] - angle[0]):.4g} deg in every "
                    "cycle, so that no motion repeats",
                    place="springs",
                )
            term._near = lambda now, angle=angle: np.interp(np.mod(now, period), t, angle)


def _drawn_stations(made: SpatialMachine, motion: Motion, own: MemberInSpace, shares: Array) -> Array:
    """Give places of the stations of a member that does not bend: in time, on the line between its ends."""
    machine = motion.machine
    pairs = [machine.beams.pairs[k] for k in own.elements]
    chart = machine.known.at(motion.t)
    ends = [
        chart.r[:, end.pose] + np.einsum("tij,j->ti", chart.R[:, end.pose], end.offset)
        for end in (pairs[0][0], pairs[-1][1])
    ]
    return ends[0][:, None] + shares[:, None] * (ends[1] - ends[0])[:, None]


def _stresses(answer: InSpace, own: MemberInSpace) -> tuple[Array, Array]:
    """Give normal stresses at the corners ``(positions, stations, corners)``, and the largest shear of torsion (Pa).

    N/A - M3 y/I + M2 z/I, with y along the first principal axis and z along the second.
    """
    found, section = answer.sections[own.label], own.section
    y, z = section.corners.T
    bending = -found.moment[..., 2:] * y / section.inertia[0] + found.moment[..., 1:2] * z / section.inertia[1]
    normal = found.force[..., :1] / section.area + bending
    modulus = section.torsion_modulus
    shear = np.full(normal.shape[:2], np.nan) if modulus is None else np.abs(found.moment[..., 0]) / modulus
    return normal, shear


def _dataset(answer: InSpace) -> xr.Dataset:
    """Put what is read off a motion into a dataset."""
    made, motion, scene = answer.made, answer.motion, answer.made.scene
    over = ("theta", "member", "s")
    variables: dict[str, Any] = {}
    labels: dict[str, Any] = {"theta": motion.t * scene.cycle_rate, "time": ("theta", motion.t)}
    if made.members:
        labels |= {"member": [own.label for own in made.members], "component": list(COMPONENTS)}
        labels |= {"s": np.linspace(0, 1, scene.analysis.stations), "section_axis": ["along", "first", "second"]}
        most = max(len(own.section.corners) for own in made.members)
        stress, strain, shear, corners = [], [], [], []
        for own in made.members:
            normal, torsion = _stresses(answer, own)
            pad = (0, most - len(own.section.corners))
            stress.append(np.pad(normal, ((0, 0), (0, 0), pad), "edge"))
            elastic = normal / own.modulus
            if answer.cycle is not None and scene.damping.material:
                elastic = elastic_strain(elastic, scene.damping.material, scene.period)
            strain.append(np.pad(elastic, ((0, 0), (0, 0), pad), "edge"))
            corners.append(np.pad(own.section.corners, (pad, (0, 0)), "edge"))
            shear.append(torsion)
        largest = np.nanmax(np.abs(np.stack(stress, axis=1)), axis=-1)
        von_mises = np.sqrt(largest**2 + 3 * np.nan_to_num(np.stack(shear, axis=1)) ** 2)
        of_members = [answer.sections[own.label] for own in made.members]
        place = np.stack([one.place for one in of_members], axis=1)
        rigid = np.stack([answer.rigid[own.label] for own in made.members], axis=1)
        forces, moments = (np.stack([getattr(one, name) for one in of_members], axis=1) for name in ("force", "moment"))
        variables |= {
            "stress": ((*over, "corner"), np.stack(stress, axis=1)),
            "strain": ((*over, "corner"), np.stack(strain, axis=1)),
            "torsion_stress": (over, np.stack(shear, axis=1)),
            "von_mises": (over, von_mises),
            "corner_place": (("member", "corner", "principal"), np.array(corners)),
            "section_force": ((*over, "section_axis"), forces),
            "section_moment": ((*over, "section_axis"), moments),
            "place": ((*over, "component"), place),
            "section_axes": ((*over, "component", "section_axis"), np.stack([one.axes for one in of_members], axis=1)),
            "deflection": ((*over, "component"), place - rigid),
        }
    if answer.joints:
        labels |= {"joint": list(answer.joints), "component": list(COMPONENTS)}
        for k, name in enumerate(("joint_force", "joint_moment")):
            values = np.stack([pair[k] for pair in answer.joints.values()], axis=1)
            variables[name] = (("theta", "joint", "component"), values)
        for k, name in enumerate(("joint_base", "joint_place")):
            places = [motion.of_end(made.joints[joint][k])[0] for joint in answer.joints]
            variables[name] = (("theta", "joint", "component"), np.stack(places, axis=1))
    rows = made.machine.n + np.array(made.driven, dtype=int)
    if made.driven:
        labels["drive"] = [drive.joint for drive in scene.drives]
        variables["input_torque"] = (("theta", "drive"), -motion.a[:, rows])
    if made.idle:
        idle = made.machine.n + np.array(list(made.idle), dtype=int)
        labels["held_link"] = list(made.idle.values())
        variables["holding_moment"] = (("theta", "held_link"), -motion.a[:, idle])
    if scene.analysis.modes and made.members and scene.analysis.method != "transient":
        variables["frequency"] = (("theta", "mode"), _frequencies(answer))
        labels["mode"] = np.arange(1, 1 + variables["frequency"][1].shape[1])
    return xr.Dataset(variables, labels)


def _frequencies(answer: InSpace) -> Array:
    """Give the slowest natural frequencies at every position, held by the drives (Hz).

    At rest they are those about the loaded equilibrium; over a cycle those of the machine without load.

    Raises
    ------
    UnstableError
        When an equilibrium is not stable.
    """
    made, motion, count = answer.made, answer.motion, answer.made.scene.analysis.modes
    if made.scene.analysis.method == "static":
        M, C, K = tangents_at(made.machine, motion.q[0], motion.a[0], moving=False)
        rates = frequencies(M, C if made.scene.dampers else None, K, count)[0]
        if (rates.real > 1e-6 * np.abs(rates).max()).any():
            raise UnstableError(
                "the equilibrium is not stable: the machine buckles or falls to another one. Lower the loads, or take "
                "stiffer members"
            )
        return np.abs(rates.imag)[None] / TURN
    held = [held_modes(made.machine, float(t))[0][:count] for t in motion.t]
    return np.array([omega[: min(map(len, held))] for omega in held]) / TURN


QUANTITIES = {"strain": "strain", "deflection": "deflection", "joint_force": "joint_force", "torque": "input_torque"}


def _better(answer: InSpace) -> dict[str, InSpace]:
    """Give answers with halved elements, and with another stage, by the source of which most of the error is gone."""
    scene = answer.made.scene.changed({"analysis.modes": 0})  # frequencies are not compared
    better = {"mesh": answer_in_space(scene, finer=2)} if answer.made.members else {}
    if answer.cycle is not None or scene.analysis.method == "transient":
        better["time"] = answer_in_space(scene, stages=STAGES + 1)
    return better


def _errors(better: dict[str, InSpace], data: xr.Dataset) -> xr.Dataset:
    """Estimate errors by better answers: what halved elements change is 3/4 of theirs, as they have order 2."""
    sources, found = list(better), {}
    others = {source: (_dataset(other), 4 / 3 if source == "mesh" else 1.0) for source, other in better.items()}
    for what, name in QUANTITIES.items():
        if name not in data or not sources:
            continue
        largest = float(np.nanmax(np.abs(data[name].to_numpy()), initial=0.0))
        sizes = [
            lack * float(np.nanmax(np.abs(other[name].to_numpy() - data[name].to_numpy()), initial=0.0))
            for other, lack in others.values()
        ]
        found[f"{what}_relative_error"] = (("source",), [size / largest if largest else 0.0 for size in sizes])
    return xr.Dataset(found, {"source": sources} if sources else {})


def _stability(answer: InSpace, data: xr.Dataset) -> tuple[list[str], list[str]]:
    """Add the Floquet multipliers of a periodic motion, refuse an unstable one, and give notices and doubts.

    Steps damp a vibration with exp(i w t) themselves, in each step by |R(i w h)|, R the stability function of Radau's
    method (Hairer and Wanner, Solving ODE II, section IV.3).

    Raises
    ------
    UnstableError
        When small disturbances grow, and that may not be so.
    """
    analysis = answer.made.scene.analysis
    if answer.cycle is None or not analysis.multipliers:
        return [], []
    running = running_modes(answer.cycle, analysis.multipliers)
    if not len(running.multipliers):
        return ["small disturbances die out within a cycle: no multiplier is above 1e-4"], []
    data["multiplier"] = ("disturbance", np.abs(running.multipliers))
    data["growth_rate"] = ("disturbance", running.rates.real)
    data["multiplier_frequency"] = ("disturbance", running.rates.imag / TURN)
    largest = float(np.abs(running.multipliers).max())
    if largest > UNSTABLE and not analysis.allow_unstable:
        raise UnstableError(
            f"the periodic motion is unstable: a small disturbance grows by a factor of {largest:.5g} in every cycle. "
            "Change the speed or the damping, or let it pass with analysis.allow_unstable = true"
        )
    tableau, h = answer.cycle.tableau, float(answer.cycle.path.h.max())
    for rate in running.rates:
        z = 1j * rate.imag * h
        grown = 1 + z * tableau.A[-1] @ np.linalg.solve(np.eye(len(tableau.c)) - z * tableau.A, np.ones(len(tableau.c)))
        by_steps = float(np.log(np.abs(grown))) / h
        if abs(by_steps) > DAMPED * abs(rate.real):
            doubt = (
                f"the steps damp a disturbance of {rate.imag / TURN:.4g} Hz by {-by_steps:.3g} 1/s, and it decays by "
                f"{-rate.real:.3g} 1/s in all: whether it dies out is not known. Take more positions"
            )
            return [], [doubt]
    return [], []


DAMPED = 0.2  # share of the decay of a disturbance that steps may make


def _attributes(answer: InSpace, data: xr.Dataset, notices: list[str], warnings: list[str]) -> dict[str, Any]:
    """Say what was decided, assumed, and is doubtful, after what is said about stability."""
    made, scene = answer.made, answer.made.scene
    notices, warnings = list(notices), list(warnings)
    for link in made.idle.values():
        moment = float(np.abs(data["holding_moment"].sel(held_link=link).to_numpy()).max())
        notices.append(
            f"link {link} may turn about its own line, which nothing drives: a row holds that turn, and takes "
            f"{moment:.3g} N m at most"
        )
    if made.redundant:
        notices.append(
            "the joints hold more than is needed where links do not bend; their forces are those of equal bearings: "
            + ", ".join(made.redundant)
        )
    if made.freedoms == 0 and scene.drives:
        notices.append("rigid links could not move: they bend wherever the machine goes")
    for own in made.members:
        if open_and_thin(scene.sections[own.stated.section]):
            warnings.append(
                f"section {own.stated.section!r} of member {own.label} is open and has thin walls: that its ends hold "
                "its warping is left out, by which it is stiffer in torsion"
            )
        off = float(np.linalg.norm(own.section.shear_centre))
        if off > 0.02 * own.section.reach:
            warnings.append(
                f"the shear centre of section {own.stated.section!r} is {1e3 * off:.3g} mm beside its centroid: forces "
                "across it twist the member, which is left out"
            )
        strength = scene.materials[own.stated.material].strength
        peak = float(np.nanmax(data["von_mises"].sel(member=own.label).to_numpy()))
        if strength is not None and peak > strength:
            warnings.append(
                f"member {own.label} has {peak / 1e6:.4g} MPa, beyond its strength of {strength / 1e6:g} MPa"
            )
    errors = {
        what: float(data[f"{what}_relative_error"].sum()) for what in QUANTITIES if f"{what}_relative_error" in data
    }
    for what, error in errors.items():
        if error > COARSE:
            warnings.append(
                f"the estimated error of the {what.replace('_', ' ')} is {100 * error:.3g} %: take more elements or "
                "positions"
            )
    return {
        "fenics_mech": __version__,
        "scene": scene.model_dump_json(by_alias=True),
        "dimension": 3,
        "dofs": made.machine.n,
        "elements": sum(len(own.elements) for own in made.members),
        "mobility": made.freedoms,
        "notices": json.dumps(notices),
        "warnings": json.dumps(list(dict.fromkeys(warnings))),
        **{f"{what}_error_estimate": error for what, error in errors.items()},
    }
