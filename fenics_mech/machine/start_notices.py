"""What is said about the assembly in which the links of a scene start."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import AssemblyError
from fenics_mech.machine.assembly import KEPT, MET, SAME, closed, units_of
from fenics_mech.machine.drawn_from_scene import LISTED, Bodies, drawn_bodies, put_together
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.joints import Joint, Weld

DOUBTFUL = np.pi / 4  # of a link without a rough angle (rad): beyond it nobody chose its assembly
TURNED = 1e-4  # rad, by which a link lies in another way


def assembly_notices(scene: Scene) -> tuple[str, ...]:
    """Say which assembly is taken at the start where the scene does not choose one, and how to choose, or nothing."""
    stated = [name for name, freedom in scene.freedoms.items() if freedom.start is not None]
    try:
        bodies = put_together(scene, scene.joints, stated)
    except AssemblyError:  # the analysis says it
        return ()
    names, free = list(scene.links), _free_links(bodies)
    missing = [i for i in free if not scene.links[names[i]].angle]
    loose = len(bodies.machine.rows) < bodies.machine.n
    far = [i for i in missing if abs(math.remainder(bodies.links[3 * i + 2], TURN)) > DOUBTFUL]
    if not bodies.searched and (loose or not far):
        return ()
    found = bodies.search().q
    others = [q for q in found if not _same(bodies, q, bodies.q)]
    if not loose and not others and (missing or not bodies.searched):
        return ()
    listed = [names[i] for i in missing]
    among = " and ".join([*([", ".join(listed[:-1])] if listed[:-1] else []), *listed[-1:]])
    why = f"no rough angle is given for {among}" if missing else "the rough angles lead to no assembly"
    any_more = " or more" if len(others) + 1 >= KEPT else ""
    ways = "in many ways" if loose else f"in {1 + len(others)} ways{any_more}" if others else "in one way"
    said = [f"Taken is {_as_keys(bodies, free, bodies.q)}"]
    said += [f"or {_as_keys(bodies, free, q)}" for q in others[:LISTED]]
    more = len(others) - LISTED
    said += [f"and {more} more"] if more > 0 else []
    return (
        f"links: {why}, and the linkage closes {ways} at the start. {'; '.join(said)}. Write the one that is meant",
    )


def _same(bodies: Bodies, q: Array, other: Array) -> bool:
    """Say whether two positions are one, but for whole turns."""
    apart = (q - other)[: bodies.machine.n] / units_of(bodies.machine)
    apart[2::3] -= TURN * np.round(apart[2::3] / TURN)
    return bool(np.abs(apart).max(initial=0.0) < SAME)


def _free_links(bodies: Bodies) -> Sequence[int]:
    """Give links whose angle neither a drive nor a joint gives."""
    scene, held = bodies.scene, {"ground"}
    angled: list[Joint] = [joint for joint in bodies.joints.values() if isinstance(joint, Weld | Prismatic)]
    angled += [scene.joints[name] for name in bodies.laws if not isinstance(scene.joints[name], Slot | Prismatic)]
    pairs = [{point.split(".")[0] for point in joint.connect[:2]} for joint in angled]
    while more := [pair for pair in pairs if pair & held and not pair <= held]:
        held.update(*more)
    return [i for i, name in enumerate(scene.links) if name not in held]


def _as_keys(bodies: Bodies, free: Sequence[int], q: Array) -> str:
    """Write an assembly as keys of a scene file; of another than the taken one what differs from it."""
    scene, names = bodies.scene, list(bodies.scene.links)
    links, taken = bodies.drawn + q[: bodies.machine.n], bodies.links
    other = not _same(bodies, q, bodies.q)
    turned = np.abs(np.remainder((links - taken)[2::3] + np.pi, TURN) - np.pi)
    angles = {i: math.remainder(links[3 * i + 2], TURN) for i in free}
    keys = {i: [f'angle = "{round(np.degrees(x), 4) + 0.0:.4g} deg"'] for i, x in angles.items()}
    keys = {i: key for i, key in keys.items() if not other or turned[i] > TURNED}
    stated = {names[i]: scene.links[names[i]].model_copy(update={"angle": x}) for i, x in angles.items()}
    led = drawn_bodies(scene.model_copy(update={"links": {**scene.links, **stated}}), bodies.joints, bodies.freedoms)
    (there,), gap = closed(led.machine, 0.0, led.q[None])
    same = np.append(led.drawn - bodies.drawn, np.zeros(len(q) - len(links))) + there
    if gap[0] >= MET or not _same(bodies, same, q):
        for i in range(len(names)):
            keys.setdefault(i, []).append(f"position = [{links[3 * i]:.6g}, {links[3 * i + 1]:.6g}]")
    return ", ".join(f"[links.{names[i]}] {', '.join(parts)}" for i, parts in sorted(keys.items()))
