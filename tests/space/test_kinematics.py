"""How rigid linkages in space move, against closed forms.

Sources: Hunt, Kinematic Geometry of Mechanisms (1978), for Bennett's and Bricard's linkages; Chiang, Kinematics of
Spherical Mechanisms (1988); Hartenberg and Denavit, Kinematic Synthesis of Linkages (1964), for RSSR and RSSP.
"""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import MechanismError
from tests.space.machines import (
    ORIGIN,
    RSSP_N,
    RSSP_P,
    X,
    Y,
    Z,
    bar,
    body,
    place,
    rigid_rssr_links,
    rod,
    rssp,
    rssp_stroke,
    rssr,
    rssr_ball,
    scene,
)  # fmt: skip

ROUNDING = 1e-12  # m, of machines of 0.1 to 1 m


def places_of(result, joint):
    """Give where the joint's second link has its point over the cycle ``(positions, 3)`` (m)."""
    return np.asarray(result.data["joint_place"].sel(joint=joint))


@pytest.mark.parametrize("balls", [1, 2])
@pytest.mark.parametrize("method", ["periodic", "quasi-static"])
def test_the_rocker_of_an_rssr_turns_as_its_closed_form(balls, method):
    result = fm.analyse(rssr(rigid_rssr_links(), balls=balls, analysis={"method": method, "positions": 72}))
    theta = np.asarray(result.data["theta"])
    np.testing.assert_allclose(places_of(result, "B"), rssr_ball(theta), atol=ROUNDING)
    crank = 0.1 * np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1)
    np.testing.assert_allclose(places_of(result, "A"), crank, atol=ROUNDING)
    assert result.data.attrs["mobility"] == balls
    assert (balls == 2) == any("about its own line" in text for text in result.notices)


def test_a_drive_may_go_back_and_forth():
    """A law of the crank's angle, which begins at the drawn position: its mean is added to it."""
    law = {"kind": "harmonics", "sine": [0.5], "cosine": [0.0, 0.2]}
    made = rssr(rigid_rssr_links(), drive={"joint": "O", "law": law, "period": 0.4}, analysis={"positions": 40})
    result = fm.analyse(made)
    theta = np.asarray(result.data["theta"])
    angle = 0.5 * np.sin(theta) + 0.2 * (np.cos(2 * theta) - 1)
    np.testing.assert_allclose(places_of(result, "B"), rssr_ball(angle), atol=ROUNDING)


def test_a_slider_crank_in_space_has_its_closed_stroke():
    """RSSP: the slider on a skew line, |P + s n - A| = l of the rod between two balls."""
    result = fm.analyse(rssp(drive={"joint": "O", "speed": -4.0}, analysis={"positions": 48}))
    found = (places_of(result, "P") - RSSP_P) @ RSSP_N
    theta = np.asarray(result.data["theta"])
    assert theta[1] < 0  # the drive turns backwards
    np.testing.assert_allclose(found, rssp_stroke(theta), atol=ROUNDING)
    assert np.ptp(found) == pytest.approx(np.ptp(rssp_stroke(np.linspace(0, 2 * np.pi, 2001))), rel=2e-3)


@pytest.mark.parametrize("degrees", [10.0, 40.0])
def test_a_universal_joint_turns_unevenly(degrees):
    """Hooke's joint: tan of the output = tan of the input / cos b, and torques are inverse to speeds.

    Both angles are from the position in which the fork of the first shaft lies in the plane of both shafts.
    """
    b, torque = np.radians(degrees), 3.0
    along = np.array([np.cos(b), np.sin(b), 0.0])  # second shaft
    fork = np.array([-np.sin(b), np.cos(b), 0.0])  # of the second shaft, in the plane of both; the first has Z
    C, D = 0.3 * along, 0.3 * along + 0.1 * fork
    made = scene(
        {
            "one": body({"A": (-0.3, 0, 0), "M": ORIGIN}, 1.0, (1e-3, 2e-3, 2e-3), (-0.15, 0, 0)),
            "two": body({"M": ORIGIN, "C": C, "D": D}, 1.0, (1e-3, 2e-3, 2e-3), 0.15 * along),
            "flag": body({"D": D}, 0.0, (0, 0, 0), D),
        },
        {
            "A": {"connect": ("ground.A", "one.A"), "axis": X},
            "M": {"connect": ("one.M", "two.M"), "kind": "universal", "axes": (Z, place(fork))},
            "C": {"connect": ("ground.C", "two.C"), "axis": place(along)},
            "D": {"connect": ("two.D", "flag.D"), "kind": "weld"},
        },
        ground={"points": {"A": (-0.3, 0, 0), "C": place(C)}},
        loads={"brake": {"joint": "C", "torque": torque}},
        drive={"joint": "A", "speed": 1e-3},  # inertia has no part
        analysis={"positions": 36},
    )
    result = fm.analyse(made)
    theta = np.asarray(result.data["theta"])
    flag = (places_of(result, "D") - C) / 0.1
    third = np.cross(along, fork)  # Z
    output = np.arctan2(flag @ third, flag @ fork)
    # the first fork lies along Z, across the plane of the shafts: a quarter of a turn from the textbook's start
    exact = np.arctan2(np.sin(theta) * np.cos(b), np.cos(theta))
    off = np.exp(1j * output) * np.exp(-1j * exact)
    np.testing.assert_allclose(off, 1.0, atol=1e-11)
    ratio = np.cos(b) / (1 - np.sin(b) ** 2 * np.sin(theta) ** 2)  # output speed over input speed
    np.testing.assert_allclose(result.data["input_torque"][:, 0], -torque * ratio, rtol=1e-5)


def spherical(theta, arcs):
    """Give the ground axes, and those of both moving joints, of a spherical four-bar by the crank's angle."""
    crank, coupler, rocker, ground = arcs
    a, d = np.array(Z), np.array([np.sin(ground), 0, np.cos(ground)])
    b = np.stack([np.sin(crank) * np.cos(theta), np.sin(crank) * np.sin(theta), np.cos(crank) + 0 * theta], axis=-1)
    x, y = np.array([np.cos(ground), 0, -np.sin(ground)]), np.array(Y)  # c = cos r d + sin r (cos p x + sin p y)
    reach = (np.cos(coupler) - np.cos(rocker) * (b @ d)) / np.sin(rocker)
    angle = np.arctan2(b @ y, b @ x) - np.arccos(reach / np.hypot(b @ x, b @ y))
    c = np.cos(rocker) * d + np.sin(rocker) * (np.cos(angle)[..., None] * x + np.sin(angle)[..., None] * y)
    return a, b, c, d


def test_a_spherical_four_bar_turns_as_its_closed_form():
    """Four axes meet in a point: the linkage moves although three rows more than needed hold it."""
    arcs = np.radians([30.0, 65.0, 60.0, 70.0])
    a, b, c, d = spherical(np.zeros(()), arcs)
    made = scene(
        {
            "crank": body({"O": a, "B": b}, 1.0, (1e-2,) * 3, (a + b) / 2),
            "coupler": body({"B": b, "C": c}, 1.0, (1e-2,) * 3, (b + c) / 2),
            "rocker": body({"Q": d, "C": c}, 1.0, (1e-2,) * 3, (d + c) / 2),
        },
        {
            "O": {"connect": ("ground.O", "crank.O"), "axis": place(a)},
            "B": {"connect": ("crank.B", "coupler.B"), "axis": place(b)},
            "C": {"connect": ("coupler.C", "rocker.C"), "axis": place(c)},
            "Q": {"connect": ("ground.Q", "rocker.Q"), "axis": place(d)},
        },
        ground={"points": {"O": place(a), "Q": place(d)}},
        drive={"joint": "O", "speed": 1.0},
        analysis={"positions": 36},
    )
    result = fm.analyse(made)
    _, b, c, _ = spherical(np.asarray(result.data["theta"]), arcs)
    np.testing.assert_allclose(places_of(result, "B"), b, atol=1e-8)  # rows with slack give way by forces of inertia
    np.testing.assert_allclose(places_of(result, "C"), c, atol=1e-8)
    assert result.data.attrs["mobility"] == 1
    assert any("hold more than is needed" in text for text in result.notices)


def bennett(first, second, twist, theta):
    """Give places and axes of the joints of Bennett's linkage, first of whose angles is theta.

    Sides a, b, a, b with twists p, q, p, q and a sin q = b sin p; tan of both half angles have a constant product.
    """
    other = np.arcsin(second * np.sin(twist) / first)

    def turn(angle):
        return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])

    def tilt(angle):
        return np.array([[1.0, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])

    product = np.sin((other + twist) / 2) / np.sin((other - twist) / 2)
    following = 2 * np.arctan(product / np.tan(theta / 2))
    places, axes, R, r = [], [], np.eye(3), np.zeros(3)
    for angle, side, lean in ((theta, first, twist), (following, second, other), (-theta, first, twist)):
        places.append(r)
        axes.append(R[:, 2])
        R = R @ turn(angle)
        r = r + side * R[:, 0]
        R = R @ tilt(lean)
    return np.array([*places, r]), np.array([*axes, R[:, 2]])


SIDES = 1.0, 0.8, np.radians(60)


def bennett_scene(link, lean=0.0, **keys):
    """Make Bennett's linkage of some links; the axis of its third joint leans by some degrees."""
    P, axes = bennett(*SIDES, 1.0)
    back = P[3] + 0 * axes[3]
    close = np.linalg.norm(P[3] - P[0])
    assert close == pytest.approx(0.8)  # the fourth side
    axes[2] = axes[2] + np.tan(np.radians(lean)) * (P[2] - P[1])
    return scene(
        {"one": link(P[0], P[1], axes[0]), "two": link(P[1], P[2], axes[1]), "three": link(P[2], back, axes[2])},
        {
            "J0": {"connect": ("ground.A", "one.A"), "axis": place(axes[0])},
            "J1": {"connect": ("one.B", "two.A"), "axis": place(axes[1])},
            "J2": {"connect": ("two.B", "three.A"), "axis": place(axes[2])},
            "J3": {"connect": ("three.B", "ground.D"), "axis": place(axes[3])},
        },
        ground={"points": {"A": place(P[0]), "D": place(back)}},
        sections={"bar": {"shape": "rectangle", "height": 9e-3, "width": 6e-3}},
        **({"drive": {"joint": "J0", "speed": 0.5}, "analysis": {"positions": 24, "modes": 0}} | keys),
    )


def rigid_side(A, B, up):
    return rod({"A": A, "B": B})


def test_a_bennett_linkage_moves_as_its_closed_form():
    """By Gruebler's count its mobility is -2; its sides and twists give it 1."""
    result = fm.analyse(bennett_scene(rigid_side))
    assert result.data.attrs["mobility"] == 1
    theta = np.asarray(result.data["theta"])
    P0, axes0 = bennett(*SIDES, 1.0)
    # the closed form has its last side fixed in a frame of the first joint: bring that side where it is drawn
    for k, angle in enumerate(1.0 + theta):
        P, axes = bennett(*SIDES, angle)
        assert np.linalg.norm(P[3] - P[0]) == pytest.approx(0.8)
        frame0, frame = (
            np.stack([p[3] - p[0], a[0], np.cross(p[3] - p[0], a[0])], axis=1) for p, a in ((P0, axes0), (P, axes))
        )
        place_of_2 = frame0 @ np.linalg.solve(frame, P[2])
        np.testing.assert_allclose(places_of(result, "J2")[k], place_of_2, atol=1e-7)  # of slack in its rows


def test_a_bennett_linkage_with_a_leaning_axis_cannot_move():
    """Rigid links: an error. Members: they bend, and a notice says so."""
    with pytest.raises(MechanismError, match="joint 'J1' has a gap of"):
        fm.analyse(bennett_scene(rigid_side, 1.0))
    swing = {"joint": "J0", "law": {"kind": "harmonics", "sine": [0.4]}, "period": 10.0}
    analysis = {"method": "quasi-static", "positions": 24, "modes": 0}
    result = fm.analyse(bennett_scene(bar, 1.0, mesh={"elements": 2}, drive=swing, analysis=analysis))
    assert result.data.attrs["mobility"] == 0
    assert any("could not move" in text for text in result.notices)
    assert float(np.abs(result.data["stress"]).max()) > 1e6


CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], dtype=float)


def bricard(**keys):
    """Bricard's linkage of the IFToMM library: six hinges along edges of a cube, five moving rods of 1 m and 1 kg."""
    axes = [np.cross(CUBE[k] - CUBE[k - 1], CUBE[(k + 1) % 6] - CUBE[k]) for k in range(6)]
    links = {f"rod{k}": rod({"A": CUBE[k], "B": CUBE[k + 1]}) for k in range(5)}
    bodies = ["ground.P", *(f"rod{k}.B" for k in range(5))]
    starts = [*(f"rod{k}.A" for k in range(5)), "ground.F"]
    joints = {f"J{k}": {"connect": (bodies[k], starts[k]), "axis": place(axes[k])} for k in range(6)}
    return scene(links, joints, ground={"points": {"P": place(CUBE[0]), "F": place(CUBE[5])}}, **keys)


def swung(angle):
    """Swing a Bricard linkage from its drawn cube to twice an angle (rad) and back, slowly."""
    law = {"kind": "harmonics", "mean": angle, "cosine": [-angle]}
    return fm.analyse(bricard(drive={"joint": "J0", "law": law, "period": 60.0}, analysis={"positions": 24}))


def test_a_bricard_linkage_has_one_freedom_and_keeps_its_rods():
    result = swung(-0.5)
    assert result.data.attrs["mobility"] == 1
    P = np.asarray(result.data["joint_place"])
    sides = np.linalg.norm(np.roll(P, -1, axis=1) - P, axis=-1)
    np.testing.assert_allclose(sides, 1.0, atol=1e-9)  # of slack under its weight of inertia
    assert np.linalg.norm(np.ptp(P, axis=0), axis=-1).max() > 0.5


@pytest.mark.parametrize("angle", [0.5, -3.0])
def test_a_bricard_linkage_that_is_driven_past_its_end_is_refused(angle):
    """It turns to one side of the cube only, and there not for ever."""
    with pytest.raises(MechanismError, match=r"rigid position at [\d.]+ degrees"):
        swung(angle)
