"""The effects that the program chooses, against all effects on."""

import dataclasses
import io

import pytest
from rich.console import Console

from fenics_mech import analyse, load
from fenics_mech.effects import EFFECTS
from fenics_mech.planning.effect_choice import choose, decided, examine
from fenics_mech.studies.effect_costs import largest_difference
from fenics_mech.views.tables import effects_table
from tests.common import response_of, with_all_effects

DEMOS = (
    "composite_four_bar",
    "counterweighted_rocker",
    "four_bar",
    "manipulator",
    "quick_return",
    "slider_crank",
    "stephenson",
)
QUICK = {
    "analysis__sub_intervals": 60,
    "analysis__stability": False,
    "analysis__allow_coarse": True,
    "mesh__elements": 2,
}
SPEEDS = {"crawling": 0.5, "medium": 10.0, "fast": 24.0}  # rad/s, of the seed four-bar
HEAVY = {"gravity": (0.0, -9.81), "drive__speed": 4.0}
THICK = {
    "sections__crank": {"shape": "rectangle", "width": 0.02, "height": 0.03},
    "sections__strip": {"shape": "rectangle", "width": 0.02, "height": 0.02},
    "materials__aluminium__poisson": 0.33,
    "drive__speed": 200.0,
}


def scenes():
    """Scenes that are slow, fast, slender, thick, heavy, compressed, with slides, with many links."""
    for name in DEMOS:
        yield name, load(f"demos/{name}.toml").changed(**QUICK)
    for name, speed in SPEEDS.items():
        yield name, load("demos/four_bar.toml").changed(drive__speed=speed, **QUICK)
    yield "heavy", load("demos/four_bar.toml").changed(**HEAVY, **QUICK)
    yield "thick", load("demos/four_bar.toml").changed(**THICK, **QUICK)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "scene"), list(scenes()), ids=lambda value: value if isinstance(value, str) else "")
def test_what_is_left_out_is_below_the_tolerance(name, scene):
    chosen, whole = analyse(scene.changed(effects="auto")), response_of(with_all_effects(scene))
    assert largest_difference(chosen, whole) < scene.neglected


def test_slow_machines_are_quasi_static_and_fast_ones_are_not(seed):
    crawling, _ = choose(seed.changed(effects="auto", drive__speed=0.5))
    assert crawling.analysis.method == "quasi-static"
    fast, _ = choose(seed.changed(effects="auto"))
    assert set(fast.effects) == {"coupling", "large-rotations"}


def test_a_tolerance_of_one_part_in_ten_needs_less(seed):
    slow = seed.changed(drive__speed=8.0, effects="auto", tolerance=0.6)
    chosen, choices = choose(slow)
    vibration = next(choice.size for choice in choices if choice.effect.name == "vibration")
    assert 0.1 < vibration < 0.3 * 0.6  # what the effects left out may come to
    assert chosen.effects == ()
    assert chosen.analysis.method == "quasi-static"


def test_gravity_is_left_out_where_inertia_is_far_larger(seed):
    fast = seed.changed(gravity=(0.0, -9.81), effects="auto", tolerance=0.2)
    chosen, choices = choose(fast)
    assert chosen.gravity == (0.0, 0.0)
    by_name = {choice.effect.name: choice for choice in choices}
    assert 0.01 < by_name["gravity"].size < 0.1
    assert not by_name["gravity"].acts


def test_an_effect_whose_data_the_scene_lacks_is_named(seed):
    scene = seed.changed(effects="auto")
    found = dataclasses.replace(examine(scene), slenderness=0.1)
    chosen, choices = decided(scene, found)
    shear = next(choice for choice in choices if choice.effect.name == "shear")
    assert "sections.crank.shear_factor" in shear.missing
    told = io.StringIO()
    Console(file=told, width=300).print(effects_table(choices, 0.005))
    assert f"shear would act, but lacks data: {shear.missing}" in told.getvalue()
    assert not shear.acts
    assert "shear" not in chosen.effects


def test_every_effect_says_what_it_is_and_where_it_comes_from():
    for name, effect in EFFECTS.items():
        assert effect.name == name
        assert effect.meaning
        assert effect.source
        assert effect.estimate or effect.size is None
