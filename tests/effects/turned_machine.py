"""A four-bar whose links bend far, by moments, a force that follows, and springs and dampers of its pins."""

from fenics_mech.scene.factories import seed_four_bar

SPEED, RETARDATION = 15.0, 3e-3
MOMENT = {
    "at": "follower.B",
    "force": (0, 0),
    "moment": 2.5,
    "factor": {"kind": "harmonics", "mean": 1, "sine": (0.5,)},
}
ACTING = {
    "loads": {"moment": MOMENT, "turning": {"at": "coupler@0.5", "force": (0.0, 35.0), "follows": True}},
    "springs": {"B": {"joint": "B", "stiffness": 4.0}, "C": {"joint": "C", "stiffness": 6.0}},
    "dampers": {"B": {"joint": "B", "damping": 0.06}, "C": {"joint": "C", "damping": 0.08}},
}


def four_bar(acting=("loads", "springs", "dampers"), elements=4, **changes):
    """Give the seed with some of what acts on rotations."""
    changes = {"analysis__sub_intervals": 120, "mesh__elements": elements} | changes
    return seed_four_bar(damping={"material": RETARDATION}).changed(
        effects=("coupling", "large-rotations"),
        drive__speed=SPEED,
        analysis__stability=False,
        analysis__allow_coarse=True,
        **{name: ACTING[name] for name in acting},
        **changes,
    )
