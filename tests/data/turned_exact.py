"""Bending of geometrically exact links that much acts on, by Exudyn: `python -m tests.data.turned_exact FILE`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers import exudyn_cycle
from fenics_mech._arrays import Array
from fenics_mech.other_programs.beam_linkage import beam_linkage
from tests.effects.turned_machine import ACTING, SPEED, four_bar

ANGLES, CYCLES = 24, 5
PERIOD = 2 * math.pi / SPEED


def risen(time: float) -> float:
    """Share of what acts from the first cycle on, so that the start is smooth."""
    share = min(1.0, time / PERIOD)
    return share * share * (3 - 2 * share)


class Turned(exudyn_cycle._Model):
    """The four-bar with what acts on it."""

    def _add_drive(self) -> None:
        super()._add_drive()
        labels = [beam.label for beam in self.linkage.beams]
        coupler, follower = (self.nodes[labels.index(name)] for name in ("coupler", "follower"))
        moment, force = ACTING["loads"]["moment"], ACTING["loads"]["turning"]["force"]
        (swing,) = moment["factor"]["sine"]

        def torque(_: Any, time: float, __: Any) -> list[float]:
            return [0.0, 0.0, moment["moment"] * (1 + swing * math.sin(SPEED * time)) * risen(time)]

        def push(_: Any, time: float, __: Any) -> list[float]:
            return [*(part * risen(time) for part in force), 0.0]

        add, items = self.system.AddLoad, self.items
        add(items.LoadTorqueVector(markerNumber=self._rigid(follower[-1]), loadVectorUserFunction=torque))
        middle = self._rigid(coupler[len(coupler) // 2])
        add(items.LoadForceVector(markerNumber=middle, bodyFixed=True, loadVectorUserFunction=push))
        ground = self.system.AddMarker(items.MarkerBodyRigid(bodyNumber=self._add(items.ObjectGround())))
        self._add_hinge(
            "B", self._rigid(coupler[-1]), self._angle(follower[-1]) - self._angle(coupler[-1]), follower[-1]
        )
        self._add_hinge("C", ground, self._angle(follower[0]), follower[0])

    def _rigid(self, node: int) -> int:
        return int(self.system.AddMarker(self.items.MarkerNodeRigid(nodeNumber=node)))

    def _angle(self, node: int) -> float:
        return math.atan2(*self._direction(node)[::-1])

    def _add_hinge(self, joint: str, first: int, angle: float, second: int) -> None:
        """Add a spring that is free at the start, and a damper."""
        stiffness, damping = ACTING["springs"][joint]["stiffness"], ACTING["dampers"][joint]["damping"]
        start = math.remainder(angle, 2 * math.pi)

        def torque(_: Any, time: float, __: int, rotation: float, rate: float, *___: float) -> float:
            return float(stiffness * (rotation - start) + damping * rate * risen(time))

        node = self.system.AddNode(self.items.NodeGenericData(numberOfDataCoordinates=1, initialCoordinates=[0]))
        spring = self.items.ObjectConnectorTorsionalSpringDamper
        self._add(spring(markerNumbers=[first, self._rigid(second)], nodeNumber=node, springTorqueUserFunction=torque))


def curves(elements: int, steps: int) -> Array:
    """Give angle, deflections of coupler and follower, and the follower's bending strain, ``(angles, 4)``."""
    exudyn_cycle._Model = Turned  # type: ignore[misc]
    linkage = beam_linkage(four_bar(acting=()))
    found = exudyn_cycle.steady_cycle(linkage, exudyn_cycle.Integration(elements, (steps,) * CYCLES, 1e-8), ANGLES)
    theta = 360 * np.arange(ANGLES) / ANGLES
    return np.column_stack([theta, found.deflection[:, 1:], found.bending[:, 2, 0]])


if __name__ == "__main__":
    rough, fine = curves(16, 2400), curves(32, 4800)
    apart = np.abs(rough - fine).max(axis=0) / np.abs(fine).max(axis=0)
    comment = [
        "The four-bar of tests/effects/turned_machine.py as geometrically exact beams: distances of the mid-spans from",
        "their chords along the normal (m), and bending strain of the follower's + fibre.",
        f"Exudyn {exudyn_cycle.import_exudyn().__version__}, 32 ANCFCable2D elements a link, "
        f"{CYCLES} cycles of 4800 steps.",
        f"16 elements and 2400 steps from these, over the largest: {', '.join(f'{part:.1e}' for part in apart[1:])}",
    ]
    rows = [",".join(f"{value:.8g}" for value in row) for row in fine]
    names = "theta_deg,coupler_deflection,follower_deflection,follower_bending"
    Path(sys.argv[1]).write_text("\n".join([*(f"# {line}" for line in comment), names, *rows, ""]))
