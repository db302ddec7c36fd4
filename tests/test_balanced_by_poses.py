"""Scenes by harmonic balance of the equation of poses, against its steps."""

import numpy as np
import pytest

from fenics_mech.answers.by_poses import by_poses
from fenics_mech.errors import SceneError
from fenics_mech.scene import load
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS


def test_impulses_are_refused():
    scene = seed_four_bar(
        effects=("coupling",),
        impulses={"blow": {"at": "follower.B", "impulse": (0.01, 0.0), "angle": "40 deg"}},
        analysis={"solver": "harmonic-balance"},
    )
    with pytest.raises(SceneError, match="harmonics do not follow"):
        by_poses(scene)


def strains(scene, count, **analysis):
    """Strains at 40 angles."""
    values = {f"analysis__{key}": value for key, value in analysis.items()}
    quick = {"analysis__stability": False, "analysis__error_estimates": False}
    result = by_poses(scene.changed(**values, **quick, analysis__sub_intervals=count))
    return result.data["strain"].to_numpy()[:: count // 40]


def same(scene, stages, count, harmonics, angles):
    """Largest difference of the strains of both solvers, over the largest strain."""
    by_steps = strains(scene, count, solver="poses", stages=stages)
    by_series = strains(scene, angles, solver="harmonic-balance", harmonics=harmonics)
    return np.abs(by_steps - by_series).max() / np.abs(by_steps).max()


@pytest.mark.slow
@pytest.mark.parametrize("effects", [("coupling",), ("coupling", "large-rotations")])
def test_seed_four_bar_by_steps_and_by_harmonics(effects):
    """Two solvers that share the equation alone; measured 2e-8 and 3e-7."""
    scene = seed_four_bar(effects=effects, damping={"material": 1.339e-4})
    assert same(scene, stages=5, count=240, harmonics=85, angles=360) < 1e-6


def test_slider_crank_by_steps_and_by_harmonics():
    scene = load(DEMOS / "slider_crank.toml").changed(effects=("coupling",))
    assert same(scene, stages=4, count=120, harmonics=25, angles=120) < 1e-6  # measured 4e-9


@pytest.mark.long
@pytest.mark.slow
def test_quick_return_by_steps_and_by_harmonics():
    """The pin passes from element to element, and P'' jumps there: both converge as a power.

    Measured 5e-5, and 1e-6 with 340 harmonics.
    """
    scene = load(DEMOS / "quick_return.toml").changed(effects=("coupling",))
    assert same(scene, stages=5, count=240, harmonics=85, angles=360) < 2e-4


def test_what_a_load_does_between_the_sub_intervals_is_told():
    """The series does not see a pulse narrower than a sub-interval; the steps that tell its error are cut there."""
    pulse = {"kind": "pulse", "start": 1.0, "end": 1.01}
    scene = load(DEMOS / "slider_crank.toml").changed(
        effects=("coupling",),
        loads={"tap": {"at": "rod@0.5", "force": (-1.0, 0.6), "factor": pulse}},
        analysis={"sub_intervals": 80, "harmonics": 16, "allow_coarse": True},
    )
    series, steps = (by_poses(scene.changed(analysis__solver=one)).data for one in ("harmonic-balance", "poses"))
    error = np.abs(series["strain"] - steps["strain"]).max(["theta", "s", "fibre"]) / series["largest_strain"]
    told = series["relative_error"].drop_sel(source=["theory", "positions"]).sum()  # at the positions
    assert 0.01 < error.max() < told < 2 * error.max()
