"""Stiff time scales: the fastest axial mode of the arm is 1e5 times its speed, and a cycle has 4 to 10,000 steps.

Right: the answer of the modes to the order of the steps where they are long beside all but the slow modes, and to
rounding where there are many; what rings is refused. Energy over long times is in `response/test_transient.py`.
"""

import numpy as np
import pytest

import fenics_mech.analysis
import fenics_mech.classical.response
from fenics_mech import _guard, analyse
from fenics_mech._guard import memory
from fenics_mech.errors import SolverError, TooLargeError
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of
from tests.hard_cases.hard import answer, arm, natural


def off(count, share, **analysis):
    """Error of the tip's deflection at a share of the first natural frequency, and its estimate."""
    speed = share * natural(arm(1.0))[0][0]
    chosen = {"sub_intervals": count, "stations": 2, "stability": False, "allow_coarse": True} | analysis
    scene = arm(speed, damping={"ratio": 0.01}, analysis=chosen)
    assert natural(scene)[0][-1] > 1e4 * speed
    exact = answer(scene, lambda omega: 0.02 * omega, analysis["solver"] != "sub-intervals")
    data = analyse(scene).data
    x, y = data["deflection"].sel(s=1.0)[:, 0].to_numpy().T
    theta = data["theta"].to_numpy()
    found = np.cos(theta) * y - np.sin(theta) * x
    error = np.abs(found - exact).max() / np.abs(exact).max()
    return error, float(data["strain_error"].max() / np.abs(data["strain"]).max()) if "strain_error" in data else None


@pytest.mark.parametrize(("count", "largest"), [(4, 7e-2), (8, 3e-3), (24, 1.5e-5), (96, 1e-7), (2000, 1e-7)])
def test_collocation_with_few_steps_and_many(count, largest):
    """Order 5, down to what readings by differences round; the estimate is no less than half of the error."""
    error, estimate = off(count, 0.2, solver="collocation")
    assert error < largest
    assert estimate > error / 2 or error < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(("count", "largest"), [(24, 3.5e-3), (96, 2.3e-4), (1000, 2e-6), (10000, 2e-6)])
def test_sub_intervals_few_and_many(count, largest):
    """The load is linear in each: order 2, down to what the two modes kept leave out."""
    assert off(count, 0.2, solver="sub-intervals", modes=2)[0] < largest


@pytest.mark.parametrize("count", [4, 8])
def test_steps_in_which_a_mode_swings_more_than_once_are_refused(count):
    with pytest.raises(SolverError, match=r"mode 1 \(6\.62\d* Hz\) is too fast"):
        off(count, 0.013, solver="sub-intervals", modes=2)


STEPS = {"solver": "sub-intervals", "sub_intervals": 6, "stations": 3, "stability": False, "allow_coarse": True}


@pytest.mark.long
@pytest.mark.slow
def test_hundreds_of_modes_at_once():
    """All modes of two members of 104 elements, the fastest with 175,000 swings in a sub-interval, beside two modes.

    The others answer statically there, which lacks their inertia: 0.7 % of the strains at so high a speed.
    """
    strip = {"section": "strip", "material": "steel"}
    halves = {"one": strip | {"ends": ("O", "B")}, "two": strip | {"ends": ("B", "A")}}
    links = {"arm": {"points": {"O": (0, 0), "B": (0.25, 0), "A": (0.5, 0)}, "members": halves}}
    speed = 0.7 * natural(arm(1.0))[0][0]
    scene = arm(speed, links=links, mesh={"elements": 104}, damping={"ratio": 0.01}, analysis=STEPS)
    few, every = (response_of(scene.changed(analysis__modes=count)).data for count in (2, "all"))
    assert every.sizes["mode"] == 624
    assert float(every["frequency"].max()) > 1e6 / scene.period
    for name in ("strain", "deflection"):
        np.testing.assert_allclose(every[name], few[name], rtol=0, atol=0.01 * float(np.abs(few[name]).max()))


def test_fast_modes_of_a_linkage_ring_and_are_refused():
    """Unlike the arm's, they jump at each join: with 360 of them one rings with 75 % of the whole vibration."""
    with pytest.raises(SolverError, match=r"mode \d+ \(\d+ Hz\) is too fast for these sub_intervals"):
        analyse(seed_four_bar(mesh={"elements": 40}, damping={"ratio": 0.02}, analysis=STEPS | {"modes": "all"}))


@pytest.mark.parametrize(
    ("module", "name", "value", "effects", "needed"),
    [
        (fenics_mech.classical.response, "JOINED", 10**9, (), "60 sub-intervals with 20 modes"),
    ],
)
def test_memory_is_judged_before_every_position_is_solved(monkeypatch, module, name, value, effects, needed):
    def modes(*_):
        raise AssertionError("the eigenproblems of all positions are solved first")

    monkeypatch.setattr(fenics_mech.classical.response, "slowest", modes)
    monkeypatch.setattr(module, name, value)
    with pytest.raises(TooLargeError, match=needed):
        analyse(seed_four_bar(effects=effects, analysis__sub_intervals=60, analysis__modes=20))


def test_memory_of_a_container_is_the_bound(monkeypatch, tmp_path):
    """One that says "max" has none, and a machine has most that it can have."""
    for name, says in (("max", "max\n"), ("little", "1000000\n")):
        (tmp_path / name).write_text(says)
    whole = memory()
    monkeypatch.setattr(_guard, "OF_CONTAINER", (tmp_path / "none", tmp_path / "max"))
    assert memory() >= whole
    monkeypatch.setattr(_guard, "OF_CONTAINER", (tmp_path / "max", tmp_path / "little"))
    with pytest.raises(TooLargeError, match=r"need about .* GB of memory, and there is 0.001 GB for it"):
        analyse(seed_four_bar())
