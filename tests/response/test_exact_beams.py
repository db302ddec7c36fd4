"""A free motion of bars that bend, against geometrically exact beams of Exudyn: `tests/data/free_exact.py`."""

import csv

import numpy as np
import pytest

import fenics_mech as fm
from tests.common import ROOT


def exact(linkage: str) -> np.ndarray:
    """Time, x and y, ``(times, 3)``."""
    with (ROOT / "tests" / "data" / "free_exact.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["linkage"] == linkage]
    return np.array([[float(row[name]) for name in ("time", "x", "y")] for row in rows])


def bars(lengths, angles, **changes) -> fm.Scene:
    """Give slender bars of steel in a chain, the first from the origin."""
    links = {
        f"b{k}": fm.Link(
            points={"A": (0, 0), "B": (length, 0)},
            members={"bar": fm.Member(ends=("A", "B"), section="bar", material="steel")},
            angle=angle,
        )
        for k, (length, angle) in enumerate(zip(lengths, angles))
    }
    joints = {"P0": fm.Revolute(connect=("ground.O", "b0.A"))}
    joints |= {f"P{k}": fm.Revolute(connect=(f"b{k - 1}.B", f"b{k}.A")) for k in range(1, len(lengths))}
    scene = fm.Scene(
        name="slender bars",
        materials={"steel": fm.Material(modulus=2e11, density=7850)},
        sections={"bar": fm.RectangleSection(width=0.02, height=0.01)},
        ground=fm.Ground(points={"O": (0, 0), "Q": (0.9, 0)}),
        links=links,
        joints=joints,
        gravity=(0, -9.81),
        effects=("coupling", "gravity", "large-rotations"),
        mesh=fm.Mesh(elements=2),
        analysis=fm.Analysis(
            method="transient", duration=0.3, sub_intervals=10, time_tolerance=1e-4, error_estimates=False
        ),
    )
    return scene.changed(changes)


def assert_near(scene: fm.Scene, point: str, linkage: str, limit: float) -> None:
    data, wanted = fm.analyse(scene).data, exact(linkage)
    found = data["point_position_bent"].sel(point=point).to_numpy()[-len(wanted) :]
    np.testing.assert_allclose(data["time"].to_numpy()[-len(wanted) :], wanted[:, 0], atol=1e-4)
    rigid = data["point_position"].sel(point=point).to_numpy()[-len(wanted) :]
    assert np.abs(rigid - found).max() > 1e-3  # m: they do bend
    assert np.abs(found - wanted[:, 1:]).max() < limit


@pytest.mark.slow  # steps of bending links
def test_double_pendulum_of_slender_bars():
    assert_near(bars([1.0, 1.0], [0.0, 0.0]), "b1.B", "double pendulum", 5e-4)  # of 0.42 m that it falls
