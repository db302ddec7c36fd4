"""What scenes in space must not state, and machines that cannot move or rest: one clear error each, never a nan."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import MechanismError, SceneError, SolverError, UnstableError
from tests.common import DEMOS
from tests.space.machines import (
    ORIGIN,
    RSSR_A,
    X,
    Y,
    Z,
    bar,
    cantilever,
    place,
    rigid_rssr_links,
    rod,
    rssr,
    rssr_ball,
    rssr_output,
    scene,
    slim,
)

RSSR = fm.load(DEMOS / "space" / "rssr.toml")


@pytest.mark.parametrize(
    ("changes", "where", "what"),
    [
        ({"links.rocker.points.B": (0.46043, 0.1, -0.0907)}, "joints.B", r"miss each other by 0\.001 m"),
        ({"links.coupler.members.AB.up": (0.36043, 0.1, -0.0917)}, "links.coupler.members.AB.up", "lies along"),
        ({"links.coupler.members.AB.up": (0.0, 0.0, 0.0)}, "links.coupler.members.AB.up", "is none, or lies along"),
        ({"links.coupler.members.AB.up": None}, "links.coupler.members.AB", "does not say how it stands"),
        ({"links.coupler.members.AB.section": "cupler"}, "links.coupler.members.AB.section", "coupler"),
        ({"links.coupler.members.AB.material": "tin"}, "links.coupler.members.AB.material", "aluminium"),
        ({"links.coupler.members.AB.ends": ("A", "C")}, "links.coupler.members.AB.ends", "point"),
        ({"links.coupler.members.AB.ends": ("A", "A")}, "links.coupler.members.AB.ends", "at one place"),
        ({"joints.O.axis": None}, "joints.O", "needs its direction"),
        ({"joints.O.axis": (0.0, 0.0, 0.0)}, "joints.O", "three zeros"),
        ({"joints.A.axes": None}, "joints.A", "needs both axes"),
        ({"joints.A.axes": ((0, 0, 1), (0, 1, 1))}, "joints.A", "right angle"),
        ({"joints.B.axis": (0.0, 0.0, 1.0)}, "joints.B", "no such direction"),
        ({"joints.B.connect": ("coupler.B", "rockr.B")}, "joints.B.connect", "rocker"),
        ({"joints.B.connect": ("coupler.B", "rocker.C")}, "joints.B.connect", "point"),
        ({"joints.B.connect": ("coupler.B", "coupler.A")}, "joints.B.connect", "of coupler"),
        ({"drive.joint": "P"}, "drive.joint", "joint"),
        ({"drive.joint": "B"}, "drive.joint", "no such freedom"),
        ({"drive": ()}, "analysis.method", "no cycle"),
        ({"joints.B.misaligned": {"about": (1, 0, 0), "by": 0.1}}, "joints.B", "no axis that could lean"),
        ({"joints.O.misaligned": {"about": (1, 0, 0), "by": "100 deg"}}, "joints.O.misaligned", "1.57"),
        ({"springs": {"s": {"between": ("crank.A", "coupler.A"), "stiffness": 1.0}}}, "springs.s", "at one place"),
        ({"dampers": {"d": {"between": ("ground.O", "crank.O"), "damping": 1.0}}}, "dampers.d", "at one place"),
        ({"masses": {"m": {"at": "couple@0.5", "mass": 1.0}}}, "masses.m.at", "coupler"),
        ({"masses": {"m": {"at": "coupler", "mass": 1.0}}}, "masses.m.at", "no point"),
        ({"masses": {"m": {"at": "coupler@0.0000001", "mass": 1.0}}}, "links", "0 and 1e-07 along member coupler"),
        ({"loads": {"t": {"joint": "B", "torque": 1.0}}}, "loads.t.joint", "no such freedom"),
        ({"loads": {"t": {"joint": "O", "torque": 1.0, "push": 1.0}}}, "loads.t.joint", "no such freedom"),
        ({"loads": {"t": {"joint": "O"}}}, "loads.t", "torque or a push"),
        ({"links.rocker.points.Z": (0.0, 0.0, 1.0)}, "links.rocker.points.Z", "at no end"),
        ({"gravity": (0.0, 0.0, float("nan"))}, "gravity", "finite"),
        ({"sections.crank.height": float("inf")}, "sections.crank", "finite"),
        ({"links.coupler.points.A": (0.1, 0.0)}, "links.coupler.points.A", ""),
    ],
)
def test_a_wrong_scene_is_told_with_its_place(changes, where, what):
    with pytest.raises(SceneError, match=what) as told:
        fm.analyse(RSSR.changed(changes))
    assert str(told.value).startswith(where)


def test_a_link_that_turns_about_its_own_line_is_held_and_told():
    """An RSSR on two balls; the moment is that of the rod's weight and inertia about its line: none of a thin one."""
    result = fm.analyse(rssr(rigid_rssr_links(), balls=2, analysis={"positions": 36}))
    assert any("link coupler may turn about its own line" in text for text in result.notices)
    assert list(result.data["held_link"].values) == ["coupler"]
    assert float(np.abs(result.data["holding_moment"]).max()) < 1e-9
    # an inertia about its line takes a moment, which the notice tells
    links, B = rigid_rssr_links(), rssr_ball(0.0)
    e, disc = (B - RSSR_A) / 0.4, 4e-3
    tensor = (0.4**2 / 12 + disc / 2) * (np.eye(3) - np.outer(e, e)) + disc * np.outer(e, e)
    products = (-tensor[0, 1], -tensor[0, 2], -tensor[1, 2])
    links["coupler"]["rigid"] |= {"inertia": place(np.diag(tensor)), "products": products}
    heavy = fm.analyse(rssr(links, balls=2, analysis={"positions": 36}))
    most = float(np.abs(heavy.data["holding_moment"]).max())
    assert most > 1e-4
    assert any(f"takes {most:.3g} N m at most" in text for text in heavy.notices)
    # a mass beside the line swings about it, which is no idle turn
    links["coupler"]["rigid"] |= {"centre": place((RSSR_A + B) / 2 + 0.02 * np.cross(e, Z))}
    with pytest.raises(SceneError, match="link coupler moves most"):
        fm.analyse(rssr(links, balls=2))


def test_a_linkage_that_can_move_freely_is_told():
    arm = scene(
        {"arm": rod({"A": ORIGIN, "B": (0.2, 0, 0)}), "hand": rod({"B": (0.2, 0, 0), "C": (0.3, 0, 0.1)})},
        {
            "A": {"connect": ("ground.A", "arm.A"), "axis": Z},
            "B": {"connect": ("arm.B", "hand.B"), "axis": Y},
        },
        ground={"points": {"A": ORIGIN}},
        drive={"joint": "A", "speed": 3.0},
    )
    with pytest.raises(SceneError, match=r"move in 1 independent ways? that no drive leads: link hand moves most"):
        fm.analyse(arm)
    with pytest.raises(SceneError, match="independent ways"):
        fm.analyse(arm.changed({"joints.B.kind": "ball", "joints.B.axis": None}))


def hinged_loop(**changes):
    """A planar parallelogram of hinges, which is overconstrained in space and passes change points."""
    A, B, D = (0.0, 0.1, 0.0), (0.3, 0.1, 0.0), (0.3, 0.0, 0.0)
    made = scene(
        {"left": rod({"O": ORIGIN, "A": A}), "top": rod({"A": A, "B": B}), "right": rod({"D": D, "B": B})},
        {
            "O": {"connect": ("ground.O", "left.O"), "axis": Z},
            "A": {"connect": ("left.A", "top.A"), "axis": Z},
            "B": {"connect": ("top.B", "right.B"), "axis": Z},
            "D": {"connect": ("ground.D", "right.D"), "axis": Z},
        },
        ground={"points": {"O": ORIGIN, "D": D}},
        drive={"joint": "O", "speed": 3.0},
        analysis={"positions": 24},
    )
    return made.changed(changes)


def test_a_parallelogram_is_overconstrained_and_swings():
    law = {"kind": "harmonics", "sine": [0.8]}
    result = fm.analyse(hinged_loop(**{"drive": {"joint": "O", "law": law, "period": 2.0}}))
    assert any("hold more than is needed" in text for text in result.notices)
    assert result.data.attrs["mobility"] == 1
    places = np.asarray(result.data["joint_place"])
    np.testing.assert_allclose(places[:, 2] - places[:, 1], [[0.3, 0, 0]] * 24, atol=1e-9)


def test_a_parallelogram_that_is_driven_through_its_change_point_is_told():
    with pytest.raises(SolverError, match="rigid position at 90 degrees"):
        fm.analyse(hinged_loop())


def test_a_hinge_that_leans_stops_a_loop_of_rigid_links():
    with pytest.raises(MechanismError, match=r"gap|contradict"):
        fm.analyse(hinged_loop(**{"joints.B.axis": (0.0, 0.03, 1.0)}))


def test_a_column_beyond_its_buckling_load_is_refused():
    """Euler's load is pi^2 E I/(4 L^2)."""
    side, length = 4e-3, 0.5
    euler = np.pi**2 * 207e9 * side**4 / 12 / (4 * length**2)

    def column(share):
        section = {"shape": "rectangle", "height": side, "width": side}
        keys = {"mesh": {"elements": 4}, "analysis": {"modes": 2}}
        return cantilever([(0, 0, 0), (length, 0, 0)], section, (-share * euler, 0, 0), **keys)

    below = fm.analyse(column(0.98)).data["frequency"]
    assert 0 < float(below[0, 0]) < 0.2 * float(fm.analyse(column(0.1)).data["frequency"][0, 0])
    with pytest.raises(UnstableError, match="buckles"):
        fm.analyse(column(1.02))


def test_a_beam_that_gives_way_under_its_load_is_refused_with_its_share():
    """A slim strip with 50 times the load that bends it by 90 degrees: no answer is better than a wrong one."""
    made = cantilever(
        [(0, 0, 0), (1, 0, 0)], {"shape": "round", "diameter": 1e-3}, (0, 0, -200.0), mesh={"elements": 4}
    )
    with pytest.raises(SolverError, match=r"with 25 % of the loads there is an equilibrium"):
        fm.analyse(made)


def test_a_spring_that_is_wound_in_every_cycle_is_told():
    made = rssr(rigid_rssr_links(), springs={"S": {"joint": "O", "stiffness": 2.0}})
    with pytest.raises(SceneError, match=r"joint 'O' is wound by 360 deg in every cycle"):
        fm.analyse(made)
    # one that comes back is not
    back = fm.analyse(rssr(rigid_rssr_links(), springs={"S": {"joint": "Q", "stiffness": 2.0}}))
    assert np.isfinite(back.data["input_torque"]).all()


def test_a_hinge_spring_works_by_its_angle():
    """Its work over the cycle is none; the drive's power is the change of k a^2/2 and of the kinetic energy."""
    stiffness, speed = 3.0, 1e-3  # so slow that inertia has no part
    made = rssr(
        rigid_rssr_links(),
        springs={"S": {"joint": "Q", "stiffness": stiffness}},
        drive={"joint": "O", "speed": speed},
        analysis={"positions": 128},
    )
    data = fm.analyse(made).data
    angle = rssr_output(np.asarray(data["theta"]))
    angle = angle - angle[0]
    waves = 1j * np.arange(65) * np.fft.rfft(stiffness * angle**2 / 2)
    exact = np.fft.irfft(waves, n=128)
    np.testing.assert_allclose(data["input_torque"][:, 0], exact, atol=1e-6 * np.abs(exact).max())


def test_a_drive_that_reaches_beyond_the_links_is_told_where():
    far = rssr(rigid_rssr_links()).changed({"ground.points.Q": place((0.3, 0.1, 0.05))})
    B = rssr_ball(0.0)
    short = {"points": {"Q": (0.46, 0.1, 0.0), "B": place(B)}, "rigid": slim((0.46, 0.1, 0.0), B)}
    made = far.changed({"links.rocker": short, "ground.points.Q": (0.46, 0.1, 0.0)})
    with pytest.raises(SolverError, match=r"at [\d.]+ degrees"):
        fm.analyse(made)


def test_members_of_all_directions_need_no_up_where_they_bend_alike():
    ends = [(0, 0, 0), (0, 0, 0.3)]
    made = cantilever(ends, {"shape": "round", "diameter": 5e-3}, (1.0, 2.0, 0), up=None, mesh={"elements": 2})
    moved = np.asarray(fm.analyse(made).data["deflection"][0, 0, -1])
    assert moved[1] == pytest.approx(2 * moved[0], rel=1e-6)
    arm = bar((0, 0, 0), (0, 0, 0.3), X)
    assert arm["members"]["AB"]["up"] == X
