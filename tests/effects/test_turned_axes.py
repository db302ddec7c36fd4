"""What acts on the rotation of axes that turn far: closed forms, the elastica, geometrically exact beams, energy."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_mech.analysis import analyse
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.studies.follow import follow
from tests.effects import strips
from tests.effects.turned_machine import four_bar

EI = strips.E * strips.INERTIA
TURNS = [0.1, 0.3, 0.6, 1.0, 1.3]


def on_weld(load, elements=16, **changes):
    """A cantilever with a load at its tip, in units of EI/L^2 and EI/L."""
    return held(load, {"kind": "weld"}, elements, **changes)


def on_spring(load, stiffness, elements=16):
    """A beam that a torsional spring (EI/L) of its pin holds, with a load at its tip."""
    spring = {"root": {"joint": "O", "stiffness": stiffness * EI / strips.L}}
    return held(load, {}, elements, springs=spring)


def held(load, joint, elements, **changes):
    stated = {"at": "beam.B", "force": (0, load.get("force", 0.0) * EI / strips.L**2)}
    stated |= {"moment": load.get("moment", 0.0) * EI / strips.L, "follows": load.get("follows", False)}
    scene = strips.beam({"O": joint}, effects=("large-rotations",), mesh={"elements": elements})
    return scene.changed(loads={"tip": stated}, analysis__stations=33, **changes)


def tip(data):
    """Rotation and place of the tip, over the length."""
    x, y = data["deflection"].isel(theta=0, member=0, s=-1).to_numpy() / strips.L
    return [data["rotation"].item(), 1 + x, y]


def along(data, name, place):
    return data[name].isel(theta=0, member=0, s=place).item()


def from_tip(force, turn=0.0):
    """Rotation and moment at the root of an elastica of length 1, and the place of its tip seen from there.

    It is integrated from the tip, which is turned by `turn`; the force is along y, and EI is 1.
    """

    def rates(_, state):
        angle, x, _ = state
        return [-force * x, np.cos(angle), np.sin(angle)]

    angle, x, y = solve_ivp(rates, (0, 1), [turn, 0, 0], rtol=1e-12, atol=1e-14).y[:, -1]
    return angle, force * x, np.array([x, y])


@pytest.mark.parametrize("turn", TURNS)
def test_a_moment_bends_a_cantilever_to_a_circle(turn):
    data = analyse(on_weld({"moment": turn})).data
    assert tip(data) == pytest.approx([turn, np.sin(turn) / turn, (1 - np.cos(turn)) / turn], rel=4e-7)
    moment = data["moment"].isel(theta=0, member=0).to_numpy() * strips.L / EI
    assert moment == pytest.approx(turn, rel=1e-6)
    # without forces there are neither axial nor shear ones
    assert abs(along(data, "shear_force", 16)) < 1e-5 * EI / strips.L**2


def test_a_moment_turns_any_elements_as_its_closed_form():
    assert tip(analyse(on_weld({"moment": 1.3}, 8)).data)[0] == pytest.approx(1.3, abs=1e-12)


@pytest.mark.parametrize("turn", TURNS)
def test_a_force_that_follows_stays_across_the_tip(turn):
    force = brentq(lambda force: -from_tip(force)[0] - turn, 1e-3, 6, xtol=1e-14)
    _, moment, (x, y) = from_tip(force)  # in the axes of the tip
    c, s = np.cos(turn), np.sin(turn)
    data = analyse(on_weld({"force": force, "follows": True})).data
    newtons = force * EI / strips.L**2
    near = 1e-6 + 1e-6 * turn**8 + newtons / (strips.E * strips.A)  # h^4, and the stretch
    assert tip(data) == pytest.approx([turn, c * x - s * y, s * x + c * y], rel=near)
    assert along(data, "moment", 0) == pytest.approx(moment * EI / strips.L, rel=near)
    assert abs(along(data, "axial_force", -1)) < 1e-5 * newtons
    assert abs(along(data, "shear_force", -1)) == pytest.approx(newtons, rel=1e-5)
    # the support holds it where it has turned to
    held = data["joint_force"].isel(theta=0).sel(joint="O").to_numpy()
    assert held == pytest.approx(newtons * np.array([s, -c]), rel=10 * near)


@pytest.mark.parametrize("turn", TURNS)
def test_a_torsional_spring_turns_by_the_moment_over_its_stiffness(turn):
    moment, stiffness = turn / 1.5, 2.0
    root = moment / stiffness
    data = analyse(on_spring({"moment": moment}, stiffness)).data
    x, y = np.sin(turn) - np.sin(root), np.cos(root) - np.cos(turn)
    assert tip(data) == pytest.approx([turn, x / moment, y / moment], rel=2e-7)
    assert data["spring_force"].item() == pytest.approx(moment * EI / strips.L, rel=1e-7)


@pytest.mark.parametrize("turn", TURNS)
def test_a_beam_on_a_torsional_spring_under_a_dead_force(turn):
    stiffness = 2.0

    def lack(force):
        angle, moment, _ = from_tip(force, turn)
        return angle - moment / stiffness

    force = brentq(lack, 1e-3, 6 * np.tan(turn), xtol=1e-14)
    _, moment, place = from_tip(force, turn)
    scene = on_spring({"force": force}, stiffness).changed(analysis__allow_large=True)  # stretched, it turns 1e-6 more
    data = analyse(scene).data
    near = 1e-6 + force * EI / strips.L**2 / (strips.E * strips.A)
    assert tip(data) == pytest.approx([turn, *place], rel=near)
    assert data["spring_force"].item() == pytest.approx(moment * EI / strips.L, rel=near)


@pytest.mark.parametrize("load", [{"moment": 0.8}, {"force": 1.5, "follows": True}])
def test_torque_that_holds_a_driven_beam(load):
    expected = load.get("moment") or from_tip(load["force"])[1]
    still = held(load, {}, 16, ground__points={"O": (0, 0)}, drive={"joint": "O", "speed": 1.0})
    torque = analyse(still.changed(analysis__method="static")).data["input_torque"].item()
    assert torque == pytest.approx(-expected * EI / strips.L, rel=1e-5)


@pytest.mark.parametrize("follows", [True, False])
def test_arm_of_a_force_on_a_rigid_lever(follows):
    # a dead force has the arm L cos(phi), one that follows L: the sine of phi is the lever's coordinate
    lever = {"points": {"O": (0, 0), "P": (0.1, 0)}, "rigid": {"mass": 1.0, "inertia": 1.0}}
    scene = strips.beam({"B": {"kind": "weld"}}, effects=("large-rotations",)).changed(
        links__lever=lever,
        joints__lever={"connect": ("ground.O", "lever.O")},
        springs={"lever": {"joint": "lever", "stiffness": 40.0}},
        loads={"turn": {"at": "lever.P", "force": (0, 32.0), "follows": follows}},
    )
    turned = 0.08 if follows else brentq(lambda turned: 40 * turned - 3.2 * np.cos(turned), 0, 1)
    assert analyse(scene).data["spring_force"].item() == pytest.approx(40 * turned, rel=1e-9)


@pytest.mark.parametrize("acting", ["loads", "springs", "dampers"])
def test_energy_balances(acting):
    # 1e-6 of 120 Radau steps under the force that follows, less of the others: rotations reach 0.5 rad
    data = analyse(four_bar((acting,))).data
    assert data.attrs["power_balance_error"] < 3e-6
    assert data["rotation"].max() > {"dampers": 0.1}.get(acting, 0.25)


@pytest.mark.slow
def test_energy_of_a_motion_in_time_balances_with_what_springs_store():
    # samples of the sudden start leave 1.1e-4; 3e-3 if springs stored the energy of slopes
    scene = four_bar(("springs",), analysis__method="transient", analysis__cycles=1, analysis__sub_intervals=480)
    assert analyse(scene).data.attrs["power_balance_error"] < 3e-4


def from_chords(scene, data):
    """Distances of the members' middles from their chords along the normal (m), ``(angles, members)``."""
    motion = solve_motion(scene, scene.drive_angles(len(data["theta"])))
    found = []
    for label, (link, _) in scene.members().items():
        first, last = (motion.of_point(link, end)[0] for end in scene.member_ends(label))
        moved = data["deflection"].sel(member=label).sel(s=[0, 0.5, 1]).to_numpy()
        first, middle, last = first + moved[:, 0], (first + last) / 2 + moved[:, 1], last + moved[:, 2]
        chord, rise = last - first, middle - (first + last) / 2
        found.append((chord[:, 0] * rise[:, 1] - chord[:, 1] * rise[:, 0]) / np.linalg.norm(chord, axis=1))
    return np.stack(found, axis=-1)


def test_a_machine_agrees_with_geometrically_exact_beams():
    exact = pd.read_csv("tests/data/turned_exact.csv", comment="#")
    scene = four_bar(elements=4)
    data = analyse(scene).data
    assert data["rotation"].max() > 0.4
    found = np.column_stack(
        [from_chords(scene, data)[:, 1:], data["strain_bending"].sel(member="follower", s=0.5, fibre="+")]
    )
    known = exact.to_numpy()[:, 1:]
    # 3.3e-4 with 4 elements, by the mesh (2.3e-5 with 8); 3e-2 where slopes were taken for rotations
    assert (np.abs(found[::5] - known).max(axis=0) < 4e-4 * np.abs(known).max(axis=0)).all()


@pytest.mark.long
@pytest.mark.slow
def test_solvers_agree():
    scene = four_bar(analysis__sub_intervals=240)
    steady = analyse(scene).data
    balanced = analyse(scene.changed(analysis__solver="harmonic-balance", analysis__harmonics=40)).data
    for name, near in (("strain", 1e-6), ("input_torque", 2e-6)):
        largest = np.abs(steady[name]).max().item()
        assert np.abs(balanced[name] - steady[name]).max().item() < near * largest
    # with the default, 1e-5, rests of fast vibrations make 1.5e-4 of the torque, of which 4.6e-4 is told
    fine = {"analysis__method": "transient", "analysis__cycles": 5, "analysis__time_tolerance": 1e-8}
    in_time = analyse(scene.changed(**fine)).data.isel(theta=slice(-241, -1))
    for name in ("strain", "input_torque"):
        largest = np.abs(steady[name]).max().item()
        assert np.abs(in_time[name].to_numpy() - steady[name].to_numpy()).max() < 2e-6 * largest


@pytest.mark.slow
def test_a_branch_over_a_moment_ends_where_an_analysis_does():
    branch = follow(four_bar(), "loads.moment.moment", (1.0, 2.5), points=4)
    data = analyse(four_bar()).data
    expected = np.linalg.norm(data["deflection"], axis=-1).max(axis=(0, 2))
    assert branch.data["peak_deflection"].to_numpy()[-1] == pytest.approx(expected, rel=2e-3)  # between positions, too
    assert branch.data["iterations"].max() <= 3  # Newton's method has the tangents
