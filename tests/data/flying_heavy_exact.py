"""Make `flying_heavy_exact.csv`: the beam of `flying_exact.py` with the sections' inertia of its paper, by Exudyn.

Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 855, give the sections an inertia of 10 about their own axes. The elements
are Exudyn's geometrically exact beams of two nodes, which have it. Their shear stiffness is 1e6, so that they hardly
shear; 32 elements differ by 3 mm. Run it with Exudyn 1.13 beside it: `python tests/data/flying_heavy_exact.py`.
Columns: time (s), and x and y (m) of the lower end, the middle and the upper end.
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
    NodeRigidBody2D,
    ObjectBeamGeometricallyExact2D,
    SensorNode,
)

ELEMENTS, STEPS, SAMPLES, DURATION = 64, 2000, 8, 0.8
START, END = np.array([6.0, 0.0]), np.array([0.0, 8.0])
FORCE, MOMENT, AXIAL, SHEAR, BENDING, LINE, TURNING = 8.0, 80.0, 1e4, 1e6, 500.0, 1.0, 10.0


def flight(elements=ELEMENTS, steps=STEPS):
    """Give times and places of both ends and the middle, ``(samples + 1, 7)``."""
    system = exu.SystemContainer().AddSystem()
    length, angle = float(np.linalg.norm(END - START)), float(np.arctan2(*(END - START)[::-1]))
    places = [START + share * (END - START) for share in np.linspace(0, 1, elements + 1)]
    nodes = [system.AddNode(NodeRigidBody2D(referenceCoordinates=[*place, angle])) for place in places]
    for pair in pairwise(nodes):
        beam = {"massPerLength": LINE, "crossSectionInertia": TURNING, "bendingStiffness": BENDING}
        beam |= {"axialStiffness": AXIAL, "shearStiffness": SHEAR}
        system.AddObject(ObjectBeamGeometricallyExact2D(nodeNumbers=list(pair), length=length / elements, **beam))
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
    """Write the table."""
    with Path(__file__).with_suffix(".csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time", "lower_x", "lower_y", "middle_x", "middle_y", "upper_x", "upper_y"])
        writer.writerows([f"{value:.8g}" for value in row] for row in flight())


if __name__ == "__main__":
    main()
