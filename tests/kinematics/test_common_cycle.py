"""Drives whose cycles differ and have a common one, against the same motion stated over that."""

import math

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene

LENGTH = 0.5


def bar():
    return {
        "points": {"A": (0, 0), "B": (LENGTH, 0)},
        "members": {"AB": {"ends": ("A", "B"), "section": "strip", "material": "steel"}},
    }


def arm(first, second, **rest):
    """Two bars, the first driven against the ground and the second against the first."""
    data = {
        "materials": {"steel": {"modulus": 200e9, "density": 7800.0}},
        "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.01}},
        "ground": {"points": {"O": (0, 0)}},
        "links": {"upper": bar(), "fore": bar()},
        "joints": {"O": {"connect": ("ground.O", "upper.A")}, "E": {"connect": ("upper.B", "fore.A")}},
        "drive": [{"joint": "O"} | first, {"joint": "E"} | second],
        "effects": ("coupling",),
        "mesh": {"elements": 1},
        "damping": {"ratio": 0.02},
        "analysis": {"solver": "collocation", "sub_intervals": 120, "stages": 3, "allow_coarse": True},
    }
    return Scene.read(data | rest)


def swing(period, *sine, **rest):
    return {"law": {"kind": "harmonics", "sine": sine} | rest, "period": period}


SHAKEN = {"p": {"at": "fore.B", "force": (0, 1.0), "factor": {"kind": "harmonics", "cosine": (0.5, 1.0)}}}


@pytest.mark.parametrize("method", ["periodic", "quasi-static"])
@pytest.mark.parametrize(
    ("drives", "by_hand"),
    [
        (  # 2 s and 1 s
            (swing(2.0, 0.5, 0.1), swing(1.0, 0.3, 0.05, mean=0.4)),
            (swing(2.0, 0.5, 0.1), swing(2.0, 0.0, 0.3, 0.0, 0.05, mean=0.4)),
        ),
        (  # 2 s and 3 s: neither is the common cycle, of 6 s
            (swing(2.0, 0.5, 0.1), swing(3.0, 0.3, 0.05, mean=0.4)),
            (swing(6.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.1), swing(6.0, 0.0, 0.3, 0.0, 0.05, mean=0.4)),
        ),
    ],
)
def test_motion_is_that_stated_over_the_common_cycle(drives, by_hand, method):
    found, expected = (
        analyse(arm(*pair, loads=SHAKEN).changed(analysis__method=method)).data for pair in (drives, by_hand)
    )
    for name in ("time", "strain", "joint_force", "input_torque", "deflection"):
        size = float(np.abs(expected[name]).max())
        # the loops are closed to 1e-13, of which accelerations and linear readings leave less than 1e-7
        assert np.abs(found[name] - expected[name]).max() < 2e-7 * size, name


@pytest.mark.parametrize(
    ("speed", "period", "common"), [(-2 * math.pi, 1.5, 3.0), (2 * math.pi, 0.5, 1.0), (math.pi, 3.0, 6.0)]
)
def test_time_derivatives_of_drives_with_a_common_cycle(speed, period, common):
    """A crank at constant speed, and a forearm that swings against it, by the law's own derivatives."""
    scene = arm({"speed": speed, "start": 0.2}, swing(period, 0.3, mean=0.4))
    assert scene.period == pytest.approx(common, rel=1e-14)
    motion = solve_motion(scene, scene.drive_angles(17))
    time, w = motion.time, 2 * np.pi / period
    assert time[-1] == pytest.approx(common * 16 / 17, rel=1e-14)
    upper = 0.2 + speed * time, np.full(17, speed), np.zeros(17)
    swung = 0.4 + 0.3 * np.sin(w * time), 0.3 * w * np.cos(w * time), -0.3 * w**2 * np.sin(w * time)
    for found, first, relative in zip((motion.angle, motion.omega, motion.alpha), upper, swung):
        expected = np.column_stack([first, first + relative])
        assert np.allclose(found, expected, rtol=0, atol=1e-10 * max(1, np.abs(expected).max()))


@pytest.mark.parametrize(
    ("first", "second", "told"),
    [
        ({"speed": 1.0}, {"speed": 2.0000001}, "6.28318530718 s at joint O, 3.14159249651 s at joint E"),
        (swing(2.0, 0.5), swing(math.pi, 0.3), "2 s at joint O, 3.14159265359 s at joint E"),
        (swing(2.0, 0.5), swing(2.0000001, 0.3), "2 s at joint O, 2.0000001 s at joint E"),
        (swing(2.3, 0.5), swing(2.0, 0.3), None),  # 20 of 2.3 s
        (swing(2.1, 0.5), swing(2.3, 0.3), "2.1 s at joint O, 2.3 s at joint E"),  # 23 of 2.1 s
    ],
)
def test_drives_without_a_short_common_cycle_are_refused(first, second, told):
    if told is None:
        assert arm(first, second).period == pytest.approx(46.0, rel=1e-14)
        return
    with pytest.raises(SceneError, match=f"no common cycle of at most 20 cycles of the first: theirs take {told}"):
        arm(first, second)


def test_law_that_repeats_is_seen_as_often():
    """As many positions in each of its own cycles are needed as it takes by itself."""
    law = swing(0.1, *([0.0] * 9), 0.3)
    alone = arm(law, swing(0.1, 0.1)).drives[0]
    need = alone.enough_angles(8, 2 * math.pi / 0.1)
    scene = arm(law, swing(0.5, 0.1))
    assert scene.drives[0].turns_in(scene.cycle_rate) == 5
    assert scene.drives[0].enough_angles(40, scene.cycle_rate) == 5 * need
