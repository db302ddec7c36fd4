"""Contact on one side of a guide against the impact of two bars in closed form, and of a member that bends."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.joints.bent_guide import BentGuide
from fenics_mech.joints.joint_state import Wrench
from fenics_mech.joints.link_states import BodyForces, LinkStates, cross, quarter
from fenics_mech.joints.side_contact import OneSide
from fenics_mech.machine.linkage import start_motion
from tests.joints.test_bending import BY_POSES, link

INERTIA = 0.02  # of the anvil (kg m^2): so light that the hammer goes on, and its friction keeps its sense
LENGTH, TO, GAP = 0.5, 1.0, 0.05  # of the hammer, place of its pin, height of its tip (m)
CONTACT = {"stiffness": 1e9, "restitution": 0.6}
AREA, DENSITY = 2e-4, 7850.0


def anvil_and_hammer(bends: bool = False, **changes) -> fm.Scene:
    """Give a bar along X on a pin, and a second one whose tip falls on it at 4 rad/s, without gravity."""
    of_members = {
        "materials": {"stiff": fm.Material(modulus=2e16, density=DENSITY)},
        "sections": {"bar": fm.RectangleSection(width="20 mm", height="10 mm")},
        "effects": ("coupling",),
        "mesh": fm.Mesh(elements=1),
    }
    scene = fm.Scene(
        name="anvil and hammer",
        ground=fm.Ground(points={"O": (0, 0), "C": (TO, GAP)}),
        links={
            "anvil": fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(mass=1.0, inertia=INERTIA)),
            "hammer": link("C", "T", LENGTH, bends=bends).model_copy(update={"angle": np.pi}),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "anvil.O")),
            "C": fm.Revolute(connect=("ground.C", "hammer.C")),
            "S": fm.Slot(connect=("anvil.O", "hammer.T")),
        },
        freedoms={"O": fm.Freedom(start=0.0), "C": fm.Freedom(start=np.pi, speed=4.0)},
        joint_laws={"touch": fm.SideContact(joint="S", contact=CONTACT)},
        analysis=fm.Analysis(
            method="transient",
            duration=0.05,
            sub_intervals=20,
            time_tolerance=1e-6,
            error_estimates=False,
            **(BY_POSES if bends else {}),
        ),
        **(of_members if bends else {}),
    )
    return scene.changed(changes)


def after(friction: float = 0.0) -> tuple[float, float]:
    """Rates of both bars after the impact, which takes no time (rad/s)."""
    inertia = INERTIA, DENSITY * AREA * LENGTH**3 / 3
    arm = np.sqrt(LENGTH**2 - GAP**2)  # of the force across the anvil, about the hammer's pin
    arms = TO - arm, arm + friction * GAP  # friction drags the tip back along the anvil
    speed = 4.0 * arm
    impulse = (1 + CONTACT["restitution"]) * speed / (arms[0] ** 2 / inertia[0] + arm * arms[1] / inertia[1])
    return -impulse * arms[0] / inertia[0], 4.0 - impulse * arms[1] / inertia[1]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_impact_of_two_bars_is_that_of_their_momenta(friction):
    data = fm.analyse(anvil_and_hammer(**{"joint_laws.touch.friction": friction, "joint_laws.touch.width": 1e-4})).data
    assert data.attrs["contacts_closed"] == 1
    assert data.attrs["power_balance_error"] < 1e-7
    found = data["freedom_rate"].isel(theta=-1).to_numpy()
    np.testing.assert_allclose(found, after(friction), rtol=3e-3)  # the contact lasts 1e-3 of a second


def test_the_pin_may_be_on_the_other_side():
    left = fm.analyse(anvil_and_hammer()).data
    turned = {"joint_laws.touch.side": "right", "joints.S.angle": np.pi}  # the guide the other way round
    right = fm.analyse(anvil_and_hammer(**turned)).data
    np.testing.assert_allclose(right["freedom_place"], left["freedom_place"], atol=1e-7)


@pytest.mark.slow
def test_a_hammer_that_bends_little_strikes_as_a_rigid_one():
    changes = {"analysis.time_tolerance": 1e-3, "joint_laws.touch.contact.stiffness": 1e7}
    rigid, bent = (fm.analyse(anvil_and_hammer(bends, **changes)).data for bends in (False, True))
    np.testing.assert_allclose(bent["freedom_place"], rigid["freedom_place"], atol=1e-5)
    assert float(bent["largest_law_effort"][0]) == pytest.approx(float(rigid["largest_law_effort"][0]), rel=2e-3)


def arm_on_a_beam() -> fm.Scene:
    """Give a beam that is clamped at the origin, and an arm of 2 kg whose tip lies on it."""
    return fm.Scene(
        name="arm on a beam",
        materials={"steel": fm.Material(modulus=2e11, density=DENSITY)},
        sections={"bar": fm.RectangleSection(width="20 mm", height="5 mm")},
        ground=fm.Ground(points={"O": (0, 0), "C": (1, 0)}),
        links={
            "beam": fm.Link(
                points={"A": (0, 0), "B": (0.8, 0)},
                members={"bar": fm.Member(ends=("A", "B"), section="bar", material="steel")},
            ),
            "arm": fm.Link(
                points={"C": (0, 0), "T": (0.5, 0)}, rigid=fm.RigidBody(mass=2.0, inertia=0.05, centre=(0.4, 0))
            ),
        },
        joints={
            "O": fm.Weld(connect=("ground.O", "beam.A")),
            "C": fm.Revolute(connect=("ground.C", "arm.C")),
            "S": fm.Slot(connect=("beam.A", "arm.T"), member="bar"),
        },
        joint_laws={"touch": fm.SideContact(joint="S", contact={"stiffness": 1e7, "exponent": 1.0})},
        freedoms={"C": fm.Freedom(start=np.pi - 0.02)},
        gravity=(0, -9.81),
        effects=("gravity",),
        mesh=fm.Mesh(elements=4),
        analysis=fm.Analysis(method="static", error_estimates=False),
    )


@pytest.mark.slow  # an equilibrium of links that bend
def test_a_beam_bends_under_an_arm_that_lies_on_it():
    data = fm.analyse(arm_on_a_beam()).data
    angle = float(data["freedom_place"].squeeze())
    x, height = 1 + 0.5 * np.cos(angle), 0.5 * np.sin(angle)
    push = float(np.linalg.norm(data["joint_force"].sel(joint="S")))
    rigidity, line, length, element = 2e11 * 0.02 * 0.005**3 / 12, DENSITY * 1e-4 * 9.81, 0.8, 0.2
    slope = push * x**2 / (2 * rigidity) + line * x * (3 * length**2 - 3 * length * x + x**2) / (6 * rigidity)
    down = push * np.cos(slope)  # it pushes across the bent axis
    bent = down * x**3 / (3 * rigidity) + line * x**2 * (6 * length**2 - 4 * length * x + x**2) / (24 * rigidity)
    bent -= down * element**3 / (192 * rigidity) + line * element**4 / (384 * rigidity)  # bow of the element there
    assert height == pytest.approx(-bent - push / 1e7, rel=5e-3)  # slopes of 0.06: their squares are left out here
    moment = push * 0.5 * np.cos(np.pi - angle - slope)  # about C, of the push across the axis
    assert moment == pytest.approx(2 * 9.81 * 0.4 * abs(np.cos(angle)), rel=1e-4)
    exact = fm.analyse(arm_on_a_beam().changed({"effects": ("gravity", "large-rotations")})).data
    sunk = 0.5 * np.sin(float(exact["freedom_place"].squeeze()))
    assert sunk == pytest.approx(height, rel=5e-3)  # the slope there is 0.06


def test_links_that_are_held_too_often_with_tight_joints_are_drawn_where_they_start():
    motion = start_motion(arm_on_a_beam())
    np.testing.assert_allclose(motion.angle[0], [0, np.pi - 0.02], atol=1e-9)


@pytest.mark.slow
def test_a_hammer_strikes_a_member_as_it_does_a_rigid_anvil():
    changes = {"analysis.time_tolerance": 1e-3, "joint_laws.touch.contact.stiffness": 1e7}
    changes |= {"joint_laws.touch.friction": 0.3}
    rubbed = []
    for bends in (False, True):
        links = {"anvil": link("O", "E", 0.6, bends), "hammer": link("C", "T", LENGTH, bends)}
        links["hammer"] = links["hammer"].model_copy(update={"angle": np.pi})
        slot = fm.Slot(connect=("anvil.O", "hammer.T"), member="bar" if bends else None)
        these = changes | ({"mesh.elements": 2} if bends else {})
        rubbed.append(fm.analyse(anvil_and_hammer(bends, **these, links=links, **{"joints.S": slot})).data)
    rigid, bent = rubbed
    assert rigid["freedom_rate"].to_numpy()[-1, 0] < -1  # the anvil turns away
    np.testing.assert_allclose(bent["freedom_place"], rigid["freedom_place"], atol=2e-5)
    assert float(bent["largest_law_effort"][0]) == pytest.approx(float(rigid["largest_law_effort"][0]), rel=2e-3)
    assert bent.attrs["power_balance_error"] < 3e-5


def bent_guide(seed: int = 0) -> tuple[BentGuide, LinkStates]:
    """Give a guide of four elements through frames that are bent at random, and a pin beside it or beyond its ends."""
    distances = 0.0, 0.2, 0.5, 0.7, 1.0
    points = {"bodies": (0, 5), "points": ((0.0, 0.0), (0.01, 0.02))}
    guide = BentGuide("S", **points, guide=0.3, slides=True, turn=0.0, nodes=(0, 1, 2, 3, 4), distances=distances)
    rng, along = np.random.default_rng(seed), np.array([np.cos(0.3), np.sin(0.3), 0.0])
    pose = np.zeros((6, 7, 3))
    pose[:, :5] = np.array(distances)[:, None] * along + 0.02 * rng.standard_normal((6, 5, 3))
    pose[:, 5] = np.array([0.1, 0.3, 0.5, 0.77, 1.1, -0.1])[:, None] * along + 0.01 * rng.standard_normal((6, 3))
    rate = rng.standard_normal(pose.shape)
    rate[:, 6] = 0  # the ground
    return guide, LinkStates(pose, rate)


def test_a_guide_that_bends_is_pushed_with_the_work_that_the_pin_takes():
    guide, links = bent_guide()
    state, rng = guide.state(links), np.random.default_rng(1)
    np.testing.assert_allclose(np.sum(state.along * state.gap, axis=-1), 0, atol=1e-12)  # the nearest point
    wrench = Wrench(rng.standard_normal((6, 2)), rng.standard_normal(6), rng.standard_normal((6, 2)))
    on = BodyForces.none(6, 6)
    guide.exert(on, state, wrench)
    seen = state.gap_rate - state.turning[0][:, None] * quarter(state.gap)
    power = np.sum(wrench.force * seen, axis=-1)
    power += (wrench.moment + cross(wrench.offset, wrench.force)) * (state.turning[1] - state.turning[0])
    np.testing.assert_allclose(np.sum(on.values * links.rate, axis=(1, 2)), power, atol=1e-12)
    np.testing.assert_allclose(on.values[..., :2].sum(axis=1), 0, atol=1e-12)
    about = on.values[..., 2] + cross(links.pose[..., :2], on.values[..., :2])
    np.testing.assert_allclose(about.sum(axis=1), 0, atol=1e-12)


def test_a_pin_is_in_a_guide_that_bends_between_its_ends_alone():
    guide, links = bent_guide()
    law = OneSide(guide, fm.SideContact(joint="S", side="right", contact=CONTACT))
    (depth,), (rate,) = law.depths(guide.state(links))
    step = 1e-6
    ahead, back = (
        law.depths(guide.state(LinkStates(links.pose + by * links.rate, links.rate)))[0][0] for by in (step, -step)
    )
    np.testing.assert_allclose(rate, (ahead - back) / (2 * step), atol=1e-8)
    assert (depth[4:] < -0.05).all()  # beyond its ends


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"joint_laws.touch.joint": "O"}, "is at a joint of kind slot"),
        ({"joint_laws.touch.side": "above"}, "left"),
        ({"joint_laws.touch.contact.restitution": 1.5}, "less than or equal to 1"),
    ],
)
def test_bad_contacts_on_one_side_are_one_clear_error(changes, words):
    with pytest.raises(fm.SceneError, match=words):
        anvil_and_hammer(**changes)


def test_a_pin_that_begins_beyond_its_guide_is_refused():
    with pytest.raises(fm.SceneError, match=r"bodies of joint 'S' overlap by 0\.05"):
        fm.analyse(anvil_and_hammer(**{"joint_laws.touch.side": "right"}))
