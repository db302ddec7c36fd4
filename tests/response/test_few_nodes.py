"""Estimates found with few nodes, against those with all of them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fenics_mech import Mesh, SolverError, analyse, load
from fenics_mech.analysis import solved
from fenics_mech.response import few_nodes as module
from fenics_mech.response.few_nodes import on_few_nodes
from fenics_mech.response.periodic import steady_state
from fenics_mech.response.setup import mechanism
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS

PULSE = {"kind": "pulse", "start": 1.0, "end": 2.0}
NEED_ALL = {
    "few elements": {"mesh": {"elements": 24}},
    "impulses": {"impulses": {"blow": {"at": "coupler.B", "angle": 1.0, "impulse": (0.0, 0.002)}}},
    "jumps": {"loads": {"jump": {"at": "coupler.B", "force": (5.0, -3.0), "factor": PULSE}}},
}


def fine(**more):
    stated = {
        "mesh": {"elements": 30},
        "damping": {"material": 1e-4},
        "effects": ("coupling",),
        "analysis": {"sub_intervals": 48, "stations": 5, "allow_coarse": True},
    }
    return seed_four_bar(**(stated | more))


def plain():
    """The same by sub-intervals."""
    analysis = {"sub_intervals": 120, "stations": 5, "modes": 3, "allow_coarse": True}
    return fine(effects=(), damping={"ratio": 0.02}, analysis=analysis)


def without_few_nodes(monkeypatch):
    limits = replace(module.FEW_NODES, from_elements=1000)
    for place in (module, steady_state):
        monkeypatch.setattr(place, "FEW_NODES", limits)


@pytest.mark.slow
@pytest.mark.parametrize("effects", [("coupling",), ("coupling", "large-rotations")], ids=["linear", "exact"])
def test_few_nodes_estimate_as_all_do(effects, monkeypatch):
    """To 1 %: 12 elements have the frequencies of slow modes to 1e-5."""
    scene = fine(effects=effects)
    solution, found = solved(scene)
    assert solution.thinned is not None
    assert solution.thinned.system.size == 3 * 3 * 12
    without_few_nodes(monkeypatch)
    solution, whole = solved(scene.changed(name="all"))
    assert solution.thinned is None
    assert np.abs(found.data["strain"] - whole.data["strain"]).max() <= 1e-6 * np.abs(whole.data["strain"]).max()
    for source in {"time", "theory"} & set(whole.data["source"].to_numpy().tolist()):
        told, own = (one.data["relative_error"].sel(source=source).item() for one in (found, whole))
        assert told == pytest.approx(own, rel=0.01), source
    assert np.abs(found.data["multiplier"] - whole.data["multiplier"]).max() < 1e-6  # of all nodes


@pytest.mark.parametrize("more", NEED_ALL.values(), ids=list(NEED_ALL))
def test_some_motions_need_all_nodes(more):
    scene = fine(**more)
    assert on_few_nodes(scene, mechanism(scene)) is None


@pytest.mark.slow
def test_nothing_is_taken_from_few_nodes_that_differ(monkeypatch):
    """Few nodes that do not have the motion say nothing of it."""
    monkeypatch.setattr(module, "FEW_NODES", replace(module.FEW_NODES, kept=1))
    monkeypatch.setattr(steady_state, "difference", lambda few, whole: math.nan)
    solution, found = solved(fine())
    assert solution.thinned is None
    assert len(solution.stability.multipliers)
    assert found.data["relative_error"].sel(source="mesh") < 1e-5


@pytest.mark.slow
def test_stability_is_that_of_all_nodes():
    """At the edge of a resonance of mode 6 a multiplier of 12 elements is 0.98, and that of 40 is 1.01."""
    scene = load(DEMOS / "pulsating_column.toml")
    loads = {"pulse": (0.0, -195.0), "dead": (0.0, 146.25)}
    forces = {name: scene.loads[name].model_copy(update={"force": force}) for name, force in loads.items()}
    scene = scene.changed(
        loads=scene.loads | forces, mesh=Mesh(elements=40), drive__speed=8490.0, damping__relative=40.0
    )
    with pytest.raises(SolverError, match="unstable"):
        analyse(scene.changed(analysis__sub_intervals=40, analysis__allow_unstable=False))


@pytest.mark.slow
def test_few_nodes_that_stretch_otherwise_are_not_taken():
    """Next to a resonance of stretching alone, 12 linear elements stretch five times less than 60."""
    scene = load(DEMOS / "pulsating_column.toml").changed(mesh=Mesh(elements=60), drive__speed=16094.0)
    scene = scene.changed(effects=("coupling",), damping__relative=4.0)
    solution, _ = solved(
        scene.changed(analysis__sub_intervals=24, analysis__stability=False, analysis__allow_coarse=True)
    )
    assert solution.thinned is None


def test_the_difference_is_that_of_the_motions():
    """One element bends far less than 30 where harmonics come near the frequencies that it has wrong."""
    scene = fine(analysis={"sub_intervals": 24, "allow_coarse": True, "stability": False, "error_estimates": False})
    solution, coarse = (solved(one)[0] for one in (scene, scene.changed(mesh__elements=6)))
    one = module.difference((coarse.system, coarse.response), (solution.system, solution.response))
    turned = replace(coarse.response, displacement=1.1 * coarse.response.displacement)
    ten_percent = module.difference((coarse.system, turned), (solution.system, solution.response))
    assert one < 2e-3
    assert ten_percent == pytest.approx(0.1 / 1.1, abs=2 * one)
