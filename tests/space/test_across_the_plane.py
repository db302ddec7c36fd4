"""Planar machines across their plane: stated in space they are the same, and they may buckle sideways."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.effects.known import COUPLING, EXACT_STRAINS
from fenics_mech.machine.lifted import lifted
from tests.common import DEMOS

E_STEEL, G_STEEL, LENGTH = 210e9, 210e9 / 2.6, 0.5


@pytest.mark.parametrize("name", ["slider_crank", pytest.param("watt", marks=pytest.mark.long)])
def test_a_planar_machine_in_space_gives_the_same(name):
    """Both are the equation of poses. At pins the plane has a moment of 1e-6, which is left of its bow."""
    exact = {"effects": (COUPLING, EXACT_STRAINS, "rotary-inertia"), "tolerance": None, "mesh.elements": 4}
    own = {"analysis.error_estimates": False}
    planar = fm.load(DEMOS / f"{name}.toml").changed(
        exact | own | {"analysis.sub_intervals": 60, "analysis.allow_coarse": True, "analysis.stations": 5}
    )
    spatial = lifted(planar).changed(own | {"analysis.stations": 5})  # at the nodes: axes bow between them
    plane, space = fm.analyse(planar).data, fm.analyse(spatial).data
    torque = plane["input_torque"].values.ravel()
    assert np.abs(space["input_torque"].values[:, 0] - torque).max() < 1e-7 * np.abs(torque).max()
    for member in plane["member"].values:
        moment = plane["moment"].sel(member=member).values
        found = space["section_moment"].sel(member=member).values
        assert np.abs(found[..., 2] - moment).max() < 2e-6 * np.abs(moment).max()
        assert np.abs(found[..., :2]).max() < 1e-9 * np.abs(moment).max()  # neither torsion, nor bending across


def cantilever(force: float) -> fm.Scene:
    """Give a thin upright strip that a force at its tip bends in the plane."""
    return fm.Scene(
        materials={"steel": fm.Material(modulus=E_STEEL, density=7850, poisson=0.3)},
        sections={"strip": fm.RectangleSection(width="1 mm", height="40 mm")},
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "arm": fm.Link(
                points={"O": (0, 0), "A": (LENGTH, 0)},
                members={"OA": fm.Member(ends=("O", "A"), section="strip", material="steel")},
            )
        },
        joints={"O": fm.Weld(connect=("ground.O", "arm.O"))},
        loads={"tip": fm.Load(at="arm.A", force=(0, -force))},
        mesh=fm.Mesh(elements=4),
        analysis=fm.Analysis(method="static", out_of_plane=True),
    )


def test_a_strip_buckles_sideways_at_the_load_of_michell_and_prandtl():
    """F = 4.013 sqrt(E I G J)/L^2 (Timoshenko and Gere, section 6.2). The strip is 1600 times as stiff in its plane."""
    height, width = 0.04, 0.001
    across, torsion = height * width**3 / 12, height * width**3 / 3 * (1 - 0.63025 * width / height)
    critical = 4.0126 * np.sqrt(E_STEEL * across * G_STEEL * torsion) / LENGTH**2
    below = fm.analyse(cantilever(0.997 * critical)).data["frequency_across"].values[0]
    alone = fm.analyse(cantilever(1e-3 * critical)).data["frequency_across"].values[0]
    assert below[0] < 0.2 * alone[0]
    with pytest.raises(fm.UnstableError if hasattr(fm, "UnstableError") else fm.SolverError, match="across its plane"):
        fm.analyse(cantilever(1.004 * critical))


def test_frequencies_across_the_plane_are_those_of_a_clamped_strip():
    """First bending across: 3.516 sqrt(E I/(rho A))/(2 pi L^2)."""
    found = fm.analyse(cantilever(1e-6)).data["frequency_across"].values[0, 0]
    exact = 3.5160 * np.sqrt(E_STEEL * 0.001**2 / 12 / 7850) / LENGTH**2 / (2 * np.pi)
    assert found == pytest.approx(exact, rel=2e-4)


def test_a_section_of_unknown_width_is_refused():
    with pytest.raises(fm.SceneError, match="no known width across the plane"):
        fm.analyse(fm.load(DEMOS / "four_bar.toml").changed({"analysis.out_of_plane": True}))


def test_the_summary_tells_frequencies_across_the_plane_beside_the_others():
    result = fm.analyse(cantilever(1e-6))
    across = result.data["frequency_across"].values[0]
    line = next(text for text in str(fm.summary(result)).splitlines() if text.startswith("across"))
    assert line.split()[1].startswith(f"{across[0]:.3g}"[:4])
    assert "Hz across the plane" in str(fm.summary(result))
    assert "Hz across the plane" in str(fm.summary(result, details=True))
    assert "Nothing is computed across" not in str(fm.summary(result))
