"""A pin that travels along a member that bends: P and its derivatives, the kink in the moment, statics at any place."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_loads import PointLoad
from fenics_mech.forces.section_forces import recover_members
from fenics_mech.kinematics import solve_motion
from fenics_mech.response.setup import mechanism


@pytest.mark.parametrize(
    "name", ["quick_return", "slider_crank", "piston", "crane", "swinging_block", "rigid_crank", "jansen"]
)
def test_derivatives_of_p_against_central_differences(name, scene_of):
    scene, h = scene_of(name).changed(analysis__sub_intervals=24), 1e-5
    system, rate = mechanism(scene), scene_of(name).cycle_rate
    theta = np.linspace(0.1, 6, 9) * np.sign(rate)  # no pin passes a node there, where the second derivative jumps
    values = system.transformation.values
    here, ahead, behind = (solve_motion(scene, theta + d) for d in (0, h, -h))
    first, second = system.transformation.derivatives(here)
    difference = rate * (values(ahead) - values(behind)) / (2 * h)
    curvature = rate**2 * (values(ahead) - 2 * values(here) + values(behind)) / h**2
    assert np.abs(first).max() > 0
    assert np.abs(difference - first).max() < 1e-7 * np.abs(first).max()
    assert np.abs(curvature - second).max() < 1e-4 * np.abs(second).max()


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


@pytest.mark.parametrize("place", [0.03, 0.31, 0.5, 0.77])
@pytest.mark.parametrize("elements", [1, 3])
def test_point_load_on_a_simply_supported_beam(place, elements, scene_of):
    # w = F b x (L^2 - b^2 - x^2)/(6 EI L) before the load, by Roark; M'' = 0 beside it; a couple likewise
    length, s = 0.3, np.linspace(0, 1, 31)
    scene = scene_of("slider_crank").changed(
        analysis__sub_intervals=4, links__rod__members__AB__mesh={"elements": elements}
    )
    system = mechanism(scene)
    mesh, member = system.beams.mesh, 1
    ei = float(system.beams.rigidity.bending.mean[mesh.cell_member == member][0])
    cells, nodes = np.flatnonzero(mesh.cell_member == member), _nodes(mesh, member)
    element = cells[min(int(place * elements), elements - 1)]
    xi = place * elements - (element - cells[0])
    force, couple = -13.0, 0.4
    for across, moment, exact in ((force, 0.0, _under_force), (0.0, couple, _under_couple)):
        w, slope, bending = exact(np.array([*s, *np.linspace(0, 1, elements + 1)]) * length, place * length, length)
        scale = (across or moment) / ei
        nodal = np.zeros((4, 3 * len(mesh.node_name)))
        nodal[:, 3 * nodes + 1], nodal[:, 3 * nodes + 2] = scale * w[31:], scale * slope[31:]
        one = np.ones(4)
        load = PointLoad(np.full(4, element), xi * one, 0 * one, across * one, moment * one)
        state = recover_members(_Held(system, nodal), ElasticResponse(np.zeros((4, system.size)), 0 * nodal), s, [load])
        angle = system.motion.angle[:, 1]
        found = (
            -np.sin(angle)[:, None] * state.deflection[:, 1, :, 0]
            + np.cos(angle)[:, None] * state.deflection[:, 1, :, 1]
        )
        assert np.abs(found - scale * w[:31]).max() < 1e-9 * np.abs(scale * w).max()
        beside = np.abs(s - place) > 1e-9
        expected = (across or moment) * bending[:31]
        assert np.abs(state.moment[:, 1] - expected)[:, beside].max() < 1e-9 * np.abs(expected).max()


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
