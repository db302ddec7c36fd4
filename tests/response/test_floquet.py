"""Floquet multipliers against closed forms, the Strutt diagram and the mechanism itself."""

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

from benchmarks.peers.compared import scene_of
from benchmarks.peers.peer_runs import EXACT
from fenics_mech import analyse, load
from fenics_mech.errors import SolverError
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.stability.floquet import floquet
from fenics_mech.response.stability.multipliers import MULTIPLIERS, _slow, eigenpairs
from fenics_mech.response.stability.turning import LinkAxes
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.meshing import with_elements
from tests.common import ROOT, response_of
from tests.response.synthetic import PERIOD, Duffing, arm, axes_of, modes_of, oscillators, places

OMEGA, ZETA = np.array([2.0, 7.3, 20.0]), np.array([0.01, 0.02, 0.05])


def damped(scheme, count, stages=3):
    """Stability of three damped oscillators."""
    tableau = Tableau.of(scheme, stages)
    matrices = oscillators(places(tableau.points, count), OMEGA, 2 * ZETA * OMEGA)
    return floquet(Flow(matrices, tableau, PERIOD / count), matrices, axes_of(matrices, count), modes_of(OMEGA))


def exact():
    """``exp(-zeta omega T + i omega_d T)``, largest magnitude first."""
    order = np.argsort(ZETA * OMEGA)
    omega, zeta = OMEGA[order], ZETA[order]
    return np.exp((-zeta + 1j * np.sqrt(1 - zeta**2)) * omega * PERIOD)


def test_no_frequency_is_told_of_what_is_rounding():
    """Over the cycle 20 rad/s with a ratio of 0.05 is damped by 500, and 300 rad/s with one of 0.9 to nothing."""
    tableau, omega, zeta = Tableau.of("gauss", 3), np.array([20.0, 300.0]), np.array([0.05, 0.9])
    matrices = oscillators(places(tableau.points, 400), omega, 2 * zeta * omega)
    found = floquet(Flow(matrices, tableau, PERIOD / 400), matrices, axes_of(matrices, 400), modes_of(omega))
    lost = np.abs(found.multipliers) < 1e-14
    assert lost.tolist() == [False, False, True, True]
    assert np.isnan(found.frequency).tolist() == lost.tolist()
    assert found.frequency[0] == pytest.approx(20 * np.sqrt(1 - 0.05**2) / (2 * np.pi), rel=1e-3)
    assert not found.vibrates[2:].any()


def errors(scheme, count, stages=3):
    found = damped(scheme, count, stages).multipliers[::2]
    return np.minimum(np.abs(found - exact()), np.abs(found.conj() - exact()))


def test_damped_oscillators():
    found = damped("gauss", 80)
    assert errors("gauss", 80) == pytest.approx(
        np.zeros(3), abs=2e-6
    )  # N (omega h)^7/100800 = 6e-6 e^(-2) of the fastest
    order = np.repeat(np.argsort(ZETA * OMEGA), 2)
    assert found.mode.tolist() == order.tolist()
    assert found.share == pytest.approx(np.ones(6))
    assert found.growth_rate == pytest.approx(-(ZETA * OMEGA)[order], rel=1e-5)
    assert found.frequency == pytest.approx((np.sqrt(1 - ZETA**2) * OMEGA)[order] / (2 * np.pi), rel=1e-6)
    assert found.stable


@pytest.mark.parametrize("scheme", ["gauss", "radau"])
def test_order_of_the_multipliers(scheme):
    """As of any state: 2s for Gauss and 2s - 1 for Radau IIA."""
    coarse, fine = (errors(scheme, count).max() for count in (40, 80))
    assert np.log2(coarse / fine) == pytest.approx(6 if scheme == "gauss" else 5, abs=0.2)


def test_radau_points_damp_and_gauss_points_do_not():
    """The magnitude by Radau points is ``exp(-N (omega h)^6/7200)``: the reason for Gauss points."""
    omega, count = 12.0, 40
    for scheme in ("gauss", "radau"):
        tableau = Tableau.of(scheme, 3)
        matrices = oscillators(places(tableau.points, count), np.array([omega]), np.zeros(1))
        found = floquet(Flow(matrices, tableau, PERIOD / count), matrices, axes_of(matrices, count), modes_of([omega]))
        loss = -np.log(np.abs(found.multipliers[0]))
        expected = 0.0 if scheme == "gauss" else count * (omega * PERIOD / count) ** 6 / 7200
        assert loss == pytest.approx(expected, rel=0.1, abs=1e-12)  # the next term is (omega h)^2/20 of it


def mathieu(a, q, damping=0.0, count=60):
    """Stability of ``x'' + 2 damping x' + (a - 2 q cos 2t) x = 0``, of period pi."""
    tableau = Tableau.of("gauss", 3)
    time = places(tableau.points, count, np.pi)
    ones = np.ones((len(time), 1, 1))
    stiffness = (a - 2 * q * np.cos(2 * time))[:, None, None]
    matrices = Matrices.of_full(ones, 2 * damping * ones, stiffness, np.zeros((len(time), 1)))
    modes = modes_of([np.sqrt(max(a, 0.01))])
    return floquet(Flow(matrices, tableau, np.pi / count), matrices, axes_of(matrices, count), modes)


@pytest.mark.parametrize("q", [0.5, 2.0])
@pytest.mark.parametrize(("curve", "number"), [("a", 0), ("b", 1), ("a", 1), ("b", 2), ("a", 2), ("b", 3), ("a", 3)])
def test_motions_on_the_strutt_curves(curve, number, q):
    """Abramowitz and Stegun, ch. 20: on a_n(q) and b_n(q) a motion has period pi (n even) or 2 pi (n odd).

    Both multipliers meet there, and part with the root of the distance: an error of 1e-9 shows as 3e-5.
    """
    border = float((mathieu_a if curve == "a" else mathieu_b)(number, q))
    assert mathieu(border, q).multipliers == pytest.approx([1 - 2 * (number % 2)] * 2, abs=1e-3)


@pytest.mark.parametrize("q", [0.5, 2.0])
@pytest.mark.parametrize("number", [0, 1, 2, 3])
def test_strutt_diagram(number, q):
    """Stable between a_n and b_(n+1), not between b_n and a_n."""
    lower = float(mathieu_a(number, q))
    below = float(mathieu_b(number, q)) if number else lower - 1
    calm, wild = (mathieu((one + other) / 2, q) for one, other in ((lower, mathieu_b(number + 1, q)), (below, lower)))
    assert np.abs(calm.multipliers) == pytest.approx([1, 1], abs=1e-8)
    assert calm.stable
    assert not wild.stable
    assert np.prod(wild.multipliers).real == pytest.approx(1, abs=1e-8)  # Liouville
    for side in (-1, 1):  # and the change is at the curve itself
        assert mathieu(lower + side * 1e-4, q).stable == (side > 0) or number == 3


def test_damping_takes_off_its_share():
    """With damping d both multipliers fall by ``exp(-d pi)`` where a grows by d^2 (Liouville)."""
    free, held = mathieu(1.0, 0.5), mathieu(1.0 + 0.1**2, 0.5, damping=0.1)
    assert np.abs(held.multipliers) == pytest.approx(np.abs(free.multipliers) * np.exp(-0.1 * np.pi), rel=1e-6)


def test_variations_of_a_nonlinear_motion():
    """The product of both multipliers is ``exp(-c T)``, and for a hardening spring they turn faster."""
    tableau, count = Tableau.of("gauss", 3), 60
    time = places(tableau.points, count)
    duffing = Duffing(time)
    tangents = duffing.linearised(*duffing.motion(time), duffing.tension)
    bent, straight = (
        floquet(Flow(m, tableau, PERIOD / count), m, axes_of(m, count), modes_of([2.0]))
        for m in (tangents, duffing.linear)
    )
    assert np.prod(bent.multipliers).real == pytest.approx(np.exp(-duffing.damping * PERIOD), rel=1e-8)
    assert bent.frequency[0] > 1.1 * straight.frequency[0]


def test_what_is_too_fast_for_the_steps_is_left_out():
    """Three points in a step follow 2 rad: 20 rad/s needs 21 steps in the cycle, 7.3 rad/s needs 8."""
    assert sorted(set(damped("gauss", 22).mode)) == [0, 1, 2]
    assert sorted(set(damped("gauss", 20).mode)) == [0, 1]
    assert damped("gauss", 20).limit == pytest.approx(2 * 20 / PERIOD / (2 * np.pi))
    none = damped("gauss", 2)
    assert len(none.multipliers) == 0
    none.refuse_unstable()
    none.refuse_resonance()


def test_what_diverges_faster_than_the_steps_follow_is_not_left_out():
    """``x'' = s^2 x`` grows by ``exp(s T)``; Gauss points make less of it, but never nothing."""
    time = places(Tableau.of("gauss", 3).points, 10)
    matrices = oscillators(time, np.array([20.0, 30.0]), np.zeros(2))
    axes, tableau = axes_of(matrices, 10), Tableau.of("gauss", 3)
    assert len(floquet(Flow(matrices, tableau, PERIOD / 10), matrices, axes, modes_of([20, 30])).multipliers) == 0
    matrices = oscillators(time, np.array([20.0, 30.0]), np.zeros(2))
    matrices.stiffness.values[:, -1] = -(30.0**2)
    found = floquet(Flow(matrices, tableau, PERIOD / 10), matrices, axes, modes_of([20, 30]))
    assert len(found.multipliers) == 1
    with pytest.raises(SolverError, match=r"unstable: .* mode 2 carries 100% of it"):
        found.refuse_unstable()


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


def test_resonance_is_found_among_many_undamped_modes():
    """A multiplier of 1 is of the same magnitude as all the others."""
    omega = np.array([2.0, 4.1, 7.3, 4 * 2 * np.pi / PERIOD, 14.2, 15.1])
    for place in range(6):
        turned = np.roll(omega, place)
        matrices = oscillators(places(Tableau.of("gauss", 3).points, 80), turned, np.zeros(6))
        flow = Flow(matrices, Tableau.of("gauss", 3), PERIOD / 80)
        found = floquet(flow, matrices, axes_of(matrices, 80), modes_of(turned))
        with pytest.raises(SolverError, match=f"mode {(3 + place) % 6 + 1} .* harmonic 4 "):
            found.refuse_resonance()


@pytest.mark.parametrize("damping", [0.0, 0.02])
@pytest.mark.parametrize("speed", [0.4, 1.0, 3.7])
def test_isotropic_rotor_in_fixed_and_in_turning_axes(speed, damping):
    """Two equal vibrations across each other: omega in fixed axes, and omega -+ speed forward and backward in turning.

    The multipliers are equal, so that eigenvectors may be any combination of both whirls.
    """
    omega, tableau, count = 1.23, Tableau.of("gauss", 3), 60
    period = 2 * np.pi / speed
    matrices = oscillators(places(tableau.points, count, period), omega * np.ones(2), 2 * damping * omega)
    angle = speed * period / count * np.arange(count)
    c, s = np.cos(angle), np.sin(angle)
    fixed = axes_of(matrices, count)
    turned, rates = np.stack([c, s, -s, c], axis=-1), speed * np.stack([-s, c, -c, -s], axis=-1)
    both, either = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    turning = LinkAxes(both, either, turned, rates, fixed.mass, fixed.link, fixed.names)
    flow, damped = Flow(matrices, tableau, period / count), omega * np.sqrt(1 - damping**2)
    for axes, shift in ((fixed, 0.0), (turning, speed)):
        found = floquet(flow, matrices, axes, modes_of([omega] * 2))
        expected = np.repeat(np.sort([abs(damped - shift), damped + shift]), 2)
        # of a step's error, (omega h)^7/100800 in each of 60, 1e-7 is left of a frequency
        assert 2 * np.pi * np.sort(found.frequency) == pytest.approx(expected, rel=1e-5, abs=1e-6)
        assert found.vibrates.all()


def test_instability_names_the_mode():
    with pytest.raises(
        SolverError,
        match=r"unstable: .* grows by 2.14656 in each cycle .* at 0\.\d+ Hz in the axes of link \w+; mode 1 carries",
    ):
        mathieu(1.0, 0.5).refuse_unstable()
    mathieu(1.0, 0.5, damping=0.4).refuse_unstable()


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


def test_growth_without_turning_is_bounded_by_what_damping_leaves_of_it():
    """Past its Euler load a strut grows at ``-c/2 + sqrt(c^2/4 + k)``; two alike grow by no more than one."""
    mass, damping, softness = np.eye(3)[None], np.diag([3.0, 3.0, 0.1])[None], np.diag([-4.0, -4.0, 9.0])[None]
    for part, rate in ((0.0, 2.0), (1.0, 1.0)):
        found = Matrices.of_full(mass, part * damping, softness, np.zeros((1, 3))).growth
        assert rate < found < 1.02 * rate


def test_a_light_coordinate_grows_faster_than_the_heaviest_tells():
    """Of M = diag(1, 1e-4) and K = diag(1, -1) the second coordinate grows by 100 1/s."""
    mass, stiffness = np.diag([1.0, 1e-4])[None], np.diag([1.0, -1.0])[None]
    found = Matrices.of_full(mass, np.zeros((1, 2, 2)), stiffness, np.zeros((1, 2))).growth
    assert 100 <= found < 105


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


@pytest.mark.parametrize("rounding", [1e-14, 1e-9, 3e-7])
def test_rounding_makes_no_multiplier(rounding):
    """What a cycle leaves of a disturbance below its rounding has no multiplier: it would be any number."""
    slow, fast = [0.5, -0.4, 0.3], np.linspace(1, 0.1, 117) ** 2
    flow = RoundedFlow(np.concatenate([slow, 0.9 * fast]), rounding)  # Gauss points hardly damp what is fast
    radau = RoundedFlow(np.concatenate([slow, 1e-7 * fast]), rounding)
    values = _slow(flow, radau, MULTIPLIERS.wanted, {})[0][0]
    if rounding > 1e-10:  # else the fast ones are found, too
        assert len(values) == 3
    for multiplier in slow:
        assert np.abs(values - multiplier).min() < 100 * rounding
    assert np.abs(values).max() < 0.9 + 1e-6


@pytest.mark.parametrize("options", [{}, {"stability_eps_ncv": 40}])  # by blocks, and by SLEPc
@pytest.mark.parametrize(("left", "all_that_count"), [(1e-10, True), (1e-7, False)])
def test_few_slow_disturbances_are_all_where_others_are_hardly_left(left, all_that_count, options):
    """Of 120 disturbances three are slow: the others need not be looked for where hardly anything is left of them."""
    slow, fast = [0.5, -0.4, 0.3], np.linspace(1, 0.1, 117) ** 2
    flow = RoundedFlow(np.concatenate([slow, 0.9 * fast]), 1e-15)
    radau = RoundedFlow(np.concatenate([slow, left * fast]), 1e-15)
    (values, _), every, _ = next(eigenpairs(flow, radau, options))
    assert every == all_that_count
    for multiplier in slow:
        assert np.abs(values - multiplier).min() < 1e-9
