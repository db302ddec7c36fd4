"""A strip between two points of the ground, as the textbooks load it."""

from fenics_mech.scene import Scene

E, INERTIA, A, RHO, L = 71e9, 8.67e-12, 4.06e-5, 2714.0, 0.4
STATIC = {"method": "static"}


def beam(joints, **rest):
    """A strip from O to B; points O and B of the ground are at its ends."""
    return Scene.read(
        {
            "materials": {"aluminium": {"modulus": E, "density": RHO}},
            "sections": {"strip": {"area": A, "inertia": INERTIA, "fibre": 8e-4}},
            "ground": {"points": {"O": (0, 0), "B": (L, 0)}},
            "links": {
                "beam": {
                    "points": {"O": (0, 0), "B": (L, 0)},
                    "members": {"OB": {"ends": ("O", "B"), "section": "strip", "material": "aluminium"}},
                }
            },
            "joints": {name: {"connect": (f"ground.{name}", f"beam.{name}")} | kind for name, kind in joints.items()},
            "analysis": STATIC,
        }
        | rest
    )
