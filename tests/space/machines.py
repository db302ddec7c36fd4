"""Scenes of machines in space that several tests state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import fenics_mech as fm

STEEL = {"modulus": 207e9, "density": 7800.0, "poisson": 0.3}
ALUMINIUM = {"modulus": 70e9, "density": 2700.0, "poisson": 0.3}
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)


def place(p: Sequence[float]) -> tuple[float, ...]:
    """Give a place or a direction as a scene takes it."""
    return tuple(float(x) for x in p)


def scene(links: Mapping[str, Any], joints: Mapping[str, Any], **keys: Any) -> fm.SpatialScene:
    """Make a scene without estimates of its errors, if `analysis` does not ask for them."""
    analysis = {"error_estimates": False} | dict(keys.pop("analysis", {}))
    data = {"materials": {"steel": STEEL, "aluminium": ALUMINIUM}, "links": links, "joints": joints}
    return fm.SpatialScene.read(data | keys | {"analysis": analysis})


def bar(
    first: Sequence[float], last: Sequence[float], up: Sequence[float] | None = Z, ends: str = "AB", **more: Any
) -> dict[str, Any]:
    """Give a link of one member of section "bar"; `ends` names its two points by a letter each."""
    one, other = ends
    member = {"ends": (one, other), "section": "bar", "material": "steel", "up": up} | more
    return {"points": {one: place(first), other: place(last)}, "members": {one + other: member}}


def body(points: Mapping[str, Sequence[float]], mass: float, inertia: Any, centre: Any, **more: Any) -> dict[str, Any]:
    """Give a link that does not bend."""
    rigid = {"mass": mass, "inertia": place(inertia), "centre": place(centre)} | more
    return {"points": {name: place(p) for name, p in points.items()}, "rigid": rigid}


def cantilever(places: Any, section: Any, force: Any, up: Any = Z, **keys: Any) -> fm.SpatialScene:
    """Clamp a chain of straight members at its first place, and load its last by a force.

    Each member has one element of its own `up`, if several are given, unless `mesh` says otherwise.
    """
    places, count = [place(p) for p in places], len(places) - 1
    ups = [None] * count if up is None else [place(u) for u in np.broadcast_to(np.array(up, dtype=float), (count, 3))]
    members = {
        f"m{k}": {"ends": (f"P{k}", f"P{k + 1}"), "section": "bar", "material": "made", "up": ups[k]}
        for k in range(count)
    }
    link = {"points": {f"P{k}": p for k, p in enumerate(places)}, "members": members}
    analysis = {"method": "static", "modes": 0, "stations": 2} | keys.pop("analysis", {})
    return scene(
        {"arm": link},
        {"foot": {"connect": ("ground.O", "arm.P0"), "kind": "weld"}},
        ground={"points": {"O": places[0]}},
        sections={"bar": section},
        loads={"tip": {"at": f"arm.P{count}", "force": place(force)}} if np.any(force) else {},
        analysis=analysis,
        **({"materials": {"made": STEEL}, "mesh": {"elements": 1}} | keys),
    )


def tip(result: Any) -> np.ndarray:
    """Give how far the last member's last end has moved ``(3,)`` (m)."""
    return np.asarray(result.data["deflection"].isel(member=-1, s=-1)[0])


RSSR_Q, RSSR_A = np.array([0.3, 0.1, 0.05]), np.array([0.1, 0.0, 0.0])
COUPLER, ROCKER = 0.4, 0.25  # m


def rssr_output(crank: Any) -> np.ndarray:
    """Give the rocker's angle from Z towards X by that of the crank: B is on a circle, at a distance from A."""
    crank = np.asarray(crank, dtype=float)
    way = 0.1 * np.stack([np.cos(crank), np.sin(crank), 0 * crank], axis=-1) - RSSR_Q
    reach = (np.sum(way**2, axis=-1) + ROCKER**2 - COUPLER**2) / (2 * ROCKER)
    return np.arctan2(way[..., 0], way[..., 2]) - np.arccos(reach / np.hypot(way[..., 0], way[..., 2]))


def rssr_ball(crank: Any) -> np.ndarray:
    """Give the place of B by the angle of the crank ``(..., 3)`` (m)."""
    angle = rssr_output(crank)
    return np.asarray(RSSR_Q + ROCKER * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1))


def rssr(links: Mapping[str, Any], *, balls: int = 1, **keys: Any) -> fm.SpatialScene:
    """Give an RSSR of three links "crank" (O, A), "coupler" (A, B) and "rocker" (Q, B), with one ball or two."""
    across = np.cross(Z, rssr_ball(0.0) - RSSR_A)
    fork = {"kind": "ball"} if balls == 2 else {"kind": "universal", "axes": (Z, place(across))}
    joints = {
        "O": {"connect": ("ground.O", "crank.O"), "axis": Z},
        "A": {"connect": ("crank.A", "coupler.A"), **fork},
        "B": {"connect": ("coupler.B", "rocker.B"), "kind": "ball"},
        "Q": {"connect": ("ground.Q", "rocker.Q"), "axis": Y},
    }
    ground = {"points": {"O": ORIGIN, "Q": place(RSSR_Q)}}
    return scene(links, joints, ground=ground, **({"drive": {"joint": "O", "speed": 10.0}} | keys))


def slim(a: Sequence[float], b: Sequence[float], mass: float = 1.0) -> dict[str, Any]:
    """Give the inertia of a thin rod between two places."""
    way = np.asarray(b, dtype=float) - np.asarray(a, dtype=float)
    second = mass * np.outer(way, way) / 12
    moments = np.trace(second) - np.diag(second)
    return {
        "mass": mass,
        "inertia": place(moments),
        "products": (second[0, 1], second[0, 2], second[1, 2]),
        "centre": place((np.asarray(a) + np.asarray(b)) / 2),
    }


def rod(points: Mapping[str, Sequence[float]], mass: float = 1.0) -> dict[str, Any]:
    """Give a link that is a thin rigid rod between its first two points."""
    ends = list(points.values())
    return {"points": {name: place(p) for name, p in points.items()}, "rigid": slim(ends[0], ends[1], mass)}


def rigid_rssr_links(masses: Sequence[float] = (1.0, 1.0, 1.0)) -> dict[str, Any]:
    """Give the links of an RSSR as thin rigid rods."""
    B = rssr_ball(0.0)
    return {
        "crank": rod({"O": ORIGIN, "A": RSSR_A}, masses[0]),
        "coupler": rod({"A": RSSR_A, "B": B}, masses[1]),
        "rocker": rod({"Q": RSSR_Q, "B": B}, masses[2]),
    }


RSSP_CRANK, RSSP_ROD, RSSP_P = 0.06, 0.25, np.array([0.1, 0.05, -0.04])
RSSP_N = np.array([0.9, 0.2, 0.387]) / np.linalg.norm([0.9, 0.2, 0.387])


def rssp_pin(theta: Any) -> np.ndarray:
    """Give the place of the crank's ball by its angle ``(..., 3)`` (m)."""
    theta = np.asarray(theta, dtype=float)
    return RSSP_CRANK * np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1)


def rssp_stroke(theta: Any) -> np.ndarray:
    """Give the stroke of the slider of an RSSP from P along n: it is the rod's length from the crank's ball."""
    way = rssp_pin(theta) - RSSP_P
    along = way @ RSSP_N
    return np.asarray(along + np.sqrt(RSSP_ROD**2 - np.sum(way**2, axis=-1) + along**2))


def rssp(guide: str = "slider", **keys: Any) -> fm.SpatialScene:
    """Give a rigid slider-crank in space with a rod between two balls; the slider may also be in a cylinder."""
    A, S = rssp_pin(0.0), RSSP_P + rssp_stroke(0.0) * RSSP_N
    links = {
        "crank": rod({"O": ORIGIN, "A": A}),
        "rod": rod({"A": A, "S": S}),
        "slider": body({"S": S}, 1.0, (1e-3, 1e-3, 1e-3), S),
    }
    joints = {
        "O": {"connect": ("ground.O", "crank.O"), "axis": Z},
        "A": {"connect": ("crank.A", "rod.A"), "kind": "ball"},
        "S": {"connect": ("rod.S", "slider.S"), "kind": "ball"},
        "P": {"connect": ("ground.P", "slider.S"), "kind": guide, "axis": place(RSSP_N)},
    }
    ground = {"points": {"O": ORIGIN, "P": place(RSSP_P)}}
    return scene(links, joints, ground=ground, **({"drive": {"joint": "O", "speed": 4.0}} | keys))
