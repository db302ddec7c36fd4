"""Links that follow a freedom in long steps: past change points, up to where they lock, and over many links."""

import re

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import AssemblyError, MechanismError

A, D = 0.1, 0.3  # crank and ground (m); a rod of D and a rocker of A make a parallelogram


def four_bar(rod: float, rocker: float) -> fm.Scene:
    """A crank with a heavy flywheel that leads a rod and a rocker for more than a turn."""

    def bar(length, mass, *ends, angle=0.0):
        body = fm.RigidBody(mass=mass, inertia=mass * length**2 / 12, centre=(length / 2, 0))
        return fm.Link(points={ends[0]: (0, 0), ends[1]: (length, 0)}, rigid=body, angle=angle)

    return fm.Scene(
        name="four-bar",
        ground=fm.Ground(points={"O": (0, 0), "C": (D, 0)}),
        links={
            "crank": bar(A, 1.0, "O", "A"),
            "rod": bar(rod, 1.0, "A", "B"),
            "rocker": bar(rocker, 1.0, "C", "B", angle=1.0),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "crank.O")),
            "A": fm.Revolute(connect=("crank.A", "rod.A")),
            "B": fm.Revolute(connect=("rod.B", "rocker.B")),
            "C": fm.Revolute(connect=("ground.C", "rocker.C")),
        },
        freedoms={"O": {"start": 1.0, "speed": 5.0, "inertia": 100.0}},
        analysis=fm.Analysis(method="transient", duration=1.6, sub_intervals=100, error_estimates=False),
    )


def rocker_angle(theta, rod, rocker):
    """Angle of the rocker on the assembly with the rod above the diagonal: the cosine rule."""
    diagonal = A * np.exp(1j * theta) - D
    size = np.abs(diagonal)
    return np.angle(diagonal * np.exp(-1j * np.arccos((size**2 + rocker**2 - rod**2) / (2 * size * rocker))))


@pytest.mark.parametrize("gap", [1e-5, 3e-4])
def test_a_free_motion_passes_a_change_point_by_a_hair(gap):
    data = fm.analyse(four_bar(D, A + gap)).data
    theta, angle = data["freedom_place"].to_numpy()[:, 0], data["link_angle"].to_numpy()[:, 2]
    assert np.ptp(theta) > 2 * np.pi
    assert np.abs(np.exp(1j * angle) - np.exp(1j * rocker_angle(theta, D, A + gap))).max() < 1e-9


def test_a_free_parallelogram_is_refused_at_its_change_point():
    with pytest.raises(AssemblyError, match=r"at 0\.428\d* s .* change point.* rocker, rod moves\. .*other lengths"):
        fm.analyse(four_bar(D, A))  # (pi - 1)/5 s


@pytest.mark.parametrize("leading", ["O", "C", "A"])
def test_at_a_change_point_only_what_helps_is_advised(leading):
    """The joints' own equations are singular there, so that those with any freedom are."""
    moving = fm.Freedom(start={"O": 1.0, "C": 1.0, "A": -1.0}[leading], speed=-5.0 if leading == "A" else 5.0)
    scene = four_bar(D, A).changed(freedoms={leading: moving})
    with pytest.raises(AssemblyError, match=r"comes to a change point.*No other joint.*stops") as found:
        fm.analyse(scene)
    assert "State the freedom at another joint" not in str(found.value)


def test_stops_keep_a_free_parallelogram_from_its_change_point():
    """The remedy of its message: the crank of 100 kg m^2 at 5 rad/s turns back at both stops."""
    stop = fm.Stop(joint="O", lower=0.3, upper=2.5, contact=fm.Contact(stiffness=1e6))
    data = fm.analyse(four_bar(D, A).changed(joint_laws={"stop": stop})).data
    turned = data["freedom_place"].to_numpy()[:, 0]
    assert 2.5 < turned.max() < np.pi
    assert 0 < turned.min() < 0.3
    assert data["link_angle"].to_numpy()[:, 2] == pytest.approx(turned, abs=1e-9)


@pytest.mark.parametrize("longer", [1e-6, 1e-3])
def test_a_crank_that_locks_is_refused(longer):
    # rod and rocker come in line where A and C are the difference of their lengths apart
    least = np.arccos((A**2 + D**2 - (D + longer - A) ** 2) / (2 * A * D))
    with pytest.raises(MechanismError, match=r"dead centre: .*another joint") as found:
        fm.analyse(four_bar(D + longer, A))
    time = float(re.search(r"at (\S+) s", str(found.value))[1])
    assert time == pytest.approx((2 * np.pi - least - 1.0) / 5.0, rel=1e-4)  # the flywheel is 1e4 times as heavy
    assert "damping" not in str(found.value)
