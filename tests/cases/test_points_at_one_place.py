"""Several points of a bending link at one place, each with a joint of its own."""

import math
from pathlib import Path

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.studies.natural_frequencies import modes
from tests.common import DEMOS

CASES = Path(__file__).parent / "scenes"


def lift(**changes):
    """Give the scissor lift with linear effects, so slow that its inertia is about 2e-5 of its weight."""
    scene = fm.load(CASES / "two_points_one_place.toml")
    slow = {"drive.period": 400.0, "effects": (), "tolerance": None}
    return scene.changed(slow | {"analysis": {"method": "quasi-static", "sub_intervals": 40}} | changes)


def check_by_hand(scene):
    """Compare forces with statics of the platform, and with the power of the cylinder."""
    result = fm.analyse(scene)
    motion = solve_motion(scene, result.data["theta"].to_numpy())
    acting = {("platform", (0.6, 0.0)): 4905.0, ("barrel", (0.0, 0.0)): 8 * 9.81}
    for label, (link, _) in scene.members().items():
        (x, y), (x2, y2) = scene.member_ends(label)
        weight = 9.81 * float(scene.rigidity(label, np.zeros(1)).line_density[0]) * math.dist((x, y), (x2, y2))
        acting[link, ((x + x2) / 2, (y + y2) / 2)] = weight
    pin, roller = motion.of_point("platform", (0.0, 0.0))[0], motion.of_point("arm1", (1.2, 0.0))[0]
    carried = {at: weight for at, weight in acting.items() if at[0] == "platform"}
    # moments on the platform about its pin; loads are vertical, and the slot takes no force along it
    moment = sum(weight * (motion.of_point(*at)[0] - pin)[:, 0] for at, weight in carried.items())
    upper = moment / (roller - pin)[:, 0]
    force = {name: result.data["joint_force"].sel(joint=name).to_numpy() for name in ("upper", "P")}
    # 1e-4: inertia, and the weights of elements at their nodes
    assert force["upper"][:, 1] == pytest.approx(-upper, rel=1e-4)
    assert force["P"][:, 1] == pytest.approx(upper - sum(carried.values()), rel=1e-4, abs=1e-4 * upper.max())
    assert np.abs(force["upper"][:, 0]).max() < 1e-4 * upper.max()
    assert np.abs(force["P"][:, 0]).max() < 1e-4 * upper.max()
    lifted = sum(weight * motion.of_point(*at)[1][:, 1] for at, weight in acting.items())
    rate = scene.drives[0].law.jet(motion.theta).first * scene.cycle_rate
    power = result.data["input_torque"].to_numpy() * rate
    assert power == pytest.approx(lifted, rel=1e-3, abs=1e-4 * np.abs(lifted).max())


@pytest.mark.slow
def test_a_lift_with_a_pin_and_a_slot_at_one_place_carries_its_load_as_by_hand():
    check_by_hand(lift())


@pytest.mark.slow
def test_a_slot_along_the_member_at_whose_end_its_point_is():
    """A pin that travels along a bending member: the same statics, as deflections are not in linear effects."""
    scene = lift()
    joint = scene.joints["upper"].model_dump() | {"member": "PZ", "angle": 0.0}
    platform = scene.links["platform"].model_dump()
    member = platform["members"]["PW"]
    platform["members"] = {"PZ": member | {"ends": ("P", "Z")}}
    del platform["points"]["W"]
    load = scene.loads["payload"].model_dump() | {"at": "platform@0.48"}
    data = scene.model_dump()
    data["joints"]["upper"], data["links"]["platform"], data["loads"]["payload"] = joint, platform, load
    check_by_hand(fm.Scene.read(data))


@pytest.mark.parametrize("beside", [0.0, 1e-9, 1e-7])  # of the link's size: the last digits of a drawing
def test_two_pins_at_one_place_are_one_pin_of_three_links(beside):
    """Two points of a link at one place, each pinned to another link, are as one pin through all three."""
    one = fm.load(DEMOS / "jansen.toml").changed(
        {"analysis": {"method": "quasi-static", "sub_intervals": 24, "allow_coarse": True}}
    )
    name = "KL"
    first, second, third = one.joints[name].connect
    data = one.model_dump()
    body, point = first.split(".")
    x, y = one.links[body].points[point]
    data["links"][body]["points"]["other"] = (x + beside * math.hypot(x, y), y)
    data["joints"][name]["connect"] = (first, second)
    data["joints"]["other"] = data["joints"][name] | {"connect": (f"{body}.other", third)}
    two = fm.analyse(fm.Scene.read(data)).data["strain"]
    expected = fm.analyse(one).data["strain"]
    # the pin is where it is stated, beside the other one: strains change by 50 times the share of that
    assert np.abs(two - expected).max() < max(1e-9, 60 * beside) * np.abs(expected).max()


def test_masses_and_springs_take_hold_of_such_points():
    scene = fm.load(CASES / "rotating_strip.toml")
    link, body = next(iter(scene.links.items()))
    end = list(body.points)[-1]
    data = scene.model_dump()
    data["links"][link]["points"]["same"] = body.points[end]
    frequencies = []
    for point in (end, "same"):
        data["masses"] = {"tip": {"at": f"{link}.{point}", "mass": 0.1}}
        frequencies.append(modes(fm.Scene.read(data)).data["frequency"].to_numpy().ravel()[0])
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-12)


def test_a_point_beside_the_members_is_refused_with_a_remedy():
    scene = fm.load(CASES / "two_points_one_place.toml")
    with pytest.raises(SceneError, match=r"point 'Q' is on no member.*or at the place of such an end"):
        scene.changed({"links.platform.points.Q": (0.0, 1e-4)})
