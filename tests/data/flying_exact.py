"""Make `flying_exact.csv`: a beam that a force and a moment at one end fling off, geometrically exact, by Exudyn.

It is the flying beam of Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 855: length 10, EA 1e4, rho A 1, from (6, 0) to
(0, 8), under a force of 8 along x and a moment of 80 at its lower end. EI is 500, and the sections have no inertia of
their own, which the elements here lack. Run it with Exudyn 1.13 beside it: `python tests/data/flying_exact.py`.
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
    NodePoint2DSlope1,
    ObjectANCFCable2D,
    SensorNode,
)

ELEMENTS, STEPS, SAMPLES, DURATION = 16, 8000, 8, 0.8
START, END = np.array([6.0, 0.0]), np.array([0.0, 8.0])
FORCE, MOMENT, AXIAL, BENDING, LINE = 8.0, 80.0, 1e4, 500.0, 1.0


def flight(elements=ELEMENTS, steps=STEPS):
    """Give times and places of both ends and the middle, ``(samples + 1, 7)``."""
    system = exu.SystemContainer().AddSystem()
    length = float(np.linalg.norm(END - START))
    along = (END - START) / length
    references = [np.append(START + share * (END - START), along) for share in np.linspace(0, 1, elements + 1)]
    nodes = [system.AddNode(NodePoint2DSlope1(referenceCoordinates=list(at))) for at in references]
    for pair in pairwise(nodes):
        cable = {"massPerLength": LINE, "axialStiffness": AXIAL, "bendingStiffness": BENDING}
        system.AddObject(
            ObjectANCFCable2D(nodeNumbers=list(pair), length=length / elements, useReducedOrderIntegration=2, **cable)
        )
    at, turned = (system.AddMarker(marker(nodeNumber=nodes[0])) for marker in (MarkerNodePosition, MarkerNodeRigid))
    system.AddLoad(LoadForceVector(markerNumber=at, loadVector=[FORCE, 0, 0]))
    system.AddLoad(LoadTorqueVector(markerNumber=turned, loadVector=[0, 0, MOMENT]))
    kept = {"outputVariableType": exu.OutputVariableType.Position, "storeInternal": True, "writeToFile": False}
    sensors = [system.AddSensor(SensorNode(nodeNumber=nodes[i], **kept)) for i in (0, elements // 2, elements)]
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.95
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = DURATION / SAMPLES
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
