"""The position from which a linkage sets out: from the rough angles of its links, or by a search where they fail."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import AssemblyError, MechanismError
from fenics_mech.kinematics.assemblies import SEARCH, every_assembly, same
from fenics_mech.kinematics.assembly import ASSEMBLY, degrees, follow_branch, newton
from fenics_mech.kinematics.loops import Loops
from fenics_mech.scene import Link, Scene
from fenics_mech.scene.numbering import GROUND, order_of


@dataclass(frozen=True)
class ChoiceLimits:
    """Limits of the choice between assemblies, and of what is said about it."""

    doubtful: float = np.pi / 4  # of a link without a rough angle (rad): beyond it nobody chose its assembly
    tried: int = 8  # assemblies of which the first is taken that lets the drive run through its cycle
    listed: int = 3  # beside the taken one, in a message
    kept: int = 8  # searches whose answers are kept: an analysis asks for its start several times


CHOICE = ChoiceLimits()


@dataclass(frozen=True)
class Start:
    """How a linkage is assembled at the start."""

    q: Array  # its coordinates, (3 links,)
    searched: bool  # whether its rough angles led to no assembly


_searches: list[tuple[object, tuple[Array, ...]]] = []


def assemble(loops: Loops) -> Array:
    """Coordinates of the assembled linkage at theta = 0; shape ``(3 links,)``."""
    # They follow from the links' rough angles. Where these lead to no assembly, all assemblies are searched for.
    # Taken is the nearest to the rough angles that lets the drive run through its cycle; see `assembly_notices`.
    return _start(loops).q


def assembly_notices(scene: Scene) -> tuple[str, ...]:
    """Say which assembly is taken at the start where the scene does not choose one, and how to choose.

    Parameters
    ----------
    scene
        The linkage.

    Returns
    -------
    tuple of str
        One sentence or none. Where the links cannot be assembled there is none, as the analysis says it.

    Examples
    --------
    >>> assembly_notices(fm.load("demos/four_bar.toml"))
    ()
    """
    stated = {name: part for name, part in scene.freedoms.items() if part.start is not None}
    loops = Loops.of(scene.model_copy(update={"joint_laws": {}, "freedoms": stated}))
    try:
        start = _start(loops)
    except AssemblyError:
        return ()
    missing = [loops.links[i] for i in _free_links(loops) if not _link(loops, i).angle]
    loose = len(loops.names) < len(start.q)
    far = [i for i in _free_links(loops) if loops.links[i] in missing and _away(start.q, i, 0.0) > CHOICE.doubtful]
    if not start.searched and (loose or not far):
        return ()
    others = [q for q in _found(loops) if not same(loops, q, start.q)]
    if not loose and not others and (missing or not start.searched):
        return ()
    why = f"no rough angle is given for {_listed(missing)}" if missing else "the rough angles lead to no assembly"
    any_more = " or more" if len(others) + 1 >= SEARCH.most_kept else ""
    ways = "in many ways" if loose else f"in {1 + len(others)} ways{any_more}" if others else "in one way"
    said = [f"Taken is {_as_keys(loops, start.q, start.q)}"]
    said += [f"or {_as_keys(loops, q, start.q)}" for q in others[: CHOICE.listed]]
    more = len(others) - CHOICE.listed
    said += [f"and {more} more"] if more > 0 else []
    return (
        f"links: {why}, and the linkage closes {ways} at the start. {'; '.join(said)}. Write the one that is meant",
    )


def _start(loops: Loops) -> Start:
    """Assemble a linkage from its rough angles, or else take one of its assemblies."""
    _refuse_contradicted(loops)
    drive = loops.drive(np.zeros(1)).value
    q, converged = newton(loops, _rough(loops)[None], drive, iterations=100, damped=True)
    astray = _astray(loops, q[0]) if converged[0] else None
    if converged[0] and astray is None:
        return Start(q[0], searched=False)
    found = _found(loops)
    if not found:
        raise AssemblyError(_impossible(loops, drive[0]))
    if astray is not None and not (found := tuple(q for q in found if _astray(loops, q) is None)):
        i = astray
        known = "; ".join(_as_keys(loops, q, q) for q in _found(loops)[: CHOICE.listed])
        raise AssemblyError(
            f"at drive angle 0 link {loops.links[i]} came to lie at {degrees(q[0, 3 * i + 2])}, far from its rough "
            f"angle {degrees(_link(loops, i).angle)}: give rough angles nearer to the intended position. The linkage "
            f"can be assembled as {known}"
        )
    if len(loops.names) < len(found[0]) or len(found) == 1:
        return Start(found[0], searched=True)
    running = (q for q in found[: CHOICE.tried] if _runs(loops, q))
    return Start(next(running, found[0]), searched=True)


def _rough(loops: Loops) -> Array:
    return _place_links(loops, loops.drive(np.zeros(1)).value[0], np.array([link.angle for link in _links(loops)]))


def _found(loops: Loops) -> tuple[Array, ...]:
    """Search for all assemblies at the start, or give what the last searches found."""
    asked = (geometry(loops.scene), loops.scene.open_joints)
    for known, answer in _searches:
        if known == asked:
            return answer
    answer = tuple(every_assembly(loops, _rough(loops), loops.drive(np.zeros(1)).value[0]).q)
    _searches.append((asked, answer))
    del _searches[: -CHOICE.kept]
    return answer


def _runs(loops: Loops, q: Array) -> bool:
    """Whether the drives lead an assembly through their whole cycle."""
    if not loops.scene.drives or loops.scene.freedoms:
        return True
    try:
        follow_branch(loops, q, np.array([0.0, math.copysign(TURN, loops.scene.cycle_rate)]))
    except MechanismError:
        return False
    return True


def _astray(loops: Loops, q: Array) -> int | None:
    """Give the first link that lies far from its rough angle; None where all are near."""
    for i in range(len(loops.links)):
        rough = _link(loops, i).angle
        if rough and i not in loops.driven_angles.body and _away(q, i, rough) > ASSEMBLY.farthest_from_guess:
            return i
    return None


def _impossible(loops: Loops, drive: Array) -> str:
    """Say which joint stays open, and by how much, where the others are closed as well as they can be."""
    nearest = every_assembly(loops, _rough(loops), drive)
    gaps = loops.gaps(_place_links(loops, drive, nearest.rest[2::3]))
    worst = max(nearest.joints & gaps.keys() or gaps, key=gaps.__getitem__)
    return (
        f"the links cannot be assembled at drive angle 0{_driven_to(loops, drive)}: joint {worst} stays open by "
        f"{gaps[worst]:.3g} m at least. Check lengths, places of joints, and where the drive starts"
        f"{_closing_start(loops, drive)}"
    )


def _driven_to(loops: Loops, drive: Array) -> str:
    """Say where the drives hold the linkage."""
    turned = zip(loops.driven_angles.name, drive[list(loops.drive_order)])
    slid = zip(loops.driven_strokes.name, drive[list(loops.drive_order)][len(loops.driven_angles) :])
    held = [f"joint {name} at {degrees(angle)} from the x axis of its first body" for name, angle in turned]
    held += [f"joint {name} at {stroke:.6g} m" for name, stroke in slid]
    return f", with {' and '.join(held)}" if held else ""


def _closing_start(loops: Loops, drive: Array) -> str:
    """Name a start of a single turning drive at which the linkage closes, the nearest; nothing where there is none."""
    if loops.driven_strokes.name or len(loops.driven_angles) != 1:
        return ""
    for away in np.radians([sign * step for step in range(10, 190, 10) for sign in (1, -1)]):
        if len(every_assembly(loops, _rough(loops), drive + away).q):
            return f": with {loops.driven_angles.name[0]} at {degrees(float(drive[0] + away))} the links close"
    return ""


def _links(loops: Loops) -> Sequence[Link]:
    return tuple(loops.scene.links.values())


def _link(loops: Loops, i: int) -> Link:
    return _links(loops)[i]


def _away(q: Array, i: int, angle: float) -> float:
    return abs(math.remainder(q[3 * i + 2] - angle, TURN))


def _free_links(loops: Loops) -> list[int]:
    """Links whose angle neither a drive nor a joint gives."""
    held = {GROUND}
    pairs = [set(pair) for kind in (loops.angles, loops.driven_angles) for pair in kind.body.tolist()]
    while more := [pair for pair in pairs if pair & held and not pair <= held]:
        held.update(*more)
    return [i for i in range(len(loops.links)) if i not in held]


def _as_keys(loops: Loops, q: Array, taken: Array) -> str:
    """Write an assembly as keys of a scene file; of another than the taken one what differs from it."""
    other = not same(loops, q, taken)
    shown = [i for i in _free_links(loops) if not other or _away(q, i, taken[3 * i + 2]) > 1e-4]
    angles = np.array([link.angle for link in _links(loops)])
    for i in _free_links(loops):
        angles[i] = math.remainder(q[3 * i + 2], TURN)
    drive = loops.drive(np.zeros(1)).value
    led, closed = newton(loops, _place_links(loops, drive[0], angles)[None], drive, iterations=100, damped=True)
    enough = bool(closed[0]) and same(loops, led[0], q)
    keys = {i: [f'angle = "{round(np.degrees(angles[i]), 4) + 0.0:.4g} deg"'] for i in shown}
    for i in range(len(loops.links)) if not enough else ():
        keys.setdefault(i, []).append(f"position = [{q[3 * i]:.6g}, {q[3 * i + 1]:.6g}]")
    return ", ".join(f"[links.{loops.links[i]}] {', '.join(parts)}" for i, parts in sorted(keys.items()))


def _listed(names: Sequence[str]) -> str:
    return " and ".join([*([", ".join(names[:-1])] if names[:-1] else []), names[-1]])


def geometry(scene: Scene) -> tuple[object, ...]:
    """Give what the positions of a scene's links depend on: equal for scenes whose links move alike."""
    links = {
        name: (link.points, link.angle, link.position, {label: part.ends for label, part in link.members.items()})
        for name, link in scene.links.items()
    }
    drives = [(drive.joint, drive.start, drive.law, drive.turns_in(scene.cycle_rate)) for drive in scene.drives]
    return order_of(scene), links, scene.ground, scene.joints, drives, scene.freedoms


def _refuse_contradicted(loops: Loops) -> None:
    """Raise `AssemblyError` where rough angles contradict a joint that leaves its two bodies no angle between them."""
    driven = loops.driven_angles.body  # a drive gives the angle of these, whatever their rough ones are
    rough = {i: link.angle for i, link in enumerate(loops.scene.links.values()) if link.angle and i not in driven}
    rough[GROUND] = 0.0
    for joint, (first, second), held in zip(loops.angles.name, loops.angles.body.tolist(), loops.angles.angle):
        if first not in rough or second not in rough:
            continue
        stated = rough[second] - rough[first]
        if abs(math.remainder(stated - held, 2 * math.pi)) > ASSEMBLY.farthest_from_held:
            names = [f"link {loops.links[i]}" if i != GROUND else "the ground" for i in (first, second)]
            raise AssemblyError(
                f"joint {joint} holds {names[1]} at {degrees(held)} to {names[0]}, and their rough angles say "
                f"{degrees(math.remainder(stated, 2 * math.pi))}. Give the angle that the joint demands, or none"
            )


def _place_links(loops: Loops, drive: Array, angles: Array) -> Array:
    """Rough coordinates: rough angles, and each link put where its first joint with a placed body lies."""
    q = np.zeros((len(loops.links) + 1, 3))
    q[:-1, 2] = angles
    for (first, second), i in zip(loops.driven_angles.body, loops.drive_order):
        if second != GROUND:
            q[second, 2] = q[first, 2] + drive[i]
        else:
            q[first, 2] = -drive[i]
    placed = {GROUND}
    for i, link in enumerate(loops.scene.links.values()):
        if link.position is not None:
            q[i, :2] = link.position
            placed.add(i)
    pairs = [(tuple(body), point) for kind in (loops.points, loops.lines) for body, point in zip(kind.body, kind.point)]
    while True:
        for (a, b), (point_a, point_b) in pairs:
            if (a in placed) != (b in placed):
                known, new, at, arm = (a, b, point_a, point_b) if a in placed else (b, a, point_b, point_a)
                q[new, :2] = q[known, :2] + _turned(at, q[known, 2]) - _turned(arm, q[new, 2])
                placed.add(int(new))
                break
        else:
            if not (afloat := set(range(len(loops.links))) - placed):
                return q[:-1].reshape(-1)
            placed.add(min(afloat))  # nothing leads from the ground to it


def _turned(point: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])
