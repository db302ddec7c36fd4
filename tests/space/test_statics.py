"""Cantilevers in space at rest, against own rod solutions, closed forms and printed benchmarks."""

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.optimize import brentq
from scipy.special import jv

import fenics_mech as fm
from fenics_mech.errors import SolverError, UnstableError
from tests.common import ROOT
from tests.space.machines import STEEL, X, Y, Z, bar, cantilever, place, scene, tip

REFERENCE = np.load(ROOT / "tests" / "data" / "spatial" / "statics_reference.npz")


def custom(area, inertia, torsion):
    """Give a section by its numbers; fibres do not matter here."""
    return {"area": area, "inertia": inertia, "torsion": torsion, "fibre": (1e-3, 1e-3)}


def princeton(force, degrees, count):
    """Dowell and Traybar's beam (1975): clamped along X, loaded at its tip at an angle to its stiff direction."""
    high, thin, E = 12.77e-3, 3.2024e-3, 71.7e9
    torsion = high * thin**3 / 3 * (1 - 0.630 * thin / high + 0.052 * (thin / high) ** 5)
    turn = np.radians(degrees)
    return cantilever(
        [(0, 0, 0), (0.508, 0, 0)],
        custom(high * thin, (thin * high**3 / 12, high * thin**3 / 12), torsion),
        (0, force * np.cos(turn), force * np.sin(turn)),
        up=Y,
        materials={"made": {"modulus": E, "density": 2700.0, "poisson": 0.31}},
        mesh={"elements": count},
    )


@pytest.mark.parametrize("case", [(8.896, 30), (13.345, 60), (13.345, 30), (4.448, 90)])
def test_the_princeton_beam_bends_and_twists_as_a_rod(case):
    """Against an own two-point solution of an exact rod: of the order 4, 1.04e-4 at most with 4 elements."""
    exact, errors = REFERENCE["princeton_{}_{}".format(*case)], []
    for count in (2, 4):
        result = fm.analyse(princeton(*case, count))
        errors.append(np.linalg.norm(tip(result) - exact[:3]) / np.linalg.norm(exact[:3]))
    assert errors[1] < 1.2e-4
    assert np.log2(errors[0] / errors[1]) > 3.2
    axes = np.asarray(result.data["section_axes"].isel(member=0, s=-1)[0])
    twist = np.arctan2(-axes[1, 2], axes[2, 2])  # of the thin direction, seen along X, as the reference has it
    assert np.degrees(twist) == pytest.approx(exact[3], rel=1e-3, abs=1e-6)


def bend(count, force, up=Z):
    """Bathe and Bolourchi's bend (1979): 45 degrees of a circle of radius 100, of straight members."""
    angle = np.linspace(0, np.pi / 4, count + 1)
    return cantilever(
        100 * np.stack([1 - np.cos(angle), np.sin(angle), 0 * angle], axis=-1),
        custom(1.0, (1 / 12, 1 / 12), 0.140577),
        (0, 0, force),
        up,
        materials={"made": {"modulus": 1e7, "density": 1.0, "poisson": 0.0}},
    )


def test_the_45_degree_bend_tends_to_the_rod_with_order_2():
    """Straight members along an arc leave an error of h^2, which two meshes extrapolate."""
    start = 100 * np.array([1 - np.sqrt(0.5), np.sqrt(0.5), 0])
    way = REFERENCE["bend45_600"] - start
    moved = [tip(fm.analyse(bend(count, 600.0))) for count in (4, 8, 16)]
    errors = [np.linalg.norm(x - way) / np.linalg.norm(way) for x in moved]
    assert errors[0] < 5e-3
    assert errors[1] < 1.3e-3
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.1)
    best = (4 * moved[2] - moved[1]) / 3
    assert np.linalg.norm(best - way) < 1e-4 * np.linalg.norm(way)


def square_frequency(made):
    """Give the square of the lowest frequency of a loaded machine (1/s^2)."""
    return float(fm.analyse(made).data["frequency"][0, 0]) ** 2


def buckling(build, guess):
    """Extrapolate the load at which the lowest frequency vanishes, from 95, 97 and 99 % of a guess."""
    loads = guess * np.array([0.95, 0.97, 0.99])
    found = np.polyfit([square_frequency(build(load)) for load in loads], loads, 2)[-1]
    with pytest.raises((UnstableError, SolverError), match=r"buckles|not stable"):
        fm.analyse(build(1.005 * found))
    return found


def test_a_strip_buckles_sideways_at_its_closed_form():
    """Timoshenko and Gere, Theory of Elastic Stability, section 6.3: 4.013 sqrt(E I GJ)/L^2 at the tip.

    The closed form leaves out the bending before: the stiff plane is 1e6 times as stiff. E I = GJ = 1.
    """
    exact = brentq(lambda force: jv(-1 / 4, force / 2), 3, 5)

    def strip(force):
        return cantilever(
            [(0, 0, 0), (1, 0, 0)],
            custom(1e9, (1e6, 1.0), 2.0),
            (0, force, 0),
            up=Y,
            materials={"made": {"modulus": 1.0, "density": 1e-9, "poisson": 0.0}},
            mesh={"elements": 4},
            analysis={"modes": 1},
        )

    assert buckling(strip, exact) == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("count", [8])
def test_a_right_angle_frame_buckles_sideways(count):
    """Argyris and others (1979), Simo and Vu-Quoc (1986): 1.088 N at the end of a frame of 240 mm legs."""

    def frame(force):
        leg, high, thin = 0.240, 0.030, 0.6e-3
        return cantilever(
            [(0, 0, 0), (leg, 0, 0), (leg, leg, 0)],
            custom(high * thin, (thin * high**3 / 12, high * thin**3 / 12), high * thin**3 / 3),
            (force, 0, 0),
            up=[Y, X],
            materials={"made": {"modulus": 71.24e9, "density": 2700.0, "poisson": 0.31}},
            mesh={"elements": count},
            analysis={"modes": 1},
        )

    assert buckling(frame, 1.088) == pytest.approx(1.088, rel=3e-3)  # four printed digits, of ten elements a leg


TWISTED = {"length": 12.0, "width": 1.1, "thickness": 0.32, "modulus": 29e6}


@pytest.mark.parametrize(("axis", "printed"), [(2, 5.424e-3), (1, 1.754e-3)])
def test_a_twisted_cantilever_of_many_short_members(axis, printed):
    """MacNeal and Harder (1985): a strip twisted by 90 degrees, printed with shear, which is 0.2 to 0.6 % of it.

    Each of 24 members stands as the strip does in its middle. The beam itself has a closed form: the integral of the
    square of the lever over E I of both directions.
    """
    length, width, thick, E = TWISTED.values()
    count = 24
    turn = np.pi / 2 * (np.arange(count) + 0.5) / count
    # the width lies along y at the root and along z at the tip, or the other way round
    up = np.stack([0 * turn, np.cos(turn), np.sin(turn)], axis=-1)
    stiff, soft = thick * width**3 / 12, width * thick**3 / 12
    made = cantilever(
        np.linspace([0, 0, 0], [length, 0, 0], count + 1),
        {"shape": "rectangle", "height": width, "width": thick},
        1e-3 * np.eye(3)[axis],  # 1e-3 of the printed load: the beam stays straight
        up,
        materials={"made": {"modulus": E, "density": 1.0, "poisson": 0.22}},
    )
    x = np.linspace(0, length, 20001)
    along = np.pi / 2 * x / length
    share = np.cos(along) ** 2 if axis == 1 else np.sin(along) ** 2  # of the force's direction in that of the width
    exact = simpson((length - x) ** 2 * (share / stiff + (1 - share) / soft), x=x) / E
    found = 1e3 * tip(fm.analyse(made))[axis]
    assert found == pytest.approx(exact, rel=1e-3)  # steps of 4 degrees
    assert found == pytest.approx(printed, rel=7e-3)


def test_an_angle_bends_beside_its_load():
    """Gere, section 6.5: the deflection is F L^3/(3 E) by the inverse of the matrix of second moments."""
    along, across, wall, length, force = 50e-3, 30e-3, 4e-3, 1.0, (0.3, -0.7)
    parts = [(along, wall, along / 2, wall / 2), (wall, across - wall, wall / 2, (across + wall) / 2)]
    area = sum(a * b for a, b, _, _ in parts)
    y0, z0 = (sum(a * b * c[k] for a, b, *c in parts) / area for k in (0, 1))
    yy = sum(a**3 * b / 12 + a * b * (y - y0) ** 2 for a, b, y, z in parts)
    zz = sum(a * b**3 / 12 + a * b * (z - z0) ** 2 for a, b, y, z in parts)
    yz = sum(a * b * (y - y0) * (z - z0) for a, b, y, z in parts)
    outline = ((0, 0), (along, 0), (along, wall), (wall, wall), (wall, across), (0, across))
    result = fm.analyse(
        cantilever([(0, 0, 0), (length, 0, 0)], {"shape": "polygon", "outline": outline}, (0, *force), up=Y)
    )
    exact = np.linalg.solve([[yy, yz], [yz, zz]], force) * length**3 / 3 / STEEL["modulus"]
    np.testing.assert_allclose(tip(result)[1:], exact, rtol=1e-6)  # 0.1 mm in 1 m: large turns are 1e-8
    assert any("shear centre" in text for text in result.warnings)
    # M y/I at all corners, by the same matrix: sigma = (y, z) I^-1 (M of y, M of z), M = F (L - x)
    corners = np.array(outline) - [y0, z0]
    stress = -corners @ np.linalg.solve([[yy, yz], [yz, zz]], np.array(force) * length)
    found = np.asarray(result.data["stress"].isel(theta=0, member=0, s=0))
    np.testing.assert_allclose(found, stress, rtol=1e-5, atol=1e-6 * np.abs(stress).max())


def test_corners_are_stressed_by_both_bendings_and_tension_as_by_hand():
    """A bracket: a shaft along X, an arm along Z at its end; the load bends the shaft twice, pulls and twists it."""
    length, lever, height, width = 0.4, 0.15, 12e-3, 8e-3
    F = np.array([30.0, 4.0, -7.0]) * 1e-4
    up = (0.0, 0.6, 0.8)  # of the shaft
    made = cantilever(
        [(0, 0, 0), (length, 0, 0), (length, 0, lever)],
        {"shape": "rectangle", "height": height, "width": width},
        F,
        up=[up, X],
        analysis={"stations": 5},
    )
    data = fm.analyse(made).data.isel(theta=0, member=0)
    e2 = np.array(up)
    e3 = np.cross(X, e2)
    area, bending, across = height * width, width * height**3 / 12, height * width**3 / 12
    for s in (0.0, 0.5, 1.0):
        at = data.sel(s=s)
        M = np.cross([length * (1 - s), 0, lever], F)  # of what is beyond, on the section
        for corner, sigma in zip(np.asarray(at["corner_place"]), np.asarray(at["stress"])):
            y, z = corner
            by_hand = F[0] / area - M @ e3 * y / bending + M @ e2 * z / across
            assert sigma == pytest.approx(by_hand, rel=1e-5)  # small loads: turns of 1e-7
        assert len({tuple(np.sign(c)) for c in np.asarray(at["corner_place"])}) == 4
        torsion = abs(M[0]) / (0.2312 * height * width**2)  # T/(beta b h^2), of b/h = 1.5: Timoshenko and Goodier
        assert float(at["torsion_stress"]) == pytest.approx(torsion, rel=2e-3)
        largest = np.abs(np.asarray(at["stress"])).max()
        mises = np.sqrt(largest**2 + 3 * float(at["torsion_stress"]) ** 2)
        assert float(at["von_mises"]) == pytest.approx(mises, rel=1e-12)


def test_gravity_bends_a_fixed_beam_and_its_foot_carries_it():
    """The tip sinks by w L^4/(8 E I), the foot holds w L and w L^2/2."""
    length, side = 0.5, 10e-3
    made = cantilever(
        [(0, 0, 0), (length, 0, 0)],
        {"shape": "rectangle", "height": side, "width": side},
        (0, 0, 0),
        up=None,
        gravity=(0, 0, -9.81),
        mesh={"elements": 2},
        analysis={"stations": 9},
    )
    data = fm.analyse(made).data
    w = STEEL["density"] * side**2 * 9.81
    down = w * length**4 / 8 / (STEEL["modulus"] * side**4 / 12)
    assert float(data["deflection"][0, 0, -1, 2]) == pytest.approx(-down, rel=1e-6)  # 70 um of 0.5 m
    np.testing.assert_allclose(data["joint_force"][0, 0], [0, 0, w * length], rtol=1e-6, atol=1e-6 * w * length)
    np.testing.assert_allclose(
        data["joint_moment"][0, 0], [0, -w * length**2 / 2, 0], rtol=1e-6, atol=1e-6 * w * length**2
    )
    left = 1 - np.asarray(data["s"])  # share of the beam beyond each station, which is inside elements too
    moments, forces = np.asarray(data["section_moment"][0, 0]), np.asarray(data["section_force"][0, 0])
    np.testing.assert_allclose(np.abs(moments).max(axis=-1), w * (left * length) ** 2 / 2, atol=1e-6 * w * length**2)
    np.testing.assert_allclose(np.abs(forces[:, 1:]).max(axis=-1), w * left * length, atol=1e-6 * w * length)


def test_a_scene_that_is_drawn_in_other_axes_has_the_same_answer():
    """Turning all of a scene by any rotation turns its answer, and no number of a section changes."""
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    first, force, up = np.array([0.2, 0.1, 0.3]), np.array([5.0, -20.0, 14.0]), np.array([0.1, 0.9, -0.3])
    section = {"shape": "rectangle", "height": 9e-3, "width": 6e-3}
    one, other = (
        fm.analyse(
            cantilever([(0, 0, 0), R @ first], section, R @ force, R @ up, mesh={"elements": 3}, analysis={"modes": 4})
        ).data
        for R in (np.eye(3), turn)
    )
    scale = float(np.abs(one["deflection"]).max())
    np.testing.assert_allclose(
        other["deflection"][0, 0], np.asarray(one["deflection"][0, 0]) @ turn.T, atol=1e-9 * scale
    )
    for name in ("stress", "section_force", "section_moment", "frequency"):
        np.testing.assert_allclose(other[name], one[name], rtol=1e-7, atol=1e-7 * float(np.abs(one[name]).max()))


def test_two_members_of_one_link_that_meet_straight_are_one_beam():
    """Members that meet at 180 degrees, and one member of as many elements."""
    section = {"shape": "rectangle", "height": 9e-3, "width": 6e-3}
    force = (0.0, 10.0, -30.0)
    ends = np.linspace([0, 0, 0], [0.4, 0.1, 0], 3)
    two = tip(fm.analyse(cantilever(ends, section, force, mesh={"elements": 2})))
    one = tip(fm.analyse(cantilever(ends[[0, 2]], section, force, mesh={"elements": 4})))
    np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-12)


def test_a_beam_between_two_balls_and_a_brace_is_a_truss():
    """Two bars on balls carry a load by tension alone: F/(2 sin a) each."""
    made = scene(
        {"left": bar((-0.3, 0, 0), (0, 0, -0.2), Y), "right": bar((0.3, 0, 0), (0, 0, -0.2), Y, "CB")},
        {
            "L": {"connect": ("ground.L", "left.A"), "kind": "revolute", "axis": Y},
            "R": {"connect": ("ground.R", "right.C"), "kind": "revolute", "axis": Y},
            "M": {"connect": ("left.B", "right.B"), "kind": "revolute", "axis": Y},
        },
        ground={"points": {"L": place((-0.3, 0, 0)), "R": place((0.3, 0, 0))}},
        sections={"bar": {"shape": "round", "diameter": 5e-3}},
        loads={"down": {"at": "left.B", "force": (0, 0, -10.0)}},
        analysis={"method": "static", "modes": 2},
    )
    data = fm.analyse(made).data
    tension = 5.0 / np.sin(np.arctan2(0.2, 0.3))
    np.testing.assert_allclose(data["section_force"][0, :, :, 0], tension, rtol=1e-4)  # stretched by 2e-5
    assert float(np.abs(data["frequency"]).min()) > 0
