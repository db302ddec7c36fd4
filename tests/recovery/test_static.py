"""Static analysis at a held position (appendix C) against beams whose answers are known."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar

E, EI, A, L = 71e9, 71e9 * 8.67e-12, 4.06e-5, 0.4


def cantilever(**rest):
    return Scene.read(
        {
            "materials": {"aluminium": {"modulus": E, "density": 2714}},
            "sections": {"strip": {"area": A, "inertia": EI / E, "fibre": 8e-4}},
            "ground": {"points": {"O": (0, 0)}},
            "links": {
                "beam": {
                    "points": {"O": (0, 0), "B": (L, 0)},
                    "members": {"OB": {"ends": ("O", "B"), "section": "strip", "material": "aluminium"}},
                }
            },
            "joints": {"O": {"kind": "weld", "connect": ("ground.O", "beam.O")}},
            "analysis": {"method": "static"},
        }
        | rest
    )


def test_cantilever_under_an_end_load():
    result = analyse(cantilever(loads={"tip": {"at": "beam.B", "force": (3.0, -0.5), "moment": 0.02}}))
    data = result.data.isel(theta=0)
    s = data["s"].to_numpy()
    assert np.allclose(data["moment"].sel(member="beam"), 0.02 - 0.5 * L * (1 - s), rtol=0, atol=1e-12)
    assert np.allclose(data["axial_force"], 3.0, rtol=1e-12)
    tip = data["deflection"].sel(member="beam", s=1).to_numpy()
    assert tip[0] == pytest.approx(3.0 * L / (E * A), rel=1e-9)
    assert tip[1] == pytest.approx(-0.5 * L**3 / (3 * EI) + 0.02 * L**2 / (2 * EI), rel=1e-9)
    assert data["joint_force"].sel(joint="O").to_numpy() == pytest.approx([-3.0, 0.5], rel=1e-9)


def test_four_bar_held_against_a_load_needs_the_torque_of_virtual_work():
    # the load on B does work as B moves with the crank: torque d theta + F . dr_B = 0
    from fenics_mech.machine.linkage import solve_motion

    force, position = np.array([5.0, -3.0]), 0.7
    scene = seed_four_bar(
        loads={"press": {"at": "follower.B", "force": tuple(force)}},
        analysis={"method": "static", "position": position},
    )
    data = analyse(scene).data
    velocity = solve_motion(scene, np.array([position])).of_point("follower", (0.27051, 0.0))[1][0]
    assert float(data["input_torque"][0]) == pytest.approx(-force @ velocity / scene.drive.speed, rel=1e-10)


@pytest.mark.parametrize("place", [0.01, 0.3, 0.5])
def test_load_inside_a_member_that_moves_needs_the_torque_of_virtual_work(place):
    # at some of these places an element carries the load inside, without a node of its own
    from fenics_mech.machine.linkage import solve_motion

    force, length = np.array([1.0, -2.0]), 0.2794
    scene = seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True})
    loaded = scene.changed(loads={"press": {"at": f"coupler@{place}", "force": tuple(force)}})
    torque = (analyse(loaded).data["input_torque"] - analyse(scene).data["input_torque"]).to_numpy()
    motion = solve_motion(scene, scene.drive_angles(12))
    velocity = motion.of_point("coupler", (place * length, 0.0))[1]
    assert torque == pytest.approx(-velocity @ force / scene.drive.speed, rel=1e-9, abs=1e-10)


def test_load_joins_the_inertia_in_the_quasi_static_answer():
    load = {"press": {"at": "follower.B", "force": (5.0, -3.0)}}
    analysis = {"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True}
    both, inertia = (analyse(seed_four_bar(analysis=analysis, loads=loads)) for loads in (load, {}))
    alone = analyse(seed_four_bar(analysis={"method": "static", "position": np.pi / 6}, loads=load))
    difference = (both.data["strain"] - inertia.data["strain"]).isel(theta=1)
    assert np.allclose(difference, alone.data["strain"].isel(theta=0), rtol=0, atol=1e-12)
