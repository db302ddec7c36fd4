"""What the analyses of a study have in common: made once, and the same result to the last bit."""

import numpy as np

from fenics_mech.planning.cycle_steps import Steps

COARSE = {"analysis.sub_intervals": 36, "analysis.allow_coarse": True, "analysis.allow_ringing": True}
SPRING = {"between": ("ground.O", "follower.B"), "stiffness": 50.0}
CASES = {  # demo, what is stated, what changes
    "truncated": ("four_bar", {}, {"drive.speed": (20, 30, -25)}),
    "coupling": ("four_bar", {"effects": ["coupling"]}, {"drive.speed": (20, 30), "damping.ratio": (0.02, 0.05)}),
    "large rotations": ("four_bar", {"effects": ["coupling", "large-rotations"]}, {"drive.speed": (20, 30)}),
    "longer steps": (
        "four_bar",
        {"effects": ["coupling", "large-rotations"], "analysis.error_estimates": False},
        {"analysis.sub_intervals": (240, 60)},
    ),
    "axial forces": ("four_bar", {"effects": ["coupling", "geometric-stiffness"]}, {"drive.speed": (20, 30)}),
    "springs": (
        "four_bar",
        {"effects": ["coupling"], "springs.s": SPRING},
        {"springs.s.stiffness": (50, 80), "drive.speed": (20, 30)},
    ),
    "sizes": ("four_bar", {}, {"sections.strip.inertia": (8.67e-12, 8e-12), "links.coupler.points.B.0": (0.27, 0.28)}),
    "quasi-static": ("quick_return", {"analysis.method": "quasi-static"}, {"drive.speed": (5, 8), "gravity.1": (0, 9)}),
}


def test_points_of_steps_stand_at_the_same_angles_at_all_speeds(seed):
    """Else what is made once at these angles would be another by rounding, and so would the result."""
    scene, places = seed.changed(analysis__sub_intervals=60), np.array([0.155, 0.5, 0.645])
    angles = [Steps.of(scene.changed(drive__speed=speed)).angles(places) for speed in np.linspace(20.0, 40.0, 14)]
    assert all(np.array_equal(one, angles[0]) for one in angles[1:])
    backwards = Steps.of(scene.changed(drive__speed=-23.0)).angles(places)
    assert np.array_equal(backwards, -angles[0])


def counted(monkeypatch, calls, module, name):
    """Count the calls of a function."""
    function = getattr(module, name)

    def counting(*arguments, **options):
        calls[name] = calls.get(name, 0) + 1
        return function(*arguments, **options)

    monkeypatch.setattr(module, name, counting)
