"""A short, seeded slice of the long run of `fuzz`: no command ends with anything but an answer or an error of ours."""

import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from fenics_mech import analyse
from fenics_mech._guard import guarded
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.scene import parse
from tests.cases.fuzz import attempt, one

SCENES = 12  # of other damage than that of the long runs so far, which ended with no other error


@pytest.mark.slow
def test_damaged_scenes_end_no_command_with_a_traceback(tmp_path):
    for number in range(50_000, 50_000 + SCENES):
        for command, end in one(number, tmp_path):
            assert " " not in end, f"{command}\n{end}"


def test_a_traceback_is_seen(monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr("tests.cases.fuzz.app", broken)
    assert "by nothing" in attempt(["check"])


STRUCTURE = """
name = "a beam that is held at both ends"
ground.points = { L = [0, 0], R = ["1 m", 0] }
materials.steel = { modulus = "210 GPa", density = "7850 kg/m^3" }
sections.bar = { shape = "rectangle", width = "50 mm", height = "10 mm" }
joints.L.connect = ["ground.L", "beam.A"]
joints.R.connect = ["ground.R", "beam.B"]

[links.beam]
points = { A = [0, 0], B = ["1 m", 0] }
members.bar = { ends = ["A", "B"], section = "bar", material = "steel" }

[loads.P]
member = "beam"
line = [0, "-100 N/m"]

[analysis]
method = "transient"
"""


def test_a_motion_in_time_of_what_neither_is_driven_nor_moves_is_refused(tmp_path):
    """Found by the long run: it was an `IndexError`."""
    with pytest.raises(SceneError, match="a motion that nothing drives needs its duration"):
        analyse(parse(STRUCTURE))


def test_a_singular_factor_is_an_error_of_ours():
    """Found by the long run: SuperLU raises a plain `RuntimeError`."""
    with pytest.raises(SolverError, match="cannot be solved with"), guarded():
        splu(sp.csc_matrix((3, 3)))
    with pytest.raises(RuntimeError, match="something else"), guarded():
        raise RuntimeError("something else")
