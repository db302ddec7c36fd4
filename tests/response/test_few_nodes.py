"""Estimates found with few nodes, against those with all of them."""

import pytest

from fenics_mech import Mesh, SolverError, analyse, load
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS

PULSE = {"kind": "pulse", "start": 1.0, "end": 2.0}
NEED_ALL = {
    "few elements": {"mesh": {"elements": 24}},
    "impulses": {"impulses": {"blow": {"at": "coupler.B", "angle": 1.0, "impulse": (0.0, 0.002)}}},
    "jumps": {"loads": {"jump": {"at": "coupler.B", "force": (5.0, -3.0), "factor": PULSE}}},
}


def fine(**more):
    stated = {
        "mesh": {"elements": 30},
        "damping": {"material": 1e-4},
        "effects": ("coupling",),
        "analysis": {"sub_intervals": 48, "stations": 5, "allow_coarse": True},
    }
    return seed_four_bar(**(stated | more))


def plain():
    """The same by sub-intervals."""
    analysis = {"sub_intervals": 120, "stations": 5, "modes": 3, "allow_coarse": True}
    return fine(effects=(), damping={"ratio": 0.02}, analysis=analysis)


@pytest.mark.slow
def test_stability_is_that_of_all_nodes():
    """At the edge of a resonance of mode 6 a multiplier of 12 elements is 0.98, and that of 40 is 1.01."""
    scene = load(DEMOS / "pulsating_column.toml")
    loads = {"pulse": (0.0, -195.0), "dead": (0.0, 146.25)}
    forces = {name: scene.loads[name].model_copy(update={"force": force}) for name, force in loads.items()}
    scene = scene.changed(
        loads=scene.loads | forces, mesh=Mesh(elements=40), drive__speed=8490.0, damping__relative=40.0
    )
    with pytest.raises(SolverError, match="unstable"):
        analyse(scene.changed(analysis__sub_intervals=40, analysis__allow_unstable=False))
