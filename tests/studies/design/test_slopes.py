"""Derivatives of answers by poses against differences of whole analyses, and searches by them."""

import math

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import DerivativeError
from fenics_mech.studies.design.explorer import Explorer
from fenics_mech.studies.design.slopes import slopes
from fenics_mech.studies.design.trial import Trials
from tests.common import DEMOS

EXACT = ("coupling", "large-rotations")
NUMBERS = ["mass", "strain.max", "strain[coupler].max", "shaking_force.rms", "torque.rms", "deflection.max"]
NUMBERS += ["joint_force[B].max", "transmission_angle.min", "utilisation.max", "damage", "tracer_error[P].rms"]
PERIODIC = [*NUMBERS, "frequency[1].min", "mean_power[drive]", "mean_power[modal damping]"]
PERIODIC += ["stability.margin", "multiplier[1].max", "growth_rate[1].max", "multiplier_frequency[1].max"]


def with_variable(scene, number, value, **changes):
    variable = {"numbers": [number], "between": sorted([0.9 * value, 1.1 * value])}
    study = {"study": {"variables": {"x": variable}}} if scene.study is None else {"study.variables": {"x": variable}}
    return scene.changed({number: value, "analysis.solver": "poses", **study, **changes})


def four_bar(number, value, effects, method="periodic"):
    """The seed with a coupler of a rectangle, a path for its end, and strengths for its stresses."""
    place = [(0.2, 0.15), (0.1, 0.2), (0.15, 0.24)]
    targets = {"P": {"point": "coupler.B", "path": place, "angles": ["20 deg", "130 deg", "250 deg"]}}
    changes = {
        "sections.coupler": {"shape": "rectangle", "width": "25.4 mm", "height": "1.6 mm"},
        "links.coupler.members.AB.section": "coupler",
        "materials.aluminium.fatigue": {"range": "4 MPa", "slope": 5},
        "materials.aluminium.strength": "60 MPa",
        "study": {"targets": targets},
        "effects": effects,
        "analysis.method": method,
        "analysis.sub_intervals": 120,  # with 60 the largest multiplier is one or the other of two
    }
    return with_variable(fm.load(DEMOS / "four_bar.toml").changed(changes), number, value)


def compared(scene, names, value):
    """Derivatives by the one variable of a study, by differences of whole analyses too, and the size of each."""
    trials, differences = Trials.of(scene, names), []
    base = trials.run([[value]])[0].numbers
    found = {name: slope[0] for name, slope in slopes(trials, [value]).items()}
    for h in (4e-4 * value, 2e-4 * value):
        ahead, behind = trials.run([[value + h], [value - h]])
        differences.append(np.array([(ahead.numbers[name] - behind.numbers[name]) / (2 * h) for name in names]))
    far, near = differences
    exact = dict(zip(names, (4 * near - far) / 3))  # Richardson
    return {name: (found[name], exact[name], max(abs(exact[name]), abs(base[name] / value))) for name in names}


VARIABLES = [("sections.coupler.height", 1.6e-3), ("drive.speed", 32.3), ("ground.points.C.0", 0.254)]


@pytest.mark.slow
@pytest.mark.parametrize(("number", "value"), [*VARIABLES, ("damping.ratio", 0.02)])
def test_derivatives_are_those_of_whole_analyses(number, value):
    for name, (found, exact, size) in compared(four_bar(number, value, EXACT), PERIODIC, value).items():
        assert math.isclose(found, exact, abs_tol=5e-6 * size), name  # a force near resonance has a third power of 4e-6


LINEAR, STIFFENED = ("coupling",), ("coupling", "geometric-stiffness")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variable", "method", "effects"),
    [
        pytest.param(0, "periodic", STIFFENED, marks=pytest.mark.long),
        (1, "periodic", LINEAR),
        pytest.param(2, "periodic", STIFFENED, marks=pytest.mark.long),
        (0, "quasi-static", STIFFENED),
        (2, "quasi-static", LINEAR),
    ],
)
def test_derivatives_of_linear_answers_are_those_of_whole_analyses(variable, method, effects):
    """What is read off linear motions is rounded to 1e-8, of forces to 1e-7, which steps of 1e-3 divide."""
    number, value = VARIABLES[variable]
    names = PERIODIC if method == "periodic" else NUMBERS
    for name, (found, exact, size) in compared(four_bar(number, value, effects, method), names, value).items():
        near = 1e-3 if "force" in name else 3e-4 if "multiplier[" in name else 5e-4  # it turns by 0.03 rad in a step
        assert math.isclose(found, exact, abs_tol=near * size), name


@pytest.mark.slow
@pytest.mark.parametrize(("number", "value"), VARIABLES)
def test_derivatives_of_exact_static_answers_are_those_of_whole_analyses(number, value):
    scene = four_bar(number, value, EXACT, "quasi-static")
    for name, (found, exact, size) in compared(scene, NUMBERS, value).items():
        assert math.isclose(found, exact, abs_tol=5e-6 * size), name


HIT = {"hit": {"at": "crank.A", "impulse": (0.0, 0.02), "angle": 1.3}}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "value", "effects"),
    [
        ("impulses.hit.impulse.1", 0.02, EXACT),
        ("sections.strip.height", 3e-3, EXACT),
        ("drive.speed", 60.0, EXACT),
        ("drive.speed", 60.0, ("coupling",)),
    ],
)
def test_impulses_have_derivatives(number, value, effects):
    base = fm.load(DEMOS / "slider_crank.toml").changed({"impulses": HIT, "effects": effects})
    scene = with_variable(base, number, value, **{"analysis.sub_intervals": 60, "analysis.allow_coarse": True})
    names = ["strain.max", "deflection.max", "joint_force.max", "torque.rms", "stability.margin", "mean_power[drive]"]
    for name, (found, exact, size) in compared(scene, names, value).items():
        near = 1e-3 if "force" in name and effects != EXACT else 5e-6
        assert math.isclose(found, exact, abs_tol=near * size), name


def test_the_angle_of_an_impulse_has_no_derivative_of_its_own():
    base = fm.load(DEMOS / "slider_crank.toml").changed({"impulses": HIT, "effects": EXACT})
    scene = with_variable(base, "impulses.hit.angle", 1.3, **{"analysis.sub_intervals": 40})
    trials = Trials.of(scene, ["strain.max"])
    with pytest.raises(DerivativeError, match="an instant at which a load jumps or an impulse acts"):
        slopes(trials, [1.3])
    explorer = Explorer(trials)
    assert explorer.derivatives(np.array([0.5]))["strain.max"][0] != 0
    assert "a variable moves an instant" in explorer.why_differences


@pytest.mark.slow
def test_a_motor_whose_shaft_twists_has_derivatives():
    motor = {"stiffness": 200.0, "damping": 0.3, "inertia": 1e-3}
    base = fm.load(DEMOS / "four_bar.toml").changed({"drive.motor": motor, "effects": EXACT})
    scene = with_variable(base, "sections.strip.area", 4.06e-5, **{"analysis.sub_intervals": 120})
    names = ["strain.max", "joint_force.max", "torque.rms"]
    for name, (found, exact, size) in compared(scene, names, 4.06e-5).items():
        assert math.isclose(found, exact, abs_tol=5e-6 * size), name


def test_a_gradient_takes_no_other_analysis(monkeypatch):
    trials = Trials.of(four_bar("drive.speed", 32.3, EXACT, "quasi-static"), ["strain.max"])
    trials.run([[32.3]])
    monkeypatch.setattr("fenics_mech.studies.design.trial.answered", None)
    assert slopes(trials, [32.3])["strain.max"][0] > 0
    with pytest.raises(TypeError):
        slopes(trials, [32.4])
