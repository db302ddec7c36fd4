"""Scene files: what they say is what the scene has, and bad ones are refused with their place."""

import pytest

from fenics_mech import load
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene, parse, schema
from fenics_mech.scene.factories import four_bar, seed_four_bar
from tests.common import DEMOS


def test_demo_is_the_seed_four_bar():
    demo, made = load(DEMOS / "four_bar.toml"), seed_four_bar()
    assert demo.links["coupler"].points["B"] == (0.2794, 0.0)
    assert demo.links["follower"].points == made.links["follower"].points
    assert demo.sections["strip"].inertia == made.sections["coupler"].inertia == pytest.approx(8.67e-12)
    assert [m.mass for m in demo.masses.values()] == [m.mass for m in made.masses.values()]
    assert demo.analysis == made.analysis
    assert demo.damping == made.damping
    assert (demo.effects, made.effects) == ("auto", ())


def test_units_are_converted_and_numbers_are_si(demo_text):
    scene = parse(demo_text.replace('"71 GPa"', "71e9").replace('"32.3 rad/s"', '"300 rpm"'))
    assert scene.materials["aluminium"].modulus == 71e9
    assert scene.drive.speed == pytest.approx(31.41592653589793, rel=1e-14)


def test_a_scene_without_a_name_has_that_of_its_file(tmp_path, demo_text):
    """Cut to the length that a name may have."""
    nameless = "\n".join(line for line in demo_text.splitlines() if not line.startswith("name = "))
    for stem in ("press", "p" * 220):
        (tmp_path / f"{stem}.toml").write_text(nameless)
        assert load(tmp_path / f"{stem}.toml").name == stem[:200]


def test_scene_is_frozen(seed):
    with pytest.raises(Exception, match="frozen"):
        seed.name = "other"


def test_changed_gives_a_new_checked_scene(seed):
    assert seed.changed(analysis__modes="all").analysis.modes == "all"
    assert seed.analysis.modes == 5
    with pytest.raises(SceneError, match=r"analysis\.modes"):
        seed.changed(analysis__modes=0)


def test_scene_survives_json(seed):
    assert Scene.model_validate_json(seed.model_dump_json()) == seed


def test_schema_names_every_table_of_the_file():
    keys = set(schema()["properties"])
    assert keys == {*Scene.model_fields, "drawing"}
    assert schema()["additionalProperties"] is False


BAD = {
    "wrong unit": ("2714 kg/m^3", "2714 kg", "materials.aluminium.density (line 7)", "wrong unit"),
    "not a quantity": ('"71 GPa"', '"much"', "materials.aluminium.modulus (line 6)", "cannot read 'much'"),
    "frequency as speed": ("32.3 rad/s", "5 Hz", "drive.speed", "2 pi"),
    "negative modulus": ('"71 GPa"', '"-71 GPa"', "materials.aluminium.modulus", "greater than 0"),
    "not finite": ("= [0, 0], A", "= [nan, 0], A", "links.crank.points.O", "finite"),
    "unknown key": ("ratio = 0.02", "ratios = 0.02", "damping.ratios (line 51)", "unknown key"),
    "missing key": ('fibre = "0.8 mm"', "", "sections.strip.fibre", "missing"),
    "unknown point": ('["crank.A", ', '["crank.X", ', "joints.A.connect (line 38)", "no point 'crank.X'"),
    "unknown link": ('"coupler.B", ', '"copler.B", ', "joints.B.connect", "no link 'copler'"),
    "unknown section": ('section = "crank"', 'section = "tube"', "links.crank.members.OA.section", "no section 'tube'"),
    "joint to itself": ('["crank.A", "coupler.A"]', '["crank.A", "crank.O"]', "joints.A", "already in joint 'O'"),
    "no such drive": ('joint = "O"', 'joint = "Q"', "drive.joint", "no joint 'Q'"),
    "drive stands still": ('speed = "32.3 rad/s"', "speed = 0", "drive", "must not be 0"),
    "zero length": ('B = ["11 in", 0]', "B = [0, 0]", "links.coupler.members.AB.ends", "length 0"),
    "loose point": ('B = ["11 in", 0]', 'B = ["11 in", 0], D = [1, 1]', "links.coupler.points", "on no member"),
    "mass on ground": ('at = "crank.A"', 'at = "ground.O"', "masses.A.at", "does not move"),
    "no elements": ("elements = 3", "elements = 0", "mesh.elements", "greater than or equal to 1"),
    "not TOML": ("[drive]", "[drive", "bad.toml", "not valid TOML"),
    "bad modes": ("modes = 5", 'modes = "many"', "analysis.modes", "'all'"),
    "unknown solver prefix": ("modes = 5", 'modes = 5\n[petsc]\nksp_type = "cg"', "petsc", "periodic_"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_scene_is_refused_with_its_place(case, demo_text):
    old, new, place, message = BAD[case]
    assert old in demo_text
    with pytest.raises(SceneError) as caught:
        parse(demo_text.replace(old, new), file="bad.toml")
    text = str(caught.value)
    assert text.startswith("bad.toml")
    assert place in text
    assert message in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("formula", "words"),
    [("1/0", "not finite"), ("1/theta", "not finite"), ("theta", "not periodic"), ("sin(2*t)", "may not stand")],
)
def test_bad_formula_of_a_drive_is_refused_with_its_place(seed, formula, words):
    law = {"kind": "expression", "formula": formula}
    with pytest.raises(SceneError, match=words) as caught:
        seed.changed(drive__speed=None, drive__law=law, drive__period=0.5)
    assert caught.value.place == "drive.law.formula"
    assert "more found" not in str(caught.value)


def tables_in(part):
    """Every table with keys in a JSON Schema."""
    if isinstance(part, dict):
        if isinstance(part.get("properties"), dict):
            yield part["properties"]
        part = list(part.values())
    for inside in part if isinstance(part, list) else []:
        yield from tables_in(inside)


def test_every_key_of_the_schema_says_what_it_means():
    tables = [keys for keys in tables_in(schema()) if all(isinstance(value, dict) for value in keys.values())]
    assert sum(map(len, tables)) > 300  # 177 of a scene, and the options of PETSc
    for keys in tables:
        for key, value in keys.items():
            said = value.get("description", "")
            assert len(said) > 4, key
            assert "or a string" not in said[:25], f"{key}: only the unit is said: {said}"


def test_a_key_of_a_quantity_says_what_it_means_and_its_unit():
    keys = schema()["$defs"]["RectangleSection"]["properties"]
    assert keys["height"]["description"].endswith(". A number in m, or a string with a unit.")
    assert keys["height"]["description"] != keys["width"]["description"]


def test_missing_file_is_named(tmp_path):
    with pytest.raises(SceneError, match=r"nowhere\.toml: cannot read"):
        load(tmp_path / "nowhere.toml")


def test_binary_file_is_refused(tmp_path):
    (tmp_path / "image.toml").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(SceneError, match="not a UTF-8 text"):
        load(tmp_path / "image.toml")


def test_factory_refuses_lengths_that_do_not_close():
    with pytest.raises(SceneError, match="do not close"):
        four_bar(
            crank=1,
            coupler=1,
            follower=1,
            ground=5,
            sections=[{"area": 1, "inertia": 1, "fibre": 1}] * 3,
            material={"modulus": 1, "density": 1},
            speed=1,
        )


def test_factory_refuses_bad_values_as_scene_errors():
    with pytest.raises(SceneError, match=r"sections\.crank\.area"):
        seed_four_bar(sections={"crank": {"area": "-1 cm^2", "inertia": 1, "fibre": 1}})


def test_crossed_branch_is_the_mirror_image():
    shape = {"crank": 1, "coupler": 3, "follower": 3, "ground": 2.5, "speed": 1}
    section = {"area": 1, "inertia": 1, "fibre": 1}
    shape |= {"sections": [section] * 3, "material": {"modulus": 1, "density": 1}}
    upright, crossed = four_bar(**shape), four_bar(**shape, branch="crossed")
    assert crossed.links["coupler"].angle == pytest.approx(-upright.links["coupler"].angle)


def test_more_elements_than_rounding_allows_are_refused():
    with pytest.raises(SceneError, match="301 elements in one member: rounding"):
        seed_four_bar(mesh={"elements": 301})


def test_places_in_errors_hold_no_kind_of_a_table(demo_text):
    text = demo_text + '[freedoms.B.effort]\nkind = "dc-motor"\nstall_torque = -1\nno_load_speed = 300\n'
    with pytest.raises(SceneError, match=r"freedoms\.B\.effort\.stall_torque .*must be greater than 0, found -1"):
        parse(text)
    with pytest.raises(SceneError, match=r"freedoms\.B\.effort\.formula .*this key is missing"):
        parse(demo_text + '[freedoms.B.effort]\nkind = "formula"\n')
