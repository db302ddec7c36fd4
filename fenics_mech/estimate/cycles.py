"""Errors of periodic motions: against the same motion by more stages, or on a finer mesh, each from what is at hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End, Fourier, Geometry, harmonics
from fenics_mech.machine import Machine
from fenics_mech.solve import Cycle, Iteration, Path, periodic
from fenics_mech.solve.newton import converge
from fenics_mech.solve.periodic import MOST, MOTION
from fenics_mech.terms import Beams, Shapes

MORE = 2  # stages in each step: where steps are long for a vibration, one more leaves a third to all of the error
MOST_STAGES = 10  # of the kernels
ENOUGH = 1e-4  # last change of Newton's method: with 1e-3 one step may do, and told over true falls to 0.8


def more_stages(stages: int) -> int:
    """Give the stages of a step by which the error of one with fewer is told."""
    return min(stages + MORE, MOST_STAGES)


def finer_steps(cycle: Cycle) -> Cycle:
    """Give the motion by two more stages in each step, whose order is higher by four.

    A quantity at the ends of the steps differs between both by the error of the steps, but for terms of that order.

    Parameters
    ----------
    cycle
        A converged motion.
    """
    path = cycle.path
    start = path.with_stages(more_stages(len(path.tableau.c)))
    return periodic(cycle.machine, path.period, start=start, tolerance=ENOUGH)


def finer_mesh(cycle: Cycle, machine: Machine) -> Cycle:
    """Give the motion of a machine with twice the elements, or with more places inside each, from that with fewer.

    Elements of Hermite polynomials have an error of order 4: 16/15 of the difference between both. With two places more
    inside, the difference is the error. One more may tell nothing: it adds no even shape, or no odd one.

    Parameters
    ----------
    cycle
        A converged motion.
    machine
        The same machine, whose elements 2 e and 2 e + 1 are the halves of element e, or the same with more places
        inside. Poses without beams have the same order, and so have the rows. Its chart is set.
    """
    start = _prolonged(cycle, machine, cycle.path.period)
    iteration = Iteration(machine, start, _axial_forces(cycle, machine))
    iteration.step()  # whose size tells nothing, as its tangents are of other forces than its places
    changes = converge(iteration, ENOUGH, MOST, MOTION)
    return Cycle(machine, iteration.path, changes)


def _axial_forces(cycle: Cycle, fine: Machine) -> list[Array | None]:
    """Give the axial forces of the coarser elements to their halves, and to other terms what they have at the start."""
    # Places between the nodes stretch stiff elements by far more than their motion does, to where they buckle.
    coarse, stresses = cycle.machine, list[Array | None]([None] * len(fine.terms))
    if 2 * len(coarse.beams.pairs) == len(fine.beams.pairs):
        known = cycle.evaluation.terms[coarse.terms.index(coarse.beams)].response.stress
        axial = known * (np.arange(known.shape[-1]) == 0)
        stresses[fine.terms.index(fine.beams)] = np.repeat(axial, 2, axis=1)
    return stresses


def finer_chart(chart: Fourier, coarse: Machine, fine: Machine) -> Fourier:
    """Give the rigid motion of a machine with finer elements by that of the coarse one: members do not bend.

    Parameters
    ----------
    chart
        The rigid motion of the coarse machine.
    coarse, fine
        As of `finer_mesh`.
    """
    r, R = _finer_poses(coarse, fine, chart.r, chart.R)
    return Fourier(chart.geometry, chart.period, r, R)


def _prolonged(cycle: Cycle, fine: Machine, period: float) -> Path:
    """Take a motion to a finer mesh: Hermite polynomials in place, Fourier series in time."""
    coarse, path = cycle.machine, cycle.path
    count = len(path.tableau.c) * len(path.starts)
    t = period / count * np.arange(count)
    q, v, a = path.when(t)
    g, n, moved = fine.geometry, fine.n, coarse.moved(t, q, v, a)
    r, R = _finer_poses(coarse, fine, moved.r, moved.R)
    chart = fine.known.at(t)
    turn = g.vector(R @ np.swapaxes(chart.R, -1, -2))
    values = np.zeros((len(t), fine.size))
    there = fine.places.ravel() >= 0
    beside = np.concatenate([r - chart.r, turn], axis=2).reshape(len(t), -1)
    values[:, fine.places.ravel()[there]] = beside[:, there]
    known = min(fine.size - n, coarse.size - coarse.n)  # multipliers, then modes of stress, of which there may be more
    values[:, n : n + known] = a[:, coarse.n : coarse.n + known]
    rates, sizes = harmonics(values, period)

    def at(instants: Array, order: int) -> Array:
        return np.asarray((np.exp(np.outer(instants, rates)) * rates**order @ sizes).real)

    of_stages = (path.starts[:, None] + path.h[:, None] * path.tableau.c).ravel()
    made = np.concatenate([at(of_stages, 2)[:, :n], at(of_stages, 0)[:, n:]], axis=1).reshape(*path.a.shape[:2], -1)
    q0, v0 = at(path.starts, 0), at(path.starts, 1)
    q0[:, n:] = v0[:, n:] = 0.0
    return replace(path, n=n, q0=q0, v0=v0, a=made)


def _finer_poses(coarse: Machine, fine: Machine, r: Array, R: Array) -> tuple[Array, Array]:
    """Give the poses of the finer elements ``(instants, poses, ...)``, by those of the coarser ones."""
    g, (whole, halves) = fine.geometry, (machine.beams for machine in (coarse, fine))
    made_r, made_R = (np.zeros((len(r), len(fine.r), *x.shape[2:])) for x in (r, R))
    for mine, theirs in zip(_without_beams(fine, halves), _without_beams(coarse, whole)):
        made_r[:, mine], made_R[:, mine] = r[:, theirs], R[:, theirs]
    if len(whole.pairs) == len(halves.pairs):
        _more_places(whole, halves, r, R, made_r, made_R)
        return made_r, made_R
    for e, (pair, element) in enumerate(zip(whole.pairs, whole.elements)):
        (p1, E1), (p2, E2) = (_end(end, r, R) for end in pair)
        d1, d2 = E1[..., 0], E2[..., 0]
        middle = (p1 + p2) / 2 + element.length / 8 * (d1 - d2)
        along = 1.5 * (p2 - p1) / element.length - (d1 + d2) / 4
        places = [(p1, E1), (middle, _half_way(g, E1, E2, along)), (p2, E2)]
        for end, (p, E) in zip((halves.pairs[2 * e][0], *halves.pairs[2 * e + 1]), places):
            made_R[:, end.pose] = E @ end.turn.T
            made_r[:, end.pose] = p - made_R[:, end.pose] @ end.offset
    return made_r, made_R


def _more_places(few: Beams, many: Beams, r: Array, R: Array, made_r: Array, made_R: Array) -> None:
    """Put in the poses of elements with more places inside, by the shapes of those with fewer."""
    shapes, shares = Shapes(few.inner), Shapes(many.inner).places
    for e, (pair, element) in enumerate(zip(few.pairs, few.elements)):
        ends = [_end(end, r, R) for end in pair]
        vectors = [x for p, E in ends for x in (p, element.length * E[..., 0])] + [r[:, k] for k in few.inside[e]]
        for theirs, mine in zip(pair, many.pairs[e]):
            made_r[:, mine.pose], made_R[:, mine.pose] = r[:, theirs.pose], R[:, theirs.pose]
        for pose, weights in zip(many.inside[e], shapes.at(shares)):
            made_r[:, pose], made_R[:, pose] = np.tensordot(weights, vectors, 1), np.eye(r.shape[-1])


def _half_way(g: Geometry, E1: Array, E2: Array, along: Array) -> Array:
    """Give axes half-way between two, turned so that the first lies along a direction."""
    c = g.vector(np.swapaxes(E1, -1, -2) @ E2)
    half = c / 2 if g.d == 2 else c / (1 + np.sqrt(1 + np.sum(c * c, axis=-1, keepdims=True) / 4))
    middle = E1 @ g.turn(half)
    e = along / np.linalg.norm(along, axis=-1, keepdims=True)
    first = middle[..., 0]
    W = e[..., :, None] * first[..., None, :] - first[..., :, None] * e[..., None, :]  # the smallest rotation
    cosine = np.sum(e * first, axis=-1)[..., None, None]
    return np.asarray((np.eye(g.d) + W + W @ W / (1 + cosine)) @ middle)


def _end(end: End, r: Array, R: Array) -> tuple[Array, Array]:
    return r[:, end.pose] + R[:, end.pose] @ end.offset, R[:, end.pose] @ end.turn


def _without_beams(machine: Machine, beams: Beams) -> list[int]:
    held = {end.pose for pair in beams.pairs for end in pair} | {pose for inside in beams.inside for pose in inside}
    return [pose for pose in range(len(machine.r)) if pose not in held]
