"""Exudyn as a peer: what it is given of a scene, its stored curves, and its agreement with the linear theory."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.peers.exudyn_cycle import BeamStates, Integration, steady_cycle
from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.other_programs.beam_linkage import beam_linkage, exported_linkage, with_material_damping
from fenics_mech.scene import load
from fenics_mech.scene.factories import seed_four_bar, slider_crank
from tests.common import DEMOS
from tests.data.seed_exact import SEED_RETARDATION, exact_seed, refined, write_curves

STORED = Path(__file__).parent.parent / "data" / "seed_exact.csv"
MEMBERS = {"coupler": 1, "follower": 2}
ALUMINIUM = {"modulus": "71 GPa", "density": "2714 kg/m^3"}


def given(name):
    """A demo as beams and joints, and the numbers of its beams by label."""
    linkage = beam_linkage(load(DEMOS / f"{name}.toml"))
    return linkage, {beam.label: number for number, beam in enumerate(linkage.beams)}


def meets(linkage, one, other):
    """Tell whether two ends of beams are at one place."""
    (a, at), (b, there) = one, other
    return linkage.beams[a].ends[at] == pytest.approx(linkage.beams[b].ends[there], abs=1e-9)


def test_the_slider_crank_is_two_beams_a_pin_a_support_and_a_guide():
    linkage, number = given("slider_crank")
    assert list(number) == ["crank", "rod"]
    assert [beam.length for beam in linkage.beams] == pytest.approx([0.06, 0.3])
    assert [beam.line_density for beam in linkage.beams] == pytest.approx([2714 * 25e-3 * h for h in (10e-3, 3e-3)])
    assert linkage.beams[1].axial == pytest.approx(71e9 * 25e-3 * 3e-3)
    assert linkage.beams[1].bending == pytest.approx(71e9 * 25e-3 * 3e-3**3 / 12)
    assert linkage.pins == (((0, -1), (1, 0)),)
    assert linkage.welds == ()
    assert linkage.supports == ((0, 0),)
    ((end, normal),) = linkage.guides
    assert end == (1, -1)
    assert normal == pytest.approx([0, 1])
    assert linkage.masses == (((0, -1), pytest.approx(0.03)), ((1, -1), pytest.approx(0.12)))
    assert linkage.joints == ("A", "O", "B")  # of the pin, the support and the guide
    assert (linkage.drive, linkage.speed) == ((0, 0), pytest.approx(60))
    assert linkage.beams[1].ends[1][1] == pytest.approx(0.01)  # on the guide, 10 mm above the crank's bearing


def test_rigid_links_start_with_the_velocities_of_the_mechanism():
    linkage, _ = given("slider_crank")
    crank, rod = linkage.beams
    assert crank.velocities == pytest.approx(np.array([[0, 0], [0, 60 * 0.06]]))
    assert rod.velocities[0] == pytest.approx(crank.velocities[1])
    assert rod.velocities[1][1] == pytest.approx(0, abs=1e-9)  # along the guide
    x, y = rod.ends[1] - rod.ends[0]
    assert rod.velocities[1] - rod.velocities[0] == pytest.approx(rod.turning * np.array([-y, x]))


def test_the_six_bar_has_welded_triangles_and_pins_at_their_corners():
    linkage, number = given("watt")
    assert len(linkage.beams) == 9
    assert [linkage.beams[number[name]].length for name in ("crank", "coupler.AB", "left", "right")] == pytest.approx(
        [0.08, 0.22, 0.24, 0.2]
    )
    assert linkage.beams[number["coupler.AP"]].length == pytest.approx(math.hypot(0.13, 0.11))
    assert len(linkage.welds) == 6  # three corners of two triangles
    triangles = {name.split(".")[0] for pair in linkage.welds for name in (linkage.beams[end[0]].label for end in pair)}
    assert triangles == {"coupler", "rocker"}
    assert all(meets(linkage, *pair) for pair in linkage.welds)
    assert len(linkage.pins) == 5  # A, B, P, Q, R; those of the ground are supports
    assert all(meets(linkage, *pair) for pair in linkage.pins)
    assert [linkage.beams[i].label.split(".")[0] for i, _ in linkage.supports] == ["crank", "rocker"]
    assert linkage.masses == (((number["left"], -1), pytest.approx(0.04)),)


def test_a_ratio_of_damping_becomes_a_retardation_of_the_softest_member():
    scene = with_material_damping(seed_four_bar())
    assert scene.damping.ratio == 0
    assert scene.damping.material == pytest.approx(SEED_RETARDATION, rel=1e-3)
    assert beam_linkage(scene).retardation == scene.damping.material
    assert with_material_damping(scene).damping.material == scene.damping.material


def read(path):
    """Columns of a CSV below a comment."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.genfromtxt(lines, delimiter=",", names=True)


@pytest.fixture(scope="module")
def coarse():
    pytest.importorskip("exudyn")
    return steady_cycle(beam_linkage(exact_seed()), Integration(8, (720,) * 4 + (1440,) * 4), 360)


@pytest.mark.parametrize("member", MEMBERS)
def test_a_coarse_run_gives_the_stored_curves(coarse, member):
    # Its time step alone leaves 3.1e-3 of the coupler's and 0.8e-3 of the follower's peak, and falls as its square;
    # the mesh leaves 0.3e-3 and 0.1e-3. The deflection is smoother.
    stored, i = read(STORED), MEMBERS[member]
    expected = np.stack([stored[f"{member}_{fibre}"] for fibre in ("plus", "minus")], axis=-1)
    assert np.abs(coarse.strain[:, i] - expected).max() < 5e-3 * np.abs(expected).max()
    deflection = stored[f"{member}_deflection"]
    assert np.abs(coarse.deflection[:, i] - deflection).max() < 5e-3 * np.abs(deflection).max()
    # The slowest mode decays at 6 1/s: by exp(-6 * 4 * 0.1945) = 1e-2 in 4 cycles, of what 1 % the coarse ones leave.
    assert coarse.periodicity < 3e-4


def test_a_slow_crank_bends_its_links_as_the_linear_theory_says():
    # At 2 rad/s the axial force is 0.15 % of the Euler load (it grows as the square of the speed, and is 30 N of 80 at
    # 32.3 rad/s), and so is what it changes of the bending. Signs, axes and fibres must then be the program's.
    pytest.importorskip("exudyn")
    scene = seed_four_bar(drive__speed="2 rad/s", analysis__method="quasi-static")
    exact = steady_cycle(exported_linkage(scene), Integration(8, (1440, 1440), 1e-8), 360)
    linear = analyse(scene)
    for i, member in enumerate(scene.members()):
        expected = np.stack([linear.strain_at(member, fibre=fibre) for fibre in "+-"], axis=-1)
        assert np.abs(exact.strain[:, i] - expected).max() < 3e-3 * np.abs(expected).max()
        axial = linear.data["strain_axial"].sel(member=member, s=0.5).to_numpy()
        # Ripple of the start from rest: the step of 2 ms cannot follow axial vibration, and damps it.
        assert np.abs(exact.axial[:, i] - axial).max() < 3e-2 * np.abs(axial).max()


STRIP = {"shape": "rectangle", "width": "25 mm", "height": "6 mm"}
ON_A_SLOPE = {"offset": 0.01, "guide_angle": "30 deg", "masses": (0.03, 0.12), "damping": {"ratio": 0.05}}


@pytest.mark.parametrize(
    "scene",
    [
        seed_four_bar(drive__speed="2 rad/s"),
        slider_crank(crank=0.06, rod=0.3, sections=[STRIP] * 2, material=ALUMINIUM, speed="2 rad/s", **ON_A_SLOPE),
        load(DEMOS / "watt.toml").changed(drive__speed="10 rpm"),
    ],
    ids=["four-bar", "slider-crank", "watt"],
)
def test_forces_of_a_slow_machine_are_those_of_rigid_links(scene):
    # Joints by name, bodies, components and signs. Exudyn starts with links that are not bent: 1 ms steps of the
    # four-bar damp their vibration to 8e-4 of its forces, and those of the others to 4e-5.
    pytest.importorskip("exudyn")
    linkage = exported_linkage(scene)
    exact = steady_cycle(linkage, Integration(4, (1440, 1440), 1e-8), 120, forces=True)
    rigid = analyse(scene.changed(effects=(), analysis={"method": "quasi-static", "sub_intervals": 120})).data
    forces = rigid["joint_force"].sel(joint=list(linkage.joints)).transpose("theta", "joint", "component").to_numpy()
    assert np.abs(exact.force - forces).max() < 2e-3 * np.abs(forces).max()
    assert np.abs(forces).max(axis=(0, 2)).min() > 0.02 * np.abs(forces).max()  # so that each joint is compared
    torque = rigid["input_torque"].to_numpy()
    assert np.abs(exact.torque - torque).max() < 2e-3 * np.abs(torque).max()


def test_places_and_forces_agree_with_large_rotations():
    # The demo with a modulus of 0.3: its axes turn by 0.023 rad, and a cycle leaves 0.57 of a disturbance. What
    # differs is the steps and elements of both programs; refined, they agree to 5e-5.
    pytest.importorskip("exudyn")
    scene = load(DEMOS / "slider_crank.toml").changed(
        materials__aluminium__modulus="21.3 GPa", effects=("coupling", "large-rotations"), mesh__elements=6,
        analysis={"sub_intervals": 120, "stages": 3, "stations": 3, "solver": "collocation", "stability": False},
    )  # fmt: skip
    scene = with_material_damping(scene)
    linkage = beam_linkage(scene)
    exact = steady_cycle(linkage, Integration(6, (480,) * 8 + (1440,) * 8), 120, forces=True)
    found, motion = analyse(scene).data, solve_motion(scene, scene.drive_angles(120))
    for i, (label, (link, _)) in enumerate(scene.members().items()):
        first, last = (motion.of_point(link, end)[0] for end in scene.member_ends(label))
        place = np.stack([first, (first + last) / 2, last], axis=1)
        deflection = found["deflection"].sel(member=label).transpose("theta", "s", "component").to_numpy()
        assert np.abs(exact.place[:, i] - place - deflection).max() < 1e-3 * np.abs(deflection).max()
    forces = found["joint_force"].sel(joint=list(linkage.joints)).transpose("theta", "joint", "component").to_numpy()
    assert np.abs(exact.force - forces).max() < 5e-4 * np.abs(forces).max()
    torque = found["input_torque"].to_numpy()
    assert np.abs(exact.torque - torque).max() < 5e-4 * np.abs(torque).max()


@pytest.mark.parametrize(("name", "bound"), [("slider_crank", 1e-2), ("watt", 1e-2)])
def test_both_programs_agree_on_guides_and_welds(name, bound):
    # Refined, they agree to 0.003 % and 0.006 %; this leaves Exudyn's two elements, its steps, and the start.
    pytest.importorskip("exudyn")
    scene = load(DEMOS / f"{name}.toml").changed(
        effects=("coupling", "large-rotations"), mesh__elements=2, analysis__sub_intervals=60,
        analysis__solver="collocation", analysis__stability=False,
    )  # fmt: skip
    scene = with_material_damping(scene)
    exact = steady_cycle(beam_linkage(scene), Integration(4, (240,) * 3 + (480,) * 2), 60)
    found = analyse(scene)
    strain = np.stack([found.strain_at(member) for member in scene.members()], axis=1)
    largest = np.abs(strain).max(axis=0)
    assert (np.abs(exact.strain[..., 0] - strain).max(axis=0) < bound * np.maximum(largest, largest.max() / 10)).all()


def cycle(axial, bending):
    """A cycle of these strains, with the axial ones as deflections of beams of unit length."""
    along = np.broadcast_to([0, 0.5, 1], (*axial.shape, 3))
    place = np.stack([along, axial[..., None] * np.array([0, 1, 0])], axis=-1)
    return BeamStates(axial, bending, place, 0.0, 0.0)


def test_curves_are_written_and_read_back(tmp_path):
    axial, bending = np.array([[0, 1.0, 2.0], [0, 3.0, 4.0]]) * 1e-5, np.array([[-1.0, 1.0], [-2.0, 2.0]]) * 1e-4
    write_curves(tmp_path / "curves.csv", cycle(axial, np.stack([bending] * 3, axis=1)), ["first", "second"])
    found = read(tmp_path / "curves.csv")
    assert found["theta_deg"].tolist() == [0, 180]
    assert found["follower_plus"] == pytest.approx([-8e-5, -16e-5])
    assert found["coupler_minus"] == pytest.approx([11e-5, 23e-5])


def test_extrapolation_removes_an_error_that_falls_as_the_square_of_the_step():
    def with_error(error):
        one = np.full((1, 1), 1 + error)
        return cycle(one, np.stack([one, -one], axis=-1))

    found = refined(with_error(4e-3), with_error(1e-3))
    assert found.axial == pytest.approx(1)
    assert found.deflection == pytest.approx(1)
    assert found.strain.ravel() == pytest.approx([2, 0])


ROCKING = {"kind": "harmonics", "sine": (0.5,)}


def loaded(**load):
    return seed_four_bar(loads={"press": {"at": "follower.B", **load}})


@pytest.mark.parametrize(
    ("scene", "place"),
    [
        (lambda: loaded(force=(5, 0)), "loads"),
        (lambda: seed_four_bar(gravity=(0, -9.81)), "gravity"),
        (lambda: seed_four_bar(masses__A__inertia=1e-6), "masses.A"),
        (lambda: seed_four_bar(drive={"joint": "O", "law": ROCKING, "period": 1}), "drive"),
        (
            lambda: seed_four_bar(links__coupler={"points": {"A": (0, 0), "B": ("11 in", 0)}, "rigid": {"mass": 0.1}}),
            "links.coupler",
        ),
        (lambda: load(DEMOS / "quick_return.toml"), "joints"),
        (lambda: load(DEMOS / "pulsating_column.toml"), ""),
    ],
)
def test_what_other_programs_cannot_be_given_is_refused(scene, place):
    with pytest.raises(SceneError, match="other programs") as refusal:
        beam_linkage(scene())
    assert refusal.value.place.startswith(place)


def test_damping_by_the_surroundings_is_refused():
    with pytest.raises(SceneError, match="other programs"):
        with_material_damping(seed_four_bar(damping__external=1.0))


def test_a_missing_exudyn_is_said_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    with pytest.raises(MechanismError, match="not installed"):
        steady_cycle(beam_linkage(seed_four_bar()), Integration(2, (120,)), 120)


@pytest.mark.parametrize("bad", [Integration(3, (720,)), Integration(0, (720,)), Integration(4, (720, 500))])
def test_a_bad_discretization_is_refused(bad):
    with pytest.raises(ValueError, match="elements"):
        steady_cycle(beam_linkage(seed_four_bar()), bad, 360)
