"""The analysis of a scene: plan, build, solve, estimate the errors, collect the result."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from fenics_mech._guard import guarded
from fenics_mech.accuracy.estimate import Errors
from fenics_mech.accuracy.joint_map_errors import naming_joints
from fenics_mech.by_poses import RefinedByPoses, by_poses
from fenics_mech.by_sub_intervals import by_sub_intervals
from fenics_mech.classical.known import has_modes
from fenics_mech.effects import active
from fenics_mech.effects.effect import Choice
from fenics_mech.effects.springs import refuse_too_stiff, wound_at_start
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.in_time_by_poses import in_time_by_poses
from fenics_mech.joints.dry_friction import creeping
from fenics_mech.kinematics import assembly_notices, reachable_range
from fenics_mech.kinematics.free_linkage import with_freedoms
from fenics_mech.mechanism import System
from fenics_mech.planning.answer_remarks import answer_remarks
from fenics_mech.planning.effect_choice import Rung, rungs, sized, suffices, theory_share
from fenics_mech.planning.fine_enough import fine_enough
from fenics_mech.planning.law_choice import choose_laws
from fenics_mech.planning.meet_tolerance import within
from fenics_mech.planning.start_state import state_to_go_on_from
from fenics_mech.recovery import Result
from fenics_mech.recovery.fields import Fields
from fenics_mech.recovery.labelled import labelled, recovered
from fenics_mech.recovery.peaks import PEAKS
from fenics_mech.repeated_by_poses import repeated_by_poses
from fenics_mech.response.periodic.known_motion import KnownMotion
from fenics_mech.response.periodic.steady_state import by_collocation, stability_of
from fenics_mech.response.setup import CommonParts, mechanism
from fenics_mech.response.solution import CollocationSolution, MotorSolution, Solution
from fenics_mech.response.solvers import SOLVERS, by_statics, check_periodic, periodic_solver
from fenics_mech.response.transient.free_motion import by_free_motion, refuse_in_time
from fenics_mech.rigid_at_rest import rigid_at_rest
from fenics_mech.rigid_by_poses import rigid_by_poses
from fenics_mech.rigid_in_time import rigid_in_time
from fenics_mech.safety.load_cases import of_cases
from fenics_mech.scene import Analysis, Scene
from fenics_mech.scene.load_cases import scenes_of, told_of_case

logger = logging.getLogger(__name__)
STEPS = ("effects", "kinematics", "beams", "modes", "response", "recovery", "errors")
Progress = Callable[[str], None]


@guarded()
def analyse(
    scene: Scene,
    progress: Progress = lambda step: None,
    common: CommonParts | None = None,
    names: Collection[str] | None = None,
) -> Result:
    """Analyse a scene as its `analysis` states.

    Parameters
    ----------
    scene
        The scene.
    progress
        Called with the name of each of `STEPS` as it begins.
    common
        What it may have in common with other analyses of a study. The result is the same, to the last bit, unless it
        begins from the last motion.
    names
        Variables that the result is to hold, with those that come with them; None for all. A scene with a tolerance
        has all of them.

    Returns
    -------
    Result
        Strains, stresses, forces, deflections, their errors, and every decision that was taken. Mesh and steps that
        the scene does not state are as fine as the answer needs; those that it states are kept, and the errors told.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at some drive angle.
    SolverError
        When a solver does not converge, or an error is too large.
    SceneError
        When a periodic response is asked for and nothing is driven.

    Examples
    --------
    >>> result = fm.analyse(fm.load("demos/four_bar.toml").changed({"analysis.sub_intervals": 90}))
    >>> print(f"{abs(result.data['strain'].sel(member='coupler')).max().item():.4f}")
    0.0003
    """
    if scene.cases:
        return _of_cases(scene, progress, common or CommonParts(), names)
    _refuse_undriven(scene)
    progress("effects")
    common = common or CommonParts()
    of_start = assembly_notices(scene)
    scene, _ = choose_laws(stated := scene)
    may_rest = scene.analysis.method == "static" and (scene.freedoms or not scene.members())
    if scene.analysis.method == "transient" or may_rest:
        scene = with_freedoms(scene)
    if not scene.members():
        progress("response")
        result = fine_enough(scene, lambda finer: _of_rigid_links(finer, stated))
    elif scene.analysis.method == "transient" and scene.analysis.start == "periodic":
        result = fine_enough(scene, repeated_by_poses)
    elif scene.tolerance is None and has_modes(scene):
        result = fine_enough(scene, lambda finer: by_sub_intervals(finer, names))
    elif scene.analysis.method == "transient":
        result = fine_enough(scene, in_time_by_poses)
    elif scene.tolerance is None:
        last = common.last
        result = fine_enough(scene, lambda finer: by_poses(finer, last, names))
    else:
        result = within(scene.changed(analysis__solver="poses"), RefinedByPoses())
    said = [*of_start, *wound_at_start(stated, scene), *creeping(scene)]
    result.data.attrs.update(answer_remarks(scene, result, said))
    return result


def _of_rigid_links(scene: Scene, stated: Scene) -> Result:
    """Analyse a scene of which no link bends; `stated` may leave open where its freedoms are."""
    start = state_to_go_on_from(scene, 0)
    if not scene.freedoms:
        return rigid_by_poses(scene)
    if scene.analysis.method == "static":
        return rigid_at_rest(scene, any(part.start is not None for part in stated.freedoms.values()))
    return rigid_in_time(scene, start)


def _of_cases(scene: Scene, progress: Progress, common: CommonParts, names: Collection[str] | None) -> Result:
    """Analyse a scene in each of its load cases, and give the result of the governing one with all of them."""
    found = {}
    for name, case in scenes_of(scene).items():
        with told_of_case(name):
            found[name] = analyse(case, progress, common, names)
    return of_cases(scene, found)


def _by_rungs(
    scene: Scene,
    progress: Progress,
    common: CommonParts,
    laws: tuple[Choice, ...],
    names: Collection[str] | None,
) -> Result:
    """Analyse a scene with linear strains, and where its answer shows that they do not suffice, with exact ones.

    `laws` is what was decided about its joint laws.
    """
    *linear, (exact, choices) = rungs(scene, common)
    for rung, decided in linear:
        try:
            result = as_planned(rung, (*decided, *laws), progress, common, names)
        except SolverError as error:  # linear strains may buckle, or meet a resonance, where exact ones do not
            if error.finer:  # which exact strains do not cure
                raise
            logger.info("linear strains have no answer: %s", error)
            continue
        if suffices(scene, result, decided):
            return result
        share = theory_share(result)
        logger.info("linear strains do not suffice: the theory's share is %s", share)
        choices = sized(choices, share)
    return as_planned(exact, (*choices, *laws), progress, common, names)


def as_planned(
    scene: Scene,
    choices: Sequence[Choice],
    progress: Progress = lambda step: None,
    common: CommonParts | None = None,
    names: Collection[str] | None = None,
) -> Result:
    """Analyse a scene with the effects, the mesh and the steps that it states: build, solve, estimate, collect.

    Parameters
    ----------
    scene
        The scene, with its effects chosen.
    choices
        What was decided about each effect, for the result to say.
    progress
        Called with the name of each of `STEPS` as it begins.
    common
        What it may have in common with other analyses of a study.
    names
        As of `analyse`.

    Returns
    -------
    Result
        With the name of the solver in its attributes.

    Raises
    ------
    SceneError
        When the scene has what its solver does not solve.
    UnresolvedError
        When a torsional spring is too stiff for the elements beside it, or an error is too large.
    SolverError
        When a solver does not converge.
    """
    return solved(scene, choices, progress, common, names)[1]


def solved(
    scene: Scene,
    choices: Sequence[Choice] = (),
    progress: Progress = lambda step: None,
    common: CommonParts | None = None,
    names: Collection[str] | None = None,
) -> tuple[Solution, Result]:
    """Analyse a scene as `as_planned` does, and give the solution too."""
    common = common or CommonParts()
    solution, solver = _answer(scene, progress, common)
    fields, errors = recovered(solution, choices, progress)
    common.answered(solution, fields, choices)
    result = labelled(solution, fields, errors, _by_errors(choices, errors), names, common)
    result.data.attrs["solver"] = solver
    return solution, result


def _answer(
    scene: Scene, progress: Progress, common: CommonParts, near: KnownMotion | None = None
) -> tuple[Solution, str]:
    """Build the mechanism of a scene and solve for its response, and name the solver."""
    refuse_too_stiff(scene)
    system = mechanism(scene, progress, common)
    names = ", ".join(effect.name for effect in active(scene))
    logger.info("%d coordinates, %d positions, effects: %s", system.size, len(system.motion.theta), names)
    solution, solver = solve(scene, system, progress, near or common.near(system.beams), common.keep)
    logger.info("solved by %s", solver)
    return solution, solver


@dataclass(frozen=True)
class _Trial:
    """What is known by an analysis with one discretisation."""

    solution: Solution
    solver: str
    fields: Fields
    errors: Errors
    choices: Sequence[Choice]


@dataclass
class RefinedAnalysis:
    """Analyses with one discretisation after the other, of which only that which is kept is whole.

    Each begins from what is known by the one before: its motion, or where only the stations are others, its solution.

    Parameters
    ----------
    progress, common
        As of `analyse`.
    theory
        Whether what the theory leaves out decides on a trial.
    """

    progress: Progress
    common: CommonParts
    theory: bool
    _last: _Trial | None = None

    def theories(self, scene: Scene) -> list[Rung]:
        """Give a scene with the effects of each theory that may answer it."""
        return rungs(scene, self.common)

    def analyse(self, trial: Scene, choices: Sequence[Choice]) -> Result:
        """Analyse a scene as it states, and give as much as tells whether it is within its tolerance.

        Parameters
        ----------
        trial
            The scene.
        choices
            What was decided about each effect.
        """
        unjudged, known = trial.changed(analysis__stability=False), None
        if self._last is not None and _but_for_stations(self._last.solution.scene) == _but_for_stations(unjudged):
            solution, solver = replace(self._last.solution, scene=unjudged), self._last.solver
            known = self._last.errors
        else:
            near, self._last = _known(self._last), None
            solution, solver = _answer(unjudged, self.progress, self.common, near)
        fields, errors = recovered(solution, choices, self.progress, known, self.theory)
        assert errors is not None  # by which a tolerance is judged
        self._last = _Trial(solution, solver, fields, errors, choices)
        return labelled(solution, fields, errors, _by_errors(choices, errors), PEAKS)

    def judge(self, allow_unstable: bool) -> None:
        """Judge the stability of the last motion, if its kind has one.

        Parameters
        ----------
        allow_unstable
            Whether an unstable motion passes.

        Raises
        ------
        SolverError
            When the motion is unstable, or at an undamped resonance.
        """
        if self._last is not None and isinstance(solution := self._last.solution, CollocationSolution):
            judged = replace(solution, stability=stability_of(solution, allow_unstable))
            self._last = replace(self._last, solution=judged)

    def refuse_missed(self, allow_coarse: bool) -> None:
        """Raise `UnresolvedError` where the positions of the last trial surely miss peaks, unless that is to pass."""
        assert self._last is not None
        if not allow_coarse:
            self._last.errors.refuse_missed(self._last.solution.scene)

    def whole(self) -> Result:
        """Give the whole result of the last trial."""
        assert self._last is not None
        last = self._last
        errors = last.errors if self.theory else last.errors.with_theory(last.solution, last.choices)
        result = labelled(last.solution, last.fields, errors, _by_errors(last.choices, errors), common=self.common)
        result.data.attrs["solver"] = last.solver
        return result


def _but_for_stations(scene: Scene) -> Scene:
    return scene.changed(analysis__stations=Analysis().stations)


def _known(trial: _Trial | None) -> KnownMotion | None:
    """Give the motion of a trial for Newton's method to begin from."""
    solution = trial.solution if trial else None
    if not isinstance(solution, CollocationSolution) or isinstance(solution, MotorSolution):
        return None
    return KnownMotion.of(solution.cycle.at_points(solution.cycle.tableau), solution.orbit)


def solve(
    scene: Scene,
    system: System,
    progress: Progress = lambda step: None,
    near: KnownMotion | None = None,
    found: Callable[[KnownMotion], None] = lambda motion: None,
) -> tuple[Solution, str]:
    """Solve for the response of a mechanism by the method of its scene, and name the solver.

    Parameters
    ----------
    scene
        The scene, with its effects chosen.
    system
        Its mechanism.
    progress
        Called with the name of each of `STEPS` as it begins.
    near
        A motion beside the one that is sought, from which collocation may begin.
    found
        Called with the motion that collocation finds under exact strains, stable or not.

    Returns
    -------
    tuple
        The solution, and the solver's name; for other than periodic responses that of the method.

    Raises
    ------
    SceneError
        When the scene has what its solver does not solve.
    SolverError
        When the solver does not converge.
    """
    method = str(scene.analysis.method)
    if method != "periodic":
        progress("response")
        if method != "transient":
            return by_statics(scene, system), method
        refuse_in_time(scene.analysis, system)
        return by_free_motion(scene, system, state_to_go_on_from(scene, system.size)), method
    solver = periodic_solver(scene.analysis, active(scene))
    check_periodic(scene, system, solver)
    progress("modes")
    modes = solve_modes(system, scene.analysis.modes, scene.petsc)
    progress("response")
    if SOLVERS[solver] is by_collocation:
        with naming_joints(scene, system, lambda: modes):
            return by_collocation(scene, system, modes, near, found), solver
    return SOLVERS[solver](scene, system, modes), solver


def collected(
    solution: Solution,
    choices: Sequence[Choice] = (),
    progress: Progress = lambda step: None,
    names: Collection[str] | None = None,
) -> Result:
    """Recover the fields of a solution, estimate their errors, and collect all in a result.

    Parameters
    ----------
    solution
        What a solver of `response` gave.
    choices
        What was decided about each effect.
    progress
        Called with the name of each of `STEPS` as it begins.
    names
        As of `analyse`.

    Raises
    ------
    UnresolvedError
        When a numerical error is too large.
    SolverError
        When deflections are beyond the theory, or something is not finite.
    """
    fields, errors = recovered(solution, choices, progress)
    return labelled(solution, fields, errors, _by_errors(choices, errors), names)


def _by_errors(choices: Sequence[Choice], errors: Errors | None) -> Sequence[Choice]:
    """Give what was decided about effects with the size of the theory's error, where that is known."""
    return choices if errors is None else sized(choices, errors.relative("strain").get("theory"))


def _refuse_undriven(scene: Scene) -> None:
    """Raise `SceneError` where a periodic response is asked for and nothing is driven."""
    if scene.analysis.method == "periodic" and not scene.drives:
        free = "".join(f"; {freedom}" for freedom in reachable_range(scene).free)
        raise SceneError(
            f"a periodic response needs a drive, and the scene has none: there is no period{free}",
            place="analysis.method",
            hint="Add a [drive], or write method = 'quasi-static'",
        )
