"""Motions in time in space, against closed forms."""

import numpy as np
import pytest
from scipy.special import ellipk

import fenics_mech as fm

G = 9.81


def swinging(**analysis) -> fm.SpatialScene:
    """Give a rigid pendulum of 0.5 m with its mass at the end, released where it is horizontal; it swings about Y."""
    return fm.SpatialScene(
        gravity=(0, 0, -G),
        ground={"points": {"O": (0, 0, 0)}},
        links={"arm": {"points": {"O": (0, 0, 0)}, "rigid": {"mass": 2.0, "centre": (0.5, 0, 0)}}},
        joints={"O": {"connect": ("ground.O", "arm.O"), "axis": (0, 1, 0)}},
        analysis={"method": "transient", "error_estimates": False, **analysis},
    )


def test_a_pendulum_swings_in_its_period_and_pulls_with_three_weights():
    """A quarter of the period is K(1/2) sqrt(L/g); below, the speed squared is 2 g L, so that the pull is 3 m g."""
    quarter = ellipk(0.5) * np.sqrt(0.5 / G)
    data = fm.analyse(swinging(duration=quarter, positions=20, time_tolerance=1e-9)).data
    force = data["joint_force"].sel(joint="O")
    assert force.isel(theta=-1).sel(component="z").item() == pytest.approx(3 * 2.0 * G, rel=1e-6)
    assert abs(force.isel(theta=-1).sel(component="x").item()) < 1e-4 * 2.0 * G
    assert data["time"].values[-1] == pytest.approx(quarter)


def test_a_wheel_on_a_horizontal_axis_precesses_and_does_not_fall():
    """With a horizontal axis m g l = I w W holds for any speed: it stays level, and turns about the vertical."""
    mass, lever, own, spin = 1.0, 0.2, 0.004, 300.0
    precession = mass * G * lever / (own * spin)
    duration = 0.5 * np.pi / precession
    wheel = {"mass": mass, "inertia": (own, 0.002, 0.002), "centre": (lever, 0, 0)}
    frame = {"points": {"O": (0, 0, 0)}, "rigid": {"mass": 0.0}}
    scene = fm.SpatialScene(
        gravity=(0, 0, -G),
        ground={"points": {"O": (0, 0, 0)}},
        links={"post": frame, "fork": frame, "wheel": {"points": {"O": (0, 0, 0)}, "rigid": wheel}},
        joints={
            "turn": {"connect": ("ground.O", "post.O"), "axis": (0, 0, 1)},
            "tilt": {"connect": ("post.O", "fork.O"), "axis": (0, 1, 0)},
            "spin": {"connect": ("fork.O", "wheel.O"), "axis": (1, 0, 0)},
        },
        analysis={
            "method": "transient",
            "duration": duration,
            "positions": 10,
            "time_tolerance": 1e-8,
            "error_estimates": False,
            "start_speeds": {"spin": spin, "turn": precession, "tilt": 0.0},
        },
    )
    force = fm.analyse(scene).data["joint_force"].sel(joint="turn")
    # the centre goes on a circle: the post holds the weight, and pulls along the way to the centre
    assert np.abs(force.sel(component="z").values - mass * G).max() < 1e-4 * mass * G
    pull = np.hypot(force.sel(component="x").values, force.sel(component="y").values)
    assert np.abs(pull - mass * lever * precession**2).max() < 1e-4 * mass * G
    last = force.isel(theta=-1)  # after a quarter of a turn the pull is along -Y
    assert last.sel(component="y").item() == pytest.approx(-mass * lever * precession**2, rel=1e-3)


def test_speeds_that_rigid_links_cannot_have_are_refused():
    scene = swinging(duration=0.1, positions=8).changed(
        links={
            "arm": {"points": {"O": (0, 0, 0), "A": (1, 0, 0)}, "rigid": {"mass": 1.0}},
            "bar": {"points": {"A": (1, 0, 0), "B": (1, 0, 1)}, "rigid": {"mass": 1.0}},
        },
        joints={
            "O": {"connect": ("ground.O", "arm.O"), "axis": (0, 1, 0)},
            "A": {"connect": ("arm.A", "bar.A"), "kind": "weld"},
            "B": {"connect": ("ground.B", "bar.B"), "axis": (0, 1, 0)},
        },
        ground={"points": {"O": (0, 0, 0), "B": (1, 0, 1)}},
        analysis__start_speeds={"O": 3.0},
    )
    with pytest.raises(fm.SceneError, match="no motion of rigid links has the speeds"):
        fm.analyse(scene)


def test_a_motion_in_time_needs_its_duration():
    with pytest.raises(fm.SceneError, match="needs its duration"):
        swinging()
