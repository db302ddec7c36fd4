"""Analysis of a driven machine by the equation of poses: plan, build, solve, estimate, collect."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index, norms
from fenics_mech.answers.balanced_by_poses import Balanced, LinearBalanced
from fenics_mech.answers.buckled_links import with_buckled
from fenics_mech.answers.mode_speeds import mode_speeds
from fenics_mech.answers.modes_by_poses import modes_kept
from fenics_mech.answers.rest_by_poses import FreelyAtRest
from fenics_mech.answers.solved_by_poses import (
    FREE,
    AtRest,
    LinearCycle,
    Run,
    Solved,
    with_effects,
)
from fenics_mech.classical.known import has_modes
from fenics_mech.effects import EFFECTS, active
from fenics_mech.effects.effect import Choice
from fenics_mech.effects.known import COUPLING, EXACT_STRAINS, STIFFENING
from fenics_mech.errors import SceneError, SolverError, UnstableError
from fenics_mech.estimate.error_sources import Errors
from fenics_mech.estimate.missed_peaks import BETWEEN, MissedPeaks, between_stations
from fenics_mech.estimate.quantities import MEASURE, Quantities, measures
from fenics_mech.estimate.remarks import between_points
from fenics_mech.joints.torsional_springs import too_stiff
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.corners import refuse_unresolved
from fenics_mech.machine.drawn_from_scene import law_of
from fenics_mech.machine.laws_from_scene import SHAFT
from fenics_mech.machine.motion import LinearMotion, Motion
from fenics_mech.planning.sampling_checks import refuse_undersampled
from fenics_mech.recovery.balance import balance_of
from fenics_mech.recovery.dataset import decisions, joined, of_errors
from fenics_mech.recovery.link_motion import motion_of_links
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.peaks_between import missed_peaks
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.rigid_places import rigid_places
from fenics_mech.recovery.signal import last_cycle, of_cycle
from fenics_mech.recovery.strains import without_vibration
from fenics_mech.recovery.stress_figures import stress_figures
from fenics_mech.recovery.variables import with_units
from fenics_mech.scene import Scene
from fenics_mech.scene.consistency import mobility
from fenics_mech.solve import followed_modes, forces_about, held_modes, quasi_static
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.terms.causes import Cause

logger = logging.getLogger(__name__)
BETWEEN_SHARES = 4  # places for each position at which a motion is looked at: vibration is slower than its steps
ROUNDED = 1e-9  # share that rounding takes, above which it is an error
FEWEST = 4  # positions of a cycle, between which peaks are looked for
STRAINED = 1e-12  # strains below are rounding of places: nothing loads the machine
ORDERS = {
    "time": 5.0,
    "harmonics": 8.0,
    BETWEEN: 2.0,
    "stations": 2.0,
    "theory": 0.0,
    "effects": 0.0,
    "rounding": 0.0,
}  # of errors, in the numbers that they fall by


def by_poses(scene: Scene, run: Run | None = None, names: Collection[str] | None = None) -> Result:
    """Analyse a driven machine over its cycle, or at rest."""
    return answered(scene, names, run)[1]


def answered(
    scene: Scene, names: Collection[str] | None = None, run: Run | None = None
) -> tuple[Solved | AtRest, Result]:
    """Give what `by_poses` gives, and before it the answer that it is read off; `names` are those of `collected`."""
    solved = solution(planned(scene), run)
    return solved, result_of(solved, names, chosen=scene.effects == "auto")


def result_of(solved: Solved | AtRest, names: Collection[str] | None = None, chosen: bool = False) -> Result:
    """Judge an answer as its scene asks, estimate its errors, and collect both with it."""
    stability = stability_of(solved)
    errors = estimated(solved, chosen) if solved.scene.analysis.error_estimates else None
    return collected(solved, errors, stability, names)


def with_errors(solved: Solved | AtRest, errors: Errors) -> Result:
    """Give as much of a result as tells whether it is within a tolerance."""
    data = read_off(solved.positions, _by_exact_strains(solved, errors))
    return Result.with_scene(solved.scene, joined(data, of_errors(errors)))


def has_poses(scene: Scene) -> bool:
    """Say whether a scene is answered at rest or over a cycle, by the equation of poses."""
    return scene.analysis.method != "transient" and not has_modes(scene)


def planned(scene: Scene) -> Scene:
    """Choose the effects of a scene for the equation of poses, or refuse those that it has not."""
    in_time = scene.analysis.method == "transient"
    scene = with_effects(with_exact_strains(scene) if in_time else scene)
    if scene.analysis.method == "periodic" and COUPLING not in scene.named_effects:
        scene = scene.changed(effects=(*scene.named_effects, COUPLING))
    if scene.freedoms and scene.analysis.method == "static":  # links go along with them by any angle
        kept = (name for name in scene.named_effects if name not in (STIFFENING, EXACT_STRAINS))
        scene = scene.changed(effects=(*kept, EXACT_STRAINS))
    acting = {effect.name for effect in active(scene)}
    if "motor" in acting and EXACT_STRAINS not in acting:
        raise SceneError(
            "where a motor's shaft twists, the equation of poses has exact strains alone, and "
            f"{EXACT_STRAINS!r} is not listed",
            place="effects",
            hint=f"Add {EXACT_STRAINS!r}",
        )
    return scene


def with_exact_strains(scene: Scene) -> Scene:
    """Give a scene with exact strains, which every motion in time has, in place of linear ones that it lists."""
    if scene.effects == "auto" or EXACT_STRAINS in scene.named_effects:
        return scene
    kept = (name for name in scene.named_effects if name not in (STIFFENING, COUPLING, EXACT_STRAINS))
    return scene.changed(effects=(COUPLING, EXACT_STRAINS, *kept))


def solution(scene: Scene, run: Run | None = None) -> Solved | AtRest:
    """Solve for the answer to a scene in the theory of its effects, and keep an exact motion in its run."""
    analysis, series = scene.analysis, scene.analysis.solver == "harmonic-balance"
    refuse_unresolved(scene)
    if analysis.method != "periodic":
        refuse_undersampled(scene, analysis.sub_intervals)
        if scene.freedoms:
            return FreelyAtRest.of(scene)
        return AtRest.of(scene)
    refuse_undersampled(scene, analysis.sub_intervals * analysis.stages, by_collocation=not series)
    if series and scene.impulses:
        raise SceneError(
            "impulses make velocities jump, which harmonics do not follow",
            place="analysis.solver",
            hint="Write solver = 'poses'",
        )
    if EXACT_STRAINS not in scene.named_effects:
        return LinearBalanced.of(scene) if series else LinearCycle.of(scene)
    found = Balanced.of(scene) if series else Solved.of(scene, run)
    if run is not None:
        run.keep(found.cycle.path)
    return found


def _by_exact_strains(solved: Solved | AtRest, errors: Errors | None) -> float | None:
    """Give the share that exact strains change beside linear ones, where it is known."""
    if solved.left_out is not None or errors is None:
        return solved.left_out
    return errors.relative("strain").get("theory")


def choices_of(scene: Scene, by_exact_strains: float | None = None) -> tuple[Choice, ...]:
    """Say which effects act, what others lack, and what exact strains change, where that is known."""
    acting = {effect.name for effect in active(scene)}
    lacking = {name: EFFECTS[name].missing_data(scene) for name in FREE if name not in acting}
    sizes = {EXACT_STRAINS: by_exact_strains}
    return tuple(
        Choice(effect, sizes.get(name), name in acting, lacking.get(name, "")) for name, effect in EFFECTS.items()
    )


def estimated(solved: Solved | AtRest, chosen: bool = False) -> Errors:
    """Estimate the errors: by answers without most of each, and by what lies between the positions and the stations."""
    here = solved.positions.quantities
    parts = {source: _change(here, other) for source, other in solved.better()}
    # halved elements lack the rest of the error; of answers at rest, inertia along and beside elements is of order 2
    lack = 2.0 ** (2.0 if isinstance(solved, AtRest) else mesh_order(solved.scene))
    parts["mesh"] = {name: lack / (lack - 1) * error for name, error in parts["mesh"].items()}
    if solved.lost > ROUNDED:
        parts["rounding"] = {name: solved.lost * size for name, size in here.largest.items()}
    if chosen and (fuller := with_assumed_shear(solved.scene)) is not None:
        run = Run()
        if isinstance(solved, Solved):
            run.keep(solved.cycle.path)
        parts["effects"] = _change(here, solution(fuller, run).positions)
    missed = None
    if solved.scene.drives and len(here.axial) >= FEWEST:
        still = isinstance(solved, AtRest) and solved.following is not None  # which is known at any angle by itself
        missed = missed_peaks(
            solved.made,
            lambda share: solved.at(share) if share else solved.positions,
            bent=isinstance(solved, Solved),
            shares=1 if still else BETWEEN_SHARES,
        )
        parts[BETWEEN] = dict(missed.errors)
    return judged_errors(solved.scene, here, parts, missed)


RECTANGLE = 5 / 6  # of the area carries shear: sections that state no share have about as much


def with_assumed_shear(scene: Scene) -> Scene | None:
    """Give a scene with the shear that it has no data for, as of rectangles; None where there is nothing to assume."""
    if "shear" in scene.named_effects:
        return None
    unstated = [name for name, section in scene.sections.items() if getattr(section, "shear_factor", 1) is None]
    changes: dict[str, Any] = {f"sections.{name}.shear_factor": RECTANGLE for name in unstated}
    fuller = scene.changed(changes | {"effects": (*scene.named_effects, "shear")})
    return None if EFFECTS["shear"].missing_data(fuller) else fuller


def _change(here: Quantities, other: OfPoses | None) -> dict[str, Array]:
    """Give by how much a better answer differs, by quantity; where there is none, nothing is known."""
    if other is None:
        return {name: np.full_like(size, np.inf) for name, size in here.largest.items()}
    return other.quantities.minus(here).largest


def judged_errors(
    scene: Scene,
    here: Quantities,
    parts: dict[str, dict[str, Array]],
    missed: MissedPeaks | None = None,
    orders: Mapping[str, float] = ORDERS,
) -> Errors:
    """Add what lies between the stations to errors by source and quantity, and refuse those that are too large."""
    largest = here.largest
    measure = measures(scene, largest)
    if "theory" in parts:  # beyond its measure a quantity is not known at all
        parts["theory"] = {name: np.minimum(error, measure[name]) for name, error in parts["theory"].items()}
    strain, deflection = here.axial[..., None] + here.bending, norms(here.deflection)[..., None]
    parts["stations"] = {"strain": between_stations(strain), "deflection": between_stations(deflection)}
    if not largest["strain"].max(initial=0.0) > STRAINED:
        parts, missed = {source: {} for source in parts}, None
    nothing = {name: np.zeros_like(size) for name, size in largest.items()}
    by_quantity = {
        name: {source: found.get(name, nothing[name]) for source, found in parts.items()} for name in largest
    }
    order = {source: mesh_order(scene) if source == "mesh" else orders[source] for source in parts}
    errors = Errors(by_quantity, order, measure, _unknown(scene), largest, missed)
    errors.judge(scene)
    return errors


def mesh_order(scene: Scene) -> float:
    """Give the order in the length of elements by which answers converge."""
    if "lumped-mass" in scene.named_effects:
        return 2.0
    travels = any(getattr(joint, "member", None) for joint in scene.joints.values())
    return 3.0 if travels else 4.0  # slopes turn where pins pass nodes


def _unknown(scene: Scene) -> tuple[str, ...]:
    """Say what is wrong by more than any estimate says."""
    analysis, found = scene.analysis, list[str]()
    if scene.drives and analysis.method != "static":
        by_steps = analysis.method == "periodic" and analysis.solver != "harmonic-balance"
        found += between_points(scene, analysis.sub_intervals * (analysis.stages if by_steps else 1), cut=by_steps)
    found += [f"what damping.ratio makes of the torsional spring {name!r}, by the mesh" for name in too_stiff(scene)]
    if scene.impulses:
        found.append("what impulses put into vibration that the mesh is too coarse for")
    if scene.points and scene.analysis.method == "transient":
        found.append("accelerations of traced points, where stiff axial vibration magnifies errors of the steps")
    return tuple(found)


def stability_of(solved: Solved | AtRest) -> xr.Dataset:
    """Give what is known of small disturbances, where the scene asks for it."""
    scene = solved.scene
    if not (isinstance(solved, Solved) and scene.analysis.stability):
        return xr.Dataset()
    values, rates, modes = solved.running
    turning = np.repeat(np.arange(len(values)), np.where(values.imag != 0, 2, 1))[: STABILITY.kept]
    values, rates, modes = values[turning], rates[turning], modes[turning]  # both of a pair
    second = np.append(False, turning[1:] == turning[:-1])
    values = np.where(second, values.conj(), values)
    fastest = STABILITY.longest_step * len(solved.cycle.tableau.c) / solved.cycle.path.h.max()
    limit = {"stability_limit": fastest / (2 * np.pi)}  # Hz
    if not len(values):
        return xr.Dataset(attrs=limit)
    if abs(values[0]) > 1 + STABILITY.tolerance and not scene.analysis.allow_unstable:
        raise UnstableError(
            f"the periodic motion is unstable: a small disturbance grows by {abs(values[0]):.6g} in each cycle "
            f"(multiplier {values[0]:.5g}, {rates[0].real:.3g} 1/s) at {rates[0].imag / (2 * np.pi):.4g} Hz, mostly in "
            f"mode {modes[0] + 1}, that of link {_links_of(solved, modes[:1])[0]}. Change the speed or give more "
            "damping; analysis.allow_unstable lets it pass"
        )
    _refuse_resonance(solved, values, rates, modes)
    of_each = ("disturbance",)
    return xr.Dataset(
        {
            "multiplier": ((*of_each, "part"), np.stack([values.real, values.imag], axis=1)),
            "growth_rate": (of_each, rates.real),
            "multiplier_frequency": (of_each, rates.imag / (2 * np.pi)),
            "multiplier_link": (of_each, _links_of(solved, modes)),
            "multiplier_mode": (of_each, modes + 1),
        },
        {"disturbance": np.arange(1, len(values) + 1), "part": ["real", "imaginary"]},
        limit,
    )


def _refuse_resonance(solved: Solved, values: NDArray[Any], rates: NDArray[Any], modes: Index) -> None:
    """Raise `SolverError` where a vibration comes back after a cycle as it was: steps alone damp it then."""
    # A disturbance that creeps back, as of a hinge that is nearly blocked, has a real multiplier just below 1.
    creeps = (values.imag == 0) & (values.real < 1)
    distance, period = np.where(creeps, np.inf, np.abs(values - 1)), solved.scene.period
    worst = int(distance.argmin())
    if distance[worst] < STABILITY.resonant:
        mode, turns = modes[worst], abs(rates[worst].imag) * period / (2 * np.pi)
        held = held_modes(solved.made.machine, 0.0)[0][mode] / (2 * np.pi)
        raise SolverError(
            f"there is no periodic motion: mode {mode + 1} ({held:.6g} Hz), hardly damped, is at resonance with "
            f"harmonic {round(turns)} of the drive ({1 / period:.6g} Hz): its multiplier is {distance[worst]:.1e} "
            "from 1. Give a damping ratio, or another speed"
        )


def _links_of(solved: Solved, modes: Index) -> list[str]:
    """Name the link whose members move most in each mode where the machine is held at the start of the cycle."""
    made, machine, mesh = solved.made, solved.made.machine, solved.positions.mesh
    shapes = np.pad(held_modes(machine, 0.0)[1][:, modes], ((0, 1), (0, 0)))  # what has no coordinate does not move
    moved = shapes[machine.places[machine.groups[0].pose, :2]].mean(axis=1)  # of the middles of elements
    parts, link = mesh.cell_length[:, None] * np.sum(moved**2, axis=1), mesh.member_link[mesh.cell_member]
    most = [int(np.bincount(link, part).argmax()) for part in parts.T]
    return [list(made.scene.links)[i] for i in most]


def read_off(found: OfPoses, by_exact_strains: float | None = None, names: Collection[str] | None = None) -> xr.Dataset:
    """Label what answers of all kinds have: strains, forces and places at the positions, and what was decided."""
    scene, links, bends = found.made.scene, found.links(), found.made.links is not None
    variables: dict[str, Any] = found.members()
    efforts, forces, moments = dict[str, Array](), dict[str, Array](), dict[str, Array]()
    if names is None or not variables.keys() >= set(names):
        efforts, forces, moments = found.efforts(), found.joint_forces, found.joint_moments()
        along = ("theta", "joint", "component")
        none = np.zeros((len(found.motion.t), 0, 2))
        variables["joint_force"] = (along, np.stack(list(forces.values()), axis=1) if forces else none)
        variables |= {**found.frame(), **found.springs(), **found.points()}
    if efforts:
        variables["input_torque"] = (("theta",), next(iter(efforts.values())))
        variables["drive_effort"] = (("theta", "drive"), np.stack(list(efforts.values()), axis=1))
    if bends:
        variables["largest_strain"] = (("member",), found.largest_strains)
    if moments:
        variables["joint_moment"] = (("theta", "held"), np.stack(list(moments.values()), axis=1))
    labels = {
        "held": list(moments),
        "theta": links.theta,
        "time": ("theta", links.time),
        "member": list(found.mesh.members) if bends else [],
        "s": found.stations,
        "fibre": ["+", "-"],
        "joint": list(forces),
        "component": ["x", "y"],
        "drive": list(efforts),
        "support": list(found.supports) if "support_force" in variables else [],
        "point": list(found.traced),
    }
    labels |= {kind: list(own) for kind, own in (("spring", scene.springs), ("damper", scene.dampers)) if own}
    if bends:
        solver = "harmonic-balance" if scene.analysis.solver == "harmonic-balance" else "poses"
        attributes = stamp(scene) | {"mobility": mobility(scene), "solver": solver}
        attributes |= decisions(found.motion.machine.n, len(found.mesh.cell), choices_of(scene, by_exact_strains))
    else:
        attributes = stamp(scene) | {"solver": str(scene.analysis.method), "effects": "[]", "elements": 0}
        attributes |= {"dofs": len(scene.freedoms), "time_steps": 0}
    used = {dimension for dimensions, _ in variables.values() for dimension in dimensions} | {"time"}
    data = xr.Dataset(variables, {name: label for name, label in labels.items() if name in used}, attributes)
    places = rigid_places(scene, links)
    return joined(data, places if bends else places[["link_position", "link_angle"]], motion_of_links(scene, links))


def collected(
    solved: Solved | AtRest, errors: Errors | None, stability: xr.Dataset, names: Collection[str] | None = None
) -> Result:
    """Label what was found."""
    scene, found = solved.scene, solved.positions
    data = read_off(found, _by_exact_strains(solved, errors), names)
    data = joined(data, stability).drop_vars(solved.untold, errors="ignore").assign_attrs(stamp(scene))
    cycle = last_cycle(scene.analysis, scene.drives, data)
    parts: list[Callable[[xr.Dataset], xr.Dataset]] = [lambda data: stress_figures(scene, data, cycle)]
    if isinstance(solved, FreelyAtRest):
        parts.append(lambda data: solved.told)
    if SHAFT in found.made.acting:
        parts.append(lambda data: _shaft(found))
    if "drive_effort" in data and scene.analysis.method != "static":
        parts.append(lambda data: _power(solved, errors))
    if isinstance(solved, Solved):
        parts += [lambda data: _modes(solved), lambda data: _without_vibration(solved)]
    if cycle is not None:
        parts.append(lambda data: of_cycle(data, cycle, scene.period, data.get("strain_quasi_static")))
    parts.append(lambda data: mode_speeds(scene, found.made))
    if errors is not None:
        data = joined(data, of_errors(errors))
    for part in parts:
        if names is None or not data.variables.keys() >= set(names):
            data = joined(data, part(data))
    return Result.with_scene(scene, with_units(scene, data))


def _power(solved: Solved | AtRest, errors: Errors | None) -> xr.Dataset:
    """Give the mean power of every cause, the mean of efforts, and how far the energy fluctuates that drives give."""
    instants, weights = solved.weighed
    powers, efforts = instants.powers(), np.stack(list(solved.positions.efforts().values()), axis=1)
    given = next(iter(solved.positions.powers().values()))
    bound = np.nan if errors is None else errors.of_power(solved.positions.drive_rates())
    mean = {cause: float(weights @ power) for cause, power in powers.items()}
    if isinstance(solved, Solved) and solved.scene.impulses:
        mean, given_at = _with_impulses(solved, mean)
        return balance_of(mean, powers, bound, MEASURE.small_power).merge(given_at)
    found = balance_of(mean, powers, bound, MEASURE.small_power)
    found["drive_effort_rms"] = (("drive",), np.sqrt(np.mean(efforts**2, axis=0)))
    surplus = np.append(given, given[0]) - given.mean()
    stored = np.cumsum((surplus[1:] + surplus[:-1]) / 2) * solved.scene.period / len(given)
    return found.assign_attrs(energy_fluctuation=float(np.ptp(stored)))


def _shaft(found: OfPoses) -> xr.Dataset:
    """Give how far a motor's crank is ahead of its drive, its rate, and the range of that over its mean."""
    law = law_of(found.made.scene, 0)(found.motion.t)
    turned, rate, _ = found.motion.jet(found.made.acting[SHAFT])
    figures = {"speed_fluctuation": float(np.ptp(rate) / abs(rate.mean()))}
    return xr.Dataset({"drive_twist": ("theta", turned - law), "drive_rate": ("theta", rate)}, attrs=figures)


def _with_impulses(solved: Solved, mean: dict[str, float]) -> tuple[dict[str, float], xr.Dataset]:
    """Add what impulses give, and what drives give at them, to the mean powers; with the impulses of their efforts."""
    cycle, scene, n = solved.cycle, solved.scene, solved.made.machine.n
    efforts, works = np.zeros((len(scene.impulses), len(scene.drives))), 0.0
    for k, blows in cycle.blows.items():
        efforts[blows.numbers] = -blows.jumps[:, n + np.array(solved.made.driven)]
        works += float(blows.works.sum())
        t = (cycle.path.starts + cycle.path.h)[k : k + 1]
        rates = OfPoses(solved.made, Motion(solved.made.machine, t, *cycle.path.when(t))).drive_rates()
        mean[next(iter(mean))] += float(np.sum(efforts[blows.numbers] @ rates[0])) / scene.period
    labels = {"impulse": list(scene.impulses), "drive": [drive.joint for drive in scene.drives]}
    impulses = xr.Dataset({"drive_impulse": (("impulse", "drive"), efforts)}, labels)
    return mean | {Cause.IMPULSES: works / scene.period}, impulses


def _modes(solved: Solved) -> xr.Dataset:
    """Give natural frequencies where the machine is held at its positions, and how well each was followed."""
    scene, machine, t = solved.scene, solved.made.machine, solved.positions.motion.t
    about = forces_about(machine, t) if STIFFENING in scene.named_effects else None
    try:
        found = followed_modes(machine, t, about=about)
    except SolverError as error:
        raise with_buckled(solved.made, t, True, error) from error
    count = modes_kept(scene.analysis.modes, found.omega.shape[1])
    here, finer = (held_modes(x.machine, 0.0)[0][:count] for x in (solved.made, solved.finer))
    return of_modes(found.omega[:, :count], np.abs(here / finer - 1), found.assurance[:, :count])


def of_modes(omega: Array, error: Array, assurance: Array) -> xr.Dataset:
    """Label rates (rad/s) and assurances of modes ``(positions, modes)``, and their relative errors ``(modes,)``."""
    along = ("theta", "mode")
    values = {"frequency": (along, omega / (2 * np.pi)), "frequency_error": (("mode",), error)}
    return xr.Dataset(values | {"assurance": (along, assurance)}, {"mode": np.arange(1, omega.shape[1] + 1)})


def _without_vibration(solved: Solved) -> xr.Dataset:
    """Give strains and stresses of the static answer to loads and rigid inertia."""
    scene, s, motion = solved.scene, solved.positions.stations, solved.positions.motion.chart
    still = quasi_static(motion.machine, motion.t)
    acting = LinearMotion(motion, still.change, moving=False, stresses=still.stresses).acting
    assert acting is not None
    forces = along_members(solved.made, acting.found, acting.a, s, bent=False)
    return xr.Dataset(without_vibration(scene.rigidities(s), forces.axial, forces.moment))
