"""Make `inverted_exact.csv`: cranks whose pins slide along arms that bend, geometrically exact, by Exudyn.

The pins of two inverted slider-cranks are in a straight guide at the pivot of the arm. In a third machine the pin rides
along the arm's bent axis, from element to element. Each is integrated from the motion of rigid links until it repeats.
In the third, Exudyn's sliding joint is of second order only in its local formulation. That has the joint's force wrong,
by up to a third, at angles where the pin goes to the next element. So its force and torque are left out.
Run it with Exudyn 1.13 beside it: `python tests/data/inverted_exact.py`, a quarter of an hour on one processor.
"""

from __future__ import annotations

import math
import sys
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

sys.exudynFast = True  # type: ignore[attr-defined]  # without range checks
import exudyn as exu  # noqa: E402
import exudyn.itemInterface  # noqa: E402

items, HERE = exu.itemInterface, Path(__file__).parent
MACHINES = {  # scene, elements of a link, and cycles with each number of steps
    "guide": (HERE.parent / "cases" / "scenes" / "inverted_slider_crank.toml", 16, 30),
    "plastic crank": (HERE / "inverted_plastic.toml", 8, 130),
    "riding": (HERE / "inverted_riding.toml", 32, 8),
}
ANGLES, STEPS = 60, (480, 480, 480, 960, 1920)  # in a cycle, of the results and one after the other
COLUMNS = "crank_middle", "crank_end", "arm_middle", "arm_end"
STORED = {"storeInternal": True, "writeToFile": False}
Array = np.ndarray[Any, Any]


class Model:
    """A crank and an arm of cable elements (ANCF), drawn with the crank along x."""

    def __init__(self, scene: dict[str, Any], elements: int) -> None:
        self.scene, self.elements = scene, elements
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddNode(items.NodePointGround())
        speed, pivot = scene["drive"]["speed"], np.array(scene["ground"]["points"]["C"])
        pin = np.array([scene["links"]["crank"]["points"]["A"][0], 0.0])
        way, rate = pin - pivot, np.array([0.0, speed * pin[0]])
        turning = (way[0] * rate[1] - way[1] * rate[0]) / (way @ way)
        tip = pivot + scene["links"]["arm"]["points"]["T"][0] * way / np.linalg.norm(way)
        self.period = 2 * math.pi / speed
        crank, _ = self.add_beam("crank", np.zeros(2), pin, speed)
        arm, cables = self.add_beam("arm", pivot, tip, turning)
        hub = self.system.AddNode(items.NodeRigidBody2D(referenceCoordinates=[0] * 3, initialVelocities=[0, 0, speed]))
        self.system.AddObject(items.ObjectRigidBody2D(nodeNumber=hub, mass=1, inertia=1))
        for node in (hub, crank[0], arm[0]):
            self.hold(node, 0)
            self.hold(node, 1)
        self.join(hub, crank[0], [0, 0, 0, 0, 0, 1])
        drive = self.hold(hub, 2, velocityLevel=True, offset=speed)
        self.rides = "member" in scene["joints"]["A"]
        joint = self.ride(crank[-1], cables, way) if self.rides else self.join(arm[0], crank[-1], [0, 1, 0, 0, 0, 0])
        gravity = np.array(scene.get("gravity", [0.0, 0.0]))
        for name, node in (("A", crank[-1]), ("T", arm[-1])):
            mass = scene["masses"][name]["mass"]
            inertia, weight = np.diag([mass, mass, 0, 0]), [*(mass * gravity), 0, 0]  # of the node's place, not slope
            self.system.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=inertia, forceVector=weight))
        kind, half = exu.OutputVariableType.Position, elements // 2
        self.places = [
            self.system.AddSensor(items.SensorNode(nodeNumber=node, outputVariableType=kind, **STORED))
            for node in (crank[half], crank[-1], arm[half], arm[-1])
        ]
        self.pulls = self.system.AddSensor(items.SensorUserFunction(sensorUserFunction=multipliers, **STORED))
        self.system.Assemble()
        rows = [[int(row) for row in self.system.systemData.GetObjectLTGAE(each)] for each in (joint, drive)]
        self.of_joint, self.of_drive = rows[0][1], rows[1][0]  # of the joint, across the guide

    def add_beam(self, name: str, first: Array, last: Array, turning: float) -> tuple[list[int], list[int]]:
        """Add a link that turns about its first end at some speed (rad/s); give its nodes and elements."""
        scene, damping = self.scene, self.scene["damping"]["material"]
        (member,) = scene["links"][name]["members"].values()
        section, metal = scene["sections"][member["section"]], scene["materials"][member["material"]]
        area = section["width"] * section["height"]
        axial, bending = metal["modulus"] * area, metal["modulus"] * area * section["height"] ** 2 / 12
        length = float(np.linalg.norm(last - first))
        direction = (last - first) / length
        spin = turning * np.array([-direction[1], direction[0]])
        nodes = [
            self.system.AddNode(
                items.NodePoint2DSlope1(
                    referenceCoordinates=[*(first + share * (last - first)), *direction],
                    initialVelocities=[*(share * length * spin), *spin],
                )
            )
            for share in np.linspace(0, 1, self.elements + 1)
        ]
        cables = [
            self.system.AddObject(
                items.ObjectANCFCable2D(
                    nodeNumbers=list(pair),
                    length=length / self.elements,
                    massPerLength=metal["density"] * area,
                    axialStiffness=axial,
                    bendingStiffness=bending,
                    axialDamping=damping * axial,
                    bendingDamping=damping * bending,
                    useReducedOrderIntegration=2,  # axial forces at Lobatto points
                )
            )
            for pair in pairwise(nodes)
        ]
        for cable in cables:
            mass = self.system.AddMarker(items.MarkerBodyMass(bodyNumber=cable))
            weight = [*scene.get("gravity", [0.0, 0.0]), 0]
            self.system.AddLoad(items.LoadMassProportional(markerNumber=mass, loadVector=weight))
        return nodes, cables

    def hold(self, node: int, coordinate: int, **motion: Any) -> int:
        """Hold a coordinate of a node, or its velocity."""
        markers = [
            self.system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=one, coordinate=of))
            for one, of in ((self.ground, 0), (node, coordinate))
        ]
        return int(self.system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=markers, **motion)))

    def join(self, one: int, other: int, axes: list[int]) -> int:
        """Hold places or the angle of two nodes in the axes of the first."""
        markers = [self.system.AddMarker(items.MarkerNodeRigid(nodeNumber=node)) for node in (one, other)]
        return int(self.system.AddObject(items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=axes)))

    def ride(self, pin: int, cables: list[int], way: Array) -> int:
        """Let a node ride along cables, at first at a way from their start."""
        markers = [self.system.AddMarker(items.MarkerBodyCable2DCoordinates(bodyNumber=cable)) for cable in cables]
        length = self.scene["links"]["arm"]["points"]["T"][0] / len(cables)
        place = float(np.linalg.norm(way))
        first = int(place // length)
        state = items.NodeGenericData(numberOfDataCoordinates=2, initialCoordinates=[first, place])
        slider = items.ObjectJointSliding2D(
            markerNumbers=[self.system.AddMarker(items.MarkerNodePosition(nodeNumber=pin)), markers[first]],
            slidingMarkerNumbers=markers,
            slidingMarkerOffsets=[k * length for k in range(len(cables))],
            nodeNumber=self.system.AddNode(state),
            useClassicalFormulation=False,
        )
        return int(self.system.AddObject(slider))

    def cycle(self, number: int, steps: int) -> Array:
        """Integrate a cycle from the end of the one before; give the columns at the end of each of `ANGLES` parts."""
        settings = exu.SimulationSettings()
        time = settings.timeIntegration
        time.numberOfSteps, time.startTime, time.endTime = steps, number * self.period, (number + 1) * self.period
        time.adaptiveStep = False
        time.generalizedAlpha.spectralRadius = 0.95
        time.newton.useModifiedNewton = True
        time.newton.modifiedNewtonJacUpdatePerStep = True
        time.newton.relativeTolerance = time.newton.absoluteTolerance = 1e-6  # forces are rounded to 1e-7 N
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.solution.sensors.writePeriod = self.period / ANGLES
        settings.solution.file.write = False
        self.system.SolveDynamic(settings, updateInitialValues=True)
        pulls, *places = (self.system.GetSensorStoredData(i)[-ANGLES:, 1:] for i in (self.pulls, *self.places))
        held = np.abs(pulls[:, self.of_joint]), -pulls[:, self.of_drive]
        return np.column_stack([*(place[:, :2] for place in places), *(() if self.rides else held)])


def multipliers(system: Any, *_: Any) -> Array:
    """Give the multipliers of all constraints."""
    return np.asarray(system.systemData.GetAECoordinates())


def steady(
    scene: dict[str, Any], elements: int, cycles: int, all_steps: tuple[int, ...] = STEPS
) -> tuple[dict[int, Array], Array]:
    """Give the last cycle by steps, and the one before the very last."""
    model, found, number, before = Model(scene, elements), {}, 0, np.zeros(0)
    for steps in all_steps:
        for _ in range(cycles):
            before, found[steps] = found.get(steps, before), model.cycle(number, steps)
            number += 1
    return found, before


def sizes(scene: dict[str, Any], exact: Array) -> Array:
    """Give the largest deflection of each point, beside the motion of rigid links, and of force and torque."""
    crank, arm = scene["links"]["crank"]["points"]["A"][0], scene["links"]["arm"]["points"]["T"][0]
    theta = 2 * math.pi * (np.arange(ANGLES) + 1) / ANGLES
    pin, foot = crank * np.stack([np.cos(theta), np.sin(theta)], axis=1), np.array(scene["ground"]["points"]["C"])
    tip = arm * (pin - foot) / np.linalg.norm(pin - foot, axis=1)[:, None]
    rigid = np.stack([pin / 2, pin, foot + tip / 2, foot + tip], axis=1)
    deflection = np.abs(exact[:, :8].reshape(ANGLES, 4, 2) - rigid).max(axis=(0, 2))
    return np.concatenate([np.repeat(deflection, 2), np.abs(exact[:, 8:]).max(axis=0)])


def main() -> None:
    """Write the table."""
    exu.config.printToConsole = False
    rows, notes = [], []
    for name, (path, elements, cycles) in MACHINES.items():
        scene = tomllib.loads(path.read_text())
        found, last = steady(scene, elements, cycles)
        rough, _ = steady(scene, elements // 2, cycles, STEPS[:-1])
        before, exact = ((4 * found[2 * n] - found[n]) / 3 for n in (480, 960))
        compared = {
            f"{elements // 2} elements from {elements}": (rough[960], found[960]),
            "1920 steps": (found[1920], exact),
            "extrapolated from 480 and 960": (before, exact),
            "last cycle from the one before": (last, found[1920]),
        }
        size = sizes(scene, exact)
        apart = [f"{what} {(np.abs(a - b).max(axis=0) / size).max():.0e}" for what, (a, b) in compared.items()]
        notes.append(f"{name}: {', '.join(apart)}")
        print(notes[-1], flush=True)
        for k, row in enumerate(exact):
            cells = [name, f"{360 * (k + 1) / ANGLES:g}", *(f"{value:.9g}" for value in row)]
            rows.append(",".join(cells + [""] * (12 - len(cells))))
    head = [
        "Steady cycles of cranks whose pins slide along arms that bend: places of the links' middles and ends (m),",
        "force of the pin's joint (N) and torque of the drive (N m). By tests/data/inverted_exact.py, with Exudyn",
        f"{exu.__version__}, ANCFCable2D, generalized-alpha with 960 and 1920 steps a cycle, extrapolated to step 0.",
        "Differences, of a point over its largest deflection, of force and torque over their largest:",
        *(f"  {note}" for note in notes),
    ]
    names = ["machine", "theta_deg", *(f"{place}_{axis}" for place in COLUMNS for axis in "xy"), "force", "torque"]
    table = [*(f"# {line}" for line in head), ",".join(names), *rows, ""]
    Path(__file__).with_suffix(".csv").write_text("\n".join(table))


if __name__ == "__main__":
    main()
