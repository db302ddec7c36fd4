"""Animations: their frames, their geometry, and what happens where nothing can be rendered."""

import os
import subprocess
from itertools import pairwise

import imageio.v2 as imageio
import numpy as np
import pytest
from PIL import Image

from fenics_mech import analyse, animate_modes, modes
from fenics_mech.errors import ResultError, ViewError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.recovery import Result
from fenics_mech.scene import parse
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views import rendering
from fenics_mech.views.animation import animate
from fenics_mech.views.drawn_parts import DRAWN, at_angles, load_names
from fenics_mech.views.frames import cycle, default_magnification, frames_at, moment_of_peak, peak_of
from fenics_mech.views.judgements import headline
from fenics_mech.views.reading import Reading
from fenics_mech.views.stage import Stage, ribbon
from fenics_mech.views.words import short
from tests.common import response_of
from tests.demos.machines import piston
from tests.studies.test_rigid_linkages import FOUR_BAR

SMALL = (240, 180)


def pictures_of(path):
    """All pictures of a GIF, as they are shown."""
    image = Image.open(path)
    for index in range(image.n_frames):
        image.seek(index)
        yield np.asarray(image.convert("RGB")).astype(int)


@pytest.mark.slow
def test_gif_has_the_frames_asked_for_and_they_differ(result, tmp_path):
    made = []
    path = animate(result, tmp_path / "m.gif", frames=6, fps=20, size=SMALL, progress=lambda *n: made.append(n))
    pictures = list(pictures_of(path))
    assert len(pictures) == 6
    assert pictures[0].shape == (180, 240, 3)
    assert Image.open(path).info["duration"] == 50
    for first, second in pairwise(pictures):
        assert (np.abs(first - second).max(axis=-1) > 60).mean() > 0.005
    assert made == [(i, 6) for i in range(6)]
    assert [p.name for p in tmp_path.iterdir()] == ["m.gif"]


def test_mp4_has_the_frames_asked_for_even_at_an_odd_size(result, tmp_path):
    path = animate(result, tmp_path / "m.MP4", frames=5, size=(241, 181))
    pictures = [np.asarray(picture) for picture in imageio.get_reader(path)]
    assert len(pictures) == 5
    assert pictures[0].shape == (182, 242, 3)


def test_png_is_coloured_and_shows_the_frame_of_the_peak_of_the_run(result, tmp_path):
    picture = np.asarray(Image.open(animate(result, tmp_path / "m.png", size=SMALL))).astype(int)
    assert picture.shape == (180, 240, 3)
    left = picture[:, : int(0.8 * 240)]  # without the colour bar
    blue, red = ((left[..., i] - left[..., j] > 60).sum() for i, j in ((2, 0), (0, 2)))
    assert min(blue, red) > 40  # members bend: one side is pressed, and the other pulled
    reading = Reading(result)
    peak = reading.peaks[reading.ranked[0]]
    assert moment_of_peak(result) == reading.theta[peak.k]
    found = peak_of(result)
    assert headline(reading)[1].startswith(found.words.replace(f", {reading.side(peak)}", ""))
    assert short(abs(found.value)) in headline(reading)[0]


def test_frames_at_the_angles_of_the_result_are_the_result(result):
    theta = result.data["theta"].to_numpy()
    frames = frames_at(result, theta, 7.0)
    motion = solve_motion(result.scene, theta)
    assert frames.sides[..., 0] == pytest.approx(1e-6 * result.data["stress"].sel(fibre="+").to_numpy())
    assert frames.sides[..., 1] == pytest.approx(1e-6 * result.data["stress"].sel(fibre="-").to_numpy())
    joint_b = motion.of_point("coupler", result.scene.links["coupler"].points["B"])[0]
    assert frames.rigid[:, 1, 1] == pytest.approx(joint_b)
    moved = result.data["deflection"].sel(member="coupler", s=1.0).to_numpy()
    assert frames.path[:, 1, -1] == pytest.approx(joint_b + 7 * moved)
    assert frames.pins[:, 2] == pytest.approx(frames.path[:, 2, -1])  # B is on the follower's end too
    assert frames.pins[:, 3] == pytest.approx(np.tile([0.254, 0], (24, 1)))


def test_interpolation_is_periodic():
    theta = -np.arange(360) * 2 * np.pi / 360  # a drive that turns back
    wanted = np.array([0.0, 6.28, -0.003, 20.0])
    found = at_angles(theta, np.sin(theta)[:, None], wanted)
    assert found[:, 0] == pytest.approx(np.sin(wanted), abs=1e-4)


def test_default_magnification_draws_about_eight_percent(result):
    factor = default_magnification(result)
    size = np.linalg.norm(np.ptp(frames_at(result, cycle(result, 60), 0.0).rigid.reshape(-1, 2), axis=0))
    share = factor * np.linalg.norm(result.data["deflection"], axis=-1).max() / size
    assert 0.05 < share < 0.12
    stiff = Result(result.data.assign(deflection=0 * result.data["deflection"], strain=0 * result.data["strain"]))
    assert default_magnification(stiff) == 1
    assert peak_of(stiff, "strain").limit == 1.0


def test_colour_bar_holds_the_largest_strain_of_the_motion_and_a_ring_is_there(result):
    spike = result.data["strain"] * 0 + 230e-6
    even = Result(result.data.assign(strain=spike, stress=(result.data["stress"].dims, 71e9 * spike.to_numpy())))
    assert (peak_of(even, "strain").limit, peak_of(even).limit) == (250, 20)
    spike[7, 2, 5, 1] = -1.1e-3
    peaked = Result(even.data.assign(strain=spike, stress=71e9 * spike))
    assert peak_of(peaked, "strain").limit == 1200
    frames = frames_at(peaked, cycle(peaked, 6), 3.0, "strain")
    assert frames.peak_value == pytest.approx(-1100)
    assert np.array_equal(frames.peak, frames.path[:, 2, 5])


def test_colours_are_in_the_units_of_the_answer(result):
    told = result.told_in(["%", "psi"])
    for quantity, size in (("strain", 1e-4), ("stress", 1e6 / 6894.757)):
        other, usual = (frames_at(one, cycle(one, 3), 1.0, quantity) for one in (told, result))
        assert other.sides == pytest.approx(size * usual.sides)
        assert other.peak_value == pytest.approx(size * usual.peak_value)


def test_names_and_ring_are_drawn(result, tmp_path):
    plain, named = (
        np.asarray(Image.open(animate(result, tmp_path / f"{names}.png", names=names))).astype(int)
        for names in (False, True)
    )
    changed = np.abs(plain - named).max(axis=-1) > 60
    assert 100 < changed.sum() < 5000
    orange = (np.abs(plain - [230, 159, 0]).max(axis=-1) < 12)[:, : int(0.8 * plain.shape[1])]
    assert 30 < orange.sum() < 3000


def test_ribbon_has_its_width_on_both_sides():
    edges = ribbon(np.array([[[0, 0], [1, 0], [2, 0]]], dtype=float), 0.1)
    assert edges[0, :, 0] == pytest.approx(np.array([[0, 0.1], [1, 0.1], [2, 0.1]]))
    assert edges[0, :, 1, 1] == pytest.approx(-0.1)


@pytest.mark.parametrize("name", ["m.avi", "m", "m.jpeg"])
def test_unknown_endings_are_refused(result, tmp_path, name):
    with pytest.raises(ViewError, match=r"\.gif, \.mp4, \.png"):
        animate(result, tmp_path / name)


@pytest.mark.parametrize("option", [{"magnify": float("nan")}, {"magnify": -1.0}, {"frames": 0}, {"fps": 0}])
def test_options_that_make_no_picture_are_refused(result, tmp_path, option):
    with pytest.raises(ViewError, match=next(iter(option))):
        animate(result, tmp_path / "m.gif", **option)


def test_a_failure_midway_leaves_no_file(result, tmp_path):
    def fail(frame, frames):
        if frame == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate(result, tmp_path / "m.gif", frames=4, size=SMALL, progress=fail)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def fresh_probe():
    """Forget what was found about rendering, before and after."""
    rendering.can_render.cache_clear()
    yield
    rendering.can_render.cache_clear()


def test_a_machine_that_cannot_render_gets_an_error_and_not_a_crash(result, tmp_path, monkeypatch, fresh_probe):
    monkeypatch.delenv(rendering.VARIABLE, raising=False)
    monkeypatch.setattr(rendering, "PROBE", "import os; os.abort()")
    with pytest.raises(ViewError, match=r"cannot render.*libegl1"):
        animate(result, tmp_path / "m.png")
    assert rendering.VARIABLE not in os.environ


def test_the_users_choice_of_window_is_kept(monkeypatch, fresh_probe):
    asked = []

    def run(command, env, **rest):
        asked.append(env[rendering.VARIABLE])
        return subprocess.CompletedProcess(command, env[rendering.VARIABLE] != "vtkOSOpenGLRenderWindow")

    monkeypatch.setattr(rendering.subprocess, "run", run)
    monkeypatch.setenv(rendering.VARIABLE, "vtkXOpenGLRenderWindow")
    with pytest.raises(ViewError, match="vtkXOpenGLRenderWindow"):
        rendering.prepare_rendering()
    assert asked == ["vtkXOpenGLRenderWindow"]
    monkeypatch.delenv(rendering.VARIABLE)
    rendering.prepare_rendering()
    assert os.environ[rendering.VARIABLE] == "vtkOSOpenGLRenderWindow"  # the second that is tried
    rendering.prepare_rendering()
    assert asked == ["vtkXOpenGLRenderWindow", "vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"]  # each asked once


def test_a_rigid_block_goes_where_its_pin_goes():
    found = analyse(piston().changed(analysis={"method": "quasi-static", "sub_intervals": 24}))
    pins, undeformed = (frames_at(found, cycle(found, 5), magnify).pins for magnify in (1000.0, 0.0))
    moved = pins - undeformed
    assert np.abs(moved[:, 2]).max() > 1e-3  # the pin B
    assert moved[:, 3] == pytest.approx(moved[:, 2])  # the guide's place G


@pytest.fixture(scope="module")
def acted_on():
    """The seed with a traced point, a mass, and a push that acts over half of the turn, its links bent and slow."""
    parts = {
        "points": {"P": {"at": "coupler@0.5", "offset": (0, 0.06)}},
        "masses": {"heavy": {"at": "coupler.B", "mass": 0.04}, "light": {"at": "crank.A", "mass": 0.01}},
        "loads": {"push": {"at": "follower.B", "force": (-3, 4), "factor": {"kind": "pulse", **HALF}}},
    }
    return analyse(seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24}, effects=[]).changed(parts))


HALF = {"start": "90 deg", "end": "270 deg", "ramp": "10 deg"}


def test_points_masses_and_loads_move_with_the_bent_links(acted_on):
    data, at = acted_on.data, cycle(acted_on, 24)
    frames = frames_at(acted_on, at, 5.0)
    rigid, bent = (data[name].sel(point="P").to_numpy() for name in ("point_position", "point_position_bent"))
    assert frames.traced[:, 0] == pytest.approx(rigid + 5 * (bent - rigid))
    assert frames.masses[:, 0] == pytest.approx(frames.pins[:, 2])  # at B
    assert frames.mass_sizes == pytest.approx([1, 0.5])
    assert frames.loads[:, 0, 0] == pytest.approx(frames.pins[:, 2])
    assert frames.loads[12, 0, 1] == pytest.approx([-0.6, 0.8])  # at 180 degrees, and none at 0
    assert not frames.loads[0, 0, 1].any()
    assert len(frames.trails) == 3  # of A, B and P: O and C do not move
    assert frames.trails[-1][:24] == pytest.approx(bent)  # not magnified
    assert frames.trails[-1][24] == pytest.approx(bent[0])  # it closes
    sections = [acted_on.scene.sections[member.section] for _, member in acted_on.scene.members().values()]
    assert frames.half_width[:, 0] == pytest.approx([section.fibre for section in sections])


def test_loads_along_members_are_arrows_on_the_bent_line(acted_on):
    """A follower's normal is its chord turned by 90 degrees; the line load falls from 50 N/m to none."""
    loads = {
        "wind": {"member": "follower", "line": (0, 50), "line_end": (0, 0), "axes": "member"},
        "weight": {"member": "coupler", "line": (0, -25)},
        "hook": {"at": "coupler@0.3", "force": (0, -8)},
    }
    found = analyse(acted_on.scene.changed(loads=loads))
    frames = frames_at(found, cycle(found, 6), 40.0)
    hook, wind, weight = frames.loads[:, 0], frames.loads[:, 1:8], frames.loads[:, 8:]
    assert hook[:, 1] == pytest.approx(np.broadcast_to([0, -1], (6, 2)))
    assert weight[:, :, 1] == pytest.approx(np.broadcast_to([0, -0.5], (6, 7, 2)))
    pin = [[*found.scene.joints].index(name) for name in "CB"]
    chord = frames.rigid[:, 2, 1] - frames.rigid[:, 2, 0]
    normal = np.stack([-chord[:, 1], chord[:, 0]], axis=-1) / np.linalg.norm(chord, axis=-1)[:, None]
    assert wind[:, :, 1] == pytest.approx(np.linspace(1, 0, 7)[:, None] * normal[:, None])
    assert {tuple(np.round(wind[0, i, 0], 9)) for i in (0, 6)} == {tuple(np.round(frames.pins[0, i], 9)) for i in pin}
    stations = found.data["s"].to_numpy()
    middle = np.array([np.interp(0.3, stations, frames.path[2, 1, :, c]) for c in range(2)])
    assert hook[2, 0] == pytest.approx(middle)


def test_a_motion_in_time_is_shown_at_its_times():
    found = analyse(parse(FOUR_BAR.replace('"periodic"', '"transient"\ncycles = 2')))
    at = cycle(found, 7)
    assert at == pytest.approx(np.linspace(0, 4 * np.pi / 30, 7))
    frames = frames_at(found, at, 1.0)
    assert frames.labels[0] == "time 0 s"
    angle = 30 * at
    assert frames.pins[:, 1] == pytest.approx(0.108 * np.stack([np.cos(angle), np.sin(angle)], axis=1), abs=1e-9)


def test_rigid_links_are_drawn(tmp_path):
    found = analyse(parse(FOUR_BAR))
    force = np.linalg.norm(found.data["joint_force"].transpose("theta", "joint", "component"), axis=-1)
    assert moment_of_peak(found) == found.data["theta"].to_numpy()[force.max(axis=1).argmax()]
    picture = np.asarray(Image.open(animate(found, tmp_path / "m.png", size=SMALL))).astype(int)
    assert (np.abs(picture - 160).max(axis=-1) < 12).sum() > 100  # grey bars


def test_true_widths_and_loads_are_seen(acted_on, tmp_path):
    wide, true = (
        np.asarray(Image.open(animate(acted_on, tmp_path / f"{width}.png", true_width=width))).astype(int)
        for width in (False, True)
    )
    assert (np.abs(wide - true).max(axis=-1) > 40).sum() > 500  # strips of 2 mm are thinner
    pictures = list(pictures_of(animate(acted_on, tmp_path / "m.gif", frames=4)))
    green = [(np.abs(one - [0, 158, 115]).max(axis=-1) < 12).sum() for one in pictures]
    assert green[2] > 50  # at 180 degrees
    assert green[0] == 0
    assert (pictures[3][5, 5] == 255).all()


def test_modes_swing(result, tmp_path):
    found = modes(result.scene.changed({"analysis.sub_intervals": 4}))
    pictures = list(pictures_of(animate_modes(found, tmp_path / "modes.gif", frames=4)))
    assert len(pictures) == 4
    assert np.abs(pictures[1] - pictures[3]).max() == 0  # at rest twice in a period
    assert (np.abs(pictures[0] - pictures[2]).max(axis=-1) > 60).sum() > 500  # on both sides
    with pytest.raises(ViewError, match=r"are a \.gif"):
        animate_modes(found, tmp_path / "modes.mp4")


def test_one_position_is_drawn_and_a_result_that_lacks_points_is_one_message(result, tmp_path):
    still = response_of(
        seed_four_bar(analysis={"method": "static", "position": 1.0}, gravity=(0, -9.81), effects=["gravity"])
    )
    frames = frames_at(still, cycle(still, 3), 1.0)
    assert frames.labels == ("drive angle 57.3°",) * 3
    assert len(frames.trails) == 0
    assert animate(still, tmp_path / "m.png", size=SMALL).exists()
    with pytest.raises(ResultError, match="lacks what is shown"):
        animate(Result(result.data.drop_vars("point_position")), tmp_path / "m.gif", size=SMALL)


def test_loads_and_points_have_names_beside_joints(acted_on, monkeypatch):
    """A load's name stands where its arrow begins, one of a load along a member at the middle arrow."""
    wind = {"member": "follower", "line": (0, 50), "axes": "member"}
    found = analyse(acted_on.scene.changed({"loads.wind": wind}))
    names = (*found.scene.joints, *found.scene.points, *load_names(found.scene))
    assert names == ("O", "A", "B", "C", "P", "push", "", "", "", "wind", "", "", "")
    frames = frames_at(found, cycle(found, 2), 1.0)
    places = len(frames.pins[0]) + len(frames.traced[0]) + len(frames.loads[0])
    assert places == len(names)
    stage = Stage(frames, (np.zeros((0, 2)), np.zeros((0, 2, 2))), SMALL, 1.0, "%", ("", ""), names, False)
    stage.picture(1)
    at = np.array(stage.names[5].position) * stage.pixel * SMALL + stage.corner - DRAWN.name * stage.extent
    place, force = frames.loads[1, 0]
    stage.close()
    assert at == pytest.approx(place - DRAWN.load * stage.extent * force)
    assert np.linalg.norm(force) == pytest.approx(1)


def test_a_ram_has_its_guide_on_the_cylinder():
    """The rod's end lies on it: the guide turns with the cylinder, and is as long as the stroke."""
    found = response_of(parse(RAM))
    frames = frames_at(found, cycle(found, 9), 0.0)
    assert frames.guides.shape == (9, 1, 2, 2)
    first, second = np.moveaxis(frames.guides[:, 0], 1, 0)
    assert np.linalg.norm(second - first, axis=1) == pytest.approx(0.2)
    arm, along = frames.pins[:, 3] - first, (second - first) / 0.2  # of the joint S
    assert arm[:, 0] * along[:, 1] - arm[:, 1] * along[:, 0] == pytest.approx(0, abs=1e-9)
    stroke = np.sum(arm * along, axis=1)
    assert stroke.min() == pytest.approx(0.05, abs=1e-6)
    assert stroke.max() == pytest.approx(0.2, abs=1e-6)


RAM = """
name = "boom with a ram"
effects = []
[materials.steel]
modulus = "207 GPa"
density = "7800 kg/m^3"
[sections]
bar = { shape = "rectangle", width = "30 mm", height = "30 mm" }
[ground]
points = { O = [0, 0], C = ["0.3 m", "-0.3 m"] }
[links.boom]
points = { O = [0, 0], A = ["0.8 m", 0], T = ["1.4 m", 0] }
members.OA = { ends = ["O", "A"], section = "bar", material = "steel" }
members.AT = { ends = ["A", "T"], section = "bar", material = "steel" }
angle = "20 deg"
[links.cylinder]
points = { C = [0, 0], E = ["0.5 m", 0] }
members.CE = { ends = ["C", "E"], section = "bar", material = "steel" }
angle = "45 deg"
[links.rod]
points = { D = [0, 0], A = ["0.5 m", 0] }
members.DA = { ends = ["D", "A"], section = "bar", material = "steel" }
angle = "45 deg"
[joints]
O.connect = ["ground.O", "boom.O"]
C.connect = ["ground.C", "cylinder.C"]
A.connect = ["boom.A", "rod.A"]
S = { kind = "prismatic", connect = ["cylinder.E", "rod.D"] }
[drive]
joint = "S"
period = "3 s"
law = { kind = "rest-to-rest", start = "0.05 m", end = "0.2 m", out = [0.1, 0.4], back = [0.6, 0.9] }
[analysis]
method = "quasi-static"
sub_intervals = 60
"""
