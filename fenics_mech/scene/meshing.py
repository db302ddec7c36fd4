"""Where the nodes of a member lie, and the same scene with finer meshes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.applied_loads import LineLoad
from fenics_mech.scene.bodies import MESH, Mesh
from fenics_mech.scene.models import Scene


def nodes_of(mesh: Mesh) -> Array:
    """Nodes along a member with this mesh, 0 to 1 of its length, shape ``(elements + 1,)``."""
    if mesh.stations is not None:
        return np.array(mesh.stations)
    lengths = mesh.grading ** np.arange(mesh.elements)
    return np.concatenate([[0.0], np.cumsum(lengths)[:-1] / lengths.sum(), [1.0]])


def member_nodes(scene: Scene, label: str, loads_at_nodes: bool, traced: bool = False) -> Array:
    """Nodes along a member of a scene, 0 to 1 of its length, shape ``(elements + 1,)``."""
    # A load has a node, which replaces one of the mesh that is very near. Where it would make a short element beside a
    # long one, the long one carries it inside: the shear force of an element loses digits as the cube of its length.
    _, member = scene.members()[label]
    nodes, places = nodes_of(member.mesh or scene.mesh), np.array(scene.loaded_places(traced).get(label, []))
    distance = np.abs(nodes[:, None] - places)
    in_need = places if loads_at_nodes or not len(places) else _in_need_of_nodes(scene, label)
    needed = (distance.min(axis=0, initial=1.0) < MESH.closest) | np.isin(places, in_need)
    found = np.sort(np.concatenate([nodes[distance.min(axis=1, initial=1.0) >= MESH.closest], places[needed]]))
    for place in places[~needed]:
        before, after = found[found <= place].max(initial=0.0), found[found > place].min(initial=1.0)
        if min(place - before, after - place) >= MESH.short * (after - before):
            found = np.sort(np.append(found, place))
    return found


def _in_need_of_nodes(scene: Scene, label: str) -> list[float]:
    """Places of a member at which what acts cannot be carried inside elements."""
    # Elements carry forces exactly in linear statics, if uniform, rigid in shear and with their neutral line on the
    # axis.
    section = scene.sections[scene.members()[label][1].section]
    linear = section.constant and not scene.rigidity(label, np.zeros(1)).neutral.any()
    if not linear or scene.analysis.method not in ("static", "quasi-static"):
        return scene.loaded_places().get(label, [])
    following = [load.at for load in scene.loads.values() if not isinstance(load, LineLoad) and load.follows]
    acting = [at.split("@") for at in (*following, *(blow.at for blow in scene.impulses.values())) if "@" in at]
    return [float(place) for name, place in acting if name == label]


def refined(scene: Scene, times: int) -> Scene:
    """Halve every element of a scene a number of times; the nodes that it has stay where they are.

    Parameters
    ----------
    scene
        The scene.
    times
        How often each element is cut into two: it becomes ``2**times`` elements of equal length.

    Returns
    -------
    Scene
        The same scene with finer meshes.

    Raises
    ------
    SceneError
        When `times` is negative, or there would be more than a million elements.

    Examples
    --------
    >>> scene = fm.load("demos/four_bar.toml")
    >>> len(fm.refined(scene, 1).mesh.stations)
    7
    """
    if times < 0:
        raise SceneError(f"a mesh can be refined 0 or more times, not {times}", place="mesh")
    if times == 0:
        return scene
    elements = sum(len(nodes_of(member.mesh or scene.mesh)) - 1 for _, member in scene.members().values())
    if times > 40 or elements * 2**times > MESH.most_refined:
        what = f"refining {elements} elements {times} times gives more than {MESH.most_refined:,} elements"
        hint = "Refine less often"
        raise SceneError(what, place="mesh", hint=hint)
    return with_meshes(scene, _halved(scene.mesh, times), lambda mesh: _halved(mesh, times))


def with_halves(scene: Scene) -> Scene:
    """Halve every element that a scene is meshed with, those at loads and traced points inside members too."""
    links = dict(scene.links)
    for label, (link, member) in scene.members().items():
        nodes = member_nodes(scene, label, loads_at_nodes=True, traced=True)
        halves = np.sort(np.concatenate([nodes, (nodes[1:] + nodes[:-1]) / 2]))
        mine = {name for name, part in links[link].members.items() if part is member}
        fine = member.model_copy(update={"mesh": Mesh(stations=tuple(halves.tolist()))})
        members = {name: fine if name in mine else part for name, part in links[link].members.items()}
        links[link] = links[link].model_copy(update={"members": members})
    return scene.model_copy(update={"links": links})


def with_elements(scene: Scene, count: int) -> Scene:
    """Give every member so many elements; one whose nodes are stated has its own cut into at least that many."""

    def cut(mesh: Mesh) -> Mesh:
        if mesh.stations is None:
            return Mesh(elements=count, grading=mesh.grading ** (mesh.elements / count))
        return _halved(mesh, max(0, math.ceil(math.log2(count / mesh.count))))

    return with_meshes(scene, cut(scene.mesh), cut)


def with_meshes(scene: Scene, mesh: Mesh, own: Callable[[Mesh], Mesh | None]) -> Scene:
    """Give a scene another mesh; `own` makes that of a member which has one of its own, or None for the scene's."""
    links = {}
    for name, link in scene.links.items():
        members = {
            label: member.model_copy(update={"mesh": own(member.mesh)}) if member.mesh else member
            for label, member in link.members.items()
        }
        links[name] = link.model_copy(update={"members": members})
    return scene.model_copy(update={"links": links, "mesh": mesh})


def _halved(mesh: Mesh, times: int) -> Mesh:
    """Cut every element of a mesh into ``2**times`` of equal length."""
    nodes, parts = nodes_of(mesh), 2**times
    cut = nodes[:-1, None] + np.diff(nodes)[:, None] * np.arange(parts) / parts
    return Mesh(stations=(*cut.ravel().tolist(), 1.0))
