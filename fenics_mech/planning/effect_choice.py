"""Choosing the effects that a scene calls for, by estimates made before the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_mech._guard import guarded
from fenics_mech.accuracy.quantities import ERROR_VARIABLES
from fenics_mech.accuracy.theory_ladder import EXACT_STRAINS, LADDER, TENSION, exact_theory, judged
from fenics_mech.accuracy.validity import bow
from fenics_mech.effects import EFFECTS, active
from fenics_mech.effects.effect import Choice, Survey
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import SceneError
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.forces.section_forces import recover_members
from fenics_mech.kinematics import positions_for_corners, solve_motion
from fenics_mech.planning.survey import survey
from fenics_mech.recovery import Result
from fenics_mech.response.setup import CommonParts, mechanism, system_at
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class ChoiceLimits:
    """Limits of the choice of effects, and of its survey."""

    certain: float = 1.0  # size from which a survey shows that strains are not linear; it may be 50 times too large
    deflection: float = 0.05  # share that linear strains may leave out: they leave out all shortening
    share: float = 0.2  # of a tolerance, that each source of errors is sent below
    left_out: float = 0.3  # of a tolerance, that the effects left out may come to: steps and mesh take up to 0.7
    positions: int = 48  # of the survey
    most_positions: int = 240  # of the survey, where modes or loads need more
    modes: int = 8  # of the survey
    most_at_corners: int = 2400  # positions of it, where a tolerance chooses those of the run


CHOICE = ChoiceLimits()


@guarded()
def choose(scene: Scene, common: CommonParts | None = None) -> tuple[Scene, tuple[Choice, ...]]:
    """Give a scene with the effects that it calls for, and what was decided about every effect.

    Where a scene lists its effects itself, it comes back as it is. A motion with freedoms is not surveyed: it has exact
    strains, the coupling and what the scene states.

    Parameters
    ----------
    scene
        The scene.
    common
        What it may have in common with other scenes of a study.

    Returns
    -------
    tuple
        The scene, whose effects are listed, and the decisions.
    """
    if scene.effects != "auto":
        acting = {effect.name for effect in active(scene)}
        return scene, tuple(Choice(effect, None, name in acting) for name, effect in EFFECTS.items())
    if scene.freedoms:  # no cycle is there to be surveyed
        exact = exact_theory(scene.changed(effects=()))
        return choose(exact, common)
    return decided(scene, examine(scene, common))


Rung = tuple[Scene, tuple[Choice, ...]]  # a scene with effects, and what was decided about each


def rungs(scene: Scene, common: CommonParts | None = None) -> list[Rung]:
    """Give the theories to analyse a scene with, one after the other until one suffices; see `suffices`.

    The first has linear strains and the second exact ones. There is only one where the scene lists its effects, or its
    response cannot show what linear strains leave out, or the survey alone shows that they are wrong.

    Parameters
    ----------
    scene
        The scene.
    common
        What it may have in common with other scenes of a study.

    Returns
    -------
    list of tuple
        Of each theory the scene and what was decided about every effect, as of `choose`.
    """
    chosen, choices = choose(scene, common)
    sizes = {choice.effect.name: choice.size for choice in choices}
    strains, tension = sizes[EXACT_STRAINS], sizes[TENSION]
    if strains is None or tension is None or strains > CHOICE.certain:
        return [(chosen, choices)]
    linear = {name for name in chosen.named_effects if name != EXACT_STRAINS}
    linear |= {TENSION} if tension > scene.neglected / 2 else set()
    return [_of(choices, chosen.changed(effects=tuple(sorted(linear)))), _of(choices, exact_theory(chosen))]


def _of(choices: Sequence[Choice], scene: Scene) -> Rung:
    acting = scene.named_effects
    return scene, tuple(replace(c, acts=c.effect.name in acting) if c.effect.name in LADDER else c for c in choices)


def suffices(scene: Scene, result: Result, choices: Sequence[Choice]) -> bool:
    """Whether what the theory of a result leaves out is little enough for a scene that chooses it.

    That is half of what the scene may neglect of the strains and `CHOICE.deflection` of the deflections, or of each
    quantity's tolerance the share that any source may have.
    Where the result does not tell it, the survey decides.

    Parameters
    ----------
    scene
        The scene that is analysed.
    result
        Its result.
    choices
        What was decided about each effect.
    """
    if theory_share(result) is None:
        return not any(c.effect.name == EXACT_STRAINS and (c.size or 0.0) > scene.neglected / 2 for c in choices)
    limits = {what: CHOICE.share * most for what, most in scene.tolerances.items()} or {
        "strain": scene.neglected / 2,
        "deflection": CHOICE.deflection,
    }
    errors = result.data.sel(source="theory")
    return all(float(errors[f"{ERROR_VARIABLES[what][1]}relative_error"]) <= limit for what, limit in limits.items())


def sized(choices: Sequence[Choice], share: float | None) -> tuple[Choice, ...]:
    """Give choices with the share of the strains that an answer with linear ones leaves out, where that is known.

    Parameters
    ----------
    choices
        What was decided about each effect.
    share
        That share; None where it is not known.
    """
    if share is None:
        return tuple(choices)
    return tuple(
        replace(c, size=share) if c.effect.name == EXACT_STRAINS and c.size is not None else c for c in choices
    )


def theory_share(result: Result) -> float | None:
    """Share of the strains that the theory of a result leaves out, where it tells that.

    Parameters
    ----------
    result
        The result of an analysis.

    Returns
    -------
    float or None
        None where theory is no source of its errors.
    """
    data = result.data
    return (
        float(data["relative_error"].sel(source="theory")) if "source" in data and "theory" in data["source"] else None
    )


def examine(scene: Scene, common: CommonParts | None = None) -> Survey:
    """Survey a scene's mechanism at a few positions, in linear theory.

    There are enough of them for harmonics of the load up to twice the frequency of the second mode.

    Parameters
    ----------
    scene
        The scene.
    common
        What it may have in common with other scenes of a study.

    Raises
    ------
    SceneError
        When a load does something between the positions that they miss.
    """
    common = common or CommonParts()
    positions = survey_positions(scene, common)
    plain = scene.changed(effects=(), analysis__sub_intervals=positions)
    system = mechanism(plain, common=common)
    modes = solve_modes(system, CHOICE.modes, plain.petsc).elastic
    if scene.drives:
        wanted = min(int(4 * modes.omega[:, :2].max() / abs(scene.cycle_rate)), CHOICE.most_positions)
        if wanted > positions:
            plain = plain.changed(analysis__sub_intervals=wanted)
            motion = solve_motion(plain, plain.drive_angles(plain.analysis.sub_intervals), near=system.motion)
            system = system_at(plain, system.beams, motion)
            modes = solve_modes(system, CHOICE.modes, plain.petsc)
        _refuse_hidden(plain)
    still = solve_static(system)
    state = recover_members(system, still, np.linspace(0, 1, 11))
    tension = mean_tension(system, still)
    return survey(plain, system, modes, still.displacement, tension, bow(system.beams.mesh.member_length, state))


def _refuse_hidden(scene: Scene) -> None:
    """Raise `SceneError` where a load does something that even the most positions of a survey miss."""
    for name, load in scene.loads.items():
        if load.enough_angles(CHOICE.most_positions) > CHOICE.most_positions:
            raise SceneError(
                f"effects = 'auto' looks at the loads at {CHOICE.most_positions} positions at most, which miss what "
                "the factor of the load does between them",
                place=f"loads.{name}.factor",
                hint="List the effects, or state what changes more slowly, such as a wider pulse",
            )


def survey_positions(scene: Scene, common: CommonParts) -> int:
    """Give the positions of a survey: more where few miss a corner of the motion, up to what the run states.

    Parameters
    ----------
    scene
        The scene.
    common
        What it may have in common with other scenes of a study.
    """
    analysis = scene.analysis
    if not scene.drives or analysis.allow_coarse or analysis.method in ("static", "transient"):
        return CHOICE.positions
    most = CHOICE.most_at_corners if scene.tolerance is not None else analysis.sub_intervals
    linkage = common.linkage(scene)
    linkage.branch.over(scene.drive_angles(analysis.sub_intervals))  # as far as the run follows it
    return positions_for_corners(linkage, scene.drive_angles, analysis.method == "periodic", CHOICE.positions, most)


def _adding_up(scene: Scene, sizes: Mapping[str, float]) -> set[str]:
    """Effects without which those left out would come to more than their share of a tolerance, the largest first.

    What the theory's own error tells of an answer is not among them.
    """
    known = judged(scene.analysis.method)
    small_first = sorted((name for name in sizes if name not in known), key=sizes.__getitem__)
    sums = np.cumsum([sizes[name] for name in small_first])
    most = CHOICE.left_out * scene.neglected if scene.tolerances else np.inf
    return {name for name, added in zip(small_first, sums) if added > most}


def decided(scene: Scene, found: Survey) -> tuple[Scene, tuple[Choice, ...]]:
    """Let those effects act whose size is above half the tolerance of the analysis: what is left out adds up.

    Parameters
    ----------
    scene
        The scene.
    found
        Its survey.

    Returns
    -------
    tuple
        The scene with these effects alone, and what was decided about each.
    """
    sizes = {name: effect.size(found) for name, effect in EFFECTS.items() if effect.size is not None}
    large = {name for name, size in sizes.items() if size > scene.neglected / 2} | _adding_up(scene, sizes)
    for effect in EFFECTS.values():
        if effect.replaces in large and effect.name in large:
            large.discard(effect.replaces)
    large -= {name for name in large if EFFECTS[name].stated_by and not EFFECTS[name].stated(scene)}
    large |= {need for name in large for need in EFFECTS[name].needs if EFFECTS[need].stated(scene)}
    large -= {name for name in large if not large.issuperset(EFFECTS[name].needs)}
    missing = {name: what for name in large if (what := EFFECTS[name].missing_data(scene))}
    large -= missing.keys()
    choices: list[Choice] = []
    named = tuple(name for name, effect in EFFECTS.items() if name in large and not effect.stated(scene))
    changes: dict[str, Any] = {"effects": named}
    for name, effect in EFFECTS.items():
        stated, size = effect.stated(scene), sizes.get(name)
        acts = name in large or (stated and size is None)
        choices.append(Choice(effect, size, acts, missing.get(name, "")))
        if stated and not acts:
            changes |= effect.without
    if scene.analysis.solver == "auto":
        changes["analysis__solver"] = "collocation"  # the sub-intervals of chapter 5 would ring in slow machines
    return scene.changed(**changes), tuple(choices)
