"""Forces in the sections of the members of a scene, and strains of their outer fibres."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.section_forces import (
    EndForces,
    InnerForces,
    Sections,
    end_forces,
    inside,
    on_cubics,
    with_rides,
)
from fenics_mech.scene.sections import Rigidity
from fenics_mech.terms import AlongBeams

ROUNDING = 1e-12  # of a member


def along_members(made: SceneMachine, found: Evaluation, a: Array, s: Array, bent: bool = True) -> Sections:
    """Give the forces in sections at stations of all members, ``(instants, members, stations)`` each."""
    # found, a (instants, size)
    assert made.links is not None
    mesh, machine, scene = made.links.mesh, made.machine, made.scene
    lumped = made.links.inertia.spread is not None
    stations, places, parts = elements_at(mesh, s)

    def sections_at(x: Array) -> list[Rigidity]:
        of_members = zip(parts, np.split(x, len(parts)))
        return [scene.rigidity(label, first + own * length) for (label, first, length), own in of_members]

    def line_mass(x: Array) -> Array:
        if lumped:  # which is at the nodes
            return np.zeros(len(x))
        return np.concatenate([one.line_density for one in sections_at(x)])

    beams, group = machine.beams, machine.groups[0]
    bending = np.array([element.length * element.stiffness[2, 2] for element in beams.elements])[stations]

    def softness(x: Array) -> Array:
        return np.asarray(bending / np.concatenate([one.bending for one in sections_at(x)]))

    varies = any(np.ptp(section.bending) > 0 for section in scene.rigidities(s))
    loads = [term for term in machine.terms if isinstance(term, AlongBeams)]
    ends_of_elements = on_elements(made, found, a)
    inner = InnerForces.of_rides(beams, machine.riders, found.at, a) if machine.rides else None

    def line(x: Array, *at: Array) -> Array:
        return np.sum([load.line(found.t, stations, x, *at) for load in loads], axis=0)

    given = stations, places, line_mass
    shape = len(found.force), len(mesh.members), len(s)
    by_loads, soft = line if loads else None, softness if varies else None
    sheared = None if made.links.rigidity.shear is None else made.links.rigidity.shear.mean  # G A_s
    sections = inside(beams, group, found.at, ends_of_elements, *given, inner, by_loads, bent, soft, sheared)
    axial, shear, moment = (x.reshape(shape) for x in (sections.axial, sections.shear, sections.moment))
    place, bow = (x.reshape(*shape, 2) for x in (sections.place, sections.bow))
    return Sections(axial, shear, moment, place, bow)


def on_elements(made: SceneMachine, found: Evaluation, a: Array) -> EndForces:
    """Give what holds all elements at their ends, also against loads along them and pins that ride on them."""
    machine = made.machine
    pairs = zip(machine.terms, found.terms)
    loads = [(term, here.response.stress) for term, here in pairs if isinstance(term, AlongBeams)]
    forces = end_forces(machine.beams, machine.groups[0], found.terms[0], found.at, loads)
    return with_rides(forces, machine.beams, machine.riders, found.at, a) if machine.rides else forces


def cubic_places(made: SceneMachine, found: Evaluation, s: Array) -> Array:
    """Give places on the polynomials between the nodes, ``(instants, members, stations, 2)`` (m)."""
    assert made.links is not None
    mesh, machine = made.links.mesh, made.machine
    elements, places, _ = elements_at(mesh, s)
    cubic = on_cubics(machine.beams, machine.groups[0], found.at, elements, places)
    return cubic.reshape(len(cubic), len(mesh.members), len(s), 2)


def elements_at(mesh: BeamMesh, s: Array) -> tuple[Index, Array, list[tuple[str, Array, Array]]]:
    """Give the element of every station of all members, and its place in it, 0..1 ``(members * stations,)``."""
    # Of each member come its name, and the starts and lengths of these elements as shares of it.
    elements, places, parts = [], [], []
    for number, label in enumerate(mesh.members):
        cells = np.nonzero(mesh.cell_member == number)[0]
        whole = float(mesh.member_length[number])
        at = (s + ROUNDING) * whole  # so that no rounding says on which side of a node a station is
        own = cells[np.clip(np.searchsorted(mesh.cell_start[cells], at, side="right") - 1, 0, None)]
        first, length = mesh.cell_start[own], mesh.cell_length[own]
        elements.append(own)
        places.append((s * whole - first) / length)
        parts.append((label, first / whole, length / whole))
    return np.concatenate(elements), np.concatenate(places), parts
