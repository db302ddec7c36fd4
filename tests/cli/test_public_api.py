"""The top level of the package: its names, their documentation, and that every example in it runs."""

import doctest
import inspect
import re
import shutil
from operator import attrgetter
from pathlib import Path

import pytest

import fenics_mech as fm

ROOT = Path(__file__).parents[2]
NAMES = [name for name in dir(fm) if name != "__version__"]
KINDS_OF_ERRORS = [name for name in NAMES if name.endswith("Error") and name not in ("MechanismError", "SceneError")]


def test_the_top_level_gives_everything_that_a_user_needs():
    wanted = "load analyse sweep follow modes refined Scene Link Member Material Ground Drive Result MechanismError"
    sections = "Custom Rectangle Round Tube I Laminate Polygon Variable Taper"
    joints = "Revolute Prismatic Slot Weld"
    loads = "Load LineLoad Impulse LineSpring HingeSpring LineDamper HingeDamper"
    factories = "four_bar slider_crank quick_return manipulator"
    names = [*wanted.split(), *(f"{name}Section" for name in sections.split()), *joints.split(), *loads.split()]
    assert set(names + factories.split()) <= set(NAMES)
    assert sorted(NAMES) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_is_documented(name):
    text = inspect.getdoc(getattr(fm, name))
    assert text is not None
    if name not in KINDS_OF_ERRORS:
        assert "Examples\n--------" in text
        assert "Parameters\n----------" in text


def test_no_name_of_the_top_level_hides_a_room():
    rooms = {room.name for room in Path(fm.__file__).parent.iterdir()}
    assert not rooms & {form for name in NAMES for form in (name, f"{name}.py")}
    import fenics_mech.answers.modes_by_poses as room

    assert inspect.ismodule(room)
    assert inspect.isfunction(fm.modes)


def test_the_version_has_a_section_in_the_changelog():
    released = rf"\[{re.escape(fm.__version__)}\] - \d{{4}}-\d\d-\d\d"
    section = r"\[Unreleased\]" if ".dev" in fm.__version__ else released
    assert re.search(rf"^## {section}$", (ROOT / "CHANGELOG.md").read_text(), re.M)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the demos and a result, as the examples have it."""
    made = tmp_path_factory.mktemp("examples")
    shutil.copytree(ROOT / "demos", made / "demos", ignore=shutil.ignore_patterns("*.png", "*.gif"))
    shutil.copytree(ROOT / "meshes", made / "meshes")
    (made / "out").mkdir()
    scene = fm.load(made / "demos" / "four_bar.toml").changed(
        {"analysis.method": "quasi-static", "analysis.sub_intervals": 90}
    )
    fm.analyse(scene).save(made / "out" / "result.nc")
    return made


EXTRAS = {
    "fatigue": "rainflow",
    "from_pylinkage": "pylinkage",
}  # libraries that examples need beside those of every installation


@pytest.mark.long
@pytest.mark.parametrize("name", [*(name for name in NAMES if name not in KINDS_OF_ERRORS), "Scene.changed"])
def test_the_example_runs(name, folder, monkeypatch):
    pytest.importorskip(EXTRAS.get(name, "numpy"))
    monkeypatch.chdir(folder)
    (example,) = doctest.DocTestFinder(recurse=False).find(attrgetter(name)(fm), name, globs={"fm": fm})
    found = doctest.DocTestRunner(verbose=False).run(example)
    assert found.attempted > 0
    assert found.failed == 0
