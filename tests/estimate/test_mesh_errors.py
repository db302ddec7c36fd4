"""Told over true errors by the mesh where its first order does not tell them, against meshes that are fine enough.

References differ by the mesh alone.
"""

import numpy as np
import pytest

from fenics_mech import analyse, load
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.meshing import with_elements
from tests.common import DEMOS, ROOT, response_of, too_coarse

EVERY = ("theta", "s", "fibre")
ANALYSIS = {"solver": "collocation", "sub_intervals": 120, "allow_coarse": True, "stability": False}
STRIP = ROOT / "tests" / "cases" / "scenes" / "rotating_strip.toml"


def told_over_true(scene, fine):
    """Told over true error of the strain by the mesh, by the largest of both, and the true one of the largest strain.

    The reference has so many elements in each member.
    """
    found, exact = analyse(scene).data, response_of(with_elements(scene, fine)).data
    true, size = np.abs(found["strain"] - exact["strain"]).max(EVERY), np.abs(found["strain"]).max(EVERY)
    told = found["strain_error"].sel(source="mesh")
    return float((told / size.max()).max() / (true / size.max()).max()), float((true / size.max()).max())


def four_bar(speed, damping, elements, **rest):
    scene = seed_four_bar(effects=("coupling",), damping={"ratio": damping}, analysis=ANALYSIS, **rest)
    return scene.changed(drive__speed=speed, mesh__elements=elements)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "damping", "elements"),
    [(14.5, 0.0, 2), (16.15, 0.0, 2), (16.15, 0.0, 1), (22.6, 0.002, 2), (32.3, 0.01, 1), (45.2, 0.0, 3)],
)
def test_mesh_that_moves_a_resonance(speed, damping, elements):
    """Measured 1.0 to 1.2. The largest that shares of the first order might be was 5, 544, 12, 3.2, 1.6 and 30."""
    told, true = told_over_true(four_bar(speed, damping, elements), 8)
    assert true > 1e-3
    assert (0.6 if (speed, elements) == (16.15, 1) else 0.8) < told < 1.6  # halves of one element are far off, too


@pytest.mark.parametrize(("damping", "elements"), [(0.0, 1), (0.0, 3), (0.01, 1)])
def test_modes_that_the_mesh_has_far_off_and_no_harmonic_meets(damping, elements):
    """Measured 0.78 to 1.3. By the bound of the vibration that harmonics might excite there it was 1213, 21634, 1.1."""
    scene = load(DEMOS / "slider_crank.toml").changed(
        effects=("coupling",), drive__speed=84.0, damping={"ratio": damping}, analysis=ANALYSIS
    )
    told, true = told_over_true(with_elements(scene, elements), 4 * elements + 4)
    assert true > 5e-5
    assert 0.75 < told < 1.6  # halved elements lack a fourth of the error


@pytest.mark.slow
def test_a_speed_that_a_sweep_left_out_has_an_answer():
    """28 % were told of eight elements; it is 1 %, and no answer is refused up to 5 %."""
    scene = load(STRIP).changed({"drive.speed": "250 rpm", "effects": ("coupling", "large-rotations")})
    assert float(analyse(scene).data["relative_error"].sel(source="mesh")) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("elements", [1, 2])
def test_a_large_vibration_under_a_law_that_is_not_linear(elements):
    """Measured 1.0 to 1.5 of every member: the law made 12 of a vibration as large as the motion itself."""
    scene = seed_four_bar(
        effects=("coupling", "large-rotations"),
        mesh={"elements": elements},
        damping={"ratio": 0.02},
        analysis=ANALYSIS | {"allow_large": True},
    )
    found, exact = analyse(scene).data, response_of(scene.changed(mesh__elements=6)).data
    true = np.abs(found["strain"] - exact["strain"]).max(EVERY)
    told = found["strain_error"].sel(source="mesh") / true
    assert (true / np.abs(found["strain"]).max(EVERY) > 0.02).all()
    assert (told > 0.8).all()
    assert (told < 2).all()


@pytest.mark.slow
def test_what_is_told_asks_for_elements_that_are_enough():
    """The number that it names lets the scene pass, and half of it does not."""
    scene = four_bar(14.5 * 1.9, 0.002, 2).changed(analysis__allow_coarse=False)
    times = float(too_coarse(scene).split("Take ")[1].split(" times as many elements")[0])
    assert not too_coarse(scene.changed(mesh__elements=int(np.ceil(2 * times))))
    assert times < 2.5
