"""The steady cycle of a linkage by Exudyn: integrated from the rigid motion until the cycle repeats.

Each member is a row of planar ANCF cable elements (Gerstmayr and Irschik 2008): Euler-Bernoulli beams that may turn as
far as they like, with the strains ``|r'| - 1`` and ``kappa = phi'``.

What follows was chosen by trial, for the least time to 1 % and 0.1 % on a four-bar, a slider-crank and a six-bar:

- Exudyn without range checks, with sparse factors, without files, and without Python in the loop.
- The generalized-alpha method with a spectral radius of 0.95. The trapezoidal rule, with constraints of index 2,
  took as long and had larger errors. Explicit methods need steps below 0.1 us, as damping grows with the stiffness.
- Newton's method with a new Jacobian in each step where steps are long, and else with an old one while that serves.
- Axial forces at Lobatto points, which take elements of twice the length for the same error.
- A few coarse cycles before the fine ones: what is left of the start decays in them at less cost.
"""

from __future__ import annotations

import contextlib
import io
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import MechanismError, SolverError
from fenics_mech.other_programs.beam_linkage import Beam, BeamLinkage, End

NEAR, FAR = (1 - math.sqrt(1 / 3)) / 2, (1 + math.sqrt(1 / 3)) / 2  # the two Gauss points of an element
SPECTRAL_RADIUS = 0.95  # of the generalized-alpha method at frequencies far above 1 / step
LOBATTO = 2  # Exudyn's number for axial forces at Lobatto points
ROUNDING = 1e-7  # residual at which Newton's iteration may end in any case (N)
LONG_STEPS, LONG_STEP_TOLERANCE = 1000, 1e-5  # below so many a cycle: a new Jacobian in each, and this tolerance


def import_exudyn() -> Any:
    """Import Exudyn, the version without range checks, when it is asked for: nothing else needs it.

    Raises
    ------
    MechanismError
        When it is not installed.
    """
    sys.exudynFast = True  # type: ignore[attr-defined]
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # it says which version it is
            import exudyn
            import exudyn.itemInterface
    except ImportError as error:
        raise MechanismError("Exudyn is not installed. pip install 'fenics_mech[peers]'") from error
    return exudyn


@dataclass(frozen=True)
class Integration:
    """How Exudyn integrates.

    Parameters
    ----------
    elements
        Elements per beam, an even number.
    steps
        Time steps in each cycle, one after the other; the last cycle is the result.
    tolerance
        Residual at which Newton's iteration ends, over that of its start.
    """

    elements: int
    steps: tuple[int, ...]
    tolerance: float = 1e-4


@dataclass(frozen=True)
class BeamStates:
    """State of the beams over one cycle, at equal drive angles from 0.

    Parameters
    ----------
    axial
        Axial strain in the middle, ``(angles, beams)``.
    bending
        Bending strain of the "+" and "-" fibres there, ``(angles, beams, 2)``.
    place
        Places of first end, middle and last end (m), ``(angles, beams, 3, 2)``.
    periodicity
        Largest difference of a fibre strain at the end of the cycle from that at its start, over the beam's largest.
    seconds
        Processor time of the integration (s), without building the model.
    force
        Force of the first end of each pin on its second (N), and then of the ground on each support and in each guide,
        ``(angles, pins + supports + guides, 2)``; None where it was not asked for.
    torque
        Torque of the drive on its beam (N m), ``(angles,)``; None where it was not asked for.
    """

    axial: Array
    bending: Array
    place: Array
    periodicity: float
    seconds: float
    force: Array | None = None
    torque: Array | None = None

    @property
    def strain(self) -> Array:
        """Strain of the "+" and "-" fibres, ``(angles, beams, 2)``."""
        return self.axial[..., None] + self.bending

    @property
    def deflection(self) -> Array:
        """Distance of the middle from the chord between the ends, along its normal (m), ``(angles, beams)``."""
        first, middle, last = np.moveaxis(self.place, 2, 0)
        chord, rise = last - first, middle - (first + last) / 2
        cross = chord[..., 0] * rise[..., 1] - chord[..., 1] * rise[..., 0]
        return np.asarray(cross / np.linalg.norm(chord, axis=-1))


def steady_cycle(linkage: BeamLinkage, how: Integration, angles: int, *, forces: bool = False) -> BeamStates:
    """Integrate a linkage from the motion of its rigid links, and give the last cycle.

    Parameters
    ----------
    linkage
        Beams and joints.
    how
        Elements and steps; the last number of steps is a multiple of `angles`.
    angles
        Number of drive angles in the result.
    forces
        Whether to read joint forces and the drive's torque too, which takes Python at every step that is stored.

    Raises
    ------
    MechanismError
        When Exudyn is not installed.
    SolverError
        When the integration fails.
    """
    if how.elements < 2 or how.elements % 2 or how.steps[-1] % angles:
        raise ValueError(f"{how.elements} elements must be even, and {how.steps[-1]} steps a multiple of {angles}")
    exu = import_exudyn()
    model = _Model(exu, linkage, how.elements, forces)
    start, period = time.process_time(), linkage.period
    for number, steps in enumerate(how.steps):
        settings = _settings(exu, steps, how.tolerance)
        settings.timeIntegration.startTime, settings.timeIntegration.endTime = number * period, (number + 1) * period
        settings.solution.sensors.active = number == len(how.steps) - 1
        settings.solution.sensors.writePeriod = period / angles
        _integrate(exu, model.system, settings)
    seconds = time.process_time() - start
    axial, curvature, place = (
        np.stack(parts, axis=1) for parts in zip(*(_of_beam(model.system, each, angles) for each in model.sensors))
    )
    bending = -curvature[..., None] * np.stack([beam.fibres for beam in linkage.beams])
    strain = axial[..., None] + bending
    change = np.abs(strain[-1] - strain[0]).max(axis=-1) / np.abs(strain).max(axis=(0, 2))
    known = model.forces(angles) if forces else (None, None)
    return BeamStates(axial[:-1], bending[:-1], place[:-1], float(change.max()), seconds, *known)


class _Model:
    """A linkage in Exudyn."""

    def __init__(self, exu: Any, linkage: BeamLinkage, elements: int, forces: bool) -> None:
        self.items, self.linkage = exu.itemInterface, linkage
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddNode(self.items.NodePointGround())
        self.nodes = [self._add_nodes(beam, elements) for beam in linkage.beams]
        self.sensors = [
            self._add_sensors(exu.OutputVariableType, self._add_cables(beam, nodes), nodes, beam.length / elements)
            for beam, nodes in zip(linkage.beams, self.nodes)
        ]
        self.joints = self._add_joints()
        for end, mass in linkage.masses:
            matrix = np.diag([mass, mass, 0, 0])  # of the node's place; none of its slope
            self._add(self.items.ObjectGenericODE2(nodeNumbers=[self._node(end)], massMatrix=matrix))
        self.drive = self._add_drive()
        self.multipliers = self._add_multipliers() if forces else -1
        self.system.Assemble()

    def forces(self, angles: int) -> tuple[Array, Array]:
        """Forces of the joints and torque of the drive over the cycle, as in `BeamStates`.

        Exudyn's multipliers pull at the first marker of a constraint, and push at its second.
        """
        stored = self.system.GetSensorStoredData(self.multipliers)[-angles - 1 : -1, 1:]

        def of(*objects: int) -> Array:
            rows = [row for each in objects for row in self.system.systemData.GetObjectLTGAE(each)]
            return -stored[:, rows]

        pins, supports, guides = self.joints
        found = [*(of(pin) for pin in pins), *(of(*support) for support in supports)]
        found += [-of(guide) * across for guide, across in guides]
        return np.stack(found, axis=1), of(self.drive)[:, 0]

    def _add(self, item: Any) -> int:
        return int(self.system.AddObject(item))

    def _node(self, end: End) -> int:
        return self.nodes[end[0]][end[1]]

    def _add_nodes(self, beam: Beam, elements: int) -> list[int]:
        shares = np.linspace(0, 1, elements + 1)[:, None]
        places, velocities = (first + shares * (last - first) for first, last in (beam.ends, beam.velocities))
        direction = beam.direction
        rate = beam.turning * np.array([-direction[1], direction[0]])
        return [
            self.system.AddNode(
                self.items.NodePoint2DSlope1(
                    referenceCoordinates=[*place, *direction], initialVelocities=[*velocity, *rate]
                )
            )
            for place, velocity in zip(places, velocities)
        ]

    def _add_cables(self, beam: Beam, nodes: list[int]) -> list[int]:
        return [
            self._add(
                self.items.ObjectANCFCable2D(
                    nodeNumbers=list(pair),
                    length=beam.length / (len(nodes) - 1),
                    massPerLength=beam.line_density,
                    axialStiffness=beam.axial,
                    bendingStiffness=beam.bending,
                    axialDamping=self.linkage.retardation * beam.axial,
                    bendingDamping=self.linkage.retardation * beam.bending,
                    useReducedOrderIntegration=LOBATTO,
                )
            )
            for pair in pairwise(nodes)
        ]

    def _add_sensors(self, kind: Any, cables: list[int], nodes: list[int], length: float) -> dict[str, list[int]]:
        """Add sensors: strain and curvature at the Gauss points nearest to the middle, places of ends and middle."""
        half = len(cables) // 2
        points = [(cables[half - 1], NEAR), (cables[half - 1], FAR), (cables[half], NEAR), (cables[half], FAR)]
        stored = {"storeInternal": True, "writeToFile": False}
        found = {
            name: [
                self.items.SensorBody(
                    bodyNumber=cable, localPosition=[xi * length, 0, 0], outputVariableType=variable, **stored
                )
                for cable, xi in points
            ]
            for name, variable in (("axial", kind.StrainLocal), ("curvature", kind.CurvatureLocal))
        }
        found["places"] = [
            self.items.SensorNode(nodeNumber=nodes[i], outputVariableType=kind.Position, **stored)
            for i in (0, half, -1)
        ]
        return {name: [self.system.AddSensor(each) for each in sensors] for name, sensors in found.items()}

    def _add_multipliers(self) -> int:
        """Add a sensor of all multipliers."""

        def read(system: Any, *_: Any) -> Array:
            return np.asarray(system.systemData.GetAECoordinates())

        sensor = self.items.SensorUserFunction(sensorUserFunction=read, storeInternal=True, writeToFile=False)
        return int(self.system.AddSensor(sensor))

    def _add_joints(self) -> tuple[list[int], list[tuple[int, int]], list[tuple[int, Array]]]:
        """Add joints; give the objects of pins, supports and guides, of these as `_guide` does."""
        linkage = self.linkage
        for one, other in linkage.welds:
            self._clamp(self._node(one), self._node(other), [1, 1, 0, 0, 0, 1])
        supports = [(self._hold(self._node(end), 0), self._hold(self._node(end), 1)) for end in linkage.supports]
        return [self._pin(pair) for pair in linkage.pins], supports, [self._guide(*each) for each in linkage.guides]

    def _pin(self, pair: tuple[End, End]) -> int:
        markers = [self.system.AddMarker(self.items.MarkerNodePosition(nodeNumber=self._node(end))) for end in pair]
        return self._add(self.items.ObjectJointRevolute2D(markerNumbers=markers))

    def _guide(self, end: End, normal: Array) -> tuple[int, Array]:
        """Add a guide; give its object, and the force by a unit multiplier."""
        across = int(abs(normal[1]) > abs(normal[0]))
        markers = [self._coordinate(self._node(end), i) for i in (across, 1 - across)]
        ratio = -float(normal[1 - across] / normal[across])
        guide = self.items.ObjectConnectorCoordinate(markerNumbers=markers, factor1=ratio)
        return self._add(guide), normal / normal[across]

    def _add_drive(self) -> int:
        """Add a hub that turns at the drive's speed, and clamp the driven beam's slope to it; give what turns it."""
        node, speed = self._node(self.linkage.drive), self.linkage.speed
        place, direction = np.split(np.array(self.system.GetNode(node)["referenceCoordinates"]), 2)
        angle = math.atan2(direction[1], direction[0])
        hub = self.system.AddNode(
            self.items.NodeRigidBody2D(referenceCoordinates=[*place, angle], initialVelocities=[0, 0, speed])
        )
        self._add(self.items.ObjectRigidBody2D(nodeNumber=hub, mass=1, inertia=1))
        self._hold(hub, 0)
        self._hold(hub, 1)
        self._clamp(hub, node, [0, 0, 0, 0, 0, 1])
        return self._hold(hub, 2, velocityLevel=True, offset=speed)

    def _hold(self, node: int, coordinate: int, **motion: Any) -> int:
        """Hold a coordinate of a node, or its velocity."""
        markers = [self._coordinate(self.ground, 0), self._coordinate(node, coordinate)]
        return self._add(self.items.ObjectConnectorCoordinate(markerNumbers=markers, **motion))

    def _coordinate(self, node: int, coordinate: int) -> int:
        return int(self.system.AddMarker(self.items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)))

    def _clamp(self, one: int, other: int, axes: list[int]) -> None:
        """Join axes of two nodes: places by the first two, rotations by the last; the angle between them stays."""
        first, second = (self._direction(node) for node in (one, other))
        c, s = float(first @ second), float(second[0] * first[1] - second[1] * first[0])
        turn = np.eye(4)
        turn[:2, :2] = [[c, -s], [s, c]]  # of the other node's frame, to that of the one
        markers = [
            self.system.AddMarker(self.items.MarkerNodeRigid(nodeNumber=one)),
            self.system.AddMarker(self.items.MarkerNodeRigid(nodeNumber=other, localHT=turn)),
        ]
        self._add(self.items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=axes))

    def _direction(self, node: int) -> Array:
        """Direction of a node at the start: of its slope, or of its angle."""
        found = self.system.GetNode(node)["referenceCoordinates"]
        return np.array(found[2:]) if len(found) == 4 else np.array([math.cos(found[2]), math.sin(found[2])])


def _settings(exu: Any, steps: int, tolerance: float) -> Any:
    """Give the settings for a cycle of so many steps."""
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.adaptiveStep = False
    settings.timeIntegration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    newton = settings.timeIntegration.newton
    newton.absoluteTolerance = ROUNDING
    newton.useModifiedNewton = True
    newton.modifiedNewtonJacUpdatePerStep = steps < LONG_STEPS
    newton.relativeTolerance = LONG_STEP_TOLERANCE if steps < LONG_STEPS else tolerance
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.linearSolver.reuseAnalyzedPattern = True
    settings.parallel.numberOfThreads = 1
    settings.solution.file.write = False
    return settings


def _integrate(exu: Any, system: Any, settings: Any) -> None:
    """Integrate a cycle, and leave its end as the start of the next."""
    printed, exu.config.printToConsole = exu.config.printToConsole, False
    try:
        done = system.SolveDynamic(settings, updateInitialValues=True)
    except Exception as error:
        raise SolverError(f"Exudyn's integration failed: {error}") from error
    finally:
        exu.config.printToConsole = printed
    if not done:
        raise SolverError(
            f"Exudyn's integration failed with {settings.timeIntegration.numberOfSteps} steps in the cycle"
        )


def _of_beam(system: Any, sensors: dict[str, list[int]], angles: int) -> Iterator[Array]:
    """Axial strain and curvature at mid-span over a cycle and at its end, ``(angles + 1,)``; places as in `BeamStates`.

    In an element that bends, the axial strain ``u' + w'^2 / 2 + ...`` is right in the mean only: take the mean of the
    two middle elements. The curvature is best at the Gauss points (Barlow 1976): take the even polynomial through the
    four of them that are nearest.
    """
    stored = {
        name: np.stack([system.GetSensorStoredData(i)[-angles - 1 :] for i in numbers])
        for name, numbers in sensors.items()
    }
    times = stored["places"][0, :, 0]
    if len(times) != angles + 1 or np.ptp(np.diff(times)) > 1e-6 * (times[-1] - times[0]):
        raise SolverError("Exudyn did not store its results at the drive angles asked for")
    axial, curvature = (stored[name][:, :, 1] for name in ("axial", "curvature"))
    inner, outer = (curvature[1] + curvature[2]) / 2, (curvature[0] + curvature[3]) / 2
    yield axial.mean(axis=0)
    yield (FAR**2 * inner - NEAR**2 * outer) / (FAR**2 - NEAR**2)
    yield stored["places"][:, :, 1:3].swapaxes(0, 1)
