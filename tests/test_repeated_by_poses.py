"""Motions that repeat, of links that bend: stiff ones move as rigid ones do, and cycles are closed in energy."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.answers.by_poses import planned
from fenics_mech.answers.repeated_by_poses import BendingRunner
from fenics_mech.solve.repeated import ANGLE

TURN, STEEL = 2 * np.pi, 2e11
WIDTH, DENSITY = 20e-3, 7850.0  # m, kg/m^3


def link(length: float, points: tuple[str, str], modulus: float | None) -> fm.Link:
    """Give a bar that bends, or where it has no modulus, a rigid one."""
    ends = dict(zip(points, ((0, 0), (length, 0))))
    if modulus is not None:
        return fm.Link(points=ends, members={"bar": fm.Member(ends=points, section="square", material="stiff")})
    mass = DENSITY * WIDTH**2 * length
    return fm.Link(points=ends, rigid=fm.RigidBody(mass=mass, centre=(length / 2, 0), inertia=mass * length**2 / 12))


def machine(modulus: float | None, links: dict[str, fm.Link], **parts) -> fm.Scene:
    bending = {} if modulus is None else {"mesh": fm.Mesh(elements=1)}
    if modulus is not None:
        bending |= {"materials": {"stiff": fm.Material(modulus=modulus, density=DENSITY)}}
        bending |= {"sections": {"square": fm.RectangleSection(width=WIDTH, height=WIDTH)}}
    return fm.Scene(name="machine", ground=fm.Ground(points={"O": (0, 0)}), links=links, **bending, **parts)


def pendulum(modulus: float | None, formula: str, **analysis) -> fm.Scene:
    options = {"method": "transient", "sub_intervals": 12, "error_estimates": False, "time_tolerance": 1e-4}
    return machine(
        modulus,
        {"arm": link(1.0, ("O", "A"), modulus)},
        joints={"O": fm.Revolute(connect=("ground.O", "arm.O"))},
        gravity=(0, -9.81),
        freedoms={"O": fm.Freedom(start=-1.5, effort=fm.FormulaEffort(formula=formula))},
        analysis=fm.Analysis(**options | analysis),
    )


def press(modulus: float | None, **analysis) -> fm.Scene:
    """Give a slider-crank that a motor turns against a load over its angle."""
    block = fm.Link(points={"B": (0, 0), "C": (0, 0)}, rigid=fm.RigidBody(mass=0.5, inertia=1e-4))
    formula = "12*(1 - omega/100) - 4*(1 - cos(theta))"
    effort = fm.FormulaEffort(formula=formula)
    options = {"method": "transient", "start": "periodic", "duration": TURN / 60, "cycles": 2, "sub_intervals": 12}
    return machine(
        modulus,
        {"crank": link(0.1, ("O", "A"), modulus), "rod": link(0.3, ("A", "B"), modulus), "block": block},
        joints={
            "O": fm.Revolute(connect=("ground.O", "crank.O")),
            "A": fm.Revolute(connect=("crank.A", "rod.A")),
            "B": fm.Revolute(connect=("rod.B", "block.B")),
            "G": fm.Prismatic(connect=("ground.O", "block.C")),
        },
        freedoms={"O": fm.Freedom(start=0.3, speed=60.0, inertia=0.01, effort=effort)},
        analysis=fm.Analysis(**options | {"error_estimates": False, "time_tolerance": 1e-4} | analysis),
    )


def multipliers(data) -> np.ndarray:
    return data["multiplier"].transpose("disturbance", "part").to_numpy() @ [1, 1j]


@pytest.mark.slow
def test_stiff_links_under_a_torque_repeat_as_rigid_ones():
    stated = {"start": "periodic", "duration": TURN / 3, "cycles": 3}
    stiff, rigid = (fm.analyse(pendulum(x, "5*cos(3*t) - 2*omega", **stated)).data for x in (1e3 * STEEL, None))
    np.testing.assert_allclose(multipliers(stiff)[:2], multipliers(rigid), atol=1e-5)
    np.testing.assert_allclose(multipliers(stiff)[2:], 0.0, atol=1e-5)
    inertia = DENSITY * WIDTH**2 / 3
    assert np.prod(multipliers(stiff)[:2]).real == pytest.approx(np.exp(-2 / inertia * TURN / 3), rel=1e-3)  # Liouville
    np.testing.assert_allclose(stiff["freedom_place"], rigid["freedom_place"], atol=1e-5)
    assert stiff.attrs["closing_error"] < 1e-6
    assert abs(stiff["mean_power"].sum()) < 1e-6  # W: what the torque does is what the damper takes


@pytest.mark.slow
def test_stiff_links_have_the_period_of_rigid_ones_of_their_own():
    stiff, rigid = (fm.analyse(press(x)).data for x in (100 * STEEL, None))
    assert stiff.attrs["own_period"] == 1
    assert stiff.attrs["repeats_after"] == pytest.approx(rigid.attrs["repeats_after"], rel=1e-5)
    np.testing.assert_allclose(multipliers(stiff)[:2], multipliers(rigid), atol=1e-4)
    assert float(np.ptp(stiff["freedom_place"].to_numpy()[[0, -1]])) == pytest.approx(TURN, abs=1e-6)


@pytest.mark.slow
def test_exponents_and_a_section_of_stiff_links_are_those_of_rigid_ones():
    stated = {"start": "smooth", "duration": 3.0, "lyapunov": True, "poincare": {"every": 0.7}}
    stiff, rigid = (fm.analyse(pendulum(x, "25*cos(3*t) - omega", **stated)).data for x in (100 * STEEL, None))
    for name in ("lyapunov_exponent", "disturbance_growth", "section_place", "section_rate"):
        np.testing.assert_allclose(stiff[name], rigid[name], atol=2e-3)
    passing = {"start": "smooth", "duration": 3.0, "poincare": {"joint": "O", "at": -1.4}}
    times = [fm.analyse(pendulum(x, "25*cos(3*t) - omega", **passing)).data["section_time"] for x in (STEEL, None)]
    np.testing.assert_allclose(*times, atol=1e-3)


@pytest.mark.slow
def test_disturbances_are_the_derivatives_of_steps_at_the_same_shares():
    runner = BendingRunner(planned(press(STEEL)))
    start = runner.begin()
    lap = runner.lap(start, 2e-3)
    orthogonal = np.linalg.qr(lap.disturbed / lap.sizes[:, None])[0]
    for way in np.random.default_rng(0).normal(size=(3, orthogonal.shape[1])):
        change = 1e-6 * lap.sizes * (orthogonal @ way)
        size = np.linalg.lstsq(lap.disturbed / lap.sizes[:, None], change / lap.sizes, rcond=None)[0]
        ends = [runner.lap(runner.moved(start, sign * change), 2e-3, lap.shares).end for sign in (1, -1)]
        found = np.subtract(*(runner.missed(start, end) for end in ends)) / 2 / lap.sizes
        np.testing.assert_allclose(found, lap.transition @ size / lap.sizes, atol=1e-5 * np.abs(found).max())
    assert set(runner.kinds[[0, 1]]) != {ANGLE}


@pytest.mark.slow
def test_a_state_beside_another_fulfils_the_rows():
    runner = BendingRunner(planned(press(STEEL)))
    start = runner.begin()
    way = runner.lap(start, 1e-3).disturbed @ np.random.default_rng(0).normal(
        size=runner.lap(start, 1e-3).disturbed.shape[1]
    )
    moved = runner.moved(start, 1e-2 * way / np.abs(way).max())
    again = runner.moved(moved, np.zeros_like(way))
    np.testing.assert_allclose(again.displacement, moved.displacement, atol=1e-12)
    np.testing.assert_allclose(again.velocity, moved.velocity, atol=1e-9)
