"""The two masses of appendix A in time, three ways, against the exact solution of (A.4)."""

import numpy as np
import pytest
from scipy.linalg import expm

import fenics_mech as fm

MASS, LENGTH = np.array([1.57, 1.57]), 0.1  # kg, m: of bars of 2e-3 m^2 and 7850 kg/m^3
STIFFNESS, DAMPING = (200.0, 300.0), (2.0, 3.0)  # k1, k2 (N/m), c1, c2 (N s/m)
PUSH, RATE = np.array([4.0, -3.0]), 9.0  # f1 and f2 are these times sin(RATE t), N and rad/s
START, SPEED = np.array([0.02, -0.01]), np.array([0.3, 0.1])  # m, m/s


def exact(times):
    """Places and rates of both masses by the exponential of the matrix of states and loads, ``(times, 4)``."""
    (k1, k2), (c1, c2) = STIFFNESS, DAMPING
    inverse, whole = np.diag(1 / MASS), np.zeros((6, 6))
    whole[:2, 2:4] = np.eye(2)
    whole[2:4, :2] = -inverse @ [[k1 + k2, -k2], [-k2, k2]]
    whole[2:4, 2:4] = -inverse @ [[c1 + c2, -c2], [-c2, c2]]
    whole[2:4, 4] = PUSH / MASS  # sin and cos are the last two unknowns
    whole[4, 5], whole[5, 4] = RATE, -RATE
    start = np.concatenate([START, SPEED, [0.0, 1.0]])
    return np.array([(expm(whole * time) @ start)[:4] for time in times])


def masses(way: str) -> fm.Scene:
    """Give the masses as rigid links that slide on the ground, or the second on the first, or as members."""
    bends, chain = way == "members", way == "on each other"
    bar = {"bar": fm.Member(ends=("A", "B"), section="bar", material="steel")}
    body = {"members": bar} if bends else {"rigid": fm.RigidBody(mass=MASS[0])}
    link = fm.Link(points={"A": (0, 0), "B": (LENGTH, 0)}, **body)
    places, rates = (np.diff(part, prepend=0.0) if chain else part for part in (START, SPEED))
    pushes = np.cumsum(PUSH[::-1])[::-1] if chain else PUSH  # an effort between the masses acts on both
    starts = zip(places + ([0.0, 1.0 - LENGTH] if chain else [0.0, 0.0]), rates, pushes)
    between = {"one": ("ground.W", "first.A", 2.0), "two": ("first.A", "second.A", 1.0)}
    of_members = {
        "materials": {"steel": fm.Material(modulus=2e11, density=7850)},
        "sections": {"bar": fm.RectangleSection(width="40 mm", height="50 mm")},
        "effects": ("coupling",),
        "mesh": fm.Mesh(elements=1),
        "damping": fm.Damping(material=1e-4),  # s: their axial vibration dies out
    }
    return fm.Scene(
        name="two masses",
        ground=fm.Ground(points={"O": (0, 0), "P": (1, 0), "W": (-2, 0)}),
        links={"first": link, "second": link},
        joints={
            "G": fm.Prismatic(connect=("ground.O", "first.A")),
            "H": fm.Prismatic(connect=("first.B" if chain else "ground.P", "second.A")),
        },
        freedoms={
            name: fm.Freedom(start=place, speed=rate, effort={"kind": "formula", "formula": f"{push}*sin({RATE}*t)"})
            for name, (place, rate, push) in zip("GH", starts)
        },
        springs={
            name: fm.LineSpring(between=(first, second), stiffness=k, length=length)
            for (name, (first, second, length)), k in zip(between.items(), STIFFNESS)
        },
        dampers={
            name: fm.LineDamper(between=(first, second), damping=c)
            for (name, (first, second, _)), c in zip(between.items(), DAMPING)
        },
        analysis=fm.Analysis(
            method="transient", duration=1.5, sub_intervals=15, time_tolerance=1e-7, error_estimates=False
        ),
        **(of_members if bends else {}),
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("way", "limit"),
    [("on the ground", 1e-9), ("on each other", 1e-9), pytest.param("members", 1e-8, marks=pytest.mark.slow)],
)
def test_two_masses_move_as_the_exact_solution(way, limit):
    data = fm.analyse(masses(way)).data
    wanted = exact(data["time"].to_numpy())
    for i, name in enumerate(("first.A", "second.A")):
        found = data["point_position"].sel(point=name, component="x").to_numpy() - i
        np.testing.assert_allclose(found, wanted[:, i], atol=limit)
    assert np.ptp(wanted[:, :2]) > 0.05  # m
    assert data.attrs["power_balance_error"] < 1e-6
