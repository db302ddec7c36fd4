"""Keys of strength and design: what they mean, how wrong ones are told, and that they are written as they are read."""

import pytest

from fenics_mech import Design, Material, SceneError, write_scene
from fenics_mech.scene import load, parse
from tests.common import ROOT

TEXT = (ROOT / "tests" / "cases" / "scenes" / "side_buckling.toml").read_text()
PIN = 'A.connect = ["crank.A", "rod.A"]'
BAD = {
    'safety = { yeld = 2 }': "design.safety.yeld",
    'safety = { yield = -2 }': "must be greater than 0, found -2",
    'deflection = "L/0"': "found 'L/0'",
    'deflection = "5 kg"': "has the wrong unit",
    'deflection = "-5 mm"': "must be greater than 0, found '-5 mm'",
    'cycles = 0': "design.cycles",
}  # fmt: skip


@pytest.mark.parametrize("line", BAD)
def test_wrong_wants_are_told(line):
    with pytest.raises(SceneError) as error:
        parse(f"{TEXT}\n[design]\n{line}\n")
    assert BAD[line] in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('strength = "250 MPa"', 'yeild = "250 MPa"', "Did you mean 'yield'?"),
        ('strength = "250 MPa"', 'yield = "250 MPa"\nultimate = "200 MPa"', "expected ultimate >= 2.5e+08 Pa"),
        ('strength = "250 MPa"', 'surface = "rough"', "'ground', 'machined', 'hot-rolled' or 'as-forged'"),
        (
            PIN,
            f'{PIN}\nA.pin = {{ diameter = "9 mm", eye = "8 mm", thickness = "5 mm" }}',
            "an eye is wider than its pin",
        ),
        (PIN, f'{PIN}\nA.pin = {{ diameter = "9 mm", eye = "18 mm" }}', "joints.A.pin.thickness"),
    ],
)
def test_wrong_strengths_and_pins_are_told(old, new, said):
    with pytest.raises(SceneError) as error:
        parse(TEXT.replace(old, new))
    assert said in str(error.value)


def test_limits_of_the_deflection():
    assert Design().allowed_deflection(0.4) == pytest.approx(0.002)
    assert Design(deflection="L / 500").allowed_deflection(1.0) == pytest.approx(0.002)
    assert Design(deflection="2 mm").allowed_deflection(1.0) == pytest.approx(0.002)


def test_yield_is_written_and_changed_by_its_name_in_files(tmp_path):
    scene = parse(TEXT.replace('strength = "250 MPa"', 'yield = "250 MPa"') + "\n[design]\nsafety = { yield = 2 }\n")
    assert scene.materials["steel"].yield_ == 250e6
    assert scene.changed({"materials.steel.yield": "300 MPa"}).materials["steel"].yield_ == 300e6
    path = write_scene(scene, tmp_path / "scene.toml")
    assert "yield = 250000000.0" in path.read_text()
    assert load(path) == scene
    assert Material(modulus=2e11, density=7850, yield_="250 MPa").yield_ == 250e6
