"""Rigid arms that carry force: the moment of force x arm x turn is in the equation of poses."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from fenics_mech import SolverError, load
from fenics_mech.scene import Scene
from fenics_mech.views.judgements import judgements, verdict
from tests.cases.elastica import cantilever_with_arm
from tests.common import analysed

SCENES = Path(__file__).parent / "scenes"
COLUMN, CANTILEVER = load(SCENES / "rigid_arm_column.toml"), load(SCENES / "rigid_arm_cantilever.toml")
LENGTH, EI, EA = 0.2, 207e9 * 0.02 * 0.003**3 / 12, 207e9 * 0.02 * 0.003


def critical(elastic, rigid):
    """Give the buckling load of a clamped column under a rigid arm, k b tan(k a) = 1 with k^2 = P/EI."""
    k = brentq(lambda k: k * rigid * np.tan(k * elastic) - 1, 1e-6, np.pi / 2 / elastic * (1 - 1e-9))
    return EI * k**2


def column(share, side=1e-3, arm=0.2, solver="auto", **analysis):
    """Give the column under a share of its buckling load, and so much of that across."""
    force = share * critical(LENGTH, arm)
    return COLUMN.changed(
        loads__F__force=(-force, side * force), links__arm__points__T=(arm, 0.0), analysis=analysis, effects="auto"
    ).changed(analysis__method="static", analysis__solver=solver)


def cantilever(arm, force=(0.0, -20.0), solver="auto", **options):
    changed = {"tolerance": None, "analysis__solver": solver, "links__arm__points__T": arm, "loads__F__force": force}
    return CANTILEVER.changed(**changed, **options)


def tip(result):
    return result.data["deflection"].sel(member="beam").isel(theta=0, s=-1).to_numpy()


def test_stiff_member_in_place_of_the_arm_buckles_where_it_should():
    """It is what the refusal advises: the tip under half of the load is the elastica's, to the mesh of 10 elements."""
    given = column(0.5).model_dump()
    given["links"]["arm"] = {
        "points": {"A": (0, 0), "T": (0.2, 0)},
        "members": {"AT": {"ends": ("A", "T"), "section": "stiff", "material": "m"}},
    }
    force = 0.5 * critical(LENGTH, 0.2)
    _, (_, y, _) = cantilever_with_arm((-force, 1e-3 * force), (0.2, 0.0), LENGTH, EI, EA)
    assert tip(analysed(Scene.read(given)))[1] == pytest.approx(y, rel=1e-3)  # the arm's EI is 8000 times the beam's


@pytest.mark.parametrize(("share", "right"), [(0.5, 1.214e-4), (0.9, 1.078e-3)])
def test_column_deflects_as_the_elastica(share, right):
    """The printed values are of the reference, which the elastica of this test gives again."""
    force = share * critical(LENGTH, 0.2)
    _, (_, y, _) = cantilever_with_arm((-force, 1e-3 * force), (0.2, 0.0), LENGTH, EI, EA)
    assert y == pytest.approx(right, rel=5e-4)  # its four digits
    result = analysed(column(share, solver="poses"))
    assert tip(result)[1] == pytest.approx(y, rel=1e-3)  # 10 elements
    assert "joints" not in result.data["source"]


@pytest.mark.parametrize(
    ("share", "side", "effects"),
    [(3.0, 1e-3, ("geometric-stiffness",)), (1.02, 0.0, ("geometric-stiffness",)), (1.02, 0.0, "auto")],
)
def test_column_is_refused_above_its_buckling_load_by_poses(share, side, effects):
    assert analysed(column(0.97, 0.0, solver="poses").changed(effects=effects))
    with pytest.raises(SolverError, match=r"the mechanism buckles"):
        analysed(column(share, side, solver="poses").changed(effects=effects))


@pytest.mark.parametrize("theory", [(), ("geometric-stiffness",), ("large-rotations",)])
@pytest.mark.parametrize(
    ("arm", "force"),
    [((0.0, -0.1), (0.0, -8.0)), ((0.0, 0.1), (0.0, -8.0)), ((0.05, 0.03), (-3.0, -8.0)), ((-0.04, 0.1), (2.0, 9.0))],
)
def test_arms_are_exact_by_poses_and_linear_theories_told(arm, force, theory):
    result = analysed(cantilever(arm, force, "poses", effects=theory))
    root, (x, y, _) = cantilever_with_arm(force, arm, LENGTH, EI, EA)
    missing = np.hypot(*(tip(result) - [x - LENGTH, y])) / np.hypot(x - LENGTH, y)
    of_root = abs(result.data["moment"].isel(theta=0, member=0, s=0).item() / root - 1)
    if theory == ("large-rotations",):
        assert missing < 1e-4  # 10 elements
        assert of_root < 1e-4
    else:
        assert 0.8 < float(result.data.attrs["deflection_error_estimate"]) / missing < 3


@pytest.mark.parametrize(
    ("arm", "force"),
    [((0.0, -0.1), (0.0, -0.1)), ((0.0, 1e-4), (0.0, -20.0)), ((0.0, -0.1), (-20.0, 0.0))],
    ids=["small turn", "small arm", "force across the arm"],
)
def test_small_arms_and_turns_are_not_warned_of(arm, force):
    level, said = verdict(judgements(analysed(cantilever(arm, force))))
    assert level == "good"
    assert "inside the theory" in said


def test_arms_up_and_down_differ():
    """By 4.3 % of the root moment."""
    found = [
        abs(analysed(cantilever((0, y), solver="poses")).data["moment"].isel(theta=0, member=0, s=0).item())
        for y in (0.1, -0.1)
    ]
    right = [abs(cantilever_with_arm((0.0, -20.0), (0.0, y), LENGTH, EI, EA)[0]) for y in (0.1, -0.1)]
    assert right[0] / right[1] - 1 == pytest.approx(0.0438, abs=5e-4)
    assert found == pytest.approx(right, rel=1e-3)  # 10 elements


def turning(speed, **options):
    """Give a beam of 0.3 m that turns about its clamped end, with a body of 0.5 kg on a rigid arm of 0.15 m."""
    given = CANTILEVER.changed(tolerance=None).model_dump()
    given |= {
        "effects": ("coupling", "geometric-stiffness"),
        "loads": {},
        "drive": {"joint": "O", "speed": speed},
        "damping": {"ratio": 0.01},
        "mesh": {"elements": 8},
        "analysis": {"sub_intervals": 60},
    }
    given["links"] = {
        "beam": {"points": {"O": (0, 0), "A": (0.3, 0)}, "members": given["links"]["beam"]["members"]},
        "arm": {
            "points": {"A": (0, 0), "T": (0.15, 0)},
            "rigid": {"mass": 0.5, "inertia": 1e-9, "centre": (0.15, 0)},
        },
    }
    return Scene.read(given).changed(**options)


def in_plane(result):
    return 2 * np.pi * float(result.data["multiplier_frequency"][0])


@pytest.mark.parametrize(("speed", "right"), [(20.0, 26.371), (60.0, 33.407), (120.0, 43.985)])
def test_frequency_of_a_turning_beam_with_a_rigid_tip_is_right_by_poses(speed, right):
    """Right by Ritz's method with cubic functions for the beam and an exact rigid body, converged to its digits."""
    result = analysed(turning(speed, analysis__solver="poses"))
    assert in_plane(result) == pytest.approx(right, rel=2e-4)
