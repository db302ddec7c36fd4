"""The steady cycle of a linkage in space by Exudyn; run by Exudyn's own Python, as it needs nothing of this package.

Usage: ``python exudyn_space_run.py PROBLEM.json RESULT.npz``, see `exudyn_in_space` for both. Each link is a row of
`ObjectBeamGeometricallyExact` of one length. The machine starts at rest, is led to its speed in two periods and one
turn, and runs until the start has decayed. The beams have no damping: that object leaves its damping matrix out.
"""

import json
import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.exudynFast = True
import exudyn as exu  # noqa: E402
import exudyn.itemInterface as items  # noqa: E402, N813

RUN_UP = 2  # periods
SPECTRAL_RADIUS = 0.8  # of the generalized-alpha method
STORED = {"storeInternal": True, "writeToFile": False}


def quaternion(R):
    """Give the Euler parameters of a rotation matrix ``(4,)``."""
    w, v = np.linalg.eigh(
        np.block(
            [
                [np.trace(R) * np.eye(1), np.array([[R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]])],
                [
                    np.array([[R[2, 1] - R[1, 2]], [R[0, 2] - R[2, 0]], [R[1, 0] - R[0, 1]]]),
                    R + R.T - np.trace(R) * np.eye(3),
                ],
            ]
        )
    )
    return v[:, np.argmax(w)]


def frame(rotation, place=(0.0, 0.0, 0.0)):
    """Give a homogeneous transformation ``(4, 4)``."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation, place
    return T


def angle(t, omega):
    """Give the drive's angle (rad): a cubic rise of its speed over the run-up, and then the speed."""
    end = RUN_UP * 2 * np.pi / abs(omega)
    x = min(t / end, 1.0)
    return omega * (end * (x**3 - x**4 / 2) + max(t - end, 0.0))


class Model:
    """A linkage in Exudyn."""

    def __init__(self, problem, elements):
        self.problem, self.container = problem, exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.g = np.array(problem["gravity"])
        self.ground = self.system.AddObject(items.ObjectGround())
        self.point = self.system.AddNode(items.NodePointGround())
        self.nodes, self.turns, self.objects, self.bodies = {}, {}, {}, {}
        for link in problem["links"]:
            self.add_link(link, elements)
        for body in problem["bodies"]:
            node = self.system.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[*body["centre"], 1, 0, 0, 0]))
            J = np.array(body["inertia"])
            six = [J[0, 0], J[1, 1], J[2, 2], J[1, 2], J[0, 2], J[0, 1]]
            self.system.AddObject(items.ObjectRigidBody(nodeNumber=node, mass=body["mass"], inertia=six))
            self.bodies[body["name"]] = node, np.array(body["centre"])
            self.push(node, body["mass"] * self.g)
        for name, s, mass in problem["masses"]:
            node = self.nodes[name][round(s * elements)]
            matrix = np.diag([mass] * 3 + [0.0] * 4)
            self.system.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=matrix))
            self.push(node, mass * self.g)
        for name, s, damping in problem["dampers"]:
            marker = self.system.AddMarker(items.MarkerNodePosition(nodeNumber=self.nodes[name][round(s * elements)]))
            still = self.system.AddMarker(items.MarkerBodyPosition(bodyNumber=self.ground))
            self.system.AddObject(
                items.ObjectConnectorCartesianSpringDamper(markerNumbers=[still, marker], damping=[damping] * 3)
            )
        for joint in problem["joints"]:
            self.add_joint(joint, joint is problem["joints"][0])
        self.add_sensors(elements)
        self.system.Assemble()

    def push(self, node, force):
        if np.any(force):
            marker = self.system.AddMarker(items.MarkerNodePosition(nodeNumber=node))
            self.system.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=list(force)))

    def add_link(self, link, elements):
        """Add a row of beams; their x axis is along the link, y and z are those of bending."""
        first, last, axes = (np.array(link[key]) for key in ("first", "last", "axes"))
        length = np.linalg.norm(last - first) / elements
        q = list(quaternion(axes))
        nodes = [
            self.system.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[*(first + s * (last - first)), *q]))
            for s in np.linspace(0, 1, elements + 1)
        ]
        section = exu.BeamSection()
        section.massPerLength = link["rA"]
        rIy, rIz = link["rI"]
        section.inertia = np.diag([rIy + rIz, rIy, rIz])
        section.stiffnessMatrix = np.diag([link["EA"], link["GA"], link["GA"], link["GJ"], *link["EI"]])
        self.objects[link["name"]] = [
            self.system.AddObject(
                items.ObjectBeamGeometricallyExact(nodeNumbers=list(pair), length=length, sectionData=section)
            )
            for pair in pairwise(nodes)
        ]
        self.nodes[link["name"]], self.turns[link["name"]] = nodes, axes
        for k, node in enumerate(nodes):
            share = 0.5 if k in (0, elements) else 1.0
            self.push(node, share * length * link["rA"] * self.g)

    def marker(self, body, s, place, rotation):
        """Add a marker with a rotation that is given in the drawn position."""
        if body == "ground":
            return self.system.AddMarker(items.MarkerBodyRigid(bodyNumber=self.ground, localHT=frame(rotation, place)))
        if body in self.bodies:
            node, centre = self.bodies[body]
            return self.system.AddMarker(
                items.MarkerNodeRigid(nodeNumber=node, localHT=frame(rotation, np.array(place) - centre))
            )
        node = self.nodes[body][0 if s == 0 else -1]
        return self.system.AddMarker(
            items.MarkerNodeRigid(nodeNumber=node, localHT=frame(self.turns[body].T @ np.array(rotation)))
        )

    def add_joint(self, joint, driven):
        """Add a joint; of the first, the drive's, the second link is clamped to a hub that turns about Z."""
        kind = [1, 1, 1, 1, 1, 1] if driven else joint["held"]
        sides = [
            self.marker(body, s, place, rotation)
            for (body, s), place, rotation in zip(joint["bodies"], joint["places"], joint["frames"])
        ]
        if driven:
            omega = self.problem["speed"]
            hub = self.system.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*joint["places"][0][:2], 0.0]))
            self.system.AddObject(items.ObjectRigidBody2D(nodeNumber=hub, mass=1.0, inertia=1e-3))
            for k in range(3):
                pair = [
                    self.system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=self.point, coordinate=0)),
                    self.system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=hub, coordinate=k)),
                ]
                led = {"offsetUserFunction": lambda mbs, t, number, offset: angle(t, omega)} if k == 2 else {}
                self.drive = self.system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=pair, **led))
            z = joint["places"][0][2]
            sides[0] = self.system.AddMarker(
                items.MarkerNodeRigid(nodeNumber=hub, localHT=frame(joint["frames"][0], [0, 0, z]))
            )
        lean = joint.get("lean", 0.0)
        end = RUN_UP * 2 * np.pi / abs(self.problem["speed"])

        def offset(mbs, t, number, given):  # an axis that leans is turned there in the run-up
            x = min(t / end, 1.0)
            return [0, 0, 0, 0, lean * x**2 * (3 - 2 * x), 0]

        led = {"offsetUserFunction": offset} if lean else {}
        self.system.AddObject(items.ObjectJointGeneric(markerNumbers=sides, constrainedAxes=kind, **led))
        if joint.get("damping"):
            turned = [
                self.marker(body, s, place, np.array(rotation)[:, [1, 2, 0]])
                for (body, s), place, rotation in zip(joint["bodies"], joint["places"], joint["frames"])
            ]
            self.system.AddObject(
                items.ObjectConnectorTorsionalSpringDamper(markerNumbers=turned, damping=joint["damping"])
            )

    def add_sensors(self, elements):
        kind, half = exu.OutputVariableType, elements // 2
        self.places = [
            self.system.AddSensor(items.SensorNode(nodeNumber=nodes[half], outputVariableType=kind.Position, **STORED))
            for nodes in self.nodes.values()
        ]
        self.moments = [
            [
                self.system.AddSensor(
                    items.SensorBody(
                        bodyNumber=objects[k], localPosition=[0, 0, 0], outputVariableType=kind.TorqueLocal, **STORED
                    )
                )
                for k in (half - 2, half - 1, half, half + 1)
            ]
            for objects in self.objects.values()
        ]
        self.torque = self.system.AddSensor(
            items.SensorObject(objectNumber=self.drive, outputVariableType=kind.Force, **STORED)
        )

    def run(self, steps, cycles, angles):
        """Integrate; give places, moments and torque over the last cycle, how they repeat, and the processor time."""
        period, start = 2 * np.pi / abs(self.problem["speed"]), time.process_time()
        settings = exu.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime = steps * cycles, cycles * period
        integration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
        integration.newton.useModifiedNewton = integration.newton.modifiedNewtonJacUpdatePerStep = True
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-6, 1e-6
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.linearSolver.reuseAnalyzedPattern = True
        settings.parallel.numberOfThreads = 1
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = period / angles
        settings.timeIntegration.verboseMode = 1
        if not self.system.SolveDynamic(settings):
            raise RuntimeError("Exudyn's integration failed")
        seconds = time.process_time() - start

        def of(number):
            stored = self.system.GetSensorStoredData(number)
            assert len(stored) == cycles * angles + 1, len(stored)
            return stored[-2 * angles - 1 : -1, 1:]

        place = np.stack([of(k) for k in self.places], axis=1)
        shares = np.array([-0.25, 0.75, 0.75, -0.25])  # to mid member, where the shear force jumps, from either side
        moment = np.stack([np.tensordot(shares, [of(k) for k in four], 1) for four in self.moments], axis=1)
        torque = -of(self.torque)[:, 0]
        half = slice(angles, None)
        change = {
            "place": np.abs(place[half] - place[:angles]).max(),
            "moment": np.abs(moment[half] - moment[:angles]).max() / np.abs(moment).max(),
            "torque": np.abs(torque[half] - torque[:angles]).max() / np.abs(torque).max(),
        }
        return {
            "place": place[half],
            "moment": moment[half],
            "torque": torque[half],
            "change": np.array([change[key] for key in ("place", "moment", "torque")]),
            "seconds": seconds,
        }


if __name__ == "__main__":
    exu.config.printToConsole = "-v" in sys.argv
    stated = json.loads(Path(sys.argv[1]).read_text())
    np.savez(sys.argv[2], **Model(stated, stated["elements"]).run(stated["steps"], stated["cycles"], stated["angles"]))
