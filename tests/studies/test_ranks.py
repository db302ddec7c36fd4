"""An analysis that is shared by processes: the same to the last bit, one voice, and one error for all."""

import pytest

from fenics_mech.analysis import analyse
from fenics_mech.recovery import Result
from tests.studies.processes import MPIRUN, finished

pytestmark = pytest.mark.skipif(MPIRUN is None, reason="no mpirun")
NONLINEAR = """
from fenics_mech.scene.factories import seed_four_bar
SCENE = seed_four_bar(
    effects=("coupling", "large-rotations"), mesh__elements=2,
    analysis={"sub_intervals": 61, "allow_coarse": True, "stages": 2, "solver": "collocation"},
)
"""


def on_two(folder, script):
    """Run a script on two processes."""
    (folder / "script.py").write_text(script)
    return finished(folder / "script.py", ranks=2)


@pytest.mark.slow
def test_two_processes_find_the_same_to_the_last_bit(tmp_path):
    # 61 positions: the parts differ in size
    script = f"""
import sys
import fenics_mech.scene
from fenics_mech import cli
{NONLINEAR}
fenics_mech.scene.load = lambda path: SCENE
sys.argv = ["fenics-mech", "run", "any.toml", "--no-plots", "-o", {str(tmp_path / "out")!r}]
cli.main()
"""
    ended = on_two(tmp_path, script)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.count("Wrote result.nc") == 1
    found = Result.load(tmp_path / "out" / "result.nc")
    alone = Result.load(analyse(found.scene).save(tmp_path / "alone.nc"))
    assert found.data.identical(alone.data)


@pytest.mark.slow
def test_a_scene_that_is_wrong_is_one_message(tmp_path):
    (tmp_path / "bad.toml").write_text("nothing = 1")
    arguments = ("-m", "fenics_mech", "run", tmp_path / "bad.toml", "-o", tmp_path / "out")
    ended = finished(*arguments, ranks=2)
    assert ended.returncode == 1
    assert ended.stderr.count("error:") == 1
