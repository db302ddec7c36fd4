"""A linkage of beams on pins as geometrically exact beams in Exudyn.

Each link is a row of planar ANCF cable elements (Gerstmayr and Irschik 2008): Euler-Bernoulli beams that may turn as
far as they like, with the strains ``|r'| - 1`` and ``kappa = phi'``.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import MechanismError, SceneError, SolverError
from fenics_mech.kinematics import solve_motion
from fenics_mech.kinematics.motion import Motion
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import Revolute

NEAR, FAR = (1 - math.sqrt(1 / 3)) / 2, (1 + math.sqrt(1 / 3)) / 2  # the two Gauss points of an element
SPECTRAL_RADIUS = 0.8  # of the generalized-alpha method at frequencies far above 1 / step
NEWTON = 1e-5  # residual at which Newton's iteration may end (N): rounding leaves 1e-8 with 8 elements, > 1e-6 with 64


def import_exudyn() -> Any:
    """Import Exudyn when it is asked for, as it is not needed for anything else."""
    try:
        import exudyn  # noqa: PLC0415
        import exudyn.itemInterface  # noqa: PLC0415
    except ImportError as error:
        raise MechanismError("Exudyn is not installed. pip install 'fenics_mech[peers]'") from error
    return exudyn


def check_scene(scene: Scene) -> None:
    """Refuse what the model has no elements for."""
    for name, link in scene.links.items():
        ends = [member.ends for member in link.members.values()]
        if len(ends) != 1 or set(link.points) != set(ends[0]):
            raise SceneError("the Exudyn model has links of one beam between their two points", place=f"links.{name}")
    for label, (_, member) in scene.members().items():
        if not scene.sections[member.section].constant:
            raise SceneError("the Exudyn model has uniform beams", place=f"links.{label}")
    for name, joint in scene.joints.items():
        if not isinstance(joint, Revolute):
            raise SceneError("the Exudyn model has pins only", place=f"joints.{name}")
    for name, mass in scene.masses.items():
        if mass.inertia:
            raise SceneError("the Exudyn model has masses without inertia only", place=f"masses.{name}")
    if scene.loads or scene.impulses or any(scene.gravity):
        raise SceneError("the Exudyn model has no loads, impulses or gravity", place="loads")
    drive = scene.drives[0] if len(scene.drives) == 1 else None
    bodies = [point.split(".")[0] for point in scene.joints[drive.joint].connect] if drive else []
    if drive is None or drive.speed is None or len(bodies) != 2 or bodies[0] != "ground":
        raise SceneError("the Exudyn model has one drive, at constant speed, from the ground to a link", place="drive")


def add_mechanism(
    exu: Any, system: Any, scene: Scene, retardation: float, elements: int
) -> dict[str, tuple[list[int], list[int]]]:
    """Build the linkage at drive angle 0, moving as rigid bodies.

    Returns
    -------
    dict
        By member: its elements and its nodes, in order.
    """
    items = exu.itemInterface
    motion = solve_motion(scene, np.zeros(1))
    ground = system.AddObject(items.ObjectGround())
    beams = {label: _add_beam(exu, system, scene, motion, label, retardation, elements) for label in scene.members()}
    node = {
        f"{link}.{end}": beams[label][1][i]
        for label, (link, member) in scene.members().items()
        for end, i in zip(member.ends, (0, -1))
    }
    for joint in scene.joints.values():
        places = []
        for point in joint.connect:
            body, xy = scene.point(point)
            if body == "ground":
                marker = items.MarkerBodyPosition(bodyNumber=ground, localPosition=[*xy, 0])
            else:
                marker = items.MarkerNodePosition(nodeNumber=node[point])
            places.append(system.AddMarker(marker))
        for pair in pairwise(places):
            system.AddObject(items.ObjectJointRevolute2D(markerNumbers=list(pair)))
    for mass in scene.masses.values():
        matrix = np.diag([mass.mass, mass.mass, 0, 0])  # of the node's place; none of its slope
        system.AddObject(items.ObjectGenericODE2(nodeNumbers=[node[mass.at]], massMatrix=matrix))
    _add_drive(exu, system, node[scene.joints[scene.drives[0].joint].connect[1]], scene.cycle_rate)
    return beams


def _add_beam(
    exu: Any, system: Any, scene: Scene, motion: Motion, label: str, retardation: float, elements: int
) -> tuple[list[int], list[int]]:
    """Add a member's nodes and elements."""
    items = exu.itemInterface
    link, _ = scene.members()[label]
    first, last = (np.array(end) for end in scene.member_ends(label))
    length = float(np.linalg.norm(last - first))
    direction, turning = _slope(motion, link, (last - first) / length)
    nodes = []
    for s in np.linspace(0, 1, elements + 1):
        place, velocity, _ = motion.of_point(link, tuple(first + s * (last - first)))
        nodes.append(
            system.AddNode(
                items.NodePoint2DSlope1(
                    referenceCoordinates=[*place[0], *direction], initialVelocities=[*velocity[0], *turning]
                )
            )
        )
    rigidity = scene.rigidity(label, np.array([0.5]))
    ea, ei = float(rigidity.axial[0]), float(rigidity.bending[0])
    cables = [
        system.AddObject(
            items.ObjectANCFCable2D(
                nodeNumbers=list(pair),
                length=length / elements,
                massPerLength=float(rigidity.line_density[0]),
                axialStiffness=ea,
                bendingStiffness=ei,
                axialDamping=retardation * ea,
                bendingDamping=retardation * ei,
            )
        )
        for pair in pairwise(nodes)
    ]
    return cables, nodes


def _slope(motion: Motion, link: str, direction: Array) -> tuple[Array, Array]:
    """A direction of a link in the fixed frame, and its rate (1/s)."""
    i = motion.links.index(link)
    c, s = math.cos(motion.angle[0, i]), math.sin(motion.angle[0, i])
    turned = np.array([[c, -s], [s, c]]) @ direction
    return turned, motion.omega[0, i] * np.array([-turned[1], turned[0]])


def _add_drive(exu: Any, system: Any, node: int, speed: float) -> None:
    """Add a hub that turns at a speed (rad/s), and clamp the slope of the driven beam's end to it."""
    items = exu.itemInterface
    place, direction = np.split(np.array(system.GetNode(node)["referenceCoordinates"]), 2)
    hub = system.AddNode(
        items.NodeRigidBody2D(
            referenceCoordinates=[*place, math.atan2(direction[1], direction[0])], initialVelocities=[0, 0, speed]
        )
    )
    system.AddObject(items.ObjectRigidBody2D(nodeNumber=hub, mass=1, inertia=1))
    fixed = system.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=system.AddNode(items.NodePointGround()), coordinate=0)
    )
    for coordinate, law in enumerate((0, 0, lambda system, t, item, offset: speed * t)):
        marker = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=hub, coordinate=coordinate))
        system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[fixed, marker], offsetUserFunction=law))
    clamped = [system.AddMarker(items.MarkerNodeRigid(nodeNumber=n)) for n in (hub, node)]
    system.AddObject(items.ObjectJointGeneric(markerNumbers=clamped, constrainedAxes=[0, 0, 0, 0, 0, 1]))


def add_sensors(exu: Any, system: Any, cables: list[int], nodes: list[int]) -> dict[str, list[int]]:
    """Add sensors: strain and curvature at the Gauss points of the two middle elements, places of ends and middle."""
    items, kind = exu.itemInterface, exu.OutputVariableType
    half = len(cables) // 2
    points = [(cables[half - 1], NEAR), (cables[half - 1], FAR), (cables[half], NEAR), (cables[half], FAR)]

    def at(variable: Any) -> list[int]:
        return [
            system.AddSensor(
                items.SensorBody(
                    bodyNumber=cable,
                    localPosition=[xi * system.GetObjectParameter(cable, "length"), 0, 0],
                    outputVariableType=variable,
                    storeInternal=True,
                    writeToFile=False,
                )
            )
            for cable, xi in points
        ]

    places = [
        system.AddSensor(
            items.SensorNode(nodeNumber=n, outputVariableType=kind.Position, storeInternal=True, writeToFile=False)
        )
        for n in (nodes[0], nodes[half], nodes[-1])
    ]
    return {"axial": at(kind.StrainLocal), "curvature": at(kind.CurvatureLocal), "places": places}


def integrate(exu: Any, system: Any, period: float, steps: int, cycles: int, angles: int) -> None:
    """Integrate by the generalized-alpha method."""
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = cycles * steps
    settings.timeIntegration.endTime = cycles * period
    settings.timeIntegration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    settings.timeIntegration.adaptiveStep = False
    settings.timeIntegration.newton.absoluteTolerance = NEWTON
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = period / angles
    printed, exu.config.printToConsole = exu.config.printToConsole, False
    try:
        done = system.SolveDynamic(settings)
    except Exception as error:
        raise SolverError(f"Exudyn's integration failed: {error}") from error
    finally:
        exu.config.printToConsole = printed
    if not done:
        raise SolverError(f"Exudyn's integration failed with {steps} steps per cycle")
