"""Springs, dampers and loads of scenes: the power of a cycle, tangents, and closed forms."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import equilibrium, periodic, rigid_cycle
from fenics_mech.terms import Spring
from tests.common import DEMOS
from tests.effects.test_impulses import turning_beam

EXACT = ("coupling", "large-rotations")

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
    numbers = {"analysis.sub_intervals": 120, "analysis.stations": 21}
    return fm.load(DEMOS / "slider_crank.toml").changed(exact | numbers | acting)


def cycle_of(scene, steps):
    made = machine_of(scene)
    made.machine.chart = rigid_cycle(made.machine, scene.period)
    return made, periodic(made.machine, scene.period, steps)


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


SPREAD = {
    "fixed": {"loads": {"w": {"member": "rod", "line": [3.0, 10.0], "line_end": [1.0, -4.0]}}},
    "member": {"loads": {"w": {"member": "rod", "line": [3.0, 10.0], "line_end": [1.0, -4.0], "axes": "member"}}},
    "air": {"damping": {"air": {"density": 1000.0, "coefficient": 1.2}}},
    "external": {"damping": {"external": 30.0}},
    "relative": {"damping": {"relative": 30.0}},
}


@pytest.mark.slow
@pytest.mark.parametrize("inner", [0, 2])
@pytest.mark.parametrize("stated", list(SPREAD))
def test_tangents_of_what_is_spread_along_links(stated, inner):
    """By differences, in a moving chart, without the beams' own stiffness that would hide them."""
    made = machine_of(loaded(**SPREAD[stated]), inner)
    machine, rng = made.machine, np.random.default_rng(1)
    machine.chart = rigid_cycle(machine, made.scene.period)
    machine.terms = list(made.acting.values())
    machine.forget_plan()
    t = np.array([0.013, 0.05])
    q, v, a = (rng.normal(size=(2, machine.size)) * size for size in (1e-3, 0.3, 1.0))
    q[:, machine.n :] = v[:, machine.n :] = 0.0
    found = machine.residual(t, q, v, a)
    for values, at, step in ((found.K, 0, 1e-6), (found.C, 1, 1e-4)):
        tangent = machine.pattern.dense(values)[..., : machine.n]
        for k in range(machine.n):
            both = []
            for sign in (1, -1):
                states = [q.copy(), v.copy(), a.copy()]
                states[at][:, k] += sign * step
                both.append(machine.residual(t, *states, tangents=False).force)
            # the air's has a corner in its slope
            bound = (1e-7 if stated == "air" else 1e-8) * np.abs(tangent).max()
            np.testing.assert_allclose((both[0] - both[1]) / (2 * step), tangent[..., k], atol=bound)


@pytest.mark.parametrize("inner", [0, 1, 3])
@pytest.mark.parametrize("axes", ["fixed", "member"])
def test_a_held_beam_carries_a_load_along_it_inside_its_elements(inner, axes):
    """A cantilever under q(x) across it, by statics, with small deflections."""
    first, last, length = 2e-3, -1e-3, 0.4
    load = {"q": {"member": "beam", "line": [0.0, first], "line_end": [0.0, last], "axes": axes}}
    scene = turning_beam(mesh={"elements": 1 if inner else 2}, loads=load, damping={}, masses={}, effects=EXACT)
    made = machine_of(scene, inner)
    q, a = equilibrium(made.machine, moving=False)
    found = made.machine.residual(np.zeros(1), q[None], 0 * q[None], a[None], moving=False)
    s = np.linspace(0, 1, 9)
    forces, x = along_members(made, found, a[None], s), s * length
    slope, beyond = (last - first) / length, length - x
    here = first + slope * x
    shear = -here * beyond - slope * beyond**2 / 2
    moment = here * beyond**2 / 2 + slope * beyond**3 / 3
    bending = scene.rigidities(s)[0].bending[0]
    deflection = first * x**2 * (6 * length**2 - 4 * length * x + x**2) / 24
    deflection += slope * x**2 * (20 * length**3 - 10 * length**2 * x + x**3) / 120
    largest = np.abs(moment).max()
    np.testing.assert_allclose(forces.moment[0, 0], moment, atol=1e-6 * largest)
    np.testing.assert_allclose(forces.shear[0, 0], shear, atol=1e-6 * np.abs(shear).max())
    bent = np.abs(deflection).max() / bending
    within = {0: 3e-3, 1: 1e-2, 3: 1e-6}[inner]  # the deflection is of degree 5: with 2 places inside it is exact
    np.testing.assert_allclose(forces.place[0, 0, :, 1], deflection / bending, atol=within * bent)
