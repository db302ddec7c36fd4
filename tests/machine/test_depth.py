"""How many functions, and how deep, lead from a scene to its periodic motion."""

import os
import sys

import fenics_mech as fm
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import periodic, rigid_cycle
from tests.common import DEMOS

ROOT = os.path.dirname(fm.__file__)


def test_a_four_bar_takes_few_functions_and_few_levels():
    """217 functions and 14 levels, the forms of members included; those without a name, as comprehensions, not counted.

    By link frames, with results and errors, they are about 800 and 36.
    """
    scene = fm.load(DEMOS / "four_bar.toml").changed({"effects": ("coupling", "large-rotations")})
    seen, depth, deepest = set(), 0, 0

    def cycle():
        made = machine_of(scene)
        made.machine.chart = rigid_cycle(made.machine, scene.period)
        return periodic(made.machine, scene.period, 24)

    def look(frame, event, _):
        nonlocal depth, deepest
        code = frame.f_code
        if not code.co_filename.startswith(ROOT):
            return
        if event == "call":
            depth += 1
            deepest = max(deepest, depth)
            if not code.co_name.startswith("<"):
                seen.add((code.co_filename, code.co_qualname))
        elif event == "return":
            depth -= 1

    cycle()  # forms are compiled
    sys.setprofile(look)
    try:
        found = cycle()
    finally:
        sys.setprofile(None)
    assert found.iterations < 10
    assert 150 < len(seen) <= 250
    assert 8 < deepest <= 15
