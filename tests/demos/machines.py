"""Machines with joints that no demo has, for the tests."""

from fenics_mech.scene import Scene
from fenics_mech.scene.factories import slider_crank

STEEL = {"modulus": "206 GPa", "density": "7850 kg/m^3"}
STRIP = {"shape": "rectangle", "width": "20 mm", "height": "5 mm"}


def scene(links, joints, drive, ground, **rest):
    """Make a scene in which every link with `ends` is one strip of steel."""
    bodies = {}
    for name, link in links.items():
        body = dict(link)
        if "ends" in body:
            body["members"] = {"beam": {"ends": body.pop("ends"), "section": "strip", "material": "steel"}}
        bodies[name] = body
    data = {
        "materials": {"steel": STEEL},
        "sections": {"strip": STRIP},
        "ground": {"points": ground},
        "links": bodies,
        "joints": joints,
        "drive": drive,
        "damping": {"ratio": 0.02},
        "analysis": {"modes": 2},
    }
    return Scene.read(data | rest)


def rigid_crank():
    """A slider-crank with a rigid crank and an inclined guide."""
    return slider_crank(
        crank=0.06,
        rod=0.3,
        sections=[STRIP] * 2,
        material=STEEL,
        speed="40 rad/s",
        offset=0.02,
        guide_angle="30 deg",
        masses=(0.0, 0.2),
        rigid_crank={"mass": 0.3, "inertia": 2e-4, "centre": (0.02, 0.0)},
        damping={"ratio": 0.02},
        analysis={"modes": 3},
    )


def piston():
    """A slider-crank whose slider is a rigid body that cannot turn, its pin beside its centre of mass."""
    links = {
        "crank": {"points": {"O": (0, 0), "A": (0.05, 0)}, "ends": ("O", "A")},
        "rod": {"points": {"A": (0, 0), "B": (0.25, 0)}, "ends": ("A", "B")},
        "piston": {
            "points": {"B": (0.01, 0.005), "G": (0, 0)},
            "rigid": {"mass": 0.3, "inertia": 1e-4, "centre": (0.03, 0.002)},
        },
    }
    joints = {
        "O": {"connect": ("ground.O", "crank.O")},
        "A": {"connect": ("crank.A", "rod.A")},
        "B": {"connect": ("rod.B", "piston.B")},
        "G": {"kind": "prismatic", "connect": ("ground.G", "piston.G"), "angle": "20 deg", "turn": "15 deg"},
    }
    return scene(links, joints, {"joint": "O", "speed": "30 rad/s"}, {"O": (0, 0), "G": (0, 0.01)})


def swinging_block():
    """An inverted slider-crank: the rod slides through a block that swivels on the ground, its pin is the ground's."""
    links = {
        "crank": {"points": {"O": (0, 0), "A": (0.08, 0)}, "ends": ("O", "A")},
        "rod": {"points": {"A": (0, 0), "B": (0.4, 0)}, "ends": ("A", "B"), "angle": "0 deg"},
    }
    joints = {
        "O": {"connect": ("ground.O", "crank.O")},
        "A": {"connect": ("crank.A", "rod.A")},
        "C": {"kind": "slot", "connect": ("rod.B", "ground.C"), "member": "beam"},
    }
    rest = {"masses": {"B": {"at": "rod.B", "mass": 0.1}}, "mesh": {"elements": 1}}
    return scene(links, joints, {"joint": "O", "speed": "20 rad/s"}, {"O": (0, 0), "C": (0.2, 0)}, **rest)


def swinging_rod():
    """The same, with a pin of the ground that travels over several elements."""
    return swinging_block().changed(mesh__elements=6)


def crane():
    """A boom lifted by a cylinder: the stroke along the flexible barrel is driven by a law."""
    links = {
        "boom": {"points": {"O": (0, 0), "B": (0.4, 0), "E": (0.7, 0)}, "angle": "60 deg"},
        "barrel": {"points": {"C": (0, 0), "D": (0.35, 0)}, "ends": ("C", "D"), "angle": "80 deg"},
        "piston": {"points": {"P": (0, 0), "B": (0.3, 0)}, "ends": ("P", "B"), "angle": "80 deg"},
    }
    links["boom"]["members"] = {
        name: {"ends": tuple(name), "section": "strip", "material": "steel"} for name in ("OB", "BE")
    }
    joints = {
        "O": {"connect": ("ground.O", "boom.O")},
        "C": {"connect": ("ground.C", "barrel.C")},
        "P": {"kind": "prismatic", "connect": ("barrel.C", "piston.P"), "member": "beam"},
        "B": {"connect": ("piston.B", "boom.B")},
    }
    law = {"kind": "harmonics", "mean": 0.15, "cosine": [0.08], "sine": [0.0, 0.01]}
    drive = {"joint": "P", "law": law, "period": "1.5 s"}
    masses = {"E": {"at": "boom.E", "mass": 0.5, "inertia": 1e-3}}
    return scene(links, joints, drive, {"O": (0, 0), "C": (0.3, -0.1)}, masses=masses)


def welded_arm():
    """A rocker of two links welded at an angle, in a four-bar with a rigid coupler."""
    links = {
        "crank": {"points": {"O": (0, 0), "A": (0.08, 0)}, "ends": ("O", "A")},
        "coupler": {
            "points": {"A": (0, 0), "B": (0.25, 0)},
            "rigid": {"mass": 0.2, "inertia": 1e-3, "centre": (0.1, 0.02)},
        },
        "rocker": {"points": {"C": (0, 0), "B": (0.2, 0)}, "ends": ("C", "B")},
        "arm": {"points": {"B": (0, 0), "E": (0.15, 0)}, "ends": ("B", "E")},
    }
    links["coupler"]["angle"], links["rocker"]["angle"], links["arm"]["angle"] = "45 deg", "90 deg", "50 deg"
    joints = {
        "O": {"connect": ("ground.O", "crank.O")},
        "A": {"connect": ("crank.A", "coupler.A")},
        "B": {"connect": ("coupler.B", "rocker.B")},
        "C": {"connect": ("ground.C", "rocker.C")},
        "W": {"kind": "weld", "connect": ("rocker.B", "arm.B"), "angle": "-40 deg"},
    }
    links["rocker"]["points"] = {"C": (0, 0), "W": (0.1, 0), "B": (0.2, 0)}
    links["rocker"].pop("ends")
    links["rocker"]["members"] = {
        name: {"ends": tuple(name), "section": "strip", "material": "steel"} for name in ("CW", "WB")
    }
    joints["W"]["connect"] = ("rocker.W", "arm.B")
    masses = {"E": {"at": "arm.E", "mass": 0.1}}
    return scene(links, joints, {"joint": "O", "speed": "15 rad/s"}, {"O": (0, 0), "C": (0.25, 0)}, masses=masses)


MACHINES = {f.__name__: f for f in (rigid_crank, piston, swinging_block, swinging_rod, crane, welded_arm)}
