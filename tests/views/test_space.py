"""Views of linkages in space show the numbers of the result, at their places, and every part of the scene."""

import json
import re

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from PIL import Image

import fenics_mech as fm
from fenics_mech.errors import ViewError
from fenics_mech.scene.files import read_toml
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.views.figures import figure_in
from fenics_mech.views.key_figures import key_figures
from fenics_mech.views.notebook import html
from fenics_mech.views.rendering import prepare_rendering
from fenics_mech.views.space import plots
from fenics_mech.views.space.page import spatial_page
from fenics_mech.views.space.reading import SpatialReading
from fenics_mech.views.space.skeleton import EYES
from fenics_mech.views.words import in_degrees, short
from tests.common import DEMOS
from tests.views.browser import PHONE, browser

FEW = {"analysis.positions": 24, "mesh.elements": 2}
SLIDER = """
gravity = [0, 0, "-9.81 m/s^2"]
materials.steel = { modulus = "207 GPa", density = "7800 kg/m^3", poisson = 0.3, yield = "250 MPa" }
sections.crank = { shape = "I", height = "14 mm", width = "10 mm", flange = "2 mm", web = "2 mm" }
sections.rod = { shape = "tube", diameter = "8 mm", thickness = "1 mm" }
ground.points = { O = [0, 0, 0], G = [0.3, 0.05, 0.04] }
masses.load = { at = "rod@0.5", mass = "20 g" }
loads.press = { at = "block.B", force = ["-50 N", 0, 0] }
loads.brake = { joint = "O", torque = "-0.1 N m" }
springs.coil = { between = ["ground.O", "block.B"], stiffness = 100 }
dampers.pot = { at = "rod@0.5", damping = 0.1 }
drive = { joint = "O", speed = "300 rpm" }
damping.material = "1 ms"
analysis = { positions = 24, method = "quasi-static" }
mesh.elements = 2
[links.crank]
points = { O = [0, 0, 0], A = [0, 0.06, 0] }
members.OA = { ends = ["O", "A"], section = "crank", material = "steel", up = [0, 0, 1] }
[links.rod]
points = { A = [0, 0.06, 0], B = [0.3, 0.05, 0.04] }
members.AB = { ends = ["A", "B"], section = "rod", material = "steel" }
[links.block]
points = { B = [0.3, 0.05, 0.04] }
rigid = { mass = "0.3 kg", inertia = [1e-4, 1e-4, 1e-4], centre = [0.3, 0.05, 0.04] }
[joints]
O = { connect = ["ground.O", "crank.O"], axis = [0, 0, 1] }
A = { connect = ["crank.A", "rod.A"], kind = "ball" }
B = { connect = ["rod.B", "block.B"], kind = "ball" }
G = { connect = ["ground.G", "block.B"], kind = "slider", axis = [1, 0, 0] }
"""


def slider_crank():
    return read_toml(SLIDER, "slider", SpatialScene.read)


@pytest.fixture(scope="module")
def rssr():
    return fm.analyse(fm.load(DEMOS / "space" / "rssr.toml").changed(FEW))


@pytest.fixture(scope="module")
def slider():
    return fm.analyse(slider_crank())


@pytest.fixture(scope="module")
def still():
    scene = fm.load(DEMOS / "space" / "rssr.toml").changed({"analysis.method": "static", "gravity": (0, 0, -9.81)})
    return fm.analyse(scene)


@pytest.fixture(scope="module")
def rigid():
    body = {"mass": 0.1, "inertia": (1e-4, 1e-4, 1e-4)}
    arm = {"points": {"O": (0, 0, 0), "A": (0.1, 0, 0)}, "rigid": body | {"centre": (0.05, 0, 0)}}
    joints = {"O": {"connect": ("ground.O", "arm.O"), "axis": (0, 0, 1)}}
    ground = {"points": {"O": (0, 0, 0)}}
    drive = {"joint": "O", "speed": 10.0}
    data = {"ground": ground, "links": {"arm": arm}, "joints": joints, "drive": drive}
    return fm.analyse(SpatialScene.read(data | {"analysis": {"positions": 12}}))


def words(text):
    return " ".join(str(text).split())


def test_summary_tells_the_largest_of_everything_with_its_place(rssr):
    data, said = rssr.data, words(fm.summary(rssr))
    k, i, j = np.unravel_index(data["von_mises"].to_numpy().argmax(), data["von_mises"].shape)
    assert (str(data["member"].to_numpy()[i]), j) == ("rocker", 0)
    at = in_degrees(float(data["theta"][k]))
    assert (
        f"Largest von Mises stress {short(float(data['von_mises'].max()) / 1e6)} MPa in rocker, at Q, at {at}." in said
    )
    bent = np.linalg.norm(data["deflection"], axis=-1).max()
    assert f"Largest deflection {short(1e3 * bent)} mm" in said
    torque = data["input_torque"].to_numpy()
    assert f"from {short(torque.min())} to {short(torque.max())}" in said
    force = np.linalg.norm(data["joint_force"].sel(joint="A"), axis=-1)
    assert re.search(rf"A universal {re.escape(short(force.max()))} ", said)
    frequency = data["frequency"].to_numpy()
    assert f"{short(frequency[:, 0].min())}\N{EN DASH}{short(frequency[:, 0].max())}," in said
    assert f"largest multiplier {short(float(data['multiplier'].max()))}: a disturbance dies out" in said
    assert "psi" in words(fm.summary(rssr.told_in(["psi"])))


def test_factor_of_safety_is_yield_over_the_largest_stress_of_the_member(slider, rssr):
    factor = 250e6 / float(slider.data["von_mises"].max())
    assert f"Factor of safety {short(factor)} against the yield strength of 250 MPa, in crank." in words(
        fm.summary(slider)
    )
    unknown = rssr.scene.changed({"materials.aluminium.yield": None})
    assert SpatialReading(fm.SpatialResult.with_scene(unknown, rssr.data)).safety[0] == "warn"
    weak = rssr.scene.changed({"materials.aluminium.yield": "50 MPa"})
    reading = SpatialReading(fm.SpatialResult.with_scene(weak, rssr.data))
    assert reading.safety[0] == "bad"
    assert reading.limit.factor == pytest.approx(50e6 / float(rssr.data["von_mises"].max()))
    assert slider.warnings[0].split()[0] in words(fm.summary(slider))
    assert "may turn about its own line" in words(fm.summary(slider))


def test_summaries_of_statics_and_of_rigid_links_say_so(still, rigid):
    assert "at rest as drawn" in words(fm.summary(still))
    assert "at rest." in words(fm.summary(still, details=True))
    assert "No link bends" in words(fm.summary(rigid))


def test_key_figures_are_numbers_of_the_result_in_si(rssr, rigid):
    found = json.loads(json.dumps(key_figures(rssr), allow_nan=False))
    for name, member in found["members"].items():
        own = rssr.data.sel(member=name)
        assert member["von_mises"] == pytest.approx(float(own["von_mises"].max()))
        assert member["deflection"] == pytest.approx(float(np.linalg.norm(own["deflection"], axis=-1).max()))
    assert found["drives"]["O"]["least"] == pytest.approx(float(rssr.data["input_torque"].min()))
    assert found["largest_multiplier"] == float(rssr.data["multiplier"].max())
    assert found["errors"]["strain_error_estimate"] == rssr.data.attrs["strain_error_estimate"]
    assert key_figures(rigid)["members"] == {}


def test_curves_are_the_largest_of_each_member_over_the_cycle(rssr):
    reading = SpatialReading(rssr)
    axes = plots.stress_figure(reading).axes[0]
    curves = {line.get_label(): line.get_xydata() for line in axes.lines}
    angles = np.degrees(rssr.data["theta"].to_numpy())
    stress = rssr.data["von_mises"].sel(member="coupler").max("s").to_numpy() / 1e6
    assert np.interp(angles, *curves["coupler"].T) == pytest.approx(stress)
    rows = plots.moment_figure(reading).axes
    own = rssr.data.sel(member="rocker")["section_moment"][:, 0]
    for n, line in enumerate(rows[0].lines):
        assert np.interp(angles, *line.get_data()) == pytest.approx(own[:, n].to_numpy())


def test_views_show_the_linkage_bent_as_the_title_says(rssr):
    reading, figure = SpatialReading(rssr), None
    figure = plots.view_figure(reading)
    times, k = reading.magnify, reading.peak_position
    assert figure.get_suptitle().endswith(f"{times:g}")
    place = rssr.data["place"] + (times - 1) * rssr.data["deflection"]
    bent = 1e3 * place.sel(member="coupler").to_numpy()[k]
    for axes, view in zip(figure.axes, ("XY", "oblique", "XZ", "YZ")):
        lines = [one for one in axes.collections if isinstance(one, LineCollection)]
        flat = bent @ EYES[view].T
        assert np.array(lines[1].get_segments())[:, 0] == pytest.approx(flat[:-1])
        low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
        assert ((low < flat) & (flat < high)).all()


def test_rigid_links_go_with_the_members_that_hold_them(slider):
    reading = SpatialReading(slider)
    far = reading.joint_points(50.0)
    b, g = reading.joints.index("B"), reading.joints.index("G")
    assert far[:, b, 0] == pytest.approx(reading.paths(50.0)[:, reading.members.index("rod"), -1])
    assert far[:, g, 1] == pytest.approx(far[:, b, 1], abs=1e-12)  # the block's point
    assert far[:, g, 0] == pytest.approx(np.tile([0.3, 0.05, 0.04], (24, 1)))  # the ground's
    assert reading.bars == [[2 * b + 1, 2 * g + 1]]


def test_all_plots_appear_and_others_are_refused(rssr, still, rigid, tmp_path):
    names = [path.stem for path in fm.plot_all(rssr, tmp_path / "a", ending=".svg")]
    assert names == [*plots.SPATIAL_FIGURES]
    assert [path.stem for path in fm.plot_all(still, tmp_path)] == ["stress", "section_moments", "deflection", "views"]
    assert [path.stem for path in fm.plot_all(rigid, tmp_path)] == ["joint_forces", "drive_torque", "views"]
    with pytest.raises(ViewError, match="there is no plot 'strain'; there are stress"):
        fm.plot_all(rssr, tmp_path, ["strain"])


def test_page_has_all_numbers_without_a_script_and_loads_nothing(rssr, slider, still, rigid, tmp_path):
    page = fm.report(rssr, tmp_path / "report.html").read_text()
    body = page.partition("<body>")[2].partition("<script")[0]
    assert "Content-Security-Policy" in page
    assert not re.search(r"(src|href)=|https?://(?!www.w3.org)", page)
    for value in (rssr.data["von_mises"].max() / 1e6, 1e3 * np.linalg.norm(rssr.data["deflection"], axis=-1).max()):
        assert short(float(value)) in body
    assert body.count("<svg") == 3
    data = json.loads(page.partition('id="data">')[2].partition("</script>")[0])
    assert data["joints"] == ["O", "A", "B", "Q"]
    assert data["peaks"][2][1:] == [0, 0]
    assert [one["row"] for name, one in data["arrays"].items() if name in ("bent", "pins")] == [3 * 33, 2 * 3 * 4]
    assert "Factor of safety" in spatial_page(slider)
    assert "about the equilibrium" in spatial_page(still)
    assert "No link bends" in spatial_page(rigid)


def test_model_shows_axes_ups_loads_and_names():
    axes = fm.plot_scene(slider_crank())
    names = {text.get_text() for text in axes.texts}
    assert {"O", "A", "B", "G", "crank", "rod", "block", "press 50.0 N", "load 20.0 g", "coil", "pot"} <= names
    legend = {text.get_text() for text in figure_in(axes).legends[0].get_texts()}
    assert {"ground", "member", "rigid link", "joint's axis", "up of a section", "gravity"} <= legend
    flat = figure_in(axes).axes[0]  # the XY view
    lines = [line.get_xydata() for line in flat.lines if line.get_linestyle() == "-."]
    assert np.ptp(lines[1], axis=0) == pytest.approx([1e3 * 0.18 * 0.3, 0])  # the slider's, along X
    own = figure_in(axes).subplots()
    assert fm.plot_scene(slider_crank(), own) is own


def test_beams_have_their_sections_and_stresses_at_their_corners(rssr, slider):
    animation = pytest.importorskip("fenics_mech.views.space.animation")
    prepare_rendering()
    reading = SpatialReading(rssr)
    stage = animation.SpatialStage(reading, "stress", 1.0, (240, 180), True)
    i, every = 1, slice(None, None, animation.FINER)
    corners = rssr.data["corner_place"][i].to_numpy()
    ring = stage.rings[i](3)[every] - rssr.data["place"][3, i].to_numpy()[:, None]
    assert np.linalg.norm(ring, axis=-1) == pytest.approx(np.tile(np.linalg.norm(corners, axis=1), (11, 1)))
    assert stage.colours[i](3)[every] == pytest.approx(rssr.data["stress"][3, i].to_numpy() / 1e6, abs=1e-9)
    stage.close()
    section = slider.scene.sections["crank"]
    outline = animation.outline_of(section)
    x, y = outline.T
    assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2 == pytest.approx(section.area)


def test_animations_appear_in_every_kind_of_file(slider, rigid, tmp_path):
    for name, result, frames in (("a.png", rigid, 1), ("m.gif", slider, 3)):
        path = fm.animate(result, tmp_path / name, frames=frames, size=(240, 180), names=True)
        assert Image.open(path).size == (240, 180)
    assert Image.open(tmp_path / "m.gif").n_frames == 3
    with pytest.raises(ViewError, match="must end in one of"):
        fm.animate(slider, tmp_path / "m.avi")


@pytest.mark.slow
def test_the_page_is_turned_zoomed_and_readable_on_a_phone(rssr, tmp_path):
    page, picture = fm.report(rssr, tmp_path / "report.html"), "return document.getElementById('mechanism').toDataURL()"
    with browser() as window:
        window.open(page)
        seen = [window.run(picture)]
        for button in ("x", "y", "z", "isometric"):
            window.click(f"#eye-{button}")
            seen.append(window.run(picture))
        window.click("#arrows")
        seen.append(window.run(picture))
        window.choose("#position", 90)
        seen.append(window.run(picture))
        move = "document.getElementById('mechanism').dispatchEvent(new WheelEvent('wheel', { deltaY: -300 }))"
        window.run(move)
        seen.append(window.run(picture))
        assert len(set(seen)) == len(seen)
        window.open(page, size=PHONE)
        assert window.run("return document.documentElement.scrollWidth") == PHONE[0]
        assert window.ask("se/log", type="browser") == []


def test_strokes_are_driven_by_forces_and_a_negative_speed_runs_backwards(slider):
    data = slider_crank().model_dump(by_alias=True)
    post = {"points": {"O": (0, 0, 0), "A": (0, 0, 0.1)}, "members": {"OA": data["links"]["rod"]["members"]["AB"]}}
    post["members"]["OA"] |= {"ends": ("O", "A")}
    arm = {"points": {"A": (0, 0, 0.1)}, "rigid": {"mass": 1.0, "inertia": (1.0, 1.0, 1.0), "centre": (0, 0, 0.1)}}
    joints = {"O": {"connect": ("ground.O", "post.O"), "kind": "slider", "axis": (0, 0, 1)}}
    joints["A"] = {"connect": ("post.A", "arm.A"), "axis": (0, 0, 1)}
    law = {"kind": "harmonics", "sine": (0.03,)}
    drives = [{"joint": "A", "speed": -10.0}, {"joint": "O", "law": law, "period": 0.2 * np.pi}]
    parts = {
        "ground": {"points": {"O": (0, 0, 0)}},
        "links": {"post": post, "arm": arm},
        "joints": joints,
        "drive": drives,
    }
    kept = {key: data[key] for key in ("materials", "sections", "analysis", "damping")}
    result = fm.analyse(SpatialScene.read(kept | parts))
    assert {name: one["unit"] for name, one in key_figures(result)["drives"].items()} == {"A": "N m", "O": "N"}
    push = SpatialReading(result).efforts[:, 1]
    mass = 1.0 + 7800 * slider.scene.sections["rod"].area * 0.1
    assert np.abs(push).max() == pytest.approx(mass * 0.03 * 10.0**2, rel=1e-3)
    page = json.loads(spatial_page(result).partition('id="data">')[2].partition("</script>")[0])
    assert page["direction"] == -1
    assert page["axis"] == sorted(page["axis"])


def test_notebooks_show_scenes_and_results(rssr):
    assert "Mobility 1" in html(rssr.scene)
    assert "Largest deflection" in html(rssr)
    assert "eye-isometric" in fm.interactive(rssr).page


def test_a_motion_in_time_is_told_and_drawn_over_time(tmp_path):
    """The arm falls for a while: nothing closes, and moments are told in seconds."""
    arm = {"points": {"O": (0, 0, 0), "T": (0.5, 0, 0)}}
    arm["members"] = {"OT": {"ends": ("O", "T"), "section": "rod", "material": "steel"}}
    scene = fm.SpatialScene(
        gravity=(0, 0, -9.81),
        ground={"points": {"O": (0, 0, 0)}},
        materials={"steel": {"modulus": "207 GPa", "density": 7800, "poisson": 0.3, "yield": "250 MPa"}},
        sections={"rod": {"shape": "round", "diameter": "8 mm"}},
        damping={"material": "1 ms"},
        links={"arm": arm},
        joints={"O": {"connect": ("ground.O", "arm.O"), "axis": (0, 1, 0)}},
        mesh={"elements": 1},
        analysis={"method": "transient", "duration": 0.2, "positions": 20, "error_estimates": False},
    )
    result = fm.analyse(scene)
    time = result.data["time"].values
    text = " ".join(str(fm.summary(result)).split())
    assert "free motion of 0.200 s" in text
    found = key_figures(result)["joints"]["O"]["time"]
    assert found in time
    assert f"{short(found)} s" in text
    (axes,) = plots.stress_figure(SpatialReading(result)).axes
    assert axes.get_xlabel() == "time (s)"
    assert np.array_equal(axes.lines[0].get_xdata(), time)
    data = json.loads(re.search(r'id="data"[^>]*>(.*?)</script>', spatial_page(result), re.S)[1])
    assert (data["kind"], data["seconds"]) == ("time", pytest.approx(0.2))
    assert data["axis"] == pytest.approx(time)
    assert [path.name for path in fm.plot_all(result, tmp_path, only=["views"])] == ["views.png"]
