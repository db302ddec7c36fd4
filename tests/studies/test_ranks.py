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


def test_what_one_process_finds_wrong_is_raised_by_all_and_may_be_caught(tmp_path):
    ended = on_two(
        tmp_path,
        """
import numpy as np
from mpi4py import MPI
from fenics_mech._ranks import over_positions, shared
from fenics_mech.errors import SceneError
rank = MPI.COMM_WORLD.rank

def broken(among):
    if rank == 1:
        raise SceneError("bad", place="links", hint="Mend it")
    return (np.zeros(among.stop - among.start),)

def analysis():
    try:
        over_positions(5, broken)
    except SceneError as error:
        assert (error.place, error.hint) == ("links", "Mend it")
    else:
        raise AssertionError
    return over_positions(5, lambda among: (np.arange(10.0).reshape(5, 2)[among], np.full(5, rank)[among]))

numbers, ranks = shared(analysis)
assert np.array_equal(numbers, np.arange(10.0).reshape(5, 2))
assert ranks.tolist() == [0, 0, 1, 1, 1]
if rank == 0:  # not shared: nobody waits
    assert over_positions(5, lambda among: (np.arange(5.0)[among],))[0].tolist() == [0, 1, 2, 3, 4]
print("done")
""",
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.count("done") == 2


@pytest.mark.slow
def test_a_scene_that_is_wrong_is_one_message(tmp_path):
    (tmp_path / "bad.toml").write_text("nothing = 1")
    arguments = ("-m", "fenics_mech", "run", tmp_path / "bad.toml", "-o", tmp_path / "out")
    ended = finished(*arguments, ranks=2)
    assert ended.returncode == 1
    assert ended.stderr.count("error:") == 1
