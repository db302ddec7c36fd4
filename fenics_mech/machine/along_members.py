"""Forces in the sections of the members of a scene, and strains of their outer fibres."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.section_forces import end_forces, inside


def along_members(made: SceneMachine, found: Evaluation, s: Array) -> tuple[Array, Array]:
    """Give axial force (N) and moment (N m) at stations of all members, ``(instants, members, stations)``.

    Parameters
    ----------
    made
        The machine of a scene.
    found
        Its residual.
    s
        Stations along every member, 0..1.
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
    ends_of_elements = end_forces(beams, group, found.terms[0], found.at)
    given = np.concatenate(elements), np.concatenate(places), line_mass
    shape = len(found.force), len(mesh.members), len(s)
    axial, moment = inside(beams, group, found.at, ends_of_elements, *given)
    return axial.reshape(shape), moment.reshape(shape)
