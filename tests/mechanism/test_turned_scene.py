"""A scene that is turned as a whole."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene.factories import seed_four_bar


@pytest.mark.parametrize("turn", [0.7, 2.5])
def test_turning_the_whole_scene_changes_no_frequency_and_no_strain(turn):
    plain = seed_four_bar(analysis={"sub_intervals": 24})
    c, s = np.cos(turn), np.sin(turn)
    data = plain.model_dump()
    # the ground turns; the drive angle is measured from the fixed x axis, so the start of the cycle moves with it
    x, y = data["ground"]["points"]["C"]
    data["ground"]["points"]["C"] = (c * x - s * y, s * x + c * y)
    for link in ("coupler", "follower"):
        data["links"][link]["angle"] += turn
    count = 24 * 5
    shift = turn / (2 * np.pi) * count
    reference = analyse(plain.changed(analysis={"sub_intervals": count, "method": "quasi-static"}))
    data["links"]["crank"]["points"] = {"O": (0, 0), "A": (0.10795 * np.cos(turn), 0.10795 * np.sin(turn))}
    turned = analyse(
        type(plain).model_validate(data).changed(analysis={"sub_intervals": count, "method": "quasi-static"})
    )
    assert shift  # the crank's own frame is turned back, so that drive angle 0 is the same position
    assert np.allclose(turned.strain_at("coupler"), reference.strain_at("coupler"), rtol=0, atol=1e-12)
