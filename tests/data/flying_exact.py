"""Make tables of a beam that a force and a moment at one end fling off, geometrically exact, by Exudyn.

It is the flying beam of Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 855: length 10, EA 1e4, rho A 1, from (6, 0) to
(0, 8), under a force of 8 along x and a moment of 80 at its lower end. EI is 500.

- In `flying_exact.csv` the sections have no inertia of their own: cable elements lack it.
- In `flying_heavy_exact.csv` they have the inertia of the paper, 10. Elements are Exudyn's exact beams of two nodes.
  Their shear stiffness is 1e6, so that they hardly shear; 32 elements differ by 3 mm.

Run it with Exudyn 1.13 beside it: `python tests/data/flying_exact.py`. Columns: time (s), and x and y (m) of the lower
end, the middle and the upper end.
"""

import csv
from itertools import pairwise
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    LoadForceVector,
    LoadTorqueVector,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodePoint2DSlope1,
    NodeRigidBody2D,
    ObjectANCFCable2D,
    ObjectBeamGeometricallyExact2D,
    SensorNode,
)

SAMPLES, DURATION = 8, 0.8
START, END = np.array([6.0, 0.0]), np.array([0.0, 8.0])
FORCE, MOMENT, AXIAL, SHEAR, BENDING, LINE, TURNING = 8.0, 80.0, 1e4, 1e6, 500.0, 1.0, 10.0
LENGTH = float(np.linalg.norm(END - START))


def light_beam(system, elements):
    """Add the beam of cable elements, and give its nodes."""
    references = [[*place, *(END - START) / LENGTH] for place in np.linspace(START, END, elements + 1)]
    nodes = [system.AddNode(NodePoint2DSlope1(referenceCoordinates=at)) for at in references]
    cable = {"massPerLength": LINE, "axialStiffness": AXIAL, "bendingStiffness": BENDING}
    cable |= {"length": LENGTH / elements, "useReducedOrderIntegration": 2}
    for pair in pairwise(nodes):
        system.AddObject(ObjectANCFCable2D(nodeNumbers=list(pair), **cable))
    return nodes


def heavy_beam(system, elements):
    """Add the beam of elements whose sections have inertia, and give its nodes."""
    angle = float(np.arctan2(*(END - START)[::-1]))
    references = [[*place, angle] for place in np.linspace(START, END, elements + 1)]
    nodes = [system.AddNode(NodeRigidBody2D(referenceCoordinates=at)) for at in references]
    beam = {"massPerLength": LINE, "crossSectionInertia": TURNING, "bendingStiffness": BENDING}
    beam |= {"axialStiffness": AXIAL, "shearStiffness": SHEAR, "length": LENGTH / elements}
    for pair in pairwise(nodes):
        system.AddObject(ObjectBeamGeometricallyExact2D(nodeNumbers=list(pair), **beam))
    return nodes


def flight(beam, elements, steps):
    """Give times and places of both ends and the middle, ``(samples + 1, 7)``."""
    system = exu.SystemContainer().AddSystem()
    nodes = beam(system, elements)
    at, turned = (system.AddMarker(marker(nodeNumber=nodes[0])) for marker in (MarkerNodePosition, MarkerNodeRigid))
    system.AddLoad(LoadForceVector(markerNumber=at, loadVector=[FORCE, 0, 0]))
    system.AddLoad(LoadTorqueVector(markerNumber=turned, loadVector=[0, 0, MOMENT]))
    kept = {"outputVariableType": exu.OutputVariableType.Position, "storeInternal": True, "writeToFile": False}
    sensors = [system.AddSensor(SensorNode(nodeNumber=nodes[i], **kept)) for i in (0, elements // 2, elements)]
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.95
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = DURATION / SAMPLES
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = DURATION
    system.SolveDynamic(settings)
    found = [system.GetSensorStoredData(sensor) for sensor in sensors]
    return np.column_stack([found[0][:, 0], *(part[:, 1:3] for part in found)])


def main():
    """Write the tables."""
    names = ["time", "lower_x", "lower_y", "middle_x", "middle_y", "upper_x", "upper_y"]
    runs = (("flying_exact", light_beam, 16, 8000), ("flying_heavy_exact", heavy_beam, 64, 2000))
    for name, beam, elements, steps in runs:
        with Path(__file__).with_name(f"{name}.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows([f"{value:.8g}" for value in row] for row in flight(beam, elements, steps))


if __name__ == "__main__":
    main()
