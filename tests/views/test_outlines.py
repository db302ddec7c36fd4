"""Outlines of links, opened again by ezdxf: against the crank's corners by hand, and the links' lengths."""

import math
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from fenics_mech import AssemblyError, ViewError, load, write_outlines
from fenics_mech.cli import app
from fenics_mech.scene import parse
from fenics_mech.views.outlines import layer_names
from tests.common import DEMOS

FOUR_BAR = """
name = "outlines"
[materials.steel]
modulus = "210 GPa"
density = "7850 kg/m^3"
[sections]
flat = { shape = "rectangle", width = "8 mm", height = "20 mm" }
thin = { shape = "rectangle", width = "8 mm", height = "10 mm" }
bar = { shape = "taper", from = "flat", to = "thin" }
plain = { area = "1 cm^2", inertia = "1 cm^4", fibre = "5 mm" }
[ground]
points = { O = [0, 0], C = ["300 mm", 0] }
[links.crank]
points = { O = [0, 0], A = ["100 mm", 0] }
members.OA = { ends = ["O", "A"], section = "flat", material = "steel", offset = "2 mm" }
[links.coupler]
points = { A = [0, 0], B = ["320 mm", 0] }
members.AB = { ends = ["A", "B"], section = "bar", material = "steel" }
angle = "40 deg"
[links.Crank]
points = { C = [0, 0], B = ["250 mm", 0] }
members.CB = { ends = ["C", "B"], section = "plain", material = "steel" }
angle = "100 deg"
[joints]
O.connect = ["ground.O", "crank.O"]
A.connect = ["crank.A", "coupler.A"]
B.connect = ["coupler.B", "Crank.B"]
C.connect = ["ground.C", "Crank.C"]
[joint_laws.rubs]
kind = "friction"
joint = "C"
coefficient = 0.1
radius = "6 mm"
[drive]
joint = "O"
speed = "10 rad/s"
[analysis]
method = "transient"
"""


@pytest.fixture
def drawn(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    return ezdxf.readfile(write_outlines(parse(FOUR_BAR), tmp_path / "links.dxf", math.radians(30)))


def corners(document, layer, closed):
    lines = document.modelspace().query(f'LWPOLYLINE[layer=="{layer}"]')
    return [np.array(line.get_points("xy")) for line in lines if line.closed == closed]


def test_the_crank_has_its_corners_by_hand(drawn):
    """A rectangle 20 mm high, 2 mm off the axis of 100 mm at 30 degrees."""
    along, across = np.array([math.cos(math.pi / 6), 0.5]), np.array([-0.5, math.cos(math.pi / 6)])
    expected = [12 * across, 100 * along + 12 * across, 100 * along - 8 * across, -8 * across]
    (outline,) = corners(drawn, "crank", closed=True)
    assert outline == pytest.approx(np.array(expected), abs=1e-9)
    (axis,) = corners(drawn, "crank", closed=False)
    assert axis == pytest.approx(np.array([[0, 0], 100 * along]), abs=1e-9)
    assert drawn.units == 4  # mm


def test_a_taper_is_as_wide_as_its_sections(drawn):
    (outline,) = corners(drawn, "coupler", closed=True)
    upper, lower = np.split(outline, 2)
    width = np.linalg.norm(upper - lower[::-1], axis=1)
    assert width == pytest.approx(np.linspace(20, 10, len(width)))
    (axis,) = corners(drawn, "coupler", closed=False)
    assert np.linalg.norm(axis[1] - axis[0]) == pytest.approx(320)


def test_pins_hold_the_links_together(drawn):
    """C and O stand on the ground; B lies at 320 mm from A and 250 mm from C."""
    pins = {tuple(np.round(pin.dxf.center, 6))[:2]: pin.dxf.radius for pin in drawn.modelspace().query("CIRCLE")}
    places = np.array(list(pins))
    assert len(places) == 4
    a, c = 100 * np.array([math.cos(math.pi / 6), 0.5]), np.array([300, 0])
    b = next(place for place in places if abs(np.linalg.norm(place - a) - 320) < 1e-5)
    assert np.linalg.norm(b - c) == pytest.approx(250)
    assert pins[300.0, 0.0] == pytest.approx(6)  # as the friction states
    assert pins[0.0, 0.0] == pytest.approx(0.01 * np.linalg.norm(np.ptp(places, axis=0)), rel=1e-5)


def test_layers_differ_by_more_than_the_case_of_letters(drawn):
    assert layer_names(parse(FOUR_BAR)) == {"crank": "crank", "coupler": "coupler", "Crank": "Crank_2"}
    (line,) = corners(drawn, "Crank_2", closed=False)  # a section without a shape has its axis alone
    assert np.linalg.norm(line[1] - line[0]) == pytest.approx(250)
    assert not corners(drawn, "Crank_2", closed=True)


def test_the_file_is_sound(drawn):
    assert not drawn.audit().errors


def test_rigid_links_are_polygons_of_their_points(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    text = FOUR_BAR.replace(
        'points = { A = [0, 0], B = ["320 mm", 0] }',
        'points = { A = [0, 0], B = ["320 mm", 0], P = ["160 mm", "90 mm"] }',
    )
    text = text.replace(
        'members.AB = { ends = ["A", "B"], section = "bar", material = "steel" }',
        'rigid = { mass = "1 kg", inertia = "0.01 kg m^2", centre = ["160 mm", "30 mm"] }',
    )
    document = ezdxf.readfile(write_outlines(parse(text), tmp_path / "rigid.dxf"))
    (triangle,) = corners(document, "coupler", closed=True)
    sides = np.linalg.norm(np.roll(triangle, -1, axis=0) - triangle, axis=1)
    assert sides == pytest.approx([320, math.hypot(160, 90), math.hypot(160, 90)])


def test_nothing_is_written_where_it_cannot(tmp_path, monkeypatch):
    scene = parse(FOUR_BAR)
    with pytest.raises(ViewError, match=r"as \.dxf, not as '\.dwg'"):
        write_outlines(scene, tmp_path / "links.dwg")
    reaches = FOUR_BAR.replace('"320 mm"', '"120 mm"')
    with pytest.raises(AssemblyError):
        write_outlines(parse(reaches), tmp_path / "links.dxf", math.pi)
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(ViewError, match=r"ezdxf.*pip install 'fenics_mech\[sketches\]'"):
        write_outlines(scene, tmp_path / "links.dxf")
    assert not list(tmp_path.iterdir())


def test_the_command_draws_a_scene_at_an_angle(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    demo = DEMOS / "slider_crank.toml"
    done = CliRunner().invoke(app, ["export", str(demo), str(tmp_path / "s.dxf"), "--angle", "90 deg"])
    assert done.exit_code == 0, done.output
    crank = next(
        line for line in ezdxf.readfile(tmp_path / "s.dxf").modelspace().query("LWPOLYLINE") if not line.closed
    )
    (x, y), (x2, y2) = crank.get_points("xy")
    link = load(demo).links[crank.dxf.layer]
    (first, second) = next(iter(link.members.values())).ends
    assert math.hypot(x2 - x, y2 - y) == pytest.approx(1e3 * math.dist(link.points[first], link.points[second]))
    bad = CliRunner().invoke(app, ["export", str(demo), str(tmp_path / "s.py"), "--angle", "90 deg"])
    assert "--angle is for the outlines" in str(bad.exception)
