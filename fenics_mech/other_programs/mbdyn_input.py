"""A scene as an input file of MBDyn: a second opinion by beams in space that turn as far as they like."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.other_programs.beam_linkage import Beam, BeamLinkage, End, exported_linkage
from fenics_mech.scene import Scene

ELEMENTS = 16  # of three nodes, of each beam; an even number, so that mid-span is at a node
STEPS, ANGLES = 1440, 120  # steps of a cycle, and how many of them are written
DECAY = 1e-4  # what is left of the vibration of the start, if it decays as that of members on two pins does
FEWEST, MOST = 4, 60  # cycles
GROUND = 1  # label of the node that stands still
SLIGHT = 1e-6  # inertia of a node's mass over that of a rod between its neighbours: no more than makes it regular
HEAD = """\
# {name}: the steady cycle by MBDyn. Written by fenics_mech {version} from a scene file.
# Beams, joints and masses in SI, at drive angle 0. Run it by: mbdyn -f THIS_FILE -o OUTPUT
# It integrates {cycles} cycles from the motion of rigid links, and writes the last two, at {angles} angles each.
# To compare with fenics_mech, analyse the scene with effects = ["coupling", "large-rotations"]
# and damping = {{ material = {retardation!r} }} (s), the only damping here.
# OUTPUT.act has, for each element of a beam, the axial force in columns 2 and 8 and the moment in columns 7 and 13.
# They are those at 0.211 and 0.789 of the element, and have the viscous part in them.
"""
PROBLEM = """\
begin: data;
    problem: initial value;
end: data;

begin: initial value;
    initial time: 0.;
    final time: {end!r};
    time step: {step!r};
    method: ms, 0.6;
    linear solver: naive, colamd;
    tolerance: 1.e-6;
    max iterations: 20;
    derivatives tolerance: 1.e-3;
    derivatives max iterations: 20;
    derivatives coefficient: 1.e-6;
end: initial value;

begin: control data;
    structural nodes: {nodes};
    rigid bodies: {bodies};
    beams: {beams};
    joints: {joints};
    skip initial joint assembly;
    default output: none, beams;
    output meter: meter, {first!r}, forever, steps, {every};
end: control data;
"""


def mbdyn_input(scene: Scene) -> str:
    """Write a scene as an input file of MBDyn."""
    # Each member is sixteen beam elements of three nodes. Masses are at the nodes, by Simpson's rule. The shear
    # stiffness is as large as that along the axis, so that sections stay nearly normal to the axis.
    from fenics_mech._version import __version__  # noqa: PLC0415

    linkage = exported_linkage(scene)
    if not linkage.retardation:
        raise SceneError("without damping no motion of MBDyn becomes periodic", place="damping")
    nodes, bodies, beams, joints = (list(part(linkage)) for part in (_nodes, _bodies, _elements, _joints))
    cycles, step = _cycles(linkage), linkage.period / STEPS
    name = ascii(scene.name)[1:-1]
    head = HEAD.format(
        name=name, version=__version__, cycles=cycles, angles=ANGLES, retardation=linkage.retardation
    ) + "".join(
        f"# Elements {_label(number, 1)} to {_label(number, ELEMENTS)} are those of {ascii(beam.label)[1:-1]}.\n"
        for number, beam in enumerate(linkage.beams)
    )
    problem = PROBLEM.format(
        end=(cycles + 0.5 / STEPS) * linkage.period, step=step, first=(cycles - 2 - 0.5 / STEPS) * linkage.period,
        every=STEPS // ANGLES, nodes=len(nodes), bodies=len(bodies), beams=len(beams), joints=len(joints),
    )  # fmt: skip
    elements = [f"body: {i}, {line};" for i, line in enumerate(bodies, 1)] + beams
    elements += [f"joint: {i}, {line};" for i, line in enumerate(joints, 1)]
    parts = _block("nodes", nodes), _block("elements", elements)
    return "\n".join([head, problem, *parts])


def _block(name: str, lines: list[str]) -> str:
    return "\n".join([f"begin: {name};", *(f"    {line}" for line in lines), f"end: {name};", ""])


def _cycles(linkage: BeamLinkage) -> int:
    """Give the number of cycles: twice the time in which vibration of the softest beam on two pins dies away."""
    slowest = min((math.pi / beam.length) ** 2 * math.sqrt(beam.bending / beam.line_density) for beam in linkage.beams)
    rate = linkage.retardation * slowest**2 / 2
    count = max(math.ceil(-2 * math.log(DECAY) / (rate * linkage.period)), FEWEST)
    if count > MOST:
        raise SceneError(
            f"with so little damping MBDyn would need {count} cycles to come to the steady motion; {MOST} is the most",
            place="damping",
            hint="State more damping",
        )
    return count


def _label(number: int, place: int) -> int:
    """Give the label of a node or an element: its number along a beam after the number of the beam."""
    return 100 * (number + 1) + place


def _node(end: End) -> int:
    """Give the label of the node at an end of a beam."""
    return _label(end[0], 2 * ELEMENTS + 1 if end[1] else 1)


def _vector(plane: Array) -> str:
    """Write a vector of the plane as one of space."""
    return f"{float(plane[0])!r}, {float(plane[1])!r}, 0."


def _axes(along: Array) -> str:
    """Write axes of which the first is along a direction of the plane, and the third is normal to the plane."""
    return f"1, {_vector(along)}, 3, 0., 0., 1."


def _nodes(linkage: BeamLinkage) -> Iterator[str]:
    """Write the nodes, in the motion of rigid links."""
    yield f"structural: {GROUND}, static, null, eye, null, null;"
    for number, beam in enumerate(linkage.beams):
        for place, share in enumerate(np.linspace(0, 1, 2 * ELEMENTS + 1), 1):
            at, velocity = (first + share * (last - first) for first, last in (beam.ends, beam.velocities))
            moving = f"{_vector(velocity)}, 0., 0., {beam.turning!r}"
            yield f"structural: {_label(number, place)}, dynamic, {_vector(at)}, {_axes(beam.direction)}, {moving};"


def _bodies(linkage: BeamLinkage) -> Iterator[str]:
    """Write the masses of the nodes by Simpson's rule, and point masses."""
    for number, beam in enumerate(linkage.beams):
        half = beam.length / (2 * ELEMENTS)
        for place in range(1, 2 * ELEMENTS + 2):
            shares = 1 if place in (1, 2 * ELEMENTS + 1) else 2 if place % 2 else 4
            yield _body(_label(number, place), beam.line_density * half * shares / 3, half)
    for end, mass in linkage.masses:
        yield _body(_node(end), mass, linkage.beams[end[0]].length / (2 * ELEMENTS))


def _body(node: int, mass: float, length: float) -> str:
    inertia = SLIGHT * mass * length**2 / 12
    return f"{node}, {mass!r}, null, diag, {inertia!r}, {inertia!r}, {inertia!r}"


def _elements(linkage: BeamLinkage) -> Iterator[str]:
    """Write the elements of the beams."""
    for number, beam in enumerate(linkage.beams):
        for element in range(1, ELEMENTS + 1):
            nodes = ", ".join(f"{_label(number, place)}, null" for place in range(2 * element - 1, 2 * element + 2))
            law = f"{_axes(beam.direction)}, {_law(beam, linkage.retardation)}"
            yield f"beam3: {_label(number, element)}, {nodes}, {law}, same, same;"


def _law(beam: Beam, retardation: float) -> str:
    stiffness = ", ".join([repr(beam.axial)] * 3 + [repr(beam.bending)] * 3)
    return f"linear viscoelastic generic, diag, {stiffness}, proportional, {retardation!r}"


def _joints(linkage: BeamLinkage) -> Iterator[str]:
    """Write the joints. Pins turn about the normal of the plane, and members bend out of it too, without loads."""
    beams, hinge = linkage.beams, "position, null"
    yield f"clamp, {GROUND}, node, node"
    for one, other in linkage.welds:
        first, second = beams[one[0]].direction, beams[other[0]].direction
        # the first axis of the one in those of the other
        seen = np.array([second @ first, second[0] * first[1] - second[1] * first[0]])
        yield (
            f"total joint, {_node(one)}, {hinge}, rotation orientation, eye, {_node(other)}, {hinge}, "
            f"rotation orientation, {_axes(seen)}, position constraint, active, active, active, null, "
            "orientation constraint, active, active, active, null"
        )
    for one, other in linkage.pins:
        yield f"revolute hinge, {_node(one)}, {hinge}, {_node(other)}, {hinge}"
    for end in linkage.supports:
        place = _vector(beams[end[0]].ends[end[1]])
        if end == linkage.drive:
            speed = f"const, {linkage.speed!r}"
            yield f"axial rotation, {GROUND}, position, {place}, {_node(end)}, {hinge}, {speed}"
        else:
            yield f"revolute pin, {_node(end)}, {hinge}, position, {place}"
    for end, normal in linkage.guides:
        along, place = np.array([normal[1], -normal[0]]), _vector(beams[end[0]].ends[end[1]])
        yield (
            f"total pin joint, {_node(end)}, {hinge}, position, {place}, position orientation, {_axes(along)}, "
            "position constraint, inactive, active, active, null"
        )
