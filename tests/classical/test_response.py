"""The dissertation's method against static answers, hand programs, printed numbers and the equation of poses."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.answers.by_sub_intervals import ByModes
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.motion import Motion
from fenics_mech.recovery.strains import without_modes
from fenics_mech.solve import damp_modes, periodic, rigid_cycle
from tests.common import DEMOS, response_of
from tests.demos.machines import MACHINES, scene
from tests.validation.reference import NineElementModel, link_strain, periodic_response

SAME = 1e-9  # of the peak: rounding of two programs, whose matrices have conditions of 1e6 to 1e8
RINGING = {"analysis.allow_ringing": True}
BAR = {"shape": "rectangle", "width": "25 mm", "height": "2 mm"}
TAPER = {"shape": "taper", "from": "bar", "to": "tip"}
SHORT = {"analysis.sub_intervals": 120, "analysis.modes": 3, "analysis.stations": 9, "analysis.allow_coarse": True}


def demo(name, changes):
    return fm.load(DEMOS / f"{name}.toml").changed({"effects": (), "tolerance": None} | SHORT | changes)


def inverted(**rocker):
    """A pin of the crank in a guide of the rocker, which moves a slider through a rod."""
    links = {
        "crank": {"points": {"O": (0, 0), "A": (0.05, 0)}, "ends": ("O", "A")},
        "rocker": {"points": {"C": (0, 0), "E": (0.3, 0)}, "angle": "75 deg"} | rocker,
        "rod": {"points": {"E": (0, 0), "F": (0.2, 0)}, "ends": ("E", "F"), "angle": "5 deg"},
    }
    joints = {
        "O": {"connect": ("ground.O", "crank.O")},
        "C": {"connect": ("ground.C", "rocker.C")},
        "A": {"kind": "slot", "connect": ("rocker.C", "crank.A"), "angle": 0.0},
        "E": {"connect": ("rocker.E", "rod.E")},
        "F": {"kind": "slot", "connect": ("ground.F", "rod.F"), "angle": 0.0},
    }
    ground = {"O": (0, 0), "C": (0, -0.15), "F": (0, 0.16)}
    return scene(links, joints, {"joint": "O", "speed": "15 rad/s"}, ground, masses={"F": {"at": "rod.F", "mass": 0.2}})


def three_on_a_pin():
    """A four-bar whose coupler and rocker move a third link by one pin; the crank turns clockwise."""
    links = {
        "crank": {"points": {"O": (0, 0), "A": (0.08, 0)}, "ends": ("O", "A")},
        "left": {"points": {"A": (0, 0), "B": (0.25, 0)}, "ends": ("A", "B"), "angle": "60 deg"},
        "rocker": {"points": {"C": (0, 0), "B": (0.2, 0)}, "ends": ("C", "B"), "angle": "100 deg"},
        "third": {"points": {"B": (0, 0), "D": (0.25, 0)}, "ends": ("B", "D"), "angle": "-10 deg"},
    }
    joints = {
        "O": {"connect": ("crank.O", "ground.O")},
        "A": {"connect": ("crank.A", "left.A")},
        "B": {"connect": ("left.B", "rocker.B", "third.B")},
        "C": {"connect": ("rocker.C", "ground.C")},
        "D": {"kind": "slot", "connect": ("ground.D", "third.D"), "angle": "20 deg"},
    }
    ground = {"O": (0, 0), "C": (0.25, 0), "D": (0.5, 0.15)}
    return scene(links, joints, {"joint": "O", "speed": "-15 rad/s"}, ground)


def led_slider():
    """A slider that a drive leads along its guide moves a rocker through a rod."""
    links = {
        "rod": {"points": {"P": (0, 0), "B": (0.3, 0)}, "ends": ("P", "B"), "angle": "40 deg"},
        "rocker": {"points": {"C": (0, 0), "B": (0.25, 0)}, "ends": ("C", "B"), "angle": "110 deg"},
    }
    joints = {
        "P": {"kind": "slot", "connect": ("ground.G", "rod.P"), "angle": "10 deg"},
        "B": {"connect": ("rod.B", "rocker.B")},
        "C": {"connect": ("ground.C", "rocker.C")},
    }
    law = {"kind": "harmonics", "mean": 0.02, "cosine": [0.03], "sine": [0.0, 0.01]}
    return scene(links, joints, {"joint": "P", "law": law, "period": "0.4 s"}, {"G": (0, 0), "C": (0.3, 0)})


def rigid_rod():
    """A slider-crank whose rod is rigid, and whose guide is at 30 degrees."""
    links = {
        "crank": {"points": {"O": (0, 0), "A": (0.08, 0)}, "ends": ("O", "A")},
        "rod": {
            "points": {"A": (0, 0), "B": (0.25, 0)},
            "rigid": {"mass": 0.2, "inertia": 1e-3, "centre": (0.1, 0.02)},
            "angle": "30 deg",
        },
    }
    joints = {
        "O": {"connect": ("ground.O", "crank.O")},
        "A": {"connect": ("crank.A", "rod.A")},
        "B": {"kind": "slot", "connect": ("ground.O", "rod.B"), "angle": "30 deg"},
    }
    return scene(links, joints, {"joint": "O", "speed": "15 rad/s"}, {"O": (0, 0)})


def yoke():
    """A pin of the crank in a guide of a rigid yoke, which slides along the ground."""
    links = {
        "crank": {"points": {"O": (0, 0), "A": (0.08, 0)}, "ends": ("O", "A")},
        "yoke": {
            "points": {"G": (0, 0), "P": (0, 0)},
            "rigid": {"mass": 0.4, "inertia": 1e-3, "centre": (0.05, 0.01)},
        },
    }
    joints = {
        "O": {"connect": ("ground.O", "crank.O")},
        "G": {"kind": "prismatic", "connect": ("ground.O", "yoke.P"), "angle": 0.0},
        "A": {"kind": "slot", "connect": ("yoke.G", "crank.A"), "angle": "90 deg"},
    }
    return scene(links, joints, {"joint": "O", "speed": "15 rad/s"}, {"O": (0, 0)})


def analysed(scene):
    return fm.analyse(scene.changed({"analysis.solver": "sub-intervals", "analysis.error_estimates": False})).data


def strains(data):
    return data["strain"].transpose("theta", "member", "s", "fibre").to_numpy()


@pytest.mark.parametrize(
    "machine",
    [
        *(MACHINES[name] for name in ("rigid_crank", "piston", "welded_arm")),
        *(inverted, three_on_a_pin, led_slider, rigid_rod, yoke),
    ],
)
def test_what_slow_machines_of_all_joints_do_is_their_static_answer(machine):
    """Links in link frames, without modes and joins; vibration goes with the square of the speed."""
    made = machine() if machine is not inverted else machine(ends=("C", "E"))
    slow = {"drive.period": "4e5 s"} if made.drive.law is not None else {"drive.speed": "1e-5 rad/s"}
    slow = SHORT | slow | {"analysis.modes": 2, "analysis.allow_ringing": True, "gravity": (0.0, -9.81)}
    at_rest = made.changed(slow | {"analysis.method": "quasi-static"})
    found, known = analysed(made.changed(slow)), response_of(at_rest).data
    for name in ("strain", "deflection", "joint_force", "drive_effort", "support_force"):
        wanted = known[name].transpose(*found[name].dims).to_numpy()
        np.testing.assert_allclose(found[name], wanted, atol=1e-5 * np.abs(wanted).max(), err_msg=name)


def test_forces_of_joints_and_sections_balance_those_of_the_links():
    """The weight of all links, and the loads on them, stand on the ground."""
    scene = demo("four_bar", {"gravity": (0.0, -9.81), "drive.speed": "0.01 rad/s"})
    data = analysed(scene.changed({"loads.pull": {"at": "coupler.B", "force": (3.0, -2.0)}}))
    rigidities = zip(scene.rigidities(np.zeros(1)), (0.10795, 0.2794, 0.27051))
    mass = sum(float(part.line_density[0]) * length for part, length in rigidities)
    mass += sum(point.mass for point in scene.masses.values())
    np.testing.assert_allclose(data["shaking_force"].mean("theta"), (3.0, -2.0 - 9.81 * mass), rtol=1e-6)


@pytest.mark.slow
def test_modes_in_time_settle_to_the_periodic_motion():
    in_time = {"analysis.method": "transient", "analysis.cycles": 10, "analysis.settled": 0.0}
    periodic_motion, course = strains(analysed(demo("four_bar", {}))), strains(analysed(demo("four_bar", in_time)))
    last = course[-121:-1]  # 2 % of 270 rad/s dies out by exp(-10) in 2 s
    np.testing.assert_allclose(last, periodic_motion, atol=1e-4 * np.abs(last).max())


def test_frequencies_of_the_seed_are_those_printed():
    """27 degrees of freedom: two programs give these to the mHz. Chapter 7: members on two pins have 47.5 and 50.6."""
    few = demo("four_bar", {"analysis.sub_intervals": 4, "analysis.modes": 6, **RINGING})
    by = ByModes.of(few.changed({"analysis.solver": "sub-intervals"})).found.by
    names = by.mechanism.P.names
    assert len(names) == 27
    assert {"A.X", "B.Y", "coupler@0.333333333333.y", "follower.C.rotation"} < set(names)
    sorted_by_size = np.sort(by.modes.omega[:2] / (2 * np.pi), axis=1)
    printed = [[43.303, 48.744, 62.157, 194.597, 208.326, 475.912], [46.651, 50.171, 81.399, 192.463, 206.778, 476.599]]
    np.testing.assert_allclose(sorted_by_size, printed, atol=0.5e-3)


@pytest.mark.parametrize("join", ["physical", "projected", "modal"])
def test_strains_of_the_seed_are_those_of_the_program_by_hand(join):
    model = NineElementModel()
    wanted = periodic_response(model, 120, modes=3, join=join)
    known = link_strain(model, wanted.theta, wanted.displacement, wanted.acceleration).total
    found = strains(analysed(demo("four_bar", {"analysis.join": join})))[:, :, 4, 0]
    assert (np.abs(found - known).max(axis=0) / np.abs(known).max(axis=0)).max() < SAME


@pytest.mark.slow
def test_poses_differ_by_what_the_truncated_equation_leaves_out():
    """Axial forces and the coupling grow with the square of the speed: 5.5 % of the rod's strain at 60 rad/s."""

    def missed(speed):
        changes = {"drive.speed": speed, "analysis.modes": 6, "analysis.sub_intervals": 720, **RINGING}
        stated = demo("slider_crank", changes | {"analysis.stations": 3})
        made = machine_of(stated)
        made.machine.chart = rigid_cycle(made.machine, stated.period)
        damp_modes(made.machine, stated.period, 0.02, fastest=32.0)
        cycle = periodic(made.machine, stated.period, 60)
        ends = [x[:, -1] for x in (cycle.t, cycle.q, cycle.v, cycle.a)]
        forces = along_members(made, without_modes(Motion(made.machine, *ends)), ends[3], np.array([0.5]))
        rod = stated.rigidity("rod", np.array([0.5]))
        known = forces.axial[:, 1, 0] / rod.axial[0] - forces.moment[:, 1, 0] * rod.fibre[0, 0] / rod.bending[0]
        found = strains(analysed(stated))[:, 1, 1, 0][(np.arange(60) + 1) * 12 % 720]
        return np.abs(found - known).max() / np.abs(known).max()

    slow, fast = missed(30.0), missed(60.0)
    assert 0.04 < fast < 0.07
    assert 3.7 < fast / slow < 4.6  # 4, and terms of the fourth power


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"effects": ("coupling",)}, "effects"),
        ({"springs.s": {"between": ("ground.O", "coupler.B"), "stiffness": 10.0}}, "springs"),
        ({"loads.pull": {"at": "crank.A", "force": (0, 1.0), "follows": True}}, "loads"),
        ({"damping.material": 1e-4}, "damping"),
        ({"links.coupler.members.AB.offset": 0.001}, "links"),
        ({"sections": {"crank": BAR, "bar": BAR, "tip": {**BAR, "height": "1 mm"}, "strip": TAPER}}, "sections"),
    ],
)
def test_what_the_method_does_not_know_is_refused(changes, place):
    for method in ("periodic", "transient"):
        stated = demo("four_bar", {"effects": (), "analysis.solver": "sub-intervals"} | changes)
        with pytest.raises(
            fm.SceneError, match=f"^{place}: .* knows driven links .* solver = 'poses' or 'collocation'"
        ):
            fm.analyse(stated.changed({"analysis.method": method}))


def test_the_program_takes_a_solver_that_knows_the_scene():
    assert analysed_by(demo("four_bar", {})) == "sub-intervals"
    assert analysed_by(demo("four_bar", {"damping.material": 1e-4})) == "poses"


def analysed_by(scene):
    return fm.analyse(scene.changed({"analysis.error_estimates": False})).data.attrs["solver"]


def test_modes_that_ring_are_refused():
    asked = {"analysis.solver": "sub-intervals", "analysis.modes": 8, "analysis.sub_intervals": 48}
    with pytest.raises(fm.UnresolvedError, match="too fast for these sub_intervals"):
        fm.analyse(demo("four_bar", asked))
    in_time = {"analysis.solver": "sub-intervals", "analysis.method": "transient", "analysis.cycles": 1}
    with pytest.raises(fm.UnresolvedError, match=r"mode 6 .* Keep 5 modes, or take at least"):
        fm.analyse(demo("four_bar", in_time | {"analysis.modes": 6}))
