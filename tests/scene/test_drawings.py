"""Mechanisms drawn in gmsh: the same numbers as from lengths, whatever the file format; bad drawings are refused."""

from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from fenics_mech import analyse, load
from fenics_mech.beams.export import plane_mesh, write_mesh
from fenics_mech.beams.mesh import mesh_scene
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene, parse, schema
from fenics_mech.scene.drawing import completed
from tests.common import DEMOS, modes_of

MESHES = Path(__file__).parents[2] / "meshes"
PAIRS = {
    "four_bar": "four_bar",
    "four_bar_graded": "four_bar",
    "slider_crank": "slider_crank",
    "six_bar": "stephenson",
}
QUICK = {"analysis__allow_coarse": True, "effects": (), "analysis__sub_intervals": 24, "analysis__allow_ringing": True}


def difference(found, expected):
    """Largest difference over the largest value."""
    return float(np.abs(found.to_numpy() - expected.to_numpy()).max() / np.abs(expected.to_numpy()).max())


@pytest.mark.parametrize("drawn", PAIRS)
def test_drawing_gives_the_strains_of_the_lengths(drawn):
    # quasi-static strains do not depend on the mesh, and the graded mesh is another one
    scenes = load(MESHES / f"{drawn}.toml"), load(DEMOS / f"{PAIRS[drawn]}.toml")
    found, expected = (analyse(scene.changed(analysis__method="quasi-static", **QUICK)).data for scene in scenes)
    assert found["member"].to_numpy().tolist() == expected["member"].to_numpy().tolist()
    assert set(found["joint"].to_numpy()) == set(expected["joint"].to_numpy())
    # the bow of an element and its stretch are those of the mean axial force: deflections within know the mesh to 1e-6
    for name, most in (("strain", 1e-9), ("deflection", 1e-6), ("input_torque", 1e-9)):
        assert difference(found[name], expected[name]) < most


@pytest.mark.parametrize("drawn", ["four_bar", "slider_crank", "six_bar"])
def test_same_elements_give_the_same_periodic_strains_and_frequencies(drawn):
    scenes = load(MESHES / f"{drawn}.toml"), load(DEMOS / f"{PAIRS[drawn]}.toml")
    found, expected = (analyse(scene.changed(**QUICK)).data for scene in scenes)
    assert difference(found["frequency"], expected["frequency"]) < 1e-9
    assert difference(found["strain"], expected["strain"]) < 1e-9


def test_drawn_position_is_that_of_drive_angle_0():
    scene = load(MESHES / "six_bar.toml")
    motion = solve_motion(scene, np.zeros(1))
    assert np.abs(motion.angle).max() < 1e-12
    with_angles = solve_motion(load(DEMOS / "stephenson.toml"), np.zeros(1))
    expected = with_angles.of_point("bar", (0.3, 0.0))[0]
    assert np.abs(motion.of_point("bar", scene.links["bar"].points["R"])[0] - expected).max() < 1e-12


def test_elements_are_those_of_the_drawing():
    scene = load(MESHES / "four_bar_graded.toml")
    mesh = mesh_scene(scene)
    drawn = meshio.read(MESHES / "four_bar.msh")
    lines = drawn.cells_dict["line"]
    lengths = np.linalg.norm(drawn.points[lines[:, 1]] - drawn.points[lines[:, 0]], axis=1)
    assert np.allclose(np.sort(mesh.cell_length), np.sort(lengths), rtol=1e-12)
    assert np.bincount(mesh.cell_member).tolist() == [4, 6, 5]
    crank = mesh.cell_length[mesh.cell_member == 0]
    assert np.allclose(crank[1:] / crank[:-1], 1.5, rtol=1e-6)  # gmsh integrates the grading


@pytest.mark.parametrize("demo", ["four_bar", "stephenson", "counterweighted_rocker", "slider_crank"])
def test_exported_mesh_is_a_drawing_with_the_same_frequencies(demo, tmp_path):
    scene = load(DEMOS / f"{demo}.toml").changed(**QUICK)
    write_mesh(
        plane_mesh(scene.links, scene.joints, mesh_scene(scene), solve_motion(scene, np.zeros(1))),
        tmp_path / "mesh.msh",
    )
    data = scene.model_dump(exclude_unset=True, exclude={"mesh", "joints", "ground"}) | {"drawing": "mesh.msh"}
    kept = {"section", "material"}
    for name, link in scene.links.items():
        members = {label: member.model_dump(include=kept) for label, member in link.members.items()}
        data["links"][name] = {"members": members} if len(members) > 1 else next(iter(members.values()))
    if demo == "slider_crank":  # its guide is not drawn
        data["ground"] = {"points": {"G": (0.0, 0.01)}}
        data["joints"] = {"B": {"kind": "slot", "connect": ("ground.G", "rod.B")}}
    again = Scene.read(completed(data, tmp_path))
    assert set(again.members()) == set(scene.members())
    first, second = (modes_of(s).frequency for s in (scene, again))
    assert np.abs(first - second).max() < 1e-9 * first.max()


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("binary", [False, True])
def test_every_gmsh_format_is_read(version, binary, tmp_path):
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Verbosity", 0)
        gmsh.open(str(MESHES / "six_bar.geo"))
        gmsh.model.mesh.generate(1)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(str(tmp_path / "six_bar.msh"))
    finally:
        gmsh.finalize()
    text = (MESHES / "six_bar.toml").read_text()
    scene, expected = parse(text.replace(".geo", ".msh"), folder=tmp_path), load(MESHES / "six_bar.toml")
    assert set(scene.links) == set(expected.links)
    for name, link in scene.links.items():
        assert link.points.keys() == expected.links[name].points.keys()
        for point, place in link.points.items():
            assert place == pytest.approx(expected.links[name].points[point], abs=1e-15)
        assert link.members.keys() == expected.links[name].members.keys()


def test_other_formats_come_through_meshio(tmp_path):
    points = np.array([[0, 0, 0], [0.10795, 0, 0], [0.1977113913043478, 0.2645888369359292, 0], [0.254, 0, 0]])
    sets = {"ground_O": [0], "joint_A": [1], "joint_B": [2], "ground_C": [3]}
    mesh = meshio.Mesh(
        points,
        [("line", np.array([[0, 1], [1, 2], [3, 2]]))],
        point_sets={name: np.array(nodes) for name, nodes in sets.items()},
        cell_sets={name: [np.array([i])] for i, name in enumerate(("crank", "coupler", "follower"))},
    )
    mesh.write(tmp_path / "four_bar.inp")
    scene = parse((MESHES / "four_bar.toml").read_text().replace(".geo", ".inp"), folder=tmp_path)
    found, expected = (
        analyse(s.changed(analysis__method="quasi-static", **QUICK)).data["strain"]
        for s in (scene, load(DEMOS / "four_bar.toml"))
    )
    assert difference(found, expected) < 1e-9


# A rocker CB, bent at E, with an end mass at W, and a triangular coupler; written so that the tests can change it.
BENT = """
Point(1) = {0, 0, 0}; Point(2) = {0.1, 0, 0}; Point(3) = {0.3, 0.3, 0}; Point(4) = {0.4, 0, 0};
Point(5) = {0.45, 0.1, 0};
Point(6) = {0.5, -0.1, 0}; Point(7) = {0.2, 0.3, 0}; Point(8) = {0.2, 0.15, 0};
Line(1) = {1, 2};
Line(2) = {2, 8}; Line(3) = {8, 3}; Line(4) = {3, 7}; Line(5) = {7, 2};
Line(6) = {4, 5}; Line(7) = {5, 3}; Line(8) = {4, 6};
Transfinite Curve {1:8} = 3;
Physical Point("ground O") = {1};
Physical Point("joint A") = {2};
Physical Point("B") = {3};
Physical Point("ground C") = {4};
Physical Point("point W") = {6};
Physical Curve("crank") = {1};
Physical Curve("coupler") = {2:5};
Physical Curve("rocker.lower") = {6};
Physical Curve("rocker.upper") = {7};
Physical Curve("rocker.tail") = {8};
"""
SCENE = """
drawing = { file = "bent.geo", section = "bar", material = "steel" }
[materials.steel]
modulus = "210 GPa"
density = 7850
[sections.bar]
shape = "rectangle"
width = 0.02
height = 0.01
[masses]
W = { at = "rocker.W", mass = 0.1 }
[drive]
joint = "O"
speed = 10
"""


@pytest.fixture
def bent(tmp_path):
    """Write the bent drawing, changed, beside a scene, changed, and read it."""

    def read(*changes, scene=(), more=""):
        drawing, text = BENT, SCENE + more
        for old, new in changes:
            assert old in drawing
            drawing = drawing.replace(old, new)
        for old, new in scene:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "bent.geo").write_text(drawing)
        return parse(text, file="bent.toml", folder=tmp_path)

    return read


def test_members_end_at_corners_branches_and_names(bent):
    scene = bent()
    # A, (0.2, 0.15) and B lie on one straight line, so that the triangle has three members, one with 4 elements
    assert set(scene.links["coupler"].members) == {"A-B", "B-p1", "p1-A"}
    assert scene.links["coupler"].members["A-B"].mesh.stations == pytest.approx((0, 0.25, 0.5, 0.75, 1), abs=1e-11)
    assert set(scene.links["rocker"].members) == {"lower", "upper", "tail"}
    assert scene.links["rocker"].members["lower"].ends == ("C", "p1")
    # the rocker's origin is B, the first of its points that the drawing names
    assert scene.links["rocker"].points["B"] == (0, 0)
    assert scene.links["rocker"].points["W"] == pytest.approx((0.2, -0.4))
    assert scene.links["rocker"].position == pytest.approx((0.3, 0.3))
    assert scene.joints["O"].connect == ("ground.O", "crank.O")
    assert scene.joints["B"].connect == ("coupler.B", "rocker.B")
    assert solve_motion(scene, np.array([0.3])).angle.shape == (1, 3)


def test_a_named_point_cuts_a_straight_link_in_two(bent):
    scene = bent(('Physical Point("B")', 'Physical Point("point H") = {8};\nPhysical Point("B")'))
    assert {"A-H", "H-B"} <= set(scene.links["coupler"].members)


def test_links_are_joined_too_where_each_has_its_own_point(bent):
    scene = bent(("Line(2) = {2, 8}", "Point(20) = {0.1, 0, 0}; Line(2) = {20, 8}"), ("{7, 2}", "{7, 20}"),
                 ('"joint A") = {2}', '"joint A") = {2, 20}'))  # fmt: skip
    assert scene.joints["A"].connect == ("crank.A", "coupler.A")


def test_a_curve_becomes_a_chain_of_its_elements(bent):
    arc = ("Line(1) = {1, 2};", "Point(30) = {0.05, -0.1, 0}; Circle(1) = {1, 30, 2};")
    scene = bent(arc, ("Curve {1:8} = 3", "Curve {1} = 7;\nTransfinite Curve {2:8} = 3"))
    assert len(scene.links["crank"].members) == 6
    assert all(member.mesh.stations == (0, 1) for member in scene.links["crank"].members.values())


def test_scene_file_may_add_to_the_drawing(bent):
    more = """
[links.coupler]
members.A-B = { mesh = { elements = 7 } }
[links.crank]
rigid = { mass = 0.2, inertia = 1e-4, centre = [0.05, 0] }
[ground]
points = { S = [1, 1] }
"""
    scene = bent(more=more)
    assert scene.links["coupler"].members["A-B"].mesh.elements == 7
    assert scene.links["crank"].members == {}
    assert scene.links["crank"].points == {"O": (0, 0), "A": (0.1, 0)}
    assert set(scene.ground.points) == {"O", "C", "S"}


def test_unit_of_the_drawing(bent):
    scene = bent(scene=[('section = "bar",', 'unit = "in", section = "bar",')])
    assert scene.ground.points["C"] == pytest.approx((0.4 * 0.0254, 0), abs=1e-18)


def test_schema_knows_drawings():
    full = schema()
    assert {"required": ["drawing"]} in full["anyOf"]
    assert "links" not in full["required"]
    assert {"section", "material", "mesh"} <= set(full["$defs"]["Link"]["properties"])


BAD = {
    "no groups": ([(line, "") for line in BENT.splitlines() if "Physical" in line], "no named physical groups"),
    "no line groups": ([(line, "") for line in BENT.splitlines() if "Physical Curve" in line], "no lines in a named"),
    "group without a name": ([('Curve("crank")', "Curve(77)")], "a group of lines is named '77 (without a name)'"),
    "strange name of lines": ([('"crank"', '"the crank"')], "a group of lines is named 'the crank'"),
    "strange name of a point": ([('"joint A"', '"joint at A"')], "a group of points is named 'joint at A'"),
    "no end of a line": (
        [('"point W") = {6}', '"point W") = {30}'), ("Point(7)", "Point(30) = {0.05, 0, 0}; Point(7)")],
        "the point of 'point W' at (0.05, 0) m is no end of a link's line",
    ),
    "joint of one link": ([('"ground O"', '"joint O"')], "'joint O' at (0, 0) m joins only link 'crank'"),
    "joint torn apart": (
        [('"joint A") = {2}', '"joint A") = {1, 7}'), ('Physical Point("ground O") = {1};', "")],
        "the points of 'joint A' lie apart, at (0, 0) m and (0.2, 0.3) m",
    ),
    "two points of one name": ([('"joint A") = {2}', '"joint A") = {2, 7}')], "'coupler' has two points named 'A'"),
    "two names": ([('"joint A")', '"joint Q") = {2};\nPhysical Point("joint A")')], "has two names"),
    "disconnected": (
        [("Line(8) = {4, 6}", "Point(9) = {1, 1, 0}; Line(8) = {9, 6}")],
        "lines of link 'rocker' are not connected: none leads from (0.4, 0) m to (",
    ),
    "welded by place only": (
        [("Line(8) = {4, 6}", "Point(9) = {0.4, 0, 0}; Line(8) = {9, 6}")],
        "two points in one place are not enough",
    ),
    "zero length": (
        [("{7, 2};", "{7, 2}; Point(9) = {0.2, 0.3, 0}; Line(9) = {7, 9};"), ("{2:5};", "{2:5, 9};")],
        "a line of 'coupler' at (0.2, 0.3) m has length 0",
    ),
    "in two groups": (
        [('"rocker.tail") = {8}', '"rocker.tail") = {8, 7}')],
        "is in two groups, 'rocker.upper' and 'rocker.tail'",
    ),
    "out of the plane": ([("{0.2, 0.3, 0}", "{0.2, 0.3, 0.01}")], "the point (0.2, 0.3) m has z = 0.01 m"),
    "second order": ([("Line(1)", "Mesh.ElementOrder = 2;\nLine(1)")], "neither points nor straight lines"),
    "syntax": ([("Line(1) = {1, 2};", "Line(1) = {1, 2;")], "gmsh cannot read bent.geo: line 5: syntax error"),
    "runs a program": ([("Line(1)", 'SystemCall "touch broken";\nLine(1)')], "line 5: the word 'SystemCall'"),
    "reads a file": ([("Line(1)", 'Include "other.geo";\nLine(1)')], "the word 'Include' is not allowed"),
    "writes a file": ([("Line(1)", 'Save "mesh.msh";\nLine(1)')], "the word 'Save' is not allowed"),
    "prints": ([("Line(1)", 'Printf("x") > "broken";\nLine(1)')], "the word 'Printf' is not allowed"),
    "command after a comment": ([("Line(1)", '/* */ System "touch broken"; // */\nLine(1)')], "the word 'System'"),
    "word of small letters": ([("Line(1)", 'run "touch broken";\nLine(1)')], "outside a group's name"),
    "command in a text": ([("Line(1)", "x = 'touch broken';\nLine(1)")], "the character ' outside a group's name"),
    "backslash": ([('"joint A"', r'"joint \A"')], "outside a group's name"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_drawing_is_refused(case, bent, tmp_path, monkeypatch):
    changes, message = BAD[case]
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError) as caught:
        bent(*changes)
    text = str(caught.value)
    assert message in text
    assert text.startswith("bent.toml: drawing (line 2): ")
    assert "bent.geo" in text
    assert "\n" not in text
    assert str(tmp_path) not in text
    assert not (tmp_path / "broken").exists()


BAD_SCENE = {
    "misspelled link": ([], "[links]\nroker = { section = 'bar' }", "links.roker", "Did you mean 'rocker'?"),
    "misspelled member": (
        [],
        "[links.rocker.members]\nuper = { section = 'bar' }",
        "links.rocker.members.uper",
        "'upper'",
    ),
    "misspelled point": ([('"rocker.W"', '"rocker.V"')], "", "masses.W.at", "no point 'rocker.V'"),
    "misspelled joint": ([('joint = "O"', 'joint = "Q"')], "", "drive.joint", "no joint 'Q'"),
    "drawn angle": ([], "[links]\nrocker = { angle = 1 }", "links.rocker.angle", "the drawing gives 'angle'"),
    "unknown key of a link": ([], "[links]\nrocker = { sections = 'bar' }", "links.rocker.sections", "unknown key"),
    "unknown key of a member": (
        [],
        "[links.rocker.members]\nupper = { x = 1 }",
        "links.rocker.members.upper.x",
        "unknown",
    ),
    "no section": ([('section = "bar", ', "")], "", "links.crank", "has no section"),
    "mesh of its own": ([], "[mesh]\nelements = 3", "mesh", "the drawing gives the elements"),
    "unknown key": ([('section = "bar", ', 'sections = "bar", ')], "", "drawing.sections", "unknown key"),
    "bad unit": ([('section = "bar", ', 'unit = "kg", section = "bar", ')], "", "drawing.unit", "no unit of length"),
    "no file": ([('file = "bent.geo", ', "")], "", "drawing", "file is missing"),
    "not a string": ([('"bent.geo"', "3")], "", "drawing.file", "must be a string"),
    "missing file": ([('"bent.geo"', '"nowhere.geo"')], "", "drawing", "cannot read nowhere.geo: No such file"),
    "folder": ([('"bent.geo"', '"."')], "", "drawing", "Is a directory"),
    "links is no table": ([], "[[links]]\nx = 1", "links", "must be a table"),
}


@pytest.mark.parametrize("case", BAD_SCENE)
def test_bad_scene_with_a_drawing_is_refused(case, bent):
    changes, more, place, message = BAD_SCENE[case]
    with pytest.raises(SceneError) as caught:
        bent(scene=changes, more=more)
    text = str(caught.value)
    assert text.startswith(f"bent.toml: {place}")
    assert message in text


@pytest.mark.parametrize("name", ["bad.msh", "bad.geo", "bad.vtu", "bad.inp", "bad.xyz"])
@pytest.mark.parametrize(
    "content", [b"", b"hello\n", b"$MeshFormat\n2.2 0 8\nhello\n", b"$MeshFormat\n4.1 0 8\n$Nodes\n1", b"\xff\xfe\0"]
)
def test_what_is_no_mesh_is_refused(name, content, tmp_path, capfd):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError) as caught:
        parse(SCENE.replace("bent.geo", name), folder=tmp_path)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr().out == ""


def test_a_script_beside_the_drawing_is_not_run(bent, tmp_path):
    # gmsh runs NAME.opt when it opens NAME
    (tmp_path / "bent.geo.opt").write_text(f'SystemCall "touch {tmp_path}/broken";')
    bent()
    assert not (tmp_path / "broken").exists()


def test_a_script_under_the_name_of_a_mesh_is_not_run(tmp_path):
    (tmp_path / "bent.msh").write_text(f'SystemCall "touch {tmp_path}/broken";\n' + BENT)
    with pytest.raises(SceneError, match=r"does not begin with \$MeshFormat"):
        parse(SCENE.replace("bent.geo", "bent.msh"), folder=tmp_path)
    assert not (tmp_path / "broken").exists()


def test_one_drawing_knows_nothing_of_another(bent):
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Verbosity", 0)
        gmsh.model.add("mine")
        bent(("Line(1)", "left_over = 3;\nLine(1)"))
        with pytest.raises(SceneError, match="left_over"):
            bent(("Line(1) = {1, 2}", "Line(1) = {1, left_over - 1}"))
        assert gmsh.model.getCurrent() == "mine"
    finally:
        gmsh.finalize()


def test_a_mesh_that_lacks_a_node_is_refused(tmp_path):
    text = (MESHES / "four_bar.msh").read_text()
    assert "\n5 1 5 \n" in text  # element 5, from node 1 to node 5
    (tmp_path / "four_bar.msh").write_text(text.replace("\n5 1 5 \n", "\n5 1 99 \n"))
    with pytest.raises(SceneError, match=r"four_bar\.msh"):
        parse((MESHES / "four_bar_graded.toml").read_text(), folder=tmp_path)


def test_groups_without_lines_are_no_mechanism(tmp_path):
    text = (MESHES / "four_bar.msh").read_text()
    (tmp_path / "four_bar.msh").write_text(text[: text.index("$Elements")] + "$Elements\n0 0 0 0\n$EndElements\n")
    with pytest.raises(SceneError, match="has no lines in a named physical group"):
        parse((MESHES / "four_bar_graded.toml").read_text(), folder=tmp_path)
