"""The effects that the program chooses, against all effects on."""

import pytest

from fenics_mech import analyse, load
from fenics_mech.effects import EFFECTS
from fenics_mech.studies.effect_costs import largest_difference
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


def test_every_effect_says_what_it_is_and_where_it_comes_from():
    for name, effect in EFFECTS.items():
        assert effect.name == name
        assert effect.meaning
        assert effect.source
