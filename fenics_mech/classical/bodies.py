"""The motion of the links as if they were rigid (chapter 6), at any instants."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.geometry import PoseMotion
from fenics_mech.kinematics import Motion
from fenics_mech.machine.assembly import led
from fenics_mech.machine.drawn_from_scene import clock_of
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.linkage import as_motion
from fenics_mech.machine.rigid_from_scene import motion_of_bodies, poses_of_links

POSITIONS = 48  # of the cycle, through which a series gives where Newton's method begins
Known = tuple[PoseMotion, Motion]


class Bodies:
    """The motion of links that do not bend, as a chart that solves for any instants and keeps what it found."""

    still = False
    _series: NDArray[np.complex128]  # of coordinates of the links as bodies, beside what turns from cycle to cycle
    _whole: Array

    def __init__(self, made: SceneMachine, like: SceneMachine | None = None) -> None:
        self.made, self._found = made, dict[bytes, Known]()
        if like is not None and isinstance(like.machine.chart, Bodies):
            known = like.machine.chart
            self._series, self._whole = known._series, known._whole
            return
        cycle = np.arange(POSITIONS + 1.0) / POSITIONS
        near = led(made.bodies.machine, made.bodies.q[None], made.period * cycle)[0][:, 0]
        self._whole = near[-1] - near[0]
        self._series = np.fft.rfft((near - cycle[:, None] * self._whole)[:-1], axis=0) / POSITIONS
        self._series[1:-1] *= 2

    def _near(self, t: Array) -> Array:
        """Coordinates of the links as bodies near to those at some instants ``(instants, size)``."""
        phase = clock_of(self.made.scene)(t) / self.made.period
        waves = np.exp(2j * np.pi * np.outer(phase, np.arange(len(self._series))))
        return phase[:, None] * self._whole + (waves @ self._series).real

    def _known(self, t: Array) -> Known:
        if (key := t.tobytes()) not in self._found:
            times, back = np.unique(t, return_inverse=True)
            none = (np.zeros((len(times), 0)),) * 3
            q, v, a = motion_of_bodies(self.made, times, self._near(times), none)
            theta = self.made.scene.cycle_rate * clock_of(self.made.scene)(t)
            links = as_motion(self.made.bodies, theta, t, q[back], v[back], a[back])
            self._found[key] = poses_of_links(self.made, q, v, a).part(back), links
        return self._found[key]

    def links(self, t: Array) -> Motion:
        """Give the motion of the links' frames at some instants (s)."""
        return self._known(t)[1]

    def at(self, t: Array) -> PoseMotion:
        """Give the motion of all poses at some instants (s)."""
        return self._known(t)[0].part(np.arange(len(t)))  # a copy: others hold it still
