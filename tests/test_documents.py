"""What the documents show is true: commands and snippets run, scenes are scenes, outputs and numbers are today's."""

import importlib
import re
import tomllib
from types import SimpleNamespace

import numpy as np
import pytest

from fenics_mech import Result, SolverError, analyse, load
from fenics_mech._console import out
from fenics_mech.effects import EFFECTS
from fenics_mech.effects.effect import Effect
from fenics_mech.scene import Scene
from fenics_mech.scene.files import parse
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.scene.synthesis_tasks import read_task
from tests import documents
from tests.common import ROOT
from tests.documents import DOCS, blocks

PAGES = {str(page.relative_to(ROOT)): page for page in documents.pages()}
MARKED = [pytest.param(name, marks=pytest.mark.slow) if "tutorial" in name else name for name in PAGES]
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
README, PRESS = ROOT / "README.md", DOCS / "tutorial" / "press.toml"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder in which all commands run, and a memory of what is analysed: many snippets share their scene."""
    folder, known = tmp_path_factory.mktemp("documents"), {}

    def remembered(scene, *args, **named):
        key = scene.model_dump_json()
        if key not in known:
            known[key] = analyse(scene, *args, **named)
        return known[key]

    documents.folder(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("COLUMNS", documents.WIDTH)
        patch.setattr(out, "width", int(documents.WIDTH))  # which tests before these may have fixed
        patch.setattr("fenics_mech.analysis.analyse", remembered)
        patch.setattr("fenics_mech.views.result_figures.plot_all", lambda *args, **named: [])
        yield folder


@pytest.mark.parametrize("name", MARKED)
def test_commands_and_snippets_run_and_print_what_is_shown(name, place):
    for block, said in documents.run(PAGES[name]):
        shown, printed = block.text.split(), said.split()
        assert [NUMBER.sub("#", word) for word in shown] == [NUMBER.sub("#", word) for word in printed]
        for one, other in zip(NUMBER.findall(" ".join(shown)), NUMBER.findall(" ".join(printed))):
            last = 10.0 ** -len(one.partition(".")[2].partition("e")[0])  # two of the last digit, for other machines
            assert float(one) == pytest.approx(float(other), rel=2e-3, abs=2 * last if "e" not in one else 0), (
                block.text
            )


LONG = {name: [c for c in documents.commands(page) if documents.is_long(c)] for name, page in PAGES.items()}


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, long in LONG.items() if set(long) - documents.NOT_RUN.keys()])
def test_long_commands_run(name, whole_place):
    for command in documents.commands(PAGES[name]):
        if command.startswith("sed") or (command in LONG[name] and command not in documents.NOT_RUN):
            assert not re.search(r"^error: ", documents.printed(command, parse=False), flags=re.MULTILINE), command


@pytest.fixture(scope="module")
def whole_place(tmp_path_factory):
    """A folder in which long commands run as they are, and share what they write."""
    folder = tmp_path_factory.mktemp("long")
    documents.folder(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield folder


@pytest.mark.slow
def test_lines_of_progress_on_a_busy_machine_are_in_no_output(place, monkeypatch):
    monkeypatch.setattr("fenics_mech._console.PAUSE", 0)
    assert (
        documents.printed("fenics-mech modes demos/four_bar.toml -o modes | head -1")
        == "Natural frequencies over the cycle\n"
    )


def test_commands_that_no_test_runs_are_known_with_a_reason():
    shown = {command for page in PAGES.values() for command in documents.commands(page)}
    others = {command for command in shown if not command.startswith(("fenics-mech", "sed"))}
    assert others <= documents.NOT_RUN.keys()
    assert documents.NOT_RUN.keys() <= shown
    assert all(documents.NOT_RUN.values())


def test_commands_within_sentences_are_parsed():
    found = [c for page in PAGES.values() for c in re.findall(r"`(fenics-mech \w+ [^`]*)`", page.read_text())]
    assert len(found) > 5
    for command in found:
        assert "Usage" in documents.printed(f"{command} --help")


@pytest.mark.parametrize("name", PAGES)
def test_scenes_are_scenes(name, place):
    demo = tomllib.loads((ROOT / "demos" / "four_bar.toml").read_text())
    space = tomllib.loads((ROOT / "demos" / "space" / "rssr.toml").read_text())
    for block in blocks(PAGES[name]):
        shown = tomllib.loads(block.text) if block.language == "toml" else {}
        if name.endswith("space.md"):
            SpatialScene.read(_merged(space, shown))
        elif isinstance(shown.get("kind"), str):
            assert read_task(shown).kind == shown["kind"]
        elif {"links", "joints"} <= set(shown) or "drawing" in shown:
            assert isinstance(parse(block.text, file=name, folder=place), Scene)
        elif shown and "tutorial" not in name:
            parse(_text(_merged(demo, shown)), file=name, folder=place)


def test_steps_of_the_page_on_space_are_its_demo():
    shown = [block.text for block in blocks(DOCS / "how-to" / "space.md") if block.language == "toml"]
    demo = tomllib.loads((ROOT / "demos" / "space" / "rssr.toml").read_text())
    assert tomllib.loads("\n".join(shown[:4])) == demo


def _merged(demo, shown):
    """The demo with the tables of a fragment in place of its own, or beside them."""
    whole = {key: shown.get(key, value) for key, value in demo.items()}
    for table, content in shown.items():
        keeps = isinstance(content, dict) and table not in ("drive", "damping")
        whole[table] = demo.get(table, {}) | content if keeps else content
    return whole


def _text(data, path=""):
    """TOML of nested tables, as inline tables."""
    return "\n".join(f"{key} = {_value(value)}" for key, value in data.items())


def _value(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{key}" = {_value(one)}' for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    return {True: "true", False: "false"}[value] if isinstance(value, bool) else repr(value)


def test_readme_is_short_and_its_links_lead_somewhere():
    assert len(README.read_text().splitlines()) <= 150
    for name, page in PAGES.items():
        for link in re.findall(r"\]\(([^)#:\s]+)\)|src=\"([^\"]+)\"", page.read_text()):
            target = "".join(link)
            known = "generated" in target or target.endswith("contributing.md") or (page.parent / target).exists()
            assert known, f"{name}: {target}"


def test_readme_python_block_saves_what_it_analyses(place):
    documents.run(README)
    saved = Result.load(place / "result.nc")
    assert saved.scene.analysis.sub_intervals == 120


def test_no_page_is_long():
    for name, page in PAGES.items():
        assert len(page.read_text().splitlines()) <= 250, name


def test_every_effect_is_in_the_table():
    text = (DOCS / "reference" / "effects.md").read_text()
    assert not [name for name in EFFECTS if f"`{name}`" not in text]


def test_section_of_the_contributors_recipe_is_one(place):
    names = vars(importlib.import_module("fenics_mech.scene.sections.plain")).copy()
    exec(_recipe("class EllipseSection"), names)
    section = names["EllipseSection"](width="8 mm", height="4 mm")
    assert section.area == pytest.approx(np.pi * 0.004 * 0.002)


def test_effect_of_the_contributors_recipe_is_the_centrifugal_force(place):
    from fenics_mech import terms
    from fenics_mech.machine.from_scene import machine_of

    names = {name: getattr(terms, name) for name in terms.__all__} | {"Effect": Effect, "np": np}
    names |= {"Array": np.ndarray, "SceneMachine": None}
    exec(_recipe("class Centrifugal"), names)
    made = machine_of(load(place / "demos" / "four_bar.toml").changed(effects=("coupling",)))
    scene = SimpleNamespace(turntable=3.0, rigidity=made.scene.rigidity)
    machine = made.machine
    made.scene = scene
    machine.terms += names["EFFECT"].acting(made).values()
    machine.forget_plan()
    zero = np.zeros((1, machine.size))
    here = machine.residual(np.zeros(1), zero, zero, zero).terms[-1]
    mesh, force = made.links.mesh, -here.response.stress[0].sum(axis=0)
    middles = here.x[0].reshape(len(mesh.cell), 4, 2)[:, [0, 2]].mean(axis=1)
    mass = [scene.rigidity(mesh.members[m], np.zeros(1)).line_density[0] for m in mesh.cell_member] * mesh.cell_length
    assert force == pytest.approx(9.0 * mass @ middles)
    assert names["EFFECT"].stated(scene)


def _recipe(begin):
    """The code of a recipe of CONTRIBUTING.md."""
    return next(block.text for block in blocks(ROOT / "CONTRIBUTING.md") if block.text.startswith(begin))


def test_scotch_yoke_is_pushed_by_its_inertia_and_bent_by_the_pin_beside_its_axis(place):
    shown = next(block.text for block in blocks(DOCS / "how-to" / "sliders_and_slots.md") if "Scotch" in block.text)
    scene = parse(shown).changed(analysis__method="quasi-static", analysis__sub_intervals=24, effects=())
    data = analyse(scene).data
    force = 7800 * 0.015 * 0.0085 * 0.25 * 0.05 * (2 * np.pi * 10) ** 2 * np.cos(data["theta"])
    assert data["joint_force"].sel(joint="A", component="x").to_numpy() == pytest.approx(
        force.to_numpy(), rel=1e-9, abs=1e-9
    )
    moment = force * 0.05 * np.sin(data["theta"])  # about the axis, by which the pin is off it
    strain = data["strain"].sel(member="yoke", s=1, fibre=["+", "-"])
    bending = (strain[:, 0] - strain[:, 1]) / 2
    assert np.abs(bending).to_numpy() == pytest.approx(
        np.abs(moment) * 0.0025 / (207e9 * 0.015 * 0.005**3 / 12), abs=1e-9
    )


def test_parts_of_the_first_page_are_the_scene_of_the_tutorial():
    parts = [block.text for block in blocks(DOCS / "tutorial" / "1_machine.md") if block.language == "toml"]
    assert tomllib.loads("".join(parts)) == tomllib.loads(PRESS.read_text())


@pytest.fixture(scope="module")
def press(place):
    """The largest stress (MPa) of the press by the changes of its scene."""
    import fenics_mech.analysis

    def largest(scene="press.toml", **changes):
        data = fenics_mech.analysis.analyse(load(place / scene).changed(**changes)).data
        return float(np.abs(data["stress"]).max()) / 1e6

    return largest


@pytest.mark.slow
def test_numbers_of_the_tutorial_are_those_of_its_runs(press):
    slow, today, fast = press("slow.toml"), press(), press("fast.toml")
    thicker = press("fast.toml", sections__rocker__height="5 mm")
    pages = {page.stem: page.read_text() for page in (DOCS / "tutorial").glob("*.md")}
    assert f"finds {slow:.0f} MPa" in pages["2_slow_run"]
    assert f"now has {today:.0f} MPa instead of {slow:.0f} MPa" in pages["3_what_matters"]
    assert f"has {fast:.0f} MPa, and 90 MPa are allowed" in pages["5_which_speed"]
    assert f"is then {thicker:.0f} MPa of the 90 MPa" in pages["6_decide"]
    with pytest.raises(SolverError, match=r"unstable.* link rod"):
        press("fast.toml", sections__rocker__height="5 mm", drive__speed="530 rpm")
    stress = press(drive__speed="450 rpm")
    assert re.search(rf"At 450 rpm [^.]* is {stress:.0f} MPa", pages["5_which_speed"])


def test_hand_calculation_of_the_tutorial():
    stress = 6 * 30 * 0.07 / (0.02 * 0.004**2) / 1e6
    assert (round(stress), round(stress * np.sin(np.radians(118.8)), 1)) == (39, pytest.approx(34.4, abs=0.11))


def test_pictures_are_small():
    sizes = [file.stat().st_size for file in (DOCS / "images").glob("*.png")]
    assert max(sizes) < 200e3
    assert sum(sizes) < 3e6
