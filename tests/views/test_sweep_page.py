"""The page of a sweep: what it holds without a script, and in a browser the slider that shows the curves of a point."""

import re

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.errors import ViewError
from fenics_mech.studies.sweep import Sweep, run_sweep
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
    with pytest.raises(ViewError, match=r"must end in \.html"):
        sweep_report(sweep, tmp_path / "sweep.txt")


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
