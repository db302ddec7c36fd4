"""How many functions, and how deep, lead from a scene to its periodic motion."""

import os
import sys

import fenics_mech as fm
from fenics_mech.beams.made_once import LastMade
from fenics_mech.machine import from_scene
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import periodic, rigid_cycle
from tests.common import DEMOS

ROOT = os.path.dirname(fm.__file__)


def counted(run):
    """Give the functions of the package that run, comprehensions and lambdas too, and their levels."""
    seen, depth, deepest = set(), 0, 0

    def look(frame, event, _):
        nonlocal depth, deepest
        if event not in {"call", "return"} or not frame.f_code.co_filename.startswith(ROOT):
            return
        depth += 1 if event == "call" else -1
        deepest = max(deepest, depth)
        seen.add((frame.f_code.co_filename, frame.f_code.co_qualname, frame.f_code.co_firstlineno))

    sys.setprofile(look)
    try:
        run()
    finally:
        sys.setprofile(None)
    return seen, deepest


def test_a_four_bar_takes_few_functions_and_few_levels(monkeypatch):
    """250 functions and 13 levels of a scene that was analysed before; 358 and 16 where its matrices are made anew.

    By link frames, with results and errors, they are about 1,700 and 37.
    """
    exact = {"effects": ("coupling", "large-rotations"), "damping": {"material": 1e-4}}
    scene = fm.load(DEMOS / "four_bar.toml").changed(exact)

    def cycle(positions=None):
        machine = machine_of(scene).machine
        machine.chart = rigid_cycle(machine, scene.period, positions)
        assert len(periodic(machine, scene.period, 12).changes) < 10

    cycle(16)  # forms are compiled, and matrices made
    functions, levels = counted(cycle)
    assert 150 < len(functions) <= 250
    assert 8 < levels <= 15
    monkeypatch.setattr(from_scene, "MADE", LastMade(1))
    more, levels = counted(lambda: machine_of(scene))
    assert len(functions) < len(functions | more) <= 360
    assert 8 < levels <= 16
