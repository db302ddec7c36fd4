"""The gallery shows every demo, with the numbers that the program gives today."""

import importlib
import re
import tomllib

import pytest

from tests.common import DEMOS, ROOT, analysed
from tests.documents import DOCS
from tests.test_documents import NUMBER

PAGE = (DOCS / "gallery.md").read_text()
PLANAR = [file for file in sorted(DEMOS.rglob("*.toml")) if file.parent.name != "space"]
NAMES = [str(file.relative_to(DEMOS).with_suffix("")) for file in PLANAR if "plugin" not in str(file)]


@pytest.fixture
def gallery(monkeypatch):
    """The script that makes it."""
    monkeypatch.syspath_prepend(DOCS)
    return importlib.import_module("gallery")


def shown(name):
    """The section of a demo."""
    return next(part for part in PAGE.split("\n## ")[1:] if f"Scene: `demos/{name}.toml`" in part)


def test_the_page_has_every_demo_once_with_its_name_and_picture(gallery):
    assert sorted(gallery.SHOWN) == sorted(NAMES)
    assert sorted(re.findall(r"Scene: `demos/(.*)\.toml`", PAGE)) == sorted(NAMES)
    for name in NAMES:
        title, picture = shown(name).splitlines()[:3:2]
        assert title.lower() == tomllib.loads((DEMOS / f"{name}.toml").read_text())["name"].lower()
        assert f"../demos/{name}.png" in picture
        assert gallery.SHOWN[name].question in shown(name)


def assert_the_same(part, found):
    """Check the words and numbers of a section."""
    one, other = part.split(), found.split()[1:]
    assert [NUMBER.sub("#", word) for word in one] == [NUMBER.sub("#", word) for word in other]
    for old, new in zip(NUMBER.findall(part), NUMBER.findall(found)):
        last = 10.0 ** -len(old.partition(".")[2])  # two of the last digit, for other machines
        assert float(old) == pytest.approx(float(new), rel=2e-3, abs=2 * last)


def test_numbers_of_the_column_are_those_of_the_program(gallery):
    scene = gallery.fm.load(DEMOS / "pulsating_column.toml")
    assert_the_same(shown("pulsating_column"), gallery.section("pulsating_column", analysed(scene)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slider_crank", "counterweighted_rocker", "joint_laws/belt_friction"])
def test_numbers_are_those_of_the_program_with_all_effects_too(gallery, name):
    assert_the_same(shown(name), gallery.section(name, *gallery.results(name)))


@pytest.mark.parametrize("name", NAMES)
def test_demos_that_warn_say_why(name):
    if "Use the numbers with care" in shown(name):
        assert "Its answer warns:" in (DEMOS / f"{name}.toml").read_text()
        assert 'With `effects = "auto"`' in shown(name)
        assert "The computation is accurate" in shown(name)
    assert "Do not use these numbers" not in PAGE


@pytest.mark.parametrize("path", PLANAR, ids=lambda path: path.stem)
def test_demos_let_the_program_choose_effects_or_say_why_not(path):
    text = path.read_text()
    if "[links" in text:  # a scene
        reasons = "It states no effects,", "It lists its effect,", "No link bends,"
        assert 'effects = "auto"' in text.split("[", 1)[0] or any(reason in text for reason in reasons)


def test_pictures_of_the_demos_are_small():
    assert max((DEMOS / f"{name}.png").stat().st_size for name in NAMES) < 200e3
    assert (ROOT / "demos" / "four_bar.png").exists()
