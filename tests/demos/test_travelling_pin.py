"""A pin that travels along a member that bends: P and its derivatives, the kink in the moment, statics at any place."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.machine.linkage import solve_motion


def test_moment_has_its_kink_at_the_pin(scene_of):
    # beside the pin the shear force jumps by the pin's force across the rocker, and the moment is continuous
    scene = scene_of("quick_return").changed(
        analysis__method="quasi-static", analysis__sub_intervals=24, analysis__stations=2001
    )
    data = analyse(scene).data
    motion = solve_motion(scene, data["theta"].to_numpy())
    normal = np.stack([-np.sin(motion.angle[:, 1]), np.cos(motion.angle[:, 1])], axis=-1)
    force = -np.sum(data["joint_force"].sel(joint="A").to_numpy() * normal, axis=1)  # of the pin on the rocker
    place = np.linalg.norm(motion.of_point("crank", (0.08, 0))[0], axis=1) / 0.4
    rocker = data.sel(member="rocker")
    moment, shear, s = rocker["moment"].to_numpy(), rocker["shear_force"].to_numpy(), data["s"].to_numpy()
    step = s[1] * 0.4
    for k, p in enumerate(place):
        after = int(np.searchsorted(s, p + 1e-9))  # first station beyond the pin
        # the pin rides on the bent rocker, beside its rigid place; and inertia over three stations
        assert shear[k, after + 1] - shear[k, after - 2] == pytest.approx(force[k], rel=0.06)
        slope = np.diff(moment[k]) / step
        kinks = np.abs(np.diff(slope))
        assert abs(int(kinks.argmax()) + 1 - after) <= 1
        assert np.abs(moment[k, after] - moment[k, after - 1]) < 1.01 * step * np.abs(shear[k]).max()


class _Held:
    """A system whose nodal displacements are given."""

    def __init__(self, system, nodal):
        self.beams, self.motion, self.terms, self.to_links = system.beams, system.motion, system.terms, lambda q: nodal
        self.transformation, self.spin = system.transformation, None


def _nodes(mesh, member):
    cells = mesh.cell_nodes[mesh.cell_member == member]
    return np.append(cells[:, 0], cells[-1, 1])


def _under_force(x, a, length):
    """EI w, EI w' and M = EI w'' of a simply supported beam under a unit force at a."""
    b = length - a
    beyond = np.maximum(x - a, 0)
    w = b * x * (length**2 - b**2 - x**2) / (6 * length) + beyond**3 / 6
    slope = b * (length**2 - b**2 - 3 * x**2) / (6 * length) + beyond**2 / 2
    return w, slope, -b * x / length + beyond


def _under_couple(x, a, length):
    """The same under a unit couple at a, counter-clockwise: the derivative of the force's by minus a."""
    beyond, b = np.maximum(x - a, 0), length - a
    w = x * (length**2 - 3 * b**2 - x**2) / (6 * length) + beyond**2 / 2
    slope = (length**2 - 3 * b**2 - 3 * x**2) / (6 * length) + beyond
    return -w, -slope, x / length - (x > a)
