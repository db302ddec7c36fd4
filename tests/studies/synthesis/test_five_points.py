"""Four-bars through five precision points: known linkages are given back, no other is missing, and defects are told."""

import numpy as np
import pytest
from scipy.optimize import root
from typer.testing import CliRunner

import fenics_mech as fm
from fenics_mech.cli import app
from fenics_mech.errors import SceneError
from fenics_mech.studies.synthesis.five_positions import dyads_of_five
from fenics_mech.studies.synthesis.planar_four_bar import FourBar

SEEDS = 40
TURN = 2 * np.pi


def pairs(places):
    return [(float(place.real), float(place.imag)) for place in places]


def known_four_bar(seed):
    """A random four-bar at five angles of its crank that it passes in order, on one branch, within a turn."""
    random = np.random.default_rng(seed)
    while True:
        places = random.normal(size=(3, 2)) @ [1, 1j]
        lengths = np.exp(random.uniform(-1, 1, 3))
        known = FourBar(places[0], places[1], *lengths, float(random.choice([-1.0, 1.0])), places[2])
        angles = random.uniform(0, TURN) + np.cumsum(random.uniform(0.2, 1.0, 5))
        if np.isfinite(known.pins(np.linspace(angles[0], angles[-1], 200))[1]).all():
            return known, angles


def positions(known, angles):
    """Places of the coupler's point, directions of the coupler, and angles of the follower."""
    first, second = known.pins(angles)
    along = (second - first) / known.coupler
    return first + known.point * along, along, np.unwrap(np.angle(second - known.pivot))


def tasks(known, angles):
    at, along, follower = positions(known, angles)
    poses = [{"at": place, "angle": float(angle)} for place, angle in zip(pairs(at), np.angle(along))]
    turned = tuple((angles - angles[0]).tolist())
    return {
        "motion": fm.MotionTask(positions=poses),
        "function": fm.FunctionTask(crank=turned, follower=tuple(follower - follower[0]), ground=known.ground),
        "path": fm.PathTask(path=pairs(at), angles=turned),
    }


def sizes(linkage, kind):
    """What a task of a kind fixes of a linkage: not the place, and of functions not the coupler's point."""
    return np.array([*linkage.lengths, *(() if kind == "function" else (linkage.point.real, linkage.point.imag))])


def test_a_published_straight_line_linkage_is_found():
    """Problem 7 of Morgan and Wampler, J. Mech. Des. 112 (1990) 544: pivots at (0, 0) and (1, 0), five places in line.

    The angles and pins are one of the solutions that PHCpack finds by homotopies, in its example of a four-bar.
    """
    places = np.array([0.5 + 1.06j, -0.83 - 0.27j, -0.34 + 0.22j, -0.13 + 0.43j, 0.22 + 0.78j])
    turned = np.exp(1j * np.array([0, 1.44734213756, 0.928413708131, 0.751699211109, 0.387116282208]))
    found = {complex(np.round(one.pivot, 6)): one.pin for one in dyads_of_five(places, turned)}
    assert len(found) == 3  # the fourth is the point itself, whose pivot is at infinity
    assert found[0] == pytest.approx(-0.0877960434509 - 0.851386907516j, abs=1e-9)  # printed to 12 digits
    assert found[1] == pytest.approx(0.235837391307 - 1.41899202704j, abs=1e-9)


@pytest.mark.parametrize("kind", ["function", "motion", "path"])
def test_five_points_of_random_four_bars_give_them_back(kind):
    for seed in range(SEEDS):
        known, angles = known_four_bar(seed)
        found = fm.four_bars(tasks(known, angles)[kind])
        away = [np.abs(sizes(one.linkage, kind) - sizes(known, kind)).max() / max(known.lengths) for one in found]
        assert min(away) < 1e-9, seed
        assert len(found) in ({1, 3} if kind == "function" else {2, 12})
        back = found[int(np.argmin(away))]
        assert not [one for one in back.defects if not one.startswith("transmission")]


@pytest.mark.parametrize("kind", ["function", "motion", "path"])
def test_all_four_bars_without_defects_pass_all_points(kind):
    passed = 0
    for seed in range(SEEDS):
        known, angles = known_four_bar(seed)
        task = tasks(known, angles)[kind]
        at, along, follower = positions(known, angles)
        for one in fm.four_bars(task):
            if [defect for defect in one.defects if not defect.startswith("transmission")]:
                continue
            linkage, there = one.linkage, one.course.start + np.array(one.course.turned)
            first, second = linkage.pins(there)
            if kind == "function":
                turned = np.exp(1j * (np.angle(second - linkage.pivot) - follower))
                np.testing.assert_allclose(turned, turned[0], atol=1e-7)
            else:
                np.testing.assert_allclose(linkage.points(there), at, atol=1e-7)
            if kind == "motion":
                turned = (second - first) / along
                np.testing.assert_allclose(turned, turned[0], atol=1e-7)
            if kind != "motion":
                np.testing.assert_allclose(
                    np.exp(1j * (there - there[0])), np.exp(1j * (angles - angles[0])), atol=1e-7
                )
            passed += 1
    assert passed > SEEDS


def test_no_pin_on_a_circle_is_missed():
    """Newton's method from 300 random starts finds no other pin, on random positions that may have none."""
    counts = set()
    for seed in range(6):
        random = np.random.default_rng(seed)
        at, turns = random.normal(size=(5, 2)) @ [1, 1j], np.exp(1j * random.uniform(0, TURN, 5))
        found = np.array([[one.pin, one.pivot] for one in dyads_of_five(at, turns)]).reshape(-1, 2)
        counts.add(len(found))

        def change(x, at=at, turns=turns):
            away = np.abs(at + complex(x[0], x[1]) * turns - complex(x[2], x[3])) ** 2
            return away[1:] - away[0]

        for start in random.normal(size=(300, 4)) * 3:
            there = root(change, start, tol=1e-12)
            pin, pivot = complex(*there.x[:2]), complex(*there.x[2:])
            if there.success and np.abs(there.x).max() < 1e3 and np.abs(change(there.x)).max() < 1e-9:
                assert np.abs(found - [pin, pivot]).sum(axis=1).min() < 1e-5
    assert counts >= {2, 4}


def test_five_points_are_nearer_to_a_logarithm_than_three():
    # y = log10(x), 1 <= x <= 2, Chebyshev spacing, 60 deg of crank and follower each
    def worst(count):
        x = 1.5 - 0.5 * np.cos(np.pi * (2 * np.arange(count) + 1) / (2 * count))
        crank, follower = np.radians(45 + 60 * (x - 1)), np.radians(60 * np.log10(x) / np.log10(2))
        errors = []
        for one in fm.four_bars(fm.FunctionTask(crank=tuple(crank), follower=tuple(follower))):
            assert not [defect for defect in one.defects if not defect.startswith("transmission")]
            turned = np.linspace(0, crank[-1] - crank[0], 60) * np.sign(one.course.turned[-1])
            made = np.unwrap(np.angle(one.linkage.pins(one.course.start + turned)[1] - one.linkage.pivot))
            wanted = np.radians(60 * np.log10(x[0] + np.degrees(turned) / 60) / np.log10(2))
            errors.append(np.abs(made - made[0] - wanted + wanted[0]).max())
        return min(errors)

    assert np.degrees(worst(5)) < 0.01 < 0.3 < np.degrees(worst(3))


def test_a_position_that_is_reached_on_the_other_branch_only_is_told():
    known, angles = known_four_bar(1)
    other = FourBar(known.origin, known.pivot, *known.lengths[:3], -known.side, known.point)
    at, along, _ = positions(known, angles)
    there, turned, _ = positions(other, angles)
    at[4], along[4] = there[4], turned[4]
    poses = [{"at": place, "angle": float(angle)} for place, angle in zip(pairs(at), np.angle(along))]
    found = fm.four_bars(fm.MotionTask(positions=poses))
    (back,) = [one for one in found if np.allclose(one.linkage.lengths, known.lengths, rtol=1e-8)]
    assert "position 5 is reached with the links assembled the other way only" in back.defects[0]
    assert found.index(back) > 0 or all(one.defects for one in found)  # the best have the fewest defects
    assert [len(one.defects) for one in found] == sorted(len(one.defects) for one in found)


BAD = [
    (lambda: fm.FunctionTask(crank=(0, 1, 2, 3), follower=(0, 1, 2, 3)), "there are 4 angles: give 3 or 5"),
    (lambda: fm.FunctionTask(crank=(0, 1, 2), follower=(0, 1)), "3 angles of the crank and 2 of the follower"),
    (lambda: fm.MotionTask(positions=[{"at": (k, 0), "angle": k} for k in range(4)]), "there are 4 positions"),
    (
        lambda: fm.MotionTask(positions=[{"at": (k, 0), "angle": k} for k in range(5)], moving=[(0, 0), (1, 0)]),
        "five positions leave no pin open",
    ),
    (lambda: fm.PathTask(path=[(k, k * k) for k in range(5)]), "five places need `angles`"),
    (
        lambda: fm.four_bars(fm.MotionTask(positions=[{"at": (k * 1e-320, 0), "angle": k / 9} for k in range(5)])),
        "these places are 2e-320 m apart",
    ),
    (
        lambda: fm.four_bars(fm.FunctionTask(crank=(0, 0.2, 0.4, 0.6, 0.8), follower=(0, 0.15, 0.32, 0.52, 0.75))),
        "no pin of the follower stays at one distance",
    ),
    (
        lambda: fm.four_bars(fm.MotionTask(positions=[{"at": (k, k * k), "angle": 0.3} for k in range(5)])),
        "do not fix the pins",
    ),
    (
        lambda: fm.four_bars(fm.PathTask(path=[(k, 0) for k in range(5)], angles=[0.01 * k for k in range(5)])),
        "a link has no length or 1000 times",
    ),
    (
        lambda: fm.four_bars(fm.MotionTask(positions=[{"at": (k % 4, k % 4), "angle": k % 4} for k in range(5)])),
        "do not fix the pins",
    ),
]


@pytest.mark.parametrize(("make", "said"), BAD, ids=[said for _, said in BAD])
def test_points_that_no_four_bar_can_have_are_one_message(make, said):
    with pytest.raises(SceneError) as caught:
        make()
    assert said in str(caught.value)


def test_positions_without_two_pins_on_circles_are_said():
    random, none = np.random.default_rng(0), []
    while not none:
        at, angles = random.normal(size=(5, 2)), random.uniform(0, TURN, 5)
        if not dyads_of_five(at @ [1, 1j], np.exp(1j * angles)):
            none = [{"at": tuple(place), "angle": angle} for place, angle in zip(at, angles)]
    with pytest.raises(SceneError, match="positions: no four-bar does this: fewer than two pins"):
        fm.four_bars(fm.MotionTask(positions=none))


def test_the_command_lists_all_and_writes_the_one_that_is_taken(tmp_path):
    known, angles = known_four_bar(3)
    at, along, _ = positions(known, angles)
    rows = [f"{{ at = {list(place)}, angle = {angle} }}" for place, angle in zip(pairs(at), np.angle(along))]
    task, file = tmp_path / "task.toml", tmp_path / "linkage.toml"
    task.write_text(f'kind = "motion"\npositions = [{", ".join(rows)}]\n')
    found = fm.four_bars(fm.load_task(task))
    picture = tmp_path / "linkage.png"
    said = CliRunner().invoke(app, ["synthesise", str(task), "-o", str(file), "--take", "2", "--draw", str(picture)])
    assert said.exit_code == 0, said.output
    assert f"{len(found)} four-bars do this; number 2 is written" in " ".join(said.output.split())
    assert fm.load(file).links["crank"].points["A"][0] == pytest.approx(found[1].linkage.crank)
    assert picture.stat().st_size > 10_000


def test_a_four_bar_that_there_is_not_is_not_taken(tmp_path):
    task, file = tmp_path / "task.toml", tmp_path / "linkage.toml"
    task.write_text('kind = "function"\ncrank = [0.5, 1.0, 1.5]\nfollower = [1.0, 1.2, 1.5]\n')
    said = CliRunner().invoke(app, ["synthesise", str(task), "-o", str(file), "--take", "2"])
    assert said.exit_code != 0
    assert "there is 1 four-bar for this task" in str(said.exception)
    assert not file.exists()
