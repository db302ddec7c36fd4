"""What is followed beside a motion with freedoms: its section, exponents, and multipliers where it repeats.

Source of the section: Nayfeh and Balachandran, Applied Nonlinear Dynamics (1995), chapter 7.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.geometry import PLANE, PoseMotion
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.motion import coordinates
from fenics_mech.machine.rigid_from_scene import near_links, rigid_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.analysis_options import PoincareSection
from fenics_mech.solve import Step
from fenics_mech.solve.disturbances import Growth, allowed, quarters_of
from fenics_mech.solve.repeated import RepeatedMotion

APART = 1e-5  # rad, or m, by which the motion of rigid links is differentiated
NODES = 24  # at which a step is looked at for passages, at least
NODES_IN_A_RADIAN = 4  # of a pin that turns fast
ROUNDING = 1e-12  # of the time, by which a passage may be beside the end of a step
Freedoms = Callable[[Step, Array], tuple[Array, Array]]  # places and rates at shares of a step, ``(shares, freedoms)``


@dataclass
class PoincareRecord:
    """Finds the points of the section in the steps of a motion."""

    scene: Scene  # the scene, with freedoms
    section: PoincareSection
    freedoms: Freedoms  # gives angles and strokes of the freedoms in a step, and their rates
    found: list[tuple[float, Array, Array]] = field(default_factory=list)

    def take(self, step: Step) -> None:
        """Find the points in a step that is solved."""
        for time in self._times(step):
            place, rate = self._at(step, np.array([time]))
            self.found.append((time, place[0], rate[0]))

    def labelled(self) -> xr.Dataset:
        """Label when the points are, and places and rates of the freedoms there."""
        names, along = list(self.scene.freedoms), ("section_point", "freedom")
        place, rate = (np.array([one[i] for one in self.found]).reshape(-1, len(names)) for i in (1, 2))
        time = ("section_point", np.array([one[0] for one in self.found]))
        states = {"section_place": (along, place), "section_rate": (along, rate)}
        return xr.Dataset(states, {"section_time": time, "freedom": names})

    def _at(self, step: Step, times: Array) -> tuple[Array, Array]:
        return self.freedoms(step, (times - step.t) / step.h)

    def _times(self, step: Step) -> list[float]:
        """Times in a step, its end included and its start not."""
        if self.section.joint is not None:
            return self._passages(step)
        every = self.section.every or self.scene.period
        first, last = ((at * (1 + ROUNDING)) / every for at in (step.t, step.t + step.h))
        return [every * k for k in range(math.floor(first) + 1, math.floor(last) + 1)]

    def _passages(self, step: Step) -> list[float]:
        """Times at which a freedom passes its place."""
        which, turns = list(self.scene.freedoms).index(str(self.section.joint)), self._turns

        def ahead(times: Array) -> Array:
            way = self._at(step, times)[0][:, which] - self.section.at
            return np.sin(way / 2) * np.sign(np.cos(way / 2)) if turns else way

        end, nodes = step.t + step.h, NODES
        if turns:
            rate = self._at(step, np.linspace(step.t, end, NODES))[1][:, which]
            nodes += int(NODES_IN_A_RADIAN * step.h * np.abs(rate).max())
        times = np.linspace(step.t, end, nodes)
        values, sign = ahead(times), 1.0 if self.section.direction == "+" else -1.0
        passed = (sign * values[:-1] < 0) & (sign * values[1:] >= 0)
        if turns:
            passed &= np.abs(values[1:] - values[:-1]) < 1  # half a turn away the difference jumps
        if not passed.any():
            return []
        from scipy.optimize import brentq  # noqa: PLC0415  (slow to import, and few steps pass the section)

        known = dict(zip(times.tolist(), values.tolist()))  # anew, rounding may give a value near 0 another sign

        def value(time: float) -> float:
            return known[time] if time in known else float(ahead(np.array([time]))[0])

        return [float(brentq(value, times[k], times[k + 1])) for k in np.flatnonzero(passed)]

    @property
    def _turns(self) -> bool:
        return self.scene.joints[str(self.section.joint)].kind == "revolute"


@dataclass(frozen=True)
class Beside:
    """What is followed beside a motion."""

    section: PoincareRecord | None = None
    growth: Growth | None = None  # disturbances, and what they grow by

    @classmethod
    def of(cls, scene: Scene, freedoms: Freedoms, growth: Growth | None) -> Beside:
        """Begin to follow what a scene wants to know."""
        section = scene.analysis.poincare
        return cls(None if section is None else PoincareRecord(scene, section, freedoms), growth)

    @classmethod
    def of_poses(cls, made: SceneMachine, times: Array, v: Array) -> Beside:
        """Begin to follow what a scene wants to know of a machine whose links bend."""
        # times: instants of the result, ascending ``(times,)`` (s); v: rates at the start ``(size,)``
        machine, growth = made.machine, None
        if not made.scene.freedoms:
            return cls()
        terms = [machine.terms.index(made.acting[f"freedoms.{name}"]) for name in made.scene.freedoms]

        def freedoms(step: Step, shares: Array) -> tuple[Array, Array]:
            place, rate = np.swapaxes(
                [[x.x[:, 0, 0], x.rate[:, 0, 0]] for x in (step.measured(k, shares) for k in terms)], 0, 1
            )
            return place.T, rate.T

        if made.scene.analysis.lyapunov:
            zero = np.zeros((1, machine.size))
            at = machine.moved(times[:1], zero, v[None], zero)
            found = [machine.groups[k].measure(at, machine.terms[k].near(times[:1])) for k in terms]
            places = np.array([[x.x[0, 0, 0] for x in found], [x.rate[0, 0, 0] for x in found]])
            seen = partial(_seen, terms)
            growth = Growth(_of_freedoms(made, times[:1], v, places), seen, times_of_growth(times))
        return cls.of(made.scene, freedoms, growth)

    def take(self, step: Step) -> None:
        """Follow a step that is solved."""
        for part in (self.section, self.growth):
            if part is not None:
                part.take(step)


def _seen(terms: list[int], step: Step, shares: Array, states: Array) -> Array:
    """Give what disturbances are at the freedoms: places, then rates, ``(shares, 2 freedoms, disturbances)``."""
    n, columns = step.machine.n, []
    for k in terms:
        found, group = step.measured(k, shares), step.machine.groups[k]
        gradient, turned = found.gradient[:, 0, 0], found.rate_by_variables[:, 0, 0]
        for one in np.moveaxis(states, 2, 0):
            way, faster = (group.variables(x)[:, 0] for x in (one[:, :n], one[:, n:]))
            place = np.sum(gradient * way, axis=1)
            columns.append([place, np.sum(gradient * faster + turned * way, axis=1)])
    found_of_all = np.array(columns).reshape(len(terms), states.shape[2], 2, len(shares))
    return np.moveaxis(found_of_all, (3, 2, 0, 1), (0, 1, 2, 3)).reshape(len(shares), -1, states.shape[2])


def _of_freedoms(made: SceneMachine, t: Array, v: Array, places: Array) -> Array:
    """Give disturbances of places of the freedoms, then of their rates, in which links move as they do not bend."""
    # t: instant ``(1,)`` (s); v: rates ``(size,)``; places: of the freedoms, and their rates ``(2, freedoms)``
    # Gives ``(2 n, 2 freedoms)``.
    machine, n, count = made.machine, made.machine.n, places.shape[1]
    near = near_links(made, machine.known.at(t))

    def moved(place: Array, rate: Array) -> tuple[Array, PoseMotion]:
        at = rigid_motion(made, t, near, (place[None], rate[None], 0 * rate[None])).motion
        return np.concatenate([coordinates(machine, *x)[0, :n] for x in ((at.r, 0 * at.w), (at.v, at.w))]), at

    columns = []
    for one in APART * np.eye(count):
        (ahead, at), (behind, before) = (moved(places[0] + sign * one, places[1]) for sign in (1, -1))
        turned = PLANE.vector(at.R @ np.swapaxes(before.R, -1, -2))
        ahead[:n] += coordinates(machine, 0 * at.r, turned)[0, :n]
        columns.append((ahead - behind) / (2 * APART))
    for one in np.eye(count):
        faster, still = (moved(places[0], rate)[0] for rate in (places[1] + one, places[1]))
        columns.append(np.append(np.zeros(n), (faster - still)[n:]))
    units = np.tile(machine.units[:n], 2)[:, None]
    rows, wanted = allowed(machine, float(t[0]), v[:n])[0] / units, np.stack(columns, axis=1) / units
    return np.asarray(units * (rows @ np.linalg.lstsq(rows, wanted, rcond=None)[0]))


def times_of_growth(times: Array) -> Array:
    """Give the instants at which the growth is wanted (s), by those of the result, ascending ``(times,)``."""
    return np.union1d(times, quarters_of(times))


def beside_motion(beside: Beside | None, time: Array, repeated: RepeatedMotion | None) -> xr.Dataset:
    """Label what is found beside a motion."""
    # time: times of the positions (s), ``(times,)``
    found = xr.Dataset()
    if beside is not None and beside.section is not None:
        found = beside.section.labelled()
    if beside is not None and beside.growth is not None:
        found = found.merge(_of_growth(beside.growth.of_each, time))
    return found if repeated is None else found.merge(_of_repeated(repeated), combine_attrs="no_conflicts")


def _of_growth(of_each: list[tuple[float, Array]], time: Array) -> xr.Dataset:
    """Logarithms of what disturbances grow by, and the exponents: their rates over the second half of the motion."""
    ends = np.append(time[0], [end for end, _ in of_each])
    grown = np.vstack([np.zeros_like(of_each[0][1]), *(growth for _, growth in of_each)])
    at = np.stack([np.interp(time, ends, column) for column in grown.T], axis=1)
    quarters = quarters_of(time)
    there = np.stack([np.interp(quarters, ends, column) for column in grown.T], axis=1)
    rates = np.diff(there, axis=0) / np.diff(quarters)[:, None]
    exponents = (there[-1] - there[0]) / (quarters[-1] - quarters[0])
    order = np.argsort(-exponents, kind="stable")
    of_all: dict[str, Any] = {
        "lyapunov_exponent": ("exponent", exponents[order]),
        "lyapunov_change": ("exponent", np.abs(rates[1] - rates[0])[order]),
        "disturbance_growth": (("theta", "exponent"), at[:, order]),
    }
    return xr.Dataset(of_all, {"exponent": np.arange(1, len(order) + 1)})


def _of_repeated(repeated: RepeatedMotion) -> xr.Dataset:
    """Multipliers of a motion that repeats, and its period."""
    attributes = {"repeats_after": repeated.period, "own_period": int(repeated.own), "closing_error": repeated.change}
    values = repeated.multipliers
    if not len(values):
        return xr.Dataset(attrs=attributes)
    parts = np.stack([values.real, values.imag], axis=1)
    rates = np.log(np.maximum(np.abs(values), np.finfo(float).tiny)) / repeated.period
    of_all: dict[str, Any] = {"multiplier": (("disturbance", "part"), parts), "growth_rate": ("disturbance", rates)}
    return xr.Dataset(of_all, {"disturbance": np.arange(1, len(values) + 1), "part": ["real", "imaginary"]}, attributes)
