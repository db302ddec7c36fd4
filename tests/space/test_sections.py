"""Numbers of sections in space against closed forms.

Sources: Timoshenko and Goodier, Theory of Elasticity, chapter 10 (torsion); Gere, Mechanics of Materials, chapter 6
(shear centres) and chapter 12 (second moments of area).
"""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.sections import numbers_of


def polygon(outline, holes=()):
    """Give the numbers of a polygon."""
    return numbers_of(fm.SpatialPolygonSection(outline=outline, holes=holes))


def rectangle(height, width):
    """Give the corners of a rectangle whose height lies along `up`."""
    return ((0, 0), (height, 0), (height, width), (0, width))


def ellipse(a, b, corners=240):
    """Give a polygon with the area of an ellipse with these half axes."""
    angle = 2 * np.pi * np.arange(corners) / corners
    grown = np.sqrt(2 * np.pi / corners / np.sin(2 * np.pi / corners))
    return tuple((grown * a * np.cos(t), grown * b * np.sin(t)) for t in angle)


@pytest.mark.parametrize(("ratio", "constant", "modulus"), [(1, 0.1406, 0.208), (2, 0.229, 0.246), (10, 0.312, 0.312)])
def test_torsion_of_rectangles_is_that_of_the_printed_table(ratio, constant, modulus):
    """Timoshenko and Goodier, section 109, table 6: J over long short^3, and T over tau long short^2."""
    found = numbers_of(fm.RectangleSection(height=ratio, width=1.0))
    assert found.torsion / ratio == pytest.approx(constant, rel=3e-3)  # three printed digits
    assert found.torsion_modulus / ratio == pytest.approx(modulus, rel=3e-3)


@pytest.mark.parametrize(("height", "width"), [(7e-3, 7e-3), (14e-3, 7e-3), (4e-3, 12e-3)])
def test_a_rectangle_is_the_same_by_its_series_and_by_finite_elements(height, width):
    """Elements of the second degree, of a twelfth of the shorter side: the energy converges at order 4."""
    series = numbers_of(fm.RectangleSection(height=height, width=width))
    found = polygon(rectangle(height, width))
    assert found.torsion == pytest.approx(series.torsion, rel=1e-4)
    assert found.torsion_modulus == pytest.approx(series.torsion_modulus, rel=1e-2)  # stress at vertices: order 2
    assert found.area == pytest.approx(series.area, rel=1e-12)
    assert found.inertia == pytest.approx(series.inertia, rel=1e-12)
    assert found.turn == 0
    assert np.abs(found.shear_centre).max() < 1e-6 * height


def test_an_ellipse_has_its_closed_form():
    """J = pi a^3 b^3/(a^2 + b^2), and the steepest stress is at the ends of the short axis: W = pi a b^2/2."""
    a, b = 5e-3, 3e-3
    found = polygon(ellipse(a, b))
    assert found.torsion == pytest.approx(np.pi * a**3 * b**3 / (a * a + b * b), rel=3e-4)  # a polygon of 240 corners
    assert found.torsion_modulus == pytest.approx(np.pi * a * b**2 / 2, rel=1e-2)


def test_a_triangle_has_its_closed_form():
    """An equilateral triangle of side 1: J = sqrt(3)/80, W = 1/20 (Timoshenko and Goodier, section 106)."""
    found = polygon(((0, 0), (1, 0), (0.5, 0.75**0.5)))
    assert found.torsion == pytest.approx(3**0.5 / 80, rel=1e-4)
    assert found.torsion_modulus == pytest.approx(1 / 20, rel=1e-2)
    assert np.abs(found.shear_centre).max() < 1e-4


def test_a_round_and_a_tube_are_the_same_by_closed_form_and_by_finite_elements():
    outer, inner = ellipse(6e-3, 6e-3), ellipse(4e-3, 4e-3)
    for section, found in (
        (fm.RoundSection(diameter=12e-3), polygon(outer)),
        (fm.TubeSection(diameter=12e-3, thickness=2e-3), polygon(outer, (inner,))),
    ):
        exact = numbers_of(section)
        assert found.torsion == pytest.approx(exact.torsion, rel=3e-4)  # a polygon of 240 corners
        assert found.inertia == pytest.approx(exact.inertia, rel=3e-4)
        assert found.area == pytest.approx(exact.area, rel=1e-9)
    assert numbers_of(fm.RoundSection(diameter=12e-3)).torsion == pytest.approx(np.pi * 12e-3**4 / 32, rel=1e-12)


def channel(height, width, wall):
    """Give a channel by its centrelines: the web along `up`, the flanges across it, away from the origin."""
    h, b, t = height / 2, width, wall / 2
    return (
        (-h - t, -t), (-h - t, b), (-h + t, b), (-h + t, t), (h - t, t), (h - t, b), (h + t, b), (h + t, -t),
    )  # fmt: skip


def test_the_shear_centre_of_a_channel_is_behind_its_web():
    """Gere, section 6.9: e = 3 b^2 t/(h t + 6 b t) from the middle of the web, for thin walls."""
    height, width, wall = 60e-3, 30e-3, 1e-3
    found = polygon(channel(height, width, wall))
    centroid = width**2 / (height + 2 * width)  # from the web, of thin walls
    behind = 3 * width**2 / (height + 6 * width)
    off = np.abs(found.shear_centre)  # the channel is symmetric about the second direction
    assert off.min() < 1e-3 * off.max()
    assert off.max() == pytest.approx(centroid + behind, rel=1e-2)  # walls of a thirtieth of the flange
    # corners of the outline are added twice in sum b t^3/3, their effect is t/b
    assert found.torsion == pytest.approx((height + 2 * width) * wall**3 / 3, rel=2e-2)
    assert found.torsion_modulus is None  # stress in a sharp notch has no bound


def angle_section(along, across, wall):
    """Give an angle: legs along `up` and across it, from their outer corner."""
    return ((0, 0), (along, 0), (along, wall), (wall, wall), (wall, across), (0, across))


def test_an_angle_has_the_principal_axes_of_its_two_rectangles():
    """Gere, section 12.8: tan 2 theta = -2 I_xy/(I_x - I_y)."""
    along, across, wall = 50e-3, 30e-3, 4e-3
    parts = [(along, wall, along / 2, wall / 2), (wall, across - wall, wall / 2, (across + wall) / 2)]
    area = sum(a * b for a, b, _, _ in parts)
    y0, z0 = (sum(a * b * c[k] for a, b, *c in parts) / area for k in (0, 1))
    yy = sum(a**3 * b / 12 + a * b * (y - y0) ** 2 for a, b, y, z in parts)
    zz = sum(a * b**3 / 12 + a * b * (z - z0) ** 2 for a, b, y, z in parts)
    yz = sum(a * b * (y - y0) * (z - z0) for a, b, y, z in parts)
    values, vectors = np.linalg.eigh([[yy, yz], [yz, zz]])
    found = polygon(angle_section(along, across, wall))
    assert found.inertia == pytest.approx(tuple(values[::-1]), rel=1e-9)
    assert abs(np.tan(found.turn)) == pytest.approx(abs(vectors[1, 1] / vectors[0, 1]), rel=1e-9)
    assert np.sign(np.tan(found.turn)) == np.sign(vectors[1, 1] / vectors[0, 1])
    # the shear centre of thin legs is where they meet: half a wall from the outer corner
    turned = np.array([[np.cos(found.turn), np.sin(found.turn)], [-np.sin(found.turn), np.cos(found.turn)]])
    meeting = turned @ np.array([wall / 2 - y0, wall / 2 - z0])
    assert np.linalg.norm(np.array(found.shear_centre) - meeting) < 0.3 * wall
    assert np.linalg.norm(meeting) > 3 * wall
    # the principal axes see no product of inertia of the outline's corners: the heel is the farthest from one axis
    assert found.corners.shape == (6, 2)


SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))


@pytest.mark.parametrize(
    ("outline", "holes", "what"),
    [
        (((0, 0), (1, 0), (2, 0)), (), "no area"),
        (((0, 0), (1, 1), (2, 2)), (), "no area"),
        (((0, 0), (1, 1), (1, 0), (0, 2)), (), "meet or cross"),
        (((0, 0), (1, 0), (1, 0), (1, 1), (0, 1)), (), "meet or cross"),
        (((0, 0), (1, 0), (2, 0), (1, 0), (1, 1), (0, 1)), (), "meet or cross"),
        (SQUARE, (SQUARE,), "meet or cross"),
        (SQUARE, (((0.5, 0.5), (1.5, 0.5), (0.5, 0.7)),), "meet or cross"),
        (SQUARE, (((2, 0.2), (3, 0.2), (3, 0.4)),), "outside"),
        (SQUARE, (((-2, 0.2), (-3, 0.2), (-3, 0.4)),), "outside"),
    ],
)
def test_corners_that_make_no_polygon_are_told(outline, holes, what):
    """The mesh generator goes on for ever at some, or meshes what is meant by nobody."""
    with pytest.raises(SceneError, match=what):
        polygon(outline, holes)


def test_corners_may_lie_on_a_side_and_go_round_either_way():
    exact = polygon(SQUARE)
    for outline in (SQUARE[::-1], ((0, 0), (0.3, 0), (1, 0), (1, 1), (0, 1))):
        assert polygon(outline).torsion == pytest.approx(exact.torsion, rel=1e-4)


def test_a_very_thin_strip_has_its_closed_form():
    """J = b t^3 (1/3 - 0.21 t/b), of a thousand thicknesses; the mesh has few elements across it."""
    found = polygon(rectangle(1e-2, 1e-5))
    assert found.torsion == pytest.approx(1e-2 * 1e-15 * (1 / 3 - 0.21e-3), rel=1e-4)
