"""A slider-crank whose rod alone bends, near a dead centre: forces on its block press or draw the rod as they are."""

from __future__ import annotations

from fenics_mech import Scene

E, G = 210e9, 210e9 / 2.6
CRANK = 1e-3  # m: so short that the rod keeps its direction to 1e-3 in a whole turn, and forces theirs to 1e-6


def rod(section, loads, length=1.0, material=None, member=None, pin=None, design=None, **analysis):
    """Give the machine: a section of the rod, forces by place, and what else a scene says of strength."""
    static = not analysis
    return Scene.read({
        "name": "press",
        "materials": {"steel": {"modulus": E, "density": 7850.0, "poisson": 0.3} | (material or {})},
        "sections": {"s": section},
        "ground": {"points": {"O": (0, 0), "G": (0, 0)}},
        "links": {
            "crank": {"points": {"O": (0, 0), "A": (CRANK, 0)}, "rigid": {"mass": 1.0}},
            "rod": {
                "points": {"A": (0, 0), "B": (length, 0)},
                "members": {"AB": {"ends": ("A", "B"), "section": "s", "material": "steel"} | (member or {})},
            },
            "block": {"points": {"B": (0, 0), "G": (0, 0)}, "rigid": {"mass": 1.0}, "position": (length + CRANK, 0)},
        },
        "joints": {
            "O": {"connect": ("ground.O", "crank.O")},
            "A": {"connect": ("crank.A", "rod.A")} | ({"pin": pin} if pin else {}),
            "B": {"connect": ("rod.B", "block.B")},
            "G": {"kind": "prismatic", "connect": ("ground.G", "block.G")},
        },
        "loads": {f"F{i}": {"at": at, "force": force, **more} for i, (at, force, more) in enumerate(loads)},
        "drive": {"joint": "O", "speed": 0.01},
        "mesh": {"elements": 4},
        "design": design or {},
        "analysis": {"method": "static" if static else "quasi-static", "error_estimates": False, **analysis},
    })  # fmt: skip


def rectangle(width, height):
    return {"shape": "rectangle", "width": width, "height": height}


def along(force):
    """Force along the rod (N): tension is positive."""
    return ("block.B", (force, 0.0), {})


def middle(force, **more):
    """Force across the rod at its middle (N), in the plane."""
    return ("rod@0.5", (0.0, force), more)
