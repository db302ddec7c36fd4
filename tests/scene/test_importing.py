"""Scenes from sketches and from pylinkage: against the same machine by lengths, and pylinkage's own motion."""

import cmath
import json
import math

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene.importing import imported, linked

SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="100mm" viewBox="0 0 200 100">
<g id="ground"><circle id="O" cx="20" cy="80" r="2"/><circle id="C" cx="120" cy="80" r="2"/></g>
<g transform="translate(20,80)"><line id="crank" x1="0.3" y1="0" x2="30" y2="-20"/></g>
<g id="construction"><line x1="0" y1="0" x2="200" y2="100"/></g>
<path d="M 50 60 L 90 45"/><path d="M 90 45 L 130 30"/><polyline points="130,30 120,80.4"/>
<circle id="A" cx="50" cy="60" r="2"/><circle cx="130" cy="30" r="2"/>{more}</svg>"""
BOMB = """<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>""" + SVG


def written(folder, name, text):
    (folder / name).write_text(text)
    return folder / name


@pytest.fixture
def svg(tmp_path):
    pytest.importorskip("svgelements")
    pytest.importorskip("defusedxml")
    return lambda more="", text=SVG: written(tmp_path, "sketch.svg", text.replace("{more}", more))


@pytest.fixture
def dxf(tmp_path):
    """Save the four-bar of the sketch with a triangle as coupler, and more."""
    ezdxf = pytest.importorskip("ezdxf")

    def save(draw=lambda space: None):
        document = ezdxf.new()
        space = document.modelspace()
        for centre in ((20, -80), (120, -80)):
            space.add_circle(centre, 2, dxfattribs={"layer": "ground"})
        for centre in ((50, -60), (130, -30)):
            space.add_circle(centre, 2)
        space.add_line((20.3, -80), (50, -60), dxfattribs={"layer": "crank"})
        space.add_lwpolyline([(50, -60), (80, -10), (130, -30)], close=True)
        space.add_line((130, -30), (120, -80.4))
        space.add_text("a note")
        draw(space)
        document.saveas(tmp_path / "sketch.dxf")
        return tmp_path / "sketch.dxf"

    return save


def test_a_sketch_is_the_linkage_of_its_lengths(svg):
    scene = fm.from_drawing(svg(), unit="mm")
    assert {name: len(link.members) for name, link in scene.links.items()} == {"crank": 1, "link1": 1, "link2": 1}
    assert {name: joint.connect for name, joint in scene.joints.items()} == {
        "O": ("ground.O", "crank.O"),
        "C": ("ground.C", "link2.C"),
        "A": ("crank.A", "link1.A"),
        "B": ("link1.B", "link2.B"),
    }
    lengths = [math.dist(*scene.member_ends(label)) for label in scene.members()]
    assert np.allclose(lengths, [math.hypot(0.03, 0.02), math.hypot(0.08, 0.03), math.hypot(0.01, 0.05)], rtol=1e-5)
    assert scene.ground.points["C"] == pytest.approx((0.12, -0.08))


@pytest.mark.parametrize(
    ("transform", "turn"),
    [
        ("translate(30,10) rotate(20) scale(0.5)", 0.5 * cmath.exp(-1j * math.radians(20))),
        ("matrix(1 0 0 -1 0 100)", 1),
    ],
)
def test_a_sketch_stands_as_its_groups_turn_mirror_and_scale_it(svg, transform, turn):
    head, _, rest = SVG.partition("\n")
    text = f'{head}<g transform="{transform}">{rest.replace("</svg>", "</g></svg>")}'
    plain, turned = fm.from_drawing(svg()), fm.from_drawing(svg(text=text))
    away = []
    for scene in (plain, turned):
        motion = solve_motion(scene, np.zeros(1))
        (o, c), links = (complex(*scene.ground.points[name]) for name in "OC"), list(scene.links)
        pin = scene.links["crank"].points["A"]
        angle = motion.angle[0, links.index("crank")]
        away.append([c - o, complex(*pin) * cmath.exp(1j * angle)])
    mirrored = np.conj(away[0]) if "matrix" in transform else np.array(away[0])
    assert away[1] == pytest.approx(turn * mirrored, abs=1e-6)


def test_a_dxf_has_links_by_layer_and_by_polyline(dxf):
    scene = fm.from_drawing(dxf(), unit="cm")
    assert list(scene.links) == ["crank", "link1", "link2"]
    assert len(scene.links["link1"].members) == 3
    assert scene.links["link1"].points["D"] == pytest.approx((0.8, 0.3))


def test_a_circle_of_a_dxf_that_was_mirrored_has_axes_of_its_own(dxf):
    def draw(space):
        space.add_line((120, -80), (160, -80), dxfattribs={"layer": "arm"})
        space.add_circle((-160, -80), 2, dxfattribs={"layer": "points", "extrusion": (0, 0, -1)})

    arm = fm.from_drawing(dxf(draw)).links["arm"]
    assert len(arm.points) == 2


def test_a_line_through_a_circle_is_one_link_with_a_pin(svg):
    more = '<line id="long" x1="10" y1="30" x2="170" y2="30"/>'
    scene = fm.from_drawing(svg(more))
    assert "long.B" in scene.joints["B"].connect
    assert len(scene.links["long"].members) == 2


def slider_crank(guide='<g id="guide"><line x1="70" y1="85" x2="110" y2="75"/></g>', more=""):
    return (
        SVG[: SVG.index("<g transform")].replace('<circle id="C" cx="120" cy="80" r="2"/>', "")
        + '<line id="crank" x1="20" y1="80" x2="40" y2="80"/><line id="rod" x1="40" y1="80" x2="90" y2="80"/>'
        + f'<circle id="A" cx="40" cy="80" r="2"/><circle id="B" cx="90" cy="80" r="2"/>{guide}{more}</svg>'
    )


def test_a_guide_in_a_sketch_is_a_slider(svg):
    """Against a slider-crank in closed form: the pin is where the guide's line meets the circle of the rod."""
    scene = fm.from_drawing(svg(text=slider_crank()))
    angle = math.atan2(10, 40)
    assert scene.joints["B"].kind == "slot"
    assert scene.joints["B"].angle == pytest.approx(angle)
    motion = solve_motion(scene, theta := np.linspace(0, 2 * np.pi, 9))
    pin = 0.02 * np.stack([np.cos(theta), np.sin(theta)], axis=-1) + (0.02, -0.08)
    along = np.array([math.cos(angle), math.sin(angle)])
    away = pin - (0.09, -0.08)
    off = away @ along
    expected = off + np.sqrt(off**2 - (away**2).sum(axis=-1) + 0.05**2)
    found = motion.of_point(*scene.point("rod.B"))[0]
    assert found == pytest.approx((0.09, -0.08) + expected[:, None] * along, abs=1e-9)


@pytest.mark.parametrize(
    ("guide", "said"),
    [
        ('<line id="guide" x1="0" y1="0" x2="9" y2="0"/>', "meets 0 circles"),
        ('<line id="guide" x1="30" y1="80" x2="100" y2="80"/>', "meets 2 circles"),
        ('<polyline id="guide" points="80,70 90,80 100,95"/>', "is no straight line"),
        ('<line id="guide" x1="20" y1="70" x2="20" y2="85"/>', "of a pin that is on the frame"),
    ],
)
def test_guides_that_say_nothing_are_refused(svg, guide, said):
    with pytest.raises(SceneError, match=f"the guide at .* {said}"):
        fm.from_drawing(svg(text=slider_crank(guide)))


def test_a_slider_that_joins_links_is_refused(svg):
    with pytest.raises(SceneError, match=r"joins 2 links\. A slider that joins links needs a block"):
        fm.from_drawing(svg(text=slider_crank(more='<line id="arm" x1="90" y1="80" x2="90" y2="40"/>')))


def test_what_is_written_is_the_scene(svg, tmp_path):
    text = imported(svg(), "mm")
    scene, again = fm.from_drawing(svg()), fm.load(written(tmp_path, "scene.toml", text))
    assert again.joints == scene.joints
    ends = [[one.member_ends(label) for label in one.members()] for one in (again, scene)]
    assert np.allclose(*ends, rtol=1e-11, atol=1e-14)
    assert text.startswith("# Made from sketch.svg")


@pytest.mark.parametrize(
    ("more", "text", "said"),
    [
        ("", BOMB, "EntitiesForbidden"),
        ("", "<svg", "it is no SVG"),
        ("", "<Xdmf/>", "it is no SVG"),
        ("", SVG.replace('"ground"', '"frame"'), "no circle is on the frame"),
        ('<path d="M 0 0 C 1 1 2 2 3 0"/>', SVG, "it has a curve"),
        ('<ellipse cx="1" cy="1" rx="3" ry="2"/>', SVG, "it has an ellipse"),
        ('<circle cx="5" cy="5" r="1"/>', SVG, "is no end of a link's line"),
        ('<line x1="1e999" y1="0" x2="1" y2="1"/>', SVG, "not a finite number"),
    ],
)
def test_bad_sketches_are_refused(svg, more, text, said):
    with pytest.raises(SceneError, match=said):
        fm.from_drawing(svg(more, text))


@pytest.mark.parametrize("kind", ["arc", "block"])
def test_curves_and_blocks_of_a_dxf_are_refused(dxf, kind):
    def draw(space):
        if kind == "arc":
            space.add_arc((0, 0), 5, 0, 90)
        else:
            space.doc.blocks.new("part")
            space.add_blockref("part", (0, 0))

    with pytest.raises(SceneError, match=r"it has (ARC|INSERT) on layer '0': draw links as straight lines"):
        fm.from_drawing(dxf(draw))


def test_too_large_a_sketch_is_refused(svg, tmp_path):
    file = written(tmp_path, "large.svg", "<svg>" + " " * 20_000_000 + "</svg>")
    with pytest.raises(SceneError, match="at most 20000000 are expected"):
        fm.from_drawing(file)


@pytest.mark.parametrize("which", ["fourbar", "slider_crank"])
def test_pylinkage_moves_as_the_scene_does(which):
    mechanism = pytest.importorskip("pylinkage.mechanism")
    step = 2 * np.pi / 24
    made = (
        mechanism.fourbar(1, 3, 3.5, 4, omega=step, initial_angle=0.3)
        if which == "fourbar"
        else mechanism.slider_crank(1, 3, omega=step, initial_angle=0.3)
    )
    scene = fm.from_pylinkage(made)
    names = [joint.id.replace(".", "_") for joint in made.joints]
    motion = solve_motion(scene, scene.drive_angles(24))
    start = np.array([joint.position for joint in made.joints])
    found = np.stack([_place(scene, motion, name) for name in names], axis=1)
    assert np.allclose(found[0], start, atol=1e-9)
    steps = made.step()
    for position in found[1:]:
        assert np.allclose(position, next(steps), atol=1e-6)


def _place(scene, motion, joint):
    """Places of a joint in the fixed frame, ``(angles, 2)``."""
    link, _, point = next(end for end in scene.joints[joint].connect if not end.startswith("ground")).partition(".")
    i = list(scene.links).index(link)
    x, y = scene.links[link].points[point]
    c, s = np.cos(motion.angle[:, i]), np.sin(motion.angle[:, i])
    return motion.position[:, i] + np.stack([c * x - s * y, s * x + c * y], axis=-1)


FOUR_BAR = {
    "joints": [
        {"id": name, "type": kind, "position": place}
        for name, kind, place in (
            ("O", "ground", [0, 0]),
            ("a.1", "revolute", [1, 0]),
            ("B", "revolute", [2, 2]),
            ("C", "ground", [4, 0]),
        )
    ],
    "links": [
        {"id": "frame", "type": "ground", "joints": ["O", "C"]},
        {"id": "crank", "type": "driver", "joints": ["O", "a.1"], "motor_joint": "O"},
        {"id": "coupler", "type": "link", "joints": ["a.1", "B"]},
        {"id": "rocker", "type": "link", "joints": ["B", "C"]},
    ],
}


def test_a_file_of_pylinkage_is_read(tmp_path):
    scene = fm.Scene.read(linked(FOUR_BAR, "in"))
    assert scene.joints["a_1"].connect == ("crank.a_1", "coupler.a_1")
    assert scene.ground.points["C"] == pytest.approx((4 * 0.0254, 0))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data["links"].pop(1), "one driver link is expected, and there are 0"),
        (lambda data: data["links"][1].update(type="arc_driver"), r"there are 0\. One that swings"),
        (
            lambda data: data["joints"][1].update(position=["a", 0]),
            "no mechanism that pylinkage has written .ValueError",
        ),
        (lambda data: data["joints"].append(3), "no mechanism that pylinkage has written .TypeError"),
        (lambda data: data["joints"][0].update(id="\x1b"), "control character"),
    ],
)
def test_bad_files_of_pylinkage_are_refused(change, said):
    data = json.loads(json.dumps(FOUR_BAR))
    change(data)
    with pytest.raises(SceneError, match=said):
        linked(data, "m")
