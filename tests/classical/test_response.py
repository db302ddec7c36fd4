"""The dissertation's room against today's sub-intervals, hand programs, printed numbers and the equation of poses."""

import doctest

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.classical import sub_intervals, transient
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.recovery.without_modes import without_modes
from fenics_mech.solve import damp_modes, periodic, rigid_cycle
from tests.common import DEMOS, ROOT, response_of
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


def compared(ours, scene):
    """Assert that strains, deflections and frequencies are those of today's program, each over its peak."""
    data = response_of(scene.changed({"analysis.solver": "sub-intervals"})).data
    for found, name, over in (
        (ours.strain, "strain", (0, 2, 3)),
        (ours.deflection, "deflection", (0, 1, 2, 3)),
        (ours.frequency, "frequency", 0),
    ):
        if name not in data:  # frequencies are told of a cycle only
            continue
        dims = [d for d in ("theta", "member", "mode", "s", "fibre", "component") if d in data[name].dims]
        known = data[name].transpose(*dims).to_numpy()
        assert (np.abs(found - known).max(axis=over) / np.abs(known).max(axis=over)).max() < SAME, name
    np.testing.assert_array_equal(ours.members, data["member"])
    np.testing.assert_allclose(ours.theta, data["theta"], rtol=1e-15)


@pytest.mark.parametrize("join", ["physical", "projected", "modal"])
def test_the_seed_is_that_of_sub_intervals_today(join):
    stated = demo("four_bar", {"analysis.join": join})
    compared(sub_intervals(stated), stated)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("four_bar", {"analysis.modes": "all", "analysis.allow_ringing": True}),
        ("four_bar", {"analysis.load": "constant", "analysis.static_correction": False, "damping.ratio": (0.02, 0.05)}),
        ("slider_crank", {"gravity": (0.0, -9.81), "analysis.modes": 2}),
        ("counterweighted_rocker", {}),
        ("manipulator", {"analysis.modes": 2}),
    ],
)
def test_demos_are_those_of_sub_intervals_today(name, changes):
    stated = demo(name, changes)
    compared(sub_intervals(stated), stated)


@pytest.mark.parametrize(("name", "join"), [("watt", "physical"), ("stephenson", "modal")])
def test_six_bars_are_those_of_sub_intervals_today(name, join):
    stated = demo(name, {"analysis.join": join, "analysis.allow_ringing": True})
    compared(sub_intervals(stated), stated)


@pytest.mark.parametrize(
    "machine",
    [
        *(MACHINES[name] for name in ("rigid_crank", "piston", "welded_arm")),
        *(inverted, three_on_a_pin, led_slider, rigid_rod, yoke),
    ],
)
def test_welds_guides_and_rigid_links_are_those_of_sub_intervals_today(machine):
    made = machine() if machine is not inverted else machine(ends=("C", "E"))
    stated = made.changed(SHORT | {"analysis.modes": 2, "analysis.allow_ringing": True})
    compared(sub_intervals(stated), stated)


def test_a_guide_on_a_rigid_link_is_that_of_sub_intervals_today():
    made = inverted(rigid={"mass": 0.3, "inertia": 2e-3, "centre": (0.12, 0.01)})
    stated = made.changed(SHORT | {"analysis.modes": 2, "analysis.allow_ringing": True})
    ours, known = sub_intervals(stated), response_of(stated.changed({"analysis.solver": "sub-intervals"})).data
    strain = known["strain"].transpose("theta", "member", "s", "fibre").to_numpy()
    assert np.abs(ours.strain - strain).max() < SAME * np.abs(strain).max()  # the rod's are small beside the crank's


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("four_bar", {}),
        ("four_bar", {"analysis.join": "projected", "analysis.load": "constant"}),
        ("slider_crank", {"drive.run_up": "0.1 s", "gravity": (0.0, -9.81), "analysis.modes": 2}),
    ],
)
def test_modes_in_time_are_those_of_today(name, changes):
    in_time = {"analysis.method": "transient", "analysis.cycles": 1, "analysis.settled": 0.0}
    stated = demo(name, in_time | changes)
    ours = transient(stated)
    compared(ours, stated)
    assert np.abs(ours.deflection[0]).max() < 1e-2 * np.abs(ours.deflection).max()  # modes left out answer at once


@pytest.mark.slow
def test_modes_in_time_settle_to_the_periodic_motion():
    in_time = {"analysis.method": "transient", "analysis.cycles": 10}
    periodic_motion, course = sub_intervals(demo("four_bar", {})), transient(demo("four_bar", in_time))
    last = course.strain[-121:-1]  # 2 % of 270 rad/s dies out by exp(-10) in 2 s
    np.testing.assert_allclose(last, periodic_motion.strain, atol=1e-4 * np.abs(last).max())


def test_frequencies_of_the_seed_are_those_printed():
    """27 degrees of freedom: two programs give these to the mHz. Chapter 7: members on two pins have 47.5 and 50.6."""
    found = sub_intervals(demo("four_bar", {"analysis.sub_intervals": 4, "analysis.modes": 6, **RINGING}))
    assert len(found.coordinates) == 27
    assert {"A.X", "B.Y", "coupler@0.333333333333.y", "follower.C.rotation"} < set(found.coordinates)
    sorted_by_size = np.sort(found.frequency[:2], axis=1)
    printed = [[43.303, 48.744, 62.157, 194.597, 208.326, 475.912], [46.651, 50.171, 81.399, 192.463, 206.778, 476.599]]
    np.testing.assert_allclose(sorted_by_size, printed, atol=0.5e-3)


@pytest.mark.parametrize("join", ["physical", "projected", "modal"])
def test_strains_of_the_seed_are_those_of_the_program_by_hand(join):
    model = NineElementModel()
    wanted = periodic_response(model, 120, modes=3, join=join)
    known = link_strain(model, wanted.theta, wanted.displacement, wanted.acceleration).total
    found = sub_intervals(demo("four_bar", {"analysis.join": join})).strain[:, :, 4, 0]
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
        whole = made.machine.residual(*ends)
        forces = along_members(made, without_modes(made.machine, *ends, whole), ends[3], np.array([0.5]))
        rod = stated.rigidity("rod", np.array([0.5]))
        known = forces.axial[:, 1, 0] / rod.axial[0] - forces.moment[:, 1, 0] * rod.fibre[0, 0] / rod.bending[0]
        found = sub_intervals(stated).strain[:, 1, 1, 0][(np.arange(60) + 1) * 12 % 720]
        return np.abs(found - known).max() / np.abs(known).max()

    slow, fast = missed(30.0), missed(60.0)
    assert 0.04 < fast < 0.07
    assert 3.7 < fast / slow < 4.6  # 4, and terms of the fourth power


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"effects": "auto"}, "effects"),
        ({"effects": ("coupling",)}, "effects"),
        ({"loads.pull": {"at": "crank.A", "force": (0, 1.0)}}, "loads"),
        ({"damping.material": 1e-4}, "damping"),
        ({"analysis.reduction": "craig-bampton"}, "analysis.reduction"),
        ({"links.coupler.members.AB.offset": 0.001}, "links"),
        ({"sections": {"crank": BAR, "bar": BAR, "tip": {**BAR, "height": "1 mm"}, "strip": TAPER}}, "sections"),
    ],
)
def test_what_the_method_does_not_know_is_refused(changes, place):
    for solve in (sub_intervals, transient):
        with pytest.raises(fm.SceneError, match=f"^{place}: the dissertation's method knows"):
            solve(demo("four_bar", {"effects": ()} | changes))


def test_modes_that_ring_are_refused():
    with pytest.raises(fm.UnresolvedError, match="too fast for these sub_intervals"):
        sub_intervals(demo("four_bar", {"analysis.modes": 8, "analysis.sub_intervals": 48}))
    with pytest.raises(fm.UnresolvedError, match=r"mode 6 .* keep 5 modes, or take 2 times as many"):
        transient(demo("four_bar", {"analysis.modes": 6, "analysis.cycles": 1}))


@pytest.mark.parametrize("solve", [sub_intervals, transient])
def test_the_example_runs(solve, monkeypatch):
    monkeypatch.chdir(ROOT)
    (example,) = doctest.DocTestFinder(recurse=False).find(solve, solve.__name__, globs={"fm": fm})
    found = doctest.DocTestRunner(verbose=False).run(example)
    assert found.attempted > 0
    assert found.failed == 0
