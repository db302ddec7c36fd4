"""Contact on one side of a guide against the impact of two bars in closed form."""

import numpy as np
import pytest

import fenics_mech as fm
from tests.joints.test_bending import link

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
            method="transient", duration=0.05, sub_intervals=20, time_tolerance=1e-6, error_estimates=False
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
