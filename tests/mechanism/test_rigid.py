"""Rigid-body modes of linkages that nothing drives, against closed forms; freedoms that are named where they count."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.machine.reach import reachable_range
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import modes_of

E, RHO, WIDTH, HEIGHT, L, G = 200e9, 7800.0, 0.02, 0.002, 0.5, 9.81
EI, LINE = E * WIDTH * HEIGHT**3 / 12, RHO * WIDTH * HEIGHT
FREE_FREE = np.array([4.730041, 7.853205, 10.995608])  # roots of cos x cosh x = 1
FREE_PINNED = np.array([3.926602, 7.068583, 10.210176])  # of tan x = tanh x


def bar(angle=0.0, length=L):
    return {
        "points": {"A": (0, 0), "B": (length, 0)},
        "members": {"AB": {"ends": ("A", "B"), "section": "strip", "material": "steel"}},
        "angle": angle,
    }


def scene(links, joints=None, **rest):
    """A scene of equal bars that nothing drives; its ground has the point O."""
    data = {
        "materials": {"steel": {"modulus": E, "density": RHO}},
        "sections": {"strip": {"shape": "rectangle", "width": WIDTH, "height": HEIGHT}},
        "ground": {"points": {"O": (0, 0)}},
        "links": links,
        "joints": joints or {},
        "mesh": {"elements": 10},
        "analysis": {"method": "static", "modes": 3},
    }
    return Scene.read(data | rest)


def four_bar(**rest):
    """The seed four-bar without its drive."""
    return seed_four_bar(drive=(), **({"analysis": {"method": "static", "modes": 3}} | rest))


def frequencies(case):
    return modes_of(case).frequency[0]


def beam_frequencies(roots):
    return roots**2 / L**2 * np.sqrt(EI / LINE) / (2 * np.pi)


@pytest.mark.parametrize("elements", [2, 20])
def test_free_beam_has_three_rigid_body_modes_and_those_of_the_closed_form(elements):
    """With 2 elements LAPACK solves, which finds the rigid-body modes too; with 20 Krylov-Schur, deflated of them."""
    found = frequencies(scene({"beam": bar(0.4)}, mesh={"elements": elements}))
    assert (found[:3] == 0).all()
    expected = beam_frequencies(FREE_FREE)
    if elements == 20:  # the error of cubic elements, (beta h)^4/720, is 1e-4 of the third
        assert found[3:] == pytest.approx(expected, rel=1.5e-4)
    else:
        assert found[3] == pytest.approx(expected[0], rel=5e-3)
        assert (found[3:5] > expected[:2]).all()


def test_free_beam_is_the_same_at_any_length_of_the_element():
    modes = frequencies(scene({"beam": bar()}, mesh={"elements": 20}, analysis={"method": "static", "modes": "all"}))
    assert len(modes) == 63  # 21 nodes
    assert (modes > 0).sum() == 60


def test_beam_on_one_pin_turns_and_vibrates():
    case = scene({"beam": bar()}, {"O": {"connect": ("ground.O", "beam.A")}})
    found = frequencies(case)
    assert found[0] == 0
    assert found[1:] == pytest.approx(beam_frequencies(FREE_PINNED), rel=1e-3)
    assert reachable_range(case).free == ("link beam can turn freely about joint O",)


def test_pendulum_swings_by_its_weight():
    """The axial force of its weight, as geometric stiffness, is all that a hanging bar has: (3 g/2 L)^(1/2)."""
    hanging = {
        "links": {"bar": bar(-np.pi / 2)},
        "joints": {"O": {"connect": ("ground.O", "bar.A")}},
        "gravity": (0, -G),
    }
    assert frequencies(scene(**hanging))[0] == 0
    swinging = scene(**hanging, effects=("geometric-stiffness",))
    # the bar's bending lowers it by about (swing/bending frequency)^2 = 1e-3 of a small part
    assert 2 * np.pi * frequencies(swinging)[0] == pytest.approx(np.sqrt(1.5 * G / L), rel=1e-4)
    axial = analyse(scene(**hanging)).data["axial_force"].isel(theta=0, member=0).to_numpy()
    assert axial == pytest.approx(LINE * G * L * (1 - np.linspace(0, 1, 21)), abs=1e-9)


def rigid_as(modulus, elements, **rest):
    """Parts of a scene whose bars are of a modulus, in so many elements."""
    return rest | {
        "materials": {"steel": {"modulus": modulus, "density": RHO}},
        "mesh": {"elements": elements},
        "analysis": {"method": "static", "modes": 3},
    }


@pytest.mark.parametrize("elements", [1, 300])
@pytest.mark.parametrize("modulus", [E, 1e18])
def test_pendulum_swings_however_stiff_it_is_beside_its_weight(modulus, elements):
    """The links' stiffness is up to 1e18 of what holds it, and is no measure of whether anything does."""
    joints = {"O": {"connect": ("ground.O", "bar.A")}}
    rest = rigid_as(modulus, elements, gravity=(0, -G), effects=("geometric-stiffness",))
    found = 2 * np.pi * frequencies(scene({"bar": bar(-np.pi / 2)}, joints, **rest))[0]
    # its bending lowers it by 1.7e7 Pa/E, and by 1.1e8 Pa/E where one element has one mean axial force
    assert found == pytest.approx(np.sqrt(1.5 * G / L), rel=1.2e8 / modulus + 1e-10)


@pytest.mark.parametrize("elements", [1, 300])
@pytest.mark.parametrize("modulus", [E, 1e12, 1e18])
def test_two_masses_on_springs_vibrate_however_stiff_they_are(modulus, elements):
    """Bars that slide: K = ((3, -2), (-2, 2)) N/m. Their stretching under their inertia takes 2e-8 for steel."""
    ends = {"A": ("ground.O", "first.A"), "B": ("ground.P", "second.A")}
    joints = {name: {"kind": "prismatic", "connect": pair, "angle": 0.0} for name, pair in ends.items()}
    springs = {
        "one": {"between": ("ground.Q", "first.A"), "stiffness": 1.0},
        "two": {"between": ("first.B", "second.A"), "stiffness": 2.0},
    }
    ground = {"points": {"O": (0, 0), "P": (0.6, 0), "Q": (-0.2, 0)}}
    rest = rigid_as(modulus, elements, ground=ground, springs=springs)
    found = 2 * np.pi * frequencies(scene({"first": bar(), "second": bar()}, joints, **rest))[:2]
    expected = np.sqrt(np.linalg.eigvalsh(np.array([[3, -2], [-2, 2]]) / (LINE * L)))
    assert found == pytest.approx(expected, rel=8e3 / modulus + 1e-12)


def test_only_what_nothing_holds_is_rigid_beside_what_a_spring_holds():
    """Of two bars that slide, a spring of 1e-3 N/m holds one, beside 1e8 N/m of steel."""
    joints = {name: {"kind": "prismatic", "connect": ("ground.O", f"{name}.A"), "angle": 0.0} for name in ("a", "b")}
    springs = {"k": {"between": ("ground.Q", "b.A"), "stiffness": 1e-3}}
    ground = {"points": {"O": (0, 0), "Q": (-0.2, 0)}}
    for elements in (1, 20):
        rest = rigid_as(E, elements, ground=ground, springs=springs)
        found = 2 * np.pi * frequencies(scene({"a": bar(), "b": bar()}, joints, **rest))
        assert found[0] == 0
        assert found[1] == pytest.approx(np.sqrt(1e-3 / (LINE * L)), rel=1e-9)


def test_two_link_pendulum():
    """Two equal bars: omega^2 = 3 g/L (1 -+ 2/7^(1/2)); bending takes 0.1 % of the second."""
    case = scene(
        {"upper": bar(-np.pi / 2), "lower": bar(-np.pi / 2)},
        {"O": {"connect": ("ground.O", "upper.A")}, "A": {"connect": ("upper.B", "lower.A")}},
        gravity=(0, -G),
        effects=("geometric-stiffness",),
    )
    expected = np.sqrt(3 * G / L * (1 + np.array([-2, 2]) / np.sqrt(7)))
    assert 2 * np.pi * frequencies(case)[:2] == pytest.approx(expected, rel=2e-3)
    assert reachable_range(case).free == (
        "link lower can turn freely about joint A",
        "link upper can turn freely about joint O and moves lower with it",
    )


def test_inverted_pendulum_falls():
    case = scene(
        {"bar": bar(np.pi / 2)},
        {"O": {"connect": ("ground.O", "bar.A")}},
        gravity=(0, -G),
        effects=("geometric-stiffness",),
    )
    with pytest.raises(SolverError, match=r"buckles|not positive"):
        analyse(case)


def test_loads_in_equilibrium_bend_a_free_beam():
    """Three forces in equilibrium: the moment in the middle is F L/2, hollow towards the normal."""
    loads = {
        "left": {"at": "beam.A", "force": (0, 1.0)},
        "right": {"at": "beam.B", "force": (0, 1.0)},
        "middle": {"at": "beam@0.5", "force": (0, -2.0)},
    }
    case = scene({"beam": bar()}, loads=loads)
    moment = analyse(case).data["moment"].isel(theta=0, member=0)
    assert float(moment.sel(s=0.5)) == pytest.approx(L / 2, rel=1e-9)
    assert np.abs(moment.sel(s=[0.0, 1.0])).max() < 1e-12


def test_free_beam_under_one_force_carries_its_own_inertia():
    """Inertia relief. With F across its end the beam has the acceleration (4 - 6 s) F/m, and M = F L s (1 - s)^2."""
    case = scene({"beam": bar()}, loads={"push": {"at": "beam.A", "force": (0, 1.0)}})
    with pytest.raises(SceneError, match="link beam can move freely along 90 deg") as refused:
        analyse(case)
    assert refused.value.place == "analysis.method"
    data = analyse(case.changed(analysis__method="quasi-static")).data.isel(theta=0, member=0)
    s = data["s"].to_numpy()
    # the normal points along the force: the beam lags behind, hollow towards it
    assert data["moment"].to_numpy() == pytest.approx(L * s * (1 - s) ** 2, abs=1e-9)


def test_weight_does_not_bend_what_falls():
    data = analyse(scene({"beam": bar(0.3)}, gravity=(0, -G), analysis={"method": "quasi-static"})).data
    assert np.abs(data["strain"]).max() < 1e-15


def test_accelerated_four_bar_balances_on_every_link():
    """Inertia relief of a mechanism: the joints' forces and the links' own inertia are all there is but the load."""
    case = four_bar(
        loads={"push": {"at": "follower.B", "force": (1.0, 0)}}, analysis={"method": "quasi-static", "modes": 3}
    )
    data = analyse(case).data.isel(theta=0)
    # a pin at the end of a link carries no moment
    assert np.abs(data["moment"].sel(s=[0.0, 1.0])).max() < 1e-9
    # no torque turns the crank about O: the force at A does what its inertia takes, with no drive
    assert "input_torque" not in data


def test_springs_hold_a_freedom():
    """A rigid turn against the spring: F times its way is k times the spring's, squared; the links hardly bend."""
    stiffness, force = 400.0, 0.5
    spring = {"s": {"between": ("follower.B", "ground.O"), "stiffness": stiffness}}
    case = four_bar(springs=spring, loads={"push": {"at": "follower.B", "force": (force, 0)}})
    data = analyse(case).data
    # rates of the driven linkage give the one freedom's way
    moving = solve_motion(seed_four_bar(), np.zeros(1)).of_point("follower", (0.27051, 0.0))
    place, way = moving[0][0], moving[1][0]
    along = place @ way / np.linalg.norm(place)
    assert float(data["spring_force"][0, 0]) == pytest.approx(force * way[0] / along, rel=1e-6)
    modes = frequencies(case)
    assert (modes > 0).all()
    assert modes[0] < 20


def test_springs_that_let_links_turn_far_are_refused():
    spring = {"s": {"between": ("follower.B", "ground.O"), "stiffness": 1.0}}
    case = four_bar(springs=spring, loads={"push": {"at": "follower.B", "force": (1.0, 0)}})
    with pytest.raises(SolverError, match=r"turns member '\w+' by .* rad"):
        analyse(case)


def test_choosing_effects_of_a_free_beam():
    case = scene(
        {"beam": bar()},
        effects="auto",
        analysis={"method": "quasi-static"},
        loads={"push": {"at": "beam.A", "force": (0, 1.0)}},
    )
    assert np.isfinite(analyse(case).data["strain"]).all()


def test_slider_without_a_drive_slides():
    joints = {"S": {"kind": "prismatic", "connect": ("ground.O", "beam.A")}}
    assert reachable_range(scene({"beam": bar()}, joints)).free == (
        "link beam can move freely along 0 deg, in joint S",
    )


def carried(share, up, **rest):
    """A coupler on two equal cranks, upright or hanging, pushed along with twice so many Euler loads.

    Half of the mass is at its other end, so that its axial force is one share everywhere; 1 N/m bends it meanwhile.
    """
    euler = np.pi**2 * EI / L**2
    links = {
        "left": bar(up * np.pi / 2, 0.3),
        "right": bar(up * np.pi / 2, 0.3),
        "coupler": bar(),
    }
    joints = {
        "O": {"connect": ("ground.O", "left.A")},
        "C": {"connect": ("ground.C", "right.A")},
        "A": {"connect": ("left.B", "coupler.A")},
        "B": {"connect": ("right.B", "coupler.B")},
    }
    values = {
        "materials": {"steel": {"modulus": E, "density": 1e-3}},
        "ground": {"points": {"O": (0, 0), "C": (L, 0)}},
        "masses": {name: {"at": f"coupler.{name}", "mass": 10.0} for name in "AB"},
        "loads": {
            "push": {"at": "A", "force": (2 * share * euler, 0)},
            "side": {"member": "coupler", "line": (0, -1.0)},
        },
        "effects": ("geometric-stiffness",),
        "analysis": {"method": "quasi-static"},
    }
    return scene(links, joints, **(values | rest))


@pytest.mark.parametrize("up", [1, -1])
@pytest.mark.parametrize("share", [1 / 80, 0.6])
def test_free_linkage_that_gives_way_to_a_push_is_a_beam_column(up, share):
    """Timoshenko and Gere, Theory of Elastic Stability, section 1.3: M = q L^2/8 2 (sec u - 1)/u^2, u = L/2 (N/EI)^1/2.

    The cranks are 0.25 N from falling or hanging, which is no buckling as the linkage is not at rest.
    """
    found = analyse(carried(share, up)).data.sel(member="coupler").isel(theta=0)
    u = np.pi / 2 * np.sqrt(share)
    moment = L**2 / 8 * 2 * (1 / np.cos(u) - 1) / u**2
    # 10 cubic elements: the moment of N times the sag is good to about 1e-5
    assert float(found["moment"].sel(s=0.5)) == pytest.approx(moment, rel=3e-5)


@pytest.mark.parametrize("up", [1, -1])
def test_free_linkage_that_gives_way_to_a_push_still_buckles(up):
    with pytest.raises(SolverError, match=r"buckles at drive angle 0 deg: .* link coupler gives way"):
        analyse(carried(1.02, up))
    assert analyse(carried(0.98, up)).data["moment"].notnull().all()


def test_free_four_bar_under_1_newton_is_nearly_as_without_axial_forces():
    """It was said to buckle at 1/80 of the Euler load, which changes strains by a share of 0.01."""
    loads = {"p": {"at": "coupler.B", "force": (1.0, 0.0)}}
    quasi_static = {"loads": loads, "analysis": {"method": "quasi-static"}}
    plain, stiffened = (
        analyse(four_bar(effects=effects, **quasi_static)).data["strain"] for effects in ((), ("geometric-stiffness",))
    )
    assert 1e-3 < float(np.abs(plain - stiffened).max() / np.abs(plain).max()) < 0.02


def test_weight_that_hangs_holds_against_a_small_push_only():
    """A bar that hangs turns by ``F/(m g/2)`` at rest; quasi-statically it gives way and accelerates."""
    weight = LINE * L * G
    hanging = {
        "links": {"bar": bar(-np.pi / 2)},
        "joints": {"O": {"connect": ("ground.O", "bar.A")}},
        "gravity": (0, -G),
        "effects": ("geometric-stiffness",),
    }
    for share, method in ((0.01, "static"), (0.5, "quasi-static")):
        push = {"push": {"at": "bar.B", "force": (share * weight / 2, 0)}}
        data = analyse(scene(**hanging, loads=push, analysis={"method": method})).data
        tip = data["deflection"].isel(theta=0, member=0, s=-1)
        # small turns, and the bar's own bending of 1e-4 of it
        expected = share * L if share < 0.1 else 0.0
        assert float(tip.sel(component="x")) == pytest.approx(expected, abs=1e-2 * share * L)
