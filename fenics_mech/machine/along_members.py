"""Forces in the sections of the members of a scene, and strains of their outer fibres."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.section_forces import InnerForces, Sections, end_forces, inside, with_rides
from fenics_mech.terms import AlongBeams


def along_members(made: SceneMachine, found: Evaluation, a: Array, s: Array, bent: bool = True) -> Sections:
    """Give the forces in sections at stations of all members, ``(instants, members, stations)`` each.

    Parameters
    ----------
    made
        The machine of a scene.
    found, a
        Its residual, and the accelerations with the multipliers there ``(instants, size)``.
    s
        Stations along every member, 0..1.
    bent
        As of `inside`.
    """
    assert made.links is not None
    mesh, machine, scene = made.links.mesh, made.machine, made.scene
    elements, places, parts = [], [], []
    for number, label in enumerate(mesh.members):
        cells = np.nonzero(mesh.cell_member == number)[0]
        whole = float(mesh.member_length[number])
        own = cells[np.clip(np.searchsorted(mesh.cell_start[cells], s * whole, side="right") - 1, 0, None)]
        first, length = mesh.cell_start[own], mesh.cell_length[own]
        elements.append(own)
        places.append((s * whole - first) / length)
        parts.append((label, first / whole, length / whole))

    def line_mass(x: Array) -> Array:
        of_members = zip(parts, np.split(x, len(parts)))
        made_of = [scene.rigidity(label, first + own * length) for (label, first, length), own in of_members]
        return np.concatenate([one.line_density for one in made_of])

    beams, group = machine.beams, machine.groups[0]
    loads = [
        (term, here.response.stress) for term, here in zip(machine.terms, found.terms) if isinstance(term, AlongBeams)
    ]
    ends_of_elements = end_forces(beams, group, found.terms[0], found.at, loads)
    inner = None
    if machine.rides:
        ends_of_elements = with_rides(ends_of_elements, beams, machine.riders, found.at, a)
        inner = InnerForces.of_rides(beams, machine.riders, found.at, a)
    stations = np.concatenate(elements)

    def line(x: Array, tangent: Array, velocity: Array) -> Array:
        return np.sum([load.line(found.t, stations, x, tangent, velocity) for load, _ in loads], axis=0)

    given = stations, np.concatenate(places), line_mass
    shape = len(found.force), len(mesh.members), len(s)
    sections = inside(beams, group, found.at, ends_of_elements, *given, inner, line if loads else None, bent)
    axial, shear, moment = (x.reshape(shape) for x in (sections.axial, sections.shear, sections.moment))
    place, bow = (x.reshape(*shape, 2) for x in (sections.place, sections.bow))
    return Sections(axial, shear, moment, place, bow)
