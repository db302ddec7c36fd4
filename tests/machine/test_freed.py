"""A machine of rigid links as one of its freedoms: tangents, and what follows where nothing holds it."""

import numpy as np
import pytest

from fenics_mech import Scene, analyse
from fenics_mech.answers.rigid_in_time import freed_of
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.scene.start_state import StartState

LENGTHS = {"crank": ("OA", 0.2), "coupler": ("AB", 0.5), "follower": ("CB", 0.4)}


def four_bar(**rest):
    """Give a four-bar that its weight, a spring and a damper move."""
    links = {
        name: {
            "points": {ends[0]: (0, 0), ends[1]: (length, 0)},
            "rigid": {"mass": 1.0, "inertia": 0.02, "centre": (length / 2, 0.05)},
        }
        for name, (ends, length) in LENGTHS.items()
    }
    links["coupler"]["angle"], links["follower"]["angle"] = 0.6, 1.9
    pins = {"O": "ground.O crank.O", "A": "crank.A coupler.A", "B": "coupler.B follower.B", "C": "ground.C follower.C"}
    scene = {
        "ground": {"points": {"O": (0, 0), "C": (0.5, 0)}},
        "links": links,
        "joints": {name: {"connect": points.split()} for name, points in pins.items()},
        "freedoms": {"O": {"start": 1.0, "inertia": 0.01}},
        "springs": {"s": {"joint": "B", "stiffness": 4.0, "angle": 0.2}},
        "dampers": {"d": {"joint": "C", "damping": 0.3}},
        "gravity": (0, -9.81),
        "analysis": {"method": "transient", "duration": 1.0},
    }
    return Scene.read(scene | rest)


RUBS = {"rubs": {"kind": "friction", "joint": "A", "coefficient": 0.2, "radius": 0.02, "width": 0.5}}


@pytest.mark.parametrize("laws", [{}, RUBS])
def test_tangents_are_differences_of_the_residual(laws):
    made = machine_of(four_bar(joint_laws=laws))
    t, states = np.array([0.2, 0.3]), [np.array([[0.0], [0.2]]), np.array([[3.0], [-2.0]]), np.array([[5.0], [7.0]])]
    freed = freed_of(made, StartState(0.0, np.array([1.0]), np.array([3.0])))
    found = freed.residual(t, *states)
    tangents = (x.reshape(2, 1, 1) for x in (found.M, found.C, found.K))
    for which, tangent in zip((2, 1, 0), tangents):
        step, sides = 1e-5, []
        for sign in (1, -1):
            beside = list(states)
            beside[which] = beside[which] + sign * step
            sides.append(freed.residual(t, *beside).force)
        differences = (sides[0] - sides[1]) / (2 * step)
        np.testing.assert_allclose(tangent[:, :, 0], differences, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("laws", [{}, {"rubs": {"kind": "friction", "joint": "O", "coefficient": 0.0, "radius": 0.01}}])
def test_a_fast_rotor_with_its_mass_beside_the_axis_is_pulled_by_it_alone(laws):
    """Its forces are m r w^2 = 2.5 kN about, and what is left of the moment is rounding of that, not of 1 N m."""
    rotor = {
        "ground": {"points": {"O": (0, 0)}},
        "links": {"rotor": {"points": {"O": (0, 0)}, "rigid": {"mass": 2.0, "inertia": 0.1, "centre": (0.05, 0)}}},
        "joints": {"O": {"connect": ["ground.O", "rotor.O"]}},
        "freedoms": {"O": {"start": 0.0, "speed": "1500 rpm"}},
        "joint_laws": laws,
        "analysis": {"method": "transient", "duration": 1.0, "sub_intervals": 10, "error_estimates": False},
    }
    data, speed = analyse(Scene.read(rotor)).data, 50 * np.pi
    np.testing.assert_allclose(np.linalg.norm(data["joint_force"][:, 0], axis=-1), 2 * 0.05 * speed**2, rtol=1e-10)
    assert data["freedom_place"][-1, 0].item() == pytest.approx(speed, rel=1e-11)


def test_friction_tells_how_far_it_is_off_its_law_under_a_share_of_the_loads():
    machine = machine_of(four_bar(joint_laws=RUBS)).machine
    t, q, a = np.zeros(1), np.zeros((1, machine.size)), np.full((1, machine.size), 2.0)
    told = [machine.residual(t, q, q + np.arange(machine.size), a, loads=loads).terms for loads in (1.0, 0.5)]
    for terms in told:
        assert max(term.response.off / term.response.limit for term in terms if term.response.limit) > 0.1


def test_what_moves_freely_fulfils_the_equation_and_keeps_the_work_of_what_acts():
    """Power of weight, springs and dampers changes the kinetic energy: by accelerations that nothing holds."""
    made = machine_of(four_bar())
    place, rate = np.array([1.0]), np.array([3.0])
    freed = freed_of(made, StartState(0.0, place, rate))
    moved, _ = freed.freely(freed.stages, rate[None])
    left = freed.residual(moved.t, 0 * place[None], rate[None], moved.a).force
    assert np.abs(left).max() < 1e-11
    loose = machine_of(four_bar(springs={}, dampers={}, gravity=(0, 0)))
    free = freed_of(loose, StartState(0.0, place, rate))
    a = free.freely(free.stages, rate[None])[0].a
    mass = [free.residual(moved.t, 0 * place[None] + x, rate[None], a).M.item() for x in (-1e-4, 0.0, 1e-4)]
    by_place = (mass[2] - mass[0]) / 2e-4
    assert a[0, 0] == pytest.approx(-by_place * rate[0] ** 2 / (2 * mass[1]), rel=1e-7)  # Eksergian's equation
