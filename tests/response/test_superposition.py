"""Superposition of modes in time against all coordinates, a closed form, and what it refuses."""

import numpy as np
import pytest

import fenics_mech as fm
from tests.common import DEMOS

IN_TIME = {"method": "transient", "cycles": 1, "settled": 0.0, "sub_intervals": 360, "error_estimates": False}


def seed(**analysis) -> fm.Scene:
    scene = fm.load(DEMOS / "four_bar.toml").changed({"effects": (), "tolerance": None})
    return scene.changed({f"analysis.{key}": value for key, value in (IN_TIME | analysis).items()})


def strains(data) -> np.ndarray:
    """Strain of the + fibre at mid-span, ``(times, members)``."""
    return data["strain"].sel(s=0.5, fibre="+").transpose("theta", "member").to_numpy()


def test_modes_in_time_tell_of_the_modes_left_out_and_not_of_the_mesh():
    modal = fm.analyse(seed(solver="sub-intervals", modes=3, error_estimates=True, allow_coarse=True)).data
    assert modal.attrs["solver"] == "sub-intervals"
    assert 0.01 < modal.attrs["error_estimate"] < 0.3
    assert "mesh" in modal.attrs["not_estimated"]


@pytest.mark.slow
def test_modes_in_time_settle_to_the_periodic_response():
    periodic = strains(fm.analyse(seed(method="periodic", solver="sub-intervals", modes=3)).data)
    last = fm.analyse(seed(solver="sub-intervals", modes=3, cycles=12)).data.isel(theta=slice(-361, -1))
    np.testing.assert_allclose(strains(last), periodic, atol=2e-3 * np.abs(periodic).max())


def test_modes_in_time_start_from_rest_as_one_oscillator_does():
    # a bar on a drive that hardly moves; the force at its end is there at once: y = (p/w^2) (1 - cos w t)
    bar = fm.Member(ends=("O", "A"), section="bar", material="steel")
    scene = fm.Scene(
        name="strip",
        materials={"steel": fm.Material(modulus=2e11, density=7850)},
        sections={"bar": fm.RectangleSection(width="20 mm", height="5 mm")},
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"bar": fm.Link(points={"O": (0, 0), "A": (1.0, 0)}, members={"bar": bar})},
        joints={"O": fm.Revolute(connect=("ground.O", "bar.O"))},
        drive=fm.Drive(joint="O", law=fm.Harmonics(mean=0.0, cosine=(1e-6,)), period=0.5),
        loads={"pull": fm.Load(at="bar.A", force=(0, 1.0))},
        mesh=fm.Mesh(elements=3),
        analysis=fm.Analysis(solver="sub-intervals", modes=1, static_correction=False, **IN_TIME),
    )
    data = fm.analyse(scene).data
    stiffness, line, root = 2e11 * 0.02 * 0.005**3 / 12, 0.785, 1.8751040687
    omega = root**2 * np.sqrt(stiffness / line)
    tip = 4 / line / omega**2  # the first mode of a cantilever has 2 at its end, normalised by its mass
    moved = data["deflection"].isel(s=-1).sel(member="bar", component="y")
    expected = tip * (1 - np.cos(omega * data["time"].to_numpy()))
    np.testing.assert_allclose(moved, expected, atol=2e-3 * tip)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"effects": ("coupling",)}, fm.SceneError, "effects: .* write solver = .poses."),
        ({"analysis.sub_intervals": 36, "analysis.modes": 9}, fm.UnresolvedError, "too fast for these sub_intervals"),
        ({"analysis.sub_intervals": 4, "analysis.modes": 2}, fm.UnresolvedError, "vibrating. Take at least"),
        (
            {"joint_laws": {"b": {"kind": "joint-effort", "joint": "C", "effort": 0.0}}},
            fm.SceneError,
            "joint_laws: .* write solver = .poses.",
        ),
    ],
)
def test_what_modes_in_time_do_not_know_is_refused(changes, error, message):
    with pytest.raises(error, match=message):
        fm.analyse(seed(solver="sub-intervals").changed(changes))
