"""Elements with places inside: closed forms, an elastica, and few unknowns against many elements."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.estimate import finer_mesh
from fenics_mech.geometry import PLANE, SPACE
from fenics_mech.joints import Ride
from fenics_mech.machine import Machine, Row
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.section_forces import end_forces, inside
from fenics_mech.solve import (
    axial_forces,
    damp_modes,
    equilibrium,
    frequencies,
    periodic,
    quasi_static,
    rigid_cycle,
    tangents_at,
)
from fenics_mech.solve.stages import radau
from fenics_mech.terms import Element, Look, Measure, ModalDamping, Shapes, hermite_mass
from tests.common import DEMOS
from tests.machine.builders import Bar, Members, load, seed
from tests.machine.test_residual import Moving
from tests.solve.linear_theory import iterates
from tests.solve.test_statics import CRITICAL, column, softest

PERIOD = 2 * np.pi / 32.3
LINE_MASS = np.array([0.290398, 0.1101884, 0.1101884])  # of the seed's members


def test_without_places_inside_the_numbers_are_those_of_a_cubic():
    """12 EI/L and EI/L, where the turn's mode of degree 1 is twice the shear mode; and Hermite's mass."""
    shapes, uniform = Shapes(0), Element.uniform(0.3, 5.0, [2.0])
    scale = np.diag([1.0, 0.5, 1.0])[[0, 2, 1]]  # stretch, curvature mode, shear mode
    np.testing.assert_allclose(shapes.stiffness(0.3, 5.0, 2.0), scale @ uniform.stiffness @ scale.T, atol=1e-13)
    np.testing.assert_allclose(shapes.mass(0.3, 1.7), hermite_mass(0.3, 1.7), atol=1e-14)


def two_elements(inner):
    """Build two elements with arms at all ends, tapers and modes of stress, in a chart that moves."""
    rng = np.random.default_rng(inner)
    machine = Machine(PLANE, rng.normal(size=2))
    places = rng.normal(size=(3, 2))
    poses = [machine.add_pose(place, PLANE.turn(rng.normal(size=1))) for place in places]
    pairs, elements = [], []
    for k in range(2):
        way, arms = places[k + 1] - places[k], 0.1 * rng.normal(size=(2, 2))
        axes = [PLANE.axes(way) @ PLANE.turn(0.2 * rng.normal(size=1)) for _ in range(2)]
        ends = [machine.end(poses[k + j], places[k + j] + arms[j], axes[j]) for j in range(2)]
        pairs.append((ends[0], ends[1]))
        length = float(np.linalg.norm(way))
        elements.append(Element.with_places(inner, length, 5.0, lambda x: 2.0 + x, lambda x: 2.0 - x, 0.3))
    machine.add_beams(pairs, elements, 0.1)
    patterns, root = rng.normal(size=(2, 3 + 2 * inner, 4)), rng.normal(size=(4, 2))
    machine.terms[0].modal = ModalDamping(patterns, np.zeros(1), (root @ root.T)[None], 2)
    machine.chart = Moving(machine, rng)
    return machine, rng


@pytest.mark.parametrize("inner", [1, 2, 4])
def test_tangents_are_the_differences_of_the_residual(inner):
    machine, rng = two_elements(inner)
    state = [0.1 * rng.normal(size=(1, machine.size)) for _ in range(3)]
    found = machine.residual(np.zeros(1), *state)
    step = 1e-6
    largest = max(np.abs(values).max() for values in (found.K, found.C, found.M))
    for unknown, values in enumerate((found.K, found.C, found.M)):
        differences = np.empty((machine.size, machine.size))
        for j in range(machine.size):
            sides = []
            for sign in (1, -1):
                moved = [x.copy() for x in state]
                moved[unknown][0, j] += sign * step
                sides.append(machine.residual(np.zeros(1), *moved, tangents=False).force[0])
            differences[:, j] = (sides[0] - sides[1]) / (2 * step)
        # rounding of forces, which are as large as K
        np.testing.assert_allclose(machine.pattern.matrix(values[0]).toarray(), differences, atol=3e-9 * largest)


def test_elements_do_the_power_that_they_take():
    machine, rng = two_elements(3)
    machine.chart = None
    machine.masses.entries.clear()
    machine.gravity[:] = 0.0
    q, v = (0.1 * rng.normal(size=(1, machine.size)) for _ in range(2))
    q[:, machine.n :] = v[:, machine.n :] = 0.0
    found = machine.residual(np.zeros(1), q, v, np.zeros_like(q), tangents=False)
    taken = sum(float(term.power.sum()) for term in found.terms)
    np.testing.assert_allclose(found.force[0, : machine.n] @ v[0, : machine.n], taken, rtol=1e-12)


@pytest.mark.parametrize(("inner", "bound"), [(1, 5e-6), (2, 4e-6)])
def test_a_column_of_one_element_buckles_at_its_load(inner, bound):
    """By the closed form of `tests/solve/test_statics.py`; 3.7e-6 is axial shortening, which it leaves out."""
    least = lambda force: softest(column(1, force, inner=inner)[0])  # noqa: E731
    found = brentq(least, 0.7 * CRITICAL, 1.6 * CRITICAL, xtol=1e-9 * CRITICAL)
    assert abs(found / CRITICAL - 1) < bound


def cantilever(inner, force, count=1):
    """Clamp a beam of length 1 and EI 1 that does not stretch, push its tip across; give the machine and its tip."""
    machine = Machine(PLANE)
    root, tip = machine.add_pose(np.zeros(2), fixed="place and turn"), machine.add_pose(np.array([1.0, 0.0]))
    members = Members(machine)
    members.add(root, tip, count, Bar(1e7, [1.0], 1.0), inner=inner)
    members.done()
    load(machine, machine.end(tip), 1, force)
    return machine, tip


@pytest.mark.parametrize(
    ("force", "inner", "bound"), [(1.0, 1, 4e-4), (1.0, 2, 1e-5), (1.0, 3, 2e-7), (3.0, 3, 2e-5), (3.0, 4, 5e-7)]
)
def test_the_tip_of_one_element_is_that_of_an_elastica(force, inner, bound):
    """By an own inextensible elastica; the tip turns by 0.46 and 0.99 rad. Two halves without places: 3e-4, 2e-3."""

    def end(moment):
        along = lambda s, y: [y[1], -force * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]  # noqa: E731
        return solve_ivp(along, (0, 1), [0, moment, 0, 0], rtol=1e-12, atol=1e-14).y[:, -1]

    exact = end(brentq(lambda moment: end(moment)[1], 0, force, xtol=1e-14))
    machine, tip = cantilever(inner, force)
    q, _ = equilibrium(machine)
    moved = q[machine.places[tip]]
    deflection = exact[2:] - [1, 0]
    assert np.linalg.norm(moved[:2] - deflection) < bound * np.linalg.norm(deflection)
    assert abs(moved[2] - exact[0]) < bound


def test_moments_along_a_bent_element_are_those_of_its_load():
    """The force times the way along the tip's bent axis, at stations inside."""
    machine, tip = cantilever(4, 1.0)
    q, a = equilibrium(machine)
    found = machine.residual(np.zeros(1), q[None], np.zeros((1, machine.size)), a[None])
    beams, group = machine.terms[0], machine.groups[0]
    ends = end_forces(beams, group, found.terms[0], found.at)
    shares, at = np.array([0.0, 1 / 5, 3 / 5, 1.0]), np.zeros(4, dtype=int)
    moment = inside(beams, group, found.at, ends, at, shares, np.ones_like).moment
    x = [0.0, *found.at.r[0, beams.inside[0], 0][[0, 2]], found.at.r[0, tip, 0]]
    np.testing.assert_allclose(moment[0], x[-1] - np.array(x), atol=1e-8)


def middle(cycle, count):
    """Moments in the middles of the seed's members at the ends of steps, with `count` elements each."""
    machine, found = cycle.machine, cycle.evaluation
    beams, group = machine.terms[0], machine.groups[0]
    ends = end_forces(beams, group, found.terms[0], found.at)
    elements, shares = count * np.arange(3) + (count - 1) // 2, np.full(3, 0.5 if count % 2 else 1.0)
    moment = inside(beams, group, found.at, ends, elements, shares, lambda x: LINE_MASS).moment
    return moment[cycle.t.shape[1] - 1 :: cycle.t.shape[1]]


def seed_cycle(count, inner, start=None):
    machine = seed(count, inner=inner)
    machine.chart = rigid_cycle(machine, PERIOD)
    return periodic(machine, PERIOD, 120) if start is None else finer_mesh(start, machine)


def largest(values):
    return np.abs(values).max(axis=0)


@pytest.mark.parametrize("rotary", [0.0, 0.02], ids=["slender", "sections that turn"])
def test_frequencies_of_a_pinned_element_are_those_of_rayleigh(rotary):
    """w^2 = EI k^4/(m + rho I k^2), k = n pi/L; sections that turn lower the third by a quarter."""
    machine = Machine(PLANE)
    poses = [machine.add_pose(np.array([x, 0.0]), fixed=fixed) for x, fixed in ((0.0, "place"), (1.0, ""))]
    members = Members(machine)
    members.add(*poses, 1, Bar(1e7, [3.0], 2.0, rotary=[rotary]), inner=4)
    members.done()
    machine.rows.append(Row((machine.at_ground(), machine.end(poses[1])), Measure(Look.PLACE, 1)))
    M, C, K = tangents_at(machine, *equilibrium(machine))
    found = np.sort(frequencies(M, C, K, 3)[0].imag)
    k = np.pi * np.arange(1, 4)
    errors = np.abs(found / np.sqrt(3.0 * k**4 / (2.0 + rotary * k**2)) - 1)
    assert (errors < [2e-7, 3e-5, 2e-2]).all()


@pytest.mark.slow
def test_one_element_a_member_gives_the_seed_in_few_unknowns():
    """Of the largest moment, against 4 and 8 elements extrapolated; 27 unknowns in 3 elements are 1.4 % off."""
    few, many = (middle(seed_cycle(count, 0), count) for count in (4, 8))
    exact = (16 * many - few) / 15
    for inner, unknowns, bound in ((1, 15, 9e-3), (2, 21, 6e-3), (3, 27, 1e-4)):
        cycle = seed_cycle(1, inner)
        assert cycle.machine.n == unknowns
        assert len(cycle.changes) <= 6
        assert (largest(middle(cycle, 1) - exact) < bound * largest(exact)).all(), inner


@pytest.mark.slow
@pytest.mark.parametrize("inner", [1, 2])
def test_told_errors_of_the_mesh_are_those_against_two_elements_with_as_many_places(inner):
    """They are 0.7 % and 0.5 % of the peak, told by two places more."""
    cycle, exact = seed_cycle(1, inner), middle(seed_cycle(2, 3), 2)
    finer = seed_cycle(1, inner + 2, start=cycle)
    assert len(finer.changes) <= 4
    told = largest(middle(finer, 1) - middle(cycle, 1))
    np.testing.assert_allclose(told / largest(middle(cycle, 1) - exact), 1, atol=0.05)


def linear_theory(count, inner):
    """Give places and turns of the seed's joints by the geometric stiffness of static axial forces, at 20 rad/s."""
    machine, period = seed(count, 20.0, inner=inner), 2 * np.pi / 20.0
    machine.chart = rigid_cycle(machine, period)
    t = period / 60 * (np.arange(60)[:, None] + radau(3).c)
    axial = axial_forces(machine, quasi_static(machine, t.ravel()))
    (iterate,) = iterates(machine, period, 60, 1, stiffening=axial)
    return iterate.change[0][:, :9]  # the coordinates that are made first


@pytest.mark.slow
def test_axial_forces_that_vary_along_one_element_stiffen_it():
    """Against 8 elements, 2e-5 of the largest; with the mean of the axial forces alone it would be 3e-3."""
    many, one = linear_theory(8, 0), linear_theory(1, 3)
    assert np.abs(one - many).max() < 3e-5 * np.abs(many).max()


RECTANGLE = {"shape": "rectangle", "width": "25 mm"}
TAPER = {
    "sections.thick": RECTANGLE | {"height": "2.4 mm"},
    "sections.thin": RECTANGLE | {"height": "1.4 mm"},
    "sections.cone": {"shape": "taper", "from": "thick", "to": "thin"},
    "links.coupler.members.AB.section": "cone",
}
OFFSET = {"links.coupler.members.AB.offset": "2 mm", "drive.speed": "20 rad/s"}


def along_scene(changes, elements, inner):
    """Give moments along the members of the seed's scene at the ends of steps."""
    numbers = {"damping": {"material": 1e-4}, "mesh.elements": elements}
    scene = fm.load(DEMOS / "four_bar.toml").changed(
        {"effects": ("coupling", "large-rotations", "rotary-inertia")} | numbers | changes
    )
    made = machine_of(scene, inner)
    machine = made.machine
    machine.chart = rigid_cycle(machine, scene.period)
    cycle = periodic(machine, scene.period, 60)
    ends = [x[:, -1] for x in (cycle.t, cycle.q, cycle.v, cycle.a)]
    return along_members(made, machine.residual(*ends), ends[3], np.linspace(0, 1, 9)).moment


@pytest.mark.slow
@pytest.mark.parametrize("changes", [TAPER, OFFSET], ids=["taper", "offset"])
def test_one_element_of_a_scene_gives_moments_all_along(changes):
    """Of other sections, against 6 elements, which are 3e-4 and 1e-3 off: theirs come from the UFL forms."""
    many, one = along_scene(changes, 6, 0), along_scene(changes, 1, 3)
    assert (np.abs(one - many).max(axis=(0, 2)) < 1.5e-3 * np.abs(many).max(axis=(0, 2))).all()


@pytest.mark.slow
def test_modes_of_one_element_are_damped_as_those_of_many():
    """Ratios of 2 %, of the modes of 8 elements and of one: 0.1 % of the moments."""
    found = []
    for count, inner in ((8, 0), (1, 3)):
        machine = seed(count, tau=0.0, inner=inner)
        machine.chart = rigid_cycle(machine, PERIOD)
        damp_modes(machine, PERIOD, 0.02)
        found.append(middle(periodic(machine, PERIOD, 120), count))
    assert (largest(found[1] - found[0]) < 1e-3 * largest(found[0])).all()


def test_what_has_no_places_inside_is_refused():
    ends = [Machine(PLANE).at_ground()] * 2
    with pytest.raises(ValueError, match="as many places inside"):
        Machine(PLANE).add_beams([ends] * 2, [Element.with_places(inner, 1.0, 1.0, 1.0) for inner in (1, 2)])
    for inner in (0, 5):
        with pytest.raises(ValueError, match="1 to 4 places inside"):
            Element.with_places(inner, 1.0, 1.0, 1.0)
    machine, tip = cantilever(1, 1.0)
    machine.rides.append(Ride(machine.end(tip), tuple(machine.terms[0].pairs)))
    with pytest.raises(ValueError, match="rides on cubics"):
        equilibrium(machine)
    space = Machine(SPACE)
    pair = space.at_ground(), space.end(space.add_pose(np.eye(3)[0]))
    space.add_beams([pair], [Element.with_places(1, 1.0, 1.0, 1.0)])
    with pytest.raises(ValueError, match="in space have no"):
        space.groups  # noqa: B018
    members = ("crank.members.OA", "coupler.members.AB", "follower.members.CB")
    deep = {"sections.deep": RECTANGLE | {"height": "20 mm"}, **{f"links.{name}.section": "deep" for name in members}}
    deep |= {"effects": ("shear",)}
    with pytest.raises(SceneError, match="neither shear"):
        machine_of(fm.load(DEMOS / "four_bar.toml").changed(deep), 1)
