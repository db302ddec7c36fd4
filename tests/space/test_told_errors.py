"""Estimated errors over true ones, which answers with 4 times as many elements and steps give.

The mesh's estimate takes order 2, and where all members bend smoothly the order is 4: then it is 1.25 times the error.
"""

import numpy as np
import pytest

import fenics_mech as fm
from tests.common import DEMOS
from tests.space.machines import ORIGIN, RSSR_A, RSSR_Q, X, Y, Z, bar, rssr, rssr_ball, scene
from tests.space.test_kinematics import bennett_scene
from tests.space.test_planar_machines import four_bar, slider_crank

QUANTITIES = {"strain": "strain", "deflection": "deflection", "joint_force": "joint_force", "torque": "input_torque"}
SIZES = {"crank": (10e-3, 8e-3), "coupler": (6e-3, 3.5e-3), "rocker": (7e-3, 4e-3)}
ROUNDING = 1e-8  # of the largest value


def elastic_rssr(speed, **keys):
    B = rssr_ball(0.0)
    links = {
        "crank": bar(ORIGIN, RSSR_A, Z, "OA", section="crank", material="aluminium"),
        "coupler": bar(RSSR_A, B, Z, "AB", section="coupler", material="aluminium"),
        "rocker": bar(RSSR_Q, B, Y, "QB", section="rocker", material="aluminium"),
    }
    return rssr(
        links,
        sections={name: {"shape": "rectangle", "height": h, "width": w} for name, (h, w) in SIZES.items()},
        drive={"joint": "O", "speed": speed},
        gravity=(0, 0, -9.81),
        damping={"material": 5e-4},
        **keys,
    )


def bow():
    """A bent bar with three straight parts, loaded at its end until it turns by 0.2 rad."""
    ends = {"AB": Z, "BC": Z, "CD": X}
    members = {e: {"ends": tuple(e), "section": "bar", "material": "steel", "up": up} for e, up in ends.items()}
    points = {"A": ORIGIN, "B": (0.2, 0, 0), "C": (0.2, 0.2, 0), "D": (0.2, 0.2, -0.15)}
    return scene(
        {"bow": {"points": points, "members": members}},
        {"foot": {"connect": ("ground.O", "bow.A"), "kind": "weld"}},
        ground={"points": {"O": ORIGIN}},
        sections={"bar": {"shape": "rectangle", "height": 4e-3, "width": 3e-3}},
        loads={"tip": {"at": "bow.D", "force": (3.0, 5.0, -8.0)}},
        analysis={"method": "static"},
    )


def leaning_bennett():
    swing = {"joint": "J0", "law": {"kind": "harmonics", "sine": [0.4]}, "period": 1.0}
    return bennett_scene(bar, 0.5, drive=swing, damping={"material": 1e-3}, analysis={"positions": 60})


MACHINES = {
    "bow": bow,
    "slow rssr": lambda: elastic_rssr(20.0, analysis={"method": "quasi-static", "positions": 36}),
    "rssr": lambda: elastic_rssr(60.0),
    "fast rssr": lambda: elastic_rssr(85.0),
    "misaligned four-bar": lambda: fm.load(DEMOS / "space" / "misaligned_four_bar.toml"),
    "four-bar": lambda: four_bar(20.0, 60),
    "slider-crank": lambda: slider_crank(60.0, 60),
    "bennett": leaning_bennett,
}
QUICK = {"bow": (), "slow rssr": pytest.mark.long}


@pytest.mark.parametrize("name", [pytest.param(name, marks=QUICK.get(name, pytest.mark.long)) for name in MACHINES])
def test_told_errors_are_near_the_true_ones(name):
    """Each source by itself, and all together: told over true is 0.78 to 1.70 here."""
    made = MACHINES[name]().changed({"analysis.error_estimates": False, "analysis.modes": 0, "analysis.multipliers": 0})
    told = fm.analyse(made.changed({"analysis.error_estimates": True})).data
    fine = {"mesh": {"mesh.elements": 4 * made.mesh.elements}}
    if made.analysis.method == "periodic":
        fine["time"] = {"analysis.positions": 4 * made.analysis.positions}
    fine["all"] = {key: value for changes in fine.values() for key, value in changes.items()}
    assert list(told["source"].values) == list(fine)[:-1]
    true = {source: fm.analyse(made.changed(changes)).data for source, changes in fine.items()}
    for what, variable in QUANTITIES.items():
        if variable not in told:
            continue
        found = np.asarray(told[variable])
        for source, data in true.items():
            every = data.sizes["theta"] // told.sizes["theta"]
            off = np.abs(np.asarray(data[variable])[::every] - found).max() / np.abs(found).max()
            estimates = told[f"{what}_relative_error"]
            estimate = float(estimates.sum() if source == "all" else estimates.sel(source=source))
            if max(estimate, off) > ROUNDING:
                assert 0.75 < estimate / off < 3, (what, source, estimate, off)
