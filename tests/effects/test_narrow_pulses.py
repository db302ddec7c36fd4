"""Factors of loads that change between the points of a cycle: the right answer, or an error."""

import time

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.planning.cycle_steps import Steps
from fenics_mech.planning.sampling_checks import refuse_undersampled
from fenics_mech.scene.applied_loads import FactorHarmonics, Varying
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.formulas.expression import Formula, Jet
from fenics_mech.scene.formulas.interval import bounds_over
from fenics_mech.studies.follow import follow
from tests.common import response_of

WHERE, WIDTH, FORCE = 1.234561, 1e-6, 1e6  # rad, rad, N
TABLE = {"kind": "table", "angles": (1.23456, WHERE, 1.234562), "values": (0.0, 1.0, 0.0)}
PULSE = {"kind": "pulse", "start": WHERE - WIDTH / 2, "end": WHERE + WIDTH / 2, "ramp": 5e-7}
IN_TIME = {"method": "transient", "cycles": 1, "sub_intervals": 40, "allow_coarse": True}
BY_POINTS = {"solver": "collocation", "sub_intervals": 60, "allow_coarse": True, "stability": False}


def struck(**rest):
    """The seed with a force across its coupler, by default of a factor with an integral of `WIDTH`."""
    load = {"at": "coupler@0.5", "force": (0.0, FORCE), "factor": TABLE}
    values = {"effects": ("coupling",), "mesh__elements": 1, "damping": {"ratio": 0.05}, "loads": {"p": load}}
    return seed_four_bar(**(values | rest))


@pytest.mark.parametrize(
    ("factor", "sign", "analysis"),
    [
        (TABLE, 1, IN_TIME),
        (TABLE, -1, BY_POINTS),
        (PULSE, 1, BY_POINTS),
    ],
)
def test_pulse_narrower_than_any_sample_is_an_impulse(factor, sign, analysis):
    """It acts for so short a time that displacements stay: what counts is force times time.

    Relative to the strains the difference is the width by the pace of the modes that it excites, 7e-4. In a cycle it
    is 2e-3 at the first position after the pulse, where steps do not follow modes that both excite.
    """
    pulse = struck(loads__p__factor=factor, analysis=analysis)
    pulse = pulse.changed(drive__speed=sign * pulse.drive.speed)
    impulse = {"at": "coupler@0.5", "angle": WHERE, "impulse": (0.0, FORCE * WIDTH / abs(pulse.drive.speed))}
    found, expected, without = (
        response_of(scene).data["strain"]
        for scene in (pulse, pulse.changed(loads={}, impulses={"i": impulse}), pulse.changed(loads={}))
    )
    size = np.abs(expected).max()
    assert np.abs(found - expected).max() < (3e-3 if analysis is BY_POINTS else 1e-3) * size
    assert np.abs(without - expected).max() > 0.3 * size


@pytest.mark.slow
def test_steps_in_time_are_cut_at_a_pulse():
    """Measured 1 % of the strain in which pulses of 1e-6 and of 1e-4 rad differ; it was missed, by 60 %."""
    wide = 100 * WIDTH
    broad = {"kind": "table", "angles": (WHERE - wide, WHERE, WHERE + wide), "values": (0.0, 1.0, 0.0)}
    narrow = struck(analysis=IN_TIME | {"sub_intervals": 20, "error_estimates": False, "solver": "poses"})
    found, expected, without = (
        analyse(scene).data["strain"]
        for scene in (
            narrow,
            narrow.changed(loads__p__factor=broad, loads__p__force=(0.0, FORCE / 100)),
            narrow.changed(loads={}),
        )
    )
    size = np.abs(expected).max()
    assert np.abs(found - expected).max() < 0.03 * size
    assert np.abs(without - expected).max() > 0.3 * size


@pytest.mark.parametrize(
    "analysis",
    [
        {"method": "quasi-static"},
        {"solver": "sub-intervals"},
        {"solver": "harmonic-balance", "harmonics": 20, "sub_intervals": 100},
    ],
)
def test_pulse_that_positions_cannot_see_is_refused(analysis):
    effects = () if "harmonics" not in analysis else ("coupling",)
    with pytest.raises(SceneError, match=r"loads.p.factor: \d+ positions miss .* whose steps are cut at corners"):
        analyse(struck(effects=effects, analysis=analysis))


def test_peak_of_a_formula_that_no_step_in_time_shows_is_refused():
    factor = {"kind": "expression", "formula": "1 + cos(theta) + 10*exp(-((theta - 1.23456)/1e-4)**2)"}
    with pytest.raises(SceneError, match=r"loads\.p\.factor: the factor has a peak between"):
        analyse(struck(loads__p__factor=factor, analysis=IN_TIME | {"allow_coarse": False}))


def test_corners_that_the_points_show_do_not_cut_steps():
    """A coarse table of a sine changes nothing in the steps, and one pulse in it cuts only where it is."""
    angles = np.linspace(0, 2 * np.pi, 361)
    smooth = {"kind": "table", "angles": tuple(angles), "values": tuple(np.sin(angles))}
    scene = struck(loads__p__factor=smooth, analysis={"solver": "collocation", "sub_intervals": 60})
    assert len(Steps.of(scene).start) == 60
    angles, values = np.append(angles, np.array([2.0, 2.00001, 2.00002])), np.append(np.sin(angles), [1.0, 500.0, 1.0])
    order = np.argsort(angles)
    scene = scene.changed(loads__p__factor=smooth | {"angles": tuple(angles[order]), "values": tuple(values[order])})
    assert 62 < len(Steps.of(scene).start) < 72


def test_load_that_jumps_under_a_motor():
    """A shaft as good as rigid gives the motion without one; with a tenth of its stiffness strains are 3.5e-3 off."""
    load = {"at": "coupler@0.5", "force": (0.0, 1.0), "factor": {"kind": "pulse", "start": 1.0, "end": 2.0}}
    plain = struck(loads={"p": load}, analysis=BY_POINTS, effects=("coupling", "large-rotations"))
    stiff = plain.changed(drive__motor={"stiffness": 1e6, "damping": 100.0, "inertia": 1e-3})
    found, expected = (analyse(scene).data["strain"] for scene in (stiff, plain))
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()


def test_branch_whose_steps_would_be_cut_elsewhere_is_refused():
    load = {"at": "coupler@0.5", "force": (0.0, 1.0), "factor": {"kind": "pulse", "start": 1.0, "end": 2.0}}
    scene = struck(loads={"p": load}, analysis=BY_POINTS, effects=("coupling", "large-rotations"))
    with pytest.raises(SceneError, match=r"loads.p.factor.start: the angles at which a load jumps"):
        follow(scene, "loads.p.factor.start", (1.0, 1.1))


def test_many_harmonics():
    """A sum of 2,000 took 11 s, of 131,072 had no end in sight; the sum is compared with one by another order."""
    cosine, sine = np.random.default_rng(3).normal(size=(2, 2000))
    start = time.process_time()
    factor = FactorHarmonics(kind="harmonics", mean=0.3, cosine=tuple(cosine), sine=tuple(sine[:1500]))
    assert Varying(factor=factor).enough_angles(40) > 1000
    theta = np.linspace(-7, 7, 50)
    n = np.arange(1, 2001)
    waves = cosine[:, None] * np.cos(n[:, None] * theta)
    waves[:1500] += sine[:1500, None] * np.sin(n[:1500, None] * theta)
    # rounding of n theta: 2000 x 7 x 1e-16, and of a sum of 2,000
    assert np.allclose(factor.at(theta), 0.3 + waves.sum(axis=0), rtol=0, atol=1e-9)
    equal = 2 * np.pi / 300 * np.arange(300)  # fewer than harmonics, which fold
    assert np.allclose(factor.equally(300), factor.at(equal), rtol=0, atol=1e-9)
    second = factor.jet(equal).second
    assert np.allclose(factor.equally(300, 2), second, rtol=0, atol=1e-9 * np.abs(second).max())
    assert time.process_time() - start < 2  # measured 0.1
    with pytest.raises(SceneError, match=r"loads.p.factor.cosine: .*10000"):
        struck(loads__p__factor={"kind": "harmonics", "cosine": (1.0,) * 131_072})


def test_narrow_bump_in_a_law_is_refused():
    """Of 1e-8 rad, over 1e-6 rad of the cycle: accelerations of 1e4 times the largest that positions see."""
    law = {"kind": "expression", "formula": "0.5*sin(theta) + 1e-8*exp(-((theta - 1.23456)/1e-6)**2)"}
    scene = struck(loads={}, drive={"joint": "O", "law": law, "period": 1.0}, analysis={"method": "quasi-static"})
    with pytest.raises(SceneError, match=r"drive.law: 360 positions miss what the law of the drive does"):
        refuse_undersampled(scene, 360)


@pytest.mark.parametrize(
    "text",
    ["tan(theta/5)**2", "exp(-theta)*log(1 + theta)", "sqrt(1 + theta)*tanh(theta - 2)", "cos(theta)/(2 + theta**2.5)"],
)
def test_bounds_of_second_derivatives_hold_and_close_in(text):
    formula, edges = Formula(text, ("theta",)), np.linspace(0, 2 * np.pi, 20_001)
    low, high = bounds_over(formula, edges[:-1], edges[1:], of_second=True)
    inside = formula.jet(Jet.variable((edges[1:] + edges[:-1]) / 2)).second
    assert ((low <= inside) & (inside <= high)).all()
    assert (high - low).max() < 0.05 * np.abs(inside).max()  # 3e-4 rad of the largest third derivatives
