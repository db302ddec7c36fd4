"""Analysis of a driven cycle by the equation of poses: build, solve, estimate, collect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, norms
from fenics_mech.accuracy.at_stations import between_stations
from fenics_mech.accuracy.estimate import Errors
from fenics_mech.accuracy.missed_peaks import BETWEEN
from fenics_mech.accuracy.quantities import MEASURE, Quantities, measures
from fenics_mech.effects import EFFECTS, active
from fenics_mech.effects.effect import Choice
from fenics_mech.eigenmodes import modes_kept
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.estimate import finer_mesh, finer_steps
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.forces.strains import stress_over_modulus, young_modulus
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.motion import Motion
from fenics_mech.recovery.balance import balance_of
from fenics_mech.recovery.dataset import decisions, of_errors
from fenics_mech.recovery.link_motion import motion_of_links
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.rigid_places import rigid_places
from fenics_mech.recovery.signal import last_cycle, of_cycle
from fenics_mech.recovery.stress_figures import stress_figures
from fenics_mech.recovery.variables import with_units
from fenics_mech.scene import Scene
from fenics_mech.scene.consistency import mobility
from fenics_mech.scene.meshing import with_halves
from fenics_mech.solve import Cycle, damp_modes, followed_modes, periodic, quasi_static, rigid_cycle, running_modes

UNSTABLE = 1e-4  # of the magnitude: what steps may make of an undamped motion
DISTURBANCES = 6  # that are told
BETWEEN_SHARES = 4  # parts of a step, between which peaks are looked for
ORDERS = {"time": 5.0, "mesh": 4.0, BETWEEN: 2.0, "stations": 2.0}  # of errors, in the numbers that they fall by


@dataclass(frozen=True)
class Solved:
    """A periodic motion of a scene's machine.

    Parameters
    ----------
    scene
        The scene.
    made
        Its machine.
    cycle
        The motion.
    """

    scene: Scene
    made: SceneMachine
    cycle: Cycle

    @classmethod
    def of(cls, scene: Scene) -> Solved:
        """Build the machine of a scene, and find its periodic motion.

        Raises
        ------
        SolverError
            When there is none near the rigid motion.
        """
        made = _built(scene)
        return cls(scene, made, periodic(made.machine, scene.period, scene.analysis.sub_intervals))

    def at(self, share: float = 0.0) -> OfPoses:
        """Give the motion at a share of every step."""
        t, q, v, a = (x[:, 0] for x in self.cycle.path.at(np.array([share or 1.0])))
        if not share:  # the end of the last step is the start of the cycle
            t, q, v, a = (np.roll(x, 1, axis=0) for x in (t, q, v, a))
            t[0] = 0.0
        return OfPoses(self.made, Motion(self.made.machine, t, q, v, a))

    @property
    def at_stages(self) -> OfPoses:
        """Give the motion at the stages of all steps, over which a mean is of the order of the steps."""
        cycle = self.cycle
        q, v, a = (x.reshape(len(cycle.t.ravel()), -1) for x in (cycle.q, cycle.v, cycle.a))
        return OfPoses(self.made, Motion(self.made.machine, cycle.t.ravel(), q, v, a))

    @cached_property
    def positions(self) -> OfPoses:
        """The motion at the positions of the result."""
        return self.at()


def _built(scene: Scene) -> SceneMachine:
    """Build a machine that is damped, with the motion of its rigid links as chart."""
    made = machine_of(scene)
    made.machine.chart = rigid_cycle(made.machine, scene.period)
    if np.any(scene.damping.ratio):
        damp_modes(made.machine, scene.period, scene.damping.ratio)
    return made


def by_poses(scene: Scene) -> Result:
    """Analyse a driven cycle.

    Parameters
    ----------
    scene
        The scene.

    Raises
    ------
    SceneError
        When it has what no term or joint of poses states yet.
    SolverError
        When there is no periodic motion, or it is unstable.
    UnresolvedError
        When an error is too large.
    """
    scene, choices = planned(scene)
    solved = Solved.of(scene)
    stability = _stability(solved) if scene.analysis.stability else xr.Dataset()
    errors = estimated(solved) if scene.analysis.error_estimates else None
    return collected(solved, errors, stability, choices)


EXACT = ("coupling", "large-rotations")  # what the equation of poses always has
FREE = ("shear", "rotary-inertia")  # what it has at no cost, where the scene lets the program choose
NOT_YET = ("inextensible", "lumped-mass", "motor", "air-drag")


def planned(scene: Scene) -> tuple[Scene, tuple[Choice, ...]]:
    """Choose the effects of a scene for the equation of poses, and say what was decided about each.

    Parameters
    ----------
    scene
        The scene.

    Raises
    ------
    SceneError
        When it lists effects that the equation has not yet.
    """
    if scene.effects == "auto":
        lacking = {name for name in FREE if EFFECTS[name].missing_data(scene)}
        scene = scene.changed(effects=(*EXACT, *(name for name in FREE if name not in lacking)))
    elif not set(EXACT) <= set(scene.named_effects):
        scene = scene.changed(effects=tuple({*scene.effects, *EXACT} - {"geometric-stiffness"}))
    acting = {effect.name for effect in active(scene)}
    if refused := [name for name in NOT_YET if name in acting]:
        raise SceneError(
            f"the equation of poses does not have {' and '.join(refused)} yet",
            place="analysis.solver",
            hint="Write solver = 'collocation'",
        )
    return scene, tuple(
        Choice(effect, None, name in acting, effect.missing_data(scene) if name in FREE and name not in acting else "")
        for name, effect in EFFECTS.items()
    )


def quantities(found: OfPoses) -> Quantities:
    """Give what is compared between two motions, at the stations of the result."""
    axial, bending = found.strains
    forces, efforts = list(found.joint_forces().values()), list(found.efforts().values())
    return Quantities(
        axial=axial,
        bending=bending,
        deflection=found.members()["deflection"][1],
        force=np.stack(forces, axis=1),
        effort=np.stack(efforts, axis=1),
    )


def estimated(solved: Solved) -> Errors:
    """Estimate the errors of a motion: by more stages, by halved elements, and by what lies between the positions."""
    here, scene = quantities(solved.positions), solved.scene
    finer = _built(with_halves(scene))
    by_mesh = finer_mesh(solved.cycle, finer.machine)
    parts = {
        "time": (quantities(replace(solved, cycle=finer_steps(solved.cycle)).at()) - here).largest,
        "mesh": (quantities(Solved(scene, finer, by_mesh).at()) - here).largest,
    }
    parts[BETWEEN] = _missed(solved, here)
    return told(scene, here, parts)


def told(scene: Scene, here: Quantities, parts: dict[str, dict[str, Array]]) -> Errors:
    """Add what lies between the stations to errors by source and quantity, and refuse those that are too large.

    Parameters
    ----------
    scene
        The scene.
    here
        What the errors are of.
    parts
        Errors by source, then by quantity.
    """
    largest = here.largest
    strain, deflection = here.axial[..., None] + here.bending, norms(here.deflection)[..., None]
    parts = parts | {"stations": {"strain": between_stations(strain), "deflection": between_stations(deflection)}}
    nothing = {name: np.zeros_like(size) for name, size in largest.items()}
    by_quantity = {
        name: {source: found.get(name, nothing[name]) for source, found in parts.items()} for name in largest
    }
    order = {source: ORDERS[source] for source in parts}
    errors = Errors(by_quantity, order, measures(scene, largest), (), largest)
    errors.judge(scene)
    return errors


def _missed(solved: Solved, here: Quantities) -> dict[str, Array]:
    """Give by how much peaks between the positions surpass those of the Fourier series through the positions."""
    through = here.at_more_angles(BETWEEN_SHARES).sizes
    most = here.largest
    for share in range(1, BETWEEN_SHARES):
        there = quantities(solved.at(share / BETWEEN_SHARES)).largest
        most = {name: np.maximum(size, there[name]) for name, size in most.items()}
    return {name: np.maximum(size - through[name].max(axis=0), 0.0) for name, size in most.items()}


def _stability(solved: Solved) -> xr.Dataset:
    """Give multipliers and frequencies of small disturbances, and refuse those that grow."""
    scene, period = solved.scene, solved.scene.period
    values, rates = running_modes(solved.cycle, 2 * DISTURBANCES)
    values, rates = values[:DISTURBANCES], rates[:DISTURBANCES]
    if not len(values):
        return xr.Dataset()
    if abs(values[0]) > 1 + UNSTABLE and not scene.analysis.allow_unstable:
        raise SolverError(
            f"the periodic motion is unstable: a small disturbance grows by {abs(values[0]):.6g} in each cycle "
            f"(multiplier {values[0]:.5g}, {rates[0].real:.3g} 1/s) at {rates[0].imag / (2 * np.pi):.4g} Hz. "
            "Change the speed or give more damping; analysis.allow_unstable lets it pass"
        )
    of_each = ("disturbance",)
    return xr.Dataset(
        {
            "multiplier": ((*of_each, "part"), np.stack([values.real, values.imag], axis=1)),
            "growth_rate": (of_each, np.log(np.abs(values)) / period),
            "multiplier_frequency": (of_each, rates.imag / (2 * np.pi)),
        },
        {"disturbance": np.arange(1, len(values) + 1), "part": ["real", "imaginary"]},
    )


def read_off(found: OfPoses, choices: Sequence[Choice]) -> xr.Dataset:
    """Label what motions of all kinds have: strains, forces and places at the positions, and what was decided.

    Parameters
    ----------
    found
        The motion at the positions.
    choices
        What was decided about effects.
    """
    scene, links = found.made.scene, found.links()
    efforts, forces = found.efforts(), found.joint_forces()
    each = np.stack(list(efforts.values()), axis=1)
    variables: dict[str, Any] = {
        **found.members(),
        "joint_force": (("theta", "joint", "component"), np.stack(list(forces.values()), axis=1)),
        **found.frame(),
        **found.points(),
        "input_torque": (("theta",), each[:, 0]),
        "drive_effort": (("theta", "drive"), each),
    }
    variables["largest_strain"] = (("member",), np.abs(variables["strain"][1]).max(axis=(0, 2, 3)))
    labels = {
        "theta": links.theta,
        "time": ("theta", links.time),
        "member": list(found.mesh.members),
        "s": found.stations,
        "fibre": ["+", "-"],
        "joint": list(forces),
        "component": ["x", "y"],
        "drive": list(efforts),
        "support": list(found.supports),
        "point": list(found.traced),
    }
    attributes = stamp(scene) | {"mobility": mobility(scene), "solver": "poses"}
    attributes |= decisions(found.motion.machine.n, len(found.mesh.cell), choices)
    data = xr.Dataset(variables, labels, attributes)
    return joined(data, rigid_places(scene, links), motion_of_links(scene, links))


def collected(solved: Solved, errors: Errors | None, stability: xr.Dataset, choices: Sequence[Choice]) -> Result:
    """Label what was found.

    Parameters
    ----------
    solved
        The motion.
    errors
        Its errors; None where they are not estimated.
    stability
        What is known of disturbances.
    choices
        What was decided about effects.
    """
    scene, found = solved.scene, solved.positions
    data = read_off(found, choices)
    efforts = data["drive_effort"].to_numpy()
    data["drive_effort_rms"] = ("drive",), np.sqrt(np.mean(efforts**2, axis=0))
    parts = [
        _power(solved, errors),
        _modes(solved),
        _without_vibration(solved),
        stability,
        *([] if errors is None else [of_errors(errors).dataset()]),
    ]
    data = joined(data, *parts)
    cycle = last_cycle(scene.analysis, scene.drives, data)
    data = joined(data, stress_figures(scene, data, cycle))
    if cycle is not None:
        data = joined(data, of_cycle(data, cycle, scene.period, data["strain_quasi_static"]))
    units = effort_units(scene.moved_joints, scene.joints)
    return Result.with_scene(scene, with_units(data, units, scene.springs.values(), scene.dampers.values()))


def joined(*parts: xr.Dataset) -> xr.Dataset:
    """Put datasets with the same labels together."""
    return xr.merge(parts, combine_attrs="no_conflicts", compat="override", join="override")


def _power(solved: Solved, errors: Errors | None) -> xr.Dataset:
    """Give the mean power of every cause, and how far the energy fluctuates that the drives give."""
    powers, steps = solved.at_stages.powers(), len(solved.cycle.t)
    given = next(iter(solved.positions.powers().values()))
    weights = np.tile(solved.cycle.tableau.A[-1] / steps, steps)
    passed = max(float(np.abs(power).mean()) for power in powers.values())
    bound = np.nan
    if errors is not None:
        uncertain = np.sum(list(errors.errors["torque"].values()), axis=0)
        bound = float(uncertain @ np.abs(solved.positions.drive_rates()).mean(axis=0))
    mean = {cause: float(weights @ power) for cause, power in powers.items()}
    found = balance_of(mean, MEASURE.small_power * passed, bound)
    surplus = np.append(given, given[0]) - given.mean()
    stored = np.cumsum((surplus[1:] + surplus[:-1]) / 2) * solved.scene.period / len(given)
    return found.assign_attrs(energy_fluctuation=float(np.ptp(stored)))


def _modes(solved: Solved) -> xr.Dataset:
    """Give natural frequencies where the machine is held at its positions, and how well each was followed."""
    scene, machine = solved.scene, solved.made.machine
    found = followed_modes(machine, solved.positions.motion.t)
    count = modes_kept(scene.analysis.modes, found.omega.shape[1])
    along = ("theta", "mode")
    return xr.Dataset(
        {
            "frequency": (along, found.omega[:, :count] / (2 * np.pi)),
            "assurance": (along, found.assurance[:, :count]),
        },
        {"mode": np.arange(1, count + 1)},
    )


def _without_vibration(solved: Solved) -> xr.Dataset:
    """Give strains and stresses of the static answer to loads and rigid inertia."""
    scene, s, motion = solved.scene, solved.positions.stations, solved.positions.motion.chart
    still = quasi_static(motion.machine, motion.t)
    terms = [
        here.with_response(replace(here.response, stress=stress))
        for here, stress in zip(still.found.terms, still.stresses)
    ]
    forces = along_members(solved.made, replace(still.found, terms=terms), still.change[2], s)
    sections = scene.rigidities(s)
    by_force, by_moment = stress_over_modulus(sections, forces.axial, forces.moment)
    strain, along = by_force[..., None] + by_moment, ("theta", "member", "s", "fibre")
    return xr.Dataset(
        {"strain_quasi_static": (along, strain), "stress_quasi_static": (along, young_modulus(sections) * strain)}
    )
