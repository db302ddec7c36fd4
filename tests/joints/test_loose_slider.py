"""The slider-crank of Flores, Leine and Glocker (2010) against an independent program with instant impacts."""

from itertools import pairwise

import numpy as np
import pytest

import fenics_mech as fm
from tests.joints import loose_slider as program


def bar(part: int, length: float, first: str, second: str) -> fm.Link:
    """Give a bar of the data with its centre in the middle."""
    body = fm.RigidBody(mass=program.MASSES[part], inertia=program.INERTIAS[part], centre=(length / 2, 0))
    return fm.Link(points={first: (0, 0), second: (length, 0)}, rigid=body)


def course(stiffness: float) -> dict[float, float]:
    """Speed of the crank by time, in the first 8 ms."""
    contact = fm.Contact(stiffness=stiffness, restitution=program.RESTITUTION)
    loose = fm.GuideClearance(joint="G", play=program.PLAY, length=2 * program.HALF, contact=contact)
    body = fm.RigidBody(mass=program.MASSES[2], inertia=program.INERTIAS[2])
    scene = fm.Scene(
        name="loose slider",
        gravity=(0, -program.G),
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "crank": bar(0, program.CRANK, "O", "A"),
            "rod": bar(1, program.ROD, "A", "B"),
            "slider": fm.Link(points={"B": (0, 0), "P": (0, 0)}, rigid=body),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "crank.O")),
            "A": fm.Revolute(connect=("crank.A", "rod.A")),
            "B": fm.Revolute(connect=("rod.B", "slider.B")),
            "G": fm.Prismatic(connect=("ground.O", "slider.P")),
        },
        joint_laws={"loose": loose},
        freedoms={"O": fm.Freedom(start=0.0, speed=program.SPEED)},
        analysis=fm.Analysis(
            method="transient", duration=8e-3, sub_intervals=40, time_tolerance=1e-6, error_estimates=False
        ),
    )
    data = fm.analyse(scene).data
    return dict(zip(data["time"].to_numpy(), data["freedom_rate"].sel(freedom="O").to_numpy()))


@pytest.mark.slow  # six contacts, twice
def test_blows_of_a_loose_slider_become_those_of_impacts_that_take_no_time():
    states, off = program.course(4), []
    for stiffness in (1e9, 1e11):
        speeds = course(stiffness)
        flights = [np.mean([before[0], after[0]]) for before, after in pairwise(states)]
        times = [min(speeds, key=lambda time, middle=middle: abs(time - middle)) for middle in flights]
        wanted = [program.flown(state, time)[2] for state, time in zip(states, times)]
        off.append(np.abs([speeds[time] / one - 1 for time, one in zip(times, wanted)]))
    assert off[1][0] < 1e-7  # before the first blow
    assert (off[1][1:] < 3e-4).all()
    # a contact of Hertz takes a time that falls with K^-0.4
    np.testing.assert_allclose(off[0][1:3] / off[1][1:3], 100**0.4, rtol=0.05)
