"""Places between stations where the strain of a member may have a peak that parabolas through the stations miss."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_loads import PointLoad, pin_loads
from fenics_mech.mechanism import System
from fenics_mech.recovery.peaks import PEAK
from fenics_mech.scene import Scene
from fenics_mech.scene.sections import Rigidity
from fenics_mech.scene.sections.rigidity import SECTION


def places_between_stations(scene: Scene, system: System, response: ElasticResponse) -> Array:
    """Give places 0..1 between the stations, ascending.

    Moments have corners under loads and pins that travel, and jump under couples, so that both sides are given. Strains
    have peaks where a section is weakest. The places are those of all members.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.
    response
        A motion of it.
    """
    stations = scene.analysis.stations
    places = [side for found in scene.loaded_places().values() for place in found for side in beside(place)]
    for label, (_, member) in scene.members().items():
        if not scene.sections[member.section].constant:
            places += _weakest(partial(scene.rigidity, label), stations - 1)
    if system.transformation.constraints.contacts:
        places += _under_pins(system, response)
    step = np.array(places) * (stations - 1)
    return np.unique(np.array(places)[np.abs(step - np.round(step)) > 1e-9])  # type: ignore[no-any-return]


def beside(place: Any) -> tuple[Any, Any]:
    """Give both sides of a place along a member, or of several, 0..1.

    Parameters
    ----------
    place
        The place, a number or an array.
    """
    return np.maximum(place - PEAK.beside, 0.0), np.minimum(place + PEAK.beside, 1.0)


def _weakest(rigidity: Callable[[Array], Rigidity], gaps: int) -> list[float]:
    """Places where a section is weaker than at the stations beside: strains under a force or a moment have peaks."""
    steps = -(-SECTION.fine // gaps)
    s = np.linspace(0, 1, gaps * steps + 1)
    found = rigidity(s)
    places: list[float] = []
    for yielding in (1 / found.axial, np.abs(found.fibre).max(axis=-1) / found.bending):
        highest = yielding[steps * np.arange(gaps)[:, None] + np.arange(steps + 1)].argmax(axis=1)
        inside = (highest > 0) & (highest < steps)
        places += s[steps * np.arange(gaps) + highest][inside].tolist()
    return places


def _under_pins(system: System, response: ElasticResponse) -> list[float]:
    """Places of pins that travel: all along their way, and where they press most."""
    places: list[float] = []
    for pin in pin_loads(system, response.undamped):
        place = along_member(system, pin)
        pressed = [np.abs(part).argmax() for part in (pin.across, pin.moment)]
        places += [*np.linspace(place.min(), place.max(), PEAK.on_the_way), *place[pressed]]
    return places


def along_member(system: System, load: PointLoad) -> Array:
    """Give the places of a load along its member, 0..1, ``(angles,)``.

    Parameters
    ----------
    system
        The mechanism.
    load
        The load.
    """
    mesh = system.beams.mesh
    along = mesh.cell_start[load.element] + load.place * mesh.cell_length[load.element]
    return np.asarray(along / mesh.member_length[mesh.cell_member[load.element]])


def even_share(count: int) -> Index:
    """Give every so many of the positions of a cycle, even ones and not many: the curves that they show are smooth.

    Parameters
    ----------
    count
        Number of the positions.
    """
    apart = max(n for n in range(1, max(count // PEAK.under_pins, 1) + 1) if count % n == 0)
    return np.arange(0, count, apart)
