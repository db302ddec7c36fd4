"""Plane linkages drawn at random, with the places of their points over the cycle in closed form."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fenics_mech.scene import Scene

POSITIONS = 36
THETA = 2 * np.pi * np.arange(POSITIONS) / POSITIONS
EVERY = {"materials": {"m": {"modulus": 7e10, "density": 2700}}, "drive": {"joint": "O", "speed": 1.0}}
EVERY |= {"sections": {"s": {"area": 1e-4, "inertia": 1e-10, "fibre": 1e-3}}, "mesh": {"elements": 1}, "effects": ()}
EVERY |= {"analysis": {"reduction": "none"}}


def meet(p, q, from_p, from_q, side):
    """Give where circles about p and q meet; side 1 is the left of the way from p to q."""
    apart = np.abs(q - p)
    cosine = (from_p**2 + apart**2 - from_q**2) / (2 * from_p * apart)
    return p + from_p * (q - p) / apart * (cosine + 1j * side * np.sqrt(1 - cosine**2))


@dataclass
class Drawn:
    """A linkage as it is drawn: places of points over the cycle, which are complex numbers, and its joints.

    A link has its first point as origin and its second on its first axis.
    """

    ground: dict
    links: dict
    joints: dict
    blocks: tuple = ()

    def read(self, rng):
        """Give its scene; each of its links is rigid or a chain of members by the throw of a coin."""
        return Scene.read(EVERY | self.tables(rng))

    def tables(self, rng, size=1.0, rigid=0.5):
        """Give the tables `ground`, `links` and `joints` of its scene, at another size and share of rigid links."""
        links = {}
        for name, points in self.links.items():
            first = [size * place[0] for place in points.values()]
            along = np.exp(1j * np.angle(first[1] - first[0])) if len(first) > 1 else 1.0
            own = {key: pair((z - first[0]) / along) for key, z in zip(points, first)}
            links[name] = {"points": own, "angle": float(np.angle(along))}
            if name in self.blocks or rng.random() < rigid:
                links[name]["rigid"] = {"mass": 0.1, "inertia": 1e-4, "centre": pair(complex(*rng.normal(size=2)))}
            else:
                ends = list(points)
                links[name]["members"] = {
                    f"{a}{b}": {"ends": (a, b), "section": "s", "material": "m"} for a, b in pairwise(ends)
                }
        ground = {"points": {key: pair(size * z) for key, z in self.ground.items()}}
        return {"ground": ground, "links": links, "joints": self.joints}


def pair(z):
    return float(np.real(z)), float(np.imag(z))


def pins(**joints):
    return {name: {"connect": points.split()} for name, points in joints.items()}


def triangle(rng, p, q):
    """Give a third point beside the way from p to q."""
    return p + (q - p) * complex(*rng.uniform([0.2, 0.3], [0.8, 0.8]))


def crank_rocker(rng):
    """Draw four lengths by Grashof's rule with 10 % to spare, the crank the shortest; give C and the places A, B."""
    while True:
        a, b, c, d = rng.uniform([0.1, 0.3, 0.3, 0.3], [0.25, 1.0, 1.0, 1.0])
        longest = max(b, c, d)
        if 1.1 * (a + longest) < b + c + d - longest:
            break
    C, A = d * np.exp(1j * rng.uniform(-3, 3)), a * np.exp(1j * THETA)
    return C, A, meet(A, C, b, c, rng.choice([-1, 1]))


def four_bar(rng):
    C, A, B = crank_rocker(rng)
    links = {"crank": {"O": 0 * A, "A": A}, "coupler": {"A": A, "B": B, "P": triangle(rng, A, B)}}
    links["rocker"] = {"C": C + 0 * A, "B": B}
    joints = pins(O="ground.O crank.O", A="crank.A coupler.A", B="coupler.B rocker.B", C="ground.C rocker.C")
    return Drawn({"O": 0.0, "C": C}, links, joints)


def slider_crank(rng):
    a, rod, offset, along = *rng.uniform([0.1, 0.6, -0.2], [0.3, 1.2, 0.2]), np.exp(1j * rng.uniform(-3, 3))
    A = a * np.exp(1j * THETA)
    beside = offset - (A / along).imag
    B = A + along * (rng.choice([-1, 1]) * np.sqrt(rod**2 - beside**2) + 1j * beside)
    G = along * (0.3 + 1j * offset)
    joints = pins(O="ground.O crank.O", A="crank.A rod.A")
    joints["B"] = {"kind": "slot", "connect": ("ground.G", "rod.B"), "angle": float(np.angle(along))}
    rod_of = {"A": A, "B": B, "P": triangle(rng, A, B)}
    return Drawn({"O": 0.0, "G": G}, {"crank": {"O": 0 * A, "A": A}, "rod": rod_of}, joints)


def inverted(rng):
    """Let the crank pin travel in a guide beside the rocker's pivot: sin(turn of the guide) = offset/distance."""
    a, d, offset = rng.uniform([0.1, 0.5, -0.15], [0.25, 0.9, 0.15])
    C, bend = d * np.exp(1j * rng.uniform(-3, 3)), np.exp(1j * rng.uniform(-3, 3))
    A = a * np.exp(1j * THETA)
    guide = (A - C) / np.abs(A - C) * np.exp(-1j * np.arcsin(offset / np.abs(A - C)))  # its direction
    H, own = C + guide * 1j * offset, guide / bend  # a point of the guide; the rocker's first axis
    links = {"crank": {"O": 0 * A, "A": A}, "rocker": {"C": C + 0 * A, "D": C + 0.4 * own, "H": H}}
    joints = pins(O="ground.O crank.O", C="ground.C rocker.C")
    slides = {"kind": "slot", "connect": ("rocker.H", "crank.A"), "angle": float(np.angle(bend))}
    if rng.random() < 0.5:  # a block between both, which turns with the guide
        links["block"] = {"K": A, "L": A + 0.1 * guide}
        joints |= pins(A="crank.A block.K")
        slides |= {"kind": "prismatic", "connect": ("rocker.H", "block.L"), "turn": float(np.angle(bend))}
    return Drawn({"O": 0.0, "C": C}, links, joints | {"S": slides}, ("block",))


def with_dyad(rng, drawn, P, of_p, Q, of_q):
    """Add two bars between two points whose distance varies, which never come into one line."""
    apart = np.abs(P - Q)
    size, share = rng.uniform(1.2, 1.6) * apart.max(), rng.uniform(0.5, 0.5 + 0.3 * apart.min() / apart.max())
    R = meet(P, Q, share * size, (1 - share) * size, rng.choice([-1, 1]))
    drawn.links |= {"left": {"P": P, "R": R}, "right": {"Q": Q + 0 * P, "R": R}}
    drawn.joints |= pins(P=f"{of_p} left.P", Q=f"{of_q} right.Q", R="left.R right.R")
    return drawn


def watt(rng):
    drawn = four_bar(rng)
    rocker = drawn.links["rocker"]
    rocker["Q"] = triangle(rng, rocker["B"], rocker["C"])
    return with_dyad(rng, drawn, drawn.links["coupler"]["P"], "coupler.P", rocker["Q"], "rocker.Q")


def stephenson(rng):
    drawn = four_bar(rng)
    drawn.ground["Q"] = drawn.ground["C"] * complex(*rng.uniform([1.5, -0.5], [2.0, 0.5]))
    return with_dyad(rng, drawn, drawn.links["coupler"]["P"], "coupler.P", drawn.ground["Q"], "ground.Q")
