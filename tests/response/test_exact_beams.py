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


def bars(lengths, angles, closed: bool = False, **changes) -> fm.Scene:
    """Give slender bars of steel in a chain, the first from the origin; three may be closed to a four-bar."""
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
        joints=joints | ({"Q": fm.Revolute(connect=("b2.B", "ground.Q"))} if closed else {}),
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
    np.testing.assert_allclose(data["time"].to_numpy()[-len(wanted) :], wanted[:, 0], atol=1e-9)
    rigid = data["point_position"].sel(point=point).to_numpy()[-len(wanted) :]
    assert np.abs(rigid - found).max() > 2e-4  # m: they do bend
    assert np.abs(found - wanted[:, 1:]).max() < limit


@pytest.mark.long
@pytest.mark.slow  # steps of bending links
def test_double_pendulum_of_slender_bars():
    assert_near(bars([1.0, 1.0], [0.0, 0.0]), "b1.B", "double pendulum", 5e-5)  # of 0.42 m that it falls


@pytest.mark.long
@pytest.mark.slow  # steps of bending links
def test_double_pendulum_of_bars_that_bend_far():
    """Their ends move by 0.13 of their length against a frame that is clamped at the pin."""
    soft = {"sections.bar": fm.RectangleSection(width=0.02, height=0.002), "analysis.duration": 0.4}
    scene = bars([1.0, 1.0], [0.0, 0.0], **soft, **{"analysis.time_tolerance": 1e-3})
    assert_near(scene, "b1.B", "soft double pendulum", 9e-4)  # 4.6e-4 of 0.89 m, with 2 elements a bar


FOUR_BAR = np.array([[0.0, 0.0], [0.21612092, 0.33658839], [0.97305294, 0.59553612], [0.9, 0.0]])  # as in the script


@pytest.mark.long
@pytest.mark.slow  # steps of bending links
def test_four_bar_of_slender_bars():
    ways = np.diff(FOUR_BAR, axis=0)
    scene = bars(
        np.linalg.norm(ways, axis=1),
        np.arctan2(ways[:, 1], ways[:, 0]),
        closed=True,
        **{"sections.bar": fm.RectangleSection(width=0.02, height=0.004), "damping": {"material": 1e-4}},
        freedoms={"P0": {}},
    )
    assert_near(scene, "b1.B", "four-bar", 7e-5)  # 1e-3 of the 76 mm that it moves


@pytest.mark.long
@pytest.mark.slow  # steps of bending links
def test_a_bar_that_a_torque_spins_up():
    thin = {"sections.bar": fm.RectangleSection(width=0.02, height=0.004), "analysis.duration": 0.4}
    thin |= {"damping": {"material": 1e-4}, "mesh.elements": 4}
    assert_near(bars([1.0], [0.0], **thin, freedoms={"P0": {"effort": 5.0}}), "b0.B", "spun bar", 5e-4)  # of 0.69 m


def flying() -> fm.Scene:
    """Give the beam of `tests/data/flying_exact.py`: two carriages without weight let its middle go where it will."""
    halves = {
        name: fm.Member(ends=ends, section="bar", material="metal")
        for name, ends in (("lower", ("A", "M")), ("upper", ("M", "B")))
    }
    carriage = fm.RigidBody(mass=1e-3, inertia=1e-3)
    return fm.Scene(
        name="flying beam",
        materials={"metal": fm.Material(modulus=1e4, density=1.0)},
        sections={"bar": fm.CustomSection(area=1.0, inertia=0.05, fibre=0.3)},
        ground=fm.Ground(points={"O": (3, 4)}),
        links={
            "along": fm.Link(points={"P": (0, 0)}, rigid=carriage),
            "across": fm.Link(points={"P": (0, 0), "Q": (0, 0)}, rigid=carriage),
            "beam": fm.Link(
                points={"A": (-5, 0), "M": (0, 0), "B": (5, 0)}, members=halves, angle=float(np.arctan2(8, -6))
            ),
        },
        joints={
            "X": fm.Prismatic(connect=("ground.O", "along.P")),
            "Y": fm.Prismatic(connect=("along.P", "across.P"), angle=np.pi / 2),
            "M": fm.Revolute(connect=("across.Q", "beam.M")),
        },
        freedoms={name: fm.Freedom() for name in "XYM"},
        loads={"end": fm.Load(at="beam.A", force=(8, 0), moment=80)},
        effects=("coupling", "large-rotations"),
        mesh=fm.Mesh(elements=2),
        analysis=fm.Analysis(
            method="transient",
            duration=0.8,
            sub_intervals=8,
            time_tolerance=1e-5,  # of the waves that a moment at once excites, steps at 1e-3 damp 2 % of the energy
            stations=9,
            allow_coarse=True,
            error_estimates=False,
        ),
    )


def heavy() -> fm.Scene:
    """Give the heavy beam of `tests/data/flying_exact.py`: plies far from its axis have its mass and no stiffness."""
    core, ply = 0.6**0.5, 0.01  # thickness with EA = 1e4 and EI = 500, and of a ply with half of the mass
    gap = 10**0.5 - core / 2 - ply / 2  # m: rho I = 10
    light = {"density": 1e-9}
    metal, foam = fm.Material(modulus=1e4 / core, **light), fm.Material(modulus=1e-6, **light)
    lead = fm.Material(modulus=1e-6, density=1 / (2 * ply))
    outer = (fm.Ply(thickness=ply, material="lead"), fm.Ply(thickness=gap, material="foam"))
    plies = (*outer, fm.Ply(thickness=core, material="metal"), *outer[::-1])
    return flying().changed(
        materials={"metal": metal, "foam": foam, "lead": lead},
        sections={"bar": fm.LaminateSection(width=1.0, plies=plies)},
        effects=("coupling", "large-rotations", "rotary-inertia"),
    )


@pytest.mark.slow  # steps of bending links
def test_a_beam_with_heavy_sections_that_flies_off():
    """With the sections' inertia of the paper, which resists turning as the mass does."""
    known = np.loadtxt(ROOT / "tests" / "data" / "flying_heavy_exact.csv", delimiter=",", skiprows=1)
    result = fm.analyse(heavy().changed(mesh__elements=10))
    assert result.data["rotation"].max() > 0.8
    assert result.data.attrs["power_balance_error"] < 1e-4
    for k, point in enumerate("AMB"):
        found = result.data["point_position_bent"].sel(point=f"beam.{point}").to_numpy()
        # the lower end moves by 2.0 m, by 3.5 m without this inertia, and 0.06 m away if that is for small rotations;
        # it is 1 mm off, the middle 5.3 mm; 7 and 21 mm with 4 elements, as sections turn linearly within each
        assert np.abs(found - known[:, 1 + 2 * k : 3 + 2 * k]).max() < 0.006


@pytest.mark.long
@pytest.mark.slow  # steps of bending links
def test_a_beam_that_flies_off():
    """Of Simo and Vu-Quoc (1986): it turns by 1.1 rad against its middle."""
    known = np.loadtxt(ROOT / "tests" / "data" / "flying_exact.csv", delimiter=",", skiprows=1)
    data = fm.analyse(flying().changed(mesh__elements=4)).data
    np.testing.assert_allclose(data["time"].to_numpy(), known[:, 0], atol=1e-9)
    assert data["rotation"].max() > 1.05
    for k, point in enumerate("AMB"):
        found = data["point_position_bent"].sel(point=f"beam.{point}").to_numpy()
        wanted = known[:, 1 + 2 * k : 3 + 2 * k]
        # a moment that begins at once bends elements that are a quarter of the beam; it moves the ends by 3.5 and 1.1 m
        assert np.abs(found - wanted).max() < 0.1
    assert data.attrs["power_balance_error"] < 1e-3
