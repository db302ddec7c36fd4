"""Putting the links together: a first position from rough angles, then along the branch over the drive angle."""

from __future__ import annotations

import numpy as np

from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics.loops import GROUND, Array, Loops
from fenics_mech.scene import Scene

TOLERANCE = 1e-13  # of the open loops, relative to the linkage's size
COARSE_TOLERANCE = 1e-9  # the same on the coarse branch
LARGEST_STEP = np.pi / 8  # of the drive angle, in following the branch
SMALLEST_STEP = 1e-6
LARGEST_CORRECTION = 0.15  # rad, of a predicted link angle: beyond it the step may have left the branch


def assemble(scene: Scene, loops: Loops) -> Array:
    """Coordinates of the assembled linkage at drive angle 0, from the links' rough angles; shape ``(3 links,)``."""
    guess = _place_links(scene, loops)
    q, converged = newton(loops, guess[None], np.zeros(1), iterations=50, damped=True)
    if not converged[0]:
        raise AssemblyError(
            f"the links cannot be assembled at drive angle 0: {_open_loop(loops, q[0], 0.0)}. "
            "Check the lengths and the rough angles of the links"
        )
    return q[0]


def follow(loops: Loops, start: Array, theta: Array) -> Array:
    """Coordinates at all drive angles, on the branch of the start at drive angle 0; shape ``(angles, 3 links)``.

    The branch is followed in coarse steps, which are halved where the prediction is poor; from these points Newton's
    method then takes all the angles at once.
    """
    knots, poses, rates, curvatures = _coarse_branch(
        loops, start, float(theta.min(initial=0)), float(theta.max(initial=0))
    )
    nearest = np.searchsorted((knots[1:] + knots[:-1]) / 2, theta)
    ahead = (theta - knots[nearest])[:, None]
    guess = poses[nearest] + rates[nearest] * ahead + curvatures[nearest] * ahead**2 / 2
    q, converged = newton(loops, guess, theta)
    if not converged.all():
        i = int(np.flatnonzero(~converged)[0])
        raise AssemblyError(
            f"the linkage cannot be assembled at drive angle {_degrees(theta[i])}: {_open_loop(loops, q[i], theta[i])}"
        )
    return q


def newton(
    loops: Loops,
    guess: Array,
    theta: Array,
    *,
    iterations: int = 12,
    damped: bool = False,
    tolerance: float = TOLERANCE,
) -> tuple[Array, np.ndarray]:
    """Newton's method on the loop equations of all positions at once; gives coordinates and whether they close."""
    q = guess.copy()
    size = max(float(np.abs(loops.point).max()), np.finfo(float).tiny)
    scale = np.append(np.full(2 * len(loops.joint), size), 1.0)
    for _ in range(iterations):
        residual = loops.residual(q, theta)
        closed = (np.abs(residual) < tolerance * scale * np.maximum(1, np.abs(theta))[:, None]).all(axis=1)
        if closed.all():
            break
        jacobian = loops.jacobian(q)
        if damped:  # least squares and short steps, as the guess may be far away or the Jacobian singular
            step = -np.stack([np.linalg.lstsq(j, r, rcond=1e-9)[0] for j, r in zip(jacobian, residual)])
            step *= np.minimum(1, 0.5 / np.maximum(np.abs(step[:, 2::3]).max(axis=1), 1e-300))[:, None]
        else:
            try:
                step = -np.linalg.solve(jacobian, residual[..., None])[..., 0]
            except np.linalg.LinAlgError:
                return q, closed
        q = q + step
    residual = loops.residual(q, theta)
    return q, (np.abs(residual) < 10 * tolerance * scale * np.maximum(1, np.abs(theta))[:, None]).all(axis=1)


def _coarse_branch(loops: Loops, start: Array, low: float, high: float) -> tuple[Array, Array, Array, Array]:
    """Drive angles, coordinates and their first two derivatives along the branch, in steps that the branch allows."""
    points = [(0.0, start, *_derivatives(loops, start, 0.0))]
    for sign, end in ((1.0, high), (-1.0, -low)):
        theta, q, rate, curvature = points[0]
        step = LARGEST_STEP
        while sign * theta < end:
            ahead = sign * step
            guess = q + rate * ahead + curvature * ahead**2 / 2
            found, closed = newton(loops, guess[None], np.array([theta + ahead]), tolerance=COARSE_TOLERANCE)
            if closed[0] and np.abs((found[0] - guess)[2::3]).max() < LARGEST_CORRECTION:
                theta, q = theta + ahead, found[0]
                rate, curvature = _derivatives(loops, q, theta)
                points.append((theta, q, rate, curvature))
                step = min(1.5 * step, LARGEST_STEP)
            elif (step := step / 2) < SMALLEST_STEP:
                raise AssemblyError(
                    f"the drive cannot turn beyond {_degrees(theta)}: the linkage locks there "
                    f"({loops.links[_fastest(rate)]} turns {np.abs(rate[2::3]).max():.3g} times as fast as the drive)"
                )
    points.sort(key=lambda point: point[0])
    knots, poses, rates, curvatures = zip(*points)
    return np.array(knots), np.array(poses), np.array(rates), np.array(curvatures)


def _derivatives(loops: Loops, q: Array, theta: float) -> tuple[Array, Array]:
    """First and second derivative of the coordinates by the drive angle."""
    jacobian = loops.jacobian(q[None])[0]
    driven = np.zeros(len(jacobian))
    driven[-1] = 1.0
    try:
        rate = np.linalg.solve(jacobian, driven)
        return rate, np.linalg.solve(jacobian, loops.convective(q[None], rate[None])[0])
    except np.linalg.LinAlgError as error:
        raise AssemblyError(f"the linkage is at a dead centre at drive angle {_degrees(theta)}") from error


def _place_links(scene: Scene, loops: Loops) -> Array:
    """Rough coordinates: rough angles, and each link put where its first joint with a placed body lies."""
    angles = np.array([link.angle for link in scene.links.values()] + [0.0])
    first, second = loops.driven
    if second != GROUND:  # the drive angle starts at 0
        angles[second] = angles[first]
    else:
        angles[first] = 0.0
    q = np.zeros((len(loops.links) + 1, 3))
    q[:, 2] = angles
    placed = {GROUND}
    while True:
        for (a, b), (point_a, point_b) in zip(loops.body, loops.point):
            if (a in placed) != (b in placed):
                known, new, at, arm = (a, b, point_a, point_b) if a in placed else (b, a, point_b, point_a)
                q[new, :2] = q[known, :2] + _turned(at, q[known, 2]) - _turned(arm, q[new, 2])
                placed.add(int(new))
                break
        else:
            return q[:-1].reshape(-1)


def _turned(point: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])


def _fastest(rate: Array) -> int:
    return int(np.abs(rate[2::3]).argmax())


def _open_loop(loops: Loops, q: Array, theta: float) -> str:
    gaps = loops.residual(q[None], np.array([theta]))[0, :-1].reshape(-1, 2)
    worst = int(np.linalg.norm(gaps, axis=1).argmax())
    return f"joint {loops.joint[worst]} stays open by {np.linalg.norm(gaps[worst]):.3g} m"


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.6g} deg"
