"""The page of a sweep: what it holds without a script, and in a browser the slider that shows the curves of a point."""

import re

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.cli.report_command import report as write_report
from fenics_mech.errors import StrangeError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.studies.sweep import Sweep
from fenics_mech.studies.sweep import sweep as run_sweep
from fenics_mech.studies.sweep_axes import parse_axes
from fenics_mech.views.page.sweep_page import can_show, sweep_report
from tests.common import DEMOS
from tests.views.browser import DESKTOP, PHONE, browser

SPEEDS = [100.0, 200.0, 300.0, 400.0]  # rpm
CURVE = "return document.querySelector('#curve .curve').getAttribute('d')"
SIDEWAYS = "return document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """A four-bar at four speeds without vibration; the third motion counts as unstable, and the last has no answer."""
    quick = {"analysis.method": "quasi-static", "analysis.sub_intervals": 48, "effects": ()}
    scene = load(DEMOS / "four_bar.toml").changed(quick)
    folder = tmp_path_factory.mktemp("sweep")
    found = run_sweep(scene, parse_axes(scene, ["drive.speed=100 rpm:400 rpm:4"]), folder)
    found.save(folder / "whole.nc")
    data = Sweep.load(folder / "whole.nc").data.copy(deep=True)
    data["unstable"][2], data["error"][3], data["message"][3] = "it <grows>", "NoStableMotion", "none is found"
    for part in data.data_vars.values():
        if part.dtype.kind == "f":
            part[{"drive.speed": 3}] = np.nan
    return Sweep(data)


def test_it_says_without_a_script_what_was_found(sweep, tmp_path):
    text = sweep_report(sweep, tmp_path / "sweep.html").read_text()
    rows = re.findall(r'<th scope="row" class="t">(\d+ rpm)</th>.*?</tr>', text)
    assert rows == [f"{speed:.0f} rpm" for speed in SPEEDS]
    assert re.findall(r">(stable|unstable|no answer)</td></tr>", text) == ["stable", "stable", "unstable", "no answer"]
    assert "1 of 4 points are UNSTABLE" in text
    assert "<grows>" not in text
    assert "://" not in text.replace("http://www.w3.org", "")  # nothing is loaded


def test_sweeps_without_curves_have_no_page(sweep, tmp_path):
    bare = Sweep(sweep.data.drop_dims("curve_theta"))
    assert can_show(sweep)
    assert not can_show(bare)
    with pytest.raises(ViewError, match="keeps no curves"):
        sweep_report(bare, tmp_path / "sweep.html")
    failed = bare.data["error"].copy(data=np.full(len(SPEEDS), "AssemblyError", dtype=object))
    with pytest.raises(ViewError, match="every point of this sweep failed"):
        sweep_report(Sweep(bare.data.assign(error=failed)), tmp_path / "sweep.html")
    with pytest.raises(ViewError, match=r"must end in \.html"):
        sweep_report(sweep, tmp_path / "sweep.txt")


STRANGE = {  # what a stranger's file may hold in place of a sweep's own, and what is said of it
    "no texts": (lambda data: data.drop_vars("effects"), "it lacks effects"),
    "one number": (lambda data: data.assign(peak_stress=1.0), "peak_stress is not a number for each"),
    "a text": (lambda data: data.assign(peak_stress=data["peak_stress"].astype(str)), "peak_stress is not a number"),
    "a curve": (lambda data: data.assign(curve_other=1.0), "'curve_other' is no curve"),
    "no unit": (lambda data: data.assign(bow=(data["bow"].dims, data["bow"].to_numpy())), "bow has no unit"),
    "no points": (lambda data: data.isel({"drive.speed": slice(0)}), "are not finite numbers"),
    "no factor": (lambda data: _written(data, written_factor=0.0), "in which unit"),
    "other members": (lambda data: data.isel(member=slice(1)), "the members of its scene"),
    "no fields": (lambda data: data.assign_attrs(paths="[]"), "the fields that are swept"),
    "not between": (lambda data: data.assign_attrs(between="[]"), "between are none that the program has written"),
    "numbers": (lambda data: _numbers(data, '{"elements": "<b>"}'), "numbers are none that the program has written"),
    "a deep scene": (lambda data: data.assign_attrs(scene="[" * 100_000), "no scene that can be analysed"),
}


def _written(data, **attributes):
    speed = data["drive.speed"]
    return data.assign_coords({"drive.speed": speed.assign_attrs(speed.attrs | attributes)})


def _numbers(data, text):
    return data.assign(numbers=data["numbers"].copy(data=np.full(data["numbers"].shape, text, dtype=object)))


@pytest.mark.parametrize("kind", STRANGE)
def test_strange_files_are_refused_before_anything_is_shown(sweep, kind, tmp_path):
    change, message = STRANGE[kind]
    file, page = Sweep(change(sweep.data).drop_encoding()).save(tmp_path / "sweep.nc"), tmp_path / "page.html"
    with pytest.raises(StrangeError, match=f"cannot be used as a sweep: .*{re.escape(message)}"):
        write_report(file, page)
    assert not page.exists()


def test_names_and_messages_do_not_act_in_the_page(sweep, tmp_path):
    act = "</script><script>alert(1)</script><img src=x onerror=alert(1)>"
    data = sweep.data.copy(deep=True).assign_attrs(title=act)
    for name in ("message", "unstable", "safety_member", "effects", "warnings"):
        data[name][2] = act
    text = sweep_report(Sweep(data), tmp_path / "sweep.html").read_text()
    assert "<script>alert" not in text
    assert "<img src=x" not in text


def test_a_sweep_is_no_result(sweep, tmp_path):
    file = Sweep(sweep.data.drop_encoding()).save(tmp_path / "sweep.nc")
    with pytest.raises(StrangeError, match="it holds a sweep, which `fenics-mech report` shows"):
        Result.load(file)


@pytest.mark.slow
def test_the_slider_shows_the_curves_of_each_point(sweep, tmp_path):
    file = sweep_report(sweep, tmp_path / "sweep.html")
    with browser() as window:
        window.open(file)
        assert window.text("#value") == "200 rpm"  # the largest of the stable ones
        fast, seen = window.run(CURVE), window.text("#curve-where")
        assert "at 200 rpm" in seen
        window.choose("#point", 0)
        assert window.text("#value") == "100 rpm"
        assert window.run(CURVE) != fast
        window.choose("#member", 0)
        window.choose("#unit", "strain")
        assert window.text("#curve-title") == "Strain over the cycle"
        assert window.text("#curve-where").startswith("crank at 100 rpm")
        window.choose("#point", 2)
        assert window.text("#state") == "Unstable: it <grows>"
        assert window.run("return document.querySelectorAll('#over circle.open').length") == 3  # of each member
        window.choose("#point", 3)
        assert "no answer at this point" in window.text("#curve")
        assert window.ask("se/log", type="browser") == []
        for size in (DESKTOP, PHONE):
            window.open(file, size)
            assert window.run(SIDEWAYS) <= 0
