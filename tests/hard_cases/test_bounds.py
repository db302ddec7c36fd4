"""Every iteration ends in time: with an answer, or with one error that says where it stopped and what to do."""

import time
import tomllib
import weakref

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech._petsc import PETSc, configured
from fenics_mech.errors import AssemblyError, SceneError, SolverError
from fenics_mech.machine import led_from_scene
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene, load
from tests.common import DEMOS


class Raising:
    """A step of TS that raises."""

    def step(self, ts):
        raise SolverError(f"no step at {ts.getTime()}")


def test_an_error_in_a_callback_leaves_nothing_to_the_end_of_petsc():
    """Else the error holds the solver, PETSc destroys it after Python's end, and the process ends by a signal."""
    ts, steps = PETSc.TS().create(comm=PETSc.COMM_SELF), Raising()
    ts.setType("python")
    ts.setPythonContext(steps)
    ts.setSolution(PETSc.Vec().createSeq(1))
    ts.setMaxTime(1.0)
    held = weakref.ref(steps)
    del steps
    with pytest.raises(SolverError, match="no step at 0") as error, configured(ts, "transient_", {}, {}):
        ts.solve(ts.getSolution())
    assert error.value.__traceback__ is not None  # the error lives on, and with it its frames
    assert held() is None


def in_time(**changes):
    return load(DEMOS / "four_bar.toml").changed(analysis__method="transient", effects=("coupling",), **changes)


@pytest.mark.parametrize("tolerance", [1e-300, 1e-16, 9e-13])
def test_a_tolerance_below_rounding_is_refused(tolerance):
    with pytest.raises(SceneError, match="time_tolerance: must be at least 1e-12"):
        in_time(analysis__time_tolerance=tolerance)


@pytest.mark.parametrize("cycles", [10**9, 10**400])
def test_more_cycles_than_memory_holds_are_refused(cycles):
    with pytest.raises(
        SceneError, match=r"analysis.cycles: \d+(\.\.\.\d+)? positions are more than a result holds, 100000"
    ):
        analyse(in_time(analysis__cycles=cycles))


def manipulator(**masses):
    """Quasi-static with large rotations at 48 positions, under a load of another mass."""
    data = tomllib.loads((DEMOS / "manipulator.toml").read_text())
    data["analysis"] = {"method": "quasi-static", "sub_intervals": 48}
    for name, mass in masses.items():
        data["masses"][name]["mass"] = mass
    return data | {"effects": ["large-rotations"]}


def test_far_beyond_buckling_the_member_and_the_angle_are_named():
    """1e9 kg: without a bound, load steps and the search for a tension below buckling took minutes."""
    start = time.process_time()
    with pytest.raises(SolverError, match=r"link \w+ buckles: .* at drive angle"):
        analyse(Scene.read(manipulator(load=1e9) | {"mesh": {"elements": 2}}))
    assert time.process_time() - start < 30  # measured: 2


def test_a_spring_that_makes_the_straight_mechanism_unstable_bends_it():
    """Pressed together from 10 m, it turns the forearm by 1.2 rad to where it is in equilibrium."""
    spring = {"between": ["ground.S", "forearm.T"], "stiffness": 100.0, "length": 10.0}
    data = analyse(Scene.read(manipulator() | {"springs": {"s": spring}})).data
    assert float(data["rotation"].max()) > 1.0
    assert float(data["relative_error"].max()) < 0.01


def test_a_law_that_changes_too_often_is_refused(monkeypatch):
    monkeypatch.setattr(led_from_scene, "MOST", 200)  # of 10,000, which take a minute
    data = tomllib.loads((DEMOS / "manipulator.toml").read_text())
    data["drive"][0]["law"] = {"kind": "expression", "formula": "0.5*sin(100*theta)"}
    with pytest.raises(AssemblyError, match=r"after 200 steps the drive is at .* link upper_arm turns fastest"):
        solve_motion(Scene.read(data), np.linspace(0, 6, 5))
