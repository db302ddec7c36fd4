"""Floquet multipliers against closed forms, the Strutt diagram and the mechanism itself."""

import numpy as np
import pytest

from benchmarks.peers.compared import scene_of
from benchmarks.peers.peer_runs import EXACT
from fenics_mech import analyse, load
from fenics_mech.errors import SolverError
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.meshing import with_elements
from tests.common import ROOT, response_of
from tests.response.synthetic import PERIOD, arm

OMEGA, ZETA = np.array([2.0, 7.3, 20.0]), np.array([0.01, 0.02, 0.05])


def exact():
    """``exp(-zeta omega T + i omega_d T)``, largest magnitude first."""
    order = np.argsort(ZETA * OMEGA)
    omega, zeta = OMEGA[order], ZETA[order]
    return np.exp((-zeta + 1j * np.sqrt(1 - zeta**2)) * omega * PERIOD)


@pytest.mark.parametrize("sub_intervals", [120, 200])
def test_softness_of_a_moment_makes_no_multiplier_of_what_is_damped_away(sub_intervals):
    """Bent by 0.9 rad it is soft for a moment, and Gauss points keep what is too fast: they made 1.02 of it."""
    data = analyse(soft_four_bar(sub_intervals)).data
    assert np.hypot(*data["multiplier"].transpose("part", ...)).max() < 0.06


def soft_four_bar(sub_intervals):
    """The demo with a tenth of its stiffness, and strong damping."""
    demo = load(ROOT / "demos" / "four_bar.toml")
    soft = {"materials.aluminium.modulus": 0.1 * demo.materials["aluminium"].modulus, "damping.ratio": 0.4}
    scene = with_elements(scene_of(demo.changed(soft), EXACT), 8)
    steps = {"sub_intervals": sub_intervals, "stages": 3, "stability": True, "error_estimates": False}
    steps |= {"allow_coarse": True, "allow_unstable": False}
    return scene.changed(analysis=scene.analysis.model_copy(update=steps))


def test_seed_four_bar_is_stable():
    """With 2 % damping disturbances decay as ``exp(-zeta omega t)``; the coupling moves that by less than a tenth."""
    scene = seed_four_bar(effects=("coupling",), analysis={"sub_intervals": 120, "solver": "collocation"})
    found = analyse(scene).data
    rate, omega = found["growth_rate"].to_numpy(), 2 * np.pi * found["multiplier_frequency"].to_numpy()
    assert rate == pytest.approx(-0.02 * omega, rel=0.1)
    assert sorted(found["multiplier_mode"].to_numpy()) == [1, 1, 2, 2, 3, 3]
    size = np.hypot(*found["multiplier"].to_numpy().T)
    assert rate == pytest.approx(np.log(size) / scene.period)


@pytest.mark.slow
@pytest.mark.parametrize("effects", [("coupling",), ("coupling", "large-rotations")])
def test_both_solvers_judge_alike(effects):
    scene = seed_four_bar(effects=effects, damping={"material": 1.339e-4})
    steps = response_of(scene.changed(analysis__solver="collocation", analysis__sub_intervals=240)).data
    series = response_of(scene.changed(analysis__solver="harmonic-balance", analysis__sub_intervals=280)).data
    # 60 harmonics leave 2e-5 of the nonlinear motion out
    assert np.abs(steps["multiplier"] - series["multiplier"]).max() < (1e-5 if len(effects) == 1 else 1e-4)


def test_tension_of_a_turning_arm_stiffens_it():
    """Southwell and Gough (1921): in its plane an arm vibrates at ``omega^2 = omega_1^2 + (1.193 - 1) speed^2``.

    Only the tangents about the motion know it: those about rest give ``omega_1^2 - speed^2``.
    """
    still = analyse(arm(1.0, analysis={"sub_intervals": 96, "solver": "sub-intervals", "modes": 2}))
    omega, rest = (
        2 * np.pi * float(still.data["frequency"][0, 0]),
        {"mesh": {"elements": 6}, "damping": {"ratio": 0.02}},
    )
    for effects, share in ((("coupling",), -1), (("coupling", "large-rotations"), 0.193)):
        found = analyse(arm(20.0, **rest, effects=effects, analysis={"sub_intervals": 64, "modes": 2})).data
        expected = np.sqrt(omega**2 + share * 20.0**2) / (2 * np.pi)
        # damping takes off 2e-4, the motion under the load is only near to straight
        assert float(found["multiplier_frequency"][0]) == pytest.approx(expected, rel=2e-3)


def test_arm_that_turns_too_fast_is_refused_unless_allowed():
    """Without the stiffness of its tension an arm diverges as ``sqrt(speed^2 - omega_1^2)``, beside 2 % Coriolis."""
    still = analyse(arm(1.0, analysis={"sub_intervals": 96, "solver": "sub-intervals", "modes": 2}))
    omega = 2 * np.pi * float(still.data["frequency"][0, 0])
    scene = arm(1.2 * omega, effects=("coupling",), analysis={"sub_intervals": 48, "modes": 2})
    with pytest.raises(SolverError, match=r"unstable: .* mostly in mode 1, that of link"):
        analyse(scene)
    found = analyse(scene.changed(analysis__allow_unstable=True)).data
    assert float(found["growth_rate"][0]) == pytest.approx(omega * np.sqrt(1.2**2 - 1), rel=1e-3)


class RoundedFlow:
    """A cycle that multiplies states by known numbers, and rounds single states and several ones differently."""

    def __init__(self, multipliers, rounding):
        self.turn = np.linalg.qr(np.random.default_rng(1).standard_normal((2 * 60, 2 * 60)))[0]
        self.multipliers, self.rounding, self.size, self.unit = multipliers, rounding, 60, np.ones(60)

    def after_cycle(self, starts):
        """Carry states through the cycle."""
        noise = np.random.default_rng(starts.shape[1]).standard_normal(starts.shape)
        exact = self.turn * self.multipliers @ (self.turn.T @ starts)
        return exact + self.rounding * np.linalg.norm(starts, axis=0) / np.sqrt(120) * noise
