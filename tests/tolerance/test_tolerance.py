"""Scenes that state an accuracy: the true error is below it, and not far below."""

import math
from pathlib import Path

import numpy as np
import pytest

import fenics_mech.tolerance
from fenics_mech import analyse, load
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.scene.build import build
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.meshing import with_elements
from fenics_mech.views.report import _between_positions

DEMOS = Path(__file__).parents[2] / "demos"
TAPERED = {"shape": "variable", "area": "4e-5*(1 - 0.5*s)", "inertia": "8e-12*(1 - 0.5*s)**3", "fibre": "8e-4"}


def true_error(result):
    """Largest error of a strain, relative to its member's largest, against twice the elements and 500 steps or more."""
    scene = result.scene
    times = math.ceil(500 / scene.analysis.sub_intervals)
    finer = with_elements(scene, 2 * scene.mesh.elements).changed(
        tolerance=None, analysis__sub_intervals=times * scene.analysis.sub_intervals, analysis__stability=False
    )
    if scene.analysis.reduction != "none":
        finer = finer.changed(analysis__cutoff=3 * scene.analysis.cutoff)
    best = analyse(finer).data["strain"].to_numpy()[::times]
    largest = np.abs(best).max(axis=(0, 2, 3))
    error = np.abs(result.data["strain"].to_numpy() - best).max(axis=(0, 2, 3))
    return float((error / np.maximum(largest, 0.1 * largest.max())).max())


def scene_of(name):
    seed = seed_four_bar(effects=("coupling",))
    if name == "tapered":
        return seed.changed(sections__coupler=TAPERED, sections__follower=TAPERED)
    return seed if name == "seed" else load(DEMOS / f"{name}.toml")


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
@pytest.mark.parametrize("name", ["seed", "tapered", "slider_crank", "manipulator", "pulsating_column"])
def test_error_is_below_the_tolerance_and_not_far_below(name, tolerance):
    result = analyse(scene_of(name).changed(tolerance=tolerance))
    assert tolerance / 100 < true_error(result) < tolerance
    assert result.data.attrs["chosen"].startswith(f"strains to {tolerance:g}, met by collocation")


def test_whole_equation_is_reduced_and_the_truncated_one_is_not():
    assert analyse(scene_of("seed").changed(tolerance=1e-2)).scene.analysis.reduction == "craig-bampton"
    assert analyse(scene_of("slider_crank").changed(tolerance=1e-2)).scene.analysis.reduction == "none"


def test_effects_are_chosen_by_the_tolerance():
    scene = load(DEMOS / "slider_crank.toml").changed(effects="auto")
    acting = [set(analyse(scene.changed(tolerance=t)).scene.effects) for t in (0.5, 1e-3)]
    assert acting[0] < acting[1]


def test_static_answers_need_no_mesh():
    result = analyse(seed_four_bar(analysis__method="quasi-static", tolerance=1e-3))
    exact = analyse(seed_four_bar(analysis__method="quasi-static", analysis__stations=result.data.sizes["s"]))
    assert np.abs(result.data["strain"] - exact.data["strain"]).max() < 1e-9 * np.abs(exact.data["strain"]).max()


@pytest.mark.parametrize(
    ("changes", "found"),
    [
        ({"analysis__method": "transient"}, "time_tolerance"),
        ({"impulses": {"hammer": {"at": "B", "angle": 1.0, "impulse": (0, 0.01)}}}, "impulses"),
        ({"effects": ("coupling",), "damping__ratio": 0.0}, "nothing damps"),  # twice as far off as the tolerance
    ],
)
def test_what_is_not_estimated_is_refused(changes, found):
    with pytest.raises(SceneError, match=found):
        analyse(seed_four_bar(tolerance=1e-3, **changes))


def test_peaks_are_sought_between_few_positions():
    scene = load(DEMOS / "slider_crank.toml")
    few, many = (analyse(scene.changed(tolerance=1e-2)), analyse(scene.changed(mesh__elements=6)))
    assert few.data.sizes["theta"] < 100
    found, best = (_between_positions(r).data["strain"].sel(member="crank") for r in (few, many))
    assert float(np.abs(found).max()) == pytest.approx(float(np.abs(best).max()), rel=1e-2)
    assert float(np.abs(few.data["strain"].sel(member="crank")).max()) < 0.98 * float(np.abs(best).max())


def test_graded_and_stated_meshes_keep_their_kind():
    scene = seed_four_bar(mesh={"elements": 4, "grading": 1.5})
    assert with_elements(scene, 8).mesh.grading == pytest.approx(1.5**0.5)
    stated = with_elements(seed_four_bar(mesh={"stations": [0, 0.2, 1]}), 3).mesh.stations
    assert stated == pytest.approx((0, 0.1, 0.2, 0.6, 1))


def test_tolerance_that_is_not_met_is_an_error(monkeypatch):
    monkeypatch.setattr(fenics_mech.tolerance, "MOST_ROUNDS", 1)
    with pytest.raises(SolverError, match=r"not met in 1 rounds: the largest error left is .*, by the time"):
        analyse(seed_four_bar(effects=("coupling",), tolerance=1e-4))


def test_tolerance_is_a_share():
    with pytest.raises(SceneError, match="tolerance"):
        seed_four_bar(tolerance=2.0)


def strut(force, elements):
    """A strut on two pins that an axial force presses and 1 N in its middle bends; 299 N is Euler's load."""
    return build(
        {
            "materials": {"al": {"modulus": 71e9, "density": 2714}},
            "sections": {"s": {"shape": "rectangle", "width": 0.02, "height": 0.004}},
            "ground": {"points": {"O": [0, 0], "G": [0.5, 0]}},
            "links": {
                "col": {
                    "points": {"A": [0, 0], "B": [0.5, 0]},
                    "members": {"AB": {"ends": ["A", "B"], "section": "s", "material": "al"}},
                    "angle": 0.0,
                }
            },
            "joints": {
                "A": {"connect": ["ground.O", "col.A"]},
                "B": {"kind": "slot", "connect": ["ground.G", "col.B"], "angle": 0.0},
            },
            "loads": {"axial": {"at": "col.B", "force": [-force, 0]}, "side": {"at": "col@0.5", "force": [0, 1]}},
            "effects": ["geometric-stiffness"],
            "mesh": {"elements": elements},
            "analysis": {"method": "static", "allow_coarse": True},
        }
    )


@pytest.mark.parametrize("force", [100.0, 280.0])
def test_a_strut_needs_elements_near_its_buckling_load(force):
    def moment(scene):
        return float(np.abs(analyse(scene).data["moment"]).max())

    wave = np.sqrt(force / (71e9 * 0.02 * 0.004**3 / 12))
    exact = np.tan(wave / 4) / (2 * wave)  # of a beam-column under a force in its middle
    coarse = strut(force, 2)
    estimate = float(analyse(coarse).data["relative_error"].sel(source="mesh"))
    assert 0.8 < estimate / abs(moment(coarse) / exact - 1) < 4
    assert moment(coarse.changed(tolerance=1e-4)) == pytest.approx(exact, rel=1e-4)
