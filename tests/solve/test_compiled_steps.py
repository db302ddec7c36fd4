"""Compiled steps of a cycle: against the same steps by SuperLU and Python, one after the other."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import compiled_steps, periodic, rigid_cycle
from fenics_mech.solve.compiled_steps import accelerated
from fenics_mech.solve.periodic import LinearSteps
from tests.common import DEMOS

EXACT = {"effects": ("coupling", "large-rotations"), "damping": {"material": 1e-4}}


def cycle_of(scene, steps, stages=3):
    machine = machine_of(scene).machine
    machine.chart = rigid_cycle(machine, scene.period)
    return periodic(machine, scene.period, steps, stages=stages)


@pytest.mark.parametrize("stages", [1, 2, 3, 5])
@pytest.mark.parametrize("name", ["four_bar", "stephenson"])
def test_states_go_through_compiled_steps_as_through_plain_ones(monkeypatch, name, stages):
    """19 steps: the last of the three groups of eight is not full. Rounding grows by the condition of a step."""
    cycle = cycle_of(fm.load(DEMOS / f"{name}.toml").changed(EXACT), 19, stages)
    assert cycle.steps.march is not None
    monkeypatch.setattr(compiled_steps, "LOST", -1.0)
    plain = LinearSteps(cycle.machine, cycle.path, cycle.evaluation)
    assert plain.march is None
    n, rng = cycle.machine.n, np.random.default_rng(3)
    states, right, gaps = (rng.normal(size=x) for x in ((4, 2 * n), cycle.path.a.shape, (19, 2 * n)))
    for found, known in zip(cycle.steps.through(states, right, gaps, True), plain.through(states, right, gaps, True)):
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-7 * np.abs(known).max())
    found, known = cycle.steps.change(right, gaps), plain.change(right, gaps)
    for name in ("q0", "v0", "a"):
        one, other = getattr(found, name), getattr(known, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-7 * np.abs(other).max())


def test_what_the_planned_order_loses_is_found(monkeypatch):
    """A diagonal block that another elimination empties: the factors are told not to hold."""
    cycle = cycle_of(fm.load(DEMOS / "four_bar.toml").changed(EXACT), 9)
    found, machine = cycle.evaluation, cycle.machine
    massless = np.zeros(machine.n, dtype=bool)
    massless[machine.places[machine.groups[0].pose[-1, 1], 2]] = True
    order = compiled_steps.order_of(machine.pattern, machine.n)
    of_it = np.isin(order.row, np.flatnonzero(massless)) & (order.row == order.column)
    for tangent in (found.M, found.C, found.K):
        tangent[:, of_it] = 0.0
    steps = LinearSteps(machine, cycle.path, found)
    force = np.random.default_rng(1).normal(size=cycle.path.a.shape)
    once = steps.through(np.zeros((1, 2 * machine.n)), force)[0]
    monkeypatch.setattr(compiled_steps, "LOST", -1.0)
    again = LinearSteps(machine, cycle.path, found).through(np.zeros((1, 2 * machine.n)), force)[0]
    np.testing.assert_allclose(once, again, rtol=0, atol=1e-7 * np.abs(again).max())


def test_forces_accelerate_within_the_rows(monkeypatch):
    """M a + G^T L = F and G a = 0 by products with the tangents, by compiled and by plain factors."""
    cycle = cycle_of(fm.load(DEMOS / "slider_crank.toml").changed(EXACT), 16)
    found, machine, n = cycle.evaluation, cycle.machine, cycle.machine.n
    force = np.zeros_like(found.force)
    force[:, :n] = np.random.default_rng(2).normal(size=(len(force), n))
    for lost in (compiled_steps.LOST, -1.0):
        monkeypatch.setattr(compiled_steps, "LOST", lost)
        a = accelerated(machine, found, force)
        M, K = (found.pattern.dense(x) for x in (found.M, found.K))
        held = n + machine.held
        of_coordinates = np.einsum("tij,tj->ti", M[:, :n, :held], a[:, :held])
        least = 2 * compiled_steps.MASSLESS * np.abs(found.M).max() * np.abs(a).max()  # of all coordinates
        np.testing.assert_allclose(of_coordinates, force[:, :n], rtol=0, atol=least)
        gaps = np.einsum("tij,tj->ti", K[:, n:held, :n], a[:, :n])
        assert np.abs(gaps).max() < 1e-9 * np.abs(a[:, :n]).max()
