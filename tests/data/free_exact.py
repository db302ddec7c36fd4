"""Make `free_exact.csv`: linkages of slender bars that fall from rest, geometrically exact, by Exudyn.

Double pendulums start along X, and so does a bar that a torque spins up. The material of the bar and of a
four-bar damps them by DAMPING, so that axial vibration dies out.
Run it with Exudyn 1.13 beside it: `python tests/data/free_exact.py`.
Columns: linkage, time (s), and x and y (m) of the end of the second bar, or of the only one.
"""

import csv
from itertools import pairwise
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    LoadMassProportional,
    LoadTorqueVector,
    MarkerBodyMass,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodePoint2DSlope1,
    NodePointGround,
    ObjectANCFCable2D,
    ObjectConnectorCoordinate,
    ObjectJointRevolute2D,
    SensorNode,
)

ELEMENTS, STEPS, SAMPLES = 8, 4000, 10
MODULUS, DENSITY, WIDTH, G = 2e11, 7850.0, 0.02, 9.81
DAMPING = 1e-4  # s, over which the rates of stretch and curvature count as much as these
FOUR_BAR = [[0.0, 0.0], [0.21612092, 0.33658839], [0.97305294, 0.59553612], [0.9, 0.0]]  # its pins (m)


def beam(system, ends, height, damping):
    """Add a bar at rest between two places, of a height (m) and a damping (s); give its nodes."""
    area, bending = WIDTH * height, MODULUS * WIDTH * height**3 / 12
    start, end = ends
    length = np.linalg.norm(end - start)
    direction = (end - start) / length
    nodes = [
        system.AddNode(NodePoint2DSlope1(referenceCoordinates=[*(start + share * (end - start)), *direction]))
        for share in np.linspace(0, 1, ELEMENTS + 1)
    ]
    for one, other in pairwise(nodes):
        cable = system.AddObject(
            ObjectANCFCable2D(
                nodeNumbers=[one, other],
                length=length / ELEMENTS,
                massPerLength=DENSITY * area,
                axialStiffness=MODULUS * area,
                bendingStiffness=bending,
                axialDamping=damping * MODULUS * area,
                bendingDamping=damping * bending,
                useReducedOrderIntegration=2,
            )
        )
        mass = system.AddMarker(MarkerBodyMass(bodyNumber=cable))
        system.AddLoad(LoadMassProportional(markerNumber=mass, loadVector=[0, -G, 0]))
    return nodes


def pin(system, one, other):
    """Pin two nodes."""
    markers = [system.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (one, other)]
    system.AddObject(ObjectJointRevolute2D(markerNumbers=markers))


def hold(system, ground, node):
    """Pin a node to the ground."""
    for number in (0, 1):
        markers = [
            system.AddMarker(MarkerNodeCoordinate(nodeNumber=part, coordinate=of))
            for part, of in ((ground, 0), (node, number))
        ]
        system.AddObject(ObjectConnectorCoordinate(markerNumbers=markers))


def course(places, grounded, duration, height, damping=0.0, torque=0.0):
    """Place of the last pin at equal times, ``(samples + 1, 3)`` with the time first; bars run from place to place."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddNode(NodePointGround())
    bars = [beam(system, ends, height, damping) for ends in pairwise(places)]
    for one, other in pairwise(bars):
        pin(system, one[-1], other[0])
    for bar, end in grounded:
        hold(system, ground, bars[bar][end])
    turned = system.AddMarker(MarkerNodeRigid(nodeNumber=bars[0][0]))
    system.AddLoad(LoadTorqueVector(markerNumber=turned, loadVector=[0, 0, torque]))
    sensor = system.AddSensor(
        SensorNode(
            nodeNumber=bars[:2][-1][-1],
            outputVariableType=exu.OutputVariableType.Position,
            storeInternal=True,
            writeToFile=False,
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.95
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.adaptiveStep = False
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.newton.relativeTolerance = 1e-6  # rounding of the axial forces is more than the default
    settings.timeIntegration.newton.absoluteTolerance = 1e-7
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = duration / STEPS
    settings.timeIntegration.numberOfSteps = STEPS
    settings.timeIntegration.endTime = duration
    system.SolveDynamic(settings)
    return system.GetSensorStoredData(sensor)[:: STEPS // SAMPLES, :3]


def main():
    """Write the table."""
    pendulum = np.array([[0.0, 0], [1, 0], [2, 0]])
    runs = {
        "double pendulum": course(pendulum, [(0, 0)], 0.3, 0.01),
        "soft double pendulum": course(pendulum, [(0, 0)], 0.4, 0.002),
        "four-bar": course(np.array(FOUR_BAR), [(0, 0), (2, -1)], 0.3, 0.004, DAMPING),
        "spun bar": course(pendulum[:2], [(0, 0)], 0.4, 0.004, DAMPING, torque=5.0),
    }
    with Path(__file__).with_suffix(".csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["linkage", "time", "x", "y"])
        for name, rows in runs.items():
            writer.writerows([name, *(f"{value:.8g}" for value in row)] for row in rows)


if __name__ == "__main__":
    main()
