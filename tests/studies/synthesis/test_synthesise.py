"""Four-bars from what they are to do: against Freudenstein's equation, known linkages, and an analysis of the scene."""

import itertools

import numpy as np
import pytest
from typer.testing import CliRunner

import fenics_mech as fm
from fenics_mech.cli import app
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import load_task
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.synthesis_tasks import read_task
from fenics_mech.scene.writing import write_scene
from fenics_mech.studies.synthesis.path_search import DIMENSIONS, PathFit
from fenics_mech.studies.synthesis.planar_four_bar import FourBar, course_of, three_point_circle

# straight-line linkages in parts of their shortest length: crank, coupler, follower, ground, point, range of the crank
HOEKEN = FourBar(0j, 2 + 0j, 1.0, 2.5, 2.5, 1.0, 5 + 0j)
CHEBYSHEV = FourBar(0j, 2 + 0j, 2.5, 1.0, 2.5, 1.0, 0.5 + 0j)
WATT = FourBar(0j, complex(np.sqrt(17), 0), 2.0, 1.0, 2.0, 1.0, 0.5 + 0j)
FUNCTION = {"crank": ("30 deg", "60 deg", "90 deg"), "follower": ("60 deg", "70 deg", "85 deg")}


def pairs(places):
    return [(float(place.real), float(place.imag)) for place in places]


def test_a_function_generator_fulfils_freudensteins_equation_and_the_scene_moves_so():
    task = fm.FunctionTask(**FUNCTION)
    found = fm.synthesise(task)
    a, b, c, d = found.linkage.crank, found.linkage.coupler, found.linkage.follower, task.ground
    phi, psi = np.array(task.crank), np.array(task.follower)
    k3 = (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    np.testing.assert_allclose(d / a * np.cos(psi) - d / c * np.cos(phi) + k3, np.cos(phi - psi), atol=1e-12)
    assert (found.linkage.kind, found.defects) == ("crank-rocker", ())
    motion = solve_motion(found.scene, phi - phi[0])
    np.testing.assert_allclose(motion.angle[:, list(found.scene.links).index("follower")], psi, atol=1e-9)


def test_a_logarithm_is_generated_between_its_points_too():
    # y = log10(x), 1 <= x <= 2, Chebyshev spacing, 60 deg of crank and follower each; another branch is 10 deg off
    x = np.array([1.0670, 1.5, 1.9330])
    crank = np.radians(45 + 60 * (x - 1))
    follower = np.radians(60 * np.log10(x) / np.log10(2))
    found = fm.synthesise(fm.FunctionTask(crank=tuple(crank), follower=tuple(follower)))
    between = np.linspace(*crank[[0, 2]], 50)
    pins = found.linkage.pins(between)[1]
    made = np.angle((pins - found.linkage.pivot) / found.linkage.follower)
    wanted = np.radians(60 * np.log10((np.degrees(between) - 45) / 60 + 1) / np.log10(2))
    assert 1e-5 < np.abs(made - wanted).max() < np.radians(0.5)


@pytest.mark.parametrize("stated", ["moving", "fixed"])
def test_three_positions_of_a_known_four_bar_give_it_back(stated):
    known = FourBar(0.1 + 0.2j, 0.4 + 0.15j, 0.1, 0.3, 0.25, -1.0, 0.1 + 0.05j)
    first, second = known.pins(np.array([0.4, 0.9, 1.5]))
    along = (second - first) / known.coupler
    at = first + known.point * along
    poses = [{"at": place, "angle": float(angle)} for place, angle in zip(pairs(at), np.angle(along))]
    given = {"moving": pairs([-known.point, known.coupler - known.point]), "fixed": pairs([known.origin, known.pivot])}
    found = fm.synthesise(fm.MotionTask(positions=poses, **{stated: given[stated]}))
    np.testing.assert_allclose(found.linkage.lengths, known.lengths, rtol=1e-9)
    assert found.linkage.point == pytest.approx(known.point, rel=1e-9)
    assert found.linkage.side == known.side
    assert not [one for one in found.defects if one.startswith(("order", "branch"))]
    few = {"analysis.method": "quasi-static", "analysis.sub_intervals": 90, "effects": ()}
    data = fm.analyse(found.scene.changed(few)).data
    path = data["point_position"].sel(point="P").to_numpy()
    for place in pairs(at):
        assert np.linalg.norm(path - place, axis=1).min() < 4e-3  # between two of the positions of the analysis


def test_a_position_on_the_other_branch_is_a_defect():
    known = FourBar(0j, 0.3 + 0j, 0.1, 0.3, 0.25, 1.0)
    other = FourBar(0j, 0.3 + 0j, 0.1, 0.3, 0.25, -1.0)
    angles = np.array([0.4, 0.9, 1.5])
    poses = []
    for linkage, angle in zip((known, known, other), angles):
        first, second = (complex(pin[0]) for pin in linkage.pins(np.array([angle])))
        poses.append({"at": (first.real, first.imag), "angle": float(np.angle(second - first))})
    found = fm.synthesise(fm.MotionTask(positions=poses, moving=[(0, 0), (0.3, 0)]))
    assert any("position 3 is reached with the links assembled the other way" in one for one in found.defects)


def test_order_and_assembly_are_judged_over_the_course():
    assert course_of(HOEKEN, [0.0, 2.0, 4.0])[1] == []
    assert course_of(HOEKEN, [0.0, 2.0, 1.0, 4.0])[1][0].startswith("order")
    assert course_of(WATT, [-0.5, 0.0, 0.5])[1] == []
    assert course_of(WATT, [-0.5, 2.0, 0.5])[1][0].startswith("branch")  # beyond its limits of 0.756


@pytest.mark.parametrize(
    ("lengths", "kind"),
    [
        ((1, 4, 3.5, 3), "crank-rocker"),
        ((4, 1, 3.5, 3), "double rocker"),
        ((3, 4, 1, 3.5), "rocker-crank"),
        ((3, 4, 3.5, 1), "double crank"),
        ((2, 4, 3, 2.5), "triple rocker"),
        ((1, 4, 2, 3), "change point"),
    ],
)
def test_kinds_are_those_of_grashof_and_say_whether_the_crank_turns(lengths, kind):
    crank, coupler, follower, ground = map(float, lengths)
    linkage = FourBar(0j, complex(ground), crank, coupler, follower, 1.0)
    assert linkage.kind == kind
    turns = bool(np.isfinite(linkage.pins(np.linspace(0, 2 * np.pi, 361))[1]).all())
    assert kind == "change point" or turns == linkage.turns


def test_the_centre_of_a_circle_and_of_points_in_line():
    assert three_point_circle([1 + 2j + 3 * np.exp(1j * t) for t in (0.1, 1.0, 4.0)]) == pytest.approx(1 + 2j)
    assert three_point_circle([0j, 1 + 1j, 3 + 3j]) is None


@pytest.mark.parametrize("given", [None, np.linspace(0, 2, 7)])
def test_derivatives_of_the_misfit_are_differences(given):
    random = np.random.default_rng(1)
    fit = PathFit(random.normal(size=7) + 1j * random.normal(size=7), given, -1.0)
    x = random.normal(size=DIMENSIONS + (7 if given is None else 1)) * 0.7
    steps = 1e-6 * np.eye(len(x))
    found = np.stack([(fit.misfit(x + step) - fit.misfit(x - step)) / 2e-6 for step in steps], axis=1)
    np.testing.assert_allclose(fit.jacobian(x), found, atol=1e-6)


def is_a_cognate(linkage, known):
    """Whether a four-bar has the lengths of one of the three that trace one curve (Roberts and Chebyshev)."""
    a, b, c, d = known.lengths
    share = known.point / b
    cognates = [np.array([a, b, c, d]), abs(share) * np.array([b, a, c, d]), abs(1 - share) * np.array([a, c, b, d])]
    either = [np.array(linkage.lengths), np.array(linkage.lengths)[[2, 1, 0, 3]]]
    return any(np.allclose(one, other, rtol=1e-6) for one in either for other in cognates)


@pytest.mark.slow
def test_hoekens_linkage_is_recovered_from_its_coupler_curve():
    places = HOEKEN.points(np.linspace(0, 2 * np.pi, 16, endpoint=False)) * np.exp(0.3j) + 0.1
    found = fm.synthesise(fm.PathTask(path=pairs(places)))
    assert found.error < 1e-9
    assert is_a_cognate(found.linkage, HOEKEN)


@pytest.mark.slow
@pytest.mark.parametrize(("known", "limit"), [(CHEBYSHEV, (-1.7, -0.7)), (WATT, (-0.7, 0.7))])
def test_chebyshevs_and_watts_linkages_are_recovered_from_places_and_angles(known, limit):
    angles = np.linspace(*limit, 12)
    task = fm.PathTask(path=pairs(known.points(angles)), angles=tuple(angles - angles[0]), closed=False)
    found = fm.synthesise(task)
    assert found.error < 1e-9
    assert is_a_cognate(found.linkage, known)


BAD = [
    ({"kind": "functoin"}, "there is no task 'functoin'"),
    ({}, "a task needs its kind"),
    ({"kind": ["function"]}, "there is no task ['function']"),
    (
        {"kind": "function", "crank": [0, 1, 2], "follower": [0, 1, 2], "least_transmission": 2},
        "least_transmission: must",
    ),
    ({"kind": "function", "crank": [0, 1, 2], "follower": [0, 1]}, "3 angles of the crank and 2 of the"),
    ({"kind": "function", "crank": [0, 1, 2], "follower": [0, 1, 2], "grond": 1}, "Did you mean 'ground'"),
    ({"kind": "motion", "positions": [{"at": [0, 0], "angle": 0}] * 3}, "either `moving` or `fixed`"),
    ({"kind": "path", "path": [[0, 0]] * 6, "angles": [0]}, "6 places and 1 angles"),
]


@pytest.mark.parametrize(("data", "said"), BAD, ids=[said for _, said in BAD])
def test_a_bad_task_is_one_message_with_its_place(data, said):
    with pytest.raises(SceneError) as caught:
        read_task(data)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("task", "said"),
    [
        (fm.FunctionTask(crank=(0.5, 0.5, 1.0), follower=(0.2, 0.2, 1.0)), "without an answer"),
        (
            fm.MotionTask(positions=[{"at": (k, 0), "angle": 0} for k in range(3)], moving=[(0, 0), (1, 0)]),
            "moving.0: no four-bar does this: its three places are in line",
        ),
    ],
)
def test_points_that_no_four_bar_passes_are_said(task, said):
    with pytest.raises(SceneError) as caught:
        fm.synthesise(task)
    assert said in str(caught.value)


@pytest.mark.parametrize("command", ["synthesise", "balance", "import"])
def test_what_is_read_is_not_overwritten(tmp_path, command):
    task = tmp_path / "task.toml"
    task.write_text('kind = "function"\ncrank = [0.5, 1.0, 1.5]\nfollower = [1.0, 1.2, 1.5]\n')
    if command == "balance":
        write_scene(seed_four_bar(), task)
    before = task.read_text()
    said = CliRunner().invoke(app, [command, str(task), "-o", str(task)])
    assert said.exit_code != 0
    assert "is the file that is read" in str(said.exception)
    assert task.read_text() == before


def test_an_error_of_a_whole_task_names_the_file_once(tmp_path):
    task = tmp_path / "task.toml"
    poses = "{ at = [0, 0], angle = 0 }, { at = [1, 0], angle = 1 }, { at = [1, 1], angle = 2 }"
    task.write_text(f'kind = "motion"\npositions = [{poses}]\n')
    with pytest.raises(SceneError, match=r"^task\.toml: three positions"):
        load_task(task)


def test_the_command_writes_a_scene_that_can_be_analysed(tmp_path):
    task = tmp_path / "task.toml"
    lines = [f"{key} = {list(value)}" for key, value in FUNCTION.items()]
    task.write_text("\n".join(['kind = "function"', *lines]).replace("'", '"'))
    file, picture = tmp_path / "linkage.toml", tmp_path / "linkage.png"
    said = CliRunner().invoke(app, ["synthesise", str(task), "-o", str(file), "--draw", str(picture)])
    assert said.exit_code == 0, said.output
    assert "Crank-rocker" in said.output
    assert picture.stat().st_size > 10_000
    scene = fm.load(file)
    assert scene.links["crank"].points["A"][0] == pytest.approx(fm.synthesise(load_task(task)).linkage.crank)
    assert fm.analyse(scene).data.attrs["error_estimate"] < 0.05


def test_a_picture_of_an_unknown_kind_is_refused_before_anything_is_written(tmp_path):
    task, file = tmp_path / "task.toml", tmp_path / "made" / "linkage.toml"
    task.write_text('kind = "function"\ncrank = [0.5, 1.0, 1.5]\nfollower = [1.0, 1.2, 1.5]\n')
    said = CliRunner().invoke(app, ["synthesise", str(task), "-o", str(file), "--draw", str(tmp_path / "x.foo")])
    assert said.exit_code != 0
    assert "must end in one of .png, .pdf, .svg" in str(said.exception)
    assert list(tmp_path.iterdir()) == [task]


def test_a_search_is_the_same_each_time():
    places = pairs(0.02 * np.exp(1j * np.linspace(0, 1.5, 6)) + 0.1)
    task = fm.PathTask(path=places, closed=False)
    one, other = (fm.synthesise(task, starts=4, seed=3) for _ in range(2))
    assert one == other


def test_cyclic_orders_of_three_are_all_passed_by_a_turning_crank():
    for order in itertools.permutations((0.0, 2.0, 4.0)):
        assert course_of(HOEKEN, order)[1] == []
