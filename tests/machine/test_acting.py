"""Springs, dampers and loads of scenes: against link frames, and the power of a cycle."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import periodic, rigid_cycle
from fenics_mech.terms import Spring
from tests.common import DEMOS, response_of

ACTING = {
    "springs": {
        "line": {"between": ["ground.G", "rod.A"], "stiffness": 300.0},
        "hinge": {"joint": "B", "stiffness": 3.0},
        "wound": {"joint": "B", "bodies": ["rod", "ground"], "stiffness": 0.1, "angle": "370 deg"},
    },
    "dampers": {"line": {"between": ["ground.G", "rod.A"], "damping": 2.0}, "hinge": {"joint": "O", "damping": 1e-3}},
    "loads": {
        "gas": {"at": "rod.B", "force": [-20.0, 0.0], "factor": {"kind": "expression", "formula": "1 + cos(theta)"}},
        "inside": {"at": "rod@0.3", "force": [0.0, 3.0], "moment": 0.2},
        "pin": {"at": "A", "force": [1.0, 2.0]},
        "jet": {"at": "rod.A", "force": [2.0, 3.0], "moment": 0.1, "follows": True},
    },
    "gravity": [0.0, -9.81],
}


def loaded(**acting):
    exact = {"effects": ("coupling", "large-rotations"), "damping": {"material": 1e-4}}
    numbers = {"analysis.sub_intervals": 120, "analysis.reduction": "none", "analysis.stations": 21}
    return fm.load(DEMOS / "slider_crank.toml").changed(exact | numbers | acting)


def cycle_of(scene, steps):
    made = machine_of(scene)
    made.machine.chart = rigid_cycle(made.machine, scene.period)
    return made, periodic(made.machine, scene.period, steps)


@pytest.mark.slow
@pytest.mark.parametrize(
    "parts", [("springs",), ("dampers",), ("loads", "gravity"), tuple(ACTING)], ids=lambda x: x[-1]
)
def test_what_acts_on_a_slider_crank_does_as_in_link_frames(parts):
    """The moments, axial forces and torque of the same scene in link frames, on the same mesh."""
    scene = loaded(**{part: ACTING[part] for part in parts})
    made, cycle = cycle_of(scene, 60)
    ends = [x[:, -1] for x in (cycle.t, cycle.q, cycle.v, cycle.a)]
    data = response_of(scene).data.isel(theta=(np.arange(60) + 1) * 2 % 120)
    forces = along_members(made, made.machine.residual(*ends), ends[3], data["s"].to_numpy())
    for name, here in (("axial_force", forces.axial), ("moment", forces.moment)):
        known = data[name].transpose("theta", "member", "s").to_numpy()
        missed = np.abs(here - known).max(axis=(0, 2)) / np.abs(known).max(axis=(0, 2))
        assert missed.max() < 3e-4, name  # as without them
    torque = -cycle.a[:, -1, made.machine.n + made.driven[0]]
    known = data["input_torque"].to_numpy()
    assert np.abs(torque - known.reshape(torque.shape)).max() < 3e-4 * np.abs(known).max()


@pytest.mark.slow
def test_the_drive_gives_in_a_cycle_what_terms_take():
    """Mean power of the drive is that of dampers, material and loads: springs and inertia keep none."""
    scene = loaded(**ACTING)
    made, cycle = cycle_of(scene, 120)
    whole = made.machine.residual(*[x[:, -1] for x in (cycle.t, cycle.q, cycle.v, cycle.a)])
    taken = {type(term).__name__: 0.0 for term in made.machine.terms}
    for term, here in zip(made.machine.terms, whole.terms):
        taken[type(term).__name__] += float(here.power.sum(axis=1).mean())
    given = float(-cycle.a[:, -1, made.machine.n + made.driven[0]].mean()) * scene.cycle_rate
    assert taken["Damper"] > 0
    assert taken["Beams"] > 0
    assert taken["PointLoad"] != 0
    # equal steps are exact for the mean of a smooth cycle; its own error is that of the strains, 1e-4 or less
    assert abs(taken["Spring"]) < 1e-4 * taken["Damper"]
    assert given == pytest.approx(sum(taken.values()), rel=1e-4)


@pytest.mark.parametrize(
    ("stated", "place"),
    [
        ({"springs": {"winds": {"joint": "A", "stiffness": 1.0}}}, "springs.winds"),
    ],
)
def test_what_no_term_states_is_refused(stated, place):
    with pytest.raises(SceneError, match=r"yet|without end") as error:
        machine_of(loaded(**stated))
    assert place in str(error.value)


def test_a_spring_at_a_hinge_acts_where_nothing_is_driven():
    """Its angle at rest is that of the link where the freedom starts."""
    scene = fm.load(DEMOS / "free_motion" / "pendulum.toml")
    (joint,) = scene.freedoms
    scene = scene.changed(
        {f"freedoms.{joint}.start": "30 deg", "springs": {"hinge": {"joint": joint, "stiffness": 2.0}}}
    )
    (spring,) = (term for term in machine_of(scene).machine.terms if isinstance(term, Spring))
    assert spring.rest == pytest.approx(scene.freedoms[joint].start)
    assert spring.near(np.array([0.0, 5.0])).ravel() == pytest.approx([spring.rest] * 2)
