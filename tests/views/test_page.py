"""The report of a result: its numbers are those of the result, names of strangers stay texts, and nothing is loaded."""

import base64
import hashlib
import json
import re
import zlib
from html.parser import HTMLParser

import numpy as np
import pytest
import xarray as xr

from fenics_mech import analyse
from fenics_mech.errors import ResultError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.scene import load, parse
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views.judgements import headline, judgements, verdict
from fenics_mech.views.page.curves import MOST, packed, payload
from fenics_mech.views.page.html import Html, json_in_page, table, tag
from fenics_mech.views.page.report import page, report
from fenics_mech.views.reading import Reading
from tests.common import DEMOS, ROOT, analysed

HOSTILE = "</script><img src=x onerror=\"document.title='taken'\">\u2028&amp;'"


class Page(HTMLParser):
    """What a page has: elements with their attributes, its scripts, its texts, and the cells of its tables."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.elements, self.scripts, self.rows, self.said, self._open = [], [], [], "", []
        self.feed(text)

    def handle_starttag(self, name, attributes):
        self.elements.append((name, dict(attributes)))
        self._open.append(name)
        if name == "tr":
            self.rows.append([])
        if name in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, name):
        while self._open and self._open.pop() != name:
            pass

    def handle_data(self, data):
        if self._open and self._open[-1] == "script":
            self.scripts.append(data)
            return
        self.said += data
        if {"td", "th"} & set(self._open):
            self.rows[-1][-1] += data

    def row(self, name):
        """The first row of a table that begins with a name, but for the table of safety."""
        return next(cells for cells in self.rows if cells[0] == name and "wanted" not in cells[-1])


@pytest.fixture(scope="module")
def found(result):
    return Page(page(result))


def number(text):
    """A number as people read it."""
    return float(text.replace("\N{MINUS SIGN}", "-"))


def test_tables_hold_the_peaks_of_the_result(result, found):
    closer = between_positions(result).data
    for member in ("crank", "coupler", "follower"):
        cells, one = found.row(member), closer.sel(member=member)
        stress = one["stress"].to_numpy()
        at = np.unravel_index(np.abs(stress).argmax(), stress.shape)
        assert number(cells[1]) == pytest.approx(1e-6 * stress[at], rel=5e-3)
        assert number(cells[2]) == pytest.approx(1e6 * one["strain"].to_numpy()[at], rel=5e-3)
        assert cells[4] == f"{np.degrees(float(one['theta'][at[0]])):.0f}\N{DEGREE SIGN}"
        bent = np.linalg.norm(one["deflection"], axis=-1)
        swing = result.data["stress_range"].sel(member=member).max()
        assert number(cells[5]) == pytest.approx(1e-6 * float(swing), rel=5e-3)
        assert number(cells[6]) == pytest.approx(1e3 * bent.max(), rel=5e-3)
    force = np.linalg.norm(closer["joint_force"].sel(joint="O"), axis=-1)
    assert number(found.row("O")[1]) == pytest.approx(force.max(), rel=5e-3)
    frequency = result.data["frequency"].sel(mode=2)
    assert number(found.row("2")[2]) == pytest.approx(float(frequency.max()), rel=5e-3)


def test_the_force_on_the_frame_is_told(result, found):
    force = np.linalg.norm(between_positions(result).data["shaking_force"].transpose("theta", "component"), axis=-1)
    assert number(found.row("on the frame")[1]) == pytest.approx(force.max(), rel=5e-3)
    data = payload(Reading(result))
    size = np.linalg.norm(unpacked(data["arrays"]["shaking"]).reshape(-1, 2), axis=-1)
    assert size.max() == pytest.approx(force.max(), rel=1e-3)


def test_a_page_is_told_in_the_units_that_are_asked_for(result):
    inches = result.told_in(["in", "psi", "lbf", "lbf in"])
    cells, usual = Page(page(inches)).row("crank"), Page(page(result)).row("crank")
    assert number(cells[1]) * 6894.757e-6 == pytest.approx(number(usual[1]), rel=1e-2)
    assert number(cells[6]) * 25.4 == pytest.approx(number(usual[6]), rel=1e-2)
    data = payload(Reading(inches, inches.scene.answer_units))
    assert data["units"]["stress"] == "psi"
    assert data["lengths"][1] == pytest.approx(11.0)
    assert not re.search(r"\b(MPa|mm|N m)\b", Page(page(inches)).said.split("The scene, in SI")[0].split("Natural")[0])


def test_forces_act_at_their_pins():
    """A pin through three links transmits two forces; both are drawn at it."""
    result = analysed(
        load(DEMOS / "jansen.toml").changed(
            {"analysis.method": "quasi-static", "analysis.sub_intervals": 8, "analysis.allow_coarse": True}
        )
    )
    data = payload(Reading(result))
    assert data["joints"][1:3] == ["M:left_j", "M:left_k"]
    assert [data["names"][n] for n in data["pin_of"]] == [name.partition(":")[0] for name in data["joints"]]


def test_traced_points_are_drawn_where_the_bent_links_carry_them(result):
    scene = result.scene.changed({"points": {"P": {"at": "coupler@0.5", "offset": (0, 0.06)}}})
    found = analysed(scene)
    data = payload(Reading(found))
    assert data["traced"] == ["P"]
    path = sum(unpacked(data["arrays"][name]) for name in ("traced", "traced_bent"))
    place = found.data["point_position_bent"].sel(point="P").transpose("theta", "component").to_numpy()
    positions = np.abs(np.subtract.outer(15.0 * np.arange(24), data["axis"])).argmin(axis=1)
    assert path[positions] == pytest.approx(place, abs=1e-4)


def test_the_page_begins_with_the_verdict(result, found):
    level, usable = verdict(judgements(result))
    said = " ".join(found.said.split())
    places = [said.index(text) for text in (" ".join(headline(Reading(result))), usable, "largest deflection")]
    assert places == sorted(places)
    assert ("section", {"class": f"verdict {level}"}) in found.elements
    for judged in judgements(result):
        assert " ".join(judged.text.split()) in said


def test_places_are_told_in_words(result):
    """The crank is bent most where it is driven, and the coupler near its middle, which is 11 inches long."""
    reading = Reading(result)
    assert reading.place(reading.peaks[0]) == "at O"
    assert re.fullmatch(r"1[345]\d mm from A", reading.place(reading.peaks[1]))
    assert reading.side(reading.peaks[0]) == "\N{MINUS SIGN} side"
    assert reading.at(0) == "0\N{DEGREE SIGN}"


def unpacked(array):
    """What the script of the page makes of packed numbers."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(array["data"])), dtype=np.uint8).reshape(2, -1)
    differences = (planes[0].astype(np.uint16) | planes[1].astype(np.uint16) << 8).view(np.int16)
    differences = differences.reshape(array["row"], -1 if array["row"] else 0)
    return np.cumsum(np.cumsum(differences, axis=1, dtype=np.int16), axis=1, dtype=np.int16).T * array["scale"]


def test_packed_numbers_are_the_numbers_to_16_bits():
    values = np.random.default_rng(1).normal(size=(50, 3, 2)) * 1e-3
    values[7] = [[1, -1], [1, -1], [1, -1]]  # steps of nearly twice the largest value
    values[8] = -values[7]
    assert unpacked(packed(values)) == pytest.approx(values.reshape(50, 6), abs=1.001 / 2 / 32767)
    assert not unpacked(packed(np.zeros((4, 2)))).any()
    assert not unpacked(packed(np.full((4, 2), np.nan))).any()


def test_what_is_drawn_is_the_result_in_the_order_of_the_angle(result):
    backward = Result(result.data.assign_coords(theta=-result.data["theta"]))
    for one, direction in ((result, 1), (backward, -1)):
        data, reading = payload(Reading(one)), Reading(one)
        assert data["direction"] == direction
        assert (np.diff(data["axis"]) > 0).all()
        stress = unpacked(data["arrays"]["stress"])
        order = np.argsort(np.mod(np.round(reading.theta, 12), 2 * np.pi))
        expected = reading.stress[order].reshape(len(order), -1)
        assert stress == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
        k, j, f = data["peaks"][0]
        flat = (0 * len(reading.s) + j) * 2 + f
        assert abs(stress[k, flat]) == pytest.approx(np.abs(reading.stress[:, 0]).max(), rel=1e-4)


def test_it_loads_nothing_and_runs_its_own_script_only(result, found):
    text = page(result)
    assert set(re.findall(r"https?://[^\"'\s<>)]+", text)) <= {"http://www.w3.org/2000/svg"}
    assert not [e for e in found.elements if {"src", "href", "action"} & set(e[1])]
    assert not [key for _, attributes in found.elements for key in attributes if key.startswith("on")]
    policy = next(a["content"] for name, a in found.elements if a.get("http-equiv") == "Content-Security-Policy")
    script = found.scripts[-1]
    assert base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() in policy
    assert "default-src 'none'" in policy
    assert len(found.scripts) == 2


def hostile(result):
    """The result with hostile texts wherever its file may hold some."""
    scene = json.loads(result.data.attrs["scene"]) | {"name": HOSTILE.replace("\u2028", "")}
    joints = [f"{HOSTILE}{n}" for n in range(result.data.sizes["joint"])]
    sources = [f"{HOSTILE}{source}" if source != "theory" else source for source in result.data["source"].to_numpy()]
    attributes = {"scene": json.dumps(scene), "warnings": json.dumps([HOSTILE]), "not_estimated": HOSTILE}
    return Result(
        result.data.assign_coords(joint=joints, source=sources).assign_attrs(**attributes, fenics_mech=HOSTILE)
    )


def test_hostile_names_stay_texts(result, found):
    text = page(hostile(result))
    taken = Page(text)
    assert [name for name, _ in taken.elements if name == "img"] == []
    assert len(taken.scripts) == 2
    assert json.loads(taken.scripts[0])["joints"][0] == f"{HOSTILE}0"
    assert f"{HOSTILE}0" in [cells[0] for cells in taken.rows]
    assert taken.said.count(HOSTILE) > 5
    assert "\u2028" not in taken.scripts[0]


def test_pieces_of_html_escape_what_is_no_piece():
    assert tag("p", "<b>", tag("b", "&"), title='"') == '<p title="&quot;">&lt;b&gt;<b>&amp;</b></p>'
    assert isinstance(tag("input", id="a", checked=True, disabled=False), Html)
    assert tag("option", "a", value=0) == '<option value="0">a</option>'
    assert "&lt;i&gt;" in table(["a", "b<"], [["<i>", "c"]])
    assert json_in_page({"a": "</script>"}) == '{"a":"\\u003c/script\\u003e"}'


def test_the_demos_page_is_small_and_whole_or_not_there(result, tmp_path):
    path = report(result, tmp_path / "report.html")
    assert path.read_text() == page(result)
    assert path.stat().st_size < 1e6
    with pytest.raises(ViewError, match=r"must end in \.html, not in '\.pdf'"):
        report(result, tmp_path / "report.pdf")
    with pytest.raises(ResultError, match="cannot be written"):
        report(result, tmp_path / "missing" / "report.html")
    assert [file.name for file in tmp_path.iterdir()] == ["report.html"]


def test_results_without_what_is_shown_are_refused(result):
    with pytest.raises(ResultError, match=r"no position.* Analyse its scene again"):
        page(Result(result.data.drop_vars("position")))
    other = result.data.assign_coords(member=["crank", "coupler", "other"])
    with pytest.raises(ResultError, match="not those of the scene"):
        page(Result(other))


@pytest.mark.slow
def test_a_made_up_result_is_shown_or_refused_in_one_line(result, tmp_path):
    """Whatever is missing or of another kind in a file that a stranger may have made."""
    data, refused = result.data, []
    broken = [data.drop_vars(name) for name in data.variables if name not in data.dims]
    broken += [data.drop_dims(name) for name in ("source", "mode", "s", "joint", "member", "fibre")]
    attributes = [{key: value for key, value in data.attrs.items() if key != name} for name in data.attrs]
    attributes += [data.attrs | {name: "[1]"} for name in data.attrs]
    for one in [*broken, *(xr.Dataset(data.variables, attrs=attrs) for attrs in attributes)]:
        try:
            report(Result(one), tmp_path / "report.html")
        except ResultError as error:
            refused.append(str(error))
    assert len(refused) > 20
    assert all(text.isprintable() for text in refused)


def test_static_and_quasi_static_results_have_shorter_pages():
    scene = seed_four_bar(effects=("gravity",), gravity=(0, -9.81), mesh={"elements": 2})
    held = Page(page(analyse(scene.changed(analysis__method="static"))))
    ids = {attributes.get("id") for _, attributes in held.elements}
    assert "mechanism" in ids
    assert not {"position", "curve", "map", "forces", "frequency", "spectrum"} & ids
    assert "held by drive O at 0\N{DEGREE SIGN}" in held.said
    slow = Page(page(analyse(scene.changed(analysis__method="quasi-static", analysis__sub_intervals=24))))
    ids = {attributes.get("id") for _, attributes in slow.elements}
    assert {"position", "curve", "map", "forces"} <= ids
    assert not {"frequency", "stability"} & ids


def free_result():
    """The pendulum of the page on free motion, for a short time."""
    text = (ROOT / "docs" / "how-to" / "free_motion.md").read_text()
    scene = re.search(r"```toml\n(name = \"pendulum\".*?)```", text, flags=re.DOTALL)[1]
    return analysed(parse(scene).changed(analysis__duration=0.02, analysis__sub_intervals=20))


@pytest.mark.slow
def test_a_free_motion_has_a_page_over_time_and_no_drive():
    found = Page(page(free_result()))
    assert "free motion of 0.0200 s" in found.said
    assert "drive torque" not in found.said
    assert re.search(r"Peak stress [\d.]+ MPa in bar, .* at [\d.]+ s", " ".join(found.said.split()))
    data = json.loads(found.scripts[0])
    assert data["kind"] == "time"
    assert len(data["axis"]) == 21


@pytest.mark.slow
def test_long_motions_are_shown_at_some_positions_and_all_peaks():
    result = free_result()
    times = np.linspace(0, 1, 5000)
    long = result.data.interp(theta=np.linspace(float(result.data["theta"][0]), float(result.data["theta"][-1]), 5000))
    long = long.assign_coords(time=("theta", times))
    stress = long["stress"].to_numpy().copy()
    stress[1234] *= 3
    data = payload(Reading(Result(long.assign(stress=(long["stress"].dims, stress)).assign_attrs(result.data.attrs))))
    assert MOST <= len(data["axis"]) < MOST + 10
    assert times[1234].round(9) in data["axis"]
