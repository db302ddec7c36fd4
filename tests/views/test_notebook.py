"""Scenes and results in a notebook: the tables of the terminal as HTML, with all texts escaped."""

import re
import sys
from html import unescape
from types import SimpleNamespace

import pytest

import fenics_mech as fm
from fenics_mech.recovery import Result
from fenics_mech.views.judgements import judgements, verdict
from fenics_mech.views.notebook import html
from fenics_mech.views.page.report import page
from tests.common import DEMOS

HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)> [red]&amp;"


@pytest.fixture
def shell(monkeypatch):
    """A shell of IPython that keeps what is registered for HTML."""
    known = {}
    formatter = SimpleNamespace(
        for_type_by_name=lambda module, name, function: known.update({(module, name): function})
    )
    running = SimpleNamespace(display_formatter=SimpleNamespace(formatters={"text/html": formatter}))
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: running))
    return known


def text_in(page):
    """The text of HTML, without its tags."""
    return re.sub(r"<[^>]*>", "", page)


def test_a_result_shows_peak_and_verdict(result):
    text = text_in(html(result))
    assert "Peak stress" in text
    assert verdict(judgements(result))[1].partition(":")[0] in text


def test_tags_in_names_are_text(result):
    scene = fm.load(DEMOS / "four_bar.toml").changed(name=HOSTILE)
    named = Result(result.data.assign_attrs(scene=scene.model_dump_json(), title=HOSTILE))
    for shown in (html(scene), html(named)):
        assert set(re.findall(r"</?([a-z]+)", shown)) == {"pre", "span"}
        assert "&lt;script&gt;alert(1)&lt;/script&gt;&lt;img src=x onerror=alert(2)&gt; [red]&amp;amp;" in shown


def test_a_scene_that_cannot_be_assembled_is_shown_with_the_reason():
    scene = fm.load(DEMOS / "four_bar.toml").changed(ground__points={"O": [0, 0], "C": ["1 m", 0]})
    text = text_in(html(scene))
    assert text.startswith("seed four-bar")
    assert "the links cannot be assembled" in text


def test_a_result_without_its_parts_is_shown_with_the_reason(result):
    assert "stress" in text_in(html(Result(result.data.drop_vars("stress"))))


def test_a_running_shell_shows_scenes_and_results_as_html(shell):
    fm._show_in_notebooks()
    for kind in (fm.Scene, fm.Result):
        shown = shell[kind.__module__, kind.__name__]
        assert shown is fm._html
    assert fm._html(fm.load(DEMOS / "four_bar.toml")).startswith("<pre")


def test_without_a_shell_nothing_is_registered(shell, monkeypatch):
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: None))
    fm._show_in_notebooks()
    assert not shell


def test_the_page_stands_in_a_frame_that_can_do_nothing_to_the_notebook(result):
    shown = fm.interactive(result, height=640)._repr_html_()
    (policy,) = re.findall(r'<iframe sandbox="([^"]*)"', shown)
    assert policy.split() == ["allow-scripts", "allow-downloads"]
    assert "height: 640px" in shown
    assert shown.count("<") == 2  # the frame alone: what is in it is escaped
    assert unescape(re.findall(r'srcdoc="([^"]*)"', shown)[0]) == page(result)
    with pytest.raises(fm.ViewError, match="height must be a positive number of pixels, found 0"):
        fm.interactive(result, height=0)
