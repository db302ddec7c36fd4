"""Make `free_exact.csv`: double pendulums of slender bars, geometrically exact, from rest along X, by Exudyn.

Run it with Exudyn 1.13 beside it: `python tests/data/free_exact.py`.
Columns: linkage, time (s), and x and y (m) of the end of the second bar.
"""

import csv
from itertools import pairwise
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePoint2DSlope1,
    NodePointGround,
    ObjectANCFCable2D,
    ObjectConnectorCoordinate,
    ObjectJointRevolute2D,
    SensorNode,
)

ELEMENTS, STEPS, SAMPLES = 8, 4000, 10
MODULUS, DENSITY, WIDTH, G = 2e11, 7850.0, 0.02, 9.81


def beam(system, start, end, velocities, height):
    """Add a bar of a height (m); give its nodes."""
    area, bending = WIDTH * height, MODULUS * WIDTH * height**3 / 12
    direction = (end - start) / np.linalg.norm(end - start)
    (first, last), length = velocities, np.linalg.norm(end - start)
    turning = (direction[0] * (last - first)[1] - direction[1] * (last - first)[0]) / length
    rate = turning * np.array([-direction[1], direction[0]])
    nodes = [
        system.AddNode(
            NodePoint2DSlope1(
                referenceCoordinates=[*(start + share * (end - start)), *direction],
                initialVelocities=[*(first + share * (last - first)), *rate],
            )
        )
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


def course(places, velocities, grounded, duration, height):
    """Place of the last pin at equal times, ``(samples + 1, 3)`` with the time first; bars run from place to place."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddNode(NodePointGround())
    bars = [beam(system, places[k], places[k + 1], velocities[k : k + 2], height) for k in range(len(places) - 1)]
    for one, other in pairwise(bars):
        pin(system, one[-1], other[0])
    for bar, end in grounded:
        hold(system, ground, bars[bar][end])
    sensor = system.AddSensor(
        SensorNode(
            nodeNumber=bars[1][-1],
            outputVariableType=exu.OutputVariableType.Position,
            storeInternal=True,
            writeToFile=False,
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.95
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = duration / SAMPLES
    settings.timeIntegration.numberOfSteps = STEPS
    settings.timeIntegration.endTime = duration
    system.SolveDynamic(settings)
    return system.GetSensorStoredData(sensor)[:, :3]


def main():
    """Write the table."""
    pendulum = np.array([[0.0, 0], [1, 0], [2, 0]])
    runs = {
        "double pendulum": course(pendulum, np.zeros((3, 2)), [(0, 0)], 0.3, 0.01),
        "soft double pendulum": course(pendulum, np.zeros((3, 2)), [(0, 0)], 0.4, 0.002),
    }
    with Path(__file__).with_suffix(".csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["linkage", "time", "x", "y"])
        for name, rows in runs.items():
            writer.writerows([name, *(f"{value:.8g}" for value in row)] for row in rows)


if __name__ == "__main__":
    main()
