"""The drawing of a model shows every part of it, with its name, at its place and in its sense."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

import fenics_mech as fm
from fenics_mech.errors import MechanismError
from fenics_mech.machine.linkage import start_motion
from fenics_mech.scene import parse
from fenics_mech.views.drawn_parts import arc, coil, guide_strokes
from fenics_mech.views.figures import figure_in, new_axes
from fenics_mech.views.model_plots import LOOKS, TURNING, Labels, Skeleton, plot_scene
from tests.common import DEMOS, ROOT
from tests.documents import blocks

ACTING = {
    "gravity": (0, -9.81),
    "loads": {
        "push": {"at": "coupler@0.5", "force": (20.0, 0.0)},
        "twist": {"at": "coupler.B", "moment": -2.0},
        "wind": {"member": "follower", "line": (0.0, 4.0)},
    },
    "impulses": {"hit": {"at": "follower.B", "angle": 1.0, "impulse": (-1.0, 0.0)}},
    "springs": {
        "coiled": {"between": ("ground.C", "coupler.A"), "stiffness": 2000.0},
        "torsion": {"joint": "C", "stiffness": 3.0},
    },
    "dampers": {"pot": {"between": ("ground.O", "follower.B"), "damping": 5.0}, "rub": {"joint": "A", "damping": 0.1}},
    "points": {"traced": {"at": "coupler@0.5", "offset": (0.0, 0.06)}},
}


@pytest.fixture(scope="module")
def scene():
    return fm.load(DEMOS / "four_bar.toml").changed(ACTING)


def words(axes):
    return {word for text in axes.texts for word in text.get_text().split()}


def lines_of(axes, kind):
    """Points (mm) of the lines in the colour of a kind."""
    colour = to_hex(LOOKS[kind]["color"])
    lines = [line.get_xydata() for line in axes.get_lines() if to_hex(line.get_color()) == colour]
    return [line for line in lines if len(line) > 1]


def test_every_part_has_its_name_and_every_kind_is_explained(scene):
    axes = plot_scene(scene)
    parts = [*scene.links, *scene.joints, *scene.masses, *scene.loads, *scene.impulses, *scene.springs, *scene.dampers]
    assert {*parts, *scene.points} <= words(axes)
    legend = {text.get_text() for text in axes.get_legend().get_texts()}
    assert legend == {"revolute joint", *LOOKS} - {"freedom"}


def test_members_and_pins_are_where_the_linkage_starts(scene):
    axes, motion = plot_scene(scene), start_motion(scene)
    expected = [
        [motion.of_point(link, scene.links[link].points[end])[0][0] * 1e3 for end in member.ends]
        for link, member in scene.members().values()
    ]
    drawn = [segment for part in axes.collections for segment in getattr(part, "get_segments", list)()]
    for ends in expected:
        assert any(np.allclose(segment, ends) for segment in drawn if len(segment) == 2)


def test_an_arrow_ends_where_its_force_acts_and_the_drive_turns_in_its_sense(scene):
    length = scene.links["coupler"].points["B"][0]
    middle = 1e3 * start_motion(scene).of_point("coupler", (length / 2, 0.0))[0][0]
    arrows = [line for line in lines_of(plot_scene(scene), "load") if len(line) == 2]
    assert any(np.allclose(line[1], middle) and line[0][0] < line[1][0] for line in arrows)
    for speed in (30.0, -30.0):
        changed = scene.changed({"drive.speed": speed})
        (turning,) = lines_of(plot_scene(changed), "drive")
        (x, y), (dx, dy) = turning[:-1].T, np.diff(turning, axis=0).T
        assert np.all((x * dy - y * dx) * speed > 0)  # about O, in the origin
        assert np.hypot(x, y) == pytest.approx(1e3 * TURNING * Skeleton.at_start(changed).extent)


@pytest.mark.parametrize("path", sorted(DEMOS.rglob("*.toml")), ids=lambda path: path.stem)
def test_names_of_joints_and_links_of_the_demos_stand_apart(path):
    if "plugin" in path.parts:
        pytest.skip("needs the plugin")
    scene, axes = fm.load(path), new_axes(5.0)
    plot_scene(scene, axes)
    figure_in(axes).canvas.draw()
    names = {*scene.joints, *scene.links}
    named = {text: name for text in axes.texts if (name := text.get_text().partition(".")[0]) in names}
    boxes = [text.get_window_extent().padded(-3) for text in named]  # in space each member of a link has one: leg.upper
    assert {*named.values()} == names
    assert not [1 for i, box in enumerate(boxes) for other in boxes[:i] if box.overlaps(other)]


def test_a_name_leaves_lines_and_other_names_free():
    axes = new_axes()
    axes.set_xlim(-1, 1)
    axes.set_ylim(-1, 1)
    labels = Labels(axes, np.array([[[0, 0], [1, 0]], [[0, 0], [0, 1]]], dtype=float))
    for name in ("first", "second", "third"):
        labels.add(name, np.zeros((1, 2)), 5, {"fontsize": 9})
    assert all((np.abs(labels.dots - middle) >= half).any(axis=1).all() for middle, half in labels.boxes)
    for i, (middle, half) in enumerate(labels.boxes):
        assert all((np.abs(middle - other[0]) >= half + other[1] - 1e-12).any() for other in labels.boxes[:i])


def test_symbols_have_their_ends_and_sizes():
    ends = np.array([[1.0, 0.0], [1.0, 2.0]])
    spring = coil(ends, 0.1)
    assert spring[[0, -1]] == pytest.approx(ends)
    assert np.abs(spring[:, 0] - 1).max() == pytest.approx(0.1)
    assert np.linalg.norm(arc(ends[0], 0.5, 0, 2) - ends[0], axis=1) == pytest.approx(0.5)
    strokes = guide_strokes(np.array([[0.0, 0.0], [1.0, 0.0]]), 1.0)
    assert (strokes[:, :, 1] < 0).all()  # under a slider that moves to the right


def test_a_linkage_that_cannot_be_assembled_is_an_error(scene):
    with pytest.raises(MechanismError, match="assembled"):
        plot_scene(scene.changed({"links.crank.points.A": (5.0, 0.0), "loads": {}, "springs": {}}))


def test_a_guide_on_a_link_that_moves_is_drawn_across_its_pin():
    """The slot of a yoke stands across it; guides on the ground have their own look."""
    (yoke,) = (block.text for block in blocks(ROOT / "README.md") if "Scotch yoke" in block.text)
    skeleton = Skeleton.at_start(parse(yoke))
    (rail,) = skeleton.rails
    pin = skeleton.pins[list(skeleton.scene.joints).index("A")]
    assert rail[:, 0] == pytest.approx(pin[0], abs=1e-12)
    assert rail[0, 1] < pin[1] < rail[1, 1]
    assert len(Skeleton.at_start(fm.load(DEMOS / "quick_return.toml")).rails) == 0  # along a member
