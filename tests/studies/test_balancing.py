"""Counterweights against closed forms, and inertia forces against those of an analysis with rigid links."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.studies.synthesis.balancing import LinkInertia, link_inertias, shaking
from tests.common import DEMOS, response_of

RIGID = {"effects": (), "analysis.method": "quasi-static"}


def four_bar_counterweights(
    lengths: tuple[float, float, float], bodies: tuple[LinkInertia, ...]
) -> tuple[complex, complex]:
    """First moments that counterweights on crank and follower need to cancel the shaking force of a four-bar."""
    # The origins of crank and follower are at the ground, that of the coupler at the crank, and the x axes along the
    # links. Berkof and Lowen (1969), with the masses of the links themselves.
    crank, coupler, follower = lengths
    of_crank, of_coupler, of_follower = (complex(*body.moment) for body in bodies)
    first = -of_crank - crank * (bodies[1].mass - of_coupler / coupler)
    second = -of_follower - of_coupler * follower / coupler
    return first, second


def slider_crank_counterweights(
    lengths: tuple[float, float], bodies: tuple[LinkInertia, ...], radius: float
) -> tuple[complex, complex]:
    """First moments that counterweights on crank and rod need to cancel the shaking force of a slider-crank."""
    # The counterweight of the rod brings the centre of rod and slider to the crank pin, that of the crank brings the
    # centre of all to the main bearing.
    crank, rod = lengths
    of_crank, of_rod = (complex(*body.moment) for body in bodies[:2])
    second = -of_rod - bodies[2].mass * rod
    first = -of_crank - crank * (bodies[1].mass + bodies[2].mass + abs(second) / radius)
    return first, second


def total(found, link):
    """First moment that the counterweight of a link adds, with its bar (kg m)."""
    before, after = (link_inertias(scene)[link].moment for scene in found)
    return complex(*(after - before))


def test_inertia_forces_are_those_of_an_analysis_with_rigid_links():
    scene = fm.load(DEMOS / "four_bar.toml")
    data = response_of(scene.changed(RIGID)).data
    found = shaking(solve_motion(scene, scene.drive_angles(360)), link_inertias(scene), scene.drive.speed)
    wanted = {"shaking_force": found.force, "shaking_moment": found.moment, "input_torque": found.torque}
    for name, values in wanted.items():
        assert data[name].to_numpy() == pytest.approx(values, abs=1e-9 * np.abs(values).max())  # measured 1e-12


def test_a_four_bar_has_the_counterweights_of_berkof_and_lowen_and_no_shaking_force():
    scene = fm.load(DEMOS / "four_bar.toml")
    balanced = fm.balance(scene, {"crank": 0.05, "follower": 0.05})
    pins = {"crank": "A", "coupler": "B", "follower": "B"}
    lengths = tuple(scene.links[name].points[end][0] for name, end in pins.items())
    closed = four_bar_counterweights(lengths, tuple(link_inertias(scene).values()))
    for name, wanted in zip(("crank", "follower"), closed):
        assert total((scene, balanced.scene), name) == pytest.approx(wanted, rel=1e-8)
    force = [np.abs(response_of(one.changed(RIGID)).data["shaking_force"]).max() for one in (scene, balanced.scene)]
    assert force[1] < 1e-9 * force[0]


def test_a_slider_crank_has_the_counterweights_of_the_closed_form():
    scene = fm.load(DEMOS / "slider_crank.toml")
    balanced = fm.balance(scene, {"crank": 0.05, "rod": 0.05})
    assert balanced.after.rms["force"] < 1e-10 * balanced.before.rms["force"]
    lengths = tuple(np.hypot(*scene.links[name].points[end]) for name, end in (("crank", "A"), ("rod", "B")))
    slider = LinkInertia(0.0, np.zeros(2), 0.0)  # whose mass is at the end of the rod
    closed = slider_crank_counterweights(lengths, (*link_inertias(scene).values(), slider), 0.05)
    assert total((scene, balanced.scene), "rod") == pytest.approx(closed[1], rel=1e-6)


def test_bars_that_taper_or_whose_mass_is_beside_the_axis_balance_too():
    """A mass taken at half of their length, on their axis, left 2e-3 of the force."""
    corner = [(-0.004, -0.01), (0.004, -0.01), (0.004, 0.004), (-0.001, 0.004), (-0.001, 0.01), (-0.004, 0.01)]
    sections = {"corner": {"shape": "polygon", "outline": corner, "axis": "origin"}}
    sections["taper"] = {"shape": "taper", "from": "thick", "to": "thin"}
    sections |= {
        name: {"shape": "rectangle", "width": 0.02, "height": h} for name, h in (("thick", 6e-3), ("thin", 2e-3))
    }
    scene = fm.load(DEMOS / "four_bar.toml")
    scene = scene.changed({f"sections.{name}": one for name, one in sections.items()})
    scene = scene.changed({"links.crank.members.OA.section": "taper", "links.follower.members.CB.section": "corner"})
    found = fm.balance(scene, {"crank": 0.05, "follower": 0.05})
    assert found.after.rms["force"] < 1e-10 * found.before.rms["force"]


def test_rigid_links_have_their_counterweights_in_their_inertia():
    body = {"mass": 0.3, "inertia": 1e-3, "centre": (0.1, 0.02)}
    links = {
        f"links.{link}.{key}": value
        for link in ("crank", "follower")
        for key, value in (("members", {}), ("rigid", body))
    }
    scene = fm.load(DEMOS / "four_bar.toml").changed(links | {"masses": {}})
    balanced = fm.balance(scene)
    force = [np.abs(response_of(one.changed(RIGID)).data["shaking_force"]).max() for one in (scene, balanced.scene)]
    assert force[1] < 1e-10 * force[0]
    weight, own = balanced.counterweights[0], balanced.scene.links["crank"].rigid
    place = weight.radius * np.array([np.cos(weight.angle), np.sin(weight.angle)])
    wanted = LinkInertia.at(0.3, np.array(body["centre"]), 1e-3) + LinkInertia.at(weight.mass, place)
    assert LinkInertia.at(own.mass, np.array(own.centre), own.inertia).inertia == pytest.approx(wanted.inertia)


def test_what_is_on_a_link_stays_there():
    scene = fm.load(DEMOS / "four_bar.toml")
    load = fm.Load(at="follower@0.4", force=(0, 1.0))
    point = fm.TracedPoint(at="follower@0.5", offset=(0, 0.01))
    found = fm.balance(scene.changed({"loads": {"pull": load}, "points": {"P": point}})).scene
    assert (found.loads["pull"].at, found.points["P"].at) == ("follower.CB@0.4", "follower.CB@0.5")


def test_weights_trade_the_force_for_the_moment():
    scene = fm.load(DEMOS / "four_bar.toml")
    alone, compromise = (fm.balance(scene, moment=weight).after.rms for weight in (0.0, 1.0))
    assert compromise["moment"] < alone["moment"]
    assert compromise["force"] > alone["force"]


@pytest.mark.parametrize(
    ("radii", "options", "said"),
    [
        ({"cranky": 0.1}, {}, "no counterweight can be pinned to 'cranky'"),
        ({"crank": -0.1}, {}, "is positive"),
        ({"crank": 2.0}, {}, "heavier than what is needed"),
        (None, {"moment": -1.0}, "a weight is 0 or more"),
        (None, {"section": "beam"}, "beam"),
    ],
)
def test_what_cannot_be_balanced_is_said(radii, options, said):
    with pytest.raises(fm.SceneError, match=said):
        fm.balance(fm.load(DEMOS / "four_bar.toml"), radii, **options)
