"""The report in a browser: clicks and drags are followed, and it is readable narrow, printed, and without script."""

import math
import re
import time

import pytest

from fenics_mech.recovery import Result
from fenics_mech.scene import parse
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views.notebook import interactive
from fenics_mech.views.page.report import report
from tests.common import analysed
from tests.studies.test_rigid_linkages import FOUR_BAR
from tests.views.browser import DESKTOP, PHONE, browser
from tests.views.test_page import free_result, hostile

pytestmark = pytest.mark.slow
PROFILE = "return document.querySelector('#along .curve').getAttribute('d')"
SIDEWAYS = "return document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.fixture(scope="module")
def window():
    with browser() as started:
        yield started


@pytest.fixture(scope="module")
def file(result, tmp_path_factory):
    return report(result, tmp_path_factory.mktemp("pages") / "report.html")


def seen(window, selector):
    return window.run("return document.querySelector(arguments[0]).getClientRects().length > 0", selector)


def picture(window, name="mechanism"):
    """The picture on a canvas, as a text."""
    return window.run(f"return document.getElementById('{name}').toDataURL()")


def test_it_opens_in_two_seconds_at_the_peak(window, file):
    window.open(file)
    assert float(window.run("return document.body.dataset.ready")) < 2000
    assert window.text("#told") == "15°"
    assert window.text("#curve-title") == "Stress at the peak\N{RIGHT SINGLE QUOTATION MARK}s place"
    assert window.text("#curve-where").startswith("crank, at O, ")
    assert window.run("return document.querySelectorAll('#forces figure').length") == 5  # with that on the frame
    ring = "return document.querySelector('#curve [data-at]').style.visibility"
    assert window.run(ring) == "hidden"  # the value above the plot is that of the peak
    window.choose("#position", 100)
    assert window.run(ring) == ""
    assert window.ask("se/log", type="browser") == []


def test_it_works_in_the_frame_of_a_notebook(window, result, tmp_path):
    ready = "<script>onload = () => document.body.dataset.ready = 1</script>"
    note = tmp_path / "notebook.html"
    note.write_text(f"<!DOCTYPE html><meta charset=utf-8>{interactive(result)._repr_html_()}{ready}", encoding="utf-8")
    window.open(note)
    window.ask("frame", id=0)
    try:
        end = time.monotonic() + 20
        while not window.run("return document.body.dataset.ready") and time.monotonic() < end:
            time.sleep(0.02)
        window.choose("#position", 180)
        assert window.text("#told") == "180\N{DEGREE SIGN}"
        assert window.run("return document.querySelectorAll('#forces figure').length") == 5
    finally:
        window.ask("frame", id=None)


def test_all_follow_the_slider_and_the_arrow_keys(window, file):
    window.open(file)
    before = (picture(window), window.text("#forces figcaption"), window.run(PROFILE))
    window.choose("#position", 180)
    assert window.text("#told") == "180°"
    assert float(window.run("return document.getElementById('dock-position').value")) == pytest.approx(180)
    after = (picture(window), window.text("#forces figcaption"), window.run(PROFILE))
    assert not set(before) & set(after)
    assert "at 180°" in window.text("#curve")
    window.click("#to-peak")
    assert window.text("#told") == "15°"
    assert picture(window) == before[0]


def test_the_slider_ends_at_a_peak_just_before_360_degrees(window, file, tmp_path):
    """Angles have four decimals, so that such a position has no distance to the start of the next turn."""
    page, count = re.subn(r'("axis": ?\[[^]]*, ?)[0-9.]+\]', r"\g<1>360.0]", file.read_text(encoding="utf-8"))
    assert count == 1
    (tmp_path / "report.html").write_text(page, encoding="utf-8")
    window.open(tmp_path / "report.html")
    window.choose("#position", 360)
    assert window.text("#told") == "0°"


def test_a_plot_is_dragged(window, file):
    window.open(file)
    script = (
        "const e = document.querySelector('#curve svg'), r = e.getBoundingClientRect(); "
        "const x = r.left + arguments[0] * r.width; "
        "for (const type of ['pointerdown', 'pointerup']) "
        "e.dispatchEvent(new PointerEvent(type, { clientX: x, clientY: r.top + 50, pointerId: 1, bubbles: true }))"
    )
    window.run("Element.prototype.setPointerCapture = () => {}")
    window.run(script, 0.6)
    assert 180 < float(window.text("#told").rstrip("°")) < 250


def test_members_and_units_are_chosen(window, file):
    window.open(file)
    window.click("tr[data-member='2']")
    assert window.run("return document.getElementById('member').value") == "2"
    assert window.text("#curve-where").startswith("follower")
    assert window.run("return document.querySelector('tr.chosen').dataset.member") == "2"
    window.choose("#unit", "strain")
    assert window.text("#curve-title").startswith("Strain")
    assert "µm/m" in window.text("#curve")
    window.choose("#member", 1)
    assert window.text("#along-where").startswith("coupler")


HOVER = (
    "const e = document.querySelector(arguments[0] + ' svg'), r = e.getBoundingClientRect(); "
    "const w = e.viewBox.baseVal.width, box = arguments[1]; "
    "e.dispatchEvent(new PointerEvent('pointermove', { clientX: r.left + r.width * box / w, "
    "clientY: r.top + r.height * arguments[2], bubbles: true })); "
    "return e.parentElement.querySelector('.tip').innerText"
)
WIDTH = "return document.querySelector(arguments[0] + ' svg').viewBox.baseVal.width"


def test_the_pointer_reads_the_curves(window, file, result):
    """The axes of the angle reach from 52 to 12 before the end of a plot: half way between is 180 degrees."""
    window.open(file)
    middle = (52 + window.run(WIDTH, "#effort") - 12) / 2
    angle, value = window.run(HOVER, "#effort", middle, 0.5).split("\n")
    assert angle == "180°"
    known = float(result.data["input_torque"].sel(theta=math.pi, method="nearest"))
    assert float(value.removesuffix(" N m").replace("\N{MINUS SIGN}", "-")) == pytest.approx(known, rel=5e-3)
    modes = window.run(HOVER, "#frequency", (52 + window.run(WIDTH, "#frequency") - 64) / 2, 0.5).split("\n")
    lowest = result.data["frequency"].sel(theta=math.pi, method="nearest").to_numpy()[0]
    assert modes[0] == "180°"
    assert float(modes[1].removeprefix("mode 1 ").removesuffix(" Hz")) == pytest.approx(lowest, rel=5e-3)
    assert "times the drive" in window.run(HOVER, "#spectrum", middle, 0.5)
    assert " mm from O: " in window.run(HOVER, "#map", middle, 0.5)
    assert re.match(r"\d+°: [\d.]+ N ", window.run(HOVER, "#forces figure", 0, 0.5))
    gone = "const e = document.querySelector('#effort svg'); e.dispatchEvent(new PointerEvent('pointerleave')); "
    assert window.run(gone + "return e.parentElement.querySelector('.tip').hidden")
    assert window.ask("se/log", type="browser") == []


def test_section_forces_are_shown_at_the_place_and_beside_another_member(window, file, result):
    window.open(file)
    assert window.run("return document.querySelectorAll('#sections svg').length") == 3
    window.choose("#unit", "moment")
    assert window.text("#curve-title") == "Bending moment at its largest"
    assert window.text("#curve-where") == "crank, at O"
    moment = result.data["moment"].sel(member="crank").isel(s=0)
    follower = abs(result.data["moment"].sel(member="follower")).max("theta")
    window.choose("#member", 2)
    at = 1e3 * result.scene.links["follower"].points["B"][0] * float(follower["s"][int(follower.argmax())])
    assert window.text("#curve-where") == f"follower, {at:.0f} mm from C"
    window.choose("#member", 0)
    window.choose("#position", 90)
    text = window.run(HOVER, "#along", 53, 0.5).split("\n")[1]
    told = float(text.split(",")[0].replace("\N{MINUS SIGN}", "-"))
    assert told == pytest.approx(float(moment.sel(theta=math.pi / 2, method="nearest")), rel=0.02)  # a pixel beside O
    window.choose("#other", 1)
    assert "orange: coupler" in window.text("#along-where")
    assert window.run("return document.querySelectorAll('#along .curve').length") == 2
    assert window.run("return document.querySelectorAll('#sections .curve').length") == 6
    lines = window.run(HOVER, "#along", 53, 0.5).split("\n")
    assert [line.split()[0] for line in lines[1:]] == ["crank", "coupler"]
    window.choose("#other", -1)
    assert window.run("return document.querySelectorAll('#along .curve').length") == 1


def test_loads_and_weight_are_drawn(window, tmp_path):
    scene = seed_four_bar(
        analysis={"method": "quasi-static", "sub_intervals": 24},
        gravity=(0.0, -9.81),
        loads={"push": {"at": "coupler.B", "force": (30.0, -40.0)}},
    )
    window.open(report(analysed(scene), tmp_path / "report.html"))
    before = picture(window)
    window.click("#acting")
    assert picture(window) != before
    window.click("#acting")
    assert picture(window) == before
    assert window.ask("se/log", type="browser") == []


def test_clicks_in_the_drawing_choose_members(window, file):
    """Clicks all over it meet each member; far from all of them the choice stays."""
    window.open(file)
    chosen = window.run(
        "const box = document.getElementById('mechanism').getBoundingClientRect(), found = []; "
        "for (let x = 0; x < box.width; x += 20) for (let y = 0; y < box.height; y += 20) { "
        "document.getElementById('mechanism').dispatchEvent("
        "new MouseEvent('click', { clientX: box.left + x, clientY: box.top + y })); "
        "found.push(document.getElementById('member').value); } return found"
    )
    assert set(chosen) == {"0", "1", "2"}
    assert chosen[0] == "0"  # the corner of the drawing is far from all


def test_deflection_is_magnified_and_forces_are_drawn(window, file):
    window.open(file)
    plain = picture(window)
    window.choose("#magnify", 0)
    assert window.text("#times") == "0 times"
    assert picture(window) != plain
    window.open(file)
    window.click("#arrows")
    assert picture(window) != plain


def test_play_moves_it_and_stops(window, file):
    window.open(file)
    window.click("#play")
    first = window.run("return +document.getElementById('position').value")
    window.run("window.ticks = 0; (function tick() { window.ticks++; requestAnimationFrame(tick); })()")
    for _ in range(200):
        if window.run("return window.ticks") > 10:
            break
    assert window.run("return +document.getElementById('position').value") != first
    window.click("#play")
    assert window.text("#play") == "▶"


def test_the_curve_is_saved_as_a_table(window, file):
    window.open(file)
    window.run(
        "const made = URL.createObjectURL; URL.createObjectURL = blob => { window.saved = blob; return made(blob); }"
    )
    window.run("HTMLAnchorElement.prototype.click = function () { window.named = this.download; }")
    window.click("#csv")
    text = window.ask("execute/async", script="window.saved.text().then(arguments[0])", args=[])
    head, first, *rest = text.splitlines()
    assert head.startswith('"drive angle (deg)","crank, at O, ')
    assert 360 < len(rest) + 1 < 400  # with the peaks of all members and joints
    assert first.startswith("0,")
    assert window.run("return window.named") == "seed_four-bar_crank_stress.csv"


def test_dark_and_light(window, file):
    ground = "return getComputedStyle(document.body).backgroundColor"
    window.open(file, color_scheme="dark")
    dark, drawn = window.run(ground), picture(window)
    assert dark == "rgb(15, 19, 24)"
    window.click("#theme")
    assert window.run(ground) == "rgb(244, 245, 247)"
    assert picture(window) != drawn
    window.open(file, color_scheme="light")
    assert window.run(ground) == "rgb(244, 245, 247)"


def test_a_phone_scrolls_downwards_only_and_has_its_controls_at_the_edge(window, file):
    window.open(file, PHONE)
    assert window.run(SIDEWAYS) == 0
    wider = "return [...document.querySelectorAll('.scroll')].map(e => e.scrollWidth - e.clientWidth)"
    assert set(window.run(wider)) == {0}  # tables are seen whole
    assert window.run("return getComputedStyle(document.querySelector('.dock')).display") == "flex"
    window.choose("#dock-position", 90)
    assert window.text("#told") == window.text("#dock-told") == "90°"
    window.open(file, DESKTOP)
    assert not seen(window, ".dock")


def test_without_script_the_tables_are_there(window, file):
    window.open(file, script=False)
    source = window.protocol("DOM.getDocument", depth=1)["root"]["nodeId"]

    def box(selector):
        node = window.protocol("DOM.querySelector", nodeId=source, selector=selector)["nodeId"]
        style = window.protocol("CSS.getComputedStyleForNode", nodeId=node)["computedStyle"]
        return {one["name"]: one["value"] for one in style}["display"]

    window.protocol("DOM.enable")
    window.protocol("CSS.enable")
    source = window.protocol("DOM.getDocument", depth=1)["root"]["nodeId"]
    assert box("#members") == "table"
    assert box(".stage") == "none"
    assert box(".tools") == "none"
    assert box("noscript") != "none"


def test_on_paper_there_are_no_controls(window, file):
    window.open(file)
    window.protocol("Emulation.setEmulatedMedia", media="print")
    assert not any(seen(window, selector) for selector in (".controls", ".tools", ".pick", "details.scene"))
    assert seen(window, "#members")
    window.protocol("Emulation.setEmulatedMedia", media="")


def test_hostile_names_run_nothing(window, result, tmp_path):
    window.open(report(hostile(result), tmp_path / "hostile.html"))
    assert "taken" not in window.run("return document.title").split(": report")[1]
    assert window.run("return document.images.length") == 0
    assert "onerror" in window.text("#forces figure:nth-child(2) figcaption")
    assert window.ask("se/log", type="browser") == []


def test_a_motion_in_time_has_a_time_axis(window, tmp_path):
    window.open(report(free_result(), tmp_path / "free.html"))
    window.choose("#position", 0.01)
    assert window.text("#told") == "0.0100 s"
    assert "time (s)" in window.text("#curve")
    window.choose("#position", 0.02)
    assert window.text("#told") == "0.0200 s"


def test_rigid_links_move_and_show_their_forces(window, tmp_path):
    window.open(report(analysed(parse(FOUR_BAR)), tmp_path / "rigid.html"))
    assert window.ask("se/log", type="browser") == []
    assert window.run("return document.querySelectorAll('#forces figure').length") == 5
    before = picture(window), window.text("#told")
    window.choose("#position", 180)
    assert window.text("#told") == "180°"
    assert picture(window) != before[0]
    window.click("#to-peak")
    assert (picture(window), window.text("#told")) == before


@pytest.mark.parametrize(
    ("period", "told"),
    [(0.1945, "Played 31 times slower than"), (40.0, "Played 6.7 times faster than"), (6.0, "Played as fast as")],
)
def test_the_pace_of_the_picture_is_told_the_right_way_round(window, result, tmp_path, period, told):
    """A turn takes 6 s on the page."""
    scene = result.scene.changed({"drive.speed": 2 * math.pi / period}).model_dump_json()
    window.open(report(Result(result.data.assign_attrs(scene=scene)), tmp_path / "pace.html"))
    assert window.text("#hint").startswith(f"{told} the machine. Drag in any plot")
