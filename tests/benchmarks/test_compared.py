"""Peers: hand-coded ones of the seed against each other, and who may be compared."""

import sys

import numpy as np
import pytest

from benchmarks.cost import RunOutcome, dataset
from benchmarks.cost_plots import beside_exudyn
from benchmarks.peers import compared
from benchmarks.peers.by_hand import by_exponentials, by_solve_ivp
from benchmarks.peers.compared import compare_peers, entries_of, require_ready, steps_of
from benchmarks.peers.peer_runs import EXACT, EXUDYN
from benchmarks.peers.seed_programs import is_seed
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.scene import load
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS
from tests.validation.reference import NineElementModel, gauss_legendre_periodic, link_strain


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


def programs(scene):
    """Programs that run on a scene, and the equations that they solve."""
    entries = entries_of(scene)
    return {each.program.split(",")[0] for each in entries}, {each.equation for each in entries}


@pytest.mark.parametrize("name", ["slider_crank", "watt"])
def test_exudyn_is_the_peer_of_any_linkage_of_beams(name):
    scene = load(DEMOS / f"{name}.toml")
    assert programs(scene) == ({"fenics_mech", EXUDYN}, {EXACT})
    assert {each.program for each in entries_of(scene, quick=True)} == {EXUDYN, "fenics_mech, collocation"}


@pytest.mark.parametrize("name", ["quick_return", "pulsating_column"])
def test_a_machine_that_exudyn_cannot_be_given_has_no_peers(name):
    with pytest.raises(SceneError, match="other programs"):
        require_ready(load(DEMOS / f"{name}.toml"))


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
def test_a_changed_seed_has_no_hand_coded_peers(changes):
    scene = seed_four_bar(**changes)
    assert not is_seed(scene)
    assert programs(scene) == ({"fenics_mech", EXUDYN}, {EXACT})


def test_the_demo_is_the_seed_whatever_its_analysis():
    assert is_seed(load(DEMOS / "four_bar.toml").changed(analysis__sub_intervals=24, mesh__elements=2))


def test_a_missing_exudyn_is_said_before_anything_runs(monkeypatch):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    with pytest.raises(MechanismError, match="not installed"):
        require_ready(seed_four_bar())
    with pytest.raises(MechanismError, match="not installed"):
        require_ready(load(DEMOS / "watt.toml"), quick=True)  # it has no other peer
    require_ready(seed_four_bar(), quick=True)


@pytest.mark.slow
def test_quick_comparison_has_all_hand_coded_programs():
    steps, seed = [], seed_four_bar()
    found = compare_peers(seed, quick=True, progress=steps.append)
    assert len(steps) == steps_of(seed, quick=True)
    data = found.data
    assert data.sizes["run"] == len(entries_of(seed, quick=True))
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
    assert (data["solver_seconds"] < data["seconds"]).to_numpy()[ours].all()


def test_a_quick_comparison_with_exudyn_says_how_long_each_takes(monkeypatch):
    pytest.importorskip("exudyn")
    monkeypatch.setattr(compared, "EXUDYN_RUNS", compared.EXUDYN_RUNS[1:2])
    found = compare_peers(load(DEMOS / "slider_crank.toml"), quick=True)
    data = found.data
    assert (data["error_mid_span"] < 0.01).all()
    assert (data["solver_seconds"] < data["seconds"]).all()
    text = next(beside_exudyn(data, {}))
    assert "Error of 1 %: Exudyn takes" in text
    assert "the solver of fenics_mech" in text


def test_the_fastest_runs_that_are_good_enough_are_compared():
    def line(program, seconds, solver, error):
        numbers = {"seconds": seconds, "solver_seconds": solver, "error_mid_span": error}
        return RunOutcome(program, EXACT, {}, numbers)

    runs = [
        line(EXUDYN, 0.2, 0.1, 0.05),
        line(EXUDYN, 3.0, 2.0, 0.005),
        line("fenics_mech, collocation", 1, 0.5, 0.002),
    ]
    (said,) = beside_exudyn(dataset([*runs, RunOutcome("by hand", "(5.1)", {}, {"error_mid_span": 1e-9})]), {})
    assert "Exudyn takes 3000 ms, 3 times as long" in said
    assert "integration takes 4 times as long" in said
