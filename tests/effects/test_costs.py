"""Nothing for nothing: an effect that is off is neither compiled nor assembled nor evaluated."""

import pytest

from fenics_mech.analysis import analyse
from fenics_mech.errors import SceneError
from fenics_mech.studies.effect_costs import added_one_by_one, largest_difference

EFFECTS = {"coupling": 1, "geometric-stiffness": 3, "large-rotations": 3}  # forms beside stiffness and mass


@pytest.mark.long
@pytest.mark.slow
def test_effects_added_one_by_one_come_nearer_to_all_of_them(seed):
    quick = {"analysis__sub_intervals": 120, "analysis__stability": False}
    runs = added_one_by_one(seed.changed(damping__material=1.339e-4, damping__ratio=0.0, **quick))
    assert [run.name for run in runs] == [
        "quasi-static",
        "vibration",
        "coupling",
        "geometric-stiffness",
        "large-rotations",
    ]
    off = [run.difference for run in runs]
    # linear theory is about a peak off, geometric stiffness brings most of what von Karman strains bring
    assert off[2] > 0.8
    assert 0.1 < off[3] < 0.4
    assert off[4] == 0


@pytest.mark.parametrize("method", ["transient", "static", "quasi-static"])
def test_other_than_periodic_responses_are_not_compared(seed, method):
    with pytest.raises(SceneError, match=f"analysis.method: --compare needs .* the method is {method}"):
        added_one_by_one(seed.changed(analysis__method=method))


def test_a_slow_machine_moves_as_without_vibration(seed):
    slow = seed.changed(drive__speed=0.5, analysis__sub_intervals=60, analysis__stability=False, effects="auto")
    vibrating, still = (analyse(slow.changed(analysis__method=method)) for method in ("periodic", "quasi-static"))
    assert largest_difference(vibrating, still) < 0.01
