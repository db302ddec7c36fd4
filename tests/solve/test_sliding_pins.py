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
    scene = fm.load(SCENES[name]).changed({"mesh.elements": elements, "analysis.reduction": "none"})
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
