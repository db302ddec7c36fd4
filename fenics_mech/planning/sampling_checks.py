"""Refusal of positions that are too many for the memory, or too few for what happens between them."""

from __future__ import annotations

import math

from fenics_mech._guard import require_memory
from fenics_mech.effects import active, loads_at_nodes
from fenics_mech.errors import SceneError
from fenics_mech.planning.cycle_steps import loads_with_hidden_peaks
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import member_nodes
from fenics_mech.scene.sampling import SAMPLING

CUT = "Write analysis.method = 'periodic' and solver = 'collocation', whose steps are cut at corners. Or "


def refuse_undersampled(scene: Scene, points: int, by_collocation: bool = False) -> None:
    """Raise `SceneError` where points of a cycle miss what a load or a drive does between them."""
    if scene.analysis.allow_coarse or not scene.drives or scene.analysis.method == "static":
        return
    several, count = isinstance(scene.drive, tuple), scene.analysis.sub_intervals
    found = {
        f"drive.{i}.law" if several else "drive.law": (
            "the law of the drive",
            drive.enough_angles(points, scene.cycle_rate),
        )
        for i, drive in enumerate(scene.drives)
    }
    for name, load in scene.loads.items():
        enough = points if by_collocation and load.cut_where_needed else load.enough_angles(points)
        found[f"loads.{name}.factor"] = "the factor of the load", enough
    for place, (what, enough) in found.items():
        if enough > points:
            slower = "state what changes more slowly, such as a wider pulse; analysis.allow_coarse lets it pass"
            wanted = f"Take at least {math.ceil(count * enough / points)} sub_intervals, or {slower}"
            known = enough < SAMPLING.samples
            raise SceneError(
                f"{count} positions miss what {what} does between them",
                place=place,
                hint=wanted if known else (CUT if place.startswith("loads.") and not by_collocation else "") + slower,
            ).finer_by(**({"sub_intervals": math.ceil(count * enough / points)} if known else {}))
    if by_collocation:
        refuse_hidden_peaks(scene)


def refuse_hidden_peaks(scene: Scene) -> None:
    """Raise `SceneError` where a load's factor has a peak that no collocation point of the scene's steps shows."""
    if scene.analysis.allow_coarse:
        return
    for name in loads_with_hidden_peaks(scene):
        raise SceneError(
            f"the factor has a peak between the points of {scene.analysis.sub_intervals} steps of a cycle",
            place=f"loads.{name}.factor",
            hint="State the peak by a table or a pulse, at whose corners steps are cut, or make it wider; "
            "analysis.allow_coarse lets it pass",
        )


def require_positions(scene: Scene, positions: int) -> None:
    """Raise `TooLargeError` where loops, nodes and results at so many positions do not fit into memory."""
    at_nodes = loads_at_nodes(active(scene))
    nodes = sum(len(member_nodes(scene, label, at_nodes)) for label in scene.members())
    each = 4 * (3 * len(scene.links)) ** 2 + 200 * nodes + 48 * len(scene.members()) * scene.analysis.stations
    hint = "Take fewer sub_intervals, cycles of a motion in time, stations or elements"
    require_memory(float(positions) * each, f"{positions} positions of {len(scene.links)} links", hint)
