"""Checks of freedoms, and of what motions with freedoms may be asked for."""

from __future__ import annotations

from fenics_mech.errors import SceneError
from fenics_mech.scene.analysis_options import STATED_STARTS
from fenics_mech.scene.base import check_known, known
from fenics_mech.scene.scene_data import SceneData
from fenics_mech.scene.state_factors import StateFactor

MOVE_IN_TIME = (
    "move in time: write method = 'transient', with start = 'periodic' for a motion that repeats, or 'static' for an "
    "equilibrium of freedoms"
)
NO_DURATION = "a motion that nothing drives needs its duration, such as '2 s'"


def check_freedoms(scene: SceneData) -> None:
    """Raise `SceneError` where a freedom is at a joint that has none, or a motion is asked for more than it has."""
    _check_places(scene)
    if scene.freedoms or (scene.joint_laws and scene.members()):
        _check_free_motion(scene)
    _check_cycles(scene)
    _check_impulses(scene)
    _check_factors(scene)


def _check_places(scene: SceneData) -> None:
    """Raise where a freedom is at a joint that has none."""
    driven = {drive.joint for drive in scene.drives}
    for name, freedom in scene.freedoms.items():
        place = f"freedoms.{name}"
        joint = known(scene.joints, name, "joint", place)
        if name in driven:
            raise SceneError(f"joint {name!r} is driven, and has no freedom left", place=place)
        if joint.kind == "weld" or len(joint.connect) != 2:
            raise SceneError(
                "a freedom is the angle or the stroke of a joint of two bodies, which is no weld", place=place
            )
        if freedom.inertia and joint.kind != "revolute":
            hint = "Put a point mass on the second body"
            raise SceneError("what slides has no moment of inertia", place=f"{place}.inertia", hint=hint)
        turns_only = getattr(freedom.effort, "kind", "") in ("dc-motor", "induction-motor")
        if turns_only and joint.kind != "revolute":
            raise SceneError("a motor's torque acts at a revolute joint", place=f"{place}.effort")


def _check_impulses(scene: SceneData) -> None:
    """Raise where impulses strike at a time that the motion does not have, or beside what does not know them."""
    free = bool(scene.freedoms) or bool(scene.joint_laws) or not scene.members()
    for name, impulse in scene.impulses.items():
        if impulse.time is not None and not (free and scene.analysis.method == "transient"):
            what = "an impulse at a `time` is of motions in time with freedoms, joint laws or rigid links"
            hint = "State the drive's `angle` at which it strikes, or the [freedoms] that move by themselves"
            raise SceneError(what, place=f"impulses.{name}.time", hint=hint)
        if impulse.angle is not None and not scene.drives:
            raise SceneError("nothing is driven", place=f"impulses.{name}.angle", hint="State the `time` of the blow")
    if scene.analysis.start in STATED_STARTS:
        refuse_late_impulses(scene, 0.0)
    if not scene.impulses or not free:
        return
    rubs = next((name for name, law in scene.joint_laws.items() if law.kind == "friction"), None)
    refused = (
        (rubs is not None, f"joint_laws.{rubs}", "friction at the instant of an impulse is not known"),
        (scene.analysis.start == "periodic", "impulses", "a motion is made to repeat without impulses"),
        (scene.analysis.lyapunov, "impulses", "Lyapunov exponents are of motions without impulses"),
    )
    for wrong, place, why in refused:
        if wrong:
            raise SceneError(why, place=place)


def _check_factors(scene: SceneData) -> None:
    """Raise where the factor of a load goes by what the motion does not have."""
    free = bool(scene.freedoms) or not scene.members()
    for name, load in scene.loads.items():
        place = f"loads.{name}.factor"
        if load.over_cycle is not None and not scene.drives:
            raise SceneError(
                "the factor goes by the angle of a drive, and nothing is driven",
                place=place,
                hint="State it over time or a joint: factor = { kind = 'formula', formula = 'sin(5 * t)' } in seconds, "
                "or formula = '-2 * rate' with joint = 'O'",
            )
        if not isinstance(load.factor, StateFactor):
            continue
        if not free:
            what = "a factor over time or a joint acts in motions with freedoms and on rigid links"
            hint = "Where drives lead links that bend, state it over theta: kind = 'expression'"
            raise SceneError(what, place=place, hint=hint)
        if load.factor.joint is not None:
            joint = known(scene.joints, load.factor.joint, "joint", f"{place}.joint")
            if joint.kind == "weld" or len(joint.connect) != 2:
                raise SceneError("a place and a rate are those of a joint of two bodies", place=f"{place}.joint")


def refuse_late_impulses(scene: SceneData, start: float) -> None:
    """Raise `SceneError` where an impulse strikes after the end of a motion that goes on from `start` (s)."""
    for name, impulse in scene.impulses.items():
        if impulse.time is None or not (scene.drives or scene.analysis.duration):
            continue
        end = start + scene.period * (scene.analysis.cycles if scene.drives else 1)
        if impulse.time >= end:
            what = f"it would strike at {impulse.time:.6g} s, and the motion ends at {end:.6g} s"
            hint = "Let the motion go on for longer, or leave the impulse out"
            raise SceneError(what, place=f"impulses.{name}.time", hint=hint)


def _check_cycles(scene: SceneData) -> None:
    """Raise where what only a motion of freedoms has is asked of another."""
    analysis = scene.analysis
    cyclic = analysis.start == "periodic"
    asked = {"start = 'periodic'": cyclic, "lyapunov": analysis.lyapunov, "poincare": analysis.poincare is not None}
    for name, wanted in asked.items():
        place = f"analysis.{name.partition(' ')[0]}"
        if wanted and analysis.method != "transient":
            raise SceneError(f"{name} is of motions in time", place=place, hint="Write method = 'transient'")
        if wanted and not scene.freedoms:
            hint = "State the joint that moves by itself under [freedoms]; drives alone have method = 'periodic'"
            raise SceneError(f"{name} is of motions with freedoms, and the scene states none", place=place, hint=hint)
    if cyclic and any(drive.run_up is not None for drive in scene.drives):
        raise SceneError("a motion that repeats has no run-up", place="drive.run_up")
    if cyclic and analysis.lyapunov:
        hint = "Leave it out: the result of a motion that repeats has `growth_rate`, from its multipliers"
        raise SceneError("one cycle is too short for Lyapunov exponents", place="analysis.lyapunov", hint=hint)
    if analysis.start_time is not None and analysis.start in STATED_STARTS:
        what = f"a motion with start = {analysis.start!r} begins at time 0"
        hint = "Leave it out, or give the file of a result as `start`"
        raise SceneError(what, place="analysis.start_time", hint=hint)
    if analysis.repeats > 1 and not cyclic:
        hint = "Write start = 'periodic', or leave it out"
        raise SceneError("only a motion that repeats counts cycles until it does", place="analysis.repeats", hint=hint)
    section = analysis.poincare
    if section is None:
        return
    if section.joint is not None:
        check_known(section.joint, scene.freedoms, "freedom", "analysis.poincare.joint")
    elif section.every is None and not scene.drives:
        what = "nothing is driven, and the section has neither a period nor a place"
        hint = "Give `every`, such as '2 s', or the `joint` of a freedom"
        raise SceneError(what, place="analysis.poincare", hint=hint)


def _check_free_motion(scene: SceneData) -> None:
    """Raise where a scene asks for more than a motion with freedoms, or with joint laws of links that bend, has."""
    what = "freedoms" if scene.freedoms else "joint laws of links that bend"
    in_time, rests = scene.analysis.method == "transient", scene.analysis.method == "static" and bool(scene.freedoms)
    lasts = bool(scene.drives) or scene.analysis.duration is not None
    refused = (
        (not in_time and not rests, "analysis.method", f"{what} {MOVE_IN_TIME}"),
        (in_time and not lasts, "analysis.duration", NO_DURATION),
        (scene.tolerance is not None, "tolerance", f"a motion with {what} is not made to a tolerance of its result"),
    )
    for wrong, place, why in refused:
        if wrong:
            raise SceneError(why, place=place)
