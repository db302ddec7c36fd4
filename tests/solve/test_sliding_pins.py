"""Cranks whose pins slide along arms that bend, in steady motion, against cable elements (ANCF) of Exudyn."""

import numpy as np
import pandas as pd
import pytest

import fenics_mech as fm
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import periodic, rigid_cycle
from tests.common import ROOT

DATA = ROOT / "tests" / "data"  # `inverted_exact.py` has made the table, and says its errors
SCENES = {
    "guide": ROOT / "tests" / "cases" / "scenes" / "inverted_slider_crank.toml",
    "plastic crank": DATA / "inverted_plastic.toml",
    "riding": DATA / "inverted_riding.toml",
}
POINTS = {"crank_middle": "crank@0.5", "crank_end": "crank.A", "arm_middle": "arm@0.5", "arm_end": "arm.T"}


def differences(name, elements, steps):
    """Give those of places over the largest deflection of each, and those of force and torque over their largest."""
    table = pd.read_csv(DATA / "inverted_exact.csv", comment="#")
    known = table[table["machine"] == name].dropna(axis=1)
    scene = fm.load(SCENES[name]).changed({"mesh.elements": elements})
    made = machine_of(scene)
    machine = made.machine
    machine.chart = rigid_cycle(machine, scene.period)
    cycle = periodic(machine, scene.period, steps)
    at = np.arange(1, len(known) + 1) * steps // len(known) - 1  # steps whose ends are at the angles of the table
    places = cycle.evaluation.at.r.reshape(*cycle.a.shape[:2], -1, 2)[at, -1]
    found = {}
    for column, point in POINTS.items():
        pose = made.end(point).pose
        beside = known[[f"{column}_x", f"{column}_y"]].to_numpy() - places[:, pose]
        deflection = cycle.q[at, -1][:, machine.places[pose, :2]]  # beside the rigid motion
        found[column] = np.abs(beside).max() / np.abs(deflection).max()
    (drive,) = made.driven
    exerted = -cycle.a[at, -1, machine.n :]  # a row's force is on the left of the equation
    for column, value in (("torque", exerted[:, drive]), ("force", np.abs(exerted[:, 1 - drive]))):
        if column in known:
            found[column] = np.abs(known[column] - value).max() / np.abs(known[column]).max()
    return found


CASES = [  # elements, steps, bound
    ("guide", 2, 60, 6e-3),  # its arm turns by half a radian: order 4 of the mesh from there to 16 times the elements
    ("guide", 4, 60, 6e-4),
    ("guide", 8, 120, 5e-5),
    ("plastic crank", 2, 60, 3e-4),
    ("plastic crank", 4, 120, 3e-5),
    ("riding", 4, 60, 2.5e-2),  # the moment has a corner inside an element
    ("riding", 8, 120, 1.5e-3),
    ("riding", 16, 120, 3e-4),
    ("riding", 32, 240, 3e-5),
]
FAST = [("guide", 2), ("guide", 4), ("plastic crank", 2), ("plastic crank", 4), ("riding", 4)]


@pytest.mark.parametrize(
    ("name", "elements", "steps", "bound"),
    [pytest.param(*case, marks=() if case[:2] in FAST else pytest.mark.slow) for case in CASES],
)
def test_cranks_with_sliding_pins_move_as_by_another_program(name, elements, steps, bound):
    """With steps of twice the length the table changes by 1e-5, and where the pin rides by 9e-5: its head tells.

    Its beams have 16, 8 and 32 elements. Where the pin rides, both programs take the axis as the same cubics between
    nodes: with 32 elements each they agree better than either with a finer mesh, from which they are about 5e-5.
    """
    found = differences(name, elements, steps)
    assert max(found.values()) < bound, found
