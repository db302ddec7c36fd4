"""Damping of slow modes only, against that of all modes, in models of many coordinates."""

from dataclasses import replace

import numpy as np
import pytest

from fenics_mech._sparse import Stack
from fenics_mech.accuracy.undamped_modes import left_undamped
from fenics_mech.analysis import solved
from fenics_mech.errors import SolverError
from fenics_mech.response import damped_modes as module
from fenics_mech.response.damped_modes import damped_modes
from fenics_mech.response.modal_damping import FACTOR
from fenics_mech.response.mode_shapes import slowest
from fenics_mech.response.periodic.cycle import Cycle, system_at_places
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import mechanism
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of
from tests.demos.test_invariance import turned

BLOW = {"impulses": {"blow": {"at": "coupler.B", "angle": 1.0, "impulse": (0.0, 0.002)}}}
PULSE = {"kind": "pulse", "start": 1.0, "end": 2.0}
JUMP = {"loads": {"jump": {"at": "coupler.B", "force": (5.0, -3.0), "factor": PULSE}}}
SPRING = {"springs": {"line": {"between": ("coupler.B", "ground.O"), "stiffness": 1000.0}}}
HINGE = {"springs": {"hinge": {"joint": "C", "stiffness": 50.0, "angle": 1.7}}}


def many(**more):
    return seed_four_bar(
        mesh={"elements": 6},
        damping={"ratio": 0.02},
        effects=("coupling",),
        analysis={"sub_intervals": 60, "stations": 5, "allow_coarse": True, "stability": False},
        **more,
    )


@pytest.mark.parametrize("more", [BLOW, JUMP, SPRING], ids=["blow", "jump", "spring"])
def test_fast_modes_need_no_damping(more, monkeypatch):
    """Each member's strains are within 1e-4 of its peak of those with all modes damped."""
    scene = many(**more)
    assert damped_modes(scene, mechanism(scene)).count < 30  # of 54
    found = response_of(scene).data["strain"]
    monkeypatch.setattr(module, "DAMPED", replace(module.DAMPED, small=1000))
    whole = response_of(scene.changed(name="all")).data["strain"]
    others = [part for part in whole.dims if part != "member"]
    assert (abs(found - whole).max(others) < 1e-4 * abs(whole).max(others)).all()


# The second is nearer to a resonance.
@pytest.mark.parametrize("speed", [32.3, pytest.param(44.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("effects", "equal"), [(("coupling",), 0.02), (("coupling", "large-rotations"), 0.2)])
def test_damping_that_is_left_out_is_told(speed, effects, equal, monkeypatch):
    """Of every member it is what all modes' damping changes of the strains."""
    scene = many().changed(drive__speed=speed, effects=effects, analysis__error_estimates=False)
    solution, found = solved(scene)
    assert solution.cycle.damped.count < 30  # of 54
    told = left_undamped(solution)["strain"]
    monkeypatch.setattr(module, "DAMPED", replace(module.DAMPED, small=1000))
    whole = solved(scene)[1].data["strain"]
    true = abs(whole - found.data["strain"]).max(("theta", "s", "fibre")).to_numpy()
    assert told == pytest.approx(true, abs=equal * true.max())


def test_damping_of_modes_beyond_few_coordinates_is_told(monkeypatch):
    """It is not less than the truth, and at most twice as much."""
    scene = many().changed(mesh__elements=10, analysis__error_estimates=False)
    monkeypatch.setattr(module, "DAMPED", replace(module.DAMPED, many=40, reduced=0.9))
    solution, found = solved(scene)
    assert solution.cycle.damped.seen < 50  # of 90
    told = left_undamped(solution)["strain"].max()
    monkeypatch.setattr(module, "DAMPED", replace(module.DAMPED, small=1000))
    true = float(abs(solved(scene)[1].data["strain"] - found.data["strain"]).max())
    assert 0.9 * true < told < 2 * true


def test_no_more_modes_are_damped_than_change_the_strains():
    """Forces that change slowly leave fast modes without damping; a smaller tolerance asks for more of them."""
    scene = many().changed(mesh__elements=16)
    slow, less = scene.changed(drive__speed=10.0), scene.changed(tolerance=1e-5)
    counts = [damped_modes(there, mechanism(there)).count for there in (slow, scene, less)]
    assert counts[0] < counts[1] < counts[2], counts


def test_few_modes_take_no_full_matrices():
    scene = many()
    cycle = Cycle(scene, mechanism(scene))
    modal = cycle.at_points(cycle.tableau).linear.modal
    assert modal.in_own_unknowns
    assert not {"damping", "stiffness"} & {*vars(modal)}


def test_modes_of_many_nodes_are_found_by_few_coordinates(monkeypatch):
    """Ends and clamped modes of the members hold the damped modes: strains are within 1e-4 of each member's peak."""
    scene = many(**SPRING).changed(mesh__elements=16)
    modes = damped_modes(scene, mechanism(scene))
    assert modes.seen < 50  # of 144 coordinates
    found = response_of(scene).data
    monkeypatch.setattr(module, "DAMPED", replace(module.DAMPED, many=1000))
    assert damped_modes(scene, mechanism(scene)).seen is None
    whole = response_of(scene.changed(name="all")).data
    for name, equal in (("strain", 1e-4), ("stress", 1e-5), ("joint_force", 1e-5)):
        apart = [part for part in whole[name].dims if part not in ("member", "joint")]
        assert (abs(found[name] - whole[name]).max(apart) <= equal * abs(whole[name]).max(apart)).all(), name


def test_all_modes_are_damped_where_fast_ones_matter():
    ringing = many(**BLOW).changed(analysis__scheme="gauss")
    assert damped_modes(many(), mechanism(many())) is not None
    for scene in (many(**HINGE), ringing, many().changed(mesh__elements=4)):
        assert damped_modes(scene, mechanism(scene)) is None


def test_damped_modes_are_those_of_a_similar_machine():
    """Turned, or with all rates three times as high, it has the same strains."""
    scene = many()
    data = scene.model_dump()
    for material in data["materials"].values():
        material["modulus"] *= 9
    data["drive"]["speed"] *= 3
    plain = response_of(scene).data["strain"].to_numpy()
    for other in (Scene.read(data), Scene.read(turned(scene, 0.7))):
        found = response_of(other).data["strain"].to_numpy()
        assert found == pytest.approx(plain, abs=1e-8 * np.abs(plain).max())


def test_damping_between_few_positions_is_that_found_there():
    """Where it is not smooth enough between the starts of the steps, it is found at parts of them as well."""
    scene = many().changed(analysis__sub_intervals=120)
    cycle, places = Cycle(scene, mechanism(scene)), Tableau.of("radau", 3).points
    assert cycle._known_damping.parts == 2
    assert_found_between_starts(cycle, 3)
    coarse = scene.changed(analysis__sub_intervals=40)
    longer = Cycle(coarse, mechanism(coarse), shorter=cycle)  # three steps in one
    found = longer.at_points(Tableau.of("radau", 3)).modal_damping.values
    there = system_at_places(coarse, longer.system, longer.steps, places)
    assert_alike(cycle._known_damping.unit, found, cycle.damped_equation(there).modal_damping.values)


def test_damping_of_long_steps_is_found_at_parts_of_parts():
    """Half a step is not smooth enough either, where two polynomials foretold it would be."""
    scene = many().changed(analysis__sub_intervals=60)
    cycle = Cycle(scene, mechanism(scene))
    assert cycle._known_damping.parts == 4
    assert_found_between_starts(cycle, 4)


def assert_found_between_starts(cycle, stages):
    """The damping that is interpolated at the points of the steps is that which is found there."""
    tableau = Tableau.of("radau", stages)
    there = system_at_places(cycle.scene, cycle.system, cycle.steps, tableau.points)
    found, expected = cycle.at_points(tableau), cycle.damped_equation(there)
    assert_alike(cycle._known_damping.unit, found.modal_damping.values, expected.modal_damping.values)


def assert_alike(unit, *factors):
    """Factors F of the same damping ``F^T F``, but for interpolation."""
    whole, exact = (scaled.transpose(0, 2, 1) @ scaled for scaled in (values / unit for values in factors))
    assert np.abs(whole - exact).max() < FACTOR.few_smooth * np.abs(exact).max()


def test_shapes_that_rounding_makes_alike_are_left_out():
    """Oscillators of 1, 2, 3 and 4 rad/s, sought by three shapes of which two are the same but for 1e-7."""
    mass, stiffness = (Stack.of_full(np.diag(part)[None]) for part in (np.ones(4), np.arange(1.0, 5.0) ** 2))
    start = np.array([[1.0, 0.2, 0.1, 0.1], [0.3, 1.0, 0.1, 0.2], [0.3, 1.0, 0.1, 0.2 + 1e-7]])
    squares, shapes, _ = slowest(mass, stiffness, start, 2)
    assert squares[0] == pytest.approx([1, 1 / 4], rel=1e-3)  # the iteration ends where it changes by less
    assert shapes.shape == (1, 2, 4)
    with pytest.raises(SolverError, match="the damping needs 3 modes, and rounding leaves 2"):
        slowest(mass, stiffness, start, 3)


def test_steps_that_resolve_no_mode_leave_all_undamped(monkeypatch):
    """At 0.05 rad/s the answer is the static one to 1e-4: steps of 2 s damp by themselves what they do not resolve."""
    monkeypatch.setattr(module, "DAMPED", replace(module.DAMPED, small=10))
    scene = seed_four_bar(
        damping={"ratio": 0.02},
        effects=("coupling",),
        analysis={"sub_intervals": 60, "stations": 5, "solver": "collocation"},
    ).changed(drive__speed=0.05, analysis__allow_coarse=True)
    assert damped_modes(scene, mechanism(scene)).count == 0
    found = response_of(scene).data["strain"]
    static = response_of(scene.changed(analysis__method="quasi-static", analysis__solver="auto", damping__ratio=0.0))
    assert abs(found - static.data["strain"]).max() < 1e-4 * abs(found).max()
