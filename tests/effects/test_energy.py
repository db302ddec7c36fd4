"""Energy: what the drive puts into the mechanism in a cycle, damping takes out."""

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.analysis import analyse
from tests.common import DEMOS, response_of
from tests.demos.machines import crane

SPRINGS = {
    "line": {"between": ("coupler.B", "ground.O"), "stiffness": 40.0, "length": 0.2},
    "hinge": {"joint": "C", "stiffness": 0.2},
}
DAMPERS = {"line": {"between": ("coupler.B", "ground.O"), "damping": 0.5}, "hinge": {"joint": "C", "damping": 1e-3}}
SHAFT = {"stiffness": 60.0, "damping": 0.05, "inertia": 2e-3}
PUSH = {
    "dead": {"at": "follower.B", "force": (1.0, 2.0)},
    "turning": {"at": "coupler.B", "force": (0.0, 0.5), "follows": True},
    "spread": {"member": "coupler", "line": (0.0, -2.0), "axes": "member"},
}
PULSE = {
    "push": {"at": "follower.B", "force": (1.0, 2.0), "factor": {"kind": "pulse", "start": 1.01, "end": 2.53}},
}
BLOWS = {
    "one": {"at": "coupler.B", "angle": 1.234, "impulse": (2e-3, -1e-3)},
    "turning": {"at": "follower.B", "angle": 4.0, "impulse": (1e-3, 0.0), "angular_impulse": 1e-5},
    "along": {"at": "coupler.A", "angle": 4.0, "impulse": (1e-3, 0.0)},
}
QUIET = {"analysis__stability": False, "damping__ratio": 0.0}
EVERYTHING = {
    "gravity": (0.0, -9.81),
    "damping__external": 0.5,
    "loads": {"push": {"at": "follower.B", "force": [1.0, 2.0]}},
}


def imbalance(scene):
    """What is left over in the result's balance of mean powers, over what damping takes."""
    data = analyse(scene).data
    causes = dict(zip(data["cause"].to_numpy(), data["mean_power"].to_numpy()))
    lost = -sum(
        value for cause, value in causes.items() if cause not in ("drive", "drives", "loads", "impulses", "stored")
    )
    return abs(sum(causes.values())) / lost


def test_damping_takes_out_what_the_drive_puts_in(seed):
    balance = {}
    for steps in (120, 480):
        changes = QUIET | EVERYTHING | {"damping__material": 1.339e-4, "analysis__sub_intervals": steps}
        balance[steps] = imbalance(seed.changed(effects=("coupling", "large-rotations"), **changes))
    # 6e-8 at 480 Radau steps, by an order of 4 to 6: the identity is exact, only the time scheme is not
    assert balance[480] < 2e-7
    assert balance[480] < balance[120] / 200


def test_modal_damping_takes_out_what_the_drive_puts_in(seed):
    balance = {}
    for steps in (120, 240):
        changes = QUIET | {"damping__ratio": 0.02, "analysis__sub_intervals": steps}
        balance[steps] = imbalance(seed.changed(effects=("coupling", "large-rotations"), **changes))
    # the same; with 2 % of all modes the fast ones die out more slowly, and want smaller steps: 5e-5
    assert balance[240] < 1e-4
    assert balance[240] < balance[120] / 20


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes", "largest"),
    [  # what 120 time steps leave; on the undeformed shape it is 8e-3 (slider-crank) to 6 (manipulator)
        ("four_bar", {"effects": ("coupling", "large-rotations"), "damping__external": 0.5}, 4e-3),
        ("four_bar", {"effects": ("coupling", "large-rotations"), "mesh__elements": 8}, 4e-3),
        (
            "four_bar",
            {"effects": ("coupling", "large-rotations", "rotary-inertia"), "springs": SPRINGS, "dampers": DAMPERS},
            4e-3,
        ),
        (
            "four_bar",
            {"effects": ("coupling", "large-rotations", "lumped-mass"), "analysis__allow_coarse": True},
            1.5e-2,
        ),
        (
            "four_bar",
            {"effects": ("coupling", "large-rotations"), "drive__motor": SHAFT, "analysis__sub_intervals": 80},
            8e-3,
        ),
        ("manipulator", {"effects": ("coupling", "large-rotations")}, 4e-3),
        ("slider_crank", {"effects": ("coupling", "large-rotations"), "damping__relative": 0.5}, 4e-3),
        ("quick_return", {"effects": ("coupling", "large-rotations"), "analysis__allow_coarse": True}, 4e-3),
    ],
)
def test_energy_of_the_cycle_balances_with_every_effect(name, changes, largest):
    changes = {"analysis__stability": False, "analysis__sub_intervals": 120, "analysis__stations": 3} | changes
    assert imbalance(load(DEMOS / f"{name}.toml").changed(**changes)) < largest


def test_residual_of_a_travelling_pin_is_within_the_errors_of_the_efforts():
    # 2e-5, as elements give way under the slider, whose turn has no kink at nodes
    scene = crane().changed(effects=("coupling", "large-rotations"), analysis__sub_intervals=120)
    scene = scene.changed(analysis__stations=3, analysis__stability=False, analysis__allow_coarse=True)
    data = analyse(scene).data
    assert data.attrs["power_balance_error"] < 2e-4
    assert abs(data.attrs["power_residual"]) < data.attrs["power_error"]


@pytest.mark.parametrize(
    ("changes", "largest"),
    [  # the steps take the energy that a blow gives to faster modes than they follow: 2.2e-2, and 2e-3 of the pulse
        ({"impulses": BLOWS, "effects": ("coupling", "large-rotations")}, 3e-2),
        ({"loads": PULSE, "effects": ("coupling", "large-rotations")}, 3e-3),
    ],
)
def test_energy_balances_where_forces_jump(changes, largest):
    changes |= {"analysis__stability": False, "analysis__sub_intervals": 120, "analysis__stations": 3}
    scene = load(DEMOS / "four_bar.toml").changed(analysis__allow_coarse=True, **changes)
    assert imbalance(scene) < largest


def test_dampers_do_their_work_on_the_shortening_of_bent_links():
    scene = load(DEMOS / "four_bar.toml").changed(
        effects=("coupling", "large-rotations"),
        dampers=DAMPERS,
        analysis__sub_intervals=120,
        analysis__stability=False,
        analysis__stations=3,
    )
    # 4e-5 of the dampers' power is left at 120 steps, and 2e-6 at 240. Without that work it is 1.3e-4 and 9e-5
    assert response_of(scene).data.attrs["power_balance_error"] < 6e-5


@pytest.mark.parametrize("axis", ["neutral", "middle"])
def test_energy_balances_beside_the_axes(axis):
    plies = ({"thickness": 1e-3, "material": "along"}, {"thickness": 2e-3, "material": "aluminium"})
    scene = load(DEMOS / "composite_four_bar.toml").changed(
        effects=("coupling", "large-rotations"),
        analysis__stability=False,
        analysis__sub_intervals=120,
        damping__relative=0.5,
    )
    data = scene.model_dump()
    data["sections"]["laminate"] |= {"axis": axis, "plies": plies}
    # what 120 time steps leave is 4e-3; without the centrifugal force of mass beside the axes it is 1.4 to 2.1
    assert imbalance(type(scene).model_validate(data)) < 1e-2


def test_energy_of_a_motion_in_time_balances_with_what_is_stored():
    scene = load(DEMOS / "four_bar.toml").changed(
        effects=("coupling", "geometric-stiffness"),
        analysis__method="transient",
        analysis__cycles=1,
        gravity=(0.0, -9.81),
    )
    # the energy at the ends is from the state alone, the power from the forces; samples in time leave 2e-4
    assert response_of(scene).data.attrs["power_balance_error"] < 5e-4


def test_torque_with_geometric_stiffness_is_that_of_large_rotations():
    # which has the shortening of bent links in its displacement: 9e-6 N m apart. Without the shortening's work it is
    # 25e-6, and 99e-6 without axial forces
    scene = load(DEMOS / "four_bar.toml").changed(drive__speed=12.0, damping__ratio=0.0, damping__material=1e-3)
    scene = scene.changed(analysis__stability=False, analysis__sub_intervals=120)
    geometric, large, linear = (
        response_of(scene.changed(effects=("coupling", *more))).data["input_torque"].to_numpy()
        for more in (("geometric-stiffness",), ("large-rotations",), ())
    )
    assert np.abs(geometric - large).max() < 0.2 * np.abs(linear - large).max()


def test_truncated_equation_does_not_balance(seed):
    # (5.1) drops terms of the coupling, and the result tells what that leaves over
    scene = seed.changed(effects=(), damping__material=1.339e-4, analysis__sub_intervals=240, **QUIET)
    assert imbalance(scene) > 0.1


def test_undamped_disturbances_keep_their_energy(seed):
    # C = M' + skew: the equation is Hamiltonian, and its multipliers lie on the unit circle, as far as steps follow
    changes = QUIET | {
        "analysis__stability": True,
        "analysis__allow_unstable": True,
        "analysis__allow_coarse": True,
    }
    scene = seed.changed(effects=("coupling",), analysis__sub_intervals=360, **changes)
    data = response_of(scene).data["multiplier"].to_numpy()
    off = np.abs(np.hypot(*data.T) - 1).max()
    assert off < 1e-4  # measured 4.7e-5


def test_a_machine_without_losses_balances():
    data = analyse(load(DEMOS / "four_bar.toml").changed(effects=(), analysis__method="quasi-static")).data
    assert data.attrs["power_balance_error"] < 1e-4  # rounding over rounding would be 1
    press = {"press": {"at": "coupler@0.25", "force": (1.0, -2.0)}}  # a dead load, which gives nothing over a cycle
    loaded = load(DEMOS / "four_bar.toml").changed(effects=(), analysis__method="quasi-static", loads=press)
    assert abs(analyse(loaded).data.attrs["power_residual"]) < 1e-8  # W; beside powers of 1 W
