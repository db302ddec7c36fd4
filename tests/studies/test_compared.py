"""Peers of the seed four-bar: hand-coded ones against each other, and who may be compared."""

import sys

import numpy as np
import pytest

from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.reference import NineElementModel, gauss_legendre_periodic, link_strain
from fenics_mech.scene import load
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.studies.peers.by_hand import by_exponentials, by_solve_ivp
from fenics_mech.studies.peers.compared import compare_peers, entries_of, is_seed, require_ready, require_seed, steps_of
from tests.common import DEMOS


def gauss_legendre(steps, damping):
    """Mid-span strains by the independent collocation of the reference, one element a link."""
    model = NineElementModel(elements=1)
    found = gauss_legendre_periodic(model, steps, damping=damping, coupling=True)
    return link_strain(model, found.theta, found.displacement, found.acceleration).total


def off(strain, other):
    """Largest difference in coupler and follower, over the largest strain of each."""
    return (np.abs(strain - other).max(axis=0) / np.abs(other).max(axis=0))[1:].max()


def test_exponentials_converge_to_the_solution_of_the_coupled_equation():
    # Each join kicks the stiff axial modes; once the sub-intervals follow these, the order is two.
    exact = gauss_legendre(480, damping=0.2)
    coarse, fine = (off(by_exponentials(n, 1, damping=0.2)[:: n // 480], exact) for n in (1920, 3840))
    assert fine < 1e-3
    assert coarse / fine > 3.5


def test_integration_in_time_settles_to_the_periodic_solution():
    # The tolerance holds for a step and a cycle; a motion that decays by 0.2 of critical keeps errors of its size.
    exact = gauss_legendre(240, damping=0.2)
    assert off(by_solve_ivp(1e-3, 1, angles=240, damping=0.2), exact) < 5e-3


@pytest.mark.parametrize("name", ["slider_crank", "watt", "composite_four_bar"])
def test_another_machine_has_no_peers(name):
    with pytest.raises(SceneError, match="seed four-bar only") as refusal:
        require_seed(load(DEMOS / f"{name}.toml"))
    assert refusal.value.place == "--peers"


@pytest.mark.parametrize(
    "changes",
    [
        {"drive__speed": 30.0},
        {"damping__ratio": 0.03},
        {"masses__A__mass": 0.05},
        {"sections__coupler__fibre": 1e-3},
        {"links__coupler__angle": "-70 deg", "links__follower__angle": "-100 deg"},
    ],
)
def test_a_changed_seed_has_no_peers(changes):
    with pytest.raises(SceneError, match="seed four-bar only"):
        require_seed(seed_four_bar(**changes))


def test_the_demo_is_the_seed_whatever_its_analysis():
    assert is_seed(load(DEMOS / "four_bar.toml").changed(analysis__sub_intervals=24, mesh__elements=2))


def test_a_missing_exudyn_is_said_before_anything_runs(monkeypatch):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    with pytest.raises(MechanismError, match="not installed"):
        require_ready(seed_four_bar())
    require_ready(seed_four_bar(), quick=True)


def test_quick_comparison_has_all_hand_coded_programs():
    steps = []
    found = compare_peers(seed_four_bar(), quick=True, progress=steps.append)
    assert len(steps) == steps_of(quick=True)
    data = found.data
    assert data.sizes["run"] == len(entries_of(quick=True))
    by_hand = data.isel(run=[i for i, name in enumerate(data["method"].to_numpy()) if "by hand" in name])
    assert sorted(by_hand["method"].to_numpy()) == [
        "Gauss-Legendre by hand",
        "chapter 5 by hand",
        "exponentials by hand",
    ]
    assert (by_hand["seconds"] > 0).all()
    # Both programs have the same elements: extrapolated from the same meshes their answers differ by the steps alone.
    own, other = (data[name].to_numpy() for name in ("error_mid_span", "error_all_mid_span"))
    ours = np.array(["fenics_mech" in name for name in data["method"].to_numpy()]) & np.isfinite(own)
    assert ours.any()
    assert np.abs(own - other)[ours].max() < 0.03
    assert np.array_equal(own[~ours], other[~ours], equal_nan=True)
